"""Pictures to train the judge on: rendered clutter of many seeds, and real frames, turned, mirrored, blurred and relit."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import cv2
import numpy as np

from stereo_lab.common.spreadsheets import read_table
from stereo_lab.detection import HUES, BallColor
from stereo_lab.recording import open_recording, read_image
from stereo_lab.results.evaluation import color_of

MOST_OF_SET = 101  # pictures of one set; of longer ones every second or third
MARKED = 4  # pictures from which a colour is learned
RADII, TYPICAL = (5, 80), 14  # px: of balls made larger and smaller, and of things where there is no ball
KINDS = 8  # of each real frame: as it is, and changed
REAL = {"green_ball": "green", "orange_ball": "orange"}


class Picture(NamedTuple):
    """One picture, what is looked for in it, and where that is: (u, v, radius) or None."""

    source: str
    image: np.ndarray
    color: BallColor
    circle: tuple[float, float, float] | None


def rendered(folder: Path) -> Iterator[Picture]:
    """Every picture of a recording of clutter: by name, by a learned colour, even and flat, painted out, for another colour."""
    recording = open_recording(folder)
    rng = np.random.default_rng(recording.name.encode()[-1])
    for set_name in (name for name in recording.sets if name != "calibration"):
        name = color_of(recording, set_name)
        pairs = recording.pairs(set_name)
        shots = [
            (getattr(pair, side), (recording.true_ball(set_name, pair.name) or {}).get(side))
            for pair in pairs[:: 1 + len(pairs) // MOST_OF_SET]
            for side in ("left", "right")
            if side == "left" or pair.right_path
        ]
        yield from _seen(f"{recording.name}/{set_name}", shots, name, rng)


def real(folder: Path) -> Iterator[Picture]:
    """The real frames of a folder with labels.csv, each in several kinds."""
    rng = np.random.default_rng(7)
    rows = [row for _, row in read_table(folder / "labels.csv", ("file", "u", "v", "radius_px"))]
    shots = []
    for row in rows:
        circle = tuple(float(row[k]) for k in ("u", "v", "radius_px")) if row["u"] else None
        shots.append((read_image(folder / row["file"]), circle))
    for kind in range(KINDS):
        changed = [_changed(image, circle, rng) if kind else (image, circle) for image, circle in shots]
        yield from _seen(f"{folder.name} {kind}", changed, REAL[folder.name], rng)


def _seen(source, shots, name, rng):
    marked = [(image, circle) for image, circle in shots if circle is not None]
    chosen = [marked[k] for k in rng.choice(len(marked), min(MARKED, len(marked)), replace=False)]
    learned = BallColor.from_samples(*zip(*chosen, strict=True)) if chosen else None
    named = BallColor.named(name)
    others = [other for other in HUES if other != name]
    for k, (image, circle) in enumerate(shots):
        yield Picture(f"{source} named", image, named, circle)
        if learned is not None:
            yield Picture(f"{source} learned", image, learned, circle)
        is_real = source.split()[0] in REAL
        if circle is not None and (is_real or k % 2 == 0):
            yield Picture(f"{source} painted out", _painted_out(image, circle), named if k % 4 else learned, None)
        if circle is not None and k % 3 == 0:
            yield Picture(f"{source} even", _evened(image, circle), named, circle)
        if circle is not None and k % 4 == 1:
            yield Picture(f"{source} smeared", _smeared(image, circle, rng), named, circle)
        if not is_real:
            even = circle is not None and rng.random() < 0.5
            zoomed, place = _zoomed(_evened(image, circle) if even else image, circle, rng)
            yield Picture(f"{source} zoomed", zoomed, learned if k % 2 and learned else named, place)
        if k % 5 == 0 and not is_real:
            yield Picture(f"{source} another colour", image, BallColor.named(others[k % len(others)]), None)


def _painted_out(image, circle):
    """The ball gone: filled in from round it."""
    u, v, r = circle
    mask = np.zeros(image.shape[:2], np.uint8)
    cv2.circle(mask, (round(u), round(v)), round(1.25 * r) + 3, 255, -1)
    return cv2.inpaint(image, mask, 5, cv2.INPAINT_TELEA)


def _evened(image, circle):
    """The ball's shade nearly halved, as in light from all sides."""
    u, v, r = circle
    y, x = np.mgrid[: image.shape[0], : image.shape[1]]
    inside = np.clip(r - np.hypot(x - u, y - v), 0, 1)[..., None]
    core = np.hypot(x - u, y - v) < 0.8 * r
    if not core.any():
        return image
    mean = image[core].mean(0)
    bright = image.max(-1, keepdims=True).astype(float) / max(1.0, mean.max())
    flat = image / np.clip(bright, 0.25, 4) ** 0.4
    return np.clip(image * (1 - inside) + flat * inside, 0, 255).astype(np.uint8)


def _smeared(image, circle, rng):
    """Everything moved on while the shutter was open, by up to a ball's radius and a quarter; light is mixed, not bytes."""
    length, angle = max(1.5, rng.uniform(0.2, 1.25) * circle[2]), rng.uniform(0, np.pi)
    size = 2 * int(np.ceil(length / 2)) + 3
    kernel = np.zeros((size, size), np.float32)
    for step in np.linspace(-0.5, 0.5, 8 * size):
        x, y = (size // 2 + step * length * np.cos(angle), size // 2 + step * length * np.sin(angle))
        kernel[round(y), round(x)] += 1
    light = cv2.filter2D((image / 255.0) ** 2.2, -1, kernel / kernel.sum())
    return np.round(255 * np.clip(light, 0, 1) ** (1 / 2.2)).astype(np.uint8)


def _zoomed(image, circle, rng):
    """The picture with a ball of another size: made small; or a part of it made large and soft, as a cheap camera sees a
    ball near by, and compressed again. Relit.
    """
    height, width = image.shape[:2]
    factor = np.clip(np.exp(rng.uniform(*np.log(RADII))) / (circle[2] if circle else TYPICAL), 0.35, 6)
    if factor < 1:
        size = round(factor * width), round(factor * height)
        small = _relit(cv2.resize(image, size, interpolation=cv2.INTER_AREA), rng)
        return small, _moved(circle, np.array([[factor, 0, (factor - 1) / 2], [0, factor, (factor - 1) / 2]]))
    middle = np.array(circle[:2] if circle else (width / 2, height / 2))
    middle += rng.uniform(-0.35, 0.35, 2) * (width, height) / factor
    half = np.array([width, height]) / (2 * factor)
    middle = np.clip(middle, half, np.array([width, height]) - half)  # nothing beyond the rim, and so no ball twice
    matrix = np.array([[factor, 0, width / 2 - factor * middle[0]], [0, factor, height / 2 - factor * middle[1]]])
    large = cv2.warpAffine(image, matrix, (width, height), flags=cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE)
    soft = _relit(cv2.GaussianBlur(large, (0, 0), rng.uniform(0.3, 0.8 * factor)), rng)
    packed = cv2.imencode(".jpg", soft, [cv2.IMWRITE_JPEG_QUALITY, int(rng.integers(35, 95))])[1]
    return cv2.imdecode(packed, cv2.IMREAD_COLOR), _moved(circle, matrix)


def _relit(image, rng):
    light = (image / 255.0) ** rng.uniform(0.7, 1.5) * rng.uniform(0.6, 1.2) * (1 + rng.normal(0, 0.05, 3))
    return np.clip(255 * light + rng.normal(0, rng.uniform(0, 4), image.shape), 0, 255).astype(np.uint8)


def _moved(circle, matrix):
    if circle is None:
        return None
    u, v = matrix @ [circle[0], circle[1], 1]
    return float(u), float(v), float(circle[2] * np.sqrt(abs(np.linalg.det(matrix[:, :2]))))


def _changed(image, circle, rng):
    """Mirrored, turned, blurred and relit at random."""
    height, width = image.shape[:2]
    matrix = cv2.getRotationMatrix2D((width / 2, height / 2), rng.uniform(-25, 25), rng.uniform(0.7, 1.1))
    if rng.random() < 0.5:
        matrix = matrix @ np.array([[-1, 0, width - 1], [0, 1, 0], [0, 0, 1.0]])
    moved = cv2.warpAffine(image, matrix, (width, height), borderMode=cv2.BORDER_REPLICATE)
    return _relit(cv2.GaussianBlur(moved, (0, 0), rng.uniform(0.3, 1.6)), rng), _moved(circle, matrix)

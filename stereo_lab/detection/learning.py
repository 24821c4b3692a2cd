"""The colour of a ball: learned from pictures in which it is marked, or the most colourful that a picture has of its name."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import cv2
import numpy as np

from stereo_lab.detection.candidates import SURELY
from stereo_lab.detection.color import BINS, HUES, LAST_HUE, STEP, BallColor, bin_colors
from stereo_lab.detection.model import check_image
from stereo_lab.errors import StereoLabError

MARKS, LEAST_SURE = 6, 0.75  # balls that mark themselves, and how sure each must be
PRIOR = 0.1  # a ball covers a few hundredths of a picture; its rarer tints count as well
MOST_PIXELS, ROUNDS, RIDGE = 20_000, 12, 1.0
# Of the pixels of a colour's name: how colourful half of them are is not at all, what a tenth exceeds is fully the ball's
COLORFUL_PARTS = 0.5, 0.9
EVERY, FEW = 2, 20  # so manieth pixel is looked at; fewer of the colour tell nothing
MOST = "most colourful "  # stands before the colour's name


def surest(images: Sequence[np.ndarray], color: BallColor) -> tuple[tuple[int, float, float, float], ...]:
    """The surest balls of a named colour in some pictures: (number of the picture, u, v, radius_px), surest first.

    The surest of each sixth of the pictures, for the light may change from the first to the last; then the surest of all others.
    """
    from stereo_lab.detection.detector import BallDetector

    detector = BallDetector(color)
    best = [(k, ball) for k, image in enumerate(images) for ball in detector.candidates(image, 1)]
    best = sorted(((k, ball) for k, ball in best if ball.score >= LEAST_SURE), key=lambda found: -found[1].score)
    part = [k * MARKS // len(images) for k, _ in best]
    later = [p in part[:n] for n, p in enumerate(part)]
    sure = [best[n] for n in sorted(range(len(best)), key=later.__getitem__)[:MARKS]]
    if not sure:
        raise StereoLabError(
            f"In none of {len(images)} pictures a {color.name} ball is found, so none can mark itself. "
            "Mark the ball by hand in three or four of them: file, u, v and radius_px in a table, and --color-from."
        )
    return tuple((k, ball.u, ball.v, ball.radius_px) for k, ball in sure)


def most_colorful(color: BallColor, image: np.ndarray) -> BallColor | None:
    """Of a colour's name only the most colourful that a picture has; None where it has hardly any, and for a learned colour.

    A name is wide: before plants and books of the ball's name all flows into one patch. A ball is often the most colourful
    thing among them.
    """
    if color.name not in HUES:
        return None
    found = image[::EVERY, ::EVERY][color.likeness(image, EVERY) > SURELY].astype(int)
    if len(found) < FEW:
        return None
    half, most = np.quantile(found.max(1) - found.min(1), COLORFUL_PARTS)
    colors = bin_colors().astype(int)
    part = (colors.max(-1) - colors.min(-1) - half) / max(most - half, STEP)
    table = color.table * np.clip(part, 0, 1).reshape(color.table.shape)
    return replace(color, name=MOST + color.name, table=table.astype(np.uint8))


def pixels_of(images: Sequence[np.ndarray], circles: Sequence[Sequence[float]]) -> tuple[np.ndarray, np.ndarray]:
    """Pixels of the marked balls and of all the rest, shapes (N, 3) and (M, 3), BGR."""
    if len(images) != len(circles) or any(len(circle) != 3 for circle in circles):
        raise StereoLabError("Expected for each picture one circle (u, v, radius), in px.")
    inside, outside = [], []
    for image, (u, v, radius) in zip(map(check_image, images), circles, strict=True):
        distance = np.hypot(*(np.indices(image.shape[:2])[::-1] - np.array([u, v])[:, None, None]))
        smooth = cv2.GaussianBlur(image, (0, 0), 1.0)
        if not (distance < 0.85 * radius).any():
            raise StereoLabError(f"The circle ({u:g}, {v:g}, {radius:g}) px lies outside its picture.")
        inside.append(smooth[distance < 0.85 * radius])
        outside.append(smooth[distance > 1.25 * radius])
    if not inside:
        raise StereoLabError("To learn a colour, mark the ball in one picture at least; three or four are better.")
    ball, rest = np.concatenate(inside), np.concatenate(outside)
    if not len(rest):
        raise StereoLabError("The marked circles fill their pictures; the colour of what is round the ball is needed.")
    return ball, rest


def table_from_pixels(ball: np.ndarray, rest: np.ndarray) -> np.ndarray:
    """How ball-like each colour is: the mean of two ways, which err in different colours.

    A histogram knows exactly what it has seen; a logistic model also judges colours that lie between.
    """
    share = (_histogram(ball, rest) + _logistic(ball, rest)) / 2
    return (255 * np.clip(share, 0, 1)).astype(np.uint8)


def _histogram(ball, rest):
    """Share of ball among the pixels of each colour, with both counts spread over similar colours."""
    shares = []
    for pixels in (ball, rest):
        blue, green, red = (pixels // STEP).astype(np.int32).T
        counts = np.bincount((blue * BINS + green) * BINS + red, minlength=BINS**3).reshape(BINS, BINS, BINS)
        shares.append(_spread(counts.astype(np.float32)) / len(pixels))
    return PRIOR * shares[0] / (PRIOR * shares[0] + (1 - PRIOR) * shares[1] + 1e-7)


def _logistic(ball, rest):
    """The probability of ball of each colour by twelve terms of it, fitted by Newton's method."""
    rng = np.random.default_rng(0)
    some = [p[rng.integers(len(p), size=min(len(p), MOST_PIXELS))] for p in (ball, rest)]
    terms = _terms(np.concatenate(some))
    is_ball = np.repeat([1.0, 0.0], [len(p) for p in some])
    weight = np.repeat([PRIOR / len(some[0]), (1 - PRIOR) / len(some[1])], [len(p) for p in some]) * len(is_ball)
    beta = np.zeros(terms.shape[1])
    for _ in range(ROUNDS):
        p = 1 / (1 + np.exp(-np.clip(terms @ beta, -30, 30)))
        hessian = (terms * (weight * p * (1 - p))[:, None]).T @ terms + RIDGE * np.eye(len(beta))
        beta = beta + np.linalg.solve(hessian, terms.T @ (weight * (is_ball - p)) - RIDGE * beta)
    return 1 / (1 + np.exp(-np.clip(_terms(bin_colors().reshape(-1, 3)) @ beta, -30, 30))).reshape(BINS, BINS, BINS)


def _terms(pixels):
    """Lightness, two colour axes (CIE Lab) and their products; hue weighed by saturation. Shape (N, 12)."""
    picture = pixels.reshape(-1, 1, 3).astype(np.float32) / 255
    lightness, a, b = cv2.cvtColor(picture, cv2.COLOR_BGR2Lab).reshape(-1, 3).T / 50.0
    hue, saturation, _ = cv2.cvtColor(picture, cv2.COLOR_BGR2HSV).reshape(-1, 3).T
    east, north = saturation * np.cos(np.radians(hue)), saturation * np.sin(np.radians(hue))
    one = np.ones_like(a)
    return np.stack(
        [one, lightness, a, b, a * a, b * b, a * b, lightness**2, lightness * a, lightness * b, east, north], -1
    ).astype(float)


def _spread(counts):
    """Gaussian blur of a colour histogram: brightness may change more than tint."""
    for axis in range(3):
        moved = np.moveaxis(counts, axis, 0)
        flat = np.ascontiguousarray(moved.reshape(BINS, -1))
        blurred = cv2.filter2D(flat, -1, cv2.getGaussianKernel(7, 1.0), borderType=cv2.BORDER_CONSTANT)
        counts = np.moveaxis(blurred.reshape(moved.shape), 0, axis)
    grey = np.zeros_like(counts)
    for step in range(-3, 4):  # along the grey diagonal: the same tint, lighter or darker
        grey += np.exp(-0.5 * (step / 1.6) ** 2) * _shifted(counts, step)
    return grey


def _shifted(counts, step):
    result = np.zeros_like(counts)
    to = slice(max(0, step), BINS + min(0, step))
    come = slice(max(0, -step), BINS - max(0, step))
    result[to, to, to] = counts[come, come, come]
    return result


def hls_ranges(pixels):
    """HLS bounds: in each channel 98 of 100 pixels lie between them; the hue may wrap round 0."""
    hls = cv2.cvtColor(pixels.reshape(-1, 1, 3), cv2.COLOR_BGR2HLS).reshape(-1, 3).astype(float)
    angle = np.angle(np.exp(2j * np.pi * hls[:, 0] / 180).mean()) * 90 / np.pi
    offset = (hls[:, 0] - angle + 90) % 180 - 90
    low, high = np.percentile(offset, [1, 99]) + angle
    (l0, l1), (s0, s1) = (np.percentile(hls[:, k], [1, 99]) for k in (1, 2))
    low, high = round(low) % 180, round(high) % 180
    spans = [(low, high)] if low <= high else [(low, LAST_HUE), (0, high)]
    if low == 0:
        spans.append((LAST_HUE, LAST_HUE))  # the same hue, as OpenCV 5 may round it
    return tuple(((int(a), int(l0), int(s0)), (int(b), int(l1), int(s1))) for a, b in spans)

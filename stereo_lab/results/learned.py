"""Lesson 09: all that may be a ball in many pictures, looked at once and kept; and ways to answer from it."""

from __future__ import annotations

import hashlib
import io
import zipfile
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

import cv2
import numpy as np

import stereo_lab.detection
from stereo_lab.common.files import read_bytes, user_folder, write_whole
from stereo_lab.common.spreadsheets import read_table
from stereo_lab.detection import BALL, BallColor, BallDetector
from stereo_lab.detection.candidates import SURELY, patches
from stereo_lab.detection.judge import EVIDENCE, MOST_LOGIT
from stereo_lab.detection.marked import Frame, Score, answers, look
from stereo_lab.detection.model import Camera, Circle
from stereo_lab.detection.weights import SHIPPED, Weights
from stereo_lab.errors import StereoLabError
from stereo_lab.recording import Recording
from stereo_lab.recording.places import course
from stereo_lab.results.evaluation import color_of

# What evidence depends on
LOOK = "candidates", "color", "cone", "detector", "hough", "judge", "model", "outline", "weights"
LEAST_WIDE, MOST_SUM = 0.01, 30.0  # a number that is always the same is not divided by zero; beyond it all is certain
PATCH_PX, PATCH_RADII = 24, 1.5  # a thing made so large, with so many radii round its middle


def frames_of(
    recording: Recording,
    set_name: str = "snaps",
    camera: Camera | None = None,
    progress: Callable[[int, int], object] = lambda done, total: None,
) -> tuple[Frame, ...]:
    """Everything that may be the ball in each left picture of a set, with the truth for a mark.

    It takes a tenth of a second a picture, and is kept: it comes with the shipped clutter, else it lies in the learner's folder.
    Pictures, colour, camera and program are its key.

    Parameters
    ----------
    recording : Recording that knows where its balls are
    set_name : str
    camera : (matrix, distortion), optional
    progress : callable (done, total)
    """
    pairs, circles, key = _asked(recording, set_name, camera)
    for path in (_beside(recording, set_name), _user_path(key)):
        kept = _read(path, key, circles)
        if kept is not None:
            return kept
    frames = _looked(recording, set_name, camera, progress)
    try:
        _write(_user_path(key), key, frames)
    except StereoLabError:
        pass  # a read-only home folder costs time, nothing else
    return frames


def keep_frames(recording: Recording, set_name: str = "snaps", camera: Camera | None = None) -> None:
    """Look at every picture anew, and put what is seen beside them: whoever gets the recording waits for nothing."""
    frames = _looked(recording, set_name, camera, lambda done, total: None)
    _write(_beside(recording, set_name), _asked(recording, set_name, camera)[2], frames)


def _asked(recording, set_name, camera):
    """The pictures of a set, the marks that truth gives them, and the key under which what is seen is kept."""
    pairs = recording.pairs(set_name)
    truth = [recording.true_ball(set_name, pair.name) for pair in pairs]
    circles: list[Circle | None] = [tuple(ball["left"]) if ball else None for ball in truth]
    return pairs, circles, _key([pair.left_path for pair in pairs], color_of(recording, set_name), camera)


def _looked(recording, set_name, camera, progress):
    pairs, circles, _ = _asked(recording, set_name, camera)
    detector, frames = BallDetector(color_of(recording, set_name), camera=camera), []
    for k, (pair, circle) in enumerate(zip(pairs, circles, strict=True)):
        frames.append(look(detector, pair.left, circle))
        progress(k + 1, len(pairs))
    return tuple(frames)


def _beside(recording, set_name):
    return recording.path / f"things_{set_name}.npz"


def _user_path(key):
    return user_folder() / "things" / f"{key}.npz"


def _write(path, key, frames):
    data = io.BytesIO()
    things, evidence = (np.concatenate([getattr(f, part) for f in frames]) for part in ("things", "evidence"))
    counts = np.array([len(f.things) for f in frames], np.int32)
    np.savez_compressed(
        data, key=np.array(key), counts=counts, things=things.astype("f4"), evidence=evidence.astype("f4")
    )
    write_whole(path, data.getvalue())


def _key(paths, color, camera):
    digest = hashlib.sha256(b"" if camera is None else b"".join(np.round(part, 6).tobytes() for part in camera))
    digest.update(color.encode())
    folder = Path(stereo_lab.detection.__file__).parent
    for path in (*paths, *(folder / f"{name}.py" for name in LOOK)):
        digest.update(read_bytes(path))
    return digest.hexdigest()[:24]


def _read(path, key, circles):
    """Frames that were kept under this key; None where there are none, or spoilt ones."""
    try:
        with np.load(io.BytesIO(read_bytes(path))) as kept:
            if str(kept["key"]) != key:
                return None
            ends = np.cumsum(kept["counts"])[:-1]
            things, evidence = (np.split(kept[part].astype(float), ends) for part in ("things", "evidence"))
        return tuple(Frame(*parts) for parts in zip(circles, things, evidence, strict=True))
    except (StereoLabError, ValueError, KeyError, OSError, zipfile.BadZipFile):
        return None


def largest_patch(image: np.ndarray, color: BallColor) -> Circle | None:
    """The circle of the largest patch of a colour, or None: what most first programs do."""
    found = patches(color.likeness(image), SURELY, 4.0)
    return found[0] if found else None


def disc(
    image: np.ndarray, circle: Sequence[float], shade: float, color: tuple[int, int, int] = (40, 40, 190)
) -> np.ndarray:
    """A picture with a disc painted into it, lighter to the upper left by ``shade``: 0 is flat, as if printed.

    Parameters
    ----------
    image : ndarray, BGR; not changed
    circle : (u, v, radius) in px
    shade : float, 0…1
    color : (blue, green, red) of its middle
    """
    u, v, r = circle
    y, x = np.mgrid[: image.shape[0], : image.shape[1]]
    inside = np.clip(r - np.hypot(x - u, y - v) + 0.5, 0, 1)[..., None]
    light = 1 - shade * ((x - u) + (y - v)) / (np.sqrt(2) * r)
    painted = np.clip(np.array(color) * light[..., None], 0, 255)
    return np.round(image * (1 - inside) + painted * inside).astype(np.uint8)


def patch(image: np.ndarray, circle: Sequence[float]) -> np.ndarray:
    """A thing cut out of a picture and made 24 px wide, grey, one and a half radii round its middle; 0…255."""
    u, v, r = circle
    reach = PATCH_RADII * r
    scale = PATCH_PX / (2 * reach)
    shift = np.array([[scale, 0, -scale * (u - reach)], [0, scale, -scale * (v - reach)]])
    grey = cv2.cvtColor(image, cv2.COLOR_BGR2GRAY)
    return cv2.warpAffine(grey, shift, (PATCH_PX, PATCH_PX), flags=cv2.INTER_AREA, borderMode=cv2.BORDER_REPLICATE)


def hog(small: np.ndarray) -> np.ndarray:
    """Histograms of oriented gradients of a patch (N. Dalal and B. Triggs 2005): in 3 x 3 fields, 8 directions each. 72 numbers."""
    small = small.astype(np.float32)
    du, dv = cv2.Sobel(small, cv2.CV_32F, 1, 0), cv2.Sobel(small, cv2.CV_32F, 0, 1)
    strength, direction = cv2.cartToPolar(du, dv)
    bins = np.minimum((direction * 8 / (2 * np.pi)).astype(int), 7)
    side = PATCH_PX // 3
    fields = [
        (slice(i, i + side), slice(j, j + side)) for i in range(0, PATCH_PX, side) for j in range(0, PATCH_PX, side)
    ]
    counts = np.array([np.bincount(bins[f].ravel(), strength[f].ravel(), 8) for f in fields]).ravel()
    return counts / (np.linalg.norm(counts) + 1e-6)


def a_moment_later(
    image: np.ndarray, circle: Circle | None, rng: np.random.Generator
) -> tuple[np.ndarray, Circle | None]:
    """The same scene as a tenth of a second later, made: two pixels farther to the right, with new noise; and its mark."""
    moved = np.roll(image, 2, axis=1) + rng.normal(0, 2, image.shape)
    return np.clip(moved, 0, 255).astype(np.uint8), circle and (circle[0] + 2, *circle[1:])


DESCRIBED: dict[str, Callable[[np.ndarray, Frame, int], np.ndarray]] = {
    "pixels": lambda image, frame, k: patch(image, frame.things[k]).ravel() / 255,
    "HOG": lambda image, frame, k: hog(patch(image, frame.things[k])),
    "evidence": lambda image, frame, k: frame.evidence[k],
}


def described(images: Sequence[np.ndarray], frames: Sequence[Frame]) -> dict[str, list[np.ndarray]]:
    """For "pixels", "HOG" and "evidence" a table for each picture, with a row for each distinct thing in it."""
    kept = [frame.ranked(SHIPPED)[0] for frame in frames]
    return {
        how: [
            np.array([row(image, frame, k) for k in numbers]) if numbers else np.zeros((0, 1))
            for image, frame, numbers in zip(images, frames, kept, strict=True)
        ]
        for how, row in DESCRIBED.items()
    }


Sums = Callable[[np.ndarray], np.ndarray]  # from rows to the sum of each


def taught(
    learner: Callable[[np.ndarray, np.ndarray], Sums],
    tables: Sequence[np.ndarray],
    frames: Sequence[Frame],
    marked: Sequence[int],
) -> Sums:
    """What a learner makes of some marked pictures; it gets rows in spreads off their mean, and which of them is the ball.

    Parameters
    ----------
    learner : callable (rows, y), gives a function from rows to sums
    tables : of all pictures, from :func:`described`
    frames : the pictures, with their marks
    marked : numbers of the pictures to learn from
    """
    x = np.concatenate([tables[k] for k in marked if len(tables[k])])
    y = np.concatenate([frames[k].is_ball[frames[k].ranked(SHIPPED)[0]] for k in marked]).astype(float)
    middle, wide = x.mean(0), x.std(0) + LEAST_WIDE
    sums = learner((x - middle) / wide, y)
    return lambda rows: sums((rows - middle) / wide)


def asked(sums: Sums, tables: Sequence[np.ndarray], frames: Sequence[Frame], shared: Sums) -> Score:
    """How pictures are answered by the most probable thing in each; ``shared`` makes probabilities of the sums."""
    said: list[Circle | None] = []
    for table, frame in zip(tables, frames, strict=True):
        told = shared(np.clip(sums(table), -MOST_SUM, MOST_SUM)) if len(table) else np.zeros(1)
        best = int(np.argmax(told))
        said.append(tuple(frame.things[frame.ranked(SHIPPED)[0][best]]) if told[best] >= BALL else None)
    return answers(frames, said)


def network(x: np.ndarray, y: np.ndarray, hidden: int = 16, steps: int = 300, rate: float = 0.3, seed: int = 0) -> Sums:
    """A small network of two layers: weighted sums of a row, each bent by tanh, and a weighted sum of those.

    It learns as the ten lines of lesson 09 do, from the same loss by steps downhill; the chain rule says what each weight did to it.

    Parameters
    ----------
    x : ndarray, shape (N, n), rows in spreads off their mean
    y : ndarray, shape (N,), 1 for the ball, else 0
    hidden : int, how many sums the first layer has
    steps, rate : of the learning
    seed : int, of the weights it starts from
    """
    rng, ones = np.random.default_rng(seed), lambda rows: np.column_stack([np.ones(len(rows)), rows])
    first = rng.normal(0, 1 / np.sqrt(x.shape[1]), (x.shape[1] + 1, hidden))
    last = rng.normal(0, 1 / np.sqrt(hidden), hidden + 1)
    for _ in range(steps):
        bent = ones(np.tanh(ones(x) @ first))
        off = (1 / (1 + np.exp(-bent @ last)) - y) / len(y)
        first_off = np.outer(off, last[1:]) * (1 - bent[:, 1:] ** 2)
        last, first = last - rate * bent.T @ off, first - rate * ones(x).T @ first_off
    return lambda rows: ones(np.tanh(ones(rows) @ first)) @ last


class Rows(NamedTuple):
    """Rows of evidence without their pictures: ``group`` is the number of the picture of each, ``ball`` is 1 for the ball.

    ``has_ball``, shape (pictures,): whether a ball is in each picture, also where no circle fitted it (but something was seen).
    """

    group: np.ndarray
    ball: np.ndarray
    evidence: np.ndarray
    has_ball: np.ndarray


def rows_of(*names: str) -> Rows:
    """Some of the rows that the shipped weights were learned from, ``data/train/rows``.

    Parameters
    ----------
    names : "s101" to "s104" and "s201" to "s206", rendered; "e301" and "e302", too, with matt balls in even light;
        "green_ball" and "orange_ball", real
    """
    picture, ball, evidence, has_ball = [], [], [], {}
    for name in names:
        for _, row in read_table(course() / "data" / "train" / "rows" / f"{name}.csv", ("picture", *EVIDENCE)):
            picture.append(f"{name} {row['picture']}")
            has_ball[picture[-1]] = row["has_ball"] == "1"
            ball.append(float(row["is_ball"]))
            evidence.append([float(row[piece]) for piece in EVIDENCE])
    pictures, group = np.unique(picture, return_inverse=True)
    return Rows(group, np.array(ball), np.array(evidence), np.array([has_ball[name] for name in pictures]))


def score_of_rows(rows: Rows, weights: Weights) -> Score:
    """How pictures are answered of which there are only rows: the most probable thing of each, or none."""
    count = rows.group.max() + 1
    odds = np.exp(np.minimum(weights.logits(rows.evidence), MOST_LOGIT))
    told = (odds / (1 + np.bincount(rows.group, odds, count)[rows.group])) >= BALL
    there = rows.has_ball
    named = np.bincount(rows.group, told, count) > 0
    right = np.bincount(rows.group, told * rows.ball, count) > 0
    return Score(int(there.sum()), int(right.sum()), int((~there).sum()), int((named & ~there).sum()))

"""The pictures of the boards, each looked at once: its size, the corners in it, and how sharp and how bright it is."""

from __future__ import annotations

import hashlib
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from stereo_lab.calibration import find_corners, match_order
from stereo_lab.common.files import read_bytes
from stereo_lab.doctor.advice import ADVICE
from stereo_lab.doctor.boards import Boards
from stereo_lab.doctor.findings import COSTS, Finding
from stereo_lab.errors import StereoLabError
from stereo_lab.recording import Board, Recording, StereoPair, read_image

BLOCK = 8  # pixels, of JPEG
WHITE = 252  # of 255: brighter, a picture tells no more


@dataclass(frozen=True)
class Look:
    """What one picture of a board looks like.

    Attributes
    ----------
    size : (width, height), px
    edge_px : float, half the width of the edges between squares; NaN where no board is seen
    contrast : float, white squares minus black ones, 0…255; NaN where no board is seen
    burnt : float, part of the white squares that is as bright as a picture can be
    blocks : float, how much larger steps are between JPEG's blocks than inside them: 1 where one sees none
    """

    size: tuple[int, int]
    edge_px: float
    contrast: float
    burnt: float
    blocks: float


@dataclass(frozen=True, eq=False)
class Looked:
    """All pictures of the boards.

    Attributes
    ----------
    boards : Boards, of those pictures that have the commonest size
    looks : {(pair's name, "left" or "right"): Look}
    size : (width, height), the commonest
    """

    boards: Boards
    looks: dict[tuple[str, str], Look]
    size: tuple[int, int]

    @property
    def other_sizes(self) -> dict[tuple[str, str], tuple[int, int]]:
        """Pictures of another size than the commonest."""
        return {key: look.size for key, look in self.looks.items() if look.size != self.size}


def look_at(pairs: Sequence[StereoPair], board: Board, progress: Callable[[int, int], object] | None = None) -> Looked:
    """Look at every picture of the boards once; one pair at a time is in memory."""
    corners, looks = [], {}
    for done, pair in enumerate(pairs, 1):
        images = [read_image(path, grey_allowed=True) for path in (pair.left_path, pair.right_path) if path]
        left, right = (find_corners(image, board) for image in images)
        if left is not None and right is not None:
            right = match_order(left, right, board)
        corners.append((left, right))
        for side, image, seen in zip(("left", "right"), images, (left, right), strict=True):
            looks[pair.name, side] = look_of(cv2.cvtColor(image, cv2.COLOR_BGR2GRAY), seen)
        if progress:
            progress(done, len(pairs))
    size = Counter(look.size for look in looks.values()).most_common(1)[0][0]
    fitting = [all(looks[pair.name, side].size == size for side in ("left", "right")) for pair in pairs]
    return Looked(_boards(pairs, corners, fitting, board, size), looks, size)


def _boards(pairs, corners, fitting, board, size):
    """The corners of all pairs of the right size, NaN where none were found."""
    nowhere = np.full((len(board.corners_mm), 2), np.nan)
    kept = [
        (pair.name, *(nowhere if c is None else c for c in seen))
        for pair, seen, fits in zip(pairs, corners, fitting, strict=True)
        if fits and any(c is not None for c in seen)
    ]
    names, left, right = zip(*kept, strict=True) if kept else ((), (), ())
    shape = (len(kept), *nowhere.shape)
    return Boards(tuple(names), np.reshape(left, shape), np.reshape(right, shape), board, size)


def look_of(grey: np.ndarray, corners: np.ndarray | None) -> Look:
    """What a grey picture looks like, with the corners in it, shape (N, 2), NaN where not seen; or None."""
    size = grey.shape[1::-1]
    if corners is None:
        return Look(size, np.nan, np.nan, float((grey >= WHITE).mean()), _blocks(grey))
    inside = np.zeros(grey.shape, np.uint8)
    there = corners[~np.isnan(corners[:, 0])]
    cv2.fillConvexPoly(inside, cv2.convexHull(there.astype(np.float32)).astype(np.int32), 1)
    shown = grey[inside > 0]
    if not len(shown):
        return Look(size, np.nan, np.nan, 0.0, _blocks(grey))
    dark, white = np.percentile(shown, (10, 90))
    slope = np.hypot(*(cv2.Sobel(grey, cv2.CV_32F, *way, scale=1 / 8) for way in ((1, 0), (0, 1))))[inside > 0]
    steepest = np.percentile(slope, 98)
    return Look(
        size, float((white - dark) / 2 / max(steepest, 1e-3)), float(white - dark),
        float((shown >= WHITE).sum() / max((shown > (dark + white) / 2).sum(), 1)), _blocks(grey),
    )  # fmt: skip


def _blocks(grey):
    """Steps from column to column and from row to row: those between blocks of 8 by all others."""
    between, inside = [], []
    for turned in (grey, grey.T):
        steps = np.abs(np.diff(turned.astype(np.int16), axis=1)).mean(0)
        edge = np.arange(1, len(steps) + 1) % BLOCK == 0
        between.append(steps[edge].mean())
        inside.append(steps[~edge].mean())
    return float(np.mean(between) / max(np.mean(inside), 1e-3))


def copies_told(recording: Recording) -> list[Finding]:
    """Pictures that are there twice, to the last bit: no camera takes the same noise again, nor two cameras one picture."""
    first: dict[tuple[str, str], str] = {}
    copies: dict[tuple[str, str], list[str]] = {}
    both: list[str] = []
    for label, pair in _all_pairs(recording):
        prints = {"left": _fingerprint(pair.left_path), "right": _fingerprint(pair.right_path)}
        if prints["left"] and prints["left"] == prints["right"]:
            both.append(label)
        for side, told in prints.items():
            other = first.setdefault((side, told), label) if told else label
            if other != label:
                copies.setdefault((other, label), []).append(side)
    return _same_in_both(both) + _twice(copies)


def _all_pairs(recording):
    """("set/name", pair) of all sets that can be read; what is wrong with the others is told elsewhere."""
    for name in recording.sets:
        try:
            pairs = recording.pairs(name)
        except StereoLabError:
            continue
        yield from ((f"{name}/{pair.name}", pair) for pair in pairs)


def _fingerprint(path):
    """What two files have in common that are alike to the last bit; empty where there is nothing to read."""
    try:
        content = b"" if path is None else read_bytes(path)
    except StereoLabError:  # told elsewhere
        return ""
    return hashlib.sha256(content).hexdigest() if content else ""


def _same_in_both(names):
    if not names:
        return []
    more = f" So do {len(names) - 1} more pairs." if len(names) > 1 else ""
    says = f"{names[0]} shows the same picture on both sides, to the last bit: one of the two is a copy.{more}"
    return [Finding("same_pictures", says, ADVICE["same_pictures"], tuple(names), severity=COSTS)]


def _twice(copies):
    if not copies:
        return []
    (other, label), sides = next(iter(copies.items()))
    # Which of the two was there first, their numbers do not tell
    same = f"the same {sides[0]} picture" if len(sides) == 1 else "the same pictures"
    more = f" So do {len(copies) - 1} more." if len(copies) > 1 else ""
    says = f"{other} and {label} show {same}, to the last bit: one of the two is a copy.{more}"
    files = tuple(dict.fromkeys(name for both in copies for name in both))
    return [Finding("picture_twice", says, ADVICE["picture_twice"], files, severity=COSTS)]

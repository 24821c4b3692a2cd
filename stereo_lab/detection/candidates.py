"""Candidates: where in a picture the ball may be. Patches of its colour; votes where patches do not tell."""

from __future__ import annotations

import math
from collections.abc import Iterator

import cv2
import numpy as np

from stereo_lab.detection.hough import vote
from stereo_lab.detection.judge import DISC, PERHAPS
from stereo_lab.detection.model import Circle
from stereo_lab.detection.outline import RING

SURELY, LEVELS = 90, (40, 90, 150, 210)  # likeness, of 255
SMALL = 0.7  # of the least radius: a patch may be so small, for its rim is blurred
MOST_PATCHES, MOST_CIRCLES = 8, 40
MOST_LOOKS = 14  # places that are worth a look
LEAST_VOTE, RADII = 0.3, 24


def above(like: np.ndarray, level: int) -> np.ndarray:
    """1 where the likeness is above a level, else 0."""
    return cv2.threshold(like, level, 1, cv2.THRESH_BINARY)[1]


def patches(like: np.ndarray, level: int, least: float) -> list[Circle]:
    """The circle of each large patch of the ball's colour, in pixels of ``like``, largest first."""
    circles = [as_circle(sums) for sums in moments(like, level)]
    return sorted((c for c in circles if c[2] > SMALL * least), key=lambda circle: -circle[2])[:MOST_PATCHES]


def moments(like: np.ndarray, level: int) -> list[dict[str, float]]:
    """The moments of each patch, as ``cv2.moments`` names them."""
    outlines = cv2.findContours(above(like, level), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)[0]
    return [sums for sums in map(cv2.moments, outlines) if sums["m00"]]


def as_circle(sums: dict[str, float]) -> Circle:
    """A circle of the same middle and area as a patch."""
    return sums["m10"] / sums["m00"], sums["m01"] / sums["m00"], math.sqrt(sums["m00"] / math.pi) + 0.5


def stretch(sums: dict[str, float], du: float, dv: float) -> float:
    """How long a patch is along a direction, by how wide it is across: 1 for a disc."""
    along = sums["mu20"] * du * du + 2 * sums["mu11"] * du * dv + sums["mu02"] * dv * dv
    across = (sums["mu20"] + sums["mu02"]) * (du * du + dv * dv) - along
    return math.sqrt(max(along, 0.0) / max(across, 1e-9))


def promising(like: np.ndarray, places: list[Circle]) -> list[Circle]:
    """The places with the ball's colour inside and another one outside, best first; near doubles are left out."""
    if not places:
        return []
    small = 1 / np.sqrt([r for *_, r in places])
    score = _ball_like(like, places, DISC, 1.0) - 0.7 * _ball_like(like, places, RING[:, ::2], 1.3) - 0.15 * small
    kept: list[Circle] = []
    for k in np.argsort(-score):
        if all(np.abs(np.subtract(places[k], other)).sum() > 0.2 * other[2] for other in kept):
            kept.append(places[k])
    return kept[:MOST_LOOKS]


def _ball_like(like, circles, spots, radii):
    """The part of some spots, so many radii round each circle's middle, that may have the ball's colour."""
    u, v, r = np.array(circles).T[:, :, None]
    x, y = np.rint(u + radii * r * spots[0]).astype(int), np.rint(v + radii * r * spots[1]).astype(int)
    inside = (x >= 0) & (y >= 0) & (x < like.shape[1]) & (y < like.shape[0])
    return (inside & (like[y.clip(0, like.shape[0] - 1), x.clip(0, like.shape[1] - 1)] > PERHAPS)).mean(1)


def voted(like: np.ndarray, thinned: np.ndarray, least: float) -> Iterator[Circle]:
    """Circles by a Hough transform, best first: edges beside the ball's colour vote on its side, one radius away."""
    height, width = like.shape
    beside = cv2.dilate(above(like, PERHAPS), np.ones((5, 5), np.uint8))
    points, directions = [], []
    for channel in (*cv2.split(cv2.GaussianBlur(thinned, (3, 3), 0)), like):
        du, dv = cv2.spatialGradient(channel)
        rows, columns = np.nonzero((cv2.Canny(du, dv, 30, 60) > 0) & (beside > 0))
        places = np.column_stack([columns, rows])
        slope = np.column_stack([du[rows, columns], dv[rows, columns]]).astype(np.float32)
        slope /= np.sqrt((slope * slope).sum(1))[:, None]
        for side in (1, -1):
            x, y = np.rint(places + 2 * side * slope).astype(int).clip(0, (width - 1, height - 1)).T
            ours = like[y, x] > PERHAPS
            points.append(places[ours])
            directions.append(side * slope[ours])
    edge, toward = np.concatenate(points), np.concatenate(directions)
    radii = np.geomspace(0.9 * least, max(least, 0.3 * min(like.shape)), RADII)
    votes = np.array([_pooled(vote(edge, toward, r, like.shape), r) for r in radii])
    layers = votes.reshape(RADII, -1)
    most = layers.argmax(1)  # in each layer; only those that change are searched again
    for _ in range(MOST_CIRCLES):
        k = int(layers[np.arange(RADII), most].argmax())
        v, u = divmod(int(most[k]), width)
        if votes[k, v, u] < LEAST_VOTE:
            return
        yield float(u), float(v), float(radii[k])
        near, beside_k = int(max(1, 0.25 * radii[k])), slice(max(0, k - 1), k + 2)
        votes[beside_k, max(0, v - near) : v + near + 1, max(0, u - near) : u + near + 1] = 0
        most[beside_k] = layers[beside_k].argmax(1)


def _pooled(votes, r):
    """Votes for each pixel of the rim, gathered from a neighbourhood that grows with the radius."""
    size = 2 * int(np.ceil(0.08 * r)) + 1
    return cv2.boxFilter(votes.astype(np.float32), -1, (size, size), normalize=False) / (2 * np.pi * r + 20)

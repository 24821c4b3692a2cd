"""Where a ball might be: circles worth a closer look, found in a small copy of the picture.

Two ways, the cheap one first. A patch of the ball's colour that stands alone tells its own circle. Where
patches run together or are partly hidden, the pixels at their edges vote for a centre, as in the Hough
transform: each one for the places at one radius from it, along the direction in which the colour changes.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np

from stereo_lab.detection.color import BallColor
from stereo_lab.detection.curves import through

SEARCH_WIDTH = 400  # a picture is halved until it is at most this wide
LEAST_RADIUS_PX, LEAST_OF_WIDTH = 3.0, 0.007
SURELY, PERHAPS = 90, 60  # likeness, of 255
MOST_BLOBS, MOST_VOTED = 8, 24
MOST_EDGES = 6000  # pixels that vote
TRIALS = 160  # circles through three points of an outline
LEAST_VOTE = 0.25  # of the rim
RADIUS_STEP = 1.15
SMALL = 6  # times the least radius: larger balls are found in the first, small copy


@dataclass(frozen=True, eq=False)
class Copy:
    """A small copy of a picture, and what to look for in it.

    Attributes
    ----------
    picture : ndarray, BGR
    likeness : ndarray, how ball-like each pixel's colour is, 0…255
    scale : float, px of the copy for each px of the picture
    least_radius, largest_radius : float, of the balls to look for, px of the copy
    """

    picture: np.ndarray
    likeness: np.ndarray
    scale: float
    least_radius: float
    largest_radius: float

    @property
    def least_area(self) -> float:
        """Pixels of half a ball of the least radius."""
        return max(6, 0.5 * np.pi * self.least_radius**2)

    def in_picture(self, circles: list[tuple[float, float, float]]) -> list[tuple[float, float, float]]:
        """Circles (u, v, r) of the copy, in pixels of the picture; those of a wrong size are left out."""
        return [
            ((u + 0.5) / self.scale - 0.5, (v + 0.5) / self.scale - 0.5, r / self.scale)
            for u, v, r in circles
            if r <= self.largest_radius
        ]


def small_copies(image: np.ndarray, color: BallColor) -> Iterator[Copy]:
    """A small :class:`Copy`, and after it one twice as large, for balls that are small in the first."""
    height, width = image.shape[:2]
    least = least_radius(width)
    halvings = max(0, int(np.ceil(np.log2(width / SEARCH_WIDTH))))
    for k, largest in ((halvings, 0.3 * min(height, width)), (halvings - 1, SMALL * least)):
        if k >= 0:
            small = image
            for _ in range(k):
                small = cv2.resize(small, (small.shape[1] // 2, small.shape[0] // 2), interpolation=cv2.INTER_AREA)
            scale = 0.5**k
            yield Copy(small, color.likeness(small), scale, least * scale, largest * scale)


def least_radius(width: int) -> float:
    """The smallest ball worth looking for in a picture of this width, px."""
    return max(LEAST_RADIUS_PX, LEAST_OF_WIDTH * width)


def blob_circles(copy: Copy) -> list[tuple[float, float, float]]:
    """Two circles (u, v, r) for each of the largest patches: the one along its outline, and the one inside."""
    mask = cv2.morphologyEx((copy.likeness > SURELY).astype(np.uint8), cv2.MORPH_CLOSE, np.ones((3, 3), np.uint8))
    _, labels, stats, _ = cv2.connectedComponentsWithStats(mask, connectivity=4)
    areas = stats[1:, cv2.CC_STAT_AREA]
    circles = []
    for label in [i + 1 for i in np.argsort(-areas)[:MOST_BLOBS] if areas[i] >= copy.least_area]:
        x, y, w, h = stats[label, :4]
        blob = np.pad((labels[y : y + h, x : x + w] == label).astype(np.uint8), 1)
        circles += [(u + x - 1, v + y - 1, r) for u, v, r in _circles_of_blob(blob)]
    return copy.in_picture(circles)


def _circles_of_blob(blob):
    _, radius, _, (u, v) = cv2.minMaxLoc(cv2.distanceTransform(blob, cv2.DIST_L2, 5))
    inside = (float(u), float(v), float(radius))
    outlines, _ = cv2.findContours(blob, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    points = max(outlines, key=len).reshape(-1, 2).astype(float)
    along = _circle_of_outline(points[:: max(1, len(points) // 300)], max(blob.shape)) if len(points) >= 8 else None
    return [inside] if along is None else [along, inside]


def _circle_of_outline(points, largest):
    """Of circles through three neighbouring points, the one that carries most of its rim."""
    rng = np.random.default_rng(1)
    n = len(points)
    first = rng.integers(n, size=TRIALS)
    span = rng.uniform(0.08, 0.33, TRIALS) * n
    triples = np.stack([first, (first + span).astype(int) % n, (first + 2 * span).astype(int) % n], 1)
    centers, radii = through(points[triples])
    good = np.isfinite(radii) & (radii > 1.5) & (radii < 0.75 * largest)
    centers, radii = centers[good], radii[good]
    if not len(radii):
        return None
    distance = np.hypot(points[None, :, 0] - centers[:, :1], points[None, :, 1] - centers[:, 1:])
    near = np.abs(distance - radii[:, None]) < np.maximum(0.8, 0.06 * radii)[:, None]
    support = near.sum(1) * (1 + 0.02 * radii.clip(0, 20)) / (2 * np.pi * radii)
    k = int(support.argmax())
    return (centers[k, 0], centers[k, 1], radii[k] + 0.5) if support[k] > LEAST_VOTE else None


def voted_circles(copy: Copy) -> list[tuple[float, float, float]]:
    """Circles (u, v, r) with the most votes of edges that have the ball's colour on their inner side."""
    places, directions = _edges_of_color(copy.likeness, copy.picture)
    if not len(places):
        return []
    height, wide = copy.likeness.shape
    steps = int(np.ceil(np.log(copy.largest_radius / copy.least_radius) / np.log(RADIUS_STEP))) + 1
    radii = 0.9 * copy.least_radius * RADIUS_STEP ** np.arange(steps)
    best = []
    for radius in radii:
        votes = _votes(places + radius * directions, height, wide)
        size = 2 * int(np.ceil(0.08 * radius)) + 1
        part = cv2.boxFilter(votes, -1, (size, size), normalize=False, borderType=cv2.BORDER_CONSTANT)
        part /= 2 * np.pi * radius
        peaks = np.argwhere((part > LEAST_VOTE) & (part >= cv2.dilate(part, np.ones((3, 3), np.uint8))))
        rim = 2 * np.pi * radius
        best += [(min(1.0, part[v, u]) * rim / (rim + 20), u, v, radius) for v, u in peaks]
    return copy.in_picture(_apart(sorted(best, reverse=True)))


def _edges_of_color(likeness, small):
    """Edge pixels beside the ball's colour, and unit vectors towards that side; one pixel may count for both."""
    smooth = cv2.GaussianBlur(small, (3, 3), 0)
    gx, gy = (cv2.Sobel(smooth, cv2.CV_32F, *order) for order in ((1, 0), (0, 1)))
    strength = gx * gx + gy * gy
    channel = strength.argmax(2)[..., None]
    gx, gy, strength = (np.take_along_axis(a, channel, 2)[..., 0] for a in (gx, gy, strength))
    beside = cv2.dilate((likeness > PERHAPS).astype(np.uint8), np.ones((5, 5), np.uint8))
    beside[:3] = beside[-3:] = 0
    beside[:, :3] = beside[:, -3:] = 0
    v, u = np.nonzero(beside)
    length = np.sqrt(strength[v, u])
    du, dv = gx[v, u] / np.maximum(length, 1e-6), gy[v, u] / np.maximum(length, 1e-6)
    ahead, behind = (strength[np.rint(v + s * dv).astype(int), np.rint(u + s * du).astype(int)] for s in (1, -1))
    crest = (length > 16) & (strength[v, u] >= ahead) & (strength[v, u] > behind)
    order = np.argsort(-length[crest])[:MOST_EDGES]
    u, v, du, dv = (a[crest][order] for a in (u, v, du, dv))
    places, directions = [], []
    for side in (1, -1):
        inner = likeness[np.rint(v + 2 * side * dv).astype(int), np.rint(u + 2 * side * du).astype(int)] > PERHAPS
        places.append(np.column_stack([u, v])[inner])
        directions.append(side * np.column_stack([du, dv])[inner])
    return np.concatenate(places).astype(np.float32), np.concatenate(directions)


def _votes(targets, height, width):
    u, v = np.rint(targets).astype(int).T
    inside = (u >= 0) & (u < width) & (v >= 0) & (v < height)
    return (
        np.bincount(v[inside] * width + u[inside], minlength=height * width).reshape(height, width).astype(np.float32)
    )


def _apart(ranked):
    """The best circles that are not nearly the same as a better one."""
    kept = []
    for _, u, v, radius in ranked:
        if all(np.hypot(u - a, v - b) + abs(radius - r) > 0.4 * min(radius, r) for a, b, r in kept):
            kept.append((float(u), float(v), float(radius)))
        if len(kept) == MOST_VOTED:
            break
    return kept

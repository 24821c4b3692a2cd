"""The cone: the rays from the camera that just touch a ball. Its axis goes through the ball's centre.

The picture of the ball is that cone cut by the image plane: an ellipse, whose middle is *not* where the centre is.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import cv2
import numpy as np

from stereo_lab.detection.outline import RAYS, Look

ON_PX, ON = 0.5, 0.04  # px, or of the radius: so near to the cone an edge lies on it
LIMIT_PX, LIMIT = 0.25, 0.02  # px, or of the radius: beyond it an edge counts nothing (Tukey)
SCATTERED = 4.0  # but nearer than so many times the median, for a smeared rim scatters: 2.7 standard deviations
# Until the cone moves by no more than so many px, or than this part of how far half of its edges lie off
MOST_ROUNDS, STILL_PX, STILL = 12, 0.03, 0.1
# Edges are weighed by where the last cone left them, so each round stops short of where the rounds lead, the more so the more
# the edges scatter. It therefore goes on by so many times (median / limit)² of its step: by the slope of Tukey's curve
FARTHER = 9.0
LEAST_CLEAR = 0.3  # of the rays must show an edge
ONE_CURVE = 0.75  # of these must lie near the first cone; else the best cone through three rays is the start
NEAR_PX, NEAR = 0.6, 0.11  # px, or of how far the look reaches: a wide look is taken at what scatters
NORMAL, LEAST_SCATTER_PX = 1.4826, 0.02  # scatter of the edges by their median; the pixels alone bring so much
TOGETHER = 2.0  # neighbouring rays share pixels and err together: on rendered balls so much more than each alone
SHARPENED_PX = 0.12  # a camera's sharpening moves the whole rim in or out
TURN = np.random.default_rng(2).integers(2**31, size=(80, 3))  # so many cones through three rays are tried


class Cone(NamedTuple):
    """A cone through the edges of a look; lengths are px, and what belongs to rays has the shape (RAYS,).

    ``u, v``: where its axis, and so the ball's centre, is seen. ``outline_px``: radius of a circle round it that covers as
    much of the picture as the ball, without the lens's distortion. ``radius_px``: f·tan α, what the ball's radius would be in the middle of the picture.
    ``look``; ``off``: how far beyond its circle the edge lies on each ray; ``weights`` of these edges; ``gap``: how far
    beyond the cone they lie. ``on``: part of the rays in the picture whose edge lies on the cone. ``axis``: a', shape (3,).
    ``information``: how well it is known, the inverse of its covariance, shape (3, 3), by how the edges scatter.
    ``scatter_px``: by that alone, the standard deviations of the centre's u, taken for v too, and of the radius.
    ``smeared``: the ball moved while the shutter was open, or looks as if it had: its edge scatters, however one looks.
    """

    u: float
    v: float
    outline_px: float
    radius_px: float
    look: Look
    off: np.ndarray
    weights: np.ndarray
    gap: np.ndarray
    on: float
    axis: np.ndarray
    information: np.ndarray
    scatter_px: tuple[float, float]
    smeared: bool = False

    @property
    def circle(self) -> tuple[float, float, float]:
        """(u, v, radius) of the next look."""
        return self.u, self.v, self.outline_px

    @property
    def sigmas_px(self) -> tuple[float, float]:
        """The standard deviations, with what moves the whole rim; where the edges tell nothing, the look's radius."""
        across, along = self.scatter_px
        return across, min(math.hypot(along, SHARPENED_PX), self.look.r)


def fit_cone(look: Look, off: np.ndarray, weights: np.ndarray) -> Cone | None:
    """The cone a·ray = cos α through the edges of a look, or None.

    ``off``: how far beyond the look's circle the edge lies on each ray, px; ``weights``: of each, 0 where none is clear.
    Divided by cos α it is linear: a'·ray = 1, and |a'|² − 1 = tan² α. Least squares, then again and again without
    what lies far off.
    """
    clear = weights > 0
    count = np.count_nonzero(clear)
    if count < LEAST_CLEAR * RAYS:
        return None
    rays, used, near = look.rays(off), weights, max(NEAR_PX, NEAR * look.share * look.r)
    parts = np.ascontiguousarray(rays.T)
    axis, gap, step, least = np.zeros(3), off, 1.0, max(LIMIT_PX, LIMIT * look.r)
    for rounds in range(MOST_ROUNDS):
        before = gap
        sums = (parts * used).dot(rays)
        best = cv2.solve(sums, used.dot(rays)[:, None], flags=cv2.DECOMP_CHOLESKY)[1][:, 0]
        axis = axis + step * (best - axis)
        x, y, z = axis.tolist()
        tan2 = x * x + y * y + z * z - 1
        if not tan2 > 1e-8 or z < 0.05:
            return None
        gap = (1 - rays.dot(axis)) * (look.r / tan2)
        away = np.abs(gap)
        order = away[clear]
        order.sort()
        if rounds == 0 and order[int(ONE_CURVE * count)] > near:
            axis = _best_of_threes(rays[clear], near, look.r)
            away = np.abs(1 - rays.dot(axis)) * (look.r / (axis @ axis - 1))
            order = np.sort(away[clear])
        middle = float(order[count // 2])
        if rounds and cv2.norm(gap, before, cv2.NORM_INF) < max(STILL_PX, STILL * middle):
            break
        limit = max(least, SCATTERED * middle)
        step = 1 + FARTHER * (middle / limit) ** 2
        used = weights * tukey(away, limit)
    focal = float(look.camera[0][0, 0])
    radius = focal * tan2**0.5
    outline = radius * ((tan2 + 1) ** 0.5 / z) ** 1.5  # the ellipse is longer away from the middle of the picture
    information = sums * (look.r / tan2 / spread_px(middle)) ** 2
    on = np.count_nonzero((away < max(ON_PX, ON * outline)) & clear) / max(1, int(np.count_nonzero(look.seen)))
    scatter = scatter_px(axis, information, focal, tan2, look.r)
    return Cone(*look.pixel(axis), outline, radius, look, off, weights, gap, on, axis, information, scatter)


def scatter_px(axis, information, focal, tan2, most):
    """Standard deviations of the centre's u and of the radius, ``most`` at most."""
    x, _, z = axis.tolist()
    told, covariance = cv2.invert(information, flags=cv2.DECOMP_CHOLESKY)
    (xx, _, xz), _, (_, _, zz) = covariance.tolist()
    across = xx - 2 * x / z * xz + x * x / (z * z) * zz  # of x/z, times z²
    along = float(axis.dot(covariance).dot(axis))
    if not told or across < 0 or along < 0:
        return most, most
    return min(focal / z * across**0.5, most), min(focal * (along / tan2) ** 0.5, most)


def tukey(off: np.ndarray, limit: float) -> np.ndarray:
    """How much each counts that lies so far off: fully at 0, nothing from the limit on."""
    return np.square(np.maximum(1 - np.square(off / limit), 0.0))


def spread_px(middle_px: float) -> float:
    """Standard deviation of an edge, px, where half of them lie nearer than ``middle_px`` to the cone."""
    return TOGETHER * max(LEAST_SCATTER_PX, NORMAL * middle_px)


def _best_of_threes(rays, near, r):
    """Of the cones through three rays, the one that most rays lie on."""
    a, b, c = rays[TURN % len(rays)].transpose(1, 0, 2)
    e, f = b - a, c - a
    normal = e[:, [1, 2, 0]] * f[:, [2, 0, 1]] - e[:, [2, 0, 1]] * f[:, [1, 2, 0]]  # their cross product
    height = (normal * a).sum(1)
    axes = normal / np.where(np.abs(height) < 1e-12, 1e9, height)[:, None]  # two of the three may be the same ray
    tan2 = (axes * axes).sum(1) - 1
    tan2[~((tan2 > 1e-8) & (tan2 < 1))] = 1e-9
    on = np.abs(1 - axes @ rays.T) * (r / tan2)[:, None] < near
    return axes[on.sum(1).argmax()]

"""The cone: the rays from the camera that just touch a ball. Its axis goes through the ball's centre.

The picture of the ball is that cone cut by the image plane: an ellipse, whose middle is *not* where the centre is.
"""

from __future__ import annotations

from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import ArrayLike

from stereo_lab.detection.outline import RAYS, Look

ON_PX, ON = 0.5, 0.04  # px, or of the radius: so near to the cone an edge lies on it
LIMIT_PX, LIMIT = 0.25, 0.02  # px, or of the radius: beyond it an edge counts nothing (Tukey)
SCATTERED = 4.0  # but nearer than so many times the median, for a smeared rim scatters: 2.7 standard deviations
MOST_ROUNDS, STILL_PX = 12, 0.01  # until the cone stands still
LEAST_CLEAR = 0.3  # of the rays must show an edge
ONE_CURVE = 0.75  # of these must lie on one cone; else the best cone through three rays is the start
NORMAL, LEAST_SCATTER_PX = 1.4826, 0.02  # scatter of the edges by their median; the pixels alone bring so much
TOGETHER = 2.0  # neighbouring rays share pixels and err together: on rendered balls so much more than each alone
SHARPENED_PX = 0.12  # a camera's sharpening moves the whole rim in or out
TRIES = 80  # cones through three rays
TURN = np.random.default_rng(2).integers(2**31, size=(TRIES, 3))
TINY = 1e-11 * np.eye(3)


class Cone(NamedTuple):
    """A cone through the edges of a look; lengths are px, and what belongs to rays has the shape (RAYS,).

    ``u, v``: where its axis, and so the ball's centre, is seen. ``outline_px``: radius of a circle round it that covers as
    much of the picture as the ball. ``radius_px``: f·tan α, what the ball's radius would be in the middle of the picture.
    ``look``; ``off``: how far beyond its circle the edge lies on each ray; ``weights`` of these edges; ``gap``: how far
    beyond the cone they lie. ``axis``: a', shape (3,). ``information``: how well it is known, the inverse of its covariance,
    shape (3, 3), by how the edges scatter.
    """

    u: float
    v: float
    outline_px: float
    radius_px: float
    look: Look
    off: np.ndarray
    weights: np.ndarray
    gap: np.ndarray
    axis: np.ndarray
    information: np.ndarray

    @property
    def circle(self) -> tuple[float, float, float]:
        """(u, v, radius) of the next look."""
        return self.u, self.v, self.outline_px

    @property
    def on(self) -> float:
        """Part of the rays whose edge lies on the cone."""
        near = np.abs(self.gap) < max(ON_PX, ON * self.outline_px)
        return np.count_nonzero(near & (self.weights > 0)) / RAYS

    @property
    def sigmas_px(self) -> tuple[float, float]:
        """Standard deviations of each coordinate of the centre, and of the radius."""
        focal, (x, y, z) = self.look.camera[0][0, 0], self.axis.tolist()
        by_u = np.array([1, 0, -x / z]) * (focal / z)
        by_radius = self.axis * (focal / (x * x + y * y + z * z - 1) ** 0.5)
        covariance = cv2.invert(self.information, flags=cv2.DECOMP_CHOLESKY)[1]
        sigma, sigma_radius = (float(by @ covariance @ by) ** 0.5 for by in (by_u, by_radius))
        return sigma, float(np.hypot(sigma_radius, SHARPENED_PX))


def fit_cone(look: Look, edge: tuple[np.ndarray, np.ndarray]) -> Cone | None:
    """The cone a·ray = cos α through the edges of a look, or None.

    Divided by cos α it is linear: a'·ray = 1, and |a'|² − 1 = tan² α. Least squares, then again and again without
    what lies far off.
    """
    off, weights = edge
    clear = weights > 0
    count = np.count_nonzero(clear)
    if count < LEAST_CLEAR * RAYS:
        return None
    rays, used, near = look.rays(off), weights, max(0.6, 0.05 * look.r)
    and_one = np.concatenate([rays, np.ones((RAYS, 1))], 1)
    products = (rays[:, :, None] * and_one[:, None]).reshape(RAYS, 12)
    gap, least = np.zeros(RAYS), max(LIMIT_PX, LIMIT * look.r)
    for rounds in range(MOST_ROUNDS):
        before = gap
        sums = (used @ products).reshape(3, 4)
        normal = sums[:, :3] + TINY
        axis = cv2.solve(normal, sums[:, 3:], flags=cv2.DECOMP_CHOLESKY)[1][:, 0]
        x, y, z = axis.tolist()
        tan2 = x * x + y * y + z * z - 1
        if not tan2 > 1e-8 or z < 0.05:
            return None
        gap = (1 - rays @ axis) * (look.r / tan2)
        away = np.abs(gap)
        if rounds == 0 and np.count_nonzero(away[clear] < near) < ONE_CURVE * count:
            axis = _best_of_threes(rays[clear], near, look.r)
            away = np.abs(rays @ axis - 1) * (look.r / (axis @ axis - 1))
        if rounds and cv2.norm(gap, before, cv2.NORM_INF) < STILL_PX:
            break
        limit = max(least, SCATTERED * middle_of(away[clear]))
        used = weights * np.maximum(1 - (away / limit) ** 2, 0) ** 2
    u, v = look.pixel(axis)
    radius = float(look.camera[0][0, 0]) * tan2**0.5
    stretch = ((tan2 + 1) ** 0.5 / z) ** 1.5  # the ellipse is longer away from the middle of the picture
    information = normal * (look.r / tan2 / spread_px(middle_of(away[clear]))) ** 2
    return Cone(u, v, radius * stretch, radius, look, off, weights, gap, axis, information)


def middle_of(sizes: np.ndarray) -> float:
    """The median; np.median is slow on few numbers."""
    return float(np.sort(sizes)[len(sizes) // 2])


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


def tangent_circle(center_mm: ArrayLike, radius_mm: float, count: int = 60) -> np.ndarray:
    """Where the rays from the camera touch a ball, its centre in the camera's frame: points, shape (count, 3), mm."""
    center = np.asarray(center_mm, float)
    distance = np.linalg.norm(center)
    near = 1 - (radius_mm / distance) ** 2
    across = np.linalg.svd(center[None] / distance)[2][1:]
    angle = np.linspace(0, 2 * np.pi, count, endpoint=False)
    return near * center + radius_mm * np.sqrt(near) * np.column_stack([np.cos(angle), np.sin(angle)]) @ across

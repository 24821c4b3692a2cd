"""The curves that a ball's edge can be: a circle, an ellipse, and the exact one, a cone of rays.

The rays from the camera that just touch a ball form a cone. Its axis goes through the ball's centre. The
picture of the ball is that cone cut by the image plane: an ellipse, whose middle is *not* where the
ball's centre is.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import cv2
import numpy as np
from numpy.typing import ArrayLike

from stereo_lab.detection.model import Camera


@dataclass(frozen=True)
class Circle:
    """A circle; what a far, central ball looks like.

    Attributes
    ----------
    u, v, radius_px : float, its centre and radius
    """

    u: float
    v: float
    radius_px: float

    @property
    def center(self) -> tuple[float, float]:
        """(u, v)."""
        return self.u, self.v

    @property
    def ball_radius_px(self) -> float:
        """Radius of the ball: that of the circle."""
        return self.radius_px

    def residuals(self, points: np.ndarray) -> np.ndarray:
        """How far points, shape (N, 2), lie outside it, px."""
        return np.hypot(points[:, 0] - self.u, points[:, 1] - self.v) - self.radius_px


@dataclass(frozen=True)
class Ellipse:
    """An ellipse.

    Attributes
    ----------
    u, v : float, its middle
    a, b : float, semi-axes, px
    angle : float, direction of a, radians
    """

    u: float
    v: float
    a: float
    b: float
    angle: float

    @property
    def center(self) -> tuple[float, float]:
        """(u, v) of its middle, which is near the ball's centre."""
        return self.u, self.v

    @property
    def radius_px(self) -> float:
        """Radius of the circle of the same area."""
        return float(np.sqrt(self.a * self.b))

    @property
    def ball_radius_px(self) -> float:
        """Radius of the ball: the shorter semi-axis, for perspective stretches the other one."""
        return min(self.a, self.b)

    @property
    def aspect(self) -> float:
        """Longer axis by the shorter one."""
        return max(self.a, self.b) / max(min(self.a, self.b), 1e-9)

    def residuals(self, points: np.ndarray) -> np.ndarray:
        """How far points, shape (N, 2), lie outside it, px."""
        c, s = np.cos(self.angle), np.sin(self.angle)
        d = points - [self.u, self.v]
        along, across = (d @ [c, s]) / self.a, (d @ [-s, c]) / self.b
        return (np.hypot(along, across) - 1) * self.radius_px


@dataclass(frozen=True, eq=False)
class Cone:
    """A cone of rays, seen through one camera.

    Attributes
    ----------
    axis : ndarray, shape (3,), unit vector towards the ball's centre
    half_angle : float, radians
    camera : (matrix, distortion)
    offset : (x, y) of the window's first pixel in the picture
    u, v : float, where the axis meets the window, px
    """

    axis: np.ndarray
    half_angle: float
    camera: Camera
    offset: tuple[int, int]
    u: float
    v: float

    @property
    def center(self) -> tuple[float, float]:
        """(u, v) of the ball's centre, where the axis meets the picture."""
        return self.u, self.v

    @property
    def ball_radius_px(self) -> float:
        """Radius that the ball would have in the middle of the picture."""
        return float(self.camera[0][0, 0] * np.tan(self.half_angle))

    @property
    def radius_px(self) -> float:
        """Radius of the circle of about the same area as its picture."""
        return self.ball_radius_px / float(self.axis[2]) ** 1.5

    def residuals(self, points: np.ndarray) -> np.ndarray:
        """How far raw pixels, shape (N, 2), lie outside it, px."""
        return self.ray_residuals(to_rays(points, self.camera, self.offset))

    def ray_residuals(self, rays: np.ndarray) -> np.ndarray:
        """The same for unit vectors, shape (N, 3); in px."""
        cosine = rays @ self.axis
        slope = np.sqrt(np.maximum(1 - cosine**2, 0)) / cosine
        return (np.arctan(slope) - self.half_angle) * self.camera[0][0, 0] / float(self.axis[2]) ** 1.5


def to_rays(points: ArrayLike, camera: Camera, offset: tuple[int, int] = (0, 0)) -> np.ndarray:
    """Unit vectors from the camera through raw pixels, shape (N, 3)."""
    matrix, distortion = camera
    pixels = (np.asarray(points, float) + offset).reshape(-1, 1, 2)
    flat = cv2.undistortPoints(pixels, matrix, distortion).reshape(-1, 2)
    rays = np.column_stack([flat, np.ones(len(flat))])
    return rays / np.linalg.norm(rays, axis=1, keepdims=True)


def fit_cone(rays: np.ndarray, camera: Camera, offset: tuple[int, int], weights: np.ndarray) -> Cone | None:
    """The cone whose surface holds the rays: a·ray = cos α, solved for a / cos α by least squares."""
    scaled = _least_squares(rays, np.ones(len(rays)), weights)
    length = np.linalg.norm(scaled)
    if not length > 1:
        return None
    axis = scaled / length
    pixel = cv2.projectPoints(axis.reshape(1, 1, 3), np.zeros(3), np.zeros(3), *camera)[0].ravel()
    u, v = pixel - offset
    return Cone(axis, float(np.arccos(1 / length)), camera, offset, float(u), float(v))


def fit_circle(points: np.ndarray, weights: np.ndarray) -> Circle:
    """Least squares for x² + y² = 2·u·x + 2·v·y + (r² − u² − v²)."""
    middle = points.mean(0)
    local = points - middle
    terms = np.column_stack([2 * local, np.ones(len(points))])
    a, b, c = _least_squares(terms, (local**2).sum(1), weights)
    return Circle(float(a + middle[0]), float(b + middle[1]), float(np.sqrt(max(c + a * a + b * b, 1e-6))))


def fit_ellipse(points: np.ndarray) -> Ellipse | None:
    """The ellipse through points (``cv2.fitEllipseDirect``), or None where there is none."""
    if len(points) < 8:
        return None
    (u, v), (width, height), turn = cv2.fitEllipseDirect(points.astype(np.float32).reshape(-1, 1, 2))
    if not (np.isfinite([u, v, width, height]).all() and min(width, height) > 0):
        return None
    return Ellipse(float(u), float(v), width / 2, height / 2, float(np.radians(turn)))


def through(triples: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Centre and radius of the circles through three points each, shapes (N, 2) and (N,)."""
    a, b, c = triples[:, 0], triples[:, 1], triples[:, 2]
    ab, ac = b - a, c - a
    cross = 2 * (ab[:, 0] * ac[:, 1] - ab[:, 1] * ac[:, 0])
    with np.errstate(divide="ignore", invalid="ignore"):
        ux = (ac[:, 1] * (ab**2).sum(1) - ab[:, 1] * (ac**2).sum(1)) / cross
        uy = (ab[:, 0] * (ac**2).sum(1) - ac[:, 0] * (ab**2).sum(1)) / cross
    return a + np.stack([ux, uy], 1), np.hypot(ux, uy)


def best_circle(points: np.ndarray, tolerance: float) -> Circle | None:
    """The circle through three of the points that carries most of the others, or None."""
    centers, radii = through(points[_triples(len(points))])
    good = np.isfinite(radii)
    centers, radii = centers[good], radii[good]
    if not len(radii):
        return None
    distance = np.hypot(points[None, :, 0] - centers[:, :1], points[None, :, 1] - centers[:, 1:])
    k = int((np.abs(distance - radii[:, None]) < tolerance).sum(1).argmax())
    return Circle(float(centers[k, 0]), float(centers[k, 1]), float(radii[k]))


@cache
def _triples(count):
    """Sixty draws of three of so many points, always the same."""
    return np.random.default_rng(2).integers(count, size=(60, 3))


def trust(residuals: np.ndarray, tolerance: float) -> np.ndarray:
    """Tukey's biweight: far points count nothing."""
    middle = np.partition(np.abs(residuals), len(residuals) // 2)[len(residuals) // 2]
    scale = 1.4826 * middle * 3.5
    limit = min(max(scale, 0.25), max(3 * tolerance, 0.5))
    return np.maximum(1 - (residuals / limit) ** 2, 0)


def _least_squares(terms, values, weights):
    """Weighted least squares by the normal equations: three unknowns, well conditioned, often called."""
    weighted = terms * (weights**2)[:, None]
    normal = weighted.T @ terms
    return np.linalg.solve(normal + np.eye(3) * (1e-12 * np.trace(normal) + 1e-12), weighted.T @ values)


def tangent_circle(center_mm: ArrayLike, radius_mm: float, count: int = 60) -> np.ndarray:
    """Where the rays from the camera touch a ball: points on a circle, shape (count, 3), mm.

    Parameters
    ----------
    center_mm : (X, Y, Z) of the ball's centre in the camera's frame
    radius_mm : float, of the ball, less than the distance
    """
    center = np.asarray(center_mm, float)
    distance = np.linalg.norm(center)
    near = 1 - (radius_mm / distance) ** 2
    across = np.linalg.svd(center[None] / distance)[2][1:]
    angle = np.linspace(0, 2 * np.pi, count, endpoint=False)
    ring = np.cos(angle)[:, None] * across[0] + np.sin(angle)[:, None] * across[1]
    return near * center + radius_mm * np.sqrt(near) * ring

"""Lesson 03: from pixels to x and y on the bench.

The paper draws two straight lines through a few samples; they hold in one plane. The better way
turns and shifts the triangulated points on to the bench; it holds everywhere.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import ArrayLike

from stereo_lab.errors import StereoLabError

STEPS = 12
HUBER = 2.5  # standard deviations beyond which a sample counts less


@dataclass(frozen=True, eq=False)
class LineFit:
    """y = m·v + c (Eq. 1), and x = m'·u + c' (Eq. 2): millimetres from a rectified pixel.

    Attributes
    ----------
    slope_mm_per_px, offset_mm : float, m and c
    residuals_mm : ndarray, shape (N,), line minus sample
    """

    slope_mm_per_px: float
    offset_mm: float
    residuals_mm: np.ndarray

    @classmethod
    def fit(cls, pixels_N: ArrayLike, lengths_mm_N: ArrayLike) -> LineFit:
        """The least-squares line through samples (at least two different pixels)."""
        pixels, lengths = _same_length(pixels_N, lengths_mm_N, 2)
        if np.ptp(pixels) < 1e-9:
            raise StereoLabError("All samples lie on the same pixel: a line needs two different ones.")
        slope, offset = np.linalg.lstsq(np.column_stack([pixels, np.ones_like(pixels)]), lengths, rcond=None)[0]
        return cls(float(slope), float(offset), slope * pixels + offset - lengths)

    def predict(self, pixels: ArrayLike) -> float | np.ndarray:
        """Millimetres for one pixel or an array of them."""
        return self.slope_mm_per_px * np.asarray(pixels, float) + self.offset_mm


@dataclass(frozen=True, eq=False)
class RigidFit:
    """bench = rotation · camera + shift: points of the rectified left camera, put on the bench (mm).

    Attributes
    ----------
    rotation : ndarray, shape (3, 3)
    shift_mm : ndarray, shape (3,)
    residuals_mm : ndarray, shape (N, 3), fit minus sample
    """

    rotation: np.ndarray
    shift_mm: np.ndarray
    residuals_mm: np.ndarray

    @classmethod
    def fit(cls, camera_Nx3: ArrayLike, bench_Nx3: ArrayLike, sigma_Nx3: ArrayLike | None = None) -> RigidFit:
        """The turn and shift that bring samples together.

        Parameters
        ----------
        camera_Nx3 : triangulated points, mm, X right, Y down, Z forward
        bench_Nx3 : measured places, mm, x right, y up, z towards the cameras
        sigma_Nx3 : standard deviations of the camera points along X, Y, Z, mm; equal where not given.
            Far points know their depth badly, and so say little about it.

        Raises
        ------
        StereoLabError
            With fewer than three points, or with all of them on one line.
        """
        camera, bench = np.asarray(camera_Nx3, float), np.asarray(bench_Nx3, float)
        if camera.shape != bench.shape or camera.ndim != 2 or camera.shape[1] != 3 or len(camera) < 3:
            raise StereoLabError(
                f"A rigid fit needs three points or more, (N, 3); got {camera.shape} and {bench.shape}."
            )
        spread = np.linalg.svd(camera - camera.mean(0), compute_uv=False)
        if spread[1] < 1e-3 * spread[0]:
            raise StereoLabError("All samples lie on one line: move the ball sideways as well as in depth.")
        sigma = np.ones_like(camera) if sigma_Nx3 is None else np.asarray(sigma_Nx3, float)
        rotation, shift = _kabsch(camera, bench)
        for _ in range(STEPS):
            rotation, shift = _improve(camera, bench, sigma, rotation, shift)
        return cls(rotation, shift, camera @ rotation.T + shift - bench)

    def predict(self, camera_Nx3: ArrayLike) -> np.ndarray:
        """Points of the rectified left camera on the bench, shape (N, 3), mm."""
        return np.asarray(camera_Nx3, float).reshape(-1, 3) @ self.rotation.T + self.shift_mm


def _kabsch(camera, bench):
    """Turn and shift that bring two sets of points together, all counted alike (Kabsch)."""
    a, b = camera - camera.mean(0), bench - bench.mean(0)
    u, _, vt = np.linalg.svd(a.T @ b)
    mirror = np.diag([1, 1, np.sign(np.linalg.det(u @ vt))])
    rotation = (u @ mirror @ vt).T
    return rotation, bench.mean(0) - rotation @ camera.mean(0)


def _improve(camera, bench, sigma, rotation, shift):
    """One Gauss-Newton step with each point's own uncertainty; far outliers count less (Huber)."""
    turned = camera @ rotation.T
    away = bench - turned - shift
    normal, gradient = np.zeros((6, 6)), np.zeros(6)
    for point, error, s in zip(turned, away, sigma, strict=True):
        inverse = np.linalg.inv(rotation @ np.diag(s**2) @ rotation.T)
        far = np.sqrt(error @ inverse @ error / 3)
        weight = inverse * min(1.0, HUBER / max(far, 1e-12))
        x, y, z = point
        jacobian = np.hstack([np.array([[0, z, -y], [-z, 0, x], [y, -x, 0]]), np.eye(3)])
        normal += jacobian.T @ weight @ jacobian
        gradient += jacobian.T @ weight @ error
    step = np.linalg.solve(normal, gradient)
    return cv2.Rodrigues(step[:3])[0] @ rotation, shift + step[3:]


def _same_length(a, b, least):
    a, b = np.asarray(a, float).ravel(), np.asarray(b, float).ravel()
    if len(a) != len(b) or len(a) < least:
        raise StereoLabError(f"Expected {least} samples or more, and as many of each; got {len(a)} and {len(b)}.")
    if not (np.isfinite(a).all() and np.isfinite(b).all()):
        raise StereoLabError("A sample is not a finite number.")
    return a, b

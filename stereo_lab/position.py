"""Lesson 03: from pixels to x and y on the bench.

The paper draws two straight lines through a few samples; they hold in one plane. The better way
turns and shifts the triangulated points on to the bench; it holds everywhere.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import ArrayLike

from stereo_lab.common.vectors import as_numbers, as_points, cross, for_each
from stereo_lab.errors import StereoLabError

STEPS, HALVINGS = 50, 30  # of a fit, and of one step of it; most fits need five steps and no halving
STILL = 1e-6  # radians, and mm: a step so small ends a fit
TINY = 1e-9  # keeps the equations solvable where a fit needs every sample
HUBER = 2.5  # standard deviations beyond which a sample counts less
BESIDE = 3.0  # standard deviations: samples that lie beside one line by less, RMS, do not tell the turn about it
ANOTHER_UNIT = 0.2  # times as far from each other as the cameras see them: no ruler is that far off
TO_BENCH = np.diag([1.0, -1.0, -1.0])  # right, down, forward to x right, y up, and less depth
WRONG_WAY_DEG = 60.0  # no bench is turned more than this from there


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
        return self.slope_mm_per_px * as_numbers(pixels) + self.offset_mm


@dataclass(frozen=True, eq=False)
class RigidFit:
    """bench = scale · rotation · camera + shift: points of the rectified left camera, put on the bench (mm).

    Attributes
    ----------
    rotation : ndarray, shape (3, 3)
    shift_mm : ndarray, shape (3,)
    residuals_mm : ndarray, shape (N, 3), fit minus sample
    scale : float, 1 unless it was free
    gain : ndarray, shape (7, N, 3), by how much the fit's turn (radians), shift (mm) and scale change with each sample
    scale_sigma : float, standard deviation of the scale, by the samples' sigmas or by how much it changes when one sample
        after another is left out (the jackknife), whichever is more; 0 where it was held
    """

    rotation: np.ndarray
    shift_mm: np.ndarray
    residuals_mm: np.ndarray
    scale: float
    gain: np.ndarray
    scale_sigma: float = 0.0

    @classmethod
    def fit(
        cls, camera_Nx3: ArrayLike, bench_Nx3: ArrayLike, sigma_Nx3: ArrayLike | None = None, free_scale: bool = False
    ) -> RigidFit:
        """The turn and shift that bring samples together, and the scale if it is free.

        Parameters
        ----------
        camera_Nx3 : triangulated points, mm, X right, Y down, Z forward
        bench_Nx3 : measured places, mm, x right, y up, z towards the cameras
        sigma_Nx3 : standard deviations of the camera points along X, Y, Z, mm; equal where not given.
            Far points know their depth badly, and so say little about it.
        free_scale : bool; a chessboard whose squares were measured wrongly makes everything larger or smaller

        Raises
        ------
        StereoLabError
            With fewer than three points, something in them that is no number, all of them on one line as far as their
            sigmas tell, or sigmas that are not theirs.
        """
        camera, bench = as_numbers(camera_Nx3), as_numbers(bench_Nx3)
        if camera.shape != bench.shape or camera.ndim != 2 or camera.shape[1] != 3 or len(camera) < 3:
            raise StereoLabError(
                f"A rigid fit needs three points or more, (N, 3); got {camera.shape} and {bench.shape}."
            )
        if not (np.isfinite(camera).all() and np.isfinite(bench).all()):
            raise StereoLabError("A coordinate of a point is no finite number.")
        sigma = for_each(1.0 if sigma_Nx3 is None else sigma_Nx3, camera.shape)
        if not (np.isfinite(sigma).all() and (sigma > 0).all()):
            raise StereoLabError("Standard deviations of points must be numbers above zero.")
        if _on_one_line(camera, bench, 0 * sigma if sigma_Nx3 is None else sigma):
            raise StereoLabError(_why_on_one_line(camera, bench))
        samples, pose = (camera, bench, sigma), (*kabsch(camera, bench), 1.0)
        for _ in range(STEPS):
            gain, variance, away = _gain(*samples, *pose, free_scale)
            step = np.einsum("kni,ni->k", gain, away)
            pose, moved = _downhill(samples, pose, step)
            if not moved:
                break
        rotation, shift, scale = pose
        residuals = scale * camera @ rotation.T + shift - bench
        scale_sigma = 0.0
        if free_scale:
            by_samples = _jackknife(gain, _slopes(camera, rotation, scale), residuals)
            scale_sigma = float(max(np.sqrt(variance[6, 6]), by_samples))
        return cls(rotation, shift, residuals, float(scale), gain, scale_sigma)

    def predict(self, camera_Nx3: ArrayLike) -> np.ndarray:
        """Points of the rectified left camera on the bench, shape (N, 3), mm."""
        return self.scale * as_points(camera_Nx3, 3) @ self.rotation.T + self.shift_mm

    def slopes(self, camera_Nx3: ArrayLike) -> np.ndarray:
        """How places on the bench change with turn, shift and scale: shape (N, 3, 7), mm per radian, mm, 1."""
        return _slopes(as_points(camera_Nx3, 3), self.rotation, self.scale)


def is_wrong_way(rotation: np.ndarray) -> bool:
    """Whether after a turn from the rectified left camera on to the bench x is not to the right, y up and depth away, not even about.

    ``rotation``: shape (3, 3).
    """
    away = np.degrees(np.arccos(np.clip((np.trace(rotation @ TO_BENCH.T) - 1) / 2, -1, 1)))
    return bool(away > WRONG_WAY_DEG)


def kabsch(camera: np.ndarray, bench: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Turn (3, 3) and shift (3,) that bring two sets of points together, all counted alike (Kabsch)."""
    a, b = camera - camera.mean(0), bench - bench.mean(0)
    u, _, vt = np.linalg.svd(a.T @ b)
    mirror = np.diag([1, 1, np.sign(np.linalg.det(u @ vt))])
    rotation = (u @ mirror @ vt).T
    return rotation, bench.mean(0) - rotation @ camera.mean(0)


def _on_one_line(camera, bench, sigma):
    """Whether all samples lie on one line, or beside it by no more than nothing but their errors may put them."""
    along = np.linalg.svd(camera - camera.mean(0), full_matrices=False)[2][0]
    unsure = np.median(np.sqrt(sigma**2 @ (1 - along**2)))  # of each sample, across the line
    spreads = (np.linalg.svd(points - points.mean(0), compute_uv=False) for points in (camera, bench))
    return any(s[1] <= max(1e-3 * s[0], BESIDE * unsure * np.sqrt(len(camera))) for s in spreads)


def _why_on_one_line(camera, bench):
    """That all samples lie on one line, and what to do: places in metres lie so near together that they seem to."""
    seen, told = (np.linalg.norm(np.ptp(points, axis=0)) for points in (camera, bench))
    if 0 < told < ANOTHER_UNIT * seen:
        return (
            f"The measured places lie within {told:.2g} mm of each other, and the cameras see {seen:.0f} mm between them: are they in "
            "metres or centimetres? Write them in millimetres."
        )
    return "All samples lie on one line: move the ball sideways as well as in depth."


def _downhill(samples, pose, step):
    """A pose after a step, halved until the cost is no higher; and whether it moved. A full step may miss where one sample is wrong."""
    before = _cost(*samples, *pose)
    for _ in range(HALVINGS):
        if np.abs(step).max() < STILL:
            break
        rotation, shift, scale = pose
        stepped = cv2.Rodrigues(step[:3])[0] @ rotation, shift + step[3:6], scale + step[6]
        if _cost(*samples, *stepped) <= before:
            return stepped, True
        step = step / 2
    return pose, False


def _cost(camera, bench, sigma, rotation, shift, scale):
    """What a fit makes small: squares of how far off samples are, in standard deviations; far outliers count less (Huber)."""
    away = (bench - scale * camera @ rotation.T - shift) @ rotation / sigma
    far = np.sqrt((away**2).sum(1) / 3)
    return np.where(far < HUBER, far**2, HUBER * (2 * far - HUBER)).sum()


def _gain(camera, bench, sigma, rotation, shift, scale, free_scale):
    """One Gauss-Newton step with each point's own uncertainty; far outliers count less (Huber).

    Returns the step's gain, shape (7, N, 3); the covariance of the seven, (7, 7); and what is missing, (N, 3).
    """
    away = bench - scale * camera @ rotation.T - shift
    inverse = (rotation[None] / sigma[:, None] ** 2) @ rotation.T
    far = np.sqrt(np.einsum("ni,nij,nj->n", away, inverse, away) / 3)
    weight = inverse * np.minimum(1.0, HUBER / np.maximum(far, 1e-12))[:, None, None]
    slopes = _slopes(camera, rotation, scale)
    slopes[:, :, :3] = -cross(bench - shift)  # the weights turn with the fit: so the cost falls along every step
    pulls = slopes.transpose(0, 2, 1) @ weight
    free = slice(0, 7 if free_scale else 6)
    variance = np.zeros((7, 7))
    variance[free, free] = np.linalg.inv((pulls @ slopes).sum(0)[free, free])
    return np.einsum("kl,nli->kni", variance, pulls), variance, away


def _jackknife(gain, slopes, residuals):
    """Standard deviation of the scale as leaving out one sample after another shows it; to first order, without new fits."""
    count, leverage = len(residuals), slopes @ gain.transpose(1, 0, 2)
    alone = np.linalg.solve((1 + TINY) * np.eye(3) - leverage, residuals[:, :, None])[..., 0]  # off a fit without them
    moves = (gain[6] * alone).sum(1)
    return np.sqrt((count - 1) / count) * np.linalg.norm(moves - moves.mean())


def _slopes(camera, rotation, scale):
    turned = camera @ rotation.T
    slopes = np.zeros((len(turned), 3, 7))
    slopes[:, :, :3] = -scale * cross(turned)
    slopes[:, :, 3:6] = np.eye(3)
    slopes[:, :, 6] = turned
    return slopes


def _same_length(a, b, least):
    a, b = as_numbers(a).ravel(), as_numbers(b).ravel()
    if len(a) != len(b) or len(a) < least:
        raise StereoLabError(f"Expected {least} samples or more, and as many of each; got {len(a)} and {len(b)}.")
    if not (np.isfinite(a).all() and np.isfinite(b).all()):
        raise StereoLabError("A sample is not a finite number.")
    return a, b

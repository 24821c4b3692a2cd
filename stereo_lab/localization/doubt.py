"""How far off a place on the bench may be: by the cameras, by the ruler, by the pixels."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from stereo_lab.calibration import StereoCalibration
from stereo_lab.detection import Detection
from stereo_lab.position import RigidFit

CENTER_SIGMA_PX = 0.03  # how well a ball's centre is known, raw px, where no detection tells
RULER_SIGMA_MM = 0.6  # a ruler read to whole millimetres
SQUARE_SIGMA = 0.002  # of its length: a printer's squares, measured over the whole board with a ruler
MISFIT = 6.0  # standard deviations: samples that are off by so much even then tell of no scale
# Standard deviations by which the samples must contradict the squares to be believed; what the cameras doubt of themselves is
# not in these: on rigs whose squares are right they come to 0.5 to 3.1
SURE = 4.0
BY_HAND_MM = 1.5  # standard deviation of a place that is measured with a ruler held by hand
FAR_OFF = 6.0  # standard deviations: neither cameras nor ruler explain it


def fit_bench(camera_Nx3: np.ndarray, bench_Nx3: np.ndarray, sigma_Nx3: np.ndarray) -> RigidFit:
    """Turn and shift on to the bench; with a scale where the samples surely contradict the board's squares."""
    free = RigidFit.fit(camera_Nx3, bench_Nx3, sigma_Nx3, free_scale=True)
    held = RigidFit.fit(camera_Nx3, bench_Nx3, sigma_Nx3)
    misfit = np.linalg.norm(free.residuals_mm, axis=1) / np.linalg.norm(sigma_Nx3, axis=1)
    believed = abs(free.scale - 1) > SURE * free.scale_sigma and np.median(misfit) < MISFIT
    return free if believed else held


def far_off(names: Iterable[str], off_Nx3: Iterable[ArrayLike], sigmas: Iterable[ArrayLike | None]) -> dict[str, float]:
    """Places that neither cameras nor ruler explain: name -> how many standard deviations off, the worst first.

    Parameters
    ----------
    names : of the places
    off_Nx3 : how far off each is from where it was measured, along x, y and depth, mm
    sigmas : of each, the standard deviations that the cameras leave, mm; None where nobody knows
    """
    off = {
        name: float((np.abs(by) / np.hypot(sigma, BY_HAND_MM)).max())
        for name, by, sigma in zip(names, off_Nx3, sigmas, strict=True)
        if sigma is not None
    }
    return {name: off[name] for name in sorted(off, key=lambda name: -off[name]) if off[name] > FAR_OFF}


def stretch(calibration: StereoCalibration, ball: Detection, side: str) -> float:
    """Rectified pixels that one raw pixel becomes, at this ball of the "left" or "right" picture."""
    ends = calibration.rectify_points(np.array(ball.center_px) + [[-0.5, 0], [0.5, 0]], side)
    return float(np.linalg.norm(ends[1] - ends[0]))


def center_sigmas(calibration: StereoCalibration, left: Detection, right: Detection) -> list[float]:
    """Standard deviations of both centres, rectified px; detections of one's own making need not tell them."""
    return [
        stretch(calibration, ball, side) * (CENTER_SIGMA_PX if ball.sigma_px is None else ball.sigma_px)
        for ball, side in ((left, "left"), (right, "right"))
    ]


def pixel_sigma(
    calibration: StereoCalibration, points: np.ndarray, centers_Nx2: ArrayLike = (CENTER_SIGMA_PX, CENTER_SIGMA_PX)
) -> np.ndarray:
    """Standard deviations of triangulated points along X, Y, Z, shape (N, 3), mm, by the pixels' noise alone, as on the axis.

    Off the axis an error of depth moves a place along its ray, so X and Y are less sure; for the weights of a fit that
    makes no difference (measured on six rigs), for what is told of a place it does: :class:`Doubt` counts it.

    Parameters
    ----------
    calibration : StereoCalibration
    points : ndarray, shape (N, 3), mm, in the rectified left frame
    centers_Nx2 : array, standard deviations of the ball's centre in the left and the right picture, rectified px
    """
    left, right = np.asarray(centers_Nx2, float).T
    depth = points[:, 2]
    across = depth / calibration.focal_px * left
    along = calibration.depth_per_px(depth) * np.hypot(left, right)
    return np.stack([across, across, along], 1)


@dataclass(frozen=True, eq=False)
class Doubt:
    """What is uncertain, and how it carries over to places on the bench.

    The cameras' errors move the samples as well, and the fit on to the bench follows: near the samples it takes
    most of such an error back.

    Attributes
    ----------
    calibration, rigid : StereoCalibration and RigidFit
    covariance : ndarray, shape (32, 32), of the cameras' 24 unknowns, the square's length, and the fit's turn, shift and scale
    """

    calibration: StereoCalibration
    rigid: RigidFit
    covariance: np.ndarray

    @classmethod
    def of(cls, calibration: StereoCalibration, rigid: RigidFit, samples: np.ndarray, centers_Nx2: ArrayLike) -> Doubt:
        """The doubt of a fit on samples, shape (N, 3), mm, in the rectified left frame; see :func:`pixel_sigma`."""
        knows = np.zeros((25, 25))
        knows[:24, :24] = np.nan if calibration.covariance is None else calibration.covariance
        knows[24, 24] = SQUARE_SIGMA**2
        follows = -np.einsum("kni,nij->kj", rigid.gain, _bench_slopes(calibration, rigid, samples))
        pixels = _by_pixels(calibration, rigid, samples, centers_Nx2)
        own = pixels @ pixels.transpose(0, 2, 1) + RULER_SIGMA_MM**2 * np.eye(3)
        noise = np.einsum("kni,nij,lnj->kl", rigid.gain, own, rigid.gain)
        both = follows @ knows
        return cls(calibration, rigid, np.block([[knows, both.T], [both, both @ follows.T + noise]]))

    def sigma_mm(
        self, point_1x3: ArrayLike, centers_px: ArrayLike = (CENTER_SIGMA_PX, CENTER_SIGMA_PX)
    ) -> tuple[float, float, float] | None:
        """Standard deviations of x, y and depth of one point of the rectified left frame; None where not known.

        ``centers_px``: those of the ball's centre in the left and the right picture, rectified px.
        """
        if self.calibration.covariance is None:
            return None
        point = np.asarray(point_1x3, float).reshape(1, 3)
        slopes = np.concatenate([_bench_slopes(self.calibration, self.rigid, point), self.rigid.slopes(point)], -1)[0]
        pixels = _by_pixels(self.calibration, self.rigid, point, centers_px)[0]
        variance = ((slopes @ self.covariance) * slopes).sum(1) + (pixels * pixels).sum(1)
        return tuple(np.sqrt(variance).tolist())


def _bench_slopes(calibration, rigid, points):
    """How places on the bench change with the cameras' unknowns and the square's length: shape (N, 3, 25)."""
    by_length = points[:, :, None]
    return rigid.scale * rigid.rotation @ np.concatenate([calibration.place_slopes(points), by_length], -1)


def _by_pixels(calibration, rigid, points, centers_Nx2):
    """How far one standard deviation of u left, u right and both v moves places on the bench: columns, shape (N, 3, 3), mm."""
    left, right = np.broadcast_to(np.asarray(centers_Nx2, float), (len(points), 2)).T[:, :, None]
    ray = points * calibration.depth_per_px(points[:, 2:]) / points[:, 2:]  # by a pixel of disparity less
    across, down = points[:, 2:] / calibration.focal_px * np.eye(3)[:2, None]
    columns = (across - ray) * left, ray * right, down * np.hypot(left, right) / 2
    return rigid.rotation @ np.stack(columns, -1)

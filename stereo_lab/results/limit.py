"""The limit of depth: what the noise of the pictures allows, before anybody has detected or calibrated anything.

Two pictures of a place where nothing moved differ by the noise of the sensor, and by nothing else. Laid over a
ball's outline, that noise shifts it a little, even for the best of detectors. How much, in pixels, is sigma_d;
in millimetres it is Z² / (f·B)·sigma_d.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from stereo_lab.calibration import StereoCalibration
from stereo_lab.detection import Detection
from stereo_lab.localization.doubt import stretch
from stereo_lab.recording import Recording, Sample, StereoPair

SIDES = ("left", "right")
SETS = ("still", "evaluation", "track", "position", "depth")  # the first that is there; repeated shots are best
DIFFERENCES = 8  # each is read at many places, so a few will do
OUTLINE = 0.25  # of the radius, on both sides of the edge: what counts as outline,
OUTLINE_PX = 3  # and never less than the blur of a webcam
MAD = 1.4826  # standard deviation of a normal spread whose median size is 1
MEAN_SIZE = np.sqrt(2 / np.pi)  # mean size of a normal error whose standard deviation is 1


@dataclass(frozen=True, eq=False)
class SensorNoise:
    """Pictures of nothing but noise.

    Attributes
    ----------
    pictures : dict, side -> ndarray, int16, shape (K, height, width, 3): differences of two shots
    source : str, the set they were taken from
    """

    pictures: dict[str, np.ndarray]
    source: str


@dataclass(frozen=True, eq=False)
class DepthLimit:
    """What the noise of the pictures allows, pose by pose.

    Attributes
    ----------
    names : tuple of str, "set/name" of each pose
    sigma_d_px : ndarray, shape (N,), standard deviation of the disparity that the noise alone brings, rectified px
    sigma_mm : ndarray, shape (N,), what that makes of the depth: Z² / (f·B)·sigma_d
    source : str, the set that the noise was taken from
    """

    names: tuple[str, ...]
    sigma_d_px: np.ndarray
    sigma_mm: np.ndarray
    source: str

    @property
    def mean_mm(self) -> float:
        """The mean size of the depth error that the noise alone would leave."""
        return float(MEAN_SIZE * self.sigma_mm.mean())

    @classmethod
    def of(
        cls,
        calibration: StereoCalibration,
        noise: SensorNoise,
        samples: Sequence[Sample],
        balls: Sequence[Sequence[Detection]],
    ) -> DepthLimit:
        """The limit of each sample, whose ball was found at (left, right) in raw pixels."""
        both = zip(samples, balls, strict=True)
        sigma_d = np.array([disparity_sigma_px(calibration, s.pair, ball, noise) for s, ball in both])
        depths = np.array([s.reference.depth_mm for s in samples])
        names = tuple(s.pair.full_name for s in samples)
        return cls(names, sigma_d, calibration.depth_per_px(depths) * sigma_d, noise.source)


def sensor_noise(recording: Recording) -> SensorNoise | None:
    """The noise of both sensors, from shots that follow each other; None where no set has two pairs.

    In the set ``still`` nothing moves, but for the few times when the ball is set elsewhere. In other sets the ball
    moves and the room stands still: at any one place most differences are noise there too.
    """
    for name in SETS:
        pairs = [p for p in recording.pairs(name) if p.right_path] if name in recording.sets else []
        if len(pairs) > 1:
            return SensorNoise({side: _differences(pairs, side) for side in SIDES}, name)
    return None


def _differences(pairs, side):
    first = np.unique(np.linspace(0, len(pairs) - 2, DIFFERENCES).round().astype(int))
    shots = [[getattr(pairs[k + step], side).astype(np.int16) for step in (0, 1)] for k in first]
    return np.array([later - earlier for earlier, later in shots])


def center_sigma_px(image: np.ndarray, ball: Detection, differences_KxHxWx3: np.ndarray) -> float:
    """How far, in u, the noise shifts the outline of a ball: one standard deviation, raw px.

    A shift by one pixel changes each pixel of the outline by the picture's slope there. Least squares reads the
    shift back: the sum of slope times change, over the sum of slope squared. Here it reads pictures of pure noise.
    """
    rows, columns = _window(image.shape, ball)
    slope = cv2.Sobel(image[rows, columns].astype(np.float32), -1, 1, 0, ksize=1) / 2
    slope *= _outline(slope.shape, ball, (columns.start, rows.start))[..., None]
    if not slope.any():
        return float("inf")
    shifts = [cv2.matchTemplate(_around(n, rows, columns), slope, cv2.TM_CCORR) for n in differences_KxHxWx3]
    return float(MAD * np.median(np.abs(shifts)) / 2**0.5 / np.sum(slope**2))  # a difference holds two shots' noise


def _window(shape, ball):
    """The rows and columns of the picture that hold the whole outline."""
    reach = ball.radius_px + max(OUTLINE_PX, OUTLINE * ball.radius_px) + 2
    low, high = (
        np.floor(np.array(ball.center_px) - reach).astype(int),
        np.ceil(np.array(ball.center_px) + reach).astype(int) + 1,
    )
    return slice(max(low[1], 0), min(high[1], shape[0])), slice(max(low[0], 0), min(high[0], shape[1]))


def _outline(shape, ball, corner):
    v, u = np.mgrid[: shape[0], : shape[1]]
    off = np.hypot(u + corner[0] - ball.u, v + corner[1] - ball.v) - ball.radius_px
    return (np.abs(off) <= max(OUTLINE_PX, OUTLINE * ball.radius_px)).astype(np.float32)


def _around(noise, rows, columns):
    """The window and half its size more on every side: the same noise, met at many places."""
    grow_v, grow_u = (rows.stop - rows.start) // 2, (columns.stop - columns.start) // 2
    left, top = max(columns.start - grow_u, 0), max(rows.start - grow_v, 0)
    return noise[top : rows.stop + grow_v, left : columns.stop + grow_u].astype(np.float32)


def disparity_sigma_px(
    calibration: StereoCalibration, pair: StereoPair, balls: Sequence[Detection], noise: SensorNoise
) -> float:
    """sigma_d of one pose: what the noise of both pictures does to the disparity, rectified px."""
    both = zip(SIDES, (pair.left, pair.right), balls, strict=True)
    sigmas = [stretch(calibration, b, s) * center_sigma_px(image, b, noise.pictures[s]) for s, image, b in both]
    return math.hypot(*sigmas)

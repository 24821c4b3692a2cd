"""Our way: the edge of the ball to a fraction of a pixel, triangulated, turned and shifted on to the bench."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from stereo_lab.calibration import StereoCalibration
from stereo_lab.detection import BALL, BallColor, BallDetector, Detection
from stereo_lab.errors import CalibrationError
from stereo_lab.localization.doubt import RULER_SIGMA_MM, Doubt, fit_bench, pixel_sigma
from stereo_lab.localization.samples import check_enough
from stereo_lab.position import RigidFit
from stereo_lab.recording import Position, Recording, Sample

CANDIDATES = 8  # round things of each picture that are paired
ROW_PX, ROW_OF_RADIUS = 2.0, 0.1  # rows of the two centres may differ by this
SIZE = 0.15  # the ball's size may seem this much wrong, and a pixel more


@dataclass(frozen=True, eq=False)
class ConeWay:
    """Cones of rays that touch the ball, triangulated, and one rigid fit on every sample.

    Attributes
    ----------
    calibration : StereoCalibration
    detectors : (BallDetector, BallDetector), left and right
    rigid : RigidFit, from the rectified left camera on to the bench
    doubt : Doubt, how far off a place may be
    arm_depth_mm : float, depth of the arm's plane
    diameter_mm : float, of the ball
    """

    calibration: StereoCalibration
    detectors: tuple[BallDetector, BallDetector]
    rigid: RigidFit
    doubt: Doubt
    arm_depth_mm: float
    diameter_mm: float

    @classmethod
    def fit(
        cls,
        recording: Recording,
        samples: dict[str, list[Sample]],
        calibration: StereoCalibration,
        color: BallColor | str,
    ) -> tuple[ConeWay, np.ndarray, tuple[str, ...]]:
        """The way, its residuals (see :class:`Localizer`) and the samples it missed."""
        detector = lambda side: BallDetector(color, "cone", calibration.camera(side))
        detectors = detector("left"), detector("right")
        diameter, depth = recording.ball.diameter_mm, recording.arm_depth_mm
        named = {f"{set_name}/{s.pair.name}": s for set_name, chosen in samples.items() for s in chosen}
        found, places, missed = [], [], []
        for name, sample in named.items():
            pair = find_pair(calibration, detectors, diameter, sample.pair.left, sample.pair.right)
            if pair is None:
                missed.append(name)
                continue
            found.append(pair)
            measured = sample.measured
            places.append([measured.x_mm, measured.y_mm, depth - measured.depth_mm])
        if len(found) < 3:
            _check_rows(calibration, detectors, named.values())
        check_enough(found, missed, 3, recording)
        points = _triangulate(calibration, *zip(*found, strict=True))
        rigid = fit_bench(points, np.array(places), np.hypot(pixel_sigma(calibration, points), RULER_SIGMA_MM))
        doubt = Doubt.of(calibration, rigid, points)
        return (
            cls(calibration, detectors, rigid, doubt, depth, diameter),
            rigid.residuals_mm * [1, 1, -1],
            tuple(missed),
        )

    def detect(
        self, left: np.ndarray, right: np.ndarray, near: tuple[Detection, Detection] | None = None
    ) -> tuple[Detection, Detection] | None:
        """The same ball in both pictures, in raw pixels: first near its last place, then everywhere."""
        if near is not None:
            looks = zip(self.detectors, (left, right), near, strict=True)
            one, other = (detector.detect(image, before) for detector, image, before in looks)
            if one and other and _same_ball(self.calibration, self.diameter_mm, one, other):
                return one, other
        return find_pair(self.calibration, self.detectors, self.diameter_mm, left, right)

    def position(self, left: Detection, right: Detection) -> Position:
        """Two detections of one ball, triangulated and put on the bench."""
        return self.on_bench(_triangulate(self.calibration, [left], [right]))

    def on_bench(self, point_1x3: ArrayLike) -> Position:
        """A point of the rectified left camera, mm, as a place on the bench."""
        x, y, z = self.rigid.predict(point_1x3)[0]
        return Position(float(x), float(y), float(self.arm_depth_mm - z), self.doubt.sigma_mm(point_1x3))


def _triangulate(calibration, left, right):
    """Detections in raw pixels to points of the rectified left camera, shape (N, 3), mm."""
    centers = [[d.center_px for d in side] for side in (left, right)]
    return calibration.triangulate(
        calibration.rectify_points(centers[0], "left"), calibration.rectify_points(centers[1], "right")
    )


def find_pair(
    calibration: StereoCalibration,
    detectors: Sequence[BallDetector],
    diameter_mm: float,
    left: np.ndarray,
    right: np.ndarray,
) -> tuple[Detection, Detection] | None:
    """Of all round things in both pictures, the two that are one ball: same row, right size, best scores.

    Parameters
    ----------
    calibration : StereoCalibration
    detectors : (BallDetector, BallDetector), left and right
    diameter_mm : float, of the ball
    left, right : ndarray, raw pictures, BGR

    Returns
    -------
    (Detection, Detection) in raw pixels, or None
    """
    seen = [d.candidates(image, CANDIDATES) for d, image in zip(detectors, (left, right), strict=True)]
    pairs = [(a, b) for a in seen[0] for b in seen[1] if a.score + b.score >= 2 * BALL]
    pairs = [pair for pair in pairs if _same_ball(calibration, diameter_mm, *pair)]
    return max(pairs, key=lambda pair: pair[0].score * pair[1].score, default=None)


def _same_ball(calibration, diameter_mm, left, right):
    """The epipolar constraint, and the ball's own size, told by both cameras."""
    (_, row), (_, right_row) = calibration.rectify_centers(left, right)
    radius = max(left.radius_px, right.radius_px)
    if abs(row - right_row) > max(ROW_PX, ROW_OF_RADIUS * radius):
        return False
    point = _triangulate(calibration, [left], [right])[0]
    if not (np.isfinite(point).all() and point[2] > 0):
        return False
    distance = float(np.linalg.norm(point))
    for detection, side in ((left, "left"), (right, "right")):
        slope = detection.radius_px / calibration.camera(side)[0][0, 0]
        size = 2 * distance * slope / np.hypot(1, slope) / diameter_mm
        if abs(size - 1) > SIZE + 1.0 / detection.radius_px:
            return False
    return True


def _check_rows(calibration, detectors, samples):
    """Where both cameras see a ball, but on different rows, the calibration is of other cameras."""
    off = []
    for sample in samples:
        seen = [d.detect(image) for d, image in zip(detectors, (sample.pair.left, sample.pair.right), strict=True)]
        if None not in seen:
            (_, row), (_, right_row) = calibration.rectify_centers(*seen)
            off.append(abs(row - right_row))
    if len(off) >= 3 and np.median(off) > ROW_PX:
        raise CalibrationError(
            f"The calibration does not fit these pictures: both cameras see the ball, but on rows {np.median(off):.0f} px "
            "apart. It was made with other cameras, or they moved since. Calibrate again."
        )

"""Lesson 07: all of it together. Two pictures in, a place on the bench out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stereo_lab.calibration import StereoCalibration, calibrate_recording
from stereo_lab.depth import PaperDepth
from stereo_lab.detection import BALL, BallDetector
from stereo_lab.errors import CalibrationError, RecordingError, StereoLabError
from stereo_lab.position import LineFit, RigidFit
from stereo_lab.recording import Position

CENTER_SIGMA_PX = 0.03  # how well a ball's centre is known, for weighing samples
RULER_SIGMA_MM = 0.6  # a ruler read to whole millimetres
CANDIDATES = 8
ROW_PX, ROW_OF_RADIUS = 2.0, 0.1  # rows of the two centres may differ by this
SIZE = 0.15  # the ball's size may seem this much wrong, and a pixel more


@dataclass(frozen=True, eq=False)
class Localizer:
    """Finds the ball in a pair and tells where it is; made by :meth:`fit`.

    Attributes
    ----------
    calibration : StereoCalibration
    method : "cone" or "paper"
    residuals_mm : ndarray, shape (N, 3), x, y, depth of the samples fitted on
    missed : tuple of str, samples in which no ball was found
    """

    calibration: StereoCalibration
    method: str
    detectors: tuple
    models: tuple
    arm_depth_mm: float
    diameter_mm: float
    residuals_mm: np.ndarray
    missed: tuple = ()

    @classmethod
    def fit(cls, recording, method="cone", calibration=None, color=None):
        """Fit on the samples of a recording.

        Parameters
        ----------
        recording : Recording with the sets calibration, position and depth
        method : "cone": every position and depth sample, triangulated, and one rigid fit.
            "paper": Eq. 1 and 2 on the position samples with use "fit", Eq. 4 on the depth
            samples with use "fit", plain Hough.
        calibration : StereoCalibration, optional; else the recording's own, made once and cached
        color : BallColor, optional; else the recording's

        Raises
        ------
        StereoLabError
            If the ball is not found in enough samples.
        """
        calibration = calibration or calibrate_recording(recording)
        color = color or recording.ball.color
        if method == "paper":
            return _fit_paper(recording, calibration, BallDetector(color, "paper"))
        detectors = tuple(BallDetector(color, method, calibration.camera(side)) for side in ("left", "right"))
        return _fit_cone(recording, calibration, detectors)

    def locate(self, left, right, near=None):
        """Where the ball is, or None where no ball is seen by both cameras.

        Parameters
        ----------
        left, right : ndarray, raw pictures, BGR
        near : (Detection, Detection), optional; where to look first

        Returns
        -------
        Position or None
        """
        found = self.detect(left, right, near)
        return None if found is None else self.position(*found)

    def detect(self, left, right, near=None):
        """The same ball in both pictures, (Detection, Detection) in raw pixels (cone) or rectified ones (paper)."""
        self.calibration.check_size(left)
        self.calibration.check_size(right)
        if self.method == "paper":
            left, right = self.calibration.rectify(left, right)
            found = tuple(d.detect(image) for d, image in zip(self.detectors, (left, right), strict=True))
            return None if None in found else found
        if near is not None:
            found = tuple(
                d.detect(image, before) for d, image, before in zip(self.detectors, (left, right), near, strict=True)
            )
            if None not in found and _same_ball(self.calibration, self.diameter_mm, *found):
                return found
        return find_pair(self.calibration, self.detectors, self.diameter_mm, left, right)

    def position(self, left, right):
        """Two detections of one ball to a place on the bench."""
        if self.method == "paper":
            x_line, y_line, depth = self.models
            disparity = left.u - right.u
            if not disparity:
                return None
            return Position(
                *(float(v) for v in (x_line.predict(left.u), y_line.predict(left.v), depth.predict(disparity)))
            )
        return self.on_bench(_triangulate(self.calibration, [left], [right]))

    def on_bench(self, point_1x3):
        """A point of the rectified left camera, mm, as a place on the bench (cone method)."""
        x, y, z = self.models[0].predict(point_1x3)[0]
        return Position(float(x), float(y), float(self.arm_depth_mm - z))


def _triangulate(calibration, left, right):
    """Detections in raw pixels to points of the rectified left camera, shape (N, 3), mm."""
    pixels = [np.array([[d.u, d.v] for d in side]) for side in (left, right)]
    rectified = [calibration.rectify_points(p, side) for p, side in zip(pixels, ("left", "right"), strict=True)]
    return calibration.triangulate(*rectified)


def find_pair(calibration, detectors, diameter_mm, left, right):
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
    rows = [calibration.rectify_points([[d.u, d.v]], side)[0, 1] for d, side in ((left, "left"), (right, "right"))]
    radius = max(left.radius_px, right.radius_px)
    if abs(rows[0] - rows[1]) > max(ROW_PX, ROW_OF_RADIUS * radius):
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


def _fit_cone(recording, calibration, detectors):
    samples = [*recording.samples("position"), *recording.samples("depth")]
    found, places, missed = [], [], []
    for sample in samples:
        pair = find_pair(calibration, detectors, recording.ball.diameter_mm, sample.pair.left, sample.pair.right)
        if pair is None:
            missed.append(sample.pair.name)
            continue
        found.append(pair)
        measured = sample.measured
        places.append([measured.x_mm, measured.y_mm, recording.arm_depth_mm - measured.depth_mm])
    if len(found) < 3:
        _check_rows(calibration, detectors, samples)
    _enough(found, samples, 3, recording)
    points = _triangulate(calibration, *zip(*found, strict=True))
    fit = RigidFit.fit(points, np.array(places), _sigma(calibration, points))
    residuals = fit.residuals_mm * [1, 1, -1]
    return Localizer(
        calibration,
        "cone",
        detectors,
        (fit,),
        recording.arm_depth_mm,
        recording.ball.diameter_mm,
        residuals,
        tuple(missed),
    )


def _check_rows(calibration, detectors, samples):
    """Where both cameras see a ball, but on different rows, the calibration is of other cameras."""
    off = []
    for sample in samples:
        seen = [d.detect(image) for d, image in zip(detectors, (sample.pair.left, sample.pair.right), strict=True)]
        if None not in seen:
            rows = [
                calibration.rectify_points([[d.u, d.v]], s)[0, 1] for d, s in zip(seen, ("left", "right"), strict=True)
            ]
            off.append(abs(rows[0] - rows[1]))
    if len(off) >= 3 and np.median(off) > ROW_PX:
        raise CalibrationError(
            f"The calibration does not fit these pictures: both cameras see the ball, but on rows {np.median(off):.0f} px "
            "apart. It was made with other cameras, or they moved since. Calibrate again."
        )


def _sigma(calibration, points):
    """Standard deviations of triangulated points and of the ruler together, along X, Y, Z."""
    depth = points[:, 2]
    across = depth / calibration.focal_px * CENTER_SIGMA_PX
    along = calibration.depth_per_px(depth) * CENTER_SIGMA_PX * np.sqrt(2)
    return np.hypot(np.column_stack([across, across, along]), RULER_SIGMA_MM)


def _fit_paper(recording, calibration, detector):
    pixels, places, missed_plane = _paper_samples(recording, "position", calibration, detector)
    disparities, depths, missed_depth = _paper_samples(recording, "depth", calibration, detector)
    _enough(pixels, [*pixels, *missed_plane], 2, recording)
    _enough(disparities, [*disparities, *missed_depth], 3, recording)
    pixels, places, disparities, depths = (np.array(a) for a in (pixels, places, disparities, depths))
    x_line, y_line = LineFit.fit(pixels[:, 0], places[:, 0]), LineFit.fit(pixels[:, 1], places[:, 1])
    depth = PaperDepth.fit(disparities[:, 2], depths[:, 2])
    residuals = np.column_stack([x_line.residuals_mm, y_line.residuals_mm, np.zeros(len(pixels))])
    return Localizer(
        calibration, "paper", (detector, detector), (x_line, y_line, depth), recording.arm_depth_mm,
        recording.ball.diameter_mm, residuals, tuple(missed_plane + missed_depth),
    )  # fmt: skip


def _paper_samples(recording, set_name, calibration, detector):
    """(u, v, disparity) and (x, y, depth) of the samples to fit on, and the names of those without a ball."""
    seen, places, missed = [], [], []
    samples = [s for s in recording.samples(set_name) if s.use == "fit"]
    if not samples:
        raise RecordingError(f'{recording.path / set_name / "measured.csv"} has no row whose use is "fit".')
    for sample in samples:
        left, right = (detector.detect(image) for image in calibration.rectify(sample.pair.left, sample.pair.right))
        if left is None or right is None:
            missed.append(sample.pair.name)
            continue
        seen.append([left.u, left.v, left.u - right.u])
        places.append([sample.measured.x_mm, sample.measured.y_mm, sample.measured.depth_mm])
    return seen, places, missed


def _enough(found, samples, least, recording):
    if len(found) < least:
        raise StereoLabError(
            f"The {recording.ball.color} ball was found in {len(found)} of {len(samples)} measured pairs; "
            f"{least} are needed. Check ball color and diameter_mm in {recording.path / 'recording.json'}."
        )


def disparities(localizer, samples):
    """Disparity d = u_left − u_right, in rectified px, of the ball in each sample where it is found.

    Returns
    -------
    disparity_px_N : ndarray, shape (N,)
    found : list of the N samples
    """
    values, found = [], []
    for sample in samples:
        pair = localizer.detect(sample.pair.left, sample.pair.right)
        if pair is None:
            continue
        columns = [d.u for d in pair]
        if localizer.method != "paper":  # the paper's way looks at rectified pictures already
            both = zip(pair, ("left", "right"), strict=True)
            columns = [localizer.calibration.rectify_points([[d.u, d.v]], side)[0, 0] for d, side in both]
        values.append(columns[0] - columns[1])
        found.append(sample)
    return np.array(values), found

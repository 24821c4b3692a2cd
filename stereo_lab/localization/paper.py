"""The paper's way: Hough circles in the rectified pictures, two straight lines for x and y, Eq. 4 for depth."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from stereo_lab.calibration import StereoCalibration
from stereo_lab.depth import PaperDepth
from stereo_lab.detection import BallColor, BallDetector, Detection
from stereo_lab.errors import RecordingError, StereoLabError
from stereo_lab.localization.samples import check_enough
from stereo_lab.position import LineFit
from stereo_lab.recording import Position, Recording, Sample


@dataclass(frozen=True, eq=False)
class PaperWay:
    """Eq. 1, 2 and 4, fitted on the samples whose use is "fit".

    Attributes
    ----------
    calibration : StereoCalibration
    detector : BallDetector, for both cameras
    x_line, y_line : LineFit, Eq. 2 and 1: millimetres from the left rectified pixel
    depth : PaperDepth, Eq. 4: millimetres from the disparity
    stand_ins : tuple of str, "set/name": samples to check on that had to be fitted on, for too few of the others show the ball
    color_told, squares_told, table_told : str, always empty: Algorithm 1 takes the bounds that it is given, and Eq. 4 any length
    """

    calibration: StereoCalibration
    detector: BallDetector
    x_line: LineFit
    y_line: LineFit
    depth: PaperDepth
    stand_ins: tuple[str, ...] = ()
    color_told: ClassVar[str] = ""
    squares_told: ClassVar[str] = ""
    table_told: ClassVar[str] = ""

    @classmethod
    def fit(
        cls,
        recording: Recording,
        samples: dict[str, list[Sample]],
        calibration: StereoCalibration,
        color: BallColor | str,
    ) -> tuple[PaperWay, np.ndarray, tuple[str, ...]]:
        """The way, its residuals (see :class:`Localizer`) and the samples it missed."""
        detector = BallDetector(color, "paper")
        plane, places, missed, stood_in = _rectified_samples(
            recording, "position", samples, calibration, detector, LINE_NEEDS
        )
        check_enough(plane, missed, LINE_NEEDS, recording, detector.color)
        along, depths, lost, as_well = _rectified_samples(recording, "depth", samples, calibration, detector, EQ4_NEEDS)
        check_enough(along, lost, EQ4_NEEDS, recording, detector.color)
        x_line, y_line = LineFit.fit(plane[:, 0], places[:, 0]), LineFit.fit(plane[:, 1], places[:, 1])
        depth = PaperDepth.fit(along[:, 2], depths[:, 2])
        residuals = np.full((len(plane) + len(along), 3), np.nan)
        residuals[: len(plane), 0] = x_line.residuals_mm
        residuals[: len(plane), 1] = y_line.residuals_mm
        residuals[len(plane) :, 2] = depth.residuals_mm
        way = cls(calibration, detector, x_line, y_line, depth, (*stood_in, *as_well))
        return way, residuals, (*missed, *lost)

    def detect(
        self, left: np.ndarray, right: np.ndarray, near: tuple[Detection, Detection] | None = None
    ) -> tuple[Detection, Detection] | None:
        """The strongest circle of each rectified picture, in raw pixels; None where one has none."""
        found = _in_rectified(self.calibration, self.detector, left, right)
        return (
            None if found is None else tuple(_raw(self.calibration, *side) for side in zip(found, SIDES, strict=True))
        )

    def position(self, left: Detection, right: Detection) -> Position | None:
        """Eq. 1, 2 and 4; None where the disparity is not above zero: the circles are not one ball."""
        (u, v), (u_right, _) = self.calibration.rectify_centers(left, right)
        if u <= u_right:
            return None
        x, y, depth = self.x_line.predict(u), self.y_line.predict(v), self.depth.predict(u - u_right)
        return Position(float(x), float(y), float(depth))


SIDES = ("left", "right")
LINE_NEEDS, EQ4_NEEDS = 2, 3  # samples: as many as there are unknowns


def _in_rectified(calibration, detector, left, right):
    """Detections in the rectified pictures, or None."""
    found = tuple(detector.detect(image) for image in calibration.rectify(left, right))
    return None if None in found else found


def _raw(calibration, detection, side):
    """A detection in a rectified picture as one in the raw picture: its centre, and how far its rim is from there."""
    u, v, r = detection.u, detection.v, detection.radius_px
    points = [(u, v), (u + r, v), (u - r, v), (u, v + r), (u, v - r)]
    center, *rim = calibration.unrectify_points(points, side)
    radius = np.linalg.norm(rim - center, axis=1).mean()
    return replace(detection, u=float(center[0]), v=float(center[1]), radius_px=float(radius))


def _rectified_samples(recording, set_name, samples, calibration, detector, needed):
    """(u, v, disparity) in rectified px and (x, y, depth) in mm of the samples to fit on; the missed ones, and who stood in for them.

    Where so many are missed that fewer than needed are left, the samples to check on that are nearest in depth take their places:
    Eq. 4 has three unknowns and often just three samples.
    """
    spare = [s for s in samples[set_name] if s.use != "fit"]
    samples = [s for s in samples[set_name] if s.use == "fit"]
    if not samples:
        raise RecordingError(f'{recording.path / set_name / "measured.csv"} has no row whose use is "fit".')
    seen, places, missed, stand_ins, turned = [], [], [], [], 0
    queue = list(samples)
    while queue:
        sample = queue.pop(0)
        found = _in_rectified(calibration, detector, sample.pair.left, sample.pair.right)
        if found is None or found[0].u <= found[1].u:
            turned += found is not None
            missed.append(sample.pair.full_name)
            if spare and len(seen) + len(queue) < needed:
                depth = sample.measured.depth_mm
                queue.append(spare.pop(int(np.argmin([abs(s.measured.depth_mm - depth) for s in spare]))))
            continue
        if sample.use != "fit":
            stand_ins.append(sample.pair.full_name)
        left, right = found
        seen.append([left.u, left.v, left.u - right.u])
        places.append([sample.measured.x_mm, sample.measured.y_mm, sample.measured.depth_mm])
    tried = len(seen) + len(missed)
    if turned > tried / 2:
        raise StereoLabError(
            f"In {turned} of {tried} {set_name} samples the ball is farther left in the left picture than in the "
            "right one, as if it were behind the cameras. Are left and right swapped?"
        )
    return np.array(seen).reshape(-1, 3), np.array(places).reshape(-1, 3), missed, stand_ins

"""Our way: the edge of the ball to a fraction of a pixel, triangulated, turned and shifted on to the bench."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from stereo_lab.calibration import StereoCalibration
from stereo_lab.common.files import typed
from stereo_lab.detection import HUES, BallColor, BallDetector, Detection
from stereo_lab.errors import CalibrationError, StereoLabError
from stereo_lab.localization.background import backgrounds_of
from stereo_lab.localization.doubt import (
    CENTER_SIGMA_PX,
    RULER_SIGMA_MM,
    Doubt,
    center_sigmas,
    far_off,
    fit_bench,
    pixel_sigma,
)
from stereo_lab.localization.matching import ROW_PX, find_pair, size_errors, surer
from stereo_lab.localization.samples import check_enough
from stereo_lab.localization.sphere import one_sphere
from stereo_lab.position import RigidFit, is_wrong_way
from stereo_lab.recording import Position, Recording, Sample

FAR_OFF = 2.0  # times: no ruler and no board is so far off
MIRROR = 1, 1, -1


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
    stand_ins : tuple, always empty: every sample but those that are left out is fitted on
    color_told : str, what was gained by letting the ball mark its own colour; empty where its name is used
    mirrored : bool, whether the measured samples fit only as a mirror shows them; the fit is then of little use
    backgrounds : (ndarray, ndarray), what the cameras see where no ball is, by the samples; empty where these are too few
    """

    calibration: StereoCalibration
    detectors: tuple[BallDetector, BallDetector]
    rigid: RigidFit
    doubt: Doubt
    arm_depth_mm: float
    diameter_mm: float
    color_told: str = ""
    backgrounds: tuple[np.ndarray, ...] = ()
    mirrored: bool = False
    stand_ins: ClassVar[tuple[str, ...]] = ()

    @classmethod
    def fit(
        cls,
        recording: Recording,
        samples: dict[str, list[Sample]],
        calibration: StereoCalibration,
        color: BallColor | str,
    ) -> tuple[ConeWay, np.ndarray, tuple[str, ...], tuple[str, ...]]:
        """The way, its residuals (see :class:`Localizer`), the samples it missed, and those unlike the others."""
        diameter, depth = recording.ball.diameter_mm, recording.arm_depth_mm
        named = {s.pair.full_name: s for chosen in samples.values() for s in chosen}
        color = BallColor.named(color) if isinstance(color, str) else color
        backgrounds = backgrounds_of(list(named.values()), diameter)
        (detectors, seen), told = _look(calibration, color, diameter, named, backgrounds), ""
        if 0 < len(seen) < len(named) and color.name in HUES:
            detectors, seen, told = _marked_by_itself(calibration, color, diameter, named, backgrounds, detectors, seen)
        missed = [name for name in named if name not in seen]
        found = list(seen.values())
        measured = [named[name].measured for name in seen]
        places = np.array([[m.x_mm, m.y_mm, depth - m.depth_mm] for m in measured])
        if len(found) < 3:
            _check_rows(recording, calibration, detectors, named.values())
        check_enough(found, missed, 3, recording, color)
        points = _triangulate(calibration, *zip(*found, strict=True))
        centers = [center_sigmas(calibration, *pair) for pair in found]
        rigid, doubt, unlike = _fit(calibration, seen, points, centers, places)
        # All mirror images are one, but for a turn: which column it is the fit cannot tell
        mirrored = unlike != () and 2 * len(_fit(calibration, seen, points, centers, places * MIRROR)[2]) < len(unlike)
        way = cls(calibration, detectors, rigid, doubt, depth, diameter, told, backgrounds, mirrored)
        return way, rigid.residuals_mm * [1, 1, -1], tuple(missed), () if mirrored else unlike

    @property
    def squares_told(self) -> str:
        """That the samples contradict the squares' length, by how much and how surely; empty where they do not."""
        off = self.rigid.scale - 1
        if off == 0 or self._is_other_unit:
            return ""
        return (
            f"By the measured samples the board's squares are {abs(off):.2%} {'longer' if off > 0 else 'shorter'} than they "
            f"were said to be ({abs(off) / self.rigid.scale_sigma:.1f} standard deviations): all places are taken that much "
            f"{'larger' if off > 0 else 'smaller'}. Measure the whole board with a ruler. Is it right? Then a camera was turned "
            "after the boards were taken."
        )

    @property
    def table_told(self) -> str:
        """That the samples as a whole are in another unit, mirrored or turned; empty where they are not."""
        if self._is_other_unit:
            return (
                f"By the measured samples the board's squares are {self.rigid.scale:.2g} times as long as they were said to be. "
                "No ruler is that far off: is square_mm or measured.csv in another unit?"
            )
        if self.mirrored:
            return (
                "The measured samples fit only as a mirror shows them. In measured.csv, is the sign of one column turned round, "
                "or are two columns exchanged?"
            )
        if is_wrong_way(self.rigid.rotation):
            return (
                "By the measured samples x is not to the right, y not up, or depth not away from the cameras. In measured.csv, "
                "are the signs of two columns turned round, or all columns exchanged?"
            )
        return ""

    @property
    def _is_other_unit(self):
        return max(self.rigid.scale, 1 / self.rigid.scale) > FAR_OFF

    def detect(
        self, left: np.ndarray, right: np.ndarray, near: tuple[Detection, Detection] | None = None
    ) -> tuple[Detection, Detection] | None:
        """The same ball in both pictures, in raw pixels: first near its last place, then everywhere."""
        if near is not None:
            looks = tuple(zip(self.detectors, (left, right), strict=True))
            one, other = (detector.first(image, before) for (detector, image), before in zip(looks, near, strict=True))
            if one and other and size_errors(self.calibration, self.diameter_mm, one, other) is not None:
                return one_sphere(self.calibration, *surer(looks, (one, other), self.backgrounds))
        return find_pair(self.calibration, self.detectors, self.diameter_mm, left, right, self.backgrounds)

    def position(self, left: Detection, right: Detection) -> Position | None:
        """Two detections of one ball, triangulated and put on the bench; None where their rays do not meet before the cameras."""
        point = _triangulate(self.calibration, [left], [right])
        if not (np.isfinite(point).all() and point[0, 2] > 0):
            return None
        return self.on_bench(point, center_sigmas(self.calibration, left, right))

    def on_bench(self, point_1x3: ArrayLike, centers_px: ArrayLike = (CENTER_SIGMA_PX, CENTER_SIGMA_PX)) -> Position:
        """A point of the rectified left camera, mm, as a place on the bench; centres known so well, rectified px."""
        x, y, z = self.rigid.predict(point_1x3)[0]
        return Position(float(x), float(y), float(self.arm_depth_mm - z), self.doubt.sigma_mm(point_1x3, centers_px))


def _look(calibration, color, diameter, named, backgrounds):
    """A detector for each camera, and what they find: name of the sample -> (Detection, Detection)."""
    left, right = (BallDetector(color, "cone", calibration.camera(side)) for side in ("left", "right"))
    pairs = {
        n: find_pair(calibration, (left, right), diameter, s.pair.left, s.pair.right, backgrounds)
        for n, s in named.items()
    }
    return (left, right), {name: pair for name, pair in pairs.items() if pair is not None}


def _fit(calibration, names, points, centers, places):
    """Turn and shift on to the bench, their doubt, and the names of the samples unlike the others."""
    sigma = np.hypot(pixel_sigma(calibration, points, centers), RULER_SIGMA_MM)
    rigid = fit_bench(points, places, sigma)
    doubt = Doubt.of(calibration, rigid, points, centers)
    return rigid, doubt, tuple(far_off(names, rigid.residuals_mm, map(doubt.sigma_mm, points, centers)))


def _marked_by_itself(calibration, color, diameter, named, backgrounds, detectors, seen):
    """The same in the colour that the surest balls of a name mark, where more is found by it; and a sentence on it."""
    try:
        learned = BallColor.learned([s.pair.left for s in named.values()], color.name)
    except StereoLabError:  # no picture is sure enough
        return detectors, seen, ""
    again = _look(calibration, learned, diameter, named, backgrounds)
    if len(again[1]) <= len(seen):
        return detectors, seen, ""
    told = (
        f"By the name {color.name} the ball was found in {len(seen)} of {len(named)} measured pairs, by the colour that it "
        f"marked itself in its {len(learned.marks)} surest pictures in {len(again[1])}: that colour is used."
    )
    return *again, told


def _triangulate(calibration, left, right):
    """Detections in raw pixels to points of the rectified left camera, shape (N, 3), mm."""
    centers = [[d.center_px for d in side] for side in (left, right)]
    return calibration.triangulate(
        calibration.rectify_points(centers[0], "left"), calibration.rectify_points(centers[1], "right")
    )


def _check_rows(recording, calibration, detectors, samples):
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
            "apart. It was made with other cameras, they moved since, or left and right are exchanged in some sets. Is it this recording's "
            f"own? Then stereo-lab check {typed(recording.path)} says which. Else use the recording's own."
        )

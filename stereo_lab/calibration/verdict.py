"""What a calibration is worth, in words: a verdict, and the reasons in millimetres."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

from stereo_lab.calibration.cameras import StereoCalibration
from stereo_lab.recording import Board

FEW, ENOUGH = 6, 10  # pairs
GOOD_MM, USABLE_MM = 3.0, 10.0  # depth error that the calibration alone brings, at 1 m
TOGETHER = 3.0  # stereo RMS beyond this many times each camera's own
NARROW = 0.25  # part of the picture that the boards should cover
PLAUSIBLE_BASELINE_MM = (20.0, 1500.0)
PLAUSIBLE_SQUARE_MM = (4.0, 250.0)
UNITS = ((10.0, "centimetres"), (1000.0, "metres"), (25.4, "inches"), (0.1, "tenths of a millimetre"))


def verdict_on(
    calibration: StereoCalibration, board: Board, corners: Sequence[tuple[np.ndarray, np.ndarray]]
) -> tuple[str, tuple[str, ...]]:
    """What a calibration is worth.

    Parameters
    ----------
    calibration : StereoCalibration
    board : Board
    corners : list of (left, right) arrays of corners, shape (N, 2), of the pairs used

    Returns
    -------
    verdict : "good", "usable" or "poor"
    reasons : tuple of str, sentences; the first says what the calibration means in mm at 1 m
    """
    error_mm = depth_error_mm(calibration)
    grade = 0 if error_mm <= GOOD_MM else 1 if error_mm <= USABLE_MM else 2
    reasons = [f"The calibration alone brings a depth error of about {error_mm:.1f} mm at 1 m."]
    for worse, reason in _doubts(calibration, board, corners):
        grade = max(grade, worse)
        reasons.append(reason)
    return ("good", "usable", "poor")[grade], tuple(reasons)


def depth_error_mm(calibration: StereoCalibration, depth_mm: float = 1000.0) -> float:
    """Depth error at one distance: rows that miss each other, and lengths that are off.

    A rectified row error of |Δv| comes with a disparity error of the same size; a length error of p
    percent is a depth error of p percent.
    """
    row = calibration.heldout_vertical_error_px
    length = calibration.heldout_length_error_percent
    row = calibration.vertical_error_px if row is None else row
    length = calibration.focal_sigma_percent if length is None else length
    return float(np.hypot(calibration.depth_per_px(depth_mm) * row, depth_mm * length / 100))


def _doubts(calibration, board, corners):
    """(how bad 0..2, why) for everything that looks wrong."""
    used = len(calibration.used)
    if used < FEW:
        yield 2, f"Only {used} pairs could be used: take 15 to 25."
    elif used < ENOUGH:
        yield 1, f"Only {used} pairs could be used: with 15 to 25 the numbers hold better."
    lost = calibration.pairs - used
    if lost > calibration.pairs / 3:
        yield 1, f"{lost} of {calibration.pairs} pairs had to be dropped."
    alone = max(calibration.left_rms_px, calibration.right_rms_px)
    if calibration.rms_px > TOGETHER * alone and calibration.rms_px > 0.5:
        yield (
            2,
            (
                f"Each camera alone explains its boards to {alone:.2f} px, both together only to {calibration.rms_px:.2f} px: "
                "the pairs were not taken at the same moment, or the cameras moved between them."
            ),
        )
    elif calibration.rms_px > 1:
        yield 2, f"The reprojection error of {calibration.rms_px:.2f} px is high: blurred pictures or a bent board."
    if calibration.focal_sigma_percent > 0.5:
        yield (
            2 if calibration.focal_sigma_percent > 2 else 1,
            (
                f"The focal length is known to {calibration.focal_sigma_percent:.1f} % only: "
                "tilt the board more, to all sides, and hold some boards near."
            ),
        )
    covered = coverage(corners, calibration.image_size)
    if covered < NARROW:
        yield (
            2,
            (
                f"The boards cover {100 * covered:.0f} % of the picture, always in the same place: "
                "hold them in every corner as well."
            ),
        )
    yield from _unit_doubts(calibration, board)


def coverage(corners: Sequence[tuple[np.ndarray, np.ndarray]], image_size: tuple[int, int]) -> float:
    """Part of the picture, 0..1, that the boards cover; the worse camera counts."""
    parts = []
    for side in (0, 1):
        mask = np.zeros((60, 80), np.uint8)
        scale = np.array([80, 60]) / np.array(image_size)
        for pair in corners:
            hull = cv2.convexHull((pair[side] * scale).astype(np.float32).reshape(-1, 1, 2))
            cv2.fillConvexPoly(mask, hull.round().astype(np.int32), 1)
        parts.append(float(mask.mean()))
    return min(parts)


def _unit_doubts(calibration, board):
    """A square size in another unit than millimetres shows in the distance between the cameras."""
    low, high = PLAUSIBLE_BASELINE_MM
    square_low, square_high = PLAUSIBLE_SQUARE_MM
    baseline, square = calibration.baseline_mm, board.square_mm
    if low <= baseline <= high and square_low <= square <= square_high:
        return
    said = f"With squares of {square:g} mm the cameras would stand {baseline:.3g} mm apart, which cannot be."
    for factor, unit in UNITS:
        if low <= baseline * factor <= high and 8 <= square * factor <= 120:
            yield (
                2,
                f"{said} Is square_mm in {unit}? Then it is {square * factor:g} mm and they stand {baseline * factor:.0f} mm apart.",
            )
            return
    yield 2, f"{said} Measure a square with a ruler, in millimetres."

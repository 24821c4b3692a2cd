"""What a calibration is worth, in words: a verdict, and the reasons in millimetres."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from stereo_lab.calibration.advice import depth_map, where_to_hold
from stereo_lab.calibration.cameras import StereoCalibration
from stereo_lab.calibration.refusals import pixels_of
from stereo_lab.calibration.saved import GRADES
from stereo_lab.calibration.views import NOTHING_NEW
from stereo_lab.recording import Board
from stereo_lab.recording.bounds import PLAUSIBLE_BASELINE_MM, SQUARES_MM, told_mm, unit_asked

GOOD = 0.005  # of the distance: sigma of depth in nine tenths of the field,
USABLE = 0.01  # or in half of it
MISFIT = 3.0  # boards that differ so much more than their corners explain are not of one rig;
FEW = 8  # of fewer none can tell
ROUGH_PX = 1.0  # corners that miss so far are blurred, or the lens is another; in larger pictures by more
POSSIBLE_BASELINE_MM = (20.0, 1500.0)


def verdict_on(calibration: StereoCalibration, board: Board) -> tuple[str, tuple[str, ...]]:
    """What a calibration is worth.

    Parameters
    ----------
    calibration : StereoCalibration
    board : Board

    Returns
    -------
    verdict : "good", "usable" or "poor"
    reasons : tuple of str, sentences; the first says what the calibration means in mm
    """
    sigma = depth_map(calibration).sigma_mm
    if not len(sigma):
        nowhere = f"No place at {calibration.depth_mm:.0f} mm is seen by both cameras: turn them inwards."
        return "poor", (nowhere, *(reason for _, reason in _unit_doubts(calibration, board)))
    most, half = np.percentile(sigma, (90, 50))
    grade = 0 if most <= GOOD * calibration.depth_mm else 1 if half <= USABLE * calibration.depth_mm else 2
    reasons = [
        f"At {calibration.depth_mm / 1000:.1f} m the calibration alone makes depth uncertain by {most:.1f} mm or less "
        f"in nine tenths of what both cameras see (half of it: {half:.1f} mm)."
    ]
    for worse, reason in _doubts(calibration, board):
        grade = max(grade, worse)
        reasons.append(reason)
    if grade:
        reasons.append(
            f"To know more, hold more boards in these parts of the left picture: {', '.join(where_to_hold(calibration))}."
        )
    return GRADES[grade], tuple(reasons)


def _doubts(calibration: StereoCalibration, board: Board) -> Iterator[tuple[int, str]]:
    """(how bad 0..2, why) for everything that looks wrong."""
    copies = sum(why.endswith(NOTHING_NEW) for _, why in calibration.dropped)
    lost = calibration.pairs - len(calibration.used) - copies
    if lost > calibration.pairs / 3:
        yield 1, f"{lost} of {calibration.pairs} pairs had to be dropped."
    if calibration.rms_px > ROUGH_PX * pixels_of(calibration.image_size):
        yield (
            2,
            f"The reprojection error of {calibration.rms_px:.2f} px is high: blurred pictures, a crumpled board, "
            "or a lens so wide that this kit has no model for it.",
        )
    if len(calibration.used) < FEW:
        yield 0, f"{len(calibration.used)} boards cannot show whether a camera was moved between them: 15 to 25 can."
    elif calibration.misfit > MISFIT:
        yield (
            1,
            f"The boards contradict each other {calibration.misfit:.0f} times more than their corners explain: "
            "did the cameras move between the pictures, or did the board change its shape?",
        )
    yield from _unit_doubts(calibration, board)


def _unit_doubts(calibration, board):
    """A square size in another unit than millimetres shows in the distance between the cameras."""
    baseline, square = calibration.baseline_mm, board.square_mm
    is_square = SQUARES_MM[0] <= square <= SQUARES_MM[1]
    usual = PLAUSIBLE_BASELINE_MM[0] <= baseline <= PLAUSIBLE_BASELINE_MM[1]
    possible = POSSIBLE_BASELINE_MM[0] <= baseline <= POSSIBLE_BASELINE_MM[1]
    asked = unit_asked(baseline, square)
    if is_square and (usual or possible and not asked):
        return
    worse, how = (0, "which is unusual") if is_square and possible else (2, "which cannot be")
    said = f"With squares of {square:g} mm the cameras would stand {told_mm(baseline)} mm apart, {how}."
    yield worse, f"{said} {asked or 'Measure a square with a ruler, in millimetres.'}"

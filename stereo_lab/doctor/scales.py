"""Three scales of one recording, the squares of its board, its ball and its ruler: the one that differs from the other two."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stereo_lab.calibration import StereoCalibration
from stereo_lab.doctor.advice import ADVICE
from stereo_lab.doctor.findings import COSTS, NOTE, STOPS, Finding
from stereo_lab.doctor.numbers import FLAT_MM, UNITS, WRONG_MM, Mistake, place
from stereo_lab.errors import StereoLabError
from stereo_lab.localization.matching import SIZE
from stereo_lab.position import kabsch
from stereo_lab.recording import Recording
from stereo_lab.recording.bounds import PLAUSIBLE_BASELINE_MM, UNIT_NAMES, told_mm

SCALE_SURE = 3.5  # standard deviations
RULER_SCALE = 0.001  # to which a ruler is true
LEAST_NEAR = 4  # places that fit, for any scale to be told
SIZE_SURE, SIZE_PART = 4.0, 0.08  # a ball's size is told to this part of it: rims are soft
BALLS_MM = (10.0, 400.0)  # from a marble to a gymnastics ball
MOST_REACH = 4.0  # times the farthest place: no arm for this bench reaches farther
TWICE = np.log(3)  # a scale beyond three times is another unit


def squares_or_table(best: Mistake, by_ball: float, points: np.ndarray, table: np.ndarray, deep: np.ndarray) -> Mistake:
    """Another unit: of the squares where the ball's size is as wrong, of the table where it is right.

    Parameters
    ----------
    best : Mistake, the likeliest of the table
    by_ball : float, how many times larger the ball is said to be than the cameras tell
    points, table, deep : as :func:`stereo_lab.doctor.numbers.place` takes them
    """
    ball_off = abs(np.log(by_ball)) > TWICE
    if best.name in ("unit", "scale") and ball_off:
        placed = best.placed if best.name == "scale" else place(points, table, deep, free_scale=True)
        if abs(np.log(placed.scale)) > TWICE:  # the cameras' millimetres are none; the ruler's are
            placed = replace(place(placed.scale * points, table, deep), scale=placed.scale)
        return replace(best, name="scale", table=table, placed=placed)
    if best.name == "scale" and not ball_off and np.log(best.placed.scale) < -TWICE:
        unit = min(UNITS, key=lambda unit: abs(np.log(best.placed.scale * UNITS[unit])))
        mended = table * UNITS[unit]
        return replace(best, name="unit", what=unit, table=mended, placed=place(points, mended, deep))
    return best


def scale_by_ruler(points: np.ndarray, best: Mistake, deep: np.ndarray, known: float) -> tuple[float, float]:
    """How many times larger the measured places are than the told ones, and its standard deviation.

    Parameters
    ----------
    points, deep : as :func:`stereo_lab.doctor.numbers.place` takes them
    best : Mistake, with the table
    known : float, the part of themselves to which the cameras know depths
    """
    near = best.placed.off < WRONG_MM
    if near.sum() < LEAST_NEAR:
        return best.placed.scale, np.inf
    a, bench = points[near], (best.table * [1, 1, -1])[near]
    rotation, _ = kabsch(a, bench)
    turned, wanted = (a - a.mean(0)) @ rotation.T, bench - bench.mean(0)
    weight = np.stack([np.ones(near.sum()), np.ones(near.sum()), 1 / deep[near]], 1)
    spread = ((turned * weight) ** 2).sum()
    scale = ((wanted * turned) * weight**2).sum() / spread
    rest = np.sqrt((((wanted - scale * turned) * weight) ** 2).sum() / max(3 * near.sum() - 7, 1))
    return float(scale), float(np.linalg.norm([max(rest, 0.4) / np.sqrt(spread), RULER_SCALE, known]))


def scales_told(
    recording: Recording,
    calibration: StereoCalibration,
    by_ball: float,
    ball_sigma: float,
    by_ruler: float,
    sigma: float,
    best: Mistake,
) -> list[Finding]:
    """What is said where the squares, the ball or the ruler have another scale than the other two.

    Parameters
    ----------
    recording : Recording
    calibration : StereoCalibration
    by_ball, by_ruler : float, how many times larger things are said to be than the cameras tell
    ball_sigma, sigma : float, their standard deviations
    best : Mistake, the likeliest of the table
    """
    baseline, square = calibration.baseline_mm, recording.board.square_mm
    is_plausible = PLAUSIBLE_BASELINE_MM[0] < baseline < PLAUSIBLE_BASELINE_MM[1]
    ruler_off = abs(np.log(by_ruler)) > np.log1p(SCALE_SURE * sigma) if np.isfinite(sigma) else best.name == "scale"
    ball_off = abs(np.log(by_ball)) > np.log1p(max(SIZE_SURE * ball_sigma, SIZE_PART))
    if abs(np.log(by_ruler)) > TWICE and ruler_off:
        if is_plausible and not ball_off:
            return []  # the ruler's unit: said of the table
        if is_plausible and (both := _ball_and_table_in(recording.ball.diameter_mm, by_ball, by_ruler)):
            says = (
                f"With squares of {square:g} mm the cameras stand {told_mm(baseline)} mm apart, as they may. But the measured places, "
                f"and diameter_mm, are {told_mm(1 / by_ruler)} times too small: they are in {both}."
            )
            does = abs(1 - 1 / by_ruler) * calibration.depth_mm
            return [Finding("unit", says, ADVICE["ball_and_table_unit"], (), does)]
        unit = _unit_of(by_ruler)
        which = "square_mm is" if ball_off else "square_mm and diameter_mm are"
        so = f"{which} in {unit}" if unit else f"the squares are {square * by_ruler:.1f} mm wide"
        says = (
            f"With squares of {square:g} mm the cameras stand {told_mm(baseline)} mm apart, and all measured places are "
            f"{told_mm(by_ruler)} times as far from each other as the cameras tell: {so}."
        )
        return [Finding("square_unit", says, ADVICE["square_unit"], (), abs(1 - 1 / by_ruler) * calibration.depth_mm)]
    if ruler_off and best.name in ("as_is", "scale"):
        does = abs(1 - 1 / by_ruler) * calibration.depth_mm
        percent = 100 * (by_ruler - 1)
        agree = "The ball's size agrees. " if abs(by_ball / by_ruler - 1) < SIZE_PART / 2 and ball_off else ""
        says = (
            f"The measured places lie {abs(percent):.1f} % {'farther apart' if percent > 0 else 'nearer together'} than the cameras tell: the squares are "
            f"{square * by_ruler:.2f} mm and not {square:g}. {agree}Or the ruler is wrong by as much."
        )
        return [Finding("square_scale", says, ADVICE["square_scale"], (), does)]
    unit = _unit_of(by_ball)
    if ball_off and unit and not is_plausible:
        says = (
            f"With squares of {square:g} mm the cameras stand {told_mm(baseline)} mm apart, and the ball looks "
            f"{recording.ball.diameter_mm / by_ball:.1f} mm wide: square_mm is in {unit}, and the measured places as well."
        )
        return [Finding("square_unit", says, ADVICE["square_unit"], (), abs(1 - 1 / by_ball) * calibration.depth_mm)]
    if (
        ball_off and (best.placed.off < WRONG_MM).sum() >= LEAST_NEAR
    ):  # also by cameras of which nobody tells how exact they are
        says = f"The ball looks {recording.ball.diameter_mm / by_ball:.1f} mm wide, and recording.json says {recording.ball.diameter_mm:g}."
        lost = abs(by_ball - 1) > SIZE  # then no two balls are taken for one any more
        return [
            Finding("ball_diameter", says, ADVICE["ball_diameter"], (), None if lost else 0.0, STOPS if lost else NOTE)
        ]
    return []


def _ball_and_table_in(diameter_mm, by_ball, by_ruler):
    """The unit in which ball and table were told, where the ball would be none in mm and is one in that unit; else nothing."""
    low, high = BALLS_MM
    return _unit_of(1 / by_ruler) if not low < diameter_mm < high and low < diameter_mm / by_ball < high else ""


def _unit_of(scale):
    """Of :data:`UNIT_NAMES` the one that a scale is, as exactly as a size is told; nothing where it is none."""
    factor = min(UNIT_NAMES, key=lambda factor: abs(np.log(scale / factor)))
    return UNIT_NAMES[factor] if abs(np.log(scale / factor)) < np.log1p(SIZE_PART) else ""


def arm_told(recording: Recording) -> list[Finding]:
    """An arm so short that it reaches none of the places in its own plane, and that would in another unit."""
    try:
        places = [] if recording.arm_is_shipped else [s.measured for s in recording.samples("position")]
    except StereoLabError:  # told elsewhere
        return []
    reach = recording.arm.l1_mm + recording.arm.l2_mm
    far = np.hypot([place.x_mm for place in places], [place.y_mm for place in places])
    unit = next(
        (f for f in UNIT_NAMES if f > 1 and len(far) and np.median(far) < f * reach < MOST_REACH * far.max()), None
    )
    if unit is None or far.min() < reach:
        return []
    says = (
        f"The arm of recording.json reaches {told_mm(reach)} mm, and none of the {len(far)} places of position, which lie in its plane, is so near. "
        f"Is it in {UNIT_NAMES[unit]}? Then it reaches {told_mm(unit * reach)} mm."
    )
    return [Finding("arm_unit", says, ADVICE["arm_unit"], severity=COSTS)]


def plane_told(recording: Recording) -> list[Finding]:
    """Places of position that lie in no plane, or not in that of the arm: an arm follows a ball in its own plane alone.

    Where it was registered it is known where it stands, and depth_mm matters little.
    """
    try:
        depths = [s.measured.depth_mm for s in recording.samples("position")]
    except StereoLabError:  # told elsewhere
        return []
    if not depths:
        return []
    if np.ptp(depths) > FLAT_MM:
        says = (
            f"The places of position lie {told_mm(min(depths))} to {told_mm(max(depths))} mm deep. They are to lie in one plane, "
            "that of the arm: the paper's two straight lines hold nowhere else."
        )
        return [Finding("not_flat", says, ADVICE["not_flat"])]
    plane, told = float(np.median(depths)), recording.arm_depth_mm
    if recording.arm_is_shipped or abs(plane - told) < max(FLAT_MM, recording.ball.diameter_mm / 2):
        return []
    says = f"The places of position lie {told_mm(plane)} mm deep, and recording.json has the arm's plane at {told_mm(told)} mm."
    if plane > 0 and (unit := _unit_of(plane / told)):
        says += f" Is depth_mm of the arm in {unit}?"
    if recording.registration_path.is_file():
        return [Finding("arm_plane", says, ADVICE["arm_plane"])]
    return [Finding("arm_plane", f"{says} The arm follows no ball there.", ADVICE["arm_plane"], severity=COSTS)]

"""What the boards tell of the two cameras: what is wrong with the pairs, where the cameras stand, and what is left in doubt."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from stereo_lab.calibration import StereoCalibration, calibrate_views, depth_map, where_to_hold
from stereo_lab.calibration.bundle import Rig, matrices
from stereo_lab.calibration.refusals import check_two_cameras
from stereo_lab.calibration.solver import robust_sigma
from stereo_lab.doctor.advice import ADVICE
from stereo_lab.doctor.boards import Boards, camera_alone
from stereo_lab.doctor.findings import NOTE, STOPS, Evidence, Finding
from stereo_lab.doctor.known import Coverage, apart_mm, coverage_of, doubt_mm
from stereo_lab.doctor.pairing import mend_pairs, turned_round
from stereo_lab.doctor.pictures import Look
from stereo_lab.doctor.upright import one_above, upside_down
from stereo_lab.errors import CalibrationError, StereoLabError
from stereo_lab.recording.bounds import PLAUSIBLE_BASELINE_MM, SQUARES_MM, told_mm, unit_asked, units_of_squares

FEWEST = 4  # boards from which cameras can be told
# Sigmas of a corner, as disparity: what good boards leave in doubt of depth, and what too few do
GOOD_DOUBT, IN_DOUBT = 4.0, 8.0
NOISY_PX, WIDE_EDGE_PX = 0.3, 1.8  # corners that scatter so much, or edges so wide, are blurred
SHARP_PX = 0.05  # sigma of sharp corners
FEW, FLAT_DEG, ONE_PLACE, SMALL = 8, 25.0, 0.45, 0.12  # boards, degrees, part of the cells, part of the picture's width
GOOD = Coverage(20, 60.0, 0.75, 0.22, (1.3, 1.3), 0.1)  # of a recording that leaves little in doubt
BENT_MM = 1.5
UNEVEN = 2.5  # times the median doubt
WRONG_PX = 1.0  # corners that are left out by less are worth no word
APART = "not_together", "stabilised"  # all pairs are concerned, and no calibration is told


@dataclass(frozen=True, eq=False)
class Cameras:
    """What the boards tell.

    Attributes
    ----------
    findings : list of Finding
    states : tuple of StereoCalibration, with everything mended that could be: one, or two of cameras that moved, the later first;
        empty where none comes out
    noise_mm : float, how much of the calibration's doubt comes from corners that scatter
    undo : (left, right), what must be done to the pictures to be as they should: "", "mirror" or "turn"
    swapped : bool, whether left and right were exchanged to come to it
    size : (width, height) of the boards' pictures, px; None where there are none
    """

    findings: list[Finding]
    states: tuple[StereoCalibration, ...] = ()
    noise_mm: float = 0.0
    undo: tuple[str, str] = ("", "")
    swapped: bool = False
    size: tuple[int, int] | None = None


def check_cameras(boards: Boards, names: Sequence[str], looks: dict[tuple[str, str], Look], depth_mm: float) -> Cameras:
    """Look at the boards of a recording.

    Parameters
    ----------
    boards : Boards, of all pairs in which a camera sees one
    names : of all pairs
    looks : of every picture
    depth_mm : float, for which everything is told
    """
    if boards.both.sum() < FEWEST:
        return Cameras([_too_few(boards, names)])
    try:
        check_two_cameras([view for view in boards.views if view.seen_by_both])
    except CalibrationError as error:
        return Cameras(_refused(error, None, []))
    mends, together = mend_pairs(boards)
    findings, swapped = [], False
    if together is not None and turned_round(together.solution.rig):
        swapped, boards = True, replace(boards, left=boards.right, right=boards.left)
        says = "The camera called right stands to the left of the other."
        findings.append(Finding("sides_swapped", says, ADVICE["sides_swapped"], severity=STOPS))
        mends, together = mend_pairs(boards)
    mends, undo, upset = upside_down(mends, together)
    calibrations = [_calibrated(b, names, depth_mm) for b in (boards, *(m.boards for m in mends))]
    findings += [] if upset is None else [upset]
    findings += _costs(mends, calibrations, depth_mm, upset is not None)
    last, refused = calibrations[-1]
    covers = _coverage(boards, looks)
    if upset is not None:
        return Cameras(findings)
    if last is None and not findings and together is not None and refused.fault == "one_above_the_other":
        return Cameras([one_above(together.solution.rig, boards.size)])
    if last is None:
        return Cameras(findings + _refused(refused, covers, findings))
    if covers is not None and max(covers.edges_px) > WIDE_EDGE_PX:
        findings = [f for f in findings if f.name not in APART or f.severity == STOPS]  # blur explains it
    if any(finding.name in APART for finding in findings):
        return Cameras(findings)
    states = _states(last, mends)
    noise = _by_noise(last, together)
    if covers is not None and max(covers.edges_px) > WIDE_EDGE_PX:  # what looks like small changes may be blur as well
        noise = 1.01 * max([noise, *(f.does_mm for f in findings if f.does_mm is not None)])
    findings += (
        [replace(f, evidence=_spread(boards)) for f in _doubts(last, covers, together, noise)]
        + _board(last, boards)
        + _corners(last)
    )
    return Cameras(findings, states, noise, undo, swapped)


def _too_few(boards, names):
    says = f"The board was found by both cameras in {int(boards.both.sum())} of {len(names)} pairs; {FEWEST} are the least."
    missing = tuple(f"calibration/{n}" for n in names if n not in set(np.array(boards.names, object)[boards.both]))
    name = "too_few_pairs" if len(missing) < len(names) / 2 else "board_not_found"
    return Finding(name, says, ADVICE[name], missing, severity=STOPS)


def _calibrated(boards, names, depth_mm):
    """The calibration that the course would make of these boards, and why none if none."""
    try:
        return calibrate_views(boards.views, boards.board, boards.size, names, (), depth_mm), None
    except CalibrationError as error:
        return None, error
    except np.linalg.LinAlgError as error:
        return None, CalibrationError(str(error))


def _costs(mends, calibrations, depth_mm, upset):
    """Findings of the mends, each with how far it moves places: the calibration before it against the one after it."""
    findings = []
    for number, mend in enumerate(mends):
        before, after = calibrations[number][0], calibrations[number + 1][0]
        does, severity = None, STOPS
        rigs = mend.rigs or (() if after is None else (after.rig,))
        if before is not None and rigs:  # of a change the worse side: who knows when the balls were taken
            does = max(apart_mm(before.rig, rig, mend.boards.size, depth_mm) for rig in rigs)
            severity = NOTE
            if mend.name in APART:
                does = doubt_mm(before)
        elif upset:
            severity = NOTE
        files = tuple(f"calibration/{name}" for name in mend.pairs)
        findings.append(Finding(mend.name, mend.says, ADVICE[mend.name], files, does, severity, mend.evidence))
    return findings


def _states(calibration, mends):
    """The calibration for each state of the cameras, the last one first."""
    moved = [mend.rigs for mend in mends if mend.rigs]
    return tuple(with_rig(calibration, rig) for rig in reversed(moved[-1])) if moved else (calibration,)


def with_rig(calibration: StereoCalibration, rig: Rig) -> StereoCalibration:
    """The same calibration of cameras that stand, or look, otherwise."""
    (left, bent), (right, bent_right) = matrices(rig.left), matrices(rig.right)
    return replace(
        calibration, left_matrix=left, left_distortion=bent, right_matrix=right, right_distortion=bent_right,
        rotation=rig.rotation, translation_mm=rig.translation,
    )  # fmt: skip


def _coverage(boards, looks):
    try:
        left, right = (camera_alone(seen, boards.board, boards.size) for seen in (boards.left, boards.right))
        return coverage_of(boards, left, right, looks)
    except (StereoLabError, ValueError):
        return None


def _refused(why, covers, findings):
    """Findings where no calibration comes out, and nothing found so far says why."""
    if any(f.severity == STOPS for f in findings):
        return []
    if why.fault:
        return [Finding(why.fault, str(why), ADVICE[why.fault], severity=STOPS)]
    lacks = _lacks(covers) if covers is not None else []
    name, text = lacks[0][1:] if lacks else ("not_together", str(why))
    return [Finding(name, text, ADVICE[name], severity=STOPS)]


def _lacks(covers: Coverage) -> list[tuple[float, str, str]]:
    """(how much, name, sentence) of what the boards lack, the worst first."""
    lacks = []
    widest = max(covers.edges_px)
    if covers.sigma_px > NOISY_PX or widest > WIDE_EDGE_PX:
        one = min(covers.edges_px) < WIDE_EDGE_PX < widest
        whose = f"The {('left', 'right')[covers.edges_px.index(widest)]} camera's" if one else "The"
        lacks.append((
            max(covers.sigma_px / NOISY_PX, widest / WIDE_EDGE_PX) + 1, "blur",
            f"{whose} pictures are blurred: corners scatter by {covers.sigma_px:.2f} px, and edges are {2 * widest:.1f} px wide.",
        ))  # fmt: skip
    if covers.count < FEW:
        lacks.append(
            (FEW / covers.count + 1, "too_few_pairs", f"Only {covers.count} pairs show the board to both cameras.")
        )
    if covers.tilt_deg < FLAT_DEG:
        lacks.append((
            FLAT_DEG / covers.tilt_deg, "never_tilted",
            f"The boards are hardly tilted: nine tenths differ by less than {covers.tilt_deg:.0f}° from each other.",
        ))  # fmt: skip
    if covers.cells < ONE_PLACE:
        lacks.append((
            ONE_PLACE / covers.cells, "one_place",
            f"The boards were held in {100 * covers.cells:.0f} % of the picture only.",
        ))  # fmt: skip
    if covers.wide < SMALL:
        lacks.append((
            SMALL / covers.wide, "board_far",
            f"The board fills {100 * covers.wide:.0f} % of the picture's width: it is too far away.",
        ))  # fmt: skip
    return sorted(lacks, reverse=True)


def _by_noise(calibration, together):
    """How much of a calibration's doubt comes from corners that scatter more than sharp ones do, in the worse camera, mm."""
    if together is None:
        return 0.0
    off = together.solution.missing
    sigma = max(robust_sigma(off[..., k, :][together.solution.weights[..., k] > 0]) for k in (0, 1))
    return doubt_mm(calibration) * (1 - min(1, SHARP_PX / sigma))


def _doubts(calibration, covers, together, noise):
    """What makes a calibration uncertain, where it is."""
    if covers is None or together is None:
        return []
    sigma_px, does, lacks = together.sigma_px, doubt_mm(calibration), _lacks(covers)
    findings = [Finding(name, says, ADVICE[name], (), noise) for _, name, says in lacks if name == "blur"]
    times = does / (calibration.depth_per_px(calibration.depth_mm) * sigma_px)
    if times < IN_DOUBT or (findings and len(lacks) == 1):  # blur explains what is in doubt
        return findings
    too_few = [(name, says) for _, name, says in lacks if name != "blur"] or [_uneven(calibration, covers, does)]
    gain = does * (1 - GOOD_DOUBT / times)
    return findings + [Finding(name, says, ADVICE[name], (), gain * 0.99**k) for k, (name, says) in enumerate(too_few)]


def _spread(boards):
    """Where boards were held, as the left camera saw them."""
    seen = boards.left[~np.isnan(boards.left[..., 0])].round(1)
    what = "all corners of all boards in the left camera's picture"
    return Evidence(what, places=tuple(map(tuple, seen.tolist())), size=boards.size)


def _uneven(calibration, covers, does):
    """Name and sentence for boards that leave much in doubt though they look well spread."""
    sigma = depth_map(calibration).sigma_mm
    says = f"The boards leave depth uncertain by ±{does:.1f} mm at {calibration.depth_mm / 1000:.1f} m"
    if len(sigma) and np.percentile(sigma, 90) > UNEVEN * np.median(sigma):
        return "one_place", f"{says} where none were held: {', '.join(where_to_hold(calibration))} of the left picture."
    lacks = {
        "too_few_pairs": (
            np.sqrt(GOOD.count / covers.count),
            f"only {covers.count} pairs show the board to both cameras",
        ),
        "never_tilted": (
            GOOD.tilt_deg / covers.tilt_deg,
            f"they are tilted to each other by {covers.tilt_deg:.0f}° at most",
        ),
        "one_place": (GOOD.cells / covers.cells, f"they were held in {100 * covers.cells:.0f} % of the picture"),
        "board_far": (GOOD.wide / covers.wide, f"they fill {100 * covers.wide:.0f} % of its width"),
    }
    name = max(lacks, key=lambda name: lacks[name][0])
    return name, f"{says}: {lacks[name][1]}."


def _board(calibration, boards):
    """The board's squares against the cameras' distance, and its bend."""
    findings = []
    low, high = PLAUSIBLE_BASELINE_MM
    baseline, square = calibration.baseline_mm, boards.board.square_mm
    if not low <= baseline <= high or not SQUARES_MM[0] <= square <= SQUARES_MM[1]:
        says = f"With squares of {square:g} mm the cameras stand {told_mm(baseline)} mm apart, which cannot be."
        if units := units_of_squares(baseline, square):
            does = abs(1 - next(iter(units))) * calibration.depth_mm
            findings.append(
                Finding("square_unit", f"{says} {unit_asked(baseline, square)}", ADVICE["square_unit"], (), does)
            )
        elif not low / 2 <= baseline <= 3 * high:
            findings.append(Finding("square_unit", says, ADVICE["square_unit"], (), calibration.depth_mm))
    if calibration.board_bend_mm > BENT_MM:
        says = f"The board is bent by {calibration.board_bend_mm:.1f} mm from its middle to its rim."
        findings.append(Finding("board_bent", says, ADVICE["board_bent"], (), 0.0))
    return findings


def _corners(calibration):
    """Single corners that the others contradict; the calibration leaves them out."""
    wrong = [corner for corner in calibration.corners_left_out if corner[-1] > WRONG_PX]
    if not wrong:
        return []
    files = tuple(dict.fromkeys(f"calibration/{name} {side}" for name, side, *_ in wrong))
    (name, side, u, v, off), count = wrong[0], len(wrong)
    says = f"{count} corner{'s are' if count > 1 else ' is'} wrong, the worst in calibration/{name}, {side}, at ({u:.0f}, {v:.0f}), by {off:.1f} px."
    if rest := len(calibration.corners_left_out) - count:
        says += f" {rest} more {'are' if rest > 1 else 'is'} left out, off by {WRONG_PX:g} px or less: farther than the scatter of the others explains."
    values = tuple((f"{n} {s}", o) for n, s, _, _, o in wrong)
    return [Finding("corners_wrong", says, ADVICE["corners_wrong"], files, 0.0, evidence=Evidence("px off", values))]

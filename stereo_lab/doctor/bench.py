"""What wrong lengths do on the bench: the localizer finds a ball by its size too, and fits turn, shift and scale to what is measured."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from stereo_lab.calibration import StereoCalibration
from stereo_lab.doctor.balls import LOST_PART, Sighting, center_sigmas, found_by_size
from stereo_lab.doctor.findings import COSTS, STOPS, Finding
from stereo_lab.doctor.known import MOST
from stereo_lab.errors import StereoLabError
from stereo_lab.localization.doubt import RULER_SIGMA_MM, fit_bench, pixel_sigma
from stereo_lab.recording import Recording
from stereo_lab.recording.bounds import told_mm
from stereo_lab.recording.model import SHARED_OUT

SQUARES = "square_unit", "square_scale"  # findings of lengths that the cameras take over
LEAST = 3  # balls that a fit needs
ROUNDED = 0.1  # of a distance: more is told to a whole per cent


def told_on_bench(
    finding: Finding,
    recording: Recording,
    calibration: StereoCalibration,
    seen: Sequence[Sighting],
    points: np.ndarray,
    table: np.ndarray,
    times: float,
    undo: tuple[str, str],
) -> Finding:
    """A finding of wrong lengths, with what the localizer makes of them.

    It stops everything where no ball is found by its size. What the fit takes out is said, and no comfort: the
    cameras' own distances stay wrong, and so does every place that other balls tell.

    Parameters
    ----------
    finding : Finding, with what they cost by the cameras alone
    recording : Recording
    calibration : StereoCalibration, with these lengths
    seen : sequence of Sighting, N balls
    points, table : ndarray, shape (N, 3), mm: where the cameras put them, and measured x, y and depth
    times : float, how many times longer the lengths are by the ruler
    undo : (left, right), what must be done to the pictures to be as they should
    """
    to_fit = [k for k, s in enumerate(seen) if s.set_name in SHARED_OUT]
    found = found_by_size([seen[k] for k in to_fit], recording.ball, calibration, undo)
    fitted = np.isin(np.arange(len(seen)), np.array(to_fit, int)[found])
    sigma = pixel_sigma(calibration, points, center_sigmas(seen, calibration))
    if finding.name in SQUARES:
        finding = _squares(finding, calibration.depth_mm, _left_mm(points, sigma, table, times, fitted))
    if len(found) < LEAST or found.mean() >= 1 - LOST_PART:
        return finding
    says = f"{finding.says} The ball then seems too large or too small for its place, and is found in {found.sum()} of {len(found)} measured pairs."
    if found.sum() < LEAST:
        return replace(finding, says=says, does_mm=None, severity=STOPS)
    return replace(finding, says=says, severity=COSTS)


def _squares(finding, depth_mm, left_mm):
    """What wrong squares do: to the cameras alone, and on the bench."""
    alone_mm = finding.does_mm
    part = alone_mm / depth_mm
    percent = f"{100 * part:.{0 if part > ROUNDED else 1}f} %"
    says = f"{finding.says} By the cameras alone distances are {percent} wrong, {told_mm(alone_mm)} mm at {depth_mm / 1000:.1f} m"
    if left_mm < alone_mm / 2:
        says += "; on the bench the fit takes that out, as long as it stands on these balls"
    return replace(finding, says=f"{says}.")


def _left_mm(points, sigma, table, times, fitted):
    """How far off places are after the fit, 95 % of them, against one with the right lengths.

    Infinite where there is no fit.
    """
    bench, right = table[fitted] * [1, 1, -1], times * points
    try:
        fit = fit_bench(points[fitted], bench, np.hypot(sigma, RULER_SIGMA_MM)[fitted])
        wanted = fit_bench(right[fitted], bench, np.hypot(times * sigma, RULER_SIGMA_MM)[fitted])
    except StereoLabError:  # too few balls, or all on one line
        return np.inf
    return float(np.percentile(np.linalg.norm(fit.predict(points) - wanted.predict(right), axis=1), MOST))

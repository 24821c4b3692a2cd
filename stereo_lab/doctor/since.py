"""A camera that was moved between the boards and the balls: the boards are right among themselves, and the balls among themselves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from stereo_lab.calibration import StereoCalibration
from stereo_lab.doctor.advice import ADVICE
from stereo_lab.doctor.balls import Sighting, places
from stereo_lab.doctor.findings import COSTS, NOTE, STOPS, Finding
from stereo_lab.doctor.numbers import Mistake, place
from stereo_lab.localization.matching import ROW_PX

# A ball's centre is told to some hundredths of a pixel, the boards' rows to a tenth: so much is a move, where all balls agree on it
A_LITTLE_PX, ALIKE = 1.0, 3.0
ASIDE_PX = np.linspace(-24, 24, 25)  # so far to the side a camera that was turned may show the balls


def moved_up_or_down(sightings: Sequence[Sighting]) -> Finding | None:
    """Where both cameras see most of the balls, but always as far from one row: so far that they are lost, or a little."""
    both = [s for s in sightings if s.rows_px is not None]
    apart = tuple(s.name for s in both if s.apart)
    rows = np.array([s.rows_px for s in both])
    if len(rows) <= len(sightings) / 2:
        return None
    lower = float(np.median(rows))
    scatter, lost = float(np.median(np.abs(rows - lower))), len(apart) > len(sightings) / 2
    if scatter > ROW_PX or not lost and abs(lower) < max(A_LITTLE_PX, ALIKE * scatter):
        return None
    says = (
        f"Both cameras see the ball, but in {len(rows)} of {len(sightings)} measured pairs the right one sees it {abs(lower):.{0 if lost else 1}f} px "
        f"{'lower' if lower > 0 else 'higher'} than the boards tell: one of them was moved between the boards and the balls."
    )
    severity = STOPS if lost else COSTS if apart else NOTE
    return Finding("camera_moved", says, ADVICE["camera_moved_since"], apart, None, severity)


def turned_since(
    best: Mistake, seen: Sequence[Sighting], calibration: StereoCalibration, table: np.ndarray, deep: np.ndarray
) -> tuple[np.ndarray, Mistake, Finding] | None:
    """Whether a camera that was turned sideways explains the measured places better than another scale does.

    Parameters
    ----------
    best : Mistake, the scale
    seen : sequence of Sighting, the balls
    calibration : StereoCalibration, of the boards
    table, deep : as :func:`stereo_lab.doctor.numbers.place` takes them

    Returns
    -------
    (ndarray, Mistake, Finding) or None: the places with that turn undone, the table on them, and what is said of it
    """

    def tried(aside_px):
        points = places(seen, calibration, aside_px)
        return np.inf if (points[:, 2] <= 0).any() else place(points, table, deep).cost

    rough = min(ASIDE_PX, key=tried)
    aside_px = float(min(rough + np.linspace(-2, 2, 17), key=tried))
    points = places(seen, calibration, aside_px)
    placed = place(points, table, deep)
    if placed.cost > best.placed.cost - 1:
        return None
    degrees = np.degrees(np.arctan(abs(aside_px) / calibration.focal_px))
    says = (
        f"The measured places fit when a camera was turned sideways by {degrees:.2f}° between the boards and the balls: each ball then "
        f"lies {abs(aside_px):.1f} px farther to the {'right' if aside_px > 0 else 'left'} in the right picture."
    )
    does = abs(aside_px) * float(calibration.depth_per_px(calibration.depth_mm))
    finding = Finding("camera_moved", says, ADVICE["camera_moved_since"], tuple(s.name for s in seen), does)
    return points, replace(best, name="as_is", what="", table=table, placed=placed), finding

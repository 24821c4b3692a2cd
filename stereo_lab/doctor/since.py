"""A camera that was moved, or focused anew, between the boards and the balls: the boards are right among themselves, and the balls among themselves."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from stereo_lab.calibration import StereoCalibration
from stereo_lab.doctor.advice import ADVICE
from stereo_lab.doctor.balls import Sighting, places
from stereo_lab.doctor.findings import COSTS, NOTE, STOPS, Finding
from stereo_lab.doctor.known import MOST
from stereo_lab.doctor.numbers import Mistake, agree, place
from stereo_lab.localization.matching import ROW_PX

# A ball's centre is told to some hundredths of a pixel, the boards' rows to a tenth: so much is a move, where all balls agree on it
A_LITTLE_PX, ALIKE = 1.0, 3.0
ASIDE_PX = np.linspace(-24, 24, 25)  # so far to the side a camera that was turned may show the balls
# Of a focal length: a thin lens of 4 mm is 1.4 % longer focused at 0.3 m than far away
LONGER = np.linspace(-0.06, 0.06, 25)
FINER = np.linspace(-1, 1, 17)  # steps of the tries, about, that are then taken in smaller ones
ONE_LINE = 3.0  # what one line costs that is wrong


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


@dataclass(frozen=True, eq=False)
class Change:
    """What may have become of a camera between the boards and the balls.

    Attributes
    ----------
    tries, finer : ndarray, the amounts tried, and what is then added to the best of them
    undone : of an amount, what :func:`places` is told to undo it
    """

    tries: np.ndarray
    finer: np.ndarray
    undone: Callable[[float], dict[str, Any]]


def _zoomed(left: int, right: int) -> Change:
    """The camera, or cameras, whose focal length is longer by some part of it."""
    return Change(LONGER, FINER * 0.005, lambda part: {"zoomed": (1 + left * part, 1 + right * part)})


CHANGES = {
    "turned": Change(ASIDE_PX, FINER * 2, lambda px: {"aside_px": px}),
    "left": _zoomed(1, 0),
    "right": _zoomed(0, 1),
    "both": _zoomed(1, 1),
}


def changed_since(
    best: Mistake, seen: Sequence[Sighting], calibration: StereoCalibration, table: np.ndarray, deep: np.ndarray
) -> tuple[np.ndarray, Mistake, Finding] | None:
    """Whether a camera that was turned sideways, or focused anew, explains the measured places better.

    Parameters
    ----------
    best : Mistake, the table as it is, or its scale
    seen : sequence of Sighting, the balls
    calibration : StereoCalibration, of the boards
    table, deep : as :func:`stereo_lab.doctor.numbers.place` takes them

    Returns
    -------
    (ndarray, Mistake, Finding) or None: the places with that change undone, the table on them, and what is said of it
    """
    sets = [s.set_name for s in seen]
    if best.name == "as_is" and agree(best.placed, sets):
        return None

    def without(change, amount):
        return places(seen, calibration, **CHANGES[change].undone(float(amount)))

    def cost(change, amount):
        points = without(change, amount)
        return np.inf if (points[:, 2] <= 0).any() else place(points, table, deep).cost

    found = []
    for change, way in CHANGES.items():
        rough = min(way.tries, key=partial(cost, change))
        amount = min(rough + way.finer, key=partial(cost, change))
        found.append((cost(change, amount), change, float(amount)))
    _, change, amount = min(found)
    points = without(change, amount)
    placed = place(points, table, deep)
    gain = best.placed.cost - placed.cost
    # A ruler that was read badly has no cause: where no scale explains it, a change must explain nearly all
    if gain < 1 or best.name == "as_is" and (gain < ONE_LINE or not agree(placed, sets)):
        return None
    mended = replace(best, name="as_is", what="", table=table, placed=placed)
    does = float(np.percentile(np.abs(points - places(seen, calibration))[:, 2], MOST))
    name, says = _in_words(change, amount, calibration)
    return points, mended, Finding(name, says, ADVICE[f"{name}_since"], tuple(s.name for s in seen), does)


def _in_words(change, amount, calibration):
    """Name of the finding, and what is said."""
    if change == "turned":
        degrees, aside = np.degrees(np.arctan(abs(amount) / calibration.focal_px)), "right" if amount > 0 else "left"
        return "camera_moved", (
            f"The measured places fit when a camera was turned sideways by {degrees:.2f}° between the boards and the balls: each ball then "
            f"lies {abs(amount):.1f} px farther to the {aside} in the right picture."
        )
    whose = "both cameras' focal lengths are" if change == "both" else f"the {change} camera's focal length is"
    return "camera_zoomed", (
        f"The measured places fit when {whose} {100 * abs(amount):.1f} % {'longer' if amount > 0 else 'shorter'} for the balls "
        f"than for the boards: zoomed, or focused anew."
    )

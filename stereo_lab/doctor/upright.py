"""Which way up the two cameras stand, and their pictures."""

from __future__ import annotations

import numpy as np

from stereo_lab.calibration.bundle import Rig
from stereo_lab.calibration.refusals import rolled_deg
from stereo_lab.doctor.advice import ADVICE
from stereo_lab.doctor.findings import STOPS, Finding
from stereo_lab.doctor.pairing import Mend
from stereo_lab.doctor.steps import Together


def upside_down(mends: list[Mend], together: Together | None) -> tuple[list[Mend], tuple[str, str], Finding | None]:
    """Mends without those that a camera upside down brings about; what to undo in pictures; and the finding, or None."""
    mirror = next((m for m in mends if m.name == "mirrored"), None)
    undo = ("", "")
    if mirror is not None:
        undo = ("mirror", "") if mirror.side == "left" else ("", "mirror")
    if together is None:
        return mends, undo, None
    roll = rolled_deg(together.solution.rig.rotation)
    if abs(roll) > 135:
        rest = [m for m in mends if not (m.name == "reversed_order" and len(m.pairs) == len(m.boards.names))]
        says = "One camera stands on its head: its pictures are turned by half a turn against the other's."
        return rest, undo, Finding("upside_down", says, ADVICE["upside_down"], severity=STOPS)
    if abs(roll) > 45:
        says = f"One camera lies on its side: its pictures are turned by {abs(roll):.0f}° against the other's."
        return mends, undo, Finding("on_its_side", says, ADVICE["upside_down"], severity=STOPS)
    return mends, undo, None


def one_above(rig: Rig, size: tuple[int, int]) -> Finding:
    """Cameras of which one stands above the other, or whose pictures are turned by a quarter: upright ones tell the latter.

    Parameters
    ----------
    rig : Rig
    size : (width, height) of the pictures, px
    """
    _, down, _ = np.eye(3) + rig.rotation
    below = -rig.rotation.T @ rig.translation @ down > 0
    way = "counter-clockwise" if below else "clockwise"  # then the right camera is to the right
    if size[1] <= size[0]:
        says = f"One camera stands above the other; or all pictures are turned by a quarter, and must be turned back {way}."
        return Finding("one_above_the_other", says, ADVICE["one_above_the_other"], severity=STOPS)
    says = (
        f"The pictures are upright, {size[0]}x{size[1]} pixels, and in them one camera stands above the other: they are turned by a "
        f"quarter. Turned back {way}, they show the cameras side by side."
    )
    return Finding("quarter_turned", says, ADVICE["quarter_turned"], severity=STOPS)

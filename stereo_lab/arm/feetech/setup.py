"""What is written into a bus servo once: its id, its range, its torque limit, and where its middle is."""

from __future__ import annotations

import time
from collections.abc import Callable

from stereo_lab.arm.feetech import packets
from stereo_lab.arm.feetech.bus import Bus
from stereo_lab.arm.feetech.servos import LAST, LIMITS, MIDDLE, STEP_DEG, TORQUE, TORQUE_LIMIT
from stereo_lab.errors import ArmError

ID, MAX_TORQUE, LOCK, HERE_IS_THE_MIDDLE = 5, 16, 55, b"\x80"
TORQUE_PERMILLE = 500  # half of what it can: enough for the light arm, and kinder to fingers and gears
ZERO = {1: "link 1 points right, as the cameras see it", 2: "link 2 goes straight on from link 1"}
SAVING_S = 0.05  # so long it takes to keep a value


def find(bus: Bus) -> list[int]:
    """The ids that answer; a servo that is new has id 1."""
    return [id for id in range(packets.LARGEST_ID + 1) if bus.ping(id, tries=1) is not None]


def set_up(
    bus: Bus,
    joint: int,
    limits_deg: tuple[float, float],
    ask: Callable[[str], bool],
    sleep: Callable[[float], None] = time.sleep,
) -> bool:
    """Make the one servo on the wire that of a joint. Nothing is written before the answer is yes.

    Parameters
    ----------
    joint : 1 or 2, which is its id then
    limits_deg : (low, high)
    ask : function(question) -> bool
    sleep : function(seconds)

    Returns
    -------
    bool, whether it was done

    Raises
    ------
    ArmError
        If the limits lie beyond a servo's turn, there is no servo on the wire or more than one, or it does not keep what
        was written.
    """
    range_ = _range_bytes(joint, limits_deg)
    there = find(bus)
    if len(there) != 1:
        heard = "none answers" if not there else f"those with the ids {', '.join(map(str, there))} answer"
        raise ArmError(
            f"Expected one servo on the wire, but {heard}. Plug in the one of joint {joint} alone, and its supply."
        )
    old = there[0]
    if not ask(f"Make the servo with id {old} that of joint {joint} (id {joint}, half of its torque)?"):
        return False
    bus.write(old, TORQUE, b"\0")
    if not ask(f"Turn the joint by hand to 0 degrees: {ZERO[joint]}. Is it there?"):
        return False
    bus.write(old, LOCK, b"\0")
    sleep(SAVING_S)
    bus.write(old, TORQUE, HERE_IS_THE_MIDDLE)
    sleep(SAVING_S)
    for address, data in (
        (LIMITS, range_),
        (MAX_TORQUE, packets.word(TORQUE_PERMILLE)),
        (TORQUE_LIMIT, packets.word(TORQUE_PERMILLE)),
    ):
        bus.write(old, address, data)
        sleep(SAVING_S)
    bus.write(old, ID, bytes([joint]))  # it still answers with its old id
    sleep(SAVING_S)
    bus.write(joint, LOCK, b"\1")
    kept = bus.read(joint, LIMITS, 4).data
    if kept != range_ or (old != joint and bus.ping(old) is not None):
        raise ArmError(f"Servo {joint} does not keep what was written. Switch its supply off and on, and try again.")
    return True


def _range_bytes(joint, limits_deg):
    """A range as it stands in a servo's table. 180 degrees are the step after its last one, which stands for it."""
    low, high = limits_deg
    if not -180 <= low < high <= 180:
        raise ArmError(
            f"Expected limits for joint {joint} within -180 to 180 degrees, as far as a servo turns; got {low:g} to {high:g}. "
            "Narrow them in the recording."
        )
    return b"".join(packets.word(min(round(limit / STEP_DEG) + MIDDLE, LAST)) for limit in limits_deg)

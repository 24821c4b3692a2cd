"""What an arm finds out about itself: what it weighs, and what its motors do."""

from __future__ import annotations

import contextlib
import math
from typing import TYPE_CHECKING

from stereo_lab.arm import protocol as wire
from stereo_lab.errors import ArmError, UnreachableTargetError
from stereo_lab.kinematics import JointAngles
from stereo_lab.motion import MotorCalibration, WeightFit, calibrate_motor, lowest_voltage

if TYPE_CHECKING:
    from stereo_lab.arm.arm import Arm

WEIGHING_POSES = ((0, 0), (60, 30), (120, -40), (90, 90), (30, 100), (150, -100))  # both links up, sideways and down
LEAST_POSES = 4
ROOM_DEG = 30.0  # a calibration that starts so near the middle has room enough
HANGS_DEG = -90.0  # of a link, to the horizon


def must_be_homed(arm: Arm, why: str) -> None:
    """Refuse an arm that does not know where it stands, and say why it must; and what is no arm.

    Raises
    ------
    ArmError
    """
    homed = getattr(arm, "homed", None)
    if homed is None:
        raise ArmError(f"Expected an arm, as connect gives it; got {type(arm).__name__}.")
    if not homed:
        raise ArmError(f"Expected {arm.name} to be homed: {why}. Call home() first.")


def calibrate(arm: Arm, joint: int) -> MotorCalibration:
    """Measure a motor; see :meth:`stereo_lab.arm.Arm.calibrate`."""
    if not arm.homed:
        arm.home()
    if not any(arm.get(j, name) for j in (1, 2) for name in ("g1", "g2")):
        weigh(arm)
    stands = arm.status().position_deg
    for j, place in _places_deg(arm.limits_deg, joint).items():
        if abs(stands[j - 1] - place) > ROOM_DEG:
            arm._switch_on()
            arm.run(f"MV {j} {place:.3f}")
    push = lambda volts, seconds: arm.push(joint, volts + _weight_v(arm, joint), seconds)
    found = calibrate_motor(push, arm.supply_v[joint - 1] - abs(_weight_v(arm, joint)))
    arm.use(joint, found)
    return found


def _places_deg(limits_deg, joint):
    """Where to calibrate a joint: in the middle of its range, and the shoulder with a forearm that hangs.

    Stretched the arm is more sluggish, and heavier; each calibration of the shoulder would find another time constant.
    """
    low, high = limits_deg[joint - 1]
    places = {joint: (low + high) / 2}
    if joint == 1:
        low, high = limits_deg[1]
        places[2] = min(max(HANGS_DEG - places[1], low), high)
    return places


def weigh(arm: Arm) -> tuple[WeightFit, WeightFit]:
    """Find what holds both joints against the weight; see :meth:`stereo_lab.arm.Arm.weigh`."""
    must_be_homed(arm, "only then its angles tell where down is")
    poses, known = _poses(arm.limits_deg), [tuple(arm.get(joint, name) for name in ("g1", "g2")) for joint in (1, 2)]
    try:
        _set_weights(arm, [(0, 0), (0, 0)])
        rows = []
        for pose in poses:
            stands = arm.move_to(JointAngles(*pose))
            rows.append((stands.theta1_deg, stands.theta2_deg, _middle_v(arm, 1), _middle_v(arm, 2)))
        one, other, *middles = zip(*rows, strict=True)
        fits = WeightFit.fit(one, other, middles[0]), WeightFit.fit(one, other, middles[1])
    except BaseException:
        with contextlib.suppress(ArmError):  # what was known of the weight before still holds
            _set_weights(arm, known)
        raise
    _set_weights(arm, [(round(fit.g1_v, 3), round(fit.g2_v, 3)) for fit in fits])
    return fits


def _set_weights(arm, weights_v):
    for joint, of_joint in enumerate(weights_v, start=1):
        for name, volts in zip(("g1", "g2"), of_joint, strict=True):
            arm.set(joint, name, volts)


def _poses(limits_deg):
    """The poses to weigh in that lie within the limits; too few tell nothing."""
    inside = [p for p in WEIGHING_POSES if all(low <= a <= high for a, (low, high) in zip(p, limits_deg, strict=True))]
    if len(inside) < LEAST_POSES:
        raise UnreachableTargetError(
            f"Expected room for {LEAST_POSES} poses or more to weigh the arm in, such as {WEIGHING_POSES[1]} and "
            f"{WEIGHING_POSES[2]} degrees; the joints turn from "
            + " and from ".join(f"{low:g} to {high:g}" for low, high in limits_deg)
            + ". Give it more room."
        )
    return inside


def _middle_v(arm, joint):
    """Halfway between the voltages that just turn a joint up and down; they lie round the one that holds it."""
    held_v = arm.get(joint, wire.HELD)
    push = lambda volts, seconds: arm.push(joint, held_v + volts, seconds)
    up, down = (lowest_voltage(push, way, arm.supply_v[joint - 1] - abs(held_v)) for way in (1, -1))
    return held_v + (up - down) / 2


def _weight_v(arm, joint):
    """What holds the joint where it stands, as far as the controller knows."""
    stands = arm.angles()
    one, both = math.radians(stands.theta1_deg), math.radians(stands.theta1_deg + stands.theta2_deg)
    return arm.get(joint, "g1") * math.cos(one) + arm.get(joint, "g2") * math.cos(both)

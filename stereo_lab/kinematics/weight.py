"""What the arm weighs, and what its joints must hold against.

The arm's plane stands upright, so every part of it pulls at the joints that carry it. Gravity points along −y.
"""

from __future__ import annotations

from dataclasses import dataclass
from numbers import Real
from typing import TYPE_CHECKING

import numpy as np

from stereo_lab.errors import StereoLabError
from stereo_lab.kinematics.angles import JointAngles

if TYPE_CHECKING:
    from stereo_lab.kinematics.two_link import TwoLinkArm

GRAVITY_M_S2 = 9.81
NM = 1e-6  # g · mm · m/s² in N·m
KG_M2 = 1e-9  # g·mm² in kg·m²
KGF_CM = 0.0980665  # N·m; data sheets of motors like this unit


@dataclass(frozen=True)
class ArmWeight:
    """The masses of a two-link arm, g, and where they sit, mm from the joint that carries them.

    The defaults are the arm of the building guide: links of plywood, the elbow's motor and 100 g of steel on a tail behind
    the shoulder, where they balance what lies before it, and a belt from there to the elbow.

    Attributes
    ----------
    link1_g, link2_g : float, the links with all that is spread over them
    center1_mm, center2_mm : float or None, where their centres of mass lie; None: in the middle
    motor_g, motor_at_mm : float, the elbow's motor with what balances the arm beside it, and where they sit along the first
        link; below 0 is behind the shoulder
    elbow_g : float, what sits at the elbow: axle, bearings, hub, pulley
    hand_g : float, the hand at the end of the second link
    load_g : float, what it carries

    Raises
    ------
    StereoLabError
        If one of them is no number, or a mass below zero.
    """

    link1_g: float = 101.0
    link2_g: float = 22.0
    center1_mm: float | None = 44.0
    center2_mm: float | None = None
    motor_g: float = 203.0
    motor_at_mm: float = -136.0
    elbow_g: float = 75.0
    hand_g: float = 8.0
    load_g: float = 12.0

    def __post_init__(self):
        for name, value in vars(self).items():
            if value is None and name.startswith("center"):
                continue
            if not isinstance(value, Real) or not np.isfinite(value):
                raise StereoLabError(f"Expected a number for {name} of an arm's weight; got {value!r}.")
            if name.endswith("_g") and value < 0:
                raise StereoLabError(f"Expected no mass below zero for {name} of an arm's weight; got {value!r}.")


def moments_g_mm(arm: TwoLinkArm) -> tuple[float, float]:
    """Mass times distance, g·mm: of all that hangs on the shoulder along the first link, and on the elbow along the second.

    What the elbow carries pulls at the shoulder as if it sat at the elbow, and besides by its own moment.
    """
    w = arm.weight
    center1, center2 = _centers_mm(arm)
    carried = w.elbow_g + w.link2_g + w.hand_g + w.load_g
    first = w.link1_g * center1 + w.motor_g * w.motor_at_mm + carried * arm.l1_mm
    return first, w.link2_g * center2 + (w.hand_g + w.load_g) * arm.l2_mm


def holding_torque_nm(arm: TwoLinkArm, angles: JointAngles) -> tuple[float | np.ndarray, float | np.ndarray]:
    """The torques that hold the arm in a pose, N·m; plus turns counter-clockwise.

    τ2 = g·M2·cos(θ1 + θ2) and τ1 = g·M1·cos θ1 + τ2, with the moments M1 and M2 of :func:`moments_g_mm`: only what lies
    sideways of a joint pulls at it.

    Parameters
    ----------
    angles : JointAngles, of scalars or of arrays

    Returns
    -------
    shoulder_nm, elbow_nm : float or ndarray
    """
    first, second = moments_g_mm(arm)
    elbow = GRAVITY_M_S2 * NM * second * np.cos(np.radians(np.add(angles.theta1_deg, angles.theta2_deg)))
    shoulder = GRAVITY_M_S2 * NM * first * np.cos(np.radians(angles.theta1_deg)) + elbow
    return (float(shoulder), float(elbow)) if np.ndim(shoulder) == 0 else (shoulder, elbow)


def worst_poses(arm: TwoLinkArm) -> tuple[JointAngles, JointAngles]:
    """The poses within the limits, to a degree, in which shoulder and elbow have most to hold."""
    one, other = (np.linspace(low, high, max(2, round(high - low) + 1)) for low, high in arm.limits_deg)
    poses = JointAngles(*np.meshgrid(one, other, indexing="ij"))
    nearest = -1e-12 * (np.abs(poses.theta1_deg) + np.abs(poses.theta2_deg))  # of equals the one nearest to zero
    most = [(np.abs(torque) + nearest).argmax() for torque in holding_torque_nm(arm, poses)]
    shoulder, elbow = (
        JointAngles(float(np.ravel(poses.theta1_deg)[k]), float(np.ravel(poses.theta2_deg)[k])) for k in most
    )
    return shoulder, elbow


def worst_torque_nm(arm: TwoLinkArm) -> tuple[float, float]:
    """The most that shoulder and elbow must hold anywhere within the limits, N·m, without sign."""
    shoulder, elbow = (holding_torque_nm(arm, pose)[j] for j, pose in enumerate(worst_poses(arm)))
    return abs(float(shoulder)), abs(float(elbow))


def inertia_parts_kg_m2(arm: TwoLinkArm) -> tuple[float, float, float]:
    """Of the first link with all that the elbow carries as a point, of what turns round the elbow, and what couples them.

    The links count as thin rods up to the next joint or the hand, round their centres of mass; all else as points. The last
    is to be multiplied by cos θ2.
    """
    w, l1, l2 = arm.weight, arm.l1_mm, arm.l2_mm
    center1, center2 = _centers_mm(arm)
    end = w.hand_g + w.load_g
    first = w.link1_g * (center1**2 + (l1 - center1) ** 2 / 3) + w.motor_g * w.motor_at_mm**2
    first += (w.elbow_g + w.link2_g + end) * l1**2
    second = w.link2_g * (center2**2 + (l2 - center2) ** 2 / 3) + end * l2**2
    return KG_M2 * first, KG_M2 * second, KG_M2 * (w.link2_g * center2 + end * l2) * l1


def inertia_kg_m2(arm: TwoLinkArm, theta2_deg: float) -> tuple[float, float, float]:
    """M11, M12 and M22 of M(θ)·θ'' + … = τ: of both joints together, what couples them, of the elbow; motors apart."""
    first, second, coupling = inertia_parts_kg_m2(arm)
    across = coupling * float(np.cos(np.radians(theta2_deg)))
    return first + second + 2 * across, second + across, second


def _centers_mm(arm):
    """Where the links' centres of mass lie."""
    w = arm.weight
    center1 = arm.l1_mm / 2 if w.center1_mm is None else w.center1_mm
    center2 = arm.l2_mm / 2 if w.center2_mm is None else w.center2_mm
    return center1, center2

"""Lesson 05: from a point to the joint angles of an arm, and back; and what the arm's weight asks of its joints.

Both joints of the two-link arm turn in the bench's x-y plane; the origin is the shoulder. Angles grow
counter-clockwise, as the cameras see it.
"""

from stereo_lab.kinematics.angles import JointAngles
from stereo_lab.kinematics.registration import LEAST_POSES, Registration
from stereo_lab.kinematics.turret import TurretAngles, TurretArm
from stereo_lab.kinematics.two_link import TwoLinkArm
from stereo_lab.kinematics.weight import (
    GRAVITY_M_S2,
    KGF_CM,
    NM,
    ArmWeight,
    holding_torque_nm,
    inertia_kg_m2,
    inertia_parts_kg_m2,
    moments_g_mm,
    worst_poses,
    worst_torque_nm,
)

__all__ = [
    "GRAVITY_M_S2", "KGF_CM", "LEAST_POSES", "NM", "ArmWeight", "JointAngles", "Registration", "TurretAngles", "TurretArm", "TwoLinkArm", "holding_torque_nm",
    "inertia_kg_m2", "inertia_parts_kg_m2", "moments_g_mm", "worst_poses", "worst_torque_nm",
]  # fmt: skip

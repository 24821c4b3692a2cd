"""Find out where an arm stands before the cameras: its hand holds the ball, and goes to places where they see it."""

from __future__ import annotations

import contextlib
from collections.abc import Callable

import numpy as np

from stereo_lab.arm.arm import Arm
from stereo_lab.arm.measuring import must_be_homed
from stereo_lab.errors import StereoLabError, UnreachableTargetError
from stereo_lab.kinematics import LEAST_POSES, JointAngles, Registration, TwoLinkArm
from stereo_lab.recording import Position

# Hands all over the plane, as parts of the reach, and the elbow's side: both sides tell the links from the zeros.
HANDS = (
    (0.70, 0.20, "down"), (0.65, -0.15, "up"), (0.35, 0.65, "down"), (0.05, 0.80, "up"), (-0.35, 0.65, "down"), (-0.65, 0.40, "up"),
    (-0.75, 0.00, "down"), (-0.35, -0.25, "up"), (0.35, -0.25, "down"), (0.45, 0.45, "up"), (0.80, 0.30, "down"), (-0.20, 0.40, "up"),
)  # fmt: skip
SIGMA_MM = 1.0  # of a place that tells none


def hand_poses(links: TwoLinkArm) -> list[JointAngles]:
    """Poses to register an arm in, within its limits; the elbow on the other side where it cannot be on the one that is wished."""
    reach, poses = links.l1_mm + links.l2_mm, []
    for x, y, elbow in HANDS:
        with contextlib.suppress(UnreachableTargetError):
            ways = links.solutions(x * reach, y * reach)
            poses.append(next((way for way in ways if (way.theta2_deg >= 0) == (elbow == "down")), ways[0]))
    return poses


def register(arm: Arm, links: TwoLinkArm, depth_mm: float, locate: Callable[[], Position | None]) -> Registration:
    """Move the hand with the ball to about a dozen places, and fit where the arm stands. This moves the arm.

    Parameters
    ----------
    arm : Arm, homed
    links : TwoLinkArm, as it is told
    depth_mm : float, the depth of its plane, as it is told
    locate : function() -> Position or None, where the cameras see the ball now

    Returns
    -------
    Registration

    Raises
    ------
    StereoLabError
        If the arm is not homed, its limits leave fewer than six poses, or the cameras see the ball in fewer.
    """
    must_be_homed(arm, "its zeros are what is measured")
    poses = hand_poses(links)
    if len(poses) < LEAST_POSES:
        raise StereoLabError(
            f"Within its limits, {links.limits_deg[0]} and {links.limits_deg[1]} degrees, the hand comes to {len(poses)} of {len(HANDS)} places; "
            f"{LEAST_POSES} or more are needed to register it. Nothing was moved."
        )
    angles, places, sigmas = [], [], []
    for pose in poses:
        stands = arm.move_to(
            pose, one_side=True
        )  # so that the play of the gears lies on one side, and is a part of the zeros
        seen = locate()
        if seen is not None:
            angles.append((stands.theta1_deg, stands.theta2_deg))
            places.append((seen.x_mm, seen.y_mm, seen.depth_mm))
            sigmas.append(SIGMA_MM * np.ones(3) if seen.sigma_mm is None else seen.sigma_mm)
    if len(places) < LEAST_POSES:
        raise StereoLabError(
            f"The cameras saw the ball in {len(places)} of {len(poses)} poses; {LEAST_POSES} or more are needed. Does the hand hold the ball, "
            "and does nothing hide it?"
        )
    return Registration.fit(links, depth_mm, np.array(angles, float), np.array(places), np.array(sigmas))

"""Find out where an arm stands before the cameras: its hand holds the ball, and goes to places where they see it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from stereo_lab.arm.arm import Arm
from stereo_lab.errors import StereoLabError
from stereo_lab.kinematics import LEAST_POSES, JointAngles, Registration, TwoLinkArm
from stereo_lab.recording import Position

# Hands all over the plane, as parts of the reach, and the elbow's side: both sides tell the links from the zeros.
HANDS = (
    (0.70, 0.20, "down"), (0.65, -0.15, "up"), (0.35, 0.65, "down"), (0.05, 0.80, "up"), (-0.35, 0.65, "down"), (-0.65, 0.40, "up"),
    (-0.75, 0.00, "down"), (-0.35, -0.25, "up"), (0.35, -0.25, "down"), (0.45, 0.45, "up"), (0.80, 0.30, "down"), (-0.20, 0.40, "up"),
)  # fmt: skip
SIGMA_MM = 1.0  # of a place that tells none


def hand_poses(links: TwoLinkArm) -> list[JointAngles]:
    """Poses to register an arm in, within its limits."""
    reach = links.l1_mm + links.l2_mm
    poses = [
        links.inverse(x * reach, y * reach, elbow)
        for x, y, elbow in HANDS
        if np.hypot(x, y) * reach > links.reach_mm[0]
    ]
    return [pose for pose in poses if links.within_limits(pose)]


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
        If the arm is not homed, or the cameras see the ball in fewer than six poses.
    """
    if not arm.homed:
        raise StereoLabError(f"Expected {arm.name} to be homed: its zeros are what is measured. Call home() first.")
    poses = hand_poses(links)
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

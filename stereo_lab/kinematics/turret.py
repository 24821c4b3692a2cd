"""The two-link arm on a turntable: three angles for a point anywhere in the room."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from stereo_lab.errors import StereoLabError
from stereo_lab.kinematics.angles import JointAngles, are_limits, must_be_angles, points, within, wrap
from stereo_lab.kinematics.two_link import TwoLinkArm


@dataclass(frozen=True)
class TurretAngles:
    """The three angles of a turret arm, or arrays of them.

    Attributes
    ----------
    turret_deg : float or ndarray, the turret's turn about the bench's y axis
    theta1_deg, theta2_deg : float or ndarray, shoulder and elbow of the arm on it
    """

    turret_deg: float | np.ndarray
    theta1_deg: float | np.ndarray
    theta2_deg: float | np.ndarray


@dataclass(frozen=True)
class TurretArm:
    """A two-link arm on a turntable: the plane of the arm is carried round the upright y axis.

    At 0° the arm's plane is the bench's x-y plane. Seen from above the turret turns
    counter-clockwise, so that at 90° the arm points away from the cameras, along −z.

    Parameters
    ----------
    plane : TwoLinkArm
    turret_limits_deg : (low, high)

    Raises
    ------
    StereoLabError
        If the arm is no TwoLinkArm, or the lower limit not below the upper one.
    """

    plane: TwoLinkArm
    turret_limits_deg: tuple[float, float] = (-180.0, 180.0)

    def __post_init__(self):
        if not isinstance(self.plane, TwoLinkArm):
            raise StereoLabError(f"Expected a TwoLinkArm to stand on the turntable; got {self.plane!r}.")
        if not are_limits([self.turret_limits_deg], 1):
            raise StereoLabError(
                f"Expected (low, high) in degrees for the turret, as in (-90, 90); got {self.turret_limits_deg}."
            )

    def forward(self, angles: TurretAngles) -> tuple[float | np.ndarray, float | np.ndarray, float | np.ndarray]:
        """Angles to the place of the hand in the bench frame.

        Parameters
        ----------
        angles : TurretAngles, of scalars or of arrays

        Returns
        -------
        x_mm, y_mm, z_mm : float or ndarray
        """
        must_be_angles(angles, TurretAngles)
        out_mm, y_mm = self.plane.forward(JointAngles(angles.theta1_deg, angles.theta2_deg))
        turret = np.radians(angles.turret_deg)
        return out_mm * np.cos(turret), y_mm, -out_mm * np.sin(turret)

    def inverse(self, x_mm: ArrayLike, y_mm: ArrayLike, z_mm: ArrayLike, elbow: str = "down") -> TurretAngles:
        """Place of the hand in the bench frame to the three angles.

        The turret looks at the point; what is left is a point in the arm's own plane,
        √(x² + z²) out and y up.

        Returns
        -------
        TurretAngles
            Arrays give arrays, with NaN where the point is out of reach. On the turret's axis every
            turret angle is right; 0 is given.

        Raises
        ------
        UnreachableTargetError
            If a single point is out of reach.
        """
        x, z = points(x_mm, z_mm)
        pose = self.plane.inverse(np.hypot(x, z), y_mm, elbow)
        turret_deg = np.where(np.isnan(pose.theta1_deg), np.nan, wrap(np.degrees(np.arctan2(-z, x))))
        turret_deg = np.where((x == 0) & (z == 0) & ~np.isnan(turret_deg), 0.0, turret_deg)
        if turret_deg.ndim == 0:
            return TurretAngles(float(turret_deg), pose.theta1_deg, pose.theta2_deg)
        return TurretAngles(turret_deg, pose.theta1_deg, pose.theta2_deg)

    def within_limits(self, angles: TurretAngles) -> bool | np.ndarray:
        """Whether turret and joints are within their limits."""
        must_be_angles(angles, TurretAngles)
        all_three = angles.turret_deg, angles.theta1_deg, angles.theta2_deg
        return within(all_three, (self.turret_limits_deg, *self.plane.limits_deg))

"""Lesson 05: from a point to the two joint angles of an arm, and back.

Both joints turn in the bench's x-y plane; the origin is the shoulder.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stereo_lab.errors import UnreachableTargetError

ROUNDING = 1e-12  # how far a cosine may leave -1..1 by rounding alone


@dataclass(frozen=True)
class JointAngles:
    """Shoulder angle from the x axis and elbow angle from the first link, in degrees."""

    theta1_deg: float
    theta2_deg: float


@dataclass(frozen=True)
class TwoLinkArm:
    """A planar arm of two links (the paper's Fig. 7).

    Parameters
    ----------
    l1_mm, l2_mm : float, lengths of the links
    theta1_limits_deg, theta2_limits_deg : (low, high), what the joints can turn
    """

    l1_mm: float
    l2_mm: float
    theta1_limits_deg: tuple = (-180.0, 180.0)
    theta2_limits_deg: tuple = (-150.0, 150.0)

    @property
    def reach_mm(self):
        """Nearest and farthest distance of the hand from the shoulder (limits left out)."""
        return abs(self.l1_mm - self.l2_mm), self.l1_mm + self.l2_mm

    def forward(self, angles):
        """Joint angles to the place of the hand.

        Parameters
        ----------
        angles : JointAngles, of scalars or of arrays

        Returns
        -------
        x_mm, y_mm : float or ndarray
        """
        theta1, theta12 = np.radians(angles.theta1_deg), np.radians(np.add(angles.theta1_deg, angles.theta2_deg))
        x_mm = self.l1_mm * np.cos(theta1) + self.l2_mm * np.cos(theta12)
        y_mm = self.l1_mm * np.sin(theta1) + self.l2_mm * np.sin(theta12)
        return x_mm, y_mm

    def inverse(self, x_mm, y_mm, elbow="down"):
        """Place of the hand to joint angles (Eq. 5 and 6 of the paper).

        θ2 = acos((x² + y² − l1² − l2²) / (2·l1·l2))
        θ1 = atan2(y, x) − atan2(l2·sin θ2, l1 + l2·cos θ2)

        Parameters
        ----------
        x_mm, y_mm : float or ndarray
        elbow : "down" (θ2 >= 0, the paper's) or "up" (θ2 <= 0)

        Returns
        -------
        JointAngles
            θ1 in (−180, 180]. Arrays give arrays, with NaN where the point is out of reach.

        Raises
        ------
        UnreachableTargetError
            If a single point is out of reach.
        """
        if elbow not in ("down", "up"):
            raise ValueError(f'elbow: expected "down" or "up", got {elbow!r}')
        x, y = np.asarray(x_mm, float), np.asarray(y_mm, float)
        cosine = (x**2 + y**2 - self.l1_mm**2 - self.l2_mm**2) / (2 * self.l1_mm * self.l2_mm)
        cosine = np.where(np.abs(cosine) <= 1 + ROUNDING, np.clip(cosine, -1, 1), np.nan)
        if cosine.ndim == 0 and np.isnan(cosine):
            raise UnreachableTargetError(self._out_of_reach(float(x), float(y)))
        theta2 = np.arccos(cosine) * (1 if elbow == "down" else -1)
        theta1 = np.arctan2(y, x) - np.arctan2(self.l2_mm * np.sin(theta2), self.l1_mm + self.l2_mm * np.cos(theta2))
        theta1_deg, theta2_deg = _wrap(np.degrees(theta1)), np.degrees(theta2)
        if cosine.ndim == 0:
            return JointAngles(float(theta1_deg), float(theta2_deg))
        return JointAngles(theta1_deg, theta2_deg)

    def _out_of_reach(self, x, y):
        near, far = self.reach_mm
        distance = np.hypot(x, y)
        gap = distance - far if distance > far else near - distance
        return (
            f"The point ({x:.1f}, {y:.1f}) mm is {distance:.1f} mm from the shoulder; "
            f"the hand reaches from {near:.1f} to {far:.1f} mm. It is {gap:.3g} mm out of reach."
        )


def _wrap(angle_deg):
    """Angles in (−180, 180]."""
    return -(np.mod(-np.asarray(angle_deg) + 180.0, 360.0) - 180.0)

"""The paper's arm: two links in a plane, from a point to the joint angles and back."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from numbers import Real

import numpy as np
from numpy.typing import ArrayLike

from stereo_lab.errors import StereoLabError, UnreachableTargetError
from stereo_lab.kinematics.angles import JointAngles, must_be_angles, must_be_limits, points, within, wrap
from stereo_lab.kinematics.weight import ArmWeight

ROUNDING = 1e-12  # how far a cosine may leave -1..1 by rounding alone


@dataclass(frozen=True)
class TwoLinkArm:
    """A planar arm of two links (the paper's Fig. 7).

    Parameters
    ----------
    l1_mm, l2_mm : float, lengths of the links, above zero
    limits_deg : ((low, high), (low, high)), how far shoulder and elbow can turn
    weight : ArmWeight, what its parts weigh and where

    Raises
    ------
    StereoLabError
        If a length is not above zero, a lower limit not below the upper one, or the weight none.
    """

    l1_mm: float
    l2_mm: float
    limits_deg: tuple[tuple[float, float], tuple[float, float]] = ((-180.0, 180.0), (-180.0, 180.0))
    weight: ArmWeight = field(default_factory=ArmWeight)

    def __post_init__(self):
        if not all(isinstance(link, Real) and np.isfinite(link) and link > 0 for link in (self.l1_mm, self.l2_mm)):
            raise StereoLabError(f"Expected two links longer than 0 mm; got {self.l1_mm} and {self.l2_mm}.")
        must_be_limits(self.limits_deg)
        if not isinstance(self.weight, ArmWeight):
            raise StereoLabError(f"Expected an ArmWeight behind the limits, or nothing; got {self.weight!r}.")

    @property
    def reach_mm(self) -> tuple[float, float]:
        """Nearest and farthest distance of the hand from the shoulder, limits left out."""
        return abs(self.l1_mm - self.l2_mm), self.l1_mm + self.l2_mm

    def forward(self, angles: JointAngles) -> tuple[float | np.ndarray, float | np.ndarray]:
        """Joint angles to the place of the hand.

        Parameters
        ----------
        angles : JointAngles, of scalars or of arrays

        Returns
        -------
        x_mm, y_mm : float or ndarray

        Raises
        ------
        StereoLabError
            If the angles are no JointAngles, or not of numbers.
        """
        must_be_angles(angles)
        try:
            theta1, theta12 = np.radians(angles.theta1_deg), np.radians(np.add(angles.theta1_deg, angles.theta2_deg))
        except TypeError:
            raise StereoLabError(f"Expected angles in degrees as numbers; got {angles}.") from None
        x_mm = self.l1_mm * np.cos(theta1) + self.l2_mm * np.cos(theta12)
        y_mm = self.l1_mm * np.sin(theta1) + self.l2_mm * np.sin(theta12)
        return x_mm, y_mm

    def inverse(self, x_mm: ArrayLike, y_mm: ArrayLike, elbow: str = "down") -> JointAngles:
        """Place of the hand to joint angles (Eq. 5 and 6 of the paper). Limits are left out.

        θ2 = acos((x² + y² − l1² − l2²) / (2·l1·l2))
        θ1 = atan2(y, x) − atan2(l2·sin θ2, l1 + l2·cos θ2)

        Stretched, acos is flat and loses half of the digits. So θ2 is found by its half:
        tan²(θ2/2) = (far² − r²) / (r² − near²), the same angle with r² = x² + y², far = l1 + l2
        and near = |l1 − l2|.

        Parameters
        ----------
        x_mm, y_mm : float or ndarray
        elbow : "down" (θ2 >= 0, the paper's) or "up" (θ2 <= 0)

        Returns
        -------
        JointAngles
            θ1 in (−180, 180]. Arrays give arrays, with NaN where the point is out of reach. With the
            hand in the shoulder of two equal links every θ1 is right; 0 is given.

        Raises
        ------
        UnreachableTargetError
            If a single point is out of reach.
        StereoLabError
            If a single point is not made of numbers.
        """
        if elbow not in ("down", "up"):
            raise StereoLabError(f'elbow: expected "down" or "up", got {elbow!r}.')
        x, y = points(x_mm, y_mm)
        sine, cosine = self._elbow(np.hypot(x, y), 1 if elbow == "down" else -1)
        if cosine.ndim == 0 and np.isnan(cosine):
            raise UnreachableTargetError(self._out_of_reach(float(x), float(y)))
        theta1 = np.arctan2(y, x) - np.arctan2(self.l2_mm * sine, self.l1_mm + self.l2_mm * cosine)
        theta1 = np.where((x == 0) & (y == 0) & ~np.isnan(cosine), 0.0, theta1)
        theta1_deg, theta2_deg = wrap(np.degrees(theta1)), np.degrees(np.arctan2(sine, cosine))
        if cosine.ndim == 0:
            return JointAngles(float(theta1_deg), float(theta2_deg))
        return JointAngles(theta1_deg, theta2_deg)

    def solutions(self, x_mm: float, y_mm: float) -> list[JointAngles]:
        """All poses within the limits that bring the hand to one point.

        Returns
        -------
        list of JointAngles
            Elbow down first; a single one where the arm is stretched.

        Raises
        ------
        UnreachableTargetError
            If the point is out of reach, or every pose is beyond a limit.
        """
        poses = list(dict.fromkeys(self.inverse(x_mm, y_mm, elbow) for elbow in ("down", "up")))
        allowed = [pose for pose in dict.fromkeys(map(self._turned, poses)) if self.within_limits(pose)]
        if not allowed:
            said = " or ".join(f"({p.theta1_deg:.1f}, {p.theta2_deg:.1f})" for p in poses)
            raise UnreachableTargetError(
                f"The point ({x_mm:.1f}, {y_mm:.1f}) mm needs the joints at {said} degrees; "
                f"they turn from {_span(self.limits_deg[0])} and from {_span(self.limits_deg[1])}."
            )
        return allowed

    def _turned(self, pose):
        """The same pose with each angle a whole turn more or less, where it is within the limits only then."""
        angles = []
        for angle, (low, high) in zip((pose.theta1_deg, pose.theta2_deg), self.limits_deg, strict=True):
            others = (angle, angle + 360.0, angle - 360.0)
            angles.append(next((other for other in others if within([other], [(low, high)])), angle))
        return JointAngles(*angles)

    def extended(self, by_mm: float) -> TwoLinkArm:
        """The same arm with a longer forearm: where its tip is in the middle of a ball, the hand touches the ball.

        Parameters
        ----------
        by_mm : float
            The ball's radius. The forearm then points at the ball's middle, and the hand ends at its near surface;
            more than the radius leaves a gap.

        Returns
        -------
        TwoLinkArm
        """
        return replace(self, l2_mm=self.l2_mm + by_mm)

    def within_limits(self, angles: JointAngles) -> bool | np.ndarray:
        """Whether joint angles are within the limits: bool, or an array of them."""
        must_be_angles(angles)
        return within((angles.theta1_deg, angles.theta2_deg), self.limits_deg)

    def jacobian(self, angles: JointAngles) -> np.ndarray:
        """How far the hand moves for each degree of each joint.

        Parameters
        ----------
        angles : JointAngles, of scalars or of arrays of N

        Returns
        -------
        ndarray, shape (2, 2) or (N, 2, 2)
            [[dx/dθ1, dx/dθ2], [dy/dθ1, dy/dθ2]] in mm per degree. Its determinant is
            l1·l2·sin θ2 times (π/180)²: zero where the arm is stretched or folded.
        """
        x, y = self.forward(angles)
        theta12 = np.radians(np.add(angles.theta1_deg, angles.theta2_deg))
        x2, y2 = self.l2_mm * np.cos(theta12), self.l2_mm * np.sin(theta12)
        rows = np.array([[-y, -y2], [x, x2]]) * np.pi / 180
        return np.moveaxis(rows, (0, 1), (-2, -1))

    def _elbow(self, r, sign):
        """Sine and cosine of θ2 for hands at distance r; NaN where out of reach."""
        near, far = self.reach_mm
        cosine = (r**2 - self.l1_mm**2 - self.l2_mm**2) / (2 * self.l1_mm * self.l2_mm)
        reachable = np.abs(cosine) <= 1 + ROUNDING
        inwards = np.clip((far - r) * (far + r), 0, None)  # far² − r²
        outwards = np.clip((r - near) * (r + near), 0, None)  # r² − near²
        whole = inwards + outwards
        sine = sign * 2 * np.sqrt(inwards * outwards) / whole
        return np.where(reachable, sine, np.nan), np.where(reachable, (outwards - inwards) / whole, np.nan)

    def _out_of_reach(self, x, y):
        near, far = self.reach_mm
        distance = np.hypot(x, y)
        gap = distance - far if distance > far else near - distance
        return (
            f"The point ({x:.1f}, {y:.1f}) mm is {distance:.1f} mm from the shoulder; "
            f"the hand reaches from {near:.1f} to {far:.1f} mm. It is {gap:.3g} mm out of reach."
        )


def _span(limits):
    return f"{limits[0]:g} to {limits[1]:g}"

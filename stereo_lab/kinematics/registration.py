"""Where the arm stands before the cameras: fitted to places at which the cameras saw its hand.

A real arm's shoulder is not quite where the ruler put it, its plane is tilted a little, its zeros are off by the width of a
switch, its links by a millimetre. The hand takes the ball to some poses, the cameras say where it is, and a fit finds all of it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from stereo_lab.common.files import check_format, finite_number, read_json, write_json
from stereo_lab.common.vectors import as_numbers, for_each
from stereo_lab.errors import StereoLabError
from stereo_lab.kinematics.angles import JointAngles, wrap
from stereo_lab.kinematics.standing import NAMES, UNITS, covariance_of, fitted, places_of, rotation, slopes_of, upright
from stereo_lab.kinematics.two_link import TwoLinkArm

LEAST_POSES = 6  # nine numbers, three from each place; more of them tell how far to trust the rest
SURE = 3.0  # standard deviations that make a difference one
WORTH_MM, WORTH_DEG = 1.0, 0.3  # less than that nobody mends
BEHIND_DEG = 90.0  # a plane turned farther is seen from its back
LOOKED_DEG = 2.0  # so far a joint turns between two looks at where the links are: the hand moves by less than a ball


@dataclass(frozen=True, eq=False)
class Registration:
    """Where an arm stands in the bench frame, and what it is really like.

    place = S + R·(x, y, 0), with x and y of the two links l1, l2 at the angles θ1 + z1 and θ2 + z2. R turns the arm's plane about
    the vertical, then tilts it about its horizontal. (Turned within its plane it would be the same as another z1.)

    Attributes
    ----------
    values : ndarray, shape (9,)
        Shoulder S as x, y and depth in mm; turned and tilted in degrees; z1 and z2 in degrees; l1 and l2 in mm.
    sigmas : ndarray, shape (9,), their standard deviations
    residuals_mm : ndarray, shape (N, 3), seen minus fitted places
    limits_deg : ((low, high), (low, high)), those of the arm, in its own degrees
    """

    values: np.ndarray
    sigmas: np.ndarray
    residuals_mm: np.ndarray
    limits_deg: tuple[tuple[float, float], tuple[float, float]]

    @classmethod
    def fit(
        cls,
        arm: TwoLinkArm,
        depth_mm: float,
        angles_N2: ArrayLike,
        places_N3: ArrayLike,
        sigmas_N3: ArrayLike | float = 1.0,
    ) -> Registration:
        """Weighted least squares by Gauss-Newton steps, from an arm that stands where it is told to.

        Parameters
        ----------
        arm : TwoLinkArm, as it is told
        depth_mm : float, the depth of its plane, as it is told
        angles_N2 : array, shape (N, 2), what the encoders said, degrees
        places_N3 : array, shape (N, 3), where the cameras saw the ball in the hand: x, y, depth in mm
        sigmas_N3 : array, shape (N, 3), or a float, how far each of them may be off, mm

        Raises
        ------
        StereoLabError
            With fewer than six poses, something in them that is no number, poses that do not tell the nine numbers apart, or
            places that fit no arm.
        """
        angles, places = as_numbers(angles_N2), as_numbers(places_N3)
        shapes = angles.shape, places.shape
        if not (angles.ndim == 2 and len(angles) >= LEAST_POSES and shapes == ((len(angles), 2), (len(angles), 3))):
            raise StereoLabError(
                f"Expected {LEAST_POSES} poses or more, each with two angles and a place, (N, 2) and (N, 3); got {shapes[0]} and {shapes[1]}."
            )
        if not (np.isfinite(angles).all() and np.isfinite(places).all()):
            raise StereoLabError("An angle or a place of a pose is no finite number.")
        spreads = for_each(sigmas_N3, places.shape)
        if not (np.isfinite(spreads).all() and (spreads > 0).all()):
            raise StereoLabError("How far a place may be off must be a number above zero.")
        told, weights = cls.told(arm, depth_mm).values, 1 / spreads.ravel()
        covariance_of(slopes_of(told, angles))  # poses that tell too little are told before anything is fitted
        values = fitted(told, angles, places, spreads)
        covariance = covariance_of(slopes_of(values, angles) * weights[:, None])
        residuals = places - places_of(values, angles)
        spread = np.sum((residuals.ravel() * weights) ** 2) / max(residuals.size - len(values), 1)
        # No surer than the places agree; and the same two cameras err alike at all of them: they tell no more than as many
        # numbers as there are to find.
        sigmas = np.sqrt(np.diag(covariance) * max(spread, 1.0) * residuals.size / len(values))
        return cls(values, sigmas, residuals, arm.limits_deg)

    @classmethod
    def told(cls, arm: TwoLinkArm, depth_mm: float) -> Registration:
        """An arm that stands where it is told to: its shoulder at the origin of the bench frame, upright, without a doubt."""
        values = np.array([0, 0, depth_mm, 0, 0, 0, 0, arm.l1_mm, arm.l2_mm], float)
        return cls(values, np.zeros(9), np.zeros((0, 3)), arm.limits_deg)

    def moved(self, by: ArrayLike) -> Registration:
        """The same arm with each of the nine values changed by so much: for trying what a registration finds."""
        return replace(self, values=self.values + np.asarray(by, float))

    def save(self, path: str | Path) -> None:
        """Write it to a JSON file, whole or not at all."""
        facts: dict[str, Any] = {"format": 1, "limits_deg": [list(limits) for limits in self.limits_deg]}
        for name, unit, value, sigma in zip(NAMES, UNITS, self.values, self.sigmas, strict=True):
            facts[name] = {"value": float(value), "sigma": float(sigma), "unit": unit}
        write_json(path, {**facts, "residuals_mm": self.residuals_mm.tolist()})

    @classmethod
    def load(cls, path: str | Path) -> Registration:
        """Read what :meth:`save` wrote.

        Raises
        ------
        StereoLabError
            If the file is no registration, or something in it is no number.
        """
        facts = read_json(path)
        check_format(facts, path)
        try:
            values = [finite_number(facts[name]["value"], f"{path}, {name}") for name in NAMES]
            sigmas = [finite_number(facts[name]["sigma"], f"{path}, {name}") for name in NAMES]
            residuals = np.array(facts["residuals_mm"], float).reshape(-1, 3)
            low1, high1, low2, high2 = (
                finite_number(limit, f"{path}, limits_deg") for low_high in facts["limits_deg"] for limit in low_high
            )
        except (KeyError, TypeError, ValueError) as error:
            raise StereoLabError(f"{path} is no registration of an arm ({error!r}). Register it again.") from None
        return cls(np.array(values), np.array(sigmas), residuals, ((low1, high1), (low2, high2)))

    @property
    def arm(self) -> TwoLinkArm:
        """The two links as they are; its angles are true ones, the joints' own are smaller by the zeros."""
        zero1, zero2 = self.values[5:7]
        (low1, high1), (low2, high2) = self.limits_deg
        limits = ((low1 + zero1, high1 + zero1), (low2 + zero2, high2 + zero2))
        return TwoLinkArm(float(self.values[7]), float(self.values[8]), limits)

    def place(self, angles: JointAngles) -> np.ndarray:
        """Where the hand is at some angles of the joints: x, y, depth in mm."""
        return places_of(self.values, np.array([[angles.theta1_deg, angles.theta2_deg]], float))[0]

    def solutions(self, x_mm: float, y_mm: float, depth_mm: float, beyond_mm: float = 0.0) -> list[JointAngles]:
        """The angles of the joints that bring the hand to a place, or as near as its plane lets it.

        Parameters
        ----------
        x_mm, y_mm, depth_mm : float, in the bench frame
        beyond_mm : float, the radius of a ball that the hand touches from outside

        Returns
        -------
        list of JointAngles
            As :meth:`TwoLinkArm.solutions`: elbow down first.

        Raises
        ------
        UnreachableTargetError
            If the place is out of reach, or beyond a limit.
        """
        inside = self.in_arm(x_mm, y_mm, depth_mm)
        zero1, zero2 = self.values[5:7]
        poses = self.arm.extended(beyond_mm).solutions(float(inside[0]), float(inside[1]))
        return [JointAngles(float(p.theta1_deg - zero1), float(p.theta2_deg - zero2)) for p in poses]

    def in_arm(self, x_mm: float, y_mm: float, depth_mm: float) -> np.ndarray:
        """A place of the bench frame as the arm has it: x and y in the plane of its hand, from its shoulder, and z before it, mm."""
        return rotation(*self.values[3:5]).T @ upright(np.array([x_mm, y_mm, depth_mm]) - self.values[:3])

    def clearance_mm(self, way: Sequence[JointAngles], x_mm: float, y_mm: float, depth_mm: float) -> float:
        """How near the middles of the links come to a place, seen along the axles, while the joints turn from pose to pose.

        Both joints start and end each move together, as the command ``MA`` lets them.

        Parameters
        ----------
        way : sequence of JointAngles, two or more
        x_mm, y_mm, depth_mm : float, in the bench frame

        Returns
        -------
        float, mm
        """
        stops = np.array([[pose.theta1_deg, pose.theta2_deg] for pose in way], float) + self.values[5:7]
        moves = zip(stops[:-1], stops[1:], strict=True)
        looks = [np.linspace(a, b, 2 + int(np.abs(b - a).max() / LOOKED_DEG)) for a, b in moves]
        one, both = np.radians(np.concatenate(looks).cumsum(axis=1).T)
        place = self.in_arm(x_mm, y_mm, depth_mm)[:2]
        upper, fore = (
            length * np.column_stack([np.cos(turn), np.sin(turn)])
            for length, turn in zip(self.values[7:], (one, both), strict=True)
        )
        return float(min(_off(place, upper).min(), _off(place - upper, fore).min()))

    def differences(self, arm: TwoLinkArm) -> list[str]:
        """Sentences on what is surely not as told: the links and the zeros.

        Parameters
        ----------
        arm : TwoLinkArm, as it is told
        """
        told = dict(zip(NAMES, (0, 0, 0, 0, 0, 0, 0, arm.l1_mm, arm.l2_mm), strict=True))
        said = []
        if abs(wrap(self.values[3])) > BEHIND_DEG:
            told["zero 1"] = 180.0
            said.append(
                "Both joints turn the other way than the cameras see it: is the arm's back to them, or are both motors and their "
                "encoders connected the wrong way round?"
            )
        for name, unit, value, sigma in zip(NAMES, UNITS, self.values, self.sigmas, strict=True):
            off = value - told[name] if unit == "mm" else float(wrap(value - told[name]))
            worth = WORTH_MM if unit == "mm" else WORTH_DEG
            if name.startswith("link") and abs(off) > max(SURE * sigma, worth):
                said.append(
                    f"{name.capitalize()} is {value:.1f} mm long (± {sigma:.1f}), not {told[name]:g}: measure it from axle to axle."
                )
            elif name.startswith("zero") and abs(off) > max(SURE * sigma, worth):
                said.append(
                    f"Joint {name[-1]} stands {off:+.1f} degrees (± {sigma:.1f}) beside what it says: "
                    f"set its `home` in the sketch {abs(off):.1f} degrees {'higher' if off > 0 else 'lower'}, or move its switch."
                )
        return said


def _off(places, links_N2):
    """How far places, seen from where a link begins, are from it, (N,)."""
    along = np.clip(np.sum(places * links_N2, axis=1) / np.sum(links_N2**2, axis=1), 0, 1)
    return np.linalg.norm(places - along[:, None] * links_N2, axis=1)

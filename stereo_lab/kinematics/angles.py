"""Joint angles, and what is asked of angles and points everywhere."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from numbers import Real

import numpy as np
from numpy.typing import ArrayLike

from stereo_lab.errors import StereoLabError

ANGLE_ROUNDING_DEG = 1e-9  # an angle this far beyond a limit is at the limit


@dataclass(frozen=True)
class JointAngles:
    """Both joint angles of an arm, or arrays of them.

    Attributes
    ----------
    theta1_deg : float or ndarray, of the shoulder, from the x axis
    theta2_deg : float or ndarray, of the elbow, from the first link
    """

    theta1_deg: float | np.ndarray
    theta2_deg: float | np.ndarray


def must_be_angles(angles: object, kind: type = JointAngles) -> None:
    """Refuse what is no JointAngles, or not of another kind of angles, such as a pair of numbers.

    Raises
    ------
    StereoLabError
    """
    if not isinstance(angles, kind):
        names = ", ".join(field.name for field in fields(kind))
        raise StereoLabError(f"Expected {kind.__name__}({names}), got {angles!r}.")


def are_limits(limits_deg: object, joints: int) -> bool:
    """Whether these are so many pairs of numbers, the lower one first in each."""
    try:
        pairs = [(low, high) for low, high in limits_deg]  # type: ignore[attr-defined]  # what has no pairs is caught
    except (TypeError, ValueError):
        return False
    numbers = all(isinstance(limit, Real) for pair in pairs for limit in pair)
    return len(pairs) == joints and numbers and all(low < high for low, high in pairs)


def must_be_limits(limits_deg: object) -> None:
    """Refuse what is not (low, high) for each of the two joints.

    Raises
    ------
    StereoLabError
    """
    if not are_limits(limits_deg, 2):
        raise StereoLabError(
            f"Expected (low, high) in degrees for each of two joints, as in ((-90, 90), (-120, 120)); got {limits_deg}."
        )


def within(angles_deg: Sequence[ArrayLike], limits_deg: Sequence[tuple[float, float]]) -> bool | np.ndarray:
    """Whether each of some angles is within its limits: bool, or an array of them."""
    fine: bool | np.ndarray = True
    for angle, (low, high) in zip(angles_deg, limits_deg, strict=True):
        angle = np.asarray(angle, float)
        fine = fine & (angle >= low - ANGLE_ROUNDING_DEG) & (angle <= high + ANGLE_ROUNDING_DEG)
    return bool(fine) if np.ndim(fine) == 0 else fine


def points(x: ArrayLike, y: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
    """Two coordinates as float arrays of one shape; a single point must be finite."""
    try:
        x, y = np.broadcast_arrays(np.asarray(x, float), np.asarray(y, float))
    except (TypeError, ValueError):
        raise StereoLabError(f"Expected coordinates in mm as numbers; got {x!r} and {y!r}.") from None
    if x.ndim == 0 and not (np.isfinite(x) and np.isfinite(y)):
        raise StereoLabError(f"Expected coordinates in mm as finite numbers; got {x} and {y}.")
    return x, y


def wrap(angle_deg: ArrayLike) -> np.ndarray:
    """Angles in (−180, 180]."""
    angle = np.asarray(angle_deg, float)
    return np.where(
        (angle > -180) & (angle <= 180), angle, 180 - (180 - angle) % 360
    )  # what is right keeps its last digit

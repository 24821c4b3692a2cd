"""What a function gives when it is tried, and whether two numbers are taken for one."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

EXACT = 1e-9  # where another number might be near by chance
NEAR = 1e-3  # so near, as a part of the value, two numbers are taken for one


def called(function: Callable, arguments: tuple) -> Any:
    """What a function gives for copies of the arguments, for it may write into them; numpy's warnings are not shown."""
    with np.errstate(all="ignore"):
        return function(*(np.copy(a) if isinstance(a, np.ndarray) else a for a in arguments))


def numbers_of(function: Callable, arguments: tuple) -> np.ndarray | None:
    """What a function gives, in a row; None where it stops, or gives what is no finite number."""
    try:
        with np.errstate(all="ignore"):
            numbers = np.asarray(called(function, arguments), float).ravel()
    except Exception:
        return None
    return numbers if numbers.size and np.isfinite(numbers).all() else None


def near(value: Any, other: Any, room: float = NEAR) -> bool:
    """Whether numbers lie so near to others, as a part of the largest of those."""
    value, other = np.asarray(value, float), np.asarray(other, float)
    if value.shape != other.shape or not np.isfinite(value).all():
        return False
    return bool(np.all(np.abs(value - other) <= room * np.abs(other).max(initial=1e-12)))


def is_as(value: Any, numbers: Any, room: float = NEAR) -> bool:
    """The same for a value of any kind."""
    try:
        return near(np.ravel(np.asarray(value, float)), numbers, room)
    except (TypeError, ValueError):
        return False

"""Vectors and arrays."""

from __future__ import annotations

import functools
from collections.abc import Callable

import numpy as np

CROSS = np.zeros((3, 3, 3))
for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
    CROSS[i, k, j], CROSS[i, j, k] = 1, -1


def cross(vectors: np.ndarray) -> np.ndarray:
    """The matrices that take the cross product with vectors, shapes (..., 3) and (..., 3, 3)."""
    return (vectors @ CROSS.reshape(3, 9)).reshape(*vectors.shape, 3)


def as_arrays(function: Callable) -> Callable:
    """The same function, but that what it gives is an array."""

    @functools.wraps(function)
    def as_array(*arguments):
        return np.array(function(*arguments))

    return as_array

"""Vectors and arrays."""

from __future__ import annotations

import functools
from collections.abc import Callable

import numpy as np

X, Y, Z = np.eye(3)
CROSS = np.stack([0 * X, -Z, Y, Z, 0 * X, -X, -Y, X, 0 * X], 1)  # the nine entries of the matrix, row by row


def cross(vectors: np.ndarray) -> np.ndarray:
    """The matrices that take the cross product with vectors, shapes (..., 3) and (..., 3, 3)."""
    return (vectors @ CROSS).reshape(*vectors.shape, 3)


def as_arrays(function: Callable) -> Callable:
    """The same function, but that what it gives is an array."""

    @functools.wraps(function)
    def as_array(*arguments):
        return np.array(function(*arguments))

    return as_array

"""Vectors and arrays."""

from __future__ import annotations

import functools
from collections.abc import Callable

import numpy as np


def cross(vectors: np.ndarray) -> np.ndarray:
    """The matrices that take the cross product with vectors, shapes (..., 3) and (..., 3, 3)."""
    found = np.zeros((*vectors.shape, 3))
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        found[..., k, j], found[..., j, k] = vectors[..., i], -vectors[..., i]
    return found


def as_arrays(function: Callable) -> Callable:
    """The same function, but that what it gives is an array."""

    @functools.wraps(function)
    def as_array(*arguments):
        return np.array(function(*arguments))

    return as_array

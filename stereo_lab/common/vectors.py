"""Vectors and arrays."""

from __future__ import annotations

import functools
import reprlib
from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from stereo_lab.errors import StereoLabError

X, Y, Z = np.eye(3)
CROSS = np.stack([0 * X, -Z, Y, Z, 0 * X, -X, -Y, X, 0 * X], 1)  # the nine entries of the matrix, row by row

DISTORTIONS = 4, 5, 8, 12, 14  # so many numbers of it OpenCV knows


def cross(vectors: np.ndarray) -> np.ndarray:
    """The matrices that take the cross product with vectors, shapes (..., 3) and (..., 3, 3)."""
    return (vectors @ CROSS).reshape(*vectors.shape, 3)


def tangent_circle(center_mm: ArrayLike, radius_mm: float, count: int = 60) -> np.ndarray:
    """Where the rays from the camera touch a ball, its centre in the camera's frame: points, shape (count, 3), mm."""
    center = np.asarray(center_mm, float)
    distance = np.linalg.norm(center)
    near = 1 - (radius_mm / distance) ** 2
    across = np.linalg.svd(center[None] / distance)[2][1:]
    angle = np.linspace(0, 2 * np.pi, count, endpoint=False)
    return near * center + radius_mm * np.sqrt(near) * np.column_stack([np.cos(angle), np.sin(angle)]) @ across


def as_numbers(values: ArrayLike) -> np.ndarray:
    """An array of float of whatever shape.

    Raises
    ------
    StereoLabError
        If they are no numbers, or rows of several lengths.
    """
    try:
        return np.asarray(values, float)
    except (TypeError, ValueError):
        raise StereoLabError(f"Expected numbers, in rows of one length; got {reprlib.repr(values)}.") from None


def as_camera(camera: object) -> tuple[np.ndarray, np.ndarray]:
    """One camera as OpenCV takes it: its matrix, shape (3, 3), and its distortion, for which None may stand.

    Raises
    ------
    StereoLabError
        If it is something else, such as a whole calibration.
    """
    try:
        matrix, distortion = (np.asarray(part if part is not None else np.zeros(5), float) for part in camera)  # type: ignore[attr-defined]
        right = matrix.shape == (3, 3) and matrix[0, 0] > 0 and distortion.size in DISTORTIONS
    except (TypeError, ValueError):
        right = False
    if not right:
        raise StereoLabError(
            f'Expected one camera, (matrix of shape (3, 3), distortion), as calibration.camera("left") gives it; got {reprlib.repr(camera)}.'
        )
    return matrix, distortion


def as_points(points: ArrayLike, numbers: int, error: type[StereoLabError] = StereoLabError) -> np.ndarray:
    """Points of so many numbers each, shape (N, numbers); one point alone counts as a row.

    Raises
    ------
    StereoLabError, or of the kind that is told
        If they have another shape, or are no numbers.
    """
    try:
        given = np.asarray(points, float)
    except (TypeError, ValueError):
        raise error(f"Expected points of {numbers} numbers each; these are no numbers.") from None
    if given.size == 0:
        return np.empty((0, numbers))
    if given.shape[-1:] != (numbers,):
        raise error(f"Expected points of {numbers} numbers each, shape (N, {numbers}); got {given.shape}.")
    return given.reshape(-1, numbers)


def for_each(values: ArrayLike, shape: tuple[int, ...]) -> np.ndarray:
    """Standard deviations for each coordinate of some points: one for all, one for each direction, or each its own.

    Raises
    ------
    StereoLabError
        If they are no numbers, or not as many.
    """
    numbers = as_numbers(values)
    try:
        return np.broadcast_to(numbers, shape)
    except ValueError:
        raise StereoLabError(f"Expected as many standard deviations as points, {shape}; got {numbers.shape}.") from None


def as_arrays(function: Callable) -> Callable:
    """The same function, but that what it gives is an array."""

    @functools.wraps(function)
    def as_array(*arguments):
        return np.array(function(*arguments))

    return as_array

"""Lesson 02: the circular Hough transform, written out. ``cv2.HoughCircles`` is the same idea, made fast."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

from stereo_lab.common.threads import one_thread

LEAST_SLOPE = 60.0  # of the brightness, per px: weaker slopes are no edge


def edges(grey: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Edge pixels and the direction in which it gets brighter there.

    Parameters
    ----------
    grey : ndarray, shape (height, width), uint8; the blurred mask

    Returns
    -------
    points_Nx2 : (u, v) of the edge pixels
    directions_Nx2 : unit vectors towards the bright side
    """
    du, dv = cv2.Sobel(grey, cv2.CV_32F, 1, 0), cv2.Sobel(grey, cv2.CV_32F, 0, 1)
    length = np.hypot(du, dv)
    v, u = np.nonzero(length > LEAST_SLOPE)
    directions = np.column_stack([du[v, u], dv[v, u]]) / length[v, u][:, None]
    return np.column_stack([u, v]), directions


def vote(points_Nx2: np.ndarray, directions_Nx2: np.ndarray, radius_px: float, shape: tuple[int, ...]) -> np.ndarray:
    """Every edge pixel gives one vote: to the place one radius away, on the bright side.

    Parameters
    ----------
    points_Nx2, directions_Nx2 : from :func:`edges`
    radius_px : float
    shape : (height, width) of the picture

    Returns
    -------
    ndarray of int, shape (height, width): votes for a centre there
    """
    places = np.rint(points_Nx2 + radius_px * directions_Nx2).astype(int)
    inside = ((places >= 0) & (places < [shape[1], shape[0]])).all(1)
    votes = np.zeros(shape, int)
    np.add.at(votes, (places[inside, 1], places[inside, 0]), 1)
    return votes


def hough_circle(
    grey: np.ndarray, radii_px: Sequence[float] | np.ndarray
) -> tuple[tuple[float, float, float], np.ndarray]:
    """The circle with the most votes for each pixel of its rim: (u, v, radius) and the accumulator.

    Returns
    -------
    circle : (u, v, radius_px)
    accumulator : ndarray, shape (len(radii_px), height, width): the three dimensions of the transform
    """
    points, directions = edges(grey)
    layers = [vote(points, directions, radius, grey.shape) for radius in radii_px]
    pooled = np.array([cv2.boxFilter(layer.astype(np.float32), -1, (3, 3), normalize=False) for layer in layers])
    share = pooled / (2 * np.pi * np.asarray(radii_px, float))[:, None, None]
    k, v, u = (int(i) for i in np.unravel_index(share.argmax(), share.shape))
    return (float(u), float(v), float(radii_px[k])), np.array(layers)


def library_circle(grey: np.ndarray, least_px: int, largest_px: int) -> tuple[float, float, float] | None:
    """The same by ``cv2.HoughCircles``: (u, v, radius) of the circle with the most votes, or None."""
    with one_thread():
        found = cv2.HoughCircles(
            grey,
            cv2.HOUGH_GRADIENT,
            1,
            max(grey.shape),
            param1=200,
            param2=10,
            minRadius=least_px,
            maxRadius=largest_px,
        )
    if found is None:
        return None
    u, v, radius = (float(x) for x in found.reshape(-1, found.shape[-1])[0, :3])
    return u, v, radius

"""Lesson 02: the circular Hough transform, written out. ``cv2.HoughCircles`` is the same idea, made fast."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

from stereo_lab.common.threads import one_thread
from stereo_lab.detection.model import Circle

LEAST_SLOPE = 60.0  # of the brightness, per px: weaker slopes are no edge
MISS_PX, MISS = 1.5, 0.1  # px, or of the radius: a vote that misses the centre by so little is one for it


def edges(grey: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Edge pixels (u, v) of a blurred mask, shape (N, 2), and unit vectors towards the bright side, shape (N, 2)."""
    du, dv = cv2.Sobel(grey, cv2.CV_32F, 1, 0), cv2.Sobel(grey, cv2.CV_32F, 0, 1)
    length = np.hypot(du, dv)
    v, u = np.nonzero(length > LEAST_SLOPE)
    directions = np.column_stack([du[v, u], dv[v, u]]) / length[v, u][:, None]
    return np.column_stack([u, v]), directions


def vote(points_Nx2: np.ndarray, directions_Nx2: np.ndarray, radius_px: float, shape: tuple[int, ...]) -> np.ndarray:
    """Every edge pixel gives one vote: to the place one radius away, on the bright side.

    Returns
    -------
    ndarray of int, of the picture's ``shape`` (height, width): votes for a centre there
    """
    places = np.rint(points_Nx2 + radius_px * directions_Nx2).astype(int)
    u, v = places[((places >= 0) & (places < [shape[1], shape[0]])).all(1)].T
    return np.bincount(v * shape[1] + u, minlength=shape[0] * shape[1]).reshape(shape)


def hough_circle(grey: np.ndarray, radii_px: Sequence[float] | np.ndarray) -> tuple[Circle, np.ndarray]:
    """The circle with the most votes for each pixel of its rim: (u, v, radius) and the accumulator.

    The accumulator, shape (len(radii_px), height, width), has the three dimensions of the transform.
    """
    points, directions = edges(grey)
    layers = [vote(points, directions, radius, grey.shape) for radius in radii_px]
    pooled = np.array([cv2.boxFilter(layer.astype(np.float32), -1, (3, 3), normalize=False) for layer in layers])
    share = pooled / (2 * np.pi * np.asarray(radii_px, float))[:, None, None]
    k, v, u = (int(i) for i in np.unravel_index(share.argmax(), share.shape))
    return (float(u), float(v), float(radii_px[k])), np.array(layers)


def library_circle(grey: np.ndarray, least_px: int, largest_px: int) -> Circle | None:
    """The same by ``cv2.HoughCircles``: (u, v, radius) of the circle with the most votes, or None."""
    with one_thread():
        found = cv2.HoughCircles(
            grey, cv2.HOUGH_GRADIENT, 1, max(grey.shape), param1=200, param2=10, minRadius=least_px, maxRadius=largest_px
        )  # fmt: skip
    if found is None:
        return None
    u, v, radius = (float(x) for x in found.reshape(-1, found.shape[-1])[0, :3])
    return u, v, radius


def rim_share(grey: np.ndarray, circle: Circle) -> float:
    """The part of a circle's rim, 0…1, from which a vote for its centre comes."""
    u, v, radius = circle
    left, top = max(0, int(u - radius - 3)), max(0, int(v - radius - 3))
    points, directions = edges(grey[top : int(v + radius + 4), left : int(u + radius + 4)])
    outward = points - (u - left, v - top)
    miss = np.hypot(*(outward + radius * directions).T)
    away = outward[miss < max(MISS_PX, MISS * radius)]
    length = max(1, round(2 * np.pi * radius))  # of the rim, px
    return len(np.unique(np.floor(np.arctan2(away[:, 1], away[:, 0]) / (2 * np.pi) * length) % length)) / length

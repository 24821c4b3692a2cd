"""Where the edge of a round thing lies, to a fraction of a pixel: rays from its centre, across its rim."""

from __future__ import annotations

from functools import cache

import cv2
import numpy as np

from stereo_lab.detection.color import BallColor

LEAST_CONTRAST = 10.0  # levels of linear light across the edge
LEAST_DROP = 0.3  # in likeness, 0…1, where the ball's colour ends
RAYS = 40, 140  # fewest and most

# Cameras store brightness on a curve (sRGB, close to the power 1/2.2). Blur mixes light, not stored
# values: on the stored ones the edge of a dark ball before a white wall would move inwards.
LINEAR = (255 * (np.arange(256) / 255.0) ** 2.2).astype(np.float32)


def edge_points(image: np.ndarray, u: float, v: float, radius: float, band: float) -> tuple[np.ndarray, np.ndarray]:
    """Where the colour changes along rays from a centre.

    Each ray is sampled from ``radius - band`` to ``radius + band``. Its colours are projected on the
    difference between its inner and its outer end; the edge is the centroid of the steepest change.

    Returns
    -------
    points : ndarray, shape (rays, 2), px
    strong : ndarray of bool, shape (rays,): the edge is clear, and inside the picture
    """
    ray, radii, x, y, step = _rays(u, v, radius, band)
    colors = _along(_light(image, x, y), max(0.1, 0.6 / step))
    third = max(2, len(radii) // 3)
    across = colors[:, :third].mean(1) - colors[:, -third:].mean(1)
    contrast = np.linalg.norm(across, axis=1)
    unit = across / np.maximum(contrast, 1e-6)[:, None]
    slope = -np.diff(np.matmul(colors, unit[:, :, None])[..., 0], axis=1)
    place, steep = _peak(slope, (radii[:-1] + radii[1:]) / 2, step, 1.5)
    points = np.array([u, v]) + ray * place[:, None]
    return points, in_picture(points, image) & (contrast > LEAST_CONTRAST) & (steep > 0)


def color_edge(
    image: np.ndarray, u: float, v: float, radius: float, band: float, color: BallColor
) -> tuple[np.ndarray, np.ndarray]:
    """Where the ball's colour ends along rays from a centre; returns the same as :func:`edge_points`."""
    ray, radii, x, y, step = _rays(u, v, radius, band)
    colors = cv2.remap(image, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    likeness = _along(color.likeness(colors).astype(np.float32) / 255, max(0.7, 0.04 * radius) / step)
    third = max(2, len(radii) // 3)
    drop = likeness[:, :third].mean(1) - likeness[:, -third:].mean(1)
    place, steep = _peak(-np.diff(likeness, axis=1), (radii[:-1] + radii[1:]) / 2, step, max(1.5, 0.1 * radius))
    points = np.array([u, v]) + ray * place[:, None]
    return points, in_picture(points, image) & (drop > LEAST_DROP) & (steep > 0)


def in_picture(points: np.ndarray, image: np.ndarray) -> np.ndarray:
    """True for points that lie inside the picture, half a pixel from its border at least."""
    return np.all((points > 0.5) & (points < np.array(image.shape[1::-1]) - 1.5), axis=1)


def _rays(u, v, radius, band):
    """Directions, sample distances and sample places of rays across the rim of a circle."""
    ray = directions(int(min(max(2 * np.pi * radius, RAYS[0]), RAYS[1])))
    step = max(0.25, 2 * band / 64)
    radii = np.arange(max(0.0, radius - band), radius + band, step)
    x = (u + ray[:, :1] * radii).astype(np.float32)
    y = (v + ray[:, 1:] * radii).astype(np.float32)
    return ray, radii, x, y, step


@cache
def directions(count: int) -> np.ndarray:
    """Unit vectors all round, shape (count, 2)."""
    angle = np.arange(count) * 2 * np.pi / count
    return np.stack([np.cos(angle), np.sin(angle)], 1)


def _along(profiles, sigma):
    """Blur along the rays (axis 1) and not across them."""
    return cv2.GaussianBlur(profiles, (0, 0), sigmaX=sigma, sigmaY=0.01, borderType=cv2.BORDER_REPLICATE)


def _light(image, x, y):
    """Linear light at sub-pixel places of the picture, shape (*x.shape, 3)."""
    x0, y0 = max(0, int(x.min()) - 2), max(0, int(y.min()) - 2)
    part = cv2.LUT(image[y0 : int(y.max()) + 4, x0 : int(x.max()) + 4], LINEAR)
    return cv2.remap(part, x - x0, y - y0, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)


def _peak(slope, middle, step, reach_px):
    """Centroid of the slope round its highest value, for every ray."""
    best = slope.argmax(1)
    reach = max(2, int(round(reach_px / step)))
    ray = np.arange(len(best))
    index = np.minimum(np.maximum(best[:, None] + np.arange(-reach, reach + 1), 0), slope.shape[1] - 1)
    near = np.maximum(slope[ray[:, None], index], 0)
    place = (near * middle[index]).sum(1) / np.maximum(near.sum(1), 1e-9)
    return place, slope[ray, best]

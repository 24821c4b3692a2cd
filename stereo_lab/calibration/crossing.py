"""Where two edges cross: a corner of a chessboard, placed by a model of the brightness round it.

Round a corner, brightness is mean + height · edge(a) · edge(b) + slope_u · u + slope_v · v. Here a and b are the
distances from the two lines that cross there; edge(a) = tanh(a / blur) goes from −1 to 1 across a line; the slopes are
those of the light on the board. Nine unknowns are fitted to the pixels of a disc, by Gauss-Newton, for all corners of a
picture at once.
"""

from __future__ import annotations

import numpy as np

DISC = 0.6  # radius as a part of the square: farther out the next lines begin
LEAST_PX, MOST_PX = 3, 15
ROUNDS = 10
STEP = np.array([1, 1, 0.2, 0.2, 0.3])  # the most that a round may change: u and v (px), two turns (radians), blur (px)
BLUR_PX = 0.3, 5.0
STILL_PX = 1e-3
SOFT_PX = 1.0  # so far a marker's edge reaches into the white round it


def place_corners(
    grey: np.ndarray,
    start_RxCx2: np.ndarray,
    there: np.ndarray | None = None,
    plain: tuple[float, np.ndarray] | None = None,
) -> np.ndarray:
    """Corners to a fraction of a pixel.

    Parameters
    ----------
    grey : ndarray, uint8
    start_RxCx2 : ndarray, the corners to about a pixel, row by row
    there : ndarray of bool, shape (rows * columns,), optional
        The corners that are in the picture; the others only tell how the lines go, and are NaN in the answer.
    plain : (float, ndarray of bool), optional
        Where white squares hold markers: how far from a corner's two lines they are plain, as a part of the square, and for each
        corner whether its white squares are the upper left and the lower right one. Pixels of markers are then left out.

    Returns
    -------
    ndarray, shape (rows * columns, 2). Where the model does not fit, a corner stays where it was.
    """
    return place_and_blur(grey, start_RxCx2, there, plain)[0]


def place_and_blur(
    grey: np.ndarray,
    start_RxCx2: np.ndarray,
    there: np.ndarray | None = None,
    plain: tuple[float, np.ndarray] | None = None,
) -> tuple[np.ndarray, float]:
    """The same as :func:`place_corners`, and how wide the edges are: the median blur, px."""
    grid = np.asarray(start_RxCx2, float)
    there = np.ones(grid[..., 0].size, bool) if there is None else there
    corners = grid.reshape(-1, 2)[there]
    along = [np.gradient(grid, axis=axis).reshape(-1, 2)[there] for axis in (1, 0)]
    square = min(np.linalg.norm(step, axis=1).min() for step in along)
    radius = int(np.clip(round(DISC * square), LEAST_PX, MOST_PX))
    if min(grey.shape) <= 2 * radius:
        return _all(corners, there), BLUR_PX[0]
    middle = np.clip(corners.round().astype(int), radius, np.array(grey.shape[::-1]) - 1 - radius)
    v, u = np.mgrid[-radius : radius + 1, -radius : radius + 1]
    disc = u**2 + v**2 <= (radius + 0.5) ** 2
    u, v = u[disc], v[disc]
    seen = grey[middle[:, 1:] + v, middle[:, :1] + u].astype(float)
    turns = [np.arctan2(step[:, 1], step[:, 0]) for step in along]
    geometry = np.column_stack([corners - middle, *turns, np.ones(len(corners))])
    counts = None if plain is None else _counts(along, u, v, corners - middle, plain[0], plain[1][there])
    geometry = _fit(geometry, u.astype(float), v.astype(float), seen, counts)
    placed = geometry[:, :2] + middle
    sane = np.linalg.norm(placed - corners, axis=1) <= radius / 2
    return _all(np.where(sane[:, None], placed, corners), there), float(np.median(geometry[:, 4]))


def _all(corners, there):
    every = np.full((len(there), 2), np.nan)
    every[there] = corners
    return every


def _counts(along, u, v, offset, margin, falling):
    """Whether a pixel counts, (N, P): it lies in a dark square, or so near to an edge that no marker is there."""
    squares = np.linalg.inv(np.stack(along, -1))
    a, b = np.einsum("nij,njp->inp", squares, np.stack([u - offset[:, :1], v - offset[:, 1:]], 1))
    white = (a * b > 0) == falling[:, None]
    plain = [
        np.abs(way) <= margin - SOFT_PX / np.linalg.norm(step, axis=1)[:, None]
        for way, step in zip((a, b), along, strict=True)
    ]
    return ~white | plain[0] | plain[1]


def _fit(geometry, u, v, seen, counts=None):
    """u, v, two turns and blur of every corner, shape (N, 5); only the pixels that count, where some do not."""
    for _ in range(ROUNDS):
        pattern, by_geometry = _pattern(geometry, u, v)
        by_light = np.stack(np.broadcast_arrays(pattern, 1.0, u / u.max(), v / v.max()), -1)
        light = _least_squares(by_light, seen, counts)
        slopes = np.concatenate([light[:, None, :1] * by_geometry, by_light], -1)
        step = _least_squares(slopes, seen - (by_light @ light[..., None])[..., 0], counts)[:, :5]
        geometry = geometry + np.clip(step, -STEP, STEP)
        geometry[:, 4] = np.clip(geometry[:, 4], *BLUR_PX)
        if np.abs(step[:, :2]).max() < STILL_PX:
            break
    return geometry


def _pattern(geometry, u, v):
    """edge(a) · edge(b) at every pixel, shape (N, P), and how it changes with the five, (N, P, 5)."""
    u, v = u - geometry[:, 0, None, None], v - geometry[:, 1, None, None]
    turn, blur = geometry[:, 2:4, None], geometry[:, 4, None, None]
    away, along = np.cos(turn) * v - np.sin(turn) * u, np.cos(turn) * u + np.sin(turn) * v  # of each of the two lines
    edge = np.tanh(away / blur)
    pull = (1 - edge**2) / blur * edge[:, ::-1]
    by_corner = [(np.sin(turn) * pull).sum(1), (-np.cos(turn) * pull).sum(1)]
    by_turns = list((-along * pull).transpose(1, 0, 2))
    return edge.prod(1), np.stack([*by_corner, *by_turns, (-away / blur * pull).sum(1)], -1)


def _least_squares(slopes, missing, counts=None):
    """For every corner the unknowns that explain what is missing, shape (N, unknowns)."""
    if counts is not None:
        slopes = slopes * counts[..., None]
    turned = slopes.transpose(0, 2, 1)
    matrix = turned @ slopes
    matrix += 1e-9 * np.trace(matrix, axis1=1, axis2=2)[:, None, None] * np.eye(matrix.shape[-1])
    return np.linalg.solve(matrix, turned @ missing[..., None])[..., 0]

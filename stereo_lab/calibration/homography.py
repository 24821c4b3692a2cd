"""Lesson 01: one picture of a flat board, and what it tells of the camera (Zhang's idea).

A board is flat, so a camera without distortion maps it to the picture by a 3x3 matrix, a homography.
Its first two columns are the board's two edges as the camera sees them. In truth they are at right
angles and of one length; that is two conditions on the camera for each picture.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from stereo_lab.calibration.cameras import as_points
from stereo_lab.errors import StereoLabError

TOO_LITTLE = 1e-6  # of the largest singular value: what is so small is rounding


def find_homography(board_Nx2: ArrayLike, pixels_Nx2: ArrayLike) -> np.ndarray:
    """The 3x3 matrix that takes board points to pixels, by least squares (``cv2.findHomography`` does the same).

    Each point gives two linear equations for the nine entries; the solution is the direction that
    all of them leave nearly unchanged (singular value decomposition).

    Parameters
    ----------
    board_Nx2 : array, points on the board, mm; four or more, not on one line
    pixels_Nx2 : array, the same points in the picture, px

    Returns
    -------
    ndarray, shape (3, 3), last entry 1

    Raises
    ------
    StereoLabError
        With fewer than four points, something in them that is no finite number, or so many of them on one line that
        the rest leave the matrix open.
    """
    board, pixels = as_points(board_Nx2, 2), as_points(pixels_Nx2, 2)
    if board.shape != pixels.shape or len(board) < 4:
        raise StereoLabError(f"A homography needs four points or more, (N, 2); got {board.shape} and {pixels.shape}.")
    _check_plane(board, "board")
    _check_plane(pixels, "picture")
    to_board, to_pixels = _normalizer(board), _normalizer(pixels)
    rows = []
    for (x, y), (u, v) in zip(apply(to_board, board), apply(to_pixels, pixels), strict=True):
        rows.append([x, y, 1, 0, 0, 0, -u * x, -u * y, -u])
        rows.append([0, 0, 0, x, y, 1, -v * x, -v * y, -v])
    values, directions = np.linalg.svd(np.array(rows))[1:]
    solution = directions[-1].reshape(3, 3)
    flat = np.linalg.svd(solution, compute_uv=False)
    # A second one fits as well, or it has no inverse
    if values[7] <= TOO_LITTLE * values[0] or flat[2] <= TOO_LITTLE * flat[0]:
        raise StereoLabError("All points but one lie on one line, or on one another: take four of which no three do.")
    homography = np.linalg.inv(to_pixels) @ solution @ to_board
    return homography / homography[2, 2]


def apply(homography: np.ndarray, points_Nx2: ArrayLike) -> np.ndarray:
    """Points through a homography, shape (N, 2)."""
    points = np.asarray(points_Nx2, float)
    lifted = np.column_stack([points, np.ones(len(points))]) @ homography.T
    return lifted[:, :2] / lifted[:, 2:]


def focal_from_homography(homography: ArrayLike, center_px: tuple[float, float]) -> float | None:
    """Focal length in px from one picture, with square pixels and a known principal point.

    The board's two edges are at right angles, h1ᵀ·W·h2 = 0, where W = diag(1/f², 1/f², 1) after the
    principal point is moved to (0, 0). That is one equation for 1/f² (Zhang 2000, Eq. 3). Where the
    board stands nearly upright towards the camera it says nothing, and the result is None.
    """
    shift = np.array([[1, 0, -center_px[0]], [0, 1, -center_px[1]], [0, 0, 1.0]])
    h = shift @ np.asarray(homography, float)
    h1, h2 = h[:, 0], h[:, 1]
    flat, deep = h1[0] * h2[0] + h1[1] * h2[1], h1[2] * h2[2]
    if abs(deep) < 1e-12 or -flat / deep <= 0:
        return None
    return float(np.sqrt(-flat / deep))


def _check_plane(points, where):
    """Refuse points that are no numbers, or that lie on one line."""
    if not np.isfinite(points).all():
        raise StereoLabError(f"A point on the {where} is not two finite numbers: leave it out, in both lists.")
    spread = np.linalg.svd(points - points.mean(0), compute_uv=False)
    if spread[1] <= TOO_LITTLE * spread[0]:
        raise StereoLabError(f"All points on the {where} lie on one line: take some beside it as well.")


def _normalizer(points):
    """Shift and scale that bring points to mean 0 and distance √2: the equations stay well conditioned."""
    mean = points.mean(0)
    scale = np.sqrt(2) / np.linalg.norm(points - mean, axis=1).mean()
    return np.array([[scale, 0, -scale * mean[0]], [0, scale, -scale * mean[1]], [0, 0, 1.0]])

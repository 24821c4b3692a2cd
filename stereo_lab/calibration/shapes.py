"""How a board may differ from a flat sheet of exact squares."""

from __future__ import annotations

import numpy as np

from stereo_lab.calibration.bundle import Shapes
from stereo_lab.recording import Board

BEND_MM, BEND_DEGREES = 2.0, (2, 3, 4)  # out of the plane: paper on card, damp or leaning
WARP_MM = 0.1  # in the plane: what a printer stretches from one end of the sheet to the other


def board_shapes(board: Board) -> Shapes:
    """The flat board, and smooth bends and weak warps of it; each shape moves its farthest corner by 1 mm.

    A shift, a turn or a tilt of the whole board is no shape: that is how it is held. Neither is a common
    scale, which no camera can see: that is the ruler's.
    """
    flat = np.asarray(board.corners_mm, float)
    middle = flat[:, :2] - flat[:, :2].mean(0)
    x, y = (middle / np.abs(middle).max()).T
    bends = [_beside_a_plane(x**p * y ** (degree - p), x, y) for degree in BEND_DEGREES for p in range(degree + 1)]
    ways = [(2, bend, BEND_MM) for bend in bends if bend is not None]
    warps = [_beside_a_plane(term, x, y) for term in (x * x, x * y, y * y)]
    ways += [(axis, warp, WARP_MM) for warp in warps if warp is not None for axis in (0, 1)]
    ways.append((0, y, WARP_MM))  # squares that lean
    columns = [_moves(axis, value) for axis, value, _ in ways]
    longer = _moves(0, x) - _moves(1, y)  # squares that are wider than high
    return Shapes(flat, np.stack([*columns, longer], -1), np.array([sigma for *_, sigma in ways] + [WARP_MM]))


def _moves(axis, value):
    """Each corner moved along one axis: shape (corners, 3)."""
    return np.asarray(value)[:, None] * np.eye(3)[axis]


def _beside_a_plane(value, x, y):
    """What is left of a shape when its plane is taken out, 1 at most; None where nothing is left."""
    plane = np.column_stack([np.ones_like(x), x, y])
    rest = value - plane @ np.linalg.lstsq(plane, value, rcond=None)[0]
    return rest / np.abs(rest).max() if np.abs(rest).max() > 1e-6 else None

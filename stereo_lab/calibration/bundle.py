"""One least-squares problem: both cameras, where every board was held, and the board's own shape (bundle adjustment).

The steps of one round (Gauss-Newton, damped as by Levenberg and Marquardt):

1. :func:`look`: where would the cameras see every corner, and how does that change with each unknown?
2. :func:`equations`: what is missing to where they were seen, as normal equations, board by board. Where a board was
   held concerns that board alone, so those six unknowns are taken out of its equations (the Schur complement).
3. :func:`fit`: add up all boards, solve for what they share, step there, and look again.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np

from stereo_lab.common.vectors import cross

LENS = ("fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3")
LEFT, RIGHT, TURN, STEP = slice(0, 9), slice(9, 18), slice(18, 21), slice(21, 24)
CAMERAS = 24  # unknowns of the two cameras: nine each, and the right one's turn and step from the left one
MOST_ROUNDS = 60
CONVERGED = 1e-8  # what a round may still gain, in variances of one coordinate
MOST_DAMPING = 1e6
NOTHING = np.zeros(3)
EXACT = (cv2.TERM_CRITERIA_COUNT + cv2.TERM_CRITERIA_EPS, 60, 1e-9)  # for undoing the distortion


@dataclass(frozen=True, eq=False)
class Rig:
    """Two cameras.

    Attributes
    ----------
    left, right : ndarray, shape (9,), each one's fx, fy, cx, cy (px), k1, k2, p1, p2, k3
    rotation, translation : ndarray, shapes (3, 3) and (3,), from the left camera to the right one, mm
    """

    left: np.ndarray
    right: np.ndarray
    rotation: np.ndarray
    translation: np.ndarray

    def moved(self, by: np.ndarray) -> Rig:
        """The rig with its 24 unknowns changed by so much."""
        return Rig(
            self.left + by[LEFT], self.right + by[RIGHT], turn(by[TURN]) @ self.rotation, self.translation + by[STEP]
        )


@dataclass(frozen=True, eq=False)
class Boards:
    """The boards: their one shape, and where each was held.

    Attributes
    ----------
    bends : ndarray, shape (shapes,), how much of each shape there is, mm
    turns, shifts : ndarray, shapes (boards, 3, 3) and (boards, 3), from each board to the left camera, mm
    """

    bends: np.ndarray
    turns: np.ndarray
    shifts: np.ndarray

    def moved(self, bends: np.ndarray, held: np.ndarray) -> Boards:
        """The boards bent by so much more, and each turned and shifted by its six numbers, shape (boards, 6)."""
        turns = np.array([turn(v) @ t for v, t in zip(held[:, :3], self.turns, strict=True)])
        return Boards(self.bends + bends, turns, self.shifts + held[:, 3:])

    def some(self, chosen: np.ndarray) -> Boards:
        """Some of the boards only."""
        return replace(self, turns=self.turns[chosen], shifts=self.shifts[chosen])


@dataclass(frozen=True, eq=False)
class Shapes:
    """The board: flat, and the ways in which it may not be.

    Attributes
    ----------
    flat : ndarray, shape (corners, 3), mm
    ways : ndarray, shape (corners, 3, shapes): by how much a millimetre of each shape moves each corner
    sigma_mm : ndarray, shape (shapes,), how much of each is to be expected
    """

    flat: np.ndarray
    ways: np.ndarray
    sigma_mm: np.ndarray


def turn(vector: np.ndarray) -> np.ndarray:
    """Rotation matrix of a rotation vector (``cv2.Rodrigues``)."""
    return cv2.Rodrigues(np.asarray(vector, float))[0]


def matrices(lens: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Matrix and distortion of a camera as OpenCV writes them, from its nine numbers."""
    fx, fy, cx, cy = lens[:4]
    return np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1]]), lens[4:]


def project(points: np.ndarray, lens: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Pixels of points in a camera's frame, and how they change (``cv2.projectPoints``).

    Parameters
    ----------
    points : ndarray, shape (..., 3), mm
    lens : ndarray, shape (9,)

    Returns
    -------
    pixels : ndarray, shape (..., 2)
    by_point, by_lens : ndarray, shapes (..., 2, 3) and (..., 2, 9), px per mm and px per unit of the lens
    """
    pixels, slopes = cv2.projectPoints(points.reshape(-1, 1, 3), NOTHING, NOTHING, *matrices(lens))
    shape = points.shape[:-1]
    slopes = slopes.reshape(*shape, 2, -1)  # by turn 0-2, shift 3-5, focal lengths, centre, distortion
    return pixels.reshape(*shape, 2), slopes[..., 3:6], slopes[..., 6:15]


def look(rig: Rig, boards: Boards, shapes: Shapes) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Where the cameras would see all corners of all boards, and how that changes.

    Returns
    -------
    pixels : ndarray, shape (boards, corners, 2 cameras, 2)
    by_shared, by_held : ndarray, the same with another axis: of the unknowns that all share, and of the six of the board
    """
    corners = shapes.flat + shapes.ways @ boards.bends
    turned = corners @ boards.turns.transpose(0, 2, 1)
    in_left = turned + boards.shifts[:, None]
    turned_on = in_left @ rig.rotation.T
    left, left_by_point, left_by_lens = project(in_left, rig.left)
    right, right_by_point, right_by_lens = project(turned_on + rig.translation, rig.right)
    by_point = np.stack([left_by_point, right_by_point @ rig.rotation], 2)

    by_shared = np.zeros((*by_point.shape[:-1], CAMERAS + shapes.ways.shape[-1]))
    by_shared[:, :, 0, :, LEFT] = left_by_lens
    by_shared[:, :, 1, :, RIGHT] = right_by_lens
    by_shared[:, :, 1, :, TURN] = right_by_point @ -cross(turned_on)
    by_shared[:, :, 1, :, STEP] = right_by_point
    by_corner = by_point @ boards.turns[:, None, None]
    by_shared[..., CAMERAS:] = by_corner @ shapes.ways[None, :, None]
    by_held = np.concatenate([by_point @ -cross(turned)[:, :, None], by_point], -1)
    return np.stack([left, right], 2), by_shared, by_held


@dataclass(frozen=True, eq=False)
class Equations:
    """Normal equations of every board, its own six unknowns taken out.

    Attributes
    ----------
    matrices, sides : ndarray, shapes (boards, shared, shared) and (boards, shared): what each board says of the shared
        unknowns
    back, held : ndarray: the six of a board follow as ``held - back @ shared``
    """

    matrices: np.ndarray
    sides: np.ndarray
    back: np.ndarray
    held: np.ndarray


def equations(
    by_shared: np.ndarray, by_held: np.ndarray, missing: np.ndarray, weights: np.ndarray, damping: float = 0.0
) -> Equations:
    """The normal equations, board by board; see :class:`Equations`.

    Parameters
    ----------
    by_shared, by_held : ndarray, as :func:`look` gives them
    missing : ndarray, shape (boards, corners, 2, 2), px: where corners were seen minus where they would be
    weights : ndarray, shape (boards, corners, 2), 0…1; 0 where a corner was not seen
    damping : float, Marquardt's share of the diagonal
    """
    root = np.sqrt(weights)[..., None]
    boards, seen = len(missing), missing[0].size
    a = (by_shared * root[..., None]).reshape(boards, seen, by_shared.shape[-1])
    b = (by_held * root[..., None]).reshape(boards, seen, 6)
    e = (missing * root).reshape(boards, seen, 1)
    at, bt = a.transpose(0, 2, 1), b.transpose(0, 2, 1)
    shared, mixed, held = at @ a, at @ b, bt @ b
    for square in (shared, held):
        diagonal = np.einsum("nii->ni", square)
        diagonal *= 1 + damping
    back = np.linalg.solve(held, np.concatenate([mixed.transpose(0, 2, 1), bt @ e], -1))
    back, alone = back[..., :-1], back[..., -1:]
    return Equations(shared - mixed @ back, (at @ e - mixed @ alone)[..., 0], back, alone[..., 0])


@dataclass(frozen=True, eq=False)
class Solution:
    """A fit, and what it says of itself.

    Attributes
    ----------
    rig, boards : Rig and Boards
    missing : ndarray, shape (boards, corners, 2 cameras, 2), px; of no meaning where a corner was not seen
    weights : ndarray, shape (boards, corners, 2)
    prior : ndarray, variance of each shared unknown, infinite where nothing is known
    variance : float, of one coordinate of a corner, px²
    equations : Equations at the solution
    """

    rig: Rig
    boards: Boards
    missing: np.ndarray
    weights: np.ndarray
    prior: np.ndarray
    variance: float
    equations: Equations

    @property
    def information(self) -> np.ndarray:
        """What boards and prior say of the shared unknowns together: the inverse of their covariance."""
        return self.equations.matrices.sum(0) / self.variance + np.diag(1 / self.prior)


def fit(
    rig: Rig, boards: Boards, seen: np.ndarray, weights: np.ndarray, shapes: Shapes, prior: np.ndarray, variance: float,
    enough: float = CONVERGED,
) -> Solution:  # fmt: skip
    """The cameras and boards that explain best where corners were seen.

    Parameters
    ----------
    rig, boards : Rig and Boards to start from
    seen : ndarray, shape (boards, corners, 2 cameras, 2), px; any finite number where the weight is 0
    weights : ndarray, shape (boards, corners, 2)
    shapes : Shapes
    prior : ndarray, shape (24 + shapes,), variance of each shared unknown round 0
    variance : float, of one coordinate, px², against which the prior is weighed
    enough : float, what a round may still gain when it is the last, in variances
    """
    damping = 1e-3
    pixels, by_shared, by_held = look(rig, boards, shapes)
    missing = seen - pixels
    cost = _cost(missing, weights, rig, boards, prior, variance)
    for _ in range(MOST_ROUNDS):
        told = equations(by_shared, by_held, missing, weights, damping)
        side = told.sides.sum(0) / variance - shared(rig, boards) / prior
        step = np.linalg.solve(told.matrices.sum(0) / variance + np.diag(1 / prior), side)
        new_rig, new_boards = rig.moved(step), boards.moved(step[CAMERAS:], told.held - told.back @ step)
        pixels, *slopes = look(new_rig, new_boards, shapes)
        new_cost = _cost(seen - pixels, weights, new_rig, new_boards, prior, variance)
        if new_cost <= cost:
            gain, damping = cost - new_cost, damping / 10
            rig, boards, missing, cost = new_rig, new_boards, seen - pixels, new_cost
            by_shared, by_held = slopes
            if gain < enough:
                break
        elif (damping := damping * 10) > MOST_DAMPING:
            break
    return Solution(rig, boards, missing, weights, prior, variance, equations(by_shared, by_held, missing, weights))


def shared(rig: Rig, boards: Boards) -> np.ndarray:
    """What a prior may speak of, in the order of the equations; the right camera's turn and step count from here."""
    return np.concatenate([rig.left, rig.right, np.zeros(6), boards.bends])


def _cost(missing, weights, rig, boards, prior, variance):
    return (weights[..., None] * missing**2).sum() / variance + (shared(rig, boards) ** 2 / prior).sum()

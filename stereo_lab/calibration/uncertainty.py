"""What a calibration knows, in millimetres: how far off a place may be that the cameras tell."""

from __future__ import annotations

import cv2
import numpy as np

from stereo_lab.calibration.bundle import CAMERAS, EXACT, LEFT, RIGHT, STEP, TURN, Rig, Solution, matrices, project
from stereo_lab.common.vectors import cross

FIELD = 13, 9  # places across and down at which the cameras' common field is looked at
MARGIN = 0.02  # of the picture, left out at its rim


def covariance(solution: Solution) -> np.ndarray:
    """Of the 24 unknowns of the two cameras, by what the boards and the prior say: shape (24, 24)."""
    return np.linalg.inv(solution.information)[:CAMERAS, :CAMERAS]


def without_each(solution: Solution) -> np.ndarray:
    """The information that is left without each of the boards: shape (boards, shared, shared)."""
    return solution.information - solution.equations.matrices / solution.variance


def moves_without(solution: Solution) -> np.ndarray:
    """By how much the shared unknowns move if a board is left out, for each board: shape (boards, shared).

    To first order: at the solution the sides of all boards and of the prior cancel. Without one board its own
    side is missing, and its own part of the information too. No fit is done again.
    """
    sides = solution.equations.sides[..., None] / solution.variance
    return -np.linalg.solve(without_each(solution), sides)[..., 0]


def rigs_without(solution: Solution) -> list[Rig]:
    """The two cameras as they would be without each of the boards, to first order."""
    return [solution.rig.moved(move) for move in moves_without(solution)]


def jackknife(solution: Solution) -> np.ndarray:
    """Covariance of the cameras' unknowns as the boards themselves show it, leaving out one at a time: shape (24, 24)."""
    moves = moves_without(solution)[:, :CAMERAS]
    count = len(moves)
    spread = moves - moves.mean(0)
    return (count - 1) / count * spread.T @ spread


def expected_jackknife(solution: Solution) -> np.ndarray:
    """What the jackknife gives on average where the model holds: somewhat more than the covariance, for few boards."""
    count, information = len(solution.equations.matrices), solution.information
    each = np.linalg.solve(without_each(solution), solution.equations.matrices / solution.variance)
    return ((count - 1) / count * each.sum(0) @ np.linalg.inv(information))[:CAMERAS, :CAMERAS]


def place_slopes(points: np.ndarray, rig: Rig) -> np.ndarray:
    """How places told by the cameras change with the cameras' unknowns.

    A ball at a place X is seen at four coordinates. The place that the cameras tell is the one that explains
    them best, so a change of the pixels by the cameras, B, must be made up by a change of the place: J·dX = −B·dθ,
    solved by least squares.

    Parameters
    ----------
    points : ndarray, shape (N, 3), mm, in the left camera's frame
    rig : Rig

    Returns
    -------
    ndarray, shape (N, 3, 24), mm per unit of each unknown
    """
    if not len(points):
        return np.zeros((0, 3, CAMERAS))
    turned = points @ rig.rotation.T
    _, left_by_point, left_by_lens = project(points, rig.left)
    _, right_by_point, right_by_lens = project(turned + rig.translation, rig.right)
    by_point = np.concatenate([left_by_point, right_by_point @ rig.rotation], 1)
    by_rig = np.zeros((len(points), 4, CAMERAS))
    by_rig[:, :2, LEFT], by_rig[:, 2:, RIGHT] = left_by_lens, right_by_lens
    by_rig[:, 2:, TURN], by_rig[:, 2:, STEP] = right_by_point @ -cross(turned), right_by_point
    return np.array([-cv2.solve(a, b, flags=cv2.DECOMP_QR)[1] for a, b in zip(by_point, by_rig, strict=True)])


def sigmas(slopes: np.ndarray, covariance: np.ndarray) -> np.ndarray:
    """Standard deviations of places, shape (N, 3), from how they change with what is uncertain, (N, 3, unknowns)."""
    return np.sqrt(np.maximum(np.einsum("nij,jk,nik->ni", slopes, covariance, slopes), 0))


def common_field(
    rig: Rig, size: tuple[int, int], depth_mm: float, count: tuple[int, int] = FIELD
) -> tuple[np.ndarray, np.ndarray]:
    """Places at one distance that both cameras see, evenly spread over the left picture.

    Returns
    -------
    points : ndarray, shape (N, 3), mm, in the left camera's frame
    pixels : ndarray, shape (N, 2), where the left camera sees them
    """
    across, down = (np.linspace(MARGIN, 1 - MARGIN, n) for n in count)
    pixels = np.stack(np.meshgrid(across, down), -1).reshape(-1, 2) * size
    flat = cv2.undistortPoints(pixels.reshape(-1, 1, 2), *matrices(rig.left), criteria=EXACT).reshape(-1, 2)
    points = np.column_stack([flat, np.ones(len(flat))]) * depth_mm
    seen = project(points @ rig.rotation.T + rig.translation, rig.right)[0]
    both = ((seen >= 0) & (seen <= np.subtract(size, 1))).all(1)
    return points[both], pixels[both]


def misfit(solution: Solution, size: tuple[int, int], depth_mm: float) -> float:
    """How much more the boards differ among themselves than the fit says: 1 where the model holds.

    The jackknife's sigma of depth by what it is on average, median over the field that both cameras see.
    """
    points, _ = common_field(solution.rig, size, depth_mm)
    slopes = place_slopes(points, solution.rig)
    told, shown = (sigmas(slopes, c)[:, 2] for c in (expected_jackknife(solution), jackknife(solution)))
    return float(np.median(shown / told)) if len(points) else 1.0

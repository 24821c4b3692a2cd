"""The least-squares side of a calibration: from corners to two cameras, and what they are worth on unseen pairs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from stereo_lab.errors import CalibrationError
from stereo_lab.recording import Board

SOLVER = 2  # counts up whenever the same boards give another calibration: those kept are then made anew
LENSES = {"brown": 0, "thin prism": cv2.CALIB_THIN_PRISM_MODEL}
FOLDS = 5
FEWEST = 3  # pairs without which nothing can be solved
FEWEST_TO_HOLD_OUT = 8
OUTLIER = 3.0  # times the median reprojection error
SHAPE_ROUNDS = 4
APART_PX, APART = 8.0, 6.0  # at least, and times the median: two pictures of two moments
BLIND = 0.5  # of the error of who guesses the mean board: a camera that tells no better knows nothing of the other


@dataclass(frozen=True, eq=False)
class View:
    """The corners of one pair.

    Attributes
    ----------
    name : str, of the pair
    left, right : ndarray, shape (corners, 2), px
    """

    name: str
    left: np.ndarray
    right: np.ndarray


@dataclass(frozen=True, eq=False)
class Fit:
    """One solution.

    Attributes
    ----------
    k1, d1, k2, d2 : ndarray, matrix and distortion of the left and of the right camera
    rotation, translation : ndarray, shapes (3, 3) and (3,), from left to right, mm
    rms : float, px, over both cameras
    errors : ndarray, shape (pairs, 2), px
    shape : ndarray, shape (corners, 3), mm: the board as it really is
    sides : RMS of each camera calibrated alone
    focal_sigma : float, standard deviation of the worse focal length, in percent
    """

    k1: np.ndarray
    d1: np.ndarray
    k2: np.ndarray
    d2: np.ndarray
    rotation: np.ndarray
    translation: np.ndarray
    rms: float
    errors: np.ndarray
    shape: np.ndarray
    sides: tuple[float, float]
    focal_sigma: float


def same_moment(views: Sequence[View], board: Board, size: tuple[int, int]) -> np.ndarray:
    """For each pair, whether its two pictures can be of one moment: shape (pairs,) of bool.

    Each camera alone tells where the board is. From the left camera's word and the middle of all pairs'
    rotations and translations follows where the right camera must see it. Where that tells the right pictures
    hardly better than the mean of all boards does, no pair is of one moment.
    """
    flat = board.corners_mm.astype(np.float32)
    left, right = [v.left for v in views], [v.right for v in views]
    try:
        solved = [cv2.calibrateCamera([flat] * len(views), points, size, None, None)[1:5] for points in (left, right)]
    except cv2.error:
        return np.ones(len(views), bool)
    turns = [[cv2.Rodrigues(r)[0] for r in side[2]] for side in solved]
    relative = [b @ a.T for a, b in zip(*turns, strict=True)]
    shifts = [b - r @ a for a, b, r in zip(solved[0][3], solved[1][3], relative, strict=True)]
    turn = cv2.Rodrigues(np.median([cv2.Rodrigues(r)[0] for r in relative], axis=0))[0]
    shift = np.median(shifts, axis=0)
    errors = []
    for turned, place, seen in zip(turns[0], solved[0][3], right, strict=True):
        told = cv2.projectPoints(flat, cv2.Rodrigues(turn @ turned)[0], turn @ place + shift, *solved[1][:2])[0]
        errors.append(np.linalg.norm(told.reshape(-1, 2) - seen, axis=1).mean())
    apart = np.array(errors)
    guessed = np.linalg.norm(np.array(right) - np.mean(right, axis=0), axis=2).mean(1)
    if np.median(apart) > max(APART_PX, BLIND * np.median(guessed)):
        return np.zeros(len(views), bool)
    return apart < np.maximum(APART_PX, APART * np.median(apart))


def _fit_without_outliers(views, board, size, lens):
    """Fit, drop the pairs whose error is far above the median, fit again."""
    kept = list(range(len(views)))
    while True:
        fit = _fit([views[i] for i in kept], board, size, lens)
        errors = np.sqrt((fit.errors**2).mean(1))
        bad = errors > OUTLIER * np.median(errors)
        if not bad.any() or len(kept) - bad.sum() < max(FEWEST, len(views) // 2):
            return fit, kept
        kept = [i for i, out in zip(kept, bad, strict=True) if not out]


def _fit(views, board, size, lens):
    """Each camera alone, then both together, and the board's shape in turn with them."""
    flat = board.corners_mm.astype(np.float32)
    left, right = [v.left for v in views], [v.right for v in views]
    try:
        sides = [_calibrate_alone(flat, points, size, lens) for points in (left, right)]
        (k1, d1), (k2, d2) = (side[1:3] for side in sides)
        shape = flat
        for _ in range(SHAPE_ROUNDS):
            solved = cv2.stereoCalibrateExtended(
                [shape] * len(views), left, right, k1, d1, k2, d2, size, np.eye(3), np.zeros((3, 1)),
                flags=lens | cv2.CALIB_USE_INTRINSIC_GUESS,
            )  # fmt: skip
            rms, k1, d1, k2, d2, rotation, translation = solved[:7]
            used_shape, shape = shape, _board_shape(shape, flat, left, right, solved)
    except (cv2.error, np.linalg.LinAlgError) as error:
        raise CalibrationError(
            "No two cameras explain these boards: the corners contradict each other. "
            "Check that left and right were taken at the same moment, and the board's size."
        ) from error
    return Fit(
        k1, d1.ravel(), k2, d2.ravel(), rotation, translation.ravel(), float(rms), np.asarray(solved[-1]).reshape(-1, 2),
        used_shape, (sides[0][0], sides[1][0]), max(side[3] for side in sides),
    )  # fmt: skip


def _calibrate_alone(flat, points, size, lens):
    """RMS, matrix, distortion and the focal length's standard deviation in percent."""
    solved = cv2.calibrateCameraExtended([flat] * len(points), points, size, None, None, flags=lens)
    rms, matrix, distortion, sigma = solved[0], solved[1], solved[2], solved[5]
    return float(rms), matrix, distortion, float(100 * sigma[0, 0] / matrix[0, 0])


def _board_shape(shape, flat, left, right, solved):
    """Move every board corner to where all views together put it (one least-squares step a corner).

    Turning, shifting or scaling the whole board is taken out again: only its shape is measured.
    """
    _, k1, d1, k2, d2, rotation, translation = solved[:7]
    normal, gradient = np.zeros((len(shape), 3, 3)), np.zeros((len(shape), 3))
    for seen_left, seen_right in zip(left, right, strict=True):
        _, rvec, tvec = cv2.solvePnP(shape, seen_left, k1, d1)
        turn = cv2.Rodrigues(rvec)[0]
        cameras = (
            (seen_left, k1, d1, turn, tvec),
            (seen_right, k2, d2, rotation @ turn, rotation @ tvec + translation),
        )
        for seen, matrix, distortion, turn_c, shift_c in cameras:
            pixels, jacobian = cv2.projectPoints(shape, cv2.Rodrigues(turn_c)[0], shift_c, matrix, distortion)
            by_point = jacobian[:, 3:6].reshape(-1, 2, 3) @ turn_c
            normal += np.einsum("nij,nik->njk", by_point, by_point)
            gradient += np.einsum("nij,ni->nj", by_point, seen - pixels.reshape(-1, 2))
    moved = shape + np.linalg.solve(normal, gradient[..., None])[..., 0]
    return _similar(moved, flat).astype(np.float32)


def _similar(points, target):
    """Turn, shift and scale ``points`` on to ``target`` (Umeyama)."""
    a, b = points - points.mean(0), target - target.mean(0)
    u, s, vt = np.linalg.svd(a.T @ b)
    mirror = np.diag([1, 1, np.sign(np.linalg.det(u @ vt))])
    scale = (s * np.diag(mirror)).sum() / (a**2).sum()
    return scale * a @ (u @ mirror @ vt) + target.mean(0)


def check_sides(fit: Fit) -> None:
    """Raise CalibrationError if the cameras stand one above the other, or left and right are swapped."""
    x, y, _ = fit.translation
    if abs(y) > abs(x):
        raise CalibrationError("One camera stands above the other. Put them side by side.")
    if x > 0:
        raise CalibrationError(
            "Left and right are swapped: the camera called right stands to the left of the other. "
            "Swap the folders (or the two patterns, or the two camera numbers)."
        )


def choose_lens(
    views: Sequence[View], board: Board, size: tuple[int, int]
) -> tuple[str, Fit, list[int], tuple[float | None, float | None]]:
    """The lens model that tells unseen pairs best: (name, fit, kept views, errors on unseen pairs)."""
    best = None
    for name, lens in LENSES.items():
        fit, kept = _fit_without_outliers(views, board, size, lens)
        if len(views) < FEWEST_TO_HOLD_OUT:
            return name, fit, kept, (None, None)
        errors = _heldout_errors(views, kept, board, size, lens)
        # A richer model must earn its place: a tenth better, or the plain one stays.
        if best is None or np.prod(errors) < 0.9 * np.prod(best[3]):
            best = name, fit, kept, errors
    return best  # type: ignore[return-value]  # there is a lens, so there is a best one


def _heldout_errors(views, kept, board, size, lens):
    """Mean rectified |Δv| (px) and diagonal error (%) of pairs that the fit has not seen.

    Outliers are left out of the fit, never of the test: every pair is held out once.
    """
    errors = []
    for fold in folds(len(views)):
        seen = [views[i] for i in kept if i not in fold]
        fit = _fit(seen, board, size, lens)
        errors += [unseen_errors(fit, views[i], board, size) for i in fold]
    return tuple(float(e) for e in np.mean(errors, 0))


def folds(count: int) -> list[list[int]]:
    """The numbers 0 to count - 1, shuffled once and for all and dealt out to FOLDS heaps.

    Boards that follow each other are often alike: dealt out in their order, a heap would hold all of one kind.
    """
    shuffled = np.random.default_rng(0).permutation(count).tolist()
    return [shuffled[fold::FOLDS] for fold in range(FOLDS)]


def unseen_errors(fit: Fit, view: View, board: Board, size: tuple[int, int]) -> tuple[float, float]:
    """Mean |Δv| after rectification (px) and mean error of the two diagonals of the board (%)."""
    rectified = cv2.stereoRectify(
        fit.k1, fit.d1, fit.k2, fit.d2, size, fit.rotation, fit.translation.reshape(3, 1), alpha=0
    )
    r1, r2, p1, p2 = rectified[:4]
    left = cv2.undistortPoints(view.left.reshape(-1, 1, 2), fit.k1, fit.d1, R=r1, P=p1).reshape(-1, 2)
    right = cv2.undistortPoints(view.right.reshape(-1, 1, 2), fit.k2, fit.d2, R=r2, P=p2).reshape(-1, 2)
    points = cv2.triangulatePoints(p1, p2, left.T.astype(float), right.T.astype(float))
    points = (points[:3] / points[3]).T
    n = board.columns
    lengths = [np.linalg.norm(points[i] - points[j]) for i, j in ((0, -1), (n - 1, len(points) - n))]
    diagonal = board.square_mm * np.hypot(board.columns - 1, board.rows - 1)
    return np.abs(left[:, 1] - right[:, 1]).mean(), 100 * np.abs(np.array(lengths) / diagonal - 1).mean()


def why_dropped(fit: Fit, view: View, board: Board, size: tuple[int, int]) -> str:
    """In words, why a pair does not fit the others."""
    alone = []
    for points, matrix, distortion in ((view.left, fit.k1, fit.d1), (view.right, fit.k2, fit.d2)):
        _, rvec, tvec = cv2.solvePnP(fit.shape, points, matrix, distortion)
        error = cv2.projectPoints(fit.shape, rvec, tvec, matrix, distortion)[0].reshape(-1, 2) - points
        alone.append(np.sqrt((error**2).sum(1).mean()))
    vertical = unseen_errors(fit, view, board, size)[0]
    if max(alone) > OUTLIER * fit.rms:
        side = ("left", "right")[int(np.argmax(alone))]
        return f"corners of the {side} picture are off by {max(alone):.2f} px: blurred, bent or partly hidden"
    return f"the two pictures do not match ({vertical:.2f} px apart): were they taken at the same moment?"

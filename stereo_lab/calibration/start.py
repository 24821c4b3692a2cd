"""Where the fit starts: each camera alone, and which pairs show one moment."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

from stereo_lab.calibration.bundle import CAMERAS, LENS, Boards, Rig, Shapes, fit, matrices, project, turn
from stereo_lab.calibration.views import View, stacked
from stereo_lab.errors import CalibrationError

SURE = 0.4  # part of the pairs that must agree for the cameras' places to be known
APART_PX, APART = 8.0, 6.0  # at least, and times what the best SURE of the pairs show: two pictures of two moments
THREE = 3  # views that agree, from which two cameras can be fitted
K1_ALONE = {"k1": 0.1, "k2": 1e-6, "p1": 1e-8, "p2": 1e-8, "k3": 1e-8}  # variances: a lens as simple as few boards tell
BLIND = 0.5  # of the error of who guesses the mean board: a camera that tells no better knows nothing of the other


def first_rig(
    views: Sequence[View], flat: np.ndarray, size: tuple[int, int], shapes: int
) -> tuple[Rig, Boards, np.ndarray]:
    """Cameras and boards to start from, and for each view whether its pictures are of one moment.

    Each camera alone tells its focal length (``cv2.initCameraMatrix2D``) and where every board was
    (``cv2.solvePnP``). Each pair so tells where the right camera stands. The pair that most others agree with is
    believed.

    Raises
    ------
    CalibrationError
        If hardly any two pairs agree.
    """
    lenses = [_lens_alone([getattr(v, side) for v in views], flat, size) for side in ("left", "right")]
    poses = [
        [board_pose(getattr(v, side), flat, lens) for v in views]
        for side, lens in zip(("left", "right"), lenses, strict=True)
    ]
    both = [k for k, (a, b) in enumerate(zip(*poses, strict=True)) if a is not None and b is not None]
    if not both:
        raise CalibrationError("No board was seen by both cameras.")
    relative = [_from_left_to_right(poses[0][k], poses[1][k]) for k in both]
    errors = _errors([views[k] for k in both], flat, [poses[0][k] for k in both], relative, lenses[1])
    rank = max(0, round(SURE * len(both)) - 1)
    sure = np.sort(errors, axis=1)[:, rank]
    best = int(sure.argmin())
    together = np.ones(len(views), bool)
    together[both] = errors[best] < max(APART_PX, APART * sure[best])
    if sure[best] > max(APART_PX, BLIND * _guess([views[k] for k in both])):
        together[both] = False
    rotation, translation = relative[best]
    held = [a if a is not None else _from_right(b, rotation, translation) for a, b in zip(*poses, strict=True)]
    boards = Boards(np.zeros(shapes), np.array([turn for turn, _ in held]), np.array([shift for _, shift in held]))
    rig = Rig(lenses[0], lenses[1], rotation, translation)
    if THREE <= together.sum() < len(views):
        together |= _fit_after_all(views, flat, rig, boards, together)
    return rig, boards, together


def _fit_after_all(views, flat, rig, boards, together):
    """Which views fit cameras that are fitted to those that agree: of few boards the start knows too little to judge."""
    seen, there = stacked([view for view, same in zip(views, together, strict=True) if same])
    prior = np.full(CAMERAS, np.inf)
    for name, variance in K1_ALONE.items():
        prior[[LENS.index(name), len(LENS) + LENS.index(name)]] = variance
    flat_board = Shapes(flat, np.zeros((len(flat), 3, 0)), np.zeros(0))
    held = Boards(np.zeros(0), boards.turns[together], boards.shifts[together])
    better = fit(rig, held, seen, there.astype(float), flat_board, prior, 1.0).rig
    return np.array([_off(view, flat, better) < APART_PX for view in views])


def _off(view, flat, rig):
    """Mean distance of the right corners from where the left camera, and the rig, put them, px."""
    pose = board_pose(view.left, flat, rig.left)
    if pose is None:
        return np.inf
    in_left = flat @ pose[0].T + pose[1]
    told = project(in_left @ rig.rotation.T + rig.translation, rig.right)[0]
    there = ~np.isnan(view.right[:, 0])
    return np.linalg.norm(told - view.right, axis=1)[there].mean() if there.any() else np.inf


def _lens_alone(seen, flat, size):
    """Nine numbers of a camera: its focal length by the boards' perspective, no distortion yet."""
    whole = [(flat[~np.isnan(s[:, 0])], s[~np.isnan(s[:, 0])]) for s in seen]
    whole = [(f.astype(np.float32), s.astype(np.float32)) for f, s in whole if len(f) >= 4]
    if not whole:
        raise CalibrationError("One of the cameras sees no board.")
    matrix = cv2.initCameraMatrix2D([f for f, _ in whole], [s.reshape(-1, 1, 2) for _, s in whole], size)
    focal = matrix[0, 0] if np.isfinite(matrix).all() and 0.2 < matrix[0, 0] / size[0] < 20 else float(size[0])
    return np.array([focal, focal, (size[0] - 1) / 2, (size[1] - 1) / 2, 0, 0, 0, 0, 0])


def board_pose(seen: np.ndarray, flat: np.ndarray, lens: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
    """Rotation and translation of a board before one camera (``cv2.solvePnP``), or None where too little is seen."""
    there = ~np.isnan(seen[:, 0])
    if there.sum() < 4:
        return None
    _, vector, shift = cv2.solvePnP(flat[there], seen[there].reshape(-1, 1, 2), *matrices(lens))
    return turn(vector), shift.ravel()


def _from_left_to_right(left, right):
    rotation = right[0] @ left[0].T
    return rotation, right[1] - rotation @ left[1]


def _from_right(right, rotation, translation):
    return rotation.T @ right[0], rotation.T @ (right[1] - translation)


def _errors(views, flat, left_poses, relative, right_lens):
    """Mean distance of the right corners from where each hypothesis puts them: shape (hypotheses, views), px."""
    in_left = np.array([flat @ q.T + t for q, t in left_poses])
    seen = np.array([v.right for v in views])
    errors = []
    for rotation, translation in relative:
        x, y, z = np.moveaxis(in_left @ rotation.T + translation, -1, 0)
        with np.errstate(divide="ignore", invalid="ignore"):
            told = right_lens[:2] * np.stack([x / z, y / z], -1) + right_lens[2:4]
        errors.append(_mean(np.linalg.norm(told - seen, axis=-1), axis=1))
    return np.nan_to_num(errors, nan=np.inf)


def _guess(views):
    """Median over the views of how far the right corners lie from their mean over all views, px."""
    right = np.array([v.right for v in views])
    return np.median(_mean(np.linalg.norm(right - _mean(right, axis=0), axis=2), axis=1))


def _mean(values, axis):
    """The mean of what is known, NaN where nothing is."""
    return np.ma.masked_invalid(values).mean(axis).filled(np.nan)

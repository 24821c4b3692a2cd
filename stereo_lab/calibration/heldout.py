"""What a calibration tells of pairs that it has not seen."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

from stereo_lab.calibration.bundle import EXACT, Rig, Solution, matrices
from stereo_lab.calibration.uncertainty import rigs_without
from stereo_lab.calibration.views import View
from stereo_lab.recording import Board

FEWEST_TO_HOLD_OUT = 8


def errors_on_unseen(
    solution: Solution, views: Sequence[View], board: Board, size: tuple[int, int]
) -> tuple[float | None, float | None]:
    """Mean |Δv| after rectification (px) and mean error of the board's diagonals (%), each view by the others' cameras.

    None with few views, or where no view shows whole diagonals to both cameras.
    """
    rigs = rigs_without(solution)
    told = [pair_errors(rig, view, board, size) for rig, view in zip(rigs, views, strict=True)]
    table = np.array(told)
    whole = table[~np.isnan(table).any(1)]
    if len(whole) < FEWEST_TO_HOLD_OUT:
        return None, None
    return float(whole[:, 0].mean()), float(whole[:, 1].mean())


def pair_errors(rig: Rig, view: View, board: Board, size: tuple[int, int]) -> tuple[float, float]:
    """Mean |Δv| after rectification (px) and mean error of the two diagonals of what both see of the board (%); NaN where nothing."""
    (k1, d1), (k2, d2) = matrices(rig.left), matrices(rig.right)
    r1, r2, p1, p2 = cv2.stereoRectify(k1, d1, k2, d2, size, rig.rotation, rig.translation.reshape(3, 1), alpha=0)[:4]
    left = _rectified(view.left, k1, d1, r1, p1)
    right = _rectified(view.right, k2, d2, r2, p2)
    rows = np.abs(left[:, 1] - right[:, 1])
    if np.isnan(rows).all():
        return np.nan, np.nan
    points = cv2.triangulatePoints(p1, p2, left.T, right.T)
    points = (points[:3] / points[3]).T
    flat, there = board.corners_mm, np.flatnonzero(~np.isnan(rows))
    ends = [
        (there[k.argmin()], there[k.argmax()])
        for k in (flat[there, 0] + flat[there, 1], flat[there, 0] - flat[there, 1])
    ]
    errors = [np.linalg.norm(points[i] - points[j]) / np.linalg.norm(flat[i] - flat[j]) - 1 for i, j in ends]
    return float(np.nanmean(rows)), float(100 * np.abs(errors).mean())


def _rectified(points, matrix, distortion, rotation, projection):
    return cv2.undistortPoints(
        points.reshape(-1, 1, 2).astype(float), matrix, distortion, R=rotation, P=projection, criteria=EXACT
    ).reshape(-1, 2)

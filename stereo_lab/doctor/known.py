"""What a calibration knows, where its pictures leave it in doubt, and how far apart two calibrations are, in millimetres."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from stereo_lab.calibration import StereoCalibration, depth_map
from stereo_lab.calibration.bundle import Rig, matrices, project
from stereo_lab.calibration.cameras import EXACT
from stereo_lab.calibration.uncertainty import common_field
from stereo_lab.doctor.boards import Alone, Boards
from stereo_lab.doctor.pictures import Look

MOST = 95  # per cent of the places for which an error is told
CENTER_PX = 0.03  # a ball's centre is known to so much in each picture (1 sigma)
TWO_SIGMA = 2.0  # 95 % of normal errors
CELLS = 6, 5  # of a picture, across and down, in which boards are looked for


def apart_mm(one: Rig, other: Rig, size: tuple[int, int], depth_mm: float) -> float:
    """How far apart two calibrations put the same balls, in depth, 95 % of the places that both cameras see; infinite where none."""
    points, _ = common_field(other, size, depth_mm)
    if not len(points):
        return np.inf
    left = project(points, other.left)[0]
    right = project(points @ other.rotation.T + other.translation, other.right)[0]
    return float(np.percentile(np.abs(_triangulated(one, left, right)[:, 2] - points[:, 2]), MOST))


def _triangulated(rig, left, right):
    """Raw pixels of both cameras to places in the left camera's frame, shape (N, 3), mm."""
    flat = [
        cv2.undistortPoints(pixels.reshape(-1, 1, 2), *matrices(lens), criteria=EXACT).reshape(-1, 2).T
        for pixels, lens in ((left, rig.left), (right, rig.right))
    ]
    there = np.column_stack([rig.rotation, rig.translation])
    places = cv2.triangulatePoints(np.eye(3, 4), there, *flat)
    return (places[:3] / places[3]).T


def doubt_mm(calibration: StereoCalibration) -> float:
    """How far off a depth may be by the calibration alone, 95 % of the errors, in nine tenths of what both cameras see."""
    sigma = depth_map(calibration).sigma_mm
    return TWO_SIGMA * float(np.percentile(sigma, 90)) if len(sigma) and not np.isnan(sigma).any() else np.inf


def noise_mm(calibration: StereoCalibration, depth_mm: float | None = None) -> float:
    """How far off a depth may be by the ball's own pixels, 95 % of the errors; without ``depth_mm`` where the boards stood."""
    there = calibration.depth_mm if depth_mm is None else depth_mm
    return TWO_SIGMA * float(calibration.depth_per_px(there)) * np.sqrt(2) * CENTER_PX


@dataclass(frozen=True)
class Coverage:
    """How the boards were held.

    Attributes
    ----------
    count : int, boards that both cameras see
    tilt_deg : float, the angle between two boards, nine tenths of them are tilted less to each other
    cells : float, part of the picture's cells in which a corner was seen, in the worse of the two cameras
    wide : float, the median board's width, as a part of the picture's
    edges_px : (left, right), half the width of the edges between squares
    sigma_px : float, how far corners lie from what one camera alone explains, the worse of both
    """

    count: int
    tilt_deg: float
    cells: float
    wide: float
    edges_px: tuple[float, float]
    sigma_px: float


def coverage_of(boards: Boards, left: Alone, right: Alone, looks: dict[tuple[str, str], Look]) -> Coverage:
    """How the boards were held, and how sharp they are."""
    both = boards.some(boards.both)
    facing = left.turns[~np.isnan(left.shifts[:, 0]), :, 2]
    angles = np.degrees(np.arccos(np.clip(facing @ facing.T, -1, 1)))
    edges = [
        [look.edge_px for (name, which), look in looks.items() if which == side and name in both.names]
        for side in ("left", "right")
    ]
    return Coverage(
        len(both.names), float(np.percentile(angles, 90)), min(_cells(both.left, both.size), _cells(both.right, both.size)),
        float(np.median(np.nanmax(both.left[..., 0], axis=1) - np.nanmin(both.left[..., 0], axis=1)) / both.size[0]),
        (float(np.nanmedian(edges[0])), float(np.nanmedian(edges[1]))), float(max(np.nanmedian(a.rms_px) for a in (left, right))),
    )  # fmt: skip


def _cells(seen, size):
    """Part of the picture's cells with a corner in them."""
    there = seen[~np.isnan(seen[..., 0])]
    across, down = (np.clip((there[:, k] * n / size[k]).astype(int), 0, n - 1) for k, n in enumerate(CELLS))
    return len(set(zip(across.tolist(), down.tolist(), strict=True))) / (CELLS[0] * CELLS[1])

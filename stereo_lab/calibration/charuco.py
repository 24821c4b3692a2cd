"""Corners of a ChArUco board: a marker in each white square says which corners are round it, so a part of a board is enough."""

from __future__ import annotations

import cv2
import numpy as np

from stereo_lab.calibration.crossing import place_corners
from stereo_lab.recording import Board
from stereo_lab.recording.bounds import DICTIONARIES

LOOK_WIDTH = 1600  # small pictures are enlarged to this width, to twice their size at most
RIM_PX = 3  # nearer to the picture's edge, half of what places a corner is cut off
FEWEST = 6  # corners that tell how a board is held; on one line they do not
LINE = 0.05  # of a square: corners of which none is farther from a line stand on one


def find_charuco(grey: np.ndarray, board: Board) -> np.ndarray | None:
    """Inner corners of a ChArUco board, those that are seen (``cv2.aruco.CharucoDetector``, :mod:`crossing`).

    Parameters
    ----------
    grey : ndarray, uint8
    board : Board, a ChArUco one

    Returns
    -------
    ndarray, shape (corners, 2), float32, or None
        Row by row, NaN where a corner is not seen. None where fewer than six are, or all of them on one line.
    """
    found = _read(grey, board)
    there = ~np.isnan(found[:, 0])
    if there.sum() < FEWEST or not _spread(board.corners_mm[there, :2] / board.square_mm):
        return None
    across, down = board.grid
    whole = _carried_on(found, board).reshape(down, across, 2)
    placed = place_corners(grey, whole, there, _plain(board)).astype(np.float32)
    with np.errstate(invalid="ignore"):
        cut_off = ((placed < RIM_PX) | (placed > np.array(grey.shape[::-1]) - 1 - RIM_PX)).any(1)
    placed[cut_off] = np.nan
    return placed


def dictionary_in(grey: np.ndarray, board: Board) -> str | None:
    """The dictionary, other than the board's, from which most markers of a picture come; None where none is read."""
    large, _ = enlarged(grey)
    read = {}
    for name in DICTIONARIES:
        if name.endswith("_50") or name == board.dictionary:  # smaller ones are the beginning of larger ones
            markers = cv2.aruco.ArucoDetector(_dictionary(name)).detectMarkers(large)[1]
            read[name] = 0 if markers is None else len(markers)
    best = max(read, key=lambda name: read[name])
    return best if read[best] >= FEWEST and read[best] > 2 * read.get(board.dictionary or "", 0) else None


def opencv_board(board: Board) -> cv2.aruco.CharucoBoard:
    """The board as OpenCV takes it."""
    size, name = (board.columns, board.rows), board.dictionary
    return cv2.aruco.CharucoBoard(size, board.square_mm, board.marker_mm or 0.0, _dictionary(name))


def _dictionary(name):
    return cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, name))


def enlarged(grey: np.ndarray) -> tuple[np.ndarray, float]:
    """A small picture made larger, where small boards are found as well, and how many times as large it is."""
    scale = min(2.0, max(1.0, LOOK_WIDTH / grey.shape[1]))
    return (grey if scale == 1 else cv2.resize(grey, None, fx=scale, fy=scale, interpolation=cv2.INTER_CUBIC)), scale


def _read(grey, board):
    """Corners beside the markers that are read, to about a pixel; NaN for the others."""
    large, scale = enlarged(grey)
    how = cv2.aruco.CharucoParameters()
    how.minMarkers, how.tryRefineMarkers = 1, True
    corners, numbers, _, _ = cv2.aruco.CharucoDetector(opencv_board(board), how).detectBoard(large)
    found = np.full((len(board.corners_mm), 2), np.nan)
    if numbers is not None:
        found[numbers.ravel()] = (corners.reshape(-1, 2) + 0.5) / scale - 0.5
    return found


def _spread(places):
    """Whether some places do not stand on one line; told in squares."""
    return np.linalg.svd(places - places.mean(0), compute_uv=False)[1] > LINE * np.sqrt(len(places))


def _carried_on(found, board):
    """All corners: those found, and for the others where the plane of the board puts them."""
    there = ~np.isnan(found[:, 0])
    plane, _ = cv2.findHomography(board.corners_mm[there, :2], found[there], cv2.RANSAC, 5.0)
    if plane is None:
        return np.where(there[:, None], found, found[there].mean(0))
    told = cv2.perspectiveTransform(board.corners_mm[None, :, :2], plane)[0]
    return np.where(there[:, None], found, told)


def _plain(board):
    """What :func:`place_corners` wants to know: the first square is dark, and the margin round a marker is white."""
    across, down = board.grid
    margin = (1 - board.marker_mm / board.square_mm) / 2
    falling = (np.add.outer(np.arange(down), np.arange(across)) % 2 == 1).ravel()
    return margin, falling

"""Corners of a ChArUco board: a marker in each white square says which corners are round it, so a part of a board is enough.

Far away or tilted, single markers are too small to be read. Such a board is found as the chessboard that it is as well, and all its
markers together say which way round it lies.
"""

from __future__ import annotations

import cv2
import numpy as np

from stereo_lab.calibration.crossing import place_and_blur
from stereo_lab.calibration.finders import classic, enlarged
from stereo_lab.calibration.printed import dictionary_of, likeness, opencv_board, place_by_print, without_strays
from stereo_lab.recording import Board
from stereo_lab.recording.bounds import DICTIONARIES

RIM_PX = 3  # nearer to the picture's edge, half of what places a corner is cut off
FEWEST = 6  # corners that tell how a board is held; on one line they do not
SURE = 5.0  # times what chance would do
OFF = 0.15  # of a square: farther off the plane is a slip; the lens bends less
LARGER, LARGEST = (1,), (1, 2, 3)  # times as large is a picture looked at for the chessboard
WIDEST = 1920  # px, of what is enlarged for it
SLIP_PX = 5.0  # a marker's corner that lies farther off the plane of most does not help to tell it
ROUNDS = 2  # by the print: in the second one the corners round a corner say better how its plane lies
LINE = 0.05  # of a square: corners of which none is farther from a line stand on one


def find_charuco(grey: np.ndarray, board: Board) -> np.ndarray | None:
    """Inner corners of a ChArUco board, those that are seen (``cv2.aruco.CharucoDetector``, :mod:`crossing`, :mod:`printed`).

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
    if np.isnan(found).any():
        whole = _as_a_chessboard(grey, board, LARGER if _tells_how_it_is_held(found, board) else LARGEST)
        found = found if whole is None else whole
    if not _tells_how_it_is_held(found, board):
        return None
    there = ~np.isnan(found[:, 0])
    across, down = board.grid
    whole = _carried_on(found, board).reshape(down, across, 2)
    placed, blur_px = place_and_blur(grey, whole, there, _plain(board))
    placed = without_strays(placed, board)
    for _ in range(ROUNDS):
        placed = place_by_print(grey, placed, board, blur_px)
    placed = placed.astype(np.float32)
    with np.errstate(invalid="ignore"):
        cut_off = ((placed < RIM_PX) | (placed > np.array(grey.shape[::-1]) - 1 - RIM_PX)).any(1)
    placed[cut_off] = np.nan
    return placed if _tells_how_it_is_held(placed, board) else None


def glimpse_of_charuco(grey: np.ndarray, board: Board) -> np.ndarray | None:
    """As :func:`find_charuco`, in a tenth of the time and to about a pixel: by the markers that can be read, and nothing else."""
    found = _read(grey, board)
    return found if _tells_how_it_is_held(found, board) else None


def dictionary_in(grey: np.ndarray, board: Board) -> str | None:
    """The dictionary, other than the board's, from which most markers of a picture come; None where none is read."""
    large, _ = enlarged(grey)
    read = {}
    for name in DICTIONARIES:
        if name.endswith("_50") or name == board.dictionary:  # smaller ones are the beginning of larger ones
            markers = cv2.aruco.ArucoDetector(dictionary_of(name)).detectMarkers(large)[1]
            read[name] = 0 if markers is None else len(markers)
    best = max(read, key=lambda name: read[name])
    return best if read[best] >= FEWEST and read[best] > 2 * read.get(board.dictionary or "", 0) else None


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


def _as_a_chessboard(grey, board, larger):
    """All corners where the whole board is seen, to about a pixel; None where it is not, or its markers do not say how it lies."""
    for times in larger:
        corners = classic(grey, board.grid, times) if times == 1 or times * grey.shape[1] <= WIDEST else None
        if corners is not None:
            return _way_round(grey, corners, board)
    return None


def _way_round(grey, corners, board):
    """Corners in the board's own order, as its markers tell it; None where they do not."""
    across, down = board.grid
    grid = corners.reshape(down, across, 2)
    turns = (0, 1, 2, 3) if across == down else (0, 2)
    ways = [np.rot90(grid, turn).reshape(-1, 2) for turn in turns]
    alike = [likeness(grey, way, board) for way in ways]
    best = int(np.argmax(alike))
    return _on_the_plane(ways[best], board) if alike[best] > SURE else None


def _on_the_plane(corners, board):
    """Corners, and those that lie far off the plane of most where it puts them: of far boards the outer ones slip."""
    grid = corners.reshape(*board.grid[::-1], 2)
    square_px = min(np.linalg.norm(np.diff(grid, axis=axis), axis=-1).mean() for axis in (0, 1))
    told = _by_the_plane(corners, board, OFF * square_px)
    if told is None:
        return corners
    return np.where(np.linalg.norm(corners - told, axis=1, keepdims=True) > OFF * square_px, told, corners)


def _tells_how_it_is_held(found, board):
    """Whether enough corners are there, and not all of them on one line."""
    places = board.corners_mm[~np.isnan(found[:, 0]), :2] / board.square_mm
    if len(places) < FEWEST:
        return False
    return np.linalg.svd(places - places.mean(0), compute_uv=False)[1] > LINE * np.sqrt(len(places))


def _carried_on(found, board):
    """All corners: those found, and for the others where the plane of the board puts them."""
    there = ~np.isnan(found[:, 0])
    told = _by_the_plane(found, board, SLIP_PX)
    return np.where(there[:, None], found, found[there].mean(0) if told is None else told)


def _by_the_plane(found, board, slip_px):
    """Where the plane of most of the corners puts all of them; None where they tell none."""
    there = ~np.isnan(found[:, 0])
    plane, _ = cv2.findHomography(board.corners_mm[there, :2], found[there], cv2.RANSAC, slip_px)
    return None if plane is None else cv2.perspectiveTransform(board.corners_mm[None, :, :2], plane)[0]


def _plain(board):
    """What :func:`place_and_blur` wants to know: the first square is dark, and the margin round a marker is white."""
    across, down = board.grid
    margin = (1 - board.marker_mm / board.square_mm) / 2
    falling = (np.add.outer(np.arange(down), np.arange(across)) % 2 == 1).ravel()
    return margin, falling

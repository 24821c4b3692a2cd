"""Corners of boards. Those of a chessboard: found by OpenCV's two finders, placed by a model of the crossing edges, put in one order."""

from __future__ import annotations

import contextlib
import itertools
from collections.abc import Callable, Sequence
from dataclasses import replace

import cv2
import numpy as np

from stereo_lab.calibration.charuco import dictionary_in, find_charuco
from stereo_lab.calibration.crossing import place_corners
from stereo_lab.calibration.finders import classic, sector
from stereo_lab.errors import CalibrationError, StereoLabError
from stereo_lab.recording import Board, StereoPair
from stereo_lab.recording.bounds import CHARUCO, FEWEST_CORNERS, MARKER, MOST_CORNERS
from stereo_lab.recording.sample import must_be_board

SHOWN = 3  # pairs in which another board is looked for
SMALLEST_PX = 16  # a side of a picture; OpenCV's finders stumble over less, and no board can be seen in it
NEAR_OF_SQUARE = 0.2  # radius of the first, rough placing, as a part of the square


def find_corners(image: np.ndarray, board: Board, finders: Sequence[Callable] | None = None) -> np.ndarray | None:
    """Inner corners of a board, to a few hundredths of a pixel.

    A chessboard is found by ``cv2.findChessboardCorners``, and by ``cv2.findChessboardCornersSB`` where that fails, a ChArUco
    board by its markers, or as a chessboard whose print says which way round it lies (:mod:`charuco`). Then two crossing edges are fitted to the picture round each corner (:mod:`crossing`).

    Parameters
    ----------
    image : ndarray, BGR or grey, uint8
    board : Board
    finders : sequence of functions, optional, for a chessboard; else both of OpenCV's

    Returns
    -------
    ndarray, shape (corners, 2), float32, or None
        Row by row. None where no whole chessboard of this size is seen, or too little of a ChArUco board; of such a board a
        corner that is not seen is NaN.

    Raises
    ------
    StereoLabError
        If it is no picture, or of another type; or if the board is no Board.
    """
    must_be_board(board)  # OpenCV takes a pair of counts
    grey = _grey(image)
    if min(grey.shape) < SMALLEST_PX:
        return None
    if board.kind == CHARUCO:
        return find_charuco(grey, board)
    for finder in finders or (classic, sector):
        corners = finder(grey, (board.columns, board.rows))
        if corners is not None:
            corners = _place(grey, corners, board)
            if not _goes_on(grey, corners, board):
                return _one_order(grey, corners, board)
    return None


def _grey(image):
    """A picture in grey; what is neither a BGR nor a grey one is refused."""
    image = np.asarray(image)
    coloured = image.ndim == 3 and image.shape[2] == 3
    if not (coloured or image.ndim == 2) or image.dtype != np.uint8 or not image.size:
        got = f"got {image.shape} and {image.dtype}" if image.ndim else "there is none; was its file found?"
        raise StereoLabError(
            f"Expected a picture of shape (height, width, 3), or (height, width) in grey, and type uint8; {got}."
        )
    return cv2.cvtColor(image, cv2.COLOR_BGR2GRAY) if coloured else image


def _spacing(corners, board):
    """Smallest distance between neighbours, px."""
    grid = corners.reshape(board.rows, board.columns, 2)
    return min(np.linalg.norm(np.diff(grid, axis=axis), axis=-1).min() for axis in (0, 1))


def _place(grey, corners, board):
    """``cv2.cornerSubPix`` brings each corner near, the model of the two edges that cross there to a fraction of a pixel."""
    radius = max(3, round(NEAR_OF_SQUARE * _spacing(corners, board)))
    near = cv2.cornerSubPix(
        grey, corners.reshape(-1, 1, 2).astype(np.float32), (radius, radius), (-1, -1),
        (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_COUNT, 40, 1e-3),
    )  # fmt: skip
    return place_corners(grey, near.reshape(board.rows, board.columns, 2)).astype(np.float32)


def _contrast(grey, points, across, down):
    """How much each point looks like a corner of a chessboard: opposite quarters alike, neighbours not."""
    total = np.zeros(len(points))
    for sx, sy in ((1, 1), (1, -1), (-1, -1), (-1, 1)):
        where = points + 0.35 * (sx * across + sy * down)
        values = cv2.remap(
            grey.astype(np.float32), where[:, 0].astype(np.float32), where[:, 1].astype(np.float32),
            cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE,
        ).ravel()  # fmt: skip
        total += sx * sy * values
    return np.abs(total)


def _beyond(grey, corners, board):
    """Mean contrast one step outside each edge of the grid, as a part of the contrast inside.

    About 1 where the board goes on, about 0.5 along its own edge, where half of the quarters are margin.
    """
    grid = corners.reshape(board.rows, board.columns, 2)
    result = []
    for turned in (grid, grid[::-1], grid.transpose(1, 0, 2), grid.transpose(1, 0, 2)[::-1]):
        out = turned[0] - turned[1]
        along = np.gradient(turned[0], axis=0)
        inside = np.median(_contrast(grey, turned[0], along, out))
        outside = np.median(_contrast(grey, turned[0] + 1.03 * out, along, out))
        result.append(outside / max(inside, 1e-6))
    return result


def _goes_on(grey, corners, board):
    """True where the real board is larger than the one looked for."""
    if min(board.rows, board.columns) < 2:
        return False
    return max(_beyond(grey, corners, board)) > 0.78


def _one_order(grey, corners, board):
    """The same first corner in every picture.

    With one count odd and one even, a board turned by 180° has its colours swapped: the first square
    is to be the dark one. Other boards look the same both ways; there the rows run to the right.
    """
    if (board.columns + board.rows) % 2:
        grid = corners.reshape(board.rows, board.columns, 2)
        centres = (grid[:-1, :-1] + grid[1:, :-1] + grid[:-1, 1:] + grid[1:, 1:]) / 4
        values = cv2.remap(grey, centres.astype(np.float32), None, cv2.INTER_LINEAR).astype(float)
        dark = np.add.outer(np.arange(board.rows - 1), np.arange(board.columns - 1)) % 2 == 0
        turned = values[dark].mean() > values[~dark].mean()
    else:
        turned = corners[-1, 0] + corners[board.columns - 1, 0] < corners[0, 0] + corners[-board.columns, 0]
    return np.ascontiguousarray(corners[::-1]) if turned else corners


def match_order(left: np.ndarray, right: np.ndarray, board: Board) -> np.ndarray:
    """The right camera's corners in the order of the left one's (the cameras stand upright, side by side).

    Turned by half a turn a board may look the same, and a square one by a quarter of a turn, too.
    """
    if board.kind == CHARUCO:  # its markers have numbers
        return right
    grid = right.reshape(board.rows, board.columns, 2)
    quarters = range(4) if board.rows == board.columns else (0, 2)
    ways = [np.rot90(grid, k).reshape(-1, 2) for k in quarters]
    return np.ascontiguousarray(max(ways, key=lambda way: np.sum((left - left.mean(0)) * way)))


def check_board_size(pairs: Sequence[StereoPair], board: Board) -> None:
    """Raise CalibrationError that names the board's real size, or its real dictionary, if another one fits most pictures."""
    shown = board_shown(pairs, board)
    if shown is None:
        return
    if CHARUCO in (board.kind, shown.kind) and not only_the_markers(board, shown):
        raise CalibrationError(
            f"The board was said to be a {board}; the pictures show a {shown}. Of a ChArUco board the squares are counted, of a "
            "chessboard without markers the corners where four squares meet. Set the board to what the pictures show."
        )
    if board.kind == CHARUCO:
        raise CalibrationError(
            f"The board's markers were said to be from {board.dictionary}; those in the pictures are from {shown.dictionary}, or "
            "one of the larger dictionaries that begin with it. Set the board's dictionary to what is printed on it."
        )
    counted = " You counted squares; count the corners where four squares meet." if counts_squares(board, shown) else ""
    raise CalibrationError(
        f"The board was said to have {board.columns}x{board.rows} inner corners; the pictures show "
        f"{shown.columns}x{shown.rows}.{counted} Set board columns to {shown.columns} and rows to {shown.rows}."
    )


def only_the_markers(board: Board, shown: Board) -> bool:
    """Whether a ChArUco board is the one that was told but for its dictionary."""
    return board.kind == shown.kind == CHARUCO and (board.columns, board.rows) == (shown.columns, shown.rows)


def counts_squares(board: Board, shown: Board) -> bool:
    """Whether who gave ``board`` counted the squares of the chessboard that the pictures show."""
    return sorted((board.columns, board.rows)) == sorted((shown.columns + 1, shown.rows + 1))


def board_shown(pairs: Sequence[StereoPair], board: Board) -> Board | None:
    """The board that most pictures show where it is not the one that was told: another size, or another dictionary."""
    some = list(pairs)[:: max(1, len(pairs) // SHOWN)][:SHOWN]
    told = [other_board(pair.left, board) for pair in some]
    seen = [other for other in told if other is not None]
    return max(seen, key=seen.count) if seen else None


def other_board(image: np.ndarray, board: Board) -> Board | None:
    """A board of another size or kind, or with markers from another dictionary, that one picture shows; or None."""
    grey = cv2.cvtColor(image, cv2.COLOR_BGR2GRAY)
    if board.kind == CHARUCO:
        read = dictionary_in(grey, board)
        if read is not None:
            return replace(board, dictionary=read)
        others = _other_prints(board)
    else:
        others = itertools.chain(_neighbours(board), _with_markers(grey, board))  # markers are read last
    return next((other for other in others if _shows(image, other)), None)


def _shows(image, board):
    """Whether a picture shows a board, of a ChArUco board most of it."""
    corners = find_corners(image, board, (classic,))
    return corners is not None and np.isfinite(corners).all(axis=1).mean() > 0.5


def _other_prints(board):
    """What a ChArUco board is often taken for: counts exchanged, inner corners counted, no markers on it."""
    columns, rows = board.columns, board.rows
    for across, down in ((rows, columns), (columns + 1, rows + 1), (rows + 1, columns + 1)):
        with contextlib.suppress(StereoLabError):  # its dictionary has too few markers
            yield replace(board, columns=across, rows=down)
    for across, down in ((columns - 1, rows - 1), (columns, rows)):
        with contextlib.suppress(StereoLabError):  # too few corners
            yield Board(across, down, board.square_mm)


def _with_markers(grey, board):
    """The ChArUco boards that may have been told as a chessboard without markers."""
    dictionary = dictionary_in(grey, board)
    counts = [(board.columns + 1, board.rows + 1), (board.columns, board.rows)]
    for across, down in [*counts, *((down, across) for across, down in counts)] if dictionary is not None else ():
        with contextlib.suppress(StereoLabError):
            yield Board(across, down, board.square_mm, CHARUCO, MARKER * board.square_mm, dictionary)


def _neighbours(board):
    """Other sizes, the likeliest mistakes first."""
    changes = [(-1, -1), (1, 1), (0, -1), (-1, 0), (0, 1), (1, 0), (-2, -2), (2, 2), (-1, -2), (-2, -1), (1, 2), (2, 1)]
    for columns, rows in ((board.columns, board.rows), (board.rows, board.columns)):
        for dc, dr in changes:
            if all(FEWEST_CORNERS <= n <= MOST_CORNERS for n in (columns + dc, rows + dr)):
                yield replace(board, columns=columns + dc, rows=rows + dr)

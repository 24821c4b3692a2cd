"""Sheets to print, true to scale: a board for the calibration, and marks for the floor where samples are measured.

Everything is in millimetres from the lower left corner of the paper. What draws it is :func:`stereo_lab.plots.sheets_pdf`.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np

from stereo_lab.calibration import opencv_board
from stereo_lab.errors import StereoLabError
from stereo_lab.recording import Board
from stereo_lab.recording.bounds import CHARUCO

PAPERS_MM = {"A4": (297.0, 210.0), "Letter": (279.4, 215.9), "A3": (420.0, 297.0)}  # wide, high
EDGE_MM = 6.0  # that a printer leaves white
FOOT_MM = 15.0  # under a board: ruler and words
QUIET_MM = 5.0  # white round a board
RULER_MM, TICK_MM = 100.0, 10.0
WORDS_MM = 3.2  # high
CROSS_MM, APART_MM = 6.0, 50.0  # marks for the floor: how large, and how far apart
JOIN_MM = 10.0  # of a sheet of marks, overlapped by the next one
MOST_SHEETS = 40


@dataclass(frozen=True, eq=False)
class Sheet:
    """One page.

    Attributes
    ----------
    wide_mm, high_mm : float
    dark : ndarray, shape (N, 4): x, y, width and height of black rectangles, mm
    lines : ndarray, shape (M, 4): from x, y to x, y, mm
    words : tuple of (x_mm, y_mm, text); text begins there, on its base line
    """

    wide_mm: float
    high_mm: float
    dark: np.ndarray
    lines: np.ndarray
    words: tuple[tuple[float, float, str], ...]


def board_sheet(board: Board, paper: str = "A4") -> Sheet:
    """A board, a ruler that checks the printer, and the numbers to type.

    Parameters
    ----------
    board : Board
    paper : str, one of :data:`PAPERS_MM`

    Returns
    -------
    Sheet

    Raises
    ------
    StereoLabError
        If the board is larger than the paper.
    """
    across, down = (n + 1 for n in board.grid)
    size = np.array([across, down]) * board.square_mm
    wide, high = _paper(paper, upright=down > across)
    room = np.array([wide - 2 * (EDGE_MM + QUIET_MM), high - 2 * (EDGE_MM + QUIET_MM) - FOOT_MM + QUIET_MM])
    if (size > room).any():
        largest = np.floor(2 * (room / (across, down)).min()) / 2
        raise StereoLabError(
            f"A board of {across}x{down} squares of {board.square_mm:g} mm is {size[0]:g} x {size[1]:g} mm; {paper} has room for "
            f"{room[0]:g} x {room[1]:g}. Take squares of {largest:g} mm, fewer squares, or larger paper."
        )
    left, bottom = (wide - size[0]) / 2, EDGE_MM + FOOT_MM + (high - 2 * EDGE_MM - FOOT_MM - size[1]) / 2
    top_left = np.array([left, bottom + size[1]])
    dark = [
        _down_from(top_left, column * board.square_mm, row * board.square_mm, board.square_mm, board.square_mm)
        for row in range(down)
        for column in range(across)
        if (row + column) % 2 == 0
    ]
    if board.kind == CHARUCO:
        dark += [_down_from(top_left, *cell) for cell in _marker_cells(board)]
    return Sheet(wide, high, np.array(dark), _ruler(), (*_ruler_words(), *_board_words(board)))


def mark_sheets(paper: str = "A4", sheets: int = 3, from_mm: float = 500.0) -> list[Sheet]:
    """Crosses to lay on the table, 50 mm apart, each row marked with its depth and each column with its x.

    The sheets are laid one behind the other, the first line of one on the last line of the one before. x is 0 in the middle.

    Parameters
    ----------
    paper : str, one of :data:`PAPERS_MM`
    sheets : int
    from_mm : float, depth of the first line

    Raises
    ------
    StereoLabError
        If there is no such paper, or not one to forty sheets are asked for, or the depth fits into no room.
    """
    if not 1 <= sheets <= MOST_SHEETS:
        raise StereoLabError(f"Expected 1 to {MOST_SHEETS} sheets, got {sheets}.")
    if not 0 <= from_mm <= 10_000:
        raise StereoLabError(f"Expected a depth of 0 to 10,000 mm for the first line, got {from_mm:g}.")
    wide, high = _paper(paper)
    rows = int((high - 2 * (EDGE_MM + JOIN_MM)) // APART_MM)
    reach = int((wide / 2 - EDGE_MM - 20) // APART_MM)
    return [_marks(wide, high, rows, reach, from_mm + k * rows * APART_MM, k, sheets) for k in range(sheets)]


def _marks(wide, high, rows, reach, from_mm, number, sheets):
    first = EDGE_MM + JOIN_MM
    xs = [k * APART_MM for k in range(-reach, reach + 1)]
    title = (
        f"Sheet {number + 1} of {sheets}. Away from the cameras is up. Crosses are {APART_MM:g} mm apart: measure them."
    )
    lines, words = [], [(EDGE_MM, high - EDGE_MM - WORDS_MM, title)]
    for row in range(rows + 1):
        y = first + row * APART_MM
        joins = (row == 0 and number > 0) or (row == rows and number + 1 < sheets)
        lines += [(EDGE_MM, y, wide - EDGE_MM, y)] if joins else []
        words.append((EDGE_MM, y + 1.5, f"depth {from_mm + row * APART_MM:g}"))
        for x in xs:
            at = wide / 2 + x
            lines += [(at - CROSS_MM / 2, y, at + CROSS_MM / 2, y), (at, y - CROSS_MM / 2, at, y + CROSS_MM / 2)]
            words.append((at + 2, y + 1.5, f"x {x:g}"))
    return Sheet(wide, high, np.empty((0, 4)), np.array(lines), tuple(words))


def _paper(name, upright=False):
    if name not in PAPERS_MM:
        raise StereoLabError(f"Expected paper {', '.join(PAPERS_MM)}; got {name!r}.")
    wide, high = PAPERS_MM[name]
    return (high, wide) if upright else (wide, high)


def _down_from(top_left, x, y, wide, high):
    """A rectangle told from the board's upper left corner, y downwards."""
    return top_left[0] + x, top_left[1] - y - high, wide, high


def _marker_cells(board: Board) -> Iterator[tuple[float, float, float, float]]:
    """Dark cells of all markers, each row's neighbours as one: x, y (down), width, height."""
    printed = opencv_board(board)
    dictionary = printed.getDictionary()
    cells = dictionary.markerSize + 2  # a dark rim round them
    side = printed.getMarkerLength() / cells
    for number, corners in zip(np.ravel(printed.getIds()), printed.getObjPoints(), strict=True):
        x, y = np.asarray(corners)[:, :2].min(0)
        bits = cv2.aruco.generateImageMarker(dictionary, int(number), cells) == 0
        for row, line in enumerate(bits):
            edges = np.flatnonzero(np.diff(np.concatenate([[0], line.astype(int), [0]])))
            for start, end in edges.reshape(-1, 2):
                yield x + start * side, y + row * side, (end - start) * side, side


def _ruler():
    x, y = EDGE_MM + 4, EDGE_MM + 2
    ticks = [(x + k, y, x + k, y + (4 if k % 50 == 0 else 2)) for k in np.arange(0, RULER_MM + 1, TICK_MM)]
    return np.array([(x, y, x + RULER_MM, y), *ticks])


def _ruler_words():
    x, y = EDGE_MM + 4, EDGE_MM + 7.5
    return (
        (x, y + WORDS_MM + 1.3, "This line is 100 mm long. Is yours? Print at 100 %, not fitted to the page."),
        (x, y, "If it is 98 mm long, your squares are 98 % of what stands here."),
    )


def _board_words(board):
    """What it is, and what is typed for it."""
    x, y = EDGE_MM + 4 + RULER_MM + 20, EDGE_MM + 7.5
    told = f"--board {board.columns}x{board.rows} --square-mm {board.square_mm:g}"
    if board.kind == CHARUCO:
        told += f" --charuco --marker-mm {board.marker_mm:g} --dictionary {board.dictionary}"
    return (x, y + WORDS_MM + 1.3, f"A {board}, squares of {board.square_mm:g} mm"), (x, y, told)

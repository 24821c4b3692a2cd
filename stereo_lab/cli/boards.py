"""The command board, and the options by which others name a board."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from stereo_lab.cli.options import Add, add_board, decimal, whole
from stereo_lab.cli.terminal import OK
from stereo_lab.errors import StereoLabError

if TYPE_CHECKING:
    from stereo_lab.recording import Ball, Board, Recording

COLUMNS, ROWS, SQUARE_MM = "9", "6", "25"  # of a board of which nothing is told


def add_to(add: Add) -> None:
    """The commands and their options."""
    board = add(
        "board", run_board, "Make a PDF to print: a board for the calibration, or marks for the table.",
        "board board.pdf --columns 9 --rows 6 --square-mm 25 --paper A4",
    )  # fmt: skip
    board.add_argument("out", metavar="FILE", help="the PDF to write")
    board.add_argument(
        "--columns", metavar="N", help="of a chessboard its inner corners, of a ChArUco board its squares (9)"
    )
    board.add_argument("--rows", metavar="N", help="the same, downwards (6)")
    add_board(board, f"(default: {SQUARE_MM})")
    board.add_argument("--paper", default="A4", metavar="NAME", help="A4, Letter or A3 (default: %(default)s)")
    board.add_argument(
        "--marks", action="store_true", help="instead of a board: crosses for the table, marked with their x and depth"
    )
    board.add_argument("--sheets", type=whole, metavar="N", help="of marks, one behind the other (3)")
    board.add_argument("--from-mm", type=decimal, metavar="MM", help="depth of the first line of marks (500)")


def run_board(options: argparse.Namespace) -> int:
    """Write a board, or marks for the table, as a PDF true to scale."""
    from stereo_lab.capture import PAPERS_MM, board_sheet, mark_sheets
    from stereo_lab.common.files import write_whole
    from stereo_lab.plots import sheets_pdf

    if Path(options.out).suffix.lower() != ".pdf":
        raise StereoLabError(f"The sheets are a PDF: expected a name that ends in .pdf, got {options.out}.")
    paper = {name.lower(): name for name in PAPERS_MM}.get(options.paper.lower(), options.paper)
    if options.marks:
        board_only = "columns", "rows", "square-mm", "charuco", "marker-mm", "dictionary"
        _of_no_use(options, "of a board, and --marks prints none: leave one of them out", *board_only)
        told = {"sheets": options.sheets, "from_mm": options.from_mm}
        sheets = mark_sheets(paper, **{name: value for name, value in told.items() if value is not None})
        what = f"{len(sheets)} sheet(s) of marks, {paper}. Lay them one behind the other, line on line."
    else:
        _of_no_use(options, "of marks: add --marks, or leave it out", "sheets", "from-mm")
        options.square_mm = options.square_mm or SQUARE_MM
        board = board_of(options.columns or COLUMNS, options.rows or ROWS, options, ("--columns", "--rows"))
        sheets, what = [board_sheet(board, paper)], f"{board}, squares of {board.square_mm:g} mm, {paper}."
    write_whole(options.out, sheets_pdf(sheets))
    print(f"{options.out}: {what}")
    print("Print it at 100 %, not fitted to the page, and measure the line of 100 mm.")
    return OK


def recording_begun(out: str) -> Recording | None:
    """The recording in a folder that is to be written to; None where none was begun there."""
    from stereo_lab.recording import open_recording

    return open_recording(out) if (Path(out) / "recording.json").is_file() else None


def ball_of_options(options: argparse.Namespace, begun: Recording | None) -> Ball:
    """The ball that the options tell; what they leave out is as in the recording that was begun, or 40 mm and red.

    Raises
    ------
    StereoLabError
        If the recording was begun with another one.
    """
    from stereo_lab.recording import USUAL_BALL, Ball
    from stereo_lab.recording.bounds import color_name, length_mm

    known = begun.ball if begun else USUAL_BALL
    ball = Ball(
        known.color if options.ball_color is None else color_name(options.ball_color, "--ball-color"),
        known.diameter_mm if options.ball_mm is None else length_mm(options.ball_mm, "--ball-mm"),
    )
    if begun and ball != known:
        raise StereoLabError(
            f"{options.out} was begun with a {known.color} ball of {known.diameter_mm:g} mm; this is a {ball.color} one of "
            f"{ball.diameter_mm:g} mm. Change it in {Path(options.out) / 'recording.json'}, or name another folder."
        )
    return ball


def board_of_option(options: argparse.Namespace) -> Board:
    """The board of --board, such as 9x6, and the options beside it."""
    parts = options.board.lower().replace("×", "x").split("x")
    if len(parts) != 2:
        raise StereoLabError(f"--board: expected columns x rows of inner corners, as in 9x6; got {options.board!r}.")
    return board_of(parts[0], parts[1], options, ("--board", "--board"))


def board_of(columns: str, rows: str, options: argparse.Namespace, told_by: tuple[str, str]) -> Board:
    """A board by its counts, which ``told_by`` names, and by the options --square-mm, --charuco, --marker-mm and --dictionary.

    Raises
    ------
    StereoLabError
        If there can be no such board.
    """
    from stereo_lab.recording import Board
    from stereo_lab.recording.bounds import (
        CHARUCO,
        DICTIONARY,
        MARKER,
        corner_count,
        dictionary_name,
        length_mm,
        markers_that_fit,
    )

    counted, more = ("squares", 1) if options.charuco else ("inner corners", 0)
    across = corner_count(columns, f"{told_by[0]}, {counted} across", more)
    down = corner_count(rows, f"{told_by[1]}, {counted} down", more)
    square = length_mm(options.square_mm, "--square-mm")
    if not options.charuco:
        _of_no_use(options, "of a ChArUco board: add --charuco, or leave it out", "marker-mm", "dictionary")
        return Board(across, down, square)
    marker = markers_that_fit(options.marker_mm or MARKER * square, square, "--marker-mm")
    dictionary = dictionary_name(options.dictionary or DICTIONARY, across * down // 2, "--dictionary")
    return Board(across, down, square, CHARUCO, marker, dictionary)


def _of_no_use(options, why, *names):
    """Refuse options that would do nothing beside the others."""
    for name in names:
        told = getattr(options, name.replace("-", "_"))
        if told is not None and told is not False:  # 0 is told
            raise StereoLabError(f"--{name} is {why}.")

"""Sheets to print: the PDF is drawn by another program, and measured."""

import cv2
import numpy as np
import pytest

from conftest import skip_unless_ci
from stereo_lab import cli
from stereo_lab.calibration import find_corners, opencv_board
from stereo_lab.recording import Board

DPI = 300
PX_MM = DPI / 25.4


def made(tmp_path, *words):
    """Grey pictures of the pages, and their words."""
    try:
        import pypdfium2
    except ImportError:
        skip_unless_ci("pypdfium2 is not installed (extra: oracle)")
    file = tmp_path / "sheet.pdf"
    assert cli.main(["board", str(file), *words]) == 0
    document = pypdfium2.PdfDocument(file)
    shown = [page.render(scale=DPI / 72, grayscale=True).to_numpy() for page in document]
    return [picture.reshape(picture.shape[:2]) for picture in shown], [
        p.get_textpage().get_text_range() for p in document
    ]


BOARDS = {
    "A4": (["--columns", "9", "--rows", "6", "--square-mm", "25"], Board(9, 6, 25.0)),
    "Letter": (["--columns", "7", "--rows", "8", "--square-mm", "21.5"], Board(7, 8, 21.5)),
    "A3": (
        ["--charuco", "--columns", "9", "--rows", "6", "--square-mm", "40"],
        Board(9, 6, 40.0, "charuco", 30.0, "DICT_4X4_50"),
    ),
    "a4": (
        [
            "--charuco",
            "--columns",
            "5",
            "--rows",
            "7",
            "--square-mm",
            "35",
            "--marker-mm",
            "25",
            "--dictionary",
            "DICT_6X6_250",
        ],
        Board(5, 7, 35.0, "charuco", 25.0, "DICT_6X6_250"),
    ),
}
PAPERS = {"A4": (297, 210), "Letter": (215.9, 279.4), "A3": (420, 297), "a4": (210, 297)}


@pytest.mark.parametrize("paper", BOARDS)
def test_a_printed_board_has_the_size_that_it_says(tmp_path, capsys, paper):
    words, board = BOARDS[paper]
    (picture,), (text,) = made(tmp_path, "--paper", paper, *words)
    assert np.allclose(picture.shape[::-1], np.array(PAPERS[paper]) * PX_MM, atol=1)
    corners = find_corners(cv2.cvtColor(picture, cv2.COLOR_GRAY2BGR), board)
    across, down = board.grid
    grid = corners.reshape(down, across, 2) * np.divide(
        PAPERS[paper], picture.shape[::-1]
    )  # whole pixels, drawn to fill them
    steps = [np.linalg.norm(np.diff(grid, axis=axis), axis=-1) for axis in (0, 1)]
    assert all(np.abs(step - board.square_mm).max() < 0.03 for step in steps)
    assert abs(np.linalg.norm(grid[-1, -1] - grid[0, 0]) / np.hypot(across - 1, down - 1) - board.square_mm) < 0.005
    assert " ".join(words[-2:]) in text and "100 mm long" in text and "100 %" in capsys.readouterr().out


def test_a_charuco_board_is_the_one_that_opencv_draws(tmp_path):
    words, board = BOARDS["A3"]
    (picture,), _ = made(tmp_path, "--paper", "A3", *words)
    wide, high = (round(n * board.square_mm * PX_MM) for n in (board.columns, board.rows))
    drawn = opencv_board(board).generateImage((wide, high))
    rows, columns = (np.flatnonzero((picture < 128).mean(axis) > 0.2) for axis in (1, 0))
    cut = picture[rows[0] : rows[0] + high, columns[0] : columns[0] + wide]
    assert (np.abs(cut.astype(int) - drawn) > 128).mean() < 0.01


def test_the_ruler_is_100_mm_long(tmp_path):
    (picture,), _ = made(tmp_path)
    foot = picture[-round(12 * PX_MM) :, : round(130 * PX_MM)] < 128
    row = foot[foot[:, : round(115 * PX_MM)].sum(1).argmax()]
    ends = np.flatnonzero(row)
    assert (ends[-1] - ends[0]) / PX_MM == pytest.approx(100, abs=0.4)  # the line's own width


def test_marks_lie_where_they_say(tmp_path):
    shown, words = made(tmp_path, "--marks", "--sheets", "2", "--from-mm", "700")
    assert len(shown) == 2 and "depth 700" in words[0] and "depth 850" in words[0] and "depth 850" in words[1]
    for picture, text in zip(shown, words, strict=True):
        dark, high = picture < 128, len(picture)
        for x in (-100, -50, 0, 50, 100):
            for row in range(4):
                u, v = (297 / 2 + x) * PX_MM, high - (16 + 50 * row) * PX_MM
                cross = dark[round(v - 2.5 * PX_MM) : round(v + 2.5 * PX_MM), round(u) - 3 : round(u) + 3]
                assert cross.any(1).mean() > 0.95  # an upright line of at least 5 mm
            assert f"x {x}" in text


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["--square-mm", "40"], "400 x 280 mm; A4 has room for 275 x 178. Take squares of 25 mm"),
        (["--paper", "A5"], "Expected paper A4, Letter, A3; got 'A5'"),
        (["--columns", "two"], "--columns, inner corners across: expected a number, got 'two'"),
        (
            ["--charuco", "--columns", "20", "--rows", "20", "--square-mm", "9"],
            "DICT_4X4_50 has 50 markers, and the board needs 200",
        ),
        (["--charuco", "--marker-mm", "25"], "--marker-mm: expected a number from 12.5 to 22.5"),
        (["--marks", "--sheets", "0"], "Expected 1 to 40 sheets, got 0"),
        (["--marks", "--from-mm", "nan"], "got nan"),
    ],
)
def test_what_cannot_be_printed_is_a_sentence(tmp_path, capsys, words, says):
    assert cli.main(["board", str(tmp_path / "sheet.pdf"), *words]) == 2
    assert says in capsys.readouterr().err and not list(tmp_path.iterdir())


def test_the_largest_square_that_is_told_does_fit(tmp_path):
    assert cli.main(["board", str(tmp_path / "sheet.pdf"), "--square-mm", "25"]) == 0
    assert cli.main(["board", str(tmp_path / "sheet.pdf"), "--square-mm", "25.5"]) == 2

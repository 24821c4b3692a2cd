"""ChArUco boards: drawn by OpenCV, seen through a lens by a projection of our own, found again."""

import json
import shutil
from functools import lru_cache

import cv2
import numpy as np
import pytest

from stereo_lab.calibration import calibrate_stereo, find_corners
from stereo_lab.calibration.charuco import glimpse_of_charuco
from stereo_lab.calibration.printed import PX, opencv_board, the_print
from stereo_lab.errors import CalibrationError, RecordingError, StereoLabError
from stereo_lab.recording import Board, open_recording

SIZE = 640, 480
MATRIX = np.array([[612.0, 0, 322], [0, 612, 237], [0, 0, 1]])
LENS = np.array([0.06, -0.1, 0.001, -0.0005, 0])
CHARUCO = Board(7, 5, 35.0, "charuco", 26.0, "DICT_4X4_50")
CHESS = Board(6, 4, 35.0)
SHARPER = 8  # times: the paper is drawn in whole pixels first
FINE, PX_MM = 3, 8  # a picture is drawn so many times as large; the printed board has so many pixels a mm


@lru_cache
def print_of(board):
    """The board as it is printed, with a square's white round it."""
    edge = round(board.square_mm * PX_MM)
    across, down = board.grid
    if board.kind == "charuco":
        size = (across + 1) * edge, (down + 1) * edge
        paper = opencv_board(board).generateImage(tuple(SHARPER * side for side in size))  # it draws whole pixels
        paper = cv2.resize(paper, size, interpolation=cv2.INTER_AREA)
    else:
        paper = 255 * (np.add.outer(np.arange((down + 1) * edge) // edge, np.arange((across + 1) * edge) // edge) % 2)
    return cv2.copyMakeBorder(paper.astype(np.uint8), edge, edge, edge, edge, cv2.BORDER_CONSTANT, value=255)


def seen(paper, board, turn, shift, rng, matrix=MATRIX):
    """The picture of a board: a ray for each fine pixel, through the lens, to the plane of the board."""
    wide, high = SIZE
    u, v = np.meshgrid((np.arange(wide * FINE) + 0.5) / FINE - 0.5, (np.arange(high * FINE) + 0.5) / FINE - 0.5)
    rays = cv2.undistortPoints(np.stack([u, v], -1).reshape(-1, 1, 2), matrix, LENS).reshape(-1, 2)
    rays = np.column_stack([rays, np.ones(len(rays))])
    far = (turn[:, 2] @ shift) / (rays @ turn[:, 2])
    on_board = (rays * far[:, None] - shift) @ turn
    x, y = ((on_board[:, :2] + 2 * board.square_mm) * PX_MM - 0.5).T.reshape(2, high * FINE, wide * FINE)
    soft = cv2.GaussianBlur(paper, (0, 0), 0.5 * PX_MM)
    picture = cv2.remap(soft, x.astype(np.float32), y.astype(np.float32), cv2.INTER_LINEAR, borderValue=150)
    picture = 20 + 0.8 * cv2.resize(picture.astype(np.float32), SIZE, interpolation=cv2.INTER_AREA)
    noisy = cv2.GaussianBlur(picture, (0, 0), 0.6) + rng.normal(0, 2, picture.shape)
    return cv2.cvtColor(np.clip(noisy, 0, 255).astype(np.uint8), cv2.COLOR_GRAY2BGR)


def true_corners(board, turn, shift):
    return cv2.projectPoints(board.corners_mm, cv2.Rodrigues(turn)[0], shift, MATRIX, LENS)[0].reshape(-1, 2)


def held(board, rng, u, v, far_mm):
    """A board tilted by up to 35 degrees, its middle at a pixel."""
    turn = cv2.Rodrigues(np.radians(rng.uniform((-35, -35, -30), (35, 35, 30))))[0]
    middle = np.array([(u - MATRIX[0, 2]) / MATRIX[0, 0], (v - MATRIX[1, 2]) / MATRIX[1, 1], 1]) * far_mm
    return turn, middle - turn @ board.corners_mm.mean(0)


def test_corners_are_more_exact_than_a_chessboards():
    """At the same poses: the markers have edges, too."""
    errors = {}
    for board in (CHARUCO, CHESS):
        rng = np.random.default_rng(5)
        for far in (500, 800, 1100):
            pose = held(board, rng, rng.uniform(200, 440), rng.uniform(160, 320), far)
            found = find_corners(seen(print_of(board), board, *pose, rng), board)
            errors.setdefault(board, []).append(np.linalg.norm(found - true_corners(board, *pose), axis=1))
    charuco, chess = (np.sqrt(np.mean(np.square(errors[board]))) for board in (CHARUCO, CHESS))
    assert charuco < 0.95 * chess < 0.008


def test_a_blurred_picture_is_no_worse():
    """Where blur reaches from the markers into the white round them, the lines alone are led astray."""
    rng = np.random.default_rng(9)
    pose = held(CHARUCO, rng, 320, 240, 700)
    picture = cv2.GaussianBlur(seen(print_of(CHARUCO), CHARUCO, *pose, rng), (0, 0), 0.8)
    away = np.linalg.norm(find_corners(picture, CHARUCO) - true_corners(CHARUCO, *pose), axis=1)
    assert np.sqrt(np.mean(away**2)) < 0.007


@pytest.mark.parametrize("name", ["DICT_4X4_50", "DICT_6X6_250"])
def test_the_print_is_the_one_that_opencv_draws(name):
    board = Board(5, 4, 24.0, "charuco", 18.0, name)
    paper = opencv_board(board).generateImage((5 * PX, 4 * PX)) / 127.5 - 1
    assert np.mean(np.abs(the_print(board)[PX:-PX, PX:-PX] - paper) > 1) < 0.001
    fine = opencv_board(board).generateImage((5 * PX * 24, 4 * PX * 24))  # so large that its whole pixels do not matter
    fine = cv2.resize(fine, (5 * PX, 4 * PX), interpolation=cv2.INTER_AREA) / 127.5 - 1
    assert np.abs(the_print(board)[PX:-PX, PX:-PX] - fine).max() < 0.1


def test_a_board_over_the_rim_counts_with_what_is_seen_of_it():
    rng = np.random.default_rng(6)
    pose = held(CHARUCO, rng, 40, 240, 600)
    found, true = find_corners(seen(print_of(CHARUCO), CHARUCO, *pose, rng), CHARUCO), true_corners(CHARUCO, *pose)
    there = ~np.isnan(found[:, 0])
    inside = ((true > 0) & (true < SIZE)).all(1)
    assert 6 <= there.sum() < len(true) and inside[there].all() and there.sum() >= 0.7 * inside.sum()
    assert np.linalg.norm(found - true, axis=1)[there].max() < 0.1


FINER = Board(9, 7, 28.0, "charuco", 21.0, "DICT_4X4_50")


@pytest.mark.parametrize("turned", [0.0, 180.0])
def test_a_board_whose_markers_are_too_small_to_read_is_found(turned):
    """Cells of two pixels: no marker is read, or hardly one; all of them together still say which way round it lies."""
    rng = np.random.default_rng(11)
    turn = cv2.Rodrigues(np.radians([0.0, 0.0, turned]))[0] @ cv2.Rodrigues(np.radians([50.0, 20.0, 0.0]))[0]
    shift = np.array([-60.0, 20.0, 1100.0]) - turn @ FINER.corners_mm.mean(0)
    image = seen(print_of(FINER), FINER, turn, shift, rng)
    grey = cv2.cvtColor(image, cv2.COLOR_BGR2GRAY)
    read = glimpse_of_charuco(grey, FINER)
    assert read is None or np.isnan(read).any()
    off = find_corners(image, FINER) - true_corners(FINER, turn, shift)
    assert np.sqrt((off**2).sum(1).mean()) < 0.1


def test_a_plain_chessboard_is_no_charuco_board():
    chess = Board(8, 6, 28.0)
    turn = cv2.Rodrigues(np.radians([20.0, 15.0, 5.0]))[0]
    shift = np.array([0.0, 0.0, 700.0]) - turn @ chess.corners_mm.mean(0)
    image = seen(print_of(chess), chess, turn, shift, np.random.default_rng(3))
    assert find_corners(image, chess) is not None and find_corners(image, FINER) is None


def test_no_board_and_too_little_of_one_is_none():
    rng = np.random.default_rng(7)
    assert find_corners(rng.integers(0, 255, (480, 640, 3)).astype(np.uint8), CHARUCO) is None
    pose = held(CHARUCO, rng, -60, 240, 600)
    assert find_corners(seen(print_of(CHARUCO), CHARUCO, *pose, rng), CHARUCO) is None


def test_a_single_row_that_is_left_at_the_rim_is_none():
    """What is cut off at the rim may leave corners on one line, which tell no plane: whoever calibrates would stop there."""
    rows = []
    for down in np.arange(-268, -252, 2.0):
        shift = np.array([0.0, down, 500.0]) - CHARUCO.corners_mm.mean(0) * [1, 0, 1]
        corners = find_corners(seen(print_of(CHARUCO), CHARUCO, np.eye(3), shift, np.random.default_rng(1)), CHARUCO)
        rows.append(0 if corners is None else len(set(np.flatnonzero(~np.isnan(corners[:, 0])) // CHARUCO.grid[0])))
    assert 1 not in rows and max(rows) > 1 and 0 in rows


class Pair:
    def __init__(self, name, left, right):
        self.name, self.left, self.right = name, left, right


RIGHT = np.array([-90.0, 0.5, -1.0])  # of the right camera, from the left one
TOE = cv2.Rodrigues(np.radians([0.3, 1.0, -0.4]))[0]


def pairs_of(board, places, seed=8):
    rng, paper, pairs = np.random.default_rng(seed), print_of(board), []
    for k, (u, v, far) in enumerate(places):
        turn, shift = held(board, rng, u, v, far)
        left = seen(paper, board, turn, shift, rng)
        right = seen(paper, board, TOE @ turn, TOE @ shift + RIGHT, rng)
        pairs.append(Pair(f"{k:03d}", left, right))
    return pairs


PLACES = [
    (u, v, 520 + 60 * ((3 * i + 2 * j) % 5))
    for i, u in enumerate((230, 330, 430))
    for j, v in enumerate((130, 240, 350))
]
RIM = [(150, 60, 560), (520, 70, 560), (160, 420, 560), (530, 420, 600)]


@pytest.fixture(scope="module")
def calibrated():
    return calibrate_stereo(pairs_of(CHARUCO, PLACES + RIM), CHARUCO)


def test_a_rig_is_calibrated_from_boards_that_leave_the_picture(calibrated):
    assert calibrated.found == calibrated.pairs == 13 and len(calibrated.used) == 13
    assert np.linalg.norm(calibrated.translation_mm - RIGHT) < 0.3
    assert abs(calibrated.left_matrix[0, 0] / 612 - 1) < 0.002 and calibrated.rms_px < 0.03
    grid = np.array([(u, v) for u in (100, 320, 540) for v in (80, 240, 400)], float)
    rays = cv2.undistortPoints(grid[:, None], MATRIX, LENS).reshape(-1, 2)
    told = cv2.undistortPoints(grid[:, None], calibrated.left_matrix, calibrated.left_distortion).reshape(-1, 2)
    assert 612 * np.linalg.norm(rays - told, axis=1).max() < 0.5


def test_outlines_of_a_part_of_a_board_lie_in_the_picture(calibrated):
    corners = calibrated.outlines.reshape(-1, 2)
    assert np.isfinite(corners).all() and (corners > 0).all() and (corners < SIZE).all()
    middle, corner = calibrated.boards_at([[330.0, 240.0], [5.0, 5.0]], "left")
    assert middle >= 1 and corner == 0


def test_another_dictionary_is_named():
    other = Board(7, 5, 35.0, "charuco", 26.0, "DICT_5X5_50")
    with pytest.raises(
        CalibrationError, match="said to be from DICT_5X5_50; those in the pictures are from DICT_4X4_50"
    ):
        calibrate_stereo(pairs_of(CHARUCO, PLACES[:4]), other)


@pytest.mark.parametrize(
    ("told", "named"),
    [
        (Board(5, 7, 35.0, "charuco", 26.0, "DICT_4X4_50"), "board of 7x5 squares"),
        (Board(6, 4, 35.0, "charuco", 26.0, "DICT_4X4_50"), "board of 7x5 squares"),
    ],
    ids=["exchanged", "inner corners"],
)
def test_a_charuco_board_told_as_another_is_named(told, named):
    with pytest.raises(CalibrationError, match=f"the pictures show a .*{named}"):
        calibrate_stereo(pairs_of(CHARUCO, PLACES[:4]), told)


def test_a_chessboard_told_as_a_charuco_board_is_named():
    told = Board(7, 5, 35.0, "charuco", 26.0, "DICT_4X4_50")
    with pytest.raises(CalibrationError, match="the pictures show a board with 6x4 inner corners"):
        calibrate_stereo(pairs_of(CHESS, PLACES[:4]), told)


def test_a_recording_says_which_board(tmp_path):
    folder = tmp_path / "mine"
    folder.mkdir()
    shutil.copy(open_recording("bench").path / "recording.json", folder)
    facts = json.loads((folder / "recording.json").read_text())
    told = {
        "kind": "charuco",
        "columns": 7,
        "rows": 5,
        "square_mm": 35.0,
        "marker_mm": 26.0,
        "dictionary": "DICT_4X4_50",
    }

    def opened(**changes):
        (folder / "recording.json").write_text(json.dumps(facts | {"board": told | changes}))
        return open_recording(folder).board

    assert opened() == CHARUCO and opened().grid == (6, 4) and opened().corners_mm.shape == (24, 3)
    for changes, words in (
        ({"kind": "circles"}, "board kind: expected chessboard or charuco, got 'circles'"),
        ({"marker_mm": 34.0}, "board marker_mm: expected a number from 17.5 to 31.5 mm"),
        ({"marker_mm": None}, "board marker_mm: expected"),
        ({"dictionary": "5x5"}, "board dictionary: expected one of DICT_4X4_50 to DICT_7X7_1000"),
        ({"columns": 20, "rows": 12}, "DICT_4X4_50 has 50 markers, and the board needs 120"),
        ({"columns": 3}, "board columns"),
    ):
        with pytest.raises(RecordingError, match=words):
            opened(**changes)


def test_a_board_that_cannot_be_is_refused_in_python_too():
    with pytest.raises(StereoLabError, match="needs 120"):
        Board(20, 12, 25.0, "charuco", 18.0, "DICT_5X5_100")

"""Two films that nobody started at the same moment, drawn from cameras that are known exactly."""

import cv2
import numpy as np
import pytest
from rigs import turned

from stereo_lab import cli
from stereo_lab.calibration import calibrate_recording
from stereo_lab.capture import import_films
from stereo_lab.capture.films import Seen, fitted, offset_s
from stereo_lab.errors import RecordingError
from stereo_lab.recording import Board, open_recording
from stereo_lab.recording.video import read_timed

BOARD = Board(7, 5, 30.0)
CELL = 40  # px of the drawn board's squares
TURN, STEP = turned((0.5, 3.0, 0.4)), np.array([-110.0, 1.0, 2.0])
SIZES, RATES, LATER_S = ((640, 480), (800, 600)), (30.0, 24.0), 1.37
REST_S, MOVE_S, PLACES = 0.9, 0.7, 12


def drawn_board():
    squares = np.indices((BOARD.rows + 1, BOARD.columns + 1)).sum(0) % 2
    board = np.kron(squares * 200 + 30, np.ones((CELL, CELL)))
    return cv2.cvtColor(np.pad(board, CELL, constant_values=235).astype(np.uint8), cv2.COLOR_GRAY2BGR)


def where(time_s, places):
    """Turn and shift of the board at a time: it rests, and moves on smoothly."""
    at, since = divmod(time_s, REST_S + MOVE_S)
    part = np.clip((since - REST_S) / MOVE_S, 0, 1)
    one, other = places[int(at) % len(places)], places[(int(at) + 1) % len(places)]
    return one + (other - one) * (3 * part**2 - 2 * part**3)


def matrix_of(side):
    width, height = SIZES[side]
    return np.array([[1.1 * width, 0, width / 2 - 0.5], [0, 1.1 * width, height / 2 - 0.5], [0, 0, 1.0]])


def picture(board, side, pose):
    """What one camera sees: the drawn board, by the homography of its plane."""
    turn, shift = cv2.Rodrigues(pose[:3])[0], pose[3:]
    to_mm = np.array([[30 / CELL, 0, -60 + 15 / CELL], [0, 30 / CELL, -60 + 15 / CELL], [0, 0, 1.0]])
    middle = np.array([[1, 0, -90.0], [0, 1, -60.0], [0, 0, 1]])
    plane = np.column_stack([turn[:, :2], shift])
    if side:
        plane = np.column_stack([TURN @ turn[:, :2], TURN @ shift + STEP])
    image = np.full((*SIZES[side][::-1], 3), 150, np.uint8)
    view = cv2.warpPerspective(board, matrix_of(side) @ plane @ middle @ to_mm, SIZES[side], flags=cv2.INTER_AREA)
    mask = cv2.warpPerspective(np.full_like(board, 255), matrix_of(side) @ plane @ middle @ to_mm, SIZES[side])
    return np.where(mask > 127, view, image)


@pytest.fixture(scope="module")
def films(tmp_path_factory):
    rng, folder = np.random.default_rng(5), tmp_path_factory.mktemp("films")
    angles = np.radians(rng.uniform((-30, -30, -15), (30, 30, 15), (PLACES, 3)))
    depth = rng.uniform(420, 640, PLACES)
    across = rng.uniform((-0.22, -0.16), (0.3, 0.16), (PLACES, 2)) * depth[:, None]
    places, board = np.column_stack([angles, across, depth]), drawn_board()
    files = []
    for side, name in enumerate(("left", "right")):
        files.append(folder / f"{name}.avi")
        writer = cv2.VideoWriter(str(files[-1]), cv2.VideoWriter_fourcc(*"MJPG"), RATES[side], SIZES[side])
        for k in range(int(PLACES * (REST_S + MOVE_S) * RATES[side])):
            writer.write(picture(board, side, where(k / RATES[side] + side * LATER_S, places)))
        writer.release()
    return files


def test_two_films_give_a_calibration(films, tmp_path):
    recording, later = import_films(*films, BOARD, tmp_path / "mine", every=8)
    assert later == pytest.approx(LATER_S, abs=0.02)
    assert recording.image_size == SIZES[0] and len(recording.pairs("calibration")) >= 9
    calibration = calibrate_recording(recording)
    assert calibration.baseline_mm == pytest.approx(np.linalg.norm(STEP), rel=0.01)
    assert calibration.rms_px < 0.3
    assert calibration.right_matrix[0, 0] == pytest.approx(
        1.1 * SIZES[0][0], rel=0.01
    )  # the right film was made smaller


def test_the_command_takes_films(films, tmp_path, capsys):
    words = ["import", "--left", str(films[0]), "--right", str(films[1]), "--board", "7x5", "--square-mm", "30"]
    assert cli.main([*words, "--out", str(tmp_path / "mine")]) == 0
    said = capsys.readouterr().out
    assert "The right film began 1.3" in said and "Next: " in said
    assert cli.main([*words[:4], "x*.png", *words[5:], "--out", str(tmp_path / "other")]) == 2
    assert "is a film and" in capsys.readouterr().err


def test_a_film_that_is_stopped_leaves_nothing(films, tmp_path):
    def stops(what, done, total):
        if what == "take the pairs":
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        import_films(films[0], films[1], BOARD, tmp_path / "mine", every=8, progress=stops)
    assert list(tmp_path.iterdir()) == []


def test_films_of_two_boards_are_refused(films, tmp_path):
    still = tmp_path / "still.avi"
    writer = cv2.VideoWriter(str(still), cv2.VideoWriter_fourcc(*"MJPG"), 30, SIZES[0])
    frame = next(image for _, image in read_timed(films[0]))
    for _ in range(300):
        writer.write(frame)
    writer.release()
    with pytest.raises(RecordingError, match="do not show one moving board"):
        import_films(films[0], still, BOARD, tmp_path / "mine")
    assert not (tmp_path / "mine").exists()


def test_films_of_another_board_than_told(films, tmp_path):
    with pytest.raises(
        RecordingError, match=r"board with 8x5 inner corners is seen in 0 of \d+ frames.*other numbers of corners"
    ):
        import_films(*films, Board(8, 5, 30.0), tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_a_film_that_ends_in_the_middle(films, tmp_path):
    cut = tmp_path / "cut.avi"
    cut.write_bytes(films[1].read_bytes()[: int(films[1].stat().st_size * 0.7)])
    recording, later = import_films(films[0], cut, BOARD, tmp_path / "mine", every=8)
    assert later == pytest.approx(LATER_S, abs=0.02) and len(recording.pairs("calibration")) >= 4


@pytest.mark.parametrize("later_s", [-20.0, -0.33, 0.0, 4.2])
def test_the_offset_of_films_with_uneven_rates(later_s):
    """Speeds alone: a phone that films at an uneven rate, and misses the board now and then."""
    rng = np.random.default_rng(1)
    beats = np.cumsum(rng.uniform(0.8, 2.5, 60))

    def film(begins_s, mean_hz):
        times = np.cumsum(rng.uniform(0.5, 1.5, int(40 * mean_hz)) / mean_hz)
        at = np.array([np.interp(t + begins_s, beats, np.arange(60) % 2) for t in times + 25])
        outlines = np.zeros((len(times), 4, 2)) + at[:, None, None] * [100, 30] + rng.normal(0, 0.2, (len(times), 4, 2))

        class Place:
            def __init__(self, outline):
                self.outline = outline

        glances = [None if rng.random() < 0.1 else Place(outline) for outline in outlines]
        return Seen(times, glances, (640, 480))

    told, alike = offset_s(film(0.0, 30), film(later_s, 25))
    assert told == pytest.approx(later_s, abs=0.05) and alike > 0.5


def test_pictures_of_another_size_are_fitted():
    image = np.full((300, 800, 3), 200, np.uint8)
    whole = fitted(image, (640, 480))
    assert whole.shape == (480, 640, 3) and (whole[240] == 200).all() and (whole[:100] == 0).all()
    assert fitted(image, (800, 300)) is image


def test_the_times_of_frames(films):
    times = [time_s for time_s, _ in read_timed(films[1])]
    assert np.allclose(np.diff(times), 1 / RATES[1], atol=1e-3)


def test_an_imported_film_is_a_recording(films, tmp_path):
    import_films(*films, BOARD, tmp_path / "mine")
    assert open_recording(tmp_path / "mine").made_by == "camera"

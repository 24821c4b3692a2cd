"""The recorder: what it takes by itself, and that nothing of it is ever lost."""

import json
import os
import shutil
import signal
import subprocess
import sys
import threading
import time
from dataclasses import replace
from functools import partial

import cv2
import numpy as np
import pytest
from test_live import SIZE as FAKE_SIZE
from test_live import Fake

from stereo_lab import cli
from stereo_lab.calibration import find_corners
from stereo_lab.calibration.corners import other_board
from stereo_lab.capture import Coverage, Folder, Recorder, Replay, Session, State, glance
from stereo_lab.capture import folder as folders
from stereo_lab.doctor import check_recording
from stereo_lab.errors import CalibrationError, RecordingError, StereoLabError
from stereo_lab.live import CameraSource
from stereo_lab.live.sources import Frame
from stereo_lab.recording import Ball, Board, open_recording
from stereo_lab.recording.importing import import_images


@pytest.fixture(scope="module")
def third_rig():
    return open_recording("third_rig")


@pytest.fixture(scope="module")
def images(third_rig):
    return [(pair.left, pair.right) for pair in third_rig.pairs("calibration")]


@pytest.fixture
def folder(third_rig, tmp_path):
    with Folder(tmp_path / "mine", third_rig.image_size, third_rig.board, third_rig.ball) as folder:
        yield folder


def held(recorder, left, right, start_s, seconds=1.0):
    """What the recorder says while a board is held so."""
    return [recorder.look(Frame(start_s + t, left, right)) for t in np.arange(0, seconds, 0.1)]


def test_a_board_is_taken_when_it_is_new_and_still(third_rig, images, folder):
    with Recorder(folder, third_rig.board) as recorder:
        states = held(recorder, *images[0], 0)
        taken = [k for k, state in enumerate(states) if state.taken]
        assert (
            taken == [4] and states[1].said == "Hold still." and "is taken" in states[-1].said
        )  # after 0.4 s, and once
        assert not any(state.taken for state in held(recorder, *images[0], 5))
        assert any(state.taken for state in held(recorder, *images[1], 10))
        moving = [recorder.look(Frame(20 + k / 10, *images[k % 2 + 2])) for k in range(10)]
        assert not any(state.taken for state in moving)
    assert folder.names("calibration") == ["000", "001"]
    kept = cv2.imread(str(folder.path / "calibration" / "left" / "000.png"))
    assert np.array_equal(kept, images[0][0])  # to the last bit


def test_what_is_said_of_boards_that_cannot_be_taken(third_rig, images, folder):
    left, right = images[0]
    nothing = np.full_like(left, 120)
    with Recorder(folder, third_rig.board) as recorder:
        assert "No board is seen" in held(recorder, nothing, nothing, 0)[-1].said
        burnt = [cv2.convertScaleAbs(image, alpha=2.5) for image in (left, right)]
        assert "reflected" in held(recorder, *burnt, 10)[-1].said
        blurred = [cv2.GaussianBlur(image, (0, 0), 2.5) for image in (left, right)]
        assert "blurred" in held(recorder, *blurred, 20)[-1].said
        assert folder.names("calibration") == []


def said_of(recorder, pairs):
    """What is said in the end where pairs are shown for some seconds each, and whatever was asked is answered."""
    for start, (left, right) in enumerate(pairs):
        states = [recorder.look(Frame(6.0 * start + t, left, right)) for t in (0.0, 2.0, 5.5)]
        recorder._working.submit(int).result()
    return states[-1].said


@pytest.mark.parametrize("told", [(-1, 0), (1, 1)])
def test_a_board_of_another_size_is_named(third_rig, images, folder, told):
    there = third_rig.board
    wrong = replace(there, columns=there.columns + told[0], rows=there.rows + told[1])
    with Recorder(folder, wrong) as recorder:
        said = said_of(recorder, images[:5])
    assert f"but a {there}." in said and ("not squares" in said) == (told == (1, 1))


def test_a_board_that_is_cut_off_is_no_smaller_one(third_rig, images, folder):
    left, right = images[11]
    first = find_corners(left, third_rig.board).reshape(third_rig.board.rows, third_rig.board.columns, 2)[:, 0]
    cut = [image[:, int(first[:, 0].max() + 6) :] for image in (left, right)]
    assert other_board(cut[0], third_rig.board).columns == third_rig.board.columns - 1
    with Recorder(folder, third_rig.board) as recorder:
        assert said_of(recorder, 5 * [cut]).startswith("No board is seen")


def test_a_board_that_one_camera_sees_counts_at_its_rim_alone(third_rig, images, folder):
    nothing = np.full_like(images[0][0], 120)
    board = third_rig.board
    at_rim = next(left for left, _ in images if Coverage().reaches_rim(glance(left, board), 0))
    inside = next(left for left, _ in images if not Coverage().reaches_rim(glance(left, board), 0))
    with Recorder(folder, board) as recorder:
        assert "Only the left camera" in held(recorder, inside, nothing, 0)[-1].said
        assert any(state.taken for state in held(recorder, at_rim, nothing, 10))


def test_bars_fill_and_the_next_place_is_one_where_none_was(third_rig, images):
    coverage = Coverage()
    before = {bar.name: bar.part for bar in coverage.bars()}
    assert set(before.values()) == {0}
    for left, right in images:
        place = coverage.next_place()
        assert place.endswith(".")
        coverage.add(glance(left, third_rig.board), glance(right, third_rig.board))
        now = {bar.name: bar.part for bar in coverage.bars()}
        assert all(now[name] >= before[name] for name in now)
        before = now
    assert before["tilted"] == 1 and before["pairs"] >= (len(images) - 1) / 20


@pytest.mark.parametrize(
    ("turn", "name"), [((0, 25), "right"), ((0, -25), "left"), ((25, 0), "upper"), ((-25, 0), "lower")]
)
def test_a_tilt_is_told_as_it_is(turn, name):
    """A drawn board that is turned towards the camera with one edge: that edge is the one told."""
    board = Board(8, 6, 25.0)
    corners = np.asarray(board.corners_mm, float)
    corners = corners - corners.mean(0)
    edge = {"right": [100, 0, 0], "left": [-100, 0, 0], "upper": [0, -75, 0], "lower": [0, 75, 0]}[name]
    rotation = cv2.Rodrigues(np.radians([turn[0], turn[1], 0.0]))[0]
    matrix = np.array([[700.0, 0, 320], [0, 700, 240], [0, 0, 1]])
    assert (rotation @ edge)[2] < 0  # nearer to the camera
    pixels = cv2.projectPoints(corners, cv2.Rodrigues(rotation)[0], np.array([0, 0, 600.0]), matrix, None)[0].reshape(
        -1, 2
    )
    from stereo_lab.capture.coverage import TILTS
    from stereo_lab.capture.glance import _tilt

    tilt = _tilt(np.asarray(board.corners_mm, float), pixels, (640, 480))
    told = [words for words, (axis, sign) in TILTS.items() if sign * tilt[axis] > 15]
    assert told == [f"its {name} edge towards you"]


def test_starting_again_goes_on(third_rig, images, folder):
    with Recorder(folder, third_rig.board) as recorder:
        held(recorder, *images[0], 0)
    again = Folder(folder.path, third_rig.image_size, third_rig.board, third_rig.ball)
    with Recorder(again, third_rig.board) as recorder:
        assert len(recorder.coverage.taken) == 1
        assert not any(state.taken for state in held(recorder, *images[0], 0))
        assert [s.taken for s in held(recorder, *images[1], 10) if s.taken] == ["001"]


def test_ten_pairs_give_a_first_calibration(third_rig, images, folder):
    with Recorder(folder, third_rig.board) as recorder:
        for k, pair in enumerate(images):
            state = held(recorder, *pair, 10 * k)[-1]
        give_up = time.monotonic() + 30
        while state.calibration is None and time.monotonic() < give_up:
            state = recorder.look(Frame(1000 + time.monotonic(), *images[0]))
    assert state.calibration.verdict in ("good", "usable") and len(state.calibration.used) >= 10
    assert check_recording(folder.recording()).verdict == "clean"


def test_a_session_shows_every_pair_and_looks_at_the_newest(third_rig, folder):
    shown = []
    with Recorder(folder, third_rig.board) as recorder:
        source = Replay(third_rig.pairs("calibration")[:3], hold_s=1.2, rate_hz=15)
        Session(source, recorder, lambda frame, state: shown.append((frame.time_s, state.time_s))).run()
    assert len(folder.names("calibration")) == 3
    assert len(shown) > 30 and np.median([now - looked for now, looked in shown[5:]]) < 1


def test_no_pair_is_taken_without_being_shown(third_rig, images):
    class Quick:
        """Takes a pair at each look, quicker than anybody shows it."""

        looks = 0

        def look(self, frame):
            self.looks += 1
            return State(frame.time_s, taken=f"{self.looks - 1:03d}")

    class Pictures(Replay):
        left_over = 300

        def read(self):
            time.sleep(0.001)
            self.left_over -= 1
            return Frame(self.now(), *images[0]) if self.left_over else None

    recorder, shown = Quick(), []
    Session(Pictures(third_rig.pairs("calibration")[:1]), recorder, lambda _, state: shown.append(state.taken)).run()
    assert sorted({name for name in shown if name}) == [f"{k:03d}" for k in range(recorder.looks)]


def test_a_camera_that_falls_silent_is_told_and_waited_for(third_rig, images, folder):
    class Silent(Replay):
        times = 0

        def read(self):
            self.times += 1
            if self.times == 3:
                raise StereoLabError("The left camera (0) gave no picture.")
            return super().read()

    said = []
    with Recorder(folder, third_rig.board) as recorder:
        source = Silent(third_rig.pairs("calibration")[:1], hold_s=1.0)
        Session(source, recorder, lambda _, state: said.append(state.said)).run()
    assert "The left camera (0) gave no picture." in said and said[-1] != said[2]


def test_cameras_that_never_give_a_picture_are_told(third_rig, folder):
    class Nothing(Replay):
        def read(self):
            raise StereoLabError("The left camera (0) gave no picture.")

    shown = []

    def show(frame, state):
        shown.append((frame, state.said))
        session.stop()

    with Recorder(folder, third_rig.board) as recorder:
        session = Session(Nothing(third_rig.pairs("calibration")[:1]), recorder, show)
        session.run()
    assert shown == [(None, "The left camera (0) gave no picture.")] and session.frame is None


def test_a_recorder_that_fails_ends_a_session_whose_cameras_are_silent(third_rig, images):
    class Once(Replay):
        def read(self):
            if self._next:
                time.sleep(0.01)
                raise StereoLabError("silent")
            return super().read()

    class Broken:
        def look(self, frame):
            raise RuntimeError("broken")

    with pytest.raises(RuntimeError, match="broken"):
        Session(Once(third_rig.pairs("calibration")[:1]), Broken(), lambda *_: None).run()


# Nothing is lost


def test_a_recording_with_pictures_of_other_kinds_goes_on(third_rig, images, tmp_path):
    for side, ending, which in (("left", ".jpg", 0), ("right", ".png", 1)):
        (tmp_path / "from").mkdir(exist_ok=True)
        cv2.imwrite(str(tmp_path / "from" / f"{side}0{ending}"), images[0][which])
    pattern = [str(tmp_path / "from" / f"{side}*") for side in ("left", "right")]
    there = import_images(*pattern, third_rig.board, tmp_path / "there")
    with Folder(there.path, there.image_size, there.board, there.ball) as folder:
        assert folder.names("calibration") == ["000"] and folder.add_pair("calibration", *images[1]) == "001"
    assert [pair.name for pair in there.pairs("calibration")] == ["000", "001"]
    assert not (there.path / folders.ASIDE).exists()
    (there.path / "calibration" / "left" / "000.png").write_bytes(b"")
    with pytest.raises(RecordingError, match="000.jpg and 000.png: two pictures of one name"):
        there.pairs("calibration")


def test_a_table_that_a_spreadsheet_has_turned_round_takes_samples(images, folder):
    folder.add_sample("position", *images[0], (120.5, -85, 1000), "fit")
    table = folder.path / "position" / "measured.csv"
    for text in (
        "name,depth_mm,x_mm,y_mm,note\n000,1000,120.5,-85,hm",
        "name;x_mm;y_mm;depth_mm;use\r\n000;120,5;-85;1000;\r\n",
    ):
        table.write_text(text, newline="")
        folder.add_sample("position", *images[1], (1.5, 2, 300))
        places = [s.measured for s in folder.recording().samples("position")]
        assert [(p.x_mm, p.y_mm, p.depth_mm) for p in places] == [(120.5, -85, 1000), (1.5, 2, 300)]
        for side in ("left", "right"):
            (folder.path / "position" / side / "001.png").unlink()
    for text, use, says in (
        ("näme\n".encode("latin-1"), "", "as text"),
        (b"name,x_mm,y_mm,depth_mm\n", "fit", "missing: use"),
    ):
        table.write_bytes(text)
        with pytest.raises(StereoLabError, match=says):
            folder.add_sample("position", *images[1], (1, 2, 300), use)
        assert folder.names("position") == ["000"] and table.read_bytes() == text


def test_nothing_is_written_into_a_folder_that_is_gone(images, folder):
    shutil.rmtree(folder.path)
    with pytest.raises(StereoLabError, match="is gone"):
        folder.add_pair("calibration", *images[0])
    assert not folder.path.exists()


def test_a_lock_is_let_go_once_and_by_whoever_holds_it(third_rig, images, folder):
    facts = folder.path, third_rig.image_size, third_rig.board, third_rig.ball
    folder.add_pair("calibration", *images[0])
    folder.close()
    good = (folder.path / "calibration" / "left" / "000.png").read_bytes()
    (folder.path / "calibration" / "left" / "000.png").write_bytes(good[:100])
    with pytest.raises(StereoLabError):
        Recorder(Folder(*facts), third_rig.board)
    (folder.path / "calibration" / "left" / "000.png").write_bytes(good)
    with Folder(*facts):
        folder.close()  # again, and it is not its lock any more
        with pytest.raises(RecordingError, match="Another recorder is at work"):
            Folder(*facts)


def test_two_recorders_on_one_folder(third_rig, folder):
    with pytest.raises(RecordingError, match="Another recorder is at work"):
        Folder(folder.path, third_rig.image_size, third_rig.board, third_rig.ball)
    folder.close()
    Folder(folder.path, third_rig.image_size, third_rig.board, third_rig.ball).close()
    assert not (folder.path / folders.LOCK).exists()


def test_the_lock_of_a_dead_recorder_is_taken_over(third_rig, folder):
    folder.close()
    gone = subprocess.Popen([sys.executable, "-c", ""])
    gone.wait()
    restarted = f"{os.getpid()} 5.0"  # a process of today with the number of one from before a restart
    for left_behind in (f"{gone.pid} 5.0", str(gone.pid), restarted, "", "nonsense"):
        (folder.path / folders.LOCK).write_text(left_behind)
        Folder(folder.path, third_rig.image_size, third_rig.board, third_rig.ball).close()


KILLED = """
import sys
from stereo_lab.capture import Folder
from stereo_lab.recording import open_recording
rec = open_recording("third_rig")
pair = rec.pairs("calibration")[0]
folder = Folder(sys.argv[1], rec.image_size, rec.board, rec.ball)
print("ready", flush=True)
while True:
    folder.add_sample("position", pair.left, pair.right, (1, 2, 3))
"""


@pytest.mark.skipif(sys.platform == "win32", reason="kill -9 is of Unix")
def test_killed_while_it_writes(third_rig, tmp_path):
    """Killed without a warning, at several moments: what is there can be opened, every picture is whole, and one can go on."""
    for delay_s in (0.05, 0.11, 0.17, 0.26):
        out = tmp_path / f"killed_{delay_s}"
        at_work = subprocess.Popen([sys.executable, "-c", KILLED, str(out)], stdout=subprocess.PIPE)
        at_work.stdout.readline()
        time.sleep(delay_s)
        os.kill(at_work.pid, signal.SIGKILL)
        at_work.wait()
        with Folder(out, third_rig.image_size, third_rig.board, third_rig.ball) as folder:
            recording = folder.recording()
            if folder.names("position"):
                for pair in recording.pairs("position"):
                    assert pair.left.shape == pair.right.shape
            before = len(recording.samples("position")) if (out / "position" / "measured.csv").exists() else 0
            left, right = third_rig.pairs("calibration")[0].left, third_rig.pairs("calibration")[0].right
            folder.add_sample("position", left, right, (4, 5, 6))
            assert len(folder.recording().samples("position")) == before + 1
            assert not list(out.rglob("*.part"))


def test_a_full_disk_is_said_and_nothing_is_half_written(third_rig, images, folder, monkeypatch):
    real, left_to_write = folders.write_whole, [1]

    def full(path, content):
        if left_to_write[0] == 0:
            raise StereoLabError(f"Cannot write {path}: No space left on device. Free some space.")
        left_to_write[0] -= 1
        real(path, content)

    monkeypatch.setattr(folders, "write_whole", full)  # full after the first half of a pair
    with Recorder(folder, third_rig.board) as recorder:
        states = held(recorder, *images[0], 0)
        assert any("No space left" in state.said for state in states) and not any(state.taken for state in states)
        assert folder.names("calibration") == [] and not list(folder.path.glob("calibration/*/*.png"))
        left_to_write[0] = 99  # space was made
        assert any(state.taken for state in held(recorder, *images[0], 10))


def test_folders_that_it_must_not_fill(third_rig, folder, tmp_path):
    size, board, ball = third_rig.image_size, third_rig.board, third_rig.ball
    folder.close()
    with pytest.raises(RecordingError, match="was begun with a board"):
        Folder(folder.path, size, Board(9, 7, 20.0), ball)
    with pytest.raises(RecordingError, match="was begun with pictures of 640x480"):
        Folder(folder.path, (320, 240), board, ball)
    (tmp_path / "letters").mkdir()
    (tmp_path / "letters" / "dear.txt").write_text("Dear")
    with pytest.raises(RecordingError, match="is no recording"):
        Folder(tmp_path / "letters", size, board, ball)
    assert [p.name for p in (tmp_path / "letters").iterdir()] == ["dear.txt"]


def test_samples_are_those_that_were_typed(images, folder):
    folder.add_sample("position", *images[0], (120.5, -85, 1000), "fit")
    folder.add_sample("position", *images[1], ("30", "40", "900"))
    one, other = folder.recording().samples("position")
    assert (one.measured.x_mm, one.measured.y_mm, one.measured.depth_mm, one.use) == (120.5, -85, 1000, "fit")
    assert (other.pair.name, other.measured.depth_mm, other.use) == ("001", 900, "")
    with pytest.raises(StereoLabError, match="position, depth_mm"):
        folder.add_sample("position", *images[0], (1, 2, "far"))
    assert folder.names("position") == ["000", "001"]


# Cameras, and the command


class Locking(Fake):
    """A camera whose focus can be held, and nothing else."""

    def get(self, what):
        return self.asked.get(what, 1) if what in (cv2.CAP_PROP_AUTOFOCUS, cv2.CAP_PROP_FOCUS) else -1.0

    def read(self):
        """A picture every few milliseconds, as long as it is open."""
        picture = np.full((*FAKE_SIZE[::-1], 3), 100, np.uint8)
        return (False, None) if self.released.wait(0.005) else (True, picture)


def test_a_camera_that_is_plugged_in_again_is_held_again(monkeypatch):
    Fake.cameras = {"all": []}
    monkeypatch.setattr("stereo_lab.live.cameras.AGAIN_S", 0.01)
    with CameraSource(0, 1, FAKE_SIZE, 30.0, Locking) as source:
        source.lock()
        Fake.cameras["all"][1].release()  # out, and in again
        until = time.monotonic() + 60
        while len(Fake.cameras["all"]) < 3 or cv2.CAP_PROP_AUTOFOCUS not in Fake.cameras["all"][2].asked:
            assert time.monotonic() < until
            time.sleep(0.01)


class Waiting(Fake):
    """A camera that never gives a picture."""

    def read(self):
        self.asked["picture"] = True
        self.released.wait()
        return False, None


def test_what_cannot_be_locked_is_said():
    Fake.cameras = {"all": []}
    with CameraSource(0, 1, FAKE_SIZE, 30.0, Locking) as source:
        said = source.lock()
        assert len(said) == 2 and "The left camera (0) does not let its exposure and white balance be held" in said[0]
        assert all(fake.asked[cv2.CAP_PROP_AUTOFOCUS] == 0 for fake in Fake.cameras["all"])


def test_a_camera_that_does_not_answer_is_not_taken_for_held(monkeypatch):
    Fake.cameras = {"all": []}
    monkeypatch.setattr("stereo_lab.live.cameras.LOCK_S", 0.2)
    with CameraSource(0, 1, FAKE_SIZE, 30.0, Waiting) as source:
        while not all(fake.asked.get("picture") for fake in Fake.cameras["all"]):
            time.sleep(0.01)
        said = source.lock()
        assert len(said) == 2 and "The right camera (1) has not said within 0.2 s that it lets its focus and" in said[1]
        for fake in Fake.cameras["all"]:
            fake.release()


@pytest.fixture(scope="module")
def films(third_rig, tmp_path_factory):
    """Two video files in which somebody holds a board still."""
    return write_films(tmp_path_factory.mktemp("films"), third_rig, 200)


def write_films(folder, recording, count, sets=("calibration", "calibration"), grey=False):
    """Two video files of the first pair of boards, or of other sets, so many frames long; gives their names."""
    films = []
    for side, name in zip(("left", "right"), sets, strict=True):
        films.append(str(folder / f"{side}.avi"))
        writer = cv2.VideoWriter(films[-1], cv2.VideoWriter_fourcc(*"MJPG"), 15, recording.image_size)
        assert writer.isOpened()
        picture = getattr(recording.pairs(name)[0], side)
        if grey:
            picture = cv2.cvtColor(cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY), cv2.COLOR_GRAY2BGR)
        for _ in range(count):
            writer.write(picture)
        writer.release()
    return films


class Played:
    """A video file, opened by OpenCV, that comes over and over."""

    def __init__(self, path):
        self.film = cv2.VideoCapture(path)

    def __getattr__(self, name):
        return getattr(self.film, name)

    def read(self):
        good, picture = self.film.read()
        if not good:
            self.film.set(cv2.CAP_PROP_POS_FRAMES, 0)
            good, picture = self.film.read()
        return good, picture


def test_the_command_records_from_what_opencv_opens(films, third_rig, tmp_path, capsys, monkeypatch):
    def ends_when_one_is_taken(*words, **how):
        print(*words, **how)
        if words[0].startswith("Taken: pair"):
            raise KeyboardInterrupt

    monkeypatch.setattr("stereo_lab.live.CameraSource", partial(CameraSource, open_capture=Played))
    monkeypatch.setattr("stereo_lab.cli.capture.print", ends_when_one_is_taken, raising=False)
    out, told = tmp_path / "mine", tmp_path / "told.json"
    board = third_rig.board
    arguments = [
        "record", str(out), "--left", films[0], "--right", films[1], "--board", f"{board.columns}x{board.rows}",
        "--square-mm", str(board.square_mm), "--ball-color", "blue", "--seconds", "300", "--json", str(told),
    ]  # fmt: skip
    assert cli.main(arguments) == 0
    said = capsys.readouterr().out
    taken = json.loads(told.read_text())["taken"]
    assert taken == 1 and "Taken: pair 000" in said and "Next: " in said
    assert "The ball: blue, 40 mm wide. (Is yours another one?" in said  # its width was not told
    recording = open_recording(out)
    assert (
        len(recording.pairs("calibration")) == taken
        and recording.board == board
        and recording.ball == Ball("blue", 40.0)
    )


def test_cameras_of_another_size_begin_no_folder(films, tmp_path, capsys):
    words = ["record", str(tmp_path / "mine"), "--left", films[0], "--right", films[1], "--size", "320x240"]
    assert cli.main(words) == 2
    said = capsys.readouterr().err
    assert "of 640x480 instead of 320x240. Ask for that size, as with record --size 640x480" in said
    assert not (tmp_path / "mine").exists()


def test_places_are_typed_in(films, tmp_path, capsys, monkeypatch):
    lines = iter(["120 85 1000", "1 2", "1 2 far", "130,5 85 1000", ""])
    monkeypatch.setattr("builtins.input", lambda _="": next(lines))
    out = tmp_path / "mine"
    arguments = ["record", str(out), "--left", films[0], "--right", films[1], "--set", "position"]
    assert cli.main(arguments) == 0
    said = capsys.readouterr().out
    assert (
        "Taken: position/001." in said
        and "Three numbers were expected" in said
        and "expected a number, got 'far'" in said
    )
    assert [s.measured.x_mm for s in open_recording(out).samples("position")] == [120, 130.5]


@pytest.mark.parametrize(
    ("sets", "says"),
    [
        (("position", "position"), "Taken: position/000.\n"),
        (("position", "calibration"), "Taken: position/000. No red ball is seen in the right picture: look at it, and"),
        (
            ("calibration", "calibration"),
            "Taken: position/000. No red ball is seen in either picture: look at them, and",
        ),
    ],
)
def test_a_place_whose_ball_is_not_seen_is_told_at_once(third_rig, tmp_path, capsys, monkeypatch, sets, says):
    films = write_films(tmp_path, third_rig, 60, sets)
    lines = iter(["120 85 1000", ""])
    monkeypatch.setattr("builtins.input", lambda _="": next(lines))
    assert (
        cli.main(["record", str(tmp_path / "mine"), "--left", films[0], "--right", films[1], "--set", "position"]) == 0
    )
    assert says in capsys.readouterr().out


def test_a_place_taken_in_grey_is_told(third_rig, tmp_path, capsys, monkeypatch):
    films = write_films(tmp_path, third_rig, 60, ("position", "position"), grey=True)
    lines = iter(["120 85 1000", ""])
    monkeypatch.setattr("builtins.input", lambda _="": next(lines))
    assert (
        cli.main(["record", str(tmp_path / "mine"), "--left", films[0], "--right", films[1], "--set", "position"]) == 0
    )
    assert "position/000. No red ball is seen: the picture is grey." in capsys.readouterr().out
    assert cli.main(["detect", films[0]]) == 0
    assert "frame 59: no ball; this is a grey picture" in capsys.readouterr().out


def test_places_end_with_the_film(third_rig, tmp_path, capsys, monkeypatch):
    films = write_films(tmp_path, third_rig, 1)
    monkeypatch.setattr("builtins.input", lambda _="": "120 85 1000")
    assert cli.main(["record", str(tmp_path / "mine"), "--left", films[0], "--right", films[1], "--set", "depth"]) == 0
    assert "The film is at its end." in capsys.readouterr().out


def test_a_recording_that_was_begun_knows_its_board(films, folder, third_rig, capsys, monkeypatch):
    folder.close()
    monkeypatch.setattr("builtins.input", lambda _="": "")
    words = ["record", str(folder.path), "--left", films[0], "--right", films[1], "--set", "depth"]
    assert cli.main(words) == 0
    assert cli.main([*words, "--board", "9x6"]) == 2
    assert f"was begun with a {third_rig.board}" in capsys.readouterr().err
    board = third_rig.board
    assert cli.main([*words, "--board", f"{board.columns}x{board.rows}"]) == 0  # of squares as they are there
    assert cli.main([*words, "--square-mm", f"{board.square_mm + 1:g}"]) == 2
    assert (
        f"squares of {board.square_mm:g} mm; this is a {board}, of {board.square_mm + 1:g} mm"
        in capsys.readouterr().err
    )
    same, ball = ["--ball-color", third_rig.ball.color, "--ball-mm", f"{third_rig.ball.diameter_mm:g}"], third_rig.ball
    assert cli.main([*words, *same]) == 0 and open_recording(folder.path).ball == ball
    assert cli.main([*words, "--ball-color", "yellow", "--ball-mm", "60"]) == 2
    assert f"begun with a {ball.color} ball of {ball.diameter_mm:g} mm; this is a yellow one" in capsys.readouterr().err
    assert open_recording(folder.path).ball == ball


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["--size", "large"], "--size: expected width x height"),
        (["--board", "9"], "--board: expected columns x rows"),
        (["--left", "other_film.avi"], "does not open"),
        (["--left", "no_such_film.avi"], "both name camera no_such_film.avi"),
    ],
)
def test_bad_words_are_refused(words, says, tmp_path, capsys):
    assert cli.main(["record", str(tmp_path / "mine"), "--right", "no_such_film.avi", *words]) == 2
    assert says in capsys.readouterr().err
    assert not (tmp_path / "mine").exists()


# The panel


class UntilTaken(Replay):
    """Holds each board until the recorder has it: how busy this computer is makes no difference."""

    def __init__(self, pairs, out):
        super().__init__(pairs)
        self._out, self._left = out, 60  # frames after all are taken: what is shown then is the last state

    def read(self):
        self._next = self._pace.due(self._next) + 1
        taken = len(list((self._out / "calibration" / "left").glob("*.png")))
        self._left -= taken >= len(self.pairs)
        pair = self.pairs[min(taken, len(self.pairs) - 1)]
        return Frame((self._next - 1) / self.rate_hz, pair.left, pair.right) if self._left else None


def test_the_panel_records_while_the_page_is_there(third_rig, tmp_path):
    from stereo_lab import widgets

    pairs = third_rig.pairs("calibration")[:2]
    out = tmp_path / "mine"
    panel = widgets.recorder_panel(lambda: UntilTaken(pairs, out), out, third_rig.board, third_rig.ball)
    assert repr(panel) == "panel: the recorder" and not (tmp_path / "mine").exists()
    panel.take_ball("position")
    assert "No pictures yet" in panel.text.value
    empty = panel.picture.value
    panel.play.playing = True
    give_up = time.monotonic() + 120
    while panel.picture.value == empty and time.monotonic() < give_up:
        time.sleep(0.05)
    panel.place["depth"].value = 900
    panel.take_ball("position")
    while panel.thread.is_alive() and time.monotonic() < give_up:
        panel._tick(None)
        time.sleep(0.2)
        panel.play.playing = False if panel.text.value.startswith("Ended") else panel.play.playing
    panel.play.playing = False
    panel.thread.join(10)
    recording = open_recording(tmp_path / "mine")
    assert len(recording.pairs("calibration")) == 2 and recording.samples("position")[0].measured.depth_mm == 900
    assert panel.bars["pairs"].value == pytest.approx(0.1) and panel.text.value.startswith("Ended")


def test_what_was_taken_stays_in_words_while_pictures_come(third_rig, tmp_path):
    from stereo_lab import widgets

    class Balls(Replay):
        def read(self):
            asked.release()
            return super().read()

    def balls():
        return Balls([sample.pair for sample in third_rig.samples("position")], hold_s=60)

    panel = widgets.recorder_panel(balls, tmp_path / "mine", third_rig.board, third_rig.ball)
    asked, said = threading.Semaphore(0), []
    panel.text.observe(lambda change: said.append(change["new"]), "value")
    panel.play.playing = True
    while not (said and said[-1].startswith("No board is seen")):
        assert asked.acquire(timeout=60)
    panel.take_ball("position")
    assert "type in x, y and depth" in panel.text.value and not (tmp_path / "mine" / "position").exists()
    panel.place["x"].value, panel.place["depth"].value = -20.5, 900
    panel.take_ball("position")
    for _ in range(8):  # half a second
        assert asked.acquire(timeout=60)
    panel.play.playing = False
    panel.thread.join(60)
    assert said[-2] == "Taken: position/000 at x -20.5, y 0, depth 900 mm." and said[-1].startswith("Ended")


@pytest.mark.filterwarnings("ignore::pytest.PytestUnhandledThreadExceptionWarning")
def test_a_panel_tells_also_what_nobody_foresaw(third_rig, tmp_path):
    from stereo_lab import widgets

    def broken():
        raise OSError("the driver is gone")

    panel = widgets.recorder_panel(broken, tmp_path / "mine", third_rig.board, third_rig.ball)
    panel.play.playing = True
    panel.thread.join(60)
    assert "OSError: the driver is gone. Press play" in panel.text.value


def test_a_panel_without_lambda_gets_a_sentence_and_lets_the_source_go(third_rig, tmp_path):
    from stereo_lab import widgets

    source = Replay(third_rig.pairs("calibration")[:1])
    with pytest.raises(StereoLabError, match="got Replay. Write lambda: before it"):
        widgets.recorder_panel(source, tmp_path / "mine", third_rig.board, third_rig.ball)
    assert source.read() is None


def test_a_panel_whose_page_is_gone_ends(third_rig, tmp_path):
    from stereo_lab.widgets import RecorderPanel

    pairs = third_rig.pairs("calibration")
    panel = RecorderPanel(lambda: Replay(pairs), tmp_path / "mine", third_rig.board, third_rig.ball, silent_s=0.5)
    panel.play.playing = True
    panel.thread.join(15)
    assert not panel.thread.is_alive() and not (tmp_path / "mine" / folders.LOCK).exists()


def test_stop_while_the_cameras_open_is_heard(third_rig, tmp_path):
    from stereo_lab import widgets

    opening, may = threading.Event(), threading.Event()

    def slowly():
        opening.set()
        assert may.wait(60)
        return Replay(third_rig.pairs("calibration"))

    panel = widgets.recorder_panel(slowly, tmp_path / "mine", third_rig.board, third_rig.ball)
    panel.play.playing = True
    assert opening.wait(60)
    panel.play.playing = False
    may.set()
    panel.thread.join(60)
    assert not panel.thread.is_alive() and not (tmp_path / "mine" / "calibration").exists()


def test_one_press_too_many_takes_nothing(third_rig, tmp_path):
    from stereo_lab import widgets

    pairs = [sample.pair for sample in third_rig.samples("position")]
    panel = widgets.recorder_panel(lambda: Replay(pairs, hold_s=60), tmp_path / "mine", third_rig.board, third_rig.ball)
    panel.play.playing = True
    give_up = time.monotonic() + 60
    while (panel._session is None or panel._session.frame is None) and time.monotonic() < give_up:
        time.sleep(0.02)
    said, asked = [], []
    for depth in (0, -900, 0.9, 60, 900, 900, 950):  # 60: in centimetres
        panel.place["depth"].value = depth
        panel.take_ball("depth")
        said.append(panel.text.value.partition(" ")[0])
        asked.append("are these millimetres?" in panel.text.value)
    panel.play.playing = False
    panel.thread.join(60)
    assert said == ["Measure", "Measure", "A", "A", "Taken:", "There", "Taken:"]
    assert asked == [False, False, True, True, False, False, False]
    assert len(open_recording(tmp_path / "mine").samples("depth")) == 2


def test_a_panel_tells_at_once_whose_ball_is_not_seen(third_rig, tmp_path):
    from stereo_lab import widgets

    boards = third_rig.pairs("calibration")
    panel = widgets.recorder_panel(
        lambda: Replay(boards, hold_s=60), tmp_path / "mine", third_rig.board, third_rig.ball
    )
    panel.play.playing = True
    give_up = time.monotonic() + 60
    while (panel._session is None or panel._session.frame is None) and time.monotonic() < give_up:
        time.sleep(0.02)
    panel.place["depth"].value = 900
    for name in ("000", "001"):  # the same place is taken again: the sentence asks for it
        panel.take_ball("position")
        assert panel.text.value.startswith(
            f"Taken: position/{name} at x 0, y 0, depth 900 mm. No orange ball is seen in either"
        )
        assert panel.text.value.endswith(f" {name} stays, and is passed over where no ball is found in it.")
    panel.play.playing = False
    panel.thread.join(60)


def test_why_the_pairs_do_not_fit_is_said_while_one_can_still_act(third_rig, images, folder, monkeypatch):
    def fails(pairs, board):
        raise CalibrationError("Left and right are swapped.")

    monkeypatch.setattr("stereo_lab.capture.recorder.calibrate_stereo", fails)
    for what in ("FIRST", "AGAIN"):
        monkeypatch.setattr(f"stereo_lab.capture.recorder.{what}", 1)
    with Recorder(folder, third_rig.board) as recorder:
        assert any(state.taken for state in held(recorder, *images[0], 0))
        recorder._working.shutdown(wait=True)
        recorder.look(Frame(2.0, *images[0]))
        assert recorder.look(Frame(2.1, *images[0])).said.endswith("do not fit: Left and right are swapped.")

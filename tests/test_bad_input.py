"""Input that nobody means to give: each is answered in one plain sentence, and nothing is left half written."""

import errno
import importlib
import json
import os
import shutil
import struct
import subprocess
import sys
import tempfile
import threading
import zlib
from types import SimpleNamespace

import cv2
import numpy as np
import pytest

from conftest import ROOT
from stereo_lab.calibration import (
    calibrate_anew,
    calibrate_recording,
    calibrate_stereo,
    find_corners,
    find_homography,
    store,
)
from stereo_lab.cli import main
from stereo_lab.common.files import read_json, read_text, typed, whole_folder, write_whole
from stereo_lab.common.spreadsheets import read_table
from stereo_lab.common.threads import one_thread
from stereo_lab.depth import OffsetDepth
from stereo_lab.detection import BallColor, BallDetector
from stereo_lab.errors import RecordingError, StereoLabError
from stereo_lab.exercises import progress, questions
from stereo_lab.kinematics import JointAngles
from stereo_lab.live import Follower, open_source, run
from stereo_lab.localization import Localizer
from stereo_lab.recording import Ball, Board, import_images, open_recording, read_image
from stereo_lab.recording.cameras import CameraPair
from stereo_lab.recording.strays import strays

FACTS = {
    "format": 1,
    "image_size": [64, 48],
    "board": {"columns": 9, "rows": 6, "square_mm": 25.0},
    "ball": {"color": "red", "diameter_mm": 40.0},
}
PICTURE = ROOT / "data" / "bench" / "snaps" / "left" / "000.jpg"
no_pipes = pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="this system has no pipes among its files")


@pytest.fixture
def small(tmp_path):
    """A recording with one pair and a table."""
    folder = tmp_path / "small"
    for side in ("left", "right"):
        (folder / "position" / side).mkdir(parents=True)
        cv2.imwrite(str(folder / "position" / side / "000.jpg"), np.zeros((48, 64, 3), np.uint8))
    write_facts(folder)
    write_table(folder, "000,1,2,3,fit")
    return folder


def write_facts(folder, **changes):
    (folder / "recording.json").write_text(json.dumps({**FACTS, **changes}))


def write_table(folder, row):
    (folder / "position" / "measured.csv").write_text(f"name,x_mm,y_mm,depth_mm,use\n{row}\n")


def refused(capsys, *arguments):
    """What a command says when it refuses: one line, exit code 2."""
    assert main([str(word) for word in arguments]) == 2
    said = capsys.readouterr().err
    assert said.startswith("stereo-lab: ") and said.count("\n") == 1
    return said


# --- pictures ------------------------------------------------------------------------------------------------


def png_that_says(width, height):
    """A PNG of a few bytes whose header promises this size."""

    def chunk(kind, content):
        return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))

    header = chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0))
    return b"\x89PNG\r\n\x1a\n" + header + chunk(b"IDAT", zlib.compress(b"\0" * 99)) + chunk(b"IEND", b"")


def jpeg_that_says(width, height):
    """A JPEG of 8x8 pixels whose header promises this size."""
    data = bytearray(cv2.imencode(".jpg", np.zeros((8, 8, 3), np.uint8))[1].tobytes())
    start = data.find(b"\xff\xc0")
    data[start + 5 : start + 9] = struct.pack(">HH", height, width)
    return bytes(data)


@pytest.mark.parametrize("make", [png_that_says, jpeg_that_says])
@pytest.mark.parametrize(("side", "says"), [(60_000, "far more"), (11_000, "11000x11000")])
def test_a_small_file_that_says_it_is_huge(tmp_path, capsys, make, side, says):
    path = tmp_path / "bomb.png"
    path.write_bytes(make(side, side))
    with pytest.raises(RecordingError, match=f"100 megapixels at most, got {says}"):
        read_image(path)
    assert "too large" in refused(capsys, "detect", path)


@pytest.mark.parametrize("side", [0, 30_000])
def test_a_header_that_opencv_stumbles_over(tmp_path, side):
    path = tmp_path / "odd.png"
    path.write_bytes(png_that_says(side, 8))
    with pytest.raises(RecordingError, match="broken"):
        read_image(path)


# --- pipes, devices, folders, large files ----------------------------------------------------------------------


@no_pipes
def test_pipes_are_not_waited_for(small, capsys):
    pipe = small / "position" / "left" / "001.jpg"
    os.mkfifo(pipe)
    assert "got a pipe" in refused(capsys, "detect", pipe)
    assert "got a pipe" in refused(capsys, "detect", PICTURE, "--color-from", pipe)
    with pytest.raises(RecordingError, match="got a pipe"):
        read_table(pipe, ("name",))
    with pytest.raises(StereoLabError, match="got a pipe"):
        read_json(pipe)


@no_pipes
@pytest.mark.parametrize("name", ["position/measured.csv", "truth.json"])
def test_a_pipe_inside_a_recording(small, name):
    (small / name).unlink(missing_ok=True)
    os.mkfifo(small / name)
    with pytest.raises(RecordingError, match="got a pipe"):
        open_recording(small).samples("position")


@no_pipes
def test_a_pipe_among_the_boards(small, capsys):
    (small / "position").rename(small / "calibration")
    (small / "calibration" / "left" / "000.jpg").unlink()
    os.mkfifo(small / "calibration" / "left" / "000.jpg")
    assert "got a pipe" in refused(capsys, "calibrate", small)


def test_a_device_and_a_folder(tmp_path, capsys):
    assert "got a device" in refused(capsys, "detect", os.devnull)
    assert "no pictures (.jpg or .png) in the folder" in refused(capsys, "detect", tmp_path)
    (tmp_path / "snaps" / "left").mkdir(parents=True)
    assert "There are some in" in refused(capsys, "detect", tmp_path)


def test_a_text_file_that_is_far_too_large(tmp_path):
    path = tmp_path / "recording.json"
    with path.open("wb") as file:
        file.truncate(61_000_000)  # takes no room on the disk
    with pytest.raises(StereoLabError, match="50 MB at most, got 61 MB"):
        read_json(path)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ('{"square_mm": 29,5, "b": 1}', "a point, not a comma"),
        ('{"square_mm": 29,5}', "a point, not a comma"),
        ('{"a": [1, 2,]}', "Take the comma before the bracket away"),
        ('{"a": 1,\n}', "Take the comma before the bracket away"),
        ('{"a": 1 "b": 2}', "Look for a missing comma"),
        ('{"a": 1,, "b": 2}', "Look for a missing comma"),
    ],
)
def test_what_people_write_in_json_is_named(tmp_path, text, says):
    path = tmp_path / "recording.json"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(StereoLabError, match=says):
        read_json(path)


def test_a_table_that_is_no_text(tmp_path):
    path = tmp_path / "x.csv"
    path.write_text("name\n" + "x" * 200_000 + "\n")
    with pytest.raises(RecordingError, match="no table"):
        read_table(path, ("name",))


# --- numbers that no room holds ----------------------------------------------------------------------------------


@pytest.mark.parametrize("row", ["000,1e308,2,3,fit", "000,1,-2e5,3,fit", "000,1,2,100001,fit"])
def test_places_that_no_room_holds(small, row):
    write_table(small, row)
    with pytest.raises(RecordingError, match=r"line 2, .*expected a number from -100,000 to 100,000 mm"):
        open_recording(small).samples("position")


BOARD, BALL, ARM = FACTS["board"], FACTS["ball"], {"l1_mm": 250, "l2_mm": 200, "depth_mm": 1000}


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"board": {**BOARD, "columns": 10**9}}, "board columns: expected a number from 3 to 100, got 1000000000"),
        ({"board": {**BOARD, "rows": 2}}, "board rows: expected a number from 3 to 100, got 2"),
        ({"board": {**BOARD, "square_mm": 1e308}}, "board square_mm: expected a number from 0.001 to 100,000 mm"),
        ({"ball": {**BALL, "diameter_mm": 1e-300}}, "ball diameter_mm: expected a number"),
        ({"ball": {**BALL, "diameter_mm": 10**400}}, "ball diameter_mm: expected a number"),
        ({"arm": {**ARM, "l1_mm": 1e9}}, "arm l1_mm: expected a number"),
        ({"arm": {**ARM, "depth_mm": 1e9}}, "arm depth_mm: expected a number"),
        ({"arm": {**ARM, "theta1_deg": [-1e300, 1e300]}}, "arm theta1_deg: expected a number"),
        ({"image_size": [10**6, 48]}, "image_size: expected a number from 8 to 20,000"),
        ({"image_size": [20_000, 20_000]}, "image_size: expected 100 megapixels at most"),
        ({"frame_rate": 1e9}, "frame_rate: expected a number"),
        ({"frame_rate": 0}, "frame_rate: expected a number"),
        ({"frame_rate": "x" * 10_000}, "frame_rate: expected a number"),
    ],
)
def test_facts_that_no_room_holds(small, change, says):
    write_facts(small, **change)
    with pytest.raises(RecordingError, match=says) as error:
        open_recording(small)
    assert len(str(error.value)) < len(str(small)) + 200


@pytest.mark.parametrize(
    ("option", "value", "says"),
    [
        ("--board", "2x6", "from 3 to 100, got '2'"),
        ("--board", "9x1000000000", "from 3 to 100"),
        ("--board", "²x6", "expected a number"),
        ("--square-mm", "1e9", "from 0.001 to 100,000 mm"),
        ("--ball-mm", "-1", "from 0.001 to 100,000 mm"),
        ("--ball-color", "pink", "expected one of red"),
    ],
)
def test_import_refuses_before_it_writes(tmp_path, capsys, option, value, says):
    options = {"--left": PICTURE, "--right": PICTURE, "--board": "9x6", "--square-mm": "25", "--out": tmp_path / "out"}
    words = [word for pair in {**options, option: value}.items() for word in pair]
    said = refused(capsys, "import", *words)
    assert option in said and says in said
    assert list(tmp_path.iterdir()) == []


def test_a_board_too_small_for_opencv():
    with pytest.raises(StereoLabError, match="board columns: expected a number from 3 to 100, got 2"):
        Board(2, 6, 25.0)


@pytest.mark.parametrize(
    ("circle", "says"), [("116,140,1e308", "fill their"), ("1e308,0,5", "outside"), ("0,0,inf", "finite")]
)
def test_circles_that_no_picture_holds(tmp_path, capsys, circle, says):
    (tmp_path / "balls.csv").write_text(f"file,u,v,radius_px\n{PICTURE},{circle}\n")
    assert says in refused(capsys, "detect", PICTURE, "--color-from", tmp_path / "balls.csv")


def test_two_lines_are_told_as_too_few_and_not_as_lost_balls(tmp_path):
    mine = tmp_path / "mine"
    shutil.copytree(
        ROOT / "data" / "bench", mine, ignore=shutil.ignore_patterns("evaluation", "track", "snaps", "still")
    )
    for name, lines in (("position", 1), ("depth", 2)):
        table = mine / name / "measured.csv"
        table.write_text("\n".join(table.read_text().splitlines()[: lines + 1]) + "\n")
    with pytest.raises(StereoLabError, match="There are [0-9] measured pairs to fit on; [0-9] are needed"):
        Localizer.fit(open_recording(mine), leave_out=open_recording(mine).samples("position"))


def test_marks_that_are_beside_the_ball_are_told(tmp_path, capsys):
    """One mark lies on the wall: its line is named; where all are good nothing is said."""
    bench = open_recording("bench")
    lines = []
    for k, pair in enumerate(bench.pairs("position")[:4]):
        u, v, r = bench.true_ball("position", pair.name)["left"]
        lines.append(f"{pair.left_path},{u + 90 * (k == 2)},{v},{r}")
    for rows, says in ((lines, "at 1 of 4 of them"), (lines[:2], "")):
        (tmp_path / "balls.csv").write_text("\n".join(["file,u,v,radius_px", *rows]) + "\n")
        assert main(["detect", str(PICTURE), "--color-from", str(tmp_path / "balls.csv")]) == 0
        told = capsys.readouterr().err
        assert says in told and ("line 4" in told) == bool(says)


def test_a_colour_is_marked_or_marks_itself(tmp_path, capsys):
    assert "Choose one of the two" in refused(
        capsys, "detect", PICTURE, "--learn", "--color-from", tmp_path / "balls.csv"
    )


# --- names and formats -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", [7, ["bench"], "", "..", "../../x", "/etc", "a\\b", "C:x", "a\0b"])
def test_calibrated_by_is_a_plain_name(small, name):
    write_facts(small, calibrated_by=name)
    with pytest.raises(RecordingError, match="calibrated_by: expected a plain name"):
        open_recording(small)


@pytest.mark.parametrize("ring", [("small",), ("other", "small")])
def test_calibrated_by_leads_in_a_ring(small, capsys, ring):
    write_facts(small, calibrated_by=ring[0])
    if len(ring) == 2:
        (small.parent / "other").mkdir()
        write_facts(small.parent / "other", calibrated_by=ring[1])
    assert "leads in a ring" in refused(capsys, "calibrate", small)


@pytest.mark.parametrize("name", ["nobody", "bench"])  # a shipped one is found by its name, but lies elsewhere
def test_calibrated_by_names_nobody(small, capsys, name):
    write_facts(small, calibrated_by=name)
    says = (
        f"recording.json: calibrated_by names the recording {name}, and there is none in {small.parent / name}. Copy it"
    )
    assert says in refused(capsys, "calibrate", small)


@pytest.mark.parametrize(("code", "advice"), [
    (errno.ENOSPC, "Free some space"), (errno.EACCES, "Choose a folder that may be written to"),
    (errno.EROFS, "Choose a folder that may be written to"), (errno.EEXIST, "A file stands where a folder is needed"),
    (errno.EIO, "Choose another folder, or free some space"),
])  # fmt: skip
def test_what_to_do_hangs_on_why_nothing_can_be_written(tmp_path, monkeypatch, code, advice):
    def refuse(*_, **__):
        raise OSError(code, os.strerror(code))

    monkeypatch.setattr(tempfile, "mkstemp", refuse)
    with pytest.raises(StereoLabError, match=f"{os.strerror(code)}. {advice}"):
        write_whole(tmp_path / "a.json", "{}")
    monkeypatch.setattr(tempfile, "TemporaryDirectory", refuse)
    with pytest.raises(StereoLabError, match=f"{os.strerror(code)}. {advice}"), whole_folder(tmp_path / "b"):
        pass


def test_a_new_recording_does_not_take_the_name_of_another(tmp_path, monkeypatch, capsys):
    """Found first in one's own folder, it would hide the shipped one from every command."""
    monkeypatch.chdir(tmp_path)
    for name in ("bench", "bench/"):
        assert "Name another folder, such as my_bench" in refused(capsys, "record", name)
    told = refused(
        capsys, "import", "--left", "a*", "--right", "b*", "--board", "9x6", "--square-mm", "25", "--out", "bench"
    )
    assert "name of a recording that is there already" in told and not (tmp_path / "bench").exists()


def test_a_file_is_no_recording(tmp_path, capsys):
    (tmp_path / "bench.zip").write_bytes(b"PK")
    assert "is a file, and a recording is a folder" in refused(capsys, "check", tmp_path / "bench.zip")


@pytest.mark.parametrize("name", ["../small/position", "..", "/etc", "a\\b"])
def test_a_set_is_a_plain_name(small, name):
    with pytest.raises(RecordingError, match="set: expected a plain name"):
        open_recording(small).pairs(name)
    with pytest.raises(RecordingError, match="set: expected a plain name"):
        open_recording(small).samples(name)


@pytest.mark.parametrize("name", ["../left/000", "../../position/left/000", "/etc/passwd"])
def test_a_picture_in_a_table_is_one_of_the_set(small, name):
    write_table(small, f"{name},1,2,3,fit")
    with pytest.raises(RecordingError, match="line 2: there is no picture named"):
        open_recording(small).samples("position")


@pytest.mark.parametrize(("old", "new", "says"), [
    ("position", "Postion", "Should its name be position?"), ("position/left", "position/Left", "Should its name be left?"),
    ("position/right", "position/rigth", "Should its name be right?"),
    ("position/measured.csv", "position/measured.xlsx", "Save the table as measured.csv"),
    ("position/left/000.jpg", "position/left/000.HEIC", "pictures end in .jpg, .jpeg or .png"),
])  # fmt: skip
def test_what_lies_under_another_name_is_pointed_at(small, old, new, says):
    assert strays(small) == []
    (small / old).rename(small / new)
    if not (small / old).exists():  # where capitals count
        assert [str(small / new) in told and says in told for told in strays(small)] == [True]


def test_what_is_missing_is_looked_for_beside_it_first(small, capsys):
    """A table, boards that come before balls, and pictures of a folder that is named by itself."""
    (small / "calibration" / "left").mkdir(parents=True)
    (small / "calibration" / "left" / "000.webp").touch()
    for side in ("left", "right"):
        for picture in (small / "position" / side).iterdir():
            picture.rename(picture.with_suffix(".webp"))
    said = refused(capsys, "calibrate", small)
    assert (
        f"{small / 'calibration' / 'left'} holds no pictures" in said
        and f"{small / 'calibration' / 'left' / '000.webp'} is" in said
    )
    with pytest.raises(RecordingError, match=r"position.left.000\.webp is not read"):
        open_recording(small).pairs("position")
    assert "There is 000.webp: name these files themselves" in refused(capsys, "detect", small / "position" / "left")


def test_a_table_of_another_kind_is_told_in_python_too(small):
    (small / "position" / "measured.csv").rename(small / "position" / "measured.xlsx")
    with pytest.raises(RecordingError, match=r"is missing\. .*measured\.xlsx is not read"):
        open_recording(small).samples("position")


def test_both_halves_that_are_missing_are_told_at_once(small):
    pictures = small / "position"
    for name in ("007", "008"):
        for side in ("left", "right"):
            shutil.copy(pictures / "left" / "000.jpg", pictures / side / f"{name}.jpg")
    (pictures / "left" / "007.jpg").unlink(), (pictures / "right" / "008.jpg").unlink()
    with pytest.raises(RecordingError, match=r"left has no picture 007\.jpg, and .*right has no picture 008\.jpg"):
        open_recording(small).pairs("position")


def test_names_of_ones_own_are_left_alone(small):
    """Sets that nobody knows, notes beside the pictures, a second table, a folder of anything."""
    shutil.copytree(small / "position", small / "red")
    shutil.copytree(small / "position", small / "position 2")
    (small / "Depth").mkdir()
    (small / "position" / "measured.xlsx").touch(), (small / "position" / "notes.txt").touch()
    (small / "position" / "rejected").mkdir(), (small / "position" / "left" / "Thumbs.db").touch()
    assert strays(small) == []


def test_a_set_that_is_missing_is_looked_for_under_other_names(small, capsys):
    (small / "position").rename(small / "calibratoin")
    assert "Should its name be calibration?" in refused(capsys, "calibrate", small)
    with pytest.raises(RecordingError, match="Should its name be calibration"):
        open_recording(small).pairs("calibration")


@pytest.mark.skipif(os.name == "nt", reason="links need rights there")
def test_a_set_may_be_a_link(small, tmp_path):
    (small / "position").rename(tmp_path / "elsewhere")
    (small / "position").symlink_to(tmp_path / "elsewhere")
    assert len(open_recording(small).samples("position")) == 1


@pytest.mark.parametrize(
    ("number", "says"),
    [(2, "newer kit"), ("1", 'expected "format": 1'), (True, 'expected "format": 1'), (0, "expected")],
)
def test_a_format_that_is_not_known(small, number, says):
    write_facts(small, format=number)
    with pytest.raises(RecordingError, match=says):
        open_recording(small)


def test_a_format_that_is_missing(small):
    (small / "recording.json").write_text(json.dumps({k: v for k, v in FACTS.items() if k != "format"}))
    with pytest.raises(RecordingError, match='Add "format": 1'):
        open_recording(small)


@pytest.mark.parametrize(
    ("truth", "says"),
    [
        ({"format": 2}, "newer kit"),
        ({"sets": []}, "expected an object"),
        ({"sets": {"position": {"000": 5}}}, "expected an object"),
        ({"sets": {"position": {"000": {"ball": 5}}}}, "expected three numbers"),
        ({"sets": {"position": {"000": {"ball": [1, 2, 1e300]}}}}, "ball: expected a number from"),
        ({"sets": {"position": {"000": {"ball": None, "left": [1, "x", 2]}}}}, "left: expected a number"),
    ],
)
def test_a_truth_that_is_none(small, truth, says):
    (small / "truth.json").write_text(json.dumps(truth))
    with pytest.raises(RecordingError, match=says):
        open_recording(small)


@pytest.mark.parametrize("name", ["recording.json", "truth.json"])
def test_brackets_within_brackets(small, capsys, name):
    (small / name).write_text('{"a":' * 200_000 + "1" + "}" * 200_000)
    assert "nested too deep" in refused(capsys, "calibrate", small)


def test_a_number_of_ten_thousand_digits(small):
    (small / "recording.json").write_text(f'{{"format": 1, "frame_rate": {"9" * 10_000}}}')
    with pytest.raises(RecordingError, match="recording.json"):
        open_recording(small)


# --- words as people write them ------------------------------------------------------------------------------------


@pytest.mark.parametrize("quote", ["'", '"'])
def test_quotes_that_the_windows_prompt_leaves(small, tmp_path, quote):
    half = lambda side: f"{quote}{small / 'position' / side / '*.jpg'}{quote}"
    made = import_images(half("left"), half("right"), Board(9, 6, 25.0), tmp_path / "out")
    assert len(made.pairs("calibration")) == 1


def test_colours_in_capitals(small, tmp_path, capsys):
    write_facts(small, ball={"color": " Red", "diameter_mm": 40})
    assert open_recording(small).ball.color == "red"
    assert BallColor.named("Red ").name == "red" == BallDetector("RED").color.name
    assert main(["detect", str(PICTURE), "--color", " Red"]) == 0
    left, right = (str(small / "position" / side / "*.jpg") for side in ("left", "right"))
    made = import_images(left, right, Board(9, 6, 25.0), tmp_path / "out", Ball("Green", 40.0))
    assert made.ball.color == "green"


@pytest.mark.parametrize("name", ["", "pink", None, [], 3])
def test_colours_that_are_none(name):
    with pytest.raises(StereoLabError, match="no colour"):
        BallColor.named(name)


# --- output that nobody takes --------------------------------------------------------------------------------------


def detect_into(output, *more):
    """Run ``detect`` with this as its standard output: (exit code, errors)."""
    command = [sys.executable, "-m", "stereo_lab", "detect", str(PICTURE), *more]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    done = subprocess.run(command, stdout=output, stderr=subprocess.PIPE, text=True, cwd=ROOT, env=environment)
    return done.returncode, done.stderr


def test_the_home_folder_is_understood_where_no_shell_puts_it(bench, tmp_path, capsys, monkeypatch):
    for variable in ("HOME", "USERPROFILE"):
        monkeypatch.setenv(variable, str(tmp_path))
    monkeypatch.chdir(tmp_path)
    shutil.copytree(bench.path / "calibration", tmp_path / "mine" / "calibration")
    for name in ("recording.json", "calibration.json"):
        shutil.copy(bench.path / name, tmp_path / "mine")
    assert open_recording("~/mine").path == (tmp_path / "mine").resolve()
    assert main(["export", "~/mine", "--out=~/there"]) == 0
    assert (tmp_path / "there" / "stereo.yml").is_file() and not (tmp_path / "~").exists()


def test_a_table_in_utf_16_is_told(tmp_path):
    (tmp_path / "measured.csv").write_bytes("name,x_mm\n".encode("utf-16"))
    with pytest.raises(StereoLabError, match="it is UTF-16, .*Save it as UTF-8"):
        read_text(tmp_path / "measured.csv")


@pytest.mark.skipif(os.name == "nt", reason="a closed pipe looks otherwise there")
@pytest.mark.parametrize("unbuffered", ["", "1"])
@pytest.mark.parametrize("more", [(), ("--json", "-")])
def test_a_closed_pipe(monkeypatch, more, unbuffered):
    monkeypatch.setenv("PYTHONUNBUFFERED", unbuffered)
    reader, writer = os.pipe()
    os.close(reader)
    code, said = detect_into(writer, *more)
    os.close(writer)
    *words, last = said.splitlines()
    assert code == 2 and last.startswith("stereo-lab: Cannot print: ") and len(words) == bool(more)


@pytest.mark.parametrize("arguments", [("detect", "text.mp4"), ("run", "--source", "cameras:97,98", "--seconds", "1")])
def test_what_does_not_open_is_told_in_one_line(tmp_path, arguments):
    """OpenCV and FFmpeg would tell it before, in theirs. They are asked to be quiet before they are loaded."""
    (tmp_path / "text.mp4").write_text("no video")
    command = [sys.executable, "-m", "stereo_lab", *arguments]
    done = subprocess.run(
        command, cwd=tmp_path, capture_output=True, text=True, env=os.environ | {"PYTHONPATH": str(ROOT)}
    )
    assert done.returncode == 2 and done.stdout == ""
    assert done.stderr.startswith("stereo-lab: ") and done.stderr.count("\n") == 1


def test_json_to_a_folder(tmp_path, capsys):
    assert "it is a folder" in refused(capsys, "detect", PICTURE, "--json", tmp_path)


@no_pipes
def test_json_to_what_is_no_plain_file(tmp_path, capsys):
    """A pipe stands for every device: a real one would be lost for the whole computer if this failed."""
    os.mkfifo(tmp_path / "pipe")
    assert "it is a pipe" in refused(capsys, "detect", PICTURE, "--json", tmp_path / "pipe")
    assert [p.name for p in tmp_path.iterdir()] == ["pipe"] and (tmp_path / "pipe").is_fifo()


def test_json_where_no_folder_can_be(tmp_path, capsys):
    (tmp_path / "file").touch()
    assert "Cannot write" in refused(capsys, "detect", PICTURE, "--json", tmp_path / "file" / "d.json")
    assert "Cannot write" in refused(capsys, "detect", PICTURE, "--json", tmp_path / "a\0b.json")


@pytest.mark.parametrize("step", ["fsync", "replace", "chmod"])
def test_a_full_disk_leaves_the_old_file(tmp_path, capsys, monkeypatch, step):
    def full(*_):
        raise OSError(28, "No space left on device")

    (tmp_path / "d.json").write_text("old")
    monkeypatch.setattr(os, step, full)
    assert "No space left" in refused(capsys, "detect", PICTURE, "--json", tmp_path / "d.json")
    assert [p.read_text() for p in tmp_path.iterdir()] == ["old"]


@pytest.mark.skipif(os.name == "nt", reason="links need rights there")
def test_a_link_stays_a_link(tmp_path):
    (tmp_path / "file").write_text("old")
    (tmp_path / "link").symlink_to(tmp_path / "file")
    write_whole(tmp_path / "link", "new")
    assert (tmp_path / "link").is_symlink() and (tmp_path / "file").read_text() == "new"


# --- a home that cannot be used --------------------------------------------------------------------------------------


@pytest.mark.parametrize("home", ["file", "file/home"])
def test_a_home_that_cannot_be_written(tmp_path, monkeypatch, bench_calibration, home):
    """Its parent is a plain file: nobody, root neither, can write there."""
    (tmp_path / "file").touch()
    monkeypatch.setenv("STEREO_LAB_HOME", str(tmp_path / home))
    monkeypatch.setattr(store, "calibrate_stereo", lambda *_: bench_calibration)
    recording = open_recording("bench")
    assert store.calibrate_anew(recording).verdict == "good"
    assert store.find_calibration(recording)[1] == store.BROUGHT
    assert progress.passed("00", 1) == 1 and progress.load() == {}


@pytest.mark.parametrize(
    "content", ["[" * 200_000, '{"00": 5}', '{"00": [[1]]}', '{"00": ["x", null]}', "[]", "\xff", ""]
)
def test_a_spoilt_progress_file(tmp_path, monkeypatch, content):
    monkeypatch.setenv("STEREO_LAB_HOME", str(tmp_path))
    (tmp_path / "progress.json").write_text(content, encoding="latin-1")
    assert progress.passed("00", 2) == 1
    assert progress.load() == {"00": [2]}


# --- one thread --------------------------------------------------------------------------------------------------------


@pytest.fixture
def three_threads():
    before = cv2.getNumThreads()
    cv2.setNumThreads(3)
    yield
    cv2.setNumThreads(before)


def test_one_thread_within_one_thread(three_threads):
    with one_thread():
        with one_thread():
            assert cv2.getNumThreads() == 1
        assert cv2.getNumThreads() == 1
    assert cv2.getNumThreads() == 3


def test_one_thread_from_two_threads(three_threads):
    """The first one in leaves before the last one does."""
    inside, leave = threading.Event(), threading.Event()

    def second():
        with one_thread():
            inside.set()
            leave.wait()

    other = threading.Thread(target=second)
    with one_thread():
        other.start()
        inside.wait()
    assert cv2.getNumThreads() == 1
    leave.set()
    other.join()
    assert cv2.getNumThreads() == 3


def test_one_thread_is_left_by_an_error(three_threads):
    with pytest.raises(ValueError), one_thread():
        raise ValueError
    assert cv2.getNumThreads() == 3


# --- rendering without its library -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("{", "not valid JSON"),
        ("[]", "in braces"),
        ("{}", "'recording'"),
        ('{"recording": 3}', "cannot be used as a rig"),
    ],
)
def test_a_rig_file_that_is_none(tmp_path, monkeypatch, text, says):
    monkeypatch.syspath_prepend(ROOT / "data" / "render")
    path = tmp_path / "mine.json"
    path.write_text(text)
    with pytest.raises(StereoLabError, match=says):
        importlib.import_module("rig").load_rig(path)


def test_a_rig_says_only_what_differs_from_another(monkeypatch):
    monkeypatch.syspath_prepend(ROOT / "data" / "render")
    rig = importlib.import_module("rig")
    clutter, even = rig.load_rig("clutter"), rig.load_rig(ROOT / "data" / "train" / "clutter_even.json")
    assert even.recording == {**clutter.recording, "title": even.recording["title"]} and even.sets == clutter.sets
    assert even.room["props"] == clutter.room["props"] and set(even.room["lights"]) != set(clutter.room["lights"])
    assert (clutter.ball_gloss, even.ball_gloss) == (0.65, 0) and even.seed != clutter.seed


def test_a_decimal_comma_is_no_new_column(tmp_path):
    table = tmp_path / "t.csv"
    table.write_text("name,x_mm,y_mm\n000,1,2,\n001,115,5,1000\n")
    with pytest.raises(RecordingError, match="line 3 has 4 fields, expected 3. A decimal comma"):
        read_table(table, ("name", "x_mm"))
    table.write_text("name;x_mm;y_mm\n000;115,5;1000\n")
    assert read_table(table, ("name", "x_mm"))[0][1]["x_mm"] == "115.5"


@pytest.mark.parametrize("word", ["fits", "test"])
def test_what_a_measured_pair_is_for_is_one_of_two_words(tmp_path, word):
    shutil.copytree(ROOT / "data" / "third_rig", tmp_path / "mine")
    table = tmp_path / "mine" / "depth" / "measured.csv"
    table.write_text(table.read_text().replace("check", word))
    with pytest.raises(RecordingError, match=f"use: expected fit or check, or nothing; got '{word}'"):
        open_recording(tmp_path / "mine").samples("depth")


@pytest.fixture
def record(monkeypatch):
    """data/render/record.py without the renderer itself, which is an extra."""
    monkeypatch.syspath_prepend(ROOT / "data" / "render")
    monkeypatch.setitem(sys.modules, "optics", SimpleNamespace(mi=None))
    module = importlib.import_module("record")
    monkeypatch.setattr(module, "Studio", lambda rig: None)
    yield module
    for name in ("record", "scene", "clutter"):  # they know no renderer now
        del sys.modules[name]


@pytest.mark.parametrize("truth", [(ROOT / "data" / "third_rig" / "truth.json").read_text(), "{}"])
def test_pictures_are_not_kept_with_a_truth_that_is_not_theirs(tmp_path, record, truth):
    there = tmp_path / "truth.json"
    there.write_text(truth)
    with pytest.raises(StereoLabError, match="another seed or rig.*--out"):
        record.record("third_rig", tmp_path, seed=7)
    assert there.read_text() == truth and list(tmp_path.iterdir()) == [there]


def test_a_recording_of_cameras_is_not_rendered_over(tmp_path, record):
    there = tmp_path / "recording.json"
    there.write_text('{"format": 1, "made_by": "camera"}')
    with pytest.raises(StereoLabError, match="not rendered.*--out"):
        record.record("third_rig", tmp_path, seed=7)
    assert list(tmp_path.iterdir()) == [there]


def test_a_recording_that_was_broken_off_is_gone_on_with(tmp_path, record, monkeypatch):
    monkeypatch.setattr(record, "_path", lambda out, *_: out)  # none of its pictures is missing
    shutil.copy(ROOT / "data" / "third_rig" / "truth.json", tmp_path)
    record.record("third_rig", tmp_path)
    assert (tmp_path / "recording.json").exists()


@pytest.fixture
def llvm(monkeypatch):
    """data/render/llvm.py; the renderer itself is not needed for it."""
    monkeypatch.syspath_prepend(str(ROOT / "data" / "render"))
    return importlib.import_module("llvm")


def modules(found, error=None, version=19):
    """What stands for drjit and mitsuba: a computer where LLVM is found, or not."""
    drjit = SimpleNamespace(
        JitBackend=SimpleNamespace(LLVM="llvm"),
        has_backend=lambda backend: found,
        detail=SimpleNamespace(llvm_version=lambda: (version, 0, 0)),
    )
    chosen = []

    def set_variant(name):
        if error:
            raise error
        chosen.append(name)

    return drjit, SimpleNamespace(set_variant=set_variant, chosen=chosen)


def test_rendering_with_llvm(llvm):
    drjit, mitsuba = modules(found=True)
    llvm.start(drjit, mitsuba)
    assert mitsuba.chosen == ["llvm_ad_rgb"]


@pytest.mark.parametrize(("found", "error"), [(False, None), (True, ImportError("the LLVM backend is inactive"))])
def test_rendering_without_llvm(llvm, found, error):
    with pytest.raises(StereoLabError, match="apt install libllvm19.*DRJIT_LIBLLVM_PATH"):
        llvm.start(*modules(found, error))


def test_rendering_with_an_llvm_that_is_too_old(llvm):
    with pytest.raises(StereoLabError, match="16 or newer, and 15 was found"):
        llvm.start(*modules(found=True, version=15))


def test_where_llvm_is_looked_for(llvm, tmp_path):
    (tmp_path / "arch").mkdir()
    library = tmp_path / "arch" / "libLLVM.so.19.1"
    library.touch()
    environment = {}
    llvm.point_to_llvm(environment, tmp_path / "arch")
    assert environment == {}
    llvm.point_to_llvm(environment, tmp_path)
    assert environment == {"DRJIT_LIBLLVM_PATH": str(library)}
    with pytest.raises(StereoLabError, match="no such file"):
        llvm.point_to_llvm({"DRJIT_LIBLLVM_PATH": str(tmp_path / "gone")}, tmp_path)


def test_render_says_what_is_missing(tmp_path, monkeypatch, capsys):
    """Whatever is installed here: a library named wrongly is told before Mitsuba is imported."""
    for name in ("record", "optics", "llvm"):
        monkeypatch.delitem(sys.modules, name, raising=False)
    monkeypatch.setattr(sys, "path", list(sys.path))
    monkeypatch.setenv("DRJIT_LIBLLVM_PATH", str(tmp_path / "gone"))
    said = refused(capsys, "render", "bench", "--out", tmp_path / "out")
    assert "DRJIT_LIBLLVM_PATH" in said or "mitsuba" in said
    assert list(tmp_path.iterdir()) == []


def test_a_name_that_is_no_text_is_written_as_an_escape(tmp_path):
    write_whole(tmp_path / "a.json", json.dumps({"file": "Zo\udceb.jpg"}, ensure_ascii=False))
    assert read_json(tmp_path / "a.json") == {"file": "Zo\udceb.jpg"}


@pytest.mark.skipif(os.name == "nt", reason="Windows knows no such rights")
def test_a_file_keeps_its_rights(tmp_path):
    mine = tmp_path / "mine"
    mine.write_text("a")
    mine.chmod(0o600)
    write_whole(mine, "b")
    assert mine.stat().st_mode & 0o777 == 0o600 and mine.read_text() == "b"


def test_commas_of_a_table_with_semicolons(tmp_path):
    table = tmp_path / "a.csv"
    table.write_text('name;x\n"ball, left";1,5\n"two\nlines";-2,25\n', encoding="utf-8")
    rows = [row for _, row in read_table(table, ("name", "x"))]
    assert rows == [{"name": "ball, left", "x": "1.5"}, {"name": "two\nlines", "x": "-2.25"}]


@pytest.mark.parametrize(
    ("call", "says"),
    [
        (lambda c: c.rectify_points(np.zeros((3, 3)), "left"), "2 numbers each"),
        (lambda c: c.rectify_points(np.arange(6.0).reshape(2, 3), "left"), "2 numbers each"),
        (lambda c: c.rectify_points([[1, 2]], "middle"), '"left" or "right"'),
        (lambda c: c.rectify_points([["a", "b"]], "left"), "no numbers"),
        (lambda c: c.triangulate(np.zeros((2, 2)), np.zeros((1, 2))), "got 2 and 1"),
        (lambda c: c.triangulate(np.zeros((2, 3)), np.zeros((2, 3))), "2 numbers each"),
        (lambda c: c.sigma_mm(np.zeros((3, 2))), "3 numbers each"),
    ],
)  # fmt: skip
def test_points_of_another_shape(bench_calibration, call, says):
    with pytest.raises(StereoLabError, match=says):
        call(bench_calibration)


def test_one_point_alone_and_none_at_all(bench_calibration):
    one = bench_calibration.rectify_points((320, 240), "left")
    assert one.shape == (1, 2) and bench_calibration.rectify_points([], "left").shape == (0, 2)


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["run", "--touch", "--arm", "virtual://arm", "--seconds", "2"], "Choose one"),
        (["board", "board.png"], "ends in .pdf"), (["detect", "nothing*.jpg"], "No file matches"),
        (["board", "b.pdf", "--square-mm", "2,5"], "--square-mm: expected a number with a decimal point, as in 2.5, got '2,5'"),
        (["board", "b.pdf", "--marker-mm", "15"], "--marker-mm is of a ChArUco board: add --charuco"),
        (["record", "mine", "--dictionary", "DICT_5X5_50"], "--dictionary is of a ChArUco board"),
        (["board", "b.pdf", "--sheets", "2"], "--sheets is of marks: add --marks"),
        (["board", "b.pdf", "--sheets", "0"], "--sheets is of marks: add --marks"),
        (["board", "b.pdf", "--marks", "--columns", "8"], "--columns is of a board, and --marks prints none"),
        (["calibrate", "bench", "--json", "numbers.txt"], "--json: expected a name that ends in .json, got numbers.txt"),
        (["check", "bench", "--report", "bench.json"], "--report: expected a name that ends in .html or .htm"),
        (["grade", "handed_in", "--csv", "class.xlsx"], "--csv: expected a name that ends in .csv"),
        (["run", "--recording", "nowhere", "--seconds", "2"], "There is no folder nowhere"),
        (["record", "mine", "--set", "depth", "--seconds", "2"], "typed places end with an empty line"),
        (["train", "clutter", "--out", "ball.txt"], "--out: expected a name that ends in .json"),
        (["train", "clutter", "--out", "b.json", "--json", "./b.json"], "--json and --out both name b.json"),
        (["calibrate", "bench", "--save", "s.json", "--json", "s.json"], "--json and --save both name s.json"),
    ],
)  # fmt: skip
def test_words_of_the_command_line_that_do_not_fit(words, says, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(words) == 2 and says in capsys.readouterr().err and not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("words", "name"),
    [
        (["calibrate", "bench", "--json"], "recording.json"),
        (["train", "clutter", "--out"], "recording.json"),
        (["log", "run.jsonl", "--csv"], "position/measured.csv"),
    ],
)
def test_no_output_takes_the_place_of_a_recordings_file(words, name, small, capsys):
    before = (small / name).read_bytes()
    assert main([*words, str(small / name)]) == 2
    assert f"belongs to the recording {small}" in capsys.readouterr().err and (small / name).read_bytes() == before


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["--rate", "10,5"], "expected a number with a decimal point, as in 10.5, got 10,5"),
        (["--seconds", "nan"], "expected a number of seconds above 0, got nan"),
        (["--seconds", "0"], "expected a number of seconds above 0, got 0"),
    ],
)
def test_numbers_that_are_none(words, says, capsys):
    with pytest.raises(SystemExit):
        main(["run", *words])
    assert says in capsys.readouterr().err


def test_the_virtual_bench_is_that_of_the_recording_named(tmp_path):
    assert main(["run", "--recording", "second_rig", "--seconds", "1", "--log", str(tmp_path / "run.jsonl")]) == 0
    assert json.loads((tmp_path / "run.jsonl").read_text().splitlines()[0])["fitted_on"] == "second_rig"


def test_detect_takes_patterns_and_folders(bench, capsys):
    folder = bench.path / "snaps" / "left"
    assert main(["detect", str(folder / "00*.jpg")]) == 0
    by_pattern = capsys.readouterr().out.splitlines()
    assert main(["detect", str(folder)]) == 0
    by_folder = capsys.readouterr().out.splitlines()
    assert len(by_pattern) == 10 and by_pattern == by_folder[:10] and len(by_folder) == len(list(folder.iterdir()))


def test_a_picture_that_cannot_be_read_does_not_hide_the_others(bench, tmp_path, capsys):
    good, bad = bench.pairs("snaps")[0].left_path, tmp_path / "cut.jpg"
    bad.write_bytes(good.read_bytes()[:3000])
    film = tmp_path / "text.mp4"
    film.write_text("no film")
    words = [str(film), str(bad), str(good), str(tmp_path / "nothere.png")]
    assert main(["detect", *words, "--json", str(tmp_path / "found.json")]) == 2
    told = capsys.readouterr()
    assert all(name in told.err for name in ("cut.jpg", "text.mp4", "nothere.png")) and "u 1" in told.out
    rows = json.loads((tmp_path / "found.json").read_text())
    assert [row["file"] for row in rows] == [str(good)]


def test_samples_that_no_depth_follows():
    with pytest.raises(StereoLabError, match="No curve"):
        OffsetDepth.fit([10, 20, 30, 40], [1000, 1100, 900, 1200])


def test_the_paper_has_no_candidates(bench):
    image = bench.pairs("snaps")[0].left
    paper = BallDetector("red", "paper")
    assert paper.first(image) == paper.detect(image)
    for asks in (paper.candidates, paper.detect_all, paper.weighed):
        with pytest.raises(StereoLabError, match="no candidates"):
            asks(image)


def test_a_name_in_the_place_of_a_recording():
    for asks in (
        Localizer.fit, lambda name: questions("04", name), calibrate_recording, calibrate_anew,
        lambda name: open_source("virtual", recording=name), lambda name: Follower(SimpleNamespace(homed=True), name),
    ):  # fmt: skip
        with pytest.raises(StereoLabError, match="as open_recording gives it"):
            asks("bench")
    with pytest.raises(StereoLabError, match="as open_recording gives it; got None"):
        Localizer.fit(None)


@pytest.mark.parametrize(
    ("call", "says"),
    [
        (lambda r: calibrate_stereo(r.board, r.pairs("calibration")), "Expected pairs first, .* then the board; got Board"),
        (lambda r: calibrate_stereo(r, r.board), "Expected pairs first, .* got Recording"),
        (lambda r: calibrate_stereo("bench", r.board), "Expected pairs first, .* got 'bench'"),
        (lambda r: calibrate_stereo([1, 2], r.board), r"Expected pairs first, .* got \[1, 2\]"),
        (lambda r: calibrate_stereo([], None), "Expected a board"),
        (lambda r: Localizer.fit(r, calibration="x"), "Expected a calibration, as calibrate_stereo .* got 'x'"),
        (lambda r: calibrate_recording(r).rectify_centers((1, 2), (3, 4)), r"two detections, .* got \(\(1, 2\), \(3, 4\)\). Bare"),
        (lambda r: Follower(r, SimpleNamespace(homed=True)), "Expected an arm, as connect gives it; got Recording"),
        (lambda r: next(run(r, open_source("bench"))), "Expected a source of pictures first, .* got Recording"),
        (lambda r: open_source("bench", rate_hz="30"), "a number of pairs a second; got '30'"),
        (lambda r: import_images(str(r.path / "still" / "left"), str(r.path / "still" / "right"), (9, 6), "new"), "Expected a board"),
        (lambda r: r.arm.forward(JointAngles(None, 3)), "angles in degrees as numbers; got JointAngles"),
    ],
)  # fmt: skip
def test_what_stands_in_the_place_of_another_thing(bench, call, says):
    with pytest.raises(StereoLabError, match=says):
        call(bench)


@pytest.mark.parametrize("path", [0, 1, "", ("bench",)])
def test_what_is_no_path_is_not_taken_for_the_shipped_bench(path):
    with pytest.raises(RecordingError, match="Expected a recording's folder or its name"):
        open_recording(path)


def test_a_recording_by_its_file_and_a_table_by_hand(bench, tmp_path):
    shutil.copytree(bench.path / "depth", tmp_path / "mine" / "depth")
    shutil.copy(bench.path / "recording.json", tmp_path / "mine")
    table = tmp_path / "mine" / "depth" / "measured.csv"
    told = [s.use for s in open_recording(tmp_path / "mine").samples("depth")]
    lines = table.read_text(encoding="utf-8").replace("fit", "Fit ").splitlines()
    table.write_text("\n".join([lines[0], *(line.replace(",", ".jpg,", 1) for line in lines[1:])]), encoding="utf-8")
    samples = open_recording(tmp_path / "mine" / "recording.json").samples("depth")
    assert [s.use for s in samples] == told and "fit" in told


def test_a_column_that_is_there_twice_is_told(tmp_path):
    table = tmp_path / "measured.csv"
    table.write_text("name,x_mm,y_mm,x_mm\n000,1,2,9\n")
    with pytest.raises(RecordingError, match="the column x_mm is there more than once"):
        read_table(table, ("name", "x_mm", "y_mm"))


def test_a_file_that_may_not_be_written_is_left_alone(tmp_path, monkeypatch):
    """A new one in its place would need no leave."""
    path = tmp_path / "kept.json"
    write_whole(path, "old")
    monkeypatch.setattr(os, "access", lambda *_: False)
    with pytest.raises(StereoLabError, match="may not be written to"):
        write_whole(path, "new")
    assert path.read_text() == "old" and list(tmp_path.iterdir()) == [path]


@pytest.mark.skipif(os.name == "nt", reason="links need a privilege there")
def test_a_link_to_an_empty_folder_is_filled(tmp_path):
    (tmp_path / "far").mkdir()
    (tmp_path / "near").symlink_to(tmp_path / "far")
    with whole_folder(tmp_path / "near") as made:
        made.mkdir()
        (made / "it.txt").write_text("x")
    assert (tmp_path / "far" / "it.txt").exists() and (tmp_path / "near").is_symlink()


@pytest.mark.parametrize(
    ("path", "words"), [("data/mine", "data/mine"), ("my rig", '"my rig"'), ("rig(1)", '"rig(1)"'), ("C:\\rigs\\é", "C:\\rigs\\é")]
)  # fmt: skip
def test_a_path_in_a_command_can_be_typed(path, words):
    assert typed(path) == words


@pytest.mark.parametrize("words", [("arm", "list"), ("arm", "torque"), ("arm", "virtual://arm"), ("places",)])
def test_with_json_the_terminal_shows_json_alone(capsys, words):
    assert main([*words, "--json", "-"]) == 0
    json.loads(capsys.readouterr().out)


def test_one_camera_is_no_pair():
    with pytest.raises(StereoLabError, match="Expected two cameras, got number 0 for both"):
        CameraPair(0, 0, (640, 480))


BOARDS = Board(9, 6, 25.0), Board(8, 6, 25.0, "charuco", 18.75, "DICT_4X4_50")
GREY = np.full((48, 64, 3), 127, np.uint8)


@pytest.mark.parametrize("board", BOARDS, ids=lambda board: board.kind)
@pytest.mark.parametrize(
    "image",
    [
        None, GREY.astype(np.float32), GREY / 255, GREY.astype(np.uint16), GREY > 100, GREY[..., :1], GREY[:0], GREY[:0, :, 0],
        GREY[..., 0] / 255, "board.jpg",
    ],
    ids=["none", "float32", "float64", "uint16", "bool", "one_channel", "empty", "empty_grey", "grey_float", "name"],
)  # fmt: skip
def test_corners_are_looked_for_in_a_picture(board, image):
    with pytest.raises(StereoLabError, match="Expected a picture of shape .* and type uint8; (got|there is none)"):
        find_corners(image, board)


@pytest.mark.parametrize("size", [(9, 6), 9, None])
def test_a_size_in_the_place_of_a_board(bench, size):
    pairs = bench.pairs("calibration")[:4]
    for asks in (lambda: find_corners(GREY, size), lambda: calibrate_stereo(pairs, size)):
        with pytest.raises(StereoLabError, match=r"Expected a board, as in Board\(9, 6, 25.0\)"):
            asks()


@pytest.mark.parametrize("board", BOARDS, ids=lambda board: board.kind)
@pytest.mark.parametrize(("height", "width"), [(5, 5), (1, 1), (8, 640), (640, 12), (16, 16)])
def test_a_picture_too_small_for_a_board_shows_none(board, height, width):
    assert find_corners(np.full((height, width, 3), 127, np.uint8), board) is None
    assert find_corners(np.full((height, width), 127, np.uint8), board) is None


SQUARE = np.array([[0.0, 0], [100, 0], [100, 100], [0, 100]])
SLANT = np.arange(5.0)[:, None] * [30.0, 20.0]
CLOUD = np.array([[10.0, 20], [200, 40], [90, 300], [260, 210], [120, 150]])


@pytest.mark.parametrize(
    ("board", "pixels", "says"),
    [
        (SQUARE, SQUARE * np.nan, "A point on the picture is not two finite numbers"),
        (SQUARE + [np.inf, 0], SQUARE, "A point on the board is not two finite numbers"),
        (SQUARE * 0, SQUARE, "All points on the board lie on one line"),
        (SLANT, CLOUD, "All points on the board lie on one line"),
        (SLANT.astype(np.float32) / 3, CLOUD, "All points on the board lie on one line"),
        (CLOUD, SLANT, "All points on the picture lie on one line"),
        (SQUARE[[0, 1, 2, 2]], SQUARE, "All points but one lie on one line"),
        (SQUARE, np.vstack([SLANT[:3], [[0, 90]]]), "All points but one lie on one line"),
        (np.vstack([SLANT, [[0, 90]]]), np.vstack([SLANT, [[0, 90]]]), "All points but one lie on one line"),
        ([["a", "b"]] * 4, SQUARE, "these are no numbers"),
        (np.ones((4, 3)), np.ones((4, 3)), "Expected points of 2 numbers each"),
        (SQUARE[:3], SQUARE[:3], "needs four points or more"),
    ],
)
def test_points_that_no_homography_follows_from(board, pixels, says):
    with pytest.raises(StereoLabError, match=says):
        find_homography(board, pixels)


def test_a_board_seen_nearly_from_its_edge_still_has_a_homography():
    board = np.array([[x, y] for y in range(6) for x in range(9)]) * 25.0
    pixels = np.column_stack([320 + board[:, 0], 240 + 0.001 * board[:, 1]])
    assert find_homography(board, pixels)[0, 0] == pytest.approx(1.0)

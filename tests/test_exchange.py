"""Calibrations given away and taken over: by other programs' rules, not by our own reader alone."""

import json
import re
import shutil
from dataclasses import replace

import cv2
import numpy as np
import pytest
import yaml

from stereo_lab import cli
from stereo_lab.calibration import calibrate_recording
from stereo_lab.capture import export_calibration, import_calibration
from stereo_lab.capture.exchange import recording_of
from stereo_lab.doctor import check_recording
from stereo_lab.errors import CalibrationError
from stereo_lab.localization import Localizer
from stereo_lab.recording import Ball, open_recording

FIELDS = "left_matrix", "left_distortion", "right_matrix", "right_distortion", "rotation", "translation_mm"


@pytest.fixture(scope="module")
def calibration(bench):
    return calibrate_recording(bench)


@pytest.fixture
def files(calibration, tmp_path):
    return export_calibration(calibration, tmp_path / "out", "bench")


def same(one, other, rtol):
    assert one.image_size == other.image_size
    for field in FIELDS:
        assert np.allclose(getattr(one, field), getattr(other, field), rtol=rtol, atol=rtol), field


def test_there_and_back(calibration, files):
    same(import_calibration(files[:1]), calibration, 1e-12)
    for order in (files[1:], files[:0:-1]):  # whichever is named first
        same(import_calibration(order), calibration, 1e-6)


def test_opencv_sees_the_same_place_with_what_stands_in_the_file(calibration, files):
    file = cv2.FileStorage(str(files[0]), cv2.FILE_STORAGE_READ)
    value = lambda name: file.getNode(name).mat()
    place = np.array([[60.0, -40.0, 900.0]])
    seen = [
        cv2.projectPoints(place, cv2.Rodrigues(turn)[0], shift, value(f"M{k}"), value(f"D{k}"))[0]
        for k, turn, shift in ((1, np.eye(3), np.zeros(3)), (2, value("R"), value("T")))
    ]
    flat = [
        cv2.undistortPoints(p, value(f"M{k}"), value(f"D{k}"), R=value(f"R{k}"), P=value(f"P{k}"))
        for k, p in enumerate(seen, 1)
    ]
    found = cv2.triangulatePoints(value("P1"), value("P2"), flat[0].reshape(2, 1), flat[1].reshape(2, 1))
    assert np.allclose(value("R1") @ place[0], (found[:3] / found[3]).ravel(), atol=0.01)


def test_ros_gets_metres_and_a_disparity_that_fits(calibration, files):
    left, right = (yaml.safe_load(file.read_text()) for file in files[1:])
    table = lambda camera, name: np.array(camera[name]["data"]).reshape(camera[name]["rows"], camera[name]["cols"])
    p_left, p_right = (table(camera, "projection_matrix") for camera in (left, right))
    assert (
        left["image_width"] == 640 and left["camera_name"] == "bench/left" and right["distortion_model"] == "plumb_bob"
    )
    assert -p_right[0, 3] / p_right[0, 0] == pytest.approx(calibration.baseline_mm / 1000)
    point = np.array([0.05, 0.02, 1.1, 1])  # in the rectified left frame, metres
    u_left, u_right = ((p @ point)[0] / (p @ point)[2] for p in (p_left, p_right))
    assert u_left - u_right == pytest.approx(calibration.focal_px * calibration.baseline_mm / 1100)


def two_files(folder, calibration, names, scale):
    """As OpenCV's example writes them: one file for the cameras, one for how they stand; and a size added by hand."""
    m1, d1, m2, d2, r, t = names
    cameras = cv2.FileStorage(str(folder / "intrinsics.yml"), cv2.FILE_STORAGE_WRITE)
    for name, value in (
        (m1, calibration.left_matrix),
        (d1, calibration.left_distortion),
        (m2, calibration.right_matrix),
    ):
        cameras.write(name, value)
    cameras.write(d2, calibration.right_distortion)
    cameras.release()
    standing = cv2.FileStorage(str(folder / "extrinsics.yml"), cv2.FILE_STORAGE_WRITE)
    standing.write(r, calibration.rotation)
    standing.write(t, calibration.translation_mm / scale)
    standing.write("image_width", 640)
    standing.write("image_height", 480)
    standing.release()
    return folder / "intrinsics.yml", folder / "extrinsics.yml"


@pytest.mark.parametrize(
    ("names", "unit", "scale"),
    [
        (("M1", "D1", "M2", "D2", "R", "T"), "mm", 1),
        (("cameraMatrix1", "distCoeffs1", "cameraMatrix2", "distCoeffs2", "R", "T"), "m", 1000),
        (("K1", "D1", "K2", "D2", "R", "T"), "cm", 10),
    ],
)
def test_usual_names_and_units(calibration, tmp_path, names, unit, scale):
    same(import_calibration(two_files(tmp_path, calibration, names, scale), unit), calibration, 1e-9)


def test_a_unit_that_the_file_contradicts_is_refused(calibration, files, tmp_path):
    for names, told in ((files[:1], "mm"), (files[1:], "m")):
        with pytest.raises(CalibrationError, match=f"its translation is in {told}; --unit says cm"):
            import_calibration(names, "cm")
        same(import_calibration(names, told), calibration, 1e-6)
    same(import_calibration(two_files(tmp_path, calibration, ("M1", "D1", "M2", "D2", "R", "T"), 1)), calibration, 1e-9)


def test_what_is_wrong_is_a_sentence(calibration, files, tmp_path):
    parts = two_files(tmp_path, calibration, ("M1", "D1", "M2", "D2", "R", "T"), 1000)
    text = files[1].read_text()
    spoilt = {
        "fisheye.yaml": text.replace("plumb_bob", "equidistant"),
        "half.yaml": text[: len(text) // 2],
        "again.yaml": text,
        "nothing.yml": "",
        "six.yaml": text.replace("image_width: 640", "image_width: six"),
        "endless.yaml": text.replace("image_width: 640", "image_width: .inf"),
        "words.yml": "Dear all,\nthis is: [not",
    }
    for name, content in spoilt.items():
        (tmp_path / name).write_text(content)
    turned = files[0].read_text().replace("R: !!", "Rest: !!").replace("image_width", "wide")
    (tmp_path / "turned.yml").write_text(turned)
    (tmp_path / "turn.yml").write_text(
        re.sub(r"R: !!.*?(?=^\w)", 'R: "hello"\n', files[0].read_text(), flags=re.S | re.M)
    )
    for names, words in (
        (parts, "0.121 mm apart. Say in which unit"),
        (parts[:1], "expected R, T, image_width, image_height as well"),
        ([tmp_path / "turned.yml"], "expected R, image_width as well"),
        (files[1:2], "expected two files"),
        ([files[1], tmp_path / "again.yaml"], "neither projection_matrix tells how far apart"),
        ([tmp_path / "fisheye.yaml", files[2]], "its lens model is equidistant"),
        (files, "left.yaml and right.yaml are of ROS, and stereo.yml not: name stereo.yml alone, or"),
        (files[1::-1], "left.yaml is of ROS, and stereo.yml not: name stereo.yml alone, or"),
        ([tmp_path / "half.yaml", files[2]], "neither YAML, XML or JSON that OpenCV wrote nor"),
        ([tmp_path / "nothing.yml"], "neither YAML"),
        ([tmp_path / "words.yml"], "neither YAML"),
        ([tmp_path / "six.yaml", files[2]], "image_width: expected a number, got 'six'"),
        ([tmp_path / "endless.yaml", files[2]], "image_width: expected a finite number"),
        ([tmp_path / "turn.yml"], "rotation is 'hello'"),
    ):
        with pytest.raises(CalibrationError, match=words):
            import_calibration([str(name) for name in names])


@pytest.fixture
def taken_over(bench, files, tmp_path):
    """The bench without its boards, with the calibration that it exported."""
    folder = tmp_path / "mine"
    for name in ("position", "depth"):
        shutil.copytree(bench.path / name, folder / name)
    facts = json.loads((bench.path / "recording.json").read_text())
    (folder / "recording.json").write_text(json.dumps(facts | {"made_by": "camera", "title": "Our own rig"}))
    assert cli.main(["import", "--calibration", str(files[1]), str(files[2]), "--out", str(folder)]) == 0
    return open_recording(folder)


def test_a_ball_is_located_with_a_calibration_from_elsewhere(bench, taken_over, capsys):
    assert taken_over.is_calibrated and not taken_over.has_boards
    sample = bench.judges("volume")[0]
    ours, theirs = (Localizer.fit(r).locate(sample.pair.left, sample.pair.right) for r in (bench, taken_over))
    assert abs(ours.depth_mm - theirs.depth_mm) < 0.5 and abs(ours.x_mm - theirs.x_mm) < 0.5
    assert cli.main(["calibrate", str(taken_over.path)]) == 0
    assert "Taken over from left.yaml and right.yaml" in capsys.readouterr().out
    assert cli.main(["calibrate", str(taken_over.path), "--report", str(taken_over.path / "c.html")]) == 2
    assert "nothing to draw" in capsys.readouterr().err and not (taken_over.path / "c.html").exists()


def exchanged(recording):
    for name in ("position", "depth"):
        left, right, aside = (recording.path / name / side for side in ("left", "right", "aside"))
        left.rename(aside), right.rename(left), aside.rename(right)


def shuffled(recording):
    for name in ("position", "depth"):
        table = recording.path / name / "measured.csv"
        head, *lines = table.read_text().splitlines()
        names, *places = zip(*(line.split(",") for line in lines), strict=True)
        moved = [column[k + 1 :] + column[: k + 1] for k, column in enumerate(places)]
        table.write_text("\n".join([head, *(",".join(row) for row in zip(names, *moved, strict=True)), ""]))


def larger_ball(recording):
    path = recording.path / "recording.json"
    facts = json.loads(path.read_text())
    path.write_text(json.dumps(facts | {"ball": {"color": "red", "diameter_mm": 65}}))


@pytest.mark.parametrize(("spoil", "name"), [
    (exchanged, "sides_swapped"), (larger_ball, "ball_diameter"), (shuffled, "table_unfit"),
])  # fmt: skip
def test_faults_of_balls_are_told_by_cameras_from_elsewhere(taken_over, spoil, name):
    """Nobody tells how exact these cameras are; that excuses no fault as large as these."""
    assert check_recording(taken_over).verdict == "clean"
    spoil(taken_over)
    finding = check_recording(open_recording(taken_over.path)).findings[0]
    assert (finding.name, finding.severity) == (name, "stops")


def test_no_folder_is_swapped_where_no_boards_tell_the_sides(taken_over, capsys):
    before = {path: path.read_bytes() for path in taken_over.path.rglob("*.jpg")}
    assert cli.main(["calibrate", str(taken_over.path), "--swap"]) == 2
    assert "no pictures of boards" in capsys.readouterr().err
    assert {path: path.read_bytes() for path in taken_over.path.rglob("*.jpg")} == before


def test_boards_win_over_a_calibration_from_elsewhere(bench, files, tmp_path, capsys):
    assert cli.main(["import", "--calibration", str(files[0]), "--out", str(bench.path)]) == 2
    assert "has boards of its own" in capsys.readouterr().err
    other = tmp_path / "other"
    other.mkdir()
    facts = json.loads((bench.path / "recording.json").read_text())
    (other / "recording.json").write_text(json.dumps(facts | {"image_size": [1280, 720]}))
    assert cli.main(["import", "--calibration", str(files[0]), "--out", str(other)]) == 2
    assert "are 1280x720 pixels, those of the calibration 640x480" in capsys.readouterr().err


def test_a_new_recording_is_made_where_there_is_none(files, tmp_path, capsys):
    assert (
        cli.main(["import", "--calibration", str(files[0]), "--out", str(tmp_path / "new"), "--ball-color", "green"])
        == 0
    )
    made = open_recording(tmp_path / "new")
    assert made.image_size == (640, 480) and made.ball.color == "green" and made.is_calibrated
    assert cli.main(["import", "--out", str(tmp_path / "newer")]) == 2
    assert "Expected --left, --right, --board, --square-mm as well" in capsys.readouterr().err


def test_the_command_names_its_files(tmp_path, capsys):
    assert cli.main(["export", "bench", "--out", str(tmp_path / "out")]) == 0
    said = capsys.readouterr().out
    assert all(
        (tmp_path / "out" / name).is_file() and name in said for name in ("stereo.yml", "left.yaml", "right.yaml")
    )


@pytest.mark.parametrize(
    ("step", "says"),
    [((0, -100, 0), "0 mm to the right of it and 100 mm below"), ((100, 0, 0), "-100 mm to the right")],
)
def test_cameras_that_do_not_stand_side_by_side_are_refused(calibration, tmp_path, step, says):
    moved = replace(calibration, translation_mm=np.array(step, float), rotation=np.eye(3))
    files = export_calibration(moved, tmp_path / "moved", "bench")
    with pytest.raises(CalibrationError, match=says):
        import_calibration(files[:1])


def test_what_the_command_would_leave_out_is_refused(bench, files, tmp_path, capsys):
    """A recording's own calibration and ball, and options that are of pictures."""
    out = tmp_path / "mine"
    words = ["import", "--calibration", str(files[0]), "--out", str(out)]
    for _ in range(2):  # the same once more changes nothing
        assert cli.main(words) == 0
    for more, said in (
        (["--ball-color", "green"], "was begun with a red ball of 40 mm; this is a green one"),
        (["--board", "8x5", "--charuco"], "--board, --charuco has no place beside it"),
        (["--every", "5"], "--every has no place beside it"),
        (["--side-by-side", "shots/*.png"], "--side-by-side has no place beside it"),
        (["--unit", "m"], "its translation is in mm; --unit says m"),
    ):
        assert cli.main([*words, *more]) == 2 and said in capsys.readouterr().err
    facts = json.loads((out / "calibration.json").read_text())
    facts["translation_mm"] = [2 * x for x in facts["translation_mm"]]
    (out / "calibration.json").write_text(json.dumps(facts))
    assert cli.main(words) == 2 and "has another calibration already" in capsys.readouterr().err
    assert json.loads((out / "calibration.json").read_text()) == facts


def test_one_film_is_not_both(tmp_path, capsys):
    (tmp_path / "a.mp4").touch()
    words = [
        "import",
        "--left",
        str(tmp_path / "a.mp4"),
        "--right",
        str(tmp_path / "a.mp4"),
        "--out",
        str(tmp_path / "mine"),
    ]
    assert cli.main([*words, "--board", "9x6", "--square-mm", "25"]) == 2
    assert "Each camera has a film of its own" in capsys.readouterr().err


def test_no_points_are_no_points(calibration):
    for points in (calibration.rectify_points([], "left"), calibration.unrectify_points(np.zeros((0, 2)), "right")):
        assert points.shape == (0, 2)


@pytest.mark.parametrize(("turned", "findings"), [(False, []), (True, [("sign", "costs")])])
def test_a_mirrored_table_is_no_note_where_the_calibration_is_from_elsewhere(bench, files, tmp_path, turned, findings):
    """Nobody knows how exact such cameras are: what a table does is weighed against what a ball's pixels do alone."""
    for name in ("position", "depth"):
        shutil.copytree(bench.path / name, tmp_path / "mine" / name)
        table = tmp_path / "mine" / name / "measured.csv"
        rows = [line.split(",") for line in table.read_text().splitlines()]
        for row in rows[1:] if turned else []:
            row[1] = f"{-float(row[1]):g}"
        table.write_text("\n".join(map(",".join, rows)) + "\n")
    shutil.copy(bench.path / "recording.json", tmp_path / "mine")
    import_calibration(files[:1]).save(tmp_path / "mine" / "calibration.json")
    checkup = check_recording(open_recording(tmp_path / "mine"))
    assert [(f.name, f.severity) for f in checkup.findings] == findings


FISHEYE = ("K1", "D1", "K2", "D2", "R", "T")


def of_numbers(calibration, count):
    """The same cameras, their distortions of so many numbers."""
    lenses = {f"{side}_distortion": np.resize([-0.02, 0.01, 0.0, 0.0, 0.0], count) for side in ("left", "right")}
    return replace(calibration, **lenses)


def test_a_fisheye_of_opencv_is_not_taken_for_an_ordinary_lens(calibration, tmp_path):
    for lens in (of_numbers(calibration, 4), replace(calibration, right_distortion=np.full((4, 1), -0.02))):
        with pytest.raises(
            CalibrationError, match="expected 5, 8, 12 or 14 numbers in .*_distortion; there are 4. .*write a fifth"
        ):
            import_calibration(two_files(tmp_path, lens, FISHEYE, 1))
    for count in (5, 8, 12, 14):
        found = import_calibration(two_files(tmp_path, of_numbers(calibration, count), FISHEYE, 1))
        assert len(found.left_distortion) == len(found.right_distortion) == count


def test_a_lens_of_four_numbers_is_given_away_with_five(calibration, tmp_path):
    """What ROS calls plumb_bob may come with four: the kit's own files of it can be read again."""
    four = of_numbers(calibration, 4)
    for files in (export_calibration(four, tmp_path)[:1], export_calibration(four, tmp_path)[1:]):
        same(import_calibration(files), of_numbers(calibration, 5), 1e-6)


def test_a_lens_of_more_numbers_is_another_calibration(calibration, tmp_path):
    for count in (5, 5, 8):
        files = export_calibration(of_numbers(calibration, count), tmp_path)
        if count == 8:
            with pytest.raises(CalibrationError, match="has another calibration already"):
                recording_of(import_calibration(files[:1]), tmp_path / "mine", Ball("red", 40.0))
        else:
            recording_of(import_calibration(files[:1]), tmp_path / "mine", Ball("red", 40.0))


@pytest.mark.parametrize(
    ("row", "column", "value", "says"),
    [
        (0, 1, 50.0, "left_matrix has a skew"),
        (1, 0, 30.0, "left_matrix has a skew"),
        (0, 2, 99999.0, "left_matrix has its principal point farther outside"),
        (0, 0, 1e-9, "left_matrix has a focal length that no lens has"),
    ],
)
def test_cameras_that_cannot_be_are_not_taken_over(calibration, tmp_path, row, column, value, says):
    matrix = calibration.left_matrix.copy()
    matrix[row, column] = value
    spoilt = replace(calibration, left_matrix=matrix)
    with pytest.raises(CalibrationError, match=f"intrinsics.yml and extrinsics.yml: {says}"):
        import_calibration(two_files(tmp_path, spoilt, FISHEYE, 1))


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ('"misfit": 1.0', '"misfit": 1,0', "line [0-9]+: this is not valid JSON.* A number has a point, not a comma"),
        ('"lens": "brown"', '"lens": "fisheye"', "lens: expected brown, got 'fisheye'"),
        ('"lens": ', '"glass": ', "it has no 'lens'"),
    ],
)
def test_a_broken_calibration_is_told_where_there_are_no_boards(taken_over, capsys, old, new, says):
    path = taken_over.path / "calibration.json"
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))
    with pytest.raises(CalibrationError, match=says) as error:
        calibrate_recording(taken_over)
    assert str(path) in str(error.value)
    assert cli.main(["calibrate", str(taken_over.path)]) == 2 and str(path) in capsys.readouterr().err


def test_a_calibration_of_another_size_is_told_where_there_are_no_boards(taken_over):
    path = taken_over.path / "calibration.json"
    facts = json.loads(path.read_text())
    path.write_text(json.dumps(facts | {"image_size": facts["image_size"][::-1]}))
    with pytest.raises(CalibrationError, match="is for pictures of 480x640 pixels, and those of .* are 640x480"):
        calibrate_recording(taken_over)


def test_no_boards_and_no_calibration_is_told(taken_over):
    (taken_over.path / "calibration.json").unlink()
    with pytest.raises(CalibrationError, match="has no pictures of boards"):
        calibrate_recording(taken_over)

"""Calibration against exact truth, another triangulation, and the mistakes that people make."""

import json
import math
import shutil
from dataclasses import fields, replace

import cv2
import numpy as np
import pytest
from rigs import BOARD, bent_board, hold, known_rig

from conftest import ROOT, slow_after_first
from stereo_lab.calibration import StereoCalibration, calibrate_stereo, match_order, store
from stereo_lab.calibration.cameras import ARRAYS
from stereo_lab.calibration.corners import _neighbours, find_corners
from stereo_lab.calibration.recipe import calibrate_views
from stereo_lab.calibration.refusals import check_sides, check_two_cameras
from stereo_lab.calibration.saved import WORDS
from stereo_lab.calibration.search import find_views
from stereo_lab.calibration.verdict import GRADES
from stereo_lab.calibration.views import View
from stereo_lab.doctor.cameras import _corners
from stereo_lab.errors import CalibrationError
from stereo_lab.recording import Board, StereoPair, open_recording
from stereo_lab.results.report import calibration_lines
from tests.written import assert_as_written


def true_centers(recording, set_name):
    rows = [recording.true_ball(set_name, pair.name) for pair in recording.pairs(set_name)]
    return (np.array([r[side][:2] for r in rows]) for side in ("left", "right"))


def test_bench_calibration_is_good(bench, bench_calibration):
    assert bench_calibration.verdict == "good"
    assert bench_calibration.rms_px < 0.10
    left, right = true_centers(bench, "evaluation")
    rows = bench_calibration.rectify_points(left, "left")[:, 1] - bench_calibration.rectify_points(right, "right")[:, 1]
    assert np.abs(rows).mean() < 0.04


def test_baseline_and_focal_length_are_the_true_ones(bench, bench_calibration):
    cameras = bench.truth["cameras"]
    baseline = np.linalg.norm(np.subtract(cameras["left"]["position_mm"], cameras["right"]["position_mm"]))
    assert bench_calibration.baseline_mm == pytest.approx(baseline, abs=0.15)
    assert bench_calibration.left_matrix[0, 0] == pytest.approx(cameras["left"]["matrix"][0][0], rel=0.002)


def test_triangulate_agrees_with_opencv(bench, bench_calibration):
    raw_left, raw_right = true_centers(bench, "position")
    left, right = (
        bench_calibration.rectify_points(raw_left, "left"),
        bench_calibration.rectify_points(raw_right, "right"),
    )
    right[:, 1] = left[:, 1]
    projections = [bench_calibration.rectified[side][1] for side in ("left", "right")]
    points = cv2.triangulatePoints(*projections, left.T, right.T)
    assert np.allclose(bench_calibration.triangulate(left, right), (points[:3] / points[3]).T, atol=1e-6)


def test_triangulate_uses_both_rows(bench_calibration):
    """Rows that differ by a pixel: the point lies between them, half a pixel from each."""
    left, right = np.array([[400.0, 200.0]]), np.array([[330.0, 201.0]])
    (x, y, z), (x0, y0, z0) = (bench_calibration.triangulate(left, r)[0] for r in (right, right - [0, 1]))
    assert (x, z) == pytest.approx((x0, z0)) and y - y0 == pytest.approx(0.5 * z / bench_calibration.focal_px)


def test_a_pixel_of_disparity_is_worth_what_triangulation_says(bench_calibration):
    left, step = np.array([[400.0, 200.0]]), 1e-4
    depths = [bench_calibration.triangulate(left, left - [d, 0])[0, 2] for d in (80.0, 80.0 - step)]
    slope = (depths[1] - depths[0]) / step
    assert bench_calibration.depth_per_px(depths[0]) == pytest.approx(slope, rel=2e-3)


def test_unrectify_undoes_rectify(bench_calibration):
    raw = np.array([[20.0, 30.0], [320.0, 240.0], [610.0, 455.0]])
    for side in ("left", "right"):
        there = bench_calibration.rectify_points(raw, side)
        assert np.abs(there - raw).max() > 1
        assert np.allclose(bench_calibration.unrectify_points(there, side), raw, atol=1e-6)


def test_save_and_load(bench_calibration, tmp_path):
    path = tmp_path / "cal.json"
    bench_calibration.save(path)
    again = StereoCalibration.load(path)
    assert again.facts() == bench_calibration.facts()
    assert np.array_equal(again.rotation, bench_calibration.rotation)


def test_load_refuses_other_files(tmp_path):
    path = tmp_path / "x.json"
    path.write_text('{"format": 1}')
    with pytest.raises(CalibrationError, match="no calibration"):
        StereoCalibration.load(path)


@pytest.fixture
def saved(bench_calibration, tmp_path):
    """A saved calibration: its path, and what is in it."""
    path = tmp_path / "cal.json"
    bench_calibration.save(path)
    return path, json.loads(path.read_text())


MIRROR = [[1, 0, 0], [0, 1, 0], [0, 0, -1]]


@pytest.mark.parametrize(
    ("key", "value", "says"),
    [
        ("rms_px", "abc", "rms_px: expected a number, got 'abc'"),
        ("rms_px", math.nan, "rms_px: expected a finite number"),
        ("rms_px", None, "rms_px: expected a number"),
        ("rms_px", True, "rms_px: expected a finite number"),
        ("pairs", "many", "pairs: expected a number"),
        ("heldout_vertical_error_px", [], "heldout_vertical_error_px: expected a number"),
        ("left_matrix", [1, 2, 3], "left_matrix"),
        ("left_matrix", {"a": 1}, "left_matrix"),
        ("left_matrix", [[math.nan] * 3] * 3, "left_matrix holds a number that is not finite"),
        ("left_matrix", [[0, 0, 320], [0, 600, 240], [0, 0, 1]], "left_matrix has a focal length of zero"),
        ("left_matrix", [[600, 0, 320], [0, 600, 240], [0, 0, 0]], "left_matrix is no camera's matrix"),
        ("left_distortion", [0, 0, 0], "left_distortion must have 4, 5, 8, 12, 14 numbers"),
        ("left_distortion", "none", "left_distortion"),
        ("rotation", [[1, 1, 0], [0, 1, 0], [0, 0, 1]], "rotation is not a rotation"),
        ("rotation", MIRROR, "rotation is not a rotation"),
        ("rotation", [[10**400, 0, 0], [0, 1, 0], [0, 0, 1]], "rotation: expected numbers"),
        ("translation_mm", [0, 0, 0], "translation_mm"),
        ("translation_mm", [1e300, 0, 0], "translation_mm"),
        ("translation_mm", [1, 2], "translation_mm"),
        ("image_size", [640], "image_size"),
        ("image_size", 640, "image_size"),
        ("image_size", [0, 480], "image_size"),
        ("image_size", [1e300, 480], "image_size"),
        ("used", 5, "used"),
        ("dropped", ["000"], "dropped"),
        ("dropped", [{"name": "000"}], "it has no 'why'"),
        ("reasons", None, "reasons"),
        ("format", 2, "newer kit"),
        ("format", None, 'expected "format": 1'),
    ],
)
def test_a_broken_calibration_is_named(saved, key, value, says):
    path, facts = saved
    path.write_text(json.dumps({**facts, key: value}))
    with pytest.raises(CalibrationError, match=says) as error:
        StereoCalibration.load(path)
    assert str(path) in str(error.value)


def test_a_calibration_with_something_missing(saved):
    path, facts = saved
    newer = {"depth_mm", "misfit", "covariance", "outlines", "corners_left_out"}  # files of before them still load
    for key in set(facts) - {"made_from", "baseline_mm", "focal_px", "pairs_used"} - newer:  # these are not needed
        path.write_text(json.dumps({k: v for k, v in facts.items() if k != key}))
        with pytest.raises(CalibrationError, match=key):
            StereoCalibration.load(path)


def test_an_older_calibration_still_loads_and_knows_no_sigma(saved):
    path, facts = saved
    newer = ("depth_mm", "misfit", "covariance", "outlines", "corners_left_out")
    path.write_text(json.dumps({key: value for key, value in facts.items() if key not in newer}))
    older = StereoCalibration.load(path)
    assert np.isnan(older.sigma_mm([[0, 0, 1000.0]])).all() and older.boards_at([[320, 240]], "left").tolist() == [0]


@pytest.mark.parametrize("content", ["", "[1, 2]", "null", "{", "[" * 200_000, "\x00"])
def test_a_calibration_that_is_something_else(tmp_path, content):
    path = tmp_path / "x.json"
    path.write_text(content)
    with pytest.raises(CalibrationError, match="no calibration"):
        StereoCalibration.load(path)


def test_a_spoilt_calibration_in_a_recording_is_made_anew(bench, bench_calibration, tmp_path, monkeypatch):
    monkeypatch.setattr(store, "calibrate_stereo", lambda *_: bench_calibration)
    monkeypatch.setenv("STEREO_LAB_HOME", str(tmp_path / "home"))
    shutil.copytree(bench.path / "calibration", tmp_path / "mine" / "calibration")
    shutil.copy(bench.path / "recording.json", tmp_path / "mine")
    (tmp_path / "mine" / "calibration.json").write_text('{"format": 1, "rms_px": "abc"}')
    assert store.find_calibration(open_recording(tmp_path / "mine"))[1] == store.MADE
    assert store.find_calibration(open_recording(tmp_path / "mine"))[1] == store.KEPT


def test_other_squares_are_another_calibration(bench, bench_calibration, tmp_path, monkeypatch):
    monkeypatch.setattr(store, "calibrate_stereo", lambda *_: bench_calibration)
    monkeypatch.setenv("STEREO_LAB_HOME", str(tmp_path / "home"))
    shutil.copytree(bench.path / "calibration", tmp_path / "mine" / "calibration")
    facts = json.loads((bench.path / "recording.json").read_text(encoding="utf-8"))
    for square_mm, source in ((24.5, store.MADE), (24.5, store.KEPT), (25.0, store.MADE)):
        facts["board"]["square_mm"] = square_mm
        (tmp_path / "mine" / "recording.json").write_text(json.dumps(facts), encoding="utf-8")
        assert store.find_calibration(open_recording(tmp_path / "mine"))[1] == source


def test_a_replaced_calibration_has_maps_of_its_own(bench_calibration):
    """What was reckoned for the first one is not carried over to the changed copy."""
    picture = np.random.default_rng(0).integers(0, 255, (480, 640, 3), np.uint8)
    before = bench_calibration.rectify(picture, picture)
    turn = cv2.Rodrigues(np.radians([3.0, 0, 0]))[0]
    other = replace(bench_calibration, rotation=turn @ bench_calibration.rotation)
    values = {field.name: getattr(other, field.name) for field in fields(other)}
    fresh = StereoCalibration(**values).rectify(picture, picture)
    assert all(np.array_equal(a, b) for a, b in zip(other.rectify(picture, picture), fresh, strict=True))
    assert not np.array_equal(other.rectify(picture, picture)[0], before[0])
    assert np.array_equal(bench_calibration.rectify(picture, picture)[0], before[0])


def test_pictures_of_another_size_are_refused(bench_calibration):
    other = np.zeros((720, 1280, 3), np.uint8)
    with pytest.raises(CalibrationError, match="640x480.*1280x720"):
        bench_calibration.rectify(other, other)


def test_swapped_cameras_are_named(bench):
    pairs = [replace(p, left_path=p.right_path, right_path=p.left_path) for p in bench.pairs("calibration")[:8]]
    with pytest.raises(CalibrationError, match="swapped"):
        calibrate_stereo(pairs, bench.board)


@pytest.mark.parametrize("said", slow_after_first((10, 7), (8, 5), (7, 10)))
def test_wrong_board_size_is_named(bench, said):
    with pytest.raises(CalibrationError, match=r"9x6|6x9"):
        calibrate_stereo(bench.pairs("calibration")[:3], Board(*said, 25.0))


def test_likely_mistakes_in_a_boards_size_are_all_tried():
    tried = {(size.columns, size.rows) for size in _neighbours(Board(9, 6, 25.0))}
    beside = {(9 + c, 6 + r) for c in (-1, 0, 1) for r in (-1, 0, 1) if c or r}
    assert beside - {(8, 7), (10, 5)} <= tried  # one more this way and one less that way is no mistake in counting
    assert {(7, 10), (8, 5), (11, 8), (7, 4)} <= tried


def test_square_in_centimetres_is_guessed(bench):
    result = calibrate_stereo(bench.pairs("calibration")[:7], replace(bench.board, square_mm=2.5))
    assert result.verdict == "poor" and any("centimetres" in reason for reason in result.reasons)


@pytest.mark.slow
def test_names_and_order_of_the_pairs_decide_nothing(bench):
    pairs = bench.pairs("calibration")[:9]
    renamed = [replace(pair, name=f"{k:03d}") for k, pair in enumerate(pairs[::-1])]
    one, other = calibrate_stereo(pairs, bench.board), calibrate_stereo(renamed, bench.board)
    assert one.heldout_vertical_error_px == pytest.approx(other.heldout_vertical_error_px, rel=1e-6)
    assert (one.verdict, one.rms_px) == (other.verdict, pytest.approx(other.rms_px, rel=1e-9))
    assert np.array_equal(one.left_matrix, other.left_matrix)


def test_wrong_board_size_is_named_of_one_picture(bench):
    with pytest.raises(CalibrationError, match="10x7 inner corners; the pictures show 9x6"):
        calibrate_stereo(bench.pairs("calibration")[:1], Board(10, 7, 25.0))


def test_a_wrong_board_size_is_told_after_a_few_pairs(bench, monkeypatch):
    looked = []
    monkeypatch.setattr("stereo_lab.calibration.search.find_corners", lambda *_: None)
    with pytest.raises(CalibrationError, match="10x7 inner corners; the pictures show 9x6"):
        find_views(bench.pairs("calibration"), Board(10, 7, 25.0), lambda done, total: looked.append(done))
    assert looked == [1, 2, 3, 4, 5, 6]


def test_too_few_boards(bench):
    with pytest.raises(CalibrationError, match="at least 4"):
        calibrate_stereo(bench.pairs("calibration")[:2], bench.board)


@pytest.mark.parametrize("count", [4, 8])
def test_pairs_not_taken_together(bench, count):
    pairs = bench.pairs("calibration")[:count]
    mixed = [replace(p, right_path=q.right_path) for p, q in zip(pairs, pairs[1:] + pairs[:1], strict=True)]
    with pytest.raises(CalibrationError, match="do not see the same boards.* same moment.* upside down"):
        calibrate_stereo(mixed, bench.board)


def test_two_pairs_mixed_up_are_dropped_and_named(bench):
    pairs = list(bench.pairs("calibration")[:14])
    pairs[3], pairs[9] = (replace(pairs[i], right_path=pairs[j].right_path) for i, j in ((3, 9), (9, 3)))
    result = calibrate_stereo(pairs, bench.board)
    assert {name for name, _ in result.dropped} == {pairs[3].name, pairs[9].name}
    assert result.rms_px < 0.1
    assert_as_written("calibrations/two mixed up", facts_in_words(result), {"absolute": 0.03, "relative": 0.01})


def test_a_board_that_never_moves(bench):
    with pytest.raises(CalibrationError, match="same place in all 8 pairs"):
        calibrate_stereo([bench.pairs("calibration")[3]] * 8, bench.board)


def test_boards_in_one_part_of_the_picture():
    rng = np.random.default_rng(2)
    rig = known_rig(rng)
    views = hold(rng, rig, bent_board(rng), 7, reach=0.02)
    result = calibrate_views(views, BOARD, rig.size, [view.name for view in views])
    assert result.verdict != "good" and any("hold more boards in these parts" in reason for reason in result.reasons)


def test_corners_are_exact_on_a_drawn_board():
    """A board drawn large with a known homography and made small: corners within 0.05 px."""
    board, scale = Board(7, 5, 20.0), 8
    squares = np.add.outer(np.arange(6), np.arange(8)) % 2
    texture = np.pad((squares * 180 + 40).astype(np.uint8).repeat(40, 0).repeat(40, 1), 40, constant_values=220)
    homography = np.array([[7.2, 0.9, 900], [-0.5, 7.0, 700], [1e-4, 2e-4, 1.0]])
    large = cv2.warpPerspective(
        texture, homography, (640 * scale, 480 * scale), borderValue=200, flags=cv2.INTER_LINEAR
    )
    image = cv2.resize(cv2.GaussianBlur(large, (0, 0), 0.6 * scale), (640, 480), interpolation=cv2.INTER_AREA)
    found = find_corners(image, board)
    inner = 80 + 40 * np.mgrid[:7, :5].T.reshape(-1, 2) - 0.5
    true = cv2.perspectiveTransform(inner.reshape(-1, 1, 2).astype(float), homography).reshape(-1, 2)
    true = (true + 0.5) / scale - 0.5
    distance = np.linalg.norm(found[:, None] - true[None], axis=2).min(1)
    assert distance.max() < 0.05


@pytest.mark.parametrize("first_is_dark", [True, False])
@pytest.mark.parametrize("size", [(7, 5), (8, 6), (8, 5), (9, 4)])
def test_corners_come_in_one_order(size, first_is_dark):
    """A board with one odd and one even count has its dark end first; others begin at the upper left."""
    board = Board(*size, 20.0)
    dark = (np.add.outer(np.arange(size[1] + 1), np.arange(size[0] + 1)) + first_is_dark) % 2 == 1
    image = np.pad(np.where(dark, 40, 220).astype(np.uint8).repeat(30, 0).repeat(30, 1), 60, constant_values=220)
    first = find_corners(cv2.GaussianBlur(image, (0, 0), 1), board)[0]
    at_upper_left = first_is_dark or sum(size) % 2 == 0
    assert first == pytest.approx((89.5, 89.5) if at_upper_left else np.subtract(image.shape[1::-1], 90.5), abs=0.1)


def test_each_view_holds_the_corners_of_its_own_two_pictures(bench):
    pairs = bench.pairs("calibration")[:3]
    views, dropped, size = find_views(pairs, bench.board)
    assert (dropped, size) == ([], bench.image_size)
    for view, pair in zip(views, pairs, strict=True):
        assert view.left == pytest.approx(find_corners(pair.left, bench.board))
        assert view.right == pytest.approx(find_corners(pair.right, bench.board))


@pytest.mark.slow
def test_real_chessboards(real_pictures):
    folder = real_pictures / "stereo_chessboard"
    pairs = [
        StereoPair(left.stem[-2:], left, folder / left.name.replace("left", "right"), None, True)
        for left in sorted(folder.glob("left*.jpg"))
    ]
    result = calibrate_stereo(pairs, Board(11, 8, 12.0))
    assert result.verdict == "good"
    assert result.heldout_vertical_error_px < 0.025
    assert result.heldout_length_error_percent < 0.13
    assert result.baseline_mm == pytest.approx(49.3, abs=0.15)


@pytest.mark.slow
def test_second_rig(second_rig):
    result = calibrate_stereo(second_rig.pairs("calibration"), second_rig.board)
    assert result.rms_px < 0.10
    left, right = true_centers(second_rig, "evaluation")
    rows = result.rectify_points(left, "left")[:, 1] - result.rectify_points(right, "right")[:, 1]
    assert np.abs(rows).mean() < 0.04


def test_shipped_recordings_say_that_they_are_rendered():
    for path in (ROOT / "data").glob("*/recording.json"):
        assert '"made_by": "render"' in path.read_text(encoding="utf-8")


@pytest.mark.parametrize(("name", "number"), [("bench", 0), ("bench", 5), ("second_rig", 3)])
def test_corners_are_those_written_down(name, number):
    recording = open_recording(ROOT / "data" / name)
    pair, lines = recording.pairs("calibration")[number], []
    left, right = find_corners(pair.left, recording.board), find_corners(pair.right, recording.board)
    for corners in (left, match_order(left, right, recording.board)):
        lines += [f"u {u:.3f} px v {v:.3f} px" for u, v in corners]
    assert_as_written(f"corners/{name}/{number}", lines, {"absolute": 0.01})


def facts_in_words(result):
    facts = result.facts()
    lines = [f"{key} {value:.3f} px" if isinstance(value, float) else f"{key} {value}" for key, value in facts.items()]
    return lines + [f"{key} " + " ".join(f"{v:.2f}" for v in getattr(result, key).ravel()) for key in ARRAYS]


@pytest.mark.parametrize("choose", [slice(0, 5), slice(3, 12, 2)], ids=["five", "five others"])
def test_a_small_calibration_is_the_one_written_down(bench, choose):
    result = calibrate_stereo(bench.pairs("calibration")[choose], bench.board)
    name = f"calibrations/{choose.start} {choose.stop} {choose.step}"
    assert_as_written(name, facts_in_words(result), {"absolute": 0.03, "relative": 0.01})


@pytest.mark.parametrize(("columns", "rows"), [(7, 7), (9, 6), (8, 7)])
def test_corners_of_both_cameras_are_in_one_order(columns, rows):
    """A square board looks the same at every quarter of a turn, any other at half a turn."""
    board = Board(columns, rows, 25.0)
    for turn in np.linspace(-3, 3, 13):
        across = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
        left = board.corners_mm[:, :2] @ across + 300
        right = left - (60, 2)
        for quarters in range(4) if columns == rows else (0, 2):
            found = np.rot90(right.reshape(rows, columns, 2), quarters).reshape(-1, 2)
            assert np.allclose(match_order(left, found, board), right)


def test_one_cameras_pictures_on_both_sides(bench):
    pairs = [replace(pair, right_path=pair.left_path) for pair in bench.pairs("calibration")[:6]]
    with pytest.raises(CalibrationError, match="same pictures"):
        calibrate_stereo(pairs, bench.board)


def test_cameras_above_each_other_may_be_pictures_that_are_turned(bench_calibration):
    above = replace(bench_calibration.rig, rotation=np.eye(3), translation=np.array([0.0, -65, 0]))
    with pytest.raises(CalibrationError, match="or all pictures are turned by a quarter.*stereo-lab check"):
        check_sides(above)


def test_calibrate_and_check_count_the_same_corners_that_are_left_out(bench_calibration):
    corners = tuple((f"{k:03d}", "left", 1.0, 2.0, off) for k, off in enumerate([7.1, 3.0, 1.2, 0.4, 0.3]))
    spoilt = replace(bench_calibration, corners_left_out=corners)
    assert any("and without 2 corners more, off by 0.30 px or more" in line for line in calibration_lines(spoilt))
    (finding,) = _corners(spoilt)
    assert "3 corners are wrong" in finding.says and "2 more are left out, off by 1 px or less" in finding.says


def test_pairs_without_a_board_do_not_hide_those_with_one(bench, tmp_path):
    """Every fourth pair shows the board, and the first look takes every second one of them all."""
    empty = tmp_path / "empty.png"
    cv2.imwrite(str(empty), np.full((480, 640), 120, np.uint8))
    boards = iter(bench.pairs("calibration")[:6])
    nothing = replace(bench.pairs("calibration")[0], left_path=empty, right_path=empty)
    pairs = [replace(next(boards), name=f"{k}") if k % 4 == 1 else replace(nothing, name=f"{k}") for k in range(24)]
    assert len(calibrate_stereo(pairs, bench.board).used) == 6


def test_one_camera_on_both_sides_is_refused_where_corners_are_missing():
    corners = np.random.default_rng(3).uniform(0, 400, (20, 54, 2))
    corners[:5, :7] = np.nan
    with pytest.raises(CalibrationError, match="the same pictures"):
        check_two_cameras([View(str(k), seen, seen + 0.1) for k, seen in enumerate(corners)])
    check_two_cameras([View(str(k), seen, seen + 5.0) for k, seen in enumerate(corners)])


def test_a_row_difference_that_nobody_knows_is_saved_and_loaded(bench_calibration, tmp_path):
    """Of ChArUco boards of which no corner is seen by both cameras: a file that does not load would be made anew for ever."""
    replace(bench_calibration, vertical_error_px=np.nan).save(tmp_path / "cal.json")
    again = StereoCalibration.load(tmp_path / "cal.json")
    assert np.isnan(again.vertical_error_px) and again.rms_px == bench_calibration.rms_px


def camera(fx=600.0, skew=0.0, below=0.0, center=(320.0, 240.0)):
    return [[fx, skew, center[0]], [below, 600.0, center[1]], [0.0, 0.0, 1.0]]


LINKED = (np.eye(24) + 5 * (np.eye(24, k=1) + np.eye(24, k=-1))).tolist()


@pytest.mark.parametrize(
    ("key", "value", "says"),
    [
        ("left_matrix", camera(skew=50.0), "left_matrix has a skew"),
        ("right_matrix", camera(below=30.0), "right_matrix has a skew"),
        ("left_matrix", camera(center=(99999.0, -5000.0)), "left_matrix has its principal point farther outside .* 640x480"),
        ("right_matrix", camera(fx=1e-9), "right_matrix has a focal length that no lens has: .*1e-09"),
        ("left_distortion", [1e9] * 5, "left_distortion is of no lens"),
        ("translation_mm", [-0.08, 0, 0], "stand 0.08 mm apart. Is it in millimetres"),
        ("translation_mm", [80, 0, 0], "by these it stands -80 mm to the right of it"),
        ("translation_mm", [0, -80, 0], "and 80 mm below it"),
        ("covariance", LINKED, "covariance is no covariance: .* no negative eigenvalue"),
        ("covariance", (1e-9 * np.array(LINKED)).tolist(), "covariance is no covariance"),
        ("depth_mm", 0, "depth_mm: expected a number from 0.001"),
        ("depth_mm", -5, "depth_mm: expected a number from 0.001"),
        ("misfit", -1, "misfit: expected a number from 1 "),
        ("rms_px", -1, "rms_px: expected a number from 0 "),
        ("verdict", "excellent", "verdict: expected good or usable or poor, got 'excellent'"),
        ("verdict", None, "verdict: expected good or usable or poor, got None"),
        ("lens", "fisheye", "lens: expected brown, got 'fisheye'"),
        ("image_size", [480, 640], "pictures, which are 480x640 .* image_size exchanged"),
    ],
)  # fmt: skip
def test_what_no_calibration_can_be_is_named(saved, key, value, says):
    path, facts = saved
    path.write_text(json.dumps({**facts, key: value}))
    with pytest.raises(CalibrationError, match=says) as error:
        StereoCalibration.load(path)
    assert str(path) in str(error.value)


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("left_matrix", camera(center=(-600.0, 900.0))),
        ("left_distortion", [-0.4, 0.2, 0.0, 0.0, -0.05]),
        ("left_distortion", [8.0, 4.0, 0.0, 0.0, 0.1, 8.3, 6.5, 0.8]),
        ("translation_mm", [-1000.0, 2.0, -3.0]),
        ("covariance", np.zeros((24, 24)).tolist()),
        ("covariance", np.ones((24, 24)).tolist()),
        ("vertical_error_px", None),
    ],
)
def test_what_an_odd_calibration_may_be_is_loaded(saved, key, value):
    path, facts = saved
    path.write_text(json.dumps({**facts, key: value}))
    assert StereoCalibration.load(path).lens == "brown"


def test_a_calibration_of_squares_in_metres_is_kept(saved):
    """It says of itself that it is poor, and which unit it takes the squares to be in."""
    path, facts = saved
    metres = [part / 1000 for part in facts["translation_mm"]]
    path.write_text(json.dumps({**facts, "translation_mm": metres, "verdict": "poor"}))
    assert StereoCalibration.load(path).baseline_mm < 1


def test_the_reader_knows_the_verdicts_that_are_given():
    assert WORDS["verdict"] == GRADES

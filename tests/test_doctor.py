"""The doctor: recordings spoilt in one way each, at several strengths, and good ones that must come out clean."""

import json
import os
import re
import shutil
from dataclasses import replace

import cv2
import numpy as np
import pytest
from rigs import BOARD, bent_board, hold, known_rig, turned

from conftest import slow_after_first
from stereo_lab import cli
from stereo_lab.calibration import calibrate_recording
from stereo_lab.calibration.bundle import Rig
from stereo_lab.doctor import FAULTS, admit, check_recording, healthy, spoil
from stereo_lab.doctor.boards import Boards
from stereo_lab.doctor.findings import COSTS, NOTE, STOPS, Checkup, Finding, in_order, severity_of
from stereo_lab.doctor.known import apart_mm
from stereo_lab.doctor.numbers import likeliest_table, place, slip_of
from stereo_lab.doctor.pairing import mend_pairs
from stereo_lab.errors import RecordingError, StereoLabError
from stereo_lab.exercises.lesson08 import _with_a_digit
from stereo_lab.localization import Localizer
from stereo_lab.recording import import_images, open_recording
from stereo_lab.recording.sample import Board

PAIRS = 20


def taken(seed, rigs=1, change=None):
    """A random source, and the boards of a rig; with ``change``, of one that is another from pair k on."""
    rng = np.random.default_rng(seed)
    rig, corners = known_rig(rng), None
    corners = bent_board(rng, 0.4)
    boards = seen(hold(rng, rig, corners, PAIRS), rig)
    k = int(rng.integers(4, PAIRS - 4))
    if change is None:
        return rng, boards, k
    after = seen(hold(rng, change(rig, rng), corners, PAIRS), rig)
    return rng, mixed(boards, after, np.arange(PAIRS) >= k), k


def seen(views, rig):
    left, right = (np.array([getattr(view, side) for view in views]) for side in ("left", "right"))
    return Boards(tuple(view.name for view in views), left, right, BOARD, rig.size)


def mixed(one, other, where):
    there = where[:, None, None]
    return replace(one, left=np.where(there, other.left, one.left), right=np.where(there, other.right, one.right))


def names(mends):
    return [mend.name for mend in mends]


@pytest.mark.parametrize("seed", range(10))
def test_good_pairs_have_no_fault(seed):
    _, boards, _ = taken(seed)
    mends, together = mend_pairs(boards)
    assert names(mends) == [] and 0.03 < together.sigma_px < 0.05  # 0.04 px were drawn


@pytest.mark.parametrize("by", [1, -1, 2, -2])
@pytest.mark.parametrize("seed", range(3))
def test_a_picture_missing_on_one_side(seed, by):
    _, boards, _ = taken(seed)
    lefts = np.arange(max(0, -by), PAIRS - max(0, by))
    shifted = replace(boards.some(lefts), right=boards.right[lefts + by])
    mends, _ = mend_pairs(shifted)
    assert names(mends) == ["pairs_shifted"] and f"lacks {abs(by)}" in mends[0].says
    assert ("next" in mends[0].says or "later" in mends[0].says) == (by < 0)


@pytest.mark.parametrize("side", ["left", "right"])
@pytest.mark.parametrize("seed", range(4))
def test_a_picture_missing_in_mid_set(seed, side):
    _, boards, k = taken(seed)
    late = np.arange(k, PAIRS - 1)  # the others were numbered anew without it
    seen = getattr(boards, side).copy()
    seen[late] = seen[late + 1]
    mends, _ = mend_pairs(replace(boards.some(np.arange(PAIRS - 1)), **{side: seen[:-1]}))
    assert names(mends) == ["pairs_shifted"] and f"the {side} side lacks 1" in mends[0].says
    assert mends[0].pairs[0] == boards.names[k]


@pytest.mark.parametrize("seed", range(4))
def test_cameras_exchanged_in_mid_set(seed):
    _, boards, k = taken(seed)
    swapped = mixed(boards, replace(boards, left=boards.right, right=boards.left), np.arange(PAIRS) >= k)
    mends, _ = mend_pairs(swapped)
    assert names(mends) == ["cameras_exchanged"] and mends[0].pairs == boards.names[k:]
    assert np.array_equal(mends[0].boards.left, boards.left)  # it is mended


@pytest.mark.parametrize("late", [True, False])
@pytest.mark.parametrize("seed", range(4))
def test_cameras_that_were_turned_by_half_a_turn_in_mid_set(seed, late):
    """They stand as others would that were moved, and to turn the pictures back saves all."""
    _, boards, k = taken(seed)
    last, there = np.array(boards.size) - 1, (np.arange(PAIRS) >= k) == late
    turned_round = replace(boards, left=last - boards.left, right=last - boards.right)
    mends, _ = mend_pairs(mixed(boards, turned_round, there))
    assert names(mends) == ["pairs_upside_down"] and mends[0].pairs == tuple(np.array(boards.names)[there])
    assert np.allclose(mends[0].boards.left, boards.left)  # it is mended


@pytest.mark.parametrize("side", ["left", "right"])
@pytest.mark.parametrize("seed", range(3))
def test_a_mirror_image(seed, side):
    _, boards, _ = taken(seed)
    across, down = BOARD.grid
    flipped = getattr(boards, side) * [-1, 1] + [boards.size[0] - 1, 0]
    flipped = flipped.reshape(PAIRS, down, across, 2)[:, :, ::-1].reshape(PAIRS, -1, 2)  # as a finder numbers them
    mends, _ = mend_pairs(replace(boards, **{side: flipped}))
    assert names(mends) == ["mirrored"] and f"The {side} camera" in mends[0].says


@pytest.mark.parametrize("seed", range(3))
def test_corners_counted_from_the_other_end(seed):
    rng, boards, _ = taken(seed)
    some = np.isin(np.arange(PAIRS), rng.choice(PAIRS, 3, replace=False))
    mends, _ = mend_pairs(mixed(boards, replace(boards, right=boards.right[:, ::-1]), some))
    assert names(mends) == ["reversed_order"] and mends[0].pairs == tuple(np.array(boards.names)[some])


@pytest.mark.parametrize("seed", range(3))
def test_two_pairs_that_do_not_match(seed):
    rng, boards, _ = taken(seed)
    one, other = rng.choice(PAIRS, 2, replace=False)
    right = boards.right.copy()
    right[[one, other]] = right[[other, one]]
    mends, _ = mend_pairs(replace(boards, right=right))
    assert names(mends) == ["pairs_do_not_match"] and set(mends[0].pairs) == {boards.names[one], boards.names[other]}


@pytest.mark.parametrize("degrees", [0.1, 0.5, 3.0])
@pytest.mark.parametrize("seed", range(4))
def test_a_camera_that_turned(seed, degrees):
    def change(rig, rng):
        axis = rng.normal(size=3)
        rotation = turned(degrees * axis / np.linalg.norm(axis)) @ rig.rotation
        return replace(rig, rotation=rotation, translation=rotation @ rig.rotation.T @ rig.translation)

    _, boards, k = taken(seed, change=change)
    mends, _ = mend_pairs(boards)
    assert names(mends) == ["camera_moved"] and mends[0].pairs == boards.names[k:]
    before, since = mends[0].rigs
    angle = np.degrees(np.arccos((np.trace(since.rotation @ before.rotation.T) - 1) / 2))
    assert angle == pytest.approx(degrees, rel=0.1, abs=0.03)


@pytest.mark.parametrize("mm", [0.5, 5.0])
@pytest.mark.parametrize("seed", range(3))
def test_a_camera_that_was_pushed(seed, mm):
    def change(rig, rng):
        push = rng.normal(size=3)
        return replace(rig, translation=rig.translation + mm * push / np.linalg.norm(push))

    _, boards, k = taken(seed, change=change)
    mends, _ = mend_pairs(boards)
    assert names(mends) == ["camera_moved"] and mends[0].pairs == boards.names[k:]


@pytest.mark.parametrize("percent", [0.3, 3.0])
@pytest.mark.parametrize("side", [0, 1])
@pytest.mark.parametrize("seed", range(2))
def test_a_camera_that_zoomed(seed, side, percent):
    def change(rig, rng):
        matrices = [matrix.copy() for matrix in rig.matrices]
        matrices[side][[0, 1], [0, 1]] *= 1 + percent / 100
        return replace(rig, matrices=tuple(matrices))

    _, boards, k = taken(seed, change=change)
    mends, _ = mend_pairs(boards)
    assert names(mends) == ["camera_zoomed"] and mends[0].pairs == boards.names[k:]
    assert f"the {('left', 'right')[side]} camera" in mends[0].says
    assert float(re.search(r"([+-][\d.]+) %", mends[0].says)[1]) == pytest.approx(percent, abs=0.05)


@pytest.mark.parametrize("px", [0.5, 3.0, 12.0])
@pytest.mark.parametrize("seed", slow_after_first(0, 1, 2))
def test_pictures_that_slip_as_a_whole(seed, px):
    rng, boards, _ = taken(seed)
    slipped = {side: getattr(boards, side) + rng.normal(0, px, (PAIRS, 1, 2)) for side in ("left", "right")}
    mends, _ = mend_pairs(replace(boards, **slipped))
    assert names(mends) == ["stabilised"]


@pytest.mark.parametrize("seed", slow_after_first(0, 1, 2))
def test_lenses_that_five_numbers_do_not_describe(seed):
    """A few tenths of a pixel that hang on the place in the picture, and sharp corners: the pairs belong together."""
    rng = np.random.default_rng([seed, 77])
    rig, corners = known_rig(rng), bent_board(rng, 0.4)
    boards = seen(hold(rng, rig, corners, PAIRS, noise_px=0.02), rig)
    bumps = rng.uniform(0, rig.size, (2, 6, 2)), rng.normal(0, 0.3, (2, 6, 2))
    bent = {}
    for side, places, by in zip(("left", "right"), *bumps, strict=True):
        pixels = getattr(boards, side)
        near = np.exp(-(((pixels[:, :, None] - places) / (0.25 * rig.size[0])) ** 2).sum(-1) / 2)
        bent[side] = pixels + near @ by
    assert names(mend_pairs(replace(boards, **bent))[0]) == []


@pytest.mark.parametrize(("mm", "degrees"), [(0.5, 0.2), (2.0, 1.0), (8.0, 3.0)])
@pytest.mark.parametrize("seed", slow_after_first(0, 1, 2))
def test_boards_that_move_between_the_two_pictures(seed, mm, degrees):
    """A hand moves a board and turns it: no shift of a picture explains that."""
    rng = np.random.default_rng([seed, 3])
    rig, corners = known_rig(rng), bent_board(rng, 0.4)
    first = hold(rng, rig, corners, PAIRS)
    turn_of = {k: turned(rng.normal(0, degrees, 3)) for k in range(PAIRS)}
    right = []
    for k, view in enumerate(first):
        lens = rig.matrices[0], rig.distortions[0]
        _, turn, place = cv2.solvePnP(corners, view.left, *lens)
        there = (corners - corners.mean(0)) @ turn_of[k].T + corners.mean(0) + rng.normal(0, mm, 3)
        right.append(rig.see(there @ cv2.Rodrigues(turn)[0].T + place.ravel())[1])
    boards = seen(first, rig)
    moved = replace(boards, right=np.array(right) + rng.normal(0, 0.04, boards.right.shape))
    assert "not_together" in names(mend_pairs(moved)[0]) and "stabilised" not in names(mend_pairs(moved)[0])


@pytest.mark.parametrize(
    ("focal_px", "bent"), [(600, [-0.4, 0.2, 0, 0, 0]), (450, [-0.3, 0.1, 0, 0, 0]), (400, [-0.28, 0.08, 0, 0, -0.005])]
)
def test_a_rig_is_no_millimetre_apart_from_itself(focal_px, bent):
    """Wide lenses bend their rims so much that a few rounds do not undo it."""
    lens = np.array([focal_px, focal_px, 320, 240, *bent])
    rig = Rig(lens, lens, np.eye(3), np.array([-100.0, 0, 0]))
    assert apart_mm(rig, rig, (640, 480), 1000.0) < 1e-3


def test_two_faults_at_once():
    _, boards, _ = taken(2)
    across, down = BOARD.grid
    flipped = (boards.right * [-1, 1] + [boards.size[0] - 1, 0]).reshape(PAIRS, down, across, 2)[:, :, ::-1]
    both = replace(boards, names=boards.names[1:], left=boards.left[1:], right=flipped.reshape(PAIRS, -1, 2)[:-1])
    assert set(names(mend_pairs(both)[0])) == {"pairs_shifted", "mirrored"}


# Measured numbers


def measured(seed, count=14):
    """Places as cameras tell them, and the table of a ruler: 8 in a plane, 6 on the way towards the cameras."""
    rng = np.random.default_rng(seed)
    x, y = rng.uniform(-250, 250, count), rng.uniform(60, 300, count)
    depth = np.where(np.arange(count) < 8, 1000.0, rng.uniform(600, 1500, count))
    table = np.column_stack([x, y, depth])
    bench = table * [1, 1, -1]
    points = (bench - [40, 150, 0]) @ np.diag([1, -1, -1]) @ turned([4, -6, 2]).T
    return points + rng.normal(0, 0.4, points.shape), (table + rng.normal(0, 0.5, table.shape)).round(), np.ones(count)


SETS = ["position"] * 8 + ["depth"] * 6


@pytest.mark.parametrize("seed", range(8))
def test_a_good_table_is_taken_as_it_is(seed):
    points, table, deep = measured(seed)
    best = likeliest_table(points, table, deep, SETS)
    assert best.name == "as_is" and best.placed.off.max() < 4


@pytest.mark.parametrize(
    ("name", "what", "spoilt"),
    [
        ("columns", "y, x, depth", lambda t: t[:, [1, 0, 2]]),
        ("columns", "depth, x, y", lambda t: t[:, [1, 2, 0]]),
        ("sign", "y", lambda t: t * [1, -1, 1]),
        ("sign", "x", lambda t: t * [-1, 1, 1]),
        ("unit", "centimetres", lambda t: t / 10),
        ("unit", "inches", lambda t: (t / 25.4).round(2)),
        ("unit_of_column", "depth in centimetres", lambda t: t / [1, 1, 10]),
        ("unit_of_column", "x and y in centimetres", lambda t: t / [10, 10, 1]),
        ("origin", "depth", lambda t: t + np.outer(np.array(SETS) == "depth", [0, 0, 30])),
        ("scale", "", lambda t: t * 1.03),
    ],
)
@pytest.mark.parametrize("seed", range(3))
def test_a_mistake_in_a_whole_table(seed, name, what, spoilt):
    points, table, deep = measured(seed)
    best = likeliest_table(points, spoilt(table), deep, SETS)
    assert best.name == name
    assert float(best.what) == pytest.approx(1.03, abs=0.002) if name == "scale" else best.what.startswith(what)
    assert best.placed.off.max() < 12


@pytest.mark.parametrize(
    ("wrong", "right", "what"),
    [
        ([100, 200, 72], [100, 200, 752], "a digit is missing"),
        ([100, 200, 7752], [100, 200, 752], "a digit too many"),
        ([100, 200, 572], [100, 200, 752], "two digits are exchanged"),
        ([-100, 200, 752], [100, 200, 752], "another sign"),
        ([10, 20, 75], [100, 200, 752], "it is in centimetres"),
        ([200, 100, 752], [100, 200, 752], "its columns are exchanged"),
        ([100, 200, 1.104], [100, 200, 1104], "a point between the thousands"),
        ([100, 200, 782], [100, 200, 752], None),
    ],
)
def test_slips_of_the_hand(wrong, right, what):
    told = slip_of(np.array(wrong, float), np.array(right) + 0.7, np.ones(3))
    assert told is None if what is None else what in told


def test_one_wrong_line_does_not_move_the_others():
    points, table, deep = measured(3)
    table[4, 2] += 300
    placed = place(points, table, deep)
    assert placed.off[4] > 250 and np.delete(placed.off, 4).max() < 4


# Whole recordings


@pytest.fixture(scope="module")
def third_rig():
    return open_recording("third_rig")


@pytest.mark.parametrize("name", ["bench", "second_rig", "third_rig"])
def test_the_shipped_recordings_are_clean(name):
    checkup = check_recording(open_recording(name))
    assert checkup.verdict == "clean" and {f.name for f in checkup.findings} <= {"corners_wrong"}
    assert 0.5 < checkup.clean_mm < 5


def test_real_pictures_get_a_clean_bill(real_pictures, tmp_path):
    chess = real_pictures / "stereo_chessboard"
    board = Board(11, 8, 12.0)
    recording = import_images(chess / "leftPic*.jpg", chess / "rightPic*.jpg", board, tmp_path / "real")
    checkup = check_recording(recording)
    assert checkup.verdict == "clean" and {f.name for f in checkup.findings} <= {"corners_wrong"}


@pytest.mark.parametrize("fault", FAULTS)
def test_each_fault_is_named_first(fault, third_rig, tmp_path):
    checkup = check_recording(spoil(third_rig, tmp_path / "spoilt", [fault], seed=1))
    assert checkup.findings[0].name == fault, [f.says for f in checkup.findings]
    for finding in checkup.findings:
        assert finding.says.endswith(".") and finding.advice.endswith(".")
        # A ball that is judged by a wrong size may be lost, which costs a sample and no millimetres
        assert finding.severity == STOPS or finding.does_mm is not None or finding.name == "ball_lost"


def test_what_a_moved_camera_costs_is_what_it_does(third_rig, tmp_path):
    """The cost told is the distance between the places that the cameras before and after it tell."""
    checkup = check_recording(spoil(third_rig, tmp_path / "spoilt", ["camera_moved"], seed=4))
    finding = checkup.findings[0]
    assert finding.severity == COSTS and checkup.verdict == "wanting" and 10 < finding.does_mm < 1000
    assert finding.evidence.marked and dict(finding.evidence.values)[finding.evidence.marked[0]] > 1


def test_both_of_two_faults_are_named(third_rig, tmp_path):
    both = {"pairs_shifted", "typing_slip"}
    checkup = check_recording(spoil(third_rig, tmp_path / "spoilt", sorted(both), seed=2))
    assert both <= {finding.name for finding in checkup.findings}


def test_a_wrong_colour_hides_no_other_fault_of_the_balls(third_rig, tmp_path):
    """What is to be mended is told at once, and not one thing after the other."""
    spoilt = spoil(third_rig, tmp_path / "spoilt", ["color_wrong", "ball_diameter", "typing_slip"], seed=1)
    checkup = check_recording(spoilt)
    assert {f.name for f in checkup.findings if f.severity != NOTE} == {"color_wrong", "ball_diameter", "typing_slip"}
    assert "orange" in checkup.findings[0].says and "There are 3 things to mend." in checkup.says


def test_a_recording_without_boards_or_balls_is_looked_at_as_far_as_it_goes(tmp_path, third_rig):
    spoilt = spoil(third_rig, tmp_path / "spoilt", [])
    for name in ("position", "depth"):
        (spoilt.path / name / "measured.csv").unlink()
    checkup = check_recording(spoilt)
    assert checkup.verdict == "clean" and checkup.depth_mm == 1000
    assert check_recording(open_recording("clutter")).verdict == "clean"


def test_there_is_no_such_fault(third_rig, tmp_path):
    with pytest.raises(RecordingError, match="no fault 'nonsense'"):
        spoil(third_rig, tmp_path / "spoilt", ["nonsense"])
    assert not (tmp_path / "spoilt").exists()


# What is said


def test_the_weightiest_comes_first():
    found = [
        Finding("a", "", "", does_mm=3.0, severity=NOTE), Finding("b", "", "", does_mm=5.0, severity=COSTS),
        Finding("c", "", "", severity=STOPS), Finding("d", "", "", does_mm=9.0, severity=COSTS),
    ]  # fmt: skip
    assert [finding.name for finding in in_order(found)] == ["c", "d", "b", "a"]
    assert Checkup(in_order(found), 2.0, 1000).verdict == "wanting"
    assert "3 things" in Checkup(in_order(found), 2.0, 1000).says


def test_the_command(third_rig, tmp_path, capsys):
    spoilt = spoil(third_rig, tmp_path / "spoilt", ["typing_slip"], seed=3)
    report, told = tmp_path / "check.html", tmp_path / "check.json"
    assert cli.main(["check", str(spoilt.path), "--report", str(report), "--json", str(told)]) == 1
    said = capsys.readouterr().out
    assert "Typing slip: costs accuracy" in said and "verdict: wanting" in said and "Try: " in said
    facts = json.loads(told.read_text())
    assert facts["verdict"] == "wanting"
    assert set(facts["findings"][0]) == {"name", "severity", "files", "says", "does_mm", "try"}
    assert "<img" in report.read_text() and "a digit" in report.read_text()
    assert cli.main(["check", "third_rig", "--json", "-"]) == 0
    assert json.loads(capsys.readouterr().out)["verdict"] == "clean"


def test_the_command_says_what_comes_next(third_rig, tmp_path, capsys):
    mine = tmp_path / "mine"
    for set_name, then in (
        ("calibration", "record {} --set position"),
        ("position", "record {} --set depth"),
        ("depth", "demo {}"),
    ):
        shutil.copytree(third_rig.path / set_name, mine / set_name)
        shutil.copy(third_rig.path / "recording.json", mine)
        assert cli.main(["check", str(mine)]) == 0
        assert then.format(mine) in capsys.readouterr().out.splitlines()[-1]


def test_a_report_that_cannot_be_written_is_refused_at_once(capsys, tmp_path):
    assert cli.main(["check", "bench", "--report", str(tmp_path)]) == 2
    assert str(tmp_path) in capsys.readouterr().err


def slip_as_told(patient):
    """The doctor's finding of a slip, and the number that it would expect there."""
    slip = next(f for f in check_recording(patient).findings if f.name == "typing_slip")
    return slip.files, float(re.search(r"should be about (\d+)", slip.says).group(1))


def test_patients_have_what_they_are_said_to_have(tmp_path):
    """Each has its one mistake, where `healthy` says; and two admissions are alike."""
    well, (a, b, c) = healthy(), admit(tmp_path)
    assert (a.board.columns, a.board.rows) == (well.board.columns + 1, well.board.rows + 1)
    assert b.board == c.board == well.board and len(b.pairs("calibration")) == well.pairs
    moved = next(f for f in check_recording(b).findings if f.name == "camera_moved")
    assert moved.files[0] == f"calibration/{well.since:03d}"
    files, about = slip_as_told(c)
    assert files == (well.slipped,) and about == pytest.approx(well.depth_mm, abs=5) and about != well.depth_mm
    with pytest.raises(RecordingError, match="there already"):
        admit(tmp_path)


@pytest.mark.parametrize("seat", slow_after_first(1, 2, 3, 4))
def test_each_seat_has_a_slip_of_its_own(seat, tmp_path):
    """Another line for each, where one number alone is what was typed with a digit more and what the cameras say."""
    well = healthy(seat)
    assert well.slipped not in {healthy(other).slipped for other in (None, *range(1, 5)) if other != seat}
    files, about = slip_as_told(admit(tmp_path, seat)[2])
    assert files == (well.slipped,)
    near = [number for number in _with_a_digit(f"{well.typed_mm:.0f}") if abs(number - about) < 8]
    assert near == [well.depth_mm]


# Tables of which one set is wrong, tables that fit nowhere, cameras that moved after the boards


def of_one_set(name, change):
    """A change of the lines of one set alone."""
    return lambda table: np.where((np.array(SETS) == name)[:, None], change(table), table)


@pytest.mark.parametrize("set_name", ["position", "depth"])
@pytest.mark.parametrize(
    ("name", "what", "spoilt"),
    [
        ("columns", "y, x, depth", lambda t: t[:, [1, 0, 2]]),
        ("sign", "y", lambda t: t * [1, -1, 1]),
        ("unit", "centimetres", lambda t: t / 10),
        ("unit_of_column", "depth in centimetres", lambda t: t / [1, 1, 10]),
        ("origin", "depth", lambda t: t + [0, 0, 30]),
        ("origin", "y", lambda t: t + [0, 150, 0]),
    ],
)
def test_a_mistake_in_the_table_of_one_set(set_name, name, what, spoilt):
    points, table, deep = measured(5)
    best = likeliest_table(points, of_one_set(set_name, spoilt)(table), deep, SETS)
    assert best.name == name and best.what.startswith(what)
    if name == "origin":  # which of the two is right cannot be known, but by how much they differ
        assert abs(float(best.what.split()[1])) == pytest.approx(30 if what == "depth" else 150, abs=2)
    else:
        assert best.sets == (set_name,) and best.placed.off.max() < 12


def test_a_mistake_in_two_tables_of_three():
    points, table, deep = measured(5, 22)
    sets = [*SETS, *["evaluation"] * 8]
    wrong = np.where((np.array(sets) == "evaluation")[:, None], table, table / 10)
    best = likeliest_table(points, wrong, deep, sets)
    assert (best.name, best.what, best.sets) == ("unit", "centimetres", ("depth", "position"))


def test_a_place_that_is_known_badly_along_its_ray_counts_less_along_it():
    """Far aside, what is wrong with the depth moves x as much as depth."""
    points = np.random.default_rng(7).uniform([-300, -300, 700], [300, 300, 1400], (14, 3))
    points[0] = [-700, 0, 1000]
    ray, across = np.array([-0.7, 0, 1]) / np.hypot(0.7, 1), np.array([1, 0, 0.7]) / np.hypot(0.7, 1)
    first = np.eye(14)[0]
    for way, off in ((ray, 4), (across, 40)):
        table = points * [1, -1, 1] + np.outer(first, 40 * way)
        assert place(points, table, np.where(first, 10, 1)).off[0] == pytest.approx(off, abs=0.5)


@pytest.mark.parametrize(
    ("what", "spoilt"),
    [("y, −x, depth", lambda t: t[:, [1, 0, 2]] * [-1, 1, 1]), ("x and depth", lambda t: t * [-1, 1, -1])],
)
def test_a_table_that_is_turned_as_a_whole_is_not_taken_as_it_is(what, spoilt):
    points, table, deep = measured(6)
    assert likeliest_table(points, spoilt(table), deep, SETS).what == what


def rewrite(recording, set_name, change):
    """Change the numbers of one table of a copy."""
    path = recording.path / set_name / "measured.csv"
    lines = path.read_text().splitlines()
    rows = [line.split(",") for line in lines[1:]]
    numbers = change(np.array([row[1:4] for row in rows], float))
    new = [",".join([row[0], *(f"{n:g}" for n in line), *row[4:]]) for row, line in zip(rows, numbers, strict=True)]
    path.write_text("\n".join([lines[0], *new]) + "\n")


def test_what_is_said_of_one_table_names_it_alone(third_rig, tmp_path):
    spoilt = spoil(third_rig, tmp_path / "cm", [])
    rewrite(spoilt, "position", lambda t: t / 10)
    (finding,) = check_recording(spoilt).findings
    assert finding.name == "unit" and "of the set position fit when they are read as centimetres" in finding.says
    assert {file.split("/")[0] for file in finding.files} == {"position"}
    spoilt = spoil(third_rig, tmp_path / "plane", [])
    rewrite(spoilt, "depth", lambda t: t + [0, 0, 30])  # too large: its plane lies farther from the balls
    says = check_recording(spoilt).findings[0].says
    assert re.search("that of depth lies (29|30|31) mm farther|that of position lies (29|30|31) mm nearer", says), says


def test_a_table_that_fits_nowhere_stops(third_rig, tmp_path):
    rng = np.random.default_rng(4)
    spoilt = spoil(third_rig, tmp_path / "nowhere", [])
    for name in ("position", "depth"):
        rewrite(spoilt, name, lambda t: rng.uniform((-300, 0, 500), (300, 400, 1500), t.shape).round())
    checkup = check_recording(spoilt)
    assert [f.name for f in checkup.findings] == ["table_unfit"] and checkup.verdict == "wanting"
    spoilt = spoil(third_rig, tmp_path / "one", [])
    rewrite(spoilt, "position", lambda t: rng.uniform((-300, 0, 500), (300, 400, 1500), t.shape).round())
    finding = check_recording(spoilt).findings[0]
    assert finding.name == "table_unfit" and finding.severity == STOPS and "of the set position" in finding.says


@pytest.mark.parametrize(("axis", "degrees"), [(1, 0.5), (0, 0.6)], ids=["sideways", "up"])
def test_a_camera_that_moved_between_the_boards_and_the_balls(third_rig, tmp_path, axis, degrees):
    """The right camera's pictures of the balls, turned as its camera was."""
    spoilt = spoil(third_rig, tmp_path / "moved", [])
    matrix = np.array(third_rig.truth["cameras"]["right"]["matrix"])
    turn = matrix @ turned(np.eye(3)[axis] * degrees) @ np.linalg.inv(matrix)
    for name in ("position", "depth"):
        for file in (spoilt.path / name / "right").iterdir():
            image = cv2.imread(str(file))
            moved = cv2.warpPerspective(image, turn, image.shape[1::-1], borderMode=cv2.BORDER_REPLICATE)
            cv2.imwrite(str(file), moved, [cv2.IMWRITE_JPEG_QUALITY, 97])
    finding = check_recording(spoilt).findings[0]
    assert finding.name == "camera_moved" and "between the boards and the balls" in finding.says
    assert "take the boards again" in finding.advice and "later pairs" not in finding.advice  # no boards are later
    if axis == 1:
        assert float(finding.says.split("sideways by ")[1].split("°")[0]) == pytest.approx(degrees, abs=0.05)


@pytest.mark.parametrize(("sides", "told"), [(["right"], "the right camera's"), (["left", "right"], "both cameras'")])
def test_a_camera_that_focused_anew_between_the_boards_and_the_balls(bench, tmp_path, sides, told):
    spoilt = spoil(bench, tmp_path / "zoomed", [])
    for file in (
        file for name in ("position", "depth") for side in sides for file in (spoilt.path / name / side).iterdir()
    ):
        image = cv2.imread(str(file))
        middle = (np.array(image.shape[1::-1]) - 1) / 2
        grown = cv2.warpAffine(
            image, cv2.getRotationMatrix2D(middle, 0, 1.02), image.shape[1::-1], borderMode=cv2.BORDER_REPLICATE
        )
        cv2.imwrite(str(file), grown, [cv2.IMWRITE_JPEG_QUALITY, 97])
    finding = check_recording(spoilt).findings[0]
    assert finding.name == "camera_zoomed" and finding.severity == COSTS and told in finding.says
    assert float(re.search(r"([\d.]+) % longer", finding.says)[1]) == pytest.approx(2.0, abs=0.2)
    assert "later pairs" not in finding.advice  # no boards are later


def test_what_is_endless_is_told_as_unknown():
    finding = Finding("camera_moved", "It moved.", "Fix it.", does_mm=float("inf"))
    assert severity_of(float("inf"), float("inf")) == STOPS and finding.facts()["does_mm"] is None
    assert json.dumps(Checkup((finding,), float("inf"), 1000.0).facts(), allow_nan=False)


def test_squares_and_tables_in_one_wrong_unit_are_not_the_balls_fault(third_rig, tmp_path):
    spoilt = spoil(third_rig, tmp_path / "cm", [])
    for name in ("position", "depth"):
        rewrite(spoilt, name, lambda t: t / 10)
    path = spoilt.path / "recording.json"
    facts = json.loads(path.read_text())
    facts["board"]["square_mm"] /= 10
    path.write_text(json.dumps(facts))
    finding = check_recording(open_recording(spoilt.path)).findings[0]
    assert finding.name == "square_unit" and "in centimetres, and the measured places as well" in finding.says


@pytest.mark.parametrize(
    "times, so",
    [
        (10, "square_mm is in tenths of a millimetre"),
        (0.1, "square_mm is in centimetres"),
        (3.936, "the squares are 2"),
        (1 / 25.4, "square_mm is in inches"),
    ],
)
def test_squares_many_times_too_large_or_too_small_are_the_one_thing_to_mend(bench, tmp_path, times, so):
    """All lengths of the cameras are wrong then; what the boards lack in millimetres is not told."""
    spoilt = spoil(bench, tmp_path / "mine", [])
    path = spoilt.path / "recording.json"
    facts = json.loads(path.read_text())
    facts["board"]["square_mm"] *= times
    path.write_text(json.dumps(facts))
    spoilt = open_recording(spoilt.path)
    findings = check_recording(spoilt).findings
    assert findings[0].name == "square_unit" and so in findings[0].says
    assert {finding.name for finding in findings[1:]} <= {"corners_wrong"}
    unusual = any("Is square_mm in" in reason for reason in calibrate_recording(spoilt).reasons)
    assert unusual == (times != 3.936)  # half a metre between the cameras may be
    if times == 10:
        with pytest.raises(StereoLabError, match="square_mm of the board"):
            Localizer.fit(spoilt)


def with_squares(recording, folder, times):
    """A copy, its squares told as so many times longer."""
    spoilt = spoil(recording, folder, [])
    facts = json.loads((folder / "recording.json").read_text())
    facts["board"]["square_mm"] *= times
    (folder / "recording.json").write_text(json.dumps(facts))
    return open_recording(spoilt.path)


def test_squares_in_metres_beside_boards_alone_stop_everything(bench, tmp_path):
    shutil.copytree(bench.path / "calibration", tmp_path / "mine" / "calibration")
    shutil.copy(bench.path / "recording.json", tmp_path / "mine")
    first = check_recording(with_squares(open_recording(tmp_path / "mine"), tmp_path / "told", 0.001)).findings[0]
    assert (first.name, first.severity, first.does_mm) == ("square_unit", "stops", None)  # not 999000 mm


@pytest.mark.parametrize("times", [0.98, 1.04])
def test_of_squares_that_are_a_little_wrong_it_is_said_what_the_fit_makes_of_them(third_rig, tmp_path, times):
    """The localizer fits a scale: by the cameras alone a ball is centimetres off, on the bench hardly."""
    wrong = with_squares(third_rig, tmp_path / "wrong", times)
    (finding,) = check_recording(wrong).findings
    alone = 100 * abs(1 - times)  # a square that is told too short makes all distances too short by as much
    assert finding.name == "square_scale" and "as long as it stands on these balls" in finding.says
    assert f"% {'farther apart' if times < 1 else 'nearer together'} than" in finding.says and "-" not in finding.says
    assert float(re.search(r"distances are ([\d.]+) % wrong", finding.says)[1]) == pytest.approx(alone, abs=0.3)
    fits = [Localizer.fit(recording) for recording in (wrong, third_rig)]
    balls = [s.pair for s in third_rig.samples("evaluation")][::3]
    found = [[fit.locate(pair.left, pair.right) for pair in balls] for fit in fits]
    places = np.array([[(p.x_mm, p.y_mm, p.depth_mm) for p in some] for some in found])
    off = np.percentile(np.linalg.norm(places[0] - places[1], axis=1), 95)
    depth_mm = calibrate_recording(third_rig).depth_mm
    assert finding.severity == COSTS and finding.does_mm == pytest.approx(alone / 100 * depth_mm, abs=0.004 * depth_mm)
    assert 0.1 < off < finding.does_mm / 4


@pytest.mark.parametrize("times", [0.1, 0.78])
def test_squares_by_which_no_ball_is_found_stop_everything(third_rig, tmp_path, times):
    wrong = with_squares(third_rig, tmp_path / "wrong", times)
    finding = check_recording(wrong).findings[0]
    assert finding.name == ("square_unit" if times == 0.1 else "square_scale")
    assert finding.severity == STOPS and finding.does_mm is None and "found in 0 of 14 measured pairs" in finding.says
    with pytest.raises(StereoLabError, match="found in 0 of 14"):
        Localizer.fit(wrong)


def test_wrong_squares_are_told_whole_where_no_fit_takes_them_out(third_rig, tmp_path):
    """With the set alone that judges there is nothing to fit on."""
    mine = whole(third_rig, tmp_path / "mine")
    for name in ("position", "depth"):
        shutil.rmtree(mine.path / name)
    facts = json.loads((mine.path / "recording.json").read_text())
    facts["board"]["square_mm"] *= 0.96
    (mine.path / "recording.json").write_text(json.dumps(facts))
    finding = next(f for f in check_recording(open_recording(mine.path)).findings if f.name == "square_scale")
    assert finding.severity == COSTS and finding.does_mm > 30 and "the fit" not in finding.says


def test_pictures_without_a_line_are_named(third_rig, tmp_path):
    spoilt = spoil(third_rig, tmp_path / "mine", [])
    table = spoilt.path / "depth" / "measured.csv"
    lines = table.read_text().splitlines()
    table.write_text("\n".join([*lines[:2], *lines[4:]]) + "\n")
    (finding,) = (f for f in check_recording(open_recording(spoilt.path)).findings if f.name == "no_line")
    assert finding.says.startswith("2 of ") and len(finding.files) == 2 and finding.files[0].startswith("depth/")


@pytest.mark.parametrize("factor, unit", [(10, "centimetres"), (25.4, "inches")])
def test_a_ball_and_tables_in_another_unit_are_not_the_squares_fault(third_rig, tmp_path, factor, unit):
    """Who has put right the squares, and not yet the rest, is not sent back."""
    spoilt = spoil(third_rig, tmp_path / "mine", [])
    for name in ("position", "depth"):
        rewrite(spoilt, name, lambda t: t / factor)
    path = spoilt.path / "recording.json"
    facts = json.loads(path.read_text())
    facts["ball"]["diameter_mm"] /= factor
    path.write_text(json.dumps(facts))
    finding = check_recording(open_recording(spoilt.path)).findings[0]
    assert finding.name == "unit" and f"they are in {unit}. " in finding.says and "diameter_mm" in finding.advice
    assert finding.severity == STOPS and "found in 0 of 14 measured pairs" in finding.says  # by its size


def test_one_cameras_pictures_on_both_sides_are_called_that(bench, tmp_path):
    mine = tmp_path / "mine"
    for side in ("left", "right"):
        shutil.copytree(bench.path / "calibration" / "left", mine / "calibration" / side)
    shutil.copy(bench.path / "recording.json", mine)
    assert [finding.name for finding in check_recording(open_recording(mine)).findings][:1] == ["same_pictures"]


def test_a_calibration_without_the_boards_that_it_was_made_of_is_told(bench, tmp_path, capsys):
    """Whether it is theirs still, nobody can tell; one that was taken over from elsewhere has none to be held against."""
    mine = tmp_path / "mine"
    shutil.copytree(bench.path / "position", mine / "position")
    for name in ("recording.json", "calibration.json"):
        shutil.copy(bench.path / name, mine)
    recording = open_recording(mine)
    assert bench.is_calibrated and not recording.is_calibrated
    says = f"{mine / 'calibration.json'} counts only beside the boards that it was made of"
    (finding,) = check_recording(recording).findings
    assert finding.name == "no_boards" and says in finding.says
    assert cli.main(["demo", str(mine)]) == 2 and says in capsys.readouterr().err


def _misspell(mine):
    table = mine / "evaluation" / "measured.csv"
    table.write_text(table.read_text(encoding="utf-8").replace("plane", "planne"), encoding="utf-8")


def test_a_broken_picture_is_no_broken_table(bench, tmp_path):
    mine = tmp_path / "mine"
    shutil.copytree(
        bench.path, mine, ignore=shutil.ignore_patterns("evaluation", "snaps", "track", "still", "truth.json")
    )
    (mine / "depth" / "left" / "003.jpg").write_bytes(b"broken")
    found = {finding.name: finding.says for finding in check_recording(open_recording(mine)).findings}
    assert "003.jpg" in found["picture_broken"] and "table_broken" not in found


def _rename_by_camera(mine):
    for picture in (mine / "calibration").glob("*/*.jpg"):
        picture.rename(picture.with_name(f"{picture.stem}_{picture.parent.name}.jpg"))


def _keep_all_back(mine):
    table = mine / "position" / "measured.csv"
    table.write_text(table.read_text(encoding="utf-8").replace(",fit", ",check"), encoding="utf-8")


def _fit_on(set_name, count):
    """So many lines of a table say fit, and the others check."""

    def change(mine):
        table = mine / set_name / "measured.csv"
        head, *rows = table.read_text(encoding="utf-8").splitlines()
        told = [f"{row.rpartition(',')[0]},{'fit' if k < count else 'check'}" for k, row in enumerate(rows)]
        table.write_text("\n".join([head, *told]) + "\n", encoding="utf-8")

    return change


def _save_16_bits(mine):
    picture = mine / "position" / "left" / "000.jpg"
    cv2.imwrite(str(picture.with_suffix(".png")), cv2.imread(str(picture)).astype(np.uint16) * 257)
    picture.unlink()


def _in_black_and_white(mine):
    for picture in (mine / "position").glob("*/*.jpg"):
        cv2.imwrite(str(picture), cv2.cvtColor(cv2.imread(str(picture), cv2.IMREAD_GRAYSCALE), cv2.COLOR_GRAY2BGR))


@pytest.mark.parametrize(
    ("spoil", "name", "says"),
    [
        (lambda mine: (mine / "evaluation" / "left" / "003.jpg").write_bytes(b"broken"), "picture_broken", "evaluation/left/003.jpg"),
        (lambda mine: (mine / "calibration" / "left" / "003.jpg").write_bytes(b""), "picture_broken", "calibration/left/003.jpg"),
        (_save_16_bits, "picture_format", "has 16 bits a channel"),
        (_in_black_and_white, "picture_grey", "is a grey picture; the ball is found by its colour. Set the camera to colour. So are"),
        (lambda mine: shutil.copy(mine / "position" / "left" / "000.jpg", mine / "position" / "left" / "000.png"), "name_twice", "Keep one."),
        (lambda mine: [file.unlink() for file in (mine / "depth" / "left").iterdir()], "no_pictures", "holds no pictures"),
        (lambda mine: (mine / "evaluation" / "right" / "003.jpg").unlink(), "half_missing", "003"),
        (lambda mine: (mine / "position" / "measured.csv").unlink(), "no_table", "no measured.csv"),
        (lambda mine: shutil.rmtree(mine / "depth" / "right"), "half_missing", "left camera alone"),
        (_misspell, "table_broken", "expected plane or volume"),
        (_rename_by_camera, "names_differ", "one name"),
        (_keep_all_back, "none_to_fit", "no line says fit"),
        (_fit_on("position", 1), "too_few_to_fit", "1 line says fit in the column use, and the paper's way cannot be fitted: it needs 2"),
        (_fit_on("depth", 2), "too_few_to_fit", "2 lines say fit in the column use, and the paper's way cannot be fitted: it needs 3"),
        (lambda mine: (mine / "position" / "measured.csv").write_bytes(b"PK\x03\x04\x14"), "misnamed", "it is a spreadsheet"),
    ],
)  # fmt: skip
def test_what_would_stop_the_chain_is_told_before(third_rig, tmp_path, spoil, name, says):
    mine = tmp_path / "mine"
    shutil.copytree(third_rig.path, mine, ignore=shutil.ignore_patterns("truth.json"))
    spoil(mine)
    found = check_recording(open_recording(mine))
    assert says in {finding.name: finding.says for finding in found.findings}[name]
    assert found.verdict == ("clean" if name == "no_table" else "wanting")


def test_where_all_is_fitted_on_check_and_demo_say_that_nothing_judges(third_rig, tmp_path, capsys):
    mine = spoil(third_rig, tmp_path / "mine", [])
    for name, count in (("position", 8), ("depth", 6)):
        _fit_on(name, count)(mine.path)
    (finding,) = check_recording(mine).findings
    assert (finding.name, finding.severity) == ("none_to_judge", NOTE)
    assert cli.main(["demo", str(mine.path), "--report", str(tmp_path / "demo.html")]) == 0
    said = capsys.readouterr().out
    assert "nothing judges the places" in said and "are the judges" not in said


def test_a_small_set_that_loses_its_balls_is_no_note(bench, tmp_path):
    """The eight pairs of position are few of seventy, and all that x and y are fitted on."""
    mine = whole(bench, tmp_path / "mine")
    for picture in (mine.path / "position" / "right").iterdir():  # as a camera would see it that points elsewhere
        cv2.imwrite(str(picture), np.roll(cv2.imread(str(picture)), 40, axis=0))
    lost = next(
        f for f in check_recording(mine).findings if f.files and set(f.files) <= {f"position/{k:03d}" for k in range(8)}
    )
    assert lost.severity == COSTS and "most of the set position" in lost.says


def _both(change):
    """The pictures of a pair, each changed in the same way."""
    return lambda left, right: (change(left), change(right))


@pytest.mark.parametrize(("name", "says", "spoilt"), [
    ("cameras_exchanged", "left and right are exchanged", lambda left, right: (right, left)),
    ("both_mirrored", "both pictures are mirror images", _both(lambda i: i[:, ::-1])),
    ("both_upside_down", "both pictures are upside down", _both(lambda i: i[::-1, ::-1])),
    ("mirrored", "the right picture is a mirror image", lambda left, right: (left, right[:, ::-1])),
    ("upside_down", "the left picture is upside down", lambda left, right: (left[::-1, ::-1], right)),
])  # fmt: skip
@pytest.mark.parametrize("pairs", [("position/003",), ("depth/000", "position/001", "position/005")])
def test_single_pairs_that_were_put_down_wrongly(third_rig, tmp_path, pairs, name, says, spoilt):
    mine = spoil(third_rig, tmp_path / "mine", []).path
    for pair in pairs:
        files = [mine / f"{pair.replace('/', f'/{side}/')}.jpg" for side in ("left", "right")]
        for file, image in zip(files, spoilt(*(cv2.imread(str(file)) for file in files)), strict=True):
            cv2.imwrite(str(file), image, [cv2.IMWRITE_JPEG_QUALITY, 95])
    (finding,) = check_recording(open_recording(mine)).findings
    assert (finding.name, finding.severity, set(finding.files)) == (name, COSTS, set(pairs))
    assert says in finding.says and pairs[0] in finding.says


def test_a_pair_with_one_picture_on_both_sides(third_rig, tmp_path):
    position = spoil(third_rig, tmp_path / "mine", []).path / "position"
    shutil.copy(position / "left" / "003.jpg", position / "right" / "003.jpg")
    (finding,) = check_recording(open_recording(tmp_path / "mine")).findings
    assert (finding.name, finding.severity, finding.files) == ("same_pictures", COSTS, ("position/003",))


def test_boards_that_tell_little_accuse_no_square(third_rig, tmp_path):
    mine = whole(third_rig, tmp_path / "mine")
    for side in ("left", "right"):
        poses = [(mine.path / "calibration" / side / f"00{k}.jpg").read_bytes() for k in (3, 5)]
        rng = np.random.default_rng(1)
        for k, file in enumerate(sorted((mine.path / "calibration" / side).glob("*.jpg"))):
            image = cv2.imdecode(np.frombuffer(poses[k % 2], np.uint8), 1)
            cv2.imwrite(str(file), np.clip(image + rng.normal(0, 2, image.shape), 0, 255).astype(np.uint8))
    names = {finding.name for finding in check_recording(open_recording(mine.path)).findings}
    assert "one_place" in names and "square_scale" not in names


@pytest.mark.parametrize(("name", "severity"), [("red", NOTE), ("yellow", COSTS)])
def test_a_ball_of_another_name_is_told_also_where_it_is_found(third_rig, tmp_path, name, severity):
    """The name red reaches as far as an orange under warm light, and finds it; the paper's way does not. Yellow finds half."""
    wrong = whole(third_rig, tmp_path / "wrong")
    facts = json.loads((wrong.path / "recording.json").read_text(encoding="utf-8"))
    facts["ball"]["color"] = name
    (wrong.path / "recording.json").write_text(json.dumps(facts), encoding="utf-8")
    (finding,) = check_recording(open_recording(wrong.path)).findings
    assert (finding.name, finding.severity) == ("color_wrong", severity)
    assert "orange" in finding.says and f"recording.json says {name}" in finding.says


# The set that judges, and left and right exchanged in some sets alone


def whole(recording, folder):
    """A copy with all its sets, and without what its renderer told."""
    shutil.copytree(recording.path, folder, ignore=shutil.ignore_patterns("truth.json", "calibration.json"))
    return open_recording(folder)


@pytest.mark.parametrize("exchanged", [
    ("position",), ("evaluation",), ("depth", "evaluation", "position"), ("calibration",), ("calibration", "depth"),
])  # fmt: skip
def test_left_and_right_exchanged_in_some_sets(third_rig, tmp_path, exchanged):
    spoilt = whole(third_rig, tmp_path / "spoilt")
    for name in exchanged:
        one, other = (spoilt.path / name / side for side in ("left", "right"))
        one.rename(tmp_path / "x"), other.rename(one), (tmp_path / "x").rename(other)
    (finding,) = check_recording(spoilt).findings
    assert finding.name == "sides_swapped" and finding.severity == STOPS
    assert {file.split("/")[0] for file in finding.files} == set(exchanged)
    assert all(name in finding.says.split("and in the")[0] for name in exchanged) and "--swap" not in finding.advice


@pytest.mark.parametrize(("name", "change"), [
    ("unit", lambda t: t / 10), ("plane", lambda t: t + [0, 0, 30]), ("sign", lambda t: t * [1, -1, 1]),
    ("typing_slip", lambda t: t * (1 - np.outer(np.arange(len(t)) == 3, [0, 0, 0.9]))),
])  # fmt: skip
def test_the_set_that_judges_is_looked_through(third_rig, tmp_path, name, change):
    spoilt = whole(third_rig, tmp_path / "spoilt")
    rewrite(spoilt, "evaluation", change)
    (finding,) = check_recording(spoilt).findings
    assert finding.name == name and all(file.startswith("evaluation/") for file in finding.files)


@pytest.mark.parametrize("name", ["position", "depth"])
@pytest.mark.parametrize("order", [[1, 0], [5, 0, 1, 2, 3, 4]])
def test_lines_beside_each_others_pictures(third_rig, tmp_path, name, order):
    spoilt = spoil(third_rig, tmp_path / "spoilt", [])
    rewrite(spoilt, name, lambda t: t[[*order, *range(len(order), len(t))]])
    (finding,) = check_recording(spoilt).findings
    moved = [k for k, line in enumerate(order) if line != k]
    assert finding.name == "lines_exchanged" and finding.severity == COSTS
    assert finding.files == tuple(f"{name}/{k:03d}" for k in moved)
    back = order.index(moved[0])  # the line of the first picture that has another one stands there
    assert f"that of {name}/{back:03d} belongs to {name}/{moved[0]:03d}" in finding.says


@pytest.mark.parametrize(("name", "since"), [("position", 0), ("depth", 0), ("evaluation", 7)])
@pytest.mark.parametrize("side", ["left", "right"])
def test_balls_of_which_one_side_is_numbered_anew(third_rig, tmp_path, name, since, side):
    """A picture is missing on one side, and the others were renamed to fill the gap."""
    spoilt = whole(third_rig, tmp_path / "spoilt")
    one, other = (sorted((spoilt.path / name / s).iterdir()) for s in (side, "right" if side == "left" else "left"))
    one[since].unlink(), other[-1].unlink()
    for new, old in zip(one[since:], one[since + 1 :], strict=False):
        old.rename(new)
    table = spoilt.path / name / "measured.csv"
    table.write_text("\n".join(table.read_text().splitlines()[:-1]) + "\n")
    finding = check_recording(spoilt).findings[0]
    assert finding.name == "pairs_shifted" and finding.files[0] == f"{name}/{since:03d}"
    assert ("the next pair's" if side == "left" else "the previous pair's") in finding.says


def test_a_ruler_that_is_moved_in_the_middle_of_a_set(third_rig, tmp_path):
    spoilt = spoil(third_rig, tmp_path / "spoilt", [])
    rewrite(spoilt, "position", lambda t: t + np.outer(np.arange(len(t)) >= 4, [43, 27, 0]))
    (finding,) = check_recording(spoilt).findings
    assert finding.name == "moved_since" and finding.severity == COSTS and "From position/004 on all 4" in finding.says


def test_a_set_that_was_taken_with_another_zoom_is_told_once(third_rig, tmp_path):
    spoilt = whole(third_rig, tmp_path / "spoilt")
    for file in (spoilt.path / "depth").glob("*/*.jpg"):
        image = cv2.imread(str(file))
        height, width = image.shape[:2]
        nearer = image[round(0.06 * height) : round(0.94 * height), round(0.06 * width) : round(0.94 * width)]
        cv2.imwrite(str(file), cv2.resize(nearer, (width, height)))
    (finding,) = check_recording(spoilt).findings
    count = len(spoilt.samples("depth"))
    assert finding.name == "table_unfit" and finding.severity == COSTS and "same size and zoom" in finding.advice
    assert finding.says.startswith(f"All {count} places of depth are off, and ") and len(finding.files) == count


@pytest.mark.parametrize("name", ["position", "evaluation"])
def test_one_set_that_is_wrong_is_not_a_small_part_of_many_good_lines(bench, tmp_path, name):
    """Fifty-six good lines beside eight that lie on another plane."""
    spoilt = whole(bench, tmp_path / "spoilt")
    rewrite(spoilt, name, lambda t: t + [0, 0, 25])
    assert check_recording(spoilt).findings[0].name == "plane"


def test_a_set_whose_x_is_counted_from_the_other_side(third_rig, tmp_path):
    spoilt = whole(third_rig, tmp_path / "spoilt")
    rewrite(spoilt, "evaluation", lambda t: t * [-1, 1, 1] + [700, 0, 0])
    (finding,) = check_recording(spoilt).findings
    assert finding.name == "sign" and {file.split("/")[0] for file in finding.files} == {"evaluation"}
    assert re.search("they are counted from the other side, as (699|700|701) − x", finding.says), finding.says


def test_pictures_of_other_cameras_are_no_matter_of_colour(third_rig, tmp_path):
    spoilt = whole(third_rig, tmp_path / "spoilt")
    for file in (spoilt.path / "position" / "right").iterdir():  # as a camera would see it that points elsewhere
        cv2.imwrite(str(file), np.roll(cv2.imread(str(file)), 40, axis=0))
    (finding,) = check_recording(spoilt).findings
    assert finding.name == "rows_apart" and len(finding.files) >= 6


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("some", [(), ("depth",)])
def test_depths_along_the_line_of_sight(seed, some):
    points, table, deep = measured(seed)
    inside = np.isin(SETS, some or SETS)
    table[inside, 2] = np.linalg.norm(points, axis=1)[inside].round()
    best = likeliest_table(points, table, deep, SETS)
    assert (best.name, best.sets) == ("slant", some) and best.placed.off.max() < 12


def test_a_picture_that_is_there_twice(third_rig, tmp_path):
    spoilt = spoil(third_rig, tmp_path / "spoilt", [])
    for side in ("left", "right"):
        (old, new), depth = sorted((spoilt.path / "position" / side).iterdir())[2:4], spoilt.path / "depth" / side
        shutil.copy(old, new), shutil.copy(old, depth / "005.jpg")
    finding = next(f for f in check_recording(spoilt).findings if f.name == "picture_twice")
    assert finding.files == ("depth/005", "position/002", "position/003")
    assert "depth/005 and position/002 show the same pictures, to the last bit" in finding.says


def test_a_copy_on_one_side_accuses_neither_pair(third_rig, tmp_path):
    spoilt = spoil(third_rig, tmp_path / "spoilt", [])
    left = spoilt.path / "calibration" / "left"
    shutil.copy(left / "005.jpg", left / "004.jpg")
    finding = next(f for f in check_recording(spoilt).findings if f.name == "picture_twice")
    assert finding.files == ("calibration/004", "calibration/005") and "show the same left picture" in finding.says


def test_balls_numbered_anew_beside_a_mirror_image(third_rig, tmp_path):
    spoilt = spoil(third_rig, tmp_path / "spoilt", ["mirrored"])
    right = sorted((spoilt.path / "position" / "right").iterdir())
    contents = [file.read_bytes() for file in right]
    for file, content in zip(right, [*contents[1:], contents[0]], strict=True):
        file.write_bytes(content)
    assert {"mirrored", "pairs_shifted"} <= {f.name for f in check_recording(spoilt).findings}


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="pipes with names are not to be had there")
def test_a_pipe_among_the_balls_is_not_waited_for(third_rig, tmp_path):
    spoilt = spoil(third_rig, tmp_path / "spoilt", [])
    picture = spoilt.path / "position" / "left" / "003.jpg"
    picture.unlink()
    os.mkfifo(picture)
    assert "picture_broken" in {f.name for f in check_recording(spoilt).findings}


def test_squares_and_ball_in_centimetres_beside_good_tables(third_rig, tmp_path):
    spoilt = spoil(third_rig, tmp_path / "spoilt", [])
    facts = json.loads((spoilt.path / "recording.json").read_text())
    facts["board"]["square_mm"] /= 10
    facts["ball"]["diameter_mm"] /= 10
    (spoilt.path / "recording.json").write_text(json.dumps(facts))
    (finding,) = check_recording(open_recording(spoilt.path)).findings
    assert finding.name == "square_unit" and "square_mm and diameter_mm are in centimetres" in finding.says


def test_an_arm_in_centimetres(third_rig, tmp_path):
    spoilt = spoil(third_rig, tmp_path / "spoilt", [])
    facts = json.loads((spoilt.path / "recording.json").read_text())
    arm = {**facts["arm"], "l1_mm": facts["arm"]["l1_mm"] / 10, "l2_mm": facts["arm"]["l2_mm"] / 10}
    (spoilt.path / "recording.json").write_text(json.dumps({**facts, "arm": arm}))
    (finding,) = check_recording(open_recording(spoilt.path)).findings
    assert finding.name == "arm_unit" and "Is it in centimetres?" in finding.says


@pytest.mark.parametrize(("down_px", "severity"), [(1.5, "note"), (3.0, "stops"), (8.0, "stops")])
def test_a_camera_that_nodded_between_boards_and_balls(third_rig, tmp_path, down_px, severity):
    """Before the balls are lost by it, and told by the rule by which the localizer loses them."""
    spoilt = spoil(third_rig, tmp_path / "spoilt", [])
    for path in [*(spoilt.path / "position/right").iterdir(), *(spoilt.path / "depth/right").iterdir()]:
        image = cv2.imread(str(path))
        lower = cv2.warpAffine(image, np.float32([[1, 0, 0], [0, 1, down_px]]), image.shape[1::-1], borderMode=1)
        cv2.imwrite(str(path), lower, [cv2.IMWRITE_JPEG_QUALITY, 98])
    shutil.rmtree(spoilt.path / "evaluation", ignore_errors=True)
    moved = [f for f in check_recording(open_recording(spoilt.path)).findings if f.name == "camera_moved"]
    assert [f.severity for f in moved] == [severity] and "px lower than the boards tell" in moved[0].says


@pytest.mark.parametrize(("told_mm", "asked"), [(1050, ""), (95, "in centimetres?"), (0.95, "in metres?")])
def test_an_arm_whose_plane_is_elsewhere(third_rig, tmp_path, told_mm, asked):
    """It follows no ball where those of position lie, unless somebody registered where it stands."""
    spoilt = spoil(third_rig, tmp_path / "spoilt", [])
    facts = json.loads((spoilt.path / "recording.json").read_text())
    facts["arm"]["depth_mm"] = told_mm
    (spoilt.path / "recording.json").write_text(json.dumps(facts))
    spoilt = open_recording(spoilt.path)
    checkup = check_recording(spoilt)
    (finding,) = checkup.findings
    assert (finding.name, finding.severity, checkup.verdict) == ("arm_plane", COSTS, "wanting")
    assert f"950 mm deep, and recording.json has the arm's plane at {told_mm:g} mm" in finding.says
    assert asked in finding.says and ("?" in finding.says) == bool(asked)
    spoilt.registration.save(spoilt.registration_path)
    assert [f.severity for f in check_recording(spoilt).findings] == [NOTE]


def test_position_and_depth_exchanged(third_rig, tmp_path):
    spoilt = spoil(third_rig, tmp_path / "spoilt", [])
    for before, after in (("position", "third"), ("depth", "position"), ("third", "depth")):
        (spoilt.path / before).rename(spoilt.path / after)
    (finding,) = check_recording(open_recording(spoilt.path)).findings
    assert finding.name == "not_flat" and "Were the folders position and depth exchanged?" in finding.advice


def test_a_wrong_size_in_recording_json_is_told_once(third_rig, tmp_path):
    spoilt = spoil(third_rig, tmp_path / "spoilt", [])
    facts = json.loads((spoilt.path / "recording.json").read_text())
    (spoilt.path / "recording.json").write_text(json.dumps({**facts, "image_size": [800, 600]}))
    (finding,) = check_recording(open_recording(spoilt.path)).findings
    assert finding.name == "image_size"


@pytest.mark.parametrize(("turn", "back", "size"), [
    (cv2.ROTATE_90_CLOCKWISE, "counter-clockwise", [640, 480]), (cv2.ROTATE_90_COUNTERCLOCKWISE, "clockwise", [480, 640]),
])  # fmt: skip
def test_pictures_that_are_turned_by_a_quarter_are_told_once(third_rig, tmp_path, turn, back, size):
    """As of phones that stand upright; whichever size recording.json tells."""
    spoilt = spoil(third_rig, tmp_path / "spoilt", [])
    for picture in spoilt.path.glob("*/*/*.jpg"):
        cv2.imwrite(str(picture), cv2.rotate(cv2.imread(str(picture)), turn))
    facts = json.loads((spoilt.path / "recording.json").read_text())
    (spoilt.path / "recording.json").write_text(json.dumps({**facts, "image_size": size}))
    (finding,) = check_recording(open_recording(spoilt.path)).findings
    assert (finding.name, finding.severity) == ("quarter_turned", STOPS) and f"back {back}," in finding.says


@pytest.mark.parametrize(("sides", "sets", "name"), [
    (("left", "right"), ("depth", "position"), "both_mirrored"), (("right",), ("depth", "position"), "mirrored"),
    (("left",), ("position",), "mirrored"),
])  # fmt: skip
def test_balls_in_mirror_images_beside_good_boards(third_rig, tmp_path, sides, sets, name):
    spoilt = spoil(third_rig, tmp_path / "spoilt", [])
    for picture in (p for s in sets for side in sides for p in (spoilt.path / s / side).iterdir()):
        cv2.imwrite(str(picture), cv2.imread(str(picture))[:, ::-1])
    finding, *_ = check_recording(spoilt).findings
    assert finding.name == name and finding.severity == STOPS
    assert {file.split("/")[0] for file in finding.files} == set(sets)
    assert ("both cameras'" if len(sides) == 2 else f"the {sides[0]} camera's") in finding.says


@pytest.mark.parametrize(("name", "turn"), [("both_mirrored", [1, -1]), ("both_upside_down", [-1, -1])])
def test_boards_in_mirror_images_or_upside_down_beside_good_balls(third_rig, tmp_path, name, turn):
    """They tell of cameras that are exchanged; who exchanges the folders of all sets has two mistakes then."""
    spoilt = spoil(third_rig, tmp_path / "spoilt", [])
    for picture in (spoilt.path / "calibration").glob("*/*.jpg"):
        cv2.imwrite(str(picture), cv2.imread(str(picture))[:: turn[0], :: turn[1]])
    (finding,) = check_recording(spoilt).findings
    assert finding.name == name and finding.severity == STOPS and "those of the balls are not" in finding.says
    assert len(finding.files) == len(spoilt.pairs("calibration")) and finding.files[0].startswith("calibration/")


@pytest.mark.parametrize(("name", "by"), [("position", (400, 150)), ("depth", (60, 40))])
def test_a_set_that_is_measured_from_another_corner_of_the_table(third_rig, tmp_path, name, by):
    spoilt = spoil(third_rig, tmp_path / "spoilt", [])
    rewrite(spoilt, name, lambda t: t + [*by, 0])
    (finding,) = check_recording(spoilt).findings
    assert finding.name == "origin" and finding.does_mm == pytest.approx(np.hypot(*by), abs=12)
    assert "do not measure x and y from one point" in finding.says


@pytest.mark.parametrize(("halved", "size"), [("calibration", "320x240"), ("position", "640x480")])
def test_boards_and_balls_of_two_sizes_are_told_once(third_rig, tmp_path, halved, size):
    spoilt = spoil(third_rig, tmp_path / "spoilt", [])
    for picture in (spoilt.path / halved).glob("*/*.jpg"):
        cv2.imwrite(str(picture), cv2.resize(cv2.imread(str(picture)), None, fx=0.5, fy=0.5, interpolation=3))
    stops = [f for f in check_recording(spoilt).findings if f.severity == STOPS]
    assert [f.name for f in stops] == ["picture_sizes"] and f"of the boards, {size} pixels" in stops[0].says


@pytest.mark.parametrize(("turned", "offered"), [([-1, 1, 1], True), ([1, -1, 1], False)])
def test_an_x_the_other_way_round_may_be_a_world_in_a_mirror(third_rig, tmp_path, turned, offered):
    spoilt = spoil(third_rig, tmp_path / "spoilt", [])
    for name in ("position", "depth"):
        rewrite(spoilt, name, lambda t: t * turned)
    (finding,) = check_recording(spoilt).findings
    assert finding.name == "sign" and ("mirror images" in finding.advice) is offered

"""A recording for each seat: its numbers hang together, its keys are computed, and the neighbour's are others."""

import json
import re
from contextlib import nullcontext
from types import SimpleNamespace

import numpy as np
import pytest

from conftest import ROOT
from stereo_lab.calibration import calibrate_recording
from stereo_lab.classroom.grading import grade, solved
from stereo_lab.classroom.handing import hand_in
from stereo_lab.classroom.papers import kit_cells, papers_in
from stereo_lab.classroom.variants import make_variant
from stereo_lab.cli import course, main
from stereo_lab.errors import StereoLabError
from stereo_lab.exercises import questions
from stereo_lab.exercises.answers import PASS, Function, judge
from stereo_lab.exercises.seats import AS_WRITTEN, numbers, reworded
from stereo_lab.localization import Localizer
from stereo_lab.recording import open_recording
from stereo_lab.work import lay_out

NOTEBOOKS = ROOT / "notebooks"
SHARED = ("00", "01", "02", "03", "04", "05", "06", "07", "08", "09")


@pytest.fixture(scope="module")
def seats(tmp_path_factory):
    folder = tmp_path_factory.mktemp("seats")
    return [make_variant(seat, folder / str(seat)) for seat in (4, 5, 6)]


def test_a_larger_bench_is_as_exact_as_the_one_it_was_made_of(seats):
    for recording in seats:
        assert calibrate_recording(recording).verdict == "good"
        localizer = Localizer.fit(recording, leave_out=recording.judges())
        judges = recording.judges("plane")
        found = [(localizer.locate(s.pair.left, s.pair.right), s.truth) for s in judges]
        off = [np.hypot(p.x_mm - t.x_mm, p.y_mm - t.y_mm) for p, t in found if p is not None]
        assert len(off) >= 0.9 * len(judges) and np.median(off) < 3


def test_a_seat_is_the_same_wherever_it_is_made(seats, tmp_path):
    again = make_variant(5, tmp_path / "again")
    for name in ("recording.json", "truth.json", "evaluation/measured.csv", "calibration/left/003.jpg"):
        assert (again.path / name).read_bytes() == (seats[1].path / name).read_bytes()
    with pytest.raises(StereoLabError, match="there already"):
        make_variant(5, tmp_path / "again")
    with pytest.raises(StereoLabError, match="number of a seat"):
        make_variant(-1, tmp_path / "none")
    assert not (tmp_path / "none").exists() and sorted(p.name for p in tmp_path.iterdir()) == ["again"]


def has_another_key(question, others):
    """Whether the neighbour's answer is wrong here; of a function, whether it is tried on other numbers."""
    if isinstance(question.answer, Function):
        return str(question.answer.inputs) != str(others.answer.inputs)
    return judge(question.answer, others.reference).status != PASS


@pytest.mark.parametrize("lesson", SHARED)
def test_three_fifths_of_the_keys_are_not_the_neighbours(seats, lesson):
    for mine, others in ((seats[0], seats[1]), (seats[1], seats[2])):
        pairs = list(zip(questions(lesson, mine), questions(lesson, others), strict=True))
        assert sum(has_another_key(*pair) for pair in pairs) >= 0.6 * len(pairs)


@pytest.mark.parametrize("lesson", SHARED)
def test_the_keys_of_a_seat_hold(seats, lesson):
    for recording in seats:
        for q in questions(lesson, recording):
            assert all(judge(q.answer, answer).status == PASS for answer in (q.reference, *q.answer.also)), q.name
            told = [judge(q.answer, wrong.answer).text == wrong.message for wrong in q.answer.wrong]
            assert sum(told) >= 0.75 * len(told), q.name


def test_the_numbers_of_a_lesson_are_those_of_its_questions():
    """A rewording that no cell has any more would leave the lesson and its key apart."""
    for lesson, before, after in (
        ("02", "pixel = (30, 40, 200)", f"pixel = {numbers(7).pixel_bgr}"),
        ("06", "elbow to −30°", f"elbow to −{-numbers(7).elbow_deg}°"),
        ("07", "a picture is 80 ms old", f"a picture is {numbers(7).old_ms:g} ms old"),
        ("07", "rolls at 250 mm/s", f"rolls at {numbers(7).speed_mm_s:g} mm/s"),
        (
            "07",
            "Turn its percentage into",
            f"{numbers(7).cpu_percent:g} % of a CPU at {numbers(7).pairs_a_second:g} pairs",
        ),
        ("07", "# of the paper's CPU, in ms", "# of that program, in ms"),
    ):
        assert any(before in cell.source for cell in kit_cells(NOTEBOOKS, lesson))
        seated = [cell.source for cell in kit_cells(NOTEBOOKS, lesson, 7)]
        assert any(after in source for source in seated) and not any(before in source for source in seated)
    assert numbers(None) == AS_WRITTEN and reworded("elbow to −30°", None) == "elbow to −30°"
    for seat in range(200):
        mine, others = numbers(seat), numbers(seat + 1)
        assert mine.pixel_bgr[2] != others.pixel_bgr[2] and mine.elbow_deg != others.elbow_deg
        assert len(set(mine.pixel_bgr)) == 3 and mine.elbow_deg >= -75


def test_a_learners_lessons_have_the_seats_numbers(tmp_path, monkeypatch, capsys):
    work = tmp_path / "work"
    monkeypatch.setenv("STEREO_LAB_WORK", str(work))
    lay_out(NOTEBOOKS, work)
    begun = work / "06_driving_the_arm.ipynb"
    begun.write_text(begun.read_text(encoding="utf-8").replace("____  ", "-30  "), encoding="utf-8")
    assert main(["variant", "7"]) == 0
    said = capsys.readouterr().out
    assert (
        "seat 7" in said
        and "new folder" not in said
        and f"{begun.name} is begun" in said
        and "reset 06" in said
        and "02_" not in said
    )
    monkeypatch.setattr(course, "_jupyterlab", lambda *_: nullcontext(SimpleNamespace(wait=lambda: 0)))
    assert main(["start"]) == 0
    said = capsys.readouterr().out
    assert f"{begun.name} has other numbers" in said and "The kit has a newer" not in said
    for lesson, seat in (("06", None), ("02", 7)):  # each with the numbers that stand in it
        hand_in(NOTEBOOKS, work, lesson, tmp_path / lesson)
        assert papers_in(tmp_path / lesson)[0].seat == seat
    text = "".join(json.loads((work / "02_detection.ipynb").read_text(encoding="utf-8"))["cells"][4]["source"])
    assert f"pixel = {numbers(7).pixel_bgr}" in text
    assert main(["variant", "8"]) == 2 and "seat 7 is in" in capsys.readouterr().err


@pytest.mark.slow
def test_grade_knows_the_seat(tmp_path):
    """Two neighbours hand in their own answers, and one of them the other's."""
    for seat in (4, 5):
        work = tmp_path / f"work{seat}"
        make_variant(seat, work / "seat")
        lay_out(NOTEBOOKS, work)
    stem = "03_world_coordinates.ipynb"
    for seat in (4, 5):
        work = tmp_path / f"work{seat}"
        asked = questions("03", open_recording(work / "seat"))
        notebook = json.loads((work / stem).read_text(encoding="utf-8"))
        code = iter(solved("03", asked, seat))
        for cell in notebook["cells"]:
            if cell["cell_type"] == "code":
                cell["source"] = next(code)
        (work / stem).write_text(json.dumps(notebook), encoding="utf-8")
        hand_in(NOTEBOOKS, work, "03", tmp_path / "in", chosen=f"seat-{seat}")
        if seat == 4:
            slope = float(asked[1].reference)
    copied = re.sub(
        r"slope = \(y1 - y0\) / \(v1 - v0\)", f"slope = {slope!r}", (work / stem).read_text(encoding="utf-8")
    )
    (work / stem).write_text(copied, encoding="utf-8")
    hand_in(NOTEBOOKS, work, "03", tmp_path / "in", chosen="copied")
    graded = grade(tmp_path / "in", open_recording(ROOT / "data" / "bench"), tmp_path / "kept.json")
    rows = {row.learner: row for row in graded.rows}
    assert [rows[name].passed for name in ("seat-4", "seat-5", "copied")] == [6, 6, 5]
    assert "seat 5" in rows["copied"].notes and rows["copied"].marks[1].status != PASS


HEAVY = ("for marked in draws", "own.detect(picture) for", "OwnBall.train(", "a_moment_later(", "Localizer.fit(")


@pytest.mark.slow
def test_lesson_09_is_marked_rightly(tmp_path):
    """Right answers in other spellings, lists among them, and known mistakes; what takes long and asks nothing is left out of both."""
    work = tmp_path / "work"
    lay_out(NOTEBOOKS, work)
    stem, bench = "09_a_detector_that_learned.ipynb", open_recording(ROOT / "data" / "bench")
    asked = questions("09", bench)
    spelled = {
        1: "def line_sum(x, y, a, b, c):\n    return [a * u + b * v + c for u, v in zip(x, y)]",
        4: "def gradient(x, p, y):\n    return [float(np.mean((p - y) * column)) for column in x.T]",
        7: "def at_most_percent(n):\n    return 100 * (1 - 0.05 ** (1 / n))",
        6: 'judged_on = "In another room."',
    }
    wrong = {
        1: "def line_sum(x, y, a, b, c):\n    return np.mean(a * x + b * y + c)",
        3: "def loss(p, y):\n    return -np.mean(y * np.log(p))",
        5: "def one_or_none(s):\n    return np.exp(s) / np.exp(s).sum()",
        6: 'judged_on = "the last ten seconds"',
    }
    blank = json.loads((work / stem).read_text(encoding="utf-8"))
    for learner, answers in (("right", spelled), ("wrong", wrong)):
        notebook = json.loads(json.dumps(blank))
        code = iter(solved("09", asked))
        for cell in notebook["cells"]:
            if cell["cell_type"] == "code":
                source = next(code)
                found = re.search(r"\bq(\d)\.check\(", source)
                if found and int(found.group(1)) in answers:
                    source = f"{answers[int(found.group(1))]}\n{source[found.start() :]}"
                cell["source"] = "pass" if any(words in source for words in HEAVY) else source
        (work / stem).write_text(json.dumps(notebook), encoding="utf-8")
        hand_in(NOTEBOOKS, work, "09", tmp_path / "in", chosen=learner)
    graded = grade(tmp_path / "in", bench, tmp_path / "kept.json")
    rows = {row.learner: row for row in graded.rows}
    assert rows["right"].passed == 8, [(mark.status, mark.why) for mark in rows["right"].marks]
    assert [k + 1 for k, mark in enumerate(rows["wrong"].marks) if mark.status != PASS] == [1, 3, 5, 6]
    assert "each has its own sum" in rows["wrong"].marks[0].why and "the room" in rows["wrong"].marks[5].why

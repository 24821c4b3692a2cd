"""Handing in: one file, a code name, nothing of the computer that it comes from."""

import json
import os
import re
import shlex
import shutil
import time

import pytest

from conftest import ROOT
from stereo_lab.classroom import grading
from stereo_lab.classroom.examiner import Answer, Examiner, Heard
from stereo_lab.classroom.grading import grade
from stereo_lab.classroom.handing import code_name, hand_in
from stereo_lab.classroom.papers import latest, papers_in
from stereo_lab.cli import _parser, main
from stereo_lab.errors import StereoLabError
from stereo_lab.exercises import questions
from stereo_lab.exercises.answers import NOT_YET, PASS, Verdict
from stereo_lab.recording import open_recording
from stereo_lab.work import lay_out
from tests.classes import STEM, add, answered, right

NOTEBOOKS = ROOT / "notebooks"


@pytest.fixture
def work(tmp_path, monkeypatch):
    folder = tmp_path / "work"
    lay_out(NOTEBOOKS, folder)
    monkeypatch.setenv("STEREO_LAB_WORK", str(folder))
    return folder


@pytest.fixture
def runs(monkeypatch):
    """Nothing is really run: each notebook passes all but its second question. Gives the list of what was to be run."""
    asked = []

    def examine(self, cells, seed):
        asked.append(cells)
        if len(asked) == 3:
            raise KeyboardInterrupt
        ways = {2: Verdict(NOT_YET, "the sign is turned")}
        return Heard({k: Answer(ways.get(k, Verdict(PASS))) for k in range(1, 7)}, seconds=[0.1])

    monkeypatch.setattr(Examiner, "examine", examine)
    monkeypatch.setattr(grading, "_limits", lambda *_: grading.LEAST)
    return asked


def save(folder, notebook):
    (folder / f"{STEM}.ipynb").write_text(json.dumps(notebook), encoding="utf-8")


def test_one_file_under_a_code_name(work, tmp_path, capsys):
    notebook = answered({1: 'slope_is = "below"'})
    notebook["cells"][2]["outputs"] = [{"output_type": "stream", "name": "stdout", "text": "/home/ada/secret"}]
    notebook["metadata"]["authors"] = [{"name": "Ada"}]
    save(work, add(notebook, "What I think", kind="markdown"))
    assert main(["hand-in", "3", "--out", str(tmp_path / "out")]) == 0
    (file,) = (tmp_path / "out").iterdir()
    said = capsys.readouterr().out
    name = code_name(work)
    assert name in file.name and name in said and "1 of 6 blanks are filled" in said
    text = file.read_text(encoding="utf-8")
    assert "secret" not in text and "Ada" not in text and "What I think" in text
    (paper,) = papers_in(tmp_path / "out")
    assert paper.learners == (name,) and paper.lesson == "03" and not paper.trouble
    assert code_name(work) == name  # the same the next time


def test_pairs_two_on_one_account_and_twice(work, tmp_path, runs):
    out = tmp_path / "out"
    hand_in(NOTEBOOKS, work, "03", out, ["calm-owl-12"])
    hand_in(NOTEBOOKS, work, "03", out, chosen="brave-fox-77")
    (out / "again").mkdir()
    first = next(path for path in out.glob("03_*calm-owl-12*"))
    again = json.loads(first.read_text(encoding="utf-8"))
    soon = [time.strftime("%Y-%m-%d %H:%M:%S", time.localtime(time.time() + hours * 3600)) for hours in (1, 2)]
    again["metadata"]["stereo_lab_hand_in"]["handed_in"] = soon[1]
    (out / "again" / "late.ipynb").write_text(json.dumps(again), encoding="utf-8")
    found = latest(papers_in(out))
    own = next(learner for learner, _ in found if learner not in ("calm-owl-12", "brave-fox-77"))
    assert {learner: [p.file for p in papers][0] for (learner, _), papers in found.items()} == {
        own: "again/late.ipynb", "calm-owl-12": "again/late.ipynb", "brave-fox-77": next(p.name for p in out.glob("03_brave-fox-77*")),
    }  # fmt: skip
    graded = grade(out, open_recording(ROOT / "data" / "bench"), tmp_path / "kept.json", due=soon[0][:16])
    rows = {row.learner: row for row in graded.rows}
    assert rows[own].notes[:3] == ("handed in 2 times, the latest counts", "late", "together with calm-owl-12")
    assert rows["brave-fox-77"].notes[:1] != ("late",)


def test_hints_and_solutions_go_along(work, tmp_path, capsys):
    q1, q2, *_ = questions("03", open_recording(ROOT / "data" / "bench"))
    q1.hint()
    q1.hint()
    q2.solution()
    capsys.readouterr()
    hand_in(NOTEBOOKS, work, "03", tmp_path / "out")
    (paper,) = papers_in(tmp_path / "out")
    assert paper.help == {1: {"hint": 2}, 2: {"solution": 1}}


@pytest.mark.parametrize(
    "told",
    [
        5,
        [],
        {"learners": ["../x"]},
        {"learners": 7, "help": {"x": 1, "1": {"hint": "many"}}},
        {"lesson": "77", "seat": "a"},
    ],
)
def test_what_is_forged_in_a_hand_in_is_passed_over(work, tmp_path, told):
    hand_in(NOTEBOOKS, work, "03", tmp_path / "out")
    (file,) = (tmp_path / "out").iterdir()
    notebook = json.loads(file.read_text(encoding="utf-8"))
    notebook["metadata"]["stereo_lab_hand_in"] = told
    file.write_text(json.dumps(notebook), encoding="utf-8")
    (paper,) = papers_in(tmp_path / "out")
    assert paper.lesson == "03" and "/" not in paper.learners[0] and paper.seat is None and paper.help in ({}, {1: {}})


def test_half_an_emoji_does_not_stop_a_hand_in(work, tmp_path):
    path = work / f"{STEM}.ipynb"
    notebook = json.loads(path.read_text(encoding="utf-8"))
    notebook["cells"][0]["source"] = "half \ud83d of it"
    path.write_text(json.dumps(notebook), encoding="utf-8")
    handed = hand_in(NOTEBOOKS, work, "03", tmp_path / "out")
    assert json.loads(handed.path.read_text(encoding="utf-8"))["cells"][0]["source"] == "half \ud83d of it"
    assert papers_in(handed.path.parent)[0].lesson == "03"


def test_what_cannot_be_handed_in_is_said(work, tmp_path, capsys):
    assert main(["hand-in", "33"]) == 2 and "no lesson '33'" in capsys.readouterr().err
    assert main(["hand-in", "3", "--with", "no name!"]) == 2 and "code name" in capsys.readouterr().err
    (work / f"{STEM}.ipynb").write_text("{", encoding="utf-8")
    assert main(["hand-in", "3"]) == 2 and re.search(
        r"cannot be read as a notebook\..*lab(\.py)? reset 03$", capsys.readouterr().err.strip()
    )
    (work / f"{STEM}.ipynb").unlink()
    assert main(["hand-in", "3"]) == 2 and re.search(
        r"is not in .*lab(\.py)? start 03$", capsys.readouterr().err.strip()
    )
    shutil.rmtree(work)
    assert main(["hand-in", "3"]) == 2 and "Name whose it is with --name, or begin with: " in capsys.readouterr().err


def test_whoever_is_named_is_not_asked_for_the_name(tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("STEREO_LAB_WORK", str(tmp_path / "work"))
    assert main(["hand-in", "3", "--name", "zoë"]) == 2
    said = capsys.readouterr().err.strip()
    assert re.search(r"yet\. Begin with: \S.* start --name zoë$", said) and "Name whose" not in said


def test_grading_goes_on_where_it_stopped_and_keeps_a_teachers_mark(work, tmp_path, runs, capsys):
    """Nothing is run twice, and what a teacher wrote into the table is there in the next one."""
    for k in range(3):
        save(work, add(answered(right()), f"x = {k}"))
        hand_in(NOTEBOOKS, work, "03", tmp_path / "in", chosen=f"learner-{k}")
    table = tmp_path / "class.csv"
    command = [
        "grade",
        str(tmp_path / "in"),
        "--csv",
        str(table),
        "--jobs",
        "1",
        "--recording",
        str(ROOT / "data" / "bench"),
    ]
    assert main(command) == 130 and not table.exists() and "stopped" in capsys.readouterr().err
    assert main(command) == 0 and len(runs) == 4
    assert "3.2  0 of 3 passed" in capsys.readouterr().out
    text = table.read_text(encoding="utf-8-sig").splitlines()
    cells = text[1].split(",")
    cells[text[0].split(",").index("2 teacher")] = "passed"
    table.write_text("\n".join([text[0], ",".join(cells), *text[2:]]), encoding="utf-8")
    assert main(command) == 0 and len(runs) == 4  # nothing was run again
    assert "3.2  1 of 3 passed" in capsys.readouterr().out
    os.remove(table)
    assert main(command) == 0 and "3.2  1 of 3 passed" in capsys.readouterr().out  # kept beside it as well
    # a learner taken out as docs/privacy.md tells it
    next((tmp_path / "in").glob("*learner-2*")).unlink()
    lines = [line for line in table.read_text(encoding="utf-8-sig").splitlines() if "learner-2" not in line]
    table.write_text("\n".join(lines), encoding="utf-8")
    os.remove(tmp_path / "class.grade.json")
    assert main(command) == 0 and "3.2  1 of 2 passed" in capsys.readouterr().out
    assert not any("learner-2" in (tmp_path / name).read_text("utf-8") for name in ("class.csv", "class.grade.json"))


def test_a_folder_that_cannot_be_written_to_is_told_before_anything_runs(work, tmp_path, runs, capsys):
    save(work, answered(right()))
    hand_in(NOTEBOOKS, work, "03", tmp_path / "in")
    (tmp_path / "file").write_text("")
    assert main(["grade", str(tmp_path / "in"), "--csv", str(tmp_path / "file" / "class.csv")]) == 2
    assert "Cannot write" in capsys.readouterr().err and runs == []


def test_marks_that_a_teacher_writes_while_the_class_runs_are_kept(work, tmp_path, monkeypatch, capsys):
    save(work, answered(right()))
    hand_in(NOTEBOOKS, work, "03", tmp_path / "in", chosen="ada")
    table = tmp_path / "class.csv"

    def examine(self, cells, seed):
        table.write_text("learner,lesson,2 teacher\nada,03,passed\n")
        return Heard({k: Answer(Verdict(NOT_YET, "no")) for k in range(1, 7)}, seconds=[0.1])

    monkeypatch.setattr(Examiner, "examine", examine)
    monkeypatch.setattr(grading, "_limits", lambda *_: grading.LEAST)
    assert main(["grade", str(tmp_path / "in"), "--csv", str(table)]) == 0
    assert "3.2  1 of 1 passed" in capsys.readouterr().out


PAGE = (ROOT / "notebooks" / "instructor" / "grading.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("command", sorted(set(re.findall(r"`python3 lab\.py ([^`]+)`", PAGE))))
def test_every_command_of_the_teachers_page_is_one(command):
    assert callable(_parser().parse_args(shlex.split(command)).run)


def test_the_teachers_page_says_what_is_so():
    from stereo_lab.classroom import examiner, room
    from stereo_lab.classroom.table import FIRST, PARTS

    assert f"{room.MEMORY / 1e9:g} GB" in PAGE and grading.TIMES == 3 and grading.LEAST.cell == 10
    assert all(f"`2{part}`" in PAGE for part in PARTS) and {"learner", "lesson"} <= set(FIRST)
    assert examiner.TAKEN.startswith(re.search(r"\*(this is the kit's own answer, taken from it)\*", PAGE).group(1))
    assert len(PAGE.split()) < 6 * 250


def test_a_clock_that_is_years_ahead_does_not_hide_what_comes_later(work, tmp_path):
    done = hand_in(NOTEBOOKS, work, "03", tmp_path / "out")
    told = json.loads(done.path.read_text(encoding="utf-8"))
    for moment in ("2099-01-01 00:00:00", "9999-99-99 99:99:99"):
        told["metadata"]["stereo_lab_hand_in"]["handed_in"] = moment
        done.path.write_text(json.dumps(told), encoding="utf-8")
        (paper,) = papers_in(tmp_path / "out")
        assert paper.handed_in[:4] == time.strftime("%Y")


def test_a_refused_name_changes_nothing(work, tmp_path):
    name = code_name(work)
    for others, chosen in ((["Zoë"], "brave-fox-77"), ([f"fox-{k}" for k in range(8)], "brave-fox-77"), ([], "")):
        with pytest.raises(StereoLabError):
            hand_in(NOTEBOOKS, work, "03", tmp_path / "out", others, chosen)
    assert code_name(work) == name and not (tmp_path / "out").exists()


def test_eight_learners_with_long_names_are_one_file_and_eight_rows(work, tmp_path):
    others = [f"{k}-{'a' * 36}" for k in range(7)]
    hand_in(NOTEBOOKS, work, "03", tmp_path / "out", others)
    (paper,) = papers_in(tmp_path / "out")
    assert paper.learners == (code_name(work), *others)

"""The course as assignments of nbgrader, tried with nbgrader itself."""

import csv
import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from conftest import ROOT, skip_unless_ci
from stereo_lab.cli import main
from stereo_lab.common.files import write_whole
from stereo_lab.errors import StereoLabError
from stereo_lab.exercises import questions
from stereo_lab.exercises.question import NotPassed
from stereo_lab.instructor import assignment, assignments
from stereo_lab.work import clean
from tests.test_notebooks import STUB, every_notebook, source

SOLUTION = re.compile(r"\n### BEGIN SOLUTION\n.*?### END SOLUTION", re.DOTALL)
LESSON = "00_start_here"


def told(cell):
    return cell["metadata"].get("nbgrader", {})


@every_notebook
def test_an_assignment_is_the_lesson_with_its_questions_taken_apart(path, bench):
    lesson, asked = json.loads(path.read_text(encoding="utf-8")), questions(path.stem[:2], bench)
    made = assignment(lesson, asked)["cells"]
    graded = [cell for cell in made if told(cell).get("grade")]
    assert [told(cell)["grade_id"] for cell in graded] == [f"q{q.lesson}-{q.number}" for q in asked]
    assert all(told(cell)["points"] == 1 and told(cell)["locked"] for cell in graded)
    ids = [cell["id"] for cell in made]
    assert len(set(ids)) == len(ids) == len(lesson["cells"]) + 2 * len(asked)
    # without the solutions, and put together again, it is the lesson
    seen = iter(cell for cell in made if "-carry" not in cell["id"])
    for before in clean(lesson)["cells"]:
        cell = next(seen)
        if before["cell_type"] == "code" and STUB.search(source(before)):
            point = next(seen)
            assert source(before).startswith(SOLUTION.sub("", cell["source"]))
            check, require = point["source"].splitlines()
            assert check in source(before) and require == check.replace(".check(", ".require(")
        else:
            assert cell == before


def test_a_point_needs_an_answer_that_passes(bench, capsys):
    question = questions("00", bench)[0]
    question.require("right")
    for answer, status in (("left", "NOT YET"), (..., "NOT YET")):
        with pytest.raises(NotPassed, match=status):
            question.require(answer)
    assert NotPassed("NOT YET")._render_traceback_() == ["no point: NOT YET"]
    assert capsys.readouterr().out == ""  # what there is to say, check has said in the line above


def test_a_folder_with_something_in_it_is_left_alone(tmp_path, capsys):
    (tmp_path / "mine.txt").write_text("mine")
    assert main(["export-nbgrader", str(tmp_path)]) == 2
    assert "holds something" in capsys.readouterr().err and os.listdir(tmp_path) == ["mine.txt"]


def test_a_course_is_written_whole_or_not_at_all(tmp_path, monkeypatch, capsys):
    def full(path, content):
        if Path(path).name.startswith("04"):
            raise StereoLabError(f"Cannot write {path}: No space left on device.")
        write_whole(path, content)

    monkeypatch.setattr(assignments, "write_whole", full)
    assert main(["export-nbgrader", str(tmp_path / "course")]) == 2
    assert "No space left" in capsys.readouterr().err and os.listdir(tmp_path) == []


def submit(course, learner, change):
    """Hand in the released lesson, changed."""
    folder = course / "submitted" / learner / LESSON
    folder.mkdir(parents=True)
    notebook = json.loads((course / "release" / LESSON / f"{LESSON}.ipynb").read_text(encoding="utf-8"))
    change(notebook["cells"])
    (folder / f"{LESSON}.ipynb").write_text(json.dumps(notebook), encoding="utf-8")


def answer(cells, numbers, bench):
    """Write the solutions of some questions."""
    asked = questions("00", bench)
    for cell in cells:
        if (found := re.fullmatch(r"q00-(\d)-answer", told(cell).get("grade_id", ""))) and int(found[1]) in numbers:
            cell["source"] = source(cell) + asked[int(found[1]) - 1].code


@pytest.fixture(scope="module")
def graded(tmp_path_factory, bench):
    """Three learners' marks, as nbgrader writes them: all answered, nothing answered, two right and one wrong."""
    if not (nbgrader := shutil.which("nbgrader", path=str(Path(sys.executable).parent))):
        skip_unless_ci("nbgrader is not installed (extra: instructor)")
    course = tmp_path_factory.mktemp("class") / "course"
    environment = {
        **os.environ, "STEREO_LAB_WORK": str(course.parent / "work"), "PYTHONPATH": str(ROOT), "HOME": str(course.parent),
        "PATH": f"{Path(nbgrader).parent}{os.pathsep}{os.environ['PATH']}",
    }  # fmt: skip

    def run(*words):
        return subprocess.run([nbgrader, *words], cwd=course, env=environment, capture_output=True, text=True)

    assert main(["export-nbgrader", str(course)]) == 0
    assert (done := run("generate_assignment", LESSON)).returncode == 0, done.stderr
    submit(course, "all", lambda cells: answer(cells, (1, 2, 3, 4, 5), bench))
    submit(course, "nothing", lambda cells: None)

    def two_and_a_mistake(cells):
        answer(cells, (1, 3), bench)
        wrong = next(cell for cell in cells if told(cell).get("grade_id") == "q00-4-answer")
        wrong["source"] = 'nearer_means = "shrinks"'

    submit(course, "some", two_and_a_mistake)
    assert (done := run("autograde", LESSON)).returncode == 0, done.stderr
    assert (done := run("export")).returncode == 0, done.stderr
    with open(course / "grades.csv", encoding="utf-8") as file:
        marks = {row["student_id"]: float(row["score"]) for row in csv.DictReader(file) if row["assignment"] == LESSON}
    return course, marks, run


@pytest.mark.slow
def test_nbgrader_gives_the_points(graded):
    course, marks, _ = graded
    assert marks == {"all": 5, "nothing": 0, "some": 2}
    released = (course / "release" / LESSON / f"{LESSON}.ipynb").read_text(encoding="utf-8")
    assert "____" in released and "BEGIN SOLUTION" not in released and 'farther_left_in = \\"right\\"' not in released


POINTS = f"""
import json, sys
from nbgrader.api import Gradebook

with Gradebook(f"sqlite:///{{sys.argv[1]}}") as book:
    handed_in = book.assignment_submissions("{LESSON}")
    points = {{told.student.id: {{g.cell.name: g.score for g in told.notebooks[0].grades}} for told in handed_in}}
print(json.dumps(points))
"""


def points_of_nbgrader(course):
    """What nbgrader's gradebook has: for each learner the points of each question.

    Asked in a process of its own: nbgrader brings setuptools, which will not come after Python's own distutils.
    """
    command = [sys.executable, "-c", POINTS, str(course / "gradebook.db")]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout.splitlines()[-1])


@pytest.mark.slow
def test_grade_gives_the_same_marks(graded, tmp_path):
    course, *_ = graded
    assert main(["grade", str(course / "submitted"), "--csv", str(tmp_path / "class.csv")]) == 0
    with open(tmp_path / "class.csv", encoding="utf-8-sig") as file:
        rows = list(csv.DictReader(file))
    ours = {row["learner"]: {f"q00-{k}": float(row[str(k)] == "passed") for k in range(1, 6)} for row in rows}
    assert ours == points_of_nbgrader(course)
    assert "arm's length" in next(row["4 why"] for row in rows if row["learner"] == "some")


@pytest.mark.slow
def test_where_nbgrader_breaks_grade_goes_on(graded, tmp_path, bench):
    """A cell that was copied, and one that was deleted: what the guide says of the two programs."""
    course, _, run = graded
    folder = tmp_path / "class"

    def copied_and_deleted(cells):
        answer(cells, (1, 2, 3, 4, 5), bench)
        places = {told(cell).get("grade_id"): k for k, cell in enumerate(cells)}
        cells.insert(places["q00-1-answer"], json.loads(json.dumps(cells[places["q00-1"]])))
        cells[places["q00-1-answer"]]["id"] = "a-copy"
        del cells[places["q00-2"] + 1]

    submit(course, "broken", copied_and_deleted)
    assert run("autograde", LESSON, "--student", "broken").returncode != 0
    assert not (course / "autograded" / "broken" / LESSON / f"{LESSON}.ipynb").exists()
    shutil.move(course / "submitted" / "broken", folder / "broken")
    assert main(["grade", str(folder), "--csv", str(tmp_path / "class.csv")]) == 0
    with open(tmp_path / "class.csv", encoding="utf-8-sig") as file:
        (row,) = csv.DictReader(file)
    assert [row[str(k)] for k in (1, 3, 4, 5)] == ["passed"] * 4, row


@pytest.mark.slow
def test_a_point_that_is_not_given_is_said_in_a_line(graded):
    course, *_ = graded
    path = course / "autograded" / "nothing" / LESSON / f"{LESSON}.ipynb"
    cells = json.loads(path.read_text(encoding="utf-8"))["cells"]
    errors = [output for cell in cells for output in cell.get("outputs", []) if output["output_type"] == "error"]
    assert [error["traceback"] for error in errors] == [["no point: NOT ATTEMPTED"]] * 5

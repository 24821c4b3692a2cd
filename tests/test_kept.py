"""What a learner wrote comes back in later lessons; what cannot come back is told, and the kit's own stands in."""

import linecache
import math

import numpy as np
import pytest

from conftest import ROOT
from stereo_lab.errors import StereoLabError
from stereo_lab.exercises import LESSONS, mine, questions
from stereo_lab.exercises.answers import Function
from stereo_lab.exercises.kept import _value
from stereo_lab.recording import open_recording

HALF = 2


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.setenv("STEREO_LAB_WORK", str(tmp_path))
    return tmp_path


def passed(name, answer, bench, capsys):
    lesson, number = name.split(".")
    questions(lesson, bench)[int(number) - 1].check(answer)
    assert capsys.readouterr().out.startswith("PASS")


def square(x):
    return x**HALF


def with_a_helper(l1, l2, x, y):
    cosine = (square(x) + square(y) - square(l1) - square(l2)) / (2 * l1 * l2)
    return math.degrees(math.acos(cosine))


by_lambda = lambda l1, l2, x, y: np.degrees(np.arccos((x**2 + y**2 - l1**2 - l2**2) / (2 * l1 * l2)))  # noqa: E731


@pytest.mark.parametrize("answer", [with_a_helper, by_lambda])
def test_a_function_comes_back(answer, bench, capsys):
    passed("05.3", answer, bench, capsys)
    back = mine("05.3", bench)
    assert capsys.readouterr().out == "question 5.3: your own answer\n"
    assert back is not answer and back(250, 200, 300, 90) == pytest.approx(answer(250, 200, 300, 90))


def test_it_is_text_to_read_and_to_change(folder, bench, capsys):
    passed("05.3", with_a_helper, bench, capsys)
    (path,) = (folder / "answers").iterdir()
    text = path.read_text(encoding="utf-8")
    assert path.name == "question_05_3.py" and "def with_a_helper(l1, l2, x, y):" in text and "HALF = 2" in text
    path.write_text("answer = lambda l1, l2, x, y: 12345.0")
    assert mine("5.3", bench) is questions("05", bench)[2].reference
    assert "question_05_3.py does not pass on this recording" in capsys.readouterr().out


@pytest.mark.parametrize("name, answer", [("05.5", -70), ("05.5", np.float64(-70.0)), ("05.5", [-70]), ("06.1", "MV 2 -30"), ("01.2", np.array([9, 6]))])  # fmt: skip
def test_a_value_comes_back(name, answer, bench, capsys):
    passed(name, answer, bench, capsys)
    assert np.array_equal(np.ravel(mine(name, bench)), np.ravel(answer))
    assert "your own answer" in capsys.readouterr().out


def test_a_value_of_another_rig_does_not(bench, second_rig, capsys):
    passed("01.2", (9, 6), bench, capsys)
    assert mine("01.2", second_rig) == questions("01", second_rig)[1].reference
    assert "does not pass on this recording" in capsys.readouterr().out


def test_nothing_there_yet(bench, capsys):
    assert mine("05.3", bench) is questions("05", bench)[2].reference
    assert (
        capsys.readouterr().out == "question 5.3: the kit's own answer, for you have not passed it in this folder yet\n"
    )


def test_a_wrong_answer_is_not_kept_and_leaves_the_right_one(bench, capsys):
    passed("05.5", -70, bench, capsys)
    questions("05", bench)[4].check(70)
    assert "NOT YET" in capsys.readouterr().out
    assert mine("05.5", bench) == -70


@pytest.mark.parametrize(
    "text, why",
    [
        ("answer = ", "SyntaxError"),
        ("import sys\nsys.exit(3)", "SystemExit"),
        ("answer = 1 / 0", "ZeroDivisionError"),
        ("", "does not pass"),
        ("answer = ____", "NameError"),
        ("answer = 'a" + "\0" + "'", "stops with"),
    ],
)
def test_a_spoilt_file_stops_nothing(folder, bench, capsys, text, why):
    (folder / "answers").mkdir()
    (folder / "answers" / "question_05_3.py").write_text(text)
    assert mine("05.3", bench) is questions("05", bench)[2].reference
    assert why in capsys.readouterr().out


def test_what_cannot_be_written_as_text_is_not_kept(bench, capsys):
    passed("05.5", -70, bench, capsys)
    questions("05", bench)[2].check(lambda *a: with_a_helper(*a))  # no line of its own
    assert mine("05.3", bench) is questions("05", bench)[2].reference


def test_a_full_disk_stops_nobody(tmp_path, monkeypatch, bench, capsys):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("STEREO_LAB_WORK", str(tmp_path / "file" / "work"))
    passed("05.5", -70, bench, capsys)
    assert mine("05.5", bench) == -70.0 and "the kit's own" in capsys.readouterr().out


@pytest.mark.parametrize("name", ["05.9", "05", "5.x", "99.1", ""])
def test_a_question_that_is_not_there(name, bench):
    with pytest.raises(StereoLabError, match="There (is|are) no question"):
        mine(name, bench)


@pytest.mark.parametrize("number", LESSONS)
def test_every_solution_can_be_kept(number, folder, bench, capsys):
    """Run as in a notebook's cell, each solution comes back and passes again, with whatever it uses."""
    names = {"__name__": "__main__"}
    if number == "07":
        names |= {"elbow_deg": mine("05.3", bench), "shoulder_deg": mine("05.4", bench)}
        capsys.readouterr()
    for q in questions(number, open_recording(ROOT / "data" / "bench")):
        if not isinstance(q.answer, Function):
            continue
        cell = "from math import *\nimport numpy as np\n" + q.code
        file = f"<cell {q.name}>"
        linecache.cache[file] = (
            len(cell),
            None,
            cell.splitlines(True),
            file,
        )  # as IPython does, so that source is found
        before = set(names)
        exec(compile(cell, file, "exec"), names)
        (defined,) = [name for name in set(names) - before if getattr(names[name], "__module__", "") == "__main__"]
        q.check(names[defined])
        assert capsys.readouterr().out.startswith("PASS")
        assert mine(q.name, bench) is not q.reference
        assert "your own answer" in capsys.readouterr().out


def test_what_came_back_is_kept_again_with_what_it_uses(bench, capsys):
    """Lesson 07 joins two functions that came back from lesson 05."""
    passed("05.3", with_a_helper, bench, capsys)
    names = {"__name__": "__main__", "elbow_deg": mine("05.3", bench), "shoulder_deg": mine("05.4", bench)}
    cell = questions("07", bench)[0].code
    linecache.cache["<cell 7.1>"] = (len(cell), None, cell.splitlines(True), "<cell 7.1>")
    exec(compile(cell, "<cell 7.1>", "exec"), names)
    capsys.readouterr()
    passed("07.1", names["angles_for"], bench, capsys)
    assert mine("07.1", bench)(150, 200, 250, 200) == pytest.approx(names["angles_for"](150, 200, 250, 200))
    assert "your own answer" in capsys.readouterr().out


def test_numbers_of_numpy_in_a_row_are_kept(bench, folder):
    """np.linspace gives them one by one as np.float64, whose repr is no value of Python's."""
    rows = (np.float64(1.5), [np.int64(2), "a"])
    assert _value(rows) == "(1.5, [2, 'a'])"

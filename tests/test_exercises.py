"""Every question: the untouched stub, right answers, each listed wrong answer, on both recordings."""

import ast
import builtins
import json
import math
import sys

import cv2
import numpy as np
import pytest

from conftest import ROOT
from stereo_lab import plots
from stereo_lab.calibration import calibrate_recording
from stereo_lab.detection import Detection
from stereo_lab.errors import StereoLabError
from stereo_lab.exercises import LESSONS, ____, questions
from stereo_lab.exercises.answers import PASS, Choice, Command, Function, Number, Wrong, judge
from stereo_lab.exercises.lesson05 import elbow_deg, shoulder_deg
from stereo_lab.exercises.question import lesson
from stereo_lab.kinematics import TwoLinkArm
from stereo_lab.position import LineFit
from stereo_lab.recording import open_recording
from tests.written import assert_as_written


@pytest.fixture(autouse=True)
def own_home(tmp_path_factory, monkeypatch):
    """Progress and answers of these tests go to a folder of their own; calibrations stay where they are."""
    monkeypatch.setenv("STEREO_LAB_WORK", str(tmp_path_factory.mktemp("work")))


@pytest.fixture(scope="module", params=[(r, n) for r in ("bench", "second_rig") for n in LESSONS], ids="-".join)
def asked(request):
    name, number = request.param
    return questions(number, open_recording(ROOT / "data" / name))


def test_there_are_five_at_least(asked):
    assert len(asked) >= 5 and [q.number for q in asked] == list(range(1, len(asked) + 1))


def test_untouched_stub(asked, capsys):
    for q in asked:
        q.check(____)
        assert capsys.readouterr().out == "NOT ATTEMPTED\n"
        assert q.carry(____) is q.reference
        if isinstance(q.answer, Function):
            q.check(lambda *_: ____)
            assert capsys.readouterr().out == "NOT ATTEMPTED\n"


def test_right_answers_pass(asked, capsys):
    for q in asked:
        for right in (q.reference, *q.answer.also):
            q.check(right)
            out = capsys.readouterr().out
            assert out.startswith("PASS - "), (q.name, out)
            assert q.carry(right) is right


def test_wrong_answers_get_their_own_message(asked, capsys):
    for q in asked:
        assert q.answer.wrong, f"{q.name} knows no wrong answer"
        for wrong in q.answer.wrong:
            q.check(wrong.answer)
            assert capsys.readouterr().out == f"NOT YET - {wrong.message}\n", q.name
            assert q.carry(wrong.answer) is q.reference
            assert "go on with the kit's answer" in capsys.readouterr().out
        assert q.carry(____) is q.reference and q.carry(q.reference) is not None
        assert capsys.readouterr().out == ""


def answer_in_words(kind):
    """One line for the right answer and one for each mistake that is known; functions say what they give."""

    def said(answer):
        if callable(answer):
            tries = [(a, _given(answer, a)) for a in kind.inputs]
            return "; ".join(f"{in_words(a)} -> {in_words(given)}" for a, given in tries)
        return in_words(answer)

    room = f" (± {kind.tolerance:#.3g} {kind.unit})" if hasattr(kind, "tolerance") else ""
    return [f"right{room}: {said(kind.right)}", *(f"{said(w.answer)}: {w.message}" for w in kind.wrong)]


def _given(function, arguments):
    try:
        with np.errstate(all="ignore"):
            return function(*arguments)
    except (ValueError, ZeroDivisionError) as error:
        return type(error).__name__


def in_words(value):
    """Numbers to four digits; of a large array, its shape and mean."""
    if isinstance(value, (str, bool, np.bool_)) or value is None:
        return str(value)
    if isinstance(value, (list, tuple)):
        return "(" + ", ".join(map(in_words, value)) + ")"
    try:
        array = np.asarray(value, float)
    except TypeError:
        return type(value).__name__
    if array.size > 12:
        return f"array {array.shape}, mean {array.mean():#.4g}"
    return " ".join(f"{v:#.4g}" for v in array.ravel())


def test_answers_are_those_written_down(asked, request):
    name = request.node.callspec.id
    lines = [line for q in asked for line in (q.name, *answer_in_words(q.answer))]
    assert_as_written(f"answers/{name}", lines, {"absolute": 0.02, "relative": 0.001})


def test_other_wrong_answers_never_raise(asked, capsys):
    for q in asked:
        for nonsense in (None, "?", float("nan"), [], np.zeros((2, 3)), object(), lambda: None, {"a": 1}, 1e300):
            q.check(nonsense)
            assert capsys.readouterr().out.startswith("NOT YET - "), (q.name, nonsense)


def test_hints_are_staged_and_solutions_shown(asked, capsys):
    for q in asked:
        assert len(q.hints) >= 3
        for k in range(len(q.hints) + 1):
            q.hint()
            assert capsys.readouterr().out.startswith(f"Hint {min(k + 1, len(q.hints))} of")
        assert any("____" in hint for hint in q.hints[-1:]), f"{q.name}: the last hint is a line with a hole"
        q.solution()
        out = capsys.readouterr().out
        assert q.code.splitlines()[0] in out and q.reason in out


def names_above(lesson, recording):
    """What stands above the questions of a lesson, made of the renderer's truth instead of by the kit."""
    calibration = calibrate_recording(recording)

    def centers(set_name, name):
        true = recording.true_ball(set_name, name)
        return [calibration.rectify_points([true[side][:2]], side)[0] for side in ("left", "right")]

    if lesson == "00":
        pair, true = recording.pairs("evaluation")[0], recording.true_ball("evaluation", "000")
        balls = {f"ball_{side}": Detection(*true[side], 1.0) for side in ("left", "right")}
        return {"left": pair.left, **balls}
    if lesson == "01":
        cameras = recording.truth["cameras"]
        steps = np.subtract(cameras["left"]["position_mm"], cameras["right"]["position_mm"])
        return {"T": steps, "np": np, "recording": recording}
    if lesson == "02":
        return {
            "pixel": (30, 40, 200),
            "np": np,
            "hls_pixel": cv2.cvtColor(np.uint8([[(30, 40, 200)]]), cv2.COLOR_BGR2HLS)[0, 0],
        }
    if lesson == "03":
        samples = [s for s in recording.samples("position") if s.use == "fit"]
        ends = sorted((centers("position", s.pair.name)[0][1], s.measured.y_mm) for s in samples)
        (v0, y0), (v1, y1) = ends[0], ends[-1]
        across = [(centers("position", s.pair.name)[0][0], s.measured.x_mm) for s in samples]
        return {"v0": v0, "y0": y0, "v1": v1, "y1": y1, "x_line": LineFit.fit(*zip(*across, strict=True))}
    if lesson == "04":
        (u_left, _), (u_right, _) = centers("depth", "000")
        return {"u_left": u_left, "u_right": u_right, "calibration": calibration}
    if lesson == "05":
        return {"l1": recording.arm.l1_mm, "l2": recording.arm.l2_mm, **vars(math)}
    if lesson == "07":
        return {"elbow_deg": elbow_deg, "shoulder_deg": shoulder_deg}
    if lesson == "09":
        return {"np": np}
    return {}


def test_solutions_run_and_pass(request, asked, capsys):
    """Each shown solution, run under the names of its notebook, gives an answer that passes."""
    recording_name, number = request.node.callspec.params["asked"]
    names = names_above(number, open_recording(ROOT / "data" / recording_name))
    for q in asked:
        exec(compile(q.code, q.name, "exec"), names)
        last = ast.parse(q.code).body[-1]
        q.check(names[last.name if isinstance(last, ast.FunctionDef) else last.targets[0].id])
        out = capsys.readouterr().out
        assert out.startswith("PASS - "), (q.name, out)


def test_the_last_hint_can_be_pasted(request, asked, capsys):
    """As it stands it is no attempt, and stops nothing: a line of the cell, or the body of its function."""
    recording_name, number = request.node.callspec.params["asked"]
    names = {"np": np, **names_above(number, open_recording(ROOT / "data" / recording_name)), "____": ____}
    for q in asked:
        line = q.hints[-1].rpartition(":\n    ")[2]
        if isinstance(q.answer, Function):
            told = q.code.splitlines()
            head = next(part for part in told if part.startswith("def "))
            unpacked = [part for part in told if "X, Y, Z =" in part]
            line = "\n".join([head, *unpacked, f"    {q.hints[-1]}"])
        exec(compile(line, q.name, "exec"), names)
        last = ast.parse(line).body[-1]
        q.check(names[last.name if isinstance(last, ast.FunctionDef) else last.targets[0].id])
        assert capsys.readouterr().out == "NOT ATTEMPTED\n", (q.name, line)


def test_unknown_lesson():
    with pytest.raises(StereoLabError, match="no questions"):
        questions("99", None)


def test_blank_stays_a_blank():
    assert repr(____) == "____" and (____ + 1) is ____ and (2 - ____)[0] is ____ and ____.u is ____
    assert (np.float64(2) * ____) is ____ and (np.ones(3) - ____) is ____
    assert judge(Number(1.0, 0.1), [1, ____]).status == "NOT ATTEMPTED"


def test_a_thing_that_is_no_number_names_those_it_holds(bench):
    told = judge(Number(2.0, 0.1, "mm"), calibrate_recording(bench)).text
    assert ".baseline_mm" in told and ".focal_px" in told and ".image_size" not in told
    assert judge(Number(2.0, 0.1, "mm"), bench.samples("depth")[0]).text.endswith("this is a Sample.")


def test_progress_is_counted(capsys):
    number = dict(asks="?", hints=("a", "b", "c ____"), code="x = 1", reason="so", reference=1.0)
    first, second = lesson("77", dict(number, answer=Number(1.0, 0.1)), dict(number, answer=Number(2.0, 0.1)))
    first.check(1.0)
    first.check(1.05)
    second.check(2.0)
    lines = capsys.readouterr().out.splitlines()
    assert [line.split("(")[1] for line in lines] == ["lesson 77: 1 of 2)", "lesson 77: 1 of 2)", "lesson 77: 2 of 2)"]


@pytest.mark.parametrize(
    ("kind", "answer", "says"),
    [
        (Number(2.0, 0.1, "mm"), 3, "3 mm is too large"),
        (Number(2.0, 0.1, "mm"), "to", "expected a number"),
        (Number(2.0, 0.1, "mm"), [2.0, "mm"], "a number and a text stand side by side"),
        (Number(2.0, 0.1, "mm"), "2 and -2", "in this text there are 2"),
        (Number(200.0, 20.0, "degrees"), -190, "the sign is turned"),
        (Number(2.0, 0.1, "mm", beside=((".*far.*", "how far?"),)), "Very far.", "how far?"),
        (Number(2.0, 0.1, "mm"), LineFit(2.0, 1.0, (0.0,)), "Take a number out of it: .offset_mm, .slope_mm_per_px."),
        (Number((9, 6), 0, labels=(("across",), ("down",))), (4, 7), "across 4 is too few, down 7 is too many"),
        (Choice("up", (Wrong("down", "no"),), "yes"), "0", "a number is no answer here"),
        (Command("MV 2 -30"), "MV 1 2 -30", "one line turns one joint"),
        (Command("MV 2 -30"), b"MV 2 -30", "leave it away"),
        (Number((1.0, 2.0), 0.1, "mm"), (1.0, 5.0), "the second number is 5 mm"),
        (Number((1.0, 2.0), 0.1, "mm"), 1.0, "expected 2 numbers"),
        (Number(2.0, 0.1, "", (Wrong(-2.0, "sign"),)), -2, "sign"),
        (Choice("up", (Wrong("down", "no"),), "yes"), "sideways", "not among"),
        (Choice("up", (Wrong("down", "no"),), "yes"), 7, "in quotes"),
        (Function(lambda x: x, ((1.0,), (2.0,)), 0.1), lambda x: 1 / 0, "ZeroDivisionError"),
        (Function(lambda x: x, ((1.0,), (2.0,)), 0.1), lambda x: None, "return"),
        (Function(lambda x: x, ((1.0,), (2.0,)), 0.1), lambda x: 1.0, "gives 1 whatever comes in"),
        (Function(lambda x: x, ((1.0,), (2.5,)), 0.1), lambda x: x if x < 2.2 else x + 3, "right for 1 of 2"),
        (
            Function(lambda x: x, ((1.0,), (2.5,)), 0.1),
            lambda x: x if x < 2 else x**4,
            "twice as large it should bring",
        ),
        (Function(lambda x: x, ((1.0,), (2.0,)), 0.1), 3.0, "expected a function"),
        (Function(lambda x: x, ((1.0,),), 0.1), lambda x: x ^ 2, "**"),
        (Function(math.acos, ((0.5,),), 0.1, domain="brackets?"), lambda x: math.acos(x + 1), "brackets?"),
        (
            Function(math.acos, ((0.5,),), 0.1, wrong=(Wrong(lambda x: math.acos(2), "no"),)),
            lambda x: 9.0,
            "x changes nothing",
        ),
        (Command("MV 2 -30"), "MV 2 −30", "minus of the keyboard"),
        (Command("MV 2 -30"), "MV 2 -30°", "degrees anyway"),
        (Command("MV 2 -30"), "MV 2, -30", "no comma"),
        (Command("MV 2 -30"), "'MV 2 -30'", "no quotes inside"),
        (Function(lambda x: 2 * x, ((1.0,),), 0.1), lambda x: str(2 * x), "gives back a text, '2.0'"),
        (Command("MV 2 -30"), "MV 2", "this has 2"),
        (Command("MV 2 -30"), "GO 2 -30", "says something else"),
        (Command("MV 2 -30"), -30, "in quotes"),
    ],
)
def test_what_a_wrong_answer_is_told(kind, answer, says):
    verdict = judge(kind, answer)
    assert verdict.status == "NOT YET" and says in verdict.text


class Trap:
    """An object each of whose answers is an error, a SystemExit here and there."""

    def _stop(self, *_):
        raise SystemExit(7)

    __eq__ = __float__ = __array__ = __repr__ = __str__ = __len__ = __iter__ = __call__ = __bool__ = _stop
    __hash__ = None

    def __getattr__(self, name):
        raise RuntimeError(name)

    @property
    def __class__(self):
        raise RuntimeError("class")


class Liar(str):
    """A text that says yes to everything."""

    def __eq__(self, other):
        return True

    __hash__ = str.__hash__

    def strip(self):
        return self

    def lower(self):
        return self

    def __repr__(self):
        raise ValueError


class Wordless(Exception):
    def __str__(self):
        raise RuntimeError


def itself():
    """A list, a dictionary and a tuple that contain themselves."""
    rows, names = [], {}
    rows.append(rows)
    names["a"] = (names, rows)
    return rows, names, (rows, names)


def deep():
    """A list in a list in a list …"""
    inside = [1.0]
    for _ in range(100_000):
        inside = [inside]
    return inside


def raising(error):
    def stop(*_):
        raise error

    return stop


KINDS = (
    Number(1.0, 0.1, "mm"),
    Number((1.0, 2.0), 0.1, "mm"),
    Choice("up", (Wrong("down", "no"),), "yes"),
    Function(lambda x: x, ((1.0,), (2.0,)), 0.1),
    Function(lambda x: np.array([x, x]), ((1.0,), (2.0,)), 0.1),
    Command("MV 2 -30"),
)
ODD = {
    "itself": itself()[0], "itself in a dictionary": itself()[1], "itself in a tuple": itself()[2], "deep": deep(),
    "trap": Trap(), "trap in a list": [Trap(), Trap()], "liar": Liar("no"), "huge": 10**5000, "huge pair": [10**400, 1],
    "True": True, "numpy True": np.True_, "array True": np.array([True, True]), "True in a list": [True, 2.0],
    "complex": 1 + 0j, "complex array": np.array([1 + 5j, 2 + 5j]), "objects": np.array([None, Trap], object),
    "surrogate": "\ud800", "superscript": "MV 2 ²", "class": Trap, "bytes": b"\xff", "exit": builtins.exit,
    "sys.exit": sys.exit, "SystemExit": raising(SystemExit()), "GeneratorExit": raising(GeneratorExit()),
    "wordless": raising(Wordless()), "unprintable": raising(ValueError("\ud800")), "recursion": raising(RecursionError()),
    "gives itself": lambda *_: itself()[0], "gives a trap": lambda *_: Trap(), "gives True": lambda *_: True,
    "gives huge": lambda *_: 10**5000, "gives exit": lambda *_: builtins.exit,
}  # fmt: skip


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: type(kind).__name__)
@pytest.mark.parametrize("name", ODD)
def test_odd_answers_never_raise(kind, name, capsys):
    (q,) = lesson("00", dict(asks="?", hints=("a",), code="x = 1", reason="so", reference="given", answer=kind))
    q.check(ODD[name])
    said = capsys.readouterr().out
    assert said.startswith("NOT YET - ") and said.count("\n") == 1
    said.encode("utf-8")
    assert q.carry(ODD[name]) == "given"


def test_exit_is_not_called(monkeypatch):
    """Calling it would close standard input, or end the notebook's kernel."""
    from IPython.core.autocall import ExitAutocall

    monkeypatch.setattr(type(builtins.exit), "__call__", lambda *_: pytest.fail("called"))
    monkeypatch.setattr(ExitAutocall, "__call__", lambda *_: pytest.fail("called"))
    for answer in (builtins.exit, builtins.quit, ExitAutocall()):
        assert "belongs to Python" in judge(Function(lambda: 1.0, ((),), 0.1), answer).text


def test_a_blank_is_found_in_what_contains_itself():
    rows = itself()[0]
    rows.append({"a": (1, np.array([____, 2], object))})
    assert judge(Number(1.0, 0.1), rows).status == "NOT ATTEMPTED"


def test_true_is_right_where_it_is_asked_for():
    kind = Function(lambda x: x > 1, ((1.0,), (2.0,)), 0)
    assert judge(kind, lambda x: bool(x > 1)).status == judge(kind, lambda x: np.greater(x, 1)).status == "PASS"
    assert (
        "for x = 1 it says False, and True is expected"
        in judge(Function(lambda x: x == 1, ((1.0,), (2.0,)), 0), lambda x: x > 1).text
    )
    assert "x changes nothing in your answer" in judge(kind, lambda x: True).text
    assert "this is True or False" in judge(Number(1.0, 0.1), True).text


def test_the_learner_can_stop_a_function_that_does_not_end():
    with pytest.raises(KeyboardInterrupt):
        judge(Function(lambda x: x, ((1.0,),), 0.1), raising(KeyboardInterrupt()))


def test_a_function_cannot_change_its_inputs():
    array = np.zeros(3)

    def spoil(a):
        a += 1
        return a

    judge(Function(lambda a: a, ((array,),), 0.1), spoil)
    assert not array.any()


@pytest.mark.parametrize(
    ("kind", "answer"),
    [
        (Number(120.5, 0.5, "mm"), "120.5 mm"), (Number(120.5, 0.5, "mm"), "120,5"), (Number(120.5, 0.5, "mm"), "120.5mm."),
        (Number(2.0, 0.05), "twice"), (Number(2.0, 0.05), "2x"), (Number(-1.4, 0.05), "−1.4 mm per px"),
        (Number((9, 6), 0), "9x6"), (Number((9, 6), 0), "9*6"), (Number((9, 6), 0), "9 across, 6 down"), (Number((9, 6), 0), "(9, 6)"),
        (Choice("grows", (Wrong("shrinks", "no"), Wrong("stays", "no")), "yes"), "The jump grows."),
        (Choice("bends it", (Wrong("moves it", "no"), Wrong("nothing", "no")), "yes"), "it bends"),
        (Choice("unseen pairs", (Wrong("the same pairs", "no"), Wrong("more decimals", "no")), "yes"), ["'unseen'"]),
        (Choice("a ring", (Wrong("a line", "no"), Wrong("nothing", "no")), "yes"), "The ring"),
        (Choice("right", (Wrong("left", "no"),), "yes"), "right, not left"), (Choice("right", (Wrong("left", "no"),), "yes"), "not left, but right"),
        (Number(120.5, 0.5, "mm"), "12.05 cm"), (Number(120.5, 0.5, "mm"), "0.1205 m"), (Number(2.0, 0.1, "times"), "two-fold"), (Number(2.0, 0.1, "times"), "twofold"),
        (Number(-1.4, 0.1, "mm per px"), "-1.4 (mm/px)"), (Number(-1.4, 0.1, "mm per px"), "-1.4 mm"), (Number(2.0, 0.1, "times"), "one twice as long"),
        (Number(120.5, 0.5, "mm"), "120.5 mm (12.05 cm)"), (Number(-1.4, 0.1, "mm per px"), "-1.4 mm/pixel"),
        (Number(200, 0, "of 255"), "200 of 255"), (Number(115.6, 0.1, "px"), "316.2 px - 200.6 px = 115.6 px"),
        (Number((9, 6), 0), "nine, six"), (Number((9, 6), 0, labels=(("across",), ("down",))), "6 down and 9 across"),
        (Number((9, 6), 0), [[9, 6]]), (Number((9, 6), 0, labels=(("across",), ("down",))), "6 down, 9 across"),
        (Function(lambda hue: hue <= 7, ((np.array([3, 8]),),), 0), lambda hue: [h <= 7 for h in hue]),
    ],
)  # fmt: skip
def test_the_form_of_a_right_answer_does_not_matter(kind, answer):
    assert judge(kind, answer).status == "PASS", judge(kind, answer)


@pytest.mark.parametrize(
    ("kind", "answer", "told"),
    [
        (Choice("grows", (Wrong("shrinks", "no"), Wrong("stays", "no")), "yes"), "not grows", "says what it is not"),
        (Choice("grows", (Wrong("shrinks", "no"), Wrong("stays", "no")), "yes"), "grows or shrinks", "two of the answers"),
        (Choice("unseen pairs", (Wrong("the same pairs", "no"), Wrong("more", "no")), "yes"), "pairs", "not among"),
        (Choice("right", (Wrong("left", "no"),), "yes"), "never right", "says what it is not"),
        (Choice("right", (Wrong("left", "no"),), "yes"), "it can't be right", "says what it is not"),
        (Choice("right", (Wrong("left", "no left"),), "yes"), "left, not right", "no left"),
        (Number(115.6, 0.5, "px"), (115, 6), "Write 115.6 with a point"), (Number(640, 0, "px"), (480, 640), "these are 2."),
        (Number(120.5, 0.5, "mm"), "120.5 px", "mm is asked for, this is px"), (Number(2.0, 0.1, "times"), "2 mm", "without mm"),
        (Number(-1.4, 0.1, "mm per px"), "-1.4 px/mm", "this is px per mm"), (Number(2.0, 0.1), "not 2", "this is a text"),
        (Number(120.5, 0.5, "mm"), "np.linalg.norm(T)", "Python in quotes"), (Number(2.0, 0.1), math.sqrt, "not called"),
        (Number(120.5, 0.5, "mm"), 0.1205, "a thousand times too small"), (Number(120.4, 0.1, "mm"), 120, "rounded too much"),
        (Number((9, 6), 0), (6, 9), "in another order"),
        (Function(lambda x, y: x + 2 * y, ((1.0, 3.0), (2.0, 5.0)), 1e-6), lambda x, y: y + 2 * x, "changed places"),
        (Function(lambda x, y: x / y, ((1.0, 3.0), (2.0, 5.0)), 1e-6), lambda x, y: -x / y, "the sign is turned"),
        (Function(lambda x, y: x / y, ((1.0, 3.0), (2.0, 5.0)), 1e-6), lambda x, y: round(x / y, 1), "you round"),
        (Function(lambda x, y: 9 * x / y, ((1.0, 4.0), (2.0, 5.0)), 1e-6), lambda x, y: 9 * x // y, "cut off"),
        (Function(lambda x, y: x / y, ((1.0, 3.0), (2.0, 5.0)), 1e-6), lambda x, y: x / 3.5, "y changes nothing"),
        (Function(lambda x, y: x / y, ((1.0, 3.0), (2.0, 5.0)), 1e-6), lambda x, y: 1.5 * x * x / y, "x is squared in your result, and should count once"),
        (Function(lambda x, y: x / y, ((1.0, 3.0), (2.0, 5.0)), 1e-6), lambda x, y: x, "gives x back"),
        (Function(lambda x, y: x / y, ((1.0, 3.0), (2.0, 5.0)), 1e-6), lambda x, y: 7.5, "whatever comes in"),
        (Function(lambda x, y: x / y, ((1.0, 3.0), (2.0, 5.0)), 1e-6), lambda x, y: 1000 * x / y, "a thousand times"),
        (Function(lambda x, y: (x, y), ((1.0, 3.0), (2.0, 5.0)), 1e-6), lambda x, y: (x, y + x), "the second number: "),
        (Function(lambda x, y: (x, y), ((1.0, 3.0), (2.0, 5.0)), 1e-6), lambda x, y: [[x], [y]], "more brackets"),
        (Function(lambda x: x.sum(), ((np.arange(5.0),),), 1e-6), lambda x: x, "Is a sum or a mean missing?"),
        (Function(lambda x: x <= 7, ((np.array([3, 8]),),), 0), lambda x: x <= 9, "for x = 8 it says True"),
        (Function(lambda x: x.mean(), ((np.arange(5.0),),), 1e-6), lambda x: x.sum() / (x - x.mean()).sum(), "no bounds"),
        (Number(120.5, 0.5), "12 or 120.5", "expected a number"),
        (Number(2047.2, 0.5), "4094.4/2", "Python in quotes"), (Number(2047.2, 0.5), "180/360*4094.4", "Python in quotes"),
        (Number(8.0, 0.5, "mm"), "1 to 8 mm", "there are 2"), (Number(8.0, 0.5, "mm"), "3 degrees, 8 mm", "there are 2"),
        (Number(50.0, 0.5, "mm"), (50, 450), "Which one of them?"), (Number(2.0, 0.1, "times"), "a wider one", "this is a text"),
        (Number(-1.4, 0.1, "mm per px"), "-1.4 px", "mm per px is asked for, this is px"),
        (Function(lambda n: 3 / n, ((3,), (7,)), 1e-6, also=(lambda n: 2.9 / n,)), lambda n: round(2.9 / n, 2), "you round"),
        (Function(lambda n: 3 / n, ((3,), (7,)), 1e-6), lambda n: np.ceil(300 / n) / 100, "in steps of 0.01"),
        (Number(180.0, 0.5), "180 * 1 s", "there are 2"), (Number(180.0, 0.5), "one hundred eighty", "this is a text"),
        (Number(640.0, 0.5), np.zeros(3), "these are 3."),
        (Number((9.0, 6.0), 0.1), 9, "expected 2 numbers, this is one"),
        (Number(20.0, 0.05, "mm", (Wrong(0.02, "in metres"),)), 0.0, "too small"),
        (Number(4.0, 0.01, "", known={"a": 3.0, "b": 7.0}, ask="How far apart?"), 21.0, "that is a * b. How far apart?"),
        (Number(4.0, 0.01, known={"a": 3.0, "b": 7.0, "c": 2.5}), (3 - 7) / 2.5, "that is (a - b) / c."),
        (Number(4.0, 0.01, known={"a": 3.1, "b": 7.3, "c": 2.5, "d": 9.7}), (3.1 - 7.3) * (2.5 - 9.7), "that is (a - b) * (c - d)."),
        (Number(4.0, 0.01, known={"a": 3.0}, ask="And now?"), 50, "50 is too large. And now?"),
        (Number(120.54, 0.05, "mm"), 122, "near, and not right yet"), (Number(120.54, 0.05, "mm"), 120, "cut off too early"),
        (Number(640, 0, "px"), 641, "one too many"), (Number(7.0, 0.5, "mm"), -70, "ten times too large, and the sign is turned"),
        (Number(9.0, 0.5, small="so near?"), 5, "5 is too small: so near?"), (Number(9.0, 0.5, large="so far?"), 50, "50 is too large: so far?"),
        (Number(9.0, 0.5, wrong=(Wrong(9.1, "by chance", exact=True),)), 9.1, "by chance"),
        (Number(9.0, 4, wrong=(Wrong(200.0, "first"), Wrong(203.0, "nearest"))), 203, "nearest"),
        (Number(9.0, 0.5, wrong=(Wrong(3.14159, "a turn"),)), 3.14, "a turn"),
        (Number((9.0, 6.0), 0), (9, 5), "the first number is right; the second number is 5"),
        (Function(lambda x, y: x / y, ((1.0, 3.0), (2.0, 5.0)), 1e-6), lambda x, y: 2.2 * x * y, "y stands above the line, and belongs below it."),
        (Function(lambda x, y: x / y, ((1.0, 3.0), (2.0, 5.0)), 1e-6), lambda x, y: x / (y + 1), "twice as large a y should bring 0.5 times the result, whatever the other numbers are; yours goes from"),
        (Function(lambda x, y: x / y + 300, ((1e7, 3.0), (2e7, 5.0)), 1e-6), lambda x, y: x * y + 300, "look at y: twice as large"),
        (Function(lambda x, y, c: x / y + c, ((1e4, 3.0, 9.0), (2e4, 5.0, 8.0)), 1e-6), lambda x, y, c: x * y + c, "look at y: twice as large"),
        (Function(lambda x, y: x + 3 * y, ((1.0, 3.0), (2.0, 5.0)), 1e-6), lambda x, y: x - 3 * y, "as if y had its sign turned"),
        (Function(lambda x, y: (x + 3 * y, x * y), ((1.0, 3.0), (2.0, 5.0)), 1e-6), lambda x, y: (y + 3 * x, x * y), "x and y had changed places"),
        (Function(lambda x, y, z: x + y * z, ((1.0, 3.0, 4.0), (2.0, 5.0, 7.0)), 1e-6), lambda x, y, z: x + y + 2 * z, "y is divided by z where it should not be, or not multiplied by it"),
        (Function(lambda x: x + 3, ((1.0,), (2.5,)), 1e-6), lambda x: x + 8, "in every try your result is 5 too large"),
        (Function(lambda x: (x, x), ((1.0,),), 0.1), lambda x: {x, 2 * x}, "curly brackets make a set"),
        (Function(lambda x: (x, x), ((1.0,),), 0.1), lambda x: {"x": x, "y": x}, "curly brackets make a dictionary"),
        (Function(lambda x: x, ((1.0,),), 0.1), lambda x: (x - 2) ** 0.5, "the root of a number below zero"),
        (Choice("up", (Wrong("down", "no"),), "yes", beside=((".*side.*", "which of the two?"),)), "To the side.", "which of the two?"),
        (Choice("up", (Wrong("down", "no"),), "yes"), "both", "two of the answers"),
        (Choice("up", (Wrong("down", "no"),), "yes", same=(("^sky$", "up"), ("^(earth|soil)$", "down"))), "Soil.", "no"),
        (Command("MV 2 -30"), "MV2 -30", "a blank is missing"), (Command("MV 2 -30"), "MV 2 - 30", "the minus belongs to its number"),
        (Command("MV 2 -30"), "MV 2 -30 degrees", "counts in degrees anyway"), (Command("MV 2 -30"), "MV(2 -30)", "no brackets"),
        (Command("MV 2 -30"), "MV 2 -40", "that turns it to -40 degrees."),
        (Function(lambda x: x, ((1.0,),), 0.1), lambda x: np.array([x]), "a list with one thing"),
        (Function(lambda x: (x, x), ((1.0,),), 0.1), lambda x: (str(x), str(x)), "the 2 numbers themselves"),
        (Function(lambda x: x + 144.27, ((1.0,),), 0.01), lambda x: round(x + 144.27, 1), "you round"),
        (Function(lambda x: x + math.pi, ((1.0,),), 1e-9), lambda x: x + 3.14159, "right but for 3.14159, which is rounded. Python knows π"),
        (Function(lambda x, y: math.radians(x) * y, ((1.0, 2.0),), 1e-9), lambda x, y: x / 57.3 * y, "right but for 57.3, which is rounded. degrees() and radians()"),
        (Function(lambda x: x + 1 / 3, ((1.0,),), 1e-9), lambda x: x + 0.33333, "only nearly"),
        (Function(lambda x: x, ((1.0,),), 0.1), lambda: 1.0, "must take 1: x"),
        (Function(lambda x: x, ((np.ones(3),),), 0.1), lambda x: x or x, "write | and &"),
        (Function(lambda x: x, ((np.ones(3),),), 0.1), lambda x: math.sqrt(x), "from np"),
        (Function(lambda x: x, ((1.0,),), 0.1), lambda x: math.hypot((x, 2 * x)), "take the inner brackets away"),
        (Function(lambda x: x, ((1.0,),), 0.1), lambda x: math.sqrt([x, 2 * x]), "take one with [0] or [1]"),
        (Function(lambda x: x, ((1.0,),), 0.1), lambda x: x(2), "a * is missing"),
        (Function(lambda x: x, ((1.0,),), 0.1), lambda x: c_u + x, "not known here"),  # noqa: F821
        (Function(lambda h: (h <= 7) | (h >= 172), ((np.uint8([0, 7, 8, 90, 172, 179]),),), 0), lambda h: (h - 172) % 180 <= 15, "h holds bytes, and below 0 a byte goes on from 255"),
        (Number(115.65, 0.12, "px", (Wrong(115.86, "up and down as well"),)), 116, "rounded too much"),
        (Number(115.65, 0.12, "px", (Wrong(115.86, "up and down as well"),)), 115.9, "up and down as well"),
        (Function(lambda x: x / x.sum(), ((np.array([1.0, 3.0]),), (np.array([1.0, 3.0, 5.0]),)), 1e-6), lambda x: x / x.cumsum(), "for x = (1, 3) it gives (1, 0.75)"),
        (Function(lambda x: x / x.sum(), ((np.array([1.0, 3.0]),),), 1e-6), lambda x: (x / x.sum()).mean(), "one for each is asked for. Is an index, a sum or a mean taken"),
        (Function(lambda x: np.exp(x), ((np.array([1.0, 3.0]),),), 1e-6), lambda x: exp(x), "write np.exp"),  # noqa: F821
        (Function(lambda x: np.log(x), ((np.array([1.0, 3.0]),),), 1e-6), lambda x: np.log(-x), "a root or a logarithm is taken of a number below zero"),
        (Function(lambda x: 1 / x, ((5.0,), (8.0,)), 1e-6, also=(lambda x: 1 / (x + 0.01),)), lambda x: -1 / (x + 0.01), "right but for its sign"),
        (Function(lambda x, y: y / x, ((100.0, 49.0), (10.0, 2.7)), 1e-6), lambda x, y: 0.5 if x > 50 else 0.3, "changes nothing in your result"),  # what looks rounded by chance is not called so
        (Number(-1.5, 0.01, "mm per px"), "0.15 cm per px", "the sign is turned"), (Number(-1.5, 0.01, "mm per px"), "1.5 mm per s", "mm per px is asked for"),
        (Number(200, 0, "of 255"), "(30,40,200)", "in this text there are 3"), (Number(640, 0, "px", of_several="Which one?"), (640, 3), "Which one?"),
        (Choice("bends it", (Wrong("nothing", "no"),), "yes", same=((".*not straight.*", "bends it"),)), "it isn't bending", "\"it isn't bending\" says what it is not"),
        (Function(lambda x, y: math.hypot(x, y), ((3.0, 4.0), (1.0, 2.0)), 1e-6), lambda x, y: x + y**2, "look at y"),
        (Function(lambda x: x, ((1.0,),), 0.1), lambda x: math.hypot, "Put () after it"),
        (Function(lambda x: x, ((np.ones(3),), (np.ones(2),)), 0.1), lambda x: x[:2], "it gives 2 numbers, and 3 are asked for"),
        (Function(lambda x: x.sum(0), ((np.ones((3, 2)),),), 0.1), lambda x: x @ np.ones(3), ".T turns a table round"),
        (Function(lambda p: -np.log(p), ((0.9,), (0.4,)), 1e-6, held=("p",)), lambda p: 0.4 - p, "for p = 0.9 it gives -0.5, and 0.1054 is expected"),
        (Function(lambda p: -np.log(p), ((0.9,), (0.4,)), 1e-6, endless="the logarithm of 0."), lambda p: -np.log(p - p), "no bounds: the logarithm of 0."),
        (Function(lambda y: y, ((np.array([0.0, 1.0]),),), 1e-6), lambda y: y[None], "in more brackets"),
    ],
)  # fmt: skip
def test_a_slip_is_named_in_plain_words(kind, answer, told):
    verdict = judge(kind, answer)
    assert verdict.status == "NOT YET" and told in verdict.text, verdict


@pytest.mark.parametrize(
    "answer", [lambda x: math.hypot(x, ____), lambda x: np.hypot(x, ____), lambda x: (x > 1) | (____)]
)
def test_a_blank_left_in_a_function_is_no_attempt(answer):
    assert judge(Function(lambda x: x, ((1.0,),), 0.1), answer).status == "NOT ATTEMPTED"


@pytest.mark.parametrize(
    ("kind", "answer", "carried"),
    [
        (Number(7.9, 0.1, "mm"), "7.9 mm", 7.9), (Number(7.9, 0.1, "mm"), "0.79 cm", 7.9), (Number(7.9, 0.1, "mm"), [7.9], 7.9),
        (Number(7.9, 0.1, "mm"), np.array([7.9]), 7.9), (Number(3, 0, ""), "three", 3.0), (Number((9, 6), 0), "9x6", (9.0, 6.0)),
        (Number((9, 6), 0), ("9", "6"), (9.0, 6.0)),
    ],
)  # fmt: skip
def test_what_is_carried_can_be_counted_with(kind, answer, carried):
    (q,) = lesson("77", dict(asks="?", hints=("a",), code="x = 1", reason="so", reference=0.0, answer=kind))
    assert q.carry(answer) == carried and type(q.carry(answer)) is type(carried)


def test_a_function_that_gives_a_list_is_carried_as_one_that_gives_an_array():
    kind = Function(lambda x: 2 * x, ((np.array([1.0, 2.0]),),), 1e-6, "", (Wrong(lambda x: x, "twice"),))
    (q,) = lesson("77", dict(asks="?", hints=("a",), code="x = 1", reason="so", reference=None, answer=kind))
    listed, whole = lambda x: [2 * v for v in x], lambda x: x + x
    assert (q.carry(listed)(np.array([3.0, 4.0])) - 1).tolist() == [5.0, 7.0] and q.carry(whole) is whole


def test_nothing_in_quotes_is_no_attempt():
    assert judge(Choice("a ring", (Wrong("a line", "no"),), "yes"), " ").status == "NOT ATTEMPTED"


def test_a_blank_in_quotes_is_no_attempt():
    assert judge(Choice("a ring", (Wrong("a line", "no"),), "yes"), "a ____").status == "NOT ATTEMPTED"


@pytest.mark.parametrize(
    ("words", "says"),
    [
        ("left or right", "these are two of the answers. Take one: left; right."),
        ("not left", "'not left' says what it is not. Say what it is: left; right."),
        ("I don't know", "a wrong guess costs nothing. Take one: left; right."),
        ("?", "a wrong guess costs nothing. Take one: left; right."),
        ("up", "'up' is not among the answers: left; right."),
    ],
)
def test_words_that_are_no_answer_are_told_why(words, says):
    choice = Choice("right", (Wrong("left", "look again."),), "so it is.")
    verdict = choice.judge(words)
    assert verdict.status == "NOT YET" and verdict.text == says


@pytest.mark.parametrize(
    ("lesson", "number", "answer", "says"),
    [
        ("06", 1, "MV 02 -30", "NOT YET - a joint is told by one digit"),
        ("06", 1, "N6 MV 2 -30", "NOT YET - the number of the line is put before it for you"),
        ("06", 1, "MV 2 -30*AC", "NOT YET - the checksum is put behind it for you"),
        ("06", 1, "MV 2 -30 100", "PASS"),
        ("06", 1, "MV 2 -30 10", "NOT YET - expected 3 words"),
        ("06", 1, "MV 2 -30 400", "NOT YET - expected 3 words"),
        ("06", 1, "MV 2 -300", "NOT YET - that turns it to -300 degrees"),
        ("06", 5, "2,047", "PASS"),
        ("06", 5, "2,5", "NOT YET - 2.5 edges a second is too small"),
        ("06", 1, "MV 2 -0.524", "NOT YET - those are radians"),
        ("06", 1, "MV 2 -0.5236", "NOT YET - those are radians"),
        ("06", 5, "2 kHz", "NOT YET - 2000 edges a second is near"),
        ("06", 5, "2047.2 edges per minute", "NOT YET - edges a second is asked for"),
        ("05", 1, "60 ± 10 mm", "NOT YET - 60 mm is too large"),
        ("05", 5, "-1.22 rad", "NOT YET - -69.9 degrees is near"),
        ("05", 5, -70.5, "NOT YET - -70.5 degrees is near"),
        ("06", 6, 201.3, "PASS"),
        ("06", 6, 210, "NOT YET - 210 degrees is too large"),
        ("05", 1, 109, "NOT YET - that is where the stop of the elbow lets it come"),
        ("02", 3, 87, "NOT YET - that is its grey value"),
        ("02", 3, 0.299 * 200 + 0.587 * 40 + 0.114 * 30, "NOT YET - that is its grey value"),
        ("05", 6, 450 / 180, "NOT YET - half a turn has π radians"),
        ("09", 6, "another day in the same room", "NOT YET - better than the same film"),
        ("09", 6, "another room", "PASS"),
        ("09", 6, "a room it has never seen", "PASS"),
        ("09", 6, "on frames it has never seen, in another room", "PASS"),
        ("09", 6, "an unseen room", "PASS"),
        ("09", 6, "frames it has never seen", "NOT YET - "),
        ("09", 6, "the whole film", "NOT YET - the film has the twenty in it"),
        ("09", 8, "the lighter side", "PASS"),
        ("09", 8, "shade and dark", "PASS"),
        ("09", 8, "shade (and dark)", "PASS"),
        ("09", 8, "shade and rim", "NOT YET - "),
        ("09", 8, "contrast, shade", "NOT YET - these are two of the answers"),
        ("09", 8, "light", "NOT YET - that is what changes"),
        ("04", 1, "halves, then halves again", "NOT YET - the area of its picture does"),
        ("04", 1, "is multiplied by 2", "NOT YET - far things jump less"),
        ("04", 1, "goes down by the same amount", "NOT YET - then it would be below zero"),
        ("04", 1, "shrinks by a factor of 4", "NOT YET - the area of its picture does"),
        ("04", 2, 160, "NOT YET - that is rounded too much"),
        ("04", 4, "one per unknown", "NOT YET - yes. How many are they"),
        ("04", 4, "3 (m, n, c)", "NOT YET - so many, yes"),
        ("05", 5, "70° but negative", "NOT YET - yes. Write it as a number, with its sign"),
        ("04", 1, "halves the error", "NOT YET - another thing"),
        ("04", 6, "2 x 120.5 mm", "NOT YET - work it out"),
        ("03", 1, "0=m", "NOT YET - then y would be the same"),
    ],
)
def test_what_a_second_reader_typed(bench, lesson, number, answer, says):
    assert str(judge(questions(lesson, bench)[number - 1].answer, answer)).startswith(says)


@pytest.mark.parametrize(
    ("number", "formula", "says"),
    [
        (2, lambda l1, l2, s, t: tuple((l1 + l2) * f(math.radians(s + t)) for f in (math.cos, math.sin)), "only the forearm points to"),
        (3, lambda l1, l2, x, y: math.degrees(math.acos((x**2 + y**2 - l1**2 + l2**2) / (2 * l1 * l2))), "both squares are taken off"),
        (4, lambda l1, l2, x, y, t: math.degrees(math.atan2(y, x)) - t, "that takes off the elbow's whole angle"),
        (4, lambda l1, l2, x, y, t: math.degrees(math.atan2(y, x) - t), "θ2 is in degrees, and atan2 gives radians"),
    ],
)  # fmt: skip
def test_formulas_that_a_second_reader_typed(bench, number, formula, says):
    assert says in judge(questions("05", bench)[number - 1].answer, formula).text


@pytest.mark.parametrize(
    ("function", "says"),
    [
        (lambda u, v, du, dv, r: complex(u, v) + r * complex(du, dv), "Give back the 2 numbers themselves"),
        (lambda u, v, du, dv, r: map(lambda a, b: a + r * b, (u, v), (du, dv)), "a map gives its numbers only when"),
        (lambda u, v, du, dv, r: (a + r * b for a, b in ((u, du), (v, dv))), "Make a tuple of it"),
    ],
)
def test_two_numbers_in_one_thing_are_taken_apart(bench, function, says):
    assert says in judge(questions("02", bench)[3].answer, function).text


L, E = np.log, np.exp


@pytest.mark.parametrize(
    ("number", "formula", "says"),
    [
        (1, lambda x, y, a, b, c: np.mean(a * x + b * y + c), "each has its own sum: no mean"),
        (1, lambda x, y, a, b, c: [a * u + b * v + c for u, v in zip(x, y, strict=True)], "PASS"),
        (1, lambda x, y, a, b, c: np.dot(np.column_stack([x, y]), [a, b]) + c, "PASS"),
        (1, lambda x, y, a, b, c: (a * x, b * y, c), "Give back the numbers themselves, one for each"),
        (2, lambda s: E(s) / (1 + E(s).sum()), "here each thing stands by itself"),
        (2, lambda s: math.exp(s) / (1 + math.exp(s)), "take the function of that name from np"),
        (2, lambda s: [1 / (1 + math.exp(-v)) for v in s], "PASS"),
        (3, lambda p, y: -np.mean(L(p[y == 1])), "the loss of the balls alone"),
        (3, lambda p, y: np.mean(E(-p)), "for p = (0.9, 0.2), y = (1, 0) it gives"),
        (3, lambda p, y: -np.mean(L(p * y)), "somewhere the logarithm of 0 is taken"),
        (3, lambda p, y: -np.mean(y * L(p + 1e-9) + (1 - y) * L(1 - p + 1e-9)), "PASS"),
        (3, lambda p, y: -L(np.prod(np.where(y == 1, p, 1 - p))) / len(p), "0 has no logarithm"),
        (4, lambda x, p, y: x @ (p - y), ".T turns a table round"),
        (4, lambda x, p, y: x.T @ (p - y)[:, None] / len(y), "in more brackets than are asked for"),
        (4, lambda x, p, y: [np.mean((p - y) * x[:, k]) for k in range(x.shape[1])], "PASS"),
        (4, lambda x, p, y: x.T @ (p - y) / 2, "a mean of two things alone"),
        (4, lambda x, p, y: np.gradient(-np.mean(L(p))), "nothing comes out"),
        (5, lambda s: 1 / (1 + E(-s)) / (1 + (1 / (1 + E(-s))).sum()), "Share the odds"),
        (5, lambda s: np.argmax(s), "the number of the best one"),
        (5, lambda s: E(s - s.max()) / (1 + E(s - s.max()).sum()), 'not off "none"'),
        (5, lambda s: E(s - np.logaddexp.reduce(np.append(s, 0))), "PASS"),
        (7, lambda n: 100 * (1 - 0.05 ** (1 / n)), "PASS"),
        (7, lambda n: -100 * math.log(0.05) / n, "PASS"),
        (7, lambda n: 100 * 3.8415 / (n + 3.8415), "PASS"),
        (7, lambda n: 100 * (1 - 0.95 ** (1 / n)), "none shows 95 times of 100"),
        (7, lambda n: -L(0.05) / n, "that is the share"),
        (7, lambda n: 1 - 0.05**1 / n, "with brackets, for ** comes before"),
        (7, lambda n: 1 - math.exp(-3 / n), "that is the share"),
        (7, lambda n: 0.95**n, "that is how often none of n shows"),
        (7, lambda n: 300 // n, "the decimals are cut off"),
    ],
)  # fmt: skip
@pytest.mark.filterwarnings("error")
def test_formulas_of_learning_that_a_reader_typed(bench, number, formula, says):
    """And no warning of numpy's stands beside what is said."""
    assert says in str(judge(questions("09", bench)[number - 1].answer, formula))


@pytest.mark.parametrize("row", [200.0, 230.0])
def test_lesson_00_asks_about_the_two_balls_that_it_is_shown(row):
    """In equal rows as well, where the way between them is the jump."""
    left, right = Detection(300.0, 200.0, 20.0, 1.0), Detection(250.0, row, 20.0, 1.0)
    asked = questions("00", open_recording("bench"), balls=(left, right))[2]
    assert judge(asked.answer, 50.0).status == PASS


def test_a_function_that_writes_into_its_arguments_does_not_change_the_question(bench, capsys):
    question = questions("02", bench)[1]
    before = [np.copy(a) for arguments in question.answer.inputs for a in arguments]

    def in_place(hue):
        hue[:] = 0

    question.check(in_place)
    question.check(lambda hue: hue < 10)
    after = [a for arguments in question.answer.inputs for a in arguments]
    assert all(np.array_equal(a, b) for a, b in zip(before, after, strict=True))
    assert "PASS" not in capsys.readouterr().out


def cell(lesson, id):
    """The source of a notebook's cell."""
    (notebook,) = (ROOT / "notebooks").glob(f"{lesson}_*.ipynb")
    cells = json.loads(notebook.read_text(encoding="utf-8"))["cells"]
    return "".join(next(c for c in cells if c["id"] == id)["source"])


@pytest.mark.parametrize(
    ("guard", "told"),
    [
        ("pass", "and elbow_deg stops with ValueError"),
        ("return None", "and elbow_deg gives None"),
        ("return 'out of reach'", "and elbow_deg gives 'out of reach'"),
        ("return False", "and elbow_deg gives False"),
        ("return math.nan", "θ2 = nan°"),
        ("raise RuntimeError('out of reach')", "and elbow_deg stops with RuntimeError"),
    ],
)
def test_what_a_right_eq_5_does_beyond_the_rim_is_told(bench, capsys, guard, told):
    names = {"arm": bench.arm, "l1": bench.arm.l1_mm, "l2": bench.arm.l2_mm, "math": math}
    lines = [f"if abs(c) > 1: {guard}", "return math.degrees(math.acos(c))"]
    body = "".join(f"\n    {line}" for line in ("c = (x**2 + y**2 - l1**2 - l2**2) / (2 * l1 * l2)", *lines))
    exec(f"def elbow_deg(l1, l2, x, y):{body}", names)
    assert judge(questions("05", bench)[2].answer, names["elbow_deg"]).status == PASS
    exec(cell("05", "cell-30"), names)
    out = capsys.readouterr().out.splitlines()
    assert out[0].endswith("θ2 = 34.5°") and out[2] == f" +20 mm: cos θ2 = 1.1840, {told}"


def test_limits_that_leave_no_place_are_told(bench, capsys):
    arm = TwoLinkArm(bench.arm.l1_mm, bench.arm.l2_mm, ((200, 250), (170, 175)))
    names = {
        "np": np,
        "plots": plots,
        "recording": bench,
        "arm": arm,
        "l1": arm.l1_mm,
        "l2": arm.l2_mm,
        "nearest_mm": 50,
    }
    exec(cell("05", "cell-07"), names)
    assert "with shoulder 200 to 250° and elbow 170 to 175°: no place is left" in capsys.readouterr().out

"""A slip in a learner's function is told: by one or two missteps from the solution that do as the function does."""

import math

import numpy as np
import pytest

from conftest import ROOT
from stereo_lab.exercises import LESSONS, questions
from stereo_lab.exercises.answers import NOT_YET, Function, judge
from stereo_lab.exercises.hanging import as_if
from stereo_lab.exercises.slips import do_alike, slip_in
from stereo_lab.recording import open_recording


@pytest.fixture(scope="module")
def functions():
    asked = [q for lesson in LESSONS for q in questions(lesson, open_recording(ROOT / "data" / "bench"))]
    return {q.name: q for q in asked if isinstance(q.answer, Function)}


def typed(question, line):
    """A function of the solution's first line and another formula, as a learner types it."""
    head = next(part for part in question.code.splitlines() if part.startswith("def "))
    scope = {**vars(math), "np": np, "math": math, "radians": math.radians, "d_px": 60.0}  # d_px: of a cell above
    exec(f"{head}\n    {line}", scope)
    return scope[head[4:].partition("(")[0]]


@pytest.mark.parametrize(
    ("name", "line", "says"),
    [
        ("0.5", "return (((a.x_mm - b.x_mm)**2 + (a.y_mm - b.y_mm)**2 - (a.depth_mm - b.depth_mm)**2)) ** 0.5", "a minus stands"),
        ("1.1", "X, Y, Z = point_mm; return focal_px * X * Z + center_px[0], focal_px * Y * Z + center_px[1]", "a * stands before Z where a / belongs"),
        ("1.6", "return z_mm**2 / (focal_px + baseline_mm) * error_px", "a plus stands before baseline_mm where a * belongs"),
        ("2.7", "return np.sqrt((u - a) * 2 + (v - b) * 2)", "a * stands before 2 where a ** belongs, twice"),
        ("3.3", "return (pixels - pixels.mean() * lengths_mm - lengths_mm.mean()).sum() / ((pixels - pixels.mean())**2).sum()",
         "brackets are missing round pixels - pixels.mean()"),
        ("3.3", "return ((pixels - np.median(pixels)) * (lengths_mm - np.median(lengths_mm))).sum() / ((pixels - np.median(pixels))**2).sum()",
         "the median stands where the mean belongs"),
        ("4.5", "return baseline_mm * focal_px / (d_px - 1) - z_mm", "d_px comes from a cell above and is the same whatever comes in"),
        ("4.5", "return baseline_mm * focal_px / (z_mm * focal_px / baseline_mm - 5) - z_mm", "focal_px hardly counts in your result, and belongs below"),
        ("5.2", "t = theta1_deg + theta2_deg; s = radians(theta1_deg); return l1 * cos(s) + l2 * cos(t), l1 * sin(s) + l2 * sin(t)",
         "radians() is left out round theta1_deg + theta2_deg"),
        ("5.3", "return degrees(acos((x**2 + y**2 - l1**2 - l2**2) / (l1 * l2)))", "2 is left out"),
        ("5.3", "return degrees(acos((x**2 + y**2 - l1**2) / (2 * l1 * l2)))", "l2 ** 2 is left out"),
        ("5.3", "return acos(degrees((x**2 + y**2 - l1**2 - l2**2) / (2 * l1 * l2)))", "degrees() and acos() have changed places"),
        ("5.3", "return degrees(acos((x**2 + y**2 - l1**2 - l2**2) / 2 * l1 * l2))", "brackets are missing round 2 * l1 * l2"),
        ("5.2", "e = l1, l2; return e, e[0] + l2, e[1]", "a pair or a list among numbers. Give back the 2 numbers"),
        ("5.3", "from stereo_lab.kinematics import TwoLinkArm; return TwoLinkArm(250, 200, ((0, 90), (0, 90))).inverse(x, y).theta2_deg",
         "write the equation itself"),
        ("5.4", "return degrees(atan2(y, x) - asin(l2 * sin(radians(theta2_deg)) / hypot(x, y)))", "asin gives no angle above 90°"),
        ("6.4", "return fast_v if left_deg > 0 else 0", "the slow part is missing"),
        ("6.4", "return fast_v if left_deg > zone_deg else slow_v if left_deg > 0.1 else 0", "yours brakes too early, with 0.01° still to go"),
        ("6.4", "return fast_v if left_deg > zone_deg else slow_v if left_deg > zone_deg / 2 else 0", "yours brakes too early, with 0.3° still to go"),
        ("7.3", "return place_mm + int(velocity_mm_s * seconds)", "int() cuts off decimals of velocity_mm_s * seconds"),
        ("7.3", "return place_mm + velocity_mm_s ** seconds", "a ** stands before seconds where a * belongs"),
        ("7.5", "return gap_mm < 4 * sigma_mm and gap_mm > -sigma_mm", "get different answers, and should not"),
        ("7.5", "return abs(gap_mm) < 10", "sigma_mm changes nothing in your answer"),
        ("8.2", "return depth_mm * width_px / (focal_px - baseline_mm)", "brackets stand round focal_px - baseline_mm, and none belong there"),
    ],
)  # fmt: skip
def test_a_slip_is_told(functions, name, line, says):
    assert says in judge(functions[name].answer, typed(functions[name], line)).text


def test_what_is_left_out_is_not_called_a_turned_sign():
    right = lambda left_deg, zone_deg: float(left_deg > zone_deg)
    given = [np.ones(1), np.zeros(1)]
    assert (
        as_if(right, ((3.0, 5.0), (-8.0, 5.0)), given, ["left_deg", "zone_deg"], {})
        == "it works as if zone_deg were 0."
    )


def test_nothing_is_told_of_what_is_right(functions):
    for q in functions.values():
        assert slip_in(q.answer.right, q.answer.right, q.answer.inputs, q.answer.solution) == "", q.name


def test_nothing_is_told_of_what_has_nothing_to_do_with_it(functions):
    kind = functions["4.3"].answer
    assert slip_in(lambda b, f, d: b**3 + math.sin(f) + 7.77, kind.right, kind.inputs, kind.solution) == ""


def test_a_function_that_prints_is_tried_in_silence(functions, capsys):
    def loud(baseline_mm, focal_px, d_px):
        print("here")
        return baseline_mm * focal_px * d_px

    kind = functions["4.3"].answer
    assert "d_px" in slip_in(loud, kind.right, kind.inputs, kind.solution)
    assert capsys.readouterr().out == ""


def test_two_functions_that_agree_by_chance_are_told_apart():
    tries = ((2.0,), (2.0,))
    assert do_alike(lambda x: 2 * x, lambda x: x + x, tries) and not do_alike(lambda x: x**2, lambda x: 2 * x, tries)


def test_whatever_a_function_gives_is_looked_at(functions):
    """Functions of which no slip comes: all pairs of missteps are tried, and none of them may stop the check."""
    for name, q in functions.items():
        count = len(q.answer.inputs[0])
        given = ", ".join(f"a{k}" for k in range(count))
        for body in ("0.1234", " + ".join(["5.4321", *(f"1.2345 * a{k}" for k in range(count))])):
            verdict = judge(q.answer, eval(f"lambda {given}: {body}"))
            assert verdict.status == NOT_YET and "could not be looked at" not in verdict.text, name

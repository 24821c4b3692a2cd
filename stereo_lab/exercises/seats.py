"""What differs from seat to seat: the numbers that questions hand out, and the inputs that functions are tried on.

Neighbours work on other recordings (:mod:`stereo_lab.classroom.variants`), so what is measured differs by itself. Here is the rest.
Without a seat everything is as the lessons are written.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from stereo_lab.exercises.answers import Function, judge
from stereo_lab.exercises.draws import with_fresh_inputs
from stereo_lab.exercises.question import Question

DRAWS = 25  # sets of inputs, of which the first is taken that tells all known mistakes by name


@dataclass(frozen=True)
class Numbers:
    """The numbers that stand in the lessons.

    Attributes
    ----------
    pixel_bgr : tuple of int, lesson 02
    elbow_deg : int, where the first command of lesson 06 turns the elbow
    old_ms, speed_mm_s : float, how old a picture is and how fast a ball rolls, lesson 07
    cpu_percent, pairs_a_second : float, what a program takes, lesson 07
    """

    pixel_bgr: tuple[int, int, int] = (30, 40, 200)
    elbow_deg: int = -30
    old_ms: float = 80.0
    speed_mm_s: float = 250.0
    cpu_percent: float = 23.37
    pairs_a_second: float = 10.0


AS_WRITTEN = Numbers()


def numbers(seat: int | None) -> Numbers:
    """The numbers of a seat; those next to each other have other ones."""
    if seat is None:
        return AS_WRITTEN
    return Numbers(
        pixel_bgr=(20 + 3 * (7 * seat % 11), 62 + 4 * (5 * seat % 13), 150 + 4 * (17 * seat % 23)),
        elbow_deg=-(35 + 5 * (7 * seat % 9)),
        old_ms=50.0 + 5 * (2 * seat % 5),
        speed_mm_s=260.0 + 10 * (7 * seat % 17),
        cpu_percent=round(14.3 + 0.7 * (11 * seat % 37), 1),
        pairs_a_second=(12.0, 15.0, 20.0, 25.0)[seat % 4],
    )


def reworded(source: str, seat: int | None) -> str:
    """A cell of a lesson with the numbers of a seat in it."""
    if seat is None:
        return source
    its = numbers(seat)
    program = f"Another program takes {its.cpu_percent:g} % of a CPU at {its.pairs_a_second:g} pairs a second. Turn this into something that you can picture:"
    for written, told in (
        ("pixel = (30, 40, 200)", f"pixel = {its.pixel_bgr}"),
        ("turns the elbow to −30°", f"turns the elbow to −{-its.elbow_deg}°"),
        ("a picture is 80 ms old", f"a picture is {its.old_ms:g} ms old"),
        ("the ball rolls at 250 mm/s", f"the ball rolls at {its.speed_mm_s:g} mm/s"),
        ("Turn its percentage into something that you can picture:", program),
        ("# of the paper's CPU, in ms", "# of that program, in ms"),
    ):
        source = source.replace(written, told)
    return source


def seated(question: Question, seat: int) -> Question:
    """The question with a seat's own inputs, where it is a function's and the mistakes can be told with them as well."""
    if not isinstance(question.answer, Function):
        return question
    for k in range(DRAWS):
        answer = with_fresh_inputs(question.name, question.answer, seat * DRAWS + k)
        whole = len(answer.inputs) == len(question.answer.inputs)
        if whole and all(judge(answer, wrong.answer).text == wrong.message for wrong in answer.wrong):
            return replace(question, answer=answer)
    return question

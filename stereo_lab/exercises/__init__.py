"""Questions of the lessons: check an answer, take a hint, see the solution, go on.

from stereo_lab.exercises import questions, ____
q1, q2, q3, q4, q5 = questions("04", recording)
disparity = ____
q1.check(disparity)
disparity = q1.carry(disparity)
depth_mm = mine("04.3", recording)    # in a later lesson
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from stereo_lab.errors import StereoLabError
from stereo_lab.exercises.blank import ____
from stereo_lab.exercises.sitting import catch_up
from stereo_lab.exercises.stops import explain_stops
from stereo_lab.recording import open_recording
from stereo_lab.recording.model import must_be_recording
from stereo_lab.recording.needs import BALL, BOARDS, lacks

if TYPE_CHECKING:  # a lesson is loaded when its questions are asked for
    from stereo_lab.exercises.question import Question
    from stereo_lab.recording import Recording

PLACES = ("calibration", "position", "depth")  # what most lessons need of a recording
NEEDS = {"01": (BOARDS,), "02": (BALL,), "08": (BOARDS, "position", "depth"), "09": (BALL, "position", "depth")}
LESSONS = ("00", "01", "02", "03", "04", "05", "06", "07", "08", "09")

__all__ = ["LESSONS", "____", "asked_in", "catch_up", "mine", "questions"]


def questions(lesson: str, recording: Recording, **seen: Any) -> tuple[Question, ...]:
    """The questions of one lesson, their answers computed from the recording in use.

    Parameters
    ----------
    lesson : str, "00" to "09"
    recording : Recording
    seen : what a lesson is to ask about in the place of the recording's own; lesson 00 takes ``balls``

    Returns
    -------
    tuple of Question

    Raises
    ------
    StereoLabError
        For a lesson that is not there.
    """
    name = str(lesson).zfill(2)
    if name not in LESSONS:
        raise StereoLabError(f"There are no questions for lesson {lesson!r}. Lessons: {', '.join(LESSONS)}.")
    must_be_recording(recording)
    explain_stops()
    asked = import_module(f"stereo_lab.exercises.lesson{name}").questions(recording, **seen)
    if recording.seat is None:
        return tuple(asked)
    from stereo_lab.exercises.seats import seated

    return tuple(seated(question, recording.seat) for question in asked)


def asked_in(lesson: str, recording: Recording) -> tuple[Question, ...]:
    """The questions as a lesson asks them: where the recording has not what it needs, those of the shipped bench."""
    lacking = lacks(recording, *NEEDS.get(lesson, PLACES))
    return questions(lesson, open_recording("bench") if lacking else recording)


def mine(name: str, recording: Recording) -> Any:
    """What you wrote to a question of an earlier lesson. Where that is not there, the kit's own stands in. Says which.

    Parameters
    ----------
    name : str, lesson and number, such as "05.3"
    recording : Recording, on which it must pass

    Raises
    ------
    StereoLabError
        If there is no such question.
    """
    from stereo_lab.exercises.kept import recall
    from stereo_lab.exercises.language import translated

    lesson, _, number = str(name).partition(".")
    asked = {str(q.number): q for q in questions(lesson, recording)}
    if number not in asked:
        raise StereoLabError(f"There is no question {name!r}. Lesson {lesson} has {', '.join(asked)}, as {lesson}.1.")
    question = asked[number]
    answer, why = recall(question.name, question.answer)
    print(
        translated(f"question {question.name}: " + (f"the kit's own answer, for {why}" if why else "your own answer"))
    )
    return question.carry(answer) if not why else question.reference

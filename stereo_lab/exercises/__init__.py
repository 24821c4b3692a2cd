"""Questions of the lessons: check an answer, take a hint, see the solution, go on.

from stereo_lab.exercises import questions, ____
q1, q2, q3, q4, q5 = questions("04", recording)
disparity = ____
q1.check(disparity)
disparity = q1.carry(disparity)
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

from stereo_lab.errors import StereoLabError
from stereo_lab.exercises.blank import ____

if TYPE_CHECKING:  # a lesson is loaded when its questions are asked for
    from stereo_lab.exercises.question import Question
    from stereo_lab.recording import Recording

LESSONS = ("00", "01", "02", "03", "04", "05", "06", "07")

__all__ = ["LESSONS", "____", "questions"]


def questions(lesson: str, recording: Recording) -> tuple[Question, ...]:
    """The questions of one lesson, their answers computed from the recording in use.

    Parameters
    ----------
    lesson : str, "00" to "07"
    recording : Recording

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
    return tuple(import_module(f"stereo_lab.exercises.lesson{name}").questions(recording))

"""What stands in the place of ``stereo_lab.exercises`` while a notebook is marked: the same questions, and no answers.

In the room this file is ``stereo_lab/exercises/__init__.py``. An answer that is checked or carried goes to the examiner, who judges
it elsewhere. Nothing in this process knows what is right.
"""

from __future__ import annotations

from typing import Any

from stereo_lab.classroom import desk
from stereo_lab.exercises.blank import ____

LESSONS = ("00", "01", "02", "03", "04", "05", "06", "07", "08", "09")

__all__ = ["LESSONS", "____", "catch_up", "mine", "questions"]


class Question:
    """A question that hands its answers on. Nothing on it can be replaced.

    Attributes
    ----------
    lesson, number : str and int
    """

    __slots__ = ("lesson", "number")
    lesson: str
    number: int

    def __init__(self, lesson: str, number: int) -> None:
        object.__setattr__(self, "lesson", lesson)
        object.__setattr__(self, "number", number)

    def __setattr__(self, name: str, value: Any) -> None:
        raise AttributeError(f"{name} of a question stays as it is")

    @property
    def name(self) -> str:
        """Lesson and number as learners read them, such as "4.2"."""
        return f"{int(self.lesson)}.{self.number}"

    def check(self, answer: Any) -> None:
        """Hand the answer to the examiner."""
        desk.check(self.lesson, self.number, answer)

    def require(self, answer: Any) -> None:
        """Nothing: the examiner has the answer from ``check``, which stands above it in an assignment of nbgrader."""

    def carry(self, answer: Any) -> Any:
        """The answer where the examiner finds it right, else what the examiner gives to go on with."""
        return desk.carry(self.lesson, self.number, answer)

    def hint(self) -> None:
        """Tell the examiner that a hint was taken here."""
        desk.help_taken(self.lesson, self.number, "hint")

    def solution(self) -> None:
        """Tell the examiner that the solution was looked at here."""
        desk.help_taken(self.lesson, self.number, "solution")


def questions(lesson: str, recording: Any = None, **seen: Any) -> tuple[Question, ...]:
    """The questions of a lesson, as many as it has."""
    name = str(lesson).zfill(2)
    return tuple(Question(name, k + 1) for k in range(desk.count(name)))


def mine(name: str, recording: Any = None) -> Any:
    """The kit's own answer to a question of an earlier lesson: what the learner kept does not come along."""
    lesson, _, number = str(name).partition(".")
    return desk.carry(lesson.zfill(2), int(number), ____)


def catch_up(lesson: str, sitting: int) -> None:
    """Nothing: all cells above have just been run."""

"""What a class has reached: a mark for each question, a row for each learner and lesson, and how many fell for what."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

from stereo_lab.exercises.answers import NOT_ATTEMPTED, NOT_YET, PASS

IN_WORDS = {PASS: "passed", NOT_YET: "not yet", NOT_ATTEMPTED: "not attempted"}
OF_A_TEACHER = {
    **dict.fromkeys(("passed", "pass", "yes", "ok", "1", "x"), PASS),
    **dict.fromkeys(("not yet", "no", "0", "fail", "failed"), NOT_YET),
    **dict.fromkeys(("not attempted", "-"), NOT_ATTEMPTED),
}  # what a teacher may write into a table


@dataclass(frozen=True)
class Mark:
    """One question of one learner.

    Attributes
    ----------
    status : PASS, NOT_YET or NOT_ATTEMPTED
    why : str, the misconception, or what stopped it
    help : str, hints and solutions that were used
    teacher : str, what the teacher wrote over it; "" where nothing
    """

    status: str
    why: str = ""
    help: str = ""
    teacher: str = ""

    @property
    def counts(self) -> str:
        """The status that counts: the teacher's where there is one."""
        return OF_A_TEACHER.get(self.teacher.strip().lower(), self.status)


@dataclass(frozen=True)
class Row:
    """One learner and one lesson.

    Attributes
    ----------
    learner, lesson, file, handed_in : str
    marks : tuple of Mark, in the order of the questions
    notes : tuple of str, what a teacher should know of it
    written : tuple of str, what the learner wrote between the cells; it is not marked
    """

    learner: str
    lesson: str
    file: str
    handed_in: str
    marks: tuple[Mark, ...]
    notes: tuple[str, ...] = ()
    written: tuple[str, ...] = ()

    @property
    def passed(self) -> int:
        """How many questions are passed, the teacher's marks counted."""
        return sum(mark.counts == PASS for mark in self.marks)

    def marked_by(self, teacher: dict[int, str]) -> Row:
        """The row with a teacher's marks, by the question's number."""
        return replace(
            self, marks=tuple(replace(m, teacher=teacher.get(k, m.teacher)) for k, m in enumerate(self.marks, 1))
        )

    def as_json(self) -> dict[str, Any]:
        """The row as JSON can write it."""
        return asdict(self)

    @classmethod
    def from_json(cls, told: dict[str, Any]) -> Row:
        """A row that :meth:`as_json` gave."""
        marks = tuple(Mark(**mark) for mark in told["marks"])
        return cls(**{**told, "marks": marks, "notes": tuple(told["notes"]), "written": tuple(told["written"])})


@dataclass(frozen=True)
class Tally:
    """How a class stands to one question.

    Attributes
    ----------
    name : str, such as "4.2"
    asks : str
    passed, not_yet, not_attempted : int
    fell_for : tuple of (str, int), what was said to wrong answers, the most frequent first
    """

    name: str
    asks: str
    passed: int
    not_yet: int
    not_attempted: int
    fell_for: tuple[tuple[str, int], ...]

    @property
    def learners(self) -> int:
        """How many handed the lesson in."""
        return self.passed + self.not_yet + self.not_attempted


def tally(rows: Iterable[Row], lesson: str, asked: Sequence[Any]) -> list[Tally]:
    """Count a lesson's questions over a class; ``asked`` are the questions."""
    mine = [row for row in rows if row.lesson == lesson and row.marks]
    tallies = []
    for k, question in enumerate(asked):
        marks = [row.marks[k] for row in mine]
        states = Counter(mark.counts for mark in marks)
        fell = Counter(kind_of_mistake(mark.why) for mark in marks if mark.counts == NOT_YET and mark.why)
        tallies.append(
            Tally(
                question.name,
                question.asks,
                states[PASS],
                states[NOT_YET],
                states[NOT_ATTEMPTED],
                tuple(fell.most_common()),
            )
        )
    return tallies


def kind_of_mistake(why: str) -> str:
    """A sentence without the learner's own numbers: the same mistake is then the same sentence."""
    return re.sub(r"-?\d[\d.,]*\d|(?<![\w.])-?\d(?![\w])", "…", why) if re.match(r"-?\d", why) else why

"""One question: its answer, its hints, its solution."""

from __future__ import annotations

import textwrap
from dataclasses import dataclass, field
from typing import Any

from stereo_lab.exercises import kept, progress
from stereo_lab.exercises.answers import PASS, Choice, Command, Function, Number, judge


@dataclass(frozen=True, eq=False)
class Question:
    """One question of a lesson.

    Attributes
    ----------
    lesson, number : str and int; together its name, "04" and 2
    asks : str, one sentence
    answer : Number, Choice, Function or Command
    hints : tuple of str, from where to look, to what to use, to the line with a hole in it
    code : str, the lines of the solution, as they stand in the notebook instead of the stub
    reason : str, why
    reference : what :meth:`carry` gives to whoever is stuck
    questions : int, how many the lesson has
    """

    lesson: str
    number: int
    asks: str
    answer: Number | Choice | Function | Command
    hints: tuple[str, ...]
    code: str
    reason: str
    reference: Any
    questions: int = 0
    _shown: list = field(default_factory=list, repr=False)

    @property
    def name(self) -> str:
        """Lesson and number as learners read them, such as "4.2"."""
        return f"{int(self.lesson)}.{self.number}"

    def check(self, answer: Any) -> None:
        """Print NOT ATTEMPTED, NOT YET with the reason, or PASS. Never raises, unless you stop it (Ctrl-C)."""
        verdict = judge(self.answer, answer)
        if verdict.status != PASS:
            print(verdict)
            return
        kept.keep(self.name, self._carried(answer))
        done = progress.passed(self.lesson, self.number)
        print(f"{verdict} (lesson {int(self.lesson)}: {done} of {self.questions})")

    def hint(self) -> None:
        """Print the next hint; after the last one, the last again."""
        k = min(len(self._shown), len(self.hints) - 1)
        self._shown.append(k)
        print(f"Hint {k + 1} of {len(self.hints)}: {self.hints[k]}")

    def solution(self) -> None:
        """Print the solution and the reason for it. It is shown, not run."""
        print(textwrap.indent(self.code, "    ") + f"\n{self.reason}")

    def carry(self, answer: Any) -> Any:
        """The answer where it is right, else the reference: whoever is stuck can go on."""
        return self._carried(answer) if judge(self.answer, answer).status == PASS else self.reference

    def _carried(self, answer):
        return self.answer.carried(answer) if isinstance(self.answer, Number) else answer


def lesson(name: str, *asked: dict[str, Any]) -> tuple[Question, ...]:
    """Number the questions of a lesson; each one is a dictionary of Question's fields."""
    return tuple(Question(lesson=name, number=k + 1, questions=len(asked), **fields) for k, fields in enumerate(asked))

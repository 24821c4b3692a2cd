"""One question: its answer, its hints, its solution."""

from __future__ import annotations

import textwrap
from dataclasses import dataclass, field

from stereo_lab.exercises import progress
from stereo_lab.exercises.answers import PASS, judge


@dataclass(frozen=True, eq=False)
class Question:
    """One question of a lesson.

    Attributes
    ----------
    lesson, number : str and int; together its name, "04" and 2
    asks : str, one sentence
    answer : Number, Choice or Function
    hints : tuple of str, from where to look, to what to use, to the line with a hole in it
    code : str, the lines of the solution, as they stand in the notebook instead of the stub
    reason : str, why
    reference : what :meth:`carry` gives to whoever is stuck
    questions : int, how many the lesson has
    """

    lesson: str
    number: int
    asks: str
    answer: object
    hints: tuple
    code: str
    reason: str
    reference: object
    questions: int = 0
    _shown: list = field(default_factory=list, repr=False)

    @property
    def name(self):
        return f"{int(self.lesson)}.{self.number}"

    def check(self, answer):
        """Print NOT ATTEMPTED, NOT YET with the reason, or PASS. Never raises, unless you stop it (Ctrl-C)."""
        verdict = judge(self.answer, answer)
        if verdict.status != PASS:
            print(verdict)
            return
        done = progress.passed(self.lesson, self.number)
        print(f"{verdict} (lesson {int(self.lesson)}: {done} of {self.questions})")

    def hint(self):
        """Print the next hint; after the last one, the last again."""
        k = min(len(self._shown), len(self.hints) - 1)
        self._shown.append(k)
        print(f"Hint {k + 1} of {len(self.hints)}: {self.hints[k]}")

    def solution(self):
        """Print the solution and the reason for it. It is shown, not run."""
        print(textwrap.indent(self.code, "    ") + f"\n{self.reason}")

    def carry(self, answer):
        """The answer where it is right, else the reference: whoever is stuck can go on."""
        return answer if judge(self.answer, answer).status == PASS else self.reference


def lesson(name, *asked):
    """Number the questions of a lesson; each one is a dictionary of Question's fields."""
    return tuple(Question(lesson=name, number=k + 1, questions=len(asked), **fields) for k, fields in enumerate(asked))

"""One question: its answer, its hints, its solution."""

from __future__ import annotations

import textwrap
from dataclasses import dataclass, field, replace
from typing import Any

from stereo_lab.exercises import kept, progress
from stereo_lab.exercises.answers import PASS, Choice, Command, Function, Number, Verdict, judge
from stereo_lab.exercises.language import in_english, translated
from stereo_lab.exercises.verdict import NOT_YET


class NotPassed(AssertionError):
    """An answer that gives no point. A notebook shows its message alone, for what to do was printed before."""

    def _render_traceback_(self) -> list[str]:
        return [f"no point: {self}"]


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

    def judge(self, answer: Any) -> Verdict:
        """The verdict on an answer, in English. Words count in the language of the class as well."""
        return judge(self.answer, in_english(answer) if isinstance(self.answer, Choice) else answer)

    def check(self, answer: Any) -> None:
        """Print NOT ATTEMPTED, NOT YET with the reason, or PASS. Never raises, unless you stop it (Ctrl-C)."""
        verdict = self.judge(answer)
        if verdict.status != PASS:
            print(_in_words(verdict))
            return
        kept.keep(self.name, answer if callable(answer) else self._carried(answer))  # a function as its own lines
        done = progress.passed(self.lesson, self.number)
        print(_in_words(verdict), translated(f"(lesson {int(self.lesson)}: {done} of {self.questions})"))

    def require(self, answer: Any) -> None:
        """Say nothing of an answer that passes, and raise at any other: for programs that count what raises, such as nbgrader.

        Raises
        ------
        NotPassed
            If it is missing or not right yet.
        """
        if (verdict := self.judge(answer)).status != PASS:
            raise NotPassed(verdict.status)

    def hint(self) -> None:
        """Print the next hint; after the last one, the last again."""
        k = min(len(self._shown), len(self.hints) - 1)
        self._shown.append(k)
        progress.helped(self.lesson, self.number, "hint", k + 1)
        print(translated(f"Hint {k + 1} of {len(self.hints)}:"), translated(self.hints[k]))

    def solution(self) -> None:
        """Print the solution and the reason for it. It is shown, not run."""
        progress.helped(self.lesson, self.number, "solution", 1)
        print(textwrap.indent(self.code, "    ") + f"\n{translated(self.reason)}")

    def carry(self, answer: Any) -> Any:
        """The answer where it is right, else the reference: whoever is stuck can go on. Of a wrong one it says so."""
        status = self.judge(answer).status
        if status == NOT_YET:
            print(translated("(The cells below go on with the kit's answer until yours is right.)"))
        return self._carried(answer) if status == PASS else self.reference

    def _carried(self, answer):
        if isinstance(self.answer, Choice):  # later cells know the English words
            return in_english(answer)
        return self.answer.carried(answer) if isinstance(self.answer, (Number, Function, Command)) else answer


def _in_words(verdict):
    """A verdict in the language of the class."""
    return str(Verdict(translated(verdict.status), translated(verdict.text)))


def lesson(name: str, *asked: dict[str, Any]) -> tuple[Question, ...]:
    """Number the questions of a lesson; each one is a dictionary of Question's fields."""
    return tuple(
        Question(lesson=name, number=k + 1, questions=len(asked), **_with_solution(fields))
        for k, fields in enumerate(asked)
    )


def _with_solution(fields):
    """A function is judged by the lines of its solution as well."""
    if not isinstance(fields["answer"], Function):
        return fields
    return {**fields, "answer": replace(fields["answer"], solution=fields["code"])}

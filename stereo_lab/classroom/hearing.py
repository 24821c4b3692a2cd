"""One run of a notebook, heard from outside: what it answers, the verdict on that, and what it gets to go on with."""

from __future__ import annotations

import builtins
import hashlib
import json
from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass, field
from typing import Any

from stereo_lab.classroom.line import EndedError, Line
from stereo_lab.classroom.wire import legible, pack, unpack
from stereo_lab.exercises import LESSONS, ____
from stereo_lab.exercises.answers import NOT_ATTEMPTED, NOT_YET, PASS, Function, Number, Verdict, judge
from stereo_lab.exercises.draws import with_fresh_inputs
from stereo_lab.exercises.question import Question

LONGEST_REASON = 300  # letters of what a cell or a function stopped with
A_CALL = 2.0  # seconds for one call of a learner's function


@dataclass(frozen=True)
class Answer:
    """What was answered to one question.

    Attributes
    ----------
    verdict : Verdict on the answer that counts, the last one that is none of the blanks
    given : int, how many different answers there were before and with it
    after_carry : bool, whether the kit's own answer had been handed out before
    """

    verdict: Verdict
    given: int = 1
    after_carry: bool = False


@dataclass
class Heard:
    """What one run of a notebook has told.

    Attributes
    ----------
    answers : dict, by the question's number
    stopped : dict, what a cell stopped with, by its place
    help : dict, how many hints and solutions were taken, by (question, "hint" or "solution")
    ended : str, why the run came to its end before its time; "" where it did not
    ended_in : int or None, the cell in which it did
    seconds : list of float, what each cell took
    """

    answers: dict[int, Answer] = field(default_factory=dict)
    stopped: dict[int, str] = field(default_factory=dict)
    help: dict[tuple[int, str], int] = field(default_factory=dict)
    ended: str = ""
    ended_in: int | None = None
    seconds: list[float] = field(default_factory=list)


class Run:
    """One run: what is said in it, and what is said to that.

    ``withheld``: numbers of questions whose answer the kit keeps back; ``carried``: of those that it has handed out, in this run or one before.
    """

    def __init__(
        self,
        line: Line,
        lesson: str,
        questions_of: Callable[[str], tuple[Question, ...]],
        cells: int,
        withheld: Collection[int],
        carried: set[int],
        seed: int,
    ) -> None:
        self.line, self.lesson, self.questions_of = line, lesson, questions_of
        self.cells, self.withheld, self.carried, self.seed = cells, withheld, carried, seed
        self.heard = Heard()
        self._given: dict[int, list[str]] = {}
        self._verdicts: dict[tuple[str, str], Verdict] = {}

    def listen(self) -> None:
        """Hear a notebook to its end.

        Raises
        ------
        EndedError
            If it comes to its end before its time.
        """
        try:
            while (message := self.line.hear()).get("say") != "done":
                self._answer(message)
        finally:
            self.line.close()

    def _answer(self, message):
        """Do what a message asks for. Whatever a forged one runs into here costs this run alone."""
        try:
            getattr(self, f"_on_{message['say']}")(message)
        except EndedError:
            raise
        except Exception:
            self.line.end("it writes into the grader's line")

    def _on_begins(self, message):
        self._verdicts.clear()  # a function may be another one after a cell: what it calls, and the numbers that it uses
        self.line.begin(self._place(message))

    def _on_ends(self, message):
        self.heard.seconds.append(self.line.seconds())
        self.heard.stopped.pop(self._place(message), None)
        if message["stopped"]:
            self.heard.stopped[self._place(message)] = legible(str(message["stopped"]), LONGEST_REASON)

    def _place(self, message):
        """Of which cell a message tells."""
        place = int(message["cell"])
        if not 0 <= place < self.cells:
            raise ValueError("no such cell")
        return place

    def _on_count(self, message):
        self.line.send(count=len(self._asked(message)))

    def _on_help(self, message):
        if message["lesson"] == self.lesson and message["what"] in ("hint", "solution"):
            key = self._question(message).number, message["what"]
            self.heard.help[key] = self.heard.help.get(key, 0) + 1

    def _on_check(self, message):
        question = self._question(message)
        if question.lesson == self.lesson:
            verdict = self._judged(question, message["answer"])
            if verdict.status != NOT_ATTEMPTED or question.number not in self.heard.answers:
                given = self._given.setdefault(question.number, [])
                shown = _digest(message["answer"])
                function = isinstance(message["answer"], dict) and "function" in message["answer"]
                if verdict.status != NOT_ATTEMPTED and (function or shown not in given):
                    given.append(shown)
                late = question.number in self.carried
                self.heard.answers[question.number] = Answer(verdict, max(len(given), 1), late)
        self.line.send(go=True)

    def _on_carry(self, message):
        question = self._question(message)
        own = question.lesson == self.lesson
        if own and question.number in self.withheld:  # also what is right: else it would tell which of many is
            self.carried.add(question.number)
            return self.line.send(value={"blank": True})
        if not self._is_blank(message["answer"]) and self._judged(question, message["answer"]).status == PASS:
            return self._give_back(question, message["answer"])
        if own:
            self.carried.add(question.number)
        if callable(question.reference):
            self.line.send(**({"code": question.code} if own else {"function": True}))
        else:
            self.line.send(value=pack(question.reference))

    def _give_back(self, question, told):
        """What is right stays the learner's; a text that tells a number goes on as the number, lists of a function as arrays."""
        if isinstance(question.answer, Number):
            self.line.send(value=pack(question.answer.carried(unpack(told))))
        elif isinstance(question.answer, Function):
            asked = unpack(told, lambda number, blank: _Asked(self, number, blank))
            self.line.send(own=True, lists=question.answer.gives_lists(asked))
        else:
            self.line.send(own=True)

    def _on_use(self, message):
        """Call the kit's own function for a cell below; withheld, it gives a blank."""
        question = self._question(message)
        if question.lesson == self.lesson:
            self.carried.add(question.number)
            if question.number in self.withheld:
                return self.line.send(value={"blank": True})
        try:
            value = question.reference(*(unpack(a) for a in message["arguments"]))
        except Exception as error:
            return self.line.send(error=f"{type(error).__name__}: {error}"[:300])
        return self.line.send(value=pack(value))

    def _question(self, message):
        asked = self._asked(message)
        number = int(message["question"])
        if not 1 <= number <= len(asked):
            raise ValueError("no such question")
        return asked[number - 1]

    def _asked(self, message):
        """The questions of the lesson that a message names, by the one name that it has."""
        if message["lesson"] not in LESSONS:
            raise ValueError("no such lesson")
        return self.questions_of(message["lesson"])

    @staticmethod
    def _is_blank(told):
        return isinstance(told, dict) and "blank" in told and told["blank"] is True and "function" not in told

    def _judged(self, question: Question, told: Any) -> Verdict:
        """The verdict on what came through the pipe; what is checked and then carried in one cell is judged once."""
        key = question.name, _digest(told)
        if key not in self._verdicts:
            self._verdicts[key] = self._judged_anew(question, told)
        return self._verdicts[key]

    def _judged_anew(self, question, told):
        """A function is tried on the lesson's inputs, then on others."""
        answer = unpack(told, lambda number, blank: _Asked(self, number, blank))
        verdict = self._said(question.judge(answer))
        if verdict.status == PASS and isinstance(question.answer, Function):
            fresh = with_fresh_inputs(question.name, question.answer, self.seed)
            other = self._said(judge(fresh, answer))
            if other.status != PASS:
                return Verdict(NOT_YET, f"right for the tries of the lesson alone. For others: {other.text}")
        return verdict

    def _said(self, verdict):
        """A verdict in letters that can be written down; none where the notebook has ended under it."""
        if self.line.over:
            raise self.line.over
        return Verdict(verdict.status, legible(verdict.text))

    def call(self, number: int, arguments: tuple) -> Any:
        """What a function of the learner's gives; raises what it raised."""
        self.line.send(call=number, arguments=[pack(a) for a in arguments], seconds=A_CALL)
        while True:
            message = self.line.hear()
            if "returned" in message:
                return unpack(message["returned"], lambda number, blank: _Asked(self, number, blank))
            if "raised" in message:
                raise _raised(message)
            self._answer(message)


def _digest(told):
    """What tells one answer from another; thousands of large ones are not kept themselves."""
    return hashlib.sha256(json.dumps(told).encode()).hexdigest()


def _untouched() -> Any:
    return ____


class _Asked:
    """Stands for a function of the learner's, which runs in the room."""

    def __init__(self, run: Run, number: int, blank: bool) -> None:
        self._run, self._number = run, number
        if blank:
            self.__code__ = _untouched.__code__  # its lines are in the room; that it is a blank is told

    def __call__(self, *arguments: Any) -> Any:
        return self._run.call(self._number, arguments)


def _raised(message: dict[str, Any]) -> Exception:
    """An error of a learner's function, of the same kind and with the same text."""
    text = legible(str(message.get("text", "")), LONGEST_REASON)
    kinds = [str(kind) for kind in list(message.get("kinds", ()))[:10]]
    known: Iterator[Any] = (getattr(builtins, kind, None) for kind in kinds)
    base = next((k for k in known if isinstance(k, type) and issubclass(k, Exception)), Exception)
    fields: dict[str, Any] = {"__str__": lambda self: text, "name": str(message.get("name", ""))[:80]}
    if not message.get("inside"):
        fields["__traceback__"] = None  # the call itself failed, and no line of the function
    name = legible(str(message["raised"]), 80) or "Exception"
    try:
        return _new(name, base, fields)
    except TypeError:  # some kinds, such as ExceptionGroup, are not made out of nothing
        return _new(name, Exception, fields)


def _new(name, base, fields):
    kind: Any = type(name, (base,), fields)
    return kind.__new__(kind)

"""An answer that is a function, tried on several inputs."""

from __future__ import annotations

import inspect
import reprlib
import traceback
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from stereo_lab.common.vectors import as_arrays
from stereo_lab.exercises.blank import is_blank
from stereo_lab.exercises.mistakes import ROOT_BELOW_ZERO, of_a_function, of_bytes
from stereo_lab.exercises.reading import as_numbers
from stereo_lab.exercises.slips import do_alike, slip_in
from stereo_lab.exercises.trying import NEAR, called
from stereo_lab.exercises.verdict import NOT_ATTEMPTED, NOT_YET, PASS, Verdict, Wrong
from stereo_lab.exercises.wording import a_kind, in_plain_words, say

SESSION = ("_sitebuiltins", "IPython.core.autocall")  # where exit, quit and help come from: calling one ends the lesson


@dataclass(frozen=True, eq=False)
class Function:
    """A function that is tried on several inputs.

    Attributes
    ----------
    right : function
    inputs : tuple of tuples, the arguments of each try
    tolerance : float, in ``unit``
    relative : float, room beside it, as a part of the right value
    wrong : tuple of Wrong, their answers functions
    praise : as in :class:`Number`
    also : tuple of functions that are right as well
    domain : str, what to say where the function stops with a ValueError, as acos does outside −1…1
    parts : dict, what the numbers in an argument are called, by the argument's name
    held : tuple of str, arguments that make no sense twice as large, such as a probability
    endless : str, what to say where a result has no bounds
    borders : tuple of (arguments, results), inputs on the border of two cases, where either result will do
    of_all : function of all that was given, which says what is wrong with it where no known mistake gives the same, or ""
    solution : str, the lines of the solution, from which slips are told; without them those of ``right`` serve
    """

    right: Callable
    inputs: tuple[tuple, ...]
    tolerance: float
    unit: str = ""
    wrong: tuple[Wrong, ...] = ()
    praise: str = ""
    also: tuple[Any, ...] = ()
    domain: str = ""
    relative: float = 0.0
    parts: dict[str, tuple[str, ...]] = field(default_factory=dict)
    held: tuple[str, ...] = ()
    endless: str = ""
    borders: tuple[tuple[tuple, tuple], ...] = ()
    of_all: Callable[[list[Any]], str] | None = None
    solution: str = ""

    def judge(self, answer: Any) -> Verdict:
        """PASS where the function is right for every input; else the first that is not, or why it stopped."""
        if not callable(answer):
            return Verdict(NOT_YET, f"expected a function, this is {a_kind(answer)}. Give its name without brackets.")
        if type(answer).__module__ in SESSION:
            return Verdict(NOT_YET, "this belongs to Python itself and would end the lesson. Give a function of yours.")
        outputs: list[Any] = []
        for arguments in self.inputs:
            try:
                output = called(answer, arguments)
            except KeyboardInterrupt:
                raise  # the learner stops a function that does not end
            except BaseException as error:  # SystemExit as well: it would end the notebook
                return (
                    Verdict(NOT_ATTEMPTED) if _has_a_blank(answer) else Verdict(NOT_YET, self._stopped(answer, error))
                )
            if is_blank(output):
                return Verdict(NOT_ATTEMPTED)
            if _is_uneven(output):
                return Verdict(
                    NOT_YET, f"your function gives back a pair or a list among numbers. Give back {self._asked()}."
                )
            if output is None:
                return Verdict(NOT_YET, self._nothing(answer, arguments))
            if isinstance(output, str) or (
                isinstance(output, (list, tuple)) and any(isinstance(o, str) for o in output)
            ):
                return Verdict(
                    NOT_YET, f"your function gives back a text, {reprlib.repr(output)}. Give back {self._asked()}."
                )
            if isinstance(output, (set, dict)):
                brackets = (
                    "a set, which has no order" if isinstance(output, set) else "a dictionary, whose things have names"
                )
                return Verdict(
                    NOT_YET, f"curly brackets make {brackets}. Round ones, or none: a comma parts two numbers."
                )
            if isinstance(output, Iterator):
                return Verdict(
                    NOT_YET, f"{a_kind(output)} gives its numbers only when it is asked. Make a tuple of it: tuple(…)."
                )
            if isinstance(output, complex) and np.size(self.right(*arguments)) > 1:
                return Verdict(
                    NOT_YET, f"a complex number is one thing. Give back {self._asked()}, with a comma between them."
                )
            if isinstance(output, complex):
                slip = slip_in(answer, self.right, self.inputs, self.solution)
                return Verdict(NOT_YET, slip or ROOT_BELOW_ZERO)
            if callable(output) or isinstance(output, (list, tuple)) and any(callable(o) for o in output):
                return Verdict(
                    NOT_YET, "your function gives back another function. Was one named and not called? Put () after it."
                )
            if np.ndim(self.right(*arguments)) == 0 and np.size(output) == 1 and np.ndim(output) > 0:
                return Verdict(
                    NOT_YET, f"your function gives back a list with one thing in it. Give back {self._asked()}."
                )
            outputs.append(output)
        return self._compare(answer, outputs)

    def gives_lists(self, answer: Any) -> bool:
        """Whether a function gives a list where an array is meant, with which the cells below cannot count."""
        given = [(_try(answer, arguments), self.right(*arguments)) for arguments in self.inputs]
        return any(isinstance(g, (list, tuple)) and isinstance(r, np.ndarray) for g, r in given)

    def carried(self, answer: Any) -> Any:
        """A right function as the cells below can count with it: what it gives as a list comes as an array."""
        return as_arrays(answer) if self.gives_lists(answer) else answer

    def _nothing(self, answer, arguments):
        """What to say of a function that gives nothing back: for these arguments alone, or for all."""
        if any(_try(answer, tried) is not None for tried in self.inputs):
            return f"for {self._given(arguments)} your function gives nothing back. Is a case missing?"
        return "your function gives nothing back. Did you forget a return?"

    def _stopped(self, answer, error):
        if isinstance(error, ValueError) and self.domain:
            outputs = [_try(answer, arguments) for arguments in self.inputs]
            known = (mistake.message for mistake in self.wrong if self._does_as(mistake.answer, outputs, NEAR))
            told = next(known, "") if any(output is not None for output in outputs) else ""
            return told or slip_in(answer, self.right, self.inputs, self.solution) or self.domain
        # An error of the call itself has no line of the function behind those of judge and called
        inside = len(list(traceback.walk_tb(error.__traceback__))) > 2
        if isinstance(error, TypeError) and "positional argument" in str(error) and not inside:
            return f"your function must take {len(self.inputs[0])}: {', '.join(self.names)}, in this order. Leave the def line as it was."
        return in_plain_words(error, any(isinstance(given, np.ndarray) for given in self.inputs[0]))

    @property
    def names(self) -> list[str]:
        """Of the arguments."""
        return list(inspect.signature(self.right).parameters)

    def _asked(self):
        """What the function is to give back, in words."""
        given = self.right(*self.inputs[0])
        right = np.asarray(given)
        if right.dtype == bool:
            return "True or False" if right.ndim == 0 else "True or False for each"
        if isinstance(given, np.ndarray):  # as many as come in: how many the tries have, says nothing to a learner
            return "the numbers themselves, one for each"
        return "the number itself" if right.size == 1 else f"the {right.size} numbers themselves"

    def _compare(self, answer, outputs):
        fits = [self._same(o, self.right(*a)) for o, a in zip(outputs, self.inputs, strict=True)]
        if all(fits) or any(self._does_as(right, outputs) for right in self.also):
            if told := self._at_a_border(answer):
                return Verdict(NOT_YET, told)
            return Verdict(PASS, self.praise or f"right for {len(fits)} tries.")
        if told := of_bytes(answer, self):
            return Verdict(NOT_YET, told)
        for mistake in self.wrong:
            if self._does_as(mistake.answer, outputs, NEAR) and self._is(answer, mistake):
                return Verdict(NOT_YET, mistake.message)
        known = f"right for {sum(fits)} of {len(fits)} tries, but " if any(fits) else ""
        told = self.of_all(outputs) if self.of_all else ""
        told = told or self._turned(outputs) or of_a_function(answer, self, outputs)
        return Verdict(NOT_YET, told or known + self._example(fits.index(False), outputs))

    def _at_a_border(self, answer):
        """What is wrong where two cases meet; "" where nothing is."""
        for arguments, results in self.borders:
            given = _try(answer, arguments)
            if given is None:
                return self._nothing(answer, arguments)
            if not any(self._same(given, result) for result in results):
                either = " or ".join(say(result) for result in results)
                return f"for {self._given(arguments)} it gives {say(given)}, and {either} {self.unit} is expected: between two cases."
        return ""

    def _turned(self, outputs):
        """A mistake that people make, and a sign that is turned round as well; "" where it is not that."""
        if any(np.asarray(o).dtype.kind not in "iuf" for o in outputs):
            return ""
        turned = [-np.asarray(o) for o in outputs]
        if any(self._does_as(right, turned) for right in self.also):
            return "right but for its sign, which is turned round."
        meant = (m.message for m in self.wrong if self._does_as(m.answer, turned, NEAR))
        return next((f"{message} Then look at the signs." for message in meant), "")

    def _is(self, answer, mistake):
        """Whether a function that gives the same as a mistake does so elsewhere, too: one of a few cases may be met by chance."""
        said = np.asarray(self.right(*self.inputs[0]))
        of_cases = said.dtype == bool and said.ndim == 0 or " if " in self.solution
        return not of_cases or do_alike(answer, mistake.answer, self.inputs)

    def _does_as(self, function, outputs, *room):
        """Whether another function gives the same for every try; where it stopped, an output is None."""
        return all(self._same(o, _try(function, a), *room) for o, a in zip(outputs, self.inputs, strict=True))

    def _given(self, arguments):
        return ", ".join(f"{name} = {say(a)}" for name, a in zip(self.names, arguments, strict=True))

    def _example(self, k, outputs):
        """The first try that is not right."""
        given = self._given(self.inputs[k])
        right = self.right(*self.inputs[k])
        wanted = f"{say(right)} {self.unit}".rstrip()
        if say(right) != say(outputs[k]):
            return f"for {given} it gives {say(outputs[k])}, and {wanted} is expected."
        if np.shape(right) != np.shape(outputs[k]):
            return f"for {given} it gives {wanted} in more brackets than are asked for."
        return f"for {given} it gives {wanted} only nearly. Do not round, and look at the type of what you give back."

    def _same(self, value, right, part=None):
        if value is None or right is None:  # of a function that stopped
            return value is right
        truth = np.asarray(right).dtype == bool  # where True or False is asked for, they are the right kind
        try:
            value, right = np.asarray(value, float) if truth else as_numbers(value), np.asarray(right, float)
        except (TypeError, ValueError, OverflowError):
            return False
        if value.shape != right.shape and not (value.size == right.size == 1):
            return False
        room = self.tolerance + self.relative * np.abs(right)
        if part is not None:
            room = np.minimum(room, part * np.abs(right).max(initial=0))
        return bool(np.all(np.abs(value.reshape(right.shape) - right) <= room))


def _has_a_blank(function):
    """Whether ``____`` still stands in a function of Python's."""
    return "____" in getattr(getattr(function, "__code__", None), "co_names", ())


def _is_uneven(output):
    """Whether a list or a pair stands beside single numbers, or beside a longer one."""
    try:
        np.shape(output)
    except ValueError:
        return True
    return False


def _try(function, arguments):
    """What a function gives; None where it stops."""
    try:
        return called(function, arguments)
    except Exception:  # in whatever way
        return None

"""Kinds of answers: a number (or several), a choice, a function. Each says PASS or why not yet."""

from __future__ import annotations

import inspect
import re
import reprlib
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from stereo_lab.exercises.blank import is_blank
from stereo_lab.exercises.mistakes import of_a_function, of_a_number
from stereo_lab.exercises.reading import (
    NEGATIONS,
    OPEN_WORDS,
    UNSURE,
    as_numbers,
    key_words,
    numbers_in,
    without_contrast,
)
from stereo_lab.exercises.wording import a_kind, error_in_words, in_plain_words, kind_of, say

OF_A_MISTAKE = 0.05  # so near to a known mistake is that mistake: else 0 would be taken for metres
PASS, NOT_YET, NOT_ATTEMPTED = "PASS", "NOT YET", "NOT ATTEMPTED"


@dataclass(frozen=True)
class Verdict:
    """What is said to an answer.

    Attributes
    ----------
    status : PASS, NOT_YET or NOT_ATTEMPTED
    text : str, a sentence
    """

    status: str
    text: str = ""

    def __str__(self):
        said = f"{self.status} - {self.text}" if self.text else self.status
        return said.encode("utf-8", "backslashreplace").decode("utf-8")  # an answer may hold what cannot be printed


@dataclass(frozen=True, eq=False)
class Wrong:
    """A mistake that people make.

    Attributes
    ----------
    answer : an answer that shows it, of the same kind as the right one
    message : str, what to say to it
    """

    answer: Any
    message: str


@dataclass(frozen=True, eq=False)
class Number:
    """One number, or several in a row.

    Attributes
    ----------
    right : float or array
    tolerance : float, in ``unit``
    unit : str, "" for a bare number
    wrong : tuple of Wrong, their answers numbers of the same shape
    praise : str, what a right answer means; after it nothing needs to be added
    also : tuple, other right answers, for the tests
    of_several : str, what to say to several numbers where one is asked for
    labels : tuple of tuples of str, for each of several numbers the words that may stand beside it
    """

    right: ArrayLike
    tolerance: float
    unit: str = ""
    wrong: tuple[Wrong, ...] = ()
    praise: str = ""
    also: tuple[Any, ...] = ()
    of_several: str = ""
    labels: tuple[tuple[str, ...], ...] = ()

    def judge(self, answer: Any) -> Verdict:
        """PASS within the tolerance; else what is wrong, by name where the mistake is known."""
        right = np.asarray(self.right, float)
        if issubclass(type(answer), str):
            answer = self._read(str(answer), right)
            if isinstance(answer, str):
                return Verdict(NOT_YET, answer)
        try:
            value = as_numbers(answer)
        except (TypeError, ValueError, OverflowError):
            return Verdict(NOT_YET, f"expected {kind_of(right)}, this is {a_kind(answer)}.")
        if not np.isfinite(value).all():
            return Verdict(NOT_YET, "there is a value that is not a finite number.")
        if value.size == right.size:
            value = value.reshape(right.shape)
            if self._same(value, right):
                return Verdict(PASS, self.praise or f"{say(value)} {self.unit}".strip() + ".")
        for mistake in self.wrong:
            if self._same(value, np.asarray(mistake.answer, float), OF_A_MISTAKE):
                return Verdict(NOT_YET, mistake.message)
        return Verdict(
            NOT_YET, self._told(value, right) if value.size == right.size else self._count(answer, value, right)
        )

    def carried(self, answer: Any) -> Any:
        """A right answer as the cells below can count with it: a text or a list of one as the number that it tells."""
        right = np.asarray(self.right, float)
        if issubclass(type(answer), str):
            answer = np.array(self._read(str(answer), right))
        if right.size == 1 and not isinstance(answer, (int, float, np.number)):
            return float(as_numbers(answer).ravel()[0])
        return (
            tuple(as_numbers(answer).ravel().tolist())
            if right.size > 1 and not isinstance(answer, (tuple, list))
            else answer
        )

    def _read(self, text, right):
        """The numbers of a text, or a sentence. A comma before three digits is a decimal one, unless the number is right without."""
        labels = tuple(map(frozenset, self.labels))
        if right.size == 1 and re.search(r"\d,\d{3}(?!\d)", text):
            plain = numbers_in(re.sub(r"(?<=\d),(?=\d{3}(?!\d))", "", text), 1, self.unit, labels)
            if not isinstance(plain, str) and self._same(np.reshape(plain, right.shape), right):
                return plain
        return numbers_in(text, right.size, self.unit, labels)

    def _count(self, answer, value, right):
        """What to say where there are more numbers than are asked for, or fewer."""
        if right.size == 1 and isinstance(answer, tuple) and value.size == 2 and all(type(a) is int for a in answer):
            with_point = f"{answer[0]}.{abs(answer[1])}"
            if abs(float(with_point) - right) <= 0.1 * abs(right):
                return f"expected a number, these are 2: a comma parts them. Write {with_point} with a point."
        many = "this is one" if value.size == 1 else f"these are {value.size}"
        return f"expected {kind_of(right)}, {many}. {self.of_several}".strip()

    def _same(self, value, other, part=float("inf")):
        room = min(self.tolerance, part * np.abs(other).max())
        return value.shape == other.shape and bool(np.all(np.abs(value - other) <= room))

    def _told(self, value, right):
        """How the number stands to the right one; of several the one that is farthest off."""
        told = f"{say(value)} {self.unit}".rstrip()
        if right.size > 1:
            worst = int(np.argmax(np.abs(value - right)))
            if np.array_equal(value, right[::-1]):
                return "the right numbers, in another order."
            worst_told = f"{say(value[worst])} {self.unit}".rstrip()
            return (
                f"the {('first', 'second', 'third')[worst]} number is {worst_told}, and that is the one farthest off."
            )
        relation = of_a_number(float(value), float(right), told) if self.tolerance else ""
        return relation or f"{told} is too {'large' if value > right else 'small'}."


@dataclass(frozen=True, eq=False)
class Choice:
    """One of a few words.

    Attributes
    ----------
    right : str
    wrong : tuple of Wrong, one for each of the other words
    praise, also : as in :class:`Number`
    same : tuple of (words, other words), other ways to say a thing
    """

    right: str
    wrong: tuple[Wrong, ...]
    praise: str
    also: tuple[Any, ...] = ()
    same: tuple[tuple[str, str], ...] = ()

    @property
    def options(self) -> list[str]:
        """All words there are to choose from, sorted."""
        return sorted([self.right, *(w.answer for w in self.wrong)])

    def judge(self, answer: Any) -> Verdict:
        """PASS for the right word, large or small letters; else what is wrong with the other."""
        if isinstance(answer, (list, tuple)) and len(answer) == 1:
            answer = answer[0]
        listed = "; ".join(self.options)
        if not issubclass(type(answer), str):
            return Verdict(NOT_YET, f"answer with one of these, in quotes: {listed}.")
        if "____" in answer:
            return Verdict(NOT_ATTEMPTED)
        word = str.strip(answer).lower()
        meant = self.right if word in self.also else self._meant(answer)
        if meant == self.right:
            return Verdict(PASS, self.praise)
        for mistake in self.wrong:
            if meant == mistake.answer:
                return Verdict(NOT_YET, mistake.message)
        return Verdict(NOT_YET, f"{self._why_none(word)}: {listed}.")

    def _why_none(self, word):
        """Why words are none of the options."""
        words = key_words(word)
        if not words or words & UNSURE:
            return "a wrong guess costs nothing. Take one"
        if sum(key_words(option) <= words for option in self.options) > 1:
            return "these are two of the answers. Take one"
        if words & NEGATIONS:
            return f"{reprlib.repr(word)} says what it is not. Say what it is"
        return f"{reprlib.repr(word)} is not among the answers"

    def _meant(self, answer):
        """The one option that has the same words, or all of the answer's, or whose words the answer has; else None.

        Words that turn a meaning round must stand in the option as well.
        """
        told = without_contrast(str.lower(answer))
        for words, others in self.same:
            told = re.sub(rf"\b{words}\b", others, told)
        words, options = key_words(told), {option: key_words(option) for option in self.options}
        open_words = words & OPEN_WORDS
        for test in (words.__eq__, words.__le__, words.__ge__):
            found = [option for option, its in options.items() if words and its and test(its) and open_words <= its]
            if found:
                return found[0] if len(found) == 1 else None
        return None


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
    praise, also : as in :class:`Number`
    domain : str, what to say where the function stops with a ValueError, as acos does outside −1…1
    parts : dict, what the numbers in an argument are called, by the argument's name
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

    def judge(self, answer: Any) -> Verdict:
        """PASS where the function is right for every input; else the first that is not, or why it stopped."""
        if not callable(answer):
            return Verdict(NOT_YET, f"expected a function, this is {a_kind(answer)}. Give its name without brackets.")
        if type(answer).__module__ in SESSION:
            return Verdict(NOT_YET, "this belongs to Python itself and would end the lesson. Give a function of yours.")
        outputs: list[Any] = []
        for arguments in self.inputs:
            try:
                with np.errstate(all="ignore"):  # numpy's warnings would stand beside what is said here
                    output = answer(*(np.copy(a) if isinstance(a, np.ndarray) else a for a in arguments))
            except KeyboardInterrupt:
                raise  # the learner stops a function that does not end
            except BaseException as error:  # SystemExit as well: it would end the notebook
                return Verdict(NOT_ATTEMPTED) if _has_a_blank(answer) else Verdict(NOT_YET, self._stopped(error))
            if is_blank(output):
                return Verdict(NOT_ATTEMPTED)
            if output is None and any(o is not None for o in outputs):
                return Verdict(
                    NOT_YET, f"for {self._given(arguments)} your function gives nothing back. Is a case missing?"
                )
            if output is None:
                return Verdict(NOT_YET, "your function gives nothing back. Did you forget a return?")
            if isinstance(output, str) or (
                isinstance(output, (list, tuple)) and any(isinstance(o, str) for o in output)
            ):
                return Verdict(
                    NOT_YET, f"your function gives back a text, {reprlib.repr(output)}. Give back {self._asked()}."
                )
            if callable(output):
                return Verdict(
                    NOT_YET, "your function gives back another function. Was one named and not called? Put () after it."
                )
            if np.ndim(self.right(*arguments)) == 0 and np.size(output) == 1 and np.ndim(output) > 0:
                return Verdict(
                    NOT_YET, "your function gives back a list with one number in it. Give back the number itself."
                )
            outputs.append(output)
        return self._compare(answer, outputs)

    def _stopped(self, error):
        if isinstance(error, ValueError) and self.domain:
            return self.domain
        inside = getattr(
            error.__traceback__, "tb_next", None
        )  # an error of the call itself has no line of the function
        if isinstance(error, TypeError) and "positional argument" in str(error) and inside is None:
            return f"your function must take {len(self.inputs[0])}: {', '.join(self._names)}, in this order. Leave the def line as it was."
        return in_plain_words(error)

    @property
    def _names(self):
        """Of the arguments."""
        return list(inspect.signature(self.right).parameters)

    def _asked(self):
        """What the function is to give back, in words."""
        right = np.asarray(self.right(*self.inputs[0]))
        if right.dtype == bool:
            return "True or False" if right.ndim == 0 else "True or False for each"
        return "the number itself" if right.size == 1 else f"the {right.size} numbers themselves"

    def _compare(self, answer, outputs):
        fits = [self._same(o, self.right(*a)) for o, a in zip(outputs, self.inputs, strict=True)]
        if all(fits):
            return Verdict(PASS, self.praise or f"right for {len(fits)} tries.")
        for mistake in self.wrong:
            if all(
                self._same(o, _try(mistake.answer, a), OF_A_MISTAKE) for o, a in zip(outputs, self.inputs, strict=True)
            ):
                return Verdict(NOT_YET, mistake.message)
        known = f"right for {sum(fits)} of {len(fits)} tries, but " if any(fits) else ""
        told = of_a_function(answer, self.right, self.inputs, outputs, self._names, self.parts, self.relative)
        return Verdict(NOT_YET, told or known + self._example(fits.index(False), outputs))

    def _given(self, arguments):
        return ", ".join(f"{name} = {say(a)}" for name, a in zip(self._names, arguments, strict=True))

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


@dataclass(frozen=True, eq=False)
class Command:
    """A line for the controller of the arm: words, and numbers that may be written in any way; only the joint is one digit.

    A percentage of the speed may stand behind it.

    Attributes
    ----------
    right : str
    wrong : tuple of Wrong, their answers lines
    praise, also : as in :class:`Number`
    """

    right: str
    wrong: tuple[Wrong, ...] = ()
    praise: str = ""
    also: tuple[Any, ...] = ()

    def judge(self, answer: Any) -> Verdict:
        """PASS for the same words and numbers; else what the line says instead."""
        if isinstance(answer, (list, tuple)) and len(answer) == 1:
            answer = answer[0]
        if not issubclass(type(answer), str):
            return Verdict(NOT_YET, f"expected a line in quotes, this is {a_kind(answer)}.")
        if "____" in answer:
            return Verdict(NOT_ATTEMPTED)
        answer = str.strip(answer)
        for sign, message in SIGNS.items():
            if sign in answer:
                return Verdict(NOT_YET, message)
        words, right = _words(answer), _words(self.right)
        if re.fullmatch(r"N\d+", answer.split()[0], re.IGNORECASE):
            return Verdict(NOT_YET, "the number of the line is put before it for you: leave it away.")
        percent = words[len(right) :]
        if words[: len(right)] == right and (not percent or _is_percent(percent)):
            return Verdict(PASS, self.praise)
        for mistake in self.wrong:
            if words == _words(mistake.answer):
                return Verdict(NOT_YET, mistake.message)
        if len(words) != len(right):
            return Verdict(NOT_YET, f"expected {len(right)} words with blanks between them, this has {len(words)}.")
        wrong = ("first", "second", "third")[
            next(k for k, pair in enumerate(zip(words, right, strict=True)) if pair[0] != pair[1])
        ]
        return Verdict(NOT_YET, f"look at the {wrong} word of {reprlib.repr(answer)}: it says something else.")


SESSION = ("_sitebuiltins", "IPython.core.autocall")  # where exit, quit and help come from: calling one ends the lesson
SIGNS = {
    "−": "the arm does not know the sign − of a printed page. Type the minus of the keyboard: -",
    "°": "no sign ° in the line: the arm counts in degrees anyway.",
    ",": "no comma in the line: its words are parted by blanks.",
    "*": "the checksum is put behind it for you: leave it away.",
    "'": "no quotes inside the line: one pair round it is enough.",
}


def _has_a_blank(function):
    """Whether ``____`` still stands in a function of Python's."""
    return "____" in getattr(getattr(function, "__code__", None), "co_names", ())


def _is_percent(words):
    """Whether these words are one, and a part of the full speed."""
    return len(words) == 1 and isinstance(words[0], float) and 0 < words[0] <= 100


def _words(line):
    """Numbers as numbers, but the second word, the joint, as it stands."""
    words = line.upper().split()
    return [float(w) if k != 1 and w.lstrip("+-").replace(".", "", 1).isdecimal() else w for k, w in enumerate(words)]


def _try(function, arguments):
    """What a function that makes a known mistake gives; None where it stops."""
    try:
        with np.errstate(all="ignore"):
            return function(*arguments)
    except (ValueError, ZeroDivisionError):
        return None


def judge(kind: Number | Choice | Function | Command, answer: Any) -> Verdict:
    """The verdict on any answer; never raises, unless the learner stops it."""
    try:
        if is_blank(answer) or (type(answer) is str and not answer.strip()):
            return Verdict(NOT_ATTEMPTED)
        if answer is None:
            return Verdict(NOT_YET, "there is nothing in it yet: None. A line that prints gives nothing back.")
        return kind.judge(answer)
    except KeyboardInterrupt:
        raise
    except BaseException as error:
        return Verdict(NOT_YET, f"the answer could not be looked at ({error_in_words(error)}).")

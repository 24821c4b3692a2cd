"""An answer that is a number, or several in a row."""

from __future__ import annotations

import contextlib
import dataclasses
import re
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from stereo_lab.exercises.formulas import made_of
from stereo_lab.exercises.near_misses import is_near_by, of_a_number
from stereo_lab.exercises.reading import as_numbers, before_reason, numbers_in, told_beside, without_bound
from stereo_lab.exercises.verdict import NOT_YET, PASS, Verdict, Wrong
from stereo_lab.exercises.wording import a_kind, kind_of, say

OF_A_MISTAKE = 0.02  # so near to a known mistake is that mistake: else 0 would be taken for metres
A_FEW = 20  # of a count up to this, a factor would give the answer away


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
    known : dict, the numbers at hand by name: what a wrong answer may be made of
    ask : str, what to say after the formula of such an answer
    small, large : str, what a number would mean that is too small, or too large
    beside : tuple of (words, what to say), for words that people give instead of a number
    """

    right: ArrayLike
    tolerance: float
    unit: str = ""
    wrong: tuple[Wrong, ...] = ()
    praise: str = ""
    also: tuple[Any, ...] = ()
    of_several: str = ""
    labels: tuple[tuple[str, ...], ...] = ()
    known: dict[str, float] = field(default_factory=dict)
    ask: str = ""
    small: str = ""
    large: str = ""
    beside: tuple[tuple[str, str], ...] = ()

    def judge(self, answer: Any) -> Verdict:
        """PASS within the tolerance; else what is wrong, by name where the mistake is known."""
        right = np.asarray(self.right, float)
        if dataclasses.is_dataclass(answer) and not isinstance(answer, type):
            has = ", ".join(f".{name}" for name in _numbers_of(answer))
            told = f" Take a number out of it: {has}." if has else ""
            return Verdict(NOT_YET, f"expected {kind_of(right)}, this is {a_kind(answer)}.{told}")
        if issubclass(type(answer), str):
            if message := told_beside(answer, self.beside):
                return Verdict(NOT_YET, message)
            answer = self._read(str(answer), right)
            if isinstance(answer, str):
                return Verdict(NOT_YET, answer)
        try:
            value = as_numbers(answer)
        except (TypeError, ValueError, OverflowError):
            if isinstance(answer, (list, tuple)) and any(isinstance(part, str) for part in answer):
                return Verdict(
                    NOT_YET,
                    "a number and a text stand side by side. Leave the text away, or write both in one pair of quotes.",
                )
            return Verdict(NOT_YET, f"expected {kind_of(right)}, this is {a_kind(answer)}.")
        if not np.isfinite(value).all():
            return Verdict(NOT_YET, "there is a value that is not a finite number.")
        if value.size == right.size:
            value = value.reshape(right.shape)
            for mistake in self.wrong:
                other = not np.allclose(
                    mistake.answer, right, rtol=1e-9, atol=0
                )  # else the mistake makes no difference here
                if mistake.exact and other and np.allclose(value, mistake.answer, rtol=1e-12, atol=0):
                    return Verdict(NOT_YET, mistake.message)
            if self._same(value, right):
                return Verdict(PASS, self.praise or f"{say(value)} {self.unit}".strip() + ".")
        if mistake := self._mistake(value):
            return Verdict(NOT_YET, mistake.message)
        return Verdict(
            NOT_YET, self._told(value, right) if value.size == right.size else self._count(answer, value, right)
        )

    def _mistake(self, value):
        """The known mistake that a wrong answer shows: the nearest, where several are near; else None.

        What the right number is when rounded is that, though a mistake be near as well.
        """
        if self.tolerance and _is_rounded(value, np.asarray(self.right, float)):
            return next((mistake for mistake in self.wrong if np.array_equal(value, mistake.answer)), None)
        shown = [
            (np.abs(value - known).max(), k)
            for k, known in enumerate(np.asarray(mistake.answer, float) for mistake in self.wrong)
            if self._same(value, known, OF_A_MISTAKE) or _is_rounded(value, known)
        ]
        return self.wrong[min(shown)[1]] if shown else None

    def carried(self, answer: Any) -> Any:
        """A right answer as the cells below can count with it: a text, a list of one or a list of texts as the numbers that it tells."""
        right = np.asarray(self.right, float)
        if issubclass(type(answer), str):
            answer = np.array(self._read(str(answer), right))
        plain = (int, float, np.number)
        if isinstance(answer, (tuple, list)) and right.size > 1 and all(isinstance(part, plain) for part in answer):
            return answer
        if isinstance(answer, plain):
            return answer
        numbers = as_numbers(answer).ravel().tolist()
        return numbers[0] if right.size == 1 else tuple(numbers)

    def _read(self, text, right):
        """The numbers of a text, or a sentence. A comma before three digits is a decimal one, unless the number is right without.

        "More than 180" is read as 180 where what is right is more.
        """
        text = before_reason(text)
        plain, side = without_bound(text)
        if side and right.size == 1:
            bound = self._read(plain, right)
            if not isinstance(bound, str) and side * (float(right) - bound[0]) > 0:
                return bound
        labels = tuple(map(frozenset, self.labels))
        if right.size == 1 and re.search(r"\d,\d{3}(?!\d)", text):
            plain = numbers_in(re.sub(r"(?<=\d),(?=\d{3}(?!\d))", "", text), 1, self.unit, labels)
            if not isinstance(plain, str) and self._same(np.reshape(plain, right.shape), right):
                return plain
        return numbers_in(text, right.size, self.unit, labels)

    def _count(self, answer, value, right):
        """What to say where there are more numbers than are asked for, or fewer."""
        two = isinstance(answer, tuple) and value.size == 2 and all(type(a) is int for a in answer)
        if right.size == 1 and self.tolerance and two:
            with_point = f"{answer[0]}.{abs(answer[1])}"
            room = self.tolerance if abs(answer[0] - right) <= self.tolerance else 0.1 * abs(right)
            is_all = np.isclose(answer[0], right, rtol=1e-9)  # then the second is no decimals of it
            if not is_all and abs(float(with_point) - right) <= room:
                return f"expected a number, these are 2: a comma parts them. Write {with_point} with a point."
        many = "this is one" if value.size == 1 else f"these are {value.size}"
        labels = f": {' and '.join(words[0] for words in self.labels)}" if self.labels else ""
        alone = "Which one of them?" if right.size == 1 else ""
        return f"expected {kind_of(right)}{labels}, {many}. {self.of_several or alone}".strip()

    def _same(self, value, other, part=float("inf")):
        room = min(self.tolerance, part * np.abs(other).max())
        return value.shape == other.shape and bool(np.all(np.abs(value - other) <= room))

    def _told(self, value, right):
        """How the number stands to the right one; of several the one that is farthest off."""
        told = f"{say(value)} {self.unit}".rstrip()
        if right.size > 1:
            if np.array_equal(value, right[::-1]):
                return "the right numbers, in another order."
            if self.labels:
                off = [
                    f"{words[0]} {say(mine)} is too {'many' if mine > its else 'few'}"
                    for words, mine, its in zip(self.labels, value, right, strict=True)
                    if mine != its
                ]
                return f"{', '.join(off)}: count again."
            if right.size == 2 and (value == right).any():
                good, other = ("first", "second") if value[0] == right[0] else ("second", "first")
                off = f"{say(value[value != right])} {self.unit}".rstrip()
                return f"the {good} number is right; the {other} number is {off}: look at it again."
            worst = int(np.argmax(np.abs(value - right)))
            worst_told = f"{say(value[worst])} {self.unit}".rstrip()
            return (
                f"the {('first', 'second', 'third')[worst]} number is {worst_told}, and that is the one farthest off."
            )
        number, wanted = float(value), float(right)
        if not self.tolerance and abs(number - wanted) == 1 and abs(wanted) > A_FEW:
            return f"{told} is one too {'many' if number > wanted else 'few'}: counted from 0, or copied wrongly? {self.ask}".strip()
        counts = not self.tolerance and abs(wanted) <= A_FEW  # a factor would give the answer away
        relation = "" if counts or self.unit == "times" else of_a_number(number, wanted, told)
        formula = "" if relation else made_of(number, self.known)
        if formula:
            return f"that is {formula}. {self.ask}".strip()
        if wanted and not relation and self._same(-value, right):
            return f"{told}: the sign is turned."
        if self.tolerance and not relation and is_near_by(number, wanted):
            return f"{told} is near, and not right yet: is something rounded, read off by eye, or copied wrongly?"
        size, means = ("large", self.large) if number > wanted else ("small", self.small)
        return relation or f"{told} is too {size}{': ' if means else '. '}{means or self.ask}".strip()


def _numbers_of(thing):
    """The names, fields and properties, under which a thing holds a number."""
    names = []
    for name in dir(thing):
        with contextlib.suppress(Exception):  # a property may fail
            if not name.startswith("_") and isinstance(getattr(thing, name), (int, float, np.number)):
                names.append(name)
    return names


def _is_rounded(value, number):
    """Whether a number was written with fewer decimals than it has, but not with so few that it is another one."""
    if value.size != 1 or number.size != 1 or not np.allclose(value, number, rtol=0.01, atol=0):
        return False
    return any(np.array_equal(value.ravel(), np.round(number.ravel(), digits)) for digits in range(4))

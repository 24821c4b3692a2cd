"""The formula by which a number comes out of those at hand: what a learner may have typed instead of the right one."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import permutations, product
from typing import Any

import numpy as np

EXACT = 1e-9  # by so little, as a part of it, a number may differ from what a formula gives


def made_of(value: float, known: dict[str, float]) -> str:
    """How a number comes out of those that are at hand, as a formula; "" where no short one gives it.

    Parameters
    ----------
    value : float
    known : the numbers at hand by name
    """
    if not value or not np.isfinite(value):
        return ""
    for name, number in known.items():
        if _is(value, number) or any(_is(value, np.round(number, k)) for k in (0, 1, 2)):
            return name
    with np.errstate(all="ignore"):
        return next((term.text for term in _formulas(known) if _is(value, term.number)), "")


@dataclass(frozen=True)
class _Term:
    """A formula: its text, what it gives, the names in it, and whether it wants brackets before it is multiplied."""

    text: str
    number: Any
    names: frozenset[str]
    is_sum: bool = False

    @property
    def held(self) -> str:
        return f"({self.text})" if self.is_sum else self.text


def _formulas(known: dict[str, float]) -> Iterator[_Term]:
    """Formulas of one, two, three and four of the known numbers, the shortest first."""
    one = [_Term(name, np.float64(number), frozenset([name])) for name, number in known.items()]
    two = [term for pair in permutations(one, 2) for term in _joined(*pair)]
    for t in one:
        x = t.number
        yield from (_Term(f"-{t.text}", -x, t.names), _Term(f"{t.text}**2", x * x, t.names))
        yield from (_Term(f"1 / {t.text}", 1 / x, t.names), _Term(f"the root of {t.text}", np.sqrt(x), t.names))
    for t in (*one, *two):
        yield from (t, _Term(f"{t.held} / 2", t.number / 2, t.names), _Term(f"2 * {t.held}", 2 * t.number, t.names))
    for pair in (*product(two, one), *product(one, two)):
        yield from _joined(*pair)
    sums = [t for t in two if t.is_sum]
    for pair in product(sums, sums):
        yield from _joined(*pair)


def _joined(a: _Term, b: _Term) -> Iterator[_Term]:
    """Two formulas with no number in common, joined in each way."""
    names = a.names | b.names
    if len(names) == len(a.names) + len(b.names):
        yield _Term(f"{a.text} + {b.text}", a.number + b.number, names, True)
        yield _Term(f"{a.text} - {b.held}", a.number - b.number, names, True)
        yield _Term(f"{a.held} * {b.held}", a.number * b.number, names)
        yield _Term(
            f"{a.held} / {b.held if '/' not in b.text and '*' not in b.text else f'({b.text})'}",
            a.number / b.number,
            names,
        )
        yield _Term(f"the root of {a.held}**2 + {b.held}**2", np.hypot(a.number, b.number), names, True)


def _is(value, number):
    return bool(abs(value - number) <= EXACT * abs(number))

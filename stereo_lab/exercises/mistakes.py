"""Names of mistakes that nobody foresaw: how an answer stands to the right one, and what it hangs on."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator, Sequence
from itertools import combinations
from typing import Any

import numpy as np

from stereo_lab.exercises.wording import say

EXACT = 1e-9  # where another number might be near by chance
NEAR = 1e-3  # so near, as a part of the value, two numbers are taken for one
ENDLESS = 1e12  # so many times what is right: rounding errors stand below the line, in the place of zero
FACTORS = {
    1000.0: "a thousand times too large: look at the units.",
    100.0: "a hundred times too large.",
    10.0: "ten times too large.",
    2.0: "twice as large as it should be.",
    0.5: "half of what it should be.",
    0.1: "ten times too small.",
    0.01: "a hundred times too small.",
    0.001: "a thousand times too small: look at the units.",
    180 / np.pi: "180/π times too large: degrees and radians.",
    np.pi / 180: "180/π times too small: degrees and radians.",
}
HOW_MANY = {0.25: "a quarter", 0.5: "half", 1.0: "the same", 2.0: "twice as much", 4.0: "four times as much"}


def of_a_number(value: float, right: float, told: str) -> str:
    """What one wrong number is to the right one; "" where it is nothing of note. ``told`` is the number with its unit."""
    if not right or not value:
        return ""
    if _near(value, -right):
        return f"{told}: the sign is turned."
    for factor in (1000.0, 100.0, 10.0, 2.0, 0.5, 0.1, 0.01, 0.001):
        if _near(value, factor * right):
            return f"{told} is {FACTORS[factor]}"
    if abs(right) != 1:
        for other, words in ((1 / right, "upside down: it is one over"), (right**2, "the square of")):
            if _near(value, other):
                return f"{told} is {words} what is asked for."
    if any(value == round(right, k) for k in (0, 1)):
        return f"{told} is rounded too much. Keep its decimals."
    return ""


def of_a_function(
    function: Callable,
    right: Callable,
    inputs: Sequence[tuple],
    outputs: Sequence[Any],
    names: Sequence[str],
    parts: dict[str, tuple[str, ...]],
    near: float = NEAR,
) -> str:
    """What a wrong function does otherwise than the right one, in every try; "" where nothing simple is found.

    Parameters
    ----------
    function, right : callables
    inputs : the arguments of each try
    outputs : what ``function`` gave for them
    names : of the arguments
    parts : what the numbers in an argument are called, by the argument's name
    near : so near, as a part of the value, two results are taken for one
    """
    wanted = [np.asarray(right(*arguments)) for arguments in inputs]
    if wanted[0].dtype == bool:
        return _of_true_and_false(inputs, outputs, wanted, names)
    try:
        given = [np.asarray(output, float) for output in outputs]
    except (TypeError, ValueError, OverflowError):
        return ""
    if any(g.size != w.size for g, w in zip(given, wanted, strict=True)):
        count = next(g.size for g, w in zip(given, wanted, strict=True) if g.size != w.size)
        sum_or_mean = " Is a sum or a mean missing?" if wanted[0].size == 1 and count > 3 else ""
        return f"it gives {_count(count)}, and {_asked(wanted[0].size)} asked for.{sum_or_mean}"
    given, wanted = [g.ravel() for g in given], [w.ravel().astype(float) for w in wanted]
    if any(not (np.abs(g) <= ENDLESS * (1 + np.abs(w).max())).all() for g, w in zip(given, wanted, strict=True)):
        squares = " Steps from a mean add up to zero: square each of them first." if np.ndim(inputs[0][0]) else ""
        return f"your result has no bounds: something below a line is zero, or nearly.{squares}"
    told = _relation(given, wanted, max(near, NEAR)) or _arguments(right, inputs, given, names)
    if told or wanted[0].size > 3:
        return told
    for k in range(wanted[0].size):
        if not all(_near(g[k], w[k]) for g, w in zip(given, wanted, strict=True)):
            place = f"the {('first', 'second', 'third')[k]} number: " if wanted[0].size > 1 else ""
            hangs = _what_it_hangs_on(_entry(function, k), _entry(right, k), inputs, names, parts)
            rest = "the others are right. " if wanted[0].size > 2 else "the other one is right. "
            alone = wanted[0].size > 1 and all(
                _near(g[j], w[j]) for g, w in zip(given, wanted, strict=True) for j in range(len(w)) if j != k
            )
            return f"{place}{rest if alone else ''}{hangs}" if hangs or alone else ""
    return ""


def _relation(given, wanted, near):
    """A relation that holds between all given numbers and those that are wanted."""
    value, right = np.concatenate(given), np.concatenate(wanted)
    if np.array_equal(value, right):
        return ""  # but for the brackets
    for digits in range(4):
        if np.allclose(value, np.round(right, digits), rtol=0, atol=1e-9):
            return "you round. Give the number with all its decimals."
    if np.array_equal(value, np.floor(right)) or np.array_equal(value, np.trunc(right)):
        return "the decimals are cut off: // and int do that. Divide by a single /."
    if _near(value, -right):
        return "the sign is turned."
    if (right < 0).any() and _near(value, np.abs(right)):
        return "right but for the sign: abs takes it away, and here it counts."
    if len(wanted[0]) > 1 and all(_near(g, w[::-1]) for g, w in zip(given, wanted, strict=True)):
        return "the right numbers, in another order."
    for factor, words in FACTORS.items():
        if _near(value, factor * right, near):
            return f"your result is {words}"
    if (right != 0).all() and len(right) > 1:
        factor = value[0] / right[0]
        if abs(factor) > NEAR and abs(factor - 1) > NEAR and _near(value, factor * right):
            return f"in every try your result is {factor:.3g} times what it should be."
        if (np.abs(right) != 1).any() and _near(value, 1 / right):
            return "your result is upside down: what stands above the line belongs below it."
    if (right > 0).all() and len(right) > 1:
        if _near(value, right**2):
            return "your result is the square of what is asked for: a root is missing."
        if _near(value, np.sqrt(right)):
            return "your result is the root of what is asked for: one root too many."
    return ""


def _arguments(right, inputs, given, names):
    """Whether the arguments have changed places, one is given back as it came, or none of them matters."""
    first = inputs[0]
    for i, j in combinations(range(len(first)), 2):
        if not (np.shape(first[i]) == np.shape(first[j]) == ()) or not all(isinstance(first[k], float) for k in (i, j)):
            continue
        swapped = [tuple(t[j] if k == i else t[i] if k == j else t[k] for k in range(len(t))) for t in inputs]
        values = [_call(right, arguments) for arguments in swapped]
        if (
            all(v is not None and _near(g, v.ravel(), EXACT) for g, v in zip(given, values, strict=True))
            and len({float(g[0]) for g in given}) > len(given) / 2
        ):
            return f"it works as if {names[i]} and {names[j]} had changed places."
    for k, name in enumerate(names):
        if all(np.size(t[k]) == g.size and _is(t[k], g, EXACT) for t, g in zip(inputs, given, strict=True)):
            return f"it gives {name} back, and nothing else."
    wanted = [right(*arguments) for arguments in inputs]
    if (
        len(inputs) > 1
        and all(_near(g, given[0]) for g in given)
        and not all(_is(w, np.ravel(wanted[0])) for w in wanted)
    ):
        return f"it gives {say(given[0])} whatever comes in. Use the names in the brackets of the def line: {', '.join(names)}."
    return ""


def _what_it_hangs_on(function, right, inputs, names, parts):
    """The first argument that, doubled, does something else to the result than it should, in one try or in all of them."""
    seen: dict[str, list] = {}
    for arguments in inputs:
        for name, doubled in _doubled(arguments, names, parts):
            values = [_call(f, a) for f in (function, right) for a in (arguments, doubled)]
            if all(value is not None for value in values):
                seen.setdefault(name, []).append([float(value) for value in values])
    told = {name: (_moves(tries, 0), _moves(tries, 2)) for name, tries in seen.items()}
    for name, (yours, should) in told.items():
        if should and not yours:
            return f"{name} changes nothing in your result, and it should."
    for name, (yours, should) in told.items():
        if yours and not should:
            return f"{name} changes your result, and it should not."
    for name, tries in seen.items():
        for before, after, was, becomes in tries:
            if before and was and not _near(before, after) and not _near(was, becomes):
                mine, its = (
                    next((w for v, w in HOW_MANY.items() if _near(v, r)), "") for r in (after / before, becomes / was)
                )
                if mine and its and mine != its:
                    return f"twice the {name} should give {its}; yours gives {mine}."
    for name, tries in seen.items():
        for before, after, was, becomes in tries:
            if not _near(was, becomes) and not _near(after - before, becomes - was):
                return (
                    f"look at {name}: twice as large it should bring {say(was)} to {say(becomes)}; "
                    f"yours goes from {say(before)} to {say(after)}."
                )
    return ""


def _moves(tries, first):
    """Whether a result moves in any of the tries."""
    return any(not _near(numbers[first], numbers[first + 1]) for numbers in tries)


def _doubled(arguments: tuple, names: Sequence[str], parts: dict[str, tuple[str, ...]]) -> Iterator[tuple[str, tuple]]:
    """The arguments with one number in them twice as large, and what that number is called."""
    for k, (argument, name) in enumerate(zip(arguments, names, strict=True)):
        put = lambda new, k=k: (*arguments[:k], new, *arguments[k + 1 :])
        if isinstance(argument, (int, float)) and argument or isinstance(argument, np.ndarray):
            yield name, put(2 * argument)
        elif isinstance(argument, tuple):
            for i, part in enumerate(argument):
                told = parts[name][i] if name in parts else f"{name}[{i}]"
                yield told, put((*argument[:i], 2 * part + (not part), *argument[i + 1 :]))
        elif dataclasses.is_dataclass(argument) and not isinstance(argument, type):
            for field in dataclasses.fields(argument):
                part = getattr(argument, field.name)
                if isinstance(part, (int, float)):
                    yield (
                        f"{name}.{field.name}",
                        put(dataclasses.replace(argument, **{field.name: 2 * part + (not part)})),
                    )


def _of_true_and_false(inputs, outputs, wanted, names):
    """The first thing that is called True and should not be, or the other way round."""
    for arguments, output, right in zip(inputs, outputs, wanted, strict=True):
        if np.size(output) != right.size:
            return f"one True or False for each of {right.size} is asked for, and it gives {_count(np.size(output))}."
        if not np.isin(np.ravel(output), (0, 1)).all():
            return "True or False is asked for, and it gives a number: compare it with something."
        for k, (mine, its) in enumerate(zip(np.ravel(output), right.ravel(), strict=True)):
            if bool(mine) != bool(its):
                told = ", ".join(
                    f"{name} = {say(np.ravel(a)[k] if np.size(a) == right.size > 1 else a)}"
                    for name, a in zip(names, arguments, strict=True)
                )
                return f"for {told} it says {bool(mine)}, and {bool(its)} is expected."
    return ""


def _entry(function, k):
    """The function, and of all that it gives one number alone."""
    return lambda *arguments: np.ravel(function(*arguments))[k]


def _call(function, arguments):
    """What it gives, as an array; None where it stops or gives no finite numbers."""
    try:
        with np.errstate(all="ignore"):
            value = np.asarray(function(*(np.copy(a) if isinstance(a, np.ndarray) else a for a in arguments)), float)
    except Exception:
        return None
    return value if value.size and np.isfinite(value).all() else None


def _is(value, numbers, near=NEAR):
    try:
        return _near(np.ravel(np.asarray(value, float)), numbers, near)
    except (TypeError, ValueError):
        return False


def _near(value, other, near=NEAR):
    value, other = np.asarray(value, float), np.asarray(other, float)
    if value.shape != other.shape or not np.isfinite(value).all():
        return False
    return bool(np.all(np.abs(value - other) <= near * np.abs(other).max(initial=1e-12)))


def _count(size):
    return {0: "nothing", 1: "one number"}.get(size, f"{size} numbers")


def _asked(size):
    return "one is" if size == 1 else f"{size} are"

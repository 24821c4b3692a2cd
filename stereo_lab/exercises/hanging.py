"""What the result of a wrong function hangs on: each argument changed in turn, in it and in the right one."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np

from stereo_lab.exercises.trying import EXACT, NEAR, near, numbers_of
from stereo_lab.exercises.wording import figures, say

AS_IF = (  # what may have become of an argument on its way
    (lambda x: 0.0 * x, "were 0"),  # first: what is left out may look like a turned sign as well
    (lambda x: -x, "had its sign turned"),
    (lambda x: 2 * x, "were twice as large"),
    (lambda x: x / 2, "were half as large"),
    (lambda x: x * x, "were squared"),
    (np.radians, "were turned into radians once more"),
    (np.degrees, "were turned into degrees once more"),
)


def as_if(right, inputs, given, names, parts):
    """What the right function would give, had something become of one of its arguments: "" where that is not it."""
    for change, words in AS_IF:
        changed: dict[str, dict[int, tuple]] = {}
        for k, arguments in enumerate(inputs):
            for name, _, other in _changed(arguments, names, parts, change):
                changed.setdefault(name, {})[k] = other
        for name, tries in changed.items():
            values = [numbers_of(right, tries.get(k, arguments)) for k, arguments in enumerate(inputs)]
            if all(v is not None and near(g, v, EXACT) for g, v in zip(given, values, strict=True)):
                return f"it works as if {name} {words}."
    return ""


def what_it_hangs_on(function, right, inputs, names, parts, room=NEAR):
    """The first argument that has another power in the result than it should, or none, or should have none."""
    seen = _seen(function, right, inputs, names, parts)
    told = {name: (_moves(tries, 0), _moves(tries, 2)) for name, tries in seen.items()}
    for name, (_, should) in told.items():
        if should and not _moves(seen[name], 0, 0.0):
            return f"{name} changes nothing in your result, and it should."
    for name, (yours, should) in told.items():
        if yours and not should:
            return f"{name} changes your result, and it should not."
    for name, (yours, should) in _powers(seen, room).items():
        if yours is not None and should is not None and yours != should and not _right_once(seen):
            return _of_powers(name, yours, should)
    return ""


def how_it_moves(function, right, inputs, names, parts, room=NEAR):
    """An argument that, doubled, moves the result otherwise than it should: in the same way in every try, or the one that does so most."""
    seen = _seen(function, right, inputs, names, parts)
    powers = _powers(seen, room)
    added = [name for name, (yours, should) in powers.items() if should is not None and yours is None]
    if added and not _right_once(seen):
        return _of_no_power(added[0], powers[added[0]][1], seen[added[0]])
    for name, tries in seen.items():
        if said := _of_steps(name, tries, seen):
            return said
    for name in seen:
        if len(seen) > 1 and _is_added(name, function, right, inputs, names, parts):
            return f"yours is off by something that hangs on {name} alone: look at where {name} comes in."
    wrong = [
        ((after - before) / (becomes - was), name, before, after, was, becomes)
        for name, tries in seen.items()
        for before, after, was, becomes, _ in tries
        if not near(was, becomes) and not near(after - before, becomes - was)
    ]
    if not wrong or near([one[0] for one in wrong], np.full(len(wrong), wrong[0][0])):
        return ""  # all is so many times as large: that is no argument's fault
    _, name, before, after, was, becomes = max(wrong, key=lambda one: abs(one[0] - 1))
    return (
        f"look at {name}: twice as large it should bring {say(was)} to {say(becomes)}; "
        f"yours goes from {say(before)} to {say(after)}."
    )


def _is_added(name, function, right, inputs, names, parts):
    """Whether a result is the right one and something more, which no other argument changes."""
    moved = False
    for arguments in inputs:
        here = _more(function, right, arguments)
        for changed, _, other in _doubled(arguments, names, parts):
            there = _more(function, right, other)
            if here is None or there is None:
                return False
            if changed == name:
                moved = moved or abs(there - here) > EXACT
            elif abs(there - here) > EXACT:
                return False
    return moved


def _more(function, right, arguments):
    """What a result has more than the right one; None where one of them is none."""
    values = [numbers_of(f, arguments) for f in (function, right)]
    return None if any(v is None for v in values) or len(values[0]) != 1 else float(values[0][0] - values[1][0])


def _seen(function, right, inputs, names, parts):
    """For each argument, in each try: both results, before and after it is doubled, and the argument."""
    seen: dict[str, list] = {}
    for arguments in inputs:
        for name, number, doubled in _doubled(arguments, names, parts):
            values = [numbers_of(f, a) for f in (function, right) for a in (arguments, doubled)]
            if all(value is not None for value in values):
                seen.setdefault(name, []).append([float(value[0]) for value in values] + [number])
    return seen


def _powers(seen, room):
    """The power of each argument in the result, and in the right one."""
    return {name: (_power(tries, 0, room), _power(tries, 2, room)) for name, tries in seen.items()}


def _right_once(seen):
    return any(near(numbers[0], numbers[2]) for tries in seen.values() for numbers in tries)


def _power(tries, first, room):
    """The power of an argument in a result, from what doubling it does; None where it is none, or not the same in every try."""
    if not all(numbers[first] and numbers[first + 1] / numbers[first] > 0 for numbers in tries):
        return None
    powers = [np.log2(numbers[first + 1] / numbers[first]) for numbers in tries]
    whole = round(2 * float(np.median(powers))) / 2  # a root is half a power
    return whole if np.allclose(powers, whole, rtol=0, atol=2 * room if room > NEAR else EXACT) else None


def _of_powers(name, yours, should):
    """What to say where an argument counts with another power than it should."""
    does = {0.5: "stands under a root", 1.0: "counts once", 2.0: "is squared", 3.0: "is taken to the power of three"}
    if not yours:
        return f"{name} hardly counts in your result, and belongs {'above' if should > 0 else 'below'} the line."
    mine = does.get(abs(yours), f"is taken to the power of {abs(yours):g}")
    its = {0.5: "stand under a root", 1.0: "count once", 2.0: "be squared"}.get(
        abs(should), f"be taken to the power of {abs(should):g}"
    )
    if yours * should < 0:
        here, there = ("above", "below") if yours > 0 else ("below", "above")
        return f"{name} stands {here} the line, and belongs {there} it{f', where it should {its}' if abs(should) != 1 else ''}."
    return f"{name} {mine} in your result, and should {its}."


def _of_no_power(name, should, tries):
    """What to say where doubling an argument should always bring the same factor, and does not; by the try where it misses it most."""
    factor = 2.0**should
    before, after, *_ = max(tries, key=lambda numbers: abs(numbers[1] - factor * numbers[0]))
    return (
        f"twice as large a {name} should bring {figures(factor)} times the result, whatever the other numbers are; yours goes from "
        f"{say(before)} to {say(after)}. Is something added, taken away or rounded?"
    )


def _of_steps(name, tries, seen):
    """What to say where an argument moves the result by more or less than it should, in the same way in every try."""
    steps = [(numbers[1] - numbers[0], numbers[3] - numbers[2]) for numbers in tries]
    if len(steps) < 2 or any(not should or not yours for yours, should in steps):
        return ""
    ratios = [yours / should for yours, should in steps]
    if near(ratios, np.full(len(ratios), -1.0), EXACT):
        return f"{name} moves your result the wrong way: is a sign turned, or have two things changed places?"
    for factor, words in ((2.0, "twice as far as it should"), (0.5, "half as far as it should")):
        if near(ratios, np.full(len(ratios), factor), EXACT):
            return f"{name} moves your result {words}."
    for other, their in seen.items():
        numbers = [numbers[4] for numbers in their]
        if other == name or len(numbers) != len(ratios) or not all(isinstance(n, (int, float)) and n for n in numbers):
            continue
        for power, words in (
            (1, "is multiplied by {}, and should not be"),
            (-1, "is divided by {} where it should not be, or not multiplied by it where it should be"),
        ):
            if len(set(numbers)) > 1 and near(ratios, np.array(numbers, float) ** power, EXACT):
                return f"{name} {words.format(other)}."
    return ""


def _moves(tries, first, room=NEAR):
    """Whether a result moves in any of the tries."""
    return any(not near(numbers[first], numbers[first + 1], room) for numbers in tries)


def _doubled(arguments, names, parts):
    """The arguments with one number in them twice as large, or 1 where it is 0."""
    return _changed(arguments, names, parts, lambda number: 2 * number + (np.ndim(number) == 0 and not number))


def _changed(
    arguments: tuple, names: Sequence[str], parts: dict[str, tuple[str, ...]], change: Callable
) -> Iterator[tuple[str, Any, tuple]]:
    """What each number in the arguments is called, the number, and the arguments with that one changed; of those with a name."""
    for k, (argument, name) in enumerate(zip(arguments, names, strict=True)):
        if not name:
            continue
        put = lambda new, k=k: (*arguments[:k], new, *arguments[k + 1 :])
        if isinstance(argument, (int, float)) and argument or isinstance(argument, np.ndarray):
            yield name, argument, put(change(argument))
        elif isinstance(argument, tuple):
            for i, part in enumerate(argument):
                told = parts[name][i] if name in parts else f"{name}[{i}]"
                yield told, part, put((*argument[:i], change(part), *argument[i + 1 :]))
        elif dataclasses.is_dataclass(argument) and not isinstance(argument, type):
            for field in dataclasses.fields(argument):
                part = getattr(argument, field.name)
                if isinstance(part, (int, float)):
                    yield f"{name}.{field.name}", part, put(dataclasses.replace(argument, **{field.name: change(part)}))

"""Names of mistakes that nobody foresaw in a function: how what it gives stands to what is right."""

from __future__ import annotations

import dis
import math
import re
import warnings
from collections.abc import Callable, Sequence
from functools import partial
from itertools import combinations
from typing import TYPE_CHECKING, Any

import numpy as np

from stereo_lab.exercises.hanging import as_if, how_it_moves, what_it_hangs_on
from stereo_lab.exercises.near_misses import FACTORS
from stereo_lab.exercises.slips import do_alike, rounded_number, slip_in, strange_number
from stereo_lab.exercises.trying import EXACT, NEAR, called, is_as, near, numbers_of
from stereo_lab.exercises.wording import say

if TYPE_CHECKING:
    from stereo_lab.exercises.function import Function

ENDLESS = 1e12  # so many times what is right: rounding errors stand below the line, in the place of zero
BELOW_ZERO = "a root or a logarithm is taken of a number below zero: look at the signs, and at what comes first."
ROOT_BELOW_ZERO = "your result is the root of a number below zero: look at the signs, and what is squared first."


def of_a_function(function: Callable, kind: Function, outputs: Sequence[Any]) -> str:
    """What a wrong function does otherwise than the right one, in every try; "" where nothing simple is found.

    Parameters
    ----------
    function : callable
    kind : what is asked for
    outputs : what ``function`` gave for its inputs
    """
    right, inputs, names, parts = kind.right, kind.inputs, kind.names, kind.parts
    room, held, endless = kind.relative, kind.held, kind.endless
    slip = partial(slip_in, function, right, inputs, kind.solution)
    wanted = [np.asarray(right(*arguments)) for arguments in inputs]
    if wanted[0].dtype == bool:
        return _of_true_and_false(function, kind, outputs, wanted, slip)
    try:
        given = [np.asarray(output, float) for output in outputs]
    except (TypeError, ValueError, OverflowError):
        return ""
    if any(g.size != w.size for g, w in zip(given, wanted, strict=True)):
        count, asked = next((g.size, w.size) for g, w in zip(given, wanted, strict=True) if g.size != w.size)
        sum_or_mean = " Is a sum or a mean missing?" if asked == 1 and count > 3 else ""
        comma = f" {asked} numbers stand with a comma between them." if count == 1 < asked <= 3 else ""
        if count == 1 < asked and isinstance(right(*inputs[0]), np.ndarray):
            return "it gives one number, and one for each is asked for. Is an index, a sum or a mean taken that is not asked for?"
        return f"it gives {_count(count)}, and {_asked(asked)} asked for.{sum_or_mean}{comma}"
    given, wanted = [g.ravel() for g in given], [w.ravel().astype(float) for w in wanted]
    if any(np.isnan(g).any() for g in given):
        return slip() or _no_number(function, inputs, endless)
    if any((np.abs(g) > ENDLESS * (1 + np.abs(w).max())).any() for g, w in zip(given, wanted, strict=True)):
        return f"your result has no bounds: {endless or 'something below a line is zero, or nearly.'}"
    if all(near(g, w, EXACT) for g, w in zip(given, wanted, strict=True)):
        return ""  # but for the brackets
    few = {w.size for w in wanted} <= {wanted[0].size} and wanted[0].size <= 3
    told = rounded_number(function, right, inputs)
    told = told or next(filter(None, (_rounds(function, asked, kind, given) for asked in (right, *kind.also))), "")
    told = told or _relation(given, wanted, max(room, NEAR))
    told = told or _arguments(function, right, inputs, given, names)
    told = told or slip(1) or _from_above(function)
    names = ["" if name in held else name for name in names]
    told = told or as_if(right, inputs, given, names, parts)
    if few:
        told = told or _of_one(what_it_hangs_on, function, right, inputs, given, wanted, names, parts, room)
    told = told or slip()
    if few:
        told = told or _of_one(how_it_moves, function, right, inputs, given, wanted, names, parts, room)
    return told or _constant(given, wanted)


def _no_number(function, inputs, endless):
    """Where nan comes from, as numpy warns of it."""
    with warnings.catch_warnings(record=True) as heard, np.errstate(all="warn"):
        warnings.simplefilter("always")
        for arguments in inputs:
            called(function, arguments)
    if any(re.fullmatch("invalid value .* divide", str(warning.message)) for warning in heard):
        return f"zero is divided by zero: {endless or 'look at what stands below the line.'}"
    return BELOW_ZERO


def of_bytes(function: Callable, kind: Function) -> str:
    """What to say of a function that would be right, did bytes not go on from 255 below 0; "" of all others."""
    names = [n for n, given in zip(kind.names, kind.inputs[0], strict=True) if getattr(given, "dtype", "") == np.uint8]
    if not names:
        return ""
    for arguments in kind.inputs:
        wide = tuple(a.astype(int) if isinstance(a, np.ndarray) else a for a in arguments)
        mine, its = numbers_of(function, wide), numbers_of(kind.right, wide)
        if mine is None or its is None or not np.array_equal(mine, its):
            return ""
    return f"{names[0]} holds bytes, and below 0 a byte goes on from 255. Make whole numbers of them first: {names[0]}.astype(int)."


def _of_one(say_of, function, right, inputs, given, wanted, names, parts, room):
    """What is to be said of the first number that is not right."""
    off = [not all(near(g[k], w[k]) for g, w in zip(given, wanted, strict=True)) for k in range(len(wanted[0]))]
    if not any(off):
        return ""
    k, several = off.index(True), len(off) > 1
    here, asked = [g[k : k + 1] for g in given], _entry(right, k)
    told = several and (_swapped(asked, inputs, here, names) or as_if(asked, inputs, here, names, parts))
    told = told or say_of(_entry(function, k), asked, inputs, names, parts, max(room, NEAR))
    if not told or not several:
        return told
    alone = f" (The other{'s are' if len(off) > 2 else ' one is'} right.)" if sum(off) == 1 else ""
    return f"the {('first', 'second', 'third')[k]} number: {told}{alone}"


def _rounds(function, right, kind, given):
    """Whether decimals are rounded or cut off: in the tries, where it may be by chance, and elsewhere.

    Where no argument makes sense twice as large there is no elsewhere.
    """
    value = np.concatenate(given)
    whole = np.concatenate([np.ravel(right(*arguments)) for arguments in kind.inputs]).astype(float)
    if value.shape != whole.shape or np.array_equal(value, whole):
        return ""
    ways = [lambda x, digits=digits: np.round(x, digits) for digits in range(4)]
    steps = [lambda x, digits=digits: np.ceil(x * 10**digits) / 10**digits for digits in range(4)]
    for way in (*ways, np.floor, np.trunc, *steps):
        if not np.allclose(value, way(whole), rtol=0, atol=1e-9):
            continue
        changed = lambda *arguments, way=way: way(np.asarray(right(*arguments), float))
        if set(kind.names) <= set(kind.held) or do_alike(function, changed, kind.inputs):
            if way in steps:
                return f"your result goes up in steps of {0.1 ** steps.index(way):g}. Give the number with all its decimals: a formula has no steps."
            cut = "the decimals are cut off: int and // do that. Leave int away, and divide by a single /."
            return "you round. Give the number with all its decimals." if way in ways else cut
    return ""


def _relation(given, wanted, room):
    """A relation that holds between all given numbers and those that are wanted."""
    value, right = np.concatenate(given), np.concatenate(wanted)
    if np.array_equal(value, right):
        return ""  # but for the brackets
    if near(value, -right):
        return "the sign is turned."
    if (right < 0).any() and near(value, np.abs(right)):
        return "right but for the sign: abs takes it away, and here it counts."
    if len(wanted[0]) > 1 and all(near(g, w[::-1]) for g, w in zip(given, wanted, strict=True)):
        return "the right numbers, in another order."
    for factor, words in FACTORS.items():
        if near(value, factor * right, room):
            return f"your result is {words}"
    if (right != 0).all() and len(right) > 1 and (np.abs(right) != 1).any() and near(value, 1 / right):
        return "your result is upside down: what stands above the line belongs below it."
    if (right > 0).all() and (value > 0).all() and (right != 1).all() and len(right) > 1:
        powers = np.log(value) / np.log(right)
        if abs(powers[0]) > NEAR and near(powers, np.full(len(powers), powers[0]), EXACT):
            roots = {
                2.0: "the square of what is asked for: a root is missing.",
                0.5: "the root of what is asked for: one root too many.",
                4.0: "what is asked for, to the power of four: a square stands where a root belongs.",
            }
            return "your result is " + roots.get(
                round(powers[0], 6), f"what is asked for, to the power of {powers[0]:.3g}."
            )
    return ""


def _constant(given, wanted):
    """What is the same in every try: so many times what it should be, or so much more."""
    value, right = np.concatenate(given), np.concatenate(wanted)
    if len(right) > 1 and near(value - right, np.full(len(right), value[0] - right[0]), EXACT):
        off = value[0] - right[0]
        return f"in every try your result is {say(abs(off))} too {'large' if off > 0 else 'small'}."
    if len(right) > 1 and (right != 0).all():
        factor = value[0] / right[0]
        if abs(factor) > NEAR and abs(factor - 1) > NEAR and near(value, factor * right):
            return f"your result is always {factor:.3g} times what it should be: one number too many stands there, or one too few."
    return ""


def _arguments(function, right, inputs, given, names):
    """Whether the arguments have changed places, one is given back as it came, or none of them matters."""
    for k, name in enumerate(names):
        if all(np.size(t[k]) == g.size and is_as(t[k], g, EXACT) for t, g in zip(inputs, given, strict=True)):
            return f"it gives {name} back, and nothing else."
    if swapped := _swapped(right, inputs, given, names):
        return swapped
    wanted = [right(*arguments) for arguments in inputs]
    if (
        len(inputs) > 1
        and all(near(g, given[0]) for g in given)
        and not all(is_as(w, np.ravel(wanted[0])) for w in wanted)
    ):
        told = f"it gives {say(given[0])} whatever comes in"
        if set(names) <= _used_in(function):
            return f"{told}: is something rounded or cut off on the way, or does it cancel?"
        return f"{told}. Use the names in the brackets of the def line: {', '.join(names)}."
    return ""


def _from_above(function):
    """What to say of a function that counts with a number from a cell above; "" of all others."""
    above, code = getattr(function, "__globals__", {}), getattr(function, "__code__", None)
    named = [step.argval for step in dis.get_instructions(code) if step.opname == "LOAD_GLOBAL"] if code else []
    numbers = (name for name in named if isinstance(above.get(name), (int, float)) and not hasattr(math, name))
    name = next(numbers, "")
    return (
        name
        and f"{name} comes from a cell above and is the same whatever comes in. Work it out inside, from the names in the brackets of the def line."
    )


def _used_in(function):
    """The names of a function of Python's that its lines make use of."""
    code = getattr(function, "__code__", None)
    return {step.argval for step in dis.get_instructions(code) if step.opname.startswith("LOAD")} if code else set()


def _swapped(right, inputs, given, names):
    """Which two arguments seem to have changed places; "" where none."""
    first = inputs[0]
    for i, j in combinations(range(len(first)), 2):
        if not (np.shape(first[i]) == np.shape(first[j]) == ()) or not all(isinstance(first[k], float) for k in (i, j)):
            continue
        swapped = [tuple(t[j] if k == i else t[i] if k == j else t[k] for k in range(len(t))) for t in inputs]
        values = [numbers_of(right, arguments) for arguments in swapped]
        if (
            all(v is not None and near(g, v, EXACT) for g, v in zip(given, values, strict=True))
            and len({float(g[0]) for g in given}) > len(given) / 2
        ):
            return f"it works as if {names[i]} and {names[j]} had changed places."
    return ""


def _of_true_and_false(function, kind, outputs, wanted, slip):
    """The first thing that is called True and should not be, or the other way round."""
    for output, asked in zip(outputs, wanted, strict=True):
        if np.size(output) != asked.size:
            if asked.size == 1:
                return f"one True or False is asked for, and it gives {_count(np.size(output))}: compare {kind.names[0]} with something."
            return (
                f"one True or False for each of {asked.size} is asked for, and it gives {_count(np.size(output))}. "
                "A comparison gives them: no [ ] round it, no index, no sum."
            )
        if not np.isin(np.ravel(output), (0, 1)).all():
            return "True or False is asked for, and it gives a number: compare it with something."
    told = slip(1) or _of_a_side(function, kind) or _of_no_matter(function, kind.right, kind.inputs, kind.names)
    if told := told or slip() or strange_number(function, kind.right, kind.solution):
        return told
    for arguments, output, right in zip(kind.inputs, outputs, wanted, strict=True):
        for k, (mine, its) in enumerate(zip(np.ravel(output), right.ravel(), strict=True)):
            if bool(mine) != bool(its):
                told = ", ".join(
                    f"{name} = {say(np.ravel(a)[k] if np.size(a) == right.size > 1 else a)}"
                    for name, a in zip(kind.names, arguments, strict=True)
                )
                return f"for {told} it says {bool(mine)}, and {bool(its)} is expected."
    return ""


def _of_a_side(function, kind):
    """Whether a yes or no hangs on the sign of an argument that counts without it."""
    for k, name in enumerate(kind.names):
        tries = [t for t in kind.inputs if isinstance(t[k], (int, float)) and t[k]]
        turned = [(*t[:k], -t[k], *t[k + 1 :]) for t in tries]
        mine, its = (
            [_alike(numbers_of(f, t), numbers_of(f, u)) for t, u in zip(tries, turned, strict=True)]
            for f in (function, kind.right)
        )
        if tries and all(its) and not all(mine):
            number = tries[mine.index(False)][k]
            return f"{name} = {say(number)} and {name} = {say(-number)} get different answers, and should not: abs() takes a sign away."
    return ""


def _of_no_matter(function, right, inputs, names):
    """The first argument that never changes a yes or no, and should."""
    for k, name in enumerate(names):
        changes = []
        for asked in (function, right):
            tries = [
                [numbers_of(asked, (*t[:k], scale * t[k], *t[k + 1 :])) for scale in (1, 0.01, 100)] for t in inputs
            ]
            changes.append(
                any(other is None or not near(other, of[0]) for of in tries if of[0] is not None for other in of)
            )
        if changes == [False, True]:
            return f"{name} changes nothing in your answer, and it should."
    return ""


def _alike(value, other):
    return value is not None and other is not None and near(value, other)


def _entry(function, k):
    """The function, and of all that it gives one number alone."""
    return lambda *arguments: np.ravel(function(*arguments))[k]


def _count(size):
    return {0: "nothing", 1: "one number"}.get(size, f"{size} numbers")


def _asked(size):
    return "one is" if size == 1 else f"{size} are"

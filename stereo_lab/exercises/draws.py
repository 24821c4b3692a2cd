"""Other inputs for a function, drawn after it was written: whoever typed in a table of results is found out."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np

from stereo_lab.exercises.answers import Function

ROOM = 0.12  # so much, as a part of it, a number is drawn away from the one in the lesson
TRIES = 40  # draws, of which the first that is fit is taken


def _of_length_one(u, v, du, dv, r):
    return u, v, du / math.hypot(du, dv), dv / math.hypot(du, dv), r


def _with_its_elbow(l1, l2, x, y, theta2_deg):
    cos = (x * x + y * y - l1 * l1 - l2 * l2) / (2 * l1 * l2)
    return l1, l2, x, y, math.copysign(math.degrees(math.acos(min(max(cos, -1), 1))), theta2_deg)


def _with_the_truth(p, y):
    return np.clip(p, 0.02, 0.98), np.round(y)


def _of_things(x, p, y):
    return np.column_stack([np.ones(len(x)), x[:, 1:]]), *_with_the_truth(p, y)


HOLDS = {
    "2.4": _of_length_one,
    "5.4": _with_its_elbow,
    "9.3": _with_the_truth,
    "9.4": _of_things,
}  # what a question says of its inputs holds for drawn ones as well


def with_fresh_inputs(name: str, answer: Function, seed: int) -> Function:
    """The same question with other inputs.

    A drawn input is like one of the lesson's: numbers a little larger or smaller, whole ones whole, zeros zero, and none overtakes
    another. What the right function stops at, or answers with no number, is drawn again, or left out.

    Parameters
    ----------
    name : str, of the question, such as "2.4"
    answer : Function
    seed : int

    Returns
    -------
    Function
    """
    rng = np.random.default_rng(seed)
    drawn = [_fit(name, answer, arguments, rng) for arguments in answer.inputs]
    return dataclasses.replace(answer, inputs=tuple(arguments for arguments in drawn if arguments is not None))


def _fit(name, answer, arguments, rng):
    """A draw that the right function answers as it answers the lesson's own input."""
    for _ in range(TRIES):
        drawn = tuple(_drawn(a, rng) for a in arguments)
        if name in HOLDS:
            drawn = HOLDS[name](*drawn)
        if _order(drawn) == _order(arguments) and _kind(answer, drawn) == _kind(answer, arguments):
            return drawn
    return None


def _drawn(value: Any, rng: np.random.Generator) -> Any:
    """A value like this one."""
    if isinstance(value, (bool, np.bool_)):
        return value
    if isinstance(value, np.ndarray) and value.dtype.kind in "iu":
        return rng.integers(value.min(), value.max(), value.shape, value.dtype, endpoint=True)
    if isinstance(value, np.ndarray):
        return (value * rng.uniform(1 - ROOM, 1 + ROOM, value.shape)).astype(value.dtype)
    if isinstance(value, (int, np.integer)):
        least = (abs(int(value)) + 1) // 2
        return type(value)(np.sign(value) * rng.integers(least, abs(int(value)), endpoint=True))
    if isinstance(value, (float, np.floating)):
        return type(value)(value * rng.uniform(1 - ROOM, 1 + ROOM))
    if isinstance(value, (tuple, list)):
        return type(value)(_drawn(part, rng) for part in value)
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        parts = {field.name: _drawn(getattr(value, field.name), rng) for field in dataclasses.fields(value)}
        return dataclasses.replace(value, **parts)
    return value


def _order(arguments):
    """Which of the single numbers are larger than which: hits stay below frames, a forearm below an upper arm."""
    numbers = [float(a) for a in arguments if isinstance(a, (int, float, np.number))]
    return tuple(np.argsort(numbers, kind="stable"))


def _kind(answer, arguments):
    """What the right function gives, without its value: a shape, where it is finite, or the error that it stops with."""
    try:
        with np.errstate(all="ignore"):
            given = np.asarray(answer.right(*arguments))
    except (ValueError, ZeroDivisionError, IndexError, KeyError) as error:
        return type(error).__name__
    shape = given.shape
    return shape, given.dtype.kind, bool(np.isfinite(given.astype(float)).all())

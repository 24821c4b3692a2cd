"""Answers and inputs as plain data, so that they can go through a pipe. Nothing that comes in is ever run.

JSON, with a tag round what JSON does not know. Both ends use it: the desk, where a learner's notebook runs, and the examiner.
"""

from __future__ import annotations

import base64
import re
from collections.abc import Callable
from typing import Any

import numpy as np

from stereo_lab.exercises.blank import ____, is_blank
from stereo_lab.recording.sample import Position

LONGEST_TEXT = 2_000  # letters; no answer of the course has more than a hundred
LARGEST_ARRAY = 10_000_000  # bytes: functions of the kit's get whole pictures, a megapixel in floats
LONGEST_LIST = 200_000  # things in it
DEEPEST = 8  # lists in lists
PLACE = ("x_mm", "y_mm", "depth_mm")
# Letters that steer a screen, and those that turn the writing on it round (all of Unicode's Bidi_Control)
STEERING = re.compile(r"[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u202a-\u202e\u2066-\u2069]")
BARE = (set, dict, complex)  # no answers: they are told by their kind, whatever is in them


class Thing:
    """Stands for an object that cannot go through the pipe: only its kind is known."""


def pack(value: Any, function: Callable[[Any], int] | None = None, depth: int = 0) -> Any:
    """What JSON can write instead of a value.

    Parameters
    ----------
    value : anything; never changed, and none of its own methods is trusted to give back what it should
    function : callable, optional
        Gives a callable a number by which it is found again; without it, a callable is a thing like any other.
    depth : int, lists that are round it

    Returns
    -------
    None, bool, int, float, str or dict
    """
    if value is None or type(value) in (bool, float):
        return value
    if type(value) is int:
        return value if abs(value) < 2**200 else {"thing": "int"}
    if issubclass(type(value), str):
        return str.__str__(value)[:LONGEST_TEXT]
    if is_blank(value):
        return {"blank": True}
    if isinstance(value, np.generic):
        value = np.asarray(value)
    if isinstance(value, np.ndarray) and value.dtype.kind in "biuf" and value.nbytes <= LARGEST_ARRAY:
        value = np.asarray(value, value.dtype.newbyteorder("<"))
        raw = base64.b64encode(value.tobytes()).decode("ascii")
        return {"array": raw, "type": value.dtype.str, "shape": list(value.shape)}
    for kind in (list, tuple):
        if issubclass(type(value), kind) and depth < DEEPEST and kind.__len__(value) <= LONGEST_LIST:
            return {kind.__name__: [pack(part, function, depth + 1) for part in kind.__iter__(value)]}
    if isinstance(value, Position):
        return {"place": [pack(float(getattr(value, name))) for name in PLACE]}
    if callable(value) and function is not None:
        return {
            "function": function(value),
            "blank": "____" in getattr(getattr(value, "__code__", None), "co_names", ()),
        }
    bare = next((kind.__name__ for kind in BARE if isinstance(value, kind)), "")
    return {"bare": bare} if bare else _numbers(value) or {"thing": str(type(value).__name__)[:80]}


def _numbers(value):
    """What numpy takes for numbers (a Decimal, a deque, an array of objects), for it counts in a notebook as well; else None."""
    try:
        parts = np.asarray(value, object)
        if parts.size <= LONGEST_LIST and not any(isinstance(p, (bool, np.bool_, complex)) for p in parts.ravel()):
            return pack(np.asarray(value, float))
    except Exception:  # whatever its own methods do
        return None
    return None


def unpack(told: Any, function: Callable[[int, bool], Any] | None = None, depth: int = 0) -> Any:
    """The value that :func:`pack` was given, or a :class:`Thing`.

    Parameters
    ----------
    told : what JSON read
    function : callable, optional
        Gives what stands for the callable of a number; told as well whether a blank is left in it.
    depth : int

    Raises
    ------
    ValueError
        If this is nothing that ``pack`` writes.
    """
    if told is None or isinstance(told, (bool, int, float)):
        return told
    if isinstance(told, str):
        return told[:LONGEST_TEXT]
    if not isinstance(told, dict) or depth > DEEPEST:
        raise ValueError("no packed value")
    if "function" in told and function is not None:
        return function(int(told["function"]), bool(told.get("blank")))
    if "blank" in told:
        return ____
    if "array" in told:
        return _array(told)
    if "bare" in told:
        return {kind.__name__: kind for kind in BARE}[told["bare"]]()
    for kind, make in (("list", list), ("tuple", tuple)):
        if kind in told:
            return make(unpack(part, function, depth + 1) for part in list(told[kind]))
    if "place" in told:
        right, up, away = (float(part) for part in told["place"])
        return Position(right, up, away)
    return type(legible(str(told["thing"]), 80) or "thing", (Thing,), {})()


def legible(text: str, most: int = LONGEST_TEXT) -> str:
    """A text of a learner's as any file and any screen takes it: no halves of letters, none that steers it or turns its words."""
    whole = text[:most].encode("utf-8", "backslashreplace").decode("utf-8")
    return STEERING.sub("\N{REPLACEMENT CHARACTER}", whole.replace("\r\n", "\n"))


def _array(told):
    if not re.fullmatch(r"[<>|]?[biuf]\d{1,2}", told["type"]):  # numpy would run what it reads in there
        raise ValueError("no array of numbers")
    kind, shape = np.dtype(told["type"]), [int(side) for side in told["shape"]]
    if len(shape) > DEEPEST or not all(0 <= side <= LARGEST_ARRAY for side in shape):
        raise ValueError("no array of numbers")
    values = np.frombuffer(base64.b64decode(str(told["array"])), kind).reshape(shape)
    return values[()] if not shape else values.copy()

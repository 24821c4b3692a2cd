"""Answers of any kind in words, and as numbers: what is said of them never fails, whatever they are."""

from __future__ import annotations

import re
from typing import Any

import numpy as np

NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?")
NAMES = ("zero", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten")
IN_WORDS = {name: str(k) for k, name in enumerate(NAMES)} | {"once": "1", "twice": "2"}
SMALL_WORDS = frozenset(("a", "an", "the", "it", "its", "in", "on", "of", "is", "to"))
# What Python and numpy say of common slips, and the same for people
SAID = (
    ("truth value of an array", "or, and, not and if take one value, and here is a whole array: write | and & and ~, each side in brackets of its own."),
    ("Python scalars", "math takes one number, and here is a whole array: take the function of that name from np."),
    ("name 'math' is not defined", "nobody told Python of math yet: write import math above your function."),
    ("name 'np' is not defined", "nobody told Python of np yet: write import numpy as np above your function."),
    ("object is not callable", "before a bracket a * is missing: Python takes a(b) for a call of a."),
    ("for ^", "a power is written ** in Python."),
    ("'builtin_function_or_method'", "a function is named and not called: put () after it."),
    ("'Position' and 'Position'", "places cannot be subtracted as a whole: take the numbers in them, as a.x_mm - b.x_mm."),
    ("'Position' object is not", "a place is no list: take the numbers in it, as a.x_mm."),
    ("'Position' object has no attribute", "a place has x_mm, y_mm and depth_mm."),
    ("'tuple'", "a pair of numbers stands where one is meant: take one with [0] or [1]."),
)  # fmt: skip


def in_plain_words(error: BaseException) -> str:
    """What to say of an error that a learner's function stopped with."""
    told = error_in_words(error)
    plain = next((sentence for part, sentence in SAID if part in told), "")
    if isinstance(error, NameError) and not plain:
        plain = "this name is not known here: use the names in the brackets of the def line."
    return (
        f"your function stopped with {told}"
        + ("" if told.endswith(".") else ".")
        + (f" That means: {plain}" if plain else "")
    )


def numbers_in(text: str, count: int) -> list[float] | None:
    """The numbers in a text, with their units, in words, with a decimal comma; None where there are not as many.

    Parameters
    ----------
    text : str
    count : int
    """
    words = " ".join(IN_WORDS.get(word, word) for word in text.lower().replace("−", "-").strip(" .").split())
    for parts in (words, re.sub(r"(?<=\d),(?=\d)", ".", words)):
        found = NUMBER.findall(parts)
        if len(found) == count:
            return [float(number) for number in found]
    return None


def key_words(text: str) -> frozenset[str]:
    """The words of a short answer that matter: in small letters, without quotes, full stops and small words."""
    return frozenset(re.findall(r"[^\W_]+", text.lower())) - SMALL_WORDS


def error_in_words(error: BaseException) -> str:
    """The kind and the text of an error of the learner's; the text may itself fail."""
    try:
        return f"{type(error).__name__}: {error}"
    except Exception:
        return type(error).__name__


def as_numbers(answer: Any) -> np.ndarray:
    """The answer as an array of floats.

    Raises
    ------
    TypeError
        For True and False, which Python counts as 1 and 0, and for complex numbers.
    """
    parts = answer if isinstance(answer, np.ndarray) else np.asarray(answer, object).ravel()
    if parts.dtype.kind in "bc" or (
        parts.dtype == object and any(isinstance(part, (bool, np.bool_, complex)) for part in parts.ravel())
    ):
        raise TypeError("no plain number")
    return np.asarray(answer, float)


def kind_of(right: np.ndarray) -> str:
    """What is expected where this is right: a number, or so many of them."""
    return "a number" if right.size == 1 else f"{right.size} numbers" if right.ndim == 1 else f"the shape {right.shape}"


def a_kind(answer: Any) -> str:
    """The kind of an answer, as in: a list."""
    kinds = {
        str: "a text",
        bool: "True or False",
        int: "a number",
        float: "a number",
        complex: "the root of a number below zero",
    }
    return kinds.get(type(answer)) or f"a {type(answer).__name__}"


def say(value: Any) -> str:
    """A number as people write it; an array by its shape."""
    if isinstance(value, str):
        return repr(value)
    if isinstance(value, (bool, np.bool_)):
        return str(bool(value))
    if type(value).__name__ == "Position":
        return f"the place ({value.x_mm:g}, {value.y_mm:g}, {value.depth_mm:g})"
    try:
        array = np.asarray(value, float)
    except (TypeError, ValueError, OverflowError):
        return a_kind(value)
    if array.size == 1:
        return f"{float(array.ravel()[0]):.4g}"
    return "(" + ", ".join(f"{v:.4g}" for v in array.ravel()) + ")" if array.size <= 4 else f"an array {array.shape}"

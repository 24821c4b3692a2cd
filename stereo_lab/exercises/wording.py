"""Answers of any kind in words, and as numbers: what is said of them never fails, whatever they are."""

from __future__ import annotations

from typing import Any

import numpy as np


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
    return f"a {type(answer).__name__}"


def say(value: Any) -> str:
    """A number as people write it; an array by its shape."""
    if isinstance(value, str):
        return repr(value)
    if isinstance(value, (bool, np.bool_)):
        return str(bool(value))
    try:
        array = np.asarray(value, float)
    except (TypeError, ValueError, OverflowError):
        return a_kind(value)
    if array.size == 1:
        return f"{float(array.ravel()[0]):.4g}"
    return "(" + ", ".join(f"{v:.4g}" for v in array.ravel()) + ")" if array.size <= 4 else f"an array {array.shape}"

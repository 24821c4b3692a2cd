"""Answers of any kind in words: what is said of them never fails, whatever they are."""

from __future__ import annotations

import math
import re
import traceback
from typing import Any

import numpy as np

from stereo_lab.errors import UnreachableTargetError

# What Python and numpy say of common slips, and the same for people
SAID = (
    ("truth value of an array", "one True or False is wanted here, and there is a whole array: write | and & and ~ for or, and, not, with each comparison in brackets of its own, (a <= b) | (c <= d); and part a <= b <= c in two."),
    ("Python scalars", "math takes one number, and here is a whole array: take the function of that name from np."),
    ("name 'math' is not defined", "nobody told Python of math yet: write import math above your function."),
    ("name 'np' is not defined", "nobody told Python of np yet: write import numpy as np above your function."),
    ("'tuple' object is not callable", "what stands in a list or a pair is taken with square brackets: [0], not (0)."),
    ("'numpy.ndarray' object is not callable", "what stands in a list or an array is taken with square brackets: [0], not (0)."),
    ("object is not callable", "before a bracket a * is missing: Python takes a(b) for a call of a."),
    ("for ^", "^ is no power in Python: a power is written **, and times is *."),
    ("bitwise_xor", "^ is no power in Python: a power is written **, and times is *."),
    ("'builtin_function_or_method'", "a function is named and not called: put () after it."),
    ("'Position' and 'Position'", "places cannot be subtracted as a whole: take the numbers in them, as a.x_mm - b.x_mm."),
    ("'Detection' and 'Detection'", "detections cannot be subtracted as a whole: take the numbers in them, as a.u - b.u."),
    ("'Detection' object has no", "a detection has u, v and radius_px, in px."),
    ("'LineFit' object has no", "a fitted line has slope_mm_per_px and offset_mm."),
    ("'LineFit' and", "a fitted line is no number: take one that it holds, as line.slope_mm_per_px."),
    ("and 'LineFit'", "a fitted line is no number: take one that it holds, as line.slope_mm_per_px."),
    ("Improper number of dimensions to norm", "np.linalg.norm takes one list of steps: np.linalg.norm([a, b]). np.hypot takes two numbers."),
    ("indices must be integers", "an index is a whole number: [0], [1]."),
    ("too many indices", "there are more numbers in the square brackets than it has directions: rows, columns, channels."),
    ("only integers, slices", "an index is a whole number, without quotes: [0], [1]."),
    ("'Position' object has no attribute", "a place has x_mm, y_mm and depth_mm."),
    ("'Position' object is not", "a place is no list: take the numbers in it, as a.x_mm."),
    ("not Position", "a place is no number: take the numbers in it, as a.x_mm."),
    ("math domain error", "a root of a number below zero, or acos of one beyond 1: look at signs and brackets, and that squares are squared: **2."),
    ("maximum recursion depth", "your function calls itself, again and again. Work with the names in its brackets."),
    ("object is not subscriptable", "this is one number already: nothing in [ ] behind it."),
    ("index out of range", "Python counts from 0: the first one is [0]."),
    ("out of bounds", "Python counts from 0: the first one is [0]."),
    ("expected 2 arguments, got 1", "atan2 and hypot take two things, with a comma between them: atan2(y, x)."),
    ("required positional argument", "a function that you call wants one thing more: look at its def line."),
    ("division by zero", "something below a line is zero in one of the tries."),
    ("has no len()", "this is one number already: take it as it is."),
    ("object is not iterable", "this is one number already: take it as it is."),
    ("'float' object has no attribute", "this is one number. Use the names in the brackets of the def line."),
    ("return arrays must be", "np.hypot takes two numbers. math.hypot takes as many as there are."),
    ("could not be broadcast", "two arrays of different shapes meet. .T turns a table round, [:, None] makes a column of a row."),
    ("not aligned", "two arrays of different shapes meet. .T turns a table round, [:, None] makes a column of a row."),
    ("mismatch in its core dimension", "two arrays of different shapes meet. .T turns a table round, [:, None] makes a column of a row."),
    ("boolean subtract", "True and False are not subtracted: join them by | or &."),
    ("not supported between instances of 'tuple'", "a comma makes a pair of two things. Join them by | or &."),
    ("'function' and", "a function is named and not called: put () after it, with what it works on."),
    ("and 'function'", "a function is named and not called: put () after it, with what it works on."),
    ("of type function", "a function is named and not called: put () after it, with what it works on."),
    ("not function", "a function is named and not called: put () after it, with what it works on."),
    ("multiply sequence", "a pair, a list or a text is not multiplied as a number is: take the numbers in it one by one."),
    ("multiply 'NoneType'", "a function that you call gives nothing back."),
    ("'NoneType'", "a function that you call gives nothing back."),
    ("and 'str'", "a text in quotes is no number: take the quotes away."),
    ("'str' and", "a text in quotes is no number: take the quotes away."),
    ("not str", "a text in quotes is no number: take the quotes away."),
    ("to str", "a text in quotes is no number: take the quotes away."),
    ("could not convert string", "a text in quotes is no number: take the quotes away."),
    ("not complex", "a root of a number below zero: look at the signs, and what is squared first."),
    ("'complex'", "a root of a number below zero: look at the signs, and what is squared first."),
    ("not list", "a list stands where one number is meant: take one with [0] or [1]."),
    ("'list'", "a list is not counted with as a number is: take the numbers in it, or np.array of it."),
    ("positional argument", "a function that you call got more than it takes, or less: look at its def line."),
    ("exactly one argument", "a function that you call takes one thing alone, or a comma stands for a point."),
    ("too many values to unpack", "there are more numbers in it than names before the =."),
    ("not enough values to unpack", "there are fewer numbers in it than names before the =."),
    ("cannot unpack", "this is one number alone: one name before the =."),
    ("local variable", "a name is used before it is given a value: an = further up. If it is a function that you call, give your result another name than the function's."),
    ("only integer scalar arrays", "an index is one whole number: [0], [1]."),
    ("has no attribute 'mean'", "this is one number already, or a list: np.array has .mean() and .sum()."),
    ("has no attribute 'sum'", "this is one number already, or a list: np.array has .mean() and .sum()."),
    ("'numpy.ndarray' object has no attribute", "an array has .shape, .mean(), .sum() and .max(); for other things np has functions, as np.linalg.norm(T)."),
    ("cannot assign to field", "places and detections stay as they are: give what you work out a name of its own, as dx = a.x_mm - b.x_mm."),
    ("'tuple'", "a pair of numbers stands where one is meant: take one with [0] or [1]."),
    ("not tuple", "a pair of numbers stands where one is meant: take one with [0] or [1]."),
)  # fmt: skip


def in_plain_words(error: BaseException, arrays: bool = False) -> str:
    """What to say of an error that a learner's function stopped with, which works on arrays or on single numbers."""
    if isinstance(error, UnreachableTargetError):
        return (
            "your function asks an arm of the package, which has links of its own. Other arms are tried as well: "
            "write the equation itself, with the names in the brackets of the def line."
        )
    told, plain = error_in_words(error), meaning_of(error)
    stopped_in = "".join(frame.line or "" for frame in traceback.extract_tb(error.__traceback__)[-1:])
    if re.search(r"hypot\(\s*[\[(]", stopped_in) and re.search(r"not (tuple|list)$", told):
        plain = "hypot takes numbers with commas between them: take the inner brackets away."
    if isinstance(error, NameError) and not plain:
        name = str(getattr(error, "name", ""))
        if name.startswith("arc"):
            plain = f"in math its name is {name.replace('arc', 'a')}, in numpy np.{name}."
        elif arrays and hasattr(np, name):
            plain = f"{name} is not imported here: write np.{name}."
        elif hasattr(math, name):
            plain = f"{name} is not imported here: write math.{name}, and import math above your function."
        else:
            plain = "this name is not known here: use the names in the brackets of the def line."
    return (
        f"your function stopped with {told}"
        + ("" if told.endswith(".") else ".")
        + (f" That means: {plain}" if plain else "")
    )


def meaning_of(error: BaseException) -> str:
    """The same in a sentence for people; "" where Python's own words must do."""
    told = error_in_words(error)
    return next((sentence for part, sentence in SAID if part in told), "")


def error_in_words(error: BaseException) -> str:
    """The kind and the text of an error of the learner's; the text may itself fail."""
    try:
        return f"{type(error).__name__}: {error}"
    except Exception:
        return type(error).__name__


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
    if (
        callable(answer)
        and type(answer).__module__.partition(".")[0] in ("builtins", "numpy")
        and not isinstance(answer, type)
    ):
        return "a function that was not called: put () behind it, with what it is to work on"
    return kinds.get(type(answer)) or f"a {type(answer).__name__}"


def figures(number: float) -> str:
    """A number with four figures, and large ones in thousands."""
    if abs(number) < 1e-9:  # what is left of a difference is no number to tell
        return "0"
    return f"{number:,.0f}" if 1e4 <= abs(number) < 1e12 else f"{number:.4g}"


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
        return figures(float(array.ravel()[0]))
    return "(" + ", ".join(figures(v) for v in array.ravel()) + ")" if array.size <= 4 else f"an array {array.shape}"

"""What to say of an error that stops a learner's cell: one plain sentence below what Python says itself."""

from __future__ import annotations

from types import TracebackType
from typing import Any

from stereo_lab.errors import StereoLabError
from stereo_lab.exercises.language import translated
from stereo_lab.exercises.wording import meaning_of

# What lessons take from a module; dist or gamma is rather a name of the learner's own
OF_MATH = {"pi", "sin", "cos", "tan", "asin", "acos", "atan", "atan2", "sqrt", "hypot", "degrees", "radians"}


def explain_stops() -> None:
    """From here on, below the error of a cell, say what it means, where that is known. Outside a notebook nothing is done."""
    from IPython.core.getipython import get_ipython

    shell = get_ipython()
    if shell is not None:
        shell.set_custom_exc((Exception,), _say)


def _say(
    shell: Any, kind: type[Exception], error: Exception, trace: TracebackType, tb_offset: int | None = None
) -> None:
    shell.showtraceback((kind, error, trace), tb_offset=tb_offset)
    if meaning := _meaning(error):
        print(translated(f"That means: {meaning}"))


def _meaning(error: Exception) -> str:
    """What an error of a cell means; "" where Python's own words, or the kit's, must do."""
    if isinstance(error, StereoLabError):
        return ""
    known = meaning_of(error).replace("above your function", "in a cell above")
    known = known.replace("yet: write", "yet. Run the cells above this one first. Where none of them imports it, write")
    if known or not isinstance(error, NameError) or isinstance(error, UnboundLocalError):
        return known
    name = error.name or "this name"
    if name in OF_MATH:
        return f"{name} has to be taken from a module first: from math import {name}"
    return f"Python knows no {name} here. A word goes in quotes. A name is spelled as in the cells above, and they have to be run first."

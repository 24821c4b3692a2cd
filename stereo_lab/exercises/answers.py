"""Kinds of answers: a number (or several), a choice, a function, a command. Each says PASS or why not yet."""

from __future__ import annotations

import warnings
from typing import Any

from stereo_lab.exercises.blank import is_blank
from stereo_lab.exercises.choice import Choice
from stereo_lab.exercises.command import Command
from stereo_lab.exercises.function import Function
from stereo_lab.exercises.number import Number
from stereo_lab.exercises.verdict import NOT_ATTEMPTED, NOT_YET, PASS, Verdict, Wrong
from stereo_lab.exercises.wording import error_in_words

__all__ = [
    "NOT_ATTEMPTED",
    "NOT_YET",
    "PASS",
    "Choice",
    "Command",
    "Function",
    "Number",
    "Verdict",
    "Wrong",
    "judge",
]


def judge(kind: Number | Choice | Function | Command, answer: Any) -> Verdict:
    """The verdict on any answer; never raises, unless the learner stops it."""
    try:
        if is_blank(answer) or (type(answer) is str and not answer.strip()):
            return Verdict(NOT_ATTEMPTED)
        if answer is None:
            return Verdict(NOT_YET, "there is nothing in it yet: None. A line that prints gives nothing back.")
        with warnings.catch_warnings():
            warnings.simplefilter(
                "ignore", RuntimeWarning
            )  # of numbers, as of an empty mean: they would stand beside what is said
            return kind.judge(answer)
    except KeyboardInterrupt:
        raise
    except BaseException as error:
        return Verdict(NOT_YET, f"the answer could not be looked at ({error_in_words(error)}).")

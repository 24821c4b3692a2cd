"""What a notebook told, as marks and notes for the table."""

from __future__ import annotations

import re

from stereo_lab.classroom.hearing import Heard
from stereo_lab.classroom.marks import Mark
from stereo_lab.classroom.papers import Paper
from stereo_lab.exercises.answers import NOT_ATTEMPTED, NOT_YET

MOST_STOPS = 5  # cells of a notebook of which the table tells what they stopped with


def marks_of(paper: Paper, code: list[str], heard: Heard, count: int) -> tuple[Mark, ...]:
    """A mark for each question; one that was never heard of, though its cell is there, says what stopped it."""
    marks = []
    for number in range(1, count + 1):
        answer, cells = heard.answers.get(number), [k for k, source in enumerate(code) if f"q{number}.check(" in source]
        told = _help(heard, paper.help.get(number, {}), number)
        if answer is None or (answer.verdict.status == NOT_ATTEMPTED and any(k in heard.stopped for k in cells)):
            stopped = [heard.stopped[k] for k in cells if k in heard.stopped]
            why = f"its cell stops: {stopped[-1]}" if stopped else ""
            marks.append(Mark(NOT_YET if stopped else NOT_ATTEMPTED, why, told))
            continue
        several = f"{answer.given} answers were given, the last one counts" if answer.given > 1 else ""
        why = answer.verdict.text if answer.verdict.status == NOT_YET else ""
        why = _further_down(why, code[max(cells, default=0) + 1 :]) or why
        marks.append(Mark(answer.verdict.status, why, ", ".join(filter(None, (told, several)))))
    return tuple(marks)


def stops_of(stopped: dict[int, str]) -> list[str]:
    """What cells stopped with, of the first few."""
    told = [f"{why} (cell {k + 1})" for k, why in sorted(stopped.items())]
    more = len(told) - MOST_STOPS
    return told[:MOST_STOPS] + ([f"{more} more cells stop"] if more > 0 else [])


def _further_down(why, below):
    """What to say where a function calls one that a cell below defines: in the learner's kernel it was there from an earlier run."""
    found = re.search(r"NameError: name '(\w+)' is not defined", why)
    sets = found and re.compile(rf"^(def {found.group(1)}\b|{found.group(1)}\s*=(?!=))", re.MULTILINE)
    if not sets or not any(sets.search(source) for source in below):
        return ""
    return f"{found.group(1)} is defined further down: run from top to bottom, it is not there yet."


def _help(heard, noted, number):
    """Hints and solutions that were used, as the notebook calls them now or the learner's computer has noted."""
    used = {what: max(heard.help.get((number, what), 0), noted.get(what, 0)) for what in ("hint", "solution")}
    hints = f"{used['hint']} hint{'s' * (used['hint'] > 1)}" if used["hint"] else ""
    return ", ".join(filter(None, (hints, "solution seen" if used["solution"] else "")))

"""What a notebook told, as marks and notes for the table."""

from __future__ import annotations

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
        marks.append(Mark(answer.verdict.status, why, ", ".join(filter(None, (told, several)))))
    return tuple(marks)


def stops_of(stopped: dict[int, str]) -> list[str]:
    """What cells stopped with, of the first few."""
    told = [f"{why} (cell {k + 1})" for k, why in sorted(stopped.items())]
    more = len(told) - MOST_STOPS
    return told[:MOST_STOPS] + ([f"{more} more cells stop"] if more > 0 else [])


def _help(heard, noted, number):
    """Hints and solutions that were used, as the notebook calls them now or the learner's computer has noted."""
    used = {what: max(heard.help.get((number, what), 0), noted.get(what, 0)) for what in ("hint", "solution")}
    hints = f"{used['hint']} hint{'s' * (used['hint'] > 1)}" if used["hint"] else ""
    return ", ".join(filter(None, (hints, "solution seen" if used["solution"] else "")))

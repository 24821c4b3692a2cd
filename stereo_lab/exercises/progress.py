"""Which questions are passed, and with how much help: two small files in the learner's own folder."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from stereo_lab.common.files import read_json, write_json
from stereo_lab.errors import StereoLabError
from stereo_lab.work import own_folder

FILE = "progress.json"
HELP = "help.json"


def passed(lesson: str, number: int) -> int:
    """Note that a question is passed; returns how many of its lesson are. A full disk stops nobody."""
    known = load()
    done = {*known.get(lesson, []), number}
    try:
        write_json(_path(), {**known, lesson: sorted(done)})
    except StereoLabError:
        pass
    return len(done)


def helped(lesson: str, number: int, what: str, times: int) -> None:
    """Note how many hints ("hint") were taken to a question, or that its solution was seen ("solution"). A full disk stops nobody."""
    known = help_taken()
    mine = known.setdefault(lesson, {}).setdefault(str(number), {})
    mine[what] = max(mine.get(what, 0), times)
    try:
        write_json(own_folder() / HELP, known)
    except StereoLabError:
        pass


def help_taken(folder: Path | None = None) -> dict[str, dict[str, dict[str, int]]]:
    """``{lesson: {number: {"hint": 2, "solution": 1}}}`` of a work folder; what cannot be read is left out."""
    try:
        known = read_json((folder or own_folder()) / HELP)
    except StereoLabError:
        return {}
    return {
        lesson: {
            number: {w: n for w, n in used.items() if type(n) is int}
            for number, used in its.items()
            if isinstance(used, dict)
        }
        for lesson, its in known.items()
        if isinstance(its, dict)
    }


def load() -> dict[str, list[int]]:
    """``{lesson: [numbers passed]}``; what cannot be read, or is no number, is left out."""
    try:
        known = read_json(_path())
    except StereoLabError:
        return {}
    return merged(known)


def merged(*known: dict[str, Any]) -> dict[str, list[int]]:
    """What is passed in one of several files; what is no list of numbers is left out."""
    told = [(lesson, numbers) for each in known for lesson, numbers in each.items() if isinstance(numbers, list)]
    together: dict[str, set[int]] = {}
    for lesson, numbers in told:
        together.setdefault(lesson, set()).update(n for n in numbers if isinstance(n, int))
    return {lesson: sorted(numbers) for lesson, numbers in together.items()}


def _path():
    return own_folder() / FILE

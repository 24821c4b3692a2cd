"""Handing in: one file under a code name, with what was written and nothing else of the learner's."""

from __future__ import annotations

import json
import re
import secrets
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from stereo_lab.classroom.papers import MOST_TOGETHER, WHEN
from stereo_lab.common.files import read_bytes, read_json, read_text, write_json, write_whole
from stereo_lab.errors import StereoLabError
from stereo_lab.exercises.progress import help_taken
from stereo_lab.work import KEY, MARK, clean, copies_of, digest_of, find

FILE = "code_name.json"
LONGEST_NAMES = 120  # letters, of all names in that of a file
FIRST = "amber brave calm clever eager fair gentle green happy keen kind lucky merry mild neat proud quick quiet rapid silver sunny swift tidy warm"
SECOND = "badger beaver crane dolphin eagle falcon finch fox gull hare heron ibis lark lynx marten mole otter owl panda puffin robin seal stork tern"


@dataclass(frozen=True)
class HandedIn:
    """What was written.

    Attributes
    ----------
    path : Path
    learners : tuple of str, code names
    saved : str, when the notebook was last saved
    answered : int, questions whose blank is filled
    questions : int
    """

    path: Path
    learners: tuple[str, ...]
    saved: str
    answered: int
    questions: int


def code_name(folder: Path, chosen: str | None = None) -> str:
    """The code name of a work folder; it is made once, by chance, or is the one that somebody chooses.

    Two learners of one name would be one row. Of half a million names, two of thirty learners get the same in one class of a thousand.

    Raises
    ------
    StereoLabError
        If the chosen one is no name of letters, figures and -, or cannot be written down.
    """
    path = folder / FILE
    if chosen is None and path.exists():
        known = read_json(path).get("code_name")
        if isinstance(known, str) and _is_name(known):
            return known
    by_chance = f"{secrets.choice(FIRST.split())}-{secrets.choice(SECOND.split())}-{secrets.randbelow(900) + 100}"
    name = _name(by_chance if chosen is None else chosen)
    write_json(path, {"code_name": name})
    return name


def hand_in(
    lessons: Path,
    folder: Path,
    lesson: str,
    out: Path,
    others: Sequence[str] = (),
    chosen: str | None = None,
    command: Callable[[str], str] = "stereo-lab {}".format,
) -> HandedIn:
    """Write one lesson of a work folder as a file for the teacher.

    Outputs and whatever else an editor wrote into the notebook stay here: they may tell whose computer it is.

    Parameters
    ----------
    lessons : Path, the kit's own notebooks
    folder : Path, the work folder
    lesson : str, such as "02"
    out : Path, the folder to write into
    others : sequence of str, the code names of those who worked on it as well
    chosen : str, optional, a code name instead of the folder's own
    command : callable, makes of "reset 03" what somebody types to do that in this folder

    Raises
    ------
    StereoLabError
        If there is no such lesson, it has not been begun in this folder or cannot be read, or a name is none.
    """
    source = folder / find(lessons, lesson).name
    if not source.is_file() or not (folder / MARK).is_file():
        raise StereoLabError(
            f"Lesson {lesson} is not in {folder}. Begin it with: {command(f'start {source.name[:2]}')}"
        )
    number = source.name[:2]
    content, with_me = _content(source, command), tuple(map(_name, others))  # before the folder's own name changes
    if len(with_me) >= MOST_TOGETHER:
        raise StereoLabError(f"A notebook is that of {MOST_TOGETHER} learners at most, got {len(with_me) + 1}.")
    names = tuple(dict.fromkeys((code_name(folder, chosen), *with_me)))
    now = time.localtime()
    told: dict[str, Any] = {"lesson": number, "learners": list(names), "handed_in": time.strftime(WHEN, now)}
    told["help"] = help_taken(folder).get(number, {})
    told["seat"] = _seat(content)
    content["metadata"] = {"kernelspec": content["metadata"].get("kernelspec", {}), KEY: told}
    whose = "_".join(names) if sum(map(len, names)) < LONGEST_NAMES else f"{names[0]}_and-{len(names) - 1}-more"
    path = out / f"{number}_{whose}_{time.strftime('%Y-%m-%d_%H-%M-%S', now)}.ipynb"
    write_whole(path, json.dumps(content, indent=1, ensure_ascii=False) + "\n")
    code = [cell["source"] for cell in content["cells"] if cell["cell_type"] == "code" and ".check(" in cell["source"]]
    saved = time.strftime("%Y-%m-%d %H:%M", time.localtime(source.stat().st_mtime))
    return HandedIn(path, names, saved, sum("____" not in lines for lines in code), len(code))


def seat_of_lesson(path: Path) -> int | None:
    """The seat whose numbers stand in a notebook; None where it has those of the class, or cannot be read.

    One that was begun before its folder got a seat keeps the numbers that it had.
    """
    try:
        return _seat(_content(path))
    except StereoLabError:
        return None


def begun(folder: Path) -> list[str]:
    """The lessons of a work folder in which somebody has worked, by the names of their notebooks."""
    copies = copies_of(folder).items()
    notebooks = [(folder / name, digest) for name, digest in sorted(copies) if name.endswith(".ipynb")]
    return [path.name for path, digest in notebooks if path.is_file() and digest_of(read_bytes(path)) != digest]


def _seat(content):
    told = content["metadata"].get(KEY)
    seat = told.get("seat") if isinstance(told, dict) else None
    return seat if type(seat) is int else None


def _content(source, command="stereo-lab {}".format):
    """The cells as they were written, without outputs and without what editors add."""
    try:
        notebook = clean(json.loads(read_text(source)))
        cells = [_cell(cell) for cell in notebook["cells"]]
        return {"cells": cells, "metadata": dict(notebook.get("metadata", {})), "nbformat": 4, "nbformat_minor": 5}
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
        raise StereoLabError(
            f"{source} cannot be read as a notebook. Open it in JupyterLab and save it, or begin it anew with: {command(f'reset {source.name[:2]}')}"
        ) from None


def _cell(cell):
    source = cell["source"]
    kept = {
        "cell_type": cell["cell_type"],
        "metadata": {},
        "source": source if isinstance(source, str) else "".join(source),
    }
    if "id" in cell:
        kept["id"] = cell["id"]
    return {**kept, "outputs": [], "execution_count": None} if cell["cell_type"] == "code" else kept


def _is_name(name):
    return bool(re.fullmatch(r"[A-Za-z0-9-]{1,40}", name))


def _name(name):
    if not _is_name(name):
        raise StereoLabError(f"A code name of 1 to 40 of the letters a to z, figures and - is expected, got {name!r}.")
    return name

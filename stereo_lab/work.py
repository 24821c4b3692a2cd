"""The learner's own folder: clean copies of the lessons, what the learner wrote, how far they are.

It is made once. What is in it belongs to the learner: a newer kit writes over nothing there that was changed.
"""

from __future__ import annotations

import hashlib
import json
import os
import re
import time
from pathlib import Path
from typing import Any

from stereo_lab.common.files import read_bytes, read_json, read_text, user_folder, write_json, write_whole
from stereo_lab.errors import StereoLabError

KEY = "stereo_lab_hand_in"  # in a notebook's metadata: whose it is and from which seat, as far as that is known
MARK = ".stereo_lab.json"  # the file that makes a folder a work folder: which copy was made from what
# The end of a name, without its ending, that keep_beside gave
KEPT_BESIDE = re.compile(r"_\d{4}-\d\d-\d\d_\d\d-\d\d(_\d+)?$")
SEAT = "seat"  # the folder of a recording of the learner's own
PAGES = ("words.md",)  # what goes with the lessons


def own_folder() -> Path:
    """Where the answers and the progress of whoever runs this lie.

    The work folder that $STEREO_LAB_WORK names; else the one in which the program runs; else the user's data folder.
    """
    named = os.environ.get("STEREO_LAB_WORK")
    if named:
        return Path(named)
    here = Path.cwd()
    return next((folder for folder in (here, *here.parents) if (folder / MARK).is_file()), user_folder())


def chosen_language() -> str:
    """What $STEREO_LAB_LANGUAGE chooses: a short name such as "de", or the whole path of a language's folder; empty for English."""
    named = os.environ.get("STEREO_LAB_LANGUAGE", "").strip()
    return named if named != "en" and (named.replace("-", "").isalnum() or Path(named).is_absolute()) else ""


def lay_out(lessons: Path, folder: Path) -> tuple[list[str], list[str]]:
    """Put a clean copy of each lesson that is missing into a work folder.

    A copy that nobody has changed is made anew where the kit's lesson has changed. One that was changed stays.

    Parameters
    ----------
    lessons : path, the folder of the kit's own notebooks
    folder : path, made where there is none

    Returns
    -------
    made, older : list of str
        Names of the copies made now, and of those that stay though the kit has a newer lesson.

    Raises
    ------
    StereoLabError
        If a lesson cannot be read, or a copy cannot be written.
    """
    known, made, older = copies_of(folder), [], []
    copies = dict(known)
    for source in _sources(lessons):
        target, fresh = folder / source.name, _clean_copy(source, seat_of(folder))
        had = digest_of(read_bytes(target)) if target.exists() else None
        if had is not None and had not in (copies.get(source.name), digest_of(fresh)):  # somebody has changed it
            if copies.get(source.name) != digest_of(fresh):
                older.append(source.name)
            continue
        if had != digest_of(fresh):
            write_whole(target, fresh)
            made.append(source.name)
        copies[source.name] = digest_of(fresh)
    if (
        copies != known or not (folder / MARK).is_file()
    ):  # on a full disk what is laid out already is opened all the same
        mark(folder, copies)
    return made, older


def reset(lessons: Path, folder: Path, lesson: str) -> tuple[Path, Path | None]:
    """A fresh copy of one lesson. The old one is kept beside it, with the time in its name.

    Parameters
    ----------
    lessons, folder : path, as for :func:`lay_out`
    lesson : str, such as "03"

    Returns
    -------
    fresh, kept : path, and path or None where there was no old one

    Raises
    ------
    StereoLabError
        If there is no such lesson, or the folder cannot be written to.
    """
    source = find(lessons, lesson)
    target = folder / source.name
    fresh = _clean_copy(source, seat_of(folder))
    new = target.with_suffix(".new")
    write_whole(new, fresh)  # a full disk is told before the old one is moved away
    kept = keep_beside(target) if target.exists() else None
    new.replace(target)
    mark(folder, {**copies_of(folder), source.name: digest_of(fresh)})
    return target, kept


def seat_of(folder: Path) -> int | None:
    """Whose recording lies in a work folder, by the number of the seat; None where there is none."""
    try:
        seat = read_json(folder / SEAT / "recording.json").get("seat")
    except StereoLabError:
        return None
    return seat if type(seat) is int and 0 <= seat <= 9999 else None


def find(lessons: Path, lesson: str) -> Path:
    """The kit's notebook of a lesson, by its number.

    Raises
    ------
    StereoLabError
        If there is none.
    """
    notebooks = [path for path in _sources(lessons) if path.suffix == ".ipynb"]
    for path in notebooks:
        if lesson.isdecimal() and path.name.startswith(lesson.zfill(2) + "_"):
            return path
    numbers = ", ".join(path.name[:2] for path in notebooks)
    raise StereoLabError(f"There is no lesson {lesson!r}. Lessons: {numbers}.")


def clean(notebook: dict[str, Any]) -> dict[str, Any]:
    """A notebook without its outputs, so that nobody reads the answer to a *predict* before they ran the cell."""
    cells = [
        {**cell, "outputs": [], "execution_count": None} if cell["cell_type"] == "code" else cell
        for cell in notebook["cells"]
    ]
    return {**notebook, "cells": cells}


def _sources(lessons):
    """The kit's lessons and what goes with them."""
    notebooks = sorted(lessons.glob("[0-9][0-9]_*.ipynb"))
    if not notebooks:
        raise StereoLabError(
            f"Expected the lessons in {lessons}; there are none. Get the kit whole, as its page shows."
        )
    found = [*notebooks, *(lessons / name for name in PAGES)]
    translated = [lessons / chosen_language() / path.name for path in found]
    return [other if other.is_file() else path for path, other in zip(found, translated, strict=True)]


def _clean_copy(source, seat):
    """What a learner gets of a lesson or a page; at a seat, with that seat's numbers."""
    text = read_text(source)
    if source.suffix == ".ipynb":
        notebook = clean(json.loads(text))
        if seat is not None:
            from stereo_lab.exercises.seats import reworded

            told = [{**cell, "source": reworded("".join(cell["source"]), seat)} for cell in notebook["cells"]]
            metadata = {
                **notebook["metadata"],
                KEY: {"seat": seat},
            }  # also a plain copy is marked by its seat's numbers
            notebook = {**notebook, "cells": told, "metadata": metadata}
        text = json.dumps(notebook, indent=1, ensure_ascii=False) + "\n"
    return text.encode("utf-8")


def copies_of(folder: Path) -> dict[str, str]:
    """Which copies were made, each with the digest that it had; none where the mark is lost or cannot be read."""
    try:
        return as_copies(read_json(folder / MARK))
    except StereoLabError:
        return {}


def as_copies(marked: dict[str, Any]) -> dict[str, str]:
    """The same, out of the content of a mark; what is no name with a digest is left out."""
    copies = marked.get("copies")
    if not isinstance(copies, dict):
        return {}
    return {name: digest for name, digest in copies.items() if isinstance(digest, str)}


def mark(folder: Path, copies: dict[str, str]) -> None:
    """Write down which copies were made, each with the digest that it had."""
    write_json(folder / MARK, {"format": 1, "copies": copies})


def digest_of(content: bytes) -> str:
    """What tells whether a copy was changed."""
    return hashlib.sha256(content).hexdigest()


def keep_beside(path: Path) -> Path:
    """Rename a file so that its name has the time in it; gives the new name.

    Raises
    ------
    StereoLabError
        If it cannot be renamed.
    """
    stem = f"{path.stem}_{time.strftime('%Y-%m-%d_%H-%M')}"
    names = (path.with_name(f"{stem}{more}{path.suffix}") for more in ("", *(f"_{k}" for k in range(2, 1000))))
    kept = next(name for name in names if not name.exists())
    try:
        path.rename(kept)
    except OSError as error:
        raise StereoLabError(
            f"Cannot rename {path}: {error.strerror}. Close it elsewhere, and look at the folder's permissions."
        ) from None
    return kept

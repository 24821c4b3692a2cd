"""The learner's own folder: clean copies of the lessons, what the learner wrote, how far they are.

It is made once. What is in it belongs to the learner: a newer kit writes over nothing there that was changed.
"""

from __future__ import annotations

import hashlib
import json
import os
import time
from pathlib import Path
from typing import Any

from stereo_lab.common.files import read_bytes, read_json, read_text, user_folder, write_json, write_whole
from stereo_lab.errors import StereoLabError

MARK = ".stereo_lab.json"  # the file that makes a folder a work folder: which copy was made from what
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
    copies, made, older = _copies(folder), [], []
    for source in _sources(lessons):
        target, fresh = folder / source.name, _clean_copy(source)
        had = _digest(read_bytes(target)) if target.exists() else None
        if had is not None and had not in (copies.get(source.name), _digest(fresh)):  # somebody has changed it
            if copies.get(source.name) != _digest(fresh):
                older.append(source.name)
            continue
        if had != _digest(fresh):
            write_whole(target, fresh)
            made.append(source.name)
        copies[source.name] = _digest(fresh)
    _mark(folder, copies)
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
    target, kept = folder / source.name, None
    if target.exists():
        kept = _free_name(folder, f"{source.stem}_{time.strftime('%Y-%m-%d_%H-%M')}", source.suffix)
        try:
            target.rename(kept)
        except OSError as error:
            raise StereoLabError(
                f"Cannot rename {target}: {error.strerror}. Close it elsewhere, and look at the folder's permissions."
            ) from None
    fresh = _clean_copy(source)
    write_whole(target, fresh)
    _mark(folder, {**_copies(folder), source.name: _digest(fresh)})
    return target, kept


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
    return [*notebooks, *(lessons / name for name in PAGES)]


def _clean_copy(source):
    """What a learner gets of a lesson or a page."""
    text = read_text(source)
    if source.suffix == ".ipynb":
        text = json.dumps(clean(json.loads(text)), indent=1, ensure_ascii=False) + "\n"
    return text.encode("utf-8")


def _copies(folder):
    """Which copies were made, each with the digest that it had; none where the mark is lost or cannot be read."""
    try:
        copies = read_json(folder / MARK).get("copies")
    except StereoLabError:
        return {}
    return (
        {name: digest for name, digest in copies.items() if isinstance(digest, str)} if isinstance(copies, dict) else {}
    )


def _mark(folder, copies):
    write_json(folder / MARK, {"format": 1, "copies": copies})


def _digest(content):
    return hashlib.sha256(content).hexdigest()


def _free_name(folder, stem, suffix):
    """A name in a folder that nothing has yet."""
    names = (folder / f"{stem}{more}{suffix}" for more in ("", *(f"_{k}" for k in range(2, 1000))))
    return next(name for name in names if not name.exists())

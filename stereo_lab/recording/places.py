"""Where the course lies: its lessons, its recordings. Nobody else knows."""

from __future__ import annotations

import os
from pathlib import Path

from stereo_lab.errors import StereoLabError

PACKAGE = Path(__file__).resolve().parent.parent
REPOSITORY = PACKAGE.parent
DATA = "STEREO_LAB_DATA"  # a folder of recordings: a teacher's, or one that thirty share


def is_repository() -> bool:
    """Whether the kit runs out of its own folder, and not as an installed package."""
    return (REPOSITORY / "lab.py").is_file()


def course() -> Path:
    """The folder that holds ``notebooks``, ``data`` and ``environment.txt``; setup.py puts it into a wheel."""
    return REPOSITORY if is_repository() else PACKAGE / "course"


def shelves() -> list[Path]:
    """Folders in which a recording is looked for by its name: the one that $STEREO_LAB_DATA names, then the kit's own."""
    named = os.environ.get(DATA)
    return [*([Path(named)] if named else []), course() / "data"]


def known() -> list[str]:
    """Names of the recordings that lie on the shelves."""
    return sorted({path.parent.name for shelf in shelves() for path in shelf.glob("*/recording.json")})


def check_name(out: str | Path) -> None:
    """Refuse a name for a new recording that is found by it already: in this folder it would hide the other one.

    Raises
    ------
    StereoLabError
        If it is that of a recording on a shelf.
    """
    if Path(out).parent == Path() and Path(out).name in known():
        raise StereoLabError(
            f"{out} is the name of a recording that is there already, and would be found in its place. Name another folder, such as my_{Path(out).name}."
        )


def check_shelves() -> None:
    """Refuse to go on without any recording.

    Raises
    ------
    StereoLabError
        If none is found; it says where to get them.
    """
    named = os.environ.get(DATA)
    if named and not any(Path(named).glob("*/recording.json")):
        raise StereoLabError(
            f"There is no recording in {Path(named).absolute()}. Name the folder that holds them, such as the folder data of the kit."
        )
    if not known():
        raise StereoLabError(
            "The recordings are not here: copy the folder data of the kit, or ask your teacher where it lies, and name it with "
            f"--data FOLDER or the environment variable {DATA}."
        )

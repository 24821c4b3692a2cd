"""What lies in a recording's folder under a name that nobody looks for: Left, postion, measured.xlsx, 004.HEIC."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Iterator
from difflib import get_close_matches
from pathlib import Path

from stereo_lab.common.files import read_json
from stereo_lab.errors import StereoLabError
from stereo_lab.recording.pictures import PICTURES

SETS = "calibration", "position", "depth", "evaluation", "snaps", "track", "still"
SIDES = "left", "right"
TABLE = "measured.csv"
CALIBRATION, KEY = "calibration.json", re.compile("[0-9a-f]{24}")  # of the pictures that one was made from
ALIKE = 0.75  # of their letters: "postion" for "position", "Lefts" for "left"
OTHER_PICTURES = ".heic", ".heif", ".avif", ".webp", ".bmp", ".tif", ".tiff", ".gif", ".raw", ".dng"


def strays(folder: Path) -> list[str]:
    """A sentence for everything in a recording that seems to be meant and is not read, with the name that would be.

    Parameters
    ----------
    folder : Path, the recording's

    Returns
    -------
    list of str
    """
    return list(dict.fromkeys(_strays(folder)))


def told_of_strays(folder: Path, about: Path | None = None) -> str:
    """The first of :func:`strays` with a space before it, to end a sentence on what is missing; empty where there are none.

    A calibration without its boards is one of them here. ``about``: the folder of what is missing; what lies in it is told first.
    """
    bereft = folder / CALIBRATION
    alone = [
        f"{bereft} counts only beside the boards that it was made of, and they are not here: put the folder calibration back."
    ]
    found = [*strays(folder), *(alone if is_bereft(bereft) else [])]
    if about is not None:
        found.sort(key=lambda sentence: f"{about}{os.sep}" not in sentence)
    return "".join(f" {sentence}" for sentence in found[:1])


def other_pictures_in(folder: Path) -> list[Path]:
    """Files of a folder that are pictures of kinds that a recording does not have."""
    return [path for path in _files(folder) if path.suffix.lower() in OTHER_PICTURES]


def is_bereft(calibration: Path) -> bool:
    """Whether a calibration is there that was made of boards, and these are not: whether it is theirs still, nobody can tell."""
    if not calibration.is_file() or (calibration.parent / "calibration" / "left").is_dir():
        return False
    try:
        return bool(KEY.fullmatch(str(read_json(calibration).get("made_from"))))
    except StereoLabError:  # told where it is used
        return False


def _strays(folder: Path) -> Iterator[str]:
    for inside in _folders(folder):
        named = folder / _meant(inside.name, SETS) if _meant(inside.name, SETS) else inside
        if named != inside and not named.exists() and any(_meant(sub.name, SIDES) for sub in _folders(inside)):
            yield f"The folder {inside} is not read. Should its name be {named.name}?"
        for sub in _folders(inside):
            side = _meant(sub.name, SIDES)
            if side and sub.name != side and not (inside / side).exists():
                yield f"The folder {sub} is not read. Should its name be {side}?"
            if side and (lost := other_pictures_in(sub)):
                more = f" (nor are {len(lost) - 1} more)" if len(lost) > 1 else ""
                yield f"{lost[0]} is not read{more}: pictures end in {', '.join(PICTURES[:-1])} or {PICTURES[-1]}. Save them so."
        if not (inside / TABLE).is_file() and any(_meant(sub.name, SIDES) for sub in _folders(inside)):
            for file in _files(inside):
                if _meant(file.name.split(".")[0], (Path(TABLE).stem,)):
                    yield f"{file} is not read. Save the table as {TABLE}, with commas between the numbers."


def _meant(name: str, known: Iterable[str]) -> str:
    """Of some names the one that another name seems to mean; empty where none."""
    close = get_close_matches(name.strip().casefold(), known, 1, ALIKE)
    return close[0] if close else ""


def _folders(folder):
    return sorted(path for path in folder.iterdir() if path.is_dir() and not path.name.startswith("."))


def _files(folder):
    return sorted(path for path in folder.iterdir() if path.is_file() and not path.name.startswith("."))

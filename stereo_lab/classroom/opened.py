"""Which recording a notebook opens, where it names one: open_recording("second_rig") in its first cell."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Sequence
from pathlib import Path

from stereo_lab.recording import Recording
from stereo_lab.recording.places import shelves

OPENS = re.compile(r"""^(\s*recording\s*=[^#\n]*?\bopen_recording)\(\s*r?["']([^"'\n]+)["']\s*\)""", re.MULTILINE)
ASKS = re.compile(r"(?<!\w)questions\(")
ON_A_SHELF = re.compile(r"(?:data[\\/]+)?([\w-]+)[\\/]?")  # its name, or where it lies in the kit


def opened(code: Sequence[str]) -> str:
    """What the notebook's questions are asked for, as it says it; "" where it opens what the class does."""
    found = OPENS.findall(ASKS.split("\n".join(code), maxsplit=1)[0])
    return found[-1][1] if found else ""


def name_of(told: str) -> str:
    """The last part of a path, on any system."""
    return re.split(r"[\\/]", told.rstrip("\\/"))[-1]


def on_a_shelf(told: str) -> Path | None:
    """The folder of a recording that is found by its name; None where it is none of these."""
    found = ON_A_SHELF.fullmatch(told)
    folders = [shelf / found.group(1) for shelf in shelves()] if found else []
    return next((folder.resolve() for folder in folders if (folder / "recording.json").is_file()), None)


def opens_what_it_gets(code: Sequence[str]) -> list[str]:
    """The code with no name in it, up to the questions: in the room it then opens what it is judged by."""
    asking = next((k for k, source in enumerate(code) if ASKS.search(source)), -1)
    return [OPENS.sub(r"\1()", source) if k <= asking else source for k, source in enumerate(code)]


def digest_of(recording: Recording) -> str:
    """What tells a recording from another one, and from itself with other tables in it."""
    whole = hashlib.sha256(str(recording.path).encode())
    for file in sorted(path for path in recording.path.rglob("*") if path.is_file()):
        whole.update(f"{file.name} {file.stat().st_size}".encode())  # a picture's size tells it from another
        if file.suffix in (".json", ".csv"):
            whole.update(file.read_bytes())
    return whole.hexdigest()

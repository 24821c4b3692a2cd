"""Where the ball truly is: the renderer's truth.json, read with care."""

from __future__ import annotations

import reprlib
from pathlib import Path
from typing import Any

from stereo_lab.common.files import check_format, finite_number, read_json
from stereo_lab.errors import RecordingError
from stereo_lab.recording.bounds import place_mm

PLACES = {"ball": place_mm, "left": finite_number, "right": finite_number}  # what three numbers each hold


def read_truth(path: Path) -> dict[str, Any]:
    """Content of truth.json; an empty dictionary where there is no such file.

    Raises
    ------
    StereoLabError
        If the file cannot be used.
    """
    if not path.exists():
        return {}
    truth = read_json(path)
    if "format" in truth:
        check_format(truth, path)
    for set_name, frames in _object(truth.get("sets", {}), f"{path}, sets").items():
        for name, entry in _object(frames, f"{path}, {set_name}").items():
            _check_entry(_object(entry, f"{path}, {set_name}/{name}"), f"{path}, {set_name}/{name}")
    return truth


def _object(value, where):
    if not isinstance(value, dict):
        raise RecordingError(f"{where}: expected an object in braces {{…}}, got {reprlib.repr(value)}.")
    return value


def _check_entry(entry, where):
    """Three numbers for the ball and for each picture; null where there is no ball."""
    for key, check in PLACES.items():
        value = entry.get(key)
        if value is None:
            continue
        if not isinstance(value, list) or len(value) != 3:
            raise RecordingError(f"{where}, {key}: expected three numbers, got {reprlib.repr(value)}.")
        for number in value:
            check(number, f"{where}, {key}")

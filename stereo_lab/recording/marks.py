"""Pictures in which a ball is marked: where they come from, and the table of marks."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Mapping
from pathlib import Path

import numpy as np

from stereo_lab.common.files import finite_number, write_whole
from stereo_lab.common.spreadsheets import read_table
from stereo_lab.errors import StereoLabError
from stereo_lab.recording.opening import open_recording
from stereo_lab.recording.pictures import without_ending
from stereo_lab.recording.video import count_frames, is_video, read_video

COLUMNS = ("picture", "u", "v", "radius_px")
SHOTS = 60  # pictures of a longer set or film, evenly spaced
Mark = tuple[float, float, float] | None  # (u, v, radius) in px; None: no ball is there


def shots_of(
    source: str | Path | None, set_name: str | None = None, names: Iterable[str] = ()
) -> dict[str, np.ndarray]:
    """The left pictures of a recording's set, or the frames of a film, by their names; 60 of them at most.

    Parameters
    ----------
    source : folder or name of a recording, or a film
    set_name : str, optional; else the set of the recording that shows a ball most often
    names : names of pictures, optional: these, and no others, however many

    Raises
    ------
    StereoLabError
        If there are no such pictures.
    """
    wanted = tuple(names)
    if source is not None and is_video(source):
        return _frames(source, wanted)
    recording = open_recording(source)
    sets = [name for name in recording.ball_sets if name != "calibration"]
    if not sets and set_name is None:
        raise StereoLabError(f"{recording.title} has no pictures of a ball. Take some, or name a film.")
    pairs = {pair.name: pair for pair in recording.pairs(set_name or sets[0])}
    chosen = wanted or tuple(np.array(list(pairs))[_spaced(len(pairs))].tolist())
    _check_there(chosen, pairs, f"{recording.title}, set {set_name or sets[0]}")
    return {name: pairs[name].left for name in chosen}


def _frames(path, wanted):
    """Frames of a film by their numbers."""
    total = count_frames(path)
    numbers = {int(name) for name in wanted if name.isdecimal()} or set(_spaced(total or SHOTS).tolist())
    found = {str(number): frame for number, frame in enumerate(read_video(path)) if number in numbers}
    _check_there(wanted, found, str(path))
    return found


def _spaced(count):
    return np.unique(np.linspace(0, count - 1, min(count, SHOTS)).round().astype(int))


def _check_there(names, there, where):
    lost = [name for name in names if name not in there]
    if lost:
        raise StereoLabError(
            f"{where} has no picture {lost[0]}: the marks are of other pictures. Name the recording or film that was marked."
        )


def read_marks(path: str | Path) -> dict[str, Mark]:
    """Marks by the names of their pictures, from a table picture, u, v, radius_px; where u is empty there is no ball.

    Raises
    ------
    StereoLabError
        If it cannot be read, a number is none, or a picture comes twice.
    """
    marks: dict[str, Mark] = {}
    for where, row in read_table(path, COLUMNS):
        name = without_ending((row["picture"] or "").strip())
        if name in marks:
            raise StereoLabError(f"{where}: picture {name} is marked twice. Only one ball is learned; leave one line.")
        if not (row["u"] or "").strip():
            marks[name] = None
            continue
        u, v, radius = (finite_number(row[k], f"{where}, {k}") for k in COLUMNS[1:])
        marks[name] = (u, v, radius)
    return marks


def write_marks(path: str | Path, marks: Mapping[str, Mark]) -> None:
    """Write what :func:`read_marks` reads, whole or not at all."""
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(COLUMNS)
    for name, mark in marks.items():
        table.writerow([name, *(("", "", "") if mark is None else (f"{value:.2f}" for value in mark))])
    write_whole(path, text.getvalue())

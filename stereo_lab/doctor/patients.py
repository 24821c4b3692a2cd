"""Three recordings with a mistake each, for lesson 08: a learner finds out what is wrong, and puts it right."""

from __future__ import annotations

import json
import tempfile
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

from stereo_lab.doctor.spoiling import spoil
from stereo_lab.recording import Board, Recording, open_recording

HEALTHY = "second_rig"  # whose copies they are
# One that stops everything, one that the calibration does not see, one that a single key does. B's seed chooses a camera that is
# turned sideways after the twelfth pair, so that rows hardly tell.
AILMENTS = {"a": ("squares_counted", 0), "b": ("camera_moved", 1866), "c": ("typing_slip", None)}
# C's seeds choose a line of `depth` each, another one for each seat, and a digit in the middle: one at the end leaves several
# numbers near what the cameras tell. In the first, which is that of no seat, the cameras are 2 mm off.
SLIPS = (5, 0, 10, 2, 18)


@dataclass(frozen=True)
class Healthy:
    """What is right where the patients are not.

    Attributes
    ----------
    board : Board, of patient A
    pairs : int, of patient B's boards
    since : int, its first pair after a camera was moved, counted from 0
    slipped : str, the line of patient C with a digit left out, as "set/name"
    typed_mm, depth_mm : float, what is written there, and what was measured
    """

    board: Board
    pairs: int
    since: int
    slipped: str
    typed_mm: float
    depth_mm: float


def admit(folder: str | Path, seat: int | None = None) -> tuple[Recording, Recording, Recording]:
    """Make three copies of the second rig, each with one mistake that people make.

    Parameters
    ----------
    folder : folder in which "patient_a", "patient_b" and "patient_c" are made
    seat : int, whose patient C it is: neighbours have other slips (``recording.seat``)

    Returns
    -------
    tuple of three Recording

    Raises
    ------
    RecordingError
        If one of them is there already.
    """
    healthy = open_recording(HEALTHY)
    patients = []
    for letter, (fault, seed) in AILMENTS.items():
        where = Path(folder) / f"patient_{letter}"
        spoil(healthy, where, [fault], SLIPS[(seat or 0) % len(SLIPS)] if seed is None else seed)
        _name(where, f"Patient {letter.upper()}")
        patients.append(open_recording(where))
    return patients[0], patients[1], patients[2]


def _name(folder, title):
    path = folder / "recording.json"
    facts = json.loads(path.read_text(encoding="utf-8"))
    path.write_text(json.dumps({**facts, "title": title}, indent=1), encoding="utf-8")


@lru_cache(maxsize=len(SLIPS))
def healthy(seat: int | None = None) -> Healthy:
    """What is right where the patients of :func:`admit` are not: read off where they differ from what they are copies of."""
    good = open_recording(HEALTHY)
    with tempfile.TemporaryDirectory() as folder:
        _, moved, slip = admit(folder, seat)
        boards = list(zip(good.pairs("calibration"), moved.pairs("calibration"), strict=True))
        since = next(k for k, pair in enumerate(boards) if _bytes(pair[0]) != _bytes(pair[1]))
        name, was, typed = next(
            (f"{name}/{was.pair.name}", was.measured.depth_mm, now.measured.depth_mm)
            for name in ("position", "depth")
            for was, now in zip(good.samples(name), slip.samples(name), strict=True)
            if was.measured != now.measured
        )
    return Healthy(good.board, len(boards), since, name, typed, was)


def _bytes(pair):
    return [path.read_bytes() for path in (pair.left_path, pair.right_path)]

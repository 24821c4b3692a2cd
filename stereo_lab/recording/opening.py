"""Opening a recording: its folder found, its recording.json read with care. The format stands in ``data/README.md``."""

from __future__ import annotations

import os
import reprlib
from dataclasses import fields
from pathlib import Path

from stereo_lab.common.files import check_format, read_json
from stereo_lab.errors import RecordingError, StereoLabError
from stereo_lab.kinematics import ArmWeight, TwoLinkArm
from stereo_lab.recording import places
from stereo_lab.recording.bounds import (
    CHARUCO,
    CHESSBOARD,
    COLORS,
    LENGTHS_MM,
    MOST_GRAMS,
    PICTURE_PX,
    PICTURES_A_SECOND,
    TURNS_DEG,
    board_kind,
    color_name,
    corner_count,
    dictionary_name,
    length_mm,
    markers_that_fit,
    number_in,
    plain_name,
    whole_in,
)
from stereo_lab.recording.model import Recording
from stereo_lab.recording.pictures import LARGEST_PICTURE
from stereo_lab.recording.sample import Ball, Board
from stereo_lab.recording.truth import read_truth

__all__ = ["COLORS", "open_recording"]

# What recording.json needs, as it may be written
NEEDED = {
    "image_size": "[640, 480]",
    "board": '{"columns": 9, "rows": 6, "square_mm": 25.0}',
    "columns": "9",
    "rows": "6",
    "square_mm": "25.0",
    "marker_mm": "18.75",
    "dictionary": '"DICT_4X4_50"',
    "ball": '{"color": "red", "diameter_mm": 40.0}',
    "diameter_mm": "40.0",
    "l1_mm": "250",
    "l2_mm": "200",
    "depth_mm": "1000",
}


def open_recording(path: str | Path | None = None) -> Recording:
    """Open a recording.

    Parameters
    ----------
    path : str or path, optional
        A folder, also one that begins with ~, or the name of a shipped recording. None: the environment variable
        STEREO_LAB_RECORDING, and without it the shipped bench.

    Returns
    -------
    Recording

    Raises
    ------
    RecordingError
        If there is no such folder or its recording.json cannot be used, or ``path`` is no path.
    """
    if path is None:
        path = os.environ.get("STEREO_LAB_RECORDING") or "bench"
    if not isinstance(path, str | os.PathLike) or not os.fspath(path):
        raise RecordingError(f"Expected a recording's folder or its name, as in 'bench'; got {reprlib.repr(path)}.")
    folder = _find_folder(os.path.expanduser(path))
    try:
        return _parse(folder, read_json(folder / "recording.json"))
    except RecordingError:
        raise
    except StereoLabError as error:
        raise RecordingError(str(error)) from None


def _find_folder(path):
    """The folder meant by a path or by the name of a shipped recording."""
    if Path(path).name == "recording.json":
        path = Path(path).parent
    for folder in (Path(path), places.course() / path, *(shelf / path for shelf in places.shelves())):
        if (folder / "recording.json").is_file():
            return folder.resolve()
    if Path(path).is_dir():
        raise RecordingError(
            f"{path} has no recording.json in it, so it is no recording. data/README.md shows what goes in."
        )
    if Path(path).is_file():
        raise RecordingError(
            f"{path} is a file, and a recording is a folder: the one that recording.json lies in. A .zip has to be unpacked first."
        )
    places.check_shelves()
    raise RecordingError(
        f"There is no folder {path}. Recordings that are found by their names: {', '.join(places.known())}."
    )


def _parse(folder, facts):
    where = folder / "recording.json"
    check_format(facts, where)
    board, ball = _section(facts, "board", where), _section(facts, "ball", where)
    arm, depth = _parse_arm(facts, where)
    return Recording(
        path=folder,
        title=str(facts.get("title", folder.name)),
        made_by=str(facts.get("made_by", "camera")),
        image_size=_parse_size(facts, where),
        frame_rate=number_in(facts.get("frame_rate", 10), f"{where}, frame_rate", *PICTURES_A_SECOND),
        board=_parse_board(board, where),
        ball=Ball(
            color_name(ball.get("color", "red"), f"{where}, ball color"),
            length_mm(_needed(ball, "diameter_mm", f"{where}, ball"), f"{where}, ball diameter_mm"),
        ),
        arm=arm,
        arm_depth_mm=depth,
        arm_is_shipped="arm" not in facts,
        calibrated_by=_parse_other(facts, where),
        truth=read_truth(folder / "truth.json"),
        seat=whole_in(facts["seat"], f"{where}, seat", 0, 9999) if "seat" in facts else None,
    )


def _parse_board(facts, where):
    """A chessboard, or where it says so a ChArUco board."""
    kind = board_kind(facts.get("kind", CHESSBOARD), f"{where}, board kind")
    charuco = kind == CHARUCO
    told = {key: _needed(facts, key, f"{where}, board") for key in ("columns", "rows", "square_mm")}
    columns, rows = (corner_count(told[way], f"{where}, board {way}", int(charuco)) for way in ("columns", "rows"))
    square = length_mm(told["square_mm"], f"{where}, board square_mm")
    if not charuco:
        return Board(columns, rows, square)
    told = {key: _needed(facts, key, f"{where}, board") for key in ("marker_mm", "dictionary")}
    marker = markers_that_fit(told["marker_mm"], square, f"{where}, board marker_mm")
    dictionary = dictionary_name(told["dictionary"], columns * rows // 2, f"{where}, board dictionary")
    return Board(columns, rows, square, kind, marker, dictionary)


def _parse_size(facts, where):
    """Width and height in pixels."""
    width, height = (whole_in(v, f"{where}, image_size", *PICTURE_PX) for v in _list(facts, "image_size", 2, where))
    if width * height > LARGEST_PICTURE:
        raise RecordingError(
            f"{where}, image_size: expected {LARGEST_PICTURE // 1_000_000} megapixels at most, got {width}x{height}."
        )
    return width, height


def _parse_other(facts, where):
    """The recording beside this one whose boards are used, or None."""
    name = facts.get("calibrated_by")
    return None if name is None else plain_name(name, f"{where}, calibrated_by")


SHIPPED_ARM = {"l1_mm": 250, "l2_mm": 200, "depth_mm": 1000, "theta1_deg": [-165, 165], "theta2_deg": [-155, 155]}


def _parse_arm(facts, where):
    arm = _section(facts, "arm", where) if "arm" in facts else SHIPPED_ARM
    limits = []
    for joint in ("theta1_deg", "theta2_deg"):
        turns = _list(arm, joint, 2, where) if joint in arm else SHIPPED_ARM[joint]
        low, high = (number_in(v, f"{where}, arm {joint}", *TURNS_DEG, "degrees") for v in turns)
        if low >= high:
            raise RecordingError(f"{where}, arm {joint}: expected [low, high] in degrees, got {reprlib.repr(turns)}.")
        limits.append((low, high))
    keys = "l1_mm", "l2_mm", "depth_mm"
    lengths = [length_mm(_needed(arm, key, f"{where}, arm"), f"{where}, arm {key}") for key in keys]
    return TwoLinkArm(*lengths[:2], tuple(limits), _parse_weight(arm, where)), lengths[2]


def _parse_weight(arm, where):
    """Masses and where they sit; what is not told is that of a light build."""
    room = {"g": (0, MOST_GRAMS), "mm": (-LENGTHS_MM[1], LENGTHS_MM[1])}
    told = [part.name for part in fields(ArmWeight) if part.name in arm]
    units = [name.rpartition("_")[2] for name in told]
    sizes = [
        number_in(arm[name], f"{where}, arm {name}", *room[unit], unit) for name, unit in zip(told, units, strict=True)
    ]
    return ArmWeight(**dict(zip(told, sizes, strict=True)))


def _needed(facts, key, where):
    """What stands under a key that nothing stands in for."""
    if key not in facts:
        raise RecordingError(
            f'{where}: {key} is missing, or spelt in another way. Add "{key}": {NEEDED[key]}, with your own values.'
        )
    return facts[key]


def _section(facts, key, where):
    section = _needed(facts, key, where)
    if not isinstance(section, dict):
        raise RecordingError(f"{where}: expected an object named {key!r}, got {reprlib.repr(section)}.")
    return section


def _list(facts, key, length, where):
    value = _needed(facts, key, where)
    if not isinstance(value, list) or len(value) != length:
        raise RecordingError(f"{where}: expected {length} numbers in {key}, got {reprlib.repr(value)}.")
    return value

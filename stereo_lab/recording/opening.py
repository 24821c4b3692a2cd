"""Opening a recording: its folder found, its recording.json read with care. The format stands in ``data/README.md``."""

from __future__ import annotations

import os
from pathlib import Path

from stereo_lab.common.files import finite_number, read_json
from stereo_lab.errors import RecordingError, StereoLabError
from stereo_lab.kinematics import TwoLinkArm
from stereo_lab.recording.model import Ball, Board, Recording

REPOSITORY = Path(__file__).resolve().parent.parent.parent
COLORS = ("red", "orange", "yellow", "green", "blue")


def open_recording(path: str | Path | None = None) -> Recording:
    """Open a recording.

    Parameters
    ----------
    path : str or path, optional
        A folder, or the name of a shipped recording. None: the environment variable
        STEREO_LAB_RECORDING, and without it the shipped bench.

    Returns
    -------
    Recording

    Raises
    ------
    RecordingError
        If there is no such folder or its recording.json cannot be used.
    """
    folder = _find_folder(path or os.environ.get("STEREO_LAB_RECORDING") or "bench")
    try:
        return _parse(folder, read_json(folder / "recording.json"))
    except RecordingError:
        raise
    except StereoLabError as error:
        raise RecordingError(str(error)) from None


def _find_folder(path):
    """The folder meant by a path or by the name of a shipped recording."""
    for folder in (Path(path), REPOSITORY / path, REPOSITORY / "data" / path):
        if (folder / "recording.json").is_file():
            return folder.resolve()
    shipped = sorted(p.parent.name for p in (REPOSITORY / "data").glob("*/recording.json"))
    if Path(path).is_dir():
        raise RecordingError(
            f"{path} has no recording.json in it, so it is no recording. data/README.md shows what goes in."
        )
    raise RecordingError(f"There is no folder {path}. Shipped recordings: {', '.join(shipped) or 'none'}.")


def _parse(folder, facts):
    where = folder / "recording.json"
    width, height = (_count(v, f"{where}, image_size") for v in _list(facts, "image_size", 2, where))
    board, ball = _section(facts, "board", where), _section(facts, "ball", where)
    color = str(ball.get("color", "red")).lower()
    if color not in COLORS:
        raise RecordingError(f"{where}, ball color: expected one of {', '.join(COLORS)}, got {color!r}.")
    arm, depth = _parse_arm(facts, where)
    return Recording(
        path=folder,
        title=str(facts.get("title", folder.name)),
        made_by=str(facts.get("made_by", "camera")),
        image_size=(width, height),
        frame_rate=_positive(facts.get("frame_rate", 10), f"{where}, frame_rate"),
        board=Board(
            _count(board.get("columns"), f"{where}, board columns"),
            _count(board.get("rows"), f"{where}, board rows"),
            _positive(board.get("square_mm"), f"{where}, board square_mm"),
        ),
        ball=Ball(color, _positive(ball.get("diameter_mm"), f"{where}, ball diameter_mm")),
        arm=arm,
        arm_depth_mm=depth,
        arm_is_shipped="arm" not in facts,
        calibrated_by=facts.get("calibrated_by"),
        truth=read_json(folder / "truth.json") if (folder / "truth.json").is_file() else {},
    )


SHIPPED_ARM = {"l1_mm": 250, "l2_mm": 200, "depth_mm": 1000, "theta1_deg": [-180, 180], "theta2_deg": [-160, 160]}


def _parse_arm(facts, where):
    arm = _section(facts, "arm", where) if "arm" in facts else SHIPPED_ARM
    limits = []
    for joint in ("theta1_deg", "theta2_deg"):
        turns = _list(arm, joint, 2, where) if joint in arm else SHIPPED_ARM[joint]
        low, high = (finite_number(v, f"{where}, arm {joint}") for v in turns)
        if low >= high:
            raise RecordingError(f"{where}, arm {joint}: expected [low, high] in degrees, got {turns!r}.")
        limits.append((low, high))
    lengths = [_positive(arm.get(k), f"{where}, arm {k}") for k in ("l1_mm", "l2_mm", "depth_mm")]
    return TwoLinkArm(*lengths[:2], tuple(limits)), lengths[2]


def _section(facts, key, where):
    if not isinstance(facts.get(key), dict):
        raise RecordingError(f"{where}: expected an object named {key!r}, got {facts.get(key)!r}.")
    return facts[key]


def _list(facts, key, length, where):
    value = facts.get(key)
    if not isinstance(value, list) or len(value) != length:
        raise RecordingError(f"{where}: expected {length} numbers in {key}, got {value!r}.")
    return value


def _positive(value, where):
    number = finite_number(value, where)
    if number <= 0:
        raise RecordingError(f"{where}: expected a number above zero, got {value!r}.")
    return number


def _count(value, where):
    number = _positive(value, where)
    if number != int(number):
        raise RecordingError(f"{where}: expected a whole number, got {value!r}.")
    return int(number)

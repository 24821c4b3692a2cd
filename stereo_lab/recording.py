"""Recordings: a folder of pictures from two cameras, and what was in front of them.

The format is described in ``data/README.md``. Nothing is read before it is asked for.
"""

from __future__ import annotations

import os
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from stereo_lab.common.files import finite_number, natural_key, read_json, read_table
from stereo_lab.errors import RecordingError, StereoLabError
from stereo_lab.importing import build_whole, expand, match_halves, one_size
from stereo_lab.kinematics import TwoLinkArm
from stereo_lab.pictures import PICTURES, read_image

REPOSITORY = Path(__file__).resolve().parent.parent
COLORS = ("red", "orange", "yellow", "green", "blue")


@dataclass(frozen=True)
class Board:
    """A chessboard, told by its *inner* corners (where four squares meet)."""

    columns: int
    rows: int
    square_mm: float

    @property
    def corners_mm(self):
        """Inner corners on the board, row by row, shape (rows * columns, 3), z = 0."""
        grid = np.mgrid[: self.columns, : self.rows].T.reshape(-1, 2)
        return np.column_stack([grid * self.square_mm, np.zeros(len(grid))])


@dataclass(frozen=True)
class Ball:
    """The ball: the name of its colour and its diameter."""

    color: str
    diameter_mm: float


@dataclass(frozen=True)
class Position:
    """Where the ball's centre is, on the bench: x to the right, y up, depth from the cameras."""

    x_mm: float
    y_mm: float
    depth_mm: float


@dataclass(frozen=True)
class StereoPair:
    """Two pictures of one moment, read from their files each time they are asked for."""

    name: str
    left_path: Path
    right_path: Path | None = None
    image_size: tuple | None = None
    grey_allowed: bool = False

    @property
    def left(self):
        """The left picture, BGR, shape (height, width, 3)."""
        return self._read(self.left_path)

    @property
    def right(self):
        """The right picture, BGR, shape (height, width, 3)."""
        if self.right_path is None:
            raise RecordingError(f"{self.left_path} was taken with the left camera alone: it has no right picture.")
        return self._read(self.right_path)

    def _read(self, path):
        image = read_image(path, self.grey_allowed)
        size = image.shape[1::-1]
        if self.image_size is not None and size != tuple(self.image_size):
            raise RecordingError(
                f"{path} is {size[0]}x{size[1]} pixels, but this recording is "
                f"{self.image_size[0]}x{self.image_size[1]}. All pictures of a recording have one size: "
                "take it again, or correct image_size in recording.json."
            )
        return image


@dataclass(frozen=True)
class Sample:
    """A pair with the ball at a measured place; ``truth`` is known in rendered recordings alone."""

    pair: StereoPair
    measured: Position
    truth: Position | None
    use: str


@dataclass(frozen=True)
class Recording:
    """An opened recording; see :func:`open_recording`."""

    path: Path
    title: str
    made_by: str
    image_size: tuple
    frame_rate: float
    board: Board
    ball: Ball
    arm: TwoLinkArm
    arm_depth_mm: float
    arm_is_shipped: bool = False
    calibrated_by: str | None = None
    truth: dict = field(default_factory=dict, repr=False)

    @property
    def name(self):
        return self.path.name

    @property
    def rendered(self):
        """True where the pictures come from a renderer and not from cameras."""
        return self.made_by == "render"

    @property
    def sets(self):
        """Names of the sets of pictures there are."""
        return sorted(p.parent.name for p in self.path.glob("*/left") if p.is_dir())

    def pairs(self, set_name):
        """The pairs of one set, in the order of their names, pictures unread.

        A set without a folder ``right`` was taken with the left camera alone.

        Raises
        ------
        RecordingError
            If the set is missing or empty, or half of a pair is missing.
        """
        folder = self.path / set_name
        left = _pictures(folder / "left")
        if not left:
            there = ", ".join(self.sets) or "none"
            raise RecordingError(
                f"{folder / 'left'} holds no pictures (.jpg or .png). Sets in this recording: {there}."
            )
        right = _pictures(folder / "right") if (folder / "right").is_dir() else {}
        if (folder / "right").is_dir():
            _check_halves(folder, left, right)
        grey = set_name == "calibration"
        return tuple(StereoPair(n, left[n], right.get(n), self.image_size, grey) for n in left)

    def samples(self, set_name):
        """The measured pairs of one set: a tuple of :class:`Sample`.

        Raises
        ------
        RecordingError
            If ``measured.csv`` is missing or has a line that cannot be used (the line is named).
        """
        pairs = {pair.name: pair for pair in self.pairs(set_name)}
        rows = read_table(self.path / set_name / "measured.csv", ("name", "x_mm", "y_mm", "depth_mm"))
        samples = []
        for where, row in rows:
            pair = _find_pair(pairs, row["name"], where)
            measured = Position(*(finite_number(row[k], f"{where}, {k}") for k in ("x_mm", "y_mm", "depth_mm")))
            ball = self.true_ball(set_name, pair.name)
            truth = None if ball is None else Position(*map(float, ball["ball"]))
            samples.append(Sample(pair, measured, truth, (row.get("use") or "").strip()))
        return tuple(samples)

    def true_ball(self, set_name, name):
        """The entry of truth.json for one frame with a ball in it, or None."""
        entry = self.truth.get("sets", {}).get(set_name, {}).get(name)
        return entry if entry and entry.get("ball") is not None else None


def open_recording(path=None):
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


# --- reading the folder ------------------------------------------------------------------------


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


def _pictures(folder):
    """Pictures of a folder by name without ending, in natural order."""
    if not folder.is_dir():
        return {}
    files = [p for p in folder.iterdir() if p.suffix.lower() in PICTURES and not p.name.startswith(".")]
    return {p.stem: p for p in sorted(files, key=natural_key)}


def _check_halves(folder, left, right):
    for side, have, other in (("left", left, right), ("right", right, left)):
        lost = [other[name].name for name in other if name not in have]
        if lost:
            more = f" and {len(lost) - 1} more" if len(lost) > 1 else ""
            raise RecordingError(
                f"{folder / side} has no picture {lost[0]}{more}: half of the pair is missing. "
                "Put it back, or take its other half away."
            )


def _find_pair(pairs, name, where):
    """A pair by its name; a spreadsheet that turned 003 into 3 is understood."""
    name = (name or "").strip()
    if name in pairs:
        return pairs[name]
    alike = [p for p in pairs.values() if name.isdigit() and p.name.isdigit() and int(p.name) == int(name)]
    if len(alike) == 1:
        return alike[0]
    raise RecordingError(f"{where}: there is no picture named {name!r} in this set.")


# --- making a recording from pictures at hand ----------------------------------------------------


def import_images(left_glob, right_glob, board, out, ball=None):
    """Make a recording from board pictures taken elsewhere.

    Parameters
    ----------
    left_glob, right_glob : str, patterns such as ``"shots/left*.jpg"``
    board : Board
    out : path of a folder that is not there yet (or is empty)
    ball : Ball, optional; a red one of 40 mm where it is not given

    Returns
    -------
    Recording

    Raises
    ------
    RecordingError
        If a pattern finds nothing, the halves do not match, a picture is broken, sizes differ or
        ``out`` is in use.
    """
    out = Path(out)
    if out.exists() and (not out.is_dir() or any(out.iterdir())):
        raise RecordingError(f"{out} is there already. Name a folder that is new.")
    halves = match_halves(expand(left_glob), expand(right_glob))
    size = one_size([path for pair in halves for path in pair])
    ball = ball or Ball("red", 40.0)
    facts = {
        "format": 1,
        "title": out.name,
        "made_by": "camera",
        "image_size": list(size),
        "frame_rate": 10,
        "board": {"columns": board.columns, "rows": board.rows, "square_mm": board.square_mm},
        "ball": {"color": ball.color, "diameter_mm": ball.diameter_mm},
    }
    build_whole(out, halves, facts)
    return open_recording(out.resolve())

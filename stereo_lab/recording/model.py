"""What a recording is: pairs of pictures, samples with the ball at a measured place. Nothing is read before it is asked for."""

from __future__ import annotations

import reprlib
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from stereo_lab.common.files import natural_key, read_table
from stereo_lab.errors import RecordingError
from stereo_lab.kinematics import TwoLinkArm
from stereo_lab.recording.bounds import color_name, corner_count, length_mm, place_mm, plain_name
from stereo_lab.recording.pictures import PICTURES, read_image


@dataclass(frozen=True)
class Board:
    """A chessboard, told by its *inner* corners (where four squares meet).

    Attributes
    ----------
    columns, rows : int, of inner corners
    square_mm : float, side of one square

    Raises
    ------
    StereoLabError
        If it has fewer than 3 or more than 100 of them each way, or its squares fit into no room.
    """

    columns: int
    rows: int
    square_mm: float

    def __post_init__(self):
        corner_count(self.columns, "board columns")
        corner_count(self.rows, "board rows")
        length_mm(self.square_mm, "board square_mm")

    @property
    def corners_mm(self) -> np.ndarray:
        """Inner corners on the board, row by row, shape (rows * columns, 3), z = 0."""
        grid = np.mgrid[: self.columns, : self.rows].T.reshape(-1, 2)
        return np.column_stack([grid * self.square_mm, np.zeros(len(grid))])


@dataclass(frozen=True)
class Ball:
    """The ball.

    Attributes
    ----------
    color : str, one of ``COLORS``
    diameter_mm : float

    Raises
    ------
    StereoLabError
        If there is no such colour, or the ball fits into no room.
    """

    color: str
    diameter_mm: float

    def __post_init__(self):
        color_name(self.color, "ball color")
        length_mm(self.diameter_mm, "ball diameter_mm")


@dataclass(frozen=True)
class Position:
    """Where the ball's centre is, on the bench.

    Attributes
    ----------
    x_mm, y_mm : float, to the right and up
    depth_mm : float, away from the cameras
    """

    x_mm: float
    y_mm: float
    depth_mm: float


@dataclass(frozen=True)
class StereoPair:
    """Two pictures of one moment, read from their files each time they are asked for.

    Attributes
    ----------
    name : str, of both files, without ending
    left_path, right_path : Path; no right one where the left camera was alone
    image_size : (width, height) that the pictures must have, or None for any
    grey_allowed : bool, whether grey pictures are taken as well
    """

    name: str
    left_path: Path
    right_path: Path | None = None
    image_size: tuple[int, int] | None = None
    grey_allowed: bool = False

    @property
    def set_name(self) -> str:
        """The set it belongs to: the name of the folder above left and right."""
        return self.left_path.parent.parent.name

    @property
    def left(self) -> np.ndarray:
        """The left picture, BGR, shape (height, width, 3)."""
        return self._read(self.left_path)

    @property
    def right(self) -> np.ndarray:
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
    """A pair with the ball at a measured place.

    Attributes
    ----------
    pair : StereoPair
    measured : Position, by the ruler
    truth : Position, the exact place; known in rendered recordings alone
    use : str, what measured.csv says it is for: "fit", "check", "plane", "volume" or nothing
    """

    pair: StereoPair
    measured: Position
    truth: Position | None
    use: str

    @property
    def reference(self) -> Position:
        """Where the ball is, as well as is known: the exact place, or the measured one on a camera recording."""
        return self.truth or self.measured


@dataclass(frozen=True)
class Recording:
    """An opened recording; see :func:`open_recording`.

    Attributes
    ----------
    path : Path of its folder
    title : str
    made_by : str, "camera" or "render"
    image_size : (width, height), px
    frame_rate : float, pairs a second
    board : Board
    ball : Ball
    arm : TwoLinkArm
    arm_depth_mm : float, depth of the plane of the arm
    arm_is_shipped : bool, whether the shipped bench's arm stands in for one that is not named
    calibrated_by : str, name of the recording beside it that has the boards; None: its own
    truth : dict, what truth.json says
    """

    path: Path
    title: str
    made_by: str
    image_size: tuple[int, int]
    frame_rate: float
    board: Board
    ball: Ball
    arm: TwoLinkArm
    arm_depth_mm: float
    arm_is_shipped: bool = False
    calibrated_by: str | None = None
    truth: dict = field(default_factory=dict, repr=False)

    @property
    def name(self) -> str:
        """Name of its folder."""
        return self.path.name

    @property
    def rendered(self) -> bool:
        """True where the pictures come from a renderer and not from cameras."""
        return self.made_by == "render"

    @property
    def sets(self) -> list[str]:
        """Names of the sets of pictures there are."""
        return sorted(p.parent.name for p in self.path.glob("*/left") if p.is_dir())

    def pairs(self, set_name: str) -> tuple[StereoPair, ...]:
        """The pairs of one set, in the order of their names, pictures unread.

        A set without a folder ``right`` was taken with the left camera alone.

        Raises
        ------
        RecordingError
            If the set is missing or empty, its name is a path, or half of a pair is missing.
        """
        folder = self.path / plain_name(set_name, f"{self.path}, set")
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

    def samples(self, set_name: str) -> tuple[Sample, ...]:
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
            measured = Position(*(place_mm(row[k], f"{where}, {k}") for k in ("x_mm", "y_mm", "depth_mm")))
            ball = self.true_ball(set_name, pair.name)
            truth = None if ball is None else Position(*map(float, ball["ball"]))
            samples.append(Sample(pair, measured, truth, (row.get("use") or "").strip()))
        return tuple(samples)

    def has_samples(self, set_name: str) -> bool:
        """Whether a set has pictures and a table of what was measured."""
        return set_name in self.sets and (self.path / set_name / "measured.csv").is_file()

    @property
    def has_boards(self) -> bool:
        """Whether there are boards to calibrate on, its own or those of the recording that calibrated_by names."""
        return "calibration" in self.sets or bool(self.calibrated_by)

    @property
    def ball_sets(self) -> list[str]:
        """Names of the sets that show the ball, single pictures first."""
        order = ("snaps", "evaluation", "position", "depth", "track")
        names = [name for name in self.sets if name != "calibration"]
        return sorted(names, key=lambda name: order.index(name) if name in order else len(order))

    def judges(self, use: str | None = None) -> tuple[Sample, ...]:
        """The samples that a model is judged by: no model may be fitted on them.

        The evaluation set; where there is none, the check samples: those of position stand for the arm's
        plane, those of depth for the volume.

        Parameters
        ----------
        use : "plane" or "volume", optional; else both

        Returns
        -------
        tuple of Sample, their ``use`` being "plane" or "volume"
        """
        if self.has_samples("evaluation"):
            found = self.samples("evaluation")
        else:
            stand_in = (("depth", "volume"), ("position", "plane"))
            found = tuple(
                replace(sample, use=kind)
                for name, kind in stand_in
                if self.has_samples(name)
                for sample in self.samples(name)
                if sample.use == "check"
            )
        return tuple(s for s in found if use is None or s.use == use)

    def true_ball(self, set_name: str, name: str) -> dict | None:
        """The entry of truth.json for one frame with a ball in it, or None."""
        entry = self.truth.get("sets", {}).get(set_name, {}).get(name)
        return entry if entry and entry.get("ball") is not None else None


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
    alike = [
        p for p in pairs.values() if name.isdecimal() and p.name.isdecimal() and p.name.lstrip("0") == name.lstrip("0")
    ]
    if len(alike) == 1:
        return alike[0]
    raise RecordingError(f"{where}: there is no picture named {reprlib.repr(name)} in this set.")

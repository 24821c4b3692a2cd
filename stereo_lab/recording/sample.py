"""What stands before the cameras, and what they take of it: board, ball, a pair of pictures, a measured sample."""

from __future__ import annotations

import reprlib
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from stereo_lab.errors import RecordingError, StereoLabError
from stereo_lab.recording.bounds import (
    CHARUCO,
    CHESSBOARD,
    board_kind,
    color_name,
    corner_count,
    dictionary_name,
    length_mm,
    markers_that_fit,
)
from stereo_lab.recording.pictures import read_image


def _keep(thing, **values):
    """What was typed, as it is understood: "40" becomes 40.0. Afterwards nobody can change it."""
    for name, value in values.items():
        object.__setattr__(thing, name, value)  # ``thing`` is frozen


@dataclass(frozen=True)
class Board:
    """A flat board whose corners a camera can find: a chessboard, or a ChArUco board.

    A ChArUco board is a chessboard with a marker in each white square. A marker tells its number, so a board counts that is
    only partly in the picture.

    Attributes
    ----------
    columns, rows : int
        Of a chessboard its *inner* corners, where four squares meet; of a ChArUco board its *squares*.
    square_mm : float, side of one square
    kind : str, "chessboard" or "charuco"
    marker_mm : float or None, side of one marker of a ChArUco board
    dictionary : str or None, what its markers are taken from, by OpenCV's name: "DICT_5X5_100"

    Raises
    ------
    StereoLabError
        If it has fewer than 3 or more than 100 inner corners each way, its squares fit into no room, its markers do not fit
        into its squares, or their dictionary is unknown or too small.
    """

    columns: int
    rows: int
    square_mm: float
    kind: str = CHESSBOARD
    marker_mm: float | None = None
    dictionary: str | None = None

    def __post_init__(self):
        board_kind(self.kind, "board kind")
        squares = int(self.kind == CHARUCO)
        _keep(
            self,
            columns=corner_count(self.columns, "board columns", squares),
            rows=corner_count(self.rows, "board rows", squares),
            square_mm=length_mm(self.square_mm, "board square_mm"),
        )
        if self.kind == CHARUCO:
            _keep(self, marker_mm=markers_that_fit(self.marker_mm, self.square_mm, "board marker_mm"))
            dictionary_name(self.dictionary, self.columns * self.rows // 2, "board dictionary")

    @property
    def grid(self) -> tuple[int, int]:
        """Inner corners across and down."""
        squares = int(self.kind == CHARUCO)
        return self.columns - squares, self.rows - squares

    @property
    def corners_mm(self) -> np.ndarray:
        """Inner corners on the board, row by row, shape (corners, 3), z = 0."""
        across, down = self.grid
        places = np.mgrid[:across, :down].T.reshape(-1, 2)
        return np.column_stack([places * self.square_mm, np.zeros(len(places))])

    def __str__(self) -> str:
        """As it is told in messages."""
        if self.kind == CHARUCO:
            return f"ChArUco board of {self.columns}x{self.rows} squares, {self.dictionary}"
        return f"board with {self.columns}x{self.rows} inner corners"


def must_be_board(board: object) -> None:
    """Refuse what is no board, such as a pair of counts.

    Raises
    ------
    StereoLabError
    """
    if not isinstance(board, Board):
        raise StereoLabError(
            "Expected a board, as in Board(9, 6, 25.0), of 9x6 inner corners and squares of 25 mm; "
            f"got {reprlib.repr(board)}."
        )


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
        color, diameter_mm = color_name(self.color, "ball color"), length_mm(self.diameter_mm, "ball diameter_mm")
        _keep(self, color=color, diameter_mm=diameter_mm)


USUAL_BALL = Ball("red", 40.0)  # the bench's, where no other one is told


@dataclass(frozen=True)
class Position:
    """Where the ball's centre is, on the bench.

    Attributes
    ----------
    x_mm, y_mm : float, to the right and up
    depth_mm : float, away from the cameras
    sigma_mm : (x, y, depth), standard deviations where they are known, else None
    """

    x_mm: float
    y_mm: float
    depth_mm: float
    sigma_mm: tuple[float, float, float] | None = None

    def minus(self, other: Position) -> tuple[float, float, float]:
        """How far it lies from another one along x, y and depth, mm."""
        return self.x_mm - other.x_mm, self.y_mm - other.y_mm, self.depth_mm - other.depth_mm


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
    def full_name(self) -> str:
        """As it is told in messages: "set/name"."""
        return f"{self.set_name}/{self.name}"

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
                "take it again, or correct image_size in recording.json.",
                fault="picture_sizes",
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

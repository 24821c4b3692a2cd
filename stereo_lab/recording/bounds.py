"""What a recording may say: numbers that fit into a room, names without a path, colours by their name."""

from __future__ import annotations

import reprlib
from typing import Any

from stereo_lab.common.files import finite_number
from stereo_lab.errors import RecordingError

LENGTHS_MM = (0.001, 100_000.0)  # a square given in metres is still told so by the calibration; no room is 100 m long
FEWEST_CORNERS, MOST_CORNERS = 3, 100  # OpenCV needs three each way; a picture cannot show a hundred sharply
PICTURE_PX = (8, 20_000)  # one side; see also LARGEST_PICTURE in pictures.py
PICTURES_A_SECOND = (0.001, 1_000.0)  # from one in a quarter of an hour to the fastest webcam ten times over
MOST_GRAMS = 100_000.0  # of a part of an arm
TURNS_DEG = (-3_600.0, 3_600.0)  # ten turns each way
COLORS = ("red", "orange", "yellow", "green", "blue")


def number_in(value: Any, where: str, low: float, high: float, unit: str = "") -> float:
    """A float from ``low`` to ``high``, both included.

    Raises
    ------
    StereoLabError
        If it is no number, or lies outside.
    """
    number = finite_number(value, where)
    if not low <= number <= high:
        wanted = f"a number from {low:,g} to {high:,g} {unit}".rstrip()
        raise RecordingError(f"{where}: expected {wanted}, got {reprlib.repr(value)}.")
    return number


def whole_in(value: Any, where: str, low: float, high: float) -> int:
    """A whole number from ``low`` to ``high``, both included.

    Raises
    ------
    StereoLabError
        If it is no whole number, or lies outside.
    """
    number = number_in(value, where, low, high)
    if number != int(number):
        raise RecordingError(f"{where}: expected a whole number, got {reprlib.repr(value)}.")
    return int(number)


def length_mm(value: Any, where: str) -> float:
    """A length in mm, above zero; see :data:`LENGTHS_MM`."""
    return number_in(value, where, *LENGTHS_MM, "mm")


def place_mm(value: Any, where: str) -> float:
    """One coordinate in mm, of either sign, that fits into a room."""
    return number_in(value, where, -LENGTHS_MM[1], LENGTHS_MM[1], "mm")


def corner_count(value: Any, where: str) -> int:
    """Inner corners of a chessboard, one way."""
    return whole_in(value, where, FEWEST_CORNERS, MOST_CORNERS)


def color_name(value: Any, where: str) -> str:
    """One of :data:`COLORS`, however it is written: "Red " is red.

    Raises
    ------
    RecordingError
        For any other name.
    """
    name = value.strip().lower() if isinstance(value, str) else value
    if name not in COLORS:
        raise RecordingError(f"{where}: expected one of {', '.join(COLORS)}, got {reprlib.repr(value)}.")
    return name


def plain_name(value: Any, where: str) -> str:
    """The name of a file or folder: a word that leads nowhere else.

    Raises
    ------
    RecordingError
        If it is no text, is empty, or has a path in it.
    """
    if not isinstance(value, str) or value in ("", ".", "..") or any(sign in value for sign in "/\\:\0"):
        raise RecordingError(f"{where}: expected a plain name without a path, got {reprlib.repr(value)}.")
    return value

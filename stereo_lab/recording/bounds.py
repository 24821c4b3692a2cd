"""What a recording may say: numbers that fit into a room, names without a path, colours by their name."""

from __future__ import annotations

import reprlib
from typing import Any

from stereo_lab.common.files import finite_number
from stereo_lab.errors import RecordingError

LENGTHS_MM = (0.001, 100_000.0)  # a square given in metres is still told so by the calibration; no room is 100 m long
FEWEST_CORNERS, MOST_CORNERS = 3, 100  # OpenCV needs three each way; a picture cannot show a hundred sharply
PICTURE_PX = (8, 20_000)  # one side; see also LARGEST_PICTURE in pictures.py
MARKER = 0.75  # side of a ChArUco board's marker, as a part of its square, where nobody tells it
# Millimetres in what people take for a millimetre, the likeliest first; squares that somebody prints
UNIT_NAMES = {10.0: "centimetres", 1000.0: "metres", 25.4: "inches", 0.1: "tenths of a millimetre"}
SQUARES_MM = (4.0, 250.0)
PLAUSIBLE_BASELINE_MM = (25.0, 500.0)  # of two webcams beside each other
PICTURES_A_SECOND = (0.001, 1_000.0)  # from one in a quarter of an hour to the fastest webcam ten times over
MOST_GRAMS = 100_000.0  # of a part of an arm
TURNS_DEG = (-3_600.0, 3_600.0)  # ten turns each way
CHESSBOARD, CHARUCO = KINDS = ("chessboard", "charuco")
DICTIONARY = "DICT_4X4_50"  # where nobody tells it
MARKER_PART = (0.5, 0.9)  # of a square's side
DICTIONARIES = {f"DICT_{bits}X{bits}_{count}": count for bits in (4, 5, 6, 7) for count in (50, 100, 250, 1000)}
COLORS = ("red", "orange", "yellow", "green", "blue")


def units_of_squares(baseline_mm: float, square_mm: float) -> dict[float, str]:
    """Of :data:`UNIT_NAMES` those in which squares may have been told as if they were mm: all is plausible with them."""
    (low, high), (smallest, largest) = PLAUSIBLE_BASELINE_MM, SQUARES_MM
    return {
        factor: name
        for factor, name in UNIT_NAMES.items()
        if low <= baseline_mm * factor <= high and smallest <= square_mm * factor <= largest
    }


def unit_asked(baseline_mm: float, square_mm: float) -> str:
    """A question after the unit of squares, and what follows from it; empty where no unit makes all plausible."""
    units = units_of_squares(baseline_mm, square_mm)
    squares, baselines = (" or ".join(told_mm(length * f) for f in units) for length in (square_mm, baseline_mm))
    asked = (
        f"Is square_mm in {' or '.join(units.values())}? Then it is {squares} mm, and they stand {baselines} mm apart."
    )
    return asked if units else ""


def told_mm(length: float) -> str:
    """A length of any size, in mm, as a sentence tells it: 0.121, 12.1, 1205."""
    return f"{length:.0f}" if length >= 100 else f"{length:.3g}"


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


def corner_count(value: Any, where: str, squares: int = 0) -> int:
    """Inner corners of a board, one way; or its squares, of which there is one more: ``squares`` is 1 then."""
    return whole_in(value, where, FEWEST_CORNERS + squares, MOST_CORNERS + squares)


def board_kind(value: Any, where: str) -> str:
    """One of :data:`KINDS`.

    Raises
    ------
    RecordingError
        For any other name.
    """
    if value not in KINDS:
        raise RecordingError(f"{where}: expected {' or '.join(KINDS)}, got {reprlib.repr(value)}.")
    return value


def markers_that_fit(value: Any, square_mm: float, where: str) -> float:
    """Side of a ChArUco board's markers, in mm.

    Raises
    ------
    RecordingError
        If they do not fit into a square with white round them, or are too small to be read in it.
    """
    low, high = (part * square_mm for part in MARKER_PART)
    return number_in(value, where, low, high, "mm, half to nine tenths of a square")


def dictionary_name(value: Any, markers: int, where: str) -> str:
    """The name of one of OpenCV's marker dictionaries that has enough markers.

    Raises
    ------
    RecordingError
        For any other name, and for a dictionary that is too small.
    """
    if value not in DICTIONARIES:
        raise RecordingError(
            f"{where}: expected one of DICT_4X4_50 to DICT_7X7_1000, such as DICT_5X5_100; got {reprlib.repr(value)}."
        )
    if DICTIONARIES[value] < markers:
        raise RecordingError(f"{where}: {value} has {DICTIONARIES[value]} markers, and the board needs {markers}.")
    return value


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

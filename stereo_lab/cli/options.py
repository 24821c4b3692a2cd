"""Options that several commands have."""

from __future__ import annotations

import argparse
from collections.abc import Callable

# Adds one command, by its name, what runs it, one sentence of help and an example; gives its parser
Add = Callable[[str, Callable[[argparse.Namespace], int], str, str], argparse.ArgumentParser]


def add_recording(parser: argparse.ArgumentParser) -> None:
    """Which recording, and where its numbers go."""
    parser.add_argument(
        "recording", nargs="?", metavar="REC",
        help="folder or name of a recording (default: $STEREO_LAB_RECORDING, else the shipped bench)",
    )  # fmt: skip
    add_json(parser)


def add_board(parser: argparse.ArgumentParser, square: str = "") -> None:
    """What else there is to say of a board; ``square``: what is taken where --square-mm is not given."""
    parser.add_argument("--square-mm", metavar="MM", help=f"side of one square in millimetres {square}".rstrip())
    parser.add_argument("--charuco", action="store_true", help="it is a ChArUco board: a chessboard with markers in it")
    parser.add_argument("--marker-mm", metavar="MM", help="side of one marker (default: three quarters of a square)")
    parser.add_argument(
        "--dictionary", metavar="NAME", help="what the markers are taken from, by OpenCV's name (default: DICT_4X4_50)"
    )  # fmt: skip


def add_json(parser: argparse.ArgumentParser) -> None:
    """Where the numbers go."""
    parser.add_argument("--json", metavar="FILE", help="write the numbers as JSON; - for the terminal")


def add_name(parser: argparse.ArgumentParser) -> None:
    """Whose folder."""
    parser.add_argument("--name", metavar="NAME", help="whose: several people at one computer have a folder each")


def decimal(word: str) -> float:
    """A number among the options; what is none is told in the words of the rest of the kit."""
    from stereo_lab.common.files import with_a_point

    try:
        return float(word)
    except ValueError:
        raise argparse.ArgumentTypeError(f"expected a number{with_a_point(word)}, got {word}") from None


def whole(word: str) -> int:
    """A whole number among the options."""
    try:
        return int(word)
    except ValueError:
        raise argparse.ArgumentTypeError(f"expected a whole number, got {word}") from None


def seconds(word: str) -> float:
    """A time that ends something."""
    if (time_s := decimal(word)) > 0:  # refuses NaN as well
        return time_s
    raise argparse.ArgumentTypeError(f"expected a number of seconds above 0, got {word}")

"""The command ``stereo-lab``."""

from __future__ import annotations

import argparse
import io
import os
import re
import sys
from collections.abc import Sequence

from stereo_lab import __version__
from stereo_lab.cli import (
    arm,
    boards,
    capture,
    checks,
    classroom,
    course,
    exchange,
    instructor,
    live,
    seats,
    train,
    vision,
)
from stereo_lab.cli.terminal import (
    BAD_INPUT,
    STOPPED,
    cannot_print,
    check_outputs,
    clear_line,
    flush_output,
    words_aside,
)
from stereo_lab.errors import StereoLabError


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command; returns the exit code 0 (done), 1 (found wanting) or 2 (bad usage or input)."""
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # before numpy is loaded: see lab.py
    os.environ.setdefault("OPENCV_LOG_LEVEL", "ERROR")  # a camera or video that does not open is told in one sentence
    os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", "-8")
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):  # a pipe on Windows may have no letter for θ
            stream.reconfigure(errors="replace")
    try:
        words, for_jupyterlab = _parted(list(sys.argv[1:] if arguments is None else arguments))
        options = _parser().parse_args([_at_home(word) for word in words])
        options.for_jupyterlab = for_jupyterlab
        check_outputs(options)
        with words_aside(options):
            code = options.run(options)
        flush_output()
        return code
    except StereoLabError as error:
        clear_line()
        print(f"stereo-lab: {error}", file=sys.stderr)
        return BAD_INPUT
    except OSError as error:
        clear_line()
        print(f"stereo-lab: {_in_words(error)}", file=sys.stderr)
        return BAD_INPUT
    except KeyboardInterrupt:
        clear_line()
        print("stereo-lab: stopped; nothing is left half written.", file=sys.stderr)
        return STOPPED


def _parted(words):
    """What stands behind `--` after `start` is for JupyterLab; argparse would mix it up with words of its own."""
    if words[:1] != ["start"] or "--" not in words:
        return words, []
    k = words.index("--")
    return words[:k], words[k + 1 :]


def _at_home(word):
    """A word with the home folder in the place of ~, where no shell has put it: in quotes, behind = and on Windows."""
    found = re.fullmatch(r"(--[\w-]+=)?(~(?:[/\\].*)?)", word, re.DOTALL)
    return word if found is None else (found[1] or "") + os.path.expanduser(found[2])


def _in_words(error):
    """An OSError as a sentence; without a file's name it comes from printing."""
    return f"Cannot use {error.filename}: {error.strerror or error}." if error.filename else cannot_print(error)


def _parser():
    parser = argparse.ArgumentParser(
        prog="stereo-lab", description="See in 3D with two webcams: calibrate, find the ball, locate it."
    )
    parser.add_argument("--version", action="version", version=f"stereo-lab {__version__}")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")

    def add(name, run, text, example):
        command = commands.add_parser(name, help=text, description=text, epilog=f"example:  stereo-lab {example}")
        command.set_defaults(run=run)
        return command

    for module in (course, seats, classroom, vision, train, exchange, capture, boards, arm, live, checks, instructor):
        module.add_to(add)
    return parser

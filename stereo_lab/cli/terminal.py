"""What every command needs of a terminal: exit codes, a progress line, JSON."""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import shutil
import signal
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, TextIO

from stereo_lab.errors import StereoLabError

if TYPE_CHECKING:
    from stereo_lab.localization import Localizer
    from stereo_lab.recording import Recording

OUTPUTS = {  # where an option that names a file is kept: the option, and how the file's name may end
    "json": ("--json", (".json",)),
    "save": ("--save", (".json",)),
    "ball": ("--out", (".json",)),
    "report": ("--report", (".html", ".htm")),
    "html": ("--html", (".html", ".htm")),
    "csv": ("--csv", (".csv",)),
    "plot": ("--plot", (".png", ".svg", ".pdf")),
}
OF_A_RECORDING = "recording.json", "calibration.json", "truth.json", "registration.json", "measured.csv"
OK, WANTING, BAD_INPUT, STOPPED = 0, 1, 2, 130
_json_to: TextIO | None = None  # where JSON goes while words are told aside


class Progress:
    """A progress line on the terminal, kept off files and pipes."""

    def __init__(self) -> None:
        self._shown = 0.0
        self._on = sys.stderr is not None and sys.stderr.isatty()

    def __enter__(self) -> Progress:
        return self

    def __exit__(self, *_: object) -> None:
        clear_line()

    def __call__(self, step: str, done: int, total: int) -> None:
        """Draw the line anew, ten times a second at most."""
        now = time.monotonic()
        if not self._on or (done < total and now - self._shown < 0.1):
            return
        self._shown = now
        filled = round(24 * done / max(total, 1))
        print(
            f"\r\033[K  [{'#' * filled}{'.' * (24 - filled)}] {done}/{total}  {step}",
            end="",
            file=sys.stderr,
            flush=True,
        )


def clear_line() -> None:
    """Wipe the progress line off the terminal."""
    if sys.stderr is not None and sys.stderr.isatty():
        print("\r\033[K", end="", file=sys.stderr, flush=True)


def tell_fit(localizer: Localizer, recording: Recording, arm: bool) -> None:
    """Print what speaks against the fit that places, or an arm, will follow.

    Raises
    ------
    StereoLabError
        If an arm would be sent to wrong places.
    """
    from stereo_lab.localization.localizer import must_lead_an_arm, where_to_look

    doubts = localizer.doubts
    for line in (*localizer.told, *doubts, *([where_to_look(recording)] if doubts else [])):
        print(line, flush=True)
    if arm:
        must_lead_an_arm(localizer)


def end_as_by_ctrl_c() -> None:
    """From now on whoever ends this program, or closes its window, ends it as Ctrl-C does: its arm must be told."""

    def end(number, _):
        signal.signal(number, signal.SIG_IGN)  # a second one would break off what the first one began
        raise KeyboardInterrupt

    for number in (getattr(signal, name) for name in ("SIGTERM", "SIGHUP") if hasattr(signal, name)):
        if signal.getsignal(number) == signal.SIG_DFL:  # under nohup it is ignored, and stays so
            signal.signal(number, end)


def check_outputs(options: argparse.Namespace) -> None:
    """Refuse files that cannot be written, before minutes of work are done for them, and those that something else lives in.

    Raises
    ------
    StereoLabError
        If a name has another ending than what is written, or is that of a file of a recording, of no plain file, or of two
        options.
    """
    from stereo_lab.common.files import check_target

    named: dict[str, str] = {}
    for kept, (option, endings) in OUTPUTS.items():
        name = getattr(options, kept, None)
        if not name or (kept == "json" and name == "-"):
            continue
        check_target(name)
        path = Path(name)
        if path.suffix.lower() not in endings:
            raise StereoLabError(f"{option}: expected a name that ends in {' or '.join(endings)}, got {name}.")
        for folder in (path.parent, path.parent.parent):  # measured.csv lies in a set of its recording
            if path.name in OF_A_RECORDING and (folder / OF_A_RECORDING[0]).is_file():
                raise StereoLabError(f"{option}: {name} belongs to the recording {folder}. Name another file.")
        place = os.path.abspath(path)
        if other := named.get(place):
            raise StereoLabError(
                f"{other} and {option} both name {name}: the one would take the other's place. Name two files."
            )
        named[place] = option


@contextlib.contextmanager
def words_aside(options: argparse.Namespace) -> Iterator[None]:
    """With ``--json -`` standard output is for the JSON alone, and words go to standard error."""
    global _json_to
    if getattr(options, "json", None) != "-":
        yield
        return
    _json_to, sys.stdout = sys.stdout, sys.stderr
    try:
        yield
    finally:
        sys.stdout, _json_to = _json_to, None


def write_json_option(path: str | None, content: object) -> None:
    """Write what ``--json`` asks for: a file, or - for the terminal.

    Raises
    ------
    StereoLabError
        If it cannot be written.
    """
    from stereo_lab.common.files import write_json

    global _json_to
    if path == "-":
        words_to, sys.stdout = sys.stdout, _json_to or sys.stdout
        try:
            print(json.dumps(content, indent=1))
            flush_output()
        finally:
            if _json_to is not None:
                _json_to, sys.stdout = sys.stdout, words_to
    elif path:
        write_json(path, content)
        print(f"written: {path}")


def flush_output() -> None:
    """Hand on what was printed; where nobody takes it, say so once and print nothing more.

    Raises
    ------
    StereoLabError
        If standard output is closed, its reader is gone or its disk is full.
    """
    if sys.stdout is None:  # started with it closed; print is silent then
        raise StereoLabError("Cannot print: standard output is closed. Leave it open, or name a file.")
    try:
        sys.stdout.flush()
    except OSError as error:
        sys.stdout = open(os.devnull, "w")  # noqa: SIM115 - else the interpreter flushes, and complains, at its end
        raise StereoLabError(cannot_print(error)) from None


def cannot_print(error: OSError) -> str:
    """Why nothing more is printed, as a sentence: the program behind a | has ended, or the disk is full."""
    help = (
        "What was to read it has ended"
        if isinstance(error, BrokenPipeError)
        else "Name a file with --json, or free some space"
    )
    return f"Cannot print: {error.strerror or error}. {help}."


def whose(name: str | None) -> str:
    """The end of a command for the folder of the one who is named: a command without it means another's."""
    return f" --name {name}" if name else ""


def me() -> str:
    """How the person called the kit: by lab.py, or by the command itself."""
    return os.environ.get("STEREO_LAB_COMMAND") or (shutil.which("stereo-lab") and "stereo-lab") or "python3 lab.py"

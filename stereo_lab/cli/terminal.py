"""What every command needs of a terminal: exit codes, a progress line, JSON."""

from __future__ import annotations

import json
import os
import shutil
import sys
import time

OK, WANTING, BAD_INPUT, STOPPED = 0, 1, 2, 130


class Progress:
    """A progress line on the terminal, kept off files and pipes."""

    def __init__(self):
        self._shown = 0.0
        self._on = sys.stderr.isatty()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        clear_line()

    def __call__(self, step, done, total):
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


def clear_line():
    if sys.stderr.isatty():
        print("\r\033[K", end="", file=sys.stderr, flush=True)


def write_json_option(path, content):
    from stereo_lab.common.files import write_json

    if path == "-":
        print(json.dumps(content, indent=1))
    elif path:
        write_json(path, content)


def me():
    """How the person called the kit: by lab.py, or by the command itself."""
    return os.environ.get("STEREO_LAB_COMMAND") or (shutil.which("stereo-lab") and "stereo-lab") or "python3 lab.py"

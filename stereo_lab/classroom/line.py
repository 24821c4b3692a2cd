"""The line to the process of one notebook: what goes through it and for how long, and what ends it."""

from __future__ import annotations

import contextlib
import json
import queue
import subprocess
import threading
import time
from dataclasses import dataclass
from typing import Any, NoReturn

from stereo_lab.classroom.room import too_much

LONGEST_LINE = 15_000_000  # bytes that a notebook may say at a time; the largest array is a third longer in letters
AT_A_TIME = 4  # lines that wait on either side: each asks, and waits for the answer
GRACE = 3.0  # seconds in which an interrupted cell has to give up
STARTS = 30.0  # seconds until the first cell begins
MOST_SAID = 20_000  # messages of one notebook; a lesson with a live film has a tenth


@dataclass(frozen=True)
class Limits:
    """How long a notebook may run.

    Attributes
    ----------
    cell, whole : float, seconds for one cell and for all together
    """

    cell: float
    whole: float


class EndedError(Exception):
    """A run that cannot go on; its text says why."""


class Line:
    """Both directions of the line, and the clock beside it."""

    def __init__(self, process: subprocess.Popen, limits: Limits, halt: threading.Event) -> None:
        self.process: Any = process
        self.limits, self.halt = limits, halt
        self.cell: int | None = None
        self.over: EndedError | None = None
        self._said = 0
        self._lines: queue.Queue = queue.Queue(AT_A_TIME)
        self._told: queue.Queue = queue.Queue(AT_A_TIME)
        self._closed = threading.Event()
        self._began = self._cell_began = self._looked = time.monotonic()
        for goes in (self._read, self._write):
            threading.Thread(target=goes, daemon=True).start()

    def begin(self, cell: int) -> None:
        """A cell begins now."""
        self.cell, self._cell_began = cell, time.monotonic()

    def seconds(self) -> float:
        """How long the cell has run."""
        return time.monotonic() - self._cell_began

    def close(self) -> None:
        """Read and write no more."""
        self._closed.set()

    def end(self, why: str) -> NoReturn:
        """It stays over: whoever judges a function takes what is raised in there for the function's own."""
        self.over = self.over or EndedError(why)
        raise self.over

    def send(self, **message: Any) -> None:
        """One line to the desk.

        Raises
        ------
        EndedError
            If nobody takes it in time.
        """
        content = json.dumps(message).encode() + b"\n"
        while True:
            self._look_after()
            with contextlib.suppress(queue.Full):
                return self._told.put(content, timeout=0.1)

    def hear(self) -> dict[str, Any]:
        """The next message.

        Raises
        ------
        EndedError
            If none comes in time, or the notebook takes too much.
        """
        while True:
            self._look_after()
            with contextlib.suppress(queue.Empty):
                line = self._lines.get(timeout=0.1)
                break
        self._said += 1
        if not line:
            self.end("it ends the kernel")
        try:
            message = json.loads(line)
        except (ValueError, RecursionError):
            message = None
        if not isinstance(message, dict) or self._said > MOST_SAID:
            self.end("it writes into the grader's line")
        return message

    def _look_after(self):
        """End what takes too long or too much."""
        now = time.monotonic()
        if self.over:
            raise self.over
        if now - self._cell_began > (self.limits.cell + GRACE if self.cell is not None else STARTS):
            self.end(f"it took longer than {self.limits.cell if self.cell is not None else STARTS:.0f} s")
        if now - self._began > self.limits.whole + STARTS or self.halt.is_set():
            self.cell = None  # no cell alone is to blame
            self.end("the notebook takes too long")
        if now - self._looked > 0.2:
            self._looked = now
            if told := too_much(self.process):
                self.end(told)

    def _read(self):
        with contextlib.suppress(OSError, ValueError):  # closed under way
            while line := self.process.stdout.readline(LONGEST_LINE):
                while not self._closed.is_set():
                    with contextlib.suppress(queue.Full):
                        self._lines.put(line, timeout=1)
                        break
        with contextlib.suppress(queue.Full):
            self._lines.put(b"", timeout=5)

    def _write(self):
        """Apart from the rest: who asks and never listens fills the pipe, and would hold up whoever writes into it."""
        with contextlib.suppress(OSError, ValueError):
            while not self._closed.is_set():
                with contextlib.suppress(queue.Empty):
                    self.process.stdin.write(self._told.get(timeout=1))
                    self.process.stdin.flush()

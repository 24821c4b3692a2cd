"""The folder that a recorder fills: whatever was taken stays, whenever the power goes."""

from __future__ import annotations

import contextlib
import time
from pathlib import Path

import cv2
import numpy as np

from stereo_lab.common.files import write_json, write_whole
from stereo_lab.common.spreadsheets import with_row
from stereo_lab.errors import RecordingError, StereoLabError
from stereo_lab.recording import Ball, Board, Recording, open_recording
from stereo_lab.recording.bounds import place_mm
from stereo_lab.recording.importing import camera_facts
from stereo_lab.recording.model import pictures_in

LOCK = ".recorder"
ASIDE = "aside"  # halves of pairs whose other half was never written
COLUMNS = "name", "x_mm", "y_mm", "depth_mm", "use"
BOARDS = "calibration"
WRITTEN_S = 0.2  # so long at most a lock is there and names nobody yet
SAME_S = 2.0  # so exactly a system tells when a process began


class Folder:
    """A recording that grows.

    Each picture is written whole or not at all, the right one of a pair first: a left one without its other half cannot be.
    One recorder at a time: a second one is refused while the first one lives.

    Parameters
    ----------
    path : folder; made where it is not there, carried on where it is
    size : (width, height), px
    board : Board
    ball : Ball

    Raises
    ------
    RecordingError
        If another recorder is at work in it, what is there is of other cameras or another board, or it cannot be written to.
    """

    def __init__(self, path: str | Path, size: tuple[int, int], board: Board, ball: Ball) -> None:
        self.path, self.size, self.ball = Path(path), size, ball
        self._check_what_is_there(board)
        self._locked = False
        self._lock()
        try:
            if not (self.path / "recording.json").exists():
                write_json(self.path / "recording.json", camera_facts(self.path.name, size, board, ball))
            self._put_halves_aside()
        except OSError as error:
            self.close()
            raise RecordingError(f"Cannot write in {self.path}: {error.strerror or error}.") from None
        except StereoLabError as error:
            self.close()
            raise RecordingError(str(error)) from None

    def _check_what_is_there(self, board):
        if not (self.path / "recording.json").exists():
            if self.path.exists() and (not self.path.is_dir() or any(p.name != LOCK for p in self.path.iterdir())):
                raise RecordingError(f"{self.path} is there and is no recording. Name a folder that is new.")
            return
        there = open_recording(self.path)
        if there.board != board:
            raise RecordingError(
                f"{self.path} was begun with a {there.board}, squares of {there.board.square_mm:g} mm; "
                f"this is a {board}, of {board.square_mm:g} mm. Name another folder."
            )
        if tuple(there.image_size) != tuple(self.size):
            wide, high = there.image_size
            raise RecordingError(
                f"{self.path} was begun with pictures of {wide}x{high}; these are {self.size[0]}x{self.size[1]}. "
                "Name another folder."
            )

    def _lock(self):
        """A file that names this process; one that a dead process left behind is taken over."""
        import psutil

        lock, me = self.path / LOCK, psutil.Process()
        try:
            self.path.mkdir(parents=True, exist_ok=True)
            for _ in range(2):
                try:
                    with open(lock, "x", encoding="ascii") as file:
                        file.write(f"{me.pid} {me.create_time():.3f}")
                    self._locked = True
                    return
                except FileExistsError:
                    if _is_held(lock):
                        break
                    lock.unlink(missing_ok=True)
        except OSError as error:
            raise RecordingError(f"Cannot write in {self.path}: {error.strerror or error}.") from None
        raise RecordingError(f"Another recorder is at work in {self.path}. End it, or name another folder.")

    def _put_halves_aside(self):
        """Right pictures whose left one was not written any more go into a folder of their own."""
        for folder in [right.parent for right in self.path.glob("*/right")]:
            whole = pictures_in(folder / "left")
            for name, right in pictures_in(folder / "right").items():
                if name not in whole:
                    aside = self.path / ASIDE / f"{folder.name}_{right.name}"
                    aside.parent.mkdir(exist_ok=True)
                    right.replace(aside)

    def close(self) -> None:
        """Let the folder go; more than once does no harm."""
        if self._locked:
            self._locked = False
            with contextlib.suppress(OSError):
                (self.path / LOCK).unlink()

    def names(self, set_name: str) -> list[str]:
        """Names of the pairs of one set, in their order."""
        return list(pictures_in(self.path / set_name / "left"))

    def add_pair(self, set_name: str, left: np.ndarray, right: np.ndarray) -> str:
        """Write a pair; returns its name.

        Raises
        ------
        StereoLabError
            If the disk is full or the folder is gone; nothing is written then.
        """
        if not (self.path / "recording.json").exists():
            raise StereoLabError(f"{self.path} is gone, or its recording.json is. Begin a new recording.")
        name = self._next_name(set_name)
        files = [self.path / set_name / side / f"{name}.png" for side in ("right", "left")]
        written: list[Path] = []
        try:
            for file, image in zip(files, (right, left), strict=True):
                write_whole(file, cv2.imencode(".png", image)[1].tobytes())
                written.append(file)
        except StereoLabError:
            for file in written:
                with contextlib.suppress(OSError):
                    file.unlink()
            raise
        return name

    def _next_name(self, set_name):
        numbers = [int(name) for name in self.names(set_name) if name.isdecimal()]
        return f"{max(numbers, default=-1) + 1:03d}"

    def add_sample(
        self, set_name: str, left: np.ndarray, right: np.ndarray, place: tuple[float, float, float], use: str = ""
    ) -> str:
        """Write a pair with the ball at a measured place: (x, y, depth), mm; returns its name.

        The table is written last and whole: a pair without its line is passed over when it is read.

        Raises
        ------
        StereoLabError
            If a number fits into no room, the table that is there cannot be used, or nothing can be written.
        """
        numbers = [place_mm(value, f"{set_name}, {what}") for value, what in zip(place, COLUMNS[1:4], strict=True)]
        if numbers[2] <= 0:
            raise StereoLabError(
                f"{set_name}, depth_mm: expected a depth above 0, before the cameras; got {numbers[2]:g}."
            )
        table, name = self.path / set_name / "measured.csv", self._next_name(set_name)
        row = dict(zip(COLUMNS, (name, *(f"{number:g}" for number in numbers), use), strict=True))
        lines = with_row(table, COLUMNS if use or not table.exists() else COLUMNS[:4], row)
        self.add_pair(set_name, left, right)
        write_whole(table, lines)
        return name

    def recording(self) -> Recording:
        """What was recorded so far."""
        return open_recording(self.path)

    def __enter__(self) -> Folder:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def _is_held(lock):
    """Whether the process that a lock names is at work; after a restart its number may be another's, who began later."""
    import psutil

    try:
        words = lock.read_text(encoding="ascii").split()
        if not words:  # another recorder may be about to write
            time.sleep(WRITTEN_S)
            words = lock.read_text(encoding="ascii").split()
        number, began = int(words[0]), float(words[1])
        return abs(psutil.Process(number).create_time() - began) < SAME_S
    except (OSError, ValueError, IndexError, psutil.Error):
        return False

"""Where pictures come from while they are looked at: a recording, or two cameras. Both look the same to every cell."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from dataclasses import dataclass
from numbers import Real
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from stereo_lab.errors import StereoLabError
from stereo_lab.recording import Recording, StereoPair, open_recording
from stereo_lab.recording.model import must_be_recording

if TYPE_CHECKING:
    from stereo_lab.arm import Arm

LEAST_HZ, MOST_HZ = 0.1, 1000.0  # pairs a second
FILM = "track"  # the set of a recording whose pictures follow one another
VGA = 640, 480  # px, what cameras are asked for where no recording tells


@dataclass(frozen=True, eq=False)
class Frame:
    """One pair of pictures, as it came.

    Attributes
    ----------
    time_s : float, when it was taken; of a real camera, when it came, by the source's clock
    left, right : ndarray, (height, width, 3), BGR uint8
    skew_s : float, how much later the right picture was taken than the left one
    dropped : int, pairs that were lost since the frame before, or that nobody fetched in time
    """

    time_s: float
    left: np.ndarray
    right: np.ndarray
    skew_s: float = 0.0
    dropped: int = 0

    def __iter__(self) -> Iterator[Any]:
        """Its time and both pictures, as in ``for time_s, left, right in source``."""
        return iter((self.time_s, self.left, self.right))


class StereoSource(AbstractContextManager["StereoSource"]):
    """What every cell asks of a source of pictures; it is closed by ``with``, and gives its frames to a ``for``.

    Attributes
    ----------
    name : str
    size : (width, height), px
    rate_hz : float, how many pairs it gives a second
    """

    name: str
    size: tuple[int, int]
    rate_hz: float

    def read(self) -> Frame | None:
        """The next pair; None where there are no more."""
        raise NotImplementedError

    def now(self) -> float:
        """The time by the clock of its frames, seconds: a frame is ``now() - frame.time_s`` old."""
        raise NotImplementedError

    def close(self) -> None:
        """Let go of what it holds."""
        raise NotImplementedError

    def __iter__(self) -> Iterator[Frame]:
        while (frame := self.read()) is not None:
            yield frame

    def __exit__(self, *_: object) -> None:
        self.close()


class Pace:
    """Gives pictures out at a rate, as cameras do: who comes late gets the newest one.

    Parameters
    ----------
    rate_hz : float
    clock, sleep : function, seconds and waiting for some
    """

    def __init__(self, rate_hz: float, clock: Callable[[], float], sleep: Callable[[float], None]) -> None:
        self.rate_hz, self._clock, self._sleep = rate_hz, clock, sleep
        self._start: float | None = None

    def due(self, number: int) -> int:
        """Wait for the picture of a number, counted from 0; the number of the newest one, where that is over."""
        now = self._clock()
        self._start = now if self._start is None else self._start
        newest = int((now - self._start) * self.rate_hz)
        if newest < number:
            self._sleep(number / self.rate_hz - (now - self._start))
        return max(newest, number)

    def now(self) -> float:
        """Seconds since the first picture was due."""
        return 0.0 if self._start is None else self._clock() - self._start


class RecordingSource(StereoSource):
    """The film of a recording: the pictures that follow one another.

    At its own rate it behaves as cameras do: who comes late gets the newest pair, and the others are dropped.

    Parameters
    ----------
    recording : Recording
    set_name : str, optional, the set to show; else the film, or where there is none the largest set with the ball in it,
        whose pictures do not follow one another
    fast : bool, every pair, one after the other, as fast as they are asked for
    clock, sleep : function, seconds and waiting for some

    Raises
    ------
    StereoLabError
        If the recording has no such set, or only left pictures in it.
    """

    def __init__(
        self,
        recording: Recording,
        set_name: str | None = None,
        fast: bool = False,
        clock: Callable[[], float] = time.monotonic,
        sleep: Callable[[float], None] = time.sleep,
    ) -> None:
        set_name = _film(recording) if set_name is None else set_name
        self.name, self.size, self.rate_hz = f"{recording.name}, {set_name}", recording.image_size, recording.frame_rate
        self.recording = recording
        self.pairs = recording.pairs(set_name)
        alone = [pair.name for pair in self.pairs if pair.right_path is None]
        if alone:
            raise StereoLabError(f"{self.name}: expected pairs, but {alone[0]} has no right picture.")
        self._pace = None if fast else Pace(self.rate_hz, clock, sleep)
        self._next, self._closed = 0, False

    def read(self) -> Frame | None:
        """The next pair, when it is due; None after the last one."""
        if self._closed:
            return None
        newest = self._next if self._pace is None else min(self._pace.due(self._next), len(self.pairs))
        dropped, self._next = newest - self._next, newest + 1
        if self._closed or newest >= len(self.pairs):
            return None
        pair = self.pairs[newest]
        return Frame(newest / self.rate_hz, pair.left, pair.right, dropped=dropped)

    def now(self) -> float:
        """The time by the clock of its frames, seconds; where it goes as fast as it can, that of the newest one."""
        return max(self._next - 1, 0) / self.rate_hz if self._pace is None else self._pace.now()

    def close(self) -> None:
        """No more pairs come."""
        self._closed = True


def _film(recording):
    """The set whose pictures follow one another, or the one that comes nearest to it."""
    if FILM in recording.sets:
        return FILM
    paired = [name for name in recording.ball_sets if all(pair.right_path for pair in recording.pairs(name))]
    if not paired:
        raise StereoLabError(
            f"{recording.name} has no pairs of a ball to look at: a set named {FILM}, taken in one go, is best."
        )
    return max(paired, key=lambda name: len(recording.pairs(name)))


def check_rate(rate_hz: float) -> None:
    """Refuse a rate that no camera has."""
    if not isinstance(rate_hz, Real):
        raise StereoLabError(f"Expected a number of pairs a second; got {rate_hz!r}.")
    if not LEAST_HZ <= rate_hz <= MOST_HZ:  # refuses NaN as well
        raise StereoLabError(f"Expected {LEAST_HZ:g} to {MOST_HZ:g} pairs a second; got {rate_hz:g}.")


def open_source(
    name: str | Path = "bench",
    size: tuple[int, int] | None = None,
    rate_hz: float = 30.0,
    fast: bool = False,
    recording: Recording | None = None,
    arm: Arm | None = None,
    late: int = 0,
) -> StereoSource:
    """Pictures as they come: of a recording, of two cameras, or of the virtual bench.

    Parameters
    ----------
    name : str or Path
        A recording's name or folder; or ``cameras:0,1``, the numbers of the left and the right camera, or the
        addresses that OpenCV opens as such; or ``virtual``, ``virtual:NAME`` for the bench of another recording.
    size : (width, height), px, what cameras are asked for; without it that of the recording, else 640 x 480
    rate_hz : float, pairs a second that cameras are asked for, or that are drawn
    fast : bool, every pair of a recording or of the virtual bench, as fast as they are asked for
    recording : Recording, optional, whose bench ``virtual`` is, and whose cameras ``cameras`` are
    arm : Arm, optional
        A virtual one is drawn on the virtual bench; where its time is its own, the bench keeps that time, too.
    late : int, so many pictures later the virtual bench hands a pair over, as webcams do

    Returns
    -------
    StereoSource
        Close it, or use it with ``with``.

    Raises
    ------
    StereoLabError
        If there is no such recording, a camera does not open, or the words cannot be understood.
    """
    from stereo_lab.live.bench import VirtualBench
    from stereo_lab.live.cameras import CameraSource

    check_rate(rate_hz)
    if not isinstance(name, str | os.PathLike | None) or name == "":
        raise StereoLabError(
            f'Expected the name of a recording, "virtual", or two cameras as in "cameras:0,1"; got {name!r}.'
        )
    if recording is not None:
        must_be_recording(recording)
    words = str(name)
    kind, _, rest = words.partition(":")
    if kind == "virtual":
        recording = open_recording(rest or None) if rest or recording is None else recording
        if arm is None or not hasattr(arm.port, "link_deg"):
            return VirtualBench(recording, None, rate_hz, fast, late)
        if arm.port.follows_the_clock:
            return VirtualBench(recording, arm.port, rate_hz, fast, late)
        return VirtualBench(recording, arm.port, rate_hz, fast, late, clock=arm.line.clock, sleep=arm.line.listen)
    if kind != "cameras" or ":" not in words:
        return RecordingSource(open_recording(name), fast=fast)
    sides = [side.strip() for side in rest.split(",")]
    if len(sides) != 2 or not all(sides) or sides[0] == sides[1]:
        raise StereoLabError(f"Expected two different cameras, as in cameras:0,1; got {words!r}.")
    left, right = (int(side) if side.isdecimal() else side for side in sides)
    return CameraSource(left, right, size or (VGA if recording is None else recording.image_size), rate_hz)


def stage_of(name: str, recording: Recording) -> Recording:
    """The recording that knows the cameras of a source.

    Parameters
    ----------
    name : str, as :func:`open_source` takes it
    recording : Recording, the one in use

    Returns
    -------
    Recording
        For the virtual bench the shipped one, where the one in use was taken with real cameras: nobody knows what those would see.

    Raises
    ------
    StereoLabError
        If the cameras are real and the recording is rendered: an arm would be sent where its calibration says.
    """
    if name.startswith("cameras:") and "cameras" in recording.truth:
        raise StereoLabError(
            f"{recording.name} is rendered: its calibration is not that of your cameras. Open your recording."
        )
    if name != "virtual" or "cameras" in recording.truth:
        return recording
    return open_recording("bench")


def look(name: str, recording: Recording, pair: StereoPair) -> Frame:
    """One pair of pictures, from wherever a lesson is told to take it.

    Parameters
    ----------
    name : str
        "recording": ``pair`` itself; "virtual": the recording's bench, drawn now; "cameras:0,1": two cameras.
    recording : Recording, whose cameras they are
    pair : StereoPair of it; where the left camera was alone, its picture stands in for the right one as well

    Raises
    ------
    StereoLabError
        If a camera does not open, or nobody knows what the recording's cameras would see.
    """
    if name == "recording":
        return Frame(0.0, pair.left, pair.left if pair.right_path is None else pair.right)
    if name != "virtual" and not name.startswith("cameras:"):
        raise StereoLabError(f'Expected "recording", "virtual" or "cameras:0,1"; got {name!r}.')
    with open_source(name, recording=recording) as source:
        frame = source.read()
    if frame is None:
        raise StereoLabError(f"{name} gave no pictures.")
    return frame

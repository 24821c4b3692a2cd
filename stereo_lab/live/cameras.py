"""Two cameras that never wait for each other: each is read in a thread of its own, and pairs are matched by time."""

from __future__ import annotations

import contextlib
import threading
import time
from collections import deque
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from stereo_lab.errors import StereoLabError
from stereo_lab.live.sources import LEAST_HZ, MOST_HZ, Frame, StereoSource, check_rate

KEPT = 4  # pictures of a side that may still find their other half; older ones are dropped
SILENT_S = 2.0  # so long without a pair is told
AGAIN_S = 1.0  # a camera that went away is opened again so often
BLACK = 8  # grey levels: a picture without a brighter pixel is black
WHITE = 250  # grey levels: what is overexposed is plain, too
TAIL = 8  # rows: so many alike at the end are what a cut-off picture is filled up with
JOIN_S = 1.0
LOCK_S = 3.0  # so long drivers have to hold what they are asked to hold
LOCKS = {  # what a camera does by itself, what switches that off, and the value that it found
    "focus": (cv2.CAP_PROP_AUTOFOCUS, 0, cv2.CAP_PROP_FOCUS),
    "exposure": (cv2.CAP_PROP_AUTO_EXPOSURE, 1, cv2.CAP_PROP_EXPOSURE),  # 1 is by hand, in Video4Linux and on Windows
    "white balance": (cv2.CAP_PROP_AUTO_WB, 0, cv2.CAP_PROP_WB_TEMPERATURE),
}


class CameraSource(StereoSource):
    """Two cameras, by their numbers or addresses; or two films, which run as fast as they were taken and end the source.

    The newest pair wins: what nobody fetched in time is dropped and counted, and no queue grows. Black pictures and
    pictures that were cut off on their way are passed over. A camera that goes away is opened again as long as the source
    is open; meanwhile :meth:`read` says which one is silent, and may be called again.

    Parameters
    ----------
    left, right : int or str, as ``cv2.VideoCapture`` takes them
    size : (width, height), px, what they are asked for
    rate_hz : float, pairs a second that they are asked for
    open_capture : function, in place of ``cv2.VideoCapture``
    silent_s : float, so long :meth:`read` waits for a pair
    clock : function, what the pictures' times are told by, seconds

    Raises
    ------
    StereoLabError
        If one of them does not open, or the rate makes no sense.
    """

    def __init__(
        self,
        left: int | str,
        right: int | str,
        size: tuple[int, int] = (640, 480),
        rate_hz: float = 30.0,
        open_capture: Callable[..., Any] = cv2.VideoCapture,
        silent_s: float = SILENT_S,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self.name, self.size, self.rate_hz, self.silent_s = f"cameras:{left},{right}", size, rate_hz, silent_s
        check_rate(rate_hz)
        self._news, self._clock = threading.Condition(), clock
        self._sides: list[_Side] = []
        try:
            for word, number in (("left", left), ("right", right)):
                self._sides.append(_Side(word, number, size, rate_hz, open_capture, self._news, clock))
        except BaseException:
            self.close()
            raise
        for side in self._sides:
            side.thread.start()

    def read(self) -> Frame | None:
        """The newest pair that nobody had yet; None once the source is closed.

        Raises
        ------
        StereoLabError
            If none comes for a while: which camera is silent, and why as far as it is known.
        """
        give_up = time.monotonic() + self.silent_s
        with self._news:
            while not any(side.stopped for side in self._sides):
                if (pair := self._match()) is not None:
                    return pair
                if not self._news.wait(max(0.0, give_up - time.monotonic())):
                    raise StereoLabError(self._who_is_silent())
        return None

    def _match(self):
        """The newest left picture with the right one that is nearest in time, within half a frame of each other."""
        left, right = self._sides
        for time_s, picture in reversed(left.taken):
            other_s, other = min(right.taken, key=lambda taken: abs(taken[0] - time_s), default=(float("inf"), None))
            if abs(other_s - time_s) <= 0.5 / self.rate_hz:
                dropped = left.give(time_s) - 1
                right.give(other_s)
                return Frame(time_s, picture, other, other_s - time_s, dropped)
        return None

    def _who_is_silent(self):
        said = [side.words() for side in self._sides]
        if not any(said):
            skew = abs(self._sides[0].taken[-1][0] - self._sides[1].taken[-1][0])
            return (
                f"No two pictures were taken at the same time for {self.silent_s:g} s: the cameras are {1000 * skew:.0f} ms "
                f"apart, half a frame is {500 / self.rate_hz:.0f}. Ask for fewer pairs a second."
            )
        return " ".join(words for words in said if words)

    def now(self) -> float:
        """The time by the clock of its frames, seconds."""
        return self._clock()

    def lock(self) -> list[str]:
        """Hold focus, exposure and white balance as they are now, where the drivers can; sentences on what could not be held."""
        with self._news:
            for side in self._sides:
                side.lock_asked, side.locks = True, {}
            self._news.wait_for(lambda: all(side.locks or side.stopped for side in self._sides), LOCK_S)
            return [words for side in self._sides if (words := side.loose())]

    def close(self) -> None:
        """Let both cameras go."""
        for side in self._sides:
            side.stop()
        for side in self._sides:
            side.end()


class _Side:
    """One camera and its thread.

    Attributes
    ----------
    taken : deque of (seconds, picture) that nobody had yet, the newest last
    trouble : str, what is wrong with it now, in words; empty where nothing is
    """

    def __init__(self, word, number, size, rate_hz, open_capture, news, clock):
        self.word, self.number, self.size, self.rate_hz = word, number, size, rate_hz
        self._open_capture, self._news, self._clock = open_capture, news, clock
        self.taken: deque[tuple[float, np.ndarray]] = deque(maxlen=KEPT)
        self.trouble, self.stopped, self.passed_over = "", False, 0
        self.lock_asked, self.locks = False, {}
        self._capture = self._open()
        if self._capture is None:
            if Path(str(number)).suffix and "://" not in str(number):
                raise StereoLabError(
                    f"{number} ({word}) does not open: there is no such file, or it is no film that can be read."
                )
            raise StereoLabError(
                f"Camera {number} ({word}) does not open. Is it plugged in, and does no other program use it? "
                "Cameras are counted from 0; one that is built into the computer is one of them."
            )
        self._film_hz = _film_hz(number, self._capture, rate_hz)
        self.thread = threading.Thread(target=self._run, name=f"camera {word}", daemon=True)

    def _open(self):
        capture = self._open_capture(self.number)
        if not capture.isOpened():
            capture.release()
            return None
        for what, value in (
            (cv2.CAP_PROP_FRAME_WIDTH, self.size[0]), (cv2.CAP_PROP_FRAME_HEIGHT, self.size[1]), (cv2.CAP_PROP_FPS, self.rate_hz),
        ):  # fmt: skip
            capture.set(what, value)
        return capture

    def _run(self):
        began, count = self._clock(), 0
        while not self.stopped:
            try:
                picture = self._next_picture()
            except Exception:  # whatever a driver raises, the camera is opened again
                picture = None
            now = self._clock()
            if picture is not None:
                self._take(now, picture)
                count += 1
                if self._film_hz:
                    self._sleep(began + count / self._film_hz - self._clock())
                continue
            if self._film_hz and count:
                self.stop()
                break
            self._trouble("gave no picture and was let go; it is opened again every second. Is it plugged in?")
            self._let_go()
            self._sleep(AGAIN_S)
        self._let_go()

    def _next_picture(self):
        """What the camera gives next, opened again and held where that is asked for; None where it gives nothing."""
        if self._capture is None:
            self._capture = self._open()
            self.lock_asked = self.lock_asked or bool(self.locks)  # plugged in again, it decides by itself again
            if self._capture is None:
                return None
        if self.lock_asked:
            self._lock()
        good, picture = self._capture.read()
        return picture if good else None

    def _let_go(self):
        if self._capture is not None:
            with contextlib.suppress(Exception):  # as above
                self._capture.release()
        self._capture = None

    def _lock(self):
        """Switch what the camera does by itself off, and keep the value that it had found."""
        held = {}
        for name, (automatic, off, value) in LOCKS.items():
            found = self._capture.get(value)
            self._capture.set(automatic, off)
            self._capture.set(value, found)
            held[name] = self._capture.get(automatic) == off
        with self._news:
            self.lock_asked, self.locks = False, held
            self._news.notify_all()

    def _take(self, now, picture):
        with self._news:
            wrong = what_is_wrong(picture, self.size)
            if wrong:
                self.trouble, self.passed_over = wrong, self.passed_over + 1
            else:
                self.trouble = ""
                self.passed_over += len(self.taken) == KEPT  # the oldest one gives way
                self.taken.append((now, picture))
            self._news.notify_all()

    def _trouble(self, words):
        with self._news:
            self.trouble = words
            self._news.notify_all()

    def _sleep(self, seconds):
        with self._news:
            self._news.wait_for(lambda: self.stopped, seconds)

    def give(self, time_s):
        """Let go of the picture of that time and of all before it: how many, with those that were passed over since the last time."""
        count, self.passed_over = self.passed_over, 0
        while self.taken and self.taken[0][0] <= time_s:
            self.taken.popleft()
            count += 1
        return count

    def loose(self):
        """What it does not hold, in words; empty where it holds all, and for a film."""
        if self._film_hz:
            return ""
        names = [name for name, held in self.locks.items() if not held] if self.locks else list(LOCKS)
        if not names:
            return ""
        refused = "does not let its" if self.locks else f"has not said within {LOCK_S:g} s that it lets its"
        return f"The {self.word} camera ({self.number}) {refused} {' and '.join(names)} be held: leave lamps and cameras as they are."

    def words(self):
        """Why nothing new comes from it; empty where something does."""
        if self.trouble:
            return f"The {self.word} camera ({self.number}) {self.trouble}"
        if not self.taken:
            return (
                f"The {self.word} camera ({self.number}) is open and gives no pictures. Unplug it and plug it in again."
            )
        return ""

    def stop(self):
        with self._news:
            self.stopped = True
            self._news.notify_all()

    def end(self):
        """Wait for the thread; one that hangs in its driver dies with the program."""
        if self.thread.is_alive():
            self.thread.join(JOIN_S)
        elif self._capture is not None:  # it never ran
            self._capture.release()


def _film_hz(number, capture, rate_hz):
    """Pictures a second of a film that a capture reads, as it says or as it is asked for; 0 where it is a camera."""
    if not (isinstance(number, str) and Path(number).is_file()):
        return 0.0
    told = capture.get(cv2.CAP_PROP_FPS)
    return told if LEAST_HZ <= told <= MOST_HZ else rate_hz


def what_is_wrong(picture: np.ndarray, size: tuple[int, int]) -> str:
    """What makes a picture useless, in words; empty where nothing does.

    Parameters
    ----------
    picture : ndarray, BGR uint8
    size : (width, height), px, what it should have
    """
    wide, high = picture.shape[1::-1]
    if (wide, high) != tuple(size):
        return f"gives pictures of {wide}x{high} instead of {size[0]}x{size[1]}. Ask for that size, as with record --size {wide}x{high}, or calibrate these cameras at it."
    if picture.max() < BLACK:
        return "gives black pictures. Is its lens covered?"
    if (picture[-TAIL:] == picture[-1, -1]).all() and picture[-1, -1].max() < WHITE:
        if shown := _rows_between_bars(picture):
            return f"gives pictures with a plain bar above and below: wide ones are filled up to the size that was asked for. Ask for another size, as with record --size {wide}x{shown}."
        return "gives pictures that end in plain rows: they are cut off on their way. Try another cable or port, or fewer pairs a second."
    return ""


def _rows_between_bars(picture):
    """Rows between two bars alike, of the colour in which a picture ends; 0 where it has no such bar above as well."""
    off = np.abs(picture.astype(float) - picture[-1, -1]).mean(axis=(1, 2))  # a mean: JPEG smears a bar's edge
    shown = np.flatnonzero(off > BLACK)
    if not len(shown):
        return 0
    above, below = shown[0], len(picture) - 1 - shown[-1]
    return len(picture) - above - below if above >= TAIL and abs(above - below) <= TAIL else 0

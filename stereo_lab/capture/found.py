"""Which cameras this computer has: what opens, what it gives, and which of two is the left one."""

from __future__ import annotations

import contextlib
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from stereo_lab.errors import StereoLabError

MOST = 10  # numbers that are tried
SIZES = ((640, 480), (1280, 720), (1920, 1080))
LOOK_S, PATIENCE_S = 1.0, 5.0  # a rate is measured for so long; so long an answer is waited for
COVERED = 0.4  # of its light before: so dark is a lens under a hand
OTHERS = 0.8  # the others keep at least so much
SYSTEM, BY_PATH = Path("/sys/class/video4linux"), Path("/dev/v4l/by-path")


@dataclass(frozen=True)
class Camera:
    """A camera that opens.

    Attributes
    ----------
    number : int, as OpenCV counts them, from 0
    name : str, as the system calls it; empty where it does not tell
    port : str, the USB port that it hangs on; the same camera in the same port keeps it. Linux only
    sizes : tuple of (width, height), px, that it gives when it is asked for them
    rate_hz : float, pictures a second at the first of them, measured; 0 where no picture comes
    """

    number: int
    name: str
    port: str
    sizes: tuple[tuple[int, int], ...]
    rate_hz: float


def find_cameras(
    open_capture: Callable[[int], Any] = cv2.VideoCapture,
    most: int = MOST,
    look_s: float = LOOK_S,
    patience_s: float = PATIENCE_S,
) -> list[Camera]:
    """Try all numbers, and tell what opens.

    Parameters
    ----------
    open_capture : function, in place of ``cv2.VideoCapture``
    most : int, how many numbers are tried, from 0
    look_s : float, so long each is looked at
    patience_s : float, so much longer an answer of its driver is waited for
    """
    with _without_warnings():
        found = [_look_in_time(number, open_capture, look_s, patience_s) for number in range(most)]
    return [camera for camera in found if camera is not None]


def which_is_covered(
    numbers: Sequence[int],
    open_capture: Callable[[int], Any] = cv2.VideoCapture,
    seconds: float = 30.0,
    clock: Callable[[], float] = time.monotonic,
) -> int:
    """The number of the camera whose lens somebody covers with a hand.

    Parameters
    ----------
    numbers : sequence of int, the cameras to watch
    open_capture : function, in place of ``cv2.VideoCapture``
    seconds : float, so long it waits

    Raises
    ------
    StereoLabError
        If a camera does not open or gives no picture, or no lens is covered in time.
    """
    captures = {}
    try:
        with _without_warnings():
            for number in numbers:
                captures[number] = open_capture(number)
                if not captures[number].isOpened():
                    raise StereoLabError(f"Camera {number} does not open. Does another program use it?")
        before = {number: max(_light(number, capture) for _ in range(10)) for number, capture in captures.items()}
        until = clock() + seconds
        while clock() < until:
            part = {number: _light(number, capture) / max(before[number], 1.0) for number, capture in captures.items()}
            dark = [number for number, light in part.items() if light < COVERED]
            if len(dark) == 1 and all(light > OTHERS for number, light in part.items() if number not in dark):
                return dark[0]
    finally:
        for capture in captures.values():
            capture.release()
    raise StereoLabError(
        f"No lens was covered for {seconds:.0f} s. Lay a hand flat on the lens, and leave the other one free."
    )


def _light(number, capture):
    good, picture = capture.read()
    if not good or picture is None:
        raise StereoLabError(f"Camera {number} gives no picture. Unplug it and plug it in again.")
    return float(np.mean(picture))


def _look_in_time(number, open_capture, look_s, patience_s):
    """The same as :func:`_look`; of a driver that hangs nothing is known, and its thread ends when it does."""
    told = [Camera(number, *_told_by_system(number), (), 0.0)]
    looks = threading.Thread(target=lambda: told.append(_look(number, open_capture, look_s)), daemon=True)
    looks.start()
    looks.join(look_s + patience_s)
    return told[-1]


def _look(number, open_capture, look_s):
    """A camera, or None where nothing opens."""
    capture = open_capture(number)
    try:
        if not capture.isOpened():
            return None
        sizes = tuple(size for size in SIZES if _gives(capture, size))
        if sizes:
            _ask(capture, sizes[0])
        return Camera(number, *_told_by_system(number), sizes, _rate(capture, look_s) if sizes else 0.0)
    finally:
        capture.release()


def _ask(capture, size):
    capture.set(cv2.CAP_PROP_FRAME_WIDTH, size[0])
    capture.set(cv2.CAP_PROP_FRAME_HEIGHT, size[1])


def _gives(capture, size):
    _ask(capture, size)
    good, picture = capture.read()
    return good and picture is not None and picture.shape[1::-1] == size


def _rate(capture, look_s):
    """Pictures a second, measured; the first one starts the clock."""
    capture.read()
    start, count = time.monotonic(), 0
    while (spent := time.monotonic() - start) < look_s:
        if not capture.read()[0]:
            break
        count += 1
    return count / spent if spent > 0 else 0.0


def _told_by_system(number):
    """Name and port, where Linux tells them."""
    name, port = "", ""
    with contextlib.suppress(OSError):
        name = (SYSTEM / f"video{number}" / "name").read_text(encoding="utf-8", errors="replace").strip()
    with contextlib.suppress(OSError):
        links = [link for link in sorted(BY_PATH.iterdir()) if link.resolve().name == f"video{number}"]
        port = links[0].name if links else ""
    return name, port


@contextlib.contextmanager
def _without_warnings() -> Iterator[None]:
    """OpenCV complains in the terminal of every number that is no camera."""
    before = cv2.utils.logging.getLogLevel()
    cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)
    try:
        yield
    finally:
        cv2.utils.logging.setLogLevel(before)

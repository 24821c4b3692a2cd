"""Videos, frame by frame (``cv2.VideoCapture``: any codec that OpenCV opens)."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np

from stereo_lab.common.files import check_plain
from stereo_lab.errors import RecordingError, StereoLabError

SUFFIXES = frozenset(
    {".mp4", ".m4v", ".mov", ".avi", ".mkv", ".webm", ".mpg", ".mpeg", ".wmv", ".ogv", ".3gp", ".mjpg"}
)


def is_video(path: str | Path) -> bool:
    """Whether a file's name says that it is a video."""
    return Path(path).suffix.lower() in SUFFIXES


def count_frames(path: str | Path) -> int:
    """How many frames a video says it has; 0 where it does not say."""
    capture = _opened(path)
    count = int(capture.get(cv2.CAP_PROP_FRAME_COUNT))
    capture.release()
    return max(0, count)


def read_video(path: str | Path) -> Iterator[np.ndarray]:
    """The frames of a video, BGR, one after the other.

    Raises
    ------
    RecordingError
        If the file is missing, no plain file, or no video that OpenCV can read.
    """
    return (frame for _, frame in read_timed(path))


def read_timed(path: str | Path) -> Iterator[tuple[float, np.ndarray]]:
    """The same with the time of each frame, seconds from the beginning: phones do not film at an even rate.

    A film that says how it was held is turned upright, as OpenCV does by itself.
    """
    capture = _opened(path)
    try:
        last_s, step_s = -np.inf, 1 / (capture.get(cv2.CAP_PROP_FPS) or 30.0)
        while True:
            there, frame = capture.read()
            if not there:
                break
            time_s = capture.get(cv2.CAP_PROP_POS_MSEC) / 1000
            last_s = time_s if time_s > last_s + 0.1 * step_s else last_s + step_s  # some files do not tell
            yield last_s, frame
        if last_s == -np.inf:
            raise RecordingError(f"{path} holds no frame that can be read. Save it again, as an .mp4 with H.264.")
    finally:
        capture.release()


def _opened(path):
    try:
        check_plain(path)
    except StereoLabError as error:
        raise RecordingError(str(error)) from None
    capture = cv2.VideoCapture(str(path))
    if not capture.isOpened():
        raise RecordingError(f"{path} is no video that OpenCV can read. Save it again, as an .mp4 with H.264.")
    return capture

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
    capture = _opened(path)
    try:
        there, frame = capture.read()
        if not there:
            raise RecordingError(f"{path} holds no frame that can be read. Save it again, as an .mp4 with H.264.")
        while there:
            yield frame
            there, frame = capture.read()
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

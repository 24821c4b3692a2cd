"""Two cameras at once (``cv2.VideoCapture``)."""

from __future__ import annotations

from types import TracebackType

import cv2
import numpy as np

from stereo_lab.errors import StereoLabError

OLD_FRAMES = 5  # what a driver may still hold from before


class CameraPair:
    """Two webcams, by their numbers; use it with ``with``.

    Parameters
    ----------
    left, right : int, as OpenCV counts them, from 0
    size : (width, height), px, what they are asked for

    Raises
    ------
    StereoLabError
        If one cannot be opened, or both are the same.
    """

    def __init__(self, left: int, right: int, size: tuple[int, int]) -> None:
        if left == right:
            raise StereoLabError(
                f"Expected two cameras, got number {left} for both. Cameras are counted from 0: give each its own number (at the terminal: --left and --right)."
            )
        self.size, self._captures = size, []
        for side, number in (("left", left), ("right", right)):
            capture = cv2.VideoCapture(number)
            self._captures.append(capture)
            if not capture.isOpened():
                self.close()
                raise StereoLabError(
                    f"Camera {number} ({side}) does not open. Is it plugged in, and does no other program use it? "
                    "Cameras are counted from 0; one that is built into the computer is one of them. Other numbers at the terminal: --left and --right."
                )
            capture.set(cv2.CAP_PROP_FRAME_WIDTH, size[0])
            capture.set(cv2.CAP_PROP_FRAME_HEIGHT, size[1])

    def read(self) -> tuple[np.ndarray, np.ndarray]:
        """The newest pair: left and right picture, BGR.

        Raises
        ------
        StereoLabError
            If a camera gives no picture, or one of another size than asked for.
        """
        for _ in range(OLD_FRAMES):
            for capture in self._captures:
                capture.grab()
        pictures = []
        for side, capture in zip(("left", "right"), self._captures, strict=True):
            good, picture = capture.read()
            if not good or picture is None:
                raise StereoLabError(f"The {side} camera gave no picture. Was it unplugged?")
            if picture.shape[1::-1] != tuple(self.size):
                wide, high = picture.shape[1::-1]
                raise StereoLabError(
                    f"The {side} camera gives {wide}x{high}, the recording has {self.size[0]}x{self.size[1]}: take a recording with these cameras."
                )
            pictures.append(picture)
        return pictures[0], pictures[1]

    def close(self) -> None:
        """Let the cameras go."""
        for capture in self._captures:
            capture.release()

    def __enter__(self) -> CameraPair:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

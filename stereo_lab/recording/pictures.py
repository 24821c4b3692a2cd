"""Reading pictures, with a plain sentence for every one that cannot be used."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np

from stereo_lab.errors import RecordingError

PICTURES = (".jpg", ".jpeg", ".png")


def read_image(path: str | Path, grey_allowed: bool = False) -> np.ndarray:
    """Read one picture as BGR, shape (height, width, 3), uint8.

    Raises
    ------
    RecordingError
        If the file is missing, broken or cut short, grey (unless allowed) or not 8 bits a channel.
    """
    path = Path(path)
    try:
        data = path.read_bytes()
    except OSError as error:
        raise RecordingError(f"Cannot read the picture {path}: {error.strerror or error}.") from None
    image = None
    if not _is_cut_short(data):
        image = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED) if data else None
    if image is None:
        raise RecordingError(f"{path} is broken or cut short ({len(data)} bytes). Copy or take it again.")
    if image.dtype != np.uint8:
        raise RecordingError(
            f"{path} has {8 * image.itemsize} bits a channel; 8 are expected. Save it as a plain JPEG."
        )
    if image.ndim == 2 or image.shape[2] == 1:
        if not grey_allowed:
            raise RecordingError(
                f"{path} is a grey picture; the ball is found by its colour. Set the camera to colour."
            )
        image = cv2.cvtColor(image, cv2.COLOR_GRAY2BGR)
    return np.ascontiguousarray(image[..., :3])


def _is_cut_short(data):
    """True for a JPEG or PNG without its end mark: decoders fill in the rest with grey."""
    if data[:2] == b"\xff\xd8":
        return data.rfind(b"\xff\xd9") < data.rfind(b"\xff\xda")
    if data[:8] == b"\x89PNG\r\n\x1a\n":
        return b"IEND" not in data[-64:]
    return False

"""Reading pictures, with a plain sentence for every one that cannot be used."""

from __future__ import annotations

import io
import warnings
from pathlib import Path

import cv2
import numpy as np
from PIL import Image

from stereo_lab.common.files import read_bytes
from stereo_lab.errors import RecordingError, StereoLabError

PICTURES = (".jpg", ".jpeg", ".png")
HEADS = (b"\xff\xd8", b"\x89PNG", b"BM", b"RIFF", b"II", b"MM")  # how pictures begin
PHONES = {
    b"heic": "HEIC",
    b"heix": "HEIC",
    b"mif1": "HEIF",
    b"msf1": "HEIF",
    b"avif": "AVIF",
}  # by what their files begin with
AS_IT_IS = cv2.IMREAD_ANYDEPTH | cv2.IMREAD_ANYCOLOR  # turned upright by its EXIF, which IMREAD_UNCHANGED passes over
# Of 255: channels of a grey picture differ by less. It has so many steps of grey at least; one of fewer is dark, or blank
COLORLESS, GREYS = 8, 32
GLANCE_PX = 16  # most pictures show a colour in every so manieth pixel already
LARGEST_PICTURE = 100_000_000  # pixels; ten times those of a good camera, and 300 MB of memory


def without_ending(name: str) -> str:
    """The name of a picture, also where it is written as a file's."""
    return Path(name).stem if name.lower().endswith(PICTURES) else name


def read_image(path: str | Path, grey_allowed: bool = False) -> np.ndarray:
    """Read one picture as BGR, shape (height, width, 3), uint8, upright as EXIF says and every viewer shows it.

    Raises
    ------
    RecordingError
        If the file is missing, no plain file, broken or cut short, too large, grey (unless allowed) or not
        8 bits a channel.
    """
    try:
        data = read_bytes(path)
    except StereoLabError as error:
        raise RecordingError(str(error)) from None
    _check_size(path, data)
    image = _decode(data)
    if image is None:
        raise _broken(path, data)
    if image.dtype != np.uint8:
        raise RecordingError(
            f"{path} has {8 * image.itemsize} bits a channel; 8 are expected. Save it as a plain JPEG.",
            fault="picture_format",
        )
    one_channel = image.ndim == 2 or image.shape[2] == 1
    image = cv2.cvtColor(image, cv2.COLOR_GRAY2BGR) if one_channel else np.ascontiguousarray(image[..., :3])
    if not grey_allowed and (one_channel or is_colorless(image)):
        raise RecordingError(
            f"{path} is a grey picture; the ball is found by its colour. Set the camera to colour.",
            fault="picture_grey",
        )
    return image


def is_colorless(image: np.ndarray) -> bool:
    """Whether a BGR picture is a grey one, as a camera in black and white or in the dark saves it."""
    if np.ptp(image[::GLANCE_PX, ::GLANCE_PX], axis=2).max() >= COLORLESS:
        return False
    blue, green, red = cv2.split(image)
    apart = max(cv2.absdiff(blue, green).max(), cv2.absdiff(green, red).max())
    return bool(apart < COLORLESS and np.count_nonzero(np.bincount(green.ravel())) >= GREYS)


def _check_size(path, data):
    """Refuse a picture whose header promises more pixels than a camera has: decoding would take the memory."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # Pillow warns of large pictures; the limit here is the kit's own
            width, height = Image.open(io.BytesIO(data)).size  # reads the header alone
    except Image.DecompressionBombError:  # above Pillow's own limit, which is higher
        raise _too_large(path, "far more") from None
    except (OSError, ValueError):
        raise _broken(path, data) from None
    if width * height > LARGEST_PICTURE:
        raise _too_large(path, f"{width}x{height} pixels")


def _decode(data):
    """The picture as OpenCV reads it, or None where it cannot."""
    if _is_cut_short(data):
        return None
    try:
        return cv2.imdecode(np.frombuffer(data, np.uint8), AS_IT_IS)
    except cv2.error:
        return None


def _too_large(path, came):
    return RecordingError(
        f"{path} is too large: expected {LARGEST_PICTURE // 1_000_000} megapixels at most, got {came}. "
        "Take it again, smaller.",
        fault="picture_format",
    )


def _broken(path, data):
    if data[4:8] == b"ftyp" and data[8:12] in PHONES:
        return RecordingError(
            f'{path} is a {PHONES[data[8:12]]} picture, which cannot be read here. Set the phone to JPEG ("most compatible"), or '
            "save it again as JPEG.",
            fault="picture_format",
        )
    if data and not data.startswith(HEADS):
        return RecordingError(f"{path} is no picture that can be read: expected a .jpg or .png.")
    return RecordingError(f"{path} is broken or cut short ({len(data)} bytes). Copy or take it again.")


def _is_cut_short(data):
    """True for a JPEG or PNG without its end mark: decoders fill in the rest with grey."""
    if data[:2] == b"\xff\xd8":
        return data.rfind(b"\xff\xd9") < data.rfind(b"\xff\xda")
    if data[:8] == b"\x89PNG\r\n\x1a\n":
        return b"IEND" not in data[-64:]
    return False

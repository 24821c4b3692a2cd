"""What every way of finding a ball takes and gives: a picture in, a Detection out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stereo_lab.errors import StereoLabError

Camera = tuple[np.ndarray, np.ndarray]  # matrix (3, 3), and distortion as OpenCV orders it


@dataclass(frozen=True)
class Detection:
    """A ball in a picture.

    Attributes
    ----------
    u, v, radius_px : float, its centre and radius in pixels of that picture
    score : float, 0…1, how sure it is a ball
    """

    u: float
    v: float
    radius_px: float
    score: float

    @property
    def center_px(self) -> tuple[float, float]:
        """(u, v)."""
        return self.u, self.v


def check_image(image: np.ndarray) -> np.ndarray:
    """A BGR uint8 picture, or a plain error."""
    image = np.asarray(image)
    if image.ndim != 3 or image.shape[2] != 3 or image.dtype != np.uint8:
        raise StereoLabError(
            f"Expected a colour picture of shape (height, width, 3) and type uint8; got {image.shape} and {image.dtype}."
        )
    return image

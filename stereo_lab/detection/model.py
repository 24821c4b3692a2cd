"""What every way of finding a ball takes and gives: a picture in, a Detection out."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from stereo_lab.errors import StereoLabError

if TYPE_CHECKING:
    from stereo_lab.detection.cone import Cone

Camera = tuple[np.ndarray, np.ndarray]  # matrix (3, 3), and distortion as OpenCV orders it
Circle = tuple[float, float, float]  # (u, v, radius), px
USUAL_FOCAL = 1.0  # in longer sides of the picture: most webcams, where no camera is told


@dataclass(frozen=True)
class Detection:
    """A ball in a picture.

    Attributes
    ----------
    u, v, radius_px : float, where its centre is seen, and the radius that it would have in the middle of the picture, px;
        by the paper's way the radius that is seen
    score : float, 0…1: the probability that it is the ball; by the paper's way, which has none, its share of votes
    sigma_px, sigma_radius_px : float, standard deviations of the centre's u and of the radius; that of v is taken to be the
        same, and is larger where the rim is hidden above or below. None by the paper's way
    cone : Cone, the edge it was found by; None by the paper's way
    """

    u: float
    v: float
    radius_px: float
    score: float
    sigma_px: float | None = None
    sigma_radius_px: float | None = None
    cone: Cone | None = field(default=None, repr=False, compare=False)

    @property
    def center_px(self) -> tuple[float, float]:
        """(u, v)."""
        return self.u, self.v

    @property
    def outline_px(self) -> float:
        """How large it is seen: the radius of a circle that covers as much of the picture."""
        return self.radius_px if self.cone is None else self.cone.outline_px

    @property
    def smeared(self) -> bool:
        """Whether it moved while the shutter was open, or looks as if it had."""
        return self.cone is not None and self.cone.smeared


def check_image(image: np.ndarray) -> np.ndarray:
    """A BGR uint8 picture, or a plain error."""
    if isinstance(image, str | Path):
        raise StereoLabError(f"Expected a picture, got the path {str(image)!r}. Read it first: read_image(path).")
    image = np.asarray(image)
    if image.ndim != 3 or image.shape[2] != 3 or image.dtype != np.uint8 or 0 in image.shape:
        got = f"got {image.shape} and {image.dtype}" if image.ndim else "there is none; was its file found?"
        raise StereoLabError(f"Expected a colour picture of shape (height, width, 3) and type uint8; {got}.")
    return image


def usual_camera(shape: tuple[int, ...]) -> Camera:
    """A camera as wide as most webcams, for pictures of this shape, where no camera is told."""
    height, width = shape[:2]
    focal = USUAL_FOCAL * max(height, width)  # an upright picture is that of a camera lying on its side
    return np.array([[focal, 0, width / 2 - 0.5], [0, focal, height / 2 - 0.5], [0, 0, 1.0]]), np.zeros(5)

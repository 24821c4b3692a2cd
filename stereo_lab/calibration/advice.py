"""Where a calibration knows least, and so where the next boards belong."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stereo_lab.calibration.cameras import StereoCalibration
from stereo_lab.calibration.uncertainty import common_field, place_slopes, sigmas

FIELD = 25, 19  # places looked at, across and down
REACH = 0.25  # of the picture's width: so far round it a board helps
ROWS, COLUMNS = ("top", "middle", "bottom"), ("left", "middle", "right")


@dataclass(frozen=True, eq=False)
class Map:
    """What a calibration knows of depth over the left picture.

    Attributes
    ----------
    pixels : ndarray, shape (N, 2), places that both cameras see, px of the left picture
    sigma_mm : ndarray, shape (N,), standard deviation of depth there
    boards : ndarray of int, shape (N,), how many boards covered each place
    """

    pixels: np.ndarray
    sigma_mm: np.ndarray
    boards: np.ndarray


def depth_map(calibration: StereoCalibration, depth_mm: float | None = None) -> Map:
    """The map at one distance; the one of the verdict where none is given."""
    depth = depth_mm or calibration.depth_mm
    points, pixels = common_field(calibration.rig, calibration.image_size, depth, FIELD)
    if calibration.covariance is None:
        sigma = np.full(len(points), np.nan)
    else:
        sigma = sigmas(place_slopes(points, calibration.rig), calibration.covariance)[:, 2]
    return Map(pixels, sigma, calibration.boards_at(pixels, "left"))


def where_to_hold(calibration: StereoCalibration, count: int = 3) -> list[str]:
    """The parts of the left picture in which boards would help most, in words, the worst first."""
    known = depth_map(calibration)
    if not len(known.pixels) or np.isnan(known.sigma_mm).any():
        return []
    size = np.array(calibration.image_size)
    doubt, told = known.sigma_mm.copy(), []
    for _ in range(count):
        worst = known.pixels[doubt.argmax()]
        told.append(part_of_picture(worst, calibration.image_size))
        near = np.linalg.norm(known.pixels - worst, axis=1) / (REACH * size[0])
        doubt *= 1 - np.exp(-(near**2))
    return list(dict.fromkeys(told))


def part_of_picture(pixel: np.ndarray, image_size: tuple[int, int]) -> str:
    """Words such as top left, middle, bottom right."""
    column, row = (min(2, max(0, int(3 * p / s))) for p, s in zip(pixel, image_size, strict=True))
    words = [ROWS[row], COLUMNS[column]]
    return "middle" if words == ["middle", "middle"] else " ".join(w for w in words if w != "middle")

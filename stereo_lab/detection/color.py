"""The colour of a ball: HLS bounds for the paper's way, and a table of how ball-like a colour is for ours."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cache

import cv2
import numpy as np

from stereo_lab.errors import StereoLabError

BINS = 32  # the colour table has BINS steps a channel

# Hue in OpenCV's 0…179; red wraps round 0. Least lightness and saturation keep grey and black out.
HUES = {
    "red": ((172, 179), (0, 7)),
    "orange": ((8, 18),),
    "yellow": ((20, 34),),
    "green": ((40, 85),),
    "blue": ((98, 130),),
}
LIGHTNESS, SATURATION = (25, 235), (70, 255)


@dataclass(frozen=True, eq=False)
class BallColor:
    """A colour: HLS bounds for the paper's way, and a table BGR -> 0…255 (how ball-like) for ours.

    Attributes
    ----------
    name : str, "learned" for one from samples
    ranges : tuple of (lower, upper), each (H, L, S) as in OpenCV
    table : ndarray, shape (32, 32, 32), uint8, indexed by B, G, R divided by 8
    """

    name: str
    ranges: tuple[tuple[tuple[int, ...], tuple[int, ...]], ...]
    table: np.ndarray = field(repr=False)

    @classmethod
    def named(cls, name: str) -> BallColor:
        """One of red, orange, yellow, green, blue, in small letters or capitals.

        Raises
        ------
        StereoLabError
            For any other name.
        """
        known = str(name).strip().lower()
        if known not in HUES:
            raise StereoLabError(f"There is no colour {name!r}. Choose one of {', '.join(HUES)}.")
        ranges = tuple(
            ((low, LIGHTNESS[0], SATURATION[0]), (high, LIGHTNESS[1], SATURATION[1])) for low, high in HUES[known]
        )
        return cls(known, ranges, _table_from_hue(HUES[known]))

    @classmethod
    def from_samples(cls, images: Sequence[np.ndarray], circles: Sequence[Sequence[float]]) -> BallColor:
        """Learn a colour from a few pictures in which the ball is marked.

        The table tells, for every colour, which share of the pixels of that colour lies on a ball.

        Parameters
        ----------
        images : sequence of ndarray, BGR
        circles : sequence of (u, v, radius_px), one for each picture

        Returns
        -------
        BallColor

        Raises
        ------
        StereoLabError
            If there is no picture, or a circle lies outside its picture or fills it.
        """
        inside, outside = [], []
        for image, (u, v, radius) in zip(images, circles, strict=True):
            distance = np.hypot(*(np.indices(image.shape[:2])[::-1] - np.array([u, v])[:, None, None]))
            smooth = cv2.GaussianBlur(image, (0, 0), 1.0)
            if not (distance < 0.85 * radius).any():
                raise StereoLabError(f"The circle ({u:g}, {v:g}, {radius:g}) px lies outside its picture.")
            inside.append(smooth[distance < 0.85 * radius])
            outside.append(smooth[distance > 1.25 * radius])
        if not inside:
            raise StereoLabError("To learn a colour, mark the ball in one picture at least; three or four are better.")
        ball, rest = np.concatenate(inside), np.concatenate(outside)
        if not len(rest):
            raise StereoLabError(
                "The marked circles fill their pictures; the colour of what is round the ball is needed."
            )
        return cls("learned", _hls_ranges(ball), _table_from_pixels(ball, rest))

    def mask(self, image: np.ndarray) -> np.ndarray:
        """255 where the pixel lies between the paper's HLS bounds, else 0; shape (height, width)."""
        hls = cv2.cvtColor(image, cv2.COLOR_BGR2HLS)
        masks = [cv2.inRange(hls, np.array(low), np.array(high)) for low, high in self.ranges]
        return np.bitwise_or.reduce(masks)

    def likeness(self, image: np.ndarray) -> np.ndarray:
        """How ball-like each pixel's colour is, 0…255, shape (height, width)."""
        blue, green, red = (image[..., k].astype(np.uint16) >> 3 for k in range(3))
        return self.table.ravel()[(blue << 10) | (green << 5) | red]


def _bin_colors():
    """The middle of every bin as a picture of shape (BINS * BINS, BINS, 3), BGR."""
    steps = (np.arange(BINS) * (256 // BINS) + 128 // BINS).astype(np.uint8)
    grid = np.stack(np.meshgrid(steps, steps, steps, indexing="ij"), -1)
    return grid.reshape(BINS * BINS, BINS, 3)


@cache
def _table_from_hue(hues):
    """1 inside the hue range, falling off over 6 steps of hue; grey and black fall off as well."""
    colors = _bin_colors()
    hls = cv2.cvtColor(colors.astype(np.float32) / 255, cv2.COLOR_BGR2HLS)
    hue = hls[..., 0] / 2
    low, high = hues[0][0], hues[-1][1]
    middle, half = (low + (high - low) % 180 / 2) % 180, (high - low) % 180 / 2
    away = np.abs((hue - middle + 90) % 180 - 90) - half
    chroma = colors.max(-1).astype(float) - colors.min(-1)
    colorful = chroma / np.maximum(colors.max(-1), 1)
    closeness = np.clip(1 - away / 6, 0, 1) * np.clip((colorful - 0.25) / 0.2, 0, 1) * np.clip((chroma - 12) / 18, 0, 1)
    table = (255 * closeness).astype(np.uint8).reshape(BINS, BINS, BINS)
    table.flags.writeable = False  # all who ask for this colour share it
    return table


def _table_from_pixels(ball, rest):
    """Share of ball among the pixels of each colour, with both counts spread over similar colours."""
    shares = []
    for pixels in (ball, rest):
        counts = np.zeros((BINS, BINS, BINS), np.float32)
        np.add.at(counts, tuple((pixels >> 3).T), 1)
        shares.append(_spread(counts) / len(pixels))
    prior = 0.1  # a ball covers a few hundredths of a picture; its rarer tints count as well
    seen = prior * shares[0] / (prior * shares[0] + (1 - prior) * shares[1] + 1e-7)
    return (255 * np.clip(seen, 0, 1)).astype(np.uint8)


def _spread(counts):
    """Gaussian blur of a colour histogram: brightness may change more than tint."""
    for axis in range(3):
        moved = np.moveaxis(counts, axis, 0)
        flat = np.ascontiguousarray(moved.reshape(BINS, -1))
        blurred = cv2.filter2D(flat, -1, cv2.getGaussianKernel(7, 1.0), borderType=cv2.BORDER_CONSTANT)
        counts = np.moveaxis(blurred.reshape(moved.shape), 0, axis)
    grey = np.zeros_like(counts)
    for step in range(-3, 4):  # along the grey diagonal: the same tint, lighter or darker
        grey += np.exp(-0.5 * (step / 1.6) ** 2) * _shifted(counts, step)
    return grey


def _shifted(counts, step):
    result = np.zeros_like(counts)
    to = slice(max(0, step), BINS + min(0, step))
    come = slice(max(0, -step), BINS - max(0, step))
    result[to, to, to] = counts[come, come, come]
    return result


def _hls_ranges(pixels):
    """HLS bounds that hold nine tenths of the pixels; the hue may wrap round 0."""
    hls = cv2.cvtColor(pixels.reshape(-1, 1, 3), cv2.COLOR_BGR2HLS).reshape(-1, 3).astype(float)
    angle = np.angle(np.exp(2j * np.pi * hls[:, 0] / 180).mean()) * 90 / np.pi
    offset = (hls[:, 0] - angle + 90) % 180 - 90
    low, high = np.percentile(offset, [5, 95]) + angle
    (l0, l1), (s0, s1) = (np.percentile(hls[:, k], [5, 95]) for k in (1, 2))
    low, high = round(low) % 180, round(high) % 180
    spans = [(low, high)] if low <= high else [(low, 179), (0, high)]
    return tuple(((int(a), int(l0), int(s0)), (int(b), int(l1), int(s1))) for a, b in spans)

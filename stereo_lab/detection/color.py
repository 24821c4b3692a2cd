"""The colour of a ball: HLS bounds for the paper's way, and a table of how ball-like a colour is for ours."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cache, cached_property

import cv2
import numpy as np

from stereo_lab.detection.weights import SHIPPED, Sizes, Weights
from stereo_lab.errors import StereoLabError

# The colour table has BINS steps a channel. A chroma, greatest − least channel, of one STEP may be rounding and noise; one of two
# steps is a colour, however dim
BINS = 32
STEP = 256 // BINS

# Hue in OpenCV's 0…179; red wraps round 0. OpenCV 5 rounds hues next to 0 up to 180 in HLS: a tenth of a red ball's pixels.
# Least lightness and saturation keep grey and black out.
LAST_HUE = 180
HUES = {
    "red": ((172, LAST_HUE), (0, 7)),
    "orange": ((8, 18),),
    "yellow": ((20, 34),),
    "green": ((40, 85),),
    "blue": ((98, 130),),
}
LIGHTNESS, SATURATION = (25, 235), (70, 255)
# For ours: hues may lie so far outside, for lamps are warm and cameras differ, and then fall off over as many as FADE
WARM, FADE = 3, 6
# How colourful, (greatest − least) / greatest channel: not at all the ball's colour, and fully. Greens are often pale, and
# hardly anything else in a room is green; but skin, wood and cardboard are a pale orange
COLORFUL = {"green": (0.10, 0.25), "orange": (0.35, 0.75)}
USUALLY = (0.25, 0.75)


@dataclass(frozen=True, eq=False)
class BallColor:
    """A colour: HLS bounds for the paper's way, and a table BGR -> 0…255 (how ball-like) for ours.

    Attributes
    ----------
    name : str, "learned" for one from samples
    ranges : tuple of (lower, upper), each (H, L, S) as in OpenCV
    table : ndarray, shape (32, 32, 32), uint8, indexed by B, G, R divided by 8
    marks : tuple of (number of the picture, u, v, radius_px), of a colour that marked itself
    weights : Weights, by which a thing of this colour is judged
    sizes : Sizes, how large the marked balls looked; from a name any size is as good
    """

    name: str
    ranges: tuple[tuple[tuple[int, ...], tuple[int, ...]], ...]
    table: np.ndarray = field(repr=False)
    marks: tuple[tuple[int, float, float, float], ...] = ()
    weights: Weights = field(default=SHIPPED, repr=False)
    sizes: Sizes = field(default=Sizes(), repr=False)

    @classmethod
    def named(cls, name: str) -> BallColor:
        """One of red, orange, yellow, green, blue, in small letters or capitals; or a ball that was learned, by its file's name.

        Raises
        ------
        StereoLabError
            For any other name.
        """
        known = str(name).strip().lower()
        if known.endswith(".json"):
            from stereo_lab.detection.own import OwnBall

            return OwnBall.load(str(name))
        if known not in HUES:
            raise StereoLabError(
                f"There is no colour {name!r}. Choose one of {', '.join(HUES)}, or the file of a ball that was learned (.json)."
            )
        ranges = tuple(
            ((low, LIGHTNESS[0], SATURATION[0]), (high, LIGHTNESS[1], SATURATION[1])) for low, high in HUES[known]
        )
        return cls(known, ranges, _table_from_hue(HUES[known], *COLORFUL.get(known, USUALLY)))

    @classmethod
    def from_samples(cls, images: Sequence[np.ndarray], circles: Sequence[Sequence[float]]) -> BallColor:
        """Learn a colour from a few pictures in which the ball is marked.

        The table tells, for every colour, which share of the pixels of that colour lies on a ball. Where two or more are marked,
        their sizes count, too: mark it as near and as far as it will be.

        Parameters
        ----------
        images : sequence of ndarray, BGR
        circles : sequence of (u, v, radius_px), one for each picture

        Raises
        ------
        StereoLabError
            If there is no picture, or a circle lies outside its picture or fills it.
        """
        from stereo_lab.detection import learning

        ball, rest = learning.pixels_of(images, circles)
        table = learning.table_from_pixels(ball, rest)
        return cls("learned", learning.hls_ranges(ball), table, sizes=Sizes.of(images, circles))

    @classmethod
    def learned(cls, images: Sequence[np.ndarray], name: str) -> BallColor:
        """Learn a colour from pictures that nobody marked: the surest balls by its name mark themselves.

        Parameters
        ----------
        images : sequence of ndarray, BGR, of one ball; a dozen or more
        name : str, as for :meth:`named`

        Returns
        -------
        BallColor
            ``marks`` tells which pictures and circles it was learned from: look at them.

        Raises
        ------
        StereoLabError
            If no picture shows a ball of that name.
        """
        from stereo_lab.detection import learning

        marks = learning.surest(images, cls.named(name))
        found = cls.from_samples([images[k] for k, *_ in marks], [circle for _, *circle in marks])
        return replace(found, marks=marks)

    def mask(self, image: np.ndarray) -> np.ndarray:
        """255 where the pixel lies between the paper's HLS bounds, else 0; shape (height, width)."""
        hls = cv2.cvtColor(image, cv2.COLOR_BGR2HLS)
        masks = [cv2.inRange(hls, np.array(low), np.array(high)) for low, high in self.ranges]
        return np.bitwise_or.reduce(masks)

    def likeness(self, image: np.ndarray, step: int = 1) -> np.ndarray:
        """How ball-like the colour of every so manieth pixel of every so manieth row is, 0…255, shape (rows, columns)."""
        packed = cv2.cvtColor(image[::step], cv2.COLOR_BGR2BGR555).view(np.uint16)  # 15 bits: red, green, blue
        return cv2.LUT(packed[:, ::step, 0], self._by_packed)

    @cached_property
    def _by_packed(self):
        return np.tile(self.table.transpose(2, 1, 0).ravel(), 2)  # the 16th bit tells nothing


def bin_colors():
    """The middle of every bin as a picture of shape (BINS * BINS, BINS, 3), BGR."""
    steps = (np.arange(BINS) * STEP + STEP // 2).astype(np.uint8)
    grid = np.stack(np.meshgrid(steps, steps, steps, indexing="ij"), -1)
    return grid.reshape(BINS * BINS, BINS, 3)


@cache
def _table_from_hue(hues, least, fully):
    """255 inside the hue range, falling off beyond it; grey and black fall off as well."""
    colors = bin_colors()
    hls = cv2.cvtColor(colors.astype(np.float32) / 255, cv2.COLOR_BGR2HLS)
    hue = hls[..., 0] / 2
    low, high = hues[0][0], hues[-1][1]
    middle, half = (low + (high - low) % 180 / 2) % 180, (high - low) % 180 / 2 + WARM
    away = np.abs((hue - middle + 90) % 180 - 90) - half
    chroma = colors.max(-1).astype(float) - colors.min(-1)
    colorful = chroma / colors.max(-1)
    parts = np.clip([1 - away / FADE, (colorful - least) / (fully - least), chroma / STEP - 1], 0, 1)
    table = (255 * parts.prod(0)).astype(np.uint8).reshape(BINS, BINS, BINS)
    table.flags.writeable = False  # all who ask for this colour share it
    return table

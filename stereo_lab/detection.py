"""Lesson 02: find a ball of one colour in one picture.

Two ways. ``method="paper"`` is Algorithm 1 of Rao and Singh: keep the pixels between two HLS bounds,
blur, and let a circular Hough transform vote for a centre. ``method="cone"`` finds round things of the
ball's colour, looks where their edge is to a fraction of a pixel, fits the cone of rays that touches
the ball, and says None where that cone does not hold.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import cv2
import numpy as np

from stereo_lab import cone
from stereo_lab.common.threads import one_thread
from stereo_lab.errors import StereoLabError

BINS = 32  # the colour table has BINS steps a channel
SAME_SIZE = 0.25  # a ball's radius may change by this part from one frame to the next

# Hue in OpenCV's 0…179; red wraps round 0. Least lightness and saturation keep grey and black out.
HUES = {
    "red": ((172, 179), (0, 7)),
    "orange": ((8, 18),),
    "yellow": ((20, 34),),
    "green": ((40, 85),),
    "blue": ((98, 130),),
}
LIGHTNESS, SATURATION = (25, 235), (70, 255)


@dataclass(frozen=True)
class Detection:
    """A ball in a picture: its centre and radius in pixels of that picture, and a score 0…1."""

    u: float
    v: float
    radius_px: float
    score: float


@dataclass(frozen=True, eq=False)
class BallColor:
    """A colour: HLS bounds for the paper's way, and a table BGR -> 0…255 (how ball-like) for ours.

    Attributes
    ----------
    ranges : tuple of (lower, upper), each (H, L, S) as in OpenCV
    table : ndarray, shape (32, 32, 32), uint8, indexed by B, G, R divided by 8
    """

    name: str
    ranges: tuple
    table: np.ndarray = field(repr=False)

    @classmethod
    def named(cls, name):
        """One of red, orange, yellow, green, blue.

        Raises
        ------
        StereoLabError
            For any other name.
        """
        if name not in HUES:
            raise StereoLabError(f"There is no colour {name!r}. Choose one of {', '.join(HUES)}.")
        ranges = tuple(
            ((low, LIGHTNESS[0], SATURATION[0]), (high, LIGHTNESS[1], SATURATION[1])) for low, high in HUES[name]
        )
        return cls(name, ranges, _table_from_hue(HUES[name]))

    @classmethod
    def from_samples(cls, images, circles):
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
            If there is no picture, or a circle lies outside its picture.
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
        return cls("learned", _hls_ranges(ball), _table_from_pixels(ball, rest))

    def mask(self, image):
        """255 where the pixel lies between the paper's HLS bounds, else 0; shape (height, width)."""
        hls = cv2.cvtColor(image, cv2.COLOR_BGR2HLS)
        masks = [cv2.inRange(hls, np.array(low), np.array(high)) for low, high in self.ranges]
        return np.bitwise_or.reduce(masks)

    def likeness(self, image):
        """How ball-like each pixel's colour is, 0…255, shape (height, width)."""
        index = (image >> 3).astype(np.uint16)
        return self.table.ravel()[(index[..., 0] << 10) | (index[..., 1] << 5) | index[..., 2]]


class BallDetector:
    """Finds one ball in a picture.

    Parameters
    ----------
    color : BallColor, or the name of one
    method : "paper" or "cone"
    camera : (matrix 3x3, distortion), optional
        Intrinsics of the camera that took the pictures, for an exact cone; without them an ellipse
        is fitted.
    """

    def __init__(self, color, method="cone", camera=None):
        if method not in ("paper", "cone"):
            raise StereoLabError(f'There is no method {method!r}. Choose "paper" or "cone".')
        self.color = BallColor.named(color) if isinstance(color, str) else color
        self.method = method
        self.camera = camera

    def detect(self, image, near=None):
        """The ball, or None where there is none.

        Parameters
        ----------
        image : ndarray, shape (height, width, 3), BGR, uint8
        near : Detection, optional; where to look first (the ball in the frame before)

        Returns
        -------
        Detection or None
        """
        image = check_image(image)
        if self.method == "paper":
            return detect_paper(image, self.color)
        if near is not None:
            found = self._look_near(image, near)
            if found is not None:
                return found
        return _best(self.candidates(image))

    def candidates(self, image, most=4):
        """What may be the ball, best first (cone method); a score below ``cone.BALL`` is not enough alone."""
        rounds = cone.find_balls(check_image(image), self.color, self.camera)
        return [Detection(*r.center, r.radius_px, r.score) for r in rounds[:most]]

    def _look_near(self, image, near):
        """Look in a window round the ball's last place; less evidence is enough there for one of the same size."""
        height, width = image.shape[:2]
        reach = int(4 * near.radius_px + 12)
        x0, y0 = max(0, int(near.u) - reach), max(0, int(near.v) - reach)
        window = image[y0 : min(height, int(near.v) + reach), x0 : min(width, int(near.u) + reach)]
        if min(window.shape[:2], default=0) < 8:
            return None
        rounds = cone.find_balls(window, self.color, self.camera, offset=(x0, y0), enough=cone.WEAK)
        same = [r for r in rounds if abs(r.radius_px - near.radius_px) < SAME_SIZE * near.radius_px + 1]
        return Detection(*same[0].center, same[0].radius_px, same[0].score) if same else None


def _best(candidates):
    return next((c for c in candidates if c.score >= cone.BALL), None)


def check_image(image):
    """A BGR uint8 picture, or a plain error."""
    image = np.asarray(image)
    if image.ndim != 3 or image.shape[2] != 3 or image.dtype != np.uint8:
        raise StereoLabError(
            f"Expected a colour picture of shape (height, width, 3) and type uint8; got {image.shape} and {image.dtype}."
        )
    return image


# --- the paper's way ---------------------------------------------------------------------------------

BLUR_PX = 9
HOUGH_RADII = (4, 0.2)  # least radius in px, largest as a part of the picture's height
HOUGH_WIDTH = 1280  # a wider picture is made smaller: votes grow with the cube of the width
MASK_LIMIT = 0.25  # of the picture; beyond it the Hough transform would vote for minutes


def detect_paper(image, color):
    """Algorithm 1: HLS bounds, blur, circular Hough transform, strongest circle.

    Returns
    -------
    Detection or None, score 1
    """
    shrink = min(1.0, HOUGH_WIDTH / image.shape[1])
    if shrink < 1:
        image = cv2.resize(image, None, fx=shrink, fy=shrink, interpolation=cv2.INTER_AREA)
    mask = color.mask(image)
    if not 0 < np.count_nonzero(mask) < MASK_LIMIT * mask.size:
        return None
    blurred = cv2.GaussianBlur(mask, (BLUR_PX, BLUR_PX), 0)
    largest = int(HOUGH_RADII[1] * image.shape[0])
    with one_thread():
        circles = cv2.HoughCircles(
            blurred, cv2.HOUGH_GRADIENT, dp=1, minDist=image.shape[0], param1=200, param2=10,
            minRadius=HOUGH_RADII[0], maxRadius=largest,
        )  # fmt: skip
    if circles is None:
        return None
    u, v, radius = (float(c) for c in circles.reshape(-1, circles.shape[-1])[0, :3])
    return Detection((u + 0.5) / shrink - 0.5, (v + 0.5) / shrink - 0.5, radius / shrink, 1.0)


# --- colour tables -----------------------------------------------------------------------------------


def _bin_colors():
    """The middle of every bin as a picture of shape (BINS * BINS, BINS, 3), BGR."""
    steps = (np.arange(BINS) * (256 // BINS) + 128 // BINS).astype(np.uint8)
    grid = np.stack(np.meshgrid(steps, steps, steps, indexing="ij"), -1)
    return grid.reshape(BINS * BINS, BINS, 3)


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
    return (255 * closeness).astype(np.uint8).reshape(BINS, BINS, BINS)


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

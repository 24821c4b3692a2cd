"""The outline: one look at a picture along rays across a circle, and where on each ray the ball ends.

Everything that is asked of a thing in the picture, its edge and the evidence for a ball, is read from such a look.
"""

from __future__ import annotations

import math
from functools import cached_property

import cv2
import numpy as np

from stereo_lab.detection.color import BallColor
from stereo_lab.detection.model import Camera, Circle

RAYS, SAMPLES = 48, 21  # rays across the outline, places on each
LEAST_BAND_PX = 13  # a ball of fewer px has a rim as blurred as one of 13
BLUR_PX = 0.5  # evens out the pixels' grid
# Squared change of light and colour across the rim: from here it is an edge, and here it counts half
CLEAR, HALF = 100, 200
COLOR_ENDS = 76  # of 255: so much less ball-like outside than inside
QUIET = 40  # variance round the ball, of light or one of the two of colour, from which on it counts less than half
GATE, FLOOR = 2.5, 0.05  # how soon a place where the ball's colour ends counts fully, and the least that a place counts

STILL = np.zeros(3)
ALL = np.ones(RAYS, bool)
SUM = np.ones((3, 1))
GAMMA = 2.2
LIGHT = (255 * (np.arange(256) / 255.0) ** GAMMA).astype(np.float32)  # a lens's blur mixes light, not stored values
LUMA = np.array([[0.114, 0.587, 0.299]], np.float32)
RED, BLUE = np.array([[[0, 0, 1]], [[1, 0, 0]]], np.float32)
CR, CB = np.float32(0.713) * (RED - LUMA), np.float32(0.564) * (BLUE - LUMA)
# JPEG's blur mixes stored colours, and widely: they count less. The first row keeps a place for the light
CHROMA = 0.3 * np.concatenate([0 * LUMA, CR, CB])
QUIET_CHROMA = 2 * CHROMA  # but before books and plants they are surer than the light; measured on rendered ones
ANGLE = np.arange(RAYS) * (2 * np.pi / RAYS)
RING = np.array([np.cos(ANGLE), np.sin(ANGLE)])
EACH = np.ones(SAMPLES, np.float32)
SPAN = np.linspace(-1, 1, SAMPLES, dtype=np.float32)
# A place lies at (u, v) + (radius + band · span) · (cos, sin): from these four to x of all places, then y of all. The
# innermost of all rays come first: a sum along the rays is one product. (dot and not @: on so few numbers half of it is the call)
PARTS = np.broadcast_arrays(*np.eye(2)[..., None, None], RING[:, None], RING[:, None] * SPAN[:, None])
PLACES = np.reshape(PARTS, (4, -1)).astype(np.float32)
MOMENTS = np.stack([SPAN, EACH])[:, 1:-1]
END = SAMPLES // 4
INNER = np.repeat([1.0 / END, 0], [END, SAMPLES - END]).astype(np.float32)  # means over the ends of a ray
OUTER = INNER[::-1].copy()
ENDS = INNER - OUTER
# An edge between those ends, blurred over so many px to both sides: 2.5 sigma of 0.8 px, for lens, pixels and colour mosaic of
# a webcam. Where a picture is blurred by less than half of that, it is put back too far
EDGE_PX = 2.0
PART = np.array([[0.5 * math.erfc(2.5 * off / 2**0.5)] for off in SPAN], np.float32)
COVERED = PART * INNER + (1 - PART) * OUTER
COUNT = np.arange(SAMPLES, dtype=np.float32).clip(1)[:, None]
UP_TO = np.tril(np.ones((SAMPLES, SAMPLES), np.float32))  # places before each one, and itself
# From likeness, 0…255, to its mean over all places before and after each one, 0…1; not for the first and the last
BEFORE = (np.tril(UP_TO, -1) / COUNT / 255)[1:-1]
AFTER = (np.tril(UP_TO, -1).T / COUNT[::-1] / 255)[1:-1]


class Look:
    """The picture along rays from a centre, across a circle; they reach ``share`` radii to both sides of it.

    ``seen``, shape (RAYS,): whether a ray crosses the circle inside the picture. ``width``: of the whole picture, px.
    """

    def __init__(self, image: np.ndarray, color: BallColor, camera: Camera, circle: Circle, share: float) -> None:
        self.color, self.camera, self.share, self.width = color, camera, share, image.shape[1]
        self.u, self.v, self.r = u, v, r = circle
        self.band = band = share * max(r, LEAST_BAND_PX)
        reach = r + band + 2
        self.left, self.top = max(0, int(u - reach)), max(0, int(v - reach))
        whole = image[self.top : int(v + reach) + 2, self.left : int(u + reach) + 2]
        self.patch = cv2.GaussianBlur(whole, (3, 3), BLUR_PX)
        told = np.array([u - self.left, v - self.top, r, band], np.float32)
        self.x, self.y = told.dot(PLACES).reshape(2, SAMPLES, RAYS)
        self.seen = ALL
        if not (r + 1 < u < image.shape[1] - r - 2 and r + 1 < v < image.shape[0] - r - 2):
            x, y = self.x[SAMPLES // 2], self.y[SAMPLES // 2]
            self.seen = (x > 0.5) & (y > 0.5) & (x < self.patch.shape[1] - 1.5) & (y < self.patch.shape[0] - 1.5)

    def sampled(self, picture: np.ndarray) -> np.ndarray:
        """The picture at every place of every ray, shape (SAMPLES, RAYS, 3)."""
        return cv2.remap(picture, self.x, self.y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)

    @cached_property
    def off(self) -> np.ndarray:
        """How far beyond the circle each place of a ray lies, px, shape (SAMPLES,)."""
        return np.float32(self.band) * SPAN

    @cached_property
    def like(self) -> np.ndarray:
        """How ball-like each place is, 0…255, shape (SAMPLES, RAYS)."""
        return self.color.likeness(self.sampled(self.patch)).astype(np.float32)

    @property
    def light_edge(self) -> tuple[np.ndarray, np.ndarray]:
        """On each ray how far beyond the circle light and colour change most; and a weight, 0 where it is not clear."""
        fall, weights = self._change
        return _centroid(fall, self.band), weights

    @cached_property
    def ball_edge(self) -> tuple[np.ndarray, np.ndarray]:
        """The same, near the place where the ball's colour ends: ball-like before it, not after it."""
        fall, weights = self._change
        return _centroid(fall * self._ends, self.band), weights

    @cached_property
    def quiet_edge(self) -> tuple[np.ndarray, np.ndarray]:
        """The same, by what is quiet round the ball: before books and plants often its colour, and not the light.

        Light and the two of colour count the less, the more each varies round the ball. What is stored of a colour is the
        root of its light, so that the lighter side seems to reach across a blurred edge: by so much each edge is put back.
        """
        places, change, weights = self._across(QUIET_CHROMA)
        change *= QUIET / (QUIET + _along(OUTER, places).var(0))
        mixed = _along(COVERED, self.sampled(self.light))
        edge = _light_and_color(255 * (mixed / 255) ** (1 / GAMMA), mixed, QUIET_CHROMA)
        off = _centroid(_cubed_slope(places, change) * self._ends, self.band)
        return off - _centroid(_cubed_slope(edge, change), EDGE_PX), weights

    @cached_property
    def light(self) -> np.ndarray:
        """The light of every pixel of the patch, 0…255, which is what a lens blurs: what is stored is its root."""
        return cv2.LUT(self.patch, LIGHT)

    @cached_property
    def _ends(self):
        return np.clip(GATE * BEFORE.dot(self.like) * (1 - AFTER.dot(self.like)), FLOOR, 1)

    @cached_property
    def _change(self):
        places, change, weights = self._across(CHROMA)
        return _cubed_slope(places, change), weights

    def _across(self, chroma):
        """Light and colour at every place of every ray, how much each ray changes from end to end, and a weight by that."""
        places = self.sampled(_light_and_color(self.patch.astype(np.float32), self.light, chroma))
        change = _along(ENDS, places)
        contrast = np.square(change).dot(EACH[:3])
        return places, change, (self.seen & (contrast > CLEAR)) * contrast / (contrast + HALF)

    @cached_property
    def color_edge(self) -> tuple[np.ndarray, np.ndarray]:
        """The same, where the ball's colour itself ends: the best split of each ray."""
        split = UP_TO.dot(self.like - 100).argmax(0)
        off = self.off[split] + (self.off[1] - self.off[0]) / 2
        return off, (self.seen & (ENDS.dot(self.like) > COLOR_ENDS)).astype(np.float32)

    def rays(self, off: np.ndarray) -> np.ndarray:
        """Unit vectors from the camera through the places this far beyond the circle, shape (RAYS, 3)."""
        return unit_rays((RING * (self.r + off)).T[:, None] + (self.u, self.v), self.camera)

    def pixel(self, ray: np.ndarray) -> tuple[float, float]:
        """Where a ray from the camera, shape (3,), of any length, is seen: the other way round."""
        u, v = cv2.projectPoints(ray[None, None], STILL, STILL, *self.camera)[0].ravel().tolist()
        return u, v


def unit_rays(pixels: np.ndarray, camera: Camera) -> np.ndarray:
    """Unit vectors from the camera through N pixels, shape (N, 3)."""
    rays = cv2.convertPointsToHomogeneous(cv2.undistortPoints(pixels, *camera))[:, 0]
    return rays / np.sqrt(np.square(rays).dot(SUM))


def _along(weights, places):
    """Weighted sums along each ray of light and colours, shape (…, RAYS, 3)."""
    return weights.dot(places.reshape(SAMPLES, -1)).reshape(*weights.shape[:-1], RAYS, 3)


def _light_and_color(stored, light, chroma):
    """Light and two of colour, of places that are stored so and have this light, shape (…, …, 3)."""
    picture = cv2.transform(stored, chroma)
    picture[..., 0] = cv2.transform(light, LUMA)
    return picture


def _cubed_slope(places, change):
    """Each ray projected on its own change of light and colour, and how steeply it falls, cubed: an edge stands out."""
    profile = (places * change).reshape(-1, 3).dot(EACH[:3]).reshape(SAMPLES, RAYS)  # its scale does not matter
    fall = np.maximum(profile[:-2] - profile[2:], 0)
    fall *= np.square(fall)
    return fall


def _centroid(fall, reach_px):
    """Where on each ray it falls, px from the middle of a ray that reaches so far to both sides."""
    moment, mass = MOMENTS.dot(fall)
    return reach_px * moment / (mass + 1e-6)

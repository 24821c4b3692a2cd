"""Is a round thing a ball? What its inside, its rim and what lies beyond say of it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import cv2
import numpy as np

from stereo_lab.detection.color import BallColor
from stereo_lab.detection.curves import Circle, Cone, Ellipse
from stereo_lab.detection.edges import color_edge, directions, edge_points

# When is a round thing a ball? The evidence is the part of its rim that agrees, less what speaks against
# it; a ball has BALL or more. Weaker ones count where a second camera sees the same ball.
BALL, WEAK = 0.5, 0.35
LEAST_EVIDENCE = 0.32  # for a long rim
CHANCE = 1.2  # a rim of n px must have CHANCE / √n more: few pixels look round by chance
LEAST_FILL = 0.5  # part of the inside that has the ball's colour
MOST_LOBES = 0.055  # of the radius: how much the outline swells in two, three or four places, as an egg or a box does
LEAST_SHADE = 0.12  # a ball is lighter on one side; a printed disc is flat

_ANGLE, _PART = np.meshgrid(np.arange(24) * np.pi / 12, np.sqrt((np.arange(8) + 0.5) / 8) * 0.85)
INSIDE = _PART * np.cos(_ANGLE), _PART * np.sin(_ANGLE)  # places inside a ball, evenly spread, in radii


@dataclass(frozen=True)
class Evidence:
    """What speaks for a ball; the attributes are those of :class:`stereo_lab.detection.cone.Round`."""

    support: float
    fill: float
    shade: float
    score: float


def judge(image: np.ndarray, curve: Circle | Ellipse | Cone, color: BallColor) -> Evidence:
    """The evidence on what lies inside and round a curve of the picture."""
    fill, shade = _inside(image, curve.u, curve.v, curve.radius_px, color)
    if fill < LEAST_FILL or shade < LEAST_SHADE:  # no ball: its rim need not be looked at
        return Evidence(0.0, fill, shade, 0.0)
    rim = _rim(image, curve, color)
    return Evidence(rim.support, fill, shade, _score(rim, 2 * np.pi * curve.radius_px))


@dataclass(frozen=True)
class Rim:
    """How the rim agrees with the curve, as parts of all rays.

    Attributes
    ----------
    support : rays with one of the two edges on the curve
    overflow : rays on which the ball's colour goes on beyond the curve with no edge there: no ball does
    ragged : rays without support outside the longest gap: one thing before a ball hides one arc of it
    seen : rays whose rim is in the picture
    lobes : how much the outline swells in two, three or four places, in radii
    """

    support: float
    overflow: float
    ragged: float
    seen: float
    lobes: float


def _rim(image, curve, color):
    u, v, radius = curve.u, curve.v, curve.radius_px
    band = max(2.5, 0.16 * radius)
    sharp, clear = edge_points(image, u, v, radius, band)
    ends, ending = color_edge(image, u, v, radius, band, color)
    on_curve = clear & (np.abs(curve.residuals(sharp)) < max(0.5, 0.04 * radius))
    on_curve |= ending & (np.abs(curve.residuals(ends)) < max(0.8, 0.06 * radius))
    beyond, seen = _beyond(image, u, v, radius, len(on_curve), color)
    ragged = (~on_curve).sum() - _longest_gap(~on_curve)
    lobes = _lobes(image, curve, edge_points)
    if lobes > MOST_LOBES:  # one round outline is enough
        lobes = min(lobes, _lobes(image, curve, lambda *ring: color_edge(*ring, color)))
    return Rim(float(on_curve.mean()), float((beyond & ~on_curve).mean()), float(ragged / len(on_curve)), seen, lobes)


@cache
def _waves(count):
    """A constant, and the waves with 2, 3 and 4 crests all round, at so many rays: shape (count, 7)."""
    angle = np.arange(count) * 2 * np.pi / count
    return np.stack([np.ones_like(angle)] + [wave(n * angle) for n in (2, 3, 4) for wave in (np.cos, np.sin)], 1)


def _lobes(image, curve, edge):
    """Root mean square of the waves with 2, 3 and 4 crests in the outline's distance from the curve, in radii.

    A ball's outline has none. Rays without an edge near the curve do not count.
    """
    radius = curve.radius_px
    points, strong = edge(image, curve.u, curve.v, radius, max(3.0, 0.3 * radius))
    off = curve.residuals(points)
    near = strong & (np.abs(off) < 0.5 + 0.2 * radius)
    if near.sum() < 12:
        return 0.0
    waves = _waves(len(points))[near]
    heights = np.linalg.solve(waves.T @ waves + 0.5 * np.eye(7), waves.T @ off[near])
    return float(np.sqrt(((waves[:, 1:] @ heights[1:]) ** 2).mean()) / radius)


def _beyond(image, u, v, radius, count, color):
    """For each ray, whether the ball's colour is found just outside the rim; and the part of rays in the picture."""
    ray = directions(count)
    radii = radius + max(1.5, 0.08 * radius) + np.array([0.0, 0.5, 1.0]) * max(1.0, 0.05 * radius)
    x = (u + ray[:, :1] * radii).astype(np.float32)
    y = (v + ray[:, 1:] * radii).astype(np.float32)
    colors = cv2.remap(image, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    seen = (x[:, 0] > 0) & (x[:, 0] < image.shape[1] - 1) & (y[:, 0] > 0) & (y[:, 0] < image.shape[0] - 1)
    return color.likeness(colors).mean(1) > 110, float(seen.mean())


def _longest_gap(missing):
    """Length of the longest run of True in a ring."""
    if missing.all():
        return len(missing)
    ring = np.roll(missing, -int(np.argmin(missing)))
    edges = np.flatnonzero(np.diff(np.concatenate([[0], ring.astype(int), [0]])))
    return int((edges[1::2] - edges[::2]).max(initial=0))


def _score(rim, rim_px):
    """BALL where there is just enough evidence, up to 1 with more, 0 where it cannot be a ball."""
    if rim.seen < 0.5 or rim.lobes > MOST_LOBES:
        return 0.0
    evidence = rim.support - 1.5 * rim.overflow - 0.25 * rim.ragged
    return float(np.clip(BALL + evidence - LEAST_EVIDENCE - CHANCE / np.sqrt(rim_px), 0, 1))


def _inside(image, u, v, radius, color):
    """Part of the inside with the ball's colour, and how much its brightness changes across it."""
    x, y = (u + radius * INSIDE[0]).astype(np.float32), (v + radius * INSIDE[1]).astype(np.float32)
    colors = cv2.remap(image, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    ball_like = color.likeness(colors) > 60
    if ball_like.sum() < 8:
        return float(ball_like.mean()), 0.0
    bright = colors.max(-1).astype(float)[ball_like]
    terms = np.stack([np.ones_like(bright), (x - u)[ball_like] / radius, (y - v)[ball_like] / radius], 1)
    slope = np.linalg.lstsq(terms, bright, rcond=None)[0]
    shade = 2 * 0.85 * np.hypot(slope[1], slope[2]) / max(slope[0], 1.0)
    return float(ball_like.mean()), float(shade)

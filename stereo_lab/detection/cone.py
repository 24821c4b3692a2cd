"""Round things of one colour: their edge to a fraction of a pixel, and whether they are a ball."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import cv2
import numpy as np

from stereo_lab.detection.color import BallColor
from stereo_lab.detection.curves import best_circle, fit_circle, fit_cone, fit_ellipse, to_rays, trust
from stereo_lab.detection.edges import color_edge, directions, edge_points
from stereo_lab.detection.model import Camera
from stereo_lab.detection.search import SURELY, blob_circles, least_radius, small_copies, voted_circles

MOST_PASSES = 6
SETTLED_PX, ROUGHLY_SETTLED_PX = 0.03, 0.3
LITTLE = 0.3  # of a ball's area
CLEAN = 0.85  # score of a ball so clear that nothing else is looked for

# When is a round thing a ball? The evidence is the part of its rim that agrees, less what speaks against
# it; a ball has BALL or more. Weaker ones count where a second camera sees the same ball.
BALL, WEAK = 0.5, 0.35
HOPELESS = 0.1  # by the edge of its colour alone: not worth a closer look
LEAST_EVIDENCE = 0.32  # for a long rim
CHANCE = 1.2  # a rim of n px must have CHANCE / √n more: few pixels look round by chance
LEAST_FILL = 0.5  # part of the inside that has the ball's colour
MOST_LOBES = 0.055  # of the radius: how much the outline swells in two, three or four places, as an egg or a box does
LEAST_SHADE = 0.12  # a ball is lighter on one side; a printed disc is flat

_ANGLE, _PART = np.meshgrid(np.arange(24) * np.pi / 12, np.sqrt((np.arange(8) + 0.5) / 8) * 0.85)
INSIDE = _PART * np.cos(_ANGLE), _PART * np.sin(_ANGLE)  # places inside a ball, evenly spread, in radii


@dataclass(frozen=True)
class Round:
    """A round thing.

    Attributes
    ----------
    center, radius_px : (u, v) and float, where the ball is and how large, px of the whole picture
    support, fill : float, 0…1, which part of its rim agrees, and which of its inside has the ball's colour
    shade : float, how much its brightness changes across it
    score : float, 0…1; a ball has ``BALL`` or more
    """

    center: tuple[float, float]
    radius_px: float
    support: float
    fill: float
    shade: float
    score: float


def find_balls(
    image: np.ndarray, color: BallColor, camera: Camera | None = None,
    offset: tuple[int, int] = (0, 0), enough: float = CLEAN,
) -> list[Round]:  # fmt: skip
    """All round things of a colour that may be a ball, best first; those with a score of BALL or more are.

    Parameters
    ----------
    image : ndarray, BGR; a whole picture or a window of one
    color : has ``likeness(image)``
    camera : (matrix, distortion) or None
    offset : (x, y) of the window's first pixel in the picture
    enough : the score that ends the search

    Returns
    -------
    list of Round, in pixels of the whole picture
    """
    seen: list[Round] = []
    for copy in small_copies(image, color):
        for circles in (blob_circles, voted_circles):
            sift = circles is voted_circles  # there are many, and most of them are nothing
            seen += _measured(image, circles(copy), color, camera, offset, seen, sift)
            if any(thing.score >= enough for thing in seen) or _all_told(copy, seen, offset):
                break
        if any(thing.score >= BALL for thing in seen):
            break
    return sorted(_distinct(seen), key=_weight, reverse=True)


def _all_told(copy, seen, offset):
    """True where balls were found and little else in the picture has their colour."""
    balls = [thing for thing in seen if thing.score >= BALL]
    rest = copy.likeness > SURELY
    for ball in balls:
        middle = [round((c - o) * copy.scale) for c, o in zip(ball.center, offset, strict=True)]
        cv2.circle(rest.view(np.uint8), middle, round(1.5 * ball.radius_px * copy.scale) + 1, 0, -1)
    told = np.pi * max((ball.radius_px * copy.scale for ball in balls), default=0) ** 2
    return np.count_nonzero(rest) < LITTLE * told


def _measured(image, circles, color, camera, offset, seen, sift):
    """What may be a ball among the circles; those that start where one was found already are passed over."""
    found = []
    for circle in circles:
        if not any(_known(circle, thing, offset) for thing in (*seen, *found)):
            thing = measure(image, circle, color, camera, offset, sift)
            if thing is not None and thing.score >= WEAK:
                found.append(thing)
    return found


def _known(circle, thing, offset):
    """True where a circle starts inside a ball that was found, and is a part of it or the ball is clear."""
    u, v = thing.center[0] - offset[0], thing.center[1] - offset[1]
    apart = np.hypot(circle[0] - u, circle[1] - v)
    if thing.score > CLEAN or (thing.score >= BALL and circle[2] < 1.1 * thing.radius_px):
        return apart < 0.6 * thing.radius_px
    return apart + abs(circle[2] - thing.radius_px) < 0.15 * thing.radius_px


def _weight(ball):
    """The score, less for small things: a few pixels look round by chance, a long rim does not."""
    rim = 2 * np.pi * ball.radius_px * ball.support
    return ball.score * rim / (rim + 20)


def _distinct(balls):
    """Of round things that overlap, the one with the longest supported rim."""
    kept = []
    for ball in sorted(balls, key=lambda b: -b.support * b.radius_px):
        apart = [np.hypot(ball.center[0] - k.center[0], ball.center[1] - k.center[1]) for k in kept]
        if all(d > 0.7 * max(ball.radius_px, k.radius_px) for d, k in zip(apart, kept, strict=True)):
            kept.append(ball)
    return kept


def measure(
    image: np.ndarray, circle: tuple[float, float, float], color: BallColor, camera: Camera | None = None,
    offset: tuple[int, int] = (0, 0), sift: bool = False,
) -> Round | None:  # fmt: skip
    """Follow the edge of one round thing and judge it: a :class:`Round`, or None.

    First where the *ball's colour* ends, which marbling and shade do not disturb; then, from there,
    where *any* colour changes most, which is more exact and sees a red ball before a red cloth. With
    ``sift``, what is hopeless by its colour is not looked at twice.
    """
    rough = _follow(image, circle, lambda u, v, r, band: color_edge(image, u, v, r, band, color), 0.06)
    if sift and rough is not None and _judged(image, rough, color, offset).score < HOPELESS:
        return None
    start = circle if rough is None else (rough.u, rough.v, rough.radius_px)
    fine = _follow(
        image, start, lambda u, v, r, band: edge_points(image, u, v, r, band), 0.05, rough,
        exact=lambda points, curve, tolerance: _exact(points, curve, camera, offset, tolerance),
    )  # fmt: skip
    if fine is not None and rough is not None and not _agree(fine, rough):
        fine = None
    curve = fine or rough
    if curve is None:
        return None
    return _judged(image, curve, color, offset)


def _judged(image, curve, color, offset):
    fill, shade = _inside(image, curve.u, curve.v, curve.radius_px, color)
    if fill < LEAST_FILL or shade < LEAST_SHADE:  # no ball: its rim need not be looked at
        support = score = 0.0
    else:
        rim = _rim(image, curve, color)
        support, score = rim.support, _score(rim, 2 * np.pi * curve.radius_px)
    center = curve.center
    return Round((center[0] + offset[0], center[1] + offset[1]), curve.ball_radius_px, support, fill, shade, score)


def _follow(image, circle, edge, share, curve=None, exact=None):
    """Fit a curve to the edge, look again round that curve, until it stays where it is.

    Without ``exact`` the curve is a circle and need not settle finely: it only says where to look.
    """
    u, v, radius = circle
    height, width = image.shape[:2]
    for step in range(MOST_PASSES):
        inside = -radius < u < width + radius and -radius < v < height + radius
        if not (least_radius(width) <= radius <= 0.6 * max(height, width) and inside):
            return None
        wide = curve is None
        points, strong = edge(u, v, radius, max(3.0, 0.45 * radius) if wide else max(2.5, 0.16 * radius))
        if strong.sum() < max(6, 0.3 * len(points)):
            return None
        points, tolerance = points[strong], max(0.6, share * radius)
        if wide or step == 0:
            curve = best_circle(points, tolerance)
        curve = _again(points, curve, tolerance, 3 if step == 0 else 1) if curve is not None else None
        if curve is not None and exact and (step or not wide):
            curve = exact(points, curve, tolerance) or curve
        if curve is None:
            return None
        moved = np.hypot(curve.u - u, curve.v - v) + abs(curve.radius_px - radius)
        u, v, radius = curve.u, curve.v, curve.radius_px
        if step > 0 and moved < (SETTLED_PX if exact else ROUGHLY_SETTLED_PX):
            break
    return curve


def _again(points, curve, tolerance, times):
    """A circle by weighted least squares from a curve that is nearly right; far points count nothing."""
    for _ in range(times):
        weights = trust(curve.residuals(points), tolerance)
        if np.count_nonzero(weights) < 5:
            return None
        curve = fit_circle(points, weights)
    return curve


def _exact(points, curve, camera, offset, tolerance):
    """The cone (with a camera) or the ellipse (without) through the same edge."""
    weights = trust(curve.residuals(points), tolerance)
    if (weights > 0).sum() < 8:
        return None
    if camera is None:
        return _whole_ellipse(points, weights)
    rays = to_rays(points, camera, offset)
    for _ in range(2):
        cone = fit_cone(rays, camera, offset, weights)
        if cone is None or (weights > 0).sum() < 8:
            return None
        weights = trust(cone.ray_residuals(rays), tolerance)
    return cone


def _whole_ellipse(points, weights):
    """An ellipse where most of the rim is seen, else None: a circle is safer."""
    kept = points[weights > 0.2]
    if len(kept) < 0.75 * len(points):
        return None
    ellipse = fit_ellipse(kept)
    return ellipse if ellipse is not None and ellipse.aspect < 1 / 0.75 else None


def _agree(fine, rough):
    """True where both edges tell of the same ball."""
    allowed = 1.0 + 0.12 * rough.radius_px
    apart = np.hypot(fine.u - rough.u, fine.v - rough.v)
    return apart < allowed and abs(fine.radius_px - rough.radius_px) < allowed


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

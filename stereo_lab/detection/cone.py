"""Round things of one colour: their edge to a fraction of a pixel, and whether they are a ball."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from stereo_lab.detection.color import BallColor
from stereo_lab.detection.curves import best_circle, fit_circle, fit_cone, fit_ellipse, to_rays, trust
from stereo_lab.detection.edges import color_edge, edge_points
from stereo_lab.detection.judge import BALL, WEAK, judge
from stereo_lab.detection.model import Camera
from stereo_lab.detection.search import SURELY, blob_circles, least_radius, small_copies, voted_circles

MOST_PASSES = 6
SETTLED_PX, ROUGHLY_SETTLED_PX = 0.03, 0.3
LITTLE = 0.3  # of a ball's area
CLEAN = 0.85  # score of a ball so clear that nothing else is looked for
HOPELESS = 0.1  # by the edge of its colour alone: not worth a closer look


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
    if sift and rough is not None and judge(image, rough, color).score < HOPELESS:
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
    evidence, (u, v) = judge(image, curve, color), curve.center
    return Round(
        (u + offset[0], v + offset[1]), curve.ball_radius_px,
        evidence.support, evidence.fill, evidence.shade, evidence.score,
    )  # fmt: skip


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

"""Round things of one colour, their edges to a fraction of a pixel, and the cone that touches a ball.

The rays from the camera that just touch a ball form a cone. Its axis goes through the ball's centre. The
picture of the ball is that cone cut by the image plane: an ellipse, whose middle is *not* where the
ball's centre is.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

SEARCH_WIDTH = 400  # blobs are looked for in a picture made this small, then once more in a larger one
MOST_BLOBS = 12
MOST_CIRCLES = 3  # a blob
TRIALS = 240  # circles through three points of an outline
LEAST_RADIUS_PX, LEAST_OF_WIDTH = 3.0, 0.007
MOST_PASSES = 6
SETTLED_PX, ROUGHLY_SETTLED_PX = 0.015, 0.2

CLEAN = 0.85  # score of a ball so clear that nothing else is looked for inside it

# When is a round thing a ball?
LEAST_SUPPORT = 0.41  # part of the rim where the edge lies on the fitted curve, for a long rim
CHANCE = 1.2  # a rim of n px must have CHANCE / √n more: few pixels look round by chance
MOST_OVERFLOW = 0.1  # part of the rim beyond which the colour goes on
MOST_RAGGED = 0.4  # part of the rim that is missing, outside one gap
LEAST_FILL = 0.5  # part of the inside that has the ball's colour
LEAST_CONTRAST = 10.0  # grey levels across the edge
LEAST_DROP = 0.3  # in likeness, 0…1, where the ball's colour ends
LEAST_SHADE = 0.15  # a ball is lighter on one side; a printed disc is flat


@dataclass(frozen=True)
class Round:
    """A round thing: centre and radius in px, how much of its rim and inside agrees, and a score."""

    center: tuple
    radius_px: float
    support: float
    fill: float
    shade: float
    score: float


def find_balls(image, color, camera=None, offset=(0, 0)):
    """All balls of a colour, best first.

    Parameters
    ----------
    image : ndarray, BGR; a whole picture or a window of one
    color : has ``likeness(image)``
    camera : (matrix, distortion) or None
    offset : (x, y) of the window's first pixel in the picture

    Returns
    -------
    list of Round, in pixels of the whole picture
    """
    for scale in _scales(image.shape[1]):
        balls = []
        for circle in _circles(image, color, scale):
            if any(ball.score > CLEAN and _within(circle, ball, offset) for ball in balls):
                continue
            ball = measure(image, circle, color, camera, offset)
            if ball is not None and ball.score > 0:
                balls.append(ball)
        if balls:
            return sorted(_distinct(balls), key=_weight, reverse=True)
    return []


def _scales(width):
    """Look in a small picture first; where nothing is found, once more in one twice as fine."""
    coarse = min(1.0, SEARCH_WIDTH / width)
    return (coarse,) if coarse == 1.0 else (coarse, min(1.0, 2 * coarse))


def least_radius(width):
    """The smallest ball worth looking for in a picture of this width, px."""
    return max(LEAST_RADIUS_PX, LEAST_OF_WIDTH * width)


def _within(circle, ball, offset):
    """True where a circle starts inside a ball that is found already."""
    u, v = ball.center[0] - offset[0], ball.center[1] - offset[1]
    return np.hypot(circle[0] - u, circle[1] - v) < 0.6 * ball.radius_px


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


# --- where to look -------------------------------------------------------------------------------------


def _circles(image, color, scale):
    """Circles (u, v, r) that follow the outline of a blob of the colour, in pixels of ``image``."""
    small = image if scale == 1 else cv2.resize(image, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
    mask = (color.likeness(small) > 90).astype(np.uint8)
    mask = cv2.morphologyEx(mask, cv2.MORPH_CLOSE, np.ones((3, 3), np.uint8))
    count, labels, stats, _ = cv2.connectedComponentsWithStats(mask, connectivity=4)
    areas = stats[1:, cv2.CC_STAT_AREA]
    least = max(6, np.pi * (least_radius(image.shape[1]) * scale) ** 2 * 0.5)
    order = [i + 1 for i in np.argsort(-areas)[:MOST_BLOBS] if areas[i] >= least]
    rng = np.random.default_rng(1)
    circles = []
    for label in order:
        x, y, w, h = stats[label, :4]
        blob = np.pad((labels[y : y + h, x : x + w] == label).astype(np.uint8), 1)
        for u, v, r in _circles_of_blob(blob, rng):
            circles.append(((u + x - 1 + 0.5) / scale - 0.5, (v + y - 1 + 0.5) / scale - 0.5, r / scale))
    return circles


def _circles_of_blob(blob, rng):
    """The largest circle inside the blob, and those with the most of the outline on them."""
    inner = cv2.distanceTransform(blob, cv2.DIST_L2, 5)
    _, radius, _, (u, v) = cv2.minMaxLoc(inner)
    circles = [(float(u), float(v), float(radius))]
    outlines, _ = cv2.findContours(blob, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    points = max(outlines, key=len).reshape(-1, 2).astype(float)
    if len(points) < 8:
        return circles
    points = points[:: max(1, len(points) // 400)]
    return circles + _circles_of_outline(points, max(blob.shape), rng)


def _circles_of_outline(points, largest, rng):
    """Circles through random triples of neighbouring points, by how much outline they carry."""
    n = len(points)
    first = rng.integers(n, size=TRIALS)
    span = rng.uniform(0.08, 0.33, TRIALS) * n
    triples = np.stack([first, (first + span).astype(int) % n, (first + 2 * span).astype(int) % n], 1)
    centers, radii = _through(points[triples])
    good = np.isfinite(radii) & (radii > 1.5) & (radii < 0.75 * largest)
    centers, radii = centers[good], radii[good]
    if not len(radii):
        return []
    distance = np.hypot(points[None, :, 0] - centers[:, :1], points[None, :, 1] - centers[:, 1:])
    near = np.abs(distance - radii[:, None]) < np.maximum(0.8, 0.06 * radii)[:, None]
    support = near.sum(1) * (1 + 0.02 * radii.clip(0, 20)) / (2 * np.pi * radii)
    chosen = []
    for k in np.argsort(-support):
        far = [np.hypot(*(centers[k] - centers[j])) > 0.5 * radii[k] for j in chosen]
        if support[k] > 0.25 and all(far):
            chosen.append(k)
        if len(chosen) == MOST_CIRCLES:
            break
    return [(centers[k, 0], centers[k, 1], radii[k] + 0.5) for k in chosen]


def _through(triples):
    """Centre and radius of the circles through three points each, shapes (N, 2) and (N,)."""
    a, b, c = triples[:, 0], triples[:, 1], triples[:, 2]
    ab, ac = b - a, c - a
    cross = 2 * (ab[:, 0] * ac[:, 1] - ab[:, 1] * ac[:, 0])
    with np.errstate(divide="ignore", invalid="ignore"):
        ux = (ac[:, 1] * (ab**2).sum(1) - ab[:, 1] * (ac**2).sum(1)) / cross
        uy = (ab[:, 0] * (ac**2).sum(1) - ac[:, 0] * (ab**2).sum(1)) / cross
    return a + np.stack([ux, uy], 1), np.hypot(ux, uy)


# --- how round it is ------------------------------------------------------------------------------------


def measure(image, circle, color, camera=None, offset=(0, 0)):
    """Follow the edge of one round thing and judge it: a :class:`Round`, or None.

    First where the *ball's colour* ends, which marbling and shade do not disturb; then, from there,
    where *any* colour changes most, which is more exact and sees a red ball before a red cloth.
    """
    rough = _follow(image, circle, lambda u, v, r, band: color_edge(image, u, v, r, band, color), 0.06, None, offset)
    start = circle if rough is None else (rough.u, rough.v, rough.radius_px)
    fine = _follow(
        image, start, lambda u, v, r, band: edge_points(image, u, v, r, band), 0.05, camera, offset, rough, True
    )
    if fine is not None and rough is not None and not _agree(fine, rough):
        fine = None
    curve = fine or rough
    if curve is None:
        return None
    u, v, radius = curve.u, curve.v, curve.radius_px
    support, overflow, ragged, seen = _rim(image, curve, color)
    fill, shade = _inside(image, u, v, radius, color)
    score = _score(support, overflow, ragged, 2 * np.pi * radius, fill, shade, seen)
    center = curve.center
    return Round((center[0] + offset[0], center[1] + offset[1]), curve.ball_radius_px, support, fill, shade, score)


def _follow(image, circle, edge, share, camera, offset, curve=None, exact=False):
    """Fit a curve to the edge, look again round that curve, until it stays where it is.

    Unless ``exact``, the curve is a circle and need not settle finely: it only says where to look.
    """
    u, v, radius = circle
    height, width = image.shape[:2]
    for step in range(MOST_PASSES):
        inside = -radius < u < width + radius and -radius < v < height + radius
        if not (least_radius(width) <= radius <= 0.6 * max(height, width) and inside):
            return None
        wide = curve is None
        points, strong, _ = edge(u, v, radius, max(3.0, 0.45 * radius) if wide else max(2.5, 0.16 * radius))
        if strong.sum() < max(6, 0.3 * len(points)):
            return None
        tolerance = max(0.6, share * radius)
        if wide or step == 0:
            curve = fit_circle(points[strong], tolerance)
        if curve is not None and exact and (step or not wide):
            curve = _exact(points[strong], curve, camera, offset, tolerance) or curve
        elif curve is not None and not wide and step:
            curve = _again(points[strong], curve, tolerance)
        if curve is None:
            return None
        moved = np.hypot(curve.u - u, curve.v - v) + abs(curve.radius_px - radius)
        u, v, radius = curve.u, curve.v, curve.radius_px
        if step > 0 and moved < (SETTLED_PX if exact else ROUGHLY_SETTLED_PX):
            break
    return curve


def _agree(fine, rough):
    """True where both edges tell of the same ball."""
    allowed = 1.0 + 0.12 * rough.radius_px
    apart = np.hypot(fine.u - rough.u, fine.v - rough.v)
    return apart < allowed and abs(fine.radius_px - rough.radius_px) < allowed


def _rim(image, curve, color):
    """How the rim agrees with the curve, as parts of all rays.

    Returns
    -------
    support : rays with one of the two edges on the curve
    overflow : rays on which the ball's colour goes on beyond the curve with no edge there: no ball does
    ragged : rays without support outside the longest gap: one thing before a ball hides one arc of it
    seen : rays whose edge is in the picture
    """
    u, v, radius = curve.u, curve.v, curve.radius_px
    band = max(2.5, 0.16 * radius)
    sharp, clear, seen = edge_points(image, u, v, radius, band)
    ends, ending, _ = color_edge(image, u, v, radius, band, color)
    on_curve = clear & (np.abs(curve.residuals(sharp)) < max(0.5, 0.04 * radius))
    on_curve |= ending & (np.abs(curve.residuals(ends)) < max(0.8, 0.06 * radius))
    beyond = _beyond(image, u, v, radius, len(on_curve), color)
    ragged = (~on_curve).sum() - _longest_gap(~on_curve)
    return float(on_curve.mean()), float((beyond & ~on_curve).mean()), float(ragged / len(on_curve)), seen


def _beyond(image, u, v, radius, count, color):
    """For each ray, whether the ball's colour is found just outside the rim."""
    angle = np.arange(count) * 2 * np.pi / count
    radii = radius + max(1.5, 0.08 * radius) + np.array([0.0, 0.5, 1.0]) * max(1.0, 0.05 * radius)
    x = (u + np.cos(angle)[:, None] * radii).astype(np.float32)
    y = (v + np.sin(angle)[:, None] * radii).astype(np.float32)
    colors = cv2.remap(image, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return color.likeness(colors).mean(1) > 110


def _longest_gap(missing):
    """Length of the longest run of True in a ring; single rays between do not end it."""
    if missing.all():
        return len(missing)
    start = int(np.argmin(missing))
    ring = np.roll(missing, -start)
    edges = np.flatnonzero(np.diff(np.concatenate([[0], ring.astype(int), [0]])))
    return int((edges[1::2] - edges[::2]).max(initial=0))


def _score(support, overflow, ragged, rim_px, fill, shade, seen):
    """0 where one condition fails, else up to 1."""
    enough = LEAST_SUPPORT + CHANCE / np.sqrt(rim_px)
    if support < enough or overflow > MOST_OVERFLOW or overflow + ragged > MOST_RAGGED:
        return 0.0
    if fill < LEAST_FILL or shade < LEAST_SHADE or seen < 0.5:
        return 0.0
    return float(support * (1 - overflow) * (1 - ragged) * min(1.0, fill / 0.9))


def _rays(u, v, radius, band):
    """Directions, sample distances and sample places of rays across the rim of a circle."""
    count = int(np.clip(2 * np.pi * radius, 40, 140))
    angle = np.arange(count) * 2 * np.pi / count
    ray = np.stack([np.cos(angle), np.sin(angle)], 1)
    step = max(0.25, 2 * band / 64)
    radii = np.arange(max(0.0, radius - band), radius + band, step)
    x = (u + ray[:, :1] * radii).astype(np.float32)
    y = (v + ray[:, 1:] * radii).astype(np.float32)
    return ray, radii, x, y, step


def edge_points(image, u, v, radius, band):
    """Where the colour changes along rays from a centre.

    Each ray is sampled from ``radius - band`` to ``radius + band``. Its colours are projected on the
    difference between its inner and its outer end; the edge is the centroid of the steepest change.

    Returns
    -------
    points : ndarray, shape (rays, 2), px
    strong : ndarray of bool, shape (rays,): the edge is clear, and inside the picture
    seen : float, part of the rays whose edge is inside the picture
    """
    ray, radii, x, y, step = _rays(u, v, radius, band)
    colors = _along(_light(image, x, y), max(0.1, 0.6 / step))
    third = max(2, len(radii) // 3)
    across = colors[:, :third].mean(1) - colors[:, -third:].mean(1)
    contrast = np.linalg.norm(across, axis=1)
    slope = -np.einsum("rkc,rc->rk", np.diff(colors, axis=1), across / np.maximum(contrast, 1e-6)[:, None])
    place, steep = _peak(slope, (radii[:-1] + radii[1:]) / 2, step, 1.5)
    points = np.array([u, v]) + ray * place[:, None]
    inside = _in_picture(points, image)
    return points, inside & (contrast > LEAST_CONTRAST) & (steep > 0), float(inside.mean())


def color_edge(image, u, v, radius, band, color):
    """Where the ball's colour ends along rays from a centre; returns the same as :func:`edge_points`."""
    ray, radii, x, y, step = _rays(u, v, radius, band)
    colors = cv2.remap(image, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    likeness = _along(color.likeness(colors).astype(np.float32) / 255, max(0.7, 0.04 * radius) / step)
    third = max(2, len(radii) // 3)
    drop = likeness[:, :third].mean(1) - likeness[:, -third:].mean(1)
    place, steep = _peak(-np.diff(likeness, axis=1), (radii[:-1] + radii[1:]) / 2, step, max(1.5, 0.1 * radius))
    points = np.array([u, v]) + ray * place[:, None]
    inside = _in_picture(points, image)
    return points, inside & (drop > LEAST_DROP) & (steep > 0), float(inside.mean())


def _along(profiles, sigma):
    """Blur along the rays (axis 1) and not across them."""
    return cv2.GaussianBlur(profiles, (0, 0), sigmaX=sigma, sigmaY=0.01, borderType=cv2.BORDER_REPLICATE)


def _in_picture(points, image):
    return ((points > 0.5) & (points < np.array(image.shape[1::-1]) - 1.5)).all(1)


# Cameras store brightness on a curve (sRGB, close to the power 1/2.2). Blur mixes light, not stored
# values: on the stored ones the edge of a dark ball before a white wall would move inwards.
LINEAR = (255 * (np.arange(256) / 255.0) ** 2.2).astype(np.float32)


def _light(image, x, y):
    """Linear light at sub-pixel places of the picture, shape (*x.shape, 3)."""
    x0, y0 = max(0, int(x.min()) - 2), max(0, int(y.min()) - 2)
    part = LINEAR[image[y0 : int(y.max()) + 4, x0 : int(x.max()) + 4]]
    return cv2.remap(part, x - x0, y - y0, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)


def _peak(slope, middle, step, reach_px):
    """Centroid of the slope round its highest value, for every ray."""
    best = slope.argmax(1)
    reach = max(2, int(round(reach_px / step)))
    index = np.clip(best[:, None] + np.arange(-reach, reach + 1), 0, slope.shape[1] - 1)
    near = np.clip(np.take_along_axis(slope, index, 1), 0, None)
    total = near.sum(1)
    place = (near * middle[index]).sum(1) / np.maximum(total, 1e-9)
    return place, np.take_along_axis(slope, best[:, None], 1)[:, 0]


def _inside(image, u, v, radius, color):
    """Part of the inside with the ball's colour, and how much its brightness changes across it."""
    angle, part = np.meshgrid(np.arange(24) * np.pi / 12, np.sqrt((np.arange(8) + 0.5) / 8) * 0.85)
    x = (u + radius * part * np.cos(angle)).astype(np.float32)
    y = (v + radius * part * np.sin(angle)).astype(np.float32)
    colors = cv2.remap(image, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    ball_like = color.likeness(colors) > 60
    if ball_like.sum() < 8:
        return float(ball_like.mean()), 0.0
    bright = colors.max(-1).astype(float)[ball_like]
    terms = np.stack([np.ones_like(bright), (x - u)[ball_like] / radius, (y - v)[ball_like] / radius], 1)
    slope = np.linalg.lstsq(terms, bright, rcond=None)[0]
    shade = 2 * 0.85 * np.hypot(slope[1], slope[2]) / max(slope[0], 1.0)
    return float(ball_like.mean()), float(shade)


# --- curves ---------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Circle:
    """A circle; what a far, central ball looks like."""

    u: float
    v: float
    radius_px: float

    @property
    def center(self):
        return self.u, self.v

    @property
    def ball_radius_px(self):
        return self.radius_px

    def residuals(self, points):
        return np.hypot(points[:, 0] - self.u, points[:, 1] - self.v) - self.radius_px


@dataclass(frozen=True)
class Ellipse:
    """An ellipse: semi-axes a, b and the direction of a."""

    u: float
    v: float
    a: float
    b: float
    angle: float

    @property
    def center(self):
        return self.u, self.v

    @property
    def radius_px(self):
        return float(np.sqrt(self.a * self.b))

    @property
    def ball_radius_px(self):
        return min(self.a, self.b)

    def residuals(self, points):
        c, s = np.cos(self.angle), np.sin(self.angle)
        d = points - [self.u, self.v]
        along, across = (d @ [c, s]) / self.a, (d @ [-s, c]) / self.b
        return (np.hypot(along, across) - 1) * self.radius_px


@dataclass(frozen=True, eq=False)
class Cone:
    """A cone of rays: unit axis, half angle; seen through one camera."""

    axis: np.ndarray
    half_angle: float
    camera: tuple
    offset: tuple

    @property
    def center(self):
        matrix, distortion = self.camera
        pixel = cv2.projectPoints(self.axis.reshape(1, 1, 3), np.zeros(3), np.zeros(3), matrix, distortion)[0].ravel()
        return float(pixel[0] - self.offset[0]), float(pixel[1] - self.offset[1])

    @property
    def u(self):
        return self.center[0]

    @property
    def v(self):
        return self.center[1]

    @property
    def ball_radius_px(self):
        return float(self.camera[0][0, 0] * np.tan(self.half_angle))

    @property
    def radius_px(self):
        return self.ball_radius_px / float(self.axis[2]) ** 1.5

    def residuals(self, points):
        rays = to_rays(points, self.camera, self.offset)
        angle = np.arctan2(np.linalg.norm(np.cross(rays, self.axis), axis=1), rays @ self.axis)
        return (angle - self.half_angle) * self.camera[0][0, 0] / float(self.axis[2]) ** 1.5


def to_rays(points, camera, offset=(0, 0)):
    """Unit vectors from the camera through raw pixels, shape (N, 3)."""
    matrix, distortion = camera
    pixels = (np.asarray(points, float) + offset).reshape(-1, 1, 2)
    flat = cv2.undistortPoints(pixels, matrix, distortion).reshape(-1, 2)
    rays = np.column_stack([flat, np.ones(len(flat))])
    return rays / np.linalg.norm(rays, axis=1, keepdims=True)


def fit_cone(points, camera, offset, weights):
    """The cone whose surface holds the rays: a·ray = cos α, solved for a / cos α by least squares."""
    rays = to_rays(points, camera, offset)
    scaled = np.linalg.lstsq(rays * weights[:, None], weights, rcond=None)[0]
    length = np.linalg.norm(scaled)
    if not length > 1:
        return None
    return Cone(scaled / length, float(np.arccos(1 / length)), camera, offset)


def fit_circle(points, tolerance):
    """A circle through most of the points: robust start, then weighted least squares."""
    rng = np.random.default_rng(2)
    triples = rng.integers(len(points), size=(60, 3))
    centers, radii = _through(points[triples])
    good = np.isfinite(radii)
    centers, radii = centers[good], radii[good]
    if not len(radii):
        return None
    distance = np.hypot(points[None, :, 0] - centers[:, :1], points[None, :, 1] - centers[:, 1:])
    held = (np.abs(distance - radii[:, None]) < tolerance).sum(1)
    k = int(held.argmax())
    return _again(points, Circle(*centers[k], radii[k]), tolerance)


def _again(points, circle, tolerance):
    """Weighted least squares from a circle that is nearly right; far points count nothing."""
    for _ in range(3):
        weights = _trust(circle.residuals(points), tolerance)
        if np.count_nonzero(weights) < 5:
            return None
        circle = _solve_circle(points, weights)
    return circle


def _solve_circle(points, weights):
    """Least squares for x² + y² = 2·u·x + 2·v·y + (r² − u² − v²)."""
    middle = points.mean(0)
    local = points - middle
    terms = np.column_stack([2 * local, np.ones(len(points))]) * weights[:, None]
    a, b, c = np.linalg.lstsq(terms, (local**2).sum(1) * weights, rcond=None)[0]
    return Circle(float(a + middle[0]), float(b + middle[1]), float(np.sqrt(max(c + a * a + b * b, 1e-6))))


def _trust(residuals, tolerance):
    """Tukey's biweight: far points count nothing."""
    scale = 1.4826 * np.median(np.abs(residuals)) * 3.5
    limit = min(max(scale, 0.25), max(3 * tolerance, 0.5))
    return np.clip(1 - (residuals / limit) ** 2, 0, None)


def _exact(points, curve, camera, offset, tolerance):
    """The cone (with a camera) or the ellipse (without) through the same edge."""
    for _ in range(2):
        weights = _trust(curve.residuals(points), tolerance)
        if (weights > 0).sum() < 8:
            return None
        better = fit_cone(points, camera, offset, weights) if camera is not None else _solve_ellipse(points, weights)
        if better is None:
            return None
        curve = better
    return curve


def _solve_ellipse(points, weights):
    """An ellipse where most of the rim is seen (``cv2.fitEllipseDirect``), else None: a circle is safer."""
    kept = points[weights > 0.2].astype(np.float32)
    if len(kept) < 12 or len(kept) < 0.75 * len(points):
        return None
    (u, v), (width, height), turn = cv2.fitEllipseDirect(kept.reshape(-1, 1, 2))
    if not (np.isfinite([u, v, width, height]).all() and min(width, height) > 0.75 * max(width, height)):
        return None
    return Ellipse(float(u), float(v), width / 2, height / 2, np.radians(turn))

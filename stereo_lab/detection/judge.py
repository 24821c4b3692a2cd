"""The judge: how probable it is that a thing is the ball. Plain evidence, weighed; nothing has a veto.

One thing in the picture is the ball, or none is: a conditional logit with "none" among the choices. Each piece of evidence
has a weight, its square has one, and each two have one together: a little of something may be best, and no shade speaks
against a ball, more so where its edge is clear.
The weights are those that came with the ball's colour: the shipped ones, or learned ones (:mod:`stereo_lab.detection.own`).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import cv2
import numpy as np

from stereo_lab.detection.cone import ON, ON_PX, Cone
from stereo_lab.detection.model import Circle
from stereo_lab.detection.outline import ANGLE, EACH, RAYS, RING
from stereo_lab.detection.weights import SHIPPED

PERHAPS = 60  # likeness, of 255: may be the ball's colour
OUTSIDE = 110  # mean likeness of a ray beyond the rim: the ball's colour goes on there
ENDS_PX, ENDS = 0.8, 0.08  # px, or of the radius: so near to the cone the colour ends on it
RIM_PX, RIM = 1.2, 0.06  # so far to both sides of the cone is neither inside nor outside
SAME = 0.5  # of the radius: things nearer than this are one
LOBES = 0.3  # radii: an edge farther off the rim is another thing's
# All three channels tell of shade: in hard light the greatest one is full all over a ball, and below DIM, of 255, one is mostly noise
DIM = 64
FEW_RAYS, USUAL_LOBES = 12, 0.06  # too few clear rays tell no lobes
MOST_LOGIT = 50.0  # beyond it all is certain, and the odds stay a number

EVIDENCE = SHIPPED.names

PARTS = np.sqrt((np.arange(6) + 0.5) / 6) * 0.85
DISC = (RING[:, ::3, None] * PARTS).reshape(2, -1).astype(np.float32)  # places inside, in radii
DISC_SPREAD, DISC_SUM = float((DISC[0] ** 2).mean()), np.ones_like(DISC[0])
WAVES = np.column_stack([wave(crests * ANGLE) for crests in (2, 3, 4) for wave in (np.cos, np.sin)])


class Thing(NamedTuple):
    """Something that may be the ball: its cone, the evidence, and the weighted sum of it (logit)."""

    cone: Cone
    evidence: np.ndarray
    logit: float


def judge(cone: Cone, colored_px: float) -> Thing:
    """The thing, its evidence taken and weighed; ``colored_px``: pixels of the ball's colour where it was looked for."""
    evidence = evidence_of(cone, colored_px)
    color, size = cone.look.color, cone.outline_px / cone.look.width
    return Thing(cone, evidence, color.weights.logit(evidence) + color.sizes.logit(size))


def evidence_of(cone: Cone, colored_px: float) -> np.ndarray:
    """What speaks for a ball, in the order of EVIDENCE.

    Contrast of likeness between inside and outside, and likeness just within the rim. Of the rays in the picture:
    those with a light edge on the cone (rim), those where the colour ends there (ends). Of all rays: those in the
    picture where it goes on without an edge (overflow), and the longest arc without a break that has an edge on the cone: half of a
    ball that looks out behind something is one, an egg's outline crosses its circle four times. Beyond: how far
    edges lie outside the cone on average; what hides a ball only cuts it off. Unsure: the standard deviation of the
    radius, in radii, by how the edges scatter. Lobes: how much the outline swells in two to four places, as an
    egg's or a box's does; astray: how far from the rim the colour ends on average. Shade: how much lighter one side
    is; a printed disc is even, but so is a ball in even light. Dark: by what part the darkest tenth of it is darker
    than half of it; a ball has no seams and no shadows. Unique: the part of all pixels of this colour that it has.
    Size is none of these: how large a ball looks tells of the camera that took the pictures. (Where the ball was marked in
    them, its size counts beside these: Sizes.) Nor is how sharp its rim is: in the logarithms of astray and beyond a tenth
    and a twentieth of a radius are added, so that less tells little.
    """
    look, r = cone.look, cone.outline_px
    rim = cone.off - cone.gap  # how far beyond the look's circle the cone lies on each ray
    edges = look.ball_edge, look.color_edge
    (light_gaps, light_clear), (color_gaps, color_clear) = [(off - rim, weight > 0) for off, weight in edges]
    astray = np.abs(color_gaps)
    on = light_clear & (np.abs(light_gaps) < max(ON_PX, ON * r))
    ends = color_clear & (astray < max(ENDS_PX, ENDS * r))
    edged = on | ends
    past = look.off[:, None] - rim.astype(np.float32)
    margin = max(RIM * r, RIM_PX)
    outer, inner = (past > margin).astype(np.float32), past < -margin
    outside = EACH.dot(look.like * outer) / (EACH.dot(outer) + 1e-3)
    within = float(look.like.ravel().dot(inner.ravel())) / (np.count_nonzero(inner) + 1e-3)
    seen = max(1, int(np.count_nonzero(look.seen)))
    fill, shade, dark = _inside(cone)
    return np.array([
        (within - outside.dot(look.seen) / seen) / 255,
        np.count_nonzero(on) / seen,
        np.count_nonzero(ends) / seen,
        np.count_nonzero(~edged & look.seen & (outside > OUTSIDE)) / RAYS,
        math.log(_lobes(color_gaps, color_clear, r) + 0.01),
        math.log(_mean(astray, color_clear, r) + 0.1),
        math.log(shade + 0.02),
        math.log(dark + 0.02),
        min(1.2, fill * np.pi * r * r / max(1.0, colored_px)),
        within / 255,
        _longest_arc(edged),
        math.log(_mean(np.maximum(light_gaps, 0), light_clear, r) + 0.05),
        math.log(cone.scatter_px[1] / r + 0.001),
    ])  # fmt: skip


def _inside(cone):
    """Part of the inside that has the ball's colour; of that, how its light changes from the middle to the rim, and how dark it gets.

    The change is that of all three channels, as a part of each one's mean; the darkness, how far the darkest tenth is below
    the median, as a part of the mean.
    """
    look, r = cone.look, np.float32(cone.outline_px)
    x, y = DISC[0] * r + np.float32(cone.u - look.left), DISC[1] * r + np.float32(cone.v - look.top)
    colors = cv2.remap(look.patch, x[None], y[None], cv2.INTER_NEAREST, borderMode=cv2.BORDER_REPLICATE)
    ours = look.color.likeness(colors)[0, :, None] > PERHAPS
    count = max(1, np.count_nonzero(ours))
    light = (colors[0] * ours).astype(np.float32)
    mean = DISC_SUM.dot(light) / count
    slope = (DISC.dot(light) - DISC.dot(ours) * mean) / np.maximum(mean, DIM)
    shade = math.hypot(*slope.ravel().tolist()) / (count * DISC_SPREAD)
    bright = np.sort(light.dot(EACH[:3]))[-count:]  # what is not ours is 0
    dark = (bright[count // 2] - bright[count // 10]) / max(1.0, mean.sum())
    return count / len(ours), shade, float(dark)


def _mean(px, clear, r):
    """Mean over the clear rays, in radii."""
    return px.dot(clear) / (r * max(1, int(np.count_nonzero(clear))))


def _longest_arc(edged):
    """The longest run of neighbouring rays, part of all: twice round, for it may cross the first ray."""
    return min(max(map(len, (2 * edged.tobytes()).split(b"\0"))), RAYS) / RAYS


def _lobes(gaps, clear, r):
    """Size of the outline's waves with two, three and four crests, in radii: the first terms of a Fourier series."""
    near = clear & (np.abs(gaps) < 0.5 + LOBES * r)
    count = np.count_nonzero(near)
    if count < FEW_RAYS:
        return USUAL_LOBES
    heights = ((gaps - gaps.dot(near) / count) * near).dot(WAVES)
    return math.sqrt(2 * heights.dot(heights)) / (count * r)


def ranking(things: list[Thing]) -> list[tuple[Thing, float]]:
    """Each distinct thing with the probability that it, and not another thing or none, is the ball; best first."""
    return [(things[k], p) for k, p in zip(*_distinct(things), strict=True)]


def _distinct(things):
    return distinct([t.cone.circle for t in things], [t.logit for t in things])


def distinct(circles: Sequence[Circle], logits: Sequence[float]) -> tuple[list[int], list[float]]:
    """The numbers of the distinct things, most probable first, and how probable each is: two looks at one tell less than looks at two."""
    kept: list[int] = []
    for k in sorted(range(len(circles)), key=lambda k: -logits[k]):
        u, v, r = circles[k]
        if all(math.hypot(u - circles[j][0], v - circles[j][1]) >= SAME * max(r, circles[j][2]) for j in kept):
            kept.append(k)
    odds = [math.exp(min(logits[k], MOST_LOGIT)) for k in kept]
    total = 1 + sum(odds)
    return kept, [one / total for one in odds]


def sureness(things: list[Thing]) -> float:
    """The probability of the best of some things."""
    return max(_distinct(things)[1], default=0.0)

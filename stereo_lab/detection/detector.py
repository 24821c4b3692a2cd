"""One ball of one colour in one picture: candidates, their outline, the judge, the ball or none."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from stereo_lab.common.vectors import as_camera
from stereo_lab.detection import candidates as where
from stereo_lab.detection.color import BallColor
from stereo_lab.detection.cone import fit_cone
from stereo_lab.detection.judge import Thing, judge, ranking, sureness
from stereo_lab.detection.learning import MOST, most_colorful
from stereo_lab.detection.model import Camera, Circle, Detection, check_image, usual_camera
from stereo_lab.detection.outline import Look
from stereo_lab.detection.paper import detect_paper
from stereo_lab.errors import StereoLabError

BALL = 0.5  # probability from which a thing is called the ball
SURE, TRIED = 0.9, 0.7  # nothing else is looked for; no votes are counted
SECOND = 1.1  # log odds: where all that failed, a ball is three times less probable
LEAST_PX, LEAST_OF_WIDTH, MOST_OF_WIDTH = 3.0, 0.007, 0.6  # radii worth looking for
GLANCE_STEP, LONG_STEP = 1.5, 2.2  # not every pixel is looked at: so many in the least radius
GLANCES, BEST_VOTED = 6, 8  # patches that get a first look; circles with the most votes, whatever colour is round them
SMALLER, SAME_STEP = 0.2, 0.5  # a cone is smaller than its patch by this part at most, and half a step of the glance
WIDE, NARROW, SMEARED = 0.45, 0.3, 0.75  # how far from the outline a look reaches, in radii
STEADY, MOVED = 0.75, 0.6  # less of the rim on the cone: a wider look; moved by more of its reach: soft edges were cut
UNSURE = 0.01  # of the radius: a centre told less surely is looked for again; on plain grounds it is told to 0.003
WORSE = 1.5  # but if it is told so many times less surely then, the first look was the better one
# On a larger ball places lie too far apart: one more look, so many px to both sides, but not at a smear
LARGE_PX, FINE_PX = 40, 8

# Where the ball is expected and so much of the rim is on the cone, the probability of before fades a little: in 14 pictures,
# half a second of film, from 0.99 to ASKED. Below it the evidence is asked for again, and a part of the belief of before is kept:
CERTAIN, FADES, ASKED, KEPT, MOST_BELIEF = 0.8, 0.985, 0.8, 0.5, 0.99
REACHES, FINE_STEPS = (2, 7), 4  # radii that a ball may move from picture to picture; every r/4-th pixel is looked at
# Of a smear only the middle is surely of the ball's colour. It moved by more than its radius, its patch is shorter along its
# way than across (their ratio is below SHORT), and at least BLURRED of its rim is on the cone
SHORT, BLURRED = 0.88, 0.5
SHRUNK, GROWN, RESIZED, RESIZED_PX = 0.6, 1.5, 0.25, 1  # its patch may change so much, its cone less


class BallDetector:
    """Finds one ball in a picture.

    Parameters
    ----------
    color : BallColor, or the name of one, or the file of a ball that was learned (``stereo-lab train``)
    method : "paper", which takes any disc for a ball, or "cone"; a drawn or printed disc without shade is none for it
    camera : (matrix 3x3, distortion), optional
        Intrinsics of the camera that took the pictures, for an exact cone; without them a usual webcam's.
    best_guess : bool
        For those who know that a ball is there: the most probable thing is given, however improbable.
    """

    def __init__(
        self, color: BallColor | str, method: str = "cone", camera: Camera | None = None, best_guess: bool = False
    ) -> None:
        if method not in ("paper", "cone"):
            raise StereoLabError(f'There is no method {method!r}. Choose "paper" or "cone".')
        self.color = color if isinstance(color, BallColor) else BallColor.named(color)
        self.method, self.best_guess, self.camera = method, best_guess, None if camera is None else as_camera(camera)

    def detect(self, image: np.ndarray, near: Detection | None = None) -> Detection | None:
        """The ball, or None where there is none.

        ``image``: ndarray, shape (height, width, 3), BGR, uint8. ``near``: where the ball was seen last, or that one moved to
        where it is expected: it is looked for there first.
        """
        found = self.first(image, near)
        return found and self._surer(image, found)

    def first(self, image: np.ndarray, near: Detection | None = None) -> Detection | None:
        """As :meth:`detect`, but an edge that scatters is not looked for again."""
        image = check_image(image)
        if self.method == "paper":
            return detect_paper(image, self.color)
        followed, enough = (None, False) if near is None else self._who_saw(near)._follow(image, near)
        if enough:
            return followed
        best = next(iter(self.candidates(image, 1)), None)
        if best is not None and best.score >= BALL:
            return best
        return followed or (best if self.best_guess else None)

    def again(self, image: np.ndarray, ball: Detection) -> Detection:
        """A ball's edge measured anew: light or colours that vary round it count less. The ball as it was where that tells less."""
        if ball.cone is None or ball.sigma_px is None:
            return ball
        cone = self._who_saw(ball)._settle(check_image(image), ball.cone.circle, (ball.cone.look.share,), "quiet")
        if cone is None or not _same(cone, ball.cone):
            return ball
        found = _detection(cone._replace(smeared=ball.smeared), ball.score)
        return found if found.sigma_px < WORSE * ball.sigma_px else ball

    def _who_saw(self, ball):
        """The detector by whose colour a ball was found: by its name, or by what is most colourful of that name."""
        color = self.color if ball.cone is None else ball.cone.look.color
        return BallDetector(color, camera=self.camera) if color.name == MOST + self.color.name else self

    def _surer(self, image, ball):
        return self.again(image, ball) if unsure(ball) else ball

    def detect_all(self, image: np.ndarray) -> list[Detection]:
        """Every ball of the colour, each judged as if it were the only one; best first."""
        alone = [(ball, _probability(logit)) for ball, logit in self.weighed(image, most=100, everything=True)]
        return [self._surer(image, replace(ball, score=p)) for ball, p in alone if p >= BALL]

    def candidates(self, image: np.ndarray, most: int = 4) -> list[Detection]:
        """What may be the ball, best first, each with the probability that it, and not another thing or none, is it.

        Where one is sure, nothing else is looked for: of two balls alike this gives one, :meth:`detect_all` both.
        """
        return [ball for ball, _ in self.weighed(image, most)]

    def weighed(self, image: np.ndarray, most: int = 8, everything: bool = False) -> list[tuple[Detection, float]]:
        """The same with the logarithm of each one's odds against none: the other camera's picture can add its own evidence."""
        if self.method == "paper":
            raise StereoLabError("The paper's way finds one ball or none, no candidates. Use the method cone.")
        seen = self.things(check_image(image), everything)
        ranked = ranking(seen)
        if not (ranked and ranked[0][1] >= BALL) and (vivid := most_colorful(self.color, image)) is not None:
            tried = BallDetector(vivid, camera=self.camera).things(image, everything)
            ranked = ranking(seen + [thing._replace(logit=thing.logit - SECOND) for thing in tried])
        return [(_detection(thing.cone, p), thing.logit) for thing, p in ranked[:most]]

    def weighed_at(self, image: np.ndarray, circles: Sequence[Circle]) -> list[tuple[Detection, float]]:
        """The same by a long look at some places (u, v, radius), px."""
        step = max(1, round(_least_radius(check_image(image)) / LONG_STEP))
        things = self._look_at(image, 1, circles, _colored(self.color.likeness(image, step), step))
        return [(_detection(thing.cone, _probability(thing.logit)), thing.logit) for thing in things]

    def things(self, image: np.ndarray, everything: bool = False) -> list[Thing]:
        """Glance at the largest patches; look longer at patches of several levels; vote last."""
        least = _least_radius(image)
        step = max(1, round(least / GLANCE_STEP))
        like = self.color.likeness(image, step)
        colored = _colored(like, step)
        seen: list[Thing] = []
        enough = math.inf if everything else SURE
        for u, v, r in where.patches(like, where.SURELY, least / step)[:GLANCES]:
            cone = self._quick(image, (u * step, v * step, r * step), "ball")
            if cone is not None and _of_the_patch(cone, r, step):
                seen.append(judge(cone, colored))
                if sureness(seen) >= enough:
                    return seen
        step = max(1, round(least / LONG_STEP))
        like = self.color.likeness(image, step)
        places = [place for level in where.LEVELS for place in where.patches(like, level, least / step)]
        seen += self._look_at(image, step, where.promising(like, places), colored, enough)
        if everything or sureness(seen) < TRIED:
            circles = list(where.voted(like, np.ascontiguousarray(image[::step, ::step]), least / step))
            best = circles[:BEST_VOTED] + where.promising(like, circles[BEST_VOTED:])
            seen += self._look_at(image, step, best, colored, enough)
        return seen

    def _look_at(self, image, step, places, colored, enough=math.inf):
        """A long look at some places, until one is sure enough."""
        found: list[Thing] = []
        for place in places:
            circle = tuple(step * p for p in place)
            if all(_apart(circle, t.cone.circle) >= 0.1 * t.cone.outline_px for t in found):
                cone = self._measure(image, circle)
                found += [] if cone is None else [judge(cone, colored)]
                if sureness(found) >= enough:
                    break
        return found

    def _follow(self, image, near):
        """Of the patches round a prediction the nearest of the right size, then its edge: the ball or None, and whether that is enough.

        It is not where the evidence alone, without the belief of before, speaks against a ball: then a better one may be elsewhere.
        Of the ball's colour only that patch counts in it, for the rest of the picture is not looked at.
        """
        circle, reaches = (near.u, near.v, near.outline_px), REACHES[1:] if near.smeared else REACHES
        patches = (self._patch_near(image, circle, reach) for reach in reaches)
        patch = next((found for found in patches if found is not None), None)
        if patch is None:
            return None, False
        cone = self._edge_near(image, near, patch)
        if cone is None or abs(cone.radius_px - near.radius_px) > RESIZED * near.radius_px + RESIZED_PX:
            return None, False
        if cone.on >= (BLURRED if cone.smeared else CERTAIN) and near.score * FADES > ASKED:
            return _detection(cone, near.score * FADES), True
        belief = min(MOST_BELIEF, max(1 - MOST_BELIEF, near.score))
        evidence = judge(cone, np.pi * patch[2] ** 2).logit
        logit = KEPT * math.log(belief / (1 - belief)) + (1 - KEPT) * evidence
        return (None, False) if logit < 0 else (_detection(cone, _probability(logit)), evidence >= 0)

    def _edge_near(self, image, near, patch):
        """One look: a wide one at a smear, if it finds the rim, else as at any other patch."""
        u, v, _, sums = patch
        # Where it was seen: a ball that is expected elsewhere keeps its cone
        last = near if near.cone is None else near.cone
        r, du, dv = near.outline_px, u - last.u, v - last.v
        whole = r < u < image.shape[1] - r and r < v < image.shape[0] - r
        if whole and math.hypot(du, dv) > r and where.stretch(sums, du, dv) < SHORT:
            cone = self._settle(image, (u, v, r), (SMEARED,), "light")
            if cone is not None and cone.on >= BLURRED:
                return cone._replace(smeared=True)
        return self._quick(image, (u, v, r), "light")

    def _patch_near(self, image, circle, reach):
        """The patch of the right size nearest to a predicted circle: (u, v, radius, moments), or None. The window cuts none."""
        near_u, near_v, r = circle
        most, step = reach * r + 8, max(1, round(r / FINE_STEPS))
        left, top = max(0, int(near_u - most - r)), max(0, int(near_v - most - r))
        window = image[top : max(0, int(near_v + most + r)), left : max(0, int(near_u + most + r))]
        if min(window.shape[:2]) < 8:
            return None
        nearest, patch = most, None
        for sums in where.moments(self.color.likeness(window, step), where.SURELY):
            u, v, size = where.as_circle(sums)
            u, v, size = left + u * step, top + v * step, size * step
            away = math.hypot(u - near_u, v - near_v)
            if SHRUNK * r < size < GROWN * r and away < nearest:
                nearest, patch = away, (u, v, size, sums)
        return patch

    def _quick(self, image, circle, edge):
        """One look; a wider one where much of the rim is off the cone, as on a smeared ball; another if it moved far."""
        cone = self._settle(image, circle, (NARROW,), edge)
        if cone is None:
            return None
        if cone.on < STEADY:
            wider = self._settle(image, cone.circle, (SMEARED,), "ball")
            better = wider is not None and wider.on > cone.on
            return wider._replace(smeared=wider.on >= STEADY) if better else cone
        moved = _apart(cone.circle, circle)
        return cone if moved < MOVED * cone.look.band else self._settle(image, cone.circle, (NARROW,), edge) or cone

    def _measure(self, image, circle):
        """A long look: where the colour ends, which marbling and shade do not disturb; from there, the light's edge."""
        rough = self._settle(image, circle, (WIDE, NARROW), "color")
        cone = self._settle(image, circle if rough is None else rough.circle, (NARROW, NARROW), "ball")
        if rough is None or cone is None:
            return cone or rough
        return cone if _same(cone, rough) else rough

    def _settle(self, image, circle, shares, edge):
        """Look round a circle, fit the cone, look round that, and so on."""
        height, width = image.shape[:2]
        camera = usual_camera(image.shape) if self.camera is None else self.camera
        least, cone = _least_radius(image), None
        for share in shares:
            u, v, r = circle
            if not (-r < u < width + r and -r < v < height + r and least <= r <= MOST_OF_WIDTH * width):
                return None
            look = Look(image, self.color, camera, circle, share)
            cone = fit_cone(look, *getattr(look, f"{edge}_edge"))
            if cone is None:
                return None
            circle = cone.circle
        if shares[-1] < SMEARED and cone.outline_px > LARGE_PX and shares[-1] * cone.outline_px > FINE_PX:
            return self._settle(image, circle, (0.99 * FINE_PX / cone.outline_px,), edge) or cone
        return cone


def unsure(ball: Detection, part: float = UNSURE) -> bool:
    """Whether a ball's edge scatters so much that it is worth another look; that of a smear does, however one looks."""
    return ball.sigma_px is not None and not ball.smeared and ball.sigma_px > part * ball.radius_px


def _least_radius(image):
    """Of a ball worth looking for in a picture, px."""
    return max(LEAST_PX, LEAST_OF_WIDTH * image.shape[1])


def _colored(like, step):
    """Pixels of the ball's colour in the whole picture, of which every so manieth was looked at."""
    return max(1, np.count_nonzero(where.above(like, where.SURELY))) * step * step


def _of_the_patch(cone, r, step):
    """Whether a cone may be that of a patch of r steps: a smear leaves less of the sure colour than the ball has, never more."""
    return (1 - SMALLER) * r - SAME_STEP <= cone.outline_px / step <= r / SHRUNK


def _apart(circle, other):
    """How far a circle and another one differ, in place and size, px."""
    return math.hypot(circle[0] - other[0], circle[1] - other[1]) + abs(circle[2] - other[2])


def _same(cone, other):
    """Whether two cones may be one ball's."""
    return _apart(cone.circle, other.circle) <= 1 + 0.25 * other.outline_px


def _detection(cone, probability):
    return Detection(cone.u, cone.v, cone.radius_px, float(probability), *cone.sigmas_px, cone)


def _probability(logit):
    """Of one thing against none."""
    return 1 / (1 + math.exp(-logit))

"""Marked pictures: what is seen in each, how well weights answer them, and marks that nobody had to make."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import cv2
import numpy as np

from stereo_lab.detection.color import BallColor
from stereo_lab.detection.detector import BALL, BallDetector
from stereo_lab.detection.judge import EVIDENCE, distinct
from stereo_lab.detection.model import Circle, check_image
from stereo_lab.detection.training import weights_of
from stereo_lab.detection.weights import SHIPPED, Weights

CENTRE, SIZE = 0.5, 0.4  # of the radius: so near to the mark is the ball, to learn from
HIT_PX, HIT = 3.0, 0.25  # px, or of the radius: so near is right, as in lesson 02
FOLDS = 5
# How strongly weights are held to the shipped ones; to zero. Chosen on data/clutter alone
RIDGE, RIDGE_ALONE = 10.0, 3.0
SURELY, HARDLY, PROPOSED = 0.75, 0.2, (14, 6)  # scores from which a ball is proposed, and up to which none is; so many
THUMB, ALIKE = (32, 24), 2.0  # px; grey levels: pictures that differ less show the same scene


class Frame(NamedTuple):
    """What is seen in one marked picture.

    ``circle``: the mark, or None where no ball is. ``things``: circles of all that may be the ball, shape (n, 3), px.
    ``evidence``: shape (n, len(EVIDENCE)).
    """

    circle: Circle | None
    things: np.ndarray
    evidence: np.ndarray

    @property
    def is_ball(self) -> np.ndarray:
        """Which of the things are the marked ball, shape (n,)."""
        if self.circle is None:
            return np.zeros(len(self.things), bool)
        u, v, r = self.circle
        away = np.hypot(self.things[:, 0] - u, self.things[:, 1] - v)
        return (away < CENTRE * r) & (np.abs(self.things[:, 2] - r) < SIZE * r + 1)

    def ranked(self, weights: Weights) -> tuple[list[int], list[float]]:
        """Numbers of the distinct things, most probable first, and how probable each is."""
        return distinct(self.things.tolist(), weights.logits(self.evidence).tolist())

    def said(self, weights: Weights) -> tuple[Circle | None, float]:
        """The thing that is called the ball, or None, and how probable the best thing is."""
        kept, told = self.ranked(weights)
        if not kept:
            return None, 0.0
        return (tuple(self.things[kept[0]]) if told[0] >= BALL else None), told[0]


class Score(NamedTuple):
    """Answers to marked pictures: of ``balls`` so many ``right``, of ``empty`` ones so many ``answered``."""

    balls: int
    right: int
    empty: int
    answered: int


def is_right(said: Circle | None, circle: Circle | None) -> bool:
    """The right ball, or rightly none."""
    if said is None or circle is None:
        return said is circle is None
    return float(np.hypot(said[0] - circle[0], said[1] - circle[1])) <= max(HIT_PX, HIT * circle[2])


def look(detector: BallDetector, image: np.ndarray, circle: Circle | None) -> Frame:
    """Everything in a picture that may be the ball, with its evidence."""
    things = detector.things(check_image(image), everything=True)
    circles = np.array([t.cone.circle for t in things], float).reshape(-1, 3)
    return Frame(circle, circles, np.array([t.evidence for t in things], float).reshape(-1, len(EVIDENCE)))


def learn(frames: Sequence[Frame], start: Weights | None = SHIPPED, trained_on: str = "") -> Weights:
    """Weights from marked pictures: from the shipped ones on, or with ``start=None`` from nothing."""
    rows, balls, groups = [], [], []
    for number, frame in enumerate(frames):
        kept = frame.ranked(SHIPPED)[0]
        rows.append(frame.evidence[kept])
        balls.append(frame.is_ball[kept])
        groups.append(np.full(len(kept), number))
    group = np.unique(np.concatenate(groups), return_inverse=True)[1]
    ridge = RIDGE_ALONE if start is None else RIDGE
    return weights_of(
        group, np.concatenate(balls).astype(float), np.concatenate(rows), EVIDENCE, ridge, None, start, trained_on
    )


def score(frames: Sequence[Frame], weights: Weights) -> Score:
    """How marked pictures are answered."""
    return answers(frames, [frame.said(weights)[0] for frame in frames])


def answers(frames: Sequence[Frame], said: Sequence[Circle | None]) -> Score:
    """The same for answers, whoever gave them: (u, v, radius) or None for each picture."""
    right = [is_right(answer, frame.circle) for answer, frame in zip(said, frames, strict=True)]
    balls = [ok for ok, frame in zip(right, frames, strict=True) if frame.circle is not None]
    empty = [ok for ok, frame in zip(right, frames, strict=True) if frame.circle is None]
    return Score(len(balls), sum(balls), len(empty), len(empty) - sum(empty))


def unseen(frames: Sequence[Frame], kept_in: Sequence[int], start: Weights | None = SHIPPED) -> Score:
    """How pictures are answered by weights that were learned without them: each fifth by those of the other four.

    Neighbours look alike, so a fifth is a run of pictures and not every fifth one. ``kept_in``: pictures that never judge.
    """
    judges = [k for k in range(len(frames)) if k not in set(kept_in)]
    parts = [[k for k in judges if (frames[k].circle is None) == empty] for empty in (False, True)]
    total = np.zeros(4, int)
    for fold in range(FOLDS):
        held = {k for part in parts for k in np.array_split(part, FOLDS)[fold].tolist()}
        if held:
            weights = learn([frame for k, frame in enumerate(frames) if k not in held], start)
            total += score([frames[k] for k in sorted(held)], weights)
    return Score(*total.tolist())


def all_alike(images: Sequence[np.ndarray]) -> bool:
    """Whether most pictures have a twin among the others: then a test on some of them means nothing."""
    thumbs = [cv2.resize(image, THUMB, interpolation=cv2.INTER_AREA).astype(float) for image in images]
    apart = np.array([[np.abs(a - b).mean() for b in thumbs] for a in thumbs]) + np.diag([np.inf] * len(thumbs))
    return bool(np.median(apart.min(1)) < ALIKE)


def propose(images: Sequence[np.ndarray], color: BallColor | str) -> dict[int, Circle | None]:
    """Marks that nobody made: where a named colour is surest, and pictures in which it sees nothing at all.

    Parameters
    ----------
    images : sequence of ndarray, BGR
    color : BallColor or the name of one

    Returns
    -------
    dict, number of a picture -> (u, v, radius) or None; 14 balls and 6 empty pictures at most. Look at them before you train
    """
    detector = BallDetector(color)
    best = {k: next(iter(detector.candidates(image, 1)), None) for k, image in enumerate(images)}
    sure = {k: (b.u, b.v, b.outline_px) for k, b in best.items() if b is not None and b.score >= SURELY}
    none = [k for k, ball in best.items() if ball is None or ball.score <= HARDLY]
    chosen: dict[int, Circle | None] = dict.fromkeys(_spread_out(none, PROPOSED[1]))
    chosen.update({k: sure[k] for k in _spread_out(list(sure), PROPOSED[0])})
    return dict(sorted(chosen.items()))


def _spread_out(numbers, most):
    """At most so many of them, evenly spaced."""
    return [
        numbers[k] for k in np.unique(np.linspace(0, len(numbers) - 1, min(most, len(numbers))).round().astype(int))
    ]

"""A ball of one's own: marked in a few pictures, learned, judged on pictures it has not seen, kept in a file."""

from __future__ import annotations

import base64
import json
import zlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from stereo_lab.common.files import finite_number, read_json, write_whole
from stereo_lab.detection.color import BINS, BallColor
from stereo_lab.detection.detector import BallDetector
from stereo_lab.detection.judge import EVIDENCE, SAME, distinct
from stereo_lab.detection.marked import all_alike, learn, look, unseen
from stereo_lab.detection.model import Camera, Circle, check_image
from stereo_lab.detection.weights import SHIPPED, Sizes, Weights
from stereo_lab.errors import StereoLabError

FORMAT = "stereo_lab ball 1"
LEAST_BALLS, LEAST_EMPTY = 5, 2  # marked pictures of each kind
COLOR_MARKS = 6  # balls from which the colour is learned; they judge nothing


@dataclass(frozen=True, eq=False)
class OwnBall(BallColor):
    """A ball that was learned: a colour, weights, and where they come from. Goes wherever a BallColor goes.

    Attributes
    ----------
    trained_on : dict, what was learned from
    unseen : dict, how it did on pictures it had not seen
    """

    trained_on: dict[str, Any] = field(default_factory=dict)
    unseen: dict[str, Any] = field(default_factory=dict)

    @classmethod
    def train(
        cls,
        images: Sequence[np.ndarray],
        circles: Sequence[Circle | None],
        color: BallColor | str | None = None,
        start: Weights | None = SHIPPED,
        names: Sequence[str] = (),
        source: str = "",
        camera: Camera | None = None,
        progress: Callable[[int, int], object] = lambda done, total: None,
    ) -> OwnBall:
        """Learn a ball from pictures in which it is marked.

        Parameters
        ----------
        images : sequence of ndarray, BGR, in the order in which they were taken
        circles : sequence of (u, v, radius) in px, one for each picture, or None where there is no ball
        color : BallColor or the name of one, optional; else it is learned from up to six of the marks
        start : Weights, optional; None: from nothing
        names, source : what the pictures are called, and where they come from
        camera : (matrix, distortion), optional
        progress : callable (done, total)

        Raises
        ------
        StereoLabError
            If there is too little to learn from, or a mark is no ball.
        """
        names = tuple(names) or tuple(str(k) for k in range(len(images)))
        circles = [_checked(*row) for row in zip(images, circles, names, strict=True)]
        marked = [k for k, circle in enumerate(circles) if circle is not None]
        _check_enough(len(marked), len(circles) - len(marked))
        shown = marked[:: max(1, 2 * len(marked) // min(2 * COLOR_MARKS, len(marked)))][:COLOR_MARKS]
        if color is None:
            learned = BallColor.from_samples([images[k] for k in shown], [circles[k] or () for k in shown])
            color = replace(learned, sizes=Sizes())  # own weights are learned without them
        else:
            color, shown = BallColor.named(color) if isinstance(color, str) else color, []
        detector, frames = BallDetector(color, camera=camera), []
        for k, image in enumerate(images):
            frames.append(look(detector, image, circles[k]))
            progress(k + 1, len(images))
        lost = _without_outline(frames, names)
        kept = [k for k in range(len(frames)) if k not in lost]
        judged = unseen([frames[k] for k in kept], [kept.index(k) for k in shown if k in kept], start)
        trained_on = {
            "source": source, "pictures": ", ".join(names), "balls": len(marked), "empty": len(circles) - len(marked),
            "no_outline_at_the_mark": [names[k] for k in lost], "color": f"{color.name}, from {len(shown)} of the marks" if shown else color.name,
            "from": "nothing" if start is None else "the shipped weights",
        }  # fmt: skip
        told = {**judged._asdict(), "pictures_alike": all_alike(images)}
        weights = learn([frames[k] for k in kept], start)
        return cls("own", color.ranges, color.table, weights=weights, trained_on=trained_on, unseen=told)

    def save(self, path: str | Path) -> None:
        """Write it as JSON that people can read; only the colour's table is packed."""
        table = base64.b64encode(zlib.compress(self.table.tobytes(), 9)).decode()
        color = {"ranges": self.ranges, "bins": BINS, "table": table}
        head = {"format": FORMAT, "trained_on": self.trained_on, "unseen": self.unseen, "color": color}
        write_whole(
            path, json.dumps(head, indent=1, ensure_ascii=False)[:-2] + ',\n "weights": ' + self.weights.text() + "}\n"
        )

    @classmethod
    def load(cls, path: str | Path) -> OwnBall:
        """Read what :meth:`save` wrote.

        Raises
        ------
        StereoLabError
            If the file cannot be read, or is something else.
        """
        facts = read_json(path)
        if facts.get("format") != FORMAT:
            raise StereoLabError(f"{path} is no ball that was learned. Make one: stereo-lab train REC --out ball.json")
        try:
            weights = Weights.of(facts["weights"])
            if weights.names != EVIDENCE:
                raise StereoLabError("its evidence is that of another version")
            trained_on, judged = dict(facts["trained_on"]), dict(facts["unseen"])
            ranges, table = _color_from(facts["color"])
            return cls("own", ranges, table, weights=weights, trained_on=trained_on, unseen=judged)
        except (StereoLabError, KeyError, TypeError, ValueError, OverflowError, zlib.error) as error:
            why = f"{error} is missing" if isinstance(error, KeyError) else error
            raise StereoLabError(
                f"{path} is damaged: {why}. Train it again: stereo-lab train REC --out {path}"
            ) from None


def _checked(image, circle, name):
    """A mark that lies in its picture, or None."""
    if circle is None:
        return None
    u, v, r = (finite_number(value, f"the mark in picture {name}") for value in circle)
    height, width = check_image(image).shape[:2]
    if not (0 <= u < width and 0 <= v < height and 0 < r < max(width, height)):
        raise StereoLabError(
            f"The mark in picture {name}, u {u:g}, v {v:g}, radius {r:g} px, lies outside the picture of {width} x {height} px, or has no radius above 0. Mark it again."
        )
    return u, v, r


def _check_enough(balls, empty):
    if balls < LEAST_BALLS:
        raise StereoLabError(
            f"The ball is marked in {balls} picture{'s' * (balls != 1)}, and {LEAST_BALLS} at least are needed; ten or more are better. Mark it in others."
        )
    if empty < LEAST_EMPTY:
        raise StereoLabError(
            f"{empty} pictures are marked as having no ball, and {LEAST_EMPTY} at least are needed: from balls alone nothing learns to say none."
        )


def _without_outline(frames, names):
    """Numbers of marked pictures in which no outline agrees with the mark; refused where it holds two balls, or where they are many."""
    lost = []
    for k, (frame, name) in enumerate(zip(frames, names, strict=True)):
        if frame.circle is None or frame.is_ball.any():
            continue
        if _things_within(frame) > 1:
            raise StereoLabError(
                f"The mark in picture {name} holds more than one round thing of the ball's colour. Mark one ball, by its rim."
            )
        lost.append(k)
    balls = sum(frame.circle is not None for frame in frames)
    if 2 * len(lost) > balls or balls - len(lost) < LEAST_BALLS:
        raise StereoLabError(
            f"In {len(lost)} of {balls} marked pictures, such as {names[lost[0]]}, nothing round of one colour has its rim at the mark. Mark the ball's own rim."
        )
    return lost


def _things_within(frame):
    """How many distinct things lie in the mark, each a good part of it."""
    u, v, r = frame.circle
    inside = [
        k for k, (x, y, size) in enumerate(frame.things)
        if np.hypot(x - u, y - v) + size < 1.2 * r and size > 0.3 * r
    ]  # fmt: skip
    kept = distinct(frame.things[inside].tolist(), SHIPPED.logits(frame.evidence[inside]).tolist())[0]
    circles = frame.things[inside][kept]
    apart = [
        np.hypot(*(a[:2] - b[:2])) > (1 + SAME) / 2 * (a[2] + b[2]) for i, a in enumerate(circles) for b in circles[:i]
    ]
    return 2 if any(apart) else min(1, len(circles))


def _color_from(facts):
    """Ranges and table of a saved colour."""
    table = np.frombuffer(zlib.decompress(base64.b64decode(facts["table"], validate=True)), np.uint8)
    if facts["bins"] != BINS or table.size != BINS**3:
        raise StereoLabError(f"its colour is not a table of {BINS} steps a channel")
    ranges = tuple(tuple(tuple(map(int, bound)) for bound in span) for span in facts["ranges"])
    if not ranges or any(len(span) != 2 or any(len(bound) != 3 for bound in span) for span in ranges):
        raise StereoLabError("its colour has no bounds for hue, lightness and saturation")
    return ranges, table.reshape(BINS, BINS, BINS)

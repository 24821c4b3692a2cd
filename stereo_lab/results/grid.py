"""One change at a time: every way to find the ball's pixels with every way to turn them into a depth."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Any, cast

import cv2
import numpy as np

from stereo_lab.calibration import StereoCalibration
from stereo_lab.depth import IdealDepth, OffsetDepth, PaperDepth
from stereo_lab.detection import BallColor, BallDetector
from stereo_lab.errors import StereoLabError
from stereo_lab.localization import Localizer
from stereo_lab.localization.paper import PaperWay
from stereo_lab.position import RigidFit
from stereo_lab.recording import Recording, Sample

FORMULAS = ("Eq. 3", "Eq. 4, 3 samples", "Eq. 4, all samples", "a/(d−d0)+c, all samples", "rigid fit, all samples")

Centers = tuple[np.ndarray, np.ndarray]  # (u, v) in the left and in the right picture, rectified px
Finder = Callable[[Sample], Centers | None]
Seen = list[tuple[Sample, Centers]]


@dataclass(frozen=True, eq=False)
class DepthGrid:
    """Mean depth errors: a row for each way to find the pixels, a column for each of FORMULAS.

    Attributes
    ----------
    pixels : tuple of str, the rows
    mean_mm : ndarray, shape (rows, columns); NaN where too few samples were found to fit on, or no curve comes near them
    judged : int, balls to judge on
    left_out : tuple of int, for each row the balls of which no pixels were found, or another thing's, more than a radius
        from where ours sees the ball: they are counted here and left out of the mean
    """

    pixels: tuple[str, ...]
    mean_mm: np.ndarray
    judged: int
    left_out: tuple[int, ...]

    def rows(self) -> list[str]:
        """The rows' names for a figure, with how many balls were left out below them."""
        return [
            f"{name}\n({count} of {self.judged} left out)" if count else name
            for name, count in zip(self.pixels, self.left_out, strict=True)
        ]

    def page(self) -> str:
        """The grid as text."""
        wide = max(map(len, self.pixels)) + 1
        heads = [formula.split(", ") for formula in FORMULAS]
        lines = [" " * wide + "".join(f"{head[k] if k < len(head) else '':>13s}" for head in heads) for k in (0, 1)]
        for name, row, count in zip(self.pixels, self.mean_mm, self.left_out, strict=True):
            cells = "".join(f"{'-' if np.isnan(mm) else f'{mm:.1f}':>13s}" for mm in row)
            lines.append(name.ljust(wide) + cells + (f"  ({count} of {self.judged} left out)" if count else ""))
        return "\n".join(lines)


def depth_grid(recording: Recording, ours: Localizer, paper: Localizer) -> DepthGrid:
    """Fit and judge every formula on the pixels of every way, all on the same pictures.

    Parameters
    ----------
    recording : Recording
    ours, paper : Localizer, of the two ways, with one calibration
    """
    calibration, scenes = ours.calibration, _Scenes(recording, ours)
    judges, samples, balls = scenes.judges, scenes.samples, scenes.balls
    finders: dict[str, Finder] = {
        "Hough circle": lambda sample: _by_way(paper, sample),
        "mask's middle": lambda sample: _middle_of_mask(paper, sample),
        "cone": lambda sample: balls[sample.pair],
    }
    if all(recording.true_ball(s.pair.set_name, s.pair.name) for s in (*samples, *judges)):
        finders["true centres"] = lambda sample: _truth(recording, calibration, sample)

    rows = {name: (scenes.seen_by(find, judges), scenes.seen_by(find, samples)) for name, find in finders.items()}
    mean_mm = np.array([_row(recording, calibration, *row) for row in rows.values()])
    return DepthGrid(tuple(rows), mean_mm, len(judges), tuple(len(judges) - len(row[0]) for row in rows.values()))


@dataclass(frozen=True)
class Chance:
    """The paper's way with something done as well as the paper leaves room for.

    Attributes
    ----------
    name : str, what is done
    mean_mm : float, mean depth error; NaN where too few samples were found to fit on
    left_out : int, balls without a place, or with another thing's
    """

    name: str
    mean_mm: float
    left_out: int


def fair_chances(recording: Recording, ours: Localizer, paper: Localizer) -> list[Chance]:
    """The paper's way as it stands, then with one change at a time, then with all of them.

    Parameters
    ----------
    recording : Recording
    ours, paper : Localizer, of the two ways, with one calibration
    """
    scenes = _Scenes(recording, ours)
    pictures = [im for s in scenes.samples for im in ours.calibration.rectify(s.pair.left, s.pair.right)]
    color = BallColor.learned(pictures, recording.ball.color)
    learned = replace(paper, way=replace(cast(PaperWay, paper.way), detector=BallDetector(color, "paper")))
    circle, middle = cache(_by_way), cache(_middle_of_mask)  # most variants ask for pixels that another has asked for
    changes: dict[str, dict[str, Any]] = {
        "as it stands": {},
        "colour bounds learned from its samples": {"way": learned},
        "the mask's middle for the circle's": {"find": middle},
        "all depth samples for three": {"use": ("fit", "check")},
        "m, n and c not below zero": {"not_below_zero": True},
    }
    for name, count in (("the first three changes", 4), ("all four changes", 5)):
        changes[name] = {key: value for change in list(changes.values())[:count] for key, value in change.items()}
    return [
        Chance(name, *_chance(scenes, **{"way": paper, "find": circle, **change})) for name, change in changes.items()
    ]


def _chance(scenes, way, find, use=("fit",), not_below_zero=False):
    """The mean depth error of one variant, and how many balls it leaves out."""
    finder = lambda sample: find(way, sample)
    judges = scenes.seen_by(finder, scenes.judges)
    samples = scenes.seen_by(finder, [s for s in scenes.samples if s.pair.set_name == "depth" and s.use in use])
    left_out = len(scenes.judges) - len(judges)
    if len(samples) < 3 or not judges:
        return np.nan, left_out
    depths_mm = [s.measured.depth_mm for s, _ in samples]
    predicted = PaperDepth.fit(_disparities(samples), depths_mm, not_below_zero).predict(_disparities(judges))
    return float(np.abs(predicted - [s.reference.depth_mm for s, _ in judges]).mean()), left_out


class _Scenes:
    """The samples of a recording and its judges, and where ours sees the ball in them."""

    def __init__(self, recording: Recording, ours: Localizer):
        self.judges = recording.judges("volume")
        kept_back = {judge.pair for judge in self.judges}
        self.samples = [s for name in ("position", "depth") for s in recording.samples(name) if s.pair not in kept_back]
        self.balls = {sample.pair: _by_way(ours, sample) for sample in (*self.samples, *self.judges)}
        self._radius_px_mm = ours.calibration.focal_px * recording.ball.diameter_mm / 2

    def seen_by(self, find: Finder, chosen: Sequence[Sample]) -> Seen:
        """What a way to find pixels sees; what is missed, or lies more than a radius from where ours sees the ball, is left out."""
        found = [(sample, find(sample)) for sample in chosen]
        return [(sample, centers) for sample, centers in found if centers is not None and self._near(sample, centers)]

    def _near(self, sample, centers):
        return _apart(centers, self.balls[sample.pair]) < self._radius_px_mm / sample.reference.depth_mm


def _by_way(localizer, sample):
    """The centres of the balls that a way detects."""
    found = localizer.detect(sample.pair.left, sample.pair.right)
    return None if found is None else localizer.calibration.rectify_centers(*found)


def _middle_of_mask(paper, sample):
    """The centroids of the largest patches between the paper's HLS bounds."""
    centers = []
    for image in paper.calibration.rectify(sample.pair.left, sample.pair.right):
        patches = cv2.findContours(paper.way.detector.color.mask(image), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)[0]
        sums = cv2.moments(max(patches, key=cv2.contourArea)) if patches else {"m00": 0}
        if not sums["m00"]:
            return None
        centers.append(np.array([sums["m10"], sums["m01"]]) / sums["m00"])
    return tuple(centers)


def _truth(recording, calibration, sample):
    """Where the ball's true centre is seen."""
    true = recording.true_ball(sample.pair.set_name, sample.pair.name)
    return tuple(calibration.rectify_points([true[side][:2]], side)[0] for side in ("left", "right"))


def _apart(centers, others):
    """How far apart two ways see a ball, in the picture where they differ more, px."""
    return np.inf if others is None else max(np.linalg.norm(np.subtract(centers, others), axis=1))


def _row(recording: Recording, calibration: StereoCalibration, judges: Seen, samples: Seen) -> list[float]:
    """The mean depth error of each formula, fitted on the samples and judged on the judges."""
    if not judges:
        return [np.nan] * len(FORMULAS)
    depth = [pair for pair in samples if pair[0].pair.set_name == "depth"]
    three = [pair for pair in depth if pair[0].use == "fit"]
    true_mm = np.array([s.reference.depth_mm for s, _ in judges])
    predicted = [IdealDepth(calibration.baseline_mm, calibration.focal_px).predict(_disparities(judges))]
    for formula, chosen in ((PaperDepth, three), (PaperDepth, depth), (OffsetDepth, depth)):
        try:
            fitted = formula.fit(_disparities(chosen), [s.measured.depth_mm for s, _ in chosen])
        except StereoLabError:  # too few of them, or no such curve
            predicted.append(np.full(len(judges), np.nan))
        else:
            predicted.append(fitted.predict(_disparities(judges)))
    predicted.append(_by_rigid_fit(recording, calibration, judges, depth))
    return [float(np.abs(depth_mm - true_mm).mean()) for depth_mm in predicted]


def _by_rigid_fit(recording, calibration, judges, samples):
    """The judges' depths by a rigid fit on the same samples as the formulas'."""
    if len(samples) < 3:
        return np.full(len(judges), np.nan)
    plane = recording.arm_depth_mm
    places = [[s.measured.x_mm, s.measured.y_mm, plane - s.measured.depth_mm] for s, _ in samples]
    return plane - RigidFit.fit(_points(calibration, samples), places).predict(_points(calibration, judges))[:, 2]


def _disparities(seen):
    return np.array([left[0] - right[0] for _, (left, right) in seen])


def _points(calibration, seen):
    return calibration.triangulate([left for _, (left, _) in seen], [right for _, (_, right) in seen])

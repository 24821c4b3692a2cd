"""Both ways, measured on one recording: the numbers behind ``stereo-lab demo`` and its report."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from stereo_lab.calibration import StereoCalibration, find_calibration
from stereo_lab.common.processes import on_all_cores
from stereo_lab.detection import HUES, BallDetector, Detection
from stereo_lab.errors import StereoLabError
from stereo_lab.localization import Localizer, find_pair
from stereo_lab.recording import Position, Recording, Sample, open_recording
from stereo_lab.recording.strays import told_of_strays
from stereo_lab.results.limit import DepthLimit, sensor_noise

METHODS = ("paper", "cone")
AXES = ("x_mm", "y_mm", "depth_mm")


@dataclass(eq=False)
class Results:
    """What a demo run found; ``facts()`` is its JSON.

    Attributes
    ----------
    recording : Recording
    calibration, calibration_source : StereoCalibration, and where it comes from
    localizers : dict, method -> Localizer
    failed : dict, method -> why it could not be fitted
    snaps, clutter : dict, method -> its frames and how many were right; None without that set
    found : dict, method -> list of (Sample, Position or None)
    centers : dict, method -> list of (du, dv), px: centre found minus true centre
    bare : names of the samples whose ball stands where no board was seen
    limit : DepthLimit of the volume poses; None where no two pictures tell the noise
    """

    recording: Recording
    calibration: StereoCalibration
    calibration_source: str
    localizers: dict[str, Localizer] = field(default_factory=dict)
    failed: dict[str, str] = field(default_factory=dict)
    snaps: dict | None = None
    clutter: dict | None = None
    found: dict[str, list[tuple[Sample, Position | None]]] = field(default_factory=dict)
    centers: dict[str, list[tuple[float, float]]] = field(default_factory=dict)
    bare: list[str] = field(default_factory=list)
    limit: DepthLimit | None = None

    def errors(self, method: str, use: str) -> tuple[np.ndarray, np.ndarray]:
        """x, y and depth errors in mm of one method, shape (N, 3), and the true depths, shape (N,)."""
        rows = [
            [*p.minus(s.reference), s.reference.depth_mm]
            for s, p in self.found.get(method, [])
            if s.use == use and p is not None
        ]
        table = np.array(rows, float).reshape(-1, 4)
        return table[:, :3], table[:, 3]

    def facts(self) -> dict[str, Any]:
        """Everything as plain numbers, ready for JSON; None where the recording lacks the set."""
        centers = {m: _center_facts(self.centers[m]) for m in METHODS if self.centers.get(m)}
        return {
            "recording": self.recording.name,
            "rendered": self.recording.rendered,
            "calibration": self.calibration.facts(),
            "calibration_source": self.calibration_source,
            "detection": self.snaps,
            "clutter": self.clutter,
            "evaluation": {m: self._evaluation_facts(m) for m in METHODS if self.found.get(m)} or None,
            "center_px": centers or None,
            **self._limit_facts(),
            "no_board_seen_there": self.bare,
            "failed": self.failed,
        }

    def _limit_facts(self):
        """The limit, and how many times as large the mean depth error reached is."""
        if self.limit is None:
            return dict.fromkeys(("sigma_d_px", "limit_depth_mm", "reached_over_limit", "limits"))
        poses = zip(self.limit.names, self.limit.sigma_d_px.tolist(), self.limit.sigma_mm.tolist(), strict=True)
        return {
            "sigma_d_px": _number(np.median(self.limit.sigma_d_px)),
            "limit_depth_mm": _number(self.limit.mean_mm),
            "reached_over_limit": self._over_limit(),
            "limits": {name: {"sigma_d_px": _number(px), "sigma_mm": _number(mm)} for name, px, mm in poses},
        }

    def _over_limit(self):
        """How many times as large as the limit the mean depth error is; None where the pictures tell no limit."""
        errors, _ = self.errors("cone", "volume")
        tells = 0 < self.limit.mean_mm < np.inf
        return _number(np.abs(errors[:, 2]).mean() / self.limit.mean_mm) if tells else None

    def _evaluation_facts(self, method):
        facts = {}
        for use in ("volume", "plane"):
            errors, _ = self.errors(method, use)
            facts[use] = {axis: _spread(errors[:, k]) for k, axis in enumerate(AXES)} if len(errors) else None
            if facts[use]:
                rows = [(s, p) for s, p in self.found[method] if s.use == use]
                facts[use]["missed"] = sum(p is None for _, p in rows)
        facts["missed"] = sum(p is None for _, p in self.found[method])
        return facts


def _number(value):
    """For JSON, which knows no infinity: a limit that pictures without noise, or without an outline, do not tell is None."""
    return float(value) if np.isfinite(value) else None


def _spread(errors):
    size = np.abs(errors)
    return {"mean": float(size.mean()), "p95": float(np.percentile(size, 95)), "max": float(size.max())}


def _center_facts(offsets):
    distance = np.hypot(*np.array(offsets).T)
    return {"mean": float(distance.mean()), "max": float(distance.max())}


def is_hit(detection: Detection | None, circle: Sequence[float]) -> bool:
    """A hit: a centre within max(3 px, a quarter of the radius) of the true (u, v, radius_px)."""
    if detection is None:
        return False
    u, v, radius = circle
    return bool(np.hypot(detection.u - u, detection.v - v) <= max(3.0, radius / 4))


def reliability(
    told: Sequence[float], right: Sequence[bool], edges: Sequence[float] = tuple(np.linspace(0, 1, 11))
) -> tuple[np.ndarray, ...]:
    """Whether probabilities are true: those of each bin beside how often they were right.

    Parameters
    ----------
    told : sequence of float, probabilities
    right : sequence of bool, what came of each
    edges : sequence of float from 0 to 1, where the bins begin and end; tenths, if it is not told

    Returns
    -------
    told, true, count : ndarray, one for each bin: mean probability, share of right ones, how many; NaN in an empty bin
    """
    p, ok = np.asarray(told, float), np.asarray(right, float)
    bins = len(edges) - 1
    index = np.clip(np.searchsorted(edges, p, side="right") - 1, 0, bins - 1)
    count = np.bincount(index, minlength=bins)
    with np.errstate(invalid="ignore"):
        return np.bincount(index, p, bins) / count, np.bincount(index, ok, bins) / count, count


def evaluate(
    recording: Recording, report: Callable[[str, int, int], object] = lambda step, done, total: None, cores: int = 1
) -> Results:
    """Run the whole chain, the paper's way and ours, on all sets that a recording has.

    Parameters
    ----------
    recording : Recording
    report : callable (step, done, total), told about progress
    cores : int, so many processes look at clutter, where most of the time goes

    Returns
    -------
    Results
    """
    calibration, source = find_calibration(recording, lambda done, total: report("calibrate the cameras", done, total))
    results = Results(recording, calibration, source)
    if "snaps" in recording.sets and recording.truth:
        results.snaps = _snaps(recording, calibration, report)
    clutter = clutter_of(recording)
    if clutter is not None:
        results.clutter = _clutter(clutter, calibration, report, cores)
    missing = [_what_is_missing(recording, name) for name in ("position", "depth") if not recording.has_samples(name)]
    if missing:
        verb = "is" if len(missing) == 1 else "are"
        results.failed["cone"] = (
            f"Nothing can be located here: {' and '.join(missing)} {verb} missing.{told_of_strays(recording.path)}"
        )
    else:
        judges = recording.judges()
        try:
            results.localizers["paper"] = paper = Localizer.fit(recording, "paper", calibration)
            # what one way was fitted on judges neither
            judges = tuple(s for s in judges if s.pair.full_name not in paper.way.stand_ins)
        except StereoLabError as error:  # its few samples leave it nothing to fall back on; ours goes on
            results.failed["paper"] = str(error)
        results.localizers["cone"] = Localizer.fit(recording, "cone", calibration, leave_out=judges)
        _evaluate_poses(results, judges, report)
    return results


def _what_is_missing(recording, name):
    """Of a set without samples: its table, or its pictures where the table is there."""
    return f"{name}/{'left' if (recording.path / name / 'measured.csv').is_file() else 'measured.csv'}"


def _snaps(recording, calibration, report):
    """Frames and hits of both methods over the snaps (left camera)."""
    detectors = {m: BallDetector(recording.ball.color, m, calibration.camera("left")) for m in METHODS}
    hits = dict.fromkeys(METHODS, 0)
    pairs = recording.pairs("snaps")
    for k, pair in enumerate(pairs):
        report("find the ball in single pictures", k, len(pairs))
        true = recording.true_ball("snaps", pair.name)
        for method, detector in detectors.items():
            hits[method] += _right(detector.detect(pair.left), true, "left")
    report("find the ball in single pictures", len(pairs), len(pairs))
    return {m: {"frames": len(pairs), "hits": hits[m]} for m in METHODS}


def _right(detection, true, side):
    """The right ball, or rightly none."""
    return detection is None if true is None else is_hit(detection, true[side])


def clutter_of(recording: Recording) -> Recording | None:
    """The recording of clutter that the same cameras took, beside this one, the first by name; None without one."""
    for path in sorted(Path(recording.path.parent).glob("*/recording.json")):
        try:
            other = open_recording(path.parent)
        except StereoLabError:
            continue
        if other.calibrated_by == recording.name and other.truth:
            return other
    return None


def _clutter(clutter, calibration, report, cores):
    """Frames, and how many were answered rightly: the right ball, or rightly none."""
    frames = [(s, pair) for s in clutter.sets for pair in clutter.pairs(s)]
    right = dict.fromkeys(METHODS, 0)
    for k, answers in enumerate(on_all_cores(partial(_told_rightly, clutter, calibration), frames, cores)):
        report("tell the ball from clutter", k, len(frames))
        for method in METHODS:
            right[method] += answers[method]
    report("tell the ball from clutter", len(frames), len(frames))
    return {m: {"frames": len(frames), "right": int(right[m])} for m in METHODS}


def color_of(recording: Recording, set_name: str) -> str:
    """The ball's colour in a set: sets of another ball are named after its colour."""
    return set_name if set_name in HUES else recording.ball.color


def _told_rightly(clutter, calibration, frame):
    """Whether each method answers one frame (set, pair) rightly."""
    set_name, pair = frame
    true = clutter.true_ball(set_name, pair.name)
    cameras = [calibration.camera(side) for side in ("left", "right")]
    right = {}
    for method in METHODS:
        detectors = [BallDetector(color_of(clutter, set_name), method, camera) for camera in cameras]
        right[method] = _clutter_right(method, detectors, clutter, calibration, pair, true)
    return right


def _clutter_right(method, detectors, clutter, calibration, pair, true):
    if pair.right_path is None:
        return _right(detectors[0].detect(pair.left), true, "left")
    if method == "paper":
        found = [d.detect(image) for d, image in zip(detectors, (pair.left, pair.right), strict=True)]
        found = None if None in found else found
    else:
        found = find_pair(calibration, detectors, clutter.ball.diameter_mm, pair.left, pair.right)
    if found is None or true is None:
        return found is None and true is None
    return all(is_hit(d, true[side]) for d, side in zip(found, ("left", "right"), strict=True))


def _evaluate_poses(results, samples, report):
    """Locate the ball in every pair that judges, with both methods."""
    recording, calibration = results.recording, results.calibration
    results.found = {m: [] for m in results.localizers}
    results.centers = {m: [] for m in METHODS}
    raw_paper = BallDetector(recording.ball.color, "paper")
    seen = []
    for k, sample in enumerate(samples):
        report("locate the ball in pairs", k, len(samples))
        left, right = sample.pair.left, sample.pair.right
        if "paper" in results.localizers:
            results.found["paper"].append((sample, results.localizers["paper"].locate(left, right)))
        cone = results.localizers["cone"]
        pair = cone.detect(left, right)
        results.found["cone"].append((sample, None if pair is None else cone.position(*pair)))
        if pair is not None and not boards_seen_at(calibration, pair):
            results.bare.append(sample.pair.full_name)
        if pair is not None and sample.use == "volume":
            seen.append((sample, pair))
        true = recording.true_ball(sample.pair.set_name, sample.pair.name)
        if true is None:
            continue
        circles = (true["left"], true["right"])
        results.centers["paper"] += _offsets((raw_paper.detect(left), raw_paper.detect(right)), circles)
        if pair is not None:
            results.centers["cone"] += _offsets(pair, circles)
    report("locate the ball in pairs", len(samples), len(samples))
    noise = sensor_noise(recording) if seen else None  # reads pictures: only where there is a ball to hold them against
    if noise is not None:
        results.limit = DepthLimit.of(calibration, noise, *zip(*seen, strict=True))


def boards_seen_at(calibration: StereoCalibration, pair: Sequence[Detection]) -> bool:
    """Whether both cameras saw a board where they see this ball; True where an older calibration does not tell."""
    if not len(calibration.outlines):
        return True
    sides = zip(pair, ("left", "right"), strict=True)
    return all(calibration.boards_at([d.center_px], side)[0] > 0 for d, side in sides)


def _offsets(detections, circles):
    return [(d.u - c[0], d.v - c[1]) for d, c in zip(detections, circles, strict=True) if d is not None]

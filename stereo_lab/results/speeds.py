"""How fast and how well the ball is found beside the paper's chain: the first table of ``stereo-lab bench``.

The paper's chain is what Algorithm 1 costs with OpenCV alone: rectify both pictures, HLS bounds, blur, circular Hough
transform. Ours looks at the raw pictures, for its cone of rays needs no rectified ones.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import cv2
import numpy as np

from stereo_lab.calibration import StereoCalibration, find_calibration
from stereo_lab.common.threads import one_thread
from stereo_lab.detection import BLUR_PX, BallColor, BallDetector, Detection
from stereo_lab.detection.hough import library_circle
from stereo_lab.detection.paper import HOUGH_RADII
from stereo_lab.recording import Recording
from stereo_lab.results.evaluation import clutter_of, color_of, is_hit

Report = Callable[[str, int, int], object]
STEPS = ("rectify", "HLS bounds", "blur", "Hough")
LOOKS = 5  # everything is timed so often; the fastest time counts
PICTURES = 60  # of a set, evenly chosen
OFF = 0.5  # radii from the ball to where it is expected, in a set that is no film
FILM = "track"  # the set whose pictures follow one another: each is fed what was found in the one before


class View(NamedTuple):
    """One picture of one camera: its side, the color looked for, the image, and the true ball, (u, v, radius_px) or None."""

    side: str
    color: str
    image: np.ndarray
    true: tuple[float, float, float] | None


def detecting(recording: Recording, report: Report = lambda step, done, total: None) -> list[dict[str, Any]]:
    """The paper's chain, ours searching and ours following the ball, over every set that tells something.

    Parameters
    ----------
    recording : Recording
    report : callable (step, done, total), told about progress

    Returns
    -------
    list of dict, one for each set and way: "set", "way", "ms" (milliseconds for a picture), "times" (how many times
    faster than the paper's chain on the same set); of the paper's chain "shares" (of its steps); of ours, where the
    truth is known, "of" (balls), "lost", "wrong" and "center_px" (mean error of the rest)
    """
    calibration = find_calibration(recording)[0]
    sets = [(name, list(_views(recording, [name]))) for name in ("evaluation", FILM, "snaps") if name in recording.sets]
    clutter = clutter_of(recording)
    if clutter is not None:
        sets.append((clutter.name, list(_views(clutter, clutter.sets))))
    with one_thread():
        # The paper's chain over all sets by itself: after another way, by what that left in memory, its Hough transform takes
        # 0.5 or 0.8 ms instead of 1.1
        alone = [_papers(name, views, calibration, report) for name, views in sets]
        return [
            row
            for (name, views), papers in zip(sets, alone, strict=True)
            for row in [papers, *_ours(name, views, papers["ms"], calibration, report)]
        ]


def page(rows: list[dict[str, Any]]) -> list[str]:
    """The rows as lines of text."""
    lines = [f"{'One picture to the ball in it':36s} {'ms':>10s} {'times as fast':>14s}   centre, mean error (px)"]
    for row in rows:
        if "shares" in row:
            shares = ", ".join(f"{step} {100 * share:.0f} %" for step, share in row["shares"].items())
            lines += [f"  {row['set']}", f"    {row['way']:32s} {row['ms']:10.3g} {1:14.3g}   ({shares})"]
            continue
        told = (
            f"{row['center_px']:.3f}, {row['lost']} lost and {row['wrong']} wrong of {row['of']}" if row["of"] else ""
        )
        lines.append(f"    {row['way']:32s} {row['ms']:10.3g} {row['times']:14.3g}   {told}")
    return [*lines, ""]


def _views(recording: Recording, names: Sequence[str]) -> Iterator[View]:
    for name in names:
        pairs = recording.pairs(name)
        if name != FILM:
            pairs = pairs[:: max(1, -(-len(pairs) // PICTURES))]
        for side in ("left", "right"):
            for pair in pairs:
                if side == "left" or pair.right_path is not None:
                    true = recording.true_ball(name, pair.name)
                    yield View(
                        side, color_of(recording, name), getattr(pair, side), None if true is None else true[side]
                    )


def _papers(name, views, calibration, report):
    chain, spent = PaperChain(calibration), []
    for k, view in enumerate(views):
        report(f"time the paper's chain in {name}", k, len(views))
        spent.append(chain.timed(view))
    steps = np.mean(spent, 0)
    ms = float(steps.sum())
    shares = dict(zip(STEPS, (steps / ms).tolist(), strict=True))
    return {"set": name, "way": "the paper's chain", "ms": ms, "times": 1.0, "shares": shares}


def _ours(name, views, paper_ms, calibration, report):
    detectors = {(v.color, v.side): BallDetector(v.color, camera=calibration.camera(v.side)) for v in views}
    searching, following = [], []
    rng = np.random.default_rng(0)
    before: Detection | None = None
    for k, view in enumerate(views):
        report(f"time the search in {name}", k, len(views))
        detector = detectors[view.color, view.side]
        searched = fastest(detector.detect, view.image)
        searching.append(searched)
        if name == FILM:
            near = before if k and views[k - 1].side == view.side else None
        else:
            near = None if searched[1] is None else expected(searched[1], rng)
        followed = searched if near is None else fastest(detector.detect, view.image, near)
        if near is not None:
            following.append((*followed, view))
        before = followed[1]
    ways = {"cone, whole picture": [(*s, v) for s, v in zip(searching, views, strict=True)]}
    if name in ("evaluation", FILM):
        ways["cone, near the last place"] = following
    return [{"set": name, "way": way, **_told(found, paper_ms)} for way, found in ways.items()]


def _told(found, paper_ms):
    """Time and errors of one way over a set: found is a list of (ms, Detection or None, View)."""
    ms = float(np.mean([spent for spent, *_ in found]))
    known = [(ball, view.true) for _, ball, view in found if view.true is not None]
    right = [np.hypot(ball.u - true[0], ball.v - true[1]) for ball, true in known if is_hit(ball, true)]
    lost = sum(ball is None for ball, _ in known)
    return {
        "ms": ms, "times": paper_ms / ms, "of": len(known), "lost": lost, "wrong": len(known) - lost - len(right),
        "center_px": float(np.mean(right)) if right else None,
    }  # fmt: skip


def expected(ball: Detection, rng: np.random.Generator) -> Detection:
    """Where a prediction that is OFF radii wrong expects the ball."""
    angle, off = rng.uniform(0, 2 * np.pi), OFF * ball.radius_px
    return replace(ball, u=ball.u + off * np.cos(angle), v=ball.v + off * np.sin(angle))


class PaperChain:
    """Rectify, HLS bounds, blur, circular Hough transform."""

    def __init__(self, calibration: StereoCalibration) -> None:
        self.calibration = calibration
        calibration.rectify(*(np.zeros((*calibration.image_size[::-1], 3), np.uint8),) * 2)  # its tables are made once

    def timed(self, view: View) -> np.ndarray:
        """Milliseconds of each of STEPS."""
        least, largest = HOUGH_RADII[0], int(HOUGH_RADII[1] * view.image.shape[0])
        ms, both = fastest(self.calibration.rectify, view.image, view.image)
        times, picture = [ms / 2], both[0]
        for step in (
            BallColor.named(view.color).mask,
            lambda mask: cv2.GaussianBlur(mask, (BLUR_PX, BLUR_PX), 0),
            lambda blurred: library_circle(blurred, least, largest),
        ):
            ms, picture = fastest(step, picture)
            times.append(ms)
        return np.array(times)


def fastest(way: Callable[..., Any], *of: Any) -> tuple[float, Any]:
    """Milliseconds of the fastest of LOOKS, and what the last one gave."""
    best = np.inf
    for _ in range(LOOKS):
        start = time.perf_counter()
        result = way(*of)
        best = min(best, time.perf_counter() - start)
    return 1000 * best, result

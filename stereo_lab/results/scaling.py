"""How the time for one picture grows with its size, and with the things in it that have the ball's colour."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import cv2
import numpy as np

from stereo_lab.calibration import StereoCalibration, find_calibration
from stereo_lab.common.threads import one_thread
from stereo_lab.detection import BallDetector
from stereo_lab.recording import Recording
from stereo_lab.results.speeds import PaperChain, View, expected, fastest

SIZES = ((320, 240), (640, 480), (960, 720), (1280, 720), (1920, 1080))
THINGS = (8, 32)
PICTURES = 6
THING_BGR = (40, 30, 190)  # of a red thing; what they are painted on has a red ball


def scaling(
    recording: Recording, report: Callable[[str, int, int], object] = lambda step, done, total: None
) -> list[dict[str, Any]]:
    """Measure the paper's chain, our search and our following on pictures made larger and smaller, and with more in them.

    Parameters
    ----------
    recording : Recording with the set evaluation
    report : callable (step, done, total), told about progress

    Returns
    -------
    list of dict : "size" (width, height), "things" (squares of the ball's colour painted in), "paper_ms", "search_ms" and
        "track_ms" for one picture
    """
    calibration = find_calibration(recording)[0]
    pictures = [sample.pair.left for sample in recording.samples("evaluation")[:PICTURES]]
    own = calibration.image_size
    cases = [(size, 0) for size in SIZES] + [(own, things) for things in THINGS]
    rows = []
    with one_thread():
        for k, (size, things) in enumerate(cases):
            report("time larger pictures, and fuller ones", k, len(cases))
            views = [painted(fitted(picture, size), things) for picture in pictures]
            rows.append(
                {
                    "size": list(size),
                    "things": things,
                    **_timed(views, calibration_for(calibration, size), recording.ball.color),
                }
            )
    return rows


def _timed(pictures, calibration, color):
    chain, detector = PaperChain(calibration), BallDetector(color, camera=calibration.camera("left"))
    rng, spent = np.random.default_rng(0), []
    for picture in pictures:
        paper_ms = float(chain.timed(View("left", color, picture, None)).sum())
        search_ms, ball = fastest(detector.detect, picture)
        track_ms = np.nan if ball is None else fastest(detector.detect, picture, expected(ball, rng))[0]
        spent.append((paper_ms, search_ms, track_ms))
    return dict(zip(("paper_ms", "search_ms", "track_ms"), np.nanmedian(spent, axis=0).tolist(), strict=True))


def fitted(picture: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    """A picture made as high as ``size`` (width, height), its sides drawn out by their last column or cut off to that width."""
    wide, high = size
    scale = high / picture.shape[0]
    inner = cv2.resize(picture, (round(picture.shape[1] * scale), high), interpolation=cv2.INTER_LINEAR)
    beside = wide - inner.shape[1]
    if beside < 0:
        return np.ascontiguousarray(inner[:, -(beside // 2) :][:, :wide])
    return cv2.copyMakeBorder(inner, 0, 0, beside // 2, beside - beside // 2, cv2.BORDER_REPLICATE)


def calibration_for(calibration: StereoCalibration, size: tuple[int, int]) -> StereoCalibration:
    """The same cameras with pictures as :func:`fitted` makes them."""
    scale = size[1] / calibration.image_size[1]
    shift = (size[0] - round(calibration.image_size[0] * scale)) // 2
    to_size = np.array([[scale, 0, shift + (scale - 1) / 2], [0, scale, (scale - 1) / 2], [0, 0, 1]])
    matrices = {f"{side}_matrix": to_size @ calibration.camera(side)[0] for side in ("left", "right")}
    return replace(calibration, image_size=size, **matrices)


def painted(picture: np.ndarray, things: int) -> np.ndarray:
    """A copy with so many red squares at random places, a fiftieth of its width wide."""
    view, rng, half = picture.copy(), np.random.default_rng(1), picture.shape[1] // 100
    for u, v in rng.uniform(0, 1, (things, 2)) * picture.shape[1::-1]:
        cv2.rectangle(view, (int(u) - half, int(v) - half), (int(u) + half, int(v) + half), THING_BGR, -1)
    return view


def page(rows: list[dict[str, Any]]) -> list[str]:
    """The rows as lines of text."""
    lines = [f"{'One picture, larger and fuller':36s} {'paper ms':>10s} {'search ms':>10s} {'follow ms':>10s}"]
    for row in rows:
        what = f"{row['size'][0]}x{row['size'][1]}, {row['things']} red things"
        lines.append(f"  {what:34s} {row['paper_ms']:10.3g} {row['search_ms']:10.3g} {row['track_ms']:10.3g}")
    return [*lines, ""]

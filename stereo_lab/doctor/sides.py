"""Left and right exchanged in some sets alone: as they are the cameras see no ball in one place, and exchanged they do."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stereo_lab.calibration import StereoCalibration
from stereo_lab.detection import BallColor, BallDetector, Detection
from stereo_lab.doctor.advice import ADVICE
from stereo_lab.doctor.balls import ROW_PX, TRIED
from stereo_lab.doctor.cameras import Cameras
from stereo_lab.doctor.findings import STOPS, Finding
from stereo_lab.errors import StereoLabError
from stereo_lab.recording import Recording, StereoPair

LEAST = 3  # pairs that must tell it
ONE_SIZE = 1.25  # times larger or smaller than the others of its set, a ball is seen in the wrong place


def exchanged_sets(recording: Recording, color: BallColor, cameras: Cameras) -> dict[str, bool]:
    """Of each set of balls that tells it, whether its left camera is the right one.

    Parameters
    ----------
    recording : Recording
    color : BallColor, the ball's
    cameras : Cameras, with a calibration
    """
    told = {}
    for name in (name for name in recording.sets if name != "calibration"):
        found = [balls for pair in _some_pairs(recording, name) if (balls := _both(pair, color))]
        as_is, crossed = (
            max(_agreeing(state, cameras.undo, balls) for state in cameras.states)
            for balls in (found, [pair[::-1] for pair in found])
        )
        if max(as_is, crossed) >= LEAST and min(as_is, crossed) <= max(as_is, crossed) / 3:
            told[name] = crossed > as_is
    return told


def _some_pairs(recording, name):
    """Pairs with two pictures from all over a set; none where it cannot be read, which is told elsewhere."""
    try:
        pairs = [pair for pair in recording.pairs(name) if pair.right_path is not None]
    except StereoLabError:
        return []
    return pairs[:: max(1, len(pairs) // TRIED)][:TRIED]


def _both(pair: StereoPair, color: BallColor) -> tuple[Detection, Detection] | None:
    """The ball in both pictures."""
    detector = BallDetector(color, "cone")
    try:
        left, right = detector.detect(pair.left), detector.detect(pair.right)
    except StereoLabError:
        return None
    return None if left is None or right is None else (left, right)


def _agreeing(calibration: StereoCalibration, undo: tuple[str, str], balls: list[tuple[Detection, Detection]]) -> int:
    """In how many pairs both cameras see one ball: on one row, before them, and as large as in the others."""
    if not balls:
        return 0
    pixels = np.array([[ball.center_px for ball in pair] for pair in balls])
    for side, how in enumerate(undo):
        if how == "mirror":
            pixels[:, side, 0] = calibration.image_size[0] - 1 - pixels[:, side, 0]
    left, right = (calibration.rectify_points(pixels[:, k], side) for k, side in enumerate(("left", "right")))
    depth = calibration.triangulate(left, right)[:, 2]
    before = (np.abs(left[:, 1] - right[:, 1]) < ROW_PX) & (depth > 0)
    if not before.any():
        return 0
    size = np.array([pair[0].radius_px for pair in balls])[before] * depth[before]
    return int((np.abs(np.log(size / np.median(size))) < np.log(ONE_SIZE)).sum())


def sides_told(recording: Recording, exchanged: dict[str, bool], swapped: bool) -> list[Finding]:
    """What is said where left and right are exchanged in some sets, and not in all.

    Parameters
    ----------
    recording : Recording
    exchanged : as :func:`exchanged_sets` returns it
    swapped : bool, whether those of the boards are
    """
    there = {**({"calibration": swapped} if "calibration" in recording.sets else {}), **exchanged}
    wrong, right = ([name for name, is_wrong in there.items() if is_wrong is which] for which in (True, False))
    if not wrong or not right:
        return []
    says = f"In the {listed(wrong)} left and right are exchanged, and in the {listed(right)} they are not."
    files = tuple(f"{name}/{pair.name}" for name in wrong for pair in recording.pairs(name))
    return [Finding("sides_swapped", says, ADVICE["set_swapped"], files, severity=STOPS)]


def listed(names: Sequence[str]) -> str:
    """Names of sets in words: "set depth", "sets depth, position and track"."""
    *others, last = names
    return f"sets {', '.join(others)} and {last}" if others else f"set {last}"

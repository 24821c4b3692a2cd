"""The ball in the measured pairs: where it is seen, where it is lost, and why."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from stereo_lab.calibration import StereoCalibration
from stereo_lab.detection import BallColor, BallDetector, Detection
from stereo_lab.detection.color import HUES, WARM
from stereo_lab.doctor.known import CENTER_PX
from stereo_lab.errors import StereoLabError
from stereo_lab.localization import doubt, find_pair
from stereo_lab.localization.matching import rows_may_differ_px, times_as_large
from stereo_lab.recording import Ball, Sample

ROW_PX = 4.0  # two balls on rows farther apart are not one
TRIED = 5  # pictures in which other colours are looked for
LOST_PART = 0.2  # of the balls; fewer are a note
FAR_MORE = 3.0  # times the ball's own pixels: so much else of its colour hides it


@dataclass(frozen=True, eq=False)
class Sighting:
    """The ball in one measured pair.

    Attributes
    ----------
    name : str, "position/003"
    sample : Sample
    left, right : Detection or None, what each camera sees
    rows_px : float or None, how much lower the right picture shows a ball than the left one, where both show one
    """

    name: str
    sample: Sample
    left: Detection | None
    right: Detection | None
    rows_px: float | None = None

    @property
    def set_name(self) -> str:
        """The set that its pair is of."""
        return self.name.split("/")[0]

    @property
    def seen(self) -> bool:
        """Whether both cameras see it."""
        return self.rows_px is not None and abs(self.rows_px) < ROW_PX

    @property
    def apart(self) -> bool:
        """Whether the localizer takes what both cameras see for two things, by their rows."""
        if self.left is None or self.right is None or self.rows_px is None:
            return False
        return abs(self.rows_px) > rows_may_differ_px(self.left, self.right)


def state_of_balls(
    states: Sequence[StereoCalibration], samples: Sequence[Sample], color: BallColor, undo: tuple[str, str]
) -> StereoCalibration:
    """Of cameras that moved, the state in which the balls were taken: their rows match."""
    if len(states) == 1:
        return states[0]
    off = []
    for sample in samples[:: max(1, len(samples) // TRIED)]:
        images = [_undone(i, how) for i, how in zip((sample.pair.left, sample.pair.right), undo, strict=True)]
        found = [BallDetector(color, "cone").detect(image) for image in images]
        if None not in found:
            centers = [state.rectify_centers(*found) for state in states]
            off.append([abs(left[1] - right[1]) for left, right in centers])
    return states[int(np.median(off, axis=0).argmin())] if off else states[0]


def look_for_balls(
    samples: dict[str, Sample],
    color: BallColor,
    ball: Ball,
    calibration: StereoCalibration,
    undo: tuple[str, str] = ("", ""),
    progress: Callable[[int, int], object] | None = None,
) -> list[Sighting]:
    """Where both cameras see the ball; its size and its place decide only where the colour alone does not."""
    detectors = [BallDetector(color, "cone", calibration.camera(side)) for side in ("left", "right")]
    sightings = []
    for done, (name, sample) in enumerate(samples.items(), 1):
        images = [_undone(i, how) for i, how in zip((sample.pair.left, sample.pair.right), undo, strict=True)]
        left, right = (detector.detect(image) for detector, image in zip(detectors, images, strict=True))
        if not _one_ball(calibration, left, right):
            left, right = find_pair(calibration, detectors, ball.diameter_mm, *images) or (left, right)
        rows_px = None if left is None or right is None else _rows_px(calibration, left, right)
        sightings.append(Sighting(name, sample, left, right, rows_px))
        if progress:
            progress(done, len(samples))
    return sightings


def found_by_size(
    sightings: Sequence[Sighting], ball: Ball, calibration: StereoCalibration, undo: tuple[str, str]
) -> np.ndarray:
    """Which balls the localizer finds, which asks for their size as well, shape (N,)."""
    detectors = [BallDetector(ball.color, "cone", calibration.camera(side)) for side in ("left", "right")]
    pairs = (
        [_undone(i, how) for i, how in zip((s.sample.pair.left, s.sample.pair.right), undo, strict=True)]
        for s in sightings
    )
    return np.array([find_pair(calibration, detectors, ball.diameter_mm, *pair) is not None for pair in pairs], bool)


def _undone(image, how):
    """A picture as it should be: flipped where the camera showed a mirror image."""
    return np.ascontiguousarray(image[:, ::-1]) if how == "mirror" else image


def _one_ball(calibration, left, right):
    """Whether both cameras see a ball, on the same row."""
    if left is None or right is None:
        return False
    return abs(_rows_px(calibration, left, right)) < ROW_PX


def _rows_px(calibration, left, right):
    one, other = calibration.rectify_centers(left, right)
    return other[1] - one[1]


def places(
    sightings: Sequence[Sighting],
    calibration: StereoCalibration,
    aside_px: float = 0.0,
    zoomed: tuple[float, float] = (1.0, 1.0),
) -> np.ndarray:
    """Where the cameras put the balls that both see, shape (N, 3), mm, in the rectified left frame.

    Parameters
    ----------
    sightings : sequence of Sighting
    calibration : StereoCalibration
    aside_px : float, so far to the right they are taken to lie in the right picture, as if its camera had been turned
    zoomed : (left, right), how many times longer the focal lengths are than when the boards were taken
    """
    middle = (np.array(calibration.image_size) - 1) / 2
    left, right = (
        calibration.rectify_points(
            [middle + (np.array(getattr(s, side).center_px) - middle) / times for s in sightings], side
        )
        for side, times in zip(("left", "right"), zoomed, strict=True)
    )
    return calibration.triangulate(left, right + [aside_px, 0.0])


def center_sigmas(sightings: Sequence[Sighting], calibration: StereoCalibration) -> np.ndarray:
    """Standard deviations of the centres of balls that both cameras see, left and right, shape (N, 2), rectified px."""
    both = [(s.left, s.right) for s in sightings]
    told = [
        doubt.center_sigmas(calibration, left, right) for left, right in both if left is not None and right is not None
    ]
    return np.maximum(told, CENTER_PX)


def disparity_sigmas(sightings: Sequence[Sighting], calibration: StereoCalibration) -> np.ndarray:
    """Standard deviations of their disparities, shape (N,), px."""
    return np.linalg.norm(center_sigmas(sightings, calibration), axis=1)


def deepness(sightings: Sequence[Sighting], points: np.ndarray, calibration: StereoCalibration) -> np.ndarray:
    """How many times worse their places are known along the camera's ray than by the ruler, shape (N,); 1 or more."""
    per_px = calibration.depth_per_px(points[:, 2])
    return np.hypot(1, per_px * np.sqrt(2) * disparity_sigmas(sightings, calibration))


def size_of_ball(
    sightings: Sequence[Sighting], points: np.ndarray, calibration: StereoCalibration
) -> tuple[float, float]:
    """The ball's diameter as both cameras tell it, mm: the median, and its standard deviation."""
    told = np.array([
        times_as_large(calibration, 1.0, getattr(sighting, side), side, point)
        for sighting, point in zip(sightings, points, strict=True)
        for side in ("left", "right")
    ])  # fmt: skip
    spread = 1.4826 * np.median(np.abs(told - np.median(told)))
    return float(np.median(told)), float(spread / np.sqrt(len(points)))


def other_name(seen: Sequence[Sighting], name: str) -> tuple[str, float] | None:
    """The colour whose hue the balls have, and that hue, 0…179, where it is not the one by whose name they were found.

    Ours finds them all the same, for a name reaches farther than its hues; the paper's way does not.
    """
    if name not in HUES or not seen:
        return None
    hue = _hue([getattr(sighting, side) for sighting in seen for side in ("left", "right")])
    nearest = min(HUES, key=lambda other: _beyond(hue, other))
    return (nearest, hue) if _beyond(hue, name) > WARM and _beyond(hue, nearest) <= 0.5 else None


def _hue(balls):
    """The mean hue of some balls, 0…179; it goes round in a circle."""
    return float(np.angle(sum(map(_hue_of, balls)))) * 90 / np.pi % 180


def _hue_of(ball):
    """The hue of a ball's middle, as a number of length 1 in the plane of colours: grey pixels count little."""
    look, reach = ball.cone.look, max(1, int(ball.outline_px / 2))
    u, v = int(ball.u - look.left), int(ball.v - look.top)
    middle = look.patch[max(0, v - reach) : v + reach + 1, max(0, u - reach) : u + reach + 1].astype(np.float32) / 255
    hue = cv2.cvtColor(middle, cv2.COLOR_BGR2HLS)[..., 0]
    colors = ((middle.max(-1) - middle.min(-1)) * np.exp(1j * np.radians(hue))).sum()
    return colors / max(abs(colors), 1e-9)


def _beyond(hue, name):
    """How far a hue lies outside those of a name; below 0 inside."""
    low, high = HUES[name][0][0], HUES[name][-1][1]
    half = (high - low) % 180 / 2
    return abs((hue - low - half + 90) % 180 - 90) - half


@dataclass(frozen=True)
class Why:
    """Why balls were lost.

    Attributes
    ----------
    name : str, of the fault
    says : str
    color : str, the name that finds them, where that is another one; else empty
    """

    name: str
    says: str
    color: str = ""


def why_lost(lost: Sequence[Sighting], ball: Ball | None) -> Why:
    """Why balls were lost: another colour, one too narrow or too wide, or, of a few balls, none of these."""
    return _by_rows(lost) or (ball and _by_color(lost, ball)) or _by_place(lost)


def _by_rows(lost):
    """Both cameras see a ball in most of them, but not where the boards tell that one ball can be."""
    rows = [abs(s.rows_px) for s in lost if s.rows_px is not None]
    if len(rows) <= len(lost) / 2:
        return None
    says = (
        f"Both cameras see a ball there, but on rows {np.median(rows):.0f} px apart, which the boards do not tell of."
    )
    return Why("rows_apart", says)


def _by_color(lost, ball):
    images = [s.sample.pair.left for s in lost[:: max(1, len(lost) // TRIED)]][:TRIED]
    by_color = {name: [b for b in map(BallDetector(name, "cone").detect, images) if b is not None] for name in HUES}
    # Two names may find it, for each reaches farther than its hues: the nearer one is meant
    best = max(by_color, key=lambda name: (len(by_color[name]), -_beyond(_hue(by_color[name]), name)))
    if best != ball.color and len(by_color[best]) > max(len(images) / 2, len(by_color[ball.color])):
        return Why("color_wrong", f"There a ball is seen that is {best}, and recording.json says {ball.color}.", best)
    try:
        learned = BallColor.learned([s.sample.pair.left for s in lost], ball.color)
        again = sum(BallDetector(learned, "cone").detect(image) is not None for image in images)
    except StereoLabError:
        again = 0
    if again > len(images) / 2:
        return Why("color_too_narrow", f"The name {ball.color} takes in too little of the ball's own colour.")
    colored = np.median([(BallColor.named(ball.color).likeness(image) > 128).mean() for image in images])
    least = np.median([np.pi * 8**2 / image[..., 0].size for image in images])
    if colored > FAR_MORE * least * 10:
        return Why("color_too_wide", f"Much else there is {ball.color} as well, {100 * colored:.0f} % of the picture.")
    return None


def _by_place(lost):
    sides = [side for side in ("left", "right") if sum(getattr(s, side) is None for s in lost) > len(lost) / 2]
    where = "in either picture" if len(sides) == 2 else f"in the {sides[0]} picture" if sides else "in one of them"
    return Why("ball_lost", f"It was not found {where}: out of the picture, covered, in shadow or burnt out.")

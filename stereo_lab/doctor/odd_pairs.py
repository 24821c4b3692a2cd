"""Single pairs whose pictures of the ball were put down otherwise than those of the others: exchanged, mirrored, or turned.

Each mistake is undone in turn. The one after which the cameras put the ball where the ruler has it is named; the other pairs tell
how the cameras' places lie on the bench.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stereo_lab.calibration import StereoCalibration
from stereo_lab.doctor.advice import ADVICE
from stereo_lab.doctor.balls import ROW_PX, Sighting, deepness, places
from stereo_lab.doctor.findings import COSTS, Finding, listed
from stereo_lab.doctor.numbers import WRONG_MM, place, similar, weighed
from stereo_lab.doctor.partners import agreeing, put_right

FEWEST = 5  # pairs that tell how the cameras' places lie on the bench
MOST = 0.5  # part of those that must agree with the ruler
NAMED = 4  # pairs in a sentence


@dataclass(frozen=True)
class Slip:
    """What may have become of the two pictures of a pair.

    Attributes
    ----------
    name, advice : of the finding, and of :data:`ADVICE`
    says : str, of one pair
    undo : (left, right), what puts the pictures right: "", "mirror" or "turn"
    exchanged : bool, whether left and right must be exchanged
    """

    name: str
    advice: str
    says: str
    undo: tuple[str, str] = ("", "")
    exchanged: bool = False


SLIPS = (
    Slip("cameras_exchanged", "cameras_exchanged", "left and right are exchanged", exchanged=True),
    Slip("both_mirrored", "pair_mirrored", "both pictures are mirror images", ("mirror", "mirror")),
    Slip("both_upside_down", "pair_upside_down", "both pictures are upside down", ("turn", "turn")),
    Slip("mirrored", "pair_mirrored", "the left picture is a mirror image", ("mirror", "")),
    Slip("mirrored", "pair_mirrored", "the right picture is a mirror image", ("", "mirror")),
    Slip("upside_down", "pair_upside_down", "the left picture is upside down", ("turn", "")),
    Slip("upside_down", "pair_upside_down", "the right picture is upside down", ("", "turn")),
)


@dataclass(frozen=True, eq=False)
class Bench:
    """How the places that the cameras tell lie on the bench.

    Attributes
    ----------
    calibration : StereoCalibration
    rotation, shift, scale : of :func:`stereo_lab.doctor.numbers.similar`
    """

    calibration: StereoCalibration
    rotation: np.ndarray
    shift: np.ndarray
    scale: float

    def off_mm(self, sighting: Sighting, slip: Slip) -> float:
        """How far a ball is from where it was measured, with a slip undone; infinite where the rays do not meet."""
        both = [ball.center_px for ball in (sighting.left, sighting.right) if ball is not None]
        pixels = np.array([both[::-1] if slip.exchanged else both])
        left, right = put_right(self.calibration, pixels, slip.undo)
        point = self.calibration.triangulate(left, right)
        if abs(left[0, 1] - right[0, 1]) >= ROW_PX or not point[0, 2] > 0:
            return np.inf
        turned = point @ self.rotation.T
        away = self.scale * turned + self.shift - on_bench([sighting])
        off = weighed(away, turned, deepness([sighting], point, self.calibration))
        return float(off[0]) / min(self.scale, 1.0)


def on_bench(sightings: Sequence[Sighting]) -> np.ndarray:
    """Where balls were measured, shape (N, 3), mm: x, y, and less depth."""
    measured = [s.sample.measured for s in sightings]
    return np.array([[m.x_mm, m.y_mm, -m.depth_mm] for m in measured])


def odd_pairs(sightings: Sequence[Sighting], calibration: StereoCalibration) -> list[Finding]:
    """What is said of single pairs that show the ball where it was measured once a slip is undone.

    Parameters
    ----------
    sightings : sequence of Sighting
    calibration : StereoCalibration
    """
    balls = {s: (s.left, s.right) for s in sightings if s.left is not None and s.right is not None}
    fits = dict(zip(balls, agreeing(calibration, list(balls.values())), strict=True))
    bench = _bench([s for s in balls if fits[s]], calibration)
    if bench is None:
        return []
    found: dict[Slip, list[str]] = {}
    for sighting in (s for s in balls if not fits[s]):
        off = {slip: bench.off_mm(sighting, slip) for slip in SLIPS}
        slip = min(off, key=lambda slip: off[slip])
        if off[slip] < WRONG_MM:
            found.setdefault(slip, []).append(sighting.name)
    return [_told(slip, tuple(files)) for slip, files in found.items()]


def _bench(good, calibration):
    """How places lie on the bench by the pairs that are as they should; None where these do not tell."""
    if len(good) < FEWEST:
        return None
    points, bench = places(good, calibration), on_bench(good)
    placed = place(points, bench * [1, 1, -1], deepness(good, points, calibration), free_scale=True)
    near = placed.off < WRONG_MM
    if near.sum() < FEWEST or near.mean() < MOST:
        return None
    return Bench(calibration, *similar(points[near], bench[near], free_scale=True))


def _told(slip, files):
    where = f"the {listed('pair', files)}" if len(files) <= NAMED else f"{len(files)} pairs"
    says = f"In {where} {slip.says}: put right, the ball is where it was measured."
    return Finding(slip.name, says, ADVICE[slip.advice], files, severity=COSTS)

"""Sets of balls whose left and right pictures do not belong together: exchanged with each other, shifted by a pair, or mirrored."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from stereo_lab.calibration import StereoCalibration, boards_of
from stereo_lab.calibration.bundle import Rig
from stereo_lab.common.files import natural_key
from stereo_lab.detection import BallColor, BallDetector, Detection
from stereo_lab.doctor.advice import ADVICE
from stereo_lab.doctor.balls import ROW_PX, TRIED, Sighting
from stereo_lab.doctor.cameras import Cameras, with_rig
from stereo_lab.doctor.findings import STOPS, Finding, listed
from stereo_lab.doctor.suspects import SHIFTS, shift_in_words
from stereo_lab.errors import StereoLabError
from stereo_lab.recording import Recording, Sample, StereoPair

LEAST = 3  # pairs that must tell it
MOST = 0.7  # of the pairs that are wrong a shift must explain
FLIPS = {
    ("mirror", "mirror"): "both cameras'",
    ("mirror", ""): "the left camera's",
    ("", "mirror"): "the right camera's",
}
TURNS = {
    "mirror": ("both_mirrored", "mirror images", "set_mirrored"),
    "turn": ("both_upside_down", "upside down", "pair_upside_down"),
}
NEARER_PX = 0.5  # on average, to one row: the boards tell rows to a tenth
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
            max(agreeing(state, balls, cameras.undo).sum() for state in cameras.states)
            for balls in (found, [pair[::-1] for pair in found])
        )
        if max(as_is, crossed) >= LEAST and min(as_is, crossed) <= max(as_is, crossed) / 3:
            told[name] = bool(crossed > as_is)
    return told


def boards_alone(recording: Recording, color: BallColor, cameras: Cameras) -> tuple[Cameras, list[Finding]]:
    """Cameras that seem exchanged because their boards are mirror images, or upside down, and the balls are not.

    Such boards tell of a right camera on the left. Who has the folders exchanged then is told afterwards that the balls are mirrored.
    Each way of putting the boards right gives other cameras; the balls' rows tell whether these are theirs.

    Parameters
    ----------
    recording : Recording
    color : BallColor, the ball's
    cameras : Cameras, with a calibration

    Returns
    -------
    (Cameras, list of Finding) : the cameras as they are then, and what is said; the same ones, and nothing, where it is not so
    """
    if not cameras.swapped or any(cameras.undo):
        return cameras, []
    sets = [name for name in recording.sets if name != "calibration"]
    found = [balls for name in sets for pair in _some_pairs(recording, name) if (balls := _both(pair, color))]
    if len(found) < LEAST:
        return cameras, []
    ways = {how: tuple(_put_right(state, how) for state in cameras.states) for how in TURNS}
    how = min(ways, key=lambda how: _rows_off_px(ways[how], found))
    known = min(_rows_off_px(cameras.states, balls) for balls in (found, [pair[::-1] for pair in found]))
    if not _rows_off_px(ways[how], found) + NEARER_PX < known:
        return cameras, []
    name, what, advice = TURNS[how]
    says = f"In the set calibration both cameras' pictures are {what}; those of the balls are not."
    files = tuple(f"calibration/{pair.name}" for pair in boards_of(recording).pairs("calibration"))
    told = Finding(name, says, ADVICE[advice], files, severity=STOPS)
    return replace(cameras, states=ways[how], swapped=False), [told]


def _put_right(calibration, how):
    """Cameras by boards that are turned, left and right exchanged, as they are by the boards put right, and not exchanged."""
    rig, (width, height) = calibration.rig, calibration.image_size
    turn = np.diag([-1.0, 1.0 if how == "mirror" else -1.0, 1.0])
    left, right = (lens.copy() for lens in (rig.right, rig.left))
    for lens in (left, right):
        lens[[2, 7]] = width - 1 - lens[2], -lens[7]  # the middle, and how the lens leans
        if how == "turn":
            lens[[3, 6]] = height - 1 - lens[3], -lens[6]
    rotation = turn @ rig.rotation.T @ turn
    return with_rig(calibration, Rig(left, right, rotation, -rotation @ turn @ rig.translation))


def _rows_off_px(states, balls):
    """How far apart the rows of one ball are, the mean; from ROW_PX on, or behind the cameras, one pair is as wrong as another."""
    pixels = np.array([[ball.center_px for ball in pair] for pair in balls])
    off = []
    for state in states:
        left, right = put_right(state, pixels, ("", ""))
        before = state.triangulate(left, right)[:, 2] > 0
        off.append(np.where(before, np.minimum(np.abs(left[:, 1] - right[:, 1]), ROW_PX), ROW_PX).mean())
    return min(off)


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


def agreeing(
    calibration: StereoCalibration,
    balls: Sequence[tuple[Detection, Detection]],
    undo: tuple[str, str] = ("", ""),
) -> np.ndarray:
    """In which pairs both cameras see one ball, shape (N,): on one row, before them, and as large as in the others.

    ``undo``: what is still to be done to the pictures that the balls were found in.
    """
    if not balls:
        return np.zeros(0, bool)
    pixels = np.array([[ball.center_px for ball in pair] for pair in balls])
    left, right = put_right(calibration, pixels, undo)
    depth = calibration.triangulate(left, right)[:, 2]
    before = (np.abs(left[:, 1] - right[:, 1]) < ROW_PX) & (depth > 0)
    if before.any():
        size = np.array([pair[0].radius_px for pair in balls]) * np.where(before, depth, np.inf)
        before &= np.abs(np.log(size / np.median(size[before]))) < np.log(ONE_SIZE)
    return before


def put_right(
    calibration: StereoCalibration, pixels: np.ndarray, undo: tuple[str, str]
) -> tuple[np.ndarray, np.ndarray]:
    """Pixels of pairs, shape (N, 2 cameras, 2), in pictures that are flipped or turned first, rectified: left and right, (N, 2) each."""
    last = np.array(calibration.image_size) - 1
    flipped = {"": pixels, "mirror": pixels * [-1, 1] + last * [1, 0], "turn": last - pixels}
    left, right = (
        calibration.rectify_points(flipped[how][:, k], side)
        for k, (how, side) in enumerate(zip(undo, ("left", "right"), strict=True))
    )
    return left, right


def uncrossed_samples(
    recording: Recording, sets: Sequence[str], exchanged: dict[str, bool], swapped: bool
) -> dict[str, Sample]:
    """All measured pairs of some sets by name, in the order of the pictures, left and right as the cameras stand.

    Parameters
    ----------
    recording : Recording
    sets : names of sets
    exchanged : as :func:`exchanged_sets` returns it
    swapped : bool, whether those of the boards are, and so those of sets that do not tell
    """
    found: dict[str, Sample] = {}
    for name in (name for name in sets if recording.has_samples(name)):
        for sample in sorted(recording.samples(name), key=lambda s: natural_key(s.pair.left_path)):
            pair = sample.pair
            if pair.right_path is None:
                continue
            if exchanged.get(name, swapped):
                sample = replace(sample, pair=replace(pair, left_path=pair.right_path, right_path=pair.left_path))
            found[f"{name}/{pair.name}"] = sample
    return found


def sides_told(recording: Recording, exchanged: dict[str, bool], swapped: bool) -> list[Finding]:
    """What is said where left and right are exchanged in some sets, and not in all; or, by cameras of elsewhere, in any.

    Parameters
    ----------
    recording : Recording
    exchanged : as :func:`exchanged_sets` returns it
    swapped : bool, whether those of the boards are
    """
    there = {**({"calibration": swapped} if "calibration" in recording.sets else {}), **exchanged}
    wrong, right = ([name for name, is_wrong in there.items() if is_wrong is which] for which in (True, False))
    elsewhere = "calibration" not in recording.sets and not swapped  # cameras that are known, and stand rightly
    if not wrong or not (right or elsewhere):
        return []
    others = (
        f", and in the {listed('set', right)} they are not"
        if right
        else ", by the calibration, whose boards are elsewhere"
    )
    says = f"In the {listed('set', wrong)} left and right are exchanged{others}."
    files = tuple(f"{name}/{pair.name}" for name in wrong for pair in recording.pairs(name))
    return [Finding("sides_swapped", says, ADVICE["set_swapped"], files, severity=STOPS)]


def shifted_pairs(sightings: Sequence[Sighting], calibration: StereoCalibration) -> list[Finding]:
    """What is said where the left pictures of a set belong to the right ones of their neighbours.

    Parameters
    ----------
    sightings : sequence of Sighting, in the order of the pictures
    calibration : StereoCalibration
    """
    found = []
    for set_name in dict.fromkeys(s.set_name for s in sightings):
        inside = [s for s in sightings if s.set_name == set_name]
        wrong = _together(inside, 0, calibration) == 0
        for by in SHIFTS if wrong.sum() >= LEAST else ():
            other = _together(inside, by, calibration)[wrong]
            if (other == 1).sum() >= max(LEAST, MOST * (other >= 0).sum()):
                since = int(wrong.argmax())  # after it one may fit by chance
                files = tuple(s.name for s in inside[since:])
                where = f"From {files[0]} on" if since else f"In the set {set_name}"
                says = f"{where} {shift_in_words(by)}"
                found.append(Finding("pairs_shifted", says, ADVICE["pairs_shifted"], files, severity=STOPS))
                break
    return found


def mirrored_sets(sightings: Sequence[Sighting], calibration: StereoCalibration) -> list[Finding]:
    """What is said where the balls of some sets fit the boards once the pictures of one camera, or of both, are flipped.

    Parameters
    ----------
    sightings : sequence of Sighting
    calibration : StereoCalibration
    """
    by_set: dict[str, list[tuple[Detection, Detection]]] = {}
    for s in sightings:
        if s.left is not None and s.right is not None:
            by_set.setdefault(s.set_name, []).append((s.left, s.right))
    as_is = {name: agreeing(calibration, balls).sum() for name, balls in by_set.items()}
    for flip, whose in FLIPS.items():
        flipped = {name: agreeing(calibration, balls, flip).sum() for name, balls in by_set.items()}
        if any(
            flipped[name] >= max(LEAST, MOST * len(balls)) and as_is[name] <= flipped[name] / 3
            for name, balls in by_set.items()
        ):
            # Beside a set that tells it, one in which both ways fit many pairs by chance goes by the better of the two
            sets = [name for name in by_set if flipped[name] > as_is[name]]
            says = f"In the {listed('set', sets)} {whose} pictures are mirror images; those of the boards are not."
            files = tuple(s.name for s in sightings if s.set_name in sets)
            name = "both_mirrored" if all(flip) else "mirrored"
            return [Finding(name, says, ADVICE["set_mirrored"], files, severity=STOPS)]
    return []


def _together(sightings, by, calibration):
    """Of each left picture whether it and the right one so many places later show one ball: 1 or 0; -1 where that is not known."""
    told = np.full(len(sightings), -1)
    known = [
        k
        for k in range(len(sightings))
        if 0 <= k + by < len(sightings) and sightings[k].left is not None and sightings[k + by].right is not None
    ]
    told[known] = agreeing(calibration, [(sightings[k].left, sightings[k + by].right) for k in known])
    return told

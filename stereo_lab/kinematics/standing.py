"""The nine numbers of an arm before its cameras: where they put its hand, and which of them fit places that were seen."""

from __future__ import annotations

import itertools

import numpy as np

from stereo_lab.errors import StereoLabError
from stereo_lab.kinematics.angles import wrap

NAMES = ("shoulder x", "shoulder y", "shoulder depth", "turned", "tilted", "zero 1", "zero 2", "link 1", "link 2")
UNITS = ("mm", "mm", "mm", "deg", "deg", "deg", "deg", "mm", "mm")
ROUNDS = 50
TURNS_DEG = (0.0, 90.0, -90.0, 180.0)  # by which a joint's zero may be off
# An arm that is found is no farther off, on average: of its reach, or standard deviations of the places
BESIDE_HAND, DEVIATIONS = 0.02, 3.0
SHORTEST = 0.2  # of a link as it is told: what comes out shorter is none
FAR_OFF = 1e5  # mm or degrees: no arm


def upright(place: np.ndarray) -> np.ndarray:
    """x, y and depth as a right-handed x, y, z: z points to the cameras."""
    return place * np.array([1.0, 1.0, -1.0])


def rotation(turned_deg: float, tilted_deg: float) -> np.ndarray:
    """First about the horizontal of the arm's plane, then about the vertical."""
    a, b = np.radians([turned_deg, tilted_deg])
    turned = np.array([[np.cos(a), 0, np.sin(a)], [0, 1, 0], [-np.sin(a), 0, np.cos(a)]])
    tilted = np.array([[1, 0, 0], [0, np.cos(b), -np.sin(b)], [0, np.sin(b), np.cos(b)]])
    return turned @ tilted


def places_of(values: np.ndarray, angles_N2: np.ndarray) -> np.ndarray:
    """Where the hand is, (N, 3)."""
    shoulder, turned, tilted, zeros, links = values[:3], values[3], values[4], values[5:7], values[7:]
    one, both = np.radians(angles_N2[:, 0] + zeros[0]), np.radians(angles_N2.sum(axis=1) + zeros.sum())
    flat = np.column_stack([np.cos(one), np.sin(one), np.cos(both), np.sin(both)])
    inside = np.column_stack(
        [links[0] * flat[:, 0] + links[1] * flat[:, 2], links[0] * flat[:, 1] + links[1] * flat[:, 3]]
    )
    return shoulder + upright(inside @ rotation(turned, tilted)[:, :2].T)


def fitted(told: np.ndarray, angles: np.ndarray, places: np.ndarray, sigmas: np.ndarray) -> np.ndarray:
    """The nine values that fit places, (9,).

    Parameters
    ----------
    told : ndarray, shape (9,), the values as they are told
    angles : ndarray, shape (N, 2), degrees
    places, sigmas : ndarray, shape (N, 3), where the hand was seen, and how far that may be off, mm

    Raises
    ------
    StereoLabError
        If the places fit no arm; with what explains them, where a joint that turns the wrong way does, or joints that are exchanged.
    """
    values, off_mm = _nearest(told, angles, places, sigmas)
    far_mm = max(BESIDE_HAND * told[7:].sum(), DEVIATIONS * sigmas.mean())
    if values is not None and off_mm < far_mm:
        return values
    reversed_, its_mm = _nearest(told, angles * [1, -1], places, sigmas)
    if its_mm < far_mm:
        joint = 2 if abs(reversed_[3]) <= 90 else 1  # the same seen from the back: both joints turn the other way there
        raise StereoLabError(
            f"Joint {joint} turns the other way than its angle says: counter-clockwise, as the cameras see it, is plus. "
            "Turn its direction round (the wires of its motor, and of its encoder), home the arm, and register it again."
        )
    if _nearest(told, angles[:, ::-1], places, sigmas)[1] < far_mm:
        raise StereoLabError(
            "The joints are exchanged: the shoulder turns where the elbow should. Exchange their plugs, home the arm, and register it again."
        )
    apart = "" if values is None else f" (seen and calculated stay {off_mm:.0f} mm apart)"
    raise StereoLabError(
        f"The places do not fit an arm of two links, wherever it stands{apart}. Is it homed, are its links as told, and did the hand hold the ball?"
    )


def _nearest(told, angles, places, sigmas):
    """The nine values by Gauss-Newton steps, and how far off the places are on average; None and infinity where no start finds an arm.

    It starts from the zeros as they are told, else from such as a switch on another side makes; else from the arm's back.
    """
    best, least, weights = None, np.inf, 1 / sigmas.ravel()
    for back, zero1, zero2 in itertools.product((0.0, 180.0), TURNS_DEG, TURNS_DEG):
        values = told + np.array([0, 0, 0, back, 0, zero1, zero2, 0, 0])
        for _ in range(ROUNDS):
            slopes = slopes_of(values, angles) * weights[:, None]
            step = np.linalg.lstsq(slopes, (places - places_of(values, angles)).ravel() * weights, rcond=None)[0]
            values = values + step
            if np.abs(step).max() < 1e-9 or not np.abs(values).max() < FAR_OFF:
                break
        off_mm = float(np.linalg.norm(places - places_of(values, angles), axis=1).mean())
        if (values[7:] > SHORTEST * told[7:]).all() and np.abs(values).max() < FAR_OFF and off_mm < least:
            best, least = _facing(values), off_mm
        if least < BESIDE_HAND * told[7:].sum():
            break
    return best, least


def _facing(values):
    """The same arm with its angles within half a turn, and told the way up: tilted by 90 degrees at most."""
    facing = values.copy()
    facing[3:7] = wrap(facing[3:7])
    if abs(facing[4]) > 90:
        facing[3:6] = wrap([facing[3] + 180, 180 - facing[4], facing[5] + 180])
    return facing


def slopes_of(values: np.ndarray, angles_N2: np.ndarray) -> np.ndarray:
    """How the places change with each value, (3N, 9): by a small step of each."""
    step = 1e-4
    return np.column_stack([
        (places_of(values + step * unit, angles_N2) - places_of(values - step * unit, angles_N2)).ravel() / (2 * step)
        for unit in np.eye(len(values))
    ])  # fmt: skip


def covariance_of(slopes: np.ndarray) -> np.ndarray:
    """Of the values; poses that leave one of them open are told."""
    _, sizes, ways = np.linalg.svd(slopes / np.linalg.norm(slopes, axis=0), full_matrices=False)
    if sizes[-1] < 1e-3 * sizes[0]:
        open_ = NAMES[int(np.abs(ways[-1]).argmax())]
        raise StereoLabError(
            f"These poses do not tell {open_}: bend the elbow both ways, and hold the hand high, low, left and right."
        )
    return np.linalg.inv(slopes.T @ slopes)

"""How to measure a motor: push it, see how far it turns, and fit its equation."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from stereo_lab.errors import StereoLabError
from stereo_lab.motion.motors import Motor, advance, encoder_count

# A controller acts every 2 ms, and no gear motor takes a second: pushes that do not tell τ end at one of them
TAU_S = 0.002, 1.0
# Pushes to fit: volts above the lowest that turns the joint, as far as the supply goes, and seconds
PUSHES = (0.5, 0.15), (0.5, 0.3), (1.0, 0.15), (1.0, 0.25), (1.4, 0.2)
LEAST_ROOM_V = 0.6  # by so much is the supply above that lowest voltage, else all pushes are alike


@dataclass(frozen=True, eq=False)
class DirectionFit:
    """One direction of one motor, from measurements only.

    A push from rest with V volts for T seconds settles at w = k·(V − V₀) degrees per second. Until it
    is at rest again the joint turns by

    w·T − k·V₀·τ·ln(1 + w₁/(k·V₀)),  w₁ = w·(1 − exp(−T/τ)), the speed when the push ends.

    Attributes
    ----------
    starts_at_v : float, the lowest voltage that turns it from rest
    dead_band_v : float, V₀, what friction takes while it turns
    speed_per_volt : float, k
    time_constant_s : float, τ
    residuals_deg : ndarray
    """

    starts_at_v: float
    dead_band_v: float
    speed_per_volt: float
    time_constant_s: float
    residuals_deg: np.ndarray

    @classmethod
    def fit(cls, starts_at_v: float, volts_N: ArrayLike, seconds_N: ArrayLike, turned_deg_N: ArrayLike) -> DirectionFit:
        """Least squares by Gauss-Newton steps on k, V₀ and τ; all values are taken without their sign.

        Raises
        ------
        StereoLabError
            With fewer than four pushes, or pushes that no motor makes: without a length, a voltage or an angle.
        """
        volts, seconds, turned = (np.abs(np.asarray(a, float)) for a in (volts_N, seconds_N, turned_deg_N))
        if len(volts) < 4 or len(np.unique(volts)) < 2 or len(np.unique(seconds)) < 2:
            raise StereoLabError("Expected four pushes or more, of two voltages and two lengths at least.")
        if not all(np.isfinite(given).all() for given in (volts, seconds, turned)) or not (volts * seconds > 0).all():
            raise StereoLabError("A push lasts for some time, with some voltage, and turns by a number of degrees.")
        speed = turned / seconds
        k = max(np.polyfit(volts, speed, 1)[0], 1.0)
        guess = np.array([k, 0.8 * starts_at_v, 0.05])
        turns = lambda k, dead_band_v, tau: push_turns_deg(k, dead_band_v, tau, volts, seconds)
        for _ in range(30):
            model = turns(*guess)
            slopes = []
            for j in range(3):
                nudged = guess.copy()
                nudged[j] *= 1.0001
                slopes.append((turns(*nudged) - model) / (guess[j] * 0.0001))
            step = np.linalg.lstsq(np.column_stack(slopes), turned - model, rcond=None)[0]
            guess = np.clip(guess + step, guess * 0.5, guess * 2)
            guess[2] = np.clip(guess[2], *TAU_S)
        residuals = turns(*guess) - turned
        if not np.isfinite(residuals).all() or np.abs(residuals).max() > 0.2 * turned.max():
            raise StereoLabError(
                "The pushes do not fit together: the joint turned by "
                + ", ".join(f"{t:.1f}" for t in turned)
                + " degrees. Does it touch something, or slip?"
            )
        k, dead_band, tau = (float(v) for v in guess)
        return cls(float(starts_at_v), min(dead_band, float(starts_at_v)), k, tau, residuals)


@dataclass(frozen=True)
class MotorCalibration:
    """Both directions of one motor.

    Attributes
    ----------
    ccw, cw : DirectionFit, counter-clockwise and clockwise
    """

    ccw: DirectionFit
    cw: DirectionFit

    @property
    def speed_per_volt(self) -> float:
        """Mean k of both directions."""
        return (self.ccw.speed_per_volt + self.cw.speed_per_volt) / 2

    @property
    def time_constant_s(self) -> float:
        """Mean τ of both directions."""
        return (self.ccw.time_constant_s + self.cw.time_constant_s) / 2

    def direction(self, way: float) -> DirectionFit:
        """The fit of the direction of ``way``: plus is counter-clockwise."""
        return self.ccw if way >= 0 else self.cw


def push_turns_deg(
    speed_per_volt: float,
    dead_band_v: float,
    time_constant_s: float,
    volts: float | np.ndarray,
    seconds: float | np.ndarray,
) -> float | np.ndarray:
    """How far a push from rest turns the joint, until it is at rest again (see :class:`DirectionFit`)."""
    w = speed_per_volt * np.maximum(volts - dead_band_v, 0)
    ends = w * (1 - np.exp(-seconds / time_constant_s))
    friction = speed_per_volt * dead_band_v
    return w * seconds - friction * time_constant_s * np.log1p(ends / friction)


@dataclass(frozen=True)
class WeightFit:
    """What holds a joint's weight, from the voltages that just turn it up and down in some poses.

    Halfway between the two lies what holds it, friction apart: V = g1·cos θ1 + g2·cos(θ1 + θ2) + A, where A is half of
    what the two directions' frictions differ by.

    Attributes
    ----------
    g1_v, g2_v : float, volts
    residuals_v : ndarray
    """

    g1_v: float
    g2_v: float
    residuals_v: np.ndarray

    @classmethod
    def fit(cls, theta1_deg_N: ArrayLike, theta2_deg_N: ArrayLike, middle_v_N: ArrayLike) -> WeightFit:
        """Least squares.

        Raises
        ------
        StereoLabError
            With fewer than four poses, something in them that is no number, or poses that do not tell the three numbers apart.
        """
        one, other = np.radians(theta1_deg_N), np.radians(np.add(theta1_deg_N, theta2_deg_N))
        rows = np.column_stack([np.cos(one), np.cos(other), np.ones(len(one))])
        if not (np.isfinite(rows).all() and np.isfinite(np.asarray(middle_v_N, float)).all()):
            raise StereoLabError("An angle or a voltage of a pose is no finite number.")
        if len(rows) < 4 or np.linalg.cond(rows) > 30:
            raise StereoLabError("Expected four poses or more, with both links up, sideways and down.")
        found = np.linalg.lstsq(rows, np.asarray(middle_v_N, float), rcond=None)[0]
        return cls(float(found[0]), float(found[1]), np.asarray(middle_v_N) - rows @ found)


def calibrate_motor(push: Callable[[float, float], float], supply_v: float, least_deg: float = 0.2) -> MotorCalibration:
    """Measure a motor by pushing it: in each direction its lowest voltage, then some pushes to fit.

    Parameters
    ----------
    push : function(volts, seconds) -> degrees turned until at rest
    supply_v : float, the largest voltage there is
    least_deg : float, less than this counts as not turning

    Returns
    -------
    MotorCalibration

    Raises
    ------
    StereoLabError
        If the motor does not turn, turns the wrong way, or only with almost all that the supply has.
    """
    starts = [lowest_voltage(push, way, supply_v, least_deg) for way in (1, -1)]
    if supply_v - max(starts) < LEAST_ROOM_V:
        raise StereoLabError(
            f"It takes {max(starts):.2f} V of {supply_v:.2f} V to turn the joint at all, which leaves too little to measure it with. "
            "Does it rub on something, or is the supply too weak?"
        )
    rows: dict[int, list[tuple[float, float, float]]] = {1: [], -1: []}
    for extra, seconds in PUSHES:
        for way, start in zip((1, -1), starts, strict=True):
            volts = min(start + extra, supply_v)
            rows[way].append((volts, seconds, push(way * volts, seconds)))
    fits = [DirectionFit.fit(start, *zip(*rows[way], strict=True)) for way, start in zip((1, -1), starts, strict=True)]
    return MotorCalibration(*fits)


def lowest_voltage(push: Callable[[float, float], float], way: int, supply_v: float, least_deg: float = 0.2) -> float:
    """Halve the gap between a voltage that does not turn the motor and one that does."""
    still, turns = 0.0, 0.25
    while True:
        turned = push(way * turns, 0.1)
        if turned * way < -least_deg:
            raise StereoLabError(
                f"A push of {way * turns:.2f} V turned the joint by {turned:.1f} degrees, the wrong way. "
                "Swap the two wires of the motor, or the two of its encoder."
            )
        if abs(turned) >= least_deg:
            break
        still, turns = turns, turns + 0.25
        if turns > supply_v:
            raise StereoLabError(
                f"The joint does not turn, not even with {still:.2f} V. Is the motor's supply switched on?"
            )
    while turns - still > 0.02:
        middle = (still + turns) / 2
        if abs(push(way * middle, 0.1)) >= least_deg:
            turns = middle
        else:
            still = middle
    return turns


def push_of(motor: Motor) -> Callable[[float, float], float]:
    """A ``push(volts, seconds)`` for :func:`calibrate_motor` from a motor model, read through its encoder."""
    position = 0.0

    def push(volts, seconds):
        nonlocal position
        before = encoder_count(motor, position)
        position, speed = advance(motor, position, 0.0, volts, seconds)
        position, _ = advance(motor, position, speed, 0.0, 2.0)
        return (encoder_count(motor, position) - before) * 360 / motor.counts_per_turn

    return push

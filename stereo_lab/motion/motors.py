"""What a cheap gear motor does (friction, inertia, backlash, an encoder that counts), and how to measure it.

Degrees at the joint, degrees per second, volts; plus is counter-clockwise. The virtual arm and lesson 06
turn these motors; numbers of real ones: FIT0450 (6 V, 1920 counts a turn) and Pololu 37D data sheets.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from stereo_lab.errors import StereoLabError

STICTION = 1.15  # a motor at rest needs this many times the voltage that keeps it turning


@dataclass(frozen=True)
class Motor:
    """A DC gear motor with encoder, as cheap ones are.

    τ·dω/dt = k·(V − V₀) − ω while it turns, with the friction's dead band V₀ against the motion.

    Attributes
    ----------
    speed_per_volt : float, k, degrees per second for each volt above the dead band
    dead_band_v : (counter-clockwise, clockwise), V₀ in volts, both above zero
    time_constant_s : float, τ
    backlash_deg : float, play between motor and link; the encoder sits on the motor and does not see it
    supply_v : float, no more than this reaches the motor
    counts_per_turn : float, of the encoder, on a turn of the joint
    """

    speed_per_volt: float = 200.0
    dead_band_v: tuple[float, float] = (1.2, 1.6)
    time_constant_s: float = 0.06
    backlash_deg: float = 1.0
    supply_v: float = 6.0
    counts_per_turn: float = 1920.0

    @classmethod
    def random(cls, rng: np.random.Generator) -> Motor:
        """One of a batch: ±15 % in speed, ±25 % in dead band, the other direction 1.1 to 1.6 times worse."""
        dead_band = 1.2 * rng.uniform(0.75, 1.25)
        return cls(
            speed_per_volt=200.0 * rng.uniform(0.85, 1.15),
            dead_band_v=(dead_band, dead_band * rng.uniform(1.1, 1.6)),
            time_constant_s=rng.uniform(0.03, 0.1),
        )


def advance(motor: Motor, position_deg: float, speed_deg_s: float, volts: float, seconds: float) -> tuple[float, float]:
    """Let a motor turn for some time under one voltage; exact, by the solution of its equation.

    At zero volts the motor is short-circuited, which brakes it.

    Parameters
    ----------
    position_deg, speed_deg_s : float, of the motor before
    volts : float; more than the supply has is cut down to it
    seconds : float, for how long

    Returns
    -------
    position_deg, speed_deg_s : float
    """
    if abs(volts) > motor.supply_v:
        volts = math.copysign(motor.supply_v, volts)
    if speed_deg_s == 0.0:
        dead_band = motor.dead_band_v[int(volts < 0)]
        if abs(volts) <= STICTION * dead_band:
            return position_deg, 0.0
        way = 1.0 if volts > 0 else -1.0
    else:
        way = 1.0 if speed_deg_s > 0 else -1.0
        dead_band = motor.dead_band_v[int(way < 0)]
    tau = motor.time_constant_s
    final = motor.speed_per_volt * (volts - way * dead_band)  # the speed it would settle at
    left = math.exp(-seconds / tau)
    speed = final + (speed_deg_s - final) * left
    if speed * way >= 0:
        return position_deg + final * seconds + (speed_deg_s - final) * tau * (1 - left), speed
    until = tau * math.log(1 - speed_deg_s / final)  # it comes to rest before the time is over
    position_deg += final * until + speed_deg_s * tau
    return advance(motor, position_deg, 0.0, volts, seconds - until)


def drag_link(link_deg: float, motor_deg: float, backlash_deg: float) -> float:
    """Where the link is, when the motor has the play of ``backlash_deg`` before it takes the link along."""
    half, ahead = backlash_deg / 2, motor_deg - link_deg
    if ahead > half:
        return motor_deg - half
    return motor_deg + half if ahead < -half else link_deg


def encoder_count(motor: Motor, position_deg: float) -> int:
    """Edges that the encoder has shown since position 0."""
    return math.floor(position_deg * motor.counts_per_turn / 360)


def polled_counts(motor: Motor, position_deg_N: ArrayLike) -> tuple[np.ndarray, int]:
    """What a host counts that looks at the two encoder lines now and then, instead of at every edge.

    The two lines go through four states in a circle. Two looks that are one state apart tell one edge
    and its direction; two states apart tell nothing (counted as lost); three apart look like one
    backwards.

    Parameters
    ----------
    position_deg_N : array, where the joint stood at each look

    Returns
    -------
    counts_N : ndarray of int, from 0
    lost : int, looks that told nothing
    """
    edges = np.floor(np.asarray(position_deg_N, float) * motor.counts_per_turn / 360).astype(int)
    moved = np.diff(edges) % 4
    told = np.array([0, 1, 0, -1])[moved]
    return np.concatenate([[0], np.cumsum(told)]), int(np.sum(moved == 2))


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
            With fewer than four pushes, or pushes that no motor makes.
        """
        volts, seconds, turned = (np.abs(np.asarray(a, float)) for a in (volts_N, seconds_N, turned_deg_N))
        if len(volts) < 4 or len(np.unique(volts)) < 2 or len(np.unique(seconds)) < 2:
            raise StereoLabError("Expected four pushes or more, of two voltages and two lengths at least.")
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


def calibrate_motor(push: Callable[[float, float], float], supply_v: float, least_deg: float = 0.5) -> MotorCalibration:
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
        If the motor does not turn, or turns the wrong way.
    """
    starts = [_lowest_voltage(push, way, supply_v, least_deg) for way in (1, -1)]
    rows: dict[int, list[tuple[float, float, float]]] = {1: [], -1: []}
    for extra, seconds in ((0.5, 0.15), (0.5, 0.3), (1.0, 0.15), (1.0, 0.25), (1.4, 0.2)):
        for way, start in zip((1, -1), starts, strict=True):
            volts = min(start + extra, supply_v)
            rows[way].append((volts, seconds, push(way * volts, seconds)))
    fits = [DirectionFit.fit(start, *zip(*rows[way], strict=True)) for way, start in zip((1, -1), starts, strict=True)]
    return MotorCalibration(*fits)


def _lowest_voltage(push, way, supply_v, least_deg):
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

"""What a cheap gear motor does: friction, inertia, load, backlash, an encoder that counts.

Degrees at the joint, degrees per second, volts, N·m; plus is counter-clockwise. The virtual arm and lesson 06
turn these motors; their numbers are those of a FIT0521 (6 V, 210 turns a minute, 3.2 A when it is held, 1364.8 edges a
turn) behind a belt of 3:1. A motor makes as much torque for an ampere as volts for a turning speed, so κ·R = 1/k, k in rad/s:
8 kgf·cm of the motor when it is held, less than the 10 of its maker. What it may hold for long is what the maker's 2.0 W at
170 turns a minute make, 1.15 kgf·cm and not the 2 that stand beside them, less a twentieth that the belt takes.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from numbers import Real

import numpy as np
from numpy.typing import ArrayLike

from stereo_lab.errors import StereoLabError

STICTION = 1.15  # a motor at rest needs this many times the voltage that keeps it turning
ABOVE_ZERO = (
    "speed_per_volt", "time_constant_s", "supply_v", "counts_per_turn", "torque_per_volt", "resistance_ohm"
)  # fmt: skip


@dataclass(frozen=True)
class Motor:
    """A DC gear motor with encoder, as cheap ones are.

    τ·dω/dt = k·(V + Q/κ − F) − ω while it turns. A load Q is like a voltage Q/κ. The friction F, against the motion, is
    the dead band V₀ and a part of the load besides, for gears that are pressed together rub.

    Attributes
    ----------
    speed_per_volt : float, k, degrees per second for each volt above the dead band
    dead_band_v : (counter-clockwise, clockwise), V₀ in volts, both above zero
    time_constant_s : float, τ, without an arm on it
    backlash_deg : float, play between motor and link; the encoder sits on the motor and does not see it
    supply_v : float, no more than this reaches the motor
    counts_per_turn : float, of the encoder, on a turn of the joint
    torque_per_volt : float, κ, N·m at the joint for each volt, held still
    gear_loss : float, the part of a load that friction takes besides
    resistance_ohm : float, of the winding
    current_limit_a : float, no more than this flows: the driver or the supply ends it
    rated_nm : float, what it may hold for long

    Raises
    ------
    StereoLabError
        If one of :data:`ABOVE_ZERO` is not.
    """

    speed_per_volt: float = 75.0
    dead_band_v: tuple[float, float] = (0.4, 0.55)
    time_constant_s: float = 0.06
    backlash_deg: float = 1.0
    supply_v: float = 6.0
    counts_per_turn: float = 4094.4
    torque_per_volt: float = 0.4
    gear_loss: float = 0.1
    resistance_ohm: float = 1.9
    current_limit_a: float = math.inf
    rated_nm: float = 0.32

    def __post_init__(self):
        for name in ABOVE_ZERO:
            value = getattr(self, name)
            if not isinstance(value, Real) or not 0 < value < math.inf:
                raise StereoLabError(f"Expected a number above zero for {name} of a motor; got {value!r}.")

    @classmethod
    def random(cls, rng: np.random.Generator) -> Motor:
        """One of a batch: ±15 % in speed, ±25 % in dead band, the other direction 1.1 to 1.6 times worse."""
        dead_band = 0.4 * rng.uniform(0.75, 1.25)
        return cls(
            speed_per_volt=75.0 * rng.uniform(0.85, 1.15),
            dead_band_v=(dead_band, dead_band * rng.uniform(1.1, 1.6)),
            time_constant_s=rng.uniform(0.03, 0.1),
        )

    @property
    def inertia_kg_m2(self) -> float:
        """What turns in it, as felt at the joint: J = κ·τ/k."""
        return self.torque_per_volt * self.time_constant_s / math.radians(self.speed_per_volt)

    @property
    def torque_per_amp(self) -> float:
        """The torque constant at the joint, N·m for each ampere: κ·R."""
        return self.torque_per_volt * self.resistance_ohm

    @property
    def stall_nm(self) -> float:
        """The most that it can give, at its supply or at the limit of its current."""
        return min(self.torque_per_volt * self.supply_v, self.torque_per_amp * self.current_limit_a)

    def current_a(self, volts: float, speed_deg_s: float) -> float:
        """What flows: the voltage, less what the turning motor makes itself, over the resistance."""
        return (volts - speed_deg_s / self.speed_per_volt) / self.resistance_ohm

    def reaching_v(self, volts: float, speed_deg_s: float) -> float:
        """What of a voltage reaches the motor: not more than the supply has, and no more current than its limit."""
        volts = min(max(volts, -self.supply_v), self.supply_v)
        own, most = speed_deg_s / self.speed_per_volt, self.current_limit_a * self.resistance_ohm
        return min(max(volts, own - most), own + most)


def advance(
    motor: Motor,
    position_deg: float,
    speed_deg_s: float,
    volts: float | None,
    seconds: float,
    load_nm: float = 0.0,
    inertia_kg_m2: float = 0.0,
) -> tuple[float, float]:
    """Let a motor turn for some time under one voltage and one load; exact, by the solution of its equation.

    At zero volts the motor is short-circuited, which brakes it. Where the limit of its current takes part, it is that of the speed
    at the beginning: exact in short steps alone.

    Parameters
    ----------
    position_deg, speed_deg_s : float, of the motor before
    volts : float; more than the supply has is cut down to it. None: no current flows, nothing brakes but friction
    seconds : float, for how long
    load_nm : float, torque on the joint from outside; plus turns it counter-clockwise
    inertia_kg_m2 : float, of what the joint carries

    Returns
    -------
    position_deg, speed_deg_s : float
    """
    pull = load_nm / motor.torque_per_volt
    push = pull + (0.0 if volts is None else motor.reaching_v(volts, speed_deg_s))
    if speed_deg_s == 0.0:
        way = 1.0 if push > 0 else -1.0
        if abs(push) <= STICTION * (motor.dead_band_v[int(push < 0)] + motor.gear_loss * abs(pull)):
            return position_deg, 0.0
    else:
        way = 1.0 if speed_deg_s > 0 else -1.0
    tau = motor.time_constant_s * (1 + inertia_kg_m2 / motor.inertia_kg_m2)
    final = motor.speed_per_volt * (push - way * (motor.dead_band_v[int(way < 0)] + motor.gear_loss * abs(pull)))
    turned, speed = _turn(speed_deg_s, final, tau, seconds, volts is None)
    if speed * way >= 0:
        return position_deg + turned, speed
    until = (
        -speed_deg_s * tau / final if volts is None else tau * math.log(1 - speed_deg_s / final)
    )  # it comes to rest then
    position_deg += _turn(speed_deg_s, final, tau, until, volts is None)[0]
    return advance(motor, position_deg, 0.0, volts, seconds - until, load_nm, inertia_kg_m2)


def _turn(speed_deg_s, final_deg_s, tau, seconds, free):
    """How far a motor turns and how fast it is then, if it does not come to rest before; free: no current brakes it."""
    if free:
        speed = speed_deg_s + final_deg_s / tau * seconds
        return (speed_deg_s + speed) / 2 * seconds, speed
    left = math.exp(-seconds / tau)
    return (
        final_deg_s * seconds + (speed_deg_s - final_deg_s) * tau * (1 - left),
        final_deg_s + (speed_deg_s - final_deg_s) * left,
    )


def drag_link(link_deg: float, motor_deg: float, backlash_deg: float) -> float:
    """Where the link is, when the motor has the play of ``backlash_deg`` before it takes the link along.

    Raises
    ------
    StereoLabError
        If the play is below zero, or no number.
    """
    if not backlash_deg >= 0:  # refuses NaN as well
        raise StereoLabError(f"Expected a play of zero degrees or more; got {backlash_deg}.")
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

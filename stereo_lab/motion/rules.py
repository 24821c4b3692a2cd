"""Ways to stop a motor where it should.

Degrees at the joint, degrees per second, volts; plus is counter-clockwise. The controller looks at the
encoder every ``TICK_S`` seconds and sets a new voltage. The virtual arm and the lesson use the rules
written here; the firmware of the real arm is the same in C.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from stereo_lab.errors import StereoLabError
from stereo_lab.motion.measuring import MotorCalibration
from stereo_lab.motion.motors import Motor, advance, encoder_count

TICK_S = 0.002  # the controller looks and acts 500 times a second
ARRIVED_COUNTS = 0.6  # a goal lies half a count beside the nearest one at most; a little more is there
REST_TICKS = 6  # so long must the encoder stand still
LAG_DEG = 10.0  # the plan waits for a joint that is so far behind
KICK_V = 0.02  # what is added with every tick for a motor that is stuck
KEPT = 0.5  # of what a kick had to add is a load
AFTER_S = 2.0  # so long after the end of a move one looks where the joint is
MOST_LOAD_V = 2.0  # a load that needs more than so many volts is not held


@dataclass(frozen=True)
class Tuning:
    """What the controller knows of a motor; the values before calibration are those of a typical one.

    Attributes
    ----------
    speed_per_volt, time_constant_s : float, k and τ
    dead_band_v, starts_at_v : (counter-clockwise, clockwise), volts without sign
    counts_per_turn : float, of the encoder
    """

    speed_per_volt: float = 75.0
    time_constant_s: float = 0.06
    dead_band_v: tuple[float, float] = (0.4, 0.55)
    starts_at_v: tuple[float, float] = (0.46, 0.65)
    counts_per_turn: float = 4094.4

    @classmethod
    def of(cls, calibration: MotorCalibration, counts_per_turn: float = 4094.4) -> Tuning:
        """From a :class:`MotorCalibration`."""
        return cls(
            calibration.speed_per_volt,
            calibration.time_constant_s,
            (calibration.ccw.dead_band_v, calibration.cw.dead_band_v),
            (calibration.ccw.starts_at_v, calibration.cw.starts_at_v),
            counts_per_turn,
        )

    @property
    def arrived_deg(self) -> float:
        """Nearer to the goal than this is there."""
        return ARRIVED_COUNTS * 360 / self.counts_per_turn

    @property
    def kp_v_per_deg(self) -> float:
        """The gain on the error. A motor without friction would swing with it; the dead band takes that away."""
        return 2 / (self.speed_per_volt * self.time_constant_s)

    @property
    def ki_v_per_deg_s(self) -> float:
        """Slow beside the gain above: it takes up what the calibration has wrong, within some time constants."""
        return self.kp_v_per_deg / (4 * self.time_constant_s)


class Rule(Protocol):
    """What :func:`drive` asks of a rule.

    Attributes
    ----------
    done : bool, whether the joint is at its goal and at rest
    holds : bool, optional; whether it goes on holding the joint there, or leaves it to the brake
    """

    done: bool

    def volts(self, measured_deg: float) -> float:
        """The voltage for the next tick."""


def slow_down_volts(left_deg: float, zone_deg: float, fast_v: float, slow_v: float) -> float:
    """The paper's rule: full speed, slow within ``zone_deg`` before the goal, brake at the goal.

    Parameters
    ----------
    left_deg : float, still to go; below zero past the goal
    zone_deg : float, how far before the goal it gets slow
    fast_v, slow_v : float, the two voltages

    Returns
    -------
    float, volts; 0 brakes, also where nobody knows how far it still is (NaN)
    """
    if not left_deg > 0:
        return 0.0
    return fast_v if left_deg > zone_deg else slow_v


def slow_zone_deg(time_constant_s: float, cruise_deg_s: float) -> float:
    """A slow zone that suits the motor.

    A motor sheds its speed with the time constant τ, and turns by up to τ·ω degrees meanwhile. Half as much again
    leaves room to settle at the slow speed; more costs time, for there it creeps.

    Raises
    ------
    StereoLabError
        If one of the two is below zero, or no number.
    """
    if not (time_constant_s >= 0 and cruise_deg_s >= 0):  # refuses NaN as well
        raise StereoLabError(
            f"Expected a time constant and a speed of zero or more; got {time_constant_s} s and {cruise_deg_s} deg/s."
        )
    return 1.5 * time_constant_s * cruise_deg_s


def trapezoid_step(
    position_deg: float,
    speed_deg_s: float,
    goal_deg: float,
    cruise_deg_s: float,
    acceleration_deg_s2: float,
    seconds: float = TICK_S,
) -> tuple[float, float]:
    """The next point of a motion that speeds up, cruises and slows down in time.

    Drawn over time, its speed is a trapezoid. The goal may change on the way.

    Parameters
    ----------
    position_deg, speed_deg_s : float, where the plan is now
    goal_deg, cruise_deg_s, acceleration_deg_s2 : float, where it goes, and how fast at most
    seconds : float, from this point to the next

    Returns
    -------
    position_deg, speed_deg_s : float
    """
    left = goal_deg - position_deg
    way = 1.0 if left >= 0 else -1.0
    change = acceleration_deg_s2 * seconds
    in_time = math.sqrt(change * change / 4 + 2 * acceleration_deg_s2 * abs(left)) - change / 2
    faster, slower = speed_deg_s * way + change, speed_deg_s * way - change
    speed = in_time if in_time < cruise_deg_s else cruise_deg_s
    speed = faster if speed > faster else slower if speed < slower else speed
    if abs(left) <= abs(speed) * seconds and abs(speed) <= 2 * change:
        return goal_deg, 0.0
    return position_deg + way * speed * seconds, way * speed


def trapezoid_s(way_deg: float, cruise_deg_s: float, acceleration_deg_s2: float) -> float:
    """How long such a motion takes, from rest to rest; a short one never reaches its cruise, and is a triangle.

    Raises
    ------
    StereoLabError
        If it has no speed or no acceleration.
    """
    if not (cruise_deg_s > 0 and acceleration_deg_s2 > 0):  # refuses NaN as well
        raise StereoLabError(
            f"Expected a speed and an acceleration above zero; got {cruise_deg_s} deg/s and {acceleration_deg_s2} deg/s²."
        )
    way_deg = abs(way_deg)
    if way_deg < cruise_deg_s**2 / acceleration_deg_s2:
        return 2 * math.sqrt(way_deg / acceleration_deg_s2)
    return way_deg / cruise_deg_s + cruise_deg_s / acceleration_deg_s2


def tracking_volts(
    tuning: Tuning, speed_deg_s: float, acceleration_deg_s2: float, error_deg: float, integral_v: float
) -> float:
    """The voltage that keeps a turning motor on its plan.

    V = ±V₀ + (ω + τ·dω/dt)/k + Kp·e + Ki·∫e dt: the motor's equation solved for V, and what the error
    e = plan − measured asks for on top. ω is the planned speed.
    """
    friction = tuning.dead_band_v[0] if speed_deg_s > 0 else -tuning.dead_band_v[1]
    feed_forward = (speed_deg_s + tuning.time_constant_s * acceleration_deg_s2) / tuning.speed_per_volt
    return friction + feed_forward + tuning.kp_v_per_deg * error_deg + integral_v


class SlowDownRule:
    """One move by the paper's rule; :meth:`volts` is asked once every tick.

    Parameters
    ----------
    start_deg, goal_deg : float, where the joint is and where it should stop
    zone_deg : float, how far before the goal it gets slow
    cruise_deg_s : float, its speed before that
    rule : function like :func:`slow_down_volts`
    """

    def __init__(
        self,
        tuning: Tuning,
        start_deg: float,
        goal_deg: float,
        zone_deg: float = 5.0,
        cruise_deg_s: float = 180.0,
        rule: Callable[[float, float, float, float], float] = slow_down_volts,
    ) -> None:
        self.start_deg, self.goal_deg, self.zone_deg, self.rule = start_deg, goal_deg, zone_deg, rule
        self.way = 1.0 if goal_deg >= start_deg else -1.0
        side = self.way < 0
        self.slow_v = tuning.starts_at_v[side]
        self.fast_v = max(tuning.dead_band_v[side] + cruise_deg_s / tuning.speed_per_volt, self.slow_v)
        self.done = False
        self._rest = _Rest(start_deg)

    def volts(self, measured_deg: float) -> float:
        """The voltage for the next tick; 0 brakes."""
        left = (self.goal_deg - measured_deg) * self.way
        rests = self._rest.ticks(measured_deg) >= REST_TICKS
        self.done = left <= 0 and rests
        return self.way * _as_volts(self.rule(left, self.zone_deg, self.fast_v, self.slow_v), left)


def _as_volts(told: Any, left_deg: float) -> float:
    """What a rule asks for as a number, which a rule of one's own need not give."""
    try:
        volts = float(told)
    except (TypeError, ValueError):
        volts = math.nan
    if math.isnan(volts):
        raise StereoLabError(
            f"Expected a number of volts from the rule; with {left_deg:.1f} degrees to go it gave {told!r}. Does each of its ways "
            "end in a return with a number?"
        )
    return volts


class Profile:
    """One move along a trapezoid, held by feed-forward and feedback, and then its end, held against the arm's weight.

    :meth:`volts` is asked once every tick. A motor that friction holds, on the way or beside the goal, is kicked: with the
    voltage that starts it and a little more with every tick, until the encoder moves. Had the kick to add much, there is
    a load that nobody told of: a part of it is kept.

    Attributes
    ----------
    done : bool, whether the joint is at its goal and at rest
    planned_deg, speed_deg_s, speeding_up_deg_s2 : float, where the plan is, how fast, and how that changes
    held_v : float, what holds the joint where it is: its weight as far as it is known, and what was learned on the way
    kick_v : float, what the kick under way has added
    """

    holds = True

    def __init__(
        self,
        tuning: Tuning,
        start_deg: float,
        goal_deg: float,
        cruise_deg_s: float = 180.0,
        acceleration_deg_s2: float = 1000.0,
        load_v: float = 0.0,
    ) -> None:
        self.tuning = tuning
        self.planned_deg, self.speed_deg_s, self.speeding_up_deg_s2 = start_deg, 0.0, 0.0
        self.load_v = load_v
        self._rest, self.kick_v, self.held_v = _Rest(start_deg), 0.0, load_v
        self.retarget(goal_deg, cruise_deg_s, acceleration_deg_s2)

    def retarget(self, goal_deg: float, cruise_deg_s: float, acceleration_deg_s2: float) -> None:
        """Give the move another goal; on its way, too. Without speed and acceleration it stays where it is.

        Raises
        ------
        StereoLabError
            If the goal is no number, or speed or acceleration are below zero.
        """
        if not (math.isfinite(goal_deg) and cruise_deg_s >= 0 and acceleration_deg_s2 >= 0):  # refuses NaN as well
            raise StereoLabError(
                "Expected a goal in degrees, and a speed and an acceleration of zero or more; got "
                f"{goal_deg}, {cruise_deg_s} and {acceleration_deg_s2}."
            )
        self.goal_deg, self.done = goal_deg, False
        self.cruise_deg_s, self.acceleration_deg_s2 = cruise_deg_s, acceleration_deg_s2

    def volts(self, measured_deg: float, weight_v: float = 0.0) -> float:
        """The voltage for the next tick. ``weight_v``: what holds the arm's weight in this pose, as far as it is known."""
        before = self.speed_deg_s
        if (self.planned_deg - measured_deg) * before < LAG_DEG * abs(before) or before == 0.0:  # else it waits
            self.planned_deg, self.speed_deg_s = trapezoid_step(
                self.planned_deg, before, self.goal_deg, self.cruise_deg_s, self.acceleration_deg_s2
            )
        rests = self._rest.ticks(measured_deg)
        there = self.goal_deg - self.planned_deg
        if there * self.speed_deg_s >= 0 and (self.goal_deg - measured_deg) * there <= 0:
            self.planned_deg, self.speed_deg_s = self.goal_deg, 0.0  # ahead of its plan, or at its end
        self.speeding_up_deg_s2 = (self.speed_deg_s - before) / TICK_S
        error = self.planned_deg - measured_deg
        ended = self.planned_deg == self.goal_deg and self.speed_deg_s == 0.0
        there_now = ended and abs(error) <= self.tuning.arrived_deg
        self.done = there_now and rests >= REST_TICKS
        self.held_v = weight_v + self.load_v
        if there_now:
            self.kick_v = 0.0
            return self.held_v
        if rests >= REST_TICKS and (ended or error * self.speed_deg_s > 0):
            return self._kick(error)
        self._learn(error)
        self.held_v = weight_v + self.load_v
        if ended:
            return self._come_back(error)
        return tracking_volts(self.tuning, self.speed_deg_s, self.speeding_up_deg_s2, error, self.held_v)

    def _come_back(self, error):
        """The voltage for a motor beside its goal; friction is added where it turns toward it, lest it is learned as a load."""
        rubs = self.tuning.dead_band_v[int(error < 0)] if error * self._rest.way > 0 else 0.0
        return self.held_v + math.copysign(rubs, error) + self.tuning.kp_v_per_deg * error

    def _kick(self, error):
        """The voltage for a motor that is stuck: what starts it, and more with every tick; never less than its error asks."""
        self.kick_v += KICK_V
        starts_v = self.tuning.starts_at_v[int(error < 0)] + self.kick_v
        return self.held_v + math.copysign(max(starts_v, self.tuning.kp_v_per_deg * abs(error)), error)

    def _learn(self, error):
        """What the error, and a kick that has just ended, tell of the load; never more than a motor may hold."""
        kept = math.copysign(KEPT * self.kick_v, error) if error else 0.0
        told = self.tuning.ki_v_per_deg_s * error * TICK_S + kept
        self.load_v = min(max(self.load_v + told, -MOST_LOAD_V), MOST_LOAD_V)
        self.kick_v = 0.0


class _Rest:
    """For how many ticks the encoder has stood still, and which way it turned before."""

    def __init__(self, measured_deg):
        self._last, self._ticks, self.way = measured_deg, 0, 0.0

    def ticks(self, measured_deg):
        self._ticks = self._ticks + 1 if measured_deg == self._last else 0
        if self._ticks == 0:
            self.way = measured_deg - self._last
        self._last = measured_deg
        return self._ticks


@dataclass(frozen=True, eq=False)
class Run:
    """One move of one motor, tick by tick.

    Attributes
    ----------
    time_s, position_deg, speed_deg_s, measured_deg, volts : ndarray, equally long
    rest_deg : float, where it is two seconds after its rule was done, or was given up and braked
    arrived_s : float, when the rule was done
    """

    time_s: np.ndarray
    position_deg: np.ndarray
    speed_deg_s: np.ndarray
    measured_deg: np.ndarray
    volts: np.ndarray
    rest_deg: float
    arrived_s: float


def drive(
    motor: Motor,
    rule: Rule,
    longest_s: float = 3.0,
    looks_per_s: float | None = None,
    lost: float = 0.0,
    seed: int = 0,
    load_nm: float = 0.0,
) -> Run:
    """Drive a motor from rest at 0° by a rule.

    Parameters
    ----------
    motor : Motor
    rule : SlowDownRule, Profile or another :class:`Rule`
    longest_s : float, when it is given up
    looks_per_s : float or None
        How often the encoder is looked at; None: every edge is caught by an interrupt.
    lost : float, which part of the looks gets lost on the way
    seed : int, for what gets lost
    load_nm : float, a torque on the joint from outside; plus turns it counter-clockwise

    Returns
    -------
    Run

    Raises
    ------
    StereoLabError
        If there is no time for one look at the encoder, or a rule of one's own gives no voltage.
    """
    if not TICK_S <= longest_s < math.inf:
        raise StereoLabError(
            f"Expected a number of seconds after which a move is given up, {TICK_S} or more; longest_s is {longest_s!r}."
        )
    rng = np.random.default_rng(seed)
    degree = 360 / motor.counts_per_turn
    position, speed = degree / 2, 0.0  # in the middle of a count
    seen, count, owed, rows = 0, 0, 0.0, []
    steps = 1 if looks_per_s is None else max(1, round(looks_per_s * TICK_S))

    def turn(volts):
        nonlocal position, speed, owed, count, seen
        for _ in range(steps):
            position, speed = advance(motor, position, speed, volts, TICK_S / steps, load_nm)
            owed += 1.0 if looks_per_s is None else looks_per_s * TICK_S / steps
            if owed >= 1 - 1e-9:
                owed -= 1
                if lost == 0 or rng.random() >= lost:
                    edges = encoder_count(motor, position)
                    count = edges if looks_per_s is None else count + (0, 1, 0, -1)[(edges - seen) % 4]
                    seen = edges

    for tick in range(round(longest_s / TICK_S)):
        measured = count * degree
        volts = rule.volts(measured)
        rows.append((tick * TICK_S, position - degree / 2, speed, measured, volts))
        if rule.done:
            break
        turn(volts)
    if rule.done and getattr(rule, "holds", False):
        for _ in range(round(AFTER_S / TICK_S)):
            before = position
            turn(volts)
            if position == before and speed == 0.0:
                break  # friction holds it, and nothing changes any more
            volts = rule.volts(count * degree)
    else:
        position, _ = advance(motor, position, speed, volts if rule.done else 0.0, AFTER_S, load_nm)
    columns = (np.array(column) for column in zip(*rows, strict=True))
    return Run(*columns, position - degree / 2, rows[-1][0])  # type: ignore[call-arg, arg-type]  # five columns

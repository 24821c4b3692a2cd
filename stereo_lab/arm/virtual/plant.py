"""What the virtual controller turns: two motors, their encoders, links and home switches, and what can go wrong."""

from __future__ import annotations

import math
from dataclasses import dataclass

from stereo_lab.kinematics import GRAVITY_M_S2, NM, TwoLinkArm, inertia_parts_kg_m2, moments_g_mm
from stereo_lab.motion import TICK_S, Motor, advance, drag_link, encoder_count

BENCH_MOTORS = (
    Motor(speed_per_volt=79.0, dead_band_v=(0.36, 0.49), time_constant_s=0.07),
    Motor(speed_per_volt=69.0, dead_band_v=(0.44, 0.53), time_constant_s=0.045),
)
EQUAL_MOTORS = (Motor(dead_band_v=(0.4, 0.4), backlash_deg=0.0),) * 2
BENCH_ARM = TwoLinkArm(250.0, 200.0, ((-165.0, 165.0), (-155.0, 155.0)))  # with the masses of a light build
SWITCHES_DEG = (-170.0, -160.0)  # where the home switches close
CAM_DEG = 12.0  # a cam on the joint holds its switch closed for so long, once in a turn
END_STOPS_DEG = ((-177.0, 169.0), (-167.0, 159.0))


@dataclass
class Faults:
    """What can go wrong; change them while the arm is connected.

    Attributes
    ----------
    noise : float, which part of the bytes is hit by one flipped bit, both ways
    silent : bool, nothing comes back any more
    unplugged : bool, the port is gone
    stalled, reversed : set of 1 and 2, joints that something holds, joints whose encoder is reversed
    """

    noise: float = 0.0
    silent: bool = False
    unplugged: bool = False
    stalled: frozenset[int] = frozenset()
    reversed: frozenset[int] = frozenset()


class Plant:
    """Two motors, their encoders, home switches, and the two links that they carry. Joints are counted from 0 here.

    The links' motion is M(θ)·θ'' + C(θ, θ') + g(θ) = τ. What a joint feels of its own inertia goes into its motor's
    equation; all the rest, its weight, the swing of the links and what the other joint's speeding up does to it, is its
    load. What the other joint does is that of the tick before.

    Parameters
    ----------
    arm : TwoLinkArm, or None for links without weight
    """

    def __init__(self, motors: tuple[Motor, Motor], faults: Faults, arm: TwoLinkArm | None = None) -> None:
        self.motors, self.faults = motors, faults
        self.positions = [180 / m.counts_per_turn for m in motors]  # in the middle of a count
        self.speeds, self.links = [0.0, 0.0], [0.0, 0.0]
        self.volts: list[float | None] = [0.0, 0.0]  # None: no current, the driver has let go
        self.weights = (0.0, 0.0) if arm is None else tuple(GRAVITY_M_S2 * NM * m for m in moments_g_mm(arm))
        self.inertias = (0.0, 0.0, 0.0) if arm is None else inertia_parts_kg_m2(arm)
        self.accelerations = [0.0, 0.0]  # rad/s², of the tick before
        self.still = False  # whether it is at rest, and nothing has changed since

    def set_duty(self, j: int, duty: int | None) -> None:
        """Set a motor's voltage, in 255ths of its supply; None lets it go."""
        volts = None if duty is None else duty * self.motors[j].supply_v / 255
        self.still = self.still and volts == self.volts[j]
        self.volts[j] = volts

    def counts(self, j: int) -> int:
        """Edges that a joint's encoder has shown since it was switched on."""
        count = encoder_count(self.motors[j], self.positions[j])
        return -count if j + 1 in self.faults.reversed else count

    def pressed(self, j: int) -> bool:
        """Whether a joint's home switch is closed."""
        return (SWITCHES_DEG[j] - self.links[j]) % 360 <= CAM_DEG

    def tick(self) -> None:
        """Let both motors turn for TICK_S."""
        if self.still:
            return
        before, loads = self.speeds.copy(), self._loads()
        for j, motor in enumerate(self.motors):
            self._turn(j, motor, *loads[j])
        self.accelerations = [math.radians(now - then) / TICK_S for now, then in zip(self.speeds, before, strict=True)]
        self.still = self.speeds == before == [0.0, 0.0]

    def _loads(self):
        """For each joint the torque on it from outside, N·m, and the inertia that it carries, kg·m²."""
        one, other = (math.radians(link) for link in self.links)
        first, second = self.inertias[:2]
        across = self.inertias[2] * math.cos(other)
        swing = self.inertias[2] * math.sin(other)
        speed1, speed2 = (math.radians(speed) for speed in self.speeds)
        elbow_weight = self.weights[1] * math.cos(one + other)
        coupled = second + across
        shoulder = swing * speed2 * (2 * speed1 + speed2) - coupled * self.accelerations[1]
        elbow = -swing * speed1 * speed1 - coupled * self.accelerations[0]
        return (
            (shoulder - self.weights[0] * math.cos(one) - elbow_weight, first + second + 2 * across),
            (elbow - elbow_weight, second),
        )

    def _turn(self, j, motor, load_nm, inertia_kg_m2):
        if self.faults.stalled and j + 1 in self.faults.stalled:
            self.speeds[j] = 0.0
            return
        position, speed = advance(
            motor, self.positions[j], self.speeds[j], self.volts[j], TICK_S, load_nm, inertia_kg_m2
        )
        low, high = END_STOPS_DEG[j]
        if not low <= position <= high:
            position, speed = min(max(position, low), high), 0.0
        self.positions[j], self.speeds[j] = position, speed
        self.links[j] = drag_link(self.links[j], position, motor.backlash_deg)

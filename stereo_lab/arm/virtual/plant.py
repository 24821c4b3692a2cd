"""What the virtual controller turns: two motors, their encoders, links and home switches, and what can go wrong."""

from __future__ import annotations

from dataclasses import dataclass

from stereo_lab.motion import TICK_S, Motor, advance, drag_link, encoder_count

BENCH_MOTORS = (
    Motor(speed_per_volt=212.0, dead_band_v=(1.05, 1.45), time_constant_s=0.07),
    Motor(speed_per_volt=183.0, dead_band_v=(1.3, 1.55), time_constant_s=0.045),
)
EQUAL_MOTORS = (Motor(dead_band_v=(1.2, 1.2), backlash_deg=0.0),) * 2
SWITCHES_DEG = (-185.0, -165.0)  # where the home switches close
END_STOPS_DEG = ((-192.0, 188.0), (-172.0, 168.0))


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
    """Two motors, their encoders, links and home switches. Joints are counted from 0 here."""

    def __init__(self, motors: tuple[Motor, Motor], faults: Faults) -> None:
        self.motors, self.faults = motors, faults
        self.positions = [180 / m.counts_per_turn for m in motors]  # in the middle of a count
        self.speeds, self.volts, self.links = [0.0, 0.0], [0.0, 0.0], [0.0, 0.0]

    def set_duty(self, j: int, duty: int) -> None:
        """Set a motor's voltage, in 255ths of its supply."""
        self.volts[j] = duty * self.motors[j].supply_v / 255

    def counts(self, j: int) -> int:
        """Edges that a joint's encoder has shown since it was switched on."""
        count = encoder_count(self.motors[j], self.positions[j])
        return -count if j + 1 in self.faults.reversed else count

    def pressed(self, j: int) -> bool:
        """Whether a joint's home switch is closed."""
        return self.links[j] <= SWITCHES_DEG[j]

    @property
    def at_rest(self) -> bool:
        """Whether both motors stand still without voltage."""
        return self.speeds == [0.0, 0.0] and self.volts == [0.0, 0.0]

    def tick(self) -> None:
        """Let both motors turn for TICK_S."""
        for j in (0, 1):
            if self.speeds[j] != 0.0 or self.volts[j] != 0.0:
                self._turn(j, self.motors[j])

    def _turn(self, j, motor):
        if self.faults.stalled and j + 1 in self.faults.stalled:
            self.speeds[j] = 0.0
            return
        position, speed = advance(motor, self.positions[j], self.speeds[j], self.volts[j], TICK_S)
        low, high = END_STOPS_DEG[j]
        if not low <= position <= high:
            position, speed = min(max(position, low), high), 0.0
        self.positions[j], self.speeds[j] = position, speed
        self.links[j] = drag_link(self.links[j], position, motor.backlash_deg)

"""One joint of a controller: its parameters, where it stands, and what it is doing."""

from __future__ import annotations

import math
from typing import Any

from stereo_lab.motion import TICK_S, Profile, Tuning

IDLE, MOVE, PUSH, SEEK, BACK, CREEP, REST = range(7)
RUNAWAY_DEG, FASTER_DEG_S = 0.6, 10.0  # so far against its voltage, and so much faster than it began
WRONG_COUNTS = 2.5  # against a kick also so many: a coarse encoder has one count for more than RUNAWAY_DEG
FOLLOW_DEG = 20.0  # a joint so far behind its plan is stalled
STALL_TICKS = 250  # by the rule: half a second of voltage without a count is a stall
STUCK_TICKS, STALL_V = 50, 1.5  # along a profile: so long without a count, with so much more than starts it
HELD_TICKS = 125  # pushed: the same for so long
CLOSED_TICKS = 3  # a home switch that is closed for less is a glitch on its wire
DEFAULTS = {
    "lo": -180.0, "hi": 180.0, "home": -185.0, "cruise": 180.0, "acc": 1000.0, "k": 200.0, "tau": 60.0, "db+": 1.2,
    "db-": 1.6, "st+": 1.4, "st-": 1.85, "zone": 5.0, "counts": 1920.0, "supply": 6.0,
}  # fmt: skip
SECOND_JOINT = {"lo": -160.0, "hi": 160.0, "home": -165.0}


class Joint:
    """One joint: its parameters, where it stands, and what it is doing.

    Attributes
    ----------
    parameters : dict, as SET takes them; see PROTOCOL.md
    mode : IDLE, MOVE, PUSH, or a leg of the homing: SEEK, BACK, CREEP, REST
    rule : SlowDownRule or Profile of the move under way
    duty : int, -255 to 255, what its motor gets
    position_deg, speed_deg_s : float, by its encoder
    homed : bool, whether it knows where it stands
    """

    def __init__(self, **changed: float) -> None:
        self.parameters = {**DEFAULTS, **changed}
        self.mode, self.duty = IDLE, 0
        self.rule: Any = None
        self.zero_count, self.zero_deg, self.homed = 0, 0.0, False
        self.position_deg = self.speed_deg_s = 0.0
        self.against_deg = self.against_from_deg_s = 0.0
        self.wrong_deg = 0.0  # turned against a kick
        self.closed_count = 0
        self.still_ticks, self.push_ticks, self.closed_ticks, self.tries = 0, 0, 0, 0
        self.retune()

    def retune(self) -> None:
        """Take over changed parameters."""
        p = self.parameters
        self.tuning = Tuning(p["k"], p["tau"] / 1000, (p["db+"], p["db-"]), (p["st+"], p["st-"]), p["counts"])
        self.degree = 360 / p["counts"]
        self.stall_v = max(p["st+"], p["st-"]) + STALL_V

    def look(self, count: int, closed: bool) -> None:
        """Take in what the encoder and the home switch say."""
        if closed and not self.closed_ticks:
            self.closed_count = count  # the place counts, if it proves to be no glitch
        self.closed_ticks = self.closed_ticks + 1 if closed else 0
        position = self.zero_deg + (count - self.zero_count) * self.degree
        turned = position - self.position_deg
        self.position_deg = position
        self.speed_deg_s += 0.1 * (turned / TICK_S - self.speed_deg_s)
        if turned == 0:
            self.still_ticks += 1
            return
        self.still_ticks = 0
        if turned * self.duty < 0:
            if self.against_deg == 0.0:
                self.against_from_deg_s = abs(self.speed_deg_s)
            self.against_deg += abs(turned)
            if getattr(self.rule, "kick_v", 0.0):  # it was at rest: nothing but the kick turns it
                self.wrong_deg += abs(turned)
        elif self.duty:
            self.against_deg = self.wrong_deg = 0.0

    @property
    def runs_away(self) -> bool:
        """Whether it turns against its voltage, and faster and faster: not just being braked; or from rest."""
        faster = abs(self.speed_deg_s) > self.against_from_deg_s + FASTER_DEG_S
        wrong = self.wrong_deg > max(RUNAWAY_DEG, WRONG_COUNTS * self.degree)
        return wrong or (self.against_deg > RUNAWAY_DEG and faster)

    @property
    def pressed(self) -> bool:
        """Whether the home switch is closed, for long enough to be no glitch."""
        return self.closed_ticks >= CLOSED_TICKS

    @property
    def held(self) -> bool:
        """Whether a push does not turn it that should."""
        return self.still_ticks > HELD_TICKS and abs(self.duty) * self.parameters["supply"] / 255 > self.stall_v

    def stand_at(self, count: int, angle_deg: float, now: int | None = None) -> None:
        """Call the place of a count so many degrees. ``now``: the count of where it stands, if it is another."""
        self.zero_count, self.zero_deg = count, angle_deg
        self.position_deg = angle_deg + (0 if now is None else now - count) * self.degree

    def plan(self, goal_deg: float, cruise: float, acceleration: float, from_plan: Profile | None = None) -> Profile:
        """A profile to a goal, from rest; or the one that is under way, with a new goal."""
        if from_plan is None:
            return Profile(self.tuning, self.position_deg, goal_deg, cruise, acceleration)
        from_plan.retarget(goal_deg, cruise, acceleration)
        return from_plan

    def stalls(self, volts: float) -> bool:
        """Whether it does not turn as it should under this voltage."""
        if not isinstance(self.rule, Profile):
            return self.still_ticks > STALL_TICKS and volts != 0
        behind = abs(self.rule.planned_deg - self.position_deg) > FOLLOW_DEG
        return behind or (self.still_ticks > STUCK_TICKS and abs(volts) > self.stall_v)

    def duration_s(self, goal_deg: float) -> float:
        """Seconds of a trapezoid from here to a goal."""
        cruise, acceleration = self.parameters["cruise"], self.parameters["acc"]
        way = abs(goal_deg - self.position_deg)
        if way < cruise**2 / acceleration:
            return 2 * math.sqrt(way / acceleration)
        return way / cruise + cruise / acceleration

    @property
    def busy(self) -> bool:
        """Whether it does anything."""
        return self.mode != IDLE

"""One joint of a controller: its parameters, where it stands, and what it is doing."""

from __future__ import annotations

import math
from typing import Any

from stereo_lab.motion import MOST_LOAD_V, REST_TICKS, TICK_S, Profile, Tuning, trapezoid_s

IDLE, HOLD, MOVE, PUSH, SEEK, BACK, CREEP, REST = range(8)
RUNAWAY_DEG = 0.6  # so far against its voltage
WRONG_COUNTS = 2.5  # but also so many: a coarse encoder has one count for more than RUNAWAY_DEG
FOLLOW_DEG = 20.0  # a joint so far behind its plan is stalled
STALL_TICKS = 250  # by the rule: half a second of voltage without a count is a stall
STUCK_TICKS = 50  # along a profile: so long, with so much more than starts it, and no faster
STALL_V = 1.5
CREEPS_DEG_S = 10.0
HELD_TICKS = 125  # pushed: the same for so long
ROLLS = 3.0  # by the rule: braked, a motor rolls on by τ·speed; with an arm that it carries by up to three times that
NET_COUNTS = 1.5  # by the rule: a lone line of an encoder goes to and fro by one count; what turns goes farther
OWED_DEG, OWED_COUNTS = 5.0, 8.0  # so far should its voltage have turned it, and it has not: a stall
OWED_TICKS = 20  # but not before so long: a motor needs its time to start
CLOSED_TICKS = 3  # a home switch that is closed for less is a glitch on its wire
DEFAULTS = {
    "lo": -165.0, "hi": 165.0, "home": -170.0, "cruise": 180.0, "acc": 500.0, "k": 75.0, "tau": 60.0, "db+": 0.4,
    "db-": 0.55, "st+": 0.46, "st-": 0.65, "zone": 5.0, "counts": 4094.4, "supply": 6.0, "g1": 0.0, "g2": 0.0,
}  # fmt: skip
SECOND_JOINT = {"lo": -155.0, "hi": 155.0, "home": -160.0}


class Joint:
    """One joint: its parameters, where it stands, and what it is doing.

    Attributes
    ----------
    parameters : dict, as SET takes them; see PROTOCOL.md
    mode : IDLE, HOLD, MOVE, PUSH, or a leg of the homing: SEEK, BACK, CREEP, REST
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
        self.rested_v = 0.0  # the voltage under which it rested when the command under way began
        self.obeyed_deg = self.wrong_deg = 0.0  # turned since then with what was added to it, and against that
        self.weight_v = self.load_v = (
            0.0  # what holds the arm's weight, as far as it is known, and what was learned besides
        )
        self.closed_count = 0
        self.still_ticks = REST_TICKS  # whatever it did before, nothing moves it now
        self.push_ticks, self.closed_ticks, self.tries, self.push_v = 0, 0, 0, 0.0
        self.strained_ticks = self.idle_ticks = 0
        self.mark_deg = self.owed_deg = 0.0  # by the rule: where it last was for sure, and what it owes since
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
        added_v = self.volts - self.rested_v
        if turned * added_v > 0 or turned * self.left_deg > 0:  # with its voltage, or where it should
            self.obeyed_deg += abs(turned)
        elif abs(added_v) > 2 * self.tuning.dead_band_v[int(added_v < 0)]:  # less may be the pull of the other joint
            self.wrong_deg += abs(turned)

    @property
    def left_deg(self) -> float:
        """How far it has to go; 0 without a goal."""
        return self.rule.goal_deg - self.position_deg if isinstance(self.rule, Profile) else 0.0

    @property
    def volts(self) -> float:
        """What its motor gets."""
        return self.duty * self.parameters["supply"] / 255

    def begin(self, mode: int) -> None:
        """A command begins. What was seen so far does not count any more, unless it goes on with another goal."""
        if self.mode != mode:
            self.rested_v, self.obeyed_deg, self.wrong_deg = self.volts, 0.0, 0.0
            if self.still_ticks < REST_TICKS:
                self.obeyed_deg = math.inf  # what carries it on may be a load
            self.still_ticks = self.strained_ticks = 0
            self.mark_deg, self.owed_deg = self.position_deg, 0.0
        self.mode = mode

    @property
    def runs_away(self) -> bool:
        """Whether it turned from rest against what was added to the voltage under which it rested.

        No load does that: it would have turned the joint before.
        """
        most = max(RUNAWAY_DEG, WRONG_COUNTS * self.degree)
        return self.wrong_deg > most and self.obeyed_deg < most

    @property
    def overloaded(self) -> bool:
        """Whether it holds all the load that it may, and that is not enough or just so: a weight, and no wrong wire."""
        return abs(self.load_v) >= MOST_LOAD_V

    @property
    def pressed(self) -> bool:
        """Whether the home switch is closed, for long enough to be no glitch."""
        return self.closed_ticks >= CLOSED_TICKS

    @property
    def held(self) -> bool:
        """Whether a push does not turn it that should."""
        return self.still_ticks > HELD_TICKS and abs(self.push_v) > self.stall_v

    def stand_at(self, count: int, angle_deg: float, now: int | None = None) -> None:
        """Call the place of a count so many degrees. ``now``: the count of where it stands, if it is another."""
        self.zero_count, self.zero_deg = count, angle_deg
        self.position_deg = angle_deg + (0 if now is None else now - count) * self.degree

    def plan(self, goal_deg: float, cruise: float, acceleration: float, from_plan: Profile | None = None) -> Profile:
        """A profile to a goal, from rest; or the one that is under way, with a new goal."""
        if from_plan is None:
            return Profile(self.tuning, self.position_deg, goal_deg, cruise, acceleration, self.load_v)
        from_plan.retarget(goal_deg, cruise, acceleration)
        return from_plan

    def hold(self) -> None:
        """Hold it where it stands."""
        self.mode, self.strained_ticks = HOLD, 0
        self.rule = self.plan(self.position_deg, 0.0, 0.0)

    @property
    def held_v(self) -> float:
        """What holds it in its pose."""
        return self.weight_v + self.load_v

    def weigh(self, cosines: tuple[float, float]) -> None:
        """What holds the arm's weight now; ``cosines``: of the angles of both links, 0 where they are not known."""
        self.weight_v = self.parameters["g1"] * cosines[0] + self.parameters["g2"] * cosines[1]

    def keep_holding(self, cosines: tuple[float, float]) -> None:
        """What holds it goes on, when what is known of its weight changes: the load takes up the difference."""
        held_v = self.held_v
        self.weigh(cosines)
        self.load_v = min(max(held_v - self.weight_v, -MOST_LOAD_V), MOST_LOAD_V)
        if self.mode == HOLD:
            self.mode = IDLE  # held anew, where it stands

    @property
    def rolls_beyond(self) -> bool:
        """Whether it is so fast, and so near the limit ahead, that it must be braked now not to roll beyond it."""
        way, p = self.rule.way, self.parameters
        room = p["hi"] - self.position_deg if way > 0 else self.position_deg - p["lo"]
        return room < ROLLS * p["tau"] / 1000 * self.speed_deg_s * way

    def follow(self) -> float:
        """The voltage that its rule asks for."""
        if not isinstance(self.rule, Profile):
            volts = self.rule.volts(self.position_deg)
            return 0.0 if self.rolls_beyond else volts
        volts = self.rule.volts(self.position_deg, self.weight_v)
        self.load_v = self.rule.load_v
        return volts

    def stalls(self, volts: float) -> bool:
        """Whether it does not turn as it should under this voltage: much more than holds its weight, and no motion."""
        if not isinstance(self.rule, Profile):
            backwards = (self.rule.start_deg - self.position_deg) * self.rule.way
            no_edge = self.still_ticks > STALL_TICKS and volts != 0
            return self._owes_much() or no_edge or backwards > FOLLOW_DEG
        push_v = volts - self.weight_v
        turns = self.speed_deg_s * push_v > CREEPS_DEG_S * abs(push_v)
        beside = abs(self.rule.planned_deg - self.position_deg)
        strained = abs(push_v) > self.stall_v or (self.overloaded and beside > self.tuning.arrived_deg)
        self.strained_ticks = self.strained_ticks + 1 if strained and not turns else 0
        return beside > FOLLOW_DEG or self.strained_ticks > STUCK_TICKS

    def _owes_much(self):
        """Whether the voltage of a move by the rule should have turned it by far more than its edges tell."""
        if abs(self.position_deg - self.mark_deg) > NET_COUNTS * self.degree:
            self.mark_deg, self.owed_deg, self.strained_ticks = self.position_deg, 0.0, 0
        way, tuning = self.rule.way, self.tuning
        free_v = way * (self.volts - self.weight_v) - tuning.dead_band_v[int(way < 0)]
        self.owed_deg = max(self.owed_deg + tuning.speed_per_volt * free_v * TICK_S, 0.0)
        self.strained_ticks += 1
        much = self.owed_deg > OWED_DEG + OWED_COUNTS * self.degree and self.strained_ticks > OWED_TICKS
        return much and self.still_ticks == 0  # without an edge, STALL_TICKS tell

    def duration_s(self, goal_deg: float) -> float:
        """Seconds of a trapezoid from here to a goal."""
        return trapezoid_s(abs(goal_deg - self.position_deg), self.parameters["cruise"], self.parameters["acc"])

    @property
    def busy(self) -> bool:
        """Whether it does anything but hold its place."""
        return self.mode > HOLD

    @property
    def corrects(self) -> bool:
        """Whether it is held, and has been moved off its place."""
        return self.mode == HOLD and abs(self.rule.goal_deg - self.position_deg) > self.tuning.arrived_deg

"""The controller of the arm in Python: what the firmware does in C, tick by tick.

A controller reads lines, drives two joints and writes lines. It sees its motors through a plant with
``counts(j)``, ``pressed(j)`` and ``set_duty(j, duty)``.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from stereo_lab.arm import protocol as wire
from stereo_lab.arm.virtual.interpreter import Interpreter
from stereo_lab.arm.virtual.joint import BACK, CREEP, HOLD, IDLE, MOVE, PUSH, REST, SECOND_JOINT, SEEK, Joint
from stereo_lab.arm.virtual.plant import Plant
from stereo_lab.motion import REST_TICKS, TICK_S, Profile, SlowDownRule

HOMING = (SEEK, BACK, CREEP, REST)
SEEK_DEG, SEEK_DEG_S, BACK_DEG, CREEP_DEG_S = 400.0, 60.0, 8.0, 10.0
BACK_TRIES = 6
COAST_TICKS = 250  # so long a joint may run on before it is held where it is
BRAKE_TICKS = 125  # a motor that is switched off is braked until both have rested for so long
BYTES_PER_TICK = wire.BAUD_RATE / 10 * TICK_S


class Controller:
    """Two joints behind a serial line. Joints are counted from 0 here.

    Attributes
    ----------
    joints : (Joint, Joint)
    line : Interpreter
    enabled, stopped : bool, whether the motors are on, and whether a stop holds them
    by_rule : bool, whether moves follow the paper's rule instead of a profile
    fault : str, as :class:`stereo_lab.arm.protocol.Status` has it
    """

    def __init__(self, plant: Plant) -> None:
        self.plant = plant
        self.restart()

    def restart(self) -> None:
        """As after power-up: motors off, positions unknown and called zero."""
        self.joints = (Joint(), Joint(**SECOND_JOINT))
        self.enabled, self.stopped, self.by_rule = False, False, False
        self.fault, self.time_ticks = "-", 0
        self.watchdog_ms, self.report_ms = 1000, 0
        self.heard_ticks = self.reported_ticks = self.dropped = 0
        self.line = Interpreter(self)
        for j, joint in enumerate(self.joints):
            joint.stand_at(self.plant.counts(j), 0.0)
            self._set_duty(j, 0)
        self.line.say(wire.GREETING)

    def _event(self, name, j):
        self.line.say(wire.encode_event(wire.Event(name, j + 1, self.joints[j].position_deg)))

    def status(self) -> wire.Status:
        """What ``?`` answers."""
        modes = [joint.mode for joint in self.joints]
        if self.stopped:
            state = "stop"
        elif not self.enabled:
            state = "off"
        elif any(mode in HOMING for mode in modes):
            state = "home"
        else:
            state = "run" if self.busy or any(joint.corrects for joint in self.joints) else "idle"
        first, second = self.joints
        return wire.Status(
            state, round(self.time_ticks * TICK_S * 1000), (first.homed, second.homed), self.fault,
            (first.position_deg, second.position_deg), (first.speed_deg_s, second.speed_deg_s), 0, self.dropped,
        )  # fmt: skip

    def enable(self, on: bool) -> None:
        """Switch the motors on or off; on also undoes a latched stop."""
        if on:
            for joint in self.joints:
                joint.idle_ticks = joint.idle_ticks if self.enabled and not self.stopped and self.fault == "-" else 0
            self.enabled, self.stopped, self.fault = True, False, "-"
        else:
            self.halt()
            self.enabled = self.stopped = False

    def move_to(self, goals: Sequence[float | None], pace: float) -> None:
        """Move joints to their goals (None: it stays as it is), at a share of their speed."""
        moving = [(joint, goal) for joint, goal in zip(self.joints, goals, strict=True) if goal is not None]
        for joint, goal in moving:
            if not joint.parameters["lo"] <= goal <= joint.parameters["hi"]:
                raise wire.ProtocolError(wire.LIMIT)
        self._must_be_on()
        if any(joint.busy and (self.by_rule or joint.mode != MOVE) for joint, _ in moving):
            raise wire.ProtocolError(wire.BUSY)
        times = [joint.duration_s(goal) for joint, goal in moving]
        for (joint, goal), time in zip(moving, times, strict=True):
            share = pace * (1.0 if time == 0 else time / max(times))  # the slower joint sets the pace
            cruise, acceleration = joint.parameters["cruise"] * share, joint.parameters["acc"]
            if joint.mode != MOVE:
                acceleration *= share**2  # a joint that moves already needs all of it, to brake in time
            if self.by_rule:
                joint.rule = SlowDownRule(
                    joint.tuning, joint.position_deg, goal, joint.parameters["zone"], joint.parameters["cruise"] * pace
                )
            else:
                joint.rule = joint.plan(goal, cruise, acceleration, joint.rule if joint.mode == MOVE else None)
            self._begin(joint, MOVE)

    def push(self, j: int, duty: int, milliseconds: float) -> None:
        """Give a motor some duty for some time."""
        joint = self.joints[j]
        self._must_be_on()
        self._must_be_idle(joint)
        joint.rule, joint.push_ticks = None, max(1, int(milliseconds / 1000 / TICK_S + 0.5))
        joint.push_v = duty * joint.parameters["supply"] / 255 - joint.held_v  # what is beyond its weight
        self._begin(joint, PUSH)
        self._set_duty(j, duty)

    def zero(self, j: int, angle_deg: float) -> None:
        """Call the place of a joint so many degrees."""
        self._must_be_idle(self.joints[j])
        self.joints[j].stand_at(self.plant.counts(j), angle_deg)
        self.joints[j].homed = True
        self._keep_holding()

    def _keep_holding(self):
        """The angles are other ones now, or what is known of the weight; what holds the joints goes on."""
        for joint in self.joints:
            joint.keep_holding(self._cosines())

    def home(self, j: int) -> None:
        """Find the home switch of a joint."""
        joint = self.joints[j]
        self._must_be_on()
        self._must_be_idle(joint)
        joint.tries, joint.homed = 0, False
        self._keep_holding()
        self._begin(joint, SEEK)
        joint.rule = joint.plan(joint.position_deg - SEEK_DEG, SEEK_DEG_S, 1000.0)
        if joint.pressed:
            self._back_off(joint)

    def set(self, j: int, name: str, value: float) -> None:
        """Set a parameter of a joint."""
        joint = self.joints[j]
        self.must_rest()
        joint.parameters[name] = value
        if name == "counts":
            joint.stand_at(self.plant.counts(j), joint.position_deg)
        joint.retune()
        self._keep_holding()

    def follow_rule(self, on: bool) -> None:
        """Move by the paper's rule from now on, or by a profile."""
        self.must_rest()
        self.by_rule = on
        self.halt(hold=True)

    def report_every(self, milliseconds: int) -> None:
        """Send a status by itself every so often, first after that time; 0: never."""
        self.report_ms, self.reported_ticks = milliseconds, self.time_ticks

    def must_rest(self) -> None:
        """Refuse what may not happen while anything moves."""
        if self.busy:
            raise wire.ProtocolError(wire.BUSY)

    def is_heard(self) -> None:
        """The host is there: the watchdog begins anew."""
        self.heard_ticks = self.time_ticks

    def _must_be_on(self):
        if self.stopped or not self.enabled:
            raise wire.ProtocolError(wire.OFF)

    def _must_be_idle(self, joint):
        if joint.busy:
            raise wire.ProtocolError(wire.BUSY)

    def _begin(self, joint, mode):
        joint.begin(mode)
        self.fault = "-"

    @property
    def busy(self) -> bool:
        """Whether either joint does anything."""
        return self.joints[0].busy or self.joints[1].busy

    def tick(self) -> None:
        """Everything that happens every TICK_S."""
        self.time_ticks += 1
        self.line.answer_questions()
        for j, joint in enumerate(self.joints):
            joint.look(self.plant.counts(j), self.plant.pressed(j))
        self._brake_or_let_go()
        cosines = self._cosines()
        for joint in self.joints:
            joint.weigh(cosines)
        for j, joint in enumerate(self.joints):
            self._control(j, joint)
        if self.watchdog_ms and self._ms_since(self.heard_ticks) > self.watchdog_ms and self.busy:
            self.halt(fault="w")
            self.enabled = False
            self.line.say("!watchdog")
        if self.report_ms and self._ms_since(self.reported_ticks) >= self.report_ms:
            self.reported_ticks = self.time_ticks
            self.line.report()

    def _ms_since(self, ticks):
        return (self.time_ticks - ticks) * TICK_S * 1000

    def _brake_or_let_go(self):
        """Switched off, a motor that turns is braked; when both have rested for a while, no current flows."""
        if not self.enabled:
            for j in (0, 1):
                self.plant.set_duty(j, None if self._rests else 0)

    @property
    def _rests(self):
        return all(joint.still_ticks >= BRAKE_TICKS for joint in self.joints)

    @property
    def _may_hold(self):
        """The motors are on, no stop is latched and nothing went wrong; in the paper's way nothing is held."""
        return self.enabled and not self.stopped and self.fault == "-" and not self.by_rule

    @property
    def settled(self) -> bool:
        """Whether nothing changes until a command comes or a motor is turned from outside."""
        if not self.enabled:
            return self._rests
        holds = all(joint.mode == HOLD and joint.rule.done for joint in self.joints)
        return holds or not self._may_hold

    def _cosines(self):
        """Of the angles of both links to the horizon; 0 as long as not both joints know where they stand."""
        first, second = self.joints
        if not (first.homed and second.homed):
            return 0.0, 0.0
        one, both = math.radians(first.position_deg), math.radians(first.position_deg + second.position_deg)
        return math.cos(one), math.cos(both)

    def _control(self, j, joint):
        joint.idle_ticks = joint.idle_ticks + 1 if joint.mode == IDLE else 0
        if joint.mode == IDLE:
            self._hold_if_it_rests(joint)
        if joint.mode == IDLE:
            return
        if joint.mode != HOLD and joint.runs_away:
            self.halt(latch=True, fault=f"r{j + 1}")
            self._event("runaway", j)
        elif joint.mode in (MOVE, HOLD):
            self._follow(j, joint)
        elif joint.mode == PUSH:
            self._keep_pushing(j, joint)
        else:
            self._keep_homing(j, joint)

    def _hold_if_it_rests(self, joint):
        """A joint is held where it comes to rest, or is after a while."""
        if self._may_hold and (joint.still_ticks >= REST_TICKS or joint.idle_ticks > COAST_TICKS):
            joint.hold()

    def _follow(self, j, joint):
        volts = joint.follow()
        if joint.mode == MOVE and joint.rule.done:
            self._finish(j, "done")
        elif joint.stalls(volts):
            self._stall(j)
        else:
            self._set_volts(j, volts)

    def _stall(self, j):
        self.halt(fault=f"s{j + 1}")
        self._event("stall", j)

    def _keep_pushing(self, j, joint):
        low, high = joint.parameters["lo"], joint.parameters["hi"]
        beyond = (joint.push_v > 0 and joint.position_deg > high) or (joint.push_v < 0 and joint.position_deg < low)
        joint.push_ticks -= 1
        if beyond:
            self._finish(j, "limit")
        elif joint.held:
            self._stall(j)
        elif joint.push_ticks == 0:
            self._set_volts(j, joint.held_v)
            joint.still_ticks = 0
        elif joint.push_ticks < 0 and joint.still_ticks >= REST_TICKS:
            self._finish(j, "done")
        elif joint.push_ticks < -COAST_TICKS:  # a load carries it on
            self._finish(j, "done")
            joint.idle_ticks = COAST_TICKS

    def _keep_homing(self, j, joint):
        pressed = joint.pressed
        if joint.mode == REST:
            if joint.still_ticks >= REST_TICKS:
                joint.homed = True
                self._finish(j, "home")
                self._keep_holding()
            return
        if joint.mode == SEEK and pressed:
            self._back_off(joint)
        elif joint.mode == CREEP and pressed:
            self._set_volts(j, joint.held_v)
            joint.stand_at(joint.closed_count, joint.parameters["home"], self.plant.counts(j))
            joint.mode, joint.still_ticks = REST, 0
            return
        volts = joint.follow()
        if joint.rule.done:
            self._homing_step(j, joint, pressed)
        elif joint.stalls(volts):
            self._stall(j)
        else:
            self._set_volts(j, volts)

    def _homing_step(self, j, joint, pressed):
        """A leg of the homing has ended without meeting the switch."""
        if joint.mode == BACK and not pressed:
            joint.mode = CREEP
            joint.rule = joint.plan(joint.position_deg - 2 * BACK_DEG - joint.tries * BACK_DEG, CREEP_DEG_S, 1000.0)
        elif joint.mode == BACK and joint.tries < BACK_TRIES:
            self._back_off(joint)
        else:
            self._stall(j)

    def _back_off(self, joint):
        joint.tries += 1
        running = joint.rule if joint.mode == SEEK else None
        joint.mode, joint.rule = BACK, joint.plan(joint.position_deg + BACK_DEG, SEEK_DEG_S, 1000.0, running)

    def _finish(self, j, event):
        """It has ended, and rests: held where it is, or in the paper's way braked."""
        joint = self.joints[j]
        joint.mode = HOLD if isinstance(joint.rule, Profile) and joint.mode == MOVE else IDLE
        self._set_volts(j, 0.0 if self.by_rule else joint.held_v)
        self._event(event, j)

    def halt(self, latch: bool = False, fault: str | None = None, hold: bool = False) -> None:
        """Stop both joints: braked; or held against their weight, where the motors are on."""
        holds = hold and self._may_hold
        for j, joint in enumerate(self.joints):
            joint.mode = IDLE
            self._set_volts(j, joint.held_v if holds else 0.0)
        self.stopped = self.stopped or latch
        if fault:
            self.fault = fault

    def _set_volts(self, j, volts):
        duty = round(volts * 255 / self.joints[j].parameters["supply"])
        self._set_duty(j, 255 if duty > 255 else -255 if duty < -255 else duty)

    def _set_duty(self, j, duty):
        self.joints[j].duty = duty
        self.plant.set_duty(j, duty)

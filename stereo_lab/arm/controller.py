"""The controller of the arm in Python: what the firmware does in C, tick by tick.

A controller reads lines, drives two joints and writes lines. It sees its motors through a plant with
``counts(j)``, ``pressed(j)`` and ``set_duty(j, duty)``.
"""

from __future__ import annotations

from stereo_lab.arm import protocol as wire
from stereo_lab.arm.joint import BACK, CREEP, IDLE, MOVE, PUSH, REST, SECOND_JOINT, SEEK, Joint
from stereo_lab.motion import REST_TICKS, TICK_S, SlowDownRule

HOMING = (SEEK, BACK, CREEP, REST)
SEEK_DEG, SEEK_DEG_S, BACK_DEG, CREEP_DEG_S = 400.0, 60.0, 8.0, 10.0
BACK_TRIES = 6
TX_BYTES, STATUS_BYTES = 128, 100  # what the controller can keep for sending; a status needs less than that
BYTES_PER_TICK = wire.BAUD_RATE / 10 * TICK_S


class Controller:
    """Two joints behind a serial line."""

    def __init__(self, plant):
        self.plant = plant
        self.restart()

    def restart(self):
        """As after power-up: motors off, positions unknown and called zero."""
        self.joints = (Joint(), Joint(**SECOND_JOINT))
        self.enabled, self.stopped, self.by_rule = False, False, False
        self.fault, self.time_ticks = "-", 0
        self.checksum, self.watchdog_ms, self.report_ms = False, 1000, 0
        self.heard_ticks = self.reported_ticks = self.dropped = 0
        self._line, self._too_long, self._last = bytearray(), False, (None, "")
        self._asked = False
        self.tx = bytearray()
        for j, joint in enumerate(self.joints):
            joint.stand_at(self.plant.counts(j), 0.0)
            self._set_duty(j, 0)
        self._say(wire.GREETING)

    # --- the line ---------------------------------------------------------------------------------------

    def feed(self, data):
        """Bytes from the host."""
        for byte in data:
            if byte in b"!?" and not self._line and not self._too_long:
                self._real_time(byte)
            elif byte in b"\r\n":
                self._end_of_line()
            elif len(self._line) < wire.LINE_MAX:
                self._line.append(byte)
            else:
                self._too_long = True

    def _real_time(self, byte):
        if byte == ord("!"):
            self._halt(latch=True, fault="e")
            self._say("!estop")
        else:
            self.heard_ticks = self.time_ticks
            self._asked = True
            self._answer_when_there_is_room()

    def _answer_when_there_is_room(self):
        """One status for all questions that came meanwhile."""
        if self._asked and len(self.tx) < TX_BYTES - STATUS_BYTES:
            self._asked = False
            self._say(wire.encode_status(self.status()))

    def _end_of_line(self):
        line, too_long = self._line.decode("latin-1"), self._too_long
        self._line, self._too_long = bytearray(), False
        try:
            if too_long:
                raise wire.ProtocolError(wire.TOO_LONG)
            command = wire.decode_command(line, self.checksum)
        except wire.ProtocolError as error:
            self._answer(wire.Reply(error.code, "", error.number))
            return
        if command is None:
            return
        self.heard_ticks = self.time_ticks
        if command.number is not None and command.number == self._last[0]:
            self._say(self._last[1])
            return
        try:
            reply = wire.Reply(0, self._execute(command) or "", command.number)
        except wire.ProtocolError as error:
            reply = wire.Reply(error.code, "", command.number)
        self._last = (command.number, wire.encode_reply(reply))
        self._answer(reply)

    def _answer(self, reply):
        self._say(wire.encode_reply(reply))

    def _say(self, text):
        self.tx += (wire.seal(text) if self.checksum else text).encode("ascii") + b"\r\n"

    def _event(self, name, j):
        self._say(wire.encode_event(wire.Event(name, j + 1, self.joints[j].position_deg)))

    def status(self):
        """What ``?`` answers."""
        modes = [joint.mode for joint in self.joints]
        if self.stopped:
            state = "stop"
        elif not self.enabled:
            state = "off"
        elif any(mode in HOMING for mode in modes):
            state = "home"
        else:
            state = "run" if any(modes) else "idle"
        return wire.Status(
            state, round(self.time_ticks * TICK_S * 1000), tuple(j.homed for j in self.joints), self.fault,
            tuple(j.position_deg for j in self.joints), tuple(j.speed_deg_s for j in self.joints), 0, self.dropped,
        )  # fmt: skip

    # --- commands ---------------------------------------------------------------------------------------

    def _execute(self, command):
        takes = COMMANDS.get(command.name)
        if takes is None:
            raise wire.ProtocolError(wire.COMMAND)
        run, least, most = takes
        if not least <= len(command.arguments) <= most:
            raise wire.ProtocolError(wire.ARGUMENT)
        return run(self, *command.arguments)

    def _id(self):
        return wire.IDENTITY

    def _enable(self, word):
        if _flag(word):
            self.enabled, self.stopped, self.fault = True, False, "-"
        else:
            self._halt()
            self.enabled = self.stopped = False

    def _stop(self):
        self._halt()

    def _move(self, joint, goal, percent="100"):
        j = _joint(joint)
        goals = [None, None]
        goals[j] = wire.read_number(goal, -1e6, 1e6)
        self._move_to(goals, wire.read_number(percent, 1, 100) / 100)

    def _move_both(self, first, second, percent="100"):
        goals = [wire.read_number(goal, -1e6, 1e6) for goal in (first, second)]
        self._move_to(goals, wire.read_number(percent, 1, 100) / 100)

    def _move_to(self, goals, pace):
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

    def _push(self, joint, duty, milliseconds):
        j = _joint(joint)
        duty = wire.read_number(duty, -255, 255)
        milliseconds = wire.read_number(milliseconds, 1, 2000)
        self._must_be_on()
        if self.joints[j].busy:
            raise wire.ProtocolError(wire.BUSY)
        self.joints[j].rule = None
        self.joints[j].push_ticks = max(1, int(milliseconds / 1000 / TICK_S + 0.5))
        self._begin(self.joints[j], PUSH)
        self._set_duty(j, int(duty))

    def _zero(self, joint, angle="0"):
        j = _joint(joint)
        angle = wire.read_number(angle, -360, 360)
        if self.joints[j].busy:
            raise wire.ProtocolError(wire.BUSY)
        self.joints[j].stand_at(self.plant.counts(j), angle)
        self.joints[j].homed = True

    def _home(self, joint):
        j = _joint(joint)
        self._must_be_on()
        joint = self.joints[j]
        if joint.busy:
            raise wire.ProtocolError(wire.BUSY)
        joint.tries, joint.homed = 0, False
        self._begin(joint, SEEK)
        joint.rule = joint.plan(joint.position_deg - SEEK_DEG, SEEK_DEG_S, 1000.0)
        if joint.pressed:
            self._back_off(joint)

    def _begin(self, joint, mode):
        joint.mode, joint.still_ticks = mode, 0
        joint.against_deg = joint.wrong_deg = 0.0
        self.fault = "-"

    def _set(self, joint, name, value):
        joint = self.joints[_joint(joint)]
        if name not in wire.PARAMETERS:
            raise wire.ProtocolError(wire.ARGUMENT)
        value = wire.read_number(value, *wire.PARAMETERS[name])
        if any(j.busy for j in self.joints):
            raise wire.ProtocolError(wire.BUSY)
        joint.parameters[name] = value
        if name == "counts":
            joint.stand_at(self.plant.counts(self.joints.index(joint)), joint.position_deg)
        joint.retune()

    def _get(self, joint, name):
        joint = self.joints[_joint(joint)]
        if name not in wire.PARAMETERS:
            raise wire.ProtocolError(wire.ARGUMENT)
        return f"{joint.parameters[name] + 0.0:.3f}"  # no -0.000

    def _mode(self, word):
        if word not in ("pid", "rule"):
            raise wire.ProtocolError(wire.ARGUMENT)
        if any(j.busy for j in self.joints):
            raise wire.ProtocolError(wire.BUSY)
        self.by_rule = word == "rule"

    def _report(self, milliseconds):
        value = wire.read_number(milliseconds, 0, 60000)
        if 0 < value < 20:
            raise wire.ProtocolError(wire.LIMIT)
        self.report_ms = int(value)

    def _watchdog(self, milliseconds):
        value = wire.read_number(milliseconds, 0, 60000)
        if 0 < value < 100:
            raise wire.ProtocolError(wire.LIMIT)
        self.watchdog_ms = int(value)

    def _checksums(self, word):
        self.checksum = _flag(word)

    def _must_be_on(self):
        if self.stopped or not self.enabled:
            raise wire.ProtocolError(wire.OFF)

    # --- the control loop -------------------------------------------------------------------------------

    @property
    def busy(self):
        return self.joints[0].mode != IDLE or self.joints[1].mode != IDLE

    def tick(self):
        """Everything that happens every TICK_S."""
        self.time_ticks += 1
        self._answer_when_there_is_room()
        for j, joint in enumerate(self.joints):
            joint.look(self.plant.counts(j), self.plant.pressed(j))
            if joint.mode != IDLE:
                self._control(j, joint)
        if self.watchdog_ms and self._ms_since(self.heard_ticks) > self.watchdog_ms and self.busy:
            self._halt(fault="w")
            self.enabled = False
            self._say("!watchdog")
        if self.report_ms and self._ms_since(self.reported_ticks) >= self.report_ms:
            self._periodic_report()

    def _periodic_report(self):
        self.reported_ticks = self.time_ticks
        if len(self.tx) > TX_BYTES - STATUS_BYTES:
            self.dropped += 1
        else:
            self._say(wire.encode_status(self.status()))

    def _ms_since(self, ticks):
        return (self.time_ticks - ticks) * TICK_S * 1000

    def _control(self, j, joint):
        if joint.runs_away:
            self._halt(latch=True, fault=f"r{j + 1}")
            self._event("runaway", j)
        elif joint.mode == MOVE:
            self._follow(j, joint)
        elif joint.mode == PUSH:
            self._keep_pushing(j, joint)
        else:
            self._keep_homing(j, joint)

    def _follow(self, j, joint):
        volts = joint.rule.volts(joint.position_deg)
        if joint.rule.done:
            self._finish(j, "done")
        elif joint.stalls(volts):
            self._stall(j)
        else:
            self._set_volts(j, volts)

    def _stall(self, j):
        self._halt(fault=f"s{j + 1}")
        self._event("stall", j)

    def _keep_pushing(self, j, joint):
        low, high = joint.parameters["lo"], joint.parameters["hi"]
        beyond = (joint.duty > 0 and joint.position_deg > high) or (joint.duty < 0 and joint.position_deg < low)
        joint.push_ticks -= 1
        if beyond:
            self._finish(j, "limit")
        elif joint.held:
            self._stall(j)
        elif joint.push_ticks == 0:
            self._set_duty(j, 0)
        elif joint.push_ticks < 0 and joint.still_ticks >= REST_TICKS:
            self._finish(j, "done")

    def _keep_homing(self, j, joint):
        pressed = joint.pressed
        if joint.mode == REST:
            if joint.still_ticks >= REST_TICKS:
                joint.homed = True
                self._finish(j, "home")
            return
        if joint.mode == SEEK and pressed:
            self._back_off(joint)
        elif joint.mode == CREEP and pressed:
            self._set_duty(j, 0)
            joint.stand_at(joint.closed_count, joint.parameters["home"], self.plant.counts(j))
            joint.mode, joint.still_ticks = REST, 0
            return
        volts = joint.rule.volts(joint.position_deg)
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
        self.joints[j].mode = IDLE
        self._set_duty(j, 0)
        self._event(event, j)

    def _halt(self, latch=False, fault=None):
        for j, joint in enumerate(self.joints):
            joint.mode = IDLE
            self._set_duty(j, 0)
        self.stopped = self.stopped or latch
        if fault:
            self.fault = fault

    def _set_volts(self, j, volts):
        duty = round(volts * 255 / self.joints[j].parameters["supply"])
        self._set_duty(j, 255 if duty > 255 else -255 if duty < -255 else duty)

    def _set_duty(self, j, duty):
        self.joints[j].duty = duty
        self.plant.set_duty(j, duty)


COMMANDS = {
    "ID": (Controller._id, 0, 0), "EN": (Controller._enable, 1, 1), "ST": (Controller._stop, 0, 0),
    "MV": (Controller._move, 2, 3), "MA": (Controller._move_both, 2, 3), "PW": (Controller._push, 3, 3),
    "ZE": (Controller._zero, 1, 2), "HM": (Controller._home, 1, 1), "SET": (Controller._set, 3, 3),
    "GET": (Controller._get, 2, 2), "MODE": (Controller._mode, 1, 1), "RP": (Controller._report, 1, 1),
    "WD": (Controller._watchdog, 1, 1), "CS": (Controller._checksums, 1, 1),
}  # fmt: skip


def _joint(word):
    if word not in ("1", "2"):
        raise wire.ProtocolError(wire.ARGUMENT)
    return int(word) - 1


def _flag(word):
    if word not in ("0", "1"):
        raise wire.ProtocolError(wire.ARGUMENT)
    return word == "1"

"""A controller of the arm's serial protocol, written from PROTOCOL.md alone. It imports nothing of the kit.

Run it with a very simple arm behind a TCP port, and connect a host with ``socket://localhost:7777``::

    python controller_from_the_page.py [--port 7777]

Ctrl-C ends it. One host at a time is served; a host that leaves is the same as silence on the line.

In a program of your own make a ``Controller``, hand it bytes with ``receive``, call ``tick`` every 2 ms and fetch what
it says with ``sent``. The kit's tests run it beside the virtual arm and the firmware. The first one, written from an
earlier state of the page, failed three of their cases: when a joint counts as busy after ``ST``, and twice how a runaway
is told. Later, both were shown the same encoder counts tick by tick: when the six ticks of a homing begin, how it backs
off again, and what holds a joint after a push, were told too loosely. The page says all of it now.
"""

import argparse
import binascii
import math
import re
import socket
import time
from contextlib import suppress

T = 0.002  # seconds of a tick
BYTES_PER_TICK = 23  # what 115200 baud carry in a tick
LONGEST_LINE = 63
MOST_LOAD = 2.0  # volts

ERRORS = {1: "checksum", 2: "command", 3: "argument", 4: "limit", 5: "off", 6: "too long", 8: "busy"}

# name: from, to, after reset of joint 1, of joint 2
PARAMETERS = {
    "lo": (-360, 360, -165, -155),
    "hi": (-360, 360, 165, 155),
    "home": (-360, 360, -170, -160),
    "cruise": (1, 720, 180, 180),
    "acc": (10, 4000, 500, 500),
    "k": (10, 2000, 75, 75),
    "tau": (5, 1000, 60, 60),
    "db+": (0, 24, 0.4, 0.4),
    "db-": (0, 24, 0.55, 0.55),
    "st+": (0, 24, 0.46, 0.46),
    "st-": (0, 24, 0.65, 0.65),
    "zone": (0, 180, 5, 5),
    "counts": (16, 65535, 4094.4, 4094.4),
    "supply": (1, 24, 6, 6),
    "g1": (-24, 24, 0, 0),
    "g2": (-24, 24, 0, 0),
}

# command: fewest arguments, most arguments; Controller has a method _do_... for each
COMMANDS = {
    **{"ID": (0, 0), "EN": (1, 1), "ST": (0, 0), "MV": (2, 3), "MA": (2, 3), "PW": (3, 3), "ZE": (1, 2), "HM": (1, 1)},
    **{"SET": (3, 3), "GET": (2, 2), "MODE": (1, 1), "RP": (1, 1), "WD": (1, 1), "CS": (1, 1)},
}


class _Refused(Exception):
    """A line is not done; it is made with the number of the page's table of errors."""

    def __str__(self):
        return f"{self.args[0]} {ERRORS[self.args[0]]}"


def _checksum(data):
    return b"%04X" % binascii.crc_hqx(data, 0xFFFF)  # CRC-16/CCITT-FALSE


def _sign(value):
    return (value > 0) - (value < 0)


def _within(value, bound):
    return max(-bound, min(bound, value))


def _text(value, digits):
    text = f"{value:.{digits}f}"
    return text.lstrip("-") if float(text) == 0 else text  # zero has no minus


def _read_number(word, lowest=-math.inf, highest=math.inf, or_zero=False):
    if not re.fullmatch(r"-?[0-9]{1,7}(\.[0-9]{1,6})?", word):
        raise _Refused(3)
    value = float(word)
    if not lowest <= value <= highest and not (or_zero and value == 0):
        raise _Refused(4)
    return value


def _read_choice(word, choices):
    if word not in choices:
        raise _Refused(3)
    return word


class _Joint:
    """One joint: its parameters, its encoder and switch, what it is doing, and the voltage that this takes.

    The page's p, s, g keep their letters; V is ``volts``, V0 ``first_volts``, L ``load``, K ``kick``, v ``speed``, and
    the part with the cosines ``gravity``. Not busy are the kinds ``idle`` (braked), ``roll`` (to rest after ``ST`` or
    ``!limit``) and ``held``; busy are ``move``, ``rule``, ``push``, ``pushed`` (its time is over) and ``home``.
    """

    def __init__(self, index, count):
        self.par = {name: row[2 + index] for name, row in PARAMETERS.items()}
        self.kind = "idle"
        self.count = self.zero = count  # zero is the count, with a fraction, at which the angle is 0
        self.still = self.rest = 6  # ticks without an edge; those that count for "at rest", as after reset
        self.last_edge = 0.0  # which way it went
        self.closed = self.closed_count = 0  # ticks since the switch closed, and where that was
        self.speed = self.volts = self.gravity = self.load = self.kick = 0.0
        self.p = self.s = self.g = self.cruise = self.acc = 0.0  # the plan
        self.first_volts = self.right_turn = self.wrong_turn = 0.0
        self.began_at_rest, self.stall_ticks, self.roll_ticks = False, 0, 0
        self.push_volts, self.push_held, self.push_ticks = 0.0, 0.0, 0
        self.rule_way, self.rule_volts = 0, 0.0
        self.mark, self.owed, self.owed_ticks = 0.0, 0.0, 0
        self.leg, self.backs = "", 0

    def sense(self, count, pressed):
        turned = (count - self.count) * self.edge()
        self._add_up(turned)
        self.speed += 0.1 * (turned / T - self.speed)
        self.still, self.rest = (0, 0) if turned else (self.still + 1, self.rest + 1)
        self.last_edge = turned or self.last_edge
        self.count = count
        if pressed and not self.closed:
            self.closed_count = count
        self.closed = self.closed + 1 if pressed else 0

    def edge(self):
        return 360 / self.par["counts"]

    def angle(self):  # the page's theta
        return (self.count - self.zero) * self.edge()

    def busy(self):
        return self.kind in ("move", "rule", "push", "pushed", "home")

    def beside(self):
        return abs(self.p - self.angle()) > 0.6 * self.edge()

    def _of_way(self, name, way):
        return self.par[name + ("+" if way > 0 else "-")]

    # ---- what commands do to it

    def stand_at(self, degrees):
        """Call the place where the joint stands by this angle."""
        shift = degrees - self.angle()
        self.zero = self.count - degrees / self.edge()
        self.p += shift  # the place where it is held gets a new name, too
        self.g += shift

    def set_parameter(self, name, value):
        """Change a parameter; the angle at which the joint stands stays."""
        angle = self.angle()
        self.par[name] = value
        self.zero = self.count - angle / self.edge()

    def add_load(self, volts):
        """Add to L, the load that nobody told of, within its bounds."""
        self.load = _within(self.load + volts, MOST_LOAD)

    @property
    def held(self):
        return self.gravity + self.load

    def hold_anew(self, gravity_before):
        """Hold with as much as before, where the joint stands now."""
        self.load = _within(gravity_before + self.load - self.gravity, MOST_LOAD)
        if self.kind == "held":
            self._begin_plan()

    def duration(self, goal):
        way, cruise, acc = abs(goal - self.angle()), self.par["cruise"], self.par["acc"]
        return 2 * math.sqrt(way / acc) if way < cruise**2 / acc else way / cruise + cruise / acc

    def move(self, goal, f):
        """Begin a move by plan, or give the running plan a new goal."""
        self.acc = self.par["acc"]
        if self.kind != "move":
            self._begin("move")
            self._begin_plan()
            self.acc *= f**2
        self.cruise = self.par["cruise"] * f
        self.g = goal

    def move_by_rule(self, goal, f):
        self._begin("rule")
        self._begin_plan()  # p is where it began
        self.g, self.rule_way = goal, 1 if goal >= self.angle() else -1
        self.mark, self.owed, self.owed_ticks = self.angle(), 0.0, 0
        self.rule_volts = self._of_way("db", self.rule_way) + f * self.par["cruise"] / self.par["k"]

    def push(self, duty, milliseconds):
        self._begin("push")
        self.volts = self.push_volts = duty * self.par["supply"] / 255  # at once
        self.push_held = self.held
        self.push_ticks = math.floor(milliseconds / 2 + 0.5)  # halves go up, and so 1 ms is a tick

    def find_home(self):
        self._begin("home")
        self._begin_plan()
        self.acc, self.backs = 1000, 0
        if self.closed >= 3:
            self._begin_leg("back", 8, 60)
        else:
            self._begin_leg("fast", -400, 60)

    def end(self, mode):
        """End what the joint does, as ``ST`` asks: it rolls on to rest and is held there."""
        if self.kind != "idle":
            self.kind, self.roll_ticks = "roll", 0
            self.volts = self.held if mode == "pid" else 0.0

    def stop(self):
        self.kind, self.volts = "idle", 0.0

    def _begin(self, kind):
        self.kind, self.stall_ticks, self.began_at_rest = kind, 0, self.still >= 6
        self.first_volts, self.right_turn, self.wrong_turn = self.volts, 0.0, 0.0

    def _begin_plan(self):
        self.p = self.g = self.angle()
        self.s, self.kick, self.rest = 0.0, 0.0, 0

    # ---- every tick

    def step(self, mode):
        """Work out the voltage until the next tick; return the word of an event, or None."""
        bound = max(0.6, 2.5 * self.edge())
        if self.busy() and self.began_at_rest and self.wrong_turn > bound >= self.right_turn:
            return "runaway"
        event = getattr(self, "_step_" + self.kind)(mode)
        self.volts = _within(self.volts, self.par["supply"])
        return "stall" if self._stalled() else event

    def _end(self, event, mode):
        self.kind = "roll" if mode == "pid" else "idle"  # not busy any more, and held from the next tick on
        return event

    def _step_idle(self, mode):
        self.roll_ticks += 1
        late = self.roll_ticks * T > 0.5  # else a load could carry the joint on for ever
        if not late and self.rest < 6:
            return None
        if self.kind == "pushed":
            return self._end("done", mode)
        if mode == "pid":
            self._begin_plan()
            self.kind = "held"
            self.volts = self.held
        return None

    _step_roll = _step_pushed = _step_idle

    def _step_held(self, _mode):
        if not self._set_volts(self._advance()) or self.kind == "held":
            return None
        self.kind = "held"  # by the same plan, at its goal
        return "done"

    _step_move = _step_held

    def _step_rule(self, mode):
        left = (self.g - self.angle()) * self.rule_way
        st = self._of_way("st", self.rule_way)
        turned_volts, self.volts = self.volts, 0.0
        room = self.par["hi"] - self.angle() if self.rule_way > 0 else self.angle() - self.par["lo"]
        if left > 0 and room < 3 * self.par["tau"] / 1000 * self.speed * self.rule_way:
            pass  # braked, or it would roll beyond its limit
        elif left > 0:
            self.volts = self.rule_way * (st if left <= self.par["zone"] else max(self.rule_volts, st))
        if left <= 0 and self.rest >= 6:
            return self._end("done", mode)
        return "stall" if self._to_and_fro(turned_volts) else None

    def _to_and_fro(self, volts):
        """Whether its edges lead nowhere, while by its voltage it should be elsewhere."""
        if abs(self.angle() - self.mark) > 1.5 * self.edge():
            self.mark, self.owed, self.owed_ticks = self.angle(), 0.0, 0
        free = (volts - self.gravity) * self.rule_way - self._of_way("db", self.rule_way)
        self.owed = max(0.0, self.owed + self.par["k"] * T * free)
        self.owed_ticks += 1
        return self.owed > 5 + 8 * self.edge() and self.owed_ticks > 20 and self.still == 0

    def _step_push(self, mode):
        above = self.push_volts > self.push_held and self.angle() > self.par["hi"]
        below = self.push_volts < self.push_held and self.angle() < self.par["lo"]
        self.push_ticks -= 1
        if self.push_ticks and not above and not below:
            return None
        event = "limit" if above or below else None
        self.kind = "roll" if event else "pushed"
        self.rest = self.roll_ticks = 0  # the six ticks count from the end of its time
        self.volts = 0.0
        if mode == "pid":
            self.volts = self.held
        return event

    def _begin_leg(self, leg, way, speed):
        self.leg, self.g, self.cruise = leg, self.angle() + way, speed
        self.backs += leg == "back"

    def _step_home(self, mode):
        closed = self.closed >= 3
        if closed and self.leg == "fast":
            self._begin_leg("back", 8, 60)
        elif closed and self.leg == "slow":
            self.leg, self.zero = "found", self.closed_count - self.par["home"] / self.edge()
            self.p, self.s, self.g = self.par["home"], 0.0, self.par["home"]  # so that rolling far is a stall
            self.volts = self.held
            self.rest = 0  # the six ticks count from here
        if self.leg == "found":
            return self._end("home", mode) if self.rest >= 6 else None
        if not self._set_volts(self._advance()):
            return None
        if self.leg != "back" or (closed and self.backs == 6):
            return "stall"
        self._begin_plan()
        if closed:
            self._begin_leg("back", 8, 60)
        else:
            self._begin_leg("slow", -(16 + 8 * self.backs), 10)
        return None

    # ---- the plan and the voltage, as the page gives them

    def _advance(self):
        """Let the plan go on for a tick; return a, the change of its speed divided by T."""
        if self.s != 0 and (self.p - self.angle()) * _sign(self.s) >= 10:
            return 0.0  # the plan waits for the joint
        before = self.s
        left = self.g - self.p
        way = 1 if left >= 0 else -1
        c = self.acc * T
        fastest = min(math.sqrt(c**2 / 4 + 2 * self.acc * abs(left)) - c / 2, self.cruise)
        self.s = way * max(self.s * way - c, min(self.s * way + c, fastest))
        if abs(left) <= abs(self.s) * T and abs(self.s) <= 2 * c:
            self.p, self.s = self.g, 0.0
        else:
            self.p += self.s * T
        if self.s * (self.g - self.p) >= 0 and (self.g - self.angle()) * (self.g - self.p) <= 0:
            self.p, self.s = self.g, 0.0
        return (self.s - before) / T

    def _set_volts(self, a):
        """Set the voltage by the plan; return whether the joint is done."""
        k, tau = self.par["k"], self.par["tau"] / 1000
        kp = 2 / (k * tau)
        ki = kp / (4 * tau)
        e = self.p - self.angle()
        ended = self.p == self.g and self.s == 0
        if ended and not self.beside():
            self.kick = 0.0
            self.volts = self.held
            return self.rest >= 6
        if self.rest >= 6 and (ended or e * self.s > 0):
            self.kick += 0.02
            self.volts = self.held
            self.volts += _sign(e) * max(self._of_way("st", e) + self.kick, kp * abs(e))
            return False
        self.add_load(ki * e * T + _sign(e) * self.kick / 2)
        self.kick = 0.0
        self.volts = self.held
        self.volts += kp * e
        if ended and e * self.last_edge > 0:
            self.volts += _sign(e) * self._of_way("db", e)
        if not ended:
            self.volts += (self.par["db+"] if self.s > 0 else -self.par["db-"]) + (self.s + tau * a) / k
        return False

    # ---- what can go wrong

    def _add_up(self, turned):
        """Add to the two sums of the runaway; ``volts`` is still what the joint had while it turned."""
        more = self.volts - self.first_volts
        toward_goal = self.kind in ("move", "home") and turned * (self.g - self.angle()) > 0
        if turned * more > 0 or toward_goal:
            self.right_turn += abs(turned)
        elif abs(more) > 2 * self._of_way("db", more):
            self.wrong_turn += abs(turned)

    def _stalled(self):
        most = max(self.par["st+"], self.par["st-"]) + 1.5
        condition, ticks = False, 0
        if self.kind in ("move", "home", "held"):
            u = self.volts - self.gravity
            strong = abs(u) > most or (abs(self.load) == MOST_LOAD and self.beside())
            condition, ticks = strong and self.speed * _sign(u) <= 10, 50
        elif self.kind == "rule":
            condition, ticks = self.volts != 0 and self.still > 0, 250
        elif self.kind == "push":
            condition, ticks = abs(self.volts - self.push_held) > most and self.still > 0, 125
        self.stall_ticks = self.stall_ticks + 1 if condition else 0
        far = self.kind in ("move", "home", "held") and abs(self.p - self.angle()) > 20
        backwards = self.kind == "rule" and (self.p - self.angle()) * self.rule_way > 20
        return far or backwards or self.stall_ticks > ticks


class Controller:
    """The controller: lines in, lines out, and 500 times a second the two motors.

    Parameters
    ----------
    plant : object
        Has ``counts(j)``, ``pressed(j)`` and ``set_duty(j, duty)`` for j = 0 and 1.
    """

    def __init__(self, plant):
        self.plant = plant
        self.joints = [_Joint(j, plant.counts(j)) for j in range(2)]
        self.on, self.latched, self.fault, self.mode = False, False, "-", "pid"
        self.known = self.lost = self.drop = 0  # h, lost and drop of the status
        self.now_ms = self.heard_ms = self.report_ms = self.report_due = 0
        self.watchdog_ms = 1000
        self.checksums = self.asked = False
        self.last_number, self.last_answer = None, ""
        self.wire, self.line = bytearray(), bytearray()  # what has still to come, and what has come of a line
        self.out, self.pending = bytearray(), 0  # what the caller has not fetched, and how much of all still waits
        self._say("armkit 1 ready")

    def receive(self, data):
        """Take bytes from the host, in any pieces; a tick reads 23 of them.

        Parameters
        ----------
        data : bytes
            What came.
        """
        self.wire += data

    def sent(self):
        """Hand over what is to be sent to the host, and forget it.

        Returns
        -------
        bytes
            Lines and pieces of lines; the caller lets 23 bytes go in a tick.
        """
        data = bytes(self.out)
        self.out.clear()
        return data

    def tick(self):
        """Do the work of 2 ms: the motors first, then what came down the line."""
        self.now_ms += 2
        self.pending = max(0, self.pending - BYTES_PER_TICK)
        for j, joint in enumerate(self.joints):
            joint.sense(self.plant.counts(j), self.plant.pressed(j))
        self._watch()
        self._weigh()
        self._control()
        self._set_duties()
        self._report()
        self._read_bytes()

    # ---- the motors

    def _busy(self):
        return any(joint.busy() for joint in self.joints)

    def _watch(self):
        if self.watchdog_ms and self.now_ms - self.heard_ms > self.watchdog_ms and self._busy():
            self.on = False
            self._stop_both("w")
            self._say("!watchdog")

    def _weigh(self):
        first, second = (math.radians(joint.angle()) for joint in self.joints)
        for joint in self.joints:
            weight = joint.par["g1"] * math.cos(first) + joint.par["g2"] * math.cos(first + second)
            joint.gravity = weight if self.known == 3 else 0.0

    def _control(self):
        for j, joint in enumerate(self.joints):
            if not self.on or self.latched or self.fault != "-":
                joint.stop()
                continue
            event = joint.step(self.mode)
            if event == "home":
                self.known |= 1 << j
                self._keep_holding()
            elif event in ("stall", "runaway"):
                self.latched = event == "runaway"
                self._stop_both(f"{event[0]}{j + 1}")
            if event:
                self._say(f"!{event} {j + 1} {_text(joint.angle(), 2)}")

    def _keep_holding(self):
        """Where the part with the cosines changes, L takes up the difference: held stays what it was."""
        before = [joint.gravity for joint in self.joints]
        self._weigh()
        for joint, gravity in zip(self.joints, before, strict=True):
            joint.hold_anew(gravity)

    def _stop_both(self, fault):
        self.fault = fault
        for joint in self.joints:
            joint.stop()

    def _set_duties(self):
        let_go = not self.on and all(joint.still * T >= 0.25 for joint in self.joints)
        for j, joint in enumerate(self.joints):
            duty = _within(round(255 * joint.volts / joint.par["supply"]), 255)
            self.plant.set_duty(j, None if let_go else duty)

    # ---- the line

    def _say(self, text):
        line = text.encode()
        if self.checksums:
            line += b"*" + _checksum(line)
        self.out += line + b"\r\n"
        self.pending += len(line) + 2

    def _read_bytes(self):
        data = bytes(self.wire[:BYTES_PER_TICK])
        del self.wire[:BYTES_PER_TICK]
        for byte in data:
            if byte in b"\r\n":
                line = bytes(self.line)
                self.line.clear()
                self._read_line(line)
            elif byte in b"!?" and not self.line:
                self._act_at_once(byte)
            elif len(self.line) <= LONGEST_LINE:  # one byte more than may be shows that it is too long
                self.line.append(byte)

    def _act_at_once(self, byte):
        if byte in b"!":
            self.latched = True
            self._stop_both("e")
            self._set_duties()
            self._say("!estop")
        else:
            self.heard_ms = self.now_ms
            self.asked = True
            self._answer_status()

    def _read_line(self, line):
        try:
            words = self._checked(line).split()
        except _Refused as refused:
            self._say(f"err {refused}")
            return
        if words:
            self._answer(words)

    def _checked(self, line):
        """Return the text without its checksum, or refuse the line."""
        if len(line) > LONGEST_LINE:
            raise _Refused(6)
        text, star, digits = line.rpartition(b"*")
        wrong = digits != _checksum(text) if star else self.checksums and line.split()
        if wrong or not re.fullmatch(rb"[\t -~]*", line):
            raise _Refused(1)
        return (text if star else line).decode()

    def _answer(self, words):
        number, name = None, ""
        if re.fullmatch("N[0-9]{1,4}", words[0]):
            number = int(words.pop(0)[1:])
            name = f" N{number}"
        if words:
            self.heard_ms = self.now_ms  # a number alone is no command
        if number is None or number != self.last_number:
            try:
                answer = f"ok{name} {self._do(words) or ''}".rstrip()
            except _Refused as refused:
                answer = f"err{name} {refused}"
        else:
            answer = self.last_answer
        if words:
            self.last_number, self.last_answer = number, answer
        self._say(answer)

    def _do(self, words):
        command = words[0].upper() if words else ""
        if command not in COMMANDS:
            raise _Refused(2)
        fewest, most = COMMANDS[command]
        if not fewest <= len(words) - 1 <= most:
            raise _Refused(3)
        return getattr(self, "_do_" + command.lower())(*words[1:])

    # ---- the status

    def _state(self):
        if self.latched:
            return "stop"
        if not self.on:
            return "off"
        if any(joint.kind == "home" for joint in self.joints):
            return "home"
        beside = any(joint.kind == "held" and joint.beside() for joint in self.joints)
        return "run" if beside or self._busy() else "idle"

    def _say_status(self):
        angles = ",".join(_text(joint.angle(), 2) for joint in self.joints)
        speeds = ",".join(_text(joint.speed, 0) for joint in self.joints)
        counters = f"lost={self.lost} drop={self.drop}"
        t = self.now_ms % 2**31
        self._say(f"<{self._state()} t={t} h={self.known} f={self.fault} p={angles} v={speeds} {counters}>")

    def _room(self):
        return 128 - self.pending >= 100

    def _answer_status(self):
        if self.asked and self._room():
            self.asked = False
            self._say_status()

    def _report(self):
        self._answer_status()
        if self.report_ms and self.now_ms >= self.report_due:
            self.report_due += self.report_ms
            if self._room():
                self._say_status()
            else:
                self.drop += 1

    # ---- the commands; each checks in the page's order

    def _joint(self, word):
        return self.joints[int(_read_choice(word, ("1", "2"))) - 1]

    def _check_free(self, joints, but=""):
        if any(joint.busy() and joint.kind != but for joint in joints):
            raise _Refused(8)

    def _accept(self, joints, but=""):
        if not self.on or self.latched:
            raise _Refused(5)
        self._check_free(joints, but)
        self.fault = "-"
        self._weigh()  # an earlier line of the same tick may have changed angles

    def _do_id(self):
        return "armkit 1 joints=2 hz=500"

    def _do_en(self, word):
        self.on, self.latched = _read_choice(word, ("0", "1")) == "1", False
        if self.on:
            self.fault = "-"
        else:
            self._stop_both(self.fault)
        for joint in self.joints:
            joint.roll_ticks = 0  # until it rests, but half a second at most, it is braked

    def _do_st(self):
        for joint in self.joints:
            joint.end(self.mode)

    def _do_mv(self, joint_word, goal_word, percent_word="100"):
        self._begin_moves([self._joint(joint_word)], [goal_word], percent_word)

    def _do_ma(self, first_word, second_word, percent_word="100"):
        self._begin_moves(self.joints, [first_word, second_word], percent_word)

    def _begin_moves(self, joints, goal_words, percent_word):
        goals = [_read_number(word) for word in goal_words]
        f = _read_number(percent_word, 1, 100) / 100
        if any(not joint.par["lo"] <= goal <= joint.par["hi"] for joint, goal in zip(joints, goals, strict=True)):
            raise _Refused(4)
        self._accept(joints, but="move")
        times = [joint.duration(goal) for joint, goal in zip(joints, goals, strict=True)]
        for joint, goal, own in zip(joints, goals, times, strict=True):
            if self.mode == "rule":
                joint.move_by_rule(goal, f)
            else:
                joint.move(goal, f * (own / max(times)) if own else f)

    def _do_pw(self, joint_word, duty_word, ms_word):
        joint = self._joint(joint_word)
        duty = int(_read_number(duty_word, -255, 255))
        milliseconds = _read_number(ms_word, 1, 2000)
        self._accept([joint])
        joint.push(duty, milliseconds)

    def _do_ze(self, joint_word, degrees_word="0"):
        joint = self._joint(joint_word)
        degrees = _read_number(degrees_word, -360, 360)
        self._check_free([joint])
        joint.stand_at(degrees)
        self.known |= 1 << self.joints.index(joint)
        self._keep_holding()

    def _do_hm(self, joint_word):
        joint = self._joint(joint_word)
        self._accept([joint])
        self.known &= ~(1 << self.joints.index(joint))
        self._keep_holding()
        joint.find_home()

    def _do_set(self, joint_word, name, value_word):
        joint = self._joint(joint_word)
        lowest, highest = PARAMETERS[_read_choice(name, PARAMETERS)][:2]
        value = _read_number(value_word, lowest, highest)
        self._check_free(self.joints)
        joint.set_parameter(name, value)
        self._keep_holding()

    def _do_get(self, joint_word, name):
        joint = self._joint(joint_word)
        values = {**joint.par, "held": joint.held}
        return _text(values[_read_choice(name, values)], 3)

    def _do_mode(self, word):
        _read_choice(word, ("pid", "rule"))
        self._check_free(self.joints)
        self.mode = word
        if word == "rule":
            self._stop_both(self.fault)  # nothing is held in this mode

    def _do_rp(self, word):
        self.report_ms = _read_number(word, 20, 60000, or_zero=True)
        self.report_due = self.now_ms + self.report_ms

    def _do_wd(self, word):
        self.watchdog_ms = _read_number(word, 100, 60000, or_zero=True)

    def _do_cs(self, word):
        self.checksums = _read_choice(word, ("0", "1")) == "1"


class SimpleArm:
    """Two motors with a first-order lag and a dead band, encoders and home switches; good enough to try the lines.

    Parameters
    ----------
    angles : sequence of float
        Where the joints stand, in degrees.
    """

    ENDS = ((-175.0, 175.0), (-165.0, 165.0))
    HOMES = (-170.0, -160.0)

    def __init__(self, angles=(0.0, 0.0)):
        self.start, self.angles = list(angles), list(angles)
        self.speeds, self.duties = [0.0, 0.0], [None, None]

    def counts(self, j):
        """Return the encoder edges of joint ``j`` since power-up."""
        return math.floor((self.angles[j] - self.start[j]) * 4094.4 / 360 + 0.5)

    def pressed(self, j):
        """Return whether the home switch of joint ``j`` is closed."""
        return self.angles[j] <= self.HOMES[j]

    def set_duty(self, j, duty):
        """Give the motor of joint ``j`` its duty, -255 to 255; None lets it go."""
        self.duties[j] = duty

    def move(self, seconds):
        """Let some time pass."""
        for j, (low, high) in enumerate(self.ENDS):
            self._turn(j, seconds)
            if not low < self.angles[j] < high:
                self.angles[j], self.speeds[j] = max(low, min(high, self.angles[j])), 0.0

    def _turn(self, j, seconds):
        volts = 6 * (self.duties[j] or 0) / 255
        way = _sign(self.speeds[j]) or _sign(volts)
        dead, starts = (0.4, 0.46) if way > 0 else (0.55, 0.65)
        if self.speeds[j] == 0 and abs(volts) <= starts:
            return
        tau = 0.5 if self.duties[j] is None else 0.06  # a motor that nobody brakes rolls on
        target = 75 * (volts - way * dead)
        speed = target + (self.speeds[j] - target) * math.exp(-seconds / tau)
        self.speeds[j] = 0.0 if speed * way < 0 else speed
        self.angles[j] += self.speeds[j] * seconds


def _serve(server, controller, arm):
    host, waiting, due = None, bytearray(), time.perf_counter()
    while True:
        controller.tick()
        arm.move(T)
        waiting += controller.sent()
        try:
            if host is None:
                waiting.clear()  # nobody hears it
                host = server.accept()[0]
                host.setblocking(False)
            del waiting[: host.send(waiting[:BYTES_PER_TICK])]
            data = host.recv(4096)
            controller.receive(data)
            host = host if data else None
        except BlockingIOError:
            pass  # nobody and nothing came
        except OSError:
            host = None
        due = max(due + T, time.perf_counter() - 0.25)  # after a long hold-up it does not hurry to catch up
        time.sleep(max(0.0, due - time.perf_counter()))


def main():
    """Run the controller with a simple arm behind a TCP port, by the clock, until Ctrl-C."""
    parser = argparse.ArgumentParser(description="The arm's protocol with a simple arm behind a TCP port.")
    parser.add_argument("--port", type=int, default=7777)
    arm = SimpleArm()
    with socket.create_server(("127.0.0.1", parser.parse_args().port)) as server, suppress(KeyboardInterrupt):
        server.setblocking(False)
        print(f"The arm listens on socket://localhost:{server.getsockname()[1]}; Ctrl-C ends it.", flush=True)
        _serve(server, Controller(arm), arm)


if __name__ == "__main__":
    main()

"""What the commands of PROTOCOL.md do to two bus servos.

Each servo has a controller of its own, which holds its place: here is only said where to go, how fast, and what a servo
tells of itself is watched. It has no watchdog: when this program is gone, it holds on.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import serial

from stereo_lab.arm import protocol as wire
from stereo_lab.arm.feetech import packets
from stereo_lab.arm.feetech.bus import TRIES, Bus
from stereo_lab.arm.virtual.interpreter import Interpreter
from stereo_lab.motion import trapezoid_s

STEP_DEG = 360 / 4096
MIDDLE, LAST = 2048, 4095  # steps at 0 degrees, and at the end of its turn
LIMITS, TORQUE, RUN, TORQUE_LIMIT, PRESENT = 9, 40, 41, 48, 56  # addresses in a servo's table
PRESENT_BYTES = 11  # position, speed, load, voltage, temperature, two flags, moving
PLACE_BYTES, GOAL_BYTES = 4, 3  # as much of PRESENT and RUN; not 2, as in a question: its late echo would be an answer
ACCELERATION_STEP = 100 * STEP_DEG  # degrees per second, every second
ARRIVED_DEG = 1.0  # as much as the play of its gears
STUCK_S = 0.3  # so long without motion, and not there, is a stall
HOT_C = 60  # above it the motor is switched off, before it does that itself
LARGEST_SPEED = 3400


class ServoJoint:
    """One joint: its limits, and what its servo told last.

    Attributes
    ----------
    range_deg : (low, high), how far its servo itself goes
    parameters : dict, as PROTOCOL.md names them; the servo knows the rest
    position_deg, speed_deg_s, load, volts, celsius : float; load is a share of the largest
    goal_deg : float or None, where it goes, while it goes
    sent : int, the goal that its servo was told last, in steps
    """

    def __init__(self, id: int, range_deg: tuple[float, float], volts: float) -> None:
        self.id, self.range_deg, self.homed, self.held_v = id, range_deg, True, 0.0
        counts = 360 / STEP_DEG  # steps of its sensor on a turn
        self.parameters = {
            "lo": range_deg[0], "hi": range_deg[1], "cruise": 120.0, "acc": 300.0, "supply": volts, "counts": counts
        }  # fmt: skip
        self.position_deg = self.speed_deg_s = self.load = self.volts = self.celsius = 0.0
        self.error, self.moving = 0, False
        self.goal_deg: float | None = None
        self.sent, self.still_s = MIDDLE, 0.0

    @property
    def busy(self) -> bool:
        """Whether it is on its way."""
        return self.goal_deg is not None

    def take_in(self, data: bytes, seconds: float) -> None:
        """What its servo told: the bytes from PRESENT on."""
        before = self.position_deg
        self.position_deg = (packets.number(data[0:2]) - MIDDLE) * STEP_DEG
        self.speed_deg_s = packets.number(data[2:4]) * STEP_DEG
        self.load = packets.number(data[4:6], 10) / 1000
        self.volts, self.celsius, self.moving = data[6] / 10, float(data[7]), bool(data[10])
        turns = abs(self.position_deg - before) > STEP_DEG or self.moving
        self.still_s = 0.0 if turns else self.still_s + seconds

    def duration_s(self, goal_deg: float) -> float:
        """Seconds of a trapezoid from here to a goal."""
        return trapezoid_s(abs(goal_deg - self.position_deg), self.parameters["cruise"], self.parameters["acc"])


class ServoController:
    """Both servos behind the commands of PROTOCOL.md.

    Attributes
    ----------
    line : Interpreter, what the host says and hears
    joints : (ServoJoint, ServoJoint)
    enabled, stopped : bool
    fault : str, as :class:`stereo_lab.arm.protocol.Status` has it
    """

    def __init__(self, bus: Bus, ids: Sequence[int], clock: Callable[[], float]) -> None:
        self.bus, self.clock, self.start = bus, clock, clock()
        self.enabled, self.stopped, self.fault = False, False, "-"
        self.watchdog_ms, self.report_ms, self.dropped = 1000, 0, 0
        self.heard_s = self.looked_s = self.reported_s = clock()
        bus.find_echo(ids[0])
        self.joints = tuple(self._joint(id) for id in ids)
        self.line = Interpreter(self)
        self.look()
        self.line.say(wire.GREETING)

    def _joint(self, id):
        table = self.bus.read(id, LIMITS, 4).data
        low, high = (packets.number(table[k : k + 2]) for k in (0, 2))
        range_deg = (-175.0, 175.0)
        if high > low:
            range_deg = wire.inwards("lo", (low - MIDDLE) * STEP_DEG), wire.inwards("hi", (high - MIDDLE) * STEP_DEG)
        return ServoJoint(id, range_deg, self.bus.read(id, 62, 1).data[0] / 10)

    # What the host's lines do

    def status(self) -> wire.Status:
        """What ``?`` answers."""
        first, second = self.joints
        state = "stop" if self.stopped else "off" if not self.enabled else "run" if self.busy else "idle"
        return wire.Status(
            state, round((self.clock() - self.start) * 1000), (True, True), self.fault,
            (first.position_deg, second.position_deg), (first.speed_deg_s, second.speed_deg_s), 0, self.dropped,
        )  # fmt: skip

    @property
    def busy(self) -> bool:
        """Whether either joint is on its way."""
        return any(joint.busy for joint in self.joints)

    def is_heard(self) -> None:
        """The host is there: the watchdog begins anew."""
        self.heard_s = self.clock()

    def enable(self, on: bool) -> None:
        """Switch the motors on, where they stand, or off, and then nothing holds them."""
        if on:
            self._stay(self.joints)
            self.enabled, self.stopped, self.fault = True, False, "-"
        else:
            self.let_go()
            self.enabled = self.stopped = False

    def halt(self, latch: bool = False, fault: str | None = None, hold: bool = False) -> None:
        """Stop both joints: they are held where they are."""
        if self.enabled:
            self._stay(self.joints)
        self.stopped = self.stopped or latch
        self.fault = fault or self.fault

    def move_to(self, goals: Sequence[float | None], pace: float) -> None:
        """Move joints to their goals (None: it stays as it is), at a share of their speed, so that they arrive together."""
        moving = [(joint, goal) for joint, goal in zip(self.joints, goals, strict=True) if goal is not None]
        for joint, goal in moving:
            if not joint.parameters["lo"] <= goal <= joint.parameters["hi"]:
                raise wire.ProtocolError(wire.LIMIT)
        if self.stopped or not self.enabled:
            raise wire.ProtocolError(wire.OFF)
        times = [joint.duration_s(goal) for joint, goal in moving]
        told = {}
        for (joint, goal), time in zip(moving, times, strict=True):
            share = pace * (1.0 if time == 0 else time / max(times))
            cruise, acceleration = joint.parameters["cruise"] * share, joint.parameters["acc"]
            if not joint.busy:
                acceleration *= share**2  # a joint that moves already needs all of it, to brake in time
                joint.still_s = 0.0  # a new goal on the way does not clear what was seen so far
            told[joint.id] = run_bytes(goal, cruise, acceleration)
            joint.goal_deg, joint.sent = goal, packets.number(told[joint.id][1:3])
        self.bus.tell(RUN, told)
        self.fault = "-"

    def push(self, j: int, duty: int, milliseconds: float) -> None:
        """A servo cannot be pushed: it knows its motor itself."""
        raise wire.ProtocolError(wire.COMMAND)

    def zero(self, j: int, angle_deg: float) -> None:
        """A servo knows where it stands; another zero is written once, by setup."""
        raise wire.ProtocolError(wire.COMMAND)

    def home(self, j: int) -> None:
        """It knows where it stands: nothing to find."""
        if self.stopped or not self.enabled:
            raise wire.ProtocolError(wire.OFF)
        self.line.say(wire.encode_event(wire.Event("home", j + 1, self.joints[j].position_deg)))

    def set(self, j: int, name: str, value: float) -> None:
        """Limits and speeds; all else is the servo's own. A limit beyond its range is the end of that, and told as such."""
        self.must_rest()
        if name not in ("lo", "hi", "cruise", "acc"):
            raise wire.ProtocolError(wire.ARGUMENT)
        if name in ("lo", "hi"):
            low, high = self.joints[j].range_deg
            value = max(value, low) if name == "lo" else min(value, high)
            if not low <= value <= high:
                raise wire.ProtocolError(wire.LIMIT)
        self.joints[j].parameters[name] = value

    def follow_rule(self, on: bool) -> None:
        """A servo moves by its own profile, by no rule."""
        if on:
            raise wire.ProtocolError(wire.COMMAND)

    def report_every(self, milliseconds: int) -> None:
        """Send a status by itself every so often, first after that time; 0: never."""
        self.report_ms, self.reported_s = milliseconds, self.clock()

    def must_rest(self) -> None:
        """Refuse what may not happen while anything moves."""
        if self.busy:
            raise wire.ProtocolError(wire.BUSY)

    # What happens by itself

    def look(self) -> None:
        """Ask both servos how they are, and act on it: arrived, stuck, overloaded, too hot; watchdog; ``?``; reports."""
        now = self.clock()
        seconds, self.looked_s = now - self.looked_s, now
        for j, joint in enumerate(self.joints):
            answer = self.bus.read(joint.id, PRESENT, PRESENT_BYTES)
            joint.error = answer.error
            joint.take_in(answer.data, seconds)
            if self.enabled:
                self._judge(j, joint)
        if self.watchdog_ms and (now - self.heard_s) * 1000 > self.watchdog_ms and self.busy:
            self.enable(False)
            self.fault = "w"
            self.line.say("!watchdog")
        self.line.answer_questions()
        if self.report_ms and (now - self.reported_s) * 1000 >= self.report_ms:
            self.reported_s = now
            self.line.report()

    def _judge(self, j, joint):
        if joint.error & 0x2C or joint.celsius > HOT_C:  # too hot, too much current, overloaded for seconds
            self.let_go()
            self.enabled = False
            self._stalls(j)
        elif joint.busy and joint.still_s > 2 * STUCK_S / 3:
            if abs(joint.goal_deg - joint.position_deg) <= ARRIVED_DEG:
                joint.goal_deg = None
                self.line.say(wire.encode_event(wire.Event("done", j + 1, joint.position_deg)))
            elif joint.still_s > STUCK_S:
                self._stay(self.joints)
                self._stalls(j)
        elif joint.moving and not joint.busy and not self._has_its_goal(joint):
            self._stay([joint])  # but not where a load moves it: with every new goal it would sink a little farther

    def _stalls(self, j):
        self.fault = f"s{j + 1}"
        self.line.say(wire.encode_event(wire.Event("stall", j + 1, self.joints[j].position_deg)))

    def _stay(self, joints):
        """Hold joints where they are now. Torque comes last: without its new goal a servo would drive to an old one."""
        for joint in joints:
            joint.goal_deg = None
        self._insist(joints, self._send_here, self._has_its_goal)
        self._switch(joints, b"\1")

    def _send_here(self, joints):
        for joint in joints:
            joint.sent = packets.number(self.bus.read(joint.id, PRESENT, PLACE_BYTES).data)
        self.bus.tell(RUN, {joint.id: b"\xfe" + packets.word(joint.sent) + bytes(4) for joint in joints})

    def _has_its_goal(self, joint):
        """Whether its servo goes where it was sent; one that stands just beyond its range may take the end of that."""
        goal = packets.number(self.bus.read(joint.id, RUN, GOAL_BYTES).data[1:])
        return abs(goal - joint.sent) * STEP_DEG <= ARRIVED_DEG

    def let_go(self) -> None:
        """Switch both motors off, whether they answer or not.

        Raises
        ------
        serial.SerialException
            If one of them may still be on.
        """
        for joint in self.joints:
            joint.goal_deg = None
        self._switch(self.joints, b"\0")

    def _switch(self, joints, torque):
        self._insist(
            joints,
            lambda left: self.bus.tell(TORQUE, {joint.id: torque for joint in left}),
            lambda joint: self.bus.holds(joint.id, TORQUE, torque),
        )

    def _insist(self, joints, tell, heeds):
        """Tell joints until all heed it: nobody answers what several are told at once, and noise may have eaten it."""
        left = list(joints)
        for _ in range(TRIES):
            tell(left)
            left = [joint for joint in left if not heeds(joint)]
            if not left:
                return
        raise serial.SerialException(
            f"servo {left[0].id} does not do what it is told: is its plug loose, or its wire noisy?"
        )


def run_bytes(goal_deg: float, cruise_deg_s: float, acceleration_deg_s2: float) -> bytes:
    """Acceleration, goal, time and speed, as they stand in a servo's table."""
    acceleration = min(max(round(acceleration_deg_s2 / ACCELERATION_STEP), 1), 254)
    speed = min(max(round(cruise_deg_s / STEP_DEG), 1), LARGEST_SPEED)
    return bytes([acceleration]) + packets.word(round(goal_deg / STEP_DEG) + MIDDLE) + bytes(2) + packets.word(speed)

"""The one client of the arm: virtual, simulated or real."""

from __future__ import annotations

import errno
import logging
import time
from collections import deque

import serial
from serial.tools import list_ports

from stereo_lab.arm import protocol as wire
from stereo_lab.errors import ArmError, StereoLabError, UnreachableTargetError
from stereo_lab.kinematics import JointAngles
from stereo_lab.motors import calibrate_motor

if "stereo_lab.arm" not in serial.protocol_handler_packages:
    serial.protocol_handler_packages.append("stereo_lab.arm")  # where pyserial finds virtual://

ANSWER_S = 0.3  # a command that is not answered so long is sent again
GIVE_UP_S = 0.9  # and after so long it has failed
BOOT_S = 2.5  # a board on USB restarts when its port is opened
MOST_TRIES = 10  # where noise is heard it is sent again at once, but not for ever
LOOK_S = 0.02  # how long one look at the port lasts
ROUNDING_S = 1e-6
ASK_S = 0.1  # how often a moving arm is asked how it is; this also feeds its watchdog
GENTLY_PERCENT = 30  # of the usual speed, for the last bit
ONE_SIDE_DEG = 3.0  # more than the backlash of a worn gear
ROOM_DEG = 30.0  # a calibration that starts so near the middle has room enough
FAULTS = {
    "s": "is stalled: it gets voltage and does not turn. Is something in its way, or its supply off?",
    "r": "ran the wrong way and was stopped: swap the two wires of its motor, or the two of its encoder.",
    "w": "stopped because it heard nothing from this computer for too long (watchdog).",
    "e": "was stopped in mid-move.",
}
log = logging.getLogger(__name__)


def ports():
    """The serial ports of this computer.

    Returns
    -------
    list of (name, description)
        The virtual arm first; it is always there.
    """
    found = sorted((p.device, p.description) for p in list_ports.comports())
    return [("virtual://arm", "a simulated arm, no hardware needed"), *found]


def connect(port="virtual://arm", baud_rate=wire.BAUD_RATE):
    """Open a port and greet the arm behind it. Nothing moves, and the motors stay off.

    Parameters
    ----------
    port : str or an open pyserial port
        "virtual://arm", "COM3", "/dev/ttyUSB0", "socket://host:port", …
    baud_rate : int

    Returns
    -------
    Arm
        Use it with ``with``: at the end its motors are stopped, whatever happens.

    Raises
    ------
    ArmError
        If the port cannot be opened, or nothing behind it speaks the arm's protocol.
    """
    opened = _open(port, baud_rate) if isinstance(port, str) else port
    arm = Arm(opened)
    try:
        arm._greet()
    except BaseException:
        opened.close()
        raise
    return arm


def _open(name, baud_rate):
    try:
        return serial.serial_for_url(name, baudrate=baud_rate, timeout=LOOK_S, write_timeout=1, exclusive=True)
    except (serial.SerialException, ValueError, OSError) as error:
        raise ArmError(_why_not(name, error)) from None


def _why_not(name, error):
    there = ", ".join(port for port, _ in ports())
    number = getattr(error, "errno", None)
    if number in (errno.EBUSY, errno.EAGAIN) or "lock" in str(error).lower():
        return f"{name} is in use. Close whatever else has it open: another notebook, the Arduino IDE's monitor."
    if number == errno.EACCES or "PermissionError" in str(error):
        return f"{name} may not be opened by this user, or is in use. On Linux join the group dialout and log in again."
    if number == errno.ECONNREFUSED:
        return f"Nobody listens at {name}. Start the program that serves the arm first."
    if name.startswith("virtual:"):
        return f"{error}."
    return f"There is no port {name} here. There are: {there}. Is the cable plugged in at both ends?"


class Arm:
    """An arm behind an open port; made by :func:`connect`.

    Attributes
    ----------
    port : the pyserial port
    limits_deg : ((low, high), (low, high)), as the controller has them
    """

    def __init__(self, port):
        self.port = port
        self.name = str(getattr(port, "name", None) or getattr(port, "port", "the port"))
        self._clock = getattr(port, "clock", time.monotonic)
        self._buffer, self._number = bytearray(), 0
        self._answers, self._trouble = deque(), {"heard": 0, "garbled": 0, "other": 0}
        self._asked_to_stop = self._restarted = False
        self.events = deque(maxlen=100)
        self.limits_deg = None

    def __repr__(self):
        return f"Arm({self.name!r})"

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    # --- what the arm does ---------------------------------------------------------------------------------

    def move_to(self, angles, one_side=False):
        """Move both joints, and wait until they are there. The motors are switched on if they are off.

        Parameters
        ----------
        angles : JointAngles
        one_side : bool
            Arrive turning clockwise, as in homing, so that backlash always lies on the same side.

        Returns
        -------
        JointAngles
            What was really reached, by the encoders.

        Raises
        ------
        UnreachableTargetError
            Beyond a limit; nothing is sent then.
        ArmError
            If the arm stops on the way, or does not answer.
        """
        goals = self._goals(angles)
        self._switch_on()
        if one_side:
            beyond = [min(g + ONE_SIDE_DEG, high) for g, (_, high) in zip(goals, self.limits_deg, strict=True)]
            self._move(f"MA {beyond[0]:.3f} {beyond[1]:.3f}")
            return self._move(f"MA {goals[0]:.3f} {goals[1]:.3f} {GENTLY_PERCENT}")
        return self._move(f"MA {goals[0]:.3f} {goals[1]:.3f}")

    def angles(self):
        """Where the joints are, by their encoders.

        Returns
        -------
        JointAngles
        """
        return JointAngles(*self.status().position_deg)

    def home(self):
        """Find out where the joints stand: drive each to its switch, back, and slowly to it again.

        Returns
        -------
        JointAngles
        """
        self._switch_on()
        for joint in (2, 1):  # the forearm first, out of the way
            self._move(f"HM {joint}")
        return self.angles()

    def stop(self):
        """Stop both motors at once. A move that is waited for elsewhere ends with an ArmError."""
        self._asked_to_stop = True
        give_up, tries = self._clock() + GIVE_UP_S, 0
        while self._clock() < give_up and tries < 2 * MOST_TRIES:
            tries += 1
            self._write(b"\n" + wire.STOP + b"\n")
            status = self._status_once(0.1)
            if status is not None and status.state == "stop":
                return
        raise self._no_answer("a stop")

    def enable(self):
        """Switch the motors on, also after a stop, when whatever caused it is mended."""
        self.command("EN 1")
        self._asked_to_stop = False

    def disable(self):
        """Stop the motors and switch them off."""
        self.command("EN 0")

    def status(self):
        """What the controller says of itself.

        Returns
        -------
        stereo_lab.arm.protocol.Status
        """
        give_up, tries = self._clock() + GIVE_UP_S, 0
        while self._clock() < give_up and tries < MOST_TRIES:
            tries += 1
            status = self._status_once(ANSWER_S)
            if status is not None:
                return status
        raise self._no_answer("a question")

    @property
    def homed(self):
        """Whether both joints know where they stand."""
        return all(self.status().homed)

    def close(self):
        """Stop the motors and close the port. Never raises: a port that is gone is closed already."""
        if not self.port.is_open:
            return
        try:
            self.stop()
            self.disable()
        except (StereoLabError, serial.SerialException, OSError) as error:
            log.info("%s could not be told to stop (%s); its watchdog stops it.", self.name, error)
        finally:
            self.port.close()

    def wait(self, seconds):
        """Let time pass while the arm stays watched."""
        until = self._clock() + seconds
        while self._clock() < until:
            self.status()
            self._listen(min(ASK_S, max(until - self._clock(), 0)))

    # --- motors and parameters -----------------------------------------------------------------------------

    def get(self, joint, name):
        """A parameter of a joint; their names stand in PROTOCOL.md."""
        return float(self.command(f"GET {joint} {name}"))

    def set(self, joint, name, value):
        """Set a parameter of a joint."""
        self.command(f"SET {joint} {name} {_decimal(value)}")
        if name in ("lo", "hi"):
            self._read_limits()

    def set_limits(self, limits_deg):
        """Tell the controller how far its joints may turn, as a recording's arm says it."""
        for joint, (low, high) in enumerate(limits_deg, start=1):
            self.set(joint, "lo", low)
            self.set(joint, "hi", high)

    def push(self, joint, volts, seconds):
        """Give a motor a voltage for some time, and wait until it is at rest.

        Returns
        -------
        float
            By how many degrees the joint turned.
        """
        self._switch_on()
        duty = round(volts / self.supply_v * 255)
        if abs(duty) > 255:
            raise UnreachableTargetError(f"The supply has {self.supply_v:g} V; {volts:g} V were asked for.")
        before = self.status().position_deg[joint - 1]
        after = self._move(f"PW {joint} {duty} {round(seconds * 1000)}")
        return (after.theta1_deg, after.theta2_deg)[joint - 1] - before

    def calibrate(self, joint):
        """Measure a motor by pushing it to and fro, some tens of degrees, and tell the controller.

        A joint that stands far from the middle of its range is driven there first.

        Returns
        -------
        MotorCalibration
        """
        self._switch_on()
        middle = sum(self.limits_deg[joint - 1]) / 2
        if abs(self.status().position_deg[joint - 1] - middle) > ROOM_DEG:
            self._move(f"MV {joint} {middle:.3f}")
        found = calibrate_motor(lambda volts, seconds: self.push(joint, volts, seconds), self.supply_v)
        self.use(joint, found)
        return found

    def use(self, joint, calibration):
        """Tell the controller what was measured of a motor."""
        for name, value in (
            ("k", calibration.speed_per_volt), ("tau", calibration.time_constant_s * 1000),
            ("db+", calibration.ccw.dead_band_v), ("db-", calibration.cw.dead_band_v),
            ("st+", calibration.ccw.starts_at_v), ("st-", calibration.cw.starts_at_v),
        ):  # fmt: skip
            self.set(joint, name, value)

    def command(self, text):
        """Send any command of the protocol.

        Parameters
        ----------
        text : str, such as "GET 1 k"

        Returns
        -------
        str
            The data of its ``ok``.

        Raises
        ------
        ArmError
            If it is refused, or not answered within a second.
        """
        self._number = self._number % wire.NUMBER_MAX + 1
        return self._exchange(text, self._number)

    # --- moving --------------------------------------------------------------------------------------------

    def _goals(self, angles):
        if not isinstance(angles, JointAngles):
            raise StereoLabError(f"Expected JointAngles(theta1_deg, theta2_deg), got {angles!r}.")
        goals = []
        for joint, (angle, (low, high)) in enumerate(
            zip((angles.theta1_deg, angles.theta2_deg), self.limits_deg, strict=True), start=1
        ):
            try:
                goal = float(angle)
            except (TypeError, ValueError):
                raise StereoLabError(f"Joint {joint}: expected a number of degrees, got {angle!r}.") from None
            if not low - 1e-6 <= goal <= high + 1e-6:  # refuses NaN as well
                raise UnreachableTargetError(
                    f"Joint {joint} turns from {low:g} to {high:g} degrees; {goal:g} was asked for. Nothing was sent."
                )
            goals.append(min(max(goal, low), high))
        return goals

    def _switch_on(self):
        status = self.status()
        if status.state == "stop" and not self._asked_to_stop:
            raise ArmError(self._why_it_stopped(status) + " When that is mended: arm.enable().")
        if status.state in ("stop", "off"):
            self.enable()

    def _move(self, command):
        """Start a move and wait for its end; whatever interrupts the wait stops the motors."""
        self._restarted = False
        self.command(command)
        try:
            while (status := self.status()).state in ("run", "home"):
                self._listen(ASK_S)
        except serial.SerialException as error:
            raise self._gone(error) from None
        except ArmError:
            raise
        except BaseException:
            self.stop()
            raise
        if self._restarted:
            raise ArmError(f"The controller on {self.name} restarted in mid-move; its position is lost. Home it again.")
        if status.fault != "-":
            raise ArmError(self._why_it_stopped(status))
        if status.state != "idle":
            raise ArmError(f"The arm on {self.name} was switched off in mid-move.")
        return JointAngles(*status.position_deg)

    def _why_it_stopped(self, status):
        kind, joint = status.fault[0], status.fault[1:]
        who = f"Joint {joint} of the arm on {self.name}" if joint else f"The arm on {self.name}"
        return f"{who} {FAULTS.get(kind, 'was stopped.')}"

    # --- the line ------------------------------------------------------------------------------------------

    def _greet(self):
        """Agree on checksums, and see who is there."""
        wait = BOOT_S if _restarts_when_opened(self.port) else GIVE_UP_S
        self._write(b"\n")
        self._exchange("CS 1", None, wait)
        identity = self.command("ID")
        if not identity.startswith("armkit 1 "):
            raise ArmError(f"Something else is at {self.name}: it calls itself {identity!r}, not armkit 1.")
        self._restarted = False
        self._read_limits()
        self.supply_v = self.get(1, "supply")

    def _read_limits(self):
        self.limits_deg = tuple((self.get(j, "lo"), self.get(j, "hi")) for j in (1, 2))

    def _exchange(self, text, number, give_up_s=GIVE_UP_S):
        """Send until it is answered: again after 0.3 s, and at once where noise was heard."""
        line = wire.encode_command(text, number)
        self._trouble = {"heard": 0, "garbled": 0, "other": 0}
        give_up, tries = self._clock() + give_up_s, 0
        while self._clock() < give_up and tries < MOST_TRIES:
            tries += 1
            self._write(line)
            reply = self._await_reply(number, min(self._clock() + ANSWER_S, give_up))
            if reply is None or (reply.code in (wire.CHECKSUM, wire.TOO_LONG, wire.OVERRUN) and number != reply.number):
                continue
            if reply.code:
                raise ArmError(f"The arm refused {text!r}: error {reply.text} ({_meaning(reply.code)}).")
            return reply.text
        raise self._no_answer(repr(text))

    def _await_reply(self, number, until):
        """The reply to a number; None as soon as something garbled came, or nothing."""
        garbled = self._trouble["garbled"]
        while True:
            while self._answers:
                reply = self._answers.popleft()
                if reply.number == number or (reply.number is None and reply.code):
                    return reply
                self._trouble["other"] += 1
            if self._trouble["garbled"] > garbled or self._clock() >= until - ROUNDING_S:
                return None
            self._listen(min(LOOK_S, until - self._clock()), once=True)

    def _status_once(self, seconds):
        self._status = None
        self._trouble = {"heard": 0, "garbled": 0, "other": 0}
        until = self._clock() + seconds
        self._write(b"\n" + wire.ASK + b"\n")
        while self._status is None and self._clock() < until - ROUNDING_S and not self._trouble["garbled"]:
            self._listen(min(LOOK_S, until - self._clock()), once=True)
        return self._status

    def _listen(self, seconds, once=False):
        """Read for some time, or (once) until something came."""
        until = self._clock() + seconds
        while True:
            try:
                self.port.timeout = max(min(LOOK_S, until - self._clock()), 0)
                data = self.port.read(max(1, self.port.in_waiting))
            except (serial.SerialException, OSError, TypeError) as error:
                raise self._gone(error) from None
            self._take(data)
            if self._clock() >= until - ROUNDING_S or (once and data):
                return

    def _take(self, data):
        self._trouble["heard"] += len(data)
        self._buffer += data
        while (end := self._buffer.find(b"\n")) >= 0:
            line = self._buffer[:end].decode("latin-1").strip("\r")
            del self._buffer[: end + 1]
            self._line(line)
        if len(self._buffer) > 4 * wire.LINE_MAX:  # no line is so long: noise, or a wrong baud rate
            self._buffer.clear()
            self._trouble["garbled"] += 1

    def _line(self, line):
        if not line:
            return
        text, right = wire.unseal(line)
        if right is None and text == wire.GREETING:
            self._restarted = True
            return
        answer = wire.decode_answer(text) if right else None
        if answer is None:
            self._trouble["garbled"] += 1
        elif isinstance(answer, wire.Reply):
            self._answers.append(answer)
        elif isinstance(answer, wire.Status):
            self._status = answer
        else:
            self.events.append(answer)

    def _write(self, data):
        try:
            self.port.write(data)
        except (serial.SerialException, OSError) as error:
            raise self._gone(error) from None

    def _gone(self, error):
        return ArmError(
            f"{self.name} is gone ({error}). Plug the arm in again and connect anew; "
            "its watchdog has stopped the motors."
        )

    def _no_answer(self, what):
        seen = self._trouble
        if self._restarted:
            return ArmError(
                f"The controller on {self.name} restarted; its position is lost. Connect and home it again."
            )
        if seen["other"]:
            return ArmError(
                f"{self.name} answers other commands than {what}. Unplug the arm, plug it in, connect anew."
            )
        if seen["heard"]:
            return ArmError(
                f"{self.name} sends {seen['heard']} bytes that make no sense after {what}: noise on the cable, another "
                f"device, or a wrong baud rate (the arm has {wire.BAUD_RATE})."
            )
        return ArmError(
            f"{self.name} does not answer {what}. Is the controller powered, and is it this port? "
            "The ports there are: stereo-lab arm list"
        )


def _restarts_when_opened(port):
    name = getattr(port, "port", None)
    return any(p.device == name and p.vid is not None for p in list_ports.comports())


def _decimal(value):
    return f"{float(value):.4f}".rstrip("0").rstrip(".")


def _meaning(code):
    return {
        wire.COMMAND: "there is no such command", wire.ARGUMENT: "an argument is missing or is not what it should be",
        wire.LIMIT: "the value is beyond its limits", wire.OFF: "the motors are off: arm.enable()",
        wire.BUSY: "the joint is moving",
    }.get(code, wire.ERRORS[code])  # fmt: skip

"""The one client of the arm: virtual, simulated or real."""

from __future__ import annotations

import atexit
import logging
import weakref
from numbers import Integral, Real

import serial

from stereo_lab.arm import measuring
from stereo_lab.arm import protocol as wire
from stereo_lab.arm.line import AGAIN_S, GIVE_UP_S, SerialLine, open_port
from stereo_lab.arm.stops import Stops
from stereo_lab.common.files import finite_number
from stereo_lab.errors import ArmError, RefusedError, StereoLabError, UnreachableTargetError
from stereo_lab.kinematics.angles import JointAngles, must_be_angles, must_be_limits
from stereo_lab.motion import MotorCalibration, WeightFit

ASK_S = 0.1  # how often a moving arm is asked how it is; this also feeds its watchdog
STOP_S = 0.1  # how long a stop waits to be confirmed before it is sent again
STANDSTILL_S = 5.0  # a move in which nothing turns for so long will not end
GENTLY_PERCENT = 30  # of the usual speed, for the last bit
ONE_SIDE_DEG = 3.0  # more than the backlash of a worn gear
FAULTS = {
    "s": "is stalled: it gets voltage and does not turn. Is something in its way, its load too heavy, or its supply off?",
    "r": "ran the wrong way and was stopped: swap the two wires of its motor, or the two of its encoder. "
    "Or does it carry far more than it can hold?",
    "w": "stopped because it heard nothing from this computer for too long (watchdog).",
    "e": "was stopped in mid-move.",
}
STOP_BYTES = b"\n" + wire.STOP + b"\n"
log = logging.getLogger(__name__)
_connected: weakref.WeakSet[Arm] = weakref.WeakSet()


def connect(port: str | serial.SerialBase = "virtual://arm", baud_rate: int = wire.BAUD_RATE) -> Arm:
    """Open a port and greet the arm behind it. Nothing moves, and the motors stay off.

    Parameters
    ----------
    port : str or an open pyserial port
        "virtual://arm", "COM3", "/dev/ttyUSB0", "socket://host:port", …
    baud_rate : int

    Returns
    -------
    Arm
        Use it with ``with``: at the end its motors are stopped, whatever happens. Else that is at the end of the program.

    Raises
    ------
    ArmError
        If the port cannot be opened, or nothing behind it speaks the arm's protocol.
    StereoLabError
        If it is neither a name nor a port.
    """
    if not isinstance(port, str) and not (hasattr(port, "read") and hasattr(port, "write")):
        raise StereoLabError(f'Expected the name of a port in quotes, such as "virtual://arm" or "COM3"; got {port!r}.')
    opened = open_port(port, baud_rate) if isinstance(port, str) else port
    arm = Arm(opened)
    try:
        arm._greet()
    except BaseException:
        opened.close()
        raise
    _connected.add(arm)
    return arm


@atexit.register
def _close_all() -> None:
    """Where a program ends, or a notebook's kernel is shut down, that did not close its arms: their motors would stay on."""
    for arm in list(_connected):
        arm.close()


class Arm:
    """An arm behind an open port; made by :func:`connect`.

    Attributes
    ----------
    port : the pyserial port
    limits_deg : ((low, high), (low, high)), as the controller has them
    supply_v : (float, float), what its motors get at most
    """

    def __init__(self, port: serial.SerialBase) -> None:
        self.port, self.line = port, SerialLine(port)
        self.name = self.line.name
        self.limits_deg: tuple[tuple[float, float], ...] = None  # type: ignore[assignment]  # until it is greeted
        self.supply_v: tuple[float, ...] = None  # type: ignore[assignment]
        self._number, self._stops = 0, Stops()

    def __repr__(self) -> str:
        return f"Arm({self.name!r})"

    def __enter__(self) -> Arm:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def move_to(self, angles: JointAngles, one_side: bool = False) -> JointAngles:
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
        goals = self.goals_deg(angles)
        self._switch_on()
        if one_side:
            beyond = [min(g + ONE_SIDE_DEG, high) for g, (_, high) in zip(goals, self.limits_deg, strict=True)]
            self.run(f"MA {beyond[0]:.3f} {beyond[1]:.3f}")
            return self.run(f"MA {goals[0]:.3f} {goals[1]:.3f} {GENTLY_PERCENT}")
        return self.run(f"MA {goals[0]:.3f} {goals[1]:.3f}")

    def steer(self, angles: JointAngles, percent: float = 100.0) -> None:
        """Set off for these angles and come back at once. A move under way goes on to the new goal without a halt.

        Who steers asks for :meth:`status` a few times a second, else the watchdog stops the arm.

        Parameters
        ----------
        angles : JointAngles
        percent : float, 1 to 100, of the usual speed

        Raises
        ------
        UnreachableTargetError
            Beyond a limit; nothing is sent then.
        StereoLabError
            If ``percent`` is not from 1 to 100; nothing is sent then.
        ArmError
            If the arm is off or stopped, or does not answer.
        """
        goals, percent = self.goals_deg(angles), finite_number(percent, "Percent of the usual speed")
        if not 1 <= round(percent) <= 100:  # as it is sent
            raise StereoLabError(f"Percent of the usual speed: expected 1 to 100, got {percent:g}. Nothing was sent.")
        self.command(f"MA {goals[0]:.3f} {goals[1]:.3f} {percent:.0f}")

    def goals_deg(self, angles: JointAngles) -> list[float]:
        """The two numbers that a move to these angles sends; refuses what is beyond a limit, and sends nothing.

        Raises
        ------
        UnreachableTargetError
            Beyond a limit, or not a number.
        """
        must_be_angles(angles)
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

    def angles(self) -> JointAngles:
        """Where the joints are, by their encoders.

        Returns
        -------
        JointAngles
        """
        return JointAngles(*self.status().position_deg)

    def home(self) -> JointAngles:
        """Find out where the joints stand: drive each to its switch, back, and slowly to it again.

        Returns
        -------
        JointAngles
        """
        self._switch_on()
        for joint in (2, 1):  # the forearm first, out of the way
            self.run(f"HM {joint}")
        return self.angles()

    def stop(self) -> None:
        """Stop both motors at once.

        Where another thread waits for a move, or is about to begin one, that ends with an ArmError.
        """
        self._stops.ask()
        give_up = self.line.clock() + GIVE_UP_S
        while (start := self.line.clock()) < give_up:
            self.line.write(STOP_BYTES)
            status = self.line.status_once(min(start + STOP_S, give_up))
            if status is not None and status.state == "stop":
                return
            self.line.listen(start + AGAIN_S - self.line.clock())
        raise self.line.no_answer("a stop")

    def enable(self) -> None:
        """Switch the motors on, also after a stop, when whatever caused it is mended."""
        self._enable(self._stops.count)

    def disable(self) -> None:
        """Stop the motors and switch them off. What another thread does with the arm is broken off by :meth:`stop`."""
        self.command("EN 0")

    def status(self) -> wire.Status:
        """What the controller says of itself.

        Returns
        -------
        stereo_lab.arm.protocol.Status
        """
        return self.line.status()

    def check(self) -> wire.Status:
        """The same of an arm that should be at work.

        Raises
        ------
        ArmError
            If its motors are off, or it was stopped: why.
        """
        status = self.status()
        if status.fault != "-" or status.state == "stop":
            raise ArmError(self._why_it_stopped(status) + " When that is mended: arm.enable().")
        if status.state == "off":
            raise ArmError(f"The motors of the arm on {self.name} are off: arm.enable().")
        return status

    @property
    def homed(self) -> bool:
        """Whether both joints know where they stand."""
        return all(self.status().homed)

    def close(self) -> None:
        """Stop the motors and close the port. Never raises: a port that is gone is closed already."""
        if not self.port.is_open:
            return
        try:
            self.stop()
            self.disable()
        except (StereoLabError, serial.SerialException, OSError) as error:
            log.info("%s could not be told to stop (%s); its watchdog stops it.", self.name, error)
        finally:
            self.line.close()

    def wait(self, seconds: float) -> None:
        """Let time pass while the arm stays watched."""
        until = self.line.clock() + finite_number(seconds, "Seconds to wait")
        while (left := until - self.line.clock()) > 0:
            self.status()
            self.line.listen(min(ASK_S, left))

    def get(self, joint: int, name: str) -> float:
        """A parameter of a joint; their names stand in PROTOCOL.md."""
        return float(self.command(f"GET {joint} {name}"))

    def set(self, joint: int, name: str, value: float) -> None:
        """Set a parameter of a joint; a limit is rounded inwards to the thousandth of a degree that the controller tells."""
        value = finite_number(value, f"Joint {joint}, {name}")
        if name in ("lo", "hi"):
            value = wire.inwards(name, value)
        self.command(f"SET {joint} {name} {_decimal(value)}")
        if name in ("lo", "hi", "supply"):
            self._read_bounds()

    def set_limits(self, limits_deg: tuple[tuple[float, float], tuple[float, float]]) -> None:
        """Tell the controller how far its joints may turn, as a recording's arm says it."""
        must_be_limits(limits_deg)
        for joint, (low, high) in enumerate(limits_deg, start=1):
            self.set(joint, "lo", low)
            self.set(joint, "hi", high)

    def push(self, joint: int, volts: float, seconds: float) -> float:
        """Give a motor a voltage for some time, and wait until it is at rest.

        Parameters
        ----------
        joint : 1 or 2
        volts : float, with a sign, up to the supply's
        seconds : float, 0.001 to 2

        Returns
        -------
        float
            By how many degrees the joint turned.

        Raises
        ------
        UnreachableTargetError
            More voltage than there is, or a joint that came to the end of its range.
        """
        _must_be_joint(joint)
        self._must_have_plain_motors()
        for what, value in (("volts", volts), ("seconds", seconds)):
            if not isinstance(value, Real):
                raise StereoLabError(f"Expected the {what} of a push as a number, got {value!r}.")
        supply = self.supply_v[joint - 1]
        if not abs(volts) <= supply:  # refuses NaN as well
            raise UnreachableTargetError(f"The supply has {supply:g} V; {volts:g} V were asked for. Nothing was sent.")
        if not 0.001 <= seconds <= 2:
            raise UnreachableTargetError(f"A push lasts 0.001 to 2 seconds; {seconds:g} were asked for.")
        self._switch_on()
        before = self.status().position_deg[joint - 1]
        after = self.run(f"PW {joint} {round(volts / supply * 255)} {round(seconds * 1000)}")
        stands = (after.theta1_deg, after.theta2_deg)[joint - 1]
        low, high = self.limits_deg[joint - 1]
        if (volts > 0 and stands > high) or (volts < 0 and stands < low):
            raise UnreachableTargetError(
                f"Joint {joint} was pushed to the end of its range ({low:g} to {high:g} degrees) and stopped there. "
                "Start nearer to the middle, or give it more room."
            )
        return float(stands - before)

    def calibrate(self, joint: int) -> MotorCalibration:
        """Measure a motor by pushing it to and fro, some tens of degrees, and tell the controller.

        An arm that is not homed is homed first, and one that is not weighed is weighed: friction is what is left of a
        voltage when the weight is known. A joint that stands far from the middle of its range is driven there, and for
        the shoulder an elbow that does not let the forearm hang is bent.

        Returns
        -------
        MotorCalibration
        """
        _must_be_joint(joint)
        self._must_have_plain_motors()
        return measuring.calibrate(self, joint)

    def weigh(self) -> tuple[WeightFit, WeightFit]:
        """Find what holds each joint against the arm's weight, and tell the controller: both joints in some poses.

        In each pose a joint is pushed as gently as just turns it, up and down.

        Raises
        ------
        ArmError
            If the arm is not homed: the weight follows the angle to the horizon.
        """
        self._must_have_plain_motors()
        return measuring.weigh(self)

    def use(self, joint: int, calibration: MotorCalibration) -> None:
        """Tell the controller what was measured of a motor."""
        for name, value in (
            ("k", calibration.speed_per_volt), ("tau", calibration.time_constant_s * 1000),
            ("db+", calibration.ccw.dead_band_v), ("db-", calibration.cw.dead_band_v),
            ("st+", calibration.ccw.starts_at_v), ("st-", calibration.cw.starts_at_v),
        ):  # fmt: skip
            self.set(joint, name, value)

    def command(self, text: str) -> str:
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
        return self.line.exchange(text, self._number)

    def _must_have_plain_motors(self):
        """Refuse what bus servos have no need of, and no command for."""
        if self.name.startswith("feetech://"):
            raise ArmError(
                f"The servos on {self.name} control their motors themselves: there is nothing to push, weigh or calibrate. "
                "Leave this step out; the moves work without it."
            )

    def _switch_on(self):
        stops, status = self._stops.count, self.status()
        if status.state == "stop" and not self._stops.hold:
            raise ArmError(self._why_it_stopped(status) + " When that is mended: arm.enable().")
        if status.state in ("stop", "off"):
            if self._stops.are_news:
                self._tell_of_a_stop()
            self._enable(stops)

    def _enable(self, stops):
        """Switch the motors on, which undoes so many stops and no later one."""
        self.command("EN 1")
        self._stops.undone = stops
        if self._stops.hold:
            self.stop()
            self._tell_of_a_stop()

    def run(self, command: str) -> JointAngles:
        """Start a move, a push or a homing and wait for its end; whatever interrupts the wait stops the motors.

        Parameters
        ----------
        command : str, such as "MV 1 30"

        Returns
        -------
        JointAngles
            Where the joints are then, by their encoders.

        Raises
        ------
        ArmError
            If it is refused, or the arm stops on the way, or does not answer.
        """
        self.line.restarted = False
        try:
            self.command(command)
            status = self._await_end()
        except RefusedError:
            if self._stops.are_news:
                self._tell_of_a_stop()
            raise
        except BaseException as error:
            self._stop_somehow(it_answers=not isinstance(error, ArmError))
            raise
        if self.line.restarted:
            raise ArmError(f"The controller on {self.name} restarted in mid-move; its position is lost. Home it again.")
        if status.fault != "-" or status.state != "idle":
            self._stops.tell()
        if status.fault != "-":
            raise ArmError(self._why_it_stopped(status))
        if status.state != "idle":
            raise ArmError(f"The arm on {self.name} was switched off in mid-move.")
        return JointAngles(*status.position_deg)

    def _await_end(self):
        """Ask until the move has ended; returns the last status."""
        turned_at, stood = self.line.clock(), None
        while (status := self.status()).state in ("run", "home"):
            if status.position_deg != stood:
                turned_at, stood = self.line.clock(), status.position_deg
            elif self.line.clock() - turned_at > STANDSTILL_S:
                self.stop()
                raise ArmError(f"The arm on {self.name} says that it moves, and nothing turns. It was stopped.")
            self.line.listen(ASK_S)
        return status

    def _stop_somehow(self, it_answers):
        """Stop an arm in mid-move, one that does not answer as well. Never raises."""
        if self.line.restarted:
            return  # its motors are off, and its new start should not begin with a stop
        try:
            if it_answers:
                self.stop()
            else:
                self._stops.ask()
                self.line.write(STOP_BYTES)
        except ArmError as error:
            log.info("%s could not be told to stop (%s); its watchdog stops it.", self.name, error)

    def _tell_of_a_stop(self):
        """Once to every thread: whoever moves the arm again after that wants to."""
        self._stops.tell()
        raise ArmError(f"The arm on {self.name} was stopped by another part of this program.")

    def _why_it_stopped(self, status):
        kind, joint = status.fault[0], status.fault[1:]
        who = f"Joint {joint} of the arm on {self.name}" if joint else f"The arm on {self.name}"
        return f"{who} {FAULTS.get(kind, 'was stopped.')}"

    def _greet(self):
        """Agree on checksums, and see who is there."""
        self.line.write(b"\n")
        self.line.exchange("CS 1", None, self.line.wait_for_answer_s())
        identity = self.command("ID")
        if not identity.startswith("armkit 1 "):
            raise ArmError(f"Something else is at {self.name}: it calls itself {identity!r}, not armkit 1.")
        self.line.restarted = False
        self._read_bounds()

    def _read_bounds(self):
        self.limits_deg = tuple((self.get(j, "lo"), self.get(j, "hi")) for j in (1, 2))
        self.supply_v = tuple(self.get(j, "supply") for j in (1, 2))


def _must_be_joint(joint):
    if not isinstance(joint, Integral) or joint not in (1, 2):
        raise StereoLabError(f"Expected joint 1 or 2, got {joint!r}.")


def _decimal(value):
    return f"{float(value):.4f}".rstrip("0").rstrip(".")

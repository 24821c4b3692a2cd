"""A serial line with a controller at its other end: questions, answers, and what to make of silence and noise."""

from __future__ import annotations

import errno
import os
import threading
import time
from collections import deque
from dataclasses import dataclass
from numbers import Integral

import serial
from serial.tools import list_ports

from stereo_lab.arm import protocol as wire
from stereo_lab.errors import ArmError, RefusedError, StereoLabError

for scheme in ("virtual", "feetech"):
    if f"stereo_lab.arm.{scheme}" not in serial.protocol_handler_packages:
        serial.protocol_handler_packages.append(f"stereo_lab.arm.{scheme}")  # where pyserial finds its ports

ANSWER_S = 0.3  # a command that is not answered so long is sent again
GIVE_UP_S = 0.9  # and after so long it has failed
BOOT_S = 2.5  # a board on USB restarts when its port is opened
AGAIN_S = 0.05  # where noise is heard it is sent again so soon
LOOK_S = 0.02  # how long one look at the port lasts
SHORTEST_REPLY, SHORTEST_STATUS = len("ok*ABCD\n"), len("<off t=0 h=0 f=- p=0.00,0.00 v=0,0 lost=0 drop=0*ABCD>\n")
ROUNDING_S = 1e-6
NETWORKS = ("socket://", "rfc2217://")
MEANING = {
    wire.COMMAND: "there is no such command", wire.ARGUMENT: "an argument is missing or is not what it should be",
    wire.LIMIT: "the value is beyond its limits", wire.OFF: "the motors are off: arm.enable()",
    wire.BUSY: "the joint is moving",
}  # fmt: skip


def ports() -> list[tuple[str, str]]:
    """The serial ports of this computer.

    Returns
    -------
    list of (name, description)
        The virtual arm first; it is always there.
    """
    found = sorted((p.device, _described(p)) for p in list_ports.comports())
    return [("virtual://arm", "a simulated arm, no hardware needed"), *found]


def _described(port):
    """A port's own words, and what is likely behind it: two chips of one maker serve boards and servo adapters."""
    kind = {
        (0x1A86, 0x55D3): f" (bus servos: feetech://{port.device})",
        (0x1A86, 0x7523): f" (an Arduino; or bus servos: feetech://{port.device})",
    }
    return f"{port.description}{kind.get((port.vid, port.pid), '')}"


def open_port(name: str, baud_rate: int = wire.BAUD_RATE) -> serial.SerialBase:
    """Open a serial port by its name or URL, for this program alone.

    Raises
    ------
    ArmError
        If there is none, or another program has it.
    StereoLabError
        If the baud rate is none.
    """
    if not isinstance(baud_rate, Integral) or baud_rate <= 0:
        raise StereoLabError(f"Expected a baud rate as a whole number, such as {wire.BAUD_RATE}; got {baud_rate!r}.")
    try:
        return serial.serial_for_url(name, baudrate=baud_rate, timeout=LOOK_S, write_timeout=1, exclusive=True)
    except (serial.SerialException, ValueError, OSError) as error:
        raise ArmError(_why_not(name, error)) from None


def _device(name):
    """A port by its one name: links followed, Windows in capitals, a Mac's tty as its cu."""
    return os.path.realpath(name).upper().replace("/DEV/TTY.", "/DEV/CU.")


def _why_not(name, error):
    number = getattr(error, "errno", None)
    if number in (errno.EBUSY, errno.EAGAIN):
        return f"{name} is in use. Close whatever else has it open: another notebook, the Arduino IDE's monitor."
    if number == errno.EACCES or "PermissionError" in str(error):
        return f"{name} may not be opened by this user, or is in use. On Linux join the group dialout and log in again."
    if str(error).startswith(("virtual://", "servo", "expected")):
        return f"{name}: {error}." if name.startswith("feetech:") else f"{error}."
    if name.removeprefix("feetech://").startswith(NETWORKS):
        return f"Nobody listens at {name}. Is its name right, and does the program run there that serves the arm?"
    there = ", ".join(port for port, _ in ports())
    return f"There is no port {name} here. There are: {there}. Is the cable plugged in at both ends?"


@dataclass
class Heard:
    """What came since the last question.

    Attributes
    ----------
    bytes, garbled : int, bytes that came, and lines that made no sense
    other : int, replies to other commands
    misheard : int, how often the controller said that what it heard made no sense
    """

    bytes: int = 0
    garbled: int = 0
    other: int = 0
    misheard: int = 0


class SerialLine:
    """An open port and the protocol on it. Every line carries a checksum.

    Attributes
    ----------
    port : the pyserial port
    name : str
    clock : function, seconds; the arm's own clock where it has one
    events : deque of Event, the newest last
    restarted : bool, whether the controller has said its greeting since this was set to False
    closing : bool, whether the port was closed from this side, or is just about to be
    """

    def __init__(self, port: serial.SerialBase) -> None:
        self.port = port
        self.name = str(getattr(port, "name", None) or getattr(port, "port", "the port"))
        self.clock = getattr(port, "clock", time.monotonic)
        self.events: deque[wire.Event] = deque(maxlen=100)
        self.restarted = self.closing = False
        self._lock = threading.RLock()  # one question at a time; a stop does not wait for it
        self._replies: deque[wire.Reply] = deque()
        self._status: wire.Status | None = None
        self._buffer, self._heard = bytearray(), Heard()

    def wait_for_answer_s(self) -> float:
        """How long a controller may take for its first answer."""
        usb = [p.device for p in list_ports.comports() if p.vid is not None]
        return BOOT_S if _device(self.name) in map(_device, usb) else GIVE_UP_S

    def write(self, data: bytes) -> None:
        """Bytes to the controller."""
        try:
            self.port.write(data)
        except (serial.SerialException, OSError, TypeError) as error:  # TypeError: of a port that is half closed
            raise self._gone(error) from None

    def close(self) -> None:
        """Close the port. Who waits for an answer in another thread is told that it was closed, and not that it is gone."""
        self.closing = True
        self.port.close()

    def exchange(self, text: str, number: int | None, give_up_s: float = GIVE_UP_S) -> str:
        """Send a command until it is answered: again after 0.3 s, and sooner where noise was heard.

        Returns
        -------
        str, the data of its ``ok``

        Raises
        ------
        RefusedError, ArmError
            If it is refused; if it is not answered in time.
        """
        data = wire.encode_command(text, number)
        with self._lock:
            self._heard = Heard()
            for until in self._tries(give_up_s):
                self.write(data)
                reply = self._await_reply(number, until)
                if reply is None:
                    continue
                if reply.number is None and reply.code in wire.UNNUMBERED:
                    self._heard.misheard += 1
                    continue
                if reply.code:
                    meaning = MEANING.get(reply.code, wire.ERRORS[reply.code])
                    raise RefusedError(f"The arm refused {text!r}: error {reply.text} ({meaning}).")
                return reply.text
            raise self.no_answer(repr(text))

    def status(self) -> wire.Status:
        """Ask until a status comes."""
        with self._lock:
            for until in self._tries(GIVE_UP_S):
                status = self.status_once(until)
                if status is not None:
                    return status
            raise self.no_answer("a question")

    def status_once(self, until: float) -> wire.Status | None:
        """Ask once; None if nothing readable comes until then."""
        with self._lock:
            self._status, self._heard = None, Heard()
            self.write(b"\n" + wire.ASK + b"\n")
            while self._status is None and not self._heard.garbled and self.clock() < until - ROUNDING_S:
                self._look(until, SHORTEST_STATUS)
            return self._status

    def listen(self, seconds: float) -> None:
        """Take in what comes for some time."""
        until = self.clock() + seconds
        while self.clock() < until - ROUNDING_S:
            with self._lock:
                self._look(until)

    def no_answer(self, what: str) -> ArmError:
        """The error for a question that got no answer, by what was heard instead."""
        heard = self._heard
        if self.restarted:
            return ArmError(
                f"The controller on {self.name} restarted; its position is lost. Connect and home it again."
            )
        if heard.other:
            return ArmError(
                f"{self.name} answers other commands than {what}. Unplug the arm, plug it in, connect anew."
            )
        if heard.misheard:
            return ArmError(
                f"{self.name} hears noise: {heard.misheard} times in a row {what} arrived garbled. Keep the cable away "
                "from the motors' wires, and take a shorter one."
            )
        if heard.bytes:
            return ArmError(
                f"{self.name} sends {heard.bytes} bytes that make no sense after {what}: noise on the cable, another "
                f"device, or a wrong baud rate (the arm has {wire.BAUD_RATE})."
            )
        return ArmError(
            f"{self.name} does not answer {what}. Is the controller powered, and is it this port? "
            "The ports there are: stereo-lab arm list"
        )

    def _tries(self, give_up_s):
        """Until when each try waits for its answer. It may end sooner, but the next one does not follow at once."""
        give_up = self.clock() + give_up_s
        while (start := self.clock()) < give_up:
            yield min(start + ANSWER_S, give_up)
            self.listen(start + AGAIN_S - self.clock())

    def _await_reply(self, number, until):
        """The reply to a number; None as soon as something garbled came, or when the time is over."""
        garbled = self._heard.garbled
        while True:
            while self._replies:
                reply = self._replies.popleft()
                if reply.number == number or (reply.number is None and reply.code):
                    return reply
                self._heard.other += 1
            if self._heard.garbled > garbled or self.clock() >= until - ROUNDING_S:
                return None
            self._look(until, SHORTEST_REPLY)

    def _look(self, until, shortest=1):
        """Read what is there, or wait a little for it; to be woken for each byte of a line that cannot be shorter is dear."""
        try:
            self.port.timeout = max(min(LOOK_S, until - self.clock()), 0)
            data = self.port.read(max(1, self.port.in_waiting, shortest - len(self._buffer)))
        except (serial.SerialException, OSError, TypeError) as error:
            raise self._gone(error) from None
        self._heard.bytes += len(data)
        self._buffer += data
        while (end := self._buffer.find(b"\n")) >= 0:
            text = self._buffer[:end].decode("latin-1").strip("\r")
            del self._buffer[: end + 1]
            self._take(text)
        if len(self._buffer) > 4 * wire.LINE_MAX:  # no line is so long: noise, or a wrong baud rate
            self._buffer.clear()
            self._heard.garbled += 1

    def _take(self, text):
        if not text:
            return
        text, right = wire.unseal(text)
        if right is None and text == wire.GREETING:
            self.restarted = True
            return
        answer = wire.decode_answer(text) if right else None
        if answer is None:
            self._heard.garbled += 1
        elif isinstance(answer, wire.Reply):
            self._replies.append(answer)
        elif isinstance(answer, wire.Status):
            self._status = answer
        else:
            self.events.append(answer)

    def _gone(self, error):
        if self.closing or not self.port.is_open:
            return ArmError(
                f"The connection to {self.name} was closed. Make a new one with connect(...), and home the arm."
            )
        if self.name.startswith("feetech://"):
            return ArmError(
                f"{self.name} is gone ({error}). A servo that still hears is switched off, and its joint sinks; one that does not goes "
                "on to its goal and holds it. Cut the supply if it must not, plug it in again and connect anew."
            )
        return ArmError(
            f"{self.name} is gone ({error}). The arm stops by itself: at its goal, by its watchdog, or because it "
            "lost its power. Plug it in again, connect anew and home it."
        )

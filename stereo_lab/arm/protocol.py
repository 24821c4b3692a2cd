"""The serial protocol of the arm: bytes to meaning and back, nothing else.

It is specified in ``stereo_lab/firmware/PROTOCOL.md``.
"""

from __future__ import annotations

import binascii
import math
import re
from dataclasses import dataclass

from stereo_lab.errors import StereoLabError

BAUD_RATE = 115200
LINE_MAX = 63  # characters of a command line, without its newline
NUMBER_MAX = 9999  # sequence numbers go from 1 to here
TIME_MS = 2**31  # a controller's time begins again here
GREETING = "armkit 1 ready"
IDENTITY = "armkit 1 joints=2 hz=500"
STOP, ASK = b"!", b"?"  # real-time: acted on at once, as the first byte of a line

CHECKSUM, COMMAND, ARGUMENT, LIMIT, OFF, TOO_LONG, OVERRUN, BUSY = range(1, 9)
ERRORS = {
    CHECKSUM: "checksum", COMMAND: "command", ARGUMENT: "argument", LIMIT: "limit", OFF: "off",
    TOO_LONG: "too long", OVERRUN: "overrun", BUSY: "busy",
}  # fmt: skip
UNNUMBERED = (CHECKSUM, TOO_LONG, OVERRUN)  # lines that were not read at all; they may be sent again
EVENTS = ("done", "stall", "home", "limit", "runaway", "watchdog", "estop")
STATES = ("off", "idle", "run", "home", "stop")
# Parameters of a joint: smallest and largest value that SET takes
PARAMETERS = {
    "lo": (-360, 360), "hi": (-360, 360), "home": (-360, 360), "cruise": (1, 720), "acc": (10, 4000),
    "k": (10, 2000), "tau": (5, 1000), "db+": (0, 24), "db-": (0, 24), "st+": (0, 24), "st-": (0, 24),
    "zone": (0, 180), "counts": (16, 65535), "supply": (1, 24), "g1": (-24, 24), "g2": (-24, 24),
}  # fmt: skip
HELD = "held"  # what holds a joint in its place, volts: GET alone
NUMBER = re.compile(r"-?\d{1,7}(\.\d{1,6})?")
MINUSES = "\u2212\u2013\u2014"  # of a printed page: they look like the keyboard's
NO_CHARACTER = re.compile(r"[^\t -~]")


@dataclass(frozen=True)
class Command:
    """A command line.

    Attributes
    ----------
    number : int, its sequence number, or None
    name : str, in capitals
    arguments : their texts
    """

    number: int | None
    name: str
    arguments: tuple[str, ...]


@dataclass(frozen=True)
class Reply:
    """An answer to a command.

    Attributes
    ----------
    code : int, 0 for ``ok``, else the number of the error
    text : str, the data of an ``ok``, else code and name of the error
    number : int, of the command, or None
    """

    code: int
    text: str
    number: int | None = None


@dataclass(frozen=True)
class Event:
    """Something that happened.

    Attributes
    ----------
    name : str, one of EVENTS
    joint, angle_deg : 1 or 2, and where it stands; None for what concerns both
    """

    name: str
    joint: int | None = None
    angle_deg: float | None = None


@dataclass(frozen=True)
class Status:
    """What the controller says of itself.

    Attributes
    ----------
    state : one of STATES
    time_ms : int, since it started
    homed : (bool, bool), whether each joint knows where it stands
    fault : str, "-" or what stopped the last move: s1, s2 (stall), r1, r2 (runaway), w (watchdog), e (stop)
    position_deg, speed_deg_s : (float, float)
    lost, dropped : int, encoder edges missed and reports left out
    """

    state: str
    time_ms: int
    homed: tuple[bool, bool]
    fault: str
    position_deg: tuple[float, float]
    speed_deg_s: tuple[float, float]
    lost: int = 0
    dropped: int = 0


class ProtocolError(StereoLabError):
    """A line that cannot be acted on. ``code`` is one of the error numbers above."""

    def __init__(self, code: int, number: int | None = None) -> None:
        super().__init__(ERRORS[code])
        self.code, self.number = code, number


def crc16(data: bytes) -> int:
    """CRC-16/CCITT-FALSE: polynomial 0x1021, start 0xFFFF; of b"123456789" it is 0x29B1."""
    return binascii.crc_hqx(data, 0xFFFF)


def seal(text: str) -> str:
    """Append ``*`` and the checksum of all that stands before it, as four hexadecimal digits."""
    return f"{text}*{crc16(text.encode('ascii')):04X}"


def unseal(line: str) -> tuple[str, bool | None]:
    """The text of a line, and whether its checksum is right (None: it has none)."""
    text, star, digits = line.rpartition("*")
    if not star:
        return line, None
    try:
        right = re.fullmatch("[0-9A-F]{4}", digits) is not None and int(digits, 16) == crc16(text.encode("ascii"))
    except UnicodeEncodeError:
        right = False
    return text, right


def encode_command(text: str, number: int | None = None, checksum: bool = True) -> bytes:
    """A command line as bytes, newline included.

    Parameters
    ----------
    text : str, such as "MV 1 30"
    number : int from 1 to NUMBER_MAX, or None

    Raises
    ------
    StereoLabError
        If it is no text, would be longer than LINE_MAX, or is not plain ASCII on one line.
    """
    if not isinstance(text, str):
        raise StereoLabError(f'A command is a line in quotes, such as "MV 2 -30"; got {text!r}.')
    line = text.strip() if number is None else f"N{number} {text.strip()}"
    for sign in line:
        if not sign.isascii() or not sign.isprintable() or sign == "*":
            why = "; the minus of the keyboard is -" if sign in MINUSES else ""
            raise StereoLabError(
                f"A command is one line of plain letters without *; got {text!r}, and {sign!r} in it is none{why}."
            )
    line = seal(line) if checksum else line
    if len(line) > LINE_MAX:
        raise StereoLabError(f"A command has {LINE_MAX} characters at most; this line has {len(line)}: {line!r}.")
    return line.encode("ascii") + b"\n"


def decode_command(line: str, checksum_needed: bool = False) -> Command | None:
    """What a controller reads from a line (str, without its newline).

    Returns
    -------
    Command or None
        None for an empty line.

    Raises
    ------
    ProtocolError
        With the error number that the controller answers.
    """
    if len(line) > LINE_MAX:
        raise ProtocolError(TOO_LONG)
    text, right = unseal(line)
    if right is False or NO_CHARACTER.search(line) or (right is None and checksum_needed and text.strip()):
        raise ProtocolError(CHECKSUM)
    words = text.split()
    number = None
    if words and re.fullmatch(r"N\d{1,4}", words[0]):
        number = int(words.pop(0)[1:])
    if not words:
        if number is None:
            return None
        raise ProtocolError(COMMAND, number)
    return Command(number, words[0].upper(), tuple(words[1:]))


def read_number(word: str, low: float, high: float, number: int | None = None) -> float:
    """A plain decimal number between two bounds, or the error that the controller answers."""
    if not NUMBER.fullmatch(word):
        raise ProtocolError(ARGUMENT, number)
    value = float(word)
    if not low <= value <= high:
        raise ProtocolError(LIMIT, number)
    return value


def encode_reply(reply: Reply) -> str:
    """A reply as text, without checksum and newline."""
    head = "ok" if reply.code == 0 else "err"
    number = "" if reply.number is None else f" N{reply.number}"
    body = reply.text if reply.code == 0 else f"{reply.code} {ERRORS[reply.code]}"
    return f"{head}{number} {body}".rstrip()


def encode_event(event: Event) -> str:
    """An event as text."""
    if event.joint is None:
        return f"!{event.name}"
    return f"!{event.name} {event.joint} {event.angle_deg:.2f}"


def encode_status(status: Status) -> str:
    """A status as text."""
    homed = sum(1 << k for k in range(2) if status.homed[k])
    p, v = status.position_deg, status.speed_deg_s
    return (
        f"<{status.state} t={status.time_ms % TIME_MS} h={homed} f={status.fault} p={p[0]:.2f},{p[1]:.2f} "
        f"v={v[0]:.0f},{v[1]:.0f} lost={status.lost} drop={status.dropped}>"
    )


REPLY = re.compile(r"(ok|err)(?: N(\d{1,4}))?(?: (.*))?")
EVENT = re.compile(r"!([a-z]+)(?: ([12]) (-?\d+\.\d+))?")
PAIR = r"(-?[\d.]+),(-?[\d.]+)"
STATUS = re.compile(rf"<([a-z]+) t=(\d+) h=([0-3]) f=(-|[sr][12]|[we]) p={PAIR} v={PAIR} lost=(\d+) drop=(\d+)>")


def inwards(name: str, limit_deg: float) -> float:
    """A limit, "lo" or "hi", to the thousandth of a degree that a controller tells, and never beyond what was meant."""
    return (math.floor if name == "hi" else math.ceil)(round(1000 * limit_deg, 3)) / 1000


def decode_answer(line: str) -> Reply | Event | Status | None:
    """What a host reads from a line (str, checksum already taken off).

    Returns
    -------
    Reply, Event, Status, or None
        None for a line that is none of these.
    """
    if found := REPLY.fullmatch(line):
        kind, number, text = found.groups()
        number = None if number is None else int(number)
        if kind == "ok":
            return Reply(0, text or "", number)
        code = re.match(r"([1-8]) ", (text or "") + " ")
        return None if code is None else Reply(int(code.group(1)), text, number)
    if found := STATUS.fullmatch(line):
        state, time_ms, homed, fault, p1, p2, v1, v2, lost, dropped = found.groups()
        if state not in STATES:
            return None
        try:
            position, speed = (float(p1), float(p2)), (float(v1), float(v2))
        except ValueError:
            return None
        joints = bool(int(homed) & 1), bool(int(homed) & 2)
        return Status(state, int(time_ms), joints, fault, position, speed, int(lost), int(dropped))
    if (found := EVENT.fullmatch(line)) and found.group(1) in EVENTS:
        name, joint, angle = found.groups()
        return Event(name, None if joint is None else int(joint), None if angle is None else float(angle))
    return None

"""Frames of Feetech's STS bus: bytes in, bytes out, nothing else.

    FF FF id length instruction parameters… checksum        to a servo
    FF FF id length error       parameters… checksum        from it

Little-endian; the length counts what follows it; the checksum is what makes the sum of all behind FF FF end in FF.
Source: Feetech's protocol manual (ft-scs, "STS/SMS series").
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

PING, READ, WRITE, SYNC_WRITE = 0x01, 0x02, 0x03, 0x83
EVERYBODY = 0xFE  # an id that all of them obey and none answers to
LARGEST_ID = 0xFD
HEADER = b"\xff\xff"
LONGEST = 90  # the whole table of a servo is shorter
ERRORS = {0x01: "its voltage", 0x02: "its encoder", 0x04: "its temperature", 0x08: "its current", 0x20: "its load"}


@dataclass(frozen=True)
class Answer:
    """What a servo sent.

    Attributes
    ----------
    id : int
    error : int, bits of :data:`ERRORS`: how it is, not whether it understood
    data : bytes
    """

    id: int
    error: int
    data: bytes


def checksum(body: bytes) -> int:
    """Of all that stands between FF FF and it."""
    return ~sum(body) & 0xFF


def frame(id: int, instruction: int, parameters: bytes = b"") -> bytes:
    """An instruction as bytes.

    Raises
    ------
    ValueError
        If two FF stand in a row inside: a servo would take them for the beginning of another frame.
    """
    body = bytes([id, len(parameters) + 2, instruction]) + parameters
    body += bytes([checksum(body)])
    if HEADER in body:
        raise ValueError(f"two FF in a row would break the frame: {body.hex(' ')}")
    return HEADER + body


def read_frame(id: int, address: int, count: int) -> bytes:
    """Ask one servo for some bytes of its table."""
    return frame(id, READ, bytes([address, count]))


def write_frame(id: int, address: int, data: bytes) -> bytes:
    """Write some bytes into the table of one servo, or of all."""
    return frame(id, WRITE, bytes([address]) + data)


def sync_write_frame(address: int, data: Mapping[int, bytes]) -> bytes:
    """Write bytes into several servos at once, equally many each; nobody answers."""
    lengths = {len(part) for part in data.values()}
    if len(lengths) != 1:
        raise ValueError(f"equally many bytes for each servo; got {sorted(lengths)}")
    parts = b"".join(bytes([id]) + part for id, part in data.items())
    return frame(EVERYBODY, SYNC_WRITE, bytes([address, lengths.pop()]) + parts)


def take_answer(heard: bytearray) -> Answer | None:
    """The first whole answer in what was heard, taken out of it; noise before it is thrown away.

    Returns
    -------
    Answer or None
        None where nothing whole is there yet.
    """
    while (start := heard.find(HEADER)) >= 0:
        del heard[:start]
        while heard[2:3] == b"\xff":  # more FF than two in front
            del heard[0]
        if len(heard) >= 4 and heard[3] > LONGEST:
            del heard[:2]  # no frame begins here
            continue
        if len(heard) < 4 or len(heard) < heard[3] + 4:
            return None
        length = heard[3]
        body, given = bytes(heard[2 : length + 3]), heard[length + 3]
        if length >= 2 and checksum(body) == given:
            del heard[: length + 4]
            return Answer(body[0], body[2], body[3:])
        del heard[:2]
    del heard[: max(len(heard) - 1, 0)]
    return None


def word(value: int, sign_bit: int = 15) -> bytes:
    """A number in two bytes: its size, and its sign as one bit."""
    size = abs(value)
    if size >= 1 << sign_bit:
        raise ValueError(f"{value} does not fit below bit {sign_bit}")
    return (size | (value < 0) << sign_bit).to_bytes(2, "little")


def number(data: bytes, sign_bit: int = 15) -> int:
    """What :func:`word` wrote."""
    value = int.from_bytes(data[:2], "little")
    size = value & ((1 << sign_bit) - 1)
    return -size if value >> sign_bit & 1 else size


def what_is_wrong(error: int) -> str:
    """The error bits of an answer in words; empty where there is none."""
    return ", ".join(name for bit, name in ERRORS.items() if error & bit)

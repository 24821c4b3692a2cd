"""The serial protocol as pure functions: bytes to meaning and back."""

import numpy as np
import pytest

from stereo_lab.arm import protocol as wire
from stereo_lab.errors import StereoLabError


def crc_bit_by_bit(data):
    """CRC-16/CCITT-FALSE as it stands in books, written apart from the library's."""
    value = 0xFFFF
    for byte in data:
        value ^= byte << 8
        for _ in range(8):
            value = ((value << 1) ^ 0x1021 if value & 0x8000 else value << 1) & 0xFFFF
    return value


def test_crc_has_its_check_value():
    assert wire.crc16(b"123456789") == 0x29B1
    data = np.random.default_rng(0).bytes(50)
    assert wire.crc16(data) == crc_bit_by_bit(data)


def test_command_round_trip():
    line = wire.encode_command("mv 1 -30.5", 17)
    assert line.startswith(b"N17 mv 1 -30.5*") and line.endswith(b"\n")
    assert wire.decode_command(line.decode()[:-1], True) == wire.Command(17, "MV", ("1", "-30.5"))
    assert wire.decode_command("ID") == wire.Command(None, "ID", ())
    assert wire.decode_command("") is None


def test_every_flipped_bit_of_a_sealed_line_is_seen():
    line = wire.encode_command("MA 12.345 -67.890", 1234)[:-1]
    for position in range(len(line)):
        for bit in range(8):
            broken = bytearray(line)
            broken[position] ^= 1 << bit
            with pytest.raises(wire.ProtocolError):
                wire.decode_command(broken.decode("latin-1"), True)


@pytest.mark.parametrize(
    ("line", "code"),
    [
        ("ID*0000", wire.CHECKSUM), ("ID*", wire.CHECKSUM), ("ID*12", wire.CHECKSUM), ("x" * 64, wire.TOO_LONG),
        ("N12", wire.COMMAND), ("é*FFFF", wire.CHECKSUM),
    ],
)  # fmt: skip
def test_lines_that_cannot_be_acted_on(line, code):
    with pytest.raises(wire.ProtocolError) as caught:
        wire.decode_command(line)
    assert caught.value.code == code


def test_a_checksum_can_be_demanded():
    assert wire.decode_command("ID").name == "ID"
    with pytest.raises(wire.ProtocolError, match="checksum"):
        wire.decode_command("ID", checksum_needed=True)


@pytest.mark.parametrize("bad", ["ID\nEN 1", "ID*", "größer", "x" * 60, "\x00"])
def test_commands_that_would_not_be_one_line_are_refused(bad):
    with pytest.raises(StereoLabError):
        wire.encode_command(bad, 1)


@pytest.mark.parametrize(
    "text, says",
    [
        ("MV 2 \u221230", "'\u2212' in it is none; the minus of the keyboard is -"),
        ("MV 2 30°", "'°' in it"),
        (5, "in quotes.*got 5"),
    ],
)
def test_what_is_wrong_in_a_command_is_named(text, says):
    with pytest.raises(StereoLabError, match=says):
        wire.encode_command(text, 1)


@pytest.mark.parametrize("word", ["nan", "inf", "1e3", "", "-", "1.", ".5", "12345678", "0x1", "1,5", "--1"])
def test_only_plain_decimal_numbers_are_read(word):
    with pytest.raises(wire.ProtocolError, match="argument"):
        wire.read_number(word, -1e9, 1e9)


def test_numbers_have_bounds():
    assert wire.read_number("-12.5", -20, 20) == -12.5
    with pytest.raises(wire.ProtocolError, match="limit"):
        wire.read_number("21", -20, 20)


@pytest.mark.parametrize(
    "reply", [wire.Reply(0, "", 3), wire.Reply(0, "200.000", 9999), wire.Reply(0, ""), wire.Reply(4, "4 limit", 7)]
)
def test_reply_round_trip(reply):
    assert wire.decode_answer(wire.encode_reply(reply)) == reply


def test_event_and_status_round_trip():
    for event in (wire.Event("done", 1, -30.25), wire.Event("watchdog"), wire.Event("runaway", 2, 4.5)):
        assert wire.decode_answer(wire.encode_event(event)) == event
    status = wire.Status("run", 123456, (True, False), "s2", (-12.25, 150.0), (-180.0, 3.0), 2, 5)
    assert wire.decode_answer(wire.encode_status(status)) == status
    assert len(wire.seal(wire.encode_status(status))) < 100


def test_the_time_begins_again():
    status = wire.Status("idle", 2147483647 + 2, (True, True), "-", (0.0, 0.0), (0.0, 0.0))
    assert wire.encode_status(status).startswith("<idle t=1 h=3")


@pytest.mark.parametrize("line", ["", "okay", "err 9 new", "!bang", "<walk t=1>", "done", "<run t=1 h=9 f=- p=1"])
def test_lines_that_are_no_answers(line):
    assert wire.decode_answer(line) is None

"""Bus servos: frames byte for byte, as Feetech's manual and its public Python packages write them."""

import threading
import time

import numpy as np
import pytest
import serial
from servo_twin import Twin, TwinPort

from stereo_lab.arm import connect, line
from stereo_lab.arm.feetech import packets, port, servos
from stereo_lab.arm.feetech.bus import Bus
from stereo_lab.arm.feetech.packets import (
    Answer,
    frame,
    number,
    read_frame,
    sync_write_frame,
    take_answer,
    word,
    write_frame,
)
from stereo_lab.arm.feetech.setup import find, set_up
from stereo_lab.arm.protocol import decode_answer
from stereo_lab.arm.virtual.interpreter import TX_BYTES
from stereo_lab.cli import main
from stereo_lab.errors import ArmError, UnreachableTargetError
from stereo_lab.kinematics import JointAngles


@pytest.mark.parametrize(("made", "bytes_"), [
    (frame(1, packets.PING), "FF FF 01 02 01 FB"), (read_frame(1, 56, 2), "FF FF 01 04 02 38 02 BE"), (read_frame(1, 56, 15), "FF FF 01 04 02 38 0F B1"),
    (write_frame(1, 40, b"\1"), "FF FF 01 04 03 28 01 CE"), (write_frame(1, 40, b"\0"), "FF FF 01 04 03 28 00 CF"),
    (write_frame(1, 40, b"\x80"), "FF FF 01 04 03 28 80 4F"), (write_frame(0xFE, 40, b"\0"), "FF FF FE 04 03 28 00 D2"),
    (write_frame(1, 55, b"\0"), "FF FF 01 04 03 37 00 C0"), (write_frame(1, 5, b"\2"), "FF FF 01 04 03 05 02 F0"),
    (write_frame(1, 42, word(2048)), "FF FF 01 05 03 2A 00 08 C4"), (write_frame(1, 46, word(-500)), "FF FF 01 05 03 2E F4 81 53"),
    (write_frame(1, 48, word(500)), "FF FF 01 05 03 30 F4 01 D1"), (write_frame(1, 31, word(-100, 11)), "FF FF 01 05 03 1F 64 08 6B"),
    (write_frame(1, 42, word(2048) + word(0) + word(1000)), "FF FF 01 09 03 2A 00 08 00 00 E8 03 D5"),
    (write_frame(1, 41, b"\x32" + word(2048) + word(0) + word(1000)), "FF FF 01 0A 03 29 32 00 08 00 00 E8 03 A3"),
    (sync_write_frame(42, {1: word(2048), 2: word(1000)}), "FF FF FE 0A 83 2A 02 01 00 08 02 E8 03 52"),
    (sync_write_frame(40, dict.fromkeys(range(1, 7), b"\0")), "FF FF FE 10 83 28 01 01 00 02 00 03 00 04 00 05 00 06 00 30"),
    (sync_write_frame(41, {k: b"\x32" + word(p) + word(0) + word(1000) for k, p in ((1, 2048), (2, 1000))}),
     "FF FF FE 14 83 29 07 01 32 00 08 00 00 E8 03 02 32 E8 03 00 00 E8 03 0A"),
])  # fmt: skip
def test_frames_are_those_of_the_manual_and_of_the_public_packages(made, bytes_):
    assert made == bytes.fromhex(bytes_)


@pytest.mark.parametrize(("bytes_", "answer"), [
    ("FF FF 01 02 00 FC", Answer(1, 0, b"")), ("FF FF 01 02 20 DC", Answer(1, 0x20, b"")), ("FF FF 01 03 00 79 82", Answer(1, 0, b"\x79")),
    ("FF FF 01 04 00 00 08 F2", Answer(1, 0, b"\0\x08")), ("FF FF 02 04 00 FF 07 F3", Answer(2, 0, b"\xff\x07")),
    ("FF FF 01 11 00 00 08 64 80 2C 04 79 1E 00 00 01 00 08 0A 80 A7", Answer(1, 0, bytes.fromhex("00 08 64 80 2C 04 79 1E 00 00 01 00 08 0A 80"))),
])  # fmt: skip
def test_answers_are_read(bytes_, answer):
    for before in (b"", b"\xff", b"\x12\xff\xff\x01", b"\xff\xff\x01\x02\x00\x00"):  # nothing, or noise in front
        heard = bytearray(before + bytes.fromhex(bytes_) + b"\xff")
        assert take_answer(heard) == answer and heard == b"\xff"


def test_half_an_answer_is_waited_for():
    whole = bytes.fromhex("FF FF 01 04 00 00 08 F2")
    for k in range(len(whole)):
        heard = bytearray(whole[:k])
        assert take_answer(heard) is None
        heard += whole[k:]
        assert take_answer(heard) == Answer(1, 0, b"\0\x08")


def test_noise_never_makes_an_answer_that_was_not_sent():
    """One flipped bit anywhere: nothing, or nothing yet."""
    whole = bytes.fromhex("FF FF 01 04 00 00 08 F2")
    for bit in range(8 * len(whole)):
        hit = bytearray(whole)
        hit[bit // 8] ^= 1 << bit % 8
        assert take_answer(hit) is None
    rng = np.random.default_rng(0)
    heard = bytearray(rng.integers(0, 256, 20_000, dtype=np.uint8).tobytes())
    while take_answer(heard) is not None:
        pass
    assert len(heard) < 260


@pytest.mark.parametrize(
    ("value", "bit"), [(0, 15), (1, 15), (-1, 15), (2047, 11), (-2047, 11), (-1000, 10), (32766, 15)]
)
def test_signs_are_a_bit_of_their_own(value, bit):
    assert number(word(value, bit), bit) == value
    assert word(-200) == bytes.fromhex("C8 80")


def test_what_would_break_a_frame_is_refused():
    with pytest.raises(ValueError, match="two FF"):
        write_frame(1, 42, b"\xff\xff")
    with pytest.raises(ValueError, match="bit 11"):
        word(2048, 11)
    with pytest.raises(ValueError, match="equally many"):
        sync_write_frame(42, {1: b"\0", 2: b"\0\0"})


def test_errors_have_words():
    assert packets.what_is_wrong(0) == "" and packets.what_is_wrong(0x24) == "its temperature, its load"


@pytest.fixture(params=[False, True], ids=["quiet", "echo"])
def wire(request, monkeypatch):
    """Two twins on a wire, the second somewhere else, behind an adapter with or without an echo."""
    twins = TwinPort([Twin(1), Twin(2, 2500)], time.monotonic, request.param)
    monkeypatch.setattr(port, "open_bus", lambda name: twins)
    return twins


def test_servos_report_when_asked_and_know_no_rule(wire):
    with connect("feetech://wire") as arm:
        assert arm.command("MODE pid") == ""
        with pytest.raises(ArmError, match="command"):
            arm.command("MODE rule")
        arm.command("RP 100")
        arm.command("RP 0")


def test_the_same_arm_by_the_same_cells(wire):
    with connect("feetech://wire") as arm:
        assert (
            arm.homed
            and arm.status().state == "off"
            and arm.angles().theta2_deg == pytest.approx(452 * 360 / 4096, abs=0.1)
        )
        reached = arm.move_to(JointAngles(30.0, -45.0))
        assert (reached.theta1_deg, reached.theta2_deg) == pytest.approx((30, -45), abs=0.2)
        assert [t.output - 180 for t in wire.twins.values()] == pytest.approx(
            [30, -45], abs=1.0
        )  # a degree of play, unseen
        assert arm.home() == arm.angles()  # nothing to find, nothing moves
        assert arm.get(1, "counts") == 4096 and arm.get(2, "held") == 0  # what follows a ball asks for it
        with pytest.raises(UnreachableTargetError, match="Joint 1 turns"):
            arm.move_to(JointAngles(200.0, 0.0))
        arm.set_limits(((-20.0, 40.0), (-60.0, 60.0)))
        with pytest.raises(UnreachableTargetError, match="-20 to 40"):
            arm.move_to(JointAngles(41.0, 0.0))
        told = arm.port.servos[0]
        assert told["volts"] == 7.4 and told["celsius"] == 31 and abs(told["load"]) <= 1
    assert [t.table[40] for t in wire.twins.values()] == [0, 0]  # left with torque off


def test_both_arrive_together(wire):
    with connect("feetech://wire") as arm:
        arm.enable()
        arm.command("MA 60 20")
        said = [
            data for data in wire.said if data[4] == packets.SYNC_WRITE and data[5] == servos.RUN and len(data) > 20
        ][-1]
        speeds = [number(said[k : k + 2]) for k in (13, 21)]
        assert speeds[0] != speeds[1] and all(0 < s <= servos.LARGEST_SPEED for s in speeds)
        arm.wait(1.5)
        assert arm.status().state == "idle"


@pytest.mark.parametrize(
    "command", ["PW 1 50 100", "ZE 1 10", "SET 1 k 80", "SET 2 supply 6", "SET 1 counts 500", "GET 1 k"]
)
def test_what_a_servo_cannot_do_is_refused(wire, command):
    with connect("feetech://wire") as arm, pytest.raises(ArmError, match="refused"):
        arm.enable()
        arm.command(command)


def test_what_servos_have_no_need_of_is_told_as_such(wire):
    with connect("feetech://wire") as arm:
        for ask in (arm.weigh, lambda: arm.calibrate(1), lambda: arm.push(1, 1.0, 0.2)):
            with pytest.raises(ArmError, match="nothing to push, weigh or calibrate. Leave this step out"):
                ask()
        assert arm.status().state == "off"


def test_a_joint_that_is_held_up_is_a_stall(wire):
    with connect("feetech://wire") as arm:
        wire.twins[1].held = True
        with pytest.raises(ArmError, match="Joint 1 .* is stalled"):
            arm.move_to(JointAngles(60.0, 0.0))
        assert number(wire.twins[1].table[42:44]) == pytest.approx(
            wire.twins[1].position, abs=2
        )  # its goal is where it is
        wire.twins[1].held = False
        assert arm.move_to(JointAngles(0.0, 0.0)).theta1_deg == pytest.approx(0, abs=0.2)


def test_a_joint_that_is_held_up_while_it_follows_is_a_stall_and_is_held():
    stand = Stand("EN 1")
    stand.twins[0].held, begun = True, stand.clock.now
    for k in range(20):
        stand.say(f"MA {5 + k} 0")  # the goal goes on
        stand.live(0.03)
        if stand.controller.fault != "-":
            break
    assert stand.controller.fault == "s1" and servos.STUCK_S < stand.clock.now - begun < 2 * servos.STUCK_S
    assert stand.torque == [1, 1] and number(stand.twins[0].table[42:44]) == servos.MIDDLE


def test_a_joint_that_follows_a_goal_which_hardly_moves_is_no_stall():
    stand = Stand("EN 1")
    goals = [0.01 * k for k in range(100)] + [1.0] * 50 + [1.0 + 0.5 * k for k in range(20)]  # creeps, rests, goes on
    for goal in goals:
        stand.say(f"MA {goal:.3f} 0")
        stand.live(0.03)
        assert stand.controller.fault == "-"
    assert stand.degrees[0] == pytest.approx(goals[-1], abs=1)


@pytest.mark.parametrize(("address", "value"), [(63, 75), (65, 0x20), (65, 4)])
def test_a_servo_that_is_too_hot_or_overloaded_is_switched_off(wire, monkeypatch, address, value):
    with connect("feetech://wire") as arm:
        arm.enable()
        live = Twin.live

        def worse(twin, seconds):
            live(twin, seconds)
            twin.table[address] = value

        monkeypatch.setattr(Twin, "live", worse)
        time.sleep(0.2)
        assert arm.status().fault == "s1" and arm.status().state == "off"
        assert [t.table[40] for t in wire.twins.values()] == [0, 0]


def test_a_stop_holds_where_it_is_and_latches(wire):
    with connect("feetech://wire") as arm:
        arm.enable()
        arm.command("MV 1 150 20")
        arm.wait(0.3)
        arm.stop()
        here = wire.twins[1].position
        time.sleep(0.2)
        assert wire.twins[1].position == pytest.approx(here, abs=12) and wire.twins[1].table[40] == 1
        with pytest.raises(ArmError):
            arm.command("MV 1 0")
        arm.enable()
        arm.command("MV 1 0")


def test_a_silent_host_is_noticed_and_the_torque_ends(wire):
    with connect("feetech://wire") as arm:
        arm.enable()
        arm.command("WD 300")
        arm.command("MV 1 170 5")
        time.sleep(0.8)
        assert wire.twins[1].table[40] == 0
        assert arm.status().fault == "w"


def test_when_one_servo_is_lost_the_other_lets_go(wire):
    with connect("feetech://wire") as arm:
        arm.enable()
        arm.command("MA 0 170 20")
        one = wire.twins.pop(1)
        with pytest.raises(ArmError, match="is gone"):
            arm.wait(2)
        assert wire.twins[2].table[40] == 0
        wire.twins[2].table[40] = 1  # and when the port is closed it is told once more
    assert wire.twins[2].table[40] == 0 and one.table[40] == 1  # who is off the wire hears nothing


def test_a_garbled_answer_is_asked_for_again(wire):
    with connect("feetech://wire") as arm:
        for _ in range(5):
            wire.noise = 1
            assert arm.angles().theta1_deg == pytest.approx(0, abs=0.1)
            time.sleep(0.05)
        assert arm.status().state == "off"


@pytest.mark.parametrize(
    ("what", "words"), [("silent", "servo 1 does not answer.*goes on to its goal"), ("unplugged", "the device is gone")]
)
def test_a_wire_that_is_lost_is_told(wire, what, words):
    with connect("feetech://wire") as arm:
        arm.enable()
        setattr(wire, what, True)
        with pytest.raises(ArmError, match=words):
            arm.move_to(JointAngles(30.0, 0.0))


def test_an_adapter_that_is_pulled_out_in_mid_move_is_told_and_closes(wire):
    with connect("feetech://wire") as arm:
        arm.enable()
        threading.Timer(0.3, setattr, (wire, "unplugged", True)).start()
        for ask in (lambda: arm.move_to(JointAngles(-100.0, 60.0)), arm.status, arm.stop):
            with pytest.raises(ArmError, match="is gone.*is switched off.*goes on to its goal"):
                ask()
    assert not arm.port.is_open and not wire.is_open


def test_a_servo_that_is_not_there_is_named(monkeypatch):
    monkeypatch.setattr(port, "open_bus", lambda name: TwinPort([Twin(1)], time.monotonic))
    with pytest.raises(ArmError, match="servo 2 does not answer"):
        connect("feetech://wire")
    with pytest.raises(ArmError, match="feetech://PORT"):
        connect("feetech://wire?ids=1")


class Ticking:
    """A clock that goes on by a millisecond with every look at it."""

    def __init__(self):
        self.now = 0.0

    def __call__(self):
        self.now += 0.001
        return self.now


class LosingPort(TwinPort):
    """Of what several are told at once, the frames with these numbers arrive with one bit flipped."""

    lost, told = (), 0

    def write(self, data):
        if data[4] == packets.SYNC_WRITE:
            self.told += 1
            if self.told in self.lost:
                data = data[:-1] + bytes([data[-1] ^ 4])
        return super().write(data)


class Stand:
    """Two twins and their controller, without threads: time passes where it is told to."""

    def __init__(self, *said):
        self.clock = Ticking()
        self.port = LosingPort([Twin(1), Twin(2)], self.clock)
        self.controller = servos.ServoController(Bus(self.port, self.clock), (1, 2), self.clock)
        self.twins = list(self.port.twins.values())
        self.say(*said)

    def say(self, *lines, lost=()):
        """Lines of the host, from now on with these of the frames lost."""
        self.port.told, self.port.lost = 0, lost
        for text in lines:
            self.controller.line.feed(text.encode() + b"\n")

    def live(self, seconds):
        until = self.clock.now + seconds
        while self.clock.now < until:
            self.clock.now += 0.02
            self.controller.is_heard()
            self.controller.look()

    @property
    def degrees(self):
        return [(twin.position - servos.MIDDLE) * servos.STEP_DEG for twin in self.twins]

    @property
    def torque(self):
        return [twin.table[servos.TORQUE] for twin in self.twins]


def test_a_joint_on_a_move_keeps_its_whole_acceleration():
    stand = Stand("EN 1", "MA 90 0")
    stand.live(0.4)
    stand.say(f"MA {stand.degrees[0] + 2:.3f} 90 50")  # joint 1 has next to nothing left to do, and has to brake for it
    whole, quarter = (servos.run_bytes(0, 1, acceleration)[0] for acceleration in (300, 300 / 2**2))
    assert [twin.table[servos.RUN] for twin in stand.twins] == [whole, quarter]  # joint 2 sets off from rest


@pytest.mark.parametrize("lost", [(1,), (2,), (1, 2), (1, 3)])
@pytest.mark.parametrize(("said", "torque"), [("!", [1, 1]), ("ST", [1, 1]), ("EN 1", [1, 1]), ("EN 0", [0, 0])])
def test_a_lost_frame_keeps_nobody_from_stopping(said, torque, lost):
    stand = Stand("EN 1", "MA 90 -60")
    stand.live(0.3)
    before = stand.degrees
    stand.say(said, lost=lost)
    stand.live(2)
    assert stand.degrees == pytest.approx(before, abs=5) and stand.torque == torque


@pytest.mark.parametrize("lost", [(), (1,), (2,), (1, 2)])
def test_switched_on_an_arm_stays_where_a_hand_has_put_it(lost):
    stand = Stand("EN 1", "MA 90 -60")
    stand.live(2)
    stand.say("EN 0")
    for twin in stand.twins:
        twin.position = servos.MIDDLE
    stand.say("EN 1", lost=lost)
    stand.live(2)
    assert stand.degrees == pytest.approx([0, 0], abs=0.2) and stand.torque == [1, 1]


@pytest.mark.parametrize("said", ["EN 1", "EN 0", "!", "ST"])
def test_what_arrives_at_no_try_is_told(said):
    stand = Stand("EN 1", "MA 90 -60")
    stand.live(0.3)
    with pytest.raises(serial.SerialException, match="servo 1 does not do what it is told"):
        stand.say(said, lost=(1, 2, 3))
    stand.controller.let_go()
    assert stand.torque == [0, 0]


def test_no_torque_comes_on_before_the_goal_is_where_the_joint_stands():
    stand = Stand("EN 1", "MA 90 -60")
    stand.live(2)
    stand.say("EN 0")
    stand.twins[0].position = servos.MIDDLE
    with pytest.raises(serial.SerialException):
        stand.say("EN 1", lost=(1, 2, 3))
    assert stand.torque == [0, 0] and stand.degrees[0] == 0


@pytest.mark.parametrize("command", ["EN 1", "EN 0", "ST", "!"])
def test_a_servo_that_does_not_obey_is_told_and_the_other_one_let_go(wire, command):
    with connect("feetech://wire") as arm:
        arm.enable()
        arm.command("MA 170 -150 20")
        wire.twins[1].write = lambda address, data: None  # it answers all the same
        with pytest.raises(ArmError, match="servo 1 does not do what it is told.*is switched off.*goes on to its goal"):
            arm.stop() if command == "!" else arm.command(command)
        assert wire.twins[2].table[servos.TORQUE] == 0


def test_one_that_is_silent_does_not_keep_the_other_one_on():
    stand = Stand("EN 1")
    del stand.port.twins[1]
    with pytest.raises(serial.SerialException, match="servo 1"):
        stand.say("EN 0", lost=(1,))
    assert stand.torque == [1, 0]


def test_a_joint_that_moves_without_a_goal_is_stopped_again():
    stand = Stand("EN 1")
    stand.live(0.1)
    stand.twins[1].put(42, word(3000))
    stand.twins[1].put(46, word(500))
    stand.say("MV 1 30")
    stand.live(2)
    assert 0 < stand.degrees[1] < 5  # and the other one goes on
    assert stand.degrees[0] == pytest.approx(30, abs=0.2) and stand.controller.status().state == "idle"


def test_an_echo_that_comes_late_is_no_answer():
    class Late(TwinPort):
        late = b""

        def write(self, data):
            late, self.late = self.late, b""
            super().write(data)
            self.arrived[:0] = late
            if data[4] == packets.SYNC_WRITE:
                self.late = bytes(self.arrived)
                self.arrived.clear()

    clock = Ticking()
    controller = servos.ServoController(Bus(late := Late([Twin(1), Twin(2)], clock, echo=True), clock), (1, 2), clock)
    controller.line.feed(b"EN 1\nMA 90 -60\n!")
    assert [number(twin.table[42:44]) for twin in late.twins.values()] == pytest.approx([servos.MIDDLE] * 2, abs=50)
    assert controller.status().state == "stop"


def test_a_load_that_moves_a_held_joint_does_not_move_its_goal():
    stand = Stand("EN 1")
    stand.live(0.1)
    stand.port.said.clear()
    stand.twins[0].put(46, word(200))
    for _ in range(10):
        stand.twins[0].position -= 15  # sags, and its servo lifts it again, slowly
        stand.live(0.02)
    assert stand.controller.joints[0].moving and all(data[4] == packets.READ for data in stand.port.said)
    assert number(stand.twins[0].table[42:44]) == servos.MIDDLE


def test_reports_that_nobody_reads_are_left_out_and_counted():
    stand = Stand("RP 20")
    stand.live(60)
    tx = stand.controller.line.tx
    assert len(tx) < TX_BYTES and (dropped := stand.controller.dropped) > 1000
    tx.clear()
    stand.live(0.05)
    assert decode_answer(tx.split(b"\r\n")[0].decode()).dropped == dropped


def test_a_question_that_waits_for_room_is_answered_when_there_is_some():
    stand = Stand("ID", "ID", "??")
    tx = stand.controller.line.tx
    assert b"<" not in tx
    stand.live(0.1)
    assert b"<" not in tx
    tx.clear()
    stand.live(0.1)
    assert tx.count(b"<") == 1  # one for both


def test_setup_writes_only_when_it_may():
    clock = Ticking()
    twins = TwinPort([Twin(1)], clock)
    bus = Bus(twins, clock)
    assert find(bus) == [1]
    before = bytes(twins.twins[1].kept)
    assert not set_up(bus, 2, (-155.0, 155.0), lambda question: False, lambda s: None)
    assert bytes(twins.twins[1].kept) == before
    twins.twins[1].position = 2300.0
    assert set_up(bus, 2, (-155.0, 155.0), lambda question: True, lambda s: None)
    servo = twins.twins[2]
    servo.power_up()  # what was kept is there after a restart
    assert servo.table[5] == 2 and servo.get(16, 2) == 500 and servo.table[55] == 1
    assert [(servo.get(k, 2) - 2048) * 360 / 4096 for k in (9, 11)] == pytest.approx([-155, 155], abs=0.1)
    assert servo.position == 2048


@pytest.mark.parametrize("limits_deg", [(-30.0, 210.0), (-200.0, 100.0), (90.0, -90.0)])
def test_setup_refuses_a_range_that_no_servo_has(limits_deg):
    twins = TwinPort([Twin(1)], Ticking())
    with pytest.raises(ArmError, match=f"within -180 to 180 degrees.*got {limits_deg[0]:g} to {limits_deg[1]:g}"):
        set_up(Bus(twins, twins.clock), 1, limits_deg, lambda question: True, lambda s: None)
    assert twins.said == []
    assert set_up(Bus(twins, twins.clock), 1, (-180.0, 180.0), lambda question: True, lambda s: None)
    assert (twins.twins[1].get(9, 2), twins.twins[1].get(11, 2)) == (0, 4095)


def test_no_limit_reaches_beyond_the_range_of_the_servo_itself(wire):
    wire.twins[1].put(9, word(servos.MIDDLE - 1023) + word(servos.MIDDLE + 1023))  # 89.912 degrees, and a bit
    with connect("feetech://wire") as arm:
        arm.set_limits(((-165.0, 165.0), (-155.0, 155.0)))  # of a recording, say
        assert arm.limits_deg == ((-89.912, 89.912), (-155.0, 155.0))
        with pytest.raises(UnreachableTargetError, match="Joint 1 turns from -89.912 to 89.912 degrees; 120 was asked"):
            arm.move_to(JointAngles(120.0, 0.0))
        with pytest.raises(ArmError, match="beyond its limits"):
            arm.set(1, "lo", 100.0)
        assert arm.move_to(JointAngles(89.912, 0.0)).theta1_deg == pytest.approx(89.9, abs=0.2)


@pytest.mark.parametrize("there", [[], [1, 7]])
def test_setup_wants_one_servo_on_the_wire(there):
    bus = Bus(TwinPort([Twin(k) for k in there], Ticking()), Ticking())
    with pytest.raises(ArmError, match="Expected one servo on the wire"):
        set_up(bus, 1, (-1.0, 1.0), lambda question: True, lambda s: None)


def test_setup_on_the_command_line(monkeypatch, capsys):
    twins = TwinPort([Twin(1)], time.monotonic)
    monkeypatch.setattr(port, "open_bus", lambda name: twins)
    monkeypatch.setattr("builtins.input", lambda question: "n")
    assert main(["arm", "feetech://wire", "setup"]) == 0 and twins.twins[1].table[5] == 1
    assert main(["arm", "virtual://arm", "setup"]) == 2
    assert "Only bus servos" in capsys.readouterr().err


def test_setup_without_its_adapter_is_told(monkeypatch, capsys):
    twins = TwinPort([Twin(1)], time.monotonic)
    twins.unplugged = True
    monkeypatch.setattr(port, "open_bus", lambda name: twins)
    monkeypatch.setattr("builtins.input", lambda question: "y")
    assert main(["arm", "feetech://wire", "setup"]) == 2
    assert "Is the adapter plugged in" in capsys.readouterr().err


def test_the_list_of_ports_tells_servo_adapters(monkeypatch):
    class Info:
        def __init__(self, device, vid, pid):
            self.device, self.description, self.vid, self.pid = device, "USB", vid, pid

    monkeypatch.setattr(line.list_ports, "comports", lambda: [Info("A", 0x1A86, 0x55D3), Info("B", 0x2341, 0x43)])
    assert "feetech://A" in line.ports()[1][1] and "feetech" not in line.ports()[2][1]

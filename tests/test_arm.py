"""The client of the arm: what it does, and what it says when something is wrong. Every fault of the wire once."""

import json
import os
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

from conftest import ROOT
from stereo_lab.arm import connect, line, ports
from stereo_lab.arm import protocol as wire
from stereo_lab.arm.stops import Stops
from stereo_lab.arm.virtual.joint import Joint
from stereo_lab.cli import main
from stereo_lab.errors import ArmError, StereoLabError, UnreachableTargetError
from stereo_lab.kinematics import JointAngles
from stereo_lab.motion import Profile


class ScriptedPort:
    """A port that answers each line by a function: ``answer(text) -> list of lines``; time passes as it is read."""

    is_open, port, name = True, "scripted", None

    def __init__(self, answer):
        self.answer, self.sent, self.out, self.time, self.timeout = answer, [], b"", 0.0, 0.02

    def clock(self):
        return self.time

    @property
    def in_waiting(self):
        return len(self.out)

    def write(self, data):
        for words in data.decode().split("\n"):
            if words:
                text = wire.unseal(words)[0]
                self.sent.append(text)
                for answer in self.answer(text):
                    self.out += answer if isinstance(answer, bytes) else (wire.seal(answer) + "\r\n").encode()

    def read(self, size):
        if not self.out:
            self.time += max(self.timeout, 0.001)
        data, self.out = self.out[:size], self.out[size:]
        self.time += len(data) / 11520
        return data

    def close(self):
        self.is_open = False


def polite(text):
    """What an idle arm answers."""
    if text == "?":
        return ["<idle t=1 h=3 f=- p=0.00,0.00 v=0,0 lost=0 drop=0>"]
    head = "ok " + (text.split()[0] if text.startswith("N") else "")
    data = {"ID": wire.IDENTITY, "lo": "-165", "hi": "165", "supply": "6"}.get(text.split()[-1], "")
    return [f"{head} {data}".strip().replace("  ", " ")]


@pytest.fixture
def arm():
    with connect("virtual://arm") as arm:
        yield arm


def test_connecting_moves_nothing(arm):
    arm.port.sleep(3)
    assert arm.status().state == "off" and arm.angles() == JointAngles(0, 0)
    assert arm.port.link_deg == (0.0, 0.0)


def test_move_to_returns_what_was_reached(arm):
    reached = arm.move_to(JointAngles(30.1, 45.1))
    assert (reached.theta1_deg, reached.theta2_deg) == pytest.approx((30.1, 45.1), abs=0.15)
    assert reached == arm.angles() and reached != JointAngles(30.1, 45.1)  # counts, not wishes


def test_after_homing_the_links_are_where_the_encoders_say(arm):
    arm.home()
    assert arm.homed
    arm.move_to(JointAngles(-50.0, 100.0), one_side=True)
    assert arm.port.link_deg == pytest.approx((-50, 100), abs=0.4)


def test_from_one_side_backlash_does_not_count():
    """Approached from below and from above: plain moves part by the backlash, one-sided ones do not."""
    for seed in range(3):
        with connect(f"virtual://arm?seed={seed}") as arm:
            arm.home()
            for joint in (1, 2):
                arm.calibrate(joint)
            gaps = {}
            for one_side in (False, True):
                places = []
                for start in (-60, 60):
                    arm.move_to(JointAngles(start, start))
                    arm.move_to(JointAngles(10.0, 20.0), one_side=one_side)
                    places.append(arm.port.link_deg)
                gaps[one_side] = np.abs(np.subtract(*places)).max()
            assert gaps[True] < 0.4 < 0.7 < gaps[False]


def test_calibration_makes_moves_exact(arm):
    arm.home()
    arm.move_to(JointAngles(0, 0))
    for joint, motor in ((1, arm.port.motors[0]), (2, arm.port.motors[1])):
        found = arm.calibrate(joint)
        assert found.speed_per_volt == pytest.approx(motor.speed_per_volt, rel=0.05)
        assert arm.get(joint, "k") == pytest.approx(found.speed_per_volt, abs=0.001)
        assert arm.get(joint, "st-") == pytest.approx(found.cw.starts_at_v, abs=0.001)


def test_virtual_time_runs_many_times_faster_than_the_clock(arm):
    start, clock = time.process_time(), arm.port.clock()  # what other programs take does not count
    for angle in (120.0, -120.0) * 5:
        arm.move_to(JointAngles(angle, -angle))
    assert (arm.port.clock() - clock) > 5 * (time.process_time() - start)  # the bench measures 100 and more


def test_realtime_follows_the_clock():
    with connect("virtual://arm?realtime=1") as arm:
        start, clock = time.monotonic(), arm.port.clock()
        arm.move_to(JointAngles(30.0, 0.0))
        assert 0.2 < arm.port.clock() - clock < time.monotonic() - start + 0.1  # never ahead; a busy machine may lag


def test_the_same_seed_is_the_same_arm():
    places = []
    for seed in (3, 3, 4):
        with connect(f"virtual://arm?seed={seed}&noise=0.001") as arm:
            arm.move_to(JointAngles(50.0, -70.0))
            places.append((arm.port.motors, arm.port.link_deg, arm.port.clock()))
    assert places[0] == places[1] != places[2]


def test_leaving_stops_the_motors():
    with pytest.raises(KeyError), connect("virtual://arm") as other:
        other.enable()
        other.command("MV 1 160")
        other.port.sleep(0.3)
        assert not other.port.at_rest
        raise KeyError("anything")
    assert not other.port.is_open and not other.port._controller.enabled
    other.port._run(500)
    assert other.port.at_rest


def test_an_interrupted_wait_stops_the_motors(arm, monkeypatch):
    listen, times = arm.line.listen, iter(range(1000))

    def interrupted(*args, **kwargs):
        if next(times) == 3:
            raise KeyboardInterrupt
        return listen(*args, **kwargs)

    monkeypatch.setattr(arm.line, "listen", interrupted)
    with pytest.raises(KeyboardInterrupt):
        arm.move_to(JointAngles(160.0, 0.0))
    assert arm.status().state == "stop"
    assert arm.move_to(JointAngles(0.0, 0.0))  # the next move is asked for: it switches the motors on again


def once_it_moves(arm, do):
    """Do it in another thread as soon as joint 1 has turned by 20 degrees."""

    def wait_and_do():
        while arm.port.motor_deg[0] < 20:
            time.sleep(0.005)
        do()

    thread = threading.Thread(target=wait_and_do, daemon=True)
    thread.start()
    return thread


def test_stop_from_elsewhere_ends_a_move_with_a_sentence():
    with connect("virtual://arm?realtime=1") as arm:
        once_it_moves(arm, lambda: arm.port.write(b"\n!\n"))
        with pytest.raises(ArmError, match="stopped in mid-move"):
            arm.move_to(JointAngles(160.0, 0.0))  # somebody else's stop stays until it is undone
        with pytest.raises(ArmError, match=r"arm\.enable\(\)"):
            arm.move_to(JointAngles(0.0, 0.0))
        arm.enable()
        arm.move_to(JointAngles(60.0, 0.0))


def test_stop_by_another_thread_ends_a_move_and_the_next_may_begin():
    with connect("virtual://arm?realtime=1") as arm:
        stopper = once_it_moves(arm, arm.stop)
        with pytest.raises(ArmError, match="stopped in mid-move"):
            arm.move_to(JointAngles(160.0, 0.0))
        stopper.join()
        assert arm.angles().theta1_deg < 120
        arm.move_to(JointAngles(60.0, 0.0))


def test_stop_by_another_thread_between_two_moves_is_not_undone():
    with connect("virtual://arm") as arm:
        arm.move_to(JointAngles(5.0, 5.0))
        thread = threading.Thread(target=arm.stop)
        thread.start()
        thread.join()
        with pytest.raises(ArmError, match="stopped by another part of this program"):
            arm.move_to(JointAngles(10.0, 5.0))
        assert arm.angles().theta1_deg == pytest.approx(5, abs=0.2)
        arm.move_to(JointAngles(10.0, 5.0))  # told once


def test_a_stop_that_is_long_undone_is_no_news():
    with connect("virtual://arm") as arm:
        arm.stop()
        arm.enable()
        arm.disable()
        raised = []

        def move():
            try:
                arm.move_to(JointAngles(3.0, 3.0))
                arm.command("MV 1 400")
            except StereoLabError as error:
                raised.append(str(error))

        thread = threading.Thread(target=move)
        thread.start()
        thread.join()
        assert len(raised) == 1 and "beyond its limits" in raised[0]


def test_a_stop_just_after_a_move_has_ended_is_told_before_the_next():
    with connect("virtual://arm") as arm:
        await_end = arm._await_end

        def ended_then_stopped():
            status = await_end()
            thread = threading.Thread(target=arm.stop)
            thread.start()
            thread.join()
            return status

        arm._await_end = ended_then_stopped
        arm.move_to(JointAngles(3.0, 3.0))
        arm._await_end = await_end
        with pytest.raises(ArmError, match="stopped by another part"):
            arm.move_to(JointAngles(6.0, 3.0))


@pytest.mark.parametrize("step", ["_enable", "command"])
def test_a_stop_while_the_motors_are_switched_on_is_not_undone(step):
    """The question is answered with off, then another thread stops, then the motors are switched on."""
    with connect("virtual://arm") as arm:
        switch_on = getattr(arm, step)

        def late(what):
            if what in ("EN 1", 0):
                thread = threading.Thread(target=arm.stop)
                thread.start()
                thread.join()
                setattr(arm, step, switch_on)
            return switch_on(what)

        setattr(arm, step, late)
        with pytest.raises(ArmError, match="stopped by another part"):
            arm.move_to(JointAngles(40.0, 0.0))
        arm.port.sleep(0.5)
        assert arm.status().state == "stop" and arm.port.motor_deg[0] < 1
        arm.move_to(JointAngles(4.0, 0.0))


def test_a_stop_between_two_legs_is_told_as_one(arm, monkeypatch):
    move = arm.run

    def stopped_after_the_first(command):
        reached = move(command)
        monkeypatch.setattr(arm, "run", move)
        thread = threading.Thread(target=arm.stop)
        thread.start()
        thread.join()
        return reached

    monkeypatch.setattr(arm, "run", stopped_after_the_first)
    with pytest.raises(ArmError, match="stopped by another part"):
        arm.home()
    arm.move_to(JointAngles(arm.angles().theta1_deg, -150.0))


def test_a_stop_gets_through_a_burst_of_noise(arm):
    arm.enable()
    arm.command("MV 1 160")
    arm.port.sleep(0.2)
    arm.port.faults.noise = 0.1
    passes = arm.port.clock() + 0.3
    read = arm.port.read

    def quieter(size=1):
        arm.port.faults.noise = 0.0 if arm.port.clock() > passes else 0.1
        return read(size)

    arm.port.read = quieter
    arm.stop()
    assert arm.status().state == "stop"


def test_command_numbers_run_from_1_to_the_last_and_begin_at_1_again(arm, monkeypatch):
    """0 is no number of the protocol: a controller would take the command for one without a number."""
    sent, exchange = [], arm.line.exchange
    monkeypatch.setattr(arm.line, "exchange", lambda text, number: sent.append(number) or exchange(text, number))
    arm._number = wire.NUMBER_MAX - 1
    for _ in range(3):
        arm.command("ID")
    assert sent == [9999, 1, 2]


def test_half_a_line_left_behind_does_not_keep_anybody_out(arm):
    arm.port.write(b"N5 GE")
    again = connect(arm.port)
    assert again.get(1, "lo") == -165


def test_a_coarse_encoder_does_not_make_a_healthy_joint_run_away():
    joint = Joint(counts=360.0)
    joint.rule, joint.duty = Profile(joint.tuning, 0.0, 5.0), 60
    joint.rule.kick_v = 0.1
    for count, away in ((-1, False), (-2, False), (-3, True)):
        joint.look(count, False)
        joint.speed_deg_s = 0.0
        assert joint.runs_away == away


def test_interrupted_while_a_move_is_being_sent_stops_it(arm, monkeypatch):
    """Ctrl-C after the command has gone out and before its reply came."""
    arm.enable()
    await_reply = arm.line._await_reply

    def interrupted(number, until):
        monkeypatch.setattr(arm.line, "_await_reply", await_reply)
        raise KeyboardInterrupt

    monkeypatch.setattr(arm.line, "_await_reply", interrupted)
    monkeypatch.setattr(arm, "_switch_on", lambda: None)
    with pytest.raises(KeyboardInterrupt):
        arm.move_to(JointAngles(160.0, 0.0))
    arm.port.sleep(0.5)
    assert arm.port.at_rest and arm.port.motor_deg[0] < 20


def test_an_arm_whose_answers_are_lost_is_stopped_with_the_error():
    arm = connect("virtual://arm?silent=0.4")  # it hears us, and we do not hear it
    with pytest.raises(ArmError, match="does not answer"):
        arm.move_to(JointAngles(160.0, 0.0))
    arm.port.sleep(0.3)
    assert arm.port.at_rest  # not a watchdog's second later


def test_a_silent_arm_is_left_within_a_second():
    arm = connect("virtual://arm?silent=0.4")
    arm.port.sleep(0.5)
    before = arm.port.clock()
    with pytest.raises(ArmError):
        arm.stop()
    assert arm.port.clock() - before < 1


def test_a_move_that_never_ends_is_given_up():
    def moving(text):
        state = "stop" if "!" in port.sent else "run"
        return [f"<{state} t=1 h=3 f=- p=1.00,0.00 v=0,0 lost=0 drop=0>"] if text == "?" else polite(text)

    port = ScriptedPort(moving)
    with pytest.raises(ArmError, match="nothing turns"):
        connect(port).move_to(JointAngles(1, 1))
    assert "!" in port.sent


def test_limits_can_be_those_of_a_recording(arm, second_rig):
    arm.set_limits(second_rig.arm.limits_deg)
    assert arm.limits_deg == second_rig.arm.limits_deg
    with pytest.raises(UnreachableTargetError, match="-140 to 140"):
        arm.move_to(JointAngles(0, 150))


@pytest.mark.parametrize(
    ("angles", "words"),
    [
        (JointAngles(166, 0), "Joint 1 turns from -165 to 165"), (JointAngles(0, -155.1), "Joint 2"),
        (JointAngles(float("nan"), 0), "nan was asked"), (JointAngles(0, float("inf")), "inf was asked"),
        (JointAngles("ten", 0), "number of degrees"), ((30, 45), "Expected JointAngles"), (None, "Expected JointAngles"),
    ],
)  # fmt: skip
def test_bad_targets_are_refused_before_anything_is_sent(angles, words):
    port = ScriptedPort(polite)
    arm = connect(port)
    arm.limits_deg = ((-165.0, 165.0), (-155.0, 155.0))
    before = len(port.sent)
    with pytest.raises(StereoLabError, match=words):
        arm.move_to(angles)
    assert len(port.sent) == before


def test_each_joint_has_its_own_supply(arm):
    arm.set(2, "supply", 12)
    assert arm.supply_v == (6, 12)
    with pytest.raises(UnreachableTargetError, match="12 V"):
        arm.push(2, 12.5, 0.05)
    with pytest.raises(UnreachableTargetError, match="6 V"):
        arm.push(1, 6.5, 0.05)


@pytest.mark.parametrize(("arguments", "words"), [
    ((1, float("nan"), 0.1), "Nothing was sent"), ((1, 2.0, float("inf")), "seconds"), ((1, 2.0, float("nan")), "seconds"),
    ((1, "much", 0.1), "got 'much'"),
    ((3, 2.0, 0.1), "joint 1 or 2"), ((1.0, 2.0, 0.1), "joint 1 or 2"),
])  # fmt: skip
def test_bad_pushes_are_refused_before_anything_is_sent(arm, arguments, words):
    with pytest.raises(StereoLabError, match=words):
        arm.push(*arguments)
    assert arm.status().state == "off"


@pytest.mark.parametrize("limits_deg", [
    ((10, -10), (-100, 100)), (-90, 90), None, ((float("nan"), 90), (0, 1)), ((-1, 1),), ("ab", "cd"),
])  # fmt: skip
def test_limits_that_are_none_are_refused_and_the_old_ones_stay(arm, limits_deg):
    with pytest.raises(StereoLabError, match=r"Expected \(low, high\) in degrees for each of two joints"):
        arm.set_limits(limits_deg)
    assert arm.limits_deg == ((-165, 165), (-155, 155))


@pytest.mark.parametrize("ask", [
    lambda arm: arm.set(1, "lo", float("nan")), lambda arm: arm.set(1, "hi", float("inf")), lambda arm: arm.set(1, "k", "fast"),
    lambda arm: arm.wait("long"), lambda arm: arm.steer(JointAngles(0.0, 0.0), "half"),
])  # fmt: skip
def test_what_should_be_a_number_is_asked_for(arm, ask):
    with pytest.raises(StereoLabError, match="expected a (finite )?number, got"):
        ask(arm)


def test_a_calibration_without_room_is_told(arm):
    arm.set_limits(((-10, 10), (-155, 155)))
    with pytest.raises(UnreachableTargetError, match="more room"):
        arm.calibrate(1)


def test_a_push_beyond_the_supply_is_refused(arm):
    with pytest.raises(UnreachableTargetError, match="6 V"):
        arm.push(1, 7.0, 0.1)


def test_unknown_port_is_named_with_what_there_is():
    for name in ("/dev/ttyNOPE", "COM77", "nonsense://arm", "virtual:/arm", "socket://127.0.0.1:1"):
        with pytest.raises(ArmError) as caught:
            connect(name)
        assert name in str(caught.value) and "Errno" not in str(caught.value)
    assert ports()[0][0] == "virtual://arm"


@pytest.mark.parametrize("port", [3, None, b"COM3"])
def test_what_is_no_port_is_told(port):
    with pytest.raises(StereoLabError, match="name of a port in quotes, such as .*; got "):
        connect(port)


@pytest.mark.parametrize(
    ("url", "words"),
    [
        ("virtual://leg", "expected virtual://arm"), ("virtual://arm?speed=3", "no option 'speed'"),
        ("virtual://arm?noise=2", "from 0 to below 1; got noise=2"), ("virtual://arm?stall=3", "1, 2, or both .*got stall=3"),
        ("virtual://arm?load_g=2000", "grams, from 0 to 1000; got load_g=2000"), ("virtual://arm?load_g=-5", "from 0 to 1000"),
        ("virtual://arm?seed=-1", "seed should be a whole number from 0 on; got seed=-1"),
    ],
)  # fmt: skip
def test_virtual_arm_names_what_its_options_should_be(url, words):
    with pytest.raises(ArmError, match=words):
        connect(url)


@pytest.fixture
def pty_pair():
    pty = pytest.importorskip("pty", reason="no pseudo-terminals on this system")
    import tty

    master, slave = pty.openpty()
    tty.setraw(slave)
    yield master, os.ttyname(slave)
    os.close(master)
    os.close(slave)


def test_port_in_use(pty_pair):
    import serial

    with serial.Serial(pty_pair[1], exclusive=True), pytest.raises(ArmError, match="in use"):
        connect(pty_pair[1])


def test_a_silent_port_is_asked_for_a_second(pty_pair):
    """Told by the number of questions, which a busy machine can only make fewer."""
    assert line.GIVE_UP_S < 1.0
    with pytest.raises(ArmError, match="does not answer"):
        connect(pty_pair[1])
    asked = os.read(pty_pair[0], 4096).count(b"\n") - 1  # the first line ends what was said before
    assert 1 <= asked <= line.GIVE_UP_S / line.ANSWER_S + 1


def test_wrong_baud_rate_is_guessed():
    with pytest.raises(ArmError, match="wrong baud rate"):
        connect("virtual://arm", baud_rate=9600)


def test_something_else_at_the_port():
    def printer(text):
        return [f"ok {text.split()[0] if text.startswith('N') else ''} Marlin 2.1".replace("ok  ", "ok ")]

    with pytest.raises(ArmError, match="Something else"):
        connect(ScriptedPort(printer))


@pytest.mark.parametrize(
    ("answers", "words"),
    [
        ([], "does not answer"), ([b"ok N"], "make no sense"), ([bytes(range(128, 256)) * 3], "make no sense"),
        (["ok N4321 lots"], "other commands"), ([b"\xff\xfe\n\x00\n"], "make no sense"),
    ],
    ids=["silent", "half a line", "binary", "other number", "short noise"],
)  # fmt: skip
def test_garbled_answers_raise_within_a_second(answers, words):
    port = ScriptedPort(polite)
    arm = connect(port)
    port.answer = lambda text: answers
    start = port.time
    with pytest.raises(ArmError, match=words) as caught:
        arm.get(1, "k")
    assert port.time - start <= 1.0
    assert "scripted" in str(caught.value)


def test_a_lost_reply_is_asked_for_again_with_the_same_number():
    port = ScriptedPort(polite)
    arm = connect(port)
    deaf = iter([True, True, False])
    port.answer = lambda text: [] if next(deaf) else polite(text)
    port.sent.clear()
    arm.command("SET 1 k 200")
    assert len(port.sent) == 3 and len(set(port.sent)) == 1


def test_an_error_reply_is_told_in_words(arm):
    with pytest.raises(ArmError, match="there is no such command"):
        arm.command("JUMP")
    with pytest.raises(ArmError, match="motors are off"):
        arm.command("MV 1 10")
    with pytest.raises(ArmError, match="beyond its limits"):
        arm.set(1, "k", 1)


def test_a_reset_in_mid_move_is_told():
    with connect("virtual://arm?reset=0.6") as arm, pytest.raises(ArmError, match="restarted"):
        arm.move_to(JointAngles(160.0, 0.0))


@pytest.mark.parametrize(("name", "baud_rate", "said"), [
    ("socket://127.0.0.1:1", 115200, "Nobody listens at socket://127.0.0.1:1"),
    ("socket://clock", 115200, "Nobody listens at socket://clock"),
    ("feetech://socket://127.0.0.1:1", 115200, "Nobody listens at feetech://socket://127.0.0.1:1"),
    ("/dev/no_clock", 115200, "There is no port /dev/no_clock"), ("virtual://arm", "fast", "Expected a baud rate.*got 'fast'"),
    ("virtual://arm", 0, "Expected a baud rate.*got 0"),
])  # fmt: skip
def test_a_port_that_does_not_open_is_told_by_its_cause(name, baud_rate, said):
    with pytest.raises(StereoLabError, match=said):
        connect(name, baud_rate)


@pytest.mark.skipif(not hasattr(os, "openpty"), reason="only where ports are files")
def test_a_port_that_another_one_has_is_in_use():
    name = os.ttyname(os.openpty()[1])
    with line.open_port(name), pytest.raises(ArmError, match="is in use"):
        connect(name)


def test_a_port_that_is_half_closed_under_a_move_is_told_as_closed():
    class HalfClosed(ScriptedPort):
        gone = False

        def _use(self, use, what):
            return (
                None + what if self.gone else use(self, what)
            )  # as pyserial: its file is None before is_open is False

        def write(self, data):
            self._use(ScriptedPort.write, data)

        def read(self, size):
            return self._use(ScriptedPort.read, size)

        def close(self):
            self.gone = True
            with pytest.raises(ArmError, match="was closed. Make a new one with connect"):
                arm.move_to(JointAngles(10.0, 10.0))
            self.is_open = False

    arm = connect(HalfClosed(polite))
    arm.close()
    assert arm.port.gone and not arm.port.is_open


def test_a_closed_connection_is_told_apart_from_an_unplugged_arm():
    arm = connect("virtual://arm")
    arm.close()
    with pytest.raises(ArmError, match="was closed. Make a new one with connect") as told:
        arm.home()
    assert "Plug" not in str(told.value)


def test_unplugged_in_mid_move_is_told_and_leaving_does_not_raise():
    arm = connect("virtual://arm?unplugged=0.5")
    with pytest.raises(ArmError, match="is gone.*Plug it in again"):
        arm.move_to(JointAngles(160.0, 0.0))
    arm.close()
    assert not arm.port.is_open


def test_the_time_of_an_unplugged_arm_goes_on():
    arm = connect("virtual://arm?unplugged=0.5")
    arm.command("EN 1")
    arm.command("MV 1 160 30")
    arm.port.sleep(2.0)
    assert 10 < arm.port.link_deg[0] < 30 and arm.port.at_rest  # its watchdog stopped it
    with pytest.raises(ArmError, match="is gone"):
        arm.status()
    arm.close()


def test_an_arm_that_falls_silent_in_mid_move_raises_within_a_second_and_stops_by_itself():
    arm = connect("virtual://arm?silent=0.4")
    with pytest.raises(ArmError, match="does not answer"):
        arm.move_to(JointAngles(160.0, 0.0))
    assert arm.port.clock() < 1.6
    arm.port.sleep(1.5)
    assert arm.port.at_rest


def test_a_reversed_encoder_is_stopped_within_five_degrees_and_named():
    for seed in range(8):
        arm = connect(f"virtual://arm?seed={seed}&runaway=2")
        with pytest.raises(ArmError, match="Joint 2 .* wrong way.*swap the two wires"):
            arm.move_to(JointAngles(0.0, 90.0))
        arm.port.sleep(0.5)
        assert abs(arm.port.motor_deg[1]) < 5
        with pytest.raises(ArmError, match=r"arm\.enable\(\)"):
            arm.move_to(JointAngles(0.0, 90.0))


def test_a_stalled_motor_is_named():
    arm = connect("virtual://arm?stall=1")
    with pytest.raises(ArmError, match="Joint 1 .* stalled"):
        arm.move_to(JointAngles(60.0, 20.0))
    assert arm.port.clock() < 2 and arm.port._controller.joints[1].duty == 0


def test_calibrating_what_does_not_turn_is_told():
    arm = connect("virtual://arm?stall=1")
    with pytest.raises(StereoLabError, match="does not turn"):
        arm.calibrate(1)


def test_the_watchdog_stops_the_motors_of_a_host_that_was_killed():
    """A host process is killed in mid-move; the arm, which lives on in this process, stops within its time."""
    pty = pytest.importorskip("pty", reason="no pseudo-terminals on this system")
    import tty

    from stereo_lab.arm.virtual import VirtualPort

    master, slave = pty.openpty()
    tty.setraw(slave)
    os.set_blocking(master, False)
    # The arm's clock takes a step each time round and never jumps, however busy the computer is: a jump would bring
    # the arm to its goal before the loop sees it move.
    device = VirtualPort("virtual://arm", baudrate=wire.BAUD_RATE, timeout=0)
    code = (
        "from stereo_lab.arm import connect; from stereo_lab.kinematics import JointAngles\n"
        f"arm = connect({os.ttyname(slave)!r}); print('moving', flush=True); arm.move_to(JointAngles(160.0, 0.0))"
    )
    host = subprocess.Popen([sys.executable, "-c", code], cwd=ROOT, stdout=subprocess.PIPE, text=True)
    said, end = [], time.monotonic() + 60
    threading.Thread(target=lambda: said.append(host.stdout.readline()), daemon=True).start()
    killed_at = None
    while time.monotonic() < end:
        try:
            device.write(os.read(master, 512))
        except BlockingIOError:
            pass
        if out := device.read(512):
            os.write(master, out)
        if killed_at is None and device.motor_deg[0] > 10:
            host.kill()
            killed_at = device.clock()
        if killed_at is not None and device._controller.fault != "-":
            break
        time.sleep(0.002)
        device.sleep(0.002)
    host.wait()
    assert killed_at is not None, "the host never moved the arm"
    assert device._controller.fault == "w" and not device._controller.busy
    assert device.clock() - killed_at < 1.5  # its watchdog has a second


@pytest.mark.parametrize("seed", range(5))
def test_noise_makes_nothing_silently_wrong_and_stops_nothing(seed):
    """10,000 commands while 0.3 % of all bytes are hit by a flipped bit, both ways."""
    arm = connect(f"virtual://arm?seed={seed}&noise=0.003")
    arm.enable()
    rng, wrong, failed = np.random.default_rng(seed), 0, 0
    joints = arm.port._controller.joints
    before = arm.port._controller.time_ticks
    for k in range(10_000):
        joint, value = int(rng.integers(1, 3)), round(float(rng.uniform(100, 300)), 3)
        try:
            if k % 4 == 3:
                wrong += arm.get(joint, "k") != joints[joint - 1].parameters["k"]
            else:
                arm.set(joint, "k", value)
                wrong += joints[joint - 1].parameters["k"] != value
        except ArmError:
            failed += 1
        assert not arm.port._controller.stopped, "a stray stop"
    assert wrong == 0 and failed == 0
    assert arm.port._controller.time_ticks > before and arm.status().state == "idle"


def test_moves_arrive_through_noise():
    with connect("virtual://arm?seed=1&noise=0.003") as arm:
        arm.home()
        for k in range(30):
            goal = JointAngles(-90.0 + 6 * k, 80.0 - 5 * k)
            reached = arm.move_to(goal)
            assert (reached.theta1_deg, reached.theta2_deg) == pytest.approx(
                (goal.theta1_deg, goal.theta2_deg), abs=0.15
            )


def test_a_burst_of_noise_is_waited_out():
    """The controller hears nothing but noise for half a second: no reason to give up."""
    port = ScriptedPort(lambda text: ["err 1 checksum"] if 1 < port.time < 1.5 else polite(text))
    arm = connect(port)
    port.time = 1.01
    assert arm.get(1, "lo") == -165 and port.time > 1.5


def test_a_controller_that_hears_only_noise_is_named():
    port = ScriptedPort(lambda text: ["err 1 checksum"] if port.time > 1 else polite(text))
    arm = connect(port)
    port.time = 1.01
    with pytest.raises(ArmError, match="hears noise"):
        arm.get(1, "lo")
    assert 0.8 < port.time - 1.01 < 1


def test_a_board_on_usb_gets_time_to_start(monkeypatch):
    class Board:
        device, vid, description = "scripted", 0x2341, "Arduino"

    monkeypatch.setattr(line.list_ports, "comports", lambda: [Board])
    port = ScriptedPort(lambda text: [])
    with pytest.raises(ArmError):
        connect(port)
    assert 2.0 < port.time < 3.0


def test_a_move_from_the_terminal_homes_an_arm_that_is_lost_but_not_for_a_goal_out_of_reach(capsys):
    """Each command opens the port anew, which restarts an Arduino: its angles would count from wherever it stands."""
    assert main(["arm", "virtual://arm", "move", "30", "0"]) == 0
    told = capsys.readouterr().out
    assert told.index("homes both joints") < told.index("reached 30.0")
    assert main(["arm", "virtual://arm", "move", "300", "0"]) == 2
    assert "homes" not in capsys.readouterr().out


@pytest.mark.parametrize(
    ("words", "code", "said"),
    [
        (["list"], 0, "virtual://arm"), (["virtual://arm"], 0, "off, joints at 0.00, 0.00"),
        (["torque"], 0, "2.7 times"), (["torque", "nowhere"], 2, "no folder"), (["virtual://arm", "fly"], 2, "no action"),
        (["virtual://arm", "home"], 0, "homed"), (["virtual://arm", "move", "30", "-45.5"], 0, "reached 30.0"),
        (["virtual://arm", "calibrate"], 0, "joint 2 clockwise"),
        (["virtual://arm", "calibrate"], 0, "The arm hangs; now its motors go off."),
        (["virtual://arm", "monitor", "--seconds", "0.1"], 0, "0.0 s  off"),
        (["virtual://arm", "move", "30"], 2, "two angles"), (["virtual://arm", "move", "30", "x"], 2, "move, joint 2"),
        (["virtual://arm", "move"], 2, "two angles"), (["virtual://arm", "home", "3"], 2, "home has no use for 3"),
        (["virtual://arm", "move", "1", "2", "3"], 2, "move has no use for 3"), (["move", "30", "45"], 2, "Name the port"),
        (["list", "move"], 2, "list has no use for move"), (["virtual://arm", "--keep"], 2, "status has no use for --keep"),
        (["virtual://arm", "status", "--left", "0"], 2, "status has no use for --left"),
        (["virtual://arm", "move", "300", "0"], 2, "Nothing was sent"), (["/dev/ttyNOPE"], 2, "There is no port"),
        (["virtual://arm?runaway=1", "move", "90", "0"], 2, "wrong way"),
    ],
)  # fmt: skip
def test_arm_on_the_command_line(words, code, said, capsys):
    assert main(["arm", *words]) == code
    out = capsys.readouterr()
    assert said in (out.out if code == 0 else out.err) and "Traceback" not in out.err


def test_arm_writes_its_numbers_as_json(capsys):
    assert main(["arm", "virtual://arm", "move", "30", "45", "--json", "-"]) == 0
    assert json.loads(capsys.readouterr().out)["angles_deg"] == pytest.approx([30, 45], abs=0.2)


@pytest.mark.parametrize("looks", [3, 1200])
def test_monitor_keeps_what_it_saw_when_it_is_stopped(tmp_path, monkeypatch, capsys, looks):
    """Ctrl-C is how it ends: exit code 0, and every look is in the file."""
    from stereo_lab.arm import Arm
    from stereo_lab.cli import arm as command

    waits = iter(range(looks))

    def wait(*_):
        if next(waits) == looks - 1:
            raise KeyboardInterrupt

    monkeypatch.setattr(Arm, "wait", wait)
    monkeypatch.setattr(command.time, "sleep", lambda _: None)
    path = tmp_path / "seen.json"
    assert main(["arm", "virtual://arm", "monitor", "--json", str(path)]) == 0
    rows = json.loads(path.read_text())
    assert len(rows) == looks and rows[0]["state"] == "off"


def test_monitor_keeps_what_it_saw_of_an_arm_that_is_lost(tmp_path, capsys):
    path = tmp_path / "seen.json"
    assert main(["arm", "virtual://arm?unplugged=0.9", "monitor", "--json", str(path)]) == 2
    assert "is gone" in capsys.readouterr().err
    assert 2 <= len(json.loads(path.read_text())) <= 5


def test_what_monitor_saw_of_an_arm_that_is_lost_goes_where_it_is_asked_for(capsys):
    assert main(["arm", "virtual://arm?unplugged=0.9", "monitor", "--json", "-"]) == 2
    assert len(json.loads(capsys.readouterr().out)) >= 1


@pytest.mark.parametrize("seconds", ["0", "-1", "nan"])
def test_monitor_refuses_no_time(capsys, seconds):
    assert main(["arm", "virtual://arm", "monitor", "--seconds", seconds]) == 2
    assert "above zero" in capsys.readouterr().err


def test_a_limit_that_is_told_can_be_reached():
    """It is told to the thousandth of a degree, and is set no farther out than that."""
    with connect("virtual://arm") as arm:
        arm.set(1, "hi", 52.3456)
        arm.set(1, "lo", -52.3456)
        assert arm.limits_deg[0] == (-52.345, 52.345)
        assert arm.move_to(JointAngles(52.345, 0.0)).theta1_deg == pytest.approx(52.345, abs=0.3)


def test_a_joint_is_calibrated_wherever_it_stands():
    with connect("virtual://arm") as arm:
        arm.home()
        arm.weigh()
        arm.move_to(JointAngles(0.0, 100.0))
        arm.disable()
        assert arm.calibrate(2).speed_per_volt > 0


def test_a_shoulder_calibrated_twice_has_about_the_same_time_constant():
    """The calibration of the elbow leaves the arm stretched: more sluggish, and heavier."""
    with connect("virtual://arm") as arm:
        arm.home()
        taus = [arm.calibrate(joint).time_constant_s for _ in range(4) for joint in (1, 2)][::2]
        assert max(taus) < 1.25 * min(taus)


def test_a_glitch_on_a_home_switch_is_no_switch():
    joint = Joint()
    for closed, pressed in ((1, 0), (1, 0), (0, 0), (1, 0), (1, 0), (1, 1), (1, 1)):
        joint.look(100 + joint.still_ticks, bool(closed))
        assert joint.pressed == bool(pressed)


def test_an_arm_in_real_time_answers_after_a_pause():
    with connect("virtual://arm?realtime=1") as arm:
        arm.angles()
        time.sleep(1.2)  # longer than an answer may take
        assert arm.status().state == "off"
        time.sleep(1.2)
        arm.stop()


def test_a_thread_knows_of_no_stop_that_another_one_knew_of():
    stops, news = Stops(), []
    for work in [stops.ask, lambda: news.append(stops.are_news)] * 20:  # numbers of threads are given again
        thread = threading.Thread(target=work)
        thread.start()
        thread.join()
    assert news == [True] * 20


def test_a_weighing_that_is_broken_off_keeps_what_was_known(monkeypatch):
    with connect("virtual://arm") as arm:
        arm.home()
        for joint, name, volts in ((1, "g1", 0.151), (2, "g2", 0.156)):
            arm.set(joint, name, volts)

        def stopped(poses):
            assert arm.get(1, "g1") == 0
            raise KeyboardInterrupt

        monkeypatch.setattr(arm, "move_to", stopped)
        with pytest.raises(KeyboardInterrupt):
            arm.weigh()
        assert (arm.get(1, "g1"), arm.get(2, "g2")) == (0.151, 0.156)

"""One suite for every controller that speaks the protocol: the virtual one, and the firmware in a simulated chip.

It runs unchanged on each; what it tests is what PROTOCOL.md promises.
"""

import pytest
from controllers import BACK_ENDS, open_back_end

from stereo_lab.arm import connect
from stereo_lab.arm import protocol as wire
from stereo_lab.kinematics import JointAngles


class Talk:
    """A bare hand on the line: no client, no retries."""

    def __init__(self, bench):
        self.port, self.bench = bench.port, bench
        self.clock = getattr(bench, "clock", None) or self.port.clock
        self.buffer, self.lines = b"", []

    def say(self, text, end=b"\n"):
        self.port.write(text.encode() + end)

    def listen(self, seconds, until=None):
        """Lines of some time, or up to one that starts with ``until``; returns the last."""
        give_up = self.clock() + seconds
        while True:
            while b"\n" in self.buffer:
                line, self.buffer = self.buffer.split(b"\n", 1)
                self.lines.append(line.decode().strip())
                if until and self.lines[-1].startswith(until):
                    return self.lines[-1]
            if self.clock() >= give_up:
                assert until is None, f"no {until!r} within {seconds} s, but {self.lines[-5:]}"
                return None
            self.port.timeout = 0.005
            self.buffer += self.port.read(max(1, self.port.in_waiting))

    def ask(self, text):
        """A command; returns its reply."""
        self.say(text)
        return self.listen(0.5, ("ok", "err"))

    def status(self):
        self.say("?")
        return wire.decode_answer(self.listen(0.5, "<").partition("*")[0])

    def rest(self, seconds=20):
        """Wait for the end of a move, keeping the watchdog quiet."""
        give_up = self.clock() + seconds
        while self.clock() < give_up:
            status = self.status()
            if status.state not in ("run", "home"):
                self.listen(0.05)  # the motor settles, events arrive
                return status
            self.listen(0.05)
        raise AssertionError(f"still {status} after {seconds} s")


@pytest.fixture(
    scope="module",
    params=[pytest.param(n, marks=[pytest.mark.slow] if n == "pty" else []) for n in BACK_ENDS],
)
def bench(request):
    bench = open_back_end(request.param)
    yield bench
    bench.close()


@pytest.fixture
def talk(bench):
    """A freshly started controller."""
    bench.restart()
    talk = Talk(bench)
    talk.listen(2, wire.GREETING)
    return talk


def test_it_greets_and_says_what_it_is(talk):
    assert talk.ask("ID") == f"ok {wire.IDENTITY}"
    assert talk.ask("N7 id") == f"ok N7 {wire.IDENTITY}"
    assert talk.status().state == "off"


@pytest.mark.parametrize(
    ("line", "reply"),
    [
        ("XX", "err 2 command"), ("N4 XX", "err N4 2 command"), ("N4", "err N4 2 command"), ("MV", "err 3 argument"),
        ("MV 3 10", "err 3 argument"), ("MV 1 ten", "err 3 argument"), ("MV 1 nan", "err 3 argument"),
        ("MV 1 1e3", "err 3 argument"), ("MV 1 10 100 5", "err 3 argument"), ("MV 1 166", "err 4 limit"),
        ("MA 0 -161", "err 4 limit"), ("MV 1 10", "err 5 off"), ("PW 1 100 100", "err 5 off"), ("HM 1", "err 5 off"),
        ("PW 1 256 100", "err 4 limit"), ("SET 1 acc 4001", "err 4 limit"), ("PW 1 100 2001", "err 4 limit"), ("EN 2", "err 3 argument"),
        ("SET 1 speed 3", "err 3 argument"), ("SET 1 k 5", "err 4 limit"), ("GET 1 speed", "err 3 argument"),
        ("RP 10", "err 4 limit"), ("WD 50", "err 4 limit"), ("MODE fast", "err 3 argument"), ("MV 1 10 0", "err 4 limit"),
        ("x" * 64, "err 6 too long"), ("ID*0000", "err 1 checksum"), ("ID*", "err 1 checksum"), ("N8 ID ", "ok N8 armkit"),
        ("CS", "err 3 argument"), ("HM 0", "err 3 argument"), ("ZE 1 400", "err 4 limit"),
    ],
)  # fmt: skip
def test_what_it_answers(talk, line, reply):
    assert talk.ask(line).startswith(reply)


def test_lines_may_end_in_cr_and_empty_ones_are_passed_over(talk):
    talk.say("\r\n\n\r\n", b"")
    talk.say("ID", b"\r\n")
    assert talk.listen(0.5, "ok").startswith("ok armkit")
    talk.listen(0.1)
    assert len([line for line in talk.lines if line.startswith(("ok", "err"))]) == 1


def test_a_flood_of_questions_leaves_it_answering(talk):
    """More than it can answer or keep: what was cut in two by that is not taken for a command."""
    talk.say("EN 1")
    for _ in range(40):
        talk.say("?\nMV 1 9")
    talk.listen(1.0)
    talk.say("")
    assert talk.ask("N8 ID") == f"ok N8 {wire.IDENTITY}"
    allowed = (wire.GREETING, "ok", "<", "err 7 overrun", "!done 1")
    assert not [line for line in talk.lines if not line.startswith(allowed)]
    assert abs(talk.rest().position_deg[0] - 9) < 0.3


def test_a_flood_holds_up_neither_the_motors_nor_a_stop(talk):
    talk.ask("SET 1 hi 40")
    talk.ask("EN 1")
    talk.say("MV 1 40")
    for _ in range(40):
        talk.say("?" * 100, b"")
        talk.listen(0.02)
    assert talk.bench.motor_deg(0) == pytest.approx(40, abs=1)
    talk.listen(1)
    talk.say("\nMV 1 0")
    talk.listen(0.05)
    here = talk.bench.motor_deg(0)
    talk.say("?" * 100 + "\n!")
    talk.listen(1, "!estop")
    talk.listen(0.3)
    assert abs(talk.bench.motor_deg(0) - here) < 8 and talk.status().state == "stop"


def test_a_slow_plan_far_from_zero_ends(talk):
    """One joint hardly moves, and slowly, so that both arrive together: its steps are far below a count."""
    talk.ask("EN 1")
    talk.ask("ZE 2 140.06")
    talk.ask("MA 40 140.062 10")
    assert talk.rest(8).position_deg == (pytest.approx(40, abs=0.2), pytest.approx(140.06, abs=0.2))


@pytest.mark.parametrize("byte", [b"\0", b"\x0b", b"\x85", b"\xa0", b"\x7f"])
def test_bytes_that_are_no_characters_spoil_their_line(talk, byte):
    for line in (b"ID" + byte + b"\n", byte + b"ID\n", byte + b"\n", wire.encode_command("ID", 3)[:-1] + byte + b"\n"):
        talk.port.write(line)
        assert talk.listen(0.5, ("ok", "err")) == "err 1 checksum"


def test_checksums(talk):
    assert talk.ask(wire.seal("N1 ID")) == f"ok N1 {wire.IDENTITY}"
    assert talk.ask("CS 1") == wire.seal("ok")
    assert talk.ask("ID") == wire.seal("err 1 checksum")
    assert talk.ask(wire.seal("N2 ID")) == wire.seal(f"ok N2 {wire.IDENTITY}")
    assert talk.ask(wire.seal("N2 ID")[:-1] + "X") == wire.seal("err 1 checksum")
    talk.say("?")
    line = talk.listen(0.5, "<")
    assert wire.unseal(line)[1] is True
    assert talk.ask(wire.seal("CS 0")) == "ok"
    assert talk.ask("ID").startswith("ok")


def test_a_repeated_number_is_acknowledged_and_not_done_again(talk):
    assert talk.ask("N5 ZE 1 10") == "ok N5"
    assert talk.ask("N5 ZE 1 20") == "ok N5"
    assert talk.status().position_deg[0] == pytest.approx(10, abs=0.01)
    assert talk.ask("N6 MV 1 500") == "err N6 4 limit"
    assert talk.ask("N6 ZE 1 30") == "err N6 4 limit"
    assert talk.ask("N7 ZE 1 20") == "ok N7"
    assert talk.status().position_deg[0] == pytest.approx(20, abs=0.01)
    assert talk.ask("ZE 1 5") == "ok"
    assert talk.ask("N7 ZE 1 7") == "ok N7"  # a line without a number makes it forget
    assert talk.status().position_deg[0] == pytest.approx(7, abs=0.01)


def test_parameters_are_kept(talk):
    for joint in (1, 2):
        for name, value in (("k", 187.25), ("tau", 45.5), ("db-", 1.375), ("counts", 3200), ("zone", 7)):
            assert talk.ask(f"SET {joint} {name} {value}") == "ok"
            assert talk.ask(f"GET {joint} {name}") == f"ok {value:.3f}"
    assert talk.ask("GET 2 lo") == "ok -155.000"


def test_what_holds_a_joint_can_be_asked_for(talk):
    """The first two links lie sideways: the shoulder, lifted by a degree, is held by a voltage against their weight."""
    assert talk.ask("SET 1 held 1") == "err 3 argument"
    talk.ask("EN 1")
    talk.ask("MA 1 0")
    talk.rest(6)
    assert 0.05 < float(talk.ask("GET 1 held").split()[1]) < 1.0


def test_an_arm_that_is_homed_again_does_not_sink(talk):
    """What holds its weight goes on when the controller no longer knows where down is."""
    talk.ask("EN 1")
    for line in ("SET 1 g1 0.33", "SET 1 g2 0.12", "SET 2 g2 0.12", "ZE 1", "ZE 2", "MA 40 0"):
        assert talk.ask(line) == "ok"
    talk.rest(6)
    held_v = float(talk.ask("GET 1 held").split()[1])
    assert talk.ask("HM 2") == "ok"
    talk.listen(0.1)
    assert float(talk.ask("GET 1 held").split()[1]) == pytest.approx(held_v, abs=0.05)
    talk.listen(0.3)
    assert talk.bench.motor_deg(0) == pytest.approx(40, abs=1)
    talk.rest(30)


def test_a_move_is_accepted_and_then_done(talk):
    assert talk.ask("EN 1") == "ok"
    assert talk.ask("MV 1 40") == "ok"
    assert talk.status().state == "run"
    status = talk.rest(6)
    assert status.state == "idle" and status.fault == "-"
    assert status.position_deg[0] == pytest.approx(40, abs=0.2) and status.position_deg[1] == pytest.approx(0, abs=0.1)
    assert any(line.startswith("!done 1 ") for line in talk.lines)
    assert talk.bench.link_deg(0) == pytest.approx(40, abs=0.9)  # the backlash of a degree, and a count


def test_two_joints_arrive_together(talk):
    talk.ask("EN 1")
    assert talk.ask("MA 60 -20") == "ok"
    talk.listen(0.25)
    middle = talk.status().position_deg
    assert 0.1 < middle[0] / 60 < 0.9 and abs(middle[0] / 60 - middle[1] / -20) < 0.2
    assert talk.rest(6).position_deg == pytest.approx((60, -20), abs=0.2)


def test_a_new_goal_may_come_on_the_way(talk):
    talk.ask("EN 1")
    talk.ask("MV 1 90")
    talk.listen(0.3)
    assert talk.ask("MV 1 -10") == "ok"
    assert talk.rest(6).position_deg[0] == pytest.approx(-10, abs=0.2)


def test_slow_moves_are_slow(talk):
    talk.ask("EN 1")
    talk.ask("MV 1 20 20")
    talk.listen(0.3)
    assert talk.status().position_deg[0] < 8
    assert talk.rest(6).position_deg[0] == pytest.approx(20, abs=0.2)


def test_the_papers_rule_overshoots_and_says_done(talk):
    talk.ask("EN 1")
    assert talk.ask("MODE rule") == "ok"
    talk.ask("MV 1 60")
    assert talk.ask("MV 1 20") == "err 8 busy"
    status = talk.rest(6)
    assert status.fault == "-" and 60 <= status.position_deg[0] < 70
    assert talk.ask("MODE pid") == "ok"


def test_stop_is_at_once_and_latched(talk):
    talk.ask("EN 1")
    talk.ask("MV 1 90")
    talk.listen(0.3)
    talk.say("!")
    talk.listen(0.3, "!estop")
    talk.listen(0.3)
    status = talk.status()
    assert status.state == "stop" and status.fault == "e" and 5 < status.position_deg[0] < 80
    here = talk.bench.link_deg(0)
    assert talk.ask("MV 1 10") == "err 5 off"
    talk.listen(0.3)
    assert talk.bench.link_deg(0) == pytest.approx(here, abs=0.05)
    assert talk.ask("EN 1") == "ok" and talk.status().state == "idle"


def test_stop_acts_only_as_the_first_byte_of_a_line(talk):
    talk.ask("EN 1")
    assert talk.ask("GET 1 k! ?") == "err 3 argument"
    assert talk.status().state == "idle"
    talk.say("MV 1 4", b"")
    talk.say("\n!\n", b"")
    talk.listen(0.3, "!estop")


def test_st_stops_and_does_not_latch(talk):
    talk.ask("EN 1")
    talk.ask("MA 90 90")
    talk.listen(0.3)
    assert talk.ask("ST") == "ok"
    assert talk.status().state == "idle"
    assert talk.ask("MV 1 0") == "ok"
    talk.rest()


def test_st_drives_no_motor_that_is_stopped_or_off(talk):
    """What holds a weight would lift the arm as soon as the weight is gone: here it never was there."""
    for line in ("SET 1 g1 2", "SET 1 g2 2", "SET 2 g2 2", "ZE 1", "ZE 2", "EN 1"):
        assert talk.ask(line) == "ok"
    for stops, stopped in (("!", "!estop"), ("EN 0", "ok")):
        talk.say(stops)
        talk.listen(0.3, stopped)
        talk.listen(0.3)
        here = [talk.bench.motor_deg(j) for j in (0, 1)]
        for line in ("ST", "MODE pid"):
            assert talk.ask(line) == "ok"
            talk.listen(0.4)
            assert [talk.bench.motor_deg(j) for j in (0, 1)] == pytest.approx(here, abs=0.5), (stops, line)


def test_motors_off_in_mid_move(talk):
    talk.ask("EN 1")
    talk.ask("MV 2 90")
    talk.listen(0.3)
    assert talk.ask("EN 0") == "ok"
    status = talk.status()
    assert status.state == "off" and status.position_deg[1] < 80


def test_a_push_turns_the_joint_and_ends(talk):
    talk.ask("EN 1")
    assert talk.ask("PW 1 100 200") == "ok"
    assert talk.ask("PW 1 100 200") == "err 8 busy"
    assert talk.ask("SET 1 k 200") == "err 8 busy" and talk.ask("ZE 1") == "err 8 busy"
    there = talk.rest().position_deg[0]
    assert 15 < there < 80 and any(line.startswith("!done 1") for line in talk.lines)
    talk.ask("PW 1 -110 200")
    assert talk.rest().position_deg[0] < there - 10
    talk.ask("PW 1 12 200")
    before = talk.status().position_deg[0]
    assert talk.rest().position_deg[0] == pytest.approx(before, abs=0.2)  # too little to turn it


def test_a_push_ends_at_a_limit(talk):
    talk.ask("SET 1 hi 20")
    talk.ask("EN 1")
    talk.ask("PW 1 110 1000")
    assert talk.rest().position_deg[0] < 35
    assert any(line.startswith("!limit 1") for line in talk.lines)


def test_homing_finds_the_same_place_twice(talk):
    talk.ask("EN 1")
    places = []
    for goal in (-150, -120):
        assert talk.ask("HM 2") == "ok"
        status = talk.status()
        assert status.state == "home" and status.homed == (False, False)
        assert talk.ask("MV 2 0") == "err 8 busy"
        status = talk.rest(30)
        assert status.homed == (False, True) and status.position_deg[1] == pytest.approx(-160, abs=0.3)
        assert any(line.startswith("!home 2 ") for line in talk.lines)
        places.append(talk.bench.link_deg(1))
        talk.ask(f"MV 2 {goal}")
        assert talk.rest().position_deg[1] == pytest.approx(goal, abs=0.2)
    assert places == pytest.approx([-160, -160], abs=0.3)


def test_homing_from_the_switch_backs_off_first(talk):
    talk.ask("EN 1")
    talk.ask("HM 2")
    talk.rest(30)
    talk.ask("HM 2")
    assert talk.rest(30).position_deg[1] == pytest.approx(-160, abs=0.3)
    assert talk.bench.link_deg(1) == pytest.approx(-160, abs=0.3)


def test_the_watchdog_stops_an_arm_whose_host_is_silent(talk):
    talk.ask("EN 1")
    talk.ask("WD 300")
    talk.ask("MV 1 160")
    talk.listen(0.5, "!watchdog")
    talk.listen(0.3)
    assert talk.bench.link_deg(0) < 60
    status = talk.status()
    assert status.state == "off" and status.fault == "w"


def test_questions_keep_the_watchdog_quiet_and_noise_does_not(talk):
    talk.ask("EN 1")
    talk.ask("WD 300")
    talk.ask("MV 1 90 50")
    assert talk.rest(8).fault == "-"
    talk.ask("MV 1 0 50")
    for _ in range(10):
        talk.say("ID*0000")
        talk.listen(0.05)
    assert talk.status().fault == "w"


def test_reports_come_by_themselves(talk):
    assert talk.ask("RP 50") == "ok"
    talk.lines.clear()
    talk.listen(0.52)
    count = sum(line.startswith("<off ") for line in talk.lines)
    assert 8 <= count <= 12
    assert talk.ask("RP 0") == "ok"


def test_a_reversed_encoder_is_stopped_within_five_degrees(talk):
    talk.ask("EN 1")
    talk.bench.fault("reverse", 1)
    for command in ("MV 1 90", "PW 1 255 500", "HM 1", "ZE 1", "MV 1 0.3", "ZE 1", "MV 1 -0.6"):
        if command == "ZE 1":
            talk.ask(command)
            continue
        here = talk.bench.motor_deg(0)
        assert talk.ask(command) == "ok"
        talk.listen(1, "!runaway 1 ")
        talk.listen(0.3)
        assert abs(talk.bench.motor_deg(0) - here) < 5, command
        status = talk.status()
        assert status.state == "stop" and status.fault == "r1"
        talk.ask("EN 1")


def test_the_encoders_agree_with_the_motors(talk):
    talk.ask("EN 1")
    talk.ask("MA 20 -20")
    position = talk.rest().position_deg
    assert position == pytest.approx([talk.bench.motor_deg(j) for j in (0, 1)], abs=0.2)


@pytest.mark.parametrize("pause_s", [0.004, 0.02, 0.032, 0.05])
def test_goals_that_keep_coming_do_not_hide_a_fault(talk, pause_s):
    """The event counts: the next goal may clear a fault before a status tells of it."""
    talk.ask("EN 1")
    for fault, event, first, step in (
        ("hold", "!stall 2 ", 10, 0.3), ("hold", "!stall 2 ", 1.5, 0.01), ("reverse", "!runaway 1 ", 10, 0.3),
    ):  # fmt: skip
        joint = int(event.split()[1])
        talk.bench.fault(fault, joint)
        talk.lines.clear()
        began, k = talk.clock(), 0
        while not any(line.startswith(event) for line in talk.lines):
            assert talk.clock() - began < 1.0, f"{fault} of joint {joint} and no {event!r}, but {talk.lines[-5:]}"
            talk.ask(f"MV {joint} {first + step * min(k, 400):.2f}")
            talk.listen(pause_s)
            k += 1
        talk.ask("EN 1")
    assert abs(talk.bench.motor_deg(0)) < 5


def test_a_stop_in_a_flood_is_not_undone_by_what_came_before_it(talk):
    for before in (10, 15, 20):
        talk.say("ID\n" * before + "EN 1\nMV 1 150\n" + "ID\n" * 10 + "\n!")
        talk.listen(1.0, "!estop")
        talk.listen(0.3)
        talk.say("")
        assert talk.status().state == "stop"
        talk.ask("EN 0")


def test_a_held_joint_is_a_stall_and_both_stop(talk):
    talk.ask("EN 1")
    talk.bench.fault("hold", 2)
    talk.ask("MA 90 90")
    talk.listen(2, "!stall 2 ")
    talk.listen(0.3)
    status = talk.status()
    assert status.state == "idle" and status.fault == "s2" and status.position_deg[0] < 80
    talk.ask("MODE rule")
    talk.ask("MV 2 90")
    assert talk.rest().fault == "s2"
    talk.ask("PW 2 255 2000")
    began = talk.clock()
    assert talk.rest().fault == "s2" and talk.clock() - began < 0.6
    talk.ask("PW 2 60 400")  # a push that need not turn it is none
    assert talk.rest().fault == "-"


def test_the_client_homes_moves_and_calibrates(bench):
    bench.restart()
    arm = connect(bench.port)
    assert arm.home() == JointAngles(pytest.approx(-170, abs=0.3), pytest.approx(-160, abs=0.3))
    reached = arm.move_to(JointAngles(-150.0, -120.0))
    assert (reached.theta1_deg, reached.theta2_deg) == pytest.approx((-150, -120), abs=0.2)
    found = arm.calibrate(2)
    assert found.speed_per_volt == pytest.approx(bench.speed_per_volt[1], rel=0.1)
    reached = arm.move_to(JointAngles(-140.0, -100.0), one_side=True)
    assert (reached.theta1_deg, reached.theta2_deg) == pytest.approx((-140, -100), abs=0.2)
    assert (bench.link_deg(0), bench.link_deg(1)) == pytest.approx((-140, -100), abs=0.6)
    arm.stop()
    assert arm.status().state == "stop"

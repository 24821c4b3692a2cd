"""PROTOCOL.md, sentence by sentence, on every controller that speaks it: what test_conformance.py does not ask."""

import re

import pytest
from controllers import BACK_ENDS, open_back_end
from test_conformance import Talk

from stereo_lab.arm import protocol as wire

COMMANDS = ("ID", "GET 1 k", "RP 0", "WD 1000", "CS 0", "ST", "EN 1", "MV 1 5", "MA 5 0", "PW 1 10 20", "HM 1", "ZE 1", "SET 1 k 75",
            "MODE pid")  # fmt: skip
STATES = {  # lines that lead to a state, and what each of the commands above is answered with there; 0 is ok
    "off": ((), (0, 0, 0, 0, 0, 0, 0, 5, 5, 5, 5, 0, 0, 0)),
    "not busy": (("EN 1",), (0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0)),
    "moves": (("EN 1", "MV 1 90 20"), (0, 0, 0, 0, 0, 0, 0, 0, 0, 8, 8, 8, 8, 8)),
    "rule": (("EN 1", "MODE rule", "MV 1 90 20"), (0, 0, 0, 0, 0, 0, 0, 8, 8, 8, 8, 8, 8, 8)),
    "pushed": (("EN 1", "PW 1 30 1500"), (0, 0, 0, 0, 0, 0, 0, 8, 8, 8, 8, 8, 8, 8)),
    "homed": (("EN 1", "HM 1"), (0, 0, 0, 0, 0, 0, 0, 8, 8, 8, 8, 8, 8, 8)),
    "stop": (("EN 1", "!"), (0, 0, 0, 0, 0, 0, 0, 5, 5, 5, 5, 0, 0, 0)),
}


@pytest.fixture(scope="module", params=[n for n in BACK_ENDS if n != "pty"])
def bench(request):
    bench = open_back_end(request.param)
    yield bench
    bench.close()


@pytest.fixture
def talk(bench):
    bench.restart()
    talk = Talk(bench)
    talk.listen(2, wire.GREETING)
    return talk


def answers(talk, *lines, seconds=0.1):
    """What comes back to lines, or to bytes that are no line."""
    talk.listen(0.02)
    before = len(talk.lines)
    for line in lines:
        talk.port.write(line if isinstance(line, bytes) else line.encode() + b"\n")
        talk.listen(seconds)
    return talk.lines[before:]


@pytest.mark.parametrize(("line", "reply"), [
    (" \tID\t ", "ok armkit 1 joints=2 hz=500"), ("iD", "ok armkit 1 joints=2 hz=500"), ("n7 ID", "err 2 command"), ("SET 1 K 100", "err 3 argument"),
    ("MODE PID", "err 3 argument"), ("ZE 1 +5", "err 3 argument"), ("ZE 1 5.", "err 3 argument"), ("ZE 1 .5", "err 3 argument"),
    ("ZE 1 12345678", "err 3 argument"), ("ZE 1 00000005", "err 3 argument"), ("ZE 1 0000005", "ok"), ("ZE 1 1.1234567", "err 3 argument"),
    ("ZE 1 -1.123456", "ok"), ("ZE 1 --1", "err 3 argument"), ("ZE 01", "err 3 argument"), ("CS 01", "err 3 argument"), ("EN +1", "err 3 argument"),
    ("PW 1 255.9 100", "err 4 limit"), ("PW 1 300 x", "err 4 limit"), ("PW 1 x 3000", "err 3 argument"), ("MV 1 999 x", "err 3 argument"),
    ("MV 1 999", "err 4 limit"), ("MV 3 999", "err 3 argument"), ("XX 1 2 3", "err 2 command"), ("ID 1", "err 3 argument"), ("MV 1 10", "err 5 off"),
    ("MV 1 10 100.5", "err 4 limit"), ("MV 1 10 0.5", "err 4 limit"), ("ZE 1 360", "ok"), ("ZE 1 -360.1", "err 4 limit"), ("PW 1 10 0.9", "err 4 limit"),
    ("RP 19", "err 4 limit"), ("RP 60001", "err 4 limit"), ("WD 99", "err 4 limit"), ("WD 60001", "err 4 limit"), ("WD 0", "ok"), ("RP 0", "ok"),
    ("N12345 ID", "err 2 command"), ("N ID", "err 2 command"), ("N007 ID", "ok N7 armkit 1 joints=2 hz=500"), ("ID" + 61 * " ", "ok armkit 1 joints=2 hz=500"),
    ("ID" + 62 * " ", "err 6 too long"), (64 * " ", "err 6 too long"), ("ID*29B1", "err 1 checksum"), (" !", "err 2 command"), (" ?", "err 2 command"),
    ("GET 3 k", "err 3 argument"), ("GET 1 K", "err 3 argument"), ("GET 1", "err 3 argument"), ("SET 1 held 1", "err 3 argument"), ("HM 1 2", "err 3 argument"),
])  # fmt: skip
def test_what_a_line_is_answered_with(talk, line, reply):
    assert answers(talk, line) == [reply]


@pytest.mark.parametrize(
    ("command", "least", "most"),
    [
        ("ID", 0, 0), ("EN", 1, 1), ("ST", 0, 0), ("MV", 2, 3), ("MA", 2, 3), ("PW", 3, 3), ("ZE", 1, 2), ("HM", 1, 1), ("SET", 3, 3),
        ("GET", 2, 2), ("MODE", 1, 1), ("RP", 1, 1), ("WD", 1, 1), ("CS", 1, 1),
    ],
)  # fmt: skip
def test_how_many_arguments_a_command_takes(talk, command, least, most):
    if least:
        assert answers(talk, command + " 1" * (least - 1)) == ["err 3 argument"]
    assert answers(talk, command + " 1" * (most + 1)) == ["err 3 argument"]


def test_checksums(talk):
    sealed = wire.seal("ID")
    small = next(s for s in map(wire.seal, ("ID", "ID ", " ID", "ID  ")) if re.search("[A-F]", s.rpartition("*")[2]))
    head, _, digits = small.rpartition("*")
    assert answers(talk, small, f"{head}*{digits.lower()}") == ["ok armkit 1 joints=2 hz=500", "err 1 checksum"]
    assert answers(talk, sealed, sealed[:-1], sealed + " ", wire.seal(""), wire.seal("  ")) == [
        "ok armkit 1 joints=2 hz=500", "err 1 checksum", "err 1 checksum"
    ]  # fmt: skip
    assert answers(talk, "CS 1") == [wire.seal("ok")]
    assert answers(talk, "ID", wire.seal("XX"), "", "   ") == [wire.seal("err 1 checksum"), wire.seal("err 2 command")]
    assert wire.unseal(answers(talk, "?")[0])[1]
    assert answers(talk, wire.seal("CS 0"), "ID") == ["ok", "ok armkit 1 joints=2 hz=500"]


def test_bytes_that_are_no_characters(talk):
    assert answers(talk, b"I\x80D\n", b"\x07\n", b"\xc3\xa4\n", b"ID\n") == ["err 1 checksum"] * 3 + [
        "ok armkit 1 joints=2 hz=500"
    ]


def test_a_number_gets_the_same_answer_until_another_comes(talk):
    assert answers(talk, "N5 XX", "N5 ID") == ["err N5 2 command"] * 2  # refused counts as answered
    assert answers(talk, "N7 ZE 1 20", "ID*0000", "?", "", "N8", "N7 ZE 1 30")[-1] == "ok N7"
    assert talk.status().position_deg[0] == pytest.approx(20, abs=0.1)  # none of these made it forget
    assert answers(talk, "ID", "N7 ZE 1 30")[-1] == "ok N7"
    assert talk.status().position_deg[0] == pytest.approx(30, abs=0.1)  # a line without a number did
    assert answers(talk, "N1 CS 1", wire.seal("N1 CS 0"))[1] == wire.seal("ok N1")  # the same answer, not done again


def test_numbers_from_the_controller(talk):
    answers(talk, "SET 1 k 75.1236", "SET 1 g1 -0.0002", "SET 1 g2 -1.5", "SET 2 counts 65534.4")
    assert answers(talk, "GET 1 k", "GET 1 g1", "GET 1 g2") == ["ok 75.124", "ok 0.000", "ok -1.500"]
    assert float(answers(talk, "GET 2 counts")[0].split()[1]) == pytest.approx(65534.4, rel=1e-6)
    assert re.fullmatch(r"<off t=\d+ h=0 f=- p=0\.00,0\.00 v=0,0 lost=0 drop=0>", answers(talk, "?")[0])


def test_a_long_line_is_answered_when_it_ends(talk):
    assert answers(talk, b"x" * 100) == []
    assert answers(talk, b"!\xff*") == []  # in the middle of a line that is thrown away
    assert answers(talk, b"\n") == ["err 6 too long"]
    assert talk.status().state == "off"


def test_bytes_acted_on_at_once_belong_to_no_line(talk):
    assert answers(talk, b"!ID\n") == ["!estop", "ok armkit 1 joints=2 hz=500"]
    assert answers(talk, b"!!") == ["!estop"] * 2 or answers(talk, b"!") == ["!estop"]
    assert talk.status().state == "stop" and talk.status().fault == "e"
    assert answers(talk, b"ID!\n") == ["err 2 command"]  # not the first byte
    answers(talk, "EN 0")
    assert talk.status().state == "off" and talk.status().fault == "e"
    answers(talk, "EN 1")
    assert talk.status().state == "idle" and talk.status().fault == "-"


@pytest.mark.parametrize("state", STATES)
def test_what_every_state_accepts(talk, state):
    way, codes = STATES[state]
    for command, code in zip(COMMANDS, codes, strict=True):
        talk.bench.restart()
        talk.buffer = b""
        talk.listen(2, wire.GREETING)
        for line in way:
            answers(talk, line if line != "!" else b"\n!", seconds=0.06)
        reply = [line for line in answers(talk, command, seconds=0.06) if line.startswith(("ok", "err"))][0]
        assert int(reply.split()[1]) == code if code else reply.startswith("ok"), (state, command, reply)


def test_the_goal_counts_before_the_state(talk):
    answers(talk, "EN 1", "PW 1 30 1500")
    assert answers(talk, "MV 1 300") == ["err 4 limit"] and answers(talk, "MV 1 30") == ["err 8 busy"]
    answers(talk, "EN 0")
    assert answers(talk, "MV 1 300") == ["err 4 limit"] and answers(talk, "MV 1 30") == ["err 5 off"]


@pytest.mark.parametrize("name", wire.PARAMETERS)
def test_bounds_of_a_parameter(talk, name):
    low, high = wire.PARAMETERS[name]
    for value, reply in ((low, "ok"), (high, "ok"), (low - 0.5, "err 4 limit"), (high + 0.5, "err 4 limit")):
        assert answers(talk, f"SET 2 {name} {value:g}") == [reply]


def test_a_parameter_belongs_to_its_joint_and_leaves_angles_alone(talk):
    answers(talk, "ZE 2 33", "EN 1", "MV 2 53")
    stands = talk.rest().position_deg[1]
    answers(talk, "SET 2 counts 2000", "SET 2 k 100")
    assert answers(talk, "GET 1 counts", "GET 1 k") == ["ok 4094.400", "ok 75.000"]
    assert talk.status().position_deg[1] == pytest.approx(stands, abs=0.02)


def test_st_says_nothing_and_ends_at_once(talk):
    answers(talk, "EN 1")
    for move in ("MV 1 60", "PW 1 60 1000", "HM 1"):
        answers(talk, move, seconds=0.3)
        assert answers(talk, "ST", "?", seconds=0.02)[1].startswith("<idle")
        assert not [line for line in answers(talk, "", seconds=0.6) if line.startswith("!")]
        assert answers(talk, "MV 1 0") == ["ok"]
        talk.rest()
    assert talk.status().homed == (False, False)  # a homing that was ended


def test_events_of_two_joints_and_of_a_new_goal(talk):
    answers(talk, "EN 1", "MA 30 15")
    talk.rest()
    assert [line[:7] for line in talk.lines if line.startswith("!")] in (["!done 1", "!done 2"], ["!done 2", "!done 1"])
    talk.lines.clear()
    answers(talk, "MV 1 60", "MV 1 20")
    talk.rest()
    done = [line for line in talk.lines if line.startswith("!")]
    assert len(done) == 1 and float(done[0].split()[2]) == pytest.approx(20, abs=0.1)


def test_en_1_on_the_way_changes_nothing(talk):
    answers(talk, "EN 1", "MV 1 40", "EN 1")
    assert talk.rest().position_deg[0] == pytest.approx(40, abs=0.1)


def test_percent_makes_a_move_slower_in_the_same_way(talk):
    """A quarter of the speed takes four times as long, and its fastest is a quarter."""
    answers(talk, "EN 1")
    seen = {}
    for goal, percent in ((80, 100), (0, 25)):
        start, fastest = talk.clock(), 0.0
        answers(talk, f"MV 1 {goal} {percent}", seconds=0.01)
        while (status := talk.status()).state == "run":
            fastest = max(fastest, abs(status.speed_deg_s[0]))
            talk.listen(0.02)
        seen[percent] = talk.clock() - start, fastest
    assert seen[25][0] / seen[100][0] == pytest.approx(4, rel=0.15)
    assert seen[25][1] / seen[100][1] == pytest.approx(0.25, rel=0.2)


def test_a_new_goal_on_the_way_has_the_whole_acceleration(talk):
    """A tenth of the speed, from rest with a hundredth of the acceleration; turned round on the way at once."""
    answers(talk, "WD 0", "EN 1", "MV 1 100 10", seconds=0.1)
    talk.listen(2)
    here = talk.status().position_deg[0]
    talk.ask("MV 1 0 10")
    talk.listen(0.5)
    assert talk.status().speed_deg_s[0] < -8 and talk.status().position_deg[0] < here + 2
    talk.rest()


def test_what_holds_a_joint_goes_on_when_its_weight_becomes_known(talk):
    answers(talk, "EN 1", "MA 30 0")
    talk.rest()
    held_v = float(talk.ask("GET 1 held").split()[1])
    assert held_v > 0.05
    for line in ("ZE 1 30", "SET 1 g1 0.3", "SET 2 zone 6", "ZE 2 0", "SET 1 g2 0.1", "HM 2"):
        assert answers(talk, line, seconds=0.01) == ["ok"]
        assert float(talk.ask("GET 1 held").split()[1]) == pytest.approx(held_v, abs=0.03), line
    talk.rest(30)
    assert talk.bench.motor_deg(0) == pytest.approx(30, abs=1)


def test_reports_come_by_themselves(talk):
    talk.listen(0.5)
    talk.ask("RP 100")
    start = len(talk.lines)
    talk.listen(0.08)
    assert len(talk.lines) == start  # the first one after that time
    talk.listen(0.97)
    times = [int(re.search(r"t=(\d+)", line).group(1)) for line in talk.lines[start:] if line.startswith("<")]
    assert len(times) == 10 and {b - a for a, b in zip(times, times[1:], strict=False)} == {100}
    talk.ask("RP 0")
    start = len(talk.lines)
    talk.listen(0.5)
    assert len(talk.lines) == start


def test_reports_that_find_the_line_full_are_counted(talk):
    """A line of 63 takes 5.5 ms; so many answers leave no room for a report every 20 ms."""
    talk.ask("RP 20")
    for _ in range(60):
        talk.say("N1 ID\nN2 ID\nN3 ID\nN4 ID")
        talk.listen(0.004)
    talk.listen(1)
    talk.say("")  # where bytes were missed, all up to a line end is passed over
    talk.ask("RP 0")
    assert talk.status().dropped > 0


def test_a_report_needs_a_hundred_free_bytes(talk):
    """Two answers take about 60 of 128, and are gone within 6 ms: a report that comes meanwhile is left out."""
    talk.ask("RP 20")
    for k in range(200):
        talk.say("N1 ID\nN2 ID")
        talk.listen(0.006 + 0.002 * (k % 3))
    talk.ask("RP 0")
    assert 0 < talk.status().dropped < 70


def test_the_watchdog_hears_questions_and_lines_alone(talk):
    for keeps, sent in (
        (True, b"?"),
        (True, b"XX\n"),
        (True, b"ID\n"),
        (False, b"\n"),
        (False, b"ID*0000\n"),
        (False, b"N9\n"),
        (False, b"  \n"),
        (False, b"x" * 70 + b"\n"),
    ):
        talk.bench.restart()
        talk.buffer, talk.lines = b"", []
        talk.listen(2, wire.GREETING)
        answers(talk, "WD 300", "EN 1", "MV 1 150 20", seconds=0.02)
        for _ in range(10):
            answers(talk, sent, seconds=0.1)
        assert ("!watchdog" not in talk.lines) == keeps, sent
    status = talk.status()
    assert status.state == "off" and status.fault == "w"


def test_a_held_arm_is_not_let_fall_by_the_watchdog(talk):
    answers(talk, "EN 1", "MV 1 20")
    talk.rest()
    talk.listen(2.5)
    assert "!watchdog" not in talk.lines and talk.status().state == "idle"


def test_who_is_homed(talk):
    answers(talk, "ZE 2 10")
    assert talk.status().homed == (False, True)
    answers(talk, "EN 1", "ZE 1", "HM 2")
    assert talk.status().homed == (True, False)
    talk.rest(30)
    assert talk.status().homed == (True, True)
    answers(talk, "SET 1 k 80", "MODE rule", "EN 0")
    assert talk.status().homed == (True, True)


def test_a_fault_is_cleared_by_the_next_move(talk):
    answers(talk, "EN 1", b"\n!", "EN 0")
    assert talk.status().fault == "e"
    talk.bench.fault("hold", 1)
    answers(talk, "EN 1", "MV 1 30", seconds=0.6)
    assert talk.status().fault == "s1" and talk.status().state == "idle"
    answers(talk, "MV 2 10")
    assert talk.status().fault == "-"


def test_a_push_of_one_tick_ends_when_it_is_over(talk):
    answers(talk, "EN 1")
    said = answers(talk, "PW 1 200 1", "", seconds=0.5)
    assert [line[:7] for line in said if line.startswith("!")] == ["!done 1"]


def test_a_push_at_the_limit_has_no_other_event(talk):
    answers(talk, "SET 1 hi 5", "EN 1", "PW 1 120 800", seconds=0.05)
    talk.listen(1.5)
    assert [line[:8] for line in talk.lines if line.startswith("!")] == ["!limit 1"]
    assert answers(talk, "PW 1 -60 100") == ["ok"]  # back is allowed


def test_homing_goes_back_and_comes_slowly(talk):
    answers(talk, "ZE 2 -150", "EN 1", "HM 2")
    speeds = []
    while (status := talk.status()).state == "home":
        speeds.append(status.speed_deg_s[1])
        talk.listen(0.02)
    assert min(speeds) == pytest.approx(-60, abs=8) and max(speeds) > 20
    assert -20 < min(speeds[-25:]) < -5
    assert [line[:7] for line in talk.lines if line.startswith("!")] == ["!home 2"]
    answers(talk, "SET 2 home -100", "HM 2")
    assert talk.rest(30).position_deg[1] == pytest.approx(-100, abs=0.3)


def test_the_rule_goes_fast_and_then_slowly(talk):
    answers(talk, "SET 1 zone 30", "SET 1 st+ 0.8", "MODE rule", "EN 1", "MV 1 60")
    speeds = {}
    while (status := talk.status()).state == "run":
        speeds[status.position_deg[0]] = status.speed_deg_s[0]
        talk.listen(0.02)
    assert max(speeds.values()) > 120 and max(v for p, v in speeds.items() if p > 50) < 60
    assert any(line.startswith("!done 1") for line in talk.lines)


def test_a_joint_that_is_moved_off_its_place_is_brought_back(talk):
    """A push takes its place; ``ST`` and moves are held where they end."""
    answers(talk, "EN 1", "MV 1 20")
    talk.rest()
    talk.listen(3)
    assert talk.bench.motor_deg(0) == pytest.approx(20, abs=0.15)
    held_v = float(talk.ask("GET 1 held").split()[1])
    assert 0 < held_v < 1


def test_a_reversed_encoder_in_mode_rule_is_a_stall(talk):
    answers(talk, "MODE rule", "EN 1")
    talk.bench.fault("reverse", 1)
    answers(talk, "MV 1 90 10")
    talk.listen(4, "!")
    assert talk.lines[-1].startswith(("!stall 1", "!runaway 1"))
    assert abs(talk.bench.motor_deg(0)) < 40

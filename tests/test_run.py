"""The whole cell: the hand at a moving ball, balls that are not followed, and how a run ends. Truth comes from the virtual bench."""

import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from contextlib import closing, contextmanager
from dataclasses import replace
from types import SimpleNamespace

import cv2
import numpy as np
import pytest

from conftest import ROOT, slow_after_first
from stereo_lab import cli
from stereo_lab.arm import connect
from stereo_lab.arm.virtual.served import served_arm
from stereo_lab.cli.live import _show
from stereo_lab.errors import ArmError, StereoLabError, UnreachableTargetError
from stereo_lab.kinematics import JointAngles
from stereo_lab.live import Follower, VirtualBench, open_source, round_trip, run, touch_in_turn
from stereo_lab.live import usage as usage_module
from stereo_lab.live.follower import GAP_MM, IN_THE_WAY, STEADY, WRONG_SIDE
from stereo_lab.live.log import RunLog, header, read_log, write_csv
from stereo_lab.live.touching import _way
from stereo_lab.live.tracker import Track
from stereo_lab.live.usage import Usage
from stereo_lab.localization import Localizer
from stereo_lab.recording import Position, open_recording
from stereo_lab.results.live_cost import ToAndFro, hand_at_ball, page, to_the_arm, whole_run

HEAD = header("virtual:bench", "virtual://arm", "bench", {"pairs": 24})


@pytest.fixture(scope="module")
def localizer(bench):
    return Localizer.fit(bench)


@contextmanager
def cell(bench, path, late=0, url="virtual://arm"):
    """A homed arm before drawn cameras; both keep the arm's own time, which no busy computer disturbs."""
    with connect(url) as arm:
        arm.home()
        arm.set_limits(bench.arm.limits_deg)
        arm.move_to(JointAngles(60, 60))
        source = VirtualBench(bench, arm.port, late=late, clock=arm.line.clock, sleep=arm.line.listen)
        source.path = path
        yield arm, source


def apart(bench, arm, source, follower):
    """How far the place before the hand is from the ball, now, mm."""
    x, y, _ = source.path(source.now())
    tip = bench.arm.extended(follower.beyond_mm).forward(JointAngles(*arm.port.link_deg))
    return np.hypot(tip[0] - x, tip[1] - y)


def follow(bench, localizer, late, predict, seconds=6.0):
    with cell(bench, round_trip(bench, 100.0), late) as (arm, source):
        follower = Follower(arm, bench, predict=predict)
        gaps = [
            apart(bench, arm, source, follower)
            for moment in run(source, localizer, follower, seconds=seconds)
            if moment.frame.time_s > 3
        ]
    return float(np.mean(gaps))


def test_the_hand_stays_at_a_moving_ball(bench, localizer):
    """A ball at 100 mm/s; without prediction the hand lags by what the pictures are late, with it it does not."""
    prompt, late = (follow(bench, localizer, late, predict=False) for late in (0, 2))
    ahead = follow(bench, localizer, 2, predict=True)
    assert late > prompt + 4  # 67 ms at 100 mm/s
    assert ahead < 7 and ahead < prompt


def still(place):
    return lambda _: place


def says(bench, localizer, path, seconds=1.5, **more):
    with cell(bench, path, **more) as (arm, source):
        return [(m, arm.port.link_deg) for m in run(source, localizer, Follower(arm, bench), seconds=seconds)]


def test_a_ball_off_the_plane_is_told_and_not_chased(bench, localizer):
    for depth, side in ((950.0, "before"), (1050.0, "behind")):
        moments = says(bench, localizer, still((50.0, 250.0, depth)))
        told = [re.fullmatch(r"the ball is (\d+) mm (\w+) the arm's plane", m.said) for m, _ in moments[STEADY:]]
        assert {words[2] for words in told} == {side} and all(abs(int(words[1]) - 50) <= 2 for words in told)
        assert all(m.step.wanted is None for m, _ in moments)
        assert np.ptp([links for _, links in moments], axis=0).max() < 0.1


def test_a_ball_off_the_plane_by_less_than_its_radius_is_followed(bench, localizer):
    moments = says(bench, localizer, still((50.0, 250.0, 985.0)))
    assert {m.said for m, _ in moments[STEADY:]} == {"follows"}


def test_a_ball_out_of_reach_is_told_and_not_chased(bench, localizer):
    far = bench.arm.reach_mm[1] + bench.ball.diameter_mm / 2 + GAP_MM + 5
    moments = says(bench, localizer, still((-far * np.sin(0.6), far * np.cos(0.6), 1000.0)))
    assert {m.said for m, _ in moments[STEADY:]} == {"the ball is out of reach"}
    assert np.ptp([links for _, links in moments], axis=0).max() < 0.1


def test_a_ball_that_goes_out_of_reach_is_left_where_it_went(bench, localizer):
    far = bench.arm.reach_mm[1]

    def path(t):
        away = min(far - 80 + 70 * t, far + 40)
        return -away * np.sin(0.6), away * np.cos(0.6), 1000.0

    moments = says(bench, localizer, path, seconds=3)
    said = [m.said for m, _ in moments]
    assert said[-1] == "the ball is out of reach" and "follows" in said
    last = np.array([links for _, links in moments[-10:]])
    assert np.ptp(last, axis=0).max() < 0.3


def test_a_ball_that_jumps_is_lost_first_and_taken_up_as_a_new_one(bench, localizer):
    here, there = (100.0, 250.0, 1000.0), (-150.0, 250.0, 1000.0)
    moments = says(bench, localizer, lambda t: here if t < 1 else there, seconds=3)
    said = [m.said for m, _ in moments]
    jumped = next(k for k, (m, _) in enumerate(moments) if m.frame.time_s >= 1)
    lost = said.index("no ball", jumped)
    again = said.index("follows", lost)
    assert said[again - STEADY + 1 : again] == ["a new ball"] * (STEADY - 1)
    x = [bench.arm.extended(GAP_MM + 20).forward(JointAngles(*links))[0] for _, links in moments]
    assert min(x[jumped:again]) > 85 and x[-1] == pytest.approx(-150, abs=12)


def test_the_elbow_never_changes_sides_before_one_ball(bench, localizer):
    """The ball goes round the shoulder until only the other elbow reaches it: the arm holds, and says how to go on."""
    low, high = -10.0, 165.0
    narrow = replace(bench, arm=replace(bench.arm, limits_deg=((low, high), bench.arm.limits_deg[1])))
    path = lambda t: (300 * np.cos(1.0 + 0.4 * t), 300 * np.sin(1.0 + 0.4 * t), 1000.0)
    moments = says(narrow, localizer, path, seconds=3.5)
    sides = {np.sign(m.step.wanted.theta2_deg) for m, _ in moments if m.step.wanted is not None}
    assert len(sides) == 1 and WRONG_SIDE in {m.said for m, _ in moments}


def led(bench, arm, follower, path, seconds):
    """The steps of a follower that is told exactly where the ball is, and how near the links come to it; no picture is drawn."""
    start_s = now_s = arm.line.clock()
    while now_s < start_s + seconds:
        ball = path(now_s - start_s)
        velocity = tuple(np.subtract(path(now_s - start_s + 0.001), ball) / 0.001)
        step = follower.steer(Track(now_s, Position(*ball), velocity, (1.0, 1.0, 1.0), True, None), now_s)
        links = JointAngles(*arm.port.link_deg)
        yield step, links, bench.registration.clearance_mm([links] * 2, *ball)
        arm.wait(1 / 30)
        now_s = arm.line.clock()


def round_the_shoulder(t):
    angle = np.radians(195 - 17 * t)
    return 330 * np.cos(angle), 330 * np.sin(angle), 1000.0


@contextmanager
def turning(bench, limit_deg, start):
    """An arm whose shoulder turns that far either way, at some angles; with its recording."""
    wide = replace(bench, arm=replace(bench.arm, limits_deg=((-limit_deg, limit_deg), (-155.0, 155.0))))
    with connect("virtual://arm") as arm:
        arm.set_limits(wide.arm.limits_deg)
        arm.home()
        arm.move_to(JointAngles(*start))
        yield wide, arm


@pytest.mark.parametrize("limit_deg", [165.0, 180.0])
def test_the_shoulder_never_swings_round_to_a_ball_that_is_followed(bench, limit_deg):
    """The ball goes over the limit of the shoulder, where the arm would have to come from the other end of its range."""
    with turning(bench, limit_deg, (-130, -90)) as (wide, arm):
        follower = Follower(arm, wide)
        steps, links, _ = zip(*led(wide, arm, follower, round_the_shoulder, 5.5), strict=True)
        said = [step.said for step in steps]
        assert "follows" in said and said[-1] == WRONG_SIDE
        assert max(pose.theta1_deg for pose in links) < -100
        follower.steer(None, arm.line.clock())  # it is covered for a moment
        last = list(led(wide, arm, follower, lambda t: round_the_shoulder(5.5), 4.0))[-1]
        assert last[0].said == "follows" and 20 < last[2] < 35


def test_no_way_that_leads_through_the_ball_is_taken(bench):
    """Neither elbow is free from here; with the ball elsewhere one is."""
    with turning(bench, 165.0, (-135, 25)) as (wide, arm):
        follower = Follower(arm, wide)
        steps = [step for step, _, _ in led(wide, arm, follower, lambda t: (-70.0, -209.0, 1000.0), 0.5)]
        assert steps[-1].said == IN_THE_WAY and not any(step.wanted for step in steps)
        moved = list(led(wide, arm, follower, lambda t: (-200.0, -209.0, 1000.0), 3.0))[-1]
        assert moved[0].said == "follows" and 20 < moved[2] < 35


def test_a_ball_that_comes_back_into_the_plane_elsewhere_is_not_swept_away(bench):
    with turning(bench, 165.0, (60, 60)) as (wide, arm):
        follower, places = Follower(arm, wide), [(330.0, 0.0, 1000.0), (0.0, 330.0, 940.0), (-250.0, 0.0, 1000.0)]
        steps, _, gaps = zip(*led(wide, arm, follower, lambda t: places[min(int(t), 2)], 4.0), strict=True)
        assert [words for words in ("follows", WRONG_SIDE) if words in {s.said for s in steps}] == [
            "follows",
            WRONG_SIDE,
        ]
        assert min(gaps) > 20


class Recorder:
    """In place of an arm: writes down what it is asked for."""

    limits_deg = ((-165.0, 165.0), (-155.0, 155.0))
    homed = True

    def __init__(self):
        self.orders = []

    def steer(self, angles, percent=100.0):
        self.orders.append(percent)

    def goals_deg(self, angles):
        return []

    def get(self, joint, name):
        return {"acc": 500.0, "counts": 4096.0}[name]


def test_the_arm_slows_towards_its_limits(bench):
    follower = Follower(Recorder(), bench)
    paces = [follower._percent(JointAngles(angle, 90)) for angle in (0, 150, 157.5, 164, -165)]
    assert paces == pytest.approx([100, 100, 50, 20, 20])


@pytest.mark.parametrize("half_turn", [180.0, -180.0])
def test_of_two_turns_within_the_limits_the_nearer_one_is_taken(bench, half_turn):
    wide = replace(bench, arm=replace(bench.arm, limits_deg=((-200.0, 200.0), (-155.0, 155.0))))
    start, beyond = JointAngles(half_turn, 90), Follower(Recorder(), wide).beyond_mm
    for theta1 in (half_turn - 10, half_turn + 10):
        ball = Position(*wide.arm.extended(beyond).forward(JointAngles(theta1, 90)), 1000.0)
        assert Follower(Recorder(), wide)._poses(ball, start)[0].theta1_deg == pytest.approx(theta1)


def test_it_follows_by_a_learners_own_inverse(bench, localizer):
    asked = []

    def mine(x, y):
        asked.append((x, y))
        pose = bench.arm.extended(GAP_MM + bench.ball.diameter_mm / 2).inverse(x, y, "up")
        return pose.theta1_deg, pose.theta2_deg

    with cell(bench, still((60.0, 280.0, 1000.0))) as (arm, source):
        follower = Follower(arm, bench, inverse=mine)
        moments = list(run(source, localizer, follower, seconds=1.5))
        assert apart(bench, arm, source, follower) < 12 and moments[-1].step.wanted.theta2_deg < 0
    assert asked[-1] == pytest.approx((60, 280), abs=2)


@pytest.mark.parametrize("wrong", [(np.nan, 10.0), (400.0, 0.0)])
def test_a_learners_inverse_that_is_wrong_moves_nothing(bench, localizer, wrong):
    with cell(bench, still((60.0, 280.0, 1000.0))) as (arm, source):
        before = arm.port.link_deg
        moments = list(run(source, localizer, Follower(arm, bench, inverse=lambda x, y: wrong), seconds=1))
        assert moments[-1].said == "the ball is out of reach" and arm.port.link_deg == pytest.approx(before, abs=0.1)


OWN = [
    ({"inverse": lambda x, y: 10.0}, "inverse= should give two numbers; it got (60, 280"),
    ({"inverse": lambda x: (0, 0)}, "inverse= stopped when it got (60, 280"),
    ({"inverse": lambda x, y: None}, "and gave None: is its return missing?"),
    ({"predict": lambda p, v: p}, "predict= stopped when it got ("),
    ({"predict": lambda p, v, s: (p, v)}, "predict= should give one number; it got ("),
    ({"predict": lambda p, v, s: None}, "it got (60, 0, 0.03) and gave None: is its return missing?"),
    ({"predict": lambda p, v, s: p * np.nan}, "and gave [nan]."),
]


@pytest.mark.parametrize(("own", "words"), OWN, ids=range(len(OWN)))
def test_a_function_of_ones_own_that_stops_gets_a_sentence(bench, own, words):
    place = Position(60.0, 280.0, 1000.0, (1.0, 1.0, 1.0))
    track = Track(0.0, place, (0.0, 0.0, 0.0), (1.0, 1.0, 1.0), True, None)
    with connect("virtual://arm") as arm:
        arm.home()
        follower = Follower(arm, bench, **own)
        with pytest.raises(StereoLabError) as told:
            follower._aim(track, 0.0, arm.angles())
    assert words in str(told.value)


def test_a_ball_out_of_reach_is_not_asked_of_a_function_of_ones_own(bench):
    """Its arc cosine would stop there."""
    place = Position(600.0, 280.0, 1000.0, (1.0, 1.0, 1.0))
    with connect("virtual://arm") as arm:
        arm.home()
        follower = Follower(arm, bench, inverse=lambda x, y: 1 / 0)
        with pytest.raises(UnreachableTargetError):
            follower._aim(Track(0.0, place, (0.0, 0.0, 0.0), (1.0, 1.0, 1.0), True, None), 0.0, arm.angles())


@pytest.mark.parametrize(
    "place", [(-200.0, 200.0, 1000.0), (150.0, 120.0, 1000.0), (220.0, 150.0, 1000.0), (0.0, 330.0, 1000.0)]
)
def test_the_arm_comes_to_a_ball_from_the_side_that_is_free(bench, localizer, place):
    """With more room alone the arm would sweep through two of these four."""
    moments, stands = says(bench, localizer, still(place), seconds=3), bench.registration
    first = next(m for m, _ in moments if m.step.wanted is not None).step
    assert stands.clearance_mm([first.reached, first.wanted], *place) > bench.ball.diameter_mm / 2
    near = min(stands.clearance_mm([JointAngles(*links)] * 2, *place) for _, links in moments)
    assert near > bench.ball.diameter_mm / 2


def test_an_arm_that_does_not_know_where_it_stands_follows_nothing(bench):
    with connect("virtual://arm") as arm:
        arm.enable()
        with pytest.raises(StereoLabError, match=r"virtual://arm to be homed.*home\(\)"):
            Follower(arm, bench)


@pytest.mark.parametrize("gap_mm", [-1, "near", None])
def test_a_hand_keeps_out_of_the_ball(bench, gap_mm):
    with pytest.raises(StereoLabError, match="gap_mm: expected "):
        Follower(Recorder(), bench, gap_mm=gap_mm)


def test_however_it_ends_the_arm_rests(bench, localizer):
    with cell(bench, round_trip(bench)) as (arm, source):
        with closing(run(source, localizer, Follower(arm, bench))) as moments:
            for moment in moments:
                if moment.number == 30:
                    break
        arm.wait(1.0)
        assert arm.status().state == "idle" and arm.status().fault == "-"


def test_an_arm_that_is_unplugged_ends_the_run_and_the_log_is_whole(bench, localizer, tmp_path):
    log = RunLog(tmp_path / "run.jsonl", HEAD)
    with cell(bench, round_trip(bench)) as (arm, source), pytest.raises(ArmError, match="is gone"):
        for moment in run(source, localizer, Follower(arm, bench), [log]):
            arm.port.faults.unplugged = moment.number == 20
    found = read_log(tmp_path / "run.jsonl")
    assert len(found.records) == 21 and found.broken == 0


def test_an_arm_that_was_stopped_says_so(bench, localizer):
    with cell(bench, round_trip(bench)) as (arm, source), pytest.raises(ArmError, match=r"stopped.*arm\.enable"):
        for moment in run(source, localizer, Follower(arm, bench)):
            if moment.number == 5:
                arm.stop()


def test_a_camera_that_falls_silent_ends_the_run_and_the_arm_rests(bench, localizer):
    with cell(bench, round_trip(bench)) as (arm, source):
        read, count = source.read, iter(range(100))

        def silent():
            if next(count) == 20:
                raise StereoLabError("The left camera (0) is silent.")
            return read()

        source.read = silent
        with pytest.raises(StereoLabError, match="is silent"):
            list(run(source, localizer, Follower(arm, bench)))
        arm.wait(1.0)
        assert arm.status().state == "idle"


def test_a_run_tells_what_it_saw_and_asked_for(bench, localizer, tmp_path):
    log = RunLog(tmp_path / "run.jsonl", HEAD)
    with cell(bench, round_trip(bench), late=1) as (arm, source):
        moments, edges = list(run(source, localizer, Follower(arm, bench), [log], seconds=2)), arm.get(2, "counts")
    log.close()
    found = read_log(tmp_path / "run.jsonl")
    assert found.head == HEAD and len(found.records) == len(moments) == 61
    last, record = moments[-1], found.records[-1]
    assert record == json.loads(json.dumps(last.record()))
    assert record["x_mm"] == pytest.approx(last.track.position.x_mm, abs=0.01)
    assert record["reached1_deg"] == pytest.approx(last.step.reached.theta1_deg, abs=0.01)
    assert record["counts2"] == pytest.approx(record["reached2_deg"] / 360 * edges, abs=1)
    assert record["left_u"] == pytest.approx(last.track.detections[0].u, abs=0.01)
    assert last.latency_ms > 1000 / 30  # one picture late
    assert set(last.stages_ms) == {"wait", "find", "steer"} and record["said"] == "follows"
    assert {"lost_edges", "rate_hz", "rss_mb", "sigma_depth_mm", "right_score"} <= set(record)
    assert ("cpu_percent" in record) == (last.cpu_percent > 0)  # known after a second
    assert replace(last, cpu_percent=12.34).record()["cpu_percent"] == 12.3
    assert replace(last, track=None, step=None).record().get("x_mm") is None


def test_an_arm_that_is_stopped_while_it_homes_says_so(monkeypatch, capsys):
    def stopped(_):
        raise KeyboardInterrupt

    monkeypatch.setattr("stereo_lab.arm.Arm.home", stopped)
    assert cli.main(["run", "--arm", "virtual://arm", "--seconds", "1"]) == 130
    assert "The arm was told to stop, and its motors are off." in capsys.readouterr().out


def test_a_recording_runs_without_an_arm(localizer):
    moments = list(run(open_source("bench", fast=True), localizer))
    assert len(moments) == len(open_recording("bench").pairs("track"))
    assert {m.said for m in moments} <= {"sees the ball", "the ball is hidden", "no ball"} and moments[0].step is None


def test_three_balls_are_touched_in_turn(bench, localizer, tmp_path):
    places = [(100.0, 250.0, 1000.0), (-100.0, 280.0, 1000.0), (0.0, 330.0, 1000.0)]
    log = RunLog(tmp_path / "run.jsonl", HEAD)
    with connect("virtual://arm") as arm:
        arm.home()
        source = VirtualBench(bench, arm.port, clock=arm.line.clock, sleep=arm.line.listen)
        source.ball_mm, gaps = places[0], []
        tip = bench.arm.extended(bench.ball.diameter_mm / 2)
        move = arm.move_to

        def moved(angles, one_side=False):
            reached = move(angles, one_side)
            if one_side:
                gaps.append(np.subtract(tip.forward(JointAngles(*arm.port.link_deg)), source.ball_mm[:2]))
            return reached

        arm.move_to = moved
        move_on = lambda touched: setattr(source, "ball_mm", places[min(touched, 2)])
        said = list(touch_in_turn(source, localizer, arm, bench, move_on=move_on, sinks=[log]))
        assert arm.angles().theta1_deg == pytest.approx(-170, abs=1)
    assert [line.split(" at ")[0] for line in said if line.startswith("touched")] == [
        f"touched ball {k}" for k in (1, 2, 3)
    ]
    assert said[-1] == "home" and np.linalg.norm(gaps, axis=1).max() < 4
    assert [r for r in read_log(tmp_path / "run.jsonl").records if "reached1_deg" in r]


def test_a_touched_ball_that_stays_is_not_touched_again(bench, localizer):
    with connect("virtual://arm") as arm:
        arm.home()
        source = VirtualBench(bench, arm.port, clock=arm.line.clock, sleep=arm.line.listen)
        source.ball_mm = (100.0, 250.0, 1000.0)
        lines = touch_in_turn(source, localizer, arm, bench)
        said = [next(lines) for _ in range(4)]
        assert said[1].startswith("touched ball 1") and said[3] == "move the ball to another place"
        source.close()
        assert next(lines) == "the pictures have ended" and next(lines) == "home"


@pytest.mark.parametrize("place", [(-200.0, 200.0, 1000.0), (150.0, 120.0, 1000.0), (180.0, 300.0, 1000.0)])
@pytest.mark.parametrize("start", [(60.0, 60.0), (150.0, -40.0), (20.0, -100.0), (-60.0, 120.0)])
def test_the_arm_goes_round_a_ball_and_not_through_it(bench, localizer, start, place):
    """The shortest way goes through it in a third of these cases; and where the elbow is up the hand does not press at the end."""
    radius, stands = bench.ball.diameter_mm / 2, bench.registration
    arm = SimpleNamespace(angles=lambda: JointAngles(*start), limits_deg=bench.arm.limits_deg)
    *before, at = _way(bench, arm, place, radius)
    assert stands.clearance_mm([arm.angles(), *before], *place) > radius
    beyond = JointAngles(at.theta1_deg + 3, at.theta2_deg + 3)
    if at.theta2_deg < 0:
        assert stands.clearance_mm([before[-1], beyond, at], *place) > radius - 0.1


def test_touching_waits_for_a_ball_and_not_for_ever(bench, localizer):
    with connect("virtual://arm") as arm:
        arm.home()
        source = VirtualBench(bench, arm.port, clock=arm.line.clock, sleep=arm.line.listen)
        source.ball_mm = (0.0, 475.0, 1000.0)
        said = list(touch_in_turn(source, localizer, arm, bench, patience_s=3))
        assert said[1:] == ["the ball is out of reach", "no ball to touch for 3 s", "home"] and 3 < source.now() < 30


def test_a_ball_that_cannot_be_touched_is_told(bench, localizer):
    with connect("virtual://arm") as arm:
        arm.home()
        source = VirtualBench(bench, arm.port, clock=arm.line.clock, sleep=arm.line.listen)
        for place, words in (
            ((100.0, 250.0, 900.0), "the ball is 100 mm before the arm's plane"), ((0.0, 475.0, 1000.0), "the ball is out of reach"),
        ):  # fmt: skip
            source.ball_mm = place
            lines = touch_in_turn(source, localizer, arm, bench)
            assert [next(lines), next(lines)][1] == words
            lines.close()


# the log


def test_a_log_is_never_written_over(tmp_path):
    path = tmp_path / "run.jsonl"
    RunLog(path, HEAD).close()
    before = path.read_bytes()
    with pytest.raises(StereoLabError, match="exists already"):
        RunLog(path, HEAD)
    assert path.read_bytes() == before
    with pytest.raises(StereoLabError, match="cannot be written"):
        RunLog(tmp_path / "no folder" / "run.jsonl", HEAD)
    with pytest.raises(StereoLabError, match="folder"):
        RunLog(tmp_path, HEAD)


def test_a_broken_last_line_is_counted_and_left_out(tmp_path):
    path = tmp_path / "run.jsonl"
    log = RunLog(path, HEAD)
    for k in range(5):
        facts = {"number": k, "time_s": k / 10, "said": "follows", "seen": True, "dropped": k % 2}
        log.write(facts | {"rate_hz": 10.0 if k else 65.0})
    log.write({"said": "touched ball 1"})  # as an older kit wrote it, without a time
    log.close()
    with open(path, "a") as file:
        file.write('{"number": 5, "time_s": 0.')
    found = read_log(path)
    summary = found.summary()
    assert len(found.records) == 6 and found.broken == 1
    assert (summary["pictures"], summary["seen"], summary["dropped"]) == (5, 5, 2) and summary[
        "seconds"
    ] == pytest.approx(0.4)
    assert summary["rate_hz"]["mean"] == pytest.approx(10.0)  # four gaps in 0.4 s, whatever one gap seemed
    assert summary["said"] == {"follows": 5, "touched ball 1": 1} and summary["latency_ms"] is None


def test_what_is_no_log_is_refused(tmp_path):
    for name, text in (("a", ""), ("b", '{"kind": "something"}\n'), ("c", "[" * 9000), ("d", "\0\1\2")):
        (tmp_path / name).write_text(text)
        with pytest.raises(StereoLabError, match="is no log of a run"):
            read_log(tmp_path / name)
    (tmp_path / "e").write_text(json.dumps({**HEAD, "format": 2}) + "\n")
    with pytest.raises(StereoLabError, match="format 2"):
        read_log(tmp_path / "e")
    with pytest.raises(StereoLabError, match="No such file"):
        read_log(tmp_path / "f")


def test_a_log_as_a_table(tmp_path):
    log = RunLog(tmp_path / "run.jsonl", HEAD)
    log.write({"number": 0, "said": "no ball, yet"})
    log.write({"number": 1, "said": "follows", "x_mm": 1.5})
    log.close()
    write_csv(read_log(tmp_path / "run.jsonl"), tmp_path / "run.csv")
    assert (tmp_path / "run.csv").read_text() == 'number,said,x_mm\n0,"no ball, yet",\n1,follows,1.5\n'


def test_a_log_is_drawn(tmp_path, capsys):
    log = RunLog(tmp_path / "run.jsonl", HEAD)
    for k in range(40):
        log.write(
            {"number": k, "time_s": k / 10, "said": "sees the ball", "x_mm": float(k), "rss_mb": 80.0, "rate_hz": 10.0}
        )
    log.close()
    for ending in ("png", "svg"):
        assert cli.main(["log", str(tmp_path / "run.jsonl"), "--plot", str(tmp_path / f"run.{ending}")]) == 0
        assert (tmp_path / f"run.{ending}").stat().st_size > 10_000
    assert cli.main(["log", str(tmp_path / "run.jsonl"), "--plot", str(tmp_path / "run.xyz")]) == 2
    assert ".png or .svg or .pdf" in capsys.readouterr().err and not (tmp_path / "run.xyz").exists()
    RunLog(tmp_path / "empty.jsonl", HEAD).close()
    assert cli.main(["log", str(tmp_path / "empty.jsonl"), "--plot", str(tmp_path / "no.png")]) == 2
    assert "nothing to draw" in capsys.readouterr().err


def test_a_full_disk_ends_the_log_and_not_the_run(tmp_path):
    """The system refuses a file that grows beyond a limit, as a full disk does."""
    if os.name == "nt":
        pytest.skip("Windows has no such limit")
    path = tmp_path / "run.jsonl"
    code = (
        "import resource, sys\nfrom stereo_lab.live.log import RunLog\n"
        f"log = RunLog({str(path)!r}, {HEAD!r})\n"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (2000, 2000))\n"
        "for k in range(100):\n    log.write({'number': k, 'said': 'follows'})\n"
        "print(log.trouble)\nlog.close()\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT, timeout=60)
    assert done.returncode == 0 and done.stderr == ""
    assert done.stdout.count("\n") == 1 and "The log ends here; the run goes on." in done.stdout
    assert 20 < len(read_log(path).records) < 100


def test_a_run_whose_log_is_cut_off_says_so_at_its_end(tmp_path, monkeypatch, capsys):
    def full(log, _record):
        log.trouble = "No space left on device. The log ends here; the run goes on."

    monkeypatch.setattr(RunLog, "write", full)
    assert cli.main(["run", "--seconds", "1", "--log", str(tmp_path / "run.jsonl")]) == 1
    assert capsys.readouterr().err.splitlines()[-1].startswith(f"{tmp_path / 'run.jsonl'} is not whole")


def test_usage_is_told_in_parts_of_one_core(monkeypatch):
    now, busy = [0.0], [0.0]
    monkeypatch.setattr(usage_module.time, "monotonic", lambda: now[0])
    usage = Usage()
    monkeypatch.setattr(usage, "_look", lambda: (now[0], busy[0]))
    usage._looks.clear()
    usage._looks.append((0.0, 0.0))
    now[0], busy[0] = 0.9, 0.5
    usage.update()
    assert usage.cpu_percent == 0.0  # no second has passed
    now[0], busy[0] = 2.0, 0.5
    usage.update()
    assert usage.cpu_percent == pytest.approx(25)
    assert 30 < usage.rss_mb < 5000


# the commands


WITH_ARM = slow_after_first([], ["--arm", "virtual://arm"])  # which is homed by the clock


@pytest.mark.parametrize("arm", WITH_ARM, ids=["alone", "arm"])
def test_the_command_runs_logs_and_is_summarised(tmp_path, capsys, arm):
    log, table, facts = tmp_path / "run.jsonl", tmp_path / "run.csv", tmp_path / "log.json"
    assert cli.main(["run", *arm, "--seconds", "1", "--log", str(log)]) == 0
    said = capsys.readouterr().out
    assert ("homing both joints" in said) == bool(arm) and "pairs of pictures" in said
    assert cli.main(["run", *arm, "--seconds", "1", "--log", str(log)]) == 2
    told = capsys.readouterr()
    assert "a log is not written over" in told.err and "moves" not in told.out
    for option, ending in (("--csv", ".csv"), ("--plot", ".png"), ("--json", ".json")):
        same = shutil.copy(log, tmp_path / f"same{ending}")
        assert cli.main(["log", str(same), option, str(same)]) == 2 and "is the log itself" in capsys.readouterr().err
    assert cli.main(["log", str(log), "--csv", str(table), "--json", str(facts)]) == 0
    said = capsys.readouterr().out
    told = json.loads(facts.read_text())
    assert (
        told["header"]["arm"] == "".join(arm[1:]) and told["pictures"] == len(table.read_text().splitlines()) - 1 > 10
    )
    assert "picture to order" in said and ("x follows" if arm else "x sees the ball") in said


def test_pictures_that_were_dropped_are_told(bench, localizer, capsys):
    with VirtualBench(bench, fast=True) as source:
        moments = list(run(source, localizer, seconds=0.1))
    _show([replace(m, frame=replace(m.frame, dropped=2)) for m in moments], [])
    said = capsys.readouterr().out
    assert f"{len(moments)} pairs of pictures. {2 * len(moments)} more were dropped" in said and "CPU   - %" in said
    _show(moments, [])
    assert "dropped" not in capsys.readouterr().out


@pytest.mark.parametrize(
    ("words", "answer"),
    [
        (["run", "--touch"], "--touch needs an arm"),
        (["run", "--source", "cameras:0,0"], "two different cameras"),
        (["run", "--source", "nothing"], "nothing"),
        (["run", "--mqtt", "a b"], "HOST:PORT"),
        (["run", "--rate", "0"], "pairs a second; got 0"),
        (["run", "--rate", "nan"], "pairs a second; got nan"),
        (["run", "--rate", "-3", "--source", "bench"], "pairs a second; got -3"),
        (["log", "nothing.jsonl"], "No such file"),
    ],
)
def test_bad_words_get_a_sentence(words, answer, capsys):
    assert cli.main(words) == 2
    assert answer in capsys.readouterr().err


@pytest.mark.parametrize(
    "words", [["run", "--seconds", "0"], ["run", "--seconds=-1"], ["watch", "h", "--seconds", "nan"]]
)
def test_a_time_that_is_over_is_refused(words, capsys):
    with pytest.raises(SystemExit) as end:
        cli.main(words)
    assert end.value.code == 2 and "seconds above 0" in capsys.readouterr().err


@pytest.mark.skipif(os.name == "nt", reason="Windows sends Ctrl-C another way")
@pytest.mark.parametrize("number", [signal.SIGINT, getattr(signal, "SIGKILL", None)])
@pytest.mark.parametrize("arm", WITH_ARM, ids=["alone", "arm"])
def test_a_run_that_is_ended_from_outside_leaves_a_whole_log(tmp_path, number, arm):
    path = tmp_path / "run.jsonl"
    words = [sys.executable, "-m", "stereo_lab", "run", *arm, "--log", str(path)]
    process = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=ROOT)
    while process.poll() is None and (not path.exists() or path.read_bytes().count(b"\n") < 20):
        time.sleep(0.05)
    process.send_signal(number)
    out, err = process.communicate(timeout=60)
    assert err == "" and len(read_log(path).records) >= 19
    if number == signal.SIGINT:
        assert process.returncode == 0 and out.endswith("Stopped.\n") and read_log(path).broken == 0


ENDS = """
import sys, time
from stereo_lab.arm import JointAngles, connect
arm = connect(sys.argv[1])
arm.home()
print("homed", flush=True)
"""


def state_of(url):
    """Of a served arm, as the next one who connects finds it."""
    with connect(url) as arm:
        return arm.status().state


@pytest.mark.parametrize("end", ["", "raise ValueError", "sys.exit(3)"])
def test_a_program_that_ends_without_a_word_leaves_no_arm_on(end):
    with served_arm() as url:
        done = subprocess.run([sys.executable, "-c", ENDS + end, url], cwd=ROOT, capture_output=True, text=True)
        assert done.stdout == "homed\n" and state_of(url) == "off"


def test_an_arm_that_keeps_its_power_follows_a_second_time(tmp_path, capsys):
    """It knows where it stands when it is connected anew, and its motors are off."""
    with served_arm() as url:
        for homes in (True, False):
            path = tmp_path / f"homes {homes}.jsonl"
            assert cli.main(["run", "--arm", url, "--seconds", "2", "--log", str(path)]) == 0
            assert ("homing" in capsys.readouterr().out) is homes
            assert read_log(path).records[-1]["said"] == "follows"
        arm = connect(url)
        arm.enable()
        arm.stop()
        arm.port.close()  # as a program ends that is killed: the stop stays
        assert cli.main(["run", "--arm", url, "--seconds", "1"]) == 2
        assert "arm.enable()" in capsys.readouterr().err


@pytest.mark.skipif(os.name == "nt", reason="Windows ends programs another way")
@pytest.mark.parametrize("name", ["SIGTERM", "SIGHUP"])
def test_whoever_ends_a_run_ends_its_arm(name):
    with served_arm() as url:
        words = [sys.executable, "-m", "stereo_lab", "run", "--arm", url]
        process = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=ROOT)
        while "follows" not in (line := process.stdout.readline()):
            assert line, process.communicate()
        process.send_signal(getattr(signal, name))
        out, err = process.communicate(timeout=60)
        assert out.endswith("Stopped.\n") and err == "" and state_of(url) == "off"


def test_an_order_that_is_broken_off_is_taken_back(bench, localizer):
    """Whether it reached the arm nobody knows."""
    with connect("virtual://arm") as arm:
        arm.home()
        follower, sent = Follower(arm, bench), arm.steer

        def steer(*given):
            sent(*given)
            raise KeyboardInterrupt

        arm.steer = steer
        source = VirtualBench(bench, arm.port, clock=arm.line.clock, sleep=arm.line.listen)
        source.path = round_trip(bench, 100.0)
        with pytest.raises(KeyboardInterrupt):
            list(run(source, localizer, follower, seconds=6.0))
        arm.wait(1.0)
        assert arm.status().state == "idle" and max(map(abs, arm.status().speed_deg_s)) < 1


def test_an_arm_that_does_not_know_where_it_stands_touches_nothing(bench, localizer):
    with connect("virtual://arm") as arm, pytest.raises(ArmError, match=r"to be homed.*home\(\)"):
        next(touch_in_turn(VirtualBench(bench, arm.port, fast=True), localizer, arm, bench))


def test_an_arm_is_not_sent_where_a_rendered_calibration_says(bench, tmp_path, capsys):
    films = [str(tmp_path / f"{side}.avi") for side in ("left", "right")]
    for side, path in zip(("left", "right"), films, strict=True):
        film = cv2.VideoWriter(path, cv2.VideoWriter.fourcc(*"MJPG"), 10.0, bench.image_size)
        for pair in bench.pairs("track")[:5]:
            film.write(getattr(pair, side))
        film.release()
    words = ["run", "--source", f"cameras:{films[0]},{films[1]}"]
    assert cli.main([*words, "--arm", "virtual://arm"]) == 2
    assert "Open your recording. Name it with --recording" in capsys.readouterr().err
    assert cli.main([*words, "--seconds", "0.1"]) == 0
    assert "is rendered: its calibration is not that of your cameras" in capsys.readouterr().err


def test_steering_refuses_what_moving_refuses(bench):
    with connect("virtual://arm") as arm:
        with pytest.raises(ArmError, match="motors are off"):
            arm.steer(JointAngles(10, 10))
        with pytest.raises(ArmError, match=r"are off: arm\.enable"):
            arm.check()
        arm.enable()
        with pytest.raises(UnreachableTargetError):
            arm.steer(JointAngles(170, 0))
        for percent in (0.4, -5, 101):
            with pytest.raises(StereoLabError, match="expected 1 to 100, got"):
                arm.steer(JointAngles(20, 10), percent)
        arm.steer(JointAngles(20, 10), percent=50)
        assert arm.check().state == "run"
        arm.wait(3.0)
        assert arm.check().position_deg == pytest.approx((20, 10), abs=0.2)


def test_a_served_arm_is_an_arm_in_another_process():
    with served_arm() as url, connect(url) as arm:
        arm.enable()
        arm.steer(JointAngles(3, 0))
        assert arm.check().state == "run" and not hasattr(arm.port, "link_deg")
    with pytest.raises(ArmError):
        connect(url)


def test_a_film_goes_to_and_fro(bench):
    film = [pair.name for pair in bench.pairs("track")]
    names = [pair.name for pair in ToAndFro(bench, 2 * len(film) + 3, 10.0).pairs]
    assert names[: len(film)] == film and names[len(film)] == film[-2] and names[2 * len(film) - 2 :][:2] == film[:2]


def test_what_the_paper_cost_is_not_measured_without_a_film(second_rig):
    without = SimpleNamespace(sets=["evaluation"], truth={})
    assert whole_run(without) is None and to_the_arm(without) is None and hand_at_ball(without) is None
    assert page({"run": None, "latency_ms": None, "hand_mm": None}) == ["The live cell", ""]

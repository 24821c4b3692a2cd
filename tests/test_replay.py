"""What one controller saw, shown to the other, tick by tick: both must give their motors the same, and say the same.

The controller that was written from PROTOCOL.md alone drives simulated motors through a scene. Its encoder counts and
switches are then shown to the controller of the virtual arm. A sentence of the page that only one of them obeys shows as
another duty within the scene, where the motors themselves would hide it.
"""

import re

import numpy as np
import pytest
from controllers import Controller as ControllerOfThePage

from stereo_lab.arm.virtual.controller import Controller
from stereo_lab.arm.virtual.plant import BENCH_ARM, BENCH_MOTORS, Faults, Plant
from stereo_lab.motion import TICK_S, Motor

NO_CURRENT = 999  # a duty that there is not
SELDOM = 0.002
QUICK, SLUGGISH = Motor(time_constant_s=0.035), Motor(dead_band_v=(0.5, 0.6), time_constant_s=0.12)


class Scene:
    """Motors, links and switches as the scene has them; what the controller sees and does is written down.

    Attributes
    ----------
    extra_nm : [float, float], loads besides the arm's own weight
    switches : [None or bool, ...], a home switch that is stuck open or closed
    """

    def __init__(self, motors, arm):
        self.plant, self.extra_nm, self.switches = Plant(motors, Faults(), arm), [0.0, 0.0], [None, None]
        loads = self.plant._loads
        self.plant._loads = lambda: tuple((nm + more, j) for (nm, j), more in zip(loads(), self.extra_nm, strict=True))
        self.duties, self.seen = [0, 0], []

    def look(self):
        """What the controller sees in this tick."""
        closed = [self.plant.pressed(j) if stuck is None else stuck for j, stuck in enumerate(self.switches)]
        self.seen.append(([self.plant.counts(j) for j in (0, 1)], closed))

    def counts(self, j):
        return self.seen[-1][0][j] if self.seen else self.plant.counts(j)

    def pressed(self, j):
        return self.seen[-1][1][j]

    def set_duty(self, j, duty):
        self.duties[j] = duty
        self.plant.set_duty(j, duty)

    def turn(self):
        self.plant.still = False
        self.plant.tick()


class Shown:
    """The same, from what was written down."""

    def __init__(self, seen):
        self.seen, self.k, self.duties = seen, 0, [0, 0]

    def counts(self, j):
        return self.seen[self.k][0][j]

    def pressed(self, j):
        return self.seen[self.k][1][j]

    def set_duty(self, j, duty):
        self.duties[j] = duty


def play(steps, motors, arm):
    """Let the controller of the page play a scene; gives what it saw, the duties, what was said in which tick, and the lines."""
    scene = Scene(motors, arm)
    controller = ControllerOfThePage(scene)
    controller.sent()
    duties, said, lines = [], [], []
    for seconds, *does in steps:
        line = b""
        for what in does:
            if callable(what):
                what(scene)
            else:
                line += what.encode() + (b"" if what in "!?" else b"\n")
        assert len(line) <= 23, "longer lines take the page's controller more than a tick"
        for k in range(max(1, round(seconds / TICK_S))):
            scene.look()
            lines.append(line if k == 0 else b"")
            controller.receive(lines[-1])
            controller.tick()
            duties.append(tuple(scene.duties))
            said += [(len(duties), text) for text in controller.sent().decode().split("\r\n") if text]
            scene.turn()
    return scene.seen, duties, said, lines


def replay(seen, lines):
    """Show the controller of the virtual arm the same."""
    shown = Shown(seen)
    controller = Controller(shown)
    controller.line.tx.clear()
    duties, said = [], []
    for k, line in enumerate(lines):
        shown.k = k
        controller.tick()
        controller.line.feed(line)
        duties.append(tuple(shown.duties))
        said += [(k + 1, text) for text in controller.line.tx.decode().split("\r\n") if text]
        controller.line.tx.clear()
    return duties, said


def load(*nm):
    return lambda scene: scene.extra_nm.__setitem__(slice(None), nm)


def switch(j, closed):
    return lambda scene: scene.switches.__setitem__(j, closed)


def fault(name, *joints):
    return lambda scene: setattr(scene.plant.faults, name, frozenset(joints))


HOMED = [(0.1, "ZE 1 -160", "EN 1"), (4, "HM 2"), (4, "HM 1")]
WEIGHED = [*HOMED, (0.1, "SET 1 g1 0.13"), (0.1, "SET 1 g2 0.15"), (0.1, "SET 2 g2 0.15")]
SCENES = {
    "moves": [
        (0.1, "EN 1"), (1.2, "MV 1 60"), (0.5, "MV 1 -30"), (0.4, "MV 1 80 40"), (2, "MV 2 -45 30"), (1.5, "MA 10 20"), (3, "MA 0 120 50"),
        (0.4, "MA 90 -90"), (0.5, "ST"), (0.02, "?"), (0.3, "MV 1 5 7"), (0.02, "GET 1 held"), (2, "EN 1"), (0.3, "MV 1 90"), (1, "EN 0"), (0.02, "?"),
        (1, "EN 1"), (0.3, "MV 2 60"), (0.1, "!"), (0.02, "?"), (0.5, "MV 1 0"), (0.3, "EN 1"), (1.5, "MV 1 0.05"), (1, "MV 1 0.1"),
    ],
    "a load that comes and goes": [
        *HOMED, (2, "MA 30 20"), (1, load(0.3, 0.1)), (0.02, "GET 1 held"), (2, "MV 1 -20"), (1, load(-0.4, -0.2)), (2, "MA 40 -20"), (0.02, "GET 2 held"),
        (2, load(0.6, 0.0)), (2, "MV 1 90 40"), (1, load(0.0, 0.0)), (2, "MV 1 0"), (0.5, "ZE 1 10"), (0.02, "GET 1 held"), (1.5, "MV 1 40"),
    ],
    "too much load": [
        *HOMED, (2, "MA 30 0"), (1.5, load(1.1, 0.0)), (0.02, "?"), (0.5, load(0.0, 0.0)), (1, "EN 1"), (0.5, load(0.0, -0.75)), (2, "MV 2 60"),
        (1, load(0.0, -1.2)), (1, "EN 1"), (2, "MV 2 0"), (1, load(0.0, 0.0), "EN 1"), (2, "MV 2 10"), (2, load(0.78, 0.0)), (2, "MV 1 60"),
        (1, load(0.0, 0.0)), (1, "EN 1"), (0.4, load(2.0, 0.0)), (1, load(0.0, 0.0)), (1, "EN 1"), (0.5, load(-4.0, 0.0)),
        (0.5, load(0.0, 0.0)),
    ],
    "weights": [
        *WEIGHED, (2, "MA 0 0"), (0.02, "GET 1 held"), (2, "MA 60 -100"), (0.1, "SET 1 g1 0.4"), (0.02, "GET 1 held"), (1, "SET 2 g1 0.2"), (2, "MA 100 40"),
        (0.1, "ZE 2 90"), (0.02, "GET 2 held"), (1, "SET 2 counts 3000"), (1.5, "MV 2 60"), (3, "HM 2"), (0.02, "GET 1 held"), (1.5, "MV 1 0"),
        (0.1, "SET 1 g1 4"), (1, "SET 1 g1 -4"),
    ],
    "pushes": [
        (0.1, "EN 1"), (0.5, "PW 1 40 100"), (0.5, "PW 1 -60.9 301"), (1.2, "PW 2 90 400"), (0.5, "PW 2 -200 1"), (0.5, "PW 2 255 3"), (0.4, "PW 1 9 200"),
        (1, load(-0.5, 0.0)), (0.1, "SET 1 hi -60"), (1.2, "PW 1 20 200"), (0.1, "SET 1 hi 165"), (1, load(0.5, 0.0)), (1.5, "PW 1 5 300"), (1.5, "PW 1 -90 200"), (1.5, "PW 1 100 60"), (1, load(0.0, 0.0)), (0.1, "SET 1 hi 30"), (0.1, "SET 1 lo -30"),
        (2, "PW 1 90 1500"), (2, "PW 1 -80 1500"), (1, "PW 1 -80 500"), (1, "PW 1 80 100"), (0.1, fault("stalled", 1)), (0.6, "PW 1 60 500"), (0.6, "PW 1 180 500"),
        (0.1, fault("stalled"), "EN 1"), (0.3, "PW 2 60 1000"), (0.5, "ST"), (0.3, "PW 2 -60 1000"), (0.5, "EN 0"), (0.5, "EN 1"), (1.5, load(-1.3, 0.0)),
        (0.5, load(0.0, 0.0)), (0.5, "EN 1"), (0.1, "PW 2 60 500"), (1, "MODE rule"), (1, "PW 2 60 200"),
    ],
    "a load carries a push on": [
        *WEIGHED, (2, "MA 80 0"), (0.2, load(-0.7, 0.0), "PW 1 -20 200"), (2,), (0.02, "?"), (0.2, load(0.0, 0.0)), (1.0, "PW 1 -90 500"), (0.3, "EN 0"),
        (0.3, load(-0.6, 0.0)), (1.5, "EN 1"), (0.02, "?"),
    ],
    "the paper's way": [
        (0.1, "EN 1"), (0.1, "MODE rule"), (2, "MV 1 60"), (0.02, "?"), (0.02, "GET 1 held"), (3, "MV 1 0 30"), (2, "MV 1 3"), (3, "MA 60 -60"), (3, "MV 2 0 5"),
        (0.1, "SET 1 zone 25"), (3, "MV 1 0"), (0.5, "MV 1 90"), (0.5, "ST"), (2, "MV 1 90 40"), (1, fault("stalled", 2)), (2, "MV 2 90"), (1, fault("stalled")),
        (0.1, "EN 1"), (0.1, load(-0.9, 0.0)), (2, "MV 1 100"), (0.1, load(-2.2, 0.0)), (1, "MV 1 100"), (0.5, load(0.0, 0.0)), (0.1, "EN 1"), (1, "MODE pid"), (1.5, "MV 1 20"), (0.1, "MODE rule"), (0.1, fault("reversed", 2)),
        (2, "MV 2 100 20"), (0.5, "EN 1"), (0.1, "MODE pid"), (4, "HM 1"),
    ],
    "the paper's way to a limit": [
        (0.1, "EN 1"), (0.1, "MODE rule"), (4, "MV 1 165"), (4, "MV 2 -155"), (4, "MV 2 150"), (0.1, "SET 1 cruise 360"), (4, "MV 1 -165"), (0.1, "EN 1"), (4, "MV 1 160"),
    ],
    "the paper's way with a weight": [
        *WEIGHED, (2, "MA 30 20"), (0.5, load(0.25, 0.0)), (1.5, "MV 1 40"), (0.02, "GET 1 held"), (0.5, "MODE rule"), (2, "MV 1 70"), (1, "PW 1 60 150"), (0.3, "MV 1 0"),
        (1, "ST"), (0.02, "?"), (1, "MODE pid"), (1.5, "MV 1 20"),
    ],
    "wires swapped": [
        (0.1, "EN 1"), (0.1, fault("reversed", 1)), (1, "MV 1 60"), (0.02, "?"), (0.2, "EN 1"), (1, "HM 1"), (0.2, "EN 1"), (1, "PW 1 120 500"), (0.1, "EN 1"),
        (0.3, "PW 1 15 500"), (0.5, "MV 2 40"), (0.3, fault("reversed", 2)), (1, "MV 2 80"), (0.5, "EN 1"), (0.1, "SET 2 counts 200"), (1, "MV 2 0"),
    ],
    "a coarse encoder": [(0.1, "SET 1 counts 100"), (0.1, "EN 1"), (2, "MV 1 40"), (2, "MV 1 0"), (0.5, "PW 1 90 200"), (2, "MV 1 3"), (1, "PW 1 15 300")],
    "something holds it": [
        (0.1, "EN 1"), (0.3, "MV 1 90"), (1, fault("stalled", 1)), (0.3, fault("stalled"), "EN 1"), (0.2, fault("stalled", 2)), (1, "MV 2 50"), (0.5, "MV 2 -50"),
        (0.5, fault("stalled")), (2, "MV 2 50 3"), (0.5, fault("stalled", 2)), (4, "MV 2 0"), (0.5, "MV 1 0"),
    ],
    "homing": [
        (0.1, "ZE 1 -160", "ZE 2 -140"), (0.1, "EN 1"), (0.01, "HM 2"), (0.4, "HM 1"), (4, "?"), (0.02, "?"), (3, "HM 1"), (1, "MV 1 -150"), (0.1, switch(0, True)),
        (3, "HM 1"), (0.1, switch(0, None)), (0.1, "EN 1"), (0.1, "SET 1 home -100"), (3, "HM 1"), (1, "MV 1 -60"), (0.3, "HM 1"), (0.5, "ST"), (0.02, "?"),
        (0.1, "HM 1"), (0.004, switch(0, True)), (4, switch(0, None)), (1, "MV 1 -40"), (0.2, "HM 1"), (0.006, switch(0, True)), (4, switch(0, None)),
    ],
    "homing from far on its switch": [
        (0.1, "EN 1"), (0.1, switch(0, True), "HM 1"), (0.35,), (1.2, switch(0, None)), (0.3,), (3, switch(0, True)), (0.1, switch(0, None)), (0.1, "EN 1"),
        (0.1, switch(0, True), "HM 1"), (0.7,), (5, switch(0, None)), (0.1, "EN 1"), (0.1, switch(1, True), "HM 2"), (6,), (0.1, "EN 1", switch(1, None)), (1, "MV 2 10"),
    ],
    "homing without a switch": [
        (0.1, "SET 2 counts 1500"), (0.1, "WD 0", "EN 1"), (1, "MV 2 150"), (1, "ZE 2 -150"), (1, "MV 2 150"), (0.1, switch(1, False), "HM 2"), (9,), (0.1, "EN 1"), (0.1, "ZE 1 160"), (0.1, switch(0, False), "HM 1"), (9,), (0.5, "?"),
    ],
    "silence": [
        (0.1, "EN 1"), (2, "MV 1 150 10"), (0.1, "WD 500", "EN 1"), (1, "MV 1 150 10"), (0.02, "?"), (1, "EN 1"), (3, "MV 1 0"), (0.1, "RP 100", "WD 0"), (2, "MV 1 150 30"), (0.05, "RP 0"), (2, "WD 0"),
        (0.5, "EN 0"), (2,), (0.2, load(-1.5, 0.0)), (0.5, load(0.0, 0.0)), (0.5,),
    ],
}  # fmt: skip


def kept_awake(steps):
    """Questions between the steps, so that no watchdog ends a long one."""
    for seconds, *does in steps:
        yield min(seconds, 0.4), *does
        for _ in range(int(seconds / 0.4)):
            yield 0.4, "?"


def words_and_numbers(text):
    """A line without its numbers; those with a point, which are angles and volts; and the whole ones."""
    found = re.findall(r"-?\d+\.\d+|(?<=[=,])-?\d+", text)
    exact, whole = ([float(n) for n in found if ("." in n) == point] for point in (True, False))
    return re.sub(r"-?\d+\.\d+|(?<=[=,])-?\d+", "#", text), exact, whole


def differences(duties, others, lines, said):
    """The ticks and joints in which two controllers want another duty.

    Just after a line or an event one of them may be a tick ahead. Elsewhere a duty may be rounded to its neighbour, seldom.
    """
    news = {k for k, line in enumerate(lines) if line} | {tick - 1 for tick, _ in said}
    after = np.zeros(len(lines), bool)
    for k in news:
        after[k : k + 3] = True
    found = []
    for j in (0, 1):
        one, other = ([NO_CURRENT if duty[j] is None else duty[j] for duty in both] for both in (duties, others))
        gaps = np.abs(np.array([other[:1] + other[:-1], other, other[1:] + other[-1:]]) - one)
        rounded = (gaps[1] == 1) & ~after
        same = np.where(after, gaps.min(axis=0) <= 8, gaps[1] == 0)
        if rounded.mean() < SELDOM:
            same |= rounded
        found += [(int(k), j) for k in np.flatnonzero(~same)]
    return sorted(found)


@pytest.mark.parametrize("motors", ["bench", "quick and sluggish"])
@pytest.mark.parametrize("name", SCENES)
def test_both_controllers_do_and_say_the_same(name, motors):
    motors = BENCH_MOTORS if motors == "bench" else (QUICK, SLUGGISH)
    steps = SCENES[name] if name == "silence" else list(kept_awake(SCENES[name]))
    seen, duties, said, lines = play(steps, motors, BENCH_ARM)
    others, other_said = replay(seen, lines)
    for k, j in differences(duties, others, lines, said)[:1]:
        heard = [text for tick, text in said if tick <= k + 1][-3:]
        pytest.fail(f"joint {j + 1} at {k * TICK_S:.3f} s: duty {duties[k][j]} and {others[k][j]}; said last: {heard}")
    assert [words_and_numbers(text)[0] for _, text in said] == [words_and_numbers(text)[0] for _, text in other_said]
    for (tick, text), (other_tick, other_text) in zip(said, other_said, strict=True):
        assert abs(tick - other_tick) <= 1
        (_, exact, whole), (_, other_exact, other_whole) = words_and_numbers(text), words_and_numbers(other_text)
        assert exact == pytest.approx(other_exact, abs=0.011) and whole == pytest.approx(other_whole, abs=2.1)

"""What must not break an arm: the virtual controller and the firmware in the simulated chip see it in the same way."""

from dataclasses import replace

import controllers
import pytest

from stereo_lab.arm.virtual.controller import Controller
from stereo_lab.arm.virtual.plant import BENCH_ARM, BENCH_MOTORS, END_STOPS_DEG, Faults, Plant
from stereo_lab.motion import TICK_S


class Cut(Plant):
    """A plant in which the second wire of some encoders may be off: the lone line goes to and fro by one."""

    cut = frozenset()

    def counts(self, j):
        count = super().counts(j)
        return count >> 1 & 1 if j + 1 in self.cut else count


class Twin:
    """The virtual controller with a bench of its own, and what it said and did.

    Attributes
    ----------
    said : str, all lines
    places : list of float, degrees; where the first motor was, tick by tick
    """

    def __init__(self, arm):
        self.plant = Cut(BENCH_MOTORS, Faults(), arm)
        self.controller = Controller(self.plant)
        self.said, self.places = "", []

    def fault(self, name, joint):
        if name == "cut":
            self.plant.cut = frozenset({joint})
        else:
            self.plant.faults.reversed = frozenset({joint})

    def do(self, seconds, *lines):
        """Send lines, and let time pass."""
        for line in lines:
            self.controller.line.feed(line.encode() + b"\n")
        for _ in range(round(seconds / TICK_S)):
            self.controller.tick()
            self.plant.tick()
            self.places.append(self.plant.positions[0])
        self.said += bytes(self.controller.line.tx).decode()
        self.controller.line.tx.clear()


class Chip:
    """The same, of the firmware in the simulated chip."""

    def __init__(self, arm, monkeypatch):
        monkeypatch.setattr(controllers, "BENCH_ARM", arm)
        self.bench = controllers.ChipBench()
        self.library, self.chip = self.bench.port.library, self.bench.port.chip
        self.said, self.places = "", []
        self.do(0.1)

    def fault(self, name, joint):
        self.bench.fault(name, joint)

    def do(self, seconds, *lines):
        for line in lines:
            self.bench.port.write(line.encode() + b"\n")
        for _ in range(round(seconds / TICK_S)):
            self.library.chip_run_us(self.chip, round(TICK_S * 1e6))
            self.places.append(self.bench.motor_deg(0))
        self.said += self.bench.port.read(self.bench.port.in_waiting).decode()


@pytest.fixture(params=["twin", "chip"])
def start(request, monkeypatch):
    """A function that starts an arm with so much in its hand, None: what it carries anyway; its motors are on."""

    def start(load_g=None, *faults):
        arm = BENCH_ARM if load_g is None else replace(BENCH_ARM, weight=replace(BENCH_ARM.weight, load_g=load_g))
        found = Twin(arm) if request.param == "twin" else Chip(arm, monkeypatch)
        for name, joint in faults:
            found.fault(name, joint)
        found.do(0.1, "WD 0", "EN 1")
        return found

    return start


@pytest.mark.parametrize(("goal", "cruise"), [(165, 180), (165, 360), (-165, 360)])
def test_by_the_rule_a_goal_at_a_limit_leaves_the_end_stop_alone(start, goal, cruise):
    arm = start()
    arm.do(4, "MODE rule", f"SET 1 cruise {cruise}", f"MV 1 {goal}")
    farthest = max(arm.places, key=abs)
    assert abs(farthest) < abs(END_STOPS_DEG[0][goal > 0]) - 3
    assert ("!done 1" in arm.said) == (abs(farthest) >= 165)  # the slow voltage may be too little to lift the arm


def test_by_the_rule_a_goal_far_from_the_limits_is_passed_as_ever(start):
    arm = start()
    arm.do(3, "MODE rule", "MV 1 60")
    assert "!done 1" in arm.said and 63 < max(arm.places) < 70


@pytest.mark.parametrize("cruise", [20, 60, 180, 360])
def test_by_the_rule_an_encoder_with_one_wire_off_is_a_stall_after_a_few_degrees(start, cruise):
    arm = start(0, ("cut", 1))
    arm.do(4, "MODE rule", f"SET 1 cruise {cruise}", "MV 1 160")
    assert "!stall 1" in arm.said
    assert max(arm.places) < 15  # and that is where it has come to rest


@pytest.mark.parametrize(
    ("load_g", "goal", "percent"),
    [(0, 60, 100), (0, 90, 12), (0, -90, 12), (None, 90, 25), (60, -2, 100), (100, -40, 30)],
)
def test_by_the_rule_an_honest_move_is_no_stall(start, load_g, goal, percent):
    arm = start(load_g)
    arm.do(9, "MODE rule", f"MV 1 {goal} {percent}")
    assert "!done 1" in arm.said and "!stall" not in arm.said


def test_the_count_of_lost_edges_goes_beyond_16_bits(monkeypatch):
    """Of the chip; the virtual arm loses none."""
    arm = Chip(BENCH_ARM, monkeypatch)
    for _ in range(40000):
        for joint in (1, 2):
            arm.fault("skip", joint)
        arm.library.chip_run_us(arm.chip, 20)
    arm.do(0.1, "?")
    assert int(arm.said.partition(" lost=")[2].split()[0]) == pytest.approx(80000, rel=0.01)

"""The virtual controller, the firmware and PROTOCOL.md are one controller: their numbers are the same."""

import contextlib
import re

import pytest

from conftest import ROOT
from stereo_lab.arm import protocol as wire
from stereo_lab.arm.virtual import controller, joint
from stereo_lab.arm.virtual.plant import BENCH_ARM, END_STOPS_DEG, SWITCHES_DEG, Faults, Plant
from stereo_lab.errors import UnreachableTargetError
from stereo_lab.motion import Motor, rules
from stereo_lab.recording import open_recording

SKETCH = (ROOT / "stereo_lab/firmware/arm_controller/arm_controller.ino").read_text(encoding="utf-8")
PROTOCOL = (ROOT / "stereo_lab/firmware/PROTOCOL.md").read_text(encoding="utf-8")
CONSTANTS = {
    name: float(value)
    for line in re.findall(r"^const (?:float|u?int\w+) (.*?);", SKETCH, re.M)
    for name, value in re.findall(r"([A-Z_]+) = (-?[\d.]+)", line)
}


@pytest.mark.parametrize("name", sorted(CONSTANTS))
def test_constants_of_the_sketch_are_those_of_the_package(name):
    found = [getattr(module, name) for module in (rules, joint, controller, wire) if hasattr(module, name)]
    for value in found:
        assert value == CONSTANTS[name]
    if not found:
        assert name in ("TICK_MS", "TICKS_A_SECOND", "HOME_ACC", "STOP_LOST",
                        "STATUS_BYTES", "ANSWER_BYTES", "BRAKE_TICKS", "KICK_V")  # fmt: skip


def test_most_constants_are_shared():
    shared = [name for name in CONSTANTS if any(hasattr(m, name) for m in (rules, joint, controller, wire))]
    assert len(shared) >= 18


def test_parameters_have_the_same_bounds_in_the_sketch():
    rows = re.findall(r'\{"(\S+)", AT\(\w+\)(?: \+ sizeof\(float\))?, (-?\d+), (\d+)\}', SKETCH)
    assert {name: (int(low), int(high)) for name, low, high in rows} == wire.PARAMETERS


def test_parameters_have_the_bounds_and_the_defaults_that_the_protocol_promises():
    told, defaults, second = {}, {}, {}
    for names, bounds, after in re.findall(r"^\| (`.*?) \| [^|]+ \| (−?\d+, \d+) \| (.*?) \|", PROTOCOL, re.M):
        first, _, of_second = after.partition("; joint 2 ")
        names = re.findall(r"`(.*?)`", names)
        for target, values in ((defaults, numbers(first)), (second, numbers(of_second))):
            target.update(zip(names, values * (len(names) if len(values) == 1 else 1), strict=False))
        told.update(dict.fromkeys(names, tuple(numbers(bounds))))
    assert told == wire.PARAMETERS
    assert defaults == joint.DEFAULTS
    assert second == joint.SECOND_JOINT


def numbers(text):
    return [float(word.replace("−", "-")) for word in re.findall(r"−?[\d.]+", text)]


def test_errors_have_the_same_names():
    names = re.search(r"ERRORS\[\] = \{(.*?)\};", SKETCH).group(1)
    assert dict(enumerate(re.findall(r'"(.*?)"', names))) == {0: "", **wire.ERRORS}


@pytest.mark.parametrize(("milliseconds", "ticks"), [(1, 1), (2, 1), (500, 250), (2000, 1000), (5000, 2500)])
def test_a_push_lasts_as_long_as_it_says(milliseconds, ticks):
    virtual = controller.Controller(Plant((Motor(), Motor()), Faults()))
    virtual.enable(True)
    virtual.push(0, 100, milliseconds)
    assert virtual.joints[0].push_ticks == ticks


def test_one_set_of_limits_everywhere():
    """The recording, the controllers after power-up, and the arm that is drawn and weighed; and it reaches enough balls."""
    arm = open_recording("bench").arm
    told = tuple((j["lo"], j["hi"]) for j in (joint.DEFAULTS, {**joint.DEFAULTS, **joint.SECOND_JOINT}))
    assert arm.limits_deg == BENCH_ARM.limits_deg == told
    assert (arm.l1_mm, arm.l2_mm, arm.weight) == (BENCH_ARM.l1_mm, BENCH_ARM.l2_mm, BENCH_ARM.weight)
    rows = re.findall(r"start_joint\(joints\[\d\], (\d+), (-?\d+)\)", SKETCH)
    assert tuple((-float(range_), float(range_)) for range_, _ in rows) == told
    assert tuple(float(home) for _, home in rows) == SWITCHES_DEG
    for (low, high), home, (first, last) in zip(told, SWITCHES_DEG, END_STOPS_DEG, strict=True):
        assert first < home < low < high < last and high - low < 340
    reached = 0
    for sample in open_recording("bench").judges("plane"):
        with contextlib.suppress(UnreachableTargetError):
            reached += bool(arm.solutions(sample.reference.x_mm, sample.reference.y_mm))
    assert reached >= 14

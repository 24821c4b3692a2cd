"""The arm's weight: the virtual arm's links and motors against MuJoCo, and where an arm that is switched off goes."""

import math
from dataclasses import replace

import numpy as np
import pytest

from conftest import ROOT, skip_unless_ci
from stereo_lab.arm import connect
from stereo_lab.arm.virtual.plant import BENCH_MOTORS, END_STOPS_DEG, SWITCHES_DEG, Faults, Plant
from stereo_lab.cli import main
from stereo_lab.kinematics import GRAVITY_M_S2, ArmWeight, JointAngles, TwoLinkArm, holding_torque_nm
from stereo_lab.motion import TICK_S, Motor

SHIPPED = TwoLinkArm(250.0, 200.0)
LIGHT = TwoLinkArm(250.0, 200.0, weight=ArmWeight(30, 15, None, motor_g=96, motor_at_mm=-90, elbow_g=50))
HEAVY = TwoLinkArm(250.0, 200.0, weight=ArmWeight(120, 60, 100, 120, motor_at_mm=200, elbow_g=30, hand_g=40, load_g=60))
MOTORS = (
    Motor(80.0, (0.12, 0.12), 0.05, backlash_deg=0.0, counts_per_turn=4096.0, gear_loss=0.0),
    Motor(75.0, (0.10, 0.10), 0.04, backlash_deg=0.0, counts_per_turn=4096.0, gear_loss=0.0),
)


@pytest.fixture(scope="module")
def mujoco():
    try:
        import mujoco
    except ImportError:
        skip_unless_ci("needs MuJoCo: pip install .[oracle]")
    return mujoco


def in_mujoco(mujoco, arm, motors, braked=False):
    """The same arm as MuJoCo's: links as rods, all else as points; friction, and the brake of a short-circuited motor."""
    w, l1, l2 = arm.weight, arm.l1_mm / 1000, arm.l2_mm / 1000
    center1 = l1 / 2 if w.center1_mm is None else w.center1_mm / 1000
    center2 = l2 / 2 if w.center2_mm is None else w.center2_mm / 1000

    def body(name, at, parts, motor, inner=""):
        mass = sum(kg for kg, _, _ in parts)
        center = sum(kg * x for kg, x, _ in parts) / mass
        turning = sum(own + kg * (x - center) ** 2 for kg, x, own in parts)
        rubs = motor.torque_per_volt * motor.dead_band_v[0]
        brake = motor.torque_per_volt / math.radians(motor.speed_per_volt) if braked else 0
        return (
            f'<body name="{name}" pos="{at} 0 0"><joint name="{name}" axis="0 0 1" armature="{motor.inertia_kg_m2}" '
            f'damping="{brake}" frictionloss="{rubs}"/><inertial pos="{center} 0 0" mass="{mass}" '
            f'diaginertia="{turning} {turning} {turning}"/>{inner}</body>'
        )

    ends = w.hand_g + w.load_g
    second = [(w.link2_g / 1000, center2, w.link2_g / 1000 * (l2 - center2) ** 2 / 3), (ends / 1000, l2, 0.0)]
    first = [
        (w.link1_g / 1000, center1, w.link1_g / 1000 * (l1 - center1) ** 2 / 3), (w.motor_g / 1000, w.motor_at_mm / 1000, 0.0),
        (w.elbow_g / 1000, l1, 0.0),
    ]  # fmt: skip
    links = body("shoulder", 0, first, motors[0], body("elbow", l1, second, motors[1]))
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><compiler angle="radian" balanceinertia="true"/><option gravity="0 -{GRAVITY_M_S2} 0" '
        f'timestep="0.0001" integrator="implicitfast"/><worldbody>{links}</worldbody></mujoco>'
    )
    return model, mujoco.MjData(model)


@pytest.mark.parametrize("arm", [SHIPPED, LIGHT, HEAVY])
def test_holding_torque_is_mujocos(mujoco, arm):
    model, data = in_mujoco(mujoco, arm, MOTORS)
    for pose in np.random.default_rng(1).uniform(-180, 180, (50, 2)):
        data.qpos[:], data.qvel[:] = np.radians(pose), 0
        mujoco.mj_forward(model, data)
        told = holding_torque_nm(arm, JointAngles(*pose.tolist()))
        assert told == pytest.approx(data.qfrc_bias.tolist(), rel=0.01, abs=1e-6)


def fall(arm, motors, pose, duty, seconds=0.5):
    """The plant's joints after some time from rest in a pose: let go, or braked."""
    plant = Plant(motors, Faults(), arm)
    plant.positions, plant.links = [float(p) for p in pose], [float(p) for p in pose]
    for j in (0, 1):
        plant.set_duty(j, duty)
    plant.still = False
    for _ in range(round(seconds / TICK_S)):
        plant.tick()
    return plant.positions


@pytest.mark.parametrize("arm", [LIGHT, HEAVY])
@pytest.mark.parametrize("braked", [False, True])
@pytest.mark.parametrize("pose", [(20.0, 30.0), (0.0, 90.0), (50.0, -60.0), (40.0, 70.0), (10.0, -100.0)])
def test_it_falls_as_mujocos_arm_does(mujoco, arm, braked, pose):
    """After half a second from rest: let go, with friction alone; and braked by its short-circuited motors."""
    model, data = in_mujoco(mujoco, arm, MOTORS, braked)
    data.qpos[:] = np.radians(pose)
    mujoco.mj_step(model, data, round(0.5 / model.opt.timestep))
    falls = np.subtract(fall(arm, MOTORS, pose, 0 if braked else None), pose)
    true = np.degrees(data.qpos) - pose
    assert np.abs(true).max() > 1
    assert np.abs(falls - true).max() < 0.02 * np.abs(true).max() + 0.02


def test_a_switch_closes_at_one_place_of_its_joint():
    """From stop to stop: one stretch at the low end, that begins where it is said to; and no joint has a whole turn."""
    plant = Plant(BENCH_MOTORS, Faults())
    for j, (low, high) in enumerate(END_STOPS_DEG):
        places = np.arange(low, high, 0.05)
        closed = []
        for place in places:
            plant.links[j] = place
            closed.append(plant.pressed(j))
        assert closed[0] and not closed[-1] and np.sum(np.diff(closed)) == 1
        assert places[np.argmin(closed)] == pytest.approx(SWITCHES_DEG[j], abs=0.06)
        assert high - low < 350


def test_the_arm_weighs_itself_with_what_it_carries():
    with connect("virtual://arm?load_g=60") as arm:
        arm.home()
        for fit, true in zip(arm.weigh(), arm.port.weight_v, strict=True):
            assert (fit.g1_v, fit.g2_v) == pytest.approx(true, abs=0.03)
        assert arm.get(1, "g2") == pytest.approx(arm.port.weight_v[0][1], abs=0.03)


def test_a_loaded_arm_sinks_when_it_is_switched_off_and_an_empty_one_does_not():
    sunk = {}
    for load in (0, 100):
        with connect(f"virtual://arm?load_g={load}") as arm:
            arm.move_to(JointAngles(30.0, 0.0))
            arm.disable()
            arm.port.sleep(2.0)
            sunk[load] = 30 - arm.port.link_deg[0]
    assert sunk[0] < 1 < 50 < sunk[100]


def test_switched_off_it_is_braked_while_it_turns_and_then_let_go():
    with connect("virtual://arm?load_g=100") as arm:
        arm.move_to(JointAngles(30.0, 0.0))
        arm.disable()
        arm.port.sleep(0.3)
        assert arm.port._plant.volts == [0.0, 0.0] and not arm.port.at_rest  # sinks, braked
        arm.port.sleep(8.0)
        assert arm.port._plant.volts == [None, None] and arm.port.at_rest


def test_a_push_that_a_load_carries_on_is_caught():
    with connect("virtual://arm?load_g=100") as arm:
        arm.move_to(JointAngles(45.0, 0.0))
        before = arm.port.link_deg[0]
        arm.push(1, 0.0, 0.3)  # nothing holds it for so long
        caught = arm.port.link_deg[0]
        arm.wait(2.0)
        assert before - 60 < caught < before - 1
        assert arm.port.link_deg[0] == pytest.approx(caught, abs=8)


def hand_speed(load_g, duty, friction_v, start):
    """The largest speed of the hand, m/s, of the plant that is pushed a little out of rest in a pose and left alone."""
    arm = TwoLinkArm(250.0, 200.0, weight=replace(ArmWeight(), load_g=ArmWeight().load_g + load_g))
    motors = (Motor(),) * 2 if friction_v is None else (Motor(dead_band_v=(friction_v,) * 2, gear_loss=0.0),) * 2
    plant = Plant(motors, Faults(), arm)
    plant.positions, plant.links, plant.speeds = list(start), list(start), [-1.0, -0.5]
    plant.volts = [duty] * 2
    most = 0.0
    for _ in range(round(6 / TICK_S)):
        plant.still = False
        plant.tick()
        slopes = arm.jacobian(JointAngles(*plant.links)) @ plant.speeds
        most = max(most, float(np.hypot(*slopes)) / 1000)
    return most


@pytest.mark.parametrize(
    ("load_g", "duty", "friction_v", "told"),
    [
        (0, 0.0, None, "stays where it is, or sinks"), (0, None, None, "stays, if the gears rub"), (100, 0.0, None, "sinks"),
        (100, None, None, "falls"), (0, None, 0.001, "falls"), (100, None, 0.001, "falls"),
    ],
)  # fmt: skip
def test_the_page_on_building_says_how_fast_it_falls(load_g, duty, friction_v, told):
    page = (ROOT / "stereo_lab/firmware/README.md").read_text(encoding="utf-8")
    fastest = max(hand_speed(load_g, duty, friction_v, start) for start in ((0.0, 0.0), (60.0, 0.0), (85.0, 0.0)))
    assert told in page
    if told.startswith("stays"):
        assert fastest < 0.02
    else:
        assert f"{told}, its hand at up to {fastest:.1f} m/s" in page


def test_the_page_on_building_says_what_the_command_prints(capsys):
    assert main(["arm", "torque"]) == 0
    page = (ROOT / "stereo_lab/firmware/README.md").read_text(encoding="utf-8")
    for line in capsys.readouterr().out.splitlines():
        if "kgf" in line:
            assert line.strip() in page


def test_an_arm_that_sinks_is_caught_when_it_is_switched_on():
    with connect("virtual://arm?load_g=100") as arm:
        arm.move_to(JointAngles(50.0, 0.0))
        arm.disable()
        arm.port.sleep(0.5)
        arm.enable()
        arm.wait(0.6)
        caught = arm.port.link_deg[0]
        arm.wait(1.5)
        assert caught < 45 and arm.port.link_deg[0] == pytest.approx(caught, abs=6)
        assert arm.status().state in ("idle", "run")

"""Lesson 05: the paper's equations against made truth, an independent library, and numbers worked out by hand."""

import numpy as np
import pytest

from conftest import skip_unless_ci
from stereo_lab.errors import StereoLabError, UnreachableTargetError
from stereo_lab.kinematics import (
    GRAVITY_M_S2,
    ArmWeight,
    JointAngles,
    TurretAngles,
    TurretArm,
    TwoLinkArm,
    holding_torque_nm,
    inertia_kg_m2,
    worst_poses,
    worst_torque_nm,
)
from stereo_lab.kinematics.angles import wrap

BENCH = TwoLinkArm(250.0, 200.0)


def random_arms(seed, count):
    """Arms of all proportions, each with a reachable point."""
    rng = np.random.default_rng(seed)
    for l1, l2 in rng.uniform(20, 400, (count, 2)):
        arm = TwoLinkArm(l1, l2)
        r, turn = rng.uniform(*arm.reach_mm), rng.uniform(-np.pi, np.pi)
        yield arm, r * np.cos(turn), r * np.sin(turn)


@pytest.mark.parametrize(
    ("l1", "l2", "x", "y", "down", "up"),
    [
        (10, 10, 10, 10, (0, 90), (90, -90)),
        (12, 9, 15, 0, (-36.8699, 90), (36.8699, -90)),
        (12, 9, 5, 15, (37.1360, 83.3536), (105.9941, -83.3536)),
        (12, 9, -8, -10, (-171.0499, 106.4039), (-86.2697, -106.4039)),
        (15, 10, 18, 7, (-9.4873, 80.7931), (51.9883, -80.7931)),
        (12, 9, 21, 0, (0, 0), (0, 0)),
        (12, 9, 3, 0, (0, 180), (0, -180)),
    ],
)
def test_inverse_gives_the_angles_worked_out_by_hand(l1, l2, x, y, down, up):
    arm = TwoLinkArm(l1, l2)
    for elbow, expected in (("down", down), ("up", up)):
        angles = arm.inverse(x, y, elbow)
        assert arm.forward(angles) == pytest.approx((x, y), abs=1e-9)
        assert -180 < angles.theta1_deg <= 180
        if expected and None not in expected:
            assert (angles.theta1_deg, angles.theta2_deg) == pytest.approx(expected, abs=1e-4)


def test_theta1_is_wrapped():
    assert TwoLinkArm(12, 9).inverse(-10, 8, "up").theta1_deg == pytest.approx(183.7 - 360, abs=0.05)


def test_stretched_and_folded_are_exact():
    arm = TwoLinkArm(12, 9)
    assert arm.inverse(21, 0) == JointAngles(0, 0)
    assert arm.inverse(3, 0) == JointAngles(0, 180)
    assert TwoLinkArm(9, 12).inverse(3, 0) == JointAngles(180, 180)


def test_origin_of_equal_links_is_reachable_and_of_others_is_not():
    assert TwoLinkArm(10, 10).inverse(0, 0) == JointAngles(0, 180)
    with pytest.raises(UnreachableTargetError, match="3 mm out of reach"):
        TwoLinkArm(12, 9).inverse(0, 0)


def test_forward_undoes_inverse_to_a_billionth_of_a_millimetre():
    for arm, x, y in random_arms(0, 3000):
        for elbow in ("down", "up"):
            assert arm.forward(arm.inverse(x, y, elbow)) == pytest.approx((x, y), abs=1e-9)


@pytest.mark.parametrize("gap_mm", [1e-2, 1e-5, 1e-8, 1e-11, 0.0])
def test_forward_undoes_inverse_at_the_rims(gap_mm):
    for arm in (BENCH, TwoLinkArm(200.0, 250.0), TwoLinkArm(220.0, 220.0)):
        near, far = arm.reach_mm
        for turn in np.radians(np.arange(-180, 180, 7)):
            for r in (near + gap_mm, far - gap_mm):
                point = r * np.cos(turn), r * np.sin(turn)
                assert arm.forward(arm.inverse(*point)) == pytest.approx(point, abs=1e-9)


def test_arrays_agree_with_scalars_and_mark_what_is_out_of_reach():
    rng = np.random.default_rng(1)
    x, y = rng.uniform(-500, 500, (2, 400))
    for elbow in ("down", "up"):
        angles = BENCH.inverse(x, y, elbow)
        for k in range(len(x)):
            if np.isnan(angles.theta1_deg[k]):
                assert np.isnan(angles.theta2_deg[k])
                with pytest.raises(UnreachableTargetError):
                    BENCH.inverse(x[k], y[k], elbow)
            else:
                one = BENCH.inverse(x[k], y[k], elbow)
                assert (one.theta1_deg, one.theta2_deg) == (angles.theta1_deg[k], angles.theta2_deg[k])
    assert 50 < np.isnan(BENCH.inverse(x, y).theta1_deg).sum() < 350


@pytest.mark.parametrize(("x", "y"), [(500, 0), (0, -450.001), (10, 10), (450 * (1 + 1e-9), 0)])
def test_out_of_reach_says_how_far(x, y):
    r = np.hypot(x, y)
    gap = r - 450 if r > 450 else 50 - r
    with pytest.raises(UnreachableTargetError, match=f"It is {gap:.3g} mm out of reach"):
        BENCH.inverse(x, y)


@pytest.mark.parametrize("bad", [np.nan, np.inf, "three", None])
def test_bad_points_are_named(bad):
    with pytest.raises(StereoLabError, match="coordinates"):
        BENCH.inverse(bad, 100.0)


def test_bad_elbow_lengths_and_limits_are_named():
    with pytest.raises(StereoLabError, match="elbow"):
        BENCH.inverse(300, 0, "left")
    with pytest.raises(StereoLabError, match="longer than 0"):
        TwoLinkArm(250, -1)
    with pytest.raises(StereoLabError, match="low, high"):
        TwoLinkArm(250, 200, ((10, -10), (0, 90)))


@pytest.mark.parametrize("forgotten", [((-90, 90), (-120, 120)), ((-90, 90),), (90,), (((90, -90), (-120, 120)),)])
def test_limits_without_their_inner_brackets_are_told(forgotten):
    with pytest.raises(StereoLabError, match=r"Expected \(low, high\) .* as in \(\(-90, 90\), \(-120, 120\)\); got"):
        TwoLinkArm(250, 200, *forgotten)


def test_what_is_no_weight_and_no_angles_is_told():
    with pytest.raises(StereoLabError, match="Expected an ArmWeight .*got 3"):
        TwoLinkArm(250, 200, ((-90, 90), (-120, 120)), 3)
    for ask in (BENCH.forward, BENCH.within_limits, BENCH.jacobian):
        with pytest.raises(StereoLabError, match=r"Expected JointAngles.*got \(10, 20\)"):
            ask((10, 20))


@pytest.mark.parametrize("part", [{"load_g": -5}, {"hand_g": "8"}, {"motor_at_mm": np.nan}, {"elbow_g": None}])
def test_a_weight_that_is_none_is_named(part):
    with pytest.raises(StereoLabError, match=f"{next(iter(part))} of an arm's weight; got"):
        ArmWeight(**part)


def test_solutions_keep_to_the_limits():
    arm = TwoLinkArm(250, 200, ((-90, 90), (-150, 150)))
    assert len(arm.solutions(300, 100)) == 2
    assert [p.theta2_deg > 0 for p in arm.solutions(-100, 300)] == [False] or len(arm.solutions(-100, 300)) == 1
    assert len(arm.solutions(450, 0)) == 1
    with pytest.raises(UnreachableTargetError, match="they turn from -90 to 90"):
        arm.solutions(-300, -50)
    with pytest.raises(UnreachableTargetError, match="out of reach"):
        arm.solutions(600, 0)


def test_limits_beyond_half_a_turn_are_used():
    arm = TwoLinkArm(250, 200, ((0.0, 270.0), (-150.0, 150.0)))
    for pose in (JointAngles(250.0, 40.0), JointAngles(30.0, -60.0)):
        found = arm.solutions(*arm.forward(pose))
        assert any(np.allclose((f.theta1_deg, f.theta2_deg), (pose.theta1_deg, pose.theta2_deg)) for f in found)
        assert all(arm.within_limits(f) for f in found)
    assert wrap([720, -180, 540, 180, -181, 10]).tolist() == [0, 180, 180, 180, 179, 10]


def test_an_extended_arm_touches_a_ball_from_outside():
    """The hand ends at the ball's surface, and the forearm points at its middle."""
    arm = TwoLinkArm(250, 200, ((-165, 165), (-155, 155)))
    for x, y in ((300.0, 120.0), (-150.0, 200.0), (90.0, -130.0)):
        for pose in arm.extended(20.0).solutions(x, y):
            hand = np.array(arm.forward(pose))
            elbow = 250 * np.array([np.cos(np.radians(pose.theta1_deg)), np.sin(np.radians(pose.theta1_deg))])
            assert np.hypot(*(hand - (x, y))) == pytest.approx(20.0, abs=1e-9)
            assert np.hypot(*(elbow - (x, y))) == pytest.approx(220.0, abs=1e-9)  # hand between elbow and ball


def test_jacobian_is_the_slope_of_forward():
    rng = np.random.default_rng(2)
    angles = JointAngles(*rng.uniform(-170, 170, (2, 50)))
    step = 1e-5
    for column, moved in enumerate(
        (
            JointAngles(angles.theta1_deg + step, angles.theta2_deg),
            JointAngles(angles.theta1_deg, angles.theta2_deg + step),
        )
    ):
        slope = (np.array(BENCH.forward(moved)) - np.array(BENCH.forward(angles))).T / step
        assert np.allclose(BENCH.jacobian(angles)[:, :, column], slope, atol=1e-4)
    determinant = np.linalg.det(BENCH.jacobian(angles))
    assert np.allclose(determinant, 250 * 200 * np.sin(np.radians(angles.theta2_deg)) * (np.pi / 180) ** 2)
    assert BENCH.jacobian(JointAngles(0.0, 90.0)).shape == (2, 2)


def test_turret_reaches_points_in_space():
    arm, rng = TurretArm(BENCH), np.random.default_rng(3)
    x, y, z = rng.uniform(-300, 300, (3, 500))
    angles = arm.inverse(x, y, z)
    good = ~np.isnan(angles.turret_deg)
    assert good.sum() > 300
    assert np.allclose(np.array(arm.forward(angles))[:, good], np.array([x, y, z])[:, good], atol=1e-9)
    distance = np.linalg.norm([x, y, z], axis=0)
    assert (good == ((distance >= 50) & (distance <= 450))).all()
    one = arm.inverse(x[good][0], y[good][0], z[good][0])
    assert one.turret_deg == angles.turret_deg[good][0]


def test_turret_turns_the_plane_of_the_arm():
    arm = TurretArm(BENCH, (-90, 90))
    flat = BENCH.inverse(300, 100)
    assert arm.inverse(300, 100, 0) == TurretAngles(0.0, flat.theta1_deg, flat.theta2_deg)
    assert arm.inverse(0, 100, -300).turret_deg == pytest.approx(90)  # away from the cameras
    assert arm.inverse(0, 300, 0).turret_deg == 0
    assert not arm.within_limits(arm.inverse(-300, 100, 1))
    assert arm.within_limits(arm.inverse(300, 100, 200))
    with pytest.raises(UnreachableTargetError):
        arm.inverse(400, 0, 400)
    for ask in (arm.forward, arm.within_limits):
        with pytest.raises(StereoLabError, match=r"Expected TurretAngles\(turret_deg, theta1_deg, theta2_deg\), got"):
            ask((1, 2, 3))
    for parts in ((None,), (BENCH, (10, -10)), (BENCH, None)):
        with pytest.raises(StereoLabError, match="Expected a TwoLinkArm|for the turret"):
            TurretArm(*parts)


@pytest.fixture(scope="module")
def ikpy():
    try:
        from ikpy.chain import Chain
        from ikpy.link import OriginLink, URDFLink
    except ImportError:
        skip_unless_ci("ikpy is not installed (extra: oracle)")

    def chain(l1, l2, turret=False):
        """Rotations about z, links along x; a turret turns about y first."""
        along, still = np.array, np.zeros(3)
        links = [OriginLink()]
        if turret:
            links.append(URDFLink("turret", still, still, rotation=along([0, 1, 0])))
        links.append(URDFLink("shoulder", still, still, rotation=along([0, 0, 1])))
        links.append(URDFLink("elbow", along([l1, 0, 0]), still, rotation=along([0, 0, 1])))
        links.append(URDFLink("hand", along([l2, 0, 0]), still, joint_type="fixed", rotation=None))
        return Chain(links, active_links_mask=[False] + [True] * (len(links) - 2) + [False])

    return chain


def test_an_independent_library_puts_the_hand_where_inverse_wants_it(ikpy):
    for arm, x, y in random_arms(4, 1000):
        chain = ikpy(arm.l1_mm, arm.l2_mm)
        for elbow in ("down", "up"):
            angles = arm.inverse(x, y, elbow)
            place = chain.forward_kinematics([0, *np.radians([angles.theta1_deg, angles.theta2_deg]), 0])[:3, 3]
            assert np.allclose(place, [x, y, 0], atol=1e-9)


def test_an_independent_solver_finds_the_same_poses(ikpy):
    """A numeric solver stops where it likes; wherever it arrives, it arrives at one of our two poses."""
    arrived = 0
    for arm, x, y in random_arms(5, 60):
        chain = ikpy(arm.l1_mm, arm.l2_mm)
        theirs = chain.inverse_kinematics([x, y, 0])
        if np.linalg.norm(chain.forward_kinematics(theirs)[:3, 3] - [x, y, 0]) > 1e-6:
            continue
        arrived += 1
        gaps = []
        for ours in (arm.inverse(x, y, elbow) for elbow in ("down", "up")):
            gap = np.degrees(theirs[1:3]) - [ours.theta1_deg, ours.theta2_deg]
            gaps.append(np.abs((gap + 180) % 360 - 180).max())
        assert min(gaps) < 1e-3, (arm, x, y)
    assert arrived > 30


def test_an_independent_library_turns_the_turret_the_same_way(ikpy):
    arm, rng = TurretArm(BENCH), np.random.default_rng(6)
    chain = ikpy(250.0, 200.0, turret=True)
    for _ in range(300):
        angles = TurretAngles(*rng.uniform(-170, 170, 3))
        theirs = chain.forward_kinematics(
            [0, *np.radians([angles.turret_deg, angles.theta1_deg, angles.theta2_deg]), 0]
        )[:3, 3]
        assert np.allclose(theirs, arm.forward(angles), atol=1e-9)


def test_a_numeric_library_says_nothing_when_a_point_is_out_of_reach(ikpy):
    """What lesson 05 tells of ikpy."""
    chain = ikpy(250.0, 200.0)
    theirs = chain.inverse_kinematics([600, 0, 0])
    assert np.linalg.norm(chain.forward_kinematics(theirs)[:3, 3] - [600, 0, 0]) > 100


HEAVY = ArmWeight(90, 60, 110, 130, motor_g=160, motor_at_mm=240, elbow_g=20, hand_g=25, load_g=35)


def parts(arm):
    """Every mass of HEAVY as (kg, link, m from the joint that carries it)."""
    w = arm.weight
    return [
        (w.link1_g / 1000, 1, w.center1_mm / 1000), (w.motor_g / 1000, 1, w.motor_at_mm / 1000),
        (w.elbow_g / 1000, 1, arm.l1_mm / 1000), (w.link2_g / 1000, 2, w.center2_mm / 1000),
        ((w.hand_g + w.load_g) / 1000, 2, arm.l2_mm / 1000),
    ]  # fmt: skip


def height_energy_j(arm, theta1_deg, theta2_deg):
    """Potential energy, each part by its height."""
    one, both = np.radians(theta1_deg), np.radians(theta1_deg + theta2_deg)
    heights = [
        (kg, m * np.sin(one) if link == 1 else arm.l1_mm / 1000 * np.sin(one) + m * np.sin(both))
        for kg, link, m in parts(arm)
    ]
    return GRAVITY_M_S2 * sum(kg * height for kg, height in heights)


def test_holding_torque_is_the_slope_of_the_energy():
    """Turning a joint by a little lifts the parts: the work is torque times angle."""
    arm = TwoLinkArm(250.0, 200.0, weight=HEAVY)
    rng = np.random.default_rng(3)
    for one, other in rng.uniform(-180, 180, (20, 2)):
        told = holding_torque_nm(arm, JointAngles(float(one), float(other)))
        turn = 1e-4
        for joint, (by1, by2) in enumerate([(turn, 0), (0, turn)]):
            work = height_energy_j(arm, one + by1, other + by2) - height_energy_j(arm, one - by1, other - by2)
            assert told[joint] == pytest.approx(work / np.radians(2 * turn), abs=1e-6)


def test_inertia_is_the_energy_of_motion():
    """Half of θ'ᵀ·M·θ' is the energy of all parts by their speeds, and of the rods' own turning."""
    arm = TwoLinkArm(250.0, 200.0, weight=HEAVY)
    rng = np.random.default_rng(4)
    for one, other, speed1, speed2 in rng.uniform(-3, 3, (20, 4)):
        both, energy = one + other, 0.0
        for kg, link, m in parts(arm):
            along = 1j * np.exp(1j * one) * speed1
            v = along * m if link == 1 else along * 0.25 + 1j * np.exp(1j * both) * (speed1 + speed2) * m
            energy += kg * abs(v) ** 2 / 2
        rods = (
            0.09 * (2 * (0.25 - 0.11)) ** 2 / 12,
            0.06 * (2 * (0.2 - 0.13)) ** 2 / 12,
        )  # as long as to their far ends
        energy += rods[0] * speed1**2 / 2 + rods[1] * (speed1 + speed2) ** 2 / 2
        m11, m12, m22 = inertia_kg_m2(arm, float(np.degrees(other)))
        assert energy == pytest.approx((m11 * speed1**2 + 2 * m12 * speed1 * speed2 + m22 * speed2**2) / 2)


def test_the_worst_pose_is_stretched_sideways_or_as_near_as_the_limits_let_it():
    assert worst_poses(BENCH) == (JointAngles(0.0, 0.0), JointAngles(0.0, 0.0))
    upright = TwoLinkArm(250.0, 200.0, ((60.0, 120.0), (-20.0, 20.0)))
    assert worst_poses(upright)[0] in (JointAngles(60.0, -20.0), JointAngles(120.0, 20.0))
    poses = JointAngles(*np.random.default_rng(5).uniform((60, -20), (120, 20), (1000, 2)).T)
    for told, worst in zip(holding_torque_nm(upright, poses), worst_torque_nm(upright), strict=True):
        assert np.abs(told).max() <= worst + 1e-12


def test_by_hand_a_hundred_grams_at_a_tenth_of_a_metre():
    bare = ArmWeight(0, 0, motor_g=0, elbow_g=0, hand_g=0, load_g=100)
    assert holding_torque_nm(TwoLinkArm(100.0, 100.0, weight=bare), JointAngles(0, 0)) == pytest.approx(
        (0.1962, 0.0981)
    )
    assert holding_torque_nm(TwoLinkArm(100.0, 100.0, weight=bare), JointAngles(90, 0)) == pytest.approx(
        (0, 0), abs=1e-12
    )


def test_a_pose_that_both_elbows_lead_to_is_given_once():
    """Folded the elbow stands at 180 degrees, or at -180 by its limits."""
    assert len(TwoLinkArm(250, 200, ((-180, 180), (-180, 0))).solutions(50, 0)) == 1

"""Where an arm stands before its cameras: the fit against known truth, on drawn pictures and from the command line."""

import json
import shutil
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from conftest import ROOT
from stereo_lab.arm import connect
from stereo_lab.arm.registering import hand_poses, register
from stereo_lab.cli import main
from stereo_lab.errors import ArmError, StereoLabError
from stereo_lab.kinematics import JointAngles, Registration, TwoLinkArm
from stereo_lab.live import DrawnCameras
from stereo_lab.localization import Localizer
from stereo_lab.recording import open_recording

ARM = TwoLinkArm(250.0, 200.0, ((-165.0, 165.0), (-155.0, 155.0)))
TOLD = Registration.told(ARM, 1000.0)
POSES = np.array([[p.theta1_deg, p.theta2_deg] for p in hand_poses(ARM)])


def standing(rng, scale=1.0):
    """An arm that stands and is built a little otherwise than it is told to."""
    return TOLD.moved(scale * np.array([*rng.normal(0, 7, 3), *rng.normal(0, 1.5, 4), *rng.normal(0, 2, 2)]))


def places(registration, poses=POSES):
    return np.array([registration.place(JointAngles(*pose)) for pose in poses])


def apart(one, other, rng):
    poses = rng.uniform(*np.array(ARM.limits_deg).T, (100, 2))
    return np.linalg.norm(places(one, poses) - places(other, poses), axis=1).mean()


def test_an_arm_as_told_is_at_the_origin():
    for theta1, theta2 in ((0, 0), (30, 60), (-100, -45)):
        pose = JointAngles(theta1, theta2)
        assert TOLD.place(pose) == pytest.approx((*ARM.forward(pose), 1000.0))


def test_by_hand_a_plane_turned_by_a_right_angle_goes_away_from_the_cameras():
    turned = Registration(
        TOLD.values + np.array([0, 0, 0, 90, 0, 0, 0, 0, 0]), TOLD.sigmas, TOLD.residuals_mm, ARM.limits_deg
    )
    assert turned.place(JointAngles(0, 0)) == pytest.approx((0, 0, 1450))  # what pointed right points to the wall
    tilted = Registration(
        TOLD.values + np.array([0, 0, 0, 0, 90, 0, 0, 0, 0]), TOLD.sigmas, TOLD.residuals_mm, ARM.limits_deg
    )
    assert tilted.place(JointAngles(90, 0)) == pytest.approx((0, 0, 550))  # what stood upright points to the cameras


@pytest.mark.parametrize("seed", range(5))
def test_exact_places_give_the_truth_back(seed):
    true = standing(np.random.default_rng(seed))
    found = Registration.fit(ARM, 1000.0, POSES, places(true))
    assert found.values == pytest.approx(true.values, abs=1e-6)


def test_its_standard_deviations_are_honest():
    """Of independent errors it promises too little rather than too much: two cameras err alike at all places."""
    rng, off = np.random.default_rng(3), []
    for _ in range(100):
        true = standing(rng)
        found = Registration.fit(ARM, 1000.0, POSES, places(true) + rng.normal(0, 1, (len(POSES), 3)), 1.0)
        off.append((found.values - true.values) / found.sigmas)
    assert (np.std(off, axis=0) > 0.3).all() and (np.std(off, axis=0) < 1.0).all()


def test_solutions_undo_place():
    true = standing(np.random.default_rng(1))
    for pose in ((40.0, 60.0), (100.0, -70.0), (-20.0, 100.0)):
        place = true.place(JointAngles(*pose))
        found = [(p.theta1_deg, p.theta2_deg) for p in true.solutions(*place)]
        assert any(np.allclose(angles, pose, atol=1e-6) for angles in found)
        near = true.solutions(*place, beyond_mm=20.0)[0]
        assert np.linalg.norm(true.place(near) - place) == pytest.approx(20.0, abs=1e-6)


def test_what_is_wrong_is_named_and_what_is_not_is_not():
    values = TOLD.values.copy()
    assert Registration(values, np.full(9, 0.2), TOLD.residuals_mm, ARM.limits_deg).differences(ARM) == []
    values[[5, 8]] += 4.0, -6.0
    said = Registration(values, np.full(9, 0.2), TOLD.residuals_mm, ARM.limits_deg).differences(ARM)
    assert len(said) == 2 and "Joint 1 stands +4.0" in said[0] and "Link 2 is 194.0 mm long" in said[1]


@pytest.mark.parametrize(
    ("poses", "words"),
    [
        (POSES[:5], "6 poses or more"),
        (POSES * [0, 1] + [20, 0], "do not tell"),
        (POSES * [1, 0] + [0, 40], "do not tell"),
        (POSES[:, :1], "two angles"),
    ],
)
def test_too_little_to_go_by_is_told(poses, words):
    with pytest.raises(StereoLabError, match=words):
        Registration.fit(ARM, 1000.0, poses, places(TOLD)[: len(poses)])


def test_it_is_kept_in_a_file(tmp_path):
    found = Registration.fit(ARM, 1000.0, POSES, places(standing(np.random.default_rng(2))))
    found.save(tmp_path / "registration.json")
    again = Registration.load(tmp_path / "registration.json")
    assert again.values == pytest.approx(found.values) and again.limits_deg == ARM.limits_deg
    facts = json.loads((tmp_path / "registration.json").read_text(encoding="utf-8"))
    for broken in ({**facts, "link 1": 3}, {k: v for k, v in facts.items() if k != "zero 1"}, {**facts, "format": 9}):
        (tmp_path / "registration.json").write_text(json.dumps(broken), encoding="utf-8")
        with pytest.raises(StereoLabError, match="registration"):
            Registration.load(tmp_path / "registration.json")


@pytest.mark.parametrize(("name", "seed"), [("bench", 0), ("bench", 1), ("second_rig", 2)])
def test_an_arm_is_registered_by_what_the_cameras_see(name, seed):
    """Places before it are off by more than 5 mm, after it by less than 2."""
    recording, rng = open_recording(name), np.random.default_rng(seed)
    localizer = Localizer.fit(recording)
    told = Registration.told(recording.arm, recording.arm_depth_mm)
    true = Registration(
        told.values + standing(rng).values - TOLD.values, TOLD.sigmas, TOLD.residuals_mm, told.limits_deg
    )
    with connect("virtual://arm") as arm:
        arm.set_limits(recording.arm.limits_deg)
        with pytest.raises(StereoLabError, match="homed"):
            register(arm, recording.arm, recording.arm_depth_mm, lambda: None)
        arm.home()
        cameras = DrawnCameras(recording, arm.port, true, seed)
        found = register(arm, recording.arm, recording.arm_depth_mm, lambda: localizer.locate(*cameras.read()))
    assert apart(found, true, rng) < 2.0 < 5.0 < apart(told, true, rng)


def test_a_ball_that_nobody_sees_is_told():
    with connect("virtual://arm") as arm:
        arm.home()
        with pytest.raises(StereoLabError, match="saw the ball in 0 of"):
            register(arm, ARM, 1000.0, lambda: None)


def test_register_on_the_command_line(tmp_path, capsys):
    rig = tmp_path / "rig"
    shutil.copytree(
        ROOT / "data" / "bench", rig, ignore=shutil.ignore_patterns("evaluation", "snaps", "track", "still")
    )
    assert main(["arm", "virtual://arm", "register", str(rig), "--keep"]) == 0
    said = capsys.readouterr().out
    assert "drawn" in said and "as they are told" in said and "registration.json" in said and "arm hangs" in said
    assert open_recording(rig).registration.values == pytest.approx(
        open_recording("bench").registration.values, abs=1.5
    )
    assert (open_recording("bench").registration.sigmas == 0).all()  # nothing was registered there
    assert main(["arm", "virtual://arm", "register", "a", "b"]) == 2


@pytest.mark.parametrize("seed", range(3))
def test_how_near_the_links_come_on_their_way(seed):
    """Against places all along both links: a hand at the end of a shorter link is one of them."""
    rng = np.random.default_rng(seed)
    stands = standing(rng)
    way = [JointAngles(*pose) for pose in rng.uniform(-150, 150, (3, 2))]
    place = stands.place(JointAngles(*rng.uniform(-150, 150, 2)))
    upper, fore = stands.values[7:]
    gaps = []
    for a, b in zip(way[:-1], way[1:], strict=True):
        for t in np.linspace(0, 1, 100):
            pose = JointAngles(
                *((1 - t) * np.array([a.theta1_deg, a.theta2_deg]) + t * np.array([b.theta1_deg, b.theta2_deg]))
            )
            for share in np.linspace(0, 1, 25):
                for links in ((share * upper, 0.0), (upper, share * fore)):
                    shorter = replace(stands, values=np.array([*stands.values[:7], *links]))
                    gaps.append(np.linalg.norm(shorter.place(pose) - place))
    assert stands.clearance_mm(way, *place) == pytest.approx(min(gaps), abs=3)


@pytest.mark.parametrize("turned", [(80, 0), (-90, 0), (180, 0), (0, 85), (0, -120), (175, 100)])
def test_a_switch_on_another_side_is_found(turned):
    """From zeros as told, steps would run away, or to links below zero."""
    true = TOLD.moved([0, 0, 0, 0, 0, *turned, 0, 0])
    found = Registration.fit(ARM, 1000.0, POSES, places(true))
    assert places(found) == pytest.approx(places(true), abs=0.01) and found.arm.l2_mm == pytest.approx(200, abs=0.01)
    assert np.abs(found.values[5:7]).max() <= 180


@pytest.mark.parametrize(
    "off",
    [(0, 0, 0, 3, -4, -105, -150, 0, 0), (10, -5, 5, -2, 3, 100, 170, 2, -1), (10, -5, 5, 1, -1, -105, -150, 2, -1)],
)
def test_it_is_told_the_way_up(off):
    """Tilted by half a turn more, turned by half a turn and with another zero it would stand at the same places."""
    true = TOLD.moved(off)
    found = Registration.fit(ARM, 1000.0, POSES, places(true))
    assert found.values == pytest.approx(true.values, abs=1e-4)
    assert f"Joint 1 stands {off[5]:+.1f}" in found.differences(ARM)[0]


def test_joints_that_both_turn_the_wrong_way_are_told_and_their_zeros_are_not():
    found = Registration.fit(ARM, 1000.0, POSES, places(TOLD, -POSES))
    (said,) = found.differences(ARM)
    assert "Both joints turn the other way" in said


STILL = np.tile((100.0, 50.0, 1000.0), (len(POSES), 1))
SCATTER = np.random.default_rng(0).normal(0, 0.5, STILL.shape)
NO_ARM = [
    (places(TOLD, POSES * [1, -1]) + SCATTER, "Joint 2 turns the other way"),
    (places(TOLD, POSES * [-1, 1]), "Joint 1 turns the other way"),
    (places(TOLD, POSES[:, ::-1]) + SCATTER, "joints are exchanged"),
    (STILL, "did the hand hold the ball"),
    (STILL + SCATTER, "did the hand hold the ball"),
    (places(TOLD, POSES * [1, 0]) + SCATTER, "do not fit an arm"),  # the elbow does not turn
    (np.vstack([places(TOLD)[:8], STILL[8:]]), r"stay \d+ mm apart"),  # the ball fell out
]


@pytest.mark.parametrize(("seen", "words"), NO_ARM, ids=range(len(NO_ARM)))
def test_places_that_fit_no_arm_are_told_with_their_cause(seen, words):
    with pytest.raises(StereoLabError, match=words):
        Registration.fit(ARM, 1000.0, POSES, seen)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ((None, places(TOLD), 1.0), "two angles and a place"),
        ((POSES, "a", 1.0), "Expected numbers"),
        ((POSES, places(TOLD), "a"), "Expected numbers"),
        ((POSES, places(TOLD), [1, 2]), "as many standard deviations"),
        ((POSES, places(TOLD), np.inf), "above zero"),
        ((POSES, places(TOLD), -1.0), "above zero"),
    ],
)
def test_what_is_no_number_is_told(given, words):
    with pytest.raises(StereoLabError, match=words):
        Registration.fit(ARM, 1000.0, *given)


def test_places_that_no_arm_has_are_refused():
    rng = np.random.default_rng(0)
    with pytest.raises(StereoLabError, match="do not fit an arm"):
        Registration.fit(ARM, 1000.0, POSES, rng.uniform(-1e4, 1e4, (len(POSES), 3)))


@pytest.mark.parametrize(
    "limits", [((0, 165), (0, 150)), ((-30, 210), (0, 150)), ((90, 270), (-150, 150)), ((-270, 0), (-150, 150))]
)
def test_limits_of_any_kind_leave_poses_where_the_arm_can_be(limits):
    arm = TwoLinkArm(250.0, 200.0, limits)
    poses = hand_poses(arm)
    assert len(poses) >= 7 and all(arm.within_limits(pose) for pose in poses)


def test_limits_that_leave_too_few_poses_are_told_before_the_arm_moves(bench):
    with connect("virtual://arm") as arm:
        before = arm.home()
        with pytest.raises(StereoLabError, match="Nothing was moved"):
            register(arm, TwoLinkArm(250.0, 200.0, ((0, 20), (0, 40))), 1000.0, lambda: None)
        assert arm.angles() == before


def in_a_cell_of_lesson_06(arm, recording):
    """The cell that registers an arm; the arm need not be one."""
    (lesson,) = (ROOT / "notebooks").glob("06_*.ipynb")
    cells = json.loads(lesson.read_text(encoding="utf-8"))["cells"]
    source = "".join(next(cell for cell in cells if cell["id"] == "cell-stand-2")["source"])
    exec(compile(source, "cell-stand-2", "exec"), {"arm": arm, "recording": recording})


def test_the_lesson_moves_no_real_arm_by_the_calibration_of_drawn_cameras(monkeypatch):
    monkeypatch.setattr("cv2.VideoCapture", lambda number: pytest.fail("a camera was opened"))
    with pytest.raises(StereoLabError, match="its calibration is not that of your cameras"):
        in_a_cell_of_lesson_06(SimpleNamespace(port=None), open_recording("bench"))


def test_the_lesson_lets_its_cameras_go_and_opens_them_again(monkeypatch):
    """Whatever becomes of the fit: the same kernel runs the cell again."""
    held = set()

    class Camera:
        def __init__(self, number):
            self.number, self.opened = number, number not in held
            held.add(number)

        def isOpened(self):
            return self.opened

        def set(self, what, value):
            return True

        def release(self):
            held.discard(self.number)

    monkeypatch.setattr("cv2.VideoCapture", Camera)
    taken = replace(open_recording("bench"), truth={}, made_by="camera")
    for _ in range(2):
        with pytest.raises(ArmError, match="Expected an arm"):
            in_a_cell_of_lesson_06(SimpleNamespace(port=None), taken)
        assert not held
    held.add(1)
    with pytest.raises(StereoLabError, match=r"Camera 1 \(right\) does not open"):
        in_a_cell_of_lesson_06(SimpleNamespace(port=None), taken)

"""Films of the arm: what they show, and that every page can play them or show their still."""

import base64
import math
import sys
from types import SimpleNamespace

import cv2
import numpy as np
import pytest

from conftest import ROOT
from stereo_lab import widgets
from stereo_lab.detection import BallDetector
from stereo_lab.errors import StereoLabError
from stereo_lab.kinematics import JointAngles
from stereo_lab.live import VirtualBench, poses_film, reach_film, run_film
from stereo_lab.live.bench import JOINT_BGR
from stereo_lab.live.film import CLOSE_PX, CLOSER
from stereo_lab.recording import Position, open_recording
from tests.test_notebooks import part_of_bench

BALLS = [(250.0, 150.0), (-150.0, 300.0)]


def joints_px(recording, pose):
    """Where the left camera sees shoulder, elbow and hand."""
    elbow = recording.arm.l1_mm * np.array(
        [math.cos(math.radians(pose.theta1_deg)), math.sin(math.radians(pose.theta1_deg))]
    )
    eye = VirtualBench(recording, fast=True).eyes[0]
    return eye.project(np.array([(0, 0, 0), (*elbow, 0), (*recording.arm.forward(pose), 0)], float))


@pytest.mark.parametrize("name", ["bench", "second_rig"])
def test_the_arm_goes_to_each_ball(name):
    recording = open_recording(ROOT / "data" / name)
    poses = [recording.arm.inverse(x, y) for x, y in BALLS]
    film = reach_film(recording, poses, BALLS, rate_hz=10)
    assert len(film) == 2 * (12 + 6)
    for picture, pose in ((film[17], poses[0]), (film[35], poses[1])):
        _, elbow, hand = joints_px(recording, pose)
        ball = BallDetector(recording.ball.color).detect(picture)
        assert math.hypot(ball.u - hand[0], ball.v - hand[1]) < 1
        u, v = np.round(elbow).astype(int)
        assert np.abs(picture[v, u].astype(int) - JOINT_BGR).max() < 40
    u, v = np.round(joints_px(recording, JointAngles(90, 0))[1]).astype(int)
    assert np.abs(film[0][v, u].astype(int) - JOINT_BGR).max() < 40  # it begins stretched upwards


def test_an_arm_is_seen_in_its_poses(bench):
    poses = [JointAngles(30, 0), JointAngles(-40, 20)]
    film = poses_film(bench, poses)
    assert len(film) == 2
    for picture, pose in zip(film, poses, strict=True):
        u, v = np.round(joints_px(bench, pose)[1]).astype(int)
        assert np.abs(picture[v, u].astype(int) - JOINT_BGR).max() < 40
        assert BallDetector("red").detect(picture) is None


def moments(recording, poses):
    """A run in which the ball goes to the right by 10 mm a picture."""
    track = lambda k: SimpleNamespace(seen=True, position=Position(100.0 + 10 * k, 200.0, recording.arm_depth_mm))
    step = lambda k, pose: SimpleNamespace(time_s=k / 10 + 0.05, wanted=pose, reached=pose)
    return [
        SimpleNamespace(frame=SimpleNamespace(time_s=k / 10), track=track(k), step=step(k, pose))
        for k, pose in enumerate(poses)
    ]


def test_a_run_is_seen_again_with_the_ball_in_the_middle(bench):
    behind = [bench.arm.inverse(100.0 + 10 * k - 40, 200.0) for k in range(9)]
    film = run_film(bench, moments(bench, behind), every=2)
    assert len(film) == 4 and film[0].shape == (
        CLOSE_PX * CLOSER,
        CLOSE_PX * CLOSER,
        3,
    )  # the last order comes after the last picture
    for picture in film:
        ball = BallDetector("red").detect(picture)
        assert math.hypot(ball.u - CLOSE_PX * CLOSER / 2, ball.v - CLOSE_PX * CLOSER / 2) < 2 * CLOSER
    at_it = run_film(bench, moments(bench, [bench.arm.inverse(105.0 + 10 * k, 200.0) for k in range(9)]), every=2)
    assert np.abs(film[0].astype(int) - at_it[0]).mean() > 3


def test_no_film_of_real_cameras(tmp_path):
    recording = open_recording(part_of_bench(tmp_path, {"position": "position"}))
    with pytest.raises(StereoLabError, match="real cameras"):
        reach_film(recording, [JointAngles(0, 90)], [(100, 100)])


def film_of(count, wide=640, high=480):
    pictures = [np.full((high, wide, 3), 255, np.uint8) for _ in range(count)]
    for k, picture in enumerate(pictures):
        cv2.rectangle(picture, (10 * k, 100), (10 * k + 80, 300), (0, 0, 255), -1)
    return pictures


def played(clip, folder):
    (folder / "clip.webm").write_bytes(clip.webm)
    video, pictures = cv2.VideoCapture(str(folder / "clip.webm")), []
    while (read := video.read())[0]:
        pictures.append(read[1])
    return pictures


@pytest.mark.parametrize(
    ("wide", "high", "size"), [(640, 480, (480, 360)), (300, 201, (300, 200)), (481, 333, (480, 332))]
)
def test_a_clip_plays_what_it_was_given(tmp_path, capfd, wide, high, size):
    given = film_of(12, wide, high)
    clip = widgets.Clip(given, 15, "a red block goes right")
    shown = played(clip, tmp_path)
    assert len(shown) == 12 and clip.size == size and shown[0].shape[1::-1] == size
    for a, b in ((given[0], shown[0]), (given[11], shown[11])):
        assert np.abs(cv2.resize(a, size, interpolation=cv2.INTER_AREA).astype(int) - b).mean() < 4
    assert len(clip.webm) < 100_000
    assert capfd.readouterr().err == ""


def test_what_a_page_gets_of_it():
    clip = widgets.Clip(film_of(3), 15, 'a "block" <goes> right')
    page = clip._repr_mimebundle_()
    assert page["text/plain"] == 'clip: a "block" <goes> right' and "<goes>" not in page["text/html"]
    assert (
        "<video controls" in page["text/html"]
        and "autoplay" not in page["text/html"]
        and "poster=" in page["text/html"]
    )
    still = cv2.imdecode(np.frombuffer(base64.b64decode(page["image/jpeg"]), np.uint8), cv2.IMREAD_COLOR)
    assert still.shape == (360, 480, 3)


def test_where_no_film_can_be_written_its_still_is_shown(monkeypatch):
    monkeypatch.setattr(cv2.VideoWriter, "fourcc", lambda *_: 0x58585858)  # a codec that nobody has
    page = widgets.Clip(film_of(3), 15, "a block")._repr_mimebundle_()
    assert "text/html" not in page and page["image/jpeg"]


def test_a_clip_of_nothing():
    with pytest.raises(StereoLabError, match="got none"):
        widgets.Clip([], 15, "nothing")


def test_a_panel_has_a_still_for_a_page_without_a_kernel(bench):
    panel = widgets.arm_reaches(bench.arm)
    still = base64.b64decode(panel._repr_mimebundle_()["image/jpeg"])
    assert still == panel.picture.value and "application/vnd.jupyter.widget-view+json" in panel._repr_mimebundle_()


@pytest.mark.slow
def test_the_film_of_the_readme(tmp_path):
    sys.path.insert(0, str(ROOT / "examples"))
    from film_of_the_cell import film, write

    pictures, shown_ms = film()
    assert len(pictures) == len(shown_ms) > 50 and abs(sum(shown_ms) - 7600) < 50
    assert all(BallDetector("red").detect(picture[:300, :400]) is not None for picture in pictures[::10])
    write(pictures[:5], shown_ms[:5], str(tmp_path / "a.webp"))
    assert cv2.imread(str(tmp_path / "a.webp")).shape == pictures[0].shape

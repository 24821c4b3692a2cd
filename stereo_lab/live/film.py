"""An arm at work as the left camera would see it: drawn, picture by picture, for a clip."""

from __future__ import annotations

from collections.abc import Sequence
from types import SimpleNamespace

import cv2
import numpy as np

from stereo_lab.kinematics import JointAngles
from stereo_lab.live.bench import VirtualBench
from stereo_lab.live.follower import ball_when_ordered
from stereo_lab.live.run import Moment
from stereo_lab.recording import Recording

MOVE_S, REST_S = 1.2, 0.6
CLOSE_PX, CLOSER = 80, 4  # so wide is the part of the picture round the ball; it is shown so many times as large


def reach_film(
    recording: Recording,
    poses: Sequence[JointAngles],
    balls_mm: Sequence[tuple[float, float]],
    rate_hz: float = 15.0,
) -> list[np.ndarray]:
    """What the left camera sees while an arm goes from ball to ball. Drawn, not filmed.

    Parameters
    ----------
    recording : Recording, a rendered one: its cameras and its arm
    poses : sequence of JointAngles, one for each ball
    balls_mm : sequence of (x, y), in the arm's plane; each lies there until the arm has rested at it
    rate_hz : float, pictures a second

    Returns
    -------
    list of ndarray, BGR

    Raises
    ------
    StereoLabError
        If the recording was taken with real cameras.
    """
    bench, pictures = _drawn(recording), []
    joints = [np.array([90.0, 0.0]), *(np.array([pose.theta1_deg, pose.theta2_deg]) for pose in poses)]
    for start, goal, (x, y) in zip(joints[:-1], joints[1:], balls_mm, strict=True):
        bench.ball_mm = (x, y, recording.arm_depth_mm)
        steps = np.linspace(0, 1, round(MOVE_S * rate_hz))
        for part in (*(3 * steps**2 - 2 * steps**3), *[1.0] * round(REST_S * rate_hz)):  # sets off and arrives softly
            bench.arm.link_deg = tuple(start + part * (goal - start))
            pictures.append(bench.draw(bench.ball_mm)[0])
    return pictures


def poses_film(recording: Recording, poses: Sequence[JointAngles]) -> list[np.ndarray]:
    """What the left camera sees of an arm in some poses, one picture each; no ball is there. Drawn, not filmed.

    Parameters
    ----------
    recording : Recording, a rendered one: its cameras and its arm
    poses : sequence of JointAngles

    Returns
    -------
    list of ndarray, BGR
    """
    bench, pictures = _drawn(recording), []
    for pose in poses:
        bench.arm.link_deg = (pose.theta1_deg, pose.theta2_deg)
        pictures.append(bench.draw(None)[0])
    return pictures


def run_film(recording: Recording, moments: Sequence[Moment], every: int = 2) -> list[np.ndarray]:
    """A run seen again by the left camera, near the ball: the arm as its encoders told, the ball where it was just then.

    Drawn, not filmed. The ball stays in the middle of the picture; a millimetre is two pixels wide or more.

    Parameters
    ----------
    recording : Recording, a rendered one: its cameras and its arm
    moments : sequence of Moment, of a run in which the arm followed
    every : int, one picture for so many moments

    Returns
    -------
    list of ndarray, BGR

    Raises
    ------
    StereoLabError
        If the recording was taken with real cameras.
    """
    bench, pictures = _drawn(recording), []
    steps, x_mm, y_mm = ball_when_ordered(moments, recording)
    zeros = recording.registration.values[5:7]
    for step, x, y in list(zip(steps, x_mm, y_mm, strict=True))[::every]:
        bench.arm.link_deg = (step.reached.theta1_deg + zeros[0], step.reached.theta2_deg + zeros[1])
        picture = bench.draw((float(x), float(y), recording.arm_depth_mm))[0]
        middle = bench.eyes[0].project(np.array([x, y, 0.0]))[0]
        pictures.append(cv2.getRectSubPix(picture, (CLOSE_PX, CLOSE_PX), tuple(map(float, middle))))
    return [cv2.resize(picture, None, fx=CLOSER, fy=CLOSER, interpolation=cv2.INTER_CUBIC) for picture in pictures]


def _drawn(recording):
    """The recording's cameras before an arm that is set, not driven. Without noise, which makes films large."""
    return VirtualBench(recording, SimpleNamespace(link_deg=(0.0, 0.0)), fast=True, noise=0.0)

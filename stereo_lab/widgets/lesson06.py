"""Panels of lesson 06."""

from __future__ import annotations

import cv2
import numpy as np

from stereo_lab.arm.registering import hand_poses
from stereo_lab.kinematics import LEAST_POSES, JointAngles, Registration, TwoLinkArm
from stereo_lab.motion import Motor, SlowDownRule, Tuning, calibrate_motor, drive, push_of
from stereo_lab.widgets.panel import BLACK, BLUE, GREY, PANEL_WIDTH, VERMILION, Panel, slider, wide, write

SHOWN_S, LONGEST_S = 4.0, 8.0  # of a move that is drawn; until it is given up


def stopping(motor: Motor, goal_deg: float = 90.0) -> Panel:
    """One motor driven by the slow-down rule: the slow zone and the speed by sliders.

    Parameters
    ----------
    motor : stereo_lab.motion.Motor
    """
    tuning = Tuning.of(calibrate_motor(push_of(motor), motor.supply_v), motor.counts_per_turn)

    def to_px(seconds, angle):
        return round(70 + seconds / SHOWN_S * 860), round(364 - angle / (1.25 * goal_deg) * 334)

    def draw(zone_deg, cruise_deg_s):
        view = np.full((420, PANEL_WIDTH, 3), 255, np.uint8)
        rule = SlowDownRule(tuning, 0.0, goal_deg, zone_deg, cruise_deg_s)
        run = drive(motor, rule, longest_s=LONGEST_S)
        if zone_deg:
            cv2.rectangle(view, to_px(0, goal_deg), to_px(SHOWN_S, goal_deg - zone_deg), (205, 235, 250), -1)
        cv2.line(view, to_px(0, goal_deg), to_px(SHOWN_S, goal_deg), BLACK, 1, cv2.LINE_AA)
        line = np.array([to_px(t, p) for t, p in zip(run.time_s, run.position_deg, strict=True)])
        cv2.polylines(view, [np.clip(line, -5000, 5000)], False, BLUE, 3, cv2.LINE_AA)
        for seconds in range(round(SHOWN_S) + 1):
            write(view, f"{seconds}", (to_px(seconds, 0)[0] - 6, 388))
        for angle in range(0, round(1.25 * goal_deg), 30):
            write(view, f"{angle}", (60 - wide(f"{angle}"), to_px(0, angle)[1] + 6))
        write(view, "time (s)", (450, 412))
        write(view, "degrees", (4, 20))
        write(view, f"goal {goal_deg:.0f} deg", (74, to_px(0, goal_deg)[1] - 8))
        where = f"{run.rest_deg - goal_deg:+.1f} degrees from the goal"
        return (
            view,
            f"stops {where}, after {run.arrived_s:.2f} s"
            if rule.done
            else f"not there after {LONGEST_S:.0f} s, {where}",
        )

    return Panel(
        "stopping a motor",
        {
            "zone_deg": slider("slow zone (degrees)", 5, 0, 40),
            "cruise_deg_s": slider("speed (degrees/s)", 180, 30, 400, 10),
        },
        draw,
    )


def registering(arm: TwoLinkArm, depth_mm: float = 1000.0) -> Panel:
    """An arm that is not as told, the places at which cameras see its hand, and what a fit finds of it.

    Parameters
    ----------
    arm : TwoLinkArm, as it is told
    depth_mm : float, the depth of its plane
    """
    told = Registration.told(arm, depth_mm)
    poses = np.array([[pose.theta1_deg, pose.theta2_deg] for pose in hand_poses(arm)])
    noise = np.random.default_rng(0).normal(size=(len(poses), 3))
    longer, scale = 5, 190 / arm.reach_mm[1]

    def places(way, angles):
        return np.array([way.place(JointAngles(*pose)) for pose in angles])

    def to_px(place):
        return round(PANEL_WIDTH / 2 + place[0] * scale), round(210 - place[1] * scale)

    def draw(zero1_deg, link2_mm, off_mm, count):
        angles = poses[:count]
        true = told.moved((0, 0, 0, 0, 0, zero1_deg, 0, 0, link2_mm))
        truth, before = places(true, angles), places(told, angles)
        seen = truth + off_mm * noise[:count]
        found = Registration.fit(arm, depth_mm, angles, seen, max(off_mm, 0.1))
        view = np.full((420, PANEL_WIDTH, 3), 255, np.uint8)
        cv2.circle(view, to_px((0, 0)), round(arm.reach_mm[1] * scale), GREY, 2, cv2.LINE_AA)
        cv2.circle(view, to_px((0, 0)), 8, BLACK, -1, cv2.LINE_AA)
        for start, end in zip(before, seen, strict=True):
            cv2.circle(view, to_px(start), 7, BLUE, 2, cv2.LINE_AA)
            cv2.arrowedLine(view, to_px(start), to_px(start + longer * (end - start)), VERMILION, 2, cv2.LINE_AA)
        words = ("circles: where the hand", "is told to be", "arrows: to where it is seen,", f"{longer} times too long")
        for k, line in enumerate(words):
            write(view, line, (16, 30 + 30 * k))
        gaps = [np.linalg.norm(places(way, angles) - truth, axis=1).mean() for way in (told, found)]
        zero1, link2 = np.round([found.values[5], found.values[8]], 1) + 0.0  # no zero with a minus
        return view, (
            f"the hand is {gaps[0]:.1f} mm beside where it is told to be, {gaps[1]:.1f} mm beside where it is found to be; "
            f"zero 1 {zero1:+.1f} ± {found.sigmas[5]:.1f} degrees, link 2 {link2:.1f} ± {found.sigmas[8]:.1f} mm"
        )

    return Panel(
        "registering an arm",
        {
            "zero1_deg": slider("joint 1 off by (degrees)", 2, -5, 5),
            "link2_mm": slider("link 2 longer by (mm)", 2, -10, 10),
            "off_mm": slider("cameras err by (mm)", 1, 0, 10),
            "count": slider("places", len(poses), LEAST_POSES, len(poses)),
        },
        draw,
    )

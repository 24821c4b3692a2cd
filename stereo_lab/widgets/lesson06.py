"""Panels of lesson 06."""

from __future__ import annotations

import cv2
import numpy as np

from stereo_lab.motion import Motor, SlowDownRule, Tuning, calibrate_motor, drive, push_of
from stereo_lab.widgets.panel import BLACK, BLUE, PANEL_WIDTH, Panel, slider


def stopping(motor: Motor, goal_deg: float = 90.0) -> Panel:
    """One motor driven by the slow-down rule: the slow zone and the speed by sliders.

    Parameters
    ----------
    motor : stereo_lab.motion.Motor
    """
    tuning = Tuning.of(calibrate_motor(push_of(motor), motor.supply_v), motor.counts_per_turn)

    def to_px(seconds, angle):
        return round(70 + seconds / 1.6 * 860), round(380 - angle / (1.25 * goal_deg) * 350)

    def draw(zone_deg, cruise_deg_s):
        view = np.full((420, PANEL_WIDTH, 3), 255, np.uint8)
        run = drive(motor, SlowDownRule(tuning, 0.0, goal_deg, zone_deg, cruise_deg_s))
        if zone_deg:
            cv2.rectangle(view, to_px(0, goal_deg), to_px(1.6, goal_deg - zone_deg), (205, 235, 250), -1)
        cv2.line(view, to_px(0, goal_deg), to_px(1.6, goal_deg), BLACK, 1, cv2.LINE_AA)
        line = np.array([to_px(t, p) for t, p in zip(run.time_s, run.position_deg, strict=True)])
        cv2.polylines(view, [np.clip(line, -5000, 5000)], False, BLUE, 3, cv2.LINE_AA)
        for k in range(0, 17, 4):
            cv2.putText(
                view,
                f"{k / 10:.1f}",
                (to_px(k / 10, 0)[0] - 12, 402),
                cv2.FONT_HERSHEY_SIMPLEX,
                0.5,
                BLACK,
                1,
                cv2.LINE_AA,
            )
        cv2.putText(view, "time (s)", (450, 417), cv2.FONT_HERSHEY_SIMPLEX, 0.5, BLACK, 1, cv2.LINE_AA)
        cv2.putText(
            view,
            f"goal {goal_deg:.0f} deg",
            (74, to_px(0, goal_deg)[1] - 8),
            cv2.FONT_HERSHEY_SIMPLEX,
            0.55,
            BLACK,
            1,
            cv2.LINE_AA,
        )
        return view, f"stops {run.rest_deg - goal_deg:+.1f} degrees from the goal, after {run.arrived_s:.2f} s"

    return Panel(
        "stopping a motor",
        {
            "zone_deg": slider("slow zone (degrees)", 5, 0, 40),
            "cruise_deg_s": slider("speed (degrees/s)", 180, 30, 400, 10),
        },
        draw,
    )

"""Panels of lesson 05."""

from __future__ import annotations

from typing import Any

import cv2
import ipywidgets
import numpy as np

from stereo_lab.errors import StereoLabError
from stereo_lab.widgets.panel import BLACK, BLUE, GREY, ORANGE, PANEL_WIDTH, VERMILION, Panel, slider


def arm_reaches(arm: Any) -> Panel:
    """A target moved by sliders, and the arm that follows it.

    Parameters
    ----------
    arm : TwoLinkArm
    """
    far = arm.reach_mm[1]
    scale = 190 / far

    def to_px(x, y):
        return round(PANEL_WIDTH / 2 + x * scale), round(210 - y * scale)

    def draw(x_mm, y_mm, elbow):
        view = np.full((420, PANEL_WIDTH, 3), 255, np.uint8)
        for radius in arm.reach_mm:
            cv2.circle(view, to_px(0, 0), round(radius * scale), GREY, 2, cv2.LINE_AA)
        cv2.circle(view, to_px(x_mm, y_mm), 10, ORANGE, -1, cv2.LINE_AA)
        try:
            pose = arm.inverse(x_mm, y_mm, elbow)
        except StereoLabError as error:
            return view, str(error)
        joint = arm.l1_mm * np.cos(np.radians(pose.theta1_deg)), arm.l1_mm * np.sin(np.radians(pose.theta1_deg))
        points = [to_px(0, 0), to_px(*joint), to_px(x_mm, y_mm)]
        for start, end, color in zip(points[:-1], points[1:], (BLUE, VERMILION), strict=True):
            cv2.line(view, start, end, color, 6, cv2.LINE_AA)
        for point in points[:2]:
            cv2.circle(view, point, 8, BLACK, -1, cv2.LINE_AA)
        beyond = "" if arm.within_limits(pose) else ": beyond a limit of this arm"
        return view, f"shoulder {pose.theta1_deg:.1f}, elbow {pose.theta2_deg:.1f} degrees{beyond}"

    whole = int(far * 1.1)
    elbow = ipywidgets.ToggleButtons(options=["down", "up"], description="elbow", style={"button_width": "110px"})
    return Panel(
        "arm follows a target",
        {
            "x_mm": slider("x (mm)", 0.6 * far, -whole, whole, 5),
            "y_mm": slider("y (mm)", 0.3 * far, -whole, whole, 5),
            "elbow": elbow,
        },
        draw,
    )

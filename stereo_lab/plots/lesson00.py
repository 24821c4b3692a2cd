"""Figures of lesson 00."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from numpy.typing import ArrayLike

from stereo_lab.plots.base import BLACK, BLUE, GREEN, ORANGE, VERMILION, Numbers

__all__ = ["jump_against_depth", "rig_from_above"]


def rig_from_above(
    left_x_mm: float,
    baseline_mm: float,
    arm_depth_mm: float,
    reach_mm: float,
    balls_x_mm: Numbers,
    balls_depth_mm: Numbers,
    title: str,
    ax: Axes | None = None,
) -> Axes:
    """The bench from above: two cameras, the plane of the arm, and places of the ball; all in mm."""
    ax = ax or plt.gca()
    cameras = np.array([left_x_mm, left_x_mm + baseline_mm])
    ax.plot(
        balls_depth_mm,
        balls_x_mm,
        "o",
        color=VERMILION,
        markersize=8,
        markeredgecolor=BLACK,
        label="places of the ball",
    )
    ax.plot([0, 0], cameras, ">", color=BLUE, markersize=16)
    ax.annotate("left camera", (0, cameras[0]), xytext=(14, 16), textcoords="offset points", va="center")
    ax.annotate("right camera", (0, cameras[1]), xytext=(14, -16), textcoords="offset points", va="center")
    ax.plot([arm_depth_mm] * 2, [-reach_mm, reach_mm], "--", color=GREEN, linewidth=2, label="plane of the arm")
    ax.plot(
        [arm_depth_mm],
        [0],
        "s",
        color=ORANGE,
        markersize=11,
        markeredgecolor=BLACK,
        linestyle="",
        label="arm's shoulder: x = 0",
    )
    ax.legend(loc="upper left", bbox_to_anchor=(1.01, 1))
    ax.invert_yaxis()
    ax.set_aspect("equal")
    ax.set_xlabel("depth from the cameras (mm)")
    ax.set_ylabel("x, to the right (mm)")
    ax.set_title(title)
    return ax


def jump_against_depth(jumps_px: ArrayLike, depths_mm: ArrayLike, title: str, ax: Axes | None = None) -> Axes:
    """Depth of the ball against its jump from the left picture to the right one."""
    ax = ax or plt.gca()
    ax.plot(jumps_px, depths_mm, "o", color=BLUE, markersize=9)
    ax.set_xlabel("jump of the ball, left u − right u (px)")
    ax.set_ylabel("depth (mm)")
    ax.set_title(title)
    return ax

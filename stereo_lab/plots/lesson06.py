"""Figures of lesson 06: motors, and how they stop."""

from __future__ import annotations

from collections.abc import Sequence

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from numpy.typing import ArrayLike

from stereo_lab.plots.base import AMBER, BLACK, BLUE, GREEN, ORANGE, VERMILION

__all__ = ["holding", "motor_curves", "plan", "stopping_errors", "stops", "touches"]

STYLES = ((BLUE, "-"), (VERMILION, "--"), (GREEN, "-."), (AMBER, ":"))
LARGER = 50  # a miss is drawn so many times as far: a millimetre beside a ball cannot be seen


def holding(
    theta1_deg: ArrayLike, torques_nm: Sequence[ArrayLike], rated_nm: float, title: str, ax: Axes | None = None
) -> Axes:
    """What shoulder and elbow must hold over the shoulder's angle, beside what their motors may.

    Parameters
    ----------
    torques_nm : two arrays, N·m, of shoulder and elbow
    rated_nm : float, N·m
    """
    ax = ax or plt.gca()
    for (color, dash), label, torque in zip(STYLES, ("shoulder", "elbow"), torques_nm, strict=False):
        ax.plot(theta1_deg, torque, dash, color=color, linewidth=2.5, label=label)
    ax.axhline(0, color=BLACK, linewidth=0.8)
    for side in (rated_nm, -rated_nm):
        ax.axhline(side, color=AMBER, linewidth=2, linestyle=":", label="motor, for long" if side > 0 else None)
    ax.set_xticks(range(-180, 181, 45))
    ax.set_xlabel("shoulder angle (degrees)")
    ax.set_ylabel("torque (N·m)")
    ax.set_title(title)
    ax.legend(loc=(0.02, 0.68))
    return ax


def motor_curves(volts: ArrayLike, curves: Sequence[tuple[str, ArrayLike]], title: str, ax: Axes | None = None) -> Axes:
    """Speed against voltage.

    Parameters
    ----------
    curves : list of (label, speeds in degrees per second)
    """
    ax = ax or plt.gca()
    for k, (label, speeds) in enumerate(curves):
        color, dash = STYLES[k % 4]
        ax.plot(volts, speeds, dash, color=color, linewidth=2.5, label=label)
    ax.axhline(0, color=BLACK, linewidth=0.8)
    ax.set_xlabel("voltage (V)")
    ax.set_ylabel("speed (degrees per second)")
    ax.set_title(title)
    ax.legend()
    return ax


def stops(
    runs: Sequence[tuple[str, ArrayLike, ArrayLike]],
    goal_deg: float,
    title: str,
    ax: Axes | None = None,
    zone_deg: float = 0.0,
    zoom_s: float | None = None,
) -> Axes:
    """Where joints are over time, on their way to a goal.

    Parameters
    ----------
    runs : list of (label, time_s, position_deg)
    zone_deg : a band before the goal, drawn
    zoom_s : show only the end, from this time on
    """
    ax = ax or plt.gca()
    ax.axhline(goal_deg, color=BLACK, linewidth=1.2, linestyle="--")
    if zone_deg:
        ax.axhspan(goal_deg - zone_deg, goal_deg, color=ORANGE, alpha=0.25)
    for k, (label, time_s, position_deg) in enumerate(runs):
        color, dash = STYLES[k % 4]
        ax.plot(time_s, position_deg, dash, color=color, linewidth=2.2, label=label)
    if zoom_s is not None:
        ax.set_xlim(left=zoom_s)
        shown = np.concatenate([np.asarray(p)[np.asarray(t) >= zoom_s] for _, t, p in runs])
        ax.set_ylim(min(shown.min(), goal_deg) - 1, max(shown.max(), goal_deg) + 1)
    ax.set_xlabel("time (s)")
    ax.set_ylabel("angle (degrees)")
    ax.set_title(title)
    ax.legend()
    return ax


def plan(
    plan_s: ArrayLike,
    planned_deg_s: ArrayLike,
    time_s: ArrayLike,
    real_deg_s: ArrayLike,
    title: str,
    ax: Axes | None = None,
) -> Axes:
    """The trapezoid of a plan, and what the motor makes of it: speeds over their own times."""
    ax = ax or plt.gca()
    ax.plot(plan_s, planned_deg_s, "--", color=BLACK, linewidth=2, label="plan")
    ax.plot(time_s, real_deg_s, "-", color=BLUE, linewidth=2, label="motor")
    ax.set_xlabel("time (s)")
    ax.set_ylabel("speed (degrees per second)")
    ax.set_title(title)
    ax.legend()
    return ax


def stopping_errors(ways: Sequence[tuple[str, ArrayLike]], title: str, ax: Axes | None = None) -> Axes:
    """How far from the goal many motors stop.

    Parameters
    ----------
    ways : list of (label, errors in degrees); where labels are alike up to a comma, their colour is
    """
    ax = ax or plt.gca()
    names = [label.split(",")[0] for label, _ in ways]
    style = {name: k % 4 for k, name in enumerate(dict.fromkeys(names))}
    for k, (name, (_, errors)) in enumerate(zip(names, ways, strict=True)):
        errors = np.sort(np.abs(errors))
        height = k + np.linspace(-0.3, 0.3, len(errors))
        marker, color = ("o", "s", "^", "D")[style[name]], STYLES[style[name]][0]
        ax.plot(np.maximum(errors, 0.01), height, marker, color=color, markersize=4, alpha=0.6)
    ax.set_yticks(range(len(ways)), [label for label, _ in ways])
    ax.set_xscale("log")
    ax.xaxis.set_major_formatter(plt.matplotlib.ticker.FormatStrFormatter("%g"))
    ax.invert_yaxis()
    ax.set_xlabel("stopping error (degrees, every numbered tick ten times the one before)")
    ax.set_title(title)
    return ax


def touches(
    ball_mm: np.ndarray, hand_mm: np.ndarray, error_mm: np.ndarray, title: str, axes: Sequence[Axes] | np.ndarray
) -> Sequence[Axes] | np.ndarray:
    """Balls in the plane, where the hand is beside each, drawn fifty times as far, and how far that is.

    Parameters
    ----------
    ball_mm, hand_mm : ndarray, shape (N, 2)
    error_mm : ndarray, shape (N,)
    axes : two axes
    """
    place, size = axes
    place.plot(ball_mm[:, 0], ball_mm[:, 1], "o", color=ORANGE, markersize=8, markeredgecolor=BLACK, label="ball")
    apart = LARGER * (hand_mm - ball_mm)
    place.quiver(*ball_mm.T, *apart.T, angles="xy", scale_units="xy", scale=1, color=BLUE, width=0.008, zorder=3)
    place.plot([], [], color=BLUE, linewidth=3, label=f"to the hand, {LARGER} times as far")
    place.plot(0, 0, "s", color=BLACK, markersize=8, label="shoulder")
    place.set_aspect("equal")
    place.set_xlabel("x (mm)")
    place.set_ylabel("y (mm)")
    place.set_title(title)
    low, high = place.get_ylim()
    place.set_ylim(low - 0.3 * (high - low), high)  # room for the legend
    place.legend(loc="lower center", ncols=1, fontsize="small")
    size.bar(range(len(error_mm)), error_mm, color=BLUE)
    size.axhline(np.mean(error_mm), color=BLACK, linestyle="--")
    size.set_xlabel("ball, in the order touched")
    size.set_ylabel("hand to ball (mm)")
    size.set_title("How far the hand is from the ball")
    return axes

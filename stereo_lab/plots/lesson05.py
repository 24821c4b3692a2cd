"""Figures of lesson 05: arms, their reach, and what a degree is worth."""

from __future__ import annotations

from collections.abc import Sequence

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.patches import Arc, Patch
from numpy.typing import ArrayLike

from stereo_lab.plots.base import AMBER, BLACK, BLUE, GREEN, ORANGE, VERMILION

__all__ = ["arms", "cosine_triangle", "one_degree", "reach", "turret", "two_links"]

LABEL = {"boxstyle": "round", "facecolor": "white", "edgecolor": "none", "alpha": 0.9}
NARROW_DEG = 18  # an angle up to it is labelled beside its lines
STYLES = ((BLUE, "-"), (VERMILION, "--"), (GREEN, ":"))


def _plane(ax, title):
    ax.set_aspect("equal")
    ax.set_xlabel("x (mm)")
    ax.set_ylabel("y (mm)")
    ax.set_title(title)
    return ax


def _beside(ax, text, point, toward, **style):
    """A text that begins a little beyond a point, on the side of it where a direction leads."""
    x, y = _unit(toward)
    across = "left" if x > 0.4 else "right" if x < -0.4 else "center"
    along = "bottom" if y > 0.4 else "top" if y < -0.4 else "center"
    shift = {"xytext": (10 * x, 10 * y), "textcoords": "offset points", "ha": across, "va": along}
    ax.annotate(text, point, **shift, **style)


def _unit(direction):
    return np.asarray(direction, float) / (np.linalg.norm(direction) or 1.0)


def _left_of(direction):
    return np.array([-direction[1], direction[0]])


def _at(turn_deg):
    """The unit vector that is turned so far counter-clockwise from the x axis."""
    return np.array([np.cos(np.radians(turn_deg)), np.sin(np.radians(turn_deg))])


def _arc(ax, corner, start_deg, turn_deg, radius, label):
    """An angle at a corner: from where it is counted, and how far it turns; counter-clockwise is plus."""
    size, (low, high) = 2 * radius, sorted((start_deg, start_deg + turn_deg))
    ax.add_patch(Arc(corner, size, size, theta1=low, theta2=high, linewidth=2, zorder=4))
    wide = abs(turn_deg) > NARROW_DEG  # else there is no room between its two lines
    toward = _at(start_deg + turn_deg / 2 if wide else start_deg - np.copysign(NARROW_DEG, turn_deg))
    _beside(ax, label, corner + radius * toward, toward, weight="bold", bbox=LABEL, zorder=4)


def _dotted(ax, start, end):
    ax.plot([start[0], end[0]], [start[1], end[1]], ":", color=BLACK, linewidth=2)


def _corner(ax, name, point, *beside):
    """A corner, its name away from what begins there and leads to some other points."""
    ax.plot(*point, "o", color=BLACK, markersize=9, zorder=5)
    toward = [_unit(other - point) for other in beside]
    away = -sum(toward)
    _beside(ax, name, point, away if np.linalg.norm(away) > 0.2 else -_left_of(toward[-1]))


def two_links(
    points: ArrayLike, angles_deg: tuple[float, float], lengths: tuple[str, str], title: str, ax: Axes | None = None
) -> Axes:
    """The paper's Fig. 7: both links with their lengths, both angles with the lines that they are counted from.

    Parameters
    ----------
    points : shoulder, elbow, hand, shape (3, 2), mm
    angles_deg : (θ1, θ2); where one is below zero, its arc goes clockwise
    lengths : labels of the upper arm and the forearm
    """
    ax = ax or plt.gca()
    shoulder, elbow, hand = np.asarray(points, float)
    theta1, theta2 = angles_deg
    long = np.linalg.norm(elbow - shoulder)
    _dotted(ax, shoulder, shoulder + [0.7 * long, 0])
    _dotted(ax, elbow, elbow + 0.6 * (elbow - shoulder))
    for color, a, b, label, turn in (
        (BLUE, shoulder, elbow, lengths[0], theta1),
        (VERMILION, elbow, hand, lengths[1], theta2),
    ):
        ax.plot([a[0], b[0]], [a[1], b[1]], "-", color=color, linewidth=5, solid_capstyle="round")
        beyond_the_arc = np.copysign(1, turn) * _left_of(b - a)
        _beside(ax, label, 0.35 * a + 0.65 * b, beyond_the_arc, color=color, weight="bold")
    _arc(ax, shoulder, 0, theta1, 0.45 * long, f"θ1 = {theta1:.0f}°")
    _arc(ax, elbow, theta1, theta2, 0.35 * long, f"θ2 = {theta2:.0f}°")
    _corner(ax, "shoulder", shoulder, shoulder + [1, 0], elbow)
    _corner(ax, "elbow", elbow, hand, shoulder)
    _corner(ax, "hand", hand, elbow)
    ax.margins(0.3, 0.2)
    return _plane(ax, title)


def arms(
    poses: Sequence[tuple[str, ArrayLike]], targets_mm: Sequence[Sequence[float]], title: str, ax: Axes | None = None
) -> Axes:
    """Arms in their plane.

    Parameters
    ----------
    poses : list of (label, points), points the shoulder, elbow and hand, shape (3, 2), mm
    targets_mm : list of (x, y), marked as balls
    """
    ax = ax or plt.gca()
    for k, (label, points) in enumerate(poses):
        points = np.asarray(points)
        color, dash = STYLES[k % 3]
        style: dict = {"color": color, "linewidth": 5, "solid_capstyle": "round", "zorder": 2, "label": label or None}
        ax.plot(points[:, 0], points[:, 1], dash, **style)
        ax.plot(points[:2, 0], points[:2, 1], "o", color=BLACK, markersize=9, zorder=3)
    for x, y in targets_mm:
        ax.plot(x, y, "o", color=ORANGE, markersize=15, markeredgecolor=BLACK, zorder=4)
    ax.margins(0.15)
    if any(label for label, _ in poses):
        ax.legend(loc="center left", bbox_to_anchor=(1.02, 0.5), handlelength=4)
    return _plane(ax, title)


def _upper_and_forearm(points, targets_mm, title, ax):
    """One arm in the colours of its two parts."""
    ax = arms([], targets_mm, title, ax)
    for color, part in ((BLUE, np.asarray(points)[:2]), (VERMILION, np.asarray(points)[1:])):
        ax.plot(*part.T, "-", color=color, linewidth=5, solid_capstyle="round", zorder=2)
        ax.plot(*part[0], "o", color=BLACK, markersize=9, zorder=3)
    return ax


def reach(
    near_mm: float,
    far_mm: float,
    x_mm: np.ndarray,
    y_mm: np.ndarray,
    poses_MxN: np.ndarray,
    balls_mm: np.ndarray,
    title: str,
    ax: Axes | None = None,
) -> Axes:
    """Where the hand can be: rings of the geometry, and how many poses within the limits reach each point.

    Parameters
    ----------
    x_mm, y_mm : axes of the grid
    poses_MxN : 0, 1 or 2 poses at each point
    balls_mm : ndarray, shape (K, 2)
    """
    ax = ax or plt.gca()
    colors = ("white", "#cfe6f5", "#56B4E9")
    ax.pcolormesh(
        x_mm, y_mm, poses_MxN, cmap=ListedColormap(colors), vmin=-0.5, vmax=2.5, shading="nearest", rasterized=True
    )
    for radius in (near_mm, far_mm):
        ax.add_patch(plt.Circle((0, 0), radius, fill=False, color=BLACK, linewidth=1.5, linestyle="--"))
    (balls,) = ax.plot(balls_mm[:, 0], balls_mm[:, 1], "o", color=ORANGE, markersize=8, markeredgecolor=BLACK)
    (shoulder,) = ax.plot(0, 0, "s", color=BLACK, markersize=8)
    (rings,) = ax.plot([], [], "--", color=BLACK, linewidth=1.5)
    ax.legend(
        [*(Patch(facecolor=c, edgecolor=BLACK) for c in colors[::-1]), rings, balls, shoulder],
        ["two poses", "one pose", "no pose", "bounds of the links alone", "balls", "shoulder"],
        loc="center left", bbox_to_anchor=(1.02, 0.5),
    )  # fmt: skip
    return _plane(ax, title)


def cosine_triangle(
    points: ArrayLike,
    lengths: Sequence[str],
    angles_deg: tuple[float, float, float],
    title: str,
    ax: Axes | None = None,
) -> Axes:
    """The triangle of shoulder, elbow and hand, with θ2 outside at the elbow and the hand's lead at the shoulder.

    Parameters
    ----------
    points : shoulder, elbow, hand, shape (3, 2)
    lengths : labels of the upper arm, the forearm and the line between
    angles_deg : (θ1, θ2, by how much the hand is ahead of the upper arm, seen from the shoulder)
    """
    ax = ax or plt.gca()
    points = np.asarray(points, float)
    closed = points[[0, 1, 2, 0]]
    ax.plot(closed[:2, 0], closed[:2, 1], "-", color=BLUE, linewidth=4)
    ax.plot(closed[1:3, 0], closed[1:3, 1], "-", color=VERMILION, linewidth=4)
    ax.plot(closed[2:, 0], closed[2:, 1], "--", color=BLACK, linewidth=2)
    theta1, theta2, ahead = angles_deg
    for label, a, b, along in zip(lengths, closed[:-1], closed[1:], (0.5, 0.7, 0.5), strict=True):  # θ2's arc is at 0.2
        out = _left_of(a - b) * np.copysign(1, theta2)  # of the triangle
        _beside(ax, label, a + along * (b - a), out, weight="bold")
    for k, name in enumerate(("shoulder", "elbow", "hand")):
        _corner(ax, name, points[k], points[k - 1], points[k - 2])
    _dotted(ax, points[1], points[1] + 0.45 * (points[1] - points[0]))
    long = np.linalg.norm(points[1] - points[0])
    _arc(ax, points[1], theta1, theta2, 0.25 * long, "θ2")
    _arc(ax, points[0], theta1, ahead, 0.3 * long, "ahead")
    ax.margins(0.3, 0.2)
    return _plane(ax, title)


def one_degree(
    points: ArrayLike, moves_mm: Sequence[tuple[str, ArrayLike]], title: str, ax: Axes | None = None
) -> Axes:
    """An arm, and where its hand goes for one degree of each joint, drawn larger.

    Parameters
    ----------
    moves_mm : list of (label, (dx, dy)) for the arrows, already enlarged
    """
    ax = _upper_and_forearm(points, [], title, ax)
    hand = np.asarray(points)[2]
    for k, (label, move) in enumerate(moves_mm):
        color, wide = ((GREEN, 2.5), (AMBER, 5))[k % 2]  # the second one shows beside the first
        tip = hand + move
        arrow = {"arrowstyle": "-|>", "linewidth": wide, "color": color, "shrinkA": 0, "shrinkB": 0}
        ax.annotate("", tip, xytext=hand, arrowprops=arrow, zorder=4 - k)
        ax.plot(*tip, color=color, linewidth=wide, label=label)
    ax.legend(loc="lower right")
    ax.margins(0.15, 0.2)
    return ax


def turret(
    from_above: Sequence[Sequence[float]],
    from_side: np.ndarray,
    titles: tuple[str, str],
    axes: Sequence[Axes] | np.ndarray,
) -> Sequence[Axes] | np.ndarray:
    """A turret arm from above (x, z) and in its own plane (out, y).

    Parameters
    ----------
    from_above : (hand, ball), each (x, z) in mm
    from_side : points of the arm, shape (3, 2): distance from the axis and height, mm
    axes : two axes
    """
    hand, ball = from_above
    above, side = axes
    above.plot([0, hand[0]], [0, hand[1]], "-", color=BLUE, linewidth=5)
    above.plot(*ball, "o", color=ORANGE, markersize=15, markeredgecolor=BLACK)
    above.plot(0, 0, "s", color=BLACK, markersize=9)
    above.set_aspect("equal")
    above.set_xlabel("x (mm)")
    above.set_ylabel("z (mm), the cameras are below")
    above.set_title(titles[0])
    above.margins(0.25)
    above.invert_yaxis()  # from above, with x to the right, z points down the page
    _upper_and_forearm(from_side, [from_side[2]], titles[1], side)
    side.set_xlabel("distance from the turret's axis (mm)")
    return axes

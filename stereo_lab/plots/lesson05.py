"""Figures of lesson 05: arms, their reach, and what a degree is worth."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np

from stereo_lab.plots.base import BLACK, BLUE, GREEN, ORANGE, VERMILION

LABEL = {"boxstyle": "round", "facecolor": "white", "edgecolor": "none", "alpha": 0.9}
STYLES = ((BLUE, "-"), (VERMILION, "--"), (GREEN, ":"))


def _plane(ax, title):
    ax.set_aspect("equal")
    ax.set_xlabel("x (mm)")
    ax.set_ylabel("y (mm)")
    ax.set_title(title)
    return ax


def arms(poses, targets_mm, title, ax=None):
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
        ax.plot(points[:, 0], points[:, 1], dash, color=color, linewidth=5, solid_capstyle="round", zorder=2)
        ax.plot(points[:2, 0], points[:2, 1], "o", color=BLACK, markersize=9, zorder=3)
        if label:
            ax.annotate(
                label, points[:2].mean(0), ha="center", color=color, weight="bold", bbox=LABEL, zorder=5,
            )  # fmt: skip
    for x, y in targets_mm:
        ax.plot(x, y, "o", color=ORANGE, markersize=15, markeredgecolor=BLACK, zorder=4)
    ax.margins(0.15)
    return _plane(ax, title)


def reach(near_mm, far_mm, x_mm, y_mm, poses_MxN, balls_mm, title, ax=None):
    """Where the hand can be: rings of the geometry, and how many poses within the limits reach each point.

    Parameters
    ----------
    x_mm, y_mm : axes of the grid
    poses_MxN : 0, 1 or 2 poses at each point
    balls_mm : ndarray, shape (K, 2)
    """
    ax = ax or plt.gca()
    colors = plt.matplotlib.colors.ListedColormap(["white", "#cfe6f5", "#8fc4e8"])
    ax.pcolormesh(x_mm, y_mm, poses_MxN, cmap=colors, vmin=-0.5, vmax=2.5, shading="nearest", rasterized=True)
    for radius in (near_mm, far_mm):
        ax.add_patch(plt.Circle((0, 0), radius, fill=False, color=BLACK, linewidth=1.5, linestyle="--"))
    ax.plot(balls_mm[:, 0], balls_mm[:, 1], "o", color=ORANGE, markersize=8, markeredgecolor=BLACK)
    ax.plot(0, 0, "s", color=BLACK, markersize=8)
    ax.annotate("shoulder", (0, 0), xytext=(8, -14), textcoords="offset points")
    return _plane(ax, title)


def cosine_triangle(points, lengths, angle_deg, title, ax=None):
    """The triangle of shoulder, elbow and hand, with θ2 outside at the elbow.

    Parameters
    ----------
    points : shoulder, elbow, hand, shape (3, 2)
    lengths : labels of the upper arm, the forearm and the line between
    angle_deg : (θ1, θ2)
    """
    ax = ax or plt.gca()
    points = np.asarray(points, float)
    names = ("shoulder", "elbow", "hand")
    closed = points[[0, 1, 2, 0]]
    ax.plot(closed[:2, 0], closed[:2, 1], "-", color=BLUE, linewidth=4)
    ax.plot(closed[1:3, 0], closed[1:3, 1], "-", color=VERMILION, linewidth=4)
    ax.plot(closed[2:, 0], closed[2:, 1], "--", color=BLACK, linewidth=2)
    for label, a, b in zip(lengths, closed[:-1], closed[1:], strict=True):
        ax.annotate(label, (a + b) / 2, xytext=(8, -16), textcoords="offset points", weight="bold")
    for name, point in zip(names, points, strict=True):
        ax.plot(*point, "o", color=BLACK, markersize=9)
        ax.annotate(name, point, xytext=(8, 8), textcoords="offset points")
    ahead = points[1] + 0.45 * (points[1] - points[0])
    ax.plot([points[1, 0], ahead[0]], [points[1, 1], ahead[1]], ":", color=BLACK, linewidth=2)
    size = 0.5 * np.linalg.norm(points[1] - points[0])
    start, turn = angle_deg
    ax.add_patch(plt.matplotlib.patches.Arc(points[1], size, size, theta1=start, theta2=start + turn, linewidth=2))
    middle = np.radians(start + turn / 2)
    ax.annotate("θ2", points[1] + 0.32 * size * 2 * np.array([np.cos(middle), np.sin(middle)]), weight="bold")
    ax.margins(0.18)
    return _plane(ax, title)


def one_degree(points, moves_mm, title, ax=None):
    """An arm, and where its hand goes for one degree of each joint, drawn larger.

    Parameters
    ----------
    moves_mm : list of (label, (dx, dy)) for the arrows, already enlarged
    """
    ax = arms([("", points)], [], title, ax)
    hand = np.asarray(points)[2]
    for k, (label, (dx, dy)) in enumerate(moves_mm):
        color = (GREEN, VERMILION)[k % 2]
        ax.annotate(
            "",
            hand + [dx, dy],
            xytext=hand,
            arrowprops={"arrowstyle": "-|>", "linewidth": 2.5, "color": color},
            zorder=5,
        )
        ax.plot(*(hand + [1.25 * dx, 1.25 * dy]), alpha=0)  # so that the axes take in the arrow
        ax.annotate(
            label, hand + [dx, dy], xytext=(0, (8, -18)[k % 2]), textcoords="offset points", ha="center", color=color,
            weight="bold", bbox=LABEL,
        )  # fmt: skip
    ax.margins(0.15, 0.2)
    return ax


def turret(from_above, from_side, titles, axes):
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
    above.set_ylabel("z (mm), up is towards the cameras")
    above.set_title(titles[0])
    above.margins(0.25)
    arms([("", from_side)], [from_side[2]], titles[1], side)
    side.set_xlabel("distance from the turret's axis (mm)")
    return axes

"""The figures of lesson 09: things as rows of numbers, a boundary that moves, shares and how well they are known."""

from __future__ import annotations

from collections.abc import Sequence

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from numpy.typing import ArrayLike

from stereo_lab.plots.base import AMBER, BLACK, BLUE, GREEN, VERMILION, Numbers, show_image

__all__ = ["boundaries", "evidence_counts", "loss_falls", "many_draws", "numbered_things", "shares"]

DASHES = (":", "--", "-.", "-")


def numbered_things(image: np.ndarray, circles_Nx3: ArrayLike, title: str, ax: Axes | None = None) -> Axes:
    """A picture with a circle and a number for each thing in it that may be the ball."""
    ax = show_image(image, title, ax)
    for k, (u, v, r) in enumerate(np.asarray(circles_Nx3)):
        ax.add_patch(plt.Circle((u, v), r + 2, fill=False, color=BLUE, linewidth=2))
        box = {"facecolor": "white", "edgecolor": BLUE, "pad": 1.5}
        beside = min(u + r + 8, image.shape[1] - 20)
        ax.annotate(str(k), (beside, max(v - r, 14)), color=BLUE, weight="bold", va="center", bbox=box)
    return ax


def boundaries(
    x: np.ndarray,
    y: np.ndarray,
    is_ball: np.ndarray,
    lines: dict[str, Sequence[float]],
    names: tuple[str, str],
    title: str,
    ax: Axes | None = None,
) -> Axes:
    """Things by two pieces of evidence, and lines a·x + b·y + c = 0 between balls and others.

    Parameters
    ----------
    x, y : ndarray, shape (N,)
    is_ball : ndarray of bool, shape (N,)
    lines : dict, a name -> (a, b, c)
    names : of the two axes
    """
    ax = ax or plt.gca()
    ax.plot(x[~is_ball], y[~is_ball], "x", color=AMBER, markersize=5, alpha=0.7, label="something else")
    ax.plot(x[is_ball], y[is_ball], "o", color=BLUE, markersize=7, alpha=0.8, label="the ball")
    ax.set_xlim(x.min() - 0.1, x.max() + 0.1)
    ax.set_ylim(y.min() - 0.1, y.max() + 0.1)
    colors = (BLACK,) if len(lines) == 1 else (GREEN, VERMILION, BLUE, BLACK)
    for k, (name, (a, b, c)) in enumerate(lines.items()):
        if a or b:
            far = 1e3 * np.array([-b, a]) / np.hypot(a, b)
            foot = -c * np.array([a, b]) / (a * a + b * b)
            ends = np.array([foot - far, foot + far])
            dash = DASHES[k % 4] if len(lines) > 1 else "-"
            ax.plot(*ends.T, dash, color=colors[k % len(colors)], linewidth=2.2, label=name, scalex=False, scaley=False)
    ax.set_xlabel(names[0])
    ax.set_ylabel(names[1])
    ax.set_title(title)
    ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.18), ncols=3)
    return ax


def loss_falls(losses: Numbers, title: str, ax: Axes | None = None) -> Axes:
    """The loss after each step."""
    ax = ax or plt.gca()
    ax.plot(range(len(losses)), losses, color=BLUE, linewidth=2.2)
    ax.set_ylim(0, None)
    ax.set_xlabel("steps")
    ax.set_ylabel("loss")
    ax.set_title(title)
    return ax


def shares(
    names: Sequence[str],
    percent: Numbers,
    low: Numbers,
    high: Numbers,
    what: str,
    title: str,
    ax: Axes | None = None,
    color: str = BLUE,
) -> Axes:
    """A dot for each share in percent, and a line from the lowest to the highest that it may be."""
    ax = ax or plt.gca()
    places = np.arange(len(names))
    middle = np.asarray(percent, float)
    reach = np.array([middle - np.asarray(low, float), np.asarray(high, float) - middle])
    ax.errorbar(middle, places, xerr=reach, fmt="o", color=color, markersize=9, capsize=5, linewidth=2)
    for place, value, end in zip(places, middle, high, strict=True):
        ax.annotate(f"{value:.0f}", (end, place), (7, 0), textcoords="offset points", va="center")
    ax.set_yticks(places, list(names))
    ax.invert_yaxis()
    ax.set_xlim(-3, 114)
    ax.margins(y=0.2)
    ax.set_xlabel(what)
    ax.set_title(title)
    return ax


def many_draws(
    learned: dict[str, tuple[Numbers, Numbers]],
    others: dict[str, tuple[float, float]],
    title: str,
    ax: Axes | None = None,
) -> Axes:
    """A mark for each learned detector: false alarms across, balls found upward.

    Parameters
    ----------
    learned : dict, a name -> (percent of false alarms, percent of balls) of many
    others : dict, a name -> the same two numbers of one
    """
    ax = ax or plt.gca()
    for (name, (alarms, balls)), marker, color in zip(learned.items(), "o^", (BLUE, VERMILION), strict=False):
        ax.plot(alarms, balls, marker, color=color, markersize=9, alpha=0.6, label=name)
    for (name, (alarm, right)), marker, color in zip(others.items(), "Ds", (GREEN, BLACK), strict=False):
        ax.plot([alarm], [right], marker, color=color, markersize=12, label=name)
    ax.set_xlim(left=-1)
    ax.set_xlabel("something named where no ball is (%)")
    ax.set_ylabel("balls right (%)")
    ax.set_title(title)
    ax.legend(loc="lower right")
    return ax


def evidence_counts(names: Sequence[str], lost: Numbers, title: str, ax: Axes | None = None) -> Axes:
    """For each piece of evidence how many balls are lost and false alarms come without it."""
    ax = ax or plt.gca()
    bars = ax.barh(range(len(names)), lost, color=BLUE)
    ax.bar_label(bars, fmt="%.0f", padding=4)
    ax.axvline(0, color=BLACK, linewidth=1)
    ax.set_yticks(range(len(names)), list(names))
    ax.invert_yaxis()
    ax.margins(x=0.12)
    ax.set_xlabel("balls no longer right, and false alarms that come, without it")
    ax.set_title(title)
    return ax

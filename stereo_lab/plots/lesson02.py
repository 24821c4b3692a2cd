"""Figures of lesson 02."""

from __future__ import annotations

from collections.abc import Sequence

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from numpy.typing import ArrayLike

from stereo_lab.plots.base import AMBER, BLACK, BLUE, VERMILION, show_image

__all__ = ["answers_bar", "flow", "heat", "hue_circle", "mask_view", "reliability", "signs", "suspect"]


def mask_view(mask: np.ndarray, title: str, ax: Axes | None = None) -> Axes:
    """A mask: white where pixels are kept."""
    ax = ax or plt.gca()
    ax.imshow(mask, cmap="gray", vmin=0, vmax=255, interpolation="nearest")
    ax.set_title(title)
    ax.set_xticks([])
    ax.set_yticks([])
    ax.grid(False)
    return ax


def hue_circle(title: str, ax: Axes | None = None) -> Axes:
    """OpenCV's hues, 0 to 180, as a band of colours; red at both ends."""
    ax = ax or plt.gca()
    band = plt.get_cmap("hsv")(np.linspace(0, 1, 180))[None, :, :3]
    ax.imshow(band, extent=(-0.5, 179.5, 0, 1), aspect="auto", interpolation="nearest")
    for low, high in ((0, 7), (172, 180)):
        ax.plot([low, high], [1.12, 1.12], color=BLACK, linewidth=6, clip_on=False)
        ax.annotate("red", ((low + high) / 2, 1.2), ha="center", annotation_clip=False)
    for hue, name in ((13, "orange"), (27, "yellow"), (62, "green"), (114, "blue")):
        ax.annotate(name, (hue, 1.2), ha="center", annotation_clip=False)
    ax.set_yticks([])
    ax.set_xlabel("hue H as OpenCV counts it")
    ax.set_title(title, pad=38)
    ax.grid(False)
    return ax


def heat(
    votes: np.ndarray,
    center: tuple[float, float] | None,
    title: str,
    ax: Axes | None = None,
) -> Axes:
    """Votes as a heat map; a cross on a centre (u, v), or none."""
    ax = ax or plt.gca()
    picture = ax.imshow(votes, cmap="inferno", interpolation="nearest", vmin=0)
    if center is not None:
        ax.plot(*center, "+", color="white", markersize=16, markeredgewidth=2)
    bar = ax.figure.colorbar(picture, ax=ax, shrink=0.8)
    bar.set_label("votes")
    ax.set_title(title)
    ax.set_xlabel("u (px)")
    ax.set_ylabel("v (px)")
    ax.grid(False)
    return ax


def flow(steps: Sequence[str], title: str, ax: Axes | None = None) -> Axes:
    """Boxes from left to right with arrows: the steps of an algorithm."""
    ax = ax or plt.gca()
    for k, text in enumerate(steps):
        ax.text(k, 0, text, ha="center", va="center", fontsize=12,
                bbox={"boxstyle": "round,pad=0.6", "facecolor": "white", "edgecolor": BLUE, "linewidth": 2})  # fmt: skip
        if k:
            arrow = {"arrowstyle": "-|>", "color": BLACK}
            ax.annotate("", (k - 0.36, 0), (k - 0.9, 0), arrowprops=arrow, zorder=0)
    ax.set_xlim(-0.5, len(steps) - 0.5)
    ax.set_ylim(-0.6, 0.6)
    ax.axis("off")
    ax.set_title(title)
    return ax


def answers_bar(
    names: Sequence[str], paper_percent: ArrayLike, ours_percent: ArrayLike, title: str, ax: Axes | None = None
) -> Axes:
    """Right answers of both methods, in percent, for a few kinds of pictures."""
    ax = ax or plt.gca()
    place = np.arange(len(names))
    for values, offset, color, hatch, label in (
        (paper_percent, -0.2, VERMILION, "//", "paper's method"), (ours_percent, 0.2, BLUE, "", "ours"),
    ):  # fmt: skip
        bars = ax.bar(place + offset, values, 0.38, color=color, hatch=hatch, edgecolor="white", label=label)
        ax.bar_label(bars, fmt="%.0f")
    ax.set_xticks(place, names)
    ax.set_ylim(0, 118)
    ax.set_ylabel("right answers (%)")
    ax.set_title(title)
    ax.legend(loc="upper right", ncols=2)
    ax.axhline(100, color=AMBER, linestyle=":")
    return ax


def suspect(image: np.ndarray, u: float, v: float, radius_px: float, title: str, ax: Axes | None = None) -> Axes:
    """One thing of a picture, cut out and made larger, with a thin circle a little outside its rim."""
    ax = show_image(image, title, ax)
    reach = 2.4 * radius_px + 2
    ax.set_xlim(u - reach, u + reach)
    ax.set_ylim(v + reach, v - reach)
    ax.add_patch(plt.Circle((u, v), 1.1 * radius_px + 1, fill=False, color=BLUE, linewidth=1.5))
    return ax


def signs(speaks: dict[str, float], title: str, named: bool, ax: Axes | None = None) -> Axes:
    """What speaks for a thing, to the right, and what against it, to the left, as bars; ``named``: with names beside them."""
    ax = ax or plt.gca()
    values = np.array(list(speaks.values()))
    for sign, color, hatch in ((values > 0, BLUE, ""), (values <= 0, VERMILION, "//")):
        ax.barh(np.flatnonzero(sign), values[sign], color=color, hatch=hatch, edgecolor="white")
    ax.axvline(0, color=BLACK, linewidth=1)
    ax.set_yticks(range(len(values)), list(speaks) if named else [""] * len(values))
    ax.invert_yaxis()
    ax.set_xlim(-4, 4)
    ax.set_xlabel("against  |  for a ball")
    ax.set_title(title)
    return ax


def reliability(told: np.ndarray, true: np.ndarray, count: np.ndarray, title: str, ax: Axes | None = None) -> Axes:
    """Share of right ones against the probability told, a dot a bin: the larger, the more it counts.

    Parameters
    ----------
    told, true : ndarray, mean probability and share of right ones of each bin; NaN where it is empty
    count : ndarray, how many each bin holds
    """
    ax = ax or plt.gca()
    ax.plot([0, 1], [0, 1], "--", color=BLACK, linewidth=1, label="told is true")
    areas = 25 + 40 * np.sqrt(count)  # square points
    ax.scatter(told, true, s=areas, color=BLUE, alpha=0.8, zorder=3)
    for x, y, n, area in zip(told, true, count, areas, strict=True):
        if n:
            above = (0, np.sqrt(area) / 2 + 4)
            ax.annotate(str(n), (x, y), above, textcoords="offset points", ha="center", annotation_clip=False)
    ax.set_xlim(-0.05, 1.05)
    ax.set_ylim(-0.16, 1.15)  # a large dot at 0 is not cut off
    ax.set_xlabel("probability told")
    ax.set_ylabel("share of balls")
    ax.set_title(title)
    ax.legend(loc="lower right")
    return ax

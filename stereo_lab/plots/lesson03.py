"""Figures of lesson 03."""

from __future__ import annotations

from collections.abc import Sequence

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from numpy.typing import ArrayLike

from stereo_lab.plots.base import BLACK, BLUE, GREEN, VERMILION, Numbers

__all__ = ["error_against_depth", "rays_spread"]


def error_against_depth(
    series: Sequence[tuple[str, ArrayLike, ArrayLike]], plane_mm: float, title: str, ax: Axes | None = None
) -> Axes:
    """Size of an error against depth: ``series`` is a list of (name, depths in mm, errors in mm)."""
    ax = ax or plt.gca()
    for (name, depth, error), (color, mark) in zip(series, ((VERMILION, "s"), (BLUE, "o")), strict=False):
        ax.plot(depth, np.maximum(error, 0.05), mark, color=color, markeredgecolor=BLACK, markersize=7, label=name)
    ax.axvline(plane_mm, color=GREEN, linestyle="--", label="plane of the arm")
    ax.set_yscale("log")
    ax.set_yticks([0.1, 1, 10, 100], ["0.1", "1", "10", "100"])
    ax.set_xlabel("depth (mm)")
    ax.set_ylabel("error in x and y (mm)")
    ax.set_title(title)
    ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.16), ncols=3)
    return ax


def rays_spread(x_per_z: Numbers, depths_mm: Numbers, plane_mm: float, title: str, ax: Axes | None = None) -> Axes:
    """Rays of a few pixels from above: how far to the side each is at a few depths; all in mm."""
    ax = ax or plt.gca()
    far = max(depths_mm)
    for k, slope in enumerate(x_per_z):
        ax.plot([0, far], [0, slope * far], "-", color=BLUE, linewidth=1 + 1.2 * (k == len(x_per_z) - 1))
    for depth in depths_mm:
        x = x_per_z[-1] * depth
        ax.plot([depth, depth], [0, x], ":", color=BLACK)
        ax.plot(depth, x, "o", color=VERMILION, markeredgecolor=BLACK, markersize=9)
        ax.annotate(f"x = {x:.0f} mm", (depth, x), xytext=(-12, 6), textcoords="offset points", ha="right")
    ax.axvline(plane_mm, color=GREEN, linestyle="--")
    ax.annotate(" plane of the arm", (plane_mm, 0.03), xycoords=("data", "axes fraction"))
    ax.margins(y=0.12)
    ax.set_xlabel("depth Z (mm)")
    ax.set_ylabel("x in the camera's frame (mm)")
    ax.set_title(title)
    return ax

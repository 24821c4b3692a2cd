"""Figures of lesson 04."""

from __future__ import annotations

from collections.abc import Sequence

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from numpy.typing import ArrayLike

from stereo_lab.plots.base import BLACK, BLUE, GREEN, ORANGE, VERMILION

__all__ = [
    "beams_cross",
    "depth_curves",
    "depth_terms",
    "error_band",
    "error_grid",
    "error_of_baseline",
    "similar_triangles",
]


def similar_triangles(
    baseline_mm: float, focal_px: float, depth_mm: float, x_mm: float, title: str, ax: Axes | None = None
) -> Axes:
    """Two pinhole cameras from above, the ball, and where its rays meet the sensors (not to scale).

    The right camera's ray is drawn at the left camera once more: what the two cut out of the sensor is the disparity d.
    """
    ax = ax or plt.gca()
    sensor = 0.18 * depth_mm  # drawn length of the focal distance
    ball = np.array([x_mm, depth_mm])
    for x, name, color, dash in ((0.0, "left", BLUE, "-"), (baseline_mm, "right", VERMILION, "--")):
        hit = x + (ball[0] - x) * sensor / depth_mm
        ax.plot([x, ball[0]], [0, ball[1]], dash, color=color, linewidth=2)
        ax.plot([x - 0.45 * baseline_mm, x + 0.45 * baseline_mm], [sensor, sensor], color=BLACK, linewidth=3)
        ax.plot([x, x], [0, sensor], ":", color=BLACK)
        ax.plot(x, 0, "^", color=color, markersize=14)
        ax.plot(hit, sensor, "o", color=color, markersize=8)
        ax.annotate(f"{name} camera", (x, 0), xytext=(0, -20), textcoords="offset points", ha="center")
        ax.annotate(f"u {name}", (hit, sensor), xytext=(8, 6), textcoords="offset points", color=color, weight="bold")
    shifted = (x_mm - baseline_mm) * sensor / depth_mm  # where the right camera's ray would meet the left sensor
    ax.plot([0, 2.2 * shifted], [0, 2.2 * sensor], "--", color=VERMILION, linewidth=1)
    ax.plot(shifted, sensor, "o", color=VERMILION, markersize=8, markerfacecolor="white")
    ax.fill([0, shifted, x_mm * sensor / depth_mm], [0, sensor, sensor], color=GREEN, alpha=0.25, linewidth=0)
    ends = (shifted, 1.25 * sensor), (x_mm * sensor / depth_mm, 1.25 * sensor)
    ax.annotate("", *ends, arrowprops={"arrowstyle": "<->", "color": GREEN})
    ax.annotate("d", (sum(u for u, _ in ends) / 2, 1.27 * sensor), ha="center", va="bottom", color=GREEN, weight="bold")
    ax.plot(*ball, "o", color=ORANGE, markersize=18, markeredgecolor=BLACK)
    ax.annotate("ball", (x_mm, depth_mm), xytext=(14, -4), textcoords="offset points")
    far = baseline_mm * 1.75
    ax.annotate("", (far, 0), (far, depth_mm), arrowprops={"arrowstyle": "<->"})
    ax.annotate(" Z", (far, depth_mm / 2))
    ax.annotate("", (0, -0.16 * depth_mm), (baseline_mm, -0.16 * depth_mm), arrowprops={"arrowstyle": "<->"})
    ax.annotate("B", (baseline_mm / 2, -0.155 * depth_mm), ha="center", va="bottom")
    ax.annotate("", (-0.6 * baseline_mm, 0), (-0.6 * baseline_mm, sensor), arrowprops={"arrowstyle": "<->"})
    ax.annotate("f ", (-0.6 * baseline_mm, sensor / 2), ha="right", va="center")
    ax.set_xlim(-0.9 * baseline_mm, 2.1 * baseline_mm)
    ax.set_ylim(-0.26 * depth_mm, 1.12 * depth_mm)
    ax.axis("off")
    ax.set_title(title)
    return ax


def depth_curves(
    curves: Sequence[tuple[str, ArrayLike, ArrayLike]],
    fit_px: ArrayLike,
    fit_mm: ArrayLike,
    check_px: ArrayLike,
    check_mm: ArrayLike,
    title: str,
    ax: Axes | None = None,
) -> Axes:
    """Depth against disparity: ``curves`` is a list of (name, disparities, depths); samples as marks."""
    ax = ax or plt.gca()
    styles = ((BLUE, "-"), (VERMILION, "--"), (GREEN, "-."))
    for (name, d, depth), (color, dash) in zip(curves, styles, strict=False):
        ax.plot(d, depth, dash, color=color, linewidth=2, label=name)
    ax.plot(fit_px, fit_mm, "o", color=BLACK, markersize=9, label="samples to fit")
    ax.plot(check_px, check_mm, "s", color=ORANGE, markeredgecolor=BLACK, markersize=9, label="samples to check")
    ax.set_xlabel("disparity d (px, rectified)")
    ax.set_ylabel("depth (mm)")
    ax.set_title(title)
    ax.legend()
    return ax


def depth_terms(d_px: np.ndarray, terms: Sequence[tuple[str, np.ndarray]], title: str, ax: Axes | None = None) -> Axes:
    """The terms of Eq. 4 on their own: a list of (name, values in mm)."""
    ax = ax or plt.gca()
    places = (0.1, 0.75, 0.5)  # of the names, each on its own line and on a patch of white: no line strikes one through
    looks = ((BLUE, "-"), (VERMILION, "--"), (GREEN, "-."))
    for (name, values), (color, dash), place in zip(terms, looks, places, strict=False):
        k = int(place * len(d_px))
        ax.plot(d_px, values, dash, color=color, linewidth=2)
        ax.text(
            d_px[k], values[k], name, ha="center", va="center", color=color, weight="bold", zorder=5,
            bbox={"facecolor": "white", "edgecolor": "none", "pad": 4},
        )  # fmt: skip
    ax.margins(y=0.1)  # room for a name on the lowest line
    ax.axhline(0, color=BLACK, linewidth=1)
    ax.set_xlabel("disparity d (px)")
    ax.set_ylabel("part of the depth (mm)")
    ax.set_title(title)
    return ax


def beams_cross(
    baseline_mm: float, crossings: Sequence[tuple[str, ArrayLike]], title: str, ax: Axes | None = None
) -> Axes:
    """Two cameras from above, and where the beams of two pixels cross, to one scale.

    ``crossings`` is a list of (name, corners): depth and x of the nearest corner, of the one at the right edges of both
    beams, of the farthest, and of the one at the left edges, shape (4, 2), mm.
    """
    ax = ax or plt.gca()
    for (name, corners), color in zip(crossings, (VERMILION, ORANGE), strict=False):
        _, right, _, left = rim = np.asarray(corners, float)
        for lens_x in (-baseline_mm / 2, baseline_mm / 2):
            for edge in (right, left):
                ax.plot([0, edge[0]], [lens_x, edge[1]], ":", color=BLACK, linewidth=1.2)
        ax.fill(*rim.T, facecolor=color, edgecolor=BLACK, linewidth=1.2)
        ax.text(left[0], -0.65 * baseline_mm, name, ha="center", va="center", fontsize=13)  # where no beam runs
    for side, name, color in ((-1, "left camera", BLUE), (1, "right camera", GREEN)):
        ax.plot(0, side * baseline_mm / 2, ">", color=color, markersize=14)
        ax.text(0, side * 0.72 * baseline_mm, name, ha="center", va="center", fontsize=13)
    ax.set_aspect("equal")
    ax.margins(x=0.02)
    ax.set(xlim=(-0.8 * baseline_mm, None), ylim=(-0.9 * baseline_mm, 0.9 * baseline_mm))
    ax.set_xlabel("depth (mm)")
    ax.set_ylabel("x (mm)")
    ax.set_title(title)
    return ax


def error_band(
    depth_mm: ArrayLike,
    errors_mm: ArrayLike,
    band_depth_mm: np.ndarray,
    band_mm: np.ndarray,
    title: str,
    ax: Axes | None = None,
) -> Axes:
    """Depth errors against depth, and the limit as a band (one and two standard deviations)."""
    ax = ax or plt.gca()
    for times, alpha in ((2, 0.18), (1, 0.3)):
        ax.fill_between(band_depth_mm, -times * band_mm, times * band_mm, color=BLUE, alpha=alpha, linewidth=0)
    ax.plot(band_depth_mm, band_mm, "--", color=BLUE)
    ax.plot(band_depth_mm, -band_mm, "--", color=BLUE)
    ax.annotate("limit, 1 σ", (band_depth_mm[-1], band_mm[-1]), xytext=(-70, 6), textcoords="offset points", color=BLUE)
    ax.plot(depth_mm, errors_mm, "o", color=VERMILION, markeredgecolor=BLACK, markersize=7)
    ax.axhline(0, color=BLACK, linewidth=1)
    ax.set_xlabel("depth (mm)")
    ax.set_ylabel("depth error (mm)")
    ax.set_title(title)
    return ax


def error_grid(
    mean_mm: np.ndarray, rows: Sequence[str], columns: Sequence[str], title: str, ax: Axes | None = None
) -> Axes:
    """Mean errors, shape (rows, columns), mm: the darker a cell, the larger; NaN stays white."""
    ax = ax or plt.gca()
    shade = np.log(np.clip(mean_mm, 1e-2, None))
    low, high = np.nanmin(shade), max(np.nanmax(shade), np.nanmin(shade) + 1e-6)
    ax.imshow(shade, cmap="Blues", vmin=low, vmax=low + 1.8 * (high - low), aspect="auto")
    for (row, column), mm in np.ndenumerate(mean_mm):
        ax.text(column, row, "–" if np.isnan(mm) else f"{mm:.1f}", ha="center", va="center", color=BLACK, fontsize=14)
    ax.set_xticks(range(len(columns)), [name.replace(", ", ",\n") for name in columns])
    ax.set_yticks(range(len(rows)), rows)
    ax.grid(False)
    ax.set_title(title)
    return ax


def error_of_baseline(
    baselines_mm: np.ndarray,
    lines: Sequence[tuple[str, np.ndarray]],
    here_mm: float,
    title: str,
    ax: Axes | None = None,
) -> Axes:
    """Limit against baseline for a few depths: ``lines`` is a list of (name, values in mm)."""
    ax = ax or plt.gca()
    for (name, values), (color, dash) in zip(lines, ((BLUE, "-"), (VERMILION, "--"), (GREEN, "-.")), strict=False):
        ax.plot(baselines_mm, values, dash, color=color, linewidth=2)
        ax.annotate(name, (baselines_mm[len(values) // 4], values[len(values) // 4]), xytext=(6, 4),
                    textcoords="offset points", color=color, weight="bold")  # fmt: skip
    ax.axvline(here_mm, color=BLACK, linestyle=":")
    ax.annotate(" this rig", (here_mm, 0.9), xycoords=("data", "axes fraction"))
    ax.set_xlabel("baseline B (mm)")
    ax.set_ylabel("depth error, 1 σ (mm)")
    ax.set_ylim(bottom=0)
    ax.set_title(title)
    return ax

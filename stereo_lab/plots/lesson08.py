"""The figures of lesson 08: a rig before it is built, how a fault in a recording was seen, and one's own error."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

from stereo_lab.plots.base import BLACK, BLUE, GREEN, ORANGE, VERMILION, Numbers, with_text_in_style

MOST_NAMES = 30  # under an axis, that can still be read


@with_text_in_style
def numbers_by_file(
    names: list[str], values: Numbers, marked: list[str], what: str, title: str, ax: Axes | None = None
) -> Axes:
    """A bar for each file; those at fault are hatched."""
    ax = ax or plt.gca()
    for chosen, color, hatch, label in ((False, BLUE, "", "others"), (True, VERMILION, "///", "at fault")):
        places = [k for k, name in enumerate(names) if (name in marked) == chosen]
        if places:
            sizes = [values[k] for k in places]
            ax.bar(places, sizes, color=color, hatch=hatch, edgecolor="white", label=label)
    step = max(1, -(-len(names) // MOST_NAMES))
    ax.set_xticks(range(0, len(names), step), [name for name in names[::step]], rotation=90, fontsize=11)
    ax.set_ylabel(what)
    ax.set_title(title)
    ax.margins(x=0.01)
    if marked:
        ax.legend()
    return ax


@with_text_in_style
def where_boards_were(corners_Nx2: np.ndarray, image_size: tuple[int, int], title: str, ax: Axes | None = None) -> Axes:
    """All corners of all boards in one camera's picture."""
    ax = ax or plt.gca()
    ax.plot(*np.asarray(corners_Nx2).T, ".", color=BLUE, markersize=4)
    ax.set_xlim(0, image_size[0])
    ax.set_ylim(image_size[1], 0)
    ax.set_aspect("equal")
    ax.set_xlabel("u (px)")
    ax.set_ylabel("v (px)")
    ax.set_title(title)
    return ax


@with_text_in_style
def both_views(
    baseline_mm: float, focal_px: float, width_px: float, strips: list[tuple[float, float]], title: str, ax: Axes | None = None
) -> Axes:  # fmt: skip
    """Two cameras from above that look straight ahead, what each sees, and how wide a strip both see.

    Parameters
    ----------
    baseline_mm, focal_px, width_px : float, of the cameras
    strips : (depth, width of what both see) of some depths, mm
    """
    ax = ax or plt.gca()
    far = 1.12 * max(depth for depth, _ in strips)
    half = far * width_px / focal_px / 2
    for x, color, hatch, name in (
        (-baseline_mm / 2, BLUE, "//", "left"),
        (baseline_mm / 2, VERMILION, "\\\\", "right"),
    ):
        wedge = [(x, 0), (x - half, far), (x + half, far)]
        ax.add_patch(plt.Polygon(wedge, facecolor=color, alpha=0.18, linewidth=0))
        ax.add_patch(plt.Polygon(wedge, fill=False, edgecolor=color, hatch=hatch, linewidth=0, alpha=0.35))
        ax.plot([x - half, x, x + half], [far, 0, far], color=color, linewidth=1.5)
        ax.plot([x], [0], "s", color=color, markersize=9)
        side = -1 if x < 0 else 1
        ax.annotate(name, (x, 0), xytext=(14 * side, 0), textcoords="offset points", va="center",
                    ha="right" if x < 0 else "left", color=color, weight="bold")  # fmt: skip
    box = {"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 1.0}
    for depth, wide in strips:
        if wide > 0:
            ax.annotate("", (-wide / 2, depth), (wide / 2, depth), arrowprops={"arrowstyle": "<->", "linewidth": 2})
        told = f"{wide:.0f} mm" if wide > 0 else "none"
        ax.annotate(told, (0, depth), xytext=(0, 6), textcoords="offset points", ha="center", va="bottom", bbox=box)
    ax.set_aspect("equal")
    ax.set_xlim(-half - baseline_mm, half + baseline_mm)
    ax.set_ylim(-0.1 * far, far)
    ax.set_xlabel("to the right (mm)")
    ax.set_ylabel("depth (mm)")
    ax.set_title(title)
    return ax


@with_text_in_style
def value_by_pair(names: list[str], values: Numbers, what: str, title: str, ax: Axes | None = None) -> Axes:
    """A dot for each pair, in their order."""
    ax = ax or plt.gca()
    ax.plot(range(len(names)), values, "o", color=BLUE, markersize=9)
    ax.set_xticks(range(len(names)), names, rotation=90, fontsize=11)
    ax.set_xlabel("pair")
    ax.set_ylabel(what)
    ax.set_title(title)
    return ax


@with_text_in_style
def told_and_typed(names: list[str], told_mm: Numbers, typed_mm: Numbers, title: str, ax: Axes | None = None) -> Axes:
    """What the cameras tell of each sample beside what is written in its table."""
    ax = ax or plt.gca()
    places = np.arange(len(names))
    ax.bar(places - 0.2, told_mm, 0.4, color=BLUE, label="the cameras tell")
    ax.bar(places + 0.2, typed_mm, 0.4, color=ORANGE, hatch="///", edgecolor="white", label="the table says")
    ax.set_xticks(places, names)
    ax.set_xlabel("sample of the set depth")
    ax.set_ylabel("depth (mm)")
    ax.set_title(title)
    ax.legend()
    return ax


@with_text_in_style
def own_errors(
    names: list[str], to_ruler_mm: Numbers, to_truth_mm: Numbers | None, title: str, ax: Axes | None = None
) -> Axes:
    """How far the cameras' depth lies from the ruler's, point by point, and from the exact one where that is known."""
    ax = ax or plt.gca()
    ax.axhline(0, color=BLACK, linewidth=1)
    ax.plot(range(len(names)), to_ruler_mm, "o", color=BLUE, markersize=10, label="… the ruler")
    if to_truth_mm is not None:
        ax.plot(
            range(len(names)),
            to_truth_mm,
            "x",
            color=VERMILION,
            markersize=10,
            markeredgewidth=2.5,
            label="… the truth",
        )
    ax.set_xticks(range(len(names)), names)
    ax.set_xlabel("place")
    ax.set_ylabel("cameras' depth less … (mm)")
    ax.set_title(title)
    ax.legend()
    return ax


@with_text_in_style
def rig_drawing(
    baseline_mm: float, depth_mm: float, high_mm: float, titles: tuple[str, str], axes: np.ndarray
) -> np.ndarray:
    """A rig to build, from above and from the side, on two axes, with the names of its parts.

    Parameters
    ----------
    baseline_mm : float, from lens to lens
    depth_mm : float, from the lenses to the plane in which the ball is measured
    high_mm : float, of the lenses above the table
    titles : of the two drawings
    axes : ndarray of two Axes
    """
    above, side = np.ravel(axes)
    wide, back = 0.45 * depth_mm, 1.25 * depth_mm
    _bar_from_above(above, baseline_mm)
    above.plot([depth_mm] * 2, [-wide, wide], "--", color=GREEN, linewidth=2)
    above.plot([back] * 2, [-wide, wide], color=BLACK, linewidth=4)
    above.plot([depth_mm], [0.4 * wide], "o", color=VERMILION, markersize=12)
    above.annotate("", (0, -0.8 * wide), (depth_mm, -0.8 * wide), arrowprops={"arrowstyle": "<->"})
    above.annotate(f"depth {depth_mm:.0f} mm", (depth_mm / 2, -0.86 * wide), ha="center")
    above.annotate("plane of the arm", (depth_mm, 0.95 * wide), xytext=(-10, 0), textcoords="offset points", ha="right")
    above.annotate("ball", (depth_mm, 0.4 * wide), xytext=(-12, 0), textcoords="offset points", ha="right", va="center")
    above.annotate(
        "plain card", (back, 0), xytext=(-6, 0), textcoords="offset points", ha="right", va="center", rotation=90
    )
    side.plot([-0.15 * depth_mm, 1.3 * depth_mm], [0, 0], color=BLACK, linewidth=4)
    side.plot([0, 0], [0, high_mm], color=BLACK, linewidth=6)
    side.plot([0], [high_mm], "s", color=BLUE, markersize=14)
    side.plot([0, depth_mm], [high_mm, 0.6 * high_mm], ":", color=BLUE)
    side.plot([depth_mm] * 2, [0, 0.6 * high_mm], color=BLACK, linewidth=2)
    side.plot([depth_mm], [0.6 * high_mm], "o", color=VERMILION, markersize=12)
    side.plot([back] * 2, [0, 1.2 * high_mm], color=BLACK, linewidth=4)
    for text, place, shift in (
        ("cameras on one bar,\nscrewed down", (0, high_mm), (14, 16)), ("ball on a rod", (depth_mm, 0.25 * high_mm), (-8, 0)),
        ("plain card", (back, 1.2 * high_mm), (-8, -2)), ("a steady stand", (0, 0.4 * high_mm), (12, 0)),
    ):  # fmt: skip
        at = "left" if shift[0] > 0 else "right"
        side.annotate(text, place, xytext=shift, textcoords="offset points", ha=at, va="center")
    for ax, title, across in ((above, titles[0], "to the right (mm)"), (side, titles[1], "up (mm)")):
        ax.set_aspect("equal")
        ax.set_xlabel("away from the cameras (mm)")
        ax.set_ylabel(across)
        ax.set_title(title)
    above.invert_yaxis()
    above.margins(y=0.15)
    side.set_ylim(-0.15 * high_mm, 1.75 * high_mm)
    return axes


def _bar_from_above(ax, baseline_mm):
    """Two cameras on their bar, with the distance of their lenses."""
    half = baseline_mm / 2
    ax.plot([0, 0], [-1.6 * half, 1.6 * half], color="0.5", linewidth=6)
    ax.plot([0, 0], [-half, half], "s", color=BLUE, markersize=12)
    for place, text in ((-half, "left"), (half, f"right, {baseline_mm:.0f} mm apart")):
        shift = (14, 6 if place < 0 else -6)
        ax.annotate(text, (0, place), xytext=shift, textcoords="offset points", va="center")


@with_text_in_style
def depth_errors(curves: list[tuple[str, np.ndarray, np.ndarray]], title: str, ax: Axes | None = None) -> Axes:
    """The error of depth against depth; a line for each (name, depths, errors), mm, with its name at its end."""
    ax = ax or plt.gca()
    for (name, depth_mm, error_mm), (color, dash) in zip(
        curves, ((VERMILION, "--"), (BLUE, "-"), (GREEN, "-.")), strict=False
    ):
        ax.plot(depth_mm, error_mm, dash, color=color, linewidth=2)
        at = 4 * len(depth_mm) // 5
        ax.annotate(name, (depth_mm[at], error_mm[at]), xytext=(6, -2), textcoords="offset points", color=color,
                    ha="left", va="top", weight="bold")  # fmt: skip
    ax.set_xlabel("depth (mm)")
    ax.set_ylabel("error of depth, 1 σ (mm)")
    ax.set_ylim(bottom=0)
    ax.margins(y=0.12)
    ax.set_title(title)
    return ax

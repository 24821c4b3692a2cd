"""Things in space, seen from any side."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.ticker import MaxNLocator
from numpy.typing import ArrayLike

from stereo_lab.plots.base import BLUE

__all__ = ["Thing", "camera_at", "space"]


@dataclass(frozen=True, eq=False)
class Thing:
    """A line through some points of the room, or dots at them.

    Attributes
    ----------
    name : str, for the legend; empty for none
    points_mm : array_like, shape (N, 3): x to the right, y up, depth away from the cameras
    color : str
    style : "-", "--" or ":" for a line, "o", "s" or "+" for dots
    """

    name: str
    points_mm: ArrayLike
    color: str
    style: str = "-"


def camera_at(
    name: str,
    lens_mm: ArrayLike,
    turn_3x3: ArrayLike,
    half_view: tuple[float, float],
    long_mm: float,
    color: str = BLUE,
) -> Thing:
    """A camera as a pyramid: its tip is the lens, its base what the camera sees at a short distance.

    Parameters
    ----------
    lens_mm : where the lens is, shape (3,)
    turn_3x3 : its columns are the camera's right, up and ahead
    half_view : half of the picture's width and height, divided by the focal length
    long_mm : how far ahead the base is drawn
    """
    lens, turn = np.asarray(lens_mm, float), np.asarray(turn_3x3, float)
    across, up = half_view
    base = [lens + long_mm * turn @ [i * across, j * up, 1] for i, j in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    a, b, c, d = base
    return Thing(name, [lens, a, b, lens, c, d, lens, a, d, c, b], color)


def space(things: Sequence[Thing], title: str, ax: Any = None, turned_deg: float = -60, raised_deg: float = 20) -> Any:
    """Things in space, each axis to the same scale.

    Parameters
    ----------
    ax : Axes3D
    turned_deg, raised_deg : from where one looks: round the upright axis, from -90 behind the cameras, and how far from above
    """
    ax = ax or plt.gca()
    for thing in things:
        x, y, depth = np.asarray(thing.points_mm, float).T
        if thing.style in ("-", "--", ":"):
            ax.plot(x, depth, y, thing.style, color=thing.color, linewidth=1.8, label=thing.name or None)
        else:
            ax.plot(x, depth, y, thing.style, color=thing.color, markersize=8, label=thing.name or None)
    every = np.concatenate([np.asarray(thing.points_mm, float) for thing in things])[:, [0, 2, 1]]
    middle, span = (every.max(0) + every.min(0)) / 2, 1.1 * np.ptp(every, axis=0)
    span = np.maximum(span, 0.25 * span.max())
    for number, name in enumerate(("x (mm)", "depth (mm)", "y (mm)")):
        axis = (ax.xaxis, ax.yaxis, ax.zaxis)[number]
        axis.set_label_text(name)
        axis.labelpad = 17
        axis.set_major_locator(MaxNLocator(max(2, round(6 * span[number] / span.max()))))
    low, high = middle - span / 2, middle + span / 2
    ax.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
    ax.set_box_aspect(span, zoom=0.97)  # each axis to the same scale
    ax.view_init(raised_deg, turned_deg)
    ax.set_title(title)
    if raised_deg > 80:  # from straight above, y is a point, and the other two axes lie beside their numbers
        ax.set(zticks=[], zlabel="")
        ax.tick_params(pad=8)
    if any(thing.name for thing in things):
        ax.legend(loc="upper left", bbox_to_anchor=(1.05, 1))
    return ax

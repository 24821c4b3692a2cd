"""The figures of lesson 08: how a fault in a recording was seen."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

from stereo_lab.plots.base import BLUE, VERMILION, Numbers

MOST_NAMES = 30  # under an axis, that can still be read


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
    ax.set_xticks(range(0, len(names), step), [name for name in names[::step]], rotation=90, fontsize=9)
    ax.set_ylabel(what)
    ax.set_title(title)
    ax.margins(x=0.01)
    if marked:
        ax.legend()
    return ax


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

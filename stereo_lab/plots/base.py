"""Every figure. Plot functions take ``ax``, return ``ax``, and compute nothing.

Colours are those of Okabe and Ito; marker and dash tell the same story to whoever sees no colour.
"""

from __future__ import annotations

import io
from collections.abc import Callable, Sequence
from functools import wraps
from typing import Any, TypeVar

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

BLUE, ORANGE, GREEN, VERMILION, BLACK = "#0072B2", "#E69F00", "#009E73", "#D55E00", "#000000"
AMBER = "#9A6700"  # for lines and words on white, where orange is too pale: 4.9 to 1 in place of 2.3
STYLE: dict[Any, Any] = {"font.size": 12, "axes.titlesize": 13, "axes.grid": True, "grid.alpha": 0.3, "figure.dpi": 100}
TEXT: dict[Any, Any] = {name: STYLE[name] for name in ("font.size", "axes.titlesize")}
Numbers = Sequence[float] | np.ndarray  # where they are counted or taken one by one

Plot = TypeVar("Plot", bound=Callable[..., Any])


def figure(rows: int = 1, columns: int = 1, height: float = 4.5, width: float = 11.0) -> tuple[Figure, np.ndarray]:
    """A figure in the kit's style; returns figure and axes."""
    plt.draw_if_interactive()  # loads Jupyter's backend first: inside rc_context its settings would be undone
    with plt.rc_context(STYLE):
        return plt.subplots(rows, columns, figsize=(width, height), layout="constrained", squeeze=False)


def with_text_in_style(draw: Plot) -> Plot:
    """The plot function with text of the kit's size in all that comes after its axes: names, legends, scales."""

    @wraps(draw)
    def drawn(*arguments: Any, **named: Any) -> Any:
        plt.draw_if_interactive()  # as in figure
        with plt.rc_context(TEXT):
            return draw(*arguments, **named)

    return drawn  # type: ignore[return-value]


def png(fig: Figure) -> bytes:
    """A finished figure as the bytes of a PNG file; the figure is closed."""
    data = io.BytesIO()
    fig.savefig(data, format="png")
    plt.close(fig)
    return data.getvalue()


def show_image(image: np.ndarray, title: str, ax: Axes | None = None) -> Axes:
    """A BGR picture with its own shape."""
    ax = ax or plt.gca()
    ax.imshow(image[..., ::-1], interpolation="nearest")
    ax.set_title(title)
    ax.set_xticks([])
    ax.set_yticks([])
    ax.grid(False)
    return ax


def side_by_side(left: np.ndarray, right: np.ndarray, rows_px: Numbers, title: str, ax: Axes | None = None) -> Axes:
    """Two pictures next to each other with lines at the same rows through both."""
    ax = show_image(np.hstack([left, right]), title, ax)
    for k, row in enumerate(rows_px):
        ax.axhline(row, color=(ORANGE, BLUE)[k % 2], linestyle=("-", "--")[k % 2], linewidth=1.4)
    return ax


def mark_ball(u: float, v: float, radius_px: float, ax: Axes | None = None, color: str = BLUE, name: str = "") -> Axes:
    """A circle round a ball, a cross a third as wide in it, and its name above it."""
    ax = ax or plt.gca()
    ax.autoscale(False)
    ax.add_patch(plt.Circle((u, v), radius_px, fill=False, color=color, linewidth=2))
    third = radius_px / 3  # in pixels of the picture, so that it does not cover a ball that is small there
    ax.plot([u - third, u + third], [v, v], color=color, linewidth=1.5)
    ax.plot([u, u], [v - third, v + third], color=color, linewidth=1.5)
    box = {"facecolor": "white", "edgecolor": color, "pad": 2}
    if name:
        ax.annotate(name, (u, v - radius_px - 6), ha="center", va="bottom", color=color, weight="bold", bbox=box)
    return ax


def line_fit(
    pixels: Numbers,
    lengths_mm: ArrayLike,
    check_pixels: Numbers,
    check_mm: ArrayLike,
    line: Any,
    names: tuple[str, str],
    title: str,
    ax: Axes | None = None,
) -> Axes:
    """Samples, check samples and the straight line through them; names are the axis labels."""
    ax = ax or plt.gca()
    span = np.array([min(*pixels, *check_pixels), max(*pixels, *check_pixels)])
    ax.plot(span, line.predict(span), "-", color=BLACK, linewidth=1.5, label="fitted line")
    ax.plot(pixels, lengths_mm, "o", color=BLUE, markersize=9, label="samples to fit")
    ax.plot(check_pixels, check_mm, "s", color=VERMILION, markersize=8, label="samples to check")
    ax.set_xlabel(names[0])
    ax.set_ylabel(names[1])
    ax.set_title(title)
    ax.legend()
    return ax


def scatter_errors(
    x_mm: np.ndarray,
    y_mm: np.ndarray,
    limit_mm: float,
    title: str,
    ax: Axes | None = None,
    color: str = BLUE,
    marker: str = "o",
) -> Axes:
    """Errors in x and y round zero, with the paper's ±1 cm as a box."""
    ax = ax or plt.gca()
    ax.plot(x_mm, y_mm, marker, color=color, markersize=7, alpha=0.8)
    box = plt.Rectangle((-limit_mm, -limit_mm), 2 * limit_mm, 2 * limit_mm, fill=False, color=BLACK, linestyle="--")
    ax.add_patch(box)
    reach = 1.2 * max(limit_mm, *np.abs(x_mm), *np.abs(y_mm))
    ax.set_xlim(-reach, reach)
    ax.set_ylim(-reach, reach)
    ax.set_aspect("equal")
    ax.set_xlabel("error in x (mm)")
    ax.set_ylabel("error in y (mm)")
    ax.set_title(title)
    return ax


def histogram_errors(
    errors_mm: ArrayLike, title: str, ax: Axes | None = None, color: str = BLUE, hatch: str = ""
) -> Axes:
    """How often each depth error occurs, with its mean size as a dashed line."""
    ax = ax or plt.gca()
    size = np.abs(errors_mm)
    ax.hist(size, bins=12, color=color, edgecolor="white", hatch=hatch)
    ax.margins(y=0.2)  # room for the label
    ax.locator_params(axis="y", integer=True)
    ax.axvline(size.mean(), color=BLACK, linestyle="--")
    ax.annotate(f" mean {size.mean():.1f} mm", (size.mean(), 0.92), xycoords=("data", "axes fraction"))
    ax.set_xlabel("size of the depth error (mm)")
    ax.set_ylabel("number of pairs")
    ax.set_title(title)
    return ax

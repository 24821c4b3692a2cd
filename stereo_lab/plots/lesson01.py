"""Figures of lesson 01."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm

from stereo_lab.plots.base import BLACK, BLUE, GREEN, ORANGE, VERMILION, Numbers, with_text_in_style

__all__ = ["depth_doubt", "error_by_pair", "grids", "how_many_pairs", "mark_corners"]


@with_text_in_style
def grids(
    straight: Sequence[np.ndarray],
    bent: Sequence[np.ndarray],
    image_size: tuple[int, int],
    title: str,
    ax: Axes | None = None,
) -> Axes:
    """Two grids, lists of lines (N, 2) in px: as a pinhole would see it, and as the lens shows it."""
    ax = ax or plt.gca()
    for k, line in enumerate(straight):
        ax.plot(*line.T, "--", color=BLACK, linewidth=1, label="pinhole" if k == 0 else None)
    for k, line in enumerate(bent):
        ax.plot(*line.T, "-", color=VERMILION, linewidth=2, label="through this lens" if k == 0 else None)
    ax.set_xlim(-20, image_size[0] + 20)
    ax.set_ylim(image_size[1] + 20, -20)
    ax.set_aspect("equal")
    ax.set_xlabel("u (px)")
    ax.set_ylabel("v (px)")
    ax.set_title(title)
    ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.12), ncols=2)
    return ax


@with_text_in_style
def mark_corners(corners_Nx2: np.ndarray, columns: int, ax: Axes | None = None) -> Axes:
    """Dots on the corners of a board, a line along each row, the first corner larger."""
    ax = ax or plt.gca()
    for start in range(0, len(corners_Nx2), columns):
        row = corners_Nx2[start : start + columns]
        ax.plot(*row.T, "-o", color=ORANGE, markersize=5, markeredgecolor=BLACK, linewidth=1.2)
    ax.plot(*corners_Nx2[0], "s", color=BLUE, markersize=10, markeredgecolor="white")
    return ax


@with_text_in_style
def error_by_pair(
    names: Sequence[str],
    errors_px: Numbers,
    typical_px: float,
    dropped: Collection[str],
    title: str,
    ax: Axes | None = None,
) -> Axes:
    """Reprojection error of every pair as a bar; dropped pairs hatched."""
    ax = ax or plt.gca()
    for out, color, hatch in ((False, BLUE, ""), (True, VERMILION, "//")):
        of = [k for k, name in enumerate(names) if (name in dropped) == out]
        if of:
            errors = [errors_px[k] for k in of]
            ax.bar(of, errors, color=color, hatch=hatch, edgecolor="white", label="left out" if out else "in the fit")
    if dropped:
        ax.legend(loc="upper left")
    ax.axhline(typical_px, color=BLACK, linestyle="--")
    ax.annotate(
        "median",
        (1, typical_px),
        (4, 0),
        ("axes fraction", "data"),
        "offset points",
        annotation_clip=False,
        va="center",
    )
    ax.set_xticks(range(len(names)), names, rotation=90)
    ax.set_xlabel("pair")
    ax.set_ylabel("reprojection error (px)")
    ax.set_title(title)
    return ax


@with_text_in_style
def how_many_pairs(counts: Numbers, used_px: Numbers, unseen_px: Numbers, title: str, ax: Axes | None = None) -> Axes:
    """Error on the pairs of the fit and on unseen ones, against the number of pairs."""
    ax = ax or plt.gca()
    ax.plot(counts, unseen_px, "-s", color=VERMILION, markersize=8)
    ax.plot(counts, used_px, "--o", color=GREEN, markersize=8)
    unseen_above = unseen_px[-1] >= used_px[-1]
    for text, px, color, above in (
        ("rows on unseen pairs", unseen_px, VERMILION, unseen_above),
        ("rows on the pairs of the fit", used_px, GREEN, not unseen_above),
    ):
        ax.annotate(
            text,
            (counts[-1], px[-1]),
            xytext=(-6, 16 if above else -20),
            textcoords="offset points",
            ha="right",
            color=color,
            weight="bold",
        )
    ax.set_ylim(bottom=0)
    ax.set_xlabel("pairs in the fit")
    ax.set_ylabel("error (px)")
    ax.set_title(title)
    return ax


@with_text_in_style
def depth_doubt(
    pixels_Nx2: np.ndarray,
    sigma_mm_N: np.ndarray,
    boards_N: np.ndarray,
    outlines: np.ndarray,
    image_size: tuple[int, int],
    title: str,
    ax: Axes | None = None,
) -> Axes:
    """How uncertain depth is over the left picture, with the boards' outlines; dots where no board was seen.

    Parameters
    ----------
    pixels_Nx2 : ndarray, places in the left picture, px
    sigma_mm_N : ndarray, standard deviation of depth there, mm
    boards_N : ndarray of int, how many boards covered each place
    outlines : ndarray, shape (boards, 4, 2), px
    image_size : (width, height), px
    """
    ax = ax or plt.gca()
    levels = np.geomspace(0.99 * sigma_mm_N.min(), 1.01 * sigma_mm_N.max(), 9)  # even steps would show the rim alone
    filled = ax.tricontourf(
        pixels_Nx2[:, 0], pixels_Nx2[:, 1], sigma_mm_N, levels=levels, norm=LogNorm(), cmap="cividis"
    )
    bar = ax.figure.colorbar(filled, ax=ax, shrink=0.9, ticks=levels, format="%.2g")
    bar.minorticks_off()
    bar.set_label("sigma of depth (mm)")
    for outline in outlines:
        ax.plot(*np.vstack([outline, outline[:1]]).T, color="white", linewidth=0.8, alpha=0.7)
    bare = pixels_Nx2[boards_N == 0]
    ax.plot(*bare.T, "o", color="white", markeredgecolor=BLACK, markersize=4, label="here no board was seen")
    ax.set_xlim(0, image_size[0])
    ax.set_ylim(image_size[1], 0)
    ax.set_aspect("equal")
    ax.grid(False)
    ax.set_xlabel("u (px)")
    ax.set_ylabel("v (px)")
    ax.set_title(title)
    if len(bare):
        ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.12))
    return ax

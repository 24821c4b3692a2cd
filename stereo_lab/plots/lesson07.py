"""Figures of lesson 07: the whole cell, what it costs, and what its log tells."""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from numpy.typing import ArrayLike

from stereo_lab.common.files import write_whole
from stereo_lab.errors import StereoLabError
from stereo_lab.plots.base import AMBER, BLACK, BLUE, GREEN, ORANGE, VERMILION, figure

if TYPE_CHECKING:
    from stereo_lab.live.log import Run

__all__ = ["certainty", "milliseconds", "over_time", "pose_at_ball", "run_page", "usage"]

PAPERS_CPU, PAPERS_RSS_MB = 23.37, 155.71  # means over 653 samples
STYLES = ((BLUE, "-"), (VERMILION, "--"), (GREEN, "-."), (AMBER, ":"))


def pose_at_ball(
    joints_mm: np.ndarray,
    ball_mm: Sequence[float],
    radius_mm: float,
    angles_deg: Sequence[float],
    title: str,
    ax: Axes | None = None,
) -> Axes:
    """The arm in its plane with its hand before the ball.

    Parameters
    ----------
    joints_mm : ndarray, shape (3, 2), shoulder, elbow, hand
    ball_mm : (x, y)
    """  # fmt: skip
    ax = ax or plt.gca()
    ax.plot(*joints_mm[:2].T, "-", color=BLUE, linewidth=8, solid_capstyle="round")
    ax.plot(*joints_mm[1:].T, "-", color=VERMILION, linewidth=8, solid_capstyle="round")
    ax.plot(*joints_mm.T, "o", color="white", markeredgecolor=BLACK, markersize=9)
    ax.add_patch(plt.Circle((ball_mm[0], ball_mm[1]), radius_mm, color=ORANGE))
    ax.annotate(f"θ1 = {angles_deg[0]:.0f}°", joints_mm[0], (14, -4), textcoords="offset points", va="top")
    ax.annotate(
        f"θ2 = {angles_deg[1]:.0f}°",
        joints_mm[1],
        (0, -12),
        textcoords="offset points",
        ha="right" if joints_mm[1][0] > 0 else "left",
        va="top",
    )
    reach = 1.15 * max(np.abs(joints_mm).max(), *np.abs(ball_mm))
    ax.set_xlim(-reach, reach)
    ax.set_ylim(-0.35 * reach, reach)
    ax.set_aspect("equal")
    ax.set_xlabel("x (mm)")
    ax.set_ylabel("y (mm)")
    ax.set_title(title)
    return ax


def over_time(
    curves: Sequence[tuple[str, ArrayLike, ArrayLike]], name: str, title: str, ax: Axes | None = None
) -> Axes:
    """Some values over time, each line named in the legend.

    Parameters
    ----------
    curves : list of (label, seconds, values)
    name : str, of the upright axis, with its unit
    """
    ax = ax or plt.gca()
    for (color, dash), (label, time_s, values) in zip(STYLES, curves, strict=False):
        ax.plot(time_s, values, dash, color=color, linewidth=2, label=label)
    ax.set_ylim(bottom=0)
    ax.set_xlabel("time (s)")
    ax.set_ylabel(name)
    ax.set_title(title)
    ax.legend()
    return ax


def certainty(
    time_s: np.ndarray,
    place_mm: np.ndarray,
    sigma_mm: np.ndarray,
    seen: np.ndarray,
    name: str,
    title: str,
    ax: Axes | None = None,
) -> Axes:
    """One coordinate of a ball that is followed, with the band in which it is 19 times of 20.

    Parameters
    ----------
    time_s, place_mm, sigma_mm : ndarray, shape (N,); sigma: standard deviation
    seen : ndarray of bool, shape (N,)
    name : str, of the coordinate, with its unit
    """
    ax = ax or plt.gca()
    low, high = place_mm - 2 * sigma_mm, place_mm + 2 * sigma_mm
    ax.fill_between(time_s, low, high, color=BLUE, alpha=0.25, label="± 2 standard deviations")
    ax.plot(time_s[seen], place_mm[seen], "o", color=BLUE, markersize=6, label="seen")
    ax.plot(time_s[~seen], place_mm[~seen], "x", color=VERMILION, markersize=8, markeredgewidth=2, label="predicted")
    ax.set_xlabel("time (s)")
    ax.set_ylabel(name)
    ax.set_title(title)
    ax.legend(loc="upper left")
    return ax


def milliseconds(stages: Mapping[str, float], title: str, ax: Axes | None = None) -> Axes:
    """What each stage takes, as bars one after the other.

    Parameters
    ----------
    stages : dict, name -> ms, in their order
    """
    ax = ax or plt.gca()
    start = 0.0
    for k, ms in enumerate(stages.values()):
        ax.barh(k, ms, left=start, color=STYLES[k % 4][0], height=0.6)
        ax.annotate(
            f"{ms:.0f} ms" if ms >= 1 else "under 1 ms",
            (start + ms, k),
            (6, 0),
            textcoords="offset points",
            va="center",
        )
        start += ms
    ax.set_yticks(range(len(stages)), list(stages))
    ax.invert_yaxis()
    ax.set_xlim(0, 1.15 * start)
    ax.set_xlabel("milliseconds since the light fell into the cameras")
    ax.set_title(title)
    return ax


def usage(values: ArrayLike, paper_mean: float, name: str, title: str, ax: Axes | None = None) -> Axes:
    """CPU or memory of a run, sample by sample, with the paper's mean.

    Parameters
    ----------
    values : array, shape (N,)
    paper_mean : float, in the same unit
    """
    ax = ax or plt.gca()
    ax.plot(values, "-", color=BLUE, linewidth=2, label="here")
    ax.axhline(paper_mean, color=VERMILION, linestyle="--", linewidth=2, label=f"the paper's mean, {paper_mean:.0f}")
    ax.set_ylim(0, 1.15 * max(paper_mean, np.nanmax(values, initial=0.0)))
    ax.set_xlabel("sample")
    ax.set_ylabel(name)
    ax.set_title(title)
    ax.legend()
    return ax


def run_page(run: Run, path: str | Path) -> None:
    """Draw the log of a run into a file: where the ball was, the joints, the times, CPU and memory.

    Raises
    ------
    StereoLabError
        If the log has no pictures, or the file cannot be written or its ending not be used.
    """
    if not run.records:
        raise StereoLabError("There is nothing to draw: the log has a header and no pictures.")
    fig, axes = figure(3, 2, height=10.5, width=12)
    time_s = run.column("time_s")
    groups = (
        ("place of the ball (mm)", ("x_mm", "y_mm", "depth_mm")),
        ("angles of the joints (degrees)", ("wanted1_deg", "reached1_deg", "wanted2_deg", "reached2_deg")),
        ("milliseconds", ("latency_ms", "find_ms", "steer_ms")),
        ("pairs a second", ("rate_hz",)),
    )
    for ax, (name, columns) in zip(axes.flat, groups, strict=False):
        for (color, dash), column in zip(STYLES, columns, strict=False):
            ax.plot(time_s, run.column(column), dash, color=color, label=column.rsplit("_", 1)[0])
        ax.set_xlabel("time (s)")
        ax.set_ylabel(name)
        ax.legend() if len(columns) > 1 else ax.set_ylim(bottom=0)
    usage(run.column("cpu_percent"), PAPERS_CPU, "CPU (percent of one core)", "", axes[2, 0])
    usage(run.column("rss_mb"), PAPERS_RSS_MB, "memory (MB)", "", axes[2, 1])
    fig.suptitle(f"{run.head.get('source')}, arm {run.head.get('arm') or 'none'}, {run.head.get('started')}")
    drawn = io.BytesIO()
    try:
        fig.savefig(drawn, format=Path(path).suffix[1:].lower() or None)
    except ValueError:
        raise StereoLabError(f"{path} cannot be drawn to: name a file that ends in .png, .svg or .pdf.") from None
    finally:
        plt.close(fig)
    write_whole(path, drawn.getvalue())

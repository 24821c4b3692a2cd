"""The paper's figures 2, 4, 5, 8 and 9, drawn from one run of the whole chain."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import cv2
import numpy as np

from stereo_lab import plots
from stereo_lab.detection import BLUR_PX, BallColor, detect_paper
from stereo_lab.results.evaluation import Results

PAPER_PLANE_MM = 10.0  # the paper's Fig. 8: x and y within ±1 cm


class Figure(NamedTuple):
    """A figure of the report.

    Attributes
    ----------
    draw : function(results) -> the figure
    sets, methods : set of str, the sets of pictures it needs, and the fitted methods
    judged : str, the kind of samples it shows: "plane", "volume" or "" for none
    caption : str
    """

    draw: Callable[[Results], plots.Figure]
    sets: set[str]
    methods: set[str]
    judged: str
    caption: str

    def fits(self, results: Results) -> bool:
        """Whether a run has what the figure needs."""
        there = self.sets <= set(results.recording.sets) and self.methods <= set(results.localizers)
        return there and all(len(results.errors(m, self.judged)[0]) or not self.judged for m in self.methods)


def draw_epipolar(results: Results) -> plots.Figure:
    """Fig. 2: rows before and after rectification."""
    pair = next(p for p in results.recording.pairs("calibration") if p.name in results.calibration.used)
    raw = (pair.left, pair.right)
    rows_px = np.linspace(0.1, 0.9, 7) * raw[0].shape[0]
    fig, axes = plots.figure(2, 1, height=8.4)
    plots.side_by_side(*raw, rows_px, "Raw: the same corner lies on different rows", axes[0, 0])
    plots.side_by_side(*results.calibration.rectify(*raw), rows_px, "Rectified: every corner keeps its row", axes[1, 0])
    return fig


def draw_detection(results: Results) -> plots.Figure:
    """Fig. 4: from the picture to the circle."""
    image = results.recording.samples("position")[0].pair.left
    color = BallColor.named(results.recording.ball.color)
    mask = color.mask(image)
    found = detect_paper(image, color)
    cone = results.localizers["cone"].way.detectors[0].detect(image)  # type: ignore[union-attr]  # a ConeWay
    fig, axes = plots.figure(1, 3, height=3.6, width=12)
    plots.show_image(cv2.cvtColor(mask, cv2.COLOR_GRAY2BGR), "In the colour range", axes[0, 0])
    blurred = cv2.GaussianBlur(mask, (BLUR_PX, BLUR_PX), 0)
    plots.show_image(cv2.cvtColor(blurred, cv2.COLOR_GRAY2BGR), "Blurred", axes[0, 1])
    plots.show_image(image, "Hough circle (dark), cone (light)", axes[0, 2])
    for detection, shade in ((found, plots.BLACK), (cone, plots.ORANGE)):
        if detection is not None:
            plots.mark_ball(detection.u, detection.v, detection.radius_px, axes[0, 2], shade)
    return fig


def draw_lines(results: Results) -> plots.Figure:
    """Fig. 5: the two straight lines of Eq. 1 and 2."""
    localizer = results.localizers["paper"]
    seen: dict[str, list] = {"fit": [], "check": []}
    for sample in results.recording.samples("position"):
        pair = localizer.detect(sample.pair.left, sample.pair.right)
        if pair is not None and sample.use in seen:
            (u, v), _ = results.calibration.rectify_centers(*pair)
            seen[sample.use].append((u, v, sample.measured.x_mm, sample.measured.y_mm))
    fit, check = (np.array(seen[k] or [[np.nan] * 4]) for k in ("fit", "check"))
    lines = localizer.way.x_line, localizer.way.y_line  # type: ignore[union-attr]  # a PaperWay
    fig, axes = plots.figure(1, 2, height=4.6)
    for k, (pixel, length) in enumerate((("u (px, rectified)", "x (mm)"), ("v (px, rectified)", "y (mm)"))):
        title = f"{length[0]} is a straight line in {pixel[0]}"
        plots.line_fit(
            fit[:, k],
            fit[:, 2 + k],
            check[:, k],
            check[:, 2 + k],
            lines[k],
            (pixel, length),
            title,
            axes[0, k],
        )
    return fig


def draw_scatter(results: Results) -> plots.Figure:
    """Fig. 8: errors in the arm's plane."""
    fig, axes = plots.figure(1, 2, height=5.2)
    for k, (method, name) in enumerate((("paper", "Two lines"), ("cone", "Rigid fit"))):
        errors, _ = results.errors(method, "plane")
        inside = (np.abs(errors[:, :2]) <= PAPER_PLANE_MM).all(1).sum()
        title = f"{name}: {inside} of {len(errors)} within ±1 cm"
        plots.scatter_errors(
            errors[:, 0],
            errors[:, 1],
            PAPER_PLANE_MM,
            title,
            axes[0, k],
            (plots.VERMILION, plots.BLUE)[k],
            "s" if k == 0 else "o",
        )
    return fig


def draw_histogram(results: Results) -> plots.Figure:
    """Fig. 9: how large the depth error is, up to the far end of the volume."""
    fig, axes = plots.figure(1, 2, height=4.4)
    for k, (method, name) in enumerate((("paper", "Eq. 4"), ("cone", "Cone and triangulation"))):
        errors, _ = results.errors(method, "volume")
        title = f"{name}: {np.abs(errors[:, 2]).mean():.1f} mm on average"
        plots.histogram_errors(errors[:, 2], title, axes[0, k], (plots.VERMILION, plots.BLUE)[k], ("//", "")[k])
    return fig


FIGURES = (
    Figure(
        draw_epipolar, {"calibration"}, set(), "",
        "The paper's Fig. 2: a pair of the board with level lines. Raw, a corner sits on another row in each camera; "
        "rectified, on the same.",
    ),
    Figure(
        draw_detection, {"position"}, {"cone"}, "",
        "The paper's Fig. 4: pixels in the colour range are white; blurred; and the circles found in the picture.",
    ),
    Figure(
        draw_lines, {"position"}, {"paper"}, "",
        "The paper's Fig. 5: measured x against pixel column and y against pixel row, four samples to fit and four to "
        "check.",
    ),
    Figure(
        draw_scatter, set(), {"paper", "cone"}, "plane",
        "The paper's Fig. 8: errors in x and y in the plane of the arm; the dashed box is ±1 cm.",
    ),
    Figure(
        draw_histogram, set(), {"paper", "cone"}, "volume",
        "The paper's Fig. 9: how many pairs have which depth error; the dashed line is the mean.",
    ),
)  # fmt: skip

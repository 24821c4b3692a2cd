"""Panels of lesson 04."""

from __future__ import annotations

import cv2
import ipywidgets
import numpy as np
from matplotlib.ticker import MaxNLocator
from numpy.typing import ArrayLike

from stereo_lab.depth import OffsetDepth, PaperDepth
from stereo_lab.errors import StereoLabError
from stereo_lab.widgets.panel import BLACK, BLUE, GREY, ORANGE, PANEL_WIDTH, VERMILION, Panel, slider, wide, write


def ball_against_disparity(baseline_mm: float, focal_px: float, diameter_mm: float) -> Panel:
    """A ball before two cameras, from above: move it, and see its two pictures part."""
    for name, value in (("baseline_mm", baseline_mm), ("focal_px", focal_px), ("diameter_mm", diameter_mm)):
        if not (np.isfinite(value) and value > 0):
            raise StereoLabError(f"Expected {name} to be above zero; got {value}.")

    def draw(depth_mm):
        disparity = baseline_mm * focal_px / depth_mm
        view = np.full((340, PANEL_WIDTH, 3), 255, np.uint8)
        across = 0.3 * 340 / max(baseline_mm, 1) * min(1.0, baseline_mm / 60)  # px per mm, upwards

        def place(depth, x):
            return round(80 + depth * 800 / 2600), round(170 - (x - baseline_mm / 2) * across)

        ball = place(depth_mm, baseline_mm / 2)
        for x, color, name in ((0.0, BLUE, "left"), (baseline_mm, VERMILION, "right")):
            x = baseline_mm - x
            camera = place(0, x)
            cv2.line(view, camera, ball, color, 2, cv2.LINE_AA)
            cv2.circle(view, camera, 9, color, -1, cv2.LINE_AA)
            write(view, name, (camera[0] - 16 - wide(name), camera[1] + 6))
        cv2.circle(view, ball, max(5, round(diameter_mm / 2 * 800 / 2600)), ORANGE, -1, cv2.LINE_AA)
        _bar(view, disparity, baseline_mm * focal_px / 400)
        return (
            view,
            f"depth {depth_mm} mm, disparity {disparity:.1f} px; depth times disparity {depth_mm * disparity:.0f} mm px",
        )

    return Panel("ball against disparity", {"depth_mm": slider("depth (mm)", 1000, 400, 2500, 10)}, draw)


def depth_samples(disparity_px_N: ArrayLike, depth_mm_N: ArrayLike) -> Panel:
    """Choose the samples of the depth fit, of which the first three are chosen, and watch the curves of Eq. 4 and of a/(d − d0) + c."""
    d, depth = np.asarray(disparity_px_N, float), np.asarray(depth_mm_N, float)
    if d.shape != depth.shape or d.ndim != 1 or len(d) < 3:
        raise StereoLabError(f"Expected as many disparities as depths, three or more; got {d.shape} and {depth.shape}.")
    controls = {
        f"sample_{k}": ipywidgets.Checkbox(k < 3, description=f"{depth[k]:.0f} mm at {d[k]:.1f} px", indent=False)
        for k in range(len(d))
    }

    def draw(**values):
        chosen = np.array(list(values.values()))
        view, to_px = _axes(d, depth)
        for k in range(len(d)):
            center = to_px(d[k], depth[k])
            cv2.circle(view, center, 8, BLACK, -1 if chosen[k] else 2, cv2.LINE_AA)
        if chosen.sum() < 3:
            return view, "Eq. 4 has three unknown numbers: choose three samples or more."
        span, said = np.linspace(0.9 * d.min(), 1.1 * d.max(), 120), []
        for model, color, name in ((PaperDepth, BLUE, "Eq. 4"), (OffsetDepth, VERMILION, "a/(d-d0)+c")):
            try:
                fit = model.fit(d[chosen], depth[chosen])
            except StereoLabError:  # another thing's disparity among the samples, or one twice
                said.append(f"{name}: no such curve comes near the chosen samples")
                continue
            told = fit.predict(span)
            ahead = np.isfinite(told)  # at d0 and below it tells nothing
            line = np.array([to_px(a, b) for a, b in zip(span[ahead], told[ahead], strict=True)])
            dashed = (
                line[len(line) % 2 :].reshape(-1, 2, 2) if model is OffsetDepth else np.stack([line[:-1], line[1:]], 1)
            )
            cv2.polylines(view, list(np.clip(dashed, -5000, 5000)), False, color, 2, cv2.LINE_AA)
            rest = np.abs(fit.predict(d[~chosen]) - depth[~chosen])
            said.append(f"{name}: {rest.mean():.0f} mm off" if len(rest) else f"{name}: nothing left to check")
        return view, "On the samples not chosen, " + "; ".join(said) + ". Solid blue: Eq. 4; dashed red: a/(d-d0)+c."

    return Panel("depth samples", controls, draw)


def signs_against_squint(baseline_mm: float, focal_px: float, depth_mm_N: ArrayLike) -> Panel:
    """Let perfect cameras squint by some pixels, and watch what Eq. 4 through exact samples makes of it."""
    depth = np.asarray(depth_mm_N, float)
    true_px = baseline_mm * focal_px / depth
    most = min(60, int(8 * true_px.min()))  # tenths of a px; a disparity stays above zero
    far = [PaperDepth.fit(true_px + squint / 10, depth) for squint in (-most, most)]
    largest = {name: max(abs(getattr(fit, name)) for fit in far) for name in "mnc"}

    def draw(squint):
        fit = PaperDepth.fit(true_px + squint / 10, depth)
        view = np.full((190, PANEL_WIDTH, 3), 255, np.uint8)
        cv2.line(view, (500, 15), (500, 175), BLACK, 1)
        for k, (name, digits, unit) in enumerate((("m", 0, "mm px"), ("n", 2, "mm/px"), ("c", 0, "mm"))):
            value, y = getattr(fit, name), 45 + 50 * k
            color = BLUE if value > 0 else VERMILION
            cv2.rectangle(view, (500, y - 14), (500 + round(330 * value / largest[name]), y + 14), color, -1)
            write(view, f"{name} = {value:.{digits}f} {unit}", (20, y + 6))
        signs = ", ".join(f"{name} {'above' if getattr(fit, name) > 0 else 'not above'} zero" for name in "mnc")
        return view, f"every disparity {squint / 10:+.1f} px: {signs}."

    return Panel("signs against squint", {"squint": slider("squint (tenths of a px)", 10, -most, most)}, draw)


def _bar(view, disparity, largest):
    """The disparity as a bar at the bottom."""
    length = round(700 * disparity / largest)
    cv2.rectangle(view, (200, 305), (900, 325), GREY, 1)
    cv2.rectangle(view, (200, 305), (200 + length, 325), ORANGE, -1)
    write(view, "disparity", (190 - wide("disparity"), 321))


def _axes(d, depth):
    """An empty chart with ticks, and the function from (disparity, depth) to its pixels."""
    view = np.full((420, PANEL_WIDTH, 3), 255, np.uint8)
    low, high, top = 0.85 * d.min(), 1.12 * d.max(), 1.15 * depth.max()

    def to_px(x, y):
        return round(90 + (x - low) / (high - low) * 830), round(356 - float(y) / top * 326)

    for x in _ticks(low, high):
        write(view, f"{x:.0f}", (to_px(x, 0)[0] - wide(f"{x:.0f}") // 2, 382))
    for y in _ticks(0, top):
        cv2.line(view, to_px(low, y), to_px(high, y), GREY, 1)
        write(view, f"{y:.0f}", (80 - wide(f"{y:.0f}"), to_px(low, y)[1] + 6))
    write(view, "disparity (px)", (440, 411))
    write(view, "depth (mm)", (96, 20))
    return view, to_px


def _ticks(low, high):
    """Round numbers between two."""
    values = MaxNLocator(6).tick_values(low, high)
    return values[(values >= low) & (values <= high)]

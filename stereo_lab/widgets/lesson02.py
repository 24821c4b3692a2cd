"""Panels of lesson 02."""

from __future__ import annotations

import cv2
import numpy as np

from stereo_lab.detection import BallColor, check_image
from stereo_lab.detection.color import LAST_HUE
from stereo_lab.widgets.panel import BLUE, ORANGE, PANEL_WIDTH, Panel, fit_width, range_slider, slider


def color_thresholds(image: np.ndarray, color: str) -> Panel:
    """Bounds on hue, lightness and saturation, and the mask that they make.

    Parameters
    ----------
    image : ndarray, BGR
    color : str, a named colour: where the sliders start

    Returns
    -------
    Panel; where the lower hue is above the upper one, the range wraps round 0
    """
    small = fit_width(check_image(image), PANEL_WIDTH // 2)
    hls = cv2.cvtColor(small, cv2.COLOR_BGR2HLS)
    ranges = BallColor.named(color).ranges
    (low, high) = (ranges[0][0], ranges[-1][1])

    def draw(hue_low, hue_high, lightness, saturation):
        spans = [(hue_low, hue_high)] if hue_low <= hue_high else [(hue_low, LAST_HUE), (0, hue_high)]
        mask = np.zeros(hls.shape[:2], np.uint8)
        for a, b in spans:
            lower, upper = (a, lightness[0], saturation[0]), (b, lightness[1], saturation[1])
            mask |= cv2.inRange(hls, np.array(lower), np.array(upper))
        share = 100 * np.count_nonzero(mask) / mask.size
        wraps = ", the hue wraps round 0" if len(spans) == 2 else ""
        return np.hstack([small, cv2.cvtColor(mask, cv2.COLOR_GRAY2BGR)]), f"{share:.1f} % of the pixels kept{wraps}"

    return Panel(
        "colour thresholds",
        {
            "hue_low": slider("lower hue H", low[0], 0, LAST_HUE),
            "hue_high": slider("upper hue H", high[0], 0, LAST_HUE),
            "lightness": range_slider("lightness L", (low[1], high[1]), 0, 255),
            "saturation": range_slider("saturation S", (low[2], high[2]), 0, 255),
        },
        draw,
    )


def hough_parameters(image: np.ndarray, color: str) -> Panel:
    """Blur, votes needed and radii of ``cv2.HoughCircles``, and the circles that it finds in the mask."""
    small = fit_width(check_image(image), PANEL_WIDTH * 2 // 3)
    mask = BallColor.named(color).mask(small)

    def draw(blur, votes, radii):
        blurred = cv2.GaussianBlur(mask, (2 * blur + 1, 2 * blur + 1), 0)
        found = cv2.HoughCircles(
            blurred, cv2.HOUGH_GRADIENT, 1, 12, param1=200, param2=votes, minRadius=radii[0], maxRadius=max(radii)
        )
        circles = [] if found is None else found.reshape(-1, found.shape[-1])[:20, :3]
        view = cv2.addWeighted(small, 0.7, cv2.cvtColor(blurred, cv2.COLOR_GRAY2BGR), 0.3, 0)
        for k, (u, v, radius) in enumerate(circles):
            cv2.circle(view, (round(u), round(v)), round(radius), (BLUE, ORANGE)[k > 0], 2, cv2.LINE_AA)
            cv2.drawMarker(view, (round(u), round(v)), (BLUE, ORANGE)[k > 0], cv2.MARKER_CROSS, 14, 2)
        count = len(circles)
        return view, f"{count} circle{'s' * (count > 1)}; the blue one has the most votes" if count else "no circle"

    return Panel(
        "Hough parameters",
        {
            "blur": slider("blur, half width (px)", 4, 0, 15),
            "votes": slider("votes needed", 10, 1, 60),
            "radii": range_slider("radii (px)", (4, min(96, small.shape[0] // 3)), 1, small.shape[0] // 3),
        },
        draw,
    )

"""Panels of lesson 01."""

from __future__ import annotations

from typing import Any

import cv2
import ipywidgets
import numpy as np

from stereo_lab.widgets.panel import ORANGE, PANEL_WIDTH, WHITE, Panel, fit_width, slider


def epipolar_line(calibration: Any, left: np.ndarray, right: np.ndarray) -> Panel:
    """One row drawn through both pictures, raw or rectified.

    Parameters
    ----------
    calibration : StereoCalibration
    left, right : ndarray, raw pictures, BGR
    """
    pairs = {
        kind: np.hstack([fit_width(image, PANEL_WIDTH // 2) for image in images])
        for kind, images in (("raw", (left, right)), ("rectified", calibration.rectify(left, right)))
    }
    height = pairs["raw"].shape[0]
    scale = left.shape[0] / height

    def draw(row, kind):
        view, y = pairs[kind].copy(), round(row / 100 * (height - 1))
        cv2.line(view, (0, y), (view.shape[1], y), ORANGE, 2, cv2.LINE_AA)
        half = view.shape[1] // 2
        cv2.line(view, (half, 0), (half, height), WHITE, 2)
        return view, f"row {y * scale:.0f} px in both {kind} pictures"

    kind = ipywidgets.ToggleButtons(
        options=["rectified", "raw"], description="pictures", style={"button_width": "110px"}
    )
    return Panel("epipolar line", {"row": slider("row (% from the top)", 40, 0, 100), "kind": kind}, draw)

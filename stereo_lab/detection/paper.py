"""The paper's way, Algorithm 1: keep the pixels between two HLS bounds, blur, vote for a circle."""

from __future__ import annotations

import cv2
import numpy as np

from stereo_lab.common.threads import one_thread
from stereo_lab.detection.color import BallColor
from stereo_lab.detection.model import Detection

BLUR_PX = 9
HOUGH_RADII = (4, 0.2)  # least radius in px, largest as a part of the picture's height
HOUGH_WIDTH = 1280  # a wider picture is made smaller: votes grow with the cube of the width
MASK_LIMIT = 0.25  # of the picture; beyond it the Hough transform would vote for minutes


def detect_paper(image: np.ndarray, color: BallColor) -> Detection | None:
    """Algorithm 1: HLS bounds, blur, circular Hough transform, strongest circle.

    Returns
    -------
    Detection or None, score 1
    """
    shrink = min(1.0, HOUGH_WIDTH / image.shape[1])
    if shrink < 1:
        image = cv2.resize(image, None, fx=shrink, fy=shrink, interpolation=cv2.INTER_AREA)
    mask = color.mask(image)
    if not 0 < np.count_nonzero(mask) < MASK_LIMIT * mask.size:
        return None
    blurred = cv2.GaussianBlur(mask, (BLUR_PX, BLUR_PX), 0)
    largest = int(HOUGH_RADII[1] * image.shape[0])
    with one_thread():
        circles = cv2.HoughCircles(
            blurred, cv2.HOUGH_GRADIENT, dp=1, minDist=image.shape[0], param1=200, param2=10,
            minRadius=HOUGH_RADII[0], maxRadius=largest,
        )  # fmt: skip
    if circles is None:
        return None
    u, v, radius = (float(c) for c in circles.reshape(-1, circles.shape[-1])[0, :3])
    return Detection((u + 0.5) / shrink - 0.5, (v + 0.5) / shrink - 0.5, radius / shrink, 1.0)

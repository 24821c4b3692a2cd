"""The paper's way, Algorithm 1: keep the pixels between two HLS bounds, blur, vote for a circle."""

from __future__ import annotations

import cv2
import numpy as np

from stereo_lab.detection.color import BallColor
from stereo_lab.detection.hough import library_circle, rim_share
from stereo_lab.detection.model import Detection

BLUR_PX = 9
HOUGH_RADII = (4, 0.2)  # least radius in px, largest as a part of the picture's height
HOUGH_WIDTH = 1280  # a wider picture is made smaller: votes grow with the cube of the width
MASK_LIMIT = 0.25  # of the picture; beyond it the Hough transform would vote for minutes


def detect_paper(image: np.ndarray, color: BallColor) -> Detection | None:
    """HLS bounds, blur, circular Hough transform, strongest circle, or None. Its score is its share of votes."""
    shrink = min(1.0, HOUGH_WIDTH / image.shape[1])
    if shrink < 1:
        image = cv2.resize(image, None, fx=shrink, fy=shrink, interpolation=cv2.INTER_AREA)
    mask = color.mask(image)
    if not 0 < np.count_nonzero(mask) < MASK_LIMIT * mask.size:
        return None
    blurred = cv2.GaussianBlur(mask, (BLUR_PX, BLUR_PX), 0)
    circle = library_circle(blurred, HOUGH_RADII[0], int(HOUGH_RADII[1] * image.shape[0]))
    if circle is None:
        return None
    u, v, radius = circle
    share = rim_share(blurred, circle)
    return Detection((u + 0.5) / shrink - 0.5, (v + 0.5) / shrink - 0.5, radius / shrink, share)

"""Lesson 02: find a ball of one colour in one picture. Lesson 09: learn to.

Two ways. ``method="paper"`` is Algorithm 1 of Rao and Singh: keep the pixels between two HLS bounds,
blur, and let a circular Hough transform vote for a centre. ``method="cone"`` finds round things of the
ball's colour, looks where their edge is to a fraction of a pixel, fits the cone of rays that touches
the ball, weighs the evidence for one, and says None where none is more probable. ``hough`` is the vote, written out to be read;
``training`` is how the judge's weights are learned, ``own`` a ball of one's own.
"""

from stereo_lab.detection.color import HUES, BallColor
from stereo_lab.detection.detector import BALL, BallDetector
from stereo_lab.detection.model import Detection, check_image
from stereo_lab.detection.own import OwnBall
from stereo_lab.detection.paper import BLUR_PX, detect_paper

__all__ = [
    "BALL",
    "BLUR_PX",
    "HUES",
    "BallColor",
    "BallDetector",
    "Detection",
    "OwnBall",
    "check_image",
    "detect_paper",
]

"""Lesson 01: what each camera does to a ray, and how the two stand to each other.

The corners of a board are found in many pairs and placed to a few hundredths of a pixel. One least-squares fit
explains them by two cameras, by where each board was held, and by the board's own shape, for paper is never flat. It
also tells how well it knows the cameras, and so any place that they tell. The order: ``corners``, ``charuco``, ``crossing``,
``start``, ``bundle``, ``solver``, ``uncertainty``, ``verdict``; ``recipe`` puts them together.
``homography`` is Zhang's idea, written out to be read.
"""

from stereo_lab.calibration.advice import depth_map, where_to_hold
from stereo_lab.calibration.cameras import StereoCalibration
from stereo_lab.calibration.corners import board_shown, counts_squares, find_corners, match_order, only_the_markers
from stereo_lab.calibration.homography import find_homography, focal_from_homography
from stereo_lab.calibration.printed import opencv_board
from stereo_lab.calibration.recipe import calibrate_stereo, calibrate_views
from stereo_lab.calibration.store import boards_of, calibrate_anew, calibrate_recording, find_calibration

__all__ = [
    "StereoCalibration", "board_shown", "boards_of", "calibrate_anew", "calibrate_recording", "calibrate_stereo",
    "calibrate_views", "counts_squares", "depth_map", "find_calibration", "find_corners", "find_homography", "focal_from_homography", "match_order", "only_the_markers", "opencv_board",
    "where_to_hold",
]  # fmt: skip

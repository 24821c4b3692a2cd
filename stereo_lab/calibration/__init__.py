"""Lesson 01: what each camera does to a ray, and how the two stand to each other.

The corners of a chessboard are found in many pairs, placed to a twentieth of a pixel by a saddle
fit, and explained by two cameras (Zhang's method, ``cv2.stereoCalibrate``). Paper is never flat: the
board's own shape is measured along with the cameras. ``homography`` is Zhang's idea, written out to be read.
"""

from stereo_lab.calibration.cameras import StereoCalibration
from stereo_lab.calibration.corners import find_corners, match_order
from stereo_lab.calibration.homography import find_homography, focal_from_homography
from stereo_lab.calibration.recipe import calibrate_stereo
from stereo_lab.calibration.store import boards_of, calibrate_anew, calibrate_recording, find_calibration

__all__ = [
    "StereoCalibration", "boards_of", "calibrate_anew", "calibrate_recording", "find_calibration", "calibrate_stereo", "find_corners", "find_homography",
    "focal_from_homography", "match_order",
]  # fmt: skip

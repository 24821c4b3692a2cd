"""A calibration against the truth, which rendered recordings know: how far off distances are because of it alone."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stereo_lab.calibration import StereoCalibration
from stereo_lab.calibration.bundle import project
from stereo_lab.calibration.uncertainty import common_field
from stereo_lab.recording import Recording


def as_rendered(recording: Recording, calibration: StereoCalibration) -> StereoCalibration | None:
    """The cameras as they were rendered, in the place of those of a calibration; None for real cameras, which nobody knows.

    Parameters
    ----------
    recording : Recording
    calibration : StereoCalibration, of any kind, of its cameras
    """
    if "cameras" not in recording.truth:
        return None
    left, right = (recording.truth["cameras"][side] for side in ("left", "right"))
    turn = np.array(right["rotation"])
    return replace(
        calibration,
        left_matrix=np.array(left["matrix"]),
        left_distortion=np.array(left["distortion"]),
        right_matrix=np.array(right["matrix"]),
        right_distortion=np.array(right["distortion"]),
        rotation=turn @ np.array(left["rotation"]).T,
        translation_mm=turn @ np.subtract(left["position_mm"], right["position_mm"]),
    )


def distance_errors_mm(calibration: StereoCalibration, true: StereoCalibration, depth_mm: float) -> np.ndarray:
    """How far off distances from the left camera are where pixels are exact, so that only the calibration can err.

    Points all over what both true cameras see at one distance are projected by the true cameras and triangulated by the
    calibration.

    Parameters
    ----------
    calibration, true : StereoCalibration
    depth_mm : float, how far ahead of the left camera the points lie

    Returns
    -------
    ndarray, shape (N,), mm; above zero where the calibration says too far
    """
    rig = true.rig
    points, left = common_field(rig, true.image_size, depth_mm)
    right = project(points @ rig.rotation.T + rig.translation, rig.right)[0]
    found = calibration.triangulate(
        calibration.rectify_points(left, "left"), calibration.rectify_points(right, "right")
    )
    return np.linalg.norm(found, axis=1) - np.linalg.norm(points, axis=1)

"""The calibration of a recording: made once, then read ever after."""

from __future__ import annotations

import hashlib

import stereo_lab
from stereo_lab.calibration.cameras import StereoCalibration
from stereo_lab.calibration.recipe import calibrate_stereo
from stereo_lab.common.files import user_folder
from stereo_lab.errors import CalibrationError, StereoLabError
from stereo_lab.recording import open_recording


def calibrate_recording(recording, progress=None):
    """The calibration of a recording, from the user's cache where it is there already.

    The cache is keyed by the pictures, the board and the version of the package.
    """
    if recording.calibrated_by:
        beside = recording.path.parent / recording.calibrated_by
        return calibrate_recording(open_recording(beside), progress)
    pairs = recording.pairs("calibration")
    path = user_folder() / "calibrations" / f"{_fingerprint(recording, pairs)}.json"
    if path.is_file():
        try:
            return StereoCalibration.load(path)
        except CalibrationError:
            pass  # a spoilt cache is made again
    result = calibrate_stereo(pairs, recording.board, progress)
    try:
        result.save(path)
    except StereoLabError:
        pass  # a read-only home folder costs time, nothing else
    return result


def _fingerprint(recording, pairs):
    digest = hashlib.sha256(f"{stereo_lab.__version__} {recording.board}".encode())
    for pair in pairs:
        for path in (pair.left_path, pair.right_path):
            digest.update(f"{pair.name}".encode())
            digest.update(path.read_bytes() if path else b"")
    return digest.hexdigest()[:24]

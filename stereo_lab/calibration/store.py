"""The calibration of a recording: made once, then read ever after.

A recording may bring its own, in ``calibration.json``; else it is kept in the user's folder. Both are keyed by
the pictures, the board and the solver: where one of these has changed, the calibration is made anew.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from dataclasses import asdict, replace

import numpy as np

from stereo_lab.calibration.cameras import StereoCalibration
from stereo_lab.calibration.recipe import JUDGED_AT_MM, calibrate_stereo
from stereo_lab.calibration.saved import TAKEN_OVER
from stereo_lab.calibration.solver import SOLVER
from stereo_lab.common.files import read_bytes, typed, user_folder
from stereo_lab.errors import CalibrationError, RecordingError, StereoLabError, SwappedSidesError
from stereo_lab.recording import Recording, open_recording
from stereo_lab.recording.model import must_be_recording
from stereo_lab.recording.strays import told_of_strays

BESIDE = "calibration.json"  # beside the sets of a recording
BROUGHT, KEPT, MADE = "it came with the recording", "kept from an earlier run", "made just now"
NEAREST_MM, FARTHEST_MM = 200.0, 10_000.0  # of measured balls


def calibrate_recording(
    recording: Recording, progress: Callable[[int, int], object] | None = None
) -> StereoCalibration:
    """The calibration of a recording: the one it brings, the one kept from before, or a new one.

    Parameters
    ----------
    recording : Recording
    progress : callable (done, total), optional; told while boards are looked for

    Returns
    -------
    StereoCalibration

    Raises
    ------
    CalibrationError
        If no calibration can be made of its boards.
    """
    return find_calibration(recording, progress)[0]


def find_calibration(
    recording: Recording, progress: Callable[[int, int], object] | None = None
) -> tuple[StereoCalibration, str]:
    """The same, and where it comes from: BROUGHT, KEPT or MADE."""
    recording = boards_of(recording)
    if "calibration" not in recording.sets:
        return _taken_over(recording), BROUGHT
    key = _key(recording)
    for path, source in ((recording.path / BESIDE, BROUGHT), (_user_path(key), KEPT)):
        found = _read(path, key)
        if found is not None:
            return found, source
    return _make(recording, key, progress), MADE


def _taken_over(recording):
    """The calibration from elsewhere that a recording without boards has: what is wrong with it is told, for none can be made anew."""
    path = recording.path / BESIDE
    found = StereoCalibration.load(path) if path.exists() else None
    if found is None or found.made_from != TAKEN_OVER:
        raise CalibrationError(
            f"{recording.title} has no pictures of boards, in calibration/left and calibration/right."
            f"{told_of_strays(recording.path)}"
        )
    if found.image_size != tuple(recording.image_size):
        (width, height), (wide, high) = found.image_size, recording.image_size
        raise CalibrationError(
            f"{path} is for pictures of {width}x{height} pixels, and those of {recording.title} are {wide}x{high}. Take over one that was "
            "made at this size."
        )
    return found


def calibrate_anew(recording: Recording, progress: Callable[[int, int], object] | None = None) -> StereoCalibration:
    """Do the work even where a calibration is at hand; the result is kept in the user's folder.

    Of a recording whose calibration was taken over from elsewhere it is that one: there is nothing to make one of.
    """
    recording = boards_of(recording)
    if "calibration" not in recording.sets:
        return find_calibration(recording)[0]
    return _make(recording, _key(recording), progress)


def _make(recording, key, progress):
    try:
        made = calibrate_stereo(recording.pairs("calibration"), recording.board, progress, distance_mm(recording))
    except SwappedSidesError as error:
        swap = f"stereo-lab calibrate {typed(recording.path)} --swap"
        raise SwappedSidesError(
            f"{error} To have the folders swapped, for every set of this recording: {swap}. In some sets alone? stereo-lab check says in which.",
            error.fault,
        ) from None
    result = replace(made, made_from=key)
    try:
        result.save(_user_path(key))
    except StereoLabError:
        pass  # a read-only home folder costs time, nothing else
    return result


def boards_of(recording: Recording) -> Recording:
    """The recording whose boards are used: itself, or the one beside it that ``calibrated_by`` names.

    Raises
    ------
    StereoLabError
        If it is a name and no recording.
    RecordingError
        If ``calibrated_by`` leads to none.
    """
    must_be_recording(recording)
    passed = [recording.name]
    while recording.calibrated_by:
        name = recording.calibrated_by
        if name in passed:
            raise RecordingError(
                f"{recording.path / 'recording.json'}: calibrated_by leads in a ring, {' -> '.join([*passed, name])}. "
                "Name a recording that has boards of its own."
            )
        beside = recording.path.parent / name
        if not (beside / "recording.json").is_file():
            raise RecordingError(
                f"{recording.path / 'recording.json'}: calibrated_by names the recording {name}, and there is none in {beside}. "
                "Copy it there, or name one that lies beside this one."
            )
        recording = open_recording(beside)
        passed.append(name)
    return recording


def distance_mm(recording: Recording) -> float:
    """The distance for which a recording's calibration is judged: the median of its ruler samples, or one metre.

    A table in another unit than millimetres tells no distance.
    """
    sets = [name for name in ("position", "depth") if recording.has_samples(name)]
    depths = [sample.measured.depth_mm for name in sets for sample in recording.samples(name)]
    told = round(float(np.median(depths)), -1) if depths else JUDGED_AT_MM
    return told if NEAREST_MM <= told <= FARTHEST_MM else JUDGED_AT_MM


def _read(path, key):
    """A calibration kept under this key; None where there is none, or a spoilt one."""
    try:
        found = StereoCalibration.load(path)
    except CalibrationError:
        return None
    return found if found.made_from == key else None


def _user_path(key):
    return user_folder() / "calibrations" / f"{key}.json"


def _key(recording):
    pairs = recording.pairs("calibration")  # first, for boards come before balls: so do their faults
    digest = hashlib.sha256(f"solver {SOLVER} {asdict(recording.board)} {distance_mm(recording)}".encode())
    for pair in pairs:
        for path in (pair.left_path, pair.right_path):
            digest.update(pair.name.encode())
            digest.update(read_bytes(path) if path else b"")
    return digest.hexdigest()[:24]

"""A saved calibration read back: every field looked at, so that a spoilt file is named and never used."""

from __future__ import annotations

import reprlib
from pathlib import Path
from typing import Any

import numpy as np

from stereo_lab.common.files import check_format, finite_number, read_json
from stereo_lab.errors import CalibrationError, StereoLabError
from stereo_lab.recording.bounds import LENGTHS_MM, PICTURE_PX, whole_in

TAKEN_OVER = "taken over from elsewhere"  # in the place of a key: a calibration whose boards are not here
MAKE_ONE = "Make one with: stereo-lab calibrate"
ARRAYS = {
    "left_matrix": (3, 3),
    "left_distortion": (-1,),
    "right_matrix": (3, 3),
    "right_distortion": (-1,),
    "rotation": (3, 3),
    "translation_mm": (3,),
}
NUMBERS = ("rms_px", "left_rms_px", "right_rms_px", "vertical_error_px", "focal_sigma_percent", "board_bend_mm")
UNKNOWN_TOO = ("vertical_error_px",)  # where no corner of a ChArUco board is seen by both cameras
NUMBERS_OR_NONE = ("heldout_vertical_error_px", "heldout_length_error_percent")
WORDS = ("lens", "verdict")
DISTORTIONS = (4, 5, 8, 12, 14)  # how many numbers OpenCV's lens models have
MOST_PAIRS = 100_000


def read_saved(path: str | Path) -> dict[str, Any]:
    """The fields of a saved StereoCalibration, by name.

    Raises
    ------
    CalibrationError
        If the file is no calibration, or something in it cannot be used.
    """
    try:
        facts = read_json(path)
        check_format(facts, path)
        unjudged = facts.get("made_from") == TAKEN_OVER
        return {
            "image_size": _size(facts["image_size"]),
            **{key: as_field(facts[key], shape, key) for key, shape in ARRAYS.items()},
            **{key: _number(facts[key], key, unjudged or key in UNKNOWN_TOO) for key in NUMBERS},
            **{key: None if facts[key] is None else finite_number(facts[key], key) for key in NUMBERS_OR_NONE},
            **{key: str(facts[key]) for key in WORDS},
            "pairs": whole_in(facts["pairs"], "pairs", 0, MOST_PAIRS),
            "found": whole_in(facts["pairs_found"], "pairs_found", 0, MOST_PAIRS),
            "used": tuple(map(str, _list(facts["used"], "used"))),
            "dropped": tuple((str(d["name"]), str(d["why"])) for d in _objects(facts["dropped"], "dropped")),
            "reasons": tuple(map(str, _list(facts["reasons"], "reasons"))),
            "depth_mm": finite_number(facts.get("depth_mm", 1000.0), "depth_mm"),
            "misfit": finite_number(facts.get("misfit", 1.0), "misfit"),
            "corners_left_out": tuple(map(_corner, _objects(facts.get("corners_left_out", []), "corners_left_out"))),
            "outlines": _outlines(facts.get("outlines", [])),
            "covariance": _covariance(facts.get("covariance")),
            "made_from": str(facts.get("made_from", "")),
        }
    except KeyError as error:
        raise CalibrationError(f"{path} is no calibration of this kit: it has no {error}. {MAKE_ONE}") from None
    except StereoLabError as error:
        raise CalibrationError(f"{path} is no calibration of this kit: {error} {MAKE_ONE}") from None


def _number(value, name, may_be_unknown):
    return np.nan if may_be_unknown and value is None else finite_number(value, name)


def _list(value, name):
    if not isinstance(value, list):
        raise CalibrationError(f"{name}: expected a list, got {reprlib.repr(value)}.")
    return value


def _objects(value, name):
    if not all(isinstance(entry, dict) for entry in _list(value, name)):
        raise CalibrationError(f"{name}: expected a list of objects, got {reprlib.repr(value)}.")
    return value


def _size(value):
    if len(_list(value, "image_size")) != 2:
        raise CalibrationError(f"image_size: expected two numbers, got {reprlib.repr(value)}.")
    return tuple(whole_in(v, "image_size", *PICTURE_PX) for v in value)


def as_field(value: Any, shape: tuple[int, ...], name: str) -> np.ndarray:
    """An array of this shape, fit for what its name says.

    Raises
    ------
    CalibrationError
        If it has another shape, is not finite, or can be no such thing: a rotation that is none.
    """
    try:
        array = np.asarray(value, float).reshape(shape)
    except (TypeError, ValueError, OverflowError) as error:
        raise CalibrationError(f"{name}: expected numbers of shape {shape} ({error}).") from None
    if not np.isfinite(array).all():
        raise CalibrationError(f"{name} holds a number that is not finite.")
    for fits, fault in FAULTS.get(name.removeprefix("left_").removeprefix("right_"), ()):
        if not fits(array):
            raise CalibrationError(f"{name} {fault}.")
    return array


def _covariance(value):
    """Of the 24 unknowns of two cameras; None in files of before there was one."""
    return None if value is None else as_field(value, (24, 24), "covariance")


def _corner(entry):
    """A single corner that was left out: (pair, side, u, v, px off)."""
    return (
        str(entry["name"]), str(entry["side"]), *(finite_number(entry[key], f"corners_left_out {key}") for key in ("u", "v", "off_px")),
    )  # fmt: skip


def _outlines(value):
    """Four corners for each board and camera; null where a camera did not see it."""
    try:
        return np.array(_list(value, "outlines"), float).reshape(-1, 2, 4, 2)
    except (TypeError, ValueError, OverflowError) as error:
        raise CalibrationError(f"outlines: expected numbers or null, of shape (boards, 2, 4, 2) ({error}).") from None


def _is_rotation(array):
    return np.allclose(array @ array.T, np.eye(3), atol=1e-3) and np.linalg.det(array) > 0


FAULTS = {  # what each array must fulfil, and what to say where it does not
    "matrix": (
        (lambda a: min(a[0, 0], a[1, 1]) > 0, "has a focal length of zero or less"),
        (lambda a: np.array_equal(a[2], (0, 0, 1)), "is no camera's matrix: its last row is not 0, 0, 1"),
    ),
    "distortion": ((lambda a: len(a) in DISTORTIONS, f"must have {', '.join(map(str, DISTORTIONS))} numbers"),),
    "covariance": (
        (lambda a: np.allclose(a, a.T) and np.diag(a).min() >= 0, "is no covariance: it must be the same mirrored"),
    ),
    "rotation": ((_is_rotation, "is not a rotation"),),
    "translation_mm": ((lambda a: 0 < np.abs(a).max() <= LENGTHS_MM[1], "is no distance between two cameras"),),
}

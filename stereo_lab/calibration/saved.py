"""A saved calibration read back: every field looked at, so that a spoilt file is named and never used."""

from __future__ import annotations

import reprlib
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from stereo_lab.calibration.bundle import Rig
from stereo_lab.calibration.refusals import check_sides
from stereo_lab.common.files import check_format, finite_number, read_json
from stereo_lab.errors import CalibrationError, StereoLabError
from stereo_lab.recording.bounds import LENGTHS_MM, PICTURE_PX, length_mm, number_in, told_mm, whole_in

TAKEN_OVER = "taken over from elsewhere"  # in the place of a key: a calibration whose boards are not here
MAKE_ONE = "Make one with: stereo-lab calibrate; or take one over with: stereo-lab import --calibration"
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
GRADES = ("good", "usable", "poor")
WORDS = {"lens": ("brown",), "verdict": GRADES}
DISTORTIONS = (4, 5, 8, 12, 14)  # how many numbers OpenCV's lens models have
MOST_PAIRS = 100_000
LARGEST = 100_000.0  # of any figure that tells how good it is
BASELINE_MM = (10.0, 3000.0)  # of two cameras on a table, or on a mast
FOCAL_SIDES = (0.1, 100.0)  # a focal length, in longer sides of the picture: from a fisheye to a telescope
FAR_OUT = 10  # longer sides of the picture: no lens moves a pixel so far
BESIDE_PX = 10  # a corner of a board is not found farther outside of its picture
NO_SKEW = 1e-6


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
        fields = _fields(facts)
        check_cameras(fields)
        _check_as_a_whole(fields)
        return fields
    except KeyError as error:
        raise CalibrationError(f"{path} is no calibration of this kit: it has no {error}. {MAKE_ONE}") from None
    except StereoLabError as error:
        raise CalibrationError(f"{path} is no calibration of this kit: {error} {MAKE_ONE}") from None


def _fields(facts):
    """Each field for itself."""
    unjudged = facts.get("made_from") == TAKEN_OVER
    return {
        "image_size": _size(facts["image_size"]),
        **{key: as_field(facts[key], shape, key) for key, shape in ARRAYS.items()},
        **{key: _number(facts[key], key, unjudged or key in UNKNOWN_TOO) for key in NUMBERS},
        **{key: None if facts[key] is None else finite_number(facts[key], key) for key in NUMBERS_OR_NONE},
        **{key: _word(facts[key], key) for key in WORDS},
        "pairs": whole_in(facts["pairs"], "pairs", 0, MOST_PAIRS),
        "found": whole_in(facts["pairs_found"], "pairs_found", 0, MOST_PAIRS),
        "used": tuple(map(str, _list(facts["used"], "used"))),
        "dropped": tuple((str(d["name"]), str(d["why"])) for d in _objects(facts["dropped"], "dropped")),
        "reasons": tuple(map(str, _list(facts["reasons"], "reasons"))),
        "depth_mm": length_mm(facts.get("depth_mm", 1000.0), "depth_mm"),
        "misfit": number_in(facts.get("misfit", 1.0), "misfit", 1.0, LARGEST),
        "corners_left_out": tuple(map(_corner, _objects(facts.get("corners_left_out", []), "corners_left_out"))),
        "outlines": _outlines(facts.get("outlines", [])),
        "covariance": _covariance(facts.get("covariance")),
        "made_from": str(facts.get("made_from", "")),
    }


def check_cameras(fields: dict[str, Any]) -> None:
    """Refuse two cameras that cannot be: by their lenses, in pictures of this size, or by how they stand.

    Parameters
    ----------
    fields : dict, with image_size and what :data:`ARRAYS` names

    Raises
    ------
    CalibrationError
        If there is a fault of :data:`CAMERA_FAULTS`, or the right camera does not stand to the right of the left one.
    """
    size = fields["image_size"]
    for side in ("left", "right"):
        camera = fields[f"{side}_matrix"], fields[f"{side}_distortion"]
        for k, fits, fault in CAMERA_FAULTS:
            if not fits(*camera, size):
                name, got = f"{side}_{('matrix', 'distortion')[k]}", reprlib.repr(camera[k].tolist())
                raise CalibrationError(f"{name} {fault}, which is {size[0]}x{size[1]} pixels; got {got}.")
    _check_stand(fields["rotation"], fields["translation_mm"])


def _check_stand(rotation, translation):
    """As boards of one's own are checked, in words for a file: nothing could place a ball by such cameras."""
    try:
        check_sides(Rig(np.zeros(9), np.zeros(9), rotation, translation))
    except CalibrationError as error:
        if error.fault == "upside_down":
            raise
        x, y, _ = (f"{part:.0f}" for part in -rotation.T @ translation)
        raise CalibrationError(
            f"expected the right camera to stand to the right of the left one; by these it stands {x} mm to the right of it "
            f"and {y} mm below it. Were the two exchanged, or the translation turned round?"
        ) from None


def _check_as_a_whole(fields):
    """Refuse fields that contradict each other: far too long a baseline for its verdict, boards outside of the pictures."""
    baseline = float(np.linalg.norm(fields["translation_mm"]))
    # Squares told in metres make a baseline of 0.1 mm: such a calibration is kept, for it says itself that it is poor
    if fields["verdict"] != "poor" and not BASELINE_MM[0] <= baseline <= BASELINE_MM[1]:
        raise CalibrationError(
            f"translation_mm: expected cameras that stand {BASELINE_MM[0]:.0f} to {BASELINE_MM[1]:.0f} mm apart; by it they "
            f"stand {told_mm(baseline)} mm apart. Is it in millimetres?"
        )
    width, height = fields["image_size"]
    seen = fields["outlines"].reshape(-1, 2)
    low, high = -BESIDE_PX, np.array([width, height]) + BESIDE_PX
    if ((seen < low) | (seen > high)).any():  # where a board is not seen it is NaN, and neither
        u, v = np.nanmax(seen, axis=0)
        raise CalibrationError(
            f"outlines: expected boards inside of the pictures, which are {width}x{height} pixels; they reach to u {u:.0f} and v {v:.0f}. "
            "Were the two numbers of image_size exchanged?"
        )


def _number(value, name, may_be_unknown):
    return np.nan if may_be_unknown and value is None else number_in(value, name, 0.0, LARGEST)


def _word(value, name):
    if value not in WORDS[name]:
        raise CalibrationError(f"{name}: expected {' or '.join(WORDS[name])}, got {reprlib.repr(value)}.")
    return value


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


def _is_covariance(array):
    """The same mirrored, and no mixture of the unknowns with a variance below zero; each counted in its own sigmas."""
    if not np.allclose(array, array.T) or np.diag(array).min() < 0:
        return False
    sigma = np.sqrt(np.diag(array))
    sigma[sigma == 0] = 1.0
    return np.linalg.eigvalsh(array / np.outer(sigma, sigma)).min() >= -1e-6


def _focal_fits(matrix, _, size):
    return all(FOCAL_SIDES[0] <= focal / max(size) <= FOCAL_SIDES[1] for focal in (matrix[0, 0], matrix[1, 1]))


def _center_fits(matrix, _, size):
    return all(-side <= center <= 2 * side for center, side in zip(matrix[:2, 2], size, strict=True))


def _lens_fits(matrix, distortion, size):
    """Whether the lens leaves the corners of a picture where they may be."""
    corners = np.array([[u, v] for u in (0.0, size[0]) for v in (0.0, size[1])])
    rays = np.column_stack([(corners - matrix[:2, 2]) / np.diag(matrix)[:2], np.ones(4)])
    seen = cv2.projectPoints(rays, np.zeros(3), np.zeros(3), matrix, distortion)[0].reshape(-1, 2)
    return np.abs(seen - corners).max() <= FAR_OUT * max(size)


FAULTS = {  # what each array must fulfil, and what to say where it does not
    "matrix": (
        (lambda a: min(a[0, 0], a[1, 1]) > 0, "has a focal length of zero or less"),
        (lambda a: np.array_equal(a[2], (0, 0, 1)), "is no camera's matrix: its last row is not 0, 0, 1"),
        (
            lambda a: max(abs(a[0, 1]), abs(a[1, 0])) <= NO_SKEW,
            "has a skew, and this kit's cameras have none: the second number of its first row and the first of its second must be 0",
        ),
    ),
    "distortion": ((lambda a: len(a) in DISTORTIONS, f"must have {', '.join(map(str, DISTORTIONS))} numbers"),),
    "covariance": (
        (_is_covariance, "is no covariance: it must be the same mirrored, and have no negative eigenvalue"),
    ),
    "rotation": ((_is_rotation, "is not a rotation"),),
    "translation_mm": ((lambda a: 0 < np.abs(a).max() <= LENGTHS_MM[1], "is no distance between two cameras"),),
}
CAMERA_FAULTS = (  # of the matrix, 0, or the distortion, 1, of a camera in pictures of a size
    (0, _focal_fits, "has a focal length that no lens has: expected 0.1 to 100 times the longer side of the picture"),
    (0, _center_fits, "has its principal point farther outside of the picture than the picture is large"),
    (1, _lens_fits, "is of no lens: it moves a corner of the picture by more than ten times the longer side of it"),
)

"""Calibrations as other programs write them: OpenCV's YAML files, and the camera_info pairs of ROS.

``cv2.stereoCalibrate`` tells how a point of the left camera's frame gets into the right one's: X_right = R X_left + T. ROS tells how
each camera is turned for rectification, R1 and R2, and how far the rectified right one stands to the side, as P2[0, 3] = -f B,
in metres. So R = R2ᵀ R1, and T = R2ᵀ (P2[0, 3] / f, 0, 0).
"""

from __future__ import annotations

import reprlib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import yaml

from stereo_lab.calibration import StereoCalibration
from stereo_lab.calibration.saved import ARRAYS, BASELINE_MM, TAKEN_OVER, as_field, check_cameras
from stereo_lab.common.files import read_bytes, write_json, write_whole
from stereo_lab.errors import CalibrationError, StereoLabError
from stereo_lab.recording import Ball, Board, Recording, open_recording
from stereo_lab.recording.bounds import PICTURE_PX, told_mm, whole_in
from stereo_lab.recording.importing import camera_facts, check_new

UNITS_MM = {"mm": 1.0, "cm": 10.0, "inch": 25.4, "m": 1000.0}
NAMES = {  # what OpenCV's examples and common tools call each of them
    "left_matrix": ("M1", "K1", "cameraMatrix1", "camera_matrix_1", "Camera_1_Matrix", "left_camera_matrix", "mtxL"),
    "left_distortion": ("D1", "distCoeffs1", "dist_coeffs_1", "Camera_1_Distortion", "left_distortion", "distL"),
    "right_matrix": ("M2", "K2", "cameraMatrix2", "camera_matrix_2", "Camera_2_Matrix", "right_camera_matrix", "mtxR"),
    "right_distortion": ("D2", "distCoeffs2", "dist_coeffs_2", "Camera_2_Distortion", "right_distortion", "distR"),
    "rotation": ("R", "rotation", "Rotation_Matrix"),
    "translation_mm": ("T", "translation", "Translation_Vector"),
}
WIDTHS, HEIGHTS = ("image_width", "imageWidth", "width"), ("image_height", "imageHeight", "height")
DISTORTIONS = "left_distortion", "right_distortion"
LEAST = 5  # numbers of a distortion in the files that are written: of four another program cannot tell which lens they are of
ROS_LENSES = ("plumb_bob", "rational_polynomial")


def export_calibration(calibration: StereoCalibration, folder: str | Path, name: str = "stereo_lab") -> list[Path]:
    """Write a calibration for other programs: ``stereo.yml`` for OpenCV, ``left.yaml`` and ``right.yaml`` for ROS.

    Parameters
    ----------
    calibration : StereoCalibration
    folder : path, made where it is not there
    name : str, of the cameras, for ROS

    Returns
    -------
    list of Path, the files
    """
    folder = Path(folder)
    files = [folder / "stereo.yml", folder / "left.yaml", folder / "right.yaml"]
    write_whole(files[0], _opencv_text(calibration))
    for file, side in zip(files[1:], ("left", "right"), strict=True):
        facts = _ros_facts(calibration, side, name)
        write_whole(file, yaml.safe_dump(facts, sort_keys=False, default_flow_style=None))
    return files


def _opencv_text(calibration):
    file = cv2.FileStorage(".yml", cv2.FILE_STORAGE_WRITE | cv2.FILE_STORAGE_MEMORY)
    width, height = calibration.image_size
    file.write("image_width", int(width))
    file.write("image_height", int(height))
    file.write("unit", "mm")
    for field, names in NAMES.items():
        value = getattr(calibration, field)
        if field in DISTORTIONS:
            value = _five_or_more(value)
        file.write(names[0], value if value.ndim == 2 else value.reshape(-1, 1))
    for k, (turn, projection) in enumerate(calibration.rectified.values(), 1):
        file.write(f"R{k}", turn)
        file.write(f"P{k}", projection)
    return file.releaseAndGetString()


def _five_or_more(lens):
    """A distortion as a row; of four numbers with a fifth one, 0, which changes nothing."""
    return np.append(lens, np.zeros(max(0, LEAST - len(lens)))).reshape(1, -1)


def _ros_facts(calibration, side, name):
    lens = _five_or_more(getattr(calibration, f"{side}_distortion"))
    turn, projection = calibration.rectified[side]
    in_metres = projection.copy()
    in_metres[:, 3] /= UNITS_MM["m"]
    table = lambda a: {"rows": len(a), "cols": a.shape[1], "data": [float(v) for v in a.ravel()]}
    return {
        "image_width": int(calibration.image_size[0]),
        "image_height": int(calibration.image_size[1]),
        "camera_name": f"{name}/{side}",
        "camera_matrix": table(getattr(calibration, f"{side}_matrix")),
        "distortion_model": "plumb_bob" if lens.size == LEAST else "rational_polynomial",
        "distortion_coefficients": table(lens),
        "rectification_matrix": table(turn),
        "projection_matrix": table(in_metres),
    }


def import_calibration(files: Sequence[str | Path], unit: str | None = None) -> StereoCalibration:
    """A calibration made elsewhere: one or more YAML files of OpenCV, or the left and the right camera_info of ROS.

    Parameters
    ----------
    files : sequence of paths
    unit : str, of the translation: mm, cm, inch or m. Left out: m of ROS; of OpenCV as the file says, or mm

    Returns
    -------
    StereoCalibration
        Its errors are NaN: what it was made of is not here to be judged.

    Raises
    ------
    CalibrationError
        If a file cannot be read, something is missing, it is in another unit, it is of a fisheye lens, or there can be no
        such two cameras.
    """
    if unit is not None and unit not in UNITS_MM:
        raise CalibrationError(f"Expected a unit of {', '.join(UNITS_MM)}; got {unit!r}.")
    texts = {str(path): read_bytes(path).decode("utf-8", "replace") for path in files}
    ros = [name for name, text in texts.items() if "camera_matrix:" in text and "projection_matrix:" in text]
    others = {name: text for name, text in texts.items() if name not in ros}
    if ros and others:
        _of_opencv(others, unit)  # whatever is wrong with these alone is told first
        raise CalibrationError(
            f"{_named(ros)} {'is' if len(ros) == 1 else 'are'} of ROS, and {_named(others)} not: name {_named(others)} alone, "
            "or the left and the right camera_info of ROS."
        )
    facts = _of_ros(texts, unit) if ros else _of_opencv(texts, unit)
    baseline = float(np.linalg.norm(facts["translation_mm"]))
    if not BASELINE_MM[0] <= baseline <= BASELINE_MM[1]:
        wish = "" if ros else " Say in which unit its translation is: --unit m, cm or inch."
        raise CalibrationError(f"{_named(texts)}: the two cameras would stand {told_mm(baseline)} mm apart.{wish}")
    try:
        check_cameras(facts)
    except CalibrationError as error:
        raise CalibrationError(f"{_named(texts)}: {error}") from None
    unknown = float("nan")
    return StereoCalibration(
        **facts, rms_px=unknown, left_rms_px=unknown, right_rms_px=unknown, vertical_error_px=unknown, focal_sigma_percent=unknown,
        heldout_vertical_error_px=None, heldout_length_error_percent=None, board_bend_mm=unknown, lens="brown",
        pairs=0, found=0, used=(), dropped=(), verdict="usable", made_from=TAKEN_OVER,
        reasons=(f"Taken over from {_named(texts)}. What it was made of is not here, so how good it is is not known.",),
    )  # fmt: skip


def recording_of(calibration: StereoCalibration, folder: str | Path, ball: Ball) -> Recording:
    """Put a calibration taken over from elsewhere into a recording without boards; where there is none, make one.

    Raises
    ------
    StereoLabError
        If the recording has boards of its own, another calibration, or pictures of another size.
    """
    folder = Path(folder)
    if (folder / "recording.json").exists():
        recording = open_recording(folder)
        if recording.has_boards:
            raise CalibrationError(f"{folder} has boards of its own: calibrate it on them, or name another folder.")
        if recording.image_size != calibration.image_size:
            raise CalibrationError(
                f"The pictures of {folder} are {_by(recording.image_size)} pixels, those of the calibration {_by(calibration.image_size)}."
            )
        kept = folder / "calibration.json"
        if kept.exists() and not _alike(StereoCalibration.load(kept), calibration):
            raise CalibrationError(
                f"{folder} has another calibration already. Take {kept} away first, or name another folder."
            )
    else:
        check_new(folder)
        facts = camera_facts(folder.name, calibration.image_size, Board(9, 6, 25.0), ball)
        write_json(folder / "recording.json", facts)
    calibration.save(folder / "calibration.json")
    return open_recording(folder.resolve())


def _alike(one, other):
    pairs = [(getattr(one, key), getattr(other, key)) for key in ARRAYS]
    return all(a.shape == b.shape and np.allclose(a, b) for a, b in pairs)


def _by(size):
    return f"{size[0]}x{size[1]}"


def _named(texts):
    return " and ".join(Path(name).name for name in texts)


def _unit_mm(told, asked, texts):
    """How many millimetres the unit has that a file tells; where it tells none, the one that is asked for, or mm."""
    if told not in UNITS_MM:
        return UNITS_MM[asked or "mm"]
    if asked not in (None, told):
        raise CalibrationError(f"{_named(texts)}: its translation is in {told}; --unit says {asked}. Leave --unit out.")
    return UNITS_MM[told]


def _of_opencv(texts, unit):
    values: dict[str, Any] = {}
    for name, text in texts.items():
        try:
            values |= _nodes(cv2.FileStorage(text, cv2.FILE_STORAGE_READ | cv2.FILE_STORAGE_MEMORY))
        except (cv2.error, SystemError):
            raise CalibrationError(
                f"{name}: this is neither YAML, XML or JSON that OpenCV wrote nor a camera_info of ROS."
            ) from None
    unit_mm = _unit_mm(str(values.get("unit")), unit, texts)  # our own export tells it
    found = {field: _one_of(values, names) for field, names in NAMES.items()}
    found |= {"width": _one_of(values, WIDTHS), "height": _one_of(values, HEIGHTS)}
    lacking = [
        NAMES[field][0] if field in NAMES else f"image_{field}" for field, value in found.items() if value is None
    ]
    if lacking:
        have = ", ".join(values) or "nothing"
        raise CalibrationError(
            f"{_named(texts)}: expected {', '.join(lacking)} as well, by that name or another usual one; there is {have}. "
            "OpenCV's own example writes two files, intrinsics.yml and extrinsics.yml: name both. A size of the pictures that is "
            "missing may be added by hand: image_width and image_height."
        )
    _check_lens(found, _named(texts))
    size = _size(found.pop("width"), found.pop("height"), _named(texts))
    checked = {field: _shaped(value, field, _named(texts)) for field, value in found.items()}
    checked["translation_mm"] = checked["translation_mm"] * unit_mm
    return {"image_size": size, **checked}


def _check_lens(found, where):
    """Refuse four numbers: no name in such a file tells a fisheye lens from an ordinary one."""
    for field in DISTORTIONS:
        if np.size(found[field]) == 4:
            raise CalibrationError(
                f"{where}: expected 5, 8, 12 or 14 numbers in {field}; there are 4. So many has a lens of cv2.fisheye, of which this kit has no "
                "model, and an older calibration of an ordinary lens. If it is an ordinary lens, write a fifth number, 0, and 5 for its 4 rows or cols."
            )


def _nodes(file):
    """The tables, numbers and words of a file, by name."""
    values = {}
    for key in file.root().keys() if file.root().isMap() else ():
        node = file.getNode(key)
        if node.isMap():
            values[key] = node.mat()
        elif node.isString():
            values[key] = node.string()
        elif node.isReal() or node.isInt():
            values[key] = node.real()
    return values


def _one_of(values, names):
    return next((values[name] for name in names if values.get(name) is not None), None)


def _size(width, height, where):
    try:
        return tuple(whole_in(n, f"{where}, image_{k}", *PICTURE_PX) for k, n in (("width", width), ("height", height)))
    except StereoLabError as error:
        raise CalibrationError(str(error)) from None


def _shaped(value, field, where):
    """An array as :class:`StereoCalibration` has it, looked at as one that is read from a file of the kit's own."""
    try:
        array = np.asarray(value, float)
    except (TypeError, ValueError):
        raise CalibrationError(f"{where}: {field} is {reprlib.repr(value)}, and numbers were expected.") from None
    if field == "rotation" and array.size == 3:
        array = cv2.Rodrigues(array.ravel())[0]
    try:
        return as_field(array.ravel() if ARRAYS[field] != (3, 3) else array, ARRAYS[field], field)
    except CalibrationError as error:
        raise CalibrationError(f"{where}: {error}") from None


def _of_ros(texts, unit):
    unit_mm = _unit_mm("m", unit, texts)
    if len(texts) != 2:
        raise CalibrationError("Of ROS expected two files, the left camera's and the right camera's.")
    cameras = [_ros_camera(name, text) for name, text in texts.items()]
    cameras.sort(key=lambda camera: -camera["shift"])  # the left one has none, the right one a negative one
    left, right = cameras
    if left["size"] != right["size"]:
        raise CalibrationError(f"The pictures of the two cameras differ in size: {left['size']} and {right['size']}.")
    if right["shift"] == left["shift"]:
        raise CalibrationError(f"{_named(texts)}: neither projection_matrix tells how far apart the cameras stand.")
    turn = right["turn"].T @ left["turn"]
    step = right["turn"].T @ np.array([(right["shift"] - left["shift"]) * unit_mm, 0, 0])
    where = _named(texts)
    facts = {"rotation": _shaped(turn, "rotation", where), "translation_mm": _shaped(step, "translation_mm", where)}
    for side, camera in (("left", left), ("right", right)):
        facts[f"{side}_matrix"] = _shaped(camera["matrix"], f"{side}_matrix", where)
        facts[f"{side}_distortion"] = _shaped(camera["lens"], f"{side}_distortion", where)
    return {"image_size": left["size"], **facts}


def _ros_camera(name, text):
    """One camera_info: its size, matrix, lens, turn, and how far to the side it stands, in metres."""
    try:
        facts = yaml.safe_load(text)
        table = lambda key, shape: np.array(facts[key]["data"], float).reshape(shape)
        model = str(facts["distortion_model"])
        projection = table("projection_matrix", (3, 4))
        camera = {
            "size": _size(facts["image_width"], facts["image_height"], name),
            "matrix": table("camera_matrix", (3, 3)), "lens": table("distortion_coefficients", -1),
            "turn": table("rectification_matrix", (3, 3)), "shift": float(projection[0, 3] / projection[0, 0]),
        }  # fmt: skip
    except (yaml.YAMLError, KeyError, TypeError, ValueError, ZeroDivisionError) as error:
        raise CalibrationError(f"{name}: this is no camera_info of ROS ({type(error).__name__}: {error}).") from None
    if model not in ROS_LENSES:
        raise CalibrationError(f"{name}: its lens model is {model}; the kit knows {' and '.join(ROS_LENSES)}.")
    return camera

"""Recordings with a mistake in them, to try the doctor on: a copy of a good one, spoilt in one way or in several."""

from __future__ import annotations

import csv
import io
import json
import shutil
from collections.abc import Callable, Sequence
from pathlib import Path

import cv2
import numpy as np

from stereo_lab.calibration import StereoCalibration, find_calibration
from stereo_lab.common.files import write_whole
from stereo_lab.errors import RecordingError
from stereo_lab.recording import Recording, open_recording, read_image
from stereo_lab.recording.importing import check_new

SETS = "calibration", "position", "depth"
NUMBERS = "x_mm", "y_mm", "depth_mm"
SIDES = "left", "right"
LEAST_BEFORE = 4  # pairs on each side of something that changes in mid-set

Spoiler = Callable[[Path, np.random.Generator, StereoCalibration], None]


def spoil(recording: Recording, out: str | Path, faults: Sequence[str], seed: int = 0) -> Recording:
    """Copy a recording's boards and measured balls into a new folder, with mistakes in them.

    Parameters
    ----------
    recording : Recording, a good one
    out : folder to make
    faults : names of :data:`FAULTS`, made one after the other
    seed : int, which pairs, which numbers

    Raises
    ------
    RecordingError
        If there is no such fault, or the folder is there already.
    """
    unknown = [fault for fault in faults if fault not in FAULTS]
    if unknown:
        raise RecordingError(f"There is no fault {unknown[0]!r}. Choose among {', '.join(FAULTS)}.")
    folder = Path(out)
    check_new(folder)
    calibration = find_calibration(recording)[0]
    for name in SETS:
        if name in recording.sets:
            shutil.copytree(recording.path / name, folder / name)
    shutil.copyfile(recording.path / "recording.json", folder / "recording.json")
    for number, fault in enumerate(faults):
        FAULTS[fault](folder, np.random.default_rng([seed, number]), calibration)
    return open_recording(folder)


# Pictures of a set are changed in their files.


def _files(folder, side, name="calibration"):
    return sorted((folder / name / side).iterdir())


def _sets(folder):
    return [name for name in SETS if (folder / name / "right").is_dir()]


def _each(files, change, quality=95):
    for file in files:
        image = np.ascontiguousarray(change(read_image(file, grey_allowed=True)))
        how = [cv2.IMWRITE_JPEG_QUALITY, quality] if file.suffix == ".jpg" else []
        write_whole(file, cv2.imencode(file.suffix, image, how)[1].tobytes())


def _contents(files, order):
    """Put into each file what stands in another one."""
    contents = [file.read_bytes() for file in files]
    for file, k in zip(files, order, strict=True):
        file.write_bytes(contents[k])


def _middle(rng, files):
    """A pair from which on something is different."""
    return int(rng.integers(LEAST_BEFORE, len(files) - LEAST_BEFORE + 1))


def _sides_swapped(folder, rng, calibration):
    for name in _sets(folder):
        for one, other in (("left", "x"), ("right", "left"), ("x", "right")):
            (folder / name / one).rename(folder / name / other)


def _cameras_exchanged(folder, rng, calibration):
    left, right = (_files(folder, side) for side in SIDES)
    for one, other in list(zip(left, right, strict=True))[_middle(rng, left) :]:
        _contents([one, other], [1, 0])


def _pairs_shifted(folder, rng, calibration):
    left, right = (_files(folder, side) for side in SIDES)
    _contents(right, [(k + 1) % len(right) for k in range(len(right))])
    for side in (left, right):
        side[-1].unlink()


def _pairs_do_not_match(folder, rng, calibration):
    right = _files(folder, "right")
    _contents([right[k] for k in rng.choice(len(right), 2, replace=False)], [1, 0])


def _not_together(folder, rng, calibration):
    right = _files(folder, "right")
    _contents(right, rng.permutation(len(right)))


def _mirrored(folder, rng, calibration):
    side = str(rng.choice(SIDES))
    for name in _sets(folder):
        _each(_files(folder, side, name), lambda image: image[:, ::-1])


def _both_mirrored(folder, rng, calibration):
    for name in _sets(folder):
        for side in SIDES:
            _each(_files(folder, side, name), lambda image: image[:, ::-1])


def _upside_down(folder, rng, calibration):
    side = str(rng.choice(SIDES))
    for name in _sets(folder):
        _each(_files(folder, side, name), lambda image: image[::-1, ::-1])


def _both_upside_down(folder, rng, calibration):
    for name in _sets(folder):
        for side in SIDES:
            _each(_files(folder, side, name), lambda image: image[::-1, ::-1])


def _seen_otherwise(calibration, side, rotation, zoom):
    """What turns a picture into that of the same camera turned and zoomed; exact, for a turn about its own centre."""
    matrix, distortion = calibration.camera(side)
    width, height = calibration.image_size
    pixels = np.stack(np.meshgrid(np.arange(width), np.arange(height)), -1).reshape(-1, 1, 2).astype(float)
    flat = cv2.undistortPoints(pixels, matrix, distortion).reshape(-1, 2) / zoom
    rays = np.column_stack([flat, np.ones(len(flat))]) @ rotation
    sources = cv2.projectPoints(rays.reshape(-1, 1, 3), np.zeros(3), np.zeros(3), matrix, distortion)[0]
    places = sources.reshape(height, width, 2).astype(np.float32)
    return lambda image: cv2.remap(image, places, None, cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE)


def _from_a_pair_on(folder, rng, calibration, degrees, zoom):
    """One camera differs from one pair on, and in all that is taken afterwards."""
    side, axis = str(rng.choice(SIDES)), rng.normal(size=3)
    turn = cv2.Rodrigues(np.radians(degrees) * axis / np.linalg.norm(axis))[0]
    change = _seen_otherwise(calibration, side, turn, zoom)
    boards = _files(folder, side)
    _each(boards[_middle(rng, boards) :], change)
    for name in _sets(folder):
        if name != "calibration":
            _each(_files(folder, side, name), change)


def _camera_moved(folder, rng, calibration):
    _from_a_pair_on(folder, rng, calibration, 0.5, 1.0)


def _camera_zoomed(folder, rng, calibration):
    _from_a_pair_on(folder, rng, calibration, 0.0, 1.01)


def _stabilised(folder, rng, calibration):
    for side in SIDES:
        for file in _files(folder, side):
            shift = np.array([[1, 0, rng.normal(0, 3)], [0, 1, rng.normal(0, 3)]])
            _each([file], lambda image, m=shift: cv2.warpAffine(image, m, image.shape[1::-1], flags=cv2.INTER_CUBIC))


def _blur(folder, rng, calibration):
    for side in SIDES:
        _each(_files(folder, side), lambda image: cv2.GaussianBlur(image, (0, 0), 2.5))


def _over_exposed(folder, rng, calibration):
    for side in SIDES:
        _each(_files(folder, side), lambda image: cv2.convertScaleAbs(image, alpha=2.2))


def _compressed(folder, rng, calibration):
    for side in SIDES:
        _each(_files(folder, side), lambda image: image, quality=8)


def _picture_sizes(folder, rng, calibration):
    _each(_files(folder, "right"), lambda image: cv2.resize(image, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA))


def _half_missing(folder, rng, calibration):
    right = _files(folder, "right")
    right[int(rng.integers(len(right)))].unlink()


def _too_few_pairs(folder, rng, calibration):
    left, right = (_files(folder, side) for side in SIDES)
    kept = set(rng.choice(len(left), 5, replace=False).tolist())
    for k, pair in enumerate(zip(left, right, strict=True)):
        if k not in kept:
            for file in pair:
                file.unlink()


# What is written in recording.json.


def _rewrite(folder, change):
    path = folder / "recording.json"
    facts = json.loads(path.read_text(encoding="utf-8"))
    change(facts["board"], facts["ball"])
    path.write_text(json.dumps(facts, indent=1), encoding="utf-8")


def _squares_counted(folder, rng, calibration):
    _rewrite(folder, lambda board, ball: board.update(columns=board["columns"] + 1, rows=board["rows"] + 1))


def _board_size(folder, rng, calibration):
    _rewrite(folder, lambda board, ball: board.update(columns=board["columns"] - 1))


def _square_unit(folder, rng, calibration):
    factor = float(rng.choice([0.1, 1 / 25.4, 0.001]))
    _rewrite(folder, lambda board, ball: board.update(square_mm=board["square_mm"] * factor))


def _square_scale(folder, rng, calibration):
    factor = float(rng.choice([0.96, 0.98, 1.02, 1.04]))
    _rewrite(folder, lambda board, ball: board.update(square_mm=board["square_mm"] * factor))


def _ball_diameter(folder, rng, calibration):
    _rewrite(folder, lambda board, ball: ball.update(diameter_mm=ball["diameter_mm"] * 1.3))


def _color_wrong(folder, rng, calibration):
    _rewrite(folder, lambda board, ball: ball.update(color="blue" if ball["color"] != "blue" else "red"))


# What was measured with a ruler.


def _retype(folder, name, change):
    """Change the lines of one table."""
    path = folder / name / "measured.csv"
    if not path.is_file():
        return
    rows = list(csv.DictReader(io.StringIO(path.read_text(encoding="utf-8"))))
    change(rows)
    out = io.StringIO(newline="")
    table = csv.DictWriter(out, list(rows[0]), lineterminator="\n")
    table.writeheader()
    table.writerows(rows)
    path.write_text(out.getvalue(), encoding="utf-8")


def _everywhere(change):
    """A fault that changes every line of every table."""

    def fault(folder, rng, calibration):
        for name in SETS:
            _retype(
                folder, name, lambda rows: [row.update(change({k: float(row[k]) for k in NUMBERS})) for row in rows]
            )

    return fault


def _typing_slip(folder, rng, calibration):
    """One digit of one depth is left out; the first one stays."""

    def slip(rows):
        row = rows[int(rng.integers(len(rows)))]
        digits = row["depth_mm"].split(".")[0]
        k = int(rng.integers(1, len(digits)))
        row["depth_mm"] = digits[:k] + digits[k + 1 :]

    _retype(folder, str(rng.choice(["position", "depth"])), slip)


def _plane(folder, rng, calibration):
    _retype(folder, "depth", lambda rows: [row.update(depth_mm=float(row["depth_mm"]) + 25) for row in rows])


FAULTS: dict[str, Spoiler] = {
    "sides_swapped": _sides_swapped, "cameras_exchanged": _cameras_exchanged, "pairs_shifted": _pairs_shifted,
    "pairs_do_not_match": _pairs_do_not_match, "not_together": _not_together, "mirrored": _mirrored,
    "both_mirrored": _both_mirrored, "upside_down": _upside_down, "both_upside_down": _both_upside_down,
    "camera_moved": _camera_moved, "camera_zoomed": _camera_zoomed, "stabilised": _stabilised, "blur": _blur,
    "over_exposed": _over_exposed, "compressed": _compressed, "picture_sizes": _picture_sizes, "half_missing": _half_missing,
    "too_few_pairs": _too_few_pairs, "squares_counted": _squares_counted, "board_size": _board_size,
    "square_unit": _square_unit, "square_scale": _square_scale, "ball_diameter": _ball_diameter, "color_wrong": _color_wrong,
    "columns_exchanged": _everywhere(lambda m: {"x_mm": m["y_mm"], "y_mm": m["x_mm"]}),
    "sign": _everywhere(lambda m: {"y_mm": -m["y_mm"]}),
    "unit": _everywhere(lambda m: {name: m[name] / 10 for name in NUMBERS}),
    "typing_slip": _typing_slip, "plane": _plane,
}  # fmt: skip

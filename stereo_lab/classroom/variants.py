"""A recording for each seat: a shipped one with other boards and balls in it, of another size, before another arm."""

from __future__ import annotations

import csv
import io
import shutil
from pathlib import Path
from typing import Any

import numpy as np

from stereo_lab.calibration import calibrate_recording
from stereo_lab.classroom.papers import LAST_SEAT
from stereo_lab.common.files import read_json, whole_folder, write_json, write_whole
from stereo_lab.errors import StereoLabError
from stereo_lab.recording import Recording, open_recording
from stereo_lab.recording.importing import check_new
from stereo_lab.recording.places import course

BASES = ("bench", "second_rig")  # neighbours have different ones
GOLDEN = 0.6180339887  # steps of it, over 1, lie far from each other
SIZES = (0.9, 1.1)  # so much larger or smaller a bench may be: of pictures alone nobody sees it
LENGTHS = (0.94, 1.06)  # the same of the links of its arm, one by one
SETS = ("calibration", "position", "depth", "evaluation")


def make_variant(seat: int, out: Path) -> Recording:
    """Make the recording of a seat; the same seat gives the same recording.

    The pictures are those of a shipped recording. Boards and balls are chosen anew. All lengths are those of a bench that is some
    per cent larger or smaller: nothing in the pictures changes by that, and every millimetre does.

    Parameters
    ----------
    seat : int, 0 to 9999
    out : Path, a folder that is new

    Raises
    ------
    StereoLabError
        If the seat is none, the folder is there already, or the disk is full.
    """
    if not 0 <= seat <= LAST_SEAT:
        raise StereoLabError(f"Expected the number of a seat, 0 to {LAST_SEAT}; got {seat}.")
    check_new(out)
    with whole_folder(out) as part:
        _fill(seat, open_recording(course() / "data" / BASES[seat % len(BASES)]), part)
        calibrate_recording(open_recording(part)).save(part / "calibration.json")
    return open_recording(out.resolve())


def _fill(seat, base, out):
    """Write pictures, tables, truth and what recording.json says."""
    rng = np.random.default_rng([seat, 18])
    facts = read_json(base.path / "recording.json")
    low, high = SIZES
    square = round(base.board.square_mm * (low + (high - low) * (seat * GOLDEN % 1)), 1)
    size = square / base.board.square_mm
    truth: dict[str, Any] = {"cameras": _larger_cameras(base.truth["cameras"], size), "sets": {}}
    for name in SETS:
        chosen = _choose(base, name, rng)
        for side in ("left", "right"):
            (out / name / side).mkdir(parents=True)
            for k, pair in enumerate(chosen):
                path = pair.left_path if side == "left" else pair.right_path
                shutil.copyfile(path, out / name / side / f"{k:03d}{path.suffix}")
        if base.has_samples(name):
            _write_samples(base, name, chosen, size, out)
            truth["sets"][name] = {
                f"{k:03d}": _larger_ball(base.true_ball(name, p.name), size) for k, p in enumerate(chosen)
            }
    write_json(out / "truth.json", truth)
    write_json(out / "recording.json", _facts(facts, base, seat, square, size, rng))


def _facts(facts, base, seat, square, size, rng):
    l1, l2 = (int(round(length * size * rng.uniform(*LENGTHS))) for length in (base.arm.l1_mm, base.arm.l2_mm))
    return {
        **facts,
        "title": f"{base.title}; seat {seat}",
        "seat": seat,
        "board": {**facts["board"], "square_mm": square},
        "ball": {**facts["ball"], "diameter_mm": round(base.ball.diameter_mm * size, 4)},
        "arm": {**facts["arm"], "l1_mm": l1, "l2_mm": l2, "depth_mm": round(base.arm_depth_mm * size, 4)},
    }


def _choose(base, name, rng):
    """Pairs of a set: boards and judging balls are drawn, in any order; those to be fitted on stay, for they were set out with care."""
    pairs = base.pairs(name)
    if name in ("position", "depth"):
        return pairs
    count = len(pairs) - 4 if name == "calibration" else 3 * len(pairs) // 4
    return [pairs[k] for k in rng.permutation(len(pairs))[:count]]


def _write_samples(base, name, chosen, size, out):
    """The table of what a ruler said, on a bench of that size."""
    known = {sample.pair.name: sample for sample in base.samples(name)}
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(("name", "x_mm", "y_mm", "depth_mm", "use"))
    for k, pair in enumerate(chosen):
        if pair.name in known:
            place = known[pair.name].measured
            numbers = (round(size * mm, 1) for mm in (place.x_mm, place.y_mm, place.depth_mm))
            table.writerow((f"{k:03d}", *numbers, known[pair.name].use))
    write_whole(out / name / "measured.csv", text.getvalue())


def _larger_cameras(cameras, size):
    return {side: {**its, "position_mm": [size * mm for mm in its["position_mm"]]} for side, its in cameras.items()}


def _larger_ball(entry, size):
    return None if entry is None else {**entry, "ball": [size * mm for mm in entry["ball"]]}

"""The commands of the cameras: demo, calibrate, detect, import, render."""

from __future__ import annotations

import argparse
import os
import sys
import time
from pathlib import Path

from stereo_lab.cli.terminal import OK, WANTING, Progress, me, write_json_option
from stereo_lab.errors import StereoLabError


def run_demo(options: argparse.Namespace) -> int:
    """Run the whole chain on a recording and write its report; WANTING where the calibration is poor."""
    os.environ.setdefault("MPLBACKEND", "agg")  # figures go to a file: no window is needed, nor a screen
    from stereo_lab.recording import open_recording
    from stereo_lab.results import report
    from stereo_lab.results.evaluation import evaluate

    recording = open_recording(options.recording)
    quiet = options.json == "-"
    say = (lambda *_: None) if quiet else print
    say(f"{recording.title}\n({report.kind_of(recording)}; {recording.path})\n")
    with Progress() as progress:
        results = evaluate(recording, progress)
    say(f"Calibration: {results.calibration_source}.\n")
    say(report.page(results))
    report.write(results, options.report)
    say(f"\nThe pictures of this run: {Path(options.report).resolve()}")
    write_json_option(options.json, results.facts())
    return WANTING if results.calibration.verdict == "poor" else OK


def run_calibrate(options: argparse.Namespace) -> int:
    """Calibrate the cameras of a recording and print what it is worth; WANTING where it is poor."""
    from stereo_lab.calibration import boards_of, calibrate_anew
    from stereo_lab.common.files import check_target
    from stereo_lab.recording import open_recording, swap_sides
    from stereo_lab.results import report

    recording = open_recording(options.recording)
    if options.report:
        check_target(options.report)
    if options.swap:
        alone = swap_sides(boards_of(recording))
        print("The folders left and right are swapped.", file=sys.stderr)
        if alone:
            print(f"Pictures of one camera alone stay as they are: {', '.join(alone)}.", file=sys.stderr)
    with Progress() as progress:
        result = calibrate_anew(recording, lambda done, total: progress("find the boards", done, total))
    if options.json != "-":
        print(*report.calibration_lines(result), sep="\n")
    if options.report:
        report.write_calibration(result, recording, options.report)
    if options.save:
        result.save(options.save)
    if options.keep:
        result.save(boards_of(recording).path / "calibration.json")
    write_json_option(options.json, result.facts())
    return WANTING if result.verdict == "poor" else OK


def run_detect(options: argparse.Namespace) -> int:
    """Find the ball in pictures and print where it is. The exit code is OK."""
    from stereo_lab.detection import BallColor, BallDetector
    from stereo_lab.recording import read_image

    color = _color_from(options.color_from) if options.color_from else BallColor.named(options.color)
    detector = BallDetector(color, options.method)
    images = [(path, read_image(path)) for path in options.images]
    rows = []
    for path, image in images:
        start = time.perf_counter()
        found = detector.detect(image)
        ms = round(1000 * (time.perf_counter() - start), 2)
        ball = (
            None if found is None else {k: round(float(getattr(found, k)), 3) for k in ("u", "v", "radius_px", "score")}
        )
        rows.append({"file": str(path), "ms": ms, "detection": ball})
        if options.json != "-":
            place = "no ball" if found is None else f"u {found.u:.1f}  v {found.v:.1f}  radius {found.radius_px:.1f} px"
            print(f"{path}: {place}")
    write_json_option(options.json, rows)
    return OK


def _color_from(path):
    """Learn a colour from a table file,u,v,radius_px; rows without a ball are passed over."""
    from stereo_lab.common.files import finite_number, read_table
    from stereo_lab.detection import BallColor
    from stereo_lab.recording import read_image

    images, circles = [], []
    for where, row in read_table(path, ("file", "u", "v", "radius_px")):
        if not (row["u"] or "").strip():
            continue
        circle = [finite_number(row[k], f"{where}, {k}") for k in ("u", "v", "radius_px")]
        if circle[2] <= 0:
            raise StereoLabError(f"{where}, radius_px: expected a number above zero, got {row['radius_px']!r}.")
        images.append(read_image(Path(path).parent / (row["file"] or "").strip()))
        circles.append(circle)
    return BallColor.from_samples(images, circles)


WAYS = ("across", "down")


def run_import(options: argparse.Namespace) -> int:
    """Make a recording from board pictures taken elsewhere. The exit code is OK."""
    from stereo_lab.recording import Ball, Board, import_images
    from stereo_lab.recording.bounds import color_name, corner_count, length_mm

    parts = options.board.lower().replace("×", "x").split("x")
    if len(parts) != 2:
        raise StereoLabError(f"--board: expected columns x rows of inner corners, as in 9x6; got {options.board!r}.")
    columns, rows = (corner_count(p, f"--board, inner corners {way}") for p, way in zip(parts, WAYS, strict=True))
    board = Board(columns, rows, length_mm(options.square_mm, "--square-mm"))
    ball = Ball(color_name(options.ball_color, "--ball-color"), length_mm(options.ball_mm, "--ball-mm"))
    recording = import_images(options.left, options.right, board, options.out, ball)
    pairs = recording.pairs("calibration")
    print(f"{recording.path}: {len(pairs)} pairs of {recording.image_size[0]}x{recording.image_size[1]} pixels.")
    print(f"Next: {me()} calibrate {options.out}")
    write_json_option(
        options.json, {"path": str(recording.path), "pairs": len(pairs), "image_size": list(recording.image_size)}
    )
    return OK


def run_render(options: argparse.Namespace) -> int:
    """Render a recording by a rig of ``data/render``. The exit code is OK."""
    from stereo_lab.recording import REPOSITORY

    folder = REPOSITORY / "data" / "render"
    rigs = sorted(p.stem for p in (folder / "rigs").glob("*.json"))
    if options.name not in rigs and not Path(options.name).is_file():
        raise StereoLabError(f"There is no rig {options.name!r}. Choose one of {', '.join(rigs)}, or name a rig file.")
    sys.path.insert(0, str(folder))
    try:
        import record
    except ModuleNotFoundError as error:
        raise StereoLabError(
            f"Rendering needs {error.name}, which is an extra: .venv/bin/python -m pip install mitsuba==3.9.1"
        ) from None
    out = Path(options.out) if options.out else REPOSITORY / "data" / Path(options.name).stem
    with Progress() as progress:
        record.record(
            options.name, out, options.seed, options.sets.split(",") if options.sets else None,
            lambda done, total, what: progress(what, done, total),
        )  # fmt: skip
    print(f"{out} is complete (a rendered recording).")
    write_json_option(options.json, {"path": str(out)})
    return OK

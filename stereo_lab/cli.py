"""The command ``stereo-lab``."""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

from stereo_lab.errors import StereoLabError

OK, WANTING, BAD_INPUT, STOPPED = 0, 1, 2, 130


def main(arguments=None):
    """Run one command; returns the exit code 0 (done), 1 (found wanting) or 2 (bad usage or input)."""
    options = _parser().parse_args(arguments)
    try:
        return options.run(options)
    except StereoLabError as error:
        _clear_line()
        print(f"stereo-lab: {error}", file=sys.stderr)
        return BAD_INPUT
    except OSError as error:
        _clear_line()
        print(f"stereo-lab: {error.filename or ''} {error.strerror or error}".strip(), file=sys.stderr)
        return BAD_INPUT
    except KeyboardInterrupt:
        _clear_line()
        print("stereo-lab: stopped; nothing is left half written.", file=sys.stderr)
        return STOPPED


def _parser():
    parser = argparse.ArgumentParser(
        prog="stereo-lab", description="See in 3D with two webcams: calibrate, find the ball, locate it."
    )
    commands = parser.add_subparsers(required=True, metavar="COMMAND")

    def add(name, run, text, example, **more):
        epilog = f"example:  stereo-lab {example}"
        command = commands.add_parser(name, help=text, description=text, epilog=epilog, **more)
        command.set_defaults(run=run)
        return command

    demo = add(
        "demo",
        _demo,
        "Run the whole chain on a recording, beside the paper's numbers.",
        "demo bench --report demo.html",
    )
    _add_recording(demo)
    demo.add_argument(
        "--report", metavar="FILE", default="demo.html", help="picture report to write (default: %(default)s)"
    )

    calibrate = add(
        "calibrate", _calibrate, "Calibrate the two cameras of a recording.", "calibrate data/bench --json cal.json"
    )
    _add_recording(calibrate)
    calibrate.add_argument("--save", metavar="FILE", help="write the calibration itself, to be loaded in Python")

    detect = add("detect", _detect, "Find the ball in pictures.", "detect data/bench/snaps/left/000.jpg --color red")
    detect.add_argument("images", nargs="+", metavar="IMAGE")
    colors = detect.add_mutually_exclusive_group()
    colors.add_argument("--color", default="red", help="red, orange, yellow, green or blue (default: %(default)s)")
    colors.add_argument("--color-from", metavar="CSV", help="learn the colour from marked balls: file,u,v,radius_px")
    detect.add_argument("--method", choices=("paper", "cone"), default="cone")
    _add_json(detect)

    bring = add(
        "import", _import, "Make a recording from board pictures you have.",
        'import --left "shots/left*.jpg" --right "shots/right*.jpg" --board 9x6 --square-mm 25 --out data/mine',
    )  # fmt: skip
    bring.add_argument("--left", required=True, metavar="GLOB", help="pattern of the left pictures, in quotes")
    bring.add_argument("--right", required=True, metavar="GLOB")
    bring.add_argument("--board", required=True, metavar="9x6", help="inner corners, columns x rows")
    bring.add_argument("--square-mm", required=True, metavar="MM", help="side of one square in millimetres")
    bring.add_argument("--out", required=True, metavar="DIR", help="folder to make")
    bring.add_argument("--ball-color", default="red", metavar="NAME")
    bring.add_argument("--ball-mm", default="40", metavar="MM", help="diameter of the ball (default: %(default)s)")
    _add_json(bring)

    render = add(
        "render",
        _render,
        "Make a shipped recording again (needs the extra: render).",
        "render bench --out /tmp/bench --seed 7",
    )
    render.add_argument("name", metavar="NAME", help="bench, clutter, second_rig, or a rig file of your own (.json)")
    render.add_argument("--out", metavar="DIR", help="folder to make (default: data/NAME)")
    render.add_argument("--seed", type=int, help="other poses and other noise")
    render.add_argument("--sets", metavar="SET,SET", help="only these sets")
    _add_json(render)

    arm = add(
        "arm",
        _arm,
        "Talk to an arm: list the ports, or name one and say what to do. Only home, move and calibrate move it.",
        "arm virtual://arm move 30 45",
    )
    arm.add_argument("url", metavar="list|URL", help="list, or a port: virtual://arm, COM3, /dev/ttyUSB0, socket://…")
    arm.add_argument(
        "action", nargs="?", default="status", choices=("status", "home", "move", "calibrate", "monitor"),
        help="what to do (default: %(default)s)",
    )  # fmt: skip
    arm.add_argument("angles", nargs="*", metavar="DEGREES", help="for move: shoulder and elbow")
    arm.add_argument("--seconds", type=float, default=None, metavar="S", help="for monitor: stop after so long")
    _add_json(arm)

    test = add("test", _test, "Run the tests: package and notebooks.", "test")
    test.add_argument("--all", action="store_true", help="everything that continuous integration runs")
    return parser


def _add_recording(parser):
    parser.add_argument(
        "recording", nargs="?", metavar="REC",
        help="folder or name of a recording (default: $STEREO_LAB_RECORDING, else the shipped bench)",
    )  # fmt: skip
    _add_json(parser)


def _add_json(parser):
    parser.add_argument("--json", metavar="FILE", help="write the numbers as JSON; - for the terminal")


# --- commands -----------------------------------------------------------------------------------------


def _demo(options):
    from stereo_lab import report
    from stereo_lab.evaluation import evaluate
    from stereo_lab.recording import open_recording

    recording = open_recording(options.recording)
    quiet = options.json == "-"
    say = (lambda *_: None) if quiet else print
    kind = "rendered recording: made by a renderer, not by cameras" if recording.rendered else "camera recording"
    say(f"{recording.title}\n({kind}; {recording.path})\n")
    with Progress() as progress:
        results = evaluate(recording, progress)
    say(report.page(results))
    report.write(results, options.report)
    say(f"\nThe pictures of this run: {Path(options.report).resolve()}")
    _write_json(options.json, results.facts())
    return WANTING if results.calibration.verdict == "poor" else OK


def _calibrate(options):
    from stereo_lab.calibration import calibrate_recording
    from stereo_lab.recording import open_recording

    recording = open_recording(options.recording)
    with Progress() as progress:
        result = calibrate_recording(recording, lambda done, total: progress("find the boards", done, total))
    if options.json != "-":
        print(f"{len(result.used)} of {result.pairs} pairs used; boards found in {result.found}.")
        for name, why in result.dropped:
            print(f"  without {name}: {why}")
        print(
            f"reprojection error  {result.rms_px:.3f} px (left alone {result.left_rms_px:.3f}, right {result.right_rms_px:.3f})"
        )
        print(f"rows after rectification match to {result.vertical_error_px:.3f} px")
        if result.heldout_vertical_error_px is not None:
            print(
                f"on unseen pairs     {result.heldout_vertical_error_px:.3f} px, "
                f"lengths off by {result.heldout_length_error_percent:.2f} %"
            )
        print(f"baseline            {result.baseline_mm:.2f} mm, focal length {result.focal_px:.1f} px (rectified)")
        print(f"the board is bent by {result.board_bend_mm:.2f} mm; lens model: {result.lens}")
        print(f"\nverdict: {result.verdict}")
        for reason in result.reasons:
            print(f"  {reason}")
    if options.save:
        result.save(options.save)
    _write_json(options.json, result.facts())
    return WANTING if result.verdict == "poor" else OK


def _detect(options):
    from stereo_lab.detection import BallColor, BallDetector
    from stereo_lab.pictures import read_image

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
    _write_json(options.json, rows)
    return OK


def _color_from(path):
    """Learn a colour from a table file,u,v,radius_px; rows without a ball are passed over."""
    from stereo_lab.detection import BallColor
    from stereo_lab.files import finite_number, read_table
    from stereo_lab.pictures import read_image

    images, circles = [], []
    for where, row in read_table(path, ("file", "u", "v", "radius_px")):
        if not (row["u"] or "").strip():
            continue
        circle = [finite_number(row[k], f"{where}, {k}") for k in ("u", "v", "radius_px")]
        if circle[2] <= 0:
            raise StereoLabError(f"{where}, radius_px: expected a number above zero, got {row['radius_px']!r}.")
        images.append(read_image(Path(path).parent / row["file"].strip()))
        circles.append(circle)
    return BallColor.from_samples(images, circles)


def _import(options):
    from stereo_lab.files import finite_number
    from stereo_lab.recording import Ball, Board, import_images

    parts = options.board.lower().replace("×", "x").split("x")
    if len(parts) != 2 or not all(p.strip().isdigit() and int(p) >= 2 for p in parts):
        raise StereoLabError(f"--board: expected columns x rows of inner corners, as in 9x6; got {options.board!r}.")
    square, diameter = (
        finite_number(v, n) for v, n in ((options.square_mm, "--square-mm"), (options.ball_mm, "--ball-mm"))
    )
    if square <= 0 or diameter <= 0:
        raise StereoLabError("--square-mm and --ball-mm: expected numbers above zero.")
    board = Board(int(parts[0]), int(parts[1]), square)
    recording = import_images(
        options.left, options.right, board, options.out, Ball(options.ball_color.lower(), diameter)
    )
    pairs = recording.pairs("calibration")
    print(f"{recording.path}: {len(pairs)} pairs of {recording.image_size[0]}x{recording.image_size[1]} pixels.")
    print(f"Next: {_me()} calibrate {options.out}")
    _write_json(
        options.json, {"path": str(recording.path), "pairs": len(pairs), "image_size": list(recording.image_size)}
    )
    return OK


def _render(options):
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
    _write_json(options.json, {"path": str(out)})
    return OK


def _arm(options):
    from stereo_lab.arm import connect, ports

    if options.url == "list":
        for name, description in ports():
            print(f"{name:20s} {description}")
        _write_json(options.json, [{"port": name, "description": text} for name, text in ports()])
        return OK
    if (options.action == "move") != bool(options.angles):
        raise StereoLabError("Expected two angles after move and none otherwise, as in: arm virtual://arm move 30 45")
    quiet = contextlib.redirect_stdout(sys.stderr) if options.json == "-" else contextlib.nullcontext()
    with connect(options.url) as arm, quiet:
        facts = ARM_ACTIONS[options.action](arm, options)
    _write_json(options.json, facts)
    return OK


def _arm_status(arm, options):
    status = arm.status()
    print(f"{arm.name}: {status.state}, joints at {_degrees(status.position_deg)}")
    if not all(status.homed):
        print("not homed since it was switched on: the angles count from where the joints stood then.")
    low_high = "; ".join(f"joint {k} turns from {low:g} to {high:g}" for k, (low, high) in enumerate(arm.limits_deg, 1))
    print(f"{low_high} degrees; supply {arm.supply_v:g} V")
    return {"state": status.state, "angles_deg": list(status.position_deg), "homed": list(status.homed)}


def _arm_home(arm, options):
    print("The arm moves: homing both joints …", flush=True)
    reached = arm.home()
    print(f"homed; joints at {_degrees((reached.theta1_deg, reached.theta2_deg))}")
    return {"angles_deg": [reached.theta1_deg, reached.theta2_deg]}


def _arm_move(arm, options):
    from stereo_lab.files import finite_number
    from stereo_lab.kinematics import JointAngles

    if len(options.angles) != 2:
        raise StereoLabError(f"move: expected two angles, shoulder and elbow; got {len(options.angles)}.")
    goal = JointAngles(*(finite_number(word, f"move, joint {k}") for k, word in enumerate(options.angles, 1)))
    if not arm.homed:
        print("stereo-lab: not homed; the angles count from where the joints stand now.", file=sys.stderr)
    reached = arm.move_to(goal)
    print(f"reached {_degrees((reached.theta1_deg, reached.theta2_deg))}")
    return {"angles_deg": [reached.theta1_deg, reached.theta2_deg]}


def _arm_calibrate(arm, options):
    facts = {}
    print("The arm moves: each motor is pushed to and fro …", flush=True)
    for joint in (1, 2):
        found = arm.calibrate(joint)
        for name, fit in (("counter-clockwise", found.ccw), ("clockwise", found.cw)):
            print(
                f"joint {joint} {name:17s}  turns from {fit.starts_at_v:.2f} V, {fit.speed_per_volt:.0f} deg/s per volt "
                f"above {fit.dead_band_v:.2f} V, time constant {1000 * fit.time_constant_s:.0f} ms"
            )
            facts[f"joint {joint} {name}"] = {
                "starts_at_v": fit.starts_at_v, "dead_band_v": fit.dead_band_v, "speed_per_volt": fit.speed_per_volt,
                "time_constant_s": fit.time_constant_s, "worst_residual_deg": float(abs(fit.residuals_deg).max()),
            }  # fmt: skip
    print("The controller keeps these until it is switched off.")
    return facts


def _arm_monitor(arm, options):
    seconds = options.seconds
    print("Every line is a look at the arm; Ctrl-C ends it.")
    start = time.monotonic()
    rows = []
    while seconds is None or time.monotonic() - start < seconds:
        status = arm.status()
        rows.append({"state": status.state, "angles_deg": list(status.position_deg), "time_ms": status.time_ms})
        print(f"{status.time_ms / 1000:8.1f} s  {status.state:5s} {_degrees(status.position_deg)}", flush=True)
        arm.wait(0.2)
        time.sleep(0.2 if hasattr(arm.port, "link_deg") else 0)  # a virtual arm's time is not ours
        del rows[:-1000]
    return rows


def _degrees(angles):
    return ", ".join(f"{angle:.2f}" for angle in angles) + " degrees"


ARM_ACTIONS = {
    "status": _arm_status, "home": _arm_home, "move": _arm_move, "calibrate": _arm_calibrate, "monitor": _arm_monitor,
}  # fmt: skip


def _test(options):
    from stereo_lab.recording import REPOSITORY

    command = [sys.executable, "-m", "pytest", "-q", "--nbval", "--nbval-cell-timeout=120", "tests", "notebooks"]
    if not options.all:
        command += ["-m", "not slow"]
    return subprocess.run(command, cwd=REPOSITORY).returncode


# --- the terminal ---------------------------------------------------------------------------------------


class Progress:
    """A progress line on the terminal, kept off files and pipes."""

    def __init__(self):
        self._shown = 0.0
        self._on = sys.stderr.isatty()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        _clear_line()

    def __call__(self, step, done, total):
        now = time.monotonic()
        if not self._on or (done < total and now - self._shown < 0.1):
            return
        self._shown = now
        filled = round(24 * done / max(total, 1))
        print(
            f"\r\033[K  [{'#' * filled}{'.' * (24 - filled)}] {done}/{total}  {step}",
            end="",
            file=sys.stderr,
            flush=True,
        )


def _clear_line():
    if sys.stderr.isatty():
        print("\r\033[K", end="", file=sys.stderr, flush=True)


def _write_json(path, content):
    from stereo_lab.files import write_json

    if path == "-":
        print(json.dumps(content, indent=1))
    elif path:
        write_json(path, content)


def _me():
    """How the person called the kit: by lab.py, or by the command itself."""
    return os.environ.get("STEREO_LAB_COMMAND") or (shutil.which("stereo-lab") and "stereo-lab") or "python3 lab.py"

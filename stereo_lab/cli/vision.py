"""The commands of the cameras: demo, calibrate, detect, render."""

from __future__ import annotations

import argparse
import contextlib
import os
import sys
import time
from pathlib import Path

from stereo_lab.cli.options import Add, add_json, add_recording, whole
from stereo_lab.cli.terminal import BAD_INPUT, OK, WANTING, Progress, write_json_option
from stereo_lab.common.files import typed
from stereo_lab.common.packages import to_install
from stereo_lab.errors import RecordingError, StereoLabError, SwappedSidesError

FRAMES_LEARNED = 60  # of a video: enough that some show the ball clearly
MOST_CORES = 4  # each holds 100 MB


def add_to(add: Add) -> None:
    """The commands and their options."""
    demo = add(
        "demo", run_demo, "Run the whole chain on a recording, beside the paper's numbers.", "demo bench --report demo.html"
    )  # fmt: skip
    add_recording(demo)
    demo.add_argument(
        "--report", metavar="FILE", default="demo.html", help="picture report to write (default: %(default)s)"
    )

    calibrate = add(
        "calibrate", run_calibrate, "Calibrate the two cameras of a recording.", "calibrate data/bench --json cal.json"
    )
    add_recording(calibrate)
    calibrate.add_argument("--save", metavar="FILE", help="write the calibration itself, to be loaded in Python")
    calibrate.add_argument("--report", metavar="FILE", help="picture of where the calibration knows least, as HTML")
    calibrate.add_argument(
        "--keep", action="store_true", help="write it into the recording, beside its boards, so that whoever gets the folder starts with it"
    )  # fmt: skip
    calibrate.add_argument(
        "--swap", action="store_true",
        help="first rename the folders left and right of every set into each other, for cameras named the wrong way round",
    )  # fmt: skip

    detect = add(
        "detect", run_detect, "Find the ball in pictures and videos.", "detect data/bench/snaps/left/000.jpg --color red"
    )  # fmt: skip
    detect.description = (
        f"{detect.description} Its centre is told in pixels, u to the right and v down from the middle of the top left pixel; "
        "radius is the one that it would have in the middle of the picture."
    )
    detect.add_argument(
        "images", nargs="+", metavar="IMAGE", help="a picture or a film, a pattern, or a folder of pictures"
    )
    detect.add_argument(
        "--learn", action="store_true", help="let the surest balls of that colour mark themselves, and learn from them"
    )
    colors = detect.add_mutually_exclusive_group()
    colors.add_argument(
        "--color",
        default="red",
        help="red, orange, yellow, green, blue, or a file that train wrote (default: %(default)s)",
    )
    colors.add_argument(
        "--color-from",
        metavar="CSV",
        help="learn the colour from balls that you marked, near and far: file,u,v,radius_px",
    )
    detect.add_argument(
        "--method", choices=("paper", "cone"), default="cone",
        help="the paper's circles, or the cone of rays that touch the ball (default: %(default)s)",
    )  # fmt: skip
    add_json(detect)

    render = add(
        "render", run_render, "Make a shipped recording again (needs the extra: render).",
        "render bench --out /tmp/bench --seed 7",
    )  # fmt: skip
    render.add_argument(
        "name",
        metavar="NAME",
        help="bench, clutter, clutter_test, second_rig, third_rig, or a rig file of your own (.json)",
    )
    render.add_argument("--out", metavar="DIR", help="folder to make (default: data/NAME)")
    render.add_argument("--seed", type=whole, help="other poses and other noise")
    render.add_argument("--sets", metavar="SET,SET", help="only these sets")
    add_json(render)


def run_demo(options: argparse.Namespace) -> int:
    """Run the whole chain on a recording and write its report; WANTING where the calibration is poor, or the places mislead."""
    os.environ.setdefault("MPLBACKEND", "agg")  # figures go to a file: no window is needed, nor a screen
    from stereo_lab.recording import open_recording
    from stereo_lab.results import report
    from stereo_lab.results.evaluation import evaluate

    recording = open_recording(options.recording)
    print(f"{recording.title}\n({report.kind_of(recording)}; {recording.path})\n")
    with Progress() as progress:
        results = evaluate(recording, progress, cores=min(os.cpu_count() or 1, MOST_CORES))
    print(f"Calibration: {results.calibration_source}.\n")
    print(report.page(results))
    report.write(results, options.report)
    print(f"\nThe pictures of this run: {Path(options.report).resolve()}")
    write_json_option(options.json, results.facts())
    return WANTING if results.calibration.verdict == "poor" or report.warnings(results) else OK


def run_calibrate(options: argparse.Namespace) -> int:
    """Calibrate the cameras of a recording and print what it is worth; WANTING where it is poor."""
    from stereo_lab.calibration import boards_of, calibrate_anew
    from stereo_lab.recording import open_recording
    from stereo_lab.results import report

    recording = open_recording(options.recording)
    with Progress() as progress, _swapped(recording) if options.swap else contextlib.nullcontext():
        result = calibrate_anew(recording, lambda done, total: progress("find the boards", done, total))
    print(*report.calibration_lines(result), sep="\n")
    if options.report:
        report.write_calibration(result, recording, options.report)
    kept = boards_of(recording).path / "calibration.json" if options.keep else None
    for file in filter(None, (options.save, kept)):
        result.save(file)
    for file in filter(None, (options.report, options.save, kept)):
        print(f"written: {file}")
    write_json_option(options.json, result.facts())
    return WANTING if result.verdict == "poor" else OK


@contextlib.contextmanager
def _swapped(recording):
    """Left and right exchanged; and back again where they turn out to have stood rightly, or nothing comes of it."""
    from stereo_lab.calibration import boards_of
    from stereo_lab.recording import swap_sides

    boards = boards_of(recording)
    if "calibration" not in boards.sets:
        raise StereoLabError(
            f"{boards.path} has no pictures of boards, so nothing tells which side is which, and nothing was renamed. Where "
            f"left and right are exchanged says: stereo-lab check {typed(recording.path)}"
        )
    theirs = [recording] if boards.path == recording.path else [boards, recording]
    alone = swap_sides(*theirs)
    named = " and ".join(str(each.path) for each in theirs)
    try:
        yield
    except SwappedSidesError:
        swap_sides(*theirs)
        raise StereoLabError(f"Left and right of {named} stood as they should: nothing was renamed.") from None
    except BaseException:
        swap_sides(*theirs)
        raise
    print(f"The folders left and right of {named} are swapped.", file=sys.stderr)
    if alone:
        print(f"Pictures of one camera alone stay as they are: {', '.join(alone)}.", file=sys.stderr)


def run_detect(options: argparse.Namespace) -> int:
    """Find the ball in pictures and print where it is. The exit code is BAD_INPUT where one cannot be read, else OK."""
    from stereo_lab.detection import BallDetector
    from stereo_lab.recording import is_video

    options.images = [file for word in options.images for file in _files(word)]
    detector = BallDetector(_color(options, [path for path in options.images if not is_video(path)]), options.method)
    rows, code = [], OK
    for path in sorted(options.images, key=is_video):  # films last: they take long
        try:
            for row in _watched(path, detector) if is_video(path) else _pictured(path, detector):
                rows.append(row)  # one by one: a film that breaks off keeps those before
        except RecordingError as error:  # the others can be looked at all the same
            print(f"stereo-lab: {error}", file=sys.stderr)
            code = BAD_INPUT
    write_json_option(options.json, rows)
    return code


def _files(word):
    """A file, or those of a pattern, which the Windows prompt hands on as it is, or of a folder."""
    from stereo_lab.recording.importing import matching
    from stereo_lab.recording.model import pictures_in
    from stereo_lab.recording.strays import other_pictures_in

    if Path(word).is_dir():
        if there := pictures_in(Path(word)):
            return list(there.values())
        within = sorted(
            path for path in Path(word).glob("*/left") if path.is_dir() and path.parent.name != "calibration"
        )
        named = f" There are some in {within[0]}." if within else ""
        if others := other_pictures_in(Path(word)):
            kind = others[0].suffix
            named = f" There is {others[0].name}: name these files themselves, {Path(word) / ('*' + kind)}, or save them as .jpg or .png."
        raise StereoLabError(f"There are no pictures (.jpg or .png) in the folder {word}.{named}")
    return matching(word) if not Path(word).exists() and set(word) & set("*?[") else [word]


def _looked(detector, image, near=None):
    """One picture's row, and its ball."""
    start = time.perf_counter()
    found = detector.detect(image, near)
    ms = round(1000 * (time.perf_counter() - start), 2)
    told = ("u", "v", "radius_px", "score", "sigma_px")
    ball = found and {k: round(float(getattr(found, k)), 3) for k in told if getattr(found, k) is not None}
    return {"ms": ms, "detection": ball}, found


def _pictured(path, detector):
    """The row of a picture."""
    from stereo_lab.recording import read_image

    row, _ = _looked(detector, read_image(path))
    _say(str(path), row["detection"])
    yield {"file": str(path), **row}


def _watched(path, detector):
    """The rows of a video: each frame is first looked at where the ball was in the one before."""
    from stereo_lab.recording.pictures import is_colorless
    from stereo_lab.recording.video import count_frames, read_video

    total, near = count_frames(path), None
    with Progress() as progress:
        for number, frame in enumerate(read_video(path)):
            row, near = _looked(detector, frame, near)
            _say(f"{path}, frame {number}", row["detection"], near is None and is_colorless(frame))
            yield {"file": str(path), "frame": number, **row}
            progress(f"look at {path}", number + 1, max(total, number + 1))


def _say(what, ball, grey=False):
    none = "no ball; this is a grey picture, and the ball is found by its colour" if grey else "no ball"
    place = f"u {ball['u']:.1f}  v {ball['v']:.1f}  radius {ball['radius_px']:.1f} px" if ball else none
    print(f"{what}: {place}")


def _color(options, pictures):
    """The colour asked for: marked in a table, by name, or by a name that marks itself in what is looked at."""
    from stereo_lab.detection import BallColor
    from stereo_lab.recording import read_image

    if options.color_from:
        if options.learn:
            raise StereoLabError(
                "With --color-from you mark the balls, with --learn they mark themselves. Choose one of the two."
            )
        return _color_from(options.color_from)
    if not options.learn:
        return BallColor.named(options.color)
    shown = [*map(read_image, pictures), *_some_frames(options.images)]
    learned = BallColor.learned(shown, options.color)
    print(
        f"The colour is learned from {len(learned.marks)} balls that are surest to be {options.color}:", file=sys.stderr
    )
    for number, u, v, radius in learned.marks:
        print(f"  picture {number + 1} of {len(shown)}: u {u:.0f}  v {v:.0f}  radius {radius:.0f} px", file=sys.stderr)
    return learned


def _some_frames(paths):
    """Frames spread over the videos among some files."""
    from stereo_lab.recording import is_video
    from stereo_lab.recording.video import count_frames, read_video

    for path in filter(is_video, paths):
        step = max(1, count_frames(path) // FRAMES_LEARNED)
        yield from (frame for number, frame in enumerate(read_video(path)) if number % step == 0)


def _color_from(path):
    """Learn a colour from a table file,u,v,radius_px; rows without a ball are passed over."""
    from stereo_lab.common.files import finite_number
    from stereo_lab.common.spreadsheets import read_table
    from stereo_lab.detection import BallColor, BallDetector
    from stereo_lab.recording import read_image
    from stereo_lab.results.evaluation import is_hit

    images, circles, lines = [], [], []
    for where, row in read_table(path, ("file", "u", "v", "radius_px")):
        if not (row["u"] or "").strip():
            continue
        circle = [finite_number(row[k], f"{where}, {k}") for k in ("u", "v", "radius_px")]
        if circle[2] <= 0:
            raise StereoLabError(f"{where}, radius_px: expected a number above zero, got {row['radius_px']!r}.")
        images.append(read_image(Path(path).parent / (row["file"] or "").strip()))
        circles.append(circle)
        lines.append(where)
    color = BallColor.from_samples(images, circles)
    seen = map(BallDetector(color).detect, images)
    missed = [line for line, ball, circle in zip(lines, seen, circles, strict=True) if not is_hit(ball, circle)]
    if missed:
        print(
            f"By the colour that these marks tell, no ball is found at {len(missed)} of {len(lines)} of them. Are u and v right, and is "
            f"each line that of its own picture? {'; '.join(missed)}",
            file=sys.stderr,
        )
    return color


def run_render(options: argparse.Namespace) -> int:
    """Render a recording by a rig of ``data/render``. The exit code is OK."""
    from stereo_lab.recording.places import REPOSITORY, is_repository

    if not is_repository():
        raise StereoLabError("The renderer comes with the kit's own folder, not with an installed package.")
    folder = REPOSITORY / "data" / "render"
    rigs = sorted(p.stem for p in (folder / "rigs").glob("*.json"))
    if options.name not in rigs and not Path(options.name).is_file():
        raise StereoLabError(f"There is no rig {options.name!r}. Choose one of {', '.join(rigs)}, or name a rig file.")
    if Path(options.name).name == "recording.json":
        raise StereoLabError(
            f"{options.name} tells of a recording; expected a rig, one of {', '.join(rigs)}, or a rig file."
        )
    sys.path.insert(0, str(folder))
    try:
        import record
    except ModuleNotFoundError as error:
        raise StereoLabError(
            f"Rendering needs {error.name}, which is an extra: {to_install('mitsuba==3.9.1')}"
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

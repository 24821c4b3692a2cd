"""The commands that take over what was made elsewhere, and write it for elsewhere: import, export."""

from __future__ import annotations

import argparse
from pathlib import Path

from stereo_lab.cli.boards import ball_of_options, board_of_option, recording_begun
from stereo_lab.cli.options import Add, add_board, add_json, add_recording, whole
from stereo_lab.cli.terminal import OK, me, write_json_option
from stereo_lab.common.files import typed
from stereo_lab.errors import StereoLabError

OF_PICTURES = ("left", "right", "side-by-side", "every", "board", "square-mm", "marker-mm", "charuco", "dictionary")


def add_to(add: Add) -> None:
    """The commands and their options."""
    bring = add(
        "import", run_import, "Make a recording from board pictures you have, or take over a calibration made elsewhere.",
        'import --left "shots/left*.jpg" --right "shots/right*.jpg" --board 9x6 --square-mm 25 --out data/mine',
    )  # fmt: skip
    bring.add_argument(
        "--left", nargs="+", metavar="GLOB", help="pattern of the left pictures, or their folder; or a film"
    )
    bring.add_argument(
        "--every", type=whole, metavar="N", help="of a film: of N frames the one with the stillest board (10)"
    )
    bring.add_argument("--right", nargs="+", metavar="GLOB", help="the same of the right ones")
    bring.add_argument(
        "--side-by-side",
        nargs="+",
        metavar="GLOB",
        help="in the place of both: pictures that hold the left and the right one beside it",
    )
    bring.add_argument(
        "--board", metavar="9x6",
        help="columns x rows: of a chessboard its inner corners, of a ChArUco board its squares",
    )  # fmt: skip
    add_board(bring)
    bring.add_argument(
        "--calibration", nargs="+", metavar="FILE",
        help="in the place of pictures: OpenCV's YAML, or the left and the right camera_info of ROS; --out may be a recording "
        "that has no boards",
    )  # fmt: skip
    bring.add_argument("--unit", help="of OpenCV's translation: mm, cm, inch or m (default: as the file says, or mm)")
    bring.add_argument("--out", required=True, metavar="DIR", help="folder to make")
    bring.add_argument("--ball-color", metavar="NAME", help="of the ball (red, or that of the recording in --out)")
    bring.add_argument("--ball-mm", metavar="MM", help="diameter of the ball (40, or that of the recording in --out)")
    add_json(bring)

    export = add("export", run_export, "Write a calibration for other programs: OpenCV's YAML, and camera_info for ROS.",
        "export bench --out calibration",
    )  # fmt: skip
    export.add_argument(
        "--out", default="calibration", metavar="DIR", help="folder of the files (default: %(default)s)"
    )
    add_recording(export)


def run_import(options: argparse.Namespace) -> int:
    """Make a recording from board pictures taken elsewhere, or of a calibration made elsewhere. The exit code is OK."""
    from stereo_lab.recording import import_images, import_side_by_side, is_video

    if options.calibration:
        return _take_over(options)
    if options.side_by_side and (options.left or options.right):
        raise StereoLabError("Either --left and --right, or --side-by-side, not both.")
    needed = ("board", "square-mm") if options.side_by_side else ("left", "right", "board", "square-mm")
    lacking = [f"--{name}" for name in needed if not getattr(options, name.replace("-", "_"))]
    if lacking:
        raise StereoLabError(
            f"Expected {', '.join(lacking)} as well; or --calibration, to take over one made elsewhere."
        )
    if options.every is not None and options.every < 1:
        raise StereoLabError(f"--every: expected a whole number from 1 up, got {options.every}.")
    films = bool(options.left) and is_video(options.left[0])
    if options.every is not None and not films:
        raise StereoLabError("--every is for films; of pictures every one is taken. Leave it out.")
    board, ball = board_of_option(options), ball_of_options(options, None)
    if films:
        recording = _from_films(options, board, ball)
    elif options.side_by_side:
        recording = import_side_by_side(options.side_by_side, board, options.out, ball)
    else:
        recording = import_images(options.left, options.right, board, options.out, ball)
    pairs = recording.pairs("calibration")
    print(f"{recording.path}: {len(pairs)} pairs of {recording.image_size[0]}x{recording.image_size[1]} pixels.")
    print(f"Next: {me()} calibrate {typed(options.out)}")
    write_json_option(
        options.json, {"path": str(recording.path), "pairs": len(pairs), "image_size": list(recording.image_size)}
    )
    return OK


def _from_films(options, board, ball):
    """A recording from two films; how much later one began is said."""
    from stereo_lab.capture.films import OF_FRAMES, import_films
    from stereo_lab.cli.terminal import Progress
    from stereo_lab.recording import is_video

    left, right = options.left[0], options.right[0]
    if not is_video(right):
        raise StereoLabError(f"{left} is a film and {right} is none: name two films, or two patterns.")
    if Path(left).resolve() == Path(right).resolve():
        raise StereoLabError(f"--left and --right both name {left}. Each camera has a film of its own.")
    with Progress() as progress:
        recording, later = import_films(left, right, board, options.out, ball, options.every or OF_FRAMES, progress)
    which = "right" if later > 0 else "left"
    print(f"The {which} film began {abs(later):.2f} s later, by how the board moves.")
    return recording


def _take_over(options):
    """A calibration made elsewhere, into a recording that has no boards, or into a new one."""
    from stereo_lab.capture import import_calibration, recording_of
    from stereo_lab.results import report

    given = [f"--{name}" for name in OF_PICTURES if getattr(options, name.replace("-", "_"))]
    if given:
        raise StereoLabError(
            f"Either pictures of boards or --calibration, not both: {', '.join(given)} has no place beside it."
        )
    calibration = import_calibration(options.calibration, options.unit)
    ball = ball_of_options(options, recording_begun(options.out))
    recording = recording_of(calibration, options.out, ball)
    print(*report.calibration_lines(calibration), sep="\n")
    print(f"Next: put measured pairs of the ball into {recording.path}, in position and depth.")
    write_json_option(options.json, {"path": str(recording.path), **calibration.facts()})
    return OK


def run_export(options: argparse.Namespace) -> int:
    """Write the calibration of a recording as other programs read it."""
    from stereo_lab.calibration import calibrate_recording
    from stereo_lab.capture import export_calibration
    from stereo_lab.cli.terminal import Progress
    from stereo_lab.recording import open_recording

    recording = open_recording(options.recording)
    with Progress() as progress:
        calibration = calibrate_recording(recording, lambda done, total: progress("find the boards", done, total))
    files = export_calibration(calibration, options.out, recording.name)
    for file, what in zip(files, ("OpenCV, in mm", "ROS, the left camera", "ROS, the right camera"), strict=True):
        print(f"{file}: {what}")
    write_json_option(options.json, {"files": [str(file) for file in files]})
    return OK

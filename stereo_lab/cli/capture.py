"""The commands of one's own cameras: record, check, cameras."""

from __future__ import annotations

import argparse
import contextlib
import os
import time
from dataclasses import asdict
from pathlib import Path

from stereo_lab.cli.boards import COLUMNS, ROWS, SQUARE_MM, ball_of_options, board_of_option, recording_begun
from stereo_lab.cli.options import Add, add_board, add_json, add_recording, decimal, seconds
from stereo_lab.cli.terminal import OK, WANTING, me, write_json_option
from stereo_lab.common.files import typed
from stereo_lab.errors import StereoLabError


def add_to(add: Add) -> None:
    """The commands and their options."""
    record = add(
        "record", run_record, "Record with two cameras: boards by themselves when they are new, still and sharp; then the ball at "
        "measured places, typed in. Ctrl-C ends it; starting again goes on.",
        "record data/mine --left 0 --right 1 --board 9x6 --square-mm 25",
    )  # fmt: skip
    record.add_argument("out", metavar="OUT", help="folder of the recording: a new one, or one that was begun")
    record.add_argument("--left", default="0", metavar="N", help="number of the left camera, or a video file (0)")
    record.add_argument("--right", default="1", metavar="N", help="number of the right camera, or a video file (1)")
    record.add_argument("--size", metavar="WxH", help="of the pictures, px (640x480, or that of the recording)")
    record.add_argument(
        "--rate", type=decimal, default=15.0, metavar="HZ", help="pairs a second (default: %(default)g)"
    )
    record.add_argument(
        "--board", metavar="9x6",
        help="columns x rows: of a chessboard its inner corners, of a ChArUco board its squares (9x6, or that of the recording)",
    )  # fmt: skip
    add_board(record, f"({SQUARE_MM}, or that of the recording)")
    record.add_argument("--ball-color", metavar="NAME", help="of the ball (red, or that of the recording)")
    record.add_argument("--ball-mm", metavar="MM", help="diameter of the ball (40, or that of the recording)")
    record.add_argument(
        "--set", choices=("calibration", "position", "depth"), default="calibration", dest="set_name",
        help="boards, or the ball at places whose x, y and depth in mm are typed in, a line each",
    )  # fmt: skip
    record.add_argument("--seconds", type=seconds, metavar="S", help="of boards: end after so long")
    add_json(record)

    check = add(
        "check", run_check, "Look a recording through: what is wrong, what it costs in millimetres, and what to do.",
        "check data/mine --report check.html",
    )  # fmt: skip
    check.add_argument("--report", metavar="FILE", help="write the findings with their figures, as HTML")
    add_recording(check)

    cameras = add("cameras", run_cameras, "Tell which cameras open, and what they give.", "cameras --which")
    cameras.add_argument("--which", action="store_true", help="of two, find out which is the left one: cover its lens")
    add_json(cameras)


def run_cameras(options: argparse.Namespace) -> int:
    """Tell which cameras open and what they give; with --which, which of them is the left one. WANTING where fewer than two."""
    from stereo_lab.capture import find_cameras, which_is_covered

    cameras = find_cameras()
    for camera in cameras:
        sizes = ", ".join(f"{wide}x{high}" for wide, high in camera.sizes)
        gives = (
            f"{sizes}; {camera.rate_hz:.0f} pictures a second"
            if sizes
            else "opens, and gives no picture: unplug it and plug it in again"
        )
        known = ", ".join(word for word in (camera.name, camera.port) if word)
        print(f"camera {camera.number}: {gives}" + (f"  ({known})" if known else ""))
    if not cameras:
        print("No camera opens. Is one plugged in, and does no other program use it?")
    working = [camera.number for camera in cameras if camera.sizes]
    if options.which and len(working) == 2:
        print(
            "Lay a hand flat on the lens of the LEFT camera, seen from behind both, and keep it there ...", flush=True
        )
        left = which_is_covered(working)
        right = next(number for number in working if number != left)
        print(f"Left is camera {left}, right is camera {right}: cameras:{left},{right}")
    elif options.which:
        raise StereoLabError(
            f"--which needs two cameras that give pictures; there {'is' if len(working) == 1 else 'are'} {len(working)}."
        )
    write_json_option(options.json, {"cameras": [asdict(camera) for camera in cameras]})
    return OK if len(working) >= 2 else WANTING


def run_record(options: argparse.Namespace) -> int:
    """Record with two cameras until Ctrl-C. The exit code is OK, also where nothing new was taken."""
    from stereo_lab.capture import Folder, Recorder
    from stereo_lab.recording.places import check_name

    if options.seconds is not None and options.set_name != "calibration":
        raise StereoLabError("--seconds ends a recording of boards; typed places end with an empty line. Leave it out.")
    begun = recording_begun(options.out)
    if begun is None:
        check_name(options.out)
    board = _board_to_record(options, begun)
    ball = ball_of_options(options, begun)
    if any(Path(film).is_file() for film in (options.left, options.right)):
        print(
            f"A film runs as a camera does, by its own clock: left and right may be of different moments. For two films of one recording: {me()} import --left FILM --right FILM"
        )
    source = _two_cameras(options, (640, 480) if begun is None else begun.image_size)
    print(f"A {board}, squares of {board.square_mm:g} mm. (Is that what a ruler says? No picture shows it.)")
    if begun is None:
        print(f"The ball: {ball.color}, {ball.diameter_mm:g} mm wide. {_of_another_ball(options)}".rstrip())
    with source:
        if begun is None:
            source.read()  # cameras that give no pair, or one of another size, begin no folder
        with Recorder(Folder(options.out, source.size, board, ball), board) as recorder:
            for sentence in source.lock():
                print(sentence)
            before = len(recorder.folder.names(options.set_name))
            (_boards if options.set_name == "calibration" else _typed_places)(source, recorder, options)
    pairs = len(recorder.folder.names(options.set_name))
    taken = pairs - before  # as the disk has it: Ctrl-C may come while one is being taken
    print(f"\n{options.out}: {taken} more; {pairs} pairs in {options.set_name}.")
    if pairs:
        print(f"Next: {me()} check {typed(options.out)}")
    write_json_option(options.json, {"path": str(options.out), "taken": taken})
    return OK


def _of_another_ball(options):
    """How to name another ball, where none was named."""
    if options.ball_color is not None and options.ball_mm is not None:
        return ""
    return "(Is yours another one? Then begin anew in another folder, with --ball-color and --ball-mm.)"


def _board_to_record(options, begun):
    """The board that the options name; what they leave out is as in the recording that was begun, or 9x6 of 25 mm."""
    from stereo_lab.recording.bounds import CHARUCO

    if begun is None:
        options.board, options.square_mm = options.board or f"{COLUMNS}x{ROWS}", options.square_mm or SQUARE_MM
        return board_of_option(options)
    there = begun.board
    if not (options.board or options.square_mm or options.marker_mm or options.charuco):
        return there
    options.board = options.board or f"{there.columns}x{there.rows}"
    options.square_mm = options.square_mm or there.square_mm
    if there.kind == CHARUCO:
        options.charuco, options.dictionary = True, there.dictionary
        options.marker_mm = options.marker_mm or there.marker_mm
    return board_of_option(options)


def _two_cameras(options, size):
    """The source that the options name; its pictures are of ``size`` where --size is not given."""
    from stereo_lab.live import CameraSource

    if options.left == options.right:
        raise StereoLabError(
            f"--left and --right both name camera {options.left}. Ask `{me()} cameras` for their numbers."
        )
    try:
        wide, high = size if options.size is None else (int(part) for part in options.size.lower().split("x"))
    except ValueError:
        raise StereoLabError(
            f"--size: expected width x height in pixels, as in 640x480; got {options.size!r}."
        ) from None
    left, right = (int(word) if word.isdecimal() else word for word in (options.left, options.right))
    return CameraSource(left, right, (wide, high), options.rate)


def _boards(source, recorder, options):
    """Boards take themselves; a line is printed whenever there is something else to say."""
    from stereo_lab.capture import Session

    said, until = [""], time.monotonic() + (options.seconds or float("inf"))

    def show(frame, state):
        if state.said != said[0]:
            said[0] = state.said
            bars = "  ".join(f"{bar.name} {100 * bar.part:.0f} %" for bar in state.bars)
            print(f"{state.said}   [{bars}]", flush=True)
        if time.monotonic() > until:
            session.stop()

    print("Hold the board before both cameras; each pair is taken by itself. Ctrl-C ends it.\n", flush=True)
    session = Session(source, recorder, show)
    with contextlib.suppress(KeyboardInterrupt):
        session.run()


def _typed_places(source, recorder, options):
    """The ball at measured places: a line with x, y and depth takes the newest pair."""
    from stereo_lab.capture import told_without

    print("Put the ball somewhere, measure it, and type x y depth in mm; an empty line ends it.\n", flush=True)
    with contextlib.suppress(KeyboardInterrupt, EOFError):
        while line := input("x y depth: ").replace(",", ".").split():
            if len(line) != 3:
                print("Three numbers were expected: to the right, up, and away from the cameras, as in 120 85 1000.")
                continue
            try:
                if (frame := source.read()) is None:
                    print("The film is at its end.")
                    break
                name = recorder.take_sample(frame, options.set_name, tuple(line))
            except StereoLabError as error:
                print(error)
                continue
            unseen = told_without(recorder.folder.ball, frame.left, frame.right)
            print(f"Taken: {options.set_name}/{name}. {unseen}".rstrip())


def run_check(options: argparse.Namespace) -> int:
    """Look a recording through and say what is wrong with it; WANTING where something is that matters."""
    os.environ.setdefault("MPLBACKEND", "agg")  # figures go to a file: no window is needed, nor a screen
    from stereo_lab.cli.terminal import Progress
    from stereo_lab.doctor import check_recording
    from stereo_lab.recording import open_recording
    from stereo_lab.results import checkup as told

    recording = open_recording(options.recording)
    with Progress() as progress:
        checkup = check_recording(recording, progress)
    print(f"{recording.title}\n({recording.path})\n")
    print(*told.lines(checkup), sep="\n")
    if checkup.verdict == "clean":
        print(f"\nNext: {_after_check(recording, options.recording or recording.path)}")
    if options.report:
        told.write(checkup, recording, options.report)
        print(f"written: {options.report}")
    write_json_option(options.json, checkup.facts())
    return OK if checkup.verdict == "clean" else WANTING


def _after_check(recording, name):
    """What comes after a clean check: measured balls as long as there are none, then the whole chain."""
    from stereo_lab.recording.needs import lacks

    lacking = lacks(recording, "position", "depth")
    if not lacking:
        return f"{me()} demo {typed(name)}"
    return (
        f"measure where a ball is; until then millimetres on the bench are not known: {me()} record {typed(name)} "
        f"--set {lacking[0]} (with the cameras' numbers as before)"
    )

"""The commands of one's own cameras: board, cameras, record, import, check, export."""

from __future__ import annotations

import argparse
import contextlib
import os
import time
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

from stereo_lab.cli.terminal import OK, WANTING, me, typed, write_json_option
from stereo_lab.errors import StereoLabError

if TYPE_CHECKING:
    from stereo_lab.recording import Board

COLUMNS, ROWS, SQUARE_MM = "9", "6", "25"  # of a board of which nothing is told


def board_of(columns: str, rows: str, options: argparse.Namespace, told_by: tuple[str, str]) -> Board:
    """A board by its counts, which ``told_by`` names, and by the options --square-mm, --charuco, --marker-mm and --dictionary.

    Raises
    ------
    StereoLabError
        If there can be no such board.
    """
    from stereo_lab.recording import Board
    from stereo_lab.recording.bounds import (
        CHARUCO,
        DICTIONARY,
        MARKER,
        corner_count,
        dictionary_name,
        length_mm,
        markers_that_fit,
    )

    counted, more = ("squares", 1) if options.charuco else ("inner corners", 0)
    across = corner_count(columns, f"{told_by[0]}, {counted} across", more)
    down = corner_count(rows, f"{told_by[1]}, {counted} down", more)
    square = length_mm(options.square_mm, "--square-mm")
    if not options.charuco:
        _of_no_use(options, "of a ChArUco board: add --charuco, or leave it out", "marker-mm", "dictionary")
        return Board(across, down, square)
    marker = markers_that_fit(options.marker_mm or MARKER * square, square, "--marker-mm")
    dictionary = dictionary_name(options.dictionary or DICTIONARY, across * down // 2, "--dictionary")
    return Board(across, down, square, CHARUCO, marker, dictionary)


def _of_no_use(options, why, *names):
    """Refuse options that would do nothing beside the others."""
    for name in names:
        told = getattr(options, name.replace("-", "_"))
        if told is not None and told is not False:  # 0 is told
            raise StereoLabError(f"--{name} is {why}.")


def run_import(options: argparse.Namespace) -> int:
    """Make a recording from board pictures taken elsewhere, or of a calibration made elsewhere. The exit code is OK."""
    from stereo_lab.recording import Ball, import_images, import_side_by_side, is_video
    from stereo_lab.recording.bounds import color_name, length_mm

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
    if options.every < 1:
        raise StereoLabError(f"--every: expected a whole number from 1 up, got {options.every}.")
    board = board_of_option(options)
    ball = Ball(color_name(options.ball_color, "--ball-color"), length_mm(options.ball_mm, "--ball-mm"))
    if options.left and is_video(options.left[0]):
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
    from stereo_lab.capture import import_films
    from stereo_lab.cli.terminal import Progress
    from stereo_lab.recording import is_video

    left, right = options.left[0], options.right[0]
    if not is_video(right):
        raise StereoLabError(f"{left} is a film and {right} is none: name two films, or two patterns.")
    with Progress() as progress:
        recording, later = import_films(left, right, board, options.out, ball, options.every, progress)
    which = "right" if later > 0 else "left"
    print(f"The {which} film began {abs(later):.2f} s later, by how the board moves.")
    return recording


def _take_over(options):
    """A calibration made elsewhere, into a recording that has no boards, or into a new one."""
    from stereo_lab.capture import import_calibration, recording_of
    from stereo_lab.recording import Ball
    from stereo_lab.recording.bounds import color_name, length_mm
    from stereo_lab.results import report

    if options.left or options.right:
        raise StereoLabError("Either pictures of boards (--left, --right) or --calibration, not both.")
    calibration = import_calibration(options.calibration, options.unit)
    ball = Ball(color_name(options.ball_color, "--ball-color"), length_mm(options.ball_mm, "--ball-mm"))
    recording = recording_of(calibration, options.out, ball)
    print(*report.calibration_lines(calibration), sep="\n")
    print(f"Next: put measured pairs of the ball into {recording.path}, in position and depth.")
    write_json_option(options.json, {"path": str(recording.path), **calibration.facts()})
    return OK


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


def board_of_option(options: argparse.Namespace) -> Board:
    """The board of --board, such as 9x6, and the options beside it."""
    parts = options.board.lower().replace("×", "x").split("x")
    if len(parts) != 2:
        raise StereoLabError(f"--board: expected columns x rows of inner corners, as in 9x6; got {options.board!r}.")
    return board_of(parts[0], parts[1], options, ("--board", "--board"))


def run_record(options: argparse.Namespace) -> int:
    """Record with two cameras until Ctrl-C. The exit code is OK, also where nothing new was taken."""
    from stereo_lab.capture import Folder, Recorder
    from stereo_lab.recording import USUAL_BALL, Ball, open_recording
    from stereo_lab.recording.bounds import color_name, length_mm

    begun = open_recording(options.out) if (Path(options.out) / "recording.json").is_file() else None
    board = _board_to_record(options, begun)
    known = begun.ball if begun else USUAL_BALL
    ball = Ball(
        known.color if options.ball_color is None else color_name(options.ball_color, "--ball-color"),
        known.diameter_mm if options.ball_mm is None else length_mm(options.ball_mm, "--ball-mm"),
    )
    if ball != known and begun:
        raise StereoLabError(
            f"{options.out} was begun with a {known.color} ball of {known.diameter_mm:g} mm; this is a {ball.color} one of "
            f"{ball.diameter_mm:g} mm. Change it in {Path(options.out) / 'recording.json'}, or name another folder."
        )
    if any(Path(film).is_file() for film in (options.left, options.right)):
        print(
            f"A film runs as a camera does, by its own clock: left and right may be of different moments. For two films of one recording: {me()} import --left FILM --right FILM"
        )
    source = _two_cameras(options, (640, 480) if begun is None else begun.image_size)
    with source, Recorder(Folder(options.out, source.size, board, ball), board) as recorder:
        for sentence in source.lock():
            print(sentence)
        before = len(recorder.folder.names(options.set_name))
        (_boards if options.set_name == "calibration" else _typed_places)(source, recorder, options)
    pairs = len(recorder.folder.names(options.set_name))
    taken = pairs - before  # as the disk has it: Ctrl-C may come while one is being taken
    print(f"\n{options.out}: {taken} more; {pairs} pairs in {options.set_name}.")
    print(f"Next: {me()} check {typed(options.out)}")
    write_json_option(options.json, {"path": str(options.out), "taken": taken})
    return OK


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
    print("Put the ball somewhere, measure it, and type x y depth in mm; an empty line ends it.\n", flush=True)
    with contextlib.suppress(KeyboardInterrupt, EOFError):
        while line := input("x y depth: ").replace(",", ".").split():
            if len(line) != 3:
                print("Three numbers were expected: to the right, up, and away from the cameras, as in 120 85 1000.")
                continue
            try:
                frame = source.read()
                name = recorder.take_sample(frame, options.set_name, tuple(line))
            except StereoLabError as error:
                print(error)
                continue
            print(f"Taken: {options.set_name}/{name}.")


def run_check(options: argparse.Namespace) -> int:
    """Look a recording through and say what is wrong with it; WANTING where something is that matters."""
    os.environ.setdefault("MPLBACKEND", "agg")  # figures go to a file: no window is needed, nor a screen
    from stereo_lab.cli.terminal import Progress
    from stereo_lab.doctor import check_recording
    from stereo_lab.recording import open_recording

    recording = open_recording(options.recording)
    with Progress() as progress:
        checkup = check_recording(recording, progress)
    if options.json != "-" or options.report:
        from stereo_lab.results import checkup as told
    if options.json != "-":
        print(f"{recording.title}\n({recording.path})\n")
        print(*told.lines(checkup), sep="\n")
    if options.report:
        told.write(checkup, recording, options.report)
    write_json_option(options.json, checkup.facts())
    return OK if checkup.verdict == "clean" else WANTING


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


def run_board(options: argparse.Namespace) -> int:
    """Write a board, or marks for the table, as a PDF true to scale."""
    from stereo_lab.capture import PAPERS_MM, board_sheet, mark_sheets
    from stereo_lab.common.files import write_whole
    from stereo_lab.plots import sheets_pdf

    if Path(options.out).suffix.lower() != ".pdf":
        raise StereoLabError(f"The sheets are a PDF: expected a name that ends in .pdf, got {options.out}.")
    paper = {name.lower(): name for name in PAPERS_MM}.get(options.paper.lower(), options.paper)
    if options.marks:
        board_only = "columns", "rows", "square-mm", "charuco", "marker-mm", "dictionary"
        _of_no_use(options, "of a board, and --marks prints none: leave one of them out", *board_only)
        told = {"sheets": options.sheets, "from_mm": options.from_mm}
        sheets = mark_sheets(paper, **{name: value for name, value in told.items() if value is not None})
        what = f"{len(sheets)} sheet(s) of marks, {paper}. Lay them one behind the other, line on line."
    else:
        _of_no_use(options, "of marks: add --marks, or leave it out", "sheets", "from-mm")
        options.square_mm = options.square_mm or SQUARE_MM
        board = board_of(options.columns or COLUMNS, options.rows or ROWS, options, ("--columns", "--rows"))
        sheets, what = [board_sheet(board, paper)], f"{board}, squares of {board.square_mm:g} mm, {paper}."
    write_whole(options.out, sheets_pdf(sheets))
    print(f"{options.out}: {what}")
    print("Print it at 100 %, not fitted to the page, and measure the line of 100 mm.")
    return OK

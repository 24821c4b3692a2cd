"""The command ``stereo-lab``."""

from __future__ import annotations

import argparse
import io
import os
import sys
from collections.abc import Sequence

from stereo_lab import __version__
from stereo_lab.cli.arm import ARM_ACTIONS, run_arm
from stereo_lab.cli.capture import run_board, run_cameras, run_check, run_export, run_import, run_record
from stereo_lab.cli.checks import run_bench, run_test
from stereo_lab.cli.classroom import run_grade, run_hand_in, run_variant
from stereo_lab.cli.course import run_progress, run_reset, run_start
from stereo_lab.cli.instructor import run_export_nbgrader
from stereo_lab.cli.live import run_live, run_log, run_watch
from stereo_lab.cli.seats import run_pack, run_places, run_ready, run_unpack, run_wheels
from stereo_lab.cli.terminal import BAD_INPUT, STOPPED, check_outputs, clear_line, decimal, flush_output, seconds
from stereo_lab.cli.train import run_train
from stereo_lab.cli.vision import run_calibrate, run_demo, run_detect, run_render
from stereo_lab.errors import StereoLabError


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command; returns the exit code 0 (done), 1 (found wanting) or 2 (bad usage or input)."""
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # before numpy is loaded: see lab.py
    os.environ.setdefault("OPENCV_LOG_LEVEL", "ERROR")  # a camera or video that does not open is told in one sentence
    os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", "-8")
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):  # a pipe on Windows may have no letter for θ
            stream.reconfigure(errors="replace")
    try:
        words, for_jupyterlab = _parted(list(sys.argv[1:] if arguments is None else arguments))
        options = _parser().parse_args(words)
        options.for_jupyterlab = for_jupyterlab
        check_outputs(options)
        code = options.run(options)
        flush_output()
        return code
    except StereoLabError as error:
        clear_line()
        print(f"stereo-lab: {error}", file=sys.stderr)
        return BAD_INPUT
    except OSError as error:
        clear_line()
        print(f"stereo-lab: {_in_words(error)}", file=sys.stderr)
        return BAD_INPUT
    except KeyboardInterrupt:
        clear_line()
        print("stereo-lab: stopped; nothing is left half written.", file=sys.stderr)
        return STOPPED


def _parted(words):
    """What stands behind `--` after `start` is for JupyterLab; argparse would mix it up with words of its own."""
    if words[:1] != ["start"] or "--" not in words:
        return words, []
    k = words.index("--")
    return words[:k], words[k + 1 :]


def _in_words(error):
    """An OSError as a sentence; without a file's name it comes from printing."""
    reason = error.strerror or error
    if error.filename:
        return f"Cannot use {error.filename}: {reason}."
    return f"Cannot print: {reason}. Name a file with --json, or free some space."


def _parser():
    parser = argparse.ArgumentParser(
        prog="stereo-lab", description="See in 3D with two webcams: calibrate, find the ball, locate it."
    )
    parser.add_argument("--version", action="version", version=f"stereo-lab {__version__}")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")

    def add(name, run, text, example, **more):
        epilog = f"example:  stereo-lab {example}"
        command = commands.add_parser(name, help=text, description=text, epilog=epilog, **more)
        command.set_defaults(run=run)
        return command

    start = add(
        "start", run_start,
        "Open the course in JupyterLab, in a folder of your own with a clean copy of each lesson.", "start 03 --name ada",
    )  # fmt: skip
    start.add_argument(
        "lesson",
        nargs="?",
        default="00",
        metavar="LESSON",
        help="its number (default: 00); after -- come options for JupyterLab",
    )
    start.add_argument(
        "--data", metavar="FOLDER", help="where the recordings lie, if not with the kit (or: $STEREO_LAB_DATA)"
    )
    reset = add("reset", run_reset, "Begin a lesson afresh; what you had is kept beside it.", "reset 03")
    reset.add_argument("lesson", metavar="LESSON", help="its number")
    progress = add("progress", run_progress, "Say how far you are.", "progress")
    _add_recording(progress)
    ready = add(
        "ready",
        run_ready,
        "Say, in half a minute, whether this computer is fit for the course, and what to do.",
        "ready",
    )
    _add_json(ready)
    pack = add(
        "pack",
        run_pack,
        "Write your folder, work and progress, into one file, for another computer.",
        "pack stick/ada.zip",
    )
    pack.add_argument("file", nargs="?", metavar="FILE", help="to write (default: the folder's name and the time)")
    unpack = add(
        "unpack",
        run_unpack,
        "Bring what pack wrote into your folder; what lies there and is different is kept.",
        "unpack stick/ada.zip",
    )
    unpack.add_argument("file", metavar="FILE")
    wheels = add(
        "wheels", run_wheels, "Make a folder from which lab.py --offline sets up computers without a network.",
        "wheels stick/wheels --system windows macos --python 3.12",
    )  # fmt: skip
    wheels.add_argument("out", metavar="OUT", help="the folder; what is in it already is not fetched again")
    wheels.add_argument("--system", nargs="+", metavar="NAME", help="windows, macos, linux, linux-arm (this one)")
    wheels.add_argument("--python", nargs="+", metavar="3.x", help="the Python of those computers (this one's)")
    _add_json(wheels)
    places = add("places", run_places, "Say where lessons, recordings, your work and everything else lies.", "places")
    _add_json(places)
    for command in (start, reset, progress, ready, places, pack, unpack):
        command.add_argument("--name", metavar="NAME", help="whose: several people at one computer have a folder each")

    variant = add(
        "variant", run_variant, "Make a recording for one seat: other boards, balls, lengths and numbers than the neighbour's.", "variant 17",
    )  # fmt: skip
    variant.add_argument(
        "seed", type=int, metavar="SEED", help="the number of the seat; the same one gives the same recording"
    )
    variant.add_argument("--out", metavar="DIR", help="a folder to make (default: seat, in the learner's folder)")
    variant.add_argument("--name", metavar="NAME", help="whose: several people at one computer have a folder each")

    give = add("hand-in", run_hand_in, "Write a lesson as one file for the teacher, under a code name.", "hand-in 02")
    give.add_argument("lesson", metavar="LESSON", help="its number")
    give.add_argument(
        "--with", action="append", default=[], dest="together_with", metavar="CODE", help="the code name of whoever worked on it with you"
    )  # fmt: skip
    give.add_argument("--code-name", metavar="CODE", help="yours, if you do not want the one that was made for you")
    give.add_argument("--out", metavar="DIR", help="where to write the file (default: handed_in, in your folder)")
    give.add_argument("--name", metavar="NAME", help="whose: several people at one computer have a folder each")

    mark = add(
        "grade", run_grade, "Run and mark the notebooks that a class has handed in; a table of who passed what.",
        "grade handed_in --csv class.csv --html class.html",
    )  # fmt: skip
    mark.add_argument(
        "folder", metavar="FOLDER", help="of notebooks, or of a folder for each learner; it is not changed"
    )
    mark.add_argument(
        "--csv", required=True, metavar="FILE",
        help="the table to write; what a teacher wrote into one that is there is kept. Beside it lies what is finished",
    )  # fmt: skip
    mark.add_argument(
        "--html", metavar="FILE", help="the same as a page, with what was fallen for and what was written"
    )
    mark.add_argument("--due", metavar="TIME", help='later is late: a day, or "2026-10-05 12:00"')
    mark.add_argument(
        "--by-folder", action="store_true",
        help="go by the folder and the date of each notebook, whatever name and time stand in it: as a class server's are collected",
    )  # fmt: skip
    mark.add_argument("--jobs", type=int, metavar="N", help="notebooks at a time (default: one for each core)")
    mark.add_argument("--recording", metavar="REC", help="what the class worked on (default: as for demo)")
    _add_json(mark)

    demo = add(
        "demo",
        run_demo,
        "Run the whole chain on a recording, beside the paper's numbers.",
        "demo bench --report demo.html",
    )
    _add_recording(demo)
    demo.add_argument(
        "--report", metavar="FILE", default="demo.html", help="picture report to write (default: %(default)s)"
    )

    calibrate = add(
        "calibrate", run_calibrate, "Calibrate the two cameras of a recording.", "calibrate data/bench --json cal.json"
    )
    _add_recording(calibrate)
    calibrate.add_argument("--save", metavar="FILE", help="write the calibration itself, to be loaded in Python")
    calibrate.add_argument("--report", metavar="FILE", help="picture of where the calibration knows least, as HTML")
    calibrate.add_argument(
        "--keep",
        action="store_true",
        help="write it into the recording, so that whoever gets the folder starts with it",
    )
    calibrate.add_argument(
        "--swap",
        action="store_true",
        help="first rename the folders left and right of every set into each other, for cameras named the wrong way round",
    )

    detect = add(
        "detect",
        run_detect,
        "Find the ball in pictures and videos.",
        "detect data/bench/snaps/left/000.jpg --color red",
    )
    detect.add_argument("images", nargs="+", metavar="IMAGE")
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
    detect.add_argument("--method", choices=("paper", "cone"), default="cone")
    _add_json(detect)

    train = add(
        "train", run_train, "Learn a ball of your own from pictures in which it is marked, and say how it does on others.",
        "train clutter --out ball.json",
    )  # fmt: skip
    _add_recording(train)
    train.add_argument("--out", required=True, metavar="FILE", help="the ball to write (.json); --color FILE uses it")
    train.add_argument(
        "--marks", metavar="CSV", help="picture,u,v,radius_px, from the panel of lesson 09; u empty: no ball (default: proposed)"
    )  # fmt: skip
    train.add_argument(
        "--set", dest="set_name", metavar="SET", help="of the recording (default: the first that shows balls)"
    )
    train.add_argument(
        "--color", metavar="NAME", help="whose surest balls mark themselves (default: that of the recording)"
    )
    train.add_argument(
        "--by-name", action="store_true", help="keep that colour; else it is learned from the marks as well"
    )
    train.add_argument("--from-nothing", action="store_true", help="learn without what the shipped weights know")

    bring = add(
        "import", run_import, "Make a recording from board pictures you have, or take over a calibration made elsewhere.",
        'import --left "shots/left*.jpg" --right "shots/right*.jpg" --board 9x6 --square-mm 25 --out data/mine',
    )  # fmt: skip
    bring.add_argument(
        "--left", nargs="+", metavar="GLOB", help="pattern of the left pictures, or their folder; or a film"
    )
    bring.add_argument(
        "--every", type=int, default=10, metavar="N", help="of a film: of N frames the one with the stillest board (10)"
    )
    bring.add_argument("--right", nargs="+", metavar="GLOB")
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
    _add_board(bring)
    bring.add_argument(
        "--calibration", nargs="+", metavar="FILE",
        help="in the place of pictures: OpenCV's YAML, or the left and the right camera_info of ROS; --out may be a recording "
        "that has no boards",
    )  # fmt: skip
    bring.add_argument("--unit", default="mm", help="of OpenCV's translation: mm, cm, inch or m (default: %(default)s)")
    bring.add_argument("--out", required=True, metavar="DIR", help="folder to make")
    bring.add_argument("--ball-color", default="red", metavar="NAME")
    bring.add_argument("--ball-mm", default="40", metavar="MM", help="diameter of the ball (default: %(default)s)")
    _add_json(bring)

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
    _add_board(record)
    record.add_argument("--ball-color", metavar="NAME", help="of the ball (red, or that of the recording)")
    record.add_argument("--ball-mm", metavar="MM", help="diameter of the ball (40, or that of the recording)")
    record.add_argument(
        "--set", choices=("calibration", "position", "depth"), default="calibration", dest="set_name",
        help="boards, or the ball at places whose x, y and depth in mm are typed in, a line each",
    )  # fmt: skip
    record.add_argument("--seconds", type=seconds, metavar="S", help="end after so long")
    _add_json(record)

    check = add(
        "check", run_check, "Look a recording through: what is wrong, what it costs in millimetres, and what to do.",
        "check data/mine --report check.html",
    )  # fmt: skip
    check.add_argument("--report", metavar="FILE", help="write the findings with their figures, as HTML")
    _add_recording(check)

    cameras = add("cameras", run_cameras, "Tell which cameras open, and what they give.", "cameras --which")
    cameras.add_argument("--which", action="store_true", help="of two, find out which is the left one: cover its lens")
    _add_json(cameras)

    give = add("export", run_export, "Write a calibration for other programs: OpenCV's YAML, and camera_info for ROS.",
        "export bench --out calibration",
    )  # fmt: skip
    give.add_argument("--out", default="calibration", metavar="DIR", help="folder of the files (default: %(default)s)")
    _add_recording(give)

    board = add(
        "board", run_board, "Make a PDF to print: a board for the calibration, or marks for the table.",
        "board board.pdf --columns 9 --rows 6 --square-mm 25 --paper A4",
    )  # fmt: skip
    board.add_argument("out", metavar="FILE", help="the PDF to write")
    board.add_argument(
        "--columns", metavar="N", help="of a chessboard its inner corners, of a ChArUco board its squares (9)"
    )
    board.add_argument("--rows", metavar="N", help="the same, downwards (6)")
    _add_board(board)
    board.add_argument("--paper", default="A4", metavar="NAME", help="A4, Letter or A3 (default: %(default)s)")
    board.add_argument(
        "--marks", action="store_true", help="instead of a board: crosses for the table, marked with their x and depth"
    )
    board.add_argument("--sheets", type=int, metavar="N", help="of marks, one behind the other (3)")
    board.add_argument("--from-mm", type=decimal, metavar="MM", help="depth of the first line of marks (500)")

    render = add(
        "render",
        run_render,
        "Make a shipped recording again (needs the extra: render).",
        "render bench --out /tmp/bench --seed 7",
    )
    render.add_argument(
        "name",
        metavar="NAME",
        help="bench, clutter, clutter_test, second_rig, third_rig, or a rig file of your own (.json)",
    )
    render.add_argument("--out", metavar="DIR", help="folder to make (default: data/NAME)")
    render.add_argument("--seed", type=int, help="other poses and other noise")
    render.add_argument("--sets", metavar="SET,SET", help="only these sets")
    _add_json(render)

    arm = add(
        "arm",
        run_arm,
        "Talk to an arm: list the ports, or name one and say what to do. Only home, move, calibrate and register move it; the last three home it first where it does not know where it stands.",
        "arm virtual://arm move 30 45",
    )
    arm.add_argument(
        "url", metavar="list|torque|URL",
        help="list: the ports; torque: what the arm of a recording weighs on its joints; or a port: virtual://arm, COM3, "
        "/dev/ttyUSB0, socket://…; feetech://PORT for bus servos",
    )  # fmt: skip
    arm.add_argument(
        "action", nargs="?", metavar="ACTION",
        help=f"{', '.join(ARM_ACTIONS)}, setup (default: status); after torque: folder or name of a recording",
    )  # fmt: skip
    arm.add_argument(
        "angles", nargs="*", metavar="WORD", help="for move: shoulder and elbow in degrees; for register: the recording"
    )
    arm.add_argument("--left", type=int, default=0, metavar="N", help="for register: number of the left camera (0)")
    arm.add_argument("--right", type=int, default=1, metavar="N", help="for register: number of the right camera (1)")
    arm.add_argument("--keep", action="store_true", help="for register: write it into the recording")
    arm.add_argument(
        "--seconds",
        type=decimal,
        default=None,
        metavar="S",
        help="for monitor: stop after so long (else Ctrl-C ends it, with exit code 0)",
    )
    _add_json(arm)

    live = add(
        "run", run_live,
        "Locate the ball in pictures as they come, and follow it with an arm. Ctrl-C ends it. An arm that does not know where it "
        "stands is homed first.",
        "run --source virtual --arm virtual://arm --seconds 20 --log run.jsonl",
    )  # fmt: skip
    live.add_argument(
        "--source", metavar="SOURCE", default="virtual",
        help="a recording; cameras:0,1; virtual, or virtual:NAME for the bench of another recording (default: %(default)s)",
    )  # fmt: skip
    live.add_argument(
        "--recording",
        metavar="REC",
        help="the recording that was taken with these cameras (default: the source's own; for cameras: as for demo)",
    )
    live.add_argument("--color", metavar="NAME", help="a colour, or a file that train wrote (default: the recording's)")
    live.add_argument("--rate", type=decimal, default=30.0, metavar="HZ", help="pairs a second (default: %(default)g)")
    live.add_argument(
        "--arm", metavar="URL", help="follow the ball with this arm: virtual://arm, COM3, /dev/ttyUSB0, …"
    )
    live.add_argument(
        "--touch", action="store_true", help="touch three balls that lie still, one after the other, and go home"
    )
    live.add_argument("--log", metavar="FILE", help="write a line for each pair of pictures (JSON Lines)")
    live.add_argument(
        "--mqtt", metavar="HOST[:PORT]", help="tell a broker; see `stereo-lab watch` (needs the extra: live)"
    )
    live.add_argument("--bench", metavar="NAME", help="what this bench is called there (default: this computer's name)")
    live.add_argument("--seconds", type=seconds, metavar="S", help="end after so long")

    log = add("log", run_log, "Summarise the log of a run.", "log run.jsonl --csv run.csv --plot run.png")
    log.add_argument("file", metavar="FILE")
    log.add_argument("--csv", metavar="FILE", help="write it as a table for a spreadsheet")
    log.add_argument("--plot", metavar="FILE", help="draw it, CPU and memory among it (.png, .svg or .pdf)")
    _add_json(log)

    watch = add(
        "watch", run_watch, "Show a line for each bench that tells a broker of its run (needs the extra: live).",
        "watch 192.168.1.10",
    )  # fmt: skip
    watch.add_argument("host", metavar="HOST[:PORT]", help="the broker")
    watch.add_argument("--seconds", type=seconds, metavar="S", help="end after so long (else Ctrl-C ends it)")

    bench = add(
        "bench", run_bench, "Measure speed and accuracy beside the alternatives, on this computer.",
        "bench --json bench.json",
    )  # fmt: skip
    _add_recording(bench)

    hand_out = add(
        "export-nbgrader", run_export_nbgrader, "Write the course as assignments of nbgrader (its use needs the extra: instructor).",
        "export-nbgrader course",
    )  # fmt: skip
    hand_out.add_argument("out", metavar="OUT", help="folder to make: nbgrader's course folder")

    test = add("test", run_test, "Run the tests: package and notebooks.", "test")
    test.add_argument("--all", action="store_true", help="everything that continuous integration runs")
    return parser


def _add_recording(parser):
    parser.add_argument(
        "recording", nargs="?", metavar="REC",
        help="folder or name of a recording (default: $STEREO_LAB_RECORDING, else the shipped bench)",
    )  # fmt: skip
    _add_json(parser)


def _add_board(parser):
    """What else there is to say of a board."""
    parser.add_argument("--square-mm", metavar="MM", help="side of one square in millimetres")
    parser.add_argument("--charuco", action="store_true", help="it is a ChArUco board: a chessboard with markers in it")
    parser.add_argument("--marker-mm", metavar="MM", help="side of one marker (default: three quarters of a square)")
    parser.add_argument(
        "--dictionary", metavar="NAME", help="what the markers are taken from, by OpenCV's name (default: DICT_4X4_50)"
    )  # fmt: skip


def _add_json(parser):
    parser.add_argument("--json", metavar="FILE", help="write the numbers as JSON; - for the terminal")

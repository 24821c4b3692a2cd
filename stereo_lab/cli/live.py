"""The commands of the live cell: run, log, watch."""

from __future__ import annotations

import argparse
import contextlib
import shutil
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING

from stereo_lab.cli.options import Add, add_json, decimal, seconds
from stereo_lab.cli.terminal import OK, WANTING, clear_line, end_as_by_ctrl_c, tell_fit, write_json_option
from stereo_lab.errors import StereoLabError

if TYPE_CHECKING:
    from stereo_lab.live import Moment
    from stereo_lab.live.log import Run

LINE_S = 0.2  # the live line is drawn anew so often; where nobody watches a terminal, every PLAIN_S
PLAIN_S, WATCH_S = 5.0, 1.0


def add_to(add: Add) -> None:
    """The commands and their options."""
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
    log.add_argument("file", metavar="FILE", help="what a run wrote, as with live --log (.jsonl)")
    log.add_argument("--csv", metavar="FILE", help="write it as a table for a spreadsheet")
    log.add_argument("--plot", metavar="FILE", help="draw it, CPU and memory among it (.png, .svg or .pdf)")
    add_json(log)

    watch = add(
        "watch", run_watch, "Show a line for each bench that tells a broker of its run (needs the extra: live).",
        "watch 192.168.1.10",
    )  # fmt: skip
    watch.add_argument("host", metavar="HOST[:PORT]", help="the broker")
    watch.add_argument("--seconds", type=seconds, metavar="S", help="end after so long (else Ctrl-C ends it)")


def run_live(options: argparse.Namespace) -> int:
    """Locate the ball in pictures as they come, and follow it with an arm, until the end or Ctrl-C; WANTING where its log is not whole."""
    from stereo_lab.live import Follower, open_source, run, touch_in_turn
    from stereo_lab.live.log import RunLog, check_new
    from stereo_lab.localization import Localizer
    from stereo_lab.recording import open_recording

    if options.touch and options.arm is None:
        raise StereoLabError("--touch needs an arm: --arm virtual://arm, or the port of yours.")
    if options.touch and options.seconds is not None:
        raise StereoLabError(
            "--touch ends with its third ball, and --seconds a run that follows. Choose one of the two."
        )
    if options.log:
        check_new(options.log)  # before the arm moves
    end_as_by_ctrl_c()
    with contextlib.ExitStack() as stack:
        told = options.recording or options.source.startswith("cameras:")
        stage = open_recording(options.recording) if told else None
        source = stack.enter_context(open_source(options.source, rate_hz=options.rate, recording=stage))
        recording = stage or getattr(source, "recording", None) or open_recording()
        if options.recording is None:
            _check_stage(options, recording)
        localizer = Localizer.fit(recording, color=options.color)
        tell_fit(localizer, recording, arm=options.arm is not None)
        arm = None if options.arm is None else stack.enter_context(_arm(options.arm, recording))
        move_on = _set_the_stage(source, arm, options.touch)
        sinks = _sinks(options, source, recording, localizer, stack)
        try:
            with arm or contextlib.nullcontext():  # at rest before the sinks are closed, which may take a moment
                if options.touch:
                    for line in touch_in_turn(source, localizer, arm, recording, move_on=move_on, sinks=sinks):
                        print(line, flush=True)
                else:
                    follower = None if arm is None else Follower(arm, recording)
                    with contextlib.closing(run(source, localizer, follower, sinks, options.seconds)) as moments:
                        _show(moments, sinks)
        except KeyboardInterrupt:
            clear_line()
            print("Stopped.")
    cut_off = [sink.path for sink in sinks if isinstance(sink, RunLog) and sink.trouble]
    for path in cut_off:
        print(f"{path} is not whole: the end of the run could not be written into it.", file=sys.stderr)
    return WANTING if cut_off else OK


def _check_stage(options, recording):
    """Real cameras cannot be those of a rendered recording: that is said, and no arm is sent where they would say."""
    from stereo_lab.live import stage_of

    try:
        stage_of(options.source, recording)
    except StereoLabError as error:
        if options.arm is not None:
            raise StereoLabError(f"{error} Name it with --recording.") from None
        print(error, file=sys.stderr)


def _arm(url, recording):
    """A port, its limits told, its joints homed and its motors on; a virtual one keeps the time of the clock."""
    from stereo_lab.arm import connect
    from stereo_lab.live.follower import switch_on

    if url.startswith("virtual://") and "realtime" not in url:
        url += ("&" if "?" in url else "?") + "realtime=1"
    arm = connect(url)
    try:
        arm.set_limits(recording.arm.limits_deg)
        if arm.homed:
            switch_on(arm)
        else:
            print("The arm moves: homing both joints …", flush=True)
            arm.home()
    except BaseException as error:
        arm.close()
        if isinstance(error, KeyboardInterrupt):
            print("The arm was told to stop, and its motors are off. It does not know yet where it stands.")
        raise
    return arm


def _set_the_stage(source, arm, touch):
    """On the virtual bench the arm is in the picture, and the ball goes round; or it moves on when it was touched."""
    from stereo_lab.live import VirtualBench, round_trip

    if not isinstance(source, VirtualBench):
        return lambda touched: None
    path = round_trip(source.recording)
    source.arm = arm.port if hasattr(getattr(arm, "port", None), "link_deg") else None
    source.path = None if touch else path

    def move_on(touched):
        source.ball_mm = path(2.0 * touched)

    move_on(0)
    return move_on


def _sinks(options, source, recording, localizer, stack):
    """Where the records of the run go."""
    from stereo_lab.live.log import RunLog, header
    from stereo_lab.live.telemetry import Broadcast, bench_name

    head = header(source.name, options.arm or "", recording.name, localizer.calibration.facts())
    sinks = []
    if options.mqtt:  # first: where it cannot be had, no log is begun, which would be in the way of the next try
        sinks.append(stack.enter_context(contextlib.closing(Broadcast(options.mqtt, bench_name(options.bench), head))))
    if options.log:
        sinks.append(stack.enter_context(contextlib.closing(RunLog(options.log, head))))
    return sinks


def _show(moments, sinks):
    """One line that is drawn anew; on a pipe a line every few seconds. What goes wrong with a log is told once."""
    live, next_s, told = sys.stdout.isatty(), 0.0, set()
    moment, dropped = None, 0
    for moment in moments:
        dropped += moment.frame.dropped
        for sink in sinks:
            if sink.trouble and sink.trouble not in told:
                told.add(sink.trouble)
                clear_line()
                print(sink.trouble, file=sys.stderr)
        if time.monotonic() >= next_s:
            next_s = time.monotonic() + (LINE_S if live else PLAIN_S)
            _draw(moment, live)
    if live:
        print()
    if moment is not None:
        late = f" {dropped} more were dropped: they came faster than they could be dealt with." if dropped else ""
        print(f"{moment.number + 1} pairs of pictures.{late}")
    for sink in sinks:
        if sink.trouble and getattr(sink, "untold", 0):
            print(f"{sink.untold} of them were not told: {sink.trouble}.", file=sys.stderr)


def _draw(moment, live):
    words = line_of(moment)
    if not live:
        print(words, flush=True)
        return
    print("\r\033[K" + words[: shutil.get_terminal_size().columns - 1], end="", flush=True)


def line_of(moment: Moment) -> str:
    """A moment in one line of text."""
    place = "-"
    if moment.track is not None:
        p = moment.track.position
        place = f"x {p.x_mm:.0f}  y {p.y_mm:.0f}  depth {p.depth_mm:.0f} mm"
    cpu = f"{moment.cpu_percent:3.0f}" if moment.cpu_percent else "  -"  # 0: no second has passed
    return (
        f"{moment.frame.time_s:7.1f} s  {place:34s} {moment.rate_hz:3.0f}/s  {moment.latency_ms:3.0f} ms  "
        f"CPU {cpu} %  {moment.rss_mb:4.0f} MB  {moment.said}"
    )


def run_log(options: argparse.Namespace) -> int:
    """Summarise the log of a run, draw it, and give it as a table."""
    from stereo_lab.live.log import read_log, write_csv

    found = read_log(options.file)
    for out in filter(None, (options.csv, options.plot, options.json)):
        if Path(out).resolve() == Path(options.file).resolve():
            raise StereoLabError(f"{out} is the log itself, and is not written over. Name another file.")
    summary = found.summary()
    print(*summary_lines(found, summary), sep="\n")
    if options.csv:
        write_csv(found, options.csv)
        print(f"written: {options.csv}")
    if options.plot:
        from stereo_lab.plots.lesson07 import run_page

        run_page(found, options.plot)
        print(f"written: {options.plot}")
    write_json_option(options.json, {"header": found.head, **summary})
    return OK


def summary_lines(found: Run, summary: dict) -> list[str]:
    """The summary of a log in words."""
    head = found.head
    lines = [f"{head.get('source')} on {head.get('started')}, arm {head.get('arm') or 'none'}"]
    lines.append(
        f"{summary['pictures']} pairs in {summary['seconds']:.1f} s, the ball seen in {summary['seen']}; {summary['dropped']} dropped"
    )
    for name, words, unit in (
        ("rate_hz", "rate", "/s"), ("latency_ms", "picture to order", " ms"), ("find_ms", "  finding the ball", " ms"),
        ("steer_ms", "  steering", " ms"), ("cpu_percent", "CPU, of one core", " %"), ("rss_mb", "memory", " MB"),
    ):  # fmt: skip
        if (told := summary[name]) is not None:
            lines.append(f"{words:20s} mean {told['mean']:.1f}{unit}, 95 % {told['p95']:.1f}, most {told['max']:.1f}")
    lines += [f"  {count:6d} x {words}" for words, count in sorted(summary["said"].items(), key=lambda row: -row[1])]
    if summary["broken_lines"]:
        lines.append(f"{summary['broken_lines']} line(s) could not be read and are left out.")
    return lines


def run_watch(options: argparse.Namespace) -> int:
    """Show a line a bench, until Ctrl-C or its time is over; WANTING where the broker is away then."""
    from stereo_lab.live.telemetry import Watch

    until = time.monotonic() + (float("inf") if options.seconds is None else options.seconds)
    watch, drawn = Watch(options.host), 0
    live = sys.stdout.isatty()
    try:
        while time.monotonic() < until:
            time.sleep(min(WATCH_S, max(0.0, until - time.monotonic())))
            lines = [*watch.lines(), watch.trouble] if watch.trouble else watch.lines()
            if live and drawn:
                print(f"\033[{drawn}F\033[J", end="")
            print(*lines, sep="\n", flush=True)
            drawn = len(lines)
    except KeyboardInterrupt:
        pass
    finally:
        trouble = watch.trouble  # before it closes: an end is one, too
        watch.close()
    return WANTING if trouble else OK

"""The command of lesson 09: train."""

from __future__ import annotations

import argparse

from stereo_lab.cli.options import Add, add_recording
from stereo_lab.cli.terminal import OK, Progress, me, write_json_option
from stereo_lab.common.files import typed


def add_to(add: Add) -> None:
    """The commands and their options."""
    train = add(
        "train", run_train, "Learn a ball of your own from pictures in which it is marked, and say how it does on others.",
        "train clutter --out ball.json",
    )  # fmt: skip
    add_recording(train)
    train.add_argument(
        "--out", dest="ball", required=True, metavar="FILE", help="the ball to write (.json); --color FILE uses it"
    )
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


def run_train(options: argparse.Namespace) -> int:
    """Learn a ball from marked pictures, write it, and say how it did on pictures it had not seen. The exit code is OK."""
    from stereo_lab.common.shares import told
    from stereo_lab.detection import OwnBall
    from stereo_lab.detection.weights import SHIPPED
    from stereo_lab.recording.marks import read_marks, shots_of

    marks = read_marks(options.marks) if options.marks else None
    shots = shots_of(options.recording, options.set_name, marks or ())
    marks_proposed = marks is None
    options.color = options.color or _usual_color(options.recording)
    if marks is None:
        marks = _proposed(options, shots)
    with Progress() as progress:
        ball = OwnBall.train(
            [shots[name] for name in marks], list(marks.values()), options.color if options.by_name else None,
            None if options.from_nothing else SHIPPED, tuple(marks), str(options.recording) + ", marks proposed" * marks_proposed,
            progress=lambda done, total: progress("look at the pictures", done, total),
        )  # fmt: skip
    ball.save(options.ball)
    facts, judged = ball.trained_on, ball.unseen
    print(f"Learned from {facts['balls']} pictures with the ball and {facts['empty']} without, from {facts['from']}.")
    if facts["no_outline_at_the_mark"]:
        print(f"Not learned from: {', '.join(facts['no_outline_at_the_mark'])}. No outline lies at the mark.")
    print(f"Pictures it had not seen: the ball right in {told(judged['right'], judged['balls'])};")
    print(f"  something named where no ball is in {told(judged['answered'], judged['empty'])}.")
    if marks_proposed:
        print("  These pictures marked themselves: only the easy ones do. Mark some by hand before you trust this.")
    print(f"  (The last two numbers: between them lies the true share, with 95 %.) {_of_the_test(judged)}".rstrip())
    print(f"{options.ball} is written. Use it: {me()} detect IMAGE --color {typed(options.ball)}")
    write_json_option(options.json, {"trained_on": facts, "unseen": judged})
    return OK


def _of_the_test(judged):
    if not judged["pictures_alike"]:
        return ""
    return "\nAll pictures look alike, so this test means nothing: mark the ball in other places and other light."


def _usual_color(recording):
    """The name of the ball's colour where none is given: a film does not tell it."""
    from stereo_lab.recording import is_video, open_recording

    return "red" if recording is not None and is_video(recording) else open_recording(recording).ball.color


def _proposed(options, shots):
    """The marks that a named colour proposes, told."""
    from stereo_lab.detection.marked import propose

    names = list(shots)
    marks = {names[k]: circle for k, circle in propose(list(shots.values()), options.color).items()}
    print(f"No marks are given. By the name {options.color} these mark themselves; look at each of them:")
    for name, circle in marks.items():
        place = (
            f"u {circle[0]:.0f}  v {circle[1]:.0f}  radius {circle[2]:.0f} px"
            if circle
            else "taken as empty, for nothing marks itself. Is it?"
        )
        print(f"  {name}: {place}")
    return marks

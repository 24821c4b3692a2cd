"""The commands for whoever takes the course: start, reset, progress."""

from __future__ import annotations

import argparse
import os
import re
import signal
import subprocess
import sys
from pathlib import Path

from stereo_lab.cli.options import Add, add_name, add_recording
from stereo_lab.cli.terminal import OK, me, whose, write_json_option
from stereo_lab.errors import StereoLabError


def add_to(add: Add) -> None:
    """The commands and their options."""
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
    add_name(start)

    reset = add("reset", run_reset, "Begin a lesson afresh; what you had is kept beside it.", "reset 03")
    reset.add_argument("lesson", metavar="LESSON", help="its number")
    add_name(reset)

    progress = add("progress", run_progress, "Say how far you are.", "progress")
    add_recording(progress)
    add_name(progress)


def run_start(options: argparse.Namespace) -> int:
    """Lay out the learner's folder and open a lesson in JupyterLab. The exit code is OK, or what JupyterLab ends with."""
    from stereo_lab.classroom.handing import seat_of_lesson
    from stereo_lab.exercises.language import settle_language
    from stereo_lab.recording.places import DATA, PACKAGE, check_shelves
    from stereo_lab.work import SEAT, find, lay_out, seat_of

    if options.data is not None:
        os.environ[DATA] = os.path.abspath(options.data)  # for the kernels, and for what this one looks for
    check_shelves()
    language = settle_language()
    lessons, folder = _lessons(), work_folder(options.name)
    lesson = find(lessons, options.lesson)
    made, older = lay_out(lessons, folder)
    print(f"Your lessons lie in {folder}" + (": they stay yours, and no newer kit writes over them." if made else "."))
    if language:
        print(f"{language} A lesson that nobody has begun is in it.")
    for name in older:
        seated = name.endswith(".ipynb") and seat_of_lesson(folder / name) != seat_of(folder)
        why = f"{name} has other numbers than your seat's recording" if seated else f"The kit has a newer {name}"
        print(f"{why}. Yours is kept; {me()} reset {name[:2]}{whose(options.name)} gives the new one beside it.")
    # An empty home has no list of fonts yet; made now, the first figure need not wait for it.
    fonts = subprocess.Popen([sys.executable, "-c", "import matplotlib.font_manager"], stderr=subprocess.DEVNULL)
    environment = {**os.environ, "STEREO_LAB_WORK": str(folder)}
    if seat_of(folder) is not None:
        environment.setdefault("STEREO_LAB_RECORDING", str(folder / SEAT))
    command = [sys.executable, "-m", "jupyterlab", str(folder / lesson.name), f"--ServerApp.root_dir={folder}"]
    command.append(f"--LabApp.extra_labextensions_path={PACKAGE / 'widgets' / 'page'}")
    # A class at work is asked nothing and nothing is fetched.
    command += ["--LabApp.news_url=None", "--LabApp.check_for_updates_class=jupyterlab.NeverCheckForUpdate"]
    with _jupyterlab(command + options.for_jupyterlab, environment) as lab, fonts:
        while True:
            try:
                return lab.wait()
            except KeyboardInterrupt:
                continue  # JupyterLab got it as well, and asks whether it is meant


def _jupyterlab(command, environment):
    """It ends with this program, or with the terminal's window, and shuts its kernels down then: they let go of their arms."""
    hang_up = getattr(signal, "SIGHUP", signal.SIGTERM)
    # JupyterLab inherits that it is ignored: by itself it would die of it at once, and its kernels with it
    before = signal.signal(hang_up, signal.SIG_IGN)
    lab = subprocess.Popen(command, env=environment)
    for number in {signal.SIGTERM, hang_up if before == signal.SIG_DFL else signal.SIGTERM}:
        signal.signal(number, lambda *_: lab.terminate())
    return lab


def run_reset(options: argparse.Namespace) -> int:
    """Lay a fresh copy of a lesson into the learner's folder and keep the old one. The exit code is OK."""
    from stereo_lab.exercises.language import settle_language
    from stereo_lab.work import reset

    settle_language()
    folder = work_folder(options.name)
    if not folder.is_dir():  # a name that is mistyped makes no learner
        raise StereoLabError(no_work(folder, options.name))
    fresh, kept = reset(_lessons(), folder, options.lesson)
    print(f"{fresh} is as new." + (f" What you had is now {kept.name}." if kept else ""))
    return OK


def run_progress(options: argparse.Namespace) -> int:
    """Print how many questions of each lesson are passed. The exit code is OK."""
    os.environ["STEREO_LAB_WORK"] = str(work_folder(options.name))
    from stereo_lab.exercises import LESSONS, asked_in, progress
    from stereo_lab.recording import open_recording

    folder = work_folder(options.name)
    if not folder.is_dir() and options.name:
        raise StereoLabError(no_work(folder, options.name))
    if not folder.is_dir():
        print(no_work(folder, None))
    recording, known, table = open_recording(options.recording), progress.load(), {}
    for lesson in LESSONS:
        asked = [q.number for q in asked_in(lesson, recording)]
        passed = sorted(set(known.get(lesson, [])) & set(asked))
        table[lesson] = {"passed": passed, "questions": len(asked)}
        left = ", ".join(f"{int(lesson)}.{k}" for k in asked if k not in passed)
        hint = f"   open: {left}" if passed and left else ""
        print(f"lesson {lesson}  {'#' * len(passed):8s} {len(passed)} of {len(asked)}{hint}")
    write_json_option(options.json, {"folder": str(folder), "lessons": table})
    return OK


def if_new(folder: Path) -> str:
    """What to say of a work folder that is not there before a command makes it: its name may be mistyped. Else ""."""
    return "" if folder.is_dir() else f"{folder.name} is a new folder. Whoever has one already names it with --name."


def no_work(folder: Path, name: str | None) -> str:
    """What to say where somebody has not begun yet, or has named nobody."""
    begin = "Begin with:" if name else "Name whose it is with --name, or begin with:"
    return f"There is no work in {folder} yet. {begin} {me()} start{whose(name)}"


def _lessons() -> Path:
    """Where the kit's own notebooks are."""
    from stereo_lab.recording.places import course

    return course() / "notebooks"


def work_folder(name: str | None) -> Path:
    """The work folder: beside lab.py, or in the home where nobody may write there; one for each name."""
    if name is not None and not re.fullmatch(r"[\w.-]{1,40}", name):
        raise StereoLabError(f"A name of letters, figures, - and _ is expected after --name, got {name!r}.")
    if name is None and os.environ.get("STEREO_LAB_WORK"):
        return Path(os.environ["STEREO_LAB_WORK"]).absolute()
    from stereo_lab.recording.places import REPOSITORY, is_repository

    whose = "work" + (f"-{name}" if name else "")
    beside = is_repository() and os.access(REPOSITORY, os.W_OK)
    return REPOSITORY / whose if beside else Path.home() / "stereo_lab" / whose

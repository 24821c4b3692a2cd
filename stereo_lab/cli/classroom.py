"""The commands between a learner and the teacher: variant, hand-in, grade."""

from __future__ import annotations

import argparse
import re
import time
from pathlib import Path

from stereo_lab.cli.options import Add, add_json, add_name, whole
from stereo_lab.cli.terminal import OK, Progress, write_json_option
from stereo_lab.errors import StereoLabError

MOST_TOLD = 20  # files that are named one by one


def add_to(add: Add) -> None:
    """The commands and their options."""
    variant = add(
        "variant", run_variant, "Make a recording for one seat: other boards, balls, lengths and numbers than the neighbour's.", "variant 17",
    )  # fmt: skip
    variant.add_argument(
        "seed", type=whole, metavar="SEED", help="the number of the seat; the same one gives the same recording"
    )
    variant.add_argument("--out", metavar="DIR", help="a folder to make (default: seat, in the learner's folder)")
    add_name(variant)

    hand = add("hand-in", run_hand_in, "Write a lesson as one file for the teacher, under a code name.", "hand-in 02")
    hand.add_argument("lesson", metavar="LESSON", help="its number")
    hand.add_argument(
        "--with", action="append", default=[], dest="together_with", metavar="CODE", help="the code name of whoever worked on it with you; once for each"
    )  # fmt: skip
    hand.add_argument("--code-name", metavar="CODE", help="yours, if you do not want the one that was made for you")
    hand.add_argument("--out", metavar="DIR", help="where to write the file (default: handed_in, in your folder)")
    add_name(hand)

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
    mark.add_argument("--jobs", type=whole, metavar="N", help="notebooks at a time (default: one for each core)")
    mark.add_argument("--recording", metavar="REC", help="what the class worked on (default: as for demo)")
    add_json(mark)


def run_hand_in(options: argparse.Namespace) -> int:
    """Write a lesson as one file for the teacher. The exit code is OK."""
    from stereo_lab.classroom.handing import hand_in
    from stereo_lab.cli.course import no_work, work_folder
    from stereo_lab.cli.terminal import me, whose
    from stereo_lab.recording.places import course
    from stereo_lab.work import MARK, find

    def command(what: str) -> str:
        return f"{me()} {what}{whose(options.name)}"

    folder, lessons = work_folder(options.name), course() / "notebooks"
    find(lessons, options.lesson)  # no such lesson is said first
    if not (folder / MARK).is_file():
        raise StereoLabError(no_work(folder, options.name))
    out = Path(options.out) if options.out else folder / "handed_in"
    done = hand_in(lessons, folder, options.lesson, out, options.together_with, options.code_name, command)
    goes_by = f"code name{'s' * (len(done.learners) > 1)} {' and '.join(done.learners)}"
    print(f"{done.path}\nGive this file to your teacher. It goes by the {goes_by}: note it down.")
    print(
        f"It holds what was saved at {done.saved}: {done.answered} of {done.questions} blanks are filled. You may hand in again, the latest counts."
    )
    return OK


def run_variant(options: argparse.Namespace) -> int:
    """Make the recording of one seat. The exit code is OK."""
    from stereo_lab.classroom.handing import begun
    from stereo_lab.classroom.variants import make_variant
    from stereo_lab.cli.course import if_new, work_folder
    from stereo_lab.cli.terminal import me, whose
    from stereo_lab.work import SEAT, seat_of

    folder = work_folder(options.name)
    out = Path(options.out) if options.out else folder / SEAT
    if not options.out and (had := seat_of(folder)) is not None:
        raise StereoLabError(
            f"The recording of seat {had} is in {out} already. Move that folder away to take another seat."
        )
    new = "" if options.out else if_new(folder)
    with Progress() as progress:
        progress("the recording", 0, 1)
        recording = make_variant(options.seed, out)
    if new:
        print(new)
    print(f"{out}: {recording.title}.")
    print(
        f"Squares of {recording.board.square_mm:g} mm, links of {recording.arm.l1_mm:g} and {recording.arm.l2_mm:g} mm."
    )
    if options.out:
        print(f'Open it by its name: open_recording("{out}").')
        return OK
    print(f"The lessons open with it: {me()} start{whose(options.name)}")
    for name in begun(folder):
        print(
            f"{name} is begun, and keeps the numbers that it had: hand it in as it is, or begin it anew with {me()} reset {name[:2]}{whose(options.name)}"
        )
    return OK


def run_grade(options: argparse.Namespace) -> int:
    """Run and mark what a class has handed in; write the table. The exit code is OK."""
    from stereo_lab.classroom.grading import grade
    from stereo_lab.classroom.marks import tally
    from stereo_lab.classroom.page import write_page
    from stereo_lab.classroom.papers import not_looked_at, whole_work_folders
    from stereo_lab.classroom.table import read_teacher, write_table
    from stereo_lab.exercises import asked_in
    from stereo_lab.exercises.language import settle_language
    from stereo_lab.recording import open_recording

    language, table, due = settle_language(), Path(options.csv), _due(options.due)
    kept = table.with_suffix(".grade.json")
    for name, out in (("--html", options.html), ("--json", options.json)):
        if out and Path(out).resolve() in (table.resolve(), kept.resolve()):
            raise StereoLabError(
                f"The table and {kept.name} stand beside each other: name another file than {out} with {name}."
            )
    if options.jobs is not None and options.jobs < 1:
        raise StereoLabError(f"Expected a number of notebooks at a time after --jobs, 1 or more; got {options.jobs}.")
    before = read_teacher(table)  # what is no class table is not written over
    recording = open_recording(options.recording)
    with Progress() as progress:
        graded = grade(
            Path(options.folder),
            recording,
            kept,
            lambda: read_teacher(table),
            due,
            options.jobs,
            progress,
            options.by_folder,
        )
    lessons = sorted({row.lesson for row in graded.rows if row.lesson})
    tallies = {lesson: tally(graded.rows, lesson, asked_in(lesson, recording)) for lesson in lessons}
    write_table(table, graded.rows)
    if options.html:
        write_page(Path(options.html), graded.rows, tallies, [graded.how])
    for lesson, counts in tallies.items():
        print(f"lesson {lesson}")
        for count in counts:
            print(f"  {count.name}  {count.passed} of {count.learners} passed, {count.not_attempted} not attempted")
            for why, number in count.fell_for[:3]:
                print(f"       {number} of {count.learners}: {why}")
    if gone := sorted({lesson for _, lesson in before if lesson} - set(lessons)):
        print(
            f"{table} had rows of lesson {', '.join(gone)}, of which nothing is in {options.folder}: they are not in it any more. Name a table for each folder."
        )
    for file, why in sorted(graded.not_run):
        print(f"Not run: {file}: {why}.")
    own = {Path(out).resolve() for out in (table, kept, options.html, options.json) if out}
    folder = Path(options.folder)
    if others := [name for name in not_looked_at(folder) if (folder / name).resolve() not in own]:
        more = f" and {len(others) - MOST_TOLD} more" if len(others) > MOST_TOLD else ""
        print(f"Not looked at, for a notebook ends in .ipynb: {', '.join(others[:MOST_TOLD])}{more}.")
    if not options.by_folder and (whole := whole_work_folders(folder)):
        print(
            f"Whole work folders: {', '.join(whole[:MOST_TOLD])}. What was handed in there has a row of its own, under a code name; with --by-folder each folder is one learner."
        )
    for line in graded.unknown:
        print(line)
    if language:
        print(f"{language} Its words and English ones count: choose that of the class.")
    print(f"{graded.how}\n{table}: {len(graded.rows)} rows, {graded.run} notebooks run now.")
    write_json_option(options.json, {"how": graded.how, "rows": [row.as_json() for row in graded.rows]})
    return OK


def _due(text):
    """A day, or a day and a time."""
    if text and not (re.fullmatch(r"\d{4}-\d\d-\d\d( \d\d:\d\d)?", text) and _is_a_time(text)):
        raise StereoLabError(f'Expected a day such as 2026-10-05, or "2026-10-05 12:00", after --due; got {text!r}.')
    return text or ""


def _is_a_time(text):
    try:
        return bool(time.strptime(text, "%Y-%m-%d %H:%M" if " " in text else "%Y-%m-%d"))
    except ValueError:
        return False

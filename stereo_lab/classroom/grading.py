"""Grading a class: a folder of notebooks in, a row for each learner and lesson out."""

from __future__ import annotations

import hashlib
import os
import re
import tempfile
import threading
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from pathlib import Path

import psutil

import stereo_lab
from stereo_lab.classroom.examiner import Examiner
from stereo_lab.classroom.line import Limits
from stereo_lab.classroom.marking import marks_of, stops_of
from stereo_lab.classroom.marks import Mark, Row
from stereo_lab.classroom.missing import CHECK, with_what_is_missing
from stereo_lab.classroom.opened import digest_of, name_of, on_a_shelf, opened, opens_what_it_gets
from stereo_lab.classroom.papers import Cell, Paper, kit_cells, latest, papers_in, written
from stereo_lab.classroom.room import BUBBLEWRAP, NAMESPACE, NOTHING, PACKAGE, Room, build_room
from stereo_lab.classroom.store import Store
from stereo_lab.classroom.table import Marks
from stereo_lab.classroom.variants import BASES, make_variant
from stereo_lab.classroom.wire import legible
from stereo_lab.errors import StereoLabError
from stereo_lab.exercises import NEEDS, PLACES, asked_in
from stereo_lab.exercises.answers import NOT_ATTEMPTED, PASS
from stereo_lab.exercises.question import Question
from stereo_lab.recording import Recording, open_recording
from stereo_lab.recording.needs import lacks
from stereo_lab.recording.places import course
from stereo_lab.work import chosen_language

LESSONS = course() / "notebooks"
TIMES = 3  # so many times as long as the reference a notebook may take
LEAST = Limits(cell=10.0, whole=30.0)  # and never less than this, seconds
FIRST_RUN = Limits(cell=240.0, whole=900.0)  # of the reference itself
SOURCE = re.compile(r"""^source_name = "([^"]*)\"""", re.MULTILINE)
NOT_HERE = "it opens the recording {}, which is not here. Name its folder with --recording"
Which = int | Path | None
HOW = {
    BUBBLEWRAP: "Each notebook ran by itself, shut in by bubblewrap: without network, and with no files but the kit.",
    NAMESPACE: "Each notebook ran by itself and without network. bubblewrap is not to be had here, so it could read this computer's files.",
    NOTHING: "Each notebook ran by itself. This system cannot keep it from the network or from this computer's files: grade what "
    "strangers hand in on Linux with bubblewrap.",
}


@dataclass(frozen=True)
class Graded:
    """What comes out.

    Attributes
    ----------
    rows : list of Row, by learner and lesson
    how : str, what the notebooks were kept from
    run : int, notebooks that were run now; the others had been run before
    unknown : list of str, what is to say of marks in the table that are nobody's
    not_run : list of (file, why), of notebooks that cannot be run
    """

    rows: list[Row]
    how: str
    run: int
    unknown: list[str]
    not_run: list[tuple[str, str]] = field(default_factory=list)


def grade(
    folder: Path,
    recording: Recording,
    kept: Path,
    teacher: Callable[[], Marks] = dict,
    due: str = "",
    cores: int | None = None,
    progress: Callable[[str, int, int], None] = lambda *_: None,
    by_folder: bool = False,
) -> Graded:
    """Run and mark all notebooks of a folder, the latest of each learner and lesson.

    Parameters
    ----------
    folder : Path, of notebooks; never written to
    recording : Recording, that of the class
    kept : Path
        A JSON file in which finished rows are kept: what is stopped goes on there, and what has not changed is not run again.
    teacher : callable, gives a teacher's marks as :func:`read_teacher` does; asked last, for a class takes minutes
    due : str, such as "2026-10-05 12:00"; later is late
    cores : int, optional, notebooks at a time; without it, one for each core
    progress : callable, gets (what, done, all)
    by_folder : bool, whether the notebook's folder tells whose it is, and not what stands in the notebook

    Raises
    ------
    StereoLabError
        If there is nothing to grade, the kit's own solutions do not pass on the recording, or the disk is full.
    """
    handed_in, store = papers_in(folder, by_folder), Store(kept)
    store.save()  # a folder that cannot be written to is told before minutes of work
    desk = _Examiners(recording, store)
    found = latest([desk.with_recording(paper) for paper in handed_in])
    papers = list({(p.file, p.lesson): p for p, *_ in found.values()}.values())
    waiting = [p for p in papers if not p.trouble and desk.key(p) not in store.rows]
    if waiting:
        with tempfile.TemporaryDirectory(prefix="stereo_lab_") as rooms:
            desk.open(Path(rooms), waiting, progress)
            _run_all(desk, waiting, store, cores or _cores(), progress)
    store.name(found)
    unknown = store.remember(teacher())
    rows = [_row(learner, lesson, given, desk, store, due) for (learner, lesson), given in found.items()]
    how = HOW[store.how] if waiting else "No notebook had to be run."
    return Graded(rows, how, len(waiting), unknown, [(p.file, p.trouble) for p in papers if p.trouble])


def _run_all(desk, waiting, store, cores, progress):
    """Several at a time; what is finished is kept at once."""
    pool = ThreadPoolExecutor(min(cores, len(waiting)))
    try:
        futures = {pool.submit(desk.examine, paper): paper for paper in waiting}
        for done, future in enumerate(as_completed(futures), 1):
            paper = futures[future]
            store.keep(desk.key(paper), future.result())
            progress(paper.file, done, len(waiting))
    finally:
        desk.halt.set()
        pool.shutdown(cancel_futures=True)


class _Examiners:
    """An examiner for each lesson and recording, and what it needs of the kit.

    A recording is asked for by its seat, by its folder where a notebook names another one than the class's, else by None.
    """

    def __init__(self, recording: Recording, store: Store) -> None:
        self.recording, self.store, self.halt = recording, store, threading.Event()
        self._asked: dict[tuple[str, Which], tuple[Question, ...]] = {}
        self._recordings: dict[Which, Recording] = {None: recording}
        self._lock = threading.RLock()
        self._edition: dict[tuple[str, Path | None], str] = {}
        self._folder, self._room = Path(), Room(Path(), NOTHING)
        self._limits: dict[tuple[str, str], Limits] = {}

    def with_recording(self, paper: Paper) -> Paper:
        """The notebook with the recording that it opens, where that is another one; with what to do where that is not here."""
        told = "" if paper.trouble or paper.seat is not None else opened(paper.code)
        if not told or name_of(told) == self.recording.path.name:
            return paper
        folder = on_a_shelf(told)
        if folder is None and self.recording.path == _bench():
            return replace(paper, trouble=NOT_HERE.format(legible(told, 80)))
        if folder is None or lacks(self._recording(folder), *NEEDS.get(paper.lesson, PLACES)):
            return paper  # the class's stands in for what is not there
        return replace(paper, recording=folder)

    def asked(self, lesson: str, which: Which = None) -> tuple[Question, ...]:
        """The questions of a lesson, worked out once for each recording."""
        with self._lock:
            if (lesson, which) not in self._asked:
                self._asked[lesson, which] = asked_in(lesson, self._recording(which))
            return self._asked[lesson, which]

    def key(self, paper: Paper) -> str:
        """What a finished row is kept under: it holds as long as notebook, recording and kit are the same."""
        return f"{paper.digest}/{paper.lesson}/{paper.seat}/{self.edition(paper.lesson, paper.recording)}"

    def edition(self, lesson: str, named: Path | None = None) -> str:
        """A lesson of this kit on the class's recording, or on one that a notebook names."""
        if (lesson, named) not in self._edition:
            whole = hashlib.sha256(f"{self._kit} {digest_of(self._recording(named))}".encode())
            for file in LESSONS.glob(f"{lesson}_*.ipynb"):
                whole.update(file.read_bytes())
            self._edition[lesson, named] = whole.hexdigest()[:16]
        return self._edition[lesson, named]

    @cached_property
    def _kit(self):
        """A digest of what all lessons run on: the kit's own code, and the language of the class."""
        whole = hashlib.sha256(stereo_lab.__version__.encode())
        language = (LESSONS / chosen_language()).glob("*") if chosen_language() else ()
        for file in sorted([*PACKAGE.rglob("*.py"), *filter(Path.is_file, language)]):
            whole.update(file.read_bytes())
        return whole.hexdigest()

    def open(self, folder: Path, papers: Iterable[Paper], progress: Callable[[str, int, int], None]) -> None:
        """Lay out the room, and see for each lesson that the reference passes and how long it takes."""
        self._folder, self._room = folder, build_room(folder)
        self.store.how = self._room.shut_by
        first: dict[tuple[str, str], Paper] = {}
        for paper in papers:
            first.setdefault((paper.lesson, self._base(paper)), paper)
        for (lesson, base), paper in sorted(first.items(), key=lambda item: item[0]):
            progress(f"the kit's own solutions of lesson {lesson}", 0, 1)
            kept, which = f"{self.edition(lesson, paper.recording)}/{base}", _which(paper)
            limits = self.store.limits(kept)
            try:
                limits = limits or _limits(
                    self._examiner(lesson, which, FIRST_RUN), self.asked(lesson, which), paper.seat
                )
            except StereoLabError:
                if paper.recording is None:
                    raise
                continue  # what one notebook names does not stop the others
            self.store.keep_limits(kept, limits)
            self._limits[lesson, base] = limits

    def examine(self, paper: Paper) -> Row:
        """The row of one notebook, without its learner; what nobody has foreseen costs no other row."""
        try:
            return self._examined(paper)
        except StereoLabError:  # nothing that another notebook would not run into as well
            raise
        except Exception as error:
            why = f"the grading itself stumbled over it ({type(error).__name__}). Look at it, and write your marks into the table"
            return self._blank(paper, why)

    def _blank(self, paper, why, text=()):
        """The row of a notebook of which nothing can be told but why."""
        marks = tuple(Mark(NOT_ATTEMPTED) for _ in self.asked(paper.lesson))
        return Row("", paper.lesson, paper.file, "", marks, (why,), text)

    def _examined(self, paper):
        kit = kit_cells(LESSONS, paper.lesson, paper.seat)
        text = tuple(written(paper.cells, kit))
        if not any(".check(" in source for source in paper.code):
            return self._blank(paper, "there is no question in it", text)
        limits = self._limits.get((paper.lesson, self._base(paper)))
        if limits is None:
            return self._blank(
                paper, f"the kit's own solutions do not pass on {self._base(paper)}, which it opens", text
            )
        code, put_back, checks = with_what_is_missing(paper.cells, kit)
        examiner = self._examiner(paper.lesson, _which(paper), limits)
        heard = examiner.examine(opens_what_it_gets(code), int(paper.digest[:12], 16))
        if self.halt.is_set():
            raise StereoLabError("Grading was stopped.")
        marks = marks_of(paper, code, heard, len(self.asked(paper.lesson)))
        notes = [f"seat {paper.seat}"] if paper.seat is not None else []
        notes += _recording_note(paper, self._recording(_which(paper)).name)
        notes += [f"{put_back} of the kit's cells were put back"] if put_back else []
        names = ", ".join(f"{int(paper.lesson)}.{number}" for number in checks)
        notes += [f"checks that were not there were put back: {names}"] if checks else []
        notes += stops_of(heard.stopped)
        notes += [heard.ended] if heard.ended and heard.ended_in is None else []
        return Row("", paper.lesson, paper.file, "", marks, tuple(notes), text)

    def _examiner(self, lesson, which, limits):
        recording = self._recording(which).path
        own = None if recording == _bench() else recording
        asked = partial(self.asked, which=which)
        return Examiner(self._room, lesson, asked, limits, own, self.halt, source_of(kit_cells(LESSONS, lesson)))

    def _recording(self, which):
        """A recording, opened or for a seat made when it is asked for."""
        with self._lock:
            if which not in self._recordings:
                self._recordings[which] = (
                    make_variant(which, self._folder / "seats" / str(which))
                    if isinstance(which, int)
                    else open_recording(which)
                )
            return self._recordings[which]

    def _base(self, paper):
        """What decides how long a lesson takes: which pictures a recording has."""
        return self._recording(paper.recording).name if paper.seat is None else BASES[paper.seat % len(BASES)]


def _bench():
    return (course() / "data" / "bench").resolve()


def _which(paper):
    return paper.recording if paper.seat is None else paper.seat


def _recording_note(paper, judged_by):
    """What to know of a notebook that names a recording."""
    told = opened(paper.code)
    if paper.recording is not None:
        return [f"on the recording {judged_by}"]
    whose = judged_by if paper.seat is None else f"the recording of seat {paper.seat}"
    return [f"it opens {legible(told, 80)}, and is judged by {whose}"] if told and name_of(told) != judged_by else []


def _limits(examiner, asked, seat):
    """Time limits from a run of the kit's own solutions, which must pass."""
    heard = examiner.examine(solved(examiner.lesson, asked, seat), 0)
    wrong = [q.name for q in asked if q.number not in heard.answers or heard.answers[q.number].verdict.status != PASS]
    if wrong and not examiner.halt.is_set():
        stopped = "; ".join(f"cell {k + 1}: {why}" for k, why in sorted(heard.stopped.items()))
        raise StereoLabError(
            f"The kit's own solutions of lesson {examiner.lesson} do not pass here ({', '.join(wrong)}). "
            f"{heard.ended or stopped or 'Look at the recording with: stereo-lab check'}"
        )
    return Limits(max(LEAST.cell, TIMES * max(heard.seconds)), max(LEAST.whole, TIMES * sum(heard.seconds)))


def solved(lesson: str, asked: tuple[Question, ...], seat: int | None = None) -> list[str]:
    """The code of the kit's own notebook of a lesson, with the solutions in the place of the blanks."""
    cells = []
    for cell in kit_cells(LESSONS, lesson, seat):
        found = CHECK.search(cell.source) if cell.code else None
        source = f"{asked[int(found.group(1)) - 1].code}\n{cell.source[found.start() :]}" if found else cell.source
        cells += [source] if cell.code else []
    return cells


def source_of(kit: tuple[Cell, ...]) -> str:
    """Where the kit's own notebook takes live pictures from; "" where it takes none."""
    found = (SOURCE.search(cell.source) for cell in kit if cell.code)
    return next((named.group(1) for named in found if named), "")


def _row(learner, lesson, given, desk, store, due):
    """One learner's row: the latest that was handed in, and what there is to say of it."""
    paper = given[0]
    notes = [paper.trouble] if paper.trouble else []
    if len(given) > 1:
        notes.append(f"handed in {len(given)} times, the latest counts")
    if due and paper.handed_in[: len(due)] > due:
        notes.append("late")
    if len(paper.learners) > 1:
        notes.append("together with " + ", ".join(other for other in paper.learners if other != learner))
    if paper.trouble:
        blank = tuple(Mark(NOT_ATTEMPTED) for _ in desk.asked(lesson)) if lesson else ()
        row = Row(learner, lesson, paper.file, paper.handed_in, blank, tuple(notes))
    else:
        run = store.row(desk.key(paper))
        row = Row(learner, lesson, paper.file, paper.handed_in, run.marks, (*notes, *run.notes), run.written)
    return row.marked_by(store.teacher(learner, lesson))


def _cores():
    """How many notebooks run at a time: one for each core that this program may use, as far as memory goes."""
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return max(1, min(cores, int(psutil.virtual_memory().available / 700_000_000)))

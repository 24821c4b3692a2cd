"""Outside the room: give a notebook its cells, hear its answers, judge; once more where that is needed to be sure."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from stereo_lab.classroom.hearing import Answer, Heard, Run
from stereo_lab.classroom.line import EndedError, Limits, Line
from stereo_lab.classroom.room import ADDRESSES, Room, close_desk
from stereo_lab.exercises.answers import NOT_YET, PASS, Verdict
from stereo_lab.exercises.question import Question

DEATHS = 3  # times that a notebook is begun again without the cell that ended it
TAKEN = "this is the kit's own answer, taken from it, and none of the learner's."


@dataclass(frozen=True)
class Examiner:
    """Examines notebooks of one lesson on one recording.

    Attributes
    ----------
    room : Room
    lesson : str, such as "03"
    questions_of : callable, the questions of any lesson by its number
    limits : Limits
    recording : Path or None, what ``open_recording()`` opens in there
    halt : Event, set to end all runs at once
    source : str, where the lesson takes its live pictures from, whatever a learner has at home; "" where it takes none
    """

    room: Room
    lesson: str
    questions_of: Callable[[str], tuple[Question, ...]]
    limits: Limits
    recording: Path | None = None
    halt: threading.Event = field(default_factory=threading.Event)
    source: str = ""

    def examine(self, cells: Sequence[str], seed: int) -> Heard:
        """Run a notebook and judge what it answers.

        A cell that ends the run (by leaving, by eating memory, by not stopping) is left out, and the rest is run once more. An
        answer that came after the kit's own was handed out counts if it comes again while that one is kept back.

        Parameters
        ----------
        cells : sequence of str, the code
        seed : int, of the inputs that functions are called with

        Returns
        -------
        Heard
        """
        heard = self._until_its_end(cells, frozenset(), seed)
        late = frozenset(k for k, a in heard.answers.items() if a.after_carry and a.verdict.status == PASS)
        if late:
            # From the beginning: which cells were left out may tell what was carried
            again = self._until_its_end(cells, late, seed).answers
            for k in late:
                own = k in again and again[k].verdict.status == PASS
                heard.answers[k] = again[k] if own else Answer(Verdict(NOT_YET, TAKEN), heard.answers[k].given)
        return heard

    def _until_its_end(self, cells, withheld, seed):
        """What a notebook told, without the cells that ended it."""
        left_out: dict[int, str] = {}
        answers: dict[int, Answer] = {}
        carried: set[int] = set()  # what was handed out in one run may be known in the next
        for _ in range(DEATHS + 1):
            heard = self._run(cells, left_out, withheld, carried, seed)
            answers.update(heard.answers)
            if heard.ended_in is None or self.halt.is_set():
                break
            left_out[heard.ended_in] = heard.ended
        heard.answers = answers
        heard.stopped.update(left_out)
        return heard

    def _run(self, cells, left_out, withheld, carried, seed):
        order = [k for k in range(len(cells)) if k not in left_out]
        process = self.room.open_desk(self.recording)
        line = Line(process, self.limits, self.halt)
        run = Run(line, self.lesson, self.questions_of, len(cells), withheld, carried, seed)
        try:
            line.send(
                cells=list(cells),
                order=order,
                lesson=self.lesson,
                seconds=self.limits.cell,
                memory=ADDRESSES,
                source=self.source,
            )
            run.listen()
        except EndedError as error:
            run.heard.ended, run.heard.ended_in = str(error), line.cell
        finally:
            close_desk(process)
        return run.heard

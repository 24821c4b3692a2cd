"""Pictures shown as they come, while a recorder looks at the newest ones in a thread of its own."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import replace

from stereo_lab.capture.recorder import Recorder, State
from stereo_lab.errors import StereoLabError
from stereo_lab.live.sources import Frame, Pace, StereoSource
from stereo_lab.recording import StereoPair


class Session:
    """A source, a recorder, and whoever shows both.

    Pictures are handed on at their own rate. The recorder takes the newest one whenever it is free, so what it says is as
    old as one of its looks. Looks may be quicker than pictures are shown: a state in which a pair was taken is always
    handed on, others only while they are the newest.

    Parameters
    ----------
    source : StereoSource
    recorder : Recorder
    show : function (Frame or None, State), called for every pair in the thread that runs the session; with None where no
        pair came for a while

    Attributes
    ----------
    frame : Frame or None, the newest; None before the first and while a camera is silent
    state : State, the newest
    """

    def __init__(self, source: StereoSource, recorder: Recorder, show: Callable[[Frame | None, State], object]) -> None:
        self.source, self.recorder, self._show = source, recorder, show
        self.frame: Frame | None = None
        self.state = State(source.now())
        self._ends, self._news = False, threading.Condition()
        self._waiting: Frame | None = None
        self._taken: list[State] = []  # states that nobody was shown yet, in which a pair was taken
        self._failed: Exception | None = None

    def run(self) -> None:
        """Until the pictures end, or :meth:`stop` is called. Whatever the recorder stumbles over is raised here."""
        looking = threading.Thread(target=self._look, name="recorder", daemon=True)
        looking.start()
        try:
            while not self._ends and self._failed is None:
                frame = self._read()
                if frame is None:
                    break
                self.frame = frame
                with self._news:
                    self._waiting = frame
                    self._news.notify()
                self._hand_on()
        finally:
            self.stop()
            looking.join()
        if self._failed is not None:
            raise self._failed
        if self._taken:  # by the look that was under way when it ended
            self._hand_on()

    def _hand_on(self):
        with self._news:
            states, self._taken = self._taken or [self.state], []
        for state in states:
            self._show(self.frame, state)

    def _read(self):
        """The next pair; a camera that fell silent is told and waited for."""
        while not self._ends and self._failed is None:
            try:
                return self.source.read()
            except StereoLabError as error:
                self.frame, self.state = None, replace(self.state, said=str(error), taken="")
                self._show(None, self.state)
        return None

    def _look(self):
        try:
            while True:
                with self._news:
                    self._news.wait_for(lambda: self._ends or self._waiting is not None)
                    frame, self._waiting = self._waiting, None
                if frame is None:
                    return
                state = self.recorder.look(frame)
                with self._news:
                    self.state = state
                    if state.taken:
                        self._taken.append(state)
        except Exception as error:  # handed on to whoever runs the session
            self._failed = error

    def stop(self) -> None:
        """End soon: what the recorder looks at now it finishes."""
        with self._news:
            self._ends = True
            self._news.notify()


class Replay(StereoSource):
    """Pairs of a recording as if somebody held the board: each for a while, then the next one.

    Parameters
    ----------
    pairs : sequence of StereoPair
    hold_s : float, so long each is shown
    rate_hz : float, pairs a second
    clock, sleep : function, seconds and waiting for some
    """

    def __init__(
        self, pairs: Sequence[StereoPair], hold_s: float = 1.5, rate_hz: float = 15.0,
        clock: Callable[[], float] = time.monotonic, sleep: Callable[[float], None] = time.sleep,
    ) -> None:  # fmt: skip
        self.name, self.rate_hz, self.pairs = "replay", rate_hz, pairs
        self.size = pairs[0].left.shape[1::-1]
        self._hold, self._pace, self._next = max(1, round(hold_s * rate_hz)), Pace(rate_hz, clock, sleep), 0
        self._at, self._images = -1, (pairs[0].left, pairs[0].right)

    def read(self) -> Frame | None:
        """The next pair, when it is due; None after the last one."""
        newest = self._pace.due(self._next)
        dropped, self._next = newest - self._next, newest + 1
        at = newest // self._hold
        if at >= len(self.pairs):
            return None
        if at != self._at:
            self._at, self._images = at, (self.pairs[at].left, self.pairs[at].right)
        return Frame(newest / self.rate_hz, *self._images, dropped=dropped)

    def now(self) -> float:
        """The time by the clock of its frames, seconds."""
        return self._pace.now()

    def close(self) -> None:
        """No more pairs come."""
        self.pairs = ()

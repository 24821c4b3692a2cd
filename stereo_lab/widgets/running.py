"""A panel that works in a thread of its own, with play and stop, while the page does something else."""

from __future__ import annotations

import threading
import time
import weakref
from collections.abc import Sequence
from typing import ClassVar

import ipywidgets

from stereo_lab.widgets.panel import PRESS, SILENT_S, TICK_MS, Pictured, answer_while_busy, telling

NOT_HEARD = f"Ended: nothing was heard from this page. {PRESS}"


class Running(Pictured):
    """Play and stop, a line of words, and work in a thread: one press on play, one run.

    ``Play`` ticks while its page is there. Whatever ends a run (stop, a fault, a page that is closed, asleep or without this panel,
    another panel of the kind), the next one waits for a press: an arm must not set off by itself.

    A page that is loaded anew counts once more, and never less, so any page that stops to show the panel ends the run: a second
    tab that is closed as well.

    Attributes
    ----------
    play, text : the buttons and the line of words
    thread : Thread of the run, or None
    """

    _newest: ClassVar[weakref.WeakValueDictionary[str, Running]] = weakref.WeakValueDictionary()

    def __init__(self, silent_s: float = SILENT_S) -> None:
        """Makes ``play`` and ``text``; :meth:`lay_out` puts them on the page."""
        self._silent_s, self._heard_s = silent_s, 0.0
        self._end = threading.Event()  # of the newest run
        self.thread: threading.Thread | None = None
        self.play = ipywidgets.Play(interval=TICK_MS, max=10**6, show_repeat=False)
        self.text = ipywidgets.Label(PRESS)
        super().__init__()
        answer_while_busy(self.play)
        self.play.observe(self._tick, "value")
        self.play.observe(self._pressed, "playing")
        self.play._view_count = 0  # the page counts how often it shows the buttons
        self.play.observe(self._seen, "_view_count")

    def lay_out(self, parts: Sequence[ipywidgets.Widget]) -> None:
        """Put the parts on the page. What a panel of this kind does that was made before ends: it has no buttons any more."""
        self.children = tuple(parts)
        if (older := self._newest.get(type(self).__name__)) is not None:
            older.end()
        self._newest[type(self).__name__] = self

    def work(self, end: threading.Event) -> str:
        """What a run does, from opening to closing; gives the words that are shown at its end."""
        raise NotImplementedError

    def end(self) -> None:
        """Ask the run to end."""
        self._end.set()

    def why_it_ends(self, end: threading.Event) -> str:
        """That an end is asked for, or that the page is gone; empty while neither is so."""
        if end.is_set():
            return f"Ended. {PRESS}"
        return NOT_HEARD if time.monotonic() - self._heard_s > self._silent_s else ""

    def _tick(self, _):
        """The page is there."""
        self._heard_s = time.monotonic()

    def _seen(self, change):
        if (change["new"] or 0) < (change["old"] or 0):
            self.end()

    def _pressed(self, change):
        self.end()
        if change["new"]:
            self._heard_s, self._end = time.monotonic(), threading.Event()
            arguments = (self._end, self.thread)
            self.thread = threading.Thread(target=self._run, args=arguments, name=type(self).__name__, daemon=True)
            self.thread.start()

    def _run(self, end, before):
        """One run, after the one before; whatever stops it is told beside the buttons."""
        try:
            if before is not None:
                before.join()
            with telling(self.text):
                self.text.value = self.why_it_ends(end) or self.work(end)
        finally:
            if end is self._end:
                self.play.playing = False

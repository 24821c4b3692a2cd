"""The recorder's panel, lesson 08: both cameras live, what is seen of the board, bars that fill, and what to do next."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from pathlib import Path

import cv2
import ipywidgets
import numpy as np

from stereo_lab.capture import Folder, Glance, Recorder, Session
from stereo_lab.capture.coverage import CELLS
from stereo_lab.errors import StereoLabError
from stereo_lab.live import CameraSource, StereoSource
from stereo_lab.recording import Ball, Board
from stereo_lab.widgets.panel import BLUE, GREY, ORANGE, PRESS, SILENT_S, TICK_MS, answer_while_busy, fit_width, jpeg

BARS = "pairs", "left picture", "right picture", "near and far", "tilted"
SIDE_PX = 480  # width of one camera's picture in the panel
SHADE = 0.35  # how strongly cells are shaded in which no board was yet
SETS = "position", "depth"


class RecorderPanel(ipywidgets.VBox):
    """Play and stop, bars, both pictures, and places to type in. ``repr`` never changes, so that a notebook's output does not.

    The session lives in a thread. ``Play`` starts it, stops it, and ticks: where the page is closed it ends. What was taken
    stays; pressing play again goes on.

    Parameters
    ----------
    open_pictures : function that gives a StereoSource
    out : folder of the recording
    board, ball : Board and Ball
    silent_s : float, so long without a tick until it ends

    Attributes
    ----------
    thread : Thread of the session, or None
    """

    def __init__(
        self, open_pictures: Callable[[], StereoSource], out: str | Path, board: Board, ball: Ball, silent_s: float = SILENT_S
    ) -> None:  # fmt: skip
        self._open_pictures, self._out, self._board, self._ball = open_pictures, Path(out), board, ball
        self._silent_s, self._heard_s = silent_s, 0.0
        self._session: Session | None = None
        self.thread: threading.Thread | None = None
        self.play = ipywidgets.Play(interval=TICK_MS, max=10**6, show_repeat=False)
        self.text = ipywidgets.Label(PRESS)
        self.bars = {name: _bar(name) for name in BARS}
        self.picture = ipywidgets.Image(format="jpeg", layout=ipywidgets.Layout(max_width="100%"))
        self.picture.value = jpeg(np.full((SIDE_PX * 3 // 4, 2 * SIDE_PX, 3), 230, np.uint8))
        self.place = {name: ipywidgets.FloatText(0, description=f"{name} (mm)") for name in ("x", "y", "depth")}
        self.take = {name: ipywidgets.Button(description=f"ball: {name}") for name in SETS}
        super().__init__([
            ipywidgets.HBox([self.play, self.text]), self.picture, ipywidgets.HBox(list(self.bars.values())),
            ipywidgets.HBox([*self.place.values(), *self.take.values()]),
        ])  # fmt: skip
        answer_while_busy(self.play)
        self.play.observe(self._tick, "value")
        self.play.observe(self._pressed, "playing")
        for name, button in self.take.items():
            button.on_click(lambda _, name=name: self.take_ball(name))

    def __repr__(self):
        return "panel: the recorder"

    def _pressed(self, change):
        if change["new"]:
            self._tick(change)
        elif self._session is not None:
            self._session.stop()

    def _tick(self, _):
        """The page is there. The first tick begins the session."""
        self._heard_s = time.monotonic()
        if self.play.playing and (self.thread is None or not self.thread.is_alive()):
            self.thread = threading.Thread(target=self._work, name="recorder panel", daemon=True)
            self.thread.start()

    def _work(self):
        """Everything from opening to closing, in the thread; whatever stops it is told beside the button."""
        try:
            with self._open_pictures() as source, self._recorder(source) as recorder:
                if isinstance(source, CameraSource):
                    self.text.value = " ".join(source.lock())
                self._session = Session(source, recorder, self._show)
                self._session.run()
            self.text.value = f"Ended. What was taken is in {self._out}. {PRESS}"
        except StereoLabError as error:
            self.text.value = str(error)
        finally:
            self._session = None

    def _recorder(self, source):
        return Recorder(Folder(self._out, source.size, self._board, self._ball), self._board)

    def _show(self, frame, state):
        session = self._session
        coverage = session.recorder.coverage if session is not None else None
        views = [
            drawn(image, seen, None if coverage is None else coverage.cells(side))
            for side, (image, seen) in enumerate(zip((frame.left, frame.right), state.seen, strict=True))
        ]
        self.picture.value = jpeg(np.hstack(views))
        self.text.value = state.said
        for bar in state.bars:
            self.bars[bar.name].value = bar.part
        if time.monotonic() - self._heard_s > self._silent_s and session is not None:
            session.stop()

    def take_ball(self, set_name: str) -> None:
        """Keep the newest pair with the ball at the place that is typed in."""
        session = self._session
        if session is None or session.frame is None:
            self.text.value = f"No pictures yet. {PRESS}"
            return
        place = tuple(self.place[name].value for name in ("x", "y", "depth"))
        try:
            name = session.recorder.take_sample(session.frame, set_name, place)
            self.text.value = f"Taken: {set_name}/{name} at x {place[0]:g}, y {place[1]:g}, depth {place[2]:g} mm."
        except StereoLabError as error:
            self.text.value = str(error)


def recorder_panel(
    open_pictures: Callable[[], StereoSource], out: str | Path, board: Board, ball: Ball
) -> RecorderPanel:
    """The recorder as a panel; nothing is opened and nothing is written until play is pressed.

    Parameters
    ----------
    open_pictures : function that gives a StereoSource: ``lambda: CameraSource(0, 1)``
    out : folder of the recording, a new one or one that was begun
    board, ball : Board and Ball
    """
    return RecorderPanel(open_pictures, out, board, ball)


def drawn(image: np.ndarray, seen: Glance | None, cells: np.ndarray | None) -> np.ndarray:
    """A camera's picture: darker where no board was yet, and the outline of the one that is seen."""
    view = fit_width(image, SIDE_PX).copy()
    height, width = view.shape[:2]
    if cells is not None:
        empty = cv2.resize((cells == 0).astype(np.uint8), (width, height), interpolation=cv2.INTER_NEAREST) > 0
        view[empty] = (view[empty] * (1 - SHADE)).astype(np.uint8)
    for k in range(1, CELLS[0]):
        cv2.line(view, (k * width // CELLS[0], 0), (k * width // CELLS[0], height), GREY, 1)
    for k in range(1, CELLS[1]):
        cv2.line(view, (0, k * height // CELLS[1]), (width, k * height // CELLS[1]), GREY, 1)
    if seen is None:
        cv2.rectangle(view, (0, 0), (width - 1, height - 1), ORANGE, 4)
    else:
        outline = (seen.outline * width / image.shape[1]).round().astype(np.int32)
        cv2.polylines(view, [outline], True, BLUE, 3, cv2.LINE_AA)
    return view


def _bar(name):
    return ipywidgets.FloatProgress(
        value=0,
        min=0,
        max=1,
        description=name,
        style={"description_width": "90px"},
        layout=ipywidgets.Layout(width="190px"),
    )

"""Panels of lesson 08: a planner for a rig; the recorder, with both cameras live, bars that fill, and what to do next."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from pathlib import Path

import cv2
import ipywidgets
import numpy as np

from stereo_lab.capture import Coverage, Folder, Glance, Recorder, Session, State, told_without
from stereo_lab.capture.coverage import CELLS
from stereo_lab.errors import StereoLabError
from stereo_lab.live import CameraSource, Frame, StereoSource
from stereo_lab.recording import Ball, Board
from stereo_lab.widgets.panel import (
    BLACK,
    BLUE,
    GREY,
    ORANGE,
    PANEL_WIDTH,
    PRESS,
    SILENT_S,
    VERMILION,
    WHITE,
    Panel,
    answer_while_busy,
    fit_width,
    jpeg,
    slider,
    wide,
    write,
)  # fmt: skip
from stereo_lab.widgets.running import Running

BARS = "pairs", "left picture", "right picture", "near and far", "tilted"
SIDE_PX = 480  # width of one camera's picture in the panel
SHADE = 0.55  # how strongly cells are shaded in which no board was yet
SETS = "position", "depth"
GAP_PX = 8  # between the two pictures
WRAPPED = {"flex_flow": "row wrap"}
READ_S = 3.0  # so long what happens once stays in words, before the wishes for the next picture


class RecorderPanel(Running):
    """Play and stop, bars, both pictures, and places to type in. ``repr`` never changes, so that a notebook's output does not.

    What was taken stays; pressing play again goes on.

    Parameters
    ----------
    open_pictures : function that gives a StereoSource
    out : folder of the recording
    board, ball : Board and Ball
    silent_s : float, so long without a tick until it ends
    still : ndarray, BGR, what is shown until it plays

    Attributes
    ----------
    thread : Thread of the session, or None
    """

    def __init__(
        self, open_pictures: Callable[[], StereoSource], out: str | Path, board: Board, ball: Ball, silent_s: float = SILENT_S,
        still: np.ndarray | None = None,
    ) -> None:  # fmt: skip
        if not callable(open_pictures):
            if isinstance(open_pictures, StereoSource):
                open_pictures.close()  # else nobody can open its cameras
            raise StereoLabError(
                "Expected a function that opens the pictures when play is pressed, such as lambda: CameraSource(0, 1); "
                f"got {type(open_pictures).__name__}. Write lambda: before it."
            )
        self._open_pictures, self._out, self._board, self._ball = open_pictures, Path(out), board, ball
        self._stays_s = 0.0
        self._session: Session | None = None
        super().__init__(silent_s)
        self.bars = {name: _bar(name) for name in BARS}
        self.picture = ipywidgets.Image(format="jpeg", layout=ipywidgets.Layout(max_width="100%"))
        self.picture.value = jpeg(
            np.full((SIDE_PX * 3 // 4, 2 * SIDE_PX, 3), 230, np.uint8) if still is None else still
        )
        self.place = {name: ipywidgets.FloatText(0, description=f"{name} (mm)") for name in ("x", "y", "depth")}
        self.take = {name: ipywidgets.Button(description=f"ball: {name}", layout={"width": "auto"}) for name in SETS}
        self._taken: tuple[str, tuple[float, ...]] | None = None
        self.lay_out([
            self.play, self.text, self.picture, ipywidgets.HBox(list(self.bars.values()), layout=WRAPPED),
            ipywidgets.HBox([*self.place.values(), *self.take.values()], layout=WRAPPED),
        ])  # fmt: skip
        for control in (*self.place.values(), *self.take.values()):
            answer_while_busy(control)
        for name, button in self.take.items():
            button.on_click(lambda _, name=name: self.take_ball(name))

    def __repr__(self):
        return "panel: the recorder"

    def end(self) -> None:
        """Ask the session to end."""
        super().end()
        if (session := self._session) is not None:
            session.stop()

    def work(self, end: threading.Event) -> str:
        """The session, from opening to closing."""
        try:
            with self._open_pictures() as source, self._recorder(source) as recorder:
                if isinstance(source, CameraSource) and (loose := source.lock()):
                    self._tell(" ".join(loose))
                self._session = Session(source, recorder, self._show)
                if not self.why_it_ends(end):
                    self._session.run()
            return f"Ended. What was taken is in {self._out}. {PRESS}"
        finally:
            self._session = None

    def _recorder(self, source):
        return Recorder(Folder(self._out, source.size, self._board, self._ball), self._board)

    def _show(self, frame, state):
        session = self._session
        coverage = session.recorder.coverage if session is not None else None
        if frame is not None:
            self.picture.value = jpeg(recorder_view(frame, state, coverage))
        if time.monotonic() > self._stays_s:
            self.text.value = state.said
            if state.taken:
                self._tell(state.said)
        for bar in state.bars:
            self.bars[bar.name].value = bar.part
        if session is not None and self.why_it_ends(self._end):
            session.stop()

    def _tell(self, words):
        """Something that happens once: it stays for a while, though pictures go on coming."""
        self._stays_s, self.text.value = time.monotonic() + READ_S, words

    def take_ball(self, set_name: str) -> None:
        """Keep the newest pair with the ball at the place that is typed in."""
        session = self._session
        frame = None if session is None else session.frame
        if session is None or frame is None:
            self.text.value = (
                f"No pictures yet. {PRESS}" if session is None else "No picture comes just now. Nothing was taken."
            )
            return
        place = tuple(self.place[name].value for name in ("x", "y", "depth"))
        if place[2] <= 0:
            self._tell(
                "Measure first where the ball is, and type in x, y and depth, which is above zero. Nothing was taken."
            )
            return
        if self._taken == (set_name, place):
            self._tell("There the ball was taken just now. Move it, and measure anew. Nothing was taken.")
            return
        try:
            name = session.recorder.take_sample(frame, set_name, place)
            unseen = told_without(session.recorder.folder.ball, frame.left, frame.right)
            self._taken = None if unseen else (set_name, place)  # where none is seen the place may be taken again
            if unseen:
                unseen += f" {name} stays, and is passed over where no ball is found in it."
            said = f"Taken: {set_name}/{name} at x {place[0]:g}, y {place[1]:g}, depth {place[2]:g} mm. {unseen}"
            self._tell(said.rstrip())
        except StereoLabError as error:
            self._tell(f"{error} Nothing was taken.")


def recorder_panel(
    open_pictures: Callable[[], StereoSource],
    out: str | Path,
    board: Board,
    ball: Ball,
    still: np.ndarray | None = None,
) -> RecorderPanel:
    """The recorder as a panel; nothing is opened and nothing is written until play is pressed.

    Parameters
    ----------
    open_pictures : function that gives a StereoSource: ``lambda: CameraSource(0, 1)``
    out : folder of the recording, a new one or one that was begun
    board, ball : Board and Ball
    still : ndarray, BGR, what is shown until play is pressed, and where no kernel runs
    """
    return RecorderPanel(open_pictures, out, board, ball, still=still)


def recorder_view(frame: Frame, state: State, coverage: Coverage | None) -> np.ndarray:
    """Both cameras' pictures as the recorder's panel shows them, BGR.

    Parameters
    ----------
    frame : Frame
    state : State, what the recorder saw in it
    coverage : Coverage or None, of the boards taken so far
    """
    cells = (None, None) if coverage is None else (coverage.cells(0), coverage.cells(1))
    left, right = (drawn(*side) for side in zip((frame.left, frame.right), state.seen, cells, strict=True))
    for view, name in ((left, "left"), (right, "right")):
        cv2.putText(view, name, (10, 24), cv2.FONT_HERSHEY_SIMPLEX, 0.7, BLACK, 4, cv2.LINE_AA)
        cv2.putText(view, name, (10, 24), cv2.FONT_HERSHEY_SIMPLEX, 0.7, WHITE, 2, cv2.LINE_AA)
    return np.hstack([left, np.full((len(left), GAP_PX, 3), 255, np.uint8), right])


def drawn(image: np.ndarray, seen: Glance | None, cells: np.ndarray | None) -> np.ndarray:
    """A camera's picture: darker where no board was yet, and the outline of the one that is seen."""
    view = fit_width(image, SIDE_PX).copy()
    height, width = view.shape[:2]
    if cells is not None:
        empty = cv2.resize((cells == 0).astype(np.uint8), (width, height), interpolation=cv2.INTER_NEAREST)
        cv2.copyTo(cv2.convertScaleAbs(view, alpha=1 - SHADE), empty, view)
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


PLAN_HIGH = 420  # px, of the planner's picture
FAR_MM, MARGIN_PX = 3200.0, 76  # the farthest depth of the planner
APART_PX = 64  # between the numbers of its axis
HUNDREDTHS = 100  # of a pixel
ENLARGED = 100  # times, the error of depth in the planner's picture


def rig_planner(ball_mm: float = 40.0) -> Panel:
    """A rig before it is bought: choose the cameras and how far apart they stand, and see how exact depth will be.

    Parameters
    ----------
    ball_mm : float, diameter of the ball
    """

    def draw(baseline_mm, depth_mm, angle_deg, width_px, noise):
        focal_px = width_px / 2 / np.tan(np.radians(angle_deg) / 2)
        error_mm = depth_mm**2 / (focal_px * baseline_mm) * np.sqrt(2) * noise / HUNDREDTHS
        both_mm = max(0.0, depth_mm * width_px / focal_px - baseline_mm)
        view = _plan_from_above(baseline_mm, depth_mm, angle_deg, both_mm, error_mm)
        nearest = f"a ball in the middle is seen by both from {baseline_mm * focal_px / width_px:.0f} mm on"
        return view, (
            f"At {depth_mm} mm: depth ±{error_mm:.{1 + (error_mm < 0.1)}f} mm (1 sigma), both see {both_mm:.0f} mm, the ball is "
            f"{ball_mm * focal_px / depth_mm:.0f} px wide; {nearest}."
        )

    return Panel(
        "rig planner",
        {
            "baseline_mm": slider("baseline (mm)", 120, 30, 500, 10),
            "depth_mm": slider("depth (mm)", 1000, 300, 3000, 50),
            "angle_deg": slider("angle of view (degrees)", 50, 30, 100, 1),
            "width_px": slider("picture width (px)", 640, 320, 1920, 160),
            "noise": slider("noise of a centre (px/100)", 3, 1, 100, 1),
        },
        draw,
    )


def _plan_from_above(baseline_mm, depth_mm, angle_deg, both_mm, error_mm):
    """Two wedges, cameras at the left, depth to the right; the strip that both see, and the error of depth, enlarged."""
    scale = (PANEL_WIDTH - 2 * MARGIN_PX) / FAR_MM
    scale = min(scale, (PLAN_HIGH / 2 - MARGIN_PX / 2) / max(both_mm / 2, 1.0))  # all of the strip in the picture
    view, half = np.full((PLAN_HIGH, PANEL_WIDTH, 3), 255, np.uint8), np.tan(np.radians(angle_deg) / 2)

    def to_px(depth, x):
        return round(MARGIN_PX + depth * scale), round(PLAN_HIGH / 2 + x * scale)

    along, middle = to_px(depth_mm, 0)
    cameras = (-baseline_mm / 2, BLUE), (baseline_mm / 2, VERMILION)
    for x, color in cameras:
        for way in (-1, 1):
            cv2.line(view, to_px(0, x), to_px(FAR_MM, x + way * half * FAR_MM), color, 1, cv2.LINE_AA)
        cv2.circle(view, to_px(0, x), 6, color, -1, cv2.LINE_AA)
    strip = [to_px(depth_mm, x) for x in (-both_mm / 2, both_mm / 2)]
    for end in strip:
        cv2.circle(view, end, 5, BLACK, -1, cv2.LINE_AA)
    cv2.line(view, *strip, BLACK if both_mm else GREY, 3, cv2.LINE_AA)
    ends = [to_px(depth_mm + side * ENLARGED * error_mm, 0)[0] for side in (-1, 1)]
    shown = np.clip(ends, MARGIN_PX, PANEL_WIDTH - 1).tolist()  # no depth is below zero
    cv2.line(view, (shown[0], middle), (shown[1], middle), ORANGE, 5, cv2.LINE_AA)
    cv2.circle(view, (along, middle), 8, ORANGE, -1, cv2.LINE_AA)

    for (x, color), name, lower in zip(cameras, ("left", "right"), (-12, 26), strict=True):
        _words(view, name, (4, to_px(0, x)[1] + lower), color)
    if both_mm:
        _words_beside(view, "both see", (along, max(min(strip[0][1], middle - 8) - 8, 20)))
    _words_beside(view, f"error of depth (1 sigma), {ENLARGED} times as long", (along, middle + 32))
    step = next(step for step in range(500, int(FAR_MM), 500) if step * scale >= APART_PX)
    for depth in range(step, int(FAR_MM), step):
        _words(view, f"{depth}", (to_px(depth, 0)[0] - 26, PLAN_HIGH - 10))
    _words(view, "depth (mm)", (4, PLAN_HIGH - 36))
    return view


def _words(view, words, place, color=BLACK):
    """Words on a ground of their own: no line runs through them."""
    x, y = place
    cv2.rectangle(view, (x - 2, y - 18), (x + wide(words) + 2, y + 6), WHITE, -1)
    write(view, words, place, color)


def _words_beside(view, words, place):
    """Words to the right of a place, or to the left of it where the picture ends."""
    x, y = place
    right = x + 14 + wide(words) < view.shape[1]
    _words(view, words, (x + 14 if right else x - 14 - wide(words), y))

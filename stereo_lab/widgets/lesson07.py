"""The live view of lesson 07: the whole cell at work in a thread of its own, while the page does something else."""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import cv2
import ipywidgets
import numpy as np

from stereo_lab.arm import Arm, connect
from stereo_lab.live import Follower, Moment, StereoSource, VirtualBench, open_source, run
from stereo_lab.live.follower import switch_on
from stereo_lab.localization import Localizer
from stereo_lab.recording import Recording
from stereo_lab.widgets.panel import (
    BLACK,
    BLUE,
    LETTERS,
    ORANGE,
    PANEL_WIDTH,
    PRESS,
    SILENT_S,
    WHITE,
    answer_while_busy,
    jpeg,
    slider,
)
from stereo_lab.widgets.running import Running

ROW = 42  # px for OpenCV's size of letters: a row of the words under them
SAID_EVERY = 150  # pictures, where nothing new is to be said: a voice reads the line aloud
THE_END = f"The pictures have ended. {PRESS}"
GLIDE_MM_S = 150.0  # the ball goes so fast to where the sliders say: a jump would be taken for another ball


class LiveCell(Running):
    """Play and stop, the ball by sliders, both pictures. ``repr`` never changes, so that a notebook's output does not.

    Parameters
    ----------
    open_arm : function that gives an Arm, or None for no arm
    open_pictures : function (arm or None) that gives a StereoSource
    stage : Recording, which knows cameras, arm and ball
    localizer : Localizer
    silent_s : float, so long without a tick until the run ends

    Attributes
    ----------
    thread : Thread of the run, or None
    """

    def __init__(
        self,
        open_arm: Callable[[], Arm | None],
        open_pictures: Callable[[Arm | None], StereoSource],
        stage: Recording,
        localizer: Localizer,
        silent_s: float = SILENT_S,
    ) -> None:
        self._open_arm, self._open_pictures, self._stage, self._localizer = open_arm, open_pictures, stage, localizer
        self._source: StereoSource | None = None
        self._follower: Follower | None = None
        super().__init__(silent_s)
        reach = round(stage.arm.reach_mm[1])
        self.follow = ipywidgets.ToggleButton(
            value=True, description="follow", tooltip="whether the arm follows the ball"
        )
        self.x = slider("ball: to the right (mm)", 100, -reach, reach)
        self.y = slider("up (mm)", round(0.55 * reach), -reach, reach)
        self.off = slider("before the plane (mm)", 0, -100, 100)
        self.picture = ipywidgets.Image(format="jpeg", layout=ipywidgets.Layout(max_width="100%"))
        self.picture.value = jpeg(_before_it_plays(stage))
        self.lay_out([ipywidgets.HBox([self.play, self.follow]), self.x, self.y, self.off, self.text, self.picture])
        for control in (self.follow, self.x, self.y, self.off):
            answer_while_busy(control)
        self.follow.observe(self._switch, "value")

    def __repr__(self):
        return "panel: the live cell"

    def _switch(self, change):
        if self._follower is not None:
            self._follower.follows = change["new"]

    def _goal_mm(self):
        """Where the sliders say that the ball is, in the bench frame."""
        return np.array((self.x.value, self.y.value, self._stage.arm_depth_mm - self.off.value), float)

    def _glide(self):
        """One picture's way of the drawn ball towards where the sliders say."""
        if isinstance(self._source, VirtualBench):
            left = self._goal_mm() - self._source.ball_mm
            part = GLIDE_MM_S / self._source.rate_hz / max(np.linalg.norm(left), 1e-9)
            self._source.ball_mm = (self._source.ball_mm + min(part, 1.0) * left).tolist()

    def work(self, end: threading.Event) -> str:
        """The cell, from opening to closing."""
        try:
            with contextlib.ExitStack() as stack:
                arm = self._open_arm()
                if arm is not None:
                    stack.callback(arm.close)
                    arm.set_limits(self._stage.arm.limits_deg)
                self._source = stack.enter_context(self._open_pictures(arm))
                if isinstance(self._source, VirtualBench):
                    self._source.ball_mm = self._goal_mm().tolist()
                if arm is not None:
                    if arm.homed:
                        switch_on(arm)
                    elif why := self._home(arm, end):
                        return why
                    self._follower = Follower(arm, self._stage)
                    self._follower.follows = self.follow.value
                moments = stack.enter_context(contextlib.closing(run(self._source, self._localizer, self._follower)))
                return self._show_all(moments, end)
        finally:
            self._source = self._follower = None

    def _home(self, arm, end):
        """Home both joints while the pictures are shown; says why it ended before that, or nothing."""
        self.text.value = "The arm moves: homing both joints, some ten seconds …"
        with ThreadPoolExecutor(1) as waiting:
            homing = waiting.submit(arm.home)
            try:
                while not homing.done():
                    frame = self._source.read()
                    why = self.why_it_ends(end) or ("" if frame else THE_END)
                    if why:
                        return why
                    self.picture.value = jpeg(_with_words(np.hstack([frame.left, frame.right]), ["homing"]))
            finally:
                if not homing.done():
                    arm.stop()
            homing.result()
        return ""

    def _show_all(self, moments, end):
        """Show moment after moment; says why it ended."""
        said = ""
        for moment in moments:
            self.picture.value = jpeg(_drawn(moment))
            if moment.said != said or moment.number % SAID_EVERY == 0:
                said = moment.said
                self.text.value = f"{said}; {moment.latency_ms:.0f} ms from the picture to the order"
            self._glide()
            if why := self.why_it_ends(end):
                return why
        return THE_END


def live_cell(source_name: str, arm_url: str | None, stage: Recording, localizer: Localizer) -> LiveCell:
    """A live view of a source, with an arm that follows the ball; nothing is opened until play is pressed.

    Parameters
    ----------
    source_name : str, as :func:`stereo_lab.live.open_source` takes it
    arm_url : str or None, as :func:`stereo_lab.arm.connect` takes it; a virtual arm keeps the time of the clock
    stage : Recording, which knows cameras, arm and ball
    localizer : Localizer
    """
    if arm_url is not None and arm_url.startswith("virtual://") and "realtime" not in arm_url:
        arm_url += ("&" if "?" in arm_url else "?") + "realtime=1"
    return LiveCell(
        lambda: None if arm_url is None else connect(arm_url),
        lambda arm: open_source(source_name, recording=stage, arm=arm),
        stage,
        localizer,
    )


def _drawn(moment: Moment) -> np.ndarray:
    """Both pictures beside each other, the ball marked, and under them what is known: of the run; of the ball and the arm."""
    frame, track = moment.frame, moment.track
    view = np.hstack([frame.left, frame.right])
    for k, ball in enumerate(() if track is None or track.detections is None else track.detections):
        center = round(ball.u + k * frame.left.shape[1]), round(ball.v)
        cv2.circle(view, center, round(ball.radius_px) + 3, BLUE, 2, cv2.LINE_AA)
        cv2.drawMarker(view, center, BLUE, cv2.MARKER_CROSS, 10, 2)
    if track is not None and not track.seen:
        cv2.rectangle(view, (0, 0), (view.shape[1] - 1, view.shape[0] - 1), ORANGE, 6)
    cpu = f"{moment.cpu_percent:.0f} % CPU, " if moment.cpu_percent else ""  # 0: no second has passed
    words = [f"{moment.rate_hz:.0f} pairs a second, {cpu}{moment.rss_mb:.0f} MB", "no ball", ""]
    if track is not None:
        p = track.position
        words[1] = f"ball x {p.x_mm:.0f}  y {p.y_mm:.0f}  depth {p.depth_mm:.0f} mm"
    if moment.step is not None:
        words[2] = f"arm {moment.step.reached.theta1_deg:.0f}, {moment.step.reached.theta2_deg:.0f} degrees"
    return _with_words(view, words)


def _before_it_plays(stage):
    """A pair of the recording, smaller."""
    pair = stage.samples("position")[0].pair
    view = cv2.resize(np.hstack([pair.left, pair.right]), None, fx=0.6, fy=0.6, interpolation=cv2.INTER_AREA)
    return _with_words(view, ["A recorded pair.", PRESS])


def _with_words(view, words):
    """The picture with two rows of words under it, as large as a page that shows it smaller needs: they cover nothing."""
    width = view.shape[1]
    size = max(LETTERS, LETTERS * width / PANEL_WIDTH)
    high = round(ROW * size)
    rows = np.full((2 * high, width, 3), WHITE, np.uint8)
    for k, part in enumerate(words):
        at = (10 + width // 2 * (k == 2), high * (1 + (k > 0)) - high // 3)
        cv2.putText(rows, part, at, cv2.FONT_HERSHEY_SIMPLEX, size, BLACK, max(1, round(size)), cv2.LINE_AA)
    return np.vstack([view, rows])

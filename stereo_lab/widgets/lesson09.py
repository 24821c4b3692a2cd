"""The panel of lesson 09: mark the ball in pictures."""

from __future__ import annotations

import base64
import html
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import cv2
import ipywidgets
import numpy as np

from stereo_lab.detection import BallColor
from stereo_lab.detection.marked import propose
from stereo_lab.errors import StereoLabError
from stereo_lab.recording.marks import Mark, read_marks, write_marks
from stereo_lab.widgets.panel import BLACK, BLUE, GREY, LONG, ORANGE, WHITE, WIDE, jpeg

LARGE, ZOOM_PX = 4, 240  # times, the enlarged cut-out and its side
USUAL_RADIUS = 12  # px, of a mark that the keyboard begins
NEAR_PX = 2.0  # a second click so near to the centre is that of a double click
# A picture of ipywidgets tells no clicks. This one writes the place of a click, in parts of its width and height, into a hidden
# field of the same panel, from where the kernel hears of it.
CLICK = (
    "const r = this.getBoundingClientRect(), field = this.closest('.mark-panel').querySelector('.mark-click input');"
    "field.value = (event.clientX - r.left) / r.width + ' ' + (event.clientY - r.top) / r.height + ' ' + Date.now();"
    "field.dispatchEvent(new Event('input', {bubbles: true}));"
)
HOW = "Click the ball's centre, then its rim. By keyboard: Tab to a slider, arrow keys."


class MarkPanel(ipywidgets.VBox):
    """Pictures one by one; two clicks mark the ball, a button says that there is none. ``marks`` holds what was marked.

    Where the table is there already, its marks are those that it begins with; *save* changes in it what was changed here.
    """

    def __init__(self, shots: Mapping[str, np.ndarray], out: str | Path, color: BallColor | str) -> None:
        if not shots:
            raise StereoLabError("There are no pictures to mark. Name a recording with a ball, or a film: shots_of(…).")
        self._shots, self._names, self._out, self._color = dict(shots), list(shots), Path(out), color
        if isinstance(color, str):
            self._color = BallColor.named(color)  # a name that is none is told before all marking
        self.marks: dict[str, Mark] = read_marks(out) if Path(out).is_file() else {}
        self._in_table = dict(self.marks)  # as this panel knows it
        self._at, self._center, self._moving = 0, None, False
        self.picture = ipywidgets.HTML()
        self.clicked = ipywidgets.Text(layout=ipywidgets.Layout(display="none"))
        self.clicked.add_class("mark-click")
        self.sliders = {name: _slider(name) for name in ("u", "v", "radius")}
        self.buttons = {
            name: ipywidgets.Button(description=name)
            for name in ("back", "next", "no ball", "clear", "propose", "save")
        }
        self.text = ipywidgets.Label(HOW)
        super().__init__([
            ipywidgets.HBox(list(self.buttons.values())), self.text, self.picture, *self.sliders.values(), self.clicked,
        ])  # fmt: skip
        self.add_class("mark-panel")
        self.clicked.observe(self._click, "value")
        for slider in self.sliders.values():
            slider.observe(self._slid, "value")
        acts = (lambda: self.go(-1), lambda: self.go(1), lambda: self.mark(None), self.clear, self.propose, self.save)
        for button, act in zip(self.buttons.values(), acts, strict=True):
            button.on_click(lambda _, act=act: act())
        self._show(HOW)

    def __repr__(self):
        return "panel: mark the ball"

    def _repr_mimebundle_(self, **asked: Any) -> dict[str, Any]:
        """As any widget's, and the picture of the moment for a page on which no kernel runs."""
        return {**super()._repr_mimebundle_(**asked), "image/jpeg": base64.b64encode(jpeg(self.view())).decode()}

    @property
    def name(self) -> str:
        """Of the picture that is shown."""
        return self._names[self._at]

    def go(self, steps: int) -> None:
        """Show another picture."""
        self._at, self._center = (self._at + steps) % len(self._names), None
        self._show(HOW)

    def mark(self, mark: Mark) -> None:
        """Mark the picture that is shown: (u, v, radius) in px, or None for no ball."""
        self.marks[self.name], self._center = mark, None
        self._show(
            "Marked: no ball."
            if mark is None
            else "Marked. Does the circle follow the rim? If not, click again, or use the sliders."
        )

    def clear(self) -> None:
        """Take the mark of this picture away."""
        self.marks.pop(self.name, None)
        self._center = None
        self._show(HOW)

    def propose(self) -> None:
        """Let the surest balls of the named colour mark themselves, where nothing is marked yet."""
        found = propose(list(self._shots.values()), self._color)
        new = {self._names[k]: mark for k, mark in found.items() if self._names[k] not in self.marks}
        self.marks |= new
        balls = sum(mark is not None for mark in new.values())
        self._show(
            f"Proposed: {balls} with a ball (an orange circle), {len(new) - balls} without. Go through them, and put right what "
            "is wrong."
            if new
            else "Nothing is proposed: what is sure enough is marked already."
        )

    def save(self) -> None:
        """Write the marks as a table. What another panel, or a hand, wrote into it meanwhile stays."""
        try:
            marks = self._with_those_of_others()
            in_order = sorted(marks, key=lambda name: (name not in self._shots, name))
            write_marks(self._out, {name: marks[name] for name in in_order})
        except StereoLabError as error:
            self.text.value = str(error)
            return
        self.marks, self._in_table = marks, dict(marks)
        self._show("")
        balls = sum(mark is not None for mark in self.marks.values())
        self.text.value = f"{self._out} is written: {balls} with the ball, {len(self.marks) - balls} without."

    def _with_those_of_others(self):
        """The table as it is now, and in it what was marked or cleared here."""
        there = read_marks(self._out) if self._out.is_file() else dict(self.marks)
        for name in {*self.marks, *self._in_table}:
            if name not in self.marks:
                there.pop(name, None)
            elif name not in self._in_table or self.marks[name] != self._in_table[name]:
                there[name] = self.marks[name]
        return there

    def view(self) -> np.ndarray:
        """The picture with its mark, and the mark enlarged beside it."""
        image, mark = self._shots[self.name], self.marks.get(self.name)
        marked = image.copy()
        u, v, radius = mark or (*(self._center or (image.shape[1] / 2, image.shape[0] / 2)), 0.0)
        if self._center is not None:
            cv2.drawMarker(marked, (round(u), round(v)), BLUE, cv2.MARKER_CROSS, 14, 2)
        side = max(ZOOM_PX / LARGE, 3.2 * radius)
        scale = ZOOM_PX / side
        close = cv2.warpAffine(image, np.array([[scale, 0, ZOOM_PX / 2 - scale * u], [0, scale, ZOOM_PX / 2 - scale * v]]),
                               (ZOOM_PX, ZOOM_PX), flags=cv2.INTER_NEAREST, borderValue=GREY)  # fmt: skip
        if mark is not None:
            cv2.circle(marked, (round(u), round(v)), round(radius), ORANGE, 2, cv2.LINE_AA)
            cv2.circle(close, (ZOOM_PX // 2, ZOOM_PX // 2), round(radius * scale), ORANGE, 1, cv2.LINE_AA)
        if self.name in self.marks and mark is None:
            cv2.putText(marked, "no ball", (12, 34), cv2.FONT_HERSHEY_SIMPLEX, 1, WHITE, 5, cv2.LINE_AA)
            cv2.putText(marked, "no ball", (12, 34), cv2.FONT_HERSHEY_SIMPLEX, 1, BLACK, 2, cv2.LINE_AA)
        beside = np.full((image.shape[0], ZOOM_PX, 3), 255, np.uint8)
        beside[: min(ZOOM_PX, len(beside))] = close[: len(beside)]
        return np.hstack([marked, beside])

    def _click(self, change):
        """The place of a click: the centre, and then the rim."""
        try:
            x, y = (float(part) for part in change["new"].split()[:2])
        except ValueError:
            return
        height, width = self._shots[self.name].shape[:2]
        u, v = x * (width + ZOOM_PX) - 0.5, y * height - 0.5
        if not (0 <= u < width and 0 <= v < height):
            self._show("That is outside the picture: click into its large part.")
        elif self._center is None:
            self._center = (u, v)
            self._show("Now click the rim.")
        else:
            self._click_rim(float(np.hypot(u - self._center[0], v - self._center[1])))

    def _click_rim(self, radius):
        """The second click: it must be as far from the first as a rim can be."""
        if radius < NEAR_PX:
            self._show("That is the centre again. Now click the rim.")
        elif radius > (most := self.sliders["radius"].max):
            self._center = None
            self._show(
                f"No rim is {radius:.0f} px from its centre in this picture, {most} px at most: begin anew, at the centre."
            )
        else:
            self.mark((*self._center, radius))

    def _slid(self, change):
        """One slider moves one number; the others keep their fractions of a pixel."""
        if not self._moving:
            mark = list(self.marks.get(self.name) or (slider.value for slider in self.sliders.values()))
            mark[list(self.sliders.values()).index(change["owner"])] = change["new"]
            u, v, radius = (float(part) for part in mark)
            self.mark((u, v, radius))

    def _set_sliders(self):
        """To the mark of this picture, in its bounds; where there is none, to where one begins."""
        height, width = self._shots[self.name].shape[:2]
        center = self._center or (width // 2, height // 2)
        begins = self.marks.get(self.name) or (*center, USUAL_RADIUS)
        most = width - 1, height - 1, max(1, min(width, height) // 2)
        self._moving = True
        for slider, value, high in zip(self.sliders.values(), begins, most, strict=True):
            slider.max = high
            slider.value = round(value)
        self._moving = False

    def _show(self, said):
        self._set_sliders()
        source = base64.b64encode(jpeg(self.view())).decode()
        self.picture.value = (
            f'<img src="data:image/jpeg;base64,{source}" style="max-width: 100%; cursor: crosshair" onclick="{CLICK}" '
            f'alt="picture {html.escape(self.name)} with its mark">'
        )
        balls = sum(m is not None for m in self.marks.values())
        done = f"{balls} with the ball, {len(self.marks) - balls} without"
        self.text.value = f"Picture {self.name}, {self._at + 1} of {len(self._names)} ({done}). {said}"


def _slider(name):
    return ipywidgets.IntSlider(
        1, 1 if name == "radius" else 0, description=f"{name} (px)", style=LONG, layout=ipywidgets.Layout(**WIDE)
    )


def mark_balls(
    shots: Mapping[str, np.ndarray], out: str | Path = "marks.csv", color: BallColor | str = "red"
) -> MarkPanel:
    """Mark the ball in some pictures; *save* writes a table that ``stereo-lab train --marks`` and ``read_marks`` read.

    Parameters
    ----------
    shots : pictures by name, from ``stereo_lab.recording.marks.shots_of``
    out : the table to write
    color : whose surest balls the button *propose* takes
    """
    return MarkPanel(shots, out, color)

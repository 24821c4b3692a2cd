"""A picture with sliders beside it."""

from __future__ import annotations

import base64
import contextlib
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import cv2
import ipywidgets
import numpy as np

from stereo_lab.errors import StereoLabError

# Okabe and Ito, as OpenCV counts: blue, green, red
BLUE, ORANGE, VERMILION, BLACK, WHITE, GREY = (
    (178, 114, 0), (0, 159, 230), (0, 94, 213), (0, 0, 0), (255, 255, 255), (200, 200, 200),
)  # fmt: skip
PANEL_WIDTH = 960  # px, of the picture in a panel
LETTERS = 0.7  # OpenCV's size of the words in it: ten points where the page is 1024 px wide
LONG = {"description_width": "170px"}
WIDE = {"width": "560px", "max_width": "98%"}  # less where the page is narrow
TICK_MS = 1000  # the page ticks so often while it is there
SILENT_S = 5.0  # so long without a tick, and the run ends: a closed page must not drive an arm
QUALITY = 80  # of the pictures on their way to the page
PRESS = "Press play: the triangle on the left."


class Pictured(ipywidgets.VBox):
    """Widgets round a ``picture``, which a page shows on which no kernel runs, as on the web or in print."""

    picture: ipywidgets.Image

    def _repr_mimebundle_(self, **asked: Any) -> dict[str, Any]:
        """As any widget's, and the picture of the moment."""
        return {**super()._repr_mimebundle_(**asked), "image/jpeg": base64.b64encode(self.picture.value).decode()}


class Panel(Pictured):
    """A picture, a line of text and controls. ``repr`` never changes, so that a notebook's output does not."""

    def __init__(
        self, name: str, controls: dict[str, ipywidgets.Widget], draw: Callable[..., tuple[np.ndarray, str]]
    ) -> None:
        """``draw(**values)`` gives the picture (BGR) and the text; ``controls`` is a dictionary of widgets."""
        self._name, self._controls, self._draw = name, controls, draw
        self.picture = ipywidgets.Image(format="jpeg", layout=ipywidgets.Layout(max_width="100%"))
        self.text = ipywidgets.Label()
        super().__init__([*controls.values(), self.text, self.picture])
        for control in controls.values():
            control.observe(self._change, "value")
        self._change()

    def __repr__(self):
        return f"panel: {self._name}"

    def control(self, name: str) -> ipywidgets.Widget:
        """One of the panel's controls, by name."""
        return self._controls[name]

    def _change(self, _=None):
        try:
            image, text = self._draw(**{name: control.value for name, control in self._controls.items()})
        except StereoLabError as error:  # the picture stays that of the last choice that could be drawn
            self.text.value = str(error)
            return
        self.picture.value = cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, 88])[1].tobytes()
        self.text.value = text


def slider(description: str, value: float, low: int, high: int, step: int = 1) -> ipywidgets.IntSlider:
    """A slider of whole numbers, as wide as all the others."""
    return ipywidgets.IntSlider(
        int(value), low, high, step, description=description, style=LONG, layout=ipywidgets.Layout(**WIDE)
    )


def range_slider(description: str, value: Sequence[float], low: int, high: int) -> ipywidgets.IntRangeSlider:
    """A slider with two ends."""
    return ipywidgets.IntRangeSlider(
        value=[int(v) for v in value], min=low, max=high, description=description, style=LONG,
        layout=ipywidgets.Layout(**WIDE),
    )  # fmt: skip


def fit_width(image: np.ndarray, width: int) -> np.ndarray:
    """The picture made at most ``width`` wide."""
    scale = min(1.0, width / image.shape[1])
    return image if scale == 1 else cv2.resize(image, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)


def wide(words: str) -> int:
    """How many px words take in a panel's picture."""
    return cv2.getTextSize(words, cv2.FONT_HERSHEY_SIMPLEX, LETTERS, 1)[0][0]


def write(view: np.ndarray, words: str, place: tuple[int, int], color: Sequence[int] = BLACK) -> None:
    """Write words into a panel's picture, from their lower left corner on."""
    cv2.putText(view, words, place, cv2.FONT_HERSHEY_SIMPLEX, LETTERS, color, 1, cv2.LINE_AA)


def answer_while_busy(control: ipywidgets.Widget) -> None:
    """Let a control be heard while another cell runs.

    ipykernel 7 hands a control's messages back to the shell that made it; without this note they stay in the thread that the
    page asked for. Where a kernel has no such note, they wait for the cell.
    """
    with contextlib.suppress(AttributeError):
        del control.comm._reply_subshell_id


@contextlib.contextmanager
def telling(text: ipywidgets.Label) -> Iterator[None]:
    """What ends a thread is told in the label, for no page shows what a thread raises. What nobody foresaw goes on, to the log."""
    try:
        yield
    except StereoLabError as error:
        text.value = str(error)
    except Exception as error:
        text.value = f"Ended by what nobody foresaw, {type(error).__name__}: {error}. {PRESS}"
        raise


def jpeg(picture: np.ndarray) -> bytes:
    """A BGR picture on its way to a page."""
    return cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, QUALITY])[1].tobytes()

"""A short film in a notebook: WebM with VP8, which every browser plays, with play and pause and a still for print."""

from __future__ import annotations

import base64
import contextlib
import os
import tempfile
from collections.abc import Iterator, Sequence
from html import escape
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from stereo_lab.errors import StereoLabError

CLIP_WIDTH = 480  # px


class Clip:
    """A film made of pictures, played in the page. Its bytes differ between computers; what it shows does not.

    Parameters
    ----------
    pictures : sequence of ndarray, BGR, all of one size
    rate_hz : float, pictures a second
    says : str, what is to be seen, for whoever cannot see it
    width_px : int, of the clip where the pictures are wider

    Raises
    ------
    StereoLabError
        If there is no picture.
    """

    def __init__(self, pictures: Sequence[np.ndarray], rate_hz: float, says: str, width_px: int = CLIP_WIDTH) -> None:
        if not len(pictures):
            raise StereoLabError("Expected the pictures of a clip, got none. Run the cell that makes them first.")
        high, wide = pictures[0].shape[:2]
        scale = min(1.0, width_px / wide)
        self.size = 2 * round(wide * scale / 2), 2 * round(high * scale / 2)  # VP8 wants whole pairs of pixels
        small = [cv2.resize(picture, self.size, interpolation=cv2.INTER_AREA) for picture in pictures]
        self.says, self.webm = says, _webm(small, rate_hz, self.size)
        self.still = cv2.imencode(".jpg", small[len(small) // 2], [cv2.IMWRITE_JPEG_QUALITY, 85])[1].tobytes()

    def __repr__(self):
        return f"clip: {self.says}"

    def _repr_mimebundle_(self, **_: Any) -> dict[str, str]:
        """The film as HTML; its still for a page that plays none; its words."""
        still = base64.b64encode(self.still).decode()
        shown = {"text/plain": repr(self), "image/jpeg": still}
        if self.webm:
            film = base64.b64encode(self.webm).decode()
            says, (wide, high) = escape(self.says, quote=True), self.size
            shown["text/html"] = (
                f'<video controls loop muted playsinline width="{wide}" height="{high}" aria-label="{says}" '
                f'poster="data:image/jpeg;base64,{still}" src="data:video/webm;base64,{film}">{says}</video>'
            )
        return shown


def _webm(pictures, rate_hz, size):
    """The bytes of the film; none where this OpenCV cannot write one."""
    with tempfile.TemporaryDirectory() as folder, _no_words_of_the_encoder():
        path = Path(folder) / "clip.webm"
        writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"VP80"), rate_hz, size)
        for picture in pictures if writer.isOpened() else ():
            writer.write(picture)
        writer.release()
        return path.read_bytes() if path.exists() else b""


@contextlib.contextmanager
def _no_words_of_the_encoder() -> Iterator[None]:
    """OpenCV's FFmpeg writes past Python that it knows VP8 by another tag, and writes it all the same."""
    kept, nowhere = os.dup(2), os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 2)
    try:
        yield
    finally:
        os.dup2(kept, 2)
        os.close(kept)
        os.close(nowhere)

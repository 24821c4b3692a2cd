"""What both ways ask of the samples they are fitted on."""

from __future__ import annotations

from collections.abc import Sequence, Sized

from stereo_lab.common.files import typed
from stereo_lab.detection import BallColor
from stereo_lab.errors import StereoLabError
from stereo_lab.recording import Recording


def check_enough(found: Sized, missed: Sequence[str], least: int, recording: Recording, color: BallColor) -> None:
    """Raise a StereoLabError that names the missed samples where fewer than ``least`` are left."""
    count = len(found) + len(missed)
    if count == 0:
        raise StereoLabError(
            f"No measured pairs are left to fit on; {least} are needed. In measured.csv the column use says fit for these: "
            "are there such lines? Were too many left out?"
        )
    if count < least:
        raise StereoLabError(
            f"There are {count} measured pairs to fit on; {least} are needed. "
            "Has each pair a line in measured.csv? Were too many left out?"
        )
    if len(found) < least:
        raise StereoLabError(
            f"The {color.name} ball was found in {len(found)} of {count} measured pairs; "
            f"{least} are needed (missed: {', '.join(missed)}). "
            + (
                f"Check the ball's color and diameter_mm, and square_mm of the board, in {recording.path / 'recording.json'}; "
                f"stereo-lab check {typed(recording.path)} says more."
                if color.name == recording.ball.color
                else f"By its recording.json the ball is {recording.ball.color}: is it the one that was asked for?"
            )
        )

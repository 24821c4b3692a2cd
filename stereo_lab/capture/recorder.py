"""Takes pairs of a board by itself: where the board is new, still and sharp."""

from __future__ import annotations

from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, field

import numpy as np

from stereo_lab.calibration import StereoCalibration, calibrate_stereo, counts_squares, where_to_hold
from stereo_lab.calibration.corners import other_board
from stereo_lab.capture.coverage import Bar, Coverage
from stereo_lab.capture.folder import BOARDS, Folder
from stereo_lab.capture.glance import Glance, glance
from stereo_lab.errors import StereoLabError
from stereo_lab.live.sources import Frame
from stereo_lab.recording import Board
from stereo_lab.recording.bounds import place_mm

HOLD_S = 0.4  # so long a board must be still
STILL = 0.012  # of the picture's width a second: a pixel in 0.13 s, at 640
EDGE_PX, SHARPER = 2.0, 1.3  # edges wider than this, or than so many times the sharpest ones, are blurred
GLARE = 0.3  # part of the white squares that may be burnt out
FIRST, AGAIN = 10, 4  # pairs after which it calibrates, and pairs more until it does so again
NONE_S, FEW = 5.0, 3  # so long without a board, while so few pairs are taken, and another one is looked for
NEAREST = 2  # diameters before the cameras a ball would fill half of a usual webcam's picture: no depth in mm is less
SIDES = "left", "right"


@dataclass(frozen=True, eq=False)
class State:
    """What a recorder knows, and wants.

    Attributes
    ----------
    time_s : float, when the pictures were taken that it looked at, by their source's clock
    seen : (Glance or None, Glance or None), the board in the left and in the right picture
    said : str, what to do now
    taken : str, the pair that was just taken; empty where none was
    pairs : int, taken so far
    bars : list of Bar
    calibration : StereoCalibration or None, of the pairs taken some time ago
    """

    time_s: float
    seen: tuple[Glance | None, Glance | None] = (None, None)
    said: str = "Hold the board before both cameras."
    taken: str = ""
    pairs: int = 0
    bars: list[Bar] = field(default_factory=list)
    calibration: StereoCalibration | None = None


class Recorder:
    """Looks at pairs of pictures, and takes those that are worth it.

    Parameters
    ----------
    folder : Folder, which it fills; what is in it already counts
    board : Board
    """

    def __init__(self, folder: Folder, board: Board) -> None:
        self.folder, self.board, self.coverage = folder, board, Coverage()
        self._before: tuple[float, tuple[Glance | None, Glance | None]] | None = None
        self._still_since, self._sharpest = float("inf"), [EDGE_PX, EDGE_PX]
        self._working = ThreadPoolExecutor(1, thread_name_prefix="calibrate")
        self._asked: Future | None = None
        self._asked_at, self._calibration, self._trouble = 0, None, ""
        self._other: Future | None = None
        self._none_since, self._others = float("inf"), (None, None)
        try:
            for pair in self._pairs():
                self._know(glance(pair.left, board), glance(pair.right, board))
        except BaseException:
            self.close()
            raise

    def _pairs(self):
        return self.folder.recording().pairs(BOARDS) if self.folder.names(BOARDS) else ()

    def _know(self, left, right):
        self.coverage.add(left, right)
        for side, seen in enumerate((left, right)):
            if seen is not None:
                self._sharpest[side] = min(self._sharpest[side], seen.edge_px)

    def look(self, frame: Frame) -> State:
        """Look at one pair, and take it where it is worth it. A disk that is full, for example, is said and not raised."""
        seen = glance(frame.left, self.board), glance(frame.right, self.board)
        self._watch(frame.time_s, seen)
        self._look_for_another(frame, seen)
        said, taken = self._wish(frame.time_s, seen), ""
        if not said:
            said, taken = self._take(frame, seen)
        if self._trouble:
            said = f"{said} The pairs taken so far do not fit: {self._trouble}"
        self._calibrate()
        bars = self.coverage.bars()
        return State(frame.time_s, seen, said, taken, len(self.coverage.taken), bars, self._calibration)

    def _watch(self, time_s, seen):
        """Since when the board is still."""
        before, self._before = self._before, (time_s, seen)
        if before is None or not _is_still(before[1], seen, time_s - before[0]):
            self._still_since = time_s

    def _look_for_another(self, frame, seen):
        """While hardly a pair is taken and no board is seen, which other one the left picture shows: the last two answers."""
        if self._other is not None and self._other.done():
            self._others, self._other = (self._others[1], self._other.result()), None
        if seen != (None, None) or len(self.coverage.taken) >= FEW:
            self._none_since = float("inf")
            return
        self._none_since = min(self._none_since, frame.time_s)
        if self._other is None and frame.time_s - self._none_since > NONE_S:
            self._none_since = frame.time_s
            self._other = self._working.submit(_whole_other, frame.left, self.board)

    def _wish(self, time_s, seen):
        """What to do before this pair can be taken; empty where it can."""
        there = [side for side, one in enumerate(seen) if one is not None]
        if not there:
            return self._no_board()
        if len(there) == 1 and not self.coverage.reaches_rim(seen[there[0]], there[0]):
            return f"Only the {SIDES[there[0]]} camera sees the board: move it to where both do."
        if self.coverage.complete and len(there) == 2:
            return "All is done: end the recording."
        if not self.coverage.is_new(*seen):
            return f"This place is taken. {self._next()}"
        if any(one.burnt > GLARE for one in seen if one is not None):
            return "The light is reflected in the board: tilt it a little, or move the lamp."
        if time_s - self._still_since < HOLD_S:
            return "Hold still."
        blurred = [
            side for side in there if seen[side].edge_px > max(SHARPER * self._sharpest[side], EDGE_PX / SHARPER)
        ]
        if blurred:
            return f"The {SIDES[blurred[0]]} picture is blurred: hold still, give it more light, or focus."
        return ""

    def _no_board(self):
        """What to do where no board is seen: one of another size was, or the next place is empty."""
        before, other = self._others
        if other is None or other != before:
            return "No board is seen. " + (self._next() or "All is done: end the recording.")
        counted = (
            " Count the corners where four squares meet, not squares." if counts_squares(self.board, other) else ""
        )
        return f"No {self.board} is seen, but a {other}.{counted} Begin again with that board, in another folder."

    def _next(self):
        if self._calibration is not None:
            worst = where_to_hold(self._calibration, 1)
            if worst and self.coverage.complete:
                return f"Known least at the {worst[0]} of the left picture."
        return self.coverage.next_place()

    def _take(self, frame, seen):
        try:
            name = self.folder.add_pair(BOARDS, frame.left, frame.right)
        except StereoLabError as error:
            return str(error), ""
        self._know(*seen)
        return f"Taken: pair {name}. {self._next()}", name

    def _calibrate(self):
        """Every few pairs, in a thread of its own; the newest one that is finished is kept."""
        if self._asked is not None and self._asked.done():
            try:
                self._calibration, self._trouble = self._asked.result(), ""
            except StereoLabError as error:
                self._trouble = str(error)
            self._asked = None
        both = sum(None not in pair for pair in self.coverage.taken)
        if self._asked is None and both >= max(FIRST, self._asked_at + AGAIN):
            self._asked_at = both
            self._asked = self._working.submit(calibrate_stereo, self._pairs(), self.board)

    def take_sample(self, frame: Frame, set_name: str, place: tuple[float, float, float], use: str = "") -> str:
        """Keep a pair with the ball at a measured place, (x, y, depth) in mm; returns its name.

        Raises
        ------
        StereoLabError
            As :meth:`Folder.add_sample`, and if no ball can be so near.
        """
        depth_mm, least_mm = place_mm(place[2], f"{set_name}, depth_mm"), NEAREST * self.folder.ball.diameter_mm
        if 0 < depth_mm < least_mm:
            raise StereoLabError(
                f"A depth of {depth_mm:g} mm is nearer than two diameters of the ball ({least_mm:g} mm): are these millimetres?"
            )
        return self.folder.add_sample(set_name, frame.left, frame.right, place, use)

    def close(self) -> None:
        """End what still calculates, and let the folder go."""
        self._working.shutdown(wait=True, cancel_futures=True)
        self.folder.close()

    def __enter__(self) -> Recorder:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def _whole_other(image, board):
    """Another board that a picture shows, or None: one that the picture cuts off looks like a smaller one, and touches its rim."""
    shown = other_board(image, board)
    seen = None if shown is None else glance(image, shown)
    if seen is None:
        return None
    square = np.linalg.norm(seen.outline[1] - seen.outline[0]) / (shown.grid[0] - 1)
    room = 1.6 * square  # its own squares, and some of the board's rim
    return shown if (seen.outline > room).all() and (seen.outline < np.array(seen.size) - room).all() else None


def _is_still(before, now, seconds):
    """Whether the board hardly moved in whatever camera sees it; another camera that loses or finds it is a movement."""
    if [one is None for one in before] != [one is None for one in now] or seconds <= 0:
        return False
    moves = [
        np.linalg.norm(a.outline - b.outline, axis=1).mean() / a.size[0]
        for a, b in zip(before, now, strict=True)
        if a is not None
    ]
    return max(moves, default=np.inf) < STILL * max(seconds, 0.1)

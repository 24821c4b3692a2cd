"""Two films of a board, by two cameras or two phones that nobody started at the same moment, and which frames belong together.

A board that is moved about moves before both cameras, so its speed over time looks alike in both films, only shifted. The
shift that makes them most alike is how much later one film began. Then frames are taken in which the board is still, for
two films have no common clock, and a board that rests is at one place for both.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from stereo_lab.capture.coverage import Coverage
from stereo_lab.capture.folder import BOARDS, Folder
from stereo_lab.capture.glance import Glance, glance
from stereo_lab.common.files import whole_folder
from stereo_lab.errors import RecordingError
from stereo_lab.recording import USUAL_BALL, Ball, Board, Recording, open_recording
from stereo_lab.recording.importing import check_new
from stereo_lab.recording.video import count_frames, read_timed

STEP_S = 0.02  # films are compared at so many moments a second
MOST_APART_S = 60.0  # films that were started farther apart
LEAST_SHARED_S = 5.0  # so long both must show the board for their speeds to be compared
ALIKE = 0.5  # correlation of the speeds from which an offset is believed
STILL = 0.03  # of the picture's width a second
OF_FRAMES = 10  # of so many one is taken, that in which the board is stillest
PAIRED_S = 0.1  # a resting board may be seen so much earlier by one camera

Progress = Callable[[str, int, int], object]


@dataclass(frozen=True, eq=False)
class Seen:
    """A film, as far as the board goes.

    Attributes
    ----------
    times_s : ndarray, shape (frames,), when each frame was taken, from the film's beginning
    glances : list of Glance or None, one for each frame
    size : (width, height), px
    """

    times_s: np.ndarray
    glances: list[Glance | None]
    size: tuple[int, int]

    def speed(self) -> np.ndarray:
        """How fast the board moves at each frame, picture widths a second; NaN where it is not seen."""
        centers = np.array([[np.nan] * 2 if g is None else g.outline.mean(0) / self.size[0] for g in self.glances])
        return np.linalg.norm(np.gradient(centers, self.times_s, axis=0), axis=1)


def watch(path: str | Path, board: Board, progress: Callable[[int, int], object] | None = None) -> Seen:
    """Look for the board in every frame of a film; one frame at a time is in memory.

    Raises
    ------
    RecordingError
        If it cannot be read, or is a single picture.
    """
    total, times, glances, size = count_frames(path), [], [], (0, 0)
    for time_s, frame in read_timed(path):
        times.append(time_s)
        glances.append(glance(frame, board))
        size = frame.shape[1::-1]
        if progress:
            progress(len(times), max(total, len(times)))
    if len(times) < 2:
        raise RecordingError(
            f"{path} has {'one picture' if times else 'no pictures'}: a film of a moving board was expected."
        )
    return Seen(np.array(times), glances, size)


def offset_s(left: Seen, right: Seen) -> tuple[float, float]:
    """By how much later the right film began, and how alike the speeds are then: their correlation.

    Raises
    ------
    RecordingError
        If the films do not show a moving board for long enough, or their speeds are not alike at any offset.
    """
    one, other = (_evenly(film) for film in (left, right))
    most = round(MOST_APART_S / STEP_S)
    shifts = [shift for shift in range(-most, most + 1) if _shared(one, other, shift) >= LEAST_SHARED_S]
    best = max(shifts, key=lambda shift: _sure(one, other, shift), default=0)
    alike = _alike(one, other, best) if shifts else 0.0
    if alike < ALIKE:
        raise RecordingError(
            "The two films do not show one moving board: how fast it moves never looks alike. Film both at once, and move the "
            "board about between the places at which you hold it still."
        )
    return _between(one, other, best) * STEP_S, alike


def _evenly(film):
    """The logarithm of the speed, at even steps of time; NaN where the board is not seen."""
    moments = np.arange(film.times_s[0], film.times_s[-1], STEP_S)
    speed = np.interp(moments, film.times_s, film.speed(), left=np.nan, right=np.nan)
    return np.log(speed + STILL)


def _parts(one, other, shift):
    """Both speeds where they are known at the same time, the other one taken ``shift`` steps earlier."""
    first, last = max(0, shift), min(len(one), len(other) + shift)
    if last <= first:
        return np.zeros(0), np.zeros(0)
    a, b = one[first:last], other[first - shift : last - shift]
    there = ~(np.isnan(a) | np.isnan(b))
    return a[there], b[there]


def _shared(one, other, shift):
    """For how long both films show the board, s."""
    return len(_parts(one, other, shift)[0]) * STEP_S


def _sure(one, other, shift):
    """How sure it is that the speeds are alike (Fisher's z): a short time is easily alike by chance."""
    return np.arctanh(np.clip(_alike(one, other, shift), -0.999, 0.999)) * np.sqrt(_shared(one, other, shift))


def _alike(one, other, shift):
    """Correlation of the speeds."""
    a, b = _parts(one, other, shift)
    return float(np.corrcoef(a, b)[0, 1]) if a.std() > 0 and b.std() > 0 else -1.0


def _between(one, other, shift):
    """The best shift to a part of a step: the top of a parabola through three correlations."""
    low, top, high = (_alike(one, other, shift + k) for k in (-1, 0, 1))
    bend = low - 2 * top + high
    return shift if bend >= 0 else shift + float(np.clip(0.5 * (low - high) / bend, -0.5, 0.5))


def resting_pairs(left: Seen, right: Seen, later_s: float, every: int) -> list[tuple[int, int]]:
    """Numbers of a left and a right frame in which the board rests at a place where it was not yet.

    Parameters
    ----------
    left, right : Seen
    later_s : float, by how much later the right film began
    every : int, of so many left frames the stillest one is looked at
    """
    speeds = [np.nan_to_num(film.speed(), nan=np.inf) for film in (left, right)]
    partner = _nearest(left.times_s - later_s, right.times_s)
    together = np.abs(right.times_s[partner] - (left.times_s - later_s)) < PAIRED_S
    worst = np.where(together, np.maximum(speeds[0], speeds[1][partner]), np.inf)
    coverage, chosen = Coverage(), []
    for start in range(0, len(worst), every):
        k = start + int(worst[start : start + every].argmin())
        both = left.glances[k], right.glances[partner[k]]
        if worst[k] < STILL and None not in both and coverage.is_new(*both):
            coverage.add(*both)
            chosen.append((k, int(partner[k])))
    return chosen


def _nearest(times, others):
    """For each time the number of the nearest of the others."""
    after = np.clip(np.searchsorted(others, times), 1, len(others) - 1)
    return after - (times - others[after - 1] < others[after] - times)


def import_films(
    left: str | Path, right: str | Path, board: Board, out: str | Path, ball: Ball | None = None, every: int = OF_FRAMES,
    progress: Progress | None = None,
) -> tuple[Recording, float]:  # fmt: skip
    """Make a recording from two films of a board.

    Parameters
    ----------
    left, right : path of a video
    board : Board
    out : path of a folder that is not there yet
    ball : Ball, optional; a red one of 40 mm where it is not given
    every : int, of so many frames the one is looked at in which the board is stillest
    progress : callable (what is done, done, total), optional

    Returns
    -------
    recording : Recording
    later_s : float, by how much later the right film began

    Raises
    ------
    RecordingError
        If the folder is there, a film cannot be read, the two do not fit together, or the board never rests before both cameras.
    """
    check_new(out)
    say = progress or (lambda *_: None)
    one = watch(left, board, lambda *n: say(f"watch {left}", *n))
    other = watch(right, board, lambda *n: say(f"watch {right}", *n))
    for path, film in ((left, one), (right, other)):
        _check_seen(path, film, board)
    later, _ = offset_s(one, other)
    chosen = resting_pairs(one, other, later, every)
    if not chosen:
        raise RecordingError(
            "The board never rests before both cameras: hold it still for a second at each of twenty places."
        )
    size = one.size
    with whole_folder(Path(out)) as part, Folder(part, size, board, ball or USUAL_BALL) as folder:
        pictures = zip(_some(left, [k for k, _ in chosen]), _some(right, [k for _, k in chosen]), strict=False)
        for done, (left_image, right_image) in enumerate(pictures, 1):
            folder.add_pair(BOARDS, left_image, fitted(right_image, size))
            say("take the pairs", done, len(chosen))
        if len(folder.names(BOARDS)) < len(chosen):
            raise RecordingError("A film gave fewer pictures the second time it was read. Save it anew, and try again.")
    return open_recording(out), later


def _check_seen(path, film, board):
    """Refuse a film that shows the board hardly ever: two of those fit together nowhere, and that would be told instead."""
    seen, frames = sum(glance is not None for glance in film.glances), len(film.glances)
    if seen * float(np.ptp(film.times_s)) / frames < LEAST_SHARED_S:
        raise RecordingError(
            f"{path}: a {board} is seen in {seen} of {frames} frames, and must be for {LEAST_SHARED_S:g} s at least. Does the "
            "board have other numbers of corners, or is it too far away?"
        )


def _some(path: str | Path, numbers: list[int]) -> Iterator[np.ndarray]:
    """Some frames of a film, in the order of their numbers, which never falls; the same one may be asked for twice."""
    wanted = list(numbers)
    for number, (_, frame) in enumerate(read_timed(path)):
        while wanted and wanted[0] == number:
            yield frame
            wanted.pop(0)
        if not wanted:
            return


def fitted(image: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    """A picture of another camera brought to one size: scaled to fit into it, with black round it. Its camera is another one then, and calibrated as such."""
    width, height = size
    scale = min(width / image.shape[1], height / image.shape[0])
    if scale == 1 and image.shape[1::-1] == tuple(size):
        return image
    how = cv2.INTER_AREA if scale < 1 else cv2.INTER_CUBIC
    small = cv2.resize(image, (round(image.shape[1] * scale), round(image.shape[0] * scale)), interpolation=how)
    whole = np.zeros((height, width, 3), np.uint8)
    top, left = (height - small.shape[0]) // 2, (width - small.shape[1]) // 2
    whole[top : top + small.shape[0], left : left + small.shape[1]] = small
    return whole

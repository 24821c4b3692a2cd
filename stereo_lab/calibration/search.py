"""The boards of a recording: pairs in, corners out."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from stereo_lab.calibration.corners import find_corners, match_order
from stereo_lab.calibration.refusals import check_enough, check_shown, check_together
from stereo_lab.calibration.shapes import board_shapes
from stereo_lab.calibration.start import first_rig
from stereo_lab.calibration.views import View
from stereo_lab.common.threads import one_thread
from stereo_lab.errors import CalibrationError
from stereo_lab.recording import Board, StereoPair

NO_BOARD = {
    1: "no whole board in the {} picture; the other one still counts for its camera's lens",
    2: "no whole board in the {} and the {} picture",
}
GLIMPSE = 6  # pairs without the board after which another one is looked for: to find none takes longest
SAMPLE = 24  # pairs that tell whether the others are worth the time


def find_views(
    pairs: Sequence[StereoPair], board: Board, progress: Callable[[int, int], object] | None = None
) -> tuple[list[View], list[tuple[str, str]], tuple[int, int]]:
    """Corners of every pair of which a camera sees the whole board.

    Some pairs come first, picked by chance from all of them: where they show no board, or another one, or boards of two
    moments, the others are not looked at.

    Returns
    -------
    views : list of View
    dropped : list of (name, why) of the pairs in which not both cameras see the board
    size : (width, height), px

    Raises
    ------
    CalibrationError
        If the pictures differ in size, or the first pairs are hopeless.
    """
    first = sorted(np.random.default_rng(0).permutation(len(pairs))[:SAMPLE].tolist())
    order = first + [k for k in range(len(pairs)) if k not in first]
    size = pairs[order[0]].left.shape[1::-1] if pairs else (0, 0)
    views: list[View] = []
    dropped: list[tuple[str, str]] = []
    for done, pair in enumerate((pairs[k] for k in order), 1):
        left, right = pair.left, pair.right
        _check_size(pair.name, (left, right), size)
        on_left, on_right = find_corners(left, board), find_corners(right, board)
        lost = [side for side, corners in (("left", on_left), ("right", on_right)) if corners is None]
        if lost:
            dropped.append((pair.name, NO_BOARD[len(lost)].format(*lost)))
        if len(lost) < 2:
            views.append(_view(pair.name, on_left, on_right, board))
        if progress:
            progress(done, len(pairs))
        if done == GLIMPSE < len(pairs):
            check_shown(views, [pairs[k] for k in order[:done]], board)
        if done == len(first) < len(pairs):
            _check_sample(views, pairs, first, board, size)
    return views, dropped, size


def _view(name, left, right, board):
    """The corners of one pair, in one order; NaN for the camera that does not see the board."""
    nowhere = np.full((len(board.corners_mm), 2), np.nan)
    if left is None or right is None:
        return View(name, nowhere if left is None else left, nowhere if right is None else right)
    return View(name, left, match_order(left, right, board))


def _check_size(name, images, size):
    for image in images:
        if image.shape[1::-1] != size:
            raise CalibrationError(
                f"Pair {name} is {image.shape[1]}x{image.shape[0]} pixels, the others are {size[0]}x{size[1]}."
            )


def _check_sample(views, pairs, first, board, size):
    """Refuse a hopeless set after a few pairs: none shows the board, or none is of one moment."""
    both = [view for view in views if view.seen_by_both]
    if not both:
        check_enough(both, [pairs[k] for k in first], board, len(pairs))
    if len(both) >= len(first) / 2:
        with one_thread():
            check_together(first_rig(both, board_shapes(board).flat, size, 0)[2])

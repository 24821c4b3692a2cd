"""From pairs of pictures of a chessboard to two calibrated cameras."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import cv2
import numpy as np

from stereo_lab.calibration.cameras import StereoCalibration
from stereo_lab.calibration.corners import check_board_size, find_corners, match_order
from stereo_lab.calibration.solver import (
    FEWEST,
    View,
    check_sides,
    choose_lens,
    same_moment,
    unseen_errors,
    why_dropped,
)
from stereo_lab.calibration.verdict import verdict_on
from stereo_lab.common.threads import one_thread
from stereo_lab.errors import CalibrationError
from stereo_lab.recording import Board, StereoPair

OTHER_MOMENT = "the two pictures do not match: were they taken at the same moment?"
PLACES = 3  # of px and mm; what two computers reckon differently lies far behind them
STILL = 0.01  # of the picture's width: a board that moves less does not move


def calibrate_stereo(
    pairs: Sequence[StereoPair], board: Board, progress: Callable[[int, int], object] | None = None
) -> StereoCalibration:
    """Calibrate two cameras from pairs of pictures of a chessboard.

    Parameters
    ----------
    pairs : sequence of StereoPair
    board : Board
    progress : callable (done, total), optional

    Returns
    -------
    StereoCalibration

    Raises
    ------
    CalibrationError
        If fewer than three pairs show the board, the board has another size, or left and right
        are swapped.
    """
    pairs = list(pairs)
    views, dropped, size = _find_views(pairs, board, progress)
    if len(views) < FEWEST:
        if len(views) < len(pairs) / 2:
            check_board_size(pairs, board)
        raise CalibrationError(
            f"The board with {board.columns}x{board.rows} inner corners was found in {len(views)} of {len(pairs)} "
            f"pairs; at least {FEWEST} are needed, and 15 to 25 are good. Take more, sharp and well lit, "
            "with the whole board in both pictures."
        )
    _check_spread(views, size)
    found = len(views)
    views.sort(key=lambda view: float(view.left.sum()))  # by what is seen: a file's name decides nothing
    with one_thread():
        together = same_moment(views, board, size)
    if not together.any():
        raise CalibrationError(
            "The two cameras do not see the same boards: how the board moves before the left one does not fit how it "
            "moves before the right one. Check that the two pictures of a pair were taken at the same moment, and that "
            "no picture is missing on one side."
        )
    if together.sum() >= max(FEWEST, len(views) / 2):
        dropped += [(view.name, OTHER_MOMENT) for view, same in zip(views, together, strict=True) if not same]
        views = [view for view, same in zip(views, together, strict=True) if same]
    with one_thread():
        lens, fit, kept, heldout = choose_lens(views, board, size)
    check_sides(fit)
    dropped += [(views[i].name, why_dropped(fit, views[i], board, size)) for i in range(len(views)) if i not in kept]
    used = [views[i] for i in kept]
    result = StereoCalibration(
        image_size=size,
        left_matrix=fit.k1.round(PLACES),
        left_distortion=fit.d1.round(2 * PLACES),
        right_matrix=fit.k2.round(PLACES),
        right_distortion=fit.d2.round(2 * PLACES),
        rotation=cv2.Rodrigues(cv2.Rodrigues(fit.rotation)[0].round(2 * PLACES))[0],
        translation_mm=fit.translation.round(PLACES),
        rms_px=fit.rms,
        left_rms_px=fit.sides[0],
        right_rms_px=fit.sides[1],
        vertical_error_px=float(np.mean([unseen_errors(fit, view, board, size)[0] for view in used])),
        heldout_vertical_error_px=heldout[0],
        heldout_length_error_percent=heldout[1],
        focal_sigma_percent=fit.focal_sigma,
        board_bend_mm=float(np.ptp(fit.shape[:, 2])),
        lens=lens,
        pairs=len(pairs),
        found=found,
        used=tuple(pair.name for pair in pairs if pair.name in {view.name for view in used}),
        dropped=tuple(sorted(dropped)),
    )
    verdict, reasons = verdict_on(result, board, [(v.left, v.right) for v in used])
    return replace(result, verdict=verdict, reasons=reasons)


def _check_spread(views, size):
    """A board that never moves tells one view of itself, however many pictures there are."""
    for seen in ("left", "right"):
        corners = np.array([getattr(view, seen) for view in views])
        if len(views) > 1 and corners.std(axis=0).mean() < STILL * size[0]:
            raise CalibrationError(
                f"The board is in the same place in all {len(views)} pairs. Between two pictures, move it to another "
                "part of the picture, turn it, and tilt it to another side."
            )


def _find_views(pairs, board, progress):
    """Corners of every pair that shows the whole board to both cameras."""
    views, dropped, size = [], [], None
    for index, pair in enumerate(pairs):
        left, right = pair.left, pair.right
        size = size or left.shape[1::-1]
        for image in (left, right):
            if image.shape[1::-1] != size:
                raise CalibrationError(
                    f"Pair {pair.name} is {image.shape[1]}x{image.shape[0]} pixels, the others are {size[0]}x{size[1]}."
                )
        corners = [find_corners(image, board) for image in (left, right)]
        lost = [side for side, c in zip(("left", "right"), corners, strict=True) if c is None]
        if lost:
            dropped.append((pair.name, f"no whole board in the {' and the '.join(lost)} picture"))
        else:
            views.append(View(pair.name, corners[0], match_order(corners[0], corners[1], board)))
        if progress:
            progress(index + 1, len(pairs))
    return views, dropped, size

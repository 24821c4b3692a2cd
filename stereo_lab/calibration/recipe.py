"""From pairs of pictures of a chessboard to two calibrated cameras."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from stereo_lab.calibration.bundle import Rig, matrices
from stereo_lab.calibration.cameras import StereoCalibration
from stereo_lab.calibration.heldout import errors_on_unseen, pair_errors
from stereo_lab.calibration.refusals import (
    check_corners,
    check_different,
    check_enough,
    check_focal,
    check_pairs,
    check_sides,
    check_spread,
    check_together,
    check_two_cameras,
)
from stereo_lab.calibration.search import find_views
from stereo_lab.calibration.shapes import board_shapes
from stereo_lab.calibration.solver import OTHER_MOMENT, solve, why_bad
from stereo_lab.calibration.start import first_rig
from stereo_lab.calibration.uncertainty import covariance, misfit
from stereo_lab.calibration.verdict import verdict_on
from stereo_lab.calibration.views import View, without_copies
from stereo_lab.common.threads import one_thread
from stereo_lab.recording import Board, StereoPair
from stereo_lab.recording.sample import must_be_board

JUDGED_AT_MM = 1000.0  # the distance of the verdict where none is told


def calibrate_stereo(
    pairs: Sequence[StereoPair], board: Board, progress: Callable[[int, int], object] | None = None,
    depth_mm: float = JUDGED_AT_MM,
) -> StereoCalibration:  # fmt: skip
    """Calibrate two cameras from pairs of pictures of a chessboard.

    Parameters
    ----------
    pairs : sequence of StereoPair
    board : Board
    progress : callable (done, total), optional
    depth_mm : float, the distance from the cameras for which the verdict is given

    Returns
    -------
    StereoCalibration

    Raises
    ------
    CalibrationError
        If fewer than four pairs show the board, the board has another size, the boards do not tell where the
        cameras stand, or left and right are swapped.
    """
    pairs = check_pairs(pairs)
    must_be_board(board)
    views, dropped, size = find_views(pairs, board, progress)
    check_enough([view for view in views if view.seen_by_both], pairs, board)
    return calibrate_views(views, board, size, [pair.name for pair in pairs], dropped, depth_mm)


def calibrate_views(
    views: Sequence[View], board: Board, size: tuple[int, int], names: Sequence[str], dropped: Sequence[tuple[str, str]] = (),
    depth_mm: float = JUDGED_AT_MM,
) -> StereoCalibration:  # fmt: skip
    """The same from corners that are found already.

    Parameters
    ----------
    views : sequence of View, each with the corners of at least one camera, enough of them of both
    board : Board
    size : (width, height), px
    names : of all pairs there were, in their order
    dropped : (name, why) of pairs that are left out already
    depth_mm : float, the distance from the cameras for which the verdict is given

    Raises
    ------
    CalibrationError
        As :func:`calibrate_stereo`.
    """
    check_corners(views, board)
    both = [view for view in views if view.seen_by_both]
    check_two_cameras(both)
    check_spread(both, size)
    views = sorted(views, key=lambda view: view.place)  # by what is seen: a file's name decides nothing
    views, copies = without_copies(views)
    check_different([view for view in views if view.seen_by_both], len(both))
    dropped = [*dropped, *copies]
    with one_thread():
        shapes = board_shapes(board)
        rig, boards, together = first_rig(views, shapes.flat, size, len(shapes.sigma_mm))
        check_together(together & [view.seen_by_both for view in views])
        dropped += [(view.name, OTHER_MOMENT) for view, same in zip(views, together, strict=True) if not same]
        views = [view for view, same in zip(views, together, strict=True) if same]
        fit = solve(rig, boards.some(together), views, shapes, size)
        dropped += [(views[k].name, why_bad(fit, views[k], shapes)) for k in fit.bad]
        kept = [views[k] for k in fit.kept]
        quality = _quality(fit, kept, board, shapes, size, depth_mm)
        # Before the sides: untilted boards leave open where a camera stands
        check_focal(quality["focal_sigma_percent"], quality["rms_px"], size)
        check_sides(fit.solution.rig)
        calibration = StereoCalibration(
            image_size=size, pairs=len(names), found=len(both),
            used=tuple(name for name in names if name in {view.name for view in kept if view.seen_by_both}),
            dropped=tuple(sorted(dropped)), depth_mm=depth_mm, **_cameras(fit.solution.rig), outlines=_outlines(kept, board),
            corners_left_out=_corners_left_out(fit.solution, kept),
            **quality,
        )  # fmt: skip
    verdict, reasons = verdict_on(calibration, board)
    return replace(calibration, verdict=verdict, reasons=reasons)


def _cameras(rig: Rig) -> dict[str, Any]:
    """The two cameras as OpenCV writes them."""
    (left_matrix, left_distortion), (right_matrix, right_distortion) = matrices(rig.left), matrices(rig.right)
    return {
        "left_matrix": left_matrix,
        "left_distortion": left_distortion,
        "right_matrix": right_matrix,
        "right_distortion": right_distortion,
        "rotation": rig.rotation,
        "translation_mm": rig.translation,
        "lens": "brown",
    }


def _quality(fit, views, board, shapes, size, depth_mm):
    """How well the cameras explain the boards, and what they know of themselves."""
    solution = fit.solution
    square, used = (solution.missing**2).sum(-1), solution.weights > 0
    vertical, length = errors_on_unseen(solution, views, board, size)
    inflated = max(1.0, misfit(solution, size, depth_mm))
    knows = covariance(solution) * inflated**2
    focal = [np.sqrt(knows[k, k]) / focal for k, focal in ((0, solution.rig.left[0]), (9, solution.rig.right[0]))]
    return {
        "rms_px": float(np.sqrt(square[used].mean())),
        "left_rms_px": float(np.sqrt(square[..., 0][used[..., 0]].mean())),
        "right_rms_px": float(np.sqrt(square[..., 1][used[..., 1]].mean())),
        "vertical_error_px": _mean([pair_errors(solution.rig, v, board, size)[0] for v in views]),
        "heldout_vertical_error_px": vertical,
        "heldout_length_error_percent": length,
        "focal_sigma_percent": float(100 * max(focal)),
        "board_bend_mm": float(np.ptp((shapes.flat + shapes.ways @ solution.boards.bends)[:, 2])),
        "covariance": knows,
        "misfit": inflated,
    }


def _mean(numbers):
    """Mean of the numbers that are known; NaN where none is."""
    known = [number for number in numbers if np.isfinite(number)]
    return float(np.mean(known)) if known else float("nan")


def _corners_left_out(solution, views):
    """(pair, side, u, v, px off) of single corners that the rest contradicts, the worst first."""
    seen = [[view.left, view.right] for view in views]
    out = []
    for board, corner, side in np.argwhere(solution.weights == 0):
        u, v = (float(p) for p in seen[board][side][corner])
        if not np.isnan(u):
            off = float(np.linalg.norm(solution.missing[board, corner, side]))
            out.append((views[board].name, ("left", "right")[side], round(u, 1), round(v, 1), round(off, 2)))
    return tuple(sorted(out, key=lambda corner: -corner[-1]))


def _outlines(views, board):
    """The four outer corners of each board, or of what is seen of it, in each picture, one after the other round it."""
    return np.array([[_outer(view.left, board), _outer(view.right, board)] for view in views], float)


def _outer(seen, board):
    """Of what is seen of a board, the corners nearest to its own four; NaN where it is not seen."""
    there = np.flatnonzero(~np.isnan(seen[:, 0]))
    if not len(there):
        return np.full((4, 2), np.nan)
    x, y = board.corners_mm[there, :2].T
    return seen[there[[(x + y).argmin(), (x - y).argmax(), (x + y).argmax(), (x - y).argmin()]]]

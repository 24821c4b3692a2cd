"""From corners to two cameras: the fit, what it leaves out, and what it knows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from stereo_lab.calibration.bundle import CAMERAS, LENS, Boards, Rig, Shapes, Solution, fit, matrices
from stereo_lab.calibration.views import View, stacked
from stereo_lab.errors import CalibrationError

SOLVER = 5  # counts up whenever the same boards give another calibration: those kept are then made anew
FEWEST = 4  # pairs without which nothing is solved: three agree with too many cameras
K3_AT_CORNER = 0.005  # of the radius at the picture's corner: as much as most lenses bend it by their third term
HUBER = 2.0  # sigmas; beyond, a corner pulls no harder
ROUGH = 1e-2  # of a variance: near enough where only outliers are looked for
BAD_CORNER = 5.0  # sigmas
BAD_VIEW = 3.0  # times the median view's
FEW = 10  # views: of fewer a wrong one pulls all the others with it, and lies no farther off than they
HALVED = 0.5  # what is left of the misfit without that view; without a right one nine tenths are
ROUNDS = 8
LEAST_SIGMA_PX = 0.01  # corners are never known better: drawn boards are exact and real ones are not
OTHER_MOMENT = "the two pictures do not match: were they taken at the same moment?"
NORMAL = 1.4826  # sigmas in a median of the sizes, for errors that are normally spread


@dataclass(frozen=True, eq=False)
class Fit:
    """A solution and the views that it rests on.

    Attributes
    ----------
    solution : Solution
    kept, bad : list of int, the views it rests on, and those that the others contradict
    sigma_px : float, of one coordinate, robustly
    """

    solution: Solution
    kept: list[int]
    bad: list[int]
    sigma_px: float


def solve(rig: Rig, boards: Boards, views: Sequence[View], shapes: Shapes, size: tuple[int, int]) -> Fit:
    """Both cameras from what they saw, without the corners and the views that the rest contradicts.

    First a fit in which nobody pulls hard (Huber's weights). Views that then lie far off are left out, then single
    corners. The fit is done again without them, and with a prior on k3 that gives way where the boards insist.
    """
    seen, there = stacked(views)
    chosen, enough = np.arange(len(views)), max(FEWEST, len(views) / 2)
    while True:
        rough, sigma = robust_fit(rig, boards.some(chosen), seen[chosen], there[chosen], shapes, size)
        off = view_errors(rough.missing, there[chosen], BAD_CORNER * sigma)
        bad = off > max(BAD_VIEW * np.median(off), BAD_VIEW * LEAST_SIGMA_PX)
        if not bad.any() or (~bad).sum() < enough:
            bad = _one_against_the_others(rig, boards.some(chosen), seen[chosen], there[chosen], shapes, size, sigma)
        if not bad.any():
            solution, sigma, bad = _exact(seen[chosen], there[chosen], shapes, size, rough, sigma)
        if not bad.any():
            break
        if (~bad).sum() < enough:
            raise CalibrationError(_contradict([views[k].name for k in chosen[bad]]), fault="not_together")
        chosen = chosen[~bad]
    kept = chosen.tolist()
    return Fit(solution, kept, [k for k in range(len(views)) if k not in kept], sigma)


def _one_against_the_others(rig, boards, seen, there, shapes, size, sigma):
    """Which view of few it is without which all others agree far better; none, where they agree no better without any."""
    if len(seen) >= FEW:
        return np.zeros(len(seen), bool)
    others = ~np.eye(len(seen), dtype=bool)
    without = [robust_fit(rig, boards.some(o), seen[o], there[o], shapes, size)[1] for o in others]
    return ~others[int(np.argmin(without))] & (min(without) < HALVED * sigma)


def _contradict(names):
    """A sentence for boards that contradict the rest, without which too few are left."""
    one = len(names) == 1
    return (
        f"The board{'' if one else 's'} of {', '.join(names)} contradict{'s' if one else ''} the others, and without {'it' if one else 'them'} too "
        "few are left. Was a camera moved, refocused or zoomed between two pairs? Take more; `stereo-lab check` tries which belong together."
    )


def robust_fit(
    rig: Rig, boards: Boards, seen: np.ndarray, there: np.ndarray, shapes: Shapes, size: tuple[int, int]
) -> tuple[Solution, float]:
    """A fit in which nobody pulls hard (Huber's weights), and the robust sigma of a coordinate, px.

    Parameters
    ----------
    rig, boards : Rig and Boards to start from
    seen, there : ndarray, as :func:`stacked` gives them
    shapes : Shapes
    size : (width, height), px
    """
    weights, sigma = there.astype(float), 1.0
    for _ in range(ROUNDS):
        solution = fit(rig, boards, seen, weights, shapes, prior_of(rig, shapes, size), sigma**2, ROUGH)
        rig, boards, before, sigma = solution.rig, solution.boards, sigma, robust_sigma(solution.missing[there])
        off = np.linalg.norm(solution.missing, axis=-1)
        weights = there * np.minimum(1, HUBER * sigma / np.maximum(off, 1e-9))
        if abs(sigma - before) < 0.05 * sigma:
            break
    return solution, sigma


def _exact(seen, there, shapes, size, solution, sigma):
    """Least squares without the corners that lie far off, until these and the prior stay the same.

    Returns as well which views keep less than half of what a camera saw of them: then nothing is solved.
    """
    kept, prior = None, None
    for _ in range(ROUNDS):
        far = np.abs(solution.missing).max(-1) >= BAD_CORNER * sigma
        now, loose = there & ~far, prior_of(solution.rig, shapes, size)
        bad = (now.sum(1) < there.sum(1) / 2).any(-1)
        if bad.any() or (kept is not None and (now == kept).all() and np.allclose(loose, prior, rtol=0.02)):
            break
        kept, prior = now, loose
        solution = fit(solution.rig, solution.boards, seen, kept.astype(float), shapes, prior, sigma**2)
        sigma = robust_sigma(solution.missing[kept])
    return solution, sigma, bad


def robust_sigma(values: np.ndarray) -> float:
    """Standard deviation told by the median, which a few wild values do not move."""
    return max(float(NORMAL * np.median(np.abs(values))), LEAST_SIGMA_PX)


def view_errors(missing: np.ndarray, there: np.ndarray, most: float) -> np.ndarray:
    """Root mean square of each view's corners, px; one wild corner does not count for more than ``most``."""
    square = np.minimum((missing**2).sum(-1), 2 * most**2) * there
    return np.sqrt(square.sum((1, 2)) / (2 * np.maximum(there.sum((1, 2)), 1)))


def prior_of(rig: Rig, shapes: Shapes, size: tuple[int, int]) -> np.ndarray:
    """Variance of each shared unknown round 0: infinite but for k3 and the board's shapes.

    That of k3 grows where k3 is large already (the reweighting of a Cauchy prior): a lens that needs it gets it.
    """
    prior = np.full(CAMERAS + len(shapes.sigma_mm), np.inf)
    for lens, first in ((rig.left, 0), (rig.right, len(LENS))):
        corner = np.hypot(*size) / 2 / lens[0]
        prior[first + LENS.index("k3")] = (K3_AT_CORNER / corner**6) ** 2 + lens[LENS.index("k3")] ** 2
    prior[CAMERAS:] = shapes.sigma_mm**2
    return prior


def why_bad(fit: Fit, view: View, shapes: Shapes) -> str:
    """In words, why a view does not fit the others: one camera's corners are off, or the two do not match."""
    rig = fit.solution.rig
    board = shapes.flat + shapes.ways @ fit.solution.boards.bends
    alone = {side: _error_alone(getattr(view, side), board, getattr(rig, side)) for side in ("left", "right")}
    worse = max(alone, key=lambda side: np.nan_to_num(alone[side]))
    if alone[worse] > BAD_VIEW * fit.sigma_px:
        return f"corners of the {worse} picture are off by {alone[worse]:.2f} px: blurred, bent or partly hidden"
    return OTHER_MOMENT


def _error_alone(seen, board, lens):
    """Root mean square error of one camera's corners, the board held as that camera tells; NaN where it sees none."""
    there = ~np.isnan(seen[:, 0])
    if not there.any():
        return np.nan
    camera = matrices(lens)
    _, vector, shift = cv2.solvePnP(board[there], seen[there].astype(float).reshape(-1, 1, 2), *camera)
    off = cv2.projectPoints(board[there], vector, shift, *camera)[0].reshape(-1, 2) - seen[there]
    return float(np.sqrt((off**2).sum(1).mean()))

"""Small changes between the pairs: one joint fit, and what each pair would rather have.

A fit of all pairs leaves, for each of them, a pull on the cameras' unknowns. Where nothing has changed the pulls are noise. Where
a camera was moved before pair k, the pulls of the pairs from k on point the same way. How much of the misfit such a change takes
away follows from the fit's own equations, without fitting again (a score test).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from stereo_lab.calibration.bundle import CAMERAS, LENS, RIGHT, STEP, TURN, Rig, Solution, equations, look
from stereo_lab.calibration.bundle import Boards as Held
from stereo_lab.calibration.shapes import board_shapes
from stereo_lab.calibration.solver import robust_fit, robust_sigma
from stereo_lab.calibration.start import board_pose, first_rig
from stereo_lab.calibration.views import stacked
from stereo_lab.doctor.boards import Boards, posed

FEWEST = 6  # pairs of which some can be told to differ from the others
SURE = 60.0  # of twice the log likelihood, beyond what chance gives the best of all places: rendered and real lenses fit no model
ODD_PART = 3  # at most one pair in so many is odd; more are a fault of all
MEDIAN_OF_SIX = 5.35  # of chi-square with six degrees of freedom
ROUNDS = 8
HUBER, WILD = 8.0, 20.0  # sigmas beyond which a corner pulls no harder, and beyond which it is as wrong as any
ALL_DIFFER = 6.0  # the pairs' misfit by what chance gives, from which all of them differ
SLIP_ROUNDS = 16
LEFT_OF_SLIPS = 0.07  # of what pairs disagree in, beyond noise: a board that moves turns as well, and leaves twice this
FIELD = [(i, j) for i in range(6) for j in range(6) if i or j]  # waves over a picture, halves of one across and down
FIELD_ROUNDS = 8  # the boards' places take a part of a field upon themselves, and give it back slowly
MOST_NOISE_PX = 0.5  # more, where each picture is explained by itself: these cameras are none


def _direction(*where):
    """Columns of the shared unknowns, shape (24, n)."""
    columns = np.zeros((CAMERAS, len(where)))
    for n, rows in enumerate(where):
        columns[list(rows), n] = 1
    return columns


POSE = _direction(*([k] for k in range(TURN.start, STEP.stop)))
CHANGES = {
    "moved": POSE,
    "left": _direction([LENS.index("fx"), LENS.index("fy")]),  # zoomed: both focal lengths, in pixels, by as much
    "right": _direction([RIGHT.start + LENS.index("fx"), RIGHT.start + LENS.index("fy")]),
}


@dataclass(frozen=True, eq=False)
class Together:
    """A joint fit of pairs, with weights that no corner pulls hard against.

    Attributes
    ----------
    boards : Boards
    solution : Solution
    sigma_px : float, of a coordinate
    """

    boards: Boards
    solution: Solution
    sigma_px: float


def fit_together(boards: Boards) -> Together:
    """Fit all pairs together. Raises CalibrationError where they cannot be."""
    shapes = board_shapes(boards.board)
    rig, held, _ = first_rig(boards.views, shapes.flat, boards.size, len(shapes.sigma_mm))
    seen, there = stacked(boards.views)
    solution, sigma = robust_fit(rig, held, seen, there, shapes, boards.size)
    return Together(boards, solution, sigma)


@dataclass(frozen=True, eq=False)
class Change:
    """Something that differs from one pair on.

    Attributes
    ----------
    what : "moved", or "left" or "right" for the camera that zoomed
    k : int, the first pair of the new state
    sure : float, how much of the misfit it takes away, beyond chance
    """

    what: str
    k: int
    sure: float


class Pulls:
    """What each pair would rather have of the shared unknowns."""

    def __init__(self, together: Together) -> None:
        solution = together.solution
        self.matrices = solution.equations.matrices / solution.variance
        self.sides = solution.equations.sides / solution.variance
        self.inverse = np.linalg.inv(solution.information)
        self.count = len(self.sides)
        self.alone = np.array([self._gain(POSE, [k])[0] for k in range(self.count)])

    def _gain(self, columns, pairs, moved=None):
        """Misfit that a change of some unknowns takes away where only these pairs have it, and the change."""
        wide = np.zeros((len(self.inverse), columns.shape[1]))
        wide[:CAMERAS] = columns
        matrix, side = self.matrices[pairs].sum(0), self.sides[pairs].sum(0)
        if moved is not None:
            side = side - matrix @ moved
        inner = wide.T @ (matrix - matrix @ self.inverse @ matrix) @ wide
        inner += 1e-12 * np.trace(inner) * np.eye(len(inner))
        pull = wide.T @ side
        change = np.linalg.solve(inner, pull)
        return float(pull @ change), wide @ change

    def spread(self) -> float:
        """How much more the pairs differ than noise says, the best single change taken out; 1 where they do not."""
        k = max(range(2, self.count - 1), key=lambda k: self._gain(POSE, slice(k, None))[0])
        _, change = self._gain(POSE, slice(k, None))
        back = self.inverse @ self.matrices[k:].sum(0) @ change
        rest = [self._gain(POSE, [n], change * (n >= k) - back)[0] for n in range(self.count)]
        return max(1.0, min(np.median(self.alone), 1.2 * np.median(rest)) / MEDIAN_OF_SIX)

    def change(self, spread: float) -> Change:
        """The likeliest change from one pair on."""
        chance = {what: columns.shape[1] * np.log(2 * self.count) for what, columns in CHANGES.items()}
        every = [
            Change(what, k, self._gain(columns, slice(k, None))[0] / spread - chance[what])
            for what, columns in CHANGES.items()
            for k in range(2, self.count - 1)
        ]
        return max(every, key=lambda change: change.sure)

    def odd(self, spread: float) -> tuple[np.ndarray, float]:
        """Pairs that differ from all others, each in its own way, and how sure that is."""
        order = np.argsort(-self.alone)
        most = max(1, min(4, self.count // ODD_PART))
        gains = np.cumsum(self.alone[order[:most]] / spread - len(POSE.T) * np.log(2 * self.count))
        best = int(gains.argmax())
        return np.sort(order[: best + 1]), float(gains[best])


def lenses_straightened(together: Together) -> Together:
    """A fit of the pairs without what hangs on the place in the picture alone.

    No lens is quite as the model of five numbers has it. What it lacks is the same at one place of the picture for every pair, so
    a smooth field for each camera takes it away. A board that moved, or a picture that slipped, leaves other pixels off in each
    pair, and no field explains them. Raises CalibrationError where the pairs cannot be fitted.
    """
    for _ in range(FIELD_ROUNDS):
        boards, solution = together.boards, together.solution
        sides = zip(
            (boards.left, boards.right),
            np.moveaxis(solution.missing, 2, 0),
            np.moveaxis(solution.weights, 2, 0),
            strict=True,
        )
        left, right = (_without_field(*side, boards.size) for side in sides)
        together = fit_together(replace(boards, left=left, right=right))
    return together


def _without_field(seen, missing, weights, size):
    """Corners of one camera without the smooth field that explains most of what they lack."""
    waves = np.cos(np.pi * seen[..., None, :] / size * FIELD).prod(-1)
    held = (weights > 0) & ~np.isnan(missing).any(-1)
    return seen - waves @ np.linalg.lstsq(waves[held], missing[held], rcond=None)[0]


def pictures_slip(boards: Boards) -> bool:
    """Whether all that the pairs disagree in goes away when each picture may have slipped as a whole.

    That is what a camera does which stabilises its pictures. A board that moves between the two pictures of a pair turns a little
    and comes nearer, too. Each round takes off what the middle corner of a pair lacks; noise is what is left where each camera's
    picture of a board is explained by itself. Raises CalibrationError where the pairs cannot be fitted.
    """
    first = together = fit_together(boards)
    for _ in range(SLIP_ROUNDS):
        off = together.solution.missing
        by = np.nanmedian(off[:, :, 1] - off[:, :, 0], axis=1)
        boards = replace(boards, right=boards.right - by[:, None])
        together = fit_together(boards)
    shapes, solution = board_shapes(boards.board), together.solution
    corners = shapes.flat + shapes.ways @ solution.boards.bends
    lenses = (boards.left, solution.rig.left), (boards.right, solution.rig.right)
    noise = max(np.nanmedian(posed(seen, corners, lens).rms_px) for seen, lens in lenses) / np.sqrt(2)
    had, left = (robust_sigma(fit.solution.missing[~np.isnan(fit.solution.missing)]) for fit in (first, together))
    return bool(noise < MOST_NOISE_PX and left**2 - noise**2 < LEFT_OF_SLIPS**2 * (had**2 - noise**2))


def _let_go(boards, start, columns, rig=None):
    """Other pairs under a rig that is known but for some unknowns: the rig, and what is missing of their corners.

    The boards keep their shape; where each is held is free.
    """
    shapes = board_shapes(boards.board)
    seen, there = stacked(boards.views)
    rig, bends = rig or start.solution.rig, start.solution.boards.bends
    held = _held(boards, rig, shapes.flat + shapes.ways @ bends, bends)
    for _ in range(ROUNDS):
        pixels, by_shared, by_held = look(rig, held, shapes)
        off = np.linalg.norm(seen - pixels, axis=-1) / start.sigma_px
        weights = there * np.minimum(1, HUBER / np.maximum(off, 1e-9))
        told = equations(by_shared[..., :CAMERAS] @ columns, by_held, seen - pixels, weights, 1e-3)
        step = np.linalg.solve(told.matrices.sum(0), told.sides.sum(0))
        rig, held = rig.moved(columns @ step), held.moved(0 * bends, told.held - told.back @ step)
    return rig, np.where(there[..., None], seen - look(rig, held, shapes)[0], np.nan)


def _held(boards, rig, corners, bends):
    """Where the boards are before a rig that is known: told by whichever camera sees them."""
    turns, shifts = [], []
    for left, right in zip(boards.left, boards.right, strict=True):
        pose = board_pose(left.astype(float), corners, rig.left)
        if pose is None:
            turn, shift = board_pose(right.astype(float), corners, rig.right)
            pose = rig.rotation.T @ turn, rig.rotation.T @ (shift - rig.translation)
        turns.append(pose[0])
        shifts.append(pose[1])
    return Held(bends, np.array(turns), np.array(shifts))


def what_changed(others: Boards, start: Together) -> tuple[str, Rig]:
    """Which change explains other pairs best, and the rig after it.

    Parameters
    ----------
    others : Boards, the pairs on the far side of the change
    start : Together, the fit of those on the near side
    """
    fits = {}
    for what, columns in CHANGES.items():
        rig, missing = _let_go(others, start, columns)
        misfit = np.nansum(np.minimum((missing / start.sigma_px) ** 2, WILD**2))
        fits[what] = misfit + columns.shape[1] * np.log(missing.size), rig
    what = min(fits, key=lambda what: fits[what][0])
    return what, fits[what][1]


def off_by(others: Boards, start: Together, rig: Rig | None = None) -> np.ndarray:
    """How far other pairs' corners lie from what a fit, or another rig, says, px: three quarters of each pair's coordinates are nearer."""
    _, missing = _let_go(others, start, np.zeros((CAMERAS, 0)), rig)
    return np.nanpercentile(np.abs(missing).reshape(len(missing), -1), 75, axis=1)

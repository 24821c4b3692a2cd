"""What is seen of the boards, pair by pair, and how well the pairs agree on where the right camera stands.

Each camera alone tells where a board is held before it, so each pair of pictures tells where the right camera stands. In a good
recording all pairs tell the same. Whether they do needs no calibration of both, and takes a fraction of a second.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np

from stereo_lab.calibration.bundle import matrices, project
from stereo_lab.calibration.start import board_pose
from stereo_lab.calibration.views import View
from stereo_lab.recording import Board

MOST_VIEWS = 40  # from which a camera alone is told
FEWEST = 3  # pairs of which one can disagree with the others
SHOWN = 12  # corners of a board, spread over it, that stand for all
FAR_OFF = 1e4  # px, for a place behind a camera, or in its lens


@dataclass(frozen=True, eq=False)
class Boards:
    """The corners of every pair, in the order in which the pairs were taken.

    Attributes
    ----------
    names : of the pairs
    left, right : ndarray, shape (pairs, corners, 2), px; NaN where a corner was not seen
    board : Board
    size : (width, height), px
    """

    names: tuple[str, ...]
    left: np.ndarray
    right: np.ndarray
    board: Board
    size: tuple[int, int]

    @property
    def both(self) -> np.ndarray:
        """Which pairs show the board to both cameras: shape (pairs,), bool."""
        return ~(np.isnan(self.left).all((1, 2)) | np.isnan(self.right).all((1, 2)))

    @property
    def views(self) -> list[View]:
        """As the calibration takes them."""
        return [View(*each) for each in zip(self.names, self.left, self.right, strict=True)]

    def some(self, chosen: np.ndarray) -> Boards:
        """Some of the pairs only, by a mask or by numbers."""
        names = tuple(np.array(self.names, object)[chosen])
        return replace(self, names=names, left=self.left[chosen], right=self.right[chosen])


@dataclass(frozen=True, eq=False)
class Alone:
    """One camera as it tells itself, and where it sees each board.

    Attributes
    ----------
    lens : ndarray, shape (9,), as in ``calibration/bundle.py``
    turns, shifts : ndarray, shapes (pairs, 3, 3) and (pairs, 3); NaN where it sees none
    rms_px : ndarray, shape (pairs,), how far each board's corners lie from what this camera explains; NaN where it sees none
    """

    lens: np.ndarray
    turns: np.ndarray
    shifts: np.ndarray
    rms_px: np.ndarray


def camera_alone(seen: np.ndarray, board: Board, size: tuple[int, int]) -> Alone:
    """A camera by its own pictures alone (``cv2.calibrateCamera``), shape of ``seen`` (pairs, corners, 2)."""
    flat = np.asarray(board.corners_mm, float)
    shown = np.flatnonzero((~np.isnan(seen[..., 0])).sum(1) >= 6)
    some = shown[np.unique(np.linspace(0, len(shown) - 1, MOST_VIEWS).astype(int))]
    there = [~np.isnan(seen[k, :, 0]) for k in some]
    objects = [flat[t].astype(np.float32) for t in there]
    pixels = [seen[k, t].astype(np.float32).reshape(-1, 1, 2) for k, t in zip(some, there, strict=True)]
    width, height = size
    guess = np.array([[1.2 * width, 0, (width - 1) / 2], [0, 1.2 * width, (height - 1) / 2], [0, 0, 1]])
    how = cv2.CALIB_USE_INTRINSIC_GUESS | cv2.CALIB_FIX_K3 | cv2.CALIB_FIX_ASPECT_RATIO
    _, matrix, distortion, _, _ = cv2.calibrateCamera(objects, pixels, size, guess, None, flags=how)
    return posed(seen, flat, np.array([*matrix[[0, 1, 0, 1], [0, 1, 2, 2]], *distortion.ravel()[:5]]))


def posed(seen: np.ndarray, flat: np.ndarray, lens: np.ndarray) -> Alone:
    """Where a camera with this lens sees each board, whose corners are ``flat``, shape (corners, 3), mm."""
    poses = [board_pose(s.astype(float), flat, lens) for s in seen]
    turns = np.array([np.full((3, 3), np.nan) if p is None else p[0] for p in poses])
    shifts = np.array([np.full(3, np.nan) if p is None else p[1] for p in poses])
    told = np.array([_seen_by(lens, flat @ q.T + t) for q, t in zip(turns, shifts, strict=True)])
    with np.errstate(invalid="ignore"):
        square = ((told - seen) ** 2).sum(-1)
        rms = np.sqrt(np.nansum(square, 1) / np.maximum((~np.isnan(square)).sum(1), 1))
    return Alone(lens, turns, shifts, np.where(np.isnan(shifts[:, 0]), np.nan, rms))


def _seen_by(lens, points):
    """Pixels of points of one camera's frame; NaN for places that are not known."""
    if np.isnan(points).any():
        return np.full((len(points), 2), np.nan)
    return cv2.projectPoints(points.reshape(-1, 1, 3), np.zeros(3), np.zeros(3), *matrices(lens))[0].reshape(-1, 2)


def posed_by(alone: Alone, seen: np.ndarray, board: Board) -> Alone:
    """The same camera before other boards."""
    return posed(seen, np.asarray(board.corners_mm, float), alone.lens)


def steps_between(left: Alone, right: Alone) -> tuple[np.ndarray, np.ndarray]:
    """Where the right camera stands, as each pair tells it: turns (pairs, 3, 3) and shifts (pairs, 3), left to right."""
    turns = right.turns @ left.turns.transpose(0, 2, 1)
    return turns, right.shifts - np.einsum("nij,nj->ni", turns, left.shifts)


def disagreement(
    left: Alone, seen: np.ndarray, lens: np.ndarray, steps: tuple[np.ndarray, np.ndarray], board: Board
) -> np.ndarray:
    """How far each pair's corners lie from where each pair's step puts them.

    Parameters
    ----------
    left : Alone, who says where the boards are
    seen : ndarray, shape (pairs, corners, 2), px, what the other camera saw
    lens : ndarray, shape (9,), of the other camera
    steps : turns and shifts of :func:`steps_between`

    Returns
    -------
    ndarray, shape (pairs, steps), root mean square, px; infinite where a pair or a step is not known
    """
    turns, shifts = (np.nan_to_num(part) for part in steps)
    flat = np.asarray(board.corners_mm, float)
    errors = np.full((len(seen), len(turns)), np.inf)
    for k in np.flatnonzero(~np.isnan(left.shifts[:, 0])):
        corners = _spread(board, seen[k])
        points = flat[corners] @ left.turns[k].T + left.shifts[k]
        moved = np.einsum("sij,cj->sci", turns, points) + shifts[:, None]
        told = project(np.where(moved[..., 2:] > board.square_mm, moved, [0, 0, 1.0]), lens)[0]
        off = np.where(moved[..., 2] > board.square_mm, ((told - seen[k, corners]) ** 2).sum(-1), FAR_OFF**2)
        if len(corners) >= 4:
            errors[k] = np.sqrt(np.minimum(off, FAR_OFF**2).mean(1))
    errors[:, np.isnan(steps[1][:, 0])] = np.inf
    return errors


def _spread(board, seen):
    """Numbers of some corners that a camera saw, spread over them; the board's four outer ones among them where it saw those."""
    there = np.flatnonzero(~np.isnan(seen[:, 0]))
    across, down = board.grid
    outer = np.intersect1d([0, across - 1, across * (down - 1), across * down - 1], there)
    return np.unique([*outer, *there[np.linspace(0, len(there) - 1, SHOWN).astype(int)]]) if len(there) else there

"""What was seen of the board in a pair of pictures."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

STILL_PX = 0.5  # a hand holds no board so still between two pictures; on a stand it tells the same twice
NOTHING_NEW = ", and tells nothing new"


@dataclass(frozen=True, eq=False)
class View:
    """The corners of one pair.

    Attributes
    ----------
    name : str, of the pair
    left, right : ndarray, shape (corners, 2), px; NaN for a corner that was not seen
    """

    name: str
    left: np.ndarray
    right: np.ndarray

    @property
    def seen_by_both(self) -> bool:
        """Whether both cameras see corners."""
        return not (np.isnan(self.left).all() or np.isnan(self.right).all())

    @property
    def place(self) -> float:
        """A number that tells views apart, and does not depend on their names."""
        return float(np.nansum(self.left) + np.nansum(self.right))


def stacked(views: Sequence[View]) -> tuple[np.ndarray, np.ndarray]:
    """All corners, shape (views, corners, 2 cameras, 2), px, 0 where not seen; and which were seen, without the last axis."""
    seen = np.stack([[v.left for v in views], [v.right for v in views]], 2).astype(float)
    return np.nan_to_num(seen), ~np.isnan(seen[..., 0])


def without_copies(views: Sequence[View]) -> tuple[list[View], list[tuple[str, str]]]:
    """Views of different places of the board, and (name, why) of those that show a place once more.

    Copies agree with each other better than any camera can, and would make the cameras surer than the boards do.
    """
    kept: list[View] = []
    copies = []
    for view in views:
        twin = next((other for other in kept if _still(view, other)), None)
        if twin is None:
            kept.append(view)
        else:
            copies.append((view.name, f"shows the board where it is in pair {twin.name}{NOTHING_NEW}"))
    return kept, copies


def _still(one, other):
    """Whether the board stands at one place before both cameras in two views; what only one of them sees tells nothing."""
    both = np.array([one.left - other.left, one.right - other.right])
    off = np.linalg.norm(both, axis=-1)
    return bool(np.isfinite(off).any() and np.nanmax(off) < STILL_PX and _sees(one) == _sees(other))


def _sees(view):
    return [bool(np.isfinite(side).any()) for side in (view.left, view.right)]

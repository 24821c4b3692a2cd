"""What was seen of the board in a pair of pictures."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np


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

"""What the boards taken so far cover, and what to do with the next one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stereo_lab.calibration.advice import part_of_picture
from stereo_lab.capture.glance import Glance

CELLS = 6, 5  # of a picture, across and down
COVERED = 0.8  # of the cells: nobody reaches all of them
ENOUGH = 20  # pairs
NEAR, FAR = 0.45, 0.25  # the board's width, as a part of the picture's
TILTED_DEG = 15.0
TILTS = {
    "its left edge towards you": (0, -1), "its right edge towards you": (0, 1), "its upper edge towards you": (1, -1),
    "its lower edge towards you": (1, 1),
}  # fmt: skip
DISTANCES = ("near", "in between", "far")
SAME = 0.04  # of the picture's width: boards whose corners lie nearer than this on average are one place


@dataclass(frozen=True)
class Bar:
    """How much of one thing is done.

    Attributes
    ----------
    name : str
    part : float, 0…1
    """

    name: str
    part: float


class Coverage:
    """The boards taken so far, as both cameras saw them.

    Attributes
    ----------
    taken : list of (Glance or None, Glance or None), left and right
    """

    def __init__(self) -> None:
        self.taken: list[tuple[Glance | None, Glance | None]] = []

    def add(self, left: Glance | None, right: Glance | None) -> None:
        """One more pair."""
        self.taken.append((left, right))

    def cells(self, side: int) -> np.ndarray:
        """How many boards had corners in each cell of one camera's picture, shape (5, 6)."""
        count = np.zeros(CELLS[::-1], int)
        for seen in (pair[side] for pair in self.taken):
            if seen is not None:
                rows, columns = cells_of(seen)
                count[rows, columns] += 1
        return count

    def bars(self) -> list[Bar]:
        """What is done, for bars that fill."""
        both = [pair for pair in self.taken if None not in pair]
        done = [Bar("pairs", min(1.0, len(both) / ENOUGH))]
        for side, name in enumerate(("left", "right")):
            done.append(Bar(f"{name} picture", min(1.0, float((self.cells(side) > 0).mean()) / COVERED)))
        done.append(Bar("near and far", len(self._distances()) / len(DISTANCES)))
        done.append(Bar("tilted", len(self._tilts()) / len(TILTS)))
        return done

    def _distances(self):
        wide = [seen.wide for pair in self.taken for seen in pair if seen is not None]
        return {DISTANCES[0 if w > NEAR else 2 if w < FAR else 1] for w in wide}

    def _tilts(self):
        """Which of the four ways a board was tilted."""
        tilts = [seen.tilt_deg for pair in self.taken for seen in pair if seen is not None]
        return {name for name, (axis, sign) in TILTS.items() if any(sign * tilt[axis] > TILTED_DEG for tilt in tilts)}

    @property
    def complete(self) -> bool:
        """Whether nothing is missing."""
        return all(bar.part >= 1 for bar in self.bars())

    def is_new(self, left: Glance | None, right: Glance | None) -> bool:
        """Whether a board is somewhere else, or held in another way, than all that were taken."""
        return all(_apart((left, right), before) > SAME for before in self.taken)

    def reaches_rim(self, seen: Glance, side: int) -> bool:
        """Whether a board fills a cell at the rim of one camera's picture in which none was yet."""
        rows, columns = cells_of(seen)
        rim = (rows == 0) | (rows == CELLS[1] - 1) | (columns == 0) | (columns == CELLS[0] - 1)
        return bool((self.cells(side)[rows[rim], columns[rim]] == 0).any())

    def next_place(self) -> str:
        """What to do with the next board, in words; empty where nothing is missing."""
        bars = {bar.name: bar.part for bar in self.bars()}
        name = min((n for n in bars if n != "pairs"), key=lambda n: bars[n])
        if bars[name] >= 1:
            return "" if bars["pairs"] >= 1 else "Hold it anywhere, tilted another way."
        if name == "tilted":
            return f"Tilt the board: {next(t for t in TILTS if t not in self._tilts())}."
        if name == "near and far":
            missing = next(d for d in DISTANCES if d not in self._distances())
            return {"near": "Come nearer with the board.", "far": "Go farther away with the board."}.get(
                missing, "Hold the board at half the way."
            )
        side = ("left picture", "right picture").index(name)
        return f"Hold the board at the {self.emptiest(side)} of the {name}."

    def emptiest(self, side: int) -> str:
        """The part of one camera's picture that has fewest boards, in words."""
        count = self.cells(side).astype(float)
        near = np.pad(count, 1, mode="edge")
        blurred = sum(
            near[1 + dy : 1 + dy + CELLS[1], 1 + dx : 1 + dx + CELLS[0]] for dy in (-1, 0, 1) for dx in (-1, 0, 1)
        )
        row, column = np.unravel_index(int((blurred + 0.01 * count).argmin()), count.shape)
        return part_of_picture(np.array([column + 0.5, row + 0.5]), CELLS)


def cells_of(seen: Glance) -> tuple[np.ndarray, np.ndarray]:
    """Rows and columns of the cells in which a board has corners."""
    places = np.clip((seen.corners / seen.size * CELLS).astype(int), 0, np.array(CELLS) - 1)
    return places[:, 1], places[:, 0]


def _apart(now: Sequence[Glance | None], before: Sequence[Glance | None]) -> float:
    """Mean distance of the outer corners of two boards, as a part of the picture's width; infinite where no camera sees both."""
    both = [(a, b) for a, b in zip(now, before, strict=True) if a is not None and b is not None]
    if not both:
        return np.inf
    return float(np.mean([np.linalg.norm(a.outline - b.outline, axis=1).mean() / a.size[0] for a, b in both]))

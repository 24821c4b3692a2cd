"""What a judge has learned: a table of numbers, in a file that people can read, and how large marked balls look.

The shipped table comes from ``data/train``.
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from stereo_lab.errors import StereoLabError

MOST = 2.5  # spreads off its mean that a piece of evidence may count
NEARER = 0.5  # in logarithms: a ball may come nearer or go farther than the marks tell by so much at least, 1.6 times
FILE = Path(__file__).parent / "weights.json"


@dataclass(frozen=True, eq=False)
class Weights:
    """Of each piece of evidence its mean, spread and weight, and the weight of each two together.

    Attributes
    ----------
    names : tuple of str, the n pieces of evidence
    mean, spread, weight : ndarray, shape (n,)
    together : ndarray, shape (n, n), symmetric
    constant : float, the logarithm of the odds of a thing against none before any evidence
    trained_on : str
    """

    names: tuple[str, ...]
    mean: np.ndarray
    spread: np.ndarray
    weight: np.ndarray
    together: np.ndarray
    constant: float
    trained_on: str = ""

    def spreads_off(self, evidence: np.ndarray) -> np.ndarray:
        """How many spreads each piece lies off its mean, MOST at most."""
        return np.minimum(np.maximum((evidence - self.mean) / self.spread, -MOST), MOST)

    def logit(self, evidence: np.ndarray) -> float:
        """The logarithm of the odds of a thing against none: each piece of evidence and each two, weighed."""
        z = self.spreads_off(evidence)
        return float(self.constant + z.dot(self.weight + self.together.dot(z)))

    def logits(self, evidence_Nxn: np.ndarray) -> np.ndarray:
        """The same for a row of evidence each, shape (N,)."""
        z = self.spreads_off(evidence_Nxn)
        return self.constant + (z * (self.weight + z @ self.together)).sum(1)

    def text(self) -> str:
        """As JSON, a line for each piece of evidence: mean, spread, weight, then those with each other."""
        table = np.column_stack([self.mean, self.spread, self.weight, self.together])
        rows = zip(self.names, table, strict=True)
        lines = [f"  {json.dumps(name)}: {[round(float(v), 4) for v in row]}" for name, row in rows]
        head = json.dumps({"trained_on": self.trained_on, "constant": round(self.constant, 4)})[:-1]
        return head + ',\n "evidence": {\n' + ",\n".join(lines) + "\n }}\n"

    @classmethod
    def of(cls, table: dict[str, Any]) -> Weights:
        """From what :meth:`text` wrote, read as JSON.

        Raises
        ------
        StereoLabError
            If a number is missing or is none, or a spread is not above zero.
        """
        try:
            names = tuple(table["evidence"])
            rows = np.array([table["evidence"][name] for name in names], float)
            constant, told = float(table["constant"]), str(table.get("trained_on", ""))
        except (KeyError, TypeError, ValueError) as error:
            raise StereoLabError(f"its table of weights cannot be read ({error})") from None
        if rows.shape != (len(names), 3 + len(names)) or not np.isfinite(rows).all() or not np.isfinite(constant):
            raise StereoLabError(f"its table of weights is not {len(names)} rows of {3 + len(names)} finite numbers")
        if not (rows[:, 1] > 0).all():
            raise StereoLabError("a spread in its table of weights is not above zero")
        return cls(names, rows[:, 0], rows[:, 1], rows[:, 2], rows[:, 3:], constant, told)


class Sizes(NamedTuple):
    """Of the logarithm of the radius, in picture widths: its middle, its spread, and how many marks more than one told them."""

    middle: float = 0.0
    spread: float = 1.0
    freedom: int = 0

    @classmethod
    def of(cls, images: Sequence[np.ndarray], circles: Sequence[Sequence[float]]) -> Sizes:
        """As marks tell them: (u, v, radius) px in each picture."""
        sizes = np.log([circle[2] / np.shape(image)[1] for image, circle in zip(images, circles, strict=True)])
        spread = max(NEARER, float(sizes.std(ddof=1))) if len(sizes) > 1 else NEARER
        return cls(float(sizes.mean()), spread * math.sqrt(1 + 1 / len(sizes)), len(sizes) - 1)

    def logit(self, radius: float) -> float:
        """How much a size, in picture widths, speaks against a ball: 0 in the middle, below 0 the farther from it.

        By Student's t, which is what a few marks tell of the next one. Fewer than two tell nothing: always 0.
        """
        if not self.freedom:
            return 0.0
        off = (math.log(radius) - self.middle) / self.spread
        return -(self.freedom + 1) / 2 * math.log1p(off * off / self.freedom)


SHIPPED = Weights.of(json.loads(FILE.read_text(encoding="utf-8")))


def speaks(evidence: np.ndarray, weights: Weights = SHIPPED) -> dict[str, float]:
    """What each piece of evidence adds to the sum, what it has together with others shared between them. Above zero: for a ball.

    Before any evidence a thing is more probably none: that comes first, "to begin with". All together are the logit.
    """
    z = weights.spreads_off(evidence)
    parts = zip(weights.names, z * (weights.weight + weights.together @ z), strict=True)
    return {"to begin with": weights.constant} | dict(parts)

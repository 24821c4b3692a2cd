"""How large a ball looks: what marks in some pictures tell of the next one."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

NEARER = 0.5  # in logarithms: a ball may come nearer or go farther than the marks tell by so much at least, 1.6 times


class Sizes(NamedTuple):
    """Of the logarithm of the radius, in picture widths: its middle, its spread, and how many marks more than one told them."""

    middle: float = 0.0
    spread: float = 1.0
    freedom: int = 0

    @classmethod
    def of(cls, images: Sequence[np.ndarray], circles: Sequence[Sequence[float]]) -> Sizes:
        """As marks tell them: (u, v, radius) px in each picture."""
        sizes = np.log([circle[2] / image.shape[1] for image, circle in zip(images, circles, strict=True)])
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

"""How well a share is known that was counted."""

from __future__ import annotations

import math

Z_95 = 1.959964  # standard deviations of a normal distribution: 95 of 100 lie within


def interval_95(count: int, of: int) -> tuple[float, float]:
    """Between which shares the true one lies with 95 %, where ``count`` of ``of`` were counted (E. B. Wilson 1927).

    Of none counted it is anything: (0, 1).
    """
    if of == 0:
        return 0.0, 1.0
    share, z2 = count / of, Z_95**2
    middle = (share + z2 / (2 * of)) / (1 + z2 / of)
    half = Z_95 / (1 + z2 / of) * math.sqrt(share * (1 - share) / of + z2 / (4 * of * of))
    return max(0.0, middle - half), min(1.0, middle + half)


def told(count: int, of: int) -> str:
    """A share in words: "58 of 70, 83 % (72 to 90)"; in brackets what it may be with 95 %."""
    low, high = interval_95(count, of)
    return f"{count} of {of}, {100 * count / of:.0f} % ({100 * low:.0f} to {100 * high:.0f})" if of else "0 of 0"

"""How a wrong number stands to the right one: a factor, a sign, a power, rounded too much."""

from __future__ import annotations

import numpy as np

from stereo_lab.exercises.trying import near

FACTORS = {
    1e6: "a million times too large: look at the units.",
    1000.0: "a thousand times too large: look at the units.",
    100.0: "a hundred times too large.",
    10.0: "ten times too large.",
    2.0: "twice as large as it should be.",
    0.5: "half of what it should be.",
    0.1: "ten times too small.",
    0.01: "a hundred times too small.",
    0.001: "a thousand times too small: look at the units.",
    1e-6: "a million times too small: look at the units.",
    3**0.5: "√3 times too large: a sum stands where the mean belongs, or a root too few.",
    3**-0.5: "√3 times too small: a mean stands where the sum belongs, before the root.",
    2**0.5: "√2 times too large: a sum stands where the mean belongs, or a root too few.",
    2**-0.5: "√2 times too small: a mean stands where the sum belongs, before the root.",
    360.0: "360 times too large: degrees and turns.",
    1 / 360: "360 times too small: degrees and turns.",
    np.pi: "π times too large.",
    1 / np.pi: "π times too small.",
    180.0: "180 times too large.",
    1 / 180: "180 times too small.",
    180 / np.pi: "180/π times too large: degrees and radians.",
    np.pi / 180: "180/π times too small: degrees and radians.",
}
NEAR_BY = 0.05  # so near, as a part of the value, is a number that was rounded, read off or copied


def of_a_number(value: float, right: float, told: str) -> str:
    """What one wrong number is to the right one; "" where it is nothing of note. ``told`` is the number with its unit."""
    if not right or not value:
        return ""
    if near(value, -right):
        return f"{told}: the sign is turned."
    for factor in (1000.0, 100.0, 10.0, 2.0, 0.5, 0.1, 0.01, 0.001):
        if near(value, factor * right):
            unit = " Are these centimetres?" if factor == 0.1 and told.endswith(" mm") else ""
            return f"{told} is {FACTORS[factor]}{unit}"
        if near(value, -factor * right):
            return f"{told} is {FACTORS[factor].partition(':')[0].rstrip('.')}, and the sign is turned."
    for factor in (3, 4):
        if near(value, factor * right):
            return f"{told} is {factor} times what is asked for."
        if near(value, right / factor):
            return f"{told} is a {'third' if factor == 3 else 'quarter'} of what is asked for."
    if abs(right) != 1:
        for other, words in ((1 / right, "upside down: it is one over"), (right**2, "the square of")):
            if near(value, other):
                return f"{told} is {words} what is asked for."
    if any(value == round(right, k) for k in range(4)):
        return f"{told} is rounded too much. Keep its decimals."
    if any(value == np.trunc(right * 10**k) / 10**k for k in (0, 1)):
        return f"{told} is cut off too early. Keep its decimals."
    return ""


def is_near_by(value: float, right: float) -> bool:
    """Whether a number lies so near to the right one that it was rather rounded or read off."""
    return abs(value - right) <= NEAR_BY * abs(right)

"""Outputs of notebooks, compared as a reader would: words exactly, numbers as numbers.

Another processor may move the last digit of a printed number. So each number has room, and the words, the lines
and the order of everything do not:

- a number with a decimal point or an exponent, and a whole number with a unit (px, mm, °, %, V, s, ms, ...), may
  differ by ABSOLUTE units of its last printed place, or by RELATIVE of its size, whichever is more;
- a whole number without a unit is a count, or a name: it is compared exactly;
- a cell that needs more room says so in its metadata:
  "stereo_lab": {"tolerance": {"absolute": 0.5, "relative": 0.05, "whole": 1, "why": "..."}}. The absolute one is in
  the number's unit, and "whole" is the room of whole numbers without a unit, as in a table with units in its head.

Blanks before and after a number do not count: columns are padded.
"""

from __future__ import annotations

import re

ABSOLUTE, RELATIVE = 1.0, 0.002
UNITS = r"px|mm|cm|m|°|deg|degrees|%|V|ms|s|mm/px|°/s|°/s/V|mm/°"
NUMBER = re.compile(
    rf"(?P<number>(?<![\w.])[-+−]?(?:\d+\.\d*|\.\d+|\d+)(?:e[-+]?\d+)?(?![\w.]\d|[A-DF-Za-df-z_]))(?=(?P<unit>\s*(?:{UNITS})(?![\w]))?)"
)


class Printed(str):
    """A text that equals another one where the words are the same and every number is near its twin.

    Attributes
    ----------
    room : dict with "absolute", "relative" and "whole", or None for the rule by the last printed place
    """

    room = None

    def __eq__(self, other):
        return not differences(str(self), str(other), self.room or getattr(other, "room", None))

    def __ne__(self, other):
        return not self == other

    __hash__ = str.__hash__


def differences(left, right, room=None):
    """What differs between two printed texts: a list of (from the one, from the other), empty where nothing does."""
    ours, theirs = list(_tokens(left)), list(_tokens(right))
    if len(ours) != len(theirs):
        return [(left, right)]
    return [(a[0], b[0]) for a, b in zip(ours, theirs, strict=True) if not _near(a, b, room)]


def _tokens(text):
    """(text, value or None, size of the last place or 0 for a count) of each word part and number, in order."""
    at = 0
    for found in NUMBER.finditer(text):
        yield text[at : found.start()].strip(" "), None, 0.0
        word = found["number"]
        yield word, float(word.replace("−", "-")), _last_place(word, found["unit"])
        at = found.end()
    yield text[at:].strip(" "), None, 0.0


def _last_place(word, unit):
    mantissa, _, power = word.partition("e")
    places = len(mantissa.partition(".")[2])
    if not (places or power or unit):
        return 0.0
    return 10.0 ** (int(power or 0) - places)


def _near(ours, theirs, room):
    if ours[1] is None or theirs[1] is None:
        return ours == theirs
    room = room or {}
    if not (ours[2] and theirs[2]):
        allowed = room.get("whole", 0.0)
    else:
        last_place = ABSOLUTE * min(ours[2], theirs[2])
        allowed = max(room.get("absolute", last_place), room.get("relative", RELATIVE) * abs(ours[1]))
    return abs(ours[1] - theirs[1]) <= allowed * (1 + 1e-9)

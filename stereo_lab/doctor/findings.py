"""What the doctor says: findings, in the order of their weight, and a verdict."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

STOPS, COSTS, NOTE = SEVERITIES = ("stops", "costs", "note")
SHARE = 0.5  # of the clean error: what costs more is a fault, what costs less a note
CLEAN, WANTING = "clean", "wanting"


@dataclass(frozen=True)
class Evidence:
    """How a fault was seen: a number for each file, for a figure.

    Attributes
    ----------
    what : str, what the numbers are, with their unit
    values : (name, number) of each file looked at, in the order of the recording
    marked : names of those that are at fault
    places : (u, v) of what is drawn in the frame of a picture instead, px
    size : (width, height) of that picture
    """

    what: str
    values: tuple[tuple[str, float], ...] = ()
    marked: tuple[str, ...] = ()
    places: tuple[tuple[float, float], ...] = ()
    size: tuple[int, int] = (0, 0)


@dataclass(frozen=True)
class Finding:
    """One thing that is wrong.

    Attributes
    ----------
    name : str, always the same for the same fault: "camera_moved"
    says : str, what is wrong and how it was seen
    advice : str, what to do
    files : names of the files concerned, such as "calibration/007"
    does_mm : float, how far off places are by it, 95 % of them, at the recording's own distance; None where nothing comes
        out at all, or where it is not known
    severity : str, "stops", "costs" or "note"
    evidence : Evidence or None
    """

    name: str
    says: str
    advice: str
    files: tuple[str, ...] = ()
    does_mm: float | None = None
    severity: str = NOTE
    evidence: Evidence | None = field(default=None, compare=False)

    def facts(self) -> dict[str, Any]:
        """What ``stereo-lab check --json`` tells of it."""
        does = _told(self.does_mm)
        return {
            "name": self.name, "severity": self.severity, "files": list(self.files), "says": self.says, "does_mm": does,
            "try": self.advice,
        }  # fmt: skip


@dataclass(frozen=True)
class Checkup:
    """What came of looking a recording through.

    Attributes
    ----------
    findings : tuple of Finding, the weightiest first
    clean_mm : float, how far off the depth of a ball may be, 95 % of them, when all that was found is mended; None where
        that is not known
    depth_mm : float, the distance for which all of it is told
    """

    findings: tuple[Finding, ...]
    clean_mm: float | None
    depth_mm: float

    @property
    def verdict(self) -> str:
        """Either "clean" or "wanting"; notes alone are clean."""
        return WANTING if any(finding.severity != NOTE for finding in self.findings) else CLEAN

    @property
    def says(self) -> str:
        """The verdict in a sentence."""
        if self.clean_mm is not None and math.isfinite(self.clean_mm):
            means = f"The depth of a ball at {self.depth_mm / 1000:.1f} m comes out to about ±{self.clean_mm:.1f} mm"
        else:
            means = f"How far off a depth may be {'cannot' if self.verdict == CLEAN else 'can'} be told"
        if self.verdict == CLEAN:
            return f"Nothing is wrong that matters. {means}."
        count = sum(finding.severity != NOTE for finding in self.findings)
        things = "one thing" if count == 1 else f"{count} things"
        return f"There {'is' if count == 1 else 'are'} {things} to mend. {means}, once that is done."

    def facts(self) -> dict[str, Any]:
        """What ``stereo-lab check --json`` writes."""
        return {
            "findings": [finding.facts() for finding in self.findings],
            "verdict": self.verdict,
            "says": self.says,
            "clean_mm": _told(self.clean_mm),
            "depth_mm": self.depth_mm,
        }


def listed(what: str, names: Sequence[str]) -> str:
    """Some of a kind in words: "set depth", "sets depth, position and track"."""
    *others, last = names
    return f"{what}s {', '.join(others)} and {last}" if others else f"{what} {last}"


def _told(mm):
    """As JSON can tell it: what is endless or unknown is none."""
    return None if mm is None or not math.isfinite(mm) else round(mm, 2)


def in_order(findings: Sequence[Finding]) -> tuple[Finding, ...]:
    """The weightiest first: what stops everything in the order found, then by millimetres."""
    return tuple(sorted(findings, key=lambda f: (SEVERITIES.index(f.severity), -(f.does_mm or 0))))


def severity_of(does_mm: float | None, clean_mm: float | None) -> str:
    """A fault where it does more than :data:`SHARE` of the error that a clean recording has; else a note."""
    if does_mm is None or not math.isfinite(does_mm):
        return STOPS
    return COSTS if does_mm > SHARE * (clean_mm or 0) else NOTE

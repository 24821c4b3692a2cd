"""What the kit costs, by its list of parts, beside the table that closes the paper."""

from __future__ import annotations

import csv
from dataclasses import dataclass
from importlib.resources import files

PAPERS_TABLE_II = (  # what, dollars, how exact, as the paper prints it
    ("Bumblebee2", "> 1500", "~1 cm"),
    ("ZED", "> 400", "~1 cm"),
    ("Karmin2", "> 400", "~2 cm"),
    ("other low-cost [6]", "> 100", ""),
    ("the paper's rig", "~ 50", "~2 cm"),
    ("[5] and others", "< 20", "no readings"),
)


@dataclass(frozen=True)
class Part:
    """One line of ``firmware/parts.csv``.

    Attributes
    ----------
    name : str
    count : int
    usd_each : float
    checked : bool, whether the price was looked up at its seller
    """

    name: str
    count: int
    usd_each: float
    checked: bool


def parts_of(what: str) -> list[Part]:
    """The parts of the kit, by ``firmware/parts.csv``.

    Parameters
    ----------
    what : "eyes" (two cameras), "DC" (the arm with gear motors) or "servo" (the arm with bus servos)
    """
    text = files("stereo_lab.firmware").joinpath("parts.csv").read_text(encoding="utf-8")
    return [
        Part(row["part"], int(row["count"]), float(row["usd_each"]), row["checked"] == "yes")
        for row in csv.DictReader(text.splitlines())
        if row["arm"] == what
    ]


def cost_usd(what: str) -> float:
    """What a part of the kit costs, in US dollars; ``what`` as in :func:`parts_of`."""
    return sum(part.usd_each * part.count for part in parts_of(what))

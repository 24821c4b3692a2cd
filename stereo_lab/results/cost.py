"""What the kit costs, by its list of parts, beside the table that closes the paper."""

from __future__ import annotations

import csv
from importlib.resources import files

PAPERS_TABLE_II = (  # what, dollars, how exact, as the paper prints it
    ("Bumblebee2", "> 1500", "~1 cm"),
    ("ZED", "> 400", "~1 cm"),
    ("Karmin2", "> 400", "~2 cm"),
    ("other low-cost [6]", "> 100", ""),
    ("the paper's rig", "~ 50", "~2 cm"),
    ("[5] and others", "< 20", "no readings"),
)


def cost_usd(part: str) -> float:
    """What a part of the kit costs, in US dollars, by ``firmware/parts.csv``.

    Parameters
    ----------
    part : "eyes" (two cameras), "DC" (the arm with gear motors) or "servo" (the arm with bus servos)
    """
    text = files("stereo_lab.firmware").joinpath("parts.csv").read_text(encoding="utf-8")
    rows = list(csv.DictReader(text.splitlines()))
    return sum(float(row["usd_each"]) * float(row["count"]) for row in rows if row["arm"] == part)

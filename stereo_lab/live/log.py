"""The log of a run: JSON Lines, one file a run, a header and then one line a picture."""

from __future__ import annotations

import csv
import io
import json
import os
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TextIO

import numpy as np

from stereo_lab.common.files import check_target, read_bytes, write_whole
from stereo_lab.errors import StereoLabError

FORMAT, KIND = 1, "stereo_lab run"


def header(source: str, arm: str, localizer: str, calibration: dict[str, Any]) -> dict[str, Any]:
    """What stands in the first line: who took the log, of what, and when.

    Parameters
    ----------
    source, arm : str, their names
    localizer : str, the recording that the localizer was fitted on
    calibration : dict, facts of the calibration
    """
    from stereo_lab import __version__

    started = time.strftime("%Y-%m-%dT%H:%M:%S%z")
    facts = {"kind": KIND, "format": FORMAT, "version": __version__, "started": started}
    return facts | {"source": source, "arm": arm, "fitted_on": localizer, "calibration": calibration}


def check_new(path: str | Path) -> None:
    """Refuse a log that is there already, or for which there is no folder: before anything moves.

    Raises
    ------
    StereoLabError
        If it is so.
    """
    path = Path(path)
    check_target(path)
    if path.exists():
        raise StereoLabError(f"{path} exists already, and a log is not written over. Name another file.")
    if not os.access(path.absolute().parent, os.W_OK):
        raise StereoLabError(
            f"{path} cannot be written: there is no such folder, or it cannot be written to. Name another file."
        )


class RunLog:
    """A file that takes the records of a run, each handed to the system at once: a crash loses at most one line.

    Parameters
    ----------
    path : str or Path, a file that does not exist yet
    head : dict, see :func:`header`

    Attributes
    ----------
    trouble : str, why nothing is written any more; empty as long as it is

    Raises
    ------
    StereoLabError
        If the file exists, or cannot be made.
    """

    def __init__(self, path: str | Path, head: dict[str, Any]) -> None:
        self.path, self.trouble = Path(path), ""
        check_new(self.path)
        try:
            self._file: TextIO | None = open(self.path, "x", encoding="utf-8", newline="\n")  # noqa: SIM115
        except OSError as error:
            raise StereoLabError(f"{self.path} cannot be written: {error.strerror or error}.") from None
        self.write(head)

    def write(self, record: dict[str, Any]) -> None:
        """One more line. Where the disk is full, that is told in ``trouble``, once, and nothing more is written."""
        if self._file is None:
            return
        try:
            self._file.write(json.dumps(record) + "\n")
            self._file.flush()
        except (OSError, ValueError) as error:
            self.trouble = (
                f"{self.path}: {getattr(error, 'strerror', None) or error}. The log ends here; the run goes on."
            )
            self.close()

    def close(self) -> None:
        """No more lines come."""
        file, self._file = self._file, None
        if file is not None:
            try:
                file.close()
            except OSError:  # what was left to write does not go on to a full disk either
                pass


@dataclass(frozen=True, eq=False)
class Run:
    """A run as its log tells it.

    Attributes
    ----------
    head : dict, the header
    records : list of dict, one for each picture
    broken : int, lines that could not be read: a crash leaves one at the end
    """

    head: dict[str, Any]
    records: list[dict[str, Any]]
    broken: int = 0

    def column(self, name: str) -> np.ndarray:
        """One value of every record as float, NaN where it is missing, shape (N,)."""
        return np.array([_number(record.get(name)) for record in self.records], float)

    def summary(self) -> dict[str, Any]:
        """What the run was like, in numbers and words; None for what was never known."""
        said: dict[str, int] = {}
        for record in self.records:
            said[str(record.get("said", ""))] = said.get(str(record.get("said", "")), 0) + 1
        time_s = self.column("time_s")
        time_s = time_s[np.isfinite(time_s)]
        seen = sum(record.get("seen") is True for record in self.records)
        facts: dict[str, Any] = {
            "pictures": sum("number" in record for record in self.records),  # a touch has a line and no picture
            "seconds": float(np.ptp(time_s)) if len(time_s) else 0.0,
        }
        facts |= {
            "seen": seen,
            "dropped": int(np.nansum(self.column("dropped"))),
            "broken_lines": self.broken,
            "said": said,
        }
        for name in ("rate_hz", "latency_ms", "find_ms", "steer_ms", "cpu_percent", "rss_mb"):
            facts[name] = _spread(self.column(name))
        if facts["rate_hz"] and facts["seconds"]:  # a mean of rates would count short gaps too much
            facts["rate_hz"]["mean"] = (facts["pictures"] - 1) / facts["seconds"]
        return facts


def _number(value):
    return float(value) if isinstance(value, int | float) and not isinstance(value, bool) else np.nan


def _spread(values):
    values = values[np.isfinite(values)]
    if not len(values):
        return None
    told = (values.mean(), np.median(values), np.percentile(values, 95), values.max())
    return dict(zip(("mean", "median", "p95", "max"), (float(v) for v in told), strict=True))


def read_log(path: str | Path) -> Run:
    """Read what :class:`RunLog` wrote; a last line that a crash cut off is counted and left out.

    Raises
    ------
    StereoLabError
        If there is no such file, or it is no log of a run.
    """
    lines = read_bytes(path).decode("utf-8", errors="replace").split("\n")
    rows = [record_of(line) for line in lines if line.strip()]
    if not rows:
        raise StereoLabError(f"{path} is empty, and so is no log of a run.")
    head = rows[0]
    if head is None or head.get("kind") != KIND:
        raise StereoLabError(f'{path} is no log of a run: its first line should say "kind": "{KIND}".')
    if head.get("format") != FORMAT:
        raise StereoLabError(
            f"{path} is a log of format {head.get('format')!r}, and this version reads format {FORMAT}. Update the kit."
        )
    records = [row for row in rows[1:] if row is not None]
    return Run(head, records, len(rows) - 1 - len(records))


def record_of(line: str | bytes) -> dict[str, Any] | None:
    """A record as it was written or sent; None where it is none."""
    try:
        row = json.loads(line)
    except (ValueError, RecursionError):
        return None
    return row if isinstance(row, dict) else None


def write_csv(run: Run, path: str | Path) -> None:
    """The records as a table for a spreadsheet, whole or not at all."""
    columns = list(dict.fromkeys(name for record in run.records for name in record))
    text = io.StringIO()
    table = csv.DictWriter(text, columns, lineterminator="\n")
    table.writeheader()
    table.writerows(run.records)
    write_whole(path, text.getvalue())

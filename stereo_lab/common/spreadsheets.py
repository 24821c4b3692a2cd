"""Tables in .csv files, as a text editor or a spreadsheet leaves them."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Sequence
from pathlib import Path

from stereo_lab.common.files import read_text
from stereo_lab.errors import RecordingError, StereoLabError

NUMBER = re.compile(r"\s*[-+−]?\d*[,.]?\d+\s*")  # also with a decimal comma, or a typographic minus


def read_table(path: str | Path, columns: Sequence[str]) -> list[tuple[str, dict[str, str]]]:
    """Rows of a CSV file as ``[(where, {column: text}), …]``.

    A table saved by a spreadsheet with semicolons and decimal commas is read as well.

    Raises
    ------
    RecordingError
        If the file cannot be read, one of the columns is missing, or a line has more fields than there are columns.
    """
    path = Path(path)
    try:
        text = read_text(path)
        rows = _rows(text)
        names = [name.strip().lower() for name in rows.fieldnames or []]
        twice = [name for name in columns if names.count(name) > 1]
        if twice:
            raise RecordingError(f"{path}, line 1: the column {', '.join(twice)} is there more than once. Keep one.")
        missing = [column for column in columns if column not in names]
        if missing:
            raise RecordingError(
                f"{path}, line 1: expected the columns {', '.join(columns)}; missing: {', '.join(missing)}."
            )
        rows.fieldnames = names
        filled = [(f"{path}, line {rows.line_num}", row) for row in rows]
        for where, row in filled:
            if any((text or "").strip() for text in row.get(None) or ()):
                raise RecordingError(
                    f"{where} has {len(names) + len(row[None])} fields, expected {len(names)}. A decimal comma? "
                    "Write 115.5, or put semicolons between the columns."
                )
    except RecordingError:
        raise
    except StereoLabError as error:
        raise RecordingError(str(error), error.fault) from None
    except csv.Error as error:
        raise RecordingError(f"{path} is no table of plain text ({error}). Save it as CSV.") from None
    told = [(where, {name: _pointed(v) for name, v in row.items() if name is not None}) for where, row in filled]
    return [(where, row) for where, row in told if any((v or "").strip() for v in row.values())]


def with_row(path: str | Path, columns: Sequence[str], row: dict[str, str]) -> str:
    """A table's text with one more line, each value under its own column, wherever a spreadsheet has put that.

    Parameters
    ----------
    path : str or Path, of a table that is there or not yet
    columns : sequence of str, those of a new table; one that is there needs them as well
    row : dict, column -> text

    Raises
    ------
    RecordingError
        As :func:`read_table`.
    """
    path, text = Path(path), ",".join(columns) + "\n"
    if path.exists():
        read_table(path, columns)
        text = read_text(path)
    first = text.splitlines()[0]
    names = [name.strip().lower() for name in next(csv.reader([first], delimiter=delimiter_of(first)))]
    line = io.StringIO(newline="")
    csv.writer(line, delimiter=delimiter_of(first), lineterminator="\n").writerow([row.get(name, "") for name in names])
    return text + ("" if text.endswith("\n") else "\n") + line.getvalue()


def _rows(text):
    """A reader of the lines, whichever sign stands between the columns."""
    return csv.DictReader(io.StringIO(text, newline=""), delimiter=delimiter_of(text))


def _pointed(text):
    """A number with a decimal comma as one with a point; any other text as it is."""
    return text.replace(",", ".").replace("−", "-") if text and NUMBER.fullmatch(text) else text


def delimiter_of(text: str) -> str:
    """The sign between the columns of a table, by its first line: a comma, else what a spreadsheet put there."""
    return max(",;\t", key=next(iter(text.splitlines()), "").count)

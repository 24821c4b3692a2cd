"""The class table: a CSV that a spreadsheet opens, and that comes back with a teacher's marks in it."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Sequence
from pathlib import Path

from stereo_lab.classroom.marks import IN_WORDS, Row
from stereo_lab.common.files import read_bytes, write_whole
from stereo_lab.common.spreadsheets import delimiter_of
from stereo_lab.errors import StereoLabError

FIRST = ("learner", "lesson", "passed", "of", "handed in", "file", "notes")
PARTS = ("", " why", " help", " teacher")
Marks = dict[tuple[str, str], dict[int, str]]


def write_table(path: Path, rows: Sequence[Row]) -> None:
    """Write the table, with room for a teacher's mark beside each question; one that is there is parted as before.

    Raises
    ------
    StereoLabError
        If it cannot be written: it is open in a spreadsheet, say.
    """
    most = max((len(row.marks) for row in rows), default=0)
    heads = [f"{k}{part}" for k in range(1, most + 1) for part in PARTS]
    text = io.StringIO()
    parted = delimiter_of(_read(path)) if path.exists() else ","
    table = csv.writer(text, delimiter=parted, lineterminator="\r\n")
    table.writerow([*FIRST, *heads])
    for row in rows:
        first = (row.learner, row.lesson, row.passed, len(row.marks), row.handed_in, row.file, "; ".join(row.notes))
        marks = [cell for m in row.marks for cell in (IN_WORDS[m.status], _with_minus(m.why), m.help, m.teacher)]
        table.writerow([_harmless(cell) for cell in (*first, *marks)])
    try:
        write_whole(path, text.getvalue().encode("utf-8-sig"))
    except StereoLabError as error:
        raise StereoLabError(
            f"{error} If it is open in a spreadsheet, close it there. Then run it again: what is marked is kept."
        ) from None


def read_teacher(path: Path) -> Marks:
    """What a teacher has written into a table that is there already; nothing where there is none.

    Returns
    -------
    dict
        By (learner, lesson), then by the question's number.

    Raises
    ------
    StereoLabError
        If there is a file that is no such table: nothing is then written over it.
    """
    if not path.exists():
        return {}
    text = _read(path)
    try:
        rows = list(csv.reader(io.StringIO(text), delimiter=delimiter_of(text)))
    except csv.Error as error:
        raise StereoLabError(
            f"{path} is no table of plain text ({error}). Save it as CSV, or name another one with --csv."
        ) from None
    heads = [head.strip() for head in rows[0]] if rows else []
    if not {"learner", "lesson"} <= set(heads):
        raise StereoLabError(
            f"Expected a class table in {path}, to keep what a teacher wrote into it; this is another file. Name another one with --csv."
        )
    found: Marks = {}
    for row in (dict(zip(heads, row, strict=False)) for row in rows[1:]):
        marks = {int(head.split()[0]): cell.strip() for head, cell in row.items() if re.fullmatch(r"\d+ teacher", head)}
        learner = _plain(row.get("learner", ""))
        if learner.strip():  # a row without marks tells that there are none any more
            lesson = row.get("lesson", "").strip()  # a spreadsheet makes 3 of 03; of what is no lesson's it is empty
            found[learner, lesson and lesson.zfill(2)] = {k: cell for k, cell in marks.items() if cell}
    return found


def _harmless(cell):
    """A text that a spreadsheet does not take for a formula, nor a part of it where semicolons part the columns."""
    if not isinstance(cell, str) or len(cell) < 2:
        return cell
    return re.sub(r"^(?=[-=+@\t\r])|(?<=[;\t])(?=[-=+@])", "'", cell)


def _with_minus(why):
    """A sentence that begins with a number below zero: with the sign of print it is none that a formula begins with."""
    return re.sub(r"^-(?=\d)", "\N{MINUS SIGN}", why)


def _plain(cell):
    return cell[1:] if cell[:1] == "'" and cell[1:2] in ("=", "+", "-", "@") else cell


def _read(path):
    content = read_bytes(path)
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:
        return content.decode("cp1252", "replace")  # as an older Excel saves it

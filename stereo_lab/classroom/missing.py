"""What somebody deleted from a notebook: cells of the kit's, and checks of answers that are there."""

from __future__ import annotations

import re

from stereo_lab.classroom.papers import Cell

CHECK = re.compile(r"\bq(\d{1,2})\.check\((\w+)\)")


def with_what_is_missing(cells: tuple[Cell, ...], kit: tuple[Cell, ...]) -> tuple[list[str], int, list[int]]:
    """The code of a notebook, and in it the kit's cells and checks that somebody deleted.

    Of a question's cell only the check comes back where the learner's answer stands elsewhere: the blank would take its place.
    A cell of the kit's that was switched to Raw or Markdown is code.

    Parameters
    ----------
    cells, kit : tuple of Cell

    Returns
    -------
    code : list of str
    count : int, how many cells without a question were put back
    checks : list of int, the questions whose check was put back
    """
    kits = {cell.id for cell in kit if cell.code and cell.id}
    code = [(cell.id, cell.source) for cell in cells if cell.code or cell.id in kits]
    lines = [line for _, source in code for line in source.splitlines()]
    stripped = {line.strip() for line in lines}
    count, checks, before = 0, [], 0
    for cell in (c for c in kit if c.code):
        place = next((k for k, (name, _) in enumerate(code) if name == cell.id), None)
        asks = CHECK.search(cell.source)
        lost = asks is not None and not _calls(lines, asks.group(1), "check")
        checks += [int(asks.group(1))] if asks and lost else []
        if place is not None:
            if asks and lost:
                code[place] = (cell.id, _with_check(code[place][1], cell.source[asks.start() :], asks.group(1)))
            before = max(before, place + 1)
        elif lost or (asks is None and not _lies_in(cell, stripped)):
            answered = asks and _is_set(asks.group(2), lines, [c for c in kit if c is not cell])
            code.insert(before, (cell.id, cell.source[asks.start() :] if asks and answered else cell.source))
            count, before = count + (asks is None), before + 1
    return [source for _, source in code], count, checks


def _calls(lines, number, what):
    """Whether a line, and no remark, calls the check or carry of a question."""
    return any(re.match(rf"[^#]*\bq{number}\s*\.\s*{what}\s*\(", line) for line in lines)


def _with_check(source, tail, number):
    """The learner's cell with the check at its end, or before the line that carries the answer on."""
    lines = source.splitlines()
    carries = next((k for k, line in enumerate(lines) if _calls([line], number, "carry")), None)
    if carries is None:
        return f"{source}\n{tail}"
    return "\n".join([*lines[:carries], tail.splitlines()[0], *lines[carries:]])


def _is_set(name, lines, others):
    """Whether a learner's line, and none of the kit's other cells, gives a name something."""
    kits = {line for cell in others for line in cell.source.splitlines()}
    sets = re.compile(rf"\s*(def {name}\b|(\w+\s*,\s*)*{name}(\s*,\s*\w+)*\s*=(?!=))")
    return any(sets.match(line) for line in lines if line not in kits)


def _lies_in(cell, lines):
    """Whether all lines of a cell stand somewhere, as after merging it with another."""
    return all(line.strip() in lines for line in cell.source.splitlines() if line.strip())

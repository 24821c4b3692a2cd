"""The lessons as assignments of nbgrader: a cell to answer in and a cell that gives the point, for each question.

Only files are written; nbgrader itself is not needed for it.
"""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from stereo_lab.common.files import read_json, whole_folder, write_whole
from stereo_lab.errors import StereoLabError
from stereo_lab.exercises import questions
from stereo_lab.exercises.question import Question
from stereo_lab.recording import Recording
from stereo_lab.work import clean

CHECK = re.compile(r"^q(?P<number>\d+)\.check\((?P<answer>.*)\)$", re.MULTILINE)
SCHEMA = 3  # of nbgrader's cell metadata
CONFIG = """c = get_config()
c.CourseDirectory.course_id = "stereo_lab"
c.ClearSolutions.code_stub = {"python": ""}  # the lesson's own stub stands above each solution
c.ExecutePreprocessor.timeout = 240  # seconds for one cell
"""


def export_nbgrader(lessons: Path, out: Path, recording: Recording) -> dict[str, int]:
    """Write the course as nbgrader's course folder: an assignment for each lesson, and nbgrader's settings.

    Parameters
    ----------
    lessons : path, the folder of the kit's own notebooks
    out : path, a folder that is not there yet, or is empty
    recording : Recording that the questions are about

    Returns
    -------
    dict of str to int
        For each assignment its points.

    Raises
    ------
    StereoLabError
        If the folder holds something already or cannot be written, or a lesson cannot be read.
    """
    if out.exists() and (not out.is_dir() or any(out.iterdir())):
        raise StereoLabError(f"Expected a new folder for the course, and {out} holds something. Name another one.")
    made = {}
    for path in sorted(lessons.glob("[0-9][0-9]_*.ipynb")):
        asked = questions(path.stem[:2], recording)
        made[path] = json.dumps(assignment(read_json(path), asked), indent=1, ensure_ascii=False) + "\n"
    with whole_folder(out) as part:
        for path, text in made.items():
            write_whole(part / "source" / path.stem / path.name, text)
        write_whole(part / "nbgrader_config.py", CONFIG)
    return {path.stem: text.count('"grade": true') for path, text in made.items()}


def assignment(notebook: dict[str, Any], asked: Sequence[Question]) -> dict[str, Any]:
    """A lesson as the teacher's version of an assignment.

    Parameters
    ----------
    notebook : dict, as in an .ipynb file
    asked : its questions in order

    Returns
    -------
    dict
        The notebook without outputs. Each cell with a question is three: the stub with the solution under it, the check that gives
        the point, and what carries the answer on.
    """
    cells = [part for cell in clean(notebook)["cells"] for part in _parts(cell, asked)]
    return {**notebook, "cells": cells}


def _parts(cell, asked):
    """The cells that come in the place of one."""
    source = "".join(cell["source"])
    found = CHECK.search(source) if cell["cell_type"] == "code" else None
    if found is None:
        return [cell]
    question, name = asked[int(found["number"]) - 1], cell["id"]
    stub, carried = source[: found.start()].rstrip(), source[found.end() :].strip()
    solution = f"{stub}\n### BEGIN SOLUTION\n{question.code}\n### END SOLUTION"
    test = f"{found.group()}\nq{found['number']}.require({found['answer']})"
    grade_id = f"q{question.lesson}-{question.number}"
    return [
        _cell(cell, name, solution, grade_id + "-answer", solution=True),
        _cell(cell, f"{name}-point", test, grade_id, grade=True, points=1, locked=True),
        _cell(cell, f"{name}-carry", carried, grade_id + "-carry", locked=True),
    ]


def _cell(cell, name, source, grade_id, grade=False, solution=False, locked=False, **points):
    """A code cell with what nbgrader is to know of it."""
    told = {
        "schema_version": SCHEMA, "grade_id": grade_id, "cell_type": "code", "grade": grade, "solution": solution,
        "locked": locked, "task": False, **points,
    }  # fmt: skip
    return {**cell, "id": name, "source": source, "metadata": {**cell["metadata"], "nbgrader": told}}

"""A lesson in several sittings: each begins in a fresh kernel as if the ones before had just been run."""

import copy
import re

import nbformat
import pytest
from nbclient import NotebookClient
from nbformat.v4 import new_code_cell, new_notebook

from conftest import ROOT
from stereo_lab.exercises import catch_up
from tests.test_notebooks import NOTEBOOKS

BEGINS = re.compile(r'catch_up\("(\d\d)", sitting=(\d)\)')
SITTINGS = [
    (path, cell["id"])
    for path in NOTEBOOKS
    for cell in nbformat.read(path, 4).cells
    if cell.cell_type == "code" and BEGINS.search(cell.source)
]


def said(cell):
    """What a code cell printed, as a page shows it: what stood before the carriage return is gone."""
    text = "".join(o.text for o in cell.outputs if o.output_type == "stream")
    return re.sub(r"[^\n]*\r", "", text)


def run(cells, folder, whole=None):
    """Run some cells of a notebook in a kernel of their own; the file has all of them."""
    notebook = new_notebook(cells=copy.deepcopy(cells))
    nbformat.write(new_notebook(cells=whole or cells), folder / "42_lesson.ipynb")
    client = NotebookClient(notebook, timeout=240, kernel_name="python3", resources={"metadata": {"path": str(folder)}})
    client.execute()
    return notebook.cells


@pytest.fixture(autouse=True)
def the_kit(monkeypatch):
    monkeypatch.setenv("PYTHONPATH", str(ROOT))
    monkeypatch.delenv("JPY_SESSION_NAME", raising=False)


LESSON = [
    new_code_cell("import math\nx = 2\nprint('not shown again')"),
    new_code_cell("def area(r):\n    return math.pi * r**x"),
    new_code_cell("from stereo_lab.exercises import catch_up\ncatch_up('42', sitting=2)"),
    new_code_cell("print(f'{area(2):.2f}')"),
]


def test_what_was_made_before_is_made_again(tmp_path):
    cells = run(LESSON[2:], tmp_path, LESSON)
    assert said(cells[0]) == "Sitting 2: all that comes before is there again, 2 cells were run. Go on.\n"
    assert said(cells[1]) == "12.57\n"


def test_whoever_goes_on_waits_for_nothing(tmp_path):
    cells = run(LESSON, tmp_path)
    assert said(cells[2]) == "Sitting 2: all that comes before is there. Go on.\n" and said(cells[3]) == "12.57\n"


def test_a_part_alone_is_not_enough(tmp_path):
    """Whoever ran the first cell again and went straight to the second sitting."""
    cells = run([LESSON[0], *LESSON[2:]], tmp_path, LESSON)
    assert "2 cells were run" in said(cells[1]) and said(cells[2]) == "12.57\n"


def test_a_cell_that_stops_is_named(tmp_path):
    broken = [LESSON[0], new_code_cell("y = x + nothing"), *LESSON[2:3]]
    (cell,) = run(broken[2:], tmp_path, broken)
    assert said(cell) == "Sitting 2: cell 2 of 2 stops with NameError: go to it and run it by hand.\n"
    half = [LESSON[0], new_code_cell("y = (x +"), *LESSON[2:3]]
    (cell,) = run(half[2:], tmp_path, half)
    assert "cell 2 of 2 stops with SyntaxError" in said(cell)


def test_a_real_arm_is_not_moved(tmp_path):
    moving = [new_code_cell("arm_url = 'COM3'\nx = 1"), new_code_cell("y = 2  # this moves the arm"), LESSON[2]]
    (cell,) = run(moving[2:], tmp_path, moving)
    assert "cell 2 of 2 moves your arm, so it waits for you" in said(cell)
    moving[0] = new_code_cell("arm_url = 'virtual://arm'\nx = 1")
    (cell,) = run(moving[2:], tmp_path, moving)
    assert "2 cells were run" in said(cell)


def test_an_arm_that_is_closed_or_connected_anew_is_homed_again(tmp_path):
    make = "from stereo_lab.arm import connect\narm = connect()"
    begins, ask = LESSON[2].source, "print(arm.homed)"
    sources = [make, "_ = arm.home()  # this moves the arm", begins, "arm.close()", begins, ask, make, begins, ask]
    cells = run([new_code_cell(source) for source in sources], tmp_path)
    assert said(cells[2]) == "Sitting 2: all that comes before is there. Go on.\n"
    for again, asked in ((4, 5), (7, 8)):
        assert "2 cells were run" in said(cells[again]) and said(cells[asked]) == "True\n"


def test_a_cell_that_is_not_saved_and_a_lesson_that_is_not_there(tmp_path):
    (cell,) = run(LESSON[2:3], tmp_path, LESSON[:2])
    assert "No cell of 42_lesson.ipynb as it was last saved begins sitting 2. Save it" in said(cell)
    (cell,) = run([new_code_cell("from stereo_lab.exercises import catch_up\ncatch_up('43', sitting=2)")], tmp_path)
    assert "notebook of lesson 43 is not in" in said(cell)


def test_a_cell_that_leaves_no_history(tmp_path):
    """As nbval runs them, and an editor that runs a cell without keeping it: the cell is found by what it calls."""
    silent = f"get_ipython().run_cell({LESSON[2].source!r}, store_history=False); print(f'{{area(2):.2f}}')"
    (cell,) = run([new_code_cell(silent)], tmp_path, LESSON)
    assert "2 cells were run" in said(cell) and said(cell).endswith("12.57\n")


def test_outside_a_notebook(capsys):
    catch_up("04", sitting=2)
    assert "for a cell of a notebook" in capsys.readouterr().out


def test_the_long_lessons_have_sittings():
    """Nothing takes over 45 minutes: what a sitting says, and what is left of the lesson's minutes for the first one."""
    assert len(SITTINGS) >= 9
    for path in NOTEBOOKS:
        text = "".join(cell.source for cell in nbformat.read(path, 4).cells)
        whole = int(re.search(r"\*\*Time:\*\* (\d+) minutes", text).group(1))
        later = [int(minutes) for minutes in re.findall(r"This sitting takes about (\d+) minutes", text)]
        assert max([whole - sum(later), *later]) <= 45, path.name
        numbers = [int(number) for _, number in BEGINS.findall(text)]
        assert numbers == list(range(2, len(later) + 2))


@pytest.mark.slow
@pytest.mark.parametrize(("path", "begins"), SITTINGS, ids=[f"{path.stem[:2]}-{begins}" for path, begins in SITTINGS])
def test_a_sitting_begins_in_a_fresh_kernel(path, begins, monkeypatch, tmp_path):
    """It prints what the lesson printed when it was run from top to bottom, but for what a clock measured."""
    monkeypatch.setenv("STEREO_LAB_WORK", str(tmp_path))
    notebook = nbformat.read(path, 4)
    first = next(k for k, cell in enumerate(notebook.cells) if cell.id == begins)
    part = copy.deepcopy(notebook)
    part.cells = part.cells[first:]
    NotebookClient(
        part, timeout=240, kernel_name="python3", resources={"metadata": {"path": str(path.parent)}}
    ).execute()
    assert "cells were run. Go on." in said(part.cells[0])
    for cell, stored in zip(part.cells[1:], notebook.cells[first + 1 :], strict=True):
        if cell.cell_type == "code" and not cell.metadata.get("stereo_lab"):
            assert numberless(said(cell)) == numberless(said(stored)), cell.source


def numberless(text):
    """Its words; a sitting that begins after a catch-up says the same of catching up."""
    return re.sub(r"Sitting \d.*|[-+]?\d[\d.,]*", "#", text).split()

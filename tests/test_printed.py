"""Outputs of notebooks are compared as numbers, and nothing else gets away."""

import json
import re
import subprocess
import sys

import nbformat
import pytest

from conftest import ROOT
from tests.printed import Printed, differences

SAME = [
    ("off by 17.4 mm", "off by 17.5 mm"),  # the last place
    ("at 1003 mm, 8 px", "at 1004 mm, 9 px"),  # a unit: measured, not counted
    ("  9.9 mm  0.5", " 10.0 mm  0.5"),  # the padding of a column
    ("sigma 1.00e-05 px", "sigma 1.01e-05 px"),
    ("m 86884 mm px", "m 86900 mm px"),  # two thousandths of a large number
    ("θ1 −0.0°", "θ1 0.0°"),
]
OTHER = [
    ("off by 17.4 mm", "off by 17.6 mm"),  # more than its room
    ("16 of 16 balls", "15 of 16 balls"),  # a count
    ("off by 17.4 mm", "off by 17.4 cm"),
    ("x 0.5 mm, y 0.3 mm", "y 0.5 mm, x 0.3 mm"),  # swapped labels
    ("off by 17.4 mm", "off by nan mm"),
    ("off by 17.4 mm", "off by mm"),
    ("off by 17.4 mm\nand more", "off by 17.4 mm"),  # a missing line
    ("a\nb 1.0", "b 1.0\na"),
    ("640x480", "640x481"),  # a name
    ("lesson 04", "lesson 05"),
    ("-1.4 mm", "1.4 mm"),
    ("1e-05 px", "1e-04 px"),
    ("without 015: 0.9 px", "without 016: 0.9 px"),
    ("100.0 %", "99.6 %"),
]


@pytest.mark.parametrize(("one", "other"), SAME)
def test_numbers_have_the_room_of_their_last_place(one, other):
    assert [Printed(one)] == [Printed(other)]
    assert not differences(other, one)


@pytest.mark.parametrize(("one", "other"), OTHER)
def test_everything_else_is_noticed(one, other):
    assert [Printed(one)] != [Printed(other)]
    assert differences(other, one)


def test_a_cell_may_ask_for_room():
    wide = Printed("Eq. 4 gives 17.4 mm for 16 balls")
    wide.room = {"absolute": 0.5, "relative": 0.0}
    assert wide == "Eq. 4 gives 17.9 mm for 16 balls" and wide != "Eq. 4 gives 18.0 mm for 16 balls"
    assert wide != "Eq. 4 gives 17.4 mm for 15 balls"
    wide.room = {"whole": 1}
    assert wide == "Eq. 4 gives 17.4 mm for 15 balls" and wide != "Eq. 4 gives 17.4 mm for 14 balls"


PRINTS = "depth 17.4 mm of 16"
WIDE = {"stereo_lab": {"tolerance": {"absolute": 0.5, "why": "a test"}}}
STORED = [  # what a notebook has stored of PRINTS, the metadata of its cell, and whether it passes
    ("depth 17.4 mm of 16\n", {}, True),
    ("depth 17.5 mm of 16\n", {}, True),
    ("depth 17.9 mm of 16\n", {}, False),
    ("depth 17.9 mm of 16\n", WIDE, True),
    ("depth 17.4 mm of 17\n", {}, False),
    ("height 17.4 mm of 16\n", {}, False),
    ("depth nan mm of 16\n", WIDE, False),
    ("depth 17.4 mm of 16\nand a line\n", {}, False),
]


def test_plain_nbval_compares_so(tmp_path):
    """As a reader would start it, pytest --nbval, with the conftest of this folder."""
    cells = []
    for k, (text, metadata, _) in enumerate(STORED):
        cells.append(nbformat.v4.new_code_cell(f"print({PRINTS!r})", execution_count=k + 1, metadata=metadata))
        cells[-1].outputs = [nbformat.v4.new_output("stream", name="stdout", text=text)]
    kernel = {"kernelspec": {"name": "python3", "display_name": "Python 3"}}
    nbformat.write(nbformat.v4.new_notebook(cells=cells, metadata=kernel), tmp_path / "one.ipynb")
    command = [
        sys.executable,
        "-m",
        "pytest",
        "-v",
        "--nbval",
        "-c",
        "pyproject.toml",
        "-p",
        "conftest",
        tmp_path / "one.ipynb",
    ]
    done = subprocess.run(list(map(str, command)), cwd=ROOT, capture_output=True, text=True)
    told = re.findall(r"Cell (\d+) (PASSED|FAILED)", done.stdout)
    assert [word == "PASSED" for _, word in told] == [passes for *_, passes in STORED], done.stdout


def test_every_wider_room_says_why():
    for path in sorted((ROOT / "notebooks").glob("*.ipynb")):
        for cell in json.loads(path.read_text(encoding="utf-8"))["cells"]:
            room = cell["metadata"].get("stereo_lab", {}).get("tolerance")
            assert room is None or (room["why"] and set(room) <= {"absolute", "relative", "whole", "why"}), path.name

"""Two thousand answers, typed into the notebooks' own cells: right ones pass, wrong ones do not, and each is told more than that."""

import json
import linecache
import re
from itertools import count

import pytest

from conftest import ROOT

NEEDED = {  # by lesson: the cells above that make the names in these answers, and what a learner imports beside
    "00": (["cell-02", "cell-05", "cell-08", "cell-14", "cell-16"], "import math"),
    "01": (["cell-01", "cell-05", "cell-09", "cell-26"], ""),
    "02": (["cell-01", "cell-03", "cell-09"], ""),
    "03": (["cell-01", "cell-03", "cell-07", "cell-12"], ""),
    "04": (["cell-01", "cell-03", "cell-09"], ""),
    "05": (["cell-01"], "from math import tan, exp"),
    "06": (["cell-01"], "from math import exp, radians"),
    "07": (
        ["cell-01", "mine-05"],
        "order_ms = 2.8; stages = {'cameras': 66.7, 'finding the ball': 1.0, 'angles': 0.005, 'order': order_ms}",
    ),
    "08": (
        ["cell-02", "cell-18"],
        "angles = [0, *11 * [0.01], 0.5893, 0.5051, 0.5036, 0.501, 0.5013, 0.5127, 0.4986, 0.5513]",
    ),
    "09": (["cell-01"], ""),
}
VAGUE = re.compile(  # what is said where no name was found
    r"look at \w+: twice as large|in every try|not among the answers|is too (small|large)\.$|the one farthest off"
    r"|it says (True|False), and|could not be looked at|stopped with \w+: [^.]*\.$"
)
numbers = count()


def typed_answers():
    """By question, as in "04.3": pairs of R or W and the text."""
    found = {}
    for line in (ROOT / "tests" / "typed_answers.txt").read_text(encoding="utf-8").splitlines():
        if line.startswith("@"):
            found[line[1:]] = here = []
        elif not line.startswith("#"):
            here.append((line[0], line[2:]))
    return found


def filled_in(cell, text):
    """The cell with an answer in the place of its blank."""
    lines = cell.splitlines()
    k = next(k for k, line in enumerate(lines) if re.search(r"(return|=) ____", line))
    if text.startswith("\\n"):
        lines[k : k + 1] = ["    " + line for line in text[2:].replace("\\n", "\n").splitlines()]
    else:
        lines[k] = lines[k].partition("____")[0] + text
    return "\n".join(lines)


def run(source, names):
    """Run a cell as a notebook does: its lines can be read again."""
    name = f"<typed {next(numbers)}>"
    linecache.cache[name] = (len(source), None, source.splitlines(keepends=True), name)
    exec(compile(source, name, "exec"), names)


@pytest.mark.slow
@pytest.mark.parametrize("lesson", NEEDED)
def test_typed_answers(lesson, capsys, monkeypatch, tmp_path):
    monkeypatch.setenv("STEREO_LAB_WORK", str(tmp_path))
    (notebook,) = (ROOT / "notebooks").glob(f"{lesson}_*.ipynb")
    read = json.loads(notebook.read_text(encoding="utf-8"))["cells"]
    cells, ids = ["".join(cell["source"]) for cell in read], [cell["id"] for cell in read]
    asking = [k for k, cell in enumerate(cells) if ".check(" in cell and "____" in cell and "q1.hint" not in cell]
    above, imported = NEEDED[lesson]
    names = {"__name__": "__main__"}
    for k in sorted({*map(ids.index, above), *asking}):
        run(cells[k].partition("ours_ms")[0], names)
        if ids[k] == above[0]:
            run(f"import numpy as np\n{imported}", names)
    answers, wrong = typed_answers(), []
    assert len(asking) == sum(question.startswith(lesson) for question in answers)
    for number, k in enumerate(asking, 1):
        for kind, text in answers[f"{lesson}.{number}"]:
            capsys.readouterr()
            run(filled_in(cells[k].partition("ours_ms")[0], text), dict(names))
            said = next(line for line in capsys.readouterr().out.splitlines() if line.startswith(("PASS", "NOT")))
            if (kind == "R") != said.startswith("PASS") or kind == "W" and VAGUE.search(said):
                wrong.append((f"{lesson}.{number}", kind, text, said))
    assert not wrong, "\n".join(map(str, wrong))

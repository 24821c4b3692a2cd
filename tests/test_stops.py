"""What is said below an error that stops a learner's cell: in a shell as a notebook has it."""

import pytest
from IPython.core.interactiveshell import InteractiveShell

from stereo_lab.exercises import questions, stops


@pytest.fixture
def run(bench, monkeypatch, capsys):
    shell = InteractiveShell.instance()
    shell.user_ns.update(bench=bench, questions=questions, pixel=(1, 2, 3))
    shell.run_cell("q1, *_ = questions('00', bench)")
    yield lambda cell: (shell.run_cell(cell), capsys.readouterr().out)
    shell.set_custom_exc((), None)
    InteractiveShell.clear_instance()


@pytest.mark.parametrize(
    "cell, said",
    [
        ("pixel[3]", "Python counts from 0"),
        ("pixel(2)", "square brackets"),
        ("pixel['red']", "a whole number"),
        ("doubles", "Python knows no doubles here"),
        ("pi", "from math import pi"),
        (
            "math.pi",
            "yet. Run the cells above this one first. Where none of them imports it, write import math in a cell above",
        ),
        ("1 / 0", "below a line is zero"),
        ("import numpy as np; np.zeros(3).norm()", "an array has .shape"),
        ("from stereo_lab.recording import Position; Position(1, 2, 3).x_mm = 0", "a name of its own"),
    ],
)
def test_the_meaning_stands_below_pythons_own_words(run, cell, said):
    done, printed = run(cell)
    assert type(done.error_in_exec).__name__ in printed  # the traceback is still there
    assert said in printed.splitlines()[-1] and printed.splitlines()[-1].startswith("That means: ")


def test_nothing_is_added_to_the_kits_own_sentences(run):
    done, printed = run("""bench.arm.forward(("'tuple'", 20))""")
    assert "Expected JointAngles(theta1_deg, theta2_deg), got (" in printed and "That means" not in printed


def test_nothing_is_added_where_nothing_is_known(run):
    done, printed = run("raise RuntimeError('of another kind')")
    assert done.error_in_exec and "That means" not in printed
    assert run("x = 1")[1] == ""


def test_outside_a_notebook_nothing_is_done():
    stops.explain_stops()

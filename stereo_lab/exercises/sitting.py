"""A lesson in several sittings: what the sittings before have made is made again, quietly."""

from __future__ import annotations

import ast
import os
import re
from pathlib import Path
from typing import Any

from stereo_lab.common.files import read_json
from stereo_lab.errors import StereoLabError
from stereo_lab.exercises.language import translated

MOVES = "this moves the arm"  # what stands in every cell of which an arm moves


def catch_up(lesson: str, sitting: int) -> None:
    """Run the code cells above this one again, where that has not been done yet; their outputs are not shown.

    So it is where they home an arm that is closed by now, or was connected anew.

    Answers are part of their cells, so they count as they stand in the notebook as it was last saved. A real arm is not moved: then
    a sentence says to run those cells one by one. But where its port is opened again, its motors let go.

    Parameters
    ----------
    lesson : str, such as "04"
    sitting : int, the one that begins here
    """
    from IPython.core.getipython import get_ipython

    shell = get_ipython()
    if shell is None:
        print("catch_up is for a cell of a notebook. Open the lesson with: stereo-lab start")
        return
    try:
        cells = _cells_above(_notebook(lesson), lesson, sitting)
    except StereoLabError as error:
        print(error)
        return
    if set().union(*map(_made_by, cells)) <= set(shell.user_ns) and not _arm_is_lost(shell.user_ns, cells):
        print(translated(f"Sitting {sitting}: all that comes before is there. Go on."))
        return
    print("\r" + translated(f"Sitting {sitting}: {_run_again(shell, cells)}"))


def _arm_is_lost(names: dict[str, Any], cells: list[str]) -> bool:
    """Whether the cells home an arm, and the one that is there is not: its port was closed, or opened anew."""
    if not any("arm.home()" in cell for cell in cells):
        return False
    try:
        return not names["arm"].homed
    except (StereoLabError, KeyError, AttributeError):  # closed, gone, or something else by that name
        return True


def _run_again(shell: Any, cells: list[str]) -> str:
    """Run cells without showing what they print or draw; gives a sentence on how it went."""
    from IPython.utils.capture import capture_output

    for number, cell in enumerate(cells, 1):
        if MOVES in cell and not str(shell.user_ns.get("arm_url", "virtual")).startswith("virtual"):
            return f"cell {number} of {len(cells)} moves your arm, so it waits for you. Run the cells from there one by one."
        print(f"\rrunning again: cell {number} of {len(cells)}", end="", flush=True)
        with capture_output():
            done = shell.run_cell(cell, store_history=False)
        if not done.success:
            return f"cell {number} of {len(cells)} stops with {type(done.error_in_exec or done.error_before_exec).__name__}: go to it and run it by hand."
    return f"all that comes before is there again, {len(cells)} cells were run. Go on."


def _notebook(lesson: str) -> Path:
    """The file of the notebook in which this runs."""
    named = os.environ.get("JPY_SESSION_NAME", "")  # JupyterLab says so, whatever the learner has called it
    if named.endswith(".ipynb") and Path(named).is_file():
        return Path(named)
    found = sorted(Path.cwd().glob(f"{lesson}_*.ipynb"))
    if not found:
        raise StereoLabError(
            f"The notebook of lesson {lesson} is not in {Path.cwd()}. Open the lesson with: stereo-lab start"
        )
    return found[0]


def _cells_above(path: Path, lesson: str, sitting: int) -> list[str]:
    """The code cells above the one in which this sitting begins, as the file has them."""
    code = ["".join(cell["source"]) for cell in read_json(path)["cells"] if cell["cell_type"] == "code"]
    begins = re.compile(rf"""catch_up\(\s*["']{lesson}["'],\s*(sitting\s*=\s*)?{sitting}\s*\)""")
    here = next((k for k, source in enumerate(code) if begins.search(source)), None)
    if here is None:
        raise StereoLabError(
            f"No cell of {path.name} as it was last saved begins sitting {sitting}. Save it, then run this cell again."
        )
    return [source for source in code[:here] if "catch_up(" not in source]


def _made_by(cell: str) -> set[str]:
    """The names that a cell gives to something, whatever happens in it."""
    made: set[str] = set()
    try:
        body = ast.parse(cell).body
    except SyntaxError:  # a line that is half written, or one of the notebook's own, such as %time
        return made
    for node in body:
        if isinstance(node, (ast.FunctionDef, ast.ClassDef)):
            made.add(node.name)
        elif isinstance(node, (ast.Import, ast.ImportFrom)):
            made |= {alias.asname or alias.name.partition(".")[0] for alias in node.names}
        elif isinstance(node, ast.Assign):
            made |= {name.id for target in node.targets for name in ast.walk(target) if isinstance(name, ast.Name)}
    return made

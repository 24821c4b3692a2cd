"""The shape of the kit: what imports what, and what importing does."""

import ast
import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

from conftest import ROOT

PACKAGE = ROOT / "stereo_lab"
LESSONS = {"calibration", "detection", "position", "depth", "kinematics", "motion"}


def imports(path):
    """Names of all modules that a file imports, anywhere in it."""
    names = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            names |= {node.module, *(f"{node.module}.{alias.name}" for alias in node.names)}
    return names


def test_import_is_light():
    code = "import stereo_lab, sys, json; print(json.dumps(sorted(sys.modules)))"
    loaded = set(json.loads(subprocess.run([sys.executable, "-c", code], capture_output=True, text=True).stdout))
    assert not loaded & {"cv2", "numpy", "matplotlib", "serial", "ipywidgets", "mitsuba"}


@pytest.mark.parametrize("lesson", sorted(LESSONS))
def test_lessons_do_not_import_each_other(lesson):
    room = PACKAGE / lesson
    files = room.rglob("*.py") if room.is_dir() else [room.with_suffix(".py")]
    used = {name.split(".")[1] for path in files for name in imports(path) if name.startswith("stereo_lab.")}
    assert not used & (LESSONS - {lesson})


@pytest.mark.parametrize("path", sorted(PACKAGE.rglob("*.py")), ids=lambda p: p.name)
def test_heavy_packages_stay_where_they_belong(path):
    used = {name.split(".")[0] for name in imports(path)}
    allowed = {"matplotlib": {"plots", "widgets"}, "ipywidgets": {"widgets"}, "mitsuba": set()}
    for package, homes in allowed.items():
        assert package not in used or homes & {path.stem, path.parent.name}


def public(node):
    """Classes, functions and methods in a tree whose names have no underscore in front; none inside functions."""
    for child in node.body:
        if isinstance(child, (ast.ClassDef, ast.FunctionDef)) and not child.name.startswith("_"):
            yield child
            if isinstance(child, ast.ClassDef):
                yield from public(child)


def is_annotated(function):
    """Whether every parameter but self and cls has a type, and what is returned as well."""
    a = function.args
    parameters = [*a.posonlyargs, *a.args, *a.kwonlyargs, *filter(None, (a.vararg, a.kwarg))]
    return function.returns is not None and all(p.annotation for p in parameters if p.arg not in ("self", "cls"))


def fields(node):
    """Names of the public fields that a class declares, each with whether its docstring names it."""
    names = [n.target.id for n in node.body if isinstance(n, ast.AnnAssign) and not n.target.id.startswith("_")]
    return [(name, bool(re.search(rf"\b{name}\b", ast.get_docstring(node) or ""))) for name in names]


def test_what_is_public_is_documented_and_typed():
    documented, typed = {}, {}
    for path in sorted(PACKAGE.rglob("*.py")):
        for node in public(ast.parse(path.read_text(encoding="utf-8"))):
            name = f"{path.relative_to(PACKAGE)}:{node.lineno} {node.name}"
            documented[name] = ast.get_docstring(node) is not None
            if isinstance(node, ast.FunctionDef):
                typed[name] = is_annotated(node)
            else:
                documented |= {f"{name}.{field}": told for field, told in fields(node)}
    assert len(documented) > 500 and len(typed) > 300  # the count itself finds them
    for what, told in (("documented", documented), ("typed", typed)):
        share = sum(told.values()) / len(told)
        assert share >= 0.99, f"{share:.1%} is {what}; not: {[name for name, there in told.items() if not there]}"


def test_no_file_is_left_half_written():
    assert not list(Path(ROOT / "data").rglob("*.part"))

"""The shape of the kit: what imports what, and what importing does."""

import ast
import json
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


def test_no_file_is_left_half_written():
    assert not list(Path(ROOT / "data").rglob("*.part"))

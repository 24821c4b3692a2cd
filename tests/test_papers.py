"""What people who carry the project on expect to find, and that it says the truth."""

import json
import re

import pytest

import stereo_lab
from conftest import ROOT


@pytest.mark.parametrize("name", ["README.md", "CONTRIBUTING.md", "CHANGELOG.md", "data/README.md"])
def test_every_link_and_path_leads_somewhere(name):
    page = ROOT / name
    text = page.read_text(encoding="utf-8")
    for link in re.findall(r"\]\(([^)#]+)\)", text):
        assert link.startswith("http") or (page.parent / link).exists(), link
    for path in re.findall(r"`((?:tests|stereo_lab|notebooks|data)/[\w/.]+)`", text):
        assert "NAME" in path or (ROOT / path).exists(), path


def test_version_is_told_once_and_the_same():
    version = stereo_lab.__version__
    assert f"version: {version}\n" in (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    newest = re.search(r"^## ([\d.]+)", (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"), re.MULTILINE)
    assert newest[1] == version


def test_the_workflow_runs_the_readmes_command():
    steps = (ROOT / ".github" / "workflows" / "tests.yml").read_text(encoding="utf-8")
    assert "run: python lab.py test\n" in steps
    for word in ("ubuntu", "macos", "windows", '"3.10"', '"3.14"'):
        assert word in steps


def test_pre_commit_runs_the_same_ruff():
    hooks = (ROOT / ".pre-commit-config.yaml").read_text(encoding="utf-8")
    assert "entry: ruff check --fix" in hooks and "entry: ruff format" in hooks and "language: system" in hooks


def test_every_package_is_in_the_wheel():
    """A folder with Python files is a package; pyproject finds packages by rule."""
    folders = {p.parent for p in (ROOT / "stereo_lab").rglob("*.py")}
    assert all((folder / "__init__.py").is_file() for folder in folders)
    assert "[tool.setuptools.packages.find]" in (ROOT / "pyproject.toml").read_text(encoding="utf-8")


def test_every_file_that_is_no_code_is_in_the_wheel():
    """Without its weights the detector cannot be imported, and without py.typed no type checker reads the hints (PEP 561)."""
    text = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    patterns = json.loads(re.search(r"package-data\]\nstereo_lab = (\[.*\])", text)[1])
    package = ROOT / "stereo_lab"
    shipped = {path for pattern in patterns for path in package.glob(pattern)}
    others = {path for path in package.rglob("*") if path.is_file() and path.suffix not in (".py", ".pyc")}
    assert package / "py.typed" in others and others <= shipped

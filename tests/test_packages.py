"""How one more package comes to this very Python."""

import shutil
import sys

import pytest

from stereo_lab.common import packages
from stereo_lab.errors import StereoLabError


def test_by_the_pip_of_this_environment(monkeypatch):
    monkeypatch.setattr(packages.importlib.util, "find_spec", lambda _: True)
    assert packages.to_install("paho-mqtt>=2.1") == f'{sys.executable} -m pip install "paho-mqtt>=2.1"'


def test_where_an_environment_has_no_pip_that_of_its_python_serves(monkeypatch, tmp_path):
    monkeypatch.setattr(packages.importlib.util, "find_spec", lambda _: None)
    monkeypatch.setattr(sys, "_base_executable", shutil.which("true"), raising=False)
    monkeypatch.setattr(sys, "executable", str(tmp_path / "my lab" / "python"))
    told = packages.to_install("mitsuba==3.9.1")
    assert told == f'{shutil.which("true")} -m pip --python "{sys.executable}" install mitsuba==3.9.1'


def test_without_a_pip(monkeypatch):
    monkeypatch.setattr(packages.importlib.util, "find_spec", lambda _: None)
    monkeypatch.setattr(sys, "_base_executable", shutil.which("false"), raising=False)
    with pytest.raises(StereoLabError, match="pip is missing"):
        packages.find_pip()
    assert packages.to_install("mitsuba==3.9.1").startswith("mitsuba==3.9.1. But pip is missing. Get it with")

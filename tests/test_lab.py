"""lab.py: what it says when it cannot go on. Nothing is installed here."""

import importlib.util
import json
import subprocess
import sys
from collections import namedtuple

import pytest

from conftest import ROOT


@pytest.fixture
def lab(tmp_path, monkeypatch):
    spec = importlib.util.spec_from_file_location("lab", ROOT / "lab.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    monkeypatch.setattr(module, "VENV", str(tmp_path / ".venv"))
    monkeypatch.setattr(module, "STAMP", str(tmp_path / ".venv" / "stamp"))
    monkeypatch.setattr(module, "PYTHON", sys.executable)
    monkeypatch.setattr(module, "EXTRAS", "")
    return module


def test_old_python(lab, monkeypatch, capsys):
    monkeypatch.setattr(lab.sys, "version_info", (3, 8, 1))
    assert lab.main(["test"]) == 2
    said = capsys.readouterr().err
    assert "3.10 or newer" in said and "3.8" in said


def test_full_disk(lab, monkeypatch, capsys):
    usage = namedtuple("usage", "total used free")
    monkeypatch.setattr(lab.shutil, "disk_usage", lambda _: usage(10**9, 10**9, 5 * 2**20))
    assert lab.main(["test"]) == 2
    assert "5 MB left" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("output", "says"),
    [
        ("OSError: [Errno 28] No space left on device", "disk is full"),
        ("ConnectionError: Temporary failure in name resolution", "online"),
        ("ERROR: No matching distribution found for numpy==2.2", "online"),
        ("error: something else", "a step failed"),
    ],
)
def test_a_failed_step_is_one_sentence(lab, output, says):
    command = [sys.executable, "-c", f"import sys; print({output!r}); sys.exit(1)"]
    with pytest.raises(lab.SetupError, match=says):
        lab.step(command, "install the packages")


def test_up_to_date_is_not_touched(lab, tmp_path, monkeypatch):
    assert not lab.up_to_date()
    (tmp_path / ".venv").mkdir()
    (tmp_path / ".venv" / "stamp").write_text(lab.wanted())
    assert lab.up_to_date()
    monkeypatch.setattr(lab, "EXTRAS", "browser")
    assert not lab.up_to_date()


def test_it_is_plain_enough_for_an_old_python_to_say_so():
    """Python 3.6 must be able to read the file, or its reader sees a SyntaxError instead of a sentence."""
    import ast

    ast.parse((ROOT / "lab.py").read_text(encoding="utf-8"), feature_version=(3, 6))


def test_stop_is_quiet(lab, monkeypatch, capsys):
    monkeypatch.setattr(lab, "make_environment", lambda *_: (k for k in ()).throw(KeyboardInterrupt))
    assert lab.main(["test"]) == 130
    assert "Stopped" in capsys.readouterr().err


def test_commands_are_passed_on(lab, tmp_path, monkeypatch):
    (tmp_path / ".venv").mkdir()
    (tmp_path / ".venv" / "stamp").write_text(lab.wanted())
    done = subprocess.run([sys.executable, "-m", "stereo_lab", "--help"], capture_output=True, cwd=ROOT)
    assert lab.main(["--help"]) == done.returncode == 0


def test_nobody_is_asked_about_news(lab, tmp_path):
    lab.quiet()
    (written,) = (tmp_path / ".venv").rglob("overrides.json")
    (answers,) = json.loads(written.read_text()).values()
    assert answers == {"fetchNews": "false", "checkForUpdates": False}


def test_ctrl_c_waits_for_what_runs(lab, monkeypatch):
    """The command got the same Ctrl-C: it puts the arm to rest, or asks whether it is meant, and that takes a moment."""
    waits = iter([KeyboardInterrupt, KeyboardInterrupt, 130])

    def wait():
        if (answer := next(waits)) == 130:
            return answer
        raise answer

    child = namedtuple("child", "wait")(wait)
    monkeypatch.setattr(lab.subprocess, "Popen", lambda *_, **__: child)
    assert lab.run(["run"]) == 130 and next(waits, None) is None


def test_without_a_command_the_course_opens(lab, monkeypatch):
    started = []
    monkeypatch.setattr(
        lab.subprocess, "Popen", lambda command, **_: started.append(command) or namedtuple("c", "wait")(lambda: 0)
    )
    assert lab.run([]) == 0 and started[0][1:] == ["-m", "stereo_lab", "start"]
    assert lab.run(["--name", "ada"]) == 0 and started[1][3:] == ["start", "--name", "ada"]

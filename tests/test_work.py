"""The learner's own folder: clean copies, nothing written over, one for each learner."""

import json
import os
import shutil
import signal
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

from conftest import ROOT
from stereo_lab.cli import course, main
from stereo_lab.errors import StereoLabError
from stereo_lab.exercises import progress
from stereo_lab.work import MARK, find, lay_out, own_folder, reset

LESSONS = ROOT / "notebooks"
NAMES = sorted(path.name for path in LESSONS.glob("*.ipynb"))


@pytest.fixture
def kit(tmp_path):
    """Two lessons of a kit that may be changed."""
    lessons = tmp_path / "kit"
    lessons.mkdir()
    for name in NAMES[:2]:
        (lessons / name).write_bytes((LESSONS / name).read_bytes())
    (lessons / "words.md").write_text("# Words\n")
    return lessons


def renew(kit):
    """A newer kit has a newer lesson 00."""
    path = kit / NAMES[0]
    path.write_text(path.read_text(encoding="utf-8").replace("# 00 Start here", "# 00 Start over"), encoding="utf-8")


def learn(path):
    """What happens to a notebook that somebody works in."""
    path.write_text(path.read_text(encoding="utf-8").replace("____  ", '"right"  '), encoding="utf-8")


def test_the_copies_are_the_lessons_without_their_outputs(tmp_path):
    made, older = lay_out(LESSONS, tmp_path / "work")
    assert made == [*NAMES, "words.md"] and older == []
    for name in NAMES:
        copy, source = (
            json.loads((folder / name).read_text(encoding="utf-8")) for folder in (tmp_path / "work", LESSONS)
        )
        assert [c["source"] for c in copy["cells"]] == [c["source"] for c in source["cells"]]
        assert {k: v for k, v in copy.items() if k != "cells"} == {k: v for k, v in source.items() if k != "cells"}
        for cell in copy["cells"]:
            assert not cell.get("outputs") and cell.get("execution_count") is None
    assert not list((tmp_path / "work").rglob("*instructor*"))


def test_a_second_time_nothing_is_touched(tmp_path):
    lay_out(LESSONS, tmp_path)
    before = {path.name: path.stat().st_mtime_ns for path in tmp_path.glob("*.ipynb")}
    assert lay_out(LESSONS, tmp_path) == ([], [])
    assert {path.name: path.stat().st_mtime_ns for path in tmp_path.glob("*.ipynb")} == before


def test_a_newer_kit_writes_over_nothing_that_was_changed(kit, tmp_path):
    work = tmp_path / "work"
    lay_out(kit, work)
    learn(work / NAMES[0])
    learned = (work / NAMES[0]).read_text(encoding="utf-8")
    renew(kit)
    assert lay_out(kit, work) == ([], [NAMES[0]])
    assert (work / NAMES[0]).read_text(encoding="utf-8") == learned


def test_a_newer_kit_renews_what_nobody_has_changed(kit, tmp_path):
    lay_out(kit, tmp_path / "work")
    renew(kit)
    assert lay_out(kit, tmp_path / "work") == ([NAMES[0]], [])
    assert "# 00 Start over" in (tmp_path / "work" / NAMES[0]).read_text(encoding="utf-8")


@pytest.mark.parametrize("mark", ["", "[1]", '{"copies": [1]}', '{"copies": {"00_start_here.ipynb": 5}}'])
def test_a_lost_mark_costs_no_work(kit, tmp_path, mark):
    work = tmp_path / "work"
    lay_out(kit, work)
    learn(work / NAMES[0])
    learned = (work / NAMES[0]).read_text(encoding="utf-8")
    (work / MARK).write_text(mark)
    _, older = lay_out(kit, work)
    assert NAMES[0] in older and (work / NAMES[0]).read_text(encoding="utf-8") == learned


def test_a_lost_mark_makes_no_untouched_copy_older(kit, tmp_path):
    lay_out(kit, tmp_path / "work")
    (tmp_path / "work" / MARK).unlink()
    assert lay_out(kit, tmp_path / "work") == ([], [])
    renew(kit)
    assert lay_out(kit, tmp_path / "work") == ([NAMES[0]], [])


def test_reset_keeps_what_was_there_every_time(kit, tmp_path):
    work = tmp_path / "work"
    lay_out(kit, work)
    fresh = (work / NAMES[0]).read_bytes()
    learn(work / NAMES[0])
    learned = (work / NAMES[0]).read_bytes()
    assert learned != fresh
    kept = [reset(kit, work, "0")[1] for _ in range(3)]
    assert len(set(kept)) == 3 and kept[0].read_bytes() == learned
    assert (work / NAMES[0]).read_bytes() == fresh == kept[2].read_bytes()
    assert reset(kit, tmp_path / "other", "01") == (tmp_path / "other" / NAMES[1], None)


@pytest.mark.parametrize("lesson", ["77", "-1", "", "start", "00_start_here.ipynb", "²"])
def test_a_lesson_that_is_not_there(lesson):
    with pytest.raises(StereoLabError, match=r"Lessons: 00, 01, 02"):
        find(LESSONS, lesson)


def test_a_kit_without_lessons(tmp_path):
    with pytest.raises(StereoLabError, match="there are none"):
        lay_out(tmp_path, tmp_path / "work")


def test_a_folder_that_cannot_be_made(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(StereoLabError, match="Cannot write"):
        lay_out(LESSONS, tmp_path / "file" / "work")


def test_whose_folder_it_is(tmp_path, monkeypatch):
    monkeypatch.delenv("STEREO_LAB_WORK", raising=False)
    monkeypatch.setenv("STEREO_LAB_HOME", str(tmp_path / "home"))
    (tmp_path / "work" / "deeper").mkdir(parents=True)
    monkeypatch.chdir(tmp_path / "work" / "deeper")
    assert own_folder() == tmp_path / "home"
    (tmp_path / "work" / MARK).write_text("{}")
    assert own_folder() == tmp_path / "work"
    monkeypatch.setenv("STEREO_LAB_WORK", str(tmp_path / "ada"))
    assert own_folder() == tmp_path / "ada"


def test_progress_belongs_to_a_learner(tmp_path, monkeypatch, capsys):
    for name, numbers in (("ada", (1, 2)), ("bo", (5,))):
        monkeypatch.setenv("STEREO_LAB_WORK", str(tmp_path / name))
        for number in numbers:
            progress.passed("00", number)
    assert progress.load() == {"00": [5]}
    monkeypatch.setenv("STEREO_LAB_WORK", str(tmp_path / "ada"))
    assert main(["progress"]) == 0
    assert "lesson 00  ##       2 of 5   open: 0.3, 0.4, 0.5\n" in capsys.readouterr().out
    assert main(["progress", "--json", "-"]) == 0
    assert json.loads(capsys.readouterr().out)["lessons"]["00"] == {"passed": [1, 2], "questions": 5}


def test_progress_needs_no_measured_balls(bench, tmp_path, monkeypatch, capsys):
    """As on the day on which a class has recorded its boards: the lessons themselves go on with the shipped bench."""
    shutil.copytree(bench.path / "calibration", tmp_path / "mine" / "calibration")
    shutil.copy(bench.path / "recording.json", tmp_path / "mine")
    monkeypatch.setenv("STEREO_LAB_WORK", str(tmp_path / "ada"))
    assert main(["progress", str(tmp_path / "mine")]) == 0
    assert "lesson 09" in capsys.readouterr().out


def test_progress_of_nobody_is_no_progress(monkeypatch, capsys):
    assert main(["progress", "--name", "nobody-of-that-name"]) == 2
    assert "There is no work in" in capsys.readouterr().err


@pytest.mark.parametrize("name", ["../ada", "", "a b", "x" * 41, "a/b"])
def test_a_name_that_is_no_name_of_a_folder(name, capsys):
    assert main(["progress", "--name", name]) == 2
    assert "letters, figures" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "lesson", "more"),
    [([], "00", []), (["3"], "03", []), (["05", "--", "--no-browser"], "05", ["--no-browser"]), (["--", "--ip=x"], "00", ["--ip=x"]), (["02", "--data", str(ROOT / "data"), "--", "--no-browser", "7"], "02", ["--no-browser", "7"])],
)  # fmt: skip
def test_start_opens_a_lesson_in_the_learners_folder(tmp_path, monkeypatch, capsys, words, lesson, more):
    started = []

    class Started:
        def __init__(self, command, env=None, **_):
            started.append((command, env))

        def __enter__(self):
            return self

        def __exit__(self, *_):
            return None

        def wait(self):
            return 7

    monkeypatch.setattr(course.subprocess, "Popen", Started)
    monkeypatch.setenv("STEREO_LAB_WORK", str(tmp_path / "work"))
    assert main(["start", *words]) == 7
    command, environment = started[-1]
    page = next(word for word in command if word.startswith("--LabApp.extra_labextensions_path="))
    assert list(Path(page.partition("=")[2]).glob("*/package.json"))  # it names pictures and sliders
    (opened,) = [name for name in NAMES if name.startswith(lesson)]
    assert str(tmp_path / "work" / opened) in command and f"--ServerApp.root_dir={tmp_path / 'work'}" in command
    assert command[len(command) - len(more) :] == more and environment["STEREO_LAB_WORK"] == str(tmp_path / "work")
    assert str(tmp_path / "work") in capsys.readouterr().out
    assert (tmp_path / "work" / opened).exists()


def test_a_folder_for_each_name_beside_lab_py_or_in_the_home(tmp_path, monkeypatch):
    monkeypatch.delenv("STEREO_LAB_WORK", raising=False)
    (tmp_path / "lab.py").write_text("")
    monkeypatch.setattr("stereo_lab.recording.places.REPOSITORY", tmp_path)
    assert course.work_folder(None) == tmp_path / "work" and course.work_folder("ada") == tmp_path / "work-ada"
    monkeypatch.setattr(os, "access", lambda *_: False)
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    monkeypatch.setenv("USERPROFILE", str(tmp_path / "home"))
    assert course.work_folder("ada") == tmp_path / "home" / "stereo_lab" / "work-ada"


def test_ctrl_c_is_left_to_jupyterlab(tmp_path, monkeypatch):
    """It asks whether it is meant; whoever started it waits for the answer."""
    waits = iter([KeyboardInterrupt, KeyboardInterrupt, 0])

    class Started(SimpleNamespace):
        def __enter__(self):
            return self

        def __exit__(self, *_):
            return None

        def wait(self):
            if (answer := next(waits)) == 0:
                return 0
            raise answer

    monkeypatch.setattr(course.subprocess, "Popen", lambda *_, **__: Started())
    monkeypatch.setenv("STEREO_LAB_WORK", str(tmp_path))
    assert main(["start"]) == 0 and next(waits, None) is None


@pytest.mark.skipif(os.name == "nt", reason="a terminal's window is closed another way there")
@pytest.mark.parametrize("nohup", [False, True])
def test_whoever_closes_the_window_ends_jupyterlab_in_its_own_way(monkeypatch, nohup):
    """It inherits that the signal is ignored, and gets the one by which it shuts its kernels down."""
    signal.signal(signal.SIGHUP, signal.SIG_IGN if nohup else signal.SIG_DFL)
    inherited, ended = [], []
    lab = SimpleNamespace(terminate=lambda: ended.append("told"))
    monkeypatch.setattr(
        course.subprocess, "Popen", lambda *_, **__: inherited.append(signal.getsignal(signal.SIGHUP)) or lab
    )
    assert course._jupyterlab([], {}) is lab and inherited == [signal.SIG_IGN]
    signal.raise_signal(signal.SIGHUP)
    assert ended == ([] if nohup else ["told"])
    signal.raise_signal(signal.SIGTERM)
    assert ended[-1] == "told" and len(ended) == (1 if nohup else 2)


@pytest.mark.parametrize("words", [[], ["--name", "evaa"]])
def test_reset_makes_no_learner_of_a_mistyped_name(tmp_path, monkeypatch, capsys, words):
    monkeypatch.setattr(course, "work_folder", lambda name: tmp_path / f"work-{name}")
    assert main(["reset", "03", *words]) == 2 and not list(tmp_path.iterdir())
    said = capsys.readouterr().err
    assert "There is no work in" in said and " ".join(["start", *words]) in said


def test_reset_by_command(tmp_path):
    environment = {**os.environ, "STEREO_LAB_WORK": str(tmp_path), "PYTHONPATH": str(ROOT)}
    run = lambda *words: subprocess.run(
        [sys.executable, "-m", "stereo_lab", *words], env=environment, capture_output=True, text=True
    )
    assert run("reset", "03").stdout.endswith("03_world_coordinates.ipynb is as new.\n")
    assert "What you had is now 03_world_coordinates_20" in run("reset", "3").stdout
    wrong = run("reset", "44")
    assert wrong.returncode == 2 and "There is no lesson '44'" in wrong.stderr

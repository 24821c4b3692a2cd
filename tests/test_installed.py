"""The kit as an installed package: what a wheel takes along, what is found where, what is said where nothing is."""

import json
import os
import shutil
import signal
import subprocess
import sys
import time
import urllib.request
import zipfile
from types import SimpleNamespace

import matplotlib
import pytest

from conftest import ROOT
from stereo_lab.cli import course, main
from stereo_lab.common.packages import find_pip
from stereo_lab.errors import RecordingError
from stereo_lab.recording import open_recording, places
from tests.test_browser import free_port

RUN = """import json, sys, nbformat
from nbclient import NotebookClient
notebook = nbformat.read(sys.argv[1], 4)
NotebookClient(notebook, timeout=120, kernel_name="python3").execute()
print(json.dumps([o.get("text", "") for c in notebook.cells for o in c.get("outputs", []) if o.output_type == "stream"]))"""


@pytest.fixture(scope="module")
def installed(tmp_path_factory):
    """An environment with the wheel, and the other packages of this one behind it; nothing of the kit's own folder."""
    folder = tmp_path_factory.mktemp("installed")
    kit = folder / "kit"
    kit.mkdir()
    for name in ("stereo_lab", "notebooks", "data"):
        skipped = shutil.ignore_patterns("__pycache__", ".ipynb_checkpoints")
        shutil.copytree(ROOT / name, kit / name, ignore=skipped)
    for name in ("pyproject.toml", "setup.py", "MANIFEST.in", "README.md", "environment.txt"):
        shutil.copy(ROOT / name, kit)
    (kit / "build" / "lib" / "stereo_lab").mkdir(parents=True)
    (kit / "build" / "lib" / "stereo_lab" / "of_an_older_build.py").write_text("")
    pip = [*find_pip(), "--disable-pip-version-check"]
    run([*pip, "wheel", "--quiet", "--no-deps", "--no-build-isolation", "--wheel-dir", str(folder), str(kit)])
    shutil.rmtree(kit)
    (wheel,) = folder.glob("*.whl")
    run([sys.executable, "-m", "venv", "--without-pip", str(folder / "venv")])
    python = folder / "venv" / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
    find = lambda program: run([str(program), "-c", "import sysconfig; print(sysconfig.get_path('purelib'))"]).strip()
    with open(os.path.join(find(python), "others.pth"), "w", encoding="utf-8") as file:
        file.write(find(sys.executable))  # behind its own, and without what a .pth there would add
    run([*pip, "--python", str(python), "install", "--quiet", "--no-deps", "--no-index", "--no-compile", str(wheel)])
    home = folder / "home"
    home.mkdir()
    environment = {k: v for k, v in os.environ.items() if not k.startswith(("STEREO_LAB", "PYTHONPATH"))}
    environment |= {"HOME": str(home), "USERPROFILE": str(home), "XDG_DATA_HOME": str(home / "data")}
    environment["MPLCONFIGDIR"] = matplotlib.get_cachedir()  # its list of fonts is long in the making
    ours = lambda *words, **more: subprocess.run(
        [str(python), *words], capture_output=True, text=True, cwd=home, env={**environment, **more}
    )
    return SimpleNamespace(wheel=wheel, python=str(python), run=ours, home=home, environment=environment)


def run(command):
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.mark.slow
def test_a_wheel_takes_the_course_along(installed):
    names = set(zipfile.ZipFile(installed.wheel).namelist())
    lessons = [path for path in (ROOT / "notebooks").rglob("*") if path.suffix in (".ipynb", ".md")]
    recordings = [path.parent for path in (ROOT / "data").glob("*/recording.json")]
    pictures = [
        path for folder in recordings for path in folder.rglob("*") if path.suffix in (".jpg", ".png", ".csv", ".json")
    ]
    wanted = {
        f"stereo_lab/course/{path.relative_to(ROOT).as_posix()}"
        for path in (*lessons, *pictures, ROOT / "environment.txt")
    }
    assert (
        len(lessons) > 15 and len(pictures) > 1000 and wanted <= names and "stereo_lab/detection/weights.json" in names
    )
    assert not [name for name in names if "older_build" in name or name.startswith(("tests", "data", "notebooks"))]
    assert installed.wheel.stat().st_size < 100e6


@pytest.mark.slow
def test_the_first_lesson_runs_from_a_wheel(installed):
    told = json.loads(installed.run("-m", "stereo_lab", "places", "--json", "-").stdout)
    assert all("site-packages" in told["places"][name] for name in ("lessons", "for the teacher", "recordings 1"))
    assert told["places"]["your work"] == str(installed.home / "stereo_lab" / "work")
    assert {"bench", "second_rig", "clutter_test"} <= set(told["recordings"])
    port = free_port()
    command = [installed.python, "-m", "stereo_lab", "start", "00", "--", "--no-browser", f"--port={port}", "--allow-root",
               "--ServerApp.port_retries=0", "--IdentityProvider.token=wheel"]  # fmt: skip
    running = subprocess.Popen(command, env=installed.environment, cwd=installed.home, stdout=subprocess.PIPE, stderr=subprocess.PIPE, start_new_session=True)  # fmt: skip
    try:
        page = f"http://127.0.0.1:{port}/api/contents/00_start_here.ipynb?token=wheel"
        assert json.loads(answer(page, running))["type"] == "notebook"
    finally:
        os.killpg(running.pid, signal.SIGKILL)  # JupyterLab and who started it
        running.communicate()
    lesson = installed.home / "stereo_lab" / "work" / "00_start_here.ipynb"
    done = installed.run("-c", RUN, str(lesson), STEREO_LAB_WORK=str(lesson.parent))
    assert done.returncode == 0, done.stderr
    assert "NOT ATTEMPTED" in "".join(json.loads(done.stdout)) and " mm" in "".join(json.loads(done.stdout))


def answer(page, running):
    for _ in range(300):
        assert running.poll() is None, running.stderr.read()
        try:
            return urllib.request.urlopen(page, timeout=2).read()
        except OSError:
            time.sleep(0.2)
    raise AssertionError("no answer")


@pytest.mark.slow
def test_a_wheel_without_recordings_says_where_to_get_them(installed):
    told = json.loads(installed.run("-m", "stereo_lab", "places", "--json", "-").stdout)["places"]
    hidden = told["recordings 1"] + "_hidden"
    os.rename(told["recordings 1"], hidden)
    try:
        done = installed.run("-m", "stereo_lab", "start")
        assert done.returncode == 2 and done.stderr.startswith("stereo-lab: The recordings are not here: ")
        assert done.stderr.count("\n") == 1 and "--data FOLDER" in done.stderr and "STEREO_LAB_DATA" in done.stderr
        code = "from stereo_lab.recording import open_recording; print(open_recording().path)"
        assert "The recordings are not here" in installed.run("-c", code).stderr
        assert installed.run("-c", code, STEREO_LAB_DATA=hidden).stdout.strip() == os.path.join(hidden, "bench")
    finally:
        os.rename(hidden, told["recordings 1"])


@pytest.mark.slow
def test_what_a_wheel_does_not_bring_is_said(installed):
    for words, says in ((("test",), "The tests come with"), (("render", "bench"), "The renderer comes with")):
        done = installed.run("-m", "stereo_lab", *words)
        assert done.returncode == 2 and says in done.stderr and done.stderr.count("\n") == 1


@pytest.fixture
def shelf(tmp_path):
    """A teacher's folder with one recording."""
    (tmp_path / "shelf" / "ours").mkdir(parents=True)
    shutil.copy(ROOT / "data" / "bench" / "recording.json", tmp_path / "shelf" / "ours")
    return tmp_path / "shelf"


def test_a_teachers_folder_comes_first(shelf, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv(places.DATA, str(shelf))
    assert open_recording("ours").path == shelf / "ours" and "ours" in places.known()
    assert open_recording("bench").path == ROOT / "data" / "bench"
    (shelf / "ours").rename(shelf / "bench")
    assert open_recording("bench").path == open_recording("data/bench").path.parent.parent.parent / shelf / "bench"
    monkeypatch.setenv(places.DATA, str(tmp_path / "none"))
    with pytest.raises(
        RecordingError, match="There is no folder no_such. Recordings that are found by their names: bench"
    ):
        monkeypatch.delenv(places.DATA)
        open_recording("no_such")


def test_start_hands_a_teachers_folder_on(shelf, tmp_path, monkeypatch):
    started = []

    class Started:
        def __init__(self, command, env=None, **_):
            started.append(env)

        __enter__ = lambda self: self
        __exit__ = lambda self, *_: None
        wait = lambda self: 0

    monkeypatch.setattr(course.subprocess, "Popen", Started)
    monkeypatch.setenv("STEREO_LAB_WORK", str(tmp_path / "work"))
    monkeypatch.setenv(places.DATA, "")  # put back in the end
    monkeypatch.chdir(shelf.parent)
    assert main(["start", "--data", "shelf"]) == 0 and started[-1][places.DATA] == str(shelf)


@pytest.mark.parametrize("shelf_there", [True, False])
def test_start_with_a_folder_that_has_none(tmp_path, monkeypatch, capsys, shelf_there):
    if shelf_there:
        (tmp_path / "shelf").mkdir()
    monkeypatch.setenv(places.DATA, "")
    monkeypatch.setenv("STEREO_LAB_WORK", str(tmp_path / "work"))
    assert main(["start", "--data", str(tmp_path / "shelf")]) == 2
    said = capsys.readouterr().err
    assert f"There is no recording in {tmp_path / 'shelf'}" in said and said.count("\n") == 1
    assert not (tmp_path / "work").exists()


def test_places_by_command(tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("STEREO_LAB_WORK", str(tmp_path / "work"))
    assert main(["places"]) == 0
    told = capsys.readouterr().out
    assert (
        f"your work        {tmp_path / 'work'}   (not there)" in told and f"recordings 1     {ROOT / 'data'}\n" in told
    )
    assert "bench, clutter, clutter_test, second_rig" in told

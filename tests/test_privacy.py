"""Nothing leaves the computer unasked: a lesson runs where there is no network, and asks for none."""

import json
import os
import re
import shutil
import subprocess
import sys

import pytest

from conftest import ROOT, skip_unless_ci
from stereo_lab.common.files import user_folder
from stereo_lab.work import lay_out

PAGE = ROOT / "docs" / "privacy.md"
# Loaded by every Python that a lesson starts: it writes down who asks for another computer, and lets it go on.
LISTENS = """import os, sys
def heard(event, args):
    if event in ("socket.getaddrinfo", "socket.gethostbyname"):
        address = args[0]
    elif event in ("socket.connect", "socket.sendto", "socket.sendmsg"):
        address = args[1][0] if isinstance(args[1], tuple) else None  # a path is a socket of this computer
    else:
        return
    if address not in (None, "", "127.0.0.1", "::1", "localhost", b"localhost", "0.0.0.0"):
        with open(os.environ["HEARD"], "a") as file:
            file.write(f"{event} {address}\\n")
sys.addaudithook(heard)
"""
RUN = """import sys, nbformat
from nbclient import NotebookClient
notebook = nbformat.read(sys.argv[1], 4)
NotebookClient(notebook, timeout=120, kernel_name="python3").execute()
print(sum(bool(cell.get("outputs")) for cell in notebook.cells))"""


@pytest.fixture
def alone(tmp_path):
    """Runs Python in a place with no network but the computer itself; gives the result, and who was asked for."""
    begin = ["unshare", "-rn", "sh", "-c", 'ip link set lo up && exec "$@"', "sh"]
    if not (shutil.which("unshare") and shutil.which("ip")) or subprocess.run([*begin, "true"], capture_output=True).returncode:  # fmt: skip
        skip_unless_ci("no network namespaces here")
    (tmp_path / "listens").mkdir()
    (tmp_path / "listens" / "sitecustomize.py").write_text(LISTENS)
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(tmp_path / "listens"), str(ROOT)])}
    environment |= {"HEARD": str(tmp_path / "heard"), "STEREO_LAB_WORK": str(tmp_path / "work")}

    def run(*words):
        done = subprocess.run([*begin, sys.executable, *words], capture_output=True, text=True, env=environment)
        heard = tmp_path / "heard"
        return done, heard.read_text().splitlines() if heard.exists() else []

    return run


@pytest.mark.slow
@pytest.mark.parametrize("lesson", ["00_start_here", "06_driving_the_arm"])
def test_a_lesson_asks_nobody(alone, tmp_path, lesson):
    lay_out(ROOT / "notebooks", tmp_path / "work")
    done, heard = alone("-c", RUN, str(tmp_path / "work" / f"{lesson}.ipynb"))
    assert done.returncode == 0 and int(done.stdout) > 10, done.stderr
    assert heard == []


def test_whoever_asks_is_heard(alone):
    code = "import socket\ntry: socket.create_connection(('192.0.2.1', 80), 2)\nexcept OSError: print('none')"
    done, heard = alone("-c", code)
    assert done.stdout == "none\n" and any("192.0.2.1" in line for line in heard)


def test_the_page_names_every_place(tmp_path, monkeypatch, capsys):
    from stereo_lab.cli import main

    monkeypatch.setenv("STEREO_LAB_WORK", str(tmp_path / "work"))
    assert main(["places", "--json", "-"]) == 0
    places = json.loads(capsys.readouterr().out)["places"]
    told = PAGE.read_text(encoding="utf-8")
    for name in ("your work", "calibrations"):
        assert f"`{name}`" in told and name in places
    assert places["calibrations"] == str(user_folder() / "calibrations")
    for kept in ("progress.json", "answers", ".stereo_lab.json", "STEREO_LAB_WORK", "STEREO_LAB_HOME", "--mqtt"):
        assert kept in told


def test_what_can_speak_to_another_computer():
    """MQTT can, where a broker is named; who adds something that can says so in docs/privacy.md."""
    speak = re.compile(r"^\s*(?:import|from) (socket|ssl|urllib(?!\.parse)|http|ftplib|smtplib|requests|httpx|paho|websockets?)\b", re.M)  # fmt: skip
    files = [path for path in (ROOT / "stereo_lab").rglob("*.py") if speak.search(path.read_text(encoding="utf-8"))]
    rooms = {path.relative_to(ROOT / "stereo_lab").as_posix() for path in files}
    # beside it: the arm served on an address that somebody named, and `ready`, which speaks to 127.0.0.1
    assert rooms == {"live/telemetry.py", "arm/virtual/served.py", "seats/ready.py"}

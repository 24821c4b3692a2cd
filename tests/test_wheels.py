"""Thirty computers from a stick: what is fetched for which, and a set-up in a place without a network."""

import http.server
import importlib.util
import json
import os
import re
import shutil
import subprocess
import sys
import threading
import zipfile

import pytest

from conftest import ROOT, skip_unless_ci
from stereo_lab.cli import main
from stereo_lab.errors import StereoLabError
from stereo_lab.seats import wheels
from stereo_lab.seats.wheels import MANIFEST, SYSTEMS, Target, fill, requirements_for, system_here

ENVIRONMENT = (ROOT / "environment.txt").read_text(encoding="utf-8")
HERE = Target.here()

# A kit as small as can be: one package besides it, and a way to install it that needs no other.
BACKEND = """
import zipfile, os
def build_editable(folder, settings=None, metadata=None):
    name = "little-1.0-py3-none-any.whl"
    with zipfile.ZipFile(os.path.join(folder, name), "w") as file:
        file.writestr("little.pth", os.getcwd())
        file.writestr("little-1.0.dist-info/METADATA", "Metadata-Version: 2.1\\nName: little\\nVersion: 1.0\\n")
        file.writestr("little-1.0.dist-info/WHEEL", "Wheel-Version: 1.0\\nRoot-Is-Purelib: true\\nTag: py3-none-any\\n")
        file.writestr("little-1.0.dist-info/RECORD", "")
    return name
build_wheel = build_editable
"""
PROGRAM = """import socket, sys, tiny
try:
    socket.create_connection(("192.0.2.1", 80), timeout=3)
    print("there is a network")
except OSError as error:
    print(tiny.WORD, sys.argv[1:], "no network:", error.strerror)
"""


@pytest.fixture
def stick(tmp_path):
    """A kit with one package, and a place that has this package; spaces and other letters in the way."""
    kit, shelf = tmp_path / "stick of Zoë" / "kit", tmp_path / "shelf"
    (kit / "stereo_lab").mkdir(parents=True)
    shelf.mkdir()
    shutil.copy(ROOT / "lab.py", kit)
    (kit / "environment.txt").write_text("tiny==1.0\nabsent==9 ; sys_platform == 'no_such_system'\n")
    project = '[project]\nname = "little"\nversion = "1.0"\n'
    build = '[build-system]\nrequires = []\nbuild-backend = "backend"\nbackend-path = ["."]\n'
    (kit / "pyproject.toml").write_text(build + project)
    (kit / "backend.py").write_text(BACKEND)
    (kit / "stereo_lab" / "__main__.py").write_text(PROGRAM)
    with zipfile.ZipFile(shelf / "tiny-1.0-py3-none-any.whl", "w") as file:
        file.writestr("tiny.py", "WORD = 'set up,'\n")
        file.writestr("tiny-1.0.dist-info/METADATA", "Metadata-Version: 2.1\nName: tiny\nVersion: 1.0\n")
        file.writestr("tiny-1.0.dist-info/WHEEL", "Wheel-Version: 1.0\nRoot-Is-Purelib: true\nTag: py3-none-any\n")
        file.writestr("tiny-1.0.dist-info/RECORD", "")
    return kit, shelf


@pytest.fixture
def shelf_only(stick, monkeypatch):
    """pip looks at the shelf and nowhere else."""
    for name in [name for name in os.environ if name.startswith("PIP_")]:
        monkeypatch.delenv(name)
    monkeypatch.setenv("PIP_CONFIG_FILE", os.devnull)
    monkeypatch.setenv("PIP_NO_INDEX", "1")
    monkeypatch.setenv("PIP_FIND_LINKS", stick[1].as_uri())
    return stick


def test_a_computer_is_set_up_without_a_network(shelf_only, tmp_path, monkeypatch):
    if not shutil.which("unshare") or subprocess.run(["unshare", "-rn", "true"], capture_output=True).returncode:
        skip_unless_ci("no network namespaces here")
    kit, _ = shelf_only
    folder = tmp_path / "stick of Zoë" / "wheels"
    sizes = fill(folder, kit / "environment.txt", [HERE])
    assert list(sizes) == ["tiny-1.0-py3-none-any.whl"]
    for name in ("PIP_NO_INDEX", "PIP_FIND_LINKS", "STEREO_LAB_EXTRAS"):
        monkeypatch.delenv(name, raising=False)
    command = ["unshare", "-rn", sys.executable, str(kit / "lab.py"), "--offline", str(folder), "hello", "--there"]
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert done.stdout == "set up, ['hello', '--there'] no network: Network is unreachable\n"
    shutil.rmtree(folder)  # and from now on it needs the stick no more
    again = subprocess.run([*command[:4], "again"], capture_output=True, text=True, cwd=tmp_path)
    assert again.stdout.startswith("set up, ['again']") and again.stderr == ""


@pytest.fixture
def lab(tmp_path, monkeypatch):
    spec = importlib.util.spec_from_file_location("lab", ROOT / "lab.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    monkeypatch.setattr(module, "STAMP", str(tmp_path / "stamp"))
    monkeypatch.setattr(module, "make_environment", lambda *_: pytest.fail("it went on"))
    return module


@pytest.mark.parametrize(
    ("made", "says"),
    [
        (None, "Expected a folder that `stereo-lab wheels` made"),
        ("[1]", "Expected a folder that `stereo-lab wheels` made"),
        ({"made_for": [["windows", "3.99"]], "files": {}}, "was made for Python 3.99 on windows; this is Python"),
        ({"made_for": [list(map(str, (HERE.system, HERE.python)))], "files": {"a.whl": 3}}, "a.whl is missing"),
        ({"made_for": [[HERE.system, HERE.python]], "files": {"b.whl": 99}}, "b.whl is missing or cut off"),
    ],
)  # fmt: skip
def test_a_folder_that_does_not_fit(lab, tmp_path, capsys, made, says):
    (tmp_path / "b.whl").write_text("cut off")
    if made is not None:
        (tmp_path / MANIFEST).write_text(made if isinstance(made, str) else json.dumps(made))
    assert lab.main(["--offline", str(tmp_path), "test"]) == 2
    said = capsys.readouterr().err
    assert says in said and said.count("\n") == 1


def test_a_folder_that_is_not_named(lab, capsys):
    assert lab.main(["--offline"]) == 2 and "the folder is expected" in capsys.readouterr().err


@pytest.mark.parametrize("system", [("win32", "AMD64"), ("darwin", "arm64"), ("darwin", "x86_64"), ("linux", "x86_64"), ("linux", "aarch64")])  # fmt: skip
def test_both_call_a_system_the_same(lab, monkeypatch, system):
    monkeypatch.setattr(lab.sys, "platform", system[0])
    monkeypatch.setattr(lab.platform, "machine", lambda: system[1])
    assert lab.system() == system_here(*system) and lab.system() in (*SYSTEMS, wheels.INTEL_MAC)


@pytest.mark.parametrize("system", SYSTEMS)
@pytest.mark.parametrize("python", ["3.10", "3.14"])
def test_each_kind_of_computer_gets_its_own(system, python):
    lines = requirements_for(ENVIRONMENT, Target(system, python))
    names = [re.split("[=<>]", line)[0] for line in lines]
    assert len(set(names)) == len(names) > 90 and {"numpy", "jupyterlab", "setuptools"} <= set(names)
    assert ("pywinpty" in names) == (system == "windows") and ("appnope" in names) == system.startswith("macos")
    assert ("numpy==2.2.6" in lines) == (python == "3.10") and not any(";" in line for line in lines)


def test_here_it_is_what_pip_takes_here():
    """An oracle: what is installed now was chosen by pip itself, by the same conditions."""
    from importlib.metadata import version

    for line in requirements_for(ENVIRONMENT, HERE, sys.version_info[2]):
        name, _, wanted = line.partition("==")
        assert version(name) == wanted, line


def test_every_release_of_a_python_is_served(stick, tmp_path, monkeypatch):
    (stick[0] / "environment.txt").write_text(
        "a==1\nb==1 ; python_full_version < '3.11.5'\nb==2 ; python_full_version >= '3.11.5'\n"
    )
    asked = []
    monkeypatch.setattr(wheels, "_download", lambda pip, out, target, micro, lines: asked.append((target.python, micro, lines)) or [])  # fmt: skip
    fill(tmp_path, stick[0] / "environment.txt", [Target("linux", "3.11"), Target("linux", "3.12")])
    assert asked == [("3.11", 0, ["a==1", "b==1"]), ("3.11", 99, ["b==2"]), ("3.12", 0, ["a==1", "b==2"])]


def test_by_command_and_again(shelf_only, tmp_path, monkeypatch, capsys):
    kit, shelf = shelf_only
    monkeypatch.setattr("stereo_lab.recording.places.REPOSITORY", kit)
    out = tmp_path / "wheels"
    assert main(["wheels", str(out), "--system", "windows", "macos", "--python", "3.12"]) == 0
    assert "Python 3.12 on windows, Python 3.12 on macos" in capsys.readouterr().out
    told = json.loads((out / MANIFEST).read_text())
    assert told["made_for"] == [["windows", "3.12"], ["macos", "3.12"]]
    assert told["files"] == {path.name: path.stat().st_size for path in out.glob("*.whl")} and len(told["files"]) == 1
    (shelf / "tiny-1.0-py3-none-any.whl").unlink()
    assert main(["wheels", str(tmp_path / "other")]) == 2
    said = capsys.readouterr().err
    assert "Cannot fetch all for" in said and "is this computer online" in said and said.count("\n") == 1
    assert not (tmp_path / "other" / MANIFEST).exists()


@pytest.mark.parametrize(
    ("system", "python"),
    [("beos", "3.12"), (wheels.INTEL_MAC, "3.12"), ("linux", "3.9"), ("linux", "3.99"), ("linux", "x")],
)
def test_no_such_computer(system, python):
    with pytest.raises(StereoLabError, match="with a network|Choose among|Expected a Python among"):
        Target(system, python)


class Proxy(http.server.BaseHTTPRequestHandler):
    """A school's proxy: it alone reaches the package index, and knows who was asked for."""

    shelf, asked = None, []

    def do_GET(self):
        self.asked.append(self.path)
        name = self.path.rstrip("/").rpartition("/")[2]
        (wheel,) = self.shelf.glob("*.whl")
        page = wheel.read_bytes() if name == wheel.name else f'<a href="/{wheel.name}">{wheel.name}</a>'.encode()
        self.send_response(200)
        self.send_header("Content-Type", "application/octet-stream" if name == wheel.name else "text/html")
        self.send_header("Content-Length", str(len(page)))
        self.end_headers()
        self.wfile.write(page)

    def log_message(self, *_):
        """Nothing in the terminal."""


def test_a_computer_is_set_up_through_a_proxy(stick, tmp_path):
    kit, Proxy.shelf = stick
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), Proxy) as proxy:
        threading.Thread(target=proxy.serve_forever, daemon=True).start()
        environment = {k: v for k, v in os.environ.items() if not k.startswith(("PIP_", "UV_", "STEREO_LAB_EXTRAS"))}
        environment |= {"PIP_CONFIG_FILE": os.devnull, "HTTP_PROXY": f"http://127.0.0.1:{proxy.server_port}"}
        for tool, index in (("PIP", "INDEX_URL"), ("UV", "INDEX_URL")):  # lab.py takes uv where it is there
            environment[f"{tool}_{index}"] = "http://packages.invalid/simple"
        environment |= {"http_proxy": environment["HTTP_PROXY"], "PIP_TRUSTED_HOST": "packages.invalid", "NO_PROXY": ""}
        environment["UV_INSECURE_HOST"] = "packages.invalid"
        command = [sys.executable, str(kit / "lab.py"), "hello"]
        done = subprocess.run(command, capture_output=True, text=True, env=environment, cwd=tmp_path)
        proxy.shutdown()
    assert done.returncode == 0, done.stderr
    assert "http://packages.invalid/simple/tiny/" in Proxy.asked


def test_a_file_is_no_folder_to_fill(tmp_path, capsys):
    (tmp_path / "x.zip").touch()
    assert main(["wheels", str(tmp_path / "x.zip")]) == 2
    assert "x.zip is a file" in capsys.readouterr().err

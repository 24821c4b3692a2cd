"""`stereo-lab ready`: each thing found fit, and each found wanting, with what to do."""

import errno
import json
import os
import signal
import socket
import subprocess
import sys
import threading
from collections import namedtuple
from types import SimpleNamespace

import pytest

from stereo_lab.cli import main
from stereo_lab.seats import devices, ready
from stereo_lab.seats.devices import CAPABILITIES, CAPTURES, OF_NODE, Device, holder_of, video_devices
from stereo_lab.seats.ready import FIT, LOOK, UNFIT, Line, examine

Camera = namedtuple("Camera", "number sizes rate_hz")
GOOD = ((640, 480),)


def test_this_computer_by_command(tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("STEREO_LAB_WORK", str(tmp_path / "work"))
    code = main(["ready"])
    told = capsys.readouterr().out
    names = ("Python", "notebooks", "memory", "disk", "browser", "serial port", "cameras")
    lines = [line for line in told.splitlines() if "->" not in line]
    assert [line[5:18].strip() for line in lines] == list(names)
    assert lines[0].startswith("ok") and "all packages load" in lines[0]
    assert lines[1].startswith("ok") and "computes" in lines[1] and lines[3].startswith("ok")
    assert code == (1 if any(line.startswith("NO") for line in lines) else 0)
    assert list(tmp_path.iterdir()) == []  # it leaves nothing behind
    for line, after in zip(told.splitlines(), [*told.splitlines()[1:], ""], strict=True):
        assert line.startswith("ok") or "->" in line or "->" in after  # what is not fit comes with what to do


def test_what_is_unfit_is_the_exit_code(monkeypatch, capsys):
    checks = [("a", lambda: Line("a", FIT, "there")), ("b", lambda: Line("b", UNFIT, "gone", "Get one."))]
    monkeypatch.setattr(ready, "all_checks", lambda folder: checks)
    assert main(["ready"]) == 1
    assert capsys.readouterr().out == "ok   a            there\nNO   b            gone\n                  -> Get one.\n"
    monkeypatch.setattr(ready, "all_checks", lambda folder: checks[:1])
    assert main(["ready", "--json", "-"]) == 0
    assert json.loads(capsys.readouterr().out) == {
        "lines": [{"what": "a", "state": "ok", "found": "there", "todo": ""}]
    }


def test_what_hangs_costs_its_own_line_only():
    ends = threading.Event()
    lines = list(examine([("hangs", ends.wait), ("fit", lambda: Line("fit", FIT, "there"))], seconds=2))
    ends.set()
    assert [(line.what, line.state) for line in lines] == [("hangs", LOOK), ("fit", FIT)]
    assert "2 s" in lines[0].found and lines[0].todo


def test_a_package_that_does_not_load():
    line = ready.python(["no_such_package"])
    assert line.state == UNFIT and "No module named 'no_such_package'" in line.found and ".venv" in line.todo


@pytest.mark.parametrize(
    ("ended", "state", "word"),
    [(-signal.SIGILL, UNFIT, "too old"), (None, LOOK, "very long"), (-signal.SIGSEGV, UNFIT, "ended with -11")],
)
def test_packages_that_end_otherwise(monkeypatch, ended, state, word):
    monkeypatch.setattr(ready, "_run", lambda *_: (ended, ""))
    line = ready.python()
    assert line.state == state and word in line.found and line.todo


def test_a_kernel_that_does_not_answer():
    assert "no kernel answers: it ended with 3" in ready.notebooks("raise SystemExit(3)").found
    assert ready.notebooks("print(41)").state == UNFIT
    assert "RuntimeError: no" in ready.notebooks("raise RuntimeError('no')").found


def test_a_computer_that_may_not_talk_to_itself(monkeypatch):
    def refused(*_, **__):
        raise PermissionError(errno.EPERM, "Operation not permitted")

    monkeypatch.setattr(socket, "create_connection", refused)
    line = ready.notebooks()
    assert line.state == UNFIT and "talk to itself: Operation not permitted" in line.found and "127.0.0.1" in line.todo


def test_memory():
    assert ready.memory(2**31).state == FIT
    line = ready.memory(300 * 2**20)
    assert line.state == LOOK and line.found.startswith("300 MB free") and "Close" in line.todo


def test_a_disk(tmp_path, monkeypatch):
    assert ready.disk(tmp_path / "not" / "there").state == FIT and list(tmp_path.iterdir()) == []
    (tmp_path / "file").write_text("")
    line = ready.disk(tmp_path / "file" / "work")
    assert line.state == UNFIT and "cannot be written to" in line.found and "STEREO_LAB_WORK" in line.todo
    line = ready.disk(tmp_path / "OneDrive - School" / "work")
    assert line.state == LOOK and "cloud" in line.found
    monkeypatch.setattr(ready.shutil, "disk_usage", lambda _: SimpleNamespace(free=50 * 2**20))
    assert ready.disk(tmp_path).state == UNFIT and ready.disk(tmp_path).found.startswith("50 MB free")


@pytest.mark.skipif(sys.platform != "linux", reason="other systems always have a browser")
def test_a_browser(tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", str(tmp_path))
    assert ready.browser().state == UNFIT
    program = tmp_path / "firefox"
    program.write_text("#!/bin/sh\necho Mozilla Firefox 140.1\n")
    program.chmod(0o755)
    monkeypatch.setenv("DISPLAY", ":0")
    assert ready.browser() == Line("browser", FIT, "Mozilla Firefox 140.1")
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    assert ready.browser().state == LOOK and "--no-browser" in ready.browser().todo


@pytest.mark.skipif(sys.platform != "linux", reason="pseudo terminals as Linux has them")
def test_a_port_that_another_program_has():
    import pty

    ours, theirs = pty.openpty()
    name = os.ttyname(theirs)
    assert ready.serial_ports(lambda: [name]) == Line("serial port", FIT, name)
    code = f"import serial; port = serial.Serial({name!r}, exclusive=True); print('open', flush=True); input()"
    with subprocess.Popen([sys.executable, "-c", code], stdin=subprocess.PIPE, stdout=subprocess.PIPE) as other:
        assert other.stdout.readline() == b"open\n"
        line = ready.serial_ports(lambda: [name])
        other.communicate(b"\n")
    assert line.state == LOOK and f"{name}: busy" in line.found and f"process {other.pid}" in line.found
    assert "Close" in line.todo
    os.close(ours)
    os.close(theirs)


@pytest.mark.parametrize(
    ("error", "windows", "found", "todo"),
    [
        (PermissionError(errno.EACCES, "Permission denied"), False, "no permission", "dialout"),
        (OSError("could not open port 'COM3': PermissionError(13, 'Access is denied.', None, 5)"), True, "busy", "Close"),
        (OSError(errno.EIO, "Input/output error"), False, "does not open", "Unplug"),
    ],
)  # fmt: skip
def test_a_port_that_does_not_open(monkeypatch, error, windows, found, todo):
    def fails(*_, **__):
        raise error

    monkeypatch.setattr("serial.Serial", fails)
    line = ready.serial_ports(lambda: ["COM3"], windows)
    assert line.state == LOOK and f"COM3: {found}" in line.found and todo in line.todo


def test_no_port():
    assert ready.serial_ports(lambda: []) == Line("serial port", FIT, "none on USB; virtual://arm is always there")


def cameras(known, found, system="linux"):
    asked = []
    line = ready.cameras(known, lambda **how: asked.append(how) or found, system)
    return line, asked


def test_two_cameras(tmp_path):
    known = [Device(0, tmp_path / "video0", "Cam A", False), Device(2, tmp_path / "video2", "Cam B", False)]
    line, asked = cameras(known, [Camera(0, GOOD, 30.2), Camera(2, GOOD, 15.0)])
    assert line == Line("cameras", FIT, "camera 0: 30 pictures a second; camera 2: 15 pictures a second")
    assert asked[0]["most"] == 3


def test_a_camera_without_permission_and_one_that_is_taken(tmp_path):
    (tmp_path / "video2").write_text("")
    known = [Device(0, tmp_path / "video0", "Cam A", True), Device(2, tmp_path / "video2", "", False), Device(4, tmp_path / "video4", "", False)]  # fmt: skip
    with subprocess.Popen(["sleep", "60"], stdin=open(tmp_path / "video2")) as other:  # noqa: SIM115 - it is the child's
        line, _ = cameras(known, [Camera(4, GOOD, 30.0)])
        other.kill()
    assert line.state == LOOK
    assert "camera 4: 30 pictures a second; camera 0 (Cam A): no permission; camera 2: busy, sleep has it" in line.found
    assert "usermod -aG video" in line.todo and "Close that program" in line.todo


def test_a_camera_that_gives_no_picture(tmp_path):
    line, _ = cameras([Device(0, tmp_path / "video0", "Cam A", False)], [Camera(0, (), 0.0)])
    assert line.state == LOOK and "camera 0 (Cam A): gives no picture" in line.found
    for system, word in (("win32", "desktop apps"), ("darwin", "allow the terminal")):
        line, asked = cameras([], [Camera(0, GOOD, 30.0), Camera(1, (), 0.0)], system)
        assert line.state == LOOK and "camera 1: opens and gives no picture" in line.found and word in line.todo
        assert asked[0]["most"] == 4


def test_no_camera_needs_nothing_done():
    assert cameras([], [])[0] == Line("cameras", FIT, "none: the recordings take their place")
    assert cameras([], [])[1] == []  # Linux says so itself; nothing is tried
    assert cameras([], [Camera(0, GOOD, 30.0)], "win32")[0].state == FIT


def test_what_linux_tells_of_its_cameras(tmp_path, monkeypatch):
    system, folder = tmp_path / "sys", tmp_path / "dev"
    folder.mkdir()
    for number, name in ((0, "Cam A\n"), (1, "Cam A\n"), (10, "Cam B\n"), (2, "Cam C\n")):
        (system / f"video{number}").mkdir(parents=True)
        (system / f"video{number}" / "name").write_text(name)
        (folder / f"video{number}").write_text("")
    plain_open = os.open

    def without_leave(path, *more):
        if str(path).endswith("video2"):
            raise PermissionError(errno.EACCES, "Permission denied", str(path))
        return plain_open(path, *more)

    def capabilities(descriptor):  # the whole device captures; the second file of camera A does not
        metadata = os.readlink(f"/proc/self/fd/{descriptor}").endswith("video1")
        return CAPABILITIES.pack(b"uvcvideo", b"Cam", b"usb", 1, OF_NODE | CAPTURES, 0 if metadata else CAPTURES)

    monkeypatch.setattr(devices.os, "open", without_leave)
    assert [(d.number, d.name, d.denied) for d in video_devices(system, folder, capabilities)] == [
        (0, "Cam A", False), (2, "Cam C", True), (10, "Cam B", False),
    ]  # fmt: skip
    assert video_devices(tmp_path / "none") == [] and CAPABILITIES.size == 104


def test_nobody_holds_what_nobody_holds(tmp_path):
    (tmp_path / "video0").write_text("")
    assert holder_of(tmp_path / "video0") == "" and holder_of(tmp_path / "none", tmp_path) == ""

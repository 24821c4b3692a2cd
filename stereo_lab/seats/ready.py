"""Whether this computer is fit for the course: a line for each thing that the lessons need, and what to do about it.

Everything is tried, not looked up: the packages are imported, a kernel computes, a file is written, ports and cameras are opened.
"""

from __future__ import annotations

import contextlib
import errno
import os
import platform
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
import webbrowser
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from stereo_lab.seats.devices import Device, holder_of, video_devices

FIT, LOOK, UNFIT = "ok", "look", "NO"
SECONDS = 25.0  # so long all of it may take; what has not answered by then is told to be silent
PACKAGES = ("numpy", "cv2", "matplotlib.pyplot", "ipywidgets", "serial", "jupyterlab")
DISK_MB = 200  # a recording of one's own has about 20 MB; ten of them, and the notebooks
MEMORY_MB = 600  # 228 MB were measured for server and kernel of one learner; a browser takes as much again and more
SYNCED = ("onedrive", "dropbox", "google drive", "googledrive", "icloud", "nextcloud", "owncloud", "seafile")
BROWSERS = (
    "firefox", "firefox-esr", "chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "microsoft-edge",
    "brave-browser", "vivaldi", "opera", "epiphany", "falkon", "konqueror",
)  # fmt: skip
COMPUTE = """from jupyter_client.manager import run_kernel
with run_kernel(kernel_name="python3") as client:
    client.execute_interactive("print(6 * 7)", timeout=20)"""


@dataclass(frozen=True)
class Line:
    """What came out for one thing.

    Attributes
    ----------
    what : str, the thing
    state : str, FIT; LOOK: the course runs, and something waits to be done; UNFIT: it does not run
    found : str, what is there
    todo : str, what to do; empty where nothing is
    """

    what: str
    state: str
    found: str
    todo: str = ""


def examine(checks: Iterable[tuple[str, Callable[[], Line]]], seconds: float = SECONDS) -> Iterator[Line]:
    """The line of each check, in their order; all of them run at once.

    Parameters
    ----------
    checks : iterable of (what, function that gives a Line)
    seconds : float
        So long all of them may take. A driver that hangs costs its own line only.
    """
    until = time.monotonic() + seconds
    running = [(what, *_begin(what, check)) for what, check in checks]
    for what, thread, told in running:
        thread.join(max(0.0, until - time.monotonic()))
        yield told[0] if told else Line(what, LOOK, f"gave no answer within {seconds:g} s", "Unplug it, or restart the computer.")  # fmt: skip


def _begin(what, check):
    told: list[Line] = []

    def look():
        try:
            told.append(check())
        except Exception as error:  # of a driver, say: it costs its own line only
            told.append(Line(what, LOOK, f"could not be looked at: {type(error).__name__}: {error}", "Unplug it, or restart the computer."))  # fmt: skip

    thread = threading.Thread(target=look, daemon=True)
    thread.start()
    return thread, told


def all_checks(folder: Path) -> list[tuple[str, Callable[[], Line]]]:
    """What :func:`examine` is to look at, for a learner whose work lies in ``folder``."""
    return [
        ("Python", python),
        ("notebooks", notebooks),
        ("memory", memory),
        ("disk", lambda: disk(folder)),
        ("browser", browser),
        ("serial port", serial_ports),
        ("cameras", cameras),
    ]


def python(packages: Sequence[str] = PACKAGES) -> Line:
    """Whether the packages load here, tried in another process: one that crashes tells so, and costs nothing else."""
    found = f"{platform.python_version()} on {platform.system()} {platform.machine()}"
    code = f"import importlib\nfor name in {tuple(packages)!r}: importlib.import_module(name)"
    ended, said = _run([sys.executable, "-c", code])
    if ended == 0:
        return Line("Python", FIT, f"{found}; all packages load")
    if ended is None:
        return Line("Python", LOOK, f"{found}; the packages take very long to load", "Let the virus scanner pass over the kit's folder.")  # fmt: skip
    if ended in (-signal.SIGILL, 0xC000001D):  # the same in Windows' words
        return Line("Python", UNFIT, f"{found}; this processor is too old for a package", "Use a computer of the last twelve years.")  # fmt: skip
    why = said.strip().splitlines()[-1] if said.strip() else f"it ended with {ended}"
    return Line("Python", UNFIT, f"{found}; a package does not load: {why}", "Delete the folder .venv of the kit and start lab.py again.")  # fmt: skip


def notebooks(code: str = COMPUTE) -> Line:
    """Whether this computer may talk to itself, as browser and notebook do, and a kernel computes."""
    try:
        _talk_to_itself()
    except OSError as error:
        return Line("notebooks", UNFIT, f"this computer may not talk to itself: {error.strerror or error}", "Let firewall and virus scanner allow Python on 127.0.0.1.")  # fmt: skip
    began = time.monotonic()
    ended, said = _run([sys.executable, "-c", code])
    if ended == 0 and "42" in said:
        return Line("notebooks", FIT, f"a kernel starts and computes, {time.monotonic() - began:.0f} s")
    why = "in 20 s" if ended is None else said.strip().splitlines()[-1] if said.strip() else f"it ended with {ended}"
    return Line("notebooks", UNFIT, f"no kernel answers: {why}", "Let the virus scanner pass over the kit's folder; else delete .venv and start lab.py again.")  # fmt: skip


def _talk_to_itself():
    with socket.create_server(("127.0.0.1", 0)) as server:
        server.settimeout(5)
        with socket.create_connection(server.getsockname(), timeout=5) as out, server.accept()[0] as into:
            into.settimeout(5)
            out.sendall(b"?")
            if into.recv(1) != b"?":
                raise OSError("what was sent did not come")


def _run(command, seconds=20.0):
    """How a command ended, and what it said; None for one that does not end."""
    try:
        done = subprocess.run(
            command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=seconds
        )
    except subprocess.TimeoutExpired:
        return None, ""
    return done.returncode, done.stdout.decode("utf-8", "replace")


def memory(available: int | None = None) -> Line:
    """Whether there is room for one learner. ``available`` : int, bytes; asked of the system where none is given."""
    import psutil

    mb = (psutil.virtual_memory().available if available is None else available) // 2**20
    if mb >= MEMORY_MB:
        return Line("memory", FIT, f"{mb} MB free")
    return Line("memory", LOOK, f"{mb} MB free; a lesson and its browser take {MEMORY_MB} MB", "Close other programs and other tabs of the browser.")  # fmt: skip


def disk(folder: Path) -> Line:
    """Whether a learner's folder can be written to and has room."""
    there = next(place for place in (folder, *folder.parents) if place.exists())
    try:
        with tempfile.NamedTemporaryFile(prefix=".ready-", dir=there, delete=False) as file:
            file.write(bytes(2**20))
        os.replace(file.name, file.name + "-moved")
        os.remove(file.name + "-moved")
        mb = shutil.disk_usage(there).free // 2**20
    except OSError as error:
        return Line("disk", UNFIT, f"{there} cannot be written to: {error.strerror or error}", "Name another folder with the environment variable STEREO_LAB_WORK.")  # fmt: skip
    if mb < DISK_MB:
        return Line("disk", UNFIT, f"{mb} MB free at {there}", f"Free some space: {DISK_MB} MB are needed.")
    if any(word in part.lower() for part in folder.parts for word in SYNCED):
        return Line("disk", LOOK, f"{mb} MB free; {folder} is copied to a cloud", "Work at one computer at a time, and let the copying end before you go to another.")  # fmt: skip
    return Line("disk", FIT, f"{mb} MB free at {there}; a file was written, renamed and deleted")


def browser(names: Sequence[str] = BROWSERS) -> Line:
    """Which browser will open. JupyterLab works with Firefox, Chrome, Edge and Safari as they are now."""
    if sys.platform in ("win32", "darwin"):
        with contextlib.suppress(webbrowser.Error):
            webbrowser.get()
            return Line("browser", FIT, "the one that this computer opens pages with")
    paths = [path for name in names if (path := shutil.which(name))]
    if not paths:
        return Line("browser", UNFIT, "none is installed", "Install Firefox, Chrome or Edge.")
    ended, said = _run([paths[0], "--version"], 5.0)
    found = said.strip().splitlines()[-1] if ended == 0 and said.strip() else Path(paths[0]).name
    if not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        return Line("browser", LOOK, f"{found}; no screen hangs on this computer", "Start with: python3 lab.py start 00 -- --no-browser, and open the address that it prints.")  # fmt: skip
    return Line("browser", FIT, found)


def serial_ports(list_ports: Callable[[], Sequence[str]] | None = None, windows: bool = os.name == "nt") -> Line:
    """Whether the USB ports of an arm can be opened. An Arduino restarts when its port is opened."""
    ports = list((list_ports or _usb_ports)())
    if not ports:
        return Line("serial port", FIT, "none on USB; virtual://arm is always there")
    troubles = [trouble for name in ports if (trouble := _port_trouble(name, windows))]
    if troubles:
        return Line("serial port", LOOK, "; ".join(found for found, _ in troubles), " ".join(dict.fromkeys(todo for _, todo in troubles)))  # fmt: skip
    return Line("serial port", FIT, ", ".join(ports))


def _usb_ports():
    """Ports on USB; one of Bluetooth takes long to open, and no arm hangs on it."""
    from serial.tools.list_ports import comports

    return sorted(port.device for port in comports() if port.vid is not None)


def _port_trouble(name, windows):
    """(what is wrong, what to do), or None."""
    import serial

    try:
        serial.Serial(name, exclusive=None if windows else True, timeout=0).close()
    except (OSError, ValueError) as error:
        denied = getattr(error, "errno", None) == errno.EACCES or "PermissionError" in str(error)
        if denied and not windows:
            return f"{name}: no permission", "Run: sudo usermod -aG dialout $USER, then log out and in again."
        if denied or getattr(error, "errno", None) in (errno.EBUSY, errno.EAGAIN) or "lock" in str(error):
            return f"{name}: busy{holder_of(name)}", "Close the Arduino program and other notebooks that hold the arm."
        return f"{name}: does not open ({error})", "Unplug it and plug it in again."
    return None


def cameras(
    devices: Sequence[Device] | None = None,
    find: Callable[..., Sequence[Any]] | None = None,
    system: str = sys.platform,
) -> Line:
    """Which cameras give pictures, and why the others do not.

    Parameters
    ----------
    devices : sequence of Device, those that the system knows of; Linux tells them
    find : function, in place of :func:`stereo_lab.capture.find_cameras`
    system : str, as ``sys.platform``
    """
    known = list(video_devices() if devices is None else devices)
    if system.startswith("linux") and not known:
        return _cameras([], [])
    from stereo_lab.capture import find_cameras

    most = max((device.number for device in known), default=3) + 1
    found = list((find or find_cameras)(most=most, look_s=0.5, patience_s=4.0))
    good = [camera for camera in found if camera.sizes]
    opened = {camera.number for camera in good}
    troubles = [_camera_trouble(device) for device in known if device.number not in opened]
    if not known:  # a system that tells nothing beforehand
        troubles = [
            (f"camera {camera.number}: opens and gives no picture", _ALLOWED.get(system, "Unplug it and plug it in again."))
            for camera in found if camera not in good
        ]  # fmt: skip
    return _cameras(good, troubles)


_ALLOWED = {
    "win32": "Close video calls; and Settings, Privacy, Camera: let desktop apps use the camera.",
    "darwin": "Close video calls; and System Settings, Privacy & Security, Camera: allow the terminal.",
}


def _camera_trouble(device):
    """(what is wrong, what to do) with a camera that gives no picture, on Linux."""
    name = f"camera {device.number}" + (f" ({device.name})" if device.name else "")
    if device.denied:
        return f"{name}: no permission", "Run: sudo usermod -aG video $USER, then log out and in again."
    holder = holder_of(device.path)
    if holder:
        return f"{name}: busy{holder}", "Close that program, or the video call in the browser."
    return f"{name}: gives no picture", "Close video calls and other notebooks; else unplug it and plug it in again."


def _cameras(good, troubles):
    given = [f"camera {camera.number}: {camera.rate_hz:.0f} pictures a second" for camera in good]
    if troubles:
        found = "; ".join([*given, *(found for found, _ in troubles)])
        return Line("cameras", LOOK, found, " ".join(dict.fromkeys(todo for _, todo in troubles)))
    if len(good) < 2:
        return Line("cameras", FIT, "; ".join([*given, "fewer than two" if good else "none"]) + ": the recordings take their place")  # fmt: skip
    return Line("cameras", FIT, "; ".join(given))

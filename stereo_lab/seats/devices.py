"""What Linux tells of its devices: which are cameras, who may open them, which program has one."""

from __future__ import annotations

import contextlib
import os
import struct
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

SYSTEM, FOLDER, PROCESSES = Path("/sys/class/video4linux"), Path("/dev"), Path("/proc")
QUERY_CAPABILITIES = 0x80685600  # VIDIOC_QUERYCAP of linux/videodev2.h
CAPABILITIES = struct.Struct("16s32s32sIII12x")  # driver, card, bus, version, of the whole device, of this node
OF_NODE, CAPTURES = 0x80000000, 0x00000001  # V4L2_CAP_DEVICE_CAPS, V4L2_CAP_VIDEO_CAPTURE


@dataclass(frozen=True)
class Device:
    """A camera that the system knows of.

    Attributes
    ----------
    number : int, as OpenCV counts it
    path : path
    name : str, as the system calls it; may be empty
    denied : bool, whether this user may not open it
    """

    number: int
    path: Path
    name: str
    denied: bool


def video_devices(
    system: Path = SYSTEM, folder: Path = FOLDER, capabilities: Callable[[int], bytes] | None = None
) -> list[Device]:
    """The cameras that Linux knows of, in order; none on other systems.

    A webcam has a second device file, for data about the pictures. It is left out.

    Parameters
    ----------
    system, folder : path, where the system describes its cameras, and where their device files lie
    capabilities : function of a file descriptor, in place of asking the driver
    """
    numbers = sorted(int(p.name[5:]) for p in system.glob("video*") if p.name[5:].isdecimal())
    devices = [_look(number, system, folder, capabilities or _capabilities) for number in numbers]
    return [device for device in devices if device is not None]


def _look(number, system, folder, capabilities):
    path, name = folder / f"video{number}", ""
    with contextlib.suppress(OSError):
        name = (system / path.name / "name").read_text(encoding="utf-8", errors="replace").strip()
    try:
        descriptor = os.open(path, os.O_RDWR | os.O_NONBLOCK)
    except PermissionError:
        return Device(number, path, name, True)
    except OSError:  # nobody asks for a camera that is going away; one that is taken shows when it is opened
        return Device(number, path, name, False)
    try:
        *_, whole, node = CAPABILITIES.unpack(capabilities(descriptor))
        captures = (node if whole & OF_NODE else whole) & CAPTURES
    except OSError:
        captures = True
    finally:
        os.close(descriptor)
    return Device(number, path, name, False) if captures else None


def _capabilities(descriptor):
    import fcntl

    return fcntl.ioctl(descriptor, QUERY_CAPABILITIES, bytes(CAPABILITIES.size))


def holder_of(path: str | Path, processes: Path = PROCESSES) -> str:
    """Which other program has a device open, as words to put behind *busy*; empty where Linux does not tell."""
    device = os.path.realpath(path)
    for process in processes.glob("[0-9]*"):
        if process.name == str(os.getpid()):
            continue
        with contextlib.suppress(OSError):
            if any(os.readlink(link) == device for link in (process / "fd").iterdir()):
                name = (process / "comm").read_text(encoding="utf-8", errors="replace").strip()
                return f", {name} has it (process {process.name})"
    return ""

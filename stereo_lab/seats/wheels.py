"""A folder with everything that computers without a network need besides Python and the kit itself.

``lab.py --offline FOLDER`` installs from it. It may serve several systems and Pythons at once: what fits all is there once.
"""

from __future__ import annotations

import platform
import subprocess
import sys
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from packaging.requirements import Requirement

from stereo_lab.common.files import read_text, write_json
from stereo_lab.common.packages import find_pip
from stereo_lab.errors import StereoLabError

MANIFEST = "wheels.json"  # lab.py reads it: for which computers, and which files of what size
INTEL_MAC = "macos-intel"
OLDEST, NEWEST = (3, 10), (3, 14)
LAST_MICRO = 99  # no Python has so many releases
GLIBC = range(5, 29)  # 2.28 has every Linux since 2019
_ON_LINUX = {
    arch: [*(f"manylinux_2_{minor}_{arch}" for minor in GLIBC), f"manylinux2014_{arch}", f"linux_{arch}"]
    for arch in ("x86_64", "aarch64")
}
SYSTEMS = {  # name: (sys_platform, os_name, platform_system, platform_machine, what wheels are named for)
    "windows": ("win32", "nt", "Windows", "AMD64", ["win_amd64"]),
    "macos": ("darwin", "posix", "Darwin", "arm64", ["macosx_14_0_arm64"]),
    "linux": ("linux", "posix", "Linux", "x86_64", _ON_LINUX["x86_64"]),
    "linux-arm": ("linux", "posix", "Linux", "aarch64", _ON_LINUX["aarch64"]),
}
REASONS = (
    (("no space left",), "the disk is full"),
    (("no matching distribution",), "a package was not found: is this computer online, and is there one for that Python?"),
    (("connection", "resolve", "network", "timed out", "unreachable"), "is this computer online, and may it download?"),
)  # fmt: skip


@dataclass(frozen=True)
class Target:
    """A kind of computer.

    Attributes
    ----------
    system : str, one of SYSTEMS
    python : str, such as "3.12"
    """

    system: str
    python: str

    def __post_init__(self) -> None:
        """Refuse what there is not.

        Raises
        ------
        StereoLabError
            If the kit does not run there.
        """
        if self.system == INTEL_MAC:
            raise StereoLabError(
                "Not every package is made for Macs with an Intel processor any more: set them up with a network."
            )
        if self.system not in SYSTEMS:
            raise StereoLabError(f"There is no system {self.system!r}. Choose among {', '.join(SYSTEMS)}.")
        known = [f"{OLDEST[0]}.{minor}" for minor in range(OLDEST[1], NEWEST[1] + 1)]
        if self.python not in known:
            raise StereoLabError(f"Expected a Python among {', '.join(known)}, got {self.python!r}.")

    @classmethod
    def here(cls) -> Target:
        """The kind that this computer is."""
        return cls(system_here(), f"{sys.version_info[0]}.{sys.version_info[1]}")


def system_here(name: str = sys.platform, machine: str = "") -> str:
    """What this system is called in SYSTEMS; lab.py has the same rule."""
    machine = machine or platform.machine()
    arm = machine.lower() in ("arm64", "aarch64")
    if name == "darwin":
        return "macos" if arm else INTEL_MAC
    return "windows" if name == "win32" else "linux-arm" if arm else "linux"


def requirements_for(environment: str, target: Target, micro: int = 0) -> list[str]:
    """The lines of environment.txt that count for a kind of computer, without their conditions.

    Parameters
    ----------
    environment : str, the text of environment.txt
    target : Target
    micro : int, the last number of its Python's version: some conditions ask for it
    """
    system, os_name, name, machine, _ = SYSTEMS[target.system]
    there = {
        "sys_platform": system, "os_name": os_name, "platform_system": name, "platform_machine": machine,
        "python_version": target.python, "python_full_version": f"{target.python}.{micro}",
        "implementation_name": "cpython", "platform_python_implementation": "CPython",
    }  # fmt: skip
    lines = [line.partition("#")[0].strip() for line in environment.splitlines()]
    wanted = [Requirement(line) for line in lines if line]
    return [f"{r.name}{r.specifier}" for r in wanted if r.marker is None or r.marker.evaluate(there)]


def fill(
    out: Path,
    environment: Path,
    targets: Sequence[Target],
    progress: Callable[[str, int, int], object] = lambda *_: None,
) -> dict[str, int]:
    """Download what the targets need into a folder. What is there already is not fetched again.

    Parameters
    ----------
    out : path, a folder; made where there is none
    environment : path of environment.txt
    targets : sequence of Target
    progress : function of (step, done, total)

    Returns
    -------
    dict of str to int
        Names of the files in the folder, with their sizes in bytes.

    Raises
    ------
    StereoLabError
        If something cannot be fetched or written.
    """
    if out.exists() and not out.is_dir():
        raise StereoLabError(f"Expected a folder to fill, and {out} is a file. Name another one.")
    text, pip = read_text(environment), find_pip()
    wanted = [(target, micro, lines) for target in targets for micro, lines in _by_micro(text, target)]
    total, done = sum(len(lines) for *_, lines in wanted), 0
    for target, micro, lines in wanted:
        for name in _download(pip, out, target, micro, lines):
            done += 1
            progress(name, min(done, total), total)
    sizes = {path.name: path.stat().st_size for path in sorted(out.glob("*.whl"))}
    made_for = [[target.system, target.python] for target in targets]
    write_json(out / MANIFEST, {"format": 1, "made_for": made_for, "files": sizes})
    return sizes


def _by_micro(environment, target):
    """What the first of a Python's releases needs, and what the latest needs besides: which one it is, nobody tells."""
    first, last = (requirements_for(environment, target, micro) for micro in (0, LAST_MICRO))
    more = [line for line in last if line not in first]
    return [(0, first), *([(LAST_MICRO, more)] if more else [])]


def _download(pip, out, target, micro, lines):
    """Run pip; the names of the packages as it comes to them."""
    with tempfile.TemporaryDirectory() as folder:
        listed = Path(folder) / "wanted.txt"
        listed.write_text("\n".join(lines) + "\n", encoding="utf-8")
        command = [*pip, "download", "--disable-pip-version-check", "--no-input", "--no-deps", "--only-binary=:all:"]
        command += ["--python-version", f"{target.python}.{micro}", "--implementation", "cp"]
        command += [word for name in SYSTEMS[target.system][-1] for word in ("--platform", name)]
        command += ["--dest", str(out), "--requirement", str(listed)]
        said = []
        with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, encoding="utf-8", errors="replace") as running:  # fmt: skip
            for line in running.stdout or ():
                said.append(line.strip())
                if line.startswith("Collecting "):
                    yield line.split()[1]
    if running.returncode:
        low = "\n".join(said).lower()
        why = next((why for signs, why in REASONS if any(sign in low for sign in signs)), "pip gave up")
        last = next((line for line in reversed(said) if line.startswith("ERROR")), said[-1] if said else "")
        if last.endswith("Exception:"):  # the head of a traceback
            last = next((line for line in reversed(said) if line), "")
        told = f"{why} ({last})" if last else f"{why}."
        raise StereoLabError(f"Cannot fetch all for {target.system}, Python {target.python}: {told} Then run it again: it goes on.")  # fmt: skip

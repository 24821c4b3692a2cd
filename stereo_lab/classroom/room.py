"""The room in which a notebook is run: a copy of the kit without its answers, no network, no other files, so much memory and no more."""

from __future__ import annotations

import contextlib
import os
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import psutil

import stereo_lab
from stereo_lab.errors import StereoLabError
from stereo_lab.recording.places import course

MEMORY = 1_500_000_000  # bytes that the processes of one notebook may use together; a lesson needs a third of it
ADDRESSES = 2 * MEMORY  # of which much is reserved and never touched
PROCESSES = 30  # of one notebook
SCRATCH = 300_000_000  # bytes that it may write; they lie in memory, too
WRITABLE = ("/tmp", "/desk", "/dev/shm")
PACKAGE = Path(stereo_lab.__file__).resolve().parent
START = "from stereo_lab.classroom.desk import main; main()"
LEFT_OUT = (
    "exercises",
    "classroom",
    "cli",
    "course",
    "__pycache__",
)  # the answers, this package, the commands, the lessons
BUBBLEWRAP = "bubblewrap"
NAMESPACE = "a network namespace"
NOTHING = ""


@dataclass(frozen=True)
class Room:
    """Where notebooks are run, one process for each.

    Attributes
    ----------
    folder : Path, with the kit as notebooks find it
    shut_by : str, what keeps a notebook from the network: BUBBLEWRAP (and from other files as well), NAMESPACE or NOTHING
    """

    folder: Path
    shut_by: str

    def open_desk(self, recording: Path | None = None) -> subprocess.Popen:
        """Start the process for one notebook; its standard input and output are the line to it."""
        seen = self.folder / "kit"
        inside = Path("/kit") if self.shut_by == BUBBLEWRAP else seen
        own = Path("/desk") if self.shut_by == BUBBLEWRAP else _new_folder(self.folder / "desks")
        environment = {
            **{
                name: os.environ[name]
                for name in ("PATH", "LANG", "LC_ALL", "SYSTEMROOT", "TEMP")
                if name in os.environ
            },
            "PYTHONPATH": str(inside),
            "HOME": str(own),
            "USERPROFILE": str(own),
            "IPYTHONDIR": str(own / "ipython"),
            "STEREO_LAB_HOME": str(own),
            "STEREO_LAB_WORK": str(own),
            "MPLCONFIGDIR": str(inside / "fonts"),
            "MPLBACKEND": "agg",
            "OPENBLAS_NUM_THREADS": "1",
            "OMP_NUM_THREADS": "1",
            "PYTHONDONTWRITEBYTECODE": "1",
        }
        if recording is not None:
            environment["STEREO_LAB_RECORDING"] = str(Path("/recording") if self.shut_by == BUBBLEWRAP else recording)
        try:
            return subprocess.Popen(
                [*self._shut(recording), sys.executable, "-c", START],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
                cwd=None if self.shut_by == BUBBLEWRAP else own,
                env=environment,
                start_new_session=True,
            )
        except OSError as error:
            raise StereoLabError(f"Cannot start Python for a notebook: {error.strerror}.") from None

    def _shut(self, recording):
        """The words before Python's own that shut it in."""
        if self.shut_by == NAMESPACE:
            return ["unshare", "--map-root-user", "--net", "--pid", "--fork", "--kill-child"]
        if self.shut_by == NOTHING:
            return []
        words = ["bwrap", "--unshare-all", "--die-with-parent", "--new-session", "--proc", "/proc", "--dev", "/dev"]
        for place in WRITABLE:
            words += ["--size", str(SCRATCH // len(WRITABLE)), "--tmpfs", place]
        for path in _system():
            words += (
                ["--symlink", os.readlink(path), str(path)]
                if path.is_symlink()
                else ["--ro-bind", str(path), str(path)]
            )
        for path in _installed_answers():
            words += ["--tmpfs", str(path)]
        words += [
            "--ro-bind",
            str(self.folder / "kit"),
            "/kit",
            "--ro-bind",
            str(course() / "data"),
            "/kit/stereo_lab/course/data",
        ]
        if recording is not None:
            words += ["--ro-bind", str(recording), "/recording"]
        # what bubblewrap makes of itself lies in memory, without bounds
        return [*words, "--remount-ro", "/", "--remount-ro", "/dev", "--chdir", "/desk"]


def build_room(folder: Path) -> Room:
    """Lay out the kit without its answers in an empty folder.

    Raises
    ------
    StereoLabError
        If the disk is full, or the folder cannot be written to.
    """
    kit = folder / "kit"
    try:
        package = kit / "stereo_lab"
        shutil.copytree(PACKAGE, package, ignore=shutil.ignore_patterns(*LEFT_OUT))
        for name in ("exercises", "classroom"):
            (package / name).mkdir()
        shutil.copy(PACKAGE / "classroom" / "stand_in.py", package / "exercises" / "__init__.py")
        shutil.copy(PACKAGE / "exercises" / "blank.py", package / "exercises")
        for name in ("__init__.py", "wire.py", "desk.py"):
            shutil.copy(PACKAGE / "classroom" / name, package / "classroom")
        (kit / "fonts").mkdir()
        (package / "course" / "data").mkdir(parents=True)
    except OSError as error:
        raise StereoLabError(
            f"Cannot write {error.filename or kit}: {error.strerror or error}. Free some space."
        ) from None
    _list_fonts(kit / "fonts")
    shut_by = _what_shuts(folder)
    if shut_by != BUBBLEWRAP:
        _give_data(kit / "stereo_lab" / "course" / "data")
    return Room(folder, shut_by)


def close_desk(process: subprocess.Popen) -> None:
    """End a notebook's process and all that it has started."""
    with contextlib.suppress(psutil.Error):
        for child in psutil.Process(process.pid).children(recursive=True):
            with contextlib.suppress(psutil.Error):
                child.kill()
    with contextlib.suppress(OSError):
        process.kill()
    process.wait()
    for stream in (process.stdin, process.stdout):
        with contextlib.suppress(OSError):
            if stream is not None:
                stream.close()


def too_much(process: subprocess.Popen) -> str:
    """What a notebook takes more of than it may, in words; "" where all is well."""
    try:
        whole = [psutil.Process(process.pid), *psutil.Process(process.pid).children(recursive=True)]
    except psutil.Error:
        return ""
    if len(whole) > PROCESSES:
        return f"it starts more than {PROCESSES} processes"
    memory = 0
    for one in whole:
        with contextlib.suppress(psutil.Error):
            memory += one.memory_info().rss
    return f"it takes more than {MEMORY / 1e9:g} GB of memory" if memory > MEMORY else ""


def _what_shuts(folder):
    """The best way there is to keep a notebook from the network: it is tried, because a system may have it and forbid it."""
    for shut_by in (BUBBLEWRAP, NAMESPACE):
        words = Room(folder, shut_by)._shut(None) if sys.platform == "linux" else []
        if words and shutil.which(words[0]):
            look = [*words, sys.executable, "-c", "import cv2"]  # packages may lie where it does not let Python look
            done = subprocess.run(look, capture_output=True)
            if done.returncode == 0:
                return shut_by
    return NOTHING


def _system():
    """What Python and its packages need of a Linux system, and nothing of anybody's home but that."""
    homes = [
        Path(p)
        for p in {sys.prefix, sys.base_prefix, sys.exec_prefix, str(Path(os.path.realpath(sys.executable)).parent)}
    ]
    names = ("usr", "bin", "sbin", "lib", "lib32", "lib64", "nix", "etc/fonts", "etc/ld.so.cache", "etc/alternatives")
    found = [path for path in (Path("/") / name for name in names) if path.exists()]
    homes += [path.resolve() for path in homes if path.is_symlink()]  # such a link leads to a folder of somebody's
    found += [path for path in sorted(set(homes)) if not any(other in (path, *path.parents) for other in found)]
    return [path for k, path in enumerate(found) if not any(other in path.parents for other in found[:k])]


def _installed_answers():
    """The kit's own folder where a notebook could see it: the copy without answers counts, and nothing else is found."""
    return [PACKAGE] if any(path in PACKAGE.parents for path in _system()) else []


def _list_fonts(folder):
    """Matplotlib looks for fonts once, and not in each of thirty notebooks."""
    command = [sys.executable, "-c", "import matplotlib.font_manager"]
    subprocess.run(command, env={**os.environ, "MPLCONFIGDIR": str(folder)}, capture_output=True)


def _give_data(folder):
    """The shipped recordings, by a link where the system allows one."""
    folder.rmdir()
    try:
        folder.symlink_to(course() / "data", target_is_directory=True)
    except OSError:
        shutil.copytree(course() / "data", folder)


def _new_folder(parent):
    parent.mkdir(exist_ok=True)
    k = len(list(parent.iterdir()))
    while True:
        try:
            (parent / str(k)).mkdir()
        except FileExistsError:
            k += 1
            continue
        return parent / str(k)

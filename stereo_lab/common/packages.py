"""pip: where it is, and the command that brings one more package."""

from __future__ import annotations

import importlib.util
import subprocess
import sys

from stereo_lab.errors import StereoLabError


def find_pip() -> list[str]:
    """How pip is run: that of this environment, or of the Python that it was made with.

    Raises
    ------
    StereoLabError
        If there is none.
    """
    if importlib.util.find_spec("pip"):
        return [sys.executable, "-m", "pip"]
    base = getattr(sys, "_base_executable", sys.executable)  # an environment that uv made has no pip of its own
    if subprocess.run([base, "-m", "pip", "--version"], capture_output=True).returncode == 0:
        return [base, "-m", "pip"]
    raise StereoLabError("pip is missing. Get it with: python -m ensurepip, or on Debian and Ubuntu: sudo apt install python3-pip.")  # fmt: skip


def to_install(package: str) -> str:
    """The command that brings a package to this very Python, as it is typed; or how pip comes first."""
    try:
        pip = find_pip()
    except StereoLabError as error:
        return f"{package}. But {error}"
    here = [] if pip[0] == sys.executable else ["--python", sys.executable]
    words = [*pip, *here, "install", package]
    return " ".join(f'"{word}"' if set(word) & set(" <>") else word for word in words)

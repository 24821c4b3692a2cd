"""What every test run stands on: a home of its own, notebooks compared as numbers, the shipped recordings."""

import os
import signal
import tempfile
from pathlib import Path

import pytest
from nbval.plugin import IPyNbCell

from tests.printed import Printed

ROOT = Path(__file__).resolve().parent
HOME = tempfile.TemporaryDirectory(prefix="stereo_lab_home_")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # as lab.py does, and before numpy is loaded
os.environ["STEREO_LAB_HOME"] = HOME.name  # nothing of whoever runs the tests is read or written; kernels inherit it
os.environ.pop("STEREO_LAB_WORK", None)

plain_sanitize = IPyNbCell.sanitize


def sanitize(cell, text):
    """nbval compares what this gives: a text that knows how much room its numbers have."""
    text = plain_sanitize(cell, text)
    if isinstance(text, str) and text.startswith(
        "<video "
    ):  # what it shows is also printed; its bytes are the encoder's
        return "<video>"
    if isinstance(text, str):
        text = Printed(text)
        text.room = cell.cell.metadata.get("stereo_lab", {}).get("tolerance")
    return text


IPyNbCell.sanitize = sanitize


@pytest.fixture(autouse=True)
def environment():
    """What a test leaves behind (a command sets the backend of its figures, and what ends it) reaches no test after it."""
    before = dict(os.environ)
    ends = {number: signal.getsignal(number) for number in (signal.SIGTERM, getattr(signal, "SIGHUP", signal.SIGTERM))}
    yield
    os.environ.clear()
    os.environ.update(before)
    for number, end in ends.items():
        signal.signal(number, end)


@pytest.fixture(scope="session")
def bench():
    from stereo_lab.recording import open_recording

    return open_recording(ROOT / "data" / "bench")


@pytest.fixture(scope="session")
def second_rig():
    from stereo_lab.recording import open_recording

    return open_recording(ROOT / "data" / "second_rig")


@pytest.fixture(scope="session")
def bench_calibration(bench):
    from stereo_lab.calibration import calibrate_recording

    return calibrate_recording(bench)


@pytest.fixture(scope="session")
def real_pictures():
    folder = os.environ.get("STEREO_LAB_REAL")
    if not folder or not Path(folder).is_dir():
        skip_unless_ci("STEREO_LAB_REAL names no folder of real pictures")
    return Path(folder)


def slow_after_first(*cases):
    """Cases for ``parametrize``: the first is always asked, the others where slow tests are."""
    return [cases[0], *(pytest.param(case, marks=pytest.mark.slow) for case in cases[1:])]


def skip_unless_ci(reason):
    """Skip, saying why; where STEREO_LAB_NO_SKIPS is set, a skip is a failure."""
    if os.environ.get("STEREO_LAB_NO_SKIPS"):
        pytest.fail(f"may not be skipped here: {reason}")
    pytest.skip(reason)

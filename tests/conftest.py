"""Shared fixtures: a home folder of its own, the shipped bench, and skips that CI does not accept."""

import os
from pathlib import Path

import pytest

from stereo_lab.calibration import calibrate_recording
from stereo_lab.recording import open_recording

ROOT = Path(__file__).resolve().parent.parent


@pytest.fixture(scope="session")
def bench():
    return open_recording(ROOT / "data" / "bench")


@pytest.fixture(scope="session")
def second_rig():
    return open_recording(ROOT / "data" / "second_rig")


@pytest.fixture(scope="session")
def bench_calibration(bench):
    return calibrate_recording(bench)


@pytest.fixture(scope="session")
def real_pictures():
    folder = os.environ.get("STEREO_LAB_REAL")
    if not folder or not Path(folder).is_dir():
        skip_unless_ci("STEREO_LAB_REAL names no folder of real pictures")
    return Path(folder)


def skip_unless_ci(reason):
    """Skip, saying why; where STEREO_LAB_NO_SKIPS is set, a skip is a failure."""
    if os.environ.get("STEREO_LAB_NO_SKIPS"):
        pytest.fail(f"may not be skipped here: {reason}")
    pytest.skip(reason)

"""The commands that check the kit itself: test and bench."""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile

from stereo_lab.cli.terminal import OK, Progress, write_json_option


def run_bench(options: argparse.Namespace) -> int:
    """Measure and print speed and accuracy beside the alternatives. The exit code is OK."""
    from stereo_lab.recording import open_recording
    from stereo_lab.results.benchmark import benchmark, page

    recording = open_recording(options.recording)
    with Progress() as progress:
        groups = benchmark(recording, progress)
    if options.json != "-":
        print(page(groups))
    write_json_option(options.json, {"recording": recording.name, **groups})
    return OK


def run_test(options: argparse.Namespace) -> int:
    """The package's tests and the notebooks, side by side: one is run by pytest, the other by nbval."""
    from stereo_lab.recording import REPOSITORY

    pytest = [sys.executable, "-m", "pytest", "-q"]
    package = [*pytest, "tests", *([] if options.all else ["-m", "not slow"])]
    notebooks = [*pytest, "--nbval", "--nbval-cell-timeout=120", "notebooks"]
    with tempfile.TemporaryFile() as later:
        beside = subprocess.Popen(notebooks, cwd=REPOSITORY, stdout=later, stderr=subprocess.STDOUT)
        try:
            code = subprocess.run(package, cwd=REPOSITORY).returncode
            beside.wait()
        finally:
            beside.kill()
        later.seek(0)
        print("The notebooks:", flush=True)
        sys.stdout.buffer.write(later.read())
    return code or beside.returncode  # a run that a signal ended has a code below zero

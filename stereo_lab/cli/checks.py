"""The commands that check the kit itself: test and bench."""

from __future__ import annotations

import subprocess
import sys

from stereo_lab.cli.terminal import OK, Progress, write_json_option


def run_bench(options):
    from stereo_lab.recording import open_recording
    from stereo_lab.results.benchmark import benchmark, page

    recording = open_recording(options.recording)
    with Progress() as progress:
        groups = benchmark(recording, progress)
    if options.json != "-":
        print(page(groups))
    write_json_option(options.json, {"recording": recording.name, **groups})
    return OK


def run_test(options):
    from stereo_lab.recording import REPOSITORY

    command = [sys.executable, "-m", "pytest", "-q", "--nbval", "--nbval-cell-timeout=120", "tests", "notebooks"]
    if not options.all:
        command += ["-m", "not slow"]
    return subprocess.run(command, cwd=REPOSITORY).returncode

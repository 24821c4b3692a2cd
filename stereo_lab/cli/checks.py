"""The commands that check the kit itself: test and bench."""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile

from stereo_lab.cli.options import Add, add_recording
from stereo_lab.cli.terminal import OK, Progress, write_json_option
from stereo_lab.errors import StereoLabError

COUNTING = "test_processors.py", "test_sittings.py"  # long, and never by the clock: they go beside the others


def add_to(add: Add) -> None:
    """The commands and their options."""
    bench = add(
        "bench", run_bench, "Measure speed and accuracy beside the alternatives, on this computer.",
        "bench --json bench.json",
    )  # fmt: skip
    add_recording(bench)

    test = add("test", run_test, "Run the tests: package and notebooks.", "test")
    test.add_argument("--all", action="store_true", help="everything that continuous integration runs")


def run_bench(options: argparse.Namespace) -> int:
    """Measure and print speed and accuracy beside the alternatives. The exit code is OK."""
    from stereo_lab.recording import open_recording
    from stereo_lab.results.benchmark import benchmark, page

    recording = open_recording(options.recording)
    with Progress() as progress:
        groups = benchmark(recording, progress)
    print(page(groups))
    write_json_option(options.json, {"recording": recording.name, **groups})
    return OK


def run_test(options: argparse.Namespace) -> int:
    """The package's tests by pytest and the notebooks by nbval, side by side, for two cores.

    With the notebooks go a third of the files with quick tests; of the slow ones those that only count, for others go by the clock.
    """
    from stereo_lab.recording.places import REPOSITORY, is_repository

    if not is_repository():
        raise StereoLabError(
            "The tests come with the kit's own folder, not with an installed package. Is this computer fit: stereo-lab ready."
        )
    files = sorted(str(path.relative_to(REPOSITORY)) for path in (REPOSITORY / "tests").glob("test_*.py"))
    pytest, quick = [sys.executable, "-m", "pytest", "-q"], ["-m", "not slow"]
    notebooks = [*pytest, "--nbval", "--nbval-cell-timeout=120", "notebooks"]
    if options.all:
        package = [*pytest, "tests", *(f"--ignore=tests/{name}" for name in COUNTING)]
        notebooks += [f"tests/{name}" for name in COUNTING]
    else:
        package = [*pytest, *quick, *(name for k, name in enumerate(files) if k % 3)]
        notebooks += [*quick, *files[::3]]
    with tempfile.TemporaryFile() as later:
        beside = subprocess.Popen(notebooks, cwd=REPOSITORY, stdout=later, stderr=subprocess.STDOUT)
        try:
            code = subprocess.run(package, cwd=REPOSITORY).returncode
            beside.wait()
        finally:
            beside.kill()
        later.seek(0)
        print("The notebooks, and the rest of the tests:", flush=True)
        sys.stdout.buffer.write(later.read())
    return code or beside.returncode  # a run that a signal ended has a code below zero

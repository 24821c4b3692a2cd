"""The commands for a teacher who uses other programs: export-nbgrader."""

from __future__ import annotations

import argparse
from pathlib import Path

from stereo_lab.cli.terminal import OK


def run_export_nbgrader(options: argparse.Namespace) -> int:
    """Write the course as assignments of nbgrader. The exit code is OK."""
    from stereo_lab.instructor import export_nbgrader
    from stereo_lab.recording import open_recording
    from stereo_lab.recording.places import course

    points = export_nbgrader(course() / "notebooks", Path(options.out), open_recording("bench"))
    for name, count in points.items():
        print(f"{name:24s} {count} points")
    print(f"{len(points)} assignments lie in {options.out}. There: nbgrader generate_assignment {next(iter(points))}")
    return OK

"""The commands for a teacher who uses other programs: export-nbgrader."""

from __future__ import annotations

import argparse
from pathlib import Path

from stereo_lab.cli.options import Add
from stereo_lab.cli.terminal import OK


def add_to(add: Add) -> None:
    """The commands and their options."""
    hand_out = add(
        "export-nbgrader", run_export_nbgrader, "Write the course as assignments of nbgrader (its use needs the extra: instructor).",
        "export-nbgrader course",
    )  # fmt: skip
    hand_out.add_argument("out", metavar="OUT", help="folder to make: nbgrader's course folder")


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

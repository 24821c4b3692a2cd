"""The commands for the computers of a class: ready, pack, unpack, wheels, places."""

from __future__ import annotations

import argparse
import time
from dataclasses import asdict
from pathlib import Path

from stereo_lab.cli.course import if_new, work_folder
from stereo_lab.cli.options import Add, add_json, add_name
from stereo_lab.cli.terminal import OK, WANTING, Progress, me, whose, write_json_option


def add_to(add: Add) -> None:
    """The commands and their options."""
    ready = add(
        "ready",
        run_ready,
        "Say, in half a minute, whether this computer is fit for the course, and what to do.",
        "ready",
    )
    add_json(ready)
    add_name(ready)

    pack = add(
        "pack",
        run_pack,
        "Write your folder, work and progress, into one file, for another computer.",
        "pack stick/ada.zip",
    )
    pack.add_argument("file", nargs="?", metavar="FILE", help="to write (default: the folder's name and the time)")
    add_name(pack)

    unpack = add(
        "unpack",
        run_unpack,
        "Bring what pack wrote into your folder; what lies there and is different is kept.",
        "unpack stick/ada.zip",
    )
    unpack.add_argument("file", metavar="FILE", help="what pack wrote (.zip)")
    add_name(unpack)

    wheels = add(
        "wheels", run_wheels, "Make a folder from which lab.py --offline sets up computers without a network.",
        "wheels stick/wheels --system windows macos --python 3.12",
    )  # fmt: skip
    wheels.add_argument("out", metavar="OUT", help="the folder; what is in it already is not fetched again")
    wheels.add_argument("--system", nargs="+", metavar="NAME", help="windows, macos, linux, linux-arm (this one)")
    wheels.add_argument("--python", nargs="+", metavar="3.x", help="the Python of those computers (this one's)")
    add_json(wheels)

    places = add("places", run_places, "Say where lessons, recordings, your work and everything else lies.", "places")
    add_json(places)
    add_name(places)


def run_ready(options: argparse.Namespace) -> int:
    """Print a line for each thing that the course needs. WANTING where one is missing without which it does not run."""
    from stereo_lab.seats.ready import UNFIT, all_checks, examine

    lines = []
    for line in examine(all_checks(work_folder(options.name))):
        lines.append(line)
        print(f"{line.state:5s}{line.what:12s} {line.found}", flush=True)
        if line.todo:
            print(f"{'':18s}-> {line.todo}", flush=True)
    write_json_option(options.json, {"lines": [asdict(line) for line in lines]})
    return WANTING if any(line.state == UNFIT for line in lines) else OK


def run_pack(options: argparse.Namespace) -> int:
    """Write a learner's folder into one file. The exit code is OK."""
    from stereo_lab.common.files import typed
    from stereo_lab.seats.moving import pack

    folder = work_folder(options.name)
    out = Path(options.file or f"{folder.name}_{time.strftime('%Y-%m-%d_%H-%M')}.zip")
    count, left_out = pack(folder, out)
    print(
        f"{out}: {count} file{'s' * (count != 1)} of {folder}, {out.stat().st_size / 1e6:.1f} MB. What is not saved yet is not in it."
    )
    for name in left_out:
        print(f"Left out, for another system would not take it: {name}")
    print(f"On the other computer: {me()} unpack {typed(out.name)}{whose(options.name)}")
    return OK


def run_unpack(options: argparse.Namespace) -> int:
    """Bring a packed folder into the learner's own. The exit code is OK."""
    from stereo_lab.seats.moving import unpack

    folder = work_folder(options.name)
    new = if_new(folder)
    done = unpack(Path(options.file), folder)
    if new:
        print(new)
    print(f"{folder}: {len(done.brought)} file{'s' * (len(done.brought) != 1)} brought.")
    for name, kept in done.kept:
        print(f"{name} was different here; what you had is now {kept}.")
    for name in done.left:
        print(f"{name} stays as it is here: nothing was done in the one that was packed.")
    if done.code_names:
        here, packed = done.code_names
        print(
            f"The code name here stays {here}; that of the pack is {packed}. Whose work is it? See that --name is right."
        )
    return OK


def run_wheels(options: argparse.Namespace) -> int:
    """Make a folder from which computers without a network are set up. The exit code is OK."""
    from stereo_lab.recording.places import course
    from stereo_lab.seats.wheels import Target, fill

    here = Target.here()
    systems, pythons = options.system or [here.system], options.python or [here.python]
    targets = [Target(system, python) for system in systems for python in pythons]
    out = Path(options.out)
    with Progress() as progress:
        sizes = fill(out, course() / "environment.txt", targets, progress)
    told = ", ".join(f"Python {target.python} on {target.system}" for target in targets)
    print(f"{out}: {len(sizes)} files, {sum(sizes.values()) / 1e6:.0f} MB, for {told}.")
    print("Copy this folder and the kit to a stick. On each computer, in the kit's folder:")
    print(f"python3 lab.py --offline PATH/TO/{out.name}      (on Windows: py lab.py …)")
    write_json_option(options.json, {"folder": str(out), "files": sizes, "for": [asdict(target) for target in targets]})
    return OK


def run_places(options: argparse.Namespace) -> int:
    """Print where everything lies that the course reads or writes. The exit code is OK."""
    from stereo_lab.common.files import user_folder
    from stereo_lab.recording.places import course, known, shelves

    work = work_folder(options.name)
    places = {
        "lessons": course() / "notebooks", "for the teacher": course() / "notebooks" / "instructor",
        **{f"recordings {k}": shelf for k, shelf in enumerate(shelves(), 1)},
        "your work": work, "calibrations": user_folder() / "calibrations",
    }  # fmt: skip
    for what, path in places.items():
        print(f"{what:16s} {path}{'' if path.exists() else '   (not there)'}")
    print(f"{'found':16s} {', '.join(known()) or 'no recording'}")
    write_json_option(options.json, {"places": {k: str(v) for k, v in places.items()}, "recordings": known()})
    return OK

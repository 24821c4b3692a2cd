"""Whose a notebook is, which lesson and from when, as folders and files are named."""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path

from stereo_lab.classroom.wire import legible
from stereo_lab.exercises import LESSONS
from stereo_lab.recording.places import course
from stereo_lab.work import KEPT_BESIDE

HANDED_IN = re.compile(r"_(\d{4}-\d\d-\d\d)_(\d\d)-(\d\d)-(\d\d)$")  # the end of the name of a file of hand-in
# What systems and browsers add to the name of a second file: "02_detection_ada (1)", "02_detection_ada - Kopie", "Copy of …"
COPY = re.compile(r"^(Copy of|Kopie von|Copie de) |( - (Copy|Kopie|Copie)|-Copy\d+)?( ?\(\d+\))?$")

Parts = tuple[str, ...]  # of a path: its folders, and the name that stands in the file's own


def by_folders(files: Iterable[Path], folder: Path, only_folders: bool = False) -> dict[Path, str]:
    """What a learner is called whose notebooks lie in a folder: ada/03.ipynb, 10a/ada/03.ipynb, 10a/03_world_coordinates_ada.ipynb.

    A folder that holds a class gives its name to no learner; of several such folders the name stands before the learner's: 10a/ada.

    Parameters
    ----------
    files : of Path
    folder : Path, with all of them in it
    only_folders : bool, whether the name of a file tells nothing

    Returns
    -------
    dict, without the notebooks that lie in no folder, and those of ``hand-in``, whose own names tell it
    """
    in_one = (path for path in files if path.parent != folder and (only_folders or not when_by_name(path)))
    parts = {path: _parts(path, folder, only_folders) for path in in_one}
    return {path: legible(name) for path, name in _learners(parts).items()}


def by_name(path: Path, lesson: str = "", learner: str = "") -> tuple[str, Parts]:
    """Lesson and learners as a file is called: 03_world_coordinates_ada.ipynb, ada-03.ipynb; both, where they are not known yet.

    A file of ``hand-in`` that cannot be read any more still tells them: 03_ada_bob_2026-10-05_12-00-00.ipynb.
    """
    stem = COPY.sub("", path.stem)
    rest = plain = KEPT_BESIDE.sub("", HANDED_IN.sub("", stem))
    found = re.search(r"(?<!\d)(\d\d)(?!\d)", rest)
    lesson = lesson or (found.group(1) if found and found.group(1) in LESSONS else "")
    if learner:
        return lesson, (learner,)
    for kits in filter(lambda kits: lesson and kits.startswith(f"{lesson}_"), _stems()):
        rest = rest.replace(kits, "")
    if lesson and found and found.group(1) == lesson:
        rest = re.sub(rf"^{lesson}[_-]|[_-]{lesson}$", "", rest)
    names = rest.strip(" _-").split("_") if HANDED_IN.search(stem) else [rest.strip(" _-")]
    return lesson, tuple(legible(name) for name in names if name) or (legible(plain),)


def when_by_name(path: Path) -> str:
    """When a file of ``hand-in`` was written, as its name tells; "" where it is called otherwise."""
    found = HANDED_IN.search(COPY.sub("", path.stem))
    return "{} {}:{}:{}".format(*found.groups()) if found else ""


def _learners(parts: dict[Path, Parts]) -> dict[Path, str]:
    named = {path: own[0] for path, own in parts.items() if len(own) == 1}
    tops: dict[str, dict[Path, Parts]] = {}
    for path, own in parts.items():
        if len(own) > 1:
            tops.setdefault(own[0], {})[path] = own[1:]
    classes = _are_classes(list(tops.values()))
    for top, inside in tops.items():
        before = top if len(tops) > 1 or not classes else ""
        below = _learners(inside) if classes else dict.fromkeys(inside, "")
        named.update({path: "/".join(filter(None, (before, name))) for path, name in below.items()})
    return named


def _are_classes(tops: list[dict[Path, Parts]]) -> bool:
    """Whether the learners lie one level down: in half of these folders, the same lesson is there from several of them.

    A folder with a lesson right in it and no name to it is a learner's, and speaks against it.
    """
    several = plain = 0
    for inside in tops:
        whose: dict[str, set[str]] = {}
        for path, own in inside.items():
            whose.setdefault(_split(path)[0], set()).add(own[0])
        several += any(len(names) > 1 for names in whose.values())
        plain += ("",) in inside.values()
    return several > plain and 2 * several >= len(tops)


def _parts(path: Path, folder: Path, only_folders: bool) -> Parts:
    return (*path.relative_to(folder).parts[:-1], "" if only_folders else _split(path)[1])


def _split(path):
    """The lesson's name in that of a file, and what stands beside it; of another file its whole name, and nothing."""
    stem = KEPT_BESIDE.sub("", COPY.sub("", path.stem))
    for kits in _stems():
        if kits in stem:
            return kits, stem.replace(kits, "").strip(" _-")
    return path.name, ""


def _stems():
    """What the kit's own notebooks are called."""
    return [path.stem for path in (course() / "notebooks").glob("[0-9][0-9]_*.ipynb")]

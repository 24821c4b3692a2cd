"""What was handed in: notebooks, as they come. Nothing in them is trusted, and nothing of them is run here."""

from __future__ import annotations

import hashlib
import json
import re
import time
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from stereo_lab.classroom.whose import by_folders, by_name, when_by_name
from stereo_lab.classroom.wire import legible
from stereo_lab.common.files import read_bytes
from stereo_lab.errors import StereoLabError
from stereo_lab.exercises import LESSONS
from stereo_lab.exercises.progress import FILE as PROGRESS
from stereo_lab.exercises.progress import HELP
from stereo_lab.exercises.seats import reworded
from stereo_lab.work import KEPT_BESIDE, KEY, PAGES, SEAT, find

LARGEST = 60_000_000  # bytes; with all its figures a lesson has a tenth
MOST_CELLS = 1_000
LAST_SEAT = 9_999
LONGEST_WORDS = 5_000  # letters of what a learner wrote between the cells
WHEN = "%Y-%m-%d %H:%M:%S"
MOST_TOGETHER = 8  # learners of one notebook


@dataclass(frozen=True)
class Cell:
    """A cell of a notebook.

    Attributes
    ----------
    id : str, "" where it has none
    code : bool
    source : str
    """

    id: str
    code: bool
    source: str


@dataclass(frozen=True)
class Paper:
    """One notebook that was handed in.

    Attributes
    ----------
    file : str, its path in the folder
    learners : tuple of str, whose it is: code names, or what its folder or its file is called
    lesson : str, "" where that cannot be told
    handed_in : str, when
    cells : tuple of Cell
    seat : int or None, of the learner's own recording
    help : dict, hints and solutions by the question's number, as the learner's computer noted them
    digest : str
    trouble : str, why it cannot be run; "" where it can
    recording : Path or None, which it opens where that is another one than the class's
    """

    file: str
    learners: tuple[str, ...]
    lesson: str
    handed_in: str
    cells: tuple[Cell, ...] = ()
    seat: int | None = None
    help: dict[int, dict[str, int]] = field(default_factory=dict)
    digest: str = ""
    trouble: str = ""
    recording: Path | None = None

    @property
    def code(self) -> list[str]:
        """The lines of its code cells."""
        return [cell.source for cell in self.cells if cell.code]


def papers_in(folder: Path, by_folder: bool = False) -> list[Paper]:
    """All notebooks in a folder and the folders in it, by name.

    ``by_folder``: the folder of a notebook and the file's date tell whose it is and when it came, whatever stands in it.

    Raises
    ------
    StereoLabError
        If there is no such folder, or no notebook in it.
    """
    if not folder.is_dir():
        raise StereoLabError(f"Expected a folder of notebooks, and {folder} is none.")
    files = sorted(
        path for path in folder.rglob("*") if path.suffix.lower() == ".ipynb" and not _left_by_a_system(path)
    )
    if not files:
        raise StereoLabError(f"There is no notebook (.ipynb) in {folder}. Collect what was handed in there first.")
    learners = by_folders(files, folder, by_folder)
    return [read_paper(path, folder, learners.get(path, ""), by_folder) for path in files]


def not_looked_at(folder: Path) -> list[str]:
    """Files that were handed in under another ending than a notebook's: 02_detection.ipynb.txt, 02_detection.html, work.zip."""
    files = (path for path in folder.rglob("*") if path.is_file() and not _left_by_a_system(path))
    names = (path.relative_to(folder) for path in files if path.suffix.lower() != ".ipynb")
    return sorted(legible(name.as_posix()) for name in names if not _of_a_work_folder(name))


def whole_work_folders(folder: Path) -> list[str]:
    """Folders with lessons in them, and below these with what was handed in: one learner under two names."""
    handed_in = {path.parent.parent for path in folder.rglob("handed_in/*.ipynb")} - {folder}
    return sorted(legible(path.relative_to(folder).as_posix()) for path in handed_in if any(path.glob("*.ipynb")))


def _of_a_work_folder(name):
    """What the kit itself lays beside the lessons of a learner."""
    kits = {PROGRESS, HELP, "code_name.json", *PAGES}
    return name.name.startswith(".") or name.name in kits or bool({"answers", SEAT} & set(name.parts[:-1]))


def _left_by_a_system(path):
    """What JupyterLab, macOS and Windows lay beside the files of a person."""
    return (
        path.name.startswith("._")
        or path.name.lower() in ("thumbs.db", "desktop.ini")
        or bool({".ipynb_checkpoints", "__MACOSX"} & set(path.parts))
    )


def read_paper(path: Path, folder: Path, learner: str = "", by_folder: bool = False) -> Paper:
    """One notebook; where it cannot be read, a paper that says why. ``learner``: what the folders call whoever wrote it."""
    file = legible(path.relative_to(folder).as_posix())
    learner = learner or by_folders([path], folder, by_folder).get(path, "")
    lesson, learners = by_name(path, learner=learner)
    if path.is_symlink():  # in a zip file may be links, to the work of others or to files of the teacher's
        return Paper(file, learners, lesson, "", trouble="it is a link to another file, and none is followed")
    try:
        when = time.strftime(WHEN, time.localtime(path.stat().st_mtime))
        if not by_folder and _may_be(named := when_by_name(path)):  # a copy has the date of its copying
            when = named
        content = read_bytes(path, LARGEST)
    except (StereoLabError, OSError) as error:
        return Paper(file, learners, lesson, "", trouble=legible(str(error)))
    digest = hashlib.sha256(content).hexdigest()
    try:
        notebook = json.loads(content.decode("utf-8-sig"))
        cells = tuple(_cell(cell) for cell in notebook["cells"][:MOST_CELLS])
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
        return Paper(file, learners, lesson, when, digest=digest, trouble="it is no notebook that can be read")
    told = _told(notebook)
    if by_folder:
        told = {key: what for key, what in told.items() if key not in ("learners", "handed_in")}
    asked = _by_code(cells)
    if asked and asked != lesson and "lesson" not in told:
        lesson, learners = by_name(path, asked, learner)
    lesson = told.get("lesson") or lesson
    trouble = (
        "" if lesson else f"it cannot be told which lesson this is. Begin its name with {LESSONS[0]}_ to {LESSONS[-1]}_"
    )
    return Paper(
        file, told.get("learners") or learners, lesson, told.get("handed_in") or when, cells,
        told.get("seat"), told.get("help", {}), digest, trouble,
    )  # fmt: skip


def latest(papers: list[Paper]) -> dict[tuple[str, str], list[Paper]]:
    """For each learner and lesson what was handed in, the latest first; what ``reset`` kept comes last, whatever its date."""
    found: dict[tuple[str, str], list[Paper]] = {}
    for paper in papers:
        for learner in paper.learners:
            found.setdefault((learner, paper.lesson), []).append(paper)
    for handed_in in found.values():
        handed_in.sort(
            key=lambda paper: (not KEPT_BESIDE.search(Path(paper.file).stem), paper.handed_in, paper.file), reverse=True
        )
    return dict(sorted(found.items()))


def kit_cells(lessons: Path, lesson: str, seat: int | None = None) -> tuple[Cell, ...]:
    """The cells of the kit's own notebook of a lesson, with the numbers of a seat."""
    notebook = json.loads(read_bytes(find(lessons, lesson)).decode("utf-8"))
    cells = (_cell(cell) for cell in notebook["cells"])
    return tuple(replace(cell, source=reworded(cell.source, seat)) for cell in cells)


def written(cells: tuple[Cell, ...], kit: tuple[Cell, ...]) -> list[str]:
    """What the learner wrote between the code: cells of text that are not the kit's, and what was added to those that are."""
    ours = {cell.id: cell.source.splitlines() for cell in kit if not cell.code}
    texts, known = [], {cell.source for cell in kit if not cell.code}
    code = {cell.id for cell in kit if cell.code}
    for cell in cells:
        if cell.code or cell.id in code or cell.source in known or not cell.source.strip():
            continue
        added = cell.source
        if cell.id in ours:
            had = set(ours[cell.id])
            added = "\n".join(line for line in cell.source.splitlines() if line not in had)
        if added.strip():
            texts.append(legible(added.strip(), LONGEST_WORDS))
    return texts


def _cell(cell):
    source = cell.get("source", "")
    source = "".join(source) if isinstance(source, list) else source
    if not isinstance(source, str):
        raise TypeError("no text")
    return Cell(str(cell.get("id", ""))[:100], cell.get("cell_type") == "code", source)


def _by_code(cells):
    """The lesson whose questions the notebook asks for."""
    found = re.search(r"""questions\(\s*["'](\d\d?)["']""", "\n".join(cell.source for cell in cells if cell.code))
    lesson = found.group(1).zfill(2) if found else ""
    return lesson if lesson in LESSONS else ""


def _may_be(when):
    """Whether a moment is one, and not after tomorrow: a clock that is years ahead would hide all that is handed in later."""
    try:
        return time.mktime(time.strptime(when, WHEN)) < time.time() + 24 * 3600
    except (ValueError, OverflowError):
        return False


def _told(notebook: Any) -> dict[str, Any]:
    """What ``stereo-lab hand-in`` wrote into a notebook, as far as it is what it should be."""
    metadata = notebook.get("metadata")
    told = metadata.get(KEY) if isinstance(metadata, dict) else None
    if not isinstance(told, dict):
        return {}
    out: dict[str, Any] = {}
    names = told.get("learners")
    if isinstance(names, list) and names and all(isinstance(n, str) and re.fullmatch(r"[\w-]{1,40}", n) for n in names):
        out["learners"] = tuple(dict.fromkeys(names[:MOST_TOGETHER]))
    if told.get("lesson") in LESSONS:
        out["lesson"] = told["lesson"]
    when = told.get("handed_in")
    if isinstance(when, str) and _may_be(when):
        out["handed_in"] = when
    if type(told.get("seat")) is int and 0 <= told["seat"] <= LAST_SEAT:
        out["seat"] = told["seat"]
    if isinstance(told.get("help"), dict):
        out["help"] = {
            int(k): {w: min(max(n, 0), 99) for w, n in v.items() if w in ("hint", "solution") and type(n) is int}
            for k, v in told["help"].items()
            if str(k).isdecimal() and len(str(k)) < 3 and isinstance(v, dict)
        }
    return out

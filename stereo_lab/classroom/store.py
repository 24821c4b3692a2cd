"""What is finished of a grading, in a file: rows, time limits, a teacher's marks. What was stopped goes on from there."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from stereo_lab.classroom.line import Limits
from stereo_lab.classroom.marks import Row
from stereo_lab.classroom.papers import Paper
from stereo_lab.classroom.room import NOTHING
from stereo_lab.classroom.table import Marks
from stereo_lab.common.files import read_json, write_json
from stereo_lab.errors import StereoLabError


class Store:
    """What is finished, in a file: rows, time limits, a teacher's marks."""

    def __init__(self, path: Path) -> None:
        self.path = path
        told: dict[str, Any] = read_json(path) if path.exists() else {}
        parts = [told.get(name, {}) for name in ("rows", "limits", "teacher")]
        if told.get("format", 1) != 1 or not all(isinstance(part, dict) for part in parts):
            raise StereoLabError(
                f"Expected what an earlier grading kept in {path}; this is another file. Move it away, or name another table with --csv."
            )
        self.rows: dict[str, Any] = parts[0]
        self.how: str = told.get("how", NOTHING)
        self._limits: dict[str, list[float]] = parts[1]
        self._teacher: dict[str, dict[str, str]] = parts[2]
        named = told.get("named", {})
        self._named = {str(name): str(file) for name, file in named.items()} if isinstance(named, dict) else {}
        self._renamed: dict[str, str] = {}

    def keep(self, key: str, row: Row) -> None:
        """One more row is finished."""
        self.rows[key] = row.as_json()
        self.save()

    def row(self, key: str) -> Row:
        """A finished row."""
        return Row.from_json(self.rows[key])

    def limits(self, edition: str) -> Limits | None:
        """The time limits of a lesson, where they were measured before."""
        return Limits(*self._limits[edition]) if edition in self._limits else None

    def keep_limits(self, edition: str, limits: Limits) -> None:
        """The time limits of a lesson."""
        self._limits[edition] = [limits.cell, limits.whole]
        self.save()

    def name(self, found: Mapping[tuple[str, str], Sequence[Paper]]) -> None:
        """Learners and lessons that have a row in the table, by what was handed in.

        A class folder with one learner in it is called otherwise when a second one comes: marks follow the file.
        """
        now = {f"{lesson}/{learner}": [paper.file for paper in given] for (learner, lesson), given in found.items()}
        for key, files in now.items():
            before = [name for name, file in self._named.items() if file in files and name not in now]
            if key not in self._named and len(before) == 1:
                self._renamed[before[0]] = key
        for old, new in self._renamed.items():
            del self._named[old]
            self._teacher[new] = self._teacher.pop(old, {})
        self._named |= {key: files[0] for key, files in now.items()}

    def remember(self, marks: Marks) -> list[str]:
        """A teacher's marks, also of learners whose notebook is not here today; a row of the table without any has none.

        Spreadsheets write 1 for a learner 01, and ? for a letter that they do not know. Gives a sentence for each row with marks
        that is nobody's.
        """
        nobody = []
        for (learner, lesson), given in marks.items():
            key, marked = f"{lesson}/{learner}", {str(k): mark for k, mark in given.items()}
            key = self._renamed.get(key, key)
            if key not in self._named.keys() | self._teacher.keys():
                meant = [name for name in self._named if name[:2] == lesson and _respelled(name[3:], learner)]
                if len(meant) != 1 and marked:
                    nobody.append(
                        f"The marks of {learner!r}, lesson {lesson}, are nobody's: no notebook of such a learner was graded."
                    )
                key = meant[0] if len(meant) == 1 else key
            self._teacher[key] = marked
        self.save()
        return nobody

    def teacher(self, learner: str, lesson: str) -> dict[int, str]:
        """What a teacher wrote for one learner and lesson."""
        return {int(k): mark for k, mark in self._teacher.get(f"{lesson}/{learner}", {}).items()}

    def save(self) -> None:
        """Write the file.

        Raises
        ------
        StereoLabError
            If it cannot be written.
        """
        told = {
            "rows": self.rows,
            "limits": self._limits,
            "teacher": self._teacher,
            "how": self.how,
            "named": dict(sorted(self._named.items())),
        }
        write_json(self.path, {"format": 1, **told})


def _respelled(name, read):
    """Whether a name is what a spreadsheet made another one of."""
    unknown = re.escape(read).replace(r"\?", ".").replace("\N{REPLACEMENT CHARACTER}", ".")
    return name.lstrip("0") == read or "." in unknown and re.fullmatch(unknown, name) is not None

"""What is finished of a grading, in a file: rows, time limits, a teacher's marks. What was stopped goes on from there."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from stereo_lab.classroom.line import Limits
from stereo_lab.classroom.marks import Row
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

    def remember(self, marks: Marks) -> None:
        """A teacher's marks, also of learners whose notebook is not here today; a row of the table without any has none."""
        for (learner, lesson), given in marks.items():
            self._teacher[f"{lesson}/{learner}"] = {str(k): mark for k, mark in given.items()}
        self.save()

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
        told = {"rows": self.rows, "limits": self._limits, "teacher": self._teacher, "how": self.how}
        write_json(self.path, {"format": 1, **told})

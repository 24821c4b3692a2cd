"""Files written whole or not at all, numbers read with care, and the user's own data folder."""

from __future__ import annotations

import csv
import json
import math
import os
import re
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import platformdirs

from stereo_lab.errors import RecordingError, StereoLabError


def write_whole(path: str | Path, content: str | bytes) -> None:
    """Write ``content`` (str or bytes) to a temporary file beside ``path``, then rename it.

    Raises
    ------
    StereoLabError
        If the folder cannot be written to.
    """
    path = Path(path)
    data = content.encode("utf-8") if isinstance(content, str) else content
    part = None
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        handle, part = tempfile.mkstemp(prefix=f".{path.name}.", dir=path.parent)
        with os.fdopen(handle, "wb") as file:
            file.write(data)
        os.chmod(part, 0o644)
        os.replace(part, path)
    except OSError as error:
        raise StereoLabError(
            f"Cannot write {path}: {error.strerror or error}. Choose another folder, or free some space."
        ) from error
    finally:
        if part is not None and os.path.exists(part):
            os.remove(part)


def write_json(path: str | Path, content: object) -> None:
    """Write ``content`` as indented JSON, whole or not at all."""
    write_whole(path, json.dumps(content, indent=1, ensure_ascii=False, allow_nan=False) + "\n")


def read_json(path: str | Path) -> dict[str, Any]:
    """Read a JSON object.

    Raises
    ------
    StereoLabError
        If the file is missing, is no JSON (the line is named) or holds no object.
    """
    path = Path(path)
    try:
        content = json.loads(path.read_text(encoding="utf-8-sig"))
    except FileNotFoundError:
        raise StereoLabError(f"There is no file {path}.") from None
    except (OSError, UnicodeDecodeError) as error:
        raise StereoLabError(f"Cannot read {path} as text: {error}.") from None
    except json.JSONDecodeError as error:
        raise StereoLabError(
            f"{path}, line {error.lineno}: this is not valid JSON ({error.msg}). "
            "Look for a missing comma, quote or bracket there."
        ) from None
    if not isinstance(content, dict):
        raise StereoLabError(f"{path}: expected an object in braces {{…}}, got {type(content).__name__}.")
    return content


def finite_number(value: Any, where: str) -> float:
    """A finite float from a number or a text; ``where`` names it in the error.

    Raises
    ------
    StereoLabError
        If it is text, NaN, infinite or missing.
    """
    try:
        number = float(value)
    except (TypeError, ValueError):
        raise StereoLabError(f"{where}: expected a number, got {value!r}.") from None
    if not math.isfinite(number) or isinstance(value, bool):
        raise StereoLabError(f"{where}: expected a finite number, got {value!r}.")
    return number


def user_folder() -> Path:
    """The learner's own folder for calibrations and progress (STEREO_LAB_HOME moves it)."""
    return Path(os.environ.get("STEREO_LAB_HOME") or platformdirs.user_data_dir("stereo_lab", False))


def natural_key(path: str | Path) -> list[int | str]:
    """Sort key under which ``left2`` comes before ``left10``."""
    return [int(part) if part.isdigit() else part.lower() for part in re.split(r"(\d+)", str(path))]


def read_table(path: str | Path, columns: Sequence[str]) -> list[tuple[str, dict[str, str]]]:
    """Rows of a CSV file as ``[(where, {column: text}), …]``.

    A table saved by a spreadsheet with semicolons and decimal commas is read as well.

    Raises
    ------
    RecordingError
        If the file or one of the columns is missing.
    """
    path = Path(path)
    try:
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or error
        raise RecordingError(f"Cannot read the table {path}: {reason}.") from None
    lines = text.splitlines()
    semicolons = bool(lines) and lines[0].count(";") > lines[0].count(",")
    if semicolons:
        text = text.replace(",", ".")
    rows = csv.DictReader(text.splitlines(), delimiter=";" if semicolons else ",")
    names = [name.strip() for name in rows.fieldnames or []]
    missing = [column for column in columns if column not in names]
    if missing:
        raise RecordingError(
            f"{path}, line 1: expected the columns {', '.join(columns)}; missing: {', '.join(missing)}."
        )
    rows.fieldnames = names
    filled = [(f"{path}, line {rows.line_num}", row) for row in rows]
    return [(where, row) for where, row in filled if any((v or "").strip() for v in row.values() if isinstance(v, str))]

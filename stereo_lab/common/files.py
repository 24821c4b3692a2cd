"""Files read and written with care: only plain files, of a sensible size, written whole or not at all."""

from __future__ import annotations

import contextlib
import errno
import json
import math
import os
import re
import reprlib
import stat
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import platformdirs

from stereo_lab.errors import StereoLabError

LARGEST_TEXT = 50_000_000  # bytes; the largest table or JSON file of the kit has less than a hundredth of it
UMASK = os.umask(0)  # which rights a new file of this person does not get; it is read by setting it
os.umask(UMASK)
SPREADSHEETS = b"PK\x03\x04", b"\xd0\xcf\x11\xe0"  # how .xlsx and .ods, and .xls, begin
UTF_16 = b"\xff\xfe", b"\xfe\xff"  # how such a text begins
LARGEST_FILE = 400_000_000  # bytes; more than an uncompressed picture of 100 megapixels has


def check_plain(path: str | Path) -> int:
    """Refuse what is no plain file; its size in bytes.

    A pipe or a device is not opened: reading from it could wait, or go on, for ever.

    Raises
    ------
    StereoLabError
        If there is no such file, or it is no plain file.
    """
    try:
        found = Path(path).stat()
    except (OSError, ValueError) as error:  # ValueError: a name with a zero byte in it
        raise _unreadable(path, error) from None
    if not stat.S_ISREG(found.st_mode):
        raise StereoLabError(f"Cannot read {path}: expected a plain file, got {_kind(found.st_mode)}.")
    return found.st_size


def _unreadable(path, error):
    return StereoLabError(f"Cannot read {path}: {getattr(error, 'strerror', None) or error}.")


def read_bytes(path: str | Path, largest: int = LARGEST_FILE) -> bytes:
    """Content of a plain file; see :func:`check_plain`.

    Parameters
    ----------
    path : str or path
    largest : int, bytes

    Raises
    ------
    StereoLabError
        If there is no such file, it is no plain file, it is too large or it cannot be read.
    """
    size = check_plain(path)
    if size > largest:
        raise StereoLabError(
            f"Cannot read {path}: expected {largest // 1_000_000} MB at most, got {size // 1_000_000} MB."
        )
    try:
        return Path(path).read_bytes()
    except OSError as error:
        raise _unreadable(path, error) from None


def _kind(mode):
    """What a file that is no plain file is, in words."""
    kinds = ((stat.S_ISDIR, "a folder"), (stat.S_ISFIFO, "a pipe"), (stat.S_ISSOCK, "a socket"))
    return next((words for fits, words in kinds if fits(mode)), "a device")


def read_text(path: str | Path) -> str:
    """Text of a plain UTF-8 file of at most 50 MB; see :func:`read_bytes`.

    Raises
    ------
    StereoLabError
        If it cannot be read, or is no text.
    """
    content = read_bytes(path, LARGEST_TEXT)
    if content.startswith(SPREADSHEETS):
        says = (
            f"Cannot read {path} as text: it is a spreadsheet. Open it with its own program and save it as CSV (UTF-8)."
        )
        raise StereoLabError(says, "misnamed")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        why = "it is UTF-16, a spreadsheet's Unicode text" if content.startswith(UTF_16) else error
        raise StereoLabError(f"Cannot read {path} as text: {why}. Save it as UTF-8.") from None


def check_target(path: str | Path) -> None:
    """Refuse to write over what is no plain file: renaming would take the place of a device.

    Raises
    ------
    StereoLabError
        If there is a folder, a pipe or a device at ``path``.
    """
    try:
        mode = os.stat(path).st_mode
    except (OSError, ValueError):
        return  # nothing is there yet; what else is wrong shows when it is written
    if not stat.S_ISREG(mode):
        raise StereoLabError(f"Cannot write {path}: it is {_kind(mode)}. Name a plain file.")


def write_whole(path: str | Path, content: str | bytes) -> None:
    """Write ``content`` (str or bytes) to a temporary file beside ``path``, then rename it.

    Raises
    ------
    StereoLabError
        If ``path`` is no plain file, its folder cannot be written to or the disk is full.
    """
    check_target(path)
    # What is no letter, as in names of an old disk, is written as an escape: JSON reads it back
    data = content.encode("utf-8", "backslashreplace") if isinstance(content, str) else content
    part = None
    try:
        target = Path(os.path.realpath(path))  # a link stays a link: the file it leads to is written
        if target.exists() and not os.access(target, os.W_OK):  # a new file in its place would need no leave
            raise PermissionError(errno.EACCES, "It is there, and may not be written to")
        target.parent.mkdir(parents=True, exist_ok=True)
        handle, part = tempfile.mkstemp(prefix=f".{target.name}.", dir=target.parent)
        with os.fdopen(handle, "wb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())  # some disks tell only here that they are full
        os.chmod(part, target.stat().st_mode & 0o777 if target.exists() else 0o666 & ~UMASK)
        os.replace(part, target)
    except (OSError, ValueError) as error:
        raise StereoLabError(f"Cannot write {path}: {why_not_written(error)}") from error
    finally:
        if part is not None:
            with contextlib.suppress(OSError):  # after the rename it is gone
                os.remove(part)


def why_not_written(error: Exception) -> str:
    """Why something cannot be written, and what to do."""
    reason = getattr(error, "strerror", None) or error
    code = getattr(error, "errno", None)
    if code == errno.ENOSPC:
        return f"{reason}. Free some space."
    if code in (errno.EACCES, errno.EPERM, errno.EROFS):
        return f"{reason}. Choose a folder that may be written to."
    if code in (errno.EEXIST, errno.ENOTDIR):
        return f"{reason}. A file stands where a folder is needed: choose another name."
    return f"{reason}. Choose another folder, or free some space."


@contextlib.contextmanager
def whole_folder(out: Path) -> Iterator[Path]:
    """A folder to be filled under another name, which then takes the name of ``out``: it is there whole or not at all.

    Raises
    ------
    StereoLabError
        If it cannot be written, or the disk is full.
    """
    out = Path(os.path.realpath(out))  # a link stays a link: the folder it leads to is filled
    try:
        out.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(prefix=f".{out.name}_", dir=out.parent) as made:
            part = Path(made) / out.name
            yield part
            if out.exists():  # an empty one
                out.rmdir()
            os.replace(part, out)
    except OSError as error:
        raise StereoLabError(f"Cannot write {out}: {why_not_written(error)}") from None


def write_json(path: str | Path, content: object) -> None:
    """Write ``content`` as indented JSON, whole or not at all."""
    write_whole(path, json.dumps(content, indent=1, ensure_ascii=False, allow_nan=False) + "\n")


def read_json(path: str | Path) -> dict[str, Any]:
    """Read a JSON object.

    Raises
    ------
    StereoLabError
        If the file cannot be read, is no JSON (the line is named) or holds no object.
    """
    path = Path(path)
    try:
        content = json.loads(read_text(path))
    except json.JSONDecodeError as error:
        raise StereoLabError(
            f"{path}, line {error.lineno}: this is not valid JSON ({error.msg}). {_look_for(error)}"
        ) from None
    except RecursionError:
        raise StereoLabError(f"{path}: its brackets are nested too deep to be read. Write it anew.") from None
    except ValueError as error:  # a whole number of thousands of digits
        raise StereoLabError(f"{path}: it holds a number that cannot be read ({error}).") from None
    if not isinstance(content, dict):
        raise StereoLabError(f"{path}: expected an object in braces {{…}}, got {type(content).__name__}.")
    return content


def _look_for(error):
    """What to look for where JSON ends: a comma in a number or before a bracket is what people write most."""
    before, behind = error.doc[: error.pos].rstrip(), error.doc[error.pos :].lstrip()
    if re.search(r"\d,$", before) and re.match(r"\d", behind):
        return "A number has a point, not a comma: 29.5."
    if before.endswith(",") and behind[:1] in ("]", "}") or re.match(r",\s*[\]}]", behind):
        return "Take the comma before the bracket away."
    return "Look for a missing comma, quote or bracket there."


def check_format(facts: dict[str, Any], where: str | Path, newest: int = 1) -> None:
    """Refuse a JSON file of a format that this kit does not know.

    Raises
    ------
    StereoLabError
        If ``"format"`` is missing, no whole number above zero, or newer than ``newest``.
    """
    number = facts.get("format")
    if "format" not in facts:
        raise StereoLabError(f'{where}: expected "format": {newest}, which is missing. Add "format": {newest} to it.')
    if not isinstance(number, int) or isinstance(number, bool) or number < 1:
        raise StereoLabError(f'{where}: expected "format": {newest}, got {reprlib.repr(number)}.')
    if number > newest:
        raise StereoLabError(
            f"{where}: it is of format {reprlib.repr(number)}, and this kit reads format {newest}: a newer kit made it. "
            "Update this kit."
        )


def finite_number(value: Any, where: str) -> float:
    """A finite float from a number or a text; ``where`` names it in the error.

    Raises
    ------
    StereoLabError
        If it is text, NaN, infinite or missing.
    """
    try:
        number = float(value)
    except (TypeError, ValueError, OverflowError):
        raise StereoLabError(f"{where}: expected a number{with_a_point(value)}, got {reprlib.repr(value)}.") from None
    if not math.isfinite(number) or isinstance(value, bool):
        raise StereoLabError(f"{where}: expected a finite number, got {reprlib.repr(value)}.")
    return number


def with_a_point(value: Any) -> str:
    """What to write where a number was written with a decimal comma; empty where it was not."""
    comma = re.fullmatch(r"\s*[+-]?\d+,\d+\s*", str(value))
    return f" with a decimal point, as in {value.replace(',', '.')}" if comma else ""


def user_folder() -> Path:
    """The learner's own folder for calibrations and progress (STEREO_LAB_HOME moves it)."""
    return Path(os.environ.get("STEREO_LAB_HOME") or platformdirs.user_data_dir("stereo_lab", False))


def natural_key(path: str | Path) -> list[int | str]:
    """Sort key under which ``left2`` comes before ``left10``."""
    return [int(part) if part.isdecimal() else part.lower() for part in re.split(r"(\d+)", str(path))]


def typed(path: str | Path) -> str:
    """A path as it is typed after a command: in quotes where it has blanks, or signs that a shell reads in its own way."""
    return f'"{path}"' if re.search(r"[^\w./\\:~+@%,=-]", str(path)) else str(path)

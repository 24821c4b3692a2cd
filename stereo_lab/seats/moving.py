"""A learner's folder as one file, and back again on another computer. What lies there already is never lost."""

from __future__ import annotations

import contextlib
import json
import os
import re
import shutil
import time
import zipfile
import zlib
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath
from typing import Any

from stereo_lab.classroom.handing import FILE as CODE_NAME
from stereo_lab.classroom.wire import legible
from stereo_lab.common.files import check_format, check_plain, read_bytes, why_not_written, write_json, write_whole
from stereo_lab.errors import StereoLabError
from stereo_lab.exercises.progress import FILE as PROGRESS
from stereo_lab.exercises.progress import HELP, merged
from stereo_lab.work import MARK, SEAT, as_copies, copies_of, digest_of, keep_beside, mark

LARGEST = 2_000_000_000  # bytes, unpacked: fifty recordings of one's own
MOST = 20_000  # files
PASSED_OVER = (".ipynb_checkpoints", "__pycache__")
# Signs that mean something else in a name on some system, and names that Windows keeps for itself or cuts short
NOT_EVERYWHERE = '\\:*?"<>|' + "".join(map(chr, range(32)))
NOT_ON_WINDOWS = re.compile(r"[. ]$|^(con|prn|aux|nul|com[1-9]|lpt[1-9])(\.|$)", re.IGNORECASE)
# What a zip file can tell of a time; a clock with an empty battery is before it
EARLIEST, LATEST = (1980, 1, 1, 0, 0, 0), (2107, 12, 31, 23, 59, 58)
LARGEST_MARK = 1_000_000  # bytes; it names a dozen copies


@dataclass(frozen=True)
class Unpacked:
    """What unpacking did.

    Attributes
    ----------
    brought : list of str, files that are now as in the pack
    kept : list of (str, str), a file that lay there and was different, and the name that it has now
    left : list of str, files that were changed here and not there: they stay
    code_names : list of str, where they differ: the one that work is handed in under here, which stays, and that of the pack
    """

    brought: list[str]
    kept: list[tuple[str, str]]
    left: list[str]
    code_names: list[str] = field(default_factory=list)


def pack(folder: Path, out: Path) -> tuple[int, list[str]]:
    """Write a learner's folder into one file.

    Parameters
    ----------
    folder : path, a work folder
    out : path, a file that is not there yet

    Returns
    -------
    count : int, how many of the learner's files went in
    left_out : list of str, names that another system would not take, the second of two that differ in capitals alone, and links

    Raises
    ------
    StereoLabError
        If there is no work folder or too much in it, ``out`` is there already or cannot be written.
    """
    if not (folder / MARK).is_file():
        raise StereoLabError(f"There is no work in {folder}. Name whose it is with --name, or start the course first.")
    if os.path.lexists(out):
        raise StereoLabError(f"{out} is already there, and is not written over. Name another file.")
    left_out: list[str] = []
    part = out.with_name(out.name + ".part")
    try:
        files = list(_files(folder.absolute(), (out.absolute(), part.absolute()), left_out))
        _check_amount(folder, len(files), sum(path.stat().st_size for path, _ in files))
        out.parent.mkdir(parents=True, exist_ok=True)
        with zipfile.ZipFile(part, "w", zipfile.ZIP_DEFLATED, strict_timestamps=False) as file:
            for path, name in files:
                _put(file, path, name)
        os.replace(part, out)
    except OSError as error:
        raise StereoLabError(f"Cannot write {out}: {why_not_written(error)}") from None
    finally:
        with contextlib.suppress(OSError):  # after the rename it is gone
            part.unlink()
    return len(files) - 1, left_out  # the mark is none of the learner's


def _files(folder, own, left_out):
    """Every plain file of a folder, with its name in the pack."""
    taken = set()
    for path in sorted(folder.rglob("*")):
        name = path.relative_to(folder).as_posix()
        if path in own or (path.is_dir() and not path.is_symlink()) or set(PASSED_OVER) & set(PurePosixPath(name).parts):  # fmt: skip
            continue
        legible = name.encode("utf-8", "replace").decode()  # "?" for what is no letter in any name
        strange = set(legible) & set(NOT_EVERYWHERE) or any(map(NOT_ON_WINDOWS.search, legible.split("/")))
        if strange or path.is_symlink() or not path.is_file() or name.casefold() in taken:
            left_out.append(legible)
        else:
            taken.add(name.casefold())
            yield path, name


def _check_amount(where, count, size):
    """Refuse more files or bytes than a pack may hold."""
    if count > MOST:
        raise StereoLabError(f"{where}: expected {MOST} files at most, got {count}.")
    if size > LARGEST:
        raise StereoLabError(
            f"{where}: expected {LARGEST // 1_000_000} MB at most, got {size // 1_000_000} MB. Move what is large away before you pack: recordings, films."
        )


def _put(file, path, name):
    about = zipfile.ZipInfo(name, min(max(time.localtime(path.stat().st_mtime)[:6], EARLIEST), LATEST))
    about.compress_type, about.external_attr = zipfile.ZIP_DEFLATED, 0o644 << 16
    file.writestr(about, read_bytes(path))


def unpack(packed: Path, folder: Path) -> Unpacked:
    """Bring what :func:`pack` wrote into a learner's folder.

    A file that lies there and is different is renamed, so that the time stands in its name, and so is the folder of another
    seat; a copy in which nobody has worked yet makes room. Which questions are passed, and with
    which help, is put together. A code name stays: under another one, work would be handed in as somebody else's. Nothing is written before all of the pack was read.

    Parameters
    ----------
    packed : path, a file that :func:`pack` wrote
    folder : path, made where there is none

    Raises
    ------
    StereoLabError
        If it is no such file, is damaged, holds a name that leads out of the folder, or there is no room.
    """
    check_plain(packed)
    try:
        with zipfile.ZipFile(packed) as file:
            names = _names(file, packed, folder)
            there = _read_mark(file, packed)
            _room(file, folder)
            if (bad := file.testzip()) is not None:
                raise StereoLabError(
                    f"{packed} is damaged: {bad} does not come out whole. Copy it anew, or pack again."
                )
            return _bring(file, names, there, folder)
    except (zipfile.BadZipFile, EOFError, NotImplementedError, RuntimeError, zlib.error) as error:
        raise StereoLabError(
            f"Expected a file that pack wrote, and {packed} cannot be read as one ({error}). Copy it anew, or pack again."
        ) from None


def _names(file, packed, folder):
    """The names of all files in a pack, each looked at."""
    entries = [entry for entry in file.infolist() if not entry.is_dir()]
    _check_amount(packed, len(entries), sum(entry.file_size for entry in entries))
    root = Path(os.path.realpath(folder))
    for entry in entries:
        name, kind = entry.filename, (entry.external_attr >> 16) & 0o170000
        parts = PurePosixPath(name).parts
        climbs = not parts or name.startswith("/") or ".." in parts or set(name) & set(NOT_EVERYWHERE)
        if climbs or kind not in (0, 0o100000) or not Path(os.path.realpath(folder / name)).is_relative_to(root):
            raise StereoLabError(
                f"{packed}: {name!r} leads out of the folder, or is no plain file. Nothing was unpacked."
            )
    names = [entry.filename for entry in entries]
    if len({name.casefold() for name in names}) < len(names):
        raise StereoLabError(f"{packed}: two files in it have the same name. Nothing was unpacked.")
    return names


def _read_mark(file, packed):
    """Which copies the pack holds; refuses what `pack` did not write."""
    if MARK not in file.namelist():
        raise StereoLabError(f"{packed} was not made by `stereo-lab pack`: {MARK} is not in it.")
    try:
        marked = json.loads(file.read(MARK)) if file.getinfo(MARK).file_size <= LARGEST_MARK else {}
    except ValueError:
        marked = {}
    check_format(marked if isinstance(marked, dict) else {}, f"{packed}, {MARK}")
    return as_copies(marked)


def _room(file, folder):
    size = sum(entry.file_size for entry in file.infolist())
    place = next(p for p in (folder.absolute(), *folder.absolute().parents) if p.exists())
    free = shutil.disk_usage(place).free
    if free < size + 2**20:
        raise StereoLabError(f"{size // 10**6 + 1} MB are needed at {place}, {free // 10**6} MB are free. Free some space.")  # fmt: skip


def _bring(file, names, there, folder):
    here, done = copies_of(folder), Unpacked([], [], [])
    if _is_of_another_seat(file, names, folder):  # two recordings in one folder would be neither
        done.kept.append((SEAT, keep_beside(folder / SEAT).name))
    for name in names:
        content, target = file.read(name), folder / name
        if name == MARK:
            continue
        if name in TOGETHER and target.exists():
            write_json(target, TOGETHER[name](_known(read_bytes(target)), _known(content)))
            continue
        if name == CODE_NAME and target.exists():
            names = [legible(str(_known(told).get("code_name")), 40) for told in (read_bytes(target), content)]
            done.code_names.extend(names if names[0] != names[1] else [])
            continue
        if target.exists():
            had = digest_of(read_bytes(target))
            if had == digest_of(content):
                continue
            if digest_of(content) == there.get(name):  # nobody has worked in it there
                done.left.append(name)
                continue
            if had != here.get(name):
                done.kept.append((name, keep_beside(target).name))
        write_whole(target, content)
        done.brought.append(name)
    mark(folder, {**there, **here, **{name: there[name] for name in done.brought if name in there}})
    return done


def _is_of_another_seat(file, names, folder):
    """Whether the learner's own recording here is another one than that of the pack."""
    name = f"{SEAT}/recording.json"
    return name in names and (folder / name).is_file() and read_bytes(folder / name) != file.read(name)


def _known(content):
    try:
        known = json.loads(content)
    except ValueError:
        return {}
    return known if isinstance(known, dict) else {}


def _most_help(*known: dict[str, Any]) -> dict[str, Any]:
    """Of each hint and solution the larger count; what is no count is left out."""
    most: dict[str, Any] = {}
    for lesson, number, what, times in (entry for each in known for entry in _counts(each)):
        used = most.setdefault(lesson, {}).setdefault(number, {})
        used[what] = max(used.get(what, 0), times)
    return most


def _counts(known, *names):
    """The counts in a file of help, each behind its lesson, its question and what it counts."""
    for name, told in known.items():
        if len(names) < 2 and isinstance(told, dict):
            yield from _counts(told, *names, name)
        elif len(names) == 2 and type(told) is int:
            yield (*names, name, told)


TOGETHER = {PROGRESS: merged, HELP: _most_help}  # files of two folders of which one is made

"""Pictures taken elsewhere, paired and copied into a new recording."""

from __future__ import annotations

import glob
import os
import re
import shutil
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from stereo_lab.common.files import natural_key, whole_folder, write_json
from stereo_lab.errors import RecordingError
from stereo_lab.recording.bounds import color_name
from stereo_lab.recording.model import PUT_BACK, Recording
from stereo_lab.recording.opening import open_recording
from stereo_lab.recording.pictures import PICTURES, read_image
from stereo_lab.recording.places import check_name
from stereo_lab.recording.sample import USUAL_BALL, Ball, Board, must_be_board

LIKE_PICTURES = (*PICTURES, ".bmp", ".tif", ".tiff", ".webp", ".pgm", ".ppm")  # endings of what OpenCV may read


def import_images(
    left_glob: str | Sequence[str],
    right_glob: str | Sequence[str],
    board: Board,
    out: str | Path,
    ball: Ball | None = None,
) -> Recording:
    """Make a recording from board pictures taken elsewhere.

    Parameters
    ----------
    left_glob, right_glob : str, patterns such as ``"shots/left*.jpg"``, or folders; or lists of files
    board : Board
    out : path of a folder that is not there yet (or is empty)
    ball : Ball, optional; a red one of 40 mm where it is not given

    Returns
    -------
    Recording

    Raises
    ------
    RecordingError
        If a pattern finds nothing, the halves do not match, a picture is broken, sizes differ or
        ``out`` is in use.
    """
    check_new(out)
    return _imported(_match_halves(matching(left_glob), matching(right_glob)), board, Path(out), ball)


def import_side_by_side(
    pattern: str | Sequence[str], board: Board, out: str | Path, ball: Ball | None = None
) -> Recording:
    """The same of pictures that hold both cameras' beside each other, the left one's on the left.

    Parameters
    ----------
    pattern : str, such as ``"shots/*.jpg"``, or a folder, or a list of files
    board, out, ball : as in :func:`import_images`

    Raises
    ------
    RecordingError
        As there, and where a picture's width is odd.
    """
    check_new(out)
    return _imported([(_Half(path, 0), _Half(path, 1)) for path in matching(pattern)], board, Path(out), ball)


@dataclass(frozen=True)
class _Half:
    """The left or the right half of a picture: side 0 or 1."""

    path: Path
    side: int

    def __str__(self):
        return str(self.path)

    def read(self):
        image = read_image(self.path, grey_allowed=True)
        if image.shape[1] % 2:
            raise RecordingError(f"{self.path} is {image.shape[1]} pixels wide: two halves of one width were expected.")
        return np.array_split(image, 2, axis=1)[self.side]


def check_new(out: str | Path) -> None:
    """Refuse to fill a folder that has something in it.

    Raises
    ------
    RecordingError
        If it has, or is no folder.
    """
    check_name(out)
    out = Path(out)
    if out.exists() and (not out.is_dir() or any(out.iterdir())):
        raise RecordingError(f"{out} is there already. Name a folder that is new.")


def camera_facts(title: str, size: tuple[int, int], board: Board, ball: Ball) -> dict[str, Any]:
    """What recording.json says of pictures taken elsewhere."""
    return {
        "format": 1,
        "title": title,
        "made_by": "camera",
        "image_size": list(size),
        "frame_rate": 10,
        "board": {name: value for name, value in asdict(board).items() if value is not None},
        "ball": {"color": color_name(ball.color, "ball color"), "diameter_mm": ball.diameter_mm},
    }


def _imported(halves, board, out, ball):
    """A recording of pairs of files, or of pairs of halves."""
    must_be_board(board)
    size = _one_size([picture for pair in halves for picture in pair])
    _build_whole(out, halves, camera_facts(out.name, size, board, ball or USUAL_BALL))
    return open_recording(out.resolve())


def _build_whole(out, halves, facts):
    with whole_folder(out) as part:
        for index, pair in enumerate(halves):
            for side, path in zip(("left", "right"), pair, strict=True):
                _copy_picture(path, part / "calibration" / side / f"{index:03d}")
        write_json(part / "recording.json", facts)


def _copy_picture(picture, target):
    """A file as it is where the kit reads its kind; else, and half a file, as PNG, which loses nothing."""
    target.parent.mkdir(parents=True, exist_ok=True)
    if isinstance(picture, Path) and picture.suffix.lower() in PICTURES:
        shutil.copyfile(picture, target.with_suffix(picture.suffix.lower()))
        return
    good, data = cv2.imencode(".png", _read(picture))
    if not good:
        raise RecordingError(f"{picture} cannot be written as PNG.")
    target.with_suffix(".png").write_bytes(data.tobytes())  # cv2.imwrite knows no letters beyond ASCII on Windows


def _read(picture):
    return read_image(picture, grey_allowed=True) if isinstance(picture, Path) else picture.read()


def matching(pattern: str | Path | Sequence[str]) -> list[Path]:
    """Files that match a pattern, in natural order; those of a folder, or a list of files, which a shell makes of a pattern.

    The Windows prompt hands quotes on, so one pair round it is taken off.

    Raises
    ------
    RecordingError
        If there is none.
    """
    if not isinstance(pattern, (str, Path)):
        if not (paths := [path for one in pattern for path in matching(one)]):
            raise RecordingError("Expected files, got an empty list. Does the pattern that it was made by find any?")
        return paths
    pattern = str(pattern).strip()
    if len(pattern) >= 2 and pattern[0] == pattern[-1] and pattern[0] in "\"'":
        pattern = pattern[1:-1]
    folder, name = os.path.split(os.path.expanduser(pattern))
    if os.path.isdir(os.path.join(folder, name)):
        folder, name = os.path.join(folder, name), "*"
    # A folder that is there is meant as it is written, though its name may have brackets
    folder = glob.escape(folder) if os.path.isdir(folder) else folder
    found = (
        [os.path.expanduser(pattern)]
        if os.path.isfile(os.path.expanduser(pattern))
        else glob.glob(os.path.join(folder, name))
    )
    paths = sorted((p for p in map(Path, found) if p.is_file() and not _left_by_a_system(p)), key=natural_key)
    if not paths and (folders := sorted(Path(p).name for p in found if os.path.isdir(p))):
        raise RecordingError(f"{pattern} finds no file, but folders: {', '.join(folders)}. Name one of them.")
    if not paths:
        raise RecordingError(f"No file matches {pattern!r}. Put the pattern in quotes and check the folder.")
    return paths


def _left_by_a_system(path):
    """What Windows and macOS lay beside pictures."""
    return path.name.startswith(".") or path.name.lower() in ("thumbs.db", "desktop.ini")


def _match_halves(left, right):
    """Pair by the last number in the file names where these are unique, else by order."""
    if both := set(left) & set(right):
        raise RecordingError(f"{min(both)} matches both patterns: left and right are pictures of two cameras.")

    def by_number(paths):
        found = {}
        for path in paths:
            numbers = re.findall(r"\d+", path.stem)
            found[int(numbers[-1]) if numbers else None] = path
        return found if len(found) == len(paths) and None not in found else None

    left_numbers, right_numbers = by_number(left), by_number(right)
    if left_numbers and right_numbers and set(left_numbers) & set(right_numbers):
        alone = sorted(set(left_numbers) ^ set(right_numbers))
        if alone:
            path = left_numbers.get(alone[0]) or right_numbers.get(alone[0])
            raise RecordingError(
                f"{path} has no other half: {len(left)} left and {len(right)} right pictures were found. {PUT_BACK}"
            )
        return [(left_numbers[k], right_numbers[k]) for k in sorted(left_numbers)]
    if len(left) != len(right):
        other = next((path for path in (*left, *right) if path.suffix.lower() not in LIKE_PICTURES), None)
        among = f" Among them is {other.name}, which is no picture by its ending." if other else ""
        raise RecordingError(
            f"{len(left)} left and {len(right)} right pictures were found: each needs its other half.{among} {PUT_BACK}"
        )
    return list(zip(left, right, strict=True))


def _one_size(paths):
    sizes = {path: _read(path).shape[1::-1] for path in paths}
    first = sizes[paths[0]]
    for path, size in sizes.items():
        if size != first:
            raise RecordingError(
                f"{path} is {size[0]}x{size[1]} pixels and {paths[0]} is {first[0]}x{first[1]}: "
                "all pictures of a recording have one size. Set both cameras to one size and take them again, or leave those of the other size out."
            )
    return first

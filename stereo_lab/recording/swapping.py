"""Left and right exchanged, for a recording whose cameras were named the wrong way round."""

from __future__ import annotations

import os

from stereo_lab.errors import RecordingError
from stereo_lab.recording.model import Recording


def swap_sides(*recordings: Recording) -> list[str]:
    """Rename the folders ``left`` and ``right`` of every set that has both into each other: in all recordings, or in none.

    Returns
    -------
    list of str
        Names of the sets that have pictures of one camera alone, and so stay as they are.

    Raises
    ------
    RecordingError
        If one is a rendered recording, whose truth names the sides, or a folder cannot be renamed; then all
        folders are as they were before.
    """
    for recording in recordings:
        if recording.truth:
            raise RecordingError(
                f"{recording.path} brings truth.json, which names the sides: its folders stay as they are. Where they were exchanged by hand, exchange them back by hand."
            )
    sets = [recording.path / name for recording in recordings for name in recording.sets]
    both = [folder for folder in sets if (folder / "right").is_dir()]
    done = []
    try:
        for folder in both:
            for before, after in (("left", "swapping"), ("right", "left"), ("swapping", "right")):
                os.rename(folder / before, folder / after)
                done.append((folder / before, folder / after))
    except BaseException as error:
        for before_path, after_path in reversed(done):
            os.rename(after_path, before_path)
        if not isinstance(error, OSError):
            raise
        raise RecordingError(
            f"{error.filename} cannot be renamed: {error.strerror}. Close what shows their pictures, or "
            "copy the recording to a folder that may be written."
        ) from None
    return [folder.name for folder in sets if folder not in both]

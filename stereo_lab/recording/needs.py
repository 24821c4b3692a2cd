"""What a lesson needs of a recording, and what it does where that is missing."""

from __future__ import annotations

from stereo_lab.recording.model import Recording
from stereo_lab.recording.opening import open_recording
from stereo_lab.recording.strays import told_of_strays

BALL = "ball"  # any set of pictures of the ball, with or without numbers
BOARDS = "boards"  # pictures of boards; a calibration may also have been taken over from elsewhere
PAIRS_OF_BOARDS = "15 to 25 pairs of a chessboard, in calibration/left and calibration/right"
TAKE = {
    BOARDS: PAIRS_OF_BOARDS,
    "calibration": PAIRS_OF_BOARDS,
    "position": "8 pairs of the ball in the plane of the arm, with their measured.csv, in position/",
    "depth": "6 pairs of the ball at growing distance, with their measured.csv, in depth/",
    BALL: "20 pictures of the ball, in snaps/left",
}


def with_sets(recording: Recording, *needed: str) -> Recording:
    """The recording itself where it has what is needed; else the shipped bench in its place.

    One sentence is printed where something is out of the ordinary: what is missing and what to take, or that the check
    samples are the judges because there is no evaluation set.

    Parameters
    ----------
    recording : Recording
    needed : names of sets; "ball" for any pictures of the ball, "boards" for pictures of boards

    Returns
    -------
    Recording
    """
    if lacking := lacks(recording, *needed):
        take = "; ".join(TAKE[name] for name in lacking)
        print(
            f"{recording.title}: what follows needs more than is there, so the shipped bench stands in. Take: {take}.{told_of_strays(recording.path)}"
        )
        return open_recording("bench")
    if "position" in needed and not recording.has_samples("evaluation"):
        print("no evaluation set: the check samples of position and depth are kept out of the fit and judge it")
    return recording


def lacks(recording: Recording, *needed: str) -> list[str]:
    """What is not there of the sets that :func:`with_sets` knows."""
    return [name for name in needed if not _has(recording, name)]


def _has(recording, name):
    if name == BALL:
        return bool(recording.ball_sets)
    if name == BOARDS:
        return recording.has_boards
    if name == "calibration":
        return recording.is_calibrated
    return recording.has_samples(name)

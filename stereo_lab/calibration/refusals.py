"""Sets of pictures that cannot be calibrated from, each refused in a sentence that says what to do."""

from __future__ import annotations

import reprlib
from collections.abc import Sequence
from typing import Any

import numpy as np

from stereo_lab.calibration.bundle import Rig
from stereo_lab.calibration.corners import check_board_size
from stereo_lab.calibration.solver import FEWEST
from stereo_lab.calibration.views import View
from stereo_lab.errors import CalibrationError, SwappedSidesError
from stereo_lab.recording import Board, StereoPair
from stereo_lab.recording.bounds import CHARUCO

SAME_PX = 0.5  # two cameras stand farther apart than a finder is off
STILL = 0.01  # of the picture's width: a board that moves less does not move
CLEAR_PX = 0.3  # reprojection error that the pictures of a webcam allow; in larger pictures by as much more
ROLLED_DEG = 30.0  # cameras turned so far against each other have no rows that could be made to match
BLURRED_FOCAL_PERCENT = 5.0  # beyond, nothing that the cameras tell is worth a word


def check_pairs(pairs: Any) -> list[StereoPair]:
    """The pairs as a list; what holds none is refused: a board, a recording, a name, numbers."""
    got = reprlib.repr(pairs)
    if not isinstance(pairs, str):
        try:
            listed = list(pairs)
        except TypeError:
            got = type(pairs).__name__
        else:
            # Pairs in memory serve as well; those of a recording are not read for it
            if all(isinstance(pair, StereoPair) or hasattr(pair, "left") for pair in listed):
                return listed
    raise CalibrationError(
        f'Expected pairs first, as recording.pairs("calibration") gives them, and then the board; got {got}.'
    )


def check_enough(found: Sequence[View], pairs: Sequence[StereoPair], board: Board, of: int = 0) -> None:
    """Refuse fewer than FEWEST boards seen by both cameras; where most are missing, name the board's real size.

    ``of``: how many pairs there are, where not all were looked at.
    """
    if len(found) >= FEWEST:
        return
    if len(found) < len(pairs) / 2:
        check_board_size(pairs, board)
    raise CalibrationError(
        f"The {board} was found in {len(found)} of {len(pairs)} "
        f"pairs{f', picked from {of}' if of > len(pairs) else ''}; at least {FEWEST} are needed, and 15 to 25 are good. Take more, sharp and well lit, "
        f"with {'much of the' if board.kind == CHARUCO else 'the whole'} board in both pictures."
    )


def check_shown(views: Sequence[View], pairs: Sequence[StereoPair], board: Board) -> None:
    """Refuse another board than was told where pairs show that one and none of these views is of the one that was told."""
    if not views:
        check_board_size(pairs, board)


def check_corners(views: Sequence[View], board: Board) -> None:
    """Refuse corners of another board."""
    expected = len(board.corners_mm), 2
    for view in views:
        if np.shape(view.left) != expected or np.shape(view.right) != expected:
            raise CalibrationError(
                f"Expected the corners of a {board} in each picture, shape {expected}; {view.name} has {np.shape(view.left)} and {np.shape(view.right)}."
            )


def check_two_cameras(views: Sequence[View]) -> None:
    """Refuse one camera's pictures on both sides: of two cameras half of all corners never lie at one place in both."""
    apart = np.array([np.linalg.norm(view.left - view.right, axis=1) for view in views])
    shared = apart[np.isfinite(apart)]
    if len(shared) and np.median(shared) < SAME_PX:
        raise CalibrationError(
            "Left and right show the same pictures, as if of one camera. Give each side the pictures of its own camera, "
            "or, where they were recorded here, two different camera numbers.",
            fault="same_pictures",
        )


def check_spread(views: Sequence[View], size: tuple[int, int]) -> None:
    """Refuse a board that never moves: it tells one view of itself, however many pictures there are."""
    for seen in ("left", "right") if views else ():
        corners = np.array([getattr(view, seen) for view in views])
        if np.ma.masked_invalid(corners).std(axis=0).mean() < STILL * size[0]:
            raise CalibrationError(
                f"The board is in the same place in all {len(corners)} pairs. Between two pictures, move it to another "
                "part of the picture, turn it, and tilt it to another side.",
                fault="one_place",
            )


def check_different(different: Sequence[View], found: int) -> None:
    """Refuse too few different places of the board, of so many pairs in which it was found."""
    if len(different) < FEWEST:
        raise CalibrationError(
            f"The board stands in {len(different)} different places in {found} pairs; at least {FEWEST} are needed, and 15 to 25 are good. "
            "Between two pictures, move it to another part of the picture, turn it, and tilt it to another side.",
            fault="one_place",
        )


def check_together(together: np.ndarray) -> None:
    """Refuse pairs of which too few show one moment; ``together`` of shape (views,), bool."""
    if together.sum() < FEWEST:
        raise CalibrationError(
            "The two cameras do not see the same boards: how the board moves before the left one does not fit how it "
            "moves before the right one. Were the two pictures of a pair taken at the same moment? Is a picture missing on one "
            "side, or a camera upside down? `stereo-lab check` tries which it is."
        )


def rolled_deg(rotation: np.ndarray) -> float:
    """By how much one camera is turned against the other about the way it looks, degrees; ``rotation`` of shape (3, 3)."""
    return float(np.degrees(np.arctan2(rotation[1, 0] - rotation[0, 1], rotation[0, 0] + rotation[1, 1])))


def check_sides(rig: Rig) -> None:
    """Refuse cameras of which one lies on its side, that stand one above the other, or whose left and right are swapped.

    Told in the directions that both cameras share, so that cameras turned inwards are not taken for swapped ones.
    """
    rolled = rolled_deg(rig.rotation)
    if abs(rolled) > ROLLED_DEG:
        raise CalibrationError(
            f"One camera is turned by {abs(rolled):.0f}° about its own axis against the other. Put both the right way up.",
            fault="upside_down",
        )
    step = -rig.rotation.T @ rig.translation  # where the right camera stands, in the left one's frame
    across, down, _ = np.eye(3) + rig.rotation
    if abs(step @ down) > abs(step @ across):
        raise CalibrationError(
            "One camera stands above the other, or all pictures are turned by a quarter. Put the cameras side by side, or turn the "
            "pictures back: `stereo-lab check` says which way.",
            fault="one_above_the_other",
        )
    if step @ across < 0:
        raise SwappedSidesError(
            "Left and right are swapped: the camera called right stands to the left of the other. "
            "Swap the folders (or the two patterns, or the two camera numbers). Or do both cameras show mirror images: can you "
            "read text in their pictures? If not, switch the mirror image off and take everything again.",
            fault="sides_swapped",
        )


def pixels_of(size: tuple[int, int]) -> float:
    """How many pixels of a picture stand for one of 640 across, for what is told in these; 1 in smaller pictures."""
    return max(1.0, size[0] / 640)


def check_focal(sigma_percent: float, rms_px: float, size: tuple[int, int] = (640, 480)) -> None:
    """Refuse boards that do not tell the focal length: they contradict each other, or were never tilted."""
    if sigma_percent <= BLURRED_FOCAL_PERCENT:
        return
    leaves = f"leave the focal length open by {sigma_percent:.0f} %"
    clear_px = CLEAR_PX * pixels_of(size)
    if sigma_percent * clear_px / max(rms_px, clear_px) <= BLURRED_FOCAL_PERCENT:
        raise CalibrationError(
            f"The boards contradict each other by {rms_px:.1f} px, and {leaves}. Was a camera moved, refocused or zoomed "
            "between two pairs? `stereo-lab check` tries which pairs belong together.",
            fault="not_together",
        )
    raise CalibrationError(
        f"The boards {leaves}: they are all parallel to the "
        "picture, or nearly. Tilt the board to the left, to the right, forwards and backwards, by 20 to 40 degrees.",
        fault="never_tilted",
    )

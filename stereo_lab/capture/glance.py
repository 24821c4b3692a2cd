"""What is seen of the board right now, in a few milliseconds: found or not, where, how large, how tilted, sharp; and of the ball."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from stereo_lab.calibration.charuco import glimpse_of_charuco
from stereo_lab.detection import BallDetector
from stereo_lab.doctor.pictures import look_of
from stereo_lab.recording import Ball, Board
from stereo_lab.recording.bounds import CHARUCO
from stereo_lab.recording.pictures import is_colorless

QUICK_WIDTH = 640  # px; boards are looked for in pictures no wider than this, and placed to a tenth of a pixel there
QUICK = cv2.CALIB_CB_ADAPTIVE_THRESH | cv2.CALIB_CB_FAST_CHECK  # that there is none is then told in 3 ms
FOCAL = 1.2  # in picture widths, of most webcams: enough to tell how a board is tilted


@dataclass(frozen=True, eq=False)
class Glance:
    """One picture of the board.

    Attributes
    ----------
    outline : ndarray, shape (4, 2), the board's outer corners round it, px; they may lie outside the picture
    corners : ndarray, shape (N, 2), px, of those that are seen
    size : (width, height) of the picture, px
    tilt_deg : (across, down), how far the board is turned about the upright and about the level axis
    edge_px : float, half the width of the edges between squares
    burnt : float, part of the white squares that is as bright as a picture can be
    """

    outline: np.ndarray
    corners: np.ndarray
    size: tuple[int, int]
    tilt_deg: tuple[float, float]
    edge_px: float
    burnt: float

    @property
    def wide(self) -> float:
        """The board's longer side, as a part of the picture's width."""
        sides = np.linalg.norm(np.diff(self.outline[[0, 1, 2, 3, 0]], axis=0), axis=1)
        return float(sides.max() / self.size[0])


def glance(image: np.ndarray, board: Board) -> Glance | None:
    """A quick look at one picture; None where no board is seen."""
    grey = cv2.cvtColor(image, cv2.COLOR_BGR2GRAY)
    scale = min(1.0, QUICK_WIDTH / grey.shape[1])
    small = grey if scale == 1 else cv2.resize(grey, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
    corners = _quick(small, board)
    if corners is None:
        return None
    corners = (corners + 0.5) / scale - 0.5
    there = ~np.isnan(corners[:, 0])
    plane = np.asarray(board.corners_mm, float)
    carried, _ = cv2.findHomography(plane[there, :2], corners[there])
    if carried is None:
        return None
    across, down = board.grid
    outer = plane[[0, across - 1, across * down - 1, across * (down - 1)], :2]
    outline = cv2.perspectiveTransform(outer[None], carried)[0]
    look = look_of(grey, corners)
    size = grey.shape[1::-1]
    return Glance(outline, corners[there], size, _tilt(plane[there], corners[there], size), look.edge_px, look.burnt)


def sides_without(ball: Ball, left: np.ndarray, right: np.ndarray) -> list[str]:
    """Of "left" and "right" those whose picture shows no ball of this colour."""
    detector = BallDetector(ball.color)
    return [side for side, image in (("left", left), ("right", right)) if detector.detect(image) is None]


def told_without(ball: Ball, left: np.ndarray, right: np.ndarray) -> str:
    """In which pictures no ball is seen, and what to do, in words; empty where both show it.

    It may be there and hard to see, so that whoever takes a pair looks at the picture before it is taken again.
    """
    sides = sides_without(ball, left, right)
    if not sides:
        return ""
    if any(is_colorless({"left": left, "right": right}[side]) for side in sides):
        return (
            f"No {ball.color} ball is seen: the picture is grey. Set the camera to colour, and take this place again."
        )
    where = f"in the {sides[0]} picture: look at it" if len(sides) == 1 else "in either picture: look at them"
    return f"No {ball.color} ball is seen {where}, and take this place again if {'it shows' if len(sides) == 1 else 'they show'} none."


def _quick(small, board):
    """Corners in a small picture, NaN where not seen, or None."""
    if board.kind == CHARUCO:
        return glimpse_of_charuco(small, board)
    found, corners = cv2.findChessboardCorners(small, (board.columns, board.rows), flags=QUICK)
    if not found:
        return None
    return cv2.cornerSubPix(small, corners, (3, 3), (-1, -1), (3, 10, 0.02)).reshape(-1, 2).astype(float)


def _tilt(plane, corners, size):
    """How a board is turned, degrees, by a camera such as most are."""
    width, height = size
    matrix = np.array([[FOCAL * width, 0, width / 2], [0, FOCAL * width, height / 2], [0, 0, 1]])
    _, turn, shift = cv2.solvePnP(plane, corners.reshape(-1, 1, 2), matrix, None)
    facing = cv2.Rodrigues(turn)[0][:, 2]
    facing = facing if facing[2] > 0 else -facing
    return tuple(float(np.degrees(np.arctan2(facing[k], facing[2]))) for k in (0, 1))

"""Corners placed by all that is printed round them: what was printed is known, markers and all.

Round a corner, brightness is mean + height · print, both of which may slope: light is uneven, and white shows it more than
black. The print is the board's own picture, put where the corners round this one say that it lies, a plane that the lens bends a little, and
blurred as the lens blurs. What it lacks to what is seen tells
how far it must be shifted, by linear least squares (Lucas and Kanade 1981); how much more it is blurred is found along the way.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np

from stereo_lab.recording import Board

PX = 64  # of the print, a square
DISC = 0.9  # radius, in squares: the markers round a corner are in it
LEAST_PX, MOST_PX = 4, 24  # in a larger one the lens bends the plane
NEAR = 2  # corners up to so many places away tell how the plane lies there
FEWEST, FEWEST_BENT = 6, 9  # of them, for a plane and for how the lens bends it
GAUSS = 0.8  # standard deviation of the blur for each px that tanh(a / blur) is blurred by, where both are as steep
LEAST_HEIGHT = 5.0  # of 255, between white and the mean, that is a print and no shadow
MOST_SHIFT_PX = 1.0
STRAY_PX, STRAYS = 1.0, 12  # so far off is a stray corner; so many are put right, the worst first
LEAST_SEEN = 0.6  # part of the disc that must be in the picture


def opencv_board(board: Board) -> cv2.aruco.CharucoBoard:
    """The board as OpenCV takes it."""
    size, name = (board.columns, board.rows), board.dictionary
    return cv2.aruco.CharucoBoard(size, board.square_mm, board.marker_mm or 0.0, dictionary_of(name))


def dictionary_of(name: str | None) -> cv2.aruco.Dictionary:
    """The markers of one of OpenCV's dictionaries."""
    return cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, str(name)))


@lru_cache(maxsize=8)
def the_print(board: Board) -> np.ndarray:
    """A ChArUco board with a square's white round it, float32, −1 where black and 1 where white, :data:`PX` a square.

    A pixel that an edge goes through is grey by how much of it is dark: whole pixels would move the edges of markers.
    """
    printed, scale = opencv_board(board), PX / board.square_mm
    dictionary = printed.getDictionary()
    cells = dictionary.markerSize + 2  # a dark rim round them
    dark = np.kron(np.add.outer(np.arange(board.rows), np.arange(board.columns)) % 2 == 0, np.ones((PX, PX)))
    for number, corners in zip(np.ravel(printed.getIds()), printed.getObjPoints(), strict=True):
        bits = cv2.aruco.generateImageMarker(dictionary, int(number), cells) == 0
        x, y = np.asarray(corners)[:, :2].min(0) * scale
        side = (board.marker_mm or 0.0) * scale / cells
        dark += _cover(y, side, cells, len(dark)) @ bits @ _cover(x, side, cells, dark.shape[1]).T
    return np.pad(1 - 2 * dark, PX, constant_values=1).astype(np.float32)


def _cover(start, side, cells, pixels):
    """How much of each pixel of a line each cell covers, shape (pixels, cells)."""
    begin, first = np.arange(pixels)[:, None], start + side * np.arange(cells)
    return np.clip(np.minimum(begin + 1, first + side) - np.maximum(begin, first), 0, None)


def without_strays(placed_Nx2: np.ndarray, board: Board) -> np.ndarray:
    """Corners, and in the place of one that lies far from where those round it put it, the place where they do.

    Parameters
    ----------
    placed_Nx2 : ndarray, row by row, NaN where not seen
    board : Board, a ChArUco one

    Returns
    -------
    ndarray, shape (N, 2)
    """
    corners = np.asarray(placed_Nx2, float).copy()
    squares = board.corners_mm[:, :2] / board.square_mm
    for _ in range(STRAYS):
        there = np.flatnonzero(~np.isnan(corners[:, 0]))
        off, told = np.zeros(len(corners)), corners.copy()
        for k in there:
            others = corners.copy()
            others[k] = np.nan
            sheet = _sheet_round(k, others, squares, board)
            if sheet is not None:
                told[k] = sheet.corner
                off[k] = np.linalg.norm(corners[k] - told[k])
        worst = int(np.argmax(off))
        if off[worst] < STRAY_PX:
            break
        corners[worst] = told[worst]
    return corners


def likeness(grey: np.ndarray, corners_Nx2: np.ndarray, board: Board) -> float:
    """How much the markers in a picture look like a board's own, where its corners are said to be.

    Parameters
    ----------
    grey : ndarray, uint8
    corners_Nx2 : ndarray, all of them, row by row
    board : Board, a ChArUco one

    Returns
    -------
    float, correlation over the cells of all markers, in standard deviations of what other markers would give by chance
    """
    places, dark = _cells(board)
    plane, _ = cv2.findHomography(board.corners_mm[:, :2], np.asarray(corners_Nx2, float))
    if plane is None:
        return 0.0
    where = cv2.perspectiveTransform(places.reshape(1, -1, 2), plane).astype(np.float32)
    seen = cv2.remap(grey, where[..., 0], where[..., 1], cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    seen = seen.reshape(dark.shape).astype(float)
    seen = seen.mean(1, keepdims=True) - seen  # of each marker, for light is uneven
    size = np.linalg.norm(seen) * np.linalg.norm(dark)
    return float((seen * dark).sum() / size * np.sqrt(dark.size)) if size else 0.0


@lru_cache(maxsize=8)
def _cells(board):
    """Of each marker the cells: where they are, mm from the first inner corner, and how dark, less the marker's mean."""
    printed = opencv_board(board)
    bits = printed.getDictionary().markerSize
    side, inner = (board.marker_mm or 0.0) / (bits + 2), np.arange(1, bits + 1) + 0.5
    steps = np.stack(np.meshgrid(inner * side, inner * side), -1).reshape(-1, 2)
    first = np.array([np.asarray(corners)[:, :2].min(0) for corners in printed.getObjPoints()]) - board.square_mm
    images = [
        cv2.aruco.generateImageMarker(printed.getDictionary(), int(number), bits + 2)[1:-1, 1:-1]
        for number in np.ravel(printed.getIds())
    ]
    dark = np.array([image.ravel() == 0 for image in images], float)
    return first[:, None] + steps, dark - dark.mean(1, keepdims=True)


def place_by_print(grey: np.ndarray, placed_Nx2: np.ndarray, board: Board, blur_px: float) -> np.ndarray:
    """Corners of a ChArUco board, placed anew by the print round each.

    Parameters
    ----------
    grey : ndarray, uint8
    placed_Nx2 : ndarray, to a tenth of a pixel or so, row by row, NaN where not seen
    board : Board, a ChArUco one
    blur_px : float, how wide edges are, as :mod:`crossing` tells it

    Returns
    -------
    ndarray, shape (N, 2); where too little is seen round a corner it stays where it was
    """
    corners = np.asarray(placed_Nx2, float).copy()
    squares = board.corners_mm[:, :2] / board.square_mm
    for k in np.flatnonzero(~np.isnan(corners[:, 0])):
        sheet = _sheet_round(k, placed_Nx2, squares, board)
        if sheet is not None:
            shift = _shift(grey, the_print(board), sheet, GAUSS * blur_px)
            corners[k] = corners[k] if shift is None else sheet.corner + shift
    return corners


@dataclass(frozen=True, eq=False)
class Sheet:
    """How the print lies in the picture round a corner: a plane, bent a little by the lens.

    Attributes
    ----------
    plane : ndarray, shape (3, 3), the homography from squares to pixels
    middle : ndarray, shape (2,), where it puts the corner, px
    bend : ndarray, shape (6, 2), px by which a place lies off the plane: 1, x, y, x², xy, y² of the px from there
    """

    plane: np.ndarray
    middle: np.ndarray
    bend: np.ndarray

    @property
    def corner(self) -> np.ndarray:
        """Where the corner lies, px."""
        return self.middle + self.bend[0]

    def squares(self, pixels_Nx2: np.ndarray) -> np.ndarray:
        """Which places of the board are seen at these pixels, in squares."""
        flat = pixels_Nx2 - _powers(pixels_Nx2 - self.middle) @ self.bend
        return cv2.perspectiveTransform(flat[None], np.linalg.inv(self.plane))[0]


def _powers(offsets):
    x, y = offsets.T
    return np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], 1)


def _sheet_round(k, placed, squares, board):
    """The sheet as the corners round one tell it; None where they are too few."""
    row, column = divmod(k, board.grid[0])
    rows, columns = np.divmod(np.arange(len(placed)), board.grid[0])
    near = (np.abs(rows - row) <= NEAR) & (np.abs(columns - column) <= NEAR) & ~np.isnan(placed[:, 0])
    if near.sum() < FEWEST or not np.ptp(rows[near]) or not np.ptp(columns[near]):
        return None
    plane = cv2.findHomography(squares[near], placed[near].astype(float))[0]
    if plane is None:
        return None
    told = cv2.perspectiveTransform(squares[None], plane)[0]
    bend = np.zeros((6, 2))
    if near.sum() >= FEWEST_BENT and min(np.ptp(rows[near]), np.ptp(columns[near])) >= 2:
        bend = np.linalg.lstsq(_powers(told[near] - told[k]), placed[near] - told[near], rcond=None)[0]
    return Sheet(plane, told[k], bend)


def _shift(grey, paper, sheet, sigma_px):
    """By how many px (u, v) what is seen lies from what the sheet tells; None where that cannot be told."""
    there = cv2.perspectiveTransform(sheet.middle[None, None], np.linalg.inv(sheet.plane))
    away = cv2.perspectiveTransform(np.float64([[[0.5, 0], [-0.5, 0], [0, 0.5], [0, -0.5]]]) + there, sheet.plane)[0]
    square = min(np.linalg.norm(away[0] - away[1]), np.linalg.norm(away[2] - away[3]))
    radius = int(np.clip(round(DISC * square), LEAST_PX, MOST_PX))
    middle = sheet.corner.round().astype(int)
    v, u = np.mgrid[-radius - 1 : radius + 2, -radius - 1 : radius + 2]
    told = _told(paper, sheet, u + middle[0], v + middle[1], sigma_px * PX / square)
    by_v, by_u = np.gradient(told)
    blurrier = np.gradient(by_u)[1] + np.gradient(by_v)[0]
    inside = (
        (u + middle[0] >= 0) & (u + middle[0] < grey.shape[1]) & (v + middle[1] >= 0) & (v + middle[1] < grey.shape[0])
    )
    disc = u**2 + v**2 <= (radius + 0.5) ** 2
    if (disc & inside).sum() < LEAST_SEEN * disc.sum():
        return None
    disc &= inside
    seen = grey[(v + middle[1])[disc], (u + middle[0])[disc]].astype(float)
    light = np.stack([np.ones(disc.sum()), u[disc] / radius, v[disc] / radius], 1)
    causes = [light, light * told[disc, None], blurrier[disc], -by_u[disc], -by_v[disc]]
    _, _, _, height, *_, shift_u, shift_v = np.linalg.lstsq(np.column_stack(causes), seen, rcond=None)[0]
    if height < LEAST_HEIGHT or np.hypot(shift_u, shift_v) > MOST_SHIFT_PX * height:
        return None
    return np.array([shift_u, shift_v]) / height


def _told(paper, sheet, u, v, sigma):
    """What the print looks like at these pixels, blurred by so many of its own px."""
    squares = sheet.squares(np.stack([u, v], -1).reshape(-1, 2).astype(float))
    places = ((squares + 2) * PX - 0.5).astype(np.float32).reshape(*u.shape, 2)
    low, high = places.reshape(-1, 2).min(0) - 4 * sigma, places.reshape(-1, 2).max(0) + 4 * sigma
    left, top = np.maximum(0, low.astype(int))
    right, bottom = np.minimum(paper.shape[::-1], high.astype(int) + 2)
    part = cv2.GaussianBlur(paper[top:bottom, left:right], (0, 0), max(sigma, 0.3), borderType=cv2.BORDER_REPLICATE)
    return cv2.remap(part, places - np.float32([left, top]), None, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)

"""OpenCV's two finders of chessboards: a grey picture and a size in, corners to about a pixel or None out."""

from __future__ import annotations

import cv2
import numpy as np

CLASSIC = cv2.CALIB_CB_ADAPTIVE_THRESH | cv2.CALIB_CB_NORMALIZE_IMAGE
SECTOR = cv2.CALIB_CB_EXHAUSTIVE | cv2.CALIB_CB_ACCURACY
FIND_WIDTH = 1280  # boards are found in pictures no wider than this; corners are placed in the full one
LOOK_WIDTH = 1600  # small pictures are enlarged to this width, to twice their size at most


def classic(grey: np.ndarray, size: tuple[int, int], larger: int = 1) -> np.ndarray | None:
    """Inner corners by ``cv2.findChessboardCorners``, which joins dark squares; shape (columns · rows, 2), or None.

    ``larger`` is how many times as large the picture is looked at.
    """
    small, scale = shrunk(grey)
    if larger > 1:
        small, scale = cv2.resize(small, None, fx=larger, fy=larger, interpolation=cv2.INTER_CUBIC), scale * larger
    found, corners = cv2.findChessboardCorners(small, size, flags=CLASSIC)
    return _at_full_size(corners, scale) if found else None


def sector(grey: np.ndarray, size: tuple[int, int]) -> np.ndarray | None:
    """Inner corners by ``cv2.findChessboardCornersSB`` on an enlarged picture, where small boards are found as well."""
    small, scale = shrunk(grey)
    large, larger = enlarged(small)
    found, corners = cv2.findChessboardCornersSB(large, size, flags=SECTOR)
    return _at_full_size(corners, scale * larger) if found else None


def shrunk(grey: np.ndarray) -> tuple[np.ndarray, float]:
    """A large picture made smaller, where boards are found sooner, and how many times as large it is."""
    scale = min(1.0, FIND_WIDTH / max(grey.shape))
    return (grey if scale == 1 else cv2.resize(grey, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)), scale


def enlarged(grey: np.ndarray) -> tuple[np.ndarray, float]:
    """A small picture made larger, where small boards are found as well, and how many times as large it is."""
    scale = min(2.0, max(1.0, LOOK_WIDTH / grey.shape[1]))
    return (grey if scale == 1 else cv2.resize(grey, None, fx=scale, fy=scale, interpolation=cv2.INTER_CUBIC)), scale


def _at_full_size(corners, scale):
    return (corners.reshape(-1, 2) + 0.5) / scale - 0.5

"""Two calibrated cameras: what they do to a pixel and to a picture, and how to keep them in a file."""

from __future__ import annotations

import reprlib
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import ArrayLike

from stereo_lab.calibration import uncertainty
from stereo_lab.calibration.bundle import CAMERAS, EXACT, STEP, TURN, Rig
from stereo_lab.calibration.saved import ARRAYS, read_saved
from stereo_lab.common import vectors
from stereo_lab.common.files import write_json
from stereo_lab.errors import CalibrationError

REMAPPED = "uint8", "uint16", "int16", "float32", "float64"  # types of pictures that cv2.remap takes


def as_points(points: ArrayLike, numbers: int) -> np.ndarray:
    """Points of so many numbers each, shape (N, numbers); what is none raises a CalibrationError."""
    return vectors.as_points(points, numbers, CalibrationError)


@dataclass(frozen=True, eq=False)
class StereoCalibration:
    """Two calibrated cameras and how good the calibration is.

    A point X in the left camera's frame (mm) is ``rotation @ X + translation_mm`` in the right one's.

    Attributes
    ----------
    image_size : (width, height), px
    left_matrix, right_matrix : ndarray, shape (3, 3), px
    left_distortion, right_distortion : ndarray, as ``cv2.calibrateCamera`` orders it
    rotation, translation_mm : ndarray, shapes (3, 3) and (3,)
    rms_px, left_rms_px, right_rms_px : float, reprojection error of both together, and of each camera alone; NaN, as other
        figures here, of a calibration made elsewhere
    vertical_error_px : float, mean row difference after rectification
    heldout_vertical_error_px, heldout_length_error_percent : float, on pairs that the fit has not seen; None with few
    focal_sigma_percent : float, standard deviation of the worse focal length
    board_bend_mm : float, how far the board is from flat
    lens : str, name of the lens model
    pairs, found : int, pairs there are, and pairs with the whole board in both pictures
    used : names of the pairs used
    dropped : (name, why) of the others
    corners_left_out : (pair, "left" or "right", u, v, px off) of single corners that the rest contradicts, worst first
    depth_mm : float, the distance for which the verdict is given
    covariance : ndarray, shape (24, 24), of the cameras' unknowns in the order of bundle.py; None in older files
    outlines : ndarray, shape (boards, 2 cameras, 4, 2), px, of the boards used, round their outer corners; NaN where a
        camera did not see one; no boards in older files
    misfit : float, how much more the boards differ among themselves than corners alone explain; 1 where they do not
    verdict, reasons : "good", "usable" or "poor", and why in sentences
    made_from : str, key of the pictures and the solver; see store.py
    """

    image_size: tuple[int, int]
    left_matrix: np.ndarray
    left_distortion: np.ndarray
    right_matrix: np.ndarray
    right_distortion: np.ndarray
    rotation: np.ndarray
    translation_mm: np.ndarray
    rms_px: float
    left_rms_px: float
    right_rms_px: float
    vertical_error_px: float
    heldout_vertical_error_px: float | None
    heldout_length_error_percent: float | None
    focal_sigma_percent: float
    board_bend_mm: float
    lens: str
    pairs: int
    found: int
    used: tuple[str, ...]
    dropped: tuple[tuple[str, str], ...]
    corners_left_out: tuple[tuple[str, str, float, float, float], ...] = ()
    depth_mm: float = 1000.0
    covariance: np.ndarray | None = None
    misfit: float = 1.0
    outlines: np.ndarray = field(default_factory=lambda: np.zeros((0, 2, 4, 2)))
    verdict: str = "poor"
    reasons: tuple[str, ...] = ()
    made_from: str = ""

    @cached_property
    def baseline_mm(self) -> float:
        """Distance between the two optical centres."""
        return float(np.linalg.norm(self.translation_mm))

    @cached_property
    def focal_px(self) -> float:
        """Focal length of the rectified pair."""
        return float(self.rectified["left"][1][0, 0])

    @property
    def center_px(self) -> tuple[float, float]:
        """Principal point (c_u, c_v) of the rectified pair: the pixel that looks straight ahead."""
        projection = self.rectified["left"][1]
        return float(projection[0, 2]), float(projection[1, 2])

    @cached_property
    def rectified(self) -> dict[str, tuple[np.ndarray, np.ndarray]]:
        """``{side: (rotation 3x3, projection 3x4)}`` of ``cv2.stereoRectify``."""
        r1, r2, p1, p2 = cv2.stereoRectify(
            self.left_matrix,
            self.left_distortion,
            self.right_matrix,
            self.right_distortion,
            tuple(self.image_size),
            self.rotation,
            self.translation_mm.reshape(3, 1),
            alpha=0,
        )[:4]
        return {"left": (r1, p1), "right": (r2, p2)}

    @cached_property
    def _maps(self):
        """``{side: the two maps of cv2.initUndistortRectifyMap}``: where each rectified pixel comes from."""
        return {
            side: cv2.initUndistortRectifyMap(
                *self.camera(side), *self.rectified[side], tuple(self.image_size), cv2.CV_32FC1
            )
            for side in ("left", "right")
        }

    def camera(self, side: str) -> tuple[np.ndarray, np.ndarray]:
        """Matrix (3, 3) and distortion of one camera, ``side`` "left" or "right"."""
        _check_side(side)
        return getattr(self, f"{side}_matrix"), getattr(self, f"{side}_distortion")

    def rectify(self, left: np.ndarray, right: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Both pictures with their rows made to match.

        Parameters
        ----------
        left, right : ndarray, shape (height, width, 3)

        Returns
        -------
        left, right : ndarray of the same shapes (``cv2.remap``)

        Raises
        ------
        CalibrationError
            If a picture is not of the size the cameras were calibrated for.
        """
        return tuple(self._remap(image, side) for image, side in ((left, "left"), (right, "right")))

    def _remap(self, image, side):
        self.check_size(image)
        return cv2.remap(image, *self._maps[side], cv2.INTER_LINEAR)

    def check_size(self, image: np.ndarray) -> None:
        """Raise CalibrationError if ``image`` is no picture, or not of the calibrated size."""
        shape, kind = np.shape(image), str(getattr(image, "dtype", type(image).__name__))
        if len(shape) not in (2, 3) or kind not in REMAPPED:
            got = f"got {shape} and {kind}" if shape else "there is none; was its file found?"
            raise CalibrationError(f"Expected a picture of shape (height, width, 3) and type uint8; {got}.")
        size = shape[1::-1]
        if size != tuple(self.image_size):
            raise CalibrationError(
                f"This calibration is for pictures of {self.image_size[0]}x{self.image_size[1]} pixels; "
                f"this one is {size[0]}x{size[1]}. Calibrate these cameras at this size."
            )

    def _rectified(self, side):
        _check_side(side)
        return self.rectified[side]

    def rectify_points(self, points_Nx2: ArrayLike, side: str) -> np.ndarray:
        """Raw pixels of one camera to rectified pixels, shape (N, 2) (``cv2.undistortPoints``)."""
        points = as_points(points_Nx2, 2)
        if not len(points):
            return points  # OpenCV gives None
        rotation, projection = self._rectified(side)
        return cv2.undistortPoints(
            points[:, None], *self.camera(side), R=rotation, P=projection, criteria=EXACT
        ).reshape(-1, 2)

    def unrectify_points(self, points_Nx2: ArrayLike, side: str) -> np.ndarray:
        """Rectified pixels of one camera back to raw pixels, shape (N, 2) (``cv2.projectPoints``)."""
        points = as_points(points_Nx2, 2)
        if not len(points):
            return points
        rotation, projection = self._rectified(side)
        rays = np.column_stack([points, np.ones(len(points))]) @ np.linalg.inv(projection[:, :3]).T @ rotation
        return cv2.projectPoints(rays.reshape(-1, 1, 3), np.zeros(3), np.zeros(3), *self.camera(side))[0].reshape(-1, 2)

    def rectify_centers(self, left: Any, right: Any) -> tuple[np.ndarray, np.ndarray]:
        """Centres of a pair of detections in rectified pixels.

        Parameters
        ----------
        left, right : Detection, or anything else with ``center_px``, in raw pixels

        Returns
        -------
        (u, v) of the left one, (u, v) of the right one

        Raises
        ------
        CalibrationError
            If they are no detections, such as bare points: those are for :meth:`rectify_points`.
        """
        if not all(hasattr(ball, "center_px") for ball in (left, right)):
            raise CalibrationError(
                f"Expected two detections, of the left and of the right picture; got {reprlib.repr((left, right))}. "
                "Bare points are for rectify_points."
            )
        return tuple(self.rectify_points([d.center_px], side)[0] for d, side in ((left, "left"), (right, "right")))

    def triangulate(self, left_Nx2: ArrayLike, right_Nx2: ArrayLike) -> np.ndarray:
        """Rectified pixels of both cameras to points in the rectified left frame.

        Z = f·B / (u_left − u_right), X = (u − c_x)·Z/f, Y = (v − c_y)·Z/f.

        Parameters
        ----------
        left_Nx2, right_Nx2 : array, rectified pixels

        Returns
        -------
        ndarray, shape (N, 3), mm: X right, Y down, Z forward. Z is below zero where left and right are swapped, or the
            pixels are not of one thing, and infinite where the rays are parallel.
        """
        p1, p2 = self.rectified["left"][1], self.rectified["right"][1]
        left, right = as_points(left_Nx2, 2), as_points(right_Nx2, 2)
        if len(left) != len(right):
            raise CalibrationError(f"Expected as many left pixels as right ones; got {len(left)} and {len(right)}.")
        (u, v), (u_right, v_right) = (left - p1[:2, 2]).T, (right - p2[:2, 2]).T
        with np.errstate(divide="ignore"):
            depth = -p2[0, 3] / (u - u_right)
        ahead = depth / p1[0, 0]
        return np.array([u * ahead, (v + v_right) / 2 * ahead, depth]).T

    def depth_per_px(self, depth_mm: float | np.ndarray) -> float | np.ndarray:
        """Millimetres of depth that one pixel of disparity is worth there: Z² / (f·B)."""
        return depth_mm**2 / (self.focal_px * self.baseline_mm)

    def sigma_mm(self, points_Nx3: ArrayLike) -> np.ndarray:
        """How far off places may be because of the calibration alone.

        Parameters
        ----------
        points_Nx3 : array, mm, in the rectified left frame, as :meth:`triangulate` gives them

        Returns
        -------
        ndarray, shape (N, 3), mm: standard deviations along X, Y, Z there; NaN where an older file does not tell
        """
        points = as_points(points_Nx3, 3)
        if self.covariance is None:
            return np.full(points.shape, np.nan)
        return uncertainty.sigmas(self.place_slopes(points), self.covariance)

    def place_slopes(self, points_Nx3: ArrayLike) -> np.ndarray:
        """How places in the rectified left frame, mm, change with the cameras' 24 unknowns, shape (N, 3, 24)."""
        to_rectified = self.rectified["left"][0]
        points = as_points(points_Nx3, 3) @ to_rectified
        slopes = to_rectified @ uncertainty.place_slopes(points, self.rig)
        return slopes + np.einsum("kij,nj->nik", self._turns_by, points)

    @cached_property
    def _turns_by(self):
        """How the rectifying rotation itself changes with the 24 unknowns: shape (24, 3, 3), by central differences."""
        slopes = np.zeros((CAMERAS, 3, 3))
        for unknowns, step in ((TURN, 1e-5), (STEP, 1e-5 * self.baseline_mm)):
            for k in range(unknowns.start, unknowns.stop):
                by = step * (np.arange(CAMERAS) == k)
                after, before = (self._to_rectified(self.rig.moved(sign * by)) for sign in (1, -1))
                slopes[k] = (after - before) / (2 * step)
        return slopes

    def _to_rectified(self, rig):
        """The left camera's rectifying rotation, were the right one where a rig has it."""
        lenses = self.left_matrix, self.left_distortion, self.right_matrix, self.right_distortion
        return cv2.stereoRectify(*lenses, tuple(self.image_size), rig.rotation, rig.translation[:, None], alpha=0)[0]

    def boards_at(self, points_Nx2: ArrayLike, side: str) -> np.ndarray:
        """How many of the boards used covered raw pixels of one camera: shape (N,) of int."""
        _check_side(side)
        points = as_points(points_Nx2, 2).astype(np.float32)
        boards = [
            b.astype(np.float32) for b in self.outlines[:, ("left", "right").index(side)] if not np.isnan(b).any()
        ]
        inside = [[cv2.pointPolygonTest(board, p.tolist(), False) >= 0 for p in points] for board in boards]
        return np.sum(inside, axis=0, dtype=int) if inside else np.zeros(len(points), int)

    @cached_property
    def rig(self) -> Rig:
        """The two cameras as the numbers that were solved for."""
        return Rig(_nine(*self.camera("left")), _nine(*self.camera("right")), self.rotation, self.translation_mm)

    def facts(self) -> dict[str, Any]:
        """What ``stereo-lab calibrate --json`` tells."""
        return {
            "pairs": self.pairs,
            "pairs_found": self.found,
            "pairs_used": len(self.used),
            "dropped": [{"name": name, "why": why} for name, why in self.dropped],
            "corners_left_out": [
                {"name": name, "side": side, "u": u, "v": v, "off_px": off}
                for name, side, u, v, off in self.corners_left_out
            ],
            "rms_px": _or_none(self.rms_px),
            "left_rms_px": _or_none(self.left_rms_px),
            "right_rms_px": _or_none(self.right_rms_px),
            "vertical_error_px": _or_none(self.vertical_error_px),
            "heldout_vertical_error_px": self.heldout_vertical_error_px,
            "heldout_length_error_percent": self.heldout_length_error_percent,
            "baseline_mm": self.baseline_mm,
            "focal_px": self.focal_px,
            "focal_sigma_percent": _or_none(self.focal_sigma_percent),
            "board_bend_mm": _or_none(self.board_bend_mm),
            "lens": self.lens,
            "depth_mm": self.depth_mm,
            "misfit": self.misfit,
            "verdict": self.verdict,
            "reasons": list(self.reasons),
        }

    def save(self, path: str | Path) -> None:
        """Write everything to a JSON file, whole or not at all."""
        content = {"format": 1, "made_from": self.made_from, "image_size": list(self.image_size)}
        for key in ARRAYS:
            content[key] = getattr(self, key).tolist()
        content["used"] = list(self.used)
        shown = self.outlines.round(1).astype(object)
        shown[np.isnan(self.outlines)] = None
        content["outlines"] = shown.tolist()
        content["covariance"] = None if self.covariance is None else self.covariance.tolist()
        write_json(path, {**content, **self.facts()})

    @classmethod
    def load(cls, path: str | Path) -> StereoCalibration:
        """Read what :meth:`save` wrote.

        Raises
        ------
        CalibrationError
            If the file is no calibration, or something in it cannot be used.
        """
        return cls(**read_saved(path))


def _check_side(side):
    if side not in ("left", "right"):
        raise CalibrationError(f'Expected the side "left" or "right"; got {side!r}.')


def _or_none(number):
    """None for what is not known: JSON has no NaN."""
    return None if np.isnan(number) else number


def _nine(matrix, distortion):
    """fx, fy, cx, cy, k1, k2, p1, p2, k3 of a camera, as :class:`Rig` has them."""
    return np.array([matrix[0, 0], matrix[1, 1], matrix[0, 2], matrix[1, 2], *np.append(distortion, 0.0)[:5]])

"""Lesson 01: what each camera does to a ray, and how the two stand to each other.

The corners of a chessboard are found in many pairs, placed to a twentieth of a pixel by a saddle
fit, and explained by two cameras (Zhang's method, ``cv2.stereoCalibrate``). Paper is never flat: the
board's own shape is measured along with the cameras.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, field, replace

import cv2
import numpy as np

import stereo_lab
from stereo_lab.common.files import read_json, user_folder, write_json
from stereo_lab.common.threads import one_thread
from stereo_lab.corners import check_board_size, find_corners, match_order
from stereo_lab.errors import CalibrationError, StereoLabError
from stereo_lab.judgement import judge
from stereo_lab.solver import FEWEST, View, check_sides, choose_lens, same_moment, unseen_errors, why_dropped

OTHER_MOMENT = "the two pictures do not match: were they taken at the same moment?"
PLACES = 3  # of px and mm; what two computers reckon differently lies far behind them
STILL = 0.01  # of the picture's width: a board that moves less does not move
EXACT = (cv2.TERM_CRITERIA_COUNT + cv2.TERM_CRITERIA_EPS, 60, 1e-9)  # for undoing the distortion

__all__ = ["StereoCalibration", "calibrate_recording", "calibrate_stereo", "find_corners"]


@dataclass(frozen=True, eq=False)
class StereoCalibration:
    """Two calibrated cameras and how good the calibration is.

    A point X in the left camera's frame (mm) is ``rotation @ X + translation_mm`` in the right one's.
    """

    image_size: tuple
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
    used: tuple
    dropped: tuple
    verdict: str = "poor"
    reasons: tuple = ()
    _maps: dict = field(default_factory=dict, repr=False)

    @property
    def baseline_mm(self):
        """Distance between the two optical centres."""
        return float(np.linalg.norm(self.translation_mm))

    @property
    def focal_px(self):
        """Focal length of the rectified pair."""
        return float(self._rectified["left"][1][0, 0])

    @property
    def center_px(self):
        """Principal point (c_u, c_v) of the rectified pair: the pixel that looks straight ahead."""
        projection = self._rectified["left"][1]
        return float(projection[0, 2]), float(projection[1, 2])

    @property
    def _rectified(self):
        """``{side: (rotation 3x3, projection 3x4)}`` of ``cv2.stereoRectify``."""
        if "rectified" not in self._maps:
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
            self._maps["rectified"] = {"left": (r1, p1), "right": (r2, p2)}
        return self._maps["rectified"]

    def camera(self, side):
        """Matrix (3, 3) and distortion of one camera, ``side`` "left" or "right"."""
        return getattr(self, f"{side}_matrix"), getattr(self, f"{side}_distortion")

    def rectify(self, left, right):
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
        if side not in self._maps:
            rotation, projection = self._rectified[side]
            self._maps[side] = cv2.initUndistortRectifyMap(
                *self.camera(side), rotation, projection, tuple(self.image_size), cv2.CV_32FC1
            )
        return cv2.remap(image, *self._maps[side], cv2.INTER_LINEAR)

    def check_size(self, image):
        """Raise CalibrationError if ``image`` is not of the calibrated size."""
        size = image.shape[1::-1]
        if size != tuple(self.image_size):
            raise CalibrationError(
                f"This calibration is for pictures of {self.image_size[0]}x{self.image_size[1]} pixels; "
                f"this one is {size[0]}x{size[1]}. Calibrate these cameras at this size."
            )

    def rectify_points(self, points_Nx2, side):
        """Raw pixels of one camera to rectified pixels, shape (N, 2) (``cv2.undistortPoints``)."""
        points = np.asarray(points_Nx2, float).reshape(-1, 1, 2)
        rotation, projection = self._rectified[side]
        return cv2.undistortPoints(points, *self.camera(side), R=rotation, P=projection, criteria=EXACT).reshape(-1, 2)

    def triangulate(self, left_Nx2, right_Nx2):
        """Rectified pixels of both cameras to points in the rectified left frame.

        Z = f·B / (u_left − u_right), X = (u − c_x)·Z/f, Y = (v − c_y)·Z/f.

        Parameters
        ----------
        left_Nx2, right_Nx2 : array, rectified pixels

        Returns
        -------
        ndarray, shape (N, 3), mm: X right, Y down, Z forward
        """
        left, right = (np.asarray(p, float).reshape(-1, 2) for p in (left_Nx2, right_Nx2))
        p1, p2 = self._rectified["left"][1], self._rectified["right"][1]
        focal = p1[0, 0]
        disparity = (left[:, 0] - p1[0, 2]) - (right[:, 0] - p2[0, 2])
        with np.errstate(divide="ignore"):
            depth = -p2[0, 3] / disparity
        row = (left[:, 1] + right[:, 1]) / 2
        return np.column_stack([(left[:, 0] - p1[0, 2]) * depth / focal, (row - p1[1, 2]) * depth / focal, depth])

    def depth_per_px(self, depth_mm):
        """Millimetres of depth that one pixel of disparity is worth there: Z² / (f·B)."""
        return depth_mm**2 / (self.focal_px * self.baseline_mm)

    def facts(self):
        """What ``stereo-lab calibrate --json`` tells."""
        return {
            "pairs": self.pairs,
            "pairs_found": self.found,
            "pairs_used": len(self.used),
            "dropped": [{"name": name, "why": why} for name, why in self.dropped],
            "rms_px": self.rms_px,
            "left_rms_px": self.left_rms_px,
            "right_rms_px": self.right_rms_px,
            "vertical_error_px": self.vertical_error_px,
            "heldout_vertical_error_px": self.heldout_vertical_error_px,
            "heldout_length_error_percent": self.heldout_length_error_percent,
            "baseline_mm": self.baseline_mm,
            "focal_px": self.focal_px,
            "focal_sigma_percent": self.focal_sigma_percent,
            "board_bend_mm": self.board_bend_mm,
            "lens": self.lens,
            "verdict": self.verdict,
            "reasons": list(self.reasons),
        }

    def save(self, path):
        """Write everything to a JSON file."""
        content = {"format": 1, "image_size": list(self.image_size)}
        for key in ARRAYS:
            content[key] = getattr(self, key).tolist()
        content["used"] = list(self.used)
        write_json(path, {**content, **self.facts()})

    @classmethod
    def load(cls, path):
        """Read what :meth:`save` wrote.

        Raises
        ------
        CalibrationError
            If the file is no calibration.
        """
        try:
            facts = read_json(path)
        except StereoLabError as error:
            raise CalibrationError(str(error)) from None
        try:
            return cls(
                image_size=tuple(int(v) for v in facts["image_size"]),
                **{key: _array(facts[key], shape) for key, shape in ARRAYS.items()},
                **{key: facts[key] for key in PLAIN},
                found=facts["pairs_found"],
                used=tuple(facts["used"]),
                dropped=tuple((d["name"], d["why"]) for d in facts["dropped"]),
                reasons=tuple(facts["reasons"]),
            )
        except (KeyError, TypeError, ValueError) as error:
            raise CalibrationError(
                f"{path} is no calibration of this kit ({error}). Make one with: stereo-lab calibrate"
            ) from None


ARRAYS = {
    "left_matrix": (3, 3),
    "left_distortion": (-1,),
    "right_matrix": (3, 3),
    "right_distortion": (-1,),
    "rotation": (3, 3),
    "translation_mm": (3,),
}
PLAIN = (
    "rms_px", "left_rms_px", "right_rms_px", "vertical_error_px", "heldout_vertical_error_px",
    "heldout_length_error_percent", "focal_sigma_percent", "board_bend_mm", "lens", "pairs", "verdict",
)  # fmt: skip


def _array(value, shape):
    array = np.asarray(value, float).reshape(shape)
    if not np.isfinite(array).all():
        raise ValueError("a number is not finite")
    return array


# --- from pairs to a calibration -------------------------------------------------------------------


def calibrate_stereo(pairs, board, progress=None):
    """Calibrate two cameras from pairs of pictures of a chessboard.

    Parameters
    ----------
    pairs : sequence of StereoPair
    board : Board
    progress : callable (done, total), optional

    Returns
    -------
    StereoCalibration

    Raises
    ------
    CalibrationError
        If fewer than three pairs show the board, the board has another size, or left and right
        are swapped.
    """
    pairs = list(pairs)
    views, dropped, size = _find_views(pairs, board, progress)
    if len(views) < FEWEST:
        if len(views) < len(pairs) / 2:
            check_board_size(pairs, board)
        raise CalibrationError(
            f"The board with {board.columns}x{board.rows} inner corners was found in {len(views)} of {len(pairs)} "
            f"pairs; at least {FEWEST} are needed, and 15 to 25 are good. Take more, sharp and well lit, "
            "with the whole board in both pictures."
        )
    _check_spread(views, size)
    found = len(views)
    with one_thread():
        together = same_moment(views, board, size)
    if together.sum() >= max(FEWEST, len(views) / 2):
        dropped += [(view.name, OTHER_MOMENT) for view, same in zip(views, together, strict=True) if not same]
        views = [view for view, same in zip(views, together, strict=True) if same]
    with one_thread():
        lens, fit, kept, heldout = choose_lens(views, board, size)
    check_sides(fit)
    dropped += [(views[i].name, why_dropped(fit, views[i], board, size)) for i in range(len(views)) if i not in kept]
    used = [views[i] for i in kept]
    result = StereoCalibration(
        image_size=size,
        left_matrix=fit.k1.round(PLACES),
        left_distortion=fit.d1.round(2 * PLACES),
        right_matrix=fit.k2.round(PLACES),
        right_distortion=fit.d2.round(2 * PLACES),
        rotation=cv2.Rodrigues(cv2.Rodrigues(fit.rotation)[0].round(2 * PLACES))[0],
        translation_mm=fit.translation.round(PLACES),
        rms_px=fit.rms,
        left_rms_px=fit.sides[0],
        right_rms_px=fit.sides[1],
        vertical_error_px=float(np.mean([unseen_errors(fit, view, board, size)[0] for view in used])),
        heldout_vertical_error_px=heldout[0],
        heldout_length_error_percent=heldout[1],
        focal_sigma_percent=fit.focal_sigma,
        board_bend_mm=float(np.ptp(fit.shape[:, 2])),
        lens=lens,
        pairs=len(pairs),
        found=found,
        used=tuple(view.name for view in used),
        dropped=tuple(sorted(dropped)),
    )
    verdict, reasons = judge(result, board, [(v.left, v.right) for v in used])
    return replace(result, verdict=verdict, reasons=reasons, _maps={})


def _check_spread(views, size):
    """A board that never moves tells one view of itself, however many pictures there are."""
    for seen in ("left", "right"):
        corners = np.array([getattr(view, seen) for view in views])
        if len(views) > 1 and corners.std(axis=0).mean() < STILL * size[0]:
            raise CalibrationError(
                f"The board is in the same place in all {len(views)} pairs. Between two pictures, move it to another "
                "part of the picture, turn it, and tilt it to another side."
            )


def _find_views(pairs, board, progress):
    """Corners of every pair that shows the whole board to both cameras."""
    views, dropped, size = [], [], None
    for index, pair in enumerate(pairs):
        left, right = pair.left, pair.right
        size = size or left.shape[1::-1]
        for image in (left, right):
            if image.shape[1::-1] != size:
                raise CalibrationError(
                    f"Pair {pair.name} is {image.shape[1]}x{image.shape[0]} pixels, the others are {size[0]}x{size[1]}."
                )
        corners = [find_corners(image, board) for image in (left, right)]
        lost = [side for side, c in zip(("left", "right"), corners, strict=True) if c is None]
        if lost:
            dropped.append((pair.name, f"no whole board in the {' and the '.join(lost)} picture"))
        else:
            views.append(View(pair.name, index, corners[0], match_order(corners[0], corners[1], board)))
        if progress:
            progress(index + 1, len(pairs))
    return views, dropped, size


def calibrate_recording(recording, progress=None):
    """The calibration of a recording, from the user's cache where it is there already.

    The cache is keyed by the pictures, the board and the version of the package.
    """
    if recording.calibrated_by:
        from stereo_lab.recording import open_recording

        beside = recording.path.parent / recording.calibrated_by
        return calibrate_recording(open_recording(beside), progress)
    pairs = recording.pairs("calibration")
    path = user_folder() / "calibrations" / f"{_fingerprint(recording, pairs)}.json"
    if path.is_file():
        try:
            return StereoCalibration.load(path)
        except CalibrationError:
            pass  # a spoilt cache is made again
    result = calibrate_stereo(pairs, recording.board, progress)
    try:
        result.save(path)
    except StereoLabError:
        pass  # a read-only home folder costs time, nothing else
    return result


def _fingerprint(recording, pairs):
    digest = hashlib.sha256(f"{stereo_lab.__version__} {recording.board}".encode())
    for pair in pairs:
        for path in (pair.left_path, pair.right_path):
            digest.update(f"{pair.name}".encode())
            digest.update(path.read_bytes() if path else b"")
    return digest.hexdigest()[:24]

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
from stereo_lab.corners import check_board_size, find_corners, match_order
from stereo_lab.errors import CalibrationError, StereoLabError
from stereo_lab.files import read_json, user_folder, write_json
from stereo_lab.judgement import judge

LENSES = {"brown": 0, "thin prism": cv2.CALIB_THIN_PRISM_MODEL}
FOLDS = 5
FEWEST = 3  # pairs without which nothing can be solved
FEWEST_TO_HOLD_OUT = 8
OUTLIER = 3.0  # times the median reprojection error
SHAPE_ROUNDS = 4
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


@dataclass(frozen=True, eq=False)
class _Fit:
    """One solution: the cameras, the board's shape and the error of each pair."""

    k1: np.ndarray
    d1: np.ndarray
    k2: np.ndarray
    d2: np.ndarray
    rotation: np.ndarray
    translation: np.ndarray
    rms: float
    errors: np.ndarray  # (pairs, 2), px
    shape: np.ndarray  # (corners, 3), mm
    sides: tuple  # RMS of each camera calibrated alone
    focal_sigma: float


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
    lens, fit, kept, heldout = _choose_lens(views, board, size)
    _check_sides(fit)
    dropped += [(views[i].name, _why_dropped(fit, views[i], board, size)) for i in range(len(views)) if i not in kept]
    used = [views[i] for i in kept]
    result = StereoCalibration(
        image_size=size,
        left_matrix=fit.k1,
        left_distortion=fit.d1,
        right_matrix=fit.k2,
        right_distortion=fit.d2,
        rotation=fit.rotation,
        translation_mm=fit.translation,
        rms_px=fit.rms,
        left_rms_px=fit.sides[0],
        right_rms_px=fit.sides[1],
        vertical_error_px=float(np.mean([_unseen_errors(fit, view, board, size)[0] for view in used])),
        heldout_vertical_error_px=heldout[0],
        heldout_length_error_percent=heldout[1],
        focal_sigma_percent=fit.focal_sigma,
        board_bend_mm=float(np.ptp(fit.shape[:, 2])),
        lens=lens,
        pairs=len(pairs),
        found=len(views),
        used=tuple(view.name for view in used),
        dropped=tuple(sorted(dropped)),
    )
    verdict, reasons = judge(result, board, [(v.left, v.right) for v in used])
    return replace(result, verdict=verdict, reasons=reasons, _maps={})


@dataclass(frozen=True, eq=False)
class _View:
    """The corners of one pair, and the place of that pair among all pairs."""

    name: str
    index: int
    left: np.ndarray
    right: np.ndarray


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
            views.append(_View(pair.name, index, corners[0], match_order(corners[0], corners[1], board)))
        if progress:
            progress(index + 1, len(pairs))
    return views, dropped, size


def _fit_without_outliers(views, board, size, lens):
    """Fit, drop the pairs whose error is far above the median, fit again."""
    kept = list(range(len(views)))
    while True:
        fit = _fit([views[i] for i in kept], board, size, lens)
        errors = np.sqrt((fit.errors**2).mean(1))
        bad = errors > OUTLIER * np.median(errors)
        if not bad.any() or len(kept) - bad.sum() < max(FEWEST, len(views) // 2):
            return fit, kept
        kept = [i for i, out in zip(kept, bad, strict=True) if not out]


def _fit(views, board, size, lens):
    """Each camera alone, then both together, and the board's shape in turn with them."""
    flat = board.corners_mm.astype(np.float32)
    left, right = [v.left for v in views], [v.right for v in views]
    try:
        sides = [_calibrate_alone(flat, points, size, lens) for points in (left, right)]
        k1, d1, k2, d2 = *sides[0][1:3], *sides[1][1:3]
        shape = flat
        for _ in range(SHAPE_ROUNDS):
            solved = cv2.stereoCalibrateExtended(
                [shape] * len(views), left, right, k1, d1, k2, d2, size, np.eye(3), np.zeros((3, 1)),
                flags=lens | cv2.CALIB_USE_INTRINSIC_GUESS,
            )  # fmt: skip
            rms, k1, d1, k2, d2, rotation, translation = solved[:7]
            used_shape, shape = shape, _board_shape(shape, flat, left, right, solved)
    except (cv2.error, np.linalg.LinAlgError) as error:
        raise CalibrationError(
            "No two cameras explain these boards: the corners contradict each other. "
            "Check that left and right were taken at the same moment, and the board's size."
        ) from error
    return _Fit(
        k1, d1.ravel(), k2, d2.ravel(), rotation, translation.ravel(), float(rms), np.asarray(solved[-1]).reshape(-1, 2),
        used_shape, (sides[0][0], sides[1][0]), max(side[3] for side in sides),
    )  # fmt: skip


def _calibrate_alone(flat, points, size, lens):
    """RMS, matrix, distortion and the focal length's standard deviation in percent."""
    solved = cv2.calibrateCameraExtended([flat] * len(points), points, size, None, None, flags=lens)
    rms, matrix, distortion, sigma = solved[0], solved[1], solved[2], solved[5]
    return float(rms), matrix, distortion, float(100 * sigma[0, 0] / matrix[0, 0])


def _board_shape(shape, flat, left, right, solved):
    """Move every board corner to where all views together put it (one least-squares step a corner).

    Turning, shifting or scaling the whole board is taken out again: only its shape is measured.
    """
    _, k1, d1, k2, d2, rotation, translation = solved[:7]
    normal, gradient = np.zeros((len(shape), 3, 3)), np.zeros((len(shape), 3))
    for seen_left, seen_right in zip(left, right, strict=True):
        _, rvec, tvec = cv2.solvePnP(shape, seen_left, k1, d1)
        turn = cv2.Rodrigues(rvec)[0]
        cameras = (
            (seen_left, k1, d1, turn, tvec),
            (seen_right, k2, d2, rotation @ turn, rotation @ tvec + translation),
        )
        for seen, matrix, distortion, turn_c, shift_c in cameras:
            pixels, jacobian = cv2.projectPoints(shape, cv2.Rodrigues(turn_c)[0], shift_c, matrix, distortion)
            by_point = jacobian[:, 3:6].reshape(-1, 2, 3) @ turn_c
            normal += np.einsum("nij,nik->njk", by_point, by_point)
            gradient += np.einsum("nij,ni->nj", by_point, seen - pixels.reshape(-1, 2))
    moved = shape + np.linalg.solve(normal, gradient[..., None])[..., 0]
    return _similar(moved, flat).astype(np.float32)


def _similar(points, target):
    """Turn, shift and scale ``points`` on to ``target`` (Umeyama)."""
    a, b = points - points.mean(0), target - target.mean(0)
    u, s, vt = np.linalg.svd(a.T @ b)
    mirror = np.diag([1, 1, np.sign(np.linalg.det(u @ vt))])
    scale = (s * np.diag(mirror)).sum() / (a**2).sum()
    return scale * a @ (u @ mirror @ vt) + target.mean(0)


def _check_sides(fit):
    x, y, _ = fit.translation
    if abs(y) > abs(x):
        raise CalibrationError("One camera stands above the other. Put them side by side.")
    if x > 0:
        raise CalibrationError(
            "Left and right are swapped: the camera called right stands to the left of the other. "
            "Swap the folders (or the two patterns, or the two camera numbers)."
        )


# --- unseen pairs --------------------------------------------------------------------------------------


def _choose_lens(views, board, size):
    """The lens model that tells unseen pairs best: (name, fit, kept views, errors on unseen pairs)."""
    best = None
    for name, lens in LENSES.items():
        fit, kept = _fit_without_outliers(views, board, size, lens)
        if len(views) < FEWEST_TO_HOLD_OUT:
            return name, fit, kept, (None, None)
        errors = _heldout_errors(views, kept, board, size, lens)
        # A richer model must earn its place: a tenth better, or the plain one stays.
        if best is None or np.prod(errors) < 0.9 * np.prod(best[3]):
            best = name, fit, kept, errors
    return best


def _heldout_errors(views, kept, board, size, lens):
    """Mean rectified |Δv| (px) and diagonal error (%) of pairs that the fit has not seen.

    Outliers are left out of the fit, never of the test: every pair is held out once.
    """
    errors = []
    for fold in range(FOLDS):
        seen = [views[i] for i in kept if views[i].index % FOLDS != fold]
        unseen = [view for view in views if view.index % FOLDS == fold]
        fit = _fit(seen, board, size, lens)
        errors += [_unseen_errors(fit, view, board, size) for view in unseen]
    return tuple(float(e) for e in np.mean(errors, 0))


def _unseen_errors(fit, view, board, size):
    """Mean |Δv| after rectification (px) and mean error of the two diagonals of the board (%)."""
    rectified = cv2.stereoRectify(
        fit.k1, fit.d1, fit.k2, fit.d2, size, fit.rotation, fit.translation.reshape(3, 1), alpha=0
    )
    r1, r2, p1, p2 = rectified[:4]
    left = cv2.undistortPoints(view.left.reshape(-1, 1, 2), fit.k1, fit.d1, R=r1, P=p1).reshape(-1, 2)
    right = cv2.undistortPoints(view.right.reshape(-1, 1, 2), fit.k2, fit.d2, R=r2, P=p2).reshape(-1, 2)
    points = cv2.triangulatePoints(p1, p2, left.T.astype(float), right.T.astype(float))
    points = (points[:3] / points[3]).T
    n = board.columns
    lengths = [np.linalg.norm(points[i] - points[j]) for i, j in ((0, -1), (n - 1, len(points) - n))]
    diagonal = board.square_mm * np.hypot(board.columns - 1, board.rows - 1)
    return np.abs(left[:, 1] - right[:, 1]).mean(), 100 * np.abs(np.array(lengths) / diagonal - 1).mean()


def _why_dropped(fit, view, board, size):
    """In words, why a pair does not fit the others."""
    alone = []
    for points, matrix, distortion in ((view.left, fit.k1, fit.d1), (view.right, fit.k2, fit.d2)):
        _, rvec, tvec = cv2.solvePnP(fit.shape, points, matrix, distortion)
        error = cv2.projectPoints(fit.shape, rvec, tvec, matrix, distortion)[0].reshape(-1, 2) - points
        alone.append(np.sqrt((error**2).sum(1).mean()))
    vertical = _unseen_errors(fit, view, board, size)[0]
    if max(alone) > OUTLIER * fit.rms:
        side = ("left", "right")[int(np.argmax(alone))]
        return f"corners of the {side} picture are off by {max(alone):.2f} px: blurred, bent or partly hidden"
    return f"the two pictures do not match ({vertical:.2f} px apart): were they taken at the same moment?"


# --- once, then ever after ------------------------------------------------------------------------------


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

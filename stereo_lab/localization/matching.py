"""Two pictures, one ball: of all round things in both, the two that lie on one row and are as large as the ball must be there."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import cv2
import numpy as np

from stereo_lab.calibration import StereoCalibration
from stereo_lab.detection import BALL, BallDetector, Detection
from stereo_lab.detection.detector import UNSURE, unsure
from stereo_lab.detection.judge import distinct
from stereo_lab.detection.model import Circle
from stereo_lab.detection.outline import STILL
from stereo_lab.localization.background import fit_on_background
from stereo_lab.localization.sphere import KNOWN, one_sphere

CANDIDATES = 8  # round things of each picture that are paired
ROW_PX, ROW_OF_RADIUS = 2.0, 0.1  # rows of the two centres may differ by this
SIZE, SIZE_PX = 0.15, 1.0  # the ball's size may seem this much wrong, and so many px
# Log odds that row and size speak for a pair: of two other things few agree. Less by how much the size is off, in usual errors
AGREE, USUAL, USUAL_PX = 4.0, 0.02, 0.2
BELIEVED = 3.0  # log odds: however sure one picture is, it does not make up for what the other one surely does not see
STEP = 0.5  # radii: so densely the other picture is looked at along the line where the ball must be

Looks = Sequence[tuple[BallDetector, np.ndarray]]  # left and right: a detector and the picture that it looks at


def find_pair(
    calibration: StereoCalibration,
    detectors: Sequence[BallDetector],
    diameter_mm: float,
    left: np.ndarray,
    right: np.ndarray,
    backgrounds: Sequence[np.ndarray] = (),
) -> tuple[Detection, Detection] | None:
    """Of all round things in both pictures, the two that are one ball: same row, right size, best scores.

    Where no two are, each thing that is probably a ball tells where the other camera must see it, and that picture is looked at there.

    Parameters
    ----------
    calibration : StereoCalibration
    detectors : (BallDetector, BallDetector), left and right
    diameter_mm : float, of the ball
    left, right : ndarray, raw pictures, BGR
    backgrounds : (ndarray, ndarray), optional; what these cameras see where no ball is, see ``median_picture``

    Returns
    -------
    (Detection, Detection) in raw pixels, or None
    """
    looks = list(zip(detectors, (left, right), strict=True))
    pair = _find(calibration, looks, diameter_mm)
    return None if pair is None else one_sphere(calibration, *surer(looks, pair, backgrounds))


def surer(
    looks: Looks, pair: tuple[Detection, Detection], backgrounds: Sequence[np.ndarray] = ()
) -> tuple[Detection, Detection]:
    """A pair of which both edges are looked for again if one of them scatters.

    By what is quiet round it, then on its background where that is known, which is worth it sooner; in both pictures by the same:
    what is wrong alike in both cancels in the disparity.

    Parameters
    ----------
    looks : two of (BallDetector, picture), left and right; pictures raw, BGR
    pair : (Detection, Detection) in them, raw pixels
    backgrounds : (ndarray, ndarray), optional

    Returns
    -------
    (Detection, Detection): as they were where neither is unsure, or where another look tells less
    """
    part = KNOWN if backgrounds else UNSURE
    if not any(unsure(ball, part) for ball in pair):
        return pair
    again = [detector.again(image, ball) for (detector, image), ball in zip(looks, pair, strict=True)]
    if backgrounds:
        images = (image for _, image in looks)
        left, right = (fit_on_background(*seen) for seen in zip(backgrounds, images, again, strict=True))
        if left is not None and right is not None:
            return left, right
    return again[0], again[1]


def _find(calibration, looks, diameter_mm):
    """The pair at first sight."""
    for everything in (False, True):  # the surest thing of one picture need not be in the other
        seen = [detector.weighed(image, CANDIDATES, everything) for detector, image in looks]
        if (pair := _best(calibration, diameter_mm, *seen)) is not None:
            return pair
    asked = [list(side) for side in seen]
    for k, side in enumerate(("left", "right")):
        for ball, logit in seen[k]:
            if logit > 0:
                detector, image = looks[1 - k]
                asked[1 - k] += detector.weighed_at(image, seen_by_the_other(calibration, diameter_mm, ball, side))
    return _best(calibration, diameter_mm, *asked)


def _best(calibration, diameter_mm, left, right):
    """The most probable pair of two lists of (Detection, log odds), or None."""
    pairs = []
    for one, a in left:
        for other, b in right:
            errors = size_errors(calibration, diameter_mm, one, other)
            if errors is not None:
                pairs.append((one, other, min(a, BELIEVED) + min(b, BELIEVED) + AGREE - sum(errors)))
    if not pairs:
        return None
    kept, told = distinct([(p[0].u, p[0].v, p[0].radius_px) for p in pairs], [p[2] for p in pairs])
    if told[0] < BALL:
        return None
    one, other, _ = pairs[kept[0]]
    return replace(one, score=told[0]), replace(other, score=told[0])


def size_errors(
    calibration: StereoCalibration, diameter_mm: float, left: Detection, right: Detection
) -> tuple[float, float] | None:
    """By how many usual errors each camera sees a ball too small or too large for its place; None where the two are not one ball.

    They are not where they break the epipolar constraint, meet behind the cameras, or seem of another size by far.
    """
    centers = calibration.rectify_centers(left, right)
    if abs(centers[0][1] - centers[1][1]) > rows_may_differ_px(left, right):
        return None
    point, errors = calibration.triangulate(*centers)[0].tolist(), []
    if not (all(map(math.isfinite, point)) and point[2] > 0):
        return None
    for ball, side in ((left, "left"), (right, "right")):
        off = abs(times_as_large(calibration, diameter_mm, ball, side, point) - 1)
        if off > _room(ball):
            return None
        errors.append(off / (USUAL + USUAL_PX / ball.radius_px))
    return errors[0], errors[1]


def rows_may_differ_px(left: Detection, right: Detection) -> float:
    """How far apart the rows of the two centres of one ball may be in rectified pictures."""
    return max(ROW_PX, ROW_OF_RADIUS * max(left.radius_px, right.radius_px))


def times_as_large(
    calibration: StereoCalibration, diameter_mm: float, ball: Detection, side: str, point: Sequence[float]
) -> float:
    """How many times as large a ball looks to one camera as one of this diameter would at a point of the rectified left frame, mm."""
    x, y, z = point
    lens_x = calibration.baseline_mm if side == "right" else 0.0
    return math.hypot(x - lens_x, y, z) * _nearness(calibration, diameter_mm, ball, side)


def _nearness(calibration, diameter_mm, ball, side):
    """1 / distance of a ball by its size in one picture, 1/mm: half its diameter times this is the sine of the cone's half angle."""
    slope = ball.radius_px / calibration.camera(side)[0][0, 0]
    return 2 * slope / (1 + slope * slope) ** 0.5 / diameter_mm


def _room(ball):
    """The part by which a ball's size may seem wrong."""
    return SIZE + SIZE_PX / ball.radius_px


def seen_by_the_other(calibration: StereoCalibration, diameter_mm: float, ball: Detection, side: str) -> list[Circle]:
    """Where the other camera must see a ball that one camera sees: circles along its epipolar line.

    How far away the ball is follows from its size, to the error that a size may have.

    Parameters
    ----------
    calibration : StereoCalibration
    diameter_mm : float, of the ball
    ball : Detection, raw pixels
    side : "left" or "right", the camera that sees it

    Returns
    -------
    list of (u, v, radius_px), raw pixels of the other camera
    """
    (matrix, distortion), other = calibration.camera(side), calibration.camera("right" if side == "left" else "left")
    turn, shift = calibration.rotation, np.ravel(calibration.translation_mm)
    if side == "right":
        turn, shift = turn.T, -turn.T @ shift
    ray = np.append(cv2.undistortPoints(np.array([[ball.center_px]]), matrix, distortion)[0, 0], 1.0)
    ray /= np.linalg.norm(ray)
    nearness = _nearness(calibration, diameter_mm, ball, side)
    room = nearness * _room(ball)

    def seen(nearness):
        place = turn @ ray / nearness + shift
        u, v = cv2.projectPoints(place[None], STILL, STILL, *other)[0].ravel().tolist()
        touch = (place @ place - diameter_mm**2 / 4) ** 0.5
        return u, v, float(other[0][0, 0] * diameter_mm / 2 / touch)

    far, near = seen(nearness - room), seen(nearness + room)
    count = 2 + int(np.hypot(far[0] - near[0], far[1] - near[1]) / (STEP * ball.radius_px))
    return [seen(n) for n in np.linspace(nearness - room, nearness + room, count)]

"""One sphere: the edges in both pictures belong to one ball, and are fitted with one.

What hides a part of the rim from one camera, or leads its edge astray, seldom does so to the other.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import cv2
import numpy as np

from stereo_lab.calibration import StereoCalibration
from stereo_lab.detection import Detection
from stereo_lab.detection.cone import LIMIT, LIMIT_PX, SCATTERED, Cone, spread_px, tukey
from stereo_lab.detection.detector import unsure

# So much of each rim on its cone, and each centre known to this part of the radius, to half of which it is on plain grounds: the
# ball that fits both has the cones' disparity to 0.01 px
CLEAN, KNOWN = 0.9, 0.006
SIZE_SIGMA_PX = 0.09  # blur and sharpening move the rim: so much may the ball's radius differ between the pictures
CONTRADICT = 2.0  # squared, in standard deviations, two of them free: of cones without a fault one pair in three
ROUNDS, ENOUGH_MM = 10, 0.03  # a tenth of what is known best
TINY = 1e-12
EYE, DAMPING = np.eye(3), TINY * np.eye(5)
ALIKE = np.array([0, 0, 0, 1.0, -1.0])  # the two radii, of the five numbers
ONE_SIZE = np.outer(ALIKE, ALIKE)

Pose = tuple[np.ndarray, np.ndarray]  # from the left camera's frame: turn (3, 3) and shift (3,), mm
Told = tuple[np.ndarray, np.ndarray]  # of a cone's a': information (3, 3), and information times what is missing (3,)


def one_sphere(calibration: StereoCalibration, left: Detection, right: Detection) -> tuple[Detection, Detection]:
    """Two detections of one ball, each centre moved to where the ball is seen that fits both pictures best.

    Five numbers, the ball's place in the left camera's frame and its radius in each picture (mm), by Gauss and Newton's
    least squares. All that the edges of a picture tell is summed up in its cone. Only where the two cones contradict each
    other the edges are asked again: those that lie far off the ball count less, as in ``fit_cone``. (A ball that was fitted on
    its background has none.) Where both rims are clean there is nothing to gain, and something to lose if a camera was nudged; they stay
    where they are, as do detections of one's own making, which have no cones.
    """
    if left.cone is None or right.cone is None:
        return left, right
    cones = left.cone, right.cone
    by_edges = all(cone.weights.any() for cone in cones)
    clean = by_edges and min(cone.on for cone in cones) >= CLEAN
    if clean and not any(unsure(ball, KNOWN) for ball in (left, right)):
        return left, right
    poses = (EYE, np.zeros(3)), (calibration.rotation, np.ravel(calibration.translation_mm))
    ball = _start(cones, poses)
    step, contradiction = _step(cones, poses, ball, [_by_cone(cone) for cone in cones])
    ball = ball + step  # one step is enough: what it leaves is its square over the ball's distance
    if contradiction > CONTRADICT and by_edges:
        edges = [_by_edges(cone) for cone in cones]
        for _ in range(ROUNDS):
            step, _ = _step(cones, poses, ball, edges)
            ball = ball + step
            if np.abs(step).max() < ENOUGH_MM:
                break
    places = [turn @ ball[:3] + shift for turn, shift in poses]
    if not np.isfinite(ball).all() or min(place[2] for place in places) <= 0:
        return left, right
    (u, v), (right_u, right_v) = (cone.look.pixel(place) for place, cone in zip(places, cones, strict=True))
    return replace(left, u=u, v=v), replace(right, u=right_u, v=right_v)


def _start(cones, poses):
    """Where the two axes pass each other, and the ball's radius by each cone."""
    ahead = [cone.axis / np.linalg.norm(cone.axis) for cone in cones]
    turn, shift = poses[1]
    turned = turn @ ahead[0]
    alike, one, other = turned @ ahead[1], turned @ shift, ahead[1] @ shift
    far = (alike * other - one) / max(1 - alike * alike, TINY)
    along = far, alike * far + other
    radii = [d * np.sqrt(1 - 1 / (cone.axis @ cone.axis)) for d, cone in zip(along, cones, strict=True)]
    return np.array([*(far * ahead[0]), *radii])


def _step(
    cones: Sequence[Cone], poses: Sequence[Pose], ball: np.ndarray, told: Sequence[Callable[[np.ndarray], Told]]
) -> tuple[np.ndarray, float]:
    """Toward the ball that best fits what each picture tells; and how much the pictures contradict each other there."""
    strict, off = (cones[0].look.r / (ball[3] * SIZE_SIGMA_PX)) ** 2, ball[3] - ball[4]
    information, missing, squares = strict * ONE_SIZE + DAMPING, -strict * off * ALIKE, strict * off * off
    for k, (turn, shift) in enumerate(poses):
        axis, slopes = _axis(turn @ ball[:3] + shift, ball[3 + k])
        known, lacks = told[k](axis)
        by_ball = np.zeros((3, 5))
        by_ball[:, :3], by_ball[:, 3 + k] = slopes[:, :3] @ turn, slopes[:, 3]
        information += by_ball.T @ known @ by_ball
        missing += lacks @ by_ball
        squares += lacks @ (cones[k].axis - axis)
    step = cv2.solve(information, missing[:, None], flags=cv2.DECOMP_CHOLESKY)[1][:, 0]
    return step, float(squares - missing @ step)


def _by_cone(cone):
    """What a cone tells of its axis."""
    return lambda axis: (cone.information, cone.information @ (cone.axis - axis))


def _by_edges(cone):
    """The same, by the edges near another axis."""
    rays, clear = cone.look.rays(cone.off), cone.weights > 0

    def told(axis):
        gap = 1 - rays @ axis
        px = cone.look.r / (axis @ axis - 1)  # a change of a'·ray in pixels
        middle = float(np.median(np.abs(px * gap[clear])))
        limit = max(LIMIT_PX, LIMIT * cone.look.r, SCATTERED * middle)
        counts = cone.weights * tukey(px * gap, limit)
        weighed = (counts * (px / spread_px(middle)) ** 2)[:, None] * rays
        return rays.T @ weighed, gap @ weighed

    return told


def _axis(place, radius):
    """The cone's a' of a ball (see ``fit_cone``), and how it changes with place and radius, shape (3, 4)."""
    touch = float(place @ place - radius * radius) ** 0.5  # how far away the rays touch it
    axis, slopes = place / touch, np.empty((3, 4))
    slopes[:, :3] = (EYE - axis[:, None] * axis) / touch
    slopes[:, 3] = axis * (radius / touch**2)
    return axis, slopes

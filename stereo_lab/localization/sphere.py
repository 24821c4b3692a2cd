"""One sphere: the edges in both pictures belong to one ball, and are fitted with one.

What hides a part of the rim from one camera, or leads its edge astray, seldom does so to the other.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stereo_lab.calibration import StereoCalibration
from stereo_lab.detection import Detection
from stereo_lab.detection.cone import LEAST_SCATTER_PX, LIMITS, LIMITS_PX, NORMAL, SCATTERED

SIZE_SIGMA_PX = 0.12  # blur and sharpening move the rim: so much may the ball's radius differ between the pictures
ROUNDS, ENOUGH_MM = 10, 0.03  # a tenth of what is known best
TINY = 1e-12 * np.eye(5)


def one_sphere(calibration: StereoCalibration, left: Detection, right: Detection) -> tuple[Detection, Detection]:
    """Two detections of one ball, each centre moved to where the ball is seen that fits the edges of both pictures best.

    Five numbers, the ball's place in the left camera's frame and its radius in each picture (mm), by Gauss and Newton's
    least squares; edges that lie far off count less, as in ``fit_cone``. Detections of one's own making, which have no
    edges, stay where they are.
    """
    if left.cone is None or right.cone is None:
        return left, right
    cones = left.cone, right.cone
    poses = (np.eye(3), np.zeros(3)), (calibration.rotation, np.ravel(calibration.translation_mm))
    rays = [cone.look.rays(cone.off) for cone in cones]
    ball = _start(cones, poses)
    for _ in range(ROUNDS):
        parts = [
            _edges(cone, seen, pose, ball, k)
            for k, (cone, seen, pose) in enumerate(zip(cones, rays, poses, strict=True))
        ]
        slopes, gaps = (np.concatenate(rows) for rows in zip(*parts, _same_size(cones, ball), strict=True))
        step = np.linalg.solve(slopes.T @ slopes + TINY, slopes.T @ gaps)
        ball += step
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
    along = np.linalg.lstsq(np.column_stack([turn @ ahead[0], -ahead[1]]), -shift, rcond=None)[0]
    radii = [far * np.sqrt(1 - 1 / (cone.axis @ cone.axis)) for far, cone in zip(along, cones, strict=True)]
    return np.array([*(along[0] * ahead[0]), *radii])


def _edges(cone, rays, pose, ball, which):
    """How far each edge of a picture lies from the ball, and how the five numbers change that, each by its weight."""
    turn, shift = pose
    axis, slopes = _axis(turn @ ball[:3] + shift, ball[3 + which])
    px = cone.look.r / (axis @ axis - 1)  # a change of a'·ray in pixels
    gap = (1 - rays @ axis) * px
    by_ball = np.zeros((len(gap), 5))
    by_ball[:, [0, 1, 2, 3 + which]] = px * (rays @ np.column_stack([slopes[:, :3] @ turn, slopes[:, 3]]))
    scatter = _median(np.abs(gap[cone.weights > 0]))
    limit = max(LIMITS_PX[-1], LIMITS[-1] * cone.look.r, SCATTERED * scatter)
    weight = np.sqrt(cone.weights) * np.maximum(1 - (gap / limit) ** 2, 0) / max(LEAST_SCATTER_PX, NORMAL * scatter)
    return weight[:, None] * by_ball, weight * gap


def _median(sizes):
    """np.median is slow on few numbers."""
    ordered = np.sort(sizes)
    return float(ordered[(len(sizes) - 1) // 2] + ordered[len(sizes) // 2]) / 2


def _same_size(cones, ball):
    """The ball is as large for one camera as for the other."""
    weight = cones[0].look.r / (ball[3] * SIZE_SIGMA_PX)
    return [[0, 0, 0, weight, -weight]], [weight * (ball[4] - ball[3])]


def _axis(place, radius):
    """The cone's a' of a ball (see ``fit_cone``), and how it changes with place and radius, shape (3, 4)."""
    touch = np.sqrt(place @ place - radius * radius)  # how far away the rays touch it
    slopes = np.column_stack([np.eye(3) / touch - np.outer(place, place) / touch**3, place * (radius / touch**3)])
    return place / touch, slopes

"""Rigs that are known exactly: cameras, a board that is not flat, and what they see of it, by OpenCV's own projection."""

from dataclasses import dataclass

import cv2
import numpy as np

from stereo_lab.calibration.views import View
from stereo_lab.recording import Board

BOARD = Board(9, 6, 25.0)


def turned(degrees):
    return cv2.Rodrigues(np.radians(np.asarray(degrees, float)))[0]


@dataclass(frozen=True, eq=False)
class Known:
    """Two cameras. ``see`` gives the pixels of points of the left camera's frame, mm."""

    size: tuple
    matrices: tuple
    distortions: tuple
    rotation: np.ndarray
    translation: np.ndarray

    def see(self, points):
        there = points, points @ self.rotation.T + self.translation
        return [
            cv2.projectPoints(p.reshape(-1, 1, 3), np.zeros(3), np.zeros(3), m, d)[0].reshape(-1, 2)
            for p, m, d in zip(there, self.matrices, self.distortions, strict=True)
        ]

    def inside(self, points, margin=4):
        return all(((p > margin) & (p < np.array(self.size) - margin)).all() for p in self.see(points))


def known_rig(rng, k3=0.0, turn=3.0, size=(640, 480)):
    """Two webcams that are not quite alike."""
    width, height = size
    focal = rng.uniform(0.9, 1.2) * width
    matrices, distortions = [], []
    for _ in range(2):
        fx, fy = focal * rng.uniform(0.99, 1.01, 2)
        matrices.append(
            np.array([[fx, 0, width / 2 + rng.normal(0, 6)], [0, fy, height / 2 + rng.normal(0, 6)], [0, 0, 1]])
        )
        distortions.append(np.array([rng.uniform(-0.2, 0.1), rng.uniform(-0.1, 0.1), *rng.normal(0, 6e-4, 2), k3]))
    rotation = turned(rng.normal(0, (1, turn, 1)))
    place = np.array([rng.uniform(80, 140), rng.normal(0, 2), rng.normal(0, 3)])
    return Known(size, tuple(matrices), tuple(distortions), rotation, -rotation @ place)


def bent_board(rng, bend_mm=0.6):
    """Corners of a sheet that bulges, and leans a little in its plane, shape (corners, 3), mm."""
    corners = np.array(BOARD.corners_mm, float)
    x, y = ((corners[:, :2] - corners[:, :2].mean(0)) / 100).T
    a, b, c, d = rng.normal(0, 1, 4)
    bulge = a * x * x + b * x * y + c * y * y + 0.3 * d * x**3
    corners[:, 2] = bend_mm * bulge / np.ptp(bulge)
    corners[:, 0] += 0.05 * y
    return corners


def hold(rng, rig, corners, count, noise_px=0.04, reach=0.5):
    """Views of the board held at random before both cameras, with normal noise."""
    views, focal = [], rig.matrices[0][0, 0]
    middle = corners.mean(0)
    while len(views) < count:
        far = rng.uniform(260, 650)
        across = rng.uniform(-reach, reach, 2) * rig.size / focal * far
        board = (corners - middle) @ turned(rng.uniform((-35, -35, -20), (35, 35, 20))).T + [*across, far]
        if rig.inside(board):
            left, right = (p + rng.normal(0, noise_px, p.shape) for p in rig.see(board))
            views.append(View(f"{len(views):03d}", left, right))
    return views


def ball_places(rng, rig, count, near=600.0, far=1800.0):
    """Places that both cameras see, shape (count, 3), mm, in the left camera's frame."""
    places = []
    while len(places) < count:
        depth = rng.uniform(near, far)
        pixel = np.append(rng.uniform(0, rig.size), 1.0)
        place = np.linalg.inv(rig.matrices[0]) @ pixel * depth
        if rig.inside(place[None]):
            places.append(place)
    return np.array(places)

"""Where things may be: points that the cameras of a rig see, drawn from its seed."""

from __future__ import annotations

import zlib

import numpy as np

EDGE_PX = 8  # so far from the rim of the picture things end


def stream(rig, *words):
    """A random generator of its own for these words."""
    return np.random.default_rng([rig.seed, *(zlib.crc32(str(w).encode()) for w in words)])


def bench_point(rig, u, v, depth_mm):
    """The point at this depth that the left camera sees near (u, v), distortion left out."""
    camera = rig.left
    ray = np.linalg.inv(camera.matrix) @ [u, v, 1.0] @ camera.rotation
    return camera.position_mm + ray * depth_mm / -ray[2]


def _ball_fits(rig, point, sides=("left", "right")):
    """On the table or above it, in front of the backdrop, whole in every picture."""
    radius = rig.recording["ball"]["diameter_mm"] / 2
    if point[1] < rig.room["table_y_mm"] + radius + 15:
        return False
    return all(rig.cameras[s].sees(point, EDGE_PX, radius) for s in sides)


def draw_point(rig, rng, depth_range, sides=("left", "right")):
    """A point at an even spread of depths and over the left picture."""
    width, height = rig.left.image_size
    depth = rng.uniform(*depth_range)
    while True:
        point = bench_point(rig, rng.uniform(0, width), rng.uniform(0, height), depth)
        if _ball_fits(rig, point, sides):
            return point

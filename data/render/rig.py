"""A rig in one small JSON file: two cameras, a ball, a board, an arm, a room and what to record.

Everything is in the bench frame (millimetres): origin at the arm's shoulder, x right, y up,
z towards the cameras. A camera frame is X right, Y down, Z forward, as in OpenCV.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import cv2
import numpy as np

from stereo_lab.common.files import read_json
from stereo_lab.errors import StereoLabError

RIGS = Path(__file__).parent / "rigs"


@dataclass(frozen=True)
class Sensor:
    """What happens to the light behind the lens of one webcam."""

    psf_px: float = 0.5
    exposure: float = 1.0
    white_balance: tuple = (1.9, 1.0, 1.6)
    full_well_electrons: float = 6000.0
    read_noise_electrons: float = 6.0
    vignetting: float = 0.25
    sharpen: float = 0.25
    jpeg_quality: int = 92


@dataclass(frozen=True)
class Camera:
    """A pinhole camera with Brown-Conrady distortion and a thin lens."""

    image_size: tuple
    matrix: np.ndarray
    distortion: np.ndarray
    rotation: np.ndarray
    position_mm: np.ndarray
    aperture_mm: float = 1.6
    focus_mm: float = 1000.0
    sensor: Sensor = field(default_factory=Sensor)

    def project(self, points_Nx3):
        """Bench points in mm to raw (distorted) pixels, shape (N, 2)."""
        points = np.asarray(points_Nx3, float).reshape(-1, 3)
        rvec, _ = cv2.Rodrigues(self.rotation)
        tvec = -self.rotation @ self.position_mm
        pixels, _ = cv2.projectPoints(points, rvec, tvec, self.matrix, self.distortion)
        return pixels.reshape(-1, 2)

    def depth(self, points_Nx3):
        """Distance along the optical axis in mm, shape (N,)."""
        return (np.asarray(points_Nx3, float) - self.position_mm) @ self.rotation[2]

    def sees(self, point, margin_px=0.0, radius_mm=0.0):
        """True where a ball of this radius lies inside the picture with a margin to spare."""
        z = self.depth([point])[0]
        if z < 100:
            return False
        margin = margin_px + radius_mm * self.matrix[0, 0] / z
        u, v = self.project([point])[0]
        width, height = self.image_size
        return margin <= u <= width - 1 - margin and margin <= v <= height - 1 - margin


@dataclass(frozen=True)
class Rig:
    """One rig file, read."""

    name: str
    recording: dict
    seed: int
    cameras: dict
    room: dict
    sets: dict
    samples: dict  # light paths a pixel for the empty "room", the "ball", and what is "around" it
    ball_gloss: float = 0.65  # 0: matt
    bend_mm: float = 0.3
    ruler_mm: float = 0.5

    @property
    def left(self):
        return self.cameras["left"]

    def depth_mm(self, point):
        """Depth as people read it: along z from the plane of the left camera's optical centre."""
        return float(self.left.position_mm[2] - point[2])


def look_rotation(yaw_deg, pitch_deg, roll_deg):
    """Rotation bench -> camera of a camera that looks along -z, then is turned by these angles."""
    yaw, pitch, roll = np.radians([yaw_deg, pitch_deg, roll_deg])
    turn = cv2.Rodrigues(np.array([0, 0, roll]))[0]
    turn = turn @ cv2.Rodrigues(np.array([pitch, 0, 0]))[0] @ cv2.Rodrigues(np.array([0, yaw, 0]))[0]
    return turn @ np.diag([1.0, -1.0, -1.0])


def load_rig(name, seed=None):
    """Read ``rigs/<name>.json`` (or a path to such a file)."""
    path = Path(name) if str(name).endswith(".json") else RIGS / f"{name}.json"
    spec = read_json(path)
    try:
        return _rig(path.stem, _completed(spec), seed)
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise StereoLabError(
            f"{path} cannot be used as a rig: {error!r}. Compare it with {RIGS / 'bench.json'}."
        ) from None


def _completed(spec):
    """What a rig's file leaves out is as in the one that it is ``based_on``; of its recording and its room, each part."""
    if "based_on" not in spec:
        return spec
    base = _completed(read_json(RIGS / f"{spec['based_on']}.json"))
    return base | spec | {key: base[key] | spec.get(key, {}) for key in ("recording", "room")}


def _rig(name, spec, seed):
    size = tuple(spec["recording"]["image_size"])
    return Rig(
        name=name,
        recording=spec["recording"],
        seed=spec["seed"] if seed is None else seed,
        cameras={side: _camera(size, c) for side, c in spec["cameras"].items()},
        room=spec["room"],
        sets=spec["sets"],
        samples=spec["samples"],
        **{key: spec[key] for key in ("ball_gloss", "bend_mm", "ruler_mm") if key in spec},
    )


def _camera(size, spec):
    fx, fy = spec["focal_px"]
    cx, cy = spec["center_px"]
    return Camera(
        image_size=size,
        matrix=np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1.0]]),
        distortion=np.array(spec["distortion"], float),
        rotation=look_rotation(*spec["yaw_pitch_roll_deg"]),
        position_mm=np.array(spec["position_mm"], float),
        aperture_mm=spec.get("aperture_mm", 1.6),
        focus_mm=spec.get("focus_mm", 1000.0),
        sensor=Sensor(**spec.get("sensor", {})),
    )

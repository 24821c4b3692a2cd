"""What the cameras of a rendered recording would see of a ball in the virtual arm's hand: drawn, not rendered.

Every ray that meets the ball is the ball, on a plain ground: enough to try the registration of an arm without one.
"""

from __future__ import annotations

import cv2
import numpy as np

from stereo_lab.arm.virtual.port import VirtualPort
from stereo_lab.errors import StereoLabError
from stereo_lab.kinematics import JointAngles, Registration
from stereo_lab.recording import Recording

LIGHT = np.array([-0.4, 0.7, 0.6])  # where it comes from, in the bench frame
GROUND, NOISE, BLUR_PX = 190.0, 1.5, 0.7
FINE = 4  # drawn so many times as large
COLORS = {  # blue, green, red, as parts of the light that come back
    "red": (0.02, 0.02, 0.5), "orange": (0.01, 0.15, 0.6), "yellow": (0.02, 0.5, 0.6), "green": (0.05, 0.35, 0.03), "blue": (0.4, 0.1, 0.02),
}  # fmt: skip


class DrawnCameras:
    """Two cameras before a virtual arm.

    Parameters
    ----------
    recording : Recording, a rendered one: its truth knows the cameras
    port : VirtualPort, the arm's
    stands : Registration or None
        Where the arm truly stands and what it is like; None: as the recording says.
    seed : int, for the noise

    Raises
    ------
    StereoLabError
        If the recording was taken with real cameras: nobody knows what those would see.
    """

    def __init__(
        self, recording: Recording, port: VirtualPort, stands: Registration | None = None, seed: int = 0
    ) -> None:
        if "cameras" not in recording.truth:
            raise StereoLabError(
                f"{recording.name} was taken with real cameras; a virtual arm can only be drawn before those of a "
                "rendered recording, such as bench. For a real arm name its port."
            )
        self.recording, self.port, self._rng = recording, port, np.random.default_rng(seed)
        self.stands = stands or Registration.told(recording.arm, recording.arm_depth_mm)

    def read(self) -> tuple[np.ndarray, np.ndarray]:
        """One pair: left and right picture, BGR."""
        x, y, depth = self.stands.place(JointAngles(*self.port.link_deg))
        cameras = self.recording.truth["cameras"]
        place = np.array([x, y, cameras["left"]["position_mm"][2] - depth])
        left, right = (self._picture(cameras[side], place) for side in ("left", "right"))
        return left, right

    def _picture(self, camera, place):
        wide, high = self.recording.image_size
        light = np.full((high, wide, 3), (GROUND / 255) ** 2.2)
        turn = np.array(camera["rotation"])
        center = turn @ (place - np.array(camera["position_mm"]))
        matrix, lens = np.array(camera["matrix"]), np.array(camera["distortion"])
        if center[2] > 0:
            self._draw(light, center, turn @ (LIGHT / np.linalg.norm(LIGHT)), matrix, lens)
        picture = 255 * light ** (1 / 2.2) + self._rng.normal(0, NOISE, light.shape)
        return np.clip(np.round(picture), 0, 255).astype(np.uint8)

    def _draw(self, light, center, sun, matrix, lens):
        """The ball into a picture of light, where it is in the picture."""
        radius = self.recording.ball.diameter_mm / 2
        pixel = cv2.projectPoints(center[None], np.zeros(3), np.zeros(3), matrix, lens)[0].ravel()
        reach = int(1.4 * matrix[0, 0] * radius / center[2]) + 8
        first, last = (np.clip(pixel + s * reach, 0, light.shape[1::-1]).astype(int) for s in (-1, 1))
        if (last - first).min() < 2:
            return
        (wide, high), (x, y) = last - first, first
        v, u = (np.mgrid[: high * FINE, : wide * FINE] + 0.5) / FINE - 0.5
        at = np.stack([u + x, v + y], -1).reshape(-1, 1, 2)
        rays = cv2.convertPointsToHomogeneous(cv2.undistortPoints(at, matrix, lens)).reshape(*u.shape, 3)
        along, square = rays @ center, (rays**2).sum(-1)
        inside = along**2 - square * (center @ center - radius**2)
        hit = inside > 0
        normal = (rays * ((along - np.sqrt(np.clip(inside, 0, None))) / square)[..., None] - center) / radius
        shade = 0.25 + 0.75 * np.clip(normal @ sun, 0, 1)
        fine = np.full((*hit.shape, 3), (GROUND / 255) ** 2.2)
        fine[hit] = (np.array(COLORS[self.recording.ball.color]) * shade[..., None])[hit]
        fine = cv2.GaussianBlur(fine, (0, 0), BLUR_PX * FINE)
        light[y : y + high, x : x + wide] = cv2.resize(fine, (int(wide), int(high)), interpolation=cv2.INTER_AREA)

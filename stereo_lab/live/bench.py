"""The virtual bench: what the cameras of a rendered recording would see of a ball and of an arm. Drawn, not rendered.

Every ray that meets the ball is the ball, through the cameras' own lenses; the rest is as plain as it may be.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np

from stereo_lab.errors import StereoLabError
from stereo_lab.kinematics import JointAngles, Registration
from stereo_lab.live.sources import Frame, Pace, StereoSource, check_rate
from stereo_lab.recording import Recording

LIGHT = np.array([-0.4, 0.7, 0.6]) / np.linalg.norm([-0.4, 0.7, 0.6])  # where it comes from, in the bench frame
WALL_MM, WALL_GREY = -220.0, 190.0  # the backdrop, behind the arm's plane
NOISE, BLUR_PX, FINE = 2.0, 0.7, 3  # grey levels; of the lens; a ball is drawn so many times as large
EXPOSURE_S, MOST_STILLS = 0.008, 12  # a moving ball is smeared over so long, by so many pictures of it
LINK_MM, JOINT_MM, ROD_MM, FLOOR_MM = 34.0, 16.0, 4.0, -500.0
SHADOW = 0.3  # how much of the light it takes
INK, ROOM = (90, 90, 90), 64  # px, by which the noise is moved about
LINK_BGR, JOINT_BGR, ROD_BGR = (214, 196, 168), (70, 70, 70), (120, 120, 120)
COLORS = {  # blue, green, red, as parts of the light that come back
    "red": (0.02, 0.02, 0.5), "orange": (0.01, 0.15, 0.6), "yellow": (0.02, 0.5, 0.6), "green": (0.05, 0.35, 0.03), "blue": (0.4, 0.1, 0.02),
}  # fmt: skip
GAMMA = 2.2
_TO_LIGHT = (np.arange(256, dtype=np.float32) / 255) ** np.float32(GAMMA)  # of a grey level


@dataclass(frozen=True, eq=False)
class Eye:
    """One camera: where it stands in the bench frame (mm), how it is turned, its lens, and the ray of each pixel.

    Attributes
    ----------
    rays : ndarray, (height, width, 2), float32: X and Y at Z = 1
    """

    position_mm: np.ndarray
    rotation: np.ndarray
    matrix: np.ndarray
    distortion: np.ndarray
    rays: np.ndarray

    @classmethod
    def of(cls, facts: dict[str, Any], size: tuple[int, int]) -> Eye:
        """From the truth of a rendered recording."""
        position, turn, matrix, lens = (
            np.array(facts[name], float) for name in ("position_mm", "rotation", "matrix", "distortion")
        )
        wide, high = size
        pixels = np.stack(np.meshgrid(np.arange(wide), np.arange(high)), -1).reshape(-1, 1, 2).astype(float)
        rays = cv2.undistortPoints(pixels, matrix, lens).reshape(high, wide, 2).astype(np.float32)
        return cls(position, turn, matrix, lens, rays)

    def seen_from(self, places_mm: np.ndarray) -> np.ndarray:
        """Places of the bench frame, (N, 3), in the camera's: X right, Y down, Z forward."""
        return (np.atleast_2d(places_mm) - self.position_mm) @ self.rotation.T

    def project(self, places_mm: np.ndarray) -> np.ndarray:
        """Places of the bench frame, (N, 3), to raw pixels, (N, 2) (``cv2.projectPoints``)."""
        turn = cv2.Rodrigues(self.rotation)[0]
        return cv2.projectPoints(
            np.atleast_2d(places_mm).astype(float),
            turn,
            -self.rotation @ self.position_mm,
            self.matrix,
            self.distortion,
        )[0].reshape(-1, 2)


class VirtualBench(StereoSource):
    """Two drawn cameras before a ball and an arm.

    Parameters
    ----------
    recording : Recording, a rendered one: its truth knows the cameras
    arm : object with ``link_deg``, optional: the port of a virtual arm, drawn where its joints are
    rate_hz : float, pairs a second
    fast : bool, as fast as they are asked for; the bench's time goes on by one picture each time
    late : int, so many pictures later a pair is handed over: webcams take their time
    seed : int, for the noise
    clock, sleep : function, seconds and waiting for some
    noise : float, its standard deviation in grey levels

    Attributes
    ----------
    ball_mm : (x, y, depth), where the ball is, in the bench frame; None: there is none. Change it at any time
    path : function of the time in seconds, giving such places; None: the ball stays where ``ball_mm`` says
    stand : bool, whether the ball stands on a rod

    Raises
    ------
    StereoLabError
        If the recording was taken with real cameras: nobody knows what those would see. If the rate makes no sense.
    """

    def __init__(
        self,
        recording: Recording,
        arm: Any = None,
        rate_hz: float = 30.0,
        fast: bool = False,
        late: int = 0,
        seed: int = 0,
        clock: Callable[[], float] = time.monotonic,
        sleep: Callable[[float], None] = time.sleep,
        noise: float = NOISE,
    ) -> None:
        if "cameras" not in recording.truth:
            raise StereoLabError(
                f"{recording.name} was taken with real cameras; only those of a rendered recording, such as bench, can be drawn. "
                "For a real arm name its port."
            )
        check_rate(rate_hz)
        self.name, self.size, self.rate_hz = f"virtual:{recording.name}", recording.image_size, rate_hz
        self.recording, self.arm = recording, arm
        self.ball_mm: Sequence[float] | None = (0.0, 120.0, float(recording.arm_depth_mm))
        self.stand = True
        self.path: Callable[[float], Sequence[float] | None] | None = None
        self.eyes = [Eye.of(recording.truth["cameras"][side], self.size) for side in ("left", "right")]
        self._wall = _wall(self.size)
        rng = np.random.default_rng(seed)
        wide, high = self.size
        self._noise = np.round(rng.normal(0, noise, (high + ROOM, wide + ROOM, 3))).astype(np.int16)
        self._rng, self._next, self._closed = rng, 0, False
        self._pace = None if fast else Pace(rate_hz, clock, sleep)
        self.late, self._on_their_way = late, deque[Frame]()

    def read(self) -> Frame | None:
        """The next pair, when it is due; None once the bench is closed."""
        while not self._closed:
            self._on_their_way.append(self._take())
            if len(self._on_their_way) > self.late:
                return self._on_their_way.popleft()
        return None

    def _take(self):
        """One pair, as things stand when it is due."""
        newest = self._next if self._pace is None else self._pace.due(self._next)
        dropped, self._next, time_s = newest - self._next, newest + 1, newest / self.rate_hz
        if self.path is None:
            left, right = self.draw(self.ball_mm)
        else:
            left, right = self.draw(self.path(time_s - EXPOSURE_S / 2), self.path(time_s + EXPOSURE_S / 2))
        return Frame(time_s, left, right, dropped=dropped)

    def now(self) -> float:
        """The time by the clock of its frames, seconds; where it goes as fast as it can, that of the newest one."""
        return max(self._next - 1, 0) / self.rate_hz if self._pace is None else self._pace.now()

    def draw(self, ball: Sequence[float] | None, until: Sequence[float] | None = None) -> tuple[np.ndarray, np.ndarray]:
        """Both pictures, BGR, of a ball at (x, y, depth) in mm.

        Parameters
        ----------
        ball, until : (x, y, depth) or None
            Where the ball is when the exposure begins, and when it ends; None: nowhere, and where it was.
        """
        places = [] if ball is None else [self._in_space(ball)]
        if ball is not None and until is not None:
            ends = np.array([places[0], self._in_space(until)])
            smeared_px = np.linalg.norm(np.diff(self.eyes[0].project(ends), axis=0))
            places = list(np.linspace(ends[0], ends[1], 1 + min(MOST_STILLS, int(np.ceil(smeared_px / 1.5)))))
        left, right = (self._picture(eye, places) for eye in self.eyes)
        return left, right

    def _in_space(self, place):
        """(x, y, depth) in the bench frame: z points from the arm's plane to the cameras."""
        x, y, depth = place
        return np.array([x, y, self.recording.arm_depth_mm - depth])

    def _picture(self, eye, places):
        picture = self._wall.copy()
        if places:
            self._shade(picture, eye, places[0])
        if places and places[0][2] < 0:  # behind the arm
            self._draw_ball(picture, eye, places)
        if self.arm is not None:
            self._draw_arm(picture, eye)
        if places and places[0][2] >= 0:
            self._draw_ball(picture, eye, places)
        cv2.putText(picture, "drawn", (8, self.size[1] - 10), cv2.FONT_HERSHEY_SIMPLEX, 0.6, INK, 1, cv2.LINE_AA)
        y, x = self._rng.integers(0, ROOM, 2)
        return cv2.add(picture, self._noise[y : y + self.size[1], x : x + self.size[0]], dtype=cv2.CV_8U)

    def _draw_arm(self, picture, eye):
        """Both links where the arm's joints are, and what they turn on."""
        links, angles = self.recording.arm, JointAngles(*self.arm.link_deg)
        elbow = links.l1_mm * np.array([np.cos(np.radians(angles.theta1_deg)), np.sin(np.radians(angles.theta1_deg))])
        joints = [(0.0, 0.0, 0.0), (*elbow, 0.0), (*links.forward(angles), 0.0)]
        for start, end in zip(joints[:-1], joints[1:], strict=True):
            _fill(picture, eye, _bar(start, end, LINK_MM), LINK_BGR)
        for joint in joints[:2]:
            _fill(picture, eye, _bar(joint, joint, JOINT_MM), JOINT_BGR)

    def _shade(self, picture, eye, place):
        """The ball's shadow on the backdrop: the circle that light sees of it, carried along the light."""
        across = np.cross(LIGHT, (0.0, 0.0, 1.0))
        across /= np.linalg.norm(across)
        turns = np.linspace(0, 2 * np.pi, 24, endpoint=False)[:, None]
        circle = place + self.recording.ball.diameter_mm / 2 * (
            np.cos(turns) * across + np.sin(turns) * np.cross(LIGHT, across)
        )
        pixels = eye.project(circle - LIGHT * ((circle[:, 2:] - WALL_MM) / LIGHT[2]))
        (x, y), (wide, high) = _window(pixels, 8, self.size)
        if wide < 2 or high < 2:
            return
        mask = np.zeros((high, wide), np.float32)
        cv2.fillPoly(mask, [np.round((pixels - (x, y)) * 16).astype(np.int32)], SHADOW, cv2.LINE_AA, 4)
        patch = picture[y : y + high, x : x + wide]
        patch[:] = patch * (1 - cv2.GaussianBlur(mask, (0, 0), 2.5))[..., None]

    def _draw_ball(self, picture, eye, places):
        """The ball on its rod into a picture: each ray that meets the ball, mixed with the rest as light."""
        x, y, z = places[0]
        if self.stand:
            _fill(picture, eye, _bar((x, y, z), (x, FLOOR_MM, z), ROD_MM), ROD_BGR)
        radius = self.recording.ball.diameter_mm / 2
        centers = eye.seen_from(np.array(places))
        if (centers[:, 2] <= 2 * radius).any():
            return
        reach = int(1.4 * eye.matrix[0, 0] * radius / centers[:, 2].min()) + 6
        (x, y), (wide, high) = _window(eye.project(np.array(places)), reach, self.size)
        if wide < 2 or high < 2:
            return
        fine = (wide * FINE, high * FINE)
        rays = cv2.resize(eye.rays[y : y + high, x : x + wide], fine, interpolation=cv2.INTER_LINEAR)
        light = cv2.resize(_TO_LIGHT[picture[y : y + high, x : x + wide]], fine, interpolation=cv2.INTER_LINEAR)
        color, sun = np.array(COLORS[self.recording.ball.color], np.float32), eye.rotation @ LIGHT
        seen = np.zeros_like(light)
        for center in centers:
            shade = _sphere(rays, center, radius, sun)
            hit = shade > 0
            still = light.copy()
            still[hit] = shade[hit][:, None] * color
            seen += still / len(centers)
        seen = cv2.resize(cv2.GaussianBlur(seen, (0, 0), BLUR_PX * FINE), (wide, high), interpolation=cv2.INTER_AREA)
        picture[y : y + high, x : x + wide] = np.round(255 * np.clip(seen, 0, 1) ** (1 / GAMMA))

    def close(self) -> None:
        """No more pictures come."""
        self._closed = True


def round_trip(recording: Recording, speed_mm_s: float = 100.0) -> Callable[[float], tuple[float, float, float]]:
    """A path for the ball of a virtual bench: a circle in the arm's plane, within its reach.

    Parameters
    ----------
    recording : Recording, whose arm it is
    speed_mm_s : float

    Returns
    -------
    function of the time in seconds, giving (x, y, depth) in mm
    """
    far = recording.arm.reach_mm[1]
    up, radius = 0.6 * far, 0.18 * far
    turns = speed_mm_s / radius  # radians a second

    def path(time_s: float) -> tuple[float, float, float]:
        angle = turns * time_s
        return (
            float(radius * np.cos(angle)),
            float(up + radius * np.sin(angle)),
            float(recording.arm_depth_mm),
        )

    return path


class DrawnCameras(AbstractContextManager["DrawnCameras"]):
    """Two drawn cameras before a virtual arm with the ball in its hand: what registering an arm asks for.

    Parameters
    ----------
    recording : Recording, a rendered one
    port : object with ``link_deg``, the arm's port
    stands : Registration or None
        Where the arm truly stands and what it is like; None: as the recording says.
    seed : int, for the noise

    Raises
    ------
    StereoLabError
        If the recording was taken with real cameras.
    """

    def __init__(self, recording: Recording, port: Any, stands: Registration | None = None, seed: int = 0) -> None:
        self._bench, self._port = VirtualBench(recording, fast=True, seed=seed), port
        self._bench.stand = False
        self.stands = stands or Registration.told(recording.arm, recording.arm_depth_mm)

    def read(self) -> tuple[np.ndarray, np.ndarray]:
        """One pair: left and right picture, BGR."""
        return self._bench.draw(self.stands.place(JointAngles(*self._port.link_deg)).tolist())

    def __exit__(self, *_: object) -> None:
        """Nothing is held; real cameras are let go of here."""


def _sphere(rays, center, radius, sun):
    """How bright the ball is where each ray meets it, 0 where none does."""
    along = rays[..., 0] * center[0] + rays[..., 1] * center[1] + center[2]
    square = rays[..., 0] ** 2 + rays[..., 1] ** 2 + 1
    inside = along**2 - square * (center @ center - radius**2)
    far = (along - np.sqrt(np.clip(inside, 0, None))) / square
    normal = (
        (far * rays[..., 0] - center[0]) * sun[0]
        + (far * rays[..., 1] - center[1]) * sun[1]
        + (far - center[2]) * sun[2]
    )
    return np.where(inside > 0, 0.25 + 0.75 * np.clip(normal / radius, 0, 1), 0).astype(np.float32)


def _wall(size):
    """The backdrop, a little darker towards its corners."""
    wide, high = size
    x, y = np.meshgrid(np.linspace(-1, 1, wide), np.linspace(-1, 1, high))
    return np.repeat((WALL_GREY * (1 - 0.06 * (x**2 + y**2)))[..., None], 3, axis=2).astype(np.uint8)


def _window(pixels, reach, size):
    """The part of the picture that holds some pixels and so much around them: (x, y), (width, height)."""
    low = np.clip(np.floor(pixels.min(axis=0)) - reach, 0, size).astype(int)
    high = np.clip(np.ceil(pixels.max(axis=0)) + reach, 0, size).astype(int)
    return low, high - low


def _bar(start, end, wide_mm):
    """The outline of a flat bar with round ends, in its plane across the cameras' way."""
    start, end = np.array(start, float), np.array(end, float)
    along = np.arctan2(end[1] - start[1], end[0] - start[0])
    outline = []
    for center, first in ((end, -90), (start, 90)):
        turns = along + np.radians(first + np.linspace(0, 180, 13))
        circle = np.column_stack([np.cos(turns), np.sin(turns), np.zeros(13)])
        outline.append(center + wide_mm / 2 * circle)
    return np.concatenate(outline)


def _fill(picture, eye, outline, color):
    """A flat thing of the bench frame into a picture."""
    if (eye.seen_from(outline)[:, 2] > 1).all():
        pixels = np.clip(eye.project(outline), -4000, 4000)
        cv2.fillPoly(picture, [np.round(pixels * 16).astype(np.int32)], color, cv2.LINE_AA, 4)

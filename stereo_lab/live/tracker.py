"""Following a ball from picture to picture: where it is, how fast it goes, and how sure that is."""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np

from stereo_lab.detection import Detection
from stereo_lab.live.sources import Frame
from stereo_lab.localization import Localizer
from stereo_lab.recording import Position

ACCELERATION_MM_S2 = 3000.0  # of a ball that is moved by hand, each way: a third of a falling one's
PUSH_S, LONGEST_S = 0.1, 10.0  # so long a hand pushes one way at most; after so long the ball may be anywhere
FORGETS_S = 0.4  # a velocity is trusted for about so long: after that it is the last place that predicts best
PATIENCE_S = 0.35  # so long an unseen ball is predicted before it is lost
FAR = 16.3  # squared distance of a place from its prediction, in standard deviations: 1 of 1,000 right ones is farther
SAME_MM = 40.0  # nearer than this to what was refused in the picture before is the same thing: a ball's diameter
EACH = np.arange(3)  # coordinate
SIGMA_MM, START_MM_S = 5.0, 1000.0  # of a place that tells none; of the velocity of a ball just found


@dataclass(frozen=True)
class Track:
    """A ball that is followed, at the time of one picture.

    Attributes
    ----------
    time_s : float, when the picture was taken
    position : Position, with its standard deviations
    velocity_mm_s, velocity_sigma_mm_s : (x, y, depth)
    seen : bool, whether it was seen in this picture; else its place is predicted
    detections : (Detection, Detection) or None, in raw pixels
    """

    time_s: float
    position: Position
    velocity_mm_s: tuple[float, float, float]
    velocity_sigma_mm_s: tuple[float, float, float]
    seen: bool
    detections: tuple[Detection, Detection] | None

    @property
    def speed_mm_s(self) -> float:
        """How fast it goes."""
        return float(np.linalg.norm(self.velocity_mm_s))

    def at(self, time_s: float) -> Position:
        """Where the ball will be at a time, if nobody pushes it: on with its velocity, which is trusted less and less."""
        ahead = FORGETS_S * (1 - np.exp((self.time_s - time_s) / FORGETS_S))
        x, y, depth = (float(p + ahead * v) for p, v in zip(_vector(self.position), self.velocity_mm_s, strict=True))
        return Position(x, y, depth)


class Tracker:
    """Follows one ball: a Kalman filter of its place and its velocity.

    The next picture is searched round the predicted place first, the whole of it where nothing is there. What is found
    too far from the prediction is not the ball that is followed, and stays refused however unsure the prediction gets: a ball
    of the same colour elsewhere is taken up only after this one is told lost. What only one camera sees counts as not seen.

    Parameters
    ----------
    localizer : Localizer
    acceleration_mm_s2 : float, how much the ball may speed up, each way (standard deviation)
    patience_s : float, so long an unseen ball is predicted
    """

    def __init__(
        self, localizer: Localizer, acceleration_mm_s2: float = ACCELERATION_MM_S2, patience_s: float = PATIENCE_S
    ) -> None:
        self.localizer, self.acceleration_mm_s2, self.patience_s = localizer, acceleration_mm_s2, patience_s
        self._filter: cv2.KalmanFilter | None = None
        self._time_s = self._seen_s = 0.0
        self._last: list[tuple[float, tuple[Detection, Detection]]] = []  # the two newest detections, and their times
        self._refused: np.ndarray | None = None  # where something else was in the picture before

    def update(self, frame: Frame) -> Track | None:
        """Take in the next pair of pictures.

        Parameters
        ----------
        frame : Frame; one that is not later than the one before begins anew

        Returns
        -------
        Track or None
            None where no ball is followed: none was found yet, or it was lost.
        """
        if frame.time_s <= self._time_s:
            self.lose()
        step_s, self._time_s = frame.time_s - self._time_s, frame.time_s
        if self._filter is not None:
            self._predict(step_s)
        found = self.localizer.detect(frame.left, frame.right, self.expected(frame.time_s))
        place = None if found is None else self.localizer.position(*found)
        if self._filter is None:
            return None if place is None else self._begin(frame.time_s, found, place)
        if place is not None and self._fits(place):
            return self._correct(frame.time_s, found, place)
        self._refused = self._refused if place is None else _vector(place)
        if frame.time_s - self._seen_s > self.patience_s:
            self.lose()
            return None
        return self._track(False, None)

    def lose(self) -> None:
        """Follow nothing any more; the next ball that is found is a new one."""
        self._filter, self._last, self._refused = None, [], None

    def expected(self, time_s: float) -> tuple[Detection, Detection] | None:
        """Where both cameras should see the ball at a time, by the last two pictures of it; None where none is followed."""
        if not self._last:
            return None
        (then_s, then), (now_s, now) = self._last[0], self._last[-1]
        if now_s == then_s:
            return now
        ahead = FORGETS_S * (1 - np.exp((now_s - time_s) / FORGETS_S)) / (now_s - then_s)
        left, right = (
            replace(b, u=float(b.u + ahead * (b.u - a.u)), v=float(b.v + ahead * (b.v - a.v)))
            for a, b in zip(then, now, strict=True)
        )
        return left, right

    def _begin(self, time_s, found, place):
        self._filter = cv2.KalmanFilter(6, 3, 0, cv2.CV_64F)
        self._filter.measurementMatrix = np.eye(3, 6)
        self._filter.statePost = np.append(_vector(place), np.zeros(3))[:, None]
        self._filter.errorCovPost = np.diag([*np.square(_sigmas(place)), *[START_MM_S**2] * 3])
        self._seen_s, self._last = time_s, [(time_s, found)]
        return self._track(True, found)

    def _predict(self, step_s):
        """Let the time pass: the ball goes on, its velocity fades, and both get less sure.

        In slow footage a hand pushes this way and that between two pictures: one push for all of the time would tell from the
        last two places how fast the ball goes now, and be sure of it.
        """
        left_s = min(step_s, LONGEST_S)
        while left_s > 0:
            push_s = min(left_s, PUSH_S)
            fades = np.exp(-push_s / FORGETS_S)
            way, speed = push_s**2 / 2 * self.acceleration_mm_s2, push_s * self.acceleration_mm_s2
            self._filter.transitionMatrix = _blocks(1.0, FORGETS_S * (1 - fades), 0.0, fades)
            self._filter.processNoiseCov = _blocks(way * way, way * speed, way * speed, speed * speed)
            self._filter.predict()
            left_s -= push_s

    def _fits(self, place):
        """Whether a place may be that of the ball that is followed."""
        gap = _vector(place) - self._filter.statePre[:3, 0]
        if self._refused is not None:
            off_mm = np.linalg.norm(_vector(place) - self._refused)
            if off_mm < min(SAME_MM, np.linalg.norm(gap)):  # that thing again, and not the ball
                return False
        spread = self._filter.errorCovPre[:3, :3] + np.diag(np.square(_sigmas(place)))
        return float(gap @ np.linalg.solve(spread, gap)) < FAR

    def _correct(self, time_s, found, place):
        self._filter.measurementNoiseCov = np.diag(np.square(_sigmas(place)))
        self._filter.correct(_vector(place)[:, None])
        self._refused = None
        self._seen_s, self._last = time_s, [*self._last[-1:], (time_s, found)]
        return self._track(True, found)

    def _track(self, seen, found):
        state = self._filter.statePost if seen else self._filter.statePre
        spread = self._filter.errorCovPost if seen else self._filter.errorCovPre
        values, sigmas = state[:, 0].tolist(), np.sqrt(np.diag(spread)).tolist()
        position = Position(*values[:3], tuple(sigmas[:3]))
        return Track(self._time_s, position, tuple(values[3:]), tuple(sigmas[3:]), seen, found)


def _blocks(a, b, c, d):
    """The same for each of three coordinates: four numbers, each times the 3x3 identity."""
    matrix = np.zeros((2, 3, 2, 3))
    matrix[:, EACH, :, EACH] = (a, b), (c, d)
    return matrix.reshape(6, 6)


def _vector(place):
    return np.array([place.x_mm, place.y_mm, place.depth_mm], float)


def _sigmas(place: Position) -> np.ndarray:
    """How far each coordinate may be off, mm."""
    return np.array((SIGMA_MM,) * 3 if place.sigma_mm is None else place.sigma_mm, float)

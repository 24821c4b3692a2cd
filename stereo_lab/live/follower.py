"""A hand that stays at a ball: which angles to ask an arm for, picture after picture."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from stereo_lab.arm.measuring import must_be_homed
from stereo_lab.common.files import finite_number
from stereo_lab.errors import ArmError, StereoLabError, UnreachableTargetError
from stereo_lab.kinematics import JointAngles
from stereo_lab.live.tracker import Track
from stereo_lab.recording import Position, Recording
from stereo_lab.recording.model import must_be_recording

if TYPE_CHECKING:
    from stereo_lab.arm import Arm
    from stereo_lab.live.run import Moment

GAP_MM = 10.0  # between the hand and the ball it follows: neither pushes the other
STEADY = 3  # pictures in a row that must show a ball before the arm sets off for it
SLOW_DEG, LEAST_PERCENT = 15.0, 20.0  # so near to a limit the arm gets slower, down to so much of its speed
ANSWERS_S = 0.03  # until an order is with the arm and its joints answer it
MOST_BETWEEN_S = 0.1  # two orders; half of that time, too, an order lies ahead
LOOK_S = 0.02  # how far apart two places are looked at to tell how fast the joints must turn
FARTHEST_DEG = 90.0  # the shoulder's turn to a ball that is followed: farther is a sweep round
TOUCH_MM = 1.0  # an arm that the ball touches may come so much nearer to it where it draws back
UNDER_WAY = 0.5  # of the ball's radius: a way under way is left only where it leads clearly through the ball
WRONG_SIDE = "the arm would have to swing round: cover the ball for a moment (a card on a stick), and it comes anew"
IN_THE_WAY = "the arm would sweep through the ball: move the ball to another place"


class _NoWayError(UnreachableTargetError):
    """A place that the arm reaches, but should not go to from where it is."""


@dataclass(frozen=True)
class Step:
    """What the arm was asked for at one picture.

    Attributes
    ----------
    time_s : float, when that was, by the clock of the pictures
    wanted : JointAngles, where the joints should be when the order is there; or None: it stays where it is
    reached : JointAngles, where they were when it was sent, by the encoders
    counts : (int, int), the encoders' edges from zero
    lost : int, edges that the controller missed since its start
    said : str, "follows", or why it does not
    """

    time_s: float
    wanted: JointAngles | None
    reached: JointAngles
    counts: tuple[int, int]
    lost: int
    said: str


def switch_on(arm: Arm) -> None:
    """Switch the motors of an arm on that knows where it stands: whoever used it last left them off.

    Raises
    ------
    ArmError
        If a stop holds it. It was not this program that stopped it, so that somebody must look first.
    """
    if arm.status().state == "stop":
        arm.check()
    arm.enable()


class Follower:
    """Keeps the hand of an arm at a ball, a little before its surface, with the forearm pointing at its middle.

    A ball that is out of reach, or more than its radius off the plane in which the hand moves, is not followed; a step says so.
    The elbow stays on one side as long as one ball is followed, and the shoulder does not swing round: the whole arm would sweep
    through the ball, or through whoever holds it. Nor does the arm set off to a ball by a way that leads through it, unless a
    function of your own says so.

    Parameters
    ----------
    arm : stereo_lab.arm.Arm, homed
    recording : Recording, which says where the arm stands, how long its links are and how large the ball is
    predict : bool or function
        Aim at where the ball will be when the order is with the arm. False: at where the ball was in the picture. A function of
        your own takes (place_mm, velocity_mm_s, seconds) for each coordinate and gives the place after so many seconds.
    gap_mm : float, between hand and ball, not below zero
    inverse : function, optional
        Your own way from the middle of a ball in the arm's plane, (x_mm, y_mm), to (theta1_deg, theta2_deg), in place of the
        kit's. It counts with a forearm that is longer by ``beyond_mm``; what it gives is checked against the limits.
    run_on : bool
        Where the arm aims ahead: order a goal that lies farther on by the way that the arm needs to brake, so that it passes the
        ball's place with the ball's speed.

    Attributes
    ----------
    beyond_mm : float, from the end of the hand to the middle of the ball
    follows : bool; switched off, the arm stays where it is
    """

    def __init__(
        self,
        arm: Arm,
        recording: Recording,
        predict: bool | Callable[[float, float, float], float] = True,
        gap_mm: float = GAP_MM,
        inverse: Callable[[float, float], tuple[float, float]] | None = None,
        run_on: bool = True,
    ) -> None:
        gap_mm = finite_number(gap_mm, "gap_mm")
        if gap_mm < 0:
            raise StereoLabError(f"gap_mm: expected 0 mm or more, got {gap_mm:g}: the hand would push into the ball.")
        must_be_homed(arm, "its angles mean nothing before")
        must_be_recording(recording)
        self.arm, self.predict, self.inverse, self.follows = arm, predict, inverse, True
        self._runs_on = run_on and bool(predict)
        self.stands, self.radius_mm = recording.registration, recording.ball.diameter_mm / 2
        self.beyond_mm = self.radius_mm + gap_mm
        self._brakes = [arm.get(joint, "acc") for joint in (1, 2)]
        self._edges = [arm.get(joint, "counts") for joint in (1, 2)]
        self._in_a_row, self._steers, self._before_s = 0, False, math.inf
        self._wanted: JointAngles | None = None  # what this ball was followed with last: it holds the elbow's side

    def steer(self, track: Track | None, now_s: float) -> Step:
        """Send the arm where the ball is, or will be.

        Parameters
        ----------
        track : Track or None, the ball
        now_s : float, the time by the clock of the pictures

        Raises
        ------
        ArmError
            If the arm is off, stopped, or does not answer.
        """
        status = self.arm.check()
        reached, wanted = JointAngles(*status.position_deg), None
        said = self._why_not(track)
        if not said:
            try:
                wanted = self._aim(track, now_s, reached)
                said = "follows"
            except _NoWayError as error:
                said = str(error)
            except UnreachableTargetError:
                said = "the ball is out of reach"
        if wanted is None and self._steers:
            self.rest()
        first, second = (round(p * n / 360) for p, n in zip(status.position_deg, self._edges, strict=True))
        return Step(now_s, wanted, reached, (first, second), status.lost, said)

    def rest(self) -> None:
        """End a move under way; the arm holds where it comes to rest."""
        self.arm.command("ST")
        self._steers = False

    def leave(self) -> None:
        """The same, whatever state the arm is in: one that is gone stops by itself."""
        if self._steers:
            with contextlib.suppress(ArmError):
                self.rest()

    def _why_not(self, track):
        """Why this ball is not followed; empty where it is."""
        self._in_a_row = 0 if track is None else self._in_a_row + track.seen
        if track is None:
            self._wanted = None
            return "no ball"
        if not self.follows:
            return "following is switched off"
        if self._in_a_row < STEADY:
            return "a new ball"
        off_mm = self.stands.in_arm(*_place(track.position))[2]
        if abs(off_mm) > self.radius_mm:
            return f"the ball is {abs(off_mm):.0f} mm {'before' if off_mm > 0 else 'behind'} the arm's plane"
        return ""

    def _aim(self, track, now_s, reached):
        """Order the angles of the hand at the ball; gives them."""
        between_s = min(max(now_s - self._before_s, 0.0), MOST_BETWEEN_S)
        ready_s, self._before_s = now_s + ANSWERS_S + between_s / 2, now_s
        ball = self._ball_at(track, ready_s)
        wanted = self._wanted = self._free_pose(ball, reached)
        goal = self._where_it_could_stop(wanted, track, ready_s) if self._runs_on else wanted
        percent = self._percent(goal)
        self._steers = True  # from here on: whatever interrupts the order may leave the arm on its way
        self.arm.steer(goal, percent)
        return wanted

    def _ball_at(self, track, time_s):
        """Where the ball will be at a time, by whichever way was chosen."""
        if not callable(self.predict):
            return track.at(time_s) if self.predict else track.position
        ahead_s = time_s - track.time_s
        places = zip(_place(track.position), track.velocity_mm_s, strict=True)
        return Position(*(_yours(self.predict, "predict", 1, p, v, ahead_s)[0] for p, v in places))

    def _free_pose(self, ball, reached):
        """The pose with the hand before a ball to which the arm comes without sweeping through it; of two, the one with more room."""
        poses = self._poses(ball, self._wanted if self._steers else reached)
        free = [pose for pose in poses if self.inverse is not None or self._is_free(reached, pose, _place(ball))]
        if not free:
            raise _NoWayError(IN_THE_WAY)
        return max(free, key=self._room_deg)

    def _is_free(self, reached, pose, place):
        """Whether the links keep off a ball on their way, or come no nearer where it touches them."""
        least_mm = self.radius_mm * (UNDER_WAY if self._steers else 1.0)
        here_mm, way_mm = (self.stands.clearance_mm((reached, end), *place) for end in (reached, pose))
        return way_mm > min(least_mm, here_mm - TOUCH_MM)

    def _poses(self, ball, start):
        """The poses with the hand before a ball; once it is followed, those that are near to ``start`` and on the elbow's side."""
        poses = [self._turned(pose, start) for pose in self.stands.solutions(*_place(ball), beyond_mm=self.beyond_mm)]
        if self.inverse is not None:
            x, y, _ = self.stands.in_arm(*_place(ball)).tolist()
            poses = [JointAngles(*_yours(self.inverse, "inverse", 2, x, y))]
            self.arm.goals_deg(poses[0])  # refuses what is beyond a limit
        if self._wanted is None:
            return poses
        side = self._wanted.theta2_deg
        near = [p for p in poses if p.theta2_deg * side >= 0 and abs(p.theta1_deg - start.theta1_deg) <= FARTHEST_DEG]
        if not near:
            raise _NoWayError(WRONG_SIDE)
        return near

    def _turned(self, pose, start):
        """The same pose with θ1 a whole turn more or less, where that is nearer and within the limits."""
        low, high = self.stands.limits_deg[0]
        turns = [pose.theta1_deg + whole for whole in (-360.0, 0.0, 360.0)]
        allowed = [turn for turn in turns if low <= turn <= high] or [pose.theta1_deg]
        return JointAngles(min(allowed, key=lambda turn: abs(turn - start.theta1_deg)), pose.theta2_deg)

    def _where_it_could_stop(self, wanted, track, ready_s):
        """A profile brakes before its goal. With its goal so far beyond, it passes the wanted angles at the ball's speed."""
        try:
            later = self._poses(self._ball_at(track, ready_s + LOOK_S), wanted)[0]
            turns = later.theta1_deg - wanted.theta1_deg, later.theta2_deg - wanted.theta2_deg
            speeds = [turn / LOOK_S for turn in turns]
            ways = [speed * abs(speed) / (2 * brakes) for speed, brakes in zip(speeds, self._brakes, strict=True)]
            goal = JointAngles(wanted.theta1_deg + ways[0], wanted.theta2_deg + ways[1])
            self.arm.goals_deg(goal)
            return goal
        except UnreachableTargetError:  # the ball leaves the reach: go to its edge
            return wanted

    def _percent(self, goal):
        """How fast, of 100: slower towards a limit of a joint."""
        return min(100.0, max(LEAST_PERCENT, 100 * self._room_deg(goal) / SLOW_DEG))

    def _room_deg(self, pose):
        """How far a pose is from the nearest limit of a joint."""
        angles = (pose.theta1_deg, pose.theta2_deg)
        return min(min(a - low, high - a) for a, (low, high) in zip(angles, self.arm.limits_deg, strict=True))


def hand_to_ball(moments: Sequence[Moment], recording: Recording, beyond_mm: float) -> tuple[np.ndarray, np.ndarray]:
    """How far the hand was from where it should have been, by the encoders, while the arm followed.

    No picture shows where the ball is while an order goes out. So its place then is read off between the pictures before and after.
    Those carry the times that the source told: the delay that real cameras have of their own is in none of these numbers.

    Parameters
    ----------
    moments : sequence of Moment, of one run
    recording : Recording, which says where the arm stands
    beyond_mm : float, from the end of the hand to the middle of the ball; see :class:`Follower`

    Returns
    -------
    time_s, gap_mm : ndarray, shape (N,)
    """
    steps, x_mm, y_mm = ball_when_ordered(moments, recording)
    tip = recording.registration.arm.extended(beyond_mm)
    zeros = recording.registration.values[5:7]
    hands = [tip.forward(JointAngles(s.reached.theta1_deg + zeros[0], s.reached.theta2_deg + zeros[1])) for s in steps]
    hand_x, hand_y = np.array(hands, float).reshape(-1, 2).T
    return np.array([step.time_s for step in steps]), np.hypot(hand_x - x_mm, hand_y - y_mm)


def ball_when_ordered(moments: Sequence[Moment], recording: Recording) -> tuple[list[Step], np.ndarray, np.ndarray]:
    """The orders of a run, and where the ball was as each went out: read off between the pictures before and after.

    Parameters
    ----------
    moments : sequence of Moment, of one run
    recording : Recording, which says where the arm stands

    Returns
    -------
    steps : list of Step, those in which the arm followed
    x_mm, y_mm : ndarray, shape (N,), in the arm's plane
    """
    seen = [m for m in moments if m.track is not None and m.track.seen]
    if not seen:
        raise StereoLabError(
            "The ball was not seen in any picture of the run. Is it in the picture, and of its colour?"
        )
    when, x, y = (
        np.array(values, float)
        for values in zip(*((m.frame.time_s, *_in_plane(recording, m)) for m in seen), strict=True)
    )
    steps = [m.step for m in moments if m.step is not None and m.step.wanted is not None and m.step.time_s <= when[-1]]
    time_s = np.array([step.time_s for step in steps])
    return steps, np.interp(time_s, when, x), np.interp(time_s, when, y)


def _in_plane(recording, moment):
    return recording.registration.in_arm(*_place(moment.track.position))[:2]


def _place(position: Position) -> tuple[float, float, float]:
    return position.x_mm, position.y_mm, position.depth_mm


def _yours(function, name, count, *values):
    """So many numbers from a function of somebody's own; where it stops or gives something else, a sentence."""
    try:
        given = function(*values)
        numbers = np.atleast_1d(np.asarray(given, float))
    except Exception as error:
        raise StereoLabError(f"Your function for {name}= stopped when it got {_told(values)}: {error}.") from error
    no_place = name == "predict" and not np.isfinite(numbers).all()  # an inverse says so where a ball is out of reach
    if given is None or numbers.shape != (count,) or no_place:
        gave = "None: is its return missing?" if given is None else f"{numbers.tolist()}."
        raise StereoLabError(
            f"Your function for {name}= should give {('one number', 'two numbers')[count - 1]}; "
            f"it got {_told(values)} and gave {gave}"
        )
    return numbers.tolist()


def _told(values):
    return "(" + ", ".join(f"{value:.4g}" for value in values) + ")"

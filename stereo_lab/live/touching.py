"""Touch some balls in turn: wait for one that lies still, reach for it, back off, wait for the next."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing
from typing import Any

import numpy as np

from stereo_lab.arm.measuring import must_be_homed
from stereo_lab.errors import UnreachableTargetError
from stereo_lab.kinematics import JointAngles
from stereo_lab.live.run import Sink, run
from stereo_lab.live.sources import StereoSource
from stereo_lab.localization import Localizer
from stereo_lab.localization.localizer import must_lead_an_arm
from stereo_lab.recording import Recording

STILL, STILL_MM = 10, 3.0  # a ball lies still that was seen so often in a row within so many mm
PATIENCE_S = 60.0
BEFORE_MM = 30.0  # before the ball the arm stops; the last bit goes straight in
BESIDE_MM = 20.0  # between a ball and the middle of a link that passes it: half the link's width, and some more


def touch_in_turn(
    source: StereoSource,
    localizer: Localizer,
    arm: Any,
    recording: Recording,
    balls: int = 3,
    move_on: Callable[[int], None] = lambda touched: None,
    sinks: Sequence[Sink] = (),
    patience_s: float = PATIENCE_S,
) -> Iterator[str]:
    """Touch balls, or one ball in several places, and go home.

    Parameters
    ----------
    source : StereoSource
    localizer : Localizer
    arm : stereo_lab.arm.Arm, homed
    recording : Recording, which says where the arm stands and how large the ball is
    balls : int, how many are touched
    move_on : function (how many were touched so far), called when the hand is off the ball again
    sinks : sequence of Sink
    patience_s : float, so long it waits for a ball that it can touch, by the clock of the pictures

    Yields
    ------
    str
        What happens, in words. It ends early where the pictures end, or no ball comes.

    Raises
    ------
    StereoLabError
        If the arm is not homed, the localizer would mislead it, a camera falls silent, or the arm stops or does not answer.
    """
    must_be_homed(arm, "its angles mean nothing before")
    must_lead_an_arm(localizer)
    radius, touched = recording.ball.diameter_mm / 2, np.empty((0, 3))
    while len(touched) < balls:
        yield f"ball {len(touched) + 1} of {balls}: waiting for one that lies still"
        place = yield from _one_that_lies_still(source, localizer, recording, touched, sinks, patience_s)
        if place is None:
            break
        *before, at = _way(recording, arm, place, radius)
        for pose in before:
            arm.move_to(pose)
        reached = arm.move_to(at, one_side=True)
        x, y, depth = place
        words = f"touched ball {len(touched) + 1} at x {x:.0f}, y {y:.0f}, depth {depth:.0f} mm"
        for sink in sinks:
            sink.write(
                {
                    "time_s": source.now(),
                    "said": words,
                    "reached1_deg": reached.theta1_deg,
                    "reached2_deg": reached.theta2_deg,
                }
            )
        yield words
        arm.move_to(before[-1])
        touched = np.vstack([touched, place])
        move_on(len(touched))
    arm.home()
    yield "home"


def _way(recording, arm, place, radius):
    """The poses from where the arm is to a ball: round it, not through it.

    At the ball both joints arrive turning clockwise. With the elbow up (θ2 below zero) the upper arm draws the hand back by that;
    with the elbow down the hand would first press some millimetres into the ball. Else the shortest way is taken.
    """
    now, stands = arm.angles(), recording.registration
    start1, start2 = (
        min(max(angle, low), high)
        for angle, (low, high) in zip((now.theta1_deg, now.theta2_deg), arm.limits_deg, strict=True)
    )
    before, at = (stands.solutions(*place, beyond_mm=radius + gap) for gap in (BEFORE_MM, 0.0))
    ways = [
        (*first, near, there)
        for near in before
        for there in at
        if (near.theta2_deg >= 0) == (there.theta2_deg >= 0)
        for first in ((), (JointAngles(near.theta1_deg, start2),), (JointAngles(start1, near.theta2_deg),))
    ]
    if not ways:
        raise UnreachableTargetError("one of two poses is out of reach")

    def rank(way):
        poses = (now, *way[:-1])
        clear_mm = min(stands.clearance_mm(poses, *place), radius + BESIDE_MM)
        return -clear_mm, way[-1].theta2_deg > 0, sum(map(_turn, poses[:-1], poses[1:]))

    return min(ways, key=rank)


def _turn(now: JointAngles, then: JointAngles) -> float:
    return max(abs(then.theta1_deg - now.theta1_deg), abs(then.theta2_deg - now.theta2_deg))


def _one_that_lies_still(source, localizer, recording, touched, sinks, patience_s):
    """The mean place of a ball that lies still and can be touched, at another place than those before; or None."""
    places, told = deque(maxlen=STILL), ""
    radius = recording.ball.diameter_mm / 2
    until_s = source.now() + patience_s
    with closing(run(source, localizer, sinks=sinks)) as moments:
        for moment in moments:
            if moment.frame.time_s > until_s:
                yield f"no ball to touch for {patience_s:.0f} s"
                return None
            track = moment.track
            if track is None or not track.seen:
                places.clear()
                continue
            p = track.position
            places.append((p.x_mm, p.y_mm, p.depth_mm))
            mean = np.mean(places, axis=0)
            if len(places) < STILL or np.abs(places - mean).max() > STILL_MM:
                continue
            if len(touched) and np.linalg.norm(touched - mean, axis=1).min() < 2 * radius:
                words = "move the ball to another place"
            else:
                words = _why_not(recording, mean, radius)
            if not words:
                return mean
            if words != told:
                yield words
            told = words
    yield "the pictures have ended"
    return None


def _why_not(recording, place, radius):
    """Why a ball cannot be touched; empty where it can."""
    stands = recording.registration
    off_mm = stands.in_arm(*place)[2]
    if abs(off_mm) > radius:
        return f"the ball is {abs(off_mm):.0f} mm {'before' if off_mm > 0 else 'behind'} the arm's plane"
    try:
        for gap in (0.0, BEFORE_MM):
            stands.solutions(*place, beyond_mm=radius + gap)
    except UnreachableTargetError:
        return "the ball is out of reach"
    return ""

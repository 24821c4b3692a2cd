"""The whole cell at work: pictures, a place, two angles, two motors, and what all of it costs."""

from __future__ import annotations

import contextlib
import time
from collections import deque
from collections.abc import Generator, Sequence
from dataclasses import dataclass, replace
from typing import Any, Protocol

import numpy as np

from stereo_lab.common.memory import keep_freed_memory
from stereo_lab.common.threads import one_thread
from stereo_lab.errors import StereoLabError
from stereo_lab.live.follower import Follower, Step
from stereo_lab.live.sources import Frame, StereoSource
from stereo_lab.live.tracker import Track, Tracker
from stereo_lab.live.usage import Usage
from stereo_lab.localization import Localizer
from stereo_lab.localization.localizer import must_lead_an_arm

RATE_OVER = 30  # pictures over which the rate is told


class Sink(Protocol):
    """What takes the records of a run: a file, the network."""

    def write(self, record: dict[str, Any]) -> None:
        """Take one record. Never raises, and never waits for long."""


@dataclass(frozen=True, eq=False)
class Moment:
    """One pair of pictures, and all that came of it.

    Attributes
    ----------
    number : int, from 0
    frame : Frame
    track : Track or None, the ball
    step : Step or None, the arm; None where there is none
    stages_ms : dict, what waiting for the pair, finding the ball, and steering took
    latency_ms : float, from the picture to the arm's order, or without an arm to the ball's place
    rate_hz : float, pairs a second that are dealt with
    cpu_percent, rss_mb : float, of this program, see :class:`stereo_lab.live.usage.Usage`
    """

    number: int
    frame: Frame
    track: Track | None
    step: Step | None
    stages_ms: dict[str, float]
    latency_ms: float
    rate_hz: float
    cpu_percent: float
    rss_mb: float

    @property
    def said(self) -> str:
        """What happens, in words."""
        if self.step is not None:
            return self.step.said
        if self.track is None:
            return "no ball"
        return "sees the ball" if self.track.seen else "the ball is hidden"

    def without_pictures(self) -> Moment:
        """The same without its two pictures: a minute of them fills the memory of a small computer."""
        nothing = np.empty((0, 0, 3), np.uint8)
        return replace(self, frame=replace(self.frame, left=nothing, right=nothing))

    def record(self) -> dict[str, Any]:
        """It as flat plain values, for a log; what is not known is left out."""
        facts: dict[str, Any] = {"number": self.number, "time_s": round(self.frame.time_s, 4), "said": self.said}
        facts |= {"skew_ms": round(1000 * self.frame.skew_s, 2), "dropped": self.frame.dropped}
        facts |= {} if self.track is None else _of_track(self.track)
        facts |= {} if self.step is None else _of_step(self.step)
        facts |= {f"{stage}_ms": round(ms, 2) for stage, ms in self.stages_ms.items()}
        facts |= {"latency_ms": round(self.latency_ms, 2), "rate_hz": round(self.rate_hz, 2)}
        facts |= {"cpu_percent": round(self.cpu_percent, 1)} if self.cpu_percent else {}  # 0: no second has passed
        return facts | {"rss_mb": round(self.rss_mb, 1)}


def _of_track(track):
    place, facts = track.position, {"seen": track.seen}
    for name, value in zip(("x_mm", "y_mm", "depth_mm"), (place.x_mm, place.y_mm, place.depth_mm), strict=True):
        facts[name] = round(value, 2)
    for name, value in zip(("sigma_x_mm", "sigma_y_mm", "sigma_depth_mm"), place.sigma_mm, strict=True):
        facts[name] = round(value, 2)
    for name, value in zip(("vx_mm_s", "vy_mm_s", "vdepth_mm_s"), track.velocity_mm_s, strict=True):
        facts[name] = round(value, 1)
    for side, ball in zip(("left", "right"), track.detections or (), strict=False):
        facts |= {f"{side}_u": round(ball.u, 2), f"{side}_v": round(ball.v, 2), f"{side}_score": round(ball.score, 3)}
    return facts


def _of_step(step):
    facts = {} if step.wanted is None else _angles("wanted", step.wanted)
    facts |= _angles("reached", step.reached)
    return facts | {"counts1": step.counts[0], "counts2": step.counts[1], "lost_edges": step.lost}


def _angles(name, angles):
    return {f"{name}{j}_deg": round(a, 2) for j, a in enumerate((angles.theta1_deg, angles.theta2_deg), start=1)}


def run(
    source: StereoSource,
    localizer: Localizer,
    follower: Follower | None = None,
    sinks: Sequence[Sink] = (),
    seconds: float | None = None,
) -> Generator[Moment, None, None]:
    """Locate the ball in pair after pair, and let an arm follow it.

    Parameters
    ----------
    source : StereoSource
    localizer : Localizer, fitted to the cameras of the source
    follower : Follower, optional
    sinks : sequence of Sink, told each moment's record
    seconds : float, optional, of pictures, after which it ends; else it ends with the source

    Yields
    ------
    Moment
        However it ends, also by an error, the arm ends its move and holds where it is. It ends by ``break`` as well, but not
        where the generator has a name: then close it (``contextlib.closing``).

    Raises
    ------
    StereoLabError
        If a camera falls silent, the arm stops or does not answer, ``source`` is none, or the localizer would mislead an arm.
    """
    if not hasattr(source, "read"):
        raise StereoLabError(
            f"Expected a source of pictures first, as open_source gives it, and then the localizer; got {type(source).__name__}."
        )
    if follower is not None:
        must_lead_an_arm(localizer)
    tracker, usage, came, first_s = Tracker(localizer), Usage(), deque[float](maxlen=RATE_OVER + 1), None
    threads = contextlib.ExitStack()
    threads.enter_context(one_thread())  # windows of some pixels are not worth sharing out: more threads only wait
    keep_freed_memory()
    number = 0
    try:
        while True:
            start = time.perf_counter()
            frame = source.read()
            if frame is None:
                return
            old_s = source.now() - frame.time_s
            came.append(time.perf_counter())
            first_s = frame.time_s if first_s is None else first_s
            track = tracker.update(frame)
            found = time.perf_counter()
            step = None if follower is None else follower.steer(track, source.now())
            done = time.perf_counter()
            usage.update()
            stages = {"wait": came[-1] - start, "find": found - came[-1], "steer": done - found}
            rate = (len(came) - 1) / (came[-1] - came[0]) if len(came) > 1 else source.rate_hz
            latency = 1000 * (old_s + done - came[-1])
            stages_ms = {name: 1000 * s for name, s in stages.items()}
            moment = Moment(number, frame, track, step, stages_ms, latency, rate, usage.cpu_percent, usage.rss_mb)
            for sink in sinks:
                sink.write(moment.record())
            yield moment
            number += 1
            if seconds is not None and frame.time_s - first_s >= seconds:
                return
    finally:
        threads.close()
        if follower is not None:
            follower.leave()

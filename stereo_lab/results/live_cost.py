"""What the live cell costs: the run of the paper again, 653 pairs at ten a second, and the way from a picture to the arm.

The run is measured in a process of its own, which does nothing else, and the simulated arm in another one, which is not counted.
"""

from __future__ import annotations

import contextlib
import json
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from stereo_lab.arm import connect
from stereo_lab.arm.virtual.served import served_arm
from stereo_lab.errors import StereoLabError
from stereo_lab.kinematics import JointAngles
from stereo_lab.live import Follower, RecordingSource, VirtualBench, open_source, round_trip, run
from stereo_lab.live.sources import FILM, Pace
from stereo_lab.localization import Localizer
from stereo_lab.recording import Recording, open_recording

PAPERS_PAIRS, PAPERS_RATE_HZ = 653, 10.0
PAPERS_CPU, PAPERS_RSS_MB = 23.37, 155.71  # means
SECONDS = 8.0  # of the virtual bench, for the other measures
LATE, SPEED_MM_S = 2, 100.0  # pictures, and how fast the ball goes
Report = Callable[[str, int, int], object]


class ToAndFro(RecordingSource):
    """The film of a recording forwards and backwards, again and again: as many pairs as are wanted.

    Parameters
    ----------
    recording : Recording with a film
    pairs : int
    rate_hz : float
    """

    def __init__(self, recording: Recording, pairs: int, rate_hz: float) -> None:
        super().__init__(recording, FILM)
        film = [*self.pairs, *self.pairs[-2:0:-1]]
        self.pairs = tuple(film[k % len(film)] for k in range(pairs))
        self.rate_hz, self._pace = rate_hz, Pace(rate_hz, time.monotonic, time.sleep)


def whole_run(
    recording: Recording, pairs: int = PAPERS_PAIRS, report: Report = lambda step, done, total: None
) -> dict[str, Any] | None:
    """The paper's run on this computer; None where the recording has no film.

    Parameters
    ----------
    recording : Recording
    pairs : int
    report : callable (step, done, total), told about progress

    Returns
    -------
    dict : "pairs", "rate_hz", "cpu_percent" and "rss_mb" (means), "cpu" and "rss" (each second's), "lost" (pairs in which no
        ball was found)
    """
    if FILM not in recording.sets:
        return None
    with served_arm() as url:
        words = [sys.executable, "-m", __name__, str(recording.path), url, str(pairs)]
        process = subprocess.Popen(words, stdout=subprocess.PIPE, text=True)
        assert process.stdout is not None
        try:
            for line in process.stdout:
                if line.startswith("{"):
                    return json.loads(line)
                report("the paper's run again, by the clock", int(line), pairs)
        finally:
            process.kill()
            process.communicate()
    raise StereoLabError("The measured run ended before its time. Run `stereo-lab run` to see why.")


def _measured(path: Path, url: str, pairs: int) -> None:
    """In the process that is measured: how far it is, line by line, and at the end the facts."""
    recording = open_recording(path)
    localizer, lost = Localizer.fit(recording), 0
    with connect(url) as arm, ToAndFro(recording, pairs, PAPERS_RATE_HZ) as source:
        arm.home()
        cpu, rss = [], []
        start_s, spent_s = time.monotonic(), time.process_time()
        for moment in run(source, localizer, Follower(arm, recording)):
            lost += moment.track is None or not moment.track.seen
            if moment.number % PAPERS_RATE_HZ == 0:
                cpu.append(moment.cpu_percent)
                rss.append(moment.rss_mb)
                print(moment.number, flush=True)
        taken_s = time.monotonic() - start_s
        percent = 100 * (time.process_time() - spent_s) / taken_s
    facts = {
        "pairs": moment.number + 1,
        "rate_hz": moment.number / taken_s,
        "cpu_percent": percent,
        "rss_mb": float(np.mean(rss)),
    }
    print(json.dumps({**facts, "cpu": cpu[1:], "rss": rss, "lost": lost}), flush=True)


def to_the_arm(recording: Recording) -> dict[str, Any] | None:
    """From a picture to the arm's order, on the virtual bench by the clock; None where its cameras are not known.

    Returns
    -------
    dict : "median", "p95" (ms, at 30 pairs a second), "pairs_a_second" (as fast as it goes)
    """
    if "cameras" not in recording.truth:
        return None
    localizer = Localizer.fit(recording)
    with _cell(recording, "virtual://arm?realtime=1") as (arm, source):
        latency = [m.latency_ms for m in run(source, localizer, Follower(arm, recording), seconds=SECONDS)][10:]
        fast = VirtualBench(recording, arm.port, fast=True)
        fast.path = source.path
        start = time.perf_counter()
        count = sum(1 for _ in run(fast, localizer, Follower(arm, recording), seconds=SECONDS / 2))
        rate = count / (time.perf_counter() - start)
    told = dict(zip(("median", "p95"), np.percentile(latency, [50, 95]).tolist(), strict=True))
    return {**told, "pairs_a_second": rate}


def hand_at_ball(recording: Recording) -> dict[str, float] | None:
    """Hand to a ball that goes round at 100 mm/s, two pictures late, by the links of the virtual arm; mean, mm.

    Returns
    -------
    dict : "seen" (aiming at where the ball was seen), "ahead" (aiming ahead); None where the cameras are not known
    """
    if "cameras" not in recording.truth:
        return None
    localizer = Localizer.fit(recording)
    return {name: _mean_gap(recording, localizer, predict) for name, predict in (("seen", False), ("ahead", True))}


def _mean_gap(recording, localizer, predict):
    with _cell(recording, "virtual://arm", late=LATE) as (arm, source):
        follower = Follower(arm, recording, predict=predict)
        tip = recording.arm.extended(follower.beyond_mm)
        gaps = []
        for moment in run(source, localizer, follower, seconds=SECONDS):
            x, y, _ = source.path(source.now())
            hand = tip.forward(JointAngles(*arm.port.link_deg))
            gaps += [float(np.hypot(hand[0] - x, hand[1] - y))] if moment.frame.time_s > SECONDS / 4 else []
    return float(np.mean(gaps))


@contextlib.contextmanager
def _cell(recording: Recording, url: str, late: int = 0) -> Iterator[Any]:
    """A homed virtual arm on its virtual bench, the ball going round; by the clock, or in the arm's own time."""
    with connect(url) as arm:
        arm.set_limits(recording.arm.limits_deg)
        arm.home()
        source = open_source("virtual", recording=recording, arm=arm, late=late)
        source.path = round_trip(recording, SPEED_MM_S)  # type: ignore[attr-defined]
        yield arm, source


def page(facts: dict[str, Any]) -> list[str]:
    """What was found as lines of text; what was not measured is left out."""
    lines = ["The live cell"]
    if (run_ := facts.get("run")) is not None:
        lines.append(
            f"  {run_['pairs']} pairs at {run_['rate_hz']:.1f} a second: {run_['cpu_percent']:.1f} % of one core (the paper's computer: "
            f"{PAPERS_CPU:.1f}), {run_['rss_mb']:.0f} MB ({PAPERS_RSS_MB:.0f}); {run_['lost']} lost"
        )
    if (way := facts.get("latency_ms")) is not None:
        lines.append(f"  picture to the arm's order: median {way['median']:.0f} ms, 95 % {way['p95']:.0f} ms")
        lines.append(f"  virtual bench with its arm, as fast as it goes: {way['pairs_a_second']:.0f} pairs a second")
    if (gap := facts.get("hand_mm")) is not None:
        lines.append(f"  hand to a ball at 100 mm/s, mean: {gap['seen']:.1f} mm, aiming ahead {gap['ahead']:.1f} mm")
    return [*lines, ""]


if __name__ == "__main__":
    _measured(Path(sys.argv[1]), sys.argv[2], int(sys.argv[3]))

"""Speed and accuracy beside the alternatives: the numbers behind ``stereo-lab bench``.

Times are told beside that of the first way of their group, measured in the same run: they differ from
computer to computer, their ratios hardly do. Pictures lie in memory and OpenCV has one thread.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import cv2
import numpy as np

from stereo_lab.arm import JointAngles, TwoLinkArm, connect
from stereo_lab.common.threads import one_thread
from stereo_lab.detection import Detection
from stereo_lab.localization import Localizer
from stereo_lab.recording import Position, Recording
from stereo_lab.results import live_cost, scaling, speeds

PAIRS = 24
POINTS = 1_000_000
ONE_BY_ONE = 300
SEARCHES = 20
MOVES = 12
NEAR, DENSE = "cone, near the last place", "dense stereo (SGBM), at the ball"


def benchmark(
    recording: Recording, report: Callable[[str, int, int], object] = lambda step, done, total: None
) -> dict[str, Any]:
    """Measure each way of doing a thing, in one run.

    Parameters
    ----------
    recording : Recording with the sets calibration, position, depth and evaluation
    report : callable (step, done, total), told about progress

    Returns
    -------
    dict : name of the group -> list of dict with "way", "ms" (milliseconds for one), "times" (how many times
        faster than the first way), "error_mm" (mean), and for the virtual arm "times" against the clock;
        "detecting" as :func:`stereo_lab.results.speeds.detecting` gives it, "scaling" as :func:`stereo_lab.results.scaling.scaling`;
        "ratios", "errors_mm", "cpu_percent", "rss_mb", "latency_ms", "run" and "hand_mm" sum up, None where nothing tells them
    """
    found = speeds.detecting(recording, report)
    with one_thread():
        vision = locating(recording, report)
        report("inverse kinematics", 0, 1)
        solving = inverse_kinematics(recording.arm)
        report("the virtual arm", 0, 1)
        moving = virtual_arm()
    groups = {
        "detecting": found,
        "scaling": scaling.scaling(recording, report),
        "locating": _beside(vision),
        "inverse_kinematics": _beside(solving),
        "virtual_arm": moving,
    }
    return {**groups, **_summed_up(groups), **_live(recording, report)}


def _summed_up(groups):
    """The three ratios and the errors that the kit is judged by."""
    ms = {row["way"]: row["ms"] for row in groups["locating"]}
    followed = ms.get(NEAR)
    ratios = {
        "search_vs_paper": _times(groups, "cone, whole picture"),
        "track_vs_paper": _times(groups, NEAR),
        "track_vs_sgbm": ms[DENSE] / followed if followed and DENSE in ms else None,
    }
    return {"ratios": ratios, "errors_mm": {row["way"]: row["error_mm"] for row in groups["locating"]}}


def _times(groups, way):
    """How many times faster than the paper's chain one way is, on the first set that has it."""
    return next((row["times"] for row in groups["detecting"] if row["way"] == way), None)


def _live(recording, report):
    """What the live cell costs."""
    run = live_cost.whole_run(recording, live_cost.PAPERS_PAIRS, report)
    report("the way to the arm, by the clock", 0, 1)
    latency = live_cost.to_the_arm(recording)
    report("the hand at a moving ball", 0, 1)
    hand = live_cost.hand_at_ball(recording)
    told = {"cpu_percent": None, "rss_mb": None} if run is None else {k: run[k] for k in ("cpu_percent", "rss_mb")}
    return {"run": run, **told, "latency_ms": latency, "hand_mm": hand}


def page(groups: dict[str, Any]) -> str:
    """The groups as text for the terminal."""
    titles = {
        "locating": ("One pair of pictures to the ball's place", "depth, mean error (mm)"),
        "inverse_kinematics": ("One point to two joint angles", "hand, mean error (mm)"),
    }
    lines = speeds.page(groups["detecting"]) + scaling.page(groups["scaling"])
    for name, (title, error) in titles.items():
        lines += [f"{title:36s} {'ms':>10s} {'times as fast':>14s}   {error}", *map(_line, groups[name]), ""]
    if (dense := groups["ratios"]["track_vs_sgbm"]) is not None:
        lines += [f"  following is {dense:.0f} times as fast as dense stereo (SGBM)", ""]
    lines += live_cost.page(groups)
    lines += [f"{'The virtual arm':36s} {'':10s} {'times as fast as the clock':>14s}"]
    return "\n".join(lines + [f"  {row['way']:34s} {'':10s} {row['times']:14.3g}" for row in groups["virtual_arm"]])


def _line(row):
    missed = f"   ({row['missed']} of {row['of']} not found)" if row.get("missed") else ""
    return f"  {row['way']:34s} {row['ms']:10.3g} {row['times']:14.3g}   {row['error_mm']:.2f}{missed}"


def _beside(rows):
    return [{**row, "times": rows[0]["ms"] / row["ms"]} for row in rows]


def locating(
    recording: Recording, report: Callable[[str, int, int], object] = lambda step, done, total: None
) -> list[dict[str, Any]]:
    """The paper's way, ours searching the whole picture, ours told where to look, and dense stereo."""
    samples = [s for s in recording.samples("evaluation") if s.use == "volume"][:PAIRS]
    paper, cone = (Localizer.fit(recording, method) for method in ("paper", "cone"))
    dense, rng = DenseStereo(cone), np.random.default_rng(0)
    ways: dict[str, Callable[[tuple[np.ndarray, np.ndarray], Any, Any], Position | None]] = {
        "the paper's way": lambda pair, seen, near: paper.locate(*pair),
        "cone, whole pictures": lambda pair, seen, near: cone.locate(*pair),
        NEAR: lambda pair, seen, near: cone.locate(*pair, near=near),
        DENSE: lambda pair, seen, near: dense.locate(*pair, seen),
    }
    spent: dict[str, list[float]] = {name: [] for name in ways}
    errors: dict[str, list[float]] = {name: [] for name in ways}
    for k, sample in enumerate(samples):
        report("locate the ball", k, len(samples))
        pair = sample.pair.left, sample.pair.right
        seen = cone.detect(*pair)
        near = None if seen is None else tuple(speeds.expected(ball, rng) for ball in seen)
        for name, way in ways.items():
            ms, place = speeds.fastest(way, pair, seen, near)
            spent[name].append(ms)
            if place is not None:
                errors[name].append(abs(place.depth_mm - sample.reference.depth_mm))
    return [
        {"way": name, "ms": float(np.median(spent[name])), "error_mm": float(np.mean(errors[name])),
         "missed": len(samples) - len(errors[name]), "of": len(samples)}
        for name in ways if errors[name]
    ]  # fmt: skip


class DenseStereo:
    """A disparity for every pixel (cv2.StereoSGBM), and the ball's taken from it."""

    def __init__(self, localizer: Localizer) -> None:
        self.localizer, self.calibration = localizer, localizer.calibration
        largest = self.calibration.focal_px * self.calibration.baseline_mm / 400  # nothing nearer than 0.4 m
        self.matcher = cv2.StereoSGBM.create(0, 16 * int(np.ceil(largest / 16)), 5, 200, 800, 1, 0, 10, 100, 2)

    def locate(self, left: np.ndarray, right: np.ndarray, seen: tuple[Detection, Detection] | None) -> Position | None:
        """The ball's place, the disparity being the median inside its circle; None where there is none."""
        if seen is None:
            return None
        pictures = self.calibration.rectify(left, right)
        disparity = self.matcher.compute(*(cv2.cvtColor(p, cv2.COLOR_BGR2GRAY) for p in pictures)) / 16
        (u, v), radius = self.calibration.rectify_points([seen[0].center_px], "left")[0], seen[0].radius_px
        rows, columns = np.indices(disparity.shape)
        inside = disparity[(np.hypot(columns - u, rows - v) < radius / 2) & (disparity > 0)]
        if not len(inside):
            return None
        surface = np.median(inside)
        point = self.calibration.triangulate([[u, v]], [[u - surface, v]])
        way: Any = self.localizer.way  # the cone's, which knows the ball's diameter
        return way.on_bench(point * (1 + way.diameter_mm / 2 / np.linalg.norm(point)))  # from surface to centre


def inverse_kinematics(arm: TwoLinkArm) -> list[dict[str, Any]]:
    """Eq. 5 and 6 one by one and as arrays, a search, and ikpy where it is installed."""
    rng = np.random.default_rng(5)
    points = _reachable(arm, rng, POINTS)
    few = points[:ONE_BY_ONE]
    ms, angles = speeds.fastest(lambda: [arm.inverse(x, y) for x, y in few])
    rows = [_solved(arm, "Eq. 5 and 6, one by one", ms / len(few), angles, few)]
    ms, angles = speeds.fastest(lambda: arm.inverse(*points.T))
    rows.append(_solved(arm, "Eq. 5 and 6, a million as arrays", ms / len(points), [angles], points))
    few = points[:SEARCHES]
    ms, angles = speeds.fastest(lambda: [search(arm, x, y) for x, y in few])
    rows.append(_solved(arm, "a search with the Jacobian", ms / len(few), angles, few))
    chain = _ikpy_chain(arm)
    if chain is not None:
        ms, angles = speeds.fastest(lambda: [_by_ikpy(chain, x, y) for x, y in few])
        rows.append(_solved(arm, "the library ikpy", ms / len(few), angles, few))
    return rows


def _reachable(arm, rng, count):
    radius = rng.uniform(abs(arm.l1_mm - arm.l2_mm), arm.l1_mm + arm.l2_mm, count)
    turn = rng.uniform(-np.pi, np.pi, count)
    points = np.column_stack([radius * np.cos(turn), radius * np.sin(turn)])
    return points[np.isfinite(arm.inverse(*points.T).theta1_deg)]


def _solved(arm, way, ms, angles, points):
    hands = np.concatenate([np.column_stack(arm.forward(a)) for a in angles])
    return {"way": way, "ms": float(ms), "error_mm": float(np.hypot(*(hands - points).T).mean())}


def search(arm: TwoLinkArm, x_mm: float, y_mm: float, steps: int = 400) -> JointAngles:
    """Inverse kinematics by damped least squares, the search of lesson 05."""
    theta, goal = np.array([20.0, 40.0]), np.array([x_mm, y_mm])
    for _ in range(steps):
        now = JointAngles(*theta)
        miss = goal - arm.forward(now)
        if np.hypot(*miss) < 1e-6:
            break
        jacobian = arm.jacobian(now)
        theta = theta + jacobian.T @ np.linalg.solve(jacobian @ jacobian.T + 20 * np.eye(2), miss)
    return JointAngles(*theta)


def _ikpy_chain(arm):
    try:
        from ikpy.chain import Chain
        from ikpy.link import OriginLink, URDFLink
    except ImportError:
        return None
    about_z = {"origin_orientation": [0, 0, 0], "rotation": [0, 0, 1]}
    return Chain(
        [
            OriginLink(),
            URDFLink("shoulder", origin_translation=[0, 0, 0], **about_z),
            URDFLink("elbow", origin_translation=[arm.l1_mm / 1000, 0, 0], **about_z),
            URDFLink("hand", origin_translation=[arm.l2_mm / 1000, 0, 0], origin_orientation=[0, 0, 0], rotation=None,
                     joint_type="fixed"),
        ],
        active_links_mask=[False, True, True, False],
    )  # fmt: skip


def _by_ikpy(chain, x_mm, y_mm):
    found = chain.inverse_kinematics([x_mm / 1000, y_mm / 1000, 0], initial_position=[0, 0.3, 0.7, 0])
    return JointAngles(*np.degrees(found[1:3]))


def virtual_arm() -> list[dict[str, Any]]:
    """Seconds on the arm's clock for each second of ours: homing, then moves to and fro."""
    with connect("virtual://arm") as arm:
        homing = _pace(arm, arm.home)
        rng = np.random.default_rng(6)
        goals = [JointAngles(*rng.uniform(-150, 150, 2)) for _ in range(MOVES)]
        moving = _pace(arm, lambda: [arm.move_to(goal) for goal in goals])
    return [{"way": "homing", "times": homing}, {"way": f"{MOVES} moves", "times": moving}]


def _pace(arm, do):
    start, arm_start = time.perf_counter(), arm.line.clock()
    do()
    return (arm.line.clock() - arm_start) / (time.perf_counter() - start)

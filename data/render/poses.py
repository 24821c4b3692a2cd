"""Which frames a rig records: where the ball or the board is in each, drawn from the rig's seed.

Each set has a random stream of its own, so that a change in one set moves no other.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import clutter
import numpy as np
import scene
from places import EDGE_PX, bench_point, draw_point, stream


@dataclass(frozen=True)
class Frame:
    """One pair (or one left picture) to take."""

    name: str
    ball: tuple | None = None
    board: tuple | None = None  # (at, turn_deg)
    color: str = "red"
    carrier: str = "stand"
    light: str = "day"
    backdrop: int = 0  # which arrangement of extra props
    cover: dict | None = None  # a thing in front of the ball
    use: str = ""
    sides: tuple = ("left", "right")
    path: tuple = field(default=())  # where the ball is while the shutter is open
    place: str = ""  # shots of one place share one traced picture: only the sensor's noise differs


def plan(rig):
    """All frames of a rig: ``{set name: [Frame, ...]}``."""
    return {name: _plan_set(rig, name, spec) for name, spec in rig.sets.items()}


def _plan_set(rig, name, spec):
    rng = stream(rig, name)
    kind = spec["kind"]
    if kind == "boards":
        frames = _boards(rig, rng, spec)
    elif kind == "clutter":
        frames = clutter.frames(rig, rng, spec)
    else:
        frames = MAKERS[kind](rig, rng, spec)
    moved = spec.get("moved", {})  # balls put by hand where the draw would set them inside the furniture
    for name, place in moved.items():
        frames[int(name)]["ball"] = tuple(place)
    return [Frame(**{**frame, "name": f"{i:03d}"}) for i, frame in enumerate(frames)]


def _boards(rig, rng, spec):
    """Boards all over both pictures, tilted every way, near and far."""
    frames, count = [], spec["count"]
    while len(frames) < count:
        place_in_grid = len(frames) % 9
        for _ in range(4000):
            pose = _board_pose(rig, rng, spec["depth_mm"], place_in_grid)
            if _board_visible(rig, pose):
                break
        else:
            place_in_grid = 4
            continue
        frames.append(_calibration_frame(rig, pose))
    return frames


def _calibration_frame(rig, pose):
    return {"board": pose, "color": rig.recording["ball"]["color"]}


def _board_pose(rig, rng, depth_range, cell):
    """A board whose middle falls near one cell of a 3x3 grid over the left picture."""
    width, height = rig.left.image_size
    depth = rng.uniform(*depth_range)
    u = (cell % 3 + rng.uniform(0, 1)) / 3 * width
    v = (cell // 3 + rng.uniform(0, 1)) / 3 * height
    turn = (rng.uniform(-38, 38), rng.uniform(-38, 38), rng.normal(0, 14))
    return tuple(bench_point(rig, u, v, depth)), turn


def _board_visible(rig, pose):
    corners = scene.board_points(rig.recording["board"], *pose, rig.bend_mm)
    square = rig.recording["board"]["square_mm"]
    grown = corners + (corners - corners.mean(0)) * 2.0 * square / np.ptp(corners, 0).max()
    return all(camera.sees(p, EDGE_PX) for camera in rig.cameras.values() for p in grown)


def _in_reach(rig, point):
    arm = rig.recording["arm"]
    far, near = arm["l1_mm"] + arm["l2_mm"], abs(arm["l1_mm"] - arm["l2_mm"])
    return near + 30 < np.hypot(point[0], point[1]) < far - 5


def _plane_points(rig, rng, count):
    """Well-spread points of the arm's plane: each is the best of many, far from those before."""
    depth = rig.recording["arm"]["depth_mm"]
    chosen = []
    while len(chosen) < count:
        candidates = []
        while len(candidates) < 12:
            point = draw_point(rig, rng, (depth, depth))
            if _in_reach(rig, point):
                candidates.append(point)
        gaps = [min((np.linalg.norm(c - p) for p in chosen), default=0) for c in candidates]
        chosen.append(candidates[int(np.argmax(gaps))])
    return chosen


def _plane(rig, rng, spec):
    points = _plane_points(rig, rng, spec["count"])
    half = len(points) // 2
    return [_on_stand(rig, p, "fit" if i < half else "check") for i, p in enumerate(points)]


def _on_stand(rig, point, use="", **more):
    return {"ball": tuple(point), "color": rig.recording["ball"]["color"], "use": use, **more}


def _axis(rig, rng, spec):
    """Ever farther away, near the middle of the picture; the ends are for fitting."""
    nearest, farthest = spec["depth_mm"]
    depths = np.linspace(nearest + 20, farthest - 20, spec["count"])
    middle = (rig.cameras["left"].position_mm + rig.cameras["right"].position_mm) / 2
    uses = _ends_fit(spec["count"])
    frames = []
    for depth, use in zip(depths, uses, strict=True):
        offset = rng.uniform(-60, 60, 2)
        point = [middle[0] + offset[0], middle[1] + offset[1], rig.left.position_mm[2] - depth]
        frames.append(_on_stand(rig, point, use))
    return frames


def _ends_fit(count):
    """Half to fit, half to check, and every check lies between two of the fit."""
    fit = np.linspace(0, count - 1, count // 2).round().astype(int)
    return ["fit" if i in fit else "check" for i in range(count)]


def _evaluation(rig, rng, spec):
    points = [draw_point(rig, rng, spec["depth_mm"]) for _ in range(spec["volume"])]
    frames = [_on_stand(rig, p, "volume") for p in points]
    return frames + [_on_stand(rig, p, "plane") for p in _plane_points(rig, rng, spec["plane"])]


def _snaps(rig, rng, spec):
    """Single left pictures; the lamp is on in one of five."""
    frames = []
    for _ in range(spec["count"]):
        point = draw_point(rig, rng, spec["depth_mm"], ("left",))
        light = "lamp" if rng.random() < 0.2 else "day"
        frames.append(_on_stand(rig, point, light=light, sides=("left",)))
    return frames


def _track(rig, rng, spec):
    """A ball carried from stop to stop, gently off and gently to rest."""
    count, rate = spec["count"], rig.recording["frame_rate"]
    stops = [draw_point(rig, rng, spec["depth_mm"]) for _ in range(spec["stops"])]
    places = [_along(stops, t, count) for t in np.arange(count)]
    shutter = 0.02 * rate  # frames that the shutter stays open
    frames = []
    for t, point in enumerate(places):
        opened = [_along(stops, t + shutter * k, count) for k in (-0.375, -0.125, 0.125, 0.375)]
        moving = np.linalg.norm(opened[0] - opened[-1]) > 0.05
        path = tuple(tuple(p) for p in opened) if moving else ()
        frames.append(_on_stand(rig, point, carrier="wand", path=path))
    return frames


def _along(stops, t, count):
    """Where the ball is at frame ``t``: a third of the time at rest, smooth between the stops."""
    legs = len(stops) - 1
    leg = min(int(max(t, 0) / count * legs), legs - 1)
    part = np.clip((t / count * legs - leg) * 1.5 - 0.25, 0, 1)
    part = part * part * part * (10 - 15 * part + 6 * part * part)
    return np.asarray(stops[leg]) * (1 - part) + np.asarray(stops[leg + 1]) * part


def _still(rig, rng, spec):
    """The same ball shot again and again, at a few places from near to far."""
    nearest, farthest = spec["depth_mm"]
    frames = []
    for number, depth in enumerate(np.linspace(nearest, farthest, spec["places"])):
        point = draw_point(rig, rng, (depth, depth))
        place = f"place {number + 1}"
        frames += [_on_stand(rig, point, place, place=place)] * spec["shots"]
    return frames


MAKERS = {
    "plane": _plane,
    "axis": _axis,
    "evaluation": _evaluation,
    "snaps": _snaps,
    "track": _track,
    "still": _still,
}

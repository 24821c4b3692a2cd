"""Arrangements of things that make a ball hard to find, drawn from the rig's seed."""

from __future__ import annotations

import numpy as np
import scene
from places import draw_point, stream

HUES = [[0.1, 0.16, 0.34], [0.42, 0.3, 0.12], [0.08, 0.22, 0.12], [0.5, 0.48, 0.42], [0.2, 0.13, 0.12]]


def props(rig, backdrop):
    """All props of one arrangement: a wall, a shelf or posters, neutral things and red ones."""
    rng = stream(rig, "arrangement", backdrop)
    table, wall_z = rig.room["table_y_mm"], rig.room["backdrop_z_mm"]
    wall = np.clip(rng.uniform(0.3, 0.75) * (1 + rng.normal(0, 0.12, 3)), 0.1, 0.8).tolist()
    things = [{"kind": "panel", "at": [0, 500, wall_z], "size": [5200, 3600], "color": wall}]
    if rng.random() < 0.5:
        things[0]["texture"] = str(rng.choice(["speckle", "stripes"]))
        things[0]["texture_seed"] = int(rng.integers(1000))
    things += _behind(rng, table, wall_z)
    things += [_neutral(rng, table, wall_z) for _ in range(rng.integers(3, 7))]
    kinds = rng.permutation(list(LURES))[: rng.integers(2, 5)]
    return things + [LURES[kind](rng, table, wall_z) for kind in kinds]


def _behind(rng, table, wall_z):
    """What covers the wall: a shelf with books (some red) and a few posters."""
    things = []
    if rng.random() < 0.7:
        palette = [*HUES, _red(rng)] if rng.random() < 0.6 else HUES
        x = float(rng.choice([-600, 0, 600]) + rng.uniform(-100, 100))
        shelf = {"kind": "shelf", "at": [x, table, wall_z + 170], "size": [900, 1400, 240]}
        things.append({**shelf, "color": [0.45, 0.35, 0.24], "seed": int(rng.integers(1000)), "palette": palette})
    for _ in range(rng.integers(1, 4)):
        color = _red(rng) if rng.random() < 0.5 else HUES[rng.integers(len(HUES))]
        at = [float(rng.uniform(-1000, 1000)), float(rng.uniform(250, 900)), wall_z + 6]
        poster = {"kind": "panel", "at": at, "size": [420, 600], "color": color}
        things.append({**poster, "texture": "poster", "texture_seed": int(rng.integers(1000))})
    return things


def _spot(rng, table, wall_z):
    """Somewhere on the far part of the table."""
    return [float(rng.uniform(-700, 700)), table, float(rng.uniform(wall_z + 350, -380))]


def _red(rng):
    """A red that a camera cannot tell from the ball's."""
    return np.clip(np.array(scene.RED) * rng.uniform(0.75, 1.3, 3), 0.01, 0.85).tolist()


def _neutral(rng, table, wall_z):
    color = np.clip(np.array(HUES[rng.integers(len(HUES))]) * rng.uniform(0.6, 1.7), 0.02, 0.85).tolist()
    at = _spot(rng, table, wall_z)
    kind = rng.integers(4)
    if kind == 0:
        return {
            "kind": "box",
            "at": at,
            "size": rng.uniform(60, 240, 3).tolist(),
            "turn_deg": [0, float(rng.uniform(0, 90)), 0],
            "color": color,
        }
    if kind == 1:
        return {
            "kind": "cylinder",
            "at": at,
            "radius": float(rng.uniform(25, 80)),
            "height": float(rng.uniform(60, 260)),
            "color": color,
        }
    if kind == 2:
        return {
            "kind": "egg",
            "at": at,
            "radius": float(rng.uniform(40, 90)),
            "height": float(rng.uniform(90, 260)),
            "color": color,
        }
    return {
        "kind": "cup",
        "at": at,
        "radius": 42,
        "height": 96,
        "gloss": 0.6,
        "turn_deg": [0, float(rng.uniform(0, 360)), 0],
        "color": color,
    }


def _cup(rng, table, wall_z):
    size = rng.uniform(0.8, 1.3)
    cup = {"kind": "cup", "at": _spot(rng, table, wall_z), "radius": 42 * size, "height": 95 * size}
    return {**cup, "gloss": 0.65, "turn_deg": [0, float(rng.uniform(0, 360)), 0], "color": _red(rng)}


def _cloth(rng, table, wall_z):
    at = [float(rng.uniform(-800, 800)), float(rng.uniform(150, 700)), wall_z + 340]
    cloth = {"kind": "cloth", "at": at, "size": rng.uniform(220, 480, 2).tolist(), "color": _red(rng)}
    return {**cloth, "folds": float(rng.uniform(2, 5))}


def _box(rng, table, wall_z):
    box = {"kind": "box", "at": _spot(rng, table, wall_z), "size": rng.uniform(50, 180, 3).tolist()}
    return {**box, "turn_deg": [0, float(rng.uniform(0, 90)), 0], "color": _red(rng)}


def _egg(rng, table, wall_z):
    radius = float(rng.uniform(25, 55))
    egg = {"kind": "egg", "at": _spot(rng, table, wall_z), "radius": radius}
    return {**egg, "height": radius * float(rng.choice([1.3, 2.9])), "gloss": 0.65, "color": _red(rng)}


def _cone(rng, table, wall_z):
    cone = {"kind": "cone", "at": _spot(rng, table, wall_z), "radius": float(rng.uniform(35, 80))}
    return {**cone, "height": float(rng.uniform(90, 240)), "color": _red(rng)}


def _print(rng, table, wall_z):
    """A disc on a card, as round as a ball from the front, and of another size."""
    size = float(rng.uniform(95, 230))
    at = _spot(rng, table, wall_z)
    at[1] = table + size / 2 + float(rng.uniform(0, 350))
    card = {"kind": "panel", "at": at, "size": [size, size], "color": _red(rng), "texture": "print"}
    return {**card, "turn_deg": [float(rng.uniform(-20, 5)), float(rng.uniform(-35, 35)), 0]}


LURES = {"cup": _cup, "cloth": _cloth, "box": _box, "egg": _egg, "cone": _cone, "print": _print}


def frames(rig, rng, spec):
    """Frames spread over the arrangements: with a ball, with one partly hidden, or with none."""
    sides = ("left", "right") if spec.get("pairs") else ("left",)
    empty = set(rng.permutation(spec["count"])[: spec.get("empty", 0)].tolist())
    color = spec.get("color", rig.recording["ball"]["color"])
    lights = list(rig.room["lights"])
    made = []
    for index in range(spec["count"]):
        backdrop = index * spec["arrangements"] // spec["count"]
        light = lights[(backdrop + int(rng.random() < 0.5)) % len(lights)]
        frame = {"color": color, "backdrop": backdrop, "light": light, "sides": sides}
        if index not in empty:
            ball = draw_point(rig, rng, spec["depth_mm"], sides)
            frame["ball"] = tuple(ball)
            if rng.random() < spec.get("hidden", 0):
                frame["cover"] = _cover(rig, rng, ball)
        made.append(frame)
    return made


def _cover(rig, rng, ball):
    """A post before the ball that hides a part of it from the left camera."""
    radius = rig.recording["ball"]["diameter_mm"] / 2
    toward = ball + (rig.left.position_mm - ball) * 45 / np.linalg.norm(rig.left.position_mm - ball)
    width, cut = float(rng.uniform(30, 70)), rng.uniform(0.25, 0.8) * radius
    table = rig.room["table_y_mm"]
    x = toward[0] + rng.choice([-1, 1]) * (cut + width / 2)
    height = float(ball[1] + rng.uniform(15, 90) - table)
    color = np.clip(np.array(HUES[rng.integers(len(HUES))]) * 1.3, 0, 0.8).tolist()
    return {"kind": "box", "at": [float(x), table, float(toward[2])], "size": [width, height, 24], "color": color}

"""Make a recording: render every frame of a rig that is not there yet, and write down the truth.

The room is traced once for each light and camera. Each frame then traces only the parts of the
picture that the ball (or board), its stand and their shadows change. Sensor noise is drawn anew
for every whole frame.
"""

from __future__ import annotations

import csv
import io
import json
import os
import re
from pathlib import Path

import clutter
import numpy as np
import optics
import poses
import rig as rigs
import scene
from places import stream

from stereo_lab.common.files import read_json
from stereo_lab.errors import StereoLabError

DATE = "2026-11-20"  # that every recording tells: made again, its files are the same to the last byte


def record(name, out, seed=None, only=None, report=lambda done, total, what: None):
    """Render the rig ``name`` into the folder ``out``; frames already there are kept.

    Parameters
    ----------
    name : str, a rig in ``rigs/`` or the path of a rig file
    out : path of the recording's folder
    seed : int or None, another seed than the rig's own draws other poses and noise
    only : list of set names or None for all
    report : callable (done, total, what)

    Raises
    ------
    StereoLabError
        Where it has no such set, or the folder holds a recording of other places or cameras: its pictures would be kept with a truth not theirs.
    """
    rig, out = rigs.load_rig(name, seed), Path(out)
    frames = poses.plan(rig)
    if unknown := set(only or ()) - frames.keys():
        raise StereoLabError(f"{name} has no set {', '.join(sorted(unknown))}. Choose from {', '.join(frames)}.")
    truth = _truth(rig, frames)
    _check_pictures_fit(out, truth)
    _write_facts(rig, frames, truth, out)
    jobs = [(s, f) for s in frames for f in frames[s] if only is None or s in only]
    missing = [(s, f) for s, f in jobs if not all(_path(out, s, f, side).exists() for side in f.sides)]
    missing.sort(key=lambda job: (job[1].backdrop, job[1].light))
    studio = Studio(rig)
    for k, (set_name, frame) in enumerate(missing):
        report(len(jobs) - len(missing) + k, len(jobs), f"{rig.name}/{set_name}/{frame.name}")
        for side, jpeg in studio.take(set_name, frame).items():
            _write_whole(_path(out, set_name, frame, side), jpeg)
    report(len(jobs), len(jobs), f"{rig.name} is complete")


class Studio:
    """A rig's room, with the empty pictures that have been traced of it."""

    def __init__(self, rig):
        self.rig = rig
        self._room = [s for spec in rig.room["props"] for s in scene.prop(spec)]
        self._empty = {}
        self._traced = {}

    def take(self, set_name, frame):
        """Both JPEG files of one frame: ``{side: bytes}``."""
        key = (set_name, frame.place or frame.name)
        if key not in self._traced:
            self._traced = {key: self._trace(frame, *key)}
        return {side: self._expose(light, frame, side, set_name) for side, light in self._traced[key].items()}

    def _trace(self, frame, *words):
        """The light that reaches each camera: ``{side: linear RGB}``."""
        moments = [moving_parts(self.rig, frame, ball) for ball in frame.path or (frame.ball,)]
        extra = self._extra(frame.backdrop)
        scenes = [scene.assemble(self.rig.room, extra + parts, frame.light) for parts in moments if parts]
        pictures = {}
        for side in frame.sides:
            picture = self._empty_room(frame, side).copy()
            seed = int(stream(self.rig, *words, side).integers(1 << 20))
            for k, (box, samples) in enumerate(self._boxes(frame, side, moments)):
                x, y, w, h = box
                tries = [
                    optics.trace(s, self.rig.cameras[side], box, samples / len(scenes), seed + 64 * k + i)
                    for i, s in enumerate(scenes)
                ]
                picture[y : y + h, x : x + w] = np.mean(tries, 0)
            pictures[side] = picture
        return pictures

    def _extra(self, backdrop):
        """The room's surfaces and those of one arrangement of clutter."""
        if "clutter" not in self.rig.room:
            return self._room
        return self._room + [s for p in clutter.props(self.rig, backdrop) for s in scene.prop(p)]

    def _empty_room(self, frame, side):
        key = (frame.backdrop, frame.light, side)
        if key not in self._empty:
            self._empty = {k: v for k, v in self._empty.items() if k[0] == frame.backdrop}
            camera = self.rig.cameras[side]
            empty = scene.assemble(self.rig.room, self._extra(frame.backdrop), frame.light)
            seed = int(stream(self.rig, "room", *key).integers(1 << 20))
            self._empty[key] = optics.trace(empty, camera, (0, 0, *camera.image_size), self.rig.samples["room"], seed)
        return self._empty[key]

    def _expose(self, picture, frame, side, set_name):
        gain = 1.0
        if "clutter" in self.rig.room:  # a webcam that sets its own exposure
            bright = np.percentile(self._empty[frame.backdrop, frame.light, side], 90)
            gain = 0.42 / bright * stream(self.rig, set_name, frame.name, "gain").uniform(0.7, 1.25)
        rng = stream(self.rig, set_name, frame.name, side, "noise")
        return optics.expose(picture, self.rig.cameras[side].sensor, rng, gain)

    def _boxes(self, frame, side, moments):
        """Parts of the picture to trace: where things moved (few paths) and the ball (many)."""
        camera = self.rig.cameras[side]
        boxes = []
        for parts in zip(*moments, strict=True):
            points = np.concatenate([part.grid.reshape(-1, 3) for part in parts])
            for cloud in (points, *self._shadows(points, frame.light)):
                boxes.append((_box_round(camera, cloud, 6), self.rig.samples["around"]))
        boxes = _united(boxes)
        if frame.ball is not None:
            radius = self.rig.recording["ball"]["diameter_mm"] / 2
            corners = [np.add(b, np.multiply(radius, c)) for b in frame.path or (frame.ball,) for c in CUBE]
            boxes.append((_box_round(camera, np.array(corners), 6), self.rig.samples["ball"]))
        return [(b, s) for b, s in boxes if b[2] > 0 and b[3] > 0]

    def _shadows(self, points, light):
        """Where each lamp throws these points on the table and the backdrop, with the half-shade."""
        shadows = []
        for lamp in self.rig.room["lights"][light]["softboxes"]:
            source = np.array(lamp["at"], float)
            for axis, level in ((1, self.rig.room["table_y_mm"]), (2, self.rig.room["backdrop_z_mm"])):
                drop = (level - source[axis]) / (points[:, axis] - source[axis])
                cast = source + (points - source) * drop[:, None]
                blur = 0.35 * lamp["size_mm"] * np.maximum(drop[:, None] - 1, 0)
                spread = np.concatenate([cast + blur * c for c in CUBE])
                on_table = spread[:, 1] > self.rig.room["table_y_mm"] - 60
                spread = spread[on_table & (spread[:, 2] > self.rig.room["backdrop_z_mm"] - 60)]
                if len(spread):
                    shadows.append(spread)
        return shadows


CUBE = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)


def moving_parts(rig, frame, ball):
    """The surfaces that are in this frame and not in the empty room."""
    board, size = rig.recording["board"], rig.recording["ball"]["diameter_mm"]
    if frame.board is not None:
        return scene.chessboard(board, *frame.board, rig.bend_mm)
    if ball is None:
        return []
    carry = {"stand": lambda: scene.stand(ball, size, rig.room["table_y_mm"]), "wand": lambda: scene.wand(ball, size)}
    skin = int(stream(rig, "skin").integers(1 << 20))
    parts = scene.ball(ball, size, frame.color, rig.ball_gloss, skin) + carry[frame.carrier]()
    return parts + (scene.prop(frame.cover) if frame.cover else [])


def _box_round(camera, points, margin):
    """Whole pixels round the projection of points, cut at the frame: (x0, y0, width, height)."""
    points = points[camera.depth(points) > 100]
    if not len(points):
        return (0, 0, 0, 0)
    pixels = camera.project(points)
    size = np.array(camera.image_size)
    low = np.clip(np.floor(pixels.min(0)) - margin, 0, size).astype(int)
    high = np.clip(np.ceil(pixels.max(0)) + margin + 1, 0, size).astype(int)
    return (*(int(v) for v in low), *(int(v) for v in high - low))


def _united(boxes):
    """Join boxes until no two overlap."""
    boxes = [b for b in boxes if b[0][2] > 0 and b[0][3] > 0]
    for i, (a, samples) in enumerate(boxes):
        for j in range(i + 1, len(boxes)):
            b = boxes[j][0]
            if a[0] < b[0] + b[2] and b[0] < a[0] + a[2] and a[1] < b[1] + b[3] and b[1] < a[1] + a[3]:
                x0, y0 = min(a[0], b[0]), min(a[1], b[1])
                x1, y1 = max(a[0] + a[2], b[0] + b[2]), max(a[1] + a[3], b[1] + b[3])
                rest = [boxes[k] for k in range(len(boxes)) if k not in (i, j)]
                return _united([*rest, ((x0, y0, x1 - x0, y1 - y0), samples)])
    return boxes


def _path(out, set_name, frame, side):
    return out / set_name / side / f"{frame.name}.jpg"


def _truth(rig, frames):
    return {
        "cameras": {side: _camera_facts(camera) for side, camera in rig.cameras.items()},
        "sets": {s: {f.name: _ball_facts(rig, f) for f in fs} for s, fs in frames.items() if s != "calibration"},
    }


def _check_pictures_fit(out, truth):
    """A folder's pictures are kept, so its truth must be this one; it may lack sets of it."""
    facts = out / "recording.json"
    if facts.exists() and read_json(facts).get("made_by") != "render":
        raise StereoLabError(f"{out} holds a recording that was not rendered. Name a new folder: --out FOLDER.")
    if not (out / "truth.json").exists():
        return
    there, truth = read_json(out / "truth.json"), json.loads(_json(truth))
    sets = there.get("sets", {})
    if there.get("cameras") != truth["cameras"] or any(
        sets.get(s, places) != places for s, places in truth["sets"].items()
    ):
        raise StereoLabError(
            f"{out} holds a recording of another seed or rig, and its pictures would be kept. "
            "Name a new folder: --out FOLDER."
        )


def _write_facts(rig, frames, truth, out):
    facts = {"format": 1, "title": rig.recording["title"], "made_by": "render", "date": DATE}
    facts = {**facts, "license": "CC-BY-4.0", **{k: v for k, v in rig.recording.items() if k != "title"}}
    _write_whole(out / "recording.json", _json(facts))
    _write_whole(out / "truth.json", _json(truth))
    for set_name, spec in rig.sets.items():
        if spec["kind"] in ("plane", "axis", "evaluation", "still"):
            _write_whole(out / set_name / "measured.csv", _measured(rig, set_name, frames[set_name]))


def _camera_facts(camera):
    return {
        "matrix": camera.matrix.tolist(),
        "distortion": camera.distortion.tolist(),
        "rotation": camera.rotation.round(9).tolist(),
        "position_mm": camera.position_mm.tolist(),
    }


def _ball_facts(rig, frame):
    if frame.ball is None:
        return {"ball": None}
    facts = {"ball": [*np.round(frame.ball[:2], 4).tolist(), round(rig.depth_mm(frame.ball), 4)]}
    if frame.color != rig.recording["ball"]["color"]:
        facts["color"] = frame.color
    for side in frame.sides:
        camera = rig.cameras[side]
        radius = rig.recording["ball"]["diameter_mm"] / 2
        distance = np.linalg.norm(np.subtract(frame.ball, camera.position_mm))
        radius_px = camera.matrix[0, 0] * radius / np.sqrt(distance**2 - radius**2)
        facts[side] = [*camera.project([frame.ball])[0].round(4).tolist(), round(float(radius_px), 3)]
    return facts


def _measured(rig, set_name, frames):
    """What a person with a ruler reads: a small error, then whole millimetres."""
    rng = stream(rig, set_name, "ruler")
    text = io.StringIO()
    rows = csv.writer(text, lineterminator="\n")
    rows.writerow(["name", "x_mm", "y_mm", "depth_mm", "use"])
    read = {}  # a place is measured once, however many shots are taken of it
    for frame in frames:
        place = frame.place or frame.name
        if place not in read:
            exact = np.array([*frame.ball[:2], rig.depth_mm(frame.ball)])
            read[place] = np.round(exact + rng.normal(0, rig.ruler_mm, 3)).astype(int)
        rows.writerow([frame.name, *read[place], frame.use])
    return text.getvalue().encode()


def _json(facts):
    """JSON with one line for each innermost list or object."""
    text = json.dumps(facts, indent=1, ensure_ascii=False)
    flat = re.compile(r"([\[{])\s*([^\[\]{}]*?)\s*([\]}])", re.S)
    text = flat.sub(lambda m: m[1] + re.sub(r"\s*\n\s*", " ", m[2]) + m[3], text)
    return (text + "\n").encode()


def _write_whole(path, content):
    """Write a file whole or not at all."""
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_name(path.name + ".part")
    part.write_bytes(content)
    os.replace(part, path)

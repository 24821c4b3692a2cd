"""What stands in front of the cameras: a room of simple things, and the ball or the board.

A prop is a small dictionary, in a rig file or made by :mod:`clutter`:
``{"kind": "box", "at": [x, y, z], "size": [w, h, d], "color": [r, g, b], "turn_deg": [x, y, z]}``.
``kind`` is the name of one of the shape functions in ``SHAPES``. ``at`` is in the bench frame.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from optics import mi

RED, GREEN, BLUE = [0.56, 0.035, 0.03], [0.05, 0.36, 0.07], [0.03, 0.09, 0.45]
BALL_COLORS = {
    "red": RED,
    "green": GREEN,
    "blue": BLUE,
    "yellow": [0.68, 0.5, 0.025],
    "orange": [0.68, 0.19, 0.02],
}


def softbox(at, toward, size_mm, color, power=1.0):
    """A square lamp that shines one way."""
    frame = mi.ScalarTransform4f().look_at(list(map(float, at)), list(map(float, toward)), [0, 1, 0.01])
    radiance = [float(power * c) for c in color]
    return {
        "type": "rectangle",
        "to_world": frame @ mi.ScalarTransform4f().scale(size_mm / 2),
        "emitter": {"type": "area", "radiance": {"type": "rgb", "value": radiance}},
    }


def ambient(color):
    """Light from everywhere, found only by rays that leave the room."""
    return {
        "type": "constant",
        "radiance": {"type": "rgb", "value": list(map(float, color))},
        "sampling_weight": 0.0,
    }


def paint(gloss, reflectance):
    """A matt surface, or a glossy plastic (gloss 0..1)."""
    if gloss:
        surface = {"type": "roughplastic", "diffuse_reflectance": reflectance}
        surface["alpha"] = 0.45 - 0.35 * gloss
    else:
        surface = {"type": "diffuse", "reflectance": reflectance}
    return {"type": "twosided", "bsdf": surface}


def bitmap(pixels, sharp=False):
    """A texture from linear reflectances, shape (rows, columns, 3); row 0 is the top."""
    return {
        "type": "bitmap",
        "bitmap": mi.Bitmap(np.ascontiguousarray(pixels, dtype=np.float32)),
        "raw": True,
        "filter_type": "nearest" if sharp else "bilinear",
        "wrap_mode": "clamp",
    }


def _noise(rng, rows, columns, coarse):
    """Smooth noise in 0..1 with a few octaves."""
    total = np.zeros((rows, columns))
    for octave in range(3):
        cells = max(2, int(coarse * 2**octave))
        grid = rng.random((cells, cells)).astype(np.float32)
        total += cv2.resize(grid, (columns, rows), interpolation=cv2.INTER_CUBIC) / 2**octave
    return np.clip((total - total.min()) / np.ptp(total), 0, 1)


def _wood(color, rng):
    streaks = _noise(rng, 8, 128, 20)[:1].repeat(128, 0)
    streaks = 0.6 * streaks + 0.4 * _noise(rng, 128, 128, 5)
    return color * (0.65 + 0.5 * streaks[..., None])


def _speckle(color, rng):
    return np.clip(color * (0.55 + 0.9 * _noise(rng, 128, 128, 8)[..., None]), 0.02, 0.9)


def _stripes(color, rng):
    wave = (np.arange(128) // int(rng.integers(6, 14))) % 2
    other = rng.random(3) * 0.6 + 0.1
    return np.where(wave[None, :, None] == 1, color, other) * np.ones((128, 128, 1))


def _poster(color, rng):
    """Flat shapes on a pale ground, some of them in the poster's colour."""
    picture = np.ones((192, 128, 3), np.float32) * (0.45 + 0.4 * rng.random(3))
    for k in range(9):
        shade = color if k % 3 == 0 else rng.random(3) * 0.7
        centre = [int(c) for c in rng.integers((10, 10), (118, 182))]
        size = int(rng.integers(8, 32))
        kind = rng.integers(3)
        ink = [float(c) for c in shade]
        if kind == 0:
            cv2.ellipse(picture, centre, (size, size // 2), 30.0 * k, 0, 360, ink, -1)
        elif kind == 1:
            corner = (centre[0] + 2 * size, centre[1] + size)
            cv2.rectangle(picture, centre, corner, ink, -1)
        else:
            offsets = rng.integers(-size, size, (3, 2))
            cv2.fillPoly(picture, [np.array(centre) + offsets], ink)
    return picture


def _print(color, rng):
    """White card with a disc in the colour: what a printer makes of a ball."""
    card = np.full((256, 256, 3), 0.8, np.float32)
    cv2.circle(card, (128, 128), 96, [float(c) for c in color], -1, cv2.LINE_AA)
    return card


TEXTURES = {"wood": _wood, "speckle": _speckle, "stripes": _stripes, "poster": _poster, "print": _print}


def place(points, at, turn_deg=(0, 0, 0)):
    """Turn points about x, then y, then z, and move them to ``at``."""
    turn = np.eye(3)
    for axis, angle in enumerate(np.radians(turn_deg)):
        turn = cv2.Rodrigues(np.eye(3)[axis] * angle)[0] @ turn
    return np.asarray(points) @ turn.T + np.asarray(at, float)


def lathe(at, profile, turn_deg=(0, 0, 0), segments=48):
    """Turn a profile of (radius, height) pairs about the vertical axis."""
    profile = np.asarray(profile, float)
    angle = np.linspace(0, 2 * np.pi, segments + 1)
    bands = []
    for lower, upper in zip(profile[:-1], profile[1:], strict=True):
        band = np.stack([lower, upper])
        x, z = band[:, :1] * np.cos(angle), band[:, :1] * np.sin(angle)
        y = np.broadcast_to(band[:, 1:], x.shape)
        bands.append(place(np.stack([x, y, z], -1), at, turn_deg))
    return bands


def box(at, size, turn_deg=(0, 0, 0)):
    """A cuboid; ``at`` is the centre of its bottom."""
    width, height, depth = size
    w, d = width / 2, depth / 2
    ring = np.array([[-w, d], [w, d], [w, -d], [-w, -d], [-w, d]])
    grids = []
    for (x0, z0), (x1, z1) in zip(ring[:-1], ring[1:], strict=True):
        grids.append([[[x0, height, z0], [x1, height, z1]], [[x0, 0, z0], [x1, 0, z1]]])
    for y in (0, height):
        grids.append([[[-w, y, -d], [w, y, -d]], [[-w, y, d], [w, y, d]]])
    return [place(grid, at, turn_deg) for grid in grids]


def panel(at, size, turn_deg=(0, 0, 0)):
    """An upright rectangle (width, height) that faces the cameras; ``at`` is its centre."""
    x, y = np.meshgrid(np.linspace(-0.5, 0.5, 5), np.linspace(0.5, -0.5, 5))
    grid = np.stack([x * size[0], y * size[1], np.zeros_like(x)], -1)
    return [place(grid, at, turn_deg)]


def cylinder(at, radius, height, turn_deg=(0, 0, 0)):
    return lathe(at, [(0, 0), (radius, 0), (radius, height), (0, height)], turn_deg)


def cone(at, radius, height, turn_deg=(0, 0, 0)):
    return lathe(at, [(0, 0), (radius, 0), (0, height)], turn_deg)


def egg(at, radius, height, turn_deg=(0, 0, 0)):
    """A longish round thing: a tomato, a balloon, a lampshade."""
    t, angle = np.meshgrid(np.linspace(0, np.pi, 40), np.linspace(0, 2 * np.pi, 61), indexing="ij")
    round_part = radius * np.sin(t)
    y = height / 2 * (1 + np.cos(t))
    grid = np.stack([round_part * np.cos(angle), y, round_part * np.sin(angle)], -1)
    return [place(grid, at, turn_deg)]


def cup(at, radius, height, turn_deg=(0, 0, 0)):
    profile = [(0, 0), (0.8 * radius, 0), (radius, height), (0.93 * radius, height)]
    profile += [(0.74 * radius, 4), (0, 4)]
    around, across = np.meshgrid(np.linspace(0, 2 * np.pi, 25), np.linspace(0, 2 * np.pi, 13))
    ring = 0.32 * height + 0.07 * height * np.cos(across)
    handle = np.stack([ring * np.cos(around), ring * np.sin(around), 0.07 * height * np.sin(across)], -1)
    handle = place(handle + [0.95 * radius, 0.5 * height, 0], at, turn_deg)
    return [*lathe(at, profile, turn_deg), handle]


def cloth(at, size, turn_deg=(0, 0, 0), folds=4.0):
    """A hanging cloth with folds; ``at`` is the middle of its upper edge."""
    x, y = np.meshgrid(np.linspace(-0.5, 0.5, 60), np.linspace(0, -1, 40))
    depth = 0.05 * size[0] * np.sin(2 * np.pi * folds * x + 3 * y) * (0.3 - y)
    grid = np.stack([x * size[0] * (1 + 0.15 * y), y * size[1], depth], -1)
    return [place(grid, at, turn_deg)]


SHAPES = {f.__name__: f for f in (box, panel, cylinder, cone, egg, cup, cloth, lathe)}


@dataclass(frozen=True)
class Surface:
    """A grid of points and what covers it."""

    grid: np.ndarray
    color: tuple = (0.5, 0.5, 0.5)
    gloss: float = 0.0
    texture: dict | None = None


def prop(spec):
    """The surfaces of one prop."""
    spec = dict(spec)
    kind, color, gloss = spec.pop("kind"), spec.pop("color"), spec.pop("gloss", 0.0)
    if kind == "shelf":
        return shelf(color=color, **spec)
    name, seed = spec.pop("texture", None), spec.pop("texture_seed", 0)
    grids = SHAPES[kind](**spec)
    texture = None
    if name is not None:
        texture = bitmap(TEXTURES[name](np.array(color, float), np.random.default_rng(seed)))
    return [Surface(grid, tuple(color), gloss, texture) for grid in grids]


BOOKS = ([0.1, 0.16, 0.3], [0.35, 0.3, 0.2], [0.08, 0.2, 0.13], [0.5, 0.5, 0.45])


def shelf(at, size, color, seed=0, palette=BOOKS):
    """Boards with a row of books on each; ``at`` is the centre of its bottom."""
    rng = np.random.default_rng(seed)
    levels = max(1, int(size[1] // 330))
    step = size[1] / levels
    surfaces = []
    for level in range(levels + 1):
        y = at[1] + level * step
        surfaces += prop({"kind": "box", "at": [at[0], y - 20, at[2]], "size": [size[0], 20, size[2]], "color": color})
        x = at[0] - size[0] / 2 + 10
        while level < levels and x < at[0] + size[0] / 2 - 70:
            thick, tall = rng.uniform(18, 55), rng.uniform(0.55, 0.85) * step
            cover = np.clip(np.array(palette[rng.integers(len(palette))]) * rng.uniform(0.6, 1.4), 0, 0.8)
            middle = [x + thick / 2, y, at[2] + rng.uniform(-15, 15)]
            surfaces += prop({"kind": "box", "at": middle, "size": [thick, tall, 0.7 * size[2]], "color": cover})
            x += thick + (rng.uniform(40, 160) if rng.random() < 0.12 else 2)
    return surfaces


def ball(center, diameter_mm, color, gloss, seed=0):
    """A plastic ball, a thousandth out of round, its seam turned by the seed; of no gloss, it is a matt one."""
    rng = np.random.default_rng(seed)
    theta, phi = np.meshgrid(np.linspace(0, np.pi, 97), np.linspace(0, 2 * np.pi, 193), indexing="ij")
    direction = np.stack([np.sin(theta) * np.cos(phi), np.cos(theta), np.sin(theta) * np.sin(phi)], -1)
    axis = rng.normal(size=3)
    axis /= np.linalg.norm(axis)
    out_of_round = 1 + 0.001 * (direction @ axis) ** 2 - 0.0003
    shade = 0.92 + 0.12 * _noise(rng, 64, 128, 5)[..., None]
    points = np.asarray(center) + diameter_mm / 2 * out_of_round[..., None] * direction
    skin = bitmap(np.clip(np.array(BALL_COLORS[color]) * shade, 0, 0.95))
    return [Surface(points, gloss=gloss, texture=skin)]


def stand(center, diameter_mm, floor_y):
    """A turned wooden stand under a ball, on the table at ``floor_y``."""
    height = center[1] - diameter_mm / 2 + 1.5 - floor_y
    profile = [(0, 0), (42, 0), (42, 7), (12, 11), (5.5, 16), (4.5, height - 7)]
    profile += [(7.5, height), (6.0, height - 0.6), (0, height - 1.5)]
    grids = lathe([center[0], floor_y, center[2]], profile, segments=40)
    return [Surface(grid, (0.62, 0.55, 0.45)) for grid in grids]


def wand(center, diameter_mm, slant_deg=14.0):
    """The stick by which somebody carries the ball, from below."""
    reach = 700 + diameter_mm / 2 - 1
    tilt = np.radians(slant_deg)
    foot = np.asarray(center) - reach * np.array([-np.sin(tilt), np.cos(tilt), 0])
    grids = lathe(foot, [(0, 0), (7, 0), (5, 700), (0, 700)], (0, 0, slant_deg), 24)
    return [Surface(grid, (0.55, 0.55, 0.53)) for grid in grids]


def board_points(board, at, turn_deg, bend_mm):
    """Inner corners of a board in the bench frame, row by row, shape (rows * columns, 3)."""
    x = (np.arange(board["columns"]) - (board["columns"] - 1) / 2) * board["square_mm"]
    y = ((board["rows"] - 1) / 2 - np.arange(board["rows"])) * board["square_mm"]
    grid = np.stack(np.meshgrid(x, y), -1).reshape(-1, 2)
    return place(_bent(grid, board, bend_mm), at, turn_deg)


def _bent(grid, board, bend_mm):
    half = (board["columns"] - 1) / 2 * board["square_mm"]
    bow = bend_mm * (1 - (grid[..., 0] / half) ** 2)
    return np.concatenate([grid, bow[..., None]], -1)


def chessboard(board, at, turn_deg, bend_mm):
    """A printed sheet on a panel on a pole: the sheet is bent, its squares are exact."""
    columns, rows, square = board["columns"], board["rows"], board["square_mm"]
    edge = 4  # white border, in fifths of a square, as are the squares themselves
    cells = (np.add.outer(np.arange(rows + 1), np.arange(columns + 1)) % 2) * 1.0
    texels = np.pad(cells.repeat(5, 0).repeat(5, 1), edge, constant_values=1)
    ink = np.where(texels[..., None] > 0, [0.78, 0.78, 0.76], [0.035, 0.035, 0.04])
    width, height = np.array(texels.shape[::-1]) * square / 5
    x, y = np.meshgrid(np.linspace(-0.5, 0.5, 33) * width, np.linspace(0.5, -0.5, 25) * height)
    sheet = place(_bent(np.stack([x, y], -1), board, bend_mm), at, turn_deg)
    plate = box([0, -height / 2 - 6, -6], [width + 12, height + 12, 8])
    plate = [Surface(place(g, at, turn_deg), (0.42, 0.33, 0.22)) for g in plate]
    foot = place([[0, -height / 2, -6]], at, turn_deg)[0]
    pole = lathe(foot - [0, 1500, 0], [(11, 0), (11, 1500), (0, 1500)])
    pole = [Surface(g, (0.3, 0.3, 0.32)) for g in pole]
    return [Surface(sheet, texture=bitmap(ink, sharp=True)), *plate, *pole]


def assemble(room, surfaces, light="day"):
    """A Mitsuba scene of surfaces under one light of the room."""
    lamps = room["lights"][light]
    parts = [ambient(lamps["ambient"])]
    parts += [softbox(**lamp) for lamp in lamps["softboxes"]]
    parts += _meshes(surfaces)
    return mi.load_dict({"type": "scene", **{f"part{i}": part for i, part in enumerate(parts)}})


def _meshes(surfaces):
    """One mesh for all that is matt, one for each plastic and texture: few meshes trace fast."""
    matt = [s for s in surfaces if s.texture is None and not s.gloss]
    meshes = [_mesh(matt, paint(0.0, {"type": "mesh_attribute", "name": "vertex_color"}))]
    plastics = {}
    for surface in surfaces:
        if surface.texture is None and surface.gloss:
            plastics.setdefault((surface.gloss, surface.color), []).append(surface)
    for (gloss, color), group in plastics.items():
        meshes.append(_mesh(group, paint(gloss, {"type": "rgb", "value": list(color)})))
    textured = [s for s in surfaces if s.texture is not None]
    return meshes + [_mesh([s], paint(s.gloss, s.texture)) for s in textured]


def _mesh(surfaces, bsdf):
    points = np.concatenate([s.grid.reshape(-1, 3) for s in surfaces])
    first = np.cumsum([0] + [s.grid.shape[0] * s.grid.shape[1] for s in surfaces])
    faces = np.concatenate([_faces(s.grid.shape) + k for s, k in zip(surfaces, first, strict=False)])
    properties = mi.Properties()
    properties["mesh_bsdf"] = mi.load_dict(bsdf)
    mesh = mi.Mesh("surfaces", len(points), len(faces), properties, True, True)
    colors = np.concatenate([np.broadcast_to(s.color, s.grid.shape).reshape(-1, 3) for s in surfaces])
    mesh.add_attribute("vertex_color", 3, colors.astype(np.float32).ravel())
    data = mi.traverse(mesh)
    data["vertex_positions"] = points.astype(np.float32).ravel()
    data["vertex_texcoords"] = np.concatenate([_uv(s.grid.shape) for s in surfaces]).ravel()
    data["faces"] = faces.astype(np.uint32).ravel()
    data.update()
    mesh.recompute_vertex_normals()
    return mesh


def _faces(shape):
    rows, columns = shape[:2]
    corner = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)).ravel()
    lower = np.stack([corner, corner + columns, corner + 1], 1)
    upper = np.stack([corner + 1, corner + columns, corner + columns + 1], 1)
    return np.vstack([lower, upper])


def _uv(shape):
    """Texture coordinates with the first row of the grid at the top of the texture."""
    v, u = np.meshgrid(np.linspace(1, 0, shape[0]), np.linspace(0, 1, shape[1]), indexing="ij")
    return np.stack([u, v], -1).astype(np.float32).reshape(-1, 2)

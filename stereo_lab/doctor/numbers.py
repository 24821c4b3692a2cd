"""Measured numbers against what the cameras see: a whole table in other units or columns, and slips of single lines.

The cameras tell where the balls are to each other, whatever the ruler says; so some turn and shift brings the places that they
tell on to the measured ones. Where none does, each mistake that a hand may have made is undone in turn, first in the whole table,
then line by line.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from stereo_lab.position import is_wrong_way, kabsch

RULER_MM = 3.0  # a ruler held by hand is not farther off than this
WRONG_MM = 3 * RULER_MM  # a line that is farther off is wrong
FLAT_MM = 6 * WRONG_MM  # a column that differs by less in its set has no sign that could be told: it lies in one plane
DRAWS = 60  # of three lines each, from which a turn and shift are tried
SEED = 0
EXPLAINS = 0.05  # of a line's distance may be left where a slip explains it: a far place is told badly by the others
AGREE = 0.7  # in lines' worth: a table that fits so well is as it should be
ONE_SET = 0.3  # in lines' worth for each table: a mistake in some of the tables alone is the less simple one
SHIFTED = 2.0  # a shift fits its own number to the lines, which a sign or a unit cannot
MENDED = 1.0  # and in lines' worth, what is left of a set that was shifted: a third of its lines
SIGNS = ((0,), (1,), (2,), (0, 1))  # columns whose sign a hand turns round
AXES = ("x", "y", "depth")
UNITS = {"centimetres": 10.0, "inches": 25.4, "metres": 1000.0}


@dataclass(frozen=True, eq=False)
class Placed:
    """Places that the cameras tell, turned and shifted on to measured ones.

    Attributes
    ----------
    cost : float, how badly they fit, in lines
    told : ndarray, shape (N, 3), x, y and depth as the cameras tell them, mm
    off : ndarray, shape (N,), how far each line is from that, mm; depth counts less where the cameras know it badly
    scale : float
    turned : bool, whether x would not be to the right, y up and depth away then, not even about
    """

    cost: float
    told: np.ndarray
    off: np.ndarray
    scale: float
    turned: bool = False


@dataclass(frozen=True, eq=False)
class Mistake:
    """A mistake in a table, and the table without it.

    Attributes
    ----------
    name : "as_is", "columns", "sign", "unit", "unit_of_column", "origin", "side", "slant" or "scale"
    what : str, in words: the columns, the unit, ...; of an origin each column, and by how many mm: "x 60, y 40"
    table : ndarray, shape (N, 3), measured x, y and depth without the mistake, mm
    placed : Placed
    sets : names of the sets in whose tables it is; none where it is in all
    """

    name: str
    what: str
    table: np.ndarray
    placed: Placed
    sets: tuple[str, ...] = ()


def place(points: np.ndarray, table: np.ndarray, deep: np.ndarray, free_scale: bool = False) -> Placed:
    """The turn and shift that most lines agree with.

    Parameters
    ----------
    points : ndarray, shape (N, 3), mm, as the cameras tell them: right, down, forward
    table : ndarray, shape (N, 3), x, y and depth, mm
    deep : ndarray, shape (N,), how much worse a place is known along the camera's ray than by the ruler; 1 or more
    free_scale : bool, whether everything may be larger or smaller
    """
    bench = table * [1, 1, -1]
    rng, count = np.random.default_rng(SEED), len(points)
    tries = [rng.choice(count, 4 if free_scale else 3, replace=False) for _ in range(DRAWS)]
    best = min((_placed(points, bench, deep, some, free_scale) for some in tries), key=lambda placed: placed.cost)
    for _ in range(4):
        near = best.off < 2.5 * RULER_MM
        if near.sum() >= 4:
            best = min(best, _placed(points, bench, deep, near, free_scale), key=lambda placed: placed.cost)
    return best


def _placed(points, bench, deep, some, free_scale):
    """Everything placed as some lines tell."""
    rotation, shift, scale = similar(points[some], bench[some], free_scale)
    told = scale * points @ rotation.T + shift
    off = weighed(told - bench, points @ rotation.T, deep) / np.clip(scale, 1e-6, 1.0)  # in the larger of two units
    turned = is_wrong_way(rotation)
    cost = _in_lines(off).sum() + 0.5 * len(points) * turned
    return Placed(float(cost), told * [1, 1, -1], off, float(scale), turned)


def _in_lines(off):
    """What each line costs that is so far off: a wrong one as much as three that are off by as much as a ruler may be."""
    return 3 * np.minimum(off / WRONG_MM, 1)


def weighed(away: np.ndarray, seen: np.ndarray, deep: np.ndarray) -> np.ndarray:
    """How far places are away, shape (N,), mm; along the rays on which they are seen, ``deep`` times less counts."""
    along = (away * seen).sum(1) / np.linalg.norm(seen, axis=1)
    across = np.sqrt(np.maximum((away**2).sum(1) - along**2, 0))
    return np.hypot(across, along / deep)


def similar(points: np.ndarray, bench: np.ndarray, free_scale: bool) -> tuple[np.ndarray, np.ndarray, float]:
    """Turn, shift and scale that bring points nearest to places of the bench, shape (N, 3) each; the scale is 1 where it is not free."""
    rotation, shift = kabsch(points, bench)
    if not free_scale:
        return rotation, shift, 1.0
    a, b = points - points.mean(0), bench - bench.mean(0)
    scale = float((b * (a @ rotation.T)).sum() / max((a**2).sum(), 1e-9))
    return rotation, bench.mean(0) - scale * rotation @ points.mean(0), scale


def likeliest_table(points: np.ndarray, table: np.ndarray, deep: np.ndarray, sets: Sequence[str]) -> Mistake:
    """The mistake in a whole table whose undoing makes most lines agree; ``as_is`` where the table is good enough.

    Parameters
    ----------
    points, table, deep : as :func:`place` takes them
    sets : of each line, the name of the set it stands in
    """
    as_is = Mistake("as_is", "", table, place(points, table, deep))
    if agree(as_is.placed, sets):
        return as_is
    found = [(as_is.placed.cost, as_is)]

    def undo(price, name, what, mended, some=()):
        placed = place(points, mended, deep)
        if price < SHIFTED or _in_lines(placed.off)[np.isin(sets, some)].mean() < MENDED:
            found.append((placed.cost + price, Mistake(name, what, mended, placed, some)))

    names = sorted(set(sets))
    parts = [some for count in range(1, len(names)) for some in itertools.combinations(names, count)]
    for price, name, what, mended in _mistakes(table, as_is.placed.turned):
        undo(price, name, what, mended)
        for some in parts:
            undo(price + ONE_SET * len(some), name, what, np.where(np.isin(sets, some)[:, None], mended, table), some)
    for set_name in names:
        inside = np.isin(sets, set_name)
        shift = _other_origin(points, table, deep, inside)
        for axes in ((0,), (1,), (2,), (0, 1)):  # another corner of the table moves both x and y
            mended = table + np.outer(inside, np.where(np.isin(range(3), axes), shift, 0.0))
            what = ", ".join(f"{AXES[k]} {shift[k]:.0f}" for k in axes)
            undo(SHIFTED * len(axes), "origin", what, mended, (set_name,))
        for axis in range(3):
            if np.ptp(table[inside, axis]) < FLAT_MM:
                continue
            turned = table * np.where(np.outer(inside, np.arange(3) == axis), -1, 1)
            by = _other_origin(points, turned, deep, inside)[axis]
            mended = turned + np.outer(np.where(inside, by, 0.0), np.arange(3) == axis)
            undo(SHIFTED + 0.4, "side", f"{by:.0f} − {AXES[axis]}", mended, (set_name,))
    for some in ((), *parts):
        inside = np.isin(sets, some or names)
        undo(0.6 + ONE_SET * len(some), "slant", "", _straight_away(points, table, inside), some)
    scaled = place(points, table, deep, free_scale=True)
    found.append((scaled.cost + 0.6, Mistake("scale", f"{scaled.scale:.4f}", table, scaled)))
    cost, best = min(found, key=lambda f: f[0])
    return best if cost < as_is.placed.cost - 1 else as_is


def agree(placed: Placed, sets: Sequence[str]) -> bool:
    """Whether the lines of each set agree with the cameras: of many good lines one set's mistake is a small part."""
    lines = _in_lines(placed.off)
    names = np.asarray(sets)
    return not placed.turned and all(lines[names == name].mean() < AGREE for name in set(sets))


def _mistakes(table, turned):
    """(price, name, in words, the table without it) of every mistake that turns numbers into others."""
    for order, signs in itertools.product(itertools.permutations(range(3)), itertools.product((1, -1), repeat=3)):
        exchanged, minus = order != (0, 1, 2), tuple(k for k in range(3) if signs[k] < 0)
        what = ", ".join(("−" if signs[k] < 0 else "") + AXES[order[k]] for k in range(3))
        if exchanged and (turned or not minus):  # both at once can only be seen where all is turned
            yield 0.6 + 0.3 * len(minus), "columns", what, table[:, order] * signs
        elif minus in SIGNS or minus and turned:
            yield 0.4, "sign", " and ".join(AXES[k] for k in minus), table * signs
    for unit, factor in UNITS.items():
        yield 0.4, "unit", unit, table * factor
        for axes in ((0,), (1,), (2,), (0, 1)):  # x and y are read off one sheet
            what = f"{' and '.join(AXES[k] for k in axes)} in {unit}"
            yield 0.6, "unit_of_column", what, table * [factor if k in axes else 1 for k in range(3)]


def _other_origin(points, table, deep, inside):
    """By how much each column of one set would be shifted to fit the others, mm."""
    if inside.sum() < 3 or (~inside).sum() < 4:
        return np.zeros(3)
    others = place(points[~inside], table[~inside], deep[~inside])
    rotation, shift = kabsch(points[~inside], others.told * [1, 1, -1])
    told = (points @ rotation.T + shift) * [1, 1, -1]
    return np.median((told - table)[inside], axis=0)


def right_lines(table: np.ndarray, placed: Placed, deep: np.ndarray) -> dict[int, int]:
    """Of lines that do not fit those that stand beside each other's pictures: picture -> the line that belongs to it.

    Parameters
    ----------
    table : ndarray, shape (N, 3), measured x, y and depth, mm
    placed : Placed, what the cameras tell
    deep : ndarray, shape (N,), as :func:`place` takes it
    """
    wrong, told, found = np.flatnonzero(placed.off > WRONG_MM), placed.told, {}
    for k in wrong:
        weight = np.array([1, 1, 1 / deep[k]])
        off = {j: float(np.linalg.norm((table[j] - told[k]) * weight)) for j in wrong if j != k}
        nearest = min(off, key=lambda j: off[j], default=None)
        if nearest is not None and off[nearest] < WRONG_MM:
            found[int(k)] = int(nearest)
    return found


def _straight_away(points, table, inside):
    """The table with depths that were measured along the line of sight, from the lens to the ball, made straight ones."""
    known = np.column_stack([points, np.ones(len(points))])
    to_right, upwards = np.linalg.lstsq(known, table[:, :2], rcond=None)[0][:3].T  # as the other two columns tell
    away = np.cross(upwards, to_right)
    more = np.linalg.norm(points, axis=1) - points @ (away / np.linalg.norm(away))
    return table - np.outer(np.where(inside, more, 0.0), [0, 0, 1])


def slip_of(line: np.ndarray, told: np.ndarray, weight: np.ndarray) -> str | None:
    """What a hand did to one line of a table, in words; None where nothing simple explains it.

    Parameters
    ----------
    line, told : ndarray, shape (3,), measured x, y and depth, and as the cameras tell them, mm
    weight : ndarray, shape (3,), how much a millimetre of each counts
    """
    tries = [(np.linalg.norm((line[list(o)] - told) * weight), "its columns are exchanged")
             for o in itertools.permutations(range(3)) if o != (0, 1, 2)]  # fmt: skip
    tries += [(np.linalg.norm((line * f - told) * weight), f"it is in {unit}") for unit, f in UNITS.items()]
    for axis in range(3):
        rest = np.linalg.norm(np.delete((line - told) * weight, axis))
        for number, what in slips(float(line[axis])):
            off = np.hypot((number - told[axis]) * weight[axis], rest)
            tries.append((off, f"{AXES[axis]} {line[axis]:g} should be about {told[axis]:.0f}: {what}"))
    off, what = min(tries)
    enough = max(RULER_MM, EXPLAINS * float(np.linalg.norm((line - told) * weight)))
    return what if float(off) < enough else None


def slips(number: float) -> Iterator[tuple[float, str]]:
    """Numbers that a slip of the hand turns into this one, and the slip."""
    yield -number, "another sign"
    yield number * 10, "in centimetres, or a digit is missing"
    yield number * 1000, "a point between the thousands, or in metres"
    yield number / 10, "a digit too many"
    digits, sign = str(abs(round(number))), -1 if number < 0 else 1
    for k, digit in itertools.product(range(len(digits) + 1), "0123456789"):
        yield sign * int(digits[:k] + digit + digits[k:]), "a digit is missing"
    for k in range(len(digits) - 1):
        yield sign * int(digits[:k] + digits[k + 1] + digits[k] + digits[k + 2 :]), "two digits are exchanged"
    if len(digits) > 1:
        for k in range(len(digits)):
            yield sign * int(digits[:k] + digits[k + 1 :]), "a digit too many"

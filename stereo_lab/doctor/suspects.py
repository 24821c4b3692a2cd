"""Mistakes that change everything: each is undone in turn, and the one whose undoing makes the pairs agree is named.

A suspect is a mistake and the boards as they would be without it. Its cost is small where all pairs then tell the same step from
the left camera to the right one. Whoever can explain more has an easier time, so each pays for what it may choose.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from stereo_lab.doctor.boards import Alone, Boards, camera_alone, disagreement, posed_by, steps_between

AGREES = (
    0.008  # of the picture's width, px: boards held by hand are hundreds of pixels apart, and noise is not this large
)
WORST = 3.0  # times that; beyond, one pair is as wrong as another
WRONG_WAY = (
    5.0  # in pairs: what it costs to put the right camera on the left, where undoing the same the other way does not
)
SHIFTS = (1, -1, 2, -2)
LEAST_SHIFTED = 2  # pairs that must agree once shifted: one may by chance
AS_IS = "as_is"
OTHERWISE = ("exchanged", "turned")  # of some pairs: left with right, or both upside down
WHOLE = ("right_mirrored", "left_mirrored", "right_reversed")  # of all pairs; another mistake may stand beside it


def shift_in_words(by: int) -> str:
    """What it means that left pictures belong to the right ones so many places later, or earlier."""
    which, where = ("next", "later") if by > 0 else ("previous", "earlier")
    whose = f"the {which} pair's" if abs(by) == 1 else f"that of the pair {abs(by)} places {where}"
    return (
        f"each left picture belongs to {whose} right picture: the {'left' if by > 0 else 'right'} side lacks {abs(by)}."
    )


@dataclass(frozen=True, eq=False)
class Suspect:
    """A mistake that may have been made.

    Attributes
    ----------
    name : str
    cost : float, how badly the pairs agree without it, in pairs
    mended : Boards without it
    off_px : ndarray, shape (pairs of ``mended``,), how far each is from what most tell then
    told : dict, what else there is to say of it
    """

    name: str
    cost: float
    mended: Boards
    off_px: np.ndarray
    told: dict[str, Any] = field(default_factory=dict)

    @property
    def odd(self) -> np.ndarray:
        """Which pairs do not agree even so."""
        return self.off_px > AGREES * self.mended.size[0]


def likeliest(boards: Boards) -> list[Suspect]:
    """All suspects, the likeliest first; ``as_is`` is one of them. Pairs that only one camera sees stay out."""
    boards = boards.some(boards.both)
    left, right = (camera_alone(seen, boards.board, boards.size) for seen in (boards.left, boards.right))
    found = list(_suspects(boards, left, right))
    best = min(found, key=lambda s: s.cost)
    if best.cost > 0.4 * WORST * len(boards.names):  # nothing explains most pairs: two mistakes at once
        for first in [s for s in found if s.name in WHOLE or s.name == "shifted"]:
            left, right = (camera_alone(s, boards.board, boards.size) for s in (first.mended.left, first.mended.right))
            for second in _suspects(first.mended, left, right):
                both = [{"name": first.name, **first.told}, {"name": second.name, **second.told}]
                if second.name not in (first.name, AS_IS):
                    found.append(replace(second, cost=second.cost + 1, name="two", told={"both": both}))
    return sorted(found, key=lambda s: s.cost)


def _suspects(boards: Boards, left: Alone, right: Alone) -> Iterator[Suspect]:
    """Every mistake that the pairs could have."""
    steps = steps_between(left, right)
    errors = disagreement(left, boards.right, right.lens, steps, boards.board)
    yield _one_step(AS_IS, 0.0, boards, errors)
    yield from _reversed(boards, left, right, steps, errors)
    yield from _shifted(boards, left, right, steps, errors)
    for name in OTHERWISE:
        yield from _from_one_on(name, boards, left, right, steps, errors)
    yield from _moved(boards, errors)
    yield from _mirrored(boards, left, right)


def _share(boards, errors):
    """Errors in units of what agrees, capped."""
    return np.minimum(errors / (AGREES * boards.size[0]), WORST)


def _one_step(name, price, boards, errors, **told):
    """A suspect under which one step holds for all pairs: the one that most agree with."""
    cost = _share(boards, errors).sum(0)
    best = int(cost.argmin())
    return Suspect(name, float(cost[best]) + price, boards, errors[:, best], told)


def _reversed(boards, left, right, steps, errors):
    """Corners counted from the other end in some right pictures, or in all."""
    backwards = boards.right[:, ::-1]
    turned = disagreement(left, backwards, right.lens, steps, boards.board)
    better = np.minimum(errors, turned)
    best = int(_share(boards, better).sum(0).argmin())
    some = turned[:, best] * 1.5 < errors[:, best]
    if some.any():
        mended = replace(boards, right=np.where(some[:, None, None], backwards, boards.right))
        names = tuple(np.array(boards.names)[some])
        price = 0.5 + 0.1 * some.sum()
        yield _one_step("reversed", price, mended, np.where(some[:, None], turned, errors), pairs=names)
    other = posed_by(right, backwards, boards.board)
    again = disagreement(left, backwards, right.lens, steps_between(left, other), boards.board)
    yield _one_step("right_reversed", 0.5, replace(boards, right=backwards), again)


def _shifted(boards, left, right, steps, errors):
    """A picture is missing on one side: from one pair on, every left one stands beside its neighbour's right one."""
    count, every = len(boards.names), np.arange(len(boards.names))
    for by in SHIFTS:
        here = every[max(0, -by) : count - max(0, by)]
        if len(here) < 4:
            continue
        one, other = _some(left, here), _some(right, here + by)
        later = steps_between(one, other)
        before = np.hstack([errors, disagreement(left, boards.right, right.lens, later, boards.board)])
        since = np.full_like(before, np.inf)
        both = [np.concatenate(parts) for parts in zip(steps, later, strict=True)]
        since[here] = disagreement(one, boards.right[here + by], other.lens, both, boards.board)
        tried = []
        for k in range(len(here) - LEAST_SHIFTED + 1):
            lefts = np.concatenate([every[:k], here[k:]])
            rights = np.concatenate([every[:k], here[k:] + by])
            mixed = np.concatenate([before[:k], since[here[k:]]])
            tried.append((_share(boards, mixed).sum(0).min(), k, lefts, rights, mixed))
        _, k, lefts, rights, mixed = min(tried, key=lambda t: t[:2])
        names = tuple(boards.names[n] for n in lefts)
        moved = replace(boards, names=names, left=boards.left[lefts], right=boards.right[rights])
        suspect = _one_step("shifted", 1.0 if k else 0.7, moved, mixed, by=by, k=k)
        yield replace(suspect, cost=suspect.cost * count / len(lefts))


def put_otherwise(name: str, boards: Boards) -> Boards:
    """All pairs with left and right exchanged, or, of those that are "turned", with both pictures turned by half a turn."""
    if name == "exchanged":
        return replace(boards, left=boards.right, right=boards.left)
    last = np.array(boards.size) - 1
    return replace(boards, left=last - boards.left, right=last - boards.right)


def _from_one_on(name, boards, left, right, steps, errors):
    """From one pair on, or up to one, pairs are right once they are put otherwise."""
    others = put_otherwise(name, boards)
    one = posed_by(left, others.left, boards.board)
    crossed = disagreement(one, others.right, right.lens, steps, boards.board)
    count = len(boards.names)
    best = None
    for k in range(1, count):
        for part in (np.arange(count) >= k, np.arange(count) < k):
            mixed = np.where(part[:, None], crossed, errors)
            mixed = np.where(part[None], np.inf, mixed)  # a step is told by a pair that stays as it is
            cost = _share(boards, mixed).sum(0).min()
            if best is None or cost < best[0]:
                best = cost, k, part, mixed
    if best is None:
        return
    _, k, part, mixed = best
    wrong = part[:, None, None]
    mended = replace(
        boards, left=np.where(wrong, others.left, boards.left), right=np.where(wrong, others.right, boards.right)
    )
    yield _one_step(name, 1.0, mended, mixed, pairs=tuple(np.array(boards.names)[part]), k=k)


def _moved(boards, errors):
    """From one pair on, another step holds: a camera was moved."""
    count, share = len(boards.names), _share(boards, errors)
    best = None
    for k in range(2, count - 1):
        before, after = share[:k, :k].sum(0), share[k:, k:].sum(0)
        cost = before.min() + after.min()
        if best is None or cost < best[0]:
            best = cost, k, int(before.argmin()), k + int(after.argmin())
    if best is None:
        return
    cost, k, one, other = best
    off = np.where(np.arange(count) < k, errors[:, one], errors[:, other])
    yield Suspect("moved", float(cost) + 2.2, boards, off, {"k": k, "steps": (one, other)})


def _mirrored(boards, left, right):
    """One camera shows itself as a mirror does."""
    for side, alone in (("left", left), ("right", right)):
        seen = mirrored(getattr(boards, side), boards)
        lens = alone.lens * [1, 1, 1, 1, 1, 1, 1, -1, 1]
        lens[2] = boards.size[0] - 1 - lens[2]
        turned = posed_by(replace(alone, lens=lens), seen, boards.board)
        one, other = (turned, right) if side == "left" else (left, turned)
        mended = replace(boards, **{side: seen})
        steps = steps_between(one, other)
        suspect = _one_step(
            f"{side}_mirrored", 0.5, mended, disagreement(one, mended.right, other.lens, steps, boards.board), side=side
        )
        # Flipping the wrong one makes the pairs agree as well, in a world seen in a mirror, where the right camera is on the left.
        yield replace(suspect, cost=suspect.cost + float(np.nanmedian(_wrong_way(steps)[~suspect.odd])))


def _wrong_way(steps):
    """For each pair the price of putting the right camera on the left."""
    turns, shifts = (np.nan_to_num(part) for part in steps)
    return np.where(-np.einsum("nji,nj->ni", turns, shifts)[:, 0] < 0, WRONG_WAY, 0.0)


def mirrored(seen: np.ndarray, boards: Boards) -> np.ndarray:
    """Corners, shape (pairs, corners, 2), as they would be in the pictures' mirror images, row by row again."""
    across, down = boards.board.grid
    flipped = seen * [-1, 1] + [boards.size[0] - 1, 0]
    return flipped.reshape(len(seen), down, across, 2)[:, :, ::-1].reshape(seen.shape)


def _some(alone, chosen):
    return replace(alone, turns=alone.turns[chosen], shifts=alone.shifts[chosen], rms_px=alone.rms_px[chosen])

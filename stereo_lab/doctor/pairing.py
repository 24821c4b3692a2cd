"""Do the pairs belong together? What is wrong is undone, and what is left is looked at again, until nothing is found."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from stereo_lab.calibration.bundle import Rig
from stereo_lab.common.files import natural_key
from stereo_lab.doctor.boards import Boards
from stereo_lab.doctor.findings import Evidence, listed
from stereo_lab.doctor.steps import (
    ALL_DIFFER,
    FEWEST,
    SURE,
    Pulls,
    Together,
    fit_together,
    lenses_straightened,
    off_by,
    pictures_slip,
    what_changed,
)
from stereo_lab.doctor.suspects import AS_IS, OTHERWISE, Suspect, likeliest, put_otherwise, shift_in_words
from stereo_lab.errors import CalibrationError

ROUNDS = 5
MOST_DRAWN = 0.1  # of the picture's width: more looks like this much in a figure
MOST_ODD = 0.5  # part of the pairs that a suspect may leave unexplained
GAIN = 1.0  # in pairs' worth: what a suspect must explain beyond what there is
BELONGS = 8.0  # sigmas: three quarters of a pair's coordinates are nearer than this, where it belongs to the others
AT_ONE_END = 0.6  # part of the last pairs, or the first, that must be odd for it to be a change and no slips
AGAINST_ODD = 0.75  # a change must explain so much of what odd pairs explain
NEAR = 3  # pairs round the first guess among which the first of a new state is


@dataclass(frozen=True, eq=False)
class Mend:
    """One thing that was wrong with the pairs, and the pairs without it.

    Attributes
    ----------
    name : str, of the finding
    says : str
    pairs : names of the pairs concerned
    boards : Boards afterwards
    rigs : (before, since) of a change, Rig each; empty where nothing has moved
    evidence : Evidence
    side : str, "left" or "right" where one camera is concerned
    """

    name: str
    says: str
    pairs: tuple[str, ...]
    boards: Boards
    rigs: tuple[Rig, ...] = ()
    evidence: Evidence | None = None
    side: str = ""


def mend_pairs(boards: Boards) -> tuple[list[Mend], Together | None]:
    """Everything that is wrong with how pairs go together, in the order found, and a fit of what is left."""
    mends: list[Mend] = []
    boards = boards.some(boards.both)
    if len(boards.names) < 4:
        return mends, None
    boards, odd = _gross(boards, mends)
    try:
        if odd.sum() > len(odd) / 2:
            mends.append(
                _not_together(
                    boards, f"In {odd.sum()} of {len(odd)} pairs the two pictures do not show the board at one place"
                )
            )
            return mends, None if (~odd).sum() < 4 else fit_together(boards.some(~odd))
        return mends, _fine(_put_back(boards, odd, mends), mends)
    except (CalibrationError, np.linalg.LinAlgError):
        return mends, None


def _gross(boards, mends):
    """Mistakes that change everything. Returns the boards without them, and which pairs even then do not agree."""
    for _ in range(ROUNDS):
        found = likeliest(boards)
        best, as_is = _not_a_change(found), next(s for s in found if s.name == AS_IS)
        if best.name == AS_IS or as_is.cost - best.cost < GAIN or best.odd.mean() > MOST_ODD:
            break
        boards = _noted(boards, best, as_is, mends)
    best = next(s for s in likeliest(boards) if s.name == AS_IS)
    return best.mended, best.odd


def _not_a_change(found: list[Suspect]) -> Suspect:
    """The likeliest, but cameras that are exchanged, or upside down, are no cameras that moved: a second step takes all in."""
    best = found[0]
    other = next((s for s in found if s.name in OTHERWISE), best)
    as_is = next(s for s in found if s.name == AS_IS)
    return other if best.name == "moved" and other.cost < min(best.cost + 2, as_is.cost - 3) else best


def _noted(boards, best, as_is, mends):
    """Put a suspect down; returns the boards without it."""
    best = _right_way(best, boards) if best.name in OTHERWISE else best
    both = best.told.get("both") or [{"name": best.name, **best.told}]
    for told in both:
        if told["name"] == "moved":
            return _moved(boards, told["k"], mends)
        name, says, pairs = _in_words(told, boards)
        seen, side = _numbers(as_is, boards, pairs), str(told.get("side", ""))
        mends.append(Mend(name, says, pairs, best.mended, evidence=seen, side=side))
    return best.mended


def _right_way(best, boards):
    """Of pairs that were put otherwise those that leave the right camera on the right when they are changed."""
    try:
        if not turned_round(fit_together(best.mended.some(~best.odd)).solution.rig):
            return best
    except (CalibrationError, np.linalg.LinAlgError):
        return best
    others = tuple(name for name in boards.names if name not in best.told["pairs"])
    return replace(best, mended=put_otherwise(best.name, best.mended), told={**best.told, "pairs": others})


def turned_round(rig: Rig) -> bool:
    """Whether the right camera stands on the left, told in the directions that both cameras share."""
    step = -rig.rotation.T @ rig.translation
    across, down, _ = np.eye(3) + rig.rotation
    return bool(step @ across < 0 and abs(step @ across) > abs(step @ down))


def _numbers(as_is, boards, marked):
    off = np.minimum(as_is.off_px, MOST_DRAWN * boards.size[0]).round(2).tolist()
    what = "distance of a pair's corners from where most other pairs put them, px"
    return Evidence(what, tuple(zip(as_is.mended.names, off, strict=True)), tuple(marked))


def _in_words(told, boards):
    """Name, sentence and pairs of a suspect."""
    name = told["name"]
    if name == "shifted":
        words, pairs = shift_in_words(told["by"]), boards.names[told["k"] :]
        words = f"From pair {pairs[0]} on {words}" if told["k"] else words[0].upper() + words[1:]
        return "pairs_shifted", words, pairs
    if name == "exchanged":
        pairs = tuple(str(n) for n in told["pairs"])
        return "cameras_exchanged", f"In {_some(pairs)} left and right are exchanged, and in the others not.", pairs
    if name == "turned":
        pairs = tuple(str(n) for n in told["pairs"])
        return "pairs_upside_down", f"In {_some(pairs)} both pictures are upside down, and in the others not.", pairs
    if name.endswith("mirrored"):
        side = told["side"]
        return (
            "mirrored",
            f"The {side} camera's pictures are mirror images: the boards agree when they are flipped.",
            boards.names,
        )
    if name == "right_reversed":
        return "reversed_order", "The corners are counted from opposite ends in the two cameras.", boards.names
    pairs = tuple(str(n) for n in told["pairs"])
    return "reversed_order", f"In {_some(pairs)} the corners are counted from the other end of the board.", pairs


def _some(pairs):
    """A few names, and how many more."""
    if len(pairs) <= 4:
        return listed("pair", pairs)
    return f"pairs {pairs[0]} to {pairs[-1]} ({len(pairs)} of them)"


def _moved(boards, k, mends):
    """A change from about pair k on: the larger part stays, and the cameras on the other side are told by the smaller one."""
    for _ in range(ROUNDS):
        late = np.arange(len(boards.names)) >= k
        late_is_larger = late.mean() > 0.5
        kept, others = (boards.some(part) for part in ((late, ~late) if late_is_larger else (~late, late)))
        start = fit_together(kept)
        what, rig = what_changed(others, start)
        used, k = k, _first_of_new(boards, k, start, rig, late_is_larger)
        if used == k:
            break
    before, since = (rig, start.solution.rig) if late_is_larger else (start.solution.rig, rig)
    name, says = _change_in_words(what, boards.names[used], before, since)
    off = np.minimum(off_by(boards, start), MOST_DRAWN * boards.size[0]).round(2).tolist()
    when = "since" if late_is_larger else "before"
    numbers = f"distance of corners from where the cameras put them that stand {when}, px"
    seen = Evidence(numbers, tuple(zip(boards.names, off, strict=True)), others.names)
    _take_in(boards.names[used], late_is_larger, mends)
    mends.append(Mend(name, says, boards.names[used:], kept, (before, since), seen))
    return kept


def _change_in_words(what, first, before, since):
    if what == "moved":
        says = f"From pair {first} on, the cameras stand otherwise to each other: one of them was moved."
        return "camera_moved", says
    percent = 100 * (getattr(since, what)[0] / getattr(before, what)[0] - 1)
    says = f"From pair {first} on, the {what} camera's focal length is {percent:+.2f} %: it zoomed, or focused anew."
    return "camera_zoomed", says


def _take_in(first, late_is_larger, mends):
    """Pairs that stood out, and are all on the far side of a change, are explained by it."""
    for mend in [mend for mend in mends if mend.name == "pairs_do_not_match"]:
        if all((natural_key(name) < natural_key(first)) == late_is_larger for name in mend.pairs):
            mends.remove(mend)


def _first_of_new(boards, k, start, rig, late_is_larger):
    """The first pair of the new state, exactly: of those near the first guess, the one that parts the two rigs best."""
    near = np.arange(max(0, k - NEAR), min(len(boards.names), k + NEAR))
    some = boards.some(near)
    kept, others = off_by(some, start) ** 2, off_by(some, start, rig) ** 2
    late, early = (kept, others) if late_is_larger else (others, kept)
    splits = [n for n in [*near, near[-1] + 1] if 2 <= n <= len(boards.names) - 2]
    return int(min(splits, key=lambda n: np.where(near >= n, late, early).sum()))


def _put_back(boards, odd, mends):
    """Fit the pairs that agree; those that fit after all come back, the others are put down."""
    if not odd.any() or (~odd).sum() < 4:
        return fit_together(boards)
    together = fit_together(boards.some(~odd))
    numbers = np.flatnonzero(odd)
    off = off_by(boards.some(numbers), together)
    belongs = off < BELONGS * together.sigma_px
    keep = ~odd
    keep[numbers[belongs]] = True
    if belongs.any():
        together = fit_together(boards.some(keep))
    away = np.flatnonzero(~keep)
    if len(away):
        k = _at_one_end(away, len(odd))
        if k is not None:
            kept = _moved(boards, k, mends)
            return fit_together(kept)
        mends.append(_odd(boards, away, off[~belongs], boards.some(keep)))
    return together


def _not_together(boards, seen, evidence=None):
    """Pairs that do not belong together, most of them, as ``seen`` says; and whether the pictures slipped, or the board moved."""
    try:
        slips = pictures_slip(boards)
    except (CalibrationError, np.linalg.LinAlgError):
        slips = False
    name, why = (
        ("stabilised", "each picture has slipped as a whole, as those of a camera do that stabilises them")
        if slips
        else ("not_together", "it moved between them, a camera focused anew, or the pictures are of different moments")
    )
    return Mend(name, f"{seen}: {why}.", boards.names, boards, (), evidence)


def _at_one_end(away, count):
    """The first pair of a new state, where pairs that do not agree stand at one end of the recording; or None."""
    if len(away) < 3 or count - len(away) < 4:
        return None
    for part, k in ((np.arange(away.min(), count), away.min()), (np.arange(away.max() + 1), away.max() + 1)):
        if len(part) <= AT_ONE_END * count and np.isin(part, away).mean() > AT_ONE_END and 2 <= k <= count - 2:
            return int(k)
    return None


def _odd(boards, away, off, kept):
    pairs = tuple(boards.names[k] for k in away)
    says = f"In {_some(pairs)} left and right do not belong together: their corners lie {max(off):.1f} px off."
    values = tuple((name, round(float(px), 2)) for name, px in zip(pairs, off, strict=True))
    return Mend("pairs_do_not_match", says, pairs, kept, (), Evidence("distance of corners, px", values, pairs))


def _fine(together, mends):
    """Small changes, by what each pair pulls at. Returns the fit of what is left."""
    for _ in range(ROUNDS):
        boards = together.boards
        if len(boards.names) < FEWEST:
            break
        pulls = Pulls(together)
        spread = pulls.spread()
        change, (odd, sure) = pulls.change(spread), pulls.odd(spread)
        values = tuple(zip(boards.names, np.sqrt(pulls.alone / 6).round(2).tolist(), strict=True))
        seen = Evidence("how much a pair contradicts the others, in standard deviations", values)
        if change.sure > SURE and (change.sure > AGAINST_ODD * sure):
            together = fit_together(_moved(boards, change.k, mends))
        elif sure > SURE:
            kept = np.setdiff1d(np.arange(len(boards.names)), odd)
            pairs = tuple(boards.names[k] for k in odd)
            worst = max(np.sqrt(pulls.alone[odd] / 6))
            says = f"In {_some(pairs)} left and right do not quite belong together: they contradict the others {worst:.0f} times more than noise."
            mends.append(Mend("pairs_do_not_match", says, pairs, boards.some(kept), (), replace(seen, marked=pairs)))
            together = fit_together(boards.some(kept))
        else:
            if spread > ALL_DIFFER and Pulls(lenses_straightened(together)).spread() > ALL_DIFFER:
                mends[:] = [
                    mend for mend in mends if mend.name != "pairs_do_not_match"
                ]  # they are no odder than the others
                says = f"The pairs contradict each other about the board's place {np.sqrt(spread):.0f} times more than noise"
                mends.append(_not_together(boards, says, seen))
            break
    return together

"""The measured balls: whether they are seen, and whether the ruler's numbers fit what the cameras see."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np

from stereo_lab.detection import BallColor
from stereo_lab.doctor.advice import ADVICE
from stereo_lab.doctor.balls import (
    LOST_PART,
    Sighting,
    deepness,
    look_for_balls,
    other_name,
    places,
    size_of_ball,
    state_of_balls,
    why_lost,
)
from stereo_lab.doctor.bench import told_on_bench
from stereo_lab.doctor.cameras import Cameras
from stereo_lab.doctor.findings import COSTS, NOTE, STOPS, Evidence, Finding, listed
from stereo_lab.doctor.known import MOST, doubt_mm
from stereo_lab.doctor.numbers import AXES, WRONG_MM, likeliest_table, place, right_lines, slip_of
from stereo_lab.doctor.odd_pairs import odd_pairs
from stereo_lab.doctor.partners import (
    boards_alone,
    exchanged_sets,
    mirrored_sets,
    shifted_pairs,
    sides_told,
    uncrossed_samples,
)
from stereo_lab.doctor.scales import scale_by_ruler, scales_told, squares_or_table
from stereo_lab.doctor.since import changed_since, moved_up_or_down
from stereo_lab.position import kabsch
from stereo_lab.recording import Recording

SETS = "position", "depth", "evaluation"
UNFIT = 1.5  # in lines' worth a line: half of what they cost if none of them fitted
FEWEST = 5  # balls from which a table can be judged
LEAST_RUN = 3  # places that are off one after the other
FAR_OFF = 4.0  # robust sigmas of all lines, beyond which a line is wrong; three times the ruler at least
TURNED = {"": [1, 1, 1], "both_mirrored": [-1, 1, 1], "both_upside_down": [-1, -1, 1]}  # how places are turned by that


@dataclass(frozen=True, eq=False)
class Told:
    """What the balls tell.

    Attributes
    ----------
    findings : list of Finding
    mirror : str, "both_mirrored" or "both_upside_down" where the places ask for it, else empty
    seen : int, in how many pairs both cameras see the ball
    color : str, the name by which balls are found that were lost by their own; else empty
    """

    findings: list[Finding]
    mirror: str = ""
    seen: int = 0
    color: str = ""


def check_balls(
    recording: Recording,
    cameras: Cameras,
    clean: float,
    progress: Callable[[int, int], object] | None = None,
    without: Collection[str] = (),
) -> Told:
    """Everything that the measured balls tell.

    Parameters
    ----------
    recording : Recording
    cameras : Cameras, with a calibration
    clean : float, what a clean recording's error is, mm
    progress : callable (done, total), optional
    without : names of pairs that cannot tell: both their pictures are one
    """
    told = _told_by_name(recording, cameras, clean, progress, without)
    if not told.color:
        return told
    # By the name that finds them they are judged as they will be once that is mended
    mended = replace(recording, ball=replace(recording.ball, color=told.color))
    rest = _told_by_name(mended, cameras, clean, progress, without)
    if rest.seen <= told.seen:
        return told
    wrong = [f for f in told.findings if f.name == "color_wrong"]
    return replace(rest, findings=[*wrong, *(f for f in rest.findings if f.name != "color_wrong")])


def _told_by_name(recording, cameras, clean, progress, without):
    """What the balls tell that are found by the name of their colour."""
    color = BallColor.named(recording.ball.color)
    cameras, told = boards_alone(recording, color, cameras)
    exchanged = exchanged_sets(recording, color, cameras)
    told += sides_told(recording, exchanged, cameras.swapped)
    every = uncrossed_samples(recording, SETS, exchanged, cameras.swapped)
    samples = {name: sample for name, sample in every.items() if name not in without}
    if not samples:
        return Told(told)
    calibration = state_of_balls(cameras.states, list(samples.values()), color, cameras.undo)
    sightings = look_for_balls(samples, color, recording.ball, calibration, cameras.undo, progress)
    mirrored = [] if any(cameras.undo) else mirrored_sets(sightings, calibration)
    told += (wrong := shifted_pairs(sightings, calibration) or mirrored)
    sightings = _without(sightings, wrong)
    told += (odd := odd_pairs(sightings, calibration))
    sightings = _without(sightings, odd)
    seen = [s for s in sightings if s.seen]
    lost, other = _lost(sightings, recording)
    so_far = Told(told + lost + ([] if other else _other_name(seen, recording)), "", len(seen), other)
    if len(seen) < FEWEST:
        return so_far
    points = places(seen, calibration)
    good = np.isfinite(points).all(1) & (points[:, 2] > 0)
    seen, points = [s for s, g in zip(seen, good, strict=True) if g], points[good]
    if len(seen) < FEWEST:
        return so_far
    deep = deepness(seen, points, calibration)
    findings, mirror = _numbers(recording, calibration, cameras, seen, points, deep, clean, so_far.findings)
    return replace(so_far, findings=findings, mirror=mirror)


def _without(sightings, findings):
    """Sightings of which nothing is told yet."""
    told = {name for finding in findings for name in finding.files}
    return [s for s in sightings if s.name not in told]


def _lost(sightings: Sequence[Sighting], recording: Recording) -> tuple[list[Finding], str]:
    """What is said of balls that were lost, and the other name that finds them."""
    if (moved := moved_up_or_down(sightings)) and moved.severity == STOPS:
        return [moved], ""
    told = [moved] if moved else []
    lost = [s for s in sightings if not s.seen and not (moved and s.name in moved.files)]
    if not lost:
        return told, ""
    files, many = tuple(s.name for s in lost), len(lost) > LOST_PART * len(sightings)
    lost_of, all_of = (Counter(s.set_name for s in some) for some in (lost, sightings))
    bereft = [name for name in SETS if lost_of[name] > all_of[name] / 2]
    why = why_lost(lost, recording.ball if many or bereft else None)
    severity = STOPS if len(sightings) - len(lost) < 3 else COSTS if many or bereft else NOTE
    where = f", in most of the {listed('set', bereft)}" if bereft and not many else ""
    says = f"The ball was lost in {len(lost)} of {len(sightings)} measured pairs{where}. {why.says}"
    values = tuple((s.name, float(s.seen)) for s in sightings)
    evidence = Evidence("ball seen by both cameras", values, files)
    few = why.name == "rows_apart" and severity == NOTE  # of cameras that moved there would be more
    advice = ADVICE["pairs_do_not_match" if few else why.name]
    return [*told, Finding(why.name, says, advice, files, None, severity, evidence)], why.color


def _other_name(seen, recording):
    """Balls that are found by a name whose hue they do not have."""
    if (found := other_name(seen, recording.ball.color)) is None:
        return []
    says = f"The ball is found, but its hue, {found[1]:.0f}, is that of {found[0]}, and recording.json says {recording.ball.color}."
    return [Finding("color_wrong", says, ADVICE["color_wrong"])]


def _numbers(recording, calibration, cameras, seen, points, deep, clean, findings):
    table = np.array([[m.x_mm, m.y_mm, m.depth_mm] for m in (s.sample.measured for s in seen)])
    sets = [s.set_name for s in seen]
    best, mirror = likeliest_table(points, table, deep, sets), ""
    if cameras.swapped and (mirror := _seen_how(points, table, deep, best)):
        points = points * TURNED[mirror]
        best = likeliest_table(points, table, deep, sets)
    size, size_sigma = size_of_ball(seen, points, calibration)
    by_ball = recording.ball.diameter_mm / size
    best = squares_or_table(best, by_ball, points, table, deep)
    if best.name in ("as_is", "scale") and (since := changed_since(best, seen, calibration, table, deep)):
        points, best, finding = since
        findings = [*findings, finding]
        size, size_sigma = size_of_ball(seen, points, calibration)
        by_ball = recording.ball.diameter_mm / size
    doubt = max(clean, doubt_mm(calibration))  # with what its boards lack
    by_ruler, sigma = scale_by_ruler(points, best, deep, doubt / 2 / calibration.depth_mm)
    told = scales_told(recording, calibration, by_ball, size_sigma / size, by_ruler, sigma, best)
    measured = recording, calibration, seen, points, best.table, by_ruler, cameras.undo
    findings += [told_on_bench(f, *measured) if f.does_mm else f for f in told]  # a diameter costs no mm
    belongs = right_lines(best.table, best.placed, deep)
    if _fits_nowhere(best.placed, belongs, clean):
        return [*findings, _unfit(best, seen)], mirror
    if best.name not in ("as_is", "scale"):
        findings.append(_whole_table(best, table, seen))
    if belongs:
        findings.append(_exchanged(best, belongs, seen, points))
    findings += _together(_lines(best, seen, table, points, deep, belongs), [s.name for s in seen])
    return findings, mirror


def _seen_how(points, table, deep, best):
    """Cameras that seem exchanged may both show mirror images, or both stand on their heads: which of :data:`TURNED`.

    None, "", where they are exchanged and nothing else, and ``best``, a mistake in the table, explains it as well.
    """
    costs = {name: place(points * turn, table, deep).cost for name, turn in TURNED.items()}
    likeliest = min(costs, key=lambda name: costs[name])
    looks_like_it = best.name == "sign" and not best.sets and best.what in ("x", "x and y")
    return likeliest if looks_like_it or best.placed.cost >= costs[likeliest] + 1 else ""


def _fits_nowhere(placed, belongs, clean):
    """Whether most lines do not fit, those left aside that stand beside each other's pictures."""
    rest = np.delete(placed.off, list(belongs))
    cost = placed.cost - 3 * len(belongs)
    bad = max(WRONG_MM, clean) if np.isfinite(clean) else WRONG_MM  # cameras of which nobody tells how exact they are
    return len(rest) < FEWEST or cost > UNFIT * len(rest) and np.percentile(rest, 75) > bad


def _how_far_off(best, seen, wrong):
    """How far each line is off; ``wrong``: the numbers of those at fault."""
    values = tuple((s.name, round(float(o), 1)) for s, o in zip(seen, best.placed.off, strict=True))
    what = "distance of the measured place from the one that the cameras tell, mm"
    return Evidence(what, values, tuple(seen[k].name for k in wrong))


def _unfit(best, seen):
    """A table, or that of one set, that fits nowhere, whichever mistake is undone."""
    off = best.placed.off
    wrong = [k for k in range(len(seen)) if off[k] > WRONG_MM]
    sets = sorted({seen[k].set_name for k in wrong})
    whose = f" of the {listed('set', sets)}" if len(sets) < len({s.set_name for s in seen}) else ""
    says = (
        f"{len(wrong)} measured places{whose} do not fit what the cameras see, however they are turned: half of these are off by "
        f"{np.median(off[wrong]):.0f} mm or more, and no single mistake explains it."
    )
    seen_by = _how_far_off(best, seen, wrong)
    return Finding("table_unfit", says, ADVICE["table_unfit"], seen_by.marked, None, STOPS, seen_by)


def _whole_table(best, table, seen):
    """A mistake of all tables, or of those of some sets."""
    whose = f" of the {listed('set', best.sets)}" if best.sets else ""
    files = tuple(s.name for s in seen if not best.sets or s.set_name in best.sets)
    says = {
        "columns": f"The measured columns{whose} fit when they are read as {best.what}.",
        "sign": f"The measured numbers{whose} fit when the sign of {best.what} is turned round.",
        "unit": f"The measured numbers{whose} fit when they are read as {best.what}.",
        "side": f"The measured numbers{whose} fit when they are counted from the other side, as {best.what}.",
        "slant": f"The measured depths{whose} fit when they are taken along the line of sight, from the lens to the ball.",
        "unit_of_column": f"The measured numbers{whose} fit when they are read as {best.what}.",
    }
    if best.name == "origin":
        return _another_origin(best, files, next(s.set_name for s in seen if s.name not in files))
    name = {"columns": "columns_exchanged", "side": "sign", "unit_of_column": "unit"}.get(best.name, best.name)
    does = float(np.percentile(np.linalg.norm(best.table - table, axis=1), MOST))
    mirror = best.name == "sign" and best.what == "x" and not best.sets  # a world in a mirror has its x the other way
    advice = ADVICE["other_side" if best.name == "side" else "sign_of_x" if mirror else name]
    return Finding(name, says[best.name], advice, files, does)


def _another_origin(best, files, other):
    """Two sets of which a column, or x and y, was not measured from one place; which of the two is right cannot be known."""
    shifts = {axis: float(by) for axis, by in (part.split() for part in best.what.split(", "))}
    (of_set,) = best.sets
    name, where = ("plane", "one plane") if "depth" in shifts else ("origin", "one point")
    lies = {
        "x": ("to the left", "to the right"),
        "y": ("lower", "higher"),
        "depth": ("farther from the balls", "nearer to the balls"),
    }
    away = " and ".join(f"{abs(by):.0f} mm {lies[axis][by > 0]}" for axis, by in shifts.items())
    says = f"The sets {of_set} and {other} do not measure {' and '.join(shifts)} from {where}: that of {of_set} lies {away}."
    return Finding(name, says, ADVICE[name], files, float(np.hypot.reduce(list(shifts.values()))))


def _exchanged(best, belongs, seen, points):
    """Lines that stand beside each other's pictures."""
    moves = [f"that of {seen[line].name} belongs to {seen[k].name}" for k, line in belongs.items()]
    says = f"{len(moves)} lines stand beside another picture: {', '.join(moves[:4])}{', and so on' if len(moves) > 4 else ''}."
    files = tuple(seen[k].name for k in belongs)
    # One by one: together they may cancel out by chance
    does = max(_pulls(points, best.table, k, seen) for k in belongs)
    evidence = _how_far_off(best, seen, list(belongs))
    return Finding("lines_exchanged", says, ADVICE["lines_exchanged"], files, does, evidence=evidence)


def _lines(best, seen, table, points, deep, belongs):
    """Single lines that do not fit, each with what a hand may have done; those that belong to other pictures are told already."""
    off, told = best.placed.off, best.placed.told
    limit = max(WRONG_MM, FAR_OFF * 1.4826 * float(np.median(np.delete(off, list(belongs)))))
    wrong = [k for k in np.flatnonzero(off > limit) if k not in belongs]
    seen_by, findings = _how_far_off(best, seen, wrong), []
    for k in wrong:
        weight = np.array([1, 1, 1 / deep[k]])
        why = slip_of(best.table[k], told[k], weight)
        away = np.abs(best.table[k] - told[k])
        axis = int(np.argmax(away * weight))
        # The numbers that are told then are the mended ones, not those in the file
        after = "" if np.array_equal(best.table[k], table[k]) else ", with that mended,"
        says = f"{seen[k].name}{after} does not fit by {away[axis]:.0f} mm in {AXES[axis]}: "
        says += f"{why}." if why else f"measured {best.table[k][axis]:.4g}, and the cameras tell {told[k][axis]:.0f}."
        does = _pulls(points, best.table, k, seen)
        name = "typing_slip" if why else "sample_off"
        findings.append(Finding(name, says, ADVICE[name], (seen[k].name,), does, evidence=seen_by))
    return findings


def _together(lines, names):
    """Where all places of a set are off, or all from one picture on, and no slip explains it, one finding instead of many."""
    for set_name in dict.fromkeys(name.split("/")[0] for name in names):
        inside = [name for name in names if name.startswith(f"{set_name}/")]
        off = [f for f in lines if f.name == "sample_off" and f.files[0] in inside]
        files = tuple(inside[-len(off) :])
        if len(off) < LEAST_RUN or {f.files[0] for f in off} != set(files):
            continue
        name, advice = "moved_since", "moved_since"
        says = f"From {files[0]} on all {len(off)} places are off, and none before: something was moved before that picture was taken."
        if len(off) == len(inside):
            name, advice = "table_unfit", "set_unfit"
            says = f"All {len(off)} places of {set_name} are off, and no single mistake explains it."
        does = max(f.does_mm for f in off)
        found = Finding(name, says, ADVICE[advice], files, does, evidence=off[0].evidence)
        lines = [found, *(f for f in lines if f not in off)]
    return lines


def _pulls(points, table, k, seen):
    """How far one line moves places, 95 % of them, in a least-squares fit that trusts every line of its kind, mm.

    Places are fitted to position and depth; evaluation, which judges them, is taken by itself.
    """
    judges = np.array([s.name.startswith("evaluation/") for s in seen])
    alike, bench = judges == judges[k], table * [1, 1, -1]
    if alike.sum() < FEWEST:
        alike = np.ones(len(table), bool)
    rest = alike & (np.arange(len(table)) != k)
    told = [points @ r.T + s for r, s in (kabsch(points[lines], bench[lines]) for lines in (alike, rest))]
    return float(np.percentile(np.linalg.norm(told[0] - told[1], axis=1), MOST))

"""The sets of balls by themselves: what keeps one from being used at all, before anything is looked for in its pictures."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from stereo_lab.doctor.advice import ADVICE
from stereo_lab.doctor.findings import COSTS, STOPS, Finding
from stereo_lab.doctor.measured import SETS
from stereo_lab.errors import StereoLabError
from stereo_lab.localization.paper import EQ4_NEEDS, LINE_NEEDS
from stereo_lab.recording import Recording, StereoPair
from stereo_lab.recording.model import SHARED_OUT

NEEDED = {"position": LINE_NEEDS, "depth": EQ4_NEEDS}  # lines to fit on, of the paper's way


def unreadable(error: StereoLabError) -> Finding:
    """A table that cannot be used, a picture that cannot, or one without its other half."""
    name = error.fault or ("table_broken" if "measured.csv" in str(error) else "picture_broken")
    return Finding(name, str(error), ADVICE[name], severity=STOPS)


def unread(pair: StereoPair) -> StereoLabError | None:
    """Why a picture of a pair cannot be used; None where both can."""
    try:
        _ = pair.left, pair.right_path and pair.right
    except StereoLabError as error:
        return error
    return None


def broken(set_name: str, spoilt: Mapping[str, StereoLabError]) -> list[Finding]:
    """The pairs of a set whose pictures cannot be used, put down together."""
    if not spoilt:
        return []
    files = tuple(f"{set_name}/{name}" for name in spoilt)
    why = next(iter(spoilt.values()))
    says = str(why) + (f" So are {len(spoilt) - 1} more of {set_name}." if len(spoilt) > 1 else "")
    name = why.fault or "picture_broken"
    return [Finding(name, says, ADVICE[name], files, severity=STOPS)]


def look_at_sets(
    recording: Recording, known: Sequence[Finding], say: Callable[[str, int, int], object]
) -> list[Finding]:
    """What keeps a set of balls from being used at all, and is not known yet: a picture, the table, the other camera's half."""
    findings: list[Finding] = []
    for name in (name for name in recording.sets if name != "calibration"):
        try:
            pairs = recording.pairs(name)
            lines = recording.samples(name) if recording.has_samples(name) else ()
        except StereoLabError as error:
            findings.append(unreadable(error))
            continue
        misnamed = any(finding.name == "misnamed" and f"/{name}/" in finding.says for finding in known)
        if name in SETS and not recording.has_samples(name) and not misnamed:
            says = f"{name} has pictures and no measured.csv, which tells where the ball was: they cannot be used."
            findings.append(Finding("no_table", says, ADVICE["no_table"]))  # what a recording lacks is no fault
        with_one = {sample.pair.name for sample in lines}
        if lines and (without := [pair.name for pair in pairs if pair.name not in with_one]):
            says = (
                f"{len(without)} of {len(pairs)} pictures of {name} have no line in its measured.csv, and are not used."
            )
            findings.append(Finding("no_line", says, ADVICE["no_line"], tuple(f"{name}/{lost}" for lost in without)))
        if name in SHARED_OUT and lines:
            findings += _to_fit(name, lines)
        if name in SETS and pairs[0].right_path is None:
            says = f"{name} was taken with the left camera alone: no depth comes out of it."
            findings.append(Finding("half_missing", says, ADVICE["left_alone"], severity=STOPS))
        spoilt: dict[str, StereoLabError] = {}
        for done, pair in enumerate(pairs, 1):
            if (why := unread(pair)) is not None:
                spoilt[pair.name] = why
            say(f"look at {name}", done, len(pairs))
        findings += broken(name, spoilt)
    told = {finding.says for finding in known}
    return [*(finding for finding in findings if finding.says not in told), *_to_judge(recording)]


def _to_fit(name, lines):
    """A set of which the paper's way has too few lines to fit on."""
    count, needed = sum(sample.use == "fit" for sample in lines), NEEDED[name]
    if count >= needed:
        return []
    number = "no line says" if not count else "1 line says" if count == 1 else f"{count} lines say"
    says = f"In the measured.csv of {name} {number} fit in the column use, and the paper's way cannot be fitted: it needs {needed} of them."
    advice = "none_to_fit" if (len(lines) + 1) // 2 >= needed else "too_few_lines"  # every second one is fitted on
    name, severity = ("too_few_to_fit", COSTS) if count else ("none_to_fit", STOPS)  # ours is fitted on all of them
    return [Finding(name, says, ADVICE[advice], severity=severity)]


def _to_judge(recording):
    """Places that are all fitted on, so that none is left to tell how far off they are."""
    try:
        if recording.judges() or not all(recording.has_samples(name) for name in SHARED_OUT):
            return []
    except StereoLabError:  # told elsewhere
        return []
    says = "There is no evaluation set, and no line of position or depth says check in the column use: no sample judges what comes out."
    return [Finding("none_to_judge", says, ADVICE["none_to_judge"])]

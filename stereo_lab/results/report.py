"""The page that ``stereo-lab demo`` prints, and its picture report in one file."""

from __future__ import annotations

import base64
import html
from pathlib import Path

import numpy as np

from stereo_lab import plots
from stereo_lab.calibration import StereoCalibration, depth_map, where_to_hold
from stereo_lab.common.files import write_whole
from stereo_lab.errors import CalibrationError
from stereo_lab.localization.doubt import FAR_OFF, far_off
from stereo_lab.localization.localizer import MOST_UNLIKE, first_of, where_to_look
from stereo_lab.recording import Recording
from stereo_lab.recording.strays import strays
from stereo_lab.results.evaluation import Results
from stereo_lab.results.figures import FIGURES

CORNERS_NAMED = 3
JUDGED = "This recording has no evaluation set: its check samples, kept out of the fit, are the judges."
UNJUDGED = (
    "This recording has no evaluation set, and no sample to check on is left: nothing judges the places. Write check in the column use "
    "of measured.csv for every second line, or leave it empty."
)
PAPER_DEPTH_MM = 8.0  # the paper's Fig. 9: mean depth error, up to 2 m


def rows(results: Results) -> list[tuple[str, str, str, str]]:
    """The table "paper | paper's method here | ours": list of (what, paper, theirs, ours)."""
    facts = results.facts()
    rms = facts["calibration"]["rms_px"]
    table = [] if rms is None else [("stereo reprojection error, RMS (px)", "", "", f"{rms:.3f}")]
    if facts["detection"]:
        share = {m: f"{100 * d['hits'] / d['frames']:.1f} %" for m, d in facts["detection"].items()}
        frames = facts["detection"]["cone"]["frames"]
        table.append((f"ball found, {frames} snaps", "99.2 %", share["paper"], share["cone"]))
    if facts["clutter"]:
        share = {m: f"{100 * d['right'] / d['frames']:.0f} %" for m, d in facts["clutter"].items()}
        table.append(
            (f"right answer in clutter, {facts['clutter']['cone']['frames']} frames", "", share["paper"], share["cone"])
        )
    if facts["center_px"]:
        mean = {m: f"{c['mean']:.2f}" for m, c in facts["center_px"].items()}
        table.append(("ball's centre, mean error (px)", "", mean.get("paper", ""), mean.get("cone", "")))
    return table + _evaluation_rows(facts)


def _evaluation_rows(facts):
    table = []
    for use, where in (("plane", "in the arm's plane"), ("volume", "in the whole volume")):
        both = {m: (facts["evaluation"] or {}).get(m, {}).get(use) for m in ("paper", "cone")}
        if not any(both.values()):
            continue
        paper = {
            "x_mm": "±10" if use == "plane" else "",
            "y_mm": "±10" if use == "plane" else "",
            "depth_mm": "8" if use == "volume" else "",
        }
        for axis, name in (("x_mm", "x"), ("y_mm", "y"), ("depth_mm", "depth")):
            cells = [f"{f[axis]['mean']:.1f} ({f[axis]['p95']:.1f})" if f else "" for f in both.values()]
            table.append((f"{name} {where}, mean (95 %) error (mm)", paper[axis], *cells))
    if facts["limit_depth_mm"] is not None:
        table.append(("depth error by the pictures' noise alone, mean (mm)", "", "", f"{facts['limit_depth_mm']:.1f}"))
    return table


def warnings(results: Results) -> list[str]:
    """What keeps the places from being believed, in plain sentences; none where most of them may be.

    That a recording has no measured balls is none, unless they are there under a name that is not read.
    """
    if "cone" in results.failed:
        return [results.failed["cone"]] if strays(results.recording.path) else []
    ours, judged = results.localizers.get("cone"), results.found.get("cone", [])
    missed, unlike = [sample for sample, place in judged if place is None], _far_off(judged)
    said = ours.doubts if ours is not None and ours.misleads else []
    if max(len(missed), len(unlike)) > MOST_UNLIKE * len(judged):
        said = [*said, *_missed_told(missed, judged), *_far_off_told(unlike, judged)]
    return said


def page(results: Results) -> str:
    """The table as text, and what it says in words; what keeps it from being believed stands before it."""
    table = [("", "paper", "its method here", "ours"), *rows(results)]
    widths = [max(len(row[k]) for row in table) for k in range(4)]
    lines = [
        "  ".join([row[0].ljust(widths[0])] + [c.rjust(w) for c, w in zip(row[1:], widths[1:], strict=True)])
        for row in table
    ]
    lines.insert(1, "-" * len(lines[0]))
    first = warnings(results)
    return "\n".join([*first, *([""] if first else []), *lines, "", *(s for s in sentences(results) if s not in first)])


def sentences(results: Results) -> list[str]:
    """What the numbers mean, plainly."""
    facts = results.facts()
    said = [f"Calibration: {facts['calibration']['verdict']}. {facts['calibration']['reasons'][0]}"]
    said += [sentence for localizer in results.localizers.values() for sentence in localizer.told]
    if "cone" in results.failed:
        said.append(results.failed["cone"])
    if "paper" in results.failed:
        said.append(f"The paper's way cannot be fitted on this recording. {results.failed['paper']}")
    volume = {m: ((facts["evaluation"] or {}).get(m) or {}).get("volume") for m in ("paper", "cone")}
    if volume["paper"] and volume["cone"]:
        theirs, ours = volume["paper"]["depth_mm"]["mean"], volume["cone"]["depth_mm"]["mean"]
        said.append(
            f"Depth: the paper tells of {PAPER_DEPTH_MM:.0f} mm on average; its method gives {theirs:.1f} mm here, "
            f"and fitting a cone and triangulating gives {ours:.1f} mm."
        )
    unlike = _far_off(results.found.get("cone", []))
    if results.limit is not None and facts["reached_over_limit"] is not None and not unlike:
        said.append(
            f"The noise of the pictures (from the set {results.limit.source}) moves a disparity by {facts['sigma_d_px']:.3f} px: "
            f"that alone would leave {facts['limit_depth_mm']:.2f} mm of depth. What is reached is "
            f"{facts['reached_over_limit']:.1f} times that; ball, cameras and ruler make the rest."
        )
    if results.bare:
        said.append(
            f"{len(results.bare)} of {len(results.found['cone'])} balls stand where a camera saw no board; what is known of its lens "
            f"there is drawn out from elsewhere: {first_of(results.bare)}."
        )
    if results.found and not results.recording.has_samples("evaluation"):
        said.append(JUDGED if any(results.found.values()) else UNJUDGED)
    if results.recording.arm_is_shipped:
        said.append("This recording names no arm, so the shipped bench's arm stands in.")
    return said + _doubts(results, unlike)


def _doubts(results, unlike):
    """What speaks against the recording itself: balls that were not found, places that neither cameras nor ruler explain."""
    said = []
    if "cone" in results.localizers:
        said += results.localizers["cone"].doubts
    if "paper" in results.localizers and (told := results.localizers["paper"].stand_ins_told):
        said.append(told)
    lost = [s.pair.full_name for s, place in results.found.get("paper", []) if place is None]
    if lost:
        said.append(
            f"In {len(lost)} of {len(results.found['paper'])} pairs that judge the paper's way finds no ball; its numbers are of the others: "
            f"{first_of(lost)}."
        )
    judged = results.found.get("cone", [])
    said += _missed_told([s for s, place in judged if place is None], judged) + _far_off_told(unlike, judged)
    return [*said, where_to_look(results.recording)] if said else []


def _missed_told(missed, judged):
    names = first_of([sample.pair.full_name for sample in missed])
    says = f"In {len(missed)} of {len(judged)} pairs that judge the two cameras show no ball in one place: {names}."
    return [says] if missed else []


def _far_off_told(unlike, judged):
    if not unlike:
        return []
    verb = "is" if len(unlike) == 1 else "are"
    return [
        f"{len(unlike)} of {len(judged)} places {verb} off by more than {FAR_OFF:.0f} times what cameras and ruler leave in "
        f"doubt, the worst by {max(unlike.values()):.0f} times: {first_of(list(unlike))}."
    ]


def _far_off(found):
    """Places that neither cameras nor ruler explain: name -> how many standard deviations off, the worst first."""
    placed = [(sample, place) for sample, place in found if place is not None]
    off = [place.minus(sample.reference) for sample, place in placed]
    return far_off([s.pair.full_name for s, _ in placed], off, [place.sigma_mm for _, place in placed])


def write(results: Results, path: str | Path) -> None:
    """Write the report: one HTML file with the paper's figures 2, 4, 5, 8 and 9 drawn from this run."""
    sections = [section(figure.draw(results), figure.caption) for figure in FIGURES if figure.fits(results)]
    cells = "".join("<tr>" + "".join(f"<td>{html.escape(c)}</td>" for c in row) + "</tr>" for row in rows(results))
    first = warnings(results)
    before, words = (
        "".join(f"<p>{html.escape(s)}</p>" for s in some)
        for some in (first, [s for s in sentences(results) if s not in first])
    )
    body = DEMO.format(
        kind=kind_of(results.recording), before=before, rows=cells, words=words, figures="".join(sections)
    )
    write_whole(path, PAGE.format(title=html.escape(results.recording.title), body=body))


PAGE = """<!doctype html><html lang="en"><meta charset="utf-8"><title>stereo_lab: {title}</title>
<style>body{{font:17px/1.5 sans-serif;max-width:1100px;margin:2em auto;padding:0 1em;color:#111}}
table{{border-collapse:collapse}}td,th{{padding:.25em .8em;border-bottom:1px solid #ccc;text-align:right}}
td:first-child,th:first-child{{text-align:left}}img{{max-width:100%}}figure{{margin:2em 0}}</style>
<h1>{title}</h1>{body}</html>
"""
DEMO = """<p>This is a {kind}.</p>{before}
<table><tr><th></th><th>paper</th><th>its method here</th><th>ours</th></tr>{rows}</table>{words}{figures}
"""


def calibration_lines(calibration: StereoCalibration) -> list[str]:
    """A calibration in plain words, a line each."""
    if np.isnan(calibration.rms_px):
        size = f"baseline            {calibration.baseline_mm:.2f} mm, focal length {calibration.focal_px:.1f} px (rectified)"
        return [size, "", f"verdict: {calibration.verdict}", *(f"  {reason}" for reason in calibration.reasons)]
    lines = [f"{len(calibration.used)} of {calibration.pairs} pairs used; boards found in {calibration.found}."]
    lines += [f"  without {name}: {why}" for name, why in calibration.dropped]
    lines += [
        f"  without one corner of {name}, {side} picture, at ({u:.0f}, {v:.0f}): it is {off:.{1 if off >= 1 else 2}f} px off"
        for name, side, u, v, off in calibration.corners_left_out[:CORNERS_NAMED]
    ]
    if len(calibration.corners_left_out) > CORNERS_NAMED:
        *_, least = calibration.corners_left_out[-1]
        lines.append(
            f"  and without {len(calibration.corners_left_out) - CORNERS_NAMED} corners more, off by {least:.2f} px or more: farther than "
            "the scatter of the others explains"
        )
    lines += [
        f"reprojection error  {calibration.rms_px:.3f} px "
        f"(left {calibration.left_rms_px:.3f}, right {calibration.right_rms_px:.3f})",
        f"rows after rectification match to {calibration.vertical_error_px:.3f} px",
    ]
    if calibration.heldout_vertical_error_px is not None:
        lines.append(
            f"on unseen pairs     {calibration.heldout_vertical_error_px:.3f} px, "
            f"lengths off by {calibration.heldout_length_error_percent:.2f} %"
        )
    places = where_to_hold(calibration)
    return [
        *lines,
        f"baseline            {calibration.baseline_mm:.2f} mm, focal length {calibration.focal_px:.1f} px (rectified), "
        f"known to {calibration.focal_sigma_percent:.2f} %",
        f"the board is bent by {calibration.board_bend_mm:.2f} mm; "
        f"the boards differ {calibration.misfit:.1f} times as much as their corners explain",
        "",
        f"verdict: {calibration.verdict}",
        *(f"  {reason}" for reason in calibration.reasons),
        *([f"  The next boards help most here in the left picture: {', '.join(places)}."] if places else []),
    ]


def kind_of(recording: Recording) -> str:
    """What made a recording, in words."""
    return "rendered recording: made by a renderer, not by cameras" if recording.rendered else "camera recording"


def write_calibration(calibration: StereoCalibration, recording: Recording, path: str | Path) -> None:
    """Write one HTML file with what a calibration is worth, in words and as the map of its doubt."""
    if calibration.covariance is None:
        raise CalibrationError(
            "This calibration does not say how well it knows its cameras, so there is nothing to draw."
        )
    known = depth_map(calibration)
    fig, axes = plots.figure(1, 1, height=6.0, width=9.0)
    what = f"Uncertainty of depth by the calibration, {calibration.depth_mm / 1000:.1f} m away"
    outlines = calibration.outlines[:, 0]
    plots.depth_doubt(known.pixels, known.sigma_mm, known.boards, outlines, calibration.image_size, what, axes[0, 0])
    caption = (
        "The left picture's area, as far as the right camera sees it too. The shade is the standard deviation of depth; white "
        "outlines are the boards; dots stand where no board was seen."
    )
    lines = [f"This is a {kind_of(recording)}.", *filter(None, calibration_lines(calibration))]
    words = "".join(f"<p>{html.escape(line)}</p>" for line in lines)
    write_whole(path, PAGE.format(title=html.escape(recording.title), body=words + section(fig, caption)))


def section(fig: plots.Figure, caption: str) -> str:
    """A figure with its caption, as a piece of a page; the figure is closed."""
    picture = base64.b64encode(plots.png(fig)).decode()
    text = html.escape(caption)
    return f'<figure><img alt="{text}" src="data:image/png;base64,{picture}"><figcaption>{text}</figcaption></figure>'

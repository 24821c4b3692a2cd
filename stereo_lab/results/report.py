"""The page that ``stereo-lab demo`` prints, and its picture report in one file."""

from __future__ import annotations

import base64
import html
from pathlib import Path

from stereo_lab import plots
from stereo_lab.common.files import write_whole
from stereo_lab.results.evaluation import Results
from stereo_lab.results.figures import FIGURES

PAPER_DEPTH_MM = 8.0  # the paper's Fig. 9: mean depth error, up to 2 m


def rows(results: Results) -> list[tuple[str, str, str, str]]:
    """The table "paper | paper's method here | ours": list of (what, paper, theirs, ours)."""
    facts = results.facts()
    table = [("stereo reprojection error, RMS (px)", "", "", f"{facts['calibration']['rms_px']:.3f}")]
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
        table.append(("depth limit of this rig, mean (mm)", "", "", f"{facts['limit_depth_mm']:.1f}"))
    return table


def page(results: Results) -> str:
    """The table as text, and what it says in words."""
    table = [("", "paper", "its method here", "ours"), *rows(results)]
    widths = [max(len(row[k]) for row in table) for k in range(4)]
    lines = [
        "  ".join([row[0].ljust(widths[0])] + [c.rjust(w) for c, w in zip(row[1:], widths[1:], strict=True)])
        for row in table
    ]
    lines.insert(1, "-" * len(lines[0]))
    return "\n".join([*lines, "", *sentences(results)])


def sentences(results: Results) -> list[str]:
    """What the numbers mean, plainly."""
    facts = results.facts()
    said = [f"Calibration: {facts['calibration']['verdict']}. {facts['calibration']['reasons'][0]}"]
    if results.failed:
        said.append(f"The paper's way cannot be fitted on this recording. {results.failed['paper']}")
    volume = {m: ((facts["evaluation"] or {}).get(m) or {}).get("volume") for m in ("paper", "cone")}
    if volume["paper"] and volume["cone"]:
        theirs, ours = volume["paper"]["depth_mm"]["mean"], volume["cone"]["depth_mm"]["mean"]
        said.append(
            f"Depth: the paper tells of {PAPER_DEPTH_MM:.0f} mm on average; its method gives {theirs:.1f} mm here, "
            f"and fitting a cone and triangulating gives {ours:.1f} mm."
        )
        if facts["evaluation"]["cone"]["missed"]:
            said.append(f"In {facts['evaluation']['cone']['missed']} pairs no ball was found.")
    if results.found and not results.recording.has_samples("evaluation"):
        said.append("This recording has no evaluation set: its check samples, kept out of the fit, are the judges.")
    if results.recording.arm_is_shipped:
        said.append("This recording names no arm, so the shipped bench's arm stands in.")
    return said


def write(results: Results, path: str | Path) -> None:
    """Write the report: one HTML file with the paper's figures 2, 4, 5, 8 and 9 drawn from this run."""
    sections = [_section(figure.draw(results), figure.caption) for figure in FIGURES if figure.fits(results)]
    kind = (
        "a rendered recording: made by a renderer, not by cameras"
        if results.recording.rendered
        else "a camera recording"
    )
    cells = "".join("<tr>" + "".join(f"<td>{html.escape(c)}</td>" for c in row) + "</tr>" for row in rows(results))
    words = "".join(f"<p>{html.escape(s)}</p>" for s in sentences(results))
    write_whole(
        path,
        TEMPLATE.format(
            title=html.escape(results.recording.title), kind=kind, rows=cells, words=words, figures="".join(sections)
        ),
    )


TEMPLATE = """<!doctype html><html lang="en"><meta charset="utf-8"><title>stereo_lab: {title}</title>
<style>body{{font:17px/1.5 sans-serif;max-width:1100px;margin:2em auto;padding:0 1em;color:#111}}
table{{border-collapse:collapse}}td,th{{padding:.25em .8em;border-bottom:1px solid #ccc;text-align:right}}
td:first-child,th:first-child{{text-align:left}}img{{max-width:100%}}figure{{margin:2em 0}}</style>
<h1>{title}</h1><p>This is {kind}.</p>
<table><tr><th></th><th>paper</th><th>its method here</th><th>ours</th></tr>{rows}</table>{words}{figures}</html>
"""


def _section(fig, caption):
    picture = base64.b64encode(plots.png(fig)).decode()
    text = html.escape(caption)
    return f'<figure><img alt="{text}" src="data:image/png;base64,{picture}"><figcaption>{text}</figcaption></figure>'

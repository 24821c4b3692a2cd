"""The page that ``stereo-lab demo`` prints, and its picture report in one file."""

from __future__ import annotations

import base64
import html
import io

import matplotlib

matplotlib.use("Agg", force=False)

import cv2  # noqa: E402
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402

from stereo_lab import plots  # noqa: E402
from stereo_lab.common.files import write_whole  # noqa: E402

PAPER_DEPTH_MM = 8.0  # the paper's Fig. 9: mean depth error, up to 2 m
PAPER_PLANE_MM = 10.0  # the paper's Fig. 8: x and y within ±1 cm


def rows(results):
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
        if not all(both.values()):
            continue
        paper = {
            "x_mm": "±10" if use == "plane" else "",
            "y_mm": "±10" if use == "plane" else "",
            "depth_mm": "8" if use == "volume" else "",
        }
        for axis, name in (("x_mm", "x"), ("y_mm", "y"), ("depth_mm", "depth")):
            cells = [f"{both[m][axis]['mean']:.1f} ({both[m][axis]['p95']:.1f})" for m in ("paper", "cone")]
            table.append((f"{name} {where}, mean (95 %) error (mm)", paper[axis], *cells))
    if facts["limit_depth_mm"] is not None:
        table.append(("depth limit of this rig, mean (mm)", "", "", f"{facts['limit_depth_mm']:.1f}"))
    return table


def page(results):
    """The table as text, and what it says in words."""
    table = [("", "paper", "its method here", "ours"), *rows(results)]
    widths = [max(len(row[k]) for row in table) for k in range(4)]
    lines = [
        "  ".join([row[0].ljust(widths[0])] + [c.rjust(w) for c, w in zip(row[1:], widths[1:], strict=True)])
        for row in table
    ]
    lines.insert(1, "-" * len(lines[0]))
    return "\n".join([*lines, "", *sentences(results)])


def sentences(results):
    """What the numbers mean, plainly."""
    facts = results.facts()
    said = [f"Calibration: {facts['calibration']['verdict']}. {facts['calibration']['reasons'][0]}"]
    volume = {m: ((facts["evaluation"] or {}).get(m) or {}).get("volume") for m in ("paper", "cone")}
    if volume["paper"] and volume["cone"]:
        theirs, ours = volume["paper"]["depth_mm"]["mean"], volume["cone"]["depth_mm"]["mean"]
        said.append(
            f"Depth: the paper tells of {PAPER_DEPTH_MM:.0f} mm on average; its method gives {theirs:.1f} mm here, "
            f"and fitting a cone and triangulating gives {ours:.1f} mm."
        )
        if facts["evaluation"]["cone"]["missed"]:
            said.append(f"In {facts['evaluation']['cone']['missed']} pairs no ball was found.")
    if results.recording.arm_is_shipped:
        said.append("This recording names no arm, so the shipped bench's arm stands in.")
    return said


# --- pictures --------------------------------------------------------------------------------------------


def write(results, path):
    """Write the report: one HTML file with the paper's figures 2, 4, 5, 8 and 9 drawn from this run."""
    sections = [_section(draw(results), caption) for draw, caption in FIGURES if _can(draw, results)]
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
    data = io.BytesIO()
    fig.savefig(data, format="png")
    plt.close(fig)
    picture = base64.b64encode(data.getvalue()).decode()
    text = html.escape(caption)
    return f'<figure><img alt="{text}" src="data:image/png;base64,{picture}"><figcaption>{text}</figcaption></figure>'


def _can(draw, results):
    sets = set(results.recording.sets)
    return NEEDS[draw] <= sets and (draw is draw_epipolar or bool(results.localizers))


def draw_epipolar(results):
    """Fig. 2: rows before and after rectification."""
    pair = next(p for p in results.recording.pairs("calibration") if p.name in results.calibration.used)
    raw = (pair.left, pair.right)
    rows_px = np.linspace(0.1, 0.9, 7) * raw[0].shape[0]
    fig, axes = plots.figure(2, 1, height=8.4)
    plots.side_by_side(*raw, rows_px, "Raw: the same corner lies on different rows", axes[0, 0])
    plots.side_by_side(*results.calibration.rectify(*raw), rows_px, "Rectified: every corner keeps its row", axes[1, 0])
    return fig


def draw_detection(results):
    """Fig. 4: from the picture to the circle."""
    from stereo_lab.detection import BLUR_PX, BallColor, detect_paper

    image = results.recording.samples("position")[0].pair.left
    color = BallColor.named(results.recording.ball.color)
    mask = color.mask(image)
    found = detect_paper(image, color)
    cone = results.localizers["cone"].detectors[0].detect(image)
    fig, axes = plots.figure(1, 3, height=3.6, width=12)
    plots.show_image(cv2.cvtColor(mask, cv2.COLOR_GRAY2BGR), "In the colour range", axes[0, 0])
    blurred = cv2.GaussianBlur(mask, (BLUR_PX, BLUR_PX), 0)
    plots.show_image(cv2.cvtColor(blurred, cv2.COLOR_GRAY2BGR), "Blurred", axes[0, 1])
    plots.show_image(image, "Hough circle (dark), cone (light)", axes[0, 2])
    for detection, shade in ((found, plots.BLACK), (cone, plots.ORANGE)):
        if detection is not None:
            plots.mark_ball(detection.u, detection.v, detection.radius_px, axes[0, 2], shade)
    return fig


def draw_lines(results):
    """Fig. 5: the two straight lines of Eq. 1 and 2."""
    localizer = results.localizers["paper"]
    seen = {"fit": [], "check": []}
    for sample in results.recording.samples("position"):
        pair = localizer.detect(sample.pair.left, sample.pair.right)
        if pair is not None and sample.use in seen:
            seen[sample.use].append((pair[0].u, pair[0].v, sample.measured.x_mm, sample.measured.y_mm))
    fit, check = (np.array(seen[k] or [[np.nan] * 4]) for k in ("fit", "check"))
    fig, axes = plots.figure(1, 2, height=4.6)
    for k, (pixel, length) in enumerate((("u (px, rectified)", "x (mm)"), ("v (px, rectified)", "y (mm)"))):
        title = f"{length[0]} is a straight line in {pixel[0]}"
        plots.line_fit(
            fit[:, k],
            fit[:, 2 + k],
            check[:, k],
            check[:, 2 + k],
            localizer.models[k],
            (pixel, length),
            title,
            axes[0, k],
        )
    return fig


def draw_scatter(results):
    """Fig. 8: errors in the arm's plane."""
    fig, axes = plots.figure(1, 2, height=5.2)
    for k, (method, name) in enumerate((("paper", "Two lines"), ("cone", "Rigid fit"))):
        errors, _ = results.errors(method, "plane")
        inside = (np.abs(errors[:, :2]) <= PAPER_PLANE_MM).all(1).sum()
        title = f"{name}: {inside} of {len(errors)} within ±1 cm"
        plots.scatter_errors(
            errors[:, 0],
            errors[:, 1],
            PAPER_PLANE_MM,
            title,
            axes[0, k],
            (plots.VERMILION, plots.BLUE)[k],
            "s" if k == 0 else "o",
        )
    return fig


def draw_histogram(results):
    """Fig. 9: how large the depth error is, up to the far end of the volume."""
    fig, axes = plots.figure(1, 2, height=4.4)
    for k, (method, name) in enumerate((("paper", "Eq. 4"), ("cone", "Cone and triangulation"))):
        errors, _ = results.errors(method, "volume")
        title = f"{name}: {np.abs(errors[:, 2]).mean():.1f} mm on average"
        plots.histogram_errors(errors[:, 2], title, axes[0, k], (plots.VERMILION, plots.BLUE)[k], ("//", "")[k])
    return fig


FIGURES = (
    (
        draw_epipolar,
        "The paper's Fig. 2: a pair of the board with level lines. Raw, a corner sits on another row in each camera; rectified, on the same.",
    ),
    (
        draw_detection,
        "The paper's Fig. 4: pixels in the colour range are white; blurred; and the circles found in the picture.",
    ),
    (
        draw_lines,
        "The paper's Fig. 5: measured x against pixel column and y against pixel row, four samples to fit and four to check.",
    ),
    (draw_scatter, "The paper's Fig. 8: errors in x and y in the plane of the arm; the dashed box is ±1 cm."),
    (draw_histogram, "The paper's Fig. 9: how many pairs have which depth error; the dashed line is the mean."),
)
NEEDS = {
    draw_epipolar: {"calibration"},
    draw_detection: {"position"},
    draw_lines: {"position", "evaluation"},
    draw_scatter: {"evaluation"},
    draw_histogram: {"evaluation"},
}

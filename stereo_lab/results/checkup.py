"""What the doctor found, for the terminal and as one HTML file."""

from __future__ import annotations

import html
import textwrap
from pathlib import Path

import numpy as np

from stereo_lab import plots
from stereo_lab.common.files import write_whole
from stereo_lab.doctor import Checkup, Finding
from stereo_lab.errors import StereoLabError
from stereo_lab.recording import Recording
from stereo_lab.results.report import PAGE, kind_of, section

WIDE = 100  # letters in a line of the terminal
FILES_NAMED = 6
TOO_LITTLE_MM = 0.05  # to be worth a number
WORDS = {"stops": "stops everything", "costs": "costs accuracy", "note": "a note, it matters little"}


def lines(checkup: Checkup) -> list[str]:
    """The findings in plain words, the weightiest first, and the verdict."""
    told: list[str] = []
    for number, finding in enumerate(checkup.findings, 1):
        told.append(_heading(number, finding, checkup))
        told += _wrapped(finding.says) + _wrapped(f"Try: {finding.advice}")
        if finding.files:
            told += _wrapped(f"Files: {_files(finding)}")
        told.append("")
    return [*told, f"verdict: {checkup.verdict}", *_wrapped(checkup.says)]


def _wrapped(text):
    return textwrap.wrap(text, WIDE, initial_indent="   ", subsequent_indent="   ")


def _heading(number, finding, checkup):
    """Number, name and weight."""
    title, does = finding.name.replace("_", " ").capitalize(), finding.does_mm
    if does is None or does < TOO_LITTLE_MM:
        return f"{number}. {title}: {WORDS[finding.severity]}"
    size = f"{does:.0f}" if does >= 10 else f"{does:.1f}"
    return f"{number}. {title}: {WORDS[finding.severity]}, up to {size} mm at {checkup.depth_mm / 1000:.1f} m"


def _files(finding):
    """The first few files, and how many more."""
    named = ", ".join(finding.files[:FILES_NAMED])
    more = len(finding.files) - FILES_NAMED
    return f"{named} and {more} more" if more > 0 else named


def write(checkup: Checkup, recording: Recording, path: str | Path) -> None:
    """Write one HTML file: each finding in words, and a figure that shows it."""
    body = [f"<p>This is a {kind_of(recording)}.</p><p><b>{html.escape(checkup.says)}</b></p>"]
    for number, finding in enumerate(checkup.findings, 1):
        heading = _heading(number, finding, checkup)
        words = [finding.says, f"Try: {finding.advice}", f"Files: {_files(finding)}" if finding.files else ""]
        body.append(f"<h2>{html.escape(heading)}</h2>")
        body += [f"<p>{html.escape(text)}</p>" for text in words if text]
        body.append(_figure(finding, recording))
    write_whole(path, PAGE.format(title=html.escape(recording.title), body="".join(body)))


def _figure(finding: Finding, recording: Recording) -> str:
    """How it was seen: numbers by file, where the boards were, or the pictures themselves."""
    evidence = finding.evidence
    if evidence is not None and len(evidence.values) > 1:
        names, values = (list(part) for part in zip(*evidence.values, strict=True))
        fig, axes = plots.figure(1, 1, height=4.0)
        plots.numbers_by_file(names, values, list(evidence.marked), "", evidence.what, axes[0, 0])
        return section(fig, f"For each file: {evidence.what}.")
    if evidence is not None and len(evidence.places):
        fig, axes = plots.figure(1, 1, height=5.0, width=7.0)
        plots.where_boards_were(np.array(evidence.places), evidence.size, evidence.what, axes[0, 0])
        return section(fig, f"{evidence.what}. The frame is the picture.")
    return _pictures(finding, recording)


def _pictures(finding, recording):
    """The first pair concerned, left and right; nothing where it cannot be read."""
    set_name, _, name = (finding.files[0] if finding.files else "calibration/").partition("/")
    try:
        pairs = recording.pairs(set_name)
        pair = next((p for p in pairs if p.name == name.split(" ")[0]), pairs[0])
        images = pair.left, pair.right
    except StereoLabError:
        return ""
    fig, axes = plots.figure(1, 2, height=4.2)
    for ax, image, side in zip(axes[0], images, ("left", "right"), strict=True):
        plots.show_image(image, f"{set_name}/{pair.name}, {side}", ax)
    return section(fig, f"The pair {set_name}/{pair.name}, left and right.")

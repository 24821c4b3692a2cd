"""Pages to print, as PDF: black rectangles, thin lines and words, true to scale."""

from __future__ import annotations

import io
from collections.abc import Iterable
from typing import TYPE_CHECKING

import matplotlib as mpl
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.patches import PathPatch, Rectangle
from matplotlib.path import Path

if TYPE_CHECKING:
    from stereo_lab.capture import Sheet

__all__ = ["sheets_pdf"]

MM_PER_INCH = 25.4
POINTS = 8.0  # of the words


def sheets_pdf(sheets: Iterable[Sheet]) -> bytes:
    """Some sheets as the bytes of one PDF file, a page each; the same bytes again for the same sheets."""
    data = io.BytesIO()
    from matplotlib.backends.backend_pdf import PdfPages  # brings 10 MB of fonts' tools, which no lesson needs

    with mpl.rc_context({"pdf.fonttype": 42}), PdfPages(data, metadata={"CreationDate": None}) as pages:
        for sheet in sheets:
            pages.savefig(_page(sheet))
    return data.getvalue()


def _page(sheet):
    fig = Figure((sheet.wide_mm / MM_PER_INCH, sheet.high_mm / MM_PER_INCH))
    ax = fig.add_axes((0, 0, 1, 1), xlim=(0, sheet.wide_mm), ylim=(0, sheet.high_mm))
    ax.set_axis_off()
    if len(sheet.dark):  # one path, so that no hairline shows between neighbours
        boxes = [Rectangle((x, y), wide, high) for x, y, wide, high in sheet.dark]
        outline = Path.make_compound_path(*(box.get_path().transformed(box.get_patch_transform()) for box in boxes))
        ax.add_patch(PathPatch(outline, facecolor="black", linewidth=0))
    ax.add_collection(LineCollection(sheet.lines.reshape(-1, 2, 2), colors="black", linewidths=0.6))
    for x, y, text in sheet.words:
        ax.text(x, y, text, fontsize=POINTS, va="baseline")
    return fig

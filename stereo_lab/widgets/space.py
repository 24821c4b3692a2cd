"""Things in space, turned by two sliders."""

from __future__ import annotations

from collections.abc import Sequence

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from stereo_lab import plots
from stereo_lab.widgets.panel import PANEL_WIDTH, Panel, slider


def space(things: Sequence[plots.Thing], title: str, turned_deg: int = -60, raised_deg: int = 20) -> Panel:
    """Look at things in space from all sides.

    Parameters
    ----------
    things : sequence of plots.Thing
    title : str
    turned_deg, raised_deg : int, from where one looks first; see ``plots.space``
    """

    def draw(turned_deg, raised_deg):
        with plt.rc_context(plots.STYLE):
            figure = Figure(figsize=(PANEL_WIDTH / 100, 5.2), dpi=100)
            canvas = FigureCanvasAgg(figure)
            ax = figure.add_axes((0.0, 0.07, 0.68, 0.86), projection="3d")
            plots.space(things, title, ax, turned_deg, raised_deg)
            canvas.draw()
        from_where = "the side"
        if raised_deg > 60:
            from_where = "above"
        elif abs(abs(turned_deg) - 90) < 45:
            from_where = "behind the cameras" if turned_deg < 0 else "behind the bench"
        return np.asarray(canvas.buffer_rgba())[..., 2::-1], f"seen from {from_where}"

    return Panel(
        f"space: {title}",
        {
            "turned_deg": slider("turn (degrees)", turned_deg, -180, 180, 5),
            "raised_deg": slider("look from above (°)", raised_deg, 0, 90, 5),
        },
        draw,
    )

"""The glitch of each scheme over feed and radius."""

import numpy as np
from matplotlib.figure import Figure

from fric.figures.style import GREY, VERMILION, new_figure
from fric.figures.views import view
from fric.simulate.over_circles import CircleMap


@view("map", of="CircleMap", usual=True)
def draw_circle_map(found: CircleMap) -> Figure:
    """Return a panel a scheme: its glitch in µm by feed and radius, one scale of colours; a cross where it cannot run.

    Where a scheme with an observer leaves more than without, the cell is framed: there the observer spoils.
    """
    from matplotlib.colors import LogNorm
    from matplotlib.patches import Rectangle

    grid, glitches = found.grid, found.glitches * 1e6
    count = len(grid.schemes)
    columns = 2 if count > 1 else 1
    rows = -(-count // columns)
    known = glitches[np.isfinite(glitches)]
    low, high = (float(known.min()), float(known.max())) if known.size else (1.0, 10.0)
    scale = LogNorm(max(low, 1e-3), max(high, 2 * max(low, 1e-3)))
    spoiled = {
        one.name: found.less(one, other) < 0
        for name, (one, other) in found.pairs().items()
        if name.startswith("observer")
    }
    with new_figure(2.0 + 3.0 * columns, 0.6 + 2.3 * rows) as figure:
        panels = np.atleast_1d(figure.subplots(rows, columns, squeeze=False)).ravel()
        drawn = None
        for panel, scheme, values in zip(panels, grid.schemes, glitches, strict=False):
            drawn = panel.imshow(values, norm=scale, cmap="cividis", origin="lower", aspect="auto")
            for (row, column), value in np.ndenumerate(values):
                dark = np.isfinite(value) and scale(value) < 0.55
                text = f"{value:.3g}" if np.isfinite(value) else "×"
                panel.text(column, row, text, ha="center", va="center", fontsize=6, color="white" if dark else "black")
                if scheme.name in spoiled and spoiled[scheme.name][row, column]:
                    corner = (column - 0.46, row - 0.46)
                    panel.add_patch(Rectangle(corner, 0.92, 0.92, fill=False, linewidth=1.2, color=VERMILION))
            panel.set_xticks(range(len(grid.feeds)), [f"{1e3 * one:.3g}" for one in grid.feeds])
            panel.set_yticks(range(len(grid.radii)), [f"{1e3 * one:.3g}" for one in grid.radii])
            panel.set_title(f"({scheme.name}) {scheme.title}", fontsize=8)
            panel.set(xlabel="feed [mm/s]", ylabel="radius [mm]")
            panel.grid(visible=False)
            panel.tick_params(length=0)
        for panel in panels[count:]:
            panel.set_axis_off()
        if drawn is not None:
            bar = figure.colorbar(drawn, ax=list(panels), shrink=0.9)
            bar.set_label("glitch [µm]")
            bar.ax.yaxis.set_major_formatter("{x:g}")
            bar.ax.yaxis.set_minor_formatter("{x:g}")
            bar.ax.tick_params(which="both", labelsize=7)
        framed = "; framed: the observer leaves more" if any(np.any(one) for one in spoiled.values()) else ""
        figure.suptitle(f"{grid.machine.name}{framed}", fontsize=9, color=GREY)
    return figure

"""What schemes leave of a path: the path with its reversals, and the contour error along it."""

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from fric.figures.style import CYCLE, GREY, VERMILION, new_figure
from fric.figures.views import view
from fric.simulate.path import PathRun


@view("contour", of="PathRun", usual=True)
def path_figure(runs: Sequence[PathRun]) -> Figure:
    """Return the path with the places where an axis reverses, and beside it the contour error of each scheme along it.

    runs: One run per scheme, of one path.
    """
    first = runs[0]
    names = tuple(first.traces)
    apart = 2.2 * max(float(np.ptp(run.contour.error)) for run in runs) * 1e6 / 2
    with new_figure(8.4, 1.6 + 0.75 * len(runs)) as figure:
        plan, along = figure.subplots(1, 2, width_ratios=(1, 2))
        plan.plot(*(1e3 * first.traces[name].reference for name in names), color=GREY)
        for n, reversal in enumerate(first.contour.reversals, 1):
            plan.plot(1e3 * reversal.x, 1e3 * reversal.y, "o", color=VERMILION, markersize=4)
            plan.annotate(
                str(n), (1e3 * reversal.x, 1e3 * reversal.y), textcoords="offset points", xytext=(4, 4), fontsize=7
            )
        plan.set_aspect("equal", adjustable="box")
        plan.set(xlabel=f"{names[0]} [mm]", ylabel=f"{names[1]} [mm]")
        plan.set_title("path; numbers where an axis reverses", fontsize=8)
        ticks = []
        for n, run in enumerate(runs):
            level = -n * apart
            ticks.append(level)
            along.axhline(level, color=GREY, linewidth=0.6)
            along.plot(
                run.contour.station * 1e3, run.contour.error * 1e6 + level, color=CYCLE[n % len(CYCLE)], linewidth=0.9
            )
        along.set_yticks(ticks, [f"({run.scheme.name}) {run.chance().text()} µm" for run in runs])
        along.set(xlabel="distance along the path [mm]", ylabel="contour error [µm]")
        along.set_title(f"contour error, lines {apart:.3g} µm apart; glitch of each scheme", fontsize=8)
    return figure

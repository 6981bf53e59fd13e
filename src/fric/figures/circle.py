"""The circular test drawn as machine tool people draw circularity: the radial error magnified on a polar plot."""

from collections.abc import Sequence
from math import ceil, pi
from typing import cast

import numpy as np
from matplotlib.figure import Figure
from matplotlib.projections.polar import PolarAxes

from fric.contour import QUADRANTS
from fric.figures.style import BLUE, GREY, VERMILION, new_figure
from fric.figures.views import view
from fric.simulate.circle import CircleRun

LINES = 4
"""Grid lines on either side of the nominal circle, which is drawn with a radius of twice as many."""


@view("contour", of="CircleRun", usual=True)
def polar_figure(runs: Sequence[CircleRun]) -> Figure:
    """Return the radial error of each scheme on a polar plot, all at one magnification (Figs. 8 and 9 of the paper).

    The heavy grey circle is the one that was asked for; the grid is in µm, outwards positive; the arrow shows the
    direction of the motion; a number stands at each reversal: its glitch in µm. The magnification is that of the error
    against the circle.

    runs: One run per scheme, of one circle.
    """
    largest = max(float(np.abs(run.circularity.error).max()) for run in runs) * 1e6
    grid = grid_of(largest)
    magnified = runs[0].circle.radius * 1e6 / (2 * LINES * grid)
    columns = 2 if len(runs) == 4 else min(3, len(runs))
    rows = ceil(len(runs) / columns)
    with new_figure(max(2.9 * columns, 3.4), 3.15 * rows + 0.5) as figure:
        for n, run in enumerate(runs, 1):
            _draw(cast(PolarAxes, figure.add_subplot(rows, columns, n, projection="polar")), run, grid)
        test = runs[0].circle
        figure.suptitle(
            f"Radial error of a circle of {test.radius * 1e3:g} mm at {test.feed * 1e3:g} mm/s\n"
            f"grid {grid:g} µm, magnified {magnified:.3g} times",
            fontsize=9,
        )
    return figure


def grid_of(largest: float) -> float:
    """Return a round grid [µm] with two to five lines up to the largest error."""
    step = 10.0 ** np.floor(np.log10(max(largest, 1e-3) / 2))
    return float(next(step * factor for factor in (1, 2, 5, 10) if largest <= 4 * step * factor))


def grid_lines(axes: PolarAxes, grid: float) -> None:
    """Draw the circle that was asked for, and a labelled grid [µm] to either side of it."""
    axes.plot(np.linspace(0, 2 * pi, 361), np.zeros(361), color=GREY, linewidth=1.6, zorder=1.9)
    axes.set_ylim(-2 * LINES * grid, LINES * grid * 1.15)
    labels = ["" if n % 2 else f"{n * grid:+g}" if n else "0" for n in range(-LINES, LINES + 1)]
    axes.set_yticks(grid * np.arange(-LINES, LINES + 1), labels, fontsize=6, color=GREY)
    axes.set_rlabel_position(22.5)
    axes.set_xticks(np.arange(4) * pi / 2, QUADRANTS)
    axes.tick_params(axis="x", pad=-1)
    axes.spines["polar"].set_visible(False)


def direction_arrow(axes: PolarAxes, direction: int, radius: float, colour: str) -> None:
    """Draw an arrow in the direction of the motion: 1 counter-clockwise, -1 clockwise."""
    arc = direction * pi / 15
    axes.annotate(
        "", xy=(1.25 * pi + arc, radius), xytext=(1.25 * pi - arc, radius),
        arrowprops={"arrowstyle": "->", "color": colour, "shrinkA": 0, "shrinkB": 0},
    )  # fmt: skip


def _draw(axes: PolarAxes, run: CircleRun, grid: float) -> None:
    found = run.circularity
    axes.plot(found.angle, found.error * 1e6, color=BLUE, linewidth=1.0)
    grid_lines(axes, grid)
    for quarter, glitch in enumerate(run.glitches):
        axes.text(
            quarter * pi / 2 + 0.2,
            -0.75 * LINES * grid,
            f"{glitch.median * 1e6:+.1f}",
            color=VERMILION,
            fontsize=7,
            ha="center",
            va="center",
        )
    direction_arrow(axes, run.circle.direction, -0.45 * LINES * grid, GREY)
    axes.set_title(f"({run.scheme.name}) {run.scheme.title}\nglitch {run.chance().text()} µm", fontsize=8)

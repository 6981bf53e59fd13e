"""A measured circle as machine tool people draw it, and the error over time at each of its reversals."""

from math import pi
from typing import cast

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.projections.polar import PolarAxes

from fric.circles.agreement import Agreement
from fric.circles.diagnose import Diagnosis
from fric.circles.glitches import smoothed
from fric.figures.circle import LINES, direction_arrow, grid_lines, grid_of
from fric.figures.style import BLUE, GREEN, GREY, ORANGE, VERMILION, feed_of, new_figure, view

COLOURS = {1: BLUE, -1: GREEN}  # Colour of each direction
PARTS = 1440  # Parts of a turn that are drawn


@view("diagnosis", of="Diagnosis", usual=True)
def draw_diagnosis(found: Diagnosis, agreement: Agreement | None = None) -> Figure:
    """Return the radial deviation of a measured circle on a polar plot, and over time at each reversal.

    On the polar plot the mean of the revolutions, a colour for each direction, and as a thin line the part that
    geometry and pitch explain. Beside it the deviation around each reversal less that part: the glitch, with the
    prediction, if any.

    agreement: What was predicted of it.
    """
    test = found.test
    with new_figure(9.4, 4.6) as figure:
        spec = figure.add_gridspec(2, 4)
        polar = cast(PolarAxes, figure.add_subplot(spec[:, :2], projection="polar"))
        grid = _polar(polar, found)
        magnified = test.radius * 1e6 / (2 * LINES * grid)
        places = {"+x": (0, 2), "+y": (0, 3), "-x": (1, 2), "-y": (1, 3)}
        shared = None
        for name, (row, column) in places.items():
            axes = figure.add_subplot(spec[row, column], sharey=shared)
            shared = shared or axes
            _reversal(axes, found, agreement, name)
            if column == 2:
                axes.set_ylabel("glitch [µm]")
            if row == 1:
                axes.set_xlabel("time after the reversal [ms]")
        shown: dict[str, Artist] = {}
        for panel in figure.get_axes()[:2]:
            shown |= {str(label): handle for handle, label in zip(*panel.get_legend_handles_labels(), strict=True)}
        figure.legend(list(shown.values()), list(shown), loc="outside lower right", ncols=4)
        revolutions = " and ".join(str(test.count) for test in found.tests)
        figure.suptitle(
            f"Circle of {feed_of(test)}, mean of {revolutions} revolutions: "
            f"G {max(found.figures.G.values()) * 1e6:.2f} µm; grid {grid:g} µm, magnified {magnified:.3g} times",
            fontsize=9,
        )
    return figure


def _polar(axes: PolarAxes, found: Diagnosis) -> float:
    curves = []
    for n, test in enumerate(found.tests):
        angle, mean, _ = test.averaged(min(PARTS, len(test.angle) // test.count))
        there = np.isfinite(mean)
        angle, mean = angle[there], mean[there]
        # the centre depends on the set-up of the test: it is reported, and not drawn
        shift = [float(found.geometry[f"centre.{name}"]) for name in test.test.names]
        mean = mean - shift[0] * np.cos(angle) - shift[1] * np.sin(angle)
        order = np.argsort(test.angle % (2 * pi))
        every = order[:: max(len(order) // PARTS, 1)]
        theta = test.angle[every] % (2 * pi)
        model = found.model[n][every] - shift[0] * np.cos(theta) - shift[1] * np.sin(theta)
        curves.append((test.test.direction, angle, mean, theta, model))
    grid = grid_of(max(float(np.abs(curve[2]).max()) for curve in curves) * 1e6)
    grid_lines(axes, grid)
    for direction, angle, mean, theta, model in curves:
        axes.plot(theta, model * 1e6, color=ORANGE, linewidth=0.9, zorder=3, label="geometry and pitch")
        axes.plot(np.append(angle, angle[0]), np.append(mean, mean[0]) * 1e6, color=COLOURS[direction], linewidth=1.0)
        direction_arrow(axes, direction, -(0.45 if direction > 0 else 0.7) * LINES * grid, COLOURS[direction])
    axes.set_title("radial deviation [µm] around its centre", fontsize=8)
    return grid


def _reversal(axes: Axes, found: Diagnosis, agreement: Agreement | None, name: str) -> None:
    for n, circle in enumerate(found.tests):
        test = circle.test
        pulse = found.pulses(n)[name]
        phi, mean = smoothed(pulse, np.radians(0.4))
        near = np.abs(phi) <= np.radians(25)
        sense = "counter-clockwise" if test.direction > 0 else "clockwise"
        scale = 1e3 * test.radius / test.feed
        wide = 2.8 if n == 0 and len(found.tests) > 1 else 1.2  # where both coincide, the line beneath remains visible
        axes.plot(phi[near] * scale, mean[near] * 1e6, color=COLOURS[test.direction], label=sense, linewidth=wide)
        if n == 0:
            glitch = found.glitches[name]
            axes.plot(glitch.place / test.feed * 1e3, glitch.value * 1e6, "o", color=VERMILION, markersize=3.5)
            axes.set_title(f"{name}: {glitch.value * 1e6:+.2f} µm", fontsize=8)
    if agreement is not None:
        test = agreement.predicted.test
        phi, mean = smoothed(agreement.predicted.pulses()[name], np.radians(0.4))
        near = np.abs(phi) <= np.radians(25)
        axes.plot(
            phi[near] * 1e3 * test.radius / test.feed, mean[near] * 1e6, color=VERMILION, linestyle="--",
            label=f"predicted, scheme ({agreement.scheme})",
        )  # fmt: skip
    axes.axvline(0, color=GREY, linewidth=0.6)

"""A measured circle as machine tool people draw it, the error at its reversals, and what tuning makes of it."""

from math import pi
from typing import cast

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.projections.polar import PolarAxes
from matplotlib.ticker import LogLocator

from fric.circles.diagnose import Agreement, Diagnosis
from fric.circles.learn import Learned
from fric.circles.tune_fit import TunedAxis
from fric.figures.circle import LINES, direction_arrow, grid_lines, grid_of
from fric.figures.style import BLUE, GREEN, GREY, ORANGE, VERMILION, feed_of, new_figure, view

COLOURS = {1: BLUE, -1: GREEN}  # Colour of each direction
PARTS = 1440  # Parts of a turn that are drawn
AROUND = np.radians(25.0)  # Half of what is shown around a reversal, as an angle on the circle [rad]


@view("diagnosis", of="Diagnosis", usual=True)
def draw_diagnosis(found: Diagnosis, agreement: Agreement | None = None) -> Figure:
    """Return the radial deviation of a measured circle on a polar plot, and over time at each reversal.

    On the polar plot the mean of the revolutions, a colour for each direction, and as a thin line the part that
    geometry and pitch explain. Beside it the deviation around each reversal less that part: the glitch, with the
    prediction, if any.
    """
    test = found.test
    with new_figure(9.4, 4.6) as figure:
        spec = figure.add_gridspec(2, 4)
        grid = _polar(cast(PolarAxes, figure.add_subplot(spec[:, :2], projection="polar")), found)
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
            f"G {max(found.figures.G.values()) * 1e6:.2f} µm; lines {grid:g} µm apart, magnified {magnified:.3g} times",
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
        phi, mean = found.pulses(n)[name].smoothed(np.radians(0.4))
        near = np.abs(phi) <= np.radians(25)
        sense = "counter-clockwise" if test.direction > 0 else "clockwise"
        scale = 1e3 * test.radius / test.feed
        wide = 2.8 if n == 0 and len(found.tests) > 1 else 1.2  # where both coincide, the line beneath remains visible
        axes.plot(phi[near] * scale, mean[near] * 1e6, color=COLOURS[test.direction], label=sense, linewidth=wide)
        if n == 0:
            glitch = found.glitches[name]
            axes.plot(glitch.place / test.feed * 1e3, glitch.value * 1e6, "o", color=VERMILION, markersize=3.5)
            axes.set_title(f"{name}: {glitch.value * 1e6:+.2f} µm".replace("-", "−"), fontsize=8)
    if agreement is not None and name in agreement.agrees:  # what has no model is not predicted
        test = agreement.predicted.test
        phi, mean = agreement.predicted.pulses()[name].smoothed(np.radians(0.4))
        near = np.abs(phi) <= np.radians(25)
        axes.plot(
            phi[near] * 1e3 * test.radius / test.feed, mean[near] * 1e6, color=VERMILION, linestyle="--",
            label=f"predicted, scheme ({agreement.scheme})",
        )  # fmt: skip
    axes.axvline(0, color=GREY, linewidth=0.6)


@view("voltage", of="TunedAxis", usual=True)
def draw_tuned(axis: TunedAxis) -> Figure:
    """Return the control voltage around the reversals of an axis, measured and replayed: before tuning and after.

    Above for each circle the voltage as it acts, less what inertia and the drive's damping need by the plant that was
    found: the voltage for friction. Below the residual with nominal and tuned parameters.
    """
    circles = len(axis.after.balance.records)
    with new_figure(2.4 + 2.6 * circles, 4.6) as figure:
        panels = figure.subplots(2, circles, squeeze=False, sharex="col", height_ratios=(1.4, 1))
        for n, (above, below) in enumerate(panels.T):
            record = axis.after.balance.records[n]
            place, scale = _voltage_after(axis, n), 1e3 * record.test.radius / record.test.feed
            angle = record.angle[record.used]
            near = np.abs(angle - place) <= AROUND
            t = (angle[near] - place) * (1.0 if angle[-1] >= angle[0] else -1.0) * scale
            m, a, offset = axis.after.plant[0], axis.after.plant[1], axis.after.plant[2 + n]
            rest = -m * record.inertia[record.used] - a * record.damping[record.used] - offset
            measured = record.delayed(axis.after.balance.coordinates.delay(axis.after.x)) + rest
            after, before = axis.after.parts()[n], axis.before.parts()[n]
            above.plot(t, measured[near], color=GREY, linewidth=2.4, label="measured")
            above.plot(t, (measured - before)[near], color=VERMILION, linestyle="--", label="replayed before")
            above.plot(t, (measured - after)[near], color=BLUE, label="replayed after")
            below.plot(t, before[near] * 1e3, color=VERMILION, linestyle="--")
            below.plot(t, after[near] * 1e3, color=BLUE)
            above.set_title(feed_of(record.test), fontsize=8)
            below.set_xlabel("time after the reversal [ms]")
            for axes in (above, below):
                axes.axvline(0, color=GREY, linewidth=0.6)
        panels[0, 0].set_ylabel("voltage of friction [V]")
        panels[1, 0].set_ylabel("residual [mV]")
        handles, labels = panels[0, 0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=3)
        left = f"residual {axis.before.rms * 1e3:.2f} mV before, {axis.after.rms * 1e3:.2f} mV after"
        figure.suptitle(f"Axis {axis.axis.name}: {left}", fontsize=9)
    return figure


def _voltage_after(axis: TunedAxis, n: int) -> float:
    """Return the angle of the last reversal of the axis on a circle that is seen whole [rad]."""
    record = axis.after.balance.records[n]
    angle = record.angle[record.used]
    low, high = float(angle.min()) + AROUND, float(angle.max()) - AROUND
    shift = 0.0 if next(iter(record.test.axes)) == record.axis else pi / 2
    places = shift + pi * np.arange(np.ceil((low - shift) / pi), np.floor((high - shift) / pi) + 1)
    return float(places[-1] if angle[-1] >= angle[0] else places[0])


@view("rounds", of="Learned", usual=True)
def draw_learned(found: Learned) -> Figure:
    """Return the glitch over the rounds and on other circles, and the radial error before and after."""
    first, last = found.rounds[0], found.rounds[-1]
    with new_figure(7.6, 3.2) as figure:
        left, right = figure.subplots(1, 2, width_ratios=(1, 1.6))
        rounds = np.arange(len(found.rounds))
        left.plot(rounds, np.array(found.glitches) * 1e6, "o-", color=BLUE)
        for (radius, feed, glitch), style in zip(found.carried, ("--", ":", "-."), strict=False):
            label = f"carried over to {radius * 1e3:g} mm at {feed * 1e3:g} mm/s"
            left.axhline(glitch * 1e6, color=GREY, linestyle=style, linewidth=1.2, label=label)
        left.legend(fontsize=6.5)
        left.set_yscale("log")
        left.yaxis.set_minor_locator(LogLocator(subs=(2.0, 5.0)))
        for formatter in (left.yaxis.set_major_formatter, left.yaxis.set_minor_formatter):
            formatter("{x:g}")
        left.set(xticks=rounds[:: max(len(rounds) // 8, 1)], xlabel="circles learned from [1]", ylabel="glitch [µm]")
        after = f"after {len(rounds) - 1}"
        for run, colour, width, label in ((first, VERMILION, 1.6, "before"), (last, BLUE, 0.9, after)):
            order = np.argsort(run.circularity.angle % (2 * np.pi))
            angle = np.degrees(run.circularity.angle % (2 * np.pi))[order]
            right.plot(angle, run.circularity.error[order] * 1e6, color=colour, label=label, linewidth=width)
        right.axhline(0.0, color=GREY, linewidth=0.6)
        right.set(xticks=[0, 90, 180, 270, 360], xlabel="angle [°]", ylabel="radial error [µm]")
        right.legend()
        learned = f"learned with γ = {found.how.share:g} up to {found.how.bandwidth:g} Hz"
        figure.suptitle(f"Circle of {feed_of(first.circle)}, {learned}", fontsize=9)
    return figure

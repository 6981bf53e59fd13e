"""The voltage of recorded circles at their reversals, and what belief and result make of it."""

from math import pi

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator

from fric.circles.learn import Learned
from fric.circles.tune_fit import TunedAxis
from fric.figures.style import BLUE, GREY, VERMILION, feed_of, new_figure, view

AROUND = np.radians(25.0)  # Half of what is shown around a reversal, as an angle on the circle [rad]


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
            place, scale = _reversal(axis, n), 1e3 * record.radius / record.feed
            angle = record.angle[record.used]
            near = np.abs(angle - place) <= AROUND
            sense = 1.0 if angle[-1] >= angle[0] else -1.0
            t = (angle[near] - place) * sense * scale
            m, a, offset = axis.after.plant[0], axis.after.plant[1], axis.after.plant[2 + n]
            rest = -m * record.inertia[record.used] - a * record.damping[record.used] - offset
            coordinates = axis.after.balance.coordinates
            measured = record.delayed(coordinates.delay(axis.after.x)) + rest
            after, before = axis.after.parts()[n], axis.before.parts()[n]
            above.plot(t, measured[near], color=GREY, linewidth=2.4, label="measured")
            above.plot(t, (measured - before)[near], color=VERMILION, linestyle="--", label="replayed before")
            above.plot(t, (measured - after)[near], color=BLUE, label="replayed after")
            below.plot(t, before[near] * 1e3, color=VERMILION, linestyle="--")
            below.plot(t, after[near] * 1e3, color=BLUE)
            above.set_title(feed_of(record), fontsize=8)
            below.set_xlabel("time after the reversal [ms]")
            for axes in (above, below):
                axes.axvline(0, color=GREY, linewidth=0.6)
        panels[0, 0].set_ylabel("voltage of friction [V]")
        panels[1, 0].set_ylabel("left [mV]")
        handles, labels = panels[0, 0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=3)
        figure.suptitle(
            f"Axis {axis.axis.name}: {axis.before.rms * 1e3:.2f} mV left before, {axis.after.rms * 1e3:.2f} mV after",
            fontsize=9,
        )
    return figure


def _reversal(axis: TunedAxis, n: int) -> float:
    """Return the angle of the last reversal of the axis on a circle that is seen whole [rad]."""
    record = axis.after.balance.records[n]
    first = next(iter(record.test.axes)) == record.axis
    angle = record.angle[record.used]
    low, high = float(angle.min()) + AROUND, float(angle.max()) - AROUND
    shift = 0.0 if first else pi / 2
    places = shift + pi * np.arange(np.ceil((low - shift) / pi), np.floor((high - shift) / pi) + 1)
    return float(places[-1] if angle[-1] >= angle[0] else places[0])


@view("rounds", of="Learned", usual=True)
def draw_learned(found: Learned) -> Figure:
    """Return the glitch over the rounds and on other circles, and the radial error before and after."""
    first, last = found.rounds[0].run, found.rounds[-1].run
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
        left.set_xticks(rounds[:: max(len(rounds) // 8, 1)])
        left.set(xlabel="circles learned from [1]", ylabel="glitch [µm]")
        after = f"after {len(rounds) - 1}"
        for run, colour, width, label in ((first, VERMILION, 1.6, "before"), (last, BLUE, 0.9, after)):
            order = np.argsort(run.circularity.angle % (2 * np.pi))
            angle = np.degrees(run.circularity.angle % (2 * np.pi))[order]
            right.plot(angle, run.circularity.error[order] * 1e6, color=colour, label=label, linewidth=width)
        right.axhline(0.0, color=GREY, linewidth=0.6)
        right.set_xticks([0, 90, 180, 270, 360])
        right.set(xlabel="angle [°]", ylabel="radial error [µm]")
        right.legend()
        figure.suptitle(
            f"Circle of {feed_of(first.circle)}, learned with γ = {found.how.share:g} up to {found.how.bandwidth:g} Hz",
            fontsize=9,
        )
    return figure

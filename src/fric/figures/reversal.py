"""What happens while an axis reverses: its error, and the voltages that stand against friction."""

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from fric.figures.style import BLUE, GREEN, GREY, VERMILION, new_figure
from fric.figures.views import view
from fric.simulate.axis import Trace
from fric.simulate.circle import CircleRun

AROUND = np.pi / 12
"""Half the width of what is shown, as an angle on the circle [rad]."""


@view("reversal", of="CircleRun")
def reversal_figure(runs: Sequence[CircleRun]) -> Figure:
    """Return error and voltages over time around the last reversal of an axis, one column per scheme.

    Above the tracking error of the axis, position less reference; below the control voltage, and in it the friction
    feedforward and what the observer adds, which is its estimate with the sign turned.

    runs: One run per scheme, of one circle; drawn is the first axis that was simulated.
    """
    name = next(iter(runs[0].traces))
    test = runs[0].circle
    half = AROUND * test.radius / test.feed
    columns = len(runs)
    with new_figure(1.2 + 1.7 * columns, 4.2) as figure:
        panels = figure.subplots(2, columns, sharex=True, sharey="row", squeeze=False, height_ratios=(1, 1.25))
        for (above, below), run in zip(panels.T, runs, strict=True):
            trace = run.traces[name]
            centre = last_reversal(trace, half)
            t = (trace.time - centre) * 1e3
            near = np.abs(t) <= half * 1e3
            above.plot(t[near], (trace.position - trace.reference)[near] * 1e6, color=BLUE)
            above.set_title(f"({run.scheme.name})\n{run.scheme.title}", fontsize=8)
            below.plot(t[near], trace.input[near], color=GREY, label="control voltage", linewidth=0.8)
            if run.scheme.feeds_forward:
                below.plot(t[near], trace.feedforward[near], "--", color=VERMILION, label="friction feedforward")
            if run.scheme.observer:
                below.plot(t[near], -trace.disturbance[near], "-.", color=GREEN, label=r"observer, $-\hat{d}$")
            for axes in (above, below):
                axes.axvline(0, color=GREY, linewidth=0.6)
            below.set_xlabel("time [ms]")
        panels[0, 0].set_ylabel(f"error of {name} [µm]")
        panels[1, 0].set_ylabel("voltage [V]")
        drawn = (line for axes in panels[1] for line in axes.get_lines())
        shown = {line.get_label(): line for line in drawn if not str(line.get_label()).startswith("_")}
        figure.legend(shown.values(), shown.keys(), loc="outside lower center", ncols=len(shown))
        figure.suptitle(
            f"Reversal of axis {name}: circle of {test.radius * 1e3:g} mm at {test.feed * 1e3:g} mm/s", fontsize=9
        )
    return figure


def last_reversal(trace: Trace, margin: float) -> float:
    """Return the time [s] of the last reversal of the reference at least ``margin`` [s] before its end."""
    steps = np.sign(np.diff(trace.reference))
    reversals = trace.time[np.flatnonzero(steps[1:] * steps[:-1] < 0) + 1]
    whole = reversals[reversals <= trace.time[-1] - margin]
    return float(whole[-1] if len(whole) else reversals[-1])

"""A contour that is learned: its glitch over the rounds, and the radial error of the first and the last."""

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator

from fric.circles.learn import Learned
from fric.figures.style import BLUE, GREY, VERMILION, new_figure
from fric.figures.views import view


@view("rounds", of="Learned", usual=True)
def draw_learned(found: Learned) -> Figure:
    """Return the glitch over the rounds and what is left of other circles, and the radial error before and after.

    found: What was learned.
    """
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
        test = first.circle
        figure.suptitle(
            f"Circle of {test.radius * 1e3:g} mm at {test.feed * 1e3:g} mm/s, learned with γ = {found.how.share:g} "
            f"up to {found.how.bandwidth:g} Hz",
            fontsize=9,
        )
    return figure

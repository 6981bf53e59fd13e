"""How the glitch of each scheme is distributed over many machines, and how often each is the best."""

from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure

from fric.figures.style import BLUE, GREY, SKY, VERMILION, new_figure
from fric.figures.views import view
from fric.simulate.monte_carlo import MonteCarlo


@view("distribution", of="MonteCarlo", usual=True)
def monte_carlo_figure(found: MonteCarlo, nominal: Mapping[str, float] | None = None) -> Figure:
    """Return the glitches of all machines by scheme, and the share of machines on which each scheme is the best.

    A dot is a machine; the bar goes from the 5 % to the 95 % quantile, with the quartiles thick and the median white.

    found: Outcomes of a study.
    nominal: Glitch of the nominal machine by scheme [m], drawn as a diamond.
    """
    schemes, glitches = found.study.schemes, found.glitches * 1e6
    text = found.distributions()
    places = np.arange(len(schemes))
    with new_figure(6.3, 1.3 + 0.42 * len(schemes)) as figure:
        left, right = figure.subplots(1, 2, sharey=True, width_ratios=(3, 1))
        for place, scheme, column in zip(places, schemes, glitches.T, strict=True):
            ran = column[np.isfinite(column)]
            if len(ran):
                # spread out by machine number: a golden-ratio sequence fills the strip evenly
                offset = 0.62 * (np.arange(len(ran)) * 0.618034 % 1.0 - 0.5)
                left.plot(ran, place + offset, ".", color=SKY, markersize=4, alpha=0.8, markeredgewidth=0)
                low, first, median, third, high = np.quantile(ran, (0.05, 0.25, 0.5, 0.75, 0.95))
                left.plot([low, high], [place, place], color=BLUE, linewidth=1.4, solid_capstyle="butt")
                left.plot([first, third], [place, place], color=BLUE, linewidth=6, solid_capstyle="butt")
                left.plot([median], [place], "|", color="white", markersize=6, markeredgewidth=1.6)
            if nominal and scheme.name in nominal:
                left.plot(nominal[scheme.name] * 1e6, place, "D", color=VERMILION, markersize=4)
            share = text[scheme.name].best * 100
            right.barh(place, share, height=0.5, color=BLUE)
            right.text(share + 2, place, f"{share:.0f} %", va="center", fontsize=7, color=GREY)
        left.set_yticks(places, [f"({scheme.name}) {scheme.title}" for scheme in schemes])
        left.invert_yaxis()
        left.set_xlim(left=0)
        left.set_xlabel("glitch [µm]")
        right.set_xlim(0, 118)
        right.set_xticks([0, 50, 100])
        right.set_xlabel("best on machines [%]")
        for axes in (left, right):
            axes.grid(visible=False, axis="y")
            axes.tick_params(axis="y", length=0)
        circle = found.study.circle
        test = f"circle of {circle.radius * 1e3:g} mm at {circle.feed * 1e3:g} mm/s"
        note = "; diamond: nominal machine" if nominal else ""
        figure.suptitle(f"{len(found)} machines, {test}{note}", fontsize=9)
    return figure

"""What changed from one date to another, number by number."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure

from fric.figures.style import BLUE, GREY, VERMILION, new_figure


@dataclass(frozen=True)
class RelativeChange:
    """A number at two dates: its name, its change with 95 % limits [%], and whether it moved beyond them."""

    name: str
    change: float
    low: float
    high: float
    moved: bool


def draw_drift(changes: Sequence[RelativeChange]) -> Figure:
    """Draw the relative change of each number with its 95 % interval; a diamond where that does not hold 0."""
    with new_figure(7.0, 0.7 + 0.24 * len(changes)) as figure:
        axes = figure.subplots()
        places = np.arange(len(changes))[::-1]
        axes.axvline(0.0, color=GREY, linestyle="--", linewidth=0.8)
        for place, one in zip(places, changes, strict=True):
            colour = VERMILION if one.moved else BLUE
            axes.plot([one.low, one.high], [place, place], color=colour, linewidth=1.6)
            axes.plot(one.change, place, "D" if one.moved else "o", color=colour, markersize=4)
        axes.set_yticks(places, [one.name for one in changes])
        axes.set_xlabel("change [%]")
        axes.set_ylim(-0.7, len(changes) - 0.3)
    return figure

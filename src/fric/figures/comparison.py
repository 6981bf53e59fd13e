"""Friction models side by side: how far each is off, and where."""

import numpy as np
from matplotlib.figure import Figure

from fric.figures.style import BLUE, GREY, VERMILION, look, new_figure
from fric.figures.views import view
from fric.identify.replay.compare import Comparison
from fric.units import prefixed, si_unit


@view("scores", of="Comparison", usual=True)
def draw_comparison(comparison: Comparison) -> Figure:
    """Draw the rms of every model, and the first hysteresis cycle scored of the first record that is scored."""
    scores = comparison.scores
    motion = comparison.records[0].log.motion
    force, length = si_unit("force", motion), si_unit("position", motion)
    with new_figure(7.0, 3.6) as figure:
        bars, hysteresis = figure.subplots(1, 2, width_ratios=[1.0, 1.3])
        place = np.arange(len(scores))[::-1]
        bars.barh(place + 0.2, [s.rms for s in scores], 0.38, color=BLUE, label="all samples scored")
        bars.barh(place - 0.2, [s.rms_near for s in scores], 0.38, color=VERMILION, label="near reversals")
        for row, score in zip(place, scores, strict=True):
            bars.annotate(f"{score.rms:.3g}", (score.rms, row + 0.2), (3, 0), textcoords="offset points", va="center")
        bars.margins(x=0.15)
        bars.set_yticks(place, [s.name for s in scores])
        bars.set(xlabel=f"rms force error [{force}]")
        bars.grid(visible=False, axis="y")
        figure.legend(*bars.get_legend_handles_labels(), loc="outside lower left", ncols=2)

        number = next(n for n, rest in enumerate(scores[0].residual) if np.isfinite(rest).any())
        record = comparison.records[number]
        shown = np.isfinite(scores[0].residual[number])
        reversals = record.reversals[shown[np.minimum(record.reversals, len(shown) - 1)]]
        if len(reversals) > 2:
            within = np.arange(len(shown))
            shown &= (within >= reversals[0]) & (within <= reversals[2])
        z = record.motion.position[shown]
        scale, unit = prefixed(float(np.ptp(z)), length)
        z = scale * (z - 0.5 * (z.min() + z.max()))
        hysteresis.plot(z, record.force[shown], color=GREY, lw=2.5, alpha=0.5, label="measured")
        for n, score in enumerate(scores):
            hysteresis.plot(z, (record.force - score.residual[number])[shown], **look(n), lw=0.9, label=score.name)
        hysteresis.set(xlabel=f"position about the middle [{unit}]", ylabel=f"force [{force}]", title=record.log.name)
        hysteresis.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))
        return figure

"""Measured against replayed force."""

import numpy as np
from matplotlib.figure import Figure

from fric.figures.style import BLACK, BLUE, GREY, new_figure
from fric.figures.views import view
from fric.identify.replay.replay_fit import ReplayFit
from fric.units import prefixed, si_unit

MOST = 4
"""Records that are drawn."""


@view("replay", of="ReplayFit", usual=True)
def draw_replay(fit: ReplayFit) -> Figure:
    """Draw, for each record, measured and replayed force over position, and the residual over time."""
    records = fit.records[:MOST]
    with new_figure(6.3, 2.6 * len(records)) as figure:
        axes = figure.subplots(len(records), 2, squeeze=False)
        force, position = si_unit("force", fit.motion), si_unit("position", fit.motion)
        for (cycle, rest), record, own in zip(axes, records, fit.own, strict=False):
            z, used = record.motion.position, record.used
            scale, unit = prefixed(float(np.ptp(z)), position)
            replayed = record.replay(fit.model) + record.own @ np.asarray(own)
            cycle.plot(scale * z[used], record.force[used], color=GREY, lw=2.5, alpha=0.5, label="measured")
            cycle.plot(scale * z[used], replayed[used], color=BLUE, lw=1.0, label=fit.model.name)
            cycle.set(xlabel=f"position [{unit}]", ylabel=f"force [{force}]", title=record.log.name)
            cycle.legend(loc="best")
            residual = np.where(used, record.force - replayed, np.nan)
            rest.plot(record.motion.time, residual, color=BLACK, lw=0.6)
            text = float(np.sqrt(np.nanmean(residual**2)))
            rest.set(xlabel="time [s]", ylabel=f"measured - replayed [{force}]", title=f"rms {text:.3g} {force}")
        return figure

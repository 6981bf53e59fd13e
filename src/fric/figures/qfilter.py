"""How far Q may reach: Fig. 7 of the paper."""

import numpy as np
from matplotlib.figure import Figure

from fric.design.observer import ObserverDesign
from fric.figures.style import BLACK, BLUE, GREY, ORANGE, VERMILION, new_figure
from fric.figures.views import view


@view("q", of="ObserverDesign", usual=True)
def q_filter_figure(design: ObserverDesign) -> Figure:
    """Draw |Q| below 1/|Delta|, as in Fig. 7: the chosen Q, and the largest by eq. (8), which touches.

    Parameters
    ----------
    design
        The observer with its limits. Where Delta was measured with a confidence, the edge of its 95 % circle is drawn
        too: that is what limits Q.
    """
    Delta, q = design.perturbation, design.observer.q
    top = design.cascade.sampling / 2
    f = np.geomspace(min(1.0, q.cutoff / 20), top, 2000)
    with new_figure(6.3, 4.0) as figure:
        axes = figure.subplots()
        inverse = -20 * np.log10(np.maximum(np.abs(Delta.Delta), 1e-12))
        style = {"color": BLACK} | ({"marker": ".", "markersize": 2, "linewidth": 0.6} if Delta.measured else {})
        axes.semilogx(Delta.frequency, inverse, label="1/|Δ|" + ", measured" * Delta.measured, **style)
        if Delta.radius.any():
            edge = -20 * np.log10(np.maximum(Delta.size, 1e-12))
            axes.fill_between(
                Delta.frequency, edge, inverse, color=GREY, alpha=0.35, linewidth=0, label="95 % confidence"
            )
        axes.semilogx(
            f, 20 * np.log10(np.abs(q.response(f))), color=BLUE, linewidth=1.8, label=_described("Q", q.cutoff)
        )
        limits = (("eq. (8)", design.robust.q, VERMILION, "--"), ("peak sensitivity", design.sensitive, ORANGE, "-."))
        for why, limit, color, line in limits:
            if limit is not None and abs(limit.cutoff / q.cutoff - 1) > 1e-6:
                axes.semilogx(
                    f, 20 * np.log10(np.abs(limit.response(f))), line, color=color, label=_described(why, limit.cutoff)
                )
        if design.robust.q is not None:
            axes.plot(design.robust.frequency, -20 * np.log10(design.robust.size), "o", color=VERMILION, markersize=5)
        axes.axvline(q.bandwidth, color=BLUE, linewidth=0.8, linestyle=":")
        axes.annotate(f"−3 dB: {q.bandwidth:.3g} Hz", (q.bandwidth, -45), color=BLUE, fontsize=8, rotation=90,
                      ha="right", va="bottom")  # fmt: skip
        axes.set(xlim=(f[0], top), ylim=(-50, 40), xlabel="frequency [Hz]", ylabel="magnitude [dB]")
        axes.legend(loc="lower left")
    return figure


def _described(what: str, cutoff: float) -> str:
    return f"{what}, cutoff {cutoff:.3g} Hz"

"""How far Q may reach: Fig. 7 of the paper."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure

from fric.control.q_filter import QFilter
from fric.design.observer import ObserverDesign
from fric.design.perturbation import Perturbation
from fric.figures.style import BLACK, BLUE, GREY, ORANGE, VERMILION, new_figure
from fric.figures.views import view


@dataclass(frozen=True, eq=False)
class QReach:
    """What is drawn of a Q: of a design, or of an observer's document with the response that is there."""

    q: QFilter
    robust: QFilter | None  # the largest by eq. (8); None where nothing limits it
    sensitive: QFilter | None  # the largest by the peak sensitivity; None where nothing limits it
    touches: Sequence[tuple[float, float]]  # frequency [Hz] and |Delta| where a limit is reached
    perturbation: Perturbation | None
    top: float  # highest frequency drawn [Hz]


@view("q", of="ObserverDesign", usual=True)
def q_filter_figure(design: ObserverDesign) -> Figure:
    """Draw |Q| below 1/|Delta|, as in Fig. 7: the chosen Q, and the largest by eq. (8), which touches.

    design: The observer with its limits. Where Delta was measured with a confidence, the edge of its 95 % circle is
        drawn too: that is what limits Q.
    """
    limit = design.robust
    touches = [(limit.frequency, limit.size)] if limit.q is not None else []
    return reach_figure(
        QReach(design.observer.q, limit.q, design.sensitive, touches, design.perturbation, design.cascade.sampling / 2)
    )


def reach_figure(found: QReach, width: float = 6.3, height: float = 4.0) -> Figure:
    """Draw |Q| and what limits it, so wide and high [inch]."""
    q, Delta = found.q, found.perturbation
    f = np.geomspace(min(1.0, q.cutoff / 20), found.top, 2000)
    with new_figure(width, height) as figure:
        axes = figure.subplots()
        if Delta is not None:
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
        limits = (("eq. (8)", found.robust, VERMILION, "--"), ("peak sensitivity", found.sensitive, ORANGE, "-."))
        for why, limit, color, line in limits:
            if limit is not None and abs(limit.cutoff / q.cutoff - 1) > 1e-6:
                axes.semilogx(
                    f, 20 * np.log10(np.abs(limit.response(f))), line, color=color, label=_described(why, limit.cutoff)
                )
        for frequency, size in found.touches:
            axes.plot(frequency, -20 * np.log10(size), "o", color=VERMILION, markersize=5)
        axes.axvline(q.bandwidth, color=BLUE, linewidth=0.8, linestyle=":")
        axes.annotate(f"−3 dB: {q.bandwidth:.3g} Hz", (q.bandwidth, -45), color=BLUE, fontsize=8, rotation=90,
                      ha="right", va="bottom")  # fmt: skip
        axes.set(xlim=(f[0], found.top), ylim=(-50, 40), xlabel="frequency [Hz]", ylabel="magnitude [dB]")
        axes.legend(loc="lower left")
    return figure


def _described(what: str, cutoff: float) -> str:
    return f"{what}, cutoff {cutoff:.3g} Hz"

"""Open loops with their margins: Bode, Nyquist and Nichols diagrams; and how far Q may reach, Fig. 7 of the paper."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure

from fric.control.q_filter import QFilter
from fric.design.loop import Loop, Margins, decibel
from fric.design.observer import ObserverDesign, Perturbation
from fric.figures.style import BLACK, BLUE, GREY, ORANGE, VERMILION, look, new_figure, view

LOWEST = 0.5  # Lowest frequency at which loops are drawn [Hz]


def bode_figure(loops: Iterable[Loop], nyquist: float) -> Figure:
    """Draw gain and phase of open loops up to half the sampling rate [Hz]; bars to 0 dB and −180° are the margins."""
    f = np.geomspace(LOWEST, nyquist, 2000)
    with new_figure(6.3, 5.2) as figure:
        gain, phase = figure.subplots(2, 1, sharex=True, height_ratios=(3, 2))
        gain.axhline(0.0, color=GREY, linewidth=0.8)
        phase.axhline(-180.0, color=GREY, linewidth=0.8)
        for n, loop in enumerate(loops):
            L, found, color = loop.response(f), loop.margins, look(n)["color"]
            gain.semilogx(f, 20 * np.log10(np.abs(L)), **look(n), label=_margins(loop))
            phase.semilogx(f, unwrapped(L), **look(n))
            if LOWEST < found.phase_crossover <= nyquist:
                gain.vlines(found.phase_crossover, -decibel(found.gain_margin), 0.0, color=color, linewidth=2.4)
                gain.plot(found.phase_crossover, -decibel(found.gain_margin), "o", color=color, markersize=4)
            if LOWEST < found.crossover <= nyquist:
                at = -180.0 + np.degrees(np.angle(-loop.response(np.array([found.crossover]))[0]))
                phase.vlines(found.crossover, -180.0, at, color=color, linewidth=2.4)
                phase.plot(found.crossover, at, "o", color=color, markersize=4)
        gain.set(ylim=(-60, 60), ylabel="gain |L| [dB]")
        gain.legend(title="phase margin, gain margin", loc="lower left", alignment="left")
        phase.set(ylim=(-400, -40), yticks=np.arange(-360, -40, 45), ylabel="phase [°]")
        phase.set(xlabel="frequency [Hz]", xlim=(LOWEST, nyquist))
    return figure


def unwrapped(L: np.ndarray) -> np.ndarray:
    """Return the phase [°] of an open loop, unwrapped, beginning between −360° and 0°."""
    angle = np.degrees(np.unwrap(np.angle(L)))
    return np.asarray(angle - 360.0 * np.ceil(angle[0] / 360.0))


def nyquist_figure(loops: Iterable[Loop], nyquist: float) -> Figure:
    """Draw open loops around −1: distance to it is 1/|S|, circles are drawn where |S| is M_s of each loop.

    The phase margin is the arc along the unit circle, the gain margin the place on the real axis.
    """
    f = np.geomspace(nyquist * 1e-4, nyquist, 6000)
    arc = np.linspace(0, 2 * np.pi, 400)
    with new_figure(5.2, 5.0) as figure:
        axes = figure.subplots()
        axes.plot(np.cos(arc), np.sin(arc), color=GREY, linewidth=0.8)
        axes.plot(-1, 0, "+", color=BLACK, markersize=10, markeredgewidth=1.6)
        for n, loop in enumerate(loops):
            L, found, color = loop.response(f), loop.margins, look(n)["color"]
            text = f"{loop.title}: M_s {decibel(found.peak_sensitivity):.1f} dB".replace("M_s", "Mₛ")
            axes.plot(L.real, L.imag, **look(n), label=text)
            radius = 1 / found.peak_sensitivity
            axes.plot(-1 + radius * np.cos(arc), radius * np.sin(arc), ":", color=color, linewidth=1.0)
            if np.isfinite(found.phase_crossover):
                axes.plot(-1 / found.gain_margin, 0, "s", color=color, markersize=4)
            if np.isfinite(found.crossover):
                at = loop.response(np.array([found.crossover]))[0]
                sweep = np.pi + np.linspace(0, np.angle(-at), 60)
                axes.plot(np.cos(sweep), np.sin(sweep), color=color, linewidth=2.4, zorder=_front(found))
                axes.plot(at.real, at.imag, "o", color=color, markersize=4)
        axes.set(xlim=(-2.5, 1.5), ylim=(-2.5, 1.5), aspect="equal")
        axes.set(xlabel="real part of L [1]", ylabel="imaginary part of L [1]")
        axes.legend(loc="upper left")
    return figure


def nichols_figure(loops: Iterable[Loop], nyquist: float) -> Figure:
    """Draw gain over phase of open loops, with the contours of |S| = 3, 6 and 10 dB around −180°.

    The phase margin is the bar at 0 dB, the gain margin that at −180°.
    """
    f = np.geomspace(nyquist * 1e-4, nyquist, 6000)
    with new_figure(6.3, 5.0) as figure:
        axes = figure.subplots()
        phase, gain = np.meshgrid(np.linspace(-360, 0, 721), np.linspace(-40, 40, 641))
        size = -20 * np.log10(np.abs(1 + 10 ** (gain / 20) * np.exp(1j * np.radians(phase))) + 1e-12)
        lines = axes.contour(phase, gain, size, levels=[3, 6, 10], colors=[GREY], linewidths=0.8)
        axes.clabel(lines, fmt=lambda level: f"|S| {level:g} dB", fontsize=7)
        axes.plot(-180, 0, "+", color=BLACK, markersize=10, markeredgewidth=1.6)
        for n, loop in enumerate(loops):
            L, found, color = loop.response(f), loop.margins, look(n)["color"]
            axes.plot(unwrapped(L), 20 * np.log10(np.abs(L)), **look(n), label=_margins(loop))
            if np.isfinite(found.phase_crossover):
                axes.vlines(-180, -decibel(found.gain_margin), 0, color=color, linewidth=2.4, zorder=_front(found))
                axes.plot(-180, -decibel(found.gain_margin), "s", color=color, markersize=4)
            if np.isfinite(found.crossover):
                at = -180 + np.degrees(np.angle(-loop.response(np.array([found.crossover]))[0]))
                axes.hlines(0, -180, at, color=color, linewidth=2.4, zorder=_front(found))
                axes.plot(at, 0, "o", color=color, markersize=4)
        axes.set(xlim=(-330, -30), ylim=(-40, 40))
        axes.set_xticks(np.arange(-315, -44, 45))
        axes.set(xlabel="phase [°]", ylabel="gain |L| [dB]")
        axes.legend(title="phase margin, gain margin", loc="lower right", alignment="left")
    return figure


def _margins(loop: Loop) -> str:
    found = loop.margins
    return f"{loop.title}: {np.degrees(found.phase_margin):.1f}°, {decibel(found.gain_margin):.1f} dB"


def _front(found: Margins) -> float:
    """Return the drawing order: a short margin is drawn above a long margin, which would hide it."""
    return 3.0 - found.phase_margin / np.pi


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
    highest = design.cascade.sampling / 2
    return reach_figure(QReach(design.observer.q, limit.q, design.sensitive, touches, design.perturbation, highest))


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
                axes.fill_between(Delta.frequency, edge, inverse, color=GREY, alpha=0.35, lw=0, label="95 % confidence")
        axes.semilogx(f, 20 * np.log10(np.abs(q.response(f))), color=BLUE, lw=1.8, label=_described("Q", q.cutoff))
        limits = (("eq. (8)", found.robust, VERMILION, "--"), ("peak sensitivity", found.sensitive, ORANGE, "-."))
        for why, limit, color, line in limits:
            if limit is not None and abs(limit.cutoff / q.cutoff - 1) > 1e-6:
                level = 20 * np.log10(np.abs(limit.response(f)))
                axes.semilogx(f, level, line, color=color, label=_described(why, limit.cutoff))
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

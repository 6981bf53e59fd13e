"""Nyquist and Nichols diagram of open loops, with their margins."""

from collections.abc import Iterable

import numpy as np
from matplotlib.figure import Figure

from fric.design.margins import Loop, Margins, decibel
from fric.figures.bode import unwrapped
from fric.figures.style import BLACK, GREY, look, new_figure


def nyquist_figure(loops: Iterable[Loop], nyquist: float) -> Figure:
    """Draw open loops around −1: distance to it is 1/|S|, circles are drawn where |S| is M_s of each loop.

    The phase margin is the arc along the unit circle, the gain margin the place on the real axis.

    loops: The loops with their margins.
    nyquist: Half the sampling rate [Hz].
    """
    f = np.geomspace(nyquist * 1e-4, nyquist, 6000)
    arc = np.linspace(0, 2 * np.pi, 400)
    with new_figure(5.2, 5.0) as figure:
        axes = figure.subplots()
        axes.plot(np.cos(arc), np.sin(arc), color=GREY, linewidth=0.8)
        axes.plot(-1, 0, "+", color=BLACK, markersize=10, markeredgewidth=1.6)
        for n, loop in enumerate(loops):
            L, found, color = loop.response(f), loop.margins, look(n)["color"]
            text = f"{loop.title}: M_s {decibel(found.peak_sensitivity):.1f} dB".replace("M_s", "$M_s$")
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
        axes.set(
            xlim=(-2.5, 1.5),
            ylim=(-2.5, 1.5),
            aspect="equal",
            xlabel="real part of L [1]",
            ylabel="imaginary part of L [1]",
        )
        axes.legend(loc="upper left")
    return figure


def nichols_figure(loops: Iterable[Loop], nyquist: float) -> Figure:
    """Draw gain over phase of open loops, with the contours of |S| = 3, 6 and 10 dB around −180°.

    The phase margin is the bar at 0 dB, the gain margin that at −180°.

    loops: The loops with their margins.
    nyquist: Half the sampling rate [Hz].
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
            text = f"{loop.title}: {np.degrees(found.phase_margin):.1f}°, {decibel(found.gain_margin):.1f} dB"
            axes.plot(unwrapped(L), 20 * np.log10(np.abs(L)), **look(n), label=text)
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


def _front(found: Margins) -> float:
    """Return the place in the drawing's depth: a short margin before a long one, which it would vanish behind."""
    return 3.0 - found.phase_margin / np.pi

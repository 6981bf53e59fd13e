"""Bode diagram of open loops, with their margins."""

from collections.abc import Iterable

import numpy as np
from matplotlib.figure import Figure

from fric.design.margins import Loop, decibel
from fric.figures.style import GREY, look, new_figure

LOWEST = 0.5
"""Frequency from which on loops are drawn [Hz]."""


def bode_figure(loops: Iterable[Loop], nyquist: float) -> Figure:
    """Draw gain and phase of open loops; each margin is a bar from the curve to 0 dB or to −180°.

    loops: The loops with their margins.
    nyquist: Half the sampling rate [Hz], the right end.
    """
    f = np.geomspace(LOWEST, nyquist, 2000)
    with new_figure(6.3, 5.2) as figure:
        gain, phase = figure.subplots(2, 1, sharex=True, height_ratios=(3, 2))
        gain.axhline(0.0, color=GREY, linewidth=0.8)
        phase.axhline(-180.0, color=GREY, linewidth=0.8)
        for n, loop in enumerate(loops):
            L, found, color = loop.response(f), loop.margins, look(n)["color"]
            text = f"{loop.title}: {np.degrees(found.phase_margin):.1f}°, {decibel(found.gain_margin):.1f} dB"
            gain.semilogx(f, 20 * np.log10(np.abs(L)), **look(n), label=text)
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
        phase.set_ylim(-400, -40)
        phase.set_yticks(np.arange(-360, -40, 45))
        phase.set(ylabel="phase [°]", xlabel="frequency [Hz]", xlim=(LOWEST, nyquist))
    return figure


def unwrapped(L: np.ndarray) -> np.ndarray:
    """Return the phase [°] of an open loop, unwrapped, beginning between −360° and 0°."""
    angle = np.degrees(np.unwrap(np.angle(L)))
    return np.asarray(angle - 360.0 * np.ceil(angle[0] / 360.0))

"""Gain and phase margin, crossovers, bandwidth and peak sensitivity of an open loop."""

from collections.abc import Callable
from dataclasses import dataclass
from math import floor, log10
from typing import Any

import numpy as np

from fric.arrays import Complex, Real

OpenLoop = Callable[[Real], Complex]

DECADES, POINTS = 5, 1500


@dataclass(frozen=True)
class Margins:
    """How far an open loop L of a stable closed loop is from −1.

    What a loop does not have (no crossover, no bandwidth below half the sampling rate) is infinite.
    """

    crossover: float  # Frequency of the gain crossover that has the phase margin [Hz]
    phase_margin: float  # Smallest phase lag that would bring the loop to the edge of stability [rad]
    phase_crossover: float  # Frequency of the phase crossover that has the gain margin [Hz]
    gain_margin: float  # Smallest factor on the gain above 1 that would do so
    gain_reduction: float  # Largest factor below 1 that would do so; 0 where the gain may fall at will
    # peak_sensitivity, peak_frequency: M_s = max |1/(1 + L)| and where it is [Hz]: 1/M_s is the distance of L from −1
    peak_sensitivity: float
    peak_frequency: float
    bandwidth: float  # First frequency at which |L/(1 + L)| has fallen by 3 dB [Hz]

    def as_dict(self) -> dict[str, Any]:
        """Return the margins as a document has them, in degrees and decibels; what is infinite is left out."""
        text: dict[str, tuple[float, str]] = {
            "phase_margin": (float(np.degrees(self.phase_margin)), "deg"),
            "gain_margin": (decibel(self.gain_margin), "dB"),
            "gain_reduction": (decibel(self.gain_reduction) if self.gain_reduction else float("inf"), "dB"),
            "peak_sensitivity": (decibel(self.peak_sensitivity), "dB"),
            "crossover": (self.crossover, "Hz"),
            "phase_crossover": (self.phase_crossover, "Hz"),
            "peak_frequency": (self.peak_frequency, "Hz"),
            "bandwidth": (self.bandwidth, "Hz"),
        }
        return {name: {"value": value, "unit": unit} for name, (value, unit) in text.items() if np.isfinite(value)}


@dataclass(frozen=True)
class Loop:
    """An open loop: its description, its response, its margins."""

    title: str  # What figures and tables call it
    response: OpenLoop  # L at frequencies [Hz], shape (n,)
    margins: Margins  # Its margins


def decibel(ratio: float) -> float:
    """Return a ratio of amplitudes in dB."""
    return float(20 * np.log10(ratio))


def rounded_down(value: float) -> str:
    """Return a positive number cut, not rounded, to four digits: what is named as allowed must be allowed."""
    scale = 10.0 ** (3 - int(np.floor(np.log10(value))))
    return f"{np.floor(value * scale) / scale:.4g}"


def border(holds: Callable[[float], bool], inside: float, outside: float, precision: float = 1e-8) -> float:
    """Return the last admissible value between an admissible value and one beyond, to a relative precision."""
    while abs(outside / inside - 1.0) > precision:
        middle = float(np.sqrt(inside * outside))
        inside, outside = (middle, outside) if holds(middle) else (inside, middle)
    return float(inside)


def three_digits(value: float) -> float:
    """Return a value with three digits, rounded down; 0 stays 0."""
    scale = 10.0 ** (2 - floor(log10(value))) if value > 0 else 1.0
    return floor(value * scale) / scale


def grid(nyquist: float) -> Real:
    """Return the frequencies [Hz] on which crossovers are looked for: five decades up to half the sampling rate."""
    return np.geomspace(nyquist * 10.0**-DECADES, nyquist, POINTS)


def margins(loop: OpenLoop, nyquist: float) -> Margins:
    """Return the margins of an open loop, crossovers refined by root finding.

    loop: L at frequencies [Hz], shape (n,).
    nyquist: Half the sampling rate [Hz].
    """
    f = grid(nyquist)
    L = loop(f)

    def at(frequency: float) -> complex:
        return complex(loop(np.array([frequency]))[0])

    crossovers = _roots(f, np.log(np.abs(L)), lambda frequency: float(np.log(abs(at(frequency)))))
    phases = [(abs(float(np.angle(-at(root)))), root) for root in crossovers]
    phase_margin, crossover = min(phases, default=(np.inf, np.inf))

    turning = [root for root in _roots(f, L.imag, lambda frequency: at(frequency).imag) if at(root).real < 0]
    edge = [nyquist] if L[-1].real < 0 and abs(L[-1].imag) < 1e-9 * abs(L[-1]) else []
    gains = [(1.0 / abs(at(root)), root) for root in {*turning, *edge}]
    gain_margin, phase_crossover = min((pair for pair in gains if pair[0] >= 1.0), default=(np.inf, np.inf))
    gain_reduction = max((gain for gain, _ in gains if gain < 1.0), default=0.0)

    peak_frequency, peak = _peak(f, 1.0 / np.abs(1.0 + L), lambda frequency: 1.0 / abs(1.0 + at(frequency)))

    def closed(frequency: float) -> float:
        return float(np.log(abs(at(frequency) / (1.0 + at(frequency))) * np.sqrt(2.0)))

    falls = _roots(f, np.log(np.abs(L / (1.0 + L)) * np.sqrt(2.0)), closed)
    return Margins(
        crossover, phase_margin, phase_crossover, gain_margin, gain_reduction, peak, peak_frequency,
        falls[0] if falls else float("inf"),
    )  # fmt: skip


def _roots(f: Real, values: Real, function: Callable[[float], float]) -> list[float]:
    """Return the roots between grid points of opposite sign, the ends of the grid left out."""
    from scipy.optimize import brentq  # not at the start: simulations need no margins, and it takes 0.1 s

    places = np.flatnonzero(np.sign(values[:-2]) * np.sign(values[1:-1]) < 0)
    return [float(brentq(function, f[i], f[i + 1], xtol=1e-10 * f[i], rtol=1e-13)) for i in places]


def _peak(f: Real, values: Real, function: Callable[[float], float]) -> tuple[float, float]:
    """Return place and height of the highest point, refined between its neighbours on the grid."""
    from scipy.optimize import minimize_scalar

    top = int(np.argmax(values))
    low, high = np.log(f[max(top - 1, 0)]), np.log(f[min(top + 1, f.size - 1)])
    found = minimize_scalar(
        lambda x: -function(np.exp(x)), bounds=(low, high), method="bounded", options={"xatol": 1e-9}
    )
    refined = -float(found.fun)
    return (float(np.exp(found.x)), refined) if refined > values[top] else (float(f[top]), float(values[top]))

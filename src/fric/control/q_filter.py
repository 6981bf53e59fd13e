"""The low-pass Q of a disturbance observer."""

from dataclasses import dataclass
from math import pi, sqrt

import numpy as np

from fric.arrays import Complex, Real
from fric.errors import FricError
from fric.verb import require_within

Roots = tuple[complex, ...]


def _butterworth(order: int) -> Roots:
    angles = pi * (2 * np.arange(1, order + 1) + order - 1) / (2 * order)
    return tuple(complex(round(np.cos(angle), 15), round(np.sin(angle), 15)) for angle in angles)


Q_FILTERS: dict[str, tuple[Roots, Roots]] = {
    "binomial2": ((-1.0,) * 2, ()),
    "binomial3": ((-1.0,) * 3, ()),
    "binomial4": ((-1.0,) * 4, ()),
    "butterworth2": (_butterworth(2), ()),
    "butterworth3": (_butterworth(3), ()),
    "umeno-hori": ((-1.0,) * 3, (-1 / 3,)),
}
"""Poles and zeros of each Q with s in units of 2π·cutoff; all have relative degree two or higher, as G_n⁻¹ asks for.

With τ = 1/(2π·cutoff): ``binomialN`` is 1/(τs + 1)^N; ``umeno-hori`` is (3τs + 1)/(τs + 1)³, the Q_31 of Umeno and
Hori (IEEE Trans. Ind. Electron. 38, 1991), for which 1 − Q is of second order at rest: a ramp of disturbance
leaves no error."""


@dataclass(frozen=True)
class QFilter:
    """The low-pass filter Q of a disturbance observer, with unit gain at rest.

    Two frequencies are at home in the literature, and they differ: the *cutoff* 1/(2πτ), where the poles lie, and the
    *bandwidth*, where |Q| has fallen by 3 dB. ``binomial2`` has its bandwidth at 0.64 cutoffs.

    name: One of `Q_FILTERS`.
    cutoff: Corner frequency 1/(2πτ) [Hz].
    Raises FricError: When the filter is not known or its cutoff is not positive.
    """

    name: str = "binomial2"
    cutoff: float = 60.0

    def __post_init__(self) -> None:
        if self.name not in Q_FILTERS:
            raise FricError(f"'{self.name}' is no Q-filter", hint=f"Known are {', '.join(Q_FILTERS)}.")
        require_within(self, "Q", cutoff="(0, inf)")

    @property
    def poles(self) -> Complex:
        """Poles [rad/s]."""
        return _scaled(Q_FILTERS[self.name][0], self.cutoff)

    @property
    def zeros(self) -> Complex:
        """Zeros [rad/s]."""
        return _scaled(Q_FILTERS[self.name][1], self.cutoff)

    @property
    def bandwidth(self) -> float:
        """The last frequency at which |Q|² = 1/2 [Hz]."""
        # |Q|² is rational in x = (frequency/cutoff)²; 2|N|² − |D|² = 0 is a polynomial in x. Of roots r that are closed
        # under conjugation |Π(jω − r)|² is Π(x + r²) at x = ω²
        squares = (np.poly([-(root**2) for root in roots]) for roots in Q_FILTERS[self.name])
        poles, zeros = (np.atleast_1d(np.real(square)) for square in squares)
        x = np.roots(np.polysub(2 * zeros / zeros[-1], poles / poles[-1]))
        return self.cutoff * sqrt(max(root.real for root in x if abs(root.imag) < 1e-6 * abs(root) and root.real > 0))

    def response(self, frequency: Real) -> Complex:
        """Return Q at the frequencies [Hz], shape (n,)."""
        s = 2j * pi * np.asarray(frequency, float)
        Q = np.ones_like(s)
        for zero in self.zeros:
            Q *= 1 - s / zero
        for pole in self.poles:
            Q /= 1 - s / pole
        return Q


def _scaled(roots: Roots, cutoff: float) -> Complex:
    """Return the roots of a filter with a cutoff [Hz]; by Python's product, which is the same on every processor."""
    return np.array([root * (2 * pi * cutoff) for root in roots], np.complex128)

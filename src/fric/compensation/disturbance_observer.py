"""The disturbance observer: what acts on the plant besides the control voltage, seen through a Q-filter."""

from __future__ import annotations

from dataclasses import dataclass
from math import comb, pi, sqrt
from typing import TYPE_CHECKING

import numpy as np

from fric.errors import FricError

if TYPE_CHECKING:
    from numpy.typing import NDArray

Q_FILTERS: dict[str, tuple[float, ...]] = {
    # denominators in x = s/(2π·cutoff), highest power first; the numerator is 1
    "binomial2": tuple(map(float, (comb(2, i) for i in range(3)))),
    "binomial3": tuple(map(float, (comb(3, i) for i in range(4)))),
    "binomial4": tuple(map(float, (comb(4, i) for i in range(5)))),
    "butterworth2": (1.0, sqrt(2.0), 1.0),
    "butterworth3": (1.0, 2.0, 2.0, 1.0),
}
"""Low-pass filters Q of relative degree two or higher, as G_n⁻¹ asks for."""


@dataclass(frozen=True)
class QFilter:
    """The low-pass filter Q of a disturbance observer, with unit gain at zero frequency.

    Parameters
    ----------
    name
        One of `Q_FILTERS`: ``binomialN`` is ``1/(τs + 1)^N`` with ``τ = 1/(2π·cutoff)``.
    cutoff
        Corner frequency [Hz].

    Raises
    ------
    FricError
        When the filter is not known or its cutoff is not positive.
    """

    name: str = "binomial2"
    cutoff: float = 60.0

    def __post_init__(self) -> None:
        if self.name not in Q_FILTERS:
            raise FricError(f"'{self.name}' is no Q-filter", mend=f"Known are {', '.join(Q_FILTERS)}.")
        if not self.cutoff > 0:
            raise FricError(f"the cutoff of Q is {self.cutoff:g} Hz", mend="Give a positive frequency.")

    def denominator(self) -> NDArray[np.float64]:
        """Return the denominator of Q in s, highest power first; the numerator is 1."""
        powers = np.arange(len(Q_FILTERS[self.name]))[::-1]
        return np.asarray(Q_FILTERS[self.name]) / (2 * pi * self.cutoff) ** powers

    def response(self, frequency: NDArray[np.float64]) -> NDArray[np.complex128]:
        """Return Q at the frequencies [Hz], shape (n,)."""
        return np.asarray(1.0 / np.polyval(self.denominator(), 2j * pi * np.asarray(frequency, float)))


@dataclass(frozen=True)
class DisturbanceObserver:
    """An observer of the disturbance at the plant's input, taken off the control voltage.

    ``d̂ = Q·(G_n⁻¹·z - u_t)`` with ``G_n = B/(s·(s + A))``.

    u_t is the control voltage without the friction feedforward: an observer that saw the feedforward would
    compensate the same friction a second time.

    Parameters
    ----------
    q
        The filter Q.
    A, B
        The nominal plant [1/s], [m/(s²·V)].
    """

    q: QFilter
    A: float
    B: float

    def inverse_numerator(self) -> NDArray[np.float64]:
        """Return the numerator of Q·G_n⁻¹ in s, ``(s² + A·s)/B``, over the denominator of Q."""
        return np.array([1.0, self.A, 0.0]) / self.B

"""Chance in a simulated run: a slow loop hunts from count to count, and what a run leaves is a draw.

A change of 1e-15 in the gain of a drive becomes a whole count of its encoder within a revolution at 10 mm/s. So what
such a run leaves is told of several, between which position 0 lies elsewhere between two counts (`Machine.placed`).
Runs that are compared are made at the same places.
"""

from dataclasses import dataclass
from math import inf

import numpy as np

PLACES = 5
"""Places between two counts at which a run that hangs on them is made: an odd number, so that the median is a run."""

SLOW = 0.03
"""Feed below which every run hangs on counts [m/s]."""

ACCURACY = 5e-9
"""By how much the integration of runs that hang on counts may move a position [m]; counts move it by ten times that."""

WIDTH = 4.2
"""Half of the interval over the standard deviation, for `PLACES` values."""


@dataclass(frozen=True)
class Chance:
    """A figure at each place: its median, and the interval in which 95 % of further runs lie.

    The median ± 4.2 standard deviations: around five normal values this holds 95 % of further ones with a confidence of
    90 %, and 98 % of them in the mean. It is a tolerance interval (Hahn and Meeker, Statistical Intervals, chapter 4),
    with the median as its centre.
    Least and largest of the five hold two of three.
    """

    values: tuple[float, ...]  # The figure at each place; one alone where it does not hang on counts
    least: float = -inf  # What it cannot be less than: 0 for a magnitude

    @property
    def median(self) -> float:
        """The median."""
        return float(np.median(self.values))

    @property
    def half(self) -> float:
        """Half of the interval; 0 for one value alone."""
        return WIDTH * float(np.std(self.values, ddof=1)) if len(self.values) > 1 else 0.0

    @property
    def low(self) -> float:
        """Lower end of the interval."""
        return max(self.median - self.half, self.least)

    @property
    def high(self) -> float:
        """Upper end of the interval."""
        return self.median + self.half

    def __sub__(self, other: "Chance") -> "Chance":
        """Return the difference, place by place; what does not hang on counts is the same at all."""
        return Chance(tuple(np.subtract(self.values, other.values).tolist()))

    def text(self, scale: float = 1e6, digits: int = 1) -> str:
        """Return the median as text, with half of the interval where that is more than the last digit: ``1.5±0.2``."""
        more = f"±{self.half * scale:.{digits}f}" if self.shown(scale, digits) else ""
        return f"{self.median * scale:.{digits}f}{more}"

    def shown(self, scale: float = 1e6, digits: int = 1) -> bool:
        """Tell whether half of the interval is more than the last digit that is written."""
        return self.half * scale >= 0.5 * 10**-digits

"""Drawing what is true from what was identified: an estimate with its 95 % interval."""

from __future__ import annotations

from collections.abc import Mapping
from math import exp, inf, log
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np

Intervals = Mapping[str, tuple[float, float]]
"""95 % intervals by the name of a parameter; ``negative.F_c`` of the negative direction, ``k_2`` of the second block."""

NORMAL_97_5 = 1.959963984540054
"""The 97.5 % quantile of the standard normal distribution."""


def draw_within(value: float, interval: tuple[float, float], lower: float, generator: np.random.Generator) -> float:
    """Draw a value whose median is the estimate and whose 2.5 and 97.5 % quantiles are the interval's limits.

    Half a normal distribution stands on either side of the estimate, each as wide as its side of the interval says:
    an interval need not be symmetric. A parameter that is positive by its nature, and whose interval is, is drawn so
    in its logarithm; of one whose interval passes its bound, what lies beyond is put on the bound.

    Parameters
    ----------
    value
        The estimate.
    interval
        Its 95 % interval, both limits finite, around the value.
    lower
        The parameter's lower bound; 0 where it is positive by its nature.
    generator
        Where randomness comes from.
    """
    low, high = interval
    z = float(generator.standard_normal()) / NORMAL_97_5
    if lower > -inf and low > 0:
        return value * exp(z * (log(high / value) if z > 0 else log(value / low)))
    return max(value + z * (high - value if z > 0 else value - low), lower)

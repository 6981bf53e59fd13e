"""Statistics that several rooms share."""

import numpy as np

from fric.arrays import Complex, Real

MAD_TO_SIGMA = 1.4826
"""Standard deviation over the median absolute deviation, of a normal distribution: ``1/Φ⁻¹(3/4)``."""


def robust_deviation(deviations: Real | Complex) -> float:
    """Return the standard deviation of a normal distribution with the median of these sizes, shape (n,)."""
    return MAD_TO_SIGMA * float(np.median(np.abs(deviations)))

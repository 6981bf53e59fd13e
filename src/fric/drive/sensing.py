"""What the controller sees of the motion: a quantised position, a filtered first difference."""

from dataclasses import dataclass
from math import inf, pi

import numpy as np

from fric.arrays import Real
from fric.kernels.elementary import exp
from fric.series import real
from fric.verb import require_within


@dataclass(frozen=True)
class Encoder:
    """A linear or rotary encoder that rounds the position to whole steps.

    resolution: One step [m or rad]; 0 for a position that is not quantised.
    place: Where position 0 lies between two counts [counts], from 0 to 1. No drive knows it
        (`fric.simulate.contour_run`).
    Raises FricError: When the resolution is negative, or the place is beyond a count.
    """

    resolution: float = 0.0
    place: float = 0.0

    def __post_init__(self) -> None:
        require_within(self, "the encoder", resolution="[0, inf)", place="[0, 1]")

    @property
    def shift(self) -> float:
        """Distance of its counts below whole steps [m or rad]."""
        return self.place * self.resolution

    def read(self, position: Real) -> Real:
        """Return the position as the encoder measures it [m], of the same shape."""
        position = real(position, "read", "position")
        if self.resolution == 0.0:
            return position
        return np.asarray(np.rint((position + self.shift) / self.resolution) * self.resolution - self.shift)


def low_pass_pole(corner: float, sampling: float) -> float:
    """Return the pole of the velocity filter ``v[n] = p·v[n-1] + (1 - p)·(z[n] - z[n-1])/T_s``.

    ``p = exp(-2π·corner/sampling)`` keeps the corner frequency [Hz] of the first-order low-pass.
    """
    return exp(-2 * pi * corner / sampling)


def low_passed(values: Real, corner: float, sampling: float) -> Real:
    """Return values, shape (n,), behind the low-pass of this pole, which has always been at the first of them."""
    if corner == inf:
        return values
    from scipy.signal import lfilter  # not at the start: a contour needs none

    pole = low_pass_pole(corner, sampling)
    return np.asarray(lfilter([1.0 - pole], [1.0, -pole], values, zi=[pole * values[0]])[0])

"""What a contour shows: the radial error of a circle, and its quadrant glitches."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi
from typing import TYPE_CHECKING

import numpy as np

from fric.errors import FricError

if TYPE_CHECKING:
    from numpy.typing import NDArray

QUADRANTS = ("+x", "+y", "-x", "-y")
"""The four reversals of a circle, by where they lie: at +x and -x the x axis turns, at +y and -y the y axis."""

WINDOW = pi / 6
"""Half the width of the window around a reversal in which its glitch is looked for [rad]."""


@dataclass(frozen=True)
class Circularity:
    """The radial error over one steady revolution.

    Parameters
    ----------
    angle
        Angle on the circle, from the +x axis [rad], in the order of the motion, shape (n,).
    error
        Radial error ``rho - radius`` [m], positive outwards, shape (n,).
    quadrants
        Glitch at +x, +y, -x and -y [m]: the signed peak of ``rho - median(rho)`` within 30° of the reversal.
    """

    angle: NDArray[np.float64]
    error: NDArray[np.float64]
    quadrants: tuple[float, float, float, float]

    @property
    def glitch(self) -> float:
        """The largest magnitude of the four glitches [m]."""
        return max(map(abs, self.quadrants))

    @property
    def rms(self) -> float:
        """Root mean square of the radial error [m]."""
        return float(np.sqrt(np.mean(self.error**2)))

    @property
    def range(self) -> float:
        """Largest less smallest radial error [m]."""
        return float(np.ptp(self.error))


def circularity(x: NDArray[np.float64], y: NDArray[np.float64], radius: float) -> Circularity:
    """Return the radial error and the quadrant glitches of the last whole revolution of a motion around the origin.

    The paper does not define the glitch. Here it is, for each quadrant, the peak with its sign of the radius less the
    median radius of the revolution, within 30° of the reversal: outwards is positive. The sign matters: friction that
    is compensated too much leaves an inward spike.

    Parameters
    ----------
    x, y
        Positions [m], each of shape (n,).
    radius
        Radius of the circle that was asked for [m].

    Raises
    ------
    FricError
        When the motion is no whole revolution.
    """
    angle = np.unwrap(np.arctan2(y, x))
    # The first sample of the last revolution: the latest from which the motion turns by 2π up to its end. A
    # revolution that ends on the very sample it began on may miss 2π by the tracking error.
    turned = np.abs(angle[-1] - angle)
    whole = np.flatnonzero(turned >= 2 * pi - 1e-3)
    if not len(whole):
        raise FricError(
            f"the motion covers {np.degrees(turned.max()):.0f}° of the circle, and a revolution is needed",
            mend="Give one revolution or more.",
        )
    last = slice(int(whole[-1]), None)
    angle, rho = angle[last], np.hypot(x[last], y[last])
    deviation = rho - np.median(rho)

    def peak(centre: float) -> float:
        near = deviation[np.abs((angle - centre + pi) % (2 * pi) - pi) <= WINDOW]
        return float(near[np.argmax(np.abs(near))])

    first, second, third, fourth = (peak(quarter * pi / 2) for quarter in range(4))
    return Circularity(angle, rho - radius, (first, second, third, fourth))

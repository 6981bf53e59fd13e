"""What of a circle repeats along an axis: a leadscrew's pitch, a scale's periods, balls that enter and leave."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

PERIODS = (1.5, 120.0)
"""Least and most periods on the diameter that are looked for."""
STANDS_OUT = 20.0
"""Times the median power that a line has to stand out."""


@dataclass(frozen=True)
class Periodic:
    """An error of position that repeats along one axis.

    Parameters
    ----------
    axis
        0 for the first axis of the circle, 1 for the second.
    pitch
        Length of a period [m].
    """

    axis: int
    pitch: float

    def columns(self, angle: NDArray[np.float64], radius: float) -> NDArray[np.float64]:
        """Return the radial deviation of a cosine and a sine of one metre along the axis, shape (n, 2)."""
        along = np.cos(angle) if self.axis == 0 else np.sin(angle)
        phase = 2 * pi / self.pitch * radius * along
        return np.column_stack([along * np.cos(phase), along * np.sin(phase)])


def periodic_errors(
    angle: NDArray[np.float64], rest: NDArray[np.float64], radius: float, most: int = 2
) -> list[Periodic]:
    """Return the lines that stand out of what geometry leaves of a circle, strongest first.

    Parameters
    ----------
    angle, rest
        Angle [rad] and what is left of the radial deviation [m] outside the glitches, shape (n,).
    radius
        Radius [m].
    most
        Lines an axis that are looked for.
    """
    found: list[Periodic] = []
    rest = rest - rest.mean()
    spacing = 2 * pi * radius / max(len(np.unique(np.round(angle % (2 * pi), 6))), 1)
    highest = min(PERIODS[1] / (2 * radius), 1 / (6 * spacing))
    frequencies = np.arange(PERIODS[0] / (2 * radius), highest, 1 / (16 * radius))
    if len(frequencies) < 16:
        return found
    for axis in (0, 1):
        left = rest
        for _ in range(most):
            power = np.array([_power(Periodic(axis, 1 / f), angle, left, radius) for f in frequencies])
            top = int(np.argmax(power))
            spread = float(np.median(power))
            if not power[top] > STANDS_OUT * spread or power[top] < 1e-30:
                break
            fine = frequencies[top] + np.linspace(-1, 1, 33) / (16 * radius)
            fine = fine[fine > 0]
            line = Periodic(axis, 1 / fine[np.argmax([_power(Periodic(axis, 1 / f), angle, left, radius) for f in fine])])
            found.append(line)
            columns = line.columns(angle, radius)
            left = left - columns @ np.linalg.lstsq(columns, left, rcond=None)[0]
    return found


def _power(line: Periodic, angle: NDArray[np.float64], rest: NDArray[np.float64], radius: float) -> float:
    """Return the sum of squares that a line explains."""
    columns = line.columns(angle, radius)
    gram, score = columns.T @ columns, columns.T @ rest
    return float(score @ np.linalg.solve(gram, score))

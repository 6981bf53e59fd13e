"""What of a circle repeats along an axis: a leadscrew's pitch, a scale's periods, balls that enter and leave."""

from dataclasses import dataclass
from math import pi

import numpy as np

from fric.arrays import Real

PERIODS = (2.5, 120.0)
"""Least and most periods on the diameter that are looked for."""
TOGETHER = 200_000
"""Samples times frequencies that are looked at together: what fits the cache."""
STANDS_OUT = 20.0
"""Times the median power that a line has to stand out."""


@dataclass(frozen=True)
class Periodic:
    """An error of position that repeats along one axis."""

    axis: int  # 0 for the first axis of the circle, 1 for the second
    pitch: float  # Length of a period [m]

    def columns(self, angle: Real, radius: float) -> Real:
        """Return the radial deviation of a cosine and a sine of one metre along the axis, shape (n, 2)."""
        along = np.cos(angle) if self.axis == 0 else np.sin(angle)
        phase = 2 * pi / self.pitch * radius * along
        return np.column_stack([along * np.cos(phase), along * np.sin(phase)])


def periodic_errors(angle: Real, rest: Real, geometry: Real, radius: float, most: int = 2) -> list[Periodic]:
    """Return the lines that stand out of what geometry leaves of a circle, strongest first.

    angle, rest: Angle [rad] and what is left of the radial deviation [m] outside the glitches, shape (n,).
    geometry: What was fitted to it, shape (n, p): a line is looked for in what these leave of it too.
    radius: Radius [m].
    most: Lines an axis that are looked for.
    """
    found: list[Periodic] = []
    spacing = 2 * pi * radius / max(len(np.unique(np.round(angle % (2 * pi), 6))), 1)
    highest = min(PERIODS[1] / (2 * radius), 1 / (6 * spacing))
    frequencies = np.arange(PERIODS[0] / (2 * radius), highest, 1 / (12 * radius))
    if len(frequencies) < 16:
        return found
    known = geometry
    for _ in range(2 * most):
        basis = np.linalg.qr(known)[0]
        left = rest - basis @ (basis.T @ rest)
        best: tuple[float, Periodic] | None = None
        for axis in (0, 1):
            power = _powers(axis, frequencies, angle, left, radius, basis)
            top = int(np.argmax(power))
            if power[top] > STANDS_OUT * float(np.median(power)) and (best is None or power[top] > best[0]):
                best = (power[top], Periodic(axis, 1 / _top(axis, frequencies[top], angle, left, radius, basis)))
        if best is None or best[0] < 1e-3 * float(rest @ rest) or best[0] < 1e-26:
            break
        found.append(best[1])
        known = np.column_stack([known, best[1].columns(angle, radius)])
    return found


def _top(axis: int, frequency: float, angle: Real, rest: Real, radius: float, basis: Real) -> float:
    """Return the frequency near one that explains most [1/m]."""
    span = 1 / (12 * radius)
    for _ in range(4):
        near = frequency + np.linspace(-span, span, 9)
        near = near[near > 0]
        frequency = float(near[np.argmax(_powers(axis, near, angle, rest, radius, basis))])
        span /= 4
    return frequency


def _powers(axis: int, frequencies: Real, angle: Real, rest: Real, radius: float, basis: Real) -> Real:
    """Return the sums of squares that lines of some frequencies [1/m] explain, beside what is known, shape (f,)."""
    along = np.cos(angle) if axis == 0 else np.sin(angle)
    found, at_once = [], max(TOGETHER // len(angle), 1)
    for start in range(0, len(frequencies), at_once):
        phase = np.outer(2 * pi * radius * along, frequencies[start : start + at_once])
        cosine, sine = along[:, np.newaxis] * np.cos(phase), along[:, np.newaxis] * np.sin(phase)
        cosine -= basis @ (basis.T @ cosine)
        sine -= basis @ (basis.T @ sine)
        cc, ss, cs = (np.einsum("nf,nf->f", a, b) for a, b in ((cosine, cosine), (sine, sine), (cosine, sine)))
        on_cosine, on_sine = rest @ cosine, rest @ sine
        little = 1e-12 * (cc + ss)
        cc, ss = cc + little, ss + little
        found.append((ss * on_cosine**2 - 2 * cs * on_cosine * on_sine + cc * on_sine**2) / (cc * ss - cs**2))
    return np.concatenate(found)

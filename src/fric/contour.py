"""Contour errors: the radial error of a circle with its quadrant glitches, the error of any path."""

from abc import ABC, abstractmethod
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from math import pi
from typing import ClassVar, NamedTuple

import numpy as np
from numpy.polynomial.polynomial import polyfit, polyval

from fric.arrays import Real
from fric.errors import FricError

QUADRANTS = ("+x", "+y", "-x", "-y")  # Reversals of a circle: of the x axis at +x and -x, of the y axis at +y and -y
WINDOW = pi / 6  # Half the width of the window around a reversal in which its glitch is looked for [rad]
SWINGS = 5  # Least number of swings about a smooth error that count as an oscillation


def of_axes(names: Sequence[str], known: Collection[str]) -> tuple[str, ...]:
    """Return the reversals of a circle, of `QUADRANTS`, that belong to known axes; its axes are ``names``."""
    return tuple(text for n, text in enumerate(QUADRANTS) if names[n % len(names)] in known)


def beside(name: str) -> tuple[str, str]:
    """Return the names of both axes of a circle if one is known: y is the second axis, any other name the first."""
    return ("x", "y") if name == "y" else (name, "y")


class Figures(NamedTuple):
    """The characteristic values of a contour error."""

    glitches: tuple[float, ...]  # m, signed, one a reversal
    rms: float  # m
    range: float  # m
    oscillation: float  # m, where no axis reverses; 0 where it is not known

    @property
    def glitch(self) -> float:
        """The largest magnitude of the glitches [m]; 0 where no axis reverses."""
        return max(map(abs, self.glitches), default=0.0)


class Judged(ABC):
    """The characteristic values of an error along a contour."""

    error: Real

    @property
    @abstractmethod
    def glitches(self) -> tuple[float, ...]:
        """The signed glitch at each reversal [m]."""

    @property
    def glitch(self) -> float:
        """The largest magnitude of the glitches [m]; 0 where no axis reverses."""
        return max(map(abs, self.glitches), default=0.0)

    @property
    def rms(self) -> float:
        """Root mean square of the error [m]."""
        return float(np.sqrt(np.mean(self.error**2)))

    @property
    def range(self) -> float:
        """Largest less smallest error [m]."""
        return float(np.ptp(self.error))


@dataclass(frozen=True)
class Circularity(Judged):
    """The radial error over one steady revolution."""

    angle: Real  # Angle on the circle, from the +x axis [rad], in the order of the motion, shape (n,)
    error: Real  # Radial error ``rho - radius`` [m], positive outwards, shape (n,)
    # Glitch at +x, +y, -x and -y [m]: the signed peak of ``rho - median(rho)`` within 30° of the reversal
    quadrants: tuple[float, float, float, float]

    @property
    def glitches(self) -> tuple[float, ...]:
        """The glitch at each quadrant [m]."""
        return self.quadrants

    @property
    def oscillation(self) -> float:
        """Largest distance of the radial error from a smooth curve half way between reversals, where it swings [m].

        There no axis reverses and friction is smooth: swings are due to encoder steps, waves of the guideway, or a
        limit cycle of the loop. The curve is a polynomial of fifth degree over 40°. Fewer than `SWINGS` swings between
        half the distance on either side are the tail of a reversal, and do not count.
        """
        found = 0.0
        for quarter in range(4):
            off = (self.angle - (quarter + 0.5) * pi / 2 + pi) % (2 * pi) - pi
            near = np.abs(off) <= pi / 9
            if int(near.sum()) > 20:
                left = self.error[near] - polyval(off[near], polyfit(off[near], self.error[near], 5))
                far = float(np.abs(left).max())
                if int(np.count_nonzero(np.diff(np.sign(left[np.abs(left) >= far / 2])))) >= SWINGS:
                    found = max(found, far)
        return found


def circularity(x: Real, y: Real, radius: float) -> Circularity:
    """Return the radial error and the quadrant glitches of the last whole revolution of a motion around the origin.

    The paper does not define the glitch. Here it is, for each quadrant, the peak with its sign of the radius less the
    median radius of the revolution, within 30° of the reversal: outwards is positive. The sign matters: friction that
    is compensated too much leaves an inward spike.

    x, y: Positions [m], each of shape (n,).
    """
    angle = np.arctan2(y, x)
    angle[1:] -= 2 * pi * np.cumsum(np.round(np.diff(angle) / (2 * pi)))  # unwrapped
    # The first sample of the last revolution: the latest from which the motion turns by 2π up to its end. A
    # revolution that ends on the very sample it began on may miss 2π by the tracking error.
    covered = np.abs(angle[-1] - angle)
    if not len(whole := np.flatnonzero(covered >= 2 * pi - 1e-3)):
        what = f"the motion covers {np.degrees(covered.max()):.0f}° of the circle, and a revolution is needed"
        raise FricError(what, hint="Give more revolutions, or a lower feed.")
    last = slice(int(whole[-1]), None)
    angle, rho = angle[last], np.hypot(x[last], y[last])
    deviation = rho - np.median(rho)

    def peak(centre: float) -> float:
        if not len(near := deviation[np.abs((angle - centre + pi) % (2 * pi) - pi) <= WINDOW]):
            hint = "Lower the feed, widen the circle, or sample more often."
            raise FricError(f"a revolution has {len(rho)} samples, and none near one of its reversals", hint=hint)
        return float(near[np.argmax(np.abs(near))])

    first, second, third, fourth = (peak(quarter * pi / 2) for quarter in range(4))
    return Circularity(angle, rho - radius, (first, second, third, fourth))


@dataclass(frozen=True)
class Reversal:
    """A place on a path where an axis reverses."""

    axis: int  # 0 for the first axis, 1 for the second
    x: float  # x, y: the place [m]
    y: float
    glitch: float  # Signed peak of the contour error less its median nearby [m]


@dataclass(frozen=True)
class ContourError(Judged):
    """The distance from a path, along it."""

    station: Real  # Distance travelled [m], shape (n,)
    error: Real  # Distance from the path [m], shape (n,): positive to the right, outwards if run counter-clockwise
    reversals: tuple[Reversal, ...]  # Where an axis reverses, in the order of the motion

    oscillation: ClassVar[float] = 0.0

    @property
    def glitches(self) -> tuple[float, ...]:
        """The glitch at each reversal [m]."""
        return tuple(reversal.glitch for reversal in self.reversals)


def contour_error(path: Real, velocity: Real, motion: Real, sampling: float) -> ContourError:
    """Return the distance of a motion from the path it was to follow, and the glitch at each reversal of an axis.

    The distance is taken along the normal of the path where the reference is; what that leaves out is the lag
    squared over twice the radius of curvature, a nanometre for 20 µm over 200 mm. A glitch is looked for while the
    path turns by 30° to either side of the reversal, and not beyond half way to the next: on a circle this is the
    quadrant glitch of `circularity`.

    path, velocity: Reference position [m] and velocity [m/s] of both axes, each of shape (n, 2), at a feed that is not
        zero.
    sampling: Samples a second [Hz].
    """
    feed = np.hypot(*velocity.T)
    station = np.concatenate([[0.0], np.cumsum((feed[1:] + feed[:-1]) / 2)]) / sampling
    tangent = velocity / feed[:, np.newaxis]
    off = motion - path
    error = off[:, 0] * tangent[:, 1] - off[:, 1] * tangent[:, 0]
    heading = np.unwrap(np.arctan2(velocity[:, 1], velocity[:, 0]))
    crossings = sorted((int(n), axis) for axis in (0, 1) for n in np.flatnonzero(np.diff(np.sign(velocity[:, axis]))))
    places = [n for n, _ in crossings]
    deviation = error - np.median(error)
    found = []
    for k, (n, axis) in enumerate(crossings):
        first = (places[k - 1] + n) // 2 if k else 0
        last = (n + places[k + 1]) // 2 if k + 1 < len(crossings) else len(error)
        beyond = np.abs(heading - heading[n]) > WINDOW
        first = max(first, int(np.flatnonzero(beyond[:n])[-1]) + 1 if beyond[:n].any() else 0)
        last = min(last, n + int(np.flatnonzero(beyond[n:])[0]) if beyond[n:].any() else len(error))
        near = deviation[first : max(last, first + 1)]
        found.append(Reversal(axis, float(path[n, 0]), float(path[n, 1]), float(near[np.argmax(np.abs(near))])))
    return ContourError(station, error, tuple(found))

"""The geometric part of a radial deviation: centre, scales, backlash, mismatch, squareness, pitch."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import inf, pi

import numpy as np
from scipy.special import stdtrit

from fric.arrays import Indices, Mask, Real
from fric.circles.measured import MeasuredCircle
from fric.circles.revolutions import Revolutions
from fric.contour import QUADRANTS
from fric.estimate import Estimate
from fric.identify.replay.replay_intervals import covariance_of

PERIODS = (2.5, 120.0)
"""Least and largest number of periods on the diameter to search."""
TOGETHER = 200_000
"""Samples times frequencies that are computed at once, to fit the cache."""
STANDS_OUT = 20.0
"""Least power of a significant line over the median power."""


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
    """Return the significant lines of a circle's residual without geometry, strongest first.

    angle, rest: Angle [rad] and residual radial deviation [m] outside the glitches, shape (n,).
    geometry: Columns that were fitted, shape (n, p): a line is fitted together with them.
    radius: Radius [m].
    most: Largest number of lines per axis.
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
    """Return the frequency near a given frequency that explains most of the residual [1/m]."""
    span = 1 / (12 * radius)
    for _ in range(4):
        near = frequency + np.linspace(-span, span, 9)
        near = near[near > 0]
        frequency = float(near[np.argmax(_powers(axis, near, angle, rest, radius, basis))])
        span /= 4
    return frequency


def _powers(axis: int, frequencies: Real, angle: Real, rest: Real, radius: float, basis: Real) -> Real:
    """Return the sums of squares that lines of some frequencies [1/m] explain besides known columns, shape (f,)."""
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


BEFORE, FIRST, LARGEST = np.radians(2.0), np.radians(30.0), np.radians(40.0)
"""Angles around a reversal that the geometry leaves out: before it, after it at first, after it at most [rad]."""
FADES = np.radians(np.geomspace(0.7, 14.0, 13))
"""Angles in which the tail of a glitch may fade to a third [rad]."""
STEPS = 6
"""Largest number of steps to fit the shape of the tails."""
MIDDLE = np.array([float(np.log(FADES).mean()), 0.0])
WITHIN = np.array([[np.log(FADES[0]), -0.5], [np.log(FADES[-1]), 1.0]])
SPREAD = np.array([np.log(FADES[-1] / FADES[0]) / np.sqrt(12.0), 0.3])
"""Prior standard deviations of ln λ and κ: λ is one of `FADES`, and no tail is far from an
exponential (that of two equal poles has κ = λ over its angle so far, 0.15 to 0.3)."""
MOST_FITTED = 10_000
"""Largest number of samples for the fit of the geometry; of more, means over neighbours are used."""


@dataclass(frozen=True)
class Geometry:
    """Geometry and pitch, fitted."""

    values: Real  # values, covariance: by the columns of `columns_of`, shape (p,), (p, p)
    covariance: Real
    freedom: int  # Degrees of freedom of the covariance
    lines: tuple[Periodic, ...]  # What repeats along an axis
    many: int  # many, both: how many tests there are, and whether in both directions
    both: bool
    fade: float  # fade, bend: λ [rad] and κ of the glitches' tails
    bend: float

    def model(self, tested: Revolutions, n: int) -> Real:
        """Return the explained part of a test, shape (n,) [m]."""
        return columns_of(tested, n, self.many, self.both, self.lines) @ self.values

    def error_at(self, tested: Revolutions, n: int, angle: float) -> float:
        """Return the standard error of the explained part at an angle [m]."""
        at = Revolutions(tested.test, np.array([angle]), np.zeros(1), np.zeros(1, np.intp), {})
        row = columns_of(at, n, self.many, self.both, self.lines)[0]
        return float(np.sqrt(max(row @ self.covariance @ row, 0.0)))

    def _quantity(self, n: int, unit: str, scale: float = 1.0, offset: float = 0.0) -> Estimate:
        half_width = float(stdtrit(max(self.freedom, 1), 0.975)) * float(np.sqrt(self.covariance[n, n])) * abs(scale)
        value = offset + scale * float(self.values[n])
        return Estimate.around(value, unit, half_width)

    def estimates(self, tests: Sequence[MeasuredCircle], both: bool) -> dict[str, Estimate]:
        """Return the geometry with its intervals."""
        names, radius, shared = tests[0].names, tests[0].radius, 2 * self.many
        found = {f"centre.{name}": self._quantity(n, "m") for n, name in enumerate(names)}
        found |= {f"scale.{name}": self._quantity(shared + n, "1", 1 / radius, 1.0) for n, name in enumerate(names)}
        found |= {f"backlash.{name}": self._quantity(shared + 2 + n, "m") for n, name in enumerate(names)}
        ellipse = self._quantity(shared + 4, "m")
        if both:
            return found | {"mismatch": ellipse, "squareness": self._quantity(shared + 5, "rad", -2 / radius)}
        if tests[0].instrument != "encoders":
            ellipse = Estimate(float(ellipse), "m", (-inf, inf))
        return found | {"mismatch": ellipse, "squareness": Estimate(0.0, "rad", (-inf, inf), assumed=True)}

    def amplitude(self, n: int) -> Estimate:
        """Return the amplitude of the periodic error along an axis [m]."""
        i = len(self.values) - 2 * len(self.lines) + 2 * n
        part, C = self.values[i : i + 2], self.covariance[i : i + 2, i : i + 2]
        size = float(np.hypot(*part))
        along = part / size if size > 0 else np.array([1.0, 0.0])
        half_width = float(stdtrit(max(self.freedom, 1), 0.975)) * float(np.sqrt(along @ C @ along))
        return Estimate(size, "m", (max(size - half_width, 0.0), size + half_width))


def columns_of(tested: Revolutions, n: int, many: int, both: bool, lines: Sequence[Periodic] = ()) -> Real:
    """Return the columns of `diagnose`'s table for one of its tests, shape (samples, parameters): pitch is last."""
    angle, s = tested.angle, float(tested.test.direction)
    cos, sin = np.cos(angle), np.sin(angle)
    centres = [column if k == n else np.zeros_like(angle) for k in range(many) for column in (cos, sin)]
    shared = [cos**2, sin**2, s / 2 * np.sign(sin) * cos, -s / 2 * np.sign(cos) * sin, s * np.sin(2 * angle)]
    pitch = [line.columns(angle, tested.test.radius) for line in lines]
    return np.column_stack([*centres, *shared, *([np.sin(2 * angle)] if both else []), *pitch])


def quiet(tested: Revolutions, behind: Mapping[str, float]) -> Mask:
    """Return the samples outside the glitches."""
    good = np.ones(len(tested.angle), bool)
    for n, name in enumerate(QUADRANTS):
        phi = (tested.test.direction * (tested.angle - n * pi / 2) + pi) % (2 * pi) - pi
        good &= (phi < -BEFORE) | (phi > behind[name])
    return good


def fit_geometry(
    tests: Sequence[Revolutions], behind: Sequence[Mapping[str, float]], lines: Sequence[Periodic], both: bool
) -> Geometry:
    """Return the geometry of one or two tests by least squares, fitted together with the tails of their glitches.

    tests: Revolutions of each test.
    behind: Per test and quadrant, up to what angle behind the reversal a glitch is left out [rad].
    lines: Periodic errors along an axis.
    both: Whether both directions were measured, which separates mismatch from squareness.
    """
    many = len(tests)
    every = -(-sum(len(test.angle) for test in tests) // MOST_FITTED)
    parts = [_means(test, np.flatnonzero(quiet(test, behind[n])), every) for n, test in enumerate(tests)]
    X = np.vstack([columns_of(one, n, many, both, lines) for n, (one, _) in enumerate(parts)])
    d = np.concatenate([circle.deviation for circle, _ in parts])
    p = X.shape[1]
    basis = np.linalg.qr(X)[0]
    beside = d - basis @ (basis.T @ d)

    def all_tails(fade: float, bend: float) -> Real:
        """Return tails and their derivatives to ln λ and κ, shape (3, n, 4·tests)."""
        tails = np.zeros((3, len(d), 4 * many))
        end = 0
        for n, (one, _) in enumerate(parts):
            tails[:, end : end + len(one.angle), 4 * n : 4 * n + 4] = tails_of(one, behind[n], fade, bend)
            end += len(one.angle)
        return tails

    def left(fade: float) -> float:
        """Return the residual sum of squares of geometry and exponential tails."""
        tails = all_tails(fade, 0.0)[0]
        tails -= basis @ (basis.T @ tails)
        gram, score = tails.T @ tails, tails.T @ beside
        gram += 1e-9 * (np.trace(gram) + 1e-300) * np.eye(len(gram))
        return float(beside @ beside - score @ np.linalg.solve(gram, score))

    shape = np.array([np.log(FADES[np.argmin([left(fade) for fade in FADES])]), 0.0])
    for _ in range(STEPS):
        tails, *slopes = all_tails(float(np.exp(shape[0])), shape[1])
        columns = np.hstack([X, tails])
        values, *_ = np.linalg.lstsq(columns, d, rcond=None)
        residual = d - columns @ values
        slope = np.column_stack([slope @ values[p:] for slope in slopes])
        moved, *_ = np.linalg.lstsq(columns, slope, rcond=None)
        projected = slope - columns @ moved
        known = float(residual @ residual) / len(d) * np.diag(SPREAD**-2)
        step = np.linalg.lstsq(
            projected.T @ projected + known, projected.T @ residual - known @ (shape - MIDDLE), rcond=None
        )[0]
        if np.abs(step).max() < 1e-3:
            break
        shape = np.clip(shape + np.clip(step, -0.3, 0.3), *WITHIN)
    if np.ptp(residual) <= 1e-12 * max(float(np.ptp(d)), 1e-15):
        covariance = np.zeros((p, p))
    else:
        lengths = [length for _, pieces in parts for length in pieces]
        covariance = covariance_of(columns, residual, lengths)
        for mode in (
            np.linalg.svd(projected * SPREAD, full_matrices=False)[2] * SPREAD
        ):  # orthogonal: their shares add up
            alone = projected @ mode
            information = 1.0 / covariance_of(alone[:, None], residual, lengths)[0, 0] if alone.any() else 0.0
            covariance += np.outer(moved @ mode, moved @ mode) / (information + 1.0)
    # the error of a tail's shape recurs at each reversal: so many segments are independent
    freedom = min(len(d) - p, sum(len(pieces) for _, pieces in parts) - 1)
    return Geometry(
        values[:p], covariance[:p, :p], freedom, tuple(lines), many, both, float(np.exp(shape[0])), float(shape[1])
    )


def _means(tested: Revolutions, used: Indices, every: int) -> tuple[Revolutions, list[int]]:
    """Return means over a number of neighbouring samples, and the lengths of the segments with these means."""
    segments = [part[: len(part) // every * every] for part in np.split(used, np.flatnonzero(np.diff(used) > 1) + 1)]
    segments = [part for part in segments if len(part)]
    index = np.concatenate(segments).reshape(-1, every)
    angle, deviation = tested.angle[index].mean(axis=1), tested.deviation[index].mean(axis=1)
    means = Revolutions(tested.test, angle, deviation, tested.revolution[index[:, 0]], {})
    return means, [len(part) // every for part in segments]


def tails_of(tested: Revolutions, behind: Mapping[str, float], fade: float, bend: float) -> Real:
    """Return the tails of the four glitches, each 1 where it begins, and derivatives to ln λ and κ, shape (3, n, 4)."""
    tails = []
    for n, name in enumerate(QUADRANTS):
        phi = (tested.test.direction * (tested.angle - n * pi / 2)) % (2 * pi)
        u = np.maximum(phi - behind[name], 0.0) / fade
        size = np.exp(-u) * np.cos(phi) * (phi > behind[name])
        tails.append([size * (1 + bend * u), size * u * (1 + bend * u - bend), size * u])
    return np.moveaxis(np.array(tails), 0, -1)

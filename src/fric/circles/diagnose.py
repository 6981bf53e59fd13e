"""A radial trace by causes: geometry, lag of the loops, backlash, friction at reversals, pitch, and the rest; and its
prediction.

Geometry is centre, scales, backlash, mismatch, squareness and pitch, fitted beside the tails of the glitches.
Where a machine file predicts the circle otherwise, the likely cause of the difference is named.
"""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import copysign, degrees, inf, log, pi
from typing import Any

import numpy as np
from scipy.optimize import linprog
from scipy.special import stdtrit

from fric.arrays import Indices, Mask, Real
from fric.circles.measured import MeasuredCircle, measured_from_run
from fric.circles.revolutions import Glitch, GlitchPulse, Revolutions, glitch_of, kick_of, pulses, revolutions
from fric.contour import QUADRANTS, of_axes
from fric.control.scheme import Scheme
from fric.errors import FricError
from fric.estimate import Estimate
from fric.flaws import circle
from fric.flaws.circle import MODEL_DISAGREES, PREDICTION_WITHOUT_INTERVAL
from fric.identify.replay.replay_fit import covariance_of
from fric.notice import Notice
from fric.records.resolution import lattice_step
from fric.simulate.contour_run import Circle, run_circle
from fric.simulate.machine import Machine
from fric.simulate.processes import Study
from fric.statistics import pair_power, rms
from fric.units import readable

PERIODS = (2.5, 120.0)  # Least and largest number of periods on the diameter to search
TOGETHER = 200_000  # Samples times frequencies that are computed at once, to fit the cache
STANDS_OUT = 20.0  # Least power of a significant line over the median power


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
    """Return the significant lines of a circle's residual without geometry, strongest first, some an axis at most.

    angle, rest: Angle [rad] and residual radial deviation [m] outside the glitches, shape (n,).
    geometry: Columns that were fitted, shape (n, p): a line is fitted together with them.
    """
    found: list[Periodic] = []
    spacing = 2 * pi * radius / max(len(np.unique(np.round(angle % (2 * pi), 6))), 1)
    highest = min(PERIODS[1] / (2 * radius), 1 / (6 * spacing))
    if len(frequencies := np.arange(PERIODS[0] / (2 * radius), highest, 1 / (12 * radius))) < 16:
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
                frequency, span = frequencies[top], 1 / (12 * radius)
                for _ in range(4):
                    near = frequency + np.linspace(-span, span, 9)
                    near = near[near > 0]
                    frequency = float(near[np.argmax(_powers(axis, near, angle, left, radius, basis))])
                    span /= 4
                best = (power[top], Periodic(axis, 1 / frequency))
        if best is None or best[0] < 1e-3 * float(rest @ rest) or best[0] < 1e-26:
            break
        found.append(best[1])
        known = np.column_stack([known, best[1].columns(angle, radius)])
    return found


def _powers(axis: int, frequencies: Real, angle: Real, rest: Real, radius: float, basis: Real) -> Real:
    """Return the sums of squares that lines of some frequencies [1/m] explain besides known columns, shape (f,)."""
    along = np.cos(angle) if axis == 0 else np.sin(angle)
    found, at_once = [], max(TOGETHER // len(angle), 1)
    for start in range(0, len(frequencies), at_once):
        phase = np.outer(2 * pi * radius * along, frequencies[start : start + at_once])
        columns = along[:, np.newaxis] * np.cos(phase), along[:, np.newaxis] * np.sin(phase)
        found.append(pair_power(columns, rest, basis))
    return np.concatenate(found)


BEFORE, FIRST, LARGEST = np.radians(2.0), np.radians(30.0), np.radians(40.0)
"""Angles around a reversal that the geometry leaves out: before it, after it at first, after it at most [rad]."""
RISES = 3e-3  # Speed of an axis [m/s] below which its friction rises before a reversal: the loop errs as by backlash
FADES = np.radians(np.geomspace(0.7, 14.0, 13))  # Angles in which the tail of a glitch may fade to a third [rad]
STEPS = 6  # Largest number of steps to fit the shape of the tails
MIDDLE = np.array([float(np.log(FADES).mean()), 0.0])
WITHIN = np.array([[np.log(FADES[0]), -0.5], [np.log(FADES[-1]), 1.0]])
SPREAD = np.array([np.log(FADES[-1] / FADES[0]) / np.sqrt(12.0), 0.3])
"""Prior standard deviations of ln λ and κ: λ is one of `FADES`, and no tail is far from an
exponential (that of two equal poles has κ = λ over its angle so far, 0.15 to 0.3)."""
MOST_FITTED, MANY = 10_000, 100_000
"""Most samples for the fit of the geometry, and for that of a lag, done at once: of more, means are used."""


@dataclass(frozen=True)
class Geometry:
    """Geometry and pitch, fitted."""

    values: Real  # values, covariance: by the columns of `columns_of`, shape (p,), (p, p)
    covariance: Real
    freedom: int  # Degrees of freedom of the covariance
    lines: tuple[Periodic, ...]  # What repeats along an axis
    many: int  # How many tests there are: two are of both directions
    fade: float  # fade, bend: λ [rad] and κ of the glitches' tails
    bend: float

    def model(self, tested: Revolutions, n: int) -> Real:
        """Return the explained part of a test, shape (n,) [m]."""
        parts = np.array_split(tested.angle, -(-len(tested.angle) // MANY))
        columns = (columns_of(replace(tested, angle=part), n, self.many, self.lines) for part in parts)
        return np.concatenate([part @ self.values for part in columns])

    def error_at(self, tested: Revolutions, n: int, angle: float) -> float:
        """Return the standard error of the explained part at an angle [m]."""
        at = Revolutions(tested.test, np.array([angle]), np.zeros(1), np.zeros(1, np.intp), {})
        row = columns_of(at, n, self.many, self.lines)[0]
        return float(np.sqrt(max(row @ self.covariance @ row, 0.0)))

    def _quantity(self, n: int, unit: str, scale: float = 1.0, offset: float = 0.0) -> Estimate:
        half_width = float(stdtrit(max(self.freedom, 1), 0.975)) * float(np.sqrt(self.covariance[n, n])) * abs(scale)
        return Estimate.around(offset + scale * float(self.values[n]), unit, half_width)

    def estimates(self, tests: Sequence[MeasuredCircle]) -> dict[str, Estimate]:
        """Return the geometry with its intervals."""
        names, radius, shared = tests[0].names, tests[0].radius, 2 * self.many
        found = {f"centre.{name}": self._quantity(n, "m") for n, name in enumerate(names)}
        found |= {f"scale.{name}": self._quantity(shared + n, "1", 1 / radius, 1.0) for n, name in enumerate(names)}
        found |= {f"backlash.{name}": self._quantity(shared + 2 + n, "m") for n, name in enumerate(names)}
        ellipse = self._quantity(shared + 4, "m")
        if self.many > 1:
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


def columns_of(tested: Revolutions, n: int, many: int, lines: Sequence[Periodic]) -> Real:
    """Return the columns of `diagnose`'s table for one of its tests, shape (samples, parameters): pitch is last."""
    angle, s = tested.angle, float(tested.test.direction)
    cos, sin = np.cos(angle), np.sin(angle)
    centres = [column if k == n else np.zeros_like(angle) for k in range(many) for column in (cos, sin)]
    shared = [cos**2, sin**2, s / 2 * np.sign(sin) * cos, -s / 2 * np.sign(cos) * sin, s * np.sin(2 * angle)]
    pitch = [line.columns(angle, tested.test.radius) for line in lines]
    return np.column_stack([*centres, *shared, *([np.sin(2 * angle)] if many > 1 else []), *pitch])


def quiet(tested: Revolutions, behind: Mapping[str, float]) -> Mask:
    """Return the samples outside the glitches, and outside the rise of friction before them."""
    before = np.clip(np.arcsin(min(RISES / tested.test.feed, 1.0)), BEFORE, 7.5 * BEFORE)
    good = np.ones(len(tested.angle), bool)
    for n, name in enumerate(QUADRANTS):
        phi = (tested.test.direction * (tested.angle - n * pi / 2) + pi) % (2 * pi) - pi
        good &= (phi < -before) | (phi > behind[name])
    return good


def fit_geometry(
    tests: Sequence[Revolutions], behind: Sequence[Mapping[str, float]], lines: Sequence[Periodic]
) -> Geometry:
    """Return the geometry of one or two tests by least squares, fitted together with the tails of their glitches.

    behind: Per test and quadrant, up to what angle behind the reversal a glitch is left out [rad].
    """
    many = len(tests)
    every = -(-sum(len(test.angle) for test in tests) // MOST_FITTED)
    parts = [_means(test, np.flatnonzero(quiet(test, behind[n])), every) for n, test in enumerate(tests)]
    X = np.vstack([columns_of(circle, n, many, lines) for n, (circle, _) in enumerate(parts)])
    d = np.concatenate([circle.deviation for circle, _ in parts])
    p = X.shape[1]
    basis = np.linalg.qr(X)[0]
    beside = d - basis @ (basis.T @ d)

    beyond, size = np.zeros((2, len(d), 4 * many))
    end = 0
    for n, (part, _) in enumerate(parts):
        block = slice(end, end := end + len(part.angle)), slice(4 * n, 4 * n + 4)
        beyond[block], size[block] = behind_of(part, behind[n])

    def left(fade: float) -> float:
        """Return the residual sum of squares of geometry and exponential tails."""
        tails = size * np.exp(-beyond / fade)
        tails -= basis @ (basis.T @ tails)
        gram, score = tails.T @ tails, tails.T @ beside
        gram += 1e-9 * (np.trace(gram) + 1e-300) * np.eye(len(gram))
        return float(beside @ beside - score @ np.linalg.solve(gram, score))

    shape = np.array([np.log(FADES[np.argmin([left(fade) for fade in FADES])]), 0.0])
    for _ in range(STEPS):
        tails, *slopes = tails_of(beyond, size, float(np.exp(shape[0])), shape[1])
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
        modes = np.linalg.svd(projected * SPREAD, full_matrices=False)[2] * SPREAD
        for mode in modes:  # orthogonal: their shares add up
            alone = projected @ mode
            information = 1.0 / covariance_of(alone[:, None], residual, lengths)[0, 0] if alone.any() else 0.0
            covariance += np.outer(moved @ mode, moved @ mode) / (information + 1.0)
    # the error of a tail's shape recurs at each reversal: so many segments are independent
    freedom = min(len(d) - p, sum(len(pieces) for _, pieces in parts) - 1)
    fade, bend = float(np.exp(shape[0])), float(shape[1])
    return Geometry(values[:p], covariance[:p, :p], freedom, tuple(lines), many, fade, bend)


def _means(tested: Revolutions, used: Indices, every: int) -> tuple[Revolutions, list[int]]:
    """Return means over a number of neighbouring samples, and the lengths of the segments with these means."""
    segments = [part[: len(part) // every * every] for part in np.split(used, np.flatnonzero(np.diff(used) > 1) + 1)]
    segments = [part for part in segments if len(part)]
    index = np.concatenate(segments).reshape(-1, every)
    angle, deviation = tested.angle[index].mean(axis=1), tested.deviation[index].mean(axis=1)
    means = Revolutions(tested.test, angle, deviation, tested.revolution[index[:, 0]], {})
    return means, [len(part) // every for part in segments]


def behind_of(tested: Revolutions, behind: Mapping[str, float]) -> tuple[Real, Real]:
    """Return how far samples are behind where the four tails begin [rad], and the tails' size, each (n, 4)."""
    phi = (tested.test.direction * (tested.angle[:, np.newaxis] - np.arange(4) * pi / 2)) % (2 * pi)
    begin = np.array([behind[name] for name in QUADRANTS])
    return np.maximum(phi - begin, 0.0), np.cos(phi) * (phi > begin)


def tails_of(beyond: Real, size: Real, fade: float, bend: float) -> tuple[Real, Real, Real]:
    """Return the tails of glitches, each 1 where it begins, and derivatives to ln λ and κ, each as `behind_of`."""
    u = beyond / fade
    tails, bent = size * np.exp(-u), 1 + bend * u
    return tails * bent, tails * u * (bent - bend), tails * u


BINS = 3600  # Number of parts of a turn: values are computed from their means, if the test has more samples


@dataclass(frozen=True)
class Iso230:
    """Characteristics of ISO 230-4 (2005), Section 3."""

    G: dict[int, float]  # By direction (1, -1): least radial separation of concentric circles that hold the path [m]
    G_b: float | None  # The same of both paths; None of one direction
    F_max: float  # Largest radial deviation from the nominal circle about the least-squares centre, over all paths [m]
    F_min: float  # Least radial deviation from it [m]
    D: float | None  # Mean radius of both paths less the nominal radius [m]; None of one direction


def minimum_zone(angle: Real, deviation: Real) -> float:
    """Return the least separation [m] of two concentric circles that hold a path near a circle.

    Radial deviations move with the centre by ``-(a·cos θ + b·sin θ)``, so that least separation is a linear programme;
    the neglected term is the shift squared over twice the radius, and the shift is the rest of the centre.

    angle, deviation: The path, as angle [rad] and radial deviation [m] from any circle around it, shape (n,).
    """
    centred, mean = around_its_centre(angle, deviation)
    if (scale := float(np.ptp(centred))) == 0.0:
        return 0.0
    centred -= mean  # which may be beyond all digits of the programme
    d, cos, sin, unity = centred / scale, np.cos(angle), np.sin(angle), np.ones_like(angle)
    # unknown: shift of the centre (a, b), inner and outer circle; inner ≤ d - a·cos - b·sin ≤ outer
    A = np.vstack([np.column_stack([-cos, -sin, 0 * unity, -unity]), np.column_stack([cos, sin, unity, 0 * unity])])
    found = linprog([0, 0, -1, 1], A_ub=A, b_ub=np.concatenate([-d, d]), bounds=[(None, None)] * 4, method="highs")
    inner, outer = np.asarray(found.x)[2:]
    return float(outer - inner) * scale


def around_its_centre(angle: Real, deviation: Real) -> tuple[Real, float]:
    """Return a radial deviation [m] around the least-squares centre of its path, and its mean [m]."""
    basis = np.column_stack([np.cos(angle), np.sin(angle), np.ones_like(angle)])
    a, b, mean = np.linalg.lstsq(basis, deviation, rcond=None)[0]
    return deviation - basis[:, :2] @ np.array([a, b]), float(mean)


def iso230(tests: Sequence[Revolutions]) -> Iso230:
    """Return the characteristics of ISO 230-4 of the mean paths of a test, or of both directions of a circle."""
    paths: dict[int, tuple[Real, Real, float]] = {}
    for tested in tests:
        bins = min(BINS, max(len(tested.angle) // tested.count, 8))
        angle, mean, _ = tested.averaged(bins)
        there = np.isfinite(mean)
        angle, mean = angle[there], mean[there]
        if tested.count == 1 and bins < BINS:  # one sample a part: the angle of the sample, not that of the part
            angle, mean = tested.angle % (2 * pi), tested.deviation
        centred, level = around_its_centre(angle, mean)
        paths[tested.test.direction] = (angle, centred, level)
    angles, deviations, levels = zip(*paths.values(), strict=True)
    both, angle, joint = len(paths) == 2, np.concatenate(angles), np.concatenate(deviations)
    return Iso230(
        {direction: minimum_zone(angle_, d) for direction, (angle_, d, _) in paths.items()},
        minimum_zone(angle, joint) if both else None, float(joint.max()), float(joint.min()),
        float(np.mean(levels)) if both else None,
    )  # fmt: skip


def lags(tests: Sequence[Revolutions], behind: Sequence[Mapping[str, float]], fit: Geometry) -> dict[str, Estimate]:
    """Return the time by which each axis is behind its reference [s], with its 95 % interval.

    The lag is the part of an axis' error that is proportional to its velocity, where no glitch peaks, beside a
    constant, scale, backlash and the tails of the glitches. Squareness has the same effect, with opposite signs in both
    directions: the mean over both is free of it, and with one direction the interval is open, except for the encoders
    of the axes, which do not see it.
    behind, fit: As in `fit_geometry`, and what it found, whose tails these have.
    """
    found = {}
    for n, name in enumerate(tests[0].test.names):
        if not all(name in test.errors for test in tests):
            continue
        each = (_lag(test, test.errors[name], n, ends, fit) for test, ends in zip(tests, behind, strict=True))
        values, errors, freedom = zip(*each, strict=True)
        value = float(np.mean(values))
        half_width = float(stdtrit(sum(freedom), 0.975)) * float(np.linalg.norm(errors)) / len(tests)
        if len(tests) == 1 and tests[0].test.instrument != "encoders":
            half_width = inf
        found[name] = Estimate.around(value, "s", half_width)
    return found


def _lag(
    tested: Revolutions, error: Real, axis: int, behind: Mapping[str, float], fit: Geometry
) -> tuple[float, float, int]:
    """Return a lag and its standard error [s], and the degrees of freedom of that."""
    used, every = np.flatnonzero(quiet(tested, behind)), -(-len(error) // MANY)
    part, segments = _means(replace(tested, deviation=error), used, every)
    along, error = part.angle - axis * pi / 2, part.deviation  # the axis moves as the cosine of this angle
    speed = -tested.test.direction * tested.test.feed * np.sin(along)
    beyond, size = behind_of(part, behind)
    tails, _, bent = tails_of(beyond, size, fit.fade, fit.bend)  # each bent by itself: one axis' share alone
    columns = np.column_stack([speed, np.ones(len(along)), np.cos(along), np.sign(speed), tails, bent])
    values, *_ = np.linalg.lstsq(columns, error, rcond=None)
    if np.ptp(residual := error - columns @ values) <= 1e-12 * max(float(np.ptp(error)), 1e-15):
        return float(values[0]), 0.0, 1
    return float(values[0]), float(covariance_of(columns, residual, segments)[0, 0]) ** 0.5, max(len(segments) - 1, 1)


def identifiability_warnings(
    circles: Sequence[Revolutions], geometry: Mapping[str, Estimate], behind: Sequence[Mapping[str, float]]
) -> tuple[Notice, ...]:
    """Return the warnings of tests: squareness, backlash, scale, scatter, glitches that do not end.

    behind: Per test and quadrant, up to what angle behind the reversal a glitch was seen [rad].
    """
    test, both, warnings = circles[0].test, len(circles) > 1, []
    ellipse = Estimate(abs(float(geometry["mismatch"])), "m")
    if test.instrument == "encoders":
        warnings.append(circle.SQUARENESS_UNSEEN.found(ellipse=None if both else ellipse))
    elif not both:
        warnings.append(circle.MISMATCH_OR_SQUARENESS.found(ellipse=ellipse, ball_bar=test.is_ball_bar))
    limits = {name: geometry[f"backlash.{name}"].limits for name in test.names}
    if moved := [name for name, (low, high) in limits.items() if not low <= 0.0 <= high]:
        warnings.append(circle.LOST_MOTION_CAUSE.found(axes=" and ".join(moved), reference=bool(circles[0].errors)))
    if test.is_ball_bar:
        warnings.append(circle.BALL_BAR_LENGTH.found())
    if min(circle.count for circle in circles) < 2:
        warnings.append(circle.ONE_REVOLUTION.found())
    if wide := sorted({name for of in behind for name, angle in of.items() if angle >= LARGEST - 1e-6}):
        warnings.append(circle.GLITCH_DOES_NOT_END.found(quadrants=wide, degrees=degrees(LARGEST)))
    return tuple(warnings)


ROUNDS = 4  # Number of iterations over the parts that glitches cover
SHARE = 2e-3  # Error of the tails of glitches over the largest glitch: no smaller periodic error is separable from it


@dataclass(frozen=True)
class Diagnosis:
    """What a circle test shows."""

    tests: tuple[Revolutions, ...]  # Whole revolutions of the test, or of both directions
    # By name: ``centre.AXIS`` [m], ``scale.AXIS`` [1], ``backlash.AXIS`` [m], ``mismatch`` [m], ``squareness`` [rad],
    # each with its 95 % interval; open where the test does not determine it
    geometry: Mapping[str, Estimate]
    lag: Mapping[str, Estimate]  # Time by which each axis is behind its reference [s], where it has one
    all_glitches: tuple[Mapping[str, Glitch], ...]  # Per test and quadrant
    periodic: tuple[tuple[Periodic, Estimate], ...]  # What repeats along an axis, with its amplitude [m]
    figures: Iso230  # Figures of ISO 230-4
    rest: float  # What geometry, glitches and pitch leave: its root mean square over parts of half a degree [m]
    scatter: float | None  # Its standard deviation between revolutions in such a part [m]; None of one revolution
    noise: float  # Noise of a sample [m]
    model: tuple[Real, ...]  # Radial deviation that geometry and pitch explain, per test, shape (n,) [m]
    warnings: tuple[Notice, ...] = field(default=())  # Warnings: what the test does not determine

    @property
    def test(self) -> MeasuredCircle:
        """The first circle test."""
        return self.tests[0].test

    @property
    def glitches(self) -> Mapping[str, Glitch]:
        """Glitches of the first test, by quadrant."""
        return self.all_glitches[0]

    @property
    def glitch(self) -> float:
        """The largest magnitude of the glitches [m]."""
        return max(abs(glitch.value) for glitch in self.glitches.values())

    def pulses(self, n: int = 0) -> dict[str, GlitchPulse]:
        """Return the deviation of a test around its reversals, less geometry and pitch."""
        return _pulses_of(self.tests[n], self.model[n])


def diagnose(tests: Sequence[MeasuredCircle]) -> Diagnosis:
    """Separate the causes in the radial trace of one circle test, or of both directions of one circle.

    To first order a radial deviation is a sum of the causes' effects at the angle θ, with s = 1 counter-clockwise:

    ============== ===================================================================================
    centre         ``a·cos θ + b·sin θ``
    scale          ``R·(m_x - 1)·cos²θ + R·(m_y - 1)·sin²θ``
    mismatch       ``s·e·sin 2θ`` with ``e = F·(τ_x - τ_y)/2``: the axes are behind by times τ, at the feed F
    squareness     ``-(R·β/2)·sin 2θ``, where the angle from +x to +y is 90° + β
    backlash       ``(s/2)·(b_x·sgn(sin θ)·cos θ - b_y·sgn(cos θ)·sin θ)``: a step that stays after a reversal
    pitch          along an axis ``cos θ·δ(R·cos θ)`` with δ of one period
    ============== ===================================================================================

    These are fitted where no glitch peaks: outside 2° before each reversal and as much behind it as the pulse there
    takes to fade to a twentieth. Its tail is fitted with them, ``c·(1 + κ·φ/λ)·exp(-φ/λ)·cos φ`` at the angle φ
    behind there, with one λ and one κ for all, whose errors are in every interval; else a long tail, or one of two
    equal poles, would pass for backlash. The rest is the glitch.

    tests: A circle test, or two of one radius and feed in both directions: these separate mismatch from squareness.
    Raises FricError: When there is no whole revolution, or the tests are not of one circle.
    """
    tested = tuple(revolutions(test) for test in tests)
    _require_one_circle(tests)
    radius, steps = tests[0].radius, tuple(map(_resolution, tests))
    behind = [dict.fromkeys(QUADRANTS, float(FIRST)) for _ in tests]
    lines: list[Periodic] = []
    fit = fit_geometry(tested, behind, lines)
    for _ in range(ROUNDS):
        tails = (_pulses_of(circle, fit.model(circle, n)) for n, circle in enumerate(tested))
        new = [{name: _covers(pulse) for name, pulse in each.items()} for each in tails]
        if not lines:
            lines = periodic_errors(*_outside(tested, fit, new), radius)
        settled = new == behind
        behind = new
        fit = fit_geometry(tested, behind, lines)
        if settled:
            break
    pulses = (p for n, circle in enumerate(tested) for p in _pulses_of(circle, fit.model(circle, n)).values())
    least = SHARE * max(float(np.abs(pulse.rest).max()) for pulse in pulses)
    sizes = [fit.amplitude(n) for n in range(len(lines))]
    seen = [line for line, size in zip(lines, sizes, strict=True) if float(size) > max(3 * size.half_width, least)]
    if len(seen) < len(lines):
        lines = seen
        fit = fit_geometry(tested, behind, lines)
    model = tuple(fit.model(circle, n) for n, circle in enumerate(tested))
    every = list(map(_pulses_of, tested, model))
    found = tuple(
        {
            name: glitch_of(pulse, radius, fit.error_at(circle, n, k * pi / 2 + circle.test.direction * 1e-3), steps[n])
            for k, (name, pulse) in enumerate(every[n].items())
        }
        for n, circle in enumerate(tested)
    )
    geometry = fit.estimates(tests)
    _, outside, _ = _outside(tested, fit, behind)
    apart = [rms(circle.averaged(min(720, max(len(circle.angle) // circle.count, 8)))[2]) for circle in tested]
    known = [value for value in apart if np.isfinite(value)]  # a single revolution shows none
    periodic = tuple((line, fit.amplitude(n)) for n, line in enumerate(lines))
    noise = float(np.median([pulse.noise() for of in every for pulse in of.values()]))
    rest = float(np.sqrt(np.mean(outside**2))) if len(outside) else 0.0
    notices = identifiability_warnings(tested, geometry, behind)
    kicks = [
        f"{name} {how}"
        for n, test in enumerate(tests)
        if not test.scheme  # one of the paper's is known, and a disturbance observer acts late by its nature
        for name, pulse in every[n].items()
        if (how := kick_of(pulse, test.feed / radius, steps[n]))
    ]
    notices += (circle.COMPENSATION_KICKS.found(quadrants=list(dict.fromkeys(kicks))),) if kicks else ()
    return Diagnosis(
        tested, geometry, lags(tested, behind, fit), found, periodic, iso230(tested), rest,
        float(np.mean(known)) if known else None, noise, model, notices,
    )  # fmt: skip


def both_directions(tests: Sequence[MeasuredCircle], feed: float | None = None) -> list[MeasuredCircle]:
    """Return the circle of some tests that is diagnosed, in both directions where both exist.

    feed: The feed [m/s]; where it is not given, the tests must be of one circle.
    """
    asked = [test for test in tests if feed is None or abs(test.feed / feed - 1) < 0.02]
    circles = {(float(f"{test.radius:.3g}"), float(f"{test.feed:.3g}")) for test in asked}
    text = ", ".join(f"{radius * 1e3:g} mm at {rate * 1e3:g} mm/s" for radius, rate in sorted(circles))
    if not asked:
        known = ", ".join(sorted({f"{test.feed * 1e3:g} mm/s" for test in tests}))
        raise FricError(f"there is no circle at {(feed or 0) * 1e3:g} mm/s", hint=f"Its circles are at {known}.")
    if len(circles) > 1:
        raise FricError(f"the tests are of several circles: {text}", hint="Say which, as in `feed='100 mm/s'`.")
    found: dict[int, MeasuredCircle] = {}
    for test in asked:
        found.setdefault(test.direction, test)
    return [found[direction] for direction in (1, -1) if direction in found]


def _require_one_circle(tests: Sequence[MeasuredCircle]) -> None:
    if len(tests) > 2 or (len(tests) == 2 and tests[0].direction == tests[1].direction):
        raise FricError(
            f"{len(tests)} tests are not the two directions of one circle",
            where=tests[0].where, hint="Give one test, or one counter-clockwise and one clockwise.",
        )  # fmt: skip
    first = tests[0]
    for other in tests[1:]:
        if abs(other.radius / first.radius - 1) > 1e-3 or abs(other.feed / first.feed - 1) > 1e-2:
            raise FricError(
                f"is of {other.radius * 1e3:g} mm at {other.feed * 1e3:g} mm/s, and the other direction of "
                f"{first.radius * 1e3:g} mm at {first.feed * 1e3:g} mm/s",
                where=other.where, hint="Give both directions of one circle at one feed.",
            )  # fmt: skip


def _pulses_of(tested: Revolutions, model: Real) -> dict[str, GlitchPulse]:
    return pulses(tested.angle, tested.deviation - model, tested.revolution, tested.test.direction)


def _covers(pulse: GlitchPulse) -> float:
    """Return the largest angle behind the reversal at which a pulse is visible [rad]."""
    width = np.radians(1.0)
    phi, mean = pulse.smoothed(width)
    error = pulse.noise() / np.sqrt(max(len(pulse.phi) * width / (pi / 2), 1.0))
    if not len(behind := np.flatnonzero(phi > -BEFORE)):
        return float(FIRST)
    top = behind[np.argmax(np.abs(mean[behind]))]
    low = np.flatnonzero(np.abs(mean[top:]) < max(4.0 * error, 0.05 * abs(mean[top])))
    end = phi[top + low[0]] if len(low) else LARGEST
    return float(np.clip(np.round(end + BEFORE, 3), np.radians(5.0), LARGEST))


def _outside(
    tests: Sequence[Revolutions], fit: Geometry, behind: Sequence[Mapping[str, float]]
) -> tuple[Real, Real, Real]:
    """Return angle, residual deviation, and the columns of the fit: means over parts where no glitch is."""
    angles, rests, columns = [], [], []
    for n, test in enumerate(tests):
        rest = Revolutions(test.test, test.angle, test.deviation - fit.model(test, n), test.revolution, {})
        angle, mean, _ = rest.averaged(min(1440, max(len(test.angle) // test.count // 2, 8)))
        centre = Revolutions(test.test, angle, mean, np.zeros(len(angle), np.intp), {})
        clear = {name: min(end + 3 * fit.fade, 1.4) for name, end in behind[n].items()}
        good = quiet(centre, clear) & np.isfinite(mean)
        angles.append(angle[good])
        rests.append(mean[good])
        columns.append(columns_of(centre, n, fit.many, fit.lines)[good])
    return np.concatenate(angles), np.concatenate(rests), np.vstack(columns)


def _resolution(test: MeasuredCircle) -> float:
    """Return the coarser encoder step of the record [m]; 0 if none is visible."""
    if test.is_ball_bar:
        assert test.deviation is not None
        return lattice_step(test.deviation) or 0.0
    return max(lattice_step(test.axis(name).position) or 0.0 for name in test.names)


DRAWS = 24  # Machines that are drawn from the intervals of a machine file
CAUSES = {  # The sentence of a disagreement, by what differs
    "level": "the whole level: friction, K_f or a gain differs",
    "width": "the width: the stiffness before sliding differs",
    "place": "the place: the delay differs",
    "sign": "the sign: gravity, or the direction of the axis",
    "backlash": "motion is lost at the reversal: backlash",
}
BACKLASH = 0.3  # Share of a measured glitch from which a reversal error that is not predicted is its likely cause
WIDE = 0.5  # Share of a predicted glitch from which its interval is wide


@dataclass(frozen=True)
class Agreement:
    """A prediction compared with the measurement."""

    predicted: Diagnosis  # The diagnosis of the simulated circle
    intervals: Mapping[str, tuple[float, float]] | None  # 95 % interval of the predicted glitches [m], by quadrant
    agrees: Mapping[str, bool]  # By quadrant of an axis that is known, whether measured and predicted intervals meet
    causes: Mapping[str, str]  # By quadrant that does not agree, a key of `CAUSES`
    scheme: str  # The scheme that was simulated
    warnings: tuple[Notice, ...]  # Warnings

    @property
    def all_agree(self) -> bool:
        """Whether every quadrant agrees."""
        return all(self.agrees.values())

    @property
    def said(self) -> str:
        """Whether it agrees, in words: with the interval of the largest glitch where that is wide."""
        if not self.all_agree or not self.intervals:
            return "agrees" if self.all_agree else "differs"
        name = max(self.agrees, key=lambda name: abs(self.predicted.glitches[name].value))
        size, limits = self.predicted.glitches[name].value, self.intervals[name]
        low, high = sorted(copysign(limit, limit * size) for limit in limits)  # of the size, as it is printed beside
        wide = high - low > WIDE * abs(size)
        return "agrees" + wide * f" with a wide interval, {readable(low, 'm', 2)} to {readable(high, 'm', 2)}"


def predict(
    measured: Diagnosis, machine: Machine, scheme: Scheme, known: Mapping[str, Any] | None = None,
    done: Callable[[], object] = lambda: None,
) -> tuple[Diagnosis, dict[str, tuple[float, float]] | None]:  # fmt: skip
    """Return the prediction of a machine for the measured circle, with the range of its glitches.

    The interval is that of machines drawn from the uncertainty of the identified machine, widened by an encoder step.

    known: The distribution of machines, as arguments of `Study`; None if the machine file has no intervals.
    """
    test = measured.test
    circle = Circle(test.radius, test.feed, 2, test.direction)
    run = run_circle(machine, scheme, circle, schemes=4)  # as many: the measured circle and both diagnoses are kept
    found = diagnose([measured.tests[0].beside(measured_from_run(run), run.traces)])
    done()
    if not known:
        return found, None
    study, drawn = Study(machine, (scheme,), circle, accuracy=1e-8, **known), []
    for n in range(DRAWS):
        quadrants = study(n).quadrants[0]
        if np.isfinite(quadrants).all():  # else it is not stable, or needs more voltage than there is
            drawn.append(quadrants)
        done()
    if len(drawn) < DRAWS // 2:
        return found, None
    around = np.quantile(np.array(drawn), [0.025, 0.975], axis=0) - np.array(run.circularity.quadrants)
    # quantiles of so few draws lie too near: a tenth of their distance is added to either side
    around += np.outer([-0.1, 0.1], np.ptp(around, axis=0))
    step = max(machine.axes[name].encoder.resolution for name in run.traces)
    limits = {
        name: (found.glitches[name].value + min(float(low), 0.0) - step,
               found.glitches[name].value + max(float(high), 0.0) + step)
        for name, low, high in zip(QUADRANTS, *around, strict=True)
    }  # fmt: skip
    return found, limits


def agreement(
    measured: Diagnosis, predicted: Diagnosis, intervals: Mapping[str, tuple[float, float]] | None, scheme: str,
    step: float = 0.0, known: Collection[str] = ("x", "y"),
) -> Agreement:  # fmt: skip
    """Compare a prediction with the measurement, quadrant by quadrant, and name the likely cause of a difference.

    intervals: Interval of each predicted glitch [m]; None where there is none.
    step: An encoder step [m], the tolerance of a prediction without interval.
    known: Names of the machine's axes: reversals of other axes are not predicted.
    """
    agrees, causes = {}, {}
    pulses, other = measured.pulses(), predicted.pulses()
    for name in of_axes(measured.test.names, known):
        found, said = measured.glitches[name], predicted.glitches[name]
        low, high = intervals[name] if intervals else (said.ci95[0] - step, said.ci95[1] + step)
        agrees[name] = found.ci95[0] <= high and found.ci95[1] >= low
        if not agrees[name]:
            lost, foreseen = (
                of.geometry[f"backlash.{of.test.names['xy'.index(name[1:])]}"] for of in (measured, predicted)
            )
            more = abs(float(lost)) - abs(float(foreseen))
            backlash = more > max(BACKLASH * abs(found.value), 2.0 * (lost.half_width + foreseen.half_width))
            causes[name] = "backlash" if backlash else _cause(found, said, pulses[name], other[name])
    warnings = [PREDICTION_WITHOUT_INTERVAL.found()] if intervals is None else []
    if causes:
        words = "; ".join(
            f"{name} {measured.glitches[name].value * 1e6:+.1f} µm measured, "
            f"{predicted.glitches[name].value * 1e6:+.1f} µm predicted ({CAUSES[cause]})"
            for name, cause in causes.items()
        )
        warnings.append(MODEL_DISAGREES.found(glitches=words))
    return Agreement(predicted, intervals, agrees, causes, scheme, tuple(warnings))


def _cause(found: Glitch, said: Glitch, pulse: GlitchPulse, other: GlitchPulse) -> str:
    """Return what differs most between two pulses: sign, level, width or place, by the largest of |ln g|, |ln w| and
    the shift in half widths, with the measured pulse ``g·p((φ - d)/w)`` of the predicted p.
    """
    small, large = sorted(map(abs, (found.value, said.value)))
    if found.value * said.value < 0 and small > 0.25 * large:
        return "sign"
    width = np.radians(0.5)
    grid = np.radians(np.arange(-10.0, 30.0, 0.25))
    seen, (phi, mean) = np.interp(grid, *pulse.smoothed(width)), other.smoothed(width)
    best = (np.inf, 1.0, 1.0, 0.0)
    top = int(np.argmax(np.abs(mean)))
    below = np.flatnonzero(np.abs(mean) <= np.abs(mean[top]) / 2)
    left, right = below[below < top].max(initial=-1) + 1, below[below > top].min(initial=len(mean)) - 1
    half = max(np.radians(1.0), float(phi[right] - phi[left]))
    for w in np.geomspace(0.3, 3.0, 25):
        for d in np.linspace(-1.5, 1.5, 25) * half:
            p = np.interp((grid - d) / w, phi, mean, left=0.0, right=0.0)
            g = float(p @ seen) / power if (power := float(p @ p)) > 0 else 0.0
            cost = float(np.sum((seen - g * p) ** 2)) * (1 + 1e-3 * (log(w) ** 2 + (d / half) ** 2))
            best = min(best, (cost, g, w, d / half), key=lambda candidate: candidate[0])
    _, g, w, d = best
    sizes = {"level": abs(log(max(abs(g), 1e-3))), "width": abs(log(w)), "place": abs(d)}
    return max(sizes, key=lambda name: sizes[name])

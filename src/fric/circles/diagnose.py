"""A radial trace by causes: geometry, lag of the loops, backlash, friction at reversals, pitch, and the rest."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import degrees, inf, pi

import numpy as np
from scipy.optimize import linprog
from scipy.special import stdtrit

from fric.arrays import Real
from fric.circles.geometry import (
    BEFORE,
    FIRST,
    LARGEST,
    Geometry,
    Periodic,
    columns_of,
    fit_geometry,
    periodic_errors,
    quiet,
    tails_of,
)
from fric.circles.glitches import Glitch, GlitchPulse, glitch_of, kick_of, noise_of, pulses, smoothed
from fric.circles.measured import MeasuredCircle
from fric.circles.revolutions import Revolutions, revolutions
from fric.contour import QUADRANTS
from fric.errors import FricError
from fric.estimate import Estimate
from fric.flaws import circle
from fric.identify.replay.replay_intervals import covariance_of
from fric.notice import Notice
from fric.records.resolution import lattice_step

BINS = 3600
"""Number of parts of a turn: values are computed from their means, if the test has more samples."""


@dataclass(frozen=True)
class Iso230:
    """Characteristics of ISO 230-4 (2005), Section 3."""

    # Circular deviation of each direction of turning, by 1 and -1: least radial separation of two concentric circles
    # that hold the path [m]
    G: dict[int, float]
    # Bidirectional circular deviation: of two circles that hold both paths [m]; None of one direction
    G_b: float | None
    # F_max, F_min: largest and least radial deviation from the nominal circle around the least-squares centre of the
    # path, over all paths [m], positive outwards
    F_max: float
    F_min: float
    # Mean bidirectional radial deviation: mean radius of both paths less the nominal radius [m]; None of one direction
    D: float | None


def minimum_zone(angle: Real, deviation: Real) -> float:
    """Return the least separation [m] of two concentric circles that hold a path near a circle.

    Radial deviations move with the centre by ``-(a·cos θ + b·sin θ)``, so that least separation is a linear programme;
    the neglected term is the shift squared over twice the radius, and the shift is the rest of the centre.

    angle, deviation: The path, as angle [rad] and radial deviation [m] from any circle around it, shape (n,).
    """
    centred, _ = around_its_centre(angle, deviation)
    scale = float(np.ptp(centred))
    if scale == 0.0:
        return 0.0
    d, cos, sin, one = centred / scale, np.cos(angle), np.sin(angle), np.ones_like(angle)
    # unknown: shift of the centre (a, b), inner and outer circle; inner ≤ d - a·cos - b·sin ≤ outer
    A = np.vstack([np.column_stack([-cos, -sin, 0 * one, -one]), np.column_stack([cos, sin, one, 0 * one])])
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

    tests: Revolutions of each test; an axis without reference has no lag.
    behind: Per test and quadrant, up to what angle behind the reversal a glitch is left out [rad].
    fit: The geometry, whose tails these have.
    """
    found = {}
    for n, name in enumerate(tests[0].test.names):
        if not all(name in test.errors for test in tests):
            continue
        values, errors, freedom = zip(
            *(_lag(test, test.errors[name], n, ends, fit) for test, ends in zip(tests, behind, strict=True)),
            strict=True,
        )
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
    used = np.flatnonzero(quiet(tested, behind))
    along = tested.angle[used] - axis * pi / 2  # the axis moves as the cosine of this
    speed = -tested.test.direction * tested.test.feed * np.sin(along)
    tails, _, bent = tails_of(tested, behind, fit.fade, fit.bend)[:, used]  # each bent by itself: one axis' share alone
    columns = np.column_stack([speed, np.ones(len(used)), np.cos(along), np.sign(speed), tails, bent])
    values, *_ = np.linalg.lstsq(columns, error[used], rcond=None)
    segments = [len(array) for array in np.split(used, np.flatnonzero(np.diff(used) > 1) + 1)]
    residual = error[used] - columns @ values
    if np.ptp(residual) <= 1e-12 * max(float(np.ptp(error)), 1e-15):
        return float(values[0]), 0.0, 1
    variance = float(covariance_of(columns, residual, segments)[0, 0])
    return float(values[0]), variance**0.5, max(len(segments) - 1, 1)


def identifiability_warnings(
    tests: Sequence[MeasuredCircle],
    circles: Sequence[Revolutions],
    geometry: Mapping[str, Estimate],
    both: bool,
    behind: Sequence[Mapping[str, float]],
    largest: float,
) -> tuple[Notice, ...]:
    """Return the warnings of the tests: squareness, backlash, scale, scatter, glitches that do not end.

    tests, circles: The tests, and their revolutions.
    geometry: What was fitted.
    both: Whether both directions were measured.
    behind: Per test and quadrant, up to what angle behind the reversal a glitch was seen [rad].
    largest: Up to what angle it was looked for [rad].
    """
    test, warnings, ellipse = tests[0], [], Estimate(abs(float(geometry["mismatch"])), "m")
    if test.instrument == "encoders":
        warnings.append(circle.SQUARENESS_UNSEEN.found(ellipse=None if both else ellipse))
    elif not both:
        warnings.append(circle.MISMATCH_OR_SQUARENESS.found(ellipse=ellipse, ball_bar=test.is_ball_bar))
    moved = [name for name in test.names if not _holds_zero(geometry[f"backlash.{name}"])]
    if moved:
        warnings.append(circle.LOST_MOTION_CAUSE.found(axes=" and ".join(moved), reference=bool(circles[0].errors)))
    if test.is_ball_bar:
        warnings.append(circle.BALL_BAR_LENGTH.found())
    if min(circle.count for circle in circles) < 2:
        warnings.append(circle.ONE_REVOLUTION.found())
    wide = sorted({name for of in behind for name, angle in of.items() if angle >= largest - 1e-6})
    if wide:
        warnings.append(circle.GLITCH_DOES_NOT_END.found(quadrants=wide, degrees=degrees(largest)))
    return tuple(warnings)


def _holds_zero(estimate: Estimate) -> bool:
    limits = np.ravel(estimate.ci95 if estimate.ci95 is not None else (-np.inf, np.inf))
    return bool(limits.min() <= 0.0 <= limits.max())


ROUNDS = 4
"""Number of iterations over the parts that glitches cover."""
SHARE = 2e-3
"""Error of the tails of glitches over the largest glitch: a smaller periodic error is not separable from it."""


@dataclass(frozen=True)
class Diagnosis:
    """What a circle test shows."""

    tests: tuple[Revolutions, ...]  # Whole revolutions of the test, or of both directions
    # By name: ``centre.AXIS`` [m], ``scale.AXIS`` [1], ``backlash.AXIS`` [m], ``mismatch`` [m], ``squareness`` [rad],
    # each with its 95 % interval; open where the test does not determine it
    geometry: Mapping[str, Estimate]
    # Time by which each axis is behind its reference [s], with its 95 % interval; none of an axis without reference
    lag: Mapping[str, Estimate]
    all_glitches: tuple[Mapping[str, Glitch], ...]  # Per test and quadrant
    periodic: tuple[tuple[Periodic, Estimate], ...]  # What repeats along an axis, with its amplitude [m]
    figures: Iso230  # Figures of ISO 230-4
    # rest, scatter, noise: what geometry, glitches and pitch leave: its root mean square [m] over parts of half a
    # degree; the standard deviation between revolutions in such a part, None of one revolution; noise of a sample [m]
    rest: float
    scatter: float | None
    noise: float
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
        tested = self.tests[n]
        return pulses(tested.angle, tested.deviation - self.model[n], tested.revolution, tested.test.direction)


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
    radius, both = tests[0].radius, len(tests) > 1
    steps = tuple(_resolution(test) for test in tests)
    behind = [dict.fromkeys(QUADRANTS, float(FIRST)) for _ in tests]
    lines: list[Periodic] = []
    fit = fit_geometry(tested, behind, lines, both)
    for _ in range(ROUNDS):
        new = [
            {name: _covers(pulse) for name, pulse in _pulses_of(circle, fit, n).items()}
            for n, circle in enumerate(tested)
        ]
        if not lines:
            lines = periodic_errors(*_outside(tested, fit, new), radius)
        settled = new == behind
        behind = new
        fit = fit_geometry(tested, behind, lines, both)
        if settled:
            break
    least = SHARE * max(
        float(np.abs(pulse.rest).max())
        for n, circle in enumerate(tested)
        for pulse in _pulses_of(circle, fit, n).values()
    )
    seen = [line for n, line in enumerate(lines) if _is_seen(fit.amplitude(n), least)]
    if len(seen) < len(lines):
        lines = seen
        fit = fit_geometry(tested, behind, lines, both)
    found = tuple(_glitches(circle, fit, n, radius, steps[n]) for n, circle in enumerate(tested))
    geometry = fit.estimates(tests, both)
    _, outside, _ = _outside(tested, fit, behind)
    known = [value for value in map(_scatter, tested) if value is not None]
    periodic = tuple((line, fit.amplitude(n)) for n, line in enumerate(lines))
    noises = [noise_of(pulse) for n, circle in enumerate(tested) for pulse in _pulses_of(circle, fit, n).values()]
    noise = float(np.median(noises))
    rest = float(np.sqrt(np.mean(outside**2))) if len(outside) else 0.0
    notices = identifiability_warnings(tests, tested, geometry, both, behind, float(LARGEST))
    kicks = [
        f"{name} {how}"
        for n, test in enumerate(tested)
        if not test.test.scheme  # one of the paper's is known, and a disturbance observer acts late by its nature
        for name, pulse in _pulses_of(test, fit, n).items()
        if (how := kick_of(pulse, test.test.feed / radius, steps[n]))
    ]
    notices += (circle.COMPENSATION_KICKS.found(quadrants=list(dict.fromkeys(kicks))),) if kicks else ()
    return Diagnosis(
        tested, geometry, lags(tested, behind, fit), found, periodic, iso230(tested), rest,
        float(np.mean(known)) if known else None, noise, tuple(fit.model(circle, n) for n, circle in enumerate(tested)),
        notices,
    )  # fmt: skip


def _is_seen(amplitude: Estimate, least: float) -> bool:
    """Return whether an amplitude exceeds three half-widths of its interval, and a lower limit [m]."""
    assert isinstance(amplitude.ci95, tuple)
    return float(amplitude) > max(3 * (float(np.max(amplitude.ci95)) - float(amplitude)), least)


def both_directions(tests: Sequence[MeasuredCircle], feed: float | None = None) -> list[MeasuredCircle]:
    """Return the circle of some tests that is diagnosed, in both directions where both exist.

    feed: The feed [m/s]; where it is not given, the tests must be of one circle.
    Raises FricError: When there is none at that feed, or several circles and no feed is given.
    """
    asked = [test for test in tests if feed is None or abs(test.feed / feed - 1) < 0.02]
    circles = {(float(f"{test.radius:.3g}"), float(f"{test.feed:.3g}")) for test in asked}
    text = ", ".join(f"{radius * 1e3:g} mm at {rate * 1e3:g} mm/s" for radius, rate in sorted(circles))
    if not asked:
        known = ", ".join(sorted({f"{test.feed * 1e3:g} mm/s" for test in tests}))
        raise FricError(f"there is no circle at {(feed or 0) * 1e3:g} mm/s", hint=f"There are {known}.")
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


def _pulses_of(tested: Revolutions, fit: Geometry, n: int) -> dict[str, GlitchPulse]:
    return pulses(tested.angle, tested.deviation - fit.model(tested, n), tested.revolution, tested.test.direction)


def _covers(pulse: GlitchPulse) -> float:
    """Return the largest angle behind the reversal at which a pulse is visible [rad]."""
    width = np.radians(1.0)
    phi, mean = smoothed(pulse, width)
    error = noise_of(pulse) / np.sqrt(max(len(pulse.phi) * width / (pi / 2), 1.0))
    behind = np.flatnonzero(phi > -BEFORE)
    if not len(behind):
        return float(FIRST)
    top = behind[np.argmax(np.abs(mean[behind]))]
    level = max(4.0 * error, 0.05 * abs(mean[top]))
    low = np.flatnonzero(np.abs(mean[top:]) < level)
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
        columns.append(columns_of(centre, n, fit.many, fit.both, fit.lines)[good])
    return np.concatenate(angles), np.concatenate(rests), np.vstack(columns)


def _scatter(tested: Revolutions) -> float | None:
    _, _, scatter = tested.averaged(min(720, max(len(tested.angle) // tested.count, 8)))
    known = scatter[np.isfinite(scatter)]
    return float(np.sqrt(np.mean(known**2))) if len(known) else None


def _glitches(tested: Revolutions, fit: Geometry, n: int, radius: float, step: float) -> dict[str, Glitch]:
    found = {}
    for k, (name, pulse) in enumerate(_pulses_of(tested, fit, n).items()):
        base = fit.error_at(tested, n, k * pi / 2 + tested.test.direction * 1e-3)
        found[name] = glitch_of(pulse, radius, base, step)
    return found


def _resolution(test: MeasuredCircle) -> float:
    """Return the coarser encoder step of the record [m]; 0 if none is visible."""
    if test.is_ball_bar:
        assert test.deviation is not None
        return lattice_step(test.deviation) or 0.0
    return max(lattice_step(test.axis(name).position) or 0.0 for name in test.names)

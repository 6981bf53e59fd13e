"""A radial trace taken apart: geometry, the loops' lag, backlash, friction at the reversals, pitch, and the rest."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import pi

import numpy as np

from fric.arrays import Real
from fric.circles.geometry import BEFORE, FIRST, LARGEST, Geometry, columns_of, fit_geometry, quiet
from fric.circles.glitches import Glitch, Pulse, glitch_of, noise_of, pulses, smoothed
from fric.circles.identifiability import identifiability_warnings
from fric.circles.iso230 import Iso230, iso230
from fric.circles.lag import lags
from fric.circles.measured import MeasuredCircle
from fric.circles.pitch import Periodic, periodic_errors
from fric.circles.revolutions import Revolutions, revolutions
from fric.contour import QUADRANTS
from fric.errors import FricError
from fric.estimate import Estimate
from fric.notice import Notice
from fric.records.resolution import lattice_step

ROUNDS = 4
"""How often what a glitch covers is looked at again."""
SHARE = 2e-3
"""Of the largest glitch, what the tails of glitches may miss: what repeats by less is not told from that."""


@dataclass(frozen=True)
class Diagnosis:
    """What a circle test shows.

    Parameters
    ----------
    tests
        Whole revolutions of the test, or of both directions.
    geometry
        By name: ``centre.AXIS`` [m], ``scale.AXIS`` [1], ``backlash.AXIS`` [m], ``mismatch`` [m], ``squareness``
        [rad], each with its 95 % interval; open where the test does not tell it.
    lag
        Time by which each axis is behind its reference [s], with its 95 % interval; none of an axis without reference.
    glitches
        Per quadrant, of the first test; ``all_glitches`` holds those of every test.
    all_glitches
        Per test and quadrant.
    periodic
        What repeats along an axis, with its amplitude [m].
    figures
        Figures of ISO 230-4.
    rest, scatter, noise
        What geometry, glitches and pitch leave: its root mean square [m] over parts of half a degree; the standard
        deviation between revolutions in such a part, None of one revolution; noise of a sample [m].
    model
        Radial deviation that geometry and pitch explain, per test, shape (n,) [m].
    warnings
        What the test cannot tell.
    """

    tests: tuple[Revolutions, ...]
    geometry: Mapping[str, Estimate]
    lag: Mapping[str, Estimate]
    all_glitches: tuple[Mapping[str, Glitch], ...]
    periodic: tuple[tuple[Periodic, Estimate], ...]
    figures: Iso230
    rest: float
    scatter: float | None
    noise: float
    model: tuple[Real, ...]
    warnings: tuple[Notice, ...] = field(default=())

    @property
    def test(self) -> MeasuredCircle:
        """The circle test that was looked at first."""
        return self.tests[0].test

    @property
    def glitches(self) -> Mapping[str, Glitch]:
        """Glitches of the first test, by quadrant."""
        return self.all_glitches[0]

    @property
    def glitch(self) -> float:
        """The largest magnitude of the glitches [m]."""
        return max(abs(glitch.value) for glitch in self.glitches.values())

    def pulses(self, n: int = 0) -> dict[str, Pulse]:
        """Return what a test shows around its reversals, less geometry and pitch."""
        tested = self.tests[n]
        return pulses(tested.angle, tested.deviation - self.model[n], tested.revolution, tested.test.direction)


def diagnose(tests: Sequence[MeasuredCircle]) -> Diagnosis:
    """Take the radial trace of one circle test apart, or of both directions of one circle.

    To first order a radial deviation is a sum of what each cause leaves at the angle θ, with s = 1 counter-clockwise:

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
    equal poles, would pass for backlash. What is left without it is the glitch.

    Parameters
    ----------
    tests
        A circle test, or two of one radius and feed in both directions: these tell mismatch from squareness.

    Raises
    ------
    FricError
        When there is no whole revolution, or the tests are not of one circle.
    """
    if not tests:
        raise FricError("there is no circle test to diagnose")
    tested = tuple(revolutions(test) for test in tests)
    _require_one_circle(tests)
    radius, both = tests[0].radius, len(tests) > 1
    steps = tuple(_resolution(test) for test in tests)
    behind = [dict.fromkeys(QUADRANTS, float(FIRST)) for _ in tests]
    lines: list[Periodic] = []
    fit = fit_geometry(tested, behind, lines, both)
    for _ in range(ROUNDS):
        new = [
            {name: _covers(pulse) for name, pulse in _pulses_of(one, fit, n).items()} for n, one in enumerate(tested)
        ]
        if not lines:
            lines = periodic_errors(*_outside(tested, fit, new), radius)
        settled = new == behind
        behind = new
        fit = fit_geometry(tested, behind, lines, both)
        if settled:
            break
    least = SHARE * max(
        float(np.abs(pulse.rest).max()) for n, one in enumerate(tested) for pulse in _pulses_of(one, fit, n).values()
    )
    seen = [line for n, line in enumerate(lines) if _is_seen(fit.amplitude(n), least)]
    if len(seen) < len(lines):
        lines = seen
        fit = fit_geometry(tested, behind, lines, both)
    found = tuple(_glitches(one, fit, n, radius, steps[n]) for n, one in enumerate(tested))
    geometry = fit.estimates(tests, both)
    _, outside, _ = _outside(tested, fit, behind)
    known = [value for value in map(_scatter, tested) if value is not None]
    periodic = tuple((line, fit.amplitude(n)) for n, line in enumerate(lines))
    noises = [noise_of(pulse) for n, one in enumerate(tested) for pulse in _pulses_of(one, fit, n).values()]
    noise = float(np.median(noises))
    rest = float(np.sqrt(np.mean(outside**2))) if len(outside) else 0.0
    notices = identifiability_warnings(tests, tested, geometry, both, behind, float(LARGEST))
    return Diagnosis(
        tested, geometry, lags(tested, behind, fit), found, periodic, iso230(tested), rest,
        float(np.mean(known)) if known else None, noise, tuple(fit.model(one, n) for n, one in enumerate(tested)),
        notices,
    )  # fmt: skip


def _is_seen(amplitude: Estimate, least: float) -> bool:
    """Return whether an amplitude is three times the half-width of its interval, and more than a least one [m]."""
    assert isinstance(amplitude.ci95, tuple)
    return float(amplitude) > max(3 * (float(np.max(amplitude.ci95)) - float(amplitude)), least)


def both_directions(tests: Sequence[MeasuredCircle], feed: float | None = None) -> list[MeasuredCircle]:
    """Return the one circle of some tests that is diagnosed, in both directions where both are there.

    tests: Circle tests.
    feed: The feed that is asked for [m/s]; where it is not given, the tests must be of one circle.
    Raises FricError: When there is none at that feed, or several circles and none was asked for.
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


def _pulses_of(tested: Revolutions, fit: Geometry, n: int) -> dict[str, Pulse]:
    return pulses(tested.angle, tested.deviation - fit.model(tested, n), tested.revolution, tested.test.direction)


def _covers(pulse: Pulse) -> float:
    """Return up to what angle behind the reversal a pulse is seen [rad]."""
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
    """Return angle, what is left of the deviation, and the columns of the fit: means over parts where no glitch is."""
    angles, rests, columns = [], [], []
    for n, one in enumerate(tests):
        rest = Revolutions(one.test, one.angle, one.deviation - fit.model(one, n), one.revolution, {})
        angle, mean, _ = rest.averaged(min(1440, max(len(one.angle) // one.count // 2, 8)))
        centre = Revolutions(one.test, angle, mean, np.zeros(len(angle), np.intp), {})
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
    """Return the coarser step of what was recorded [m]; 0 where none is seen."""
    if test.is_ball_bar:
        assert test.deviation is not None
        return lattice_step(test.deviation) or 0.0
    return max(lattice_step(test.axis(name).position) or 0.0 for name in test.names)

"""A radial trace taken apart: geometry, the loops' lag, backlash, friction at the reversals, pitch, and the rest."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import inf, pi
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.special import stdtrit

from fric.contour import QUADRANTS
from fric.errors import FricError
from fric.estimate import Estimate
from fric.identify.circle.doubts import doubts_of
from fric.identify.circle.glitches import Glitch, Pulse, glitch_of, noise_of, pulses, smoothed
from fric.identify.circle.iso230 import Iso230, iso230
from fric.identify.circle.pitch import Periodic, periodic_errors
from fric.identify.circle.revolutions import Revolutions, revolutions
from fric.identify.records.resolution import lattice_step
from fric.identify.replay.replay_intervals import covariance_of
from fric.notice import Notice

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from fric.identify.circle.measured import MeasuredCircle

BEFORE, FIRST, LARGEST = np.radians(2.0), np.radians(30.0), np.radians(40.0)
"""Around a reversal this much is left out of the geometry: before it, behind it at first, behind it at most [rad]."""
FADES = np.radians(np.geomspace(0.7, 14.0, 13))
"""Angles in which the tail of a glitch may fade to a third [rad]."""
ROUNDS = 4
"""How often what a glitch covers is looked at again."""
MOST = 60_000
"""Samples that geometry is fitted to; of more, one in so many is taken."""


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
        Time by which each axis is behind its reference [s]; empty where no reference was recorded.
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
    lag: Mapping[str, float]
    all_glitches: tuple[Mapping[str, Glitch], ...]
    periodic: tuple[tuple[Periodic, Estimate], ...]
    figures: Iso230
    rest: float
    scatter: float | None
    noise: float
    model: tuple[NDArray[np.float64], ...]
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
        turns = self.tests[n]
        return pulses(turns.angle, turns.deviation - self.model[n], turns.turn, turns.test.direction)


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
    takes to fade to a twentieth. Its tail is fitted with them, ``c·exp(-φ/λ)·cos φ`` at the angle φ behind the
    reversal, with one λ for all; else a long one would pass for backlash. What is left without it is the glitch.

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
    turns = tuple(revolutions(test) for test in tests)
    _require_one_circle(tests)
    radius, both = tests[0].radius, len(tests) > 1
    steps = tuple(_resolution(test) for test in tests)
    behind = [dict.fromkeys(QUADRANTS, float(FIRST)) for _ in tests]
    lines: list[Periodic] = []
    fit = _fitted(turns, behind, lines, both)
    for _ in range(ROUNDS):
        new = [
            {name: _covers(pulse) for name, pulse in _pulses_of(one, fit, n).items()} for n, one in enumerate(turns)
        ]
        if not lines:
            angle, left = _outside(turns, fit, new)
            lines = periodic_errors(angle, left, radius)
        settled = new == behind
        behind = new
        fit = _fitted(turns, behind, lines, both)
        if settled:
            break
    found = tuple(_glitches(one, fit, n, radius, steps[n]) for n, one in enumerate(turns))
    geometry = fit.estimates(tests, both)
    angle, left = _outside(turns, fit, behind)
    _, scatters = zip(*(_scatter(one) for one in turns), strict=True)
    known = [value for value in scatters if value is not None]
    periodic = tuple(
        (line, fit.amplitude(n)) for n, line in enumerate(lines)
    )
    noise = float(np.median([noise_of(pulse) for n, one in enumerate(turns) for pulse in _pulses_of(one, fit, n).values()]))
    doubts = doubts_of(tests, turns, geometry, both, behind, float(LARGEST))
    return Diagnosis(
        turns, geometry, _lags(turns), found, periodic, iso230(turns), _rms_of_parts(angle, left),
        float(np.mean(known)) if known else None, noise, tuple(fit.model(one, n) for n, one in enumerate(turns)),
        doubts,
    )  # fmt: skip


def _require_one_circle(tests: Sequence[MeasuredCircle]) -> None:
    if len(tests) > 2 or (len(tests) == 2 and tests[0].direction == tests[1].direction):
        raise FricError(
            f"{len(tests)} tests are not the two directions of one circle",
            where=tests[0].where, mend="Give one test, or one counter-clockwise and one clockwise.",
        )  # fmt: skip
    first = tests[0]
    for other in tests[1:]:
        if abs(other.radius / first.radius - 1) > 1e-3 or abs(other.feed / first.feed - 1) > 1e-2:
            raise FricError(
                f"is of {other.radius * 1e3:g} mm at {other.feed * 1e3:g} mm/s, and the other direction of "
                f"{first.radius * 1e3:g} mm at {first.feed * 1e3:g} mm/s",
                where=other.where, mend="Give both directions of one circle at one feed.",
            )  # fmt: skip


@dataclass(frozen=True)
class _Fit:
    """Geometry and pitch, fitted."""

    names: tuple[str, ...]
    values: NDArray[np.float64]
    covariance: NDArray[np.float64]
    freedom: int
    lines: tuple[Periodic, ...]
    many: int
    both: bool

    def model(self, turns: Revolutions, n: int) -> NDArray[np.float64]:
        """Return what is explained of a test, shape (n,) [m]."""
        return columns_of(turns, n, self.many, self.both, self.lines) @ self.values

    def error_at(self, turns: Revolutions, n: int, angle: float) -> float:
        """Return the standard error of what is explained at an angle [m]."""
        at = Revolutions(turns.test, np.array([angle]), np.zeros(1), np.zeros(1, np.intp), {})
        row = columns_of(at, n, self.many, self.both, self.lines)[0]
        return float(np.sqrt(max(row @ self.covariance @ row, 0.0)))

    def _quantity(self, name: str, unit: str, scale: float = 1.0, offset: float = 0.0) -> Estimate:
        n = self.names.index(name)
        reach = float(stdtrit(max(self.freedom, 1), 0.975)) * float(np.sqrt(self.covariance[n, n])) * abs(scale)
        value = offset + scale * float(self.values[n])
        return Estimate(value, unit, (value - reach, value + reach))

    def estimates(self, tests: Sequence[MeasuredCircle], both: bool) -> dict[str, Estimate]:
        """Return the geometry with its intervals."""
        first, second = tests[0].names
        radius = tests[0].radius
        found = {f"centre.{first}": self._quantity("centre.x.0", "m"), f"centre.{second}": self._quantity("centre.y.0", "m")}
        found |= {f"scale.{first}": self._quantity("scale.x", "1", 1 / radius, 1.0)}
        found |= {f"scale.{second}": self._quantity("scale.y", "1", 1 / radius, 1.0)}
        found |= {f"backlash.{first}": self._quantity("backlash.x", "m")}
        found |= {f"backlash.{second}": self._quantity("backlash.y", "m")}
        ellipse = self._quantity("mismatch", "m")
        if both:
            return found | {"mismatch": ellipse, "squareness": self._quantity("square", "rad", -2 / radius)}
        if tests[0].instrument == "encoders":
            return found | {"mismatch": ellipse, "squareness": Estimate(0.0, "rad", (-inf, inf), assumed=True)}
        unknown = Estimate(float(ellipse), "m", (-inf, inf))
        return found | {"mismatch": unknown, "squareness": Estimate(0.0, "rad", (-inf, inf), assumed=True)}

    def amplitude(self, n: int) -> Estimate:
        """Return the amplitude of what repeats along an axis [m]."""
        i = len(self.names) - 2 * len(self.lines) + 2 * n
        part, C = self.values[i : i + 2], self.covariance[i : i + 2, i : i + 2]
        size = float(np.hypot(*part))
        along = part / size if size > 0 else np.array([1.0, 0.0])
        reach = float(stdtrit(max(self.freedom, 1), 0.975)) * float(np.sqrt(along @ C @ along))
        return Estimate(size, "m", (max(size - reach, 0.0), size + reach))


def columns_of(
    turns: Revolutions, n: int, many: int, both: bool, lines: Sequence[Periodic] = ()
) -> NDArray[np.float64]:
    """Return the columns of `diagnose`'s table for one of its tests, shape (samples, parameters)."""
    angle, s = turns.angle, float(turns.test.direction)
    cos, sin = np.cos(angle), np.sin(angle)
    centres = [column if k == n else np.zeros_like(angle) for k in range(many) for column in (cos, sin)]
    shared = [
        cos**2, sin**2, s / 2 * np.sign(sin) * cos, -s / 2 * np.sign(cos) * sin, s * np.sin(2 * angle),
        *([np.sin(2 * angle)] if both else []),
    ]  # fmt: skip
    pitch = [line.columns(angle, turns.test.radius) for line in lines]
    return np.column_stack([*centres, *shared, *pitch])


def _names(many: int, both: bool, lines: int) -> tuple[str, ...]:
    centres = [f"centre.{axis}.{k}" for k in range(many) for axis in ("x", "y")]
    shared = ["scale.x", "scale.y", "backlash.x", "backlash.y", "mismatch", *(["square"] if both else [])]
    return (*centres, *shared, *(f"pitch.{k}.{part}" for k in range(lines) for part in ("cos", "sin")))


def _quiet(turns: Revolutions, behind: Mapping[str, float]) -> NDArray[np.bool_]:
    """Return which samples no glitch covers."""
    good = np.ones(len(turns.angle), bool)
    for n, name in enumerate(QUADRANTS):
        phi = (turns.test.direction * (turns.angle - n * pi / 2) + pi) % (2 * pi) - pi
        good &= (phi < -BEFORE) | (phi > behind[name])
    return good


def _fitted(
    tests: Sequence[Revolutions], behind: Sequence[Mapping[str, float]], lines: Sequence[Periodic], both: bool
) -> _Fit:
    many = len(tests)
    every = -(-sum(len(one.angle) for one in tests) // MOST)
    used = [np.flatnonzero(_quiet(one, behind[n]))[::every] for n, one in enumerate(tests)]
    X = np.vstack([columns_of(one, n, many, both, lines)[u] for n, (one, u) in enumerate(zip(tests, used, strict=True))])
    d = np.concatenate([one.deviation[u] for one, u in zip(tests, used, strict=True)])
    p = X.shape[1]

    def with_tails(fade: float) -> NDArray[np.float64]:
        tails = np.zeros((len(d), 4 * many))
        end = 0
        for n, (one, u) in enumerate(zip(tests, used, strict=True)):
            tails[end : end + len(u), 4 * n : 4 * n + 4] = _tails(one, u, behind[n], fade)
            end += len(u)
        return tails

    def solved(fade: float) -> tuple[float, NDArray[np.float64], NDArray[np.float64]]:
        columns = np.hstack([X, with_tails(fade)])
        values, *_ = np.linalg.lstsq(columns, d, rcond=None)
        return float(np.sum((d - columns @ values) ** 2)), columns, values

    found = [solved(fade)[0] for fade in FADES]
    best = int(np.argmin(found))
    around = np.geomspace(FADES[max(best - 1, 0)], FADES[min(best + 1, len(FADES) - 1)], 9)
    fade = float(around[np.argmin([solved(one)[0] for one in around])])
    _, columns, values = solved(fade)
    slope = (with_tails(fade * 1.01) - with_tails(fade / 1.01)) @ values[p:]
    residual = d - columns @ values
    pieces = [len(part) for u in used for part in np.split(u, np.flatnonzero(np.diff(u) > every) + 1)]
    if np.ptp(residual) <= 1e-12 * max(float(np.ptp(d)), 1e-15):
        covariance = np.zeros((p, p))
    else:
        if np.linalg.norm(slope) > 3 * np.std(residual):  # how sure the fade is matters where there is a tail
            columns = np.column_stack([columns, slope])
        covariance = covariance_of(columns, residual, pieces)[:p, :p]
    return _Fit(_names(many, both, len(lines)), values[:p], covariance, len(d) - p, tuple(lines), many, both)


def _tails(
    turns: Revolutions, used: NDArray[np.intp], behind: Mapping[str, float], fade: float
) -> NDArray[np.float64]:
    """Return the tails of the four glitches at some samples, each 1 where it begins, shape (n, 4)."""
    tails = []
    for n, name in enumerate(QUADRANTS):
        phi = (turns.test.direction * (turns.angle[used] - n * pi / 2)) % (2 * pi)
        tails.append(np.exp(np.minimum((behind[name] - phi) / fade, 0.0)) * np.cos(phi) * (phi > behind[name]))
    return np.column_stack(tails)


def _pulses_of(turns: Revolutions, fit: _Fit, n: int) -> dict[str, Pulse]:
    return pulses(turns.angle, turns.deviation - fit.model(turns, n), turns.turn, turns.test.direction)


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
    tests: Sequence[Revolutions], fit: _Fit, behind: Sequence[Mapping[str, float]]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return angle and what is left of the deviation, means over half degrees where no glitch is."""
    angles, rests = [], []
    for n, one in enumerate(tests):
        rest = Revolutions(one.test, one.angle, one.deviation - fit.model(one, n), one.turn, {})
        angle, mean, _ = rest.averaged(min(1440, max(len(one.angle) // one.count // 2, 8)))
        centre = Revolutions(one.test, angle, mean, np.zeros(len(angle), np.intp), {})
        good = _quiet(centre, behind[n]) & np.isfinite(mean)
        angles.append(angle[good])
        rests.append(mean[good])
    return np.concatenate(angles), np.concatenate(rests)


def _rms_of_parts(angle: NDArray[np.float64], rest: NDArray[np.float64]) -> float:
    return float(np.sqrt(np.mean(rest**2))) if len(rest) else 0.0


def _scatter(turns: Revolutions) -> tuple[None, float | None]:
    _, _, scatter = turns.averaged(min(720, max(len(turns.angle) // turns.count, 8)))
    known = scatter[np.isfinite(scatter)]
    return None, float(np.sqrt(np.mean(known**2))) if len(known) else None


def _glitches(turns: Revolutions, fit: _Fit, n: int, radius: float, step: float) -> dict[str, Glitch]:
    found = {}
    for k, (name, pulse) in enumerate(_pulses_of(turns, fit, n).items()):
        base = fit.error_at(turns, n, k * pi / 2 + turns.test.direction * 1e-3)
        found[name] = glitch_of(pulse, radius, base, step)
    return found


def _resolution(test: MeasuredCircle) -> float:
    """Return the coarser step of what was recorded [m]; 0 where none is seen."""
    if test.is_ball_bar:
        assert test.deviation is not None
        return lattice_step(test.deviation) or 0.0
    return max(lattice_step(test.axis(name).position) or 0.0 for name in test.names)


def _lags(turns: Sequence[Revolutions]) -> dict[str, float]:
    names = turns[0].lag
    return {name: float(np.mean([one.lag[name] for one in turns if name in one.lag])) for name in names}


def document(found: Diagnosis) -> dict[str, Any]:
    """Return a diagnosis as a plain document, for programs; every number in SI."""
    test, figures, geometry = found.test, found.figures, found.geometry
    names = test.names

    def plain(value: float | None, unit: str) -> dict[str, Any] | None:
        return None if value is None else {"value": value, "unit": unit}

    def per_axis(what: str) -> dict[str, Any]:
        return {name: geometry[f"{what}.{name}"].as_dict() for name in names}

    def glitches(of: Mapping[str, Glitch]) -> dict[str, Any]:
        return {
            name: {"value": g.value, "unit": "m", "ci95": list(g.ci95), "width": g.width, "place": g.place}
            for name, g in of.items()
        }

    directions = {1: "counter-clockwise", -1: "clockwise"}
    return {
        "radius": plain(test.radius, "m"),
        "feed": plain(test.feed, "m/s"),
        "direction": plain(float(test.direction), "1"),
        "revolutions": [one.count for one in found.tests],
        "centre": per_axis("centre"),
        "scale": per_axis("scale"),
        "squareness": geometry["squareness"].as_dict(),
        "backlash": per_axis("backlash"),
        "mismatch": geometry["mismatch"].as_dict(),
        "lag": {name: plain(value, "s") for name, value in found.lag.items()},
        "glitch": glitches(found.glitches),
        "glitch_of": {
            directions[one.test.direction]: glitches(of) for one, of in zip(found.tests, found.all_glitches, strict=True)
        },
        "pitch": [
            {"axis": names[line.axis], "pitch": plain(line.pitch, "m"), "amplitude": amplitude.as_dict()}
            for line, amplitude in found.periodic
        ],
        "rest": plain(found.rest, "m"),
        "scatter": plain(found.scatter, "m"),
        "noise": plain(found.noise, "m"),
        "iso230": {
            "G": plain(max(figures.G.values()), "m"),
            "G_of": {directions[k]: plain(value, "m") for k, value in figures.G.items()},
            "G_b": plain(figures.G_b, "m"),
            "F_max": plain(figures.F_max, "m"),
            "F_min": plain(figures.F_min, "m"),
            "D": plain(figures.D, "m"),
        },
        "warnings": list(found.warnings),
        "warnings_coded": [Notice.of(warning).as_dict() for warning in found.warnings],
    }

"""The plant of eq. (1) from frequency responses, or from an ordinary motion; the force constant; the choice of records.

The lines of a response give the force per volt and the lag of the logged force, too. A force that is logged late is
not proportional to the voltage of the same sample, and a regression of one on the other gives too small a K_f with a
narrow interval. In the frequency domain both separate:

    F/U = K_f·e^(-jωτ)/(1 + jω·T_f)

the magnitude towards 0 Hz is K_f, the phase is the delay τ and a first-order filter T_f of the measurement.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from itertools import chain, compress
from math import exp, sqrt
from typing import Literal, NamedTuple

import numpy as np
from scipy import optimize
from scipy.special import chdtri, stdtrit

from fric import statistics
from fric.arrays import Complex, Indices, Mask, Real
from fric.drive.plant import OF_EFFORT, LinearPlant, hold_delay
from fric.drive.resonance import Encoder, Resonance
from fric.errors import FricError, found_in
from fric.estimate import Estimate
from fric.flaws import channel as flaws
from fric.flaws import response
from fric.flaws.drift import RECORDS_VARY
from fric.flaws.files import RECORD_LEFT_OUT
from fric.flaws.static_map import FORCE_OVER_POSITION
from fric.identify.plant.frequency_response import SEGMENTS, MeasuredResponse, driven_alike, measure_response
from fric.log import ForceVelocity, FrequencyResponse, Log, Record, refuse_several_axes
from fric.notice import Notice
from fric.process import one_blas_thread
from fric.records.flaws import even_sampling, evened, record_flaws
from fric.records.inspection import CONDITION
from fric.records.motion import BANDWIDTH, Conditioning, kept, shows_mass, thinned
from fric.records.over_strokes import ForceOverPosition, cogging
from fric.records.prepared import Drive, Prepared, prepared
from fric.records.recognition import kind_of
from fric.records.resolution import clipped
from fric.records.segments import steady_segments
from fric.search import simplest
from fric.units import Motion, drive_unit, is_effort, readable, rotates, si_unit

COARSEST = 0.3  # Relative deviation up to which the logarithm of a response is practically unbiased
FLOOR = 1e-5  # Least relative deviation of a line: the rounding of a logged force
LONGEST = 25e-3  # Longest delay in the search [s], and four times the longest lead
FEW_LINES = 8  # Least number of lines for the fit of the lag, if the record has them
MEANS = 4  # Least number of steady segments for a line through their means
BENT = 0.02  # Largest deviation of the means from their line, as a share of their range
SMALL = 0.03  # Largest share of friction in a correct A
QUIET = 20.0  # Largest frequency in the search for friction's harmonics [Hz]; above it encoder steps cause more voltage
FREE, NEIGHBOURS = 100.0, 0.5
"""Degrees of freedom from which lines that scatter give an interval to be trusted, and the correlation of neighbouring
lines below which they scatter: of seven axes that a dense multisine moved around rest it was 0 to 0.36."""
ACCELERATES = 0.02  # Least acceleration of a record (rms), as a share of the greatest, for the fit of a rigid axis
_EACH = ("F_v_positive", "F_c_positive", "F_v_negative", "F_c_negative")


class Lines(NamedTuple):
    """The lines of one response that a fit uses."""

    frequency: Real  # Frequencies [Hz], shape (n,)
    response: Complex  # Z/U [m/V], shape (n,)
    deviation: Real  # Relative standard deviation of real and imaginary part, shape (n,)
    hold: float | None  # Sampling rate of the hold before the plant [Hz]; None where the response is of eq. (1) itself
    reversing: float  # Equivalent gain of Coulomb friction [s/m], see `MeasuredResponse`
    correlation: float  # Neighbouring lines per independent line
    known: bool  # True where the deviation is known in full, false where only its shape is (a table)


def select(
    measured: MeasuredResponse, *, hold: float | None, coherence: float, band: tuple[float, float] = (0.0, np.inf),
    least: int = 4,
) -> tuple[Lines, Mask]:  # fmt: skip
    """Return the lines of a response that are certain enough, and their selection, shape (n,).

    hold: Sampling rate of the hold [Hz], or None.
    Raises FricError: When fewer lines are left.
    """
    table = measured.table
    f = table.frequency
    deviation = np.ones_like(f) if table.deviation is None else table.deviation
    known = measured.method != "table"
    used = (f >= band[0]) & (f <= band[1]) & (f < (np.inf if hold is None else 0.45 * hold))
    if table.coherence is not None:
        used &= table.coherence >= coherence
    if known:
        used &= deviation <= COARSEST
    if np.count_nonzero(used) < least:
        between = f" between {band[0]:g} and {band[1]:g} Hz" if band != (0.0, np.inf) else ""
        what = f"{np.count_nonzero(used)} of {len(f)} frequencies have a coherence of {coherence:g} or more{between}"
        raise FricError(what, where=table.where, hint="Excite harder or longer, or lower `coherence=`.")
    floor = 1e-9  # a response without any noise weighs much, but not infinitely
    lines = Lines(
        f[used], measured.response[used], np.maximum(deviation[used], floor), hold, measured.reversing or 0.0,
        measured.correlation, known,
    )  # fmt: skip
    return lines, used


def at(lines: Lines, kept: Mask) -> Lines:
    """Return a part of the lines."""
    return lines._replace(**{name: getattr(lines, name)[kept] for name in ("frequency", "response", "deviation")})


def near(lines: Lines, dampings: int = 60, most: int = 200) -> tuple[Real, float]:
    """Return A, ln B, T_d near the best, and the residual sum of squares.

    They are from a grid with a wrapped phase, so that no error of unwrapping is possible.

    Raises FricError: When the response is that of eq. (1) with the wrong sign.
    """
    thin = slice(None, None, -(-len(lines.frequency) // most))
    f, response, deviation = lines.frequency[thin], lines.response[thin], lines.deviation[thin]
    weight = 1 / np.maximum(deviation, 1e-3) ** 2
    weight = weight / weight.sum()
    omega = 2 * np.pi * f
    T_d = np.arange(0, 20 / f.max(), 0.2 / f.max())
    back = np.exp(1j * np.outer(T_d, omega))
    best, at = np.inf, np.zeros(3)
    for A in (0.0, *np.geomspace(0.05 * omega.min(), 2 * omega.max(), dampings)):
        ratio = response * 1j * omega * (1j * omega + A)
        log_B = float(weight @ np.log(np.abs(ratio)))
        cost = weight @ (np.log(np.abs(ratio)) - log_B) ** 2 + np.angle(ratio * back) ** 2 @ weight
        n = int(np.argmin(cost))
        if cost[n] < best:
            best, at = float(cost[n]), np.array([A, log_B, T_d[n]])
    if best > 1.0 and weight @ np.cos(np.angle(-response * 1j * omega * (1j * omega + at[0]))) > 0.5:
        hint = "Set sign: -1 for input or position."
        raise FricError("the response is that of eq. (1) with the sign turned", hint=hint)
    return at, best


UNDETERMINED = 0.5  # Assumed share of the table in the moving mass, if it is not determined
BLOCKS, FEWEST_LINES = 10, 5  # Number of blocks of neighbouring lines for the jackknife, and the least number
SCATTER_BY_CHANCE = float(chdtri(BLOCKS - 1, 0.1)) / (BLOCKS - 1)  # Ratio of variances that chance exceeds in 1 of 10
OTHER_RATIOS = (0.2, 0.8)  # Other possible shares of the table, if it is not determined
MISFIT = 0.99  # Quantile of chi-squared above which the residuals exceed noise


class ResponseForm(NamedTuple):
    """The set of parameters: A, ln B, T_d; F_c/M or β of friction; ln f, ln ζ and the ratio of a second mass.

    F_c/M is that of Coulomb friction along motions of several amplitudes, ``A + F_c/M·reversing``. Around rest friction
    is a spring as well as a damper, whose stiffness grows with the frequency as smaller motions see it stiffer:
    ``Z/U = B·exp(-jωT_d)/(-ω² + jωA + βω)``. With an encoder at the table the ratio of a second mass is not fitted: the
    response depends on it only by A/ω.
    """

    friction: Literal["", "coulomb", "hysteresis"] = ""
    encoder: Encoder | None = None  # Where the encoder is, where there is a second mass

    @property
    def of_axis(self) -> int:
        """Number of parameters of the axis and its friction, before those of a second mass."""
        return 3 + bool(self.friction)

    def plant(self, x: Real, reversing: float = 0.0) -> LinearPlant:
        """Return eq. (1), with what friction adds to A along a motion with this gain [s/m]."""
        A = float(x[0]) + (float(x[3]) * reversing if self.friction == "coulomb" else 0.0)
        return LinearPlant(max(A, 0.0), float(np.exp(x[1])), max(float(x[2]), 0.0))

    def resonance(self, x: Real, share: float = UNDETERMINED) -> Resonance | None:
        """Return the second mass, if any, with this share of the table where the share is not determined."""
        if self.encoder is None:
            return None
        tail = [float(value) for value in x[self.of_axis :]]
        ratio = tail[2] if len(tail) > 2 else share
        return Resonance(float(np.exp(tail[0])), ratio, float(np.exp(tail[1])), self.encoder)

    def response(
        self, x: Real, frequency: Real, hold: float | None, reversing: float = 0.0, share: float = UNDETERMINED
    ) -> Complex:
        """Return Z/U [m/V] of these parameters at frequencies [Hz], shape (n,)."""
        plant, resonance = self.plant(x, reversing), self.resonance(x, share)
        seen = resonance.response(plant, frequency, hold) if resonance else plant.response(frequency, hold)
        spring = float(x[3]) / (1j * plant.A - 2 * np.pi * frequency) if self.friction == "hysteresis" else 0.0
        return np.asarray(seen / (1.0 + spring))


@dataclass(frozen=True)
class PlantSolution:
    """Parameters of eq. (1), and of Coulomb friction and a second mass where they were requested."""

    values: Real  # A [1/s], ln B, T_d [s], F_c/M [m/s²] or β [1/s] if fitted, second mass's in `ResponseForm`; (p,)
    covariance: Real  # Covariance of these, shape (p, p)
    chi2: float  # Chi-squared over its freedom, for the deviations as they were measured [1]
    misfit: float  # Relative deviation that measured ones lack to explain the residuals; 0 where noise does
    freedom: float  # Degrees of freedom, correlated lines counted once
    form: ResponseForm  # Which parameters there are

    def plant(self, reversing: float = 0.0) -> LinearPlant:
        """Return eq. (1), with what friction adds to A along a motion with this gain [s/m]."""
        return self.form.plant(self.values, reversing)

    def response(self, frequency: Real, hold: float | None, reversing: float = 0.0) -> Complex:
        """Return Z/U [m/V] at frequencies [Hz], shape (n,), as in `ResponseForm.response`."""
        return self.form.response(self.values, frequency, hold, reversing)

    def half_widths(self) -> Real:
        """Return half the 95 % intervals, shape (p,)."""
        return float(stdtrit(self.freedom, 0.975)) * np.sqrt(np.diag(self.covariance))

    def second_mass(self) -> dict[str, Estimate] | None:
        """Return frequency, ratio and damping of the second mass with their 95 % intervals, where there is one."""
        found = self.form.resonance(self.values)
        if found is None:
            return None
        f, zeta, ratio, half = found.frequency, found.damping, found.ratio, self.half_widths()[self.form.of_axis :]
        known = len(half) > 2
        limits = (ratio - float(half[2]), ratio + float(half[2])) if known else None
        return {
            "frequency": Estimate.around_log(f, "Hz", float(half[0])),
            "ratio": Estimate(ratio, "1", limits, assumed=not known),
            "damping": Estimate.around_log(zeta, "1", float(min(half[1], 20.0))),
        }

    def estimates(self, motion: Motion) -> dict[str, Estimate]:
        """Return A, B and T_d with their 95 % intervals; that of B is symmetric in its logarithm."""
        A, log_B, T_d = (float(v) for v in self.values[:3])
        half = [float(h) for h in self.half_widths()[:3]]
        return {
            "A": Estimate.around(A, si_unit("rate", motion), half[0]),
            "B": Estimate.around_log(exp(log_B), si_unit("acceleration per input", motion), half[1]),
            "T_d": Estimate.around(T_d, "s", half[2]),
        }


def solve(
    sets: Sequence[Lines], *, friction: Literal["", "coulomb", "hysteresis"] = "",
    misfits: Sequence[float] | None = None, resonance: Resonance | None = None, start: Real | None = None,
) -> PlantSolution:  # fmt: skip
    """Fit eq. (1) to the lines of one or more responses by weighted least squares on log magnitude and phase.

    The residual is ``ln(G_m/G)``, its real part the log magnitude, its imaginary part the phase, both over the relative
    deviation of the line. What friction around rest does beyond β differs from frequency to frequency: with its
    hysteresis the deviation to be added is that of each block of neighbouring lines.

    friction: Parameter of friction, see `ResponseForm`.
    misfits: Relative deviation to be added for each response; by default estimated.
    resonance: Start of the search for a second mass; by default eq. (1) alone.
    start: Start of the search for A, ln B, T_d, and F_c/M if fitted; by default from a grid and 0.
    """
    form = ResponseForm(friction, resonance.encoder if resonance else None)
    start = near(sets[0])[0] if start is None else np.array(start, float)
    holds = [lines.hold for lines in sets if lines.hold is not None]
    lower = [0.0, -np.inf, hold_delay(min(holds)) if holds else 0.0]
    start[2] = max(start[2], lower[2] * (1 + 1e-6))
    top = max(float(lines.frequency.max()) for lines in sets)
    upper, scale = [np.inf] * 3, [2 * np.pi * top * 0.05, 0.1, 0.05 / top]
    if friction:
        at_0, unit, least = (0.0, 1.0, -np.inf) if friction == "coulomb" else (1.0, 20.0, 0.0)
        start, lower, upper, scale = np.append(start, at_0)[:4], [*lower, least], [*upper, np.inf], [*scale, unit]
    if resonance is not None:
        n = 3 if resonance.encoder == "motor" else 2
        second = [float(np.log(resonance.frequency)), float(np.log(resonance.damping)), resonance.ratio]
        start, scale = np.append(start, second[:n]), scale + [0.05, 0.3, 0.05][:n]
        lower, upper = lower + [second[0] - 2.0, -9.0, 1e-3][:n], upper + [second[0] + 2.0, 0.0, 0.999][:n]

    def model(x: Real, lines: Lines) -> Complex:
        return form.response(x, lines.frequency, lines.hold, lines.reversing)

    correlation = max(lines.correlation for lines in sets)
    rows = sum(2 * len(lines.frequency) for lines in sets)
    freedom = max(rows / correlation - len(start), 1.0)

    def fitted(added: Sequence[float | Real], start: Real) -> optimize.OptimizeResult:
        def residual(x: Real) -> Real:
            return np.concatenate([residual_of(model(x, s), s, a) for s, a in zip(sets, added, strict=True)])

        return optimize.least_squares(
            residual, start, jac="3-point", bounds=(lower, upper), x_scale=scale, xtol=1e-10, ftol=1e-10, gtol=1e-10,
        )  # fmt: skip

    added: list[float | Real] = [0.0] * len(sets) if misfits is None else list(misfits)
    found = fitted(added, start)
    plain = chi2 = 2 * float(found.cost) / max(rows - len(start), 1)
    if misfits is None and chi2 * freedom > chdtri(freedom, 1 - MISFIT) and all(lines.known for lines in sets):
        # without the misfit a fit of lines that friction bends ends anywhere
        x, parts = (start, BLOCKS) if friction == "hysteresis" else (found.x, 1)
        for _ in range(60):  # the misfit with which chi-squared is its freedom
            added = [_misfit(model(x, lines), lines, len(start), parts) for lines in sets]
            last, found = x, fitted(added, x)
            x = found.x
            if np.allclose(x, last, rtol=1e-6, atol=1e-12):
                break
        chi2 = 2 * float(found.cost) / max(rows - len(start), 1)
    covariance = statistics.parameter_covariance(found.jac) * chi2 * correlation
    quantile = float(stdtrit(freedom, 0.975))
    covariance = statistics.widened(covariance, _left_out(found, sets, covariance) / quantile**2)
    if form.encoder == "table":
        for ratio in OTHER_RATIOS:
            shares = [form.response(found.x, lines.frequency, lines.hold, lines.reversing, ratio) for lines in sets]
            other = [residual_of(share, lines, a) for share, lines, a in zip(shares, sets, added, strict=True)]
            moved = np.linalg.lstsq(found.jac, np.concatenate(other) - found.fun, rcond=None)[0]
            covariance = covariance + np.outer(moved, moved) / (len(OTHER_RATIOS) * quantile**2)
    misfit = max(float(np.sqrt(np.mean(np.square(of)))) for of in added)
    return PlantSolution(found.x, covariance, plain, misfit, freedom, form)


def _left_out(found: optimize.OptimizeResult, sets: Sequence[Lines], covariance: Real) -> Real:
    """Return the squared half-widths (p, p) by leaving out blocks of neighbouring lines, 0 with few lines.

    The errors of a model, of friction and of an encoder's steps are similar from line to line, and no scatter over
    periods shows them. Where blocks differ by no more than chance, that scatter is sufficient.
    """
    if min(len(lines.frequency) for lines in sets) < 2 * FEWEST_LINES:
        return np.zeros((len(found.x), len(found.x)))
    label = [np.tile(_blocks(lines, BLOCKS) + BLOCKS * number, 2) for number, lines in enumerate(sets)]
    moved = statistics.jackknife(found.jac, found.fun, np.concatenate(label))
    sure = np.diag(moved) > SCATTER_BY_CHANCE * float(stdtrit(BLOCKS - 1, 0.975)) ** 2 * np.diag(covariance)
    return np.asarray(np.where(np.outer(sure, sure), moved, 0.0))


def _blocks(lines: Lines, count: int) -> Indices:
    """Return the number of the block of neighbouring lines that each line is in, of a number of blocks, shape (n,)."""
    return np.asarray(np.argsort(np.argsort(lines.frequency)) * count // len(lines.frequency))


def residual_of(modelled: Complex, lines: Lines, misfit: float | Real) -> Real:
    """Return log magnitudes and phases over a model, each over its deviation, shape (2·n,)."""
    ratio = np.log(lines.response / modelled)
    weight = 1 / np.hypot(lines.deviation, misfit)
    return np.concatenate([ratio.real * weight, ratio.imag * weight])


def _misfit(modelled: Complex, lines: Lines, count: int, parts: int = 1) -> Real:
    """Return the relative deviation at which chi-squared of each part of a response is its freedom, shape (n,)."""
    residual = lines.deviation * residual_of(modelled, lines, 0.0).reshape(2, -1)
    block, added = _blocks(lines, max(min(parts, len(lines.frequency) // FEWEST_LINES), 1)), np.empty(residual.shape[1])
    for of in (block == number for number in np.unique(block)):
        freedom = max(2 * np.count_nonzero(of) * (1 - count / residual.size), 1)
        added[of] = sqrt(statistics.excess_variance(residual[:, of], lines.deviation[of], freedom))
    return np.maximum(added, 0.1 * np.sqrt(np.mean(added**2)))


@dataclass(frozen=True)
class ResponseFit:
    """One measured response and eq. (1) fitted to it alone."""

    measured: MeasuredResponse  # The response
    used: Mask  # Which of its lines were sure enough, shape (n,)
    solution: PlantSolution  # A, ln B, T_d of this response alone
    hold: float | None  # Sampling rate of the hold in front of the plant [Hz]; None for a continuous response
    stand_off: tuple[float, ...] = ()  # Frequencies of outlying lines, which were not fitted [Hz]

    def model(self, frequency: Real) -> Complex:
        """Return the fitted response [m/V] at frequencies [Hz], shape (n,)."""
        return self.solution.response(frequency, self.hold)

    def of(self, solution: PlantSolution, frequency: Real, *, friction: bool = True) -> Complex:
        """Return what another solution shows of this experiment [m/V], shape (n,), with friction or without."""
        values = solution.values.copy()
        values[2] = max(values[2], 0.0 if self.hold is None else hold_delay(self.hold))
        reversing = (self.measured.reversing or 0.0) if friction else 0.0
        return solution.form.response(values, frequency, self.hold, reversing)


@dataclass(frozen=True)
class FrictionInfluence:
    """Contribution of Coulomb friction to A: ``A_seen = A + F_c/M·gain``, its describing function along each motion."""

    gains: Real  # Equivalent gain of unit Coulomb friction along each motion [s/m], (r,); 0 where it never reverses
    seen: Real  # A fitted to each response alone [1/s], shape (r,)
    half: Real  # Half the 95 % interval of each, shape (r,)
    differs: bool  # Whether the responses show friction; False also where it could not be compared
    compared: bool  # Whether there were two amplitudes to compare
    coulomb: Estimate | None = None  # F_c/M [m/s²], where it was fitted


@dataclass(frozen=True)
class PlantFit:
    """The plant of eq. (1), identified from frequency responses."""

    axis: str  # axis, motion: name and motion of the axis
    motion: Motion
    estimates: dict[str, Estimate]  # A, B, T_d, and K_f where it is known
    solution: PlantSolution  # The fit of all responses together
    responses: tuple[ResponseFit, ...]  # Each response with its separate fit
    friction: FrictionInfluence  # What friction does to A
    hold: float | None  # Sampling rate of the hold [Hz]; None for a continuous response
    transport: Estimate  # T_d without half a sample of hold [s]
    second_mass: dict[str, Estimate] | None = None  # Of a table on a spring (`fric.drive.resonance`); None if unseen
    warnings: tuple[Notice, ...] = ()  # Warnings: what the data do not determine

    @property
    def plant(self) -> LinearPlant:
        """Eq. (1) without the contribution of friction to A."""
        return self.solution.plant()


LEAST_FILTER = 0.2  # T_f [samples] above which the lag counts as a filter
FORM = 0.01  # Error of the lag of a filter [samples] that is treated as continuous
DESCRIBED = 0.1  # Lag [samples] above which there is a warning
DEAD = 0.01  # Share of the input (rms) above which a dead zone gives a warning
PARTS, SURELY = 8, 6.0  # Parts of a record that determine a dead zone, and standard errors above which they do
DIFFERS = 0.05  # Share by which a force constant or a mass that the user states may differ from the identified value


@dataclass(frozen=True)
class ForceScale:
    """K_f, and the lag of the logged force."""

    K_f: Estimate | None  # Force constant [N/V]; None where it is not known
    lag: Estimate | None = None  # Lag of the force behind the input, filter included [s]; None if either was not logged
    filter: Estimate | None = None  # Corner of the first-order filter in the lag [Hz]; None where none is seen
    sampling: float = 0.0  # Sampling rate of the records [Hz]
    warnings: tuple[Notice, ...] = ()  # Their warnings

    @property
    def shift(self) -> float:
        """Return the lag if it exceeds its error and `DESCRIBED` samples, else 0 [s]."""
        return float(self.lag) if self.lag is not None and _matters(self.lag, self.sampling) else 0.0

    def estimates(self) -> dict[str, Estimate]:
        """Return the known values by their names in the plant file."""
        found = {"K_f": self.K_f, "force_lag": self.lag, "force_filter": self.filter}
        return {name: estimate for name, estimate in found.items() if estimate is not None}


def force_scale(
    logs: Sequence[Log], given: float | None, motion: Motion, *, period: float | None = None,
    segment: float | None = None, strokes: Sequence[Log] = (),
) -> ForceScale:  # fmt: skip
    """Return K_f [N/V] and the lag of the force, from the response of force to input if records have both.

    Otherwise, and if K_f is not given, strokes determine K_f, but not the lag.

    given: K_f [N/V], where the user knows it; the records then determine the lag, and check K_f.
    """
    unit = si_unit("force per input", motion)
    stated = None if given is None else Estimate(given, unit, fixed=True)
    both = [log for log in logs if log.input is not None and log.force is not None and np.ptp(log.input) > 0]
    both = [log for log in both if log.force is not None and clipped(log.force).mean() < CUT]
    answered: list[tuple[Log, Lines]] = []
    for log in both:
        with suppress(FricError):  # else it determines neither K_f nor the lag
            answered.append((log, force_lines(log, period, segment)))
    if not answered:
        steady, text = (stated, ()) if stated else steady_force_constant(strokes, motion)
        return ForceScale(steady, warnings=text)
    sampling = max(lines.hold or 0.0 for _, lines in answered)
    values, covariance, freedom = pooled_lags([lag_in_band(lines) for _, lines in answered])
    filtered = values[2] > 3 * np.sqrt(covariance[2, 2]) and values[2] > LEAST_FILTER / sampling
    if not filtered:
        values, covariance, freedom = pooled_lags([lag_in_band(lines, filtered=False) for _, lines in answered])
    quantile = float(stdtrit(freedom, 0.975))
    half = quantile * np.sqrt(np.diag(covariance))
    K_f, lag = float(np.exp(values[0])), float(values[1] + values[2])
    half_width_lag = quantile * float(np.sqrt(max(covariance[1:, 1:].sum(), 0.0)))
    if filtered:  # the unknown form and rate of the filter add an error of the lag
        half_width_lag = float(np.hypot(half_width_lag, FORM / sampling))
    late = Estimate.around(lag, si_unit("time", motion), half_width_lag)
    corner = None
    if filtered:
        T_low, T_high = (float(values[2] + side * half[2]) for side in (-1, 1))
        corner = Estimate(1 / (2 * np.pi * float(values[2])), "Hz", (1 / (2 * np.pi * T_high), 1 / (2 * np.pi * T_low)))
    found = Estimate.around_log(K_f, unit, float(half[0]))
    warnings = _lag_described(late, corner, sampling)
    warnings += [notice for log, _ in answered if (notice := _dead_zone(log, *values[1:3])) is not None]
    if stated is not None and abs(K_f / float(stated) - 1) > max(DIFFERS, float(half[0])):
        warnings.append(flaws.K_F_DIFFERS.found(given=stated, found=found))
    return ForceScale(stated or found, late, corner, sampling, tuple(warnings))


def force_lines(log: Log, period: float | None, segment: float | None) -> Lines:
    """Return the sure lines of F/U, over segments if there is no usable period, as in a sweep; raise `FricError`
    where there are fewer than three.
    """
    try:
        measured = measure_response(log, period=period, segment=segment, output="force")
    except FricError:
        if period is not None or segment is not None:
            raise
        measured = measure_response(log, segment=float(log.time[-1] - log.time[0]) / SEGMENTS, output="force")
    lines, _ = select(measured, hold=measured.sampling, coherence=0.0, least=3)
    return lines._replace(deviation=np.maximum(lines.deviation, FLOOR))


def _dead_zone(log: Log, delay: float, corner: float) -> Notice | None:
    """Return the warning where small inputs make no force: beyond a dead zone ±u_0 it is ``K_f·(u - u_0·sgn u)``.

    u_0 is regressed with K_f by parts of the record, both columns late as the force is [s]: of what a lag or a filter
    would leave, the sign of an input that is no Gaussian noise takes a part.
    """
    u, F = (log.require(channel, "a dead zone") for channel in ("input", "force"))
    n, interval = len(log), float(np.median(np.diff(log.time)))
    s = 2j * np.pi * np.fft.rfftfreq(n, interval)
    late = np.fft.irfft(np.fft.rfft([u, np.sign(u)]) * np.exp(-s * delay) / (1 + s * corner), n)
    X = np.column_stack([*late, np.ones(n)])
    parts = np.array_split(np.arange(n), PARTS + 2)[1:-1]  # at the ends both overlap
    found = np.array([np.linalg.lstsq(X[part], F[part], rcond=None)[0] for part in parts])
    slope, jump = found[:, :2].mean(axis=0)
    error = float(found[:, 1].std(ddof=1)) / np.sqrt(PARTS)
    if jump > -max(DEAD * slope * float(np.sqrt(np.mean(u**2))), SURELY * error):
        return None
    rises = Estimate(float(slope), si_unit("force per input", log.motion))
    return flaws.DEAD_ZONE.found(log.where, zone=Estimate(-jump / slope, log.unit("input")), slope=rises)


def _matters(lag: Estimate, sampling: float) -> bool:
    return abs(float(lag)) > max(DESCRIBED / sampling, lag.half_width)


def against_mass(estimates: dict[str, Estimate], mass: float | None, motion: Motion) -> list[Notice]:
    """Compare K_f/B with the moving mass that the user states, or take K_f from it where it is not known otherwise.

    estimates: B, and K_f where it is known; K_f is added where it is not.
    mass: Stated moving mass [kg or kg·m²]; None where the user does not know it.
    """
    if mass is None or "B" not in estimates:
        return []
    B, unit = estimates["B"], si_unit("mass", motion)
    if "K_f" not in estimates:
        low, high = B.ci95 or (float(B), float(B))
        interval = (mass * float(low), mass * float(high))  # type: ignore[arg-type]
        per_input = si_unit("force per input", motion)
        estimates["K_f"] = Estimate(mass * float(B), per_input, interval, source="the stated mass times B")
        return []
    found = float(estimates["K_f"]) / float(B)
    relative = [estimate.half_width / float(estimate) for estimate in (estimates["K_f"], B)]
    if abs(found / mass - 1) <= max(DIFFERS, float(np.hypot(relative[0], relative[1]))):
        return []
    return [flaws.MASS_DIFFERS.found(found=Estimate(found, unit), stated=Estimate(mass, unit))]


def _lag_described(lag: Estimate, corner: Estimate | None, sampling: float) -> list[Notice]:
    if not _matters(lag, sampling):
        return []
    size, samples = Estimate(abs(float(lag)), "s"), float(lag) * sampling
    return [flaws.FORCE_LAGS.found(lag=size, samples=abs(samples), late=samples, corner=corner)]


class FittedLag(NamedTuple):
    """K_f, delay and filter of one record."""

    values: Real  # ln K_f, τ [s], T_f [s]
    covariance: Real
    freedom: float
    residual: Real  # Real and imaginary parts over their deviation, shape (2, n), by frequency


def lag_in_band(lines: Lines, filtered: bool = True) -> FittedLag:
    """Fit the widest band from the lowest line on whose residual is noise, not a pattern."""
    top = float(lines.frequency.max())
    while True:
        fitted = _fit(at(lines, lines.frequency <= top), filtered)
        fewer = np.count_nonzero(lines.frequency <= top / 2)
        if fewer < FEW_LINES or not any(statistics.smoother_than_noise(part, -3.09) for part in fitted.residual):
            return fitted
        top /= 2


def _fit(lines: Lines, filtered: bool) -> FittedLag:
    """Fit ln K_f, τ, and T_f where there is a filter, on the complex logarithm; the lines share the misfit."""
    omega = 2 * np.pi * lines.frequency
    top = float(omega.max())
    start = np.array([float(np.log(np.abs(lines.response[0]))), _first_delay(lines), 0.05 / top])[: 2 + filtered]
    lower, scale = [-np.inf, -np.inf, 0.0][: len(start)], [0.01, 0.01 / top, 0.01 / top][: len(start)]
    misfit, n = 0.0, len(start)

    def residual(x: Real) -> Real:
        model = np.exp(x[0] - 1j * omega * x[1]) / (1 + 1j * omega * (x[2] if filtered else 0.0))
        return residual_of(model, lines, misfit)

    for _ in range(8):
        found = optimize.least_squares(
            residual, start, bounds=(lower, np.inf), x_scale=scale, xtol=1e-12, ftol=1e-12, gtol=1e-12
        )
        start = found.x if not filtered else np.append(found.x[:2], max(found.x[2], 1e-6 / top))
        chi2 = 2 * float(found.cost) / max(2 * len(omega) - n, 1)
        if abs(chi2 - 1) < 0.02 or (misfit == 0.0 and chi2 < 1):
            break
        grown = float(np.median(np.hypot(lines.deviation, misfit))) * float(np.sqrt(max(chi2, 1e-12)))
        misfit = float(np.sqrt(max(grown**2 - float(np.median(lines.deviation)) ** 2, 0.0)))
    covariance = np.zeros((3, 3))
    covariance[:n, :n] = statistics.parameter_covariance(np.asarray(found.jac)) * max(chi2, 1.0) * lines.correlation
    freedom = max((2 * len(omega) - n) / lines.correlation, 1.0)
    return FittedLag(np.append(found.x, [0.0] * (3 - n)), covariance, freedom, found.fun.reshape(2, -1))


def _first_delay(lines: Lines) -> float:
    """Return the delay [s] near the best, from a grid: the phase is wrapped, and so are delays beyond 1/spacing."""
    omega = 2 * np.pi * lines.frequency
    weight = np.minimum(1 / lines.deviation, 1e3) ** 2
    longest = min(LONGEST, 0.4 / float(np.diff(lines.frequency).min()))
    step = min(0.1 / float(lines.frequency.max()), longest / 4)
    delays = step * np.arange(-np.floor(longest / 4 / step), np.ceil(longest / step) + 1)
    turned = np.angle(lines.response * np.exp(1j * np.outer(delays, omega))) ** 2 @ weight
    return float(delays[int(np.argmin(turned))])


def pooled_lags(fits: Sequence[FittedLag]) -> tuple[Real, Real, float]:
    """Return the weighted mean of records, its covariance with their differences, and its freedom."""
    freedom = sum(fit.freedom for fit in fits)
    if len(fits) == 1:
        return fits[0].values, fits[0].covariance, freedom
    values = np.array([fit.values for fit in fits])
    variances = np.array([np.diag(fit.covariance) for fit in fits]) + 1e-30
    weights = 1 / variances
    mean = (weights * values).sum(axis=0) / weights.sum(axis=0)
    excess = (weights * (values - mean) ** 2).sum(axis=0) / (len(fits) - 1)
    variance = np.maximum(excess, 1.0) / weights.sum(axis=0)
    joint = fits[0].covariance / np.sqrt(np.outer(variances[0], variances[0]))
    return mean, joint * np.sqrt(np.outer(variance, variance)), freedom


def steady_force_constant(logs: Sequence[Log], motion: Motion) -> tuple[Estimate | None, tuple[Notice, ...]]:
    """Return K_f [N/V] as the slope of mean force over mean input of steady segments, and warnings.

    logs: Strokes at constant velocity; those without force or input have no part in it.
    motion: Motion of the axis. Returns none if fewer than `MEANS` segments are steady, or all have the same voltage.
    """
    means = [
        (float(np.mean(log.input[part.start : part.stop])), float(np.mean(log.force[part.start : part.stop])))
        for log in logs if log.force is not None and log.input is not None
        for part in steady_segments(log) if clipped(log.force)[part.start : part.stop].mean() < CUT
    ]  # fmt: skip
    u, F = np.array(means, float).reshape(-1, 2).T
    if len(u) < MEANS or np.ptp(u) == 0.0:
        return None, ()
    level = u - u.mean()
    slope = float(level @ F / (level @ level))
    off = F - F.mean() - slope * level
    error = float(np.sqrt(off @ off / (len(u) - 2) / (level @ level)))
    half_width = float(stdtrit(len(u) - 2, 0.975)) * error
    source = f"mean force over mean input of {len(u)} steady segments"
    found = Estimate.around(slope, si_unit("force per input", motion), half_width, source=source)
    share = float(np.sqrt(off @ off / len(u))) / float(np.ptp(F))
    return found, () if share <= BENT else (flaws.FORCE_NOT_PROPORTIONAL.found(segments=len(u), off=share),)


CUT = 0.01  # Share of clipped samples from which on a force does not tell the force constant
GAINS_APART = 0.05  # Share by which the friction's gain must differ between records to compare their amplitudes
UNSURE_BETA, UNSURE_SHIFT = 0.4, 0.25
"""Error of β as a share of A and β, and of A, B and T_d as a share of what β changes: chosen on 152 axes, simulated
around rest by two friction models, of which 148 have B in its interval; of 50 more all have. Without β 18 of 47 had."""
UNSURE_SWEEP = 0.33
"""Deviation of ln B in a sweep, as a share of what friction has in the response: of 32 axes simulated by LuGre and an
elasto-plastic model, with no fric code, its rms is 0.33, where a multisine leaves 0.05 (14 axes)."""
SURE = 0.99  # Probability below which two responses count as different

Method = Literal["response", "motion"]


@one_blas_thread()
def identify_plant(  # noqa: PLR0913 - the verb of its name gives each setting
    records: Sequence[Log | FrequencyResponse], *, hold: float | None = None, continuous: bool = False,
    coherence: float = 0.5, band: tuple[float, float] = (0.0, np.inf), period: float | None = None,
    segment: float | None = None, given_force_constant: float | None = None, mass: float | None = None,
    strokes: Sequence[Log] = (), delay: float | None = None,
) -> PlantFit:  # fmt: skip
    """Fit A, B and T_d of eq. (1) to one or more frequency responses of one axis.

    A record in time includes the zero-order hold of the controller; a table is continuous. If two records differ in
    amplitude, the describing function of Coulomb friction is removed from A; if friction cannot be separated from A, A
    is assumed to be 0, and strokes show all damping as viscous friction.

    hold: Sampling rate of the hold [Hz]; that of the record where not given.
    continuous: Take every response as that of eq. (1) itself, without hold and sampling.
    given_force_constant: K_f [N/V], where no force was logged.
    mass: Moving mass [kg], where the user knows it: K_f/B is checked against it, or K_f taken from it.
    strokes: Records at constant velocity, which determine K_f where no record of a response has a force.
    delay: T_d [s] of a logged effort, which its response does not show.
    Raises FricError: When a record gives no response, too few lines are certain, or the sign of input or position is
        wrong.
    """
    # of the records as they were logged: what is made up for along a cubic looks like jitter
    clocks = [record_flaws([given], "plant") if isinstance(given, Log) else [] for given in records]
    even, uneven = zip(*(evened(given) if isinstance(given, Log) else (given, []) for given in records), strict=True)
    logs = [record for record in even if isinstance(record, Log)]
    fits, sets = [], []
    for measured, clock in zip(_measured(even, clocks, period, segment), clocks, strict=True):
        held = None if continuous else hold or measured.sampling
        # a measured effort acts when it is logged, and a drive's command is held: the response shows which
        either = is_effort(measured.table.motion) and drive_unit(measured.table.motion) != "V" and not hold
        tried = []
        for rate in dict.fromkeys((None, held) if either else (held,)):
            with _blamed_on(clock):
                lines, used = select(measured, hold=rate, coherence=coherence, band=band)
            with found_in(measured.table.where):
                tried.append((*solve_with_modes(lines), lines, used, rate))
        solution, kept, lines, used, rate = min(tried, key=lambda found: found[0].chi2)
        used[np.flatnonzero(used)[~kept]] = False
        fits.append(ResponseFit(measured, used, solution, rate, tuple(float(f) for f in lines.frequency[~kept])))
        sets.append(at(lines, kept))
    solution, influence = _joined(fits, sets)
    motion = fits[0].measured.table.motion
    around_rest = _holds_friction(fits, influence)
    if around_rest:
        solution = _with_hysteresis(solution, sets, any(fit.measured.sweeps for fit in fits))
    rate = min((fit.hold for fit in fits if fit.hold is not None), default=None)
    estimates = solution.estimates(motion)
    if is_effort(motion):
        estimates |= effort_estimates(motion, delay, estimates["T_d"])
        scale = ForceScale(estimates["K_f"])
    else:
        scale = force_scale(logs, given_force_constant, motion, period=period, segment=segment, strokes=strokes)
        estimates |= scale.estimates()
    others = [*chain(*uneven), *scale.warnings, *against_mass(estimates, mass, motion)]
    transport = estimates["T_d"]
    if rate is not None:
        low, high = transport.ci95 or (0.0, 0.0)
        half = hold_delay(rate)
        transport = replace(transport, value=float(transport) - half, ci95=(low - half, high - half))  # type: ignore[operator]
    notices = list(described(fits, solution, influence, estimates, rate))
    if around_rest and not is_effort(motion):
        # strokes show all viscous friction, where no damping is subtracted
        high = max(float(estimates["A"]), 0.0) + float(solution.half_widths()[0])
        estimates["A"] = replace(estimates["A"], value=0.0, ci95=(0.0, high), assumed=True)
    return PlantFit(
        fits[0].measured.table.axis, motion, estimates, solution, tuple(fits), influence, rate, transport,
        solution.second_mass(), (*notices, *others, *chain.from_iterable(clocks)),
    )  # fmt: skip


@contextmanager
def _blamed_on(clock: Sequence[str]) -> Iterator[None]:
    """Name an error of a record's clock as the cause of an exception, if there is one."""
    try:
        yield
    except FricError as error:
        if not clock:
            raise
        raise FricError(error.what, where=error.where, hint=f"The cause may be this: {clock[0]}") from None


def _measured(
    records: Sequence[Log | FrequencyResponse], clocks: Sequence[Sequence[str]], period: float | None,
    segment: float | None,
) -> list[MeasuredResponse]:  # fmt: skip
    """Return the responses of records, at lines that are driven according to all of them."""
    measured = []
    for record, clock in zip(records, clocks, strict=True):
        with _blamed_on(clock):
            measured.append(measure_response(record, period=period, segment=segment))
    for n, driven in enumerate(driven_alike([found.lines for found in measured])):
        known = measured[n].lines
        if known is not None and driven is not None and np.any(driven != known.driven):
            measured[n] = measure_response(records[n], period=period, segment=segment, driven=driven)
    return measured


def _joined(fits: Sequence[ResponseFit], sets: Sequence[Lines]) -> tuple[PlantSolution, FrictionInfluence]:
    """Return the fit of all responses, with Coulomb friction where two amplitudes show it."""
    gains = np.array([np.nan if fit.measured.reversing is None else fit.measured.reversing for fit in fits])
    seen = np.array([fit.solution.values[0] for fit in fits])
    half = np.array([fit.solution.half_widths()[0] for fit in fits])
    alone = FrictionInfluence(gains, seen, half, differs=False, compared=False)
    if len(fits) == 1:
        return fits[0].solution, alone
    misfits = [fit.solution.misfit for fit in fits]
    seen_modes = [fit.solution for fit in fits if fit.solution.form.encoder]
    mode = seen_modes[0].form.resonance(seen_modes[0].values) if seen_modes else None
    together = solve(sets, misfits=misfits, resonance=mode)
    if np.any(np.isnan(gains)) or np.ptp(gains) <= GAINS_APART * np.max(np.abs(gains)):
        return together, alone
    slope, level = np.polyfit(gains, seen, 1)  # a search from 0 may end where A of one record is held at 0
    start = np.array([max(float(level), 0.0), *fits[int(np.argmin(gains))].solution.values[1:3], slope])
    split = solve(sets, friction="coulomb", misfits=misfits, resonance=mode, start=start)
    value, deviation = float(split.values[3]), float(np.sqrt(split.covariance[3, 3]))
    alike = max(_alike(split, lines, misfit) for lines, misfit in zip(sets, misfits, strict=True))
    quantile = float(stdtrit(split.freedom, 0.975))
    rest = np.zeros(len(split.values))  # of B and T_d, which pre-sliding moves and its describing function does not
    rest[1:3] = np.polyfit(gains, [fit.solution.values[1:3] for fit in fits], 1)[1] - split.values[1:3]
    split = replace(split, covariance=split.covariance * alike + np.outer(rest, rest) / quantile**2)
    half_width = quantile * deviation * float(np.sqrt(alike))
    length = "rad" if rotates(fits[0].measured.table.motion) else "m"
    coulomb = Estimate.around(value, f"{length}/s^2", half_width)
    differs = abs(value) > float(stdtrit(split.freedom, (1 + SURE) / 2)) * deviation
    found = FrictionInfluence(gains, seen, half, differs=differs, compared=True, coulomb=coulomb)
    return (split if differs and value > 0 else together), found


def _with_hysteresis(plain: PlantSolution, sets: Sequence[Lines], sweeps: bool) -> PlantSolution:
    """Return a fit with the hysteresis of friction; its errors allow for what is not this hysteresis.

    sweeps: Whether the excitation is a swept sine, whose amplitude, and so friction's damping, changes with frequency.
    """
    solution = solve(sets, friction="hysteresis", resonance=plain.form.resonance(plain.values), start=plain.values[:3])
    C, quantile = solution.covariance, float(stdtrit(solution.freedom, 0.975))
    along = C[3] / max(C[3, 3], 1e-300)  # what an error of β changes
    least = UNSURE_BETA * (solution.values[0] + solution.values[3]) / quantile
    moved = np.zeros(len(along))
    moved[:3] = UNSURE_SHIFT * (solution.values[:3] - plain.values[:3]) / quantile
    C = C + np.outer(along, along) * max(least**2 - C[3, 3], 0.0) + np.outer(moved, moved)
    if sweeps:
        friction = complex(solution.values[3], solution.values[0])
        omega = 2 * np.pi * np.concatenate([lines.frequency for lines in sets])
        C[1, 1] += (UNSURE_SWEEP * float(np.mean(np.abs(friction / (friction - omega))))) ** 2
    return replace(solution, covariance=C)


def _alike(solution: PlantSolution, lines: Lines, misfit: float) -> float:
    """Return the number of neighbouring lines per independent line, by the correlation of residuals: what friction
    around rest is beyond its describing function is no noise, and similar from line to line.
    """
    model = solution.form.response(solution.values, lines.frequency, lines.hold, lines.reversing)
    return statistics.memory(np.log(lines.response / model) / np.hypot(lines.deviation, misfit))


def plant_records(
    records: Sequence[Record], method: Method | None = None
) -> tuple[Method, list[Log | FrequencyResponse]]:
    """Return the method and its records: frequency responses if there are any, else motions.

    A response that is recognised in a record without a kind counts as stated.

    method: The method, where the user chooses it; a record of any kind is then used.
    """
    refuse_several_axes(records)
    dynamic = [r for r in records if not isinstance(r, ForceVelocity)]
    in_time: list[Log | FrequencyResponse] = [r for r in records if isinstance(r, Log)]
    excited = [isinstance(r, FrequencyResponse) or kind_of(r) == "frequency-response" for r in dynamic]
    asked, method = method is not None, method or ("response" if any(excited) else "motion")
    taken = {"motion", None, *(["constant-velocity"] if asked else [])}
    chosen: list[Log | FrequencyResponse] = [
        r for r, response in zip(dynamic, excited, strict=True)
        if (response if method == "response" else not response and isinstance(r, Log) and r.kind in taken)
    ]  # fmt: skip
    if asked and not chosen:
        chosen = in_time
    if not chosen:
        kinds = ", ".join(sorted({str(r.kind) for r in in_time if isinstance(r, Log)})) or "tables"
        what = f"no record is of kind frequency-response or motion (there are {kinds})"
        hint = "Say `method='response'` or `method='motion'` to take them as such."
        raise FricError(what, where=records[0].source, hint=hint)
    return method, chosen


UNLIKE = 0.02  # Misfit of eq. (1) above which a second mass is searched for [1]
OFF = 6.0  # Ratio to the usual residual above which a line is an outlier
VISIBLE = 0.01  # Least relative residual of an outlying line
MOST_OUTLIERS = 0.35  # Largest share of outlying lines: with more, the model is wrong
ROUGH = 0.03  # Misfit assumed in the search for the best start [1]
GAIN = 40.0  # Least relative reduction of the sum of bounded squared residuals by an accepted second mass
BELOW = 3.0  # Least ratio of a second mass's frequency to the lowest line: below it, lines show the rigid axis


class Found(NamedTuple):
    """A fit and its lines."""

    solution: PlantSolution
    kept: Mask  # Which lines belong to the fit, shape (n,)


def solve_with_modes(lines: Lines) -> Found:
    """Fit eq. (1), with a second mass where the response shows it, without outlying lines.

    A line that is not driven, but moved by friction's harmonics, shows the inverse of the controller and is an outlier.
    Such lines are left out for each form; a second mass is accepted if it explains the lines far better, with bounded
    residuals.

    Raises FricError: When the sign of input or position is turned.
    """
    rigid = _without_outliers(lines, None)
    if rigid.solution.misfit < UNLIKE and np.all(rigid.kept):
        return rigid
    found = _best_mode(lines)
    if found is None:
        return rigid
    scale = max(statistics.robust_deviation(_off(lines, found.solution)[found.kept]), 1e-3)
    bounded = [float(np.sum(np.minimum(np.abs(_off(lines, fit.solution)) / scale, OFF) ** 2)) for fit in (rigid, found)]
    return found if bounded[0] - bounded[1] > GAIN and _is_determined(found.solution, at(lines, found.kept)) else rigid


def _is_determined(solution: PlantSolution, lines: Lines) -> bool:
    """Return whether the lines determine frequency and ratio of a second mass, and the rigid axis below it as well.

    Friction around rest is a spring, too: in a small motion it causes a resonance at or below the lowest lines. A
    resonance above all lines was not measured: a filter, or a delay of a fraction of a sample, has the same effect.
    """
    half, values = solution.half_widths()[3:], solution.values[3:]
    ratio = len(values) < 3 or bool(half[2] < values[2] < 0.99)
    within = BELOW * float(lines.frequency.min()) <= float(np.exp(values[0])) <= float(lines.frequency.max())
    return ratio and within and bool(half[0] < 0.1)


def _best_mode(lines: Lines) -> Found | None:
    """Return the best fit with a second mass, for a motor or a table encoder; None with too few lines."""
    low, high = float(lines.frequency.min()), float(lines.frequency.max())
    if len(lines.frequency) < 10 or high < 4 * low:
        return None
    encoders: tuple[Encoder, ...] = ("motor", "table")
    grid = np.geomspace(BELOW * low, 1.2 * high, 24)
    starts = [start for encoder in encoders for start in _starts(lines, encoder, grid)[:2]]
    rough = [solve([lines], resonance=resonance, start=start, misfits=[ROUGH]) for resonance, start in starts]
    if not rough:
        return None
    rough.sort(key=lambda solution: len(solution.values))
    offs = (np.abs(_off(lines, solution)) for solution in rough)
    best = rough[simplest(float(np.mean(np.log(off + 1e-3))) for off in offs)]  # robust to outlying lines
    return _without_outliers(lines, best.form.resonance(best.values), best.values[:3])


def _starts(lines: Lines, encoder: Encoder, frequencies: Real) -> list[tuple[Resonance, Real]]:
    """Return second masses by how well eq. (1) explains the rest of the response, the best first."""
    tried = []
    for frequency in frequencies:
        for ratio in (0.15, 0.4, 0.7) if encoder == "motor" else (UNDETERMINED,):
            resonance = Resonance(float(frequency), ratio, 0.03, encoder)
            without = lines._replace(response=lines.response / resonance.factor(0.0, lines.frequency))
            try:
                start, cost = near(without, 12, 60)
            except FricError:
                continue
            tried.append((cost, resonance, start))
    return [(resonance, start) for _, resonance, start in sorted(tried, key=lambda mode: mode[0])]


def _without_outliers(lines: Lines, resonance: Resonance | None, start: Real | None = None) -> Found:
    kept = np.ones(len(lines.frequency), bool)
    solution = solve([lines], resonance=resonance, start=start)
    for _ in range(6):
        off = np.abs(_off(lines, solution))
        usual = statistics.robust_deviation(off[kept])
        outlying = off > np.maximum(OFF * np.hypot(usual, lines.deviation), VISIBLE)
        if np.count_nonzero(outlying) > MOST_OUTLIERS * len(outlying) or np.array_equal(~outlying, kept):
            break
        kept = ~outlying
        start = solution.values[:3]
        solution = solve([at(lines, kept)], resonance=solution.form.resonance(solution.values), start=start)
    return Found(solution, kept)


def _off(lines: Lines, solution: PlantSolution) -> Complex:
    return np.asarray(np.log(lines.response / solution.response(lines.frequency, lines.hold)))


def described(
    fits: Sequence[ResponseFit], solution: PlantSolution, friction: FrictionInfluence, estimates: dict[str, Estimate],
    hold: float | None,
) -> Iterator[Notice]:  # fmt: skip
    """Yield the warnings of a fit."""
    for fit in fits:
        name = fit.measured.table.name
        yield from (warning.at(name) for warning in fit.measured.warnings)
        if fit.stand_off:
            yield response.LINES_STAND_OFF.found(name, count=len(fit.stand_off), lines=list(fit.stand_off))
        if (size := fit.solution.misfit) > 0:
            f = fit.measured.table.frequency[fit.used]
            apart = np.log(fit.measured.response[fit.used] / fit.model(f))
            worst, below = float(f[int(np.argmax(np.abs(apart)))]), float(np.sqrt(f.min() * f.max()))
            bound = (
                {"edge": "lowest", "limit": 2.0 * worst} if worst < below else {"edge": "highest", "limit": 0.5 * worst}
            )
            wrong = size >= response.FALSE and not (fit.solution.freedom > FREE and _scatter(apart))
            yield response.RESPONSE_MISFIT.found(name, wrong=wrong, misfit=size, worst=worst, **bound)
    if (mode := solution.form.resonance(solution.values)) is not None:
        by_motor = mode.encoder == "motor"
        frequency, share = Estimate(mode.frequency, "Hz"), mode.ratio if by_motor else 0.0
        yield response.SECOND_MASS.found(encoder=mode.encoder, frequency=frequency, share=share)
        if by_motor:
            yield response.SPRING_IN_SERIES.found()
    if not estimates["A"].fixed:  # else, behind an effort, what is viscous is friction
        yield from _of_friction(fits, friction, estimates)
        yield response.A_HOLDS_VISCOUS.found()
    if not estimates["A"].fixed and float(estimates["A"]) <= float(solution.half_widths()[0]):
        yield response.A_OPEN.found(lowest=min(float(fit.measured.table.frequency[fit.used].min()) for fit in fits))
    edge = hold_delay(hold) if hold else 0.0
    if float(estimates["T_d"]) <= edge * (1 + 1e-6):
        yield response.T_D_AT_BOUND.found(hold=bool(hold))
    if estimates["T_d"].assumed:
        yield response.T_D_ASSUMED.found(effort=True)
    if "K_f" not in estimates:
        yield flaws.K_F_MISSING.found()


def _scatter(apart: Complex) -> bool:
    """Return whether what is left at neighbouring lines differs, as by friction around rest: a structure's is alike."""
    return all(abs(float(x[1:] @ x[:-1])) < NEIGHBOURS * float(x @ x) for x in (apart.real, apart.imag))


def _of_friction(
    fits: Sequence[ResponseFit], friction: FrictionInfluence, estimates: dict[str, Estimate]
) -> Iterator[Notice]:
    gains = friction.gains
    if friction.differs and friction.coulomb is not None:
        if float(friction.coulomb) < 0:
            yield response.AMPLITUDES_DISAGREE.found()
            return
        low, high, A = friction.seen.min(), friction.seen.max(), float(estimates["A"])
        yield response.FRICTION_IN_RESPONSE.found(low=low, high=high, A=A, coulomb=friction.coulomb)
        return
    if friction.compared or not np.any(np.nan_to_num(gains) > 0):
        return
    gain = float(np.nanmax(gains)) * float(estimates["B"])
    per, unit = gain, "volt"
    if "K_f" in estimates:
        per, unit = gain / float(estimates["K_f"]), estimates["K_f"].unit.partition("/")[0]
    each = f"each {unit} of Coulomb friction adds {per:.3g} 1/s to it"
    yield response.A_HOLDS_FRICTION.found(each=each, small=not _holds_friction(fits, friction), limit=SMALL)


def _holds_friction(fits: Sequence[ResponseFit], friction: FrictionInfluence) -> bool:
    """Return whether friction may be more than a small share of A, and no two amplitudes separate it."""
    small = all(share is not None and share < SMALL for share in map(_friction_seen, fits))
    return not (friction.compared or small) and bool(np.any(np.nan_to_num(friction.gains) > 0))


def _friction_seen(fit: ResponseFit) -> float | None:
    """Return an upper bound of Coulomb friction's share of A, by the lines that are not driven; None without these.

    Along a motion that is about normally distributed, sign(v) is 2/π in power like v, which is in A; the rest of
    1 - 2/π is at all lines, and what it takes in voltage at those that are not driven, ``Z/G - U``, shows its level.
    It reaches to about three times the highest line that is used; the factor of 2 is for caution.
    """
    lines, gain = fit.measured.lines, fit.measured.reversing
    if lines is None or gain is None:
        return None
    f = fit.measured.table.frequency[fit.used]
    within = ~lines.driven & (lines.frequency >= f.min()) & (lines.frequency <= min(float(f.max()), QUIET))
    if np.count_nonzero(within) < 3:
        return None
    voltage = lines.position[within] / fit.model(lines.frequency[within]) - lines.input[within]
    count = 3 * QUIET / float(lines.frequency[0])
    power = 2 * float(np.mean(np.abs(voltage) ** 2)) * count
    level = 2 * np.sqrt(power / (1 - 2 / np.pi))
    plant = fit.solution.plant()
    return float(level * plant.B * gain / max(plant.A, 1e-300))


UNEVEN = 0.05  # Share of the viscous friction by which directions differ from their mean, above which it is warned of
REST = 0.05  # Share of the largest speed below which the axis rests or creeps, and the force does not show friction
ONE_WAY = 0.02  # Travel of a motion one way over that the other way below which it goes one way
RESTS = 0.1  # Share of such samples above which they are left out; without a filter they always are
FEWEST = 30  # Least number of samples of a fit

RigidAxis = tuple[Real, Real]  # M, F_v, F_c and offset of a rigid axis, shape (4,), and their covariance (4, 4)


@dataclass(frozen=True)
class MotionFit:
    """A rigid axis fitted to its motion: ``force = M·z̈ + F_v·ż + F_c·sign(ż) + offset``."""

    axis: str  # axis, motion: name and motion of the axis
    motion: Motion
    channel: Literal["force", "input"]  # ``input`` without force or K_f: then all are in volts (per m/s², per m/s)
    estimates: dict[str, Estimate]  # M, F_v, F_c (or F_v, F_c by direction), offset; for correlated residuals
    deviation: dict[str, float]  # Standard deviations by ordinary least squares, for independent residuals
    plant: dict[str, Estimate]  # A, B, T_d of eq. (1), and K_f where it is known.
    relative_error: float  # ``‖residual‖/‖force‖`` [1]
    condition_number: float  # Of the observation matrix
    autocorrelation: float  # Of neighbouring residuals, after decimation
    sampling: float  # sampling, conditioning: sampling rate [Hz] and filters of the first record
    conditioning: Conditioning
    time: Real  # time, measured, fitted: decimated samples: instants [s], logged and fitted force, each of shape (n,)
    measured: Real
    fitted: Real
    warnings: tuple[Notice, ...] = ()  # Warnings: what the data do not determine


def identify_motion(  # noqa: PLR0913 - the verb of its name gives each setting
    logs: Sequence[Log], *, direction: Literal["both", "each"] = "both", force_constant: float | None = None,
    delay: float | None = None, cutoff: float | None = None, decimation: int | None = None, border: int | None = None,
    mass: float | None = None, replayed: Callable[[Sequence[Prepared]], RigidAxis | None] | None = None,
    place: ForceOverPosition | Literal["none"] | None = None,
) -> MotionFit:  # fmt: skip
    """Fit a rigid axis to motions by least squares on zero-phase filtered, decimated signals.

    The inverse dynamic model of Janot, Gautier and Brunot (Nonlinear System Identification Benchmarks, 2019):
    the position is filtered forwards and backwards, differentiated by central differences, and each column of the
    observation matrix is decimated like the force. Where the rate would put the filter's corner into the motion there
    is no filter; many rests, and samples between which the speed changes, are left out.

    logs: Records of one axis, each with a force or an input; instants that jitter are made even. A record that hardly
        accelerates beside another is left out: it shows no mass, and friction that is not of sliding.
    direction: Common F_v, F_c and an offset, or F_v and F_c for each direction (an offset is then half their
        difference).
    force_constant: K_f [N/V]; with it an input is used as force.
    delay: T_d [s], which a motion does not show; by default half a sample. If given, it is the delay of the force after
        its voltage.
    cutoff, decimation, border: See `Conditioning`; chosen from the sampling rate where not given.
    replayed: Gives the estimates of motions by a law that falls with speed and yields before it slides; they are taken
        where their intervals are narrower, or they are outside of those of the rigid fit.
    place: Force over position that was taken off, or "none"; by default the one that strokes at constant velocity show.
    Raises FricError: When neither force nor input was logged, the sampling is uneven, or the motion does not separate
        the terms.
    """
    asked, motion, amiss = logs, logs[0].motion, record_flaws(logs, "plant")
    given = {"direction": direction, "force_constant": force_constant, "delay": delay, "cutoff": cutoff,
             "decimation": decimation, "border": border, "mass": mass, "replayed": replayed}  # fmt: skip
    bare = all(is_effort(log.motion) or log.input is None for log in logs)  # else K_f would have what is taken off
    placed = bare and place is None and all(log.position is not None and log.force is not None for log in logs)
    if placed and (place := cogging([(log, part) for log in logs for part in steady_segments(log)])):
        fit = identify_motion([place.less(log) for log in logs], **given, place=place)  # type: ignore[arg-type]
        varies = Estimate(2**0.5 * place.varies, logs[0].unit("force"))
        length = Estimate(float(np.ptp(place.places)), logs[0].unit("position"))
        said = FORCE_OVER_POSITION.found(varies=varies, length=length, either=False, taken_off=True, level=np.inf)
        return replace(fit, warnings=(*fit.warnings, said))
    place = None if place == "none" else place
    logs, clocks = zip(*map(evened, logs), strict=True)
    channel: Literal["force", "input"] = (
        "force" if all(log.force is not None for log in logs) or force_constant is not None else "input"
    )
    rates = [even_sampling(log) for log in logs]
    settings = [Conditioning.of(rate, cutoff, decimation, border) for rate in rates]
    effort = is_effort(motion)
    acting = effort_estimates(motion, delay) if effort else {}
    scale = ForceScale(acting["K_f"], acting["T_d"]) if effort else force_scale(logs, force_constant, motion)
    scaled = force_constant is not None
    served = [
        replace(log, force=None) if channel == "input" or (scaled and log.input is not None) else log for log in logs
    ]
    settings = [replace(s, cutoff=0.0) if cutoff is None and s.cutoff < 5 * BANDWIDTH else s for s in settings]
    timing = (0.0, 0.0) if effort else (delay or 0.0, scale.shift)
    drive = Drive(force_constant or 1.0, *timing)
    records = prepared(served, drive=drive, filters=settings)
    shown = [_in_motion(record, s) for record, s in zip(records, settings, strict=True)]
    shown = [record.restricted(place.covers(record.log)) for record in shown] if place else shown
    pairs = zip(shown, settings, strict=True)
    settings = [s if record.used[s.border :].all() else replace(s, decimation=1) for record, s in pairs]
    sizes = [float(np.linalg.norm(r.motion.acceleration[r.used])) / max(r.used.sum(), 1) ** 0.5 for r in shown]
    idle = [size < ACCELERATES * max(sizes) for size in sizes]
    if any(idle):
        kept_logs = [log for log, rests in zip(asked, idle, strict=True) if not rests]
        fit = identify_motion(kept_logs, **given, place=place)  # type: ignore[arg-type]
        whose = ", ".join(log.name for log in compress(logs, idle))
        why = f"{whose}: less than {ACCELERATES:.0%} of another record's acceleration"
        return replace(fit, warnings=(*fit.warnings, RECORD_LEFT_OUT.found(logs[0].source, why=why)))
    names = ("M", "F_v", "F_c", "offset") if direction == "both" else ("M", *_EACH)
    X = np.vstack([_observations(record, s, direction) for record, s in zip(shown, settings, strict=True)])
    forces = [thinned(record.drive[record.used], s.decimation) for record, s in zip(shown, settings, strict=True)]
    times = [record.log.time[record.used] for record in shown]
    times = [t[kept(len(t), s.decimation)] for t, s in zip(times, settings, strict=True)]
    y, time = np.concatenate(forces), np.concatenate(times)
    if len(y) < FEWEST or not any(shows_mass(record.motion, record.used) for record in shown):
        what = f"at {readable(max(rates), 'Hz', 3)} the speed changes between samples, and the mass is not seen"
        raise FricError(what, where=logs[0].where, hint="Log ten samples or more of each start and stop.")
    _refuse_rank(X, names, logs[0])

    values = np.asarray(np.linalg.lstsq(X, y, rcond=None)[0], float)
    residual = y - X @ values
    deviation = np.std(residual, ddof=1) * np.sqrt(np.diag(np.linalg.inv(X.T @ X)))
    lengths = [len(force) for force in forces]
    covariance = statistics.hac_covariance(X, residual, lengths)
    quantile = float(stdtrit(len(y) - len(values), 0.975))
    lags = ((record.done.timing * np.gradient(record.drive, record.log.time))[record.used] for record in shown)
    rates_of = [thinned(lag, s.decimation) for lag, s in zip(lags, settings, strict=True)]
    covariance = covariance + _of_timing(X, np.concatenate(rates_of), residual, lengths)
    ends = np.cumsum(lengths)[:-1]
    between = statistics.between_records(np.split(X, ends), np.split(residual, ends), quantile)
    if between is not None:
        covariance = covariance + between.covariance
    if replayed is not None and direction == "both" and (cutoff, decimation, border) == (None,) * 3:
        with suppress(FricError):  # a replay needs more of a record than this fit
            whole = list(prepared([replace(log, kind="motion") for log in served], drive=drive))
            whole = [record.restricted(place.covers(record.log)) for record in whole] if place else whole
            values, covariance = _finer((values, covariance), replayed(whole))
            residual = y - X @ values
    if place is not None:
        at = (record.log.require("position", "it")[record.used] for record in shown)
        z = [thinned(places, s.decimation) for places, s in zip(at, settings, strict=True)]
        covariance = covariance + place.moves(X, np.concatenate(z))

    half = quantile * np.sqrt(np.diag(covariance))
    units = [_unit(name, channel, motion) for name in names]
    rows = zip(names, values, half, units, strict=True)
    estimates = {name: Estimate.around(float(v), unit, float(h)) for name, v, h, unit in rows}

    K_f = scale.K_f
    plant = scale.estimates() | _plant(
        np.asarray(values, float), covariance, quantile, direction, channel, K_f, delay, hold_delay(max(rates)), motion
    )
    plant |= acting
    lag = float(residual[1:] @ residual[:-1] / (residual @ residual))
    return MotionFit(
        logs[0].axis, motion, channel, estimates, dict(zip(names, map(float, deviation), strict=True)), plant,
        float(np.linalg.norm(residual) / np.linalg.norm(y)), float(np.linalg.cond(X)), lag, rates[0], settings[0],
        time, y, X @ values,
        (*_varies(between, estimates), *_directions(X, y, lengths, estimates),
         *_warnings(records, settings[0].border, estimates, K_f, assumed=delay is None),
         *scale.warnings, *against_mass(plant, mass, motion), *chain(*clocks), *amiss),
    )  # fmt: skip


def _finer(rigid: RigidAxis, replay: RigidAxis | None) -> RigidAxis:
    """Return the replay where it is finer or outside of the rigid fit's intervals, else the latter, widened by it."""
    if replay is None:
        return rigid
    (values, covariance), off = rigid, replay[0] - rigid[0]
    half, other = (1.96 * np.sqrt(np.diag(found))[:3] for found in (covariance, replay[1]))
    if np.prod(other) < np.prod(half) or (np.abs(off)[:3] > half).any():
        return replay
    return values, statistics.widened(covariance, replay[1] + np.outer(off, off))


def _of_timing(X: Real, late: Real, residual: Real, lengths: Sequence[int]) -> Real:
    """Return the increase of the covariance (p, p) due to the alignment of force and position within a sample: as in
    `fric.identify.replay.replay_fit.of_supposed`, by a force that is late by one standard deviation (n,).
    """
    joint = np.column_stack([late, X])
    if not late.any() or np.linalg.cond(joint / np.linalg.norm(joint, axis=0)) > CONDITION:
        return np.zeros((X.shape[1], X.shape[1]))
    moved = np.linalg.lstsq(X, late, rcond=None)[0]
    found = np.linalg.lstsq(joint, residual, rcond=None)[0]
    variance = float(statistics.hac_covariance(joint, residual - joint @ found, lengths)[0, 0])
    moment = variance / (1.0 + variance) + (float(found[0]) / (1.0 + variance)) ** 2
    return np.asarray(moment * np.outer(moved, moved))


def _in_motion(record: Prepared, settings: Conditioning) -> Prepared:
    """Return a record without the samples at rest, where they are many or no filter blurs them."""
    speed = np.abs(record.motion.velocity)
    moving = speed >= REST * speed[record.used].max(initial=0.0)
    return record.restricted(moving) if not settings.cutoff or moving[record.used].mean() < 1.0 - RESTS else record


def _observations(record: Prepared, settings: Conditioning, direction: str) -> Real:
    v, acceleration = record.motion.velocity[record.used], record.motion.acceleration[record.used]
    if direction == "both":
        terms = [acceleration, v, np.sign(v), np.ones_like(v)]
    else:
        forth, back = (v > 0) + 0.5 * (v == 0), (v < 0) + 0.5 * (v == 0)
        terms = [acceleration, v * forth, np.sign(v) * forth, v * back, np.sign(v) * back]
    return np.column_stack([thinned(np.asarray(term, float), settings.decimation) for term in terms])


def _refuse_rank(X: Real, names: Sequence[str], log: Log) -> None:
    """Refuse a motion along which two terms are collinear, for any units of the columns, or that goes one way: F_c and
    the offset are one force then, and the few samples of an overshoot would tell them apart.
    """
    size = np.linalg.norm(X, axis=0)
    velocity = X[:, [name.startswith("F_v") for name in names]]
    travel = [np.maximum(sign * velocity, 0.0).sum() for sign in (1.0, -1.0)]
    dead = [name for name, norm in zip(names, size, strict=True) if norm == 0]
    if dead:
        hint = "Log a motion in both directions."
        raise FricError(f"the motion does not excite {', '.join(dead)}", where=log.where, hint=hint)
    if np.linalg.cond(X / size) > CONDITION or min(travel) < ONE_WAY * max(travel):
        hint = "Log a motion in both directions, with changing speed and acceleration."
        raise FricError("the motion does not separate mass, viscous and Coulomb friction", where=log.where, hint=hint)


def _unit(name: str, channel: str, motion: Motion) -> str:
    dimension = "mass" if name == "M" else "viscous" if name.startswith("F_v") else "force"
    if channel == "force":
        return si_unit(dimension, motion)
    length = si_unit("position", motion)
    return {"mass": f"V*s^2/{length}", "viscous": f"V*s/{length}", "force": "V"}[dimension]


def effort_estimates(motion: Motion, delay: float | None = None, seen: Estimate | None = None) -> dict[str, Estimate]:
    """Return A = 0, K_f = 1 and T_d of a drive whose effort was logged: what is viscous behind it is friction.

    A measured effort acts when it is logged, and is late behind what the controller asks for; a drive's command acts
    later, as a response to it shows: ``force_lag = T_d - seen``, which is 0 where T_d is the delay seen.

    delay: T_d [s], where it is known.
    seen: Delay of the motion in a response to the effort. Unless it is longer, T_d of a current loop is assumed.
    """
    loop = Estimate(OF_EFFORT, si_unit("time", motion), assumed=True)
    T_d = loop if delay is None else replace(loop, value=delay, assumed=False, fixed=True)
    T_d = seen if seen is not None and delay is None and float(seen) > float(loop) else T_d
    A, K_f = (Estimate(x, si_unit(d, motion), fixed=True) for x, d in ((0.0, "rate"), (1.0, "force per input")))
    lag = T_d if seen is None else Estimate.around(float(T_d) - float(seen), T_d.unit, seen.half_width)
    return {"A": A, "T_d": T_d, "K_f": K_f} | ({} if T_d is seen else {"force_lag": lag})


def _plant(  # noqa: PLR0913 - what a motion tells and what is given besides
    values: Real, covariance: Real, quantile: float, direction: str, channel: str,
    K_f: Estimate | None, delay: float | None, assumed: float, motion: Motion,
) -> dict[str, Estimate]:  # fmt: skip
    """Return A = F_v/M, B = K_f/M, and their intervals by the delta method."""
    M, viscous = values[0], np.zeros(len(values))  # the mean of the directions
    viscous[[1] if direction == "both" else [1, 3]] = 1.0 if direction == "both" else 0.5
    A = float(viscous @ values / M)
    gradient = viscous / M
    gradient[0] = -A / M
    half = quantile * float(np.sqrt(gradient @ covariance @ gradient))
    found = {"A": Estimate.around(A, si_unit("rate", motion), half)}
    k = 1.0 if channel == "input" else None if K_f is None else float(K_f)
    if k is not None:
        B = float(k / M)
        relative = quantile * float(np.sqrt(covariance[0, 0])) / abs(float(M))
        if channel == "force" and K_f is not None and isinstance(K_f.ci95, tuple):
            relative = float(np.hypot(relative, K_f.half_width / k))
        found["B"] = Estimate.around(B, si_unit("acceleration per input", motion), B * relative)
    unit = si_unit("time", motion)
    found["T_d"] = Estimate(assumed, unit, assumed=True) if delay is None else Estimate(delay, unit, fixed=True)
    if K_f is not None:
        found["K_f"] = K_f
    return found


def _directions(X: Real, y: Real, lengths: Sequence[int], estimates: Mapping[str, Estimate]) -> Iterator[Notice]:
    """Warn that viscous friction differs by direction: ``F_v·ż + d·|ż|`` has F_v + d forwards and F_v - d backwards."""
    if "F_v" not in estimates:
        return
    more = np.column_stack([X, np.abs(X[:, 1])])
    if np.linalg.cond(more / np.linalg.norm(more, axis=0)) > CONDITION:
        return
    values = np.linalg.lstsq(more, y, rcond=None)[0]
    error = float(np.sqrt(statistics.hac_covariance(more, y - more @ values, lengths)[-1, -1]))
    mean, by = float(values[1]), float(values[-1])
    if abs(by) > max(float(stdtrit(len(y) - len(values), 1 - statistics.DIFFERENT / 2)) * error, UNEVEN * abs(mean)):
        unit = estimates["F_v"].unit
        yield response.VISCOUS_BY_DIRECTION.found(forward=Estimate(mean + by, unit), backward=Estimate(mean - by, unit))


def _varies(between: statistics.Between | None, estimates: Mapping[str, Estimate]) -> Iterator[Notice]:
    """Warn about differences of records that chance does not explain."""
    if between is not None and between.chance < statistics.DIFFERENT:
        units = [estimate.unit for estimate in estimates.values()]
        by = [
            f"{name} by {readable(float(size), unit, 2)}"
            for name, size, unit in zip(estimates, between.deviations, units, strict=True) if size > 0.0
        ]  # fmt: skip
        order = [f"M {readable(float(estimates['M']) + float(off), units[0], 4)}" for off in between.off[:, 0]]
        yield RECORDS_VARY.found(by=by, order=order, one_speed=False, within=False, motions=False, scatter=1.0)


def _warnings(
    records: Sequence[Prepared], border: int, estimates: dict[str, Estimate], K_f: Estimate | None, *, assumed: bool
) -> Iterator[Notice]:
    hidden = [float(np.mean(~record.used[border:])) for record in records]
    if any(hidden):
        yield response.CHANGES_BETWEEN.found(share=max(hidden), less=False)
    for name, estimate in estimates.items():
        if (name == "M" or name.startswith(("F_v", "F_c"))) and float(estimate) <= 0:
            falls = name.startswith("F_v") and float(estimates["M"]) > 0
            yield response.NOT_PHYSICAL.found(name=name, value=estimate, falls=falls)
        elif name == "M" and estimate.half_width >= float(estimate):
            yield response.MASS_NOT_SHOWN.found(mass=estimate, half=Estimate(estimate.half_width, estimate.unit))
    if not is_effort(motion := records[0].log.motion):
        yield response.A_HOLDS_VISCOUS.found()
    if assumed:
        yield response.T_D_ASSUMED.found(effort=is_effort(motion))
    if K_f is None:
        yield flaws.K_F_MISSING.found()

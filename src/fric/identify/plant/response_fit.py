"""Eq. (1) fitted to measured frequency responses, by least squares on the complex logarithm; and the force constant.

The lines of the response give the force per volt and the lag of the logged force, too. A force that is logged late is
not proportional to the voltage of the same sample, and a regression of one on the other gives too small a K_f with a
narrow interval. In the frequency domain both separate:

    F/U = K_f·e^(-jωτ)/(1 + jω·T_f)

the magnitude towards 0 Hz is K_f, the phase is the delay τ and a first-order filter T_f of the measurement.
"""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from math import exp
from typing import NamedTuple

import numpy as np
from scipy import optimize
from scipy.special import chdtri, stdtrit

from fric.arrays import Complex, Mask, Real
from fric.drive.plant import LinearPlant, hold_delay
from fric.drive.resonance import Encoder, Resonance
from fric.errors import FricError
from fric.estimate import Estimate
from fric.flaws.channel import DEAD_ZONE, FORCE_LAGS, FORCE_NOT_PROPORTIONAL, K_F_DIFFERS, MASS_DIFFERS
from fric.identify.plant.frequency_response import SEGMENTS, MeasuredResponse, measure_response
from fric.log import Log
from fric.notice import Notice
from fric.records.segments import steady_segments
from fric.statistics import jackknife, smoother_than_noise, widened
from fric.units import Motion, si_unit

COARSEST = 0.3  # Relative deviation up to which the logarithm of a response is practically unbiased


class Lines(NamedTuple):
    """The lines of one response that a fit uses."""

    frequency: Real  # Frequencies [Hz], shape (n,)
    response: Complex  # Z/U [m/V], shape (n,)
    deviation: Real  # Relative standard deviation of real and imaginary part, shape (n,)
    # Sampling rate of the hold in front of the plant [Hz]; None where the response is that of eq. (1) itself.
    hold: float | None
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
        raise FricError(
            f"{np.count_nonzero(used)} of {len(f)} frequencies have a coherence of {coherence:g} or more"
            + (f" between {band[0]:g} and {band[1]:g} Hz" if band != (0.0, np.inf) else ""),
            where=table.where,
            hint="Excite harder or longer, or lower `coherence=`.",
        )
    floor = 1e-9  # a response without any noise weighs much, but not infinitely
    lines = Lines(
        f[used], measured.response[used], np.maximum(deviation[used], floor), hold, measured.reversing or 0.0,
        measured.correlation, known,
    )  # fmt: skip
    return lines, used


def at(lines: Lines, kept: Mask) -> Lines:
    """Return a part of the lines."""
    return lines._replace(
        frequency=lines.frequency[kept], response=lines.response[kept], deviation=lines.deviation[kept]
    )


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
    if best > 1.0:
        turned = weight @ np.cos(np.angle(-response * 1j * omega * (1j * omega + at[0])))
        if turned > 0.5:
            raise FricError(
                "the response is that of eq. (1) with the sign turned", hint="Set sign: -1 for input or position."
            )
    return at, best


UNDETERMINED = 0.5  # Assumed share of the table in the moving mass, if it is not determined
BLOCKS, FEWEST = 10, 5  # Number of blocks of neighbouring lines for the jackknife, and the least number
SCATTER_BY_CHANCE = float(chdtri(BLOCKS - 1, 0.1)) / (BLOCKS - 1)
"""Ratio of the variances by blocks and by scatter that chance exceeds in one of ten cases."""
OTHER_RATIOS = (0.2, 0.8)  # Other possible shares of the table, if it is not determined
MISFIT = 0.99  # Quantile of chi-squared above which the residuals exceed noise


class ResponseForm(NamedTuple):
    """The set of parameters: A, ln B, T_d; F_c/M of Coulomb friction; ln f, ln ζ and the ratio of a second mass.

    With an encoder at the table the ratio is not fitted: the response depends on it only by A/ω.
    """

    friction: bool = False
    encoder: Encoder | None = None  # Where the encoder is, where there is a second mass

    def plant(self, x: Real, reversing: float = 0.0) -> LinearPlant:
        """Return eq. (1), with what friction adds to A along a motion with this gain [s/m]."""
        A = float(x[0]) + (float(x[3]) * reversing if self.friction else 0.0)
        return LinearPlant(max(A, 0.0), float(np.exp(x[1])), max(float(x[2]), 0.0))

    def resonance(self, x: Real, share: float = UNDETERMINED) -> Resonance | None:
        """Return the second mass, if any, with this share of the table where the share is not determined."""
        if self.encoder is None:
            return None
        tail = [float(value) for value in x[3 + self.friction :]]
        return Resonance(
            float(np.exp(tail[0])), tail[2] if len(tail) > 2 else share, float(np.exp(tail[1])), self.encoder
        )

    def response(
        self, x: Real, frequency: Real, hold: float | None, reversing: float = 0.0, share: float = UNDETERMINED
    ) -> Complex:
        """Return Z/U [m/V] of these parameters at frequencies [Hz], shape (n,)."""
        plant, resonance = self.plant(x, reversing), self.resonance(x, share)
        return resonance.response(plant, frequency, hold) if resonance else plant.response(frequency, hold)


@dataclass(frozen=True)
class PlantSolution:
    """Parameters of eq. (1), and of Coulomb friction and a second mass where they were requested."""

    # A [1/s], ln B, T_d [s], F_c/M [m/s²] where friction was fitted, and those of a second mass as in `Form`; shape
    # (p,)
    values: Real
    covariance: Real  # Covariance of these, shape (p, p)
    chi2: float  # Chi-squared over its freedom, for the deviations as they were measured [1]
    # Relative deviation that must be added to the measured deviations to explain the residuals; 0 where noise does
    misfit: float
    freedom: float  # Degrees of freedom, correlated lines counted once
    form: ResponseForm  # Which parameters there are

    def plant(self, reversing: float = 0.0) -> LinearPlant:
        """Return eq. (1), with what friction adds to A along a motion with this gain [s/m]."""
        return self.form.plant(self.values, reversing)

    def response(self, frequency: Real, hold: float | None, reversing: float = 0.0) -> Complex:
        """Return Z/U [m/V] at frequencies [Hz], shape (n,), as in `Form.response`."""
        return self.form.response(self.values, frequency, hold, reversing)

    def half_widths(self) -> Real:
        """Return half the 95 % intervals, shape (p,)."""
        return float(stdtrit(self.freedom, 0.975)) * np.sqrt(np.diag(self.covariance))

    def second_mass(self) -> dict[str, Estimate] | None:
        """Return frequency, ratio and damping of the second mass with their 95 % intervals, where there is one."""
        found = self.form.resonance(self.values)
        if found is None:
            return None
        f, zeta, ratio, half = found.frequency, found.damping, found.ratio, self.half_widths()[3 + self.form.friction :]
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
    sets: Sequence[Lines],
    *,
    friction: bool = False,
    misfits: Sequence[float] | None = None,
    resonance: Resonance | None = None,
    start: Real | None = None,
) -> PlantSolution:
    """Fit eq. (1) to the lines of one or more responses by weighted least squares on log magnitude and phase.

    The residual is ``ln(G_m/G)``, its real part the log magnitude, its imaginary part the phase, both over the relative
    deviation of the line. With friction, A of each response is ``A + F_c/M·reversing``.

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
        start, lower, upper, scale = np.append(start, 0.0)[:4], [*lower, -np.inf], [*upper, np.inf], [*scale, 1.0]
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

    def fitted(added: Sequence[float], start: Real) -> optimize.OptimizeResult:
        def residual(x: Real) -> Real:
            return np.concatenate([residual_of(model(x, s), s, a) for s, a in zip(sets, added, strict=True)])

        return optimize.least_squares(
            residual, start, jac="3-point", bounds=(lower, upper), x_scale=scale, xtol=1e-10, ftol=1e-10, gtol=1e-10,
        )  # fmt: skip

    added = [0.0] * len(sets) if misfits is None else list(misfits)
    found = fitted(added, start)
    plain = chi2 = 2 * float(found.cost) / max(rows - len(start), 1)
    unexplained = chi2 * freedom > chdtri(freedom, 1 - MISFIT)
    if misfits is None and unexplained and all(lines.known for lines in sets):
        for _ in range(60):  # the misfit with which chi-squared is its freedom
            added = [_misfit(model(found.x, lines), lines, len(start)) for lines in sets]
            last, found = found.x, fitted(added, found.x)
            if np.allclose(found.x, last, rtol=1e-6, atol=1e-12):
                break
        chi2 = 2 * float(found.cost) / max(rows - len(start), 1)
    covariance = np.linalg.pinv(found.jac.T @ found.jac) * chi2 * correlation
    quantile = float(stdtrit(freedom, 0.975))
    covariance = widened(covariance, _left_out(found, sets, covariance) / quantile**2)
    if form.encoder == "table":
        for ratio in OTHER_RATIOS:
            shares = [form.response(found.x, lines.frequency, lines.hold, lines.reversing, ratio) for lines in sets]
            other = [residual_of(share, lines, a) for share, lines, a in zip(shares, sets, added, strict=True)]
            moved = np.linalg.lstsq(found.jac, np.concatenate(other) - found.fun, rcond=None)[0]
            covariance = covariance + np.outer(moved, moved) / (len(OTHER_RATIOS) * quantile**2)
    return PlantSolution(found.x, covariance, plain, max(added), freedom, form)


def _left_out(found: optimize.OptimizeResult, sets: Sequence[Lines], covariance: Real) -> Real:
    """Return the squared half-widths (p, p) by leaving out blocks of neighbouring lines, 0 with few lines.

    The errors of a model, of friction and of an encoder's steps are similar from line to line, and no scatter over
    periods shows them. Where blocks differ by no more than chance, that scatter is sufficient.
    """
    if min(len(lines.frequency) for lines in sets) < 2 * FEWEST:
        return np.zeros((len(found.x), len(found.x)))
    label = []
    for number, lines in enumerate(sets):
        block = np.argsort(np.argsort(lines.frequency)) * BLOCKS // len(lines.frequency)
        label += 2 * [block + BLOCKS * number]
    moved = jackknife(found.jac, found.fun, np.concatenate(label))
    wider = SCATTER_BY_CHANCE * float(stdtrit(BLOCKS - 1, 0.975)) ** 2
    sure = np.diag(moved) > wider * np.diag(covariance)
    return np.asarray(np.where(np.outer(sure, sure), moved, 0.0))


def residual_of(modelled: Complex, lines: Lines, misfit: float) -> Real:
    """Return log magnitudes and phases over a model, each over its deviation, shape (2·n,)."""
    ratio = np.log(lines.response / modelled)
    weight = 1 / np.hypot(lines.deviation, misfit)
    return np.concatenate([ratio.real * weight, ratio.imag * weight])


def _misfit(modelled: Complex, lines: Lines, count: int) -> float:
    """Return the relative deviation at which chi-squared of a response equals its degrees of freedom."""
    squares = residual_of(modelled, lines, 0.0).reshape(2, -1) ** 2 * lines.deviation**2
    n = max(squares.size - count, 1)

    def excess(misfit: float) -> float:
        return float(np.sum(squares / (lines.deviation**2 + misfit**2))) - n

    top = float(np.sqrt(squares.sum())) + 1e-12
    return 0.0 if excess(0.0) <= 0 else float(optimize.brentq(excess, 0.0, top, xtol=1e-9 * top))


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

    # Equivalent gain of a unit Coulomb friction along each motion [s/m], shape (r,); 0 where it never reverses
    gains: Real
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
    # Frequency, ratio and damping of a table on a spring, see `fric.drive.resonance`; None where none is seen
    second_mass: dict[str, Estimate] | None = None
    warnings: tuple[Notice, ...] = ()  # Warnings: what the data do not determine

    @property
    def plant(self) -> LinearPlant:
        """Eq. (1) without the contribution of friction to A."""
        return self.solution.plant()


LEAST_FILTER = 0.2  # T_f [samples] above which the lag counts as a filter
FORM = 0.01  # Error of the lag of a filter [samples] that is treated as continuous
DESCRIBED = 0.1  # Lag [samples] above which there is a warning
DEAD = 0.01  # Share of the input (rms) above which a dead zone gives a warning
PARTS, SURE = 8, 6.0  # Parts of a record that determine a dead zone, and standard errors above which they do
DIFFERS = 0.05  # Share by which a force constant or a mass that the user states may differ from the identified value


@dataclass(frozen=True)
class ForceScale:
    """K_f, and the lag of the logged force."""

    K_f: Estimate | None  # Force constant [N/V]; None where it is not known
    # Lag of the logged force behind the logged input at low frequency, filter included [s]; None where no
    # record has both
    lag: Estimate | None = None
    # Corner of the first-order filter that is part of the lag [Hz]; None where none is seen
    filter: Estimate | None = None
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
    logs: Sequence[Log],
    given: float | None,
    motion: Motion,
    *,
    period: float | None = None,
    segment: float | None = None,
    strokes: Sequence[Log] = (),
) -> ForceScale:
    """Return K_f [N/V] and the lag of the force, from the response of force to input if records have both.

    Otherwise, and if K_f is not given, strokes determine K_f, but not the lag.

    given: K_f [N/V], where the user knows it; the records then determine the lag, and check K_f.
    """
    unit = si_unit("force per input", motion)
    stated = None if given is None else Estimate(given, unit, fixed=True)
    both = [log for log in logs if log.input is not None and log.force is not None and np.ptp(log.input) > 0]
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
        warnings.append(K_F_DIFFERS.found(given=stated, found=found))
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
    if jump > -max(DEAD * slope * float(np.sqrt(np.mean(u**2))), SURE * error):
        return None
    rises = Estimate(float(slope), si_unit("force per input", log.motion))
    return DEAD_ZONE.found(log.where, zone=Estimate(-jump / slope, log.unit("input")), slope=rises)


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
        estimates["K_f"] = Estimate(
            mass * float(B), si_unit("force per input", motion), interval, source="the stated mass times B"
        )
        return []
    found = float(estimates["K_f"]) / float(B)
    relative = [estimate.half_width / float(estimate) for estimate in (estimates["K_f"], B)]
    if abs(found / mass - 1) <= max(DIFFERS, float(np.hypot(relative[0], relative[1]))):
        return []
    return [MASS_DIFFERS.found(found=Estimate(found, unit), stated=Estimate(mass, unit))]


def _lag_described(lag: Estimate, corner: Estimate | None, sampling: float) -> list[Notice]:
    if not _matters(lag, sampling):
        return []
    size, samples = Estimate(abs(float(lag)), "s"), float(lag) * sampling
    return [FORCE_LAGS.found(lag=size, samples=abs(samples), late=samples, corner=corner)]


FLOOR = 1e-5  # Least relative deviation of a line: the rounding of a logged force
LONGEST = 25e-3  # Longest delay in the search [s], and four times the longest lead
FEW_LINES = 8  # Least number of lines for the fit of the lag, if the record has them


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
        if fewer < FEW_LINES or not any(smoother_than_noise(part, -3.09) for part in fitted.residual):
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
    covariance, J = np.zeros((3, 3)), np.asarray(found.jac)
    covariance[:n, :n] = np.linalg.pinv(J.T @ J) * max(chi2, 1.0) * lines.correlation
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


MEANS = 4  # Least number of steady segments for a line through their means
BENT = 0.02  # Largest deviation of the means from their line, as a share of their range


def steady_force_constant(logs: Sequence[Log], motion: Motion) -> tuple[Estimate | None, tuple[Notice, ...]]:
    """Return K_f [N/V] as the slope of mean force over mean input of steady segments, and warnings.

    logs: Strokes at constant velocity; those without force or input have no part in it.
    motion: Motion of the axis. Returns none if fewer than `MEANS` segments are steady, or all have the same voltage.
    """
    means = [
        (float(np.mean(log.input[part.start : part.stop])), float(np.mean(log.force[part.start : part.stop])))
        for log in logs if log.force is not None and log.input is not None
        for part in steady_segments(log)
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
    if share <= BENT:
        return found, ()
    return found, (FORCE_NOT_PROPORTIONAL.found(segments=len(u), off=share),)

"""The force constant (force per volt) and the lag of the logged force, from the lines of the response.

A force that is logged late is not proportional to the voltage of the same sample, and a regression of one on the other
gives too small a K_f with a narrow interval. In the frequency domain both separate:

    F/U = K_f·e^(-jωτ)/(1 + jω·T_f)

the magnitude towards 0 Hz is K_f, the phase is the delay τ and a first-order filter T_f of the measurement.
"""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy import optimize
from scipy.special import stdtrit

from fric.arrays import Real
from fric.errors import FricError
from fric.estimate import Estimate
from fric.flaws.channel import (
    DEAD_ZONE,
    FORCE_LAGS,
    FORCE_NOT_PROPORTIONAL,
    K_F_DIFFERS,
    MASS_DIFFERS,
)
from fric.identify.plant.frequency_response import SEGMENTS, measure_response
from fric.identify.plant.response_fit import Lines, at, residual_of, select
from fric.log import Log
from fric.notice import Notice
from fric.records.segments import steady_segments
from fric.statistics import smoother_than_noise
from fric.units import Motion, si_unit

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


def force_constant(
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
    assert log.input is not None
    assert log.force is not None
    n, interval = len(log), float(np.median(np.diff(log.time)))
    s = 2j * np.pi * np.fft.rfftfreq(n, interval)
    late = np.fft.irfft(np.fft.rfft([log.input, np.sign(log.input)]) * np.exp(-s * delay) / (1 + s * corner), n)
    X = np.column_stack([*late, np.ones(n)])
    parts = np.array_split(np.arange(n), PARTS + 2)[1:-1]  # at the ends both overlap
    found = np.array([np.linalg.lstsq(X[part], log.force[part], rcond=None)[0] for part in parts])
    slope, jump = found[:, :2].mean(axis=0)
    error = float(found[:, 1].std(ddof=1)) / np.sqrt(PARTS)
    if jump > -max(DEAD * slope * float(np.sqrt(np.mean(log.input**2))), SURE * error):
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
FEWEST = 8  # Least number of lines for the fit of the lag, if the record has them


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
        if fewer < FEWEST or not any(smoother_than_noise(part, -3.09) for part in fitted.residual):
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

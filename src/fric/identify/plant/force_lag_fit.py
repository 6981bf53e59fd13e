"""K_f and the lag of a logged force, fitted to the response of force to input on its lines."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy import optimize

from fric.arrays import Complex, Real
from fric.errors import FricError
from fric.identify.plant.covariance import smoother_than_noise
from fric.identify.plant.frequency_response import MeasuredResponse
from fric.identify.plant.response_lines import COARSEST

FLOOR = 1e-5
"""Relative deviation that a line has at least: the rounding of a logged force."""

LONGEST = 25e-3
"""Longest delay that is looked for [s], and four times the longest lead."""

FEWEST = 8
"""Lines that the lag is fitted to at least, where the record has them."""


class ForceLines(NamedTuple):
    """The lines of one record: frequency [Hz], F/U [N/V], its relative deviation, lines that tell as much as one."""

    frequency: Real
    response: Complex
    deviation: Real
    correlation: float


class FittedLag(NamedTuple):
    """K_f, delay and filter of one record."""

    values: Real
    """ln K_f, τ [s], T_f [s]"""
    covariance: Real
    freedom: float
    residual: Real
    """Real and imaginary parts over their deviation, shape (2, n), by frequency."""


def force_lines(measured: MeasuredResponse) -> ForceLines:
    """Return the lines of a response of force to input that are sure; raise `FricError` where there are not three."""
    table = measured.table
    deviation = np.asarray(table.deviation)
    used = (deviation <= COARSEST) & (table.frequency < 0.45 * (measured.sampling or np.inf))
    if np.count_nonzero(used) < 3:
        raise FricError("fewer than three frequencies are sure", where=table.where)
    return ForceLines(
        table.frequency[used], measured.response[used], np.maximum(deviation[used], FLOOR), measured.correlation
    )


def lag_in_band(lines: ForceLines, filtered: bool = True) -> FittedLag:
    """Fit the widest band from the lowest line on in which what is left is noise, not a pattern."""
    top = float(lines.frequency.max())
    while True:
        used = lines.frequency <= top
        part = ForceLines(lines.frequency[used], lines.response[used], lines.deviation[used], lines.correlation)
        fitted = _fit(part, filtered)
        fewer = np.count_nonzero(lines.frequency <= top / 2)
        if fewer < FEWEST or not any(smoother_than_noise(part, -3.09) for part in fitted.residual):
            return fitted
        top /= 2


def _fit(lines: ForceLines, filtered: bool) -> FittedLag:
    """Fit ln K_f, τ, and T_f where there is a filter, on the complex logarithm; the lines share the misfit."""
    omega = 2 * np.pi * lines.frequency
    top = float(omega.max())
    start = np.array([float(np.log(np.abs(lines.response[0]))), _first_delay(lines), 0.05 / top])[: 2 + filtered]
    lower, scale = [-np.inf, -np.inf, 0.0][: len(start)], [0.01, 0.01 / top, 0.01 / top][: len(start)]
    misfit, n = 0.0, len(start)

    def residual(x: Real) -> Real:
        model = np.exp(x[0] - 1j * omega * x[1]) / (1 + 1j * omega * (x[2] if filtered else 0.0))
        ratio = np.log(lines.response / model)
        weight = 1 / np.hypot(lines.deviation, misfit)
        return np.concatenate([ratio.real * weight, ratio.imag * weight])

    freedom = max((2 * len(omega) - n) / lines.correlation, 1.0)
    for _ in range(8):
        found = optimize.least_squares(
            residual, start, bounds=(lower, np.inf), x_scale=scale, xtol=1e-12, ftol=1e-12, gtol=1e-12
        )
        start = found.x if not filtered else np.append(found.x[:2], max(found.x[2], 1e-6 / top))
        chi2 = 2 * float(found.cost) / max(2 * len(omega) - n, 1)
        if abs(chi2 - 1) < 0.02 or (misfit == 0.0 and chi2 < 1):
            break
        plain = np.hypot(lines.deviation, misfit)
        grown = float(np.median(plain)) * float(np.sqrt(max(chi2, 1e-12)))
        misfit = float(np.sqrt(max(grown**2 - float(np.median(lines.deviation)) ** 2, 0.0)))
    covariance, J = np.zeros((3, 3)), np.asarray(found.jac)
    covariance[:n, :n] = np.linalg.pinv(J.T @ J) * max(chi2, 1.0) * lines.correlation
    return FittedLag(np.append(found.x, [0.0] * (3 - n)), covariance, freedom, found.fun.reshape(2, -1))


def _first_delay(lines: ForceLines) -> float:
    """Return the delay [s] near the best, from a grid: the phase is wrapped, and so are delays beyond 1/spacing."""
    omega = 2 * np.pi * lines.frequency
    weight = np.minimum(1 / lines.deviation, 1e3) ** 2
    longest = min(LONGEST, 0.4 / float(np.diff(lines.frequency).min()))
    step = min(0.1 / float(lines.frequency.max()), longest / 4)
    delays = step * np.arange(-np.floor(longest / 4 / step), np.ceil(longest / step) + 1)
    turned = np.angle(lines.response * np.exp(1j * np.outer(delays, omega))) ** 2 @ weight
    return float(delays[int(np.argmin(turned))])


def pooled_lags(fits: Sequence[FittedLag]) -> tuple[Real, Real, float]:
    """Return the mean of records, weighted, its covariance with what they differ by, and its freedom."""
    freedom = sum(fit.freedom for fit in fits)
    if len(fits) == 1:
        return fits[0].values, fits[0].covariance, freedom
    values = np.array([fit.values for fit in fits])
    own = np.array([np.diag(fit.covariance) for fit in fits]) + 1e-30
    mean, variance = np.zeros(3), np.zeros(3)
    for n in range(3):
        weight = 1 / own[:, n]
        mean[n] = weight @ values[:, n] / weight.sum()
        excess = float(weight @ (values[:, n] - mean[n]) ** 2) / (len(fits) - 1)
        variance[n] = max(excess, 1.0) / weight.sum()
    joint = fits[0].covariance / np.sqrt(np.outer(own[0], own[0]))
    return mean, joint * np.sqrt(np.outer(variance, variance)), freedom

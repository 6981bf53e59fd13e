"""Eq. (1) fitted to measured frequency responses, by least squares on the complex logarithm."""

from collections.abc import Sequence
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
from fric.identify.plant.frequency_response import MeasuredResponse
from fric.notice import Notice
from fric.statistics import jackknife, widened
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


EQUATION_1 = ResponseForm()


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
    form: ResponseForm = EQUATION_1  # Which parameters there are

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

    friction: Fit F_c/M, too.
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
    label, first = [], 0
    for lines in sets:
        n = len(lines.frequency)
        block = first + np.argsort(np.argsort(lines.frequency)) * BLOCKS // n
        label += [block, block]
        first += BLOCKS
    smallest = min(len(lines.frequency) for lines in sets)
    if smallest < 2 * FEWEST:
        return np.zeros((len(found.x), len(found.x)))
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

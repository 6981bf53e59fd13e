"""The plant of eq. (1), fitted to frequency responses: the influence of friction on it, and the choice of records."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from itertools import chain
from math import exp
from typing import Literal, NamedTuple

import numpy as np
from scipy import optimize
from scipy.special import chdtri, stdtrit

from fric.arrays import Complex, Mask, Real
from fric.choice import simplest
from fric.drive.plant import LinearPlant, hold_delay
from fric.drive.resonance import Encoder, Resonance
from fric.errors import FricError
from fric.estimate import Estimate
from fric.flaws import response
from fric.flaws.channel import K_F_MISSING
from fric.flaws.response import A_HOLDS_FRICTION, A_OPEN
from fric.identify.plant.force_constant import against_mass, force_constant
from fric.identify.plant.frequency_response import MeasuredResponse, driven_alike, measure_response
from fric.log import ForceVelocity, FrequencyResponse, Log, Record, refuse_several_axes
from fric.notice import Notice
from fric.records.flaws import evened, record_flaws
from fric.records.inspection import kind_of
from fric.statistics import jackknife, robust_deviation, widened
from fric.threads import one_blas_thread
from fric.units import Motion, rotates, si_unit

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


GAINS_APART = 0.05  # Share by which the friction's gain must differ between records to compare their amplitudes
SURE = 0.99  # Probability below which two responses count as different


Method = Literal["response", "motion"]


@one_blas_thread()
def identify_plant(  # noqa: PLR0913 - the verb of its name gives each setting
    records: Sequence[Log | FrequencyResponse],
    *,
    hold: float | None = None,
    continuous: bool = False,
    coherence: float = 0.5,
    band: tuple[float, float] = (0.0, np.inf),
    period: float | None = None,
    segment: float | None = None,
    given_force_constant: float | None = None,
    mass: float | None = None,
    strokes: Sequence[Log] = (),
) -> PlantFit:
    """Fit A, B and T_d of eq. (1) to one or more frequency responses of one axis.

    A record in time includes the zero-order hold of the controller; a table is continuous. If two records differ in
    amplitude, the describing function of Coulomb friction is removed from A; if friction cannot be separated from A, A
    is assumed to be 0.

    hold: Sampling rate of the hold [Hz]; that of the record where not given.
    continuous: Take every response as that of eq. (1) itself, without hold and sampling.
    given_force_constant: K_f [N/V], where no force was logged.
    mass: Moving mass [kg], where the user knows it: K_f/B is checked against it, or K_f taken from it.
    strokes: Records at constant velocity, which determine K_f where no record of a response has a force.
    Raises FricError: When a record gives no response, too few lines are certain, or the sign of input or position is
        wrong.
    """
    # of the records as they were logged: what is made up for along a cubic looks like jitter
    clocks = [record_flaws([given], "plant") if isinstance(given, Log) else [] for given in records]
    even, uneven = list[Log | FrequencyResponse](), list[Notice]()
    for given in records:
        record, clock_notices = evened(given) if isinstance(given, Log) else (given, [])
        even.append(record)
        uneven += clock_notices
    logs = [record for record in even if isinstance(record, Log)]
    fits, sets = [], []
    for measured, clock in zip(_measured(even, clocks, period, segment), clocks, strict=True):
        rate = None if continuous else hold or measured.sampling
        with _blamed_on(clock):
            lines, used = select(measured, hold=rate, coherence=coherence, band=band)
        try:
            solution, kept = solve_with_modes(lines)
        except FricError as error:
            raise error.at(measured.table.where) from None
        used[np.flatnonzero(used)[~kept]] = False
        fits.append(ResponseFit(measured, used, solution, rate, tuple(float(f) for f in lines.frequency[~kept])))
        sets.append(at(lines, kept))
    solution, influence = _joined(fits, sets)
    motion = fits[0].measured.table.motion
    rates = [fit.hold for fit in fits if fit.hold is not None]
    rate = min(rates) if rates else None
    estimates = solution.estimates(motion)
    scale = force_constant(logs, given_force_constant, motion, period=period, segment=segment, strokes=strokes)
    estimates |= scale.estimates()
    others = [*uneven, *scale.warnings, *against_mass(estimates, mass, motion)]
    transport = estimates["T_d"]
    if rate is not None:
        low, high = transport.ci95 or (0.0, 0.0)
        half = hold_delay(rate)
        transport = replace(transport, value=float(transport) - half, ci95=(low - half, high - half))  # type: ignore[operator]
    notices = list(described(fits, solution, influence, estimates, rate))
    if {A_OPEN.code, A_HOLDS_FRICTION.code} <= {notice.code for notice in notices if notice.severity != "note"}:
        # the rest is friction: strokes show all viscous friction, where no damping is subtracted
        high = float(estimates["A"]) + float(solution.half_widths()[0])
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
    least = fits[int(np.argmin(gains))].solution.values
    start = np.array([max(float(level), 0.0), *least[1:3], slope])
    split = solve(sets, friction=True, misfits=misfits, resonance=mode, start=start)
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


def _alike(solution: PlantSolution, lines: Lines, misfit: float) -> float:
    """Return the number of neighbouring lines per independent line, by the correlation of residuals.

    Friction around rest is more than its describing function: the remainder is not noise, and is similar from line to
    line. The number is the sum of the residuals' correlation over the lines, as of a correlated series.
    """
    model = solution.form.response(solution.values, lines.frequency, lines.hold, lines.reversing)
    off = np.log(lines.response / model) / np.hypot(lines.deviation, misfit)
    n = len(off)
    likeness = np.array([np.vdot(off[: n - k], off[k:]).real for k in range(n)]) / max(np.vdot(off, off).real, 1e-300)
    ends = np.flatnonzero(likeness < 0)
    return 1.0 + 2.0 * float(np.sum(likeness[1 : ends[0] if ends.size else n]))


def plant_records(
    records: Sequence[Record], method: Method | None = None
) -> tuple[Method, list[Log | FrequencyResponse]]:
    """Return the method and its records: frequency responses if there are any, else motions.

    A response that is recognised in a record without a kind counts as stated.

    method: The method, where the user chooses it; a record of any kind is then used.
    Raises FricError: When no record is usable, or the records are of different axes.
    """
    refuse_several_axes(records)
    dynamic = [r for r in records if not isinstance(r, ForceVelocity)]
    in_time: list[Log | FrequencyResponse] = [r for r in records if isinstance(r, Log)]
    excited = [isinstance(r, FrequencyResponse) or kind_of(r) == "frequency-response" for r in dynamic]
    asked, method = method is not None, method or ("response" if any(excited) else "motion")
    chosen: list[Log | FrequencyResponse] = [
        r for r, response in zip(dynamic, excited, strict=True)
        if (response if method == "response" else not response and isinstance(r, Log) and r.kind in {"motion", None})
    ]  # fmt: skip
    if asked and not chosen:
        chosen = in_time
    if not chosen:
        kinds = ", ".join(sorted({str(r.kind) for r in in_time if isinstance(r, Log)})) or "tables"
        raise FricError(
            f"no record is of kind frequency-response or motion (there are {kinds})",
            where=records[0].source,
            hint="Say `method='response'` or `method='motion'` to take them as such.",
        )
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
    scale = max(robust_deviation(_off(lines, found.solution)[found.kept]), 1e-3)
    bounded = [float(np.sum(np.minimum(np.abs(_off(lines, one.solution)) / scale, OFF) ** 2)) for one in (rigid, found)]
    return found if bounded[0] - bounded[1] > GAIN and _is_determined(found.solution, at(lines, found.kept)) else rigid


def _is_determined(solution: PlantSolution, lines: Lines) -> bool:
    """Return whether the lines determine frequency and ratio of a second mass, and the rigid axis below it as well.

    Friction around rest is a spring, too: in a small motion it causes a resonance at or below the lowest lines. A
    resonance above all lines was not measured: a filter, or a delay of a fraction of a sample, has the same effect.
    """
    half, values = solution.half_widths()[3:], solution.values[3:]
    ratio = len(values) < 3 or bool(half[2] < values[2] < 0.99)
    at = float(np.exp(values[0]))
    within = BELOW * float(lines.frequency.min()) <= at <= float(lines.frequency.max())
    return ratio and within and bool(half[0] < 0.1)


def _best_mode(lines: Lines) -> Found | None:
    """Return the best fit with a second mass, for a motor or a table encoder; None with too few lines."""
    if len(lines.frequency) < 10:
        return None
    low, high = float(lines.frequency.min()), float(lines.frequency.max())
    if high < 4 * low:
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
    tried.sort(key=lambda pair: pair[0])
    return [(resonance, start) for _, resonance, start in tried]


def _without_outliers(lines: Lines, resonance: Resonance | None, start: Real | None = None) -> Found:
    kept = np.ones(len(lines.frequency), bool)
    solution = solve([lines], resonance=resonance, start=start)
    for _ in range(6):
        off = np.abs(_off(lines, solution))
        usual = robust_deviation(off[kept])
        stands = off > np.maximum(OFF * np.hypot(usual, lines.deviation), VISIBLE)
        if np.count_nonzero(stands) > MOST_OUTLIERS * len(stands) or np.array_equal(~stands, kept):
            break
        kept = ~stands
        start = solution.values[:3]
        again = solution.form.resonance(solution.values)
        solution = solve([at(lines, kept)], resonance=again, start=start)
    return Found(solution, kept)


def _off(lines: Lines, solution: PlantSolution) -> Complex:
    return np.asarray(np.log(lines.response / solution.response(lines.frequency, lines.hold)))


SMALL = 0.03  # Largest share of friction in a correct A
QUIET = 20.0  # Largest frequency in the search for friction's harmonics [Hz]; above it encoder steps cause more voltage


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
            worst = float(f[int(np.argmax(np.abs(np.log(fit.measured.response[fit.used] / fit.model(f)))))])
            found = {"misfit": size, "worst": worst, "highest": 0.5 * worst}
            yield response.RESPONSE_MISFIT.found(name, wrong=size >= response.FALSE, **found)
    if (mode := solution.form.resonance(solution.values)) is not None:
        by_motor = mode.encoder == "motor"
        frequency, share = Estimate(mode.frequency, "Hz"), mode.ratio if by_motor else 0.0
        yield response.SECOND_MASS.found(encoder=mode.encoder, frequency=frequency, share=share)
        if by_motor:
            yield response.SPRING_IN_SERIES.found()
    yield from _of_friction(fits, friction, estimates)
    if float(estimates["A"]) <= float(solution.half_widths()[0]):
        lowest = min(float(fit.measured.table.frequency[fit.used].min()) for fit in fits)
        yield response.A_OPEN.found(lowest=lowest)
    edge = hold_delay(hold) if hold else 0.0
    if float(estimates["T_d"]) <= edge * (1 + 1e-6):
        yield response.T_D_AT_BOUND.found(hold=bool(hold))
    yield response.A_HOLDS_VISCOUS.found()
    if "K_f" not in estimates:
        yield K_F_MISSING.found()


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
    added = [_friction_seen(fit) for fit in fits]
    small = all(value is not None and value < SMALL for value in added)
    yield response.A_HOLDS_FRICTION.found(each=each, small=small, limit=SMALL)


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
    at = lines.frequency[within]
    voltage = lines.position[within] / fit.model(at) - lines.input[within]
    count = 3 * QUIET / float(lines.frequency[0])
    power = 2 * float(np.mean(np.abs(voltage) ** 2)) * count
    level = 2 * np.sqrt(power / (1 - 2 / np.pi))
    plant = fit.solution.plant()
    return float(level * plant.B * gain / max(plant.A, 1e-300))

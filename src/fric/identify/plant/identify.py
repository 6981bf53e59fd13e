"""The plant of eq. (1) from frequency responses, or from an ordinary motion, and the choice of records."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from itertools import chain
from typing import Literal, NamedTuple

import numpy as np
from scipy.special import stdtrit

from fric.arrays import Complex, Mask, Real
from fric.choice import simplest
from fric.drive.plant import CURRENT_LOOP, hold_delay
from fric.drive.resonance import Encoder, Resonance
from fric.errors import FricError, found_in
from fric.estimate import Estimate
from fric.flaws import response
from fric.flaws.channel import K_F_MISSING
from fric.flaws.drift import RECORDS_VARY
from fric.flaws.response import (
    A_HOLDS_FRICTION,
    A_HOLDS_VISCOUS,
    A_OPEN,
    CHANGES_BETWEEN,
    MASS_NOT_SHOWN,
    NOT_PHYSICAL,
    T_D_ASSUMED,
    VISCOUS_BY_DIRECTION,
)
from fric.identify.plant.frequency_response import MeasuredResponse, driven_alike, measure_response
from fric.identify.plant.response_fit import (
    UNDETERMINED,
    ForceScale,
    FrictionInfluence,
    Lines,
    PlantFit,
    PlantSolution,
    ResponseFit,
    against_mass,
    at,
    force_scale,
    near,
    select,
    solve,
)
from fric.log import ForceVelocity, FrequencyResponse, Log, Record, refuse_several_axes
from fric.notice import Notice
from fric.records.flaws import even_sampling, evened, record_flaws
from fric.records.inspection import CONDITION
from fric.records.motion import BANDWIDTH, Conditioning, kept, shows_mass, thinned
from fric.records.prepared import Drive, Prepared, prepared
from fric.records.recognition import kind_of
from fric.statistics import DIFFERENT, Between, between_records, hac_covariance, robust_deviation, widened
from fric.threads import one_blas_thread
from fric.units import Motion, is_effort, readable, rotates, si_unit

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
    even, uneven = zip(*(evened(given) if isinstance(given, Log) else (given, []) for given in records), strict=True)
    logs = [record for record in even if isinstance(record, Log)]
    fits, sets = [], []
    for measured, clock in zip(_measured(even, clocks, period, segment), clocks, strict=True):
        rate = None if continuous else hold or measured.sampling
        with _blamed_on(clock):
            lines, used = select(measured, hold=rate, coherence=coherence, band=band)
        with found_in(measured.table.where):
            solution, kept = solve_with_modes(lines)
        used[np.flatnonzero(used)[~kept]] = False
        fits.append(ResponseFit(measured, used, solution, rate, tuple(float(f) for f in lines.frequency[~kept])))
        sets.append(at(lines, kept))
    solution, influence = _joined(fits, sets)
    motion = fits[0].measured.table.motion
    rate = min((fit.hold for fit in fits if fit.hold is not None), default=None)
    estimates = solution.estimates(motion)
    scale = force_scale(logs, given_force_constant, motion, period=period, segment=segment, strokes=strokes)
    estimates |= scale.estimates()
    others = [*chain(*uneven), *scale.warnings, *against_mass(estimates, mass, motion)]
    transport = estimates["T_d"]
    if rate is not None:
        low, high = transport.ci95 or (0.0, 0.0)
        half = hold_delay(rate)
        transport = replace(transport, value=float(transport) - half, ci95=(low - half, high - half))  # type: ignore[operator]
    notices = list(described(fits, solution, influence, estimates, rate))
    if {A_OPEN.code, A_HOLDS_FRICTION.code} <= {notice.code for notice in notices if notice.severity != "note"}:
        # the rest is friction: strokes show all viscous friction, where no damping is subtracted
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
    bounded = [float(np.sum(np.minimum(np.abs(_off(lines, fit.solution)) / scale, OFF) ** 2)) for fit in (rigid, found)]
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
        outlying = off > np.maximum(OFF * np.hypot(usual, lines.deviation), VISIBLE)
        if np.count_nonzero(outlying) > MOST_OUTLIERS * len(outlying) or np.array_equal(~outlying, kept):
            break
        kept = ~outlying
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


UNEVEN = 0.05  # Share of the viscous friction by which directions differ from their mean, above which it is warned of
REST = 0.05  # Share of the largest speed below which the axis rests or creeps, and the force does not show friction
RESTS = 0.1  # Share of such samples above which they are left out; without a filter they always are
FEWEST = 30  # Least number of samples of a fit


RigidAxis = tuple[Real, Real]
"""M, F_v, F_c and offset of a rigid axis, shape (4,), and their covariance (4, 4)."""


@dataclass(frozen=True)
class MotionFit:
    """A rigid axis fitted to its motion: ``force = M·z̈ + F_v·ż + F_c·sign(ż) + offset``."""

    axis: str  # axis, motion: name and motion of the axis
    motion: Motion
    # ``force``, or ``input`` where no force was logged and no force constant given: then M, F_v, F_c and offset are in
    # volts (per m/s², per m/s)
    channel: Literal["force", "input"]
    # M, F_v, F_c and offset; or M and F_v, F_c of either direction. Intervals allow for correlated residuals.
    estimates: dict[str, Estimate]
    # Standard deviation of each by ordinary least squares, for independent residuals
    deviation: dict[str, float]
    plant: dict[str, Estimate]  # A, B, T_d of eq. (1), and K_f where it is known.
    relative_error: float  # ``‖residual‖/‖force‖`` [1]
    condition_number: float  # Of the observation matrix
    autocorrelation: float  # Of neighbouring residuals, after decimation
    sampling: float  # sampling, conditioning: sampling rate [Hz] and filters of the first record
    conditioning: Conditioning
    # time, measured, fitted: decimated samples: instants [s], and logged and fitted force, each of shape (n,)
    time: Real
    measured: Real
    fitted: Real
    warnings: tuple[Notice, ...] = ()  # Warnings: what the data do not determine


def identify_motion(  # noqa: PLR0913 - the verb of its name gives each setting
    logs: Sequence[Log],
    *,
    direction: Literal["both", "each"] = "both",
    force_constant: float | None = None,
    delay: float | None = None,
    cutoff: float | None = None,
    decimation: int | None = None,
    border: int | None = None,
    mass: float | None = None,
    replayed: Callable[[Sequence[Prepared]], RigidAxis | None] | None = None,
) -> MotionFit:
    """Fit a rigid axis to motions by least squares on zero-phase filtered, decimated signals.

    The inverse dynamic model of Janot, Gautier and Brunot (Nonlinear System Identification Benchmarks, 2019):
    the position is filtered forwards and backwards, differentiated by central differences, and each column of the
    observation matrix is decimated like the force. Where the rate would put the filter's corner into the motion there
    is no filter; many rests, and samples between which the speed changes, are left out.

    logs: Records of one axis, each with a force or an input; instants that jitter are made even.
    direction: Common F_v, F_c and an offset, or F_v and F_c for each direction (an offset is then half their
        difference).
    force_constant: K_f [N/V]; with it an input is used as force.
    delay: T_d [s], which a motion does not show; by default half a sample. If given, it is the delay of the force after
        its voltage.
    cutoff, decimation, border: See `Conditioning`; chosen from the sampling rate where not given.
    replayed: Gives the estimates of motions by a law that falls with speed and yields before it slides; they are taken
        where their intervals are narrower, or they are outside of those of the rigid fit.
    Raises FricError: When neither force nor input was logged, the sampling is uneven, or the motion does not separate
        the terms.
    """
    motion, flaws = logs[0].motion, record_flaws(logs, "plant")
    logs, clocks = zip(*map(evened, logs), strict=True)
    channel: Literal["force", "input"] = (
        "force" if all(log.force is not None for log in logs) or force_constant is not None else "input"
    )
    rates = [even_sampling(log) for log in logs]
    settings = [Conditioning.of(rate, cutoff, decimation, border) for rate in rates]
    effort = is_effort(motion)
    if effort:  # it acts when it is logged, and is late behind what the controller asks for
        late = 0.5 / (np.pi * CURRENT_LOOP) + hold_delay(HELD) if delay is None else delay
        unity = Estimate(1.0, si_unit("force per input", motion), fixed=True)
        scale = ForceScale(unity, Estimate(late, si_unit("time", motion), assumed=True))
    else:
        scale = force_scale(logs, force_constant, motion)
    scaled = force_constant is not None
    served = [
        replace(log, force=None) if channel == "input" or (scaled and log.input is not None) else log for log in logs
    ]
    settings = [replace(s, cutoff=0.0) if cutoff is None and s.cutoff < 5 * BANDWIDTH else s for s in settings]
    timing = (0.0, 0.0) if effort else (delay or 0.0, scale.shift)
    drive = Drive(force_constant or 1.0, *timing)
    records = prepared(served, drive=drive, filters=settings)
    shown = [_in_motion(record, s) for record, s in zip(records, settings, strict=True)]
    settings = [
        s if record.used[s.border :].all() else replace(s, decimation=1)
        for record, s in zip(shown, settings, strict=True)
    ]
    names = ("M", "F_v", "F_c", "offset") if direction == "both" else ("M", *_EACH)
    X = np.vstack([_observations(record, s, direction) for record, s in zip(shown, settings, strict=True)])
    forces = [thinned(record.drive[record.used], s.decimation) for record, s in zip(shown, settings, strict=True)]
    times = [record.log.time[record.used] for record in shown]
    times = [t[kept(len(t), s.decimation)] for t, s in zip(times, settings, strict=True)]
    y, time = np.concatenate(forces), np.concatenate(times)
    if len(y) < FEWEST or not any(shows_mass(record.motion, record.used) for record in shown):
        what = f"at {max(rates):.3g} Hz the speed changes between samples, and the mass is not seen"
        raise FricError(what, where=logs[0].where, hint="Log ten samples or more of each start and stop.")
    _refuse_rank(X, names, logs[0])

    values = np.asarray(np.linalg.lstsq(X, y, rcond=None)[0], float)
    residual = y - X @ values
    spread = np.std(residual, ddof=1)
    deviation = spread * np.sqrt(np.diag(np.linalg.inv(X.T @ X)))
    lengths = [len(force) for force in forces]
    covariance = hac_covariance(X, residual, lengths)
    quantile = float(stdtrit(len(y) - len(values), 0.975))
    rates_of = [
        thinned((record.done.timing * np.gradient(record.drive, record.log.time))[record.used], s.decimation)
        for record, s in zip(shown, settings, strict=True)
    ]
    covariance = covariance + _of_timing(X, np.concatenate(rates_of), residual, lengths)
    ends = np.cumsum(lengths)[:-1]
    between = between_records(np.split(X, ends), np.split(residual, ends), quantile)
    if between is not None:
        covariance = covariance + between.covariance
    as_usual = direction == "both" and (cutoff, decimation, border) == (None,) * 3
    if replayed is not None and as_usual:
        with suppress(FricError):  # a replay needs more of a record than this fit
            whole = prepared([replace(log, kind="motion") for log in served], drive=drive)
            values, covariance = _finer((values, covariance), replayed(whole))
            residual = y - X @ values

    half = quantile * np.sqrt(np.diag(covariance))
    units = [_unit(name, channel, motion) for name in names]
    estimates = {
        name: Estimate.around(float(v), unit, float(h))
        for name, v, h, unit in zip(names, values, half, units, strict=True)
    }

    K_f = scale.K_f
    plant = scale.estimates() | _plant(
        np.asarray(values, float), covariance, quantile, direction, channel, K_f, delay,
        float(scale.lag) if effort and scale.lag is not None else hold_delay(max(rates)), motion,
    )  # fmt: skip
    lag = float(residual[1:] @ residual[:-1] / (residual @ residual))
    return MotionFit(
        logs[0].axis, motion, channel, estimates, dict(zip(names, map(float, deviation), strict=True)), plant,
        float(np.linalg.norm(residual) / np.linalg.norm(y)), float(np.linalg.cond(X)), lag, rates[0], settings[0],
        time, y, X @ values,
        (*_varies(between, estimates), *_directions(X, y, lengths, estimates),
         *_warnings(records, settings[0].border, estimates, K_f, assumed=delay is None),
         *scale.warnings, *against_mass(plant, mass, motion), *chain(*clocks), *flaws),
    )  # fmt: skip


def _finer(rigid: RigidAxis, replay: RigidAxis | None) -> RigidAxis:
    """Return the replay where it is finer or outside of the rigid fit's intervals, else the latter, widened by it."""
    if replay is None:
        return rigid
    (values, covariance), off = rigid, replay[0] - rigid[0]
    half, other = (1.96 * np.sqrt(np.diag(found))[:3] for found in (covariance, replay[1]))
    if np.prod(other) < np.prod(half) or (np.abs(off)[:3] > half).any():
        return replay
    return values, widened(covariance, replay[1] + np.outer(off, off))


HELD = 4000.0  # Rate of the hold that is assumed beside a current loop [Hz], as of controllers that fric designs
_EACH = ("F_v_positive", "F_c_positive", "F_v_negative", "F_c_negative")


def _of_timing(X: Real, late: Real, residual: Real, lengths: Sequence[int]) -> Real:
    """Return the increase of the covariance (p, p) due to the alignment of force and position within a sample.

    As `fric.identify.replay.replay_fit.of_supposed`, by a force that is late by one standard deviation (n,).
    """
    joint = np.column_stack([late, X])
    if not late.any() or np.linalg.cond(joint / np.linalg.norm(joint, axis=0)) > CONDITION:
        return np.zeros((X.shape[1], X.shape[1]))
    moved = np.linalg.lstsq(X, late, rcond=None)[0]
    found = np.linalg.lstsq(joint, residual, rcond=None)[0]
    variance = float(hac_covariance(joint, residual - joint @ found, lengths)[0, 0])
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
    """Refuse a motion along which two terms are collinear, for any units of the columns."""
    size = np.linalg.norm(X, axis=0)
    dead = [name for name, norm in zip(names, size, strict=True) if norm == 0]
    if dead:
        raise FricError(
            f"the motion does not excite {', '.join(dead)}", where=log.where, hint="Log a motion in both directions."
        )
    if np.linalg.cond(X / size) > CONDITION:
        raise FricError(
            "the motion does not separate mass, viscous and Coulomb friction",
            where=log.where,
            hint="Log a motion in both directions, with changing speed and acceleration.",
        )


def _unit(name: str, channel: str, motion: Motion) -> str:
    dimension = "mass" if name == "M" else "viscous" if name.startswith("F_v") else "force"
    if channel == "force":
        return si_unit(dimension, motion)
    length = si_unit("position", motion)
    return {"mass": f"V*s^2/{length}", "viscous": f"V*s/{length}", "force": "V"}[dimension]


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
    if is_effort(motion):  # behind an effort a drive has no damping: what is viscous is friction
        found["A"] = Estimate(0.0, si_unit("rate", motion), fixed=True)
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
    error = float(np.sqrt(hac_covariance(more, y - more @ values, lengths)[-1, -1]))
    mean, by = float(values[1]), float(values[-1])
    if abs(by) > max(float(stdtrit(len(y) - len(values), 1 - DIFFERENT / 2)) * error, UNEVEN * abs(mean)):
        unit = estimates["F_v"].unit
        yield VISCOUS_BY_DIRECTION.found(forward=Estimate(mean + by, unit), backward=Estimate(mean - by, unit))


def _varies(between: Between | None, estimates: Mapping[str, Estimate]) -> Iterator[Notice]:
    """Warn about differences of records that chance does not explain."""
    if between is not None and between.chance < DIFFERENT:
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
        yield CHANGES_BETWEEN.found(share=max(hidden), less=False)
    for name, estimate in estimates.items():
        if (name == "M" or name.startswith(("F_v", "F_c"))) and float(estimate) <= 0:
            falls = name.startswith("F_v") and float(estimates["M"]) > 0
            yield NOT_PHYSICAL.found(name=name, value=estimate, falls=falls)
        elif name == "M" and estimate.half_width >= float(estimate):
            yield MASS_NOT_SHOWN.found(mass=estimate)
    if not is_effort(motion := records[0].log.motion):
        yield A_HOLDS_VISCOUS.found()
    if assumed:
        yield T_D_ASSUMED.found(effort=is_effort(motion))
    if K_f is None:
        yield K_F_MISSING.found()

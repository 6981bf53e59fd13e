"""Any friction model fitted to any records by replaying its step along the measured motion.

The blocks of a GMS model are placed best among all local least-squares solutions. If a model has fewer blocks than the
machine, its knots can be placed in several ways, like those of any spline with free knots: the start decides by chance,
and the interval of a solution does not include the others. But the force is linear in the shares of blocks with given
k/alpha (`fric.identify.replay.replay_search`). So a replay with a row of blocks gives the residual of any few blocks:
all places on a grid are tried and the best refined, without further replay. The same with noise added to the force
shows how far noise moves them.

A knot is separable from the reversal, and from the previous knot, at a distance of `RESOLVED` encoder steps.

Intervals allow for a lag of the force. A force that is logged τ late is ``F(t - τ)``, to first order ``F - τ·dF/dt``.
After a reversal this rounds the corner of the hysteresis cycle, which blocks of a model cannot do: so a model that can
follow a virgin curve of any shape separates the lag from stiffness. With another model its misfit would look like a
lag.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import chain, combinations
from math import comb, exp, log
from typing import NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.special import chdtrc, expit, stdtrit

from fric.arrays import Indices, Mask, Real
from fric.columns import PRESLIDING
from fric.errors import FricError, require_known
from fric.estimate import TWOFOLD, Covariance, Estimate, Interval, Scale
from fric.flaws.blocks import EXPLAINS_LITTLE, NEVER_SLIDES, PARAMETER_AT_BOUND, PARAMETER_AT_EDGE, PARAMETER_UNSEEN
from fric.flaws.channel import FORCE_LATE, FORCE_LATE_OPEN, STIFFNESS_UNRESOLVED
from fric.flaws.drift import RECORDS_VARY
from fric.flaws.response import CHANGES_BETWEEN
from fric.friction import FrictionModel, Parameter, models
from fric.friction.directed import Directed
from fric.friction.gms import GMS
from fric.friction.stribeck import STATIC_PARAMETERS, StaticMap
from fric.identify.plant.identify import RigidAxis
from fric.identify.replay import replay_search
from fric.identify.replay.replay_search import Coordinate, Coordinates, Key, Point, Ranges, Search, side_by_side
from fric.notice import Notice
from fric.process import one_blas_thread
from fric.records.flaws import record_flaws
from fric.records.inspection import CONDITION, RESOLVED, energy_changes, identifiability_of, too_coarse
from fric.records.preparation import DIMENSIONS, Own
from fric.records.prepared import Prepared, between_reversals
from fric.records.recognition import kind_of
from fric.statistics import DIFFERENT, OF_TWO, hac_covariance, jackknife, pooled, reach, sandwich, supposed, widened
from fric.units import Motion, readable, si_unit

SPANS_ALIKE = 1.5  # Ratio of the spans of two records up to which they count as the same motion
LAGS = 10  # Lags at which residuals are tested against white noise
Beyond = Callable[[Search, Real, Real], Real]
"""Increase of a covariance (s, s) that residuals do not show: of a search, its end (p,), and directions seen (p, s)."""
YIELDS = 0.1  # Share of the travel of a sample within which a contact yields, of which the samples show no start
MOST_IN_MOTION = 20_000  # Samples of a motion that are replayed for a plant at most: of more, every n-th
MOST_MOTIONS = 5  # Motions that are replayed for a plant at most, some seconds each: those that show the mass best
BLIND = 1e-6  # Share of the largest effect of a direction below which records do not determine a direction


def white(residual: Real, lengths: Sequence[int]) -> bool:
    """Return whether residuals are consistent with white noise (Ljung and Box, Biometrika 65, 1978, at 1 %)."""
    statistic = 0.0
    for part in np.split(residual, np.cumsum(lengths)[:-1]):
        lags = min(LAGS, len(part) // 4)
        rho = [float(part[lag:] @ part[:-lag]) / max(float(part @ part), 1e-300) for lag in range(1, lags + 1)]
        statistic += len(part) * (len(part) + 2) * sum(r * r / (len(part) - k) for k, r in enumerate(rho, start=1))
    return bool(chdtrc(LAGS * len(lengths), statistic) >= 0.01)


def covariance_of(gradient: Real, residual: Real, lengths: Sequence[int], most: float = 12.0) -> Real:
    """Return the covariance (p, p) of a least-squares fit.

    If the residuals are `white`, it is that of ordinary least squares; else that of `hac_covariance`, which is valid
    for any residuals but less precise.
    """
    if not white(residual, lengths):
        return hac_covariance(gradient, residual, lengths, most)
    n, p = gradient.shape
    try:
        back = np.linalg.inv(np.linalg.qr(gradient, mode="r"))
    except np.linalg.LinAlgError:
        raise FricError("a parameter has no effect along these records", hint="Log larger motions.") from None
    return np.asarray(back @ back.T * float(residual @ residual) / (n - p))


def replay_covariance(
    gradient: Real, residual: Real, records: Sequence[Prepared], quantile: float, most: float = 12.0
) -> Real:
    """Return the covariance (p, p) of a fit by replay.

    It is that of `covariance_of`, and where the residuals are not white, widened where one of two resamplings gives
    more for a parameter: leaving out cycles shows how the drive repeats (`jackknife`), and weighing the parts of a
    cycle shows the error of the model that recurs at the same place (`sandwich`). So if a model has fewer blocks than
    the machine, the interval is of the block that replaces several.
    """
    lengths = [int(record.used.sum()) for record in records]
    covariance = covariance_of(gradient, residual, lengths, most)
    if white(residual, lengths):
        return covariance
    cycles, phases = ([getattr(record, of)[record.used] for record in records] for of in ("cycle", "phase"))
    resampled = [
        by(gradient, residual, np.concatenate([1000 * i + label for i, label in enumerate(labels)]))
        for by, labels in ((jackknife, cycles), (sandwich, phases))
    ]
    return widened(covariance, *(array / quantile**2 for array in resampled))


class Levels(NamedTuple):
    """Variation of the level of friction between records."""

    deviation: float  # Standard deviation of the records' levels [1]
    each: Real  # Level of each record less the mean [1], shape (R,)
    chance: float  # Probability with which records of one level scatter so
    sure: bool  # Whether they scatter beyond chance, where two alone show it
    alike: bool  # Whether they have one motion
    gained: Real  # What the covariance of the joint parameters gains by it, shape (s, s)
    left: Real  # The residuals less what levels explain, shape (n,)


def levels_of(search: Search, best: Point, shown: Real, quantile: float) -> Levels | None:
    """Return the variation of the level of friction between records; None if it cannot be told from the parameters.

    Record r shows ``(1 + u_r)·F``. The contrasts of u are estimated beside all parameters, by one Gauss-Newton step,
    with the covariance V of `replay_covariance`: ``s² = Σu²/(R - 1)``, with the error ``v = tr V/(R - 1)`` in it. With
    H, how parameters move with each u, they gain ``H·Hᵀ·(r²/1.96² - v)`` beyond their covariance; r is the `reach`.
    Where motions were logged again, these contrasts are those within records of one motion. Those between motions are
    then what the model misses, and what they move counts as an error once.

    shown: Derivatives of the residual by what is seen, shape (n, s).
    """
    records, model = search.records, search.coordinates.build(best.x)
    spans = [float(np.ptp(record.motion.position[record.used])) for record in records if not record.slides]
    if (count := len(spans)) < 2:
        return None
    member = np.eye(len(records))[:, [not record.slides for record in records]]
    replayed = [np.outer(record.replay(model), row) for record, row in zip(records, member, strict=True)]
    columns = search.projected(replayed)
    of = _motions(spans)
    alike = bool(of.max() < count - 1)  # else no motion was logged twice, and all contrasts count
    each = np.equal.outer(np.unique(of), of) if alike else np.ones((1, count), dtype=bool)
    contrasts = np.hstack([
        np.eye(count)[:, rows] @ np.linalg.qr(np.eye(number) - 1.0 / number)[0][:, : number - 1]
        for rows, number in zip(each, each.sum(axis=1), strict=True)
    ])  # fmt: skip
    free = contrasts.shape[1]
    between = (each[1:] - each[1:].mean(axis=1, keepdims=True)).T
    X = np.column_stack([columns @ contrasts, columns @ between, shown])
    if np.linalg.cond(X / np.linalg.norm(X, axis=0)) > CONDITION:
        return None
    found = np.linalg.lstsq(X, best.residual, rcond=None)[0]
    V = replay_covariance(X, best.residual - X @ found, records, quantile)[:free, :free]
    u, error = found[:free], float(np.trace(V)) / free
    deviation = float(np.sqrt(u @ u / free))
    beyond = max((reach(deviation, error**0.5, free + 1) / 1.96) ** 2 - error, 0.0)
    chance = float(chdtrc(free, float(u @ np.linalg.solve(V, u))))
    H = np.linalg.lstsq(shown, columns, rcond=None)[0]
    missed = between @ found[free : count - 1]
    left, gained = best.residual - columns @ (contrasts @ u + missed), beyond * H @ H.T
    gained += np.outer(H @ missed, H @ missed)
    return Levels(deviation, contrasts @ u, chance, free > 1 or chance < OF_TWO, alike, gained, left)


def _motions(spans: Sequence[float]) -> Indices:
    """Return the number of each record's motion: the spans of one motion differ by less than `SPANS_ALIKE`."""
    found, number, begun = np.zeros(len(spans), dtype=int), -1, 0.0
    for n in np.argsort(spans):
        if spans[n] >= SPANS_ALIKE * begun:
            number, begun = number + 1, spans[n]
        found[n] = number
    return found


class Slopes(NamedTuple):
    """Derivatives of a parameter (a value for each block) by the search coordinates, on the scale of its interval."""

    parameter: Parameter
    scale: Scale
    centre: Real
    slope: Real  # Derivatives over the coordinates, shape (blocks, p)


@dataclass(frozen=True)
class Solved:
    """A solution of a search, and the uncertainty around it."""

    coordinates: Coordinates  # The search coordinates
    x: Real  # Their values, shape (p,)
    seen: Mask  # Which of them the records determine, shape (p,)
    covariance: Real  # Their covariance, shape (p, p); nan where they are not determined
    quantile: float  # Half-widths in standard deviations

    @cached_property
    def values(self) -> dict[str, dict[str, float | tuple[float, ...]]]:
        """All parameters in SI, by section and name."""
        return self.coordinates.values(self.x)

    @cached_property
    def slopes(self) -> dict[Key, Slopes]:
        """The `Slopes` of the fitted parameters."""
        return slopes(self.coordinates, self.x)

    @property
    def _known(self) -> Real:
        return np.where(self.seen[:, None] & self.seen, self.covariance, 0.0)

    @cached_property
    def _near(self) -> Real:
        """The distance at which each coordinate counts as at its bound: a tenth of its standard error."""
        error = np.sqrt(np.nan_to_num(np.diag(self.covariance)))
        return np.asarray(np.maximum(0.1 * error, 1e-6 * (self.coordinates.upper - self.coordinates.lower)))

    def order(self) -> list[int]:
        """Return the blocks in the order in which they slip: by their limit over their stiffness."""
        for section, parameters in self.coordinates.model.declared().items():
            blocks = {p.dimension: np.asarray(self.values[section][p.name]) for p in parameters if p.per_block}
            if "stiffness" in blocks and len(blocks) == 2:
                (limit,) = (value for dimension, value in blocks.items() if dimension != "stiffness")
                return [int(n) for n in np.argsort(limit / blocks["stiffness"], kind="stable")]
        return list(range(self.coordinates.blocks))

    def joint(self) -> Covariance:
        """Return the covariance of the parameters that the records determine, blocks in the order of their slip."""
        names: list[str] = []
        scales: list[Scale] = []
        rows: list[Real] = []
        for (_, name), found in self.slopes.items():
            vector = found.parameter.per_block
            for number, n in enumerate(self.order() if vector else [0], 1):
                if name != replay_search.LEVEL.name and not (np.abs(found.slope[n, ~self.seen]) > 1e-6).any():
                    names.append(f"{name}_{number}" if vector else name)
                    scales.append(found.scale)
                    rows.append(found.slope[n])
        slope = np.reshape(rows, (len(rows), len(self.x)))
        return Covariance.of(names, slope @ self._known @ slope.T, scales)

    def limits(self) -> dict[Key, tuple[tuple[float, float], ...]]:
        """Return the 95 % intervals of parameters: symmetric in the logarithm, the logit of a share, or linearly."""
        limits = {}
        for key, (p, scale, centre, slope) in self.slopes.items():
            error = self.quantile * np.sqrt(np.einsum("ij,jk,ik->i", slope, self._known, slope))
            error[(np.abs(slope[:, ~self.seen]) > 1e-6).any(axis=1)] = np.inf
            low, high = self._within_search(key, centre, centre - error, centre + error)
            if scale == "logit":
                low, high = expit(low), expit(high)
            elif scale == "log":
                with np.errstate(over="ignore"):
                    low, high = np.exp(low), np.exp(high)
            low, high = np.maximum(low, p.lower), np.minimum(high, p.upper)
            limits[key] = tuple((float(a), float(b)) for a, b in zip(low, high, strict=True))
        for section, fall in {key[0]: found[0][0] for key, found in limits.items() if key[1] == "v_s"}.items():
            if fall == 0.0 and {(section, "F_c"), (section, "F_s")} <= limits.keys():
                # friction that falls at any lower speed may fall from any level
                limits[section, "F_s"] = ((limits[section, "F_c"][0][0], limits[section, "F_s"][0][1]),)
        return limits

    def _within_search(self, key: Key, centre: Real, low: Real, high: Real) -> tuple[Real, Real]:
        """Return limits that are open beyond the search range, or if the value is at its edge.

        The records were not evaluated there. A parameter whose lower bound is another has no open lower limit.
        """
        of = [n for n, c in enumerate(self.coordinates.free) if c.key == key]
        scale, near = self.coordinates.free[of[0]].scale, self._near[of]
        if scale not in {"log", "ratio"}:
            return low, high
        below, above = (self.x - self.coordinates.lower)[of], (self.coordinates.upper - self.x)[of]
        high = np.where((high - centre > above) | (above < near), np.inf, high)
        if scale == "ratio":
            return np.maximum(low, centre - below), high
        return np.where((centre - low > below) | (below < near), -np.inf, low), high

    def edges(self) -> Iterator[Notice]:
        """Warn about parameters at the edge of their search range, and about undetermined blocks."""
        for c, at, is_seen, near in zip(self.coordinates.free, self.x, self.seen, self._near, strict=True):
            if not is_seen:
                yield PARAMETER_UNSEEN.found(parameter=c.label, left="")
            elif at - c.lower < min(near, 0.02) and c.scale == "ratio":
                yield PARAMETER_AT_BOUND.found(parameter=c.label, bound=str(c.parameter.at_least), no_effect=True)
            elif at - c.lower < near and c.scale == "linear" and c.lower == c.parameter.lower:
                yield PARAMETER_AT_BOUND.found(parameter=c.label, bound=f"{c.lower:g}", no_effect=False)
            elif c.scale != "share" and min(at - c.lower, c.upper - at) < near:
                yield PARAMETER_AT_EDGE.found(parameter=c.label)


def slopes(coordinates: Coordinates, x: Real) -> dict[Key, Slopes]:
    """Return the `Slopes` of the fitted parameters at a point, shape (p,)."""
    scales: dict[Key, tuple[Parameter, Scale]] = {
        c.key: (c.parameter, {"linear": "linear", "share": "logit"}.get(c.scale, "log"))  # type: ignore[misc]
        for c in coordinates.free
    }

    def quantities(at: Real) -> dict[Key, Real]:
        values, found = coordinates.values(at), {}
        for (section, name), (_, scale) in scales.items():
            value = np.atleast_1d(np.asarray(values[section][name], float))
            logit = np.log1p(-value) if scale == "logit" else 0.0
            found[section, name] = value if scale == "linear" else np.log(value) - logit
        return found

    centre, steps = quantities(x), replay_search.STEP * (coordinates.upper - coordinates.lower)
    moved = [quantities(x + step * unit) for step, unit in zip(steps, np.eye(len(x)), strict=True)]
    by = {key: np.array([found[key] for found in moved]) for key in centre}
    return {key: Slopes(*scales[key], at, (by[key] - at).T / steps) for key, at in centre.items()}


SUSPECTED = 0.6  # Lag [samples] above which the lag is estimated again, with the force moved by it
CLEAR = 2.5  # Ratio of mean lag to half-width above which a lag is reported: hunting looks like a smaller lag
LATEST_SAMPLES, LATEST = 4.0, 10e-3  # Largest lag in samples, or by a filter [s]: smooth friction looks like a lag
BLOCKS = 3  # Number of blocks for a virgin curve of any shape


def lateness(search: Search, best: Point, quantile: float) -> dict[str, Estimate]:
    """Return the lag of the logged force behind the position [s], by record, for cycles only.

    It is one Gauss–Newton step from the solution, in the lag of each record, a damping that map and plant lack, and all
    parameters. Its interval includes what recurs in each cycle, and alignment of the channels to half a sample.
    """
    records, seen, cycled = search.records, search.seen(best), _cycled(search)
    if not cycled or not seen.any() or search.coordinates.model is not GMS:
        return {}
    rates = _rates(search.coordinates.build(best.x), records)
    late = [search.projected([rate * (n == number) for n, rate in enumerate(rates)]) for number in cycled]
    damping = search.projected([record.motion.velocity for record in records])
    gradient = np.column_stack([*late, damping, best.gradient[:, seen]])
    step = -np.linalg.lstsq(gradient, best.residual, rcond=None)[0]
    deviation = np.sqrt(np.diag(replay_covariance(gradient, best.residual, records, quantile)))[: len(cycled)]
    half = quantile * np.hypot(deviation, [records[n].done.timing for n in cycled])
    unit = si_unit("time", records[0].log.motion)
    steps = zip(cycled, step, half, strict=False)
    return {records[n].log.name: Estimate.around(float(value), unit, float(width)) for n, value, width in steps}


def suspected(records: Sequence[Prepared], late: Mapping[str, Estimate]) -> bool:
    """Return whether the lag of any record needs a second estimate."""
    intervals = _intervals(records)
    return any(abs(float(by)) > SUSPECTED * intervals[name] for name, by in late.items())


def credible(records: Sequence[Prepared], late: Mapping[str, Estimate]) -> bool:
    """Return whether the log of a drive may have the mean of lags [s]."""
    interval = max(_intervals(records)[name] for name in late)
    return abs(float(mean_lag(late.values()))) <= max(LATEST_SAMPLES * interval, LATEST)


def _intervals(records: Sequence[Prepared]) -> dict[str, float]:
    return {record.log.name: float(np.median(np.diff(record.motion.time))) for record in records}


def mean_lag(late: Iterable[Estimate]) -> Estimate:
    """Return the mean of lags [s], weighted by their intervals: a drive logs all records in the same way."""
    every = list(late)
    weights = np.array([estimate.half_width for estimate in every]) ** -2.0
    lags = np.array([float(estimate) for estimate in every])
    return Estimate.around(float(weights @ lags / weights.sum()), every[0].unit, float(weights.sum() ** -0.5))


def one_lag(records: Sequence[Prepared], late: Mapping[str, Estimate], clear: float) -> bool:
    """Return whether lags [s] agree within their intervals, and their mean exceeds a number of its half-widths.

    A difference between records is not a lag. A drive that hunts errs alike whenever it repeats a motion: the mean over
    its records is no surer than that of a single one.
    """
    if not (every := list(late.values())):
        return False
    same = all(abs(float(a) - float(b)) <= np.hypot(a.half_width, b.half_width) for a, b in combinations(every, 2))
    spans = [float(np.ptp(record.motion.position[record.used])) for record in records if record.log.name in late]
    repeats = len(every) / (1 + int(_motions(spans).max()))
    return same and abs(float(mean := mean_lag(every))) > clear * mean.half_width * repeats**0.5


def lateness_notice(records: Sequence[Prepared], late: Mapping[str, Estimate], *, sure: bool) -> Notice:
    """Return the warning about the lag of the force of records, and whether its mean was corrected.

    sure: Whether the fit is better with it, and it is credible.
    """
    dt, sign = _intervals(records), float(np.copysign(1.0, float(mean_lag(late.values()))))
    parts = [
        f"'{name}' {readable(sign * float(by), by.unit, 2)} ± {readable(by.half_width, 's', 2)} "
        f"({sign * float(by) / dt[name]:.2g} samples)"
        for name, by in late.items()
    ]
    return FORCE_LATE.found(late=parts, later=sign > 0.0) if sure else FORCE_LATE_OPEN.found(late=parts)


def of_supposed(search: Search, best: Point, slopes: Real, quantile: float) -> Real:
    """Return the increase of the covariance (p, p) due to the alignment of force and position, and to levels.

    The channels of a log are aligned to ±dt/2: all records are late by c standard deviations of that, c ~ N(0, 1), and
    parameters move by m·c, to first order. Where blocks separate a lag from stiffness, and in motions (`in_motion`),
    the records show c as ĉ ± s: its second moment about 0, the lag of the fit, is ``s²/(1 + s²) + (ĉ/(1 + s²))²`` by
    Bayes' rule; elsewhere it is 1.
    So is the level of friction at the place of a record in sliding, in the standard deviation of its force over
    position: in one direction that is a force, or friction, which then differs from that at other places as much.

    slopes: Derivatives of the residual by what is seen, shape (n, p).
    """
    records, model = search.records, search.coordinates.build(best.x)
    moves = _moves(records)
    cycled = bool(_cycled(search)) and not any("mass" in r.done.own for r in records)
    late = [record.done.timing * rate for record, rate in zip(records, _rates(model, records), strict=True)]
    levels = [[of_level(model, other) * (other is record) for other in records] for record in records if record.slides]
    found = np.zeros((slopes.shape[1],) * 2)
    for forces, shown in [(late, cycled), *((level, True) for level in levels)]:
        by = search.projected(forces)
        moved, c, variance = np.linalg.lstsq(slopes, by, rcond=None)[0], 1.0, 0.0
        if forces is late and moves:
            c, variance = in_motion(search, best, quantile)
        elif shown and by.any():
            joint = np.column_stack([by, slopes])
            c = np.linalg.lstsq(joint, best.residual, rcond=None)[0][0]
            variance = replay_covariance(joint, best.residual, records, quantile)[0, 0]
        moment = variance / (1.0 + variance) + (c / (1.0 + variance)) ** 2
        found += moment * np.outer(moved, moved)
    return found


def in_motion(search: Search, best: Point, quantile: float) -> tuple[float, float]:
    """Return by how many of its standard deviations the force of motions is late, and the variance of that.

    Of samples apart from rests and reversals, for between samples a reversal hides: there the force is inertia and
    damping, whose rate no parameter of friction follows along a motion of several accelerations (Frisch and Waugh,
    Econometrica 1, 1933), nor damping that the model lacks, nor a load over the position.
    """
    part = replace(search, records=[record.in_motion() for record in search.records], weights=None)
    point = part.at(best.x)
    rates = _rates(search.coordinates.build(best.x), part.records)
    late = part.projected([-r.done.timing * rate for r, rate in zip(part.records, rates, strict=True)])
    motions = [record.motion for record in part.records]
    beside = part.projected([np.column_stack([m.velocity, np.sign(m.velocity), m.position]) for m in motions])
    Q = np.linalg.qr(np.column_stack([point.gradient[:, part.seen(point)], beside]))[0]
    size, late, residual = late @ late, late - Q @ (Q.T @ late), point.residual - Q @ (Q.T @ point.residual)
    if len(late) < FEWEST * (len(best.x) + 1) or late @ late <= BLIND * size:
        return 0.0, UNSEEN
    c = float(late @ residual / (late @ late))
    return c, float(replay_covariance(late[:, None], residual - c * late, part.records, quantile)[0, 0])


def usual_fall(search: Search, x: Real) -> Real:
    """Return a point, shape (p,), with friction that falls as it usually does: few samples of a motion are so slow."""
    at = x.copy()
    for n, c in enumerate(search.coordinates.free):
        if c.parameter.name == "v_s":
            at[n] = c.upper + log(0.05 / 3.0)  # of the fastest, as the range ends at three times that
        elif c.parameter.name == "F_s":
            at[n] = log(1.15)
    return at


def _moves(records: Sequence[Prepared]) -> bool:
    """Return whether records are motions that show a mass, in samples that show how they start and stop."""
    return all("mass" in record.done.own and record.done.starts and not record.slides for record in records)


def aligned(search: Search, best: Point, quantile: float) -> Search:
    """Return the search with motions moved to the instants of their force, where they show its lag within a sample."""
    if not _moves(search.records):
        return search
    c, variance = in_motion(search, best, quantile)
    if abs(c) > UNIFORM + 2.0 * variance**0.5:  # it is not that of samples
        return search
    by = c / (1.0 + variance)
    records = [record.moved(by * record.done.timing) for record in search.records]
    return replace(search, records=records, weights=None).weighed(best.x)


def of_level(model: FrictionModel, record: Prepared) -> Real:
    """Return how the force of a record changes with the level, by the share that varies over its places [N], (n,)."""
    law, replayed = model.model if isinstance(model, Directed) else model, record.replay(model)
    waves = record.record_part(record.force - replayed)[len(record.done.own) :]
    by = min(float(np.sqrt(0.5 * waves @ waves) / np.abs(replayed[record.used]).mean()), 0.5)
    if not isinstance(law, GMS):
        return by * replayed

    def at(level: float) -> Real:
        return side_by_side(model, level * np.array([law.alpha]), np.array([law.k]), law.C / level, record).sum((1, 2))

    return np.asarray(0.5 * (at(1.0 + by) - at(1.0 - by)))


FEWEST, UNSEEN = 10, 1e9  # Samples in motion a parameter that show a lag at least, and the variance where they do not
UNIFORM = 3.0**0.5  # Half-width of a uniform distribution in its standard deviations
SHAPE_STEP = 1e-2  # Step of the difference quotient over a supposed shape factor, in its standard deviation
NEAR = 1e-3  # Distance from the end of its range, as a share of it, below which a factor is at the end
SHOWN = 2.0  # Standard deviations by which records show another shape factor before it is fitted


def of_shape(search: Search, best: Point, key: Key, quantile: float) -> tuple[Real, bool]:
    """Return the increase of the covariance (p, p) due to a supposed shape factor, and whether records show another.

    The logarithm of the factor is c·`TWOFOLD` off, c ~ N(0, 1), and the fit at c is x + m(c), linear from c = 0 to -1
    and to 1, where it is solved again. Towards the smaller squares S a parabola has the slope S' at the fit and meets
    the squares of that solution. With the variance v of a residual the score is ``-S'/2v`` and the information
    ``S"/2v``, and the increase is the mean of m·mᵀ over the two values of `supposed`. v is as much larger than that of
    white noise as `replay_covariance` says of a Gauss-Newton step in c.
    """
    of, v, seen = search.coordinates, float(np.mean(best.residual**2)), search.seen(best)

    def at(c: float) -> Search:
        return replace(search, coordinates=replace(of, held={**of.held, key: of.held[key] * exp(c * TWOFOLD)}))

    column = (at(SHAPE_STEP).residual(best.x) - at(-SHAPE_STEP).residual(best.x)) / (2.0 * SHAPE_STEP)
    joint = np.column_stack([column, best.gradient[:, seen]])
    solved = {side: at(side).fine(best.x) for side in (-1.0, 1.0)}
    moves = [side * (x - best.x) for side, x in solved.items()]
    if np.linalg.cond(joint / np.maximum(np.linalg.norm(joint, axis=0), 1e-300)) > 1.0 / BLIND:
        return np.mean([np.outer(m, m) for m in moves], axis=0), False
    v *= replay_covariance(joint, best.residual, search.records, quantile)[0, 0]
    v /= np.linalg.inv(joint.T @ joint)[0, 0] * float(np.mean(best.residual**2))
    slope = 2.0 * float(column @ best.residual)
    side = -float(np.copysign(1.0, slope))
    information = max(at(side).cost(solved[side]) - float(best.residual @ best.residual) - side * slope, 0.0) / v
    score = -slope / (2.0 * v)
    each = [c * moves[int(c > 0.0)] for c in supposed(score, information)]
    return np.mean([np.outer(m, m) for m in each], axis=0), abs(score) > SHOWN * information**0.5


def _cycled(search: Search) -> list[int]:
    """Return the records whose cycles separate a lag from stiffness; none for a model of too few blocks."""
    if search.coordinates.blocks < BLOCKS:
        return []
    return [n for n, record in enumerate(search.records) if not record.slides and len(record.reversals) > 4]


def _rates(model: FrictionModel, records: Sequence[Prepared]) -> list[Real]:
    """Return the rate of the drive's force [N/s], shape (n,), of each record: friction, inertia and damping."""
    return [np.gradient(record.fitted(model) + record.taken_off, record.motion.time) for record in records]


ROW, MOST_SAMPLES = 160, 40_000  # Number of blocks in the row, and of samples in its replay
BEYOND = 1.5  # Excess width of the row over the blocks on either side, in the logarithm of k/alpha
WORSE = 1.02  # Ratio of squared residuals above which a place is rejected: the force is interpolated in the row
TRIED, SETTLED, STEPS = 20_000, 40, 24  # Most places tried on the grid; places refined; least-squares steps from each
RIVALS, PLACES_APART = 3, 0.05  # Points kept beside the best, and their least distance in log(k/alpha) of some block
DRAWS, LEAST = 96, 1e-4  # Number of noise draws, and the share of a step over which their effect is linear


@dataclass(frozen=True)
class Placement:
    """Good placements of blocks."""

    search: Search  # The search
    model: GMS  # The model whose static map and C are taken
    blocks: CubicSpline  # Force of a block of unit share over the logarithm of its k/alpha, in d directions
    target: Real  # The measured force in these directions, shape (d,)
    noisy: int  # Number of rows that are measured; the last row states that shares sum to 1
    apart: float  # How far two knots are apart at least, over F_s [m/N]
    places: Real  # Logarithms of k/alpha [N/m] of the least-squares points, shape (m, N), the best first
    shares: Real  # The shares there, shape (m, N)

    def point(self, places: Real, shares: Real) -> Real:
        """Return the point of the search (p,) of some blocks, in the order in which they slip."""
        total, order = float(shares.sum()), np.argsort(-places)
        found = replace(
            self.model, static=replay_search.times(self.model.static, total), alpha=tuple(shares[order] / total),
            k=tuple((shares * np.exp(places))[order]),
        )  # fmt: skip
        return replay_search.coordinates_of(self.search.coordinates, found)

    def better(self, x: Real) -> Real:
        """Return the best point of the search (p,); x if the row of blocks gives no better place."""
        if not len(self.places):
            return x
        best = self.point(self.places[0], self.shares[0])
        return best if self.search.cost(best) < WORSE * self.search.cost(x) else x

    def unsettled(self, size: float) -> Real:
        """Return the increase of a covariance (p, p) due to the nonlinear effect of noise on blocks.

        White noise is added to the force and the blocks are placed anew, from each known point: so an interval includes
        the curvature of the misfit over a knot, and other places as often as noise makes them better. The outer 5 % of
        the draws are clipped to the limits of the others.

        size: Standard deviation of the noise, that of the residual [N].
        """
        rng, count = np.random.default_rng(0), self.places.shape[1]
        noise = np.zeros((DRAWS, len(self.target)))
        noise[:, : self.noisy] = size * rng.standard_normal((DRAWS, self.noisy))
        noise[1::2] = -noise[::2]
        places, shares = self.places[0], self.shares[0]
        slopes = np.vstack([self.blocks(places), shares[:, None] * self.blocks(places, 1)])
        steps = np.linalg.lstsq(slopes.T, noise.T, rcond=1e-12)[0].T
        room = np.concatenate([0.5 * shares, np.full(count, 0.5)])  # of blocks that the records hardly separate
        least = np.minimum(LEAST, 1.0 / np.max(np.abs(steps) / room, axis=1, initial=1.0, keepdims=True))
        linear = [self.point(places + item[count:], shares + item[:count]) for item in least * steps]
        found = settled(
            self.blocks, np.tile(self.target + noise, (len(self.places), 1)), np.repeat(self.places, DRAWS, axis=0),
            STEPS // 2, self.apart,
        )  # fmt: skip
        first = np.argmin(found[2].reshape(-1, DRAWS), axis=0) * DRAWS + np.arange(DRAWS)
        moved = [self.point(found[0][n], found[1][n]) for n in first if np.isfinite(found[2][n])]
        best = self.point(places, shares)
        values, vectors = np.linalg.eigh(_spread(np.array(moved) - best) - _spread((np.array(linear) - best) / least))
        return np.asarray(vectors * np.maximum(values, 0.0) @ vectors.T)


def _spread(moved: Real) -> Real:
    """Return the mean squares and products (p, p) of moves (m, p), the outer 5 % of them as large as the limits."""
    kept = np.clip(moved, *np.quantile(moved, [0.025, 0.975], axis=0))
    return np.asarray(kept.T @ kept / len(kept))


def break_away(static: StaticMap) -> float:
    """Return F_s of a map, of which alpha is a share; raise a `FricError` where it is 0."""
    if static.F_s > 0.0:
        return static.F_s
    hint = "Look at what `fric identify static` says of that map, or leave `static=` out."
    raise FricError("the static map has no friction at break-away (F_s is 0), and alpha is a share of it", hint=hint)


def placed(search: Search, x: Real) -> Placement:
    """Return the best placement of the blocks of a GMS model.

    x: Point of the search, shape (p,): the static map, its level and C are taken from it, but no block.
    """
    if (every := -(-sum(len(record.force) for record in search.records) // MOST_SAMPLES)) > 1:
        search = replace(search, records=[record.thinned(every) for record in search.records], weights=None).weighed(x)
    model = search.coordinates.build(x)
    law = model.model if isinstance(model, Directed) else model
    assert isinstance(law, GMS)
    alpha, k = np.array(law.alpha), np.array(law.k)
    here = np.log(k / alpha)
    row = np.linspace(here.min() - BEYOND, here.max() + BEYOND, ROW)
    every_k = np.exp(np.append(row, here))[None]
    ones = np.ones_like(every_k)
    table = search.projected([side_by_side(model, ones, every_k, law.C, record)[:, 0] for record in search.records])
    target = search.residual(x) + table[:, ROW:] @ alpha
    small = np.asarray(np.linalg.qr(np.column_stack([table[:, :ROW], target]), mode="r"))
    noisy = len(small) - 1
    if all(c.parameter is not replay_search.LEVEL for c in search.coordinates.free):
        small = np.vstack([small, np.full(ROW + 1, 1e3 * np.linalg.norm(target))])  # the shares then sum to 1
    blocks, force = CubicSpline(row, small[:, :ROW].T), small[:, ROW]
    apart = RESOLVED * identifiability_of(search.records).resolved / break_away(law.static)
    places, shares, cost = settled(blocks, force, on_a_grid(blocks, force, len(alpha), apart), STEPS, apart)
    kept: list[int] = []
    for n in np.argsort(cost):
        if len(kept) <= RIVALS and np.isfinite(cost[n]):
            other = [np.abs(np.sort(places[n]) - np.sort(places[m])).max() > PLACES_APART for m in kept]
            kept += [int(n)] if all(other) else []
    return Placement(search, law, blocks, force, noisy, apart, places[kept], shares[kept])


def on_a_grid(blocks: CubicSpline, target: Real, count: int, apart: float) -> Real:
    """Return the best places (m, count) on the finest grid that can be searched completely; arguments as `settled`."""
    size = count + 1
    while size < ROW and comb(size + 1, count) <= TRIED:
        size += 1
    grid = np.linspace(blocks.x[0], blocks.x[-1], size)
    columns, chosen = blocks(grid), np.array(list(combinations(range(size), count)))
    right = (columns @ target)[chosen]
    normal = (columns @ columns.T)[chosen[:, :, None], chosen[:, None]] + _tiny(target, count)
    shares = np.linalg.solve(normal, right[..., None])[..., 0]
    possible = (shares > 0.0).all(axis=1) & _told_apart(grid[chosen], apart)
    gain = np.where(possible, np.sum(shares * right, axis=1), -np.inf)
    return np.asarray(grid[chosen[np.argsort(-gain, kind="stable")[:SETTLED]]])


def settled(blocks: CubicSpline, target: Real, places: Real, steps: int, apart: float) -> tuple[Real, Real, Real]:
    """Return places (m, N), shares (m, N) and cost (m,) of the least-squares points next to many starts (m, N).

    Levenberg and Marquardt's steps over places and shares, the shares solved for anew after each (variable projection).
    The target (d,) is common to all starts, or each has a target.
    """

    def solved(at: Real) -> tuple[Real, Real, Real, Real]:
        columns = blocks(at)
        shares = np.linalg.solve(columns @ columns.mT + tiny, columns @ target[..., None])[..., 0]
        rest = target - (shares[:, None] @ columns)[:, 0]
        left = np.where((shares > 0.0).all(axis=1) & _told_apart(at, apart), np.sum(rest**2, axis=1), np.inf)
        return columns, np.asarray(shares, float), np.asarray(rest, float), left

    slope, count = blocks.derivative(), places.shape[1]
    target = np.broadcast_to(target, (len(places), target.shape[-1]))
    tiny, damping = _tiny(target[0], count), np.full(len(places), 1e-2)
    places = places.copy()
    columns, shares, rest, cost = solved(places)
    for _ in range(steps):
        J = np.concatenate([columns, shares[..., None] * slope(places)], axis=1)
        normal = J @ J.mT
        diagonal = np.einsum("mii->mi", normal)
        diagonal += 1e-12 * diagonal.max(axis=1, keepdims=True)
        diagonal *= np.where(np.arange(2 * count) < count, 1.0 + 1e-12, 1.0 + damping[:, None])
        step = np.linalg.solve(normal, (J @ rest[..., None]))[:, count:, 0]
        tried = np.clip(places + np.clip(step, -0.5, 0.5), blocks.x[0], blocks.x[-1])
        found = solved(tried)
        better = found[-1] < cost
        for old, new in zip((places, columns, shares, rest, cost), (tried, *found), strict=True):
            old[better] = new[better]
        damping = np.where(better, damping / 5.0, damping * 5.0)
    return places, shares, cost


def _told_apart(places: Real, apart: float) -> Mask:
    """Return the sets of blocks (m, N) whose knots are all separable, over F_s [m/N]."""
    return np.asarray((np.diff(np.sort(np.exp(-places), axis=1), axis=1) >= apart).all(axis=1))


def _tiny(target: Real, count: int) -> Real:
    return 1e-12 * float(target @ target) * np.eye(count)


@dataclass(frozen=True)
class ReplayFit:
    """A model fitted by replay."""

    model: FrictionModel  # The model with the values found
    axis: str  # axis, motion: name and motion of the axis
    motion: Motion
    estimates: dict[str, dict[str, Estimate]]  # With 95 % intervals, by section of a friction file and name
    records: tuple[Prepared, ...]  # The records, and which of their samples were fitted
    level: Estimate  # Level of the records relative to a static map that was held, where it was fitted; else 1
    own: tuple[tuple[float, ...], ...]  # Terms of each record, in the order of its `Preparation.own`
    rmse: float  # Root of the mean squared residual [N]
    r2: float  # Share of the force's variance that is explained
    independent: float  # Number of independent residuals, by their first-order autocorrelation
    coordinates: Coordinates  # coordinates, x: the search coordinates that are free in the end, and their values
    x: Real
    spread: Real  # Covariance of ``x``, shape (p, p); nan where the records do not determine it
    covariance: Covariance  # Covariance of the fitted parameters
    late: Mapping[str, Estimate]  # Lag of force behind position [s], by record, see `lateness`
    warnings: tuple[Notice, ...] = ()  # Warnings: what the records do not determine
    between_records: Mapping[str, Estimate] = field(default_factory=dict)  # Deviation: level [1], offset [N], mass [kg]

    @property
    def own_estimates(self) -> list[dict[Own, Estimate]]:
        """Terms of each record, by name, with units."""
        return [
            {name: Estimate(value, si_unit(DIMENSIONS[name], self.motion)) for name, value in
             zip(record.done.own, values, strict=False)}
            for record, values in zip(self.records, self.own, strict=True)
        ]  # fmt: skip


@one_blas_thread()
def identify_by_replay(  # noqa: PLR0913 - the verb identify_model gives each setting
    name: str, records: Sequence[Prepared], *, static: Mapping[str, Estimate] | None = None,
    negative: StaticMap | None = None, blocks: int = 4, fix: Mapping[str, float] | None = None,
    free: Sequence[str] = (), seed: int = 0, start: FrictionModel | None = None, with_level: bool = False,
    beyond: Beyond | None = None,
) -> ReplayFit:  # fmt: skip
    """Fit a friction model to records by replay: a coarse global search (NLopt's CRS2), then least squares.

    The blocks of a GMS model are placed first if there is no start, and if they leave more than noise (`placed`). The
    terms of each record (`Preparation.own`) enter linearly and are projected out. After a first fit each sample is
    weighed by its spread (`fric.identify.replay.replay_search.spread`). The intervals are valid for residuals that are
    correlated in time (see `replay_covariance`), and include a lag between force and position. A parameter without
    effect on these records is found by its flat gradient, left at its typical value, and named in a warning.

    static: Static map to keep, for a model with a static map; by default it is fitted, too.
    negative: Map of the negative direction, if each direction has a map.
    fix: Values in SI of parameters that are not fitted.
    free: Names of parameters to fit that are held by default (`delta`).
    start: A model to start from; there is no coarse search then.
    with_level: Whether each record has a level of friction, which scales F_c and F_s of the kept static map.
    beyond: Increase of the covariance that the residuals do not show.
    """
    model = fitted_model(name)
    few = FricError("there are too few samples to compare", where=records[0].log.where, hint="Log for longer.")
    if not (records := [record.trimmed() for record in records if record.used.any()]):
        raise few
    if static is not None:  # a lag in sliding is seen beside a known map
        of_lag = [kind_of(r.log) == "sliding-sine" and not r.slides and not len(r.reversals) for r in records]
        records = [record.in_sliding() if lag else record for record, lag in zip(records, of_lag, strict=True)]
    held, by_default = _held(model, fix or {}, free, static)
    if not any(record.done.starts for record in records):  # what yields before sliding does so between samples
        step = max(float(np.median(np.abs(np.diff(r.motion.position))[r.used[1:]])) for r in records)
        rigid = max(float(np.ptp(record.force[record.used])) for record in records) / (YIELDS * step)
        found = [(s, p) for s, ps in model.declared().items() for p in ps if p.dimension == "stiffness"]
        held |= {(s, p.name): rigid for s, p in found if not p.per_block and p.name not in {*free, *(fix or {})}}
    ranges = replay_search.search_ranges(records)
    coordinates = Coordinates.of(model, ranges, blocks=blocks, held=held, level=with_level, negative=negative)
    if sum(int(r.used.sum()) for r in records) <= 2 * len(coordinates.free):
        raise few
    search = Search(coordinates, records)
    x = search.coarse(seed) if start is None else replay_search.coordinates_of(coordinates, start)
    in_blocks = model is GMS and blocks > 1
    x = placed(search, x).better(x) if in_blocks and start is None else x
    x = search.fine(x, replay_search.HOP) if in_blocks else search.fine(x)
    search, placement = search.weighed(x), None
    if in_blocks and not white(search.residual(x), [int(record.used.sum()) for record in records]):
        placement = placed(search, x)
        x = placement.better(x)
        search = search.weighed(x)
    x = search.fine(x)
    best = search.at(min([x, search.fine(usual_fall(search, x))], key=search.cost) if _moves(records) else x)
    search = aligned(search, best, _quantile(best, len(best.x)))
    if search.records is not records:
        records, best = search.records, search.at(search.fine(best.x))
    warnings: list[Notice] = []
    assumed: set[Key] = set()
    while flat := [
        c
        for c, seen in zip(search.coordinates.free, search.seen(best), strict=True)
        if c.block is None and not (seen and _falls(search, best, c))
    ]:
        c, p = flat[-1], flat[-1].parameter
        n = search.coordinates.free.index(c)
        value, left = float(np.max(p.typical)), ""
        low, high = np.exp([c.lower, c.upper]) if c.scale == "log" else (c.lower, c.upper)
        if p.at_least:
            value, left = float("nan"), f"that of {p.at_least}"
        elif not low <= value <= high:
            value = float(np.sqrt(low * high)) if c.scale == "log" else low
        there = np.where(np.arange(len(best.x)) == n, log(max(value, 1e-300)), best.x)
        if c.scale == "log" and search.cost(there) > WORSE * search.cost(best.x):
            value = float(np.exp(best.x[n]))  # a contact so stiff that it does not show is left so
        left = left or f"{value:.3g} {si_unit(p.dimension, records[0].log.motion)}"
        search = replace(search, coordinates=search.coordinates.without(n, value))
        best = search.at(search.fine(np.delete(best.x, n)))
        assumed.add(c.key)
        warnings.append(PARAMETER_UNSEEN.found(parameter=c.label, left=left))
    shapes = [of_shape(search, best, key, _quantile(best, len(best.x))) for key in by_default]
    fit = _described(search, best, placement, warnings, assumed, [by for by, _ in shapes], static, beyond)
    if shown := [key[1] for key, (_, other) in zip(by_default, shapes, strict=True) if other]:
        freed = identify_by_replay(
            name, records, static=static, negative=negative, blocks=blocks, fix=fix, free=[*free, *shown],
            start=fit.model, with_level=with_level, beyond=beyond,
        )  # fmt: skip
        better = 2.0 * fit.independent * log(fit.rmse / freed.rmse) > len(shown) * log(fit.independent)  # Schwarz
        spans = [np.asarray(each[n].ci95, float) for each in freed.estimates.values() for n in shown if n in each]
        places = [(at - c.lower) / (c.upper - c.lower) for c, at in zip(freed.coordinates.free, freed.x, strict=True)
                  if c.parameter.name in shown]  # fmt: skip
        inside = all(NEAR < place < 1.0 - NEAR for place in places)  # else another shape explains it
        if better and inside and all(span.shape == (2,) and span[1] < 4.0 * span[0] for span in spans):
            return freed
    return fit


def _falls(search: Search, best: Point, coordinate: Coordinate) -> bool:
    """Return whether a record reaches the velocity at which F_s has fallen to F_c, below which both are inseparable:
    one that is too slow for its starts and stops does not show where it fell.
    """
    if coordinate.parameter.name != "F_s" or not coordinate.parameter.at_least:
        return True
    if not any(record.done.starts for record in search.records):
        return False
    v_s = search.coordinates.values(best.x)["static"].get("v_s", 0.0)
    fastest = max(float(np.quantile(np.abs(record.motion.velocity[record.used]), 0.99)) for record in search.records)
    return not (isinstance(v_s, float) and v_s > fastest)


def record_notices(records: Sequence[Prepared], model: FrictionModel) -> list[Notice]:
    """Return the warnings about records that any fit by replay has, for any model."""
    cycled = [record for record in records if kind_of(record.log) in PRESLIDING]
    changes = chain.from_iterable(energy_changes(record, record.replay(model), record.used) for record in cycled)
    return [*too_coarse(records), *record_flaws([record.log for record in records], "gms"), *changes]


def fitted_models() -> dict[str, type[FrictionModel]]:
    """Return the friction models that can be fitted, by their names."""
    return {key: model for key, model in sorted(models().items()) if model.identified}


def fitted_model(name: str) -> type[FrictionModel]:
    """Return the friction model of a name; raise a `FricError` if there is none that can be fitted."""
    require_known(name, fitted_models(), "there is no friction model", "To fit there are")
    return fitted_models()[name]


def _held(
    model: type[FrictionModel], fix: Mapping[str, float], free: Sequence[str], static: Mapping[str, Estimate] | None
) -> tuple[dict[Key, float], list[Key]]:
    """Return the fixed values: given, of a static map that is kept, or held by default; and which are the last."""
    declared = {p.name: (section, p) for section, parameters in model.declared().items() for p in parameters}
    for name in (*fix, *free):
        require_known(name, declared, f"{model.name} has no parameter", "It has")
    held, by_default = dict[Key, float](), list[Key]()
    for name, (section, p) in declared.items():
        if name in fix:
            if p.per_block:
                raise FricError(f"{name} has a value for every block, and cannot be fixed")
            held[section, name] = fix[name]
        elif static is not None and section == "static" and name in static and name not in free:
            held[section, name] = float(static[name])
        elif p.held and name not in free:
            held[section, name] = float(np.max(p.typical))
            by_default.append((section, name))
    return held, by_default


def _described(
    search: Search, best: Point, placement: Placement | None, warnings: list[Notice], assumed: set[Key],
    wider: Sequence[Real], static: Mapping[str, Estimate] | None, beyond: Beyond | None,
) -> ReplayFit:  # fmt: skip
    coordinates, records = search.coordinates, tuple(search.records)
    motion, x, seen = records[0].log.motion, best.x, search.seen(best)
    covariance, levels, quantile = np.full((len(x), len(x)), np.nan), None, _quantile(best, len(x))
    if seen.any():
        basis = np.eye(len(x))[:, seen]
        levels = levels_of(search, best, best.gradient @ basis, quantile)
        alike = best if levels is None else replace(best, residual=levels.left)
        covariance[np.ix_(seen, seen)] = _covariance(search, alike, basis, quantile, beyond)
        covariance[np.ix_(seen, seen)] += sum(by[np.ix_(seen, seen)] for by in wider)
        covariance[np.ix_(seen, seen)] += 0.0 if levels is None else levels.gained
    if placement is not None and len(placement.places) and seen.all():
        free = [placement.search.coordinates.free.index(c) for c in coordinates.free]
        covariance += placement.unsettled(float(np.sqrt(np.mean(best.residual**2))))[np.ix_(free, free)]
    solved = Solved(coordinates, x, seen, covariance, quantile)
    within, notices = _opened(solved, records)
    blocks = solved.order()
    estimates: dict[str, dict[str, Estimate]] = {}
    scaled: dict[str, dict[str, Estimate]] = {}
    for section, parameters in coordinates.model.declared().items():
        estimates[section], scaled[section] = {}, {}
        for p in parameters:
            key, value, fitted = (section, p.name), solved.values[section][p.name], within.get((section, p.name))
            interval: Interval | tuple[Interval, ...] | None = fitted and fitted[0]
            if isinstance(value, tuple):
                value, interval = tuple(value[n] for n in blocks), fitted and tuple(fitted[n] for n in blocks)
            unit, undetermined = si_unit(p.dimension, motion), key in assumed
            found = Estimate(value, unit, interval, fixed=interval is None and not undetermined, assumed=undetermined)
            kept = static if section == "static" and static and fitted is None else {}
            estimates[section][p.name], scaled[section][p.name] = kept.get(p.name, found), found
    model = coordinates.on_guideway(coordinates.model.from_sections(scaled), solved.values)
    level = Estimate(1.0, "1")
    if (of_level := ("static", replay_search.LEVEL.name)) in within:
        level = Estimate(solved.values["static"][replay_search.LEVEL.name], "1", within[of_level][0])
    warnings += [*notices, *record_notices(records, model), *solved.edges()]
    residual = replace(search, weights=None).residual(x)
    force = np.concatenate([record.force[record.used] for record in records])
    parts = [(hidden, squares.mean()) for squares, hidden in (replay_search.unseen(r, model) for r in records)]
    less = [float(np.mean(2.0 * hidden > of)) for hidden, of in parts if hidden.mean() > 0.5 * of]
    left = [1.0 - float(r.used.mean()) for r in records if replay_search.few_a_swing(r) and not r.done.starts]
    if less or left:
        warnings.append(CHANGES_BETWEEN.found(share=max(less + left), less=not left))
    rmse = float(np.sqrt(np.mean(residual**2)))
    if (r2 := 1.0 - rmse**2 / float(np.var(force))) < 0.5:
        warnings.append(EXPLAINS_LITTLE.found(model=coordinates.model.name, share=max(r2, 0.0)))
    squares = max(float(residual @ residual), 1e-300)
    rho = min(max(float(residual[1:] @ residual[:-1]) / squares, 0.0), 0.999)
    independent = len(residual) * (1 - rho) / (1 + rho)
    nuisances = tuple(tuple(float(c) for c in r.record_part(r.force - r.replay(model))) for r in records)
    between = _scatter(records, nuisances, levels)
    if levels is not None and levels.chance < DIFFERENT:
        others = [f"the {name} by {readable(float(by), by.unit, 2)}" for name, by in between.items() if name != "level"]
        each = [f"{1.0 + item:.3f} of the friction" for item in levels.each]
        by = [f"friction by {levels.deviation:.1%}", *others]
        says = {"by": by, "order": each, "one_speed": False, "within": False, "motions": not levels.alike}
        apart = max(levels.deviation, 2.0 * float(between.get("offset", 0.0)) / float(np.ptp(force)))
        warnings.append(RECORDS_VARY.found(**says, scatter=apart))
    return ReplayFit(
        model, records[0].log.axis, motion, estimates, records, level, nuisances, rmse, r2, independent, coordinates, x,
        covariance, solved.joint(), lateness(search, best, quantile), tuple(warnings), between,
    )  # fmt: skip


def axis_in_motion(records: Sequence[Prepared]) -> RigidAxis | None:
    """Return M, F_v, F_c and offset of a rigid axis (4,) and their covariance (4, 4), from its motions.

    LuGre's model is replayed, so that friction which falls with speed, and yields before it slides, is in none of them.
    The mass and offset follow by least squares. Each record is replayed alone, for its level would move its mass; the
    mean over them is returned (`pooled`), of many over those of the greatest acceleration. None if half of them move
    one way, or do not show the mass or a parameter of the model.
    """
    shown = [float(np.std(record.motion.acceleration)) for record in records]
    records = [records[n] for n in sorted(np.argsort(shown)[-MOST_MOTIONS:])]
    told = [axis for record in records if (axis := _axis_alone(record)) is not None]
    return pooled(*map(np.array, zip(*told, strict=True))) if 2 * len(told) > len(records) else None


def _axis_alone(record: Prepared) -> tuple[Real, Real, bool] | None:
    """Return the rigid axis of one record, and whether its residual is of the model, not white."""
    if not _moves([record]) or "offset" not in record.done.own:
        return None
    few = record.thinned(-(-len(record.force) // MOST_IN_MOTION))
    fit = identify_by_replay("lugre", [few.restricted(between_reversals(few.motion))])
    shown = slopes(fit.coordinates, fit.x)
    if np.isnan(fit.spread).any() or not shown.keys() >= {("static", "sigma"), ("static", "F_c")}:
        return None
    moving = fit.records[0].in_motion()  # near rests the error of the model moves M
    late = Search(fit.coordinates, fit.records)
    c, variance = in_motion(late, late.at(fit.x), 1.96)
    moment = variance / (1.0 + variance) + (c / (1.0 + variance)) ** 2
    rates = Search(fit.coordinates, [replace(moving, done=replace(moving.done, own=()))]).gradient(fit.x)
    m, used = moving.motion, moving.used
    by = (moving.done.timing * np.gradient(moving.fitted(fit.model), m.time))[used]
    X = np.column_stack([m.acceleration, np.ones_like(m.time)])[used]
    y = (moving.force - moving.replay(fit.model))[used]
    found, by, *moves = np.linalg.lstsq(X, np.column_stack([y, by, rates]), rcond=None)[0].T
    off = y - X @ found
    error = replay_covariance(X, off, [moving], float(stdtrit(len(y) - 2, 0.975)))
    F_v, F_c = (float(fit.estimates["static"][name]) for name in ("sigma", "F_c"))
    of_M, of_offset = np.transpose(moves)
    J = np.array([of_M, shown["static", "sigma"].slope[0], F_c * shown["static", "F_c"].slope[0], of_offset])
    covariance = J @ fit.spread @ J.T
    covariance[::3, ::3] += error + moment * np.outer(by, by)
    if unlike := not white(off, [len(off)]):  # friction that lags is as mass where the axis speeds up, not as it brakes
        up = (m.velocity * m.acceleration)[used] > 0.0
        covariance[0, 0] += np.ptp([np.linalg.lstsq(X[part], y[part])[0][0] for part in (up, ~up)]) ** 2 / 4.0
    return np.array([found[0], F_v, F_c, found[1]]), covariance, unlike


def _scatter(records: Sequence[Prepared], own: Sequence[Sequence[float]], levels: Levels | None) -> dict[str, Estimate]:
    """Return the standard deviation of the differences between records, in level and fitted terms."""
    found = {} if levels is None or not levels.sure else {"level": Estimate(levels.deviation, "1")}
    for n, name in enumerate(records[0].done.own):
        values = [c[n] for c, record in zip(own, records, strict=True) if record.done.own[n:][:1] == (name,)]
        if len(values) == len(records) > 2 and name != "damping":
            found[name] = Estimate(float(np.std(values, ddof=1)), si_unit(DIMENSIONS[name], records[0].log.motion))
    return found


def _opened(solved: Solved, records: Sequence[Prepared]) -> tuple[dict[Key, tuple[Interval, ...]], list[Notice]]:
    """Return the 95 % intervals, open if the records set no upper limit, and the warnings about them.

    Where no branch slides, the largest force seen is only a lower bound of F_c and F_s, and v_s is not determined. A
    stiffness whose spring yields before the encoder shows motion after a reversal is a lower bound; records of a few
    encoder steps do not determine it.
    """
    seen, motion, notices, found = identifiability_of(records), records[0].log.motion, list[Notice](), solved.limits()
    of: dict[str, list[Key]] = {"force": [], "velocity": [], "stiffness": []}
    for key, slope in solved.slopes.items():
        of.setdefault(slope.parameter.dimension, []).append(key)
    if not seen.slides and of["force"]:
        for key in of["force"]:
            found[key] = tuple((seen.peak if len(found[key]) == 1 else low, np.inf) for low, _ in found[key])
        found |= {key: ((0.0, np.inf),) * len(found[key]) for key in of["velocity"]}  # how it falls once it slides
        peak, names = Estimate(seen.peak, si_unit("force", motion)), " and ".join(name for _, name in of["force"])
        notices.append(NEVER_SLIDES.found(force=peak, names=names, slope=seen.slope, amplitude=None, static=False))
    if len(too_coarse(records)) == len(records):
        return found | {key: ((0.0, np.inf),) * len(found[key]) for key in of["stiffness"]}, notices
    values = {name: np.asarray(value) for section in solved.values.values() for name, value in section.items()}
    for section, name in of["stiffness"]:
        limit = values.get("W", values.get("alpha", 1.0) * values.get("F_s", values.get("F_c", np.inf)))
        slips = np.atleast_1d(limit / values[name])
        if (slips < seen.resolved).any():
            both = zip(found[section, name], slips, strict=True)
            found[section, name] = tuple((low, np.inf if slip < seen.resolved else high) for (low, high), slip in both)
            slip, least = (Estimate(float(item), si_unit("position", motion)) for item in (slips.min(), seen.resolved))
            notices.append(STIFFNESS_UNRESOLVED.found(name=name, slip=slip, resolved=least))
    return found, notices


def _quantile(point: Point, count: int) -> float:
    """Return the half-width of a 95 % interval in standard deviations, where a number of parameters is fitted."""
    return float(stdtrit(max(len(point.residual) - count, 1), 0.975))


def _covariance(search: Search, point: Point, basis: Real, quantile: float, beyond: Beyond | None) -> Real:
    """Return the covariance of a solution in some directions (p, s): of residuals, of what is supposed, and beyond."""
    shown = point.gradient @ basis
    found = replay_covariance(shown, point.residual, search.records, quantile)
    found = found + of_supposed(search, point, shown, quantile)
    return found if beyond is None else np.asarray(found + beyond(search, point.x, basis))


def replay_information(
    records: Sequence[Prepared], model: GMS, ranges: Ranges, beyond: Beyond | None = None
) -> tuple[tuple[str, ...], Real]:
    """Return the information of records about alpha, k and C of a GMS model, with only its static map known.

    It is the inverse of the covariance of the fit at this model, in the directions that the records determine; the
    terms of each record (a level, offsets) are projected out. alpha enters by its logit (the last share follows from
    the others), k and C by their logarithms, as in a friction file's covariance.

    records: Records with the friction of this model, ready for replay.
    ranges: Ranges of the values that the records can show.
    beyond: Increase of the covariance that the residuals do not show. Returns the parameters, and a matrix (p, p).
    """
    held = {("static", name): float(getattr(model.static, name)) for name in STATIC_PARAMETERS}
    level = not all(record.slides for record in records)
    coordinates = Coordinates.of(GMS, ranges, blocks=len(model.alpha), held=held, level=level)
    search = Search(coordinates, [record.trimmed() for record in records])
    x = replay_search.coordinates_of(coordinates, model)
    search = search.weighed(x)
    here = search.at(x)
    S, V = np.linalg.svd(here.gradient, full_matrices=False)[1:]
    seen = BLIND * S[0] < S
    basis = np.eye(len(x)) if seen.all() else V[seen].T
    covariance = _covariance(search, here, basis, _quantile(here, len(basis.T)), beyond)
    information = basis @ np.linalg.inv(covariance) @ basis.T
    levels = [n for n, c in enumerate(coordinates.free) if c.parameter is replay_search.LEVEL]
    kept = [n for n in range(len(x)) if n not in levels]
    own, onto, back, of_levels = (information[np.ix_(a, b)] for a in (kept, levels) for b in (kept, levels))
    information = own - onto @ np.linalg.pinv(of_levels) @ back
    names, rows = [], []
    for (section, name), found in slopes(coordinates, x).items():
        if section != "static":
            count = len(found.slope) - (name == "alpha")
            names += [f"{name}_{n + 1}" if found.parameter.per_block else name for n in range(count)]
            rows += [found.slope[n, kept] for n in range(count)]
    back = np.linalg.inv(np.array(rows))
    return tuple(names), np.asarray(back.T @ information @ back)

"""Intervals of the parameters of a fit by replay, warnings about what the records do not determine, and lags.

A force that is logged τ late is ``F(t - τ)``, to first order ``F - τ·dF/dt``. After a reversal this rounds the corner
of the hysteresis cycle, which blocks of a model cannot do: so a model that can follow a virgin curve of any shape
separates the lag from stiffness. With another model its misfit would look like a lag.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations
from typing import NamedTuple

import numpy as np
from scipy.special import chdtrc, expit, stdtrit

from fric.arrays import Mask, Real
from fric.estimate import Covariance, Estimate, Scale
from fric.flaws.blocks import PARAMETER_AT_BOUND, PARAMETER_AT_EDGE, PARAMETER_UNSEEN
from fric.flaws.channel import FORCE_LATE, FORCE_LATE_OPEN
from fric.friction import FrictionModel, Parameter
from fric.friction.gms import GMS
from fric.identify.replay.replay_search import LEVEL, STEP, Coordinates, Point, Search
from fric.notice import Notice
from fric.records.judgement import CONDITION
from fric.records.prepared import Prepared
from fric.statistics import OF_TWO, hac_covariance, jackknife, sandwich, widened
from fric.units import readable, si_unit

SPANS_ALIKE = 1.5  # Ratio of the spans of two records up to which they count as the same motion
LAGS = 10  # Lags at which residuals are tested against white noise
Beyond = Callable[[Search, Real, Real], Real]
"""Increase of a covariance (s, s) that residuals do not show: of a search, its end (p,), and directions seen (p, s)."""


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
    back = np.linalg.inv(np.linalg.qr(gradient, mode="r"))
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
    resampled = [
        by(gradient, residual, np.concatenate([1000 * i + label for i, label in enumerate(labels)]))
        for by, labels in (
            (jackknife, [record.cycle[record.used] for record in records]),
            (sandwich, [record.phase[record.used] for record in records]),
        )
    ]
    return widened(covariance, *(array / quantile**2 for array in resampled))


class Levels(NamedTuple):
    """Variation of the level of friction between records."""

    deviation: float  # Standard deviation of the records' levels [1]
    each: Real  # Level of each record less the mean [1], shape (R,)
    chance: float  # Probability with which records of one level scatter so
    gained: Real  # What the covariance of the joint parameters gains by it, shape (s, s)


def levels_of(search: Search, best: Point, shown: Real, quantile: float) -> Levels | None:
    """Return the variation of the level of friction between records; None if they do not show it.

    Record r shows ``(1 + u_r)·F``. The contrasts of u are estimated beside all parameters, by one Gauss-Newton step,
    with the covariance V of `replay_covariance`; by moments ``τ² = (Σu² - tr V)/(R - 1)`` (Hedges 1983). The parameters
    gain ``H·τ²·Hᵀ``, H being how they move with each u, with Student's t of R - 1. Two records are only compared if
    they have the same motion: the error of a model along another motion would look like a level.

    shown: Derivatives of the residual by what is seen, shape (n, s).
    """
    records, model = search.records, search.coordinates.build(best.x)
    spans = [float(np.ptp(record.motion.position[record.used])) for record in records if not record.slides]
    count = len(spans)
    if count < 2 or (count == 2 and max(spans) > SPANS_ALIKE * min(spans)):
        return None
    member = np.eye(len(records))[:, [not record.slides for record in records]]
    replayed = [np.outer(record.replay(model), row) for record, row in zip(records, member, strict=True)]
    columns = search.projected(replayed)
    contrasts = np.linalg.qr(np.eye(count) - 1.0 / count)[0][:, : count - 1]
    X = np.column_stack([columns @ contrasts, shown])
    size = np.linalg.norm(X, axis=0)
    if np.linalg.cond(X / size) > CONDITION:
        return None
    found = np.linalg.lstsq(X, best.residual, rcond=None)[0]
    V = replay_covariance(X, best.residual - X @ found, records, quantile)[: count - 1, : count - 1]
    u = found[: count - 1]
    chance = float(chdtrc(count - 1, float(u @ np.linalg.solve(V, u))))
    variance = max(float(u @ u - np.trace(V)) / (count - 1), 0.0)
    if variance == 0.0 or chance > OF_TWO:
        return None
    H = np.linalg.lstsq(shown, columns, rcond=None)[0]
    wider = float(stdtrit(count - 1, 0.975)) / quantile
    return Levels(variance**0.5, contrasts @ u, chance, wider**2 * variance * H @ H.T)


class Slopes(NamedTuple):
    """Derivatives of a parameter (a value for each block) by the search coordinates, on the scale of its interval."""

    parameter: Parameter
    scale: Scale
    centre: Real
    slope: Real  # Derivatives over the coordinates, shape (blocks, p)


Key = tuple[str, str]  # Section and name of a parameter


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
                if name != LEVEL.name and not (np.abs(found.slope[n, ~self.seen]) > 1e-6).any():
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
        return limits

    def _within_search(self, key: Key, centre: Real, low: Real, high: Real) -> tuple[Real, Real]:
        """Return limits that are open beyond the search range, or if the value is at its edge.

        The records were not evaluated there. A parameter whose lower bound is another has no open lower limit.
        """
        of = [n for n, c in enumerate(self.coordinates.free) if (c.section, c.parameter.name) == key]
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
        (c.section, c.parameter.name): (c.parameter, {"linear": "linear", "share": "logit"}.get(c.scale, "log"))  # type: ignore[misc]
        for c in coordinates.free
    }

    def quantities(at: Real) -> dict[Key, Real]:
        values, found = coordinates.values(at), {}
        for (section, name), (_, scale) in scales.items():
            value = np.atleast_1d(np.asarray(values[section][name], float))
            logit = np.log1p(-value) if scale == "logit" else 0.0
            found[section, name] = value if scale == "linear" else np.log(value) - logit
        return found

    centre, steps = quantities(x), STEP * (coordinates.upper - coordinates.lower)
    moved = [quantities(x + step * unit) for step, unit in zip(steps, np.eye(len(x)), strict=True)]
    return {
        key: Slopes(*scales[key], at, (np.array([found[key] for found in moved]) - at).T / steps)
        for key, at in centre.items()
    }


SUSPECTED = 0.6  # Lag [samples] above which the lag is estimated again, with the force moved by it
CLEAR = 2.0  # Ratio of mean lag to half-width above which a lag is reported: hunting looks like a smaller lag
MOST_SAMPLES, MOST_SECONDS = 4.0, 10e-3
"""Largest lag of a log, in samples or by a filter [s]: friction without corners looks like a longer lag."""
BLOCKS = 3  # Number of blocks for a virgin curve of any shape


def lateness(search: Search, best: Point, quantile: float) -> dict[str, Estimate]:
    """Return the lag of the logged force behind the position [s], by record, for cycles only.

    It is one Gauss–Newton step from the solution, in the lag of each record and all parameters together, and its
    interval includes the error of the model that recurs in each cycle, and alignment of the channels to half a sample.
    """
    records, seen, cycled = search.records, search.seen(best), _cycled(search)
    if not cycled or not seen.any() or search.coordinates.model is not GMS:
        return {}
    rates = _rates(search.coordinates.build(best.x), records)
    late = [search.projected([rate * (n == number) for n, rate in enumerate(rates)]) for number in cycled]
    gradient = np.column_stack([*late, best.gradient[:, seen]])
    step = -np.linalg.lstsq(gradient, best.residual, rcond=None)[0]
    deviation = np.sqrt(np.diag(replay_covariance(gradient, best.residual, records, quantile)))[: len(cycled)]
    half = quantile * np.hypot(deviation, [records[n].done.timing for n in cycled])
    unit = si_unit("time", records[0].log.motion)
    return {
        records[n].name: Estimate.around(float(value), unit, float(width))
        for n, value, width in zip(cycled, step, half, strict=False)
    }


def suspected(records: Sequence[Prepared], late: Mapping[str, Estimate]) -> bool:
    """Return whether the lag of any record needs a second estimate."""
    intervals = _intervals(records)
    return any(abs(float(by)) > SUSPECTED * intervals[name] for name, by in late.items())


def credible(records: Sequence[Prepared], late: Mapping[str, Estimate]) -> bool:
    """Return whether the log of a drive may have the mean of lags [s]."""
    interval = max(_intervals(records)[name] for name in late)
    return abs(float(mean_lag(late.values()))) <= max(MOST_SAMPLES * interval, MOST_SECONDS)


def _intervals(records: Sequence[Prepared]) -> dict[str, float]:
    return {record.name: float(np.median(np.diff(record.motion.time))) for record in records}


def mean_lag(late: Iterable[Estimate]) -> Estimate:
    """Return the mean of lags [s], weighted by their intervals: a drive logs all records in the same way."""
    every = list(late)
    weights = np.array([estimate.half_width for estimate in every]) ** -2.0
    lags = np.array([float(estimate) for estimate in every])
    return Estimate.around(float(weights @ lags / weights.sum()), every[0].unit, float(weights.sum() ** -0.5))


def one_lag(late: Mapping[str, Estimate], clear: float) -> bool:
    """Return whether lags [s] agree within their intervals, and their mean exceeds a number of its half-widths.

    A difference between records is not a lag.
    """
    every = list(late.values())
    if not every:
        return False
    same = all(abs(float(a) - float(b)) <= np.hypot(a.half_width, b.half_width) for a, b in combinations(every, 2))
    return same and abs(float(mean := mean_lag(every))) > clear * mean.half_width


def lateness_notice(records: Sequence[Prepared], late: Mapping[str, Estimate], *, sure: bool) -> Notice:
    """Return the warning about the lag of the force of records, and whether its mean was corrected.

    sure: Whether the fit is better with it, and it is credible.
    """
    motion = records[0].log.motion
    dt = _intervals(records)
    parts = [
        f"'{name}' {readable(float(by), si_unit('time', motion), 2)} ± {readable(by.half_width, 's', 2)} "
        f"({float(by) / dt[name]:+.2g} samples)"
        for name, by in late.items()
    ]
    return (FORCE_LATE if sure else FORCE_LATE_OPEN).found(late=parts)


def of_timing(search: Search, best: Point, slopes: Real, quantile: float) -> Real:
    """Return the increase of the covariance (p, p) due to the alignment of force and position within a sample.

    The channels of a log are aligned to ±dt/2: all records are late by c standard deviations of that, c ~ N(0, 1), and
    parameters move by m·c, to first order. Where blocks separate a lag from stiffness, the records show c as ĉ ± s: its
    second moment about 0, the lag of the fit, is ``s²/(1 + s²) + (ĉ/(1 + s²))²`` by Bayes' rule; elsewhere it is 1.

    slopes: Derivatives of the residual by what is seen, shape (n, p).
    """
    records = search.records
    rates = _rates(search.coordinates.build(best.x), records)
    late = search.projected([record.done.timing * rate for record, rate in zip(records, rates, strict=True)])
    moved, moment = np.linalg.lstsq(slopes, late, rcond=None)[0], 1.0
    if _cycled(search) and late.any():
        joint = np.column_stack([late, slopes])
        found = -np.linalg.lstsq(joint, best.residual, rcond=None)[0][0]
        variance = replay_covariance(joint, best.residual, records, quantile)[0, 0]
        moment = variance / (1.0 + variance) + (found / (1.0 + variance)) ** 2
    return np.asarray(moment * np.outer(moved, moved))


def _cycled(search: Search) -> list[int]:
    """Return the records whose cycles separate a lag from stiffness; none for a model of too few blocks."""
    if search.coordinates.blocks < BLOCKS:
        return []
    return [n for n, record in enumerate(search.records) if not record.slides and len(record.reversals) > 4]


def _rates(model: FrictionModel, records: Sequence[Prepared]) -> list[Real]:
    """Return the rate of the replayed force [N/s], shape (n,), of each record."""
    return [np.gradient(record.replay(model), record.motion.time) for record in records]

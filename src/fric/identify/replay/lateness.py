"""Lag of the logged force behind the logged position, estimated by a replay; and its least uncertainty.

A force that is logged τ late is ``F(t - τ)``, to first order ``F - τ·dF/dt``. After a reversal this rounds the corner
of the hysteresis cycle, which blocks of a model cannot do: so a model that can follow a virgin curve of any shape
separates the lag from stiffness. With another model its misfit would look like a lag.
"""

from collections.abc import Iterable, Mapping, Sequence
from itertools import combinations

import numpy as np

from fric.arrays import Real
from fric.estimate import Estimate
from fric.flaws.channel import FORCE_LATE, FORCE_LATE_OPEN
from fric.friction import FrictionModel
from fric.identify.replay.replay_intervals import replay_covariance
from fric.identify.replay.replay_search import Point, Search
from fric.notice import Notice
from fric.records.prepared import Prepared
from fric.units import readable, si_unit

SUSPECTED = 0.6
"""Lag [samples] above which the lag is estimated again, with the force moved by it."""
CLEAR = 2.0
"""Ratio of mean lag to half-width above which a lag is reported: hunting between counts looks like a smaller lag."""
MOST_SAMPLES, MOST_SECONDS = 4.0, 10e-3
"""Largest lag of a log, in samples or by a filter [s]: friction without corners looks like a longer lag."""
BLOCKS = 3
"""Number of blocks for a virgin curve of any shape."""


def lateness(search: Search, best: Point, quantile: float) -> dict[str, Estimate]:
    """Return the lag of the logged force behind the position [s], by record, for cycles only.

    It is one Gauss–Newton step from the solution, in the lag of each record and all parameters together, and its
    interval includes the error of the model that recurs in each cycle, and alignment of the channels to half a sample.

    search, best: The search, and its solution.
    quantile: Half-widths in standard deviations.
    """
    records, seen, cycled = search.records, search.seen(best), _cycled(search)
    if not cycled or not seen.any():
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


def moved_back(records: Sequence[Prepared], late: Mapping[str, Estimate]) -> tuple[tuple[Prepared, ...], float]:
    """Return the records with given lags with the force moved back by their mean, and the others unchanged."""
    by = float(mean_lag(late.values()))
    return tuple(record.later(by) if record.name in late else record for record in records), by


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

    late: The lag of each [s].
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

    search, best: The search, and its solution.
    slopes: Derivatives of the residual by what is seen, shape (n, p).
    quantile: Half-widths in standard deviations.
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

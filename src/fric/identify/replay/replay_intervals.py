"""Intervals of the parameters of a fit by replay, and warnings about what the records do not determine."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from scipy.special import chdtrc, expit, stdtrit

from fric.arrays import Mask, Real
from fric.estimate import Covariance, Scale
from fric.flaws.blocks import PARAMETER_AT_BOUND, PARAMETER_AT_EDGE, PARAMETER_UNSEEN
from fric.friction import Parameter
from fric.identify.replay.coordinates import LEVEL, Coordinates
from fric.identify.replay.replay_search import STEP, Point, Search
from fric.notice import Notice
from fric.records.judgement import CONDITION
from fric.records.prepared import Prepared
from fric.statistics import OF_TWO, hac_covariance, jackknife, sandwich, widened

SPANS_ALIKE = 1.5
"""Ratio of the spans of two records up to which they count as the same motion."""
LAGS = 10
"""Lags at which residuals are tested against white noise."""
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

    gradient, residual: Derivatives (n, p) and residuals (n,) of all records one after the other.
    lengths: Samples of each record.
    most: As in `hac_covariance`.
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

    gradient, residual: As in `covariance_of`.
    quantile: Half-widths in standard deviations.
    most: As in `hac_covariance`.
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

    search, best: The search, and its solution.
    shown: Derivatives of the residual by what is seen, shape (n, s).
    quantile: Half widths are this many standard deviations.
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


def slopes(coordinates: Coordinates, x: Real) -> dict[tuple[str, str], Slopes]:
    """Return the `Slopes` of the fitted parameters, by section and name."""
    scales: dict[tuple[str, str], tuple[Parameter, Scale]] = {
        (c.section, c.parameter.name): (c.parameter, {"linear": "linear", "share": "logit"}.get(c.scale, "log"))  # type: ignore[misc]
        for c in coordinates.free
    }

    def quantities(at: Real) -> dict[tuple[str, str], Real]:
        found = {}
        for (section, name), (_, scale) in scales.items():
            value = np.atleast_1d(np.asarray(coordinates.values(at)[section][name], float))
            found[section, name] = (
                value if scale == "linear" else np.log(value) - (np.log1p(-value) if scale == "logit" else 0.0)
            )
        return found

    centre = quantities(x)
    steps = STEP * (coordinates.upper - coordinates.lower)
    moved = [quantities(x + step * unit) for step, unit in zip(steps, np.eye(len(x)), strict=True)]
    return {
        key: Slopes(
            *scales[key],
            centre[key],
            np.column_stack([(m[key] - centre[key]) / step for m, step in zip(moved, steps, strict=True)]),
        )
        for key in scales
    }


def joint(coordinates: Coordinates, x: Real, covariance: Real, seen: Mask, blocks: Sequence[int]) -> Covariance:
    """Return the covariance of the parameters that the records determine, blocks in the given order."""
    names: list[str] = []
    scales: list[Scale] = []
    rows: list[Real] = []
    for (_, name), found in slopes(coordinates, x).items():
        vector = found.parameter.per_block
        for number, n in enumerate(blocks if vector else [0], 1):
            if name != LEVEL.name and not (np.abs(found.slope[n, ~seen]) > 1e-6).any():
                names.append(f"{name}_{number}" if vector else name)
                scales.append(found.scale)
                rows.append(found.slope[n])
    slope = np.reshape(rows, (len(rows), len(x)))
    return Covariance.of(names, slope @ np.where(seen[:, None] & seen, covariance, 0.0) @ slope.T, scales)


def limits(
    coordinates: Coordinates, x: Real, covariance: Real, seen: Mask, quantile: float
) -> dict[tuple[str, str], tuple[tuple[float, float], ...]]:
    """Return the 95 % intervals of fitted parameters: symmetric in the logarithm, the logit of a share, or linearly."""
    known = np.where(seen[:, None] & seen, covariance, 0.0)
    limits = {}
    for key, (p, scale, centre, slope) in slopes(coordinates, x).items():
        error = quantile * np.sqrt(np.einsum("ij,jk,ik->i", slope, known, slope))
        error[(np.abs(slope[:, ~seen]) > 1e-6).any(axis=1)] = np.inf
        low, high = _within_search(coordinates, key, x, covariance, centre, centre - error, centre + error)
        if scale == "logit":
            low, high = expit(low), expit(high)
        elif scale == "log":
            with np.errstate(over="ignore"):
                low, high = np.exp(low), np.exp(high)
        low, high = np.maximum(low, p.lower), np.minimum(high, p.upper)
        limits[key] = tuple((float(a), float(b)) for a, b in zip(low, high, strict=True))
    return limits


def _within_search(
    coordinates: Coordinates, key: tuple[str, str], x: Real, covariance: Real, centre: Real, low: Real, high: Real
) -> tuple[Real, Real]:
    """Return limits that are open beyond the search range, or if the value is at its edge.

    The records were not evaluated there. A parameter whose lower bound is another parameter has no open lower limit.
    """
    of = [n for n, c in enumerate(coordinates.free) if (c.section, c.parameter.name) == key]
    scale, near = coordinates.free[of[0]].scale, _near(coordinates, covariance)[of]
    if scale not in {"log", "ratio"}:
        return low, high
    below, above = (x - coordinates.lower)[of], (coordinates.upper - x)[of]
    high = np.where((high - centre > above) | (above < near), np.inf, high)
    if scale == "ratio":
        return np.maximum(low, centre - below), high
    return np.where((centre - low > below) | (below < near), -np.inf, low), high


def _near(coordinates: Coordinates, covariance: Real) -> Real:
    """Return the distance at which each coordinate counts as at its bound: a tenth of its standard error."""
    error = np.sqrt(np.nan_to_num(np.diag(covariance)))
    return np.asarray(np.maximum(0.1 * error, 1e-6 * (coordinates.upper - coordinates.lower)))


def order(coordinates: Coordinates, values: Mapping[str, Mapping[str, float | tuple[float, ...]]]) -> list[int]:
    """Return the blocks in the order in which they slip: by their limit over their stiffness."""
    for section, parameters in coordinates.model.declared().items():
        blocks = {p.dimension: np.asarray(values[section][p.name]) for p in parameters if p.per_block}
        if "stiffness" in blocks and len(blocks) == 2:
            (limit,) = (value for dimension, value in blocks.items() if dimension != "stiffness")
            return [int(n) for n in np.argsort(limit / blocks["stiffness"], kind="stable")]
    return list(range(coordinates.blocks))


def edges(coordinates: Coordinates, x: Real, seen: Mask, covariance: Real) -> Iterator[Notice]:
    """Warn about parameters at the edge of their search range, and about undetermined blocks."""
    for c, at, is_seen, near in zip(coordinates.free, x, seen, _near(coordinates, covariance), strict=True):
        if not is_seen:
            yield PARAMETER_UNSEEN.found(parameter=c.label, left="")
        elif at - c.lower < min(near, 0.02) and c.scale == "ratio":
            yield PARAMETER_AT_BOUND.found(parameter=c.label, bound=str(c.parameter.at_least), no_effect=True)
        elif at - c.lower < near and c.scale == "linear" and c.lower == c.parameter.lower:
            yield PARAMETER_AT_BOUND.found(parameter=c.label, bound=f"{c.lower:g}", no_effect=False)
        elif c.scale == "share":
            continue
        elif min(at - c.lower, c.upper - at) < near:
            yield PARAMETER_AT_EDGE.found(parameter=c.label)

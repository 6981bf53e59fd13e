"""Any friction model fitted to any records by replaying its step along the measured motion."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import chain

import numpy as np
from scipy.special import stdtrit

from fric.arrays import Real
from fric.columns import PRESLIDING
from fric.errors import FricError, require_known
from fric.estimate import Covariance, Estimate, Interval
from fric.flaws.blocks import EXPLAINS_LITTLE, NEVER_SLIDES, PARAMETER_UNSEEN
from fric.flaws.channel import STIFFNESS_UNRESOLVED
from fric.flaws.drift import RECORDS_VARY
from fric.friction import FrictionModel, models
from fric.friction.gms import GMS
from fric.friction.stribeck import STATIC_PARAMETERS, StaticMap
from fric.identify.replay.placement import Placement, placed
from fric.identify.replay.replay_intervals import (
    Beyond,
    Key,
    Levels,
    Solved,
    lateness,
    levels_of,
    of_timing,
    replay_covariance,
    slopes,
    white,
)
from fric.identify.replay.replay_search import (
    HOP,
    LEVEL,
    Coordinate,
    Coordinates,
    Point,
    Ranges,
    Search,
    coordinates_of,
    search_ranges,
)
from fric.notice import Notice
from fric.records.flaws import record_flaws
from fric.records.judgement import energy_changes, identifiability_of, too_coarse
from fric.records.preparation import DIMENSIONS, Own
from fric.records.prepared import Prepared
from fric.records.recognition import kind_of
from fric.statistics import DIFFERENT
from fric.threads import one_blas_thread
from fric.units import Motion, readable, si_unit

YIELDS = 0.1  # Share of the travel of a sample within which a contact yields, of which the samples show no start


@dataclass(frozen=True)
class ReplayFit:
    """A model fitted by replay."""

    model: FrictionModel  # The model with the values found
    axis: str  # axis, motion: name and motion of the axis
    motion: Motion
    # Its parameters with their 95 % intervals, by section of a friction file and name
    estimates: dict[str, dict[str, Estimate]]
    records: tuple[Prepared, ...]  # The records, and which of their samples were fitted
    level: Estimate  # Level of the records relative to a static map that was held, where it was fitted; else 1
    own: tuple[tuple[float, ...], ...]  # Terms of each record, in the order of its `Preparation.own`
    rmse: float  # Root of the mean squared residual [N]
    r2: float  # Share of the force's variance that is explained
    independent: float  # Number of independent residuals, by their first-order autocorrelation
    coordinates: Coordinates  # coordinates, x: the search coordinates that are free in the end, and their values
    x: Real
    covariance: Covariance  # Covariance of the fitted parameters
    # Lag of the logged force behind the position [s], by record, see `lateness`
    late: Mapping[str, Estimate]
    warnings: tuple[Notice, ...] = ()  # Warnings: what the records do not determine
    # Standard deviation of the ``level`` [1], the ``offset`` [N] and the ``mass`` [kg] of records, where seen
    between_records: Mapping[str, Estimate] = field(default_factory=dict)

    @property
    def own_estimates(self) -> list[dict[Own, Estimate]]:
        """Terms of each record, by name, with units."""
        return [
            {name: Estimate(value, si_unit(DIMENSIONS[name], self.motion)) for name, value in
             zip(record.done.own, values, strict=True)}
            for record, values in zip(self.records, self.own, strict=True)
        ]  # fmt: skip


@one_blas_thread()
def identify_by_replay(  # noqa: PLR0913 - the verb identify_model gives each setting
    name: str,
    records: Sequence[Prepared],
    *,
    static: Mapping[str, Estimate] | None = None,
    negative: StaticMap | None = None,
    blocks: int = 4,
    fix: Mapping[str, float] | None = None,
    free: Sequence[str] = (),
    seed: int = 0,
    start: FrictionModel | None = None,
    with_level: bool = False,
    beyond: Beyond | None = None,
) -> ReplayFit:
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
    Raises FricError: When there is no such model, or no such parameter, or no sample to compare.
    """
    model = fitted_model(name)
    records = [record.trimmed() for record in records if record.used.any()]
    if static is not None:  # a lag in sliding is seen beside a known map
        of_lag = [kind_of(r.log) == "sliding-sine" and not r.slides and not len(r.reversals) for r in records]
        records = [record.in_sliding() if lag else record for record, lag in zip(records, of_lag, strict=True)]
    held = _held(model, fix or {}, free, static)
    if not any(record.done.starts for record in records):  # what yields before sliding does so between samples
        step = max(float(np.median(np.abs(np.diff(r.motion.position))[r.used[1:]])) for r in records)
        rigid = max(float(np.ptp(record.force[record.used])) for record in records) / (YIELDS * step)
        found = [(s, p) for s, ps in model.declared().items() for p in ps if p.dimension == "stiffness"]
        held |= {(s, p.name): rigid for s, p in found if not p.per_block and p.name not in {*free, *(fix or {})}}
    coordinates = Coordinates.of(
        model, search_ranges(records), blocks=blocks, held=held, level=with_level, negative=negative
    )
    if sum(int(r.used.sum()) for r in records) <= 2 * len(coordinates.free):
        raise FricError("there are too few samples to compare", where=records[0].log.where)
    search = Search(coordinates, records)
    x = search.coarse(seed) if start is None else coordinates_of(coordinates, start)
    in_blocks = model is GMS and blocks > 1
    x = placed(search, x).better(x) if in_blocks and start is None else x
    x = search.fine(x, HOP) if in_blocks else search.fine(x)
    search, placement = search.weighed(x), None
    if in_blocks and not white(search.residual(x), [int(record.used.sum()) for record in records]):
        placement = placed(search, x)
        x = placement.better(x)
        search = search.weighed(x)
    best = search.at(search.fine(x))
    warnings: list[Notice] = []
    assumed: set[tuple[str, str]] = set()
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
        left = left or f"{value:.3g} {si_unit(p.dimension, records[0].log.motion)}"
        search = replace(search, coordinates=search.coordinates.without(n, value))
        best = search.at(search.fine(np.delete(best.x, n)))
        assumed.add((c.section, p.name))
        warnings.append(PARAMETER_UNSEEN.found(parameter=c.label, left=left))
    return _described(search, best, placement, warnings, assumed, static, beyond)


def _falls(search: Search, best: Point, coordinate: Coordinate) -> bool:
    """Return whether a record reaches the velocity at which F_s has fallen to F_c; below it both are inseparable.

    A record that is too slow for its starts and stops does not show where it fell.
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


def fitted_model(name: str) -> type[FrictionModel]:
    """Return the friction model of a name; raise a `FricError` if there is none that can be fitted."""
    known = {key: model for key, model in sorted(models().items()) if model.identified}
    require_known(name, known, "there is no friction model", "To fit there are")
    return known[name]


def _held(
    model: type[FrictionModel], fix: Mapping[str, float], free: Sequence[str], static: Mapping[str, Estimate] | None
) -> dict[tuple[str, str], float]:
    """Return the fixed values: given, fixed by default, or of a static map that is kept."""
    declared = {p.name: (section, p) for section, parameters in model.declared().items() for p in parameters}
    for name in (*fix, *free):
        require_known(name, declared, f"{model.name} has no parameter", "It has")
    held: dict[tuple[str, str], float] = {}
    for name, (section, p) in declared.items():
        if name in fix:
            if p.per_block:
                raise FricError(f"{name} has a value for every block, and cannot be fixed")
            held[section, name] = fix[name]
        elif static is not None and section == "static" and name in static and name not in free:
            held[section, name] = float(static[name])
        elif p.held and name not in free:
            held[section, name] = float(np.max(p.typical))
    return held


def _described(
    search: Search,
    best: Point,
    placement: Placement | None,
    warnings: list[Notice],
    assumed: set[tuple[str, str]],
    static: Mapping[str, Estimate] | None,
    beyond: Beyond | None,
) -> ReplayFit:
    """Return the fit with intervals and warnings."""
    coordinates, records = search.coordinates, tuple(search.records)
    motion, x, seen = records[0].log.motion, best.x, search.seen(best)
    covariance, levels, quantile = np.full((len(x), len(x)), np.nan), None, _quantile(best, len(x))
    if seen.any():
        basis = np.eye(len(x))[:, seen]
        levels = levels_of(search, best, best.gradient @ basis, quantile)
        covariance[np.ix_(seen, seen)] = _covariance(search, best, basis, quantile, beyond)
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
    if (of_level := ("static", LEVEL.name)) in within:
        level = Estimate(solved.values["static"][LEVEL.name], "1", within[of_level][0])
    warnings += [*notices, *record_notices(records, model), *solved.edges()]
    residual = replace(search, weights=None).residual(x)
    force = np.concatenate([record.force[record.used] for record in records])
    rmse = float(np.sqrt(np.mean(residual**2)))
    r2 = 1.0 - rmse**2 / float(np.var(force))
    if r2 < 0.5:
        warnings.append(EXPLAINS_LITTLE.found(model=coordinates.model.name, share=max(r2, 0.0)))
    squares = max(float(residual @ residual), 1e-300)
    rho = min(max(float(residual[1:] @ residual[:-1]) / squares, 0.0), 0.999)
    independent = len(residual) * (1 - rho) / (1 + rho)
    own = tuple(tuple(float(c) for c in r.record_part(r.force - r.replay(model))) for r in records)
    between = _scatter(records, own, levels)
    if levels is not None and levels.chance < DIFFERENT:
        others = [f"the {name} by {readable(float(by), by.unit, 2)}" for name, by in between.items() if name != "level"]
        each = [f"{1.0 + item:.3f} of the friction" for item in levels.each]
        by = [f"friction by {levels.deviation:.1%}", *others]
        warnings.append(RECORDS_VARY.found(by=by, order=each, one_speed=False, within=False))
    return ReplayFit(
        model, records[0].log.axis, motion, estimates, records, level, own, rmse, r2, independent, coordinates, x,
        solved.joint(), lateness(search, best, quantile), tuple(warnings), between,
    )  # fmt: skip


def _scatter(
    records: Sequence[Prepared], variance: Sequence[Sequence[float]], levels: Levels | None
) -> dict[str, Estimate]:
    """Return the standard deviation of the differences between records, in level and fitted terms."""
    found = {} if levels is None else {"level": Estimate(levels.deviation, "1")}
    for n, name in enumerate(records[0].done.own):
        values = [one[n] for one, record in zip(variance, records, strict=True) if record.done.own[n:][:1] == (name,)]
        if len(values) == len(records) > 2 and name != "damping":
            unit = si_unit(DIMENSIONS[name], records[0].log.motion)
            found[name] = Estimate(float(np.std(values, ddof=1)), unit)
    return found


def _opened(
    solved: Solved, records: Sequence[Prepared]
) -> tuple[dict[Key, tuple[tuple[float, float], ...]], list[Notice]]:
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
            found[section, name] = tuple(
                (low, np.inf if slip < seen.resolved else high)
                for (low, high), slip in zip(found[section, name], slips, strict=True)
            )
            slip, least = (Estimate(float(item), si_unit("position", motion)) for item in (slips.min(), seen.resolved))
            notices.append(STIFFNESS_UNRESOLVED.found(name=name, slip=slip, resolved=least))
    return found, notices


def _quantile(point: Point, count: int) -> float:
    """Return the half-width of a 95 % interval in standard deviations, where a number of parameters is fitted."""
    return float(stdtrit(max(len(point.residual) - count, 1), 0.975))


def _covariance(search: Search, point: Point, basis: Real, quantile: float, beyond: Beyond | None) -> Real:
    """Return the covariance of a solution in some directions (p, s): of residuals, of timing, and beyond both."""
    shown = point.gradient @ basis
    found = replay_covariance(shown, point.residual, search.records, quantile)
    found = found + of_timing(search, point, shown, quantile)
    return found if beyond is None else np.asarray(found + beyond(search, point.x, basis))


BLIND = 1e-6  # Share of the largest effect of a direction below which records do not determine a direction


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
    x = coordinates_of(coordinates, model)
    search = search.weighed(x)
    here = search.at(x)
    S, V = np.linalg.svd(here.gradient, full_matrices=False)[1:]
    seen = BLIND * S[0] < S
    basis = np.eye(len(x)) if seen.all() else V[seen].T
    covariance = _covariance(search, here, basis, _quantile(here, len(basis.T)), beyond)
    information = basis @ np.linalg.inv(covariance) @ basis.T
    levels = [n for n, c in enumerate(coordinates.free) if c.parameter is LEVEL]
    kept = [n for n in range(len(x)) if n not in levels]
    information = (
        information[np.ix_(kept, kept)]
        - information[np.ix_(kept, levels)]
        @ np.linalg.pinv(information[np.ix_(levels, levels)])
        @ information[np.ix_(levels, kept)]
    )
    names, rows = [], []
    for (section, name), found in slopes(coordinates, x).items():
        if section != "static":
            count = len(found.slope) - (name == "alpha")
            names += [f"{name}_{n + 1}" if found.parameter.per_block else name for n in range(count)]
            rows += [found.slope[n, kept] for n in range(count)]
    back = np.linalg.inv(np.array(rows))
    return tuple(names), np.asarray(back.T @ information @ back)

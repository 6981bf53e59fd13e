"""Identification of the GMS model (Section 3.2.1): from pre-sliding records to alpha, k and C."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from itertools import chain
from typing import Any

import numpy as np
from scipy.special import expit, logit, stdtrit

from fric.arrays import Mask, Real
from fric.columns import PRESLIDING
from fric.drive.plant import Plant
from fric.errors import FricError
from fric.estimate import Covariance, Estimate
from fric.flaws import blocks as flaws
from fric.flaws.channel import FIRST_BLOCK_UNRESOLVED
from fric.flaws.drift import FRICTION_DIFFERS, RECORDS_VARY, REST_RAISES_FRICTION
from fric.flaws.files import RECORD_LEFT_OUT
from fric.friction import FrictionModel
from fric.friction.directed import directed, mean_map
from fric.friction.gms import GMS
from fric.friction.stribeck import StaticMap
from fric.identify.gms import virgin_curve
from fric.identify.gms.hunting import PLACES, Hunting
from fric.identify.replay import replay_fit
from fric.log import Log
from fric.notice import Notice
from fric.plausibility import settled
from fric.process import one_blas_thread
from fric.records.flaws import record_flaws, without_kicked
from fric.records.inspection import RESOLVED, cycle_energies, energy_changes, energy_per_cycle
from fric.records.prepared import Prepared, of_shares, prepared
from fric.records.recognition import kind_of
from fric.records.resolution import without_clipped
from fric.search import simplest
from fric.statistics import rms
from fric.units import Motion, si_unit

ASSUMED_C = 1e4  # Attraction parameter [N/s] without a record in sliding: a lag s/C of 10 to 16 ms for Table 1
ASSUMED_RATE = 100.0  # The same over F_c [1/s], for forces in A, % or N·m, of which 1e4 would be another lag
UNDETERMINED = float(np.log(10.0))  # Half width of log C's interval beyond which C is not determined: a factor of 10
INERTIA = 0.1  # Share of inertia in the force above which a sine is too fast
HOLLOW = 0.02  # Share of F_s by which a virgin curve is below a concave curve, beyond its error, that gives a warning
LEVEL = 0.03  # Deviation of Σ alpha from 1 that gives a warning
OTHER = 1.3  # Ratio of pre-sliding friction to that of the map from which they are of two machines, or units


@dataclass(frozen=True)
class Replay:
    """One record, measured against replayed."""

    record: Prepared  # The record as it was prepared; its ``used`` are the samples that the fit used
    replayed: Real  # The model's force along the motion, with the terms of the record [N], shape (n,)
    held_out: Mask  # Samples after the chosen cycles, which the fit did not see, shape (n,)
    own: Real  # Coefficients of the terms of the record, in the order of `Preparation.own`, shape (m,)

    @property
    def name(self) -> str:
        """Name of the record."""
        return self.record.log.name

    @property
    def kind(self) -> str:
        """``presliding`` or ``sliding``."""
        return "sliding" if self.record.slides else "presliding"

    @property
    def energy(self) -> Estimate | None:
        """Energy lost per cycle [J], over all whole cycles from the first one in the fit; None in sliding."""
        if self.record.slides:
            return None
        reversals = self.record.reversals[self.record.reversals >= int(np.argmax(self.record.used))]
        energies = cycle_energies(self.record.motion.position, self.record.force, reversals)
        return energy_per_cycle(energies, self.record.log.motion)

    @property
    def rmse(self) -> float:
        """Residual over the samples used [N]."""
        return rms((self.record.force - self.replayed)[self.record.used])

    @property
    def rmse_held_out(self) -> float | None:
        """Residual over held-out samples [N]; None without any."""
        return rms((self.record.force - self.replayed)[self.held_out]) if self.held_out.any() else None


@dataclass(frozen=True)
class GMSFit:
    """An identified GMS model, and the records that it was identified from."""

    axis: str  # axis, motion: the axis
    motion: Motion
    static: StaticMap  # The static map whose F_s is the unit of alpha; F_c = F_s at the plateau where none was given
    static_given: bool  # False where the plateau replaces a static map
    alpha: Estimate  # alpha, k, C: the parameters, one value a block in the order of slip displacements
    k: Estimate
    C: Estimate
    alpha_sum: Estimate  # Σ alpha before it was normalised: the level of the records relative to the static map
    curve: virgin_curve.VirginCurve  # The measured virgin curve
    hysteresis: tuple[virgin_curve.HysteresisCycles, ...]  # The records that it is from
    blocks: virgin_curve.Blocks  # Its piecewise-linear fit
    choice: virgin_curve.Choice | None  # How the number of blocks was chosen; None where the user gave it
    asked: int | None  # Number of blocks that the user requested; None where the criterion chose it
    knots_given: bool  # knots_given, refined: true where the user gave the knots; where the parameters are from replay
    refined: bool
    records: tuple[Replay, ...]  # Each record, measured against replayed
    covariance: Covariance | None  # Covariance of the parameters; None where they were not refined by replay
    between_records: Mapping[str, Estimate]  # Deviation of ``level`` [1], ``offset`` [N] of records, where seen
    warnings: tuple[Notice, ...]  # Warnings: what the data do not determine

    @property
    def model(self) -> GMS:
        """The model for output: alpha sums to 1, and F_s is that of the static map."""
        assert isinstance(self.alpha.value, tuple)
        assert isinstance(self.k.value, tuple)
        return GMS(self.static, self.alpha.value, self.k.value, float(self.C))

    @property
    def rmse(self) -> float:
        """Residual over all samples used [N]."""
        rest = [(replay.record.force - replay.replayed)[replay.record.used] for replay in self.records]
        return rms(np.concatenate(rest))

    @property
    def curve_rmse(self) -> float:
        """Misfit of the model to the measured virgin curve, over equal steps of displacement [N]."""
        z = np.linspace(0.0, float(self.curve.displacement[-1]), 501)[1:]
        level = float(self.alpha_sum) if self.static_given else 1.0
        found = virgin_curve.Blocks(np.asarray(self.k.value), self.model.slip_displacements * level)
        return float(np.sqrt(np.mean((self.curve(z) - found(z)) ** 2)))

    @property
    def reason(self) -> str:
        """Reason for the number of blocks, in a sentence."""
        count = len(self.blocks)
        if self.choice is not None:
            return self.choice.reason
        if self.asked in {None, count}:
            return f"{count} blocks, as the user said"
        return f"{count} blocks: of the {self.asked} that were asked for, the others would have no stiffness"

    @property
    def method(self) -> str:
        """Method of identification, in a line."""
        given = self.knots_given and not self.choice
        start = "eq. (6) at given knots" if given else "concave piecewise-linear virgin curve"
        refined = ", refined by replay of all records" if self.refined else ""
        return f"{start}{refined}; intervals by leaving out cycles, and by the repeatable misfit"


Fit = Callable[[Sequence[Prepared]], tuple[GMSFit, Mapping[str, Estimate]]]  # A fit to records, and their forces' lags


@one_blas_thread()
def identify_gms(  # noqa: PLR0913 - the verb of its name gives each setting
    logs: Sequence[Log], *, static: StaticMap | None = None, negative: StaticMap | None = None,
    plant: Plant | None = None, blocks: int | None = None, most_blocks: int = virgin_curve.MOST_BLOCKS,
    knots: Sequence[float] | None = None, refined: bool = True, cycles: tuple[int, int] | None = None,
    places: int = PLACES, on_time: bool = False,
) -> GMSFit:  # fmt: skip
    """Identify alpha, k and C of the GMS model.

    The knots of the virgin curve of pre-sliding records give the blocks by eq. (6), and a replay of the GMS step along
    the measured motion refines them. C is fitted where a ``sliding-sine`` record is among the logs.

    The arguments are those of `fric.identify_gms`, in SI; ``negative`` is the static map of the negative direction,
    where each direction has a map; ``places`` are those of `Hunting`; of a force that is ``on_time``, as a simulated
    force is, no lag is estimated. Without a log of kind ``presliding-sine`` or ``micro-steps``, those of kind
    ``motion`` or of no kind are used.

    Raises FricError: When no record has whole cycles, an amplitude is under three encoder steps, a channel was not
        logged, or the knots do not suit the curve.
    """
    presliding, sliding = sorted_by_kind(logs)
    for log in presliding:
        log.require("position", "the virgin curve")
    for given_map in filter(None, (static, negative)):
        replay_fit.break_away(given_map)
    presliding, kicked = without_kicked(presliding)
    presliding, left_out = without_clipped(presliding, 0.0)
    given = prepared([*presliding, *sliding], plant)
    slow, unsuited = _suited(given[: len(presliding)], partial(virgin_curve.find_cycles, cycles=cycles))
    slow, unsuited = (slow, unsuited) if slow else ([*given[: len(presliding)]], [])
    slides, reversing = _suited(given[len(presliding) :], Prepared.in_sliding)
    ready, unsuited = [*slow, *slides], [*unsuited, *reversing]
    doubtful = settled(of_shares(ready))
    identified = partial(
        _identified, static=static, negative=negative, blocks=blocks, most_blocks=most_blocks, knots=knots,
        refined=refined, cycles=cycles, hunting=Hunting(plant, places),
    )  # fmt: skip
    try:
        result, lateness = (identified(ready)[0], []) if on_time else _on_time(ready, identified)
    except FricError as error:
        if (without := _without_one(ready, identified)) is None:
            raise
        result, lateness, unsuitable = without
        unsuited.append(RECORD_LEFT_OUT.found(unsuitable.log.where, why=error.what))
    found = notices_of(result, sliding_logged=bool(slides), plant_given=plant is not None)
    warnings, amiss = (*result.warnings, *lateness, *found), record_flaws([*presliding, *sliding], "gms", plant)
    return replace(result, warnings=(*warnings, *amiss, *doubtful, *left_out, *kicked, *unsuited))


def _suited(records: Sequence[Prepared], judge: Callable[[Prepared], object]) -> tuple[list[Prepared], list[Notice]]:
    """Return the records that a judge accepts, and the warnings about those for which it raises a `FricError`."""
    kept, left_out = [], []
    for record in records:
        try:
            judge(record)
            kept.append(record)
        except FricError as error:
            left_out.append(RECORD_LEFT_OUT.found(record.log.where, why=error.what))
    return kept, left_out


def _is_slow(record: Prepared) -> bool:
    return record.log.kind != "sliding-sine"


def _without_one(records: Sequence[Prepared], identified: Fit) -> tuple[GMSFit, list[Notice], Prepared] | None:
    """Return the result without one of at least three pre-sliding records, and that record; else None."""
    slow = [*filter(_is_slow, records)]
    for record in slow if len(slow) > 2 else ():
        with suppress(FricError):
            return *_on_time([other for other in records if other is not record], identified), record
    return None


def _on_time(ready: Sequence[Prepared], identified: Fit) -> tuple[GMSFit, list[Notice]]:
    """Return the fit, with the common lag of the force corrected if that is better, and the warnings.

    A lag is one step from a fit (`lateness`), and is estimated again with the force moved by the first estimate: a step
    from records that are 3.5 samples late finds 2.4 of them, and a second step 3.6.
    """
    fit, late = identified(ready)
    if not replay_fit.suspected(ready, late):
        return fit, []
    for _ in range(2):
        by = float(replay_fit.mean_lag(late.values()))
        again, left = identified([record.later(by) if record.log.name in late else record for record in ready])
        late = {name: Estimate.around(by + float(lag), lag.unit, lag.half_width) for name, lag in left.items()}
        if not replay_fit.one_lag(ready, late, 1.0):
            break
    if not replay_fit.one_lag(ready, late, replay_fit.CLEAR):
        return fit, []
    sure = simplest([fit.rmse, again.rmse]) == 1 and replay_fit.credible(ready, late)
    return again if sure else fit, [replay_fit.lateness_notice(ready, late, sure=sure)]


def _identified(  # noqa: PLR0913 - the settings of identify_gms, and the lag
    ready: Sequence[Prepared], *, static: StaticMap | None, negative: StaticMap | None, blocks: int | None,
    most_blocks: int, knots: Sequence[float] | None, refined: bool, cycles: tuple[int, int] | None, hunting: Hunting,
) -> tuple[GMSFit, Mapping[str, Estimate]]:  # fmt: skip
    """Return the fit to prepared records, of which the first are in pre-sliding, and the lags of their forces."""
    count = sum(map(_is_slow, ready))
    hysteresis = [virgin_curve.find_cycles(record, cycles) for record in ready[:count]]
    curve = virgin_curve.virgin_curve(hysteresis, static, negative)
    between = mean_map(static, negative) if static is not None else None
    if between is not None and not curve.saturates:
        curve = replace(curve, level=between.F_s)
    log, motion = ready[0].log, ready[0].log.motion
    choice, found, without = _blocks(curve, blocks, most_blocks, knots, refined, si_unit("force", motion))
    base = between or StaticMap(found.limit.sum(), found.limit.sum(), 1e-3)
    slides = [record.in_sliding() for record in ready[count:]] if static is not None else []
    records = [*(cycle.for_replay() for cycle in hysteresis), *slides]
    begin = _lag_of(slides, _at_level(base, found, curve.saturates), negative)

    model: FrictionModel
    fit: replay_fit.ReplayFit | None = None
    if refined:
        given = static or base, negative
        fit = _refined(records, given, begin, hunting, with_level=curve.saturates, with_C=bool(slides))
        alpha, k, C = (fit.estimates["gms"][name] for name in ("alpha", "k", "C"))
        level, model = fit.level, fit.model
        if C.fixed:
            C = replace(C, fixed=False, assumed=True)
    else:
        alpha, k, level = _by_leaving_out(found, without, base, motion)
        C = Estimate(assumed_C(static or base, motion), si_unit("force rate", motion), assumed=True)
        level = level if curve.saturates else Estimate(1.0, "1")
        model = directed(_at_level(static or base, found, curve.saturates), negative)
    if static is None:
        base, by = replace(base, F_c=base.F_c * float(level), F_s=base.F_s * float(level)), float(level)
        limits = None if level.ci95 is None else (float(level.ci95[0]) / by, float(level.ci95[1]) / by)  # type: ignore[arg-type]
        level = Estimate(1.0, level.unit, limits)
    replays = [_replayed(record, model, cycles) for record in records]
    limit = np.asarray(alpha.value) * base.F_s * (float(level) if static is not None else 1.0)
    blocks_found = virgin_curve.Blocks(np.asarray(k.value), limit / np.asarray(k.value))
    curve = virgin_curve.with_all_errors(curve, blocks_found(curve.displacement))
    result = GMSFit(
        log.axis, motion, base, static is not None, alpha, k, C, level, curve, tuple(hysteresis), found, choice,
        blocks, knots is not None, refined, tuple(replays), fit.covariance if fit else None,
        fit.between_records if fit else {},
        tuple(notice for notice in fit.warnings if notice.code == RECORDS_VARY.code) if fit else (),
    )  # fmt: skip
    return result, fit.late if fit else {}


def sorted_by_kind(logs: Sequence[Log]) -> tuple[list[Log], list[Log]]:
    """Return the pre-sliding records and those in sliding; a kind that is recognised counts as stated."""
    kinds = [(log, kind_of(log)) for log in logs]
    if not (presliding := [log for log, kind in kinds if kind in PRESLIDING]):
        presliding = [log for log, kind in kinds if kind == "motion" or (log.kind is None and kind != "sliding-sine")]
    if not presliding:
        hint = "Log slow sines of small amplitude, or micro-steps, and ingest them with `kind='presliding-sine'`."
        raise FricError("there is no pre-sliding record among the logs", hint=hint)
    return presliding, [replace(log, kind=kind) for log, kind in kinds if kind == "sliding-sine"]


def assumed_C(static: StaticMap, motion: Motion) -> float:
    """Return the attraction parameter that is assumed [N/s], of one digit where the force is not in newtons."""
    return ASSUMED_C if motion == "linear" else float(f"{ASSUMED_RATE * static.F_c:.0e}")


def _at_level(static: StaticMap, blocks: virgin_curve.Blocks, with_level: bool) -> GMS:
    """Return the model of some blocks on a static map, scaled to their level where they slide."""
    level = float(blocks.limit.sum()) / static.F_s if with_level else 1.0
    alpha = blocks.limit / blocks.limit.sum()
    k = alpha * static.F_s * level / blocks.displacement
    return GMS(replace(static, F_c=static.F_c * level, F_s=static.F_s * level), tuple(alpha), tuple(k), ASSUMED_C)


def _lag_of(slides: Sequence[Prepared], model: GMS, negative: StaticMap | None) -> GMS:
    """Return a model with the best C of a grid in sliding: with a damping the misfit has two minima."""
    if not slides:
        return model

    def left(tried: GMS) -> float:
        rest = [record.force - record.fitted(directed(tried, negative)) for record in slides]
        return sum(float(np.sum(r[record.used] ** 2)) for r, record in zip(rest, slides, strict=True))

    return min((replace(model, C=float(rate)) for rate in np.geomspace(1.0, 1e4, 17) * model.static.F_s), key=left)


def _refined(
    records: Sequence[Prepared], maps: tuple[StaticMap, StaticMap | None], start: GMS, hunting: Hunting, *,
    with_level: bool, with_C: bool,
) -> replay_fit.ReplayFit:  # fmt: skip
    """Return the fit by replay from the blocks of the virgin curve; C is assumed where no record determines it."""
    given = {p.name: Estimate(getattr(maps[0], p.name), "") for p in StaticMap.parameters}
    start = replace(start, static=replace(start.static, F_s=start.static.F_s / mean_map(*maps).F_s * maps[0].F_s))

    def fitted(**fix: float) -> replay_fit.ReplayFit:
        return replay_fit.identify_by_replay(
            "gms", records, static=given, negative=maps[1], blocks=len(start.alpha), start=start, fix=fix,
            with_level=with_level, beyond=hunting,
        )  # fmt: skip

    C = assumed_C(maps[0], records[0].log.motion)
    fit = fitted() if with_C else fitted(C=C)
    low, high = fit.estimates["gms"]["C"].ci95 or (0.0, 0.0)
    bounded = bool(low and high and np.log(np.divide(high, low)) < 2.0 * UNDETERMINED)
    if with_C and not (bounded and _of_one(float(fit.level))):
        fit = fitted(C=C)
    return fit


def _of_one(level: float) -> bool:
    """Return whether pre-sliding friction is that of the map, as far as machines change within a day."""
    return 1.0 / OTHER < level < OTHER


def _blocks(
    curve: virgin_curve.VirginCurve, count: int | None, most: int, knots: Sequence[float] | None, refit: bool, unit: str
) -> tuple[virgin_curve.Choice | None, virgin_curve.Blocks, list[virgin_curve.Blocks]]:
    """Return the choice of the number of blocks, the blocks, and, for `_by_leaving_out`, those without each cycle."""
    if knots is not None:
        at = np.asarray(knots, float)
        if at[-1] > curve.displacement[-1]:
            what = f"the last knot is beyond the virgin curve, which ends at {curve.displacement[-1] * 1e6:.3g} µm"
            raise FricError(what, hint="Choose knots within it, or add a record of larger amplitude.")
        found = virgin_curve.blocks_from_knots(at, curve(at))
        without = []
        for other in curve.without_cycles():
            try:
                without.append(virgin_curve.blocks_from_knots(at, other(at)))
            except FricError:  # without this cycle the curve is not concave at the knots
                without.append(found)
        return None, found, without
    choice = virgin_curve.choose_blocks(curve, most, unit=unit) if count is None else None
    found = choice.blocks if choice else virgin_curve.fit_blocks(curve, count or 1)
    return choice, found, [] if refit else virgin_curve.fit_without_cycles(curve, found)


def _by_leaving_out(
    found: virgin_curve.Blocks, without: Sequence[virgin_curve.Blocks], static: StaticMap, motion: Motion
) -> tuple[Estimate, Estimate, Estimate]:
    """Return alpha, k and the level of the virgin curve's blocks, with intervals from the curve without each cycle."""

    def quantities(blocks: virgin_curve.Blocks) -> Real:
        share = np.clip(blocks.limit / blocks.limit.sum(), 1e-15, 1.0 - 1e-15)  # a single block has alpha = 1
        return np.concatenate([logit(share), np.log(blocks.k), [np.log(blocks.limit.sum() / static.F_s)]])

    if not found.limit.sum() > 0.0:
        raise FricError("no block holds a force", hint="Is it the right column?")
    without = [blocks for blocks in without if blocks.limit.sum() > 0.0]
    value, n = quantities(found), len(found)
    intervals: Any = (None, None, None)
    if (count := len(without)) > 1:
        moved = np.array([quantities(blocks) for blocks in without])
        moved = moved - moved.mean(axis=0)
        half = stdtrit(count - 1, 0.975) * np.sqrt((count - 1) / count * np.sum(moved**2, axis=0))
        low, high = value - half, value + half
        pairs = np.exp([low, high]).T.tolist()
        shares = expit([low, high]).T.tolist()
        intervals = tuple(map(tuple, shares[:n])), tuple(map(tuple, pairs[n : 2 * n])), tuple(pairs[-1])
    share = tuple(float(item) for item in found.limit / found.limit.sum())
    k = Estimate(tuple(float(item) for item in found.k), si_unit("stiffness", motion), intervals[1])
    level = Estimate(float(found.limit.sum() / static.F_s), "1", intervals[2])
    return Estimate(share, "1", intervals[0]), k, level


def _replayed(record: Prepared, model: FrictionModel, cycles: tuple[int, int] | None) -> Replay:
    held_out = np.zeros(len(record.force), dtype=bool)
    if cycles is not None and not record.slides:
        held_out[np.flatnonzero(record.used)[-1] + 1 :] = True
    replayed = record.replay(model)
    values = record.record_part(record.force - replayed)
    return Replay(record, replayed + record.own @ values, held_out, values)


def notices_of(fit: GMSFit, *, sliding_logged: bool, plant_given: bool) -> Iterator[Notice]:
    """Yield the warnings of a fit."""
    metre, newton, F_s = si_unit("position", fit.motion), si_unit("force", fit.motion), fit.static.F_s
    if not fit.static_given:
        yield flaws.NO_STATIC_MAP.found(F_s=Estimate(F_s, newton))
    yield from _saturation(fit, metre, newton)
    if fit.asked not in {None, len(fit.blocks)}:
        yield flaws.FEWER_BLOCKS.found(why=fit.reason)
    step = max(cycle.record.motion.step for cycle in fit.hysteresis)
    if (first := float(fit.model.slip_displacements[0])) < RESOLVED * step:
        yield FIRST_BLOCK_UNRESOLVED.found(slip=Estimate(first, metre), step=Estimate(step, metre))
    shares = {cycle.record.log.name: cycle.record.done.inertia_share or 0.0 for cycle in fit.hysteresis}
    fast = {name: share for name, share in shares.items() if share > INERTIA}
    for name, share in fast.items():
        yield flaws.SINE_TOO_FAST.found(f"record '{name}'", share=share, slower=float(np.sqrt(share / INERTIA)))
    if loaded := [cycle.record.log.name for cycle in fit.hysteresis if cycle.loaded]:
        yield flaws.BEGINS_LOADED.found(records=loaded)
    if fit.C.assumed:
        reasons = {
            "pre-sliding records do not determine it": not sliding_logged,
            "no static map is given": not fit.static_given,
            "the fit was not refined by replay": not fit.refined,
            "the sines show another level of friction than the strokes": not _of_one(float(fit.alpha_sum)),
            "the sliding record leaves it open by more than a factor of ten (is the plant that of the log?)": True,
        }
        why = next(reason for reason, applies in reasons.items() if applies)
        C = Estimate(float(fit.C), si_unit("force rate", fit.motion))
        yield flaws.C_ASSUMED.found(C=C, why=why, logged=sliding_logged)
    elif not plant_given:
        yield flaws.C_WITHOUT_PLANT.found()
    if fit.curve.saturates and abs(float(fit.alpha_sum) - 1.0) > LEVEL:
        flaw = flaws.LEVEL_DIFFERS if _of_one(float(fit.alpha_sum)) else flaws.LEVEL_OF_ANOTHER
        yield flaw.found(level=float(fit.alpha_sum))
    if abs(fit.curve.mismatch) > LEVEL * F_s + fit.curve.mismatch_half:
        flaw = REST_RAISES_FRICTION if fit.curve.mismatch > 0 else FRICTION_DIFFERS
        yield flaw.found(by=Estimate(abs(fit.curve.mismatch), newton))
    where, hollow = fit.curve.hollow
    # inertia makes it hollow too, and so does the joint of two records that differ
    if hollow > max(HOLLOW * F_s, abs(fit.curve.mismatch)) and not fast:
        sizes = {"slip": Estimate(where, metre), "hollow": Estimate(hollow, newton)}
        yield flaws.LOST_MOTION.found(**sizes, share=hollow / F_s)
    if len(fit.curve.cycles) < 2:
        yield flaws.ONE_CYCLE.found()
    cycled = [r for r in fit.records if r.kind == "presliding"]
    yield from chain.from_iterable(energy_changes(r.record, r.replayed, r.record.used | r.held_out) for r in cycled)


def _saturation(fit: GMSFit, metre: str, newton: str) -> Iterator[Notice]:
    if fit.curve.saturates:
        return
    extent, end = float(fit.curve.displacement[-1]), float(fit.curve.force[-1])
    force = Estimate(end, newton)
    if not fit.static_given:
        amplitude = Estimate(3.0 * extent, metre)
        yield flaws.NEVER_SLIDES.found(force=force, names="F_s", slope=0.0, amplitude=amplitude, static=True)
        return
    amplitude = Estimate(max(1.5 * float(fit.model.slip_displacements[-1]), 2.0 * extent), metre)
    missing = Estimate(max(fit.static.F_s - end, 0.0), newton)
    found = {"extent": Estimate(extent, metre), "force": force, "missing": missing}
    yield flaws.NEVER_SATURATES.found(**found, amplitude=amplitude)

"""Warnings about what pre-sliding data do not determine."""

from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise, permutations
from typing import Any

import numpy as np

from fric.arrays import Indices, Real
from fric.estimate import Estimate
from fric.flaws import blocks
from fric.flaws import drift as flaws
from fric.flaws.channel import FIRST_BLOCK_UNRESOLVED
from fric.flaws.drift import FRICTION_DIFFERS, REST_RAISES_FRICTION
from fric.identify.gms.fit import GMSFit, Replay
from fric.identify.gms.knots import Blocks
from fric.notice import Notice
from fric.records.judgement import RESOLVED, cycle_energies, drift, energy_warnings
from fric.units import si_unit

INERTIA = 0.1
"""Share of inertia in the force above which a sine is too fast."""

INSEPARABLE = 0.01
"""Two blocks are not separable when a single block in their place changes the curve by less than this share of F_s."""

HOLLOW = 0.02
"""Share of F_s by which a virgin curve is below a concave curve, beyond its error, that gives a warning."""

LEVEL = 0.03
"""Deviation of Σ alpha from 1 that gives a warning."""


def notices_of(fit: GMSFit, *, sliding_logged: bool, plant_given: bool) -> Iterator[Notice]:
    """Yield the warnings of a fit.

    fit: The fit.
    sliding_logged: Whether a record in sliding was among the logs.
    plant_given: Whether inertia and damping were subtracted.
    """
    metre, newton, F_s = si_unit("position", fit.motion), si_unit("force", fit.motion), fit.static.F_s
    if not fit.static_given:
        yield blocks.NO_STATIC_MAP.found(F_s=Estimate(F_s, newton))
    yield from _saturation(fit, metre, newton)
    if fit.asked not in {None, len(fit.blocks)}:
        yield blocks.FEWER_BLOCKS.found(why=fit.reason)
    step = max(cycle.motion.step for cycle in fit.hysteresis)
    slips = [Estimate(float(slip), metre) for slip in fit.model.slip_displacements]
    if float(slips[0]) < RESOLVED * step:
        yield FIRST_BLOCK_UNRESOLVED.found(slip=slips[0], step=Estimate(step, metre))
    for n, gap in enumerate(pair_gaps(fit.blocks)):
        if gap < INSEPARABLE * F_s and len(slips) == len(fit.blocks):
            found = {"n": n + 1, "m": n + 2, "slip": slips[n], "next": slips[n + 1]}
            yield blocks.BLOCKS_INSEPARABLE.found(**found, gap=Estimate(float(gap), newton))
    shares = {cycle.name: cycle.record.done.inertia_share or 0.0 for cycle in fit.hysteresis}
    fast = {name: share for name, share in shares.items() if share > INERTIA}
    for name, share in fast.items():
        yield blocks.SINE_TOO_FAST.found(f"record '{name}'", share=share, slower=float(np.sqrt(share / INERTIA)))
    if loaded := [cycle.name for cycle in fit.hysteresis if cycle.loaded]:
        yield blocks.BEGINS_LOADED.found(records=loaded)
    if fit.C.assumed:
        why = (
            "pre-sliding records do not determine it"
            if not sliding_logged
            else "no static map is given"
            if not fit.static_given
            else "the fit was not refined by replay"
            if not fit.refined
            else "the sliding record does not determine it to a factor of ten (is the plant that of the log?)"
        )
        C = Estimate(float(fit.C), si_unit("force rate", fit.motion))
        yield blocks.C_ASSUMED.found(C=C, why=why, logged=sliding_logged)
    elif not plant_given:
        yield blocks.C_WITHOUT_PLANT.found()
    if fit.curve.saturates and abs(float(fit.alpha_sum) - 1.0) > LEVEL:
        yield blocks.LEVEL_DIFFERS.found(level=float(fit.alpha_sum))
    if abs(fit.curve.mismatch) > max(LEVEL * F_s, 0.0):
        flaw = REST_RAISES_FRICTION if fit.curve.mismatch > 0 else FRICTION_DIFFERS
        yield flaw.found(by=Estimate(abs(fit.curve.mismatch), newton))
    where, hollow = fit.curve.hollow
    if hollow > HOLLOW * F_s and not fast:  # inertia makes it hollow too
        yield blocks.LOST_MOTION.found(slip=Estimate(where, metre), hollow=Estimate(hollow, newton))
    if len(fit.curve.cycles) < 2:
        yield blocks.ONE_CYCLE.found()
    yield from changes(fit)


def _saturation(fit: GMSFit, metre: str, newton: str) -> Iterator[Notice]:
    if fit.curve.saturates:
        return
    extent, end = float(fit.curve.displacement[-1]), float(fit.curve.force[-1])
    force = Estimate(end, newton)
    if not fit.static_given:
        amplitude = Estimate(3.0 * extent, metre)
        yield blocks.NEVER_SLIDES.found(force=force, names="F_s", slope=0.0, amplitude=amplitude, static=True)
        return
    amplitude = Estimate(max(1.5 * float(fit.model.slip_displacements[-1]), 2.0 * extent), metre)
    missing = Estimate(max(fit.static.F_s - end, 0.0), newton)
    found = {"extent": Estimate(extent, metre), "force": force, "missing": missing}
    yield blocks.NEVER_SATURATES.found(**found, amplitude=amplitude)


def pair_gaps(pairs: Blocks) -> Real:
    """Return the largest change of the virgin curve when two neighbours are merged [N], shape (N - 1,).

    The merged block has their total stiffness and limit; the greatest change is where it slips.
    """
    k, limit = pairs.k, pairs.limit
    merged = (limit[:-1] + limit[1:]) / (k[:-1] + k[1:])
    both = np.minimum(k[:-1] * merged, limit[:-1]) + np.minimum(k[1:] * merged, limit[1:])
    return np.asarray(limit[:-1] + limit[1:] - both)


CHANGES = 0.03
"""Share of F_s by which friction or offset must change to give a warning."""

PIECES = 30
"""Segments of a record in which its misfit is evaluated."""

STANDS_OFF = 3.0
"""Ratio to the usual misfit above which the misfit of a segment is an outlier."""


def changes(fit: GMSFit) -> Iterator[Notice]:
    """Yield what changed while the records of a fit were logged."""
    newton, F_s = si_unit("force", fit.motion), fit.static.F_s
    presliding = [record for record in fit.records if record.kind == "presliding"]
    offsets, levels = dict[str, float](), []
    for replay in presliding:
        offset, level = _over_cycles(replay)
        if not len(level):
            continue
        offsets[replay.name] = float(offset.mean())
        levels.append(float(level.mean()))
        where = f"record '{replay.name}'"
        if (change := _drifts(level, CHANGES)) is not None:
            yield flaws.FRICTION_DRIFTS.found(where, change=change)
        if (change := _drifts(offset, CHANGES * F_s)) is not None:
            yield flaws.OFFSET_DRIFTS.found(where, change=Estimate(change, newton))
        if (segment := segment_of_misfit(replay)) is not None:
            begin, end, there, elsewhere = segment
            rms = {"there": Estimate(there, newton), "elsewhere": Estimate(elsewhere, newton)}
            yield flaws.MISFIT_IN_ONE_STRETCH.found(where, begin=begin, end=end, **rms)
        else:  # a cycle and a half hardly raise the misfit, but clearly the energies, as `inspect` shows
            reversals = _seen_reversals(replay)
            notices = energy_warnings(
                cycle_energies(replay.position, replay.measured, reversals), replay.time[reversals[::2]]
            )
            yield from (notice.at(where) for notice in notices if notice.code == flaws.ENERGY_IN_ONE_SEGMENT.code)
    if differing := _beyond_load(fit, offsets):
        by, (least, first), (most, second) = differing
        values = {"least": Estimate(least, newton), "first": first, "most": Estimate(most, newton), "second": second}
        yield flaws.OFFSET_DIFFERS.found(by=Estimate(by, newton), **values)
    if len(levels) > 1 and np.ptp(levels) > CHANGES:
        yield flaws.LEVEL_BETWEEN_RECORDS.found(by=float(np.ptp(levels)), **_between(presliding, levels))


def _beyond_load(
    fit: GMSFit, offsets: Mapping[str, float]
) -> tuple[float, tuple[float, str], tuple[float, str]] | None:
    """Return the difference of the offsets of two records [N], and both, where their loads do not explain it.

    Blocks that do not slip along a cycle of amplitude a keep the load that they had where the record begins: up to
    ``V(inf) - V(a)`` on the virgin curve V, which shows as an offset. Where the end of the curve is unknown, it may be
    any.
    """
    if len(offsets) < 2 or not (fit.static_given or fit.curve.saturates):
        return None
    ends = max(float(fit.curve.force[-1]), fit.static.F_s)
    load = {cycle.name: max(ends - float(fit.curve(cycle.amplitude)), 0.0) for cycle in fit.hysteresis}
    pairs = [
        (offsets[b] - offsets[a] - load.get(a, 0.0) - load.get(b, 0.0), a, b)
        for a, b in permutations(offsets, 2) if offsets[b] > offsets[a]
    ]  # fmt: skip
    beyond, a, b = max(pairs, default=(0.0, "", ""))
    return (
        (offsets[b] - offsets[a], (offsets[a], a), (offsets[b], b))
        if beyond > CHANGES * fit.static.F_s + 2.0 * fit.rmse
        else None
    )


def _between(records: Sequence[Replay], values: Sequence[Any]) -> dict[str, Any]:
    """Return the least and the most of values, and the records that have them."""
    pairs = list(zip(values, (record.name for record in records), strict=False))
    (least, first), (most, second) = (pick(pairs, key=lambda pair: float(pair[0])) for pick in (min, max))
    return {"least": least, "first": first, "most": most, "second": second}


def _over_cycles(replay: Replay) -> tuple[Real, Real]:
    """Return the offset [N] and the friction relative to the model's, of each whole cycle."""
    reversals = _seen_reversals(replay)
    ends = reversals[::2]
    measured, modelled = (
        cycle_energies(replay.position, force, reversals) for force in (replay.measured, replay.replayed)
    )
    rest = replay.measured - replay.replayed + replay.own[0]
    offset = [float(np.mean(rest[a:b])) for a, b in pairwise(ends)]
    return np.array(offset), np.asarray(measured / modelled)


def _seen_reversals(replay: Replay) -> Indices:
    """Return the reversals among what a replay fits or holds out."""
    reversals, seen = replay.record.reversals, replay.used | replay.held_out
    return np.asarray(reversals[seen[np.minimum(reversals, len(seen) - 1)]])


def _drifts(values: Real, least: float) -> float | None:
    """Return the change of values from the first cycle to the last, where it is sure and more than the least."""
    if len(values) < 4:
        return None
    change, half = drift(values)
    return change if abs(change) > max(half, least) else None


def segment_of_misfit(replay: Replay) -> tuple[float, float, float, float] | None:
    """Return begin and end [s] of the segment that a replay's misfit sits in, its rms there and elsewhere [N].

    None where the misfit is spread over the record. Segments are compared with the lower quartile of all.
    """
    seen = np.flatnonzero(replay.used | replay.held_out)
    if len(seen) < 10 * PIECES:
        return None
    pieces = np.array_split(seen, PIECES)
    rest = replay.measured - replay.replayed
    rms = np.sqrt([float(np.mean(rest[piece] ** 2)) for piece in pieces])
    off = np.flatnonzero(rms > STANDS_OFF * float(np.quantile(rms, 0.25)))
    if not len(off) or len(off) < 0.7 * (off[-1] - off[0] + 1) or len(off) == PIECES:
        return None
    inside = np.zeros(PIECES, bool)
    inside[off[0] : off[-1] + 1] = True
    there, elsewhere = (float(np.sqrt(np.mean(rms[part] ** 2))) for part in (inside, ~inside))
    return float(replay.time[pieces[off[0]][0]]), float(replay.time[pieces[off[-1]][-1]]), there, elsewhere

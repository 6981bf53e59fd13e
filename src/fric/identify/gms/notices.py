"""Warnings about parameters that pre-sliding data do not determine."""

from collections.abc import Iterator

import numpy as np

from fric.arrays import Real
from fric.estimate import Estimate
from fric.flaws import blocks
from fric.flaws.channel import FIRST_BLOCK_UNRESOLVED
from fric.flaws.drift import FRICTION_DIFFERS, REST_RAISES_FRICTION
from fric.identify.gms.fit import GMSFit
from fric.identify.gms.knots import Blocks
from fric.notice import Notice
from fric.records.judgement import RESOLVED, cycle_energies, energy_warnings
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
    if abs(fit.curve.mismatch) > LEVEL * F_s + fit.curve.mismatch_half:
        flaw = REST_RAISES_FRICTION if fit.curve.mismatch > 0 else FRICTION_DIFFERS
        yield flaw.found(by=Estimate(abs(fit.curve.mismatch), newton))
    where, hollow = fit.curve.hollow
    if hollow > HOLLOW * F_s and not fast:  # inertia makes it hollow too
        sizes = {"slip": Estimate(where, metre), "hollow": Estimate(hollow, newton)}
        yield blocks.LOST_MOTION.found(**sizes, share=hollow / F_s)
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


def changes(fit: GMSFit) -> Iterator[Notice]:
    """Yield the warnings about changes during a record, by the ratio of its cycles' energy to the model's."""
    for replay in fit.records:
        if replay.kind == "presliding":
            reversals, seen = replay.record.reversals, replay.used | replay.held_out
            reversals = reversals[seen[np.minimum(reversals, len(seen) - 1)]]
            measured, modelled = (
                cycle_energies(replay.position, force, reversals) for force in (replay.measured, replay.replayed)
            )
            usual = float(np.sum(modelled)) / max(len(modelled), 1)
            for notice in energy_warnings(measured / modelled * usual, replay.time[reversals[::2]]):
                yield notice.at(f"record '{replay.name}'")

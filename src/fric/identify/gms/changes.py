"""What changed while the records were logged: friction and offset, over a record and between records, and misfit."""

from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from fric.arrays import Indices, Real
from fric.estimate import Estimate
from fric.flaws import drift as flaws
from fric.identify.gms.fit import GMSFit
from fric.identify.replay.measured import Replay
from fric.notice import Notice
from fric.records.energy import cycle_energies, drift, energy_warnings
from fric.units import si_unit

CHANGES = 0.03
"""Share of F_s by which friction or offset must change to be told."""

PIECES = 30
"""Pieces of a record in which its misfit is looked at."""

STANDS_OFF = 3.0
"""Times the usual misfit from which on that of a piece stands off."""


def changes(fit: GMSFit) -> Iterator[Notice]:
    """Yield what changed while the records of a fit were logged."""
    newton, F_s = si_unit("force", fit.motion), fit.static.F_s
    presliding = [one for one in fit.records if one.kind == "presliding"]
    offsets, levels = [], []
    for one in presliding:
        offset, level = _over_cycles(one)
        if not len(level):
            continue
        offsets.append(float(offset.mean()))
        levels.append(float(level.mean()))
        where = f"record '{one.name}'"
        if (change := _drifts(level, CHANGES)) is not None:
            yield flaws.FRICTION_DRIFTS.found(where, change=change)
        if (change := _drifts(offset, CHANGES * F_s)) is not None:
            yield flaws.OFFSET_DRIFTS.found(where, change=Estimate(change, newton))
        if (segment := segment_of_misfit(one)) is not None:
            begin, end, there, elsewhere = segment
            rms = {"there": Estimate(there, newton), "elsewhere": Estimate(elsewhere, newton)}
            yield flaws.MISFIT_IN_ONE_STRETCH.found(where, begin=begin, end=end, **rms)
        else:  # a cycle and a half hardly stand out of the misfit, but do of the energies, as `inspect` tells
            reversals = _seen_reversals(one)
            notices = energy_warnings(cycle_energies(one.position, one.measured, reversals), one.time[reversals[::2]])
            yield from (notice.at(where) for notice in notices if notice.code == flaws.ENERGY_IN_ONE_SEGMENT.code)
    if len(offsets) > 1 and np.ptp(offsets) > CHANGES * F_s:
        found = [Estimate(offset, newton) for offset in offsets]
        yield flaws.OFFSET_DIFFERS.found(by=Estimate(float(np.ptp(offsets)), newton), **_between(presliding, found))
    if len(levels) > 1 and np.ptp(levels) > CHANGES:
        yield flaws.LEVEL_BETWEEN_RECORDS.found(by=float(np.ptp(levels)), **_between(presliding, levels))


def _between(records: Sequence[Replay], values: Sequence[Any]) -> dict[str, Any]:
    """Return the least and the most of values, and the records that have them."""
    pairs = list(zip(values, (one.name for one in records), strict=False))
    (least, first), (most, second) = (pick(pairs, key=lambda pair: float(pair[0])) for pick in (min, max))
    return {"least": least, "first": first, "most": most, "second": second}


def _over_cycles(one: Replay) -> tuple[Real, Real]:
    """Return the offset [N] and the friction relative to the model's, of each whole cycle."""
    reversals = _seen_reversals(one)
    ends = reversals[::2]
    measured, modelled = (cycle_energies(one.position, force, reversals) for force in (one.measured, one.replayed))
    rest = one.measured - one.replayed + one.own[0]
    offset = [float(np.mean(rest[a:b])) for a, b in pairwise(ends)]
    return np.array(offset), np.asarray(measured / modelled)


def _seen_reversals(one: Replay) -> Indices:
    """Return the reversals among what a replay fits or holds out."""
    reversals, seen = one.record.reversals, one.used | one.held_out
    return np.asarray(reversals[seen[np.minimum(reversals, len(seen) - 1)]])


def _drifts(values: Real, least: float) -> float | None:
    """Return by how much values go from the first cycle to the last, where that is sure and more than the least."""
    if len(values) < 4:
        return None
    change, half = drift(values)
    return change if abs(change) > max(half, least) else None


def segment_of_misfit(one: Replay) -> tuple[float, float, float, float] | None:
    """Return begin and end [s] of the segment that a replay's misfit sits in, its rms there and elsewhere [N].

    None where the misfit is spread over the record. Pieces stand off the lower quartile of all.
    """
    seen = np.flatnonzero(one.used | one.held_out)
    if len(seen) < 10 * PIECES:
        return None
    pieces = np.array_split(seen, PIECES)
    rest = one.measured - one.replayed
    rms = np.sqrt([float(np.mean(rest[piece] ** 2)) for piece in pieces])
    off = np.flatnonzero(rms > STANDS_OFF * float(np.quantile(rms, 0.25)))
    if not len(off) or len(off) < 0.7 * (off[-1] - off[0] + 1) or len(off) == PIECES:
        return None
    inside = np.zeros(PIECES, bool)
    inside[off[0] : off[-1] + 1] = True
    there, elsewhere = (float(np.sqrt(np.mean(rms[part] ** 2))) for part in (inside, ~inside))
    return float(one.time[pieces[off[0]][0]]), float(one.time[pieces[off[-1]][-1]]), there, elsewhere

"""Holding maps: the force that holds an axis at places, forwards and backwards, with a row for each place."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.special import stdtrit

from fric.arrays import Real
from fric.estimate import Estimate
from fric.flaws.channel import HOLDING_MAP
from fric.log import Log
from fric.notice import Notice
from fric.records.motion import find_reversals
from fric.records.resolution import lattice_step
from fric.statistics import hac_covariance

PLACES = 8  # Least number of places in a pass
MOST_ROWS = 20_000  # Largest number of rows of a map
SAME = 0.1  # Largest difference of places between both passes, as a share of their distance
COUNTS = 5.0  # Encoder counts between neighbouring places below which all motions reach the same places
SMOOTH = 0.4  # Correlation of ways and times, and of neighbouring speeds, from which on they are of a motion
UNEVEN = 0.5  # Least range of the intervals of an event-driven clock (10 % to 90 %), over their median


@dataclass(frozen=True)
class HoldingMap:
    """Friction and load from holding forces, ``F = load(z) ± level(z)`` by the direction of approach."""

    #: Half the difference of there and back, the mean over places: friction at rest, of Coulomb's to the static [N]
    level: Estimate
    load: Estimate  #: Half their sum, the mean over places: gravity, an offset [N]
    varies: float  #: Standard deviation of the load over places: cogging, a cable [N]
    points: int  #: Rows
    length: float  #: Over which places reach [m]


def passes_of(position: Real) -> list[slice]:
    """Return the passes of a list of places, each in one direction."""
    step = float(np.median(np.abs(np.diff(position))))
    edges = [0, *find_reversals(position, threshold=0.5 * step), len(position) - 1]
    return [slice(a, b + 1) for a, b in pairwise(map(int, edges))]


def is_holding_map(log: Log) -> bool:
    """Return whether a record without an even clock reaches places forwards and backwards that were chosen.

    They are the same both ways, which a sampled motion does not reach unless its encoder is very coarse; or they lie as
    far apart as they like, however long that took, as no motion does.
    """
    z, force = log.position, log.force
    if z is None or force is None or not 2 * PLACES <= len(z) <= MOST_ROWS:
        return False
    steps = np.diff(log.time)
    low, usual, high = np.quantile(steps, [0.1, 0.5, 0.9])
    rows = bool(np.all(steps == 1.0))  # counted, for want of a time
    step = float(np.median(np.abs(np.diff(z))))
    if not (rows or high - low > UNEVEN * usual) or step <= 0.0:
        return False
    count = lattice_step(z) or 0.0
    if step < COUNTS * count and not np.allclose(np.abs(np.diff(z))[np.diff(z) != 0.0], count, rtol=1e-6):
        return False
    if len(passes := passes_of(z)) < 2 or min(part.stop - part.start for part in passes) < PLACES:
        return False
    there = np.sort(z[passes[0]])
    back = np.concatenate([z[part] for part in passes[1::2]])
    back = back[(back > there[0] - 0.5 * step) & (back < there[-1] + 0.5 * step)]
    n = np.clip(np.searchsorted(there, back), 1, len(there) - 1)
    off = np.minimum(np.abs(back - there[n - 1]), np.abs(back - there[n]))
    same = len(back) >= PLACES and float(np.quantile(off, 0.9)) < SAME * step
    return same or (not rows and len(back) >= PLACES and _at_will(steps, np.diff(z), passes))


def _at_will(steps: Real, moved: Real, passes: list[slice]) -> bool:
    """Return whether the way to each next place says nothing about its time, nor the speed about the next speed."""
    inside = (moved != 0.0) & (steps > 0.0)
    inside[[part.stop - 2 for part in passes]] = False
    way, time = np.log(np.abs(moved[inside])), np.log(steps[inside])
    if len(way) < 4 * PLACES or min(way.std(), time.std()) < 0.5 * UNEVEN:
        return False
    speed = way - time
    return bool(np.corrcoef(way, time)[0, 1] < SMOOTH and np.corrcoef(speed[1:], speed[:-1])[0, 1] < SMOOTH)


def holding_map(log: Log) -> HoldingMap | None:
    """Return friction and load of holding forces; None without two passes over the same places."""
    if log.position is None or log.force is None:
        return None
    ways: dict[bool, list[tuple[Real, Real]]] = {True: [], False: []}
    for part in passes_of(log.position):
        if part.stop - part.start < PLACES:
            continue
        inside = slice(part.start + 1, part.stop - 1)  # at a turn the axis came both ways
        z, F = log.position[inside], log.force[inside]
        order = np.argsort(z)
        ways[bool(z[-1] > z[0])].append((z[order], F[order]))
    low = max((z[0] for way in ways.values() for z, _ in way), default=0.0)
    high = min((z[-1] for way in ways.values() for z, _ in way), default=0.0)
    places = min((len(z) for way in ways.values() for z, _ in way), default=0)
    if not (ways[True] and ways[False]) or low >= high:
        return None
    grid = np.linspace(low, high, places)
    up, down = (np.mean([np.interp(grid, z, F) for z, F in ways[forth]], axis=0) for forth in (True, False))
    load, unit = 0.5 * (up + down), log.unit("force")
    level, mean = (_mean(values, unit) for values in (0.5 * (up - down), load))
    return HoldingMap(level, mean, float(load.std()), len(log), float(high - low))


def _mean(values: Real, unit: str) -> Estimate:
    """Return the mean over places, whose neighbours are correlated, with its 95 % interval."""
    mean = float(values.mean())
    variance = float(hac_covariance(np.ones((len(values), 1)), values - mean)[0, 0])
    return Estimate.around(mean, unit, float(stdtrit(len(values) - 1, 0.975)) * variance**0.5)


def holds(log: Log) -> Notice | None:
    """Return the notice on a holding map; None for other records."""
    if log.kind not in {None, "holding-map"} or (log.kind is None and not is_holding_map(log)):
        return None
    if (found := holding_map(log)) is None:
        return None
    return HOLDING_MAP.found(
        log.where, points=found.points, level=found.level, load=found.load,
        varies=Estimate(found.varies, found.load.unit), length=Estimate(found.length, log.unit("position")),
    )  # fmt: skip

"""What is left of a force's settling in strokes that end too soon, taken off their means.

After a change of velocity friction follows eq. (5): while all blocks slip, ``F - s(v)`` falls by ``exp(-t·C/s(v))``.
One stroke alone tells that time badly; all of them share C. Each is fitted by a level and a fall of its own.
"""

from collections.abc import Sequence
from dataclasses import replace
from itertools import compress
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar
from scipy.special import stdtrit

from fric.arrays import Real
from fric.identify.plant.covariance import sandwich
from fric.identify.records.segments import Segment
from fric.identify.static_map.averages import Average, average
from fric.identify.static_map.map_fit import SpeedPoint
from fric.log import Log
from fric.notice import Notice, Severity
from fric.units import Motion, readable, si_unit

BATCHES, FEWEST = 96, 24
"""Batches that a stroke is looked at in, and samples that it has at least."""

UNLIKE = 2.0
"""Chi-squared over its freedom from which on the strokes do not settle like this."""

GAIN = 20.0
"""How much more than its parameters a settling takes from chi-squared, at least."""

VISIBLE = 0.5
"""Standard errors of a stroke's mean from which on what it is off by is worth taking off."""

RISING = 0.1
"""Share of all that is taken off by which forces may rise: from break-away on they fall."""

SMALL, LARGE = 0.01, 0.1
"""Share of friction up to which what is taken off leaves no doubt, and from which on it is wrong."""


class _Stroke(NamedTuple):
    number: int
    time: Real
    """Since it is at constant velocity, of batches [s]."""
    force: Real
    """Means of batches over their standard error [1]."""
    error: float
    """That standard error [N]."""
    level: float
    """Friction [N]."""
    late: Real
    """Time of the samples of which the point is the mean [s]."""

    def shape(self, log_C: float) -> Real:
        """Return the fall along those samples, from 1."""
        return np.asarray(np.exp(-self.late * np.exp(log_C) / self.level))

    def off(self, log_C: float) -> float:
        """Return what the fall adds to the mean of those samples [N]."""
        return self.fall(log_C)[0] * float(np.mean(self.shape(log_C)))

    def fall(self, log_C: float) -> tuple[float, float]:
        """Return the fall from the beginning to the level, and its standard error [N]."""
        shape = np.exp(-self.time * np.exp(log_C) / self.level)
        around = shape - shape.mean()
        power = max(float(around @ around), 1e-12)
        fall = float(around @ self.force) / power
        return fall * self.error, self.error / power**0.5


def settled_points(
    points: list[SpeedPoint], strokes: Sequence[tuple[int, Log, Segment]], method: Average, motion: Motion
) -> tuple[list[SpeedPoint], Real | None, list[Notice]]:
    """Return the points without what is left of their settling, how they then err together, and what to say of it.

    The errors [N], shape (2, n), are half a 95 % interval: of C, and of one time for all strokes in its place. Where
    the strokes do not settle like eq. (5), or have settled, all is left as it is.

    Parameters
    ----------
    points
        The points of all strokes.
    strokes
        By the number of a point, its record and steady segment.
    method
        How the mean of a stroke was taken.
    motion
        Linear or rotary, for the units.
    """
    known = _batched(points, strokes)
    if not known or (shared := _shared(known)) is None:
        return points, None, []
    number = np.array([one.number for one in known])
    taken = np.array([one.off(shared.log_C) for one in known])
    worth = np.abs(taken) > VISIBLE * np.array([points[n].standard_error for n in number])
    rises = np.array([points[n].force for n in number]) * taken < 0.0
    if not worth.any() or np.sum(np.abs(taken)[worth & rises]) > RISING * np.sum(np.abs(taken)[worth]):
        return points, None, []
    together = np.zeros((2, len(points)))
    step = min(shared.half, 0.3)
    moved = [np.array([one.off(shared.log_C + by) for one in known]) for by in (step, -step)]
    together[0, number] = worth * (moved[0] - moved[1]) * shared.half / (2 * step)
    alike = [one._replace(level=float(np.median([one.level for one in known]))) for one in known]
    if (other := _shared(alike)) is not None:  # one time for all, as a filter or a creep has it
        together[1, number] = worth * (np.array([one.off(other.log_C) for one in alike]) - taken)
    found, logs = list(points), {n: (log, segment) for n, log, segment in strokes}
    for one in compress(known, worth):
        log, segment = logs[one.number]
        force = log.require("force", "the friction map")[segment.start : segment.stop]
        fall, error = one.fall(shared.log_C)
        mean = average(force - fall * one.shape(shared.log_C), method)
        error *= shared.scale * float(np.mean(one.shape(shared.log_C)))
        error = float(np.linalg.norm([mean.standard_error, error, points[one.number].rounding]))
        found[one.number] = replace(
            points[one.number], force=points[one.number].force + mean.value - average(force, method).value,
            standard_error=error, settled=False,
        )  # fmt: skip
    return found, together, [_notice(taken[worth], number[worth], shared, points, motion)]


class _Shared(NamedTuple):
    log_C: float
    half: float
    """Half its 95 % interval."""
    scale: float
    """Residuals over their standard error, 1 at least."""


def _shared(known: Sequence[_Stroke]) -> _Shared | None:
    """Return C of all strokes; None where they do not settle so, or have settled."""
    longest = float(np.log(max(one.time[-1] / one.level for one in known)))

    counts = np.array([len(one.time) for one in known])
    begins = np.append(0, np.cumsum(counts[:-1]))
    rate = np.concatenate([one.time / one.level for one in known])
    force = np.concatenate([one.force for one in known])
    centred = force - np.repeat(np.add.reduceat(force, begins) / counts, counts)

    def residuals(log_C: float) -> Real:
        """Return what falls as `_Stroke.fall` leave over, of all strokes one after the other [1]."""
        shape = np.exp(-rate * np.exp(log_C))
        around = shape - np.repeat(np.add.reduceat(shape, begins) / counts, counts)
        power = np.maximum(np.add.reduceat(around**2, begins), 1e-12)
        return centred - np.repeat(np.add.reduceat(around * force, begins) / power, counts) * around

    def cost(log_C: float) -> float:
        return float(np.sum(residuals(log_C) ** 2))

    grid = np.linspace(-1.0, 4.6, 36) - longest  # falls that take nearly three strokes, down to a hundredth of one
    nearest = int(np.argmin([cost(one) for one in grid]))
    if nearest == 0:
        return None
    near = float(grid[nearest])
    log_C = float(minimize_scalar(cost, bounds=(near - 0.16, near + 0.16), method="bounded").x)
    left = residuals(log_C)
    freedom = max(len(left) - 2 * len(known) - 1, 1)
    chi2 = max(float(left @ left) / freedom, 1.0)
    flat = float(centred @ centred)
    if chi2 > UNLIKE or (flat - float(left @ left)) / chi2 < GAIN + 2 * len(known):
        return None
    gradient = (residuals(log_C + 1e-3) - residuals(log_C - 1e-3)) / 2e-3
    label = np.repeat(np.arange(len(known)), counts)
    plain = chi2 * float(stdtrit(freedom, 0.975)) ** 2 / max(float(gradient @ gradient), 1e-12)
    among = float(sandwich(gradient[:, np.newaxis], left, label)[0, 0])
    return _Shared(log_C, max(plain, among) ** 0.5, chi2**0.5)


def _notice(
    taken: Real, number: NDArray[np.int_], shared: _Shared, points: Sequence[SpeedPoint], motion: Motion
) -> Notice:
    speeds = sorted(abs(points[n].velocity) for n in number)
    unit, newton = si_unit("velocity", motion), si_unit("force", motion)
    largest = float(np.max(np.abs(taken)))
    share = largest / float(np.median(np.abs([point.force for point in points])))
    severity: Severity = "note" if share < SMALL else "doubt" if share < LARGE else "wrong"
    return Notice(
        f"the force still settles in {len(taken)} strokes between {readable(speeds[0], unit, 2)} and "
        f"{readable(speeds[-1], unit, 2)}: up to {readable(largest, newton, 2)} is taken off their means, by an "
        f"exponential of C = {readable(float(np.exp(shared.log_C)), newton + '/s', 2)} that all of them share. "
        "Log longer strokes.", "strokes-unsettled", severity,
    )  # fmt: skip


def _batched(points: Sequence[SpeedPoint], strokes: Sequence[tuple[int, Log, Segment]]) -> list[_Stroke]:
    levels = [[p.force for p in points if p.velocity * sense > 0] for sense in (1, -1)]
    offset = sum(float(np.median(level)) for level in levels) / 2 if all(levels) else 0.0
    found = []
    for number, log, segment in strokes:
        n = segment.stop - segment.onset
        if n < FEWEST:
            continue
        each = max(n // BATCHES, 1)
        first = segment.stop - n // each * each
        force = log.require("force", "the friction map")[first : segment.stop].reshape(-1, each).mean(axis=1)
        since = log.time[segment.onset]
        time = log.time[first : segment.stop].reshape(-1, each).mean(axis=1) - since
        error = float(np.std(np.diff(force))) / 2**0.5
        level = abs(points[number].force - offset)
        if error > 0.0 and level > 0.0:
            late = log.time[segment.start : segment.stop] - since
            found.append(_Stroke(number, time, force / error, error, level, late))
    return found

"""What is left of a force's settling in strokes that end too soon, taken off their means.

After a change of velocity friction follows eq. (5): while all blocks slip, ``F - s(v)`` falls by ``exp(-t·C/s(v))``.
One stroke alone tells that time badly; all of them share C. Each is fitted by a level and a fall of its own.
"""

from dataclasses import replace
from itertools import compress
from typing import NamedTuple

import numpy as np
from scipy.optimize import minimize_scalar
from scipy.special import stdtrit

from fric.arrays import Real
from fric.flaws.static_map import STROKES_SETTLING, STROKES_UNSETTLED
from fric.identify.plant.covariance import sandwich
from fric.identify.static_map.averages import average
from fric.identify.static_map.points import SpeedPoint
from fric.identify.static_map.strokes import Correction, Strokes
from fric.notice import Notice

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


class _Shared(NamedTuple):
    log_C: float
    half: float
    """Half its 95 % interval."""
    scale: float
    """Residuals over their standard error, 1 at least."""


def settling(strokes: Strokes) -> Correction | None:
    """Take what is left of the settling off the means of strokes, with one C for all.

    It errs by C, and by whether one time for all strokes takes its place. Where the strokes do not settle like eq. (5),
    or have settled, all is left as it is.
    """
    points, known = strokes.points, _batched(strokes)
    shared = _shared(known) if known else None
    if shared is None:
        return _unsettled(strokes)
    number = np.array([one.number for one in known])
    taken = np.array([one.off(shared.log_C) for one in known])
    worth = np.abs(taken) > VISIBLE * np.array([points[n].standard_error for n in number])
    rises = np.array([points[n].force for n in number]) * taken < 0.0
    if not worth.any() or np.sum(np.abs(taken)[worth & rises]) > RISING * np.sum(np.abs(taken)[worth]):
        return _unsettled(strokes)
    found = list(points)
    for one in compress(known, worth):
        found[one.number] = _settled(strokes, one, shared)
    together = np.zeros((2, len(points)))
    together[:, number] = worth * _errors(known, taken, shared)
    notice = _notice(strokes, np.abs(taken[worth]), [abs(points[n].velocity) for n in number[worth]], shared)
    return Correction(points=found, together=together, notices=[notice])


def _errors(known: list[_Stroke], taken: Real, shared: _Shared) -> Real:
    """Return how what is taken off errs [N]: by C, and by whether strokes share it, half widths, shape (2, n)."""
    step = min(shared.half, 0.3)
    up, down = (np.array([one.off(shared.log_C + by) for one in known]) for by in (step, -step))
    alike = [one._replace(level=float(np.median([one.level for one in known]))) for one in known]
    other = _shared(alike)  # one time for all, as a filter or a creep has it
    apart = 0.0 * taken if other is None else np.array([one.off(other.log_C) for one in alike]) - taken
    return np.array([(up - down) * shared.half / (2 * step), apart])


def _settled(strokes: Strokes, one: _Stroke, shared: _Shared) -> SpeedPoint:
    """Return the point of a stroke without what is left of its settling."""
    point, (log, segment) = strokes.points[one.number], strokes.stretches.by_number[one.number]
    force = log.require("force", "the friction map")[segment.start : segment.stop]
    fall, error = one.fall(shared.log_C)
    mean = average(force - fall * one.shape(shared.log_C), strokes.asked.average)
    error *= shared.scale * float(np.mean(one.shape(shared.log_C)))
    error = float(np.linalg.norm([mean.standard_error, error, point.rounding]))
    settled = point.force + mean.value - average(force, strokes.asked.average).value
    return replace(point, force=settled, standard_error=error, settled=False)


def _shared(known: list[_Stroke]) -> _Shared | None:
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


def _batched(strokes: Strokes) -> list[_Stroke]:
    points = strokes.points
    levels = [[p.force for p in points if p.velocity * sense > 0] for sense in (1, -1)]
    offset = sum(float(np.median(level)) for level in levels) / 2 if all(levels) else 0.0
    found = []
    for number, (log, segment) in strokes.stretches.by_number.items():
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


def _notice(strokes: Strokes, taken: Real, speeds: list[float], shared: _Shared) -> Notice:
    of, largest = strokes.asked.of, float(np.max(taken))
    ends = {"slowest": of(min(speeds), "velocity"), "fastest": of(max(speeds), "velocity")}
    C = of(float(np.exp(shared.log_C)), "force rate")
    found = {"strokes": len(taken), "most": of(largest, "force"), "share": largest / strokes.size, "C": C}
    return STROKES_SETTLING.found(**ends, **found)


def _unsettled(strokes: Strokes) -> Correction | None:
    """Return what there is to say where nothing is taken off, and a force had not settled by half of its stroke."""
    speeds = [
        strokes.asked.of(v, "velocity") for v in dict.fromkeys(p.velocity for p in strokes.points if not p.settled)
    ]
    return Correction(notices=[STROKES_UNSETTLED.found(speeds=speeds)]) if speeds else None

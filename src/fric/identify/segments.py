"""Steady stretches of a record: where the drive moves at a constant velocity and its friction has settled.

A record may be one speed, or an hour of strokes at many. On position z(t), constant velocity is a straight line, and
the distance of z from the chord between two samples is the CUSUM of the velocity. The search is in four steps:

1. *split* a piece at its greatest distance from the chord, as long as that is more than the encoder, the noise or one
   per cent of the way explain, then join neighbours that one chord explains as well;
2. *trim* each piece where it leaves the straight line of its inner part, with the onset of the ramp;
3. *judge*: a stretch moves, its velocity has no trend, and it is no mere moment between accelerations;
4. *settle*: the friction force follows the velocity late (pre-sliding, frictional lag); its transient is cut off.

Where only the velocity was logged, z is its integral, and the noise to be explained is that of a random walk.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from fric.errors import FricError
from fric.identify.resolution import lattice_step, noise_level

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from fric.log import Log

RELATIVE = 0.01
"""Distance from the chord, as a share of the way, that still counts as constant velocity."""
TREND = 0.01
"""Change of velocity over a stretch, as a share of it, that is not taken for an acceleration."""
SHORTEST = 16
"""Samples, and counts of the encoder, that a stretch has at least."""
SETTLING = 0.5
"""Share of a stretch that is given up at most until the force has settled."""
BATCHES = 64
"""Batches of a stretch that the settling of its force is looked for in."""


@dataclass(frozen=True)
class Stretch:
    """Samples ``start`` up to ``stop`` of a record, at constant velocity and with the friction force settled.

    Parameters
    ----------
    start, stop
        First sample, and the one after the last.
    velocity
        Velocity [m/s], by regression of position on time (mean of the velocity where no position was logged).
    velocity_se
        Its standard error [m/s], which allows for autocorrelation.
    onset
        First sample at constant velocity; from there to ``start`` the force was settling.
    settled
        False where the force had not settled when half of the stretch was given up.
    """

    start: int
    stop: int
    velocity: float
    velocity_se: float
    onset: int
    settled: bool = True

    def __len__(self) -> int:
        return self.stop - self.start


@dataclass(frozen=True)
class _Path:
    """Position over time, and how far it may be off a chord for no reason but resolution and noise.

    `explained` takes the number of samples of a piece (for a random walk, the distance grows with it).
    """

    time: NDArray[np.float64]
    position: NDArray[np.float64]
    velocity: NDArray[np.float64] | None
    count: float
    grain: float
    explained: Callable[[int], float]

    def distance(self, start: int, stop: int) -> NDArray[np.float64]:
        """Return the distance of each sample of a piece from its chord [m]."""
        t, z = self.time[start:stop], self.position[start:stop]
        slope = (z[-1] - z[0]) / (t[-1] - t[0])
        distance: NDArray[np.float64] = np.abs(z - (z[0] + slope * (t - t[0])))
        return distance

    def tolerance(self, start: int, stop: int) -> float:
        """Return the distance from the chord [m] at which a piece is no more one of constant velocity."""
        way = abs(float(self.position[stop - 1] - self.position[start]))
        return max(self.explained(stop - start), RELATIVE * way)

    def slope(self, start: int, stop: int) -> float:
        """Return the slope of the chord [m/s]."""
        rise = self.position[stop - 1] - self.position[start]
        return float(rise / (self.time[stop - 1] - self.time[start]))


def _path(log: Log) -> _Path:
    time = log.time
    for channel in ("time", "position", "velocity"):
        values = getattr(log, channel)
        if values is not None and not np.isfinite(values).all():
            bad = int(np.flatnonzero(~np.isfinite(values))[0])
            raise FricError(
                f"the {channel} is no number at sample {bad}",
                where=log.where,
                mend="Ingest the log again with --bad-cells drop.",
            )
    if log.position is not None:
        count = lattice_step(log.position) or 0.0
        grain = max(count, 4.0 * noise_level(log.position))
        grain = max(grain, 1e-9 * float(np.ptp(log.position)))
        return _Path(time, log.position, None, count, grain, lambda samples: 2.0 * grain)
    assert log.velocity is not None  # a Log holds one of them
    v = log.velocity
    dt = float(np.median(np.diff(time))) if len(time) > 1 else 0.0
    position = np.concatenate([[0.0], np.cumsum(0.5 * (v[1:] + v[:-1]) * np.diff(time))])
    noise = max(float(np.median(np.abs(np.diff(v)))) * 1.4826 / np.sqrt(2.0), (lattice_step(v) or 0.0) / np.sqrt(12.0))
    noise = max(noise, 1e-9 * float(np.ptp(v)))
    # a Brownian bridge over n samples leaves 2·sigma·sqrt(n)/2 once in a thousand pieces
    return _Path(time, position, v, 0.0, noise * dt, lambda samples: 2.0 * noise * dt * float(np.sqrt(samples)))


def steady_stretches(log: Log) -> list[Stretch]:
    """Return the stretches of a record at constant velocity, in the order of time; standing still is none.

    Parameters
    ----------
    log
        A record with position or, failing that, velocity. Where it holds the force, its settling is cut off.

    Raises
    ------
    FricError
        When position, velocity or time is not a number somewhere.
    """
    if len(log) < SHORTEST or log.kind in {"presliding-sine", "sliding-sine", "frequency-response"}:
        return []
    path = _path(log)
    pieces = [piece for piece in _joined(path, _split(path)) if piece[1] - piece[0] >= SHORTEST]
    kept = (_trimmed(path, *_trimmed(path, *piece)) for piece in pieces)
    found = [stretch for piece in kept if (stretch := _judged(path, *piece)) is not None]
    moves = [
        (start, stop, abs(_way(path, start, stop)), path.explained(stop - start), log.time[stop - 1] - log.time[start])
        for start, stop in pieces
    ]
    while moments := [stretch for stretch in found if not _lasts(stretch, found, moves, len(log))]:
        found.remove(min(moments, key=len))
    if log.force is None or not np.isfinite(log.force).all():
        return found
    return [_settled(path, log.force, stretch) for stretch in found]


def _way(path: _Path, start: int, stop: int) -> float:
    return float(path.position[stop - 1] - path.position[start])


def _split(path: _Path) -> list[tuple[int, int]]:
    """Split at the greatest distance from the chord until each piece is explained; pieces share their end samples."""
    pieces, pending = [], [(0, len(path.time))]
    while pending:
        start, stop = pending.pop()
        if stop - start > 3:
            distance = path.distance(start, stop)
            cut = int(distance.argmax())
            if distance[cut] > path.tolerance(start, stop):
                pending += [(start + cut, stop), (start, start + cut + 1)]  # the first part comes off the stack first
                continue
        pieces.append((start, stop))
    return pieces


def _joined(path: _Path, pieces: list[tuple[int, int]]) -> list[tuple[int, int]]:
    """Join neighbours that one chord explains."""
    joined = [pieces[0]]
    for start, stop in pieces[1:]:
        first, last = joined[-1]
        before, after = path.slope(first, last), path.slope(start, stop)
        blur = path.explained(last - first) / (path.time[last - 1] - path.time[first])
        blur += path.explained(stop - start) / (path.time[stop - 1] - path.time[start])
        alike = abs(before - after) <= 8.0 * RELATIVE * max(abs(before), abs(after)) + 4.0 * blur
        if alike and path.distance(first, stop).max() <= path.tolerance(first, stop):
            joined[-1] = (first, stop)
        else:
            joined.append((start, stop))
    return joined


def _trimmed(path: _Path, start: int, stop: int) -> tuple[int, int]:
    """Return the samples of a piece that keep to the straight line of its inner eight tenths.

    Looking outward from there, also past the ends of the piece, the motion is seen to leave the line when it is off by
    what noise does not explain. It left earlier: in a ramp the distance grows as a·tau²/2, so that the onset lies as
    long before that as it takes from there to four times the distance; twice that time is left out. A stop that is
    over within the noise is not seen at all: hence twice the time that the noise takes to pass is left out at an end
    that is not that of the record.
    """
    n = stop - start
    edge = n // 10
    if n - 2 * edge < SHORTEST:
        return start, stop
    t, z = path.time, path.position
    inner = slice(start + edge, stop - edge)
    t_inner, z_inner = t[inner] - t[inner].mean(), z[inner] - z[inner].mean()
    slope = float(t_inner @ z_inner) / float(t_inner @ t_inner)
    first, last = max(start - n, 0), min(stop + n, len(t))
    residual = z[first:last] - z[inner].mean() - slope * (t[first:last] - t[inner].mean())
    usual = 5.0 * float(np.median(np.abs(residual[start + edge - first : stop - edge - first])))
    allowed = max(path.grain if path.velocity is None else path.explained(n), usual)
    way = abs(_way(path, start + edge, stop - edge)) / (n - 2 * edge)
    blind = int(min(2.0 * allowed / way, n)) if way > 0.0 else n
    middle = (start + stop) // 2 - first
    before = _kept(residual[middle::-1], allowed, blind, first + middle + 1 - start, edge)
    after = _kept(residual[middle:], allowed, blind, stop - first - middle, edge)
    return first + middle + 1 - before, first + middle + after


def _kept(outward: NDArray[np.float64], allowed: float, blind: int, most: int, edge: int) -> int:
    """Count the samples, from the middle of a piece on, that keep to its line; no more than the ``most`` it has."""
    off = np.abs(outward) > allowed
    off[: most - edge] = False
    lasting = np.append(off, [True] * 3)
    leaves = np.flatnonzero(lasting[:-3] & lasting[1:-2] & lasting[2:-1] & lasting[3:])
    if not len(leaves):
        return most
    seen = int(leaves[0])
    back = np.flatnonzero(~off[seen:])
    run = np.abs(outward[seen : seen + int(back[0]) if len(back) else None])
    far = int(np.argmax(np.minimum(run, 4.0 * allowed)))
    return max(min(seen - max(2 * far, blind) - 3, most), 0)


def _judged(path: _Path, start: int, stop: int) -> Stretch | None:
    """Return the stretch, or None where it is too short, stands still, or its velocity has a trend."""
    n = stop - start
    if n < SHORTEST:
        return None
    if abs(_way(path, start, stop)) <= (path.explained(n) if path.count == 0.0 else SHORTEST * path.grain):
        return None
    t = path.time[start:stop] - path.time[start:stop].mean()
    duration = float(t[-1] - t[0])
    if path.velocity is None:
        velocity, velocity_se = _regressed(t, path.position[start:stop])
        least = _count_error(path.count, velocity, duration, n)
        velocity_se = max(velocity_se, least)
        z = path.position[start:stop]
        left, bends = z - z.mean() - velocity * t, ((2, 12.0 / duration), (3, 15.0 / duration))
    else:
        least = 0.0
        velocity, velocity_se = _regressed(np.ones(n), path.velocity[start:stop])
        left, bends = path.velocity[start:stop] - velocity, ((1, 2.0), (2, 1.5))
    if abs(velocity) < 5.0 * velocity_se:
        return None
    # Legendre's polynomials of the trend and of the curvature of the velocity, and how far it moves with each
    for degree, swing in bends:
        bend, bend_se = _regressed(np.polynomial.Legendre.basis(degree)(2.0 * t / duration), left)
        if swing * abs(bend) > max(TREND * abs(velocity), 5.0 * swing * bend_se, 12.0 * least):
            return None
    return Stretch(start, stop, velocity, velocity_se, onset=start)


def _count_error(count: float, velocity: float, duration: float, samples: int) -> float:
    """Return the error of a slope [m/s] that whole counts leave in a perfectly regular motion.

    Position in whole counts is off by a sawtooth, seen under its alias where a sample is not far from p/q counts: then
    its height is 1/q count. N teeth leave up to 1.75·height/(N·duration), half of which is given.
    """
    q = np.arange(1.0, 65.0)
    each = q * abs(velocity) * duration / (samples - 1) / count if count else np.zeros_like(q)
    teeth = (samples - 1) * np.abs(each - np.round(each))
    return float((0.9 * count / q / np.maximum(teeth, 1.0)).max()) / duration


def _regressed(x: NDArray[np.float64], y: NDArray[np.float64]) -> tuple[float, float]:
    """Return the coefficient of y on x by least squares and its standard error.

    The error is the sandwich estimate over batches of neighbouring samples (x·residual summed over each), so that it
    holds for residuals that are correlated over less than a batch: a count of the encoder, a ripple.
    """
    squares = float(x @ x)
    coefficient = float(x @ y) / squares
    scores = x * (y - coefficient * x if np.ptp(x) == 0 else y - y.mean() - coefficient * x)
    batches = min(30, len(x) // 2)
    edges = np.linspace(0, len(x), batches, endpoint=False).astype(int)
    sums = np.add.reduceat(scores, edges)
    return coefficient, float(np.sqrt(sums @ sums * batches / (batches - 1))) / squares


def _lasts(
    stretch: Stretch, found: list[Stretch], pieces: list[tuple[int, int, float, float, float]], samples: int
) -> bool:
    """Say whether a stretch is no mere moment between longer accelerations, such as the crest of a sine.

    An acceleration reaches up to the next stretch, or the next piece at rest (or slower by far).
    """
    bounds = [(other.start, other.stop) for other in found if other is not stretch]
    bounds += [
        (start, stop)
        for start, stop, way, rest, duration in pieces
        if way <= max(rest, 0.02 * abs(stretch.velocity) * duration)
    ]
    before = max((stop for _, stop in bounds if stop <= stretch.start), default=0)
    after = min((start for start, _ in bounds if start >= stretch.stop), default=samples)
    return len(stretch) >= 0.5 * max(stretch.start - before, after - stretch.stop)


def _settled(path: _Path, force: NDArray[np.float64], stretch: Stretch) -> Stretch:
    """Cut the settling of the force off a stretch, where it is seen.

    The cut minimises the marginal standard error of what is left, ``S(k)/(n - k)²`` with S the sum of squares about
    the mean of the batches k to n (White, Simulation 69(6), 1997: MSER), and is made only where what it takes off is a
    transient: a stationary force is left whole.
    """
    n = len(stretch)
    batches = min(BATCHES, n // 4)
    if batches < 8:
        return stretch
    y = force[stretch.start : stretch.stop]
    late = y[n // 2 :]
    middle = float(np.median(late))
    spread = 1.4826 * float(np.median(np.abs(late - middle))) or float(late.std())
    edges = np.linspace(0, n, batches, endpoint=False).astype(int)
    # a glitch must not look like a transient: it counts as twenty standard deviations at most
    y = np.clip(y, middle - 20.0 * spread, middle + 20.0 * spread)
    means = np.add.reduceat(y, edges) / np.diff(np.append(edges, n))
    last = int(SETTLING * batches)
    left = batches - np.arange(batches)
    total, squares = np.cumsum(means[::-1])[::-1], np.cumsum((means - middle)[::-1] ** 2)[::-1]
    scatter = np.maximum(squares - left * (total / left - middle) ** 2, 0.0)
    cut = int(np.argmin((scatter / left**2)[: last + 1]))
    if cut == 0:
        return stretch
    if not _is_transient(means[:cut], means[cut:]):
        return stretch
    quarter = batches // 4
    settled = cut < last or not _is_transient(means[-2 * quarter : -quarter], means[-quarter:])
    start = stretch.start + int(edges[cut])
    shorter = _judged(path, start, stretch.stop) or stretch
    return Stretch(start, stretch.stop, shorter.velocity, shorter.velocity_se, stretch.onset, settled)


def _is_transient(head: NDArray[np.float64], tail: NDArray[np.float64]) -> bool:
    """Say whether the head settles into the tail, rather than being part of how the force wanders.

    It differs from the tail by more than four standard errors, and begins outside the range that the tail keeps to.
    """
    difference = float(head.mean() - tail.mean())
    if abs(difference) <= 4.0 * _mean_se(tail) * np.sqrt(1.0 + len(tail) / len(head)):
        return False
    toward = np.sign(difference)
    return bool((toward * head[:3]).max() > (toward * tail).max())


def _mean_se(batches: NDArray[np.float64]) -> float:
    """Return the standard error of the mean of batch means that may be correlated, by their initial positive sum."""
    centred = batches - batches.mean()
    n = len(centred)
    covariance = np.correlate(centred, centred, "full")[n - 1 : n - 1 + n // 4] / n
    negative = np.flatnonzero(covariance <= 0.0)
    upto = int(negative[0]) if len(negative) else len(covariance)
    return float(np.sqrt(max(covariance[0] + 2.0 * covariance[1:upto].sum(), 0.0) / max(n - 1, 1)))


def reversals(position: NDArray[np.float64], threshold: float | None = None) -> NDArray[np.intp]:
    """Return the samples at which a motion turns round, in the order of time.

    A reversal is an extreme from which the motion comes back by more than the threshold: the flicker of an encoder is
    none. Where the extreme lasts (a dwell, a flat crest of counts), its middle is given.

    Parameters
    ----------
    position
        Position [m], shape (n,).
    threshold
        Way back [m] that makes a reversal; two counts of the encoder or eight standard deviations of the noise where
        it is not given.
    """
    z = np.asarray(position, float)
    if len(z) < 3:
        return np.zeros(0, dtype=np.intp)
    count = lattice_step(z) or 0.0
    if threshold is None:
        threshold = max(2.0 * count, 8.0 * noise_level(z), 1e-9 * float(np.ptp(z)))
    flat = 0.5 * count
    found: list[int] = []
    direction, begin = 0, 0
    while (turn := _next_turn(z, begin, direction, threshold)) is not None:
        extreme, passed, turned = turn
        if direction:
            level = np.flatnonzero(np.abs(z[begin:passed] - z[extreme]) <= flat) + begin
            found.append(int(level[0] + level[-1]) // 2)
        direction, begin = turned, extreme
    return np.array(found, dtype=np.intp)


def _next_turn(z: NDArray[np.float64], begin: int, direction: int, threshold: float) -> tuple[int, int, int] | None:
    """Return the extreme after ``begin``, the sample that is past it by the threshold, and the direction from there."""
    stop = begin
    block = 1024
    high = low = z[begin]
    at_high = at_low = begin
    while stop < len(z):
        start, stop = stop, min(stop + block, len(z))
        part = z[start:stop]
        highest = np.maximum(np.maximum.accumulate(part), high)
        lowest = np.minimum(np.minimum.accumulate(part), low)
        down = np.flatnonzero(highest - part > threshold) if direction >= 0 else np.zeros(0, int)
        up = np.flatnonzero(part - lowest > threshold) if direction <= 0 else np.zeros(0, int)
        first_down, first_up = (int(k[0]) if len(k) else len(part) for k in (down, up))
        k = min(first_down, first_up)
        seen = part[: k + 1]
        if seen.max() > high:
            high, at_high = seen.max(), start + int(seen.argmax())
        if seen.min() < low:
            low, at_low = seen.min(), start + int(seen.argmin())
        if k < len(part):
            return (at_high, start + k, -1) if first_down < first_up else (at_low, start + k, 1)
        block *= 2
    return None

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
from fric.identify.records.resolution import lattice_step, noise_level
from fric.identify.records.settling import settled_from
from fric.threads import one_blas_thread

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from fric.log import Log

RELATIVE = 0.01
"""Distance from the chord, as a share of the way, that still counts as constant velocity."""
TREND = 0.01
"""Change of velocity over a stretch, as a share of it, that is not taken for an acceleration."""
SHORTEST = 16
"""Samples, and counts of the encoder, that a stretch has at least."""


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
        A record with position or, failing that, velocity. Where it holds the force, its settling is cut off. A record
        that says it is a sine or a frequency response has no stretch.

    Raises
    ------
    FricError
        When position, velocity or time is not a number somewhere.
    """
    return stretches_and_rests(log)[0]


@one_blas_thread()
def stretches_and_rests(log: Log) -> tuple[list[Stretch], list[tuple[int, int]]]:
    """Return the stretches as `steady_stretches` does, and where the axis stands still: first sample, one past last."""
    if len(log) < SHORTEST or log.kind in {"presliding-sine", "sliding-sine", "frequency-response"}:
        return [], []
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
    rests = [(start, stop) for start, stop, way, rest, _ in moves if way <= rest]
    if log.force is not None and np.isfinite(log.force).all():
        found = [_settled(path, log.force, stretch) for stretch in found]
    return found, rests


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
    first, last = max(start - n // 2, 0), min(stop + n // 2, len(t))
    residual = z[first:last] - z[inner].mean() - slope * (t[first:last] - t[inner].mean())
    usual = 5.0 * float(np.median(np.abs(residual[start + edge - first : stop - edge - first])))
    allowed = max(1.5 * path.grain if path.velocity is None else path.explained(n), usual)
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
    x = 2.0 * t / duration
    legendre = {1: x, 2: 1.5 * x * x - 0.5, 3: x * (2.5 * x * x - 1.5)}
    for degree, swing in bends:
        bend, bend_se = _regressed(legendre[degree], left)
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
    """Cut the settling of the force off a stretch."""
    cut, settled = settled_from(force[stretch.start : stretch.stop])
    if cut == 0:
        return stretch
    start = stretch.start + cut
    shorter = _judged(path, start, stretch.stop) or stretch
    return Stretch(start, stretch.stop, shorter.velocity, shorter.velocity_se, stretch.onset, settled)

"""Straight pieces of a motion: where position over time keeps to its chord, but for resolution and noise."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fric.arrays import Real
from fric.log import Log
from fric.records.resolution import lattice_step, noise_level
from fric.statistics import robust_deviation

RELATIVE = 0.01
"""Distance from the chord, as a share of the travel, that still counts as constant velocity."""
SHORTEST = 16
"""Samples, and counts of the encoder, that a segment has at least."""


@dataclass(frozen=True)
class Path:
    """Position over time, and how far it may be off a chord for no reason but resolution and noise.

    `explained` takes the number of samples of a piece (for a random walk, the distance grows with it).
    """

    time: Real
    position: Real
    velocity: Real | None
    count: float
    resolution: float
    explained: Callable[[int], float]

    def distance(self, start: int, stop: int) -> Real:
        """Return the distance of each sample of a piece from its chord [m]."""
        t, z = self.time[start:stop], self.position[start:stop]
        slope = (z[-1] - z[0]) / (t[-1] - t[0])
        distance: Real = np.abs(z - (z[0] + slope * (t - t[0])))
        return distance

    def tolerance(self, start: int, stop: int) -> float:
        """Return the distance from the chord [m] at which a piece is no more one of constant velocity."""
        return max(self.explained(stop - start), RELATIVE * abs(self.travel(start, stop)))

    def travel(self, start: int, stop: int) -> float:
        """Return the travel from the first sample of a piece to the last [m], with its sign."""
        return float(self.position[stop - 1] - self.position[start])

    def slope(self, start: int, stop: int) -> float:
        """Return the slope of the chord [m/s]."""
        rise = self.position[stop - 1] - self.position[start]
        return float(rise / (self.time[stop - 1] - self.time[start]))


def travelled(log: Log) -> Real:
    """Return the position of a record [m]; where it was not logged, the integral of the velocity from 0; shape (n,)."""
    if log.position is not None:
        return log.position
    v = log.require("velocity", "a motion")
    return np.concatenate([[0.0], np.cumsum(0.5 * (v[1:] + v[:-1]) * np.diff(log.time))])


def path_of(log: Log) -> Path:
    """Return the position of a record over time, from its velocity where no position was logged."""
    time = log.time
    if log.position is not None:
        count = lattice_step(log.position) or 0.0
        resolution = max(count, 4.0 * noise_level(log.position))
        resolution = max(resolution, 1e-9 * float(np.ptp(log.position)))
        return Path(time, log.position, None, count, resolution, lambda samples: 2.0 * resolution)
    assert log.velocity is not None  # a Log holds one of them
    v = log.velocity
    dt = float(np.median(np.diff(time)))
    noise = max(robust_deviation(np.diff(v)) / np.sqrt(2.0), (lattice_step(v) or 0.0) / np.sqrt(12.0))
    noise = max(noise, 1e-9 * float(np.ptp(v)))
    # a Brownian bridge over n samples leaves 2·sigma·sqrt(n)/2 once in a thousand pieces
    return Path(time, travelled(log), v, 0.0, noise * dt, lambda samples: 2.0 * noise * dt * float(np.sqrt(samples)))


def straight_pieces(path: Path) -> list[tuple[int, int]]:
    """Return first sample, and one past the last, of the pieces that each keep to a chord of their own."""
    return [piece for piece in _joined(path, _split(path)) if piece[1] - piece[0] >= SHORTEST]


def _split(path: Path) -> list[tuple[int, int]]:
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


def _joined(path: Path, pieces: list[tuple[int, int]]) -> list[tuple[int, int]]:
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


def trimmed(path: Path, start: int, stop: int) -> tuple[int, int]:
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
    allowed = max(1.5 * path.resolution if path.velocity is None else path.explained(n), usual)
    travel = abs(path.travel(start + edge, stop - edge)) / (n - 2 * edge)
    blind = int(min(2.0 * allowed / travel, n)) if travel > 0.0 else n
    middle = (start + stop) // 2 - first
    before = _kept(residual[middle::-1], allowed, blind, first + middle + 1 - start, edge)
    after = _kept(residual[middle:], allowed, blind, stop - first - middle, edge)
    return first + middle + 1 - before, first + middle + after


def _kept(outward: Real, allowed: float, blind: int, most: int, edge: int) -> int:
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

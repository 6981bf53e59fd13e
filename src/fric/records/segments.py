"""Steady segments of a record: where the drive moves at a constant velocity and its friction has settled.

A record may have one speed, or an hour of strokes at many. In position z(t), constant velocity is a straight line, and
the distance of z from the chord between two samples is the CUSUM of the velocity. The search is in four steps:

1. *split* a piece at its greatest distance from the chord, as long as that is more than the encoder, the noise or one
   per cent of the travel explain, then join neighbours that one chord explains as well;
2. *trim* each piece where it leaves the straight line of its inner part, with the onset of the ramp;
3. *judge*: a segment moves, its velocity has no trend, and it is no mere moment between accelerations;
4. *settle*: the friction force follows the velocity late (pre-sliding, frictional lag); its transient is cut off.

Where only the velocity was logged, z is its integral, and the noise to be explained is that of a random walk.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from itertools import pairwise, zip_longest

import numpy as np

from fric.arrays import Real
from fric.columns import PRESLIDING
from fric.estimate import STAYS
from fric.log import Log
from fric.process import one_blas_thread
from fric.records.resolution import lattice_step, noise_level
from fric.statistics import robust_deviation

COARSE = 0.02  # Noise of a position, in travels of a sample at the largest speed, that hides how the speed changes
SAME = 4.0  # Distance of a velocity's integral from a position, in its noise, up to which they are of one motion
PROMPT = 0.01  # Interval of samples within which a drive logs its velocity [s]
RELATIVE = 0.01  # Distance from the chord, as a share of the travel, that still counts as constant velocity
GRAIN = 2.0**-20  # Share of the resolution that distances are rounded to
SWINGS = 0.03  # Root mean square of the velocity about its mean, over that mean, above which a stroke swings
ENOUGH = 4096  # Number of samples searched for a swing; of more, means are used
ASKED = 0.1  # Travel of the reference over that of the position below which the axis is at rest, and creeps
AS_FAR = 0.25  # Largest relative difference of the travel of the reference and of the position in a stroke
ALIKE, SLIP, SLIPS = 2.0, 0.5, 4
"""Of creeps between slips: ratio of speeds; share of a slip, most in samples and least in travel; least number."""
SHORTEST = 16  # Least number of samples, and of encoder counts, in a segment
MOMENT = 0.1  # Share of the neighbouring segment, in time and travel, below which a segment is no stroke
CREEP = 0.001  # Share of its travel below which a far shorter segment, or the next, is how the axis comes to rest
BRIEF = 0.02  # Share of another segment, either way, in time and travel, below which a segment is no stroke
TREND = 0.01  # Largest relative change of velocity over a segment that is no acceleration
SETTLING = 0.5  # Largest share of the samples to drop until the force has settled
BATCHES = 64  # Number of batches for the search of settling
OVER = 0.8  # Least share of the places of a segment on which the way back shows what depends on the place
ALIKE_OVER_PLACE = 0.8  # Least correlation of the forces of both ways over the places for that


@dataclass(frozen=True)
class Path:
    """Position over time, and its tolerance about a chord from resolution and noise alone.

    The argument of `explained` is the number of samples of a piece (for a random walk, the distance grows with it).
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
        return self.rounded(np.abs(z - (z[0] + self.slope(start, stop) * (t - t[0]))))

    def rounded(self, distance: Real) -> Real:
        """Return distances [m] without their last bits: of whole counts, many equal each other or a tolerance."""
        return (distance / grain).round() * grain if (grain := GRAIN * self.resolution) else distance

    def tolerance(self, start: int, stop: int) -> float:
        """Return the distance from the chord [m] above which the velocity of a piece is not constant."""
        return max(self.explained(stop - start), RELATIVE * abs(self.travel(start, stop)))

    def travel(self, start: int, stop: int) -> float:
        """Return the travel from the first sample of a piece to the last [m], with its sign."""
        return float(self.position[stop - 1] - self.position[start])

    def slope(self, start: int, stop: int) -> float:
        """Return the slope of the chord [m/s]."""
        return self.travel(start, stop) / float(self.time[stop - 1] - self.time[start])


def travelled(log: Log) -> Real:
    """Return the position of a record [m], or the integral of the velocity from 0 without a position, shape (n,)."""
    if log.position is not None:
        return log.position
    v = log.require("velocity", "a motion")
    return np.concatenate([[0.0], np.cumsum(0.5 * (v[1:] + v[:-1]) * np.diff(log.time))])


def finer(log: Log) -> Log:
    """Return the record of a motion without its position, where a velocity of the same motion shows it in finer steps.

    At 10 Hz three digits of a position hardly change between samples, while those of the velocity do. At a rate at
    which a drive's velocity may be late by more than a sample it is not used.
    """
    z, v, dt = log.position, log.velocity, float(np.median(np.diff(log.time)))
    if z is None or v is None or dt < PROMPT:
        return log
    noise = max(noise_level(z), (lattice_step(z) or 0.0) / np.sqrt(12.0))
    alone = replace(log, position=None)
    if noise <= COARSE * dt * float(np.quantile(np.abs(v), 0.98)):
        return log
    drift = np.polynomial.Polynomial.fit(log.time, off := travelled(alone) - z, 1)
    return alone if np.std(off - drift(log.time)) < SAME * noise else log


def path_of(log: Log) -> Path:
    """Return the path of a record, from its velocity if no position was logged."""
    time = log.time
    if log.position is not None:
        count = lattice_step(log.position) or 0.0
        resolution = max(count, 4.0 * noise_level(log.position), 1e-9 * float(np.ptp(log.position)))
        return Path(time, log.position, None, count, resolution, lambda samples: 2.0 * resolution)
    assert log.velocity is not None  # a Log holds one of them
    v, dt = log.velocity, float(np.median(np.diff(time)))
    noise = max(robust_deviation(np.diff(v)) / np.sqrt(2.0), (lattice_step(v) or 0.0) / np.sqrt(12.0))
    noise = max(noise, 1e-9 * float(np.ptp(v)))
    # a Brownian bridge over n samples leaves 2·sigma·sqrt(n)/2 once in a thousand pieces
    return Path(time, travelled(log), v, 0.0, noise * dt, lambda samples: 2.0 * noise * dt * float(np.sqrt(samples)))


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
    """Join neighbours that a common chord explains."""
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
    residual = path.rounded(z[first:last] - z[inner].mean() - slope * (t[first:last] - t[inner].mean()))
    usual = 5.0 * float(np.median(np.abs(residual[start + edge - first : stop - edge - first])))
    allowed = max(1.5 * path.resolution if path.velocity is None else path.explained(n), usual)
    travel = abs(path.travel(start + edge, stop - edge)) / (n - 2 * edge)
    blind = int(min(2.0 * allowed / travel, n)) if travel > 0.0 else n
    middle = (start + stop) // 2 - first
    before = _kept(residual[middle::-1], allowed, blind, first + middle + 1 - start, edge)
    after = _kept(residual[middle:], allowed, blind, stop - first - middle, edge)
    return first + middle + 1 - before, first + middle + after


def _kept(outward: Real, allowed: float, blind: int, most: int, edge: int) -> int:
    """Count the samples from the middle of a piece that follow its line, up to ``most``."""
    off = np.abs(outward) > allowed
    off[: most - edge] = False
    lasting = np.append(off, [True] * 3)
    if not len(leaves := np.flatnonzero(lasting[:-3] & lasting[1:-2] & lasting[2:-1] & lasting[3:])):
        return most
    seen = int(leaves[0])
    back = np.flatnonzero(~off[seen:])
    run = np.abs(outward[seen : seen + int(back[0]) if len(back) else None])
    far = int(np.argmax(np.minimum(run, 4.0 * allowed)))
    return max(min(seen - max(2 * far, blind) - 3, most), 0)


@dataclass(frozen=True)
class Segment:
    """Samples ``start`` up to ``stop`` of a record, at constant velocity and with the friction force settled."""

    start: int  #: First sample
    stop: int  #: The sample after the last
    velocity: float  #: By regression of position on time, or the mean where no position was logged [m/s]
    velocity_se: float  #: Its standard error, which allows for autocorrelation [m/s]
    #: First sample at constant velocity; from there to ``start`` the force was settling
    onset: int = field(metadata=STAYS)
    settled: bool = True  #: False where the force had not settled when half of the segment was given up

    def __len__(self) -> int:
        return self.stop - self.start


def steady_segments(log: Log) -> list[Segment]:
    """Return the constant-velocity segments of a record, in order of time, without rests.

    log: A record with position or, failing that, velocity. If it has a force, its settling is cut off. A record stated
        to be a sine or a frequency response has no segment.
    """
    return segments_and_rests(log)[0]


@one_blas_thread()
def segments_and_rests(log: Log) -> tuple[list[Segment], list[tuple[int, int]]]:
    """Return the segments of `steady_segments`, and the rests: first sample, one past the last."""
    if len(log) < SHORTEST or log.kind in {*PRESLIDING, "sliding-sine", "frequency-response", "holding-map"}:
        return [], []
    path = path_of(log)
    pieces = [piece for piece in _joined(path, _split(path)) if piece[1] - piece[0] >= SHORTEST]  # each along a chord
    creeps = {piece for piece in pieces if _creeps(log, path, *piece)}
    kept = (trimmed(path, *trimmed(path, *piece)) for piece in pieces if piece not in creeps)
    found = [segment for piece in kept if (segment := _accepted(path, *piece)) is not None]
    found = [segment for segment in found if _as_asked(log, path, segment.start, segment.stop)]
    moves = [
        (start, stop, abs(path.travel(start, stop)), path.explained(stop - start), log.time[stop - 1] - log.time[start])
        for start, stop in pieces
    ]
    while found and not all(lasting := _lasts(found, np.array(moves), len(log))):
        found.remove(min((segment for segment, lasts in zip(found, lasting, strict=True) if not lasts), key=len))
    rests = [(start, stop) for start, stop, travel, rest, _ in moves if travel <= rest or (start, stop) in creeps]
    found = _between_slips(path, found)
    if log.force is not None:
        force, pairs = log.force, zip_longest(found, found[1:])
        found = [segment for segment, later in pairs if later is None or not _leads_into(path, force, segment, later)]
        found = [_settled(path, force, segment, found) for segment in found]
    return found, rests


def _creeps(log: Log, path: Path, start: int, stop: int) -> bool:
    """Return whether a piece moves while the reference, which moves elsewhere, stays: the axis settles."""
    r, z = log.reference, path.position
    if r is None or np.ptp(r) < 0.5 * np.ptp(z):
        return False
    return bool(np.ptp(r[start:stop]) < ASKED * abs(path.travel(start, stop)))


def _between_slips(path: Path, found: list[Segment]) -> list[Segment]:
    """Return the segments without those between slips: an axis that sticks creeps, all alike, and slips on by more."""
    creeps = set[int]()
    for n, (a, b) in enumerate(pairwise(found)):
        creep, slip = path.travel(a.start, a.stop), path.travel(a.stop - 1, b.start + 1)
        alike = 1.0 / ALIKE < a.velocity / b.velocity < ALIKE
        if alike and slip / creep > SLIP and b.start - a.stop < SLIP * min(len(a), len(b)):
            creeps |= {n, n + 1}
    return found if len(creeps) < SLIPS else [segment for n, segment in enumerate(found) if n not in creeps]


def _as_asked(log: Log, path: Path, start: int, stop: int) -> bool:
    """Return whether a piece moves as fast as the reference, if that moves as far; phases of stick-slip do not."""
    r = log.reference
    if r is None or abs(float(np.ptp(r)) / max(float(np.ptp(path.position)), 1e-300) - 1.0) > AS_FAR:
        return True
    return abs(float(r[stop - 1] - r[start]) - (moved := path.travel(start, stop))) <= AS_FAR * abs(moved)


def _accepted(path: Path, start: int, stop: int) -> Segment | None:
    """Return the segment, or None where it is too short, at rest, or its velocity has a trend."""
    if (n := stop - start) < SHORTEST:
        return None
    if abs(path.travel(start, stop)) <= (path.explained(n) if path.count == 0.0 else SHORTEST * path.resolution):
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
    return Segment(start, stop, velocity, velocity_se, onset=start)


def _count_error(count: float, velocity: float, duration: float, samples: int) -> float:
    """Return the error of a slope [m/s] due to whole counts in a perfectly uniform motion.

    The error of whole counts is a sawtooth, aliased if the motion in a sample is close to p/q counts: its height is
    then 1/q count. N teeth leave up to 1.75·height/(N·duration), half of which is given.
    """
    q = np.arange(1.0, 65.0)
    each = q * abs(velocity) * duration / (samples - 1) / count if count else np.zeros_like(q)
    teeth = (samples - 1) * np.abs(each - np.round(each))
    return float((0.9 * count / q / np.maximum(teeth, 1.0)).max()) / duration


def _regressed(x: Real, y: Real) -> tuple[float, float]:
    """Return the coefficient of y on x by least squares and its standard error: a sandwich over batches of neighbouring
    samples, for residuals that are correlated over less than a batch, as by a count of the encoder or a ripple.
    """
    squares = float(x @ x)
    coefficient = float(x @ y) / squares
    scores = x * (y - coefficient * x if np.ptp(x) == 0 else y - y.mean() - coefficient * x)
    batches = min(30, len(x) // 2)
    sums = np.add.reduceat(scores, np.linspace(0, len(x), batches, endpoint=False).astype(int))
    return coefficient, float(np.sqrt(sums @ sums * batches / (batches - 1))) / squares


def _lasts(found: list[Segment], moves: Real, samples: int) -> list[bool]:
    """Return which segments are more than a moment between longer accelerations, such as the crest of a sine.

    An acceleration reaches up to the next segment, or the next piece at rest (or slower by far).

    moves: First sample, one past the last, travel [m], that of a rest [m] and duration [s] of each piece, shape (m, 5).
    """
    first, last, travel, rest, duration = moves.T
    starts, stops, v = np.array([(segment.start, segment.stop, segment.velocity) for segment in found]).T
    n, pauses = stops - starts, np.searchsorted(np.sort(first[travel <= rest]), starts)  # before each segment

    def lasts(i: int) -> bool:
        share = v[i] * n[i] / (v * n)  # beside one far longer, in time and travel, it is its ramp, or how it catches up
        along = (share > 0.0) & (share < MOMENT) & (pauses == pauses[i])
        slow = travel <= np.maximum(rest, 0.02 * abs(v[i]) * duration)
        ends, begins = np.append(stops, last[slow]), np.append(starts, first[slow])
        before = ends[ends <= starts[i]].max(initial=0.0)
        after = begins[begins >= stops[i]].min(initial=samples)
        after_it = (np.arange(len(v)) == i - 1) & (pauses == pauses[i])  # the loop closes its error there: creep
        ramp = (np.abs(share) < CREEP) & ((n[i] < MOMENT * n) | after_it) | (n[i] < MOMENT * n) & along
        ramp |= np.maximum(np.abs(share), n[i] / n) < BRIEF
        return bool(not ramp.any() and n[i] >= 0.5 * max(starts[i] - before, after - stops[i]))

    return [*map(lasts, range(len(found)))]


def _leads_into(path: Path, force: Real, segment: Segment, later: Segment) -> bool:
    """Return whether a segment continues at its speed in a longer one while its force is settling.

    Friction that builds up along a slow stroke makes the axis lag by a part of a count, which splits the stroke.
    """
    same = abs(segment.velocity - later.velocity) <= TREND * abs(later.velocity) + 5.0 * segment.velocity_se
    on = later.velocity * float(path.time[later.start] - path.time[segment.stop - 1])
    behind = abs(path.travel(segment.stop - 1, later.start + 1) - on)  # by all of it, where it rested between
    same = same and behind <= 2.0 * path.resolution + 0.25 * abs(on)
    longer = later.start - segment.stop < len(later) and len(segment) < len(later)
    return same and longer and segment.start + settled_from(force[segment.start : later.stop])[0] >= segment.stop


def _opposite(path: Path, segment: Segment, found: list[Segment]) -> Segment | None:
    """Return the segment nearest in time that goes back over nearly all places of a segment, or None."""
    low, high = sorted(path.position[[segment.start, segment.stop - 1]])

    def shared(other: Segment) -> float:
        first, last = sorted(path.position[[other.start, other.stop - 1]])
        return (min(high, last) - max(low, first)) / (high - low)

    back = [other for other in found if other.velocity * segment.velocity < 0.0 and shared(other) > OVER]
    return min(back, key=lambda other: abs(other.start - segment.start), default=None)


def _over_places(path: Path, force: Real, segment: Segment, back: Segment) -> Real:
    """Return the force of a segment without its variation over position, as the way back shows it at the same places.

    Friction that settles has the sign of the motion, and each way begins at another place: only what depends on the
    place is alike on both ways. Where that is not most of the variation, the force is returned as it is. At the end of
    the segment the way back settles: its last quarter is left out.
    """
    there, back_there = slice(segment.start, segment.stop), slice(back.start, back.stop)
    low, high = sorted(map(float, path.position[[segment.start, segment.stop - 1]]))
    bins = np.linspace(low, high, BATCHES // 4 + 1)

    def mean_of(way: slice) -> Real:
        count = np.histogram(path.position[way], bins)[0]
        summed = np.histogram(path.position[way], bins, weights=force[way])[0]
        return np.where(count > 0, summed / np.maximum(count, 1), np.nan)

    forth, level = mean_of(there), mean_of(back_there)
    varies = np.ptp(forth) > 0.0 and np.ptp(level) > 0.0  # neither where a place was not visited
    if not varies or not np.corrcoef(forth, level)[0, 1] > ALIKE_OVER_PLACE:
        return force[there]
    at_ends = 0.5 * (level[1:] + level[:-1])
    at_ends = np.concatenate([[2.0 * level[0] - at_ends[0]], at_ends, [2.0 * level[-1] - at_ends[-1]]])
    return np.asarray(force[there] - np.interp(path.position[there], bins, at_ends))[: 3 * len(segment) // 4]


def _settled(path: Path, force: Real, segment: Segment, found: list[Segment]) -> Segment:
    """Cut the settling of the force off a segment, unless it is a force over position that the way back shows, too."""
    cut, settled = settled_from(force[segment.start : segment.stop])
    if cut and (back := _opposite(path, segment, found)) is not None:
        cut, settled = settled_from(_over_places(path, force, segment, back))
    if cut == 0:
        return segment
    start = segment.start + cut
    shorter = _accepted(path, start, segment.stop) or segment
    return Segment(start, segment.stop, shorter.velocity, shorter.velocity_se, segment.onset, settled)


def settled_from(force: Real) -> tuple[int, bool]:
    """Return the sample after which a force has settled, and whether half of the force is enough for that.

    The cut minimises the marginal standard error of what is left, ``S(k)/(n - k)²`` with S the sum of squares about
    the mean of the batches k to n (White, Simulation 69(6), 1997: MSER), and is made only where what it takes off is a
    transient: a stationary force is left whole.

    force: The force at constant velocity, from its first sample on, shape (n,).
    """
    n = len(force)
    if (batches := min(BATCHES, n // 4)) < 8:
        return 0, True
    late = force[n // 2 :]
    middle = float(np.median(late))
    spread = robust_deviation(late - middle) or float(late.std())
    edges = np.linspace(0, n, batches, endpoint=False).astype(int)
    # a glitch must not look like a transient: it counts as twenty standard deviations at most
    y = np.clip(force, middle - 20.0 * spread, middle + 20.0 * spread)
    means = np.add.reduceat(y, edges) / np.diff(np.append(edges, n))
    last, left = int(SETTLING * batches), batches - np.arange(batches)
    total, squares = np.cumsum(means[::-1])[::-1], np.cumsum((means - middle)[::-1] ** 2)[::-1]
    scatter = np.maximum(squares - left * (total / left - middle) ** 2, 0.0)
    if (cut := int(np.argmin((scatter / left**2)[: last + 1]))) == 0 or not _is_transient(means[:cut], means[cut:]):
        return 0, True
    quarter = batches // 4
    return int(edges[cut]), cut < last or not _is_transient(means[-2 * quarter : -quarter], means[-quarter:])


def _is_transient(head: Real, tail: Real) -> bool:
    """Return whether the head settles into the tail: over four standard errors off it, and begun outside its range."""
    difference = float(head.mean() - tail.mean())
    if abs(difference) <= 4.0 * _mean_se(tail) * np.sqrt(1.0 + len(tail) / len(head)):
        return False
    toward = np.sign(difference)
    return bool((toward * head[:3]).max() > (toward * tail).max())


def _mean_se(batches: Real) -> float:
    """Return the standard error of the mean of batch means that may be correlated, by their initial positive sum."""
    centred = batches - batches.mean()
    n = len(centred)
    covariance = np.correlate(centred, centred, "full")[n - 1 : n - 1 + max(n // 4, 1)] / n
    upto = int(negative[0]) if len(negative := np.flatnonzero(covariance <= 0.0)) else len(covariance)
    return float(np.sqrt(max(covariance[0] + 2.0 * covariance[1:upto].sum(), 0.0) / max(n - 1, 1)))


def velocity_swing(log: Log, segment: Segment) -> float:
    """Return the root mean square of the velocity about its mean over that mean; 0 if below `SWINGS`.

    For a logged position it is the sum of ``(2πf·Z)²`` over the lines above its noise, below the frequency at which the
    sawtooth of whole counts would look like a swing.
    """
    part, n = slice(segment.start, segment.stop), len(segment)
    if n < 4 * SHORTEST:
        return 0.0
    t = log.time[part] - log.time[segment.start]
    sampling = (n - 1) / float(t[-1])
    if log.position is None:
        v = np.asarray(log.velocity)[part]
        swing = float(np.sqrt(max(float(np.var(v)) - float(np.var(np.diff(v))) / 2, 0.0))) / abs(segment.velocity)
        return swing if swing > SWINGS else 0.0
    count = lattice_step(log.position[part][:ENOUGH]) or 0.0
    z, each = log.position[part] - segment.velocity * t, max(n // ENOUGH, 1)
    n = n // each
    z = z[: n * each].reshape(n, each).mean(axis=1)
    z, sampling = z - z.mean(), sampling / each
    # the sawtooth of whole counts, at any alias, has less than this share of the velocity below that frequency
    top = min(0.25 * sampling, SWINGS / np.sqrt(2) * abs(segment.velocity) / count if count else np.inf)
    if float(np.std(z)) * 2 * np.pi * top < SWINGS * abs(segment.velocity):
        return 0.0
    window = 0.5 - 0.5 * np.cos(2 * np.pi * np.arange(n) / n)  # Hann's, and the share of the variance of each line
    power = 2 * np.abs(np.fft.rfft(z * window)) ** 2 / (n * float(window @ window))
    f = np.arange(len(power)) * sampling / n
    floor = max(float(np.median(power[f > 0.25 * sampling])), (count**2 / 12) * 2 / n)
    seen = (f <= top) & (f >= 2 * sampling / n) & (power > 12 * floor)
    swing = float(np.sqrt(np.sum((2 * np.pi * f[seen]) ** 2 * power[seen]))) / abs(segment.velocity)
    return swing if swing > SWINGS else 0.0

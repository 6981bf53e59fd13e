"""Variation of the force over place and time within strokes at constant velocity.

A variation along the stroke with the same sign in both directions is a force over position (cogging, a cable, a
balance); a variation whose sign changes with the direction is friction over position. Both recur at every speed, unlike
noise. As a drive or a guideway warms up, the magnitude of the force changes at the same rate at all speeds.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations, pairwise
from typing import NamedTuple

import numpy as np
from scipy.special import stdtrit

from fric.arrays import Mask, Real
from fric.log import Log
from fric.records.segments import Segment

PLACES = 64  # Number of places along the longest stroke for comparison
SHORTEST = 12  # Least number of places in a stroke that is compared
SURE = 4.0  # Standard errors above which strokes agree about the place
STROKES_AGREE = 0.5  # Correlation of two strokes of one direction, above which they agree
MINOR = 0.1  # Share of the variance below which one of two causes is not reported
LASTING = 0.7  # Least duration of a stroke for a rate [s]
FASTEST = 0.02  # Rate [1/s] above which the force is settling, not warming up
SETTLING = 3.0  # Largest ratio of the rates in whole strokes and in their later halves without settling
STUCK = 1e-9  # Least uncertainty of the slope over a stroke, as a share of the force, unless the force is at a bound
REPEATED = 0.05  # Relative difference of speeds up to which strokes repeat each other
FEWEST = 4  # Number of speeds above which each is left out, and of strokes that separate cogging from inertia
LIKELY_RATE, SURE_RATE = 0.99, 0.995  # Probabilities above which a rate is likely, and surely, not zero
SCATTERED_RATE = 0.95  # The same where the means of strokes scatter beyond their noise, too, as of what changes


@dataclass(frozen=True)
class OverPlace:
    """Forces that recur at the same place in all strokes."""

    cogging: float  # Root mean square of the force over position [N]
    friction: float  # Root mean square of the friction over position [N]
    strokes: int  # Strokes that were compared
    length: float  # Length of the travel that they were compared over [m]

    @property
    def either(self) -> bool:
        """Whether both are half of what varies: the strokes of the two directions do not meet."""
        return self.cogging == self.friction

    @property
    def most_friction(self) -> float:
        """Largest root mean square of the friction over position [N]."""
        return self.friction * (np.sqrt(2.0) if self.either else 1.0)


@dataclass(frozen=True)
class OverTime:
    """Change of the magnitude of the force in time, at all speeds."""

    rate: float  # Relative rate [1/s]
    half: float  # Half its 95 % interval [1/s]
    duration: float  # From the first record to the last with a common clock, else that of all records together [s]
    clocked: bool  # Whether the records have a common clock
    sure: bool  # Whether the rate is no chance

    @property
    def change(self) -> float:
        """The change over all records [1]."""
        return self.rate * self.duration


def over_place(strokes: Sequence[tuple[Log, Segment]]) -> OverPlace | None:
    """Return the common variation of strokes over place; None if they do not agree, or are too few.

    Two strokes are compared over their common places, each without its mean and slope there. Noise differs between
    strokes, so their covariance is the variance of their common part. Friction that rises along the travel falls along
    a stroke back, as nothing does that changes in time: it is compared with the slopes, too.
    """
    cut = [
        (log.position, log.force, segment) for log, segment in strokes
        if log.position is not None and log.force is not None
    ]  # fmt: skip
    if len(cut) < 4:
        return None
    low, high = min(z[s.start : s.stop].min() for z, _, s in cut), max(z[s.start : s.stop].max() for z, _, s in cut)
    edges = np.linspace(low, high, PLACES + 1)
    same, opposite = _of_directions([(z[s.start : s.stop], F[s.start : s.stop], s.velocity) for z, F, s in cut], edges)
    # from the onset on: what rises along a stroke seems to settle
    from_onset = [(z[s.onset : s.stop], F[s.onset : s.stop], s.velocity) for z, F, s in cut]
    rising, falling = _of_directions(from_onset, edges, 0)
    rises = 0.0
    if rising is not None and falling is not None and rising.agrees and falling.sure:
        rises = 0.5 * (rising.covariance - falling.covariance) * (falling.correlation < -STROKES_AGREE)
    if same is None or opposite is None or not (same.agrees or rises > 0.0):
        return None
    # F = ±F_r + c ± w: strokes of one direction share c + w, and opposite strokes c² - w² on average
    across = opposite.covariance if opposite.sure else 0.0
    cogging, friction = (max(0.5 * (same.covariance + sign * across), 0.0) for sign in (1.0, -1.0))
    friction = max(friction, rises)
    whole = cogging + friction
    return OverPlace(
        float(np.sqrt(cogging)) if cogging > MINOR * whole else 0.0,
        float(np.sqrt(friction)) if friction > MINOR * whole else 0.0,
        same.strokes, float(high - low),
    )  # fmt: skip


class ForceOverPosition(NamedTuple):
    """A force over position, by its values at places; zero in the mean over them."""

    places: Real  # [m], shape (PLACES + 1,)
    force: Real  # [N], shape (PLACES + 1,)
    varies: float  # Root mean square of what recurs [N]
    errors: Real  # Directions whose squares add up to its covariance [N], shape (strokes, PLACES + 1)

    def less(self, log: Log) -> Log:
        """Return a record without it."""
        z, F = (log.require(name, "a force over position") for name in ("position", "force"))
        return replace(log, force=F - np.interp(z, self.places, self.force))

    def covers(self, log: Log) -> Mask:
        """Return which samples of a record are at these places, shape (n,)."""
        z, apart = log.require("position", "a force over position"), self.places[1] - self.places[0]
        return np.asarray(np.abs(z - self.places.mean()) < 0.5 * np.ptp(self.places) + apart)

    def moves(self, X: Real, z: Real) -> Real:
        """Return the covariance of a least-squares fit by its errors, of columns X (n, p) at places z (n,): (p, p)."""
        effects = np.column_stack([np.interp(z, self.places, error) for error in self.errors])
        moved = np.linalg.lstsq(X, effects, rcond=None)[0]
        return np.asarray(moved @ moved.T)


def cogging(strokes: Sequence[tuple[Log, Segment]]) -> ForceOverPosition | None:
    """Return the force over position in which strokes of both directions agree (`over_place`); None where they do not.

    ``F_i(z) = m_i + c(z)`` along stroke i, c being linear between places; its errors are those of a jackknife.
    """
    if (found := over_place(strokes)) is None or found.either or not found.cogging or len(strokes) < FEWEST:
        return None
    every = 1 + sum(len(log) for log, _ in strokes) // 400_000  # so many samples show it
    cut = [[log.require(of, "cogging")[s.start : s.stop : every] for of in ("position", "force")] for log, s in strokes]
    places = np.linspace(min(z.min() for z, _ in cut), max(z.max() for z, _ in cut), PLACES + 1)
    hats = [np.column_stack([np.interp(z, places, row) for row in np.eye(PLACES + 1)]) for z, _ in cut]
    hats = [hat - hat.mean(axis=0) for hat in hats]
    normal = np.array([hat.T @ hat / len(hat) for hat in hats])
    right = np.array([hat.T @ (F - F.mean()) / len(hat) for hat, (_, F) in zip(hats, cut, strict=True)])

    def solved(without: int | None = None) -> Real:
        kept = np.arange(len(cut)) != without
        whole = normal[kept].sum(axis=0)
        bound = 1e-3 * np.trace(whole) / len(whole) * np.eye(len(whole))
        force = np.linalg.solve(whole + bound, right[kept].sum(axis=0))
        return np.asarray(force - force.mean())

    each = np.array([solved(n) for n in range(len(cut))])
    errors = np.sqrt((len(cut) - 1) / len(cut)) * (each - each.mean(axis=0))
    return ForceOverPosition(places, solved(), found.cogging, errors)


class _Common(NamedTuple):
    """The common part of pairs of strokes."""

    covariance: float  # [N²]
    correlation: float  # Median
    sure: bool
    strokes: int

    @property
    def agrees(self) -> bool:
        """Whether strokes of one direction show it."""
        return self.sure and self.correlation >= STROKES_AGREE


def _of_directions(
    cut: Sequence[tuple[Real, Real, float]], edges: Real, less: int = 1
) -> tuple[_Common | None, _Common | None]:
    """Return the common part of positions, forces and velocities of strokes, of one direction and of opposite ones."""
    profiles = [(profile(z, F, edges), v) for z, F, v in cut]
    alike = [(a, b) for (a, v), (b, w) in combinations(profiles, 2) if v * w > 0.0 and v != w]
    against = [(a, b) for (a, v), (b, w) in combinations(profiles, 2) if v * w < 0.0]
    return _common(alike, less), _common(against, less)


def profile(z: Real, F: Real, edges: Real) -> Real:
    """Return the mean force of a stroke at each place between edges; nan where it was not."""
    place = np.clip(np.digitize(z, edges) - 1, 0, len(edges) - 2)
    count = np.bincount(place, minlength=len(edges) - 1)
    return np.where(count > 0, np.bincount(place, F, minlength=len(count)) / np.maximum(count, 1), np.nan)


def _common(pairs: Sequence[tuple[Real, Real]], less: int = 1) -> _Common | None:
    """Return the common part of the pairs that meet at enough places; None where there are fewer than three.

    less: Degree of the polynomial over place that each stroke is taken without.
    """
    found, seen = [], set()
    for a, b in pairs:
        if len(at := np.flatnonzero(np.isfinite(a) & np.isfinite(b))) < SHORTEST:
            continue
        x, y = (array[at] - np.polynomial.Polynomial.fit(at, array[at], less)(at) for array in (a, b))
        if (size := float(np.sqrt(np.mean(x * x) * np.mean(y * y)))) > 0.0:
            covariance = float(np.mean(x * y))
            found.append((covariance, float(np.clip(covariance / size, -0.999, 0.999)), len(at)))
            seen |= {id(a), id(b)}
    if len(found) < 3:
        return None
    covariance, correlation, places = np.array(found).T
    long = places >= (0.0 if less else 0.5 * places.max())  # what rises along the travel is hardly seen in a short part
    z = np.arctanh(correlation)  # Fisher's: its spread does not depend on the correlation
    # each stroke is in many pairs: no more of them are independent than half of the strokes
    error = max(float(np.std(z, ddof=1)), 0.3) / np.sqrt(max(0.5 * len(seen), 1.0))
    return _Common(
        float(np.average(covariance[long], weights=places[long])), float(np.median(correlation)),
        bool(abs(np.mean(z)) > SURE * error), len(seen),
    )  # fmt: skip


def over_time(strokes: Sequence[tuple[Log, Segment]], *, scattered: bool = False) -> OverTime | None:
    """Return the rate at which the magnitude of the force changes; None if it is zero or not known.

    The slope of the force in each stroke is regressed on the size of the force (the rate), on the speed (a force over
    position) and on the velocity (friction over position), so that effects of place do not count as time. The rate is
    accepted if the strokes of each direction alone show it; it is sure if slow and fast strokes do.

    scattered: Whether the means of strokes scatter beyond noise, which is a second sign that something changes.
    """
    whole, late = _trends(strokes, 0.0), _trends(strokes, 0.5)
    if whole is None or late is None:
        return None
    rate, deviation, freedom = whole.values[0], whole.errors[0], whole.freedom
    forward, backward, *speeds = (value * rate > 0.0 for value in whole.apart)
    if not (forward and backward and sum(whole.logged) * rate > 0.0):  # it is no friction that changes
        return None
    asked = (SCATTERED_RATE, SCATTERED_RATE) if scattered else (LIKELY_RATE, SURE_RATE)
    likely, sure = (abs(rate) > float(stdtrit(freedom, 0.5 * (1.0 + value))) * deviation for value in asked)
    # what settles changes less and less
    if not likely or abs(rate) > FASTEST or not 1.0 / SETTLING < late.values[0] / rate < SETTLING:
        return None
    spans = sorted((float(log.time[0]), float(log.time[-1])) for log in {id(log): log for log, _ in strokes}.values())
    one_clock = all(after[0] >= before[1] for before, after in pairwise(spans))  # with the pauses, where it is known
    duration = spans[-1][1] - spans[0][0] if one_clock else sum(end - begin for begin, end in spans)
    return OverTime(rate, float(stdtrit(freedom, 0.975)) * deviation, duration, one_clock, sure and all(speeds))


def along_axis(strokes: Sequence[tuple[Log, Segment]]) -> tuple[float, float] | None:
    """Return the slope of the force along the axis [N/m], and half its 95 % interval; None if it is 0.

    It is estimated from the later halves of strokes, settled or not: a rise along a stroke looks like settling.
    """
    if (found := _trends(strokes, 0.5, settled=False)) is None:
        return None
    rises, deviation = found.values[1], found.errors[1]
    sure = abs(rises) > float(stdtrit(found.freedom, 0.5 * (1.0 + SURE_RATE))) * deviation
    return (rises, float(stdtrit(found.freedom, 0.975)) * deviation) if sure else None


class _Trends(NamedTuple):
    """The terms of the slopes of strokes in time."""

    values: list[float]  # Relative rate [1/s], force over position and friction over position [N/m]
    errors: list[float]  # Their standard errors
    freedom: int  # Degrees of freedom of the errors
    apart: list[float]  # Relative rate of forward and backward strokes, and of the slower and the faster half [1/s]
    logged: list[float]  # Median slope of the logged force over it, of forward and backward strokes [1/s]


def _trends(strokes: Sequence[tuple[Log, Segment]], begin: float, *, settled: bool = True) -> _Trends | None:
    """Return the terms of the slopes of strokes, from a share of each stroke on."""
    rows, slopes, errors = [], [], []
    for log, segment in strokes:
        first = segment.start if settled else segment.onset
        start = first + int(begin * (segment.stop - first))
        part = slice(start, segment.stop)
        lasting = float(log.time[segment.stop - 1] - log.time[first])
        if log.force is None or segment.stop - start < 64 or (settled and not segment.settled) or lasting < LASTING:
            continue
        t, F = log.time[part] - log.time[start], log.force[part] * np.sign(segment.velocity)
        slope, rest, noise = _slope(t, F)
        if max(rest, noise) * float(t[-1]) <= STUCK * abs(float(np.mean(F))):  # no noise at all: the force is stuck
            continue
        rows.append([float(np.mean(F)), abs(segment.velocity), segment.velocity])
        slopes.append(slope)
        errors.append((rest, noise))
    if len(rows) < 8:
        return None
    X, y, (rest, noise) = np.array(rows), np.array(slopes), np.array(errors).T
    # a ripple over encoder counts averages out sooner than noise: all strokes together show how much
    w = 1.0 / np.maximum(rest, noise * min(float(np.median(rest / np.maximum(noise, 1e-9 * rest))), 1.0))
    A, b = X * w[:, np.newaxis], y * w
    if np.linalg.matrix_rank(A / np.linalg.norm(A, axis=0), tol=1e-6) < 3:
        return None
    solution, *_ = np.linalg.lstsq(A, b, rcond=None)
    freedom = len(y) - 3
    spread = max(float(np.sum((b - A @ solution) ** 2)) / freedom, 1.0)
    deviations: Real = np.sqrt(spread * np.diag(np.linalg.inv(A.T @ A)))
    order, speed = np.argsort(X[:, 1]), np.empty(len(y), int)
    speed[order] = np.cumsum(np.append(False, np.diff(np.log(X[order, 1])) > np.log1p(REPEATED)))
    if (count := int(speed.max()) + 1) > FEWEST:
        # a law or a place affects the strokes of one speed equally in both directions: each speed is left out
        without = np.array([np.linalg.lstsq(A[speed != n], b[speed != n], rcond=None)[0] for n in range(count)])
        scatter = np.sqrt((count - 1) / count * np.sum((without - without.mean(axis=0)) ** 2, axis=0))
        deviations, freedom = np.maximum(deviations, scatter), min(freedom, count - 1)
    made = b - A[:, 1:] @ solution[1:]  # by the rate
    forward, slow = X[:, 2] > 0, X[:, 1] < np.median(X[:, 1])
    apart = [float(A[some, 0] @ made[some] / (A[some, 0] @ A[some, 0])) for some in (forward, ~forward, slow, ~slow)]
    logged = [float(np.median(y[some] / X[some, 0])) if some.any() else 0.0 for some in (forward, ~forward)]
    return _Trends(solution.tolist(), deviations.tolist(), freedom, apart, logged)


def _slope(t: Real, F: Real) -> tuple[float, float, float]:
    """Return the slope of a force in time [N/s] by the means of eight parts, and two standard errors: by the deviation
    of the parts from a line, and by the noise of independent samples.
    """
    parts = np.array_split(np.arange(len(t)), 8)
    at, mean = (np.array([values[part].mean() for part in parts]) for values in (t, F))
    at, mean = at - at.mean(), mean - mean.mean()
    spread = float(np.sqrt(at @ at))
    slope = float(at @ mean) / spread**2
    noise = np.array([F[part].std(ddof=1) / np.sqrt(len(part)) for part in parts])
    return slope, float(np.sqrt(np.sum((mean - slope * at) ** 2) / 6.0)) / spread, float(np.mean(noise)) / spread

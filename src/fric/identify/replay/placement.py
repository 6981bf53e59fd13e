"""Best placement of the blocks of a GMS model among all local least-squares solutions.

If a model has fewer blocks than the machine, its knots can be placed in several ways, like those of any spline with
free knots: the start decides by chance, and the interval of a solution does not include the others. But the force is
linear in the shares of blocks with given k/alpha (`fric.identify.replay.replay_search`). So a replay with a row of
blocks gives the residual of any few blocks: all places on a grid are tried and the best refined, without further
replay. The same with noise added to the force shows how far noise moves them.

A knot is separable from the reversal, and from the previous knot, at a distance of `RESOLVED` encoder steps.
"""

from dataclasses import dataclass, replace
from itertools import combinations
from math import comb

import numpy as np
from scipy.interpolate import CubicSpline

from fric.arrays import Mask, Real
from fric.friction.directed import Directed
from fric.friction.gms import GMS
from fric.identify.replay.replay_search import LEVEL, Search, coordinates_of, side_by_side, times
from fric.records.judgement import RESOLVED, identifiability_of

ROW, MOST_SAMPLES = 160, 40_000  # Number of blocks in the row, and of samples in its replay
BEYOND = 1.5  # Excess width of the row over the blocks on either side, in the logarithm of k/alpha
WORSE = 1.02  # Ratio of squared residuals above which a place is rejected: the force is interpolated in the row
TRIED, SETTLED, STEPS = 20_000, 40, 24
"""Largest number of places tried on the grid, number of places refined, and least-squares steps from each."""
RIVALS, PLACES_APART = 3, 0.05  # Points kept beside the best, and their least distance in log(k/alpha) of some block
DRAWS, LEAST = 96, 1e-4  # Number of noise draws, and the share of a step over which their effect is linear


@dataclass(frozen=True)
class Placement:
    """Good placements of blocks."""

    search: Search  # The search
    model: GMS  # The model whose static map and C are taken
    # What a block of unit share adds to the force over the logarithm of its k/alpha, in d directions
    blocks: CubicSpline
    target: Real  # The measured force in these directions, shape (d,)
    noisy: int  # Number of rows that are measured; the last row states that shares sum to 1
    apart: float  # How far two knots are apart at least, over F_s [m/N]
    # places, shares: the least-squares points: the logarithms of k/alpha [N/m], and the shares, shape (m, N), the best
    # first
    places: Real
    shares: Real

    def point(self, places: Real, shares: Real) -> Real:
        """Return the point of the search (p,) of some blocks, in the order in which they slip."""
        total, order = float(shares.sum()), np.argsort(-places)
        found = replace(
            self.model, static=times(self.model.static, total), alpha=tuple(shares[order] / total),
            k=tuple((shares * np.exp(places))[order]),
        )  # fmt: skip
        return coordinates_of(self.search.coordinates, found)

    def better(self, x: Real) -> Real:
        """Return the best point of the search (p,); x if the row of blocks gives no better place."""
        if not len(self.places):
            return x
        best = self.point(self.places[0], self.shares[0])
        return best if self.search.cost(best) < WORSE * self.search.cost(x) else x

    def unsettled(self, size: float) -> Real:
        """Return the increase of a covariance (p, p) due to the nonlinear effect of noise on blocks.

        White noise is added to the force and the blocks are placed anew, from each known point: so an interval includes
        the curvature of the misfit over a knot, and other places as often as noise makes them better. The outer 5 % of
        the draws are clipped to the limits of the others.

        size: Standard deviation of the noise, that of the residual [N].
        """
        rng, count = np.random.default_rng(0), self.places.shape[1]
        noise = np.zeros((DRAWS, len(self.target)))
        noise[:, : self.noisy] = size * rng.standard_normal((DRAWS, self.noisy))
        noise[1::2] = -noise[::2]
        places, shares = self.places[0], self.shares[0]
        slopes = np.vstack([self.blocks(places), shares[:, None] * self.blocks(places, 1)])
        steps = np.linalg.lstsq(slopes.T, noise.T, rcond=1e-12)[0].T
        room = np.concatenate([0.5 * shares, np.full(count, 0.5)])  # of blocks that the records hardly separate
        least = np.minimum(LEAST, 1.0 / np.max(np.abs(steps) / room, axis=1, initial=1.0, keepdims=True))
        linear = [self.point(places + item[count:], shares + item[:count]) for item in least * steps]
        found = settled(
            self.blocks, np.tile(self.target + noise, (len(self.places), 1)), np.repeat(self.places, DRAWS, axis=0),
            STEPS // 2, self.apart,
        )  # fmt: skip
        first = np.argmin(found[2].reshape(-1, DRAWS), axis=0) * DRAWS + np.arange(DRAWS)
        moved = [self.point(found[0][n], found[1][n]) for n in first if np.isfinite(found[2][n])]
        best = self.point(places, shares)
        values, vectors = np.linalg.eigh(_spread(np.array(moved) - best) - _spread((np.array(linear) - best) / least))
        return np.asarray(vectors * np.maximum(values, 0.0) @ vectors.T)


def _spread(moved: Real) -> Real:
    """Return the mean squares and products (p, p) of moves (m, p), the outer 5 % of them as large as the limits."""
    kept = np.clip(moved, *np.quantile(moved, [0.025, 0.975], axis=0))
    return np.asarray(kept.T @ kept / len(kept))


def placed(search: Search, x: Real) -> Placement:
    """Return the best placement of the blocks of a GMS model.

    x: Point of the search, shape (p,): the static map, its level and C are taken from it, but no block.
    """
    every = -(-sum(len(record.force) for record in search.records) // MOST_SAMPLES)
    if every > 1:
        search = replace(search, records=[record.thinned(every) for record in search.records], weights=None).weighed(x)
    model = search.coordinates.build(x)
    one = model.model if isinstance(model, Directed) else model
    assert isinstance(one, GMS)
    alpha, k = np.array(one.alpha), np.array(one.k)
    here = np.log(k / alpha)
    row = np.linspace(here.min() - BEYOND, here.max() + BEYOND, ROW)
    every_k = np.exp(np.append(row, here))[None]
    table = search.projected(
        [side_by_side(model, np.ones_like(every_k), every_k, one.C, record)[:, 0] for record in search.records]
    )
    target = search.residual(x) + table[:, ROW:] @ alpha
    small = np.asarray(np.linalg.qr(np.column_stack([table[:, :ROW], target]), mode="r"))
    noisy = len(small) - 1
    if all(c.parameter is not LEVEL for c in search.coordinates.free):
        small = np.vstack([small, np.full(ROW + 1, 1e3 * np.linalg.norm(target))])  # the shares then sum to 1
    blocks, force = CubicSpline(row, small[:, :ROW].T), small[:, ROW]
    apart = RESOLVED * identifiability_of(search.records).resolved / one.static.F_s
    places, shares, cost = settled(blocks, force, on_a_grid(blocks, force, len(alpha), apart), STEPS, apart)
    kept: list[int] = []
    for n in np.argsort(cost):
        if len(kept) <= RIVALS and np.isfinite(cost[n]):
            other = [np.abs(np.sort(places[n]) - np.sort(places[m])).max() > PLACES_APART for m in kept]
            kept += [int(n)] if all(other) else []
    return Placement(search, one, blocks, force, noisy, apart, places[kept], shares[kept])


def on_a_grid(blocks: CubicSpline, target: Real, count: int, apart: float) -> Real:
    """Return the best places (m, count) on the finest grid that can be searched completely; arguments as `settled`."""
    size = count + 1
    while size < ROW and comb(size + 1, count) <= TRIED:
        size += 1
    grid = np.linspace(blocks.x[0], blocks.x[-1], size)
    columns, chosen = blocks(grid), np.array(list(combinations(range(size), count)))
    right = (columns @ target)[chosen]
    normal = (columns @ columns.T)[chosen[:, :, None], chosen[:, None]] + _tiny(target, count)
    shares = np.linalg.solve(normal, right[..., None])[..., 0]
    possible = (shares > 0.0).all(axis=1) & _told_apart(grid[chosen], apart)
    gain = np.where(possible, np.sum(shares * right, axis=1), -np.inf)
    return np.asarray(grid[chosen[np.argsort(-gain, kind="stable")[:SETTLED]]])


def settled(blocks: CubicSpline, target: Real, places: Real, steps: int, apart: float) -> tuple[Real, Real, Real]:
    """Return places (m, N), shares (m, N) and cost (m,) of the least-squares points next to many starts (m, N).

    Levenberg and Marquardt's steps over places and shares, the shares solved for anew after each (variable projection).
    The target (d,) is common to all starts, or each has a target.
    """

    def solved(at: Real) -> tuple[Real, Real, Real, Real]:
        columns = blocks(at)
        shares = np.linalg.solve(columns @ columns.mT + tiny, columns @ target[..., None])[..., 0]
        rest = target - (shares[:, None] @ columns)[:, 0]
        possible = (shares > 0.0).all(axis=1) & _told_apart(at, apart)
        left = np.where(possible, np.sum(rest**2, axis=1), np.inf)
        return columns, np.asarray(shares, float), np.asarray(rest, float), left

    slope, count = blocks.derivative(), places.shape[1]
    target = np.broadcast_to(target, (len(places), target.shape[-1]))
    tiny, damping = _tiny(target[0], count), np.full(len(places), 1e-2)
    places = places.copy()
    columns, shares, rest, cost = solved(places)
    for _ in range(steps):
        J = np.concatenate([columns, shares[..., None] * slope(places)], axis=1)
        normal = J @ J.mT
        diagonal = np.einsum("mii->mi", normal)
        diagonal += 1e-12 * diagonal.max(axis=1, keepdims=True)
        diagonal *= np.where(np.arange(2 * count) < count, 1.0 + 1e-12, 1.0 + damping[:, None])
        step = np.linalg.solve(normal, (J @ rest[..., None]))[:, count:, 0]
        tried = np.clip(places + np.clip(step, -0.5, 0.5), blocks.x[0], blocks.x[-1])
        found = solved(tried)
        better = found[-1] < cost
        for old, new in zip((places, columns, shares, rest, cost), (tried, *found), strict=True):
            old[better] = new[better]
        damping = np.where(better, damping / 5.0, damping * 5.0)
    return places, shares, cost


def _told_apart(places: Real, apart: float) -> Mask:
    """Return the sets of blocks (m, N) whose knots are all separable, over F_s [m/N]."""
    knots = np.sort(np.exp(-places), axis=1)
    return np.asarray((np.diff(knots, axis=1) >= apart).all(axis=1))


def _tiny(target: Real, count: int) -> Real:
    return 1e-12 * float(target @ target) * np.eye(count)

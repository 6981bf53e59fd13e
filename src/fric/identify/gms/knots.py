"""Slip blocks from the virgin curve: a concave piecewise-linear fit, and eq. (6) of the paper.

N blocks with slip displacements ``d_1 < … < d_N`` give the curve ``V(z) = Σ k_i·min(z, d_i)``: linear between its
knots d_i, and concave exactly when every k_i is positive.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import nlopt
import numpy as np

from fric.arrays import Real
from fric.choice import simplest
from fric.errors import FricError
from fric.identify.gms.virgin_curve import VirginCurve
from fric.identify.static_map.stribeck_fit import nonnegative
from fric.search import minimised

MOST_BLOCKS = 6  # Largest number of blocks that the information criterion may choose by default
REPEATABLE = 0.005  # Share by which friction repeats along a drive at best: a block must change the curve by more
STRONG = 6.0
"""Difference of Schwarz's criterion below which evidence for a block is not strong (Kass, Raftery, JASA 90, 1995): runs
whose B differs by 1e-13 scatter by 2.5."""
LEAST_SHARE = 1e-5  # Least share of a block in the friction, a few steps of a 16-bit force channel


@dataclass(frozen=True)
class Blocks:
    """Slip blocks in the order of their slip displacements."""

    k: Real  # Stiffness of each block [N/m], shape (N,)
    displacement: Real  # Displacement at which each block slips [m], shape (N,)

    def __len__(self) -> int:
        return len(self.k)

    @property
    def limit(self) -> Real:
        """Force ``W_i = k_i·d_i`` at which each block slips [N]."""
        return self.k * self.displacement

    def __call__(self, z: Real | float) -> Real:
        """Return the virgin curve [N] at displacements z [m]."""
        return np.asarray(np.minimum(np.asarray(z)[..., None], self.displacement) @ self.k)


def blocks_from_knots(knots: Real, force: Real) -> Blocks:
    """Solve eq. (6) for any number of blocks, from the knots that the user chose.

    ``K_j = Σ_{i≥j} k_i`` is the slope before knot j, so ``k_j = K_j - K_{j+1}``, and ``Σ W_i`` is the force at the
    last knot (the paper prints four blocks and lost a row).

    knots: Displacements of the knots [m], increasing, shape (N,).
    force: The virgin curve at the knots [N], shape (N,).
    Raises FricError: When the knots do not increase, or the curve is not concave there (a stiffness would be negative).
    """
    knots, force = np.asarray(knots, float), np.asarray(force, float)
    if len(knots) == 0 or (np.diff(knots, prepend=0.0) <= 0).any():
        raise FricError("the knots do not increase from zero", hint="Name them in order, as in '0.9 um, 26 um, 54 um'.")
    slopes = np.diff(force, prepend=0.0) / np.diff(knots, prepend=0.0)
    k = slopes - np.append(slopes[1:], 0.0)
    if (k <= 0).any():
        bad = int(np.flatnonzero(k <= 0)[0])
        raise FricError(
            f"the virgin curve does not get flatter at knot {bad + 1} ({knots[bad] * 1e6:.3g} µm), so its block would "
            "have no stiffness",
            hint="Move that knot, leave it out, or use `knots='auto'`.",
        )
    return Blocks(k, knots)


def fit_blocks(curve: VirginCurve, count: int, begun: list[Real] | None = None) -> Blocks:
    """Fit a concave piecewise-linear curve of ``count`` blocks by weighted least squares.

    The knots are placed one after the other where each helps most, and all moved each time: a global search (CRS2)
    behind that lowered the squares of 70 fits by 0.8 % at most. For given knots the stiffnesses are a non-negative
    least-squares problem, which makes the curve concave. A block that would not slip within the curve keeps its
    stiffness; its slip displacement is then where the curve reaches ``curve.level``.

    begun: Knots placed one after the other, by number of knots, shared with fits of other numbers of blocks.
    """
    extent = float(curve.displacement[-1])
    low, high = np.log(max(float(curve.displacement[0]), 1e-4 * extent)), np.log(extent)
    sliding = curve.saturates
    solved = _stiffnesses(curve, [] if sliding else [extent])
    free = count if sliding else count - 1
    knots = _placed(lambda x: solved(x)[1], low, high, free, [] if begun is None else begun) if free else np.zeros(0)
    knots = np.sort(knots)
    k, d = solved(knots)[0], np.exp(knots)
    if not sliding:
        left = curve.level - float(k[:-1] @ d)
        d = np.append(d, max(left / k[-1], extent) if k[-1] > 0 else extent)
    keep = k * d > LEAST_SHARE * float(k @ d)
    if not keep.any():
        raise FricError(
            "the virgin curve does not rise: what is left of the force is no friction",
            hint="Look at the sign and the units of the force, and at the plant whose inertia is taken off.",
        )
    return Blocks(k[keep], d[keep])


@dataclass(frozen=True)
class Choice:
    """The number of blocks that an information criterion chose, and the candidates."""

    candidates: tuple[Blocks, ...]  # The fit with 1, 2, … blocks
    rms: tuple[float, ...]  # Misfit of each [N]
    # Schwarz's criterion of each: the fewest blocks are chosen whose criterion is the least, to `STRONG`
    criterion: tuple[float, ...]
    spread: float  # Median spread that a point of the curve is given [N]
    unit: str = "N"  # Unit of the force, for messages

    @property
    def chosen(self) -> int:
        """Index of the chosen fit."""
        return simplest(self.criterion, STRONG)

    @property
    def blocks(self) -> Blocks:
        """The chosen fit."""
        return self.candidates[self.chosen]

    @property
    def reason(self) -> str:
        """Reason against more blocks, in a sentence."""
        chosen, count = self.chosen, self.chosen + 1
        if count == len(self.candidates):
            return f"{count} blocks fit best (information criterion), the most that were tried"
        return (
            f"{count} blocks: another lowers the misfit from {self.rms[chosen]:.2g} to {self.rms[count]:.2g} "
            f"{self.unit} rms, less than it is worth where friction repeats to {self.spread:.2g} {self.unit}"
        )


def choose_blocks(curve: VirginCurve, most: int = MOST_BLOCKS, unit: str = "N") -> Choice:
    """Choose the number of blocks by Schwarz's information criterion, ``BIC(N) = Σ r²/σ² + 2·N·ln n``.

    σ holds the scatter of the cycles, the blur of the encoder, and a floor of 0.5 % of the level (`REPEATABLE`).
    Without the floor, noise-free simulated cycles would separate two blocks that no drive repeats well enough to show.
    Points of the curve within one step of the encoder count as a single point: n is their number. The search ends when
    the criterion has risen twice.
    """
    standard_error = np.nan_to_num(curve.band, nan=0.0) / 2.0
    spread = np.sqrt(standard_error**2 + curve.blur**2 + (REPEATABLE * curve.level) ** 2)
    share = np.gradient(curve.displacement) / curve.step if curve.step else np.ones_like(spread)
    share = np.clip(share, 0.0, 1.0)
    number = float(share.sum())
    candidates, rms, criterion = [], [], []
    begun: list[Real] = []
    for count in range(1, most + 1):
        blocks = fit_blocks(curve, count, begun)
        residual = curve.force - blocks(curve.displacement)
        candidates.append(blocks)
        rms.append(float(np.sqrt(np.mean(residual**2))))
        criterion.append(float(share @ (residual / spread) ** 2 + 2 * count * np.log(number)))
        if count > 2 and criterion[-1] > criterion[-2] > criterion[-3]:
            break
    return Choice(tuple(candidates), tuple(rms), tuple(criterion), float(np.median(spread)), unit)


def fit_without_cycles(curve: VirginCurve, blocks: Blocks) -> list[Blocks]:
    """Return the fit with each cycle left out in turn, its knots moved from those of all cycles."""
    extent = float(curve.displacement[-1])
    inside = blocks.displacement < extent * (1 - 1e-9)
    start = np.log(blocks.displacement[inside])
    beyond = np.full(len(blocks) - len(start), extent)
    solved = _stiffnesses(curve, beyond)
    found = []
    for other in curve.without_cycles():
        knots = start
        if len(start):

            def cost(x: Real, force: Real = other.force) -> float:
                return solved(x, force)[1]

            knots = _moved(cost, start, start - 1.0, np.minimum(start + 1.0, np.log(extent)))
        k, _ = solved(knots, other.force)
        d = np.append(np.exp(knots), beyond)
        for n in range(len(start), len(d)):
            d[n] = max((curve.level - float(k[:n] @ d[:n])) / max(k[n], 1e-300), extent)
        found.append(Blocks(np.maximum(k, 1e-9 * k.max()), d))
    return found


def _stiffnesses(curve: VirginCurve, beyond: Sequence[float] | Real) -> Callable[..., tuple[Real, float]]:
    """Return the stiffnesses of blocks, and their misfit, as a function of the logarithms of their knots.

    beyond: Knots of further blocks, which are not searched [m].
    """
    weight = weights(curve)
    place, rows = curve.displacement[:, None], weight[:, None]

    def solved(knots: Real, force: Real = curve.force) -> tuple[Real, float]:
        d = np.append(np.exp(knots), beyond)
        limit, rest = nonnegative(rows * np.minimum(place / d, 1.0), weight * force, 100 * len(d))
        return limit / d, rest**2

    return solved


def _placed(cost: Callable[[Real], float], low: float, high: float, count: int, begun: list[Real]) -> Real:
    """Return the knots (logarithms) of least cost; see `fit_blocks`."""
    while len(begun) < count:  # add a knot where it helps most, then move all
        tried = (np.append(begun[-1] if begun else np.zeros(0), place) for place in np.linspace(low, high, 40))
        begun.append(_moved(cost, min(tried, key=cost), low, high))
    return _moved(cost, begun[count - 1], low, high)  # again with large steps, out of a flat valley


def _moved(cost: Callable[[Real], float], start: Real, low: Real | float, high: Real | float) -> Real:
    """Return the nearest minimum by NLopt's Sbplx (Rowan 1990) within bounds."""
    optimizer = nlopt.opt(nlopt.LN_SBPLX, len(start))
    optimizer.set_lower_bounds(low)
    optimizer.set_upper_bounds(high)
    optimizer.set_maxeval(500 * len(start))
    optimizer.set_xtol_abs(1e-7)
    optimizer.set_ftol_rel(1e-10)
    return minimised(optimizer, cost, np.clip(start, low, high))


def weights(curve: VirginCurve) -> Real:
    """Return a weight for each point of a virgin curve, the inverse of its spread [1/N], shape (n,).

    So that points at which the cycles agree by chance do not dominate the fit, the spread is at least the median spread
    and 0.02 % of the level; it includes the blur of the encoder.
    """
    spread = np.nan_to_num(curve.band, nan=0.0)
    floor = max(float(np.median(spread)), 2e-4 * abs(curve.level))
    return np.asarray(1.0 / np.sqrt(spread**2 + floor**2 + curve.blur**2))

"""How strokes scatter about a map: beyond their own noise, and single ones that stand off all others."""

from dataclasses import replace
from math import sqrt
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from fric.arrays import Mask, Real
from fric.errors import FricError
from fric.identify.static_map.stribeck_fit import Solution, StribeckProblem
from fric.statistics import robust_deviation

OUTLYING = 6.0
"""Standard deviations from the map beyond which a stroke is left out."""
REPEATED = 0.05
"""Ratio of speeds, less one, up to which two strokes repeat each other."""
SWUNG = 0.3
"""Share of what averaging over a swing does to a force that is its error: the swing is no sine."""
MOST_OUTLYING = 0.15
"""Share of the strokes that may be left out: where more stand off, it is the map that is wrong."""
STANDING = 5.0
"""Standard deviations from the map beyond which a stroke that is kept weighs by what it stands off."""
REPEATS = 1e-3
"""Share of the force to which friction repeats at best."""


class Fitted(NamedTuple):
    """A fit to strokes, and how they scatter."""

    problem: StribeckProblem  # What was minimised; the standard errors include all scatter
    solution: Solution  # Where the minimum is
    between: float  # Standard deviation of the strokes beyond their own errors [N]
    own: Real  # The own error of each stroke that is kept [N]
    kept: Mask  # Which strokes had a part, shape (n,)
    beyond: Real  # What single strokes stand off by beyond all that [N], 0 of most; one of each that is kept


def without_outliers(problem: StribeckProblem, certain: Real, *, fixed: bool) -> Fitted:
    """Fit the strokes, the one that stands off most left out, until none does."""
    whole, kept, own = problem, np.ones(len(problem.v), bool), problem.standard_error
    while True:
        swing = None if whole.swing is None else whole.swing[kept]
        problem = replace(whole, v=whole.v[kept], F=whole.F[kept], standard_error=own[kept], swing=swing)
        if problem.degrees_of_freedom < 1:
            raise FricError(
                f"{len(whole.v)} strokes cannot give {len(problem.free)} parameters",
                hint=f"Log strokes at {len(problem.free) + 1} speeds or more, or fix delta.",
            )
        solution, between = solve_with_scatter(problem, own[kept], fixed=fixed)
        if swing is not None and not fixed:
            swung = problem.model(solution.theta) - replace(problem, swing=None).model(solution.theta)
            own = own.copy()
            own[kept] = np.hypot(whole.standard_error[kept], SWUNG * swung)
            problem = replace(problem, standard_error=own[kept])
            solution, between = solve_with_scatter(problem, own[kept], fixed=fixed)
        worst = _outlying(problem, solution, certain, kept)
        if worst is None:
            break
        kept[worst] = False
    beyond = 0.0 * own[kept] if fixed else _beyond(problem, solution, own[kept])
    if beyond.any():
        own = own.copy()
        own[kept] = np.hypot(own[kept], beyond)
        solution, between = solve_with_scatter(replace(problem, standard_error=own[kept]), own[kept], fixed=fixed)
    problem = replace(problem, standard_error=np.sqrt(own[kept] ** 2 + between**2))
    return Fitted(problem, solution, between, own[kept], kept, beyond)


def _beyond(problem: StribeckProblem, solution: Solution, own: Real) -> Real:
    """Return by how much single strokes stand off a map that all others agree on [N], shape (n,).

    They are kept, for they may be the fall of a real drive, and weigh by what they stand off: an axis that hunts
    between the counts of its encoder sticks now and then, which its logged position does not show. That takes less
    force: where both directions take more at one speed, it is the map that is wrong there, and they weigh as all.
    """
    found = 0.0 * own
    least = np.maximum(own, REPEATS * float(np.median(np.abs(problem.F))))
    for _ in range(5):  # towards what most agree on, by Cauchy's weights: a few that stand off would bend the map
        residual = np.abs(problem.F - problem.model(solution.theta))
        error = np.hypot(np.maximum(least, robust_deviation(residual)), residual)
        solution = replace(problem, standard_error=error).solve()
    for _ in range(10):
        residual = np.abs(problem.F - problem.model(solution.theta))
        stands = residual > STANDING * np.maximum(least, robust_deviation(residual))
        stands &= ~_mirrored(problem, stands & (np.abs(problem.F) > np.abs(problem.model(solution.theta))))
        before, found = found, np.where(stands, residual, 0.0)
        if np.count_nonzero(stands) > MOST_OUTLYING * len(own):
            return 0.0 * own  # it is the map that is wrong
        if np.allclose(found, before, rtol=0.03):
            break
        error = np.hypot(own, found)
        solution, _ = solve_with_scatter(replace(problem, standard_error=error), error, fixed=False)
    return found


def _mirrored(problem: StribeckProblem, some: Mask) -> Mask:
    """Return which of some strokes have another of them beside them at their speed, in the other direction."""
    v = np.where(some, problem.v, np.nan)
    return np.asarray(np.any(np.abs(v[:, np.newaxis] + v) <= REPEATED * np.abs(v), axis=0))


def _outlying(problem: StribeckProblem, solution: Solution, own: Real, kept: Mask) -> int | None:
    """Return the stroke that stands off most, where it stands off map and neighbours beyond all measure."""
    if np.count_nonzero(~kept) >= MOST_OUTLYING * len(kept) or problem.degrees_of_freedom < 4:
        return None
    residual = np.abs(problem.F - problem.model(solution.theta))
    usual = robust_deviation(residual) + 1e-9 * float(np.abs(problem.F).max())
    measure = OUTLYING * np.maximum(usual, own[kept])
    for worst in np.argsort(-residual / measure):
        if residual[worst] <= measure[worst]:
            return None
        if _contradicted(problem, int(worst), float(measure[worst])):
            return int(np.flatnonzero(kept)[worst])
    return None


def _contradicted(problem: StribeckProblem, n: int, measure: float) -> bool:
    """Say whether the strokes beside one in speed, of its direction, contradict it.

    Between two others friction is between theirs, whatever the shape of its fall, to within the measure; two that
    repeat its speed are asked alone.
    """
    same = (np.sign(problem.v) == np.sign(problem.v[n])) & (np.arange(len(problem.v)) != n)
    apart = np.log(np.abs(problem.v) / np.abs(problem.v[n]))
    repeats = problem.F[same & (np.abs(apart) < REPEATED)]
    if len(repeats) > 1:
        return abs(float(problem.F[n] - np.median(repeats))) > measure
    below, above = np.flatnonzero(same & (apart < 0)), np.flatnonzero(same & (apart >= 0))
    if not (len(below) and len(above)):
        return False
    beside = [problem.F[below[np.argmax(apart[below])]], problem.F[above[np.argmin(apart[above])]]]
    return bool(problem.F[n] < min(beside) - measure or problem.F[n] > max(beside) + measure)


def solve_with_scatter(
    problem: StribeckProblem, own: Real, *, fixed: bool, start: Solution | None = None
) -> tuple[Solution, float]:
    """Minimise, estimate the variance between strokes from the residuals, and again until both agree.

    The search is local from ``start`` where that is given.
    """
    solution = problem.solve(start=start)
    variance = 0.0
    if fixed:
        return solution, variance
    for _ in range(30):
        residual = problem.F - problem.model(solution.theta)
        found = excess_variance(residual, own, problem.degrees_of_freedom)
        if abs(found - variance) <= 1e-8 * found:
            break
        variance = found
        again = replace(problem, standard_error=np.sqrt(own**2 + variance))
        solution = again.solve(start=None if start is None else solution)
    return solution, sqrt(variance)


def excess_variance(residual: Real, standard_error: Real, dof: int) -> float:
    """Return the variance between strokes [N²] that explains residuals larger than their standard errors.

    Paule and Mandel's (1982) estimate: the smallest q ≥ 0 with ``Σ r²/(se² + q) ≤ dof``.
    """

    def surplus(q: float) -> float:
        return float(np.sum(residual**2 / (standard_error**2 + q))) - dof

    if surplus(0.0) <= 0:
        return 0.0
    high = float(np.sum(residual**2)) / dof * (1 + 1e-6)
    return float(brentq(surplus, 0.0, high, xtol=1e-15 * high, rtol=1e-10))

"""Eq. (2) fitted to the forces of strokes: weights, scatter between strokes, intervals."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import sqrt
from typing import TYPE_CHECKING, Literal

import numpy as np
from scipy.optimize import brentq
from scipy.special import stdtrit

from fric.errors import FricError
from fric.estimate import Estimate
from fric.friction.stribeck import StaticMap
from fric.identify.strokes.averages import MAD_TO_SIGMA
from fric.identify.strokes.profile import profile_interval
from fric.identify.strokes.stribeck_fit import PARAMETERS, Solution, StribeckProblem
from fric.units import Motion, si_unit

if TYPE_CHECKING:
    from numpy.typing import NDArray

Weights = Literal["error", "equal"]

OUTLYING = 6.0
"""Standard deviations from the map beyond which a stroke is left out."""

MOST_OUTLYING = 0.15
"""Share of the strokes that may be left out: where more stand off, it is the map that is wrong."""

DIMENSIONS = {p.name: p.dimension for p in StaticMap.parameters} | {"offset": "force"}


@dataclass(frozen=True)
class SpeedPoint:
    """The friction force at one constant velocity, from one stroke.

    Parameters
    ----------
    velocity
        Velocity [m/s], signed.
    force
        Robust mean of the force [N], signed, the drive's own linear damping taken off where the plant is known.
    standard_error
        Its standard error [N], with autocorrelation.
    samples
        Samples it was taken from.
    settled
        False where the force had not settled by half of the stroke.
    record, start, stop
        Record, and the time in it [s] at which the steady stretch begins and ends.
    """

    velocity: float
    force: float
    standard_error: float
    samples: int
    record: str
    start: float
    stop: float
    settled: bool = True


@dataclass(frozen=True)
class MapFit:
    """Eq. (2) fitted to points of both directions, or of one.

    Parameters
    ----------
    problem, solution
        What was minimised, and where the minimum is; the standard errors include ``between``.
    estimates
        Each parameter with unit and 95 % interval; an infinite limit is one that the data do not set.
    covariance
        Linearised covariance of the free parameters, in the order of ``problem.free``.
    between
        Standard deviation of the strokes beyond their own noise [N].
    left_out
        Strokes that stand off all others, and had no part in the fit.
    """

    problem: StribeckProblem
    solution: Solution
    estimates: Mapping[str, Estimate]
    covariance: NDArray[np.float64]
    between: float
    left_out: tuple[SpeedPoint, ...] = ()

    @property
    def static_map(self) -> StaticMap:
        """The friction map, without the offset."""
        return StaticMap(**{name: value for name, value in self.solution.theta.items() if name != "offset"})

    @property
    def residual(self) -> NDArray[np.float64]:
        """Measured less fitted force [N] at each point."""
        return self.problem.F - self.problem.model(self.solution.theta)

    @property
    def rmse(self) -> float:
        """Root mean square residual [N]."""
        return float(np.sqrt(np.mean(self.residual**2)))

    @property
    def r2(self) -> float:
        """Coefficient of determination."""
        return 1.0 - float(np.sum(self.residual**2) / np.sum((self.problem.F - self.problem.F.mean()) ** 2))

    def predict(self, v: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the fitted force [N] at velocities v [m/s], and half the width of its 95 % band."""
        theta = self.solution.theta
        force = np.sign(v) * self.static_map.level(v) + theta["sigma"] * v + theta["offset"]
        J = self.problem.jacobian(theta, v)
        variance = np.einsum("ij,jk,ik->i", J, self.covariance, J)
        return force, stdtrit(self.problem.degrees_of_freedom, 0.975) * np.sqrt(np.maximum(variance, 0.0))


def fit_map(
    points: Sequence[SpeedPoint], delta: float | None, weights: Weights, motion: Motion, *, with_offset: bool
) -> MapFit:
    """Fit eq. (2) to strokes; each weighs by its own error and the scatter that all show beyond theirs.

    A stroke that stands off the map by more than `OUTLYING` times the median absolute residual of all (as a standard
    deviation), and its own error, is left out: a stroke that stuck and slipped, or a value typed by hand. It is told.

    Parameters
    ----------
    points
        The strokes.
    delta
        Shape factor [1] where it is fixed.
    weights
        ``error``, or ``equal`` for the same weight each.
    motion
        Linear or rotary, for the units.
    with_offset
        False where the offset is 0 by assumption.

    Raises
    ------
    FricError
        When there are too few strokes for the parameters.
    """
    v, F, own = np.array([(p.velocity, p.force, p.standard_error) for p in points]).T
    floor = 1e-9 * float(np.abs(F).max())
    own = np.full_like(F, float(np.std(F)) or 1.0) if weights == "equal" else np.maximum(own, floor)
    kept = np.ones(len(points), bool)
    while True:
        problem = StribeckProblem(v[kept], F[kept], own[kept], delta, with_offset)
        if problem.degrees_of_freedom < 1:
            raise FricError(
                f"{len(points)} strokes cannot give {len(problem.free)} parameters",
                mend=f"Log strokes at {len(problem.free) + 1} speeds or more, or fix delta.",
            )
        solution, between = _solve_with_scatter(problem, own[kept], fixed=weights == "equal")
        worst = _outlying(problem, solution, 0.0 * F if weights == "equal" else own, kept)
        if worst is None:
            break
        kept[worst] = False
    own = own[kept]
    problem = replace(problem, standard_error=np.sqrt(own**2 + between**2))
    scale = solution.cost / problem.degrees_of_freedom
    covariance = problem.covariance(solution) * scale
    errors = np.sqrt(np.diag(covariance))
    estimates = {}
    for name in PARAMETERS:
        unit, value = si_unit(DIMENSIONS[name], motion), float(solution.theta[name])
        if name not in problem.free:
            estimates[name] = Estimate(value, unit, fixed=name == "delta", assumed=name == "offset")
            continue
        interval = profile_interval(problem, solution, name, scale, float(errors[problem.free.index(name)]))
        estimates[name] = Estimate(value, unit, interval)
    left_out = tuple(point for point, used in zip(points, kept, strict=True) if not used)
    return MapFit(problem, solution, estimates, covariance, between, left_out)


def _outlying(
    problem: StribeckProblem, solution: Solution, own: NDArray[np.float64], kept: NDArray[np.bool_]
) -> int | None:
    """Return the stroke that stands off most, where it stands off the map beyond all measure."""
    if np.count_nonzero(~kept) >= MOST_OUTLYING * len(kept) or problem.degrees_of_freedom < 4:
        return None
    residual = np.abs(problem.F - problem.model(solution.theta))
    usual = MAD_TO_SIGMA * float(np.median(residual)) + 1e-9 * float(np.abs(problem.F).max())
    stands_off = residual / np.maximum(usual, own[kept])
    worst = int(np.argmax(stands_off))
    return int(np.flatnonzero(kept)[worst]) if stands_off[worst] > OUTLYING else None


def _solve_with_scatter(problem: StribeckProblem, own: NDArray[np.float64], *, fixed: bool) -> tuple[Solution, float]:
    """Minimise, estimate the variance between strokes from the residuals, and again until both agree."""
    solution = problem.solve()
    variance = 0.0
    if fixed:
        return solution, variance
    for _ in range(30):
        residual = problem.F - problem.model(solution.theta)
        found = excess_variance(residual, own, problem.degrees_of_freedom)
        if abs(found - variance) <= 1e-8 * found:
            break
        variance = found
        solution = replace(problem, standard_error=np.sqrt(own**2 + variance)).solve()
    return solution, sqrt(variance)


def excess_variance(residual: NDArray[np.float64], standard_error: NDArray[np.float64], dof: int) -> float:
    """Return the variance between strokes [N²] that explains residuals larger than their standard errors.

    Paule and Mandel's (1982) estimate: the smallest q ≥ 0 with ``Σ r²/(se² + q) ≤ dof``.
    """

    def surplus(q: float) -> float:
        return float(np.sum(residual**2 / (standard_error**2 + q))) - dof

    if surplus(0.0) <= 0:
        return 0.0
    high = float(np.sum(residual**2)) / dof
    return float(brentq(surplus, 0.0, high, xtol=1e-15 * high, rtol=1e-10))

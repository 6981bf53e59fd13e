"""Least squares of the static map, eq. (2), to forces at constant velocities: separable, bounded, globally safe.

For given v_s and delta eq. (2) is linear in the rest,

    F = F_c·sgn(v)·(1 - g) + F_s·sgn(v)·g + sigma·v + offset,   g = exp(-|v/v_s|^delta),

so the sum of squares is minimised over F_c, F_s, sigma and offset in closed form (non-negative least squares), and
only log v_s, and delta where it is free, are searched (variable projection; Golub and Pereyra 1973). That search is
global, by DIRECT-L (Gablonsky and Kelley 2001), because the projected sum can have more than one minimum; Brent's
method polishes it in one parameter, a simplex in two. Intervals are profiles of the same sum.
"""

from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property
from math import isfinite, sqrt
from typing import Any, NamedTuple, Self

import numpy as np
from scipy.optimize import brentq, minimize_scalar, nnls
from scipy.special import stdtrit

from fric.arrays import Mask, Real
from fric.errors import FricError
from fric.friction.stribeck import STATIC_PARAMETERS, stribeck_shares
from fric.records.over_strokes import REPEATED
from fric.search import minimised
from fric.statistics import excess_variance, of_one_size, robust_deviation

PARAMETERS = (*STATIC_PARAMETERS, "offset")
DELTA_RANGE = (0.3, 3.0)
V_S_BEYOND = 5.0  # v_s is searched from the lowest speed divided by this to the highest speed times this
Cost = Callable[[Real], float]
SWUNG = 0.3  # Share of what averaging over a swing does to a force that is its error: the swing is no sine
MOST_OUTLYING = 0.15  # Largest share of strokes that count as outliers: where more deviate, the map does not fit
OUTLYING = 5.0  # Standard deviations from the map beyond which the deviation of a stroke is in its weight
REPEATS = 1e-3  # Share of the force to which friction repeats at best


@dataclass(frozen=True)
class MapSolution:
    """A minimum of the weighted sum of squares: the parameters by name, and the sum."""

    theta: Mapping[str, float]
    cost: float


@dataclass(frozen=True)
class StribeckProblem:
    """Forces at constant velocities, and which parameters of eq. (2) are free."""

    v: Real  # Velocities [m/s], signed, shape (n,)
    F: Real  # Forces [N], signed, shape (n,)
    standard_error: Real  # Of each force [N], shape (n,)
    delta: float | None = 1.0  # The shape factor where it is fixed; None where it is free
    with_offset: bool = True  # False where no offset is fitted: one direction cannot separate it from F_c
    fall: bool = True  # False for Coulomb plus viscous friction alone, F_s = F_c
    swing: Real | None = None
    """Root mean square of the velocity about its mean over that mean, of each stroke, shape (n,); the force of a stroke
    is then the mean of eq. (2) along a sine of this size. None where no stroke swings."""
    offset: float = 0.0  # The offset where it is not fitted [N]
    strobed: Mask | None = None
    """Strokes that move by whole counts of the encoder a sample, shape (n,): in logs slower than the loop its answer to
    counts does not average out, and is alike in both directions. None where no stroke does."""

    @cached_property
    def _weighted_ones(self) -> tuple[Real, float]:
        """The weights over the root of the sum of their squares, shape (n,), and that root."""
        size = float(np.linalg.norm(1.0 / self.standard_error))
        return 1.0 / self.standard_error / size, size

    def of(self, some: Mask) -> Self:
        """Return the problem of some strokes."""
        swing = None if self.swing is None else self.swing[some]
        strobed = None if self.strobed is None else self.strobed[some]
        error = self.standard_error[some]
        return replace(self, v=self.v[some], F=self.F[some], standard_error=error, swing=swing, strobed=strobed)

    @property
    def free(self) -> tuple[str, ...]:
        """Names of the parameters that are fitted."""
        held = {"F_s", "v_s", "delta"} if not self.fall else set() if self.delta is None else {"delta"}
        return tuple(n for n in PARAMETERS if n not in (held if self.with_offset else held | {"offset"}))

    @property
    def degrees_of_freedom(self) -> int:
        """Points less free parameters."""
        return len(self.v) - len(self.free)

    def v_s_range(self) -> tuple[float, float]:
        """Return the range in which v_s is searched [m/s]."""
        speed = np.abs(self.v)
        return float(speed.min()) / V_S_BEYOND, float(speed.max()) * V_S_BEYOND

    def model(self, theta: Mapping[str, float]) -> Real:
        """Return the force of eq. (2), offset included [N], shape (n,)."""
        level = theta["F_c"] + (theta["F_s"] - theta["F_c"]) * self._shares(theta["v_s"], theta["delta"])
        return np.sign(self.v) * level + theta["sigma"] * self.v + theta["offset"]

    def swung(self, theta: Mapping[str, float]) -> Real:
        """Return what averaging over its swing changes of the force of each stroke [N], shape (n,)."""
        return (
            np.zeros_like(self.v) if self.swing is None else self.model(theta) - replace(self, swing=None).model(theta)
        )

    def _shares(self, v_s: float, delta: float) -> Real:
        """Return the remaining Stribeck rise at each stroke, averaged over its swing, shape (n,)."""
        if self.swing is None:
            return stribeck_shares(self.v, v_s, delta)
        nodes = np.cos(np.pi * (np.arange(8) + 0.5) / 8)  # of Gauss and Chebyshev: a sine spends its time so
        around = self.v[:, None] * (1 + np.sqrt(2) * self.swing[:, None] * nodes)
        return np.asarray(stribeck_shares(around, v_s, delta).mean(axis=1))

    def solve(self, held: Mapping[str, float] | None = None, start: MapSolution | None = None) -> MapSolution:
        """Return the minimum, with some parameters held at a value; local from ``start`` where that is given."""
        fixed = ({} if self.delta is None else {"delta": self.delta}) | dict(held or {})
        if not self.with_offset:
            fixed.setdefault("offset", self.offset)
        if not self.fall:
            fixed |= {"v_s": float(np.abs(self.v).min()), "delta": 1.0 if self.delta is None else self.delta}
        ends = {"v_s": np.log(self.v_s_range()), "delta": DELTA_RANGE}
        if not (searched := [name for name in ends if name not in fixed]):
            return self._project(fixed, fixed["v_s"], fixed["delta"])

        def at(x: Real) -> MapSolution:
            found = dict(zip(searched, x.tolist(), strict=True))
            v_s = fixed["v_s"] if "v_s" in fixed else float(np.exp(found["v_s"]))
            return self._project(fixed, v_s, (fixed | found)["delta"])

        def cost(x: Real) -> float:
            return at(x).cost

        lower, upper = np.array([ends[name] for name in searched]).T
        if start is None:
            most = 60 if len(searched) == 1 else 400
            x = minimised("GN_DIRECT_L", cost, (lower + upper) / 2, lower, upper, maxeval=most)
        else:
            near = {"v_s": np.log(start.theta["v_s"]), "delta": start.theta["delta"]}
            x = np.clip([near[name] for name in searched], lower, upper)
        return at(_polished(cost, x, lower, upper, near=start is not None))

    def _project(self, held: Mapping[str, float], v_s: float, delta: float) -> MapSolution:
        """Minimise over the linear parameters at given v_s and delta, with F_s ≥ F_c ≥ 0 and sigma ≥ 0."""
        sign, g = np.sign(self.v), self._shares(v_s, delta)
        F = self.F - held.get("offset", 0.0) - held.get("sigma", 0.0) * self.v
        if "F_s" in held and "F_c" not in held:
            F, columns = F - held["F_s"] * sign * g, {"F_c": sign * (1.0 - g)}  # from 0 to F_s
        else:
            F, columns = F - held.get("F_c", 0.0) * sign, {} if "F_c" in held else {"F_c": sign}
            columns |= {"rise": sign * g} if self.fall else {}  # F_s - F_c
        if "sigma" not in held:
            columns["sigma"] = self.v
        found = self._nonnegative(columns, F, "offset" not in held)
        if found.get("F_c", 0.0) > held.get("F_s", np.inf):
            F = F - held["F_s"] * columns.pop("F_c")
            found = self._nonnegative(columns, F, "offset" not in held) | {"F_c": held["F_s"]}
        F_c = held.get("F_c", found.get("F_c", 0.0))
        known = {"F_s": F_c + found.get("rise", 0.0), **found, **held, "F_c": F_c, "v_s": v_s, "delta": delta}
        return MapSolution({name: known[name] for name in PARAMETERS}, found["cost"])

    def _nonnegative(self, columns: Mapping[str, Real], F: Real, free_offset: bool) -> dict[str, float]:
        """Weighted non-negative least squares, with a free offset, if any, projected out first."""
        w, (ones, size) = 1.0 / self.standard_error, self._weighted_ones
        A, b = np.empty((len(w), len(columns))), F * w
        for n, column in enumerate(columns.values()):
            np.multiply(column, w, out=A[:, n])
        scale = np.sqrt(np.add.reduce(A * A, axis=0))
        scale[scale == 0] = 1.0
        A /= scale
        rest_A, rest_b = A, b
        if free_offset:
            rest_A, rest_b = A - ones[:, None] * (ones @ A), b - ones * (ones @ b)
        x = nonnegative(rest_A, rest_b, 3 * len(columns))[0] if columns else np.zeros(0)
        residual = rest_b - rest_A @ x
        found = dict(zip(columns, (x / scale).tolist(), strict=True)) | {"cost": float(residual @ residual)}
        if free_offset:
            found["offset"] = float(ones @ (b - A @ x)) / size
        return found

    def jacobian(self, theta: Mapping[str, float], v: Real | None = None) -> Real:
        """Return dF/d(free parameters) [SI], shape (n, len(free)), at the points or at other velocities."""
        v = self.v if v is None else v
        sign, ratio = np.sign(v), np.abs(v / theta["v_s"])
        power = ratio ** theta["delta"]
        g, rise = stribeck_shares(v, theta["v_s"], theta["delta"]), theta["F_s"] - theta["F_c"]
        with np.errstate(divide="ignore"):
            log_ratio = np.where(ratio > 0, np.log(ratio), 0.0)
        columns = {
            "F_c": sign * (1.0 - g) if self.fall else sign,
            "F_s": sign * g,
            "v_s": sign * rise * g * power * theta["delta"] / theta["v_s"],
            "delta": -sign * rise * g * power * log_ratio,
            "sigma": v,
            "offset": np.ones_like(v),
        }
        return np.column_stack([columns[name] for name in self.free])

    def inverse(self, solution: MapSolution) -> Real:
        """Return the change of the free parameters with each weighted force, to first order, shape (len(free), n)."""
        J, size = of_one_size(self.jacobian(solution.theta) / self.standard_error[:, None])
        return np.linalg.pinv(J, rcond=1e-7) / size[:, None]

    def covariance(self, solution: MapSolution) -> Real:
        """Return the linearised covariance of the free parameters for the given standard errors."""
        inverse = self.inverse(solution)
        return np.asarray(inverse @ inverse.T)  # of J, not of J'J: so no variance is negative


def profile_interval(
    problem: StribeckProblem, best: MapSolution, name: str, scale: float, guess: float
) -> tuple[float, float]:
    """Return the 95 % profile-likelihood interval of a parameter.

    The parameter is held, the rest minimised again, and the limits are where the sum of squares has risen by
    ``t²·scale`` (t: Student's quantile for the degrees of freedom; Bates and Watts 1988, ch. 6). A limit is the
    parameter's bound where that is reached first, and infinite where the data set none.

    ``scale`` is the variance of a residual in units of its standard error squared, ``guess`` the linearised standard
    error of the parameter, from which the search begins.
    """
    target = float(stdtrit(problem.degrees_of_freedom, 0.975)) ** 2 * scale
    best_value = best.theta[name]
    force = 10.0 * float(np.abs(problem.F).max())
    walls = {
        # searched up to here, and the limit where the data set none
        "F_c": ((0.0, force), (0.0, np.inf)),
        "F_s": ((0.0, force), (0.0, np.inf)),
        "v_s": (problem.v_s_range(), (0.0, np.inf)),
        "delta": (DELTA_RANGE, DELTA_RANGE),
        "sigma": ((0.0, force / float(np.abs(problem.v).max())), (0.0, np.inf)),
        "offset": ((-force, force), (-np.inf, np.inf)),
    }
    (low, high), physical = walls[name]
    searched = min(low, best_value), max(high, best_value)  # F_s beyond the slowest stroke may be far above all forces
    known = {best_value: (-np.sqrt(target), best)}

    def rise(value: float) -> float:
        if value not in known:  # each starts from the nearest solution
            found = problem.solve({name: value}, known[min(known, key=lambda other: abs(other - value))][1])
            known[value] = (np.sqrt(max(found.cost - best.cost, 0.0)) - np.sqrt(target), found)
        return float(known[value][0])

    limits = []
    for side in (-1, 1):
        wall = searched[side > 0]
        step = max(guess * np.sqrt(target), 1e-9 * abs(best_value), 1e-300)
        inner, outer = best_value, best_value
        for _ in range(60):
            outer = best_value + side * step
            if (outer - wall) * side >= 0:
                outer = wall
            if outer == wall or rise(outer) > 0:
                break
            inner, step = outer, step * 1.6
        if rise(outer) <= 0:
            limits.append(physical[side > 0])
        else:
            limits.append(float(brentq(rise, inner, outer, xtol=1e-3 * abs(outer - best_value))))
    return limits[0], limits[1]


def _polished(cost: Cost, start: Real, lower: Real, upper: Real, *, near: bool) -> Real:
    """Polish a minimum, by parabolas in a bracket (Brent 1973) or, of two coordinates, by NLopt's Subplex (Rowan 1990);
    a start that is near takes smaller steps. The sum of squares is quadratic: 1e-5 of log v_s is 1e-10 of the sum.
    """
    start, step = np.clip(start, lower, upper), (0.01 if near else 0.05) * (upper - lower)
    if len(start) == 1:
        away = step if start[0] + step[0] <= upper[0] else -step
        found = minimize_scalar(
            lambda x: cost(np.clip(np.array([x]), lower, upper)),
            bracket=(float(start[0]), float(start[0] + away[0])),
            method="brent",
            options={"xtol": (1e-5 if near else 1e-8) / max(float(np.abs(start[0])), 1.0)},
        )
        return np.clip(np.array([found.x]), lower, upper)
    within = 1e-5 if near else 1e-9
    return minimised("LN_SBPLX", cost, start, lower, upper, initial_step=step, xtol_abs=within, maxeval=2000)


_unchecked: Any = None
"""The function behind SciPy's, whose checks take 8 % of `identify gms`; the public one where another SciPy lacks it."""

with suppress(ImportError):
    from scipy.optimize._slsqplib import nnls as _unchecked


def nonnegative(A: Real, b: Real, most: int) -> tuple[Real, float]:
    """Return ``x ≥ 0`` of least ``|A·x - b|``, and that norm, by Lawson and Hanson's active sets.

    Raises RuntimeError: When that many are not enough.
    Raises ValueError: When a number of A or b is not finite.
    """
    A = np.ascontiguousarray(A)
    flat = A.ravel()
    if _unchecked is None or not (isfinite(flat @ flat) and isfinite(b @ b)):  # sums show it sooner than each number
        x, rest = nnls(A, b, maxiter=most)
        return x, float(rest)
    x, rest, state = _unchecked(A, b, most)
    if state == 3:
        raise RuntimeError("non-negative least squares did not end")
    return x, rest


class FittedMap(NamedTuple):
    """A fit to strokes, and how they scatter."""

    problem: StribeckProblem  # What was minimised; the standard errors include all scatter
    solution: MapSolution  # Where the minimum is
    between: float  # Standard deviation of the strokes beyond their errors [N]
    deviation: Real  # The error of each stroke [N], shape (n,)
    beyond: Real  # Deviation of single strokes beyond all that [N], mostly 0, shape (n,)
    errors: Real  # The error of each stroke without that deviation [N], shape (n,)


def fit_strokes(
    problem: StribeckProblem, *, fixed: bool, alike: bool = False, start: MapSolution | None = None
) -> FittedMap:
    """Fit the strokes; those that deviate from all others weigh less, but where weights are ``fixed`` or ``alike``.

    The search is local from ``start`` where that is given.
    """
    deviation, free, count = problem.standard_error, len(problem.free), len(problem.v)
    if problem.degrees_of_freedom < 1:
        hint = f"Log strokes at {free + 1} speeds or more, or fix delta."
        raise FricError(f"{count} strokes cannot give {free} parameters", hint=hint)
    if problem.swing is not None and not fixed:
        solution, _ = solve_with_scatter(problem, deviation, fixed=fixed, start=start)
        deviation = np.hypot(deviation, SWUNG * problem.swung(solution.theta))
        problem = replace(problem, standard_error=deviation)
    solution, between = solve_with_scatter(problem, deviation, fixed=fixed, start=start)
    errors, local = deviation, start is not None
    beyond = 0.0 * deviation if fixed or alike else _beyond(problem, solution, deviation, local=local)
    if beyond.any():
        deviation = np.hypot(deviation, beyond)
        again = replace(problem, standard_error=deviation)
        solution, between = solve_with_scatter(again, deviation, fixed=fixed, start=solution if local else None)
    problem = replace(problem, standard_error=np.hypot(deviation, between))
    return FittedMap(problem, solution, between, deviation, beyond, errors)


def _beyond(problem: StribeckProblem, solution: MapSolution, errors: Real, *, local: bool) -> Real:
    """Return the deviation of single strokes from a map that all others agree on [N], shape (n,).

    Their weight includes the deviation, so that what went wrong hardly counts, and the fall of a real drive still does.
    An axis that hunts between the counts of its encoder sticks now and then, which its logged position does not show.
    That takes less force: where both directions take more at one speed, the map is wrong there, and their weights stay,
    but for strokes that move by whole counts a sample.
    """
    found = 0.0 * errors
    least = np.maximum(errors, REPEATS * float(np.median(np.abs(problem.F))))
    for _ in range(5):  # towards what most agree on, by Cauchy's weights: a few outliers would bend the map
        residual = np.abs(problem.F - problem.model(solution.theta))
        error = np.hypot(np.maximum(least, robust_deviation(residual)), residual)
        solution = replace(problem, standard_error=error).solve(start=solution if local else None)
    for _ in range(10):
        residual = np.abs(problem.F - problem.model(solution.theta))
        outlying = residual > OUTLYING * np.maximum(least, robust_deviation(residual))
        more = outlying & (np.abs(problem.F) > np.abs(problem.model(solution.theta)))
        more &= True if problem.strobed is None else ~problem.strobed
        v = np.where(more, problem.v, np.nan)
        outlying &= ~np.any(np.abs(v[:, np.newaxis] + v) <= REPEATED * np.abs(v), axis=0)  # both directions take more
        before, found = found, np.where(outlying, residual, 0.0)
        if np.count_nonzero(outlying) > MOST_OUTLYING * len(errors):
            return 0.0 * errors  # the map does not fit
        if np.allclose(found, before, rtol=0.03):
            break
        error = np.hypot(errors, found)
        again = replace(problem, standard_error=error)
        solution, _ = solve_with_scatter(again, error, fixed=False, start=solution if local else None)
    return found


def solve_with_scatter(
    problem: StribeckProblem, errors: Real, *, fixed: bool, start: MapSolution | None = None
) -> tuple[MapSolution, float]:
    """Minimise, estimate the variance between strokes from the residuals, and again until both agree.

    The search is local from ``start`` where that is given.
    """
    solution = problem.solve(start=start)
    variance = 0.0
    if fixed:
        return solution, variance
    for _ in range(30):
        found = excess_variance(problem.F - problem.model(solution.theta), errors, problem.degrees_of_freedom)
        if abs(found - variance) <= 1e-8 * found:
            break
        variance = found
        again = replace(problem, standard_error=np.sqrt(errors**2 + variance))
        solution = again.solve(start=None if start is None else solution)
    return solution, sqrt(variance)

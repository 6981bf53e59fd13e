"""Eq. (2) fitted to the forces of strokes: weights, scatter between strokes, intervals."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import stdtrit

from fric.arrays import Real
from fric.estimate import Estimate
from fric.friction.stribeck import StaticMap
from fric.identify.static_map.forms import HeldOut, at_bound, chosen
from fric.identify.static_map.points import SpeedPoint
from fric.identify.static_map.scatter import Fitted, without_outliers
from fric.identify.static_map.stribeck_fit import PARAMETERS, Solution, StribeckProblem, profile_interval
from fric.identify.static_map.strokes import Asked, Strokes
from fric.units import si_unit

DIMENSIONS = {p.name: p.dimension for p in StaticMap.parameters} | {"offset": "force"}


@dataclass(frozen=True)
class MapFit:
    """Eq. (2) fitted to points of both directions, or of one."""

    asked: Asked  # What was asked for
    problem: StribeckProblem  # What was minimised; the standard errors include ``between``
    solution: Solution  # Where the minimum is
    estimates: Mapping[str, Estimate]
    """Each parameter with unit and 95 % interval; an infinite limit is one that the data do not set."""
    covariance: Real  # Linearised covariance of the free parameters, in the order of ``problem.free``
    between: float  # Standard deviation of the strokes beyond their own noise [N]
    held_out: HeldOut  # How well forms predict strokes that are held out
    left_out: tuple[SpeedPoint, ...] = ()  # Strokes that stand off all others, and had no part in the fit
    standing_off: tuple[tuple[SpeedPoint, float], ...] = ()
    """Strokes that stand off all others and had a part in the fit, each with by how much [N]; they weigh by it."""

    @property
    def static_map(self) -> StaticMap:
        """The friction map, without the offset; sigma is 0 where more damping was taken off than there is."""
        known = {name: value for name, value in self.solution.theta.items() if name != "offset"}
        return StaticMap(**known | {"sigma": max(known["sigma"], 0.0)})

    def describe_form(self, held_out: HeldOut) -> str:
        """Say which form the map has, and why: how well others do."""
        form = "eq. (2)" if self.problem.fall else "Coulomb plus viscous friction"
        form += " with delta free" if "delta" in self.problem.free else ""
        if len(tried := held_out.as_dict()) < 2:
            return form
        errors = [f"{self.asked.says(error, 'force')} {text}" for text, error in tried.items()]
        return f"{form} (errors at strokes held out: {', '.join(errors)})"

    @property
    def residual(self) -> Real:
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

    def predict(self, v: Real) -> tuple[Real, Real]:
        """Return the fitted force [N] at velocities v [m/s], and half the width of its 95 % band."""
        theta = self.solution.theta
        force = np.sign(v) * self.static_map.level(v) + theta["sigma"] * v + theta["offset"]
        J = self.problem.jacobian(theta, v)
        variance = np.einsum("ij,jk,ik->i", J, self.covariance, J)
        return force, stdtrit(self.problem.degrees_of_freedom, 0.975) * np.sqrt(np.maximum(variance, 0.0))


def solved(strokes: Strokes, offset: float | None) -> tuple[Fitted, HeldOut]:
    """Return the map of `fit_map` without intervals, and how well its forms predict strokes that are held out."""
    asked, F = strokes.asked, strokes.force
    own = np.array([point.standard_error for point in strokes.points])
    fixed = asked.weights == "equal"
    own = np.full_like(F, float(np.std(F)) or 1.0) if fixed else np.maximum(own, 1e-9 * float(np.abs(F).max()))
    shape = {"auto": 1.0, "free": None}[asked.delta] if isinstance(asked.delta, str) else asked.delta
    problem = StribeckProblem(
        strokes.velocity, F, own, shape, offset is None, asked.form != "coulomb", None, offset or 0.0
    )
    for into in strokes.into:
        problem = into(problem, strokes.points)
    fitted = without_outliers(problem, 0.0 * F if fixed else own, fixed=fixed)
    return chosen(fitted, fall=asked.form == "auto", shape=asked.delta == "auto", fixed=fixed)


def fit_map(strokes: Strokes, offset: float | None = None) -> MapFit:
    """Fit eq. (2) to strokes; each weighs by its own error and the scatter that all show beyond theirs.

    A stroke is left out where it stands off the map by more than `OUTLYING` times the median absolute residual of all
    (as a standard deviation), and its own error, and where the strokes of its direction next to it in speed, or those
    that repeat it, contradict it: the slowest and the fastest have none beside them, and are never left out for it.
    Single strokes that stand off and are kept weigh by what they stand off.

    Where Coulomb plus viscous friction predicts held-out strokes no worse, or a parameter of eq. (2) ends at its bound,
    that is taken: F_s = F_c and v_s are then assumed.

    The offset [N] is given where it is not fitted.

    Raises FricError: When there are too few strokes for the parameters.
    """
    fitted, held_out = solved(strokes, offset)
    left_out = tuple(point for point, used in zip(strokes.points, fitted.kept, strict=True) if not used)
    part = [point for point, used in zip(strokes.points, fitted.kept, strict=True) if used]
    standing = tuple((point, float(by)) for point, by in zip(part, fitted.beyond, strict=True) if by)
    estimates, covariance = _estimates(fitted, strokes.asked)
    estimates = _with_common_errors(estimates, fitted, strokes.together[:, fitted.kept])
    if strokes.asked.damping:
        fitted, estimates = _less_damping(fitted, estimates, strokes.asked)
    return MapFit(
        strokes.asked, fitted.problem, fitted.solution, estimates, covariance, fitted.between,
        replace(held_out, also=strokes.tried), left_out, standing,
    )  # fmt: skip


def widened(estimate: Estimate, by: Callable[[float], float], least: float = -np.inf) -> Estimate:
    """Return an estimate with each half of its interval made what a function gives of it, down to a least limit."""
    if not isinstance(estimate.ci95, tuple):
        return estimate
    value = float(estimate)
    below, above = (by(abs(float(limit) - value)) for limit in estimate.ci95)  # type: ignore[arg-type]
    return replace(estimate, ci95=(max(value - below, least), value + above))


def _estimates(fitted: Fitted, asked: Asked) -> tuple[dict[str, Estimate], Real]:
    problem, solution = fitted.problem, fitted.solution
    scale = solution.cost / problem.degrees_of_freedom
    if asked.weights != "equal":  # the errors of the strokes are known: chance may make a fit look better than they do
        scale = max(scale, 1.0)
    covariance = problem.covariance(solution) * scale
    errors = np.sqrt(np.diag(covariance))
    bounded = at_bound(problem, solution) if problem.fall else ()
    estimates = {}
    for name in PARAMETERS:
        unit, value = si_unit(DIMENSIONS[name], asked.motion), float(solution.theta[name])
        if name in problem.free:
            interval = profile_interval(problem, solution, name, scale, float(errors[problem.free.index(name)]))
            estimates[name] = Estimate(value, unit, interval, assumed=name in bounded)
        else:
            fixed = name == "delta" and problem.delta is not None
            estimates[name] = Estimate(value, unit, fixed=fixed, assumed=not fixed or name in bounded)
    return estimates, covariance


def _less_damping(fitted: Fitted, estimates: dict[str, Estimate], asked: Asked) -> tuple[Fitted, dict[str, Estimate]]:
    """Take the damping that the plant holds off what was fitted; sigma alone knows of it, and of its error."""
    theta, problem = dict(fitted.solution.theta), fitted.problem
    theta["sigma"] -= asked.damping
    solution = replace(fitted.solution, theta=theta)
    problem = replace(problem, F=problem.F - asked.damping * problem.v)
    one, value = estimates["sigma"], max(theta["sigma"], 0.0)
    if isinstance(one.ci95, tuple):
        below, above = (float(np.hypot(float(limit) - float(one), asked.damping_error)) for limit in one.ci95)  # type: ignore[arg-type]
        one = replace(one, ci95=(max(value - below, 0.0), max(value + above, 0.0)))
    sigma = replace(one, value=value)
    return fitted._replace(problem=problem, solution=solution), estimates | {"sigma": sigma}


def _with_common_errors(estimates: dict[str, Estimate], fitted: Fitted, together: Real) -> dict[str, Estimate]:
    """Widen the intervals by what the map moves where the forces of all strokes move together, by half widths [N]."""
    problem, solution = fitted.problem, fitted.solution
    thetas = [replace(problem, F=problem.F + shift).solve(start=solution).theta for shift in together if shift.any()]
    if not thetas:
        return estimates
    found = dict(estimates)
    for name in problem.free:
        shift = float(np.linalg.norm([theta[name] - float(estimates[name]) for theta in thetas]))
        least = 0.0 if name != "offset" else -np.inf
        found[name] = widened(estimates[name], lambda half, by=shift: float(np.hypot(half, by)), least)  # type: ignore[misc]
    return found

"""Eq. (2) fitted to the forces of strokes: weights, scatter between strokes, intervals."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from scipy.special import stdtrit

from fric.arrays import Real
from fric.estimate import Estimate
from fric.friction.stribeck import StaticMap
from fric.identify.static_map.forms import HeldOut, at_bound, chosen
from fric.identify.static_map.profile import profile_interval
from fric.identify.static_map.scatter import Fitted, without_outliers
from fric.identify.static_map.stribeck_fit import PARAMETERS, Solution, StribeckProblem
from fric.units import Motion, readable, si_unit

Weights = Literal["error", "equal"]
Form = Literal["auto", "coulomb", "stribeck"]
ShapeFactor = float | Literal["auto", "free"]

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
        Record, and the time in it [s] at which the steady segment begins and ends.
    swing
        Root mean square of the velocity about its mean over that mean [1]; 0 where it does not swing.
    over_position
        What was taken off the force because it comes again at the places of this stroke [N].
    onset
        Time in the record from which on it was at constant velocity [s], the force settling; ``start`` where None.
    rounding
        What steps in which the force was logged have of the standard error [N].
    """

    velocity: float
    force: float
    standard_error: float
    samples: int
    record: str
    start: float
    stop: float
    settled: bool = True
    swing: float = 0.0
    over_position: float = 0.0
    onset: float | None = None
    rounding: float = 0.0


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
    held_out
        How well forms predict strokes that are held out.
    left_out
        Strokes that stand off all others, and had no part in the fit.
    standing_off
        Strokes that stand off all others and had a part in the fit, each with by how much [N]; they weigh by it.
    """

    problem: StribeckProblem
    solution: Solution
    estimates: Mapping[str, Estimate]
    covariance: Real
    between: float
    held_out: HeldOut
    left_out: tuple[SpeedPoint, ...] = ()
    standing_off: tuple[tuple[SpeedPoint, float], ...] = ()

    @property
    def static_map(self) -> StaticMap:
        """The friction map, without the offset; sigma is 0 where more damping was taken off than there is."""
        known = {name: value for name, value in self.solution.theta.items() if name != "offset"}
        return StaticMap(**known | {"sigma": max(known["sigma"], 0.0)})

    def describe_form(self, motion: Motion, held_out: HeldOut | None = None) -> str:
        """Say which form the map has, and why: how well others do, of this map or as given."""
        form = "eq. (2)" if self.problem.fall else "Coulomb plus viscous friction"
        form += " with delta free" if "delta" in self.problem.free else ""
        tried = (held_out or self.held_out).as_dict()
        if len(tried) < 2:
            return form
        errors = [f"{readable(error, si_unit('force', motion), 3)} {text}" for text, error in tried.items()]
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


def solved(
    points: Sequence[SpeedPoint],
    delta: ShapeFactor,
    weights: Weights,
    *,
    with_offset: bool,
    form: Form,
    offset: float,
    damping: float,
) -> tuple[Fitted, HeldOut]:
    """Return the map of `fit_map` without intervals, and how well its forms predict strokes that are held out."""
    v, F, own, swing = np.array([(p.velocity, p.force, p.standard_error, p.swing) for p in points]).T
    floor = 1e-9 * float(np.abs(F).max())
    fixed = weights == "equal"
    own = np.full_like(F, float(np.std(F)) or 1.0) if fixed else np.maximum(own, floor)
    shape = {"auto": 1.0, "free": None}[delta] if isinstance(delta, str) else delta
    problem = StribeckProblem(
        v, F + damping * v, own, shape, with_offset, form != "coulomb",
        swing if np.any(swing > 0) and form != "coulomb" else None, offset,
    )  # fmt: skip
    fitted = without_outliers(problem, 0.0 * F if fixed else own, fixed=fixed)
    return chosen(fitted, fall=form == "auto", shape=delta == "auto", fixed=fixed)


def fit_map(
    points: Sequence[SpeedPoint],
    delta: ShapeFactor,
    weights: Weights,
    motion: Motion,
    *,
    with_offset: bool,
    form: Form = "auto",
    offset: float = 0.0,
    damping: float = 0.0,
    damping_error: float = 0.0,
    together: Real | None = None,
) -> MapFit:
    """Fit eq. (2) to strokes; each weighs by its own error and the scatter that all show beyond theirs.

    A stroke is left out where it stands off the map by more than `OUTLYING` times the median absolute residual of all
    (as a standard deviation), and its own error, and where the strokes of its direction next to it in speed, or those
    that repeat it, contradict it: the slowest and the fastest have none beside them, and are never left out for it.

    Single strokes that stand off and are kept weigh by what they stand off.

    Where Coulomb plus viscous friction predicts held-out strokes no worse, or a parameter of eq. (2) ends at its bound,
    that is taken: F_s = F_c and v_s are then assumed.

    Parameters
    ----------
    points
        The strokes.
    delta
        Shape factor [1], ``free`` to fit it, or ``auto`` for 1 unless it predicts held-out strokes better free.
    weights
        ``error``, or ``equal`` for the same weight each.
    motion
        Linear or rotary, for the units.
    with_offset
        False where the offset is not fitted.
    offset
        What it is then [N].
    damping, damping_error
        Damping [N·s/m] that was taken off the forces, and half its 95 % interval. What is left may be below 0 where it
        was too much: sigma is then 0, and the other parameters are what they are for any damping taken off.
    together
        Directions in which the forces of all points err together, half widths [N], shape (m, n).
    form
        ``coulomb`` for Coulomb plus viscous friction, ``stribeck`` for eq. (2), ``auto`` for what predicts better.

    Raises
    ------
    FricError
        When there are too few strokes for the parameters.
    """
    fitted, held_out = solved(
        points, delta, weights, with_offset=with_offset, form=form, offset=offset, damping=damping
    )
    left_out = tuple(point for point, used in zip(points, fitted.kept, strict=True) if not used)
    estimates, covariance = _estimates(fitted.problem, fitted.solution, motion, fixed_weights=weights == "equal")
    if together is not None:
        estimates = _with_common_errors(estimates, fitted.problem, fitted.solution, together[:, fitted.kept])
    if damping:
        fitted, estimates = _less_damping(fitted, estimates, damping, damping_error)
    part = [point for point, used in zip(points, fitted.kept, strict=True) if used]
    standing = tuple((point, float(by)) for point, by in zip(part, fitted.beyond, strict=True) if by)
    return MapFit(fitted.problem, fitted.solution, estimates, covariance, fitted.between, held_out, left_out, standing)


def _estimates(
    problem: StribeckProblem, solution: Solution, motion: Motion, *, fixed_weights: bool
) -> tuple[dict[str, Estimate], Real]:
    scale = solution.cost / problem.degrees_of_freedom
    if not fixed_weights:  # the errors of the strokes are known: chance may make a fit look better than they allow
        scale = max(scale, 1.0)
    covariance = problem.covariance(solution) * scale
    errors = np.sqrt(np.diag(covariance))
    estimates = {}
    for name in PARAMETERS:
        unit, value = si_unit(DIMENSIONS[name], motion), float(solution.theta[name])
        if name not in problem.free:
            fixed = name == "delta" and problem.delta is not None
            estimates[name] = Estimate(value, unit, fixed=fixed, assumed=not fixed)
            continue
        interval = profile_interval(problem, solution, name, scale, float(errors[problem.free.index(name)]))
        estimates[name] = Estimate(value, unit, interval)
    if problem.fall:
        for name in at_bound(problem, solution):
            estimates[name] = replace(estimates[name], assumed=True)
    return estimates, covariance


def _less_damping(
    fitted: Fitted, estimates: dict[str, Estimate], damping: float, error: float
) -> tuple[Fitted, dict[str, Estimate]]:
    """Take the damping that the plant holds off what was fitted; sigma alone knows of it, and of its error."""
    theta, problem = dict(fitted.solution.theta), fitted.problem
    theta["sigma"] -= damping
    solution = replace(fitted.solution, theta=theta)
    problem = replace(problem, F=problem.F - damping * problem.v)
    one, value = estimates["sigma"], max(theta["sigma"], 0.0)
    if isinstance(one.ci95, tuple):
        below, above = (float(np.hypot(float(limit) - float(one), error)) for limit in one.ci95)  # type: ignore[arg-type]
        one = replace(one, ci95=(max(value - below, 0.0), max(value + above, 0.0)))
    return fitted._replace(problem=problem, solution=solution), estimates | {
        "sigma": replace(one, value=max(value, 0.0))
    }


def _with_common_errors(
    estimates: dict[str, Estimate], problem: StribeckProblem, solution: Solution, moved: Real
) -> dict[str, Estimate]:
    """Widen the intervals by what the map moves where the forces of all strokes move together, by half widths [N]."""
    thetas = [replace(problem, F=problem.F + shift).solve(start=solution).theta for shift in moved if shift.any()]
    if not thetas:
        return estimates
    found = {}
    for name, one in estimates.items():
        found[name] = one
        if not isinstance(one.ci95, tuple) or name not in problem.free:
            continue
        value = float(one)
        below, above = (abs(float(limit) - value) for limit in one.ci95)  # type: ignore[arg-type]
        shift = float(np.linalg.norm([theta[name] - value for theta in thetas]))
        least = 0.0 if name != "offset" else -np.inf
        low, high = value - float(np.hypot(below, shift)), value + float(np.hypot(above, shift))
        found[name] = replace(one, ci95=(max(low, least), high))
    return found

"""Eq. (2) fitted to the forces of strokes: weights, scatter between strokes, intervals."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal, NamedTuple

import numpy as np
from scipy.special import stdtrit

from fric.estimate import Estimate
from fric.friction.stribeck import StaticMap
from fric.identify.static_map.profile import profile_interval
from fric.identify.static_map.scatter import Fitted, solve_with_scatter, without_outliers
from fric.identify.static_map.stribeck_fit import PARAMETERS, Solution, StribeckProblem
from fric.units import Motion, readable, si_unit

if TYPE_CHECKING:
    from numpy.typing import NDArray

Weights = Literal["error", "equal"]
Form = Literal["auto", "coulomb", "stribeck"]

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


class HeldOut(NamedTuple):
    """Weighted root mean square error at strokes that are held out [N], of eq. (2) and without its fall."""

    stribeck: float
    coulomb: float


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
    held_out
        How well the two forms predict strokes that are held out, where one was chosen by it.
    standing_off
        Strokes that stand off all others and had a part in the fit, each with by how much [N]; they weigh by it.
    """

    problem: StribeckProblem
    solution: Solution
    estimates: Mapping[str, Estimate]
    covariance: NDArray[np.float64]
    between: float
    left_out: tuple[SpeedPoint, ...] = ()
    held_out: HeldOut | None = None
    standing_off: tuple[tuple[SpeedPoint, float], ...] = ()

    @property
    def static_map(self) -> StaticMap:
        """The friction map, without the offset; sigma is 0 where more damping was taken off than there is."""
        known = {name: value for name, value in self.solution.theta.items() if name != "offset"}
        return StaticMap(**known | {"sigma": max(known["sigma"], 0.0)})

    def form_told(self, motion: Motion) -> str:
        """Say which form the map has, and why."""
        form = "eq. (2)" if self.problem.fall else "Coulomb plus viscous friction"
        if self.held_out is None:
            return form
        falling, plain = (readable(error, si_unit("force", motion), 3) for error in self.held_out)
        return f"{form} (strokes held out: {falling} off by eq. (2), {plain} without its fall)"

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
    points: Sequence[SpeedPoint],
    delta: float | None,
    weights: Weights,
    motion: Motion,
    *,
    with_offset: bool,
    form: Form = "auto",
    offset: float = 0.0,
    damping: float = 0.0,
    damping_error: float = 0.0,
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
        Shape factor [1] where it is fixed.
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
    form
        ``coulomb`` for Coulomb plus viscous friction, ``stribeck`` for eq. (2), ``auto`` for what predicts better.

    Raises
    ------
    FricError
        When there are too few strokes for the parameters.
    """
    v, F, own, swing = np.array([(p.velocity, p.force, p.standard_error, p.swing) for p in points]).T
    floor = 1e-9 * float(np.abs(F).max())
    own = np.full_like(F, float(np.std(F)) or 1.0) if weights == "equal" else np.maximum(own, floor)
    problem = StribeckProblem(
        v, F + damping * v, own, delta, with_offset, form != "coulomb",
        swing if np.any(swing > 0) and form != "coulomb" else None, offset,
    )  # fmt: skip
    fitted = without_outliers(problem, 0.0 * F if weights == "equal" else own, fixed=weights == "equal")
    held_out = None
    if form == "auto":
        simple = replace(fitted.problem, fall=False, swing=None, standard_error=fitted.own)
        solution, between = solve_with_scatter(simple, fitted.own, fixed=weights == "equal")
        simple = replace(simple, standard_error=np.sqrt(fitted.own**2 + between**2))
        held_out = HeldOut(_press(fitted.problem, fitted.solution), _press(simple, solution))
        if held_out.coulomb <= held_out.stribeck or _at_bound(fitted.problem, fitted.solution):
            fitted = fitted._replace(problem=simple, solution=solution, between=between)
    left_out = tuple(point for point, used in zip(points, fitted.kept, strict=True) if not used)
    estimates, covariance = _estimates(fitted.problem, fitted.solution, motion, fixed_weights=weights == "equal")
    if damping:
        fitted, estimates = _less_damping(fitted, estimates, damping, damping_error)
    part = [point for point, used in zip(points, fitted.kept, strict=True) if used]
    standing = tuple((point, float(by)) for point, by in zip(part, fitted.beyond, strict=True) if by)
    return MapFit(fitted.problem, fitted.solution, estimates, covariance, fitted.between, left_out, held_out, standing)


def _estimates(
    problem: StribeckProblem, solution: Solution, motion: Motion, *, fixed_weights: bool
) -> tuple[dict[str, Estimate], NDArray[np.float64]]:
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
        for name in _at_bound(problem, solution):
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


def _at_bound(problem: StribeckProblem, solution: Solution) -> tuple[str, ...]:
    """Return the parameters of the fall that end at a bound: it is then not seen."""
    theta, (low, high) = solution.theta, problem.v_s_range()
    if theta["F_s"] <= theta["F_c"] * (1 + 1e-9):
        return ("F_s", "v_s")
    return (("F_c",) if theta["F_c"] <= 0.0 else ()) + (
        ("v_s",) if theta["v_s"] <= low * 1.001 or theta["v_s"] >= high / 1.001 else ()
    )


def _press(problem: StribeckProblem, solution: Solution) -> float:
    """Return the root mean square of held-out strokes' residuals [N], by their leverage (Allen 1974: PRESS)."""
    J = problem.jacobian(solution.theta) / problem.standard_error[:, None]
    size = np.linalg.norm(J, axis=0)
    Q = np.linalg.svd(J[:, size > 0] / size[size > 0], full_matrices=False)
    leverage = np.sum(Q.U[:, 1e-9 * Q.S.max() < Q.S] ** 2, axis=1)
    residual = (problem.F - problem.model(solution.theta)) / np.maximum(1 - leverage, 1e-3)
    weight = 1 / problem.standard_error**2
    return float(np.sqrt(np.sum(weight * residual**2) / np.sum(weight)))

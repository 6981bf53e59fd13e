"""Identification of the static friction map, eq. (2), from records at constant velocity (Section 3.1.1)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import isinf, sqrt
from typing import TYPE_CHECKING, Literal

import numpy as np
from scipy.stats import chi2
from scipy.stats import t as student

from fric.errors import FricError
from fric.estimate import Estimate, Interval
from fric.friction.stribeck import StaticMap
from fric.identify.averages import Average, average
from fric.identify.segments import steady_stretches
from fric.identify.stribeck_fit import (
    PARAMETERS,
    Solution,
    StribeckProblem,
    excess_variance,
    profile_interval,
)
from fric.units import Motion, readable, si_unit

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from fric.drive.plant import Plant
    from fric.log import Log

Direction = Literal["both", "each"]
Weights = Literal["error", "equal"]

DIMENSIONS = {p.name: p.dimension for p in StaticMap.parameters} | {"offset": "force"}
CORRELATED = 0.95


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
    """

    problem: StribeckProblem
    solution: Solution
    estimates: Mapping[str, Estimate]
    covariance: NDArray[np.float64]
    between: float

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
        return force, student.ppf(0.975, self.problem.degrees_of_freedom) * np.sqrt(np.maximum(variance, 0.0))


@dataclass(frozen=True)
class StaticFit:
    """What `identify_static` found.

    Parameters
    ----------
    axis, motion
        The axis.
    points
        Every steady stroke.
    static
        The map of both directions, or of the positive one; None where one speed alone was logged.
    negative
        The negative direction's own map where each direction was asked for.
    at_speed
        Where one speed alone was logged: ``velocity`` and ``force`` there.
    warnings
        What the data cannot tell.
    method
        How the fit was made, in words.
    """

    axis: str
    motion: Motion
    points: tuple[SpeedPoint, ...]
    static: MapFit | None
    negative: MapFit | None
    at_speed: Mapping[str, Estimate]
    warnings: tuple[str, ...]
    method: str


def identify_static(
    logs: Sequence[Log],
    *,
    plant: Plant | None = None,
    delta: float | None = 1.0,
    direction: Direction = "both",
    weights: Weights = "error",
    average: Average = "robust",
) -> StaticFit:
    """Identify the static friction map, eq. (2), from strokes at constant velocity.

    Each steady stretch gives one point: velocity, robust mean force, standard error. Strokes scatter beyond their
    noise (temperature, lubrication, place); the variance between them is estimated with the map, added to each
    point's own, and so weights and intervals know it. Intervals are by profile likelihood.

    Parameters
    ----------
    logs
        Records of one axis, each with one or many strokes.
    plant
        Where given, the drive's own linear damping ``K_f·(A/B)·v`` is taken off the force first.
    delta
        Stribeck shape factor [1], or None to fit it.
    direction
        ``both``: one map and an offset; ``each``: a map for each direction.
    weights
        ``error``: by standard error and scatter between strokes; ``equal``: every stroke the same.
    average
        ``robust`` (Huber) or ``median`` force of a stretch.

    Raises
    ------
    FricError
        When there is no steady stroke, or there are too few speeds for the parameters.
    """
    points = steady_points(logs, average=average, plant=plant)
    axis, motion = logs[0].axis, logs[0].motion
    method = (
        f"eq. (2) by separable least squares; weights {weights}; average {average}; direction {direction}; "
        + ("drive damping taken off; " if plant else "")
        + "95 % intervals by profile likelihood"
    )
    speeds = {round(abs(p.velocity), 12) for p in points}
    if np.ptp(np.abs([p.velocity for p in points])) <= 0.02 * max(speeds):
        at_speed, warning = _one_speed(points, motion)
        return StaticFit(axis, motion, tuple(points), None, None, at_speed, (warning,), method)

    warnings: list[str] = []
    positive, backward = [p for p in points if p.velocity > 0], [p for p in points if p.velocity < 0]
    if direction == "each":
        if not (positive and backward):
            raise FricError(
                "only one direction was measured", mend="Log strokes in both directions, or use --direction both."
            )
        mirrored = [replace(p, velocity=-p.velocity, force=-p.force) for p in backward]
        static = _fit(positive, delta, weights, motion, with_offset=False)
        negative = _fit(mirrored, delta, weights, motion, with_offset=False)
        warnings += [f"positive direction: {text}" for text in _doubts(static, motion)]
        warnings += [f"negative direction: {text}" for text in _doubts(negative, motion)]
        return StaticFit(axis, motion, tuple(points), static, negative, {}, tuple(warnings), method)
    if not (positive and backward):
        warnings.append(
            "only one direction was measured: an offset of the force channel cannot be told from Coulomb friction, "
            "and 0 is assumed. Log strokes in both directions."
        )
    fit = _fit(points, delta, weights, motion, with_offset=bool(positive and backward))
    if plant is not None:
        warnings += _damping_doubt(fit, plant, motion)
    return StaticFit(axis, motion, tuple(points), fit, None, {}, tuple(warnings + _doubts(fit, motion)), method)


def steady_points(logs: Sequence[Log], *, average: Average = "robust", plant: Plant | None = None) -> list[SpeedPoint]:
    """Return one point for each steady stretch of the records, by velocity.

    Raises
    ------
    FricError
        When a record logged no force, or none holds a steady stroke.
    """
    stated = [log for log in logs if log.kind == "constant-velocity"]
    points = [point for log in stated or logs for point in _points_of(log, average, plant)]
    if not points:
        raise FricError(
            "no stroke at constant velocity was found",
            where=logs[0].source,
            mend="Log strokes long enough to settle at constant velocity; `fric inspect` shows what is there.",
        )
    return sorted(points, key=lambda point: point.velocity)


def _points_of(log: Log, method: Average, plant: Plant | None) -> list[SpeedPoint]:
    force = log.require("force", "the friction map")
    points = []
    for stretch in steady_stretches(log):
        mean = average(force[stretch.start : stretch.stop], method)
        damping = plant.K_f * plant.A / plant.B * stretch.velocity if plant else 0.0
        points.append(
            SpeedPoint(
                stretch.velocity,
                mean.value - damping,
                mean.standard_error,
                stretch.stop - stretch.start,
                log.name,
                float(log.time[stretch.start]),
                float(log.time[stretch.stop - 1]),
            )
        )
    return points


def _fit(
    points: Sequence[SpeedPoint], delta: float | None, weights: Weights, motion: Motion, *, with_offset: bool
) -> MapFit:
    v, F, own = np.array([(p.velocity, p.force, p.standard_error) for p in points]).T
    floor = 1e-9 * float(np.abs(F).max())
    own = np.full_like(F, float(np.std(F)) or 1.0) if weights == "equal" else np.maximum(own, floor)
    problem = StribeckProblem(v, F, own, delta, with_offset)
    if problem.degrees_of_freedom < 1:
        raise FricError(
            f"{len(points)} strokes cannot give {len(problem.free)} parameters",
            mend=f"Log strokes at {len(problem.free) + 1} speeds or more, or fix delta.",
        )
    solution, between = _solve_with_scatter(problem, own, fixed=weights == "equal")
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
    return MapFit(problem, solution, estimates, covariance, sqrt(between**2))


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


def _one_speed(points: Sequence[SpeedPoint], motion: Motion) -> tuple[dict[str, Estimate], str]:
    sign = np.sign([p.velocity for p in points])
    F, error = np.array([(p.force, p.standard_error) for p in points]).T * np.array([sign, np.ones_like(sign)])
    speed = float(np.mean(np.abs([p.velocity for p in points])))
    value = float(np.mean(F))
    within = float(np.sqrt(np.sum(error**2))) / len(F)
    across = float(np.std(F, ddof=1)) / sqrt(len(F)) if len(F) > 1 else 0.0
    half = max(1.96 * within, float(student.ppf(0.975, len(F) - 1)) * across if len(F) > 1 else 0.0)
    at_speed = {
        "velocity": Estimate(speed, si_unit("velocity", motion)),
        "force": Estimate(value, si_unit("force", motion), (value - half, value + half)),
    }
    told = readable(speed, si_unit("velocity", motion))
    return at_speed, f"one speed alone was logged ({told}): the friction there is given, and no map."


def _damping_doubt(fit: MapFit, plant: Plant, motion: Motion) -> list[str]:
    damping = plant.K_f * plant.A / plant.B
    interval = fit.estimates["sigma"].ci95
    if fit.solution.theta["sigma"] > 0 or interval is None:
        return []
    told = readable(damping, si_unit("viscous", motion))
    return [f"sigma is 0 after the drive's own damping of {told} was taken off: is the plant's A or K_f too large?"]


def _doubts(fit: MapFit, motion: Motion) -> list[str]:
    """Say what the data cannot tell about a fitted map."""
    problem, theta = fit.problem, fit.solution.theta
    doubts: list[str] = []
    slowest = float(np.abs(problem.v).min())
    told = readable(slowest, si_unit("velocity", motion))
    if theta["F_s"] <= theta["F_c"] * (1 + 1e-9):
        doubts.append(
            f"F_s sits at its bound F_c: friction does not fall with speed down to {told}; v_s means nothing here."
        )
    elif any(isinf(limit) or limit == 0.0 for name in ("F_s", "v_s") for limit in _interval(fit, name)):
        doubts.append(
            f"the data do not reach the Stribeck range: F_s and v_s are not settled by strokes from {told} up. "
            "Log slower strokes."
        )
    doubts += _correlations(fit)
    own_scatter = float(np.sum(fit.residual**2 / (problem.standard_error**2 - fit.between**2)))
    if fit.between and chi2.sf(own_scatter, problem.degrees_of_freedom) < 0.01:
        spread = readable(fit.between, si_unit("force", motion), 2)
        doubts.append(f"strokes scatter by {spread} beyond their own noise; weights and intervals allow for it.")
    visible = fit.rmse > 1e-6 * float(np.abs(problem.F).max())
    if visible and _patterned(problem.v, fit.residual / problem.standard_error):
        doubts.append(
            "the residuals are not noise, they follow the speed: eq. (2) does not describe these strokes wholly. "
            "Try --delta free or --direction each, and look at the figure."
        )
    return doubts


def _interval(fit: MapFit, name: str) -> Interval:
    low, high = fit.estimates[name].ci95 or (0.0, 0.0)
    assert isinstance(low, float)
    assert isinstance(high, float)
    return low, high


def _correlations(fit: MapFit) -> list[str]:
    size = np.sqrt(np.diag(fit.covariance))
    free = fit.problem.free
    with np.errstate(invalid="ignore", divide="ignore"):
        correlation = fit.covariance / np.outer(size, size)
    return [
        f"{free[i]} and {free[j]} are correlated by {correlation[i, j]:+.3f}: the data tell them apart badly."
        for i in range(len(free))
        for j in range(i)
        if abs(correlation[i, j]) > CORRELATED
    ]


def _patterned(v: NDArray[np.float64], residual: NDArray[np.float64]) -> bool:
    """Test whether residuals in the order of velocity are smoother than noise (von Neumann's ratio, 1 % level)."""
    n = len(v)
    if n < 8:
        return False
    r = residual[np.argsort(v)]
    ratio = float(np.sum(np.diff(r) ** 2) / np.sum((r - r.mean()) ** 2))
    return (ratio - 2.0) / sqrt(4.0 * (n - 2) / (n**2 - 1)) < -2.33

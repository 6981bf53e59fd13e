"""Eq. (2) fitted to the forces of strokes: weights, scatter between strokes, intervals."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from math import exp, hypot, log
from typing import NamedTuple, Self

import numpy as np
from scipy.optimize import least_squares
from scipy.special import fdtrc, stdtrit

from fric.arrays import Mask, Real
from fric.estimate import NORMAL_97_5, TWOFOLD, Covariance, Estimate
from fric.friction.stribeck import StaticMap, stribeck_shares
from fric.identify.static_map import stribeck_fit
from fric.identify.static_map.points import Asked, SpeedPoint, Strokes
from fric.identify.static_map.stribeck_fit import FittedMap, MapSolution, StribeckProblem
from fric.records.over_strokes import REPEATED
from fric.search import simplest
from fric.statistics import supposed
from fric.units import si_unit

CLEARLY = 0.8  # Ratio of errors below which a free shape factor is used: with stick-slip it is correlated with F_s
LIKELY = 0.2  # Chance by noise below which a free shape factor that fits better is in the intervals of one supposed
EXACT = 1e-20  # Least variance of a residual over that of the forces: they are rounded to 1e-10
UNSEEN = (0.5, 1.0, 2.0, 4.0)  # v_s over the lowest speed, of falls that the strokes may not show
EVEN = 0.5  # Chance that a shape factor is what is supposed, where strokes are predicted no better with another
NO_SINE = 4.0  # Times what averaging over a sine does, that averaging over sticking and slipping may do
LEAST_RISE = 1e-6  # Least rise of F_s with age, as a share of F_s
DIFFERENT = 1e-3  # Probability of such a gain by chance below which a richer form is used
FEWEST = 8  # Least number of strokes for a richer form
GROUPS = 10  # Number of groups of strokes that are left out in turn for an interval
DESCRIPTIONS = {  # Names of the forms, in the order in which they are reported
    "stribeck": "by eq. (2)",
    "coulomb": "without the Stribeck fall",
    "delta": "with delta free",
    "ages": "with an F_s that ages",
    "each": "by a map for each direction",
}
DIMENSIONS = {p.name: p.dimension for p in StaticMap.parameters} | {"offset": "force"}


def weighted_rms(weight: Real, errors: Real) -> float:
    """Return the weighted root mean square of errors [N]."""
    return float(np.sqrt(np.sum(weight * errors**2) / np.sum(weight)))


def predicts_better(weight: Real, plain: Real, rich: Real) -> bool:
    """Return whether the errors of a richer form at held-out strokes [N] are smaller, beyond one standard error.

    Breiman, Friedman, Olshen and Stone (1984): one in two hundred parameters that are not needed passes.
    """
    n, gain = len(weight), weight * (plain**2 - rich**2)
    return bool(n >= FEWEST and gain.sum() > np.sqrt(n / (n - 1)) * np.linalg.norm(gain - gain.mean()))


@dataclass(frozen=True)
class HeldOut:
    """Errors of forms at held-out strokes, weighted as in the fit."""

    weight: Real  # Of each stroke [1/N²], shape (n,)
    form: str  # The form that the map has
    errors: Mapping[str, Real]  # By form, the error at each stroke while it is held out [N], shape (n,)
    ages: float | None = None  # Growth of F_s for each factor e of the age of the contact [N], if that predicts best
    also: Mapping[str, float] = field(default_factory=dict)  # Errors of further forms [N], by name

    def __getitem__(self, form: str) -> float:
        """Return the weighted root mean square error of a form [N]."""
        return weighted_rms(self.weight, self.errors[form])

    def entered(self, form: str, errors: Real) -> Self:
        """Return the errors with those of another form [N]."""
        return replace(self, errors={**self.errors, form: errors})

    def better(self, rich: str) -> bool:
        """Return whether a richer form predicts better than that of the map, beyond one standard error."""
        return predicts_better(self.weight, self.errors[self.form], self.errors[rich])

    def as_dict(self) -> dict[str, float]:
        """Return the errors of all forms [N], by name."""
        return {text: self[form] for form, text in DESCRIPTIONS.items() if form in self.errors} | dict(self.also)


def _misfit(problem: StribeckProblem, solution: MapSolution) -> tuple[Real, Real]:
    return problem.F - problem.model(solution.theta), problem.jacobian(solution.theta)


def by_leverage(problem: StribeckProblem, residual: Real, jacobian: Real) -> Real:
    """Return residuals [N] of held-out strokes by their leverage (Allen 1974: PRESS), shape (n,)."""
    leverage = np.sum(_directions(problem, jacobian) ** 2, axis=1)
    return np.asarray(residual / np.maximum(1 - leverage, 1e-3))


def clearly_better(
    tried: HeldOut, rich: str, more: int, problem: StribeckProblem, misfits: Sequence[tuple[Real, Real]],
    swings: Mask | None = None,
) -> bool:  # fmt: skip
    """Return whether a richer form predicts clearly better than that of the map with as many parameters ``more``.

    Its errors at held-out strokes are smaller; its sum of squares is smaller by more than noise in the forces explains
    (F test), which few strokes do not tell by themselves; and it predicts speeds that are held out. ``misfits`` are
    the residuals [N] and the Jacobian of the map and of the richer form, shapes (n,) and (n, p); ``swings``: what the
    swing of a stroke explains.
    """
    without, within = (float(np.sum((residual / problem.standard_error) ** 2)) for residual, _ in misfits)
    free = max(problem.degrees_of_freedom - more, 1)
    chance = fdtrc(more, free, free / more * max(without / max(within, 1e-300) - 1.0, 0.0))
    clearly = tried.better(rich) and tried[rich] < CLEARLY * tried[tried.form] and chance < DIFFERENT
    return bool(
        clearly and _at_other_speeds(problem, misfits, np.zeros(len(problem.v), bool) if swings is None else swings)
    )


def _at_other_speeds(problem: StribeckProblem, misfits: Sequence[tuple[Real, Real]], swings: Mask) -> bool:
    """Return whether a richer form predicts clearly better when all strokes of a speed are held out together: by its
    place, or steps of the force, both directions may deviate at one speed, so that a stroke predicts the other. What a
    stroke that swings misses by no more than its swing does is not held out, where eight other speeds are.
    """
    speed = np.abs(problem.v)
    order = np.argsort(speed)
    alike = np.split(order, 1 + np.flatnonzero(np.diff(np.log(speed[order])) > np.log1p(REPEATED)))
    if sum(steady := [not swings[group].any() for group in alike]) >= FEWEST:
        alike = [group for group, even in zip(alike, steady, strict=True) if even]
    squares: list[list[float]] = []
    for residual, jacobian in misfits:
        U, r = _directions(problem, jacobian), residual / problem.standard_error
        squares.append([])
        for array in alike:
            left, axes = np.linalg.eigh(np.eye(len(array)) - U[array] @ U[array].T)
            squares[-1].append(float(np.sum((axes.T @ r[array] / np.maximum(left, 1e-3)) ** 2)))
    without, within = np.array(squares)
    gain, n = without - within, len(alike)
    spread = np.sqrt(n / (n - 1)) * np.linalg.norm(gain - gain.mean()) if n > 1 else np.inf
    return bool(gain.sum() > spread and within.sum() < CLEARLY**2 * without.sum())


def _directions(problem: StribeckProblem, jacobian: Real) -> Real:
    """Return an orthonormal basis of the changes of weighted points by a fit, shape (n, p)."""
    J = jacobian / problem.standard_error[:, None]
    size = np.linalg.norm(J, axis=0)
    Q = np.linalg.svd(J[:, size > 0] / size[size > 0], full_matrices=False)
    return np.asarray(Q.U[:, 1e-9 * Q.S.max() < Q.S])


def at_bound(problem: StribeckProblem, solution: MapSolution) -> tuple[str, ...]:
    """Return the parameters of the fall that end at a bound, so that the fall is not determined."""
    theta, (low, high) = solution.theta, problem.v_s_range()
    if theta["F_s"] <= theta["F_c"] * (1 + 1e-9):
        return ("F_s", "v_s")
    return (("F_c",) if theta["F_c"] <= 0.0 else ()) + (
        ("v_s",) if theta["v_s"] <= low * 1.001 or theta["v_s"] >= high / 1.001 else ()
    )


def chosen(fitted: FittedMap, *, fall: bool, shape: bool, fixed: bool) -> tuple[FittedMap, HeldOut]:
    """Return a fit of eq. (2) in the form that predicts held-out strokes best, and the errors of all forms.

    It has no ``fall`` if that is allowed and predicts no worse, or not clearly worse than a fall that ends at a bound;
    its ``shape`` factor is free if that is allowed and predicts better, and nothing ends at a bound. All strokes have
    equal weights if ``fixed``.
    """
    plain, solution = fitted.problem, fitted.solution
    name = "stribeck" if plain.fall else "coulomb"
    held_out = HeldOut(1 / plain.standard_error**2, name, {name: by_leverage(plain, *_misfit(plain, solution))})
    if fall and plain.fall:
        simple = _solved(fitted, replace(plain, fall=False, swing=None), None, fixed=fixed)
        held_out = held_out.entered("coulomb", by_leverage(simple.problem, *_misfit(simple.problem, simple.solution)))
        plainer = replace(held_out, form="coulomb")
        misfits = _misfit(simple.problem, simple.solution), _misfit(plain, solution)
        open_fall = at_bound(plain, solution) and not clearly_better(plainer, "stribeck", 2, plain, misfits)
        if open_fall or not simplest([held_out["coulomb"], held_out["stribeck"]]):
            held_out, fitted = plainer, simple
    if not fitted.problem.fall:
        return fitted, held_out
    if plain.swing is None and fitted.between > 0 and plain.degrees_of_freedom >= 5:
        held_out = _with_ageing(plain, solution, held_out)
    if (shape or held_out.ages is not None) and plain.degrees_of_freedom - (plain.delta is not None) >= 3:
        return _with_shape(fitted, held_out, shape=shape, fixed=fixed)
    return fitted, held_out


def _with_ageing(plain: StribeckProblem, solution: MapSolution, held_out: HeldOut) -> HeldOut:
    """Return the errors of eq. (2) with an F_s that ages, and the ageing if that is clearly better."""
    ageing = aged(plain, solution)
    tried = held_out.entered("ages", by_leverage(plain, ageing.residual, ageing.jacobian))
    misfits = _misfit(plain, solution), (ageing.residual, ageing.jacobian)
    # two parameters more: the rise, and the speed at which it begins
    return replace(tried, ages=ageing.rise) if clearly_better(tried, "ages", 2, plain, misfits) else tried


def _with_shape(fitted: FittedMap, held_out: HeldOut, *, shape: bool, fixed: bool) -> tuple[FittedMap, HeldOut]:
    """Return the fit, with its shape factor free if allowed and clearly better, and its errors."""
    plain, solution = fitted.problem, fitted.solution
    freed = _solved(fitted, replace(plain, delta=None), solution, fixed=fixed)
    misfits = _misfit(plain, solution), _misfit(freed.problem, freed.solution)
    tried = held_out.entered("delta", by_leverage(freed.problem, *misfits[1]))
    if tried.ages is not None and not simplest([tried["delta"], tried["ages"]]):
        tried = replace(tried, ages=None)
    low, high = stribeck_fit.DELTA_RANGE
    inside = low * 1.01 < freed.solution.theta["delta"] < high / 1.01 and not at_bound(freed.problem, freed.solution)
    swings = explained(freed.problem, freed.solution.theta, misfits[1][0])
    if shape and tried.ages is None and inside and clearly_better(tried, "delta", 1, plain, misfits, swings):
        if swings.any():  # which weigh as much less as they miss
            missed = np.where(swings, misfits[1][0], 0.0)
            fitted = fitted._replace(deviation=np.hypot(fitted.deviation, missed))
            freed = _solved(fitted, replace(plain, delta=None), freed.solution, fixed=fixed)
        return freed, replace(tried, form="delta")
    return fitted, tried


def explained(problem: StribeckProblem, theta: Mapping[str, float], residual: Real) -> Mask:
    """Return the strokes whose swing explains what they miss [N]: a few times what averaging over a sine does."""
    most = NO_SINE * np.abs(problem.swung(theta))
    return np.asarray(most > np.maximum(np.abs(residual), 1e-12 * most.max()))


def _solved(fitted: FittedMap, problem: StribeckProblem, start: MapSolution | None, *, fixed: bool) -> FittedMap:
    """Return the fit of another form to the strokes of a fit."""
    problem = replace(problem, standard_error=fitted.deviation)
    solution, between = stribeck_fit.solve_with_scatter(problem, fitted.deviation, fixed=fixed, start=start)
    problem = replace(problem, standard_error=np.hypot(fitted.deviation, between))
    return fitted._replace(problem=problem, solution=solution, between=between)


def each_direction(problem: StribeckProblem, solution: MapSolution, damping: float) -> Real | None:
    """Return the errors at held-out strokes of a map for each direction, with the offset of both [N].

    None where there are too few strokes for that. The subtracted damping [N·s/m] may exceed the true damping.
    """
    errors = np.empty_like(problem.F)
    for sign in (1.0, -1.0):
        same = np.sign(problem.v) == sign
        side = problem.of(same)
        side = replace(side, F=side.F + damping * side.v, with_offset=False, offset=float(solution.theta["offset"]))
        if side.degrees_of_freedom < 2:
            return None
        errors[same] = by_leverage(side, *_misfit(side, side.solve(start=solution)))
    return errors


class Ageing(NamedTuple):
    """Eq. (2) with an F_s that ages, fitted to strokes: ``F_s·(1 + growth·ln(1 + v_a/|v|))`` in place of F_s.

    In steady sliding the contact is renewed every ``distance``, and its age is ``distance/|v|`` (A. Ruina, Journal of
    Geophysical Research 88, 1983, p. 10359).
    """

    rise: float  # What F_s grows by with each factor e of the age, of contacts that are old [N]
    residual: Real  # Measured less fitted force [N], shape (n,)
    jacobian: Real  # Its derivatives by all free parameters but for their sign, each scaled, shape (n, p)


def aged(problem: StribeckProblem, solution: MapSolution) -> Ageing:
    """Fit eq. (2) with an F_s that ages, to strokes that do not swing, from eq. (2) without ageing."""
    theta, speed, sign = solution.theta, np.abs(problem.v), np.sign(problem.v)
    slowest = float(speed.min())
    level = theta["F_s"] or 1.0
    scale = np.array([theta["F_c"] or 1.0, level, level, level / float(speed.max()), level])

    def force(x: Real) -> Real:
        F_c, F_s, rise, sigma, offset = x[:5] * scale
        v_s, v_a = np.exp(x[5:])
        g = stribeck_shares(problem.v, v_s, theta["delta"])
        level = F_c * (1 - g) + (F_s + rise * np.log1p(v_a / speed)) * g
        return np.asarray(sign * level + sigma * problem.v + offset * problem.with_offset)

    def misfit(x: Real) -> Real:
        return (problem.F - (0.0 if problem.with_offset else problem.offset) - force(x)) / problem.standard_error

    low, high = np.log(problem.v_s_range())
    start = [theta["F_c"], theta["F_s"], 0.03 * theta["F_s"], theta["sigma"], theta["offset"]] / scale
    lower = [0.0, 0.0, 0.0, 0.0, -np.inf, low, np.log(0.1 * slowest)]
    upper = [np.inf] * 5 + [high, np.log(100 * slowest)]
    begin = np.clip([*start, np.log(theta["v_s"]), np.log(2 * slowest)], lower, upper)
    tight = 1e-12
    found = least_squares(misfit, begin, bounds=(lower, upper), x_scale="jac", ftol=tight, xtol=tight, gtol=tight)
    error, jacobian = problem.standard_error, np.asarray(found.jac)
    if found.x[2] < LEAST_RISE:  # at its bound neither the rise nor the speed at which it begins is free
        jacobian = np.delete(jacobian, [2, 6], axis=1)
    return Ageing(float(found.x[2] * scale[2]), found.fun * error, jacobian * error[:, None])


@dataclass(frozen=True)
class MapFit:
    """Eq. (2) fitted to points of both directions, or of one."""

    asked: Asked  # The arguments
    problem: StribeckProblem  # What was minimised; the standard errors include ``between``
    solution: MapSolution  # Where the minimum is
    estimates: Mapping[str, Estimate]  # Each parameter with unit and 95 % interval; an infinite limit is not determined
    covariance: Covariance  # Linearised covariance of the free parameters, and of a shape factor that is supposed
    between: float  # Standard deviation of the strokes beyond their noise [N]
    held_out: HeldOut  # How well forms predict strokes that are held out
    standing_off: tuple[tuple[SpeedPoint, float], ...] = ()  # Strokes of less weight, and deviation from the others [N]

    @property
    def static_map(self) -> StaticMap:
        """The friction map, without the offset; sigma is 0 where the subtracted damping exceeds the true damping."""
        known = {name: value for name, value in self.solution.theta.items() if name != "offset"}
        return StaticMap(**known | {"sigma": max(known["sigma"], 0.0)})

    def describe_form(self, held_out: HeldOut) -> str:
        """Return the notice on the form of the map, with the errors of the others."""
        form = "eq. (2)" if self.problem.fall else "Coulomb plus viscous friction"
        form += " with delta free" if "delta" in self.problem.free else ""
        if len(tried := held_out.as_dict()) < 2:
            return form
        errors = [f"{self.asked.says(error, 'force')} {text}" for text, error in tried.items()]
        return f"{form} (rms error at strokes left out of the fit: {', '.join(errors)})"

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
        problem = replace(self.problem, delta=None) if "delta" in self.covariance.names else self.problem
        J = problem.jacobian(theta, v)
        variance = np.einsum("ij,jk,ik->i", J, np.array(self.covariance.matrix), J)
        return force, stdtrit(self.problem.degrees_of_freedom, 0.975) * np.sqrt(np.maximum(variance, 0.0))


def solved(strokes: Strokes, offset: float | None, *, alike: bool = False) -> tuple[FittedMap, HeldOut]:
    """Return the map of `fit_map` without intervals, and the errors of its forms at held-out strokes."""
    asked, F = strokes.asked, strokes.force
    errors = np.array([point.standard_error for point in strokes.points])
    fixed = asked.weights == "equal"
    errors = np.full_like(F, float(np.std(F)) or 1.0) if fixed else np.maximum(errors, 1e-9 * float(np.abs(F).max()))
    shape = {"auto": 1.0, "free": None}[asked.delta] if isinstance(asked.delta, str) else asked.delta
    problem = StribeckProblem(
        strokes.velocity, F, errors, shape, offset is None, asked.form != "coulomb", None, offset or 0.0
    )
    for into in strokes.into:
        problem = into(problem, strokes.points)
    fitted = stribeck_fit.fit_strokes(problem, fixed=fixed, alike=alike)
    return chosen(fitted, fall=asked.form == "auto", shape=asked.delta == "auto", fixed=fixed)


def fit_map(strokes: Strokes, offset: float | None = None) -> MapFit:
    """Fit eq. (2) to strokes, weighted by their errors and their scatter beyond these.

    The weight of a stroke that deviates from all others includes its deviation.

    If Coulomb plus viscous friction predicts held-out strokes no worse, or not clearly worse than an eq. (2) of which a
    parameter ends at its bound, that form is used: F_s = F_c and v_s are then assumed.

    The offset [N] is fixed if given.
    """
    fitted, held_out = solved(strokes, offset)
    standing = tuple((point, float(by)) for point, by in zip(strokes.points, fitted.beyond, strict=True) if by)
    estimates, covariance = _estimates(fitted, strokes.asked)
    estimates = _with_common_errors(_with_weights(estimates, fitted), fitted, strokes.together)
    if strokes.asked.delta == "auto" and {"v_s"} == {"v_s", "delta"} & {*fitted.problem.free}:
        known = strokes.asked.weights != "equal"
        estimates, covariance = _with_supposed_shape(estimates, covariance, fitted, errors_known=known)
    if strokes.asked.form == "auto" and not fitted.problem.fall:
        estimates, covariance = _with_unseen_fall(estimates, covariance, fitted)
    if strokes.asked.damping:
        fitted, estimates = _less_damping(fitted, estimates, strokes.asked)
    return MapFit(
        strokes.asked, fitted.problem, fitted.solution, estimates, covariance, fitted.between,
        replace(held_out, also=strokes.tried), standing,
    )  # fmt: skip


def widened(estimate: Estimate, by: Callable[[float], float], least: float = -np.inf) -> Estimate:
    """Return an estimate with each half of its interval mapped by a function, down to a least limit."""
    if not isinstance(estimate.ci95, tuple):
        return estimate
    value = float(estimate)
    below, above = (by(abs(float(limit) - value)) for limit in estimate.ci95)  # type: ignore[arg-type]
    return replace(estimate, ci95=(max(value - below, least), value + above))


def _wider(
    estimates: Mapping[str, Estimate], halves: Mapping[str, float], both: Callable[[float, float], float]
) -> dict[str, Estimate]:
    """Return the estimates with each half of an interval made one with another; only an offset may be below 0."""
    wider = {
        name: widened(estimates[name], partial(both, half), -np.inf if name == "offset" else 0.0)
        for name, half in halves.items()
    }
    return {**estimates, **wider}


def _estimates(fitted: FittedMap, asked: Asked) -> tuple[dict[str, Estimate], Covariance]:
    problem, solution = fitted.problem, fitted.solution
    scale = solution.cost / problem.degrees_of_freedom
    if asked.weights != "equal":  # the errors of the strokes are known: chance may make a fit look better than they do
        scale = max(scale, 1.0)
    covariance = problem.covariance(solution) * scale
    errors = np.sqrt(np.diag(covariance))
    bounded = at_bound(problem, solution) if problem.fall else ()
    estimates = {}
    for name in stribeck_fit.PARAMETERS:
        unit, value = si_unit(DIMENSIONS[name], asked.motion), float(solution.theta[name])
        if name in problem.free:
            interval = stribeck_fit.profile_interval(
                problem, solution, name, scale, float(errors[problem.free.index(name)])
            )
            estimates[name] = Estimate(value, unit, interval, assumed=name in bounded)
        else:
            fixed = name == "delta" and problem.delta is not None
            estimates[name] = Estimate(value, unit, fixed=fixed, assumed=not fixed or name in bounded)
    return estimates, Covariance.of(problem.free, covariance, "linear")


def _with_supposed_shape(
    estimates: dict[str, Estimate], covariance: Covariance, fitted: FittedMap, *, errors_known: bool
) -> tuple[dict[str, Estimate], Covariance]:
    """Return intervals and covariance that include the error of the shape factor, which is supposed to be 1.

    It is 1 with a chance `EVEN`; else its logarithm is c·`TWOFOLD`, c ~ N(0, 1), and the map at c is linear from c = 0
    to -1 and to 1, where it is solved again; towards the smaller squares, a parabola has their slope at the fit and
    meets those of that solution. The second moment of the moves is that at the two values of `supposed`, and beside it
    that of the move to the free factor, where that is better by more than noise likely explains (`LIKELY`, F test): no
    chance before the data is known for factors that far off.

    F_s and v_s, which may lie below all strokes, also hold their intervals with the factors at the ends of what is
    supposed (95 %), where the sum of squares there is not larger by more than noise explains (profile likelihood).
    """
    problem, solution, sides = fitted.problem, fitted.solution, (-1.0, 1.0)
    given, freed = problem.delta or 1.0, replace(problem, delta=None)
    solved = [replace(problem, delta=given * exp(c * TWOFOLD)).solve(start=solution) for c in sides]
    scale = max(solution.cost / problem.degrees_of_freedom, 1.0 if errors_known else EXACT)
    column = freed.jacobian(solution.theta)[:, freed.free.index("delta")] * given * TWOFOLD
    slope = -2.0 * float(np.sum(column * (problem.F - problem.model(solution.theta)) / problem.standard_error**2))
    toward = solved[int(slope < 0.0)].cost
    values = supposed(-slope / (2.0 * scale), max(toward - solution.cost + abs(slope), 0.0) / scale, EVEN)
    moves = np.array([[side.theta[name] - solution.theta[name] for name in freed.free] for side in solved])
    moved = [abs(c) * moves[int(c > 0.0)] for c in values]
    moment, free = TWOFOLD**2 * float(np.mean(np.square(values))), freed.solve(start=solution)
    dof = max(freed.degrees_of_freedom, 1)
    if fdtrc(1, dof, dof * max(solution.cost / max(free.cost, 1e-300) - 1.0, 0.0)) < LIKELY:
        moved.append(2**0.5 * np.array([free.theta[name] - solution.theta[name] for name in freed.free]))
        moment += log(free.theta["delta"] / given) ** 2
    matrix = np.transpose(moved) @ moved / 2.0
    seen, far = [freed.free.index(name) for name in covariance.names], NORMAL_97_5 * moment**0.5
    halves = dict(zip(freed.free, NORMAL_97_5 * np.sqrt(np.diag(matrix)), strict=True))
    unknown = moment > (0.5 * TWOFOLD) ** 2  # the strokes tell less than half of what is supposed
    delta = Estimate(given, "1", (given * exp(-far), given * exp(far)), assumed=unknown)
    estimates = _wider(estimates, halves, hypot) | {"delta": delta}
    for c in (-NORMAL_97_5, NORMAL_97_5):
        shaped = replace(problem, delta=given * exp(c * TWOFOLD))
        side = shaped.solve(start=solution)
        if side.cost - min(solution.cost, side.cost) < float(stdtrit(problem.degrees_of_freedom, 0.975)) ** 2 * scale:
            for name in ("F_s", "v_s"):
                known, guess = estimates[name].limits, estimates[name].half_width / NORMAL_97_5
                limits = stribeck_fit.profile_interval(shaped, side, name, scale, guess)
                estimates[name] = replace(estimates[name], ci95=(min(limits[0], known[0]), max(limits[1], known[1])))
    matrix[np.ix_(seen, seen)] += np.array(covariance.matrix)
    return estimates, Covariance.of(freed.free, matrix, "linear")


def _with_unseen_fall(
    estimates: dict[str, Estimate], covariance: Covariance, fitted: FittedMap
) -> tuple[dict[str, Estimate], Covariance]:
    """Return intervals and covariance that include the end of a fall below the slowest strokes.

    Their forces hold a rest of it, which a map without a fall takes for F_c and less sigma. The second moment of the
    moves is that to falls of v_s around the lowest speed (`UNSEEN`, equally likely), each with the F_s that fits best.
    """
    falling, slowest = replace(fitted.problem, fall=True), float(np.abs(fitted.problem.v).min())
    names, known = covariance.names, fitted.solution.theta
    falls = [falling.solve({"v_s": share * slowest, "delta": known["delta"]}).theta for share in UNSEEN]
    moves = np.array([[theta[name] - known[name] for name in names] for theta in falls])
    matrix = moves.T @ moves / len(moves)
    halves = dict(zip(names, NORMAL_97_5 * np.sqrt(np.diag(matrix)), strict=True))
    return _wider(estimates, halves, hypot), Covariance.of(names, matrix + np.array(covariance.matrix), "linear")


def _with_weights(estimates: dict[str, Estimate], fitted: FittedMap) -> dict[str, Estimate]:
    """Return intervals that allow for the choice of the strokes that weigh less: by the jackknife, if there are any.

    Which strokes are outliers depends on the sample: the fit is repeated without each of ten groups, every tenth stroke
    by speed. Where a tenth of the strokes is 5.5 standard deviations off, intervals of v_s hold in 90 % of sessions,
    and in 83 % by the errors of the strokes alone.
    """
    problem, groups = fitted.problem, min(GROUPS, len(fitted.deviation))
    if not fitted.beyond.any() or problem.degrees_of_freedom <= -(-len(fitted.deviation) // groups):
        return estimates
    group, thetas = np.argsort(np.argsort(np.abs(problem.v), kind="stable")) % groups, []
    for some in (group != n for n in range(groups)):
        part = replace(problem.of(some), standard_error=fitted.errors[some])
        left = stribeck_fit.fit_strokes(part, fixed=False, start=fitted.solution)
        thetas.append([left.solution.theta[name] for name in problem.free])
    spread = np.sqrt((groups - 1) / groups * np.sum((np.array(thetas) - np.mean(thetas, axis=0)) ** 2, axis=0))
    return _wider(estimates, dict(zip(problem.free, float(stdtrit(groups - 1, 0.975)) * spread, strict=True)), max)


def _less_damping(
    fitted: FittedMap, estimates: dict[str, Estimate], asked: Asked
) -> tuple[FittedMap, dict[str, Estimate]]:
    """Subtract the damping of the plant from the fit; only sigma changes, with its error."""
    theta, problem = dict(fitted.solution.theta), fitted.problem
    theta["sigma"] -= asked.damping
    solution = replace(fitted.solution, theta=theta)
    problem = replace(problem, F=problem.F - asked.damping * problem.v)
    estimate, value = estimates["sigma"], max(theta["sigma"], 0.0)
    if isinstance(estimate.ci95, tuple):
        below, above = (float(np.hypot(float(limit) - float(estimate), asked.damping_error)) for limit in estimate.ci95)  # type: ignore[arg-type]
        estimate = replace(estimate, ci95=(max(value - below, 0.0), max(value + above, 0.0)))
    return fitted._replace(problem=problem, solution=solution), estimates | {"sigma": replace(estimate, value=value)}


def _with_common_errors(estimates: dict[str, Estimate], fitted: FittedMap, together: Real) -> dict[str, Estimate]:
    """Widen the intervals by the change of the map when the forces of all strokes shift by half-widths [N]."""
    problem, solution = fitted.problem, fitted.solution
    thetas = [replace(problem, F=problem.F + shift).solve(start=solution).theta for shift in together if shift.any()]
    if not thetas:
        return estimates
    moved = {name: [theta[name] - float(estimates[name]) for theta in thetas] for name in problem.free}
    return _wider(estimates, {name: float(np.linalg.norm(by)) for name, by in moved.items()}, hypot)

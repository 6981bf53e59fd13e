"""Which form a map has, by how well it predicts strokes that are held out.

A richer form is taken where its squared errors at strokes that are held out are smaller by more than one standard error
of that (Breiman, Friedman, Olshen and Stone 1984): of parameters that are not needed one in two hundred passes.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import NamedTuple, Self

import numpy as np
from scipy.optimize import least_squares

from fric.arrays import Real
from fric.choice import simplest
from fric.friction.stribeck import stribeck_shares
from fric.identify.static_map.scatter import REPEATED, Fitted, solve_with_scatter
from fric.identify.static_map.stribeck_fit import DELTA_RANGE, Solution, StribeckProblem

CLEARLY = 0.8
"""Ratio of errors under which a free shape factor is taken: it trades with F_s at slow strokes that stick and slip."""
LEAST_RISE = 1e-6
"""Rise of F_s with age, as a share of F_s, under which F_s does not age."""
FEWEST = 8
"""Strokes from which on a richer form is asked for."""
DESCRIPTIONS = {
    "stribeck": "by eq. (2)",
    "coulomb": "without its fall",
    "delta": "with delta free",
    "ages": "with an F_s that ages",
    "each": "by a map for each direction",
}
"""What the forms are called, in the order in which they are told."""


def weighted_rms(weight: Real, errors: Real) -> float:
    """Return the weighted root mean square of errors [N]."""
    return float(np.sqrt(np.sum(weight * errors**2) / np.sum(weight)))


def predicts_better(weight: Real, plain: Real, rich: Real) -> bool:
    """Return whether the errors of a richer form at held-out strokes [N] are smaller, beyond one standard error."""
    n, gain = len(weight), weight * (plain**2 - rich**2)
    return bool(n >= FEWEST and gain.sum() > np.sqrt(n / (n - 1)) * np.linalg.norm(gain - gain.mean()))


@dataclass(frozen=True)
class HeldOut:
    """How well forms predict strokes that are held out, each stroke weighed as the fit weighs it."""

    weight: Real  # Of each stroke [1/N²], shape (n,)
    form: str  # The form that the map has
    errors: Mapping[str, Real]  # By form, the error at each stroke while it is held out [N], shape (n,)
    ages: float | None = None
    """What F_s grows by with each factor e of the age of the contact [N], where that predicts best."""
    also: Mapping[str, float] = field(default_factory=dict)
    """Errors of what was tried beside the forms [N], by what it is called."""

    def __getitem__(self, form: str) -> float:
        """Return the weighted root mean square error of a form [N]."""
        return weighted_rms(self.weight, self.errors[form])

    def entered(self, form: str, errors: Real) -> Self:
        """Return it with the errors of another form [N]."""
        return replace(self, errors={**self.errors, form: errors})

    def better(self, rich: str) -> bool:
        """Return whether a richer form predicts better than that of the map, beyond one standard error."""
        return predicts_better(self.weight, self.errors[self.form], self.errors[rich])

    def as_dict(self) -> dict[str, float]:
        """Return the errors of all that was tried [N], by what it is called."""
        return {text: self[form] for form, text in DESCRIPTIONS.items() if form in self.errors} | dict(self.also)


def left_out_errors(problem: StribeckProblem, solution: Solution) -> Real:
    """Return the error at each stroke while it is held out [N], shape (n,)."""
    return by_leverage(problem, *_misfit(problem, solution))


def _misfit(problem: StribeckProblem, solution: Solution) -> tuple[Real, Real]:
    return problem.F - problem.model(solution.theta), problem.jacobian(solution.theta)


def by_leverage(problem: StribeckProblem, residual: Real, jacobian: Real) -> Real:
    """Return what residuals [N] are while their stroke is held out, by its leverage (Allen 1974: PRESS), shape (n,)."""
    leverage = np.sum(_directions(problem, jacobian) ** 2, axis=1)
    return np.asarray(residual / np.maximum(1 - leverage, 1e-3))


def at_other_speeds(problem: StribeckProblem, plain: tuple[Real, Real], rich: tuple[Real, Real]) -> bool:
    """Return whether a richer form predicts clearly better where all strokes of a speed are held out together.

    What both directions show at one speed may be a place, or steps of the force: one tells of the other then. Of either
    form the residuals [N] and the Jacobian are given, shapes (n,) and (n, p).
    """
    speed = np.abs(problem.v)
    order = np.argsort(speed)
    alike = np.split(order, 1 + np.flatnonzero(np.diff(np.log(speed[order])) > np.log1p(REPEATED)))
    squares: list[list[float]] = []
    for residual, jacobian in (plain, rich):
        U, r = _directions(problem, jacobian), residual / problem.standard_error
        squares.append([])
        for one in alike:
            left, axes = np.linalg.eigh(np.eye(len(one)) - U[one] @ U[one].T)
            squares[-1].append(float(np.sum((axes.T @ r[one] / np.maximum(left, 1e-3)) ** 2)))
    without, within = np.array(squares)
    gain, n = without - within, len(alike)
    spread = np.sqrt(n / (n - 1)) * np.linalg.norm(gain - gain.mean()) if n > 1 else np.inf
    return bool(gain.sum() > spread and within.sum() < CLEARLY**2 * without.sum())


def _directions(problem: StribeckProblem, jacobian: Real) -> Real:
    """Return the directions in which a fit can move its weighed points, orthonormal, shape (n, p)."""
    J = jacobian / problem.standard_error[:, None]
    size = np.linalg.norm(J, axis=0)
    Q = np.linalg.svd(J[:, size > 0] / size[size > 0], full_matrices=False)
    return np.asarray(Q.U[:, 1e-9 * Q.S.max() < Q.S])


def at_bound(problem: StribeckProblem, solution: Solution) -> tuple[str, ...]:
    """Return the parameters of the fall that end at a bound: it is then not seen."""
    theta, (low, high) = solution.theta, problem.v_s_range()
    if theta["F_s"] <= theta["F_c"] * (1 + 1e-9):
        return ("F_s", "v_s")
    return (("F_c",) if theta["F_c"] <= 0.0 else ()) + (
        ("v_s",) if theta["v_s"] <= low * 1.001 or theta["v_s"] >= high / 1.001 else ()
    )


def chosen(fitted: Fitted, *, fall: bool, shape: bool, fixed: bool) -> tuple[Fitted, HeldOut]:
    """Return a fit of eq. (2) in the form that predicts held-out strokes best, and how well each does.

    Without its ``fall`` where that may be and predicts no worse, or the fall ends at a bound; with its ``shape`` factor
    free where that may be and predicts better, and nothing ends at a bound. All strokes weigh alike where ``fixed``.
    """
    plain, solution = fitted.problem, fitted.solution
    name = "stribeck" if plain.fall else "coulomb"
    held_out = HeldOut(1 / plain.standard_error**2, name, {name: left_out_errors(plain, solution)})
    if fall and plain.fall:
        simple = _solved(fitted, replace(plain, fall=False, swing=None), None, fixed=fixed)
        held_out = held_out.entered("coulomb", left_out_errors(simple.problem, simple.solution))
        if not simplest([held_out["coulomb"], held_out["stribeck"]]) or at_bound(plain, solution):
            held_out, fitted = replace(held_out, form="coulomb"), simple
    if not fitted.problem.fall:
        return fitted, held_out
    if plain.swing is None and fitted.between > 0 and plain.degrees_of_freedom >= 5:
        held_out = _with_ageing(plain, solution, held_out)
    if (shape or held_out.ages is not None) and plain.degrees_of_freedom - (plain.delta is not None) >= 3:
        return _with_shape(fitted, held_out, shape=shape, fixed=fixed)
    return fitted, held_out


def _with_ageing(plain: StribeckProblem, solution: Solution, held_out: HeldOut) -> HeldOut:
    """Return how well eq. (2) predicts with an F_s that ages, and by how much it does where that is clearly better."""
    ageing = aged(plain, solution)
    tried = held_out.entered("ages", by_leverage(plain, ageing.residual, ageing.jacobian))
    clearly = tried.better("ages") and tried["ages"] < CLEARLY * tried["stribeck"]
    if clearly and at_other_speeds(plain, _misfit(plain, solution), (ageing.residual, ageing.jacobian)):
        return replace(tried, ages=ageing.rise)
    return tried


def _with_shape(fitted: Fitted, held_out: HeldOut, *, shape: bool, fixed: bool) -> tuple[Fitted, HeldOut]:
    """Return the fit with its shape factor free where that may be and predicts clearly better, and how well it does."""
    plain, solution = fitted.problem, fitted.solution
    freed = _solved(fitted, replace(plain, delta=None), solution, fixed=fixed)
    tried = held_out.entered("delta", left_out_errors(freed.problem, freed.solution))
    if tried.ages is not None and not simplest([tried["delta"], tried["ages"]]):
        tried = replace(tried, ages=None)
    low, high = DELTA_RANGE
    inside = low * 1.01 < freed.solution.theta["delta"] < high / 1.01 and not at_bound(freed.problem, freed.solution)
    clearly = inside and tried.better("delta") and tried["delta"] < CLEARLY * tried["stribeck"]
    if shape and tried.ages is None and clearly:
        misfits = _misfit(plain, solution), _misfit(freed.problem, freed.solution)
        if at_other_speeds(plain, *misfits):
            return freed, replace(tried, form="delta")
    return fitted, tried


def _solved(fitted: Fitted, problem: StribeckProblem, start: Solution | None, *, fixed: bool) -> Fitted:
    """Return the fit of another form to the strokes of a fit."""
    problem = replace(problem, standard_error=fitted.own)
    solution, between = solve_with_scatter(problem, fitted.own, fixed=fixed, start=start)
    problem = replace(problem, standard_error=np.hypot(fitted.own, between))
    return fitted._replace(problem=problem, solution=solution, between=between)


def each_direction(problem: StribeckProblem, solution: Solution, damping: float) -> Real | None:
    """Return the errors at held-out strokes of a map for each direction, with the offset of both [N].

    None where there are too few strokes for that. What was taken off the forces [N·s/m] may be more than there is.
    """
    errors = np.empty_like(problem.F)
    for sign in (1.0, -1.0):
        own = np.sign(problem.v) == sign
        swing = None if problem.swing is None else problem.swing[own]
        F = problem.F[own] + damping * problem.v[own]
        side = replace(
            problem, v=problem.v[own], F=F, standard_error=problem.standard_error[own], swing=swing, with_offset=False,
            offset=float(solution.theta["offset"]),
        )  # fmt: skip
        if side.degrees_of_freedom < 2:
            return None
        errors[own] = left_out_errors(side, side.solve(start=solution))
    return errors


class Ageing(NamedTuple):
    """Eq. (2) with an F_s that ages, fitted to strokes: ``F_s·(1 + growth·ln(1 + v_a/|v|))`` in place of F_s.

    In steady sliding the contact is renewed every ``distance``, and its age is ``distance/|v|`` (A. Ruina, Journal of
    Geophysical Research 88, 1983, p. 10359).
    """

    rise: float  # What F_s grows by with each factor e of the age, of contacts that are old [N]
    residual: Real  # Measured less fitted force [N], shape (n,)
    jacobian: Real  # Its derivatives by all free parameters but for their sign, each scaled, shape (n, p)


def aged(problem: StribeckProblem, solution: Solution) -> Ageing:
    """Fit eq. (2) with an F_s that ages, to strokes that do not swing, from eq. (2) without ageing."""
    theta, speed, sign = solution.theta, np.abs(problem.v), np.sign(problem.v)
    slowest = float(speed.min())
    scale = np.array([theta["F_c"] or 1.0, theta["F_s"], theta["F_s"], theta["F_s"] / float(speed.max()), theta["F_s"]])

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

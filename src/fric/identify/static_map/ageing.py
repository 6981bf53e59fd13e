"""Static friction that grows with the age of the contact, as strokes show it.

In steady sliding the contact is renewed every ``distance``, its age is ``distance/|v|`` (A. Ruina, Journal of
Geophysical Research 88, 1983, p. 10359), and eq. (2) has ``F_s·(1 + growth·ln(1 + v_a/|v|))`` for F_s.
"""

from typing import NamedTuple

import numpy as np
from scipy.optimize import least_squares

from fric.arrays import Real
from fric.friction.stribeck import stribeck_shares
from fric.identify.static_map.stribeck_fit import Solution, StribeckProblem


class Ageing(NamedTuple):
    """Eq. (2) with an F_s that ages, fitted to strokes.

    Parameters
    ----------
    rise
        What F_s grows by with each factor e of the age, of contacts that are old [N].
    residual
        Measured less fitted force [N], shape (n,).
    jacobian
        Its derivatives by all parameters but for their sign, each scaled, shape (n, p).
    """

    rise: float
    residual: Real
    jacobian: Real


def aged(problem: StribeckProblem, solution: Solution) -> Ageing:
    """Fit eq. (2) with an F_s that ages.

    Parameters
    ----------
    problem, solution
        Strokes that do not swing, and eq. (2) without ageing fitted to them.
    """
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
    found = least_squares(misfit, begin, bounds=(lower, upper), x_scale="jac")
    error = problem.standard_error
    return Ageing(float(found.x[2] * scale[2]), found.fun * error, np.asarray(found.jac) * error[:, None])

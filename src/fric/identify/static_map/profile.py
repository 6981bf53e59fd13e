"""Profile-likelihood intervals of the static map's parameters."""

import numpy as np
from scipy.optimize import brentq
from scipy.special import stdtrit

from fric.identify.static_map.stribeck_fit import DELTA_RANGE, Solution, StribeckProblem


def profile_interval(
    problem: StribeckProblem, best: Solution, name: str, scale: float, guess: float, level: float = 0.95
) -> tuple[float, float]:
    """Return the profile-likelihood interval of one parameter.

    The parameter is held, the rest minimised again, and the limits are where the sum of squares has risen by
    ``t²·scale`` (t: Student's quantile for the degrees of freedom; Bates and Watts 1988, ch. 6). A limit is the
    parameter's bound where that is reached first, and infinite where the data set none.

    Parameters
    ----------
    problem, best
        The problem and its minimum.
    name
        The parameter.
    scale
        Variance of a residual in units of its standard error squared.
    guess
        Linearised standard error of the parameter, the first step of the search.
    level
        Confidence level.
    """
    target = float(stdtrit(problem.degrees_of_freedom, 0.5 + level / 2)) ** 2 * scale
    best_value = best.theta[name]
    force = 10.0 * float(np.abs(problem.F).max())
    walls = {
        # searched up to here, and what the limit is where the data set none
        "F_c": ((0.0, force), (0.0, np.inf)),
        "F_s": ((0.0, force), (0.0, np.inf)),
        "v_s": (problem.v_s_range(), (0.0, np.inf)),
        "delta": (DELTA_RANGE, DELTA_RANGE),
        "sigma": ((0.0, force / float(np.abs(problem.v).max())), (0.0, np.inf)),
        "offset": ((-force, force), (-np.inf, np.inf)),
    }
    searched, physical = walls[name]
    known = {best_value: (-np.sqrt(target), best)}

    def rise(value: float) -> float:
        if value not in known:  # each starts from the nearest one solved
            start = known[min(known, key=lambda other: abs(other - value))][1]
            found = problem.solve({name: value}, start)
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

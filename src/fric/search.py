"""Searches of NLopt, which an error in their cost ends."""

from collections.abc import Callable
from math import inf
from typing import Any, Literal

import numpy as np

from fric.arrays import Real

Algorithm = Literal["GN_CRS2_LM", "GN_DIRECT_L", "LN_SBPLX"]


def minimised(
    algorithm: Algorithm, cost: Callable[[Real], float], start: Real, low: Real | float, high: Real | float,
    **settings: Any,
) -> Real:  # fmt: skip
    """Return where a search of NLopt finds the least cost between bounds, shape (n,).

    An exception of the cost ends the search and is raised. NLopt itself would go on with the error set and raise nested
    SystemErrors, so that a SIGTERM during a search would end in such an error.

    settings: Those of NLopt, by name, as ``maxeval``.
    """
    import nlopt  # of which `design` does without until it searches

    search = nlopt.opt(getattr(nlopt, algorithm), len(start))
    for name, value in {"lower_bounds": low, "upper_bounds": high, **settings}.items():
        getattr(search, f"set_{name}")(value)
    raised: list[BaseException] = []

    def objective(x: Real, _: Real) -> float:
        try:
            return inf if raised else cost(x)
        except BaseException as error:
            raised.append(error)
            search.force_stop()
            return inf

    search.set_min_objective(objective)
    try:
        found = search.optimize(start)
    except nlopt.ForcedStop:
        found = start
    if raised:
        raise raised[0]
    return np.asarray(found)

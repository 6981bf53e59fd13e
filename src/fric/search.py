"""Searches of NLopt, which an error in their cost ends."""

from collections.abc import Callable
from math import inf
from typing import TYPE_CHECKING

import numpy as np

from fric.arrays import Real

if TYPE_CHECKING:
    import nlopt


def minimised(search: "nlopt.opt", cost: Callable[[Real], float], start: Real) -> Real:
    """Return where a search of NLopt finds the least cost, shape (n,).

    An exception of the cost ends the search and is raised. NLopt itself would go on with the error set and raise nested
    SystemErrors, so that a SIGTERM during a search would end in such an error.
    """
    from nlopt import ForcedStop  # of which `design` does without until it searches

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
    except ForcedStop:
        found = start
    if raised:
        raise raised[0]
    return np.asarray(found)

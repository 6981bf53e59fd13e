"""Searches of NLopt, which an error in their cost ends; and choices: of what differs by its scatter, the simplest."""

from collections.abc import Callable, Iterable, Sequence
from math import hypot, inf, isfinite
from typing import Any, Literal

import numpy as np

from fric.arrays import Real

ROUNDING = 1e-7  # Share of the best score within which scores are equal: searches of one minimum differ by this much
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


def simplest(scores: Iterable[float], scatter: float | Sequence[float] = 0.0) -> int:
    """Return the index of the simplest candidate that is as good as the best.

    Candidate n is as good as the best, b, where ``score_n - score_b <= scatter_n + 1e-7·|score_b|``. So a choice does
    not depend on the last bit, nor on noise, where candidates are equally good.

    scores: What each candidate leaves, in any unit, the simplest candidate first; less is better. A score that is not
        finite is never as good as a finite score.
    scatter: Scatter of the difference from the best score between repetitions, in the same unit: one for all
        candidates, or one a candidate.
    """
    found = [score if isfinite(score) else inf for score in map(float, scores)]
    best = min(found)
    each = [float(scatter)] * len(found) if isinstance(scatter, int | float) else [float(value) for value in scatter]
    allowed = (value + ROUNDING * abs(best) for value in each)
    return next(n for n, (score, by) in enumerate(zip(found, allowed, strict=True)) if score <= best + by)


def ranked(scores: Sequence[float], scatter: Sequence[float] | None = None) -> list[int]:
    """Return the indices of candidates, the best first; a simpler candidate before those as good (`simplest`).

    scatter: Scatter of each score, independent of the others; 0 where not given.
    """
    each, left, found = scatter or [0.0] * len(scores), list(range(len(scores))), []
    while left:
        best = min(left, key=lambda n: scores[n])
        found.append(left.pop(simplest([scores[n] for n in left], [hypot(each[n], each[best]) for n in left])))
    return found

"""Choices among candidates: what differs by less than its scatter is a tie, and the simplest candidate wins it."""

from collections.abc import Iterable, Sequence
from math import hypot, isfinite

ROUNDING = 1e-7  # Share of the best score within which scores are equal: searches of one minimum differ by this much


def simplest(scores: Iterable[float], scatter: float | Sequence[float] = 0.0) -> int:
    """Return the index of the simplest candidate that is as good as the best.

    Candidate n is as good as the best, b, where ``score_n - score_b <= scatter_n + 1e-7·|score_b|``. So a choice does
    not depend on the last bit, nor on noise, where candidates are equally good.

    scores: What each candidate leaves, in any unit, the simplest candidate first; less is better. A score that is not
        finite is never as good as a finite score.
    scatter: Scatter of the difference from the best score between repetitions, in the same unit: one for all
        candidates, or one a candidate.
    """
    found = [score if isfinite(score) else float("inf") for score in map(float, scores)]
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

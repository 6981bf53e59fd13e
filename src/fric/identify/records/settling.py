"""Where a force has settled after the start of a motion."""

import numpy as np

from fric.arrays import Real

SETTLING = 0.5
"""Share of the samples that is given up at most until the force has settled."""
BATCHES = 64
"""Batches that the settling is looked for in."""


def settled_from(force: Real) -> tuple[int, bool]:
    """Return the sample from which on a force has settled, and False where half of it is not enough.

    The cut minimises the marginal standard error of what is left, ``S(k)/(n - k)²`` with S the sum of squares about
    the mean of the batches k to n (White, Simulation 69(6), 1997: MSER), and is made only where what it takes off is a
    transient: a stationary force is left whole.

    Parameters
    ----------
    force
        The force at constant velocity, from its first sample on, shape (n,).
    """
    n = len(force)
    batches = min(BATCHES, n // 4)
    if batches < 8:
        return 0, True
    late = force[n // 2 :]
    middle = float(np.median(late))
    spread = 1.4826 * float(np.median(np.abs(late - middle))) or float(late.std())
    edges = np.linspace(0, n, batches, endpoint=False).astype(int)
    # a glitch must not look like a transient: it counts as twenty standard deviations at most
    y = np.clip(force, middle - 20.0 * spread, middle + 20.0 * spread)
    means = np.add.reduceat(y, edges) / np.diff(np.append(edges, n))
    last = int(SETTLING * batches)
    left = batches - np.arange(batches)
    total, squares = np.cumsum(means[::-1])[::-1], np.cumsum((means - middle)[::-1] ** 2)[::-1]
    scatter = np.maximum(squares - left * (total / left - middle) ** 2, 0.0)
    cut = int(np.argmin((scatter / left**2)[: last + 1]))
    if cut == 0:
        return 0, True
    if not _is_transient(means[:cut], means[cut:]):
        return 0, True
    quarter = batches // 4
    settled = cut < last or not _is_transient(means[-2 * quarter : -quarter], means[-quarter:])
    return int(edges[cut]), settled


def _is_transient(head: Real, tail: Real) -> bool:
    """Say whether the head settles into the tail, rather than being part of how the force wanders.

    It differs from the tail by more than four standard errors, and begins outside the range that the tail keeps to.
    """
    difference = float(head.mean() - tail.mean())
    if abs(difference) <= 4.0 * _mean_se(tail) * np.sqrt(1.0 + len(tail) / len(head)):
        return False
    toward = np.sign(difference)
    return bool((toward * head[:3]).max() > (toward * tail).max())


def _mean_se(batches: Real) -> float:
    """Return the standard error of the mean of batch means that may be correlated, by their initial positive sum."""
    centred = batches - batches.mean()
    n = len(centred)
    covariance = np.correlate(centred, centred, "full")[n - 1 : n - 1 + max(n // 4, 1)] / n
    negative = np.flatnonzero(covariance <= 0.0)
    upto = int(negative[0]) if len(negative) else len(covariance)
    return float(np.sqrt(max(covariance[0] + 2.0 * covariance[1:upto].sum(), 0.0) / max(n - 1, 1)))

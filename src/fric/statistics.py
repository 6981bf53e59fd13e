"""Statistics that several rooms share."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from fric.arrays import Complex, Real

FINEST = 1e-12
"""Least variance of what scatters in a mixed model, over that of all."""
MAD_TO_SIGMA = 1.4826
"""Standard deviation over the median absolute deviation, of a normal distribution: ``1/Φ⁻¹(3/4)``."""


def robust_deviation(deviations: Real | Complex) -> float:
    """Return the standard deviation of a normal distribution with the median of these sizes, shape (n,)."""
    return MAD_TO_SIGMA * float(np.median(np.abs(deviations)))


class MixedModel(NamedTuple):
    """Random effects of a linear model, by restricted maximum likelihood."""

    deviations: Real
    """Standard deviation of the effects of each kind, shape (kinds,)."""
    predicted: Real
    """Each effect, best linear unbiased, shape (q,)."""
    errors: Real
    """A root of the covariance of prediction less effect, shape (q, q)."""
    likelier: float
    """By how much twice the logarithm of the restricted likelihood is larger than without the effects, 0 or more."""


def mixed_model(y: Real, X: Real, error: Real, kinds: Sequence[Real]) -> MixedModel:
    """Return the random effects in ``y = X·β + Σ Z_k·b_k + e``; b_k have variance τ_k², e has ``error² + s²``.

    The variances s² and τ_k² minimise ``log|V| + log|XᵀV⁻¹X| + yᵀPy`` (Patterson and Thompson 1971); the effects are
    those of Henderson's equations, ``b = D·Zᵀ·P·y`` with covariance ``D - D·Zᵀ·P·Z·D`` of their error.

    y: What is described, shape (n,).
    X: Columns of what is fixed, shape (n, p).
    error: Standard error of each, as far as it is known, shape (n,).
    kinds: The columns Z_k of each kind of effect, of shape (n, q_k).
    """
    from scipy.linalg import solve_triangular  # which reading a log does without
    from scipy.optimize import minimize

    Z, counts = np.hstack(kinds), [one.shape[1] for one in kinds]
    X = X / np.linalg.norm(X, axis=0)
    size = float(np.mean((y - X @ np.linalg.lstsq(X, y, rcond=None)[0]) ** 2)) or 1.0
    units = size / np.array([1.0, *(float(np.sum(one**2)) / np.count_nonzero(one) for one in kinds)])

    def seen(variances: Real) -> tuple[Real, Real, float]:
        """Return the root of D, the products of y and Z over P, and the likelihood."""
        tau = np.sqrt(np.repeat((variances * units)[1:], counts))
        weight = 1.0 / np.sqrt(error**2 + max(variances[0], FINEST) * size)
        columns = weight[:, np.newaxis] * np.column_stack([y, Z, X])
        A = columns[:, 1 : 1 + len(tau)] * tau
        root = np.linalg.cholesky(np.eye(len(tau)) + A.T @ A)
        inner = solve_triangular(root, A.T @ columns, lower=True)
        over_V = columns.T @ columns - inner.T @ inner
        first = 1 + len(tau)
        fixed = np.linalg.cholesky(over_V[first:, first:])
        taken = solve_triangular(fixed, over_V[first:, :first], lower=True)
        P = over_V[:first, :first] - taken.T @ taken
        logs = [np.log(np.diag(root)), np.log(np.diag(fixed)), -np.log(weight)]
        return tau, P, 2.0 * float(sum(map(np.sum, logs))) + float(P[0, 0])

    def least(start: Sequence[float], free: int) -> tuple[float, Real]:
        """Return the least of the first so many variances, the others 0, and where it is."""
        rest = np.zeros(len(units) - free)

        def cost(some: Real) -> float:
            return seen(np.append(some, rest))[2]

        found = minimize(cost, start[:free], bounds=[(0.0, None)] * free)
        return float(found.fun), np.append(found.x, rest)

    without, _ = least([1.0], 1)
    tried = [least([1.0, *(one,) * len(kinds)], len(units)) for one in (0.1, 1.0)]
    likelihood, variances = tried[int(tried[1][0] < tried[0][0])]
    tau, P, _ = seen(variances)
    covariance = np.diag(tau**2) - np.outer(tau**2, tau**2) * P[1:, 1:]
    values, vectors = np.linalg.eigh(covariance)
    deviations = np.sqrt((variances * units)[1:])
    return MixedModel(
        deviations, tau**2 * P[1:, 0], vectors * np.sqrt(np.maximum(values, 0.0)), max(without - likelihood, 0.0)
    )

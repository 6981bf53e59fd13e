"""Statistics that several rooms share: robust and mixed models, and covariances for correlated residuals."""

from collections.abc import Sequence
from itertools import pairwise
from math import log
from typing import NamedTuple

import numpy as np
from scipy.special import chdtrc, expit, fdtrc, ndtr, stdtrit

from fric.arrays import Complex, Indices, Mask, Real

FINEST = 1e-12  # Least variance of what scatters in a mixed model, over that of all
LOST = 1e-9  # The same, with the known error, below which the likelihood's slopes over other variances have no digits
ENOUGH = 25_000  # Values of which a long-run covariance is found; of twice as many, sums of neighbours are taken
LASTING, PENALTY = 6.0, 3.0  # Times that the longest memory of residuals fits into all, and least gain of a coefficient
MAD_TO_SIGMA = 1.4826  # Standard deviation over the median absolute deviation, of a normal distribution: ``1/Φ⁻¹(3/4)``
COMMON, FACTOR = 0.05, 7.4
"""Standard deviation of the level of an axis from record to record that is exceeded as often as not [1], and the factor
from it that two of three are within: in public logs two records of a linear axis have 1 %, four of a grinder 26 %."""
COLUMNS_APART = 1e-7  # Least singular value of columns of size 1 that a record tells apart; squares halve the digits
DIFFERENT = 1e-3  # Probability of a scatter with equal parameters, below which records count as different
OF_TWO = 0.05  # Probability above which two records are not said to scatter: one difference hardly tells the next


def robust_deviation(deviations: Real | Complex) -> float:
    """Return the standard deviation of a normal distribution with the median of these sizes, shape (n,)."""
    return MAD_TO_SIGMA * float(np.median(np.abs(deviations)))


def rms(values: Real) -> float:
    """Return the root mean square of those of these values, shape (n,), that are known; NaN of none."""
    return float(np.sqrt(np.mean(known**2))) if len(known := values[np.isfinite(values)]) else float("nan")


def memory(series: Real | Complex) -> float:
    """Return the number of neighbouring values of a series of mean 0, shape (n,), for an independent one.

    It is the sum of their correlations, from the value itself to both sides, up to the first that is negative.
    """
    n = len(series)
    likeness = np.fft.ifft(np.abs(np.fft.fft(series, 2 * n)) ** 2).real[:n]
    likeness = likeness / max(float(likeness[0]), 1e-300)
    ends = np.flatnonzero(likeness < 0)
    return 1.0 + 2.0 * float(np.sum(likeness[1 : ends[0] if ends.size else n]))


def supposed(score: float, information: float, exact: float = 0.0) -> tuple[float, float]:
    """Return two values of a parameter c that a fit holds at 0: with equal chances they have its second moment.

    Before the data c is 0 with a chance p, else drawn from N(0, 1). The likelihood has the logarithm ``S·c - I·c²/2``.
    By Bayes' rule c is then drawn from ``N(S/(1 + I), 1/(1 + I))`` with the chance ``(1 - p)·L/(p + (1 - p)·L)``, where
    ``L = (1 + I)^-½·exp(S²/(2 + 2·I))``.

    score, information, exact: S, I and p.
    """
    mean, deviation = score / (1.0 + information), (1.0 + information) ** -0.5
    likelier = 0.5 * score * mean + log(deviation)
    share = float(expit(likelier + log((1.0 - exact) / exact))) ** 0.5 if exact else 1.0
    return share * (mean - deviation), share * (mean + deviation)


class MixedModel(NamedTuple):
    """Random effects of a linear model, by restricted maximum likelihood."""

    deviations: Real  # Standard deviation of the effects of each kind, shape (kinds,)
    measured: Real  # The same, as measured, errors included: of those Student's t holds, also where none is left
    error: Real  # Standard deviation of the error of an effect as it is measured, of each kind
    predicted: Real  # Each effect, best linear unbiased, shape (q,)
    errors: Real  # A root of the covariance of prediction less effect, shape (q, q)
    likelier: float  # Increase of twice the logarithm of the restricted likelihood by the effects, 0 or more


def mixed_model(y: Real, X: Real, error: Real, kinds: Sequence[Real]) -> MixedModel:
    """Return the random effects in ``y = X·β + Σ Z_k·b_k + e``; b_k have variance τ_k², e has ``error² + s²``.

    The variances s² and τ_k² minimise ``log|V| + log|XᵀV⁻¹X| + yᵀPy`` (Patterson and Thompson 1971); the effects are
    those of Henderson's equations, ``b = D·Zᵀ·P·y`` with covariance ``D - D·Zᵀ·P·Z·D`` of their error.

    y: What is described, shape (n,).
    X: Columns of what is fixed, shape (n, p).
    error: Known standard error of each, shape (n,).
    kinds: The columns Z_k of each kind of effect, of shape (n, q_k).
    """
    from scipy.optimize import minimize, minimize_scalar  # which reading a log does without

    Z, counts = np.hstack(kinds), [kind.shape[1] for kind in kinds]
    X = X / np.linalg.norm(X, axis=0)
    size = float(np.mean((y - X @ np.linalg.lstsq(X, y, rcond=None)[0]) ** 2)) or 1.0
    units = size / np.array([1.0, *(float(np.sum(kind**2)) / np.count_nonzero(kind) for kind in kinds)])

    def seen(variances: Real) -> tuple[Real, Real, float]:
        """Return the root of D, the products of y and Z over P, and the likelihood."""
        tau = np.sqrt(np.repeat((variances * units)[1:], counts))
        weight = 1.0 / np.sqrt(error**2 + max(variances[0], FINEST) * size)
        columns = weight[:, np.newaxis] * np.column_stack([Z * tau, X, y, Z])
        prior = np.eye(len(tau), columns.shape[1])  # no products: they leave nothing where effects are large
        R = np.asarray(np.linalg.qr(np.vstack([prior, columns]), mode="r"))
        first = len(tau) + X.shape[1]
        P = R[first:, first:].T @ R[first:, first:]
        logs = [np.log(np.abs(np.diag(R)[:first])), -np.log(weight)]
        return tau, P, 2.0 * float(sum(map(np.sum, logs))) + float(P[0, 0])

    def least(start: Sequence[float], free: int) -> tuple[float, Real]:
        """Return the minimum over the first variances, the others 0, and its place."""
        rest = np.zeros(len(units) - free)

        def cost(some: Real) -> float:
            return seen(np.append(some, rest))[2]

        found = minimize(cost, start[:free], bounds=[(0.0, None)] * free)
        return float(found.fun), np.append(found.x, rest)

    without, _ = least([1.0], 1)
    tried = [least([1.0, *(value,) * len(kinds)], len(units)) for value in (0.1, 1.0)]
    likelihood, variances = tried[int(tried[1][0] < tried[0][0])]
    if float(np.min(error)) ** 2 / size + variances[0] < LOST:  # each effect alone: the search by slopes lost its place
        for on in np.eye(len(units))[1:]:
            moved = minimize_scalar(
                lambda log, at, on: seen(at * np.exp(log * on))[2], bounds=(-1.0, 1.0), args=(variances, on)
            )
            variances = variances * np.exp(moved.x * on)
    tau, P, _ = seen(variances)
    values, vectors = np.linalg.eigh(np.diag(tau**2) - np.outer(tau**2, tau**2) * P[1:, 1:])
    deviations = np.sqrt((variances * units)[1:])
    # of errors v, Q = ZᵀPZ has 1/(D + v) in each contrast that what is fixed leaves, and E|ZᵀPy|² = tr Q
    each = [slice(1 + end - n, 1 + end) for n, end in zip(counts, np.cumsum(counts), strict=True)]
    traces = np.maximum([np.trace(P[of, of]) for of in each], 1e-300)
    total = traces / np.maximum([np.sum(P[of, of] ** 2) for of in each], 1e-300)
    measured = np.sqrt(total * [np.sum(P[of, 0] ** 2) for of in each] / traces)
    v = np.sqrt(np.maximum(total - deviations**2, 0.0))
    root = vectors * np.sqrt(np.maximum(values, 0.0))
    return MixedModel(deviations, measured, v, tau**2 * P[1:, 0], root, max(without - likelihood, 0.0))


def reach(deviation: float, error: float, count: int) -> float:
    """Return half the 95 % interval of an effect as measured, of which a number are seen: normal, their mean known.

    Before their differences are seen they are alike or, with equal chances, scatter by τ, log(τ/COMMON) being normal of
    deviation log(FACTOR); the interval is that of the posterior mixture. It is nearly Student's where three or more
    scatter far beyond their errors, and that of the errors alone where they agree.

    deviation, error: Standard deviation of the effects as measured [1], and that of their error in it.
    """
    x = np.linspace(-2.5, 2.5, 51)
    prior = np.append(1.0, np.exp(-0.5 * x**2) / np.sum(np.exp(-0.5 * x**2)))
    variance = np.append(1e-18, (COMMON * FACTOR**x) ** 2) + error**2
    logs = np.log(prior) - 0.5 * (count - 1) * (np.log(variance) + deviation**2 / variance)
    weight, scale = np.exp(logs - logs.max()), np.sqrt(variance)
    halves = np.geomspace(1.95 * scale[0], 2.0 * scale[-1], 1000)
    outside = 2.0 * ndtr(-halves[:, np.newaxis] / scale) @ (weight / weight.sum())
    return float(halves[np.argmax(outside <= 0.05)])


def hac_covariance(regressors: Real, residual: Real, lengths: Sequence[int] | None = None, most: float = 12.0) -> Real:
    """Return the covariance (p, p) of least-squares estimates, valid where neighbouring residuals are correlated.

    ``(XᵀX)⁻¹·S·(XᵀX)⁻¹`` with S the long-run covariance of the scores ``x_i·e_i``, by autoregressions (den Haan and
    Levin 1997): each score is whitened by one of the order that predicts it best, and S is what is left over
    ``(1 - Σa)²``. A sum of coefficients is raised by its bias (Kendall 1954), and S allows for how few values a score
    of such memory is worth, by Student's t.

    regressors: The observation matrix X, shape (n, p).
    lengths: Rows of each record, in order, where several are stacked: nothing is shared between records.
    most: Order of the autoregressions at most, for a hundred values.
    """
    # Orthonormal regressors: the scores are then of one size, and the inverse is that of R alone.
    q, r = np.linalg.qr(regressors)
    back = np.linalg.inv(r)
    return np.asarray(back @ score_covariance(q, residual, lengths, most) @ back.T)


def score_covariance(regressors: Real, residual: Real, lengths: Sequence[int] | None, most: float) -> Real:
    """Return the long-run covariance (p, p) of the sum of the scores ``x_i·e_i``; arguments as `hac_covariance`."""
    n, p = regressors.shape
    scores = np.ascontiguousarray(regressors.T) * residual
    edges = np.cumsum([0, *([n] if lengths is None else lengths)])
    if (every := n // ENOUGH) > 1:  # sums of neighbours have the same long-run covariance
        at = np.concatenate([np.arange(*of, every) for of in pairwise(edges)])
        scores, n, edges = np.add.reduceat(scores, at, axis=1), len(at), np.searchsorted(at, edges)
    filters = _autoregressions(scores, edges[1:-1], int(min(most * (n / 100.0) ** 0.25, np.diff(edges).min() / 8)))
    whitened = scores.copy()
    for lag, a in enumerate(filters.T, start=1):
        whitened[:, lag:] -= a[:, None] * scores[:, :-lag]
    whitened = np.concatenate([whitened[:, a + filters.shape[1] : b] for a, b in pairwise(edges)], axis=1).T
    total = filters.sum(axis=1)
    sums = total + (1.0 + 3.0 * np.maximum(total, 0.0)) / n * filters.any(axis=1)
    left = 1.0 - np.minimum(sums, 1.0 - LASTING / n)
    covariance = whitened.T @ whitened * (n / len(whitened) * n / (n - p)) / np.outer(left, left)
    memory = np.maximum(np.diag(covariance) / np.maximum(np.sum(scores**2, axis=1), 1e-300), 1.0)
    wider = stdtrit(np.maximum(n / memory - 1.0, 1.0), 0.975) / 1.96
    return np.asarray(covariance * np.outer(wider, wider))


def _autoregressions(series: Real, starts: Indices, most: int) -> Real:
    """Return the coefficients by which each series is predicted, of the best order up to a most, by Burg's recursion;
    each costs ``PENALTY`` of ``n·log`` of the error (Akaike's 2 takes too many).
    series: Values in parts, shape (p, n), and where the parts begin but for the first.
    """
    (p, n), forward, backward = series.shape, series.copy(), series.copy()
    a = found = np.zeros((p, 0))
    error = np.sum(series**2, axis=1) / n
    best, orders = n * np.log(np.maximum(error, 1e-300)), np.zeros(p, np.intp)
    for order in range(1, most + 1):
        forward, backward = forward[:, 1:], backward[:, :-1]
        forward[:, starts - 1] = backward[:, starts - order] = 0.0  # nothing is predicted from another part
        power = np.einsum("pn,pn->p", forward, forward) + np.einsum("pn,pn->p", backward, backward)
        k = 2.0 * np.einsum("pn,pn->p", forward, backward)[:, None] / np.where(power > 0.0, power, np.inf)[:, None]
        a = np.hstack([a - k * a[:, ::-1], k])
        forward, backward = forward - k * backward, backward - k * forward
        error = error * (1.0 - k[:, 0] ** 2)
        cost = n * np.log(np.maximum(error, 1e-300)) + PENALTY * order
        better = cost < best
        best, orders = np.where(better, cost, best), np.where(better, order, orders)
        found = np.where(better[:, None], a, np.hstack([found, np.zeros((p, 1))]))
    return found[:, : int(orders.max(initial=0))]


def pair_power(columns: tuple[Real, Real], rest: Real, known: Real) -> Real:
    """Return the sums of squares that pairs of columns explain beside known ones, shape (f,).

    columns: The first and the second of each pair, each of shape (n, f).
    rest: What is to be explained, shape (n,).
    known: An orthonormal basis of the known columns, shape (n, p).
    """
    a, b = (column - known @ (known.T @ column) for column in columns)
    aa, bb, ab = (np.einsum("nf,nf->f", column, other) for column, other in ((a, a), (b, b), (a, b)))
    on_a, on_b, little = rest @ a, rest @ b, 1e-12 * (aa + bb)
    aa, bb = aa + little, bb + little
    return np.asarray((bb * on_a**2 - 2 * ab * on_a * on_b + aa * on_b**2) / (aa * bb - ab**2))


def smoother_than_noise(residual: Real, quantile: float) -> bool:
    """Test whether residuals in their order are smoother than noise, by von Neumann's ratio; never of fewer than 8.

    quantile: Quantile of the standard normal distribution, below which they are: -2.33 for a level of 1 %.
    """
    if (n := len(residual)) < 8:
        return False
    ratio = float(np.sum(np.diff(residual) ** 2) / max(float(np.sum((residual - residual.mean()) ** 2)), 1e-300))
    return bool((ratio - 2.0) / np.sqrt(4.0 * (n - 2) / (n**2 - 1)) < quantile)


def widened(covariance: Real, *others: Real) -> Real:
    """Return a covariance (p, p) with each deviation the largest of several covariances."""
    errors, *beside = (np.sqrt(np.maximum(np.diag(array), 0.0)) for array in (covariance, *others))
    widen = np.divide(np.max([errors, *beside], axis=0), errors, out=np.ones_like(errors), where=errors > 0)
    return np.asarray(covariance * np.outer(widen, widen))


def of_one_size(gradient: Real) -> tuple[Real, Real]:
    """Return columns of size 1, and their sizes (p,): a small one, squared, counts for none beside a large one."""
    size = np.linalg.norm(gradient, axis=0)
    size[size == 0] = 1.0
    return gradient / size, size


def parameter_covariance(gradient: Real) -> Real:
    """Return the covariance of parameters (p, p) for residuals of variance 1."""
    columns, size = of_one_size(gradient)
    back = np.linalg.pinv(columns) / size[:, np.newaxis]
    return np.asarray(back @ back.T)


def jackknife(gradient: Real, residual: Real, label: Indices) -> Real:
    """Return the squared half widths (p, p) of 95 % intervals that leaving out each group of samples gives.

    Each is one Gauss–Newton step from the solution, with Student's t: a percentile bootstrap of five cycles covers some
    80 %, not 95.

    label: The group that each sample belongs to, shape (n,).
    """
    (gradient, size), groups, left_out = of_one_size(gradient), np.unique(label), []
    normal = gradient.T @ gradient
    for group in groups:
        J, r = gradient[label == group], residual[label == group]
        left_out.append(np.linalg.lstsq(normal - J.T @ J, J.T @ r, rcond=1e-12)[0])
    count, moved = len(groups), np.array(left_out) / size
    moved = moved - moved.mean(axis=0)
    t = float(stdtrit(max(count - 1, 1), 0.975))
    return np.asarray(t**2 * (count - 1) / count * moved.T @ moved)


def sandwich(gradient: Real, residual: Real, label: Indices) -> Real:
    """Return the squared half widths (p, p) of 95 % intervals where residuals of one group belong together.

    The infinitesimal jackknife, or sandwich (White, Econometrica 50, 1982); see `jackknife`.
    """
    groups = np.unique(label)
    scores = np.array([gradient[label == group].T @ residual[label == group] for group in groups])
    moved = np.linalg.lstsq(gradient.T @ gradient, scores.T, rcond=1e-12)[0]
    t = float(stdtrit(max(len(groups) - 1, 1), 0.975))
    return np.asarray(t**2 * moved @ moved.T)


class Between(NamedTuple):
    """Variation of the parameters between records, beyond their errors."""

    covariance: Real  # What the covariance of the joint estimates gains by it, shape (p, p)
    deviations: Real  # Standard deviation of each parameter from record to record, shape (p,)
    off: Real  # What each record shows less the joint estimates, shape (R, p)
    chance: float  # Probability with which records of the same parameters scatter so


def excess_variance(residual: Real, standard_error: Real, freedom: float) -> float:
    """Return the variance that explains residuals (..., n) larger than their standard errors (n,).

    Paule and Mandel's (1982) estimate: the smallest q ≥ 0 with ``Σ r²/(se² + q)`` at most the degrees of freedom.
    """
    from scipy.optimize import brentq  # not at the start: simulations need it not, and it takes 0.1 s

    def surplus(q: float) -> float:
        return float(np.sum(residual**2 / (standard_error**2 + q))) - freedom

    if surplus(0.0) <= 0:
        return 0.0
    high = float(np.sum(residual**2)) / freedom * (1 + 1e-6)
    return float(brentq(surplus, 0.0, high, xtol=1e-15 * high, rtol=1e-10))


def between_records(parts: Sequence[Real], residuals: Sequence[Real], quantile: float) -> Between | None:
    """Return the variation between records, by the moments of their estimates; None where a record has no estimate.

    With δ_r the estimate of record r less the joint estimate and S_r its covariance, ``T = Σ(δ_r - δ̄)(δ_r - δ̄)ᵀ/(R -
    1) - mean S_r``, as far as it is positive (DerSimonian and Laird 1986, in several variables). The joint estimate is
    ``Σ W_r·θ_r``, ``W_r = (XᵀX)⁻¹X_rᵀX_r``, and gains ``Σ W_r·T·W_rᵀ``, with Student's t of R - 1 for its quantile.
    The chance is that of Fisher's F of the parameter that scatters most, times their number: the variances of records
    have the freedom by which they scatter themselves (Satterthwaite 1946), too little to invert each S_r.

    parts, residuals: The observations X_r (n, p) of each record, and the residuals of the joint fit (n,).
    quantile: By which the covariance is multiplied for an interval.
    """
    count, size = len(parts), parts[0].shape[1]
    sized = (X / np.maximum(np.linalg.norm(X, axis=0), 1e-300) for X in parts)
    if count < 2 or any(len(X) < 4 * size or np.linalg.matrix_rank(X, COLUMNS_APART) < size for X in sized):
        return None
    off = np.array([np.linalg.lstsq(X, e, rcond=None)[0] for X, e in zip(parts, residuals, strict=True)])
    covariances = np.array([hac_covariance(X, e - X @ d) for X, e, d in zip(parts, residuals, off, strict=True)])
    each = np.maximum(np.einsum("rii->ri", covariances), 1e-300)  # a fit may leave nothing
    known = 2.0 * count * each.mean(axis=0) ** 2 / np.maximum(each.var(axis=0, ddof=1), 1e-300)
    squares = off.var(axis=0, ddof=1) / each.mean(axis=0)
    chance = min(size * float(fdtrc(count - 1, np.maximum(known, 1.0), squares).min()), 1.0)
    if count == 2 and chance > OF_TWO:
        return None
    scale = np.sqrt(each.mean(axis=0))
    within = covariances.mean(axis=0) + np.diag(1e-9 * scale**2)  # residuals of few samples leave it singular
    from scipy.linalg import eigh  # which simulations do without

    values, vectors = eigh(np.cov(off.T) / np.outer(scale, scale), within / np.outer(scale, scale))
    vectors /= scale[:, None]
    back = within @ vectors
    T = (back * np.maximum(values - 1.0, 0.0)) @ back.T
    normals = np.array([X.T @ X for X in parts])
    shares = np.linalg.solve(normals.sum(axis=0), normals)
    wider = float(stdtrit(count - 1, 0.975)) / quantile
    return Between(wider**2 * np.einsum("rij,jk,rlk->il", shares, T, shares), np.sqrt(np.diag(T)), off, chance)


def pooled(values: Real, covariances: Real, shared: Mask) -> tuple[Real, Real]:
    """Return the mean (p,) of estimates that scatter beyond their errors, and its covariance (p, p).

    Weights are ``w_r = 1/(s_r² + τ²)``, with τ² by moments (DerSimonian and Laird 1986), and s_r the error, or that
    of the median: what the finest shows best is its own value. The variance is that by the errors or, if greater, by
    the scatter, ``Σ w_r·(θ_r - θ)²/((R - 1)·Σ w_r)`` with Student's t of R - 1 (Hartung and Knapp 2001). Two scatter
    where chance does not explain it (`OF_TWO`).

    values, covariances: The estimates, shape (R, p), and their covariances, shape (R, p, p).
    shared: Those whose error is of a model that they share, shape (R,): no mean makes it smaller.
    """
    if not (freedom := len(values) - 1):
        return values[0], covariances[0]
    squares, tau2 = np.einsum("rpp->rp", covariances), 0.0
    squares = np.maximum(squares, np.median(squares, axis=0))
    for _ in range(2):
        w = 1.0 / (squares + tau2)
        total = w.sum(axis=0)
        mean = (w * values).sum(axis=0) / total
        Q = (w * (values - mean) ** 2).sum(axis=0)
        seen = (freedom > 1) | (chdtrc(1, Q) < OF_TWO) | (tau2 > 0.0)
        tau2 = np.maximum(Q - freedom, 0.0) / (total - (w**2).sum(axis=0) / total) * seen
    w_r = (w / total) ** np.where(shared, 0.5, 1.0)[:, None]
    covariance = np.einsum("rp,rpq,rq->pq", w_r, covariances, w_r)
    scatter = (float(stdtrit(freedom, 0.975)) / 1.96) ** 2 * Q / (freedom * total) * seen
    return mean, covariance + np.diag(np.maximum(scatter - np.diag(covariance), 0.0))

"""Cubic splines whose slopes are solved in a fixed order: a reference has the same bits on every processor."""

from typing import Literal

import numpy as np

from fric.arrays import Real
from fric.kernels.signatures import ARRAY, compiled

Ends = Literal["natural", "periodic", "not-a-knot"]


@compiled(ARRAY(ARRAY, ARRAY, ARRAY, ARRAY))
def tridiagonal(lower: Real, middle: Real, upper: Real, right: Real) -> Real:
    """Solve ``lower[i]·s[i-1] + middle[i]·s[i] + upper[i]·s[i+1] = right[i]`` by elimination, without pivoting."""
    n = len(middle)
    c, s = np.empty(n), np.empty(n)
    c[0], s[0] = upper[0] / middle[0], right[0] / middle[0]
    for i in range(1, n):
        pivot = middle[i] - lower[i] * c[i - 1]
        c[i] = upper[i] / pivot
        s[i] = (right[i] - lower[i] * s[i - 1]) / pivot
    for i in range(n - 2, -1, -1):
        s[i] -= c[i] * s[i + 1]
    return s


def spline_slopes(x: Real, y: Real, ends: Ends = "not-a-knot") -> Real:
    """Return the slopes of the cubic spline through points, whose second derivative is continuous, shape (n,).

    With ``h = Δx`` and ``d = Δy/h`` they solve
    ``h[i]·s[i-1] + 2(h[i-1] + h[i])·s[i] + h[i-1]·s[i+1] = 3(h[i]·d[i-1] + h[i-1]·d[i])``
    (C. de Boor, A Practical Guide to Splines, chapter IV).

    x: Strictly increasing, shape (n,), n at least 4.
    y: Values, shape (n,); the last is the first where the spline is periodic.
    ends: No curvature at the ends, a periodic spline, or a third derivative that is continuous at the second and at the
        second-last point.
    """
    h, d = np.diff(x), np.diff(y) / np.diff(x)
    if ends == "periodic":
        before, slope = np.roll(h, 1), np.roll(d, 1)
        lower, middle, upper = h.copy(), 2.0 * (before + h), before
        right = 3.0 * (h * slope + before * d)
        # the ring is cut, and closed again by Sherman and Morrison's formula
        first, last, gamma = lower[0], upper[-1], -middle[0]
        middle[0], middle[-1] = middle[0] - gamma, middle[-1] - first * last / gamma
        closing = np.zeros(len(middle))
        closing[0], closing[-1] = gamma, last
        cut, ring = (tridiagonal(lower, middle, upper, side) for side in (right, closing))
        share = (cut[0] + first * cut[-1] / gamma) / (1.0 + ring[0] + first * ring[-1] / gamma)
        found = cut - share * ring
        return np.append(found, found[0])
    inner = 3.0 * (h[1:] * d[:-1] + h[:-1] * d[1:])
    middle = np.array([2.0, *(2.0 * (h[:-1] + h[1:])), 2.0])
    if ends == "natural":
        return tridiagonal(
            np.array([0.0, *h[1:], 1.0]), middle, np.array([1.0, *h[:-1], 0.0]),
            np.array([3.0 * d[0], *inner, 3.0 * d[-1]]),
        )  # fmt: skip
    start, end = h[0] + h[1], h[-2] + h[-1]
    middle[0], middle[-1] = h[1], h[-2]
    return tridiagonal(
        np.array([0.0, *h[1:], end]), middle, np.array([start, *h[:-1], 0.0]),
        np.array([
            ((h[0] + 2.0 * start) * h[1] * d[0] + h[0] * h[0] * d[1]) / start, *inner,
            (h[-1] * h[-1] * d[-2] + (2.0 * end + h[-1]) * h[-2] * d[-1]) / end,
        ]),
    )  # fmt: skip

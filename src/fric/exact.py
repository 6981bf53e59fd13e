"""Sums, products and functions in a fixed order: what feeds a simulation has the same bits on every processor.

A closed loop reads its position in whole encoder counts, and a last bit decides on which side of an edge a count falls.
BLAS, LAPACK and NumPy's vectorised functions take other orders and other roundings on other processors. What is
computed here goes through IEEE sums and products in the order that is written, and `fric.kernels.elementary`.
"""

from collections.abc import Callable, Iterable, Sequence
from math import frexp
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fric.arrays import Real
from fric.kernels.elementary import cos, exp, log, sin

Matrix = list[list[float]]  # A matrix by its rows


def each(function: Callable[[float], float], x: NDArray[np.floating[Any]]) -> Real:
    """Return a scalar function of each element, in the array's shape."""
    return np.fromiter(map(function, x.ravel().tolist()), float, x.size).reshape(x.shape)


def geometric(first: float, last: float, n: int) -> Real:
    """Return n numbers from the first to the last, at equal ratios, shape (n,)."""
    ratio = log(last / first) / (n - 1)
    return np.array([first, *(first * exp(k * ratio) for k in range(1, n - 1)), last])


def convolved(a: Sequence[complex], b: Sequence[complex]) -> list[complex]:
    """Return the coefficients of the product of two polynomials."""
    found: list[complex] = [0.0] * (len(a) + len(b) - 1)
    for i, x in enumerate(a):
        for j, y in enumerate(b):
            found[i + j] += x * y
    return found


def polynomial(roots: Iterable[complex]) -> list[complex]:
    """Return the coefficients of ``Π(x - root)``, highest power first."""
    found: list[complex] = [1.0]
    for root in roots:
        found = convolved(found, [1.0, -complex(root)])
    return found


def exponentials(x: Iterable[complex]) -> list[complex]:
    """Return e to complex powers."""
    return [exp(z.real) * complex(cos(z.imag), sin(z.imag)) for z in map(complex, x)]


def transposed(a: Matrix) -> Matrix:
    """Return the transpose."""
    return [list(column) for column in zip(*a, strict=True)]


def added(a: Matrix, b: Matrix) -> Matrix:
    """Return the sum of two matrices."""
    return [[x + y for x, y in zip(row, other, strict=True)] for row, other in zip(a, b, strict=True)]


def product(*factors: Matrix) -> Matrix:
    """Return the product of matrices, from the left to the right."""
    found, *others = factors
    for other in others:
        columns = transposed(other)
        found = [[sum(x * y for x, y in zip(row, column, strict=True)) for column in columns] for row in found]
    return found


def identity(n: int) -> Matrix:
    """Return the identity of order n."""
    return [[float(i == j) for j in range(n)] for i in range(n)]


def inverse(a: Matrix) -> Matrix:
    """Return the inverse, by elimination with partial pivoting; a singular matrix raises `ZeroDivisionError`."""
    n = len(a)
    rows = [[*row, *unit] for row, unit in zip(a, identity(n), strict=True)]
    for i in range(n):
        best = max(range(i, n), key=lambda k: abs(rows[k][i]))
        rows[i], rows[best] = rows[best], rows[i]
        pivot = rows[i][i]
        rows[i] = [value / pivot for value in rows[i]]
        for k in range(n):
            if k != i and (share := rows[k][i]) != 0.0:
                rows[k] = [value - share * top for value, top in zip(rows[k], rows[i], strict=True)]
    return [row[n:] for row in rows]


def matrix_exponential(a: Matrix) -> Matrix:
    """Return e^a by its series around zero, squared from there."""
    squarings = max(0, frexp(max(sum(map(abs, column)) for column in transposed(a)))[1] + 1)
    scale = 2.0**-squarings
    found = term = identity(len(a))
    for n in range(1, 17):  # 2^-16/16! is below the last digit
        term = [[scale / n * value for value in row] for row in product(term, a)]
        found = added(found, term)
    for _ in range(squarings):
        found = product(found, found)
    return found


def riccati(a: Matrix, G: Matrix, H: Matrix) -> Matrix:
    """Return the stabilising solution X of ``X = aᵀ X (I + G X)⁻¹ a + H``, by doubling.

    Every round doubles the horizon: E. K. Chu, H. Y. Fan, W. W. Lin and C. S. Wang,
    Structure-preserving algorithms for periodic discrete-time algebraic Riccati equations, 2004.

    a, G, H: State matrix, ``b r⁻¹ bᵀ`` and the weight of the state, shape (n, n) each.
    """
    for _ in range(64):
        middle = inverse(added(identity(len(a)), product(G, H)))
        back = transposed(a)
        more = product(back, H, middle, a)
        G = added(G, product(a, middle, G, back))
        H, before = added(H, more), H
        a = product(a, middle, a)
        if before == H:
            break
    return H

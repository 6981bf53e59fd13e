"""Non-negative least squares for searches that ask for thousands of small ones."""

from contextlib import suppress
from math import isfinite
from typing import Any

import numpy as np
from scipy.optimize import nnls

from fric.arrays import Real

_unchecked: Any = None
"""What SciPy's own function calls, behind checks that take twice the time of so small a problem: 8 % of `identify gms`.

Where another SciPy has it elsewhere, its public function is called."""

with suppress(ImportError):
    from scipy.optimize._slsqplib import nnls as _unchecked


def nonnegative(A: Real, b: Real, most: int) -> tuple[Real, float]:
    """Return ``x ≥ 0`` of least ``|A·x - b|``, and that norm, by Lawson and Hanson's active sets.

    A, b: The problem, of shapes (n, m) and (n,).
    most: Largest number of active sets.
    Raises RuntimeError: When that many are not enough.
    Raises ValueError: When a number of A or b is not finite.
    """
    A = np.ascontiguousarray(A)
    flat = A.ravel()
    if _unchecked is None or not (isfinite(flat @ flat) and isfinite(b @ b)):  # sums tell it sooner than each number
        x, rest = nnls(A, b, maxiter=most)
        return x, float(rest)
    x, rest, state = _unchecked(A, b, most)
    if state == 3:
        raise RuntimeError("non-negative least squares did not end")
    return x, rest

"""Elementary functions of IEEE sums and products alone: the same bits on every processor and with every C library.

A C library takes other roundings where a processor multiplies and adds in one step: of 10,000 values of exp, sin or cos
some six differ in the last bit. In a closed loop that reads its position in whole encoder counts this is enough for a
count to fall to the other side. These functions are within four units in the last place, as `tests/kernels` holds them.

Reductions and series are the classical: J.-M. Muller, Elementary Functions, chapters 4 and 11.
"""

import math
from math import cos as library_cos
from math import sin as library_sin

import numpy as np
from numba import types

from fric.arrays import Real
from fric.kernels.signatures import compiled

ONE = types.float64(types.float64)

_PARTS = 32  # Parts of an octave in which exp looks up 2^(j/32)


def _octave() -> Real:
    """Return 2^(j/32), each rounded once: the 32nd root of ``2^j`` as a whole number of 80 binary places."""
    table = []
    for j in range(_PARTS):
        root = 1 << (j + _PARTS * 80)
        for _ in range(5):
            root = math.isqrt(root)
        table.append(root / (1 << 80))
    return np.array(table)


_OCTAVE = _octave()
_LOWEST = -1074
_POWERS = np.array([math.ldexp(1.0, n) for n in range(_LOWEST, 1024)])
# ln 2/32, ln 2 and π/2 in parts whose first products with whole numbers below 2^20 are exact
_STEP, _STEP_REST = 0.02166084938653512, 5.9631716539705866e-12
_LN2, _LN2_REST = 0.6931471803691238, 1.9082149292705877e-10
_QUARTER, _QUARTER_NEXT, _QUARTER_REST = 1.5707963267341256, 6.077100506303966e-11, 2.0222662487959506e-21
_FAR = 1e6  # Angle [rad] from which the parts of π/2 do not reduce exactly any more: the C library's function serves


@compiled(ONE, makes_arrays=False)
def exp(x: float) -> float:
    """Return e^x."""
    if not x < 709.782712893384:
        return x if x != x else np.inf
    if x < -744.4:  # below the smallest number
        return 0.0
    whole = np.rint(x * (_PARTS / 0.6931471805599453))
    r = (x - whole * _STEP) - whole * _STEP_REST
    n = int(whole)
    p = r + r * r * (0.5 + r * (1.0 / 6.0 + r * (1.0 / 24.0 + r * (1.0 / 120.0 + r * (1.0 / 720.0)))))
    t = _OCTAVE[n & (_PARTS - 1)]
    return (t + t * p) * _POWERS[(n >> 5) - _LOWEST]


@compiled(ONE, makes_arrays=False)
def expm1(x: float) -> float:
    """Return e^x - 1."""
    if not abs(x) < 0.35:
        return exp(x) - 1.0
    series = 1.0
    for n in range(14, 1, -1):
        series = 1.0 + x * series / n
    return x * series


@compiled(ONE, makes_arrays=False)
def _log_near_1(f: float) -> float:
    """Return ln(1 + f) for 1 + f from √½ to √2, by the series of ``2·artanh(f/(2 + f))``."""
    s = f / (2.0 + f)
    z = s * s
    series = 1.0 / 23.0
    for n in range(21, 1, -2):
        series = 1.0 / n + z * series
    return 2.0 * (s + s * z * series)


@compiled(ONE, makes_arrays=False)
def log(x: float) -> float:
    """Return the natural logarithm."""
    if not 0.0 < x < np.inf:
        return -np.inf if x == 0.0 else np.nan if x < 0.0 else x
    m, n = math.frexp(x)
    if m < 0.7071067811865476:
        m, n = 2.0 * m, n - 1
    return n * _LN2 + (_log_near_1(m - 1.0) + n * _LN2_REST)


@compiled(ONE, makes_arrays=False)
def log1p(x: float) -> float:
    """Return ln(1 + x)."""
    return _log_near_1(x) if -0.29 < x < 0.41 else log(1.0 + x)


@compiled(types.float64(types.float64, types.float64), makes_arrays=False)
def power(x: float, y: float) -> float:
    """Return x^y for x from 0 on; its relative error is that of ``|y·ln x|`` in the last place."""
    if x == 0.0:
        return 1.0 if y == 0.0 else 0.0 if y > 0.0 else np.inf
    return exp(y * log(x))


@compiled("Tuple((f8, f8))(f8)", makes_arrays=False)
def _turned(x: float) -> tuple[float, float]:
    """Return cosine and sine of an angle [rad]."""
    if not abs(x) < _FAR:
        return library_cos(x), library_sin(x)
    whole = np.rint(x * (2.0 / math.pi))
    r = ((x - whole * _QUARTER) - whole * _QUARTER_NEXT) - whole * _QUARTER_REST
    z = r * r
    s = c = 1.0
    for n in range(18, 0, -2):
        s, c = 1.0 - z * s / (n * (n + 1)), 1.0 - z * c / (n * (n - 1))
    s *= r
    n = int(whole) & 3
    if n == 0:
        return c, s
    if n == 1:
        return -s, c
    if n == 2:
        return -c, -s
    return s, -c


@compiled(ONE, makes_arrays=False)
def cos(x: float) -> float:
    """Return the cosine of an angle [rad]."""
    return _turned(x)[0]


@compiled(ONE, makes_arrays=False)
def sin(x: float) -> float:
    """Return the sine of an angle [rad]."""
    return _turned(x)[1]


@compiled(types.void(*[types.float64[::1]] * 3), makes_arrays=False)
def _turned_each(x: Real, c: Real, s: Real) -> None:
    for n in range(len(x)):
        c[n], s[n] = _turned(x[n])


def cos_sin(angle: Real) -> tuple[Real, Real]:
    """Return cosine and sine of angles [rad], shape (n,)."""
    c, s = np.empty(len(angle)), np.empty(len(angle))
    _turned_each(np.ascontiguousarray(angle, float), c, s)
    return c, s

"""What the compiled steps of friction models share: relaxation towards a level, and a reversal inside a step."""

from fric.kernels.elementary import exp
from fric.kernels.signatures import compiled


@compiled("Tuple((f8, f8))(f8, f8, f8, f8)", makes_arrays=False)
def shares(s_0: float, s_1: float, rate: float, length: float) -> tuple[float, float]:
    """Return ``exp(-x)`` and its mean ``(1 - exp(-x))/x`` for ``x = 2·rate·length/(s_0 + s_1)``; see `relax`."""
    x = 2.0 * rate * length / (s_0 + s_1)
    if not x > 0.0:
        return 1.0, 1.0
    if x < 0.125:  # the series of expm1, to the last digit, in pairs: sooner there than exp
        y = x * x
        low = (1.0 - x * (1.0 / 2.0)) + y * (1.0 / 6.0 - x * (1.0 / 24.0))
        high = (1.0 / 120.0 - x * (1.0 / 720.0)) + y * (1.0 / 5040.0 - x * (1.0 / 40320.0))
        mean = low + (y * y) * (high + (y * y) * (1.0 / 362880.0 - x * (1.0 / 3628800.0)))
        left = 1.0 - x * mean
    else:
        left = exp(-x)
        mean = (1.0 - left) / x
    return left, mean


@compiled("Tuple((f8, f8))(f8, f8, f8, f8)", makes_arrays=False)
def relax(s_0: float, s_1: float, rate: float, length: float) -> tuple[float, float]:
    """Return the share of a load after a relaxation, and its pull, while the level changes from s_0 to s_1.

    ``u(length) = left·u(0) + pull`` solves ``du/dx = rate·(1 - u/s)`` for a level that changes linearly and 1/s taken
    at the middle: second order, and exact for a constant level. It is a weighted mean of u(0), s_0 and s_1, so the
    load stays among them for any rate and any length.
    """
    left, mean = shares(s_0, s_1, rate, length)
    return left, (mean - left) * s_0 + (1.0 - mean) * s_1


@compiled("Tuple((f8, f8))(f8, f8, f8)", makes_arrays=False)
def reversal(v_0: float, v: float, dt: float) -> tuple[float, float]:
    """Return the path [m] and the time [s] before the motion reverses in a step; zeros where it does not.

    The velocity goes linearly from v_0 to v, and the motion reverses where that is zero.
    """
    if v_0 * v >= 0.0:
        return 0.0, 0.0
    before = v_0 / (v_0 - v)
    return 0.5 * v_0 * before * dt, before * dt

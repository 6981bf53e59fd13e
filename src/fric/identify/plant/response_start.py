"""Where a search for eq. (1) begins: the best of a grid."""

import numpy as np

from fric.arrays import Real
from fric.errors import FricError
from fric.identify.plant.response_lines import Lines


def near(lines: Lines, dampings: int = 60, most: int = 200) -> tuple[Real, float]:
    """Return A, ln B, T_d near the best, and what is left of the squares.

    They are from a grid: the phase is wrapped, so that no unwrapping can go wrong.

    Parameters
    ----------
    lines
        The lines.
    dampings
        Values of A that are tried.
    most
        Lines that are looked at.

    Raises
    ------
    FricError
        When the response is that of eq. (1) with the sign turned.
    """
    thin = slice(None, None, -(-len(lines.frequency) // most))
    f, response, deviation = lines.frequency[thin], lines.response[thin], lines.deviation[thin]
    weight = 1 / np.maximum(deviation, 1e-3) ** 2
    weight = weight / weight.sum()
    omega = 2 * np.pi * f
    T_d = np.arange(0, 20 / f.max(), 0.2 / f.max())
    back = np.exp(1j * np.outer(T_d, omega))
    best, at = np.inf, np.zeros(3)
    for A in (0.0, *np.geomspace(0.05 * omega.min(), 2 * omega.max(), dampings)):
        ratio = response * 1j * omega * (1j * omega + A)
        log_B = float(weight @ np.log(np.abs(ratio)))
        cost = weight @ (np.log(np.abs(ratio)) - log_B) ** 2 + np.angle(ratio * back) ** 2 @ weight
        n = int(np.argmin(cost))
        if cost[n] < best:
            best, at = float(cost[n]), np.array([A, log_B, T_d[n]])
    if best > 1.0:
        turned = weight @ np.cos(np.angle(-response * 1j * omega * (1j * omega + at[0])))
        if turned > 0.5:
            raise FricError(
                "the response is that of eq. (1) with the sign turned", hint="Set sign: -1 for input or position."
            )
    return at, best

"""The lines of a measured response that are sure enough for a fit, and where a search for eq. (1) begins."""

from typing import NamedTuple

import numpy as np

from fric.arrays import Complex, Mask, Real
from fric.errors import FricError
from fric.identify.plant.frequency_response import MeasuredResponse

COARSEST = 0.3
"""Relative deviation up to which the logarithm of a response is as good as unbiased."""


class Lines(NamedTuple):
    """The lines of one response that a fit uses."""

    frequency: Real  # Frequencies [Hz], shape (n,)
    response: Complex  # Z/U [m/V], shape (n,)
    deviation: Real  # Relative standard deviation of real and imaginary part, shape (n,)
    # Sampling rate of the hold in front of the plant [Hz]; None where the response is that of eq. (1) itself.
    hold: float | None
    reversing: float  # Equivalent gain of Coulomb friction [s/m], see `MeasuredResponse`
    correlation: float  # Neighbouring lines that tell as much as one
    known: bool  # True where the deviation is known in full, false where only its shape is (a table)


def select(
    measured: MeasuredResponse,
    *,
    hold: float | None,
    coherence: float,
    band: tuple[float, float] = (0.0, np.inf),
) -> tuple[Lines, Mask]:
    """Return the lines of a response that are sure enough, and which they are, shape (n,).

    measured: The response.
    hold: Sampling rate of the hold [Hz], or None.
    coherence: Least coherence.
    band: Lowest and highest frequency [Hz].
    Raises FricError: When fewer than four lines are left.
    """
    table = measured.table
    f = table.frequency
    deviation = np.ones_like(f) if table.deviation is None else table.deviation
    known = measured.method != "table" or table.coherence is None
    used = (f >= band[0]) & (f <= band[1]) & (f < (np.inf if hold is None else 0.45 * hold))
    if table.coherence is not None:
        used &= table.coherence >= coherence
    if measured.method != "table":
        used &= deviation <= COARSEST
    if np.count_nonzero(used) < 4:
        raise FricError(
            f"{np.count_nonzero(used)} of {len(f)} frequencies have a coherence of {coherence:g} or more"
            + (f" between {band[0]:g} and {band[1]:g} Hz" if band != (0.0, np.inf) else ""),
            where=table.where,
            hint="Excite harder or longer, or lower `coherence=`.",
        )
    floor = 1e-9  # a response without any noise weighs much, but not infinitely
    lines = Lines(
        f[used], measured.response[used], np.maximum(deviation[used], floor), hold, measured.reversing or 0.0,
        measured.correlation, known and measured.method != "table",
    )  # fmt: skip
    return lines, used


def near(lines: Lines, dampings: int = 60, most: int = 200) -> tuple[Real, float]:
    """Return A, ln B, T_d near the best, and what is left of the squares.

    They are from a grid: the phase is wrapped, so that no unwrapping can go wrong.

    lines: The lines.
    dampings: Values of A that are tried.
    most: Lines that are looked at.
    Raises FricError: When the response is that of eq. (1) with the sign turned.
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

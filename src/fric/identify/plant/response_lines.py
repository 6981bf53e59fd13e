"""The lines of a measured response that are sure enough for a fit."""

from typing import NamedTuple

import numpy as np

from fric.arrays import Complex, Mask, Real
from fric.errors import FricError
from fric.identify.plant.frequency_response import MeasuredResponse

COARSEST = 0.3
"""Relative deviation up to which the logarithm of a response is as good as unbiased."""


class Lines(NamedTuple):
    """The lines of one response that a fit uses.

    Parameters
    ----------
    frequency
        Frequencies [Hz], shape (n,).
    response
        Z/U [m/V], shape (n,).
    deviation
        Relative standard deviation of real and imaginary part, shape (n,).
    hold
        Sampling rate of the hold in front of the plant [Hz]; None where the response is that of eq. (1) itself.
    reversing
        Equivalent gain of Coulomb friction [s/m], see `MeasuredResponse`.
    correlation
        Neighbouring lines that tell as much as one.
    known
        True where the deviation is known in full, false where only its shape is (a table).
    """

    frequency: Real
    response: Complex
    deviation: Real
    hold: float | None
    reversing: float
    correlation: float
    known: bool


def select(
    measured: MeasuredResponse,
    *,
    hold: float | None,
    coherence: float,
    band: tuple[float, float] = (0.0, np.inf),
) -> tuple[Lines, Mask]:
    """Return the lines of a response that are sure enough, and which they are, shape (n,).

    Parameters
    ----------
    measured
        The response.
    hold
        Sampling rate of the hold [Hz], or None.
    coherence
        Least coherence.
    band
        Lowest and highest frequency [Hz].

    Raises
    ------
    FricError
        When fewer than four lines are left.
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
            hint="Excite harder or longer, or lower --coherence.",
        )
    floor = 1e-9  # a response without any noise weighs much, but not infinitely
    lines = Lines(
        f[used], measured.response[used], np.maximum(deviation[used], floor), hold, measured.reversing or 0.0,
        measured.correlation, known and measured.method != "table",
    )  # fmt: skip
    return lines, used

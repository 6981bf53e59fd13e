"""Which lines of a periodic excitation are driven, and what those between them tell of distortion."""

from collections.abc import Sequence
from itertools import permutations
from typing import NamedTuple

import numpy as np
from scipy import ndimage

from fric.arrays import Complex, Mask, Real
from fric.identify.plant.spectra import Spectra

APART = 1.5
"""Ratio of two amplitudes from which on they tell lines apart that are driven and that are not."""

LESS = 0.75
"""Power of that ratio by which a driven line grows at least."""


class MeanLines(NamedTuple):
    """Lines of a period: frequency [Hz], mean complex amplitude of input [V] and position [m], which are driven; (n,).

    The reference may have told which are driven.
    """

    frequency: Real
    input: Complex
    position: Complex
    driven: Mask
    stated: bool


def excited(spectra: Spectra, driven: Mask | None = None, tall: float = 0.05, surely: float = 0.3) -> Mask:
    """Return which lines of a periodic excitation are driven.

    At a line that is not driven a closed loop shows the controller, the encoder's steps or friction's harmonics, and
    these may repeat themselves as exactly as the excitation. A driven line is tall among its neighbours in input and
    position together, not small against the input at any lower frequency, and above the noise. A line that is less than
    surely tall must take power from the voltage, ``Re(u*·jωz) > 0``: friction's harmonics bring it.

    spectra: Spectra of whole periods.
    driven: The lines that the reference drives, shape (n,), where it is known: it settles the question.
    tall, surely: Share of the tallest that a driven line has at least, and from which on it is taken for one as it is.
    """
    U, Z = (np.abs(np.mean(x, axis=0)) for x in (spectra.input, spectra.position))
    variance = np.var(spectra.input, axis=0, ddof=1) / len(spectra.input)
    noise = np.sqrt(ndimage.median_filter(variance, size=21, mode="nearest"))
    if driven is not None:
        return driven
    both = np.sqrt(U * Z)
    half_width = np.maximum(2, np.arange(len(U)) // 4)
    around = np.array([both[max(0, k - r) : k + r + 1].max() for k, r in enumerate(half_width)])
    power = np.real(1j * np.mean(spectra.position, axis=0) * np.mean(spectra.input, axis=0).conj())
    seen = (both > surely * around) | ((both > tall * around) & (power > 0))
    return np.asarray(seen & (tall * np.maximum.accumulate(U) < U) & (5 * noise < U))


def driven_alike(records: Sequence[MeanLines | None]) -> list[Mask | None]:
    """Return which lines of each record are driven by what two amplitudes of one excitation show, None where nothing.

    What is driven grows with the excitation, in input or in position (a loop that holds one leaves the other to
    friction); friction's harmonics do not. So a line is driven that one of two records shows as such, and that grows
    from the one to the other about as much as those do that both show and that grow at all, by their median: a loop
    that friction all but stops grows by more than its excitation.

    records: The lines of each record, None for one without periods.
    """
    found: list[Mask | None] = [None] * len(records)
    for small, large in permutations(range(len(records)), 2):
        one, other = records[small], records[large]
        if one is None or other is None or not np.array_equal(one.frequency, other.frequency):
            continue
        growth = np.maximum(_ratio(other.input, one.input), _ratio(other.position, one.position))
        both = one.driven & other.driven
        if not both.any() or np.quantile(growth[both], 0.75) < APART:
            continue
        driven = (growth > np.median(growth[both & (growth > APART)]) ** LESS) & (one.driven | other.driven)
        for n in (small, large):
            if not records[n].stated:  # type: ignore[union-attr]
                found[n] = driven if found[n] is None else driven & found[n]
    return found


def _ratio(over: Complex, under: Complex) -> Real:
    return np.asarray(np.abs(over) / np.maximum(np.abs(under), 1e-300))


def distortion(spectra: Spectra, driven: Mask, neighbours: int = 12) -> Real:
    """Return the relative deviation that what repeats itself without being driven brings to each driven line.

    Friction's harmonics and an encoder's steps repeat themselves from period to period, and no scatter over periods
    shows them. The lines between the driven ones do (Pintelon and Schoukens, System Identification, 2nd ed., section
    4.3): they show the voltage ``|Z_j/G - U_j|``, with G between the driven lines; its median over the nearest lines j
    that are not driven, over U_k, is what line k is off by.

    spectra: Spectra of whole periods.
    driven: Which lines are driven, shape (n,).
    neighbours: Lines that are looked at; with fewer than four of them there is no telling: 0.
    """
    U, Z = np.mean(spectra.input, axis=0), np.mean(spectra.position, axis=0)
    at = np.flatnonzero(driven)
    inside = np.arange(len(U)) <= (at[-1] if len(at) else -1)
    quiet = np.flatnonzero(~driven & inside)
    found = np.zeros(len(at))
    if len(quiet) < 4 or np.any(U[at] == 0) or np.any(Z[at] == 0):
        return found
    f, log_G = np.log(spectra.frequency), np.log(Z[at] / U[at])
    angle = np.unwrap(log_G.imag)
    G = np.exp(np.interp(f[quiet], f[at], log_G.real) + 1j * np.interp(f[quiet], f[at], angle))
    voltage = np.abs(Z[quiet] / G - U[quiet]) ** 2
    for n, k in enumerate(at):
        near = np.argsort(np.abs(f[quiet] - f[k]))[:neighbours] if len(quiet) > neighbours else slice(None)
        found[n] = np.sqrt(np.median(voltage[near]) / np.log(2.0) / 2) / np.abs(U[k])
    return found

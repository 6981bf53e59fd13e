"""What friction costs over a cycle, and how that changes over a record."""

import numpy as np
from scipy.special import stdtrit

from fric.arrays import Indices, Real
from fric.estimate import Estimate
from fric.flaws.drift import ENERGY_DRIFTS, ENERGY_IN_ONE_SEGMENT
from fric.notice import Notice


def cycle_energies(position: Real, force: Real, reversals: Indices) -> Real:
    """Return the energy lost in each whole cycle, ``∮F·dz`` from one reversal to the next but one [J], shape (cycles,).

    position, force: The motion [m] and the force along it [N], each of shape (n,).
    reversals: Samples at which the motion reverses.
    """
    work = np.append(0.0, np.cumsum(0.5 * (force[1:] + force[:-1]) * np.diff(position)))
    ends = reversals[::2]
    return np.asarray(np.diff(work[ends])) if len(ends) > 1 else np.zeros(0)


def energy_per_cycle(energies: Real) -> Estimate | None:
    """Return the mean energy of cycles with its 95 % interval by Student's t; None of fewer than two cycles."""
    if len(energies) < 2:
        return None
    mean, n = float(energies.mean()), len(energies)
    half = float(stdtrit(n - 1, 0.975) * energies.std(ddof=1) / np.sqrt(n))
    return Estimate.around(mean, "J", half)


def drift(values: Real) -> tuple[float, float]:
    """Return by how much values change from the first to the last by their line, and half its 95 % interval.

    values: One value a cycle, shape (cycles,), three or more.
    """
    n = len(values)
    at = (np.arange(n) - 0.5 * (n - 1)) / max(n - 1, 1)
    slope = float(at @ values / (at @ at))
    rest = values - values.mean() - slope * at
    error = float(np.sqrt(rest @ rest / (n - 2) / (at @ at)))
    return slope, float(stdtrit(n - 2, 0.975)) * error


CHANGES = 0.03
"""Share of the energy per cycle by which it must change over a record to be told."""
STANDS_OFF = 0.1
"""Share by which the energy of cycles stands off the others' to be told apart."""


def energy_warnings(energies: Real, ends: Real) -> list[Notice]:
    """Return what the energies of equal cycles tell of a record: cycles that stand off in one segment, or a drift.

    energies: Energy lost in each cycle [J], shape (n,).
    ends: Instants at which the cycles begin, and the last one ends [s], shape (n + 1,).
    """
    if len(energies) < 4:
        return []
    usual = float(np.median(energies))
    off = np.flatnonzero(np.abs(energies - usual) > STANDS_OFF * abs(usual))
    spread = float(np.median(np.abs(energies - usual)))
    off = off[np.abs(energies[off] - usual) > 6 * spread]
    if len(off) and len(off) < 0.5 * len(energies) and off[-1] - off[0] + 1 == len(off):
        there, elsewhere = float(energies[off].mean()), float(np.delete(energies, off).mean())
        span = {"begin": float(ends[off[0]]), "end": float(ends[off[-1] + 1])}
        return [ENERGY_IN_ONE_SEGMENT.found(there=Estimate(there, "J"), elsewhere=Estimate(elsewhere, "J"), **span)]
    change, half = drift(energies)
    if abs(change) <= max(half, CHANGES * abs(usual)):
        return []
    return [ENERGY_DRIFTS.found(change=change / usual, half=half / abs(usual))]

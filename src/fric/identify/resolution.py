"""How finely a channel was logged: the step of its lattice, and the level of its noise."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

_EVIDENCE = 16
"""Neighbouring values that must lie on the lattice before it is believed, unless each value came up often."""


def lattice_step(values: NDArray[np.float64]) -> float | None:
    """Return the step of the lattice that logged values lie on (an encoder's count), or None where there is none.

    The gaps between neighbouring values that occur are whole multiples of the step. They may be off by a fifth of it:
    a log written with few decimals rounds the counts of its encoder. Scaling and offset do not matter.

    Parameters
    ----------
    values
        What was logged, any unit, shape (n,). What is not finite is left out.
    """
    values = values[np.isfinite(values)]
    levels = np.unique(values)
    if len(levels) < 2:
        return None
    needed = 1 if len(values) >= 10 * len(levels) else _EVIDENCE
    rounding = 16.0 * np.finfo(float).eps * float(np.abs(levels).max())
    gaps = np.diff(levels)
    gaps = gaps[gaps > rounding]
    if len(gaps) < needed:
        return None
    smallest = float(gaps.min())
    first = float(np.median(gaps[gaps < 1.75 * smallest]))
    for divisor in (1, 2, 3, 4, 5):
        step = first / divisor
        if step < 8.0 * rounding:
            return None
        near = gaps[gaps < 24.0 * step]
        for _ in range(3):
            counts = np.maximum(np.round(near / step), 1.0)
            step = float(near.sum() / counts.sum())
        misfit = np.abs(near - step * counts)
        # two rounded counts make a gap: each is off by up to a fifth where the log kept few decimals
        if len(near) >= needed and np.quantile(misfit, 0.99) < 0.25 * step and misfit.mean() < 0.21 * step:
            return step
    return None


def noise_level(values: NDArray[np.float64]) -> float:
    """Return the standard deviation of white noise on a smooth channel, its quantisation included.

    It is taken from second differences, whose variance is six times that of the noise, in blocks. Blocks of exact rest
    are left out, and the lower quartile of the others, away from ramps, steps and glitches, is given.

    Parameters
    ----------
    values
        Equidistant samples, any unit, shape (n,).
    """
    if len(values) < 3:
        return 0.0
    squares = np.diff(values, 2) ** 2
    length = max(len(squares) // 64, min(len(squares), 32))
    blocks = squares[: len(squares) // length * length].reshape(-1, length).mean(axis=1)
    blocks = blocks[blocks > 0.0]
    return float(np.sqrt(np.quantile(blocks, 0.25) / 6.0)) if len(blocks) else 0.0

"""A channel that is cut off at the end of its range."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from fric.identify.records.resolution import lattice_step

if TYPE_CHECKING:
    from numpy.typing import NDArray

STUCK = 5
"""Consecutive samples at its very extreme after which a force or input counts as clipped."""


def counts(values: NDArray[np.float64]) -> float | None:
    """Return the step in which a force or voltage was logged; none where that is the last digit of a number."""
    step = lattice_step(values)
    return None if step is None or step < 1e-6 * float(np.ptp(values)) else step


def clipped_samples(values: NDArray[np.float64]) -> int:
    """Count the samples at which a channel is flat at its extreme, more than coarse counts alone bring about."""
    span = float(np.ptp(values)) if len(values) else 0.0
    if span == 0.0:
        return 0
    clipped, step = 0, counts(values)
    for side in (values, -values):
        top = side >= side.max() - 1e-9 * span
        edges = np.flatnonzero(np.diff(np.concatenate([[False], top, [False]]).astype(int)))
        longest = int((edges[1::2] - edges[::2]).max())
        below = np.count_nonzero(side >= side.max() - 1.5 * step) - np.count_nonzero(top) if step else 0
        if longest >= STUCK and np.count_nonzero(top) > 3 * below:
            clipped += int(np.count_nonzero(top))
    return clipped

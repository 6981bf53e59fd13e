"""How often a right test of statistics may fail: in one of a thousand draws of its seeds, and the bounds that follow.

On one list of seeds a fit gives the same numbers to a millionth of its interval on every processor, so that a test that
passes goes on to pass; the bounds say which change of the code is no mere draw.
"""

from __future__ import annotations

import numpy as np
from scipy.special import bdtr

RARE = 1e-3
"""Chance of failing of a test whose subject is right."""


def fewest(count: int, share: float = 0.95) -> int:
    """Return how many of ``count`` intervals hold the truth at least, where each does with a chance of ``share``.

    Fewer do with a chance of less than `RARE` (binomial).
    """
    return int(np.sum(bdtr(np.arange(count), count, share) < RARE))


def most(count: int, share: float = 0.95) -> int:
    """Return how many of ``count`` do at most: more do with a chance of less than `RARE`."""
    return count - fewest(count, 1.0 - share)

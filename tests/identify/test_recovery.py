"""Each model recovers its own parameters from its own noisy logs, and its intervals hold them as often as they say."""

import numpy as np
import pytest
from scipy import stats

from tests.identify.recovery import FITTED, REACH, recover

SEEDS = 400
LEAST, MOST = 0.90, 0.98
"""Share of the intervals that hold the truth."""
NARROW = 0.8
"""Intervals of this part of their right width must not pass."""
RARE = 1e-3
"""How often an interval that is right may fail one of the bounds, by the draw of the seeds."""

WIDEST = float(np.sqrt(stats.chi2.isf(RARE / 2, SEEDS) / SEEDS))
SLIMMEST = float(np.sqrt(stats.chi2.ppf(RARE / 2, SEEDS) / SEEDS))
"""Root mean square of the errors of `SEEDS` seeds over their standard errors, 1.118 and 0.885."""
FARTHEST = float(stats.norm.isf(RARE / 2) / np.sqrt(SEEDS))
"""Mean of these errors, 0.165."""


def test_the_bounds_tell_right_intervals_from_narrow_ones():
    """What `test_intervals_cover_the_truth` can see, from the binomial of the count and the chi² of the errors."""

    def kept(miss):
        misses = stats.binom(SEEDS, miss)
        return misses.cdf(round((1 - LEAST) * SEEDS)) - misses.cdf(round((1 - MOST) * SEEDS) - 1)

    assert 1 - kept(0.05) < RARE
    assert stats.binom(100, 0.05).sf(10) + stats.binom(100, 0.05).cdf(1) > 0.04  # of 100 seeds: too few for this
    assert kept(2 * stats.norm.sf(NARROW * REACH)) < 0.2
    assert stats.chi2.cdf(SEEDS * (NARROW * WIDEST) ** 2, SEEDS) < 2e-3
    assert stats.norm.cdf(FARTHEST * np.sqrt(SEEDS) - 0.35 * np.sqrt(SEEDS)) < RARE


@pytest.mark.long
@pytest.mark.parametrize("name", FITTED)
def test_intervals_cover_the_truth(name):
    """A model's intervals, and those of each of its parameters, hold the truth in 90 to 98 % of 400 seeds.

    Of 100 seeds, a right interval shows a share outside 0.90 to 0.98 in one of 21 families of seeds, by the chance of
    the count alone; of 400, in one of 1,576: P(X < 8) + P(X > 40) with X binomial of 400 and 0.05. An interval of 0.8
    of the right width misses 11.7 % and not 5 %, and fails that in 83 % of families, P(X > 40) with 0.117.

    The errors over their standard errors tell a width better than the count does. Their root mean square, over 400
    seeds, is below 1.118 and above 0.885 but for one family in a thousand (chi² of 400 degrees); narrow intervals have
    1.25, and fail in 99.9 % of families: P(chi² > 400·(0.8·1.118)²). A bias is told by their mean, within ±0.165 but
    for one family in a thousand; one of 0.35 standard errors fails in all but 1 of 10,000.
    """
    found = recover(name, range(SEEDS))
    told = dict(zip(found.labels, zip(found.shares, found.biases, found.widths, strict=True), strict=True))
    assert LEAST <= found.shares.mean() <= MOST, told
    assert ((found.shares >= LEAST) & (found.shares <= MOST)).all(), told
    assert ((found.widths > SLIMMEST) & (found.widths < WIDEST)).all(), told
    assert (np.abs(found.biases) < FARTHEST).all(), told

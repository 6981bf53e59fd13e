"""Each model recovers its own parameters from its own noisy logs, and its intervals hold them as often as they say."""

from dataclasses import replace
from functools import cache

import pytest

from tests.identify.recovery import FITTED, recover

SEEDS = 32
NARROW = 0.8
"""Intervals of this part of their right width must not pass."""
ASIDE = 0.2
"""Nor estimates that are off by this many standard errors."""

recovered = cache(lambda name: recover(name, range(SEEDS)))


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=pytest.mark.long(15)) if name == "leuven" else name for name in FITTED]
)
def test_intervals_cover_the_truth(name):
    recovered(name).check()


@pytest.mark.parametrize("name", ["dahl", "static"])
def test_intervals_that_are_narrow_wide_or_aside_do_not_pass(name):
    found = recovered(name)
    for errors in (found.errors / NARROW, found.errors * NARROW, found.errors + ASIDE, found.errors - ASIDE):
        with pytest.raises(AssertionError):
            replace(found, errors=errors).check()

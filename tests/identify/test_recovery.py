"""Each model recovers its own parameters from its own noisy logs, and its intervals hold them as often as they say."""

from dataclasses import replace
from functools import cache

import pytest

from tests.identify.recovery import FITTED, recover
from tests.turns import in_turns

SEEDS = 32
NARROW = 0.8
"""Intervals of this part of their right width must not pass."""
ASIDE = 0.2
"""Nor estimates that are off by this many standard errors."""

LONG = {"dahl": 3, "gms": 8, "leuven": 15, "lugre": 7, "maxwell_slip": 7, "static": 4}
"""Models whose statistics take longer [s]; that each is found, with intervals, is in test_replay_fit.py."""

recovered = cache(lambda name: recover(name, range(SEEDS)))


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=pytest.mark.long(LONG[name])) if name in LONG else name for name in FITTED]
)
def test_intervals_cover_the_truth(name):
    recovered(name).check()


@pytest.mark.parametrize("name", in_turns(["dahl", "static"], ["dahl"], 4))
def test_intervals_that_are_narrow_wide_or_aside_do_not_pass(name):
    found = recovered(name)
    for errors in (found.errors / NARROW, found.errors * NARROW, found.errors + ASIDE, found.errors - ASIDE):
        with pytest.raises(AssertionError):
            replace(found, errors=errors).check()

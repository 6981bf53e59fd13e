"""Ties go to the simplest candidate, and only ties do."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fric.search import ROUNDING, ranked, simplest

SCORES = st.lists(st.floats(-1e6, 1e6), min_size=1, max_size=8)


@given(SCORES, st.floats(0.0, 1e3))
def test_the_choice_is_the_first_within_the_scatter_of_the_best(scores, scatter):
    chosen, allowed = simplest(scores, scatter), scatter + ROUNDING * abs(min(scores))
    assert scores[chosen] <= min(scores) + allowed
    assert all(score > min(scores) + allowed for score in scores[:chosen])


@given(SCORES, st.integers(0, 2**32 - 1))
def test_rounding_changes_no_choice_between_equals(scores, seed):
    equal = np.repeat(min(scores), len(scores))
    jittered = equal * (1 + 1e-12 * np.random.default_rng(seed).standard_normal(len(scores)))
    assert simplest(jittered) == 0


def test_a_candidate_has_a_scatter_of_its_own():
    assert simplest([3.0, 2.0, 1.0], [1.0, 1.0, 0.0]) == 1
    assert simplest([3.0, 2.0, 1.0], [2.0, 0.0, 0.0]) == 0


def test_what_is_no_number_loses():
    assert simplest([float("nan"), float("inf"), 5.0], 1e9) == 2
    assert simplest([float("nan"), float("inf")]) == 0
    with pytest.raises(ValueError, match="empty"):
        simplest([])


@given(SCORES)
def test_without_scatter_candidates_are_in_the_order_of_their_scores(scores):
    order = ranked(scores)
    assert sorted(order) == list(range(len(scores)))
    slack = ROUNDING * max(map(abs, scores))
    assert all(scores[a] <= scores[b] + slack for a, b in pairwise(order))


def test_of_candidates_within_their_scatter_the_simplest_is_first():
    assert ranked([1.0, 0.9, 0.5, 0.45], [0.1, 0.1, 0.1, 0.1]) == [2, 3, 0, 1]

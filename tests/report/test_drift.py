"""Drift against intervals: the interval of a difference covers as often as it says."""

from __future__ import annotations

from math import inf
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fric.report.collect import Change, collect, description

HALF = st.floats(0.01, 10)
VALUE = st.floats(-100, 100)


@given(VALUE, VALUE, HALF, HALF)
def test_symmetric_intervals_add_in_quadrature_and_turn_with_time(a: float, b: float, ha: float, hb: float) -> None:
    there = Change("F_c", "N", a, b, (a - ha, a + ha), (b - hb, b + hb))
    back = Change("F_c", "N", b, a, (b - hb, b + hb), (a - ha, a + ha))
    low, high = there.difference_ci95
    assert high - there.difference == pytest.approx(np.hypot(ha, hb), rel=1e-6)
    assert back.difference_ci95 == pytest.approx((-high, -low))
    assert there.verdict == back.verdict


def test_an_unchanged_number_is_said_to_move_one_time_in_twenty() -> None:
    rng = np.random.default_rng(3)
    sigma = np.array([1.0, 2.5])
    values = 50 + sigma * rng.standard_normal((8000, 2))
    half = 1.96 * sigma
    moved = sum(
        Change("F_c", "N", a, b, (a - half[0], a + half[0]), (b - half[1], b + half[1])).verdict == "moved"
        for a, b in values.tolist()
    )
    assert moved / len(values) == pytest.approx(0.05, abs=0.01)  # four standard errors


def test_a_limit_that_is_open_decides_nothing_on_its_side() -> None:
    earlier_open = Change("C", "N/s", 1e4, 3e4, (5e3, inf), (2e4, 4e4))
    assert earlier_open.verdict == "within"  # it may have been as large as one likes
    later_open = Change("C", "N/s", 1e4, 3e4, (5e3, 2e4), (2.5e4, inf))
    assert later_open.verdict == "moved"  # it is larger, however large
    assert Change("C", "N/s", 1e4, 3e4, (5e3, inf), (2e4, inf)).verdict == "unknown"
    assert Change("C", "N/s", 1e4, 3e4, (-inf, inf), (-inf, inf)).verdict == "unknown"
    assert Change("C", "N/s", 1e4, 3e4).verdict == "unknown"
    assert Change("C", "N/s", 0.0, 1.0).relative is None


def test_two_dates_of_one_axis(files: SimpleNamespace) -> None:
    inputs = collect([files.september, files.march])  # by date, not by the order given
    ((before, after),) = inputs.pairs
    assert (before.source, after.source) == ("march.yaml", "september.yaml")
    changes = {change.name: change for change in before.changes(after)}
    assert changes["F_c"].verdict == "moved"
    assert changes["F_c"].relative == pytest.approx(-9 / 105)
    assert changes["v_s"].before == pytest.approx(1e-3)  # in SI, whatever the unit of the file
    assert "delta" not in changes  # set by hand
    assert {name for name, change in changes.items() if change.verdict == "moved"} == {"F_c"}
    assert "gms.k_4" in changes
    assert description(list(changes.values())).startswith("1 of ")


def test_the_same_numbers_at_two_dates_are_said_to_be_the_same() -> None:
    assert description([Change("F_c", "N", 105.0, 105.0, (104, 106), (104, 106))]) == "No number changed."
    assert description([]) == "The two share no identified number."


def test_the_glitch_of_two_dates(files: SimpleNamespace) -> None:
    inputs = collect([files.run, files.later_run])
    ((before, after),) = inputs.test_pairs
    found = {change.name[1]: change for change in before.changes(after)}
    assert found["a"].relative == pytest.approx(0)
    assert found["c"].relative < -0.5  # a full feedforward leaves next to nothing
    assert "no" in description(list(found.values())).lower()

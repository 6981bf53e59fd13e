"""Intervals of tune: which part of an error is known from few draws, and which estimate a kept shape leaves open."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import norm, t

from fric.circles.tune_fit import _half_widths, _of_either


def test_only_the_error_that_was_drawn_eight_times_has_eight_degrees_of_freedom() -> None:
    rng = np.random.default_rng(5)
    errors = rng.normal(size=(8, 1))
    drawn = errors.T @ errors / 8
    assert _half_widths(np.eye(1), drawn, errors)[0] == pytest.approx(t(8).ppf(0.975) * drawn[0, 0] ** 0.5)
    assert _half_widths(np.eye(1), drawn + 1e6, errors)[0] == pytest.approx(norm.ppf(0.975) * 1e3, rel=1e-3)


def test_intervals_with_a_drawn_part_hold_the_truth_as_often_as_they_say() -> None:
    """4,000 errors, a half of whose variance is known and a half drawn eight times: within 1.3 % (< 1e-3 by chance)."""
    rng, held = np.random.default_rng(6), []
    for _ in range(4000):
        errors = rng.normal(size=(8, 1))
        half = _half_widths(np.eye(1), 1.0 + errors.T @ errors / 8, errors)[0]
        held.append(abs(rng.normal() * 2**0.5) < half)
    assert np.mean(held) == pytest.approx(0.95, abs=0.013)


@pytest.mark.parametrize(
    ("half_kept", "moved", "half"), [(0.0, 0.3, 1.0), (0.2, -2.0, 1.0), (1.0, 0.0, 1.0), (0.1, 5.0, 0.1)]
)
def test_an_interval_holds_95_percent_of_a_kept_shape_and_of_the_whole(
    half_kept: float, moved: float, half: float
) -> None:
    """By 200,000 draws of either at equal odds; the kept value is within. Fails by chance below 1e-3."""
    rng = np.random.default_rng(7)
    kept, whole = (rng.normal(at, width / 1.96, 100000) for at, width in ((0.0, half_kept), (moved, half)))
    low, high = (_of_either(half_kept, moved, half, level) for level in (0.025, 0.975))
    assert low <= 0.0 <= high
    inside = np.mean([np.mean((low - 1e-9 <= part) & (part <= high + 1e-9)) for part in (kept, whole)])
    assert inside == pytest.approx(0.95, abs=0.002) or (half_kept == 0.0 and inside > 0.95)

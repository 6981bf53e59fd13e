"""Where a force has settled: also in stretches of a few dozen samples."""

import numpy as np
import pytest

from fric.records.segments import settled_from


@pytest.mark.parametrize("samples", [32, 40, 48, 60, 64, 200])
def test_a_force_that_falls_throughout_loses_up_to_half_and_no_more(samples):
    rng = np.random.default_rng(samples)
    force = 10.0 * np.exp(-2.0 * np.arange(samples) / samples) + 0.01 * rng.standard_normal(samples)
    start, _ = settled_from(force)
    assert 0 < start <= samples // 2


@pytest.mark.parametrize("samples", [32, 40, 64, 200])
def test_a_force_that_is_steady_is_left_whole(samples):
    rng = np.random.default_rng(samples)
    assert settled_from(100.0 + rng.standard_normal(samples)) == (0, True)

"""Robust means: resistant to glitches, and as sure as they claim."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.signal import lfilter

from fric.identify.static_map.points import autocorrelation_time, average, huber_mean


def _ar1(n: int, memory: float, rng: np.random.Generator) -> np.ndarray:
    shocks = rng.standard_normal(n)
    shocks[1:] *= np.sqrt(1 - memory**2)
    return lfilter([1.0], [1.0, -memory], shocks)


@pytest.mark.parametrize("method", ["robust", "median"])
@pytest.mark.parametrize("memory", [0.0, 0.8])
def test_standard_error_is_the_scatter_of_the_mean(method, memory):
    """A scatter of 150 is known to 6 %: that it is off by 20 % has a chance of 5 in 10,000."""
    rng = np.random.default_rng(5)
    means = [average(100 + _ar1(2000, memory, rng), method) for _ in range(150)]
    scatter = np.std([m.value for m in means], ddof=1)
    claimed = np.mean([m.standard_error for m in means])
    assert claimed == pytest.approx(scatter, rel=0.2)


@pytest.mark.parametrize("memory", [0.0, 0.5, 0.9])
def test_autocorrelation_time_of_a_first_order_process(memory):
    rng = np.random.default_rng(1)
    tau = np.mean([autocorrelation_time(_ar1(20_000, memory, rng)) for _ in range(40)])
    assert tau == pytest.approx((1 + memory) / (1 - memory), rel=0.08)  # four standard errors, or more


@pytest.mark.parametrize("method", ["robust", "median"])
def test_glitches_and_typed_values_hardly_move_the_mean(method):
    rng = np.random.default_rng(2)
    x = 100 + rng.standard_normal(1000)
    clean = average(x, method)
    x[:: 50 if method == "median" else 125] = 1e4
    x[10] = -999.0
    spoiled = average(x, method)
    assert abs(spoiled.value - clean.value) < 3 * clean.standard_error
    assert spoiled.standard_error < 2 * clean.standard_error


@given(st.floats(-1e6, 1e6), st.floats(1e-3, 1e3), st.sampled_from(["robust", "median"]))
def test_moves_and_stretches_with_the_samples(shift, segment, method):
    x = np.random.default_rng(0).standard_normal(200)
    there, here = average(shift + segment * x, method), average(x, method)
    tolerance = 1e-6 * (abs(shift) + segment)
    assert there.value == pytest.approx(shift + segment * here.value, abs=tolerance)
    assert there.standard_error == pytest.approx(segment * here.standard_error, rel=1e-3, abs=tolerance)


def test_a_constant_is_sure_but_for_the_steps_that_it_comes_in():
    assert average(np.full(50, 7.0)).standard_error == 0.0
    for method in ("robust", "median"):
        assert average(np.full(50, 8.0), method, 4.0).standard_error == pytest.approx(4.0 / np.sqrt(12))


@pytest.mark.parametrize("share", [0.05, 0.2, 0.35])
def test_a_drive_that_pushes_to_one_side_has_its_mean_force(share):
    """A PI loop that sees counts pushes hard in few samples and pulls a little in all others: zero in the mean."""
    rng = np.random.default_rng(3)
    pushes = (np.arange(4000) * share) % 1.0 < share
    x = 50.0 + 10.0 * (pushes - share) + 0.5 * rng.standard_normal(4000)
    found = average(x)
    assert abs(found.value - x.mean()) < 0.05
    assert found.standard_error < 0.3


@pytest.mark.parametrize("noise", [0.2, 0.25, 0.3, 0.35, 0.4, 0.5])
def test_a_mean_of_coarse_steps_knows_what_rounding_does_to_it(noise: float) -> None:
    """Under noise of less than half a step most of a mean's error is rounding's, which more samples do not lessen."""
    rng, inside = np.random.default_rng(3), []
    for level in rng.uniform(50, 54, 100):
        found = huber_mean(4.0 * np.round(level / 4.0 + rng.normal(0, noise, 20_000)))
        inside.append(abs(found.value - level) <= 2 * found.standard_error)
    assert np.mean(inside) >= 0.9

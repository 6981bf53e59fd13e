from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fric.records.resolution import clipped_samples, lattice_step, noise_level


@given(st.floats(1e-9, 1e-2), st.floats(-1e4, 1e4), st.integers(20, 5000), st.floats(1e-3, 1e3), st.integers(0, 10**6))
def test_step_is_found_at_any_scale_and_offset(step, offset_counts, span, scale, seed):
    counts = np.random.default_rng(seed).integers(0, span, 3 * span) + offset_counts
    values = (counts * step) * scale / scale
    assert lattice_step(values) == pytest.approx(step, rel=1e-6)


@given(st.integers(0, 10**6))
def test_what_is_not_quantised_has_no_step(seed):
    rng = np.random.default_rng(seed)
    time = np.arange(3000) / 1000
    assert lattice_step(rng.standard_normal(3000)) is None
    assert lattice_step(np.sin(time)) is None
    assert lattice_step(np.full(100, 3.0)) is None


def test_step_survives_few_decimals():
    counts = np.random.default_rng(0).integers(0, 400, 4000)
    assert lattice_step(np.round(counts * 0.25, 1)) == pytest.approx(0.25, rel=1e-3)


def test_few_levels_that_came_up_often_are_a_lattice():
    assert lattice_step(np.random.default_rng(0).integers(9, 12, 500) * 0.1047) == pytest.approx(0.1047)


def test_noise_is_told_from_motion():
    rng = np.random.default_rng(0)
    time = np.arange(20_000) / 1000
    motion = 0.1 * np.abs(time % 4 - 2)
    assert noise_level(motion + 1e-5 * rng.standard_normal(len(time))) == pytest.approx(1e-5, rel=0.15)
    assert noise_level(np.zeros(2)) == 0.0


@pytest.mark.parametrize("per_cycle", [50, 80, 250])
def test_curvature_is_not_taken_for_noise(per_cycle):
    """A sine has differences of every order; white noise on it is found, down to a ten-thousandth of its size."""
    sine = np.sin(2 * np.pi * np.arange(20 * per_cycle) / per_cycle)
    assert noise_level(sine) < 1e-6
    rng = np.random.default_rng(0)
    for noise in (1e-4, 1e-2):
        assert noise_level(sine + noise * rng.standard_normal(sine.size)) == pytest.approx(noise, rel=0.2)


@pytest.mark.parametrize("each", [0.31, 1.0, 7.3, 199.995])
def test_a_constant_velocity_is_not_taken_for_the_lattice(each):
    time = np.arange(3000.0)
    assert lattice_step(0.25e-6 * np.floor(each * time)) == pytest.approx(0.25e-6, rel=1e-6) or each == 1.0
    rng = np.random.default_rng(0)
    assert lattice_step(each * time + 0.01 * rng.standard_normal(3000)) is None


@pytest.mark.parametrize("samples", [2500, 4096])
def test_a_sine_without_an_encoder_has_no_step(samples):
    t = np.arange(samples) / 82.0
    assert lattice_step(15e-6 * np.sin(2 * np.pi * 0.1 * t)) is None
    assert lattice_step(450e-6 * np.sin(2 * np.pi * 0.1 * t + 0.3)) is None


@pytest.mark.parametrize("rest", [-0.0067, -0.9])
def test_samples_that_rest_at_the_lowest_value_are_not_clipped(rest: float) -> None:
    """Five equal samples before a motion one way were its lowest: a whole sine in sliding was left out."""
    rng = np.random.default_rng(1)
    force = np.concatenate([np.full(60, rest), 1.0 + 0.2 * np.sin(np.arange(4000) / 50) + 0.01 * rng.normal(size=4000)])
    assert clipped_samples(force) == (60 if rest < -0.5 else 0)

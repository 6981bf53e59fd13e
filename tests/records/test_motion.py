"""The motion between the encoder's counts."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fric import FricError
from fric.records.motion import slope, smooth_motion


def sine(amplitude, frequency, step, seconds=12.0, dt=1e-3):
    t = np.arange(0.0, seconds, dt)
    w = 2 * np.pi * frequency
    z = amplitude * np.sin(w * t)
    return t, z, amplitude * w * np.cos(w * t), np.rint(z / step) * step


@pytest.mark.parametrize(("amplitude", "step"), [(15e-6, 0.25e-6), (15e-6, 1e-6), (450e-6, 0.25e-6)])
def test_a_sine_is_known_far_better_than_its_counts(amplitude, step):
    t, z, v, counted = sine(amplitude, 0.1, step)
    motion = smooth_motion(t, counted)
    assert motion.step == pytest.approx(step, rel=1e-6)
    inside = slice(500, -500)
    assert np.std(motion.position[inside] - z[inside]) < step / 15  # a count alone leaves step/√12
    assert np.std(motion.velocity[inside] - v[inside]) < 0.02 * np.abs(v).max()


def test_rounding_leaves_nothing_of_a_stiff_spline():
    """Of 12 000 knots rounding left up to four times the counts' spread, and the spline was as rough as it came out."""
    t, z, _, counted = sine(450e-6, 0.1, 0.25e-6)
    inside = slice(500, -500)
    found = [(smooth_motion(t, counted + shift).position - shift)[inside] for shift in (0.0, 0.01)]
    assert np.std(found[0] - z[inside]) < 0.25e-6 / 25
    assert np.std(found[1] - z[inside]) < 0.25e-6 / 25


def test_a_motion_without_noise_is_left_as_it_is():
    """Sampled coarsely, too: 80 samples a cycle were once smoothed, and the velocity was off by 7 %."""
    t, z, v, _ = sine(300e-6, 0.62, 1e-6, dt=20e-3)
    motion = smooth_motion(t, z)
    assert np.array_equal(motion.position, z)
    assert np.abs(motion.velocity - v).max() < 1e-4 * np.abs(v).max()


def test_the_velocity_of_exact_samples_is_that_of_a_parabola_through_five_and_zero_at_rest():
    rng = np.random.default_rng(0)
    t = np.cumsum(rng.uniform(0.5, 1.5, 60))
    curve = np.polynomial.Polynomial([1.0, 2.0, -0.3, 0.01, -0.002])
    assert slope(t, curve(t)) == pytest.approx(curve.deriv()(t), rel=1e-12)
    dwell = np.where(t < t[30], 0.1, 0.1 + (t - t[30]) ** 2)
    assert (slope(t, dwell)[:29] == 0.0).all()


@settings(max_examples=12, deadline=None)
@given(st.floats(8, 400), st.floats(0.08, 0.6), st.floats(-0.5, 0.5))
def test_the_motion_is_never_further_from_the_truth_than_the_counts(counts, frequency, phase):
    step = 0.25e-6
    t = np.arange(0.0, 8.0, 1e-3)
    z = step * (counts * np.sin(2 * np.pi * frequency * t) + phase)
    counted = np.rint(z / step) * step
    motion = smooth_motion(t, counted)
    inside = slice(200, -200)
    assert np.std((motion.position - z)[inside]) < 0.5 * np.std((counted - z)[inside])


def test_an_exact_position_is_left_as_it_is():
    t, z, v, _ = sine(15e-6, 0.1, 1.0)
    motion = smooth_motion(t, z)
    assert motion.step == 0.0
    assert np.array_equal(motion.position, z)
    assert np.abs(motion.velocity - v).max() < 1e-5 * np.abs(v).max()


def test_a_dwell_does_not_ring():
    t = np.arange(0.0, 6.0, 5e-3)
    v = np.where((t % 2) < 1, 2.3e-4, 0.0) * np.where(t % 4 < 2, 1, -1)
    z = np.concatenate([[0.0], np.cumsum(v[:-1] * 5e-3)])
    motion = smooth_motion(t, np.rint(z / 1e-7) * 1e-7)
    dwell = (t % 2 > 1.2) & (t % 2 < 1.8)
    assert np.abs(motion.position - z)[dwell].max() < 1e-7
    assert np.abs(motion.velocity[dwell]).max() < 1e-6


def test_noise_without_a_lattice_is_smoothed():
    t, z, _, _ = sine(15e-6, 0.1, 1.0)
    noisy = z + 50e-9 * np.random.default_rng(0).standard_normal(t.size)
    motion = smooth_motion(t, noisy)
    assert np.std(motion.position - z) < 20e-9


@pytest.mark.parametrize("counts", [0, 2])
def test_standing_still_is_refused(counts):
    t = np.arange(0.0, 1.0, 1e-3)
    with pytest.raises(FricError, match="move"):
        smooth_motion(t, 1e-6 * np.minimum(np.floor(4 * t), counts))


def test_a_clock_whose_end_is_beyond_the_last_knot_by_a_digit_is_smoothed() -> None:
    """60 s at 1 kHz: so many knots of a length that a double rounds down do not reach the last sample."""
    rng = np.random.default_rng(0)
    for n in (59_999, 60_000, 60_001):
        t = np.arange(n) * 1e-3
        smooth_motion(t, np.sin(t) + rng.normal(0.0, 1e-4, n))

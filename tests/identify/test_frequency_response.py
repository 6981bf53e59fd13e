"""The empirical frequency response: periods, segments, closed loops, tables."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import chirp, lfilter

from fric.drive.plant import SampledPlant
from fric.errors import FricError
from fric.identify.plant.frequency_response import find_period, measure_response
from fric.log import FrequencyResponse, Log
from tests.identify.excited_axis import RATE, X, excite, multisine, shaken


def truth(f: np.ndarray) -> np.ndarray:
    return SampledPlant.of(X, RATE).response(f, RATE)


def noise(seconds: float, size: float, seed: int = 3) -> np.ndarray:
    return size * lfilter([0.05], [1, -0.95], np.random.default_rng([seed, 3]).normal(size=round(seconds * RATE)))


def z_scores(log: Log, **options: float) -> tuple[np.ndarray, np.ndarray]:
    """Return real and imaginary errors over the deviation that is told, at coherent lines."""
    m = measure_response(log, **options)
    assert m.table.coherence is not None
    assert m.table.deviation is not None
    sure = m.table.coherence > 0.5
    ratio = m.response[sure] / truth(m.table.frequency[sure]) - 1
    return ratio.real / m.table.deviation[sure], ratio.imag / m.table.deviation[sure]


def test_the_response_of_a_quiet_axis_is_that_of_the_held_plant() -> None:
    """Without noise and encoder only rounding is left, in a closed loop, around a moving mean."""
    log = shaken(X, seed=1, position_noise=0.0, voltage_noise=0.0, resolution=0.0)
    m = measure_response(log)
    assert m.method == "periods"
    np.testing.assert_allclose(m.response, truth(m.table.frequency), rtol=1e-4)


@pytest.mark.parametrize("through", ["voltage", "reference", "reference, not logged"])
def test_errors_are_as_large_as_told_in_a_closed_loop(through: str) -> None:
    scores = []
    for seed in range(12):
        if through == "voltage":
            log = shaken(X, seed=seed)
        else:
            tall = multisine(
                np.unique(np.rint(np.geomspace(1, 200, 60)).astype(int)), 2000, np.random.default_rng(seed)
            )
            r = np.tile(tall / np.abs(tall).max() * 2e-4, 9)
            log = excite(X, seed=seed, reference=r, skip=2000, log_reference=through == "reference")
        scores.append(z_scores(log))
    both = np.concatenate([np.concatenate(pair) for pair in scores])
    assert len(both) > 800
    assert np.abs(both.mean()) < 4 / np.sqrt(len(both))
    assert both.std() == pytest.approx(1.0, abs=0.12)


def test_segments_with_the_reference_as_driver() -> None:
    log = excite(X, seed=4, reference=noise(30, 6e-4))
    m = measure_response(log)
    assert m.method == "segments"
    assert "reference as driver" in m.description
    assert not m.warnings
    assert np.concatenate(z_scores(log)).std() == pytest.approx(1.0, abs=0.2)
    sure = m.table.coherence > 0.9
    assert np.count_nonzero(sure) > 100
    assert np.median(np.abs(m.response[sure] / truth(m.table.frequency[sure]) - 1)) < 0.01


@pytest.mark.parametrize("phase", [0.0, -90.0])
@pytest.mark.parametrize("logged", [True, False])
def test_a_single_sweep(phase: float, logged: bool) -> None:
    """It is told where it went, 1 to 300 Hz, whether it starts with a step or not; the errors are as large as told."""
    n = round(30 * RATE)
    r = 1e-3 * np.linspace(1, 0.1, n) * chirp(np.arange(n) / RATE, 1, 30, 300, "log", phi=phase)
    m = measure_response(excite(X, seed=4, reference=r, log_reference=logged))
    assert "sweep" in m.description
    f = m.table.frequency
    assert f.min() < 2.5
    assert 280 < f.max() < 320
    assert np.all(np.diff(f) > 0)
    inside = (f > 1.5) & (f < 290)
    error = np.abs(m.response[inside] / truth(f[inside]) - 1)
    assert np.quantile(error, 0.99) < 0.12
    # |error| over the deviation of either part is Rayleigh's
    assert np.median(error / m.table.deviation[inside]) == pytest.approx(np.sqrt(2 * np.log(2)), rel=0.15)


def test_without_its_reference_a_noisy_closed_loop_is_biased_and_that_is_told() -> None:
    """The direct quotient is drawn to the controller's inverse; through the reference it is not (20 to 40 Hz)."""
    log = excite(X, seed=4, reference=noise(60, 3e-4), voltage_noise=1.0)
    joint, direct = measure_response(log), measure_response(replace(log, reference=None))
    assert "loop-feeds-back" in {warning.code for warning in direct.warnings}
    error = []
    for m in (joint, direct):
        band = (m.table.frequency > 20) & (m.table.frequency < 40)
        error.append(abs(np.mean(m.response[band] / truth(m.table.frequency[band])) - 1))
    assert error[0] < 0.06
    assert error[1] > 0.3


def test_the_period_is_found_whatever_lies_beneath() -> None:
    rng = np.random.default_rng(1)
    tall = np.tile(multisine(np.arange(2, 150, 3), 1500, rng), 7)[:9999]
    for period in (find_period(tall), find_period(tall + rng.normal(0, 2, tall.size) + 1e-2 * np.arange(tall.size))):
        assert period == 1500 or period == 500  # lines 2 + 3n repeat, up to a phase, within a third
    assert find_period(rng.normal(size=9999)) is None
    assert find_period(np.ones(999)) is None


def test_a_period_that_swings_in_is_left_out() -> None:
    """What it swings in by is no drift either: that was taken off all periods, and drove lines which nothing drives."""
    noisy = shaken(X, seed=1, voltage_noise=0.0)
    begun = replace(noisy, position=noisy.position + 1e-4 * np.exp(-np.arange(len(noisy)) / 300))
    assert measure_response(begun).averages == measure_response(noisy).averages - 1

    log = shaken(X, seed=1, position_noise=0.0, voltage_noise=0.0, resolution=0.0)
    swung = np.exp(-np.arange(len(log)) / 100)
    assert log.input is not None
    first = replace(log, position=log.position + 1e-2 * swung, input=log.input + 0.5 * swung)
    left, whole = measure_response(first), measure_response(log)
    np.testing.assert_array_equal(left.table.frequency, whole.table.frequency)
    np.testing.assert_allclose(left.response, whole.response, rtol=1e-4)


def test_only_driven_lines_are_told_although_the_encoder_repeats_itself() -> None:
    """30 mm/s over half a second are whole encoder steps, so that rounding repeats in each period."""
    m = measure_response(shaken(X, seed=1, position_noise=0.0, voltage_noise=0.0))
    assert m.table.frequency.max() == pytest.approx(400)
    np.testing.assert_allclose(m.response[5:], truth(m.table.frequency[5:]), rtol=0.05)


@pytest.mark.parametrize("resolution", [2e-6, 5e-6])
def test_a_coarse_encoder_that_repeats_itself_drives_no_line(resolution: float) -> None:
    """A loop answers rounding that all periods have alike: its lines showed the controller: B was 10^5 too large."""
    m = measure_response(shaken(X, seed=1, position_noise=0.0, voltage_noise=0.0, resolution=resolution))
    assert m.table.deviation is not None
    error = np.abs(m.response / truth(m.table.frequency) - 1)
    assert m.table.frequency.max() <= 400
    assert np.all(error < 4 * m.table.deviation)
    assert error[(m.table.frequency > 5) & (m.table.frequency < 50)].max() < 0.02


@pytest.mark.parametrize("start", [0, 700])
def test_a_uniform_reference_drives_no_line(start: int) -> None:
    """What its rounding repeats was taken for driven lines, and a start before the periods bent them all."""
    log = shaken(X, seed=1, voltage_noise=0.0, mean=0.0307013)  # a period is 15.35065 mm, a sample 7.675325 µm
    r, z, u = (np.asarray(x) for x in (log.reference, log.position, log.input))
    speed = r[1] - r[0]
    begun = 0.5 * speed * np.arange(start) ** 2 / max(start, 1)  # from rest to the speed
    r = np.concatenate([begun, r - r[0] + 0.5 * speed * start])
    z, u = np.concatenate([begun, z - z[0] + 0.5 * speed * start]), np.concatenate([np.zeros(start), u])
    made = Log(np.arange(len(r)) / RATE, position=z, input=u, reference=np.round(r, 8), kind="frequency-response")
    m, alone = measure_response(made), measure_response(replace(log, reference=None))
    np.testing.assert_array_equal(m.table.frequency, alone.table.frequency)
    np.testing.assert_allclose(m.response, alone.response, rtol=1e-3)


def test_friction_gain_of_a_motion() -> None:
    """4/(π·V) for a sine of amplitude V, √(2/π)/σ for noise, nothing around a motion that never turns."""
    t = np.arange(40_000) / RATE
    V = 0.02
    u = np.sin(2 * np.pi * 5 * t)
    z = -V / (2 * np.pi * 5) * np.cos(2 * np.pi * 5 * t)
    log = Log(t, position=z + 1e-12 * u, input=u + 0.1 * np.sin(2 * np.pi * 10 * t) + 0.1 * np.sin(2 * np.pi * 15 * t))
    m = measure_response(log, segment=1.0)
    assert m.reversing == pytest.approx(4 / (np.pi * V), rel=0.02)
    assert measure_response(replace(log, position=z + 2 * V * t), segment=1.0).reversing == 0.0
    assert shaken(X, seed=2).input is not None
    assert measure_response(shaken(X, seed=2)).reversing == 0.0
    assert (measure_response(shaken(X, seed=2, mean=0.0)).reversing or 0.0) > 10


def test_a_table_is_unwrapped() -> None:
    f = np.geomspace(2, 900, 80)
    G = X.response(f)
    m = measure_response(FrequencyResponse(f, np.abs(G), np.angle(G)))
    assert np.all(np.diff(m.table.phase) < 0)
    assert m.warnings
    assert m.reversing is None
    with pytest.raises(FricError, match="do not increase"):
        measure_response(FrequencyResponse(f[::-1], np.abs(G), np.angle(G)))
    with pytest.raises(FricError, match="magnitude is 0 in row 1, and is above 0"):
        measure_response(FrequencyResponse(f, 0 * f, np.angle(G)))


def test_what_gives_no_response_is_refused() -> None:
    log = shaken(X, seed=1)
    with pytest.raises(FricError, match="no input"):
        measure_response(replace(log, input=None))
    with pytest.raises(FricError, match="does not move"):
        measure_response(replace(log, input=np.zeros(len(log))))
    with pytest.raises(FricError, match="period"):
        measure_response(log, period=3.0)
    with pytest.raises(FricError, match="segment"):
        measure_response(log, segment=3.9)


def test_the_period_is_the_shortest_where_an_encoder_rounds_several_of_them_alike() -> None:
    """A third of a count further in each period: after three of them the record repeats itself to the last digit."""
    period, n = 2000, np.arange(20_000)
    shaken = np.tile(multisine(np.arange(1, 300, 7), period, np.random.default_rng(2)), 10)
    place = 5 * shaken + (240 + 1 / 3) * n / period
    assert find_period(shaken + 0.1 * shaken.std() * (np.rint(place) - place)) == period

"""The virgin curve against the exact one of the model, ΣF_i = Σ min(k_i·z, alpha_i·F_s)."""

from dataclasses import replace

import numpy as np
import pytest

from fric import FricError, Log
from fric.identify.gms.virgin_curve import find_cycles, virgin_curve, with_all_errors
from fric.records.prepared import prepared
from tests.identify.presliding import PAPER, TABLE_1, pair, record

Z = np.linspace(0.0, 100e-6, 1001)[1:]


def loops_of(logs, cycles=None):
    return [find_cycles(record, cycles) for record in prepared(logs)]


def rms(curve):
    return float(np.sqrt(np.mean((curve(Z) - TABLE_1.virgin_curve(Z)) ** 2)))


def test_noise_free_loops_give_it_to_a_thousandth():
    curve = virgin_curve(loops_of(pair(step=0.0, noise=0.0)), PAPER)
    assert rms(curve) < 1e-3 * PAPER.F_s
    assert curve.level == pytest.approx(PAPER.F_s, rel=2e-3)
    assert curve.saturates


@pytest.mark.parametrize("frequency", [0.05, 0.2])
def test_the_speed_of_the_loop_does_not_matter_once_s_is_divided_out(frequency):
    curve = virgin_curve(loops_of(pair(step=0.0, noise=0.0, frequency=frequency)), PAPER)
    assert rms(curve) < 2.5e-3 * PAPER.F_s


def test_without_dividing_by_s_the_plateau_is_low():
    # the trap of Section 3.2.1: 5 to 7 N low where the 450 µm loop is fast
    logs = [
        replace(log, force=log.force - PAPER.sigma * np.gradient(log.position, log.time))
        for log in pair(step=0, noise=0)
    ]
    plateau = Z > 60e-6
    low = (virgin_curve(loops_of(logs))(Z) - PAPER.F_s)[plateau].mean()
    assert -8.0 < low < -4.0


def test_loops_of_one_amplitude_may_have_encoders_of_different_steps():
    """Each record had bins of its own encoder's step, and their branches could not be put together."""
    logs = [record(450e-6, step=step, seed=n) for n, step in enumerate((0.1e-6, 12e-6))]
    curve = virgin_curve(loops_of(logs), PAPER)
    assert curve.level == pytest.approx(PAPER.F_s, rel=0.02)
    assert rms(curve) < 0.08 * PAPER.F_s


def test_an_offset_does_not_bend_it():
    without = virgin_curve(loops_of(pair(step=0.0, noise=0.0)), PAPER)
    with_offset = virgin_curve(loops_of(pair(step=0.0, noise=0.0, offset=7.0)), PAPER)
    assert np.abs(with_offset.force - without.force).max() < 1e-9


def test_small_loop_up_to_its_amplitude_then_the_large_one():
    curve = virgin_curve(loops_of(pair()), PAPER)
    (small, upto), (large, _) = curve.record
    assert "15 um" in small
    assert "450 um" in large
    assert upto == pytest.approx(15e-6, rel=0.02)
    assert curve.mismatch < 2.0
    # the band is of the right size: half of the points within their 95 % band of the truth would be few
    inside = np.abs(curve.force - TABLE_1.virgin_curve(curve.displacement)) < curve.band + curve.blur
    assert inside.mean() > 0.85


@pytest.mark.parametrize("slope", [-3000.0, 3000.0])
def test_the_band_holds_what_a_force_over_position_adds(slope):
    """With 6 N of cogging 0.82 and 0.89 of the curve were inside."""
    logs = [replace(log, force=log.force + slope * log.position) for log in pair(step=0.0)]
    curve = virgin_curve(loops_of(logs), PAPER)
    band = with_all_errors(curve, curve.force).band
    assert np.mean(np.abs(curve.force - TABLE_1.virgin_curve(curve.displacement)) < band) > 0.9


def test_a_small_loop_alone_does_not_saturate():
    assert not virgin_curve(loops_of([record(15e-6)]), PAPER).saturates


def test_three_encoder_steps_are_too_few():
    (smooth,) = prepared([record(0.7e-6, step=0.0, noise=0.1)])
    with pytest.raises(FricError, match="steps of the encoder"):
        find_cycles(replace(smooth, motion=replace(smooth.motion, step=0.25e-6)))


def test_a_ramp_has_no_cycle():
    t = np.arange(0.0, 5.0, 1e-3)
    with pytest.raises(FricError, match="no whole cycle"):
        loops_of([Log(t, position=1e-5 * t, force=t)])


def test_cycles_are_chosen():
    (hysteresis,) = loops_of([record(15e-6)], (2, 3))
    assert len(hysteresis.chosen()) == 2
    (late,) = loops_of([record(15e-6)], (2, 9))
    assert late.cycles == (2, 4)
    with pytest.raises(FricError, match="cycle 9"):
        loops_of([record(15e-6)], (9, 12))


@pytest.mark.parametrize("play", [0.0, 3e-6])
def test_a_play_makes_the_curve_hollow_and_friction_does_not(play):
    """Half of the play stands in the halved branch, where the force passes zero: at half of F_s."""
    logs = [
        replace(log, position=log.position + 0.5 * play * np.tanh(log.force / 8.0))
        for log in pair(step=0.0, noise=0.0)
    ]  # fmt: skip
    where, hollow = virgin_curve(loops_of(logs), PAPER).hollow
    if not play:
        assert hollow < 1e-3 * PAPER.F_s
    else:
        assert hollow > 0.05 * PAPER.F_s
        assert 0.3 * play < where < 3 * play


@pytest.mark.parametrize("frequency", [0.1, 0.3, 1.0, 3.0])
@pytest.mark.parametrize("static", [None, PAPER])
def test_a_fast_sine_makes_no_play_of_the_stribeck_fall(frequency, static):
    logs = pair(frequency=frequency, dt=4e-4 / frequency)
    assert virgin_curve(loops_of(logs), static).hollow[1] < 0.02 * PAPER.F_s


def test_the_smaller_record_that_ends_higher_is_a_positive_mismatch():
    small, large = pair(step=0.0, noise=0.0)
    higher = replace(small, force=1.1 * small.force)
    aged = virgin_curve(loops_of([higher, large]), PAPER)
    assert aged.mismatch > 0.03 * PAPER.F_s
    assert aged.hollow[1] < 0.01 * PAPER.F_s  # nor is what follows lower for a play
    lower = virgin_curve(loops_of([replace(small, force=0.9 * small.force), large]), PAPER)
    assert lower.mismatch < -0.03 * PAPER.F_s
    assert lower.hollow[1] < 0.01 * PAPER.F_s  # nor where a small loop takes less, as in LuGre's model


def test_a_force_at_the_reversals_that_does_not_oppose_the_motion_is_refused():
    # a staircase of six counts does so too, by chance: docs/data-quality.md has its record
    (log,) = pair(step=0.0, noise=0.0)[:1]
    with pytest.raises(FricError, match="does not oppose"):
        virgin_curve(loops_of([replace(log, force=-log.force)]), PAPER)

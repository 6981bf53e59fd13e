"""Steady segments against strokes whose boundaries, speeds and forces are known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fric.errors import FricError
from fric.log import Log
from fric.records.motion import find_reversals
from fric.records.recognition import kind_of
from fric.records.segments import Segment, _leads_into, finer, path_of, steady_segments
from tests.records.kinematics import encoder, strokes

MASS, COULOMB, NOISE = 121.0, 100.0, 1.0


@st.composite
def programmes(draw):
    """Strokes of 10 µm/s to 30 mm/s: each at least 80 counts long and no shorter than its ramps."""
    step = draw(st.sampled_from([5e-8, 2.5e-7, 1e-6]))
    acceleration = 10 ** draw(st.floats(-1.3, 0.7))
    legs = []
    for _ in range(draw(st.integers(1, 6))):
        speed = 10 ** draw(st.floats(-5.0, -1.523))
        duration = max(draw(st.floats(0.3, 3.0)), 80.0 * step / speed, speed / acceleration)
        legs.append((draw(st.sampled_from([-1.0, 1.0])) * speed, duration))
    slowest = min(abs(speed) for speed, _ in legs)
    dwell = draw(st.floats(0.05, 0.5)) + 5.0 * step / slowest  # a dwell below the noise cannot be seen
    rate = draw(st.sampled_from([1000.0, 2000.0, 4000.0]))
    return strokes(legs, acceleration=acceleration, dwell=dwell, rate=rate), step, draw(st.integers(0, 10**6))


@settings(max_examples=20, deadline=None)
@given(programmes(), st.sampled_from([0.0, 0.3]))
def test_every_stroke_is_found_and_no_sample_of_its_ramps(programme, noise_counts):
    made, step, seed = programme
    rng = np.random.default_rng(seed)
    n = len(made.time)
    position = encoder(made.position + noise_counts * step * rng.standard_normal(n), step, rng.uniform(0, step))
    force = COULOMB * np.sign(made.velocity) + MASS * made.acceleration + NOISE * rng.standard_normal(n)
    found = steady_segments(Log(time=made.time, position=position, force=force))
    assert len(found) == len(made.plateaus)
    for segment, (begin, end, velocity) in zip(found, made.plateaus, strict=True):
        first, last = made.time[segment.start], made.time[segment.stop - 1]
        slow = 3.0 * step / abs(velocity)  # what one cannot see within the noise of the encoder
        # a ramp, or a moment at rest, may be in as long as the axis is not off the line by a count
        hidden = max(np.sqrt(2.0 * step / made.ramp), step / abs(velocity)) + 1e-9
        assert first >= begin - hidden
        assert made.time[segment.onset] < begin + 0.15 * (end - begin) + 6 * slow + 0.05
        assert end + hidden >= last > end - 0.1 * (end - begin) - 6 * slow - 0.05
        assert abs(segment.velocity - velocity) < 8.0 * segment.velocity_se
        assert segment.velocity_se < 0.02 * abs(velocity)
        mean = force[segment.start : segment.stop].mean()
        ramps = max(begin - first, 0.0) + max(last - end, 0.0)
        bias = (COULOMB + MASS * made.ramp) * ramps / (last - first)
        assert abs(mean - COULOMB * np.sign(velocity)) < 5.0 * NOISE / np.sqrt(len(segment)) + bias


@settings(max_examples=20, deadline=None)
@given(programmes())
def test_velocity_logs_give_the_same_strokes(programme):
    made, _, seed = programme
    rng = np.random.default_rng(seed)
    fastest = max(abs(velocity) for *_, velocity in made.plateaus)
    velocity = made.velocity + 0.002 * fastest * rng.standard_normal(len(made.time))
    found = steady_segments(Log(time=made.time, velocity=velocity))
    for begin, end, true in made.plateaus:
        if abs(true) < 0.02 * fastest:
            continue  # slower than the noise
        middle = np.searchsorted(made.time, 0.5 * (begin + end))
        (segment,) = (segment for segment in found if segment.start <= middle < segment.stop)
        assert begin - 1e-9 < made.time[segment.start] < begin + 0.15 * (end - begin) + 0.05
        assert end - 0.15 * (end - begin) - 0.05 < made.time[segment.stop - 1] < end + 1e-9
        assert abs(segment.velocity - true) < 6.0 * segment.velocity_se


def one_segment(force_of_time, *, duration=10.0, velocity=1e-4, rate=1000.0):
    made = strokes([(velocity, duration)], dwell=0.3, rate=rate)
    begin = made.plateaus[0][0]
    force = force_of_time(made.time - begin) * (made.velocity != 0)
    return Log(time=made.time, position=encoder(made.position, 2.5e-7), force=force), begin


@pytest.mark.parametrize("settling", [0.02, 0.1, 0.5])
def test_settling_is_cut_and_the_mean_is_unbiased(settling):
    errors = []
    for seed in range(40):
        rng = np.random.default_rng(seed)
        log, begin = one_segment(
            lambda tau, rng=rng: 100.0 * (1.0 - np.exp(-np.maximum(tau, 0) / settling)) + rng.standard_normal(len(tau))
        )
        (segment,) = steady_segments(log)
        assert segment.settled
        assert log.time[segment.start] > begin + 3.0 * settling
        left = log.force[segment.start : segment.stop]
        errors.append((left.mean() - 100.0) * np.sqrt(len(left)))
    # what is left of the transient is less than the noise of one mean
    assert abs(np.mean(errors)) < 1.0


def test_what_settles_for_most_of_the_stretch_is_said_to_be_unsettled():
    rng = np.random.default_rng(1)
    log, _ = one_segment(lambda tau: 100.0 * (1.0 - np.exp(-np.maximum(tau, 0) / 8.0)) + rng.standard_normal(len(tau)))
    (segment,) = steady_segments(log)
    assert not segment.settled


@pytest.mark.parametrize("memory", [0.0, 0.95])
def test_a_stationary_force_is_left_whole(memory):
    cuts, means = [], []
    for seed in range(100):
        rng = np.random.default_rng(seed)
        time = np.arange(4000) / 1000.0
        shocks = rng.standard_normal(len(time) + 500)
        noise = np.convolve(shocks, memory ** np.arange(400), "valid")[: len(time)] if memory else shocks[: len(time)]
        log = Log(time=time, position=encoder(1e-3 * time, 2.5e-7), force=50.0 + noise)
        (segment,) = steady_segments(log)
        cuts.append((segment.start - segment.onset) / len(time))
        means.append(log.force[segment.start : segment.stop].mean() - 50.0)
    assert np.mean(cuts) < 0.02
    assert abs(np.mean(means)) < 3.5 * np.std(means) / np.sqrt(len(means))  # chance of failing: 5 in 10,000


def test_a_glitch_in_the_force_is_no_settling():
    rng = np.random.default_rng(3)
    time = np.arange(4000) / 1000.0
    force = 50.0 + rng.standard_normal(len(time))
    force[700] = 9_999.0
    (segment,) = steady_segments(Log(time=time, position=encoder(1e-3 * time, 2.5e-7), force=force))
    assert segment.start == segment.onset


def test_standing_still_and_shaking_are_no_stretch():
    rng = np.random.default_rng(0)
    time = np.arange(5000) / 1000.0
    still = encoder(0.3e-6 * rng.standard_normal(len(time)), 2.5e-7)
    assert steady_segments(Log(time=time, position=still)) == []
    assert steady_segments(Log(time=time, position=np.zeros(len(time)))) == []
    assert steady_segments(Log(time=time, velocity=1e-3 * rng.standard_normal(len(time)))) == []
    assert steady_segments(Log(time=time[:5], position=time[:5])) == []


@pytest.mark.parametrize("amplitude", [15e-6, 450e-6, 5e-3])
def test_a_sine_is_hardly_ever_steady(amplitude):
    time = np.arange(40_000) / 4000.0
    log = Log(time=time, position=encoder(amplitude * np.sin(2 * np.pi * 0.5 * time), 2.5e-7))
    assert sum(len(segment) for segment in steady_segments(log)) < 0.1 * len(time)
    assert steady_segments(replace(log, kind="sliding-sine")) == []


def test_a_slow_ramp_is_no_stretch():
    time = np.arange(20_000) / 4000.0
    assert steady_segments(Log(time=time, position=encoder(0.5 * 6e-3 * time**2, 2.5e-7))) == []


def test_what_is_no_number_is_told():
    time = np.arange(100) / 100.0
    position = 1e-3 * time
    position[42] = np.nan
    with pytest.raises(FricError, match="position is not a number at sample 42"):
        steady_segments(Log(time=time, position=position))


@pytest.mark.parametrize("counts", [4, 15, 60, 1800])
def test_reversals_of_a_sine_through_a_flickering_encoder(counts):
    rng = np.random.default_rng(counts)
    time = np.arange(40_000) / 4000.0
    true = counts * np.sin(2 * np.pi * 0.5 * time)
    position = 2.5e-7 * np.round(true + 0.2 * rng.standard_normal(len(time)))
    found = find_reversals(position)
    expected = np.arange(10) + 0.5
    assert len(found) == len(expected)
    # within the time that the sine takes for one and a half counts about its crest
    assert np.abs(time[found] - expected).max() < np.arccos(1 - 1.5 / counts) / np.pi


def test_reversal_lies_in_the_middle_of_a_dwell_and_obeys_the_threshold():
    position = np.array([0.0, 1, 2, 3, 3, 3, 3, 3, 2, 1, 0, 1, 0, -5, -5, 0, 5])
    assert find_reversals(position, threshold=2.0).tolist() == [5, 13]
    assert find_reversals(position, threshold=0.5).tolist() == [5, 10, 11, 13]
    assert find_reversals(np.arange(9.0)).tolist() == []
    assert find_reversals(np.zeros(9)).tolist() == []


@pytest.mark.parametrize("builds_up", [True, False])
def test_a_stretch_that_friction_builds_up_in_is_no_stroke_where_a_longer_one_goes_on_at_its_speed(builds_up):
    """Two stretches at one speed are two strokes where the force is the same in both."""
    n, rng = 4000, np.random.default_rng(3)
    force = COULOMB * (1.0 - 0.6 * np.exp(-np.arange(n) / 300.0) * builds_up) + NOISE * rng.standard_normal(n)
    first, second = Segment(0, 400, 5e-5, 5e-8, 0), Segment(440, n, 5.001e-5, 1e-8, 440)
    t = np.arange(n) / 1000.0
    path = path_of(Log(time=t, position=encoder(5e-5 * t, 5e-8, 0.0)))
    assert _leads_into(path, force, first, second) == builds_up
    assert not _leads_into(path, force, first, replace(second, velocity=-5e-5))
    assert not _leads_into(path, force, first, replace(second, velocity=6e-5))
    rested = path_of(Log(time=t, position=encoder(5e-5 * (t - np.clip(t - 0.4, 0.0, 0.04)), 5e-8, 0.0)))
    assert not _leads_into(rested, force, first, second)


def moved(*speeds):
    """Return a record of 2 kHz that goes from speed [µm/s] to speed, each held for its time [s], by ramps of 0.1 s."""
    parts = [np.zeros(600)]
    for speed, held in speeds:
        parts += [np.linspace(parts[-1][-1], speed, 200), np.full(round(2000 * held), speed)]
    position = np.cumsum(np.concatenate(parts)) / 2000.0
    noise = 0.1 * np.random.default_rng(0).standard_normal(len(position))
    return Log(time=np.arange(len(position)) / 2000.0, position=np.round((position + noise) / 0.5) * 0.5e-6)


def test_the_moment_in_which_a_slow_axis_catches_up_is_no_stroke():
    speeds = [1e6 * s.velocity for s in steady_segments(moved((95.0, 0.12), (45.0, 5.0)))]
    assert speeds == pytest.approx([45.0], rel=0.01)


def test_a_short_fast_stroke_beside_a_long_slow_one_is_one():
    speeds = [1e6 * s.velocity for s in steady_segments(moved((2000.0, 0.3), (50.0, 8.0)))]
    assert speeds == pytest.approx([2000.0, 50.0], rel=0.01)


def test_an_axis_that_creeps_into_its_place_after_a_pause_makes_no_stroke():
    """In a clean session 20 ms at 86 µm/s after a stroke at 30 mm/s were a stroke, from which F_s was doubted."""
    t = np.arange(8000) / 2000.0
    v = 0.03 * (
        np.clip(np.minimum(t - 0.1, 1.8 - t) / 0.1, 0.0, 1.0) - np.clip(np.minimum(t - 2.1, 3.8 - t) / 0.1, 0, 1)
    )
    v += np.where(t >= 3.96, 86e-6, 0.0)
    log = Log(t, encoder(np.cumsum(v) / 2000.0, 1e-7), force=COULOMB * np.sign(v), kind="constant-velocity")
    assert [round(segment.velocity, 3) for segment in steady_segments(log)] == [0.03, -0.03]


def test_a_velocity_shows_a_motion_whose_position_has_three_digits():
    t = np.arange(0.0, 60.0, 0.1)
    z, v = 0.15 + 0.04 * np.sin(0.9 * t), 0.036 * np.cos(0.9 * t)
    log = Log(t, position=np.round(z, 3), velocity=v, force=np.sign(v), kind="motion")
    assert finer(log).position is None
    assert finer(replace(log, position=z)).position is not None
    assert finer(replace(log, velocity=0.5 * v)).position is not None  # it is not of this motion
    assert finer(replace(log, time=0.01 * t, velocity=100.0 * v)).position is not None  # and here perhaps late


def two_sided(n_strokes: int, *, hurried: int = -1, creep: float = 0.0) -> Log:
    """Strokes of 20 mm/s to and fro, one of which ``hurried`` along; after each the axis creeps to its place [m/s]."""
    dt, pieces = 1e-3, []
    for n in range(n_strokes):
        speed = np.concatenate([np.linspace(0, 1, 60), np.ones(900), np.linspace(1, 0, 60)])
        if n == hurried:
            speed *= 1.0 + 0.5 * np.sin(np.arange(len(speed)) / 60.0)
        pieces += [(-1.0) ** n * 20e-3 * speed, np.full(500, (-1.0) ** n * creep)]
    v = np.concatenate(pieces)
    z = np.cumsum(v) * dt
    rng = np.random.default_rng(5)
    force = 30.0 * np.tanh(v / 1e-4) + rng.normal(0.0, 0.5, len(v))
    return Log(np.arange(len(v)) * dt, position=np.round(z / 1e-8) * 1e-8, force=force)


def test_how_a_loop_closes_its_error_after_a_stroke_is_no_stroke() -> None:
    """At 1 µm/s after strokes of 20 mm/s such moments were strokes, and made the record a motion."""
    log = two_sided(8, creep=-2e-6)
    assert [round(segment.velocity, 3) for segment in steady_segments(log)] == [0.02, -0.02] * 4
    assert kind_of(log) == "constant-velocity"


def test_a_stroke_back_that_is_not_steady_lies_between_two_ahead() -> None:
    log = two_sided(8, hurried=3, creep=-2e-6)
    assert len(steady_segments(log)) == 7
    assert kind_of(log) == "constant-velocity"


@pytest.mark.parametrize("with_reference", [True, False])
def test_short_strokes_that_settle_late_are_recognised_by_their_reference(with_reference: bool) -> None:
    """Strokes of 0.8 s of a slow integral action were a motion, and left out of the map."""
    t, rest = np.arange(400) / 500.0 - 0.1, np.zeros(100)  # the axis breaks away after 0.1 s, and overshoots
    ahead, back = (np.where(t > 0.0, 1.0 + 0.6 * np.exp(-np.clip(t, 0.0, None) / tau), 0.0) for tau in (0.06, 0.072))
    v = 1e-3 * np.concatenate([rest, ahead, rest, -back, rest])
    asked = 1e-3 * np.concatenate([rest, np.ones(400), rest, -np.ones(400), rest])
    position, reference = np.round(np.cumsum(v) / 500.0 / 2.5e-7) * 2.5e-7, np.cumsum(asked) / 500.0
    log = Log(np.arange(len(v)) / 500.0, position=position, force=30.0 * np.sign(v))
    log = replace(log, reference=reference) if with_reference else log
    assert kind_of(log) == ("constant-velocity" if with_reference else "motion")


def test_a_slow_stroke_between_fast_ones_without_a_pause_is_kept() -> None:
    dt, pieces = 1e-3, []
    for n, speed in enumerate([50e-3, 0.1e-3, 50e-3, 0.1e-3, 50e-3]):
        ramp = np.concatenate([np.linspace(0, 1, 60), np.ones(900 if speed > 1e-3 else 4000), np.linspace(1, 0, 60)])
        pieces.append((-1.0) ** n * speed * ramp)
    v = np.concatenate(pieces)
    log = Log(np.arange(len(v)) * dt, position=np.cumsum(v) * dt, force=30.0 * np.tanh(v / 1e-5))
    assert [round(1e3 * segment.velocity, 2) for segment in steady_segments(log)] == [50.0, -0.1, 50.0, -0.1, 50.0]


def test_an_axis_that_creeps_while_its_reference_stays_is_at_rest() -> None:
    """At 5 µm/s for a second, between strokes of 1 mm/s, such a creep made strokes a motion, and left no static map."""
    log = two_sided(4, creep=-5e-6)
    asked = two_sided(4).position
    assert kind_of(replace(log, reference=asked)) == "constant-velocity"
    assert len(steady_segments(replace(log, reference=asked))) == 4
    creeping = two_sided(4, creep=-50e-6)  # without a reference it may be a stroke
    assert len(steady_segments(creeping)) > 4
    assert len(steady_segments(replace(creeping, reference=asked))) == 4
    unused = replace(creeping, reference=np.zeros(len(creeping)))  # which says nothing
    assert len(steady_segments(unused)) == len(steady_segments(creeping))


def test_creeps_between_slips_are_no_strokes() -> None:
    """Of an axis that sticks at 50 µm/s, creeps at 30 µm/s were strokes: F_s was 64 (63.5 … 64.7) for 77 N."""
    rate, seed = 1000.0, np.random.default_rng(4)
    creep = np.full(300, 30e-6)
    slip = 400e-6 * np.sin(np.pi * np.arange(40) / 40) ** 2
    speed = np.concatenate([np.zeros(200), *([creep, slip] * 12), np.zeros(200)])
    t, z = np.arange(len(speed)) / rate, np.cumsum(speed) / rate
    force = 60.0 * (speed > 0) + seed.normal(size=len(t))
    asked = np.interp(t, [0.2, t[-1] - 0.2], [0.0, z[-1]])
    log = Log(time=t, position=encoder(z, 5e-8), force=force)
    assert not steady_segments(log)
    assert not steady_segments(replace(log, reference=asked))  # whose speed is 53 µm/s
    steady = one_segment(lambda tau: np.full(len(tau), 60.0))[0]
    assert len(steady_segments(replace(steady, reference=steady.position + 1e-5))) == 1  # lags, as without feedforward


def test_a_moment_at_the_end_of_a_long_record_is_no_stroke() -> None:
    """An axis that sticks on its way back crept for 0.1 s at 30 µm/s, beside a stroke of 10 s at 50 µm/s."""
    t, rng = np.arange(24_700) * 1e-3, np.random.default_rng(1)
    z = np.interp(t, [0, 2.4, 12.1, 12.4, 24.49, 24.6, 24.7], [0, 0, 485e-6, 485e-6, 485e-6, 481.8e-6, 481.8e-6])
    log = Log(time=t, position=z + rng.normal(0, 20e-9, len(t)), force=23.0 + rng.normal(0, 1.0, len(t)))
    assert [round(segment.velocity * 1e6) for segment in steady_segments(log)] == [50]

"""What a record is and is good for: on motions that are known, on bundled logs with their kind taken off, on flaws."""

from __future__ import annotations

import itertools
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import fric
from fric.documents.inspection import InspectionDocument
from fric.io.hdf5 import read_records
from fric.log import FrequencyResponse, Log
from fric.records.flaws import evened, record_flaws
from fric.records.inspection import inspect, is_at_rest
from fric.records.motion import find_reversals
from fric.records.prepared import prepared
from fric.records.recognition import LOOP_SHARE, force_rise, is_rigid, kind_of
from fric.simulate.experiment import experiment
from tests.identify.excited_axis import RATE, X, shaken
from tests.records.kinematics import encoder, strokes

DATA = Path(__file__).parents[2] / "data"
RNG = np.random.default_rng(0)


def uses(found):
    return {use.purpose: use for use in found.uses}


@pytest.mark.parametrize("name", ["constant-velocity", "presliding-sine", "sliding-sine", "frequency-response"])
def test_bundled_logs_are_recognised_without_their_kind(name):
    for log in read_records(DATA / f"{name}.h5"):
        stated, recognised = inspect(log), inspect(replace(log, kind=None))
        assert (stated.kind, stated.stated) == (name, True)
        assert (recognised.kind, recognised.stated) == (name, False)


def test_bundled_logs_are_good_for_what_they_were_made_for():
    good = {
        name: {
            purpose
            for log in read_records(DATA / f"{name}.h5")
            for purpose, use in uses(inspect(log)).items()
            if use.good
        }
        for name in ("constant-velocity", "presliding-sine", "sliding-sine", "frequency-response")
    }
    assert good == {
        "constant-velocity": {"static"},
        "presliding-sine": {"gms"},
        "sliding-sine": {"gms"},
        "frequency-response": {"plant"},
    }


def sine(amplitude=15e-6, frequency=0.1, step=2.5e-7, cycles=5, rate=500.0):
    time = np.arange(int(cycles / frequency * rate)) / rate
    position = amplitude * np.sin(2 * np.pi * frequency * time)
    force = 100.0 * np.sin(2 * np.pi * frequency * time + 0.5) + RNG.standard_normal(len(time))
    return Log(time=time, position=encoder(position, step), force=force)


@pytest.mark.parametrize(("amplitude", "frequency"), [(15e-6, 0.1), (450e-6, 0.1), (60e-6, 2.0)])
def test_amplitude_and_frequency_of_a_sine(amplitude, frequency):
    found = inspect(sine(amplitude, frequency))
    assert found.sine.frequency == pytest.approx(frequency, rel=1e-3)
    assert found.sine.amplitude == pytest.approx(amplitude, abs=2.5e-7)
    assert len(found.reversals) == 10
    assert found.encoder_step == pytest.approx(2.5e-7)


def test_a_large_loop_without_presliding_is_a_sliding_sine():
    log = sine(amplitude=5e-3)
    square = 100.0 * np.sign(np.gradient(log.position))
    assert inspect(replace(log, force=square)).kind == "sliding-sine"


def test_an_amplitude_below_three_steps_of_the_encoder_is_not_good_for_gms():
    use = uses(inspect(replace(sine(amplitude=0.6e-6), kind="presliding-sine")))["gms"]
    assert not use.good
    assert "steps of the encoder" in use.why


def test_strokes_give_their_speeds_and_a_triangle_is_no_sine():
    made = strokes([(1e-3, 1.0), (-1e-3, 1.0), (4e-3, 1.0), (-4e-3, 1.0)] * 2, rate=1000.0)
    found = inspect(Log(time=made.time, position=encoder(made.position, 2.5e-7), force=np.sign(made.velocity)))
    assert found.kind == "constant-velocity"
    assert found.speeds == pytest.approx([-4e-3, -1e-3, 1e-3, 4e-3], rel=1e-4)
    assert len(found.stretches) == 8
    triangle = 1e-3 * np.abs(np.arange(20_000) / 1000 % 2 - 1)
    found = inspect(Log(time=np.arange(20_000) / 1000, position=encoder(triangle, 2.5e-7)))
    assert (found.kind, found.sine) == ("constant-velocity", None)


def test_flaws_are_counted():
    log = sine()
    force, time = log.force.clip(-90.0, 80.0), log.time.copy()
    time[2000:] += 0.01
    found = inspect(replace(log, force=force, time=time, dropped=7))
    assert found.channels["force"].clipped == np.count_nonzero((force == 80.0) | (force == -90.0))
    assert found.channels["position"].clipped == 0
    assert [gap.intervals for gap in found.gaps] == pytest.approx([6.0])
    assert found.sampling == pytest.approx(500.0)
    assert found.dropped == 7
    assert "clipped" in uses(found)["gms"].why


def test_coarse_and_noisy_channels_are_not_clipped():
    log = sine()
    assert inspect(log).channels["force"].clipped == 0
    assert inspect(replace(log, force=np.round(log.force / 5.0) * 5.0)).channels["force"].clipped == 0
    assert inspect(replace(log, force=np.zeros(len(log)))).channels["force"].clipped == 0


def test_jitter_of_the_clock():
    log = sine()
    time = log.time + 1e-4 * RNG.standard_normal(len(log))
    assert inspect(replace(log, time=time)).jitter == pytest.approx(np.sqrt(2) * 1e-4, rel=0.05)


@pytest.mark.parametrize("samples", [2, 4, 5, 40])
def test_short_records_are_told_and_not_failed_on(samples):
    found = inspect(Log(time=np.arange(float(samples)), position=np.zeros(samples), force=np.zeros(samples)))
    assert not any(use.good for use in found.uses)
    json.dumps(InspectionDocument.made({"records": [found]}).tree(), allow_nan=False)


def test_a_frequency_response_as_measured():
    frequency = np.geomspace(1.0, 200.0, 40)
    found = inspect(FrequencyResponse(frequency, 1 / frequency**2, -np.ones(40), np.full(40, 0.9)))
    assert (found.kind, found.points, found.coherence) == ("frequency-response", 40, 0.9)
    assert uses(found)["plant"].good
    assert not uses(inspect(FrequencyResponse(frequency[:3], frequency[:3], -np.ones(3))))["plant"].good


def back_and_forth(shape, noise, seed=0):
    """Return a slow motion of 25 µm through twelve springs that slip one after the other, with the encoder's noise."""
    rng = np.random.default_rng(seed)
    ends = np.append(0.0, 25e-6 * (-1.0) ** np.arange(9) * (rng.uniform(0.6, 1.0, 9) if shape == "by hand" else 1.0))
    share = np.linspace(0.0, 1.0, 700)
    share = {"smooth": np.tanh(4.0 * (2.0 * share - 1.0)) / (2.0 * np.tanh(4.0)) + 0.5}.get(shape, share)
    pause = np.zeros(400 if shape == "with rests" else 0)
    path = np.concatenate([np.r_[a + (b - a) * share, b + pause] for a, b in itertools.pairwise(ends)])
    slip, levels = np.geomspace(0.5e-6, 30e-6, 12), np.full(12, 5.0)
    force, springs, before = np.zeros(len(path)), np.zeros(12), path[0]
    for i, at in enumerate(path):
        springs = np.clip(springs + levels / slip * (at - before), -levels, levels)
        before, force[i] = at, springs.sum()
    position = np.round((path + noise * rng.standard_normal(len(path))) / 1e-7) * 1e-7
    return Log(time=1e-3 * np.arange(len(path)), position=position, force=force + rng.standard_normal(len(path)))


@pytest.mark.parametrize("shape", ["triangle", "smooth", "by hand", "with rests"])
@pytest.mark.parametrize("noise", [0.0, 1e-7, 3e-7])
def test_a_slow_motion_back_and_forth_is_presliding_whatever_its_shape(shape, noise):
    found = inspect(back_and_forth(shape, noise))
    assert found.kind == "presliding-sine"
    assert len(found.reversals) == 8
    assert uses(found)["gms"].good


def test_a_fast_motion_back_and_forth_is_none():
    """Its force goes against the motion after a reversal, as inertia asks for."""
    time = np.arange(8000) / 1000.0
    angle = 2.0 * np.pi * 0.8 * time
    position = 0.1 * (np.sin(angle) + 0.2 * np.sin(3.0 * angle))
    acceleration = np.gradient(np.gradient(position, time), time)
    force = 100.0 * acceleration + 5.0 * np.sign(np.gradient(position)) + RNG.standard_normal(8000)
    assert inspect(Log(time=time, position=np.round(position / 1e-6) * 1e-6, force=force)).kind == "motion"


def test_viscous_friction_of_a_robot_is_no_presliding():
    """A force that rises with the speed comes up late after a reversal; a rigid body with friction explains it all."""
    time = np.arange(6000) / 250.0
    x = sum(a * np.sin(2.0 * np.pi * 0.05 * n * time) for n, a in enumerate((0.3, 0.3, -0.4, 0.2, 0.3), 1))
    v = np.gradient(x, time)
    force = 0.5 * np.gradient(v, time) + 8.0 * v + 2.5 * np.sign(v) + 0.05 * RNG.standard_normal(6000)
    log = Log(time=time, position=x, force=force, motion="rotary")
    assert force_rise(log, find_reversals(x)) > LOOP_SHARE
    assert inspect(log).kind == "motion"


def test_pick_and_place_is_of_a_rigid_body_whatever_friction_holds_at_rest():
    """A robot's moves passed for pre-sliding sines, for in their dwells no rigid body explained the force."""
    time, rng = np.arange(9000) / 250.0, np.random.default_rng(3)
    share = np.clip(np.linspace(0.0, 1.4, 300), 0.0, 1.0)
    moves = [a + (b - a) * share**3 * (10 - 15 * share + 6 * share**2) for a, b in itertools.pairwise(
        np.concatenate([[0.0], rng.uniform(-1.0, 1.0, 30)]))]  # fmt: skip
    x = np.concatenate(moves)
    v = np.gradient(x, time)
    held = np.repeat(rng.uniform(-1.0, 1.0, 30), 300)
    force = 0.8 * np.gradient(v, time) + 3.0 * v + 4.0 * np.where(np.abs(v) > 1e-4, np.sign(v), held)
    log = Log(time=time, position=x, force=force + 0.05 * rng.standard_normal(9000), motion="rotary")
    assert is_rigid(log)
    assert inspect(log).kind == "motion"


@pytest.mark.parametrize("velocity", [True, False])
def test_noise_is_no_motion(velocity):
    noise = np.random.default_rng(5).normal(0.0, 1e-6, 8000)
    assert is_at_rest(np.cumsum(noise) if velocity else noise)
    for hertz in (0.05, 1.0, 20.0):
        assert not is_at_rest(2e-5 * np.sin(2e-3 * np.pi * hertz * np.arange(8000)) + noise)


@pytest.mark.parametrize("of", ["stamps", "samples"])
def test_what_jitters_is_seen_by_the_motion(of):
    """Stamps that jitter by 4 % beside even samples made an acceleration of noise, and half of the mass."""
    rng, n = np.random.default_rng(6), 8000
    even = 1e-3 * np.arange(n)
    stamps = even + rng.uniform(0.0, 4e-5, n)
    taken = even if of == "stamps" else stamps
    kept = np.sort(rng.choice(np.arange(1, n - 1), int(0.97 * n), replace=False))
    log, notices = evened(Log(time=stamps[kept], position=(5.0 * np.sin(8.0 * taken))[kept], motion="rotary"))
    assert len(notices) == 1
    assert len(log) == kept[-1] - kept[0] + 1  # the period is that of the count, and not the median step's
    assert log.position is not None
    accelerations = np.diff(log.position, 2)[50:-50] * 1e6
    assert np.abs(accelerations).max() < (321.0 if of == "stamps" else 330.0)  # 5·8² rad/s²


def test_moves_of_many_lengths_are_no_frequency_response():
    """Their spectrum is broad, but they pause; a noise about rest or about a speed does not."""
    time, rng = np.arange(20_000) / 1000.0, np.random.default_rng(7)
    ends = np.concatenate([[0.0], rng.uniform(-0.1, 0.1, 40)])
    share = np.clip(np.linspace(0.0, 1.4, 500), 0.0, 1.0)
    moves = np.concatenate(
        [a + (b - a) * share**3 * (10 - 15 * share + 6 * share**2) for a, b in itertools.pairwise(ends)]
    )
    noise = np.cumsum(np.convolve(rng.standard_normal(20_000), np.ones(20), "same")) * 1e-5
    for position, kind in (
        (moves, "motion"),
        (noise, "frequency-response"),
        (noise + 0.05 * time, "frequency-response"),
    ):
        velocity = np.gradient(position, time)
        log = Log(time=time, position=position, input=np.gradient(velocity, time) + 5.0 * velocity, motion="linear")
        assert inspect(log).kind == kind


@pytest.mark.parametrize("periodic", [True, False])
def test_periods_show_an_excitation_that_an_encoder_step_hides(periodic):
    """A response along a ramp on a coarse encoder was a stroke; a regulated stroke, whose input is noise, still is."""
    rng, time = np.random.default_rng(11), np.arange(20_000) / 2000.0
    lines = rng.uniform(0.0, 2.0 * np.pi, 60)
    period = sum(np.sin(2.0 * np.pi * (k + 2) * time / 2.5 + phase) for k, phase in enumerate(lines))
    effort = period if periodic else 0.3 * rng.standard_normal(len(time))
    shaken = 1e-6 * np.cumsum(effort - effort.mean())
    position = 1e-5 * np.round((0.05 * time + shaken - np.linspace(0.0, shaken[-1], len(time))) / 1e-5)
    log = Log(time=time, position=position, input=1.0 + effort + 0.01 * rng.standard_normal(len(time)), motion="linear")
    assert inspect(log).kind == ("frequency-response" if periodic else "constant-velocity")


def test_a_spindle_of_one_direction_shows_friction_and_no_offset():
    time = np.arange(4000) / 100.0
    speed = np.interp(time, [0, 1, 12, 20, 28, 38, 40], [0, 0, 300, 120, 250, 0, 0])
    rest = 1e-4 * RNG.standard_normal(4000) * (speed == 0.0)
    log = Log(time=time, velocity=speed + rest, force=1.4 + 4e-3 * speed, motion="rotary")
    (record,) = prepared([log])
    assert record.done.own == ("mass",)
    assert record.used.mean() > 0.8


def test_noise_makes_no_reversals_in_a_long_rest():
    rng = np.random.default_rng(4)
    path = np.repeat(np.r_[np.linspace(0.0, 1.0, 50), np.full(60_000, 1.0), np.linspace(1.0, 0.0, 50)], 2)
    position = 1e-4 * path + 1e-6 * rng.standard_normal(len(path))
    log = Log(time=1e-3 * np.arange(len(path)), position=position, force=np.zeros(len(path)))
    assert len(inspect(log).reversals) == 1


@pytest.mark.parametrize("cycles", [5, 20])
def test_a_sine_in_sliding_is_no_stroke(cycles: int) -> None:
    """6 ± 2.5 mm/s was taken for a stroke, polluted the map, and was missing for C."""
    axis = fric.read_machine("virtual-rig").axis("x")
    (log,) = experiment(axis, "sliding-sine", mean=6e-3, swing=2.5e-3, frequency=1.0, cycles=cycles, samples=2000)
    assert inspect(replace(log, kind=None)).kind == "sliding-sine"
    (stroke,) = experiment(axis, "constant-velocity", speeds=[6e-3], samples=2000)
    assert inspect(replace(stroke, kind=None)).kind == "constant-velocity"


def test_a_loop_that_hunts_turns_no_sine_more_often() -> None:
    """Turns of 0.2 µm behind each reversal of a sine of 40 µm left "3 samples through pre-sliding", and no blocks."""
    t = np.arange(15_000) / 500.0
    asked, hunts = 40e-6 * np.sin(2 * np.pi * 0.1 * t), 0.1e-6 * np.sin(2 * np.pi * 43.0 * t)
    speed = np.gradient(asked, t)
    z = asked + hunts * np.exp(-((speed / 5e-6) ** 2))
    found = inspect(Log(t, encoder(z, 20e-9), force=40.0 * np.tanh(speed / 15e-6)))
    assert (found.kind, len(found.reversals)) == ("presliding-sine", 6)
    assert len(find_reversals(encoder(z, 20e-9))) > 20
    there = 100e-6 * np.clip(np.minimum(t - 5.0, 15.0 - t) / 2.0, 0.0, 1.0)
    force = 40.0 * np.sign(np.gradient(there, t))
    assert inspect(Log(t, encoder(there + hunts, 20e-9), force=force)).kind != "presliding-sine"


def test_a_start_before_a_multisine_does_not_make_it_a_stroke() -> None:
    """A heavy axis swings by 5 % in speed: the ramp of the start was the tallest line, and the response a stroke."""
    record = shaken(X, seed=3, peak=0.5, mean=0.03)
    start = 0.5 * 0.03 * np.arange(RATE // 2) ** 2 / RATE / (RATE // 2)
    z, u = np.asarray(record.position), np.asarray(record.input)
    position, input = np.concatenate([start, start[-1] + z - z[0]]), np.concatenate([0.0 * start, u])
    log = Log(np.arange(len(position)) / RATE, position=position, input=input)
    assert kind_of(log) == "frequency-response"


def test_an_encoder_step_a_thousand_times_that_of_others_is_another_unit() -> None:
    """Two of 17 strokes in mm for µm: F_c was 79.6 (76.2 … 83.0) for 63.3 N."""
    sound = list(read_records(DATA / "constant-velocity.h5"))
    mixed = [replace(log, position=1e3 * log.position) if n in {3, 8} else log for n, log in enumerate(sound)]
    for logs, told in ((sound, False), (mixed, True)):
        assert ("position-unit-differs" in {notice.code for notice in record_flaws(logs, "static")}) == told


def test_jitter_at_rest_before_a_sine_in_sliding_is_no_reversal() -> None:
    """21 ms of it made a motion of the sine, and C was assumed."""
    t = np.arange(8000) / 1000.0
    z = 4e-3 * t - 3e-3 / (2 * np.pi * 3) * (np.cos(2 * np.pi * 3 * t) - 1.0)
    jitter = 1e-7 * np.array([0, -4, -8, -2, 4, 0, -5, -1, 2, -1, -3, 0, 1, -3, 0])
    position = np.concatenate([jitter, encoder(z, 1e-7)])
    force = np.concatenate([np.zeros(15), 100.0 + 5.0 * np.cos(2 * np.pi * 3 * t)])
    log = Log(np.arange(len(position)) / 1000.0, position=position, force=force)
    assert kind_of(log) == "sliding-sine"

"""Flaws of the log: what a drive's trace makes of a motion, held against the same motion without them."""

import weakref
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from scipy.signal import freqz

from fric.documents.machine_files import read_machine
from fric.drive.plant import LinearPlant, SampledPlant
from fric.drive.sensing import Encoder, low_pass_pole
from fric.errors import FricError
from fric.kernels.sensing import read
from fric.log import Log
from fric.simulate.axis import run_axis
from fric.simulate.experiment import constant_velocity, experiment, frequency_response, presliding_sine
from fric.simulate.reality.flaws import Clock, ForceChannel, Interpolation, NoiseColour, Reality
from fric.simulate.reality.motion import sensing_of
from fric.simulate.reality.trace import _between, _driven

MACHINES = Path("configs/reality")
BASE = read_machine(MACHINES / "base.yaml").axis("x")
IDEAL = replace(BASE, encoder=Encoder(), force_noise=0.0)


def excited(reality: Reality, seed: int = 0) -> Log:
    """Return a record at the controller's rate, with the lines that carry the most."""
    (log,) = frequency_response(replace(IDEAL, reality=reality), periods=2, seed=seed)
    return log


def ratio(log: Log, plain: Log, channel: str) -> tuple[np.ndarray, np.ndarray]:
    """Return frequencies [Hz] below 300 Hz, and what became of a channel's lines there."""
    flawed, whole = (np.fft.rfft(getattr(one, channel) - getattr(one, channel)[0]) for one in (log, plain))
    f = np.fft.rfftfreq(len(plain), 1 / 4000)
    lines = np.flatnonzero((np.abs(whole) > 0.03 * np.abs(whole).max()) & (f > 1) & (f < 300))
    return f[lines], flawed[lines] / whole[lines]


PLAIN = excited(Reality())


def test_a_long_run_is_read_between_its_samples_as_by_a_spline_through_all_of_them():
    rng = np.random.default_rng(7)
    run = np.cumsum(rng.normal(size=2_300_000)) * 1e-6
    at = np.sort(rng.uniform(0, len(run) - 1, 3000))
    whole = CubicSpline(np.arange(len(run)), run)(at)
    np.testing.assert_allclose(_between(run, at), whole, rtol=0, atol=1e-15 * np.abs(run).max())
    read = _between(run, at, lambda places: 0.5 * np.interp(places, [0, len(run)], [0, 1e-3]))
    np.testing.assert_allclose(read, whole, rtol=0, atol=1e-14 * np.abs(run).max())


def test_a_run_is_let_go_before_the_next(monkeypatch):
    made: list[weakref.ref] = []

    def run(axis, *arguments, **settings):
        assert not any(earlier() for earlier in made)
        trace = run_axis(axis, *arguments, **settings)
        made.append(weakref.ref(trace))
        return trace

    monkeypatch.setattr("fric.simulate.experiment.run_axis", run)
    assert len(presliding_sine(IDEAL, amplitudes=[15e-6, 30e-6, 45e-6], frequency=1.0, cycles=1)) == len(made) == 3


@pytest.mark.parametrize("lag", [0.0, 0.25e-3, 0.6e-3, 1e-3])
def test_a_force_that_lags_is_late_by_that_time(lag: float) -> None:
    f, change = ratio(excited(Reality(force=ForceChannel(lag=lag))), PLAIN, "force")
    delay = -np.polyfit(2 * np.pi * f, np.unwrap(np.angle(change)), 1, w=np.abs(change))[0]
    assert delay == pytest.approx(lag, abs=2e-6)


def test_a_filtered_force_is_behind_the_low_pass_of_the_drive() -> None:
    f, change = ratio(excited(Reality(force=ForceChannel(filter=300.0))), PLAIN, "force")
    p = low_pass_pole(300.0, 4000)
    _, expected = freqz([1 - p], [1, -p], worN=f, fs=4000)
    np.testing.assert_allclose(change, expected, atol=0.03)  # a record of two periods leaks a little


def test_a_position_that_is_logged_late_is_that_of_before() -> None:
    late, plain = (constant_velocity(replace(IDEAL, reality=r), speeds=[0.02])[0]
                   for r in (Reality(clock=Clock(position=0.4e-3)), Reality()))  # fmt: skip
    at_speed = slice(900, 1400)
    np.testing.assert_allclose((plain.position - late.position)[at_speed], 0.02 * 0.4e-3, rtol=2e-3)
    np.testing.assert_array_equal(plain.force, late.force)


def test_a_position_between_two_samples_is_that_of_the_plant_behind_its_hold() -> None:
    """What a held voltage adds is known there: a spline through the samples alone is 0.4 % off at 500 Hz."""
    plant, late = BASE.plant, 0.4e-3
    f = np.array([10.0, 100.0, 300.0, 500.0])
    exact = [SampledPlant.of(LinearPlant(0.0, plant.B, plant.T_d + add), 4000).response(f, 4000) for add in (late, 0.0)]
    n = np.arange(12_001)
    u = np.sum([np.cos(2 * np.pi * one * n / 4000) for one in f], axis=0)
    at = np.arange(4000.0, 8000.0)
    moved = _driven(BASE, u)
    z = moved(n.astype(float))
    lines = np.rint(f).astype(int)
    rise = np.mean(z[8000:12_000] - z[4000:8000]) / 4000
    found = [np.fft.rfft(w - rise * at)[lines] for w in (_between(z, at - late * 4000, moved), _between(z, at))]
    np.testing.assert_allclose(found[0] / found[1], exact[0] / exact[1], atol=3e-4)


def test_a_force_in_steps_of_the_current_lies_on_them() -> None:
    log = presliding_sine(replace(BASE, reality=Reality(force=ForceChannel(step=4.0))), amplitudes=[15e-6], cycles=1)[0]
    np.testing.assert_allclose(log.force / 4.0, np.rint(log.force / 4.0), atol=1e-6)
    assert len(np.unique(log.force)) > 10


def test_coloured_noise_has_the_size_and_the_memory_that_were_asked_for() -> None:
    settings = {"amplitudes": [15e-6], "cycles": 2, "samples": 80_000}
    clean = presliding_sine(IDEAL, **settings)[0]
    noise = NoiseColour(3.0, 20.0)
    log = presliding_sine(replace(IDEAL, reality=Reality(noise=noise)), seed=1, **settings)[0]
    rest = log.force - clean.force
    # 20 s of noise with a memory of 8 ms hold some 1250 independent values: four standard errors are 8 %
    assert rest.std() == pytest.approx(3.0, rel=0.08)
    for lag in (1, 10, 40):
        expected = low_pass_pole(20.0, 4000) ** lag
        assert np.mean(rest[lag:] * rest[:-lag]) / rest.var() == pytest.approx(expected, abs=0.08)


def test_lost_samples_leave_gaps_in_a_time_that_is_stamped_and_jumps_in_one_that_is_not() -> None:
    told, undetermined, whole = (
        constant_velocity(replace(IDEAL, reality=Reality(clock=clock)), speeds=[0.02], seed=2)[0]
        for clock in (Clock(lost=0.05), Clock(lost=0.05, stamped=False), Clock())
    )
    assert len(told) == len(undetermined)
    assert len(told) / len(whole) == pytest.approx(0.95, abs=0.02)
    assert set(told.time) < set(whole.time)
    np.testing.assert_array_equal(told.position, undetermined.position)
    usual = np.median(np.diff(whole.time))
    np.testing.assert_allclose(np.diff(undetermined.time), usual, rtol=1e-6)
    gaps = np.rint(np.diff(told.time) / usual)
    assert gaps.max() > 1
    assert gaps.sum() == len(whole) - 1


def test_jitter_moves_the_instants_and_the_time_tells_it_or_not() -> None:
    told, undetermined = (
        constant_velocity(replace(IDEAL, reality=Reality(clock=Clock(jitter=60e-6, stamped=s))), speeds=[0.02])[0]
        for s in (True, False)
    )
    np.testing.assert_array_equal(told.position, undetermined.position)
    off = told.time - undetermined.time
    assert off.std() == pytest.approx(60e-6, rel=0.1)
    at_speed = slice(900, 1400)
    straight = np.polyfit(told.time[at_speed], told.position[at_speed], 1)
    assert np.std(told.position[at_speed] - np.polyval(straight, told.time[at_speed])) < 1e-8
    assert np.std(undetermined.position[at_speed] - np.polyval(straight, undetermined.time[at_speed])) > 1e-6


def test_the_encoder_errs_with_the_pitch_of_its_scale_and_the_controller_follows_it() -> None:
    axis = replace(IDEAL, reality=Reality(encoder=Interpolation(0.3e-6, 20e-6, 0.6)))
    (log,) = constant_velocity(axis, speeds=[1e-4], samples=100_000)
    at_speed = slice(3000, 20_000)
    reference, told = log.reference[at_speed], log.position[at_speed]
    # at 5 Hz the loop holds what the encoder tells at the reference, so that the error is in the true position
    assert np.std(told - reference - np.mean(told - reference)) < 0.1e-6
    true = np.linspace(0, 60e-6, 301)
    seen = true.copy()
    read(seen, axis.encoder.resolution, sensing_of(axis))
    np.testing.assert_allclose(seen - true, 0.3e-6 * np.sin(2 * np.pi * true / 20e-6 + 0.6), atol=1e-15)


def test_a_seed_gives_the_same_digits_and_the_noise_of_a_machine_without_flaws_is_not_drawn_anew() -> None:
    axis = read_machine(MACHINES / "all.yaml").axis("x")
    first, second = (
        presliding_sine(axis, amplitudes=[15e-6], frequency=0.5, cycles=1, samples=500, seed=n)[0].sha256
        for n in (3, 3)
    )
    assert first == second
    quiet = replace(BASE, reality=Reality(clock=Clock(lost=0.1)))
    whole, part = (
        presliding_sine(a, amplitudes=[15e-6], frequency=0.5, cycles=1, samples=500)[0] for a in (BASE, quiet)
    )
    kept = np.isin(whole.time, part.time)
    np.testing.assert_array_equal(whole.force[kept], part.force)


def test_every_machine_of_the_bench_is_the_base_machine_with_its_flaw() -> None:
    files = sorted(MACHINES.glob("*.yaml"))
    assert len(files) >= 20
    for file in files:
        machine = read_machine(file)
        axis = machine.axis("x")
        assert replace(axis, reality=Reality(), second_mass=None) == BASE
        assert machine.axis("y") == read_machine(MACHINES / "base.yaml").axis("y")
        assert (axis == BASE) == (file.stem == "base")


def test_a_sparse_multisine_has_the_lines_of_the_machine_and_a_setting_stands_over_it() -> None:
    axis = read_machine(MACHINES / "sparse-lines.yaml").axis("x")
    (log,) = experiment(replace(axis, encoder=Encoder(), force_noise=0.0), "frequency-response", periods=2)
    assert np.abs(log.reference).max() == 0.0
    (other,) = frequency_response(axis, periods=2, lowest=5.0, mean=30e-3)
    assert other.time[-1] == pytest.approx(2 / 5.0, abs=1e-3)
    assert np.ptp(other.reference) > 5e-3


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ("force: {lag: 2 N}", "reality.force.lag"),
        ("force: {delay: 1 ms}", "not a known key"),
        ("clock: {lost: 120 %}", "lost of clock is 1.2"),
        ("waves: [{amplitude: 60 %, pitch: 3 mm}, {amplitude: 50 %, pitch: 4 mm}]", "together reach 1"),
        ("cogging: [{force: 3 N, pitch: 0 mm}]", "pitch of cogging is 0"),
        ("noise: {force: 3 N}", "corner"),
    ],
)
def test_what_is_no_flaw_is_told_with_its_place(tmp_path: Path, given: str, told: str) -> None:
    file = tmp_path / "machine.yaml"
    base = (MACHINES / "base.yaml").resolve()
    file.write_text(f"fric: machine/1\nlike: {base}\naxes:\n  x:\n    reality:\n      {given}\n")
    with pytest.raises(FricError) as error:
        read_machine(file)
    assert told in str(error.value)
    assert str(file) in str(error.value)

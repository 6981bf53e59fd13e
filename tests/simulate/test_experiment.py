from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fric.documents.machine_files import read_machine
from fric.drive.sensing import Encoder
from fric.errors import FricError
from fric.friction.gms import GMS
from fric.io.hdf5 import read_records, write_logs
from fric.kernels.loop import closed_loop
from fric.log import Log
from fric.reference import Reference
from fric.reproduce.paper import SAMPLES
from fric.simulate.axis import run_axis
from fric.simulate.experiment import (
    EXPERIMENTS,
    OF_THE_PAPER,
    constant_velocity,
    experiment,
    frequency_response,
    presliding_sine,
    sliding_sine_around,
)
from fric.simulate.machine import Axis

XY_TABLE = read_machine(Path("configs/xy-table.yaml"))
AXIS = XY_TABLE.axis("x")
IDEAL = replace(AXIS, encoder=Encoder(), force_noise=0.0)


def steady(log: Log, direction: int) -> np.ndarray:
    """Return the force in the second half of the stroke, where the reference keeps its speed."""
    assert log.reference is not None
    assert log.force is not None
    v = np.gradient(log.reference, log.time)
    at_speed = np.flatnonzero(np.abs(v - direction * np.abs(v).max()) < 1e-6 * np.abs(v).max())
    return log.force[at_speed[len(at_speed) // 2 : -5]]


@pytest.mark.parametrize("speed", [1e-5, 2e-4, 1e-3, 30e-3])
@pytest.mark.parametrize("name", ["x", "y"])
def test_force_in_steady_sliding_is_the_static_map_and_the_drive_s_own_damping(speed: float, name: str) -> None:
    axis = replace(XY_TABLE.axis(name), encoder=Encoder(), force_noise=0.0)
    (log,) = constant_velocity(axis, speeds=[speed])
    for direction in (1, -1):
        v = direction * speed
        expected = float(axis.friction.steady_state(v)) + axis.plant.M * axis.plant.A * v
        np.testing.assert_allclose(steady(log, direction), expected, rtol=1e-6)


def test_a_constant_load_adds_to_the_force_in_both_directions() -> None:
    plain, loaded = (constant_velocity(axis, speeds=[1e-2])[0] for axis in (IDEAL, replace(IDEAL, load=12.5)))
    for direction in (1, -1):
        assert np.mean(steady(loaded, direction) - steady(plain, direction)) == pytest.approx(12.5, rel=1e-6)


def test_a_contact_that_is_too_stiff_to_be_integrated_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """A block of 3e12 N/m, which swings at 17 kHz, takes hundreds of steps a sample: a minute was spent on it."""
    gms = AXIS.friction
    assert isinstance(gms, GMS)
    made: list[int] = []

    def counted(*given: Any) -> Any:
        traces, saturated = closed_loop(*given)
        made.append(int(np.isfinite(traces.position).sum()))
        return traces, saturated

    monkeypatch.setattr("fric.simulate.axis.closed_loop", counted)
    with pytest.raises(FricError, match="too stiff"):
        list(experiment(replace(AXIS, friction=replace(gms, k=(3e12, *gms.k[1:]))), "micro-steps"))
    assert made[0] < 100_000


def test_a_long_record_is_integrated_in_longer_steps(monkeypatch: pytest.MonkeyPatch) -> None:
    """To the last digits, a sine of ten minutes takes a minute of a processor, and its record is the same."""
    accuracies: list[float] = []

    def seen(axis: Axis, reference: Reference, **given: Any) -> Any:
        accuracies.append(given["accuracy"])
        return run_axis(axis, reference, **given)

    monkeypatch.setattr("fric.simulate.experiment.run_axis", seen)
    forces = []
    for _ in range(2):
        (log,) = presliding_sine(IDEAL, amplitudes=[15e-6], cycles=1, samples=500)
        forces.append(log.require("force", "this test"))
        monkeypatch.setattr("fric.simulate.experiment.LONG", 10_000)
    exact, coarse = accuracies
    assert exact == 0.0 < coarse <= 1e-9
    np.testing.assert_allclose(forces[1], forces[0], atol=1e-3 * np.ptp(forces[0]))


def test_every_stroke_leaves_presliding_behind() -> None:
    last_block = 0.039 / 1.002 * 165 / 0.119e6
    (log,) = constant_velocity(IDEAL, speeds=[1e-5])
    assert log.position is not None
    assert np.ptp(log.position) > 4 * 2 * last_block


def test_noise_has_the_spread_that_was_asked_for_and_a_new_seed_draws_anew() -> None:
    clean = presliding_sine(IDEAL, amplitudes=[15e-6], cycles=2)[0].force
    noisy = [
        presliding_sine(replace(IDEAL, force_noise=3.0), amplitudes=[15e-6], cycles=2, seed=n)[0].force for n in (1, 2)
    ]
    assert clean is not None
    first, second = (force - clean for force in noisy if force is not None)
    assert first.std() == pytest.approx(3.0, rel=0.06)  # 4 standard errors of 4000 samples
    assert abs(np.corrcoef(first, second)[0, 1]) < 0.06


def test_the_encoder_tells_whole_steps_alone() -> None:
    for log in experiment(replace(AXIS, encoder=Encoder(1e-6)), "sliding-sine"):
        assert log.position is not None
        np.testing.assert_allclose(log.position / 1e-6, np.rint(log.position / 1e-6), atol=1e-6)


def test_the_same_seed_gives_the_same_digits_and_kinds_do_not_disturb_each_other() -> None:
    short = {"cycles": 1, "samples": 500}
    first, second, other = (presliding_sine(AXIS, amplitudes=[15e-6], seed=n, **short)[0].sha256 for n in (3, 3, 4))
    assert first == second
    assert first != other
    assert presliding_sine(AXIS, amplitudes=[15e-6, 30e-6], seed=3, **short)[0].sha256 == first


def test_a_slow_sine_returns_to_its_loop() -> None:
    (log,) = presliding_sine(IDEAL, amplitudes=[15e-6], samples=4000)
    assert log.force is not None
    assert log.position is not None
    cycles = log.force.reshape(5, 800)
    np.testing.assert_allclose(cycles[1:], np.broadcast_to(cycles[1], (4, 800)), atol=0.01)
    assert np.abs(log.position).max() == pytest.approx(15e-6, rel=1e-3)


def test_sliding_never_turns() -> None:
    (log,) = sliding_sine_around(IDEAL)
    assert log.position is not None
    v = np.gradient(log.position, log.time)
    assert v.min() > 0
    assert np.median(v) == pytest.approx(2e-3, rel=0.05)


def test_the_multisine_shows_the_plant_of_eq_1_with_the_hold_of_the_controller() -> None:
    (log,) = frequency_response(AXIS)
    assert log.position is not None
    assert log.input is not None
    assert AXIS.cascade.limit > np.abs(log.input).max()
    periods, n = 8, len(log) // 8
    u = np.fft.rfft(log.input.reshape(periods, n).mean(axis=0))
    position = log.position - np.polyval(np.polyfit(log.time, log.position, 1), log.time)
    z = np.fft.rfft(position.reshape(periods, n).mean(axis=0))
    lines = np.unique(np.rint(np.geomspace(1, 250, 60))).astype(int)
    lines = lines[lines >= 5]
    f = np.fft.rfftfreq(n, AXIS.cascade.T_s)[lines]
    hold = np.sinc(f * AXIS.cascade.T_s)  # its delay of half a sample is in T_d
    ratio = z[lines] / u[lines] / (AXIS.plant.response(f) * hold)
    np.testing.assert_allclose(np.abs(ratio), 1.0, atol=0.015)
    np.testing.assert_allclose(np.degrees(np.angle(ratio)), 0.0, atol=1.0)


def test_a_log_passes_through_its_file_and_holds_no_truth(tmp_path: Path) -> None:
    logs = list(experiment(AXIS, "presliding-sine", amplitudes=[15e-6], samples=500))
    write_logs(tmp_path / "log.h5", logs)
    (read,) = read_records(tmp_path / "log.h5")
    assert isinstance(read, Log)
    assert (read.kind, read.axis, read.motion, read.sha256) == ("presliding-sine", "x", "linear", logs[0].sha256)
    assert set(read.channels()) == {"time", "position", "force", "input", "reference"}
    for channel, values in logs[0].channels().items():
        np.testing.assert_array_equal(read.channels()[channel], values)


def test_of_all_experiments_each_takes_the_settings_it_knows() -> None:
    logs = list(experiment(IDEAL, "all", samples=300, speeds=[0.01], amplitudes=[15e-6]))
    assert [log.kind for log in logs] == list(OF_THE_PAPER)
    assert all(len(log) <= 300 for log in logs[:3])
    assert len(logs[3]) == 16_000  # the controller's rate: a longer step would lose the upper frequencies


def test_kinds_and_settings_that_do_not_exist_are_told() -> None:
    with pytest.raises(FricError, match="'sliding-sine' has no setting 'speeds'"):
        list(experiment(AXIS, "sliding-sine", speeds=[0.01]))
    with pytest.raises(FricError, match="no experiment 'drop'"):
        list(experiment(AXIS, "drop"))
    with pytest.raises(FricError, match="half the controller's rate"):
        frequency_response(AXIS, highest=3000.0)
    with pytest.raises(FricError, match="no peak velocity above zero"):
        frequency_response(AXIS, mean=0.0)
    with pytest.raises(FricError, match="reverses the motion"):
        sliding_sine_around(AXIS, mean=1e-3, swing=2e-3)
    assert set(EXPERIMENTS) == {
        "constant-velocity", "presliding-sine", "micro-steps", "sliding-sine", "frequency-response",
    }  # fmt: skip


def test_the_reproduction_makes_the_paper_s_records() -> None:
    assert set(SAMPLES) == set(OF_THE_PAPER)

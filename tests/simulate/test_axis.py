from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from fric.control.cascade import Cascade
from fric.control.feedforward import friction_feedforward
from fric.control.scheme import NONE, PAPER_SCHEMES
from fric.design.loop import SampledLoop, margins
from fric.documents.machine_files import read_machine
from fric.drive.plant import Plant
from fric.drive.sensing import Encoder
from fric.errors import FricError
from fric.friction.stribeck import StaticMap
from fric.kernels.loop import closed_loop
from fric.kernels.plant import WORK
from fric.kernels.signatures import compiled_step
from fric.process import heard
from fric.reference import Reference, sine, strokes
from fric.simulate.axis import _loop_arguments, run_axis
from fric.simulate.machine import Axis, NominalFriction
from tests.friction.instances import INSTANCES
from tests.simulate.plain_loop import counted, plain_loop

MACHINE = read_machine(Path("configs/xy-table.yaml"))
IDEAL = replace(MACHINE.axis("x"), encoder=Encoder())
REVERSALS = sine(1e-3, 2.9, 1, 4000.0, run_in=0.5)
"""Three reversals with the acceleration that a circle of 30 mm at 100 mm/s has there, 0.33 m/s²."""


@pytest.mark.parametrize(
    ("scheme", "axis"),
    [
        pytest.param("f", IDEAL, marks=pytest.mark.long(4)),
        pytest.param("a", MACHINE.axis("x"), marks=pytest.mark.long(2)),
        ("f", MACHINE.axis("x")),
        pytest.param("a", MACHINE.axis("x").placed(0.3), marks=pytest.mark.long(3)),
    ],
    ids=["f, no encoder", "a", "f", "a, between counts"],
)
def test_the_loop_agrees_with_a_plain_one_written_apart(scheme: str, axis: Axis) -> None:
    """Within 0.02 µm is asked for. With an encoder on, nothing less will do than the same count in every sample."""
    chosen = PAPER_SCHEMES[scheme]
    ahead = np.zeros(len(REVERSALS))
    if chosen.friction:
        ahead = friction_feedforward(
            axis.nominal_friction.models["gms"], REVERSALS, axis.plant.K_f, axis.nominal_friction.gain
        )
    position, voltage = plain_loop(axis, REVERSALS, ahead, observer=chosen.observer)
    assert np.abs(position - REVERSALS.position).max() > 1e-6
    run = run_axis(axis, REVERSALS, chosen)
    assert np.abs(run.measured - counted(axis.encoder, position)).max() < 1e-11
    assert np.abs(run.position - position).max() < 1e-11
    assert np.abs(run.input - voltage).max() < 1e-7


def test_counts_that_lie_elsewhere_are_the_same_motion_elsewhere() -> None:
    """With counts moved by 0.3 of a count an axis does at 0 what it did 0.3 counts above, with counts as they were."""
    axis, above = MACHINE.axis("x"), 0.3 * MACHINE.axis("x").encoder.resolution
    placed = run_axis(axis.placed(0.3), REVERSALS)
    moved = run_axis(axis, replace(REVERSALS, position=REVERSALS.position + above))
    assert np.abs(placed.position + above - moved.position).max() < 1e-11
    assert np.abs(placed.measured + above - moved.measured).max() < 1e-11
    assert np.abs(placed.position - run_axis(axis, REVERSALS).position).max() > 1e-9


@pytest.mark.parametrize("name", INSTANCES)
def test_halving_the_plant_step_changes_nothing_whatever_the_friction(name: str) -> None:
    axis = replace(IDEAL, friction=INSTANCES[name])
    usual, halved = (run_axis(axis, REVERSALS, halvings=n) for n in (0, 1))
    assert np.abs(usual.position - REVERSALS.position).max() > 1e-6
    assert np.abs(usual.position - halved.position).max() < 5e-12
    assert np.abs(usual.velocity - halved.velocity).max() < 5e-9


@compiled_step
def rough(dz: float, v: float, dt: float, state: np.ndarray, parameters: np.ndarray) -> float:
    """Friction that no step is short enough for, with teeth of a picometre and 1 N; it counts how often it is asked."""
    state[0] += dz
    parameters[0] += 1.0
    return 100.0 * np.tanh(v / 1e-3) + (state[0] * 1e12) % 1.0


@compiled_step
def smoothed(dz: float, v: float, dt: float, state: np.ndarray, parameters: np.ndarray) -> float:
    parameters[0] += 1.0
    return 100.0 * np.tanh(v / 1e-3) + 0.5


def test_friction_that_is_nowhere_smooth_is_simulated_all_the_same() -> None:
    others = _loop_arguments(IDEAL, REVERSALS, NONE)[3:]
    (teeth, asked), (mean, fewer) = (
        (closed_loop(friction, np.zeros(1), calls, *others)[0], calls[0] / len(REVERSALS))
        for friction, calls in ((rough, np.zeros(1)), (smoothed, np.zeros(1)))
    )
    assert np.abs(teeth.position - mean.position).max() < 10e-9
    assert fewer < 100
    assert asked < 4 * WORK


@compiled_step
def constant(dz: float, v: float, dt: float, state: np.ndarray, parameters: np.ndarray) -> float:
    parameters[0] += 1.0
    return np.tanh(1e3 * v)


@pytest.mark.parametrize(("v_0", "M"), [(3000.0, 1e3), (1.0, 1e-7)], ids=["fast", "light"])
def test_rounding_of_large_velocities_and_forces_is_no_corner(v_0: float, M: float) -> None:
    """A motor at 3000 rad/s, and one of 1e-7 kg·m² that 1 N·m brakes and 1 N·m drives."""
    _, _, _, plant, board, _, command = _loop_arguments(IDEAL, REVERSALS, NONE)
    motor = plant._replace(A=3.0, M=M, load=-1.0, v_0=v_0)
    calls = np.zeros(1)
    run, _ = closed_loop(constant, np.zeros(1), calls, motor, board, [], command)
    assert calls[0] < 25 * len(REVERSALS)
    assert run.velocity[-1] == pytest.approx(v_0 * np.exp(-3.0 * REVERSALS.time[-1]), abs=2.0)


@pytest.mark.parametrize("delay", [0.0, 0.025e-3, 0.2499e-3, 0.25e-3, 0.525e-3, 0.8123e-3])
def test_a_delay_that_is_no_number_of_steps_shifts_the_response_by_itself(delay: float) -> None:
    T = 0.25e-3
    plant = Plant(A=28.57, B=4.526, T_d=delay + T / 2, K_f=548.0)
    hands_off = Cascade(K_v=1e-12, K_p=1e-12, K_i=0.0, velocity_filter=500.0, sampling=1 / T)
    axis = Axis("x", plant, hands_off, StaticMap(0.0, 0.0, 1.0))
    still = Reference(1 / T, *(np.zeros(200) for _ in range(3)))
    step = np.where(np.arange(200) >= 10, 1.0, 0.0)
    found = run_axis(axis, still, excitation=step).position
    t = np.maximum(still.time - 10 * T - delay, 0.0)
    exact = plant.B / plant.A * (t - (1 - np.exp(-plant.A * t)) / plant.A)
    np.testing.assert_allclose(found, exact, atol=1e-6 * exact.max())


def test_what_the_motor_gives_is_stored_or_dissipated() -> None:
    reference = strokes(20e-3, 2e-3, 4000.0)
    axis = replace(IDEAL, load=20.0)
    run, plant = run_axis(axis, reference), axis.plant
    fine = np.arange(0, reference.time[-1], 1e-6)
    v, F = (np.interp(fine, run.time, values) for values in (run.velocity, run.friction))
    hold = np.clip(((fine - plant.transport_delay(4000.0)) * 4000.0).astype(int), 0, None)
    u = np.where(fine >= plant.transport_delay(4000.0), run.input[hold], 0.0)
    given = np.trapezoid(plant.K_f * u * v, fine)
    kinetic = 0.5 * plant.M * v[-1] ** 2
    spent = np.trapezoid((plant.damping * v + F + axis.load) * v, fine)
    assert given == pytest.approx(kinetic + spent, rel=2e-3)
    assert np.trapezoid(F * v, fine) > 0.5 * given


def test_a_run_repeats_to_the_last_digit() -> None:
    axis = MACHINE.axis("x")
    for scheme in PAPER_SCHEMES.values():
        first, second = (run_axis(axis, REVERSALS, scheme) for _ in range(2))
        np.testing.assert_array_equal(first.position, second.position)
        np.testing.assert_array_equal(first.input, second.input)


def test_friction_without_memory_holds_below_its_level_and_slides_above() -> None:
    friction = StaticMap(F_c=105.0, F_s=165.0, v_s=1e-3)
    hands_off = replace(IDEAL.cascade, K_v=1e-12, K_p=1e-12, K_i=0.0)
    axis = replace(IDEAL, friction=friction, cascade=hands_off)
    still = Reference(4000.0, *(np.zeros(2000) for _ in range(3)))
    for share, moves in ((0.99, False), (-0.99, False), (1.01, True), (-1.01, True)):
        run = run_axis(axis, still, excitation=np.full(2000, share * 165.0 / axis.plant.K_f))
        assert bool(np.abs(run.position[-1]) > 1e-4) == moves
        if moves:
            assert np.sign(run.position[-1]) == np.sign(share)
        else:
            assert np.all(run.position == 0.0)
            assert run.friction[-1] == pytest.approx(share * 165.0, rel=1e-9)


def test_gms_friction_holds_a_load_below_break_away_for_good() -> None:
    hands_off = replace(IDEAL.cascade, K_v=1e-12, K_p=1e-12, K_i=0.0)
    axis = replace(IDEAL, cascade=hands_off)
    still = Reference(4000.0, *(np.zeros(40_000) for _ in range(3)))
    run = run_axis(axis, still, excitation=np.full(40_000, 100.0 / axis.plant.K_f))
    assert np.ptp(run.position[20_000:]) < 1e-9
    assert run.friction[-1] == pytest.approx(100.0, rel=1e-3)


def test_the_integral_does_not_wind_up_in_saturation() -> None:
    fast = strokes(0.2, 0.04, 4000.0, ramp=0.1)
    free = run_axis(IDEAL, fast)
    limited = run_axis(replace(IDEAL, cascade=replace(IDEAL.cascade, limit=1.5)), fast)
    assert free.saturated == 0
    assert np.abs(free.input).max() > 1.7
    assert limited.saturated > 100
    assert np.abs(limited.input).max() == 1.5
    assert np.abs(limited.position[-1] - fast.position[-1]) < 5e-6
    assert limited.position.max() < fast.position.max() + 0.25e-3


def test_the_observer_finds_the_friction_that_is_left_to_it() -> None:
    slide = strokes(10e-3, 5e-3, 4000.0)
    middle = slice(1500, 2000)
    for gain in (0.0, 0.6):
        axis = replace(IDEAL, nominal_friction=NominalFriction(IDEAL.nominal_friction.models, gain))
        run = run_axis(axis, slide, PAPER_SCHEMES["f"])
        # d̂ is what acts on the plant besides u_t: friction less what was fed forward, as a voltage that brakes
        left = float(axis.friction.steady_state(10e-3)) * (1 - gain) / axis.plant.K_f
        np.testing.assert_allclose(run.disturbance[middle], -left, rtol=1e-3)


@pytest.mark.parametrize(("scheme", "factor"), [("a", 0.98), ("a", 1.02), ("d", 0.98), ("d", 1.02)])
def test_an_unstable_loop_is_told_before_the_run_and_a_stable_one_is_not(scheme: str, factor: float) -> None:
    """The edge of stability by its frequency response: the gain margin of the loop opened at the plant's input."""
    blocks = (IDEAL.observer,) if PAPER_SCHEMES[scheme].observer else ()
    loop = SampledLoop(IDEAL.plant, IDEAL.cascade, blocks)
    edge = margins(loop.input, loop.nyquist).gain_margin
    assert 2.0 < edge < 10.0
    axis = replace(IDEAL, plant=replace(IDEAL.plant, B=IDEAL.plant.B * edge * factor), observer=IDEAL.observer)
    if factor < 1:
        run_axis(axis, REVERSALS, PAPER_SCHEMES[scheme])
    else:
        with pytest.raises(FricError, match=r"not stable: its gain margin is -0\.[0-9] dB"):
            run_axis(axis, REVERSALS, PAPER_SCHEMES[scheme])


def test_schemes_that_the_axis_cannot_run_are_told() -> None:
    with pytest.raises(FricError, match="believes in none"):
        run_axis(replace(IDEAL, nominal_friction=NominalFriction()), REVERSALS, PAPER_SCHEMES["b"])
    with pytest.raises(FricError, match="has none"):
        run_axis(replace(IDEAL, observer=None), REVERSALS, PAPER_SCHEMES["d"])
    with pytest.raises(FricError, match="sampled at 1000 Hz"):
        run_axis(IDEAL, sine(1e-3, 2.0, 1, 1000.0), NONE)


def test_a_run_tells_that_it_lives() -> None:
    """A slow circle under one scheme took 80 s without a word."""
    said: list[str] = []
    with heard(said.append):
        run_axis(MACHINE.axis("x"), REVERSALS)
    assert said == [""]

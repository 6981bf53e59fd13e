"""Flaws of guideway, motor and masses, each against its closed form or an integration that shares no code with fric."""

from dataclasses import replace
from math import exp, inf, log, log1p, pi, sqrt
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from fric.documents.machine_files import read_machine
from fric.drive.sensing import Encoder
from fric.errors import FricError
from fric.friction.lugre import LuGre
from fric.friction.stribeck import StaticMap
from fric.kernels.replay import replay
from fric.reference import Reference, circle, strokes
from fric.simulate.axis import run_axis
from fric.simulate.experiment import Trial, runs_of
from fric.simulate.reality.flaws import Cogging, Direction, Drift, Dwell, Reality, SecondMass, Wave
from fric.simulate.reality.motion import true_axis

BASE = read_machine(Path("configs/reality/base.yaml")).axis("x")
IDEAL = replace(BASE, encoder=Encoder(), force_noise=0.0)
GMS = IDEAL.friction


def force_along(reality, time, position, velocity, began=0.0):
    """Return the friction force along a motion [N]."""
    step, state, parameters, _ = true_axis(replace(IDEAL, reality=reality), float(position[0]), began)
    return replay(step, position, velocity, time, state, parameters)


def steady(reality, speed, seconds=5.0, began=0.0):
    """Return time [s], position [m] and force [N] of a motion at one speed, from relaxed blocks."""
    time = np.arange(0.0, seconds, 1e-3)
    return time, speed * time, force_along(reality, time, speed * time, np.full_like(time, speed), began)


def test_without_flaws_the_wrapped_friction_is_the_model_s_own_to_the_last_digit() -> None:
    time = np.arange(0.0, 2.0, 1e-3)
    position, velocity = 1e-4 * np.sin(2 * pi * time), 2e-4 * pi * np.cos(2 * pi * time)
    none = Reality(cogging=(Cogging(0.0, 1e-3),))
    np.testing.assert_array_equal(force_along(none, time, position, velocity), GMS.replay(time, position, velocity))


def test_cogging_adds_its_force_over_position() -> None:
    cogging = Cogging(6.0, 24e-3, 0.8)
    time, z, force = steady(Reality(cogging=(cogging, Cogging(2.0, 4e-3))), 0.02)
    expected = 6.0 * np.sin(2 * pi * z / 24e-3 + 0.8) + 2.0 * np.sin(2 * pi * z / 4e-3)
    np.testing.assert_allclose(force - GMS.replay(time, z, np.full_like(z, 0.02)), expected, atol=1e-9)


def test_a_wave_varies_the_level_and_not_the_viscous_part() -> None:
    _, z, force = steady(Reality(waves=(Wave(0.06, 40e-3, 0.4),)), 0.01, 8.0)
    static = GMS.static
    level = float(static.level(0.01))
    expected = level * (1 + 0.06 * np.sin(2 * pi * z / 40e-3 + 0.4)) + static.sigma * 0.01
    np.testing.assert_allclose(force[500:], expected[500:], rtol=2e-3)  # blocks follow their level with a lag of s/C


def test_the_negative_direction_has_its_own_level_and_viscosity() -> None:
    direction = Reality(direction=Direction(0.85, 1.3))
    static = GMS.static
    for speed in (0.03, -0.03):
        *_, force = steady(direction, speed)
        level, viscous = (1.0, 1.0) if speed > 0 else (0.85, 1.3)
        expected = level * float(static.level(speed)) + viscous * static.sigma * abs(speed)
        assert force[-1] == pytest.approx(np.sign(speed) * expected, rel=1e-9)


@pytest.mark.parametrize("began", [0.0, 40.0])
def test_friction_drifts_with_the_time_since_the_machine_was_switched_on(began: float) -> None:
    time, _, force = steady(Reality(friction=Drift(-0.15, 60.0)), 0.02, 30.0, began)
    static = GMS.static
    level = float(static.level(0.02)) * (1 - 0.15 * (1 - np.exp(-(time + began) / 60.0)))
    np.testing.assert_allclose(force[500:], (level + static.sigma * 0.02)[500:], rtol=1e-4)


@pytest.mark.parametrize("rest", [0.0, 0.5, 20.0])
def test_break_away_grows_with_the_logarithm_of_the_rest(rest: float) -> None:
    # pushed by 300 µm within 10 ms, a contact that 1 m of sliding renews is as old as the rest when it breaks away
    dwell = Dwell(growth=0.1, time=0.2, distance=1.0)
    dt, speed = 1e-4, 0.03
    still = np.zeros(round(rest / dt))
    pushed = speed * dt * np.arange(1, 101)
    position = np.concatenate([[0.0], still, pushed])
    time = dt * np.arange(len(position))
    velocity = np.where(position > 0, 1e-9, 0.0)  # of the map, s(v) = F_s
    force = force_along(Reality(dwell=dwell), time, position, velocity)
    age = rest + 0.003  # when the last block breaks away; those that slip follow their level with a lag
    assert force[-1] == pytest.approx(GMS.static.F_s * (1 + 0.1 * log1p(age / 0.2)), rel=2e-3)


def test_sliding_renews_the_contact_as_the_ageing_law_says() -> None:
    dwell = Dwell(growth=0.1, time=0.2, distance=10e-6)
    speed = 2e-5  # the age in steady sliding is distance over speed, 0.5 s
    time = np.arange(0.0, 60.0, 1e-2)
    force = force_along(Reality(dwell=dwell), time, speed * time, np.full_like(time, speed))
    static = GMS.static
    F_s = static.F_s * (1 + 0.1 * log(1 + 0.5 / 0.2))
    expected = static.F_c + (F_s - static.F_c) * exp(-speed / static.v_s) + static.sigma * speed
    assert force[-1] == pytest.approx(expected, rel=1e-4)


def test_a_motor_that_fades_takes_more_voltage_for_the_same_motion() -> None:
    axis = replace(IDEAL, reality=Reality(force_constant=Drift(-0.08, 2.0)))
    reference = strokes(0.02, 0.02, 4000)
    trials = [Trial(reference, f"{n}", "motion", 4096) for n in range(3)]
    plain = run_axis(IDEAL, reference)
    at_speed = 4000  # 1 s after the beginning, in the first stroke
    for n, (_, run) in enumerate(runs_of(axis, trials)):
        t = n * len(reference) / 4000 + at_speed / 4000
        given = 1 - 0.08 * (1 - exp(-t / 2.0))
        assert run.input[at_speed] * given == pytest.approx(plain.input[at_speed], rel=1e-3)


def test_a_motor_that_strengthens_beyond_the_gain_margin_is_refused() -> None:
    """As a force constant that rises by 9e15 %, of which no run ended."""
    reference = strokes(0.02, 0.02, 4000)
    run_axis(replace(IDEAL, reality=Reality(force_constant=Drift(0.5, 2.0))), reference)
    with pytest.raises(FricError, match=r"with 2000% more force per volt is not stable"):
        run_axis(replace(IDEAL, reality=Reality(force_constant=Drift(20.0, 2.0))), reference)
    with pytest.raises(FricError, match="amount"):
        Drift(9e13, 60.0)


def test_gains_for_which_the_plant_is_too_slow_are_said_to_be_of_another_unit() -> None:
    """As of logs whose force and voltage have changed places: to lower the gains was the only advice."""
    slow = replace(IDEAL, plant=replace(IDEAL.plant, B=IDEAL.plant.B / 120))
    cascade = replace(IDEAL.cascade, limit=inf, K_i=50 * IDEAL.cascade.K_i)
    with pytest.raises(FricError, match="no gain makes it so") as refused:
        run_axis(replace(slow, cascade=cascade), strokes(0.02, 0.02, 4000))
    assert "is the force logged as the input" in refused.value.hint


def test_gravity_is_a_load_of_which_no_controller_knows() -> None:
    reference = strokes(0.02, 0.02, 4000)
    plain, loaded = (run_axis(axis, reference) for axis in (IDEAL, replace(IDEAL, reality=Reality(gravity=60.0))))
    at_speed = slice(3000, 4000)
    np.testing.assert_allclose((loaded.input - plain.input)[at_speed] * IDEAL.plant.K_f, 60.0, rtol=1e-3)
    assert loaded.input[0] == plain.input[0]


# --- two masses ---------------------------------------------------------------------------------------------------

LUGRE = LuGre(StaticMap(80.0, 115.0, 2e-3, 1.0, 120.0), sigma_0=1e7, sigma_1=3e3)


def two_masses(axis, voltage, t_end):
    """Integrate motor and table with LuGre's bristles by SciPy, from rest, the voltage held over each sample."""
    second, plant, m = axis.second_mass, axis.plant, axis.friction
    s, T = m.static, axis.cascade.T_s
    late = plant.T_d - T / 2
    motor, on_table = plant.M - second.mass, second.friction == "table"

    def rates(t, y):
        z, v, w, u, bristle = y
        slide = u if on_table else v
        level = s.F_c + (s.F_s - s.F_c) * np.exp(-abs(slide / s.v_s))
        grow = slide - m.sigma_0 * abs(slide) / level * bristle
        friction = m.sigma_0 * bristle + m.sigma_1 * grow + s.sigma * slide
        gap = np.clip(z - w, -second.backlash / 2, second.backlash / 2)
        spring = second.stiffness * (z - w - gap) + second.damping * (v - u)
        n = int(np.floor((t - late) / T + 1e-9))
        drive = plant.K_f * (voltage[n] if 0 <= n < len(voltage) else 0.0)
        on = (0.0, friction) if on_table else (friction, 0.0)
        return [v, (drive - plant.M * plant.A * v - spring - on[0]) / motor, u, (spring - on[1]) / second.mass, grow]

    edges = np.arange(0, round(t_end / T) + 1) * T + late
    y, found = np.zeros(5), [np.zeros(5)]
    for n in range(round(t_end / T)):  # from sample to sample, so that no step of the voltage lies inside
        for a, b in ((n * T, edges[n] - late + late % T), (edges[n] - late + late % T, (n + 1) * T)):
            if b > a + 1e-12:
                y = solve_ivp(rates, (a + 1e-12, b - 1e-12), y, rtol=1e-9, atol=1e-14, method="LSODA").y[:, -1]
        found.append(y)
    return np.array(found)


@pytest.mark.parametrize("friction", ["motor", "table"])
def test_two_masses_move_as_scipy_integrates_them(friction: str) -> None:
    second = SecondMass(30.0, 20e6, 2e3, encoder="motor", friction=friction)
    axis = replace(IDEAL, second_mass=second, friction=LUGRE)
    _, run = open_loop(axis, 240)
    expected = two_masses(axis, run.input, 239 / 4000)
    scale = np.ptp(expected[:, 0])
    np.testing.assert_allclose(run.sensed, expected[:240, 0], atol=1e-6 * scale)
    np.testing.assert_allclose(run.position, expected[:240, 2], atol=1e-6 * scale)


def open_loop(axis, samples):
    """Run an axis whose controller does nothing but add a voltage: 1 V, there and back."""
    weak = replace(axis.cascade, K_v=1e-12, K_p=1e-12, K_i=0.0)
    rest = Reference(4000.0, *(np.zeros(samples) for _ in range(3)))
    voltage = np.where(np.arange(samples) < samples // 2, 1.0, -1.0) * 1.0
    return voltage, run_axis(replace(axis, cascade=weak), rest, excitation=voltage)


def lines_of(axis):
    """Return frequencies [Hz] and the response of an axis from voltage to the encoder, by an impulse of voltage."""
    weak = replace(axis.cascade, K_v=1e-12, K_p=1e-12, K_i=0.0)
    n = 40_000
    rest = Reference(4000.0, *(np.zeros(n) for _ in range(3)))
    voltage = np.zeros(n)
    voltage[1] = 5.0
    run = run_axis(replace(axis, cascade=weak), rest, excitation=voltage)
    velocity = np.gradient(run.sensed)
    return np.fft.rfftfreq(n, 1 / 4000), np.abs(np.fft.rfft(velocity - velocity[-1]))


@pytest.mark.parametrize("encoder", ["motor", "table"])
def test_resonance_and_antiresonance_lie_where_masses_and_spring_put_them(encoder: str) -> None:
    second = SecondMass(30.0, 20e6, 60.0, encoder=encoder)
    free = replace(GMS, static=StaticMap(1e-6, 1e-6, 1e-3))
    f, response = lines_of(replace(IDEAL, second_mass=second, friction=free))
    motor = IDEAL.plant.M - 30.0
    resonance = sqrt(20e6 * (1 / 30.0 + 1 / motor)) / (2 * pi)
    band = (f > 50) & (f < 400)
    assert f[band][np.argmax(response[band])] == pytest.approx(resonance, rel=2e-3)
    if encoder == "motor":
        below = (f > 50) & (f < resonance)
        assert f[below][np.argmin(response[below])] == pytest.approx(sqrt(20e6 / 30.0) / (2 * pi), rel=2e-3)


def test_play_lets_the_table_stand_while_the_motor_turns_round() -> None:
    second = SecondMass(30.0, 100e6, 5e3, backlash=6e-6, encoder="motor")
    _, run = next(runs_of(replace(IDEAL, second_mass=second), [Trial(strokes(0.01, 0.01, 4000), "s", "motion", 9000)]))
    gap = run.sensed - run.position
    forward, back = gap[2000:4000], gap[7000:8500]
    pull = GMS.steady_state(0.01) / 100e6
    assert np.mean(forward) == pytest.approx(3e-6 + pull, rel=0.01)
    assert np.mean(back) == pytest.approx(-3e-6 - pull, rel=0.01)


def test_what_no_axis_can_have_is_told() -> None:
    with pytest.raises(FricError, match="no memory"):
        run_axis(
            replace(IDEAL, friction=GMS.static, reality=Reality(cogging=(Cogging(1.0, 1e-3),))),
            strokes(0.01, 0.01, 4000),
        )
    with pytest.raises(FricError, match="all that moves"):
        run_axis(replace(IDEAL, second_mass=SecondMass(100.0, 1e7)), strokes(0.01, 0.01, 4000))
    with pytest.raises(FricError, match="encoder of second_mass is 'gear'"):
        SecondMass(10.0, 1e7, encoder="gear")


def test_a_motion_that_grows_beyond_all_numbers_is_refused() -> None:
    """A damper of 9e14 N·s/m on a spring made the position NaN, which a spline of the trace then refused."""
    axis = replace(BASE, second_mass=SecondMass(20.0, 1e8, 9e14))
    with pytest.raises(FricError, match="beyond all numbers"):
        run_axis(axis, circle(0.005, 0.1, 1, axis.cascade.sampling)[0])

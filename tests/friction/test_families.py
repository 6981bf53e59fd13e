"""Where one model turns into another, the equations solved by SciPy instead, and what each model lacks."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from fric.drive.plant import Plant
from fric.errors import FricError
from fric.friction import models
from fric.friction.dahl import Dahl
from fric.friction.gms import GMS
from fric.friction.leuven import Leuven
from fric.friction.lugre import LuGre
from fric.friction.maxwell_slip import MaxwellSlip
from fric.friction.stribeck import StaticMap
from tests.friction.test_under_load import push

STATIC = StaticMap(F_c=105.0, F_s=165.0, v_s=1e-3, delta=1.0, sigma=40.0)
BLOCKS = ((0.566, 0.227, 0.207), (1e8, 1.4e6, 1e6))
LUGRE = LuGre(STATIC, 5e7, 300.0)
LEUVEN = Leuven(STATIC, *BLOCKS, sigma_1=300.0, n=8.0)


def sine(amplitude, frequency, cycles=1.0, dt=2e-4):
    time = np.arange(0.0, cycles / frequency, dt)
    omega = 2 * np.pi * frequency
    return time, amplitude * (1 - np.cos(omega * time)), amplitude * omega * np.sin(omega * time)


def solved(rhs, state, time):
    result = solve_ivp(rhs, (0.0, time[-1]), state, "LSODA", time, rtol=1e-6, atol=1e-5, max_step=time[-1] / 300)
    return result.y


@pytest.mark.parametrize("amplitude", [2e-6, 50e-6, 2e-3])
def test_lugre_solves_its_differential_equation(amplitude):
    time, z, v = sine(amplitude, 1.0)
    omega = 2 * np.pi

    def rhs(t, F):
        speed = amplitude * omega * np.sin(omega * t)
        return LUGRE.sigma_0 * (speed - abs(speed) / STATIC.level(speed) * F)

    (F,) = solved(rhs, [0.0], time)
    bending = LUGRE.sigma_1 / LUGRE.sigma_0 * np.array([rhs(t, f) for t, f in zip(time, F, strict=True)])
    np.testing.assert_allclose(LUGRE.replay(time, z, v), F + bending + STATIC.sigma * v, atol=0.05)


@pytest.mark.parametrize(("amplitude", "tolerance"), [(2e-6, 0.05), (50e-6, 0.1)])
def test_leuven_solves_its_differential_equation(amplitude, tolerance):
    time, x, v = sine(amplitude, 1.0)
    omega, n = 2 * np.pi, LEUVEN.n
    W, k = np.array(LEUVEN.alpha) * STATIC.F_s, np.array(LEUVEN.k)

    def share(speed, F_h):
        r = F_h / STATIC.level(speed) * np.sign(speed)
        return 1.0 - np.sign(r) * abs(r) ** n

    def rhs(t, F):
        speed = amplitude * omega * np.sin(omega * t)
        rate = speed * share(speed, F.sum())
        sticks = np.where(rate > 0, F < W, F > -W)
        return k * rate * sticks

    F = np.clip(solved(rhs, np.zeros(3), time), -W[:, None], W[:, None])
    expected = F.sum(axis=0) + LEUVEN.sigma_1 * v * share(v, F.sum(axis=0)) + STATIC.sigma * v
    error = LEUVEN.replay(time, x, v) - expected
    assert np.sqrt(np.mean(error**2)) < tolerance


def test_leuven_converges_in_sliding_too():
    fine, coarse = (LEUVEN.replay(*sine(2e-3, 1.0, dt=dt)) for dt in (1e-5, 2e-4))
    assert np.sqrt(np.mean((fine[::20] - coarse) ** 2)) < 0.3


@pytest.mark.parametrize("n", [0.5, 1.0, 1.0 + 1e-6, 2.0])
def test_dahl_solves_its_differential_equation(n):
    model = Dahl(F_c=105.0, sigma_0=5e7, n=n)
    time, z, v = sine(20e-6, 1.0)
    omega = 2 * np.pi

    def rhs(t, F):
        speed = 20e-6 * omega * np.sin(omega * t)
        left = 1.0 - F / model.F_c * np.sign(speed)
        return model.sigma_0 * speed * np.maximum(left, 0.0) ** n

    (expected,) = solved(rhs, [0.0], time)
    np.testing.assert_allclose(model.replay(time, z, v), expected, atol=0.05)


def test_lugre_without_stribeck_effect_and_damping_is_dahl():
    flat = replace(STATIC, F_s=STATIC.F_c)
    time, z, v = sine(40e-6, 0.5, dt=1e-3)
    dahl = Dahl(STATIC.F_c, 5e7, 1.0, STATIC.sigma)
    np.testing.assert_allclose(LuGre(flat, 5e7).replay(time, z, v), dahl.replay(time, z, v), atol=1e-9)


def test_gms_without_stribeck_effect_and_lag_is_maxwell_slip():
    flat = replace(STATIC, F_s=STATIC.F_c)
    alpha, k = BLOCKS
    time, z, v = sine(60e-6, 0.5, dt=1e-3)
    slip = MaxwellSlip(tuple(a * flat.F_c for a in alpha), k, flat.sigma)
    np.testing.assert_allclose(GMS(flat, alpha, k, 1e12).replay(time, z, v), slip.replay(time, z, v), atol=1e-9)


def test_leuven_of_a_sharp_transition_is_maxwell_slip_below_break_away():
    alpha, k = BLOCKS
    time, z, v = sine(10e-6, 0.5, dt=1e-3)
    flat = StaticMap(165.0, 165.0, 1e-3)
    slip = MaxwellSlip(tuple(a * flat.F_c for a in alpha), k)
    np.testing.assert_allclose(Leuven(flat, alpha, k, n=100.0).replay(time, z, v), slip.replay(time, z, v), atol=1e-3)


def minor_loop_gap(model):
    """Return by how much a small excursion on a branch fails to close [N]: path 0 → 4 → 3 → 4 µm."""
    path = np.concatenate(
        [np.linspace(0, 4e-6, 401), np.linspace(4e-6, 3e-6, 101)[1:], np.linspace(3e-6, 4e-6, 101)[1:]]
    )
    time = 3e7 * np.arange(path.size)  # so slow that the level is F_s
    force = model.replay(time, path)
    return abs(force[-1] - force[400])


def test_who_closes_a_minor_loop():
    """LuGre and Dahl do not, GMS and Maxwell slip do, Leuven the better the sharper its transition."""
    alpha, k = BLOCKS
    F_s = STATIC.F_s
    assert minor_loop_gap(LUGRE) > 0.05 * F_s
    assert minor_loop_gap(Dahl(F_s, 5e7)) > 0.05 * F_s
    assert minor_loop_gap(GMS(STATIC, alpha, k)) < 1e-9 * F_s
    assert minor_loop_gap(MaxwellSlip(tuple(a * F_s for a in alpha), k)) < 1e-9 * F_s
    gaps = [minor_loop_gap(replace(LEUVEN, sigma_1=0.0, n=n)) for n in (2.0, 8.0, 32.0)]
    assert gaps[0] > 5 * gaps[1] > 25 * gaps[2]
    assert gaps[2] < 1e-5 * F_s


@pytest.mark.parametrize("dt", [1e-5, 1e-3, 0.1])
def test_a_stiff_lugre_slides_at_full_speed_with_any_step(dt):
    stiff = LuGre(STATIC, 1e8, 1e3)
    time = np.arange(500) * dt
    force = stiff.replay(time, 0.1 * time, np.full(500, 0.1))
    assert np.all(np.abs(force[1:]) <= STATIC.F_s + 0.1 * (STATIC.sigma + stiff.sigma_1))
    assert force[-1] == pytest.approx(float(STATIC.steady_state(0.1)), rel=1e-9)


@pytest.mark.parametrize(
    ("model", "creeps"),
    [
        (LUGRE, True),
        (Dahl(STATIC.F_s, 5e7), True),
        (GMS(STATIC, *BLOCKS), False),
        (MaxwellSlip(tuple(a * STATIC.F_s for a in BLOCKS[0]), BLOCKS[1]), False),
        (replace(LEUVEN, n=30.0), False),
    ],
    ids=lambda value: value.name if hasattr(value, "name") else "",
)
def test_who_creeps_under_a_load_that_vibrates_below_break_away(model, creeps):
    """The models that close no minor loop do: by more than an excursion in each cycle, and without end."""
    dt, per_cycle, cycles = 1e-4, 2000, 60
    load = STATIC.F_s * (0.5 + 0.25 * np.sin(2 * np.pi * np.arange(cycles * per_cycle) / per_cycle))
    load *= np.minimum(np.arange(load.size) / (5 * per_cycle), 1.0)
    means = push(model, load, dt).reshape(cycles, per_cycle).mean(axis=1)
    late = (means[-1] - means[20]) / (cycles - 21)
    if creeps:
        assert late > 0.1e-6
        assert means[40] - means[20] == pytest.approx(20 * late, rel=0.05)
    else:
        assert abs(late) < 1e-9


@pytest.mark.parametrize(
    ("model", "gives"),
    [
        (replace(LUGRE, sigma_1=5e4), True),
        (LUGRE, False),
        (replace(LUGRE, sigma_1=0.0), False),
        (replace(LEUVEN, sigma_1=5e4), True),
        (replace(LEUVEN, sigma_1=0.0), False),
        (GMS(STATIC, *BLOCKS), False),
        (GMS(STATIC, *BLOCKS, C=1e7), False),
    ],
    ids=["lugre, much sigma_1", "lugre", "lugre, none", "leuven, much sigma_1", "leuven, none", "gms", "gms, fast C"],
)
def test_who_gives_energy_back(model, gives):
    """A cycle of 20 um at 10 um/s and 5 um in a run, there and back: the load of the slow part meets a low s(v)."""
    speeds, ways = ((1e-5, 0.3) if model.name == "leuven" else (1e-5, 0.1)), (20e-6, 5e-6)
    v = np.repeat(speeds, 2000)
    dz = np.repeat(ways, 2000) / 2000
    v, dz = np.tile(np.concatenate([v, -v]), 3), np.tile(np.concatenate([dz, -dz]), 3)
    time, position = (np.append(0.0, np.cumsum(steps)) for steps in (dz / v, dz))
    force = model.replay(time, position, np.append(v[0], v))
    work = (force[1:] * dz)[-8000:].sum()
    assert work < -2e-3 if gives else work > 4e-3


@pytest.mark.parametrize("wrong", [float("inf"), float("nan"), -1e300])
def test_no_model_has_a_parameter_that_no_friction_has(wrong: float) -> None:
    """In Python as in a file: each parameter of each model in turn."""
    for model in models().values():
        typical = model.typical()
        for parameter in model.parameters:
            several = (wrong,) * max(1, len(getattr(typical, parameter.name))) if parameter.per_block else wrong
            with pytest.raises(FricError):
                replace(typical, **{parameter.name: several})


@pytest.mark.parametrize("wrong", [np.ones(3) + 0j, "a", None, [[1.0], [1.0, 2.0]], {}])
def test_a_law_takes_real_numbers(wrong: object) -> None:
    model = models()["gms"].typical()
    plant = Plant(16.0, 2.4, 6e-4, 150.0)
    for law in (model.steady_state, getattr(model, "virgin_curve"), plant.response):  # noqa: B009
        with pytest.raises(FricError, match="numbers"):
            law(wrong)

"""The same identities for every friction model: a new model in the package is held to them without a word here.

The first part is what every model must hold, the second what a model claims in its `properties`.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from fric.friction import models
from fric.friction.stribeck import OnStaticMap, StaticMap
from fric.kernels.increments import reversal
from tests.friction.instances import INSTANCES, slowly, static_of, stiffness_of, with_property, with_viscous
from tests.turns import in_turns

every_model = pytest.mark.parametrize("name", INSTANCES)
quick = settings(max_examples=20, deadline=None, derandomize=True, database=None)


def claiming(*claimed):
    return pytest.mark.parametrize("name", with_property(*claimed))


def harmonics(amplitude, period, shape, seed, cycles=1, samples=2000):
    """Return time and position of a random closed cycle, a sum of harmonics, repeated."""
    rng = np.random.default_rng(seed)
    phase = np.arange(cycles * samples + 1) / samples
    position = sum(
        amplitude * rng.normal() / h * np.sin(2 * np.pi * (h * phase + rng.uniform())) for h in shape
    ) * np.ones(phase.size)
    return phase * period, position


cycles = st.fixed_dictionaries(
    {
        "amplitude": st.floats(-7.5, -2.5).map(lambda x: 10**x),
        "period": st.floats(-2.5, 2.0).map(lambda x: 10**x),
        "shape": st.lists(st.integers(1, 9), min_size=1, max_size=4, unique=True),
        "seed": st.integers(0, 2**32 - 1),
    }
)


@pytest.mark.parametrize("model", models().values(), ids=models())
def test_typical_values_are_within_bounds_and_packed_with_named_dimensions(model):
    for parameter in model.parameters:
        assert np.all(np.isfinite(parameter.typical)), parameter.name
        assert np.all(
            (parameter.lower <= np.array(parameter.typical)) & (np.array(parameter.typical) <= parameter.upper)
        )
        assert parameter.doc
    assert model.typical().packed().dtype == model.typical().initial_state().dtype == np.float64


@every_model
@quick
@given(cycle=cycles)
def test_friction_is_odd(name, cycle):
    time, position = harmonics(**cycle)
    model = INSTANCES[name]
    np.testing.assert_array_equal(model.replay(time, -position), -model.replay(time, position))


@every_model
@quick
@given(cycle=cycles)
def test_closed_cycles_dissipate(name, cycle):
    time, position = harmonics(**cycle, cycles=3)
    for force in (INSTANCES[name].replay(time, position), slowly(INSTANCES[name], position)):
        work = (0.5 * (force[1:] + force[:-1]) * np.diff(position))[-2000:].sum()
        assert work >= -1e-9 * static_of(INSTANCES[name]).F_s * np.ptp(position)


@every_model
@pytest.mark.parametrize("speed", [1e-5, 4e-5, 2e-4, 1e-3, 4e-3, 1.6e-2, 0.03, 0.5])
@pytest.mark.parametrize("direction", [1, -1])
def test_steady_sliding_is_the_static_map(name, speed, direction):
    model = INSTANCES[name]
    time = np.linspace(0.0, max(20.0, 2e-3 / speed), 20_001)
    v = np.full(time.size, direction * speed)
    force = model.replay(time, v * time, v)
    assert force[-1] == pytest.approx(float(model.steady_state(direction * speed)), rel=1e-9)
    # and, said apart from the model: the paper's eq. (2), with friction against the motion in both directions
    m = static_of(model)
    eq2 = m.F_c + (m.F_s - m.F_c) * np.exp(-((speed / m.v_s) ** m.delta)) + m.sigma * speed
    assert force[-1] == pytest.approx(direction * eq2, rel=1e-9)


@every_model
@pytest.mark.parametrize("direction", [1, -1])
def test_viscous_friction_opposes_motion_both_ways(name, direction):
    model = INSTANCES[name]
    if "sigma" not in {p.name for p in (*model.parameters, *StaticMap.parameters * isinstance(model, OnStaticMap))}:
        pytest.skip("it has no viscous part")
    model = with_viscous(model, 500.0)
    time = np.linspace(0.0, 2.0, 4001)

    def at(speed):
        v = np.full(time.size, direction * speed)
        return model.replay(time, v * time, v)[-1]

    assert (at(0.9) - at(0.4)) / 0.5 == pytest.approx(direction * 500.0, rel=1e-9)


@every_model
@quick
@given(cycle=cycles, dt=st.floats(-9, 9).map(lambda x: 10**x))
def test_at_rest_nothing_changes(name, cycle, dt):
    model = INSTANCES[name]
    state, parameters = model.initial_state(), model.packed()
    model.replay(*harmonics(**cycle, samples=200), state=state)
    force, held = type(model).step(0.0, 0.0, dt, state, parameters), state.copy()
    for _ in range(20):
        assert type(model).step(0.0, 0.0, dt, state, parameters) == force
    np.testing.assert_array_equal(state, held)


@every_model
@quick
@given(cycle=cycles, cut=st.integers(1, 1999))
def test_a_replay_can_be_continued_from_its_state(name, cycle, cut):
    model = INSTANCES[name]
    time, position = harmonics(**cycle)
    v = np.gradient(position, time)
    whole = model.replay(time, position, v)
    state = model.initial_state()
    first = model.replay(time[:cut], position[:cut], v[:cut], state)
    second = model.replay(time[cut - 1 :], position[cut - 1 :], v[cut - 1 :], state)
    np.testing.assert_allclose(np.concatenate([first, second[1:]]), whole, rtol=0, atol=1e-9)


# What a model claims


def with_waits(amplitude, legs, samples=200, least=1e-3):
    """Return time, position and velocity of a closed cycle: to each target fast or slow, then on a little for a while.

    The speed of a stroke is a cosine about its mean that goes down to a small share of it, never to zero: a contact
    that slips goes on to slip.
    """
    x = np.arange(1, samples + 1) / samples
    time, position, velocity = [np.zeros(1)], [np.zeros(1)], [np.zeros(1)]
    for target, fast, wait in (*legs, (0.0, *legs[-1][1:])):
        on = 1e-3 * np.sign(amplitude * target - position[-1][-1])
        for end, T in ((target - on, fast), (target, wait)):
            start, travel = position[-1][-1], amplitude * end - position[-1][-1]
            time.append(time[-1][-1] + T * x)
            position.append(start + travel * (x - (1 - least) * np.sin(2 * np.pi * x) / (2 * np.pi)))
            velocity.append(travel / T * (1 - (1 - least) * np.cos(2 * np.pi * x)))
    return np.concatenate(time), np.concatenate(position), np.concatenate(velocity)


leg = st.tuples(st.floats(-1, 1), st.floats(-4, 1).map(lambda x: 10**x), st.floats(-2, 1).map(lambda x: 10**x))


@claiming("passive")
@quick
@given(amplitude=st.floats(-7, -3).map(lambda x: 10**x), legs=st.lists(leg, min_size=1, max_size=3))
@example(amplitude=1.5e-6, legs=[(1.0, 3e-4, 0.1)])  # by eq. (4) as printed, GMS gives back 2 % of F_s times the way
def test_no_motion_draws_more_energy_than_went_in(name, amplitude, legs):
    """From a relaxed contact at any time, and over a cycle that closes in position and state, with the end force.

    ``Σ F·dz`` with the force at the end of a step is exact for a model whose load grows no faster than its spring is
    stretched, but for the steps in which the motion reverses: these err by twice F_s times their way at most, which
    vanishes with dt.
    """
    model = INSTANCES[name]
    F_s = static_of(model).F_s
    time, position, v = with_waits(amplitude, legs)
    v[0] = v[-1]
    there = np.array([reversal(*step)[0] for step in zip(v[:-1], v[1:], np.diff(time), strict=True)])
    ways = (np.abs(there) + np.abs(np.diff(position) - there))[there != 0.0]
    bound = 2 * F_s * ways.sum() + 1e-12 * F_s * np.abs(np.diff(position)).sum()
    state, total = model.initial_state(), 0.0
    for _ in range(6):
        before = state.copy()
        work = np.cumsum(model.replay(time, position, v, state)[1:] * np.diff(position))
        assert total + work.min() >= -6 * bound
        total += work[-1]
    if np.allclose(state, before, rtol=1e-9, atol=1e-9):
        assert work[-1] >= -bound


@claiming("bounded")
@quick
@given(
    dt=st.floats(-7, 4).map(lambda x: 10**x),
    speed=st.floats(-7, 1).map(lambda x: 10**x),
    jump=st.floats(-8, 0).map(lambda x: 10**x),
    seed=st.integers(0, 2**32 - 1),
)
def test_force_is_never_above_static_friction_whatever_the_step(name, dt, speed, jump, seed):
    """Increments and velocities that have nothing to do with each other, as a poor log may give them."""
    model, rng = INSTANCES[name], np.random.default_rng(seed)
    time, v = dt * np.arange(300), speed * rng.normal(size=300)
    force = model.replay(time, np.cumsum(jump * rng.normal(size=300)), v) - static_of(model).sigma * v
    assert np.abs(force).max() <= static_of(model).F_s * (1 + 1e-12)


@claiming("bounded")
def test_the_start_of_a_fast_move_is_clamped(name):
    model = INSTANCES[name]
    time = np.arange(200) * 1e-3
    position = 0.03 + 0.5 * time  # far from zero, and already fast
    force = model.replay(time, position, np.full(200, 0.5)) - 0.5 * static_of(model).sigma
    assert np.abs(force).max() <= static_of(model).F_s * (1 + 1e-12)


def steps(corners, step):
    """Return a path through corners given in steps, and the index of each corner in it."""
    parts = [np.arange(a, b, np.sign(b - a)) for a, b in pairwise(corners)]
    path = np.concatenate([*parts, corners[-1:]])
    return path * step, np.cumsum([0, *(p.size for p in parts)])


def break_away_distance(name):
    return static_of(INSTANCES[name]).F_s / stiffness_of(INSTANCES[name])


@claiming("non-local memory")
@pytest.mark.parametrize("scale", [0.02, 0.3, 2.0, 30.0])
def test_minor_loops_nested_three_deep_close_and_leave_no_trace(name, scale):
    model = INSTANCES[name]
    nested = [0, 400, -200, 300, -100, 200, -50, 100, 0, 100, -50, 200, -100, 300, -200, 450]
    #         (             the way in: reversals A B C D E F ) G     the way out: F' E' D' C' B' A'
    path, corner = steps(nested, scale * break_away_distance(name) / 400)
    force = slowly(model, path)[corner]
    F_s = static_of(model).F_s
    for entered, left in ((7, 9), (6, 10), (5, 11), (4, 12), (3, 13), (2, 14)):
        assert force[entered] == pytest.approx(force[left], abs=1e-9 * F_s)
    direct, corner = steps([0, 400, -200, 450], scale * break_away_distance(name) / 400)
    assert force[-1] == pytest.approx(slowly(model, direct)[-1], abs=1e-9 * F_s)


@claiming("non-local memory")
@pytest.mark.parametrize("reversal", [7, 60, 333, 1000])
def test_branches_after_a_reversal_are_the_virgin_curve_twice(name, reversal):
    model = INSTANCES[name]
    for direction in (1, -1):
        path, corner = steps(
            np.array([0, reversal, -reversal, reversal]) * direction, 3 * break_away_distance(name) / 1000
        )
        force = slowly(model, path)
        virgin = force[: reversal + 1]
        for start, sign in ((corner[1], -1), (corner[2], 1)):
            branch = force[start : start + 2 * reversal + 1 : 2]
            np.testing.assert_allclose(
                branch - force[start], 2 * sign * virgin, rtol=0, atol=1e-9 * static_of(model).F_s
            )


@claiming("pre-sliding")
@pytest.mark.parametrize("dt", in_turns([1e-4, 1e-3, 1e-2, 0.1], [1e-3, 1e-2, 0.1]))
def test_peak_force_of_a_slow_pull_does_not_depend_on_the_step(name, dt):
    model, speed = INSTANCES[name], 1e-5
    time = np.arange(0.0, 200.0, dt)[:2_000_000]
    v = np.full(time.size, speed)
    force = model.replay(time, speed * time, v)
    assert force.max() == pytest.approx(float(static_of(model).steady_state(speed)), rel=1e-6)
    np.testing.assert_allclose(np.diff(force), np.abs(np.diff(force)), atol=1e-9 * force.max())


@claiming("frictional lag")
def test_force_is_higher_while_the_speed_rises(name):
    model = INSTANCES[name]
    m = static_of(model)
    time = np.linspace(0.0, 3.0, 30_001)
    mean, swing, omega = 3 * m.v_s, 2 * m.v_s, 2 * np.pi * 2.0
    v = mean + swing * np.sin(omega * time)
    position = mean * time - swing / omega * np.cos(omega * time)
    force = model.replay(time, position, v) - m.sigma * v
    last = time > 2.5
    rising, falling = (np.flatnonzero(last & (s * np.cos(omega * time) > 0.5)) for s in (1, -1))
    rising, falling = (branch[np.argsort(v[branch])] for branch in (rising, falling))
    grid = np.linspace(2.5, 3.5, 11) * m.v_s
    up = np.interp(grid, v[rising], force[rising])
    down = np.interp(grid, v[falling], force[falling])
    assert np.all(up >= down) if m.F_c == m.F_s else np.all(up > down)

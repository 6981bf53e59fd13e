"""What is particular to the GMS model; what holds for every model is in test_properties.py and test_under_load.py."""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fric.errors import FricError
from fric.estimate import Estimate
from fric.friction.gms import GMS
from fric.friction.rolling import Rolling
from fric.friction.stribeck import StaticMap
from fric.kernels.increments import reversal
from tests.friction import gms_oracle
from tests.friction.instances import PAPER, TABLE_1, ten_blocks
from tests.turns import in_turns

# amplitude [m], angular frequency [1/s], phase, duration [s]: Table 1's references, and two that are harder
REFERENCES = {
    "15 um sine": (15e-6, 2 * np.pi * 0.1, 0.3, 3.2),
    "450 um sine": (450e-6, 2 * np.pi * 0.1, 0.3, 4.0),
    "30 mm circle at 100 mm/s": (30e-3, 100 / 30, 0.3, 1.8),
    "30 mm circle at 10 mm/s": (30e-3, 10 / 30, 1.2, 3.0),
}


def motion(name, shift=0.0):
    amplitude, omega, phase, duration = REFERENCES[name]
    phase += shift

    def z(t):
        return amplitude * np.sin(omega * t + phase)

    def v(t):
        return amplitude * omega * np.cos(omega * t + phase)

    turns = (np.pi * (np.arange(20) + 0.5) - phase) / omega
    return z, v, [t for t in turns if 0 < t < duration], duration


def replayed(model, name, dt, every=1, shift=0.0, chunk=1_000_000):
    """Replay a reference from rest in steps of dt, and return every so many-th force."""
    z, v, _, duration = motion(name, shift)
    count, state, kept = round(duration / dt), model.initial_state(), []
    for first in range(0, count, chunk):
        n = np.arange(first, min(first + chunk, count) + 1)
        time = n * dt
        force = model.replay(time, z(time), v(time), state)
        kept.append(force[n % every == 0][0 if first == 0 else 1 :])
    return np.concatenate(kept)


@pytest.mark.parametrize("name", REFERENCES)
def test_a_step_of_100_us_is_converged(name):
    """Against a step 100 times finer, within 0.05 N."""
    error = replayed(TABLE_1, name, 1e-4) - replayed(TABLE_1, name, 1e-6, every=100)
    assert np.abs(error).max() <= 0.05


@pytest.mark.parametrize(  # with 1e6 N/s a slipping block loads as fast as it is stretched, and no faster
    ("name", "C"), in_turns(product(REFERENCES, (1e4, 1e6)), zip(REFERENCES, 2 * (1e4, 1e6), strict=True))
)
def test_the_step_is_of_second_order(name, C):
    """Over several phases, since the place of a turn and of a break-away in its step is a matter of luck."""
    steps, finest = np.array([8, 4, 2, 1]) * 1e-4, 6.25e-6
    square, model = np.zeros(steps.size), replace(TABLE_1, C=C)
    for phase in np.linspace(-0.15, 0.15, 7):
        fine = replayed(model, name, finest, shift=phase)
        for i, dt in enumerate(steps):
            square[i] += np.mean((replayed(model, name, dt, shift=phase) - fine[:: round(dt / finest)]) ** 2)
    order = np.polyfit(np.log(steps), 0.5 * np.log(square), 1)[0]
    assert 1.8 < order < 2.3


MODELS = {
    "Table 1": TABLE_1, "ten": ten_blocks(), "slow C": replace(TABLE_1, C=100.0), "fast C": replace(TABLE_1, C=1e5),
}  # fmt: skip


BOTH = {
    *product(REFERENCES, ["Table 1"]),
    ("15 um sine", "ten"),
    *product(["15 um sine", "450 um sine"], ["slow C", "fast C"]),
}
"""Every motion, and every model, in each session."""


@pytest.mark.parametrize(
    ("name", "model"),
    [
        pytest.param(name, model, id=f"{name}-{word}", marks=[pytest.mark.long(2)] * ((name, word) not in BOTH))
        for name in REFERENCES
        for word, model in MODELS.items()
    ],
)
def test_force_agrees_with_the_equations_solved_apart(name, model):
    z, v, turns, duration = motion(name)
    dt = 2e-5
    time = np.arange(round(duration / dt) + 1) * dt
    force = replayed(model, name, dt)[::50]
    expected = gms_oracle.force(model, z, v, turns, time[::50])
    np.testing.assert_allclose(force, expected, rtol=0, atol=2e-3)


@pytest.mark.parametrize("C", [300.0, 1e3, 1e4, 1e5])
@pytest.mark.parametrize("frequency", [0.5, 4.0])
def test_lag_in_sliding_is_first_order_with_time_constant_s_over_c(C, frequency):
    """For a small change of speed around a mean, ``dF/dt = C·(1 - F/s(v))`` is a low-pass of s with s/C."""
    model = replace(TABLE_1, C=C, static=replace(PAPER, sigma=0.0))
    mean, swing, omega, dt = 1.5e-3, 1e-6, 2 * np.pi * frequency, 5e-5
    settled = np.ceil(20 * 165 / C * frequency) / frequency
    time = np.arange(0.0, settled + 4 / frequency, dt)
    v = mean + swing * np.sin(omega * time)
    force = model.replay(time, mean * time - swing / omega * np.cos(omega * time), v)
    last = time >= settled - 0.5 * dt
    response = 2j * np.mean(force[last] * np.exp(-1j * omega * time[last])) / swing
    s = PAPER.level(mean)
    slope = -(s - PAPER.F_c) / PAPER.v_s
    assert response == pytest.approx(slope / (1 + 1j * omega * s / C), rel=2e-3)


def test_width_of_the_lag_loop_shrinks_with_c():
    mean, swing, omega = 2e-3, 1.5e-3, 2 * np.pi * 2.0
    time = np.arange(0.0, 2.0, 1e-4)
    v = mean + swing * np.sin(omega * time)
    position = mean * time - swing / omega * np.cos(omega * time)
    last = time >= 1.5 - 5e-5

    def width(C):
        force = replace(TABLE_1, C=C).replay(time, position, v)[last]
        return abs(0.5 * np.sum(force * np.roll(v[last], -1) - np.roll(force, -1) * v[last])) / (2 * swing)

    widths = np.array([width(C) for C in (3e3, 1e4, 3e4, 1e5, 1e6)])
    assert np.all(np.diff(widths) < 0)
    assert widths[-2] / widths[-1] == pytest.approx(10, rel=0.05)  # in the end as 1/C


def test_blocks_break_away_one_after_the_other_each_at_its_own_share():
    model = ten_blocks()
    time = 1e6 * np.arange(200_001)
    position = np.linspace(0.0, 1.2 * model.slip_displacements.max(), time.size)
    state = model.initial_state()
    force = model.replay(time, position, state=state)
    np.testing.assert_allclose(force, model.virgin_curve(position), atol=1e-6 * model.static.F_s)
    np.testing.assert_allclose(state[2:12], np.array(model.alpha) * model.static.F_s, rtol=1e-6)
    # eq. (6): the slope of the virgin curve in a segment is the stiffness of the blocks that still stick
    knots = np.sort(model.slip_displacements)
    order = np.argsort(model.slip_displacements)
    for j, middle in enumerate(0.5 * (knots[1:] + knots[:-1])):
        slope = (model.virgin_curve(middle * 1.0001) - model.virgin_curve(middle)) / (middle * 1e-4)
        assert slope == pytest.approx(np.array(model.k)[order[j + 1 :]].sum(), rel=1e-6)


def test_table_1_slips_where_the_notes_say():
    np.testing.assert_allclose(TABLE_1.slip_displacements * 1e6, [0.93, 27.5, 25.9, 54.1], rtol=0.01)


def test_slow_pull_from_rest_follows_the_virgin_curve():
    time = np.linspace(0.0, 1000.0, 4001)
    position = 0.1e-6 * time  # at 0.1 um/s the level is F_s within 0.01 %
    force = TABLE_1.replay(time, position)
    np.testing.assert_allclose(force, TABLE_1.virgin_curve(position), atol=0.02)
    np.testing.assert_array_equal(TABLE_1.virgin_curve(-position), -TABLE_1.virgin_curve(position))


@pytest.mark.parametrize("speed", [0.0, 1e-4])
def test_an_encoder_that_flickers_by_one_count_leaves_no_trace(speed):
    """The blocks remember: the force goes back and forth on a spring, and returns to what it was."""
    count, dt = 0.25e-6, 1e-3
    approach = np.round(np.linspace(0.0, 200e-6, 2001) / count) * count
    hold = np.full(2001, approach[-1])
    flicker = hold - count * (np.arange(2001) % 2)
    end = approach[-1] + np.arange(1, 401) * count

    def force_after(middle):
        position = np.concatenate([approach, middle, end])
        v = np.concatenate([np.full(2001, 1e-4), np.full(2001, speed), np.full(400, 2.5e-4)])
        return TABLE_1.replay(dt * np.arange(position.size), position, v)[-400:]

    still, flickering = force_after(hold), force_after(flicker)
    np.testing.assert_allclose(flickering, still, rtol=0, atol=1e-9 * PAPER.F_s)


def energy(model, state):
    """Return what the springs store [J], ``Σ F_i²/(2·k_i)``."""
    blocks = len(model.k)
    return float(np.sum(state[-2 * blocks : -blocks] ** 2 / (2 * np.array(model.k))))


@pytest.mark.parametrize(
    "model",
    [
        TABLE_1,
        ten_blocks(),
        replace(TABLE_1, C=1e7),
        Rolling(PAPER, TABLE_1.alpha, TABLE_1.k, 1e5, (0.2, 0.1), (1e-3, 7e-6), (0.0, 1.0)),
    ],
    ids=["Table 1", "ten", "fast C", "rolling"],
)
@settings(max_examples=20, deadline=None, derandomize=True, database=None)
@given(
    dt=st.floats(-7, 3).map(lambda x: 10**x),
    speed=st.floats(-7, 0).map(lambda x: 10**x),
    jump=st.floats(-9, -2).map(lambda x: 10**x),
    rough=st.floats(0, 1),
    seed=st.integers(0, 2**32 - 1),
)
def test_no_step_gives_back_more_than_its_springs_lose(model, dt, speed, jump, rough, seed):
    """Exact for every step, whether or not v has to do with dz: ``Σ F_i·dz ≥ ΔE``, with the forces at its end.

    Where the motion reverses inside the step, a way a there and b back, it is short by ``a·b·Σ k_i`` at most: that
    vanishes with dt⁴, and is the quadrature's, not the model's.
    """
    rng = np.random.default_rng(seed)
    ways = jump * np.cumsum(rng.normal(size=200)) * rng.integers(0, 2, 200)  # slow, fast, and without a count
    velocities = np.where(rng.random(200) < rough, speed * rng.normal(size=200), ways / dt)
    state, parameters, v_0 = model.initial_state(), model.packed(), 0.0
    for dz, v in zip(ways, velocities, strict=True):
        before = energy(model, state)
        force = type(model).step(dz, v, dt, state, parameters) - model.static.sigma * v
        there, _ = reversal(v_0, v, dt)
        short = max(0.0, -there * (dz - there)) * sum(model.k)
        rounding = 1e-12 * (abs(force * dz) + before)
        assert force * dz >= energy(model, state) - before - short - rounding
        v_0 = v


@pytest.mark.long(3)
def test_the_limit_on_the_load_in_slip_is_what_makes_a_cycle_dissipate():
    """Eq. (4) as printed loads a spring by time alone: a cycle that is fast there and back, with waits, gives 6 µJ.

    It is as long as block 1 takes to break away at F_c. At the ends it waits six lags at 10 nm/s, where the level is
    F_s. As printed, the springs start back at alpha·F_s, and are pulled to alpha·F_c only.
    """
    fast, wait, creep = 3e-4, 0.1, 1e-8
    length = 1.01 * TABLE_1.alpha[0] * (PAPER.F_c + PAPER.F_s) / TABLE_1.k[0]
    half = fast + wait

    def z(t):
        there, since = t % (2 * half) < half, t % half
        x = np.minimum(since / fast, 1.0)
        travel = length * (x - np.sin(2 * np.pi * x) / (2 * np.pi)) + creep * since
        return np.where(there, travel, length + creep * half - travel)

    def v(t):
        there, x = t % (2 * half) < half, np.minimum(t % half / fast, 1.0)
        return np.where(there, 1, -1) * (length / fast * (1 - np.cos(2 * np.pi * x)) + creep)

    model = replace(TABLE_1, static=replace(PAPER, sigma=0.0))
    stroke = np.concatenate([np.linspace(0.0, fast, 300, endpoint=False), np.linspace(fast, half, 500, endpoint=False)])
    time = np.append((half * np.arange(6)[:, None] + stroke).ravel(), 6 * half)
    turns = [half * n for n in range(1, 6)]
    replayed, solved, printed = (
        model.replay(time, z(time), v(time)),
        gms_oracle.force(model, z, v, turns, time),
        gms_oracle.force(model, z, v, turns, time, as_printed=True),
    )
    last = slice(4 * stroke.size, None)

    def work(force):
        return float((0.5 * (force[1:] + force[:-1]) * np.diff(z(time)))[last].sum())

    assert work(printed) < -5e-6
    assert work(solved) > 30e-6
    assert work(replayed) == pytest.approx(work(solved), rel=1e-3)


@pytest.mark.parametrize(
    ("name", "C", "newton"),
    [
        ("450 um sine", 1e4, 0.03),
        ("30 mm circle at 10 mm/s", 1e4, 0.4),
        ("30 mm circle at 100 mm/s", 1e4, 0.8),
        pytest.param("30 mm circle at 100 mm/s", 1e6, 13.4, marks=pytest.mark.long(2)),
    ],
)
def test_how_far_the_limit_moves_the_force(name, C, newton):
    z, v, turns, duration = motion(name)
    time, model = np.linspace(0.0, duration, 10_001), replace(TABLE_1, C=C)
    printed = gms_oracle.force(model, z, v, turns, time, as_printed=True)
    assert np.abs(model.replay(time, z(time), v(time)) - printed).max() == pytest.approx(newton, rel=0.2)


def test_vibration_of_the_position_does_not_drift_over_a_million_steps():
    time = np.arange(1_000_001) * 1e-3
    position = 0.4e-6 * np.sin(2 * np.pi * 5.0 * time)  # block 1 sticks
    force = TABLE_1.replay(time, position)
    np.testing.assert_allclose(force[-200:], force[201:401], rtol=0, atol=1e-8 * PAPER.F_s)


@pytest.mark.parametrize(
    "fields",
    [
        {"alpha": (0.5, 0.6)},
        {"alpha": (1.5, -0.5)},
        {"alpha": (1.0,)},
        {"alpha": (), "k": ()},
        {"k": (1e6, 0.0)},
        {"C": 0.0},
        {"C": -1.0},
        {"k": (float("nan"), 1e6)},
    ],
)
def test_parameters_without_physics_are_refused(fields):
    with pytest.raises(FricError):
        GMS(**{"static": PAPER, "alpha": (0.5, 0.5), "k": (1e6, 1e5), "C": 1e4} | fields)


def sections(**gms):
    static = {"F_c": (105.0, "N"), "F_s": (165.0, "N"), "v_s": (1e-3, "m/s"), "offset": (3.0, "N")}
    blocks = {"alpha": ((0.566, 0.227, 0.170, 0.039), "1"), "k": (TABLE_1.k, "N/m")} | gms
    return {name: {p: Estimate(*e) for p, e in given.items()} for name, given in (("static", static), ("gms", blocks))}


def test_model_from_the_sections_of_a_friction_file():
    model = GMS.from_sections(sections())
    assert model.static == StaticMap(105.0, 165.0, 1e-3, 1.0, 0.0)
    assert model.alpha == pytest.approx(TABLE_1.alpha)  # printed as a sum of 1.002, normalised
    assert model.k == TABLE_1.k


def test_sections_that_do_not_make_a_model_are_told():
    without_k = sections()
    del without_k["gms"]["k"]
    with pytest.raises(FricError, match="no k in 'gms'"):
        GMS.from_sections(without_k)
    with pytest.raises(FricError, match=r"no F_c, F_s, v_s in 'static'"):
        GMS.from_sections({"gms": sections()["gms"]})
    with pytest.raises(FricError, match=r"sums to 1\.5"):
        GMS.from_sections(sections(alpha=((0.75, 0.25, 0.25, 0.25), "1")))
    with pytest.raises(FricError, match="C of 'gms' is -1"):
        GMS.from_sections(sections(C=(-1.0, "N/s")))

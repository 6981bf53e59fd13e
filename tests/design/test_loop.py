from dataclasses import replace

import control
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fric.control.cascade import Cascade
from fric.control.inverse_model import DifferenceEquation, DisturbanceObserver
from fric.control.q_filter import Q_FILTERS, QFilter
from fric.design.loop import SampledLoop, margins
from fric.drive.plant import LinearPlant, SampledPlant
from tests.design.plants import CASCADE_X, CASCADE_Y, X, Y

AXES = pytest.mark.parametrize(("plant", "cascade"), [(X, CASCADE_X), (Y, CASCADE_Y)], ids=["x", "y"])
T_S = 1 / 4000


def of_control(plant: LinearPlant, cascade: Cascade, observer: DisturbanceObserver | None = None) -> dict:
    """The loop's blocks as python-control has them: its discretisation, its delays, its interconnection."""
    A, B = plant.A, plant.B
    z = control.tf([1, 0], [1], T_S)
    share = plant.transport_delay(cascade.sampling) / T_S % 1
    whole = int(plant.transport_delay(cascade.sampling) / T_S)
    continuous = control.ss([[0, 1], [0, -A]], [[0], [B]], [[1, 0]], [[0]])
    late, early, all_of_it = (control.c2d(continuous, length * T_S, "zoh") for length in (share, 1 - share, 1.0))
    # The input changes once within a sample: first the older of two inputs acts, then the newer.
    both = control.ss(all_of_it.A, np.hstack([early.B, early.A @ late.B]), [[1.0, 0.0]], np.zeros((1, 2)), T_S)
    G = both * control.ss([[0.0]], [[1.0]], [[0.0], [1.0]], [[1.0], [0.0]], T_S)
    for _ in range(whole):
        G = G * control.ss([[0.0]], [[1.0]], [[1.0]], [[0.0]], T_S)
    p = np.exp(-2 * np.pi * cascade.velocity_filter * T_S)
    blocks = {
        "G": G,
        "C": control.ss(cascade.K_p + cascade.K_i * T_S * z / (z - 1)),
        "D": control.ss((1 - p) * (z - 1) / (z - p) / T_S),
    }
    if observer is not None:
        q = observer.q
        denominator = np.real(np.poly(q.poles))
        gain = np.real(np.prod(-q.poles) / np.prod(-q.zeros))
        numerator = gain * np.real(np.atleast_1d(np.poly(q.zeros)))
        continuous = control.tf(numerator, denominator)
        inverse = control.tf(np.polymul(numerator, [1 / B, A / B, 0]), denominator)
        blocks["Q"] = control.c2d(control.ss(continuous), T_S, "zoh")
        blocks["F"] = control.c2d(control.ss(inverse), T_S, "tustin")
    return blocks


@AXES
def test_open_loops_and_margins_agree_with_python_control(plant: LinearPlant, cascade: Cascade) -> None:
    loop, blocks = SampledLoop(plant, cascade), of_control(plant, cascade)
    f = np.geomspace(0.1, 1999, 200)
    velocity = blocks["C"] * blocks["G"] * blocks["D"]
    position = cascade.K_v * control.feedback(blocks["C"] * blocks["G"], blocks["D"])
    whole = blocks["C"] * (blocks["D"] + control.ss([], [], [], cascade.K_v, T_S)) * blocks["G"]
    for ours, theirs in ((loop.velocity, velocity), (loop.position, position), (loop.input, whole)):
        np.testing.assert_allclose(ours(f), theirs(np.exp(2j * np.pi * f * T_S)), rtol=1e-6)
        found = margins(ours, loop.nyquist)
        # Its polynomial method loses digits with poles this close to z = 1, so it is given the response on a fine grid.
        omega = 2 * np.pi * np.geomspace(1.0, 1990.0, 2000)
        L = theirs(np.exp(1j * omega * T_S))
        table = np.abs(L), np.degrees(np.unwrap(np.angle(L))), omega
        gains, phases, _, phase_crossovers, crossovers, _ = control.stability_margins(table, returnall=True)
        above = gains > 1
        nearest = np.argmin(gains[above])
        assert found.gain_margin == pytest.approx(gains[above][nearest], rel=1e-6)
        assert found.phase_crossover == pytest.approx(phase_crossovers[above][nearest] / (2 * np.pi), rel=1e-6)
        nearest = np.argmin(np.abs(phases))
        assert np.degrees(found.phase_margin) == pytest.approx(phases[nearest], rel=1e-6)
        assert found.crossover == pytest.approx(crossovers[nearest] / (2 * np.pi), rel=1e-6)


@AXES
@pytest.mark.parametrize("name", Q_FILTERS)
def test_the_loop_with_observer_agrees_with_python_control(plant: LinearPlant, cascade: Cascade, name: str) -> None:
    observer = DisturbanceObserver(QFilter(name, 40.0), plant.A, plant.B)
    loop, blocks = SampledLoop(plant, cascade, (observer,)), of_control(plant, cascade, observer)
    f = np.geomspace(1, 1999, 200)
    at = np.exp(2j * np.pi * f * T_S)
    value = {block: system(at) for block, system in blocks.items()}
    feedback = value["C"] * (value["D"] + cascade.K_v) + value["F"]
    np.testing.assert_allclose(loop.input(f), value["G"] * feedback / (1 - value["Q"]), rtol=1e-6)
    # The closed loop's poles, by python-control's own interconnection.
    one = control.ss([], [], [], 1.0, T_S)
    back = blocks["C"] * (blocks["D"] + control.ss([], [], [], cascade.K_v, T_S)) + blocks["F"]
    poles = control.poles(control.feedback(control.feedback(one, blocks["Q"], 1) * blocks["G"], back))
    ours = loop.poles()
    # the position one sample ago, and what is to join the integral, are states of ours; each adds a pole at 0
    assert len(ours) == len(poles) + 2
    # F and Q have equal poles, one in each, that the loop cannot move, and the delay has some at 0: eigenvalues of
    # multiplicity n are found to the n-th root of the rounding, all others to 1e-6.
    stuck = np.append(np.exp(observer.q.poles * T_S), 0.0)
    for pole in poles:
        tolerance = 1e-2 if np.min(np.abs(stuck - pole)) < 1e-2 else 1e-6
        assert np.min(np.abs(ours - pole)) < tolerance
    assert np.abs(poles).max() < 1.0


@settings(max_examples=30, deadline=None)
@given(
    st.floats(1.0, 200.0), st.floats(0.5, 20.0), st.floats(0.125e-3, 2e-3), st.floats(1.0, 250.0), st.floats(0.02, 1.0)
)
def test_eigenvalues_and_nyquist_tell_the_same_stability(A: float, B: float, T_d: float, f_c: float, r: float) -> None:
    """Two derivations: the state matrix, and the encirclements of −1 by the open loop at the plant's input."""
    rate = 2 * np.pi * f_c
    cascade = Cascade(rate * r, rate / B, rate**2 / B / 10, 500.0, 4000.0)
    loop = SampledLoop(LinearPlant(A, B, T_d), cascade)
    # L has its poles inside the unit circle but for two at z = 1 (position and integral), which the contour passes
    # outside: on that arc the phase of L falls from 0 to −180°, and from there f runs along half the circle.
    f = np.geomspace(1e-3, 2000, 2000)
    phase = np.unwrap(np.angle(1 + loop.input(f)))
    turns = (phase[-1] + 2 * np.pi * round((-np.pi - phase[0]) / (2 * np.pi))) / np.pi
    if abs(np.abs(loop.poles()[0]) - 1) > 1e-4:
        assert loop.stable == (round(turns) == 0)


def test_the_sampled_plant_is_the_continuous_one_at_low_frequency() -> None:
    """Behind the hold, half a sample, and the transport delay, the rest of T_d: together eq. (1) as it is measured."""
    f = np.array([0.01, 0.1, 1.0, 10.0, 60.0])
    ratio = SampledPlant.of(X, 4000.0).response(f, 4000.0) / X.response(f)
    np.testing.assert_allclose(ratio, 1.0, atol=5e-4)


def test_velocity_loop_alone_is_judged_without_the_position() -> None:
    loop = SampledLoop(X, CASCADE_X)
    assert loop.velocity_stable
    edge = margins(loop.velocity, loop.nyquist).gain_margin
    for factor, stable in ((0.999, True), (1.001, False)):
        gain = factor * edge
        scaled = replace(CASCADE_X, K_p=CASCADE_X.K_p * gain, K_i=CASCADE_X.K_i * gain)
        assert SampledLoop(X, scaled).velocity_stable is stable


@AXES
@pytest.mark.parametrize("with_observer", [False, True])
def test_margins_are_where_stability_ends(plant: LinearPlant, cascade: Cascade, with_observer: bool) -> None:
    """The gain of the plant times the gain margin, up and down, is the edge that the eigenvalues see."""
    blocks = (DisturbanceObserver(QFilter(), plant.A, plant.B),) if with_observer else ()
    loop = SampledLoop(plant, cascade, blocks)
    found = margins(loop.input, loop.nyquist)
    for factor in (found.gain_margin, found.gain_reduction):
        inside, outside = (replace(plant, B=plant.B * factor**share) for share in (0.999, 1.001))
        assert SampledLoop(inside, cascade, blocks).stable
        assert not SampledLoop(outside, cascade, blocks).stable


def test_a_delay_as_long_as_the_phase_margin_is_the_edge() -> None:
    """PM = 2π f T of more transport delay, which the state matrix takes in whole and part samples."""
    loop = SampledLoop(X, CASCADE_X, (DisturbanceObserver(QFilter(), X.A, X.B),))
    found = margins(loop.input, loop.nyquist)
    extra = found.phase_margin / (2 * np.pi * found.crossover)
    for factor, stable in ((0.95, True), (1.05, False)):  # behind a sampler a share of a sample is no pure delay
        slower = replace(X, T_d=X.T_d + factor * extra)
        assert SampledLoop(slower, CASCADE_X, loop.blocks).stable is stable


def test_state_matrix_is_the_loop_run_sample_by_sample() -> None:
    observer = DisturbanceObserver(QFilter("binomial3", 50.0), X.A, X.B)
    loop = SampledLoop(X, CASCADE_X, (observer,))
    both = observer.discrete(4000.0)
    sampled = loop.sampled
    p, c = np.exp(-2 * np.pi * 500 * T_S), CASCADE_X
    x = np.zeros(loop.state_matrix().shape[0])
    x[0] = x[2 + sampled.whole + 1] = 1e-3  # off by 1 mm, at rest
    state, past_u, z_old, v_f, integral = np.array([1e-3, 0.0]), [0.0] * (sampled.whole + 1), 1e-3, 0.0, 0.0
    zs, us = [], []

    def filtered(equation: DifferenceEquation, history: list[float]) -> float:
        out: list[float] = []
        for n in range(len(history)):
            y = sum(equation.b[i] * history[n - i] for i in range(len(equation.b)) if n >= i)
            out.append(y - sum(equation.a[i] * out[n - i] for i in range(1, len(equation.a)) if n >= i))
        return out[-1]

    for _ in range(40):
        z = state[0]
        zs.append(z)
        v_f = p * v_f + (1 - p) * (z - z_old) / T_S
        z_old = z
        error = -c.K_v * z - v_f
        integral += T_S * error
        u = c.K_p * error + c.K_i * integral - (filtered(both.inverse, zs) - filtered(both.low_pass, [*us, 0.0]))
        us.append(u)
        past_u.append(u)
        state = (
            sampled.Phi @ state + sampled.late * past_u[-2 - sampled.whole] + sampled.early * past_u[-1 - sampled.whole]
        )
        x = loop.state_matrix() @ x
        np.testing.assert_allclose(x[:2], state, rtol=1e-7, atol=1e-12)

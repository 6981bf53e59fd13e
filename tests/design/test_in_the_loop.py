"""The loop as designed against the loop as it runs: `fric.design.loop` and `fric.kernels.loop` are two derivations."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import freqz

from fric.control.base import Setting
from fric.control.cascade import Cascade
from fric.control.inverse_model import DisturbanceObserver
from fric.control.q_filter import Q_FILTERS, QFilter
from fric.design.loop import SampledLoop
from fric.drive.sensing import low_pass_pole
from fric.kernels.block import Commands
from fric.kernels.loop import Board, Traces, closed_loop
from fric.kernels.plant import PlantConstants
from fric.kernels.signatures import compiled_step
from tests.design.plants import CASCADE_X, X

T_S = 1 / 4000


@compiled_step
def no_friction(dz: float, v: float, dt: float, state: np.ndarray, parameters: np.ndarray) -> float:
    return 0.0


def run(
    position: np.ndarray,
    excitation: np.ndarray | None = None,
    observer: DisturbanceObserver | None = None,
    cascade: Cascade = CASCADE_X,
    load: float = 0.0,
    friction: np.ndarray | None = None,
) -> tuple[Traces, int]:
    """Run the x axis without friction. A load [N] acts on its mass of 121 kg."""
    blocks = [block.ready(Setting(X, cascade)) for block in (cascade, observer) if block is not None]
    zero = np.zeros(position.size)
    return closed_loop(
        no_friction,
        np.zeros(1),
        np.zeros(1),
        PlantConstants(X.A, X.B, 121.0, load, X.transport_delay(cascade.sampling), 0.0),
        Board(cascade.T_s, cascade.limit, 0.0),
        blocks,
        Commands(
            position, zero, zero, zero if excitation is None else excitation, zero if friction is None else friction,
            position, zero,
        ),
    )  # fmt: skip


@pytest.mark.parametrize("name", [None, *Q_FILTERS])
def test_the_running_loop_has_the_sensitivity_of_the_design(name: str | None) -> None:
    """A multisine w added to the voltage gives u·(1 − Q)/w = 1/(1 + L), and z/u = G, at every line."""
    observer = None if name is None else DisturbanceObserver(QFilter(name, 40.0), X.A, X.B)
    loop = SampledLoop(X, CASCADE_X, () if observer is None else (observer,))
    n, lines = 4000, np.unique(np.geomspace(1, 1900, 60).astype(int))  # a period of 1 s: the lines are in Hz
    phases = np.random.default_rng(3).uniform(0, 2 * np.pi, lines.size)
    w = np.cos(2 * np.pi * np.outer(np.arange(n) / n, lines) + phases).sum(axis=1) * 0.01
    traces, saturated = run(np.zeros(4 * n), np.tile(w, 4), observer)
    assert saturated == 0
    W, U, Z = (np.fft.rfft(x[-n:])[lines] for x in (np.tile(w, 4), traces.input, traces.position))
    f = lines.astype(float)
    Q = 0.0
    if observer is not None:
        low_pass = observer.discrete(4000.0).low_pass
        _, Q = freqz(low_pass.b, low_pass.a, f, fs=4000.0)
    np.testing.assert_allclose(Z / U, loop.G(f), rtol=2e-3)  # the kernel's plant is stepped, of second order
    np.testing.assert_allclose(U / W * (1 - Q), 1 / (1 + loop.input(f)), rtol=2e-3)


def test_a_step_of_load_is_taken_over_by_the_observer() -> None:
    """d̂ settles at the load in volts, −F·B/(M·B), sooner than the integral does, and the integral is left at 0."""
    observer = DisturbanceObserver(QFilter("binomial2", 60.0), X.A, X.B)
    n, load = 4000, 100.0
    with_observer, _ = run(np.zeros(n), observer=observer, load=load)
    without, _ = run(np.zeros(n), load=load)
    volts = load / 121.0 / X.B
    assert with_observer.disturbance[-1] == pytest.approx(-volts, rel=1e-6)
    assert with_observer.input[-1] == pytest.approx(volts, rel=1e-6)
    assert np.abs(with_observer.position).max() < 0.6 * np.abs(without.position).max()


def test_the_observer_does_not_see_the_friction_feedforward() -> None:
    """A feedforward that the drive does not need disturbs it; d̂ finds it as a disturbance, in its own size and sign."""
    observer = DisturbanceObserver(QFilter("binomial2", 60.0), X.A, X.B)
    fed = np.full(4000, 0.2)
    traces, _ = run(np.zeros(4000), observer=observer, friction=fed)
    assert traces.disturbance[-1] == pytest.approx(0.2, rel=1e-6)


@pytest.mark.parametrize("name", Q_FILTERS)
def test_the_observer_does_not_wind_up_while_the_drive_saturates(name: str) -> None:
    """It is fed the limited voltage: d̂ stays at what the delay makes of the motion, however much is asked in vain.

    Fed the voltage as wanted, it would take all that the drive cannot give, 10 V and more, for a disturbance.
    """
    observer = DisturbanceObserver(QFilter(name, 40.0), X.A, X.B)
    limited = replace(CASCADE_X, limit=1.0)
    target = np.full(8000, 20e-3)
    target[0] = 0.0  # the run begins at the first reference
    traces, saturated = run(target, observer=observer, cascade=limited)
    assert saturated > 400
    assert np.abs(traces.input).max() == 1.0
    wanted = CASCADE_X.K_p * CASCADE_X.K_v * 20e-3
    assert wanted > 100 * limited.limit
    assert np.abs(traces.disturbance).max() < limited.limit
    assert traces.position[-1] == pytest.approx(20e-3, abs=1e-8)
    assert abs(traces.disturbance[-1]) < 1e-6


def test_the_integral_does_not_wind_up_while_the_drive_saturates() -> None:
    """It waits while the voltage is limited, unless it leads out of the limit. An integral that does not wait, run here
    beside, goes on rising, and has to be worked off by an overshoot."""
    limited = replace(CASCADE_X, limit=1.0)
    target = np.full(8000, 20e-3)
    target[0] = 0.0
    traces, saturated = run(target, cascade=limited)
    assert saturated > 400
    naive = _without_anti_windup(target, limited)
    overshoot, naive_overshoot = (max(float(z.max()) - 20e-3, 0.0) for z in (traces.position, naive))
    assert naive_overshoot > 2e-3
    assert overshoot < 0.5 * naive_overshoot


def _without_anti_windup(target: np.ndarray, cascade: Cascade) -> np.ndarray:
    sampled = SampledLoop(X, cascade).sampled
    p = low_pass_pole(cascade.velocity_filter, cascade.sampling)
    state, seen, v, integral = np.zeros(2), 0.0, 0.0, 0.0
    inputs, position = [0.0] * (sampled.whole + 1), np.zeros(target.size)
    for n, r in enumerate(target):
        position[n] = z = state[0]
        v, seen = p * v + (1 - p) * (z - seen) / T_S, z
        error = cascade.K_v * (r - z) - v
        integral += cascade.K_i * T_S * error
        inputs.append(float(np.clip(cascade.K_p * error + integral, -cascade.limit, cascade.limit)))
        late, early = inputs[-2 - sampled.whole], inputs[-1 - sampled.whole]
        state = sampled.Phi @ state + sampled.late * late + sampled.early * early
    return position

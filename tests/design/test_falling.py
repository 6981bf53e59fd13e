"""Whether a loop holds falling friction: by Nyquist in the library, by eigenvalues of a loop written apart here."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import expm

import fric
from fric.design.cascade import MARGIN, falling_margin, hold_falling
from fric.design.observer import PEAK_SENSITIVITY, WholeLoop, model_perturbation
from fric.simulate.spread import draw_machine

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def steep():
    """An axis whose friction has a short lag and falls steeply."""
    axis = draw_machine(fric.read_machine(ROOT / "configs/xy-table.yaml"), 13)[0].axes["y"]
    return replace(axis, observer=replace(axis.observer, A=axis.plant.A, B=axis.plant.B))


def growth(axis, slope: float, lag: float) -> float:
    """The largest eigenvalue of an axis whose friction falls by slope [N·s/m] behind a lag [s], at one speed."""
    plant, own, T = axis.plant, axis.cascade, axis.cascade.T_s
    both = axis.observer.discrete(own.sampling)
    A = np.zeros((4, 4))  # position, velocity, friction in volts, and the voltage that is held
    A[0, 1], A[1, 1], A[1, 2], A[1, 3] = 1, -plant.A, -plant.B, plant.B
    A[2, 1], A[2, 2] = -slope / plant.K_f / lag, -1 / lag
    whole, share = divmod(plant.T_d - T / 2, T)
    whole = int(whole)
    early, late = expm(A * share), expm(A * (T - share))
    n = 3 + whole + 1
    seen, slow, integral, watch = n, n + 1, n + 2, n + 3
    e = np.eye(n + 7)
    step = np.zeros_like(e)
    pole = np.exp(-2 * np.pi * own.velocity_filter * T)
    step[seen], step[slow] = e[0], pole * e[slow] + (1 - pole) * (e[0] - e[seen]) / T
    error = -own.K_v * e[0] - step[slow]
    step[integral] = e[integral] + own.K_i * T * error
    u = own.K_p * error + step[integral]
    b, a = both.inverse.b, both.inverse.a
    inverse = b[0] * e[0] + e[watch]
    step[watch], step[watch + 1] = b[1] * e[0] - a[1] * inverse + e[watch + 1], b[2] * e[0] - a[2] * inverse
    u = u - inverse + e[watch + 2]
    b, a = both.low_pass.b, both.low_pass.a
    step[watch + 2], step[watch + 3] = b[1] * u - a[1] * e[watch + 2] + e[watch + 3], b[2] * u - a[2] * e[watch + 2]
    sent = [u, *(e[3 + k] for k in range(whole + 1))]  # now, one sample ago, …
    state = early[:3, :3] @ e[:3] + np.outer(early[:3, 3], sent[whole + 1])
    step[:3] = late[:3, :3] @ state + np.outer(late[:3, 3], sent[whole])
    for k in range(whole + 1):
        step[3 + k] = sent[k]
    return float(np.abs(np.linalg.eigvals(step)).max())


def grows(axis, times: float) -> bool:
    """Whether errors grow at any speed where friction falls so many times as steeply."""
    static, C = axis.friction.static, axis.friction.C
    largest = 0.0
    for v in static.v_s * np.geomspace(0.05, 4, 12):
        share = np.exp(-((v / static.v_s) ** static.delta))
        fall = (static.F_s - static.F_c) * share * static.delta / v * (v / static.v_s) ** static.delta
        level = static.F_c + (static.F_s - static.F_c) * share
        largest = max(largest, growth(axis, times * fall, level / C))
    return largest > 1.0 + 1e-9


def test_errors_grow_beyond_the_margin_and_not_below_it(steep):
    for axis in (steep, replace(steep, plant=replace(steep.plant, T_d=0.9 * steep.plant.T_d))):
        margin = falling_margin(axis.plant, axis.cascade, axis.friction, (axis.observer,))
        assert 0.4 < margin < 0.9
        assert grows(axis, 1.03 * margin)
        assert not grows(axis, 0.97 * margin)


def test_gains_that_hold_it_keep_the_peak_sensitivity(steep):
    cascade, observer = hold_falling(steep.plant, steep.cascade, steep.friction, steep.observer)
    held = replace(steep, cascade=cascade, observer=observer)
    margin = falling_margin(steep.plant, cascade, steep.friction, (observer,))
    assert margin > 1.1
    assert not grows(held, 0.97 * margin)
    loop = WholeLoop(steep.plant, cascade, model_perturbation(steep.plant, 2000.0))
    assert loop.peak((observer,)) <= PEAK_SENSITIVITY


def test_a_loop_that_holds_it_stays(steep):
    flat = replace(steep.friction, static=replace(steep.friction.static, F_s=1.05 * steep.friction.static.F_c))
    assert falling_margin(steep.plant, steep.cascade, flat, (steep.observer,)) > MARGIN
    assert hold_falling(steep.plant, steep.cascade, flat, steep.observer) == (steep.cascade, steep.observer)

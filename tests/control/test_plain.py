"""Each block once more, plain and written apart: fed with what the axis saw in a run, it gives the same volts.

The loop itself is held against one written apart in tests/simulate/test_axis.py. Where the volts of a block agree in
every sample to 1e-6 V, so does the position, to far below 0.02 µm: the cascade holds the axis with 83.7·126 V/m, and
1e-6 V move it by 1e-10 m.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import replace
from functools import cache

import control
import numpy as np
import pytest
from scipy.linalg import expm
from scipy.signal import cont2discrete

from fric.control import block_type
from fric.control.scheme import Scheme
from fric.design.blocks import design_block
from fric.design.loop import SampledLoop, learned_share
from fric.errors import FricError
from fric.simulate.axis import Trace, blocks_of, run_axis, setting_of
from tests.control.blocks import AXIS, MOTION
from tests.simulate.plain_loop import Filter

T = 1 / 4000.0
P, C = AXIS.plant, AXIS.cascade
DELAY = P.T_d - T / 2


@cache
def run_of(name: str) -> tuple[Trace, dict[str, float], np.ndarray]:
    """Return a run with a block, the block's parameters, and the volts that it gave."""
    kind = block_type(name)
    beside = ("inverse-model",) if name == "adaptive" else ()
    friction = None if name in {"adaptive", "reversal-pulse"} else "gms"
    if kind.kind == "controller":
        scheme = Scheme("s", "", friction=friction, controller=name)
    else:
        scheme = Scheme("s", "", friction=friction, blocks=(name, *beside))
    trace = run_axis(AXIS, MOTION, scheme)
    blocks = blocks_of(AXIS, scheme, setting_of(AXIS, scheme, MOTION))
    block = blocks[0 if kind.kind == "controller" else 1]
    values = {one.name: getattr(block, one.name) for one in kind.parameters}
    volts = {"observer": trace.disturbance, "feedforward": trace.feedforward}.get(kind.kind)
    return trace, values, trace.input - inverse() - trace.feedforward if volts is None else volts


def inverse() -> np.ndarray:
    return (MOTION.acceleration + P.A * MOTION.velocity) / P.B


def nominal_friction(trace: Trace, share: float = 1.0) -> np.ndarray:
    """Return the force of the GMS model along the reference, its blocks' stiffness multiplied."""
    model = AXIS.nominal_friction.models["gms"]
    other = type(model)(static=model.static, alpha=model.alpha, k=tuple(share * k for k in model.k), C=model.C)
    return AXIS.nominal_friction.gain / P.K_f * other.replay(trace.time, trace.reference, MOTION.velocity)


def delayed(u: np.ndarray) -> np.ndarray:
    """Return the voltage as it acts, linear between samples: value n is that of sample n - 1, the delay ago."""
    n = np.arange(len(u))
    return np.interp(n - 1 - DELAY / T, [-1, *n], [0.0, *u], left=0.0)


def kalman(trace: Trace, values: dict[str, float]) -> np.ndarray:
    """The filter by matrices; the gains by running the Riccati recursion until it stands."""
    F = np.array([[0, 1, 0], [0, -P.A, P.B], [0, 0, 0]])
    Phi = expm(F * T)
    push = np.array([0, P.B])
    share = DELAY - int(DELAY / T) * T

    def held(t: float) -> tuple[np.ndarray, np.ndarray]:
        M = np.zeros((3, 3))
        M[:2, :2], M[:2, 2] = F[:2, :2], push
        E = expm(M * t)
        return E[:2, :2], E[:2, 2]

    rest, early = held(T - share)
    late = rest @ held(share)[1]
    r = 1e-14
    q = r * ((2 * math.pi * values["cutoff"]) ** 3 / P.B * T) ** 2
    S = np.diag([1e-12, 1e-6, 1e-2])
    for _ in range(20000):
        K = S[:, 0] / (S[0, 0] + r)
        S = Phi @ (S - np.outer(K, S[0])) @ Phi.T + np.diag([0, 0, q])
    u, whole = trace.input - trace.feedforward, int(DELAY / T)
    x, out = np.array([trace.measured[0], 0.0, 0.0]), []
    for n, z in enumerate(trace.measured):
        if n:
            x = Phi @ x
            at = n - 1 - whole
            x[:2] += early * (u[at] if at >= 0 else 0.0) + late * (u[at - 1] if at >= 1 else 0.0)
        x = x + K * (z - x[0])
        out.append(x[2])
    return np.array(out)


def two_dof(trace: Trace, values: dict[str, float]) -> np.ndarray:
    tau = 1 / (2 * math.pi * values["cutoff"])
    lag = [tau**3, 3 * tau**2, 3 * tau, 1.0]
    inverse_model = Filter([3 * tau / P.B, (1 + 3 * tau * P.A) / P.B, P.A / P.B, 0.0], lag, T, "tustin")
    low_pass = Filter([3 * tau, 1.0], lag, T, "zoh")
    late, out = delayed(trace.input - trace.feedforward), []
    for z, u in zip(trace.measured - trace.measured[0], late, strict=True):
        low_pass.push(u)
        out.append(inverse_model.output(z) - low_pass.output())
        inverse_model.push(z)
    return np.array(out)


def filtered_velocity(trace: Trace) -> np.ndarray:
    pole, v, out = math.exp(-2 * math.pi * C.velocity_filter * T), 0.0, []
    for change in np.diff(trace.measured, prepend=trace.measured[0]) / T:
        v = pole * v + (1 - pole) * change
        out.append(v)
    return np.array(out)


def sliding_mode(trace: Trace, values: dict[str, float]) -> np.ndarray:
    e, rate = trace.reference - trace.measured, MOTION.velocity - filtered_velocity(trace)
    slope, reach = values["slope"], values["reach"]
    s = rate + 2 * slope * e + slope**2 * np.cumsum(e) * T
    assert np.abs(s).max() < reach / values["gain"]
    return (2 * slope * rate + slope**2 * e) / P.B + values["gain"] * s


def gain_scheduled(trace: Trace, values: dict[str, float]) -> np.ndarray:
    """What it is handed over stroke by stroke; the rest by sums."""
    error = C.K_v * (trace.reference - trace.measured) + MOTION.velocity - filtered_velocity(trace)
    model = AXIS.nominal_friction.models["gms"]
    knots = [2 * a * model.static.F_s / k for a, k in zip(model.alpha, model.k, strict=True)]
    pole, level, integral, out = math.exp(-2 * math.pi * C.velocity_filter * T), 1.0, 0.0, []
    turns = np.flatnonzero(MOTION.velocity[1:] * MOTION.velocity[:-1] < 0) + 1
    turns = [0, *turns, len(error)]
    ended: list[float] = []  # the integral at the reversals
    for first, last in itertools.pairwise(turns):
        way = np.abs(trace.reference[first:last] - trace.reference[first])
        if first:
            ended.append(integral)
        change = values["carried"] * (ended[-2] - ended[-1]) if len(ended) > 1 else 0.0
        begun, own = integral, 0.0
        for n, x in zip(range(first, last), way, strict=True):
            stiffness = sum(k for knot, k in zip(knots, model.k, strict=True) if x / 4 < knot)
            level = pole * level + (1 - pole) * min(1.0, math.sqrt(stiffness / P.M) / (0.4 * P.B * C.K_p))
            turned = sum(a * min(1.0, x / knot) for a, knot in zip(model.alpha, knots, strict=True)) / sum(model.alpha)
            own += C.K_i * T * (1 + values["integral"] * level) * error[n]
            integral = begun + own + change * turned
            out.append(C.K_p * (1 + values["proportional"] * level) * error[n] + integral)
    return np.array(out)


def repetitive(trace: Trace, values: dict[str, float]) -> np.ndarray:
    """The Gaussian by its formula at each instant, its derivatives by differences of it, everything by sums."""
    width = math.sqrt(math.log(2)) / (2 * math.pi * values["cutoff"])
    around = np.arange(-24, 25)
    norm = {}

    def h(t: np.ndarray, about: float) -> np.ndarray:
        if about not in norm:
            norm[about] = np.exp(-(((around - about) * T) ** 2) / (2 * width**2)).sum()
        return np.exp(-(t**2) / (2 * width**2)) / norm[about]

    period = MOTION.period / T
    frac, late = period - int(period), P.T_d / T
    learned = trace.input - trace.feedforward - inverse()
    e = trace.reference - trace.measured
    out, step = np.zeros(len(e)), 1e-6
    for n in range(len(e)):
        first = n - int(period) - 24
        if first < math.ceil(MOTION.begins / T):
            continue
        offset = (around + frac) * T
        out[n] = learned[first : first + 49] @ h(offset, -frac)
        about = late - int(late) - frac
        offset = (around - about) * T
        middle, later, sooner = (h(offset - shift, about) for shift in (0.0, step, -step))
        rate, curve = (later - sooner) / (2 * step), (later - 2 * middle + sooner) / step**2
        first += int(late)
        out[n] += e[first : first + 49] @ (curve + P.A * rate) / P.B
    return -out


def reversal_pulse(trace: Trace, values: dict[str, float]) -> np.ndarray:
    v, speeds = MOTION.velocity, np.geomspace(1e-4, 1.0, 20)
    table = AXIS.nominal_friction.gain / P.K_f * np.asarray(AXIS.nominal_friction.models["gms"].steady_state(speeds))
    out, heading, pulse = [], 0.0, 0.0
    amplitudes = [values["slow"], values["middle"], values["fast"]]
    for n in range(len(v)):
        if v[n] * heading < 0:
            rate = abs(v[n] - v[n - 1]) / T
            pulse = np.interp(math.log10(rate), np.log10([0.003, 0.03, 0.33]), amplitudes)
        else:
            pulse *= math.exp(-T / values["decay"])
        heading = np.sign(v[n]) or heading
        out.append(heading * (np.interp(abs(v[n]), np.append(0.0, speeds), np.append(0.0, table)) + pulse))
    return np.array(out)


def adaptive(trace: Trace, values: dict[str, float]) -> np.ndarray:
    soft, stiff = nominal_friction(trace, 0.6), nominal_friction(trace, 1.6)
    mean, apart = (soft + stiff) / 2, stiff - soft
    pole = math.exp(-2 * math.pi * values["cutoff"] * T)
    twice = [np.zeros(len(mean)), np.zeros(len(mean))]
    for out, source in zip(twice, (mean, apart), strict=True):
        one = two = 0.0
        for n, given in enumerate(source):
            one = pole * one + (1 - pole) * given
            two = pole * two + (1 - pole) * one
            out[n] = two
    level, shift, volts = 1.0, 0.0, []
    for n in range(len(mean)):
        if n:
            left = trace.disturbance[n - 1]
            step = values["rate"] * T
            level = np.clip(
                level - step * left * twice[0][n - 1] / np.mean(mean**2), values["lowest"], values["highest"]
            )
            shift = np.clip(shift - step * left * twice[1][n - 1] / np.mean(apart**2), -level / 2, level / 2)
        volts.append(level * mean[n] + shift * apart[n])
    assert level > 1.1  # the machine's friction is 1/0.73 of what is fed forward
    return np.array(volts)


PLAIN = {
    "kalman": kalman, "two-dof": two_dof, "sliding-mode": sliding_mode, "gain-scheduled": gain_scheduled,
    "repetitive": repetitive, "reversal-pulse": reversal_pulse, "adaptive": adaptive,
}  # fmt: skip


@pytest.mark.parametrize("name", PLAIN)
def test_the_block_is_what_a_plain_one_is(name: str) -> None:
    trace, values, volts = run_of(name)
    assert trace.saturated == 0
    plain = PLAIN[name](trace, values)
    assert np.abs(volts).max() > 0.05
    assert np.abs(volts - plain).max() < 1e-6


@pytest.mark.parametrize("name", ["kalman", "two-dof"])
def test_margins_and_poles_are_those_of_python_control(name: str) -> None:
    """The observer by python-control's own conversions and interconnection, with the cascade of the machine."""
    setting = setting_of(AXIS, Scheme("s", "", blocks=(name,)), MOTION)
    design = design_block(block_type(name), setting)
    cutoff = design.block.cutoff  # type: ignore[attr-defined]
    loop = SampledLoop(P, C, (design.block,))
    f = np.geomspace(1.0, 1990.0, 1500)
    z = np.exp(2j * np.pi * f * T)
    pole = math.exp(-2 * math.pi * C.velocity_filter * T)
    PI = control.tf([C.K_p + C.K_i * T, -C.K_p], [1, -1], T)
    D = control.tf([(1 - pole) / T, -(1 - pole) / T], [1, -pole], T)
    if name == "two-dof":
        tau = 1 / (2 * math.pi * cutoff)
        lag = [tau**3, 3 * tau**2, 3 * tau, 1.0]
        F = control.c2d(
            control.ss(control.tf([3 * tau / P.B, (1 + 3 * tau * P.A) / P.B, P.A / P.B, 0.0], lag)), T, "tustin"
        )
        Q = control.c2d(control.ss(control.tf([3 * tau, 1.0], lag)), T, "zoh")
        share = DELAY / T - int(DELAY / T)
        wait = z ** -int(DELAY / T) * ((1 - share) + share / z)
        F_z, Q_z = F(z), Q(z) * wait
    else:  # d̂ from the matrices of a steady Kalman filter: x = (I - K·H)·(Phi·x + G·u) + K·z
        Ad, *_ = cont2discrete(
            (
                np.array([[0, 1, P.B * 0], [0, -P.A, P.B], [0, 0, 0]]),
                np.array([[0], [P.B], [0]]),
                np.eye(3),
                np.zeros((3, 1)),
            ),
            T,
        )
        q = ((2 * math.pi * cutoff) ** 3 / P.B * T) ** 2
        scale = np.diag([1.0, T, T**2 * P.B])
        S, _, _ = control.dare(
            (scale @ Ad @ np.linalg.inv(scale)).T, np.eye(3)[:, :1], np.diag([0, 0, q * scale[2, 2] ** 2]), 1
        )
        K = np.linalg.inv(scale) @ S[:, :1] / (S[0, 0] + 1)
        keep = np.eye(3) - K @ np.eye(3)[:1]
        G = control.ss(P.A * 0 + np.array([[0.0, 1], [0, -P.A]]), [[0], [P.B]], np.eye(2), np.zeros((2, 1)))
        share = DELAY - int(DELAY / T) * T
        whole_step, part = control.c2d(G, T), control.c2d(G, T - share)
        early = part.B
        late = whole_step.B - early
        # d̂ = c·(zI - keep·Ad)^-1·(keep·[early; late]·u delayed + K·z·measured), one sample ahead
        F_z, Q_z = np.empty(len(z), complex), np.empty(len(z), complex)
        for i, one in enumerate(z):
            inside = np.linalg.inv(one * np.eye(3) - keep @ Ad)
            pushed = np.vstack([early + late / one, [[0.0]]]) * one ** -int(DELAY / T)
            F_z[i] = (inside @ K * one)[2, 0]
            Q_z[i] = -(inside @ (keep @ pushed))[2, 0]
    L = loop.G(f) * (PI(z) * (D(z) + C.K_v) + F_z) / (1 - Q_z)
    np.testing.assert_allclose(loop.input(f), L, rtol=1e-6)
    peak = 20 * math.log10(np.abs(1 / (1 + L)).max())
    assert design.margins is not None
    assert 20 * math.log10(design.margins.peak_sensitivity) == pytest.approx(peak, abs=0.02)
    assert peak <= 6.0
    omega = 2 * np.pi * f
    table = np.abs(L), np.degrees(np.unwrap(np.angle(L))), omega
    gains, phases, *_ = control.stability_margins(table, returnall=True)
    assert np.degrees(design.margins.phase_margin) == pytest.approx(np.abs(phases).min(), abs=0.1)
    assert design.margins.gain_margin == pytest.approx(gains[gains > 1].min(), rel=2e-3)


def test_what_the_repetitive_controller_learns_shrinks_where_the_plant_is_known_and_grows_where_it_is_not() -> None:
    """|h·(1 - G/G_n)·S| by the formula against the impulse responses; a delay that is not believed makes it grow."""
    setting = setting_of(AXIS, Scheme("s", "", blocks=("repetitive",)), MOTION)
    block = block_type("repetitive")(cutoff=150.0)  # type: ignore[call-arg]
    for late, grows in ((0.0, False), (2.0e-3, True)):
        loop = SampledLoop(replace(P, T_d=P.T_d + late), replace(C, K_p=C.K_p / 3, K_i=C.K_i / 3), (), None, setting)
        assert loop.stable
        share, at = learned_share(block, loop, setting)
        f = np.array([at])
        h = np.exp(-0.5 * (2 * np.pi * f * math.sqrt(math.log(2)) / (2 * np.pi * 150.0)) ** 2)
        # G_n as the filters take it: continuous, its delay T_d ahead
        ratio = loop.G(f) / (P.B / (2j * np.pi * f * (2j * np.pi * f + P.A)) * np.exp(-2j * np.pi * f * P.T_d))
        exact = np.abs(h * (1 - ratio) / (1 + loop.input(f)))[0]
        assert share == pytest.approx(exact, abs=0.02)
        assert (share >= 1.0) is grows
    slow = replace(AXIS, plant=replace(P, T_d=P.T_d + 2.0e-3), nominal=P, cascade=loop.cascade)
    with pytest.raises(FricError, match="grows from period to period"):
        run_axis(slow, MOTION, Scheme("s", "", blocks=("repetitive",)))

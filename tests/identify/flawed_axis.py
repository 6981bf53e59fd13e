"""An axis with the flaws of real drives, in closed loop: friction that falls, a second mass, a force logged late."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numba
import numpy as np
from numpy.typing import NDArray

from fric.log import Log

RATE = 4000.0
STEPS = 20  # of the plant, a sample


@dataclass(frozen=True)
class Machine:
    """One axis [SI]: an elasto-plastic friction with Stribeck's fall on the table, a spring between motor and table."""

    A: float = 14.6
    B: float = 2.5
    K_f: float = 210.0
    transport: float = 0.4e-3
    F_c: float = 0.0
    F_s: float = 0.0
    v_s: float = 1e-3
    stiffness: float = 2e7
    mode: float = 0.0
    """Frequency of the resonance [Hz]; 0 for a rigid axis."""
    ratio: float = 0.3
    """Mass of the table over that of both."""
    damping: float = 0.02
    on_table: bool = False
    """Where the encoder is."""

    @property
    def M(self) -> float:
        return self.K_f / self.B


@numba.njit
def _run(m, gains, r, added, noise, lag, resolution, on_table):  # type: ignore[no-untyped-def]
    K_f, d, M, ratio, omega, zeta, F_c, F_s, v_s, k_f = m
    K_v, K_p, K_i, p, T = gains
    n, h = r.size, T / STEPS
    m2 = ratio * M if omega > 0 else 0.0
    m1 = M - m2
    k = omega**2 * m1 * m2 / M
    c = 2 * zeta * omega * m1 * m2 / M
    z1, v1, z2, v2, spring = r[0], 0.0, r[0], 0.0, 0.0
    past, slow, integral = r[0], 0.0, 0.0
    U, Z = np.zeros(n), np.zeros(n)
    for i in range(n):
        raw = (z2 if on_table else z1) + noise[i]
        measured = np.rint(raw / resolution) * resolution if resolution > 0 else raw
        slow = p * slow + (1 - p) * (measured - past) / T
        past = measured
        error = K_v * (r[i] - measured) - slow
        integral += K_i * T * error
        U[i] = K_p * error + integral + added[i]
        Z[i] = measured
        for s in range(STEPS):
            at = i * STEPS + s - lag
            u = U[at // STEPS] if at >= 0 else 0.0
            v = v2 if omega > 0 else v1
            level = F_c + (F_s - F_c) * np.exp(-abs(v) / v_s)
            F = 0.0
            if level > 0.0:
                spring = min(max(spring + v * h, -level / k_f), level / k_f)
                F = k_f * spring
            if omega > 0:
                z1, z2 = z1 + 0.5 * h * v1, z2 + 0.5 * h * v2
                w1, w2 = v1, v2
                for _ in range(2):  # dampers by the mean of both ends, or B and the resonance are 1e-4 off
                    a1, a2 = 0.5 * (v1 + w1), 0.5 * (v2 + w2)
                    link = k * (z1 - z2) + c * (a1 - a2)
                    w1 = v1 + h * (K_f * u - d * a1 - link) / m1
                    w2 = v2 + h * (link - F) / m2
                v1, v2 = w1, w2
                z1, z2 = z1 + 0.5 * h * v1, z2 + 0.5 * h * v2
            else:
                z1 += 0.5 * h * v1
                v1 = (v1 * (1 - 0.5 * h * d / M) + h * (K_f * u - F) / M) / (1 + 0.5 * h * d / M)
                z1 += 0.5 * h * v1
                z2, v2 = z1, v1
    return U, Z


def run(
    machine: Machine,
    reference: NDArray[np.float64],
    voltage: NDArray[np.float64] | None = None,
    *,
    seed: int = 0,
    position_noise: float = 0.05e-6,
    resolution: float = 0.25e-6,
    force_noise: float = 1.0,
    force_lag: float = 0.0,
    force_filter: float = 0.0,
    force_step: float = 0.0,
    crossover: float = 30.0,
    skip: int = 0,
    name: str = "record",
    kind: str = "frequency-response",
) -> Log:
    """Return what is logged; the force is late by ``force_lag`` samples and a first-order filter [Hz], in steps [N]."""
    n, rng = len(reference), np.random.default_rng([seed, 11])
    added = np.zeros(n) if voltage is None else voltage
    K_p = 2 * np.pi * crossover / machine.B
    gains = (2 * np.pi * crossover / 4, K_p, K_p * 2 * np.pi * crossover / 5, np.exp(-2 * np.pi * 500 / RATE), 1 / RATE)
    values = (
        machine.K_f, machine.M * machine.A, machine.M, machine.ratio, 2 * np.pi * machine.mode, machine.damping,
        machine.F_c, machine.F_s, machine.v_s, machine.stiffness,
    )  # fmt: skip
    u, z = _run(
        np.array(values), np.array(gains), reference, added, rng.normal(0, position_noise, n),
        round(machine.transport * RATE * STEPS), resolution, machine.on_table,
    )  # fmt: skip
    fine = np.repeat(u, STEPS)  # what the held voltage makes of the motor's current, and a filter of its measurement
    if force_filter:
        a, y = -np.expm1(-2 * np.pi * force_filter / RATE / STEPS), np.empty_like(fine)
        state = fine[0]
        for i, value in enumerate(fine):
            state += a * (value - state)
            y[i] = state
        fine = y
    at = np.rint((np.arange(n) - force_lag) * STEPS).astype(int)
    force = machine.K_f * fine[np.clip(at, 0, len(fine) - 1)] + rng.normal(0, force_noise, n)
    if force_step:
        force = np.rint(force / force_step) * force_step
    log = Log(np.arange(n) / RATE, position=z, force=force, input=u, reference=reference, name=name, kind=kind)
    return replace(log.slice(skip, n), time=np.arange(n - skip) / RATE)


def multisine(lines: NDArray[np.int64], period: int, rng: np.random.Generator) -> NDArray[np.float64]:
    """Return one period of a multisine of peak 1 with random phases."""
    n = np.arange(period)
    phase = rng.uniform(0, 2 * np.pi, len(lines))
    x = np.cos(2 * np.pi * np.outer(n, lines) / period + phase).sum(axis=1)
    return x / np.abs(x).max()


def shaken(
    machine: Machine, *, seed: int = 0, peak: float = 2.0, mean: float = 0.03, periods: int = 8, period: int = 4000,
    highest: float = 400.0, count: int = 40, swing: float = 0.0, **options: float,
) -> Log:  # fmt: skip
    """Return the axis in steady motion (or around rest: mean 0), shaken by a voltage or a reference of sparse lines."""
    rng = np.random.default_rng([seed, 5])
    top = highest * period / RATE
    lines = np.unique(np.rint(np.geomspace(2, top, count)).astype(int))
    tall = np.tile(multisine(lines, period, rng), periods + 1)
    r = mean * np.arange(len(tall)) / RATE + swing * tall
    return run(machine, r, None if swing else peak * tall, seed=seed, skip=period, **options)

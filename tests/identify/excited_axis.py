"""A linear axis in closed loop, excited: an own small simulation, against which identification is tested."""

from __future__ import annotations

import numba
import numpy as np
from numpy.typing import NDArray

from fric.drive.plant import LinearPlant
from fric.log import Log

X = LinearPlant(28.57, 4.526, 0.65e-3)
Y = LinearPlant(20.00, 8.916, 0.65e-3)
GAINS = {X: (126.0, 83.7, 3156.0), Y: (126.0, 42.4, 1600.0)}
RATE = 4000.0
STEPS = 10  # plant steps a sample: the transport delay of 2.1 samples is 21 of them


@numba.njit
def _run(phi, gamma, friction, gains, r, added, load, noise, lag, resolution):  # type: ignore[no-untyped-def]
    n = r.size
    K_v, K_p, K_i, p, T = gains
    F_c, k = friction
    z, v, F, past, slow, integral = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    U, Zm = np.zeros(n), np.zeros(n)
    for i in range(n):
        raw = z + noise[i]
        measured = np.rint(raw / resolution) * resolution if resolution > 0 else raw
        slow = p * slow + (1 - p) * (measured - past) / T
        past = measured
        error = K_v * (r[i] - measured) - slow
        integral += K_i * T * error
        U[i] = K_p * error + integral + added[i]
        Zm[i] = measured
        for s in range(STEPS):
            at = i * STEPS + s - lag
            u = U[at // STEPS] if at >= 0 else 0.0
            a = u + load[i] - F
            z_next = z + phi[0] * v + gamma[0] * a
            v = phi[1] * v + gamma[1] * a
            F = min(max(F + k * (z_next - z), -F_c), F_c)
            z = z_next
    return U, Zm


def multisine(lines: NDArray[np.int64], period: int, rng: np.random.Generator) -> NDArray[np.float64]:
    """Return one period of a multisine of unit amplitudes and random phases, the least peaked of five."""
    n = np.arange(period)
    draws = []
    for _ in range(5):
        phase = rng.uniform(0, 2 * np.pi, len(lines))
        draws.append(np.cos(2 * np.pi * np.outer(n, lines) / period + phase).sum(axis=1))
    return min(draws, key=lambda x: float(np.abs(x).max()))


def excite(
    plant: LinearPlant,
    *,
    seed: int,
    reference: NDArray[np.float64] | None = None,
    voltage: NDArray[np.float64] | None = None,
    position_noise: float = 0.1e-6,
    voltage_noise: float = 0.02,
    resolution: float = 0.25e-6,
    friction: float = 0.0,
    stiffness: float = 2e5,
    skip: int = 0,
    log_reference: bool = True,
) -> Log:
    """Return what the drive logs; friction [V] is a spring (stiffness [V/m]) that slips, the force over K_f."""
    n = len(reference if reference is not None else voltage)
    rng = np.random.default_rng([seed, 7])
    h = 1 / RATE / STEPS
    Phi, Gamma = plant.held(h)
    K_v, K_p, K_i = GAINS[plant]
    r = np.zeros(n) if reference is None else reference
    u, z = _run(
        np.array([Phi[0, 1], Phi[1, 1]]), Gamma, np.array([friction, stiffness]),
        np.array([K_v, K_p, K_i, np.exp(-2 * np.pi * 500 / RATE), 1 / RATE]), r,
        np.zeros(n) if voltage is None else voltage, rng.normal(0, voltage_noise, n),
        rng.normal(0, position_noise, n), round(plant.transport_delay(RATE) / h), resolution,
    )  # fmt: skip
    t = np.arange(n) / RATE
    log = Log(t, position=z, input=u, reference=r if log_reference else None, kind="frequency-response")
    return log.slice(skip, n)


def shaken(
    plant: LinearPlant, *, seed: int, peak: float = 2.0, mean: float = 0.03, periods: int = 8, period: int = 2000,
    **options: float,
) -> Log:  # fmt: skip
    """Return a moving axis whose voltage is shaken by a multisine of this peak [V], 2 to 400 Hz."""
    rng = np.random.default_rng([seed, 3])
    lines = np.unique(np.rint(np.geomspace(1, 0.1 * period, 60)).astype(int))
    tall = multisine(lines, period, rng)
    voltage = np.tile(tall * peak / np.abs(tall).max(), periods + 1)
    ramp = mean * np.arange(len(voltage)) / RATE
    return excite(plant, seed=seed, reference=ramp, voltage=voltage, skip=period, **options)

"""Strokes that stick and slip, simulated apart: bristles under a cascade, with no code of fric."""

from typing import Any

import numpy as np
import pytest
from numba import njit

import fric
from fric.errors import FricError

SPEEDS = np.array([0.3e-3, 0.6e-3, 1e-3, 2e-3, 4e-3, 8e-3, 15e-3, 30e-3, 50e-3, 80e-3])


@njit
def simulated(reference, velocity, acceleration, dt, gains, m, levels, v_s, sigma, offset):  # type: ignore[no-untyped-def] # pragma: no cover
    """Return position and force of one mass on bristles (LuGre without damping), of 20 implicit steps a sample."""
    (K_p, K_v, K_i), (F_c, F_s), stiffness = gains, levels, 2e7
    x, v, z, held = reference[0], 0.0, 0.0, 0.0
    position, force, h = np.empty(len(reference)), np.empty(len(reference)), dt / 20
    for i in range(len(reference)):
        missing = velocity[i] + K_v * (reference[i] - x) - v
        held += K_i * missing * dt
        position[i], force[i] = x, K_p * missing + held + m * acceleration[i]
        for _ in range(20):
            level = F_c + (F_s - F_c) * np.exp(-abs(v) / v_s)
            z = (z + h * v) / (1.0 + h * stiffness * abs(v) / level)
            v += h * (force[i] - stiffness * z - sigma * v - offset) / m
            x += h * v
    return position, force


def session(seed: int) -> tuple[list[fric.Log], dict[str, float]]:
    """Return strokes there and back on an axis near the limit of its loop, and its map."""
    rng = np.random.default_rng(seed)
    F_c = rng.uniform(20, 80)
    true = {"F_c": F_c, "F_s": F_c * rng.uniform(1.4, 1.7), "v_s": rng.uniform(2e-3, 4e-3)}
    true["sigma"] = rng.uniform(100, 600)
    offset, m, w = rng.uniform(-5, 5), rng.uniform(15, 60), rng.uniform(90, 115)
    gains = m * w, w * rng.uniform(0.7, 0.9), m * w**2 * rng.uniform(0.08, 0.12)
    dt, logs = 1e-3, []
    for speed in SPEEDS * rng.uniform(0.7, 1.4):
        half = float(np.clip(0.02 / speed, 2, 20)) / 2
        t = np.arange(int(2 * half / dt)) * dt
        into = np.minimum(t % half, half - t % half) / min(speed, 0.1 * half)
        v = np.where(t < half, speed, -speed) * np.clip(into, 0, 1)
        z = np.cumsum(v) * dt
        map_of = (true["F_c"], true["F_s"]), true["v_s"], true["sigma"], offset
        position, force = simulated(z, v, np.gradient(v, dt), dt, gains, m, *map_of)
        columns: dict[str, Any] = {"time [s]": t, "position [m]": position}
        logs.append(fric.Log.from_frame({**columns, "force [N]": force + rng.normal(0, 0.02 * F_c, len(t))}))
    return logs, true


def held(seed: int) -> dict[str, bool] | None:
    """Return whether the intervals of a session that sticks and slips hold its map; None of another session."""
    logs, true = session(seed)
    try:
        found = fric.identify_static(logs)
    except FricError:
        return None
    if "strokes-swing" not in {notice.code for notice in found.fit.warnings}:
        return None
    limits = {name: getattr(found, name).limits for name in true}
    return {name: low <= true[name] <= high for name, (low, high) in limits.items()}


def test_the_slowest_strokes_stick_though_their_swing_reads_less() -> None:
    """F_s was 0.7 % off with an interval of 0.1 %: the fastest parts of a slip are lost below the noise."""
    assert held(304) == dict.fromkeys(("F_c", "F_s", "v_s", "sigma"), True)


@pytest.mark.long(120)
def test_intervals_of_strokes_that_stick_and_slip_hold_the_map() -> None:
    """Of 95 % intervals in 30 or more sessions less than four of five hold with a chance of 1e-3."""
    rows = [row for row in map(held, range(300, 360)) if row is not None]
    assert len(rows) >= 30
    for name in ("F_c", "F_s", "v_s", "sigma"):
        assert np.mean([row[name] for row in rows]) > 0.8, name

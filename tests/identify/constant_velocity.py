"""Kinematic strokes at constant velocity with a known friction map, as an encoder and a force channel log them."""

from __future__ import annotations

import numpy as np

from fric.friction.stribeck import StaticMap
from fric.log import Log

PAPER_SPEEDS = np.array([0.01, 0.04, 0.08, 0.2, 0.4, 0.5, 1, 2, 4, 5, 8, 10, 14, 16, 20, 25, 30]) * 1e-3
"""The paper's 17 speeds [m/s], Section 3.1.1."""

TABLE_1 = StaticMap(F_c=105.0, F_s=165.0, v_s=1e-3, delta=1.0, sigma=40.0)
"""The paper's Table 1."""


def stroke(
    v: float, rng: np.random.Generator, *, friction: StaticMap = TABLE_1, samples: int = 1500, sampling: float = 1000.0,
    noise: float = 0.01, encoder: float = 0.25e-6, offset: float = 0.0, memory: float = 0.0,
) -> Log:  # fmt: skip
    """Return one record at velocity v [m/s]; ``memory`` is the lag-one correlation of the force noise."""
    time = np.arange(samples) / sampling
    position = v * time + rng.uniform(0, 1e-6)
    if encoder:
        position = np.round(position / encoder) * encoder
    force = float(friction.steady_state(v)) + offset
    white = rng.standard_normal(samples)
    if memory:
        for n in range(1, samples):
            white[n] = memory * white[n - 1] + np.sqrt(1 - memory**2) * white[n]
    return Log(time, position, force=force + abs(force) * noise * white, kind="constant-velocity", name=f"{1e3 * v:g}")


def both_directions(speeds: np.ndarray = PAPER_SPEEDS) -> np.ndarray:
    return np.concatenate([-speeds[::-1], speeds])

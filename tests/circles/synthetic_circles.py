"""Circles with known faults, made point by point: no code shared with what takes them apart."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fric.circles.measured import AxisTrace, MeasuredCircle

QUADRANTS = ("+x", "+y", "-x", "-y")


@dataclass(frozen=True)
class Faults:
    """What is wrong with a machine: lengths in m, times in s, squareness in rad."""

    centre: tuple[float, float] = (0.0, 0.0)
    scale: tuple[float, float] = (1.0, 1.0)
    backlash: tuple[float, float] = (0.0, 0.0)
    squareness: float = 0.0
    lag: tuple[float, float] = (0.0, 0.0)
    glitch: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)
    fade: float = 0.02
    pitch: float = 0.0
    periodic: float = 0.0


def drawn_faults(rng: np.random.Generator) -> Faults:
    return Faults(
        centre=tuple(rng.normal(0, 3e-6, 2)),
        scale=tuple(1 + rng.normal(0, 5e-5, 2)),
        backlash=tuple(rng.uniform(0, 6e-6, 2)),
        squareness=rng.normal(0, 5e-5),
        lag=tuple(rng.uniform(0, 50e-6, 2)),
        glitch=tuple(rng.uniform(-12e-6, 20e-6, 4)),
        fade=rng.uniform(0.01, 0.03),
    )


def circle(
    faults: Faults, rng: np.random.Generator, *, direction: int = 1, radius: float = 0.03, feed: float = 0.1,
    revolutions: int = 2, sampling: float = 4000.0, noise: float = 1e-7, instrument: str = "grid",
) -> MeasuredCircle:  # fmt: skip
    omega = direction * feed / radius
    n = int(2 * np.pi * revolutions / abs(omega) * sampling) + 1
    t = np.arange(n) / sampling
    theta = omega * t + 0.7
    along = [np.cos(omega * (t - faults.lag[0]) + 0.7), np.sin(omega * (t - faults.lag[1]) + 0.7)]
    x, y = radius * along[0], radius * along[1]
    # a table whose y axis leans away from +x by the squareness
    x, y = faults.centre[0] + faults.scale[0] * x - faults.squareness * y, faults.centre[1] + faults.scale[1] * y
    x = x + faults.periodic * np.cos(2 * np.pi * radius * np.cos(theta) / faults.pitch + 0.4) if faults.pitch else x
    x = x - faults.backlash[0] / 2 * np.sign(-direction * np.sin(theta))
    y = y - faults.backlash[1] / 2 * np.sign(direction * np.cos(theta))
    for quarter, height in enumerate(faults.glitch):
        since = ((direction * (theta - quarter * np.pi / 2) + np.pi) % (2 * np.pi) - np.pi) / abs(omega)
        pulse = np.where(since > 0, since / faults.fade * np.exp(1 - since / faults.fade), 0.0)
        x, y = x + height * pulse * np.cos(theta), y + height * pulse * np.sin(theta)
    axes = {
        "x": AxisTrace(t, x + rng.normal(0, noise, n) if noise else x, radius * np.cos(theta)),
        "y": AxisTrace(t, y + rng.normal(0, noise, n) if noise else y, radius * np.sin(theta)),
    }
    return MeasuredCircle(radius, feed, direction, axes, instrument=instrument)


def truths(faults: Faults, feed: float = 0.1) -> dict[str, float]:
    return {
        "centre.x": faults.centre[0], "centre.y": faults.centre[1],
        "scale.x": faults.scale[0], "scale.y": faults.scale[1],
        "backlash.x": faults.backlash[0], "backlash.y": faults.backlash[1],
        "squareness": faults.squareness, "mismatch": feed * (faults.lag[0] - faults.lag[1]) / 2,
    }  # fmt: skip

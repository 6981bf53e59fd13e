"""Kinematics of strokes with known boundaries: ramps, plateaus and dwells, seen through an encoder."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Strokes:
    """Samples of time, exact motion, acceleration of the ramps, and plateaus: (first time, last time, velocity)."""

    time: NDArray[np.float64]
    position: NDArray[np.float64]
    velocity: NDArray[np.float64]
    acceleration: NDArray[np.float64]
    ramp: float
    plateaus: list[tuple[float, float, float]]


def strokes(
    legs: Sequence[tuple[float, float]], *, acceleration: float = 1.0, dwell: float = 0.2, rate: float = 4000.0
) -> Strokes:
    """Return strokes (velocity [m/s], duration of the plateau [s]) with a ramp up and down and a dwell before each."""
    corners, speeds, plateaus = [0.0], [0.0], []
    for velocity, duration in legs:
        ramp = abs(velocity) / acceleration
        begin = corners[-1] + dwell
        corners += [begin, begin + ramp, begin + ramp + duration, begin + duration + 2 * ramp]
        speeds += [0.0, velocity, velocity, 0.0]
        plateaus.append((begin + ramp, begin + ramp + duration, velocity))
    corners.append(corners[-1] + dwell)
    speeds.append(0.0)
    t_c, v_c = np.array(corners), np.array(speeds)
    z_c = np.concatenate([[0.0], np.cumsum(0.5 * (v_c[1:] + v_c[:-1]) * np.diff(t_c))])
    t = np.arange(int(corners[-1] * rate)) / rate
    leg = np.clip(np.searchsorted(t_c, t, side="right") - 1, 0, len(t_c) - 2)
    a = (np.diff(v_c) / np.maximum(np.diff(t_c), 1e-12))[leg]
    tau = t - t_c[leg]
    return Strokes(t, z_c[leg] + v_c[leg] * tau + 0.5 * a * tau**2, v_c[leg] + a * tau, a, acceleration, plateaus)


def encoder(position: NDArray[np.float64], step: float, offset: float = 0.0) -> NDArray[np.float64]:
    """Return the position in whole counts of an encoder."""
    return np.floor((position + offset) / step) * step

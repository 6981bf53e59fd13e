"""Time of a replayed step of every friction model, against a four-block GMS; a stiff LuGre among them."""

from __future__ import annotations

from dataclasses import replace
from time import perf_counter

import numpy as np

from fric.friction import FrictionModel, models
from fric.friction.gms import GMS
from fric.friction.lugre import LuGre

STEPS = 50_000
BASELINE = GMS.typical()
BASELINE = replace(BASELINE, alpha=(0.5, 0.2, 0.2, 0.1), k=(1e8, 2e6, 1e6, 2e5))


def run() -> list[tuple[str, str, str]]:
    """Time every model in turn with the baseline, on the 30 mm circle at 100 mm/s and on a sine of 15 µm."""
    time = np.arange(STEPS) * 1e-4
    candidates: list[tuple[str, FrictionModel, str]] = [
        (name, model.typical(), "told") for name, model in models().items()
    ]
    candidates.append(("lugre with sigma_0 of 1e8 N/m", replace(LuGre.typical(), sigma_0=1e8), "at most 3"))
    rows = []
    for motion, (amplitude, omega) in {"100 mm/s": (30e-3, 100 / 30), "15 um": (15e-6, 0.2 * np.pi)}.items():
        position, velocity = amplitude * np.sin(omega * time), amplitude * omega * np.cos(omega * time)
        for name, model, target in candidates:
            spent = np.array([[_seconds(m, time, position, velocity) for m in (model, BASELINE)] for _ in range(40)])
            ours, baseline = spent.min(axis=0)
            told = f"{ours / baseline:.2f} ({ours / STEPS * 1e9:.0f} / {baseline / STEPS * 1e9:.0f} ns)"
            rows.append((f"step of {name} / of a four-block gms, {motion}", told, target))
    return rows


def _seconds(model: FrictionModel, *motion: np.ndarray) -> float:
    start = perf_counter()
    model.replay(*motion)
    return perf_counter() - start

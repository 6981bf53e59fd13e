"""The static map from 34 logs of 30 000 samples, against line and mean by numpy and one fit by scipy's curve_fit."""

from __future__ import annotations

from time import perf_counter

import numpy as np
from scipy.optimize import curve_fit

import fric
from fric.friction.stribeck import StaticMap
from fric.identify.static_map.identify import identify_static
from fric.identify.static_map.points import Asked

SPEEDS = np.array([0.01, 0.04, 0.08, 0.2, 0.4, 0.5, 1, 2, 4, 5, 8, 10, 14, 16, 20, 25, 30]) * 1e-3
SAMPLES = 30_000
TRUE = StaticMap(F_c=105.0, F_s=165.0, v_s=1e-3, delta=1.0, sigma=40.0)


def logs() -> list[fric.Log]:
    """Make one record a speed and direction: 0.25 µm encoder, 1 % force noise."""
    rng = np.random.default_rng(1)
    time = np.arange(SAMPLES) / 1000.0
    made = []
    for v in np.concatenate([-SPEEDS[::-1], SPEEDS]):
        position = np.round((v * time + rng.uniform(0, 0.25e-6)) / 0.25e-6) * 0.25e-6
        force = float(TRUE.steady_state(v)) * (1 + 0.01 * rng.standard_normal(SAMPLES))
        made.append(fric.Log(time, position, force=force, kind="constant-velocity", name=f"{v:g}"))
    return made


def _plain(v: np.ndarray, F_c: float, F_s: float, v_s: float, sigma: float, offset: float) -> np.ndarray:
    return np.sign(v) * (F_c + (F_s - F_c) * np.exp(-np.abs(v / v_s))) + sigma * v + offset


def run() -> list[tuple[str, str, str]]:
    """Time the whole identification, segmentation and intervals included; imports are done before."""
    records = logs()
    identify_static(records[:3] + records[-3:], Asked())
    start = perf_counter()
    identify_static(records, Asked())
    whole = perf_counter() - start
    start = perf_counter()
    v = np.array([np.polyfit(log.time, log.position, 1)[0] for log in records])
    F = np.array([np.mean(log.force) for log in records])
    curve_fit(_plain, v, F, p0=[100, 150, 2e-3, 50, 0])
    baseline = perf_counter() - start
    what = "identify static, 34 × 30 000 samples / numpy lines and means and one curve_fit, no intervals"
    return [(what, f"{whole / baseline:.1f} ({whole:.2f} s)", "under 1 s")]

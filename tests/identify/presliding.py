"""Records of a GMS machine along a given motion: the truth is known, nothing is in closed loop."""

from __future__ import annotations

from functools import partial

import numpy as np

from fric.friction.gms import GMS
from fric.friction.stribeck import StaticMap
from fric.identify.gms import identify
from fric.log import Log

identify_gms = partial(identify.identify_gms, places=1)
"""Half of a fit goes into records made again at three places between two counts, which `test_hunting.py` holds."""

PAPER = StaticMap(F_c=105.0, F_s=165.0, v_s=1e-3, delta=1.0, sigma=40.0)
TABLE_1 = GMS(
    PAPER,
    alpha=tuple(a / 1.002 for a in (0.566, 0.227, 0.170, 0.039)),
    k=(99.94e6, 1.364e6, 1.081e6, 0.119e6),
    C=1e4,
)
APART = GMS(PAPER, alpha=(0.4, 0.3, 0.2, 0.1), k=(66e6, 9.9e6, 1.65e6, 0.2e6), C=1e4)
"""Blocks well apart: they slip at 1, 5, 20 and 82.5 µm."""


def record(
    amplitude: float,
    model: GMS = TABLE_1,
    *,
    frequency: float = 0.1,
    cycles: int = 5,
    dt: float = 1e-2,
    step: float = 0.25e-6,
    noise: float = 1.0,
    offset: float = 0.0,
    mean: float = 0.0,
    mass: float = 0.0,
    damping: float = 0.0,
    kind: str = "presliding-sine",
    seed: int = 0,
) -> Log:
    """Return a record of a sine about a mean velocity; mass [kg] and damping [N·s/m] add to the logged force."""
    rng = np.random.default_rng([seed, round(amplitude * 1e9)])
    time = np.arange(0.0, (cycles + 0.3) / frequency, dt)
    w = 2 * np.pi * frequency
    z = mean * time + amplitude * np.sin(w * time)
    v = mean + amplitude * w * np.cos(w * time)
    force = model.replay(time, z, v) + offset + noise * rng.standard_normal(time.size)
    force += damping * v - mass * amplitude * w**2 * np.sin(w * time)
    position = np.rint(z / step) * step if step else z
    return Log(time, position=position, force=force, kind=kind, name=f"{kind} {amplitude * 1e6:g} um")


def pair(model: GMS = TABLE_1, **settings: float) -> list[Log]:
    """Return the paper's two records, 15 and 450 µm at 0.1 Hz."""
    return [record(amplitude, model, **settings) for amplitude in (15e-6, 450e-6)]


def rms_error(found: GMS, true: GMS = TABLE_1, reach: float = 100e-6) -> float:
    """Return the rms difference of two virgin curves from 0 to a displacement [N]."""
    z = np.linspace(0.0, reach, 1001)[1:]
    return float(np.sqrt(np.mean((found.virgin_curve(z) - true.virgin_curve(z)) ** 2)))

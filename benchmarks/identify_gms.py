"""`identify gms` on the paper's two records, against plain replays, and scipy's curve_fit of the curve alone."""

from __future__ import annotations

from pathlib import Path
from time import perf_counter, process_time

import numpy as np
from scipy.optimize import curve_fit

import fric
from fric.friction.gms import GMS
from fric.friction.stribeck import StaticMap
from fric.identify.gms.identify import identify_gms
from fric.simulate.experiment import experiment

PAPER = StaticMap(F_c=105.0, F_s=165.0, v_s=1e-3, delta=1.0, sigma=40.0)
MACHINE = Path(__file__).parents[1] / "configs/xy-table.yaml"
START = [1e-6, 20e-6, 60e-6, 0.5, 0.3, 0.2]


def _curve(z: np.ndarray, *theta: float) -> np.ndarray:
    d, share = np.array(theta[:3]), np.array(theta[3:])
    return 165.0 * (np.minimum(z[:, None] / d, 1.0) @ share)


def run() -> list[tuple[str, str, str]]:
    """Time the whole identification with five cycles of each record; imports and compilation are done before."""
    axis = fric.read_machine(MACHINE).axes["x"]
    logs = list(experiment(axis, "presliding-sine"))
    fit = identify_gms(logs, static=PAPER, plant=axis.plant)
    begin, cpu = perf_counter(), process_time()
    fit = identify_gms(logs, static=PAPER, plant=axis.plant)
    whole, busy = perf_counter() - begin, process_time() - cpu

    model = fit.model
    begin = perf_counter()
    for _ in range(10):
        for motion in (one.record.motion for one in fit.hysteresis):
            model.replay(motion.time, motion.position, motion.velocity)
    replay = (perf_counter() - begin) / 10

    z, force = fit.curve.displacement, fit.curve.force
    theta, _ = curve_fit(_curve, z, force, p0=START, maxfev=20_000)

    true = axis.friction
    assert isinstance(true, GMS)
    at = np.linspace(0.0, 100e-6, 1001)[1:]
    refined = float(np.sqrt(np.mean((model.virgin_curve(at) - true.virgin_curve(at)) ** 2)))
    knots = float(np.sqrt(np.mean((_curve(at, *theta) - true.virgin_curve(at)) ** 2)))
    return [
        ("identify gms, two records of five cycles: computing after start-up", f"{busy:.2f} s", "under 5 s"),
        ("  … in replays of both records", f"{whole / replay:.0f} × {1e3 * replay:.2f} ms", "reported"),
        ("virgin curve from the truth, rms: refined / curve_fit alone", f"{refined:.2f} / {knots:.2f} N", "under 1 N"),
    ]

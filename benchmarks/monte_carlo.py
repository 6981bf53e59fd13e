"""A Monte Carlo of 200 machines with six schemes each, on two cores against one; and the same digits on both.

Wall time of the whole, the start of the processes included. FRIC_BENCH_REPEAT (1) pairs are run.
"""

from __future__ import annotations

import os
from pathlib import Path
from statistics import median
from time import perf_counter

import numpy as np

from fric.compensation.base import PAPER_SCHEMES
from fric.documents.machine_files import read_machine
from fric.simulate.monte_carlo import Study, monte_carlo
from fric.simulate.processes import default_workers

MACHINE = read_machine(Path(__file__).parents[1] / "configs/xy-table.yaml")
MACHINES = 200


def run() -> list[tuple[str, str, str]]:
    """Time the study on one process and on two, in turn."""
    what = f"{MACHINES} machines × 6 schemes, one core / two cores"
    if default_workers() < 2:
        return [(what, "skipped: there is one core", "at least 1.8 ×")]
    study = Study(MACHINE, tuple(PAPER_SCHEMES.values()))
    study(0)
    pairs = []
    for _ in range(int(os.environ.get("FRIC_BENCH_REPEAT", "1"))):
        found, seconds = [], []
        for workers in (1, 2):
            start = perf_counter()
            found.append(monte_carlo(study, MACHINES, workers=workers).quadrants)
            seconds.append(perf_counter() - start)
        assert np.array_equal(*found)
        pairs.append(seconds)
    one, two = sorted(pairs, key=lambda pair: pair[0] / pair[1])[len(pairs) // 2]
    ratio = median(one / two for one, two in pairs)
    return [(what, f"{ratio:.2f} × ({one:.1f} / {two:.1f} s)", "at least 1.8 ×")]

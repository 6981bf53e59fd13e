"""A Monte Carlo of 200 machines with six schemes each, on two cores against one; and the same digits on both.

Wall time of the whole, the start of the processes included. FRIC_BENCH_REPEAT (1) pairs are run. Two processes that
know nothing of each other show what the machine allows: cores that share a unit, or a neighbour, hold those back too.
"""

from __future__ import annotations

import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from statistics import median
from time import perf_counter, process_time

import numpy as np

from fric.control.scheme import PAPER_SCHEMES
from fric.documents.machine_files import read_machine
from fric.simulate.processes import Study, default_workers, run_all

MACHINE = read_machine(Path(__file__).parents[1] / "configs/xy-table.yaml")
STUDY = Study(MACHINE, tuple(PAPER_SCHEMES.values()))
MACHINES = 200


def _independent(processes: int) -> float:
    """Return how long so many processes take for half the machines each, all at once, after their imports [s]."""
    words = [sys.executable, "-m", "benchmarks.monte_carlo"]
    started = [
        subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) for _ in range(processes)
    ]
    for process in started:
        assert process.stdout is not None
        process.stdout.readline()  # it is ready
    for process in started:
        assert process.stdin is not None
        process.stdin.write("go\n")
        process.stdin.flush()
    return max(float(process.communicate()[0]) for process in started)


def _alone() -> None:
    """Be one of these processes."""
    STUDY(0)
    print("ready", flush=True)
    sys.stdin.readline()
    start = perf_counter()
    for index in range(MACHINES // 2):
        STUDY(index)
    print(perf_counter() - start)


def run() -> list[tuple[str, str, str]]:
    """Time the study exactly and to its accuracy, and on one process and on two, in turn."""
    exact = replace(STUDY, accuracy=0.0)
    STUDY(0)
    exact(0)
    seconds = []
    for study in (exact, STUDY):
        start = process_time()
        for index in range(20):
            study(index)
        seconds.append((process_time() - start) / 20)
    rows = [
        (
            f"a machine, six schemes: exactly / to {STUDY.accuracy * 1e6:g} µm, processor time",
            f"{seconds[0] / seconds[1]:.1f} × ({1e3 * seconds[0]:.0f} / {1e3 * seconds[1]:.0f} ms)",
            "at least 2.5 ×",
        )
    ]
    what = f"{MACHINES} machines × 6 schemes, one core / two cores"
    if default_workers() < 2:
        return [*rows, (what, "skipped: there is one core", "at least 1.8 ×")]
    pairs = []
    for _ in range(int(os.environ.get("FRIC_BENCH_REPEAT", "1"))):
        found, seconds = [], []
        for workers in (1, 2):
            start = perf_counter()
            found.append([outcome.quadrants for outcome in run_all(STUDY, MACHINES, workers=workers)])
            seconds.append(perf_counter() - start)
        assert np.array_equal(*found)
        pairs.append((*seconds, 2 * _independent(1) / _independent(2)))
    one, two, _ = sorted(pairs, key=lambda pair: pair[0] / pair[1])[len(pairs) // 2]
    ratio, possible = median(one / two for one, two, _ in pairs), median(reached for _, _, reached in pairs)
    return [
        *rows,
        (what, f"{ratio:.2f} × ({one:.1f} / {two:.1f} s)", "at least 1.8 ×"),
        ("the same by two processes that know nothing of each other", f"{possible:.2f} ×", "what the machine allows"),
    ]


if __name__ == "__main__":
    _alone()

"""A Monte Carlo of 200 machines with six schemes each, on two cores against one; and the same digits on both."""

from __future__ import annotations

from collections import defaultdict
from pathlib import Path
from threading import get_native_id
from time import perf_counter

import numpy as np

from fric.compensation.base import PAPER_SCHEMES
from fric.io.machine import read_machine
from fric.simulate.monte_carlo import Outcome, Study, default_workers, outcomes

MACHINE = read_machine(Path(__file__).parents[1] / "configs/xy-table.yaml")
BLOCKS, SIZE = 10, 20  # one core and two take turns, so that what else the computer does meets both


class _Watched:
    """A study that notes for how long each thread was at work, without what it waited in the queue for a core."""

    def __init__(self, study: Study) -> None:
        self.study = study
        self.seconds: dict[int, float] = defaultdict(float)

    def __call__(self, index: int) -> Outcome:
        thread = get_native_id()
        queued, start = _queued(thread), perf_counter()
        outcome = self.study(index)
        self.seconds[thread] += perf_counter() - start - (_queued(thread) - queued)
        return outcome


def _queued(thread: int) -> float:
    """Return for how long a thread was ready to run and had no core [s]."""
    return int(Path(f"/proc/self/task/{thread}/schedstat").read_text().split()[1]) * 1e-9


def run() -> list[tuple[str, str, str]]:
    """Time blocks of machines on one worker and on two, in turn."""
    what = f"{BLOCKS * SIZE} machines × 6 schemes, one core / two cores"
    if default_workers() < 2:
        return [(what, "skipped: there is one core", "at least 1.8 ×")]
    Study(MACHINE, tuple(PAPER_SCHEMES.values()))(0)
    elapsed, at_work = np.zeros((BLOCKS, 2)), np.zeros((BLOCKS, 2))
    for block in range(BLOCKS):
        found = []
        for n in (0, 1):
            study = _Watched(Study(MACHINE, tuple(PAPER_SCHEMES.values()), seed=block))
            start = perf_counter()
            with outcomes(study, SIZE, workers=n + 1) as given:  # type: ignore[arg-type]
                found.append(np.array([outcome.quadrants for outcome in given]))
            elapsed[block, n] = perf_counter() - start
            at_work[block, n] = sum(study.seconds.values()) / (n + 1)
        assert np.array_equal(*found)
    rows = []
    for told, seconds in ((what, elapsed), ("the same, without the time for which no core was free", at_work)):
        one, two = seconds.sum(axis=0)
        rows.append((told, f"{one / two:.2f} × ({one:.1f} / {two:.1f} s)", "at least 1.8 ×"))
    return rows

"""A fleet of 100 machines at two dates: which axes are found to have changed, and what two workers are worth.

Two workers are timed three times: by the clock, which needs an idle machine; by the processor time of the busier one,
which is what the clock would show were it idle; and by half of that of both, where one was let run more than the other.
A worker's own threads take 2.6 % of the time by the clock, and so more where others run beside it.
"""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from pathlib import Path
from time import perf_counter, process_time
from typing import Any

import fric
from tests.automatic.fleet_rig import make_fleet

MACHINES = int(os.environ.get("FRIC_FLEET", "100"))
DRIFTED = frozenset(range(3, MACHINES, 10))


def numbers(found: Any) -> list[Any]:
    """Return every number that was identified, by machine, date and axis."""
    told = []
    for outcome in found.outcomes:
        for name, axis in outcome.axes.items():
            for document in filter(None, (axis.friction, axis.plant)):
                kept = {key: part for key, part in document.tree().items() if key != "provenance"}
                told.append((outcome.unit.machine, outcome.unit.date, name, document.type, kept))
    return told


def run() -> Iterator[tuple[str, str, str]]:
    import distributed

    with tempfile.TemporaryDirectory() as folder:
        logs = Path(folder) / "logs"
        make_fleet(logs, MACHINES, DRIFTED)
        begin, cpu = perf_counter(), process_time()
        alone = fric.auto(logs, output=Path(folder) / "alone", workers=1)
        clock, cpu = perf_counter() - begin, process_time() - cpu
        cluster = distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None)
        with cluster, distributed.Client(cluster) as client:
            before = client.run(process_time)
            begin = perf_counter()
            shared = fric.auto(logs, output=Path(folder) / "shared", scheduler=cluster.scheduler_address)
            clock_shared = perf_counter() - begin
            spent = {worker: now - before[worker] for worker, now in client.run(process_time).items()}
        truth = {f"machine-{n:03d}" for n in DRIFTED}
        found = {machine for machine, _ in alone.changed}
        yield f"{MACHINES} machines: changed axes found", f"{len(found & truth)} of {len(truth)}", "all"
        yield "others found", str(len(found - truth)), "0"
        moved = {(one.machine, one.axis) for one in alone.drifts if one.change.verdict == "moved"}
        yield "others beyond their own 95 % interval", str(len({m for m, _ in moved} - truth)), "some 20 %"
        yield "the same digits on a Dask cluster", str(numbers(alone) == numbers(shared)), "True"
        yield (
            "the same changes",
            str([vars(one) for one in alone.drifts] == [vars(one) for one in shared.drifts]),
            "True",
        )
        yield "processor time alone over that of the busier worker", f"{cpu / max(spent.values()):.2f}", "≥ 1.8"
        half = 0.5 * sum(spent.values())
        yield "processor time alone over half of that of both workers", f"{cpu / half:.2f}", "≥ 1.8"
        yield "time alone over that on two workers, by the clock", f"{clock / clock_shared:.2f}", "≥ 1.8 idle"
        yield "processor time a machine and date", f"{cpu / (2 * MACHINES):.2f} s", ""

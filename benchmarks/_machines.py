"""Machine after machine, kept as they are ready: what was broken off goes on where it was."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Sequence
from concurrent.futures import Future, ProcessPoolExecutor, as_completed
from dataclasses import dataclass, field
from hashlib import sha256
from pathlib import Path
from time import monotonic
from typing import Any

import numpy as np

from benchmarks.reality.results import ROOMS, SOURCE
from fric.cli.console import progress
from fric.process import one_blas_thread
from fric.simulate.processes import default_workers

Job = Callable[..., dict[str, Any]]


@dataclass(frozen=True)
class Study:
    """How machines are run.

    Parameters
    ----------
    machines
        How many; None for as many as a benchmark takes by itself.
    seed
        What they are drawn with.
    folder
        Where is kept what they gave: one file a job, a line a machine.
    workers
        Processes.
    minutes
        No machine is begun after this time; what is there is taken then.
    any_version
        Take what older code gave too.
    """

    machines: int | None = None
    seed: int = 0
    folder: Path = Path("build/benchmarks")
    workers: int = field(default_factory=default_workers)
    minutes: float = float("inf")
    any_version: bool = False
    began: float = field(default_factory=monotonic)

    def number(self, own: int) -> int:
        """Return how many machines are run, where a benchmark by itself takes so many."""
        return own if self.machines is None else self.machines

    def run(self, job: Job, tasks: Sequence[tuple[Any, ...]]) -> Ran:
        """Run a job for each task that is not kept, and return what is there then, in the order of the tasks."""
        version, names = _version(job), [repr(task) for task in tasks]
        file = self.folder / f"{job.__module__.split('.')[-1].lstrip('_')}-{job.__name__}.jsonl"
        file.parent.mkdir(parents=True, exist_ok=True)
        lines = [json.loads(line) for line in file.read_text().splitlines()] if file.exists() else []
        known = {name: (made, found) for name, made, found in lines if self.any_version}
        known |= {name: (made, found) for name, made, found in lines if made == version}
        missing = [task for task in tasks if repr(task) not in known]
        with progress("machines") as advance, file.open("a") as kept:
            advance(0, total=len(missing))
            for task, found in self._all(job, missing):
                known[repr(task)] = (version, found)
                kept.write(json.dumps([repr(task), version, found]) + "\n")
                kept.flush()
                advance(1)
        there = [(task, *known[name]) for task, name in zip(tasks, names, strict=True) if name in known]
        older = sum(made != version for _, made, _ in there)
        return Ran([task for task, *_ in there], [found for *_, found in there], len(tasks), older)

    def _all(self, job: Job, tasks: Sequence[tuple[Any, ...]]) -> Any:
        if self.workers == 1:
            for task in tasks:
                if self._over():
                    return
                yield task, _job(job, task)
            return
        waiting = list(reversed(tasks))
        running: dict[Future[dict[str, Any]], tuple[Any, ...]] = {}
        with ProcessPoolExecutor(self.workers) as pool:
            while running or (waiting and not self._over()):
                while waiting and len(running) < self.workers and not self._over():
                    task = waiting.pop()
                    running[pool.submit(_job, job, task)] = task
                done = next(as_completed(running))
                yield running.pop(done), done.result()

    def _over(self) -> bool:
        return monotonic() - self.began > 60.0 * self.minutes


@dataclass(frozen=True)
class Ran:
    """What a study has: tasks and what they gave, how many were asked for, and how many older code gave."""

    tasks: list[tuple[Any, ...]]
    found: list[dict[str, Any]]
    asked: int
    older: int

    def row(self) -> tuple[str, str, str]:
        """Return the row that says how many there are."""
        older = f", {self.older} of them by an earlier version" if self.older else ""
        return "machines", f"{len(self.found)} of {self.asked}{older}", ""


def _version(job: Job) -> str:
    """Return a digest of what a job depends on: rooms of the library, machines, its own file."""
    files = sorted(file for room in (*ROOMS, "circles", "design", "records") for file in (SOURCE / room).rglob("*.py"))
    files += sorted(SOURCE.glob("*.py"))
    files += [*sorted((SOURCE.parents[1] / "configs").rglob("*.yaml")), Path(str(sys.modules[job.__module__].__file__))]
    return sha256(b"".join(file.read_bytes() for file in files)).hexdigest()[:12]


@one_blas_thread()
def _job(job: Job, task: tuple[Any, ...]) -> dict[str, Any]:
    return job(*task)


def spread_of(values: Sequence[float]) -> str:
    """Return median, 95th percentile and largest of glitches [m], in µm."""
    known = np.asarray(values, float) * 1e6
    return f"{np.median(known):.2f} / {np.percentile(known, 95):.2f} / {known.max():.2f}"

"""Machine after machine on all cores, kept as they are ready: what was broken off goes on where it was."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np

import fric
from fric.cli.console import progress
from fric.simulate.processes import default_workers
from fric.threads import one_blas_thread

KEPT = Path("build/benchmarks")


def run_on_machines(job: Callable[..., dict[str, Any]], tasks: Sequence[tuple[Any, ...]]) -> list[dict[str, Any]]:
    """Return what a job gives for each task, in their order; what is kept of the same sources is not run again."""
    sources = [*Path(fric.__file__).parent.rglob("*.py"), *Path("configs").rglob("*.yaml")]
    sources += Path(__file__).parent.glob("*.py")
    digest = sha256(b"".join(path.read_bytes() for path in sorted(sources))).hexdigest()[:12]
    kept = KEPT / f"{job.__module__.split('.')[-1]}-{job.__name__}-{digest}.jsonl"
    kept.parent.mkdir(parents=True, exist_ok=True)
    known = dict(json.loads(line) for line in kept.read_text().splitlines()) if kept.exists() else {}
    missing = [task for task in tasks if repr(task) not in known]
    with (
        ProcessPoolExecutor(default_workers()) as pool,
        kept.open("a") as file,
        progress("machines", total=len(missing)) as advance,
    ):
        running = {pool.submit(_job, job, task): task for task in missing}
        for done in as_completed(running):
            known[repr(running[done])] = done.result()
            file.write(json.dumps([repr(running[done]), done.result()]) + "\n")
            file.flush()
            advance(1)
    return [known[repr(task)] for task in tasks]


@one_blas_thread()
def _job(job: Callable[..., dict[str, Any]], task: tuple[Any, ...]) -> dict[str, Any]:
    return job(*task)


def spread_of(values: Sequence[float]) -> str:
    """Return median, 95th percentile and largest of glitches [m], in µm."""
    known = np.asarray(values, float) * 1e6
    return f"{np.median(known):.2f} / {np.percentile(known, 95):.2f} / {known.max():.2f}"

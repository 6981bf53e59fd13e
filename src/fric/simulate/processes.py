"""The circular test on many machines: how the glitch of each scheme is distributed, and which scheme is the best.

Each machine is drawn and run by its number alone (`fric.simulate.spread`), so that the same machines give the same
digits on one core, on all of them, and on a Dask cluster (the extra ``dask``).
"""

import multiprocessing
import os
import pickle
import signal
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass, field
from multiprocessing.connection import Connection, wait
from multiprocessing.context import BaseContext
from threading import Thread, current_thread, main_thread
from types import ModuleType
from typing import Any, TypeVar

import numpy as np

import fric
from fric.arrays import Mask, Real
from fric.control.scheme import Scheme
from fric.errors import FricError
from fric.estimate import Covariance
from fric.flaws.prediction import DRIVE_SATURATES, SCHEME_FAILED, SPREAD_UNUSED
from fric.notice import Notice
from fric.reference import MOST_BYTES
from fric.simulate.contour_run import Circle, run_circle
from fric.simulate.machine import Machine
from fric.simulate.spread import DEFAULT_SPREADS, Intervals, Spread, check_spreads, draw_machine
from fric.verb import require_within

T = TypeVar("T")
MACHINES_BY_START = 6  # Machines that one process runs, about, while others start
_STUDY: Callable[[int], Any]  # The study whose machines a worker process runs
QUANTILES = {"median": 0.5, "p05": 0.05, "p95": 0.95, "low": 0.025, "high": 0.975}  # Of the glitch, by keys in files
ACCURACY = 5e-9  # Largest error of a glitch by the integration of the plant [m], where machines differ by micrometres


def default_workers() -> int:
    """Return the number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _begin(study: Callable[[int], Any], stop: Connection) -> None:
    """Make a process a worker: it has the study, leaves Ctrl-C to its parent, and ends with it or ``stop``."""
    global _STUDY
    _STUDY = study
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    end_with_parent(stop)


def end_with_parent(*stops: Connection) -> None:
    """Let this process end with the process that started it, however that ends, or when one of ``stops`` closes."""
    parent = multiprocessing.parent_process()
    assert parent is not None
    Thread(target=lambda: (wait([parent.sentinel, *stops]), os._exit(1)), daemon=True).start()


def _run(index: int) -> Any:
    return _STUDY(index)


def _started() -> BaseContext:
    """Return how workers are started: from a server that has imported their modules, has no threads, and leaves Ctrl-C
    to the parent, as they do from their first moment; from nothing where there is none (Windows).
    """
    if "forkserver" not in multiprocessing.get_all_start_methods():
        return multiprocessing.get_context("spawn")
    from multiprocessing import forkserver

    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(["fric.simulate.processes"])
    if current_thread() is main_thread():
        before = signal.signal(signal.SIGINT, signal.SIG_IGN)
        try:
            forkserver.ensure_running()
        finally:
            signal.signal(signal.SIGINT, before)
    return context


@contextmanager
def _apart(study: object) -> Iterator[None]:
    """Let workers that are started here not import the script that called: it would run anew in each. Of a study that
    holds what the script defines they do, and it needs the usual guard ``if __name__ == "__main__":``.
    """
    script = sys.modules["__main__"]
    if b"__main__" not in pickle.dumps(study):
        sys.modules["__main__"] = ModuleType("__main__")
    try:
        yield
    finally:
        sys.modules["__main__"] = script


def run_all(
    study: Callable[[int], T], machines: int, *, workers: int | None = None, scheduler: str | None = None,
    memory: float = 0.0, advance: Callable[[], object] = lambda: None, interrupted: Callable[[], bool] = lambda: False,
) -> list[T]:  # fmt: skip
    """Return the outcomes of all machines in their order; of those that are done where it is interrupted.

    scheduler: Address of a Dask cluster that runs them instead, see `cluster_outcomes`.
    advance, interrupted: Called for each machine; called after each whether to stop.
    Others, and what is raised, as `outcomes` and `cluster_outcomes`.
    """
    if scheduler:
        opened = cluster_outcomes(study, machines, scheduler)
    else:
        opened = outcomes(study, machines, workers=workers, memory=memory)
    done = []
    with opened as found:
        for outcome in found:
            done.append(outcome)
            advance()
            if interrupted():
                break
    return done


@contextmanager
def outcomes(
    study: Callable[[int], T], machines: int, *, workers: int | None = None, memory: float = 0.0
) -> Iterator[Iterator[T]]:
    """Give the outcomes of machines 0, 1, 2, … in their order, as soon as they are ready.

    The machines are shared out among processes, see `_apart`. When the block ends early, machines that were not begun
    are left out; an error in the block, or Ctrl-C, also ends those that are running.

    workers: Processes, 1 for this process alone. Where not given, one a core; this process alone for few machines,
        which it runs before others have started.
    memory: Memory of a machine at most [byte]: there are as many processes as fit in `MOST_BYTES` together.
    """
    if workers is None:
        workers = min(default_workers(), machines // MACHINES_BY_START) or 1
    if memory:
        workers = min(workers, max(1, int(MOST_BYTES // memory)))
    if (workers := min(workers, machines)) == 1:
        yield map(study, range(machines))
        return
    context = _started()
    watched, stop = context.Pipe(duplex=False)
    with _apart(study):
        pool = ProcessPoolExecutor(workers, context, _begin, (study, watched))
        found = pool.map(_run, range(machines))  # starts all workers
    try:
        yield _unbroken(found)
    except BaseException:
        stop.close()  # which ends the workers at once
        raise
    finally:
        pool.shutdown(cancel_futures=True)


def _unbroken(found: Iterator[T]) -> Iterator[T]:
    try:
        yield from found
    except BrokenProcessPool:
        hint = "Was there memory enough? Try fewer workers."
        raise FricError("a process that ran machines was killed", hint=hint) from None


def _version() -> str:
    return fric.__version__


@contextmanager
def cluster_outcomes(
    study: Callable[[int], T], machines: int, address: str, *, timeout: float = 15.0
) -> Iterator[Iterator[T]]:
    """Give the outcomes of machines 0, 1, 2, … in their order, run by the workers of a Dask cluster.

    The work is that of `outcomes`, machine by machine. When the block ends early, machines that were not begun are left
    out.

    timeout: How long to wait for the scheduler, and for its first worker [s].
    """
    try:
        import distributed
    except ImportError:
        why = "a Dask cluster needs distributed, which is not installed"
        raise FricError(why, hint="pip install 'fric[dask]'") from None
    try:
        client: Any = distributed.Client(address, timeout=timeout, set_as_default=False)
    except (OSError, ValueError) as error:
        hint = "Start one with `dask scheduler`, and give the address that it prints, as tcp://host:8786."
        raise FricError(f"the Dask scheduler at {address} does not answer ({error})", hint=hint) from None
    with client:
        _require_workers(client, address, timeout)
        futures = client.map(study, range(machines), pure=False)
        try:
            yield (future.result() for future in futures)
        finally:
            client.cancel(futures)


def _require_workers(client: Any, address: str, timeout: float) -> None:
    hint = f"Start them with `dask worker {address}` in an environment with fric {fric.__version__}."
    try:
        client.wait_for_workers(1, timeout=timeout)
        versions = client.run(_version)
    except TimeoutError:
        raise FricError(f"the Dask scheduler at {address} has no workers", hint=hint) from None
    except ImportError:
        raise FricError(f"a worker of the Dask scheduler at {address} has no fric", hint=hint) from None
    if other := set(versions.values()) - {fric.__version__}:
        raise FricError(f"a worker of the Dask scheduler at {address} has fric {', '.join(sorted(other))}", hint=hint)


@dataclass(frozen=True)
class Study:
    """What is run on each of many machines."""

    machine: Machine  # The nominal machine
    schemes: tuple[Scheme, ...]  # The compensation schemes
    circle: Circle = field(default_factory=Circle)  # The test
    seed: int = 0  # Seed of the machines
    spreads: Mapping[str, Spread] = field(default_factory=lambda: DEFAULT_SPREADS)  # What is drawn: see `draw_machine`
    intervals: Mapping[str, Intervals] = field(default_factory=dict)
    covariances: Mapping[str, Sequence[Covariance]] = field(default_factory=dict)
    discrepancies: Mapping[str, Mapping[str, Spread]] = field(default_factory=dict)
    completion: Callable[[Machine, int], Machine] | None = None  # Makes it agree with circles (`fric.circles.tune`)
    only: str | None = None  # Name of the one axis that is simulated
    accuracy: float = ACCURACY  # Largest error of a glitch by the integration of the plant [m]; 0 for the last digits

    def __post_init__(self) -> None:
        check_spreads(self.spreads)
        require_within(self, "the integration", accuracy="[0, inf]")

    def drawn(self, index: int) -> tuple[Machine, dict[str, float]]:
        """Return machine number ``index``, and what was drawn for it."""
        names = ("seed", "spreads", "intervals", "covariances", "discrepancies")
        machine, drawn = draw_machine(self.machine, index, **{name: getattr(self, name) for name in names})
        return (machine if self.completion is None else self.completion(machine, index)), drawn

    def __call__(self, index: int) -> "Outcome":
        """Run all schemes on machine number ``index``; a scheme that cannot run has no glitch, but a reason."""
        count = len(self.schemes)
        quadrants, swings, saturated = np.full((count, 4), np.nan), np.full(count, np.nan), np.zeros(count, bool)
        failures, drawn, machine = dict[str, str](), dict[str, float](), None
        for n, scheme in enumerate(self.schemes):
            try:
                if machine is None:
                    machine, drawn = self.drawn(index)
                run = run_circle(machine, scheme, self.circle, only=self.only, accuracy=self.accuracy, places=1)
            except FricError as error:
                failures[scheme.name] = error.what
                continue
            quadrants[n] = run.circularity.quadrants
            swings[n] = run.circularity.oscillation
            saturated[n] = any(trace.saturated for trace in run.traces.values())
        return Outcome(index, drawn, quadrants, saturated, swings, failures)


@dataclass(frozen=True)
class Outcome:
    """Results of the schemes on one of the machines."""

    index: int  # Number of the machine
    drawn: Mapping[str, float]  # What was drawn, by ``AXIS.NAME``: factors of spreads [1], values of intervals [SI]
    quadrants: Real  # Glitch per scheme at +x, +y, -x and -y [m], shape (schemes, 4); nan where it could not run
    saturated: Mask  # Whether the drive saturated, shape (schemes,)
    swings: Real  # What swings where no axis reverses [m], shape (schemes,); nan where the scheme could not run
    failures: Mapping[str, str]  # Why a scheme could not run, by its name: a loop that is not stable on this machine


@dataclass(frozen=True)
class Distribution:
    """How the glitch of one scheme is distributed over the machines."""

    quantiles: Mapping[str, float]  # Glitch [m] by the names of `QUANTILES`; nan where the scheme ran on no machine
    best: float  # Share of the machines on which no other scheme leaves less [1]; equal schemes share a machine
    failed: int  # Machines on which the scheme could not run
    saturated: int  # Machines on which the drive saturated


@dataclass(frozen=True)
class MonteCarlo:
    """Outcomes of a study."""

    study: Study  # What was run
    asked: int  # Requested number of machines
    outcomes: tuple[Outcome, ...]  # Of machines 0, 1, 2, …; fewer than requested where it was interrupted

    def __len__(self) -> int:
        return len(self.outcomes)

    @property
    def quadrants(self) -> Real:
        """Signed glitches [m], shape (machines, schemes, 4)."""
        return np.array([outcome.quadrants for outcome in self.outcomes])

    @property
    def swings(self) -> Real:
        """What swings where no axis reverses [m], shape (machines, schemes); nan where a scheme could not run."""
        return np.array([outcome.swings for outcome in self.outcomes])

    @property
    def glitches(self) -> Real:
        """Glitch of each machine and scheme [m], shape (machines, schemes); nan where a scheme could not run."""
        return np.asarray(np.abs(self.quadrants).max(axis=2))

    def distributions(self) -> dict[str, Distribution]:
        """Return the distribution of the glitch by scheme."""
        glitches = self.glitches
        least = np.where(np.isnan(glitches), np.inf, glitches)
        winners = (least == least.min(axis=1, keepdims=True)) & np.isfinite(least)
        shares = winners / np.maximum(winners.sum(axis=1, keepdims=True), 1)
        saturated = np.array([outcome.saturated for outcome in self.outcomes]).sum(axis=0)
        found = {}
        for n, scheme in enumerate(self.study.schemes):
            ran = glitches[np.isfinite(glitches[:, n]), n]
            quantiles = {name: float(np.quantile(ran, at)) if len(ran) else np.nan for name, at in QUANTILES.items()}
            best = float(shares[:, n].mean())
            found[scheme.name] = Distribution(quantiles, best, len(glitches) - len(ran), int(saturated[n]))
        return found

    def warnings(self) -> tuple[Notice, ...]:
        """Return the warnings: machines that could not run, drives that saturate, spreads without use."""
        warnings = []
        for name, found in self.distributions().items():
            if found.failed:
                why = next(outcome.failures[name] for outcome in self.outcomes if name in outcome.failures)
                counts = {"failed": found.failed, "runs": len(self), "of": "machines"}
                warnings.append(SCHEME_FAILED.found(f"scheme {name}", **counts, why=why))
            if found.saturated:
                counts = {"saturated": found.saturated, "machines": len(self)}
                warnings.append(DRIVE_SATURATES.found(f"scheme {name}", **counts))
        spreads = self.study.spreads
        ran = [outcome for outcome in self.outcomes if len(outcome.failures) < len(self.study.schemes)]
        if ran and spreads is not DEFAULT_SPREADS:  # which were not asked for
            drawn = {key.partition(".")[2] for outcome in ran for key in outcome.drawn}
            warnings += [SPREAD_UNUSED.found(name=name) for name in spreads if name not in drawn]
        return tuple(warnings)

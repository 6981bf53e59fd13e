"""The machines of a study on the cores of this computer, or on a Dask cluster (the extra ``dask``)."""

import multiprocessing
import os
import signal
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing.connection import wait
from multiprocessing.context import BaseContext
from threading import Thread, current_thread, main_thread
from typing import Any, TypeVar

import fric
from fric.errors import FricError

T = TypeVar("T")

MACHINES_BY_START = 6  # Machines that one process runs, about, while others start


def default_workers() -> int:
    """Return the number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


_STUDY: Callable[[int], Any]  # The study whose machines a worker process runs


def _begin(study: Callable[[int], Any]) -> None:
    """Make a process a worker: it has the study, leaves Ctrl-C to its parent, and ends with it."""
    global _STUDY
    _STUDY = study
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    end_with_parent()


def end_with_parent() -> None:
    """Let this process end with the process that started it, however that ends."""
    parent = multiprocessing.parent_process()
    assert parent is not None
    Thread(target=lambda: (wait([parent.sentinel]), os._exit(1)), daemon=True).start()


def _run(index: int) -> Any:
    return _STUDY(index)


def _started() -> BaseContext:
    """Return how workers are started: from a server that has imported their modules, and has no threads.

    The server, and so each worker from its first moment on, leaves Ctrl-C to the parent. Where there is none (Windows),
    each worker starts from nothing.
    """
    if "forkserver" not in multiprocessing.get_all_start_methods():
        return multiprocessing.get_context("spawn")
    from multiprocessing import forkserver

    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(["fric.simulate.monte_carlo"])
    if current_thread() is main_thread():
        before = signal.signal(signal.SIGINT, signal.SIG_IGN)
        try:
            forkserver.ensure_running()
        finally:
            signal.signal(signal.SIGINT, before)
    return context


def run_all(
    study: Callable[[int], T],
    machines: int,
    *,
    workers: int | None = None,
    scheduler: str | None = None,
    advance: Callable[[], object] = lambda: None,
    interrupted: Callable[[], bool] = lambda: False,
) -> list[T]:
    """Return the outcomes of all machines in their order; of those that are done where it is interrupted.

    scheduler: Address of a Dask cluster that runs them instead, see `cluster_outcomes`.
    advance, interrupted: Called for each machine; called after each whether to stop.
    Others, and what is raised, as `outcomes` and `cluster_outcomes`.
    """
    opened = cluster_outcomes(study, machines, scheduler) if scheduler else outcomes(study, machines, workers=workers)
    done = []
    with opened as found:
        for outcome in found:
            done.append(outcome)
            advance()
            if interrupted():
                break
    return done


@contextmanager
def outcomes(study: Callable[[int], T], machines: int, *, workers: int | None = None) -> Iterator[Iterator[T]]:
    """Give the outcomes of machines 0, 1, 2, … in their order, as soon as they are ready.

    The machines are shared out among processes. Each imports the script that called, which so needs the usual guard
    ``if __name__ == "__main__":``. When the block ends early, machines that were not begun are left out.

    workers: Processes, 1 for this process alone. Where not given, one a core; this process alone for few machines,
        which it runs before others have started.
    Raises FricError: When a process was killed.
    """
    if workers is None:
        workers = min(default_workers(), machines // MACHINES_BY_START) or 1
    if (workers := min(workers, machines)) == 1:
        yield map(study, range(machines))
        return
    pool = ProcessPoolExecutor(workers, _started(), _begin, (study,))
    try:
        yield _unbroken(pool.map(_run, range(machines)))
    finally:
        pool.shutdown(cancel_futures=True)


def _unbroken(found: Iterator[T]) -> Iterator[T]:
    try:
        yield from found
    except BrokenProcessPool:
        raise FricError(
            "a process that ran machines was killed", hint="Was there memory enough? Try fewer workers."
        ) from None


def _version() -> str:
    return fric.__version__


@contextmanager
def cluster_outcomes(
    study: Callable[[int], T], machines: int, address: str, *, timeout: float = 15.0
) -> Iterator[Iterator[T]]:
    """Give the outcomes of machines 0, 1, 2, … in their order, run by the workers of a Dask cluster.

    The work is that of `outcomes`, machine by machine. When the block ends early, machines that were not begun are left
    out.

    address: Address of the scheduler, as ``tcp://host:8786``.
    timeout: How long to wait for the scheduler, and for its first worker [s].
    Raises FricError: When Dask is not installed, the scheduler does not answer, or its workers have no fric of this
        version.
    """
    try:
        import distributed
    except ImportError:
        why = "a Dask cluster needs distributed, which is not installed"
        raise FricError(why, hint="pip install 'fric[dask]'") from None
    try:
        client: Any = distributed.Client(address, timeout=timeout, set_as_default=False)
    except (OSError, ValueError) as error:
        raise FricError(
            f"the Dask scheduler at {address} does not answer ({error})",
            hint="Start one with `dask scheduler`, and give the address that it prints, as tcp://host:8786.",
        ) from None
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

"""The machines of a study on a Dask cluster (the extra ``dask``)."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, TypeVar

import fric
from fric.errors import FricError

T = TypeVar("T")


def _version() -> str:
    return fric.__version__


@contextmanager
def cluster_outcomes(
    study: Callable[[int], T], machines: int, address: str, *, timeout: float = 15.0
) -> Iterator[Iterator[T]]:
    """Give the outcomes of machines 0, 1, 2, … in their order, run by the workers of a Dask cluster.

    The work is that of `fric.simulate.monte_carlo.outcomes`, machine by machine. When the block ends early, machines
    that were not begun are left out.

    Parameters
    ----------
    study
        What is run on each machine.
    machines
        How many.
    address
        Address of the scheduler, as ``tcp://host:8786``.
    timeout
        How long to wait for the scheduler, and for its first worker [s].

    Raises
    ------
    FricError
        When Dask is not installed, the scheduler does not answer, or its workers have no fric of this version.
    """
    try:
        import distributed
    except ImportError:
        raise FricError(
            "a Dask cluster needs distributed, which is not installed", hint="pip install 'fric[dask]'"
        ) from None
    if machines < 1:
        raise FricError(f"{machines} machines are none to work with", hint="Give 1 or more.")
    try:
        client: Any = distributed.Client(address, timeout=timeout, set_as_default=False)  # type: ignore[no-untyped-call]
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

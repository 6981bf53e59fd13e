"""Progress of a long fit: each replay of a model calls the listener."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar

_LISTENER: ContextVar[Callable[[], object] | None] = ContextVar("listener", default=None)


def tried() -> None:
    """Report to the listener that a fit tried a further set of parameters."""
    if (listener := _LISTENER.get()) is not None:
        listener()


@contextmanager
def heard(listener: Callable[[], object]) -> Iterator[None]:
    """Call a function whenever a fit in this block tries a set of parameters."""
    before = _LISTENER.set(listener)
    try:
        yield
    finally:
        _LISTENER.reset(before)

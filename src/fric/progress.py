"""Progress of a long fit: each replay of a model calls the listener."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar

_LISTENER: ContextVar[Callable[[str], object] | None] = ContextVar("listener", default=None)


def tried(step: str = "") -> None:
    """Report to the listener that a fit tried a further set of parameters, or that a step of this name begins."""
    if (listener := _LISTENER.get()) is not None:
        listener(step)


@contextmanager
def heard(listener: Callable[[str], object]) -> Iterator[None]:
    """Call a function whenever a fit in this block tries a set of parameters, or a step begins: with its name."""
    before = _LISTENER.set(listener)
    try:
        yield
    finally:
        _LISTENER.reset(before)

"""What a process has once: threads of its linear algebra, the listener to its progress, a process beside it."""

import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from contextvars import ContextVar
from datetime import UTC, datetime
from functools import cache
from typing import TYPE_CHECKING, TypeVar

from fric.errors import FricError

if TYPE_CHECKING:
    from threadpoolctl import ThreadpoolController

T = TypeVar("T")
_WATCHED = """
import os, signal, sys, threading, time
def end():
    os.read(0, 1)  # until the other end is closed
    os.kill(os.getpid(), signal.SIGTERM)
    time.sleep(2.0)
    os._exit(1)
if os.name != 'nt':  # where a thread that waits for input holds up each library that looks at it
    threading.Thread(target=end, daemon=True).start()
"""
_LISTENER: ContextVar[Callable[[str], object] | None] = ContextVar("listener", default=None)


@cache
def _controller() -> "ThreadpoolController":
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController()


@contextmanager
def one_blas_thread() -> Iterator[None]:
    """Keep BLAS to one thread, in a ``with`` block or as a decorator.

    For the matrices of a loop, of ten rows, and for the product of two vectors BLAS wakes a thread a core. Each then
    spins for milliseconds beside what comes next, or takes the core from another process that runs machines.
    """
    with _controller().limit(limits=1, user_api="blas"):
        yield


def tried(step: str = "") -> None:
    """Report to the listener that a further set of parameters or run is tried, or that a step of this name begins."""
    if (listener := _LISTENER.get()) is not None:
        listener(step)


def now() -> datetime:
    """Return the time, or that of ``SOURCE_DATE_EPOCH``, which asks for the same output again."""
    asked = os.environ.get("SOURCE_DATE_EPOCH")
    try:
        return datetime.fromtimestamp(int(asked), UTC) if asked else datetime.now(UTC)
    except (ValueError, OverflowError, OSError):
        hint = "Unset it, or give seconds since 1970."
        raise FricError(f"SOURCE_DATE_EPOCH is '{asked}', which is no time", hint=hint) from None


@contextmanager
def holding(variable: ContextVar[T], value: T) -> Iterator[None]:
    """Let a variable hold a value within the block."""
    before = variable.set(value)
    try:
        yield
    finally:
        variable.reset(before)


def heard(listener: Callable[[str], object]) -> AbstractContextManager[None]:
    """Call a function whenever this block tries a set of parameters or a run, or a step begins: with its name."""
    return holding(_LISTENER, listener)


def run_python(code: str, *words: str) -> subprocess.CompletedProcess[bytes]:
    """Run code in a separate process, which is terminated when this process ends; return its result."""
    reading, writing = os.pipe()
    try:
        command = [sys.executable, "-P", "-c", _WATCHED + code, *words]
        return subprocess.run(command, stdin=reading, capture_output=True, check=False)
    finally:
        os.close(reading)
        os.close(writing)

"""One thread for the linear algebra of small matrices and long vectors."""

from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from threadpoolctl import ThreadpoolController


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

"""What commands print: tables and words for people through Rich, JSON for programs, warnings on standard error."""

from __future__ import annotations

import json
import signal
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import cached_property
from types import FrameType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rich.console import Console

# Rich is imported where it is first needed: `fric --help` prints nothing through it, and it costs 50 ms.


class Stream:
    """Standard output or standard error, written through Rich.

    Parameters
    ----------
    stderr
        True for standard error.
    """

    def __init__(self, *, stderr: bool) -> None:
        self._stderr = stderr

    @cached_property
    def console(self) -> Console:
        """Rich's console; a file takes lines of any length."""
        from rich.console import Console

        wide = self._stderr or sys.stdout.isatty()
        return Console(stderr=self._stderr, highlight=False, soft_wrap=True, width=None if wide else 1000)

    def print(self, *things: Any, markup: bool = True) -> None:
        """Print as Rich does, with its markup or without."""
        self.console.print(*things, markup=markup)


OUT, ERR = Stream(stderr=False), Stream(stderr=True)


def print_json(document: Mapping[str, Any]) -> None:
    """Print one JSON object on standard output."""
    sys.stdout.write(json.dumps(document, ensure_ascii=False, indent=2, allow_nan=False) + "\n")


def print_table(columns: Sequence[str], rows: Iterable[Sequence[str]], title: str | None = None) -> None:
    """Print a table: the first column to the left, numbers to the right."""
    from rich.table import Table

    table = Table(title=title, title_justify="left", box=None, pad_edge=False, header_style="bold")
    for n, column in enumerate(columns):
        table.add_column(column, justify="left" if n == 0 else "right")
    for row in rows:
        table.add_row(*row)
    OUT.print(table)


def print_warnings(warnings: Iterable[str]) -> None:
    """Print each warning on standard error."""
    for warning in warnings:
        ERR.print(f"[bold yellow]warning:[/] {warning}")


@contextmanager
def progress(description: str, total: int | None = None) -> Iterator[Any]:
    """Show a progress bar on standard error, silent when that is no terminal; gives a function to advance it."""
    if not sys.stderr.isatty():
        yield lambda steps=1: None
        return
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*columns, console=ERR.console, transient=True) as bar:
        task = bar.add_task(description, total=total)

        def advance(steps: int = 1) -> None:
            bar.advance(task, steps)

        yield advance


@contextmanager
def interruption() -> Iterator[Callable[[], bool]]:
    """Let the first Ctrl-C, or polite kill, be asked for instead of raised; the second one is raised as ever.

    An exception out of nowhere would leave locks held that other threads wait for.
    """
    caught: list[int] = []
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}

    def catch(number: int, frame: FrameType | None) -> None:
        caught.append(number)
        for own, handler in before.items():
            signal.signal(own, handler)

    for number in before:
        signal.signal(number, catch)
    try:
        yield lambda: bool(caught)
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)

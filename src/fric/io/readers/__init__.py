"""Readers of foreign log files, one format a file.

A reader is a module of this package with two functions: ``recognises(path, head) -> bool`` looks at the first bytes,
and ``tables(path, layout) -> Iterator[Table]`` reads the file. A new module is found by itself.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from importlib import import_module
from pathlib import Path
from pkgutil import iter_modules
from typing import Any

from fric.documents.bundled import missing
from fric.documents.mapping import Layout
from fric.errors import FricError
from fric.io.readers.base import Table

HEAD = 4096


@cache
def _readers() -> tuple[Any, ...]:
    modules = (import_module(f"{__name__}.{module.name}") for module in iter_modules(__path__))
    return tuple(module for module in modules if hasattr(module, "recognises"))


def tables(path: Path, layout: Layout | None = None) -> Iterator[Table]:
    """Read a foreign log file by the reader that recognises it, table by table.

    Raises
    ------
    FricError
        When there is no such file, it is empty, cannot be read, or is of no known format.
    """
    try:
        with path.open("rb") as file:
            head = file.read(HEAD)
    except FileNotFoundError:
        raise missing(path) from None
    except IsADirectoryError:
        raise FricError("is a folder", where=str(path), mend=f"Name the files in it, as in {path}/*.csv.") from None
    except OSError as error:
        raise FricError(f"cannot be read: {error.strerror}", where=str(path)) from None
    if not head.strip():
        raise FricError("is empty", where=str(path), mend="Export the log again.")
    for reader in _readers():
        if reader.recognises(path, head):
            yield from reader.tables(path, layout or Layout())
            return
    raise FricError(
        "is of no format that is known",
        where=str(path),
        mend="Text (also .gz), MATLAB .mat, Parquet and fric's own HDF5 are read; export it as CSV.",
    )

"""Readers of foreign log files, one format a file.

A reader is a module of this package with a ``FORMAT`` and two functions: ``recognises(path, head) -> float`` returns
from the first bytes how likely the file is of its format, and ``tables(path, layout) -> Iterator[Table]`` reads the
file. 1 is a mark that no other format has, 0.5 the ending of the name, 0.1 text of any kind, 0 that it is not. The
reader with the highest value is taken; a new module is found automatically.
"""

from collections.abc import Generator
from contextlib import suppress
from functools import cache
from importlib import import_module
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from pkgutil import iter_modules
from typing import Any

from fric.documents.mapping import Layout
from fric.errors import FricError
from fric.input import reading
from fric.io.readers.base import ForeignTable, Format, guarded

HEAD = 4096


@cache
def _readers() -> tuple[Any, ...]:
    modules = (import_module(f"{__name__}.{module.name}") for module in iter_modules(__path__))
    return tuple(module for module in modules if hasattr(module, "recognises"))


def formats() -> list[Format]:
    """Return the formats that are read, by name."""
    found = [reader.FORMAT for reader in _readers() if hasattr(reader, "FORMAT")]
    return sorted(found, key=lambda form: form.name.casefold())


def installed(form: Format) -> str | None:
    """Return the version of the library that a format needs; nothing where it needs none, None where it lacks."""
    with suppress(PackageNotFoundError):
        return version(form.module.partition(".")[0]) if form.module else ""
    return None


def endings() -> frozenset[str]:
    """Return the suffixes of foreign logs; a log file of fric has none of them."""
    return frozenset(ending for form in formats() for ending in form.endings) - {".h5"}


def marked(path: Path) -> bool:
    """Return whether the content of a file, and not its name alone, is of a format that is read."""
    with suppress(FricError):
        return _surest(path)[0] > 0.5
    return False


def _surest(path: Path) -> tuple[float, Any]:
    """Return how sure the surest reader of a file is, and the reader."""
    with reading(path, of_folder=f"Name the files in it, as in {path}/*.csv.") as file:
        head = file.read(HEAD)
    if not head.strip():
        raise FricError("the file is empty", where=str(path), hint="Export the log again.")
    return max(((float(reader.recognises(path, head)), reader) for reader in _readers()), key=lambda found: found[0])


def tables(path: Path, layout: Layout | None = None) -> Generator[ForeignTable, None, None]:
    """Read a foreign log file by the reader that recognises it, table by table."""
    sure, reader = _surest(path)
    if not sure > 0:
        hint = "`fric ingest --list` lists the formats that are read; export it as CSV."
        raise FricError("its format is not known", where=str(path), hint=hint)
    yield from guarded(path, iter(reader.tables(path, layout or Layout())))

"""What grows by a file: a room is imported file by file for what they hold, as classes that state a name."""

from functools import cache
from importlib import import_module
from pkgutil import iter_modules
from types import ModuleType
from typing import Any


@cache
def files_of(room: str, name: str = "") -> tuple[ModuleType, ...]:
    """Import the files of a room, or the file of a name alone if there is one, and return them."""
    files = (module.name for module in iter_modules(import_module(room).__path__))
    return tuple(import_module(f"{room}.{file}") for file in files if name in {"", file})


def named(base: Any, key: str = "name") -> dict[str, Any]:
    """Return the imported subclasses of a class that state a name, by that name."""
    found, pending = dict[str, Any](), [base]
    while pending:
        kind = pending.pop()
        pending += kind.__subclasses__()
        if isinstance(name := vars(kind).get(key), str):
            found[name] = kind
    return dict(sorted(found.items()))

"""Control blocks, one a file, and schemes made of them. `blocks` finds them: a new block is one new file here."""

from functools import cache
from importlib import import_module
from pkgutil import iter_modules

from fric.control.base import ControlBlock, Setting
from fric.errors import require_known

__all__ = ["ControlBlock", "Setting", "block_type", "blocks"]


@cache
def blocks() -> dict[str, type[ControlBlock]]:
    """Return every control block of this package by its name, as written in machine and schemes files."""
    for module in iter_modules(__path__):
        import_module(f"{__name__}.{module.name}")
    return dict(sorted(_loaded().items()))


def _loaded() -> dict[str, type[ControlBlock]]:
    found: dict[str, type[ControlBlock]] = {}
    pending: list[type[ControlBlock]] = list(ControlBlock.__subclasses__())
    while pending:
        block = pending.pop()
        pending += block.__subclasses__()
        if "name" in vars(block):
            found[block.name] = block
    return found


@cache
def block_type(name: str) -> type[ControlBlock]:
    """Return the control block of a name, which its file has too: of the others none is loaded.

    Raises FricError: When there is none: with those there are.
    """
    file = name.replace("-", "_")
    if any(module.name == file for module in iter_modules(__path__)):
        import_module(f"{__name__}.{file}")
    if name not in (found := _loaded()):
        found = blocks()
    require_known(name, found, "there is no control block")
    return found[name]

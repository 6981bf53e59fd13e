"""Control blocks, one a file, and schemes made of them. `blocks` finds them: a new block is one new file here."""

from functools import cache

from fric.control.base import ControlBlock, Setting
from fric.errors import require_known
from fric.family import files_of, named

__all__ = ["ControlBlock", "Setting", "block_type", "blocks"]


@cache
def blocks() -> dict[str, type[ControlBlock]]:
    """Return every control block of this package by its name, as written in machine and schemes files."""
    files_of(__name__)
    return named(ControlBlock)


@cache
def block_type(name: str) -> type[ControlBlock]:
    """Return the control block of a name, which its file has too: of the others none is loaded."""
    files_of(__name__, name.replace("-", "_"))
    found: type[ControlBlock] | None = named(ControlBlock).get(name)
    if found is None:
        require_known(name, blocks(), "there is no control block")
    return found or blocks()[name]

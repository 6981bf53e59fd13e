"""Export of compensation and machines to the languages of controllers, one target a file."""

from functools import cache

from fric.export.base import Target
from fric.family import files_of

__all__ = ["Target", "targets"]


@cache
def targets() -> dict[str, Target]:
    """Return every target of this package by its name: each `Target` that a module of it makes."""
    found = (item for module in files_of(__name__) for item in vars(module).values() if isinstance(item, Target))
    return {target.name: target for target in sorted(found, key=lambda target: target.name)}

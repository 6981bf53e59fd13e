"""What a controller runs: compensation and machines in the languages of controllers, one target a file."""

from functools import cache
from importlib import import_module
from pkgutil import iter_modules

from fric.export.base import Target

__all__ = ["Target", "targets"]


@cache
def targets() -> dict[str, Target]:
    """Return every target of this package by its name: a module that has a ``TARGET``."""
    found = {}
    for module in iter_modules(__path__):
        made = getattr(import_module(f"{__name__}.{module.name}"), "TARGET", None)
        if isinstance(made, Target):
            found[made.name] = made
    return dict(sorted(found.items()))

"""Export of compensation and machines to the languages of controllers, one target a file."""

from functools import cache
from importlib import import_module
from pkgutil import iter_modules

from fric.export.base import Target

__all__ = ["Target", "targets"]


@cache
def targets() -> dict[str, Target]:
    """Return every target of this package by its name: each `Target` that a module of it makes."""
    modules = (import_module(f"{__name__}.{module.name}") for module in iter_modules(__path__))
    found = {
        target.name: target for module in modules for target in vars(module).values() if isinstance(target, Target)
    }
    return dict(sorted(found.items()))

"""Friction models, one a file. `MODELS` finds them: a new model is one new file in this package."""

from __future__ import annotations

from functools import cache
from importlib import import_module
from pkgutil import iter_modules

from fric.friction.base import FrictionModel, Parameter

__all__ = ["FrictionModel", "Parameter", "models"]


@cache
def models() -> dict[str, type[FrictionModel]]:
    """Return every friction model of this package by its name, as written in friction files."""
    for module in iter_modules(__path__):
        import_module(f"{__name__}.{module.name}")
    found: dict[str, type[FrictionModel]] = {}
    pending: list[type[FrictionModel]] = list(FrictionModel.__subclasses__())
    while pending:
        model = pending.pop()
        pending += model.__subclasses__()
        if isinstance(vars(model).get("name"), str):
            found[model.name] = model
    return dict(sorted(found.items()))

"""Friction models, one a file. `MODELS` finds them: a new model is one new file in this package."""

from functools import cache
from importlib import import_module
from pkgutil import iter_modules

from fric.friction.base import FrictionModel, Parameter

__all__ = ["FrictionModel", "Parameter", "model_type", "models"]


@cache
def models() -> dict[str, type[FrictionModel]]:
    """Return every friction model of this package by its name, as written in friction files."""
    for module in iter_modules(__path__):
        import_module(f"{__name__}.{module.name}")
    return _imported()


@cache
def model_type(name: str) -> type[FrictionModel] | None:
    """Return a friction model by its name, None where there is none; only its file is imported."""
    if name in {module.name for module in iter_modules(__path__)}:
        import_module(f"{__name__}.{name}")
    return _imported().get(name) or models().get(name)


def _imported() -> dict[str, type[FrictionModel]]:
    found: dict[str, type[FrictionModel]] = {}
    pending: list[type[FrictionModel]] = list(FrictionModel.__subclasses__())
    while pending:
        model = pending.pop()
        pending += model.__subclasses__()
        if isinstance(vars(model).get("name"), str):
            found[model.name] = model
    return dict(sorted(found.items()))

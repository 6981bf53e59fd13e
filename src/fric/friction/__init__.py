"""Friction models, one a file. `MODELS` finds them: a new model is one new file in this package."""

from functools import cache

from fric.family import files_of, named
from fric.friction.base import FrictionModel, Parameter

__all__ = ["FrictionModel", "Parameter", "model_type", "models"]


@cache
def models() -> dict[str, type[FrictionModel]]:
    """Return every friction model of this package by its name, as written in friction files."""
    files_of(__name__)
    return named(FrictionModel)


@cache
def model_type(name: str) -> type[FrictionModel] | None:
    """Return a friction model by its name, None where there is none; only its file is imported."""
    files_of(__name__, name)
    return named(FrictionModel).get(name) or models().get(name)

"""What fields of schemas are made of: sources, descriptions, defaults, and types that several share."""

from collections.abc import Callable, Container, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from math import isfinite
from operator import attrgetter
from typing import Annotated, Any

from pydantic import AfterValidator, BaseModel, BeforeValidator, Field

from fric.errors import FricError, require_name
from fric.estimate import Estimate

Known = Annotated[  # A number, or null for an infinite value or NaN, which JSON cannot hold
    float | None, BeforeValidator(lambda given: None if isinstance(given, float) and not isfinite(given) else given)
]


class SchemaError(FricError, ValueError):
    """An error of the schema, which pydantic collects; of the user where a document that was read is used."""


@contextmanager
def refused(place: str = "") -> Iterator[None]:
    """Turn a `FricError` within the block into an error of the schema, with place and remedy."""
    try:
        yield
    except FricError as error:
        raise SchemaError(error.what, where=place, hint=error.hint) from None


AxisName = Annotated[str, AfterValidator(refused()(require_name))]


@dataclass(frozen=True)
class Of:
    """Source of a key of a written document in the object that the document is made of."""

    read: Callable[[Any], Any]
    unit: str = ""  # Of a number, which becomes a quantity


def of(
    source: str | Callable[[Any], Any], says: str | None = None, default: Any = ..., *, unit: str = "",
    alias: str | None = None,
) -> Any:  # fmt: skip
    """Return a field of a schema with its source, an attribute by its dotted name or a function, and its description.

    A key with a default is left out if its value is None, or the object has no such attribute; of others None is null.
    """
    field: Any = Field(default, description=says, alias=alias)
    field.metadata.append(Of(attrgetter(source) if isinstance(source, str) else source, unit))
    return field


def said(says: str, default: Any = None) -> Any:
    """Return a field of a schema that may be left out, with its description; `list` and `dict` make a new default."""
    field: Any = Field
    return field(**{"default_factory" if isinstance(default, type) else "default": default}, description=says)


def read_off(kind: type[BaseModel], holder: Any, but: Container[str] = ()) -> dict[str, Any]:
    """Return the values of a schema from an object, by key: as `of` states, or of the attribute of the key's name."""
    found = {}
    for name, field in kind.model_fields.items():
        if name in but:
            continue
        how = next((mark for mark in field.metadata if isinstance(mark, Of)), None) or Of(attrgetter(name))
        try:
            value = how.read(holder)
        except AttributeError:
            if field.is_required():
                raise
            continue
        if value is not None or field.is_required():
            found[field.alias or name] = Estimate(value, how.unit) if how.unit and value is not None else value
    return found


def known(**values: Any) -> dict[str, Any]:
    """Return the items that are not None."""
    return {name: value for name, value in values.items() if value is not None}

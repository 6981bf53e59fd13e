"""Parts of documents made from the dataclasses that they hold: their fields, units and meaning are said once, there.

``PartOf[Channel]`` is the pydantic model ``ChannelPart``, with a description of each field from the docstring.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import MISSING, Field, fields, is_dataclass
from functools import cache, reduce
from inspect import getdoc
from operator import or_
from pathlib import Path
from types import UnionType
from typing import Annotated, Any, ClassVar, Generic, TypeVar, Union, get_args, get_origin, get_type_hints

import pydantic
from pydantic import AliasChoices

from fric.documents.base import CodedWarning
from fric.documents.quantity import CovarianceBlock, Physical, Quantity
from fric.estimate import Covariance, Estimate
from fric.notice import Notice

T = TypeVar("T")

HELD: dict[Any, Any] = {Estimate: Quantity, Covariance: CovarianceBlock, Notice: CodedWarning, Path: str}
"""What documents hold in place of a type that is not a dataclass of plain numbers."""


class PartOf(Physical, Generic[T]):
    """A part that holds each field of a dataclass, and what that has as properties where a subclass names them."""

    held: ClassVar[type[Any]]

    def __class_getitem__(cls, kind: Any) -> Any:
        """Return the part of a dataclass."""
        return _part(cls, kind) if is_dataclass(kind) else super().__class_getitem__(kind)

    @classmethod
    def entry(cls, field: Field[Any], kind: Any, text: str | None) -> dict[str, tuple[Any, Any]]:
        """Return the keys of a field in a document, each with its type and what pydantic is to know of it."""
        if field.name == "warnings":
            aliases = AliasChoices("warnings_coded", "warnings")
            coded = pydantic.Field(default_factory=list, validation_alias=aliases)
            return {
                "warnings": (list[str], pydantic.Field(default_factory=list)),
                "warnings_coded": (list[CodedWarning], coded),
            }
        return {field.name: (cls.of_type(kind), pydantic.Field(description=text))}

    @classmethod
    def of_type(cls, kind: Any) -> Any:
        """Return the type by which a document holds something of a type."""
        if is_dataclass(kind) and kind not in HELD:
            return _part(cls, kind)
        origin, given = get_origin(kind), tuple(map(cls.of_type, get_args(kind)))
        if origin is Annotated:
            return Annotated[Quantity, *kind.__metadata__]
        if origin in {Union, UnionType}:
            return reduce(or_, given)
        if origin in {tuple, list, Sequence}:
            return list[given[0]]  # type: ignore[valid-type]
        if origin in {dict, Mapping}:
            return dict[given]  # type: ignore[valid-type]
        return HELD.get(kind, kind)


@cache
def _part(base: type[PartOf[Any]], kind: Any) -> Any:
    """Return the part that holds a dataclass."""
    summary, described = described_fields(kind)
    types = get_type_hints(kind, include_extras=True)
    given: dict[str, Any] = {}
    for one in fields(kind):
        given |= base.entry(one, types[one.name], described.get(one.name))
    name = f"{kind.__name__}Part"
    made = pydantic.create_model(name, __base__=base, __doc__=summary, __module__=__name__, **given)
    made.held = kind
    return made


def described_fields(kind: type[Any]) -> tuple[str, dict[str, str]]:
    """Return what a docstring says of a class, its first paragraph, and of each field: a sentence, without the unit.

    A field is described below ``Parameters``, as in NumPy, or in a line ``name: …``; several of one line have commas
    between them.
    """
    text = getdoc(kind) or ""
    below = text.partition("Parameters\n-")[2]
    found = re.findall(r"^(\w+(?:, \w+)*)\n((?:    .*\n?)+)", below, re.MULTILINE)
    found = found or re.findall(r"^(\w+(?:, \w+)*): (.+\n?(?:    .*\n?)*)", text, re.MULTILINE)
    told = {}
    for names, body in found:
        sentence = re.split(r"\.(?: |$)", " ".join(body.split()))[0]
        for name in names.split(", "):
            told[name] = sentence[0].lower() + sentence[1:]
    return text.partition("\n\n")[0], told


def optional(field: Field[Any]) -> bool:
    """Tell whether a field may be left out."""
    return field.default is not MISSING or field.default_factory is not MISSING

"""Parts of documents made from dataclasses, which define fields, units and meaning.

``PartOf[Channel]`` is the pydantic model ``ChannelPart`` of a part that fric only writes, described by the docstring;
``FilePart[Cascade]`` is that of what fric also reads: a number is a quantity with a unit, of the dimension given with
the field (``Annotated[float, "force"]``).
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import MISSING, Field, fields, is_dataclass
from functools import cache, reduce
from inspect import cleandoc, getdoc
from math import inf
from operator import or_
from pathlib import Path
from types import UnionType
from typing import Annotated, Any, ClassVar, Generic, TypeVar, Union, get_args, get_origin, get_type_hints

import pydantic
from pydantic import AliasChoices

from fric.documents.base import CodedWarning
from fric.documents.quantity import CovarianceBlock, Known, Physical, Quantity
from fric.estimate import Covariance, Estimate, Interval
from fric.notice import Notice
from fric.units import Motion

T = TypeVar("T")

HELD: dict[Any, Any] = {Estimate: Quantity, Covariance: CovarianceBlock, Notice: CodedWarning, Path: str}
"""Types in documents for types that are not dataclasses of plain numbers."""


class PartOf(Physical, Generic[T]):
    """A part that holds each field of a dataclass, and its properties that a subclass names."""

    held: ClassVar[type[Any]]

    def __class_getitem__(cls, kind: Any) -> Any:
        """Return the part of a dataclass."""
        return _part(cls, kind) if hasattr(kind, "__dataclass_fields__") else super().__class_getitem__(kind)

    @classmethod
    def entry(cls, field: Field[Any], kind: Any, text: str | None) -> dict[str, tuple[Any, Any]]:
        """Return the keys of a field in a document, each with its type and its data for pydantic."""
        if field.name == "warnings":
            aliases = AliasChoices("warnings_coded", "warnings")
            coded: Any = pydantic.Field(default_factory=list, validation_alias=aliases)
            return {
                "warnings": (list[str], pydantic.Field(default_factory=list)),
                "warnings_coded": (list[CodedWarning], coded),
            }
        return {field.name: (cls.of_type(kind), pydantic.Field(description=text))}

    @classmethod
    def of_type(cls, kind: Any) -> Any:
        """Return the type by which a document holds something of a type."""
        if isinstance(kind, type) and is_dataclass(kind) and kind not in HELD:
            return _part(cls, kind)
        if kind == Interval:
            return list[Known]
        origin, given = get_origin(kind), tuple(map(cls.of_type, get_args(kind)))
        if origin is Annotated:
            return Annotated[Quantity, *kind.__metadata__]
        if origin in {Union, UnionType}:
            return reduce(or_, given)
        if origin in {tuple, list, Sequence}:
            return list[given[0]]  # type: ignore[valid-type]
        if origin in {dict, Mapping}:
            return dict[given[0], given[1]]  # type: ignore[valid-type]
        return HELD.get(kind, kind)


class FilePart(PartOf[T]):
    """A part that is read: each number with a dimension is a quantity, and fields with a default may be left out."""

    @classmethod
    def entry(cls, field: Field[Any], kind: Any, text: str | None) -> dict[str, tuple[Any, Any]]:
        """Return the key of a field, which may be left out if the dataclass has a default."""
        may_lack = field.default is not MISSING or field.default_factory is not MISSING
        within: list[Any] = [one for one in (kind, *get_args(kind)) if is_dataclass(one)]
        text = text and text.partition(" [")[0]  # a quantity says its unit
        if within and get_origin(kind) is tuple:
            return {field.name: (cls.of_type(kind), pydantic.Field(default_factory=list))}
        if within:
            return {field.name: (cls.of_type(within[0]) | None, pydantic.Field(None, description=text))}
        if get_origin(kind) is not Annotated:
            given = field.default if may_lack else ...
            return {field.name: (kind, pydantic.Field(given, description=text))}
        asked: Any = Quantity | None if may_lack else Quantity
        given = None if may_lack else ...
        return {field.name: (Annotated[asked, *kind.__metadata__], pydantic.Field(given, description=text))}

    def estimates(self, motion: Motion, where: str = "") -> dict[str, Estimate]:
        """Return its numbers, with those of nested parts; raise ValueError with a remedy."""
        for name, item in self:
            for n, part in enumerate(item if isinstance(item, list) else [item]):
                if isinstance(part, FilePart):
                    part.estimates(motion, f"{where}.{name}" + (f".{n}" if isinstance(item, list) else ""))
        return super().estimates(motion, where)

    def in_si(self, motion: Motion) -> T:
        """Return the dataclass in SI; raise a `FricError` where it is not physical."""

        def made(one: Any) -> Any:
            return one.in_si(motion) if isinstance(one, FilePart) else one

        given = {
            name: tuple(map(made, one)) if isinstance(one, list) else made(one)
            for name in {field.name for field in fields(self.held)} - self.dimensions.keys()
            if (one := getattr(self, name, None)) is not None
        }
        found: T = self.held(**given, **self.values(motion))
        return found


@cache
def _part(base: type[PartOf[Any]], kind: type[Any]) -> Any:
    """Return the part that holds a dataclass."""
    summary, described = described_fields(kind)
    types = get_type_hints(kind, include_extras=True)
    given: dict[str, Any] = {}
    for field in fields(kind):
        if field.metadata.get("leaves", True):
            given |= base.entry(field, types[field.name], described.get(field.name))
    name = f"{kind.__name__}Part"
    made = pydantic.create_model(name, __base__=base, __doc__=summary, __module__=__name__, **given)
    made.held = kind
    return made


def filed(given: Any, motion: Motion) -> Any:
    """Return a dataclass as the keys of its `FilePart` in a file, but for those at their defaults."""
    if isinstance(given, tuple):
        return [filed(one, motion) for one in given]
    if not is_dataclass(given) or isinstance(given, type) or type(given) in HELD:
        return given
    unset = {field.name for field in fields(given) if getattr(given, field.name) == field.default}
    found = _part(FilePart, type(given)).of(given, motion)
    return {name: filed(one, motion) for name, one in found.items() if name not in unset and one not in ((), {})}


def described_fields(kind: type[Any]) -> tuple[str, dict[str, str]]:
    """Return the description of a class, the first paragraph of its docstring, and a sentence for each field.

    A field is described below ``Parameters``, as in NumPy, or in a line ``name: …``; several of one line have commas
    between them.
    """
    text, texts = getdoc(kind) or "", dict[str, str]()
    for one in reversed(kind.__mro__[:-1]):
        doc = cleandoc(one.__doc__ or "")
        below = doc.partition("Parameters\n-")[2]
        found = re.findall(r"^(\w+(?:, \w+)*)\n((?:    .*\n?)+)", below, re.MULTILINE)
        for names, body in found or re.findall(r"^(\w+(?:, \w+)*): (.+\n?(?:    .*\n?)*)", doc, re.MULTILINE):
            sentence = re.split(r"\.(?: |$)", " ".join(body.split()))[0]
            texts |= {name: sentence[0].lower() + sentence[1:] for name in names.split(", ")}
    return text.partition("\n\n")[0], texts


def again(kind: Any, given: Any) -> Any:
    """Return a dataclass, or a type within it, from the plain values that `PartOf` made of it; null is infinite."""
    inner = get_args(kind)
    if is_dataclass(kind):
        types = get_type_hints(kind)
        made: Any = kind
        return made(
            **{field.name: again(types[field.name], given[field.name]) for field in fields(kind) if field.name in given}
        )
    if kind is float:
        return inf if given is None else float(given)
    if kind is Notice:
        return Notice.of(given)
    if get_origin(kind) is tuple:
        return tuple(again(inner[0], item) for item in given)
    if get_origin(kind) in {dict, Mapping}:
        return {key: again(inner[1], item) for key, item in given.items()}
    return given

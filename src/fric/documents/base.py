"""The common part of YAML documents: type, warnings, provenance; quantities with units; parts made from dataclasses.

``PartOf[Channel]`` is the pydantic model ``ChannelPart`` of a part that fric only writes, described by the docstring;
``FilePart[Cascade]`` is that of what fric also reads: a number is a quantity with a unit, of the dimension given with
the field (``Annotated[float, "force"]``).
"""

import re
import shlex
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager
from contextvars import ContextVar
from dataclasses import MISSING, asdict, fields, is_dataclass, replace
from dataclasses import Field as DataclassField
from functools import cache, reduce
from hashlib import sha256
from inspect import cleandoc, getdoc
from linecache import getlines
from math import inf
from operator import or_
from pathlib import Path
from typing import Annotated, Any, ClassVar, Generic, Literal, Self, TypeVar, get_args, get_origin, get_type_hints

import numpy as np
from pydantic import AliasChoices, BaseModel, Field, TypeAdapter, ValidationError, create_model, model_validator
from pydantic_core import InitErrorDetails, PydanticCustomError

import fric
from fric.documents.fields import AxisName, Known, SchemaError, known, read_off, refused, said
from fric.errors import FricError
from fric.estimate import Covariance, Estimate, Interval, Scale
from fric.log import Record
from fric.notice import Notice, Severity, once
from fric.process import holding, now
from fric.units import Motion, factor, of_force, rotates, si_unit
from fric.verb import UNIONS

LARGEST = 1e20  # Largest number of a quantity: a stiffness of 1e9 N/m whose interval is open reaches 1e15
_COMMAND: ContextVar[tuple[str, ...] | None] = ContextVar("command", default=None)
HEAD, FOOT = ("fric", "axis", "motion"), ("warnings", "warnings_coded", "provenance")  # Keys above and below the rest


def largest(given: Any) -> float:
    """Return the largest magnitude of the numbers in values, lists and keys; parts look at theirs themselves."""
    held = given.values() if isinstance(given, Mapping) else given if isinstance(given, list | tuple) else ()
    return float(min(abs(given), 1e300)) if isinstance(given, float | int) else max(map(largest, held), default=0.0)


class Part(BaseModel):
    """A part of a document: an unknown key is an error, never ignored, and so is a number beyond all drives."""

    model_config = {"extra": "forbid", "frozen": True, "defer_build": True, "allow_inf_nan": False}
    most: ClassVar[float] = LARGEST

    @model_validator(mode="after")
    def _is_of_a_drive(self) -> Self:
        for name, given in self.__dict__.items():
            if not largest(given) <= self.most:
                what = f"{name}: {largest(given):g} is beyond all drives\nGive null for an open limit."
                raise PydanticCustomError("beyond", "{what}", {"what": what})
        return self


class Written(Part):
    """A part that fric writes and does not read: made of an object, by `read_off`."""

    @model_validator(mode="before")
    @classmethod
    def _read_off(cls, given: Any) -> Any:
        held = isinstance(given, Mapping | BaseModel | list | set | str | bytes | float | int | None)
        held = held or type(given).__module__.startswith(("datetime", "ruamel."))  # what a file holds
        return given if held else read_off(cls, given)


class Quantity(Part):
    """A value with its unit, as in ``{value: 105, unit: N, ci95: [104, 106]}``, or by hand as ``"105 N"``."""

    value: float | list[float]
    unit: str
    ci95: list[float | None] | list[list[float | None]] | None = said(
        "95 % interval [low, high], one per element; null is a limit that the data do not set"
    )
    fixed: bool = False
    assumed: bool = False
    source: str = ""

    @model_validator(mode="before")
    @classmethod
    def _by_hand(cls, given: Any) -> Any:
        if isinstance(given, Estimate):
            return given.as_dict()
        if isinstance(given, str):
            number, _, unit = given.strip().partition(" ")
            try:
                return {"value": float(number), "unit": unit.strip() or "1"}
            except ValueError:
                raise ValueError(f"'{given}' is not a quantity\nWrite a number and its unit, as '105 N'.") from None
        if isinstance(given, int | float) and not isinstance(given, bool):
            return {"value": given, "unit": "1"}
        return given

    def si(self, dimension: str, motion: Motion) -> Estimate:
        """Return the quantity as an `Estimate` in SI; a unit of the wrong kind raises a `FricError`."""
        scale, given = factor(self.unit, dimension, motion), Estimate.read(self.__dict__)

        def scaled(part: Any) -> Any:
            return tuple(map(scaled, part)) if isinstance(part, tuple) else part * scale

        value, ci95 = scaled(given.value), given.ci95 and scaled(given.ci95)
        return replace(given, value=value, unit=si_unit(dimension, motion), ci95=ci95, source=self.source)

    @model_validator(mode="after")
    def _interval_fits(self) -> Self:
        with refused():
            Estimate.read(self.__dict__)
        return self


class CovarianceBlock(Part):
    """Covariance of what was identified together; square, in the order of the names, in SI units."""

    names: list[str] = Field(description="parameters; k_2 is of the second block, negative.F_c of that direction")
    scales: list[Scale] = Field(description="whether the covariance is of the value, its logarithm or its logit")
    matrix: list[list[float]]
    most: ClassVar[float] = LARGEST**2

    @model_validator(mode="before")
    @classmethod
    def _of_a_fit(cls, given: Any) -> Any:
        return asdict(given) if isinstance(given, Covariance) else given

    @model_validator(mode="after")
    def _is_square(self) -> Self:
        n = len(self.names)
        if len(self.scales) != n or len(self.matrix) != n or any(len(row) != n for row in self.matrix):
            raise ValueError(f"the covariance does not fit its {n} names\nGive a scale and a row of {n} for each.")
        return self

    def covariance(self) -> Covariance:
        """Return the covariance, without parameters that are open."""
        return Covariance.of(self.names, self.matrix, self.scales)


def in_units(values: Mapping[str, Any], dimensions: Mapping[str, str], motion: Motion) -> dict[str, Estimate]:
    """Return numbers in SI with their units, by name."""
    return {name: Estimate(values[name], si_unit(of, motion)) for name, of in dimensions.items() if name in values}


def quantities(given: Mapping[Any, Any], dimensions: dict[str, str], motion: Motion, where: str) -> dict[str, Estimate]:
    """Parse named quantities of known dimensions to SI; raise SchemaError with a remedy on a misfit."""
    found: dict[str, Estimate] = {}
    for name, value in given.items():
        if name not in dimensions:
            known_are = f"Known are {', '.join(dimensions)}."
            raise SchemaError(f"'{name}' is not a parameter", where=where or "here", hint=known_are)
        with refused(f"{where}.{name}" if where else name):
            quantity = value if isinstance(value, Quantity) else Quantity.model_validate(value)
            found[name] = quantity.si(dimensions[name], motion)
    return found


Given = TypeVar("Given", Estimate, Quantity)


def single(found: dict[str, Given]) -> dict[str, Given]:
    """Return quantities of one number each; raise SchemaError with a remedy if one is a list."""
    for name, quantity in found.items():
        if isinstance(quantity.value, tuple | list):
            what = f"a list of {len(quantity.value)} where one value is expected"
            raise SchemaError(what, where=name, hint="Give one number with its unit.")
    return found


class Physical(Part):
    """A part whose fields are quantities, each with its dimension beside it: ``Annotated[Quantity, "force"]``."""

    dimensions: ClassVar[dict[str, str]]

    @classmethod
    def __pydantic_init_subclass__(cls, **_: Any) -> None:
        """Note the dimension of each field, if any."""
        given = ((name, item) for name, field in cls.model_fields.items() for item in field.metadata)
        cls.dimensions = {name: text for name, text in given if isinstance(text, str)}

    @model_validator(mode="after")
    def _has_one_number_each(self) -> Self:
        single({name: given for name in self.dimensions if isinstance(given := getattr(self, name), Quantity)})
        return self

    @classmethod
    def of(cls, given: object, motion: Motion) -> dict[str, Any]:
        """Return the fields of an object in SI for a file; None, infinite and missing values are left out."""
        values = {name: getattr(given, name, None) for name in cls.model_fields}
        kept = {name: value for name, value in values.items() if value not in (None, inf)}
        return kept | in_units(kept, cls.dimensions, motion)

    def estimates(self, motion: Motion, where: str = "") -> dict[str, Estimate]:
        """Return the given quantities in SI; raise SchemaError with a remedy on a wrong unit."""
        given = {name: getattr(self, name) for name in self.dimensions}
        return quantities(known(**given), self.dimensions, motion, where)

    def values(self, motion: Motion) -> dict[str, float]:
        """Return the quantities that are given, as numbers in SI."""
        return {name: float(estimate) for name, estimate in self.estimates(motion).items()}


def commanded(*words: str) -> AbstractContextManager[None]:
    """Let documents made within the block name this command instead of that of the process."""
    return holding(_COMMAND, words)


def provenance(logs: Iterable[Record] = ()) -> dict[str, Any]:
    """Return the ``provenance`` of a document made by this process from these records.

    The time is ``SOURCE_DATE_EPOCH`` if set, so that an output can be reproduced to the last byte.
    """
    program = Path(sys.argv[0]).name.replace("__main__.py", "fric")
    command = shlex.join(_COMMAND.get() or (program, *sys.argv[1:]))
    made = {"fric": fric.__version__, "created": now().isoformat(timespec="seconds"), "command": command}
    read = [{"file": log.source, "record": log.name, "sha256": log.sha256} for log in logs]
    return made | arithmetic() | {"logs": read}


@cache
def arithmetic() -> dict[str, str]:
    """Return what rounds sums here: each BLAS with version and architecture, and NumPy's vector instructions."""
    from threadpoolctl import threadpool_info

    keys = ("internal_api", "version", "architecture")
    used = [item for item in threadpool_info() if item["user_api"] == "blas"]
    blas = {" ".join(str(item[key]) for key in keys if item.get(key)) for item in used}
    config: Any = np.show_config(mode="dicts")
    extensions = config.get("SIMD Extensions", {})
    chosen = extensions.get("found") or extensions.get("baseline") or ["none"]
    return {"blas": ", ".join(sorted(blas)), "simd": str(chosen[-1])}


def sources(files: Iterable[Path]) -> list[dict[str, str]]:
    """Return name and digest of each source file."""
    return [{"file": str(file), "sha256": sha256(Path(file).read_bytes()).hexdigest()} for file in files]


class SourceFile(Part, extra="allow"):
    """A file, and the record in it, that a document was made from."""

    file: str
    record: str = ""
    sha256: str = ""


class Provenance(Part, extra="allow"):
    """Origin of a document."""

    fric: str = ""
    created: str = ""
    command: str = ""
    logs: list[SourceFile] = Field(default_factory=list)


class CodedWarning(Part):
    """A warning for programs: its text is in ``warnings``, too."""

    code: str = said("the same for every size of the same matter, such as force-lags", "")
    severity: Severity = said("wrong: a number is wrong until this is mended", "doubt")
    text: str
    values: dict[str, Any] = said("what the sentence names, in SI with units", dict)
    where: str = said("record, file or axis that it was found in; stands before the sentence", "")
    carried: bool = said("whether a file that was read said it first", False)

    @model_validator(mode="before")
    @classmethod
    def _of_a_notice(cls, given: Any) -> Any:
        return given.as_dict() if isinstance(given, Notice) else given


class MachineOrigin(Part):
    """Arguments of `read_machine` by which a run's machine was read."""

    path: str = ""
    nominal_files: list[str] = Field(default_factory=list)
    friction_model: str | None = None
    gain: float | None = None
    lead: float | Literal["auto"] | None = None


class RunProvenance(Provenance):
    """Origin of a run file, with what the verdict asks of its machine; an older file has only some of it."""

    machine: str = ""
    axes: list[str] = Field(default_factory=list)
    resolution: float = Field(0.0, ge=0.0)
    exact: bool = False
    origin: MachineOrigin = MachineOrigin()
    warnings_coded: list[CodedWarning] = Field(default_factory=list)


def run_provenance(given: Any, where: str) -> dict[str, Any]:
    """Return what a run file says of its origin, with the keys that it has."""
    try:
        return RunProvenance.model_validate(given).model_dump(exclude_unset=True)
    except ValidationError as error:
        key = ".".join(map(str, ("provenance", *error.errors()[0]["loc"])))
        raise FricError(f"{key} is not as fric writes it", where=where, hint="Make it again.") from None


def nested(kind: Any, given: Any, name: str) -> Any:
    """Return the checked value of a key that the schema's class does not declare; errors name that key."""
    for item in (kind, *get_args(kind)):
        if isinstance(item, type) and issubclass(item, Part):
            item.model_rebuild()  # undeclared values are dumped by their serializer: before 2.14, only if built
    try:
        return TypeAdapter(kind).validate_python(given)
    except ValidationError as error:
        text = []
        for told in error.errors():
            of = PydanticCustomError("nested", "{told}", {"told": told["msg"]}) if "ctx" in told else told["type"]
            text.append(InitErrorDetails(type=of, loc=(name, *told["loc"]), input=told["input"]))
        raise ValidationError.from_exception_data(name, text) from None


def warned(notices: Iterable[Notice]) -> dict[str, Any]:
    """Return the ``warnings`` and ``warnings_coded`` of a document; each text occurs once."""
    words = once(map(Notice.of, notices))
    return {"warnings": [str(word) for word in words], "warnings_coded": [word.as_dict() for word in words]}


class Document(Part):
    """A document: its first key ``fric`` gives type and version."""

    type: ClassVar[str]
    version: ClassVar[int] = 1

    fric: str
    warnings: list[str] = said("what the data do not determine", list)
    warnings_coded: list[CodedWarning] = said("the same with code and severity", list)
    provenance: Provenance | None = None

    def __init_subclass__(cls, type: str = "", **settings: Any) -> None:
        """Keep the type that a class of documents states: ``class Plan(Document, type="plan")``."""
        super().__init_subclass__(**settings)
        if type:
            cls.type = type

    @classmethod
    def type_name(cls) -> str:
        """Return the value of ``fric:`` in the file, as in ``friction/1``."""
        return f"{cls.type}/{cls.version}"

    @classmethod
    def json_schema(cls) -> dict[str, Any]:
        """Return the JSON Schema of this type."""
        return {"$schema": "https://json-schema.org/draft/2020-12/schema", **cls.model_json_schema()}

    @classmethod
    def made(
        cls, content: object, *, notices: Iterable[Notice] = (), logs: Iterable[Record] = (),
        also: Mapping[str, Any] | None = None,
    ) -> Self:  # fmt: skip
        """Return a document of this process, checked against the schema as when read.

        logs, also: Records that it was made from, and further keys of its provenance.
        """
        if not isinstance(content, Mapping):
            content = read_off(cls, content, {"fric", *FOOT})
        foot = warned(notices) | {"provenance": provenance(logs) | dict(also or {})}
        try:
            return cls.model_validate({"fric": cls.type_name()} | dict(content) | foot, from_attributes=True)
        except ValidationError as error:
            odd = [
                ".".join(map(str, found["loc"])) for found in error.errors()
                if found["type"] in {"finite_number", "beyond"} or "beyond all drives" in found["msg"]
            ]  # fmt: skip
            if not odd:
                raise
            hint = "Look at the records with `fric inspect`, and leave out what is odd."
            raise FricError(f"{odd[0]} comes out as no number: the data do not tell it", hint=hint) from None

    def notices(self) -> tuple[Notice, ...]:
        """Return the warnings as data; a warning without a code, of an older file, is a doubt."""
        coded = {warning.text: Notice.of(dict(warning)) for warning in self.warnings_coded}
        return tuple((coded | {text: coded.get(text, Notice.of(text)) for text in self.warnings}).values())

    def passed_on(self) -> tuple[Notice, ...]:
        """Return the doubts of this document for documents based on it, each with its origin; not the notes."""
        of = f"{self.type} of axis {axis}" if (axis := getattr(self, "axis", "")) else self.type
        doubts = (notice for notice in self.notices() if notice.severity != "note")
        return tuple(doubt if doubt.carried else doubt.at(of, carried=True) for doubt in doubts)

    def tree(self, *, nulls: bool = True) -> dict[str, Any]:
        """Return the content as plain values in the order of a file, ready to be written or printed."""
        given = self.model_dump(exclude_unset=True, by_alias=True, exclude_none=not nulls)
        return {key: given[key] for key in sorted(given, key=lambda key: (key in FOOT) - (key in HEAD))}

    def content(self, *names: str) -> dict[str, Any]:
        """Return the named keys between head and foot, or all, for a file that is based on this file."""
        given = {key: part for key, part in self.tree().items() if key not in (*HEAD, *FOOT)}
        return {key: part for key, part in given.items() if key in names or not names}


class OfAxis(Document):
    """A document of an axis."""

    axis: AxisName
    motion: Motion = "linear"

    def belongs(self, axis: str, motion: Motion) -> bool:
        """Return whether it is of an axis: of the same units of what it holds, or of forces where it has no such."""
        held = {*getattr(self, "dimensions", {}).values()}
        alike = all(si_unit(of, self.motion) == si_unit(of, motion) for of in held)
        alike &= rotates(self.motion) == rotates(motion) if held else of_force(self.motion) == of_force(motion)
        return alike and self.axis == axis


class AxisDocument(OfAxis, Physical):
    """A document of quantities of an axis."""

    @model_validator(mode="after")
    def _units_fit(self) -> Self:
        self.estimates(self.motion)
        return self


T = TypeVar("T")

HELD: dict[Any, Any] = {Estimate: Quantity, Covariance: CovarianceBlock, Notice: CodedWarning, Path: str}
"""Types in documents for types that are not dataclasses of plain numbers."""


class PartOf(Physical, Generic[T]):
    """A part that holds each field of a dataclass, and its properties that a subclass names."""

    held: ClassVar[type[Any]]

    def __class_getitem__(cls, kind: Any) -> Any:
        return _part(cls, kind) if hasattr(kind, "__dataclass_fields__") else super().__class_getitem__(kind)

    @classmethod
    def entry(cls, field: DataclassField[Any], kind: Any, text: str | None) -> dict[str, tuple[Any, Any]]:
        """Return the keys of a field in a document, each with its type and its data for pydantic."""
        if field.name == "warnings":
            coded: Any = Field(default_factory=list, validation_alias=AliasChoices("warnings_coded", "warnings"))
            return {"warnings": (list[str], Field(default_factory=list)), "warnings_coded": (list[CodedWarning], coded)}
        return {field.name: (cls.of_type(kind), Field(description=text))}

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
        if origin in UNIONS:
            return reduce(or_, given)
        if origin in {tuple, list, Sequence}:
            return list[given[0]]  # type: ignore[valid-type]
        return dict[given[0], given[1]] if origin in {dict, Mapping} else HELD.get(kind, kind)  # type: ignore[valid-type]


class FilePart(PartOf[T]):
    """A part that is read: each number with a dimension is a quantity, and fields with a default may be left out."""

    @classmethod
    def entry(cls, field: DataclassField[Any], kind: Any, text: str | None) -> dict[str, tuple[Any, Any]]:
        """Return the key of a field, which may be left out if the dataclass has a default."""
        may_lack = field.default is not MISSING or field.default_factory is not MISSING
        within: list[Any] = [part for part in (kind, *get_args(kind)) if isinstance(part, type) and is_dataclass(part)]
        text = text and text.partition(" [")[0]  # a quantity says its unit
        if within and get_origin(kind) is tuple:
            return {field.name: (cls.of_type(kind), Field(default_factory=list))}
        if within:
            return {field.name: (cls.of_type(within[0]) | None, Field(None, description=text))}
        given = field.default if may_lack else ...
        if get_origin(kind) is Annotated:
            asked: Any = Quantity | None if may_lack else Quantity
            kind, given = Annotated[asked, *kind.__metadata__], None if may_lack else ...
        return {field.name: (kind, Field(given, description=text))}

    def estimates(self, motion: Motion, where: str = "") -> dict[str, Estimate]:
        """Return its numbers, with those of nested parts; raise SchemaError with a remedy."""
        for name, item in self:
            for n, part in enumerate(item if isinstance(item, list) else [item]):
                if isinstance(part, FilePart):
                    part.estimates(motion, f"{where}.{name}" + (f".{n}" if isinstance(item, list) else ""))
        return super().estimates(motion, where)

    def in_si(self, motion: Motion) -> T:
        """Return the dataclass in SI; raise a `FricError` where it is not physical."""

        def made(part: Any) -> Any:
            return part.in_si(motion) if isinstance(part, FilePart) else part

        given = {
            name: tuple(map(made, given)) if isinstance(given, list) else made(given)
            for name in {field.name for field in fields(self.held)} - self.dimensions.keys()
            if (given := getattr(self, name, None)) is not None
        }
        return self.held(**given, **self.values(motion))


@cache
def _part(base: type[PartOf[Any]], kind: type[Any]) -> Any:
    """Return the part that holds a dataclass."""
    summary, described = described_fields(kind)
    types = get_type_hints(kind, include_extras=True)
    given: dict[str, Any] = {}
    for field in fields(kind):
        if field.metadata.get("leaves", True):
            given |= base.entry(field, types[field.name], described.get(field.name))
    made = create_model(f"{kind.__name__}Part", __base__=base, __doc__=summary, __module__=__name__, **given)
    made.held = kind
    return made


def filed(given: Any, motion: Motion) -> Any:
    """Return a dataclass as the keys of its `FilePart` in a file, but for those at their defaults."""
    if isinstance(given, tuple):
        return [filed(part, motion) for part in given]
    if not is_dataclass(given) or isinstance(given, type) or type(given) in HELD:
        return given
    unset = {field.name for field in fields(given) if getattr(given, field.name) == field.default}
    found = _part(FilePart, type(given)).of(given, motion)
    return {name: filed(part, motion) for name, part in found.items() if name not in unset and part not in ((), {})}


def described_fields(kind: type[Any]) -> tuple[str, dict[str, str]]:
    """Return the description of a class, the first paragraph of its docstring, and a sentence for each field.

    A field is described below ``Parameters``, as in NumPy, or in a line ``name: …``; several of one line have commas
    between them. Or it is described on its line behind ``#:``, or in such lines above it, as Sphinx reads them.
    """
    text, texts = getdoc(kind) or "", dict[str, str]()
    for base in reversed(kind.__mro__[:-1]):
        doc = cleandoc(base.__doc__ or "")
        found = re.findall(r"^(\w+(?:, \w+)*)\n((?:    .*\n?)+)", doc.partition("Parameters\n-")[2], re.MULTILINE)
        found = found or re.findall(r"^(\w+(?:, \w+)*): (.+\n?(?:    .*\n?)*)", doc, re.MULTILINE)
        for names, body in [*found, *_beside(base)]:
            sentence = re.split(r"\.(?: |$)", " ".join(body.split()))[0]
            texts |= {name: sentence[0].lower() + sentence[1:] for name in names.split(", ")}
    return text.partition("\n\n")[0], texts


def _beside(kind: type[Any]) -> Iterator[tuple[str, str]]:
    """Yield what the source of a class says beside its fields behind ``#:``: of which, and the text."""
    file = getattr(sys.modules[kind.__module__], "__file__", None) or ""
    own = re.search(rf"^class {kind.__name__}\b.*\n(?:(?: .*)?\n)*", "".join(getlines(file)), re.MULTILINE)
    lines = re.findall(r"((?:^    #: .*\n)*)^    (\w+): .*?(  #: .*)?$", own[0] if own else "", re.MULTILINE)
    for above, name, behind in lines:
        if text := " ".join((above + behind).replace("#:", "").split()):
            several = re.match(r"(\w+(?:, \w+)+): (.*)", text)
            yield (several[1], several[2]) if several else (name, text)


def again(kind: Any, given: Any) -> Any:
    """Return a dataclass, or a type within it, from the plain values that `PartOf` made of it; null is infinite."""
    inner = get_args(kind)
    if is_dataclass(kind):
        types = get_type_hints(kind)
        made: Any = kind
        return made(**{f.name: again(types[f.name], given[f.name]) for f in fields(kind) if f.name in given})
    if kind is float:
        return inf if given is None else float(given)
    if kind is Notice:
        return Notice.of(given)
    if get_origin(kind) is tuple:
        return tuple(again(inner[0], item) for item in given)
    return {key: again(inner[1], item) for key, item in given.items()} if get_origin(kind) in {dict, Mapping} else given

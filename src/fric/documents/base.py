"""The common part of YAML documents: type, warnings, and provenance (version, time, command, logs with digests)."""

import os
import shlex
import sys
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from datetime import UTC, datetime
from functools import cache
from hashlib import sha256
from pathlib import Path
from typing import Annotated, Any, ClassVar, Self, get_args

import numpy as np
from pydantic import AfterValidator, Field, TypeAdapter, ValidationError, model_validator
from pydantic_core import InitErrorDetails, PydanticCustomError

import fric
from fric.documents.quantity import Part, Physical, read_off, refused
from fric.errors import FricError
from fric.log import Record, axis_name
from fric.notice import Notice, Severity, once
from fric.units import Motion

_COMMAND: ContextVar[tuple[str, ...] | None] = ContextVar("command", default=None)


@contextmanager
def commanded(*words: str) -> Iterator[None]:
    """Let documents made within the block name this command instead of that of the process."""
    before = _COMMAND.set(words)
    try:
        yield
    finally:
        _COMMAND.reset(before)


def provenance(logs: Iterable[Record] = ()) -> dict[str, Any]:
    """Return the ``provenance`` of a document made by this process from these records.

    The time is ``SOURCE_DATE_EPOCH`` if set, so that an output can be reproduced to the last byte.
    """
    epoch = os.environ.get("SOURCE_DATE_EPOCH")
    made = datetime.fromtimestamp(int(epoch), UTC) if epoch else datetime.now(UTC)
    program = Path(sys.argv[0]).name.replace("__main__.py", "fric")
    return {
        "fric": fric.__version__,
        "created": made.isoformat(timespec="seconds"),
        "command": shlex.join(_COMMAND.get() or (program, *sys.argv[1:])),
        **arithmetic(),
        "logs": [{"file": log.source, "record": log.name, "sha256": log.sha256} for log in logs],
    }


@cache
def arithmetic() -> dict[str, str]:
    """Return the libraries that round sums here: each BLAS with version and architecture, NumPy's vector
    instructions.
    """
    from threadpoolctl import threadpool_info

    keys = ("internal_api", "version", "architecture")
    blas = {
        " ".join(str(item[key]) for key in keys if item.get(key))
        for item in threadpool_info()
        if item["user_api"] == "blas"
    }
    config: Any = np.show_config(mode="dicts")
    extensions = config.get("SIMD Extensions", {})
    chosen = extensions.get("found") or extensions.get("baseline") or ["none"]
    return {"blas": ", ".join(sorted(blas)), "simd": str(chosen[-1])}


def sources(files: Iterable[Path]) -> list[dict[str, str]]:
    """Return name and digest of each source file."""
    return [{"file": str(file), "sha256": sha256(Path(file).read_bytes()).hexdigest()} for file in files]


AxisName = Annotated[str, AfterValidator(refused()(axis_name))]


class Provenance(Part, extra="allow"):
    """Origin of a document."""

    fric: str = ""
    created: str = ""
    command: str = ""
    logs: list[dict[str, str]] = Field(default_factory=list)


class CodedWarning(Part):
    """A warning for programs: its text is in ``warnings``, too."""

    code: str = Field("", description="the same for every size of the same matter, such as force-lags")
    severity: Severity = Field("doubt", description="wrong: a number is wrong until this is mended")
    text: str
    values: dict[str, Any] = Field(default_factory=dict, description="what the sentence names, in SI with units")
    where: str = Field("", description="record, file or axis that it was found in; stands before the sentence")
    carried: bool = Field(False, description="whether a file that was read said it first")

    @model_validator(mode="before")
    @classmethod
    def _of_a_notice(cls, given: Any) -> Any:
        return given.as_dict() if isinstance(given, Notice) else given


def nested(kind: Any, given: Any, name: str) -> Any:
    """Return the checked value of a key that the schema's class does not declare; errors name that key."""
    for item in (kind, *get_args(kind)):
        if isinstance(item, type) and issubclass(item, Part):
            item.model_rebuild()  # undeclared values are dumped by their serializer: before 2.14, only if built
    try:
        return TypeAdapter(kind).validate_python(given)
    except ValidationError as error:
        text = [
            InitErrorDetails(
                type=PydanticCustomError("nested", "{told}", {"told": error["msg"]})
                if "ctx" in error
                else error["type"],
                loc=(name, *error["loc"]),
                input=error["input"],
            )
            for error in error.errors()
        ]
        raise ValidationError.from_exception_data(name, text) from None


def warned(notices: Iterable[Notice]) -> dict[str, Any]:
    """Return the ``warnings`` and ``warnings_coded`` of a document; each text occurs once."""
    words = once(map(Notice.of, notices))
    return {"warnings": [str(word) for word in words], "warnings_coded": [word.as_dict() for word in words]}


HEAD, FOOT = ("fric", "axis", "motion"), ("warnings", "warnings_coded", "provenance")
"""Keys above and below the content."""


class Document(Part):
    """A document: its first key ``fric`` gives type and version."""

    type: ClassVar[str]
    version: ClassVar[int] = 1

    fric: str
    warnings: list[str] = Field(default_factory=list, description="what the data do not determine")
    warnings_coded: list[CodedWarning] = Field(default_factory=list, description="the same with code and severity")
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
        return cls.model_json_schema()

    @classmethod
    def made(
        cls,
        content: object,
        *,
        notices: Iterable[Notice] = (),
        logs: Iterable[Record] = (),
        also: Mapping[str, Any] | None = None,
    ) -> Self:
        """Return a document of this process, checked against the schema as when read.

        logs, also: Records that it was made from, and further keys of its provenance.
        """
        if not isinstance(content, Mapping):
            content = read_off(cls, content, {"fric", *FOOT})
        head = {"fric": cls.type_name()}
        foot = warned(notices) | {"provenance": provenance(logs) | dict(also or {})}
        try:
            return cls.model_validate(head | dict(content) | foot, from_attributes=True)
        except ValidationError as error:
            odd = [".".join(map(str, error["loc"])) for error in error.errors() if error["type"] == "finite_number"]
            if not odd:
                raise
            raise FricError(
                f"{odd[0]} comes out as no number: the data do not tell it",
                hint="Look at the records with `fric inspect`, and leave out what is odd.",
            ) from None

    def notices(self) -> tuple[Notice, ...]:
        """Return the warnings as data; a warning without a code, of an older file, is a doubt."""
        coded = {warning.text: Notice.of(dict(warning)) for warning in self.warnings_coded}
        return tuple((coded | {text: coded.get(text, Notice.of(text)) for text in self.warnings}).values())

    def passed_on(self) -> tuple[Notice, ...]:
        """Return the doubts of this document for documents based on it, each with its origin; notes are not passed
        on.
        """
        of = f"{self.type} of axis {axis}" if (axis := getattr(self, "axis", "")) else self.type
        doubts = (notice for notice in self.notices() if notice.severity != "note")
        return tuple(doubt if doubt.carried else doubt.at(of, carried=True) for doubt in doubts)

    def tree(self) -> dict[str, Any]:
        """Return the content as plain values in the order of a file, ready to be written or printed."""
        given = self.model_dump(exclude_unset=True, by_alias=True)
        return {key: given[key] for key in sorted(given, key=lambda key: (key in FOOT) - (key in HEAD))}


class OfAxis(Document):
    """A document of an axis."""

    axis: AxisName
    motion: Motion = "linear"


class AxisDocument(OfAxis, Physical):
    """A document of quantities of an axis."""

    @model_validator(mode="after")
    def _units_fit(self) -> Self:
        self.estimates(self.motion)
        return self

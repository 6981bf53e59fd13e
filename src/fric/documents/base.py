"""What every YAML document shares: quantities with units, provenance, and the line that says its type."""

import re
from collections.abc import Iterable, Mapping
from dataclasses import asdict
from math import inf, isfinite
from typing import Annotated, Any, ClassVar, Self

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    TypeAdapter,
    ValidationError,
    model_validator,
)
from pydantic_core import InitErrorDetails, PydanticCustomError

from fric.documents.provenance import provenance
from fric.errors import FricError
from fric.estimate import Covariance, Estimate, Scale
from fric.log import Record, axis_name
from fric.notice import Notice, Severity
from fric.units import Motion, factor, si_unit


def _of_axis(name: str) -> str:
    try:
        return axis_name(name)
    except FricError as error:
        raise ValueError(f"{error.what}\n{error.hint}") from None


def _finite(given: Any) -> Any:
    return None if isinstance(given, float) and not isfinite(given) else given


Known = Annotated[float | None, BeforeValidator(_finite)]
"""A number, or null for one that is infinite or not a number, which JSON cannot hold."""

AxisName = Annotated[str, AfterValidator(_of_axis)]


class Part(BaseModel):
    """A part of a document: an unknown key is an error, never passed over."""

    model_config = ConfigDict(extra="forbid", frozen=True, defer_build=True)


class Quantity(Part):
    """A value with its unit, as in ``{value: 105, unit: N, ci95: [104, 106]}``, or by hand as ``"105 N"``."""

    value: float | list[float]
    unit: str
    ci95: list[float | None] | list[list[float | None]] | None = Field(
        None, description="95 % interval [low, high], one per element; null is a limit that the data do not set"
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
                raise ValueError(f"'{given}' is not a quantity\nWrite a number and a unit, as in '105 N'.") from None
        if isinstance(given, int | float) and not isinstance(given, bool):
            return {"value": float(given), "unit": "1"}
        return given

    def si(self, dimension: str, motion: Motion) -> Estimate:
        """Return the quantity as an `Estimate` in SI; a unit of the wrong kind raises a `FricError`."""
        scale = factor(self.unit, dimension, motion)

        def scaled(value: Any) -> Any:
            return tuple(scaled(v) for v in value) if isinstance(value, list) else float(value) * scale

        limits = None if self.ci95 is None else scaled(self._limits())
        unit = si_unit(dimension, motion)
        return Estimate(scaled(self.value), unit, limits, self.fixed, self.assumed, self.source)

    def _limits(self) -> Any:
        """Return the limits of the interval, an open one as infinity, one pair per element of the value."""
        vector = isinstance(self.value, list)
        pairs: Any = self.ci95 if vector else [self.ci95]
        if len(pairs) != (len(self.value) if isinstance(self.value, list) else 1) or any(
            not isinstance(pair, list) or len(pair) != 2 for pair in pairs
        ):
            raise FricError("ci95 does not fit the value", hint="Give [low, high], one such pair per value.")
        ends = [[-inf if low is None else low, inf if high is None else high] for low, high in pairs]
        return ends if vector else ends[0]


class Provenance(Part):
    """What made a document, from what."""

    model_config = ConfigDict(extra="allow", frozen=True)

    fric: str = ""
    created: str = ""
    command: str = ""
    logs: list[dict[str, str]] = Field(default_factory=list)


class CodedWarning(Part):
    """A warning for programs: its text stands in ``warnings`` too."""

    code: str = Field("", description="the same for every size of the same matter, such as force-lags")
    severity: Severity = Field("doubt", description="wrong: a number is wrong until this is mended")
    text: str

    @model_validator(mode="before")
    @classmethod
    def _of_a_notice(cls, given: Any) -> Any:
        return Notice.of(given).as_dict() if isinstance(given, str) else given


class CovarianceBlock(Part):
    """Covariance of what was identified together; square, in the order of the names, in SI units."""

    names: list[str] = Field(description="parameters; k_2 is of the second block, negative.F_c of that direction")
    scales: list[Scale] = Field(description="whether the covariance is of the value, its logarithm or its logit")
    matrix: list[list[float]]

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
        """Return the covariance."""
        return Covariance(tuple(self.names), tuple(self.scales), tuple(tuple(row) for row in self.matrix))


def known(**values: Any) -> dict[str, Any]:
    """Return what is not None."""
    return {name: value for name, value in values.items() if value is not None}


def nested(kind: Any, given: Any, name: str) -> Any:
    """Return what stands under a key that the schema's class does not declare, checked; errors tell that key."""
    try:
        return TypeAdapter(kind).validate_python(given)
    except ValidationError as error:
        text = [
            InitErrorDetails(
                type=PydanticCustomError("nested", "{told}", {"told": one["msg"]}) if "ctx" in one else one["type"],
                loc=(name, *one["loc"]),
                input=one["input"],
            )
            for one in error.errors()
        ]
        raise ValidationError.from_exception_data(name, text) from None


def warned(notices: Iterable[str]) -> dict[str, Any]:
    """Return the ``warnings`` and ``warnings_coded`` of a document; each text stands once."""
    words = list(dict.fromkeys(Notice.of(text) for text in notices))
    return {"warnings": [str(one) for one in words], "warnings_coded": [one.as_dict() for one in words]}


HEAD, FOOT = ("fric", "axis", "motion"), ("warnings", "warnings_coded", "provenance")
"""Keys that stand above, and below, all content."""


_PASSED_ON = re.compile(r"[a-z-]+ of axis \S+: ")
"""Begins a warning that was told by one document of another."""


class Document(Part):
    """A document: its first key ``fric`` says type and version."""

    type: ClassVar[str]
    version: ClassVar[int] = 1

    fric: str
    warnings: list[str] = Field(default_factory=list, description="what the data could not tell")
    warnings_coded: list[CodedWarning] = Field(default_factory=list, description="the same with code and severity")
    provenance: Provenance | None = None

    @classmethod
    def type_name(cls) -> str:
        """Return what stands behind ``fric:`` in the file, as in ``friction/1``."""
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
        notices: Iterable[str] = (),
        logs: Iterable[Record] = (),
        also: Mapping[str, Any] | None = None,
    ) -> Self:
        """Return a document that this process makes of some content, checked against the schema as one that is read.

        Parameters
        ----------
        content
            What it holds, by key; or something with attributes of these names.
        notices
            Its warnings.
        logs
            Records that it was made from.
        also
            Further keys of its provenance.
        """
        if not isinstance(content, Mapping):
            content = {name: getattr(content, name) for name in cls.model_fields.keys() - {"fric", *FOOT}}
        head = {"fric": cls.type_name()}
        foot = warned(notices) | {"provenance": provenance(logs) | dict(also or {})}
        return cls.model_validate(head | dict(content) | foot, from_attributes=True)

    def notices(self) -> tuple[Notice, ...]:
        """Return the warnings as data; one that an older file tells without a code is a doubt."""
        coded = {one.text: Notice(**dict(one)) for one in self.warnings_coded}
        return tuple((coded | {text: coded.get(text, Notice(text)) for text in self.warnings}).values())

    def passed_on(self) -> tuple[Notice, ...]:
        """Return the doubts of this document for what builds upon it, each with where it is from; notes stay here."""
        text = [one for one in self.notices() if one.severity != "note"]
        of = f"{self.type} of axis {axis}" if (axis := getattr(self, "axis", "")) else self.type
        return tuple(one if _PASSED_ON.match(one) else Notice(f"{of}: {one}", one.code, one.severity) for one in text)

    def tree(self) -> dict[str, Any]:
        """Return what was given, as plain values in the order of a file, ready to be written or printed."""
        given = self.model_dump(exclude_unset=True, by_alias=True)
        return {key: given[key] for key in sorted(given, key=lambda key: (key in FOOT) - (key in HEAD))}


class Physical(Part):
    """A part whose fields are quantities, each with its dimension beside it: ``Annotated[Quantity, "force"]``."""

    dimensions: ClassVar[dict[str, str]]

    @classmethod
    def __pydantic_init_subclass__(cls, **_: Any) -> None:
        """Note the dimension of each field that has one."""
        given = ((name, one) for name, field in cls.model_fields.items() for one in field.metadata)
        cls.dimensions = {name: one for name, one in given if isinstance(one, str)}

    @classmethod
    def of(cls, given: object, motion: Motion) -> dict[str, Any]:
        """Return what the fields of something in SI are in a file; what is None, infinite or not there is left out."""
        values = {name: getattr(given, name, None) for name in cls.model_fields}
        kept = {name: value for name, value in values.items() if value not in (None, inf)}
        return kept | in_units(kept, cls.dimensions, motion)

    def estimates(self, motion: Motion, where: str = "") -> dict[str, Estimate]:
        """Return the quantities that are given, in SI; raise ValueError with the mend on a misfit."""
        given = {name: getattr(self, name) for name in self.dimensions}
        found = quantities(known(**given), self.dimensions, motion, where)
        for name, estimate in found.items():
            if isinstance(estimate.value, tuple):
                raise ValueError(
                    f"{name}: {len(estimate.value)} values stand where there is one\nGive one number with its unit."
                )
        return found

    def values(self, motion: Motion) -> dict[str, float]:
        """Return the quantities that are given, as numbers in SI."""
        return {name: float(estimate) for name, estimate in self.estimates(motion).items()}


class OfAxis(Document):
    """A document that is of one axis."""

    axis: AxisName
    motion: Motion = "linear"


class AxisDocument(OfAxis, Physical):
    """A document of quantities that is of one axis."""

    @model_validator(mode="after")
    def _units_fit(self) -> Self:
        self.estimates(self.motion)
        return self


def in_units(values: Mapping[str, Any], dimensions: Mapping[str, str], motion: Motion) -> dict[str, Estimate]:
    """Return numbers in SI with their units, by name."""
    return {name: Estimate(values[name], si_unit(one, motion)) for name, one in dimensions.items() if name in values}


def quantities(given: Mapping[str, Any], dimensions: dict[str, str], motion: Motion, where: str) -> dict[str, Estimate]:
    """Parse named quantities of known dimensions to SI; raise ValueError with the mend on a misfit."""
    found: dict[str, Estimate] = {}
    for name, value in given.items():
        if name not in dimensions:
            raise ValueError(f"{where or 'here'}: '{name}' is not a parameter\nKnown are {', '.join(dimensions)}.")
        try:
            quantity = value if isinstance(value, Quantity) else Quantity.model_validate(value)
            found[name] = quantity.si(dimensions[name], motion)
        except FricError as error:
            place = f"{where}.{name}" if where else name
            raise ValueError(f"{place}: {error.what}\n{error.hint}") from None
    return found

"""The YAML documents and their schemas; `fric schema TYPE` prints each as JSON Schema."""

from __future__ import annotations

from typing import Any, ClassVar, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

from fric.errors import FricError
from fric.estimate import Estimate
from fric.friction import models
from fric.units import Motion, factor, si_unit


class Part(BaseModel):
    """A part of a document: an unknown key is an error, never passed over."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class Quantity(Part):
    """A value with its unit, as in ``{value: 105, unit: N, ci95: [104, 106]}``, or by hand as ``"105 N"``."""

    value: float | list[float]
    unit: str
    ci95: list[float] | list[list[float]] | None = None
    fixed: bool = False
    assumed: bool = False
    source: str = ""

    @model_validator(mode="before")
    @classmethod
    def _by_hand(cls, given: Any) -> Any:
        if isinstance(given, str):
            number, _, unit = given.strip().partition(" ")
            try:
                return {"value": float(number), "unit": unit.strip() or "1"}
            except ValueError:
                raise ValueError(
                    f"'{given}' is not a quantity\nWrite a number and a unit, as in '105 N'."
                ) from None
        if isinstance(given, int | float) and not isinstance(given, bool):
            return {"value": float(given), "unit": "1"}
        return given

    def si(self, dimension: str, motion: Motion) -> Estimate:
        """Return the quantity as an `Estimate` in SI; a unit of the wrong kind raises a `FricError`."""
        scale = factor(self.unit, dimension, motion)

        def scaled(value: Any) -> Any:
            return tuple(scaled(v) for v in value) if isinstance(value, list) else float(value) * scale

        return Estimate(
            scaled(self.value), si_unit(dimension, motion), None if self.ci95 is None else scaled(self.ci95),
            self.fixed, self.assumed, self.source,
        )  # fmt: skip


class Provenance(Part):
    """What made a document, from what."""

    model_config = ConfigDict(extra="allow", frozen=True)

    fric: str = ""
    created: str = ""
    command: str = ""
    logs: list[dict[str, str]] = Field(default_factory=list)


class Document(Part):
    """A document: its first key ``fric`` says type and version."""

    type: ClassVar[str]
    version: ClassVar[int] = 1

    fric: str
    warnings: list[str] = Field(default_factory=list)
    provenance: Provenance | None = None

    @classmethod
    def type_name(cls) -> str:
        """Return what stands behind ``fric:`` in the file, as in ``friction/1``."""
        return f"{cls.type}/{cls.version}"


def quantities(
    given: dict[str, Any], dimensions: dict[str, str], motion: Motion, where: str
) -> dict[str, Estimate]:
    """Parse named quantities of known dimensions to SI; raise ValueError with the mend on a misfit."""
    found: dict[str, Estimate] = {}
    for name, value in given.items():
        if name not in dimensions:
            raise ValueError(f"{where}: '{name}' is not a parameter\nKnown are {', '.join(dimensions)}.")
        try:
            found[name] = Quantity.model_validate(value).si(dimensions[name], motion)
        except FricError as error:
            raise ValueError(f"{where}.{name}: {error.what}\n{error.mend}") from None
    return found


def _document_types() -> dict[str, type[Document]]:
    pending, found = [Document], {}
    while pending:
        document = pending.pop()
        pending += document.__subclasses__()
        if "type" in vars(document):
            found[document.type] = document
    return dict(sorted(found.items()))


class FrictionDocument(Document):
    """A friction file: the static map, and any other model under its own name."""

    model_config = ConfigDict(extra="allow", frozen=True)
    type: ClassVar[str] = "friction"

    axis: str
    motion: Motion = "linear"
    static: dict[str, Quantity] | None = Field(
        None, description="F_c, F_s, v_s, delta, sigma, offset of eq. (2)"
    )
    static_negative: dict[str, Quantity] | None = Field(None, description="the negative direction's own values")
    fit: dict[str, Any] = Field(default_factory=dict, description="how well the static map fits")

    @model_validator(mode="after")
    def _models_are_known(self) -> Self:
        for name in self.model_extra or {}:
            if name not in models() and name.removesuffix("_fit") not in models():
                raise ValueError(f"'{name}' is not a friction model\nKnown are {', '.join(models())}.")
        self.estimates("static") if self.static else None
        return self

    def estimates(self, section: str) -> dict[str, Estimate]:
        """Return the parameters of one section (``static``, ``gms``, …) in SI."""
        name = section.removesuffix("_negative")
        given = getattr(self, section, None) or (self.model_extra or {}).get(section)
        if not given:
            raise FricError(f"there is no '{section}' in the friction of axis {self.axis}")
        dimensions = {p.name: p.dimension for p in models()[name].parameters}
        if name == "static":
            dimensions["offset"] = "force"
        raw = {
            key: value.model_dump() if isinstance(value, Quantity) else value for key, value in given.items()
        }
        return quantities(raw, dimensions, self.motion, section)

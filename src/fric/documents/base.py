"""What every YAML document shares: quantities with units, provenance, and the line that says its type."""

from __future__ import annotations

from math import inf
from typing import Any, ClassVar, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

from fric.errors import FricError
from fric.estimate import Estimate
from fric.units import Motion, factor, si_unit


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
            raise FricError("ci95 does not fit the value", mend="Give [low, high], one such pair per value.")
        ends = [[-inf if low is None else low, inf if high is None else high] for low, high in pairs]
        return ends if vector else ends[0]


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


class Physical(Part):
    """A part whose fields are quantities of known dimensions."""

    dimensions: ClassVar[dict[str, str]]

    def estimates(self, motion: Motion, where: str = "") -> dict[str, Estimate]:
        """Return the quantities that are given, in SI; raise ValueError with the mend on a misfit."""
        given = {name: getattr(self, name) for name in self.dimensions}
        raw = {name: value.model_dump() for name, value in given.items() if value is not None}
        found = quantities(raw, self.dimensions, motion, where)
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

    axis: str
    motion: Motion = "linear"


class AxisDocument(OfAxis, Physical):
    """A document of quantities that is of one axis."""

    @model_validator(mode="after")
    def _units_fit(self) -> Self:
        self.estimates(self.motion)
        return self


def quantities(given: dict[str, Any], dimensions: dict[str, str], motion: Motion, where: str) -> dict[str, Estimate]:
    """Parse named quantities of known dimensions to SI; raise ValueError with the mend on a misfit."""
    found: dict[str, Estimate] = {}
    for name, value in given.items():
        if name not in dimensions:
            raise ValueError(f"{where or 'here'}: '{name}' is not a parameter\nKnown are {', '.join(dimensions)}.")
        try:
            found[name] = Quantity.model_validate(value).si(dimensions[name], motion)
        except FricError as error:
            place = f"{where}.{name}" if where else name
            raise ValueError(f"{place}: {error.what}\n{error.mend}") from None
    return found

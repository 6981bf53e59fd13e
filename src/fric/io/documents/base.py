"""What every YAML document shares: quantities with units, provenance, and the line that says its type."""

from __future__ import annotations

from typing import Any, ClassVar

from pydantic import BaseModel, ConfigDict, Field, model_validator

from fric.errors import FricError
from fric.estimate import Estimate
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
                raise ValueError(f"'{given}' is not a quantity\nWrite a number and a unit, as in '105 N'.") from None
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


def quantities(given: dict[str, Any], dimensions: dict[str, str], motion: Motion, where: str) -> dict[str, Estimate]:
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

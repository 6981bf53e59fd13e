"""Quantities of documents: a number with its unit, as files hold it, and parts whose fields are such."""

from collections.abc import Callable, Container, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from itertools import chain
from math import inf, isfinite
from operator import attrgetter
from typing import Annotated, Any, ClassVar, Self, TypeVar

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, model_validator

from fric.errors import FricError
from fric.estimate import Covariance, Estimate, Scale
from fric.units import Motion, factor, si_unit

MOST = 1e20  # Largest number of a quantity: a stiffness of 1e9 N/m whose interval is open reaches 1e15

Known = Annotated[
    float | None, BeforeValidator(lambda given: None if isinstance(given, float) and not isfinite(given) else given)
]
"""A number, or null for an infinite value or NaN, which JSON cannot hold."""


@contextmanager
def refused(place: str = "") -> Iterator[None]:
    """Turn a `FricError` within the block into an error of the schema, with place and remedy."""
    try:
        yield
    except FricError as error:
        raise ValueError(f"{place}{': ' if place else ''}{error.what}\n{error.hint}") from None


class Part(BaseModel):
    """A part of a document: an unknown key is an error, never ignored."""

    model_config = ConfigDict(extra="forbid", frozen=True, defer_build=True, allow_inf_nan=False)


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


def read_off(kind: type[BaseModel], holder: Any, but: Container[str] = ()) -> dict[str, Any]:
    """Return the values of a schema from an object, by key: as `of` states, or of the attribute of the key's name."""
    found = {}
    for name, field in kind.model_fields.items():
        if name in but:
            continue
        how = next((one for one in field.metadata if isinstance(one, Of)), None) or Of(attrgetter(name))
        try:
            value = how.read(holder)
        except AttributeError:
            if field.is_required():
                raise
            continue
        if value is not None or field.is_required():
            found[field.alias or name] = Estimate(value, how.unit) if how.unit and value is not None else value
    return found


class Written(Part):
    """A part that fric writes and does not read: made of an object, by `read_off`."""

    @model_validator(mode="before")
    @classmethod
    def _read_off(cls, given: Any) -> Any:
        held = isinstance(given, Mapping | BaseModel | list | str | float | int | None)  # as files hold it
        return given if held else read_off(cls, given)


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
            return {"value": given, "unit": "1"}
        return given

    def si(self, dimension: str, motion: Motion) -> Estimate:
        """Return the quantity as an `Estimate` in SI; a unit of the wrong kind raises a `FricError`."""
        scale = factor(self.unit, dimension, motion)

        def limits(pair: Any) -> tuple[float, float]:
            low, high = pair
            return -inf if low is None else low * scale, inf if high is None else high * scale

        value: Any = (
            tuple(value * scale for value in self.value) if isinstance(self.value, list) else self.value * scale
        )
        ci95: Any = self.ci95 and (tuple(map(limits, self.ci95)) if isinstance(value, tuple) else limits(self.ci95))
        return Estimate(value, si_unit(dimension, motion), ci95, self.fixed, self.assumed, self.source)

    @model_validator(mode="after")
    def _interval_fits(self) -> Self:
        values = self.value if isinstance(self.value, list) else [self.value]
        pairs: Any = (self.ci95 if isinstance(self.value, list) else [self.ci95]) if self.ci95 is not None else []
        if self.ci95 is not None and [isinstance(pair, list) and len(pair) for pair in pairs] != [2] * len(values):
            raise ValueError("ci95 does not fit the value\nGive [low, high], one such pair per value.")
        for number in (*values, *chain(*pairs)):
            if number is not None and abs(number) > MOST:
                raise ValueError(f"{number:g} {self.unit} is beyond all drives\nGive null for an open limit.")
        return self


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
    """Return the items that are not None."""
    return {name: value for name, value in values.items() if value is not None}


def in_units(values: Mapping[str, Any], dimensions: Mapping[str, str], motion: Motion) -> dict[str, Estimate]:
    """Return numbers in SI with their units, by name."""
    return {
        name: Estimate(values[name], si_unit(dimension, motion))
        for name, dimension in dimensions.items()
        if name in values
    }


def quantities(given: Mapping[str, Any], dimensions: dict[str, str], motion: Motion, where: str) -> dict[str, Estimate]:
    """Parse named quantities of known dimensions to SI; raise ValueError with a remedy on a misfit."""
    found: dict[str, Estimate] = {}
    for name, value in given.items():
        if name not in dimensions:
            raise ValueError(f"{where or 'here'}: '{name}' is not a parameter\nKnown are {', '.join(dimensions)}.")
        with refused(f"{where}.{name}" if where else name):
            quantity = value if isinstance(value, Quantity) else Quantity.model_validate(value)
            found[name] = quantity.si(dimensions[name], motion)
    return found


Given = TypeVar("Given", Estimate, Quantity)


def single(found: dict[str, Given]) -> dict[str, Given]:
    """Return quantities of one number each; raise ValueError with a remedy if one is a list."""
    for name, quantity in found.items():
        if isinstance(quantity.value, tuple | list):
            count = len(quantity.value)
            raise ValueError(f"{name}: {count} values where one is expected\nGive one number with its unit.")
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
        """Return the given quantities in SI; raise ValueError with a remedy on a wrong unit."""
        given = {name: getattr(self, name) for name in self.dimensions}
        return quantities(known(**given), self.dimensions, motion, where)

    def values(self, motion: Motion) -> dict[str, float]:
        """Return the quantities that are given, as numbers in SI."""
        return {name: float(estimate) for name, estimate in self.estimates(motion).items()}

"""What came of a fleet, ``fric: fleet/1``: which axes of which machines changed between dates."""

from typing import ClassVar

from pydantic import Field

from fric.documents.base import Document
from fric.documents.quantity import Known, Part


class FleetUnit(Part):
    """The logs of one machine at one date."""

    machine: str
    date: str
    axes: dict[str, dict[str, list[str]]] = Field(description="by axis, which steps were done and what is missing")
    notes: list[str] = Field(description="what was guessed, left out, or could not be read")


class FleetChange(Part):
    """A number whose interval at one date does not agree with that at the next."""

    machine: str
    axis: str
    parameter: str
    unit: str
    dates: list[str]
    before: float
    after: float
    relative: float | None
    ci95: list[Known] = Field(description="95 % interval of the difference, of this number alone")
    p: float = Field(description="probability of such a difference where nothing changed")
    adjusted: float = Field(description="the same with all numbers of the fleet in mind (Holm)")
    changed: bool


class FleetDocument(Document):
    """A fleet: what was done, and what changed."""

    type: ClassVar[str] = "fleet"

    page: str | None = None
    level: float = Field(description="probability that an axis is said to have changed where none did")
    tests: int = Field(description="numbers that were compared")
    units: list[FleetUnit]
    changed: list[list[str]] = Field(description="machine and axis of each that changed")
    changes: list[FleetChange] = Field(description="beyond its own interval, the surest first")

"""What stands beside exported files, ``manifest.json``: ``fric: export/1``."""

from typing import Any, ClassVar, Literal

from pydantic import Field

from fric.documents.base import AxisName, CodedWarning, Document
from fric.documents.quantity import Part
from fric.units import Motion


class ExportedNumber(Part):
    """A number with its unit."""

    value: float | None = Field(description="null where there is no limit")
    unit: str


class ExportedBlock(Part):
    """A control block that was exported."""

    name: str
    kind: Literal["controller", "feedforward", "observer"]
    parameters: list[float] = Field(description="as its compiled step reads them")


class TrustPart(Part):
    """Whether the verdict on the scheme trusts it."""

    trusted: bool
    why: list[CodedWarning] = Field(description="why not")


class TrialPart(Part):
    """A circle in LinuxCNC beside its simulation."""

    scheme: str
    velocity: float = Field(description="feed [m/s]")
    direction: Literal[1, -1] = Field(description="1 counter-clockwise")
    glitch: float = Field(description="[m]")
    quadrants: list[float] = Field(description="at +x, +y, -x, -y, outwards positive [m]")
    simulated: list[float] = Field(description="the same, simulated [m]")
    difference: float = Field(description="largest of a quadrant [m]")


class ExportDocument(Document):
    """What was exported, from what, and what is doubtful of it."""

    type: ClassVar[str] = "export"

    exported_by: str = Field(alias="version", description="version of fric")
    target: str
    part: Literal["compensation", "machine"]
    machine: str
    axis: AxisName
    motion: Motion
    scheme: str
    parameters: dict[str, ExportedNumber]
    friction: dict[str, Any] = Field(description="name of the model, and its parameters by section")
    blocks: list[ExportedBlock]
    files: dict[str, str] = Field(description="SHA-256 of each file")
    sources: list[dict[str, str]] = Field(description="files it was made from, each with its SHA-256")
    verdict: TrustPart | None = None
    trial: list[TrialPart] | None = None

"""What measured circles tell, as `--json` prints it: ``fric: diagnosis/1`` and ``fric: tuning/1``."""

from typing import ClassVar

from pydantic import Field

from fric.documents.base import Document, Part, Quantity


class GlitchPart(Part):
    """A friction glitch at a quadrant."""

    value: float
    unit: str
    ci95: list[float | None]
    width: float
    place: float


class PredictedGlitch(GlitchPart):
    """What a machine file predicts for a quadrant."""

    ci95: list[float | None] | None  # type: ignore[assignment]  # without what was identified there is none
    agrees: bool
    cause: str | None


class PitchPart(Part):
    """What comes again along an axis."""

    axis: str
    pitch: Quantity
    amplitude: Quantity


class DiagnosisDocument(Document):
    """A measured circle, taken apart."""

    type: ClassVar[str] = "diagnosis"

    radius: Quantity
    feed: Quantity
    direction: Quantity = Field(description="1 counter-clockwise, -1 clockwise")
    revolutions: list[int]
    centre: dict[str, Quantity]
    scale: dict[str, Quantity]
    squareness: Quantity
    backlash: dict[str, Quantity]
    mismatch: Quantity
    lag: dict[str, Quantity | None]
    glitch: dict[str, GlitchPart]
    glitch_of: dict[str, dict[str, GlitchPart]]
    pitch: list[PitchPart]
    rest: Quantity | None
    scatter: Quantity | None
    noise: Quantity | None
    iso230: dict[str, Quantity | dict[str, Quantity] | None]
    predicted: dict[str, PredictedGlitch] | None = None
    scheme: str | None = None
    agrees: bool | None = None


class ResidualPart(Part):
    """What is left of the voltage of an axis [V]."""

    before: float
    after: float
    noise: float | None


class TunedAxisPart(Part):
    """What circles gave an axis."""

    parameters: dict[str, Quantity]
    residual: ResidualPart
    full_shape: bool
    improves: bool


class NextCircle(Part):
    """What the next circle should show."""

    glitch: float = Field(description="[m]")
    ci95: list[float | None]
    radius: float = Field(description="[m]")


class TuningDocument(Document):
    """What controllers believe, refitted to recorded circles."""

    type: ClassVar[str] = "tuning"

    axes: dict[str, TunedAxisPart]
    predicted: dict[str, dict[str, NextCircle]] = Field(description="by feed [m/s] and scheme")
    measured: dict[str, float] = Field(description="recorded glitch [m] by feed")
    files: list[str] | None = None

"""What schemes leave of a contour, as `--json` prints it: ``fric: circle-result/1`` and ``fric: path-result/1``."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, ClassVar, Literal

from pydantic import Field

from fric.documents.base import CodedWarning, Document
from fric.documents.generated import PartOf, again
from fric.documents.quantity import Known, Part
from fric.simulate.prediction import Predicted, Prediction
from fric.simulate.spread import Distribution


class ChancePart(Part):
    """Between what 95 % of further runs lie, where counts of the encoder decide on what a run leaves."""

    places: int = Field(description="places between two counts at which it was run; every figure is their median")
    glitch: list[float] = Field(description="[m]")
    reversals: list[list[float]] = Field(description="of the signed glitch at each reversal [m]")


class CircleScheme(Part):
    """What one scheme leaves of a circle."""

    title: str
    glitch: float = Field(description="largest of the quadrants, without its sign [m]")
    quadrants: list[float] = Field(description="at +x, +y, -x, -y, outwards positive [m]")
    radial_rms: float = Field(description="[m]")
    radial_range: float = Field(description="largest less smallest radial error [m]")
    chance: ChancePart | None = Field(None, description="null where one run tells it")
    warnings: list[str] = Field(default_factory=list)


class SchemeSpread(Part):
    """How the glitch of one scheme is distributed over machines; null where it ran on none."""

    median: float | None = Field(description="[m]")
    p05: float | None
    p95: float | None
    ci95: list[float | None]
    best: float = Field(description="share of the machines on which no other scheme leaves less")
    failed: int = Field(description="machines on which it could not run")
    saturated: int


class SpreadFactor(Part):
    """What was spread, and how widely."""

    distribution: Distribution
    factor: list[float]


class MonteCarloPart(Part):
    """The test on many machines."""

    machines: int
    asked: int
    seed: int
    accuracy: float = Field(description="by how much the integration may move a glitch [m]")
    from_intervals: dict[str, list[str]] = Field(description="by axis, what was drawn from what was identified")
    spreads: dict[str, SpreadFactor]
    schemes: dict[str, SchemeSpread]
    warnings: list[str]


class VerdictPart(Part):
    """What to switch on, how far that may be trusted, and what to type next; lengths in m."""

    scheme: str | None = Field(description="null where none is recommended")
    glitch: float | None = Field(description="median over the machines that were drawn")
    ci95: list[float] | None
    stays_under: float | None = Field(description="what 95 % of the machines that were drawn stay under")
    trusted: bool
    passes: bool | None = Field(description="whether the tolerance is kept; null where none was asked, or not decided")
    result: Literal["", "pass", "fail", "not decided"] = Field(description="empty where no tolerance was asked")
    headline: str
    why: list[str] = Field(description="why it is not to be trusted yet")
    settled: list[str] = Field(description="what the files warn of, and the measured circle settles")
    effort: list[str]
    next: list[str] = Field(description="what to type next")


class PredictedScheme(PartOf[Predicted]):
    """What one scheme should leave, on machines drawn from all that is open about the one that was identified."""

    glitch: Known = Field(description="median [m]")
    under: Known = Field(description="what 95 % of the machines stay under [m]")
    trusted: bool
    why: list[CodedWarning] = Field(description="why it must not be trusted")


class PredictionPart(PartOf[Prediction]):
    """What schemes should leave of the circle, and whether that may be trusted."""

    schemes: dict[str, PredictedScheme]


def prediction_tree(found: Prediction) -> dict[str, Any]:
    """Return a prediction as plain values."""
    return PredictionPart.model_validate(found, from_attributes=True).model_dump(exclude_unset=True)


def prediction_of(tree: Mapping[str, Any]) -> Prediction:
    """Return the prediction of such values."""
    found: Prediction = again(Prediction, tree)
    schemes = {
        name: replace(one, distrust=tuple(why for why in one.why if why not in found.distrust))
        for name, one in found.schemes.items()
    }
    return replace(found, schemes=schemes)


class CircleResultDocument(Document):
    """What schemes leave of a circle."""

    type: ClassVar[str] = "circle-result"

    velocity: float = Field(description="feed [m/s]")
    radius: float = Field(description="[m]")
    direction: Literal[1, -1] = Field(description="1 counter-clockwise")
    schemes: dict[str, CircleScheme]
    monte_carlo: MonteCarloPart | None = None
    verdict: VerdictPart | None = Field(None, description="what to switch on, by this circle alone")
    prediction: PredictionPart | None = None


class PathReversal(Part):
    """The glitch at one reversal of an axis."""

    axis: str
    x: float
    y: float
    glitch: float = Field(description="[m]")


class PathScheme(Part):
    """What one scheme leaves of a path."""

    title: str
    glitch: float = Field(description="largest at a reversal, without its sign [m]")
    reversals: list[PathReversal]
    contour_rms: float
    contour_range: float
    chance: ChancePart | None = Field(None, description="null where one run tells it")
    warnings: list[str] = Field(default_factory=list)


class PathResultDocument(Document):
    """What schemes leave of a path."""

    type: ClassVar[str] = "path-result"

    velocity: float = Field(description="feed [m/s]")
    schemes: dict[str, PathScheme]

"""What was learned of a circle, as `--json` prints it: ``fric: learning/1`` and ``fric: learned-feedforward/1``."""

from typing import ClassVar, Literal

from pydantic import Field

from fric.documents.base import Document
from fric.documents.quantity import Part


class LearnedCircle(Document):
    """The circle that was learned."""

    radius: float = Field(description="[m]")
    feed: float = Field(description="[m/s]")
    direction: Literal[1, -1] = Field(description="1 counter-clockwise")
    share: float = Field(description="of a round that is taken over")
    bandwidth: float = Field(description="up to what frequency [Hz]")


class RoundPart(Part):
    """One round."""

    glitch: float = Field(description="median over places between two counts [m]")
    ci95: list[float] = Field(description="between what 95 % of runs lie [m]")
    quadrants: list[float] = Field(description="at +x, +y, -x, -y, outwards positive, medians [m]")


class CarriedPart(Part):
    """What is left of another circle with what was learned of this one."""

    radius: float = Field(description="[m]")
    feed: float = Field(description="[m/s]")
    glitch: float = Field(description="[m]")


class LearningDocument(LearnedCircle):
    """Rounds of learning in simulation."""

    type: ClassVar[str] = "learning"

    rounds: list[RoundPart]
    carried_over: list[CarriedPart]


class LearnedAxis(Part):
    """What is fed forward on one axis."""

    largest: float = Field(description="[V]")
    samples: int


class LearnedFeedforwardDocument(LearnedCircle):
    """What is fed forward in the next round of a measured circle."""

    type: ClassVar[str] = "learned-feedforward"

    axes: dict[str, LearnedAxis]

"""What a reproduction of the paper left, as `--json` prints it: ``fric: reproduction/1``."""

from typing import ClassVar, Literal

from pydantic import Field

from fric.documents.base import Document
from fric.documents.contours import CircleScheme
from fric.documents.quantity import Part


class ReproducedFeed(Part):
    """What schemes leave of the circle at one feed."""

    velocity: float = Field(description="feed [m/s]")
    radius: float = Field(description="[m]")
    direction: Literal[1, -1]
    schemes: dict[str, CircleScheme]


class ReproductionDocument(Document):
    """The page, and what each scheme leaves."""

    type: ClassVar[str] = "reproduction"

    page: str
    steps: int
    made_now: int = Field(alias="made", description="steps that were not up to date")
    feeds: dict[str, ReproducedFeed] = Field(description="by feed [m/s]")

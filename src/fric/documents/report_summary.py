"""The few words of a report that `--json` prints: ``fric: report/1``."""

from typing import Any, ClassVar, Literal

from pydantic import ConfigDict, Field

from fric.documents.base import Document
from fric.documents.quantity import Part


class AdvicePart(Part):
    """What a contour test advises."""

    model_config = ConfigDict(extra="allow", frozen=True)

    velocity: float = Field(description="feed [m/s]")
    radius: float | None = Field(description="[m]; null of a path")
    reasons: list[str]


class ChangePart(Part):
    """One number at two dates, in SI."""

    name: str
    unit: str
    before: float
    after: float
    verdict: Literal["moved", "within", "unknown"]


class DriftPart(Part):
    """What changed between two files that tell of the same."""

    of: str
    told: str
    changes: list[ChangePart]


class ReportDocument(Document):
    """What a report says in a few words."""

    type: ClassVar[str] = "report"

    axes: list[str]
    advice: list[AdvicePart]
    drift: list[DriftPart]
    circles: list[dict[str, Any]] = Field(description="measured circles: file, and diagnosis/1 of each")

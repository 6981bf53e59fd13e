"""What came of a folder of logs, as `--json` prints it: ``fric: auto/1``."""

from typing import ClassVar

from fric.documents.base import Document
from fric.documents.contours import VerdictPart
from fric.documents.quantity import Part


class StepsPart(Part):
    """Which steps were done for an axis, and which record is missing for others."""

    done: list[str]
    missing: list[str]


class AutoDocument(Document):
    """The report, what was done by axis, and the verdict."""

    type: ClassVar[str] = "auto"

    report: str | None
    axes: dict[str, StepsPart]
    verdict: VerdictPart

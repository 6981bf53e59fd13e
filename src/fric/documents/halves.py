"""Halves of records beside each other, as `--json` prints them: ``fric: halves/1``."""

from typing import ClassVar

from fric.documents.base import Document
from fric.documents.generated import PartOf
from fric.identify.halves import Halved


class HalvedPart(PartOf[Halved]):
    """A parameter of two halves of the records."""

    half_widths: float


class HalvesDocument(Document):
    """How far halves of the records are apart, each identified alone."""

    type: ClassVar[str] = "halves"

    axis: str
    within: float
    found: list[HalvedPart]
    untold: dict[str, str]

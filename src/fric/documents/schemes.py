"""The schemes file: ``fric: schemes/1``."""

from __future__ import annotations

from pathlib import Path
from typing import ClassVar

from pydantic import Field

from fric.compensation.base import Compensation
from fric.documents.base import Document, Part
from fric.documents.yaml import read_document


class SchemePart(Part):
    """A compensation scheme: the friction that is fed forward, and whether the observer is on."""

    title: str = ""
    friction: str | None = Field(None, description="friction model to feed forward: static, gms, …; none if left out")
    observer: bool = Field(False, description="true where the axis' disturbance observer is on")
    gain: float | None = Field(None, description="gain of the feedforward; the machine's where left out")


class SchemesDocument(Document):
    """A schemes file: compensation schemes by name."""

    type: ClassVar[str] = "schemes"

    schemes: dict[str, SchemePart]

    def compensations(self) -> dict[str, Compensation]:
        """Return the schemes by name."""
        return {
            name: Compensation(name, part.title, part.friction, part.observer, part.gain)
            for name, part in self.schemes.items()
        }


def read_schemes(path: Path) -> dict[str, Compensation]:
    """Read compensation schemes by name from a schemes file."""
    return read_document(path, SchemesDocument).compensations()

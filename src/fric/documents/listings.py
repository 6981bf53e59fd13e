"""What there is, as `--json` prints it: ``fric: formats/1`` and ``fric: example/1``."""

from typing import ClassVar

from pydantic import Field

from fric.documents.base import Document
from fric.documents.quantity import Part


class FormatPart(Part):
    """One format of logs."""

    name: str
    endings: list[str]
    library: str | None
    version: str | None = Field(description="null where it lacks, or none is needed")
    installed: bool
    extra: str | None = Field(description="which installs the library")


class FormatsDocument(Document):
    """The formats of logs that are read."""

    type: ClassVar[str] = "formats"

    formats: list[FormatPart]


class ExampleDocument(Document):
    """An example that was copied."""

    type: ClassVar[str] = "example"

    name: str
    folder: str
    files: list[str]

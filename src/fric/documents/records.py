"""Records, and the records that were read in, as `--json` prints them: ``fric: records/1``, ``ingest/1`` and others."""

from typing import Any, Literal

from pydantic import Field, field_validator

from fric.columns import Kind
from fric.documents.base import Document
from fric.documents.quantity import Part
from fric.units import Motion


class RecordPart(Part):
    """Description of a record."""

    kind: Kind | None
    samples: int


class RecordsDocument(Document, type="records"):
    """Records of one axis."""

    axis: str
    records: dict[str, RecordPart]


class IngestedPart(Part):
    """A record that was added."""

    name: str
    source: str
    sha256: str
    kind: Kind | None
    samples: int
    dropped: int
    channels: dict[str, str] = Field(description="each channel, and the column it was read from")
    left_out: list[str]


class IngestDocument(Document, type="ingest"):
    """The records read into a log file."""

    output: str
    axis: str
    motion: Motion
    records: list[IngestedPart]
    skipped: list[list[str]] = Field(description="files already read, with the names of their records")
    samples: int
    dropped: int


class IngestedCircle(Part):
    """A circle test that was added."""

    name: str
    radius: float = Field(description="[m]")
    feed: float = Field(description="[m/s]")
    direction: Literal[1, -1] = Field(description="1 counter-clockwise")
    axes: dict[str, list[str]] = Field(description="channels of each axis")
    instrument: str
    source: str
    sha256: str

    @field_validator("axes", mode="before")
    @classmethod
    def _of_traces(cls, given: Any) -> Any:
        return {name: list(item.channels()) if hasattr(item, "channels") else item for name, item in given.items()}


class IngestCirclesDocument(Document, type="ingest-circles"):
    """The tests read into a circle test file."""

    output: str
    tests: list[IngestedCircle]
    samples: int

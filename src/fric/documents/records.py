"""What records hold, and what was read in, as `--json` prints it: ``fric: inspection/1``, ``ingest/1`` and others."""

from typing import Any, ClassVar, Literal

from pydantic import AliasChoices, Field, field_validator

from fric.columns import Kind
from fric.documents.base import CodedWarning, Document
from fric.documents.quantity import Part, Quantity
from fric.units import Motion


class UsePart(Part):
    """Whether a record is good for an identification, and why."""

    purpose: str
    good: bool
    why: str


class InspectedPart(Part):
    """What every record tells."""

    name: str
    source: str
    axis: str
    motion: Motion
    kind: Kind
    stated: bool = Field(description="whether the record says so, else it is recognised")
    uses: list[UsePart]
    warnings: list[str] = Field(default_factory=list)
    warnings_coded: list[CodedWarning] = Field(
        default_factory=list, validation_alias=AliasChoices("warnings_coded", "warnings")
    )


class ChannelPart(Part):
    """What a channel holds, in its SI unit."""

    unit: str
    low: float | None
    high: float | None
    step: float | None = Field(description="of the lattice that its values lie on")
    not_a_number: int
    clipped: int


class GapPart(Part):
    """Missing samples."""

    time: float = Field(description="before them [s]")
    intervals: float = Field(description="sampling intervals that the gap is long")


class SegmentPart(Part):
    """A segment at constant velocity."""

    start: int
    stop: int
    velocity: float
    velocity_se: float
    settled: bool


class SinePart(Part):
    """The sine that a motion follows."""

    amplitude: float
    frequency: float
    mean_velocity: float
    cycles: float
    explained: float


class InspectedLog(InspectedPart):
    """What a record in time holds."""

    samples: int
    duration: float = Field(description="[s]")
    sampling: float | None = Field(description="[Hz]")
    jitter: float = Field(description="standard deviation of the sampling intervals [s]")
    channels: dict[str, ChannelPart]
    gaps: list[GapPart]
    stretches: list[SegmentPart] = Field(validation_alias=AliasChoices("stretches", "segments"))
    speeds: list[float]
    sine: SinePart | None
    reversals: list[int]
    rise: float | None
    excites: bool
    slope: float | None
    energy: Quantity | None = Field(description="lost per cycle")
    dropped: int
    encoder_step: float | None


class InspectedResponse(InspectedPart):
    """What a measured frequency response holds."""

    points: int
    low: float = Field(description="[Hz]")
    high: float = Field(description="[Hz]")
    coherence: float | None


class InspectedTable(InspectedPart):
    """What a table of mean forces at velocities holds."""

    points: int
    directions: Literal[0, 1, 2]
    slowest: float
    fastest: float
    weakest: float
    strongest: float
    columns: list[str]


class InspectionDocument(Document):
    """What records hold, and what they are good for."""

    type: ClassVar[str] = "inspection"

    records: list[InspectedLog | InspectedResponse | InspectedTable]


class RecordPart(Part):
    """What one record is."""

    kind: Kind | None
    samples: int


class RecordsDocument(Document):
    """Records of one axis."""

    type: ClassVar[str] = "records"

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


class IngestDocument(Document):
    """What was read into a log file."""

    type: ClassVar[str] = "ingest"

    output: str
    axis: str
    motion: Motion
    records: list[IngestedPart]
    skipped: list[list[str]] = Field(description="what was there already, with the name of the record that it is")
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
        return {name: list(one.channels()) if hasattr(one, "channels") else one for name, one in given.items()}


class IngestCirclesDocument(Document):
    """What was read into a circle test file."""

    type: ClassVar[str] = "ingest-circles"

    output: str
    tests: list[IngestedCircle]
    samples: int

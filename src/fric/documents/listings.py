"""Listings and outputs, as `--json` prints them: records, formats, an example, an export, a report, a fleet."""

from math import inf
from operator import itemgetter
from typing import Any, Literal

from pydantic import Field, field_validator

from fric.columns import Kind
from fric.documents.base import CodedWarning, Document, Part, Written
from fric.documents.fields import AxisName, Known, of
from fric.units import Motion


class FormatPart(Written):
    """One format of logs."""

    name: str = of(itemgetter(0))
    endings: list[str] = of(itemgetter(1))
    library: str | None = of(lambda row: row[2] or None)
    version: str | None = of(lambda row: row[3] or None, "null if missing, or if none is needed")
    installed: bool = of(lambda row: row[3] is not None)
    extra: str | None = of(lambda row: row[4] or None, "the extra that installs the library")


class FormatsDocument(Document, type="formats"):
    """The formats of logs that are read."""

    formats: list[FormatPart] = of("rows")


class BlockKindPart(Written):
    """A kind of control block."""

    name: str
    kind: Literal["controller", "feedforward", "observer"]
    linear: bool
    asks: str = Field(description="what it asks of a controller, in a few words")


class BlocksDocument(Document, type="blocks"):
    """The control blocks that there are."""

    blocks: list[BlockKindPart]


class ProposalDocument(Document, type="proposal"):
    """A mapping that logs may have."""

    output: str = Field(description="file that it was written to; - for none")
    mapping: str = Field(description="text of the mapping")


class ExampleDocument(Document, type="example"):
    """An example that was copied."""

    name: str
    folder: str = of(lambda made: str(made.folder))
    files: list[str]


class ExportedNumber(Part):
    """A number with its unit."""

    value: float | None = Field(description="null where there is no limit")
    unit: str


class ExportedBlock(Part):
    """A control block that was exported."""

    name: str
    kind: Literal["controller", "feedforward", "observer"]
    parameters: list[float] = Field(description="as its compiled step reads them")


class TrustPart(Part):
    """Whether the verdict trusts the scheme."""

    trusted: bool
    why: list[CodedWarning] = Field(description="why not")


class TrialPart(Written):
    """A circle in LinuxCNC and its simulation."""

    scheme: str = of("scheme.name")
    velocity: float = of("feed", "feed [m/s]")
    direction: Literal[1, -1] = Field(description="1 counter-clockwise")
    glitch: float = of("measured.glitch", "[m]")
    quadrants: list[float] = of("measured.quadrants", "at +x, +y, -x, -y, outwards positive [m]")
    simulated: list[float] = of("simulated.quadrants", "the same, simulated [m]")
    difference: float = Field(description="largest of a quadrant [m]")


class ExportDocument(Document, type="export"):
    """An export, its sources, and doubts about it."""

    exported_by: str = Field(alias="version", description="version of fric")
    target: str
    part: Literal["compensation", "machine"]
    machine: str
    axis: AxisName
    motion: Motion
    scheme: str
    parameters: dict[str, ExportedNumber]
    friction: dict[str, Any] = Field(description="name of the model, and its parameters by section")
    blocks: list[ExportedBlock]
    files: dict[str, str] = Field(description="SHA-256 of each file")
    sources: list[dict[str, str]] = Field(description="source files, each with its SHA-256")
    verdict: TrustPart | None = None
    trial: list[TrialPart] | None = None


class AdvicePart(Part, extra="allow"):
    """Advice from a contour test."""

    velocity: float = Field(description="feed [m/s]")
    radius: float | None = Field(description="[m]; null of a path")
    reasons: list[str]


class ChangePart(Part):
    """A number at two dates, in SI."""

    name: str
    unit: str
    before: float
    after: float
    verdict: Literal["moved", "within", "unknown"]


class DriftPart(Part):
    """Changes between two files on the same subject."""

    of: str
    told: str
    changes: list[ChangePart]


class ReportDocument(Document, type="report"):
    """Summary of a report."""

    axes: list[str]
    advice: list[AdvicePart]
    drift: list[DriftPart]
    circles: list[dict[str, Any]] = Field(description="measured circles: file, and diagnosis/1 of each")


class StepsPart(Part):
    """The steps done for an axis, and the records missing for others."""

    done: list[str]
    missing: list[str]


class FleetUnit(Written):
    """The logs of one machine at one date."""

    machine: str = of("unit.machine")
    date: str = of("unit.date")
    axes: dict[str, StepsPart] = Field(description="steps done and records missing, by axis")
    notes: list[str] = of("description", "what was guessed, left out, or could not be read")


class FleetChange(Written):
    """A number whose interval at one date does not agree with that at the next."""

    machine: str
    axis: str
    parameter: str = of("change.name")
    unit: str = of("change.unit")
    dates: list[str]
    before: float = of("change.before")
    after: float = of("change.after")
    relative: float | None = of("change.relative")
    ci95: list[Known] = of(
        lambda item: item.change.difference_ci95 or (inf, inf), "95 % interval of the difference, of this number alone"
    )
    p: float = Field(description="probability of such a difference where nothing changed")
    adjusted: float = Field(description="the same, adjusted for all numbers of the fleet (Holm)")
    changed: bool


class FleetDocument(Document, type="fleet"):
    """A fleet: steps done, and changes."""

    page: str | None
    level: float = Field(description="probability that an axis is said to have changed where none did")
    tests: int = Field(description="numbers that were compared")
    units: list[FleetUnit]
    changed: list[list[str]] = Field(description="machine and axis of each that changed")
    changes: list[FleetChange] = Field(description="beyond its own interval, the surest first")


class RecordPart(Written):
    """Description of a record."""

    kind: Kind | None
    samples: int = of(len)


class RecordsDocument(Document, type="records"):
    """Records of one axis."""

    axis: str
    records: dict[str, RecordPart] = of(lambda found: {log.name: log for log in found.records})


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

"""The content of records as `--json` prints it, ``fric: inspection/1``: apart, since reading a log inspects none."""

from fric.documents.base import Document, PartOf
from fric.documents.fields import of
from fric.records.inspection import Inspection, ResponseInspection, TableInspection


class InspectedLog(PartOf[Inspection]):
    """Content of a record in time."""

    encoder_step: float | None


class InspectedResponse(PartOf[ResponseInspection]):
    """Content of a measured frequency response."""


class InspectedTable(PartOf[TableInspection]):
    """Content of a table of mean forces at velocities."""


class InspectionDocument(Document, type="inspection"):
    """The content of records, and their uses."""

    records: list[InspectedLog | InspectedResponse | InspectedTable] = of("found")
